"""One thread for the linear algebra of NumPy, for as long as a computation lasts.

The matrices here are so small that several threads lose more in waiting for each other than they
gain: two to four times the processor's time, and on busy cores a multiple of the time.
"""

from __future__ import annotations

import ctypes
import os
import threading
from contextlib import ContextDecorator
from functools import cache
from typing import Any

from numpy.linalg import _umath_linalg

VARIABLE = "OPENBLAS_NUM_THREADS"
# Of NumPy's own wheels, of other builds with long whole numbers, and of all others.
_NAMES = (
    "scipy_openblas_{}_num_threads64_",
    "openblas_{}_num_threads64_",
    "openblas_{}_num_threads",
)


class OneThread(ContextDecorator):
    """A block or function in which NumPy's OpenBLAS takes one thread; the last to leave gives them
    back.

    Blocks may lie in each other, and in threads at once. Where the environment variable
    ``OPENBLAS_NUM_THREADS`` is set, that holds; another BLAS is left alone.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._inside = 0
        self._before: int | None = None

    def __enter__(self) -> None:
        with self._lock:
            self._inside += 1
            if self._inside == 1:
                self._before = None if VARIABLE in os.environ else blas_threads()
                if self._before is not None:
                    _openblas("set")(1)

    def __exit__(self, *error: object) -> None:
        with self._lock:
            self._inside -= 1
            if self._inside == 0 and self._before is not None:
                _openblas("set")(self._before)


one_thread = OneThread()


def blas_threads() -> int | None:
    """How many threads NumPy's OpenBLAS takes now; None where NumPy has another BLAS,
    or hides it."""
    ask = _openblas("get")
    return None if ask is None else int(ask())


@cache
def _openblas(verb: str) -> Any:
    """OpenBLAS's function that gets or sets the number of threads,
    by way of what is linked to it."""
    try:
        linked = ctypes.CDLL(_umath_linalg.__file__)
    except OSError:
        return None
    names = (name.format(verb) for name in _NAMES)
    return next((getattr(linked, name) for name in names if hasattr(linked, name)), None)
