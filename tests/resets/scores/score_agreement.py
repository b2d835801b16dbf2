"""Predicted scores against simulated pushes, each as a mean with its standard error over independent collections."""

import numpy as np

from cyclemap.maps.mixtures.law_distances import cumulative_on_grid, density_on_grid
from cyclemap.maps.mixtures.law_evolution import law_after
from cyclemap.maps.mixtures.random_map import sample_random_paths
from cyclemap.resets.scores.coverage_measures import coverage_measures
from cyclemap.resets.scores.effective_size import mean_covariance
from cyclemap.resets.scores.simulated_coverage import drawn_starts, random_map_of

TWO_PI = 2 * np.pi
CELLS = 1 << 14


def linear_scores(law):
    """Functions of θ, on a grid, whose means under a law are its TV and W1 from uniform: they attain the suprema.

    TV is the share of the set where the density is above uniform, less that set's own; W1 the mean of Kantorovich's
    potential, whose slope is -sgn(G - median G).
    """
    above = (density_on_grid(law.moments, CELLS) > 0.5 / np.pi).astype(float)
    excess = np.array(law.moments)
    excess[0] = 0.0
    reached = cumulative_on_grid(excess, CELLS)
    potential = np.cumsum(-np.sign(reached - np.median(reached))) * TWO_PI / CELLS
    return above - above.mean(), potential - potential.mean()


def table_of(values, theta):
    return values[np.minimum((np.mod(theta, TWO_PI) * (CELLS / TWO_PI)).astype(int), CELLS - 1)]


def deviation(values, truth):
    """How many standard errors the mean of independent values is from the truth."""
    return float((np.mean(values) - truth) / (np.std(values, ddof=1) / np.sqrt(len(values))))


def agreement(scores, runs, pushes, seed=1):
    """Standard errors between prediction and ``runs`` collections of ``pushes``, started from the stationary law."""
    operator, law = scores.operator, scores.law
    starts = drawn_starts(operator, "stationary", runs, np.random.default_rng(seed))
    theta = sample_random_paths(random_map_of(operator), pushes - 1, starts, seed)
    variation, potential = (np.mean(table_of(part, theta), axis=1) for part in linear_scores(law))
    found = {
        "total_variation": deviation(variation, scores.evenness.total_variation),
        "wasserstein": deviation(potential, scores.evenness.wasserstein),
    }
    count = scores.pushes
    share = coverage_measures(theta[:, :count], scores.sectors).sector_share
    found["sector_share"] = deviation(share, scores.visits.stationary[-1])
    for order in (1, 2):
        means, _ = mean_covariance(operator, order, pushes)
        for axis, wave in enumerate((np.cos, np.sin)):
            values = np.mean(wave(order * theta), axis=1)
            centre = (law.moments[order].real, law.moments[order].imag)[axis]
            found[f"mean_{wave.__name__}_{order}"] = deviation(values, centre)
            squares = pushes * (values - centre) ** 2
            found[f"variance_{wave.__name__}_{order}"] = deviation(squares, means[axis, axis])
    return found


def agreement_from_start(operator, start, cycles, runs, seed=2):
    """The same for TV and W1 of the law ``cycles`` cycles after one start."""
    theta = sample_random_paths(random_map_of(operator), cycles, np.full(runs, start), seed)[:, -1]
    law = law_after(operator, start, cycles)
    variation, potential = (table_of(part, theta) for part in linear_scores(law))
    return {
        "total_variation": deviation(variation, law.total_variation()),
        "wasserstein": deviation(potential, law.wasserstein()),
    }
