"""Push weights for several scenarios: what pushes do on each, and the search among those scenarios that count."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import CircleMap, Noise
from cyclemap.maps.mixtures.random_map import RandomMap
from cyclemap.mechanics import Material, SidePush
from cyclemap.resets.drawn_pushes.push_library import PushLibrary
from cyclemap.resets.drawn_pushes.push_mixture import PushMixture
from cyclemap.resets.drawn_pushes.push_weights import PushWeights, best_push_weights, push_weights
from cyclemap.resets.robust.material_score import QuickGrid, SampledCycles, own_drag, sample_cycles
from cyclemap.resets.robust.scenario_loops import loop_on
from cyclemap.resets.robust.worst_case import Allowance
from cyclemap.resets.strategies.cycle_action import CycleAction

Array = NDArray[np.float64]

# A scenario left out of the search counts where its bias is this much larger than that of all in it.
_CLOSE = 2e-4


@dataclass(frozen=True, eq=False)
class ScenarioRow:
    """The pushes of a library on one material: their cycles, and the mean drag of the loop's own reset, m.

    Processes send it to each other: maps cannot be sent, samples can.
    """

    loop: CollectionLoop
    cycles: SampledCycles
    own_drag: float

    @property
    def maps(self) -> tuple[CircleMap, ...]:
        """The map of each push."""
        return self.cycles.maps

    @property
    def drag_length(self) -> Array:
        """(P, K), m, of each push from K even orientations."""
        return self.cycles.drag_length


def scenario_row(loop: CollectionLoop, pushes: Sequence[SidePush], grid: QuickGrid, material: Material) -> ScenarioRow:
    """Return what the pushes do on one material, from the grid's orientations; 0.1 s a push."""
    here = loop_on(loop, material)
    cycles = sample_cycles(here, [CycleAction(push=push) for push in pushes], grid)
    return ScenarioRow(here, cycles, own_drag(here, grid.accuracy))


def scenario_library(pushes: Sequence[SidePush], rows: Sequence[ScenarioRow], noise: Noise, modes: int) -> PushLibrary:
    """Return the library of the pushes on every scenario, for `best_push_weights`."""
    cycles = tuple(tuple(RandomMap((one,), None, noise) for one in row.maps) for row in rows)
    lengths = np.array([row.drag_length for row in rows])
    return PushLibrary(tuple(pushes), cycles, lengths, modes, loops=tuple(row.loop for row in rows))


def least_worst_weights(
    library: PushLibrary, own_drags: Array, allowance: Allowance, most_pushes: int | None, starts: int, seed: int
) -> PushWeights:
    """Return the weights whose largest bias over the library's scenarios is least, within the drag allowed on each.

    own_drags : (S,), m, to which drags are allowed in proportion. The search looks at the scenarios that count: it
    begins with the one that is worst for even weights and adds that which is worst for the weights found, until none
    outside is worse than those inside by more than 2e-4 or exceeds its drag. As few as two or three are usual.
    """
    within, extra = allowance.pushes, allowance.reach
    limit, every = allowance.drag_ratio * own_drags, np.arange(len(library.pushes))
    even = np.full(every.size, 1.0 / every.size)
    inside = [int(np.argmax(_biases(library, every, even, within, extra)))]
    while True:
        part = _only_scenarios(library, inside)
        found = best_push_weights(
            part,
            drag_limit=limit[inside],
            within=within,
            extra_tv=extra,
            most_pushes=most_pushes,
            starts=starts,
            seed=seed,
        )
        numbers = np.array(found.numbers)
        biases = _biases(library, numbers, found.weights, within, extra)
        drag = library.mean_drags[:, numbers] @ found.weights
        over = np.maximum(biases - biases[inside].max() - _CLOSE, drag / limit - 1.0 - _CLOSE)
        over[inside] = -np.inf
        if over.max() <= 0.0:
            return push_weights(library, numbers, found.weights, drag_limit=limit, within=within, extra_tv=extra)
        inside.append(int(np.argmax(over)))


def _biases(library: PushLibrary, numbers: NDArray[np.int64], weights: Array, within: int, extra_tv: float) -> Array:
    """The bias of each scenario, (S,), from the library's matrices: in the long run, or early less what is allowed."""
    mixtures = [PushMixture(library.matrices[s][numbers]) for s in range(library.scenarios)]
    late = [mixture.bias_after(weights, within)[0] - extra_tv for mixture in mixtures]
    return np.maximum([mixture.bias(weights)[0] for mixture in mixtures], late)


def _only_scenarios(library: PushLibrary, numbers: list[int]) -> PushLibrary:
    return replace(
        library,
        random_maps=tuple(library.random_maps[s] for s in numbers),
        drag_lengths=library.drag_lengths[numbers],
        loops=tuple(library.loops[s] for s in numbers) if library.loops else (),
    )
