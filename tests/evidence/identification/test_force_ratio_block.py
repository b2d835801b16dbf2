"""Sliding contacts give the friction of rod and object without bias;
sticking ones only bound it."""

import math
from dataclasses import replace

import numpy as np
import pytest
from refusals import refused

from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence import RecordingNoise, contact_force_ratio, identify, read_push_file
from cyclemap.evidence.identification.force_blocks import force_ratio_block, sliding_forces
from cyclemap.evidence.pushes.contact_forces import contact_samples
from cyclemap.evidence.recorded_push import Recording, record_push
from cyclemap.mechanics import Pusher, Slider

SQUARE = Slider.mit("rect1").outline_points(4)
MU = 0.15
QUIET = RecordingNoise(0.0)
NOISE = RecordingNoise(0.0, 1e-4, math.radians(0.1), 0.05)


def recorded(noise=QUIET, seed=0, count=4, friction=MU):
    loop = replace(CollectionLoop.mit("plywood", accuracy=1e-6), pusher=Pusher(friction=friction))
    pushes = [loop.strokes(1.5 * number, loop.push.distance / 60)[0] for number in range(count)]
    rng = np.random.default_rng(seed)
    return [record_push(push, loop.push.distance, Recording(noise=noise), rng) for push in pushes]


def sliding_of(records, outline=SQUARE):
    return sliding_forces([(record, outline) for record in records])


def friction_of(sliding):
    return identify([force_ratio_block(sliding)], ["pusher_friction"], starts=1)["pusher_friction"]


def test_pushes_without_noise_give_the_rods_friction_however_it_slides() -> None:
    records = recorded()
    sliding = sliding_of(records)
    assert sliding.ratio == pytest.approx(np.full(sliding.ratio.size, MU), abs=1e-3)
    assert friction_of(sliding).value == pytest.approx(MU, abs=1e-4)
    assert sliding.samples > 1000 and sliding.sticking > 1000
    slips = np.concatenate([contact_samples(record, SQUARE).slip for record in records])
    assert np.nanmin(slips) < -0.1 and np.nanmax(slips) > 0.1
    # A group a push; of one push alone each piece.
    assert set(force_ratio_block(sliding).groups) == {0, 1, 2, 3}
    one = sliding_of(records[:1])
    assert force_ratio_block(one).groups.tolist() == list(range(one.ratio.size))


def test_noise_does_not_bias_the_friction_as_it_does_the_median_ratio() -> None:
    records = [recorded(NOISE, seed) for seed in range(8)]
    found = [friction_of(sliding_of(pushes)) for pushes in records]
    assert np.mean([one.value for one in found]) == pytest.approx(MU, abs=5e-4)
    assert (
        np.mean([contact_force_ratio(record, SQUARE) for pushes in records for record in pushes])
        < MU - 0.01
    )
    assert sum(one.lower < MU < one.upper for one in found) >= 6


def test_a_push_that_sticks_all_along_or_has_no_normal_force_does_not_slide() -> None:
    (rough,), (plain,) = recorded(count=1, friction=5.0), recorded(count=1)
    assert sliding_of([rough]).sticking > 1000
    for record in (rough, replace(plain, ft_wrench=plain.ft_wrench * [1.0, 0.0, 0.0, 0.0])):
        refused(force_ratio_block, sliding_of([record]), told="no push slides")


@pytest.mark.slow
def test_the_measured_files_of_the_hexagon_agree_on_a_friction_near_a_fifth(measured_data) -> None:
    """The forces of the rect1 files are unusable, and are not taken for friction."""
    pieces = {"rect1": [], "hex": []}
    for shape, found in pieces.items():
        files = sorted((measured_data / "mit_files").glob(f"*shape={shape}*"))
        found += [
            sliding_of([read_push_file(file)], Slider.mit(shape).outline_points(360))
            for file in files
        ]
    assert [one.ratio.size < 2 for one in pieces["rect1"]] == [True] * 13
    values = [friction_of(one).value for one in pieces["hex"] if one.ratio.size > 1]
    assert len(values) >= 10 and all(0.15 < value < 0.27 for value in values)
