"""`cyclemap identify`: from measured data to a material file, with tables, sentences, JSON and a
picture.
"""

import math
import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path

import click
from rich.table import Table

from cyclemap.cli.collected.readable_data import readable_tables, selected_values
from cyclemap.cli.commands import IdentifyOptions
from cyclemap.cli.options import pair_in_metres, words_of
from cyclemap.cli.output import file_stem, people_table, progress_bar, publish
from cyclemap.collection.loop import CollectionLoop
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence.identification.collected_blocks import (
    CollectedBlocks,
    collected_blocks,
)
from cyclemap.evidence.identification.identify import Identification, KindErrors, NamedInterval
from cyclemap.evidence.identification.known_floor import identify_collected, known_shapes
from cyclemap.evidence.identification.surface_parameters import ParameterSpace, starting_space
from cyclemap.evidence.identified_material import (
    Derived,
    derived_quantities,
    identified_curves,
    identified_material,
)
from cyclemap.evidence.identified_words import far_places, implausible, readable_kind
from cyclemap.evidence.tables.columns import Selection
from cyclemap.mechanics import Material, load_material
from cyclemap.mechanics.material import FLOOR_SHAPE_KEYS, SPREAD_KEYS, shape_numbers
from cyclemap.mechanics.material_text import load_plates, material_toml
from cyclemap.plain_text import key_and_value, plain_number
from cyclemap.protocol.chosen_loop import ChosenCollection, chosen_loop
from cyclemap.protocol.collection_file import collection_tables, collection_text
from cyclemap.protocol.settings import NOISE_KEY
from cyclemap.views.identify_page import headline, identify_page, note_sentences, page_sentences
from cyclemap.written import Json, Unit, json_of, written

_SIZES = (
    *("mean", "median", "rms", "left_out_mean", "left_out_median", "left_out_rms"),
    *("isotropic_mean", "isotropic_median"),
)
NOTHING = "–"


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
    surface = None if begin is None else load_material(begin)
    known = None if asked.floor is None else surface
    fixed = fixed_values(asked.fix)
    shapes = tuple(shape for plate in asked.plate for shape in load_plates(plate))
    selected = selected_values(asked.select)
    chosen = chosen_loop("isotropic", asked.protocol, asked.settings, asked.data[0])
    read = readable_tables(asked.data, asked.table, asked.results.out)
    space = starting_space(chosen.loop, surface)
    collected = _collected(asked, chosen, read, selected, population=known is not None)
    fixed |= known_shapes(shapes, collected.blocks, collected.loop.slider.name)
    identified = _identified(asked, collected, known, fixed, space)
    doubtful = _is_doubtful(identified, collected, asked.force)
    since = f" from cycle {asked.first} on" if asked.first else ""
    material = identified_material(
        identified,
        asked.name or f"{collected.surface or selected.get('surface', 'surface')}-identified",
        [f"{path.name}{since}" for path in read],
        collected.last_cycle,
        collected.loop.slider.name,
        floor=known,
    )
    _conclude(collected, identified, material, doubtful, asked)


def _collected(
    asked: IdentifyOptions,
    chosen: ChosenCollection,
    read: Sequence[Path],
    selected: Selection,
    population: bool,
) -> CollectedBlocks:
    """The blocks of all data; population : whether the floor is one of which something is known."""
    target = None if asked.target_mm is None else pair_in_metres("--target-mm", asked.target_mm)
    with progress_bar("reading") as report:
        return collected_blocks(
            read,
            chosen.loop,
            selected,
            first=asked.first,
            wear=asked.wear,
            most=asked.most,
            progress=report,
            push_length=chosen.loop.push.distance if "push_mm" in chosen.settings else None,
            population=population,
            target=target,
        )


def _identified(
    asked: IdentifyOptions,
    collected: CollectedBlocks,
    known: Material | None,
    fixed: Mapping[str, float],
    space: ParameterSpace,
) -> Identification:
    """What explains the data, as far as it is not known or fixed."""
    groups = sum(len(set(block.groups.tolist())) for block in collected.blocks)
    usual_folds = min(5, groups) if groups > 1 else 0
    with progress_bar("identifying") as report:
        return identify_collected(
            collected,
            known,
            fixed,
            space,
            free=words_of(asked.free or ""),
            believes=not asked.no_priors,
            folds=usual_folds if asked.folds is None else asked.folds,
            starts=asked.starts,
            student=None if asked.student == math.inf else asked.student,
            seed=asked.seed,
            progress=report,
        )


def _is_doubtful(identified: Identification, collected: CollectedBlocks, force: bool) -> bool:
    """Whether the answer cannot be right, which is said; CycleMapError, unless `force`, where it
    is.
    """
    reach = collected.loop.slider.outline.extent
    doubts = implausible(identified, reach)
    if doubts and not force:
        why = "; ".join((*doubts, *(f"data: {note}" for note in collected.notes)))
        mend = "look at object, push, units and --angles; with --force it is written all the same"
        raise CycleMapError(f"no material is written, for this cannot be right: {why}: {mend}")
    for words in doubts:
        click.echo(f"warning: this cannot be right: {words}", err=True)
    for words in far_places(identified, reach):
        click.echo(f"warning: {words}", err=True)
    return bool(doubts)


def _conclude(
    data: CollectedBlocks,
    identified: Identification,
    material: Material,
    doubtful: bool,
    asked: IdentifyOptions,
) -> None:
    results = asked.results
    seed = asked.seed
    derived = derived_quantities(identified, seed=seed)
    stem = file_stem(material.name)
    answer = headline(material.name, derived, identified.friction())
    # The material file names object, push and ring that it was found with where these are not MIT's
    # own.
    loop = data.loop.with_material(material)
    is_mit = collection_tables(loop) == collection_tables(CollectionLoop.mit(material))
    page = identify_page(
        answer,
        identified,
        identified_curves(identified, data.scans, seed),
        page_sentences(identified),
    )
    toml = results.out / f"{stem}.toml"
    text = material_toml(material) if is_mit else collection_text(loop)
    publish(
        identify_report(material, data.notes, identified, derived),
        page,
        results,
        f"identify_{stem}",
        answer,
        *(f"data: {note}" for note in data.notes),
        parameter_table(identified),
        derived_table(derived) if derived else "",
        error_table(identified),
        *note_sentences(identified),
        after=(
            f"material: {toml}",
            "" if doubtful else f"next: cyclemap portrait {shlex.quote(str(toml))}",
        ),
        beside={toml: text.encode()},
    )


def fixed_values(pairs: tuple[str, ...]) -> dict[str, float]:
    """The values of `name=value` texts.

    >>> fixed_values(("pusher_friction=0.15",))
    {'pusher_friction': 0.15}
    """
    values = {}
    for pair in pairs:
        name, text = key_and_value("--fix", pair, "name=number")
        try:
            values[name] = plain_number(text)
        except ValueError as cause:
            raise InvalidInput(f"--fix {pair!r} is not of the form name=number") from cause
    return values


def identify_report(
    material: Material, data: Sequence[str], identified: Identification, derived: Sequence[Derived]
) -> Json:
    """The report of an identification."""
    wear = material.wear
    starts = identified.starts
    return {
        **json_of(material, "name", "provenance", "misfit", "inferred", "friction"),
        "worn": None if wear is None else {"cycles": wear.cycles, **json_of(wear.friction)},
        "converged": identified.fit.converged,
        "level": identified.level,
        "parameters": [
            {**_in_its_unit(estimate), "at_bound": estimate.at_bound or None}
            for estimate in identified.estimates
        ],
        "plates": {plate.plate: written(plate.numbers) for plate in material.plates},
        "floor_shape": written(shape_numbers(material.floor, FLOOR_SHAPE_KEYS)),
        "sessions": {
            session.name: written(shape_numbers(session.shape, FLOOR_SHAPE_KEYS))
            for session in material.sessions
        },
        "session_spread": written(dict(zip(SPREAD_KEYS, material.session_spread, strict=True))),
        "priors": written(identified.priors),
        "held": written(dict(sorted(identified.problem.fixed.items()))),
        "derived": [*map(_in_its_unit, derived)],
        "errors": [*map(_error, identified.errors)],
        "starts": {**json_of(starts, "count", "arrived"), "failed": len(starts.failures)},
        "notes": list(identified.notes),
        "data": list(data),
    }


def _in_its_unit(result: NamedInterval) -> Json:
    unit = result.readable[0]
    return {**json_of(result, unit=Unit("", unit.of_si)), "unit": unit.ending or "1"}


def _error(error: KindErrors) -> Json:
    kind, unit = readable_kind(error.kind)
    return {
        "block": error.block,
        "kind": kind,
        "unit": unit.ending or "1",
        **json_of(error, "rows", *_SIZES, unit=Unit("", unit.of_si)),
    }


def parameter_table(identified: Identification) -> Table:
    """Every parameter that the data were asked about: identified with its interval, or held."""
    rows: list[tuple[str, ...]] = []
    for estimate in identified.lasting:
        value, lower, upper = _readable(estimate)
        interval = f"{lower}{'*' * estimate.lower_open} to {upper}{'*' * estimate.upper_open}"
        known = interval if estimate.identifiable else "not identifiable"
        rows.append((estimate.name, value, known, estimate.description))
    for name, held in sorted(identified.problem.fixed.items()):
        rows.append((name, _digits(held), "held", ""))
    columns = ("name", "value", f"{100.0 * identified.level:g} % interval", "what it is")
    table = people_table("Parameters", columns, rows, words=(0, 3))
    estimates = [estimate for estimate in identified.estimates if estimate.identifiable]
    if any(estimate.lower_open or estimate.upper_open for estimate in estimates):
        table.caption = "* a bound of the parameter, not excluded by the data"
    return table


def derived_table(derived: Sequence[Derived]) -> Table:
    """What follows from the parameters."""
    rows = []
    for quantity in derived:
        value, lower, upper = _readable(quantity)
        interval = f"{lower} to {upper}" if quantity.known else "any"
        rows.append((quantity.name.replace("_", " "), value, interval, quantity.description))
    return people_table(
        "It follows", ("name", "value", "interval", "what it is"), rows, words=(0, 3)
    )


def _readable(result: NamedInterval) -> tuple[str, str, str]:
    """A value with its unit, and the ends of its interval."""
    unit, *numbers = result.readable
    value, lower, upper = map(_digits, numbers)
    return f"{value}{unit.sign}", lower, upper


def error_table(identified: Identification) -> Table:
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
    for error in identified.errors:
        kind, unit = readable_kind(error.kind)
        sizes = [getattr(error, name) for name in _SIZES if not name.endswith("rms")]
        cells = [
            f"{_digits(unit.of_si(size))}{unit.sign}" if math.isfinite(size) else NOTHING
            for size in sizes
        ]
        rows.append((error.block, kind, str(error.rows), *cells))
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
