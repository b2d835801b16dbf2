"""Nearly invariant sets of noisy maps: shares, stays and arcs against passages, symmetry and finer
bases.
"""

import numpy as np
import pytest

from cyclemap.maps import (
    CircleMap,
    WrappedCauchy,
    WrappedNormal,
    conjugate,
    fixed_points,
    mean_passage_time,
    transfer_operator,
)

TWO_PI = 2 * np.pi


def wells(deep, tilt, phase=0.0, count=2):
    """A map with ``count`` stable points, their depths told apart by ``tilt``."""
    return CircleMap(
        lambda x: x - deep * np.sin(count * x) + tilt * np.sin(x + phase),
        lambda x: 1 - deep * count * np.cos(count * x) + tilt * np.cos(x + phase),
    )


@pytest.mark.parametrize(
    ("deep", "tilt", "sigma"), [(0.3, 0.05, 0.25), (0.3, 0.05, 0.2), (0.35, 0.03, 0.25)]
)
def test_stays_are_passages_to_the_other_stable_point(deep, tilt, sigma):
    """The mean time from one stable point until the other is reached is the stay, and a little
    longer.
    """
    two_wells = wells(deep, tilt)
    held = transfer_operator(two_wells, WrappedNormal(sigma)).metastable_sets()
    stable = [orbit.points[0] for orbit in fixed_points(two_wells) if orbit.stable]
    assert len(held) == 2 and held[0].share > held[1].share
    for one, other in (held, held[::-1]):
        start = min(stable, key=lambda theta: abs(np.sin((theta - one.peak) / 2)))
        goal = min(stable, key=lambda theta: abs(np.sin((theta - other.peak) / 2)))
        passage = mean_passage_time(
            two_wells, WrappedNormal(sigma), start, (goal + 0.1, goal + TWO_PI - 0.1)
        )
        assert 0.998 * passage < 1 / one.leaving < passage
    assert sum(one.share for one in held) == pytest.approx(
        1.0, abs=sum(one.share.error_bound for one in held)
    )
    # As many paths go one way as the other.
    flows = [one.share * one.leaving for one in held]
    assert flows[0] == pytest.approx(flows[1], rel=2e-3)


def test_equal_wells_hold_equal_shares_on_arcs_that_are_images_of_each_other():
    for count in (2, 3):
        held = transfer_operator(
            wells(0.25, 0.0, count=count), WrappedNormal(0.25)
        ).metastable_sets()
        assert len(held) == count
        for one in held:
            assert one.share.holds(1 / count) and one.share.error_bound < 1e-9
            assert one.leaving.error_bound < 1e-8 * one.leaving
            assert (
                abs(one.leaving - held[0].leaving)
                <= one.leaving.error_bound + held[0].leaving.error_bound
            )
            np.testing.assert_allclose(np.diff(one.arcs), TWO_PI / count, atol=1e-8)
            assert np.sin(count * one.peak / 2) == pytest.approx(0.0, abs=0.05)


def test_sets_turn_with_the_map():
    plain = transfer_operator(wells(0.3, 0.05), WrappedNormal(0.3)).metastable_sets()
    turned = transfer_operator(
        conjugate(wells(0.3, 0.05), 1.0), WrappedNormal(0.3)
    ).metastable_sets()
    assert len(plain) == 2
    for one, other in zip(plain, turned, strict=True):
        assert abs(one.share - other.share) < 1e-9
        assert (
            abs(one.leaving - other.leaving) <= one.leaving.error_bound + other.leaving.error_bound
        )
        assert np.max(np.abs(np.exp(1j * (one.arcs + 1.0)) - np.exp(1j * other.arcs))) < 1e-8


def test_where_noise_soon_connects_everything_nothing_is_held():
    for circle_map, sigma in (
        (CircleMap.arnold(0.1, 0.9), 0.3),
        (CircleMap.arnold(0.15, 0.9), 0.1),
        (wells(0.3, 0.0), 1.5),
    ):
        assert transfer_operator(circle_map, WrappedNormal(sigma)).metastable_sets() == ()
    assert transfer_operator(CircleMap.rigid(0.0), WrappedNormal(0.02)).metastable_sets() == ()


def test_bounds_hold_on_random_wells_with_few_modes_and_with_maps_that_are_off():
    """Chances of leaving with half the modes, and of maps moved within ``max_error``, lie within
    the stated bounds.
    """
    rng, off, judged, compared = np.random.default_rng(5), 1e-5, 0, 0
    for _ in range(10):
        deep, tilt, phase, count = (
            rng.uniform(0.25, 0.4),
            rng.uniform(0.0, 0.1),
            rng.uniform(0, TWO_PI),
            rng.integers(2, 4),
        )
        noise = (
            WrappedNormal(rng.uniform(0.25, 0.4)) if rng.uniform() < 0.8 else WrappedCauchy(0.85)
        )
        circle_map, waves = wells(deep, tilt, phase, count), rng.integers(0, 4)
        full = transfer_operator(circle_map, noise)
        claimed = CircleMap(circle_map, circle_map.derivative, max_error=off)
        moved = CircleMap(
            lambda x, m=circle_map, w=waves: m(x) + off * np.cos(w * x), circle_map.derivative
        )
        truth = {round(one.peak, 1): one.leaving for one in full.metastable_sets()}
        few = transfer_operator(circle_map, noise, modes=max(8, full.modes // 3)).metastable_sets()
        beside = transfer_operator(moved, noise).metastable_sets()
        bounds = transfer_operator(claimed, noise).metastable_sets()
        for one in few:
            error = min(abs(one.leaving - leaving) for leaving in truth.values())
            assert error <= one.leaving.error_bound + max(
                leaving.error_bound for leaving in truth.values()
            )
            judged += 1
        if len(bounds) != len(beside):  # a set at the edge of what counts as held
            continue
        for one, other in zip(bounds, beside, strict=True):
            assert abs(one.leaving - other.leaving) <= 1.01 * one.leaving.error_bound
            compared += 1
    assert judged >= 12 and compared >= 12


def test_with_too_few_modes_for_an_eigenvalue_the_chance_of_leaving_has_no_bound():
    """Where the slow eigenvalues' bounds are infinite, so are those of all states, not nan."""
    three_wells = wells(0.342, 0.002, 1.18, 3)
    few = transfer_operator(three_wells, WrappedNormal(0.28), modes=8)
    held = few.metastable_sets()
    assert len(held) == 3
    assert [state.leaving.error_bound for state in held] == [np.inf] * 3
