"""Units of force, mass and length change no push and no drag."""

from dataclasses import replace

import numpy as np
import pytest
from random_cases import random_case, sized

from cyclemap.mechanics import EllipseFriction

SEEDS = (0, 6, 11, 25)
every_case = pytest.mark.parametrize("seed", SEEDS)


def outcome(case):
    """Turns of push and drag, displacement in the initial frame."""
    push, drag = case.run()
    return np.array((push.turn, drag.turn, *push.displacement))


def accurate(seed):
    return random_case(seed, accuracy=1e-9)


@every_case
def test_scaling_every_friction_force_and_the_mass_changes_no_digit(seed):
    """Nothing of the engine is measured in absolute friction."""
    case, law = accurate(seed), accurate(seed).model.friction
    for factor in (1e-9, 1e-4, 7.0, 1e3):
        scaled = EllipseFriction(
            *(factor * v for v in (law.mu_a, law.mu_b, law.m0, law.n0)), law.phi
        )
        model = replace(case.model, friction=scaled, slider=replace(case.model.slider, mass=factor))
        assert np.abs(outcome(replace(case, model=model)) - outcome(case)).max() < 1e-12


@every_case
def test_scaling_every_length_scales_displacements_and_nothing_else(seed):
    case = accurate(seed)
    for factor in (1e-4, 300.0):
        found = outcome(sized(case, factor))
        assert np.abs(found / (1.0, 1.0, factor, factor) - outcome(case)).max() < 1e-8
