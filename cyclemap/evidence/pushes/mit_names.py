"""File names of the MIT push dataset (Yu et al. 2016): what a name says about the push or the
friction scan.
"""

import math
import re
from collections.abc import Callable
from dataclasses import asdict, dataclass
from decimal import Decimal
from pathlib import PurePath

from cyclemap.checks import finite_number, whole_number
from cyclemap.errors import InvalidInput

_NUMBER = r"[-+]?\d+(?:\.\d+)?"
_BEGIN = rf"surface=(?P<surface>.+)_shape=(?P<object>.+)_a=(?P<a>{_NUMBER})_v=(?P<v>{_NUMBER})"
_END = r"(?:_rep=(?P<rep>\d+))?"
_PLACE = rf"_i=(?P<i>\d+)(?:\.0+)?_s=(?P<s>{_NUMBER})_t=(?P<t>{_NUMBER})"
_PUSH = re.compile(f"motion_{_BEGIN}{_PLACE}{_END}", re.ASCII)
_SCAN = re.compile(f"record_{_BEGIN}_deg=(?P<deg>{_NUMBER}){_END}", re.ASCII)
# Letters and digits behind a point; decimals of a number are no suffix.
_SUFFIX = re.compile(r"\.[A-Za-z][A-Za-z0-9]*")


@dataclass(frozen=True)
class PushFacts:
    """What the name of a push file says; a fact it does not give is NaN (text: None).

    Attributes
    ----------
    surface, object : str or None
        Names, such as "plywood" and "rect1".
    acceleration : float
        m/s^2, 0 for a push at constant speed.
    speed : float
        m/s; NaN where the name gives a negative one, as names of accelerated pushes do.
    side : float
        Side of the object, counter-clockwise from 0.
    fraction : float
        Place on that side, from its first vertex.
    angle : float
        Of the push against the inner normal, in the object's initial frame, rad.
    repetition : float
        Number of the push in its set.
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

    direction : rad in [0, 2π), the way the object moves in the world: half a turn from the `deg` of
        the name.

    The rest as in `PushFacts`.
    """

    surface: str | None = None
    object: str | None = None
    acceleration: float = math.nan
    speed: float = math.nan
    direction: float = math.nan
    repetition: float = math.nan


def push_facts(path: str | PurePath) -> PushFacts | None:
    """Return the facts in the name of a push file (folders and suffix do not matter); None for any
    other name.

    Names are `motion_surface=S_shape=O_a=A_v=V_i=I_s=F_t=T` with A in mm/s^2, V in mm/s and T in
    rad, and `_rep=NNNN` behind it in repeated sets.
    """
    found = _PUSH.fullmatch(_bare(path))
    if found is None:
        return None
    side, fraction, angle = (float(found[letter]) for letter in "ist")
    return PushFacts(*_motion(found), side, fraction, angle, float(found["rep"] or "nan"))


def scan_facts(path: str | PurePath) -> ScanFacts | None:
    """Return the facts in the name of a straight friction scan; None for any other name.

    Names are `record_surface=S_shape=O_a=A_v=V_deg=D_rep=RRR`; scans that also turn the object
    (`rotdeg` in the name) are another kind, and none of these.
    """
    found = _SCAN.fullmatch(_bare(path))
    if found is None:
        return None
    direction = math.radians((float(found["deg"]) + 180.0) % 360.0)
    return ScanFacts(*_motion(found), direction, float(found["rep"] or "nan"))


def _bare(path: str | PurePath) -> str:
    """The name of a file without its suffix."""
    name = PurePath(path)
    return name.stem if _SUFFIX.fullmatch(name.suffix) else name.name


def _motion(found: re.Match[str]) -> tuple[str, str, float, float]:
    """Surface, object, acceleration and speed."""
    # The numbers nearest to a thousandth of the text's.
    acceleration, speed = (float(f"{found[letter]}e-3") for letter in "av")
    return found["surface"], found["object"], acceleration, speed if speed >= 0.0 else math.nan


def push_name(facts: PushFacts) -> str:
    """Return the name of a push file, without folder and suffix, that says these facts: the inverse
    of `push_facts`.

    Numbers have the decimals that names of the dataset have, and more where the exact number needs
    them. Raises InvalidInput where a fact is missing (only the repetition may be) or no name could
    say it.

    >>> push_name(PushFacts("plywood", "rect1", 0.0, 0.02, 0.0, 0.7, 0.0, 12.0))
    'motion_surface=plywood_shape=rect1_a=0_v=20_i=0.000_s=0.700_t=0.000_rep=0012'
    >>> push_facts("motion_surface=pu_shape=hex_a=0_v=5.5_i=1.000_s=0.250_t=-0.349").speed
    0.0055
    """
    place = (("i", "side"), ("s", "fraction"), ("t", "angle"))
    told = "_".join(
        f"{letter}={_decimal(fact, getattr(facts, fact), 0, 3)}" for letter, fact in place
    )
    return _name("motion", facts, told, 4, push_facts)


def scan_name(facts: ScanFacts) -> str:
    """Return the name of a friction scan, without folder and suffix: the inverse of `scan_facts`.

    The direction is written in degrees to nine decimals. Raises InvalidInput as `push_name` does.

    >>> scan_name(ScanFacts("pu", "rect1", 0.0, 0.02, math.radians(90.0), 1.0))
    'record_surface=pu_shape=rect1_a=0_v=20_deg=270_rep=001'
    """
    degrees = round(math.degrees(finite_number("direction", facts.direction)) + 180.0, 9) % 360.0
    return _name("record", facts, f"deg={_decimal('direction', degrees)}", 3, scan_facts)


def _decimal(name: str, value: float, shift: int = 0, decimals: int = 0) -> str:
    """The exact decimal number value 10^shift without exponent, with at least so many decimals."""
    exact = Decimal(repr(finite_number(name, value) + 0.0)).scaleb(shift).normalize()
    return f"{exact:.{max(decimals, -int(exact.as_tuple().exponent))}f}"


def _name(
    kind: str,
    facts: PushFacts | ScanFacts,
    place: str,
    digits: int,
    read: Callable[[str], PushFacts | ScanFacts | None],
) -> str:
    """The name of a file; InvalidInput where reading it gives other facts."""
    motion = "_".join(
        f"{letter}={_decimal(fact, getattr(facts, fact), 3)}"
        for letter, fact in (("a", "acceleration"), ("v", "speed"))
    )
    name = f"{kind}_surface={facts.surface}_shape={facts.object}_{motion}_{place}"
    if not math.isnan(facts.repetition):
        repetition = facts.repetition
        number = int(repetition) if float(repetition).is_integer() else repetition
        name += f"_rep={whole_number('repetition', number, 0):0{digits}d}"
    seen = read(name)
    for fact, value in asdict(facts).items():
        again = getattr(seen, fact, None)
        same = value == again
        if isinstance(value, (int, float)) and isinstance(again, (int, float)):
            # Directions are written to nine decimals of a degree, and are the same a full turn on.
            both_unknown = math.isnan(value) and math.isnan(again)
            same = both_unknown or abs(math.remainder(value - again, 2.0 * math.pi)) < 1e-10
        if not same:
            raise InvalidInput(
                f"no file name can say {facts}: it would be read as {seen}; mend the texts and "
                "numbers"
            )
    return name
