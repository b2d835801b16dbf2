"""Does a simulator, or a robot, push alike in all directions? The answer, the friction ellipse that
does the same, and the lock-in that it would cause.

The same push is made from orientations all around. Were friction the same in every direction, the
object's motion in its own frame would not depend on the orientation: what depends on it is
anisotropy of the surface, or of the solver.
"""

from __future__ import annotations

import json
import math
import subprocess
import weakref
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike
from scipy import optimize, stats

from cyclemap.arrays import TWO_PI, Array, Place, even_angles
from cyclemap.checks import finite_array, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_surfaces import Anisotropy
from cyclemap.errors import ConvergenceError, CycleMapError, InvalidInput
from cyclemap.evidence.laws.linear_fit import (
    LinearFit,
    fit_linear,
    fourier_columns,
    student_quantile,
)
from cyclemap.maps import fixed_points
from cyclemap.mechanics import Material, Pose
from cyclemap.mechanics.contact_curve import first_contact

Push = Callable[[float], Sequence[float]]
EndPose = Callable[[float, Place, Place], Sequence[float]]

PUSHES = 72
FEWEST = 12
# What chance alone passes for anisotropy once in a thousand probes is not called anisotropy.
ALARM_RATE = 1e-3
CONFIDENCE = 0.95
MOST_HARMONICS = 4
OUTCOMES = ("dx", "dy", "dtheta")
# Of what a solver leaves in a motion that is the same from all orientations: m and rad of a
# rounding error.
_ROUNDING = 1e-9
# A map is asked for where it locks; no finer than intervals of probes are.
_TOLERANCE = 1e-4
_AROUND = np.linspace(0.0, TWO_PI, 721)
# Of the numbers of an ellipse, for differences.
_STEP = 1e-3


@dataclass(frozen=True)
class Harmonic:
    """How much of an outcome goes with `order` times the orientation, with its 95 % interval (m,
    rad).
    """

    outcome: str
    order: int
    amplitude: float
    lower: float
    upper: float


@dataclass(frozen=True)
class Interval:
    """A number and its 95 % interval."""

    value: float
    lower: float
    upper: float


@dataclass(frozen=True, eq=False)
class Probe:
    """What a set of pushes from all around tells.

    Attributes
    ----------
    loop : CollectionLoop
        The loop whose push was probed.
    theta : ndarray, shape (n,)
        Orientations before the pushes, rad.
    change : ndarray, shape (n, 3)
        Dx, dy (m, in the object's frame before the push), dtheta (rad).
    harmonics : tuple of Harmonic
        Of each outcome over the orientation.
    p_value : float
        Of pushes that are alike in all directions but for noise.
    noise : ndarray, shape (3,)
        Standard deviation of what no harmonic explains.
    anisotropy : Anisotropy
        Of the friction ellipse under `loop` that mimics them.
    ratio : Interval
        Its axes' ratio, 1 or more.
    offset : Interval
        Its centre over the mean radius.
    explained : float
        Share of the pushes' dependence on orientation that it accounts for.
    covariance : ndarray, shape (4, 4)
        Of the ellipse's numbers, as `Anisotropy.of_components` takes them.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import probe
    >>> loop = CollectionLoop.mit("isotropic", accuracy=1e-6)
    >>> def alike(theta):
    ...     cycle = loop.cycle(theta)
    ...     return (*cycle.push_displacement, cycle.push_turn)
    >>> probe(alike, loop, 24).found
    False
    """

    loop: CollectionLoop
    theta: Array
    change: Array
    harmonics: tuple[Harmonic, ...]
    p_value: float
    noise: Array
    anisotropy: Anisotropy
    ratio: Interval = field(metadata={"name": "axis_ratio"})
    offset: Interval
    explained: float
    covariance: Array

    @property
    def found(self) -> bool:
        """Whether pushes depend on their direction, by more than chance in one of a thousand
        probes.
        """
        return self.p_value < ALARM_RATE

    @cached_property
    def mimic(self) -> CollectionLoop:
        """The loop on the friction ellipse that mimics what was probed."""
        return _on_ellipse(self.loop, self.anisotropy)

    @cached_property
    def stable(self) -> tuple[Interval, ...]:
        """Orientations (rad) in which a collection on that ellipse would lock, each with what noise
        leaves open, to first order; none where it would not.
        """
        stable = []
        for orbit in fixed_points(self.mimic.circle_map(_TOLERANCE)):
            if orbit.stable:
                theta = orbit.points[0]
                reach = self._turn_reach(theta) / (1.0 - orbit.multiplier)
                stable.append(Interval(theta, theta - reach, theta + reach))
        return tuple(stable)

    def _turn_reach(self, theta: float) -> float:
        """Half of the 95 % interval, rad, of the turn of a cycle from orientation `theta`, rad, on
        that ellipse.
        """
        values = self.anisotropy.seen_from(0.0)
        place = np.array([theta])
        slopes = []
        for step in _STEP * np.eye(4):
            ends = [
                _on_ellipse(self.loop, Anisotropy.of_components(moved)).next_theta(place)[0]
                for moved in (values + step, values - step)
            ]
            slopes.append((ends[0] - ends[1]) / (2.0 * _STEP))
        variance = float(np.array(slopes) @ self.covariance @ slopes)
        return student_quantile(CONFIDENCE, _freedom(self.theta.size)) * math.sqrt(variance)

    @cached_property
    def turns(self) -> tuple[float, float]:
        """Least and greatest turn of a cycle on that ellipse, rad."""
        turned = self._turned
        return float(turned.min()), float(turned.max())

    @cached_property
    def slowest(self) -> Interval:
        """The turn of a cycle on that ellipse (rad) where it is nearest to none, with what noise
        leaves open, to first order.
        """
        place = int(np.argmin(np.abs(self._turned)))
        turn = float(self._turned[place])
        reach = self._turn_reach(float(_AROUND[::4][place]))
        return Interval(turn, turn - reach, turn + reach)

    @cached_property
    def _turned(self) -> Array:
        return self.mimic.next_theta(_AROUND[::4]) - _AROUND[::4]


def probe(push: Push, loop: CollectionLoop, count: int = PUSHES) -> Probe:
    """Push from orientations spread evenly and look at what comes back.

    Parameters
    ----------
    push : callable
        Gives (dx, dy, dtheta) of one push from orientation theta (rad): m in the object's frame
        before it, rad. It has to be the push of `loop`, on whatever surface it has.
    loop : CollectionLoop
        Whose push it is.
    count : int, optional
        How many pushes.

    Returns
    -------
    Probe
        Whether pushes depend on their direction, and the ellipse that mimics them; see
        `probe_pushes`.

    Notes
    -----
    Of harmonics of the orientation no choice of pushes tells more than those spread evenly (Dette
    et al. 2017): it is what the criterion of `plan_pushes` comes to where nothing is believed
    before.

    References
    ----------
    Dette, H., Konstantinou, M., Schorning, K. & Gösmann, J. (2017), Optimal designs for regression
    with spherical data, arXiv:1710.10526.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import probe
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> def plywood(theta):
    ...     cycle = loop.cycle(theta)
    ...     return (*cycle.push_displacement, cycle.push_turn)
    >>> found = probe(plywood, CollectionLoop.mit("isotropic", accuracy=1e-6), 24)
    >>> found.found, round(found.ratio.value, 3)
    (True, 1.085)
    """
    size = whole_number("pushes of a probe", count, least=FEWEST)
    theta = even_angles(size)
    changes = []
    for angle in theta.tolist():
        given = push(angle)
        try:
            changes.append(finite_array("a pose change", given, last=3, ndim=1))
        except InvalidInput as error:
            raise InvalidInput(
                f"from theta = {angle:.4g} rad: {error}; give (dx, dy, dtheta) in m and rad"
            ) from error
    return probe_pushes(theta, np.array(changes), loop)


def probe_pushes(theta: ArrayLike, change: ArrayLike, loop: CollectionLoop) -> Probe:
    """Look at pushes that were made from all around.

    Parameters
    ----------
    theta : array_like, shape (n,)
        Orientations before the pushes, rad; 12 at least, and no gaps of a quarter turn.
    change : array_like, shape (n, 3)
        How each moved the object: dx, dy (m, in the object's frame before the push), dtheta
        (rad).
    loop : CollectionLoop
        Whose push it is.

    Returns
    -------
    Probe
        Whether pushes depend on their direction, and the ellipse that mimics them.

    Raises
    ------
    InvalidInput
        For fewer than 12 pushes, or ones that leave gaps of a quarter turn.

    Notes
    -----
    Each outcome is fitted by harmonics of the orientation up to the fourth (as the pushes
    allow), and the ellipse by least squares of the loop's own pushes, its mean motion left
    free; outcomes are weighted by the scatter that the harmonics leave. Intervals take noise as
    normal and independent from push to push; of 2000 sets of 12 to 36 made pushes they held the
    truth in 94 to 96 %, also with Student's noise of three degrees of freedom.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import probe_pushes
    >>> loop = CollectionLoop.mit("plywood", accuracy=1e-6)
    >>> theta = np.linspace(0.0, 6.0, 24)
    >>> cycles = loop.cycles(theta)
    >>> change = np.column_stack([cycles.push_displacement, cycles.push_turn])
    >>> found = probe_pushes(theta, change, CollectionLoop.mit("isotropic", accuracy=1e-6))
    >>> found.found, round(found.ratio.value, 2)
    (True, 1.08)
    """
    angles = finite_array("theta", theta, ndim=1)
    moved = finite_array("change", change, last=3, ndim=2)
    if angles.size < FEWEST or len(moved) != angles.size:
        raise InvalidInput(
            f"{angles.size} orientations and {len(moved)} changes: give {FEWEST} or more, as many "
            "of both"
        )
    gaps = np.diff(np.sort(np.mod(angles, TWO_PI)))
    if max(float(gaps.max(initial=0.0)), TWO_PI - float(gaps.sum())) > 0.5 * math.pi:
        raise InvalidInput(
            "the orientations leave a gap of more than a quarter turn: push from all around"
        )
    order = _order(angles.size)
    design = fourier_columns(angles, order)
    fits = [fit_linear(design, column) for column in moved.T]
    noise = np.array([max(fit.sigma, _ROUNDING) for fit in fits])
    values, covariance, explained = _ellipse(angles, moved, noise, loop)
    free = _freedom(angles.size)
    offset = _length(values[:2], covariance[:2, :2], free)
    # The logarithm of the axes' ratio is twice the length of the second harmonic's vector.
    ratio = [math.exp(2.0 * length) for length in _length(values[2:], covariance[2:, 2:], free)]
    return Probe(
        loop,
        angles,
        moved,
        _harmonics(fits, order),
        _p_value(moved, fits, noise, order),
        noise,
        Anisotropy.of_components(values),
        Interval(*ratio),
        Interval(*offset),
        explained,
        covariance,
    )


def _order(count: int) -> int:
    """How many harmonics of the orientation so many pushes allow."""
    return min(MOST_HARMONICS, (count - 4) // 4)


def _freedom(count: int) -> int:
    """Degrees of freedom of the ellipse's intervals by so many pushes: those of the scatter by
    which an outcome is weighted, since one outcome tells nearly all.
    """
    return count - 2 * _order(count) - 1


def _harmonics(fits: Sequence[LinearFit], order: int) -> tuple[Harmonic, ...]:
    """Those of each outcome, up to an order."""
    harmonics = []
    for name, fit in zip(OUTCOMES, fits, strict=True):
        free = fit.residuals.size - fit.coefficients.size
        for degree in range(1, order + 1):
            rows = slice(2 * degree - 1, 2 * degree + 1)
            length = _length(fit.coefficients[rows], fit.covariance[rows, rows], free)
            harmonics.append(Harmonic(name, degree, *length))
    return tuple(harmonics)


def _length(vector: Array, covariance: Array, free: int) -> tuple[float, float, float]:
    """The length of a vector (2,), and those of the shortest and longest in its 95 % confidence
    ellipse.
    """
    values, axes = np.linalg.eigh(covariance)
    reach = math.sqrt(2.0 * stats.f.ppf(CONFIDENCE, 2, free))
    radii = reach * np.sqrt(np.maximum(values, 0.0))
    circle = np.column_stack([np.cos(_AROUND), np.sin(_AROUND)])
    lengths = np.hypot(*(vector + (radii * circle) @ axes.T).T)
    seen = axes.T @ vector
    inside = bool(np.sum((seen / np.maximum(radii, 1e-300)) ** 2) <= 1.0)
    return float(np.hypot(*vector)), 0.0 if inside else float(lengths.min()), float(lengths.max())


def _p_value(moved: Array, fits: Sequence[LinearFit], noise: Array, order: int) -> float:
    """Of no dependence on orientation: the likelihood ratio of Wilks, with Rao's F for three
    outcomes.
    """
    count = len(moved)
    extra = 2 * order
    centred = (moved - moved.mean(axis=0)) / noise
    left = np.stack([fit.residuals for fit in fits], axis=-1) / noise
    floor = (_ROUNDING / noise) ** 2 * count * np.eye(3)
    log_ratio = (
        np.linalg.slogdet(left.T @ left + floor)[1]
        - np.linalg.slogdet(centred.T @ centred + floor)[1]
    )
    s = math.sqrt((9.0 * extra**2 - 4.0) / (extra**2 + 4.0))
    first = 3.0 * extra
    second = (count - 3.0 - 0.5 * extra) * s - 1.5 * extra + 1.0
    root = math.exp(log_ratio / s)
    return float(stats.f.sf((1.0 - root) / max(root, 1e-300) * second / first, first, second))


def _ellipse(
    angles: Array, moved: Array, noise: Array, loop: CollectionLoop
) -> tuple[Array, Array, float]:
    """The four numbers of the ellipse (see `Anisotropy.of_components`), their covariance, and the
    share explained.
    """
    fine = replace(loop, accuracy=min(loop.accuracy, 1e-7))

    # SciPy takes steps relative to the unknowns: those of one and more do not vanish with them.
    def residuals(shifted: Array) -> Array:
        try:
            made = _on_ellipse(fine, Anisotropy.of_components(shifted - 1.0)).cycles(angles)
        except CycleMapError:
            return np.full(moved.size, 1e3)
        predicted = np.column_stack([made.push_displacement, made.push_turn])
        away = (moved - predicted) / noise
        return np.asarray((away - away.mean(axis=0)).ravel())

    fit = optimize.least_squares(
        residuals, np.ones(4), diff_step=1e-4, x_scale=0.02, method="lm", ftol=1e-6
    )
    if not fit.success:
        raise ConvergenceError(f"no friction ellipse could be fitted: {fit.message}")
    # What an ellipse cannot mimic counts as scatter of its own, so that its intervals do not forget
    # it.
    free = moved.size - 7
    left = float(fit.fun @ fit.fun)
    covariance = max(left / free, 1e-30) * np.linalg.inv(fit.jac.T @ fit.jac)
    total = float((((moved - moved.mean(axis=0)) / noise) ** 2).sum())
    return fit.x - 1.0, covariance, max(1.0 - left / max(total, 1e-300), 0.0)


def _on_ellipse(loop: CollectionLoop, anisotropy: Anisotropy) -> CollectionLoop:
    """The loop on a friction ellipse of its own mean radius."""
    law = loop.material.friction
    friction = anisotropy.friction(math.sqrt(law.mu_a * law.mu_b))
    return replace(loop, material=Material(f"{loop.material.name} (probed)", friction))


def simulated_push(loop: CollectionLoop, end_pose: EndPose) -> Push:
    """Return a loop's push as `probe` asks for it, from a simulator that moves a rod in the world.

    Parameters
    ----------
    loop : CollectionLoop
        Whose push it is.
    end_pose : callable
        Gives the object's pose (x, y, theta), m and rad, whole turns left out or not, after the
        rod has gone straight from one place to another (m), at which the object lay at the
        origin with orientation theta (rad): the rod first touches it where it starts. No push
        turns an object by half a turn.

    Returns
    -------
    callable
        theta (rad) -> (dx, dy, dtheta), m and rad.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import simulated_push
    >>> loop = CollectionLoop.mit()
    >>> push = simulated_push(loop, lambda theta, start, end: (*end, theta))
    >>> [round(part, 5) for part in push(0.3)]      # an object that goes to where the rod ends
    [-0.018, -0.10025, 0.0]
    """
    place, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    last = place + loop.push.distance * way

    def push(theta: float) -> tuple[float, float, float]:
        start = Pose(theta=theta)
        rod_start, rod_end = (start.to_world(*point.tolist()) for point in (place, last))
        x, y, turned = end_pose(theta, rod_start, rod_end)
        return (*start.to_object(x, y), math.remainder(turned - theta, TWO_PI))

    return push


def command_push(command: Sequence[str]) -> Push:
    """Return a push that a program makes: a line {"theta_deg": 30} in, a line {"dx_mm", "dy_mm",
    "dtheta_deg"} out.

    Parameters
    ----------
    command : sequence of str
        The program and its arguments; it is started once, and asked line by line.

    Returns
    -------
    callable
        theta (rad) -> (dx, dy, dtheta), m and rad.

    Raises
    ------
    InvalidInput
        Where it answers otherwise.

    Examples
    --------
    >>> import sys
    >>> from cyclemap.evidence import command_push
    >>> answer = "print('{\\"dx_mm\\": 40, \\"dy_mm\\": -70, \\"dtheta_deg\\": 75}', flush=True)"
    >>> push = command_push([sys.executable, "-c", f"import sys\\nfor line in sys.stdin: {answer}"])
    >>> [round(float(moved), 3) for moved in push(0.5)]
    [0.04, -0.07, 1.309]
    """
    try:
        process = subprocess.Popen(
            list(command), stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        )
    except OSError as error:
        raise InvalidInput(f"{' '.join(command)}: cannot be started ({error.strerror})") from error
    assert process.stdin is not None and process.stdout is not None
    reader = process.stdout
    writer = process.stdin

    def push(theta: float) -> tuple[float, float, float]:
        line = ""
        try:
            writer.write(json.dumps({"theta_deg": math.degrees(theta)}) + "\n")
            writer.flush()
            line = reader.readline()
            answered = json.loads(line)
            return (
                1e-3 * float(answered["dx_mm"]),
                1e-3 * float(answered["dy_mm"]),
                math.radians(float(answered["dtheta_deg"])),
            )
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise InvalidInput(
                f"{command[0]} answered {line.strip()[:200]!r}: for each line "
                '{"theta_deg": ...} a line {"dx_mm": ..., "dy_mm": ..., "dtheta_deg": ...} is '
                "wanted, written out at once"
            ) from error

    def close() -> None:
        process.terminate()
        with suppress(OSError):
            process.communicate()

    # The program ends with the last user of the function.
    weakref.finalize(push, close)
    return push
