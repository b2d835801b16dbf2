"""File names of the MIT push dataset (Yu et al. 2016): what a name says about the push or the friction scan."""

import math
import re
from dataclasses import dataclass
from pathlib import PurePath

_NUMBER = r"[-+]?\d+(?:\.\d+)?"
_PUSH = re.compile(
    rf"motion_surface=(?P<surface>.+)_shape=(?P<object>.+)_a=(?P<a>{_NUMBER})_v=(?P<v>{_NUMBER})"
    rf"_i=(?P<i>\d+)(?:\.0+)?_s=(?P<s>{_NUMBER})_t=(?P<t>{_NUMBER})(?:_rep=(?P<rep>\d+))?",
    re.ASCII,
)
_SCAN = re.compile(
    rf"record_surface=(?P<surface>.+)_shape=(?P<object>.+)_a=(?P<a>{_NUMBER})_v=(?P<v>{_NUMBER})"
    rf"_deg=(?P<deg>{_NUMBER})(?:_rep=(?P<rep>\d+))?",
    re.ASCII,
)


@dataclass(frozen=True)
class PushFacts:
    """What the name of a push file says; a fact it does not give is NaN (text: None).

    surface, object : names, such as "plywood" and "rect1". acceleration : m/s^2, 0 for a push at constant speed.
    speed : m/s; NaN where the name gives a negative one, as names of accelerated pushes do. side : side of the
    object, counter-clockwise from 0. fraction : place on that side, from its first vertex. angle : rad, of the
    push against the inner normal, in the object's initial frame. repetition : number of the push in its set.
    """

    surface: str | None = None
    object: str | None = None
    acceleration: float = math.nan
    speed: float = math.nan
    side: float = math.nan
    fraction: float = math.nan
    angle: float = math.nan
    repetition: float = math.nan


@dataclass(frozen=True)
class ScanFacts:
    """What the name of a friction scan says; a fact it does not give is NaN (text: None).

    direction : rad in [0, 2π), the way the object moves in the world: half a turn from the `deg` of the name.
    The rest as in `PushFacts`.
    """

    surface: str | None = None
    object: str | None = None
    acceleration: float = math.nan
    speed: float = math.nan
    direction: float = math.nan
    repetition: float = math.nan


def push_facts(path: str | PurePath) -> PushFacts | None:
    """Return the facts in the name of a push file (folders and suffix do not matter); None for any other name.

    Names are `motion_surface=S_shape=O_a=A_v=V_i=I_s=F_t=T` with A in mm/s^2, V in mm/s and T in rad, and
    `_rep=NNNN` behind it in repeated sets.

    >>> facts = push_facts("motion_surface=abs_shape=hex_a=0_v=50_i=4.000_s=0.700_t=-0.349.h5")
    >>> facts.object, facts.speed, facts.side, facts.angle
    ('hex', 0.05, 4.0, -0.349)
    """
    found = _PUSH.fullmatch(_stem(path))
    if found is None:
        return None
    return PushFacts(
        surface=found["surface"],
        object=found["object"],
        acceleration=float(found["a"]) / 1000.0,
        speed=_speed(found["v"]),
        side=float(found["i"]),
        fraction=float(found["s"]),
        angle=float(found["t"]),
        repetition=_repetition(found["rep"]),
    )


def scan_facts(path: str | PurePath) -> ScanFacts | None:
    """Return the facts in the name of a straight friction scan; None for any other name.

    Names are `record_surface=S_shape=O_a=A_v=V_deg=D_rep=RRR`; scans that also turn the object (`rotdeg` in
    the name) are another kind, and none of these.

    >>> facts = scan_facts("record_surface=pu_shape=rect1_a=0_v=20_deg=270_rep=001.h5")
    >>> facts.surface, facts.speed, round(facts.direction, 6), facts.repetition
    ('pu', 0.02, 1.570796, 1.0)
    """
    found = _SCAN.fullmatch(_stem(path))
    if found is None:
        return None
    return ScanFacts(
        surface=found["surface"],
        object=found["object"],
        acceleration=float(found["a"]) / 1000.0,
        speed=_speed(found["v"]),
        direction=math.radians((float(found["deg"]) + 180.0) % 360.0),
        repetition=_repetition(found["rep"]),
    )


def _stem(path: str | PurePath) -> str:
    """The file's name without its suffix; a name without one ends in a number, whose decimals are no suffix."""
    name = PurePath(path)
    return name.name if name.suffix[1:].isdigit() else name.stem


def _speed(text: str) -> float:
    speed = float(text) / 1000.0
    return speed if speed >= 0.0 else math.nan


def _repetition(text: str | None) -> float:
    return math.nan if text is None else float(text)
