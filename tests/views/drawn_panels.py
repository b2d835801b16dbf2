"""What the tests of the panels share: an empty panel, its picture, and its artists picked by how they look."""

from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from cyclemap.views import style


def panel(width: float = 6.0, height: float = 4.0) -> Axes:
    with style.picture_style():
        return style.new_figure(width, height).add_subplot()


def png(axes: Axes) -> bytes:
    """The picture; the legend must stand above the panel, where it covers nothing."""
    figure = axes.get_figure()
    picture = style.render(figure, "png", 60)
    assert picture.startswith(b"\x89PNG")
    legend = axes.get_legend()
    if legend is not None:
        renderer = figure.canvas.get_renderer()
        assert legend.get_window_extent(renderer).y0 >= axes.get_window_extent(renderer).y1 - 1
    return picture


def legend_words(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.get_legend().get_texts()]


def written(axes: Axes) -> list[str]:
    return [text.get_text() for text in axes.texts]


def labelled(axes: Axes, start: str) -> Line2D:
    """The one line whose legend entry starts so."""
    found = [line for line in axes.lines if str(line.get_label()).startswith(start)]
    assert len(found) == 1, f"{len(found)} lines are labelled {start!r}"
    return found[0]
