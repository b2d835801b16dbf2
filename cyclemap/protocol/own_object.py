"""An experiment with one's own object: a first guess of where to push it, and what is likely wrong
with a guess.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, DoubtfulInput, InvalidInput
from cyclemap.mechanics import Ellipse, Polygon, grid_footprint, load_material
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.mechanics.outline import Outline
from cyclemap.protocol.collection_file import names_surface, read_settings
from cyclemap.protocol.settings import (
    SETTINGS,
    Settings,
    inherited_defaults,
    layered,
    loop_from_settings,
    without_noise,
)

MM = 1000.0
# MIT's experiment by the size of its object, the square root of the plate's area: where the ring
# is, how far it pushes.
_RING = 15.0 / 90.0
_PUSH = 150.0 / 90.0
_FRACTION = 0.7
# Degrees of a push on a disc, and how far the axes of what counts as one may differ.
_SLANT = 15.0
_ROUND = 1.02
_RULED_MM = 5.0
# Objects that a rod on a robot's arm pushes about are within these sizes (m); a hand moves none
# that is heavier (kg).
_SMALLEST = 0.01
_LARGEST = 1.0
_HEAVIEST = 50.0
_MOST_RATIO = 2.0
# Where a ring would lie beside a bent object, it comes to the nearest of so many cells a side
# inside.
_CELLS = 40
_AROUND = (np.arange(24) * 2.0 * math.pi / 24).tolist()
# A ring nearer to the centre than this share of the object's reach hardly turns it; a push shorter
# than this neither.
_SHORT_LEVER = 0.03
_SHORT_PUSH = 0.1

# Whether something is doubtful, and what is said of it.
Doubts = tuple[tuple[bool, str], ...]


def first_settings(outline: Outline, name: str) -> Settings:
    """Return settings of an experiment with an object of this outline, in proportion as MIT's is.

    The pushed side is the longest that a straight wall could touch, the ring on the way from the
    centroid to the corner that ends it; a disc, which no straight push turns, is pushed at a slant.
    Rod and friction are MIT's rod and no surface at all: they want to be measured.
    """
    size = math.sqrt(outline.area)
    centre = np.array(outline.centroid)
    if isinstance(outline, Ellipse):
        shape: Settings = {"semi_x_mm": MM * outline.semi_x, "semi_y_mm": MM * outline.semi_y}
        side = 0
        corner = np.array([-outline.semi_x, outline.semi_y])
        slant = _SLANT if 1.0 / _ROUND < outline.semi_x / outline.semi_y < _ROUND else 0.0
    else:
        shape = {"vertices_mm": (MM * outline.array).round(6).tolist()}
        side = _longest_outer_side(outline)
        slant = 0.0
        corner = outline.array[(side + 1) % outline.sides]
    ring = centre + _RING * size * (corner - centre) / math.hypot(*(corner - centre))
    if not outline.contains(ring):
        cells, load = grid_footprint(outline, _CELLS).quadrature
        # Those with half a cell's load lie on a side.
        inside = cells[load > 0.75 * load.max()]
        ring = inside[np.argmin(np.hypot(*(inside - ring).T))]
    return {
        **shape,
        "object_name": name,
        "mass_kg": 1.0,
        "side": side,
        "fraction": _FRACTION if isinstance(outline, Polygon) else 0.3,
        "angle_deg": slant,
        "push_mm": _RULED_MM * round(MM * _PUSH * size / _RULED_MM) or round(MM * _PUSH * size, 3),
        "pusher_radius_mm": 4.75,
        "pusher_mu": 0.15,
        "hitch_x_mm": round(MM * float(ring[0]), 2),
        "hitch_y_mm": round(MM * float(ring[1]), 2),
    }


def within_reach(loop: CollectionLoop) -> CollectionLoop:
    """Return the loop with its push no longer than its rod stays on the object, from 24
    orientations, less a tenth.
    """
    coarse = replace(loop, accuracy=1e-6)
    travel = min(coarse.cycle(theta).push.travel for theta in _AROUND)
    if travel >= loop.push.distance * (1.0 - 1e-9):
        return loop
    shorter = 0.9 * MM * travel
    ruled = _RULED_MM * math.floor(shorter / _RULED_MM) or shorter
    return replace(loop, push=replace(loop.push, distance=ruled / MM))


def _longest_outer_side(outline: Polygon) -> int:
    """The longest side that has the whole object on its inner side."""
    start = outline.array
    edge = np.roll(start, -1, axis=0) - start
    length = np.hypot(*edge.T)
    along_x, along_y = edge.T / length
    away = start[:, None] - start
    # How far every corner is to the left of every side.
    left = along_x * away[..., 1] - along_y * away[..., 0]
    outer = np.flatnonzero(left.min(axis=0) >= -1e-9 * outline.extent).tolist()
    return max(
        outer or range(outline.sides), key=lambda side: (round(float(length[side]), 9), -side)
    )


@dataclass(frozen=True)
class Finding:
    """What is wrong, or likely so.

    Attributes
    ----------
    wrong : bool
        Whether nothing can be computed with it.
    words : str
        In plain words.
    """

    wrong: bool
    words: str


@dataclass(frozen=True)
class CheckedCollection:
    """A collection file as it was understood, and what is doubted of it.

    Attributes
    ----------
    loop : CollectionLoop or None
        The loop; None where there can be none.
    findings : tuple of Finding
        What is wrong, or likely so, in plain words.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.protocol import check_collection
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     count = Path(folder, "mine.toml").write_text("[pusher]\\npusher_radius_mm = 5\\n")
    ...     checked = check_collection(f"{folder}/mine.toml")
    >>> checked.loop.pusher.radius, any(finding.wrong for finding in checked.findings)
    (0.005, False)
    """

    loop: CollectionLoop | None
    findings: tuple[Finding, ...]


def check_collection(path: str | Path) -> CheckedCollection:
    """Look at a collection file as a careful colleague would.

    Parameters
    ----------
    path : str or Path
        The collection file.

    Returns
    -------
    CheckedCollection
        The loop, where there can be one, and the findings.

    Raises
    ------
    DataFileError
        Where the file is no collection at all.

    Notes
    -----
    Asked are: units, the ring's place, the pushed side and what is left to MIT's experiment,
    then, by running the push and drag from 24 orientations, whether the rod runs off the object
    and whether cycles turn it; last, friction.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from cyclemap.protocol import check_collection
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     count = Path(folder, "mine.toml").write_text("[push]\\npush_mm = 1500\\n")
    ...     checked = check_collection(f"{folder}/mine.toml")
    >>> checked.findings[0].words.split(" (")[0]
    'the rod slides past the edge after 154 of 1500 mm'
    """
    (settings, _) = without_noise(read_settings(path))
    has_surface = names_surface(path)
    doubtful = [
        f"{words} is not said, so it is that of MIT's experiment: give {', '.join(keys)}"
        for words, keys in inherited_defaults(settings).items()
    ]
    if not {"vertices_mm", "semi_x_mm", "shape"} & set(settings):
        doubtful.append(
            "no object is said, so it is MIT's 90 mm square rect1: give vertices_mm, semi_x_mm "
            "and semi_y_mm, or shape"
        )
    if not has_surface:
        doubtful.append(
            "no surface is said: give a table [friction] with mu_a and mu_b, or name a material "
            "with each command"
        )
    with warnings.catch_warnings(record=True) as doubts:
        warnings.simplefilter("always", DoubtfulInput)
        try:
            material = load_material(path if has_surface else "isotropic")
            loop = loop_from_settings(layered(settings), CollectionLoop.mit(material))
            first_contact(loop.slider, loop.push, loop.pusher.radius)
            _ = loop.model
        except InvalidInput as error:
            return CheckedCollection(
                None, (Finding(True, str(error)), *(Finding(False, words) for words in doubtful))
            )
    doubtful += [*dict.fromkeys(str(doubt.message) for doubt in doubts), *_unusual(loop)]
    return CheckedCollection(
        loop, (*_strokes(loop), *(Finding(False, words) for words in doubtful))
    )


def _unusual(loop: CollectionLoop) -> list[str]:
    """What is odd about the sizes and frictions of a loop."""
    slider = loop.slider
    reach = slider.outline.extent
    away = math.dist(slider.outline.centroid, (0.0, 0.0))
    lever = math.dist(slider.hitch, slider.centre_of_mass)
    size = f"the object reaches {MM * reach:.4g} mm from its centre"
    doubts: Doubts = (
        (
            reach < _SMALLEST,
            f"{size}: were its lengths given in metres or centimetres? They are read as "
            "millimetres",
        ),
        (reach > _LARGEST, f"{size}: were its lengths given in finer units than millimetres?"),
        (
            away > reach,
            f"{size}, which is {MM * away:.4g} mm from the origin of its frame: was the drawing "
            "not centred?",
        ),
        (
            lever < _SHORT_LEVER * reach,
            "the ring is all but at the centre of mass: the drag back will hardly turn the object",
        ),
        (slider.mass > _HEAVIEST, f"the mass is {slider.mass:g} kg: was it given in grams?"),
        *_unusual_friction(loop),
    )
    return [words for is_so, words in doubts if is_so]


def _unusual_friction(loop: CollectionLoop) -> Doubts:
    law = loop.material.friction
    low, high = sorted((law.mu_a, law.mu_b))
    return (
        (
            low < SETTINGS["mu_a"].low or high > SETTINGS["mu_a"].high,
            f"friction of {low:g} to {high:g} is rare between dry solids, 0.1 to 0.8 is usual",
        ),
        (
            high > _MOST_RATIO * low,
            f"friction is {high / low:.3g} times as large in one direction as in another; "
            "measured ones reach 1.6",
        ),
        (
            loop.pusher.friction > SETTINGS["pusher_mu"].high,
            f"friction of {loop.pusher.friction:g} between rod and object is that of rubber",
        ),
        (
            law.mu_a == law.mu_b and law.m0 == law.n0 == 0.0,
            "friction is the same in every direction, so that no push direction is preferred: a "
            "guess to start with; cyclemap identify finds it from data",
        ),
    )


def _strokes(loop: CollectionLoop) -> list[Finding]:
    """What running the cycle from orientations all around shows."""
    coarse = replace(loop, accuracy=1e-6)
    asked = loop.push.distance
    shortest = (math.inf, 0.0)
    turns = []
    for theta in _AROUND:
        try:
            cycle = coarse.cycle(theta)
        except CycleMapError as error:
            return [Finding(True, f"from θ0 = {math.degrees(theta):.0f}°: {error}")]
        shortest = min(shortest, (cycle.push.travel, theta))
        turns.append(abs(cycle.push_turn))
    doubts = (
        (
            shortest[0] < asked * (1.0 - 1e-9),
            f"the rod slides past the edge after {MM * shortest[0]:.0f} of {MM * asked:.0f} mm "
            f"(from θ0 = {math.degrees(shortest[1]):.0f}°): take a shorter push_mm, or push "
            "nearer to the middle",
        ),
        (
            asked < _SHORT_PUSH * loop.slider.outline.extent,
            f"a push of {MM * asked:.4g} mm hardly moves this object: is push_mm in millimetres?",
        ),
        (
            max(turns) < math.radians(1.0),
            "the push goes through the centre of friction and does not turn the object: move the "
            "contact or slant it",
        ),
    )
    return [Finding(False, words) for is_so, words in doubts if is_so]
