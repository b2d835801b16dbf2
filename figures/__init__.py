"""The gallery in order, what an exhibit is and is made from, and the modules behind the names,
imported when asked.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from cyclemap.errors import InvalidInput, unknown_name
from cyclemap.written import UNWRITTEN

if TYPE_CHECKING:
    import numpy as np
    from matplotlib.figure import Figure
    from numpy.typing import NDArray


THETA0_FILE = "plywood_rect1_theta0_2000.csv"
NO_DATA = "no measured data found"


@dataclass(frozen=True)
class MeasuredFolder:
    """A folder of measured data; `path` is None where there is none."""

    path: Path | None = None

    @classmethod
    def found(cls, given: Path | None = None) -> MeasuredFolder:
        """Return the folder `given`, else the one $CYCLEMAP_DATA names, else `shared/data` beside
        the checkout.

        Raises InvalidInput where `given` or $CYCLEMAP_DATA is no folder.
        """
        named = given or (
            Path(os.environ["CYCLEMAP_DATA"]) if os.environ.get("CYCLEMAP_DATA") else None
        )
        if named is not None:
            if not named.is_dir():
                raise InvalidInput(
                    f"measured data: {str(named)!r} is no folder; name one, or leave --data out"
                )
            return cls(named)
        beside = Path(__file__).parents[2] / "shared" / "data"
        return cls(beside if beside.is_dir() else None)

    def find(self, name: str) -> Path | None:
        """Return the path of the file or sub-folder `name` in the folder; None where it is not
        there.
        """
        place = None if self.path is None else self.path / name
        return place if place is not None and place.exists() else None


# The source of what the paper does not have.
BEYOND = "not in the paper"


@dataclass(frozen=True)
class Entry:
    """One exhibit as the gallery lists it.

    name : as the command line says it.
    source : the paper's figure, or `BEYOND`.
    title : a few words.
    module : of this room, whose EXHIBITS have it.
    """

    name: str
    source: str
    title: str
    module: str = field(metadata=UNWRITTEN)


# What an exhibit computes, of a type of its own.
Result = Any


@dataclass(frozen=True)
class Exhibit:
    """How an exhibit is made: a picture, a table or an animation.

    compute : measured data -> result, the only slow part.
    caption : result -> sentences that hold for this result, with its numbers.
    draw : result -> figure.
    header, rows : of a table; result -> rows of words.
    frames : result -> the `Frame`s of an animation, all of one size.
    """

    compute: Callable[..., Result]
    caption: Callable[[Result], str]
    draw: Callable[[Result], Figure] | None = None
    header: tuple[str, ...] = ()
    rows: Callable[[Result], list[tuple[str, ...]]] | None = None
    frames: Callable[[Result], Iterator[Frame]] | None = None


@dataclass(frozen=True, eq=False)
class Frame:
    """One picture of an animation.

    pixels : (height, width, 3), 0 to 255.
    seconds : how long it is shown.
    """

    pixels: NDArray[np.uint8]
    seconds: float


CATALOGUE = (
    Entry("setup-and-cycle", "Figs. 1 (left) and 2", "The set-up and two cycles", "cycles"),
    Entry(
        "trajectories-object-frame",
        "Fig. 3",
        "Paths of the centre in the object's frame",
        "trajectories",
    ),
    Entry(
        "trajectories-robot-frame",
        "Fig. 4",
        "Paths of the centre in the robot's frame",
        "trajectories",
    ),
    Entry(
        "limit-ellipse-and-patch",
        "the paper's limit ellipse and patch, and Fig. 10 (right)",
        "Limit ellipse of a point, of plywood, and the forces of the patch",
        "forces",
    ),
    Entry(
        "force-ratio",
        "Fig. 10 (left)",
        "Ratio of tangential to normal force at the pushing point",
        "forces",
    ),
    Entry(
        "simulated-against-measured",
        "Fig. 13",
        "Simulated and measured turns over θ0, plywood",
        "plywood_turns",
    ),
    Entry(
        "turn-over-theta0",
        "Fig. 5",
        "Turn of the push over its first orientation",
        "material_turns",
    ),
    Entry(
        "theta0-histograms",
        "Fig. 6",
        "Histograms of the orientation before a push",
        "material_directions",
    ),
    Entry(
        "turn-histograms",
        "Fig. 7",
        "Histograms of the turn, predicted by the law and recorded",
        "material_turns",
    ),
    Entry(
        "staircases",
        "the paper's staircases",
        "Staircases of θ0 over the pushes",
        "material_directions",
    ),
    Entry("table-friction", "Table I", "Friction ellipses of the materials", "tables"),
    Entry("table-deviations", "Table II", "How much equal pushes differ", "tables"),
    Entry("table-law-errors", "Table III", "How far pushes lie from a law of θ0", "tables"),
    Entry(
        "anisotropic-against-isotropic",
        "Figs. 11 and 12",
        "Simulated paths on anisotropic and on isotropic friction",
        "cycles",
    ),
    Entry(
        "dynamic-against-quasi-static",
        BEYOND,
        "What inertia changes at 20 mm/s, and how it vanishes with the speed",
        "cycles",
    ),
    Entry("fingerprint", BEYOND, "Five numbers against the full map", "fingerprint"),
    Entry("saddle-node", BEYOND, "Two directions meet as the ring moves in", "ring_distance"),
    Entry(
        "phase-diagram",
        BEYOND,
        "Ring radius against anisotropy: where the robot locks in",
        "ring_distance",
    ),
    Entry(
        "floor-shape",
        BEYOND,
        "What anisotropy of friction explains, and what the floor's shape explains",
        "plywood_turns",
    ),
    Entry(
        "staircase-bottleneck",
        BEYOND,
        "A staircase and the bottleneck that makes it",
        "bottleneck",
    ),
    Entry("wear-drift", BEYOND, "The cycle map as plywood wears", "bottleneck"),
    Entry("locking-in", BEYOND, "The loop of push and drag locks in", "locking_in"),
)


def entries(names: tuple[str, ...] = ()) -> tuple[Entry, ...]:
    """Return the entries of these names, in the gallery's order and each once; of none or "all",
    all of them.

    Raises InvalidInput, with the nearest name, for one that is unknown.

    >>> [entry.name for entry in entries(("wear-drift", "saddle-node"))]
    ['saddle-node', 'wear-drift']
    """
    known = {entry.name for entry in CATALOGUE}
    for name in names:
        if name not in known and name != "all":
            raise unknown_name("figure", name, known)
    everything = not names or "all" in names
    return tuple(entry for entry in CATALOGUE if everything or entry.name in names)


def load_exhibit(name: str) -> Exhibit:
    """Return the exhibit of this name; InvalidInput where it is unknown."""
    if name == "all" or not (chosen := entries((name,))):
        raise unknown_name("figure", name, {entry.name for entry in CATALOGUE})
    exhibits: dict[str, Exhibit] = import_module(f"cyclemap.figures.{chosen[0].module}").EXHIBITS
    return exhibits[name]
