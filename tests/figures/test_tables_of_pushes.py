"""Tables II and III: the paper's rows as printed, and simulated and recorded ones that are their
pushes' own.
"""

import numpy as np
import pytest
from figure_cases import RECORDED_ABS, SMALL, recorded_folder, small

from cyclemap.figures.catalogue import NO_DATA, load_exhibit
from cyclemap.figures.materials.simulated_collections import sampled_run

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
both = pytest.mark.parametrize("table", [DEVIATIONS, LAW_ERRORS])


@pytest.fixture(scope="module")
def deviations():
    return small("table-deviations")


@pytest.fixture(scope="module")
def errors():
    return small("table-law-errors")


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
            assert (
                tuple(cell for place, cell in enumerate(cells) if place % 3 != free)
                == printed[name]
            )
        assert len(told) == 9 and {len(row) for row in told} == {len(table.header)} == {12}
    (plywood,) = [row for row in DEVIATIONS.rows(deviations) if row[:2] == ("plywood", "paper")]
    assert plywood[3:10:3] == ("69.1", "36.6", "94.3")


@both
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
        assert row[3 + 3 * place : 6 + 3 * place] == (
            f"{mean:.1f}",
            f"{std:.2f}",
            f"{100 * std / mean:.2f}",
        )


def simulated_laws(errors):
    """Published statistics, and source and laws of each simulated set."""
    return [
        (each.published, source, laws)
        for each, sets in errors
        for source, laws in sets
        if source != "recorded"
    ]


def test_simulated_errors_are_the_residuals_of_the_laws(errors) -> None:
    cells = [row for row in LAW_ERRORS.rows(errors) if row[1].startswith("simulated")]
    found = simulated_laws(errors)
    assert len(found) == 5
    for row, (_, source, laws) in zip(cells, found, strict=True):
        assert row[1] == source
        for place, (one, unit) in enumerate(zip(laws, (180 / np.pi, 1e3, 1e3), strict=True)):
            off = unit * np.sqrt(np.mean((one.value - one.law(one.theta)) ** 2))
            assert row[3 + 3 * place] == f"{off:.2f}"
            assert row[5 + 3 * place] == str(one.law.harmonics)


def test_scatter_of_friction_explains_dy_on_pu_and_less_than_half_of_dtheta_but_on_plywood(
    errors,
) -> None:
    """Of plywood the law is of one harmonic over pushes that wear: what it leaves is no scatter
    alone.
    """
    _, *found = simulated_laws(errors)
    for published, _, laws in found:
        assert (laws[0].law.rmse < 0.5 * published.rmse[0]) == (published.material != "plywood")
    pu, _, law = found[-1]
    assert pu.material == "pu" and law[2].law.rmse == pytest.approx(pu.rmse[2], rel=0.2)
