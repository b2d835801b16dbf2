"""Where results go: files that appear whole or not at all, the terminal, and a bar for slow work."""

import re
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import click

from cyclemap.cli.json_report import Json, json_text
from cyclemap.whole_files import write_whole

PATIENCE_SECONDS = 2.0


def write_json(path: Path, report: Json) -> None:
    """Write `report` as JSON to the file `path`."""
    write_whole(path, json_text(report).encode())


def file_stem(name: str) -> str:
    """A material's name as part of a file name.

    >>> file_stem("worn plywood (side B)")
    'worn_plywood_side_B'
    """
    return re.sub(r"[^\w.-]+", "_", name).strip("_.") or "material"


def publish_json(report: Json, target: str | None) -> bool:
    """Send `report` where --json says; True where it took the terminal, which then shows nothing else."""
    if target == "-":
        click.echo(json_text(report), nl=False)
        return True
    if target is not None:
        write_json(Path(target), report)
    return False


@contextmanager
def progress_bar(label: str) -> Iterator[Callable[[float], None]]:
    """A function to report the fraction done to; a terminal gets a bar once work takes over two seconds."""
    if not sys.stderr.isatty():
        yield lambda fraction: None
        return
    from rich.console import Console
    from rich.progress import Progress

    bar = Progress(console=Console(stderr=True), transient=True)
    task = bar.add_task(label, total=1.0)
    due = time.monotonic() + PATIENCE_SECONDS

    def report(fraction: float) -> None:
        if time.monotonic() > due:
            bar.start()
        bar.update(task, completed=fraction)

    try:
        yield report
    finally:
        bar.stop()
