"""A rod that touches two places of a concave outline: what an independent solver of all modes says of it."""

import math

import numpy as np
import pytest
from two_contact_reference import (
    Contact,
    Instant,
    Plate,
    consistent_modes,
    cross,
    free_spin,
    one_contact,
    quarter,
    run_push,
    unit,
)

from cyclemap.mechanics import EllipseFriction, LimitSurface, PatchFootprint, Polygon

PLYWOOD, ISOTROPIC = (0.2545, 0.2346, 0.0325, 0.0082, 2.6175), (0.25, 0.25, 0.0, 0.0, 0.0)
NOTCH = ((-0.05, -0.04), (0.05, -0.04), (0.05, 0.03), (0.0, 0.005), (-0.05, 0.03))
SKEW = ((-0.05, -0.04), (0.05, -0.04), (0.05, 0.04), (0.012, 0.005), (-0.05, 0.03))
SLOT = (*NOTCH[:3], (0.004, 0.03), (0.004, 0.0), (-0.004, 0.0), (-0.004, 0.03), (-0.05, 0.03))

# Whole pushes of plates at the origin under even pressure: plate, surface, rod's radius and friction, then side,
# fraction, orientation (rad), angle (rad), distance as of SidePush; where the plate ends (x, y, theta), to 1e-10 m and
# 1e-9 rad as steps of accuracy 1e-10 and 1e-12 agree, and the modes on the way.
PUSHES = (
    (
        (SKEW, ISOTROPIC, 0.002, 0.15, 3, 0.231, 0.8, 0.912, 0.1),
        (0.0521195004040, -0.0309833293934, -0.280234802335),
        ("slide-", "wedge turn-", "leave slide-"),
    ),
    (
        (NOTCH, PLYWOOD, 0.00475, 0.15, 3, 0.476, -1.5, 1.217, 0.1),
        (-0.0542007813700, -0.0293443067396, -2.200358490187),
        ("slide-", "wedge turn-", "leave slide-"),
    ),
    (
        (SKEW, PLYWOOD, 0.002, 0.3, 2, 0.754, 1.7, -1.048, 0.1),
        (0.0738043741424, -0.0111636259122, 0.457666467312),
        ("slide+", "leave stick", "slide-", "wedge turn-"),
    ),
    (
        (NOTCH, PLYWOOD, 0.0, 0.05, 3, 0.476, 2.6, 0.84, 0.1),
        (0.0316036221351, 0.0755721868805, 2.410184947658),
        ("slide-", "wedge pivot", "leave slide-"),
    ),
    (
        (SLOT, PLYWOOD, 0.00475, 0.05, 2, 0.99, 0.5, -0.4, 0.08),
        (0.0269667597703, -0.0544214362237, 1.339427671083),
        ("slide+", "slide+", "wedge turn+", "leave slide+"),
    ),
    (
        (NOTCH, PLYWOOD, 0.00475, 0.3, 2, 0.93, 0.2, -0.4636, 0.08),
        (0.0167099740270, -0.0775298325311, 0.160665802096),
        ("slide+", "wedge wedged"),
    ),
)


def patch_friction(vertices, law):
    """Of a polygon under even pressure."""
    return LimitSurface(PatchFootprint(Polygon(vertices)), EllipseFriction(*law)).wrench


def ellipsoid_friction(matrix):
    """D = sqrt(V^T A V), any orientation alike."""
    return lambda twist, theta: matrix @ twist / math.sqrt(twist @ matrix @ twist)


def recomputed(push, accuracy):
    vertices, law, radius, mu, side, fraction, theta, angle, distance = push
    plate = Plate(vertices, patch_friction(vertices, law), radius, mu)
    return run_push(plate, side, fraction, theta, angle, distance, accuracy)


def random_wedge(rng, radius=None, mu=None):
    """An instant with two contacts of a concave corner, anywhere on an object of extent one, that the rod pushes."""
    mu = rng.uniform(0.0, 1.0) if mu is None else mu
    radius = 10.0 ** rng.uniform(-2.0, 0.0) if radius is None else radius
    first, corner, centre = (
        rng.uniform(0.0, 2.0 * math.pi),
        rng.uniform(0.05, math.pi - 0.05),
        rng.uniform(-1.0, 1.0, 2),
    )
    contacts = [Contact(tuple(centre - radius * unit(a)), a) for a in (first, first - corner)]
    u = unit(rng.uniform(0.0, 2.0 * math.pi))
    while min(contact.normal @ u for contact in contacts) >= 0.0:
        u = unit(rng.uniform(0.0, 2.0 * math.pi))
    bumps = rng.normal(size=(3, 3))
    matrix = np.diag([1.0, 1.0, 0.4]) + 0.1 * bumps @ bumps.T
    return Instant(ellipsoid_friction(matrix), 0.0, u, radius, mu, 1.0), contacts, math.pi - corner, matrix


def test_one_contact_on_an_ellipsoid_is_the_closed_form():
    """V = A^-1 J^T K^-1 u where it sticks, and along A^-1 J^T d where it slides."""
    rng = np.random.default_rng(2)
    for _ in range(20):
        instant, (contact, _), _, matrix = random_wedge(rng)
        x, y = contact.point
        jacobian = np.array([[1.0, 0.0, -y], [0.0, 1.0, x]])
        drive = np.linalg.solve(matrix, jacobian.T)
        modes = {mode.name: mode for mode in one_contact(instant, contact)}
        assert np.allclose(modes["stick"].twist, drive @ np.linalg.solve(jacobian @ drive, instant.velocity), atol=1e-9)
        for name, sense in (("slide+", 1.0), ("slide-", -1.0)):
            along = drive @ (-contact.normal + sense * instant.mu * contact.tangent)
            factor = (contact.normal @ instant.velocity) / (contact.normal @ jacobian @ along)
            assert np.allclose(modes[name].twist, factor * along, rtol=1e-7, atol=1e-7 * abs(factor))


@pytest.mark.slow
def test_forces_of_every_mode_balance_friction_and_those_kept_touch():
    rng, names = np.random.default_rng(3), set()
    for case in range(60):
        instant, contacts, _, _ = random_wedge(rng, radius=0.0 if case % 5 == 0 else None)
        for kept, mode in consistent_modes(instant, contacts):
            held = contacts if kept == "both" else [contacts[int(kept)]]
            total = np.zeros(3)
            for contact, (normal, tangential) in zip(held, mode.forces, strict=True):
                if mode.name != "pivot":
                    assert normal >= 0.0 and abs(tangential) <= instant.mu * normal * (1.0 + 1e-9)
                force = -normal * contact.normal + tangential * contact.tangent
                total += [*force, cross(np.array(contact.point), force)]
                velocity = mode.twist[:2] + mode.twist[2] * quarter(np.array(contact.point))
                assert abs(contact.normal @ (velocity - instant.velocity)) < 1e-9
            assert np.allclose(total, instant.wrench(mode.twist, 0.0), atol=1e-8)
            names.add(mode.name)
    assert names == {"stick", "slide+", "slide-", "turn+", "turn-", "wedged", "pivot"}


@pytest.mark.slow
def test_one_mode_holds_unless_the_notch_locks_itself():
    """A notch no wider than both friction cones holds any force: then the wedge holds, whatever else does."""
    rng, several = np.random.default_rng(4), 0
    for _ in range(80):
        instant, contacts, opening, _ = random_wedge(rng)
        names = [mode.name for _, mode in consistent_modes(instant, contacts)]
        if opening > 2.0 * math.atan(instant.mu):
            assert len(names) == 1
        else:
            assert "wedged" in names
            several += len(names) > 1
    assert several > 8


@pytest.mark.slow
def test_without_friction_a_wedged_rod_is_a_ring():
    rng, turned = np.random.default_rng(5), 0
    for _ in range(40):
        instant, contacts, _, _ = random_wedge(rng, mu=0.0)
        ((kept, mode),) = consistent_modes(instant, contacts)
        if kept == "both":
            centre = instant.centre(contacts[0])
            assert mode.twist[2] == pytest.approx(free_spin(instant, centre, instant.velocity), abs=1e-9)
            turned += 1
    assert turned > 5


def test_a_symmetric_notch_pushed_along_its_axis_translates():
    plate = Plate(NOTCH, patch_friction(NOTCH, ISOTROPIC), 0.004, 0.2)
    place = ("side", 2, math.sqrt(0.003125) - 0.002)
    contacts = [plate.contact(place), plate.contact(("side", 3, 0.002))]
    instant = Instant(plate.wrench, 0.0, np.array([0.0, -1.0]), 0.004, 0.2, 0.1)
    ((_, mode),) = consistent_modes(instant, contacts)
    assert mode.name == "wedged" and np.allclose(mode.twist, (0.0, -1.0, 0.0))
    # The forces that no friction needs, of a frictionless rod, are each half the friction over the cosine.
    ((_, turn),) = consistent_modes(Instant(plate.wrench, 0.0, np.array([1e-6, -1.0]), 0.004, 0.0, 0.1), contacts)
    normal = 0.125 / math.cos(math.atan(0.5))
    assert np.allclose([n for n, _ in turn.forces], normal, rtol=1e-4)


@pytest.mark.slow
def test_thin_rods_tend_to_a_point():
    """The difference of the end poses falls with the radius."""
    law, push = PLYWOOD, (3, 0.476, 2.6, 0.84, 0.1)
    plates = [Plate(NOTCH, patch_friction(NOTCH, law), radius, 0.05) for radius in (0.0, 2e-4, 2e-5)]
    point, thick, thin = (np.array(run_push(plate, *push, 1e-8).pose) for plate in plates)
    coarse, fine = np.abs(thick - point).max(), np.abs(thin - point).max()
    assert 1e-6 < coarse < 0.05 and fine < 0.2 * coarse


@pytest.mark.slow
def test_a_mirrored_push_ends_mirrored():
    one = recomputed((NOTCH, ISOTROPIC, 0.002, 0.05, 2, 0.65, -0.4, -0.583, 0.1), 1e-9)
    two = recomputed((NOTCH, ISOTROPIC, 0.002, 0.05, 3, 0.35, 0.4, 0.583, 0.1), 1e-9)
    assert np.allclose(np.array(one.pose) * (-1.0, 1.0, -1.0), two.pose, atol=1e-6)
    assert one.modes == ("slide+", "wedge turn-", "leave slide-") and two.modes == (
        "slide-",
        "wedge turn+",
        "leave slide+",
    )


@pytest.mark.slow
@pytest.mark.parametrize("case", PUSHES)
def test_whole_pushes_are_recomputed(case):
    push, pose, modes = case
    found = recomputed(push, 1e-8)
    assert np.allclose(found.pose, pose, rtol=0.0, atol=2e-6)
    assert (found.ended, found.modes, found.ambiguous) == ("distance", modes, ())
