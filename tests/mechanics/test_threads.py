"""Values are shared by threads, forks and processes, survive pickling,
and stop when interrupted."""

import os
import pickle
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest
from refusals import refused

import cyclemap as cm
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    LimitSurface,
    PatchFootprint,
    PointFootprint,
    Polygon,
    Pusher,
    SidePush,
    Slider,
    grid_footprint,
)
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.mechanics.engine.schema import PARAMETERS
from cyclemap.mechanics.engine.strokes import THREADS_VARIABLE

THETA = np.linspace(-4.0, 5.0, 24)
SQUARE = Slider.mit("rect1").outline
OVAL = Slider(Ellipse(0.05, 0.03), hitch=(0.0, 0.01))
TRIANGLE = Slider(Polygon(((0.05, -0.03), (0.02, 0.05), (-0.04, -0.02))), hitch=(0.0, 0.01))


def mixture():
    """Loops that differ in everything, made anew so that nothing of them is known yet."""
    mit = cm.CollectionLoop.mit
    return [
        mit(),
        mit("abs", accuracy=1e-6),
        mit(pusher=Pusher(0.0)),
        mit(footprint=grid_footprint(SQUARE, 4)),
        mit(
            footprint=PointFootprint(((0.03, 0.03), (-0.04, 0.01), (0.0, -0.04)), (3.0, 1.0, 2.0)),
            accuracy=1e-6,
        ),
        mit(
            footprint=PatchFootprint(SQUARE, 0.2, 0.2, 0.1, (0.002, 0.001)),
            reset=DragBack(((0.1, 0.05),), 0.002),
        ),
        mit(slider=OVAL, push=SidePush(0, 0.2, 0.1, 0.08)),
        mit(
            slider=OVAL,
            footprint=PatchFootprint(OVAL.outline, 0.1, 0.3),
            push=SidePush(0, 0.2, 0.1, 0.08),
        ),
        mit(slider=TRIANGLE, reset=DragBack(pin_friction_radius=0.05)),
    ]


def everything(loop):
    """All numbers of some cycles of a loop: in one call and one by one, slopes, forces,
    friction."""
    theta = THETA[::8]
    cycles = loop.cycles(theta)
    one = loop.cycle(float(theta[1]))
    twists = np.array(((1.0, 0.2, 3.0), (0.1, -1.0, 30.0)))
    columns = [
        cycles.push_turn,
        cycles.push_displacement,
        cycles.drag_turn,
        cycles.drag_length,
        cycles.theta_next,
    ]
    columns += [one.trajectory.push.contact_force, one.trajectory.drag.pose, [one.theta_next]]
    columns += [loop.sensitivity(float(theta[2])).jacobian]
    columns += [LimitSurface(loop.model.pressure, loop.material.friction).hessian(twists)]
    return np.concatenate([np.ravel(column) for column in columns]).tobytes()


@pytest.fixture(scope="module")
def alone():
    return [everything(loop) for loop in mixture()]


@pytest.fixture
def hasty():
    """Threads that take turns every ten microseconds."""
    interval = sys.getswitchinterval()
    sys.setswitchinterval(1e-5)
    yield
    sys.setswitchinterval(interval)


@pytest.mark.slow
@pytest.mark.parametrize(("shared", "inner"), [(True, "1"), (False, "3")])
def test_eight_threads_come_to_the_same_bits_as_one_after_the_other(
    hasty, alone, shared, inner, monkeypatch
):
    monkeypatch.setenv(THREADS_VARIABLE, inner)
    loops = mixture()
    order = np.random.default_rng(3).permutation(np.repeat(np.arange(len(loops)), 3)).tolist()

    def work(number):
        return everything(loops[number] if shared else mixture()[number])

    with ThreadPoolExecutor(8) as pool:
        for number, found in zip(order, pool.map(work, order), strict=True):
            assert found == alone[number]


def test_nothing_depends_on_the_number_of_threads_or_on_the_company(monkeypatch):
    loops, theta, found = mixture(), np.random.default_rng(12).uniform(-4.0, 9.0, (9, 4)), []
    for count in ("1", "2", "5"):
        monkeypatch.setenv(THREADS_VARIABLE, count)
        found.append(run_batch(loops, theta, len(PARAMETERS)))
    order = np.random.default_rng(1).permutation(9)
    shuffled = run_batch([loops[k] for k in order], theta[order][:, ::-1], len(PARAMETERS))
    for name, column in vars(found[0]).items():
        for other in found[1:]:
            np.testing.assert_array_equal(column, getattr(other, name), err_msg=name)
        np.testing.assert_array_equal(column[order][:, ::-1], getattr(shuffled, name), err_msg=name)


def test_a_number_of_threads_that_is_none_is_refused_by_name(monkeypatch):
    for count in ("0", "-1", "two", "1.5", "²", " "):
        monkeypatch.setenv(THREADS_VARIABLE, count)
        refused(
            cm.CollectionLoop.mit().cycles, THETA, told="CYCLEMAP_THREADS must be a whole number"
        )


def test_loops_models_and_results_come_back_from_pickles(alone):
    for loop, wanted in zip(mixture(), alone, strict=True):
        assert everything(loop) == wanted
        again = pickle.loads(pickle.dumps(loop))
        assert again == loop and everything(again) == wanted
        assert pickle.loads(pickle.dumps(loop.model)) == loop.model
        cycle = pickle.loads(pickle.dumps(loop.cycle(0.3)))
        assert (
            cycle.push.trajectory.contact_force.tobytes()
            == loop.cycle(0.3).push.trajectory.contact_force.tobytes()
        )
    made = mixture()[0].circle_map(tolerance=1e-3)
    for one in (made, made.derivative):
        assert pickle.loads(pickle.dumps(one))(THETA).tobytes() == one(THETA).tobytes()


CHILD = """
import os, sys, numpy as np
import cyclemap as cm
loop = cm.CollectionLoop.mit()
"""


def child(program: str, threads: str) -> subprocess.Popen:
    environment = {**os.environ, THREADS_VARIABLE: threads}
    return subprocess.Popen(
        [sys.executable, "-c", CHILD + program], env=environment, stdout=subprocess.PIPE, text=True
    )


@pytest.mark.skipif(not hasattr(os, "fork"), reason="nothing can be forked here")
def test_a_fork_of_a_process_whose_threads_ran_cycles_has_threads_of_its_own():
    forked = (
        "theta = np.linspace(0.0, 6.0, 16)\n"
        "before = loop.next_theta(theta)\n"
        "child = os.fork()\n"
        "if child == 0: os._exit(0 if (loop.next_theta(theta) == before).all() else 1)\n"
        "print(os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]))"
    )
    with child(forked, "2") as process:
        try:
            assert process.communicate(timeout=60.0)[0] == "0\n"
        finally:
            process.kill()


@pytest.mark.slow
@pytest.mark.parametrize("threads", ["1", "2"])
def test_a_call_that_would_take_minutes_ends_when_interrupted(threads):
    """A million cycles take minutes; a second later the process tells that it stopped, and runs
    cycles again.
    """
    endless = (
        "from cyclemap.collection.loop import run_cycles\n"
        "before = loop.next_theta(np.linspace(0.0, 6.0, 16))\n"
        "print('begun', flush=True)\n"
        "try: run_cycles([loop], np.zeros(1_000_000))\n"
        "except KeyboardInterrupt:\n"
        "    print('interrupted', flush=True)\n"
        "    print((loop.next_theta(np.linspace(0.0, 6.0, 16)) == before).all())"
    )
    with child(endless, threads) as process:
        try:
            assert process.stdout is not None and process.stdout.readline() == "begun\n"
            time.sleep(1.0)
            assert process.poll() is None
            process.send_signal(signal.SIGINT)
            assert process.communicate(timeout=20.0)[0] == "interrupted\nTrue\n"
        finally:
            process.kill()
