"""`cyclemap init`: a file for one's own object, made from its outline."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import click

from cyclemap.cli.run_check import tell_check
from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import DEFAULT_SIGMA
from cyclemap.errors import InvalidInput
from cyclemap.mechanics import Ellipse, Polygon, Slider
from cyclemap.mechanics.outline import Outline
from cyclemap.plain_text import plain_number
from cyclemap.protocol.chosen_loop import set_settings
from cyclemap.protocol.collection_file import collection_text
from cyclemap.protocol.outline_files import read_outline
from cyclemap.protocol.own_object import first_settings, within_reach
from cyclemap.protocol.setting_table import SETTINGS, without_noise
from cyclemap.protocol.settings import layered, loop_from_settings
from cyclemap.text_files import write_whole

COMMENTS = (
    "What is pushed, on what, where, and how it is dragged back: lengths in mm, angles in "
    "degrees counter-clockwise.",
    "Every command takes this file as MATERIAL, or as --protocol beside another material. "
    "[friction] is the surface:",
    "mu_a and mu_b along its axes, the first at phi_deg from the robot's x, its centre off by "
    "m0, n0.",
)


def run_init(file: Path, json_target: str | None, **asked: Any) -> None:
    """Write the file that is asked for, check it, and draw it beside itself."""
    if file.suffix != ".toml":
        raise InvalidInput(f"{file}: the file's name must end in .toml")
    if file.exists() and not asked["force"]:
        raise InvalidInput(
            f"{file} is there already: choose another name, or give --force to write over it"
        )
    if not any(asked[key] for key in ("rectangle_mm", "ellipse_mm", "shape", "outline")):
        _ask(asked)
    outline, said = _outline(asked)
    name = asked["name"] or asked["shape"] or (asked["outline"] or file).stem
    own, sigma = without_noise(set_settings(asked["settings"]))
    first = {"shape": asked["shape"]} if asked["shape"] else first_settings(outline, name)
    loop = loop_from_settings(layered(first, own), CollectionLoop.mit("isotropic"))
    material = replace(
        loop.material, name=asked["surface"], provenance="given with cyclemap init, not measured"
    )
    loop = replace(loop, material=material)
    if "push_mm" not in own and not asked["shape"]:
        loop = within_reach(loop)
    notes = {key: f"{one.meaning[0].upper()}{one.meaning[1:]}." for key, one in SETTINGS.items()}
    text = collection_text(
        loop, noise=DEFAULT_SIGMA if sigma is None else sigma, comments=COMMENTS, notes=notes
    )
    write_whole(file, text.encode())
    tell_check(file, file.with_suffix(".png"), json_target, [*said, f"written: {file}"])


def _ask(asked: dict[str, Any]) -> None:
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
    key: str = {
        "rectangle": "rectangle_mm",
        "ellipse": "ellipse_mm",
        "mit": "shape",
        "file": "outline",
    }[kind]
    words = {
        "rectangle_mm": "Its width,height in mm",
        "ellipse_mm": "Its widths along x,y in mm",
        "shape": "Its name",
    }
    answer = click.prompt(words.get(key, "The file"), default="rect1" if key == "shape" else None)
    asked[key] = Path(answer) if key == "outline" else answer
    asked["name"] = asked["name"] or (
        None if key == "shape" else click.prompt("A name for it", default="object")
    )
    asked["surface"] = click.prompt("A name for the surface", default=asked["surface"])


def _outline(asked: dict[str, Any]) -> tuple[Outline, list[str]]:
    """The outline that is asked for, and what is to be said of it."""
    given = [key for key in ("rectangle_mm", "ellipse_mm", "shape", "outline") if asked[key]]
    option = f"--{given[0].replace('_', '-')}"
    if len(given) > 1:
        raise InvalidInput(
            f"{option} and --{given[1].replace('_', '-')} both say the outline: give one"
        )
    if given == ["outline"]:
        found = read_outline(
            asked["outline"], asked["unit"], 1e-3 * asked["tolerance_mm"], asked["underside"]
        )
        return found.outline, list(found.words)
    if given == ["shape"]:
        return Slider.mit(asked["shape"]).outline, []
    try:
        lengths = [plain_number(part) for part in asked[given[0]].split(",")]
    except ValueError:
        lengths = []
    if len(lengths) != 2 or not 0.0 < min(lengths) <= max(lengths) < float("inf"):
        raise InvalidInput(f"{option} {asked[given[0]]}: give two lengths in mm, such as 120,60")
    x, y = (0.5e-3 * length for length in lengths)
    return (
        Polygon(((x, y), (-x, y), (-x, -y), (x, -y)))
        if given == ["rectangle_mm"]
        else Ellipse(x, y)
    ), []
