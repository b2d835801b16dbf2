"""The predicted ratio sits at the friction coefficient while the rod slides and between while it
sticks.
"""

import shutil

import numpy as np
import pytest
from figure_cases import assert_drawn

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import RecordingNoise, identify, read_push_file
from cyclemap.evidence.identification.force_blocks import force_ratio_block, sliding_forces
from cyclemap.evidence.pushes.push_files import write_push_file
from cyclemap.evidence.pushes.recordings import PushFacts, push_name
from cyclemap.evidence.recorded_push import Recording, record_push
from cyclemap.figures import forces as figure
from cyclemap.figures.catalogue import NO_DATA, MeasuredFolder
from cyclemap.figures.forces import FOLDER, draw_ratio, force_ratio, predicted_ratio, recorded_ratio
from cyclemap.mechanics import Slider
from cyclemap.protocol import loop_from_settings

NAME = "force-ratio"


@pytest.fixture(scope="module")
def recorded(tmp_path_factory) -> MeasuredFolder:
    """Two recorded pushes of rect1 by the mechanics: a short one that only slides,
    and a long one."""
    folder = tmp_path_factory.mktemp("recorded")
    (folder / FOLDER).mkdir()
    loop = CollectionLoop.mit("plywood")
    push = loop.strokes(0.5, loop.push.distance / 60)[0]
    for fraction, noise in ((0.7, 0.01), (0.8, 5.0)):
        record = record_push(
            push,
            loop.push.distance,
            Recording(noise=RecordingNoise(force=noise)),
            np.random.default_rng(2),
        )
        facts = PushFacts("plywood", "rect1", 0.0, 0.02, 0.0, fraction, 0.0)
        write_push_file(folder / FOLDER / f"{push_name(facts)}.h5", record)
    return MeasuredFolder(folder)


def test_the_predicted_ratio_is_the_friction_while_sliding_and_less_while_sticking(result) -> None:
    found = result.predicted
    assert found.friction == 0.15
    assert found.sliding.sum() > 50 and (~found.sliding).sum() > 30
    assert np.allclose(np.abs(found.ratio[found.sliding]), found.friction, atol=1e-9)
    assert np.all(np.abs(found.ratio[~found.sliding]) <= found.friction + 1e-6)


def test_the_push_slides_one_way_sticks_and_slides_the_other_way(result) -> None:
    found = result.predicted
    assert found.ratio[0] == pytest.approx(0.15) and found.ratio[-1] == pytest.approx(-0.15)
    assert np.all(np.diff(found.ratio) <= 1e-7)
    assert np.count_nonzero(np.diff(found.sliding.astype(int))) == 2
    stuck = 1000.0 * found.travel[~found.sliding]
    assert f"from {stuck[0]:.0f} to {stuck[-1]:.0f} mm" in figure.ratio_caption(result)


def test_the_ratio_does_not_depend_on_the_weight_or_the_level_of_friction() -> None:
    ratios = []
    for mu in (0.2, 0.4):
        loop = loop_from_settings({"mu_a": mu, "mu_b": mu, "m0": 0.0, "n0": 0.0})
        course = loop.model.push(
            loop.start_pose(0.3), loop.push, loop.push.distance / 40
        ).trajectory
        found = predicted_ratio(course, loop.pusher.radius, 0.15)
        ratios.append(np.interp(np.linspace(0.001, 0.14, 30), found.travel, found.ratio))
    assert np.allclose(*ratios, atol=1e-4)


def test_a_recorded_push_gives_back_the_friction_that_made_it(recorded) -> None:
    found = recorded_ratio(recorded)
    assert found is not None and found.files == 2
    assert found.name == "rect1 on plywood, 20 mm/s"
    assert found.friction == pytest.approx(0.15, abs=2e-3)
    assert found.sliding.sum() > 500 and found.sticking.sum() > 200
    assert not np.any(found.sliding & found.sticking)
    predicted = CollectionLoop.mit("plywood").cycle(0.5).trajectory.push
    course = predicted_ratio(predicted, 0.00475, 0.15)
    # The record's way begins 1 mm before the rod touches.
    expected = np.interp(found.travel - 0.001, course.travel, course.ratio)
    assert np.median(np.abs(found.ratio - expected)) < 0.01


def test_the_noisy_push_is_not_chosen_and_a_damaged_file_is_passed_over_and_told(
    recorded, tmp_path
) -> None:
    shutil.copytree(recorded.path / FOLDER, tmp_path / FOLDER)
    facts = PushFacts("plywood", "rect1", 0.0, 0.02, 0.0, 0.9, 0.0)
    (tmp_path / FOLDER / f"{push_name(facts)}.h5").write_bytes(b"no push")
    found = force_ratio(MeasuredFolder(tmp_path))
    told, drawn = figure.ratio_caption(found), draw_ratio(found)
    assert "of 2 recorded pushes (1 more could not be read)" in told
    assert f"ratio is {found.recorded.friction:.3f}" in told
    assert NO_DATA not in told
    assert_drawn(drawn, 2)


@pytest.mark.slow
def test_the_recorded_push_of_the_data_slides_near_a_fifth_and_sticks_below(measured_data) -> None:
    """hex on abs at 50 mm/s, pushed at 20 degrees: the coefficient is that of the whole estimator
    on this file.
    """
    found = force_ratio(MeasuredFolder(measured_data))
    assert found.recorded is not None and found.recorded.files == 51
    assert found.recorded.name == "hex on abs, 50 mm/s"
    name = "motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=0.349.h5"
    forces = sliding_forces(
        [(read_push_file(measured_data / FOLDER / name), Slider.mit("hex").outline_points(360))]
    )
    assert forces.samples == found.recorded.forces.samples
    whole = identify([force_ratio_block(forces)], ["pusher_friction"], starts=1)["pusher_friction"]
    assert found.recorded.friction == pytest.approx(whole.value, abs=0.02)
    assert (
        np.mean(np.abs(found.recorded.ratio[found.recorded.sticking]) < found.recorded.friction)
        > 0.8
    )
    assert_drawn(draw_ratio(found), 2)
