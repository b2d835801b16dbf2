"""Run the benchmarks: `python -m tests.benchmarks` from the repository's root, with nothing else
running.
"""

import os

# As the command line does, and before numpy is imported.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tests.benchmarks import circle_maps, engine

for one in (engine, circle_maps):
    one.main()
