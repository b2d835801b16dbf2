"""Rival explanations on made data whose true explanation is known."""

import numpy as np
import pytest

from cyclemap.errors import InvalidInput
from cyclemap.evidence.identification.data_block import FunctionBlock, Values
from cyclemap.evidence.identification.explanations import OPEN_QUESTIONS, compare_explanations

PARAMETERS = ("offset_x", "rim_share", "hitch_scale", "pin_friction_radius")
BASE = ("offset_x",)
DIRECTIONS = np.linspace(0.0, 2 * np.pi, 60, endpoint=False)
# A ring's friction turns these made strokes much as the rim does, but for so much of another harmonic.
UNLIKE = 0.01


def turns(values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Turns (rad) of made strokes, linear in all parameters, and their derivatives."""
    by = np.stack(
        [
            0.9 * np.cos(DIRECTIONS),
            0.8 * np.sin(2 * DIRECTIONS),
            0.5 * np.cos(3 * DIRECTIONS),
            40.0 * (np.sin(2 * DIRECTIONS) + UNLIKE * np.cos(5 * DIRECTIONS)),
        ],
        axis=-1,
    )
    return by @ [values[name] for name in PARAMETERS], by


def made_block(truth: dict[str, float], seed: int = 0) -> FunctionBlock:
    given = {"offset_x": 0.05, "rim_share": 0.0, "hitch_scale": 1.0, "pin_friction_radius": 0.0} | truth
    data = turns(given)[0] + 0.02 * np.random.default_rng(seed).standard_normal(len(DIRECTIONS))

    def function(values: Values) -> tuple[np.ndarray, np.ndarray]:
        predicted, by = turns(values)
        return predicted - data, by

    return FunctionBlock("strokes", PARAMETERS, function, np.arange(len(DIRECTIONS)), "turn (rad)")


def compared(truth: dict[str, float], **options):
    return compare_explanations([made_block(truth)], BASE, starts=1, **options)


def test_the_true_explanation_is_found_and_a_look_alike_is_said_to_be_open() -> None:
    """Weight on the rim and friction in the ring turn strokes almost alike: the data cannot tell which it is."""
    found = compared({"rim_share": 0.3})
    assert len(found.explanations) == len(OPEN_QUESTIONS) == 6
    candidates = {found.best.name, *(one.name for one in found.equals)}
    assert {"weight on the rim", "friction in the ring"} <= candidates
    worse = {one.name for one in found.explanations if one.told_apart}
    assert worse == {"even pressure, ideal ring", "another lever"}
    rim = next(one for one in found.explanations if one.extra == ("rim_share",))
    assert rim.found is not None
    assert rim.found["rim_share"].lower < 0.3 < rim.found["rim_share"].upper


def test_two_causes_at_once_need_both() -> None:
    found = compared({"rim_share": 0.3, "hitch_scale": 0.8})
    assert found.best.extra == ("rim_share", "hitch_scale")
    told = {one.extra for one in found.explanations if one.told_apart}
    assert {(), ("rim_share",), ("hitch_scale",), ("pin_friction_radius",)} <= told


def test_where_nothing_is_amiss_no_explanation_beats_the_plain_one_by_more_than_the_error() -> None:
    for seed in range(3):
        found = compare_explanations([made_block({}, seed)], BASE, starts=1, seed=seed)
        plain = next(one for one in found.explanations if not one.extra)
        assert not plain.told_apart


def test_of_explanations_as_good_as_each_other_the_simplest_is_the_best() -> None:
    """Without weight on the rim its share comes out as nothing: freeing it as well is no better explanation."""
    found = compared({}, alternatives={"rim": ("rim_share",), "plain": ()})
    assert found.best.name == "plain" and abs(found.explanations[1].deviance) < 2.0
    assert [one.name for one in found.equals] == ["rim"]


def test_scores_are_those_of_the_rows_left_out() -> None:
    """By hand from the residuals of cross-validation: one kind of row, every row a group."""
    found = compared({"rim_share": 0.3})
    plain = next(one for one in found.explanations if not one.extra)
    assert plain.found is not None and plain.found.validation is not None and found.best.found is not None
    assert found.best.found.validation is not None
    mine, best = (one.validation.residuals for one in (plain.found, found.best.found))
    count, noise = len(mine), np.sqrt(np.mean(best**2))
    assert plain.deviance == pytest.approx(count * np.log(np.mean(mine**2) / np.mean(best**2)))
    more = (mine**2 - best**2) / noise**2
    assert plain.worse == pytest.approx(np.sum(more))
    assert plain.standard_error == pytest.approx(np.std(more, ddof=1) * np.sqrt(count))
    assert found.best.deviance == 0.0 and found.best.worse == 0.0


def test_explanations_are_compared_on_the_same_folds_and_without_what_they_free() -> None:
    found = compare_explanations([made_block({"rim_share": 0.3})], (*BASE, "rim_share"), starts=1, folds=4)
    assert found.free == BASE
    folds = [one.found.validation.fold for one in found.explanations if one.found and one.found.validation]
    assert len(folds) == 6
    assert all(np.array_equal(fold, folds[0]) and fold.max() == 3 for fold in folds)


def test_a_single_explanation_or_fold_is_no_comparison() -> None:
    with pytest.raises(InvalidInput, match="nothing to compare"):
        compared({}, alternatives={"plain": ()})
    with pytest.raises(InvalidInput, match="folds"):
        compared({}, folds=1)
