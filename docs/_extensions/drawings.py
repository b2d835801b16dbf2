"""The site's own drawings, made when it is built: each module of `_figures` draws one, into
`_build/drawn`.
"""

from importlib import import_module
from pathlib import Path

from sphinx.application import Sphinx

from cyclemap.views.panels.layout import render
from cyclemap.views.panels.style import picture_style

DRAWN = Path("_build") / "drawn"


def draw_all(app: Sphinx) -> None:
    """Draw what is missing or older than its module."""
    for module in sorted((Path(app.srcdir) / "_figures").glob("[a-z]*.py")):
        picture = Path(app.srcdir) / DRAWN / f"{module.stem}.png"
        if not picture.exists() or picture.stat().st_mtime < module.stat().st_mtime:
            picture.parent.mkdir(parents=True, exist_ok=True)
            picture.write_bytes(drawn(module.stem))


def drawn(name: str) -> bytes:
    """The picture that a module of `_figures` draws, as PNG."""
    with picture_style():
        return render(import_module(f"_figures.{name}").draw(), "png", dpi=144)


def setup(app: Sphinx) -> dict[str, bool]:
    """Draw before the pages are read."""
    app.connect("builder-inited", draw_all)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
