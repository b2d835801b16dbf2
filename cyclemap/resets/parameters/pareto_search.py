"""The front of bias against cost over families of strategies: the least bias for each of several costs allowed."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from cyclemap.checks import finite_array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.maps import Noise
from cyclemap.resets.parameters.parameter_gradient import MEAN_DRAG, REACH, TOTAL_VARIATION, Resolution, score_index
from cyclemap.resets.parameters.parameter_samples import even_orientations
from cyclemap.resets.parameters.parameter_search import ParameterSearch, search_parameters
from cyclemap.resets.parameters.parameter_space import StrategyFamily
from cyclemap.resets.parameters.pareto_front import Candidate, ParetoFront, pareto_front
from cyclemap.resets.scores.strategy_scores import strategy_scores
from cyclemap.resets.strategies.strategy import ResetStrategy
from cyclemap.resets.strategies.strategy_maps import strategy_maps

Array = NDArray[np.float64]

FRONT_SCORES = (TOTAL_VARIATION, MEAN_DRAG, REACH)


@dataclass(frozen=True, eq=False)
class SearchedFront:
    """A front and the searches that led to it, one for each family and cost allowed.

    A search that did not meet its limits gives no candidate: its best may lie far outside. Values are `checked` where
    the searches were, else those of the search.
    """

    front: ParetoFront
    searches: tuple[ParameterSearch, ...]


def search_front(
    loop: CollectionLoop,
    families: Sequence[StrategyFamily],
    noise: Noise,
    allowed: ArrayLike,
    *,
    cost: str = MEAN_DRAG,
    bias: str = TOTAL_VARIATION,
    limits: Mapping[str, float] | None = None,
    names: Sequence[str] = FRONT_SCORES,
    progress: Callable[[float], None] | None = None,
    **options: Any,
) -> SearchedFront:
    """Return the front of the families on a loop: for every family and every `allowed` cost the least bias.

    allowed : (n,), of the score `cost`. limits : on further scores. names : the scores that the front is of.
    options : those of `search_parameters`. By the epsilon-constraint method (Haimes, Lasdon & Wismer 1971), which finds
    points in dents of the front too; from the largest cost down, each search also begins where the one before ended.
    All that is found joins the front, also what a search for one cost finds that another family beats.

    Raises InvalidInput for bad values, and where no search met its limits.
    """
    costs = np.sort(finite_array("costs allowed", allowed, ndim=1))[::-1].tolist()
    row_of = [score_index(name) for name in names]
    searches: list[ParameterSearch] = []
    report = progress or (lambda fraction: None)
    for number, family in enumerate(families):
        start = options.get("start")
        for step, most in enumerate(costs):
            wanted = {**options, "start": start}
            searches.append(search_parameters(loop, family, noise, bias, {**(limits or {}), cost: most}, **wanted))
            start = searches[-1].values
            report((number + (step + 1) / len(costs)) / len(families))
    found = [_candidate(one, row_of) for one in searches if one.feasible]
    if not found:
        raise InvalidInput(f"no strategy of the {len(families)} families keeps the limits: allow more than {costs}")
    return SearchedFront(pareto_front(found, names), tuple(searches))


def scored_candidate(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    noise: Noise,
    *,
    title: str | None = None,
    resolution: Resolution | None = None,
    tolerance: float = 1e-3,
) -> Candidate:
    """Return a strategy with any schedule as a candidate for a front of `FRONT_SCORES`, from its adaptive maps.

    title : None: the strategy's name. resolution : as for a search. tolerance : of the maps, rad.

    >>> from cyclemap.maps import WrappedNormal
    >>> from cyclemap.resets.strategies.drag_strategies import StraightReset
    >>> loop, size = CollectionLoop.mit(accuracy=1e-6), Resolution(modes=32, pushes=5)
    >>> made = scored_candidate(loop, StraightReset(), WrappedNormal(0.1), resolution=size, tolerance=1e-2)
    >>> made.title, round(float(made.values[1]), 3)
    ('straight', 0.1)
    """
    size = resolution or Resolution()
    maps = strategy_maps(loop, strategy, nodes=size.nodes, tolerance=tolerance)
    scores = strategy_scores(maps, noise, modes=size.modes, pushes=size.pushes)
    drag = maps.mean_drag_length(even_orientations(size.samples)).mean()
    values = (float(scores.total_variation), float(drag), float(scores.curve.total_variation[-1]))
    return Candidate(strategy.name if title is None else title, values, strategy)


def _candidate(search: ParameterSearch, rows: list[int]) -> Candidate:
    values = search.best.value if search.checked is None else search.checked
    return Candidate(search.family.title, values[rows], search.strategy)
