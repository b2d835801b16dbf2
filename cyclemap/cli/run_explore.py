"""`cyclemap explore`: the loop as one page with sliders, which computes in the browser."""

import webbrowser
from pathlib import Path

import click

from cyclemap.cli.options import TableOptions, measured_orientations
from cyclemap.cli.output import progress_bar, result_stem
from cyclemap.collection.portrait import portrait
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop, told_settings
from cyclemap.text_files import write_whole
from cyclemap.views.explorer.page import page_html


def run_explore(
    options: LoopOptions, data: Path | None, table: TableOptions, browser: bool, out: Path
) -> None:
    """Write the page, and open it."""
    options = LoopOptions(options.material or "plywood", options.protocol, options.settings)
    loop, sigma = chosen_loop(options, data)
    pairs = measured_orientations(data, table, out)
    with progress_bar(f"page on {loop.material.name}") as progress:
        found = portrait(loop, sigma=sigma, progress=progress)
    page = page_html(
        found, 0.0, (str(options.material),), told_settings(options, data)[1], pairs=pairs
    )
    stem = result_stem(out, "explore", loop)
    place = stem.with_name(f"{stem.name}.html")
    write_whole(place, page.encode())
    click.echo(f"page: {place} ({len(page.encode()) / 1e3:.0f} kB)")
    if browser:
        webbrowser.open(place.resolve().as_uri())
