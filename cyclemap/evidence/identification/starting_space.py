"""Where an identification starts, and what it takes for granted: the protocol's facts, or a material to start from."""

from __future__ import annotations

from dataclasses import fields, replace

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.parameter_space import Parameter, ParameterSpace
from cyclemap.evidence.identification.surface_parameters import SURFACE, SurfaceParameters, share_unknowns
from cyclemap.mechanics import Material, PatchFootprint, PointFootprint

# A start on a bound goes inside by this share of the way to the other one.
_INSIDE = 0.01


def starting_space(loop: CollectionLoop, start: Material | None = None) -> ParameterSpace:
    """Return the unknowns of a surface, what is neither free nor given having the loop's value.

    start : a material from which every search begins; its friction, and what was found with it, then also stand for
    what is not free. Raises InvalidInput for a footprint of points, which no block of data takes.

    >>> space = starting_space(CollectionLoop.mit("isotropic"))
    >>> space["pusher_friction"].nominal, space["rim_share"].nominal
    (0.15, 0.0)
    """
    values = _loop_values(loop)
    if start is None:
        return ParameterSpace(tuple(replace(one, nominal=values[one.name]) for one in SURFACE.parameters))
    friction = SurfaceParameters.from_friction(start.friction).values()
    values |= {name: friction[name] for name in SURFACE.names[:5]}
    found = {field.name: getattr(start.found_with, field.name) for field in fields(start.found_with)}
    told = {name: value for name, value in found.items() if value is not None}
    pressure = start.pressure_of(loop.slider.name)
    if pressure is not None:
        values |= share_unknowns(PatchFootprint(loop.slider.outline, **pressure.shares))  # type: ignore[arg-type]
    values |= {name: value for name, value in told.items() if name in SURFACE.names}
    return ParameterSpace(tuple(_from(one, values[one.name]) for one in SURFACE.parameters))


def _loop_values(loop: CollectionLoop) -> dict[str, float]:
    if isinstance(loop.footprint, PointFootprint):
        raise InvalidInput("identification takes the exact footprint: leave footprint=grid out")
    footprint = loop.footprint or PatchFootprint(loop.slider.outline)
    surface = SurfaceParameters.from_friction(
        loop.material.friction,
        pusher_friction=loop.pusher.friction,
        **share_unknowns(footprint),
        pin_friction_radius=loop.reset.pin_friction_radius,
    )
    return surface.values()


def _from(parameter: Parameter, value: float) -> Parameter:
    """The parameter with its search starting from a value, or a little inside the bound it lies on."""
    margin = _INSIDE * (parameter.upper - parameter.lower)
    start = min(max(value, parameter.lower + margin), parameter.upper - margin)
    return replace(parameter, start=start, nominal=value)
