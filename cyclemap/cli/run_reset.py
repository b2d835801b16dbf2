"""`cyclemap reset`: a reset designed for a material, as a ranked table, JSON, a picture, a protocol and a schedule."""

from __future__ import annotations

import math
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rich.table import Table

from cyclemap.cli.json_report import Json
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.reset_report import predicted_scores, reset_report
from cyclemap.cli.reset_robust import (
    BeyondRequest,
    RobustAnswer,
    WearAnswer,
    followed_under_wear,
    made_robust,
    material_range,
    wearing_loop,
)
from cyclemap.cli.settings import ChosenCollection, chosen_collection
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.maps import WrappedNormal
from cyclemap.resets.design.reset_curves import reset_curves
from cyclemap.resets.design.reset_demands import ResetDemands
from cyclemap.resets.design.reset_design import ResetDesign, design_reset
from cyclemap.resets.design.reset_ranking import ScoredReset
from cyclemap.resets.design.reset_trial import ResetTrial, reset_trial
from cyclemap.resets.protocol.protocol_file import write_protocol
from cyclemap.resets.protocol.schedule_file import write_schedule
from cyclemap.views import reset_sentences as sentences
from cyclemap.views.reset_page import reset_page
from cyclemap.views.robust_page import robust_page, wear_page
from cyclemap.views.sentences import material_line
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

COLUMNS = (
    "",
    "strategy",
    "TV",
    "after",
    "reached",
    "worth",
    "drag (mm)",
    "× own",
    "s",
    "room (mm)",
    "contact (mm)",
    "",
)


@dataclass(frozen=True)
class ResetRequest:
    """What is asked of `cyclemap reset` besides the loop, in the units of the command line."""

    allow_tv: float
    extra_tv: float
    within: int
    drag_ratio: float
    reach_mm: float | None
    seconds: float | None
    least_push_mm: float | None
    abilities: tuple[str, ...]
    keep_push: bool
    thoroughness: str | None
    pushes: int
    cycles: int
    seed: int
    out: Path
    picture_format: str
    beyond: BeyondRequest

    @property
    def demands(self) -> ResetDemands:
        """The demands in SI units."""
        reach = None if self.reach_mm is None else 1e-3 * self.reach_mm
        contact = None if self.least_push_mm is None else 1e-3 * self.least_push_mm
        kept = (self.allow_tv, self.extra_tv, self.within, self.drag_ratio)
        return ResetDemands(*kept, reach, self.seconds, self.abilities, contact)


@dataclass(frozen=True)
class ResetFiles:
    """Where the results are."""

    picture: Path
    protocol: Path
    schedule: Path
    json: Path
    robust: Path
    wear: Path

    @classmethod
    def of(cls, request: ResetRequest, material: str) -> ResetFiles:
        """Of a material's name, in the folder asked for."""
        stem = f"reset_{file_stem(material)}"
        shown = request.picture_format
        endings = (f".{shown}", ".toml", ".csv", ".json", f"_robust.{shown}", f"_wear.{shown}")
        return cls(*(request.out / f"{stem}{ending}" for ending in endings))


@dataclass(frozen=True, eq=False)
class ResetAnswers:
    """All that was found; None where it was not asked for."""

    design: ResetDesign
    robust: RobustAnswer | None
    wear: WearAnswer | None
    trial: ResetTrial | None

    def report(self, files: ResetFiles) -> Json:
        """As JSON."""
        told = reset_report(self.design, self.trial, files.protocol, files.schedule)
        beyond = {"robust": self.robust, "wear": self.wear}
        return {**told, **{name: one.report() for name, one in beyond.items() if one is not None}}


def run_reset(options: LoopOptions, request: ResetRequest, json_target: str | None) -> None:
    """Design the reset, try it, write picture, protocol, schedule and JSON, and print for people or as JSON."""
    demands = request.demands
    asked = chosen_collection(options)
    about = material_range(asked.loop, request.beyond, request.keep_push)
    wearing = wearing_loop(asked.loop, request.beyond, request.cycles)
    noise = WrappedNormal(DEFAULT_SIGMA if asked.sigma is None else asked.sigma)
    design, robust = _designed(asked, demands, noise, request), None
    if about is not None:
        with _Stages() as report:
            design, robust = made_robust(design, about, request.beyond, request.seed, report)
    worn = None if wearing is None else followed_under_wear(design, wearing, request.cycles)
    found = ResetAnswers(design, robust, worn, _tried(design, request))
    files = ResetFiles.of(request, design.loop.material.name)
    told = found.report(files)
    _write_files(found, noise, request, files)
    write_json(files.json, told)
    if not publish_json(told, json_target):
        _print_for_people(found, files)


def _designed(
    asked: ChosenCollection, demands: ResetDemands, noise: WrappedNormal, request: ResetRequest
) -> ResetDesign:
    """The design; a strategy that the protocol names is ranked with the others."""
    options: dict[str, Any] = {"keep_push": request.keep_push, "thoroughness": request.thoroughness or "normal"}
    given = () if asked.strategy is None else (asked.strategy,)
    with _Stages() as report:
        return design_reset(asked.loop, demands, noise, also=given, progress=report, **options)


def _tried(design: ResetDesign, request: ResetRequest) -> ResetTrial | None:
    if not request.pushes:
        return None
    with progress_bar(f"{request.pushes} pushes by the full mechanics") as report:
        return reset_trial(design.cache, design.chosen.candidate, request.pushes, seed=request.seed, progress=report)


def _write_files(found: ResetAnswers, noise: WrappedNormal, request: ResetRequest, files: ResetFiles) -> None:
    design = found.design
    strategy = design.chosen.candidate.strategy
    predicted = {**predicted_scores(design.chosen), **(found.robust.predicted() if found.robust else {})}
    write_protocol(files.protocol, design.loop, strategy, noise=noise, predicted=predicted)
    write_schedule(files.schedule, design.loop, strategy, request.cycles, request.seed)
    pages = {files.picture: reset_page(design, reset_curves(design, seed=request.seed), found.trial)}
    if found.robust is not None:
        pages[files.robust] = robust_page(found.robust.robust, found.robust.other)
    if found.wear is not None and found.wear.course is not None:
        pages[files.wear] = wear_page(found.wear.course, found.wear.allow_tv, found.wear.name)
    for path, page in pages.items():
        write_whole(path, render(page, request.picture_format))


class _Stages:
    """A bar for each stage of the work, one after the other, with its name."""

    def __init__(self) -> None:
        self._stack, self._stage = ExitStack(), ""

    def __enter__(self) -> _Stages:
        return self

    def __exit__(self, *_: object) -> None:
        self._stack.close()

    def __call__(self, stage: str, done: float) -> None:
        if stage != self._stage:
            self._stack.close()
            self._stage, self._report = stage, self._stack.enter_context(progress_bar(stage))
        self._report(done)


def _print_for_people(found: ResetAnswers, files: ResetFiles) -> None:
    console, design = PeopleConsole(), found.design
    console.print_table(ranking_table(design))
    for number, sentence in enumerate(sentences.reset_sentences(design)):
        console.print(sentence, style=None if number else "bold" if design.met else "bold red")
    if found.robust is not None:
        for number, sentence in enumerate(found.robust.told()):
            console.print(sentence, style=None if number else "bold" if found.robust.robust.holds else "bold red")
    if found.wear is not None:
        console.print(found.wear.told())
    if found.trial is not None:
        console.print(sentences.trial_sentence(found.trial))
    if told := material_line(design.loop.material):
        console.print(told)
    for name, path in _written(found, files):
        console.print(f"{name}: {path}")


def _written(found: ResetAnswers, files: ResetFiles) -> list[tuple[str, Path]]:
    """What people are told of the files."""
    named = [("picture", files.picture), ("protocol", files.protocol), ("schedule", files.schedule)]
    if found.robust is not None:
        named.insert(1, ("over the range", files.robust))
    if found.wear is not None and found.wear.course is not None:
        named.insert(-2, ("under wear", files.wear))
    return named


def ranking_table(design: ResetDesign) -> Table:
    """The ranking: what meets the demands first, then what misses them, then what needs more."""
    within, near = design.demands.within, design.demands.near_tv
    table = Table(
        title=f"Resets for {design.loop.material.name}",
        title_justify="left",
        caption=(
            f"TV: total variation of θ0's law from uniform; after: {within} pushes after the worst start; reached: "
            f"pushes until {near:g} from any start; worth: of 100 pushes; "
            "contact: the shortest of its pushes"
        ),
        caption_justify="left",
    )
    for number, column in enumerate(COLUMNS):
        table.add_column(column, justify="left" if number in (1, len(COLUMNS) - 1) else "right", no_wrap=True)
    for number, one in enumerate(design.ranking, 1):
        table.add_row(*_row(number, one), style="bold" if one is design.chosen else None)
    return table


def _row(number: int, one: ScoredReset) -> tuple[str, ...]:
    found, cost = one.numbers, one.cost
    worth = found.effective_per_100
    return (
        str(number),
        one.name,
        f"{found.tv:.4f}",
        f"{found.tv_after:.4f}",
        found.reach_words,
        "–" if not math.isfinite(worth) else f"{worth:.1f}" if worth < 999 else "> 999",
        f"{1000 * cost.mean_drag_length:.1f}",
        f"{one.drag_ratio:.2f}",
        f"{cost.mean_seconds:.1f}",
        f"{1000 * cost.reach:.0f}",
        f"{1000 * one.contact:.0f}",
        sentences.standing(one),
    )
