"""Whole cycles in compiled code are the interpreted ones, whatever else is in the call and on however many threads."""

import math
import os
import signal
import subprocess
import sys
import threading
import time
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    EllipseFriction,
    Material,
    Polygon,
    Pusher,
    SidePush,
    Slider,
    grid_footprint,
)
from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.cycle_batch import CycleBatch, cycle_batch
from cyclemap.mechanics.compiled.threads import THREADS_VARIABLE, on_threads, thread_count

NUMBERS = ("push_turn", "push_displacement", "drag_turn", "drag_length", "theta_next")
SQUARE = Slider.mit("rect1")
OBJECTS = (
    (SQUARE, None),
    (Slider(Ellipse(0.05, 0.03), hitch=(0.0, 0.01)), None),
    (Slider(Polygon(((0.05, -0.03), (0.02, 0.05), (-0.04, -0.02))), hitch=(0.0, 0.01)), None),
)


pytestmark = pytest.mark.usefixtures("compiled")


def random_loop(rng, number: int) -> CollectionLoop:
    """One of the objects in turn; surface, rod, push, way back and accuracy drawn."""
    slider, footprint = OBJECTS[number % len(OBJECTS)]
    law = EllipseFriction(*rng.uniform(0.15, 0.4, 2), *rng.uniform(-0.05, 0.05, 2), rng.uniform(0.0, math.pi))
    pusher = Pusher(rng.uniform(0.001, 0.01), rng.choice([0.0, 0.15, 0.5]))
    side = int(rng.integers(slider.outline.sides))
    push = SidePush(side, rng.uniform(0.05, 0.95), rng.uniform(-0.8, 0.8), rng.uniform(0.02, 0.2))
    ways = tuple(map(tuple, rng.uniform(-0.1, 0.1, (int(rng.integers(3)), 2))))
    reset = DragBack(ways, float(rng.choice([0.0, 0.001])))
    return CollectionLoop(slider, Material("drawn", law), pusher, push, reset, footprint, 10.0 ** rng.uniform(-9, -5))


def random_loops(count: int) -> list[CollectionLoop]:
    rng = np.random.default_rng(11)
    return [random_loop(rng, number) for number in range(count)]


def thetas(*shape: int) -> np.ndarray:
    return np.random.default_rng(12).uniform(-4.0, 9.0, shape)


def same(one: CycleBatch, other: CycleBatch) -> None:
    """Bit for bit."""
    for name in vars(one):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def test_a_mixture_of_loops_agrees_with_python_to_1e_12():
    """Where a map is steep, rounding is magnified as any difference is."""
    loops, theta = random_loops(15), thetas(15, 2)
    batch = cycle_batch(loops, theta, slopes=True)
    assert batch.done.sum() >= 28 and 0 < batch.left.sum() < 20
    for number, (loop, row) in enumerate(zip(loops, theta, strict=True)):
        with stroke_runner.interpreted():
            slow = loop.cycles(row)
        for place in np.flatnonzero(batch.done[number]).tolist():
            at, allowed = (number, place), 1e-12 * max(1.0, abs(batch.by_theta[number, place]))
            for name in NUMBERS:
                difference = np.abs(getattr(batch, name)[at] - getattr(slow, name)[place]).max()
                assert difference <= allowed, (name, at)
            assert batch.left[at] == slow.left[place]


@pytest.mark.parametrize("material", ["plywood", "delrin"])
def test_slopes_are_those_of_the_sensitivities(material):
    loop, theta = CollectionLoop.mit(material), np.linspace(-1.0, 9.0, 12)
    batch = cycle_batch([loop], theta[None], slopes=True)
    slopes = [loop.sensitivity(t, ("theta",)).by_theta for t in theta]
    assert batch.done.all() and 0 < batch.left.sum() < 12
    np.testing.assert_allclose(batch.by_theta[0], slopes, rtol=0.0, atol=1e-9)


def test_slopes_are_those_of_central_differences():
    loops = [replace(loop, accuracy=1e-10) for loop in random_loops(12)]
    theta, step = thetas(12, 2), 1e-5
    sides = [cycle_batch(loops, theta + sign * step, slopes=False) for sign in (1.0, -1.0)]
    batch = cycle_batch(loops, theta, slopes=True)
    done = batch.done & sides[0].done & sides[1].done
    assert done.sum() >= 20
    differences = (sides[0].theta_next - sides[1].theta_next) / (2.0 * step)
    np.testing.assert_allclose(batch.by_theta[done], differences[done], rtol=2e-4, atol=2e-4)
    assert np.isnan(sides[0].by_theta).all()


def test_what_a_cycle_comes_to_does_not_depend_on_its_company():
    loops, theta = random_loops(8), thetas(8, 3)
    whole, order = cycle_batch(loops, theta, slopes=True), np.random.default_rng(1).permutation(8)
    shuffled = cycle_batch([loops[k] for k in order], theta[order][:, ::-1], slopes=True)
    same(shuffled, CycleBatch(*(column[order][:, ::-1] for column in vars(whole).values())))
    alone = [cycle_batch([loop], row[None], slopes=True) for loop, row in zip(loops, theta, strict=True)]
    columns = zip(*(vars(batch).values() for batch in alone), strict=True)
    same(whole, CycleBatch(*(np.concatenate(column) for column in columns)))


def test_nothing_depends_on_the_number_of_threads(monkeypatch):
    loops, theta, found = random_loops(9), thetas(9, 4), []
    for count in ("1", "2", "5"):
        monkeypatch.setenv(THREADS_VARIABLE, count)
        found.append(cycle_batch(loops, theta, slopes=True))
    same(found[0], found[1])
    same(found[0], found[2])


def test_parts_that_do_not_fit_and_what_only_python_can_run_are_left_to_it():
    loop = CollectionLoop.mit()
    cases = [
        replace(loop, push=SidePush(side=7)),
        replace(loop, accuracy=1.0),
        replace(loop, pusher=Pusher(0.0)),
        replace(loop, footprint=grid_footprint(SQUARE.outline, 3)),
        loop,
    ]
    batch = cycle_batch(cases, np.zeros((5, 2)), slopes=False)
    np.testing.assert_array_equal(batch.done.sum(axis=1), [0, 0, 0, 2, 2])
    assert np.isnan(batch.theta_next[:3]).all() and np.isfinite(batch.theta_next[3:]).all()


@pytest.mark.parametrize(
    "reset",
    [DragBack(((0.1, 0.0), (0.1, 0.0))), DragBack(((0.1, 0.0), (0.0, 0.0))), DragBack(((0.1, 0.05),), 0.05)],
    ids=["a way-point twice", "the target twice", "a ring that holds"],
)
def test_legs_without_length_and_rings_that_hold_are_those_of_python(reset):
    loop, theta = replace(CollectionLoop.mit(), reset=reset), np.array([0.0, 1.0, 4.0])
    batch = cycle_batch([loop], theta[None], slopes=True)
    assert batch.done.all()
    with stroke_runner.interpreted():
        slow = loop.cycles(theta)
        slopes = [loop.sensitivity(t, ("theta",)).by_theta for t in theta]
    for name in NUMBERS:
        np.testing.assert_allclose(getattr(batch, name)[0], getattr(slow, name), rtol=0.0, atol=1e-12)
    np.testing.assert_allclose(batch.by_theta[0], slopes, rtol=0.0, atol=1e-9)
    assert (slow.drag_turn == 0.0).all() == (reset.pin_friction_radius > 0.0)


def test_no_orientations_are_no_cycles():
    assert cycle_batch([CollectionLoop.mit()], np.zeros((1, 0)), slopes=True).theta_next.shape == (1, 0)
    assert cycle_batch([], np.zeros((0, 3)), slopes=True).push_displacement.shape == (0, 3, 2)


@pytest.mark.parametrize("count", ["0", "-1", "two", "1.5", "²", " "])
def test_a_number_of_threads_that_is_none_is_refused_by_name(monkeypatch, count):
    monkeypatch.setenv(THREADS_VARIABLE, count)
    with pytest.raises(InvalidInput, match=r"CYCLEMAP_THREADS must be a whole number of at least 1, not '"):
        cycle_batch([CollectionLoop.mit()], np.zeros((1, 2)), slopes=False)


def test_the_number_of_threads_is_that_of_the_cores_unless_it_is_given(monkeypatch):
    monkeypatch.setenv(THREADS_VARIABLE, "7")
    assert thread_count() == 7
    monkeypatch.delenv(THREADS_VARIABLE)
    assert 1 <= thread_count() <= (os.cpu_count() or 1)


def test_work_on_threads_is_done_by_all_of_them_and_its_errors_are_raised_and_stop_the_rest():
    barrier, stopped = threading.Barrier(3, timeout=10.0), []
    on_threads(3, barrier.wait, lambda: stopped.append(1))
    assert not stopped

    def fail() -> None:
        barrier.wait()
        raise ValueError("of a thread")

    with pytest.raises(ValueError, match="of a thread"):
        on_threads(3, fail, lambda: stopped.append(1))
    assert stopped == [1]


CHILD = """
import os, numpy as np
from cyclemap.collection import CollectionLoop
from cyclemap.mechanics.compiled import stroke_runner
stroke_runner.WORTHWHILE = 0
loop = CollectionLoop.mit()
"""


def run_child(program: str, threads: str) -> subprocess.Popen:
    environment = {**os.environ, THREADS_VARIABLE: threads}
    return subprocess.Popen([sys.executable, "-c", CHILD + program], env=environment, stdout=subprocess.PIPE, text=True)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing can be forked here")
def test_a_fork_of_a_process_whose_threads_ran_cycles_has_threads_of_its_own():
    forked = (
        "theta = np.linspace(0.0, 6.0, 64)\n"
        "before = loop.next_theta(theta)\n"
        "child = os.fork()\n"
        "if child == 0: os._exit(0 if (loop.next_theta(theta) == before).all() else 1)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))"
    )
    with run_child(forked, "2") as process:
        try:
            assert process.communicate(timeout=30.0)[0] == "0\n"
        finally:
            process.kill()


@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_long_call_can_be_interrupted(threads):
    endless = (
        "loop.next_theta(np.zeros(2))\n"
        "print('begun', flush=True)\n"
        "try: loop.next_theta(np.zeros(300_000))\n"
        "except KeyboardInterrupt: print('interrupted')"
    )
    with run_child(endless, threads) as process:
        try:
            assert process.stdout is not None and process.stdout.readline() == "begun\n"
            time.sleep(0.5)
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=20.0)[0] == "interrupted\n"
        finally:
            process.kill()
