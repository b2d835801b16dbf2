"""`cyclemap init`: a file for one's own object, made from its outline; `cyclemap check`: what is
likely wrong with such a file.
"""

import math
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import click

from cyclemap.cli.commands import CheckOptions, InitOptions
from cyclemap.cli.output import PeopleConsole, publish_json
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Ellipse, Polygon, Slider
from cyclemap.mechanics.outline import Outline
from cyclemap.plain_text import number_or_nan
from cyclemap.protocol.chosen_loop import set_settings
from cyclemap.protocol.collection_file import collection_text
from cyclemap.protocol.outline_files import read_outline
from cyclemap.protocol.own_object import check_collection, first_settings, within_reach
from cyclemap.protocol.settings import SETTINGS, layered, loop_from_settings, without_noise
from cyclemap.text_files import write_whole
from cyclemap.views.panels.layout import render
from cyclemap.views.push_pages import object_page
from cyclemap.written import Json

COMMENTS = (
    "What is pushed, on what, where, and how it is dragged back: lengths in mm, angles in "
    "degrees counter-clockwise.",
    "Every command takes this file as MATERIAL, or as --protocol beside another material. "
    "[friction] is the surface:",
    "mu_a and mu_b along its axes, the first at phi_deg from the robot's x, its centre off by "
    "m0, n0.",
)


def run_init(asked: InitOptions) -> None:
    """Write the file that is asked for, check it, and draw it beside itself."""
    file = asked.file
    if file.suffix != ".toml":
        raise InvalidInput(f"{file}: the file's name must end in .toml")
    picture = file.with_suffix(".png")
    for target in (file, picture):
        if target.exists() and not asked.force:
            raise InvalidInput(
                f"{target} is there already: choose another name, or give --force to write over it"
            )
    if not _outlines(asked):
        asked = _answered(asked)
    outline, said = _outline(asked)
    name = asked.name or asked.shape or (asked.outline or file).stem
    own, sigma = without_noise(set_settings(asked.settings))
    first: dict[str, object] = (
        {"shape": asked.shape} if asked.shape else first_settings(outline, name)
    )
    loop = loop_from_settings(layered(first, own), CollectionLoop.mit("isotropic"))
    material = replace(
        loop.material, name=asked.surface, provenance="given with cyclemap init, not measured"
    )
    loop = replace(loop, material=material)
    if "push_mm" not in own and not asked.shape:
        loop = within_reach(loop)
    notes = {
        key: f"{setting.meaning[0].upper()}{setting.meaning[1:]}."
        for key, setting in SETTINGS.items()
    }
    text = collection_text(
        loop, noise=DEFAULT_SIGMA if sigma is None else sigma, comments=COMMENTS, notes=notes
    )
    write_whole(file, text.encode())
    tell_check(file, picture, asked.json, [*said, f"written: {file}"])


def _outlines(asked: InitOptions) -> list[str]:
    """The options that say an outline, of those that were given."""
    given = {
        "--rectangle-mm": asked.rectangle_mm,
        "--ellipse-mm": asked.ellipse_mm,
        "--shape": asked.shape,
        "--outline": asked.outline,
    }
    return [option for option, value in given.items() if value]


def _answered(asked: InitOptions) -> InitOptions:
    """Ask people what was not said; InvalidInput where nobody answers."""
    if sys.stdin is None or not sys.stdin.isatty():
        raise InvalidInput(
            "say what the object is: --rectangle-mm 120,60, --ellipse-mm 80,80, --shape NAME or "
            "--outline FILE"
        )
    kind = click.prompt(
        "The object",
        type=click.Choice(["rectangle", "ellipse", "mit", "file"]),
        default="rectangle",
    )
    name = asked.name
    if kind == "mit":
        asked = replace(asked, shape=click.prompt("Its name", default="rect1"))
    else:
        if kind == "rectangle":
            asked = replace(asked, rectangle_mm=click.prompt("Its width,height in mm"))
        elif kind == "ellipse":
            asked = replace(asked, ellipse_mm=click.prompt("Its widths along x,y in mm"))
        else:
            asked = replace(asked, outline=Path(click.prompt("The file")))
        name = name or click.prompt("A name for it", default="object")
    surface = click.prompt("A name for the surface", default=asked.surface)
    return replace(asked, name=name, surface=surface)


def _outline(asked: InitOptions) -> tuple[Outline, list[str]]:
    """The outline that is asked for, and what is to be said of it."""
    option, *others = _outlines(asked)
    if others:
        raise InvalidInput(f"{option} and {others[0]} both say the outline: give one")
    if asked.outline:
        drawing = read_outline(
            asked.outline, asked.unit, 1e-3 * asked.tolerance_mm, asked.underside
        )
        return drawing.outline, list(drawing.words)
    if asked.unit or asked.underside:
        raise InvalidInput(
            f"--unit and --underside are about --outline FILE, not {option}: leave them out"
        )
    if asked.shape and asked.name:
        raise InvalidInput(
            f"--name {asked.name}: {asked.shape} keeps its name, by which materials know its "
            "plate; leave --name out"
        )
    if asked.shape:
        return Slider.mit(asked.shape).outline, []
    widths = asked.rectangle_mm or asked.ellipse_mm or ""
    lengths = [number_or_nan(word) for word in widths.split(",")]
    if len(lengths) != 2 or not all(0.0 < length < math.inf for length in lengths):
        raise InvalidInput(f"{option} {widths}: give two lengths in mm, such as 120,60")
    x, y = (0.5e-3 * length for length in lengths)
    if asked.rectangle_mm:
        return Polygon(((x, y), (-x, y), (-x, -y), (x, -y))), []
    return Ellipse(x, y), []


def run_check(asked: CheckOptions) -> None:
    """Check the file, and draw it where results go."""
    tell_check(asked.file, asked.out / f"check_{asked.file.stem}.png", asked.json, [])


def tell_check(file: Path, picture: Path, json_target: str | None, said: list[str]) -> None:
    """Check a file, draw it, and tell what was said before and what was found; InvalidInput where
    nothing would run.
    """
    checked = check_collection(file)
    wrong = [finding.words for finding in checked.findings if finding.wrong]
    doubts = [finding.words for finding in checked.findings if not finding.wrong]
    write_whole(picture, render(object_page(checked)))
    report: Json = {
        "file": str(file),
        "said": said,
        "wrong": wrong,
        "doubts": doubts,
        "picture": str(picture),
    }
    if not publish_json(report, json_target):
        console = PeopleConsole()
        for line in (*said, *(f"check: {words}" for words in doubts)):
            console.print(line)
        if not (wrong or doubts):
            console.print(f"{file}: nothing to object to", style="bold")
        console.print(f"picture: {picture}")
    if wrong:
        raise InvalidInput(f"{file}: {'; '.join(wrong)}")
    if json_target != "-":
        PeopleConsole().print(f"next: cyclemap portrait {shlex.quote(str(file))}")
