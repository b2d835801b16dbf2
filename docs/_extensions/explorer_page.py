"""The explorer inside a page: `{explorer} MATERIAL key=value ...` shows the page of `cyclemap
explore` in a frame.

Pages of the same words are written once; nothing of them comes from a network.
"""

import hashlib
from pathlib import Path
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective
from sphinx.util.osutil import relative_uri

from cyclemap.collection import CollectionLoop, portrait
from cyclemap.protocol import loop_from_settings
from cyclemap.protocol.chosen_loop import set_settings
from cyclemap.views.explorer_page import page_html

FOLDER = "_static/explorer"
# Pixels that the pictures and half the sliders fill.
HEIGHT = 900


class Explorer(SphinxDirective):
    """The page of a material with settings, in a frame, with a link to it alone."""

    required_arguments = 1
    optional_arguments = 20
    has_content = False

    def run(self) -> list[nodes.Node]:
        """Write the page where it is not there yet; return its frame."""
        words = " ".join(self.arguments).split()
        name = f"{words[0]}-{hashlib.sha256(' '.join(words).encode()).hexdigest()[:8]}.html"
        place = Path(self.env.app.outdir) / FOLDER / name
        if not place.exists():
            place.parent.mkdir(parents=True, exist_ok=True)
            place.write_text(page_of(words[0], words[1:]), encoding="utf-8")
        address = relative_uri(
            self.env.app.builder.get_target_uri(self.env.docname), f"{FOLDER}/{name}"
        )
        title = f"cyclemap explore {' '.join(words)}"
        frame = (
            f'<iframe class="explorer" src="{address}" title="{title}" loading="lazy" '
            f'height="{HEIGHT}"></iframe>'
        )
        link = f'<p class="explorer-link"><a href="{address}">Open it alone</a></p>'
        return [nodes.raw("", frame + link, format="html")]


def page_of(material: str, words: list[str]) -> str:
    """The page of a material with settings as on the command line."""
    settings = set_settings(words)
    loop = loop_from_settings(settings, CollectionLoop.mit(material))
    return page_html(portrait(loop), 0.0, (material,), settings)


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directive."""
    app.add_directive("explorer", Explorer)
    return {"version": "1", "parallel_read_safe": True}
