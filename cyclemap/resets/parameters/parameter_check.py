"""The scores of a strategy once more, from adaptive maps that keep their jumps, against those of a search."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import read_only
from cyclemap.collection.loop import CollectionLoop
from cyclemap.maps import Noise
from cyclemap.maps.operator.fourier_discretisation import needed_modes
from cyclemap.resets.parameters.parameter_gradient import BiasGradient, Resolution
from cyclemap.resets.parameters.parameter_samples import even_orientations
from cyclemap.resets.scores.reset_scores import reset_scores
from cyclemap.resets.strategies.strategy_maps import strategy_maps

Array = NDArray[np.float64]


def checked_scores(
    loop: CollectionLoop, found: BiasGradient, noise: Noise, resolution: Resolution, tolerance: float = 1e-4
) -> Array:
    """Return the scores (5,), in the order of `SCORES`, by `strategy_maps` and `reset_scores`, with twice the modes.

    tolerance : of the maps, rad. Another sampling, another interpolation, another quadrature than the search's; only
    the mechanics and the law's nodes are shared. Not bounded: certify with `reset_scores` by itself.
    """
    strategy = found.family.strategy(found.values)
    maps = strategy_maps(loop, strategy, nodes=resolution.nodes, tolerance=tolerance)
    modes = min(2 * resolution.modes, needed_modes(noise))
    scores = reset_scores(maps.maps, noise, maps.law.weights, modes=modes, bounded=False, pushes=resolution.pushes)
    moments = np.abs(scores.law.moments[1:])
    return read_only(
        [
            scores.evenness.total_variation,
            np.sqrt(0.5 * np.sum(moments**2)),
            1.0 - scores.spectral_gap,
            scores.curve.total_variation[-1],
            maps.mean_drag_length(even_orientations(resolution.samples)).mean(),
        ]
    )
