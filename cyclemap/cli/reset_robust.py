"""The parts of `cyclemap reset` that look beyond one fresh material: a range of materials, and wear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from cyclemap.cli.json_report import Json
from cyclemap.cli.robust_report import robust_report, wear_report
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Wear, load_material
from cyclemap.resets.design.reset_design import ResetDesign
from cyclemap.resets.robust.design_under_wear import ResetUnderWear, reset_under_wear
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.material_score import independent_law
from cyclemap.resets.robust.robust_ranking import allowance_of, robust_first
from cyclemap.resets.robust.robust_reset import ROBUST_GRID, RobustReset, corner_check, robust_reset
from cyclemap.resets.robust.worst_case import WorstCase
from cyclemap.views import robust_sentences as sentences

Progress = Callable[[str, float], None]


@dataclass(frozen=True)
class BeyondRequest:
    """What is asked besides the design for one fresh material, in the units of the command line."""

    robust: bool
    ratio_percent: float
    offset_percent: float
    materials: int
    workers: int | None
    wear: bool
    wear_to: str | None


@dataclass(frozen=True, eq=False)
class RobustAnswer:
    """A robust reset, and what the first strategy by the nominal material alone does on the corners of the range."""

    robust: RobustReset
    other: tuple[str, WorstCase] | None

    def report(self) -> Json:
        """As JSON."""
        return robust_report(self.robust, self.other)

    def predicted(self) -> dict[str, float | bool]:
        """What a protocol file carries along of it."""
        check = self.robust.check
        found = {"robust_holds": self.robust.holds, "robust_worst_tv": check.worst()[1].total_variation}
        return {**found, "robust_share_exceeding_95": check.share_exceeding}

    def told(self) -> tuple[str, ...]:
        """In sentences, the verdict first."""
        return sentences.robust_sentences(self.robust, self.other)


@dataclass(frozen=True, eq=False)
class WearAnswer:
    """A reset as the surface `name` wears. course : None where it cannot be followed, for the reason `why_not`."""

    course: ResetUnderWear | None
    why_not: str
    allow_tv: float
    name: str

    def report(self) -> Json:
        """As JSON."""
        return wear_report(self.course, self.why_not, self.allow_tv, self.name)

    def told(self) -> str:
        """In a sentence."""
        if self.course is None:
            return f"Not followed as {self.name} wears: {self.why_not}."
        return sentences.wear_sentence(self.course, self.allow_tv, self.name)


def material_range(loop: CollectionLoop, asked: BeyondRequest, keep_push: bool) -> MaterialRange | None:
    """The range that is asked for; None where none is. InvalidInput for one that cannot be."""
    if not asked.robust:
        return None
    if keep_push:
        raise InvalidInput("--robust draws pushes and --keep-push allows one alone: leave out one of them")
    return MaterialRange(loop.material, 0.01 * asked.ratio_percent, 0.01 * asked.offset_percent)


def wearing_loop(loop: CollectionLoop, asked: BeyondRequest, cycles: int) -> CollectionLoop | None:
    """The loop on a surface that wears as it is asked for; None where it is not. InvalidInput where it cannot."""
    if asked.wear_to is None and not asked.wear:
        return None
    if cycles < 2:
        raise InvalidInput(f"--cycles is {cycles}: wear is followed over 2 pushes or more")
    if asked.wear_to is not None:
        worn = Wear(load_material(asked.wear_to).friction, float(cycles))
        return replace(loop, material=replace(loop.material, wear=worn))
    if loop.material.wear is None:
        raise InvalidInput(f"{loop.material.name} does not wear: name the worn surface with --wear-to MATERIAL")
    return loop


def made_robust(
    design: ResetDesign, about: MaterialRange, asked: BeyondRequest, seed: int, progress: Progress
) -> tuple[ResetDesign, RobustAnswer]:
    """The design with the robust pushes first, and how these do over the range."""
    loop, allowance = design.loop, allowance_of(design)
    robust = robust_reset(
        loop,
        about,
        allowance=allowance,
        count=asked.materials,
        seed=seed,
        reach=design.demands.reach,
        contact=design.demands.contact,
        noise=design.noise,
        grid=ROBUST_GRID,
        workers=asked.workers,
        progress=progress,
    )
    first = design.chosen
    corners = corner_check(
        loop,
        first.candidate.strategy,
        about,
        robust,
        noise=design.noise,
        grid=ROBUST_GRID,
        workers=asked.workers,
        progress=lambda done: progress("the first by the nominal material on the corners", done),
    )
    answer = RobustAnswer(robust, None if corners is None else (first.name, corners))
    return robust_first(design, robust, progress), answer


def followed_under_wear(design: ResetDesign, loop: CollectionLoop, pushes: int) -> WearAnswer:
    """What becomes of the chosen strategy over so many pushes on a loop whose surface wears."""
    strategy, allow_tv, name = design.chosen.candidate.strategy, design.demands.allow_tv, loop.material.name
    try:
        independent_law(strategy, ROBUST_GRID.nodes)
    except InvalidInput as refused:
        return WearAnswer(None, str(refused), allow_tv, name)
    course = reset_under_wear(loop, strategy, pushes, noise=design.noise, grid=ROBUST_GRID)
    return WearAnswer(course, "", allow_tv, name)
