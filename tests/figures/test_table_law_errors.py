"""Table III: the paper's errors as printed, and simulated and recorded ones that are the residuals of their laws."""

import numpy as np
import pytest
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.table_law_errors import HEADER, TABLE, caption, compute, rows, simulated_laws

# Table III as printed: RMSE and percentage of Δθ (°), Δx (mm), Δy (mm).
PRINTED = {
    "plywood": ("2.07", "2.99", "0.91", "2.46", "3.39", "3.66"),
    "abs": ("2.99", "4.00", "1.56", "3.88", "3.21", "4.75"),
    "delrin": ("1.28", "1.63", "0.81", "2.07", "1.61", "3.08"),
    "pu": ("1.14", "1.64", "0.60", "1.49", "1.56", "1.86"),
}


@pytest.fixture(scope="module")
def result():
    return compute(NOWHERE, SMALL)


def test_the_papers_rows_are_those_it_prints(result) -> None:
    paper = {row[0]: row[3:] for row in rows(result) if row[1] == "paper"}
    assert list(paper) == list(PRINTED)
    for name, printed in PRINTED.items():
        assert tuple(cell for place, cell in enumerate(paper[name]) if place % 3 < 2) == printed
    assert all(len(row) == len(HEADER) == 12 for row in rows(result)) and len(rows(result)) == 9


def test_simulated_errors_are_the_residuals_of_the_laws(result) -> None:
    cells = iter([row for row in rows(result) if row[1].startswith("simulated")])
    checked = 0
    for laws in result.laws:
        for one in simulated_laws(laws):
            row = next(cells)
            for place, (found, unit) in enumerate(zip(one.laws, (180 / np.pi, 1e3, 1e3), strict=True)):
                off = unit * np.sqrt(np.mean((found.value - found.law(found.theta)) ** 2))
                assert row[3 + 3 * place] == f"{off:.2f}"
                assert row[5 + 3 * place] == str(found.law.harmonics)
                checked += 1
    assert checked == 15


def test_scatter_of_friction_explains_dy_on_pu_and_less_than_half_of_dtheta_but_on_plywood(result) -> None:
    """Of plywood the law is of one harmonic over pushes that wear: what it leaves is no scatter alone."""
    for each, laws in zip(result.materials, result.laws, strict=True):
        law = simulated_laws(laws)[-1]
        assert (law.dtheta.law.rmse < 0.5 * each.published.rmse[0]) == (each.surface != "plywood")
    pu = simulated_laws(result.laws[3])[-1]
    assert pu.dy.law.rmse == pytest.approx(result.materials[3].published.rmse[2], rel=0.2)


def test_the_caption_tells_each_simulated_error_beside_the_papers(result) -> None:
    told = caption(result)
    last = {row[0]: row for row in rows(result) if row[1].startswith("simulated")}
    for name, printed in PRINTED.items():
        for place, value in enumerate(printed[::2]):
            assert f"{last[name][3 + 3 * place]} of {value} on {name}" in told
    assert told.endswith(f"Recorded pushes on plywood, abs, delrin and pu: {NO_DATA}.")


def test_recorded_pushes_have_a_row_of_their_own_laws(tmp_path_factory) -> None:
    found = compute(recorded_folder(tmp_path_factory), SMALL)
    (row,) = [row for row in rows(found) if row[:2] == ("abs", "recorded")]
    assert row[2] == str(RECORDED_ABS) and row[3] != ""
    assert TABLE.caption(found).endswith(f"Recorded pushes on delrin and pu: {NO_DATA}.")


def test_the_folder_of_measured_data_adds_no_row(measured_data, result) -> None:
    assert rows(compute(MeasuredFolder(measured_data), SMALL)) == rows(result)
