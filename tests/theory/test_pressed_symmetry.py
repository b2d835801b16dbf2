"""Shapes of plate and floor under isotropic friction: harmonics in symbols, and those of the code's
map.
"""

import math
from dataclasses import replace

import numpy as np
import sympy as sp

import cyclemap as cm
from cyclemap.mechanics import EllipseFriction, Material, PressedFootprint, SurfaceShape
from cyclemap.mechanics.cycle_batch import run_batch
from theory import pressed_symmetry as theory

LOOP = cm.CollectionLoop.mit(material="isotropic", accuracy=1e-9)
THETA = np.arange(16) * 2.0 * math.pi / 16


def harmonics(loop):
    """Size of each harmonic of the turn of a cycle, rad."""
    turn = run_batch((loop,), THETA[None]).theta_next[0] - THETA
    return np.abs(np.fft.rfft(turn)) / len(turn)


def on_floor(bow, loop=LOOP):
    floor = SurfaceShape(0.0, bow, 0.3)
    return replace(loop, footprint=PressedFootprint(loop.slider.outline, floor=floor))


def test_the_floor_turns_against_the_plate_by_its_bow_alone():
    assert theory.turned_bow_residual() == 0
    assert theory.half_turn_residual() == 0
    assert theory.turned_floor_residual() == 0
    assert not theory.shapes_without_bow().has(theory.THETA)


def test_a_bow_adds_the_second_harmonic_and_the_offset_the_first():
    responses = sp.symbols("u v", real=True)
    assert set(theory.first_order_harmonics(*responses)) == {2}
    assert set(theory.offset_harmonics(*responses)) == {1}


def test_three_supports_bear_what_balance_asks_for():
    loads = theory.loads_of_three_supports()
    assert not any(symbol.name.startswith("q") for symbol in loads.free_symbols)
    shapes = {
        symbol
        for symbol in theory.level_of_three_supports().free_symbols
        if symbol.name.startswith("q")
    }
    assert len(shapes) == 3


def test_the_codes_map_has_a_second_harmonic_that_grows_with_the_bow_and_a_fourth_with_its_square():
    # Bows that leave all of the plate in contact.
    small, twice = harmonics(on_floor(0.04)), harmonics(on_floor(0.08))
    assert np.all(small[1::2] < 1e-8) and np.all(twice[1::2] < 1e-8)
    assert abs(twice[2] / small[2] - 2.0) < 0.002
    assert abs(twice[4] / small[4] - 4.0) < 0.01


def test_an_offset_adds_a_first_harmonic_in_its_own_proportion_whatever_the_bow():
    first = []
    for share in (1.0, 2.0):
        law = EllipseFriction.isotropic(LOOP.material.friction.mu_a)
        law = replace(law, m0=0.002 * share, n0=0.001 * share)
        offset = replace(LOOP, material=Material("offset", law))
        found = harmonics(on_floor(0.04, offset))
        first.append(found[1])
        assert abs(found[1] / harmonics(offset)[1] - 1.0) < 0.02
        # What it adds to the others goes with its square.
        assert abs(found[2] / harmonics(on_floor(0.04))[2] - 1.0) < 0.06 * share**2
        assert found[3] < 0.01 * share**2 * found[2]
    assert abs(first[1] / first[0] - 2.0) < 0.01
