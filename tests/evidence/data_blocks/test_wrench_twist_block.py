"""Wrench-twist pairs give friction and rim share back; groups by contact make honest intervals."""

import math

import numpy as np
import pytest

from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.evidence.data_blocks.force_blocks import (
    FORCE_KIND,
    TORQUE_KIND,
    WrenchTwists,
    read_wrench_twists,
    wrench_twist_block,
)
from cyclemap.evidence.identification.cross_validation import random_folds
from cyclemap.evidence.identification.data_block import JointProblem
from cyclemap.evidence.identification.identifiability import uncertainty
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.least_squares import fit_with_noise
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.evidence.laws.linear_fit import student_quantile
from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, Slider

SQUARE = Slider.mit("rect1").outline
RHO, WEIGHT = SQUARE.extent, 8.2
SCALE = np.array([1.0, 1.0, RHO])
PARAMETERS = ("friction_scale", "rim_share")
TRUTH = {"friction_scale": -1.5, "rim_share": 0.4}
PARTS = {"corner_share": 0.0, "inner_share": 0.0}
SPACE = SURFACE.select(PARAMETERS)
RUNS = 200


def wrench(twist, rim_share=0.4, friction=None):
    law = friction or EllipseFriction.isotropic(math.exp(-1.5))
    return WEIGHT * LimitSurface(PatchFootprint(SQUARE, rim_share=rim_share), law).wrench(twist)


def made_twists(count=60, seed=0):
    rng = np.random.default_rng(seed)
    return rng.standard_normal((count, 3)) * 0.006 / SCALE


TWISTS = made_twists()
WRENCHES = wrench(TWISTS)


def test_without_noise_friction_and_rim_share_come_back_exactly() -> None:
    block = wrench_twist_block(WrenchTwists(WRENCHES, TWISTS), SQUARE, WEIGHT)
    found = identify([block], PARAMETERS, starts=3)
    assert found.converged and found.starts.arrived == 3
    assert max(abs(found.values[name] - TRUTH[name]) for name in PARAMETERS) < 1e-9


def test_the_derivatives_are_slopes_and_the_prediction_is_that_of_the_limit_surface_at_any_share() -> None:
    block = wrench_twist_block(WrenchTwists(WRENCHES, TWISTS), SQUARE, WEIGHT)
    at, step = SPACE.vector({"friction_scale": -1.3, "rim_share": 0.7}), 1e-6
    residual, _ = block.residuals(PARTS | SPACE.values(at))
    _, exact = block.residuals({"corner_share": 0.3, "inner_share": 0.2} | SPACE.values(at))
    assert block.parameters == ("friction_scale", "inner_share", "rim_share", "corner_share")
    for column, name in enumerate(block.parameters):
        sides = ({"corner_share": 0.3, "inner_share": 0.2} | SPACE.values(at) for _ in range(2))
        up, down = (
            block.residuals({**values, name: values[name] + sign * step})[0]
            for sign, values in zip((1.0, -1.0), sides, strict=True)
        )
        assert np.allclose(exact[:, column], (up - down) / (2.0 * step), atol=1e-8)
    expected = wrench(TWISTS, 0.7, EllipseFriction.isotropic(math.exp(-1.3))) - WRENCHES
    assert np.allclose(residual, (expected / SCALE).ravel(), atol=1e-10)


def test_turning_the_object_with_its_pairs_by_a_quarter_turn_changes_no_residual() -> None:
    """The square is its own image: the frame's choice of sides cannot matter."""
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    noisy = WRENCHES + 0.1 * np.random.default_rng(1).standard_normal(WRENCHES.shape) * SCALE
    first = wrench_twist_block(WrenchTwists(noisy, TWISTS), SQUARE, WEIGHT).residuals(TRUTH)[0].reshape(-1, 3)
    moved = WrenchTwists(noisy @ turn.T, TWISTS @ turn.T)
    second = wrench_twist_block(moved, SQUARE, WEIGHT).residuals(TRUTH)[0].reshape(-1, 3)
    assert np.allclose(second, first @ turn.T, atol=1e-9)


def test_the_place_of_contact_is_where_the_force_enters_the_outline() -> None:
    """Forces put on known points of the rim, counted in pieces from the first vertex."""
    share = (np.arange(40) + 0.5) / 10.0
    side, along = np.divmod(share, 1.0)
    rim = SQUARE.points(4)
    start, end = rim[side.astype(int)], rim[side.astype(int) + 1]
    point, edge = start + along[:, None] * (end - start), (end - start) / 0.09
    inward = np.column_stack([-edge[:, 1], edge[:, 0]])
    force = 2.0 * inward + 0.3 * edge
    torque = point[:, 0] * force[:, 1] - point[:, 1] * force[:, 0]
    data = WrenchTwists(np.column_stack([force, torque]), np.column_stack([0.01 * inward, np.zeros(40)]))
    assert data.contact_pieces(SQUARE).tolist() == list(range(40))
    missing = WrenchTwists([[1.0, 0.0, 0.2], [0.0, 0.0, 1.0]], [[0.01, 0.0, 0.0], [0.0, 0.0, 0.1]])
    assert missing.contact_pieces(SQUARE).tolist() == [-1, -1]


@pytest.mark.slow
def test_intervals_of_95_percent_cover_in_90_to_99_percent_where_the_pairs_of_a_contact_share_their_errors() -> None:
    groups, held = np.repeat(np.arange(15), 4), []
    for seed in range(RUNS):
        rng = np.random.default_rng(seed)
        error = rng.standard_normal((60, 3)) + rng.standard_normal((15, 3))[groups]
        data = WrenchTwists(WRENCHES + 0.07 * error * SCALE, TWISTS)
        problem = JointProblem((wrench_twist_block(data, SQUARE, WEIGHT, groups),), SPACE, PARTS)
        fit = fit_with_noise(problem, SPACE.vector(TRUTH))
        errors = uncertainty(problem, fit)
        half = np.array([student_quantile(0.95, freedom) for freedom in errors.freedom.tolist()])
        held.append(np.abs(fit.vector - SPACE.vector(TRUTH)) < half * errors.standard_error)
    assert len(held) == 200
    shares = np.mean(held, axis=0)
    assert np.all((shares >= 0.9) & (shares <= 0.99))


def test_anisotropy_seen_from_all_around_hardly_moves_the_rim_share() -> None:
    friction = EllipseFriction(0.2545, 0.2346, 0.0325, 0.0082, 2.6175)
    twist = np.tile(made_twists(30, 3), (12, 1))
    turns = np.repeat(np.arange(12) * math.pi / 6.0, 30)
    surface = LimitSurface(PatchFootprint(SQUARE, rim_share=0.4), friction)
    measured = np.concatenate([WEIGHT * surface.wrench(twist[turns == angle], angle) for angle in np.unique(turns)])
    block = wrench_twist_block(WrenchTwists(measured, twist), SQUARE, WEIGHT)
    found = identify([block], PARAMETERS, starts=1)
    assert found["rim_share"].value == pytest.approx(0.4, abs=0.03)


def test_files_are_read_by_surface_and_refused_by_line(tmp_path) -> None:
    header = "surface,fx,fy,m_over_rho,vx,vy,w_times_rho"
    file = tmp_path / "pairs.csv"
    file.write_text(f"{header}\nabs,1.0,0.0,0.5,0.01,0.0,0.004\nplywood,2.0,0.0,0.5,0.01,0.0,0.004\n")
    data = read_wrench_twists(file, rho=0.06, surface="plywood")
    assert data.wrench.tolist() == [[2.0, 0.0, 0.03]]
    assert np.allclose(data.twist, [[0.01, 0.0, 0.004 / 0.06]])
    with pytest.raises(DataFileError, match="no row has surface 'delrin'; there are abs, plywood"):
        read_wrench_twists(file, rho=0.06, surface="delrin")
    file.write_text(f"{header}\nabs,-1.0,0.0,-0.5,0.01,0.0,0.004\n")
    with pytest.raises(DataFileError, match="turn their signs"):
        read_wrench_twists(file, rho=0.06)
    file.write_text("fx,fy\n1,2\n")
    with pytest.raises(DataFileError, match="m_over_rho"):
        read_wrench_twists(file, rho=0.06)


def test_pairs_that_cannot_be_used_are_refused() -> None:
    with pytest.raises(InvalidInput, match="twist 1 is zero"):
        WrenchTwists([[1.0, 0.0, 0.0]] * 2, [[0.01, 0.0, 0.0], [0.0, 0.0, 0.0]])
    with pytest.raises(InvalidInput, match="2 wrenches and 1 twists"):
        WrenchTwists([[1.0, 0.0, 0.0]] * 2, [[0.01, 0.0, 0.0]])
    with pytest.raises(InvalidInput, match="60 whole numbers"):
        wrench_twist_block(WrenchTwists(WRENCHES, TWISTS), SQUARE, WEIGHT, groups=np.arange(3))
    with pytest.raises(InvalidInput, match="weight must be positive"):
        wrench_twist_block(WrenchTwists(WRENCHES, TWISTS), SQUARE, -1.0)


def test_measured_pairs_ask_for_weight_on_the_rim_on_plywood_and_for_little_on_abs(measured_data) -> None:
    """Signs and units: all power is positive in the filtered data, and forces are friction times the weight."""
    slider, found = Slider.mit("rect1"), {}
    for surface, count in (("plywood", 600), ("abs", 506)):
        path = measured_data / "mit_rect1_wrench_twist_v10.csv"
        data = read_wrench_twists(path, rho=0.06364, surface=surface, source="HEAD_filtered")
        assert len(data.twist) == count
        assert np.all(data.power > 0.0)
        block = wrench_twist_block(data, slider.outline, slider.mass * 9.80665)
        assert len(np.unique(block.groups)) > 30
        assert set(block.kinds) == {FORCE_KIND, TORQUE_KIND}
        found[surface] = identify([block], PARAMETERS, starts=2, student=4.0, folds=5)
        even = identify([block], PARAMETERS[:1], {"rim_share": 0.0}, starts=2, student=4.0, folds=5)
        assert random_folds(even.problem, 5).tolist() == random_folds(found[surface].problem, 5).tolist()
        found[surface + " even"] = even
    assert found["plywood"]["rim_share"].lower > 0.6
    assert found["abs"]["rim_share"].upper < 0.5
    assert math.exp(found["plywood"].values["friction_scale"]) == pytest.approx(0.227, abs=0.01)
    assert math.exp(found["abs"].values["friction_scale"]) == pytest.approx(0.179, abs=0.01)
    torque = {name: one.errors[1].left_out_rms for name, one in found.items()}
    assert torque["plywood"] < 0.8 * torque["plywood even"]
    assert torque["abs"] < 1.05 * torque["abs even"]
