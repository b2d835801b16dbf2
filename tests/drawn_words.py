"""Whether the words of a picture can be read: the boxes of the renderer tell which lie over others
or stick out.
"""

from itertools import combinations

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.text import Annotation, Text

# Points by which words may touch: their boxes have room for letters that are not there.
_TOUCH = 2.0


def assert_words_apart(figure: Figure) -> None:
    """No two texts of the figure lie over each other, tick labels and legends among them, and none
    sticks out of it.
    """
    figure.canvas.draw()
    renderer = figure.canvas.get_renderer()
    # Of an annotation the words alone, without its arrow.
    boxes = [
        (text.get_text(), Text.get_window_extent(text, renderer))
        for text in words_of_figure(figure)
    ]
    assert boxes
    for words, box in boxes:
        inside = (
            box.x0 >= -1
            and box.y0 >= -1
            and box.x1 <= figure.bbox.x1 + 1
            and box.y1 <= figure.bbox.y1 + 1
        )
        assert inside, f"{words!r} sticks out of the picture"
    for (first, one), (second, other) in combinations(boxes, 2):
        apart = (
            one.x1 - _TOUCH <= other.x0
            or other.x1 - _TOUCH <= one.x0
            or one.y1 - _TOUCH <= other.y0
            or other.y1 - _TOUCH <= one.y0
        )
        assert apart, f"{first!r} lies over {second!r}"


def words_of_figure(figure: Figure) -> list[Text]:
    """The texts that a figure shows once it is drawn."""
    renderer = figure.canvas.get_renderer()
    hidden = {id(text) for axes in figure.findobj(Axes) for text in _hidden_ticks(axes)}
    shown = [
        text for text in figure.findobj(Text) if text.get_visible() and text.get_text().strip()
    ]
    return [
        text
        for text in shown
        if id(text) not in hidden
        and not (isinstance(text, Annotation) and not text._check_xy(renderer))
    ]


def _hidden_ticks(axes: Axes) -> list[Text]:
    """Labels of ticks that are out of the window, or of axes that are switched off."""
    found: list[Text] = []
    for axis in axes._axis_map.values():
        drawn = (
            [label for tick in axis._update_ticks() for label in (tick.label1, tick.label2)]
            if axes.axison
            else []
        )
        keep = {id(label) for label in drawn} | (
            {id(axis.label), id(axis.offsetText)} if axes.axison else set()
        )
        found += [text for text in axis.findobj(Text) if id(text) not in keep]
    return found
