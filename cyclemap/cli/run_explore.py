"""`cyclemap explore`: the loop as one page with sliders, which computes in the browser."""

import webbrowser
from pathlib import Path

from cyclemap.cli.options import TableOptions, measured_orientations
from cyclemap.cli.output import progress_bar, result_stem, write_page
from cyclemap.collection.portrait import portrait
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop
from cyclemap.views.explorer.page import page_html


def run_explore(
    options: LoopOptions, data: Path | None, table: TableOptions, browser: bool, out: Path
) -> None:
    """Write the page, and open it."""
    options = LoopOptions(options.material or "plywood", options.protocol, options.settings)
    chosen = chosen_loop(options, data)
    pairs = measured_orientations(data, table, out)
    with progress_bar(f"page on {chosen.loop.material.name}") as progress:
        drawn = portrait(chosen.loop, sigma=chosen.sigma, progress=progress)
    page = page_html(drawn, 0.0, (str(options.material),), chosen.settings, pairs=pairs)
    place = write_page(page, result_stem(out, "explore", chosen.loop))
    if browser:
        webbrowser.open(place.resolve().as_uri())
