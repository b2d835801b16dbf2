"""The nearest place of an outline, against a search over the outline itself."""

from itertools import pairwise

import casadi as ca
import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.mechanics import MIT_SHAPE_NAMES, Ellipse, Polygon, Slider
from cyclemap.mechanics.dynamics.nearest_place import nearest_place

OUTLINES = {name: Slider.mit(name).outline for name in MIT_SHAPE_NAMES} | {"slim": Ellipse(0.08, 0.02)}


def nearest_places(outline, places: np.ndarray) -> np.ndarray:
    """The nearest place of the outline to each place (2, n)."""
    x, y = ca.SX.sym("x"), ca.SX.sym("y")
    function = ca.Function("nearest", [x, y], [ca.vertcat(*nearest_place(outline, x, y))])
    return np.array(function(places[:1], places[1:]))


def around(outline, gap: float) -> np.ndarray:
    """Places (2, 40) about 5 mm outside."""
    random = np.random.default_rng(4)
    angle, found = random.uniform(0.0, 2.0 * np.pi, 40), []
    dense = dense_outline(outline)
    for a in angle:
        ray = np.array((np.cos(a), np.sin(a)))
        rim = dense[np.argmax((dense - dense.mean(axis=0)) @ ray)]
        found.append(rim + gap * ray)
    return np.array(found).T


def dense_outline(outline) -> np.ndarray:
    corners = outline.points(20_001)
    if isinstance(outline, Ellipse):
        return corners
    share = np.linspace(0.0, 1.0, 4_001)[:, None]
    return np.concatenate([a + share * (b - a) for a, b in pairwise(corners)])


@pytest.mark.parametrize("name", OUTLINES)
def test_no_place_of_the_outline_is_nearer(name):
    outline = OUTLINES[name]
    places = around(outline, 0.00475)
    found = nearest_places(outline, places)
    dense = dense_outline(outline)
    for place, nearest in zip(places.T, found.T, strict=True):
        searched = np.hypot(*(dense - place).T).min()
        assert np.hypot(*(nearest - place)) == pytest.approx(searched, abs=1e-7)
        # The place itself lies on the outline.
        assert np.hypot(*(dense - nearest).T).min() < 4e-5
    assert found.shape == (2, 40)


def test_a_concave_outline_is_refused():
    concave = Polygon(((1.0, 1.0), (0.0, 0.2), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)))
    with pytest.raises(InvalidInput, match="convex"):
        nearest_place(concave, ca.SX.sym("x"), ca.SX.sym("y"))
