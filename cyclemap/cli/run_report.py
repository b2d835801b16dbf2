"""`cyclemap report`: everything about one loop in one HTML file, to mail and to open without a
network; `cyclemap explore`: its page with sliders alone, which computes in the browser.
"""

import shlex
import webbrowser
from dataclasses import replace
from pathlib import Path

from cyclemap.cli.collected.readable_data import readable_data
from cyclemap.cli.commands import ExploreOptions, ReportOptions
from cyclemap.cli.options import length_and_start, said_command
from cyclemap.cli.output import progress_bar, result_name, write_page
from cyclemap.collection.portrait import Portrait, portrait
from cyclemap.evidence.comparison.collection_data import collection_data, measured_pairs
from cyclemap.maps import WrappedNormal
from cyclemap.plain_text import typeset
from cyclemap.progress import Progress
from cyclemap.protocol.chosen_loop import ChosenCollection, chosen_loop
from cyclemap.views import sentences
from cyclemap.views.explorer_page import Download, Section, page_html, provenance_of
from cyclemap.views.panels.layout import render

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


def run_report(asked: ReportOptions) -> None:
    """Compute all of it and write the page."""
    chosen = asked.loop.chosen_loop(asked.data)
    data = None if asked.data is None else readable_data(asked.data, asked.table, asked.out)
    pairs = None if data is None else collection_data(data, chosen.loop).pairs
    cycles, start = length_and_start(pairs)
    sections: list[Section] = []
    downloads: tuple[Download, ...] = ()
    with progress_bar(f"report on {chosen.loop.material.name}") as progress:
        drawn = portrait(
            chosen.loop,
            sigma=chosen.sigma,
            cycles=cycles,
            start=start,
            progress=lambda share: progress(0.6 * share),
        )
        if data is not None:
            sections += _beside_data(drawn, data, chosen, lambda x: progress(0.6 + 0.3 * x))
        if asked.reset:
            advice, downloads = _what_to_do(drawn, chosen, lambda x: progress(0.9 + 0.1 * x))
            sections.append(advice)
    lines = (
        sentences.push_line(drawn),
        sentences.parameters_line(drawn),
        sentences.accuracy_line(drawn),
        sentences.uncertainty_sentence(drawn.loop.material.name, drawn.uncertainty),
        sentences.material_line(drawn.loop.material),
    )
    sections.append(Section("How sure", tuple(filter(None, lines))))
    sections = [
        replace(section, paragraphs=tuple(map(typeset, section.paragraphs))) for section in sections
    ]
    inputs = [path for path in (asked.data, asked.loop.protocol) if path and path.is_file()]
    command = shlex.join(said_command("out", files_by_name=True))
    page = page_html(
        drawn,
        start,
        (asked.loop.surface or "isotropic",),
        chosen.settings,
        pairs=pairs,
        sections=[*sections, Section("Methods", (METHODS,)), Section("To cite", (BIBTEX,))],
        downloads=downloads,
        provenance=provenance_of(drawn, command, inputs),
    )
    write_page(page, asked.out / f"{result_name('report', chosen.loop)}.html")


def _what_to_do(
    drawn: Portrait, chosen: ChosenCollection, progress: Progress
) -> tuple[Section, tuple[Download, ...]]:
    """The reset that `cyclemap reset` finds, in its three lines, and its protocol to take away."""
    from cyclemap.protocol.protocol_file import protocol_text
    from cyclemap.resets import design_reset
    from cyclemap.views.reset_page import design_sentences

    design = design_reset(drawn.loop, sigma=chosen.noise, progress=progress)
    protocol = protocol_text(drawn.loop, design.chosen.strategy, noise=chosen.noise)
    advice = Section("What to do", design_sentences(design))
    return advice, (Download("protocol.toml", protocol),)


def _beside_data(
    drawn: Portrait, data: Path, chosen: ChosenCollection, progress: Progress
) -> list[Section]:
    """Recorded against predicted: the verdicts of `cyclemap compare`, with their p-values, and what
    is left over.
    """
    from cyclemap.evidence.comparison.compare import compare
    from cyclemap.views import compare_page
    from cyclemap.views.compare_page import verdicts

    noise = None if chosen.sigma is None else WrappedNormal(chosen.sigma)
    compared = compare(drawn.loop, data, noise=noise, progress=progress)
    name = drawn.loop.material.name
    opening = (compare_page.headline(name, compared), compare_page.data_sentence(compared))
    answers = (verdict.words for verdict in verdicts(compared))
    trust = compare_page.trust_sentences(compared)
    page = compare_page.residual_page(compared)
    return [
        Section("Recorded against predicted", (*opening, *answers, *trust)),
        Section(
            "What explains it, and what is left",
            tuple(compare_page.explanation_sentences(name, compared)),
            b"" if page is None else render(page, "png", 80),
            "Measured less predicted, over the orientation before the push; a line joins medians "
            "of 5 degrees",
        ),
    ]


def run_explore(asked: ExploreOptions) -> None:
    """Write the explorer's page, and open it."""
    surface = asked.loop.surface or "plywood"
    chosen = chosen_loop(surface, asked.loop.protocol, asked.loop.settings, asked.data)
    pairs = None
    if asked.data is not None:
        pairs = measured_pairs(readable_data(asked.data, asked.table, asked.out))
    cycles, start = length_and_start(pairs)
    with progress_bar(f"page on {chosen.loop.material.name}") as progress:
        drawn = portrait(
            chosen.loop, sigma=chosen.sigma, cycles=cycles, start=start, progress=progress
        )
    page = page_html(drawn, start, (surface,), chosen.settings, pairs=pairs)
    place = asked.out / f"{result_name('explore', chosen.loop)}.html"
    write_page(page, place)
    if asked.browser:
        webbrowser.open(place.resolve().as_uri())
