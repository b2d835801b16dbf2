"""What follows from an identified ellipse: values by its own formulas, intervals that hold the truth."""

import math

import numpy as np
import pytest

from cyclemap.evidence.data_blocks.force_blocks import friction_ellipse_from_scans
from cyclemap.evidence.identification.identify import Identification
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.evidence.identified_curves import derived_quantities, sampled_values
from cyclemap.mechanics import EllipseFriction

LAW = EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6)
NAMES = {"axis_ratio", "axis_direction", "offset_size", "offset_direction", "mean_friction"}


def identified(law: EllipseFriction, noise: float, seed: int = 0, count: int = 36) -> Identification:
    """From made scans, noise in N, of an object of 8 N."""
    direction = np.linspace(0.0, 2 * np.pi, count, endpoint=False).repeat(2)
    way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    force = 8.0 * law.traction(way) + noise * np.random.default_rng(seed).standard_normal((2 * count, 2))
    along, across = np.sum(force * way, axis=1), force[:, 1] * way[:, 0] - force[:, 0] * way[:, 1]
    return friction_ellipse_from_scans({"direction": direction, "force_along": along, "force_across": across}, 8.0)


def test_values_are_those_of_the_ellipse() -> None:
    told = {one.name: one for one in derived_quantities(identified(LAW, 1e-5))}
    assert set(told) == NAMES
    mean = math.sqrt(0.28 * 0.22)
    assert told["axis_ratio"].value == pytest.approx(0.28 / 0.22, abs=1e-3)
    assert told["axis_direction"].value == pytest.approx(0.6, abs=1e-3)
    assert told["offset_size"].value == pytest.approx(math.hypot(0.02, 0.012) / mean, abs=1e-3)
    assert told["offset_direction"].value == pytest.approx(0.6 + math.atan2(-0.012, 0.02), abs=1e-3)
    assert told["mean_friction"].value == pytest.approx(mean, abs=1e-3)
    assert all(one.lower <= one.value <= one.upper and one.known for one in told.values())


@pytest.mark.slow
def test_small_errors_agree_with_the_delta_method() -> None:
    """The log of the axis ratio moves along the ellipticity's own direction, the rest by the chain rule."""
    found = identified(LAW, 0.05)
    told = {one.name: one for one in derived_quantities(found, draws=8000)}
    names = found.problem.space.names
    x, y = (found.values[name] for name in ("ellipticity_x", "ellipticity_y"))
    gradient = np.zeros(len(names))
    ratio = math.hypot(x, y)
    for name, part in (("ellipticity_x", x), ("ellipticity_y", y)):
        gradient[names.index(name)] = math.exp(ratio) * part / ratio
    error = math.sqrt(gradient @ found.uncertainty.covariance @ gradient)
    width = told["axis_ratio"].upper - told["axis_ratio"].lower
    t = 2.0 * 1.96
    assert width == pytest.approx(t * error, rel=0.1)


@pytest.mark.slow
def test_intervals_hold_the_truth_as_often_as_they_say() -> None:
    """30 seeded sets, 95 %: fewer than 25 held of one quantity would be a chance of 1 in 300."""
    mean = math.sqrt(0.28 * 0.22)
    truth = {"axis_ratio": 0.28 / 0.22, "axis_direction": 0.6, "mean_friction": mean}
    truth |= {"offset_size": math.hypot(0.02, 0.012) / mean, "offset_direction": 0.6 + math.atan2(-0.012, 0.02)}
    held = dict.fromkeys(truth, 0)
    for seed in range(30):
        for one in derived_quantities(identified(LAW, 0.1, seed, count=18), draws=200, seed=seed):
            held[one.name] += one.lower <= truth[one.name] <= one.upper
    assert all(count >= 25 for count in held.values()), held


def test_isotropic_friction_has_no_direction_and_a_ratio_that_may_be_one() -> None:
    told = {one.name: one for one in derived_quantities(identified(EllipseFriction.isotropic(0.25), 0.1))}
    assert told["axis_ratio"].lower == 1.0 and told["offset_size"].lower == 0.0
    assert not told["axis_direction"].known and not told["offset_direction"].known


def test_a_direction_at_the_end_of_its_range_has_an_interval_around_it() -> None:
    """An axis along y has angle +90 or -90 degrees: its interval does not run around the circle."""
    told = {one.name: one for one in derived_quantities(identified(EllipseFriction(0.3, 0.2, phi=math.pi / 2), 0.05))}
    axis = told["axis_direction"]
    assert axis.known and axis.upper - axis.lower < 0.2
    assert abs(math.cos(axis.value)) < 0.1


def test_samples_scatter_as_the_covariance_says() -> None:
    found = identified(LAW, 0.05)
    values = sampled_values(found, 4000, seed=3)
    assert len(values) == 4000
    drawn = np.array([[one[name] for name in SURFACE.names[:5]] for one in values])
    assert np.mean(drawn, axis=0) == pytest.approx(found.fit.vector, abs=4e-4)
    freedom = found.uncertainty.freedom
    assert np.all(freedom > 20.0)
    assert np.std(drawn, axis=0) == pytest.approx(found.uncertainty.standard_error, rel=0.1)
