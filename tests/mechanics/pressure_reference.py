"""A second route to a footprint's friction: plain numerical quadrature of its definition, in
extended precision.

Seen from the centre of rotation the integrands are powers of the distance, so that few radial nodes
are exact; around the rim Gauss's rule runs on panels that shrink towards the places nearest to the
centre. No closed form, no velocity plane, no homogeneity of D. Where the centre is far or at
infinity, a fine area rule.
"""

import math

import numpy as np
from sympy.integrals.quadrature import gauss_legendre

from cyclemap.mechanics import Ellipse, PointFootprint, Polygon

REAL = np.longdouble
INNER = 0.55
FAR = 4.0
TURN = 2 * REAL("3.14159265358979323846264")


def _gauss(count):
    """Nodes and weights on [0, 1], beyond double precision."""
    nodes, weights = (
        np.array([REAL(str(one)) for one in values]) for values in gauss_legendre(count, 25)
    )
    return (1 + nodes) / 2, weights / 2


NODE, WEIGHT = _gauss(20)
# Powers of the distance up to the third.
RADIUS, RADIAL = _gauss(2)


def reference(footprint, law, twist, frame=0.0):
    """Return D, grad D (3,), Hessian (3, 3) at a twist of the footprint's frame, per unit load."""
    twist = np.asarray(twist, REAL)
    matrix = traction_matrix(law, frame)
    found = [REAL(0), np.zeros(3, REAL), np.zeros((3, 3), REAL)]
    moment = np.zeros(2, REAL)
    for points, weights in rules(footprint, matrix, twist):
        speed, slope, bend = _density(matrix, points, twist)
        for k, part in enumerate(
            (weights @ speed, weights @ slope, np.tensordot(weights, bend, 1))
        ):
            found[k] = found[k] + part
        moment += weights @ points
    # The ellipse's centre acts as a constant force at the centre of pressure.
    c, s = math.cos(law.phi - frame), math.sin(law.phi - frame)
    fx, fy = c * law.m0 - s * law.n0, s * law.m0 + c * law.n0
    constant = np.array((fx, fy, moment[0] * fy - moment[1] * fx))
    return found[0] + constant @ twist, found[1] + constant, found[2]


def traction_matrix(law, frame):
    """M with s = |M v|."""
    c, s = REAL(math.cos(law.phi - frame)), REAL(math.sin(law.phi - frame))
    return np.array(((law.mu_a * c, law.mu_a * s), (-law.mu_b * s, law.mu_b * c)))


def rules(footprint, matrix, twist):
    """Points (n, 2) and loads (n,) for each part of the pressure, fit for a twist."""
    if isinstance(footprint, PointFootprint):
        return [tuple(map(REAL, footprint.quadrature))]
    outline, middle = footprint.outline, np.array(footprint.outline.centroid, REAL)
    found = [(footprint.even_share, _area_rule(outline, matrix, twist))]
    if footprint.inner_share:
        found.append((footprint.inner_share, _area_rule(_inside(outline), matrix, twist)))
    if footprint.rim_share:
        found.append((footprint.rim_share, _line_rule(outline, matrix, twist)))
    if footprint.corner_share:
        found.append(
            (
                footprint.corner_share,
                (outline.array.astype(REAL), np.full(outline.sides, REAL(1)) / outline.sides),
            )
        )
    scaled = [(points, REAL(share) * weights) for share, (points, weights) in found]
    points, weights = found[0][1]
    return [*scaled, (points, weights * ((points - middle) @ np.array(footprint.gradient, REAL)))]


def _inside(outline):
    if isinstance(outline, Ellipse):
        return Ellipse(INNER * outline.semi_x, INNER * outline.semi_y)
    centre = np.array(outline.centroid)
    return Polygon(tuple(map(tuple, centre + INNER * (outline.array - centre))))


def _density(matrix, points, twist):
    """|M v| and its derivatives by the twist, at points: (n,), (n, 3), (n, 3, 3)."""
    turned = np.stack([-points[:, 1], points[:, 0]], axis=-1)
    w = (twist[:2] + twist[2] * turned) @ matrix.T
    speed = np.maximum(np.hypot(*w.T), REAL(1e-300))
    jacobian = np.zeros((len(w), 2, 3), REAL)
    jacobian[:, :, :2] = matrix
    jacobian[:, :, 2] = turned @ matrix.T
    along = w / speed[:, None]
    slope = (along[:, :, None] * jacobian).sum(axis=1)
    across = (
        jacobian[:, :, None]
        * np.array(((0, 1), (-1, 0)), REAL)[None, :, :, None]
        * along[:, None, :, None]
    ).sum((1, 2))
    return speed, slope, across[:, :, None] * across[:, None, :] / speed[:, None, None]


def _centre(outline, matrix, twist):
    """The centre of rotation; none where it is far, as the friction sees it."""
    middle = np.array(outline.centroid, REAL)
    at_middle = matrix @ (twist[:2] + twist[2] * np.array((-middle[1], middle[0])))
    if abs(twist[2]) * outline.extent * FAR * np.abs(matrix).max() < np.hypot(*at_middle):
        return None
    return np.array((-twist[1], twist[0])) / twist[2]


def _area_rule(outline, matrix, twist):
    centre = _centre(outline, matrix, twist)
    apex = np.array(outline.centroid, REAL) if centre is None else centre
    rim, step = (
        np.concatenate(column)
        for column in zip(*_rim(outline, matrix, apex, centre is None), strict=True)
    )
    p = rim - apex
    cross = p[:, 0] * step[:, 1] - p[:, 1] * step[:, 0]
    share, weight = (NODE, WEIGHT) if centre is None else (RADIUS, RADIAL)
    points = apex + share[:, None, None] * p
    weights = (share * weight)[:, None] * cross
    return points.reshape(-1, 2), weights.ravel() / _area(outline)


def _area(outline):
    if isinstance(outline, Ellipse):
        return REAL(outline.semi_x) * REAL(outline.semi_y) * TURN / 2
    x, y = (outline.array.astype(REAL) - np.array(outline.centroid, REAL)).T
    return (x * np.roll(y, -1) - y * np.roll(x, -1)).sum() / 2


def _line_rule(outline, matrix, twist):
    """A side's load goes with its distance from the centroid; on an ellipse the load is even in the
    eccentric angle.
    """
    centre = _centre(outline, matrix, twist)
    centre = np.array(outline.centroid, REAL) if centre is None else centre
    if isinstance(outline, Ellipse):
        tau, weight = _angles(outline, matrix, centre)
        return _on_ellipse(outline, tau)[0], weight / weight.sum()
    middle, points, loads = np.array(outline.centroid, REAL), [], []
    for rim, step in _rim(outline, matrix, centre):
        edge = step.sum(axis=0)
        length = np.hypot(*edge)
        distance = ((rim[0] - middle)[0] * edge[1] - (rim[0] - middle)[1] * edge[0]) / length
        points.append(rim)
        loads.append(distance * np.hypot(*step.T))
    return np.concatenate(points), np.concatenate(loads) / (2 * _area(outline))


def _rim(outline, matrix, centre, far=False):
    """Points of the rim and steps times weights, part by part."""
    if isinstance(outline, Ellipse):
        tau, weight = (
            _panels(TURN * np.arange(13) / 12) if far else _angles(outline, matrix, centre)
        )
        place, step = _on_ellipse(outline, tau)
        yield place, step * weight[:, None]
        return
    corners = outline.array.astype(REAL)
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        # Nearest as the friction sees it.
        start, edge = (matrix @ np.array((-v[1], v[0])) for v in (a - centre, b - a))
        foot = np.clip(-(start @ edge) / (edge @ edge), 0, 1)
        breaks = [foot - _shrinking(foot), foot + _shrinking(1 - foot)]
        t, w = (NODE, WEIGHT) if far else _panels(np.concatenate(breaks))
        yield a + t[:, None] * (b - a), w[:, None] * (b - a)


def _angles(outline, matrix, centre):
    """Eccentric angles and weights: panels shrink towards the nearest places, and towards the
    image's ends.
    """

    def speeds(tau):
        place = _on_ellipse(outline, tau)[0] - centre
        return np.hypot(*(np.stack([-place[..., 1], place[..., 0]], axis=-1) @ matrix.T).T)

    grid = np.arange(4_000) * TURN / 4_000
    size, width, near = speeds(grid), grid[1], []
    for k in np.flatnonzero((size <= np.roll(size, 1)) & (size < np.roll(size, -1))):
        low, high = grid[k] - width, grid[k] + width
        for _ in range(120):
            one, other = low + (high - low) * REAL(0.382), low + (high - low) * REAL(0.618)
            low, high = (low, other) if speeds(one) < speeds(other) else (one, high)
        near.append(low % TURN)
    breaks = [grid[::100], [TURN]]
    for place in near:
        for sign in (-1, 1):
            breaks.append((place + sign * _shrinking(REAL(1.0))) % TURN)
    return _panels(np.concatenate(breaks))


def _shrinking(length):
    return np.concatenate([[REAL(0)], length * REAL(0.25) ** np.arange(28, -1, -1)])


def _panels(breaks):
    breaks = np.unique(breaks)
    low, size = breaks[:-1, None], np.diff(breaks)[:, None]
    return (low + size * NODE).ravel(), (size * WEIGHT).ravel()


def _on_ellipse(outline, tau):
    c, s = np.cos(tau), np.sin(tau)
    a, b = REAL(outline.semi_x), REAL(outline.semi_y)
    return np.stack([a * c, b * s], axis=-1), np.stack([-a * s, b * c], axis=-1)
