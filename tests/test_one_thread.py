"""Linear algebra takes one thread while a computation lasts, whenever NumPy was imported."""

import os
import subprocess
import sys

import pytest

# A map that notes how many threads NumPy's OpenBLAS may take whenever it is asked for its values.
CODE = """
import numpy as np
np.ones((300, 300)) @ np.ones((300, 300))
import threading
import cyclemap as cm
from cyclemap.one_thread import blas_threads

seen = []

def lift(theta):
    seen.append(blas_threads())
    return theta + 0.3 * np.sin(theta)

noisy = cm.CircleMap(lift, lambda theta: 1.0 + 0.3 * np.cos(theta)), cm.WrappedNormal(0.3)
before = blas_threads()
seen.clear()
operator = cm.transfer_operator(*noisy)
for ask in (
    lambda: operator.density(0.0),
    lambda: operator.error_bound,
    lambda: operator.spectral_gap,
    lambda: operator.rotation_number,
    lambda: cm.mean_passage_time(*noisy, 3.0, (2.0, 4.0)),
    lambda: cm.predict_staircase(*noisy),
):
    ask()
    after = blas_threads()
    assert after == before, (before, after)
many = [threading.Thread(target=cm.mean_passage_time, args=(*noisy, 3.0, (2.0, 4.0))) for _ in range(4)]
for thread in many:
    thread.start()
for thread in many:
    thread.join()
assert blas_threads() == before
print(before, *sorted(set(seen)))
"""


@pytest.mark.slow
@pytest.mark.parametrize("asked", [None, "2"])
def test_questions_to_a_noisy_map_take_one_thread_unless_the_user_says_how_many(asked) -> None:
    """The user's own linear algebra has its threads before and after, be it asked in threads at
    once.
    """
    surroundings = {
        name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"
    }
    if asked is not None:
        surroundings["OPENBLAS_NUM_THREADS"] = asked
    done = subprocess.run(
        [sys.executable, "-c", CODE], env=surroundings, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    before, *inside = done.stdout.split()
    if before in ("None", "1"):
        pytest.skip("NumPy has another BLAS here, or one thread anyway")
    assert inside == (["1"] if asked is None else [asked])
