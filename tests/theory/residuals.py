"""Collects what a theory module claims to vanish."""

import inspect

import sympy as sp


def residuals(module):
    """Return {name: function} of the module's own functions named ..._residual."""
    found = inspect.getmembers(module, inspect.isfunction)
    return {name: f for name, f in found if name.endswith("_residual") and f.__module__ == module.__name__}


def vanishes(expression):
    """Whether an expression, or every entry of a matrix, is exactly the number zero."""
    entries = list(expression) if isinstance(expression, sp.MatrixBase) else [expression]
    return len(entries) > 0 and all(entry == sp.Integer(0) for entry in entries)
