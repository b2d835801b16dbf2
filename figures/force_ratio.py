"""Tangential over normal force at the pushing point over one push: predicted, and of one recorded
push.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from numpy.typing import NDArray

from cyclemap.arrays import Array
from cyclemap.checks import read_only
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.force_blocks import (
    SLIDING,
    STICKING,
    SlidingForces,
    sliding_forces,
)
from cyclemap.evidence.pushes.contact_forces import contact_samples
from cyclemap.evidence.pushes.recordings import push_facts
from cyclemap.mechanics import MIT_SHAPE_NAMES, Slider, Trajectory
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.scene import MM
from cyclemap.views.panels.style import EVEN, LINE, MARKS, QUIET, Look, picture_style

from .catalogue import NO_DATA, Exhibit, MeasuredFolder
from .materials.paper_pushes import push_file_names, readable_pushes

Chosen = NDArray[np.bool_]
FOLDER = "mit_files"
# Most recorded pushes that are looked through for one that both sticks and slides.
MOST_FILES = 120
_STEPS = 240


@dataclass(frozen=True, eq=False)
class PredictedRatio:
    """travel (n,) m, of the rod; ratio (n,) tangential over normal force; sliding (n,); friction :
    of the rod.

    The tangent is a quarter turn counter-clockwise from the normal into the object.
    """

    travel: Array
    ratio: Array
    sliding: Chosen
    friction: float


@dataclass(frozen=True, eq=False)
class RecordedRatio:
    """The samples of one recorded push in which rod and object touch.

    name : object, surface and speed. travel (n,) m; ratio (n,); sliding, sticking (n,) by the
        motion alone, neither where the poses do not tell.
    forces : of its pieces.
    files : looked through; unreadable : those passed over.
    """

    name: str
    travel: Array
    ratio: Array
    sliding: Chosen
    sticking: Chosen
    forces: SlidingForces
    files: int
    unreadable: int

    @property
    def friction(self) -> float:
        """Median ratio of the sliding pieces, positive where friction goes with the slip."""
        return float(np.median(self.forces.ratio))


@dataclass(frozen=True, eq=False)
class ForceRatio:
    """The predicted push, and the recorded one;
    None where none was found that sticks and slides."""

    predicted: PredictedRatio
    recorded: RecordedRatio | None


def compute(measured: MeasuredFolder) -> ForceRatio:
    """Run the MIT push on plywood from θ0 = 0, and read the recorded push that sticks and slides
    most.
    """
    loop = CollectionLoop.mit("plywood")
    push = loop.model.push(loop.start_pose(0.0), loop.push, loop.push.distance / _STEPS)
    predicted = predicted_ratio(push.trajectory, loop.pusher.radius, loop.pusher.friction)
    return ForceRatio(predicted, recorded_ratio(measured))


def predicted_ratio(course: Trajectory, radius: float, friction: float) -> PredictedRatio:
    """Return the ratio along a push of a rod of `radius` (m) and friction
    coefficient `friction`."""
    normal = (course.contact_point - course.pusher) / radius
    tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=-1)
    along, into = (
        np.sum(course.contact_force * tangent, axis=1),
        np.sum(course.contact_force * normal, axis=1),
    )
    sliding = np.char.startswith(np.asarray(course.mode, dtype=str), "slide")
    return PredictedRatio(read_only(course.path), read_only(along / into), sliding, friction)


def recorded_ratio(measured: MeasuredFolder) -> RecordedRatio | None:
    """Return the ratio of that recorded push of an MIT shape which has most samples of sticking and
    of sliding both.
    """
    home = measured.find(FOLDER)
    named = [] if home is None else [(path, push_facts(path)) for path in push_file_names(home)]
    shapes = {
        path: facts
        for path, facts in named
        if facts is not None and facts.object in MIT_SHAPE_NAMES
    }
    records, unreadable = readable_pushes(list(shapes)[:MOST_FILES])
    most, best = 0, None
    for path, record in records:
        outline = Slider.mit(str(shapes[path].object)).outline_points(360)
        forces = sliding_forces([(record, outline)])
        if min(forces.samples, forces.sticking) > most:
            most, best = (
                min(forces.samples, forces.sticking),
                (shapes[path], record, outline, forces),
            )
    if best is None:
        return None
    facts, record, outline, forces = best
    samples = contact_samples(record, outline)
    kept = samples.touching & np.isfinite(samples.slip)
    slip = np.abs(samples.slip[kept])
    # The rod's way at the times of the wrenches that both other clocks cover.
    tip, time = record.tip_pose, record.ft_wrench[:, 0]
    clocks = record.object_pose[:, 0], tip[:, 0]
    time = time[(time >= max(c[0] for c in clocks)) & (time <= min(c[-1] for c in clocks))]
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(tip[:, 1:3], axis=0).T))])
    travel = np.interp(time, tip[:, 0], travelled)[kept]
    ratio = samples.force[kept].imag / samples.force[kept].real
    name = f"{facts.object} on {facts.surface}, {MM * facts.speed:.0f} mm/s"
    motion = slip > SLIDING, slip < STICKING
    return RecordedRatio(
        name, read_only(travel), read_only(ratio), *motion, forces, len(records), unreadable
    )


@picture_style()
def draw(result: ForceRatio) -> Figure:
    """Draw the predicted ratio, and the recorded one, where there is one, to the right of it, on
    one scale.
    """
    predicted, recorded = result.predicted, result.recorded
    ratios = [predicted.ratio] if recorded is None else [predicted.ratio, recorded.ratio]
    half = 1.2 * max(float(np.abs(ratio).max()) for ratio in ratios)
    figure, (left, *right) = page("ab"[: len(ratios)], size=(5.5 * len(ratios), 4.3))
    _bounds(left, predicted.friction)
    travel, sticking = MM * predicted.travel, np.where(predicted.sliding, np.nan, predicted.ratio)
    left.plot(travel, predicted.ratio, label="sliding", **{**LINE, "linewidth": 1.2})
    left.plot(travel, sticking, label="sticking", **{**LINE, "linewidth": 3.0})
    entitle(left, "Predicted, plywood")
    if recorded is not None:
        _draw_recorded(right[0], recorded)
    for axes in (left, *right):
        axes.set(ylim=(-half, half), xlabel="travel of the rod (mm)")
    left.set_ylabel("tangential / normal force (1)")
    return figure


def _bounds(axes: Axes, friction: float) -> None:
    for bound in (-friction, friction):
        axes.axhline(bound, label=f"±μp = ±{friction:.2f}", **EVEN)


def _draw_recorded(axes: Axes, recorded: RecordedRatio) -> None:
    _bounds(axes, recorded.friction)
    unclear = ~(recorded.sliding | recorded.sticking)
    kinds: tuple[tuple[str, Chosen, Look], ...] = (
        ("sliding", recorded.sliding, {"marker": "o", "markerfacecolor": "white"}),
        ("sticking", recorded.sticking, {"marker": "o"}),
        ("neither", unclear, {"marker": ".", "color": QUIET, "markeredgewidth": 0.0}),
    )
    travel = MM * recorded.travel
    for name, chosen, look in kinds:
        axes.plot(travel[chosen], recorded.ratio[chosen], label=name, **{**MARKS, **look})
    entitle(axes, f"Recorded, {recorded.name}")


def caption(result: ForceRatio) -> str:
    """Where the predicted ratio sits, and where the recorded one does."""
    predicted, recorded = result.predicted, result.recorded
    stuck = predicted.travel[~predicted.sliding]
    words = (
        "Ratio of tangential to normal force of the rod on the object over one push; the tangent "
        "is a quarter turn counter-clockwise from the normal into the object. The push from θ0 = 0 "
        f"on plywood, predicted: ±{predicted.friction:.2f} where the rod slides (thin), between "
        f"where it sticks (thick, from {MM * stuck[0]:.0f} to {MM * stuck[-1]:.0f} mm)."
    )
    if recorded is None:
        return (
            f"{words} {NO_DATA.capitalize()} of a push that sticks and slides (sought in {FOLDER})."
        )
    over = float(np.mean(np.abs(recorded.ratio[recorded.sticking]) < recorded.friction))
    damaged = f" ({recorded.unreadable} more could not be read)" if recorded.unreadable else ""
    return (
        f"{words} On the right, of {recorded.files} recorded pushes{damaged} the one that both "
        f"sticks and slides most, {recorded.name}. Whether the rod slides is read off the motion, "
        f"not off the forces. While it slides the ratio is {recorded.friction:.3f} (median of "
        f"{len(recorded.forces.ratio)} pieces; the paper's push has 0.15); while it sticks "
        f"{100 * over:.0f} % of the samples lie below that."
    )


EXHIBITS = {
    "force-ratio": Exhibit(compute, caption, draw),
}
