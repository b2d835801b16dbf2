"""Results as JSON: degrees and millimetres, every number finite or null."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import TYPE_CHECKING

from cyclemap import file_text
from cyclemap.written import (
    DEGREES,
    MILLIMETRES,
    NUMBER,
    Json,
    Unit,
    degrees,
    direction_deg,
    json_of,
    rows,
    written,
)

if TYPE_CHECKING:
    from cyclemap.collection.loop import CollectionLoop
    from cyclemap.collection.uncertain_directions import DirectionUncertainty
    from cyclemap.evidence import MeasuredStaircase
    from cyclemap.maps import Orbit, StepComparison, Steps
    from cyclemap.mechanics import SidePush
    from cyclemap.resets import ResetStrategy

# What a push changes, what is known of it, and what these are written in.
UNITS = {"dtheta": DEGREES, "dx": MILLIMETRES, "dy": MILLIMETRES}
# The same where the unit is said elsewhere.
PLAIN_UNITS = {name: Unit("", unit.of_si) for name, unit in UNITS.items()}
FACT_UNITS = {
    "surface": NUMBER,
    "object": NUMBER,
    "acceleration": Unit("mm_s2", MILLIMETRES.of_si),
    "speed": Unit("mm_s", MILLIMETRES.of_si),
    "side": NUMBER,
    "fraction": NUMBER,
    "angle": DEGREES,
}


def actions_report(strategy: ResetStrategy, loop: CollectionLoop) -> list[Json]:
    """The strategy's actions, filled in by their loop, with their shares of the cycles."""
    from cyclemap.views.reset_page import action_words

    return [
        {
            "name": action_words(action),
            "weight": written(share),
            **push_report(acted.push),
            "way_points_mm": [[*map(millimetres, place)] for place in acted.reset.way_points],
            "gripper_turn_deg": degrees(action.turn),
        }
        for action, acted, share in zip(
            strategy.actions, strategy.loops(loop), strategy.shares, strict=True
        )
    ]


def push_report(push: SidePush) -> Json:
    """How the rod pushes."""
    return {
        **json_of(push, "side", "fraction"),
        "angle_deg": degrees(push.angle),
        "push_mm": millimetres(push.distance),
    }


def orbit_report(orbit: Orbit) -> Json:
    """Where a fixed point is, and whether it is stable."""
    return {
        "theta_deg": direction_deg(float(orbit.points[0])),
        **json_of(orbit, "multiplier", "stable"),
    }


def json_text(report: Json) -> str:
    """The text of a report, ending with a line break; NaN and infinities are refused."""
    return json.dumps(report, indent=2, allow_nan=False, ensure_ascii=False) + "\n"


def uncertainty_report(known: DirectionUncertainty) -> Json:
    """How well stable directions are known; `upper_deg` may pass 360. Of no posterior the shares
    are no chances.
    """
    return {
        **json_of(known, "source", "method", "first_order_error", "samples", "locks"),
        "chance_of_lock_in": known.chance if known.is_posterior else None,
        **json_of(known, "directions"),
    }


def steps_report(steps: Steps) -> Json:
    """The dwells and steps of a path."""
    return {
        **json_of(steps, "cycles", "climb"),
        "steps": steps.count,
        "heights_deg": degrees(steps.heights),
        "dwells": rows(
            first_cycle=steps.start,
            cycles=steps.lengths,
            level_deg=degrees(steps.levels),
            censored=steps.censored,
        ),
    }


def measured_report(measured: MeasuredStaircase) -> Json:
    """A measured staircase, and what the map fitted to it predicts."""
    report = steps_report(measured.steps)
    foretold = measured.foretold
    if foretold is None:
        return {**report, "fitted": None, "problem": measured.problem, "comparison": None}
    return {
        **report,
        "fitted": {
            "harmonics": foretold.fitted.law.harmonics,
            "pairs": foretold.fitted.pairs,
            "noise_deg": degrees(foretold.fitted.sigma),
            **json_of(foretold.prediction),
        },
        "problem": None,
        "comparison": comparison_report(foretold.comparison),
    }


def comparison_report(comparison: StepComparison, errors: bool = True) -> Json:
    """Steps and visits measured beside those predicted; of visits also their standard errors where
    asked for.
    """
    means = ("mean", "standard_error") if errors else ("mean",)
    visits = [
        {
            **json_of(visit.zone, "centre"),
            **json_of(visit, "exits", *means, "predicted", "mean_p_value"),
        }
        for visit in comparison.visits
    ]
    return {**json_of(comparison, "net_steps", "expected_steps", "pace_p_value"), "visits": visits}


def facts_report(facts: Mapping[str, object], *left_out: str) -> Json:
    """What the pushes of a set share, None where it is not known."""
    return {
        unit.named(name): written(facts.get(name), unit)
        for name, unit in FACT_UNITS.items()
        if name not in left_out
    }


def millimetres(metres: float) -> float:
    """Return a length that was set in millimetres, in the digits it was set in.

    >>> millimetres(0.01378)
    13.78
    """
    return float(file_text.MILLIMETRES.written(metres))
