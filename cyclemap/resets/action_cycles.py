"""Cycles of many actions on many materials: how far they turn the object over its orientation, and
what they cost.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from cyclemap.arrays import TWO_PI, Array, even_angles, placed
from cyclemap.checks import finite_array, require_room, whole_number
from cyclemap.collection.loop import CollectionLoop, require_loop, run_cycles
from cyclemap.collection.loop_surfaces import on_material
from cyclemap.errors import InvalidInput
from cyclemap.maps import CircleMap
from cyclemap.maps.lifts.circle_map import require_map
from cyclemap.mechanics import Material
from cyclemap.progress import Progress, part_of
from cyclemap.protocol.strategy import CycleAction, ResetStrategy, require_strategy

# Radians: of a single cycle. What lies between the samples is known to no better.
_ACCURACY = 1e-5
# Equally spaced orientations from which contact and room are looked at, and samples of a push over
# which the reach of the object is taken: some 8 mm of rod travel apart.
_CONTACT_STARTS = 12
_ROOM_STARTS = 8
_COURSE = 20
# How fast the robot works. Speed of the rod in contact, m/s; s a cycle for all else: into the ring,
# out of it, to the next push; s more in a cycle in which a gripper turns the object.
ROD_SPEED = 0.020
HANDLING = 10.0
GRIPPING = 10.0


@dataclass(frozen=True, eq=False)
class SampledTurns:
    """Turns of cycles on equal steps of the orientation.

    Attributes
    ----------
    turn : ndarray, shape (materials, actions, samples)
        theta_next - theta on the lift, rad, a gripper's turn included.
    drag_length : ndarray, shape (materials, actions)
        Mean over the samples, m.
    """

    turn: Array
    drag_length: Array

    @property
    def steepest(self) -> Array:
        """The largest slope of the turn, (actions,), over all materials, between neighbouring
        samples.
        """
        steps = np.abs(np.diff(self.turn, append=self.turn[..., :1])) * (
            self.turn.shape[-1] / TWO_PI
        )
        return np.asarray(steps.max(axis=(0, 2)))

    def refined(self, samples: int) -> Array:
        """Return the turns at `samples` orientations (materials, actions, samples), by a periodic
        cubic spline.
        """
        from scipy.interpolate import CubicSpline

        around = np.concatenate([self.turn, self.turn[..., :1]], axis=-1)
        places = np.linspace(0.0, TWO_PI, around.shape[-1])
        at = even_angles(samples)
        return np.asarray(CubicSpline(places, around, axis=-1, bc_type="periodic")(at))


def sample_turns(
    loop: CollectionLoop,
    actions: Sequence[CycleAction],
    materials: Sequence[Material],
    samples: int = 36,
) -> SampledTurns:
    """Return the turns of one cycle of every action on every material from equally spaced
    orientations.

    Parameters
    ----------
    loop : CollectionLoop
        Prepared by the strategy (its ring's place).
    actions : sequence of CycleAction
        Those whose cycles are run; such as differ in a gripper's turn alone are run once.
    materials : sequence of Material
        The surfaces.
    samples : int, default 36
        How many orientations.

    Returns
    -------
    SampledTurns
        Turns (materials, actions, samples), rad, and mean drags.

    Raises
    ------
    CycleMapError
        What a cycle raises that leads out of the mechanics.

    Notes
    -----
    About 0.3 ms a cycle and core.

    Examples
    --------
    >>> import numpy as np
    >>> from cyclemap import CollectionLoop, load_material
    >>> from cyclemap.resets import CycleAction, sample_turns
    >>> loop, actions = CollectionLoop.mit(), [CycleAction(), CycleAction(turn=1.0)]
    >>> found = sample_turns(loop, actions, [load_material("plywood")], 4)
    >>> np.degrees(found.turn[0, 0]).round(2).tolist()
    [9.97, -2.88, -9.77, 22.9]
    >>> (found.turn[0, 1] - found.turn[0, 0]).round(9).tolist()
    [1.0, 1.0, 1.0, 1.0]
    """
    theta = even_angles(whole_number("samples", samples, least=3))
    gripped = np.array([action.turn for action in actions])
    still = [replace(action, turn=0.0) for action in actions]
    distinct = [*dict.fromkeys(still)]
    surfaces = [on_material(_roughly(loop), material) for material in materials]
    run = run_cycles([action.on(surface) for surface in surfaces for action in distinct], theta)
    shape = (len(materials), len(distinct), len(theta))
    places = [distinct.index(action) for action in still]
    turn = (run.theta_next - run.theta).reshape(shape)[:, places] + gripped[:, None]
    return SampledTurns(turn, run.drag_length.reshape(shape).mean(axis=-1)[:, places])


def _roughly(loop: CollectionLoop) -> CollectionLoop:
    return replace(loop, accuracy=max(loop.accuracy, _ACCURACY))


def strategy_maps(
    loop: CollectionLoop,
    strategy: ResetStrategy,
    *,
    tolerance: float = 1e-4,
    progress: Progress | None = None,
) -> tuple[CircleMap, ...]:
    """Return the cycle map of each of a strategy's actions, its gripper's turn included.

    Parameters
    ----------
    loop : CollectionLoop
        The loop that the strategy is run on.
    strategy : ResetStrategy
        Whose actions.
    tolerance : float, default 1e-4
        Error of each map, rad, wherever it does not jump (see `CollectionLoop.circle_map`).
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    tuple of CircleMap
        One an action.

    Notes
    -----
    Wear is left out.

    Examples
    --------
    >>> import math
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import CycleAction, ResetStrategy, strategy_maps
    >>> quarters = ResetStrategy((CycleAction(), CycleAction(turn=math.pi / 2.0)))
    >>> first, second = strategy_maps(CollectionLoop.mit(), quarters, tolerance=1e-2)
    >>> round(float(second(1.0) - first(1.0)), 9) == round(math.pi / 2.0, 9)
    True
    """
    require_loop(loop)
    require_strategy(strategy)
    computed: dict[CollectionLoop, CircleMap] = {}
    maps = list[CircleMap]()
    for acted, action in zip(strategy.loops(loop), strategy.actions, strict=True):
        if acted not in computed:
            computed[acted] = acted.circle_map(tolerance)
        made = computed[acted]
        if action.turn != 0.0 and made.pieces is not None:
            raised = made.pieces.shifted(0.0, action.turn)
            made = CircleMap.from_pieces(raised, made.breaks, made.samples, made.max_error)
        maps.append(made)
        part_of(progress, len(maps), len(strategy.actions))(0.0)
    return tuple(maps)


def map_turns(maps: Sequence[CircleMap], samples: int = 1024) -> Array:
    """Return the turns of cycle maps at equal steps of the orientation.

    Parameters
    ----------
    maps : sequence of CircleMap
        The maps, one an action.
    samples : int, default 1024
        How many orientations, from 0.

    Returns
    -------
    ndarray, shape (maps, samples)
        f(θ) - θ, rad.

    Examples
    --------
    >>> from cyclemap import CircleMap
    >>> from cyclemap.resets import map_turns
    >>> map_turns([CircleMap.rigid(0.25)], samples=3).round(4).tolist()
    [[1.5708, 1.5708, 1.5708]]
    """
    count = whole_number("samples", samples, least=1)
    try:
        each = tuple(maps)
    except TypeError as cause:
        raise InvalidInput(f"maps is {maps!r}: give a sequence of CircleMaps") from cause
    for cycle_map in each:
        require_map(cycle_map)
    require_room("the turns", len(each) * count, "give fewer samples")
    theta = even_angles(count)
    return np.array([np.asarray(cycle_map(theta)) - theta for cycle_map in each])


def checked_turns(turn: ArrayLike, actions: int | None = None) -> Array:
    """Return turns of actions at equal steps, (actions, n), or raise InvalidInput; `actions`: how
    many there are, None for any number.

    >>> checked_turns([[0.1, 0.2]], 1).shape
    (1, 2)
    """
    checked = finite_array("turn", turn, ndim=2)
    if checked.size == 0:
        raise InvalidInput(f"turn has shape {checked.shape}: give a row an action, of some steps")
    if actions is not None and len(checked) != actions:
        raise InvalidInput(f"turn has {len(checked)} rows for {actions} actions: give one each")
    return checked


def seconds(travel: Array, turned: Array) -> Array:
    """Return the time (s) of cycles whose push and drag are `travel` (m) long, a gripper in the
    share `turned` of them.

    >>> seconds(np.array([0.25, 0.25]), np.array([0.0, 1.0])).tolist()
    [22.5, 32.5]
    """
    return travel / ROD_SPEED + HANDLING + GRIPPING * turned


def contact_lengths(loop: CollectionLoop, actions: Sequence[CycleAction]) -> Array:
    """Return how far (m) the rod goes in contact at least, in the push of each action, over twelve
    orientations.

    >>> contact_lengths(CollectionLoop.mit(), [CycleAction()]).round(3).tolist()
    [0.132]
    """
    rough = _roughly(loop)
    poses = [rough.start_pose(theta) for theta in even_angles(_CONTACT_STARTS).tolist()]
    lengths = {}
    for push in {action.push or loop.push for action in actions}:
        lengths[push] = min(rough.model.push(pose, push).travel for pose in poses)
    return np.array([lengths[action.push or loop.push] for action in actions])


def room_needed(loop: CollectionLoop, action: CycleAction) -> float:
    """Return the largest distance (m) from the target of any point of rod and object, over eight
    orientations.

    The rod goes to the end of its push, whether or not it has lost the object by then. The object's
    reach is that at samples some 8 mm of rod travel apart.

    >>> round(room_needed(CollectionLoop.mit(), CycleAction()), 3)
    0.186
    """
    acted = action.on(_roughly(loop))
    step = acted.push.distance / _COURSE
    outline = loop.slider.outline_points()
    reaches = []
    for theta in even_angles(_ROOM_STARTS).tolist():
        push, drag = acted.strokes(theta, step if not action.way_points else step / 2.0)
        course = push.trajectory
        first = course.pusher[0]
        way = course.pusher[-1] - first
        end = first + acted.push.distance * way / math.hypot(*way)
        for place in (first, end, *acted.reset.way_points):
            reaches.append(math.hypot(*place) + loop.pusher.radius)
        for stroke in [course, drag.trajectory] if acted.reset.way_points else [course]:
            places = placed(stroke.pose.T[..., None], outline)
            reaches.append(float(np.hypot(*places.T).max()))
    return max(reaches)
