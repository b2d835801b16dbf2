"""The monitor of a collection: fed θ0 push by push, it tells whether the data are locking in."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput
from cyclemap.resets.monitor.bias_report import Advice, Alarm, BiasReport
from cyclemap.resets.monitor.coverage import Coverage, CoverageRule
from cyclemap.resets.monitor.rest_direction import Rest
from cyclemap.resets.monitor.rest_evidence import RestEvidence, RestRule
from cyclemap.resets.monitor.visit_evidence import VisitEvidence

ALARM_RATE = 0.01
LEAST_GAIN = 0.1  # a push is useful while it tells a tenth of what the most telling one would
# Radians: beyond this a float keeps less than seven digits of the fraction of a turn.
LARGEST_ORIENTATION = 1e9
RECENT = 50  # pushes over which the recent worth is taken


class BiasMonitor:
    """Tells, while a collection runs, whether its orientations lock in, and what would help.

    ``alarm_rate`` : the chance, in (0, 1), that it ever raises an alarm on a collection without bias, however long. It
    holds by a theorem, Ville's inequality, half of it for each kind of evidence:

    - against "visits" for every reset whose turns are exchangeable, so do not depend on where the object stood,
      whatever their law: independent uniform θ0, isotropic friction with any turn and any noise, final directions drawn
      at random;
    - against "rest" where θ0, whenever it has lingered (``RestRule``), comes back within ``half_width`` with chance ½
      at most: independent uniform θ0, every noise that leaves no arc of 2·half_width more than half the probability
      (normal with 17.8° or more), and steady climbs faster than ``RestRule.slowest_climb``, up to the chance that
      noise holds them up (below 1e-15 a push for 8° a push with 1.1° of noise).

    A steady climb that is slower, or that comes round to the same few directions for many pushes, does raise the alarm:
    its law is even in the long run, but the next hundred pushes are spent on neighbours.

    The monitor changes as it is fed, for a collection has one course; each report is a value that stays. A push costs
    some tenths of a millisecond, however many came before; the orientations are kept, for ``forecast``.
    The same orientations and ``seed`` give the same reports, θ0 wrapped or not.

    >>> monitor = BiasMonitor()
    >>> for turn in range(20):
    ...     report = monitor.update(math.radians(85.0))
    >>> report.alarm.kind, report.alarm.push, round(math.degrees(report.alarm.directions[0]))
    ('rest', 16, 85)
    >>> round(math.degrees(report.advice.direction))
    265
    """

    def __init__(
        self,
        alarm_rate: float = ALARM_RATE,
        *,
        rest_rule: RestRule | None = None,
        coverage_rule: CoverageRule | None = None,
        seed: int = 0,
    ) -> None:
        if not 0.0 < finite_number("alarm_rate", alarm_rate) < 1.0:
            raise InvalidInput(f"alarm_rate must lie between 0 and 1, such as 0.01, not {alarm_rate!r}")
        self.alarm_rate = alarm_rate
        self.rest_rule = rest_rule or RestRule()
        self._seed = whole_number("seed", seed, least=0)
        self._coverage = Coverage(coverage_rule)
        self._path: list[float] = []
        self._worth = [0.0]
        self._changed = 0
        self._alarm: Alarm | None = None
        self._alarms: tuple[Alarm, ...] = ()
        self._begin()

    @property
    def alarms(self) -> tuple[Alarm, ...]:
        """Every alarm so far: one at most for each reset used."""
        return self._alarms

    @property
    def path(self) -> tuple[float, ...]:
        """The orientations fed since the reset was last changed, rad, as they were given."""
        return tuple(self._path[self._changed :])

    @property
    def coverage(self) -> Coverage:
        """What is covered, over all resets used."""
        return self._coverage

    def update(self, theta: float) -> BiasReport:
        """Take the θ0 of the next push (rad; wrapped, or any number of turns) and tell where the collection stands.

        Raises InvalidInput where it is no finite number, or over 1e9 rad, where the fraction of a turn is lost; the
        monitor is then as it was.
        """
        angle = finite_number("theta", theta)
        if abs(angle) > LARGEST_ORIENTATION:
            raise InvalidInput(
                f"theta {angle:g} rad is over {LARGEST_ORIENTATION:g}: its fraction of a turn is lost; "
                "give it within a turn, or mend the record it comes from"
            )
        self._path.append(angle)
        self._rest.add(angle)
        self._visits.add(angle)
        self._coverage.add(angle)
        self._worth.append(self._coverage.effective_pushes)
        del self._worth[: -RECENT - 1]
        if self._alarm is None:
            self._alarm = self._raised()
            self._alarms += () if self._alarm is None else (self._alarm,)
        return self.report

    def reset_changed(self) -> None:
        """Start anew, for the robot resets differently from the next push on.

        Evidence, alarm and the orientations to forecast from are dropped, and the alarm rate is given out afresh: it
        holds for each reset used. What has been covered stays covered.
        """
        self._changed = len(self._path)
        self._begin()

    @property
    def report(self) -> BiasReport:
        """Where the collection stands."""
        rest, coverage = self._lasting_rest(), self._coverage.state()
        return BiasReport(
            push=len(self._path) - 1,
            since_change=len(self._path) - self._changed,
            alarm=self._alarm,
            rest_evidence=self._rest.log_evidence / math.log(10.0),
            visit_evidence=self._visits.log_evidence / math.log(10.0),
            threshold=math.log10(2.0 / self.alarm_rate),
            rest=rest,
            useful_pushes=self._useful(rest),
            recent_worth=self._recent_worth(coverage.effective_pushes),
            coverage=coverage,
            advice=Advice(self._alarm is not None, coverage.least_covered),
        )

    def _begin(self) -> None:
        self._rest = RestEvidence(self.rest_rule)
        # Another stream of shuffles for each reset: none is used twice.
        self._visits = VisitEvidence(self.rest_rule.half_width, seed=self._seed + self._changed)
        self._alarm = None

    def _raised(self) -> Alarm | None:
        threshold, push = math.log(2.0 / self.alarm_rate), len(self._path) - 1
        if self._rest.log_evidence >= threshold:
            rest = self._counted(self._rest.rest)
            if rest is not None:
                return Alarm(push, "rest", rest.towards, rest.began)
        if self._visits.log_evidence >= threshold:
            return Alarm(push, "visits", (self._visits.peak(),), None)
        return None

    def _recent_worth(self, effective: float) -> float:
        return (effective - self._worth[0]) / max(len(self._worth) - 1, 1)

    def _lasting_rest(self) -> Rest | None:
        """The rest just now, where it has lasted twice the window; a single hit may be chance."""
        rest = self._counted(self._rest.rest)
        if rest is None:
            return None
        lasted = len(self._path) - rest.began
        return rest if lasted >= 2 * self.rest_rule.window * len(rest.directions) else None

    def _counted(self, rest: Rest | None) -> Rest | None:
        """A rest counted from the first push fed, not from the last change of the reset."""
        return None if rest is None else replace(rest, began=rest.began + self._changed)

    def _useful(self, rest: Rest | None) -> int | None:
        if self._alarm is None or rest is None:
            return None
        return self._coverage.useful_repeats(rest.directions, LEAST_GAIN)


def watch(theta: Iterable[float], monitor: BiasMonitor | None = None) -> tuple[BiasReport, ...]:
    """The reports on the orientations ``theta`` (rad), one a push; of a new ``BiasMonitor`` unless one is given.

    >>> reports = watch([0.3] * 20)
    >>> [report.alarm is not None for report in reports].index(True)
    16
    """
    watching = BiasMonitor() if monitor is None else monitor
    return tuple(watching.update(angle) for angle in theta)
