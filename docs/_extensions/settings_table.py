"""The table of all that `--set` and files may say, made from the settings' own table: `{settings}`
shows it.
"""

import math

from docutils import nodes
from docutils.statemachine import StringList
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

from cyclemap import CollectionLoop
from cyclemap.protocol.settings import SETTINGS


def markdown() -> str:
    """The table in Markdown: key, fact, usual range, and what MIT's experiment has."""
    mit = CollectionLoop.mit()
    lines = ["| key | fact | usual | MIT's experiment |", "|---|---|---|---|"]
    for key, one in SETTINGS.items():
        usual = (
            f"{one.low:g} to {one.high:g}" if math.isfinite(one.low) and one.low < one.high else ""
        )
        default = one.default or f"{one.of(mit) / float(one.unit.in_si):.6g}"
        lines.append(f"| `{key}` | {one.meaning} | {usual} | {default} |")
    return "\n".join(lines) + "\n"


class SettingsTable(SphinxDirective):
    """The table, as Markdown of the page."""

    def run(self) -> list[nodes.Node]:
        """Return the parsed table."""
        section = nodes.container()
        self.state.nested_parse(
            StringList(markdown().splitlines(), "settings"), self.content_offset, section
        )
        return section.children


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the directive."""
    app.add_directive("settings", SettingsTable)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
