"""Resets: what the robot does otherwise, how evenly the orientations spread then, and how to watch it."""

from cyclemap.resets.monitor.bias_monitor import BiasMonitor, watch
from cyclemap.resets.monitor.bias_report import Advice, Alarm, BiasReport
from cyclemap.resets.monitor.coverage import Coverage, CoverageRule, CoverageState
from cyclemap.resets.monitor.forecast import Forecast, forecast
from cyclemap.resets.monitor.rest_direction import Rest
from cyclemap.resets.monitor.rest_evidence import RestRule

__all__ = [
    "Advice",
    "Alarm",
    "BiasMonitor",
    "BiasReport",
    "Coverage",
    "CoverageRule",
    "CoverageState",
    "Forecast",
    "Rest",
    "RestRule",
    "forecast",
    "watch",
]
