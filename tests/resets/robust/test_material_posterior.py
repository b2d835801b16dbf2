"""Materials drawn from an identification: its best one, and draws with the identification's own covariance."""

import numpy as np
import pytest
from robust_cases import GRID, LAW, NOISE, ROUGH, SHORT, short_loop

from cyclemap.errors import InvalidInput
from cyclemap.evidence.data_blocks.friction_scan_block import friction_ellipse_from_scans
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.surface_parameters import SurfaceParameters
from cyclemap.resets.robust.material_posterior import MaterialPosterior
from cyclemap.resets.robust.worst_case import worst_case
from cyclemap.resets.strategies.push_strategies import DrawnPushes, side_pushes


@pytest.fixture(scope="module")
def found() -> Identification:
    """From made friction scans with noise of .05 N, of an object of 8 N on LAW."""
    direction = np.linspace(0.0, 2 * np.pi, 24, endpoint=False)
    way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    force = 8.0 * LAW.traction(way) + 0.05 * np.random.default_rng(0).standard_normal((24, 2))
    along, across = np.sum(force * way, axis=1), force[:, 1] * way[:, 0] - force[:, 0] * way[:, 1]
    return friction_ellipse_from_scans({"direction": direction, "force_along": along, "force_across": across}, 8.0)


def test_the_posterior_has_the_identifications_best_and_covariance(found):
    """The first is the fit; drawn parameters spread as its covariance says, within the error of 3000 draws."""
    posterior = MaterialPosterior(found, "floor")
    sample = posterior.sampled(3001, seed=2)
    assert sample.materials[0].friction == found.friction() and sample.materials[0].name == "floor"
    assert (len(sample), sample.chosen, sample.independent, sample.names) == (3001, 1, True, posterior.names)
    expected = np.sqrt(np.diag(found.uncertainty.covariance))
    assert expected.size == 5 and np.all(expected > 0.0)
    assert np.std(sample.points[1:], axis=0) == pytest.approx(expected, rel=0.15)  # Student's factor: somewhat wider
    drawn = SurfaceParameters.from_friction(sample.materials[7].friction).values()
    assert [drawn[name] for name in sample.names] == pytest.approx(sample.points[7].tolist(), abs=1e-9)


def test_scenarios_reach_further_than_most_draws(found):
    posterior = MaterialPosterior(found)
    few, many = posterior.scenarios(), posterior.sampled(300, seed=9)
    spread = np.std(many.points, axis=0)
    far, usual = (np.linalg.norm((one.points[1:] - one.points[0]) / spread, axis=1) for one in (few, many))
    assert len(few) == 12 and far.min() > np.median(usual) and far.max() > np.quantile(usual, 0.97)


def test_draws_come_again_with_their_seed(found):
    posterior = MaterialPosterior(found)
    once, again, other = (posterior.sampled(20, seed) for seed in (1, 1, 2))
    assert np.array_equal(once.points, again.points) and not np.array_equal(once.points[1:], other.points[1:])
    assert posterior.without_direction() is posterior


def test_a_strategy_over_a_posterior_gets_a_share_with_confidence(found):
    pair = DrawnPushes(side_pushes(SHORT, (0, 2)))
    worst = worst_case(short_loop(ROUGH), pair, MaterialPosterior(found), count=4, noise=NOISE, grid=GRID)
    assert len(worst.scores) == 4 and 0.5 < worst.share_exceeding <= 1.0  # three draws tell little
    assert np.ptp(worst.column("total_variation")) > 0.0


def test_what_is_no_identification_is_refused():
    with pytest.raises(InvalidInput, match="needs an Identification"):
        MaterialPosterior(LAW)
