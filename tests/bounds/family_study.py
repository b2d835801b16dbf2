"""Bifurcations of random families, their curves and their points of codimension two beside the same
ones in longer floats: errors over bounds.
"""

import time
from collections.abc import Callable, Iterator

import numpy as np

from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.maps import (
    Bifurcation,
    BifurcationCurve,
    CodimensionTwo,
    bifurcations,
    follow_bifurcation,
)
from tests.bounds.bound_study import BoundStudy
from tests.bounds.random_families import LONG, RandomFamily, Unknowns, random_family, root

_RESOLUTION = 6
_FOLLOWED = 0.5  # of the families: that one of their curves is followed
_POINTS = 4  # of a curve that are judged
_ROUNDING = 1e-14  # of an orbit's equations: what curves are said to be correct to


def study_families(count: int, seed: int, late: Callable[[], bool] = lambda: False) -> BoundStudy:
    """Judge so many random families, each of its own seed; ends early when it is ``late``."""
    found = BoundStudy()
    for place in range(count):
        if late():
            break
        rng = np.random.default_rng([seed, place])
        family = random_family(rng)
        begun = time.process_time()
        try:
            _judge(found, family, f"family {place}", rng)
        except (ConvergenceError, InvalidInput) as refusal:
            found.refused[" ".join(str(refusal).split()[-6:])] += 1
        found.seconds.append(time.process_time() - begun)
    return found


def _judge(found: BoundStudy, family: RandomFamily, where: str, rng: np.random.Generator) -> None:
    height = float(rng.uniform(-0.8, 0.8))
    starts = bifurcations(
        lambda p: family(p, height),
        family.first,
        family.period,
        family.winding,
        resolution=_RESOLUTION,
    )
    for start in starts:
        _judge_start(found, family, start, height, where)
    chosen = [start for start in starts if start.kind != "branch point"]
    if family.sampled or not chosen or rng.uniform() > _FOLLOWED:
        return  # the curves of a sampled family are those of the samples
    start = chosen[rng.integers(len(chosen))]
    curve = follow_bifurcation(family, start, height, family.first, family.second)
    for place in rng.integers(0, curve.first.size, _POINTS):
        _judge_point(found, family, curve, int(place), where)
    for special in curve.special:
        _judge_special(found, family, curve, special, where)


def _roots(
    family: RandomFamily, kind: str, near: Unknowns, free: int
) -> Iterator[tuple[Unknowns, float]]:
    """The roots nearest to what was found, from either side of a break that it lies on."""
    for side in (1, -1) if kind.startswith("border") else (0,):
        solved = root(family.equations(kind, near, side), near, free)
        if solved is not None:
            yield solved


def _judge_start(
    found: BoundStudy, family: RandomFamily, start: Bifurcation, height: float, where: str
) -> None:
    if start.kind == "branch point" or (family.sampled and start.kind != "saddle-node"):
        return
    near = np.array([start.theta, float(start.parameter), height], dtype=LONG)
    errors = [float(abs(at[1] - near[1])) for at, _ in _roots(family, start.kind, near, 2)]
    found.judge(start.kind, where, min(errors, default=np.inf), start.parameter.error_bound)


def _judge_point(
    found: BoundStudy, family: RandomFamily, curve: BifurcationCurve, place: int, where: str
) -> None:
    near = np.array([curve.points[place, 0], curve.first[place], curve.second[place]], dtype=LONG)
    member = family(*near[1:].astype(float))
    slope_error = float(np.max(member.derivative_and_error(curve.points[place])[1]))
    ratios = [(np.inf, 0.0)]
    for at, moved in _roots(family, curve.kind, near, 3):
        allowed = moved * (_ROUNDING + family.period * slope_error)
        ratios.append((float(np.linalg.norm(at - near)), allowed))
    found.judge(f"curve of {curve.kind}", where, *min(ratios))


def _judge_special(
    found: BoundStudy,
    family: RandomFamily,
    curve: BifurcationCurve,
    special: CodimensionTwo,
    where: str,
) -> None:
    halved = family.period == 2 and curve.kind == "saddle-node"
    if special.kind == "tip" or (special.kind == "generalised flip" and halved):
        return  # no equations of these orbits
    bounds = np.array([special.first.error_bound, special.second.error_bound])
    nearest = np.full(2, np.inf)
    for theta in special.points:
        near = np.array([theta, float(special.first), float(special.second)], dtype=LONG)
        for at, _ in _roots(family, special.kind, near, 3):
            errors = np.abs(at - near)[1:].astype(float)
            if np.max(errors / bounds) < np.max(nearest / bounds):
                nearest = errors
    for error, bound in zip(nearest.tolist(), bounds.tolist(), strict=True):
        found.judge(special.kind, where, error, bound)
