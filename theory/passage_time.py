"""Cycles through the bottleneck that a saddle-node leaves: x' = x + ε + a x², by the flow, to
higher order, exactly.

x is the distance from the slowest point (rad), ε > 0 the gap (rad a cycle), a > 0 the curvature
(1/rad). To leading order the passage takes π/√(aε) cycles (Pomeau & Manneville 1980).
"""

import sympy as sp

GAP, CURVATURE = sp.symbols("epsilon a", positive=True)
PLACE = sp.Symbol("x", real=True)
REACH = sp.Symbol("X", positive=True)
ORDER = sp.Symbol("eta", positive=True)


def move() -> sp.Expr:
    """Return what one cycle moves the orbit by, ε + a x²."""
    return GAP + CURVATURE * PLACE**2


def flow_time() -> sp.Expr:
    """Return the time of the flow dx/dt = ε + a x² from 0 to x: arctan(x √(a/ε))/√(aε), cycles."""
    return sp.atan(PLACE * sp.sqrt(CURVATURE / GAP)) / sp.sqrt(CURVATURE * GAP)


def passage_time() -> sp.Expr:
    """Return the time from -∞ to ∞, π/√(aε), cycles."""
    return 2 * sp.limit(sp.atan(PLACE), PLACE, sp.oo) / sp.sqrt(CURVATURE * GAP)


def end_correction() -> sp.Expr:
    """Return what the flow from -X to X takes less than the whole passage: -2/(aX) + 2ε/(3a²X³) +
    O(ε²), cycles.
    """
    # arctan y = π/2 - arctan(1/y), and arctan(1/y) = 1/y - 1/(3y³) + ...
    beyond = (
        sp.series(sp.atan(PLACE), PLACE, 0, 5)
        .removeO()
        .subs(PLACE, sp.sqrt(GAP / CURVATURE) / REACH)
    )
    return sp.expand(-2 * beyond / sp.sqrt(CURVATURE * GAP))


def interpolating_flow(step: sp.Expr) -> sp.Expr:
    """Return the field v = g - gg'/2 + gg'²/3 + g²g''/12 whose flow over one cycle is x + g(x), up
    to the order g⁴.
    """
    slope, bend = sp.diff(step, PLACE), sp.diff(step, PLACE, 2)
    return step - step * slope / 2 + step * slope**2 / 3 + step**2 * bend / 12


def time_one_map(field: sp.Expr) -> sp.Expr:
    """Return the displacement of a flow over one cycle, v + vv'/2 + v(vv')'/6 + ..., up to the
    order v⁴.
    """
    second = field * sp.diff(field, PLACE)
    return field + second / 2 + field * sp.diff(second, PLACE) / 6


def counting_time() -> sp.Expr:
    """Return T(x), whose difference counts the cycles of x' = x + ε + a x²: (1 + aε/3) arctan/√(aε)
    + ½ ln g - ax/2.

    It is the integral of 1/v, v the interpolating flow, to the order of g'²/g: the flow's time,
    aε/3 more of it, and terms of the ends.
    """
    return (1 + CURVATURE * GAP / 3) * flow_time() + sp.log(move()) / 2 - CURVATURE * PLACE / 2


def counted_passage() -> sp.Expr:
    """Return the cycles from -X to X to that order: 2 (1 + aε/3) arctan(X √(a/ε))/√(aε) - aX."""
    time = counting_time()
    return sp.expand(time.subs(PLACE, REACH) - time.subs(PLACE, -REACH))


def soluble_map() -> sp.Expr:
    """Return the Möbius map x' = (x + ε)/(1 - a x) = x + ε + a x² + higher terms, whose passage is
    known exactly.
    """
    return (PLACE + GAP) / (1 - CURVATURE * PLACE)


def soluble_angle() -> sp.Expr:
    """Return φ(x) = arctan(x √(a/ε)): the soluble map advances it by arctan √(aε) every cycle."""
    return sp.atan(PLACE * sp.sqrt(CURVATURE / GAP))


def soluble_passage() -> sp.Expr:
    """Return the cycles of the soluble map from -∞ to ∞, exactly: π/arctan √(aε) = π/√(aε) (1 +
    aε/3 - ...).
    """
    return sp.pi / sp.atan(sp.sqrt(CURVATURE * GAP))
