"""A loop as one HTML file: answers for scrubber and ring slider inside it, words, provenance; the same bytes each time.

Its policy lets in only the scripts and styles it was written with, by their digests, and no request at all.
"""

from __future__ import annotations

import base64
import hashlib
import math
import platform
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import metadata, resources
from pathlib import Path

import jinja2
import numpy as np

from cyclemap.collection.loop import CollectionLoop
from cyclemap.collection.portrait import Portrait
from cyclemap.errors import CycleMapError
from cyclemap.evidence import Theta0Pairs
from cyclemap.views.explorer.answers import coarse, measured, of_portrait

RING_STEPS = 25
# The ring is moved along its own direction, from a fifth of its distance to 1.8 times.
_NEAREST, _FARTHEST = 0.2, 1.8
_RING_CYCLES = 300
_PACKAGES = ("cyclemap", "numpy", "scipy", "casadi")


@dataclass(frozen=True)
class Section:
    """A heading with its paragraphs, and a picture as PNG with what it shows, where there is one."""

    title: str
    paragraphs: tuple[str, ...]
    picture: bytes = b""
    shows: str = ""

    @property
    def image(self) -> str:
        """The picture as an address of its own."""
        return f"data:image/png;base64,{base64.b64encode(self.picture).decode()}"


@dataclass(frozen=True)
class Download:
    """A file inside the report: its name, and its text."""

    name: str
    text: str

    @property
    def address(self) -> str:
        """The file as an address of its own."""
        return f"data:text/plain;charset=utf-8;base64,{base64.b64encode(self.text.encode()).decode()}"


def ring_answers(
    loop: CollectionLoop, sigma: float, start: float, progress: Callable[[float], None] | None = None
) -> list[dict[str, object]]:
    """What the explorer would draw coarsely with the ring at 25 distances (mm) from the object's origin.

    A ring that cannot be there has `refused`, with the reason, in place of its answer. A ring at the origin is moved
    along x, over 40 mm.
    """
    hitch = np.asarray(loop.slider.hitch)
    distance = math.hypot(*hitch)
    along = hitch / distance if distance > 0.0 else np.array([1.0, 0.0])
    found = []
    for number, place in enumerate(np.linspace(_NEAREST, _FARTHEST, RING_STEPS) * (distance or 0.025)):
        moved = replace(loop, slider=replace(loop.slider, hitch=tuple((place * along).tolist())))
        answer: dict[str, object] = {"ring_mm": round(1e3 * float(place), 3)}
        try:
            answer |= coarse(moved, sigma, start, _RING_CYCLES)
        except CycleMapError as refusal:
            answer["refused"] = str(refusal)
        found.append(answer)
        if progress is not None:
            progress((number + 1) / RING_STEPS)
    return found


def report_html(
    portrait: Portrait,
    start: float,
    rings: Sequence[Mapping[str, object]],
    picture: bytes,
    command: str,
    *,
    pairs: Theta0Pairs | None = None,
    sections: Sequence[Section] = (),
    downloads: Sequence[Download] = (),
    inputs: Sequence[Path] = (),
) -> str:
    """The report as HTML.

    start : rad, of the animated cycles and the staircase. rings : of `ring_answers`. picture : the portrait as PNG,
    shown where scripts do not run. command : that made it. pairs : measured orientations. sections : what else is
    told, in order. downloads : files to take away. inputs : files read, told with their digests.
    """
    files = {name: _file(name) for name in ("explorer/page.css", "report/report.css", "explorer/uplot/uPlot.min.css")}
    style = "\n".join(files.values())
    plot = _file("explorer/uplot/uPlot.iife.min.js")
    drawing = _file("explorer/drawing.js").replace("export class", "class")
    script = f"{drawing}\n{_file('report/report.js')}"
    answer = of_portrait(portrait, start)
    versions = [f"{name} {metadata.version(name)}" for name in _PACKAGES]
    provenance = [
        ("command", command),
        ("seed", str(portrait.staircase.seed)),
        *((f"input {path.name}", f"SHA-256 {hashlib.sha256(path.read_bytes()).hexdigest()}") for path in inputs),
        ("material", portrait.loop.material.provenance or "as named on the command line"),
        ("versions", ", ".join([*versions, f"Python {platform.python_version()}"])),
    ]
    policy = (
        f"default-src 'none'; script-src {_digest(plot)} {_digest(script)}; style-src {_digest(style)}; img-src data:; "
        "base-uri 'none'; form-action 'none'"
    )
    page = jinja2.Environment(autoescape=True, undefined=jinja2.StrictUndefined, trim_blocks=True, lstrip_blocks=True)
    return page.from_string(_file("report/report.html")).render(
        name=portrait.loop.material.name,
        answer=answer,
        data={"answer": answer, "rings": list(rings), "measured": measured(pairs)},
        picture=base64.b64encode(picture).decode(),
        policy=policy,
        style=style,
        plot=plot,
        script=script,
        sections=sections,
        downloads=downloads,
        provenance=provenance,
    )


def _digest(text: str) -> str:
    return f"'sha256-{base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()}'"


def _file(name: str) -> str:
    return resources.files("cyclemap.views").joinpath(name).read_text(encoding="utf-8")
