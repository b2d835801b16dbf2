"""A swept point has the portrait's own numbers; what has no loop or no number says so."""

from dataclasses import asdict, replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop, portrait
from cyclemap.mechanics import CycleNoise
from cyclemap.protocol import loop_from_settings
from cyclemap.sweeps import PortraitNumbers, SweepPlan, SweptPoint, portrait_numbers as module

TOLERANCE = 1e-4


@pytest.mark.slow
def test_every_number_is_the_portraits_to_the_last_bit() -> None:
    """At a point that changes friction, ring and noise."""
    plan = SweepPlan.grid("plywood", {"mu_a": (0.26,), "hitch_x_mm": (-11.0,)}, {"noise_deg": 10.0})
    found = PortraitNumbers(("all",), TOLERANCE, rotation_tolerance=0.0)(plan.point(0))
    loop = loop_from_settings({"mu_a": 0.26, "hitch_x_mm": -11.0}, CollectionLoop.mit("plywood"))
    drawn = portrait(loop, sigma=float(np.radians(10.0)), cycles=1, tolerance=TOLERANCE)
    points, rotation = drawn.fixed_points, drawn.rotation
    assert len(points) == 2 and rotation.locked == 0 and drawn.tv_from_uniform is not None
    assert found.refusal == ""
    assert found.values == {
        "samples": drawn.map.samples,
        "max_error": drawn.map.max_error,
        "rotation": rotation.value,
        "rotation_lower": rotation.lower,
        "rotation_upper": rotation.upper,
        "locked_winding": 0.0,
        "locked_period": 1.0,
        "fixed_points": 2.0,
        "stable_points": len(drawn.stable_points),
        "fixed_point_theta": tuple(orbit.points[0] for orbit in points),
        "fixed_point_multiplier": tuple(orbit.multiplier for orbit in points),
        "fixed_point_stable": tuple(float(orbit.stable) for orbit in points),
        "gathering_jump_theta": drawn.gathering_jumps,
        **asdict(drawn.turns),
        "tv_from_uniform": drawn.tv_from_uniform,
        "spectral_gap": drawn.operator.spectral_gap,
        "mixing_cycles": drawn.operator.mixing_cycles,
        "noisy_mean_turn": drawn.prediction.mean_turn,
        "mean_residence_cycles": drawn.prediction.mean_residence_cycles,
        "step": drawn.prediction.step,
    }
    assert {one.name for one in PortraitNumbers(("all",)).quantities} == set(found.values)


def only_values(*arguments):
    """Of the one point of a grid."""
    plan = SweepPlan.grid(*arguments)
    return plan.numbers(plan.point(0)).values


def normal_gap(noise):
    """Of a rigid rotation with normal noise: the second eigenvalue has the size exp(-σ²/2)."""
    return pytest.approx(1.0 - np.exp(-0.5 * noise**2), abs=1e-6)


def test_neighbours_that_differ_in_noise_alone_share_a_map(monkeypatch) -> None:
    made = []

    def counted(loop, tolerance=1e-6, progress=None):
        made.append(loop)
        return real(loop, tolerance)

    real = CollectionLoop.circle_map
    monkeypatch.setattr(CollectionLoop, "circle_map", counted)
    module._map_of.cache_clear()
    numbers = PortraitNumbers(("stationary",), 1e-2)
    plan = SweepPlan.grid("isotropic", {"noise_deg": (10.0, 40.0)}, numbers=numbers)
    gaps = [plan.numbers(plan.point(number)).values["spectral_gap"] for number in range(2)]
    assert len(made) == 1
    assert gaps == normal_gap(np.radians([10.0, 40.0]))


def test_a_material_that_has_a_noise_of_its_own_is_swept_with_it() -> None:
    """As its portrait is; kicks that hang together by 0.5 carry √3 times as far."""
    loop = CollectionLoop.mit("isotropic")
    own = replace(loop.material, noise=CycleNoise((np.log(0.2), 0.0, 0.0), 0.5))
    over, numbers = {"push_mm": (150.0,)}, PortraitNumbers(("stationary",), 1e-2)
    plain = only_values(own, over, {}, numbers)["spectral_gap"]
    drawn = portrait(replace(loop, material=own), cycles=1, tolerance=1e-2)
    assert plain == drawn.operator.spectral_gap
    assert plain == normal_gap(0.2 * np.sqrt(3.0))
    given = only_values(own, over, {"noise_deg": 30.0}, numbers)
    assert given["spectral_gap"] == normal_gap(np.radians(30.0))


def test_a_gap_that_is_rounding_is_not_told() -> None:
    """Of two stable directions that the noise never leaves in a collection's time."""
    strong = {"mu_a": 0.4, "mu_b": 0.2, "m0": 0.0, "n0": 0.0, "noise_deg": 1.0}
    numbers = PortraitNumbers(("stationary",), 1e-3)
    values = only_values("plywood", {"phi_deg": (150.0,)}, strong, numbers)
    assert np.isnan(values["spectral_gap"]) and np.isnan(values["mixing_cycles"])


def test_a_loop_that_cannot_be_is_a_stated_refusal() -> None:
    for over, told in (
        ({"fraction": (0.5, 1.5)}, "contact fraction 1.5"),
        ({"push_mm": (150.0, -1.0)}, "push distance"),
        ({"mu_b": (0.2, 0.0)}, "mu_b"),
        ({"rim_share": (0.0, 7.0)}, "rim"),
    ):
        plan = SweepPlan.grid("plywood", over)
        found = plan.numbers(plan.point(1))
        assert found.values == {} and told in found.refusal


def test_a_group_that_cannot_be_found_leaves_the_others(monkeypatch) -> None:
    def refused(work):
        raise module.CycleMapError("too steep")

    monkeypatch.setitem(module._FOUND, "rotation", refused)
    numbers = PortraitNumbers(("rotation", "turns"), 1e-2)
    plan = SweepPlan.grid("isotropic", {"mu_a": (0.25,)}, numbers=numbers)
    found = plan.numbers(plan.point(0))
    assert found.refusal == "rotation: too steep"
    told = [quantity.name for group in ("map", "turns") for quantity in module.GROUPS[group]]
    assert list(found.values) == told


def test_a_coarser_map_is_taken_only_where_it_settles_what_is_asked() -> None:
    """The ring goes out through the saddle-node: counts and locks are those of fine maps."""
    fine = PortraitNumbers(tolerance=1e-7, rotation_tolerance=0.0)

    def point_at(radius: float) -> SweptPoint:
        x, y = radius * np.array((-1.0, 1.0)) / np.sqrt(2.0)
        return SweepPlan.grid("plywood", {"hitch_x_mm": (x,)}, {"hitch_y_mm": y}).point(0)

    low, high = 9.0, 11.0
    while high - low > 1e-6:
        middle = 0.5 * (low + high)
        if fine(point_at(middle)).values["min_turn"] > 0.0:
            low = middle
        else:
            high = middle
    coarse = 0
    for radius in (4.0, low - 2e-4, low, high + 2e-4, 12.0, 18.0):
        point, near = point_at(radius), abs(radius - low) <= 1e-3
        swept, exact = PortraitNumbers()(point).values, fine(point).values
        if not near:
            assert swept["fixed_points"] == exact["fixed_points"] == (2.0 if radius > low else 0.0)
            assert swept["locked_period"] == exact["locked_period"]
        assert swept["rotation_lower"] <= exact["rotation_upper"]
        assert exact["rotation_lower"] <= swept["rotation_upper"]
        coarse += swept["max_error"] > 1e-5
        assert swept["max_error"] <= (1e-5 if near else 1e-4)
    assert coarse == 3


@pytest.mark.slow
def test_by_default_rotation_and_law_are_told_finely_enough_for_a_phase_diagram() -> None:
    """Away from the tongue 0/1, where nothing is exact: within 1e-4 turns a cycle."""
    ring, numbers = {"hitch_y_mm": 5.0}, PortraitNumbers(("rotation", "stationary"))
    values = only_values("plywood", {"hitch_x_mm": (-5.0,)}, ring, numbers)
    assert values["locked_period"] == 0.0
    assert 0.0 < values["rotation_upper"] - values["rotation_lower"] <= 2e-4
    assert 0.0 < values["tv_from_uniform"] < 1.0


SOURCES = "mechanics/push.py", "mechanics/steps.c", "maps/lifts/lift.py", "collection/loop.py"
OTHERS = ("mechanics/push.pyc", "mechanics/notes.txt", "views/page.py", "sweeps/sweep_store.py")


def test_an_edit_of_a_source_is_another_version_and_of_anything_else_is_not(
    tmp_path, monkeypatch
) -> None:
    """In a package of a few files; the real one has the engine that runs the strokes."""
    assert {path.suffix for path in (module.PACKAGE / "mechanics").rglob("*.c")} == {".c"}
    names = (*SOURCES, *OTHERS, "sweeps/portrait_numbers.py")
    digest = module.code_version.__wrapped__
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(module, "PACKAGE", tmp_path)
    before = digest()
    for name in names:
        (tmp_path / name).write_text("changed")
        assert (digest() == before) == (name in OTHERS), name
        (tmp_path / name).write_text(name)
        assert digest() == before
