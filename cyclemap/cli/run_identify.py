"""`cyclemap identify`: from measured data to a material file, with tables, sentences, JSON and a
picture.
"""

import math
import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import click
from rich.table import Table

from cyclemap.cli.json_report import json_text
from cyclemap.cli.options import ResultOptions, TableOptions, pair_in_metres, readable_tables
from cyclemap.cli.output import PeopleConsole, file_stem, people_table, progress_bar, publish_json
from cyclemap.cli.run_fit import selected_values
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import ConvergenceError, CycleMapError, InvalidInput
from cyclemap.evidence.data_blocks.collected_blocks import (
    CollectedBlocks,
    collected_blocks,
    telling_parameters,
)
from cyclemap.evidence.identification.identify import Estimate, Identification, KindErrors, identify
from cyclemap.evidence.identification.known_floor import (
    FLOOR_TOLD,
    held_values,
    known_beliefs,
    known_shapes,
    known_spread,
)
from cyclemap.evidence.identification.surface_parameters import (
    ParameterSpace,
    starting_space,
)
from cyclemap.evidence.identified_material import (
    Derived,
    derived_quantities,
    identified_curves,
    identified_material,
)
from cyclemap.evidence.identified_words import implausible, readable_kind, readable_unit
from cyclemap.mechanics import Material, load_material
from cyclemap.mechanics.material import FLOOR_SHAPE_KEYS, SPREAD_KEYS, shape_numbers
from cyclemap.mechanics.material_text import load_plates, material_toml
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.protocol.collection_file import collection_tables, collection_text
from cyclemap.protocol.setting_table import NOISE_KEY
from cyclemap.text_files import write_whole
from cyclemap.views.identify_page import headline, identify_page, note_sentences, page_sentences
from cyclemap.views.panels.layout import render
from cyclemap.written import Json, Unit, json_of, written

_SIZES = (
    *("mean", "median", "rms", "left_out_mean", "left_out_median", "left_out_rms"),
    *("isotropic_mean", "isotropic_median"),
)
NOTHING = "–"


@dataclass(frozen=True)
class IdentifyOptions:
    """What `cyclemap identify` was asked, as it was typed."""

    data: tuple[Path, ...]
    table: TableOptions
    select: tuple[str, ...]
    protocol: Path | None
    settings: tuple[str, ...]
    first: int
    most: int
    start: str | None
    floor: str | None
    plate: tuple[str, ...]
    target_mm: str | None
    free: str | None
    fix: tuple[str, ...]
    wear: bool
    no_priors: bool
    folds: int | None
    student: float
    starts: int
    seed: int
    name: str | None
    force: bool
    results: ResultOptions


def run_identify(asked: IdentifyOptions) -> None:
    """Read the data, identify the surface, write material, JSON and picture, and print for people
    or as JSON.
    """
    if any(pair.partition("=")[0].strip() == NOISE_KEY for pair in asked.settings):
        raise InvalidInput("noise_deg: the noise is estimated from the data; leave the setting out")
    if asked.floor is not None and asked.start is not None:
        raise InvalidInput(
            "--floor tells what is known, and where the search begins: leave --start out"
        )
    begin = asked.start if asked.floor is None else asked.floor
    surface, fixed = None if begin is None else load_material(begin), fixed_values(asked.fix)
    known = None if asked.floor is None else surface
    target = None if asked.target_mm is None else pair_in_metres("--target-mm", asked.target_mm)
    shapes = tuple(shape for plate in asked.plate for shape in load_plates(plate))
    options = LoopOptions("isotropic", asked.protocol, asked.settings)
    selected, chosen = selected_values(asked.select), chosen_loop(options, asked.data[0])
    loop = chosen.loop
    read = readable_tables(asked.data, asked.table, asked.results.out)
    space = starting_space(loop, surface)
    with progress_bar("reading") as report:
        collected = collected_blocks(
            read,
            loop,
            selected,
            first=asked.first,
            wear=asked.wear,
            most=asked.most,
            progress=report,
            push_length=loop.push.distance if "push_mm" in chosen.settings else None,
            population=known is not None,
            target=target,
        )
    fixed |= known_shapes(shapes, collected.blocks, collected.loop.slider.name)
    found = _identified(asked, collected, fixed, known, space)
    doubtful = _is_doubtful(found, collected, asked.force)
    since = f" from cycle {asked.first} on" if asked.first else ""
    sources = [f"{path.name}{since}" for path in read]
    default = collected.surface or selected.get("surface", "surface")
    name = asked.name or f"{default}-identified"
    plate_name, last = collected.loop.slider.name, collected.last_cycle
    material = identified_material(found, name, sources, last, plate_name, floor=known)
    _conclude(collected, found, material, doubtful, asked)


def _is_doubtful(found: Identification, collected: CollectedBlocks, force: bool) -> bool:
    """Whether the answer cannot be right, which is said; CycleMapError, unless `force`, where it
    is.
    """
    doubts = implausible(found, collected.loop.slider.outline.extent)
    if doubts and not force:
        why = "; ".join((*doubts, *(f"data: {note}" for note in collected.notes)))
        mend = "look at object, push, units and --angles; with --force it is written all the same"
        raise CycleMapError(f"no material is written, for this cannot be right: {why}: {mend}")
    for words in doubts:
        click.echo(f"warning: this cannot be right: {words}", err=True)
    return bool(doubts)


def _identified(
    asked: IdentifyOptions,
    collected: CollectedBlocks,
    fixed: Mapping[str, float],
    known: Material | None,
    space: ParameterSpace,
) -> Identification:
    """Identify what was asked for, or else what the data tell, and is not fixed."""
    blocks, plate = collected.blocks, collected.loop.slider.name
    named = tuple(name.strip() for name in (asked.free or "").split(",") if name.strip())
    believed = None if known is None else known_beliefs(known, FLOOR_TOLD)
    named = named or tuple(
        name for name in telling_parameters(blocks, believed) if name not in fixed
    )
    held = held_values(blocks, space, named, known)
    beliefs = collected.beliefs(named) | known_beliefs(known, named, plate)
    groups = sum(len(set(block.groups.tolist())) for block in blocks)
    usual_folds = min(5, groups) if groups > 1 else 0
    with progress_bar("identifying") as report:
        found = identify(
            blocks,
            named,
            held | {key: at for key, at in fixed.items() if key not in named},
            priors={} if asked.no_priors else beliefs,
            noise={**collected.noise, **known_spread(known, blocks)},
            folds=usual_folds if asked.folds is None else asked.folds,
            starts=asked.starts,
            student=None if asked.student == math.inf else asked.student,
            seed=asked.seed,
            space=space,
            progress=report,
        )
    if not found.fit.converged:
        raise ConvergenceError(
            f"no start converged: {found.fit.message}; take more --starts, or free fewer parameters"
        )
    return found


def _conclude(
    data: CollectedBlocks,
    found: Identification,
    material: Material,
    doubtful: bool,
    asked: IdentifyOptions,
) -> None:
    results, seed = asked.results, asked.seed
    derived, stem = derived_quantities(found, seed=seed), file_stem(material.name)
    told = identify_report(material, data.notes, found, derived)
    answer = headline(material.name, derived, found.friction())
    # The material file names object, push and ring that it was found with where these are not MIT's
    # own.
    loop = data.loop.with_material(material)
    is_mit = collection_tables(loop) == collection_tables(CollectionLoop.mit(material))
    page = identify_page(
        answer, found, identified_curves(found, data.scans, seed), page_sentences(found)
    )
    toml = results.out / f"{stem}.toml"
    picture = results.out / f"identify_{stem}.{results.picture_format}"
    # All of the content is made before the first file is written.
    files = {
        toml: (material_toml(material) if is_mit else collection_text(loop)).encode(),
        results.out / f"identify_{stem}.json": json_text(told).encode(),
        picture: render(page, results.picture_format),
    }
    for path, content in files.items():
        write_whole(path, content)
    if publish_json(told, results.json_target):
        return
    PeopleConsole().tell(
        answer,
        *(f"data: {note}" for note in data.notes),
        parameter_table(found),
        derived_table(derived) if derived else "",
        error_table(found),
        *note_sentences(found),
        f"picture: {picture}",
        f"material: {toml}",
        "" if doubtful else f"next: cyclemap portrait {shlex.quote(str(toml))}",
    )


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


def identify_report(
    material: Material, data: Sequence[str], found: Identification, derived: Sequence[Derived]
) -> Json:
    """The report of an identification."""
    wear, starts = material.wear, found.starts
    spread = dict(zip(SPREAD_KEYS, material.session_spread, strict=True))
    return {
        **json_of(material, "name", "provenance", "misfit", "inferred", "friction"),
        "worn": None if wear is None else {"cycles": wear.cycles, **json_of(wear.friction)},
        "converged": found.fit.converged,
        "level": found.level,
        "parameters": [
            {**_in_its_unit(estimate), "at_bound": estimate.at_bound or None}
            for estimate in found.estimates
        ],
        "plates": {plate.plate: written(plate.numbers) for plate in material.plates},
        "floor_shape": written(shape_numbers(material.floor, FLOOR_SHAPE_KEYS)),
        "sessions": {
            session.name: written(shape_numbers(session.shape, FLOOR_SHAPE_KEYS))
            for session in material.sessions
        },
        "session_spread": written(spread),
        "priors": written(found.priors),
        "held": written(dict(sorted(found.problem.fixed.items()))),
        "derived": [*map(_in_its_unit, derived)],
        "errors": [*map(_error, found.errors)],
        "starts": {**json_of(starts, "count", "arrived"), "failed": len(starts.failures)},
        "notes": list(found.notes),
        "data": list(data),
    }


def _in_its_unit(result: Estimate | Derived) -> Json:
    unit = readable_unit(result.unit)
    return {**json_of(result, unit=Unit("", unit.of_si)), "unit": unit.ending or "1"}


def _error(error: KindErrors) -> Json:
    kind, unit = readable_kind(error.kind)
    told = json_of(error, "rows", *_SIZES, unit=Unit("", unit.of_si))
    return {"block": error.block, "kind": kind, "unit": unit.ending or "1", **told}


def parameter_table(found: Identification) -> Table:
    """Every parameter that the data were asked about: identified with its interval, or held."""
    rows: list[tuple[str, ...]] = []
    for estimate in found.lasting:
        unit = readable_unit(estimate.unit)
        lower = _digits(unit.of_si(estimate.lower)) + "*" * estimate.lower_open
        upper = _digits(unit.of_si(estimate.upper)) + "*" * estimate.upper_open
        interval = f"{lower} to {upper}" if estimate.identifiable else "not identifiable"
        value = f"{_digits(unit.of_si(estimate.value))}{unit.sign}"
        rows.append((estimate.name, value, interval, estimate.description))
    rows += [
        (name, _digits(held), "held", "") for name, held in sorted(found.problem.fixed.items())
    ]
    columns = ("name", "value", f"{100.0 * found.level:g} % interval", "what it is")
    table = people_table("Parameters", columns, rows, words=(0, 3))
    if any(one.identifiable and (one.lower_open or one.upper_open) for one in found.estimates):
        table.caption = "* a bound of the parameter, not excluded by the data"
    return table


def derived_table(derived: Sequence[Derived]) -> Table:
    """What follows from the parameters."""
    rows = []
    for quantity in derived:
        unit = readable_unit(quantity.unit)
        value = f"{_digits(unit.of_si(quantity.value))}{unit.sign}"
        lower, upper = (_digits(unit.of_si(end)) for end in (quantity.lower, quantity.upper))
        interval = f"{lower} to {upper}" if quantity.known else "any"
        rows.append((quantity.name.replace("_", " "), value, interval, quantity.description))
    return people_table(
        "It follows", ("name", "value", "interval", "what it is"), rows, words=(0, 3)
    )


def error_table(found: Identification) -> Table:
    """How far predictions lie from the data: in the sample, left out, and those of isotropic
    friction.
    """
    columns = (
        "data",
        "error",
        "values",
        "mean",
        "median",
        "mean, left out",
        "median",
        "mean, isotropic",
        "median",
    )
    rows = []
    for error in found.errors:
        kind, unit = readable_kind(error.kind)
        sizes = [getattr(error, name) for name in _SIZES if not name.endswith("rms")]
        told = [
            f"{_digits(unit.of_si(size))}{unit.sign}" if math.isfinite(size) else NOTHING
            for size in sizes
        ]
        rows.append((error.block, kind, str(error.rows), *told))
    table = people_table("Errors, predicted less measured", columns, rows, words=(0, 1))
    table.caption = (
        "isotropic: the same friction all around, floor and plate flat, nothing identified"
    )
    return table


def _digits(value: float) -> str:
    """Three digits, or as many decimals as make sense for a number of this size; less than a
    millionth is none.
    """
    if not math.isfinite(value):
        return NOTHING
    if abs(value) < 1e-6:
        return "0"
    return f"{value:.1f}" if abs(value) >= 100.0 else f"{value:.3g}".replace("e-0", "e-")
