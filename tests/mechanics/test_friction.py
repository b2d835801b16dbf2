"""Point friction: the offset ellipse is a maximum-dissipation law."""

import math

import numpy as np
import pytest
from random_cases import random_friction

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import EllipseFriction

LAWS = [random_friction(np.random.default_rng(seed)) for seed in range(40)]
VELOCITIES = np.random.default_rng(0).normal(size=(50, 2))


def gradient(function, at, step=1e-6):
    sides = [(function(at + step * e) - function(at - step * e)) / (2 * step) for e in np.eye(2)]
    return np.stack(sides, axis=-1)


@pytest.mark.parametrize("law", LAWS[:8])
@pytest.mark.parametrize("frame", [0.0, 0.7, -2.9])
def test_traction_is_the_gradient_of_dissipation_in_any_frame(law, frame):
    found = law.traction(VELOCITIES, frame)
    assert np.allclose(found, gradient(lambda v: law.dissipation(v, frame), VELOCITIES), atol=1e-8)


@pytest.mark.parametrize("law", LAWS[:8])
def test_power_of_the_traction_is_the_dissipation(law):
    power = (law.traction(VELOCITIES) * VELOCITIES).sum(-1)
    assert np.allclose(power, law.dissipation(VELOCITIES), rtol=1e-13)


@pytest.mark.parametrize("law", LAWS[:8])
def test_a_turned_frame_sees_the_same_forces_turned_back(law):
    angle = 1.1
    turn = np.array(((math.cos(angle), -math.sin(angle)), (math.sin(angle), math.cos(angle))))
    seen = law.traction(VELOCITIES @ turn, frame=angle) @ turn.T
    assert np.allclose(seen, law.traction(VELOCITIES), atol=1e-14)
    turned = law.turned(angle).traction(VELOCITIES @ turn.T) @ turn
    assert np.allclose(turned, law.traction(VELOCITIES), atol=1e-14)


def test_dissipation_is_positive_in_every_direction_up_to_the_limit_of_the_centre():
    angle = np.linspace(0.0, 2.0 * np.pi, 721)
    around = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    assert all(law.dissipation(around).min() > 0.0 for law in LAWS)
    edge = EllipseFriction(0.3, 0.2, 0.3 * 0.999999 * math.cos(1.0), 0.2 * 0.999999 * math.sin(1.0))
    assert 0.0 < edge.dissipation(around).min() < 1e-5


@pytest.mark.parametrize("law", LAWS)
def test_no_other_force_of_the_ellipse_dissipates_more(law):
    others = law.traction(np.random.default_rng(1).normal(size=(200, 2)))
    own = law.dissipation(VELOCITIES)
    assert (own[:, None] - VELOCITIES @ others.T).min() >= -1e-14


def test_isotropic_friction_opposes_the_velocity_with_one_coefficient():
    found = EllipseFriction.isotropic(0.3).turned(0.4).traction(VELOCITIES, frame=1.3)
    assert np.allclose(found, 0.3 * VELOCITIES / np.hypot(*VELOCITIES.T)[:, None], atol=1e-15)


@pytest.mark.parametrize(
    ("values", "named"),
    [
        ((0.25, 0.2, 0.25, 0.0), "m0=0.25"),
        ((0.25, 0.2, 0.2, 0.15), "n0=0.15"),
        ((0.0, 0.2), "mu_a"),
        ((0.2, -0.1), "-0.1"),
        ((float("nan"), 0.2), "nan"),
        ((0.2, 0.2, float("inf")), "m0"),
        ((0.2, 0.2, 0.0, 0.0, "1"), "phi"),
        ((True, 0.2), "mu_a"),
    ],
)
def test_a_law_that_cannot_be_is_refused_by_name(values, named):
    with pytest.raises(InvalidInput, match=named) as refused:
        EllipseFriction(*values)
    assert "\n" not in str(refused.value)


def test_traction_at_rest_and_bad_velocities_are_refused():
    law = EllipseFriction.isotropic(0.3)
    with pytest.raises(InvalidInput, match="zero"):
        law.traction([[1.0, 0.0], [0.0, 0.0]])
    with pytest.raises(InvalidInput, match="shape"):
        law.dissipation([1.0, 2.0, 3.0])
    with pytest.raises(InvalidInput, match="finite"):
        law.dissipation([1.0, float("nan")])
