"""Table I: the paper's numbers to the digit, and what follows from them by a second route."""

import math

import numpy as np
import pytest
from figure_cases import SCANS, recorded_folder

from cyclemap.figures.catalogue import MeasuredFolder
from cyclemap.figures.materials.tables import (
    FRICTION_HEADER,
    friction_caption,
    friction_ellipses,
    friction_rows,
)
from cyclemap.mechanics import material_names

NAME = "table-friction"


def test_the_plywood_row_is_the_papers(result) -> None:
    first = dict(zip(FRICTION_HEADER, friction_rows(result)[0], strict=True))
    assert (first["material"], first["source"]) == ("plywood", "paper")
    assert [first[name] for name in ("μa", "μb", "m0", "n0")] == [
        "0.2545",
        "0.2346",
        "0.0325",
        "0.0082",
    ]
    assert float(first["φ (°)"]) == pytest.approx(math.degrees(2.6175), abs=0.005)
    assert "φ = 2.6175 rad" in friction_caption(result)


def test_every_built_in_surface_has_a_row_and_wear_has_two(result) -> None:
    assert [row.material for row in result.rows].count("plywood-measured") == 2
    alike = {"isotropic", "plywood-floor", "abs-floor", "unknown"}
    assert {row.material for row in result.rows} == set(material_names()) - alike
    assert (
        all(len(row) == len(FRICTION_HEADER) for row in friction_rows(result))
        and len(result.rows) == 6
    )


def test_derived_numbers_are_those_of_the_traction_in_all_directions(result) -> None:
    """Tractions of opposite slides have the offset for a mean; less it, they lie on the centred
    ellipse's curve.
    """
    angle = np.linspace(0.0, 2 * np.pi, 7200, endpoint=False)
    ways = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    for row in result.rows:
        traction = row.law.traction(ways)
        centre = 0.5 * (traction + row.law.traction(-ways))
        assert np.ptp(centre, axis=0) == pytest.approx(0.0, abs=1e-12)
        x, y = centre[0]
        assert row.anisotropy.offset * row.mean == pytest.approx(math.hypot(x, y))
        assert math.cos(row.anisotropy.offset_direction - math.atan2(y, x)) == pytest.approx(1.0)
        radius = np.hypot(*(traction - centre).T)
        assert row.axis_ratio == pytest.approx(radius.max() / radius.min(), rel=1e-5)
        assert row.mean == pytest.approx(math.sqrt(radius.max() * radius.min()), rel=1e-5)


@pytest.mark.slow
def test_recorded_friction_scans_give_back_the_ellipse_they_were_made_with(
    tmp_path_factory,
) -> None:
    found = friction_ellipses(recorded_folder(tmp_path_factory))
    scanned = [row for row in found.rows if row.source == f"{SCANS} recorded scans"]
    assert [row.surface for row in scanned] == ["plywood"] and found.absent == (
        "abs",
        "delrin",
        "pu",
    )
    assert (scanned[0].mean, scanned[0].axis_ratio, scanned[0].anisotropy.offset) == pytest.approx(
        (found.rows[0].mean, found.rows[0].axis_ratio, found.rows[0].anisotropy.offset), rel=1e-5
    )
    assert "fitted to recorded friction scans on plywood" in friction_caption(found)


def test_the_folder_of_measured_data_holds_no_friction_scans(measured_data) -> None:
    assert friction_ellipses(MeasuredFolder(measured_data)).absent == (
        "plywood",
        "abs",
        "delrin",
        "pu",
    )
