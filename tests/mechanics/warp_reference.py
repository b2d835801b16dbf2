"""A second route to a warped footprint's dissipation: its pressure from the definition, by plain quadrature."""

import numpy as np
from patch_reference import Pressure, area_rule, under_pressure

from cyclemap.mechanics import Ellipse, Polygon

INNER = 0.8


def inner_of(outline):
    """The inner outline, made here once more."""
    if isinstance(outline, Ellipse):
        return Ellipse(INNER * outline.semi_x, INNER * outline.semi_y)
    centre = np.array(outline.centroid)
    return Polygon(tuple(map(tuple, centre + INNER * (outline.array - centre))))


def frame_rule(outline):
    """Levers and weights, positive and negative, of the mean over the frame: that of the whole less the inner part."""
    points, weights = area_rule(outline)
    inside, lighter = area_rule(inner_of(outline))
    lever = np.concatenate([points, inside]) - outline.centroid
    return lever, np.concatenate([weights, -(INNER**2) * lighter]) / (1.0 - INNER**2)


def saddle(outline, warp):
    """a q_a + b q_b as a Pressure: the saddles made orthogonal to 1, x, y on the frame, one after the other."""
    lever, weights = frame_rule(outline)
    x, y = lever.T
    raw = (warp[0] * (x * x - y * y) + warp[1] * 2.0 * x * y) / outline.extent**2
    basis = []
    for mode in (np.ones_like(x), x / outline.extent, y / outline.extent):
        rest = mode - sum((weights @ (mode * b)) * b for b in basis)
        basis.append(rest / np.sqrt(weights @ rest**2))
    projected = sum((weights @ (raw * b)) * b for b in basis)
    (gx, gy, constant), *_ = np.linalg.lstsq(np.column_stack([x, y, np.ones_like(x)]), -projected, rcond=1e-14)
    bend = np.array(((warp[0], warp[1]), (warp[1], -warp[0]))) / outline.extent**2
    return Pressure(constant, (gx, gy), bend)


def parts_of(footprint):
    """Factor, region and pressure of the means that make up a footprint: even part and lean, rim's part and saddles."""
    outline, w, q = footprint.outline, footprint.rim_share, saddle(footprint.outline, footprint.warp)
    frame_of_share = Pressure(w + q.constant, q.gradient, q.bend)
    return (
        (1.0, outline, Pressure(1.0 - w, footprint.gradient)),
        (1.0 / (1.0 - INNER**2), outline, frame_of_share),
        (-(INNER**2) / (1.0 - INNER**2), inner_of(outline), frame_of_share),
    )


def by_quadrature(footprint, law, twist, frame):
    """D, its gradient and Hessian, each part over its own region."""
    terms = [
        [factor * part for part in under_pressure(region, law, twist, frame, pressure)]
        for factor, region, pressure in parts_of(footprint)
    ]
    return [sum(term[i] for term in terms) for i in range(3)]
