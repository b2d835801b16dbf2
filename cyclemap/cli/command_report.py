"""`cyclemap report`: everything about one loop in one HTML file, to mail and to open without a network."""

from __future__ import annotations

import shlex
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click

from cyclemap.cli.options import PATH, LoopOptions, loop_options, readable_data, table_options

if TYPE_CHECKING:
    from cyclemap.collection.portrait import Portrait, Progress
    from cyclemap.views.report.report_page import Download, Section

METHODS = (
    "The cycle map takes the object's orientation before a push to that before the next. Pushes and drags are "
    "quasi-static: the rod's force balances friction, whose law at every point of the support is the gradient of an "
    "offset ellipse's support function, integrated over the pressed area in closed form. The map is sampled adaptively "
    "to the stated error; fixed points are its intersections with the diagonal, stable where |f'| < 1; the noise of a "
    "cycle is normal, independent between cycles. The model holds for slow pushes on a floor whose friction is the "
    "same everywhere."
)
BIBTEX = """@article{ma2018friction,
  author = {Ma, Daolin and Rodriguez, Alberto},
  title = {Friction Variability in Planar Pushing Data: Anisotropic Friction and
    Data-collection Bias},
  journal = {IEEE Robotics and Automation Letters},
  volume = {3}, number = {4}, pages = {3232--3239}, year = {2018}
}"""


@click.command("report")
@loop_options
@click.option("--data", metavar="FILE", type=PATH, help="Measured pushes or θ0 to judge it by.")
@table_options
@click.option("--reset", is_flag=True, help="Also find a reset without bias, with its files (some ten seconds).")
@click.option("--out", metavar="DIR", type=PATH, default="out", help="Where.")
def report_command(
    options: LoopOptions, data: Path | None, columns: str | None, units: str | None, reset: bool, out: Path
) -> None:
    """Write report_MATERIAL.html: verdict, moving pictures, a ring to slide, data beside it, what to do, provenance."""
    from cyclemap.cli.output import file_stem, progress_bar
    from cyclemap.cli.settings import chosen_loop
    from cyclemap.collection.portrait import DEFAULT_SIGMA, portrait
    from cyclemap.collection.portrait_curves import portrait_curves
    from cyclemap.evidence.comparison.collection_data import collection_data
    from cyclemap.plain_text import typeset
    from cyclemap.text_files import write_whole
    from cyclemap.views.portrait_page import portrait_page
    from cyclemap.views.report.report_page import Section, report_html, ring_answers
    from cyclemap.views.style import render

    loop, chosen = chosen_loop(options)
    sigma = DEFAULT_SIGMA if chosen is None else chosen
    data = None if data is None else readable_data(data, columns, units, out)
    pairs = None if data is None else collection_data(data, loop).pairs
    path = None if pairs is None else pairs.path
    start = 0.0 if path is None else float(path[0])
    with progress_bar(f"report on {loop.material.name}") as progress:
        cycles = 2000 if path is None else len(path) - 1
        found = portrait(loop, sigma=chosen, cycles=cycles, start=start, progress=lambda share: progress(0.4 * share))
        rings = ring_answers(loop, sigma, start, lambda share: progress(0.4 + 0.2 * share))
        sections: list[Section] = []
        if data is not None:
            sections += _beside_data(found, data, sigma, chosen is not None, lambda share: progress(0.6 + 0.3 * share))
        downloads: tuple[Download, ...] = ()
        if reset:
            section, downloads = _what_to_do(found, sigma, lambda share: progress(0.9 + 0.1 * share))
            sections.append(section)
        told = [replace(one, paragraphs=tuple(map(typeset, one.paragraphs))) for one in (*sections, _how_sure(found))]
        sections = [*told, Section("Methods", (METHODS,)), Section("To cite", (BIBTEX,))]
    words = ["cyclemap", "report", options.material or ""]
    words += [word for one in options.settings for word in ("--set", one)]
    words += ["--protocol", options.protocol.name] if options.protocol else []
    words += ["--data", data.name] if data else []
    picture = render(portrait_page(found, portrait_curves(found)), "png", 80)
    page = report_html(
        found,
        start,
        rings,
        picture,
        shlex.join([*words, *["--reset"] * reset]),
        pairs=pairs,
        sections=sections,
        downloads=downloads,
        inputs=[path for path in (data, options.protocol) if path is not None and path.is_file()],
    )
    place = out / f"report_{file_stem(loop.material.name)}.html"
    write_whole(place, page.encode())
    click.echo(f"report: {place} ({len(page.encode()) / 1e3:.0f} kB)")


def _beside_data(found: Portrait, data: Path, sigma: float, said: bool, progress: Progress) -> list[Section]:
    """Recorded against predicted: the verdicts of `cyclemap compare`, with their p-values, and what is left over."""
    from cyclemap.evidence.comparison.compare import compare
    from cyclemap.maps import WrappedNormal
    from cyclemap.views import compare_page
    from cyclemap.views.report.report_page import Section
    from cyclemap.views.style import render

    compared = compare(found.loop, data, noise=WrappedNormal(sigma) if said else None, progress=progress)
    name = found.loop.material.name
    told = (compare_page.headline(name, compared), compare_page.data_sentence(compared))
    verdicts = (one.words for one in compared.verdicts)
    trust = compare_page.trust_sentences(compared)
    page = compare_page.residual_page(compared)
    return [
        Section("Recorded against predicted", (*told, *verdicts, *trust)),
        Section(
            "What explains it, and what is left",
            tuple(compare_page.explanation_sentences(name, compared)),
            b"" if page is None else render(page, "png", 80),
            "Measured less predicted, over the orientation before the push; a line joins medians of 5 degrees",
        ),
    ]


def _what_to_do(found: Portrait, sigma: float, progress: Progress) -> tuple[Section, tuple[Download, ...]]:
    """The reset that `cyclemap reset` finds, in its three lines, and its protocol to take away."""
    from cyclemap.resets import design_reset
    from cyclemap.resets.protocol.protocol_file import protocol_text
    from cyclemap.views.report.report_page import Download, Section
    from cyclemap.views.reset_page import design_sentences

    design = design_reset(found.loop, sigma=sigma, progress=progress)
    text = protocol_text(found.loop, design.chosen.strategy, noise=sigma)
    return Section("What to do", design_sentences(design)), (Download("protocol.toml", text),)


def _how_sure(found: Portrait) -> Section:
    """What the answer rests on, and where it ends."""
    from cyclemap.views import sentences
    from cyclemap.views.report.report_page import Section

    material = found.loop.material
    told = [sentences.push_line(found), sentences.parameters_line(found), sentences.accuracy_line(found)]
    told += filter(
        None, [sentences.uncertainty_sentence(material.name, found.uncertainty), sentences.material_line(material)]
    )
    return Section("How sure", tuple(told))
