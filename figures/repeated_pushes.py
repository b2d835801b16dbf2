"""The paper's repeated pushes on four materials: what Ma & Rodriguez (2018) publish of them, those
that the user's folder holds, and simulated ones, sampled from maps of the cycle and of the push:
not 2000 full cycles.

The paper gives standard deviations and root mean square errors, and both as percentages of the
mean: the mean is one over the other. Percentages carry no sign. In this package's frame the object
moves along -y: the means of the published plywood, 69.1 deg, 36.6 mm and 94.3 mm, put the rod's
centre 48.9 mm from the middle of the pushed side, where it must be 49.75 mm, if the motion is
(+36.6, -94.3) mm, and nowhere near that side with any other signs or with x and y exchanged. So dx
is the published Δx, dy minus the published Δy. Orientations are those of this package: the measured
plywood staircase lingers near 95 deg, where the paper sees its high peak ("around 100 deg").
"""

from __future__ import annotations

import math
import os
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np
from matplotlib.figure import Figure

from cyclemap.arrays import TWO_PI, Array
from cyclemap.checks import positive_number, read_only, whole_number
from cyclemap.collection import CollectionLoop, worn_loop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import DataFileError, unknown_name
from cyclemap.evidence import (
    PushSet,
    Theta0Pairs,
    load_pushes,
    push_sets,
    read_theta0_pairs,
    set_laws,
)
from cyclemap.evidence.identification.force_blocks import SCAN_FIELDS
from cyclemap.evidence.laws.push_sets import FEWEST
from cyclemap.evidence.pushes.push_files import read_push_file
from cyclemap.evidence.pushes.recordings import PushRecord, push_facts, scan_facts
from cyclemap.evidence.tables.data_kinds import SUFFIXES
from cyclemap.maps import (
    CircleMap,
    DriftingMap,
    Staircase,
    WrappedNormal,
    sample_staircase,
    transfer_operator,
)
from cyclemap.views.panels.layout import Panel, grid_of, picture
from cyclemap.views.panels.orientation import CIRCLE, OUTCOMES
from cyclemap.views.panels.style import BARS, DOTS, QUIET, Look
from cyclemap.views.sentences import listed

from . import NO_DATA, THETA0_FILE, MeasuredFolder

if TYPE_CHECKING:
    import pandas


SOURCE = "Ma & Rodriguez 2018, Tables II and III and the text on stable directions"
PUBLISHED_CYCLES = 2000


@dataclass(frozen=True)
class PublishedStatistics:
    """What is published of one material, in the order dtheta (rad), dx, dy (m, initial object
    frame).

    mean, std : of the pushes.
    rmse : of them about the paper's fitted law of θ0; rmse_percent : as printed beside it, per cent
        of a mean that is up to 3 % off that of Table II.
    directions : rad, where the histogram of θ0 has the peaks that the text names, the one visited
        first in front.
    always_advancing : the text sees no stable direction.
    first_share : of the cycles, spent in the first direction, where the run starts there and leaves
        it for good.
    """

    material: str
    mean: tuple[float, ...]
    std: tuple[float, ...]
    rmse: tuple[float, ...]
    rmse_percent: tuple[float, ...]
    directions: tuple[float, ...]
    always_advancing: bool = False
    first_share: float | None = None


def published_statistics(material: str) -> PublishedStatistics:
    """Return what is published of `material`: plywood, abs, delrin or pu. Raises InvalidInput for
    another.

    >>> [round(1e3 * length, 1) for length in published_statistics("abs").mean[1:]]
    [40.1, -67.6]
    """
    if material not in PUBLISHED:
        raise unknown_name("material of Ma & Rodriguez (2018)", material, PUBLISHED)
    return PUBLISHED[material]


# As printed: standard deviations of Δθ (deg), Δx, Δy (mm), these in per cent of the means, errors
# of the fitted law, these in per cent, and directions (deg). abs is "stuck in one stable direction"
# for "about 150 times", then in a second for good; the first has the small peak.
_TABLES: dict[str, tuple[tuple[float, ...], ...]] = {
    "plywood": (
        (4.74, 2.84, 8.57),
        (6.86, 7.75, 9.09),
        (2.07, 0.91, 3.39),
        (2.99, 2.46, 3.66),
        (100.0, 280.0),
    ),
    "abs": (
        (3.21, 1.59, 5.31),
        (4.30, 3.97, 7.86),
        (2.99, 1.56, 3.21),
        (4.00, 3.88, 4.75),
        (-150.0, 150.0),
    ),
    "delrin": (
        (1.28, 0.97, 3.21),
        (1.63, 2.49, 6.33),
        (1.28, 0.81, 1.61),
        (1.63, 2.07, 3.08),
        (80.0,),
    ),
    "pu": ((4.53, 2.93, 11.39), (6.53, 7.30, 13.40), (1.14, 0.60, 1.56), (1.64, 1.49, 1.86), ()),
}
_SI = np.array([math.radians(1.0), 1e-3, 1e-3])
PUBLISHED = MappingProxyType(
    {
        name: PublishedStatistics(
            name,
            tuple((_SI * [1.0, 1.0, -1.0] * 100.0 * std / percent).tolist()),
            tuple((_SI * std).tolist()),
            tuple((_SI * rmse).tolist()),
            rmse_percent,
            tuple(np.radians(directions).tolist()),
            always_advancing=name == "pu",
            first_share=150.0 / PUBLISHED_CYCLES if name == "abs" else None,
        )
        for name, (std, percent, rmse, rmse_percent, directions) in _TABLES.items()
    }
)


# The paper's repeated pushes, as the names of the MIT files say it; SI units and radians.
OBJECT = "rect1"
PROTOCOL = {"acceleration": 0.0, "speed": 0.02, "side": 0.0, "fraction": 0.7, "angle": 0.0}
# The material whose θ0 are at hand in a file of their own.
THETA0_SURFACE = "plywood"


def recorded_set(measured: MeasuredFolder, surface: str) -> PushSet | None:
    """Return the set of ``surface`` with the most pushes in the folder, in the MIT layout; None
    where there is none.

    Looked for in all sub-folders by the names of the files,
    ``motion_surface=SURFACE_shape=rect1_..._rep=NNNN`` with the paper's protocol (``PROTOCOL``); at
    least 20 of them, in one folder, make a set.
    """
    if measured.path is None:
        return None
    pushes = _set_below(measured.path, surface)
    if pushes is not None:
        # One who watches the folder so knows what was used.
        measured.find(pushes.source.relative_to(measured.path).as_posix())
    return pushes


def measured_theta0(measured: MeasuredFolder, surface: str) -> Theta0Pairs | None:
    """Return the measured θ0 of ``surface`` in order: of its set, else for plywood of its own file;
    None without.
    """
    pushes = recorded_set(measured, surface)
    if pushes is not None and pushes.pairs is not None:
        return pushes.pairs
    file = measured.find(THETA0_FILE) if surface == THETA0_SURFACE else None
    return None if file is None else read_theta0_pairs(file)


def measured_scans(measured: MeasuredFolder, surface: str) -> pandas.DataFrame | None:
    """Return the friction scans of rect1 on ``surface`` as ``PushTable.scans`` has them; None where
    there are none.

    Of several folders that hold some, the one with the most; scans whose force could not be told
    are left out.
    """
    if measured.path is None:
        return None

    def is_wanted(name: str) -> bool:
        scan = scan_facts(name)
        return scan is not None and (scan.surface, scan.object) == (surface, OBJECT)

    for home, _ in folders_by_count(measured.path, is_wanted)[:1]:
        measured.find(home.relative_to(measured.path).as_posix())
        scans = load_pushes(home).scans
        wanted = scans[(scans["surface"] == surface) & (scans["object"] == OBJECT)]
        return wanted.dropna(subset=list(SCAN_FIELDS))
    return None


def folders_by_count(folder: Path, is_wanted: Callable[[str], bool]) -> list[tuple[Path, int]]:
    """Return the folders below one that hold files of wanted names, and how many, most first."""
    counts: Counter[Path] = Counter()
    for home, _, names in sorted(os.walk(folder)):
        counts[Path(home)] = sum(is_wanted(name) for name in names if name.endswith(SUFFIXES))
    return [(home, count) for home, count in counts.most_common() if count]


def not_found(what: str, surfaces: Iterable[str]) -> str:
    """Say that ``what`` was not found for these surfaces; empty where there are none.

    >>> not_found("pushes", ["abs", "pu"])
    'Recorded pushes on abs and pu: no measured data found.'
    """
    names = list(surfaces)
    return f"Recorded {what} on {listed(names)}: {NO_DATA}." if names else ""


@lru_cache(maxsize=32)
def _set_below(folder: Path, surface: str) -> PushSet | None:
    def is_wanted(name: str) -> bool:
        facts = push_facts(name)
        if facts is None or facts.repetition < 0:
            return False
        given = [getattr(facts, key) for key in PROTOCOL]
        is_own = np.allclose(given, list(PROTOCOL.values()), rtol=1e-6, atol=1e-9)
        return is_own and (facts.surface, facts.object) == (surface, OBJECT)

    for home, count in folders_by_count(folder, is_wanted):
        if count < FEWEST:
            return None
        sets = push_sets(load_pushes(home), {"surface": surface, "object": OBJECT, **PROTOCOL})
        best = max(sets, key=lambda pushes: pushes.count)
        if best.count >= FEWEST:
            return best
    return None


def push_file_names(folder: Path) -> list[Path]:
    """Return the files of a folder that are pushes by name and suffix, sorted; sub-folders are not
    entered.
    """
    return sorted(
        path
        for path in folder.iterdir()
        if path.suffix.lower() in SUFFIXES and push_facts(path) is not None
    )


def readable_pushes(files: Iterable[Path]) -> tuple[list[tuple[Path, PushRecord]], int]:
    """Return the pushes that can be read, each with its file, and how many cannot.

    >>> readable_pushes([Path("motion_surface=abs_shape=hex_a=0_v=20_i=0_s=0.7_t=0.h5")])
    ([], 1)
    """
    records = []
    unreadable = 0
    for path in files:
        try:
            record = read_push_file(path)
        except DataFileError:
            unreadable += 1
            continue
        assert isinstance(record, PushRecord)
        records.append((path, record))
    return records, unreadable


# The material that stands for each of the paper's: for plywood the one inferred from the measured
# staircase, since it alone wears and climbs as the robot saw it; Table I's plywood locks in and
# stays.
STANDS_FOR = {"plywood": "plywood-measured", "abs": "abs", "delrin": "delrin", "pu": "pu"}
NOISE = WrappedNormal(DEFAULT_SIGMA)
# Radians: accuracy of the cycle maps, far below the noise of a cycle.
MAP_TOLERANCE = 1e-4
# Of the integration of pushes and drags, relative: a hundredth of that.
_ACCURACY = 1e-6
# Orientations at which derivatives are computed: they only scale noise.
_SLOPES = 36
_OUTPUTS = ("push_turn", "push_dx", "push_dy", "theta_next")
_OFFSET = ("m0", "n0")
# Of each of the paper's materials, those that a table simulates: plywood by Table I, and as the
# staircase tells it.
SIMULATED = {
    surface: tuple(dict.fromkeys((surface, material))) for surface, material in STANDS_FOR.items()
}
# Names and units of Δθ, Δx and Δy in the paper's convention, and the factors from radians, m and
# this package's signs.
QUANTITIES = [
    (name, unit.strip(), sign * factor)
    for (name, _, factor, unit), sign in zip(OUTCOMES.values(), (1.0, 1.0, -1.0), strict=True)
]
# The laws of Δθ, Δx and Δy over θ0 of a set; one and the same set is fitted once.
fitted_laws = lru_cache(maxsize=32)(set_laws)


@dataclass(frozen=True)
class Sampling:
    """How long and how finely a run is sampled.

    pushes : in the run, 2 or more.
    states : of a wearing surface, 2 or more, between which maps are blended; with 5 the blend is
        within 0.07 degrees of the map of a cycle between them.
    tolerance : rad, of the cycle maps.
    """

    pushes: int = PUBLISHED_CYCLES
    states: int = 5
    tolerance: float = MAP_TOLERANCE

    def __post_init__(self) -> None:
        whole_number("pushes", self.pushes, least=2)
        whole_number("states", self.states, least=2)
        positive_number("tolerance", self.tolerance)


PAPER = Sampling()


@dataclass(frozen=True, eq=False)
class SurfaceState:
    """The cycle and the push on a surface as it is at one cycle.

    cycle : its number.
    map : the cycle map, rad.
    motion : of θ0 (n,), rad: (n, 3), Δθ (rad), Δx and Δy (m, initial object frame) of the push, the
        periodic cubic spline through pushes computed where the map had to be sampled.
    slopes : of θ0: (n, 4, 2), derivatives of Δθ, Δx, Δy and the next θ0 by the centre (m0, n0) of
        the limit ellipse, linear between 36 orientations.
    """

    cycle: float
    map: CircleMap
    motion: Callable[[Array], Array]
    slopes: Callable[[Array], Array]


@lru_cache(maxsize=32)
def surface_states(
    material: str, count: int, tolerance: float = MAP_TOLERANCE
) -> tuple[SurfaceState, ...]:
    """Compute the state of a built-in material, or `count` of one that wears, evenly over the
    cycles of its wear.

    Time: about 2 s each. Raises what the mechanics raise where they have no answer.

    >>> (state,) = surface_states("isotropic", 1, tolerance=1e-3)
    >>> np.degrees(state.motion(np.array([0.0, 1.0]))[:, 0]).round(3)
    array([74.52, 74.52])
    """
    from scipy.interpolate import BSpline, CubicSpline, make_interp_spline

    loop, states = CollectionLoop.mit(material), []
    wear = loop.material.wear
    for cycle in [0.0] if wear is None else np.linspace(0.0, wear.cycles, count).tolist():
        worn = replace(worn_loop(loop, cycle), accuracy=_ACCURACY)
        cycle_map = worn.circle_map(tolerance)
        assert cycle_map.pieces is not None
        theta = cycle_map.pieces.knots[:-1]
        runs = worn.cycles(theta)
        motion = np.column_stack([runs.push_turn, runs.push_displacement])
        spline = CubicSpline(
            np.append(theta, theta[0] + TWO_PI), np.vstack([motion, motion[:1]]), bc_type="periodic"
        )
        places, slopes = TWO_PI * np.arange(_SLOPES + 1) / _SLOPES, []
        for start in places[:-1].tolist():
            tangent = worn.sensitivity(start, _OFFSET)
            slopes.append(
                [[tangent.by(parameter, output) for parameter in _OFFSET] for output in _OUTPUTS]
            )
        linear = make_interp_spline(places, [*slopes, slopes[0]], k=1)
        states.append(
            SurfaceState(
                cycle, cycle_map, spline, BSpline(linear.t, linear.c, 1, extrapolate="periodic")
            )
        )
    return tuple(states)


@dataclass(frozen=True, eq=False)
class SampledRun:
    """A run of noisy cycles on one material, each push with its motion.

    surface, material : the paper's name, and that of what stands for it.
    states : one, or several of a surface that wears.
    map : of the cycle.
    run : the orientations, rad, lifted.
    pushes : the same as recorded pushes.
    jitter : (n, 2), by how much the centre (m0, n0) of each push's limit ellipse was off, over the
        mean coefficient.
    """

    surface: str
    material: str
    states: tuple[SurfaceState, ...]
    map: CircleMap | DriftingMap
    run: Staircase
    pushes: PushSet
    jitter: Array

    @property
    def published(self) -> PublishedStatistics:
        """What the paper says of this material."""
        return published_statistics(self.surface)

    @cached_property
    def density(self) -> tuple[Array, float]:
        """Stationary density (721,), per rad, of θ0 at `CIRCLE`, and a bound on its error; the mean
        over the wear.

        As if each state had been there for ever: a run of finite length need not have forgotten
        where it began.
        """
        weight = np.ones(len(self.states))
        if weight.size > 1:
            weight[[0, -1]] = 0.5
        weight /= weight.sum()
        operators = [transfer_operator(state.map, NOISE) for state in self.states]
        density = weight @ np.array([operator.density(CIRCLE) for operator in operators])
        return np.asarray(density), float(weight @ [operator.error_bound for operator in operators])


@lru_cache(maxsize=32)
def sampled_run(material: str, sampling: Sampling = PAPER) -> SampledRun:
    """Return a run of pushes on a built-in material, from the direction that the paper names first,
    else 0.

    θ_{n+1} = f_n(θ_n) + ξ_n, ξ_n normal with the scatter of measured plywood cycles, 1.1 degrees.
    The cause is taken to be friction that is not the same everywhere: in each push the centre of
    the limit ellipse is off by a random vector, equally likely in any direction and of the size at
    which the next θ0 scatters by just that much. The same vector moves Δθ, Δx and Δy, by their
    exact derivatives: their scatter is predicted from that of θ0.

    Where the material wears, cycle map and push are blended between states evenly spread over the
    cycles of its wear.

    >>> run = sampled_run("pu", Sampling(pushes=50, states=2, tolerance=1e-3))
    >>> run.pushes.count, len(run.states)
    (50, 1)
    """
    surface = material.split("-")[0]
    start = (*published_statistics(surface).directions, 0.0)[0]
    states = surface_states(material, sampling.states, sampling.tolerance)
    places = [state.cycle for state in states]
    cycle_map = (
        states[0].map
        if len(states) == 1
        else DriftingMap.between([(stage.cycle, stage.map) for stage in states])
    )
    run = sample_staircase(cycle_map, NOISE, sampling.pushes, start)
    theta, ahead, cycle = run.theta[:-1], run.theta[1:], np.arange(sampling.pushes + 1.0)
    # How much of each state the surface of each cycle has, linear between neighbours.
    share = np.array([np.interp(cycle[:-1], places, unit) for unit in np.eye(len(states))])

    def blended(values: Callable[[SurfaceState], Array]) -> Array:
        of_states = np.array([values(state) for state in states])
        return np.asarray(np.einsum("kn,kn...->n...", share, of_states))

    kick = ahead - blended(lambda state: state.map(theta))
    motion = blended(lambda state: state.motion(theta))
    slopes = blended(lambda state: state.slopes(theta))
    # Along the slope of the next θ0 an offset is kick / |slope|; across it, where it turns nothing,
    # as large: as complex numbers a quarter turn is the factor i.
    free = NOISE.sigma * np.random.default_rng((run.seed, 1)).standard_normal(kick.size)
    turned = (kick + 1j * free) / (slopes[:, -1] @ [1.0, -1j])
    offset = np.column_stack([turned.real, turned.imag])
    dtheta, dx, dy = (motion + np.einsum("nij,nj->ni", slopes[:, :-1], offset)).T
    pairs = Theta0Pairs(theta, ahead, run.theta, {}, cycle[:-1], cycle)
    facts, place = {"surface": material, "object": "rect1"}, Path(f"simulated {material}")
    pushes = PushSet(f"{material}, simulated", place, facts, 1, theta, dtheta, dx, dy, pairs)
    law = CollectionLoop.mit(material).material.friction
    jitter = read_only(offset / math.sqrt(law.mu_a * law.mu_b))
    return SampledRun(surface, material, states, cycle_map, run, pushes, jitter)


@dataclass(frozen=True, eq=False)
class MaterialPushes:
    """One of the paper's materials.

    published : what the paper prints.
    runs : simulated, of each material that stands for it.
    sets : of these and, last, the recorded one where it was found, each with the words for where it
        comes from.
    """

    published: PublishedStatistics
    runs: list[SampledRun]
    sets: list[tuple[str, PushSet]]


def material_pushes(measured: MeasuredFolder, sampling: Sampling = PAPER) -> list[MaterialPushes]:
    """Simulate pushes on every material and look for recorded ones, in the paper's order."""
    result = []
    for surface, materials in SIMULATED.items():
        runs = [sampled_run(material, sampling) for material in materials]
        sets = [(f"simulated, {run.material}", run.pushes) for run in runs]
        if (recorded := recorded_set(measured, surface)) is not None:
            sets.append(("recorded", recorded))
        result.append(MaterialPushes(published_statistics(surface), runs, sets))
    return result


PANEL_INCHES = (5.2, 3.7)
# What simulated pushes look like where the same is drawn of measured ones: grey.
_GREY: Look = {"label": "simulated", "color": QUIET, "markeredgecolor": QUIET}
SIMULATED_DOTS: Look = {**DOTS, **_GREY}
SIMULATED_BARS: Look = {
    **BARS,
    "label": "simulated",
    "facecolor": "#c4c4c4",
    "edgecolor": QUIET,
}


def draw_each(draw: Callable[..., None], result: Sequence[Any]) -> Figure:
    """A figure of a panel a material, each with its run."""
    return draw_materials([(panel.run.surface, partial(draw, panel=panel)) for panel in result])


def draw_materials(panels: Sequence[Panel]) -> Figure:
    """A figure of a few panels, a material each, with room above each for a legend."""
    layout = grid_of(len(panels), 2 if len(panels) <= 4 else 3)
    width, height = PANEL_INCHES
    rows = layout.split(";")
    return picture(layout, panels, size=(width * len(rows[0]), height * len(rows)), keys=2)
