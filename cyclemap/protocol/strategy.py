"""What the robot does in a cycle, and in which order it does one thing or another."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from cyclemap.arrays import TWO_PI, Array, Whole
from cyclemap.checks import finite_number, point, positive_number, whole_number
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import SidePush

Points = tuple[tuple[float, float], ...]

RANDOM = "random"
IN_TURN = "in turn"
SHUFFLED = "shuffled"
ORDERS = (RANDOM, IN_TURN, SHUFFLED)
GRIPPER = "gripper"
RING = "ring"
MOST_ACTIONS = 10_000
MOST_CYCLES = 10_000_000
# A share counts as a whole number of places in a block to within this.
_WHOLE = 1e-9


@dataclass(frozen=True)
class CycleAction:
    """One cycle as a strategy wants it; what is None is done as the loop does it.

    Parameters
    ----------
    way_points : tuple of tuple[float, float] or None, optional
        (x, y), m, from the target: where the drag goes before its last leg to the target; ():
        straight.
    push : SidePush or None, optional
        The push of this cycle.
    turn : float, default 0.0
        rad, counter-clockwise: a gripper turns the object about its ring after the drag. The
        ring stays at the target, so that the state before the next push is still the
        orientation alone.

    Raises
    ------
    InvalidInput
        For a value that is not finite, or a push that is not a `SidePush`.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import CycleAction
    >>> CycleAction(way_points=((0.05, 0.0),)).on(CollectionLoop.mit()).reset.way_points
    ((0.05, 0.0),)
    """

    way_points: Points | None = None
    push: SidePush | None = None
    turn: float = 0.0

    def __post_init__(self) -> None:
        if self.way_points is not None:
            places = tuple(point("way-point", place) for place in self.way_points)
            object.__setattr__(self, "way_points", places)
        if self.push is not None and not isinstance(self.push, SidePush):
            raise InvalidInput(
                f"the push of an action must be a SidePush or None, not {self.push!r}"
            )
        object.__setattr__(self, "turn", finite_number("gripper turn", self.turn))

    def on(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop with this action's push and way-points; the gripper's turn is no part of
        a loop.
        """
        reset = loop.reset
        if self.way_points is not None:
            reset = replace(reset, way_points=self.way_points)
        return replace(loop, push=self.push or loop.push, reset=reset)

    def filled(self, loop: CollectionLoop) -> CycleAction:
        """Return the same action with the loop's push and way-points where it has
        none of its own."""
        acted = self.on(loop)
        return CycleAction(acted.reset.way_points, acted.push, self.turn)


@dataclass(frozen=True)
class ResetStrategy:
    """A few actions, how often each comes, and in which order.

    Parameters
    ----------
    actions : tuple of CycleAction
        One or more.
    weights : tuple of float or None, optional
        Positive, one an action, scaled to shares that sum to one; None: all alike.
    order : str, optional
        ``random``: drawn anew before every push, so that orientations are a Markov chain. ``in
        turn``: as listed, again and again; all alike. ``shuffled``: blocks that hold every
        action as often as its share says, each block in an order of its own.
    block : int or None, optional
        Of ``shuffled``, how many pushes a block has; None: as few as the shares allow.
    hitch : tuple[float, float] or None, optional
        (x, y), m, object's frame: the ring's place for the whole collection; None: the loop's.

    Raises
    ------
    InvalidInput
        For anything else, naming it.

    Examples
    --------
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.resets import ResetStrategy
    >>> coin = ResetStrategy.pushes(CollectionLoop.mit().push, (1, 2))
    >>> coin.shares.tolist(), [action.push.side for action in coin.run(5, seed=1)]
    ([0.5, 0.5], [2, 2, 1, 2, 1])
    """

    actions: tuple[CycleAction, ...]
    weights: tuple[float, ...] | None = None
    order: str = RANDOM
    block: int | None = None
    hitch: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        given = tuple(self.actions) if isinstance(self.actions, Sequence) else ()
        if not given or not all(isinstance(action, CycleAction) for action in given):
            raise InvalidInput(
                f"a strategy is made of one CycleAction or more, not of {self.actions!r}"
            )
        if len(given) > MOST_ACTIONS:
            raise InvalidInput(f"{len(given)} actions are more than {MOST_ACTIONS}: give fewer")
        if self.order not in ORDERS:
            raise InvalidInput(f"order is {self.order!r}; it must be one of {', '.join(ORDERS)}")
        object.__setattr__(self, "actions", given)
        if self.weights is not None:
            weights = tuple(
                positive_number("weight of an action", weight) for weight in self.weights
            )
            if len(weights) != len(given):
                raise InvalidInput(f"{len(given)} actions need as many weights, not {len(weights)}")
            object.__setattr__(self, "weights", None if len(set(weights)) == 1 else weights)
        if self.order == IN_TURN and self.weights is not None:
            raise InvalidInput(
                "actions in turn are all alike: list one twice where it should come twice as often"
            )
        if self.hitch is not None:
            object.__setattr__(self, "hitch", point("hitch", self.hitch))
        self._check_block()

    @classmethod
    def pushes(cls, push: SidePush, sides: Sequence[int]) -> ResetStrategy:
        """Return the same push on several sides, each alike, drawn before every push.

        Parameters
        ----------
        push : SidePush
            The push.
        sides : sequence of int
            Numbers of the sides.

        Returns
        -------
        ResetStrategy
            One action a side.

        Examples
        --------
        >>> from cyclemap import SidePush
        >>> from cyclemap.resets import ResetStrategy
        >>> len(ResetStrategy.pushes(SidePush(), (0, 1, 2)).actions)
        3
        """
        return cls(tuple(CycleAction(push=replace(push, side=side)) for side in sides))

    @property
    def shares(self) -> Array:
        """How often each action comes, (k,), summing to one."""
        weights = np.ones(len(self.actions)) if self.weights is None else np.array(self.weights)
        # By the largest first: a sum of huge weights would overflow.
        weights = weights / weights.max()
        return np.asarray(weights / weights.sum())

    @cached_property
    def counts(self) -> tuple[int, ...]:
        """How often each action comes in a block: of ``shuffled``; else once each."""
        if self.order != SHUFFLED:
            return (1,) * len(self.actions)
        size = self.block or self._least_block()
        return tuple(round(share * size) for share in self.shares.tolist())

    @property
    def needs(self) -> tuple[str, ...]:
        """What it asks of the robot besides the same rod and ring: "gripper", "ring" (elsewhere),
        or nothing.
        """
        gripper = (GRIPPER,) if any(action.turn for action in self.actions) else ()
        return gripper if self.hitch is None else (*gripper, RING)

    def prepared(self, loop: CollectionLoop) -> CollectionLoop:
        """Return the loop as it is set up once, before the first cycle: its ring where the strategy
        wants it.
        """
        if self.hitch is None:
            return loop
        return replace(loop, slider=replace(loop.slider, hitch=self.hitch))

    def loops(self, loop: CollectionLoop) -> tuple[CollectionLoop, ...]:
        """Return the loop of each action, its gripper's turn left out."""
        prepared = self.prepared(loop)
        return tuple(action.on(prepared) for action in self.actions)

    def drawn(self, cycles: int, seed: int | np.random.SeedSequence = 0) -> Whole:
        """Return the number of the action of each cycle; the same for the same seed.

        Parameters
        ----------
        cycles : int
            How many cycles, at most ten million.
        seed : int or SeedSequence, default 0
            Of the draws.

        Returns
        -------
        ndarray of int, shape (cycles,)
            Numbers from 0.

        Raises
        ------
        InvalidInput
            For more than ten million cycles.
        """
        count = whole_number("cycles", cycles, least=0)
        if count > MOST_CYCLES:
            raise InvalidInput(
                f"{count} cycles are more than {MOST_CYCLES}: ask for fewer at a time"
            )
        if self.order == IN_TURN:
            return np.arange(count) % len(self.actions)
        random = np.random.default_rng(seed)
        if self.order == RANDOM:
            ends = np.cumsum(self.shares)[:-1]
            return np.searchsorted(ends, random.random(count), side="right")
        block = np.repeat(np.arange(len(self.actions)), self.counts)
        blocks = [random.permutation(block) for _ in range(-(-count // block.size))]
        return np.concatenate([np.empty(0, dtype=np.int64), *blocks])[:count]

    def run(self, cycles: int, seed: int = 0) -> tuple[CycleAction, ...]:
        """Return what the robot does in each of `cycles` cycles."""
        return tuple(self.actions[index] for index in self.drawn(cycles, seed).tolist())

    def _fits(self, size: int) -> bool:
        """Whether in so many pushes every action can come as often as its share says."""
        often = size * self.shares
        off = np.abs(often - np.round(often)).max()
        return bool(off <= _WHOLE * size and often.min() >= 0.5)

    def _least_block(self) -> int:
        """The least number of pushes that fits; 0 where none will do."""
        sizes = range(len(self.actions), MOST_ACTIONS + 1)
        return next(filter(self._fits, sizes), 0)

    def _check_block(self) -> None:
        if self.order != SHUFFLED:
            if self.block is not None:
                raise InvalidInput(
                    f"a block of {self.block} belongs to the order {SHUFFLED!r}, not to "
                    f"{self.order!r}"
                )
            return
        size = self._least_block()
        if self.block is not None:
            size = whole_number("block", self.block, least=1)
        if size > MOST_ACTIONS:
            raise InvalidInput(
                f"a block of {size} pushes is larger than {MOST_ACTIONS}: choose a smaller one"
            )
        if not size or not self._fits(size):
            shares = ", ".join(f"{share:.4g}" for share in self.shares)
            raise InvalidInput(
                f"no block of {size or MOST_ACTIONS} pushes gives shares {shares}: choose other "
                "weights"
            )


def one_loop(loop: CollectionLoop, strategy: ResetStrategy) -> CollectionLoop | None:
    """Return the loop that the strategy amounts to where every cycle is the same and needs no
    gripper; else None.

    >>> leg = ResetStrategy((CycleAction(((0.05, 0.0),)),))
    >>> one_loop(CollectionLoop.mit(), leg).reset.way_points
    ((0.05, 0.0),)
    """
    actions = set(strategy.actions)
    alike = len(actions) == 1 and not strategy.actions[0].turn
    return strategy.loops(loop)[0] if alike else None


def overruled_settings(strategy: ResetStrategy) -> tuple[str, ...]:
    """Return the --set keys that the strategy replaces in every cycle.

    >>> overruled_settings(ResetStrategy((CycleAction(()),)))
    ('way_points_mm',)
    """
    keys: list[str] = []
    if all(action.push is not None for action in strategy.actions):
        keys += ["side", "fraction", "angle_deg", "push_mm"]
    if all(action.way_points is not None for action in strategy.actions):
        keys.append("way_points_mm")
    if strategy.hitch is not None:
        keys += ["hitch_x_mm", "hitch_y_mm"]
    return tuple(keys)


def gripper_turns(count: int) -> tuple[CycleAction, ...]:
    """Return the loop's own cycle followed by each of some equal turns of a gripper.

    Parameters
    ----------
    count : int
        How many turns, the first of them none.

    Returns
    -------
    tuple of CycleAction
        One a turn: 0, 2π/count, ... rad.

    Raises
    ------
    InvalidInput
        For a count that is no whole number from 1.

    Examples
    --------
    >>> import math
    >>> from cyclemap.resets import gripper_turns
    >>> [round(math.degrees(action.turn)) for action in gripper_turns(4)]
    [0, 90, 180, 270]
    """
    steps = whole_number("turns", count, least=1)
    return tuple(CycleAction(turn=TWO_PI * step / steps) for step in range(steps))


def legs(length: float, count: int) -> tuple[CycleAction, ...]:
    """Return drags by a place off the target, in each of some equal directions, the first along x.

    Parameters
    ----------
    length : float
        Distance of the place from the target, m, positive.
    count : int
        How many directions.

    Returns
    -------
    tuple of CycleAction
        One a direction.

    Raises
    ------
    InvalidInput
        For a length that is not positive, and a count that is no whole number from 1.

    Examples
    --------
    >>> from cyclemap.resets import legs
    >>> [action.way_points for action in legs(0.05, 2)][0]
    ((0.05, 0.0),)
    """
    away = positive_number("leg's length", length)
    steps = whole_number("directions", count, least=1)
    angles = [TWO_PI * step / steps for step in range(steps)]
    return tuple(
        CycleAction(((away * math.cos(angle), away * math.sin(angle)),)) for angle in angles
    )


def require_strategy(strategy: object) -> ResetStrategy:
    """Return what is a ResetStrategy, or raise InvalidInput."""
    if not isinstance(strategy, ResetStrategy):
        raise InvalidInput(f"the strategy is {strategy!r}: give a ResetStrategy")
    return strategy
