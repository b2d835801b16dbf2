"""No stated bound below the error, on random lifts: `python -m tests.bounds [LIFTS] [SEED]
[MINUTES]` from the root, and on random families: `python -m tests.bounds families [FAMILIES] [SEED]
[MINUTES]`.
"""

import os
import sys
import time

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

from tests.bounds.bound_study import study, table
from tests.bounds.family_study import study_families

if __name__ == "__main__":
    words = sys.argv[1:]
    run, usual = study, [10_000, 0, 8]
    if words[:1] == ["families"]:
        words = words[1:]
        run, usual = study_families, [1_000, 0, 60]
    numbers = [float(word) for word in words] + usual[len(words) :]
    begun = time.process_time()
    found = run(
        int(numbers[0]), int(numbers[1]), lambda: time.process_time() - begun > 60 * numbers[2]
    )
    print(table(found))
    print(f"{time.process_time() - begun:.0f} s of a core")
    sys.exit(1 if found.broken else 0)
