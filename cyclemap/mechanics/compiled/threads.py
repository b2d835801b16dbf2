"""How many threads compiled code may use, and work that they share."""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from functools import lru_cache

from cyclemap.errors import InvalidInput

# Threads that compiled code may use, instead of one a core.
THREADS_VARIABLE = "CYCLEMAP_THREADS"


def thread_count() -> int:
    """Return how many threads compiled code may use: CYCLEMAP_THREADS, else one a core that this process may use.

    Raises InvalidInput where the variable is not a whole number of at least 1.
    """
    named = os.environ.get(THREADS_VARIABLE)
    if not named:
        return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    if not (named.isascii() and named.isdecimal() and int(named) >= 1):
        raise InvalidInput(f"{THREADS_VARIABLE} must be a whole number of at least 1, not {named!r}")
    return int(named)


def on_threads(count: int, work: Callable[[], None], stop: Callable[[], None]) -> None:
    """Run the same work on `count` threads at once, the calling one among them; it shares itself out.

    `stop` is called where one of them fails or is interrupted: nobody takes more of the work then.
    """
    others: list[Future[None]] = []
    try:
        others += [_pool(count).submit(work) for _ in range(count - 1)]
        work()
    except BaseException:
        stop()
        raise
    finally:
        # What was not begun has nothing left to do.
        begun = [other for other in others if not other.cancel()]
        for other in begun:
            other.result()


@lru_cache(maxsize=4)
def _pool(count: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(count, thread_name_prefix="cyclemap")


# Threads do not come along into a fork of the process.
if hasattr(os, "register_at_fork"):
    os.register_at_fork(after_in_child=_pool.cache_clear)
