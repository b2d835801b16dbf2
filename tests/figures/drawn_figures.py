"""What the tests of drawn figures share: no empty panel, axes labelled with units, no words over each other."""

import re
from itertools import combinations

from matplotlib.figure import Figure

from cyclemap.views.style import render

UNIT = re.compile(r"\((mm|°|1|N|per degree)\)")
DIMENSIONLESS = ("coefficient", "cycle")
# Points by which words may touch: their boxes have room for letters that are not there.
_TOUCH = 2.0


def assert_drawn(figure: Figure, panels: int) -> None:
    """A picture comes out; so many panels, bars of shades among them, none empty, all with units, words apart."""
    assert render(figure, "png", 60).startswith(b"\x89PNG")
    assert len(figure.axes) == panels
    for axes in figure.axes:
        assert axes.lines or axes.collections or axes.patches, "an empty panel"
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or UNIT.search(label) or any(word in label for word in DIMENSIONLESS), label
        assert axes.get_xlabel() or axes.get_ylabel()
    assert_no_words_overlap(figure)


def assert_no_words_overlap(figure: Figure) -> None:
    """No two texts, titles and legends of the figure cover each other, and none sticks out of it."""
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    boxes = [(text.get_text(), text.get_window_extent(renderer)) for text in _words(figure)]
    for axes in figure.axes:
        if axes.get_legend() is not None:
            boxes.append((f"legend of {axes.get_title(loc='left')}", axes.get_legend().get_window_extent(renderer)))
    assert boxes
    for words, box in boxes:
        inside = box.x0 >= -1 and box.y0 >= -1 and box.x1 <= figure.bbox.x1 + 1 and box.y1 <= figure.bbox.y1 + 1
        assert inside, f"{words!r} sticks out of the picture"
    for (first, one), (second, other) in combinations(boxes, 2):
        apart = (
            one.x1 - _TOUCH <= other.x0
            or other.x1 - _TOUCH <= one.x0
            or one.y1 - _TOUCH <= other.y0
            or other.y1 - _TOUCH <= one.y0
        )
        assert apart, f"{first!r} lies over {second!r}"


def words_of(figure: Figure) -> str:
    """All texts of the figure and its panels, legends included, in one line."""
    legends = [axes.get_legend() for axes in figure.axes if axes.get_legend() is not None]
    entries = [text for legend in legends for text in legend.get_texts()]
    return " | ".join(text.get_text() for text in [*_words(figure), *entries])


def _words(figure: Figure) -> list:
    titles = [axes.title for axes in figure.axes] + [axes._left_title for axes in figure.axes]
    labels = [axis.label for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    texts = [text for axes in figure.axes for text in axes.texts]
    return [text for text in [*figure.texts, *titles, *labels, *texts] if text.get_text().strip()]
