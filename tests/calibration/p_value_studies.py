"""Every p-value of the package under its own null: seeded simulations,
one function a kind of test."""

from collections.abc import Callable
from functools import partial

import numpy as np

from cyclemap.evidence.comparison.collection_null import (
    CollectionModel,
    collection_p_values,
    collection_statistics,
    simulated_ensemble,
)
from cyclemap.evidence.comparison.cycle_agreement import (
    direction_agreement,
    map_misfit,
    simulated_quantity,
)
from cyclemap.evidence.comparison.push_agreement import mean_error, within_error
from cyclemap.evidence.laws.fit_map import fit_map, fit_worn_law, map_of_turn
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    WrappedNormal,
    compare_steps,
    find_steps,
    predict_staircase,
    sample_staircases,
)

TWO_PI = 2.0 * np.pi
# Second eigenvalue 0.90: neighbours are strongly correlated, a start is forgotten in ten cycles.
SLOW, SLOW_NOISE = CircleMap.arnold(0.01, 0.15), WrappedNormal(0.3)
# A locked map that opens: the bottleneck of a worn surface.
WORN = DriftingMap.between([(0, CircleMap.arnold(0.045, 0.3)), (300, CircleMap.arnold(0.09, 0.3))])
WORN_NOISE = WrappedNormal(0.25)
GHOST, GHOST_NOISE = CircleMap.arnold(0.15, 0.9), WrappedNormal(0.05)
WELL, WELL_NOISE = CircleMap.arnold(0.1, 0.9), WrappedNormal(0.45)
LENGTH = 300
STEPS_LENGTH = {"ghost": 400, "well": 2_000}

Found = dict[str, np.ndarray]


def gathered(rows: list[dict[str, float | None]]) -> Found:
    """Each p-value over the simulations, those left out where there was too little to test."""
    return {
        name: np.array([row[name] for row in rows if row[name] is not None], dtype=float)
        for name in rows[0]
    }


def mean_errors(count: int, runs: int, seed: int) -> Found:
    """Whether a mean is within its error: one p-value of 0.05 or 1 a run, for means that are 0."""
    rng = np.random.default_rng(seed)

    def p_value(size: int, memory: float) -> float:
        noise = rng.standard_normal(size + 50)
        for n in range(1, noise.size):
            noise[n] += memory * noise[n - 1]
        kept = noise[50:]
        return 1.0 if within_error(float(kept.mean()), mean_error(kept), size) else 0.05

    cases = [(20, 0.0), (300, 0.0), (300, 0.4), (1500, 0.4)]
    names = [f"bias, n {size}, lag correlation {memory:g}" for size, memory in cases]
    return gathered(
        [
            {name: p_value(*case) for name, case in zip(names, cases, strict=True)}
            for _ in range(count)
        ]
    )


def fit_still(path: np.ndarray) -> CollectionModel:
    """Two harmonics, and the scatter about them."""
    fitted = fit_map(path[:-1], path[1:], harmonics=2)
    return CollectionModel(fitted.map, WrappedNormal(fitted.sigma))


def fit_worn(path: np.ndarray) -> CollectionModel:
    """Two harmonics, linear in the cycle, and the scatter about them."""
    theta, turn = path[:-1], np.diff(path)
    worn = fit_worn_law(theta, turn, np.arange(turn.size), harmonics=2, degree=1)
    ends = [(n, map_of_turn(worn.at(n))) for n in (worn.first, worn.last)]
    return CollectionModel(DriftingMap.between(ends), WrappedNormal(worn.sigma))


TRUTHS = {
    "chain": (CollectionModel(SLOW, SLOW_NOISE), fit_still),
    "wear": (CollectionModel(WORN, WORN_NOISE), fit_worn),
}


def collections(
    count: int, runs: int, seed: int, kind: str = "wear", refitted: bool = False
) -> Found:
    """Collections of a slow chain or of a map that wears: given in full, or fitted to the path."""
    truth, fit = TRUTHS[kind]
    statistics = {**collection_statistics(), "map": map_misfit}
    rows = []
    for k, path in enumerate(truth.paths(0.5, LENGTH, count, seed)):
        model, refit = (fit(path), fit) if refitted else (truth, None)
        found = collection_p_values(
            path, model, statistics, runs=runs, seed=seed + 10 + 3 * k, refit=refit
        )
        rows.append(
            {f"{name}, {'refitted ' * refitted}{kind}": one.value for name, one in found.items()}
        )
    return gathered(rows)


def details(count: int, runs: int, seed: int) -> Found:
    """Directions and steps of a map that wears, among simulated collections."""
    truth = CollectionModel(WORN, WORN_NOISE)
    zones = predict_staircase(WORN.at(LENGTH // 2), WORN_NOISE).zones
    ensemble = simulated_ensemble(truth, 0.5, LENGTH, 200, seed)
    rows = []
    for k in range(count):
        path, *null = truth.paths(0.5, LENGTH, runs + 1, seed + 1 + k)
        match = direction_agreement(path, zones, ensemble, np.array(null)).matches[0]
        climbs = np.array([one[-1] - one[0] for one in null])
        steps = np.array([float(find_steps(one).count) for one in null])
        rows.append(
            {
                "direction, wear": None if match.p_value is None else match.p_value.value,
                "climb, wear": simulated_quantity(path[-1] - path[0], climbs).p_value.value,
                "number of steps, wear": simulated_quantity(
                    float(find_steps(path).count), steps
                ).p_value.value,
            }
        )
    return gathered(rows)


def steps(count: int, runs: int, seed: int, kind: str = "ghost") -> Found:
    """Visits and pace of stationary paths, in their predicted zones."""
    circle_map, noise = {"ghost": (GHOST, GHOST_NOISE), "well": (WELL, WELL_NOISE)}[kind]
    summary = predict_staircase(circle_map, noise)
    begun = np.linspace(0.0, TWO_PI, count, endpoint=False)
    settled = sample_staircases(circle_map, noise, 400, begun, seed)[:, -1]
    rows = []
    for path in sample_staircases(circle_map, noise, STEPS_LENGTH[kind], settled, seed + 1):
        found = compare_steps(find_steps(path, zones=summary.zones), summary)
        (visit,) = found.visits
        rows.append({f"visits, {kind}": visit.mean_p_value, f"pace, {kind}": found.pace_p_value})
    return gathered(rows)


# Name: (study, simulations of the null of each p-value). Refits are slow: fewer simulations.
STUDIES: dict[str, tuple[Callable[[int, int, int], Found], int]] = {
    "bias": (mean_errors, 1),
    "chain": (partial(collections, kind="chain"), 99),
    "chain-refitted": (partial(collections, kind="chain", refitted=True), 39),
    "wear": (collections, 99),
    "wear-refitted": (partial(collections, refitted=True), 39),
    "details": (details, 39),
    "ghost": (partial(steps, kind="ghost"), 1),
    "well": (partial(steps, kind="well"), 1),
}
