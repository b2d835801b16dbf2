"""Where the points of a sweep run: chunks of them, in this process, in processes of its own, or on any executor."""

import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Executor, Future, ProcessPoolExecutor
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

from cyclemap.errors import CycleMapError, DoubtfulInput
from cyclemap.mechanics.engine.strokes import THREADS_VARIABLE
from cyclemap.sweeps.portrait_numbers import PointNumbers, PointOutcome, SweptPoint

# Processes share the cores: each does linear algebra, and runs strokes, in one thread.
_THREADS = ("OPENBLAS_NUM_THREADS", THREADS_VARIABLE)


@dataclass(frozen=True, eq=False)
class FoundChunk:
    """What a worker sends back: points with their outcomes, the worker's code version, and the seconds it took."""

    found: tuple[tuple[SweptPoint, PointOutcome], ...]
    version: str
    seconds: float


def find_chunk(numbers: PointNumbers, points: tuple[SweptPoint, ...]) -> FoundChunk:
    """Find the numbers of some points, one after the other.

    What a point refuses is in its outcome; any other failure is a CycleMapError that names the point.
    """
    begun = time.perf_counter()
    found = tuple((point, _find(numbers, point)) for point in points)
    return FoundChunk(found, numbers.version, time.perf_counter() - begun)


def _find(numbers: PointNumbers, point: SweptPoint) -> PointOutcome:
    try:
        with warnings.catch_warnings():
            # A sweep goes where it is sent: what is doubtful of its ends was said when it was planned.
            warnings.simplefilter("ignore", DoubtfulInput)
            return numbers(point)
    except Exception as error:
        told = f"point {point.number} ({_described(point.settings)})"
        raise CycleMapError(
            f"{told} failed, which no input should make it do: {type(error).__name__}: {error}"
        ) from error


def _described(settings: Mapping[str, object]) -> str:
    return ", ".join(
        f"{key}={value:g}" if isinstance(value, float) else f"{key}={value}" for key, value in settings.items()
    )


class InThisProcess(Executor):
    """An executor that runs what it is given at once, in the calling thread."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run the call and return its finished future; KeyboardInterrupt goes through."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def own_executor(workers: int) -> Iterator[Executor]:
    """An executor of so many processes, this one alone for 1; the processes end with the block or with this process."""
    if workers == 1:
        yield InThisProcess()
        return
    with _one_thread_each():
        # Fresh processes: a copy of this one would share its open store, its locks and its buffers.
        fresh = multiprocessing.get_context("spawn")
        others = set(multiprocessing.active_children())
        pool = ProcessPoolExecutor(workers, mp_context=fresh, initializer=_start_worker)
        try:
            yield pool
        except KeyboardInterrupt:
            # Whoever raised it has awaited what is at work, or was told not to.
            for worker in set(multiprocessing.active_children()) - others:
                worker.terminate()
            raise
        finally:
            pool.shutdown(wait=True, cancel_futures=True)


def _start_worker() -> None:
    """Leave Ctrl-C to the parent, and end when it ends, however it does."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    threading.Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """Let new processes use one thread where the user has not said otherwise."""
    unsaid = [name for name in _THREADS if name not in os.environ]
    os.environ.update(dict.fromkeys(unsaid, "1"))
    try:
        yield
    finally:
        for name in unsaid:
            os.environ.pop(name, None)
