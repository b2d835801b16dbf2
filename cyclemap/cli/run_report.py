"""`cyclemap report`: everything about one loop in one HTML file, to mail and to open without a
network.
"""

import shlex
from dataclasses import replace
from pathlib import Path

import click

from cyclemap.cli.options import TableOptions, readable_data, said_command
from cyclemap.cli.output import progress_bar, result_stem
from cyclemap.collection.portrait import DEFAULT_SIGMA, Portrait, Progress, portrait
from cyclemap.evidence.comparison.collection_data import collection_data
from cyclemap.evidence.comparison.compare import compare
from cyclemap.maps import WrappedNormal
from cyclemap.plain_text import typeset
from cyclemap.protocol.chosen_loop import LoopOptions, chosen_loop, told_settings
from cyclemap.protocol.protocol_file import protocol_text
from cyclemap.resets import design_reset
from cyclemap.text_files import write_whole
from cyclemap.views import compare_page, sentences
from cyclemap.views.explorer.page import Download, Section, page_html, provenance_of
from cyclemap.views.reset_page import design_sentences
from cyclemap.views.style import render
from cyclemap.views.verdicts import verdicts

METHODS = (
    "The cycle map takes the object's orientation before a push to that before the next. Pushes "
    "and drags are quasi-static: the rod's force balances friction, whose law at every point of "
    "the support is the gradient of an offset ellipse's support function, integrated over the "
    "pressed area in closed form. The map is sampled adaptively to the stated error; fixed points "
    "are its intersections with the diagonal, stable where |f'| < 1; the noise of a cycle is "
    "normal, independent between cycles. The model holds for slow pushes on a floor whose friction "
    "is the same everywhere."
)
BIBTEX = """@article{ma2018friction,
  author = {Ma, Daolin and Rodriguez, Alberto},
  title = {Friction Variability in Planar Pushing Data: Anisotropic Friction and
    Data-collection Bias},
  journal = {IEEE Robotics and Automation Letters},
  volume = {3}, number = {4}, pages = {3232--3239}, year = {2018}
}"""


def run_report(
    options: LoopOptions, data: Path | None, table: TableOptions, reset: bool, out: Path
) -> None:
    """Compute all of it and write the page."""
    loop, chosen = chosen_loop(options, data)
    sigma = DEFAULT_SIGMA if chosen is None else chosen
    data = None if data is None else readable_data(data, table, out)
    pairs = None if data is None else collection_data(data, loop).pairs
    path = None if pairs is None else pairs.path
    start = 0.0 if path is None else float(path[0])
    with progress_bar(f"report on {loop.material.name}") as progress:
        cycles = 2000 if path is None else len(path) - 1
        found = portrait(
            loop,
            sigma=chosen,
            cycles=cycles,
            start=start,
            progress=lambda share: progress(0.6 * share),
        )
        sections: list[Section] = []
        if data is not None:
            sections += _beside_data(
                found, data, sigma, chosen is not None, lambda share: progress(0.6 + 0.3 * share)
            )
        downloads: tuple[Download, ...] = ()
        if reset:
            # The reset that `cyclemap reset` finds, in its three lines, and its protocol to take
            # away.
            design = design_reset(
                found.loop, sigma=sigma, progress=lambda share: progress(0.9 + 0.1 * share)
            )
            sections.append(Section("What to do", design_sentences(design)))
            protocol = protocol_text(found.loop, design.chosen.strategy, noise=sigma)
            downloads = (Download("protocol.toml", protocol),)
        material = loop.material
        sure = [
            tell(found)
            for tell in (sentences.push_line, sentences.parameters_line, sentences.accuracy_line)
        ]
        sure += [
            sentences.uncertainty_sentence(material.name, found.uncertainty),
            sentences.material_line(material),
        ]
        sections.append(Section("How sure", tuple(filter(None, sure))))
        sections = [
            replace(one, paragraphs=tuple(map(typeset, one.paragraphs))) for one in sections
        ]
        sections += [Section("Methods", (METHODS,)), Section("To cite", (BIBTEX,))]
    inputs = [path for path in (data, options.protocol) if path is not None and path.is_file()]
    page = page_html(
        found,
        start,
        (options.material or "isotropic",),
        told_settings(options, data)[1],
        pairs=pairs,
        sections=sections,
        downloads=downloads,
        provenance=provenance_of(
            found, shlex.join(said_command("out", files_by_name=True)), inputs
        ),
    )
    stem = result_stem(out, "report", loop)
    place = stem.with_name(f"{stem.name}.html")
    write_whole(place, page.encode())
    click.echo(f"report: {place} ({len(page.encode()) / 1e3:.0f} kB)")


def _beside_data(
    found: Portrait, data: Path, sigma: float, said: bool, progress: Progress
) -> list[Section]:
    """Recorded against predicted: the verdicts of `cyclemap compare`, with their p-values, and what
    is left over.
    """
    compared = compare(
        found.loop, data, noise=WrappedNormal(sigma) if said else None, progress=progress
    )
    name = found.loop.material.name
    told = (compare_page.headline(name, compared), compare_page.data_sentence(compared))
    answers = (one.words for one in verdicts(compared))
    trust = compare_page.trust_sentences(compared)
    page = compare_page.residual_page(compared)
    return [
        Section("Recorded against predicted", (*told, *answers, *trust)),
        Section(
            "What explains it, and what is left",
            tuple(compare_page.explanation_sentences(name, compared)),
            b"" if page is None else render(page, "png", 80),
            "Measured less predicted, over the orientation before the push; a line joins medians "
            "of 5 degrees",
        ),
    ]
