"""How far a set-up is from losing or gaining a stable direction,
along every one of its settings."""

import math
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from cyclemap.arrays import TWO_PI, Array, even_angles, shorter_way
from cyclemap.collection.loop import CollectionLoop, require_loop
from cyclemap.collection.uncertain_directions import stable_points
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.maps import Bifurcation, BifurcationCurve, CircleMap, Estimate, follow_bifurcation
from cyclemap.mechanics.cycle_batch import run_batch
from cyclemap.progress import Progress, unheard
from cyclemap.protocol.settings import SETTINGS, Setting, loop_from_settings, setting_named
from cyclemap.written import DIRECTION

# Shares of the way to either end of a setting's usual range at which the stable directions are
# counted.
_WAY = (0.03125, 0.125, 0.25, 0.5, 0.75, 1.0)
# rad, of the cycles by which directions are counted; of those by which changes are solved for.
_COUNTED = 1e-6
_ACCURACY = 1e-10
# What those are off by, and their slopes; steps of the differences, of the range and rad.
_CYCLE_ERROR = 1e-9
_SLOPE_ERROR = 1e-6
_SETTING_STEP = 1e-5
_ANGLE_STEP = 1e-4
_ITERATIONS = 12
_NODES = 96
# What encloses a change is halved so often before a smooth one is sought, and where there is none.
_FIRST_HALVINGS = 4
_HALVINGS = 12
# Fine counts: error of the map, rad, and how often its cells are halved.
_FINE_ERROR = 1e-8
_FINE_HALVINGS = 16
# Directions beside a change are counted where the turn of a fold, rad, or else the slope is so far
# from what it is there.
_BESIDE = {"saddle-node": 1e-4, "period doubling": 2e-3}
# At most this share of what encloses it.
_HALF_WAY = 0.5
_STRAY = 8.0
Ends = tuple[float, float]
SMOOTH = {"saddle-node": 1.0, "period doubling": -1.0}


@dataclass(frozen=True)
class DirectionChange:
    """A value of a setting at which the number of stable directions changes.

    Attributes
    ----------
    value : Estimate
        Of the setting, SI units or rad, with the bound on its error.
    kind : str
        "saddle-node" (a stable direction and an unstable one merge), "period doubling" (it
        gives way to two that alternate) or "kink" (elsewise, at a kink or a jump of the map).
    theta : float
        Where, rad; nan at a kink.
    directions : int
        How many stable ones there are beyond it.

    Examples
    --------
    >>> from cyclemap.maps import Estimate
    >>> from cyclemap.sweeps import DirectionChange
    >>> change = DirectionChange(Estimate(-0.00627, 1e-9), "saddle-node", 2.6, 0)
    >>> change.kind, float(change.value)
    ('saddle-node', -0.00627)
    """

    value: Estimate
    kind: str
    theta: float = field(metadata=DIRECTION)
    directions: int


@dataclass(frozen=True)
class DirectionMargin:
    """How far one setting is from a change of the number of stable directions.

    Attributes
    ----------
    key : str
        The setting's name.
    value : float
        What the loop has, SI units or rad.
    directions : int
        How many stable ones it has.
    below, above : DirectionChange or None
        The nearest change on either side; None where there is none down to `low`, or up to
        `high`.
    low, high : float
        How far the loop can be run within the usual range, SI units or rad.
    span : float
        Length of the usual range, SI units or rad.

    Examples
    --------
    >>> from cyclemap.maps import Estimate
    >>> from cyclemap.sweeps import DirectionChange, DirectionMargin
    >>> change = DirectionChange(Estimate(-0.006, 1e-9), "saddle-node", 2.6, 0)
    >>> margin = DirectionMargin("hitch_x_mm", -0.0106, 1, None, change, -0.02, 0.0, 0.02)
    >>> margin.nearest is change, round(margin.share, 2)
    (True, 0.23)
    """

    key: str
    value: float
    directions: int
    below: DirectionChange | None
    above: DirectionChange | None
    low: float
    high: float
    span: float

    @property
    def nearest(self) -> DirectionChange | None:
        """The nearer of the two."""
        changes = [change for change in (self.below, self.above) if change is not None]
        return min(changes, key=lambda change: abs(change.value - self.value), default=None)

    @property
    def share(self) -> float:
        """The distance of the nearest change as a share of the usual range; inf where there is
        none.
        """
        return (
            math.inf if self.nearest is None else abs(self.nearest.value - self.value) / self.span
        )


def direction_margins(
    loop: CollectionLoop,
    keys: tuple[str, ...] | None = None,
    progress: Progress | None = None,
) -> tuple[DirectionMargin, ...]:
    """Return how far a loop is from losing or gaining a stable direction along each of its
    settings.

    Parameters
    ----------
    loop : CollectionLoop
        The set-up.
    keys : tuple of str or None, optional
        Settings, each alone being changed within its usual range; None: all that have one.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    tuple of DirectionMargin
        The nearest change first.

    Raises
    ------
    InvalidInput
        For an unknown key, or one without a usual range or a value here.

    Notes
    -----
    The stable directions are counted at 1/32, 1/8, 1/4, 1/2, 3/4 and all of the way to either end
    of the range; halving narrows the change between the first two that differ; near it f(θ) = θ
    with f'(θ) = 1, or -1, is solved for θ and the setting by Newton's method on cycles good to
    1e-10, and held only where the number changes across it; else halving encloses the change, on
    maps good to 1e-8 rad. So a direction that comes and goes between two of those values is missed,
    and jumps about which orbits gather do not count. Bounds are of first order in the errors of a
    cycle (1e-9 rad) and of its slope (1e-6), and of the difference steps; those of a "kink"
    enclose.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.sweeps import direction_margins
    >>> ring, rod = direction_margins(CollectionLoop.mit(), ("hitch_x_mm", "pusher_mu"))
    >>> ring.nearest.kind, ring.nearest.directions, round(1000 * ring.nearest.value, 4), rod.nearest
    ('saddle-node', 0, -6.2714, None)
    """
    require_loop(loop)
    report = progress or unheard
    known = [setting for setting in SETTINGS.values() if _value(setting, loop) is not None]
    chosen = known if keys is None else [setting_named(key) for key in keys]
    for setting in chosen:
        if setting not in known:
            raise InvalidInput(
                f"{setting.key} has no usual range or no value here: ask for some of "
                f"{', '.join(other.key for other in known)}"
            )
    count = len(stable_points([replace(loop, accuracy=_COUNTED)])[0])
    margins = []
    for place, setting in enumerate(chosen):
        value = _value(setting, loop)
        unit = float(setting.unit.in_si)
        assert value is not None
        with warnings.catch_warnings():
            # Of places of the ring that are only tried.
            warnings.simplefilter("ignore", DoubtfulInput)
            # A value beyond its usual range is the end of it.
            lowest = min(setting.low * unit, value)
            highest = max(setting.high * unit, value)
            below, low = _Way(loop, setting, value, lowest, count).nearest()
            above, high = _Way(loop, setting, value, highest, count).nearest()
        span = unit * (setting.high - setting.low)
        margins.append(DirectionMargin(setting.key, value, count, below, above, low, high, span))
        report((place + 1) / len(chosen))
    return tuple(sorted(margins, key=lambda margin: margin.share))


def _value(setting: Setting, loop: CollectionLoop) -> float | None:
    value = setting.of(loop) if setting.place and math.isfinite(setting.low) else None
    return value if isinstance(value, float) and setting.low < setting.high else None


@dataclass(frozen=True)
class _Way:
    """From the value that a loop has, with so many stable directions, to an end of the setting's
    range.
    """

    loop: CollectionLoop
    setting: Setting
    value: float
    end: float
    count: int

    def at(self, value: float) -> CollectionLoop:
        """The loop with the setting at a value, SI, for counting."""
        set_there = loop_from_settings(
            {self.setting.key: value / float(self.setting.unit.in_si)}, self.loop
        )
        return replace(set_there, accuracy=_COUNTED)

    def counted(self, value: float, is_fine: bool = False) -> int:
        """How many stable directions there are; fine counts are those of nearly exact maps."""
        loop = self.at(value)
        if not is_fine:
            return len(stable_points([loop])[0])
        exact = replace(loop, accuracy=_ACCURACY)
        points = stable_points([exact], map_error=_FINE_ERROR, halvings=_FINE_HALVINGS)
        return len(points[0])

    def nearest(self) -> tuple[DirectionChange | None, float]:
        """The nearest change, and how far it was looked for."""
        last = self.value
        for share in _WAY if self.end != self.value else ():
            value = self.value + share * (self.end - self.value)
            try:
                beyond = self.counted(value)
            except CycleMapError:  # the loop cannot be run there
                break
            if beyond != self.count:
                return self._between(last, value, beyond), value
            last = value
        return None, last

    def _between(self, near: float, far: float, beyond: int) -> DirectionChange:
        """The change of the number between two values."""
        change = self._smooth(*self._halved(near, far, beyond, _FIRST_HALVINGS))
        if change is not None:
            return change
        near, far, beyond = self._halved(near, far, beyond, _HALVINGS, is_fine=True)
        value = Estimate(0.5 * (near + far), 0.5 * abs(far - near))
        return DirectionChange(value, "kink", math.nan, beyond)

    def _halved(
        self, near: float, far: float, beyond: int, times: int, is_fine: bool = False
    ) -> tuple[float, float, int]:
        """The nearest change that halving finds, between two values, and the number beyond it."""
        for _ in range(times):
            middle = 0.5 * (near + far)
            count = self.counted(middle, is_fine)
            if count == self.count:
                near = middle
            else:
                far = middle
                beyond = count
        return near, far, beyond

    def _smooth(self, near: float, far: float, beyond: int) -> DirectionChange | None:
        """A smooth change between two values, or beside them where counts put it there."""
        rich = near if beyond < self.count else far
        width = abs(far - near)
        # Newton's method may stray farther than it may end.
        ends = (min(near, far) - _STRAY * width, max(near, far) + _STRAY * width)
        span = float(self.setting.unit.in_si) * (self.setting.high - self.setting.low)
        for theta, kind in self._starts(rich):
            solved = smooth_change(self.at, (theta, rich), SMOOTH[kind], _SETTING_STEP * span, ends)
            if solved is None or abs(solved.value - rich) > 2.0 * width:
                continue
            beside = min(solved.beside(kind), _HALF_WAY * width) * math.copysign(1.0, far - near)
            counts = [self.counted(solved.value + side * beside, True) for side in (-1.0, 1.0)]
            if counts[0] == self.count != counts[1]:
                return DirectionChange(solved.value, kind, solved.theta % TWO_PI, counts[1])
        return None

    def _starts(self, value: float) -> Iterator[tuple[float, str]]:
        """Angles of a map at which Newton's method begins, and the kind of change that it seeks:
        where the slope passes that of one.
        """
        theta = even_angles(_NODES)
        batch = run_batch((self.at(value),), theta[None], 1)
        slope = batch.jacobian[0, :, -1, 0]
        turn = np.abs(shorter_way(batch.theta_next[0] - theta))
        for kind, target in SMOOTH.items():
            passes = np.flatnonzero((slope - target) * (np.roll(slope, -1) - target) <= 0.0)
            yield from ((float(theta[at]), kind) for at in passes[np.argsort(turn[passes])])


@dataclass(frozen=True, eq=False)
class SmoothChange:
    """Where θ returns after a cycle with a given slope of the map.

    theta : rad.
    value : of what the loop varies with, with its bound.
    slopes : ((f' - 1, ∂f/∂value), (f'', ∂f'/∂value)) there.
    """

    theta: float
    value: Estimate
    slopes: Array

    def beside(self, kind: str) -> float:
        """How far from the value the directions that a change of a kind parts can be told apart."""
        (turning, by_value), (bend, twist) = self.slopes
        # The direction of a period doubling moves on with the value.
        rate = by_value if kind == "saddle-node" else twist - bend * by_value / turning
        return _BESIDE[kind] / max(abs(float(rate)), 1e-300)


def smooth_change(
    loop_at: Callable[[float], CollectionLoop],
    start: tuple[float, float],
    target: float,
    step: float,
    ends: Ends,
) -> SmoothChange | None:
    """Solve f(θ) = θ, f'(θ) = `target` for angle (rad) and value by Newton's method; None where it
    finds nothing between the ends of the value.

    step : of the value, of differences by it.
    """
    theta, value = start
    slack = 0.5 * (ends[1] - ends[0])
    for _ in range(_ITERATIONS):
        try:
            residual, slopes = _system(loop_at, theta, value, target, step)
        except CycleMapError:
            return None
        if not abs(np.linalg.det(slopes)) > 1e-12:
            return None
        moved = -np.linalg.solve(slopes, residual)
        theta += float(np.clip(moved[0], -0.3, 0.3))
        value += float(moved[1])
        if not ends[0] - slack <= value <= ends[1] + slack:
            return None
        if abs(moved[1]) < 1e-3 * step and abs(moved[0]) < 1e-6:
            break
    else:
        return None
    if not ends[0] <= value <= ends[1]:
        return None
    row = np.abs(np.linalg.inv(slopes)[1])
    off = np.abs(residual) + np.array([_CYCLE_ERROR, _SLOPE_ERROR])
    error = float(row @ off) + abs(float(moved[1]))
    return SmoothChange(theta, Estimate(value, error), slopes)


def _system(
    loop_at: Callable[[float], CollectionLoop],
    theta: float,
    value: float,
    target: float,
    step: float,
) -> tuple[Array, Array]:
    """(turn, slope - target), and the derivative by the angle and the value, by centred
    differences.
    """
    loops = [replace(loop_at(value + k * step), accuracy=_ACCURACY) for k in (-1, 0, 1)]
    angles = np.tile(theta + _ANGLE_STEP * np.arange(-1.0, 2.0), (3, 1))
    batch = run_batch(loops, angles, 1)
    slope = batch.jacobian[:, :, -1, 0]
    turn = float(shorter_way(batch.theta_next[1, 1] - theta))
    push = float(batch.theta_next[2, 1] - batch.theta_next[0, 1]) / (2.0 * step)
    bend = float(slope[1, 2] - slope[1, 0]) / (2.0 * _ANGLE_STEP)
    twist = float(slope[2, 1] - slope[0, 1]) / (2.0 * step)
    return np.array([turn, slope[1, 1] - target]), np.array(
        [[slope[1, 1] - 1.0, push], [bend, twist]]
    )


def change_curve(
    loop: CollectionLoop, key: str, change: DirectionChange, other: str, first: Ends, second: Ends
) -> BifurcationCurve:
    """Return the curve on which stable directions change in a plane of two settings.

    Parameters
    ----------
    loop : CollectionLoop
        The set-up.
    key : str
        The setting of a `DirectionMargin`.
    change : DirectionChange
        That margin's `below` or `above`, no kink: where the curve begins.
    other : str
        The second setting, at the loop's own value there.
    first, second : tuple[float, float]
        (low, high) of both, in the units of their keys.

    Returns
    -------
    BifurcationCurve
        In the units of the keys.

    Raises
    ------
    InvalidInput
        For a setting without a range or a value here, and for a change that is a kink.

    Notes
    -----
    See `cyclemap.maps.follow_bifurcation`. Every map is run cycle by cycle, so that a curve takes
    half a minute.

    Examples
    --------
    How far in the ring may lie on plywood before the stable direction is lost, for other rods; and
    what is refused:

    >>> import math
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.maps import Estimate
    >>> from cyclemap.sweeps import DirectionChange, change_curve, direction_margins
    >>> loop, plane = CollectionLoop.mit(), ((-12.0, -3.0), (0.12, 0.18))
    >>> (ring,) = direction_margins(loop, ("hitch_x_mm",))  # doctest: +SKIP
    >>> curve = change_curve(  # doctest: +SKIP
    ...     loop, "hitch_x_mm", ring.nearest, "pusher_mu", *plane
    ... )
    >>> curve.kind, curve.first.min().round(2), curve.first.max().round(2)  # doctest: +SKIP
    ('saddle-node', -6.5, -5.99)
    >>> kink = DirectionChange(Estimate(-0.006, 1e-9), "kink", math.nan, 0)
    >>> change_curve(loop, "hitch_x_mm", kink, "pusher_mu", *plane)
    Traceback (most recent call last):
        ...
    cyclemap.errors.InvalidInput: ...the change, a kink, must be smooth
    """
    settings = setting_named(key), setting_named(other)
    units = [float(setting.unit.in_si) for setting in settings]
    at = _value(settings[1], require_loop(loop))
    if at is None or change.kind not in SMOOTH:
        raise InvalidInput(
            f"{other} must be a setting with a range, and the change, a {change.kind}, must be "
            "smooth"
        )
    exact = replace(loop, accuracy=_ACCURACY)

    @lru_cache(maxsize=64)
    def family(value_of_key: float, value_of_other: float) -> CircleMap:
        member = loop_from_settings({key: value_of_key, other: value_of_other}, exact)

        def slopes(theta: Array) -> Array:
            batch = run_batch((member,), theta.reshape(1, -1), 1)
            return batch.jacobian[0, :, -1, 0].reshape(theta.shape)

        return CircleMap(member.next_theta, slopes, max_error=_CYCLE_ERROR)

    value = Estimate(change.value / units[0], change.value.error_bound / units[0])
    slope = SMOOTH[change.kind]
    turn = float(exact.next_theta(change.theta)) - change.theta
    kind = change.kind.replace(" ", "-")
    winding = round(turn / TWO_PI)
    start = Bifurcation(kind, value, np.array([change.theta]), 1, winding, slope, slope, False)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DoubtfulInput)
        return follow_bifurcation(family, start, at / units[1], first, second)
