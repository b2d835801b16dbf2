"""Roots of a function of one variable in many brackets at once."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from cyclemap.maps.arcs import Array
from cyclemap.maps.rounding import EPS

_CLOSE = 2.0 * EPS  # share of |x| (plus a thousandth) at which a bracket is closed
_STEPS = 120


def bracketed_root(function: Callable[[Array, npt.NDArray[np.int64]], Array], low: Array, high: Array) -> Array:
    """A root of f(x, i) in each bracket i, to rounding (Chandrupatla 1997): bisection or inverse quadratic steps.

    f takes points and the numbers of their brackets. Where it has one sign at both ends, the end nearer to zero.
    """
    index = np.arange(low.size)
    a, b = low.astype(np.float64), high.astype(np.float64)
    fa, fb = function(a, index), function(b, index)
    answer = np.where(np.abs(fa) < np.abs(fb), a, b)
    open_ = fa * fb < 0.0
    index, a, b, fa, fb = index[open_], a[open_], b[open_], fa[open_], fb[open_]
    share = np.full(index.size, 0.5)
    for _ in range(_STEPS):
        if index.size == 0:
            break
        x = a + share * (b - a)
        fx = function(x, index)
        stays = np.sign(fx) == np.sign(fa)
        c, fc = np.where(stays, a, b), np.where(stays, fa, fb)
        b, fb = np.where(stays, b, a), np.where(stays, fb, fa)
        a, fa = x, fx
        answer[index] = np.where(np.abs(fa) < np.abs(fb), a, b)
        reach = _CLOSE * (np.abs(a) + 1e-3) / np.maximum(np.abs(b - a), 1e-300)
        share = np.clip(_next_share(a, b, c, fa, fb, fc), reach, 1.0 - reach)
        go = (reach < 0.5) & (fa != 0.0)
        index, a, b, fa, fb, share = index[go], a[go], b[go], fa[go], fb[go], share[go]
    return answer


def _next_share(a: Array, b: Array, c: Array, fa: Array, fb: Array, fc: Array) -> Array:
    """Where in [a, b] to look next: by inverse quadratic interpolation where it can be trusted, else the middle."""
    with np.errstate(divide="ignore", invalid="ignore"):
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        trusted = (phi**2 < xi) & ((1.0 - phi) ** 2 < 1.0 - xi)
        share = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
    return np.where(trusted & np.isfinite(share), share, 0.5)
