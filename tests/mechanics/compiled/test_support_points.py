"""Compiled strokes on support points are the interpreted ones, also where the object turns about one of them."""

import math
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.mechanics import DragBack, EllipseFriction, Material, PointFootprint, grid_footprint
from cyclemap.mechanics.compiled import stroke_runner
from cyclemap.mechanics.compiled.cycle_batch import cycle_batch
from cyclemap.mechanics.pinned_point import PinnedPoints

MIT = CollectionLoop.mit()
FEW = tuple((x, y) for x in (-0.04, 0.03) for y in (-0.03, 0.04))
FOOTPRINTS = {
    "four": PointFootprint(FEW, (1.0, 1.0, 1.0, 1.0)),
    "loaded": PointFootprint(FEW, (1.0, 2.0, 1.5, 3.0)),
    "grid": grid_footprint(MIT.slider.outline, 5),
}
NUMBERS = ("push_turn", "push_displacement", "drag_turn", "drag_length", "theta_next")
THETA = np.linspace(-3.0, 3.0, 12)
every_footprint = pytest.mark.parametrize("footprint", FOOTPRINTS.values(), ids=FOOTPRINTS)


pytestmark = pytest.mark.usefixtures("compiled")


def on_points(footprint, seed: int) -> CollectionLoop:
    """A surface drawn at random; every other one with friction in the ring."""
    rng, reset = np.random.default_rng(seed), DragBack(pin_friction_radius=1e-3 * (seed % 2))
    law = EllipseFriction(*rng.uniform(0.15, 0.4, 2), *rng.uniform(-0.05, 0.05, 2), rng.uniform(0.0, math.pi))
    return replace(MIT, footprint=footprint, material=Material("drawn", law), reset=reset, accuracy=1e-5)


@every_footprint
def test_cycles_on_support_points_are_those_of_python(footprint) -> None:
    for seed in range(2):
        loop = on_points(footprint, seed)
        found = cycle_batch([loop], THETA[None], slopes=False)
        assert found.done.all()
        with stroke_runner.interpreted():
            wanted = loop.cycles(THETA)
        for name in NUMBERS:
            np.testing.assert_allclose(getattr(found, name)[0], getattr(wanted, name), rtol=0.0, atol=1e-11)


def test_turning_about_a_support_point_is_run_by_the_compiled_code_as_by_python(monkeypatch) -> None:
    """Python is seen to find such points on these very cycles, of which the compiled code leaves none to it."""
    held = []
    about = PinnedPoints._about

    def seen(self, index, arguments):
        solution = about(self, index, arguments)
        held.append(solution is not None)
        return solution

    monkeypatch.setattr(PinnedPoints, "_about", seen)
    loop = on_points(FOOTPRINTS["grid"], 0)
    compiled_ends = cycle_batch([loop], THETA[None], slopes=False)
    assert compiled_ends.done.all() and not held
    with stroke_runner.interpreted():
        wanted = loop.next_theta(THETA)
    assert sum(held) > 10
    np.testing.assert_allclose(compiled_ends.theta_next[0], wanted, rtol=0.0, atol=1e-11)


@every_footprint
def test_slopes_on_support_points_are_pythons_and_left_to_it_where_a_point_rests(footprint) -> None:
    loop = on_points(footprint, 1)
    found = cycle_batch([loop], THETA[None], slopes=True)
    with stroke_runner.interpreted():
        wanted = [loop.sensitivity(theta, ("theta",)).by_theta for theta in THETA.tolist()]
    done = found.done[0]
    assert done.sum() >= 6
    np.testing.assert_allclose(found.by_theta[0][done], np.array(wanted)[done], rtol=0.0, atol=1e-8)


def test_more_support_points_than_there_is_room_for_are_left_to_python() -> None:
    many, few = (replace(MIT, footprint=grid_footprint(MIT.slider.outline, count)) for count in (32, 31))
    assert many.model.stroke_kind is None and few.model.stroke_kind is not None
