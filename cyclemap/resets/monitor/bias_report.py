"""What the monitor tells after a push."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from cyclemap.resets.monitor.coverage import CoverageState
from cyclemap.resets.monitor.rest_direction import Rest

AlarmKind = Literal["rest", "visits"]


@dataclass(frozen=True)
class Alarm:
    """That the data lock in.

    push : at which push it was raised. kind : "rest" where θ0 comes back, push after push, to where it just was;
    "visits" where it gathers about directions over many pushes. directions : rad in [0, 2π), towards which: where
    the steps of the rest lead, or the direction most visited; several where θ0 goes round them in turn. began : the
    push at which the rest began, None for "visits". Pushes are counted from 0, the first one fed.
    """

    push: int
    kind: AlarmKind
    directions: tuple[float, ...]
    began: int | None

    @property
    def delay(self) -> int | None:
        """Pushes from the first of the rest to the alarm; None for "visits"."""
        return None if self.began is None else self.push - self.began


@dataclass(frozen=True)
class Advice:
    """What to do next.

    change_reset : True where the next pushes should not be left to the reset in use. direction : rad in [0, 2π), the
    direction of the circle that is least covered: bring the object to it.
    """

    change_reset: bool
    direction: float


@dataclass(frozen=True)
class BiasReport:
    """The state of a collection after a push.

    push : number of the last push fed, from 0; -1 before any. since_change : pushes since the reset was last changed.
    alarm : the first one since then, None where there was none.
    rest_evidence, visit_evidence : log10 of the evidence for each kind; an alarm is raised where one of them reaches
        ``threshold`` = log10(2 / alarm rate).
    rest : where θ0 rests just now, if it does and has for twice the rule's window, alarm or not.
    useful_pushes : while it rests and an alarm was raised: how many more pushes there still tell a tenth of what a push
        in the most telling direction would. None otherwise: no end is in sight.
    recent_worth : effective pushes gained a push over the last 50: 1 where they spread evenly, 0 where they tell
        nothing new; above 1 while directions open up that were not known.
    coverage, advice : see there.
    """

    push: int
    since_change: int
    alarm: Alarm | None
    rest_evidence: float
    visit_evidence: float
    threshold: float
    rest: Rest | None
    useful_pushes: int | None
    recent_worth: float
    coverage: CoverageState
    advice: Advice

    @property
    def alarm_p_value(self) -> float:
        """An upper bound, at any time, on the chance that an unbiased collection shows as much evidence by now.

        It counts the two kinds of evidence and uses what they are now, not the most they have been.
        """
        return min(1.0, 2.0 * math.pow(10.0, -max(self.rest_evidence, self.visit_evidence)))
