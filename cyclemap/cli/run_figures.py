"""`cyclemap figures`: what there is, and each of it made, written, captioned and told."""

import csv
import io
from dataclasses import dataclass, field
from pathlib import Path

from cyclemap.cli.commands import FiguresOptions
from cyclemap.cli.options import ResultOptions
from cyclemap.cli.output import (
    PeopleConsole,
    Told,
    people_table,
    progress_bar,
    publish_json,
    write_json,
)
from cyclemap.errors import CycleMapError, DataFileError
from cyclemap.figures import NO_DATA, Entry, MeasuredFolder, entries, load_exhibit
from cyclemap.plain_text import typeset
from cyclemap.text_files import only_writer, read_json, write_whole
from cyclemap.written import Json, json_of, written

INDEX_FILE = "figures.json"
_KEYS = ("name", "title", "source", "caption", "file", "measured")


@dataclass(frozen=True)
class WatchedFolder(MeasuredFolder):  # type: ignore[misc]
    """Measured data that remember what was asked for and, of that, what was there (names within the
    folder).
    """

    asked: list[str] = field(default_factory=list)
    there: list[str] = field(default_factory=list)

    def find(self, name: str) -> Path | None:
        """Return the path of the file or sub-folder `name` in the folder; None where it is not
        there.
        """
        path: Path | None = super().find(name)
        self.asked.append(name)
        if path is not None and name not in self.there:
            self.there.append(name)
        return path


def list_figures(results: ResultOptions) -> None:
    """Tell the names of all exhibits with their sources and titles; no exhibit is imported."""
    if publish_json({"figures": written(entries())}, results.json):
        return
    console = PeopleConsole()
    widest = max(len(entry.name) for entry in entries())
    for entry in entries():
        console.print(f"{entry.name:<{widest}}  {entry.title} ({entry.source})")
    console.print("make them with: cyclemap figures NAME ... (or all)")


def run_figures(asked: FiguresOptions) -> None:
    """Make every exhibit named, or list them where none is; what fails is told and loses none of
    the others.

    Raises InvalidInput for an unknown name, a folder that is none and an index that cannot be read,
    before any work; CycleMapError at the end where something failed.
    """
    results = asked.results
    if not asked.names:
        list_figures(results)
        return
    chosen = entries(asked.names)
    folder = MeasuredFolder.found(asked.data)
    known = [entry.name for entry in entries()]
    with only_writer(results.out):
        index = _read_index(results.out / INDEX_FILE)
        made = list[Json]()
        failed = list[Json]()
        for place, entry in enumerate(chosen, 1):
            try:
                with progress_bar(f"{entry.name} ({place} of {len(chosen)})"):
                    line, wants_data, table = _make(entry, folder, results)
            except CycleMapError as error:
                failed.append({"name": entry.name, "error": str(error)})
                continue
            made.append(line)
            index[entry.name] = line
            # In the gallery's order; names that are no longer there come last.
            kept = sorted(
                index, key=lambda name: known.index(name) if name in known else len(known)
            )
            write_json(results.out / INDEX_FILE, {"figures": [index[name] for name in kept]})
            if results.json != "-":
                # One exhibit for people: title, rows of a table, caption, file, and whether
                # measured data were there.
                PeopleConsole().tell(
                    f"{line['name']}: {line['title']} ({line['source']})",
                    table,
                    str(line["caption"]),
                    f"measured data: {line['measured'] or NO_DATA}" if wants_data else "",
                    f"file: {results.out / str(line['file'])}\n",
                )
        publish_json({"figures": made, "failed": failed}, results.json)
        if failed:
            reasons = "; ".join(f"{failure['name']}: {failure['error']}" for failure in failed)
            raise CycleMapError(f"{len(failed)} of {len(chosen)} could not be made: {reasons}")


def _make(entry: Entry, folder: MeasuredFolder, results: ResultOptions) -> tuple[Json, bool, Told]:
    """Make and write one exhibit: its line of the index, whether it asked for measured data, and
    its rows where it is a table.
    """
    exhibit = load_exhibit(entry.name)
    data = WatchedFolder(folder.path)
    result = exhibit.compute(data)
    table: Told = ""
    if exhibit.draw is not None:
        from cyclemap.views.panels.layout import render

        suffix = results.format
        content = render(exhibit.draw(result), suffix)
    elif exhibit.frames is not None:
        from cyclemap.figures.locking_in import animated_gif

        suffix = "gif"
        content = animated_gif(exhibit.frames(result))
    else:
        rows = list(exhibit.rows(result))
        text = io.StringIO()
        csv.writer(text, lineterminator="\n").writerows([exhibit.header, *rows])
        suffix = "csv"
        content = text.getvalue().encode()
        table = people_table("", exhibit.header, rows, words=range(len(exhibit.header)))
    path = results.out / f"{entry.name}.{suffix}"
    write_whole(path, content)
    line: Json = {
        **json_of(entry, "name", "title", "source"),
        "caption": typeset(exhibit.caption(result)),
        "file": path.name,
        "measured": ", ".join(data.there) or None,
    }
    return line, bool(data.asked), table


def _read_index(path: Path) -> dict[str, Json]:
    """The lines of an index by name, in order; none where there is no file; DataFileError where it
    is no index.
    """
    try:
        lines = read_json(path)["figures"] if path.exists() else []  # type: ignore[index]
        return {line["name"]: {key: line[key] for key in _KEYS} for line in lines}
    except (DataFileError, KeyError, TypeError) as error:
        raise DataFileError(
            f"{path}: not an index of figures; remove it or choose another --out"
        ) from error
