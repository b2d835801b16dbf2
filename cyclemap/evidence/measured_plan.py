"""What measured pushes tell of a floor of which something was believed before, and whether that is
enough.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.uncertain_directions import DirectionUncertainty, direction_uncertainty
from cyclemap.errors import ConvergenceError
from cyclemap.evidence.data_blocks.collected_blocks import collected_blocks, telling_parameters
from cyclemap.evidence.identification.identify import Identification, identify
from cyclemap.evidence.identification.known_floor import (
    FLOOR_TOLD,
    held_values,
    known_beliefs,
    known_shapes,
    known_spread,
)
from cyclemap.evidence.identification.surface_parameters import starting_space
from cyclemap.evidence.identified_material import identified_material
from cyclemap.mechanics.material import ANY_PLATE
from cyclemap.mechanics.plate_footprint import known_plate
from cyclemap.progress import Progress, part_of

# Directions, and whether there are any, are known when this share of what is left to believe
# agrees.
SURE = 0.95


@dataclass(frozen=True, eq=False)
class MeasuredPlan:
    """What pushes on a floor tell of it.

    Attributes
    ----------
    loop : CollectionLoop
        On the identified floor.
    identification : Identification
        Of its parameters.
    directions : DirectionUncertainty
        How well the stable ones are known.
    notes : tuple of str
        What was read and left out.

    Examples
    --------
    Of the file that `filled_text` makes of a filled table:

    >>> from pathlib import Path
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import measured_plan
    >>> loop = CollectionLoop.mit("unknown")
    >>> measured = measured_plan(loop, [Path("read.csv")])  # doctest: +SKIP
    >>> measured.is_enough(within=0.1)  # doctest: +SKIP
    False
    """

    loop: CollectionLoop
    identification: Identification
    directions: DirectionUncertainty
    notes: tuple[str, ...]

    @property
    def half_width(self) -> float:
        """Half the widest 95 % interval of a stable direction that is likely to be there, rad; 0
        where none is.
        """
        likely = [
            direction for direction in self.directions.directions if direction.share > 1.0 - SURE
        ]
        return 0.5 * max((direction.upper - direction.lower for direction in likely), default=0.0)

    def is_enough(self, within: float) -> bool:
        """Whether it is known that the loop locks in, and where to `within` rad, or that it does
        not.
        """
        chance = self.directions.chance
        return chance <= 1.0 - SURE or (chance >= SURE and self.half_width <= within)


def measured_plan(
    loop: CollectionLoop,
    paths: Sequence[Path],
    *,
    seed: int = 0,
    progress: Progress | None = None,
) -> MeasuredPlan:
    """Identify the floor of a loop from measured pushes, and tell how well its stable directions
    are then known.

    Parameters
    ----------
    loop : CollectionLoop
        Its material has samples of what is believed of the floor.
    paths : sequence of Path
        Tables that `readable_data` made readable.
    seed : int, default 0
        Of the starts of the search.
    progress : callable or None, optional
        Called with the fraction done.

    Returns
    -------
    MeasuredPlan
        The floor, its parameters, and how well directions are known.

    Raises
    ------
    InvalidInput
        For data that cannot be read, or that hold a filled-in push twice.
    ConvergenceError
        Where no start converges.

    Examples
    --------
    Of two pushes, in half a minute:

    >>> from pathlib import Path
    >>> from cyclemap import CollectionLoop
    >>> from cyclemap.evidence import measured_plan
    >>> loop = CollectionLoop.mit("unknown")
    >>> measured = measured_plan(loop, [Path("read.csv")])  # doctest: +SKIP
    >>> measured.notes  # doctest: +SKIP
    ('read.csv: 2 push ends of rect1',)
    """
    report = progress or (lambda fraction: None)
    identification, notes = identified_plan(loop, paths, seed=seed, progress=part_of(report, 0, 2))
    sources, floor = [path.name for path in paths], loop.material
    material = identified_material(
        identification, f"{floor.name}-measured", sources, plate=loop.slider.name, floor=floor
    )
    measured = replace(loop, footprint=None).with_material(material)
    directions = direction_uncertainty(measured, part_of(report, 1, 2))
    return MeasuredPlan(measured, identification, directions, notes)


def identified_plan(
    loop: CollectionLoop,
    paths: Sequence[Path],
    *,
    starts: int = 2,
    seed: int = 0,
    progress: Progress | None = None,
) -> tuple[Identification, tuple[str, ...]]:
    """Identify floor, plate, rod and ring from measured pushes, beginning with what the loop's
    material believes.

    loop, paths, seed, progress : see `measured_plan`, and there what is raised.
    starts : of the search. Returns the identification, and notes on what was read. A plate that is
        known stays as it is. Noise is Student's with four degrees of freedom, so that a misread
        ruler counts little.
    """
    floor = loop.material
    collected = collected_blocks(paths, loop, population=True)
    plate = known_plate(floor, collected.loop.slider)
    shapes = () if plate is None or plate.plate == ANY_PLATE else (plate,)
    fixed = known_shapes(shapes, collected.blocks, collected.loop.slider.name)
    telling = telling_parameters(collected.blocks, known_beliefs(floor, FLOOR_TOLD))
    free = [name for name in telling if name not in fixed]
    space = starting_space(loop, floor)
    identification = identify(
        collected.blocks,
        free,
        held_values(collected.blocks, space, free, floor) | fixed,
        priors=collected.beliefs(free) | known_beliefs(floor, free, collected.loop.slider.name),
        noise={**collected.noise, **known_spread(floor, collected.blocks)},
        starts=starts,
        student=4.0,
        seed=seed,
        space=space,
        progress=progress,
    )
    if not identification.fit.converged:
        raise ConvergenceError(f"no start converged: {identification.fit.message}")
    return identification, collected.notes
