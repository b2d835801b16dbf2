"""The gallery's pictures and tables, as `cyclemap figures all --out docs/gallery` left them in
docs/gallery.

`figures.json` there lists the entries, each with name, title, source, caption, file and the
measured data that were used, if any. `{gallery}` shows them all; `{gallery-picture} name` shows
one, by its name or its file; both say how to make what is not there.
"""

import csv
import json
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.docutils import SphinxDirective

LOGGER = logging.getLogger(__name__)
FOLDER = "gallery"
HOW = "cyclemap figures all --out docs/gallery"
PICTURES = {".png", ".svg", ".gif"}


def entries(folder: Path) -> list[dict[str, Any]]:
    """The entries of figures.json, in order; none where it is not there."""
    file = folder / "figures.json"
    return list(json.loads(file.read_text(encoding="utf-8"))["figures"]) if file.exists() else []


class Gallery(SphinxDirective):
    """All entries, one after the other, each under an anchor of its name."""

    def run(self) -> list[nodes.Node]:
        """Return the sections, or a note how to make the pictures."""
        self.env.note_dependency(f"{FOLDER}/figures.json")
        found = entries(Path(self.env.srcdir) / FOLDER)
        return [node for entry in found for node in self.shown(entry)] or [
            missing("The pictures are not here yet")
        ]

    def shown(self, entry: dict[str, Any]) -> list[nodes.Node]:
        """Return one entry as a section."""
        anchor = nodes.make_id(f"figure-{entry['name']}")
        section = nodes.section("", nodes.title(text=entry["title"]), ids=[anchor])
        # Other pages lead here by {ref}`figure-NAME`.
        self.env.domains.standard_domain.note_hyperlink_target(
            anchor, self.env.docname, anchor, entry["title"]
        )
        self.state.document.note_explicit_target(section)
        section += about(entry)
        section += exhibit(Path(self.env.srcdir) / FOLDER, entry)
        section += paragraph(str(entry["caption"]))
        return [section]


class GalleryPicture(SphinxDirective):
    """One exhibit with its caption, by its name, or without it, by that of its file; a note where
    it is not there.
    """

    required_arguments = 1
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Return the picture."""
        name, folder = self.arguments[0], Path(self.env.srcdir) / FOLDER
        self.env.note_dependency(f"{FOLDER}/figures.json")
        for entry in entries(folder):
            if entry["name"] == name:
                return [*exhibit(folder, entry), paragraph(str(entry["caption"]))]
            if entry.get("file") == name:
                return exhibit(folder, entry)
        return [missing(f"{name} is not here yet")]


def about(entry: dict[str, Any]) -> nodes.Node:
    """The line that tells where a figure stands in the paper, how it is made, and from what."""
    line = nodes.paragraph(classes=["figure-source"])
    line += nodes.Text(f"{capital(str(entry['source']))}. Made by ")
    line += nodes.literal(text=f"cyclemap figures {entry['name']}")
    line += nodes.Text(f". Measured data: {entry['measured']}." if entry.get("measured") else ".")
    return line


def exhibit(folder: Path, entry: dict[str, Any]) -> list[nodes.Node]:
    """The pictures of an entry, or its table; a warning for a file that is not there."""
    shown: list[nodes.Node] = []
    listed = entry.get("files") or [entry["file"]]
    for name in [listed] if isinstance(listed, str) else listed:
        path = folder / Path(name).name
        if not path.is_file():
            LOGGER.warning("docs/gallery/figures.json names %s, which is not there", name)
        elif path.suffix in PICTURES:
            shown.append(picture(path.name, str(entry["title"])))
        elif path.suffix == ".csv":
            shown.append(table(list(csv.reader(path.read_text(encoding="utf-8").splitlines()))))
        else:
            shown.append(
                nodes.literal_block(text=path.read_text(encoding="utf-8"), language="text")
            )
    return shown


def picture(name: str, words: str) -> nodes.Node:
    """A picture of the gallery, with words for who cannot see it."""
    return nodes.image(uri=f"/{FOLDER}/{name}", alt=words)


def table(rows: list[list[str]]) -> nodes.Node:
    """A table whose first row is its header."""
    group = nodes.tgroup(cols=len(rows[0]))
    group += [nodes.colspec(colwidth=1) for _ in rows[0]]
    group += nodes.thead("", table_row(rows[0]))
    group += nodes.tbody("", *(table_row(row) for row in rows[1:]))
    return nodes.table("", group)


def table_row(cells: list[str]) -> nodes.Node:
    """One row."""
    return nodes.row("", *(nodes.entry("", nodes.paragraph(text=cell)) for cell in cells))


def paragraph(text: str) -> nodes.Node:
    """A paragraph of plain text."""
    return nodes.paragraph(text=text)


def missing(what: str) -> nodes.Node:
    """A note that says how to make what is not there."""
    words = nodes.paragraph(
        "", nodes.Text(f"{what}. To make all of the gallery: "), nodes.literal(text=HOW)
    )
    return nodes.note("", words)


def capital(text: str) -> str:
    """A text with its first letter large."""
    return text[:1].upper() + text[1:]


def setup(app: Sphinx) -> dict[str, bool]:
    """Register both directives."""
    app.add_directive("gallery", Gallery)
    app.add_directive("gallery-picture", GalleryPicture)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
