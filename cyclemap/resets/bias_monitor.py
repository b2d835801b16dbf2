"""The monitor of a collection: fed θ0 push by push, it tells whether the data are locking in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from cyclemap.checks import finite_number
from cyclemap.errors import InvalidInput
from cyclemap.resets.bias_evidence import ArcEvidence, Rest, RestEvidence, RestRule, VisitEvidence
from cyclemap.resets.coverage import Coverage, CoverageState
from cyclemap.written import DIRECTION

ALARM_RATE = 0.01
LEAST_GAIN = 0.1  # a push is useful while it tells a tenth of what the most telling one would
# Radians: beyond this a float keeps less than seven digits of the fraction of a turn.
LARGEST_ORIENTATION = 1e9
RECENT = 50  # pushes over which the recent worth is taken
_RULE = RestRule()

AlarmKind = Literal["rest", "visits"]


@dataclass(frozen=True)
class Alarm:
    """That the data lock in.

    Attributes
    ----------
    push : int
        At which push it was raised.
    kind : {'rest', 'visits'}
        "rest" where θ0 comes back, push after push, to where it just was; "visits" where it
        gathers about directions over many pushes.
    directions : tuple of float
        rad in [0, 2π), towards which: where the steps of the rest lead, or the direction most
        visited; several where θ0 goes round them in turn.
    began : int or None
        The push at which the rest began, None for "visits". Pushes are counted from 0, the
        first one fed.

    Examples
    --------
    >>> from cyclemap.resets import watch
    >>> alarm = watch([0.3] * 20)[-1].alarm
    >>> alarm.kind, alarm.push, [round(direction, 3) for direction in alarm.directions]
    ('rest', 14, [0.3])
    """

    push: int
    kind: AlarmKind
    directions: tuple[float, ...] = field(metadata=DIRECTION)
    began: int | None


@dataclass(frozen=True)
class Advice:
    """What to do next.

    Attributes
    ----------
    change_reset : bool
        True where the next pushes should not be left to the reset in use.
    direction : float
        rad in [0, 2π), the direction of the circle that is least covered: bring the object to
        it.

    Examples
    --------
    >>> from cyclemap.resets import watch
    >>> advice = watch([0.3] * 20)[-1].advice
    >>> advice.change_reset, round(advice.direction, 1)
    (True, 3.4)
    """

    change_reset: bool
    direction: float = field(metadata=DIRECTION)


@dataclass(frozen=True)
class BiasReport:
    """The state of a collection after a push.

    Attributes
    ----------
    push : int
        Number of the last push fed, from 0; -1 before any.
    alarm : Alarm or None
        The first one since the reset was last changed, None where there was none.
    rest_evidence, visit_evidence : float
        log10 of the evidence for each kind; an alarm is raised where one of them reaches
        ``threshold``.
    threshold : float
        log10(2 / alarm rate).
    rest : Rest or None
        Where θ0 rests just now, if it does and has for twice the rule's window, alarm or not.
    useful_pushes : int or None
        While it rests and an alarm was raised: how many more pushes there still tell a tenth of
        what a push in the most telling direction would. None otherwise: no end is in sight.
    recent_worth : float
        Effective pushes gained a push over the last 50: 1 where they spread evenly, 0 where
        they tell nothing new; above 1 while directions open up that were not known.
    coverage : CoverageState
        What the collection covers.
    advice : Advice
        What to do next.

    Examples
    --------
    >>> from cyclemap.resets import watch
    >>> report = watch([0.3] * 20)[-1]
    >>> report.push, report.rest_evidence > report.threshold, report.coverage.covered < 0.2
    (19, True, True)
    """

    push: int
    alarm: Alarm | None
    rest_evidence: float = field(metadata={"name": "rest_log10"})
    visit_evidence: float = field(metadata={"name": "visits_log10"})
    threshold: float = field(metadata={"name": "threshold_log10"})
    rest: Rest | None
    useful_pushes: int | None
    recent_worth: float
    coverage: CoverageState
    advice: Advice


class BiasMonitor:
    """Tells, while a collection runs, whether its orientations lock in, and what would help.

    Parameters
    ----------
    alarm_rate : float, optional
        The chance, in (0, 1), that it ever raises an alarm on a collection without bias,
        however long.

    Raises
    ------
    InvalidInput
        For a rate outside (0, 1).

    Notes
    -----
    The alarm rate holds by a theorem, Ville's inequality, half of it for each kind of evidence:

    - against "visits" for every reset whose turns are exchangeable, so do not depend on where the
      object stood, whatever their law: independent uniform θ0, isotropic friction with any turn and
      any noise, final directions drawn at random. Half of this share looks at blocks of 48 pushes
      (``VisitEvidence``), half at arcs of the circle that the first 48 pushes keep to
      (``ArcEvidence``): half a circle is told after 26 pushes in the median;
    - against "rest" where θ0, whenever it has lingered (``RestRule``: four pushes within some 3°),
      comes back within ``half_width`` with chance ½ at most: independent uniform θ0, turns that do
      not depend on θ0 and of which no more than half fall within any 6° (normal ones that scatter
      by 4.5° or more), and walks without scatter faster than 1.2° a push (``RestRule``). Slow walks
      that scatter less have no theorem: at 2 ± 1.1° a push or faster it is far below ½.

    What is slower, or comes round to the very same two, three or four directions, does raise the
    alarm: its law may be even in the long run, but its next hundred pushes repeat the last ones.

    The monitor changes as it is fed, for a collection has one course; each report is a value that
    stays. A push costs some tenths of a millisecond, however many came before, each 48th, which
    ends a block, up to two milliseconds, and a dozen of the first 48 some hundredths of a second
    where they may keep to an arc; the orientations are kept. The same orientations give the same
    reports, θ0 wrapped or not.

    Examples
    --------
    >>> import math
    >>> from cyclemap import BiasMonitor
    >>> monitor = BiasMonitor()
    >>> for turn in range(20):
    ...     report = monitor.update(math.radians(85.0))
    >>> report.alarm.kind, report.alarm.push, round(math.degrees(report.alarm.directions[0]))
    ('rest', 14, 85)
    >>> round(math.degrees(report.advice.direction))
    265
    """

    def __init__(self, alarm_rate: float = ALARM_RATE) -> None:
        if not 0.0 < finite_number("alarm_rate", alarm_rate) < 1.0:
            raise InvalidInput(
                f"alarm_rate must lie between 0 and 1, such as 0.01, not {alarm_rate!r}"
            )
        self.alarm_rate = alarm_rate
        # Over all resets used.
        self.coverage = Coverage()
        self._path: list[float] = []
        self._worth = [0.0]
        self._alarm: Alarm | None = None
        self.reset_changed()

    @property
    def path(self) -> tuple[float, ...]:
        """The orientations fed since the reset was last changed, rad, as they were given."""
        return tuple(self._path[self._changed :])

    def update(self, theta: float) -> BiasReport:
        """Take the θ0 of the next push and tell where the collection stands.

        Parameters
        ----------
        theta : float
            rad; wrapped, or any number of turns.

        Returns
        -------
        BiasReport
            The state after this push.

        Raises
        ------
        InvalidInput
            Where it is no finite number, or over 1e9 rad, where the fraction of a turn is lost;
            the monitor is then as it was.
        """
        angle = finite_number("theta", theta)
        if abs(angle) > LARGEST_ORIENTATION:
            raise InvalidInput(
                f"theta {angle:g} rad is over {LARGEST_ORIENTATION:g}: its fraction of a turn is "
                "lost; give it within a turn, or mend the record it comes from"
            )
        self._path.append(angle)
        for fed in (self._rest, self._visits, self._arcs, self.coverage):
            fed.add(angle)
        self._worth.append(self.coverage.effective_pushes)
        del self._worth[: -RECENT - 1]
        if self._alarm is None:
            threshold = math.log(2.0 / self.alarm_rate)
            push = len(self._path) - 1
            rest = self._rest.rest
            highest = max(self._rest.log_evidence, self._log_visits)
            # Whichever evidence raises the alarm, a rest that is under way says best what locks in.
            if rest is not None and highest >= threshold:
                self._alarm = Alarm(push, "rest", rest.towards, rest.began)
            elif self._log_visits >= threshold:
                self._alarm = Alarm(push, "visits", (self._visits.peak(),), None)
        return self.report

    def reset_changed(self) -> None:
        """Start anew, for the robot resets differently from the next push on.

        Evidence and alarm are dropped, and the alarm rate is given out afresh: it
        holds for each reset used. What has been covered stays covered.
        """
        self._changed = len(self._path)
        self._rest = RestEvidence(_RULE, self._changed)
        # Another stream of shuffles for each reset: none is used twice.
        self._visits = VisitEvidence(seed=self._changed)
        self._arcs = ArcEvidence(seed=self._changed)
        self._alarm = None

    @property
    def _log_visits(self) -> float:
        """Natural logarithm of the evidence for "visits": the mean of what blocks and arcs tell."""
        return float(np.logaddexp(self._visits.log_evidence, self._arcs.log_evidence)) - math.log(
            2.0
        )

    @property
    def report(self) -> BiasReport:
        """Where the collection stands."""
        rest = self._rest.rest
        coverage = self.coverage.state()
        # Told where it has lasted twice the window; a single hit may be chance.
        if rest is not None and len(self._path) - rest.began < 2 * _RULE.window * len(
            rest.directions
        ):
            rest = None
        return BiasReport(
            push=len(self._path) - 1,
            alarm=self._alarm,
            rest_evidence=self._rest.log_evidence / math.log(10.0),
            visit_evidence=self._log_visits / math.log(10.0),
            threshold=math.log10(2.0 / self.alarm_rate),
            rest=rest,
            useful_pushes=None
            if rest is None or self._alarm is None
            else self.coverage.useful_repeats(rest.directions, LEAST_GAIN),
            recent_worth=(coverage.effective_pushes - self._worth[0])
            / max(len(self._worth) - 1, 1),
            coverage=coverage,
            advice=Advice(self._alarm is not None, coverage.least_covered),
        )


def watch(theta: Iterable[float], monitor: BiasMonitor | None = None) -> tuple[BiasReport, ...]:
    """Return the reports on a collection's orientations, one a push.

    Parameters
    ----------
    theta : iterable of float
        The orientations, rad, in the order of the pushes.
    monitor : BiasMonitor or None, optional
        The monitor that is fed; None: a new one.

    Returns
    -------
    tuple of BiasReport
        The state after each push.

    Examples
    --------
    >>> from cyclemap.resets import watch
    >>> reports = watch([0.3] * 20)
    >>> [report.alarm is not None for report in reports].index(True)
    14
    """
    watching = BiasMonitor() if monitor is None else monitor
    return tuple(watching.update(angle) for angle in theta)
