"""A sweep in sentences: what was swept, how much of it is done, where it locks, what was refused."""

import math
from collections import Counter

import numpy as np

from cyclemap.sweeps.point_sets import MATERIAL_KEY
from cyclemap.sweeps.sweep_results import Sweep
from cyclemap.views.sweep_panels import axis_words, key_words

_MOST_REASONS = 3
_LONGEST_REASON = 160


def sweep_headline(sweep: Sweep) -> str:
    """What was swept, in a line, and what was selected of it."""
    names = "" if MATERIAL_KEY in sweep.keys else f"{', '.join(sweep.description['plan']['material'])}: "
    kept = [axis.key for axis in sweep.axes] or list(sweep.keys)
    fixed = [
        f"{key_words(key)} = {_value(sweep.swept[key][0])}" for key in sweep.keys if key not in kept and len(sweep)
    ]
    return f"{names}{' × '.join(map(key_words, kept))}{' at ' if fixed else ''}{', '.join(fixed)}"


def sweep_sentences(sweep: Sweep) -> list[str]:
    """How much is done, the share that locks, the stable directions, and the refusals."""
    total = math.prod(sweep.shape) if sweep.axes else int(sweep.description["count"])
    whole = f"{len(sweep)} points" if len(sweep) == total else f"{len(sweep)} of {total} points"
    told = [f"{whole} over {_swept(sweep)}."]
    if "locked_period" in sweep.columns:
        told.append(_locked_sentence(sweep))
    if "stable_points" in sweep.columns and np.isfinite(sweep.columns["stable_points"]).any():
        told.append(_stable_sentence(sweep))
    refused = [text for text in sweep.refusals if text]
    if refused:
        told.append(_refusal_sentence(refused))
    return told


def settings_line(sweep: Sweep) -> str:
    """What holds for all points: settings, and the accuracy asked for."""
    plan = sweep.description["plan"]
    told = ", ".join(f"{key}={value}" for key, value in plan["settings"].items())
    asked = plan["quantities"]
    accuracy = f"map to {np.degrees(asked['tolerance']):.1g}°" if "tolerance" in asked else ""
    pace = asked.get("rotation_tolerance", 0.0)
    turns = f"rotation numbers to {pace:g} turns a cycle" if pace and "rotation" in sweep.columns else ""
    return "; ".join(part for part in (f"set: {told}" if told else "", accuracy, turns) if part)


def _value(value: object) -> str:
    return f"{value:.5g}" if isinstance(value, float) else str(value)


def _swept(sweep: Sweep) -> str:
    if sweep.axes:
        return ", ".join(axis_words(axis) for axis in sweep.axes)
    sample = sweep.description["plan"]["points"]
    ranges = (
        f"{key_words(key)} {ends['low']:g} to {ends['high']:g}"
        if isinstance(ends, dict)
        else f"{key_words(key)} {', '.join(map(str, ends))}"
        for key, ends in sample.get("ranges", {}).items()
    )
    return f"{', '.join(ranges)} ({sample.get('sequence')} sample, seed {sample.get('seed')})"


def _locked_sentence(sweep: Sweep) -> str:
    """How many points are proved to lock, and to what."""
    period, winding = sweep.columns["locked_period"], sweep.columns["locked_winding"]
    locked = period > 0
    if not locked.any():
        return "No point is proved to lock."
    ratios = Counter(
        f"{int(p)}/{int(q)}" for p, q in zip(winding[locked].tolist(), period[locked].tolist(), strict=True)
    )
    listed = ", ".join(f"{count} at {ratio}" for ratio, count in ratios.most_common(_MOST_REASONS))
    more = ", ..." if len(ratios) > _MOST_REASONS else ""
    return f"{int(locked.sum())} lock ({listed}{more})."


def _stable_sentence(sweep: Sweep) -> str:
    counts = Counter(sweep.columns["stable_points"][np.isfinite(sweep.columns["stable_points"])].astype(int).tolist())
    listed = ", ".join(f"{counts[count]} with {count}" for count in sorted(counts))
    return f"Stable directions: {listed}."


def _refusal_sentence(refused: list[str]) -> str:
    reason, count = Counter(text.partition(" (set:")[0] for text in refused).most_common(1)[0]
    short = reason if len(reason) <= _LONGEST_REASON else f"{reason[: _LONGEST_REASON - 1]}…"
    most = f"{count} of them" if count < len(refused) else "all of them" if count > 1 else "it"
    return f"{len(refused)} refused; {most} so: {short}."
