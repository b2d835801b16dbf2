"""Wrench-twist pairs give friction and the plate's shape back; groups by contact make honest
intervals.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.evidence import WrenchTwists, identify, wrench_twist_block
from cyclemap.evidence.identification.force_blocks import read_wrench_twists
from cyclemap.evidence.tables.columns import TWIST_COLUMNS, WRENCH_COLUMNS, known_columns
from cyclemap.mechanics import EllipseFriction, LimitSurface, PressedFootprint, Slider, SurfaceShape
from cyclemap.text_files import read_csv_table

RECT1 = Slider.mit("rect1")
SQUARE, WEIGHT = RECT1.outline, RECT1.weight
RHO, KPA = SQUARE.extent, 1e3 * SQUARE.area / WEIGHT
SCALE = np.array([1.0, 1.0, RHO])
TRUTH = {"friction_scale": -1.5, "plate_dome": 0.4}
PARAMETERS = tuple(TRUTH)
PARTS = {"floor_dome": 0.0, "plate_warp_x": 0.0, "plate_warp_y": 0.0}
HEADER = "surface,fx,fy,m_over_rho,vx,vy,w_times_rho"


def wrench(twist, dome_kpa=0.4, friction=None, angle=0.0):
    law = friction or EllipseFriction.isotropic(math.exp(-1.5))
    return WEIGHT * LimitSurface(
        PressedFootprint(SQUARE, SurfaceShape(KPA * dome_kpa)), law
    ).wrench(twist, angle)


def made_twists(count, seed):
    return np.random.default_rng(seed).standard_normal((count, 3)) * 0.006 / SCALE


TWISTS = made_twists(60, 0)
WRENCHES = wrench(TWISTS)


def made_block(wrenches=WRENCHES, twists=TWISTS):
    return wrench_twist_block(WrenchTwists(wrenches, twists), RECT1)


def test_without_noise_friction_and_dome_come_back_exactly() -> None:
    found = identify([made_block()], PARAMETERS, starts=3)
    assert found.fit.converged and found.starts.arrived == 3
    assert found.values == pytest.approx({**PARTS, **TRUTH}, abs=1e-6)


def test_derivatives_are_slopes_and_the_prediction_the_limit_surfaces_at_any_shape() -> None:
    block, step = made_block(), 1e-3
    values = {
        "friction_scale": -1.3,
        "floor_dome": 0.3,
        "plate_dome": 0.7,
        "plate_warp_x": 0.3,
        "plate_warp_y": 0.2,
    }
    exact = block.residuals(values)[1]
    assert block.parameters == (
        "friction_scale",
        "floor_dome",
        "plate_dome",
        "plate_warp_x",
        "plate_warp_y",
    )
    for column, name in enumerate(block.parameters):
        up, down = (block.residuals({**values, name: values[name] + by})[0] for by in (step, -step))
        assert np.allclose(exact[:, column], (up - down) / (2.0 * step), atol=1e-6)
    expected = wrench(TWISTS, 1.0, EllipseFriction.isotropic(math.exp(-1.3))) - WRENCHES
    assert np.allclose(
        block.residuals(values | PARTS | {"floor_dome": 0.3})[0],
        (expected / SCALE).ravel(),
        atol=1e-10,
    )


def test_the_place_of_contact_is_where_the_force_enters_the_outline() -> None:
    side, along = np.divmod((np.arange(40) + 0.5) / 10.0, 1.0)
    rim = SQUARE.points(4)
    start, end = rim[side.astype(int)], rim[side.astype(int) + 1]
    point, edge = start + along[:, None] * (end - start), (end - start) / 0.09
    inward = np.column_stack([-edge[:, 1], edge[:, 0]])
    force = 2.0 * inward + 0.3 * edge
    torque = point[:, 0] * force[:, 1] - point[:, 1] * force[:, 0]
    data = WrenchTwists(
        np.column_stack([force, torque]), np.column_stack([0.01 * inward, np.zeros(40)])
    )
    assert data.contact_pieces(SQUARE).tolist() == list(range(40))
    missing = WrenchTwists([[1.0, 0.0, 0.2], [0.0, 0.0, 1.0]], [[0.01, 0.0, 0.0], [0.0, 0.0, 0.1]])
    assert missing.contact_pieces(SQUARE).tolist() == [-1, -1]


def test_anisotropy_seen_from_all_around_hardly_moves_the_dome() -> None:
    friction, twist = EllipseFriction(0.2545, 0.2346, 0.0325, 0.0082, 2.6175), made_twists(30, 3)
    measured = np.concatenate([wrench(twist, 0.4, friction, k * math.pi / 6.0) for k in range(12)])
    found = identify([made_block(measured, np.tile(twist, (12, 1)))], PARAMETERS, starts=1)
    assert found["plate_dome"].value == pytest.approx(0.4, abs=0.05)


def pairs_in(path, rho, **wanted):
    """The pairs of the rows that have these texts."""
    rows = known_columns(read_csv_table(path), (*WRENCH_COLUMNS, *TWIST_COLUMNS))
    for key, text in wanted.items():
        rows = rows[rows[key] == text]
    return read_wrench_twists(rows, rho)


def test_rows_of_a_table_are_read_as_they_were_scaled(tmp_path) -> None:
    file = tmp_path / "pairs.csv"
    file.write_text(
        f"{HEADER}\nabs,1.0,0.0,0.5,0.01,0.0,0.004\nplywood,2.0,0.0,0.5,0.01,0.0,0.004\n"
    )
    data = pairs_in(file, 0.06, surface="plywood")
    assert data.wrench.tolist() == [[2.0, 0.0, 0.03]]
    assert np.allclose(data.twist, [[0.01, 0.0, 0.004 / 0.06]])
    sign = f"{HEADER}\nabs,-1,0,-0.5,0.01,0,0.004\n"
    for text, words in ((sign, "turn their signs"), ("fx,fy\n1,2\n", "m_over_rho")):
        file.write_text(text)
        refused(pairs_in, file, 0.06, told=words, kind=DataFileError)


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (
            lambda: WrenchTwists([[1.0, 0.0, 0.0]] * 2, [[0.01, 0.0, 0.0], [0.0, 0.0, 0.0]]),
            "twist 1 is zero",
        ),
        (
            lambda: WrenchTwists([[1.0, 0.0, 0.0]] * 2, [[0.01, 0.0, 0.0]]),
            "2 wrenches and 1 twists",
        ),
    ],
)
def test_pairs_that_cannot_be_used_are_refused(asked, words) -> None:
    refused(asked, told=words)


def test_measured_pairs_ask_for_weight_on_the_rim_on_plywood_and_for_little_on_abs(
    measured_data,
) -> None:
    slider, path = Slider.mit("rect1"), measured_data / "mit_rect1_wrench_twist_v10.csv"
    free, even = {}, {}
    for surface, count in (("plywood", 600), ("abs", 506)):
        data = pairs_in(path, 0.06364, surface=surface, source="HEAD_filtered")
        assert len(data.twist) == count
        assert np.all(np.sum(data.wrench * data.twist, axis=1) > 0.0)
        block = wrench_twist_block(data, slider)
        assert len(np.unique(block.groups)) > 30
        free[surface] = identify([block], PARAMETERS, starts=2, student=4.0, folds=5)
        even[surface] = identify(
            [block], PARAMETERS[:1], {"plate_dome": 0.0}, starts=2, student=4.0, folds=5
        )
    assert free["plywood"]["plate_dome"].lower > max(1.0, free["abs"]["plate_dome"].value)
    for surface, friction, gain in (("plywood", 0.227, 0.8), ("abs", 0.179, 1.05)):
        assert math.exp(free[surface].values["friction_scale"]) == pytest.approx(friction, abs=0.01)
        torque, other = (one[surface].errors[1] for one in (free, even))
        assert (
            torque.kind == "wrench torque over radius (N)"
            and torque.left_out_rms < gain * other.left_out_rms
        )
