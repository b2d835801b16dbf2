"""Forces on the object: a point's limit ellipse, the one fitted to friction scans, those of the
patch; and the ratio of tangential to normal force at the rod over one push.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array, Mask, turned
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.force_blocks import (
    SLIDING,
    STICKING,
    SlidingForces,
    friction_ellipse_from_scans,
    scan_traction,
    sliding_forces,
)
from cyclemap.evidence.pushes.contact_forces import contact_samples
from cyclemap.evidence.pushes.recordings import push_facts
from cyclemap.mechanics import (
    MIT_SHAPE_NAMES,
    EllipseFriction,
    PointFootprint,
    Slider,
    Trajectory,
    grid_footprint,
)
from cyclemap.views.identify_page import draw_ellipses
from cyclemap.views.panels.layout import entitle, page
from cyclemap.views.panels.scene import MM, draw_object
from cyclemap.views.panels.style import (
    EVEN,
    FORCE,
    INK,
    LINE,
    MARKS,
    PREDICTED,
    PREDICTED_FILL,
    QUIET,
    Look,
    arrow,
    cross,
    picture_style,
    show_window,
)

from . import NO_DATA, Exhibit, MeasuredFolder
from .repeated_pushes import measured_scans, push_file_names, readable_pushes

# Direction (rad) in which the point of the first panel slides: one whose traction leans visibly
# away from it.
DIRECTION = math.radians(100.0)
# The ellipse of the first panel, drawn rounder than no surface is: Table I's axes differ too little
# to be seen.
SKETCHED = EllipseFriction(0.30, 0.15, m0=0.05, n0=0.02, phi=math.radians(25.0))
_FEWEST_SCANS = 3
# Millimetres of arrow a force of one point, and of the whole patch.
_POINT_ARROW, _WHOLE_ARROW = 9.0, 34.0
GRID = 8
# Of the panels of tractions, from their middle.
_REACH = 0.34
# The instant is after this share of the push's way.
SHARE = 0.3
_STEPS = 1000


@dataclass(frozen=True, eq=False)
class LimitEllipseAndPatch:
    """What the panels show beside a sketched law: the law of plywood with scans and their fit, and
    the patch.

    table : Table I.
    scans (n, 2) tractions, fitted : None where no scans were found.
    """

    table: EllipseFriction
    scans: Array | None
    fitted: EllipseFriction | None
    patch: PatchForces


def limit_ellipse_and_patch(measured: MeasuredFolder) -> LimitEllipseAndPatch:
    """Read and fit the friction scans of rect1 on plywood where there are any, and run one push on
    the 8 x 8 grid.
    """
    loop = CollectionLoop.mit("plywood")
    law, patch, table = (
        loop.material.friction,
        patch_forces(loop),
        measured_scans(measured, "plywood"),
    )
    if table is None or len(table) < _FEWEST_SCANS:
        return LimitEllipseAndPatch(law, None, None, patch)
    weight = loop.model.weight
    fitted = friction_ellipse_from_scans(table, weight).friction()
    return LimitEllipseAndPatch(law, scan_traction(table, weight), fitted, patch)


def limit_curve(law: EllipseFriction) -> Array:
    """Return the limit ellipse as a closed polyline (241, 2), by the traction of every direction of
    sliding.
    """
    angle = np.linspace(0.0, TWO_PI, 241)
    return law.traction(np.stack([np.cos(angle), np.sin(angle)], axis=-1))


@picture_style()
def draw_limits(result: LimitEllipseAndPatch) -> Figure:
    """Draw the law of a point, the law of the surface, and the patch, side by side."""
    figure, (law, surface, patch) = page("abc", size=(13.0, 4.9))
    _draw_law(law)
    _draw_surface(surface, result)
    _draw_patch(patch, result.patch)
    return figure


def _draw_law(axes: Axes) -> None:
    law, velocity = SKETCHED, np.array([math.cos(DIRECTION), math.sin(DIRECTION)])
    traction, centre = law.traction(velocity), _centre(law)
    axes.fill(*limit_curve(law).T, facecolor=PREDICTED_FILL, edgecolor=PREDICTED, linewidth=1.8)
    for reach, turn, name in ((law.mu_a, 0.0, "m"), (law.mu_b, 0.5 * math.pi, "n")):
        axis = turned(np.array([reach, 0.0]), law.phi + turn)
        ends = np.stack([centre - axis, centre + axis])
        axes.plot(*ends.T, color=QUIET, linewidth=0.9, linestyle="--")
        x, y = (centre + (1.0 + 0.03 / reach) * axis).tolist()
        axes.text(x, y, name, color=QUIET, ha="center", va="center", style="italic")
    along = np.array([-velocity[1], velocity[0]])
    tangent = np.stack([traction - 0.25 * along, traction + 0.1 * along])
    axes.plot(*tangent.T, color=QUIET, linewidth=1.2, linestyle=":")
    axes.plot(*centre, "o", color=PREDICTED, markersize=4)
    cross(axes, colour=INK, markeredgewidth=1.5)
    head = traction + 0.13 * velocity
    arrow(axes, np.zeros(2), traction, FORCE, 2.2, 6, mutation_scale=14.0)
    arrow(axes, traction, head, INK, 2.2, 6, mutation_scale=14.0)
    words = (
        (0.75 * traction, (0.025, -0.003), "traction μ", FORCE, "center"),
        (head, (0.03, 0.0), "sliding velocity v", INK, "center"),
        (centre, (0.012, -0.012), "centre (m0, n0)", PREDICTED, "top"),
    )
    for place, offset, name, colour, side in words:
        x, y = (place + offset).tolist()
        axes.text(x, y, name, color=colour, va=side)
    _traction_axes(axes, "Limit ellipse of a point (sketch)", centre)


def _draw_surface(axes: Axes, result: LimitEllipseAndPatch) -> None:
    law = result.table
    curves = {"Table I": law}
    if result.fitted is not None:
        curves["fitted"] = result.fitted
    curves["isotropic"] = EllipseFriction.isotropic(math.sqrt(law.mu_a * law.mu_b))
    ellipses = {name: limit_curve(ellipse) for name, ellipse in curves.items()}
    draw_ellipses(axes, ellipses, result.scans)
    axes.plot(*_centre(law), "o", color=PREDICTED, markersize=4)
    _traction_axes(axes, "Plywood", np.zeros(2))


def _draw_patch(axes: Axes, patch: PatchForces) -> None:
    points = MM * patch.footprint.quadrature[0]
    draw_object(axes, patch.outline, facecolor="#f6f6f6", edgecolor=QUIET, zorder=1)
    tips = points + _POINT_ARROW * patch.force / np.hypot(*patch.force.T).max()
    for point, tip in zip(points, tips, strict=True):
        arrow(axes, point, tip, PREDICTED, 1.0, 6, mutation_scale=7.0)
    axes.plot(*points.T, ".", color=PREDICTED, markersize=3)
    pivot = MM * np.array([-patch.twist[1], patch.twist[0]]) / patch.twist[2]
    axes.plot(*pivot, "*", color=INK, markersize=10)
    axes.text(pivot[0], pivot[1] - 6.0, "centre of\nrotation", fontsize=8, ha="center", va="top")
    force, torque = float(np.hypot(*patch.wrench[:2])), 1e3 * patch.wrench[2]
    whole, contact = _WHOLE_ARROW / force, MM * patch.contact
    tail = contact - whole * patch.rod[:2]
    arrow(axes, np.zeros(2), whole * patch.wrench[:2], FORCE, 3.0, 6, mutation_scale=18.0)
    axes.plot(0.0, 0.0, "o", color=FORCE, markersize=5)
    arrow(axes, tail, contact, INK, 3.0, 6, mutation_scale=18.0)
    words = f"friction on the object: {force:.2f} N\nand {torque:.1f} N mm about its centre"
    axes.text(2.0, tail[1] + 8.0, words, color=FORCE, fontsize=8, va="top")
    axes.text(tail[0] - 3.0, tail[1] - 2.0, "rod", color=INK, ha="right", va="top")
    axes.set(xlim=(-58, 96), ylim=(-58, 96), aspect="equal")
    axes.set(xlabel="x (mm), object's frame", ylabel="y (mm)")
    entitle(axes, "Patch of 8 x 8 points")


def _centre(law: EllipseFriction) -> Array:
    return turned(np.array([law.m0, law.n0]), law.phi)


def _traction_axes(axes: Axes, title: str, middle: Array) -> None:
    show_window(axes, middle - _REACH, middle + _REACH)
    axes.set(
        aspect="equal", xlabel="traction coefficient along x", ylabel="traction coefficient along y"
    )
    entitle(axes, title)


def limit_caption(result: LimitEllipseAndPatch) -> str:
    """What the law says, how far scans and their fit lie from Table I, and what the patch adds up
    to.
    """
    patch, lean = result.patch, math.degrees(lean_of(SKETCHED, DIRECTION))
    law, fitted = result.table, result.fitted
    surface = f"{NO_DATA.capitalize()} of friction scans (record_surface=plywood_shape=rect1_...)."
    if result.scans is not None and fitted is not None:
        apart = float(np.hypot(*(limit_curve(fitted) - limit_curve(law)).T).max())
        surface = (
            f"Dots: {len(result.scans)} friction scans; dashed: the ellipse fitted to them, axes "
            f"{fitted.mu_a:.4f} and {fitted.mu_b:.4f}, at most {apart:.4f} from Table I."
        )
    return (
        "Left: the traction of a sliding point is the point of its limit ellipse where the outward "
        "normal is the direction of sliding (maximum dissipation); here the two differ by "
        f"{lean:.0f}°. Axes differ more, and the offset is larger, than on plywood, to be seen. "
        f"Middle: the limit ellipse of plywood in Table I, axes {law.mu_a:g} and {law.mu_b:g}, its "
        f"centre {math.hypot(law.m0, law.n0):.3f} off zero, beside the isotropic circle of the "
        f"same area. {surface} Right: the forces of the ground on the 8 x 8 points after "
        f"{100 * SHARE:.0f} % of the push from θ0 = 0 on plywood (Table I), and their resultant: "
        f"{np.hypot(*patch.wrench[:2]):.2f} N and {1e3 * patch.wrench[2]:.1f} N mm about the "
        f"centre, which balance the rod's {np.hypot(*patch.rod[:2]):.2f} N. Each point's force is "
        f"one {len(patch.force)}th of the weight times its traction; the object turns about the "
        "star."
    )


def lean_of(law: EllipseFriction, angle: float) -> float:
    """Return the angle (rad, positive) between the sliding velocity in direction `angle` and its
    traction.
    """
    traction = law.traction(np.array([math.cos(angle), math.sin(angle)]))
    return abs(math.remainder(math.atan2(traction[1], traction[0]) - angle, TWO_PI))


@dataclass(frozen=True, eq=False)
class PatchForces:
    """The forces on the patch during one push, in the object's frame.

    footprint : its points.
    twist : (3,) m, m, rad per metre of the rod's way.
    force : (k, 2) N, of the ground on the object at the points.
    wrench : (3,) N, N, N m, of the ground on the object about its centre; rod : of the rod on it.
    contact : (2,) m.
    outline : (5, 2) m, closed.
    """

    footprint: PointFootprint
    twist: Array
    force: Array
    wrench: Array
    rod: Array
    contact: Array
    outline: Array


def patch_forces(loop: CollectionLoop) -> PatchForces:
    """Return the forces on the 8 x 8 grid of `loop` during its push from θ0 = 0.

    The twist is the slope of the computed course, by central differences; that it balances the rod
    is not used.
    """
    footprint = grid_footprint(loop.slider.outline, GRID)
    gridded = replace(loop, footprint=footprint)
    course = gridded.model.push(
        gridded.start_pose(0.0), loop.push, loop.push.distance / _STEPS
    ).trajectory
    at = int(np.searchsorted(course.path, SHARE * course.path[-1]))
    pose = course.pose[at]
    slope = (course.pose[at + 1] - course.pose[at - 1]) / (
        course.path[at + 1] - course.path[at - 1]
    )
    twist = np.array([*turned(slope[:2], -pose[2]), slope[2]])
    points, weights = footprint.quadrature
    velocity = twist[:2] + twist[2] * np.stack([-points[:, 1], points[:, 0]], axis=-1)
    friction, load = loop.material.friction, gridded.model.weight
    force = -load * weights[:, None] * friction.traction(velocity, pose[2])
    wrench = np.array([*force.sum(axis=0), _torque(points, force).sum()])
    contact = turned(course.contact_point[at] - pose[:2], -pose[2])
    push = turned(course.contact_force[at], -pose[2])
    rod = np.array([*push, float(_torque(contact, push))])
    outline = loop.slider.outline.points(4)
    return PatchForces(footprint, twist, force, wrench, rod, contact, outline)


def _torque(lever: Array, force: Array) -> Array:
    return np.asarray(lever[..., 0] * force[..., 1] - lever[..., 1] * force[..., 0])


FOLDER = "mit_files"
# Most recorded pushes that are looked through for one that both sticks and slides.
MOST_FILES = 120
_SAMPLES = 240


@dataclass(frozen=True, eq=False)
class PredictedRatio:
    """travel (n,) m, of the rod; ratio (n,) tangential over normal force; sliding (n,); friction :
    of the rod.

    The tangent is a quarter turn counter-clockwise from the normal into the object.
    """

    travel: Array
    ratio: Array
    sliding: Mask
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
    sliding: Mask
    sticking: Mask
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


def force_ratio(measured: MeasuredFolder) -> ForceRatio:
    """Run the MIT push on plywood from θ0 = 0, and read the recorded push that sticks and slides
    most.
    """
    loop = CollectionLoop.mit("plywood")
    push = loop.model.push(loop.start_pose(0.0), loop.push, loop.push.distance / _SAMPLES)
    predicted = predicted_ratio(push.trajectory, loop.pusher.radius, loop.pusher.friction)
    return ForceRatio(predicted, recorded_ratio(measured))


def predicted_ratio(course: Trajectory, radius: float, friction: float) -> PredictedRatio:
    """Return the ratio along a push of a rod of `radius` (m) and friction
    coefficient `friction`."""
    normal = (course.contact_point - course.pusher) / radius
    tangent = np.stack([-normal[:, 1], normal[:, 0]], axis=-1)
    along, into = (np.sum(course.contact_force * way, axis=1) for way in (tangent, normal))
    sliding = np.char.startswith(course.mode, "slide")
    return PredictedRatio(course.path, along / into, sliding, friction)


def recorded_ratio(measured: MeasuredFolder) -> RecordedRatio | None:
    """Return the ratio of that recorded push of an MIT shape which has most samples of sticking and
    of sliding both.
    """
    home = measured.find(FOLDER)
    shapes = {}
    for path in [] if home is None else push_file_names(home):
        facts = push_facts(path)
        if facts is not None and facts.object in MIT_SHAPE_NAMES:
            shapes[path] = facts
    records, unreadable = readable_pushes(list(shapes)[:MOST_FILES])
    tried = []
    for path, record in records:
        outline = Slider.mit(str(shapes[path].object)).outline_points(360)
        forces = sliding_forces([(record, outline)])
        if forces.samples and forces.sticking:
            tried.append((forces, shapes[path], record, outline))
    if not tried:
        return None
    most = max(tried, key=lambda push: min(push[0].samples, push[0].sticking))
    forces, facts, record, outline = most
    samples = contact_samples(record, outline)
    kept = samples.touching & np.isfinite(samples.slip)
    slip = np.abs(samples.slip[kept])
    clock, x, y = record.tip_pose[:, :3].T
    travelled = np.cumsum(np.hypot(np.diff(x, prepend=x[0]), np.diff(y, prepend=y[0])))
    travel = np.interp(samples.time[kept], clock, travelled)
    ratio = samples.force[kept].imag / samples.force[kept].real
    name = f"{facts.object} on {facts.surface}, {MM * facts.speed:.0f} mm/s"
    sliding, sticking = slip > SLIDING, slip < STICKING
    return RecordedRatio(name, travel, ratio, sliding, sticking, forces, len(records), unreadable)


@picture_style()
def draw_ratio(result: ForceRatio) -> Figure:
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
    kinds: tuple[tuple[str, Mask, Look], ...] = (
        ("sliding", recorded.sliding, {"marker": "o", "markerfacecolor": "white"}),
        ("sticking", recorded.sticking, {"marker": "o"}),
        ("neither", unclear, {"marker": ".", "color": QUIET, "markeredgewidth": 0.0}),
    )
    for name, chosen, look in kinds:
        places = MM * recorded.travel[chosen], recorded.ratio[chosen]
        axes.plot(*places, label=name, **{**MARKS, **look})
    entitle(axes, f"Recorded, {recorded.name}")


def ratio_caption(result: ForceRatio) -> str:
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
    "limit-ellipse-and-patch": Exhibit(limit_ellipse_and_patch, limit_caption, draw_limits),
    "force-ratio": Exhibit(force_ratio, ratio_caption, draw_ratio),
}
