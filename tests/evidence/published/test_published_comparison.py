"""Predictions beside published numbers, and the shipped materials that were inferred from them."""

import re

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.evidence.published_comparison import DIRECTION_TOLERANCE, comparison_table, published_comparison
from cyclemap.mechanics import Material, load_material, material_names

INFERRED = ("abs", "delrin", "pu")
# Stable directions that each material predicts, and published ones that it misses by more than 15 degrees.
SHOWN = {"abs": 1, "delrin": 1, "pu": 0}
MISSED_DEG = {"abs": [], "delrin": [], "pu": []}


def numbers_of(text: str) -> np.ndarray:
    return np.array(re.findall(r"-?\d+\.?\d*", text), dtype=float)


def words_of(text: str) -> str:
    return re.sub(r"-?\d+\.?\d*", "#", text)


@pytest.fixture(scope="module")
def comparisons():
    return {name: published_comparison(name) for name in INFERRED}


def test_isotropic_friction_has_no_stable_direction_and_misses_every_published_peak():
    isotropic = load_material("isotropic")
    found = published_comparison(Material("delrin", isotropic.friction))
    assert found.stable.size == found.peaks.size == 0
    assert np.all(np.isinf(found.misses)) and found.misses.size == 1


@pytest.mark.parametrize("name", INFERRED)
def test_the_shipped_file_tells_its_own_misfit(name, comparisons):
    """One evaluation gives the numbers in the file again, and the file says that no forces were measured."""
    material = load_material(name)
    assert material.inferred and "inferred from" in material.provenance and "0.25 by convention" in material.provenance
    told = comparisons[name].sentence
    assert material.misfit.startswith(told[:4]) and words_of(told) == words_of(material.misfit[: len(told)])
    assert numbers_of(told) == pytest.approx(numbers_of(material.misfit[: len(told)]), abs=0.11)


@pytest.mark.parametrize("name", INFERRED)
def test_real_cycles_turn_towards_each_predicted_stable_direction(name, comparisons):
    """The series between nodes and the mechanics itself agree on where the turn changes sign, within two degrees."""
    loop, near = CollectionLoop.mit(name), np.deg2rad(2.0)
    stable = comparisons[name].stable
    assert stable.size == SHOWN[name]
    for angle in stable:
        before, after = loop.next_theta([angle - near, angle + near]) - [angle - near, angle + near]
        assert before > 0.0 > after


@pytest.mark.parametrize("name", INFERRED)
def test_published_directions_are_met_within_fifteen_degrees_or_the_file_says_which_is_not(name, comparisons):
    found = comparisons[name]
    missed = np.degrees(np.array(found.published.directions)[found.misses > DIRECTION_TOLERANCE])
    assert missed.tolist() == pytest.approx(MISSED_DEG[name])
    assert ("no peak within" in load_material(name).misfit) == bool(MISSED_DEG[name])


def test_on_pu_orientation_always_advances_and_elsewhere_it_does_not(comparisons):
    least = {name: found.predicted.turn.min() for name, found in comparisons.items()}
    assert least["pu"] > 0.0 > max(least["abs"], least["delrin"])


def test_the_table_names_every_material_and_quantity(comparisons):
    table = comparison_table(comparisons.values())
    assert all(name in table for name in INFERRED)
    assert table.count("turn (deg)") == table.count("dx (mm)") == table.count("dy (mm)") == 3


def test_a_material_without_published_numbers_is_refused():
    assert "isotropic" in material_names()
    with pytest.raises(InvalidInput, match="isotropic"):
        published_comparison("isotropic")


@pytest.mark.parametrize("name", ["delrin", "pu"])
def test_means_of_the_2000_pushes_are_met_where_pressure_is_free(name, comparisons):
    """Within 1.2 degrees, 1.5 and 3 mm of the published means, spreads within a factor 1.5."""
    found, published = comparisons[name].predicted, comparisons[name].published
    assert np.all(np.abs(found.mean - published.mean) < [np.deg2rad(1.2), 1.5e-3, 3e-3])
    assert np.all(np.abs(np.log(found.std / published.std)) < np.log(1.5))
