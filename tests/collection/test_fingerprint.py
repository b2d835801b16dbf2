"""Five numbers of the protocol: exact, as good a prediction as they say; what has no prediction is
refused by name.
"""

import math
import pickle
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection import (
    Anisotropy,
    CollectionLoop,
    Fingerprint,
    Prediction,
    TurnResponse,
    check_prediction,
    fingerprint,
    predict,
)
from cyclemap.collection.fingerprint_prediction import (
    DRIFTS,
    LOCKS,
    UNDECIDED,
    first_order_lock_in,
    full_lock_in,
    lock_in_boundary,
)
from cyclemap.collection.loop_surfaces import MOST_ELLIPTICITY, with_anisotropy, with_bow
from cyclemap.errors import ConvergenceError
from cyclemap.maps import CircleMap, fixed_points
from cyclemap.mechanics import EllipseFriction
from cyclemap.protocol import loop_from_settings

ANGLES = 2.0 * np.pi * np.arange(16) / 16
PROTOCOLS = {
    "MIT": {},
    "hexagon with pin friction": {"shape": "hex", "pin_friction_mm": 1.0},
}


@pytest.fixture(scope="module")
def plywood():
    return CollectionLoop.mit(material="plywood")


@pytest.fixture(scope="module")
def mit(plywood):
    return fingerprint(plywood)


@pytest.fixture(scope="module")
def prediction(plywood, mit):
    return predict(mit, Anisotropy.of(plywood.material.friction))


def full_turns(loop, surface, angles=ANGLES):
    return with_anisotropy(loop, surface).next_theta(angles) - angles


def test_an_anisotropy_gives_back_its_ellipse_whatever_its_axes_are_called() -> None:
    """The same ellipse with axes exchanged, φ turned by a half turn, or all coefficients doubled
    has one anisotropy.
    """
    given = EllipseFriction(0.3, 0.2, 0.04, -0.03, 0.7)
    seen = Anisotropy.of(given).seen_from(0.3)
    quarter = EllipseFriction(0.2, 0.3, -0.03, -0.04, 0.7 + np.pi / 2)
    half = EllipseFriction(0.3, 0.2, -0.04, 0.03, 0.7 + np.pi)
    for same in (quarter, half, EllipseFriction(0.6, 0.4, 0.08, -0.06, 0.7)):
        assert Anisotropy.of(same).seen_from(0.3) == pytest.approx(seen, abs=1e-15)
    back = Anisotropy.of(given).friction(math.sqrt(0.06))
    values = [(law.mu_a, law.mu_b, law.m0, law.n0, law.phi) for law in (back, given)]
    assert values[0] == pytest.approx(values[1], abs=1e-15)
    assert Anisotropy.of_components(
        Anisotropy.of(given).seen_from(0.0)
    ).friction().phi == pytest.approx(0.7)


@pytest.mark.parametrize("name", PROTOCOLS)
def test_differences_of_whole_cycles_over_sixteen_orientations_have_the_fingerprints_harmonics(
    name,
) -> None:
    """The second route: the answer to an offset is a pure first harmonic, to an ellipticity a pure
    second one.
    """
    loop = loop_from_settings(PROTOCOLS[name])
    found, step, psi, phi = fingerprint(loop).cycle, 5e-4, 0.4, 1.1
    cases = (
        (1, psi, found.offset_amplitude, found.offset_phase),
        (2, phi, found.ellipse_amplitude, found.ellipse_phase),
    )
    for harmonic, direction, amplitude, phase in cases:
        size = np.array([step, 0.0]) if harmonic == 1 else np.array([0.0, step])
        plus = full_turns(loop, Anisotropy(size[0], psi, size[1], phi))
        minus = full_turns(loop, Anisotropy(size[0], psi + np.pi, size[1], phi + np.pi / 2))
        modes = np.fft.rfft((plus - minus) / (2.0 * step)) / 8.0
        expected = amplitude * np.exp(-1j * (harmonic * direction + phase))
        assert modes[harmonic] == pytest.approx(expected, abs=2e-4 * (1.0 + amplitude))
        assert np.abs(np.delete(modes, harmonic)).max() < 2e-4 * (1.0 + amplitude)


def test_the_fingerprint_belongs_to_the_protocol_not_to_the_surface(mit) -> None:
    """Another material under the same protocol has the same numbers; its parts add."""
    other = fingerprint(CollectionLoop.mit(material="isotropic"))
    for one, two in ((mit.cycle, other.cycle), (mit.push, other.push)):
        assert one.turn == two.turn and np.array_equal(one.gradient, two.gradient)
    assert mit.cycle.gradient == pytest.approx(mit.push.gradient + mit.drag.gradient)
    assert mit.cycle.turn == mit.push.turn + mit.drag.turn


def test_the_error_of_the_turn_falls_with_the_square_of_the_anisotropy(plywood, mit) -> None:
    """From plywood itself to a 32nd: slope 2 overall; and with the cube when the second order is
    taken along.
    """
    surface = Anisotropy.of(plywood.material.friction)
    scales = 2.0 ** -np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0])
    errors = []
    for scale in scales:
        scaled = predict(mit, surface.scaled(scale))
        full = full_turns(plywood, scaled.anisotropy)
        laws = scaled.turn(ANGLES), scaled.second_order_turn(ANGLES)
        errors.append([np.abs(full - law).max() for law in laws])
    first, second = np.array(errors).T
    assert np.polyfit(np.log(scales), np.log(first), 1)[0] == pytest.approx(2.0, abs=0.25)
    assert np.polyfit(np.log(scales[3:]), np.log(first[3:]), 1)[0] == pytest.approx(2.0, abs=0.1)
    assert np.log2(second[4] / second[5]) == pytest.approx(3.0, abs=0.3)


def test_plywoods_directions_lie_within_the_error_that_is_stated(plywood, prediction) -> None:
    """The exact patch's own: 63.168° stable and 199.876° unstable;
    the second order comes nearer."""
    truth = {True: 63.168, False: 199.876}
    assert sorted(direction.stable for direction in prediction.directions) == [False, True]
    for direction in prediction.directions:
        miss = abs(math.degrees(direction.theta) - truth[direction.stable])
        assert miss <= math.degrees(direction.error) < 90.0
        assert (
            abs(math.degrees(direction.second_order.points[0]) - truth[direction.stable])
            < 0.5 * miss
        )
    assert prediction.verdict == LOCKS and prediction.trusted
    again = pickle.loads(pickle.dumps(prediction))
    assert again.directions[0].theta == prediction.directions[0].theta
    checked = check_prediction(prediction, plywood, tolerance=1e-4)
    assert len(checked.directions) == 2 and all(
        direction.within_error for direction in checked.directions
    )
    assert math.degrees(checked.stable_points[0].points[0]) == pytest.approx(63.168, abs=0.02)
    assert math.degrees(checked.directions[0].miss) == pytest.approx(3.77, abs=0.05)


def test_most_random_surfaces_lie_within_their_errors_and_no_verdict_is_wrong(plywood, mit) -> None:
    """Where a verdict is given the full map agrees; of the directions at least nine in ten are
    within their errors.
    """
    rng = np.random.default_rng(5)
    angles = 2.0 * np.pi * np.arange(24) / 24
    held, decided = [], 0
    coarse = replace(plywood, accuracy=1e-6)
    for _ in range(8):
        surface = Anisotropy(
            rng.uniform(0, 0.15), rng.uniform(0, 7), rng.uniform(0, 0.08), rng.uniform(0, 7)
        )
        predicted = predict(mit, surface)
        zeros = falling_zeros(full_turns(coarse, surface, angles))
        if predicted.verdict != UNDECIDED:
            assert (predicted.verdict == LOCKS) == bool(zeros)
            decided += 1
        for direction in predicted.stable_directions:
            away = [abs(math.remainder(zero - direction.theta, 2.0 * np.pi)) for zero in zeros]
            held.append(min(away, default=np.inf) <= direction.error)
    assert decided >= 5 and len(held) >= 5
    assert np.mean(held) >= 0.9


def falling_zeros(turn):
    """Where the trigonometric interpolant of a turn over equal steps falls through zero."""
    fine = np.fft.irfft(np.fft.rfft(turn), 2400) * 2400 / turn.size
    falls = np.flatnonzero((fine > 0.0) & (np.roll(fine, -1) <= 0.0))
    return (2.0 * np.pi / 2400 * (falls + 0.5)).tolist()


def test_surfaces_without_a_direction_drift_and_one_too_anisotropic_for_a_first_order_law_says_so(
    mit,
) -> None:
    """Isotropic ones by Ω, weak ones slower, slowest where their turn is least."""
    nothing = predict(mit, Anisotropy(0.0, 0.0, 0.0, 0.0))
    assert nothing.directions == () and nothing.verdict == DRIFTS and nothing.trusted
    assert nothing.mean_turn == pytest.approx(mit.cycle.turn, abs=1e-12)
    assert nothing.lock_in.scale == np.inf and nothing.lock_in_range == (np.inf, np.inf)
    weak = predict(mit, Anisotropy(0.03, 1.0, 0.01, 0.5))
    least = float(weak.turn(weak.slowest))
    assert (
        weak.directions == ()
        and weak.verdict == DRIFTS
        and 0.0 < least < weak.mean_turn < mit.cycle.turn
    )
    assert least == pytest.approx(weak.turn(np.linspace(0, 7, 3000)).min(), abs=1e-5)
    strong = predict(mit, EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7))
    assert strong.anisotropy == Anisotropy.of(EllipseFriction(0.35, 0.18, 0.05, -0.03, 0.7))
    assert not strong.trusted and strong.verdict == UNDECIDED and strong.ratio > 1.0


def test_fixed_points_appear_exactly_at_the_predicted_scale(mit) -> None:
    """Just below none, just above a pair; for one harmonic at |Ω| = X, for two beyond."""
    rays = np.radians([0.0, 20.0, 55.0, 90.0])
    edge = lock_in_boundary(mit.cycle, 0.4, 2.0, rays)
    assert edge[0] == pytest.approx([mit.cycle.turn / mit.cycle.offset_amplitude, 0.0], abs=1e-15)
    assert edge[-1] == pytest.approx([0.0, mit.cycle.turn / mit.cycle.ellipse_amplitude], abs=1e-15)
    for offset, ellipticity in edge:
        surface = Anisotropy(offset, 0.4, ellipticity, 2.0)
        assert first_order_lock_in(mit.cycle, surface).scale == pytest.approx(1.0, abs=1e-12)
        assert fixed_points(predict(mit, surface.scaled(1.0 - 1e-6)).map) == []
        assert len(fixed_points(predict(mit, surface.scaled(1.0 + 1e-6)).map)) in (2, 4)


def test_the_edge_of_lock_in_is_off_by_the_square_of_the_anisotropy_it_takes(plywood) -> None:
    """Rings further out make Ω smaller and so the edge nearer: its error falls with the square,
    within its range.
    """
    surface, (x, y) = Anisotropy.of(plywood.material.friction), plywood.slider.hitch
    scales, errors = [], []
    for lever in (1.3, 1.38):
        loop = replace(
            plywood, accuracy=1e-7, slider=replace(plywood.slider, hitch=(lever * x, lever * y))
        )
        predicted = predict(fingerprint(loop), surface)
        full = full_lock_in(loop, surface, predicted.lock_in)
        low, high = predicted.lock_in_range
        assert low < full.scale < high and low < predicted.lock_in.scale < high
        scales.append(predicted.lock_in.scale)
        errors.append(abs(full.scale - predicted.lock_in.scale))
    assert np.log(errors[0] / errors[1]) / np.log(scales[0] / scales[1]) == pytest.approx(
        2.0, abs=0.2
    )


RESPONSE = TurnResponse(0.1, [2.0, 0.5, 0.4, 1.0], np.zeros((4, 4)))
FOUND = Fingerprint(RESPONSE, TurnResponse(0.0, np.zeros(4), np.zeros((4, 4))), 0.0, 0.1)


def test_what_is_no_surface_no_protocol_or_no_number_is_refused_by_name(plywood, mit) -> None:
    flat = Anisotropy(0.1, 0.0, 0.0, 0.0)
    for other in (None, "plywood", 0.1, (0.1, 0.0, 0.1, 0.0)):
        refused(predict, FOUND, other, told=r"must be an Anisotropy or an EllipseFriction.*not ")
        refused(Anisotropy.of, other, told="friction must be an EllipseFriction")
        refused(predict, other, flat, told="needs a Fingerprint")
        refused(fingerprint, other, told="loop must be a CollectionLoop")
    for surface, told in (
        (Anisotropy(1e200, 0.0, 0.1, 0.0), "offset 1e[+]200 reaches out"),
        (Anisotropy(2.0, 0.0, 0.0, 0.0), "offset 2 reaches out.*choose less than 1$"),
        (
            Anisotropy(0.0, 0.0, 5.1, 0.0),
            "ellipticity 5.1 is more than any surface has.*choose at most 5",
        ),
        (Anisotropy(1e200, 0.0, 1e200, 0.0), "ellipticity 1e[+]200"),
    ):
        refused(predict, FOUND, surface, told=told)
    refused(
        TurnResponse,
        0.0,
        [1.0, 2.0, 3.0],
        np.zeros((4, 4)),
        told=r"gradient of a turn has shape \(3,\)",
    )
    refused(Anisotropy, -0.1, 0.0, 0.0, 0.0, told="offset must not be negative")
    refused(Anisotropy.of_components, np.zeros((2, 4)), told="components must have 1 axes")
    refused(Prediction, 5, flat, told="fingerprint must be a Fingerprint, not 5")
    refused(Prediction, FOUND, 5, told="anisotropy must be an Anisotropy, not 5")
    fixed = loop_from_settings({"way_points_mm": [[0.0, 50.0]]})
    refused(fingerprint, fixed, told="way-points of the reset.*fixed in the world.*way_points_mm")
    coarse, near = replace(plywood, accuracy=1e-5), first_order_lock_in(mit.cycle, flat)
    refused(
        full_lock_in,
        coarse,
        flat.scaled(0.1),
        near,
        told="no lock-in between",
        kind=ConvergenceError,
    )
    predicted = predict(FOUND, Anisotropy(0.1, 0.0, 0.02, 0.0))
    for law in (
        predicted.turn,
        predicted.second_order_turn,
        predicted.turn_error,
        predicted.anisotropy.seen_from,
    ):
        for theta in (math.nan, [0.0, math.inf], "abc"):
            refused(law, theta, told="theta must")
    for law in (RESPONSE.first_order, RESPONSE.second_order):
        for seen in ("abc", math.nan, [0.1, 0.0, 0.0], [0.1, 0.0, math.nan, 0.0]):
            refused(law, seen, told="seen must")
    refused(lock_in_boundary, RESPONSE, 0.0, 0.0, "abc", told="shares must")


@pytest.mark.parametrize("size", [1e-200, 1e200])
def test_the_mean_friction_drops_out_however_small_or_large(size) -> None:
    seen = Anisotropy.of(EllipseFriction(2.0 * size, size, m0=size))
    usual = Anisotropy.of(EllipseFriction(0.2, 0.1, m0=0.1))
    assert seen.offset == pytest.approx(usual.offset, rel=1e-14)
    assert seen.ellipticity == pytest.approx(usual.ellipticity, rel=1e-12)


@pytest.mark.parametrize("ellipticity", [0.0, 0.3, MOST_ELLIPTICITY])
@pytest.mark.parametrize("away", [0.0, 0.7, 0.5 * np.pi, 2.4])
def test_offsets_are_refused_exactly_where_the_friction_ellipse_leaves_zero_out(
    ellipticity, away
) -> None:
    """The edge in polar form: along `away` from the axis of greater friction it lies at |cos/e^v,
    sin e^v|^-1.
    """
    stretch = math.exp(ellipticity)
    edge = 1.0 / math.hypot(math.cos(away) / stretch, math.sin(away) * stretch)
    inside, outside = (
        Anisotropy(factor * edge, 0.4 + away, ellipticity, 0.4)
        for factor in (1.0 - 1e-9, 1.0 + 1e-9)
    )
    assert predict(FOUND, inside).anisotropy is inside
    assert isinstance(inside.friction(), EllipseFriction)
    for asked in (lambda: predict(FOUND, outside), outside.friction):
        refused(asked, told=r"offset .* reaches out of the friction ellipse.*choose less than")


def test_the_first_order_law_may_be_scaled_beyond_any_surface() -> None:
    """Rays of unit length, and ranges of lock-in beyond scale 10, need no surface that has them."""
    edge = lock_in_boundary(RESPONSE, 0.0, 0.0, [0.0, 0.5 * np.pi])
    assert edge[0, 0] == pytest.approx(0.1 / math.hypot(2.0, 0.5))
    slow = Fingerprint(
        TurnResponse(3.0, RESPONSE.gradient, np.zeros((4, 4))), FOUND.drag, 0.0, 0.01
    )
    found = predict(slow, Anisotropy(0.1, 0.0, 0.02, 0.0))
    assert 10.0 < found.lock_in_range[0] < found.lock_in.scale


def test_a_prediction_is_checked_on_its_own_surface_only(plywood, monkeypatch) -> None:
    """Another material is refused before any cycle; the same ellipse under exchanged axes or twice
    the friction not.
    """
    monkeypatch.setattr(CollectionLoop, "circle_map", lambda loop, **how: CircleMap.rigid(0.3))
    law = plywood.material.friction
    prediction = predict(FOUND, law)
    doubled = EllipseFriction(
        2 * law.mu_a, 2 * law.mu_b, 2 * law.m0, 2 * law.n0, law.phi + 2 * np.pi
    )
    exchanged = EllipseFriction(law.mu_b, law.mu_a, -law.n0, law.m0, law.phi - np.pi / 2)
    for same in (law, exchanged, doubled, prediction.anisotropy.friction()):
        loop = replace(plywood, material=replace(plywood.material, friction=same))
        assert check_prediction(prediction, loop).fixed_points == ()
    other = CollectionLoop.mit(material="isotropic")
    refused(
        check_prediction,
        prediction,
        other,
        told="offset 0.13.*but isotropic has offset 0.0000.*own friction",
    )
    refused(check_prediction, prediction, with_bow(plywood, 1.0), told="floor_bow=0")
    refused(check_prediction, None, plywood, told="needs a Prediction and a CollectionLoop")


def test_without_a_friction_on_the_rod_the_second_order_is_not_found(prediction) -> None:
    """Differences of a jump: the hessian's asymmetry is far beyond that of the MIT rod."""
    loop = loop_from_settings({"pusher_mu": 0.0})
    slippery = predict(fingerprint(loop), loop.material.friction)
    assert not slippery.second_order_found and not slippery.trusted
    assert (
        slippery.fingerprint.hessian_error > 0.02 * np.abs(slippery.fingerprint.cycle.hessian).max()
    )
    assert prediction.second_order_found


def test_the_floors_bow_adds_a_second_harmonic_whose_size_and_place_two_routes_tell(plywood, mit):
    """The engine's derivatives by the bow at one orientation, and the harmonics of a bowed map."""
    small, bowed = 0.01, with_bow(replace(plywood, accuracy=1e-10), 0.01)
    second = np.fft.rfft(full_turns(bowed, Anisotropy(0.0, 0.0, 0.0, 0.0)))[2] / 8.0 / small
    assert abs(second) == pytest.approx(mit.cycle.bow_amplitude, rel=1e-4)
    assert -np.angle(second) == pytest.approx(mit.cycle.bow_phase, abs=1e-4)
