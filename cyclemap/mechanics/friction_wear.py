"""Friction between two states of wear: the limit ellipse moves in a straight line from the one to the other."""

from __future__ import annotations

import math

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.mechanics.friction import EllipseFriction


def worn_friction(fresh: EllipseFriction, worn: EllipseFriction, share: float) -> EllipseFriction:
    """Return the friction a `share` (0 to 1) of the way from `fresh` to `worn`.

    A limit ellipse (Ma & Rodriguez 2018, Eq. 1) is its centre c = R(φ)(m0, n0) and its shape matrix
    S = R(φ) diag(mu_a², mu_b²) R(φ)ᵀ in the surface's own axes; both go in a straight line, so that angles that name
    the same ellipse (φ, φ + π; φ + π/2 with the axes exchanged) make no difference. S stays positive definite, and
    cᵀ S⁻¹ c, which must be below one, is jointly convex in (c, S): it stays below the larger of its ends. The ends
    are returned as they were given; between them mu_a belongs to the axis nearest to that of `fresh`.

    >>> between = worn_friction(EllipseFriction(0.3, 0.3), EllipseFriction(0.4, 0.3, m0=0.1), 0.5)
    >>> round(between.mu_a, 6), between.mu_b, between.m0
    (0.353553, 0.3, 0.05)
    """
    share = finite_number("share of wear", share)
    if not 0.0 <= share <= 1.0:
        raise InvalidInput(f"share of wear is {share:g}: it runs from 0 (fresh) to 1 (worn)")
    if share in (0.0, 1.0) or fresh == worn:
        return worn if share == 1.0 else fresh
    (centre0, shape0), (centre1, shape1) = _ellipse(fresh), _ellipse(worn)
    squares, axes = np.linalg.eigh((1.0 - share) * shape0 + share * shape1)
    first = _axis(fresh.phi)
    main = axes[:, np.argmax(np.abs(first @ axes))]
    main = main if main @ first >= 0.0 else -main
    other = np.array([-main[1], main[0]])
    along = np.argmax(np.abs(main @ axes))
    centre = (1.0 - share) * centre0 + share * centre1
    mu_a, mu_b = math.sqrt(squares[along]), math.sqrt(squares[1 - along])
    return EllipseFriction(
        mu_a, mu_b, float(centre @ main), float(centre @ other), math.atan2(float(main[1]), float(main[0]))
    )


def _axis(angle: float) -> np.ndarray:
    return np.array([math.cos(angle), math.sin(angle)])


def _ellipse(law: EllipseFriction) -> tuple[np.ndarray, np.ndarray]:
    """Centre (2,) and shape matrix (2, 2) in the surface's axes."""
    rotation = np.stack([_axis(law.phi), _axis(law.phi + math.pi / 2.0)], axis=1)
    return rotation @ (law.m0, law.n0), rotation @ np.diag([law.mu_a**2, law.mu_b**2]) @ rotation.T
