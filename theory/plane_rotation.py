"""Rotations of the plane, which every derivation about directions uses."""

import sympy as sp


def rotation(angle: sp.Expr) -> sp.Matrix:
    """Return the matrix that turns vectors of the plane by an angle (rad), counter-clockwise."""
    return sp.Matrix([[sp.cos(angle), -sp.sin(angle)], [sp.sin(angle), sp.cos(angle)]])
