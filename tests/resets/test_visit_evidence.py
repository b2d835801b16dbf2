"""Blocks in shuffled order: a fair game for every law of the turns, and a telling one where visits
gather.
"""

import math

import numpy as np
import pytest

from cyclemap.maps import WrappedNormal
from cyclemap.resets.bias_evidence import KERNEL, VisitEvidence, VisitLaw


def evidence_of(path, **how) -> VisitEvidence:
    evidence = VisitEvidence(**how)
    for theta in np.asarray(path).tolist():
        evidence.add(theta)
    return evidence


def walk(random, count, turn_deg, noise_deg):
    return np.cumsum(
        np.radians(turn_deg + noise_deg * random.standard_normal(count))
    ) + random.uniform(0, 2 * np.pi)


@pytest.mark.parametrize(("turn_deg", "noise_deg"), [(0.0, 20.0), (8.0, 8.0), (0.0, 200.0)])
def test_the_mean_wealth_is_one_for_turns_of_any_law(turn_deg, noise_deg) -> None:
    """250 collections of six short blocks; within four standard errors."""
    random = np.random.default_rng(5)
    wealth = [
        math.exp(
            evidence_of(
                walk(random, 37, turn_deg, noise_deg), block=6, orders=9, seed=seed
            ).log_evidence
        )
        for seed in range(250)
    ]
    assert len(wealth) == 250
    assert np.std(wealth) > 0.05
    assert np.mean(wealth) == pytest.approx(1.0, abs=4 * np.std(wealth) / math.sqrt(250))


def test_a_rigid_rotation_gives_no_evidence_at_all() -> None:
    """All orders of equal turns are the same path."""
    assert evidence_of(np.radians(8.0) * np.arange(500)).log_evidence == pytest.approx(
        0.0, abs=1e-9
    )
    assert evidence_of(np.full(500, 1.0)).log_evidence == pytest.approx(0.0, abs=1e-9)


def test_independent_biased_directions_and_a_slow_zone_give_evidence_and_their_direction() -> None:
    random = np.random.default_rng(2)
    paths = [(centre, random.vonmises(centre, 0.8, 800)) for centre in (0.5, 3.0)]
    slow = [0.0]
    for _ in range(900):
        slow.append(
            slow[-1] + np.radians(9.0 - 4.0 * np.cos(slow[-1]) + 1.1 * random.standard_normal())
        )
    for centre, path in (*paths, (0.0, slow[1:])):
        found = evidence_of(path)
        assert found.log_evidence > 10.0
        assert abs((found.peak() - centre + np.pi) % (2 * np.pi) - np.pi) < np.radians(25.0)


def test_evidence_knows_neither_the_origin_nor_whole_turns_and_repeats_with_its_seed() -> None:
    random = np.random.default_rng(4)
    path = random.vonmises(1.0, 0.8, 300)
    plain = evidence_of(path).log_evidence
    assert plain > 1.0
    assert evidence_of(path).log_evidence == plain
    assert evidence_of(path + 0.7).log_evidence == pytest.approx(plain, abs=1e-6)
    assert evidence_of(
        path + 2 * np.pi * random.integers(-2, 3, 300)
    ).log_evidence == pytest.approx(plain, abs=1e-6)
    assert evidence_of(path, seed=1).log_evidence != plain


def test_evidence_changes_where_a_block_is_full_and_not_before() -> None:
    random = np.random.default_rng(6)
    evidence, course = VisitEvidence(block=20), []
    for theta in random.vonmises(1.0, 2.0, 101).tolist():
        evidence.add(theta)
        course.append(evidence.log_evidence)
    changed = np.flatnonzero(np.diff(course)) + 1
    # The first block teaches the law of visits; the others are betted on when their last push has
    # come.
    assert changed.tolist() == [40, 60, 80, 100]


def test_the_law_is_the_kernel_estimate_mixed_with_the_uniform_law() -> None:
    visits = np.array([0.3, 0.4, 2.0, 6.2])
    law = VisitLaw()
    law.add(visits)
    theta = np.linspace(0.0, 2 * np.pi, 7)
    kernel = WrappedNormal(KERNEL)
    learned = 2 * np.pi * kernel.density(np.subtract.outer(theta, visits)).sum(axis=1)
    assert law.ratio(theta) == pytest.approx(0.1 + 0.9 * (24 + learned) / (24 + 4), abs=1e-5)
    grid = np.arange(3600) * (2 * np.pi / 3600)
    assert law.ratio(grid).mean() == pytest.approx(1.0, abs=1e-5)
    law.add(visits[:1], kept=0.5)
    assert law.visits == 3.0
