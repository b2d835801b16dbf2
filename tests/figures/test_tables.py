"""Tables I to III: the paper's numbers as printed, what follows from them by a second route, and
simulated and recorded rows that are their pushes' own.
"""

import math

import numpy as np
import pytest
from figure_cases import RECORDED_ABS, SCANS, SMALL, exhibited, recorded_folder

from cyclemap.figures import NO_DATA, MeasuredFolder, load_exhibit
from cyclemap.figures.repeated_pushes import sampled_run
from cyclemap.figures.tables import (
    FRICTION_HEADER,
    friction_caption,
    friction_ellipses,
    friction_rows,
)
from cyclemap.mechanics import material_names

# As printed, of Δθ (°), Δx (mm), Δy (mm): standard deviation and percentage in Table II, RMSE and
# percentage in III.
SPREADS = {
    "plywood": ("4.74", "6.86", "2.84", "7.75", "8.57", "9.09"),
    "abs": ("3.21", "4.30", "1.59", "3.97", "5.31", "7.86"),
    "delrin": ("1.28", "1.63", "0.97", "2.49", "3.21", "6.33"),
    "pu": ("4.53", "6.53", "2.93", "7.30", "11.39", "13.40"),
}
ERRORS = {
    "plywood": ("2.07", "2.99", "0.91", "2.46", "3.39", "3.66"),
    "abs": ("2.99", "4.00", "1.56", "3.88", "3.21", "4.75"),
    "delrin": ("1.28", "1.63", "0.81", "2.07", "1.61", "3.08"),
    "pu": ("1.14", "1.64", "0.60", "1.49", "1.56", "1.86"),
}
DEVIATIONS, LAW_ERRORS = load_exhibit("table-deviations"), load_exhibit("table-law-errors")
ellipses = exhibited("table-friction")
deviations = exhibited("table-deviations")
errors = exhibited("table-law-errors")


def test_the_papers_rows_are_those_it_prints(deviations, errors) -> None:
    """Every row fills the header; three cells a quantity, of which the printed two come after a
    mean, or first.
    """
    for table, result, printed, free in (
        (DEVIATIONS, deviations, SPREADS, 0),
        (LAW_ERRORS, errors, ERRORS, 2),
    ):
        told = table.rows(result)
        paper = {row[0]: row[3:] for row in told if row[1] == "paper"}
        assert list(paper) == list(printed)
        for name, cells in paper.items():
            shown = [cell for place, cell in enumerate(cells) if place % 3 != free]
            assert shown == list(printed[name])
        assert len(told) == 9 and {len(row) for row in told} == {len(table.header)} == {12}
    (plywood,) = [row for row in DEVIATIONS.rows(deviations) if row[:2] == ("plywood", "paper")]
    assert plywood[3:10:3] == ("69.1", "36.6", "94.3")


@pytest.mark.parametrize("table", [DEVIATIONS, LAW_ERRORS])
def test_recorded_pushes_have_a_row_of_their_own(tmp_path_factory, table) -> None:
    found = table.compute(recorded_folder(tmp_path_factory), SMALL)
    (row,) = [row for row in table.rows(found) if row[:2] == ("abs", "recorded")]
    assert row[2] == str(RECORDED_ABS) and row[3] != ""
    # A law explains pushes without noise to the last digit; their spread stays.
    assert (float(row[4]) > 0.0) == (table is DEVIATIONS)
    assert table.caption(found).endswith(f"Recorded pushes on delrin and pu: {NO_DATA}.")


def test_simulated_rows_are_the_statistics_of_their_pushes_in_the_papers_signs(deviations) -> None:
    pushes = sampled_run("pu", SMALL).pushes
    (row,) = [row for row in DEVIATIONS.rows(deviations) if row[1] == "simulated, pu"]
    assert row[2] == str(SMALL.pushes)
    for place, value in enumerate((np.degrees(pushes.dtheta), 1e3 * pushes.dx, -1e3 * pushes.dy)):
        mean, std = np.mean(value), np.std(value, ddof=1)
        told = f"{mean:.1f} {std:.2f} {100 * std / mean:.2f}"
        assert " ".join(row[3 + 3 * place : 6 + 3 * place]) == told


def test_simulated_errors_are_the_residuals_of_the_laws_less_than_half_the_papers_of_dtheta(
    errors,
) -> None:
    """But on plywood, whose law is of one harmonic over pushes that wear: what it leaves is no
    scatter alone. On pu the scatter of friction explains Δy.
    """
    rows = [row for row in LAW_ERRORS.rows(errors) if row[1].startswith("simulated")]
    found = [
        (each.published, source, laws)
        for each, sets in errors
        for source, laws in sets
        if source != "recorded"
    ]
    assert len(found) == 5
    for row, (published, source, laws) in zip(rows, found, strict=True):
        assert row[1] == source
        for place, (law, unit) in enumerate(zip(laws, (180 / np.pi, 1e3, 1e3), strict=True)):
            off = unit * np.sqrt(np.mean((law.value - law.law(law.theta)) ** 2))
            assert row[3 + 3 * place] == f"{off:.2f}"
            assert row[5 + 3 * place] == str(law.law.harmonics)
        if source != "simulated, plywood":
            is_explained = laws[0].law.rmse < 0.5 * published.rmse[0]
            assert is_explained == (published.material != "plywood")
    assert published.material == "pu"
    assert laws[2].law.rmse == pytest.approx(published.rmse[2], rel=0.2)


def test_the_plywood_row_is_the_papers(ellipses) -> None:
    first = dict(zip(FRICTION_HEADER, friction_rows(ellipses)[0], strict=True))
    assert (first["material"], first["source"]) == ("plywood", "paper")
    printed = {"μa": "0.2545", "μb": "0.2346", "m0": "0.0325", "n0": "0.0082"}
    assert {**first, **printed} == first
    assert float(first["φ (°)"]) == pytest.approx(math.degrees(2.6175), abs=0.005)
    assert "φ = 2.6175 rad" in friction_caption(ellipses)


def test_every_built_in_surface_has_a_row_and_wear_has_two(ellipses) -> None:
    assert [row.material for row in ellipses.rows].count("plywood-measured") == 2
    alike = {"isotropic", "plywood-floor", "abs-floor", "unknown"}
    assert {row.material for row in ellipses.rows} == set(material_names()) - alike
    assert {len(row) for row in friction_rows(ellipses)} == {len(FRICTION_HEADER)}
    assert len(ellipses.rows) == 6


def test_derived_numbers_are_those_of_the_traction_in_all_directions(ellipses) -> None:
    """Tractions of opposite slides have the offset for a mean; less it, they lie on the centred
    ellipse's curve.
    """
    angle = np.linspace(0.0, 2 * np.pi, 7200, endpoint=False)
    ways = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    for row in ellipses.rows:
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
    (scanned,) = [row for row in found.rows if row.source == f"{SCANS} recorded scans"]
    assert scanned.surface == "plywood" and found.absent == ("abs", "delrin", "pu")
    fitted, table = (
        (row.mean, row.axis_ratio, row.anisotropy.offset) for row in (scanned, found.rows[0])
    )
    assert fitted == pytest.approx(table, rel=1e-5)
    assert "fitted to recorded friction scans on plywood" in friction_caption(found)


def test_the_folder_of_measured_data_holds_no_friction_scans(measured_data) -> None:
    absent = friction_ellipses(MeasuredFolder(measured_data)).absent
    assert absent == ("plywood", "abs", "delrin", "pu")
