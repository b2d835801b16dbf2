"""What the tests of drawn figures share: no empty panel, axes labelled with units, no words over each other."""

import re

from drawn_words import assert_words_apart, words_of_figure
from matplotlib.figure import Figure

from cyclemap.views.style import render

UNIT = re.compile(r"\((mm|°|1|N|per degree)\)")
DIMENSIONLESS = ("coefficient", "cycle")


def assert_drawn(figure: Figure, panels: int) -> None:
    """A picture comes out; so many panels, bars of shades among them, none empty, all with units, words apart."""
    assert render(figure, "png", 60).startswith(b"\x89PNG")
    assert len(figure.axes) == panels
    for axes in figure.axes:
        assert axes.lines or axes.collections or axes.patches, "an empty panel"
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or UNIT.search(label) or any(word in label for word in DIMENSIONLESS), label
        assert axes.get_xlabel() or axes.get_ylabel()
    assert_words_apart(figure)


def words_of(figure: Figure) -> str:
    """All texts of the figure and its panels, legends included, in one line."""
    return " | ".join(text.get_text() for text in words_of_figure(figure))
