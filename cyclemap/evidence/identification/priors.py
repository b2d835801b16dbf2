"""Weak beliefs about parameters, as rows of data of their own: where few data speak, they say what is usual."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from types import MappingProxyType

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import finite_number, positive_number
from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Values

PRIOR_KIND = "prior (standard deviations)"


def prior_block(beliefs: Mapping[str, tuple[float, float]], name: str = "priors") -> FunctionBlock:
    """Return beliefs (value, standard deviation) about parameters by name, in SI units, as a block of data.

    A row is the parameter's distance from the believed value in standard deviations; its noise is known to be 1: give
    `noise={PRIOR_KIND: 1.0, ...}` to `identify`. Raises InvalidInput for no belief or a deviation that is not positive.

    >>> prior_block({"pusher_friction": (0.15, 0.03)}).residuals({"pusher_friction": 0.18})[0].round(9).tolist()
    [1.0]
    """
    if not beliefs:
        raise InvalidInput("a block of priors needs a belief about one parameter at least")
    names = tuple(beliefs)
    centre = np.array([finite_number(f"believed {key}", beliefs[key][0]) for key in names])
    width = np.array([positive_number(f"deviation of the believed {key}", beliefs[key][1]) for key in names])

    def function(values: Values) -> tuple[Array, Array]:
        return (np.array([values[key] for key in names]) - centre) / width, np.diag(1.0 / width)

    return FunctionBlock(name, names, function, np.arange(len(names)), np.full(len(names), PRIOR_KIND))


# What is usual: how anisotropic floors are, rods and rings of steel on steel, how plates press, how well the frames of
# a robot and a camera agree. Wide enough that data which know better overrule it.
USUAL = MappingProxyType(
    {
        "ellipticity_x": (0.0, 0.2),
        "ellipticity_y": (0.0, 0.2),
        "offset_x": (0.0, 0.15),
        "offset_y": (0.0, 0.15),
        "pusher_friction": (0.15, 0.05),
        "rim_share": (0.2, 0.3),
        "corner_share": (0.1, 0.3),
        "inner_share": (0.2, 0.4),
        "pin_friction_radius": (1.5e-3, 1e-3),
        "tip_offset_x": (0.0, 1.5e-3),
        "tip_offset_y": (0.0, 1.5e-3),
    }
)


def usual_beliefs(names: Sequence[str]) -> dict[str, tuple[float, float]]:
    """Return what is usual (value, standard deviation) of those parameters of which it is known, of any plate.

    >>> usual_beliefs(["rim_share[hex]", "friction_scale"])
    {'rim_share[hex]': (0.2, 0.3)}
    """
    return {name: USUAL[plain] for name in names if (plain := name.partition("[")[0]) in USUAL}
