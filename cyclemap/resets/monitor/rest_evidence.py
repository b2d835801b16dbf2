"""Evidence that the orientation rests: that it comes back, push after push, to where it just was."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import positive_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.resets.monitor.rest_direction import Rest, RestingRun

Array = NDArray[np.float64]

CHANCE = 0.5  # a rest is where θ0 comes back more likely than not
_RATES = np.array([0.75, 0.9, 0.98])  # chances of coming back that are betted on, in equal shares


@dataclass(frozen=True)
class RestRule:
    """What counts as a rest.

    half_width : rad, in (0, π/4). window : how many pushes a rest must have lasted before it is betted on.
    longest_period : rests on cycles of up to this many directions are looked for.
    """

    half_width: float = math.radians(12.0)
    window: int = 6
    longest_period: int = 4

    def __post_init__(self) -> None:
        if not positive_number("half_width", self.half_width) < math.pi / 4:
            raise InvalidInput(f"half_width must be below π/4 rad (45°), not {self.half_width!r}")
        whole_number("window", self.window, least=2)
        whole_number("longest_period", self.longest_period, least=1)

    @property
    def slowest_climb(self) -> float:
        """Rad a push: a steady climb slower than this lingers so long that it counts as a rest.

        >>> round(math.degrees(RestRule().slowest_climb), 2)
        3.43
        """
        return 2.0 * self.half_width / (self.window + 1)


class RestEvidence:
    """A bet against the chance of coming back, whose gains are the evidence.

    For each period p up to ``rule.longest_period`` look at the ``window`` pushes p, 2p, ..., back. Where they lie close
    together (mean resultant length at least cos(half_width)) a bet is placed that θ0 comes within ``half_width`` of
    their mean direction. The bet is fair for a chance of ½: a hit multiplies the stake by 2r, a miss by 2(1 - r), for
    three rates r > ½. Stakes are spread over the rates, over the periods (in proportion to 1/p²) and over the bet at
    which the rest begins (1/s(s + 1) on the s-th).

    The wealth is a non-negative supermartingale that starts at 1 whenever, given the past, each betted chance is at
    most ½. So P(it ever exceeds c) ≤ 1/c, over a collection without end (Ville 1939; testing by betting: Shafer 2021;
    Ramdas, Grünwald, Vovk & Shafer 2023).
    """

    def __init__(self, rule: RestRule) -> None:
        self.rule = rule
        periods = np.arange(1, rule.longest_period + 1)
        self._shares = (1.0 / periods**2) / np.sum(1.0 / periods**2)
        self._log_stakes = np.full((periods.size, _RATES.size), -np.inf)
        self._bets = np.zeros(periods.size, dtype=np.int64)
        self._recent: list[complex] = []
        self._pushes = 0
        self._runs: list[RestingRun | None] = [None] * periods.size

    @property
    def log_evidence(self) -> float:
        """Natural logarithm of the wealth."""
        return float(np.logaddexp.reduce(np.log(self._shares) + self._log_wealth()))

    @property
    def rest(self) -> Rest | None:
        """The rest that θ0 is in just now, of the period with the most evidence; None where it is in none."""
        active = [index for index, run in enumerate(self._runs) if run is not None]
        if not active:
            return None
        wealth = self._log_wealth() + np.log(self._shares)
        run = self._runs[max(active, key=lambda index: float(wealth[index]))]
        return None if run is None else run.rest()

    def add(self, theta: float) -> None:
        """Take the next θ0 (rad, any number of turns): settle the bets on it."""
        point = complex(math.cos(theta), math.sin(theta))
        for index in range(self._shares.size):
            self._settle(index, point)
        self._recent.append(point)
        del self._recent[: -self.rule.window * self.rule.longest_period]
        self._pushes += 1

    def _settle(self, index: int, point: complex) -> None:
        """Settle the bet on the period ``index + 1``, if one is placed."""
        back = self._recent[-(index + 1) :: -(index + 1)][: self.rule.window]
        centre = sum(back) / self.rule.window
        if len(back) < self.rule.window or abs(centre) < math.cos(self.rule.half_width):
            self._runs[index] = None
            return
        hit = (point * centre.conjugate()).real >= abs(centre) * math.cos(self.rule.half_width)
        self._bets[index] += 1
        new = -math.log(self._bets[index] * (self._bets[index] + 1))
        factor = np.log((_RATES if hit else 1.0 - _RATES) / CHANCE)
        self._log_stakes[index] = np.logaddexp(self._log_stakes[index], new) + factor
        self._follow(index, point, hit)

    def _follow(self, index: int, point: complex, hit: bool) -> None:
        """Lengthen the run of hits, begin one, or end it."""
        run, period = self._runs[index], index + 1
        if not hit:
            self._runs[index] = None
        elif run is None:
            reach, scatter = self.rule.window * period, self.rule.half_width / 2.0
            self._runs[index] = RestingRun(self._pushes - reach, period, [*self._recent[-reach:], point], scatter)
        else:
            run.add(point)

    def _log_wealth(self) -> Array:
        """Per period: what the stakes have become, and what is still unspent."""
        staked = np.logaddexp.reduce(self._log_stakes, axis=1) - math.log(_RATES.size)
        return np.asarray(np.logaddexp(staked, -np.log1p(self._bets)), dtype=np.float64)


def rest_evidence_of(theta: Any, rule: RestRule | None = None) -> Array:
    """The natural logarithm of the evidence after each of the orientations ``theta`` (n,) rad: shape (n,).

    >>> lingering = np.full(20, 1.5)
    >>> rest_evidence_of(lingering).round(1)[[6, 10, 19]].tolist()
    [0.2, 2.1, 7.8]
    """
    evidence, course = RestEvidence(rule or RestRule()), []
    for angle in np.asarray(theta, dtype=np.float64).tolist():
        evidence.add(angle)
        course.append(evidence.log_evidence)
    return np.array(course)
