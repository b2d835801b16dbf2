"""Fronts of bias against cost: one search for each cost allowed, and strategies of any schedule beside them."""

import numpy as np
import pytest

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import WrappedNormal
from cyclemap.maps.mixtures.fourier_law import FourierLaw
from cyclemap.mechanics import EllipseFriction, Material, SidePush
from cyclemap.resets.parameters.parameter_gradient import Resolution
from cyclemap.resets.parameters.parameter_search import AGREEMENT
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.parameters.pareto_front import pareto_front
from cyclemap.resets.parameters.pareto_search import FRONT_SCORES, scored_candidate, search_front
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes

SHORT = SidePush(distance=0.06)
EVEN = CollectionLoop.mit(Material("even", EllipseFriction.isotropic(0.25)), push=SHORT, accuracy=1e-6)
WIDE = WrappedNormal(0.8)  # so wide that the first harmonic is always the slowest
COARSE = Resolution(samples=8, modes=16, nodes=4, pushes=2)
# The first push as it is, the second's distance free.
SECOND = StrategyFamily(
    "second push",
    ("distance",),
    (0.03,),
    (0.12,),
    lambda v: DrawnPushes((SHORT, SidePush(2, distance=v[0]))),
)


def test_a_front_falls_as_more_is_allowed():
    """Mixing against drag on an even surface: more drag buys less |lambda_2|, so that every search is on the front, its
    limit binds, and all values are those of adaptive maps."""
    names, seen = ("second_eigenvalue", "mean_drag_length"), []
    options = {"starts": 1, "iterations": 8, "resolution": COARSE}
    made = search_front(
        EVEN, (SECOND,), WIDE, (0.045, 0.055), bias=names[0], names=names, progress=seen.append, **options
    )
    assert len(made.searches) == 2 and seen == [0.5, 1.0]
    front = made.front
    assert front.names == names and len(front.candidates) == 2 and not front.dominated
    assert np.abs(front.points[:, 1] - (0.055, 0.045)).max() < 1e-4 and front.points[0, 0] < front.points[1, 0] - 0.05
    assert all(search.binding == ("mean_drag_length",) for search in made.searches)
    assert all(search.disagreement < AGREEMENT for search in made.searches)
    with pytest.raises(InvalidInput, match="keeps the limits"):
        search_front(EVEN, (SECOND,), WIDE, (0.001,), starts=1, iterations=1, resolution=COARSE, check=False)


def test_a_strategy_of_any_schedule_joins_a_front():
    """Pushes that alternate are rotations on an even surface: uniform in the long run, and after n pushes from anywhere
    a wrapped normal law of n variances; drawn ones mix more, at the same drag."""
    pushes, noise = (SHORT, SidePush(2, distance=0.12)), WrappedNormal(0.6)
    rows = [
        scored_candidate(EVEN, kind(pushes), noise, resolution=COARSE, tolerance=1e-2)
        for kind in (AlternatingPushes, DrawnPushes)
    ]
    alternating, drawn = (np.asarray(row.values) for row in rows)
    assert max(alternating[0], drawn[0]) < 1e-6 and abs(alternating[1] - drawn[1]) < 1e-9
    orders = np.arange(17)
    law = FourierLaw(noise.coefficients(orders) ** COARSE.pushes)
    assert abs(alternating[2] - float(law.total_variation())) < 1e-4 and drawn[2] < alternating[2] - 0.05
    assert [row.title for row in rows] == ["alternating pushes", "drawn pushes"]
    front = pareto_front(rows, FRONT_SCORES)
    assert front.best("reach").title == "drawn pushes" and len(front.candidates) + len(front.dominated) == 2
