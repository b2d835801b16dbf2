"""What is drawn of a sweep is what was found: planes, lines in the order of the key, every fixed
point.
"""

import numpy as np
import pytest
from fake_numbers import FakeNumbers, fake_plan, fake_sample, fake_values, swept
from refusals import refused

from cyclemap.sweeps import (
    PortraitNumbers,
    SweepPlan,
    SweptLines,
    SweptPlane,
    SweptScatter,
    sweep_curves,
)


def test_a_plane_has_the_rotation_numbers_the_counts_and_the_refusals(tmp_path) -> None:
    sweep = swept(tmp_path / "sweep.sqlite", fake_plan(refused_above=0.28))
    curves = sweep_curves(sweep)
    assert isinstance(curves, SweptPlane)
    assert [quantity.name for quantity, _ in curves.planes] == ["rotation", "stable_points"]
    assert np.array_equal(curves.planes[1][1], sweep.on_grid("stable_points"), equal_nan=True)
    assert curves.rotation is not None and curves.rotation.period.sum() == 4 * 3
    assert curves.refused.tolist() == [[False] * 4] * 4 + [[True] * 4]


def test_angles_are_drawn_in_degrees(tmp_path) -> None:
    """The fake numbers have no turns; a real map of isotropic friction turns by its rotation number
    each cycle.
    """
    over = {"hitch_x_mm": (-10.607,), "hitch_y_mm": (10.607,)}
    numbers = PortraitNumbers(("rotation", "turns"), tolerance=1e-3)
    plan = SweepPlan.grid("isotropic", over, numbers=numbers)
    curves = sweep_curves(swept(tmp_path / "sweep.sqlite", plan), ("mean_turn", "rotation"))
    turn, rotation = (float(values[0, 0]) for _, values in curves.planes)
    assert turn == pytest.approx(74.52037 - 66.51814, abs=0.06)
    assert 360.0 * rotation == pytest.approx(turn, abs=0.06)


def test_lines_run_along_the_key_with_every_fixed_point(tmp_path) -> None:
    plan = SweepPlan.grid(
        "plywood", {"hitch_x_mm": (0.0, -8.0, -4.0, -12.0)}, numbers=FakeNumbers()
    )
    curves = sweep_curves(swept(tmp_path / "sweep.sqlite", plan))
    assert isinstance(curves, SweptLines)
    assert curves.parameter.tolist() == curves.rotation_at.tolist() == [-12.0, -8.0, -4.0, 0.0]
    assert curves.lines[0][1].tolist() == [
        fake_values(0.25, x)["rotation"] for x in (-12.0, -8.0, -4.0, 0.0)
    ]
    at, theta, stable = curves.points
    assert sorted(at.tolist()) == [-12.0, -12.0, -8.0, -8.0]
    assert stable.sum() == 2
    assert np.degrees(0.1 + 8.0 / 7.0) in theta[stable]


@pytest.mark.slow
def test_a_sample_over_two_keys_is_scattered_and_over_one_is_a_line(tmp_path) -> None:
    curves = sweep_curves(swept(tmp_path / "sweep.sqlite", fake_sample(32, refused_above=0.25)))
    assert isinstance(curves, SweptScatter) and curves.refused.sum() == 16
    plan = SweepPlan.sample("plywood", {"mu_a": (0.2, 0.3)}, 32, numbers=FakeNumbers())
    one = sweep_curves(swept(tmp_path / "one.sqlite", plan))
    assert isinstance(one, SweptLines) and np.all(np.diff(one.parameter) > 0.0)


def test_what_cannot_be_drawn_is_refused(tmp_path) -> None:
    over = {"mu_a": (0.2, 0.3), "mu_b": (0.2, 0.3), "hitch_x_mm": (-8.0, 0.0)}
    sweep = swept(tmp_path / "sweep.sqlite", SweepPlan.grid("plywood", over, numbers=FakeNumbers()))
    refused(sweep_curves, sweep, told="3 keys are swept")
    refused(
        sweep_curves,
        sweep.select(mu_b=0.2),
        ("fixed_point_theta",),
        told="fixed_point_theta is a list",
    )
    refused(
        sweep_curves, sweep.select(mu_b=0.2), ("tv",), told="unknown quantity of this sweep 'tv'"
    )
    refused(sweep_curves, sweep.where(np.zeros(8, dtype=bool)), told="nothing to draw")
