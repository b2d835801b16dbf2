"""Compiled strokes are the interpreted ones: every number of them, and the steps that they took."""

import math
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import (
    DragBack,
    Ellipse,
    EllipseFriction,
    PatchFootprint,
    Polygon,
    Pose,
    Pusher,
    QuasiStaticModel,
    SidePush,
    Slider,
)
from cyclemap.mechanics.compiled import stroke_runner

SQUARE = Slider.mit("rect1")
AROUND = (0.05, 0.0, 0.7)


pytestmark = pytest.mark.usefixtures("compiled")


def random_law(rng) -> EllipseFriction:
    mu_a, mu_b = rng.uniform(0.15, 0.4, 2)
    return EllipseFriction(mu_a, mu_b, *rng.uniform(-0.05, 0.05, 2), rng.uniform(0.0, math.pi))


def random_case(rng) -> tuple[QuasiStaticModel, Pose, SidePush, DragBack]:
    """A law, rod, push and drag drawn at random, on MIT's square."""
    pusher = Pusher(rng.uniform(0.001, 0.01), rng.choice([0.0, 0.15, 0.5]))
    model = QuasiStaticModel(SQUARE, random_law(rng), pusher, accuracy=10.0 ** rng.uniform(-10.0, -6.0))
    push = SidePush(int(rng.integers(4)), rng.uniform(0.05, 0.95), rng.uniform(-0.8, 0.8), rng.uniform(0.02, 0.2))
    reset = DragBack(((0.03, -0.05),), float(rng.choice([0.0, 0.001])))
    return model, Pose(0.02, -0.01, rng.uniform(-4.0, 4.0)), push, reset


def run(case):
    model, pose, push, reset = case
    pushed = model.push(pose, push)
    return pushed, model.drag(pushed.end, (*reset.way_points, (0.0, 0.0)), math.inf, reset.pin_friction_radius)


def numbers(strokes) -> list[float]:
    push, drag = strokes
    return [*vars(push.end).values(), push.travel, *vars(drag.end).values(), drag.length]


def story(strokes) -> list[tuple[str, str, int | None, int]]:
    """Modes, pieces, what ended each phase, and how many steps it took."""
    phases = [*strokes[0].run.phases, *(leg.phase for leg in strokes[1].legs)]
    return [(p.motion.mode, p.motion.piece.kind, p.phase.broken, len(p.phase.steps)) for p in phases]


def both(case):
    """The strokes as Python runs them, and compiled ones, which are no fallback."""
    with stroke_runner.interpreted():
        slow = run(case)
    assert stroke_runner.stroke_runner(case[0].stroke_kind) is not None
    return slow, run(case)


def test_random_strokes_agree_to_1e_12_and_take_the_same_steps():
    rng = np.random.default_rng(7)
    cases = [random_case(rng) for _ in range(40)]
    modes = set()
    for case in cases:
        slow, fast = both(case)
        assert story(fast) == story(slow)
        np.testing.assert_allclose(numbers(fast), numbers(slow), rtol=0.0, atol=1e-12)
        assert fast[0].ended == slow[0].ended
        modes |= {phase[0] for phase in story(slow)}
    assert modes >= {"stick", "slide_left", "slide_right", "slide_free", "ring", "ring_left", "ring_right"}


def leaning() -> PatchFootprint:
    outline = SQUARE.outline
    return PatchFootprint(outline, gradient=(3.0, -2.0), rim_share=0.2, warp=(0.05, 0.02))


@pytest.mark.parametrize(
    ("slider", "footprint"),
    [
        (Slider(Ellipse(0.05, 0.03), mass=1.0, hitch=(0.0, 0.01)), None),
        (Slider(Polygon(((0.05, -0.03), (0.02, 0.05), (-0.04, -0.02))), mass=1.0, hitch=(0.0, 0.01)), None),
        (SQUARE, leaning()),
    ],
    ids=["ellipse", "triangle", "leaning, framed and warped"],
)
def test_other_outlines_and_pressures_agree_to_1e_12(slider, footprint):
    model = QuasiStaticModel(slider, EllipseFriction(0.3, 0.2, 0.02, -0.01, 0.4), footprint=footprint)
    for theta in (0.3, 2.0):
        slow, fast = both((model, Pose(theta=theta), SidePush(fraction=0.6, distance=0.1), DragBack()))
        assert story(fast) == story(slow)
        np.testing.assert_allclose(numbers(fast), numbers(slow), rtol=0.0, atol=1e-12)


def test_a_recorded_stroke_holds_the_stages_of_its_steps():
    case = (QuasiStaticModel(SQUARE, EllipseFriction(0.3, 0.2)), Pose(), SidePush(), DragBack())
    slow, fast = both(case)
    pairs = list(zip(slow[0].run.phases, fast[0].run.phases, strict=True))
    assert len(pairs) >= 2
    for one, other in pairs:
        np.testing.assert_allclose(other.start, one.start, atol=1e-12)
        for taken, same in zip(one.phase.steps, other.phase.steps, strict=True):
            assert same.h == pytest.approx(taken.h, rel=1e-5)
            finite = np.isfinite(taken.stages)
            np.testing.assert_allclose(same.stages[finite], taken.stages[finite], atol=1e-7)
    np.testing.assert_allclose(fast[0].trajectory.pose, slow[0].trajectory.pose, atol=1e-12)


def test_one_library_serves_threads_at_once():
    loop, theta = CollectionLoop.mit(), np.linspace(0.0, 6.0, 8)
    alone = loop.next_theta(theta)
    with ThreadPoolExecutor(4) as pool:
        for found in pool.map(lambda _: loop.next_theta(theta), range(8)):
            np.testing.assert_array_equal(found, alone)


def test_a_point_rod_is_left_to_python():
    model = QuasiStaticModel(SQUARE, EllipseFriction(0.3, 0.2), Pusher(radius=0.0))
    assert model.stroke_kind is None
    assert model.push(Pose(), SidePush(distance=0.02)).ended == "distance"


def test_a_library_is_compiled_once_enough_strokes_are_asked_for(monkeypatch, tmp_path):
    monkeypatch.setenv("CYCLEMAP_CACHE", str(tmp_path / "empty"))
    monkeypatch.setattr(stroke_runner, "WORTHWHILE", 10)
    monkeypatch.setattr(stroke_runner, "_compiled_here", [])
    kind = CollectionLoop.mit().model.stroke_kind
    assert [stroke_runner.stroke_runner(kind, 3) is not None for _ in range(4)] == [False, False, False, True]


def test_each_library_that_a_process_compiles_makes_the_next_one_dearer(monkeypatch, tmp_path):
    """Where every loop has an object of its own, few are compiled, however many there are."""
    monkeypatch.setenv("CYCLEMAP_CACHE", str(tmp_path / "dear"))
    monkeypatch.setattr(stroke_runner, "WORTHWHILE", 10)
    monkeypatch.setattr(stroke_runner, "_compiled_here", [])
    sliders = [Slider(Polygon(((width, -0.03), (0.0, 0.05), (-0.04, -0.02))), mass=1.0) for width in (0.04, 0.05, 0.06)]
    kinds = [QuasiStaticModel(slider, EllipseFriction(0.3, 0.2)).stroke_kind for slider in sliders]
    assert len(set(kinds)) == 3
    assert [stroke_runner.stroke_runner(kind, 20) is not None for kind in kinds] == [True, False, False]
    assert len(stroke_runner._compiled_here) == 1
