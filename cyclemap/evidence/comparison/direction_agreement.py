"""Predicted stable directions and slow zones beside the modes of the measured histogram."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.evidence.orientations.collection_null import Ensemble
from cyclemap.evidence.orientations.goodness_of_fit import PValue, monte_carlo_p_value
from cyclemap.evidence.orientations.orientation_comparison import (
    DEFAULT_BANDWIDTH,
    angle_between,
    kernel_modes,
    nearest_modes,
)
from cyclemap.maps import SlowZone

# Orientations of the ensemble from which the predicted modes are taken.
_POOLED = 12_000


@dataclass(frozen=True)
class DirectionMatch:
    """A predicted direction and the measured mode nearest to it, rad in [0, 2π).

    kind : "stable", "jump", "ghost", as of a ``SlowZone``. centre : of the zone.
    predicted_mode : mode of the predicted collections' orientations nearest to the centre, by the kernel that the
        measured modes come from: a ghost's mode lies beside its slowest point. measured_mode : nearest to that.
    difference : measured less predicted mode, in [-π, π). None where there is no mode.
    p_value : of a difference so large, among simulated collections; exact for a prediction that was not fitted to
        these data, else too large.
    """

    kind: str
    centre: float
    predicted_mode: float | None
    measured_mode: float | None
    difference: float | None
    p_value: PValue | None


@dataclass(frozen=True, eq=False)
class DirectionAgreement:
    """All directions. matches : one a predicted zone. measured_modes, predicted_modes : (k,) rad, sorted."""

    matches: tuple[DirectionMatch, ...]
    measured_modes: Array
    predicted_modes: Array


def direction_agreement(
    path: Array,
    zones: tuple[SlowZone, ...],
    ensemble: Ensemble,
    null: Array,
    bandwidth: float = DEFAULT_BANDWIDTH,
) -> DirectionAgreement:
    """Match the predicted ``zones`` with the modes of ``path`` (n,) rad.

    ensemble : of the predicted collections. null : (runs, n) others, of which the p-values are made.
    bandwidth : of the kernel estimates, rad.
    """
    measured = kernel_modes(path, bandwidth)
    stride = max(1, ensemble.paths.size // _POOLED)
    predicted = kernel_modes(ensemble.paths.ravel()[::stride], bandwidth)
    simulated = [kernel_modes(one, bandwidth) for one in null] if zones else []
    matches = tuple(_match(zone, predicted, measured, simulated) for zone in zones)
    return DirectionAgreement(matches, read_only(measured), read_only(predicted))


def _match(zone: SlowZone, predicted: Array, measured: Array, simulated: list[Array]) -> DirectionMatch:
    mode = _nearest(zone.centre, predicted)
    seen = None if mode is None else _nearest(mode, measured)
    if mode is None or seen is None:
        return DirectionMatch(zone.kind, zone.centre, mode, seen, None, None)
    off = float(angle_between(np.asarray(mode), np.asarray(seen)))
    # A simulated collection without any mode is as far off as can be.
    null = [_distance(mode, modes) for modes in simulated]
    return DirectionMatch(zone.kind, zone.centre, mode, seen, off, monte_carlo_p_value(abs(off), null))


def _nearest(target: float, modes: Array) -> float | None:
    return float(nearest_modes(np.asarray(target), modes)) if modes.size else None


def _distance(target: float, modes: Array) -> float:
    seen = _nearest(target, modes)
    return float(np.pi) if seen is None else abs(float(angle_between(np.asarray(target), np.asarray(seen))))
