"""The limit curve, friction scans and their fit, a patch that balances the rod, and the ratio of
forces over a push: what the captions claim.
"""

import math

import numpy as np
import pytest
from figure_cases import SCANS, assert_drawn, exhibited, recorded_folder, small, words_of

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import RecordingNoise, identify, read_push_file
from cyclemap.evidence.identification.force_blocks import force_ratio_block, sliding_forces
from cyclemap.evidence.pushes.push_files import write_push_file
from cyclemap.evidence.pushes.recordings import PushFacts, push_name
from cyclemap.evidence.recorded_push import Recording, record_push
from cyclemap.figures import NO_DATA, MeasuredFolder, forces as figure
from cyclemap.figures.forces import (
    DIRECTION,
    FOLDER,
    GRID,
    SKETCHED,
    draw_ratio,
    force_ratio,
    lean_of,
    limit_curve,
    predicted_ratio,
)
from cyclemap.mechanics import EllipseFriction, Slider
from cyclemap.protocol import loop_from_settings

limits = exhibited("limit-ellipse-and-patch")
ratio = exhibited("force-ratio")


def test_the_limit_curve_is_the_ellipse_of_equation_1(limits) -> None:
    for law in (SKETCHED, limits.table):
        x, y = limit_curve(law).T
        c, s = math.cos(law.phi), math.sin(law.phi)
        m, n = (c * x + s * y - law.m0) / law.mu_a, (-s * x + c * y - law.n0) / law.mu_b
        assert np.allclose(m**2 + n**2, 1.0, atol=1e-12)


def test_the_lean_of_an_isotropic_law_is_zero_and_the_captions_is_the_sketchs(limits) -> None:
    assert lean_of(EllipseFriction.isotropic(0.3), 1.0) == pytest.approx(0.0, abs=1e-12)
    lean = math.degrees(lean_of(SKETCHED, DIRECTION))
    assert lean > 20.0
    assert f"the two differ by {lean:.0f}°" in figure.limit_caption(limits)


def test_the_patch_balances_the_rod_by_a_second_route(limits) -> None:
    """The twist comes from the slope of the course alone; the rod's force from the contact
    solver.
    """
    patch = limits.patch
    assert patch.force.shape == (GRID**2, 2)
    assert np.allclose(patch.wrench, -patch.rod, rtol=0.0, atol=1e-4 * np.hypot(*patch.rod[:2]))


@pytest.mark.slow
def test_scans_give_back_the_ellipse_that_made_them(tmp_path_factory) -> None:
    found = small("limit-ellipse-and-patch", recorded_folder(tmp_path_factory))
    assert found.scans.shape == (SCANS, 2)
    apart = np.hypot(*(limit_curve(found.fitted) - limit_curve(found.table)).T).max()
    assert apart < 1e-5
    told, drawn = figure.limit_caption(found), figure.draw_limits(found)
    assert f"Dots: {SCANS} friction scans" in told and f"at most {apart:.4f} from Table I" in told
    assert NO_DATA not in told
    assert "friction scans" in words_of(drawn) and "fitted" in words_of(drawn)
    assert_drawn(drawn, 3)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> MeasuredFolder:
    """Two recorded pushes of rect1 by the mechanics, one of them noisy, and a file that is none."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / FOLDER).mkdir()
    loop = CollectionLoop.mit("plywood")
    push = loop.strokes(0.5, loop.push.distance / 60)[0]
    for fraction, noise in ((0.7, 0.01), (0.8, 5.0)):
        recording = Recording(noise=RecordingNoise(force=noise))
        record = record_push(push, loop.push.distance, recording, np.random.default_rng(2))
        write_push_file(folder / FOLDER / push_file(fraction), record)
    (folder / FOLDER / push_file(0.9)).write_bytes(b"no push")
    return MeasuredFolder(folder)


def push_file(fraction: float) -> str:
    return f"{push_name(PushFacts('plywood', 'rect1', 0.0, 0.02, 0.0, fraction, 0.0))}.h5"


def test_the_ratio_is_the_friction_while_the_push_slides_one_way_and_then_the_other(ratio) -> None:
    found = ratio.predicted
    assert found.friction == 0.15
    assert found.sliding.sum() > 50 and (~found.sliding).sum() > 30
    assert np.allclose(np.abs(found.ratio[found.sliding]), found.friction, atol=1e-9)
    assert np.all(np.abs(found.ratio[~found.sliding]) <= found.friction + 1e-6)
    assert found.ratio[[0, -1]] == pytest.approx((0.15, -0.15))
    assert np.all(np.diff(found.ratio) <= 1e-7)
    assert np.count_nonzero(np.diff(found.sliding.astype(int))) == 2
    stuck = 1000.0 * found.travel[~found.sliding]
    assert f"from {stuck[0]:.0f} to {stuck[-1]:.0f} mm" in figure.ratio_caption(ratio)


def test_the_ratio_does_not_depend_on_the_weight_or_the_level_of_friction() -> None:
    ratios = []
    for mu in (0.2, 0.4):
        loop = loop_from_settings({"mu_a": mu, "mu_b": mu, "m0": 0.0, "n0": 0.0})
        push = loop.model.push(loop.start_pose(0.3), loop.push, loop.push.distance / 40)
        found = predicted_ratio(push.trajectory, loop.pusher.radius, 0.15)
        ratios.append(np.interp(np.linspace(0.001, 0.14, 30), found.travel, found.ratio))
    assert np.allclose(*ratios, atol=1e-4)


def test_the_quiet_recorded_push_is_chosen_and_gives_back_the_friction_that_made_it(
    recorded,
) -> None:
    """The noisy one is not chosen, and a damaged file is passed over and told."""
    both = force_ratio(recorded)
    found = both.recorded
    assert found.name == "rect1 on plywood, 20 mm/s"
    assert found.friction == pytest.approx(0.15, abs=2e-3)
    assert found.sliding.sum() > 500 and found.sticking.sum() > 200
    assert not np.any(found.sliding & found.sticking)
    predicted = CollectionLoop.mit("plywood").cycle(0.5).trajectory.push
    course = predicted_ratio(predicted, 0.00475, 0.15)
    # The record's way begins 1 mm before the rod touches.
    expected = np.interp(found.travel - 0.001, course.travel, course.ratio)
    assert np.median(np.abs(found.ratio - expected)) < 0.01
    told = figure.ratio_caption(both)
    assert "of 2 recorded pushes (1 more could not be read)" in told
    assert f"ratio is {found.friction:.3f}" in told and NO_DATA not in told
    assert_drawn(draw_ratio(both), 2)


@pytest.mark.slow
def test_the_recorded_push_of_the_data_slides_near_a_fifth_and_sticks_below(measured_data) -> None:
    """hex on abs at 50 mm/s, pushed at 20 degrees: the coefficient is that of the whole estimator
    on this file.
    """
    found = force_ratio(MeasuredFolder(measured_data)).recorded
    assert found.files == 51 and found.name == "hex on abs, 50 mm/s"
    name = "motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=0.349.h5"
    record, outline = read_push_file(measured_data / FOLDER / name), Slider.mit("hex")
    forces = sliding_forces([(record, outline.outline_points(360))])
    assert forces.samples == found.forces.samples
    whole = identify([force_ratio_block(forces)], ["pusher_friction"], starts=1)["pusher_friction"]
    assert found.friction == pytest.approx(whole.value, abs=0.02)
    assert np.mean(np.abs(found.ratio[found.sticking]) < found.friction) > 0.8
