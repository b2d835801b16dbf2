"""What the theory says to vanish is exactly zero in symbols: every function named ..._residual."""

import inspect

import pytest
import sympy as sp

from theory import (
    contact_modes,
    moebius_drag,
    noisy_passage,
    offset_force,
    patch_dissipation,
    patch_limits,
    square_torque,
    traction_law,
    turned_surface,
)

COUNTS = {contact_modes: 15, offset_force: 6, patch_dissipation: 7, patch_limits: 6}
COUNTS |= {square_torque: 9, traction_law: 9, moebius_drag: 1, noisy_passage: 1, turned_surface: 2}
QUICK = (moebius_drag, noisy_passage, patch_dissipation, traction_law, turned_surface)


def residuals_of(module):
    found = [function for _, function in inspect.getmembers(module, inspect.isfunction)]
    own = [function for function in found if function.__module__ == module.__name__]
    return [function for function in own if function.__name__.endswith("_residual")]


CASES = [
    pytest.param(
        one,
        id=f"{one.__module__}.{one.__name__}",
        marks=[] if module in QUICK else pytest.mark.slow,
    )
    for module in COUNTS
    for one in residuals_of(module)
]


@pytest.mark.parametrize("residual", CASES)
def test_every_residual_is_exactly_zero(residual):
    found = residual()
    entries = list(found) if isinstance(found, sp.MatrixBase) else [found]
    assert entries and all(entry == sp.Integer(0) for entry in entries)


def test_none_is_left_out():
    assert {module: len(residuals_of(module)) for module in COUNTS} == COUNTS
