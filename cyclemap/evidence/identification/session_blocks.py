"""Blocks of several plates and sessions: what each has of its own, and which sessions are odd."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import cycle

import numpy as np

from cyclemap.arrays import Array
from cyclemap.collection.loop import CollectionLoop
from cyclemap.evidence.identification.data_block import DataBlock, session_block
from cyclemap.evidence.identification.stroke_block import TIP_OFFSET, surface_model
from cyclemap.evidence.identification.surface_parameters import (
    FLOOR_NAMES,
    PLATE_NAMES,
    SURFACE,
    SurfaceParameters,
)
from cyclemap.evidence.predicted_strokes import loop_of_plate, predicted_push_ends
from cyclemap.evidence.pushes.measured_strokes import (
    READ,
    ROD_OFF,
    MeasuredPush,
    push_noise,
    set_up_errors,
)

# What belongs to a plate, or to the frame that its data are in, and what to a session.
PLATE_OWNED = (*SURFACE.select(PLATE_NAMES).parameters, *TIP_OFFSET)
SESSION_OWNED = SURFACE.select(FLOOR_NAMES).parameters
# A session whose robot was this far from where it was sent (m), and so many times further than in
# others, is odd.
_ASTRAY = 5e-4
_TIMES = 3.0
# So is one in which a plate turns by this share less or more than in another, and by so many
# standard errors; so many pushes, at least, tell.
_TURNS_APART = 0.15
_TURN_ERRORS = 4.0
_FEWEST_TURNS = 20


@dataclass(frozen=True, eq=False)
class SessionBlock:
    """A block of data, of which plate it is, and in which session; empty where nothing tells.

    words : what it holds.
    read : how far readings are off, m and rad; None where that is not told.
    pushes : of the block, some of them.
    strayed : how far the robot was from where it was sent, m, on average; None where that is not
        known.
    scans : tractions of friction scans, (n, 2).
    last_cycle : how many the last cycle is behind the first.
    """

    block: DataBlock
    words: str
    read: tuple[float, float] | None = None
    pushes: Sequence[MeasuredPush] = ()
    strayed: float | None = None
    scans: Array | None = None
    last_cycle: float = 0.0
    plate: str = ""
    session: str = ""

    @property
    def set_up(self) -> dict[str, tuple[float, float]]:
        """What is believed of how each push was set up by hand, by name: 0 and a deviation."""
        unknown = (row.name for row in self.block.own_parameters if row.name.startswith(ROD_OFF))
        errors = cycle(set_up_errors(self.read or READ).tolist())
        return {name: (0.0, error) for name, error in zip(unknown, errors, strict=False)}

    @property
    def noise(self) -> dict[str, float]:
        """How far measurements are off, by kind of noise; infinite where that is not told.

        Of pushes that a robot made the angle before them is noise, too.
        """
        kinds = set(self.block.kinds.tolist())
        if self.read is None:
            return dict.fromkeys(kinds, math.inf)
        along, _, turned, dragged = push_noise(self.read).tolist()
        if not self.set_up:
            turned = math.hypot(turned, self.read[1])
        sizes = {"push place (m)": along, "push turn (rad)": turned, "drag turn (rad)": dragged}
        return {kind: sizes[kind] for kind in kinds}


def named_blocks(
    known: Sequence[SessionBlock], odd: Sequence[str], population: bool
) -> tuple[DataBlock, ...]:
    """Return the blocks, those of several plates or sessions with unknowns of their own, and how
    sessions differ.

    odd : sessions that do not count to the floor's mean.
    population : whether one session is taken as one of several. Equal names get a number behind.
    """
    # What tells no speed belongs to the first session of its plate that does.
    first: dict[str, str] = {}
    for row in known:
        if row.session:
            first.setdefault(row.plate, row.session)
    owners = [row.session or first.get(row.plate, row.plate) for row in known]
    of_floor = {parameter.name for parameter in SESSION_OWNED}
    both = [*zip(owners, known, strict=True)]
    telling = (owner for owner, row in both if of_floor & {*row.block.parameters})
    sessions = list(dict.fromkeys(telling))
    has_sessions = len(sessions) > 1 or (population and bool(sessions))
    has_plates = len({row.plate for row in known}) > 1
    blocks = []
    for owner, row in both:
        block = row.block
        if has_plates:
            block = block.of_owner(row.plate, PLATE_OWNED)
        if has_sessions:
            block = block.of_owner(owner, SESSION_OWNED)
        whose = owner if has_sessions else row.plate if has_plates else ""
        blocks.append(replace(block, name=f"{whose} {block.name}".strip()))
    if has_sessions:
        blocks.append(session_block(sessions, odd))
    names = [block.name for block in blocks]
    for index, name in enumerate(names):
        if names.count(name) > 1:
            place = names[: index + 1].count(name)
            blocks[index] = replace(blocks[index], name=f"{name} {place}")
    return tuple(blocks)


def odd_sessions(
    loop: CollectionLoop, known: Sequence[SessionBlock]
) -> tuple[dict[str, str], dict[str, str]]:
    """Return sessions whose robot strayed, or whose plate turned, unlike in the others, each with
    the reason; and those of which nothing tells whether they or another one is odd.

    Of two sessions that turn a plate unlike the odd one is that whose robot strayed more.
    """
    tip_errors = {row.session: row.strayed for row in known if row.strayed is not None}
    pushes: dict[str, dict[str, Sequence[MeasuredPush]]] = {}
    for row in known:
        if len(row.pushes) >= _FEWEST_TURNS:
            pushes.setdefault(row.plate, {}).setdefault(row.session, row.pushes)
    usual = float(np.median([*tip_errors.values()])) if tip_errors else 0.0
    odd = dict[str, str]()
    open_ones = dict[str, str]()
    for session, size in tip_errors.items():
        if size > max(_ASTRAY, _TIMES * usual):
            odd[session] = (
                f"the rod was {1e3 * size:.2g} mm from where it was sent on average, "
                f"{1e3 * usual:.2g} mm in others"
            )
    for plate, sessions in pushes.items():
        if len(sessions) < 2:
            continue
        own_loop = loop_of_plate(loop, plate)
        turns = {name: flat_turns(own, own_loop) for name, own in sessions.items()}
        for session, reason in _turned_unlike(turns).items():
            astray = tip_errors.get(session, 0.0)
            others = max(tip_errors.get(name, 0.0) for name in turns if name != session)
            if len(turns) > 2 or astray > others:
                odd[session] = reason
            elif astray == others:
                open_ones[session] = reason
    return odd, open_ones


def _turned_unlike(turns: Mapping[str, tuple[float, float]]) -> dict[str, str]:
    """The sessions of one plate that turned it unlike the median of all, of two the other one."""
    unlike = {}
    for session, (ratio, error) in turns.items():
        ranked = sorted(known for name, known in turns.items() if len(turns) > 2 or name != session)
        usual, its_error = ranked[(len(ranked) - 1) // 2]
        least = _TURN_ERRORS * math.hypot(error, its_error)
        if abs(ratio - usual) > max(_TURNS_APART * max(ratio, usual), least):
            unlike[session] = (
                f"its turns are {ratio:.2f} of isotropic friction's on a flat floor, "
                f"{usual:.2f} in others"
            )
    return unlike


def flat_turns(pushes: Sequence[MeasuredPush], loop: CollectionLoop) -> tuple[float, float]:
    """Return the mean size of turns over that of isotropic friction on a flat floor, and its
    standard error; loop : whose object was pushed, by whose rod.
    """
    model = surface_model(SurfaceParameters(), loop.slider, rod_radius=loop.pusher.radius)
    ends = predicted_push_ends(model, pushes)[0]
    before, after = np.array([(push.start.theta, push.end.theta) for push in pushes]).T
    predicted = np.abs(ends[:, 2] - before)
    measured = np.abs(after - before)
    mean = max(float(np.mean(predicted)), 1e-9)
    ratio = float(np.mean(measured)) / mean
    return ratio, float(np.std(measured - ratio * predicted)) / math.sqrt(len(pushes)) / mean
