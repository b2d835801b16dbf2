"""Maximum dissipation as drawn, scans and their fit where there are any, and a patch that balances the rod."""

import math

import numpy as np
import pytest
from figure_cases import assert_drawn, words_of

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import RecordingNoise
from cyclemap.evidence.data_blocks.force_blocks import ScanForces
from cyclemap.evidence.pushes.mit_names import scan_name
from cyclemap.evidence.pushes.push_files import write_push_file
from cyclemap.evidence.recorded_push import Recording, record_scan, scan_set
from cyclemap.figures import limit_ellipse_and_patch
from cyclemap.figures.catalogue import NO_DATA, MeasuredFolder
from cyclemap.figures.limit_ellipse_and_patch import GRID, compute, draw, lean_of, limit_curve, patch_forces
from cyclemap.figures.measured_sets import measured_scans
from cyclemap.mechanics import EllipseFriction, LimitSurface

NAME = "limit-ellipse-and-patch"
# Every so many of the 144 scans of a set.
EVERY = 6


@pytest.fixture(scope="module")
def scanned(tmp_path_factory) -> MeasuredFolder:
    """Noisy friction scans of rect1 on Table I's plywood, laid out as the MIT dataset has them."""
    loop, folder = CollectionLoop.mit("plywood"), tmp_path_factory.mktemp("scans")
    home = folder / "plywood" / "rect1" / "friction_scan"
    home.mkdir(parents=True)
    for number, facts in enumerate(list(scan_set("plywood", "rect1", 0.02))[::EVERY]):
        recording, random = Recording(noise=RecordingNoise(force=0.02)), np.random.default_rng(number)
        record = record_scan(loop.material.friction, loop.model.weight, facts.direction, recording, random)
        write_push_file(home / f"{scan_name(facts)}.h5", record)
    return MeasuredFolder(folder)


def test_the_drawn_traction_dissipates_most_of_all_points_of_the_ellipse(result) -> None:
    law, velocity = result.sketched, np.array([math.cos(result.sliding), math.sin(result.sliding)])
    power = limit_curve(law, 2001) @ velocity
    assert law.traction(velocity) @ velocity == pytest.approx(power.max(), rel=1e-5)
    assert np.all(power <= law.traction(velocity) @ velocity + 1e-12)


def test_the_limit_curve_is_the_ellipse_of_equation_1(result) -> None:
    for law in (result.sketched, result.table):
        x, y = limit_curve(law).T
        c, s = math.cos(law.phi), math.sin(law.phi)
        m, n = c * x + s * y, -s * x + c * y
        assert np.allclose(((m - law.m0) / law.mu_a) ** 2 + ((n - law.n0) / law.mu_b) ** 2, 1.0, atol=1e-12)


def test_the_lean_of_an_isotropic_law_is_zero_and_the_captions_is_the_sketchs(result) -> None:
    assert lean_of(EllipseFriction.isotropic(0.3), 1.0) == pytest.approx(0.0, abs=1e-12)
    lean = math.degrees(lean_of(result.sketched, result.sliding))
    assert lean > 20.0
    assert f"the two differ by {lean:.0f}°" in limit_ellipse_and_patch.caption(result)


def test_the_patch_balances_the_rod_by_a_second_route(result) -> None:
    """The twist comes from the slope of the course alone; the rod's force from the contact solver."""
    patch = result.patch
    assert patch.force.shape == (GRID**2, 2)
    assert np.allclose(patch.wrench, -patch.rod, rtol=0.0, atol=1e-4 * np.hypot(*patch.rod[:2]))


def test_the_sum_over_points_is_the_gradient_of_the_dissipation(result) -> None:
    patch, loop = result.patch, CollectionLoop.mit("plywood")
    gradient = LimitSurface(patch.footprint, result.table).wrench(patch.twist, patch.angle)
    assert np.allclose(patch.wrench, -loop.model.weight * gradient, atol=1e-10)


def test_isotropic_points_are_pulled_straight_back() -> None:
    patch = patch_forces(CollectionLoop.mit("isotropic"))
    along = np.sum(patch.force * patch.velocity, axis=1)
    assert np.allclose(along, -np.hypot(*patch.force.T) * np.hypot(*patch.velocity.T), rtol=1e-12)


@pytest.mark.slow
def test_scans_give_back_the_ellipse_that_made_them(scanned) -> None:
    found = compute(scanned)
    assert isinstance(found.scans, ScanForces) and found.fitted is not None
    assert len(found.scans.direction) == 24
    apart = np.hypot(*(limit_curve(found.fitted) - limit_curve(found.table)).T).max()
    assert apart < 2e-3
    told, figure = limit_ellipse_and_patch.caption(found), draw(found)
    assert "Dots: 24 friction scans" in told and f"at most {apart:.4f} from Table I" in told
    assert NO_DATA not in told and NO_DATA not in words_of(figure)
    assert "friction scans" in words_of(figure) and "fitted" in words_of(figure)
    assert_drawn(figure, 3)


def test_scans_of_another_surface_are_not_taken_for_plywoods(scanned) -> None:
    assert measured_scans(scanned, "abs") is None
    assert measured_scans(scanned, "plywood") is not None
