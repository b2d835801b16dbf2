"""The report of `cyclemap replay` as JSON: every push and every group, in degrees and millimetres."""

import math
from typing import TYPE_CHECKING, Any

from cyclemap.cli.json_report import Json
from cyclemap.evidence.replay.replay_table import ReplayedPushes

if TYPE_CHECKING:
    import pandas

# Columns in m, m/s or m/s^2 and in rad, and what they are called in mm and degrees.
_MILLIMETRES = {
    "speed": "speed_mm_s",
    "acceleration": "acceleration_mm_s2",
    **{
        name: f"{name}_mm"
        for name in (
            "error", "rms_error", "measured_motion", "predicted_motion", "shift", "start_gap", "straightness",
            "mean_error", "median_error", "mean_motion", "mean_rms_error", "isotropic_error", "isotropic_mean_error",
        )
    },
}  # fmt: skip
_DEGREES = {
    name: f"{name}_deg"
    for name in (
        "angle", "turn_error", "rms_turn_error", "measured_turn", "predicted_turn", "mean_turn_error",
        "median_turn_error", "mean_turn", "isotropic_turn_error", "isotropic_mean_turn_error",
    )
}  # fmt: skip


def replay_report(replayed: ReplayedPushes, material: str, pusher_friction: float) -> Json:
    """The replays of a collection: the groups by object and by speed, every push, and the files left out."""
    error, turn_error = replayed.mean_errors
    return {
        "material": material,
        "pusher_friction": pusher_friction,
        "pushes": len(replayed.table),
        "mean_error_mm": _plain(1e3 * error),
        "mean_turn_error_deg": _plain(math.degrees(turn_error)),
        "by_object": _rows(replayed.by("surface", "object")),
        "by_speed": _rows(replayed.by("speed")),
        "replays": _rows(replayed.table),
        "not_replayed": [{"path": str(file.path), "reason": file.reason} for file in replayed.not_replayed],
    }


def _rows(table: "pandas.DataFrame") -> list[Json]:
    return [dict(_entry(str(name), value) for name, value in row.items()) for row in table.to_dict("records")]


def _entry(name: str, value: Any) -> tuple[str, object]:
    if name in _MILLIMETRES:
        return _MILLIMETRES[name], _plain(1e3 * value)
    if name in _DEGREES:
        return _DEGREES[name], _plain(math.degrees(value))
    return name, _plain(value)


def _plain(value: Any) -> object:
    """A value that JSON can hold: no NaN, no numpy scalar."""
    if hasattr(value, "item"):
        value = value.item()
    return None if isinstance(value, float) and not math.isfinite(value) else value
