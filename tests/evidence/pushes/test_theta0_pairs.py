"""Measured (θ0, next θ0) pairs: three layouts, every way in which a file can be wrong, and sums of
known pairs.
"""

import pickle
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, strategies as st
from refusals import refused

from cyclemap.errors import DataFileError, DoubtfulInput
from cyclemap.evidence import (
    Theta0Pairs,
    angle_histogram,
    measured_overlay,
    read_theta0_pairs,
    turn_bins,
)
from cyclemap.evidence.laws.turn_bins import covered_arcs, is_covered

HEADER = "rep,theta0_accum_deg,theta0_mod360_deg,dtheta_to_next_deg,flag\n"
STAIRCASE = (
    HEADER
    + "0,350.000,350.000,-20.000,jump\n1,330.000,330.000,40.000,\n"
    + "2,370.000,10.000,5.000,\n3,375.000,15.000,,\n"
)


@pytest.fixture
def csv(tmp_path: Path):
    def write(text: str | bytes) -> Path:
        path = tmp_path / "pushes.csv"
        path.write_bytes(text.encode() if isinstance(text, str) else text)
        return path

    return write


@pytest.fixture
def read(csv):
    """The pairs of a table of this text."""
    return lambda text: read_theta0_pairs(csv(text))


def degrees(values):
    return np.rad2deg(values).round(9).tolist()


def test_staircase_layout_keeps_unflagged_pairs_on_the_unwrapped_path_with_their_numbers(
    read,
) -> None:
    pairs = read(STAIRCASE)
    assert (degrees(pairs.theta), degrees(pairs.theta_next)) == ([330.0, 370.0], [370.0, 375.0])
    assert degrees(pairs.turn) == [40.0, 5.0]
    assert degrees(pairs.path) == [350.0, 330.0, 370.0, 375.0]
    assert (pairs.cycle.tolist(), pairs.path_cycle.tolist()) == ([1.0, 2.0], [0.0, 1.0, 2.0, 3.0])
    assert dict(pairs.dropped) == {"jump": 1}
    copy = pickle.loads(pickle.dumps(pairs))
    assert copy.dropped == pairs.dropped
    assert np.array_equal(copy.theta, pairs.theta) and np.array_equal(copy.path, pairs.path)


def test_a_missing_rep_makes_no_pair_and_breaks_no_path_and_a_path_without_neighbours_stays_whole(
    read,
) -> None:
    """What happened in cycles that were not recorded is unknown, and no sign of a move."""
    text = HEADER + "0,10.0,10.0,5.0,\n1,15.0,15.0,5.0,\n7,90.0,90.0,5.0,\n8,95.0,95.0,,\n"
    pairs = read(text)
    assert degrees(pairs.theta_next) == [15.0, 20.0, 95.0]
    assert pairs.unbroken.path_cycle.tolist() == [0.0, 1.0, 7.0, 8.0]
    apart = read(HEADER + "0,10.0,10.0,5.0,\n7,90.0,90.0,,\n")
    assert apart.unbroken.path.size == 2


def test_two_columns_take_the_shorter_way_round(read) -> None:
    pairs = read("theta0_deg,theta_next_deg\n350,10\n10,350\n100,100\n30,755\n")
    assert degrees(pairs.turn) == [20.0, -20.0, 0.0, 5.0]
    assert (pairs.path, pairs.cycle, pairs.path_cycle) == (None, None, None)


def test_pairs_of_which_each_begins_where_the_one_before_ended_are_in_order(read) -> None:
    """They are what the single column of their beginnings and the last end is; one gap, and nothing
    is known.
    """
    chained = read("theta0_deg,theta_next_deg\n340,355\n-5.004,12\n372,350\n")
    alone = read("theta0_deg\n340\n355\n12\n350\n")
    assert degrees(alone.path) == [340.0, 355.0, 372.0, 350.0]
    assert degrees(alone.turn) == [15.0, 17.0, -22.0]
    assert np.degrees(chained.path) == pytest.approx(np.degrees(alone.path), abs=0.01)
    for pairs in (chained, alone):
        assert pairs.cycle.tolist() == [0.0, 1.0, 2.0]
        assert pairs.path_cycle.tolist() == [0.0, 1.0, 2.0, 3.0]
    assert read("theta0_deg,theta_next_deg\n340,355\n355,12\n12.02,350\n").path is None


def made_chain(jitter_deg: float, moved: tuple[int, ...] = (), rows: int = 60) -> np.ndarray:
    """(rows, 2) degrees: a noisy loop's θ0 and the next, measured with jitter; `moved` begin
    elsewhere.
    """
    random, theta, made = np.random.default_rng(3), 40.0, []
    for row in range(rows):
        theta = random.uniform(0.0, 360.0) if row in moved else theta
        ahead = theta + 9.0 + 6.0 * np.sin(np.deg2rad(theta)) + random.normal()
        made.append([theta, ahead] + jitter_deg * random.normal(size=2))
        theta = ahead
    return np.array(made)


def as_text(pairs: np.ndarray) -> str:
    return "theta0_deg,theta_next_deg\n" + "".join(
        f"{a % 360.0:.4f},{b % 360.0:.4f}\n" for a, b in pairs
    )


def test_a_chain_measured_twice_with_jitter_is_in_order_and_its_path_that_of_the_beginnings(
    read,
) -> None:
    made = made_chain(0.2)
    pairs = read(as_text(made))
    along = np.rad2deg(pairs.path[:-1] - pairs.path[0])
    assert np.allclose(along, made[:, 0] - made[0, 0], atol=1e-3)
    assert np.allclose(np.rad2deg(pairs.turn), made[:, 1] - made[:, 0], atol=1e-3)
    assert pairs.unbroken.path.size == pairs.path.size == 61


def test_an_object_moved_by_hand_is_told_and_the_longest_run_is_between_two_moves(read) -> None:
    with pytest.warns(DoubtfulInput, match="2 of 60 pairs do not begin where the one before ended"):
        pairs = read(as_text(made_chain(0.2, moved=(12, 47))))
    assert pairs.path.size == 61 and pairs.theta.size == pairs.unbroken.theta.size == 60
    assert pairs.unbroken.path_cycle.tolist() == list(range(12, 47))


def test_turns_by_hand_among_orientations_alone_make_no_pairs_and_break_the_path(read) -> None:
    """Few of them: of one in ten nobody knows which turns are the map's."""

    def read_moved(moved: tuple[int, ...]) -> Theta0Pairs:
        theta = made_chain(0.2, moved, 300)[:, 0] % 360.0
        return read("theta0_deg\n" + "".join(f"{angle:.4f}\n" for angle in theta))

    with pytest.warns(DoubtfulInput, match="turns behind pushes 119, 209 .* moved by hand"):
        pairs = read_moved((120, 210))
    assert pairs.moved == (119.0, 209.0) and dict(pairs.dropped) == {"moved by hand": 2}
    assert np.setdiff1d(np.arange(299.0), pairs.cycle).tolist() == [119.0, 209.0]
    assert pairs.unbroken.path_cycle.tolist() == list(range(120))
    assert read_moved(tuple(range(5, 300, 10))).moved == ()


def test_an_arc_over_0_ends_beyond_its_begin_and_holds_what_lies_on_both_sides() -> None:
    measured = np.deg2rad([350.0, 5.0, 12.0, 100.0, 118.0])
    arcs = covered_arcs(measured)
    assert np.rad2deg(arcs).ravel() == pytest.approx([100.0, 118.0, 350.0, 372.0])
    inside = is_covered(measured, np.deg2rad([-9.0, 0.0, 11.0, 360.0, 110.0, 40.0, 200.0, 345.0]))
    assert inside.tolist() == [True] * 5 + [False] * 3


@pytest.mark.parametrize("seed", range(5))
def test_neither_shuffled_pairs_nor_a_sweep_over_theta0_are_taken_for_a_chain(read, seed) -> None:
    random = np.random.default_rng(seed)
    shuffled = random.permutation(made_chain(0.0))
    theta = np.sort(random.uniform(0.0, 360.0, 60))
    ahead = theta + 9.0 + 6.0 * np.sin(np.deg2rad(theta)) + random.normal(size=60)
    sweep = np.column_stack([theta, ahead])
    even = sweep - theta[:, None] + 6.0 * np.arange(60)[:, None]
    for made in (shuffled, sweep, even):
        assert read(as_text(made)).path is None


def test_byte_order_mark_crlf_blanks_and_capitals_are_harmless(read) -> None:
    pairs = read(b"\xef\xbb\xbfTheta0_deg, Theta_next_deg\r\n 1 , 2 \r\n\r\n")
    assert degrees(pairs.theta_next) == [2.0]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("", "the file is empty"),
        ("\n\n", "the file is empty"),
        ("theta0_deg,theta_next_deg\n", "line 1: a header but no rows"),
        ("angle,next\n1,2\n", "line 1: the header is angle,next; it must be rep,theta0_accum_deg"),
        ("rep,theta0_accum_deg\n1,2\n", "theta0_mod360_deg, dtheta_to_next_deg, flag is missing"),
        ("theta_next_deg\n1\n", "line 1: column theta0_deg is missing"),
        ("theta0_deg,theta_next_deg\n1,2\n3,four\n", "line 3: theta_next_deg is 'four'"),
        ("theta0_deg,theta_next_deg\n1,2\nnan,4\n", "line 3: theta0_deg is 'nan'"),
        ("theta0_deg,theta_next_deg\n1,inf\n", "line 2: theta_next_deg is 'inf'"),
        ("theta0_deg,theta_next_deg\n1,2\n3,\n", "line 3: theta_next_deg is ''"),
        ("theta0_deg,theta_next_deg\n1,2\n3", "line 3: 1 of 2 fields; the line is cut off"),
        ("theta0_deg,theta_next_deg\n1,2,3\n", "line 2: 3 of 2 fields"),
        ("theta0_deg\n12\n", "line 2: a single θ0 makes no pair"),
        (
            "theta0_deg,theta0_next_deg\n1,2\n3,4\n",
            "has theta0_next_deg beside theta0_deg: name it",
        ),
        ("theta_nxt_deg,theta0_deg\n1,2\n3,4\n", "has theta_nxt_deg beside theta0_deg: name it"),
        (b"theta0_deg\n\xff\xfe\n", "byte 11 is not UTF-8"),
        ('theta0_deg\n"1\n2\n', "mend the quotes"),
        (HEADER + "0,10,10,5,jump\n1,15,15,,\n", "line 3: no row without a flag"),
        (
            HEADER + "0,10,10,5,\n1,16,16,,\n",
            "line 2: dtheta_to_next_deg is 5, the next row says 6",
        ),
        (HEADER + "0,10,10,5,\n1,15,25,,\n", "theta0_mod360_deg disagree (15 and 25)"),
        (HEADER + "0,10,10,5,\n1,15,15\n", "line 3: 3 of 5 fields"),
        (
            HEADER + "0,10,10,5,\n1,15,15,5,\n",
            "line 3: the last row has a next θ0: the file is cut",
        ),
    ],
)
def test_bad_file_is_refused_by_name_and_line(csv, text, said) -> None:
    path = csv(text)
    with pytest.raises(DataFileError) as refusal:
        read_theta0_pairs(path)
    assert str(path) in str(refusal.value) and said in str(refusal.value)


def test_absent_file_and_folder_are_refused(tmp_path: Path) -> None:
    absent = tmp_path / "none.csv"
    refused(read_theta0_pairs, absent, told="there is no such file", kind=DataFileError)
    refused(read_theta0_pairs, tmp_path, told="cannot be read", kind=DataFileError)


@pytest.mark.parametrize(
    ("theta", "theta_next", "numbers", "match"),
    [
        ([], [], {}, "two equally long lists"),
        ([1.0], [1.0, 2.0], {}, "two equally long lists"),
        ([np.nan], [1.0], {}, "not finite"),
        ([1.0], [np.inf], {}, "not finite"),
        (
            [0.0, 1.0],
            [0.0, 1.0],
            {"cycle": [0.0]},
            r"cycle has shape \(1,\) for angles of shape \(2",
        ),
        ([0.0, 1.0], [0.0, 1.0], {"cycle": [0.0, np.nan]}, r"cycle has shape \(2,\)"),
        ([0.0, 1.0], [0.0, 1.0], {"path_cycle": [0.0, 1.0]}, "path_cycle has shape"),
    ],
)
def test_pairs_that_are_none_are_refused(theta, theta_next, numbers, match) -> None:
    numbers = {name: np.array(given) for name, given in numbers.items()}
    refused(Theta0Pairs, np.array(theta), np.array(theta_next), told=match, **numbers)


def test_measured_plywood_cut_in_the_middle_of_a_line_is_refused(measured_data: Path, csv) -> None:
    whole = (measured_data / "plywood_rect1_theta0_2000.csv").read_bytes()
    for cut in range(len(whole) // 2, len(whole) // 2 + 60):
        refused(read_theta0_pairs, csv(whole[:cut]), told="cut off", kind=DataFileError)


TURN = 2 * np.pi


def turn(theta):
    return 0.1 + 0.05 * np.sin(2 * theta) - 0.02 * np.cos(theta)


def noisy_pairs(sigma: float, count: int = 20_000) -> Theta0Pairs:
    random = np.random.default_rng(7)
    theta = random.uniform(-TURN, 3 * TURN, count)
    return Theta0Pairs(theta, theta + turn(theta) + sigma * random.standard_normal(count))


def test_bin_medians_follow_the_map_and_shrug_off_outliers() -> None:
    pairs = noisy_pairs(1e-4)
    spoiled = pairs.theta_next.copy()
    spoiled[::10] += 3.0
    bins = turn_bins(Theta0Pairs(pairs.theta, spoiled))
    assert bins.centre.size == 72
    # A tenth of outliers shifts a median within the spread of the turn over its bin: slope 0.12, 5
    # degrees.
    assert np.abs(bins.median - turn(bins.centre)).max() < 0.12 * np.deg2rad(2.5)


def test_bins_with_few_pairs_are_left_out() -> None:
    theta = np.deg2rad([1.0, 2.0, 3.0, 100.0, 101.0])
    bins = turn_bins(Theta0Pairs(theta, theta + 0.1), bins=36)
    assert np.rad2deg(bins.centre).round(9).tolist() == [5.0] and bins.count.tolist() == [3]


@given(st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=50), st.integers(1, 100))
def test_histogram_is_a_density_for_any_angles(theta, bins) -> None:
    histogram = angle_histogram(np.array(theta), bins)
    assert (histogram.density >= 0).all()
    assert np.sum(histogram.density * np.diff(histogram.edges)) == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize(
    ("angle", "index"), [(0.0, 0), (-1e-20, 7), (TURN - 1e-12, 7), (np.pi, 4), (-0.1, 7)]
)
def test_histogram_counts_an_angle_in_its_own_bin(angle, index) -> None:
    assert np.flatnonzero(angle_histogram(np.array([angle]), 8).density).tolist() == [index]


def test_empty_histogram_and_no_bins_are_refused() -> None:
    refused(angle_histogram, np.array([]), told="at least one")
    refused(angle_histogram, np.array([1.0]), 0, told="bins must be at least 1")


def test_an_overlay_measures_a_constant_offset_exactly() -> None:
    pairs = noisy_pairs(0.0)
    overlay = measured_overlay(pairs, lambda theta: turn(theta) - 0.03)
    assert (overlay.agreement.pairs, overlay.agreement.bins) == (20_000, 72)
    assert overlay.agreement.rms == pytest.approx(0.03, abs=1e-12)
    assert overlay.agreement.bin_rms == pytest.approx(0.03, abs=1e-3)
    assert np.array_equal(overlay.bins.median, turn_bins(pairs).median)
    assert np.array_equal(overlay.histogram.density, angle_histogram(pairs.theta).density)
