"""A collection being watched: its monitor, and the course of the evidence for a picture of it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from cyclemap.checks import read_only
from cyclemap.errors import InvalidInput
from cyclemap.evidence.theta0.theta0_statistics import AngleHistogram, angle_histogram
from cyclemap.resets.monitor.bias_monitor import ALARM_RATE, BiasMonitor
from cyclemap.resets.monitor.bias_report import BiasReport
from cyclemap.resets.monitor.forecast import Forecast, forecast

Array = NDArray[np.float64]
HISTOGRAM_BINS = 36


@dataclass(frozen=True, eq=False)
class WatchedCourse:
    """A watched collection as it stands after n pushes.

    theta : (n,) rad, in [0, 2π). rest_evidence, visit_evidence : (n,) log10, after each push. effective_pushes : (n,).
    histogram : of the directions. report : after the last push. alarm_rate : of the monitor.
    forecast : of the next pushes; None where too little was recorded.
    """

    theta: Array
    rest_evidence: Array
    visit_evidence: Array
    effective_pushes: Array
    histogram: AngleHistogram
    report: BiasReport
    alarm_rate: float
    forecast: Forecast | None

    @property
    def pushes(self) -> int:
        """How many pushes were fed."""
        return int(self.theta.size)


class WatchedCollection:
    """A monitor that remembers the course of what it told.

    >>> watched = WatchedCollection()
    >>> for turn in range(30):
    ...     report = watched.add(0.1)
    >>> watched.course().report.alarm.push
    16
    """

    def __init__(self, alarm_rate: float = ALARM_RATE) -> None:
        self.monitor = BiasMonitor(alarm_rate)
        self._rows: list[tuple[float, float, float]] = []

    @property
    def pushes(self) -> int:
        """How many pushes were fed."""
        return len(self._rows)

    def add(self, theta: float) -> BiasReport:
        """Take the next θ0 (rad)."""
        report = self.monitor.update(theta)
        self._rows.append((report.rest_evidence, report.visit_evidence, report.coverage.effective_pushes))
        return report

    def course(self) -> WatchedCourse:
        """The course so far; InvalidInput where nothing was fed."""
        if not self._rows:
            raise InvalidInput("no push was fed; give at least one θ0")
        theta = read_only(np.mod(self.monitor.path, 2 * np.pi))
        rest, visits, effective = (read_only(column) for column in zip(*self._rows, strict=True))
        return WatchedCourse(
            theta=theta,
            rest_evidence=rest,
            visit_evidence=visits,
            effective_pushes=effective,
            histogram=angle_histogram(theta, HISTOGRAM_BINS),
            report=self.monitor.report,
            alarm_rate=self.monitor.alarm_rate,
            forecast=forecast(self.monitor),
        )
