"""The unknowns of a surface are smooth through isotropy, turn with the world, and chain derivatives
exactly.
"""

import numpy as np
import pytest
from refusals import refused

from cyclemap.evidence import Parameter, ParameterSpace, SurfaceParameters
from cyclemap.evidence.identification.surface_parameters import SURFACE
from cyclemap.mechanics import EllipseFriction

ROUND = EllipseFriction(0.2, 0.2)
DIRECTIONS = np.linspace(0.0, 2 * np.pi, 7, endpoint=False)
VELOCITIES = np.stack([np.cos(DIRECTIONS), np.sin(DIRECTIONS)], axis=-1)


def test_friction_to_parameters_and_back_is_the_same_limit_curve() -> None:
    rng = np.random.default_rng(0)
    for _ in range(50):
        axes, offset = rng.uniform(0.1, 0.5, 2), rng.uniform(-0.05, 0.05, 2)
        friction = EllipseFriction(*axes, *offset, rng.uniform(-7.0, 7.0))
        back = SurfaceParameters.from_friction(friction, plate_dome=0.7).to_friction()
        expected = friction.dissipation(VELOCITIES)
        assert np.allclose(back.dissipation(VELOCITIES), expected, rtol=1e-13)
        assert back.mu_a >= back.mu_b


def test_turning_the_surface_turns_offset_once_and_ellipticity_twice() -> None:
    friction, angle = EllipseFriction(0.3, 0.2, 0.03, -0.02, 0.4), 0.83
    before, after = map(SurfaceParameters.from_friction, (friction, friction.turned(angle)))
    assert after.friction_scale == before.friction_scale
    offset, turned = (complex(surface.offset_x, surface.offset_y) for surface in (before, after))
    assert abs(turned - offset * np.exp(1j * angle)) < 1e-15
    axis, twice = (complex(row.ellipticity_x, row.ellipticity_y) for row in (before, after))
    assert abs(twice - axis * np.exp(2j * angle)) < 1e-15


def test_a_space_selects_and_extends_by_name_and_begins_at_the_nominal_surface() -> None:
    assert SURFACE.nominal == SurfaceParameters().values()
    assert SurfaceParameters.from_values({**SURFACE.nominal, "tilt": 1.0}) == SurfaceParameters()
    bias = Parameter("bias", "a shift", "m", -1.0, 1.0, 0.0, 0.1)
    space = SURFACE.extended(bias).select(("bias", "plate_dome"))
    told = space.values(space.vector({"plate_dome": 0.1, "bias": 2.0, "other": 3.0}))
    assert list(told.items()) == [("bias", 2.0), ("plate_dome", 0.1)]


@pytest.mark.parametrize(
    ("asked", "words"),
    [
        (lambda: SurfaceParameters(plate_dome=90.0), r"plate_dome is 90\.0"),
        (SurfaceParameters(offset_x=0.9, ellipticity_x=-0.5).to_friction, "not contain zero"),
        (lambda: SurfaceParameters.from_friction(ROUND, plate_dom=1.0), "did you mean 'plate_d"),
        (lambda: Parameter("x", "", "1", 0.0, 1.0, 0.0, 1.0), "strictly between"),
        (lambda: ParameterSpace((SURFACE["plate_dome"], SURFACE["plate_dome"])), "named twice"),
        (lambda: SURFACE.select(("plate_dome",)).vector({}), "no value for plate_dome"),
    ],
)
def test_what_cannot_be_a_surface_is_refused_by_name(asked, words) -> None:
    refused(asked, told=words)
