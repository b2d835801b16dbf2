"""Sliding contacts give the friction of rod and object without bias; sticking ones only bound it."""

import math

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence import PushRecord, RecordingNoise, contact_force_ratio, identify, read_push_file
from cyclemap.evidence.data_blocks.force_blocks import force_ratio_block, sliding_forces
from cyclemap.evidence.pushes.contact_forces import contact_samples
from cyclemap.evidence.recorded_push import Recording, record_push
from cyclemap.mechanics import Slider

SQUARE = Slider.mit("rect1").outline_points(4)
RADIUS, SPEED, MU = 0.00475, 0.02, 0.15
QUIET = RecordingNoise(0.0)
NOISE = RecordingNoise(0.0, 1e-4, math.radians(0.1), 0.05)


def made_record(noise=QUIET, seed=0, mu_factor=1.0, slip=0.4, samples=250):
    """The record of a push at side 0, the rod going along -y, that sticks, its ratio rising to MU, then slides.

    It slides at `slip` of the rod's travel. The normal into the object is -y, the tangent +x, in the object's frame.
    """
    rng, time, spin = np.random.default_rng(seed), np.arange(samples) * 0.004, 0.4
    sliding = time > 0.4 * time[-1]
    ratio = np.sign(slip) * MU * np.where(sliding, 1.0, np.linspace(-0.5, 2.0, samples))
    # Along the side the centre of a rod that sticks rolls on by its radius times the object's turn.
    rate = np.where(sliding, slip * SPEED, 0.0) + RADIUS * spin
    along = -0.018 + np.concatenate([[0.0], np.cumsum(0.004 * rate[1:])])
    rod, normal = np.column_stack([along, np.full(samples, 0.045 + RADIUS)]), 1.8 + 0.2 * np.sin(time)
    tip = np.column_stack([np.zeros_like(time), -SPEED * time])
    force = np.column_stack([mu_factor * ratio * normal, -normal])
    pose = np.column_stack([tip - turned(spin * time, rod), spin * time]) + noise.of_poses(samples, rng)
    wrench = np.column_stack([-turned(spin * time, force), 0.0 * time]) + noise.of_wrenches(samples, RADIUS, rng)
    return PushRecord(*(np.column_stack([time, part]) for part in (pose, np.column_stack([tip, 0.0 * time]), wrench)))


def turned(angle, vectors):
    c, k = np.cos(angle), np.sin(angle)
    return np.column_stack([c * vectors[:, 0] - k * vectors[:, 1], k * vectors[:, 0] + c * vectors[:, 1]])


def sliding_of(records, outline=SQUARE):
    return sliding_forces([(record, outline) for record in records])


def friction_of(sliding):
    """The friction of the rod, identified from forces alone."""
    return identify([force_ratio_block(sliding)], ["pusher_friction"], starts=1)["pusher_friction"]


@pytest.fixture(scope="module")
def collection():
    """Records pushes of the MIT loop on plywood with a noise; its pusher's friction is MU."""
    loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    assert loop.pusher.friction == MU
    pushes = [loop.strokes(theta, loop.push.distance / 60)[0] for theta in np.arange(0.0, 6.0, 1.5)]

    def recorded(noise, seed=0):
        rng = np.random.default_rng(seed)
        return [record_push(push, loop.push.distance, Recording(noise=noise), rng) for push in pushes]

    return recorded


@pytest.mark.parametrize("slip", [0.4, -0.4])
def test_the_slip_of_a_made_push_is_what_made_it_and_rolling_is_none(slip: float) -> None:
    samples = contact_samples(made_record(slip=slip), SQUARE)
    assert samples.touching.all() and samples.window == 51
    assert np.isnan(samples.slip[:25]).all() and np.isnan(samples.slip[-25:]).all()
    assert np.allclose(samples.slip[25:70], 0.0, atol=2e-3)
    assert np.allclose(samples.slip[130:225], slip, atol=2e-3)


def test_pushes_of_the_mechanics_without_noise_give_the_rods_friction(collection) -> None:
    sliding = sliding_of(collection(QUIET))
    assert friction_of(sliding).value == pytest.approx(MU, abs=1e-4)
    assert set(sliding.push) == {0, 1, 2, 3}
    assert sliding.samples > 1000 and sliding.sticking > 1000


def test_noise_does_not_bias_the_friction_as_it_does_the_median_ratio(collection) -> None:
    records = [collection(NOISE, seed) for seed in range(8)]
    found = [friction_of(sliding_of(pushes)) for pushes in records]
    assert np.mean([one.value for one in found]) == pytest.approx(MU, abs=5e-4)
    assert np.mean([contact_force_ratio(record, SQUARE) for pushes in records for record in pushes]) < MU - 0.01
    assert sum(one.lower < MU < one.upper for one in found) >= 6


def test_groups_are_pushes_and_the_pieces_of_one_push_alone_its_pieces() -> None:
    records = [made_record(samples=500, slip=slip) for slip in (0.4, 0.3)]
    both, one = sliding_of(records), sliding_of(records[:1])
    assert len(both.ratio) >= 6 and both.push.tolist() == sorted(both.push.tolist())
    assert set(force_ratio_block(both).groups) == {0, 1}
    assert force_ratio_block(one).groups.tolist() == list(range(len(one.ratio)))
    assert np.allclose(both.ratio, MU, atol=1e-9)


def test_a_push_that_sticks_all_along_or_has_no_normal_force_does_not_slide() -> None:
    record = made_record()
    slack = PushRecord(record.object_pose, record.tip_pose, record.ft_wrench * np.array([1.0, 0.0, 0.0, 0.0]))
    assert sliding_of([made_record(slip=0.01)]).sticking == 150
    for one in (made_record(slip=0.01), slack):
        with pytest.raises(InvalidInput, match="no push slides"):
            force_ratio_block(sliding_of([one]))


@pytest.mark.slow
def test_the_measured_files_of_the_hexagon_agree_on_a_friction_near_a_fifth(measured_data) -> None:
    """The forces of the rect1 files are unusable, and are not taken for friction."""
    pieces = {"rect1": [], "hex": []}
    for shape, found in pieces.items():
        files = sorted((measured_data / "mit_files").glob(f"*shape={shape}*"))
        found += [sliding_of([read_push_file(file)], Slider.mit(shape).outline_points(360)) for file in files]
    assert [one.ratio.size < 2 for one in pieces["rect1"]] == [True] * 13
    values = [friction_of(one).value for one in pieces["hex"] if one.ratio.size > 1]
    assert len(values) >= 10
    assert all(0.15 < value < 0.27 for value in values)
