"""Planes and curves on executors: the numbers are those of one thread, and progress rises to 1."""

from concurrent.futures import ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import fields, is_dataclass

import numpy as np
import pytest

from cyclemap.maps import CircleMap, bifurcation_curves, lyapunov_exponents, rotation_plane, tongues


def one_by_one(omega, strength):
    """The sine family as a plain function, that no formula is known of."""
    return CircleMap.arnold(omega, strength)


def planes_rotation(**options):
    return rotation_plane(one_by_one, np.linspace(0.1, 0.9, 5), [0.5, 1.5], 1e-2, **options)


def planes_exponents(**options):
    omega, strength = np.linspace(0.1, 0.9, 9)[:, None], [0.5, 2.5]
    return lyapunov_exponents(one_by_one, omega, strength, cycles=200, **options)


def edges_of_tongues(**options):
    return tongues(one_by_one, [0, (1, 2)], [0.4, 0.6, 0.7, 1.2], (-0.5, 1.0), **options)


def curves_in_the_plane(**options):
    return bifurcation_curves(one_by_one, (0.02, 0.4), (0.5, 2.3), lines=2, **options)


def same(one, other):
    """Whether all numbers of two results are the same, to the last digit."""
    if is_dataclass(one):
        return all(same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(same, one, other))
    return np.array_equal(one, other, equal_nan=np.asarray(one).dtype.kind == "f")


@pytest.mark.parametrize(
    "found", [planes_rotation, planes_exponents, edges_of_tongues, curves_in_the_plane]
)
def test_the_numbers_do_not_depend_on_the_executor(found):
    plain = found()
    for kind in (ThreadPoolExecutor, ProcessPoolExecutor):
        told = []
        with kind(2) as executor:
            assert same(found(progress=told.append, executor=executor), plain)
        assert told == sorted(told) and told[-1] == 1.0 and len(told) > 1


def test_same_sees_a_changed_digit():
    edges = edges_of_tongues()
    assert not same(edges, tongues(one_by_one, [0, (1, 2)], [0.4, 0.6, 0.7, 1.3], (-0.5, 1.0)))
