"""Lets these tests import the benchmarks, however pytest was started: `tests` is no installed package."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parents[2]))
