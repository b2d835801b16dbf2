"""Table II: the paper's rows as it prints them, and simulated and recorded ones that are their pushes' own."""

import numpy as np
import pytest
from figure_cases import NOWHERE, RECORDED_ABS, SMALL, recorded_folder

from cyclemap.figures.measured_folder import NO_DATA, MeasuredFolder
from cyclemap.figures.simulated_collections import sampled_run
from cyclemap.figures.table_deviations import HEADER, TABLE, caption, compute, rows

# Table II as printed: standard deviation and percentage of Δθ (°), Δx (mm), Δy (mm).
PRINTED = {
    "plywood": ("4.74", "6.86", "2.84", "7.75", "8.57", "9.09"),
    "abs": ("3.21", "4.30", "1.59", "3.97", "5.31", "7.86"),
    "delrin": ("1.28", "1.63", "0.97", "2.49", "3.21", "6.33"),
    "pu": ("4.53", "6.53", "2.93", "7.30", "11.39", "13.40"),
}


@pytest.fixture(scope="module")
def result():
    return compute(NOWHERE, SMALL)


def test_the_papers_rows_are_those_it_prints(result) -> None:
    paper = {row[0]: row for row in rows(result) if row[1] == "paper"}
    assert list(paper) == list(PRINTED)
    for name, printed in PRINTED.items():
        cells = paper[name][3:]
        assert tuple(cell for place, cell in enumerate(cells) if place % 3) == printed
    assert paper["plywood"][3:10:3] == ("69.1", "36.6", "94.3")


def test_simulated_rows_are_the_statistics_of_their_pushes_in_the_papers_signs(result) -> None:
    pushes = sampled_run("pu", SMALL).pushes
    (row,) = [row for row in rows(result) if row[1] == "simulated, pu"]
    assert row[2] == str(SMALL.pushes)
    for place, value in enumerate((np.degrees(pushes.dtheta), 1e3 * pushes.dx, -1e3 * pushes.dy)):
        mean, std = np.mean(value), np.std(value, ddof=1)
        assert row[3 + 3 * place : 6 + 3 * place] == (f"{mean:.1f}", f"{std:.2f}", f"{100 * std / mean:.2f}")


def test_plywood_is_simulated_twice_and_each_row_fills_the_header(result) -> None:
    sources = [row[1] for row in rows(result) if row[0] == "plywood"]
    assert sources == ["paper", "simulated, plywood", "simulated, plywood-measured"]
    assert len(rows(result)) == 9 and {len(row) for row in rows(result)} == {len(HEADER)} == {12}


def test_the_caption_tells_how_far_simulated_rows_lie_from_the_papers(result) -> None:
    told, cells = caption(result), rows(result)
    for place, (name, unit) in enumerate((("Δθ", "°"), ("Δx", " mm"), ("Δy", " mm"))):
        column, offs, shares = 3 + 3 * place, [], []
        for row in cells:
            if row[1] == "paper":
                mean, std = float(row[column]), float(row[column + 1])
            else:
                offs.append(abs(float(row[column]) - mean))
                shares.append(float(row[column + 1]) / std)
        words = told.split(f"means of {name} are within ")[1]
        assert float(words.split(unit)[0]) == pytest.approx(max(offs), abs=0.16)
        low, high = words.split("spreads ")[1].split(" of the paper's")[0].split(" to ")
        assert (float(low), float(high)) == pytest.approx((min(shares), max(shares)), abs=0.011)
    assert told.endswith(f"Recorded pushes on plywood, abs, delrin and pu: {NO_DATA}.")


def test_recorded_pushes_have_a_row(tmp_path_factory) -> None:
    found = compute(recorded_folder(tmp_path_factory), SMALL)
    row = next(row for row in rows(found) if row[:2] == ("abs", "recorded"))
    assert row[2] == str(RECORDED_ABS) and float(row[4]) > 0.0
    assert TABLE.caption(found).endswith(f"Recorded pushes on delrin and pu: {NO_DATA}.")


def test_the_folder_of_measured_data_adds_no_row(measured_data, result) -> None:
    assert rows(compute(MeasuredFolder(measured_data), SMALL)) == rows(result)
