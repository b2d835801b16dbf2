"""The limit curve as drawn, scans and their fit where there are any, and a patch that balances the
rod.
"""

import math

import numpy as np
import pytest
from figure_cases import SCANS, assert_drawn, recorded_folder, small, words_of

from cyclemap.figures import forces as figure
from cyclemap.figures.catalogue import NO_DATA
from cyclemap.figures.forces import DIRECTION, GRID, SKETCHED, lean_of, limit_curve
from cyclemap.mechanics import EllipseFriction

NAME = "limit-ellipse-and-patch"


def test_the_limit_curve_is_the_ellipse_of_equation_1(result) -> None:
    for law in (SKETCHED, result.table):
        x, y = limit_curve(law).T
        c, s = math.cos(law.phi), math.sin(law.phi)
        m, n = c * x + s * y, -s * x + c * y
        assert np.allclose(
            ((m - law.m0) / law.mu_a) ** 2 + ((n - law.n0) / law.mu_b) ** 2, 1.0, atol=1e-12
        )


def test_the_lean_of_an_isotropic_law_is_zero_and_the_captions_is_the_sketchs(result) -> None:
    assert lean_of(EllipseFriction.isotropic(0.3), 1.0) == pytest.approx(0.0, abs=1e-12)
    lean = math.degrees(lean_of(SKETCHED, DIRECTION))
    assert lean > 20.0
    assert f"the two differ by {lean:.0f}°" in figure.limit_caption(result)


def test_the_patch_balances_the_rod_by_a_second_route(result) -> None:
    """The twist comes from the slope of the course alone;
    the rod's force from the contact solver."""
    patch = result.patch
    assert patch.force.shape == (GRID**2, 2)
    assert np.allclose(patch.wrench, -patch.rod, rtol=0.0, atol=1e-4 * np.hypot(*patch.rod[:2]))


@pytest.mark.slow
def test_scans_give_back_the_ellipse_that_made_them(tmp_path_factory) -> None:
    found = small(NAME, recorded_folder(tmp_path_factory))
    assert found.scans.shape == (SCANS, 2)
    apart = np.hypot(*(limit_curve(found.fitted) - limit_curve(found.table)).T).max()
    assert apart < 1e-5
    told, drawn = figure.limit_caption(found), figure.draw_limits(found)
    assert f"Dots: {SCANS} friction scans" in told and f"at most {apart:.4f} from Table I" in told
    assert (
        NO_DATA not in told and "friction scans" in words_of(drawn) and "fitted" in words_of(drawn)
    )
    assert_drawn(drawn, 3)
