"""Runs a sweep: every point that its store lacks, in chunks, here, in processes of its own, or on
any executor.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Iterator
from concurrent.futures import (
    FIRST_COMPLETED,
    BrokenExecutor,
    CancelledError,
    Executor,
    Future,
    ProcessPoolExecutor,
    wait,
)
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeVar

from cyclemap.checks import whole_number
from cyclemap.errors import CycleMapError, DoubtfulInput
from cyclemap.mechanics.engine.strokes import THREADS_VARIABLE
from cyclemap.sweeps.portrait_numbers import PointOutcome, PortraitNumbers, SweptPoint
from cyclemap.sweeps.sweep_plan import SweepPlan
from cyclemap.sweeps.sweep_store import SweepStatus, SweepStore

# Processes share the cores: each does linear algebra, and runs strokes, in one thread.
_THREADS = ("OPENBLAS_NUM_THREADS", THREADS_VARIABLE)


# What a worker sends back: points with their outcomes, the worker's code version, and the seconds
# it took.
FoundChunk = tuple[list[tuple[SweptPoint, PointOutcome]], str, float]


def find_chunk(numbers: PortraitNumbers, points: tuple[SweptPoint, ...]) -> FoundChunk:
    """Find the numbers of some points, one after the other.

    What a point refuses is in its outcome; any other failure is a CycleMapError that names the
    point.
    """
    begun = time.perf_counter()
    outcomes = []
    for point in points:
        try:
            with warnings.catch_warnings():
                # A sweep goes where it is sent: what is doubtful of its ends was said when it was
                # planned.
                warnings.simplefilter("ignore", DoubtfulInput)
                outcomes.append((point, numbers(point)))
        except Exception as error:
            given = point.settings.items()
            settings = (
                f"{key}={value:g}" if isinstance(value, float) else f"{key}={value}"
                for key, value in given
            )
            raise CycleMapError(
                f"point {point.number} ({', '.join(settings)}) failed, which no input should make "
                f"it do: {type(error).__name__}: {error}"
            ) from error
    return outcomes, numbers.version, time.perf_counter() - begun


Found = TypeVar("Found")


class InThisProcess(Executor):
    """An executor that runs what it is given at once, in the calling thread."""

    def submit(self, fn: Callable[..., Found], /, *args: object, **kwargs: object) -> Future[Found]:
        """Run the call and return its finished future; KeyboardInterrupt goes through."""
        future: Future[Found] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future


@contextmanager
def own_executor(workers: int) -> Iterator[Executor]:
    """An executor of so many processes, this one alone for 1; the processes end with the block or
    with this process.
    """
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


Progress = Callable[[SweepStatus], None]

# A chunk is to take about so long: much longer than its way there and back, short enough to lose
# when killed.
_CHUNK_SECONDS = 1.0
_LARGEST_CHUNK = 256
# Points whose presence in the store is looked up together.
_LOOKED_UP = 4096
# Chunks on their way for each worker: the next one waits there when one is done.
_CHUNKS_A_WORKER = 2


def run_sweep(
    plan: SweepPlan,
    path: str | Path,
    *,
    workers: int | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> SweepStatus:
    """Run what a store lacks of a plan, and return how far it is: complete, unless interrupted.

    Parameters
    ----------
    plan : SweepPlan
        The points, and what is asked of each.
    path : str or Path
        The store, a file, made where there is none.
    workers : int or None, optional
        How many processes; None: one a core that this one may use; 1: none but this one.
    executor : Executor or None, optional
        Run on it instead, be it of threads, processes or a cluster
        (`distributed.Client.get_executor()`); `workers` then says how many chunks it works on
        at once.
    progress : callable or None, optional
        Called with the status at the beginning and after every chunk.

    Returns
    -------
    SweepStatus
        How far the store is.

    Raises
    ------
    StoreWriteError
        On a full disk.
    CycleMapError
        Where a worker dies or fails; what was stored is kept in each case.

    Notes
    -----
    Only this process writes. Memory does not grow with the length of the sweep: at most twice
    as many chunks as workers are on their way. What is found depends neither on the number or
    kind of workers nor on interruptions, as long as the machines round alike (of several, all
    with one library of the engine and processors of one kind). Two sweeps into one store at
    once do no harm, but do the work twice. Scripts that use processes guard their main part by
    ``if __name__ == "__main__"``.

    On KeyboardInterrupt the chunks at work are awaited and stored, and it is raised again; a
    second one drops them. See `SweepStore` for stores that are refused.

    Examples
    --------
    >>> import tempfile
    >>> from cyclemap.sweeps import PortraitNumbers, SweepPlan, run_sweep
    >>> quick = PortraitNumbers(("rotation",), tolerance=1e-2)
    >>> plan = SweepPlan.grid("isotropic", {"noise_deg": (1.0, 2.0)}, numbers=quick)
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     run_sweep(plan, f"{folder}/sweep.sqlite", workers=1)
    SweepStatus(points=2, stored=2, refused=0)
    """
    cores = (
        len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    )
    many = cores if workers is None else whole_number("workers", workers, least=1)
    with SweepStore(Path(path), plan) as store:
        status = store.status()
        report = progress or (lambda status: None)
        report(status)
        if status.complete:
            return status
        with own_executor(many) if executor is None else nullcontext(executor) as pool:
            _Run(plan, store, pool, many, report, status).go()
        store.finish()
        return store.status()


@dataclass
class _Run:
    """A sweep at work: the chunks on their way, and how long a point takes."""

    plan: SweepPlan
    store: SweepStore
    executor: Executor
    workers: int
    progress: Progress
    status: SweepStatus
    waiting: set[Future[FoundChunk]] = field(default_factory=set)
    point_seconds: float | None = None

    def go(self) -> None:
        """Send all chunks and store what comes back."""
        try:
            for chunk in self._chunks():
                self.waiting.add(self.executor.submit(find_chunk, self.plan.numbers, chunk))
                # A chunk is done already where the executor is this process.
                while len(self.waiting) >= _CHUNKS_A_WORKER * self.workers or any(
                    future.done() for future in self.waiting
                ):
                    self._take(wait(self.waiting, return_when=FIRST_COMPLETED).done)
            while self.waiting:
                self._take(wait(self.waiting, return_when=FIRST_COMPLETED).done)
        except KeyboardInterrupt:
            self._cancel()
            self._take(wait(self.waiting).done)
            raise
        except BrokenExecutor as error:
            raise CycleMapError(
                f"a worker ended abruptly ({error}), perhaps for lack of memory; "
                f"{self.status.stored} of {self.status.points} points are stored: run the same "
                "sweep again to go on"
            ) from error
        finally:
            self._cancel()

    def _take(self, done: set[Future[FoundChunk]]) -> None:
        """Store the chunks that are done."""
        for future in done:
            self.waiting.discard(future)
            if future.cancelled():
                continue
            try:
                outcomes, version, seconds = future.result()
            except CancelledError as error:
                raise CycleMapError(
                    f"the executor dropped a chunk ({error}): run the same sweep again"
                ) from error
            if version != (wanted := self.plan.numbers.version):
                raise CycleMapError(
                    f"a worker runs another version of the code ({version}, not {wanted}): "
                    "install the same one there"
                )
            self.store.add(outcomes)
            each = seconds / len(outcomes)
            self.point_seconds = (
                each if self.point_seconds is None else 0.5 * (self.point_seconds + each)
            )
            stored = self.status.stored + len(outcomes)
            refused = sum(bool(outcome.refusal) for _, outcome in outcomes)
            self.status = SweepStatus(len(self.plan), stored, self.status.refused + refused)
            self.progress(self.status)

    def _cancel(self) -> None:
        self.waiting = {future for future in self.waiting if not future.cancel()}

    def _chunks(self) -> Iterator[tuple[SweptPoint, ...]]:
        """The points that are not stored, in order, in chunks as long as points are quick.

        One while their time is unknown, and few at the end, that all workers end together.
        """
        chunk: list[SweptPoint] = []
        stored: set[str] = set()
        for index in range(len(self.plan)):
            if index % _LOOKED_UP == 0:
                stored = self.store.digests(index, index + _LOOKED_UP)
            point = self.plan.point(index)
            if point.digest in stored:
                continue
            chunk.append(point)
            size = 1
            if self.point_seconds is not None:
                fair = (len(self.plan) - index) // (2 * self.workers)
                size = min(
                    int(_CHUNK_SECONDS / max(self.point_seconds, 1e-9)), fair, _LARGEST_CHUNK
                )
            if len(chunk) >= size:
                yield tuple(chunk)
                chunk = []
        if chunk:
            yield tuple(chunk)


def sweep_status(path: str | Path, plan: SweepPlan | None = None) -> SweepStatus:
    """Return how far a store is.

    Parameters
    ----------
    path : str or Path
        The store, a file.
    plan : SweepPlan or None, optional
        With it, an absent store is at the beginning and another plan's is refused.

    Returns
    -------
    SweepStatus
        Points in all, stored, refused.

    Raises
    ------
    DataFileError
        For a file that is absent (without a plan), damaged or no store.
    InvalidInput
        For the store of another plan.

    Examples
    --------
    >>> from cyclemap.sweeps import SweepPlan, sweep_status
    >>> plan = SweepPlan.grid("isotropic", {"noise_deg": (1.0, 2.0)})
    >>> sweep_status("not-yet-begun.sqlite", plan)
    SweepStatus(points=2, stored=0, refused=0)
    """
    if plan is not None and not Path(path).exists():
        return SweepStatus(len(plan), 0, 0)
    with SweepStore(Path(path), plan) as store:
        return store.status()
