"""`cyclemap fit`: laws fitted to measured pushes, in tables and sentences, as JSON, and as a picture of each set."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from cyclemap.cli.fit_report import fit_report, law_table, set_report, statistics_table
from cyclemap.cli.output import file_stem, progress_bar, publish_json, write_json
from cyclemap.cli.terminal import PeopleConsole
from cyclemap.errors import CycleMapError, InvalidInput
from cyclemap.evidence import PushTable, UnreadableFile, load_pushes
from cyclemap.evidence.tables.push_sets import PushSet, push_sets
from cyclemap.evidence.tables.set_fit import SetFit, fit_set
from cyclemap.plain_text import plain_number
from cyclemap.suggestions import unknown_name
from cyclemap.views.fit_page import fit_page
from cyclemap.views.fit_sentences import set_sentences
from cyclemap.views.style import render
from cyclemap.whole_files import write_whole

# Bad files are told by name up to this many, and counted beyond.
MOST_NAMED = 10
SELECT_KEYS = {
    "surface": ("surface", None),
    "object": ("object", None),
    "shape": ("object", None),
    "speed_mm_s": ("speed", 1e-3),
    "side": ("side", 1.0),
    "fraction": ("fraction", 1.0),
    "angle_deg": ("angle", math.radians(1.0)),
}


@dataclass(frozen=True)
class FitRequest:
    """What is asked of the fit: which pushes, which laws, and where results go."""

    select: tuple[str, ...]
    harmonics: int | None
    wear: bool
    seed: int
    out: Path
    picture_format: str


def run_fit(data: Path, request: FitRequest, json_target: str | None) -> None:
    """Read the pushes, fit every set of them, write pictures and JSON, and print for people or as JSON."""
    chosen = selected_values(request.select)
    with progress_bar(f"reading {data.name}") as report:
        pushes = load_pushes(data, progress=report)
    _check_readable(data, pushes)
    fits = _fit_all(push_sets(pushes, chosen), request)
    pictures = [_write(fit, request) for fit in fits if not fit.is_empty]
    if not publish_json(fit_report(pushes, fits), json_target):
        _print_for_people(pushes, fits, pictures)


def selected_values(pairs: tuple[str, ...]) -> dict[str, str | float]:
    """The columns and values of `key=value` texts, in SI units and radians; `shape` is another word for `object`.

    >>> selected_values(("surface=plywood", "speed_mm_s=20"))
    {'surface': 'plywood', 'speed': 0.02}
    """
    values: dict[str, str | float] = {}
    for pair in pairs:
        key, equals, text = (part.strip() for part in pair.partition("="))
        if not (key and equals and text):
            raise InvalidInput(f"--select {pair!r} is not of the form key=value")
        if key not in SELECT_KEYS:
            raise unknown_name("selection", key, SELECT_KEYS)
        column, unit = SELECT_KEYS[key]
        values[column] = text if unit is None else unit * _finite(key, text)
    return values


def _finite(key: str, text: str) -> float:
    try:
        value = plain_number(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise InvalidInput(f"--select {key}={text}: give a finite number")
    return value


def _check_readable(data: Path, pushes: PushTable) -> None:
    if len(pushes.table):
        return
    if pushes.unreadable:
        raise CycleMapError(f"{data}: no push could be read: {reasons_of(pushes.unreadable)}")
    raise InvalidInput(f"{data}: holds {len(pushes.scans)} friction scans and no push; give pushes to fit")


def reasons_of(left_out: Sequence[UnreadableFile]) -> str:
    """Why files were left out, the first of them by name, the others counted."""
    told = "; ".join(f"{file.path}: {file.reason}" for file in left_out[:MOST_NAMED])
    return told + (f"; and {len(left_out) - MOST_NAMED} more" if len(left_out) > MOST_NAMED else "")


def _fit_all(sets: tuple[PushSet, ...], request: FitRequest) -> list[SetFit]:
    fits = []
    with progress_bar("fitting") as report:
        for done, pushes in enumerate(sets):

            def share(fraction: float, before: int = done) -> None:
                report((before + fraction) / len(sets))

            options = {"harmonics": request.harmonics, "wear": request.wear, "seed": request.seed}
            fits.append(fit_set(pushes, progress=share, **options))  # type: ignore[arg-type]
    return fits


def _write(fit: SetFit, request: FitRequest) -> Path:
    """Write the page and the report of one set; returns the picture's path."""
    stem = f"fit_{file_stem(fit.pushes.name)}"
    write_json(request.out / f"{stem}.json", set_report(fit))
    picture = request.out / f"{stem}.{request.picture_format}"
    write_whole(picture, render(fit_page(fit), request.picture_format))
    return picture


def _print_for_people(pushes: PushTable, fits: list[SetFit], pictures: list[Path]) -> None:
    console = PeopleConsole()
    scans = f" and {len(pushes.scans)} friction scans" if len(pushes.scans) else ""
    console.print(f"{len(pushes.table)} pushes{scans} read, in {len(fits)} set{'s' * (len(fits) != 1)}", style="bold")
    for file in pushes.unreadable[:MOST_NAMED]:
        console.print(f"could not be read: {file.path}: {file.reason}")
    if len(pushes.unreadable) > MOST_NAMED:
        console.print(f"could not be read: {len(pushes.unreadable)} files in all")
    if any(fit.pushes.has_motion for fit in fits):
        for table in (statistics_table([fit.statistics for fit in fits]), law_table([fit.laws for fit in fits])):
            console.print_table(table)
    for fit in fits:
        if not fit.is_empty:
            console.print("\n".join(set_sentences(fit)))
    if not pictures:
        console.print("nothing could be fitted: no set has enough pushes")
    for picture in pictures:
        console.print(f"picture: {picture}")
