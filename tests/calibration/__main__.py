"""Calibration of every p-value under its null: `python -m tests.calibration [RUNS] [STUDY ...]` from the root."""

import os
import sys
import time

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tests.calibration.p_value_studies import STUDIES
from tests.calibration.rejection_table import HEADER, row

DEFAULT_RUNS = 400

arguments = sys.argv[1:]
count = int(arguments.pop(0)) if arguments and arguments[0].isdigit() else DEFAULT_RUNS
unknown = set(arguments) - set(STUDIES)
if unknown:
    sys.exit(f"unknown study {', '.join(sorted(unknown))}; known: {', '.join(STUDIES)}")
print(HEADER, flush=True)
for name in arguments or STUDIES:
    study, runs = STUDIES[name]
    begun = time.perf_counter()
    for test, values in study(count, runs, 1000).items():
        print(row(test, values), flush=True)
    print(f"  {name}: {time.perf_counter() - begun:.0f} s", flush=True)
