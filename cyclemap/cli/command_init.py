"""`cyclemap init` and `check`: a file for one's own object, what is likely wrong with it, and a picture."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from cyclemap.cli.options import JSON_HELP, PATH
from cyclemap.errors import InvalidInput

if TYPE_CHECKING:
    from cyclemap.mechanics.outline import Outline

COMMENTS = (
    "What is pushed, on what, where, and how it is dragged back: lengths in mm, angles in degrees counter-clockwise.",
    "Every command takes this file as MATERIAL, or as --protocol beside another material. [friction] is the surface:",
    "mu_a and mu_b along its axes, the first at phi_deg from the robot's x, its centre off by m0, n0.",
)


@click.command("init")
@click.argument("file", type=PATH)
@click.option("--rectangle-mm", metavar="WIDTH,HEIGHT", help="A rectangle: its lengths along x and y.")
@click.option("--ellipse-mm", metavar="WIDTH,HEIGHT", help="An ellipse, or a disc: its whole widths along x and y.")
@click.option(
    "--shape", metavar="NAME", help="An object of the MIT push dataset: rect1 to rect3, tri1 to tri3, hex, ..."
)
@click.option("--outline", metavar="PATH", type=PATH, help="An SVG, DXF, STL, URDF or CSV file of it.")
@click.option(
    "--unit", type=click.Choice(["mm", "cm", "m", "inch"]), help="Of the outline file. [default: guessed, said]"
)
@click.option("--tolerance-mm", type=float, default=0.1, help="Corners of the outline that may go.")
@click.option("--underside", is_flag=True, help="The foot print of a mesh, not its silhouette.")
@click.option("--name", help="Of the object. [default: the file's]")
@click.option("--surface", default="table", help="Name of the surface.")
@click.option("--set", "settings", metavar="KEY=VALUE", multiple=True, help="One fact of the experiment; repeatable.")
@click.option("--force", is_flag=True, help="Write over a file that is there.")
@click.option("--json", "json_target", metavar="FILE", help=JSON_HELP)
def init_command(file: Path, json_target: str | None, **asked: Any) -> None:
    """Write FILE.toml for your own object: its outline, a first guess of push, rod and ring, and a picture of it all.

    Asked for no outline, it asks back.
    """
    if file.suffix != ".toml":
        raise InvalidInput(f"{file}: the file's name must end in .toml")
    if file.exists() and not asked["force"]:
        raise InvalidInput(f"{file} is there already: choose another name, or give --force to write over it")
    if not any(asked[key] for key in ("rectangle_mm", "ellipse_mm", "shape", "outline")):
        _ask(asked)
    outline, said = _outline(asked)
    name = asked["name"] or asked["shape"] or (asked["outline"] or file).stem
    from dataclasses import replace

    from cyclemap.cli.settings import set_settings
    from cyclemap.collection.collection_file import collection_text
    from cyclemap.collection.loop import CollectionLoop
    from cyclemap.collection.own_object import first_settings, within_reach
    from cyclemap.collection.portrait import DEFAULT_SIGMA
    from cyclemap.collection.setting_table import SETTINGS, without_noise
    from cyclemap.collection.settings import layered
    from cyclemap.text_files import write_whole

    own, sigma = without_noise(set_settings(asked["settings"]))
    first = {"shape": asked["shape"]} if asked["shape"] else first_settings(outline, name)
    loop = CollectionLoop.from_settings(layered(first, own), CollectionLoop.mit("isotropic"))
    material = replace(loop.material, name=asked["surface"], provenance="given with cyclemap init, not measured")
    loop = replace(loop, material=material)
    if "push_mm" not in own and not asked["shape"]:
        loop = within_reach(loop)
    notes = {key: f"{one.meaning[0].upper()}{one.meaning[1:]}." for key, one in SETTINGS.items()}
    text = collection_text(loop, noise=DEFAULT_SIGMA if sigma is None else sigma, comments=COMMENTS, notes=notes)
    write_whole(file, text.encode())
    tell_check(file, file.with_suffix(".png"), json_target, [*said, f"written: {file}"])


def _ask(asked: dict[str, Any]) -> None:
    """Ask people what was not said; InvalidInput where nobody answers."""
    if sys.stdin is None or not sys.stdin.isatty():
        raise InvalidInput(
            "say what the object is: --rectangle-mm 120,60, --ellipse-mm 80,80, --shape NAME or --outline FILE"
        )
    kind = click.prompt("The object", type=click.Choice(["rectangle", "ellipse", "mit", "file"]), default="rectangle")
    key: str = {"rectangle": "rectangle_mm", "ellipse": "ellipse_mm", "mit": "shape", "file": "outline"}[kind]
    words = {"rectangle_mm": "Its width,height in mm", "ellipse_mm": "Its widths along x,y in mm", "shape": "Its name"}
    answer = click.prompt(words.get(key, "The file"), default="rect1" if key == "shape" else None)
    asked[key] = Path(answer) if key == "outline" else answer
    asked["name"] = asked["name"] or (None if key == "shape" else click.prompt("A name for it", default="object"))
    asked["surface"] = click.prompt("A name for the surface", default=asked["surface"])


def _outline(asked: dict[str, Any]) -> tuple[Outline, list[str]]:
    """The outline that is asked for, and what is to be said of it."""
    from cyclemap.mechanics import Ellipse, Polygon, Slider
    from cyclemap.plain_text import plain_number

    given = [key for key in ("rectangle_mm", "ellipse_mm", "shape", "outline") if asked[key]]
    if len(given) > 1:
        raise InvalidInput(
            f"--{given[0].replace('_', '-')} and --{given[1].replace('_', '-')} both say the outline: give one"
        )
    if given == ["outline"]:
        from cyclemap.collection.outline_files import read_outline

        found = read_outline(asked["outline"], asked["unit"], 1e-3 * asked["tolerance_mm"], asked["underside"])
        return found.outline, list(found.words)
    if given == ["shape"]:
        return Slider.mit(asked["shape"]).outline, []
    try:
        lengths = [plain_number(part) for part in asked[given[0]].split(",")]
    except ValueError:
        lengths = []
    if len(lengths) != 2 or not 0.0 < min(lengths) <= max(lengths) < float("inf"):
        said = f"--{given[0].replace('_', '-')} {asked[given[0]]}"
        raise InvalidInput(f"{said}: give two lengths in mm, such as 120,60")
    x, y = (0.5e-3 * length for length in lengths)
    return (Polygon(((x, y), (-x, y), (-x, -y), (x, -y))) if given == ["rectangle_mm"] else Ellipse(x, y)), []


@click.command("check")
@click.argument("file", type=PATH)
@click.option("--out", metavar="DIR", type=PATH, default="out", help="Of the picture.")
@click.option("--json", "json_target", metavar="FILE", help=JSON_HELP)
def check_command(file: Path, out: Path, json_target: str | None) -> None:
    """Look at a collection FILE.toml as a careful colleague would: say what is likely wrong, and draw it."""
    tell_check(file, out / f"check_{file.stem}.png", json_target, [])


def tell_check(file: Path, picture: Path, json_target: str | None, said: list[str]) -> None:
    """Check a file, draw it, and tell what was said before and what was found; InvalidInput where nothing would run."""
    from cyclemap.cli.output import PeopleConsole, publish_json
    from cyclemap.collection.own_object import check_collection
    from cyclemap.errors import InvalidInput
    from cyclemap.text_files import write_whole
    from cyclemap.views.object_page import object_page
    from cyclemap.views.style import render

    found = check_collection(file)
    wrong = [finding.words for finding in found.findings if finding.wrong]
    doubts = [finding.words for finding in found.findings if not finding.wrong]
    write_whole(picture, render(object_page(found)))
    report: dict[str, object] = {"file": str(file), "said": said, "wrong": wrong, "doubts": doubts}
    report["picture"] = str(picture)
    if not publish_json(report, json_target):
        console = PeopleConsole()
        for line in said:
            console.print(line)
        for words in doubts:
            console.print(f"check: {words}")
        if not (wrong or doubts):
            console.print(f"{file}: nothing to object to", style="bold")
        console.print(f"picture: {picture}")
    if wrong:
        raise InvalidInput(f"{file}: {'; '.join(wrong)}")
    if json_target != "-":
        PeopleConsole().print(f"next: cyclemap portrait {file}")
