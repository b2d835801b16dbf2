"""`cyclemap identify`: from measured data to a material file, with tables, sentences, JSON and a picture."""

import math
import shlex
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from cyclemap.cli.command_identify import IdentifyRequest
from cyclemap.cli.identify_report import derived_table, error_table, identify_report, parameter_table
from cyclemap.cli.json_report import json_text
from cyclemap.cli.options import LoopOptions
from cyclemap.cli.output import file_stem, progress_bar, publish_json
from cyclemap.cli.run_fit import selected_values
from cyclemap.cli.settings import chosen_loop
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.collection.collection_file import collection_text
from cyclemap.collection.found_with import with_material
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.loop_settings import loop_tables
from cyclemap.collection.setting_table import NOISE_KEY
from cyclemap.errors import ConvergenceError, InvalidInput
from cyclemap.evidence.data_blocks.collected_blocks import CollectedBlocks, collected_blocks, telling_parameters
from cyclemap.evidence.identification.derived_quantities import Derived, derived_quantities
from cyclemap.evidence.identification.identification import Identification
from cyclemap.evidence.identification.identify import identify
from cyclemap.evidence.identification.parameter_space import ParameterSpace
from cyclemap.evidence.identification.priors import usual_beliefs
from cyclemap.evidence.identification.starting_space import starting_space
from cyclemap.evidence.identified.identified_curves import identified_curves
from cyclemap.evidence.identified.identified_material import identified_material
from cyclemap.mechanics import Material, load_material
from cyclemap.mechanics.material_text import material_toml
from cyclemap.plain_text import plain_number
from cyclemap.views import identify_page as sentences
from cyclemap.views.identify_page import identify_page
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole


@dataclass(frozen=True, eq=False)
class Outcome:
    """All that an identification came to."""

    data: CollectedBlocks
    found: Identification
    derived: tuple[Derived, ...]
    material: Material


def run_identify(data: Sequence[Path], request: IdentifyRequest, json_target: str | None) -> None:
    """Read the data, identify the surface, write material, JSON and picture, and print for people or as JSON."""
    outcome = _outcome(data, request)
    told = identify_report(outcome.material, outcome.data.notes, outcome.found, outcome.derived)
    files = _files(outcome, request, json_text(told).encode())
    for path, content in files.items():
        write_whole(path, content)
    if not publish_json(told, json_target):
        _print_for_people(outcome, list(files))


def _outcome(data: Sequence[Path], request: IdentifyRequest) -> Outcome:
    start = None if request.start is None else load_material(request.start)
    fixed, loop, select = fixed_values(request.fix), _loop(data, request), selected_values(request.select)
    space = starting_space(loop, start)
    choices: dict[str, Any] = {name: getattr(request, name) for name in ("first", "wear", "most")}
    with progress_bar("reading") as report:
        collected = collected_blocks(data, loop, select, progress=report, **choices)
    found = _identified(collected, request, space, fixed)
    if not found.converged:
        raise ConvergenceError(f"no start converged: {found.fit.message}; take more --starts, or free fewer parameters")
    name = request.name or f"{collected.surface or select.get('surface', 'surface')}-identified"
    since = f" from cycle {request.first} on" if request.first else ""
    sources = [f"{path.name}{since}" for path in data]
    material = identified_material(found, name, sources, collected.last_cycle, collected.loop.slider.name)
    return Outcome(collected, found, derived_quantities(found, seed=request.seed), material)


def fixed_values(pairs: tuple[str, ...]) -> dict[str, float]:
    """The values of `name=value` texts.

    >>> fixed_values(("pusher_friction=0.15",))
    {'pusher_friction': 0.15}
    """
    values = {}
    for pair in pairs:
        name, _, text = (part.strip() for part in pair.partition("="))
        try:
            values[name] = plain_number(text)
        except ValueError as cause:
            raise InvalidInput(f"--fix {pair!r} is not of the form name=number") from cause
    return values


def _loop(data: Sequence[Path], request: IdentifyRequest) -> CollectionLoop:
    """The experiment of the data, its surface isotropic: the noise is estimated, whatever a file says of it."""
    if any(pair.partition("=")[0].strip() == NOISE_KEY for pair in request.settings):
        raise InvalidInput("noise_deg: the noise is estimated from the data; leave the setting out")
    return chosen_loop(LoopOptions("isotropic", request.protocol, request.settings), data[0])[0]


def _identified(
    data: CollectedBlocks, request: IdentifyRequest, space: ParameterSpace, fixed: dict[str, float]
) -> Identification:
    free = tuple(name.strip() for name in (request.free or "").split(",") if name.strip())
    free = free or tuple(name for name in telling_parameters(data.blocks) if name not in fixed)
    groups = sum(len(set(block.groups.tolist())) for block in data.blocks)
    folds = request.folds if request.folds is not None else min(5, groups) if groups > 1 else 0
    held = {name: value for name, value in fixed.items() if name not in free}
    with progress_bar("identifying") as report:
        return identify(
            data.blocks,
            free,
            held,
            priors={} if request.no_priors else usual_beliefs(free),
            folds=folds,
            starts=request.starts,
            student=None if request.student == math.inf else request.student,
            seed=request.seed,
            space=space,
            progress=report,
        )


def _files(outcome: Outcome, request: IdentifyRequest, report: bytes) -> dict[Path, bytes]:
    """Every file with its content, all of it made before the first is written."""
    stem = file_stem(outcome.material.name)
    curves = identified_curves(outcome.found, outcome.data.scans, request.seed)
    words = sentences.page_sentences(outcome.found)
    page = identify_page(sentences.headline(outcome.material.name, outcome.derived), outcome.found, curves, words)
    return {
        request.out / f"{stem}.toml": _material_text(outcome).encode(),
        request.out / f"identify_{stem}.json": report,
        request.out / f"identify_{stem}.{request.picture_format}": render(page, request.picture_format),
    }


def _material_text(outcome: Outcome) -> str:
    """The material and, where the experiment is not MIT's own, the object, push and ring that it was found with."""
    loop = with_material(outcome.data.loop, outcome.material)
    if loop_tables(loop) == loop_tables(CollectionLoop.mit(outcome.material)):
        return material_toml(outcome.material)
    return collection_text(loop)


def _print_for_people(outcome: Outcome, files: list[Path]) -> None:
    console = PeopleConsole()
    console.print(sentences.headline(outcome.material.name, outcome.derived), style="bold")
    for note in outcome.data.notes:
        console.print(f"data: {note}")
    console.print_table(parameter_table(outcome.found))
    if outcome.derived:
        console.print_table(derived_table(outcome.derived))
    console.print_table(error_table(outcome.found))
    for sentence in sentences.note_sentences(outcome.found):
        console.print(sentence)
    material, _, picture = files
    console.print(f"picture: {picture}")
    console.print(f"material: {material}")
    console.print(f"next: cyclemap portrait {shlex.quote(str(material))}")
