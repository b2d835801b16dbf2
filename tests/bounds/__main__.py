"""No stated bound below the error, on random lifts: `python -m tests.bounds [LIFTS] [SEED]
[MINUTES]` from the root.
"""

import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tests.bounds.bound_study import study, table

if __name__ == "__main__":
    numbers = [float(word) for word in sys.argv[1:]] + [10_000, 0, 8][len(sys.argv) - 1 :]
    begun = time.process_time()
    found = study(
        int(numbers[0]), int(numbers[1]), lambda: time.process_time() - begun > 60 * numbers[2]
    )
    print(table(found))
    print(f"{time.process_time() - begun:.0f} s of a core")
    sys.exit(1 if found.broken else 0)
