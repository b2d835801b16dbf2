"""The portrait of a collection loop on one landscape page."""

from __future__ import annotations

from textwrap import fill
from typing import TYPE_CHECKING, Any

from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.gridspec import GridSpec

from cyclemap.collection.portrait import Portrait
from cyclemap.collection.portrait_curves import PortraitCurves
from cyclemap.views import map_panels, sentences
from cyclemap.views.object_page import cycle_key, draw_cycle
from cyclemap.views.style import QUIET, new_figure, picture_style

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay


LINE_LETTERS = 175
# The top of its panel, where titles stand anyway; said, it spares Matplotlib the measuring of every tick label.
_TITLE_PLACE = 1.0
# A legend of four entries stands beside the longest title.
_NARROW: dict[str, Any] = {"handlelength": 1.2, "handletextpad": 0.4, "columnspacing": 0.8, "fontsize": 7.5}
# So many letters of a headline fill the page at full size.
_HEADLINE_LETTERS = 84


def portrait_page(portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None = None) -> Figure:
    """Draw `portrait`, whose curves are `curves`, with `measured` over it where given."""
    with picture_style():
        figure = new_figure()
        grid = GridSpec(
            2, 3, figure, width_ratios=(5.2, 2.75, 3.2), left=0.055, right=0.99, bottom=0.145, top=0.80,
            wspace=0.24, hspace=0.42,
        )  # fmt: skip
        panels = [figure.add_subplot(grid[row, column]) for column in range(3) for row in range(2)]
        turn, density, cobweb, staircase, push, drag = panels
        known = portrait.uncertainty
        map_panels.draw_turn(turn, curves.turn, portrait.fixed_points, () if known is None else known.directions)
        if measured is not None:
            map_panels.draw_measured_turns(turn, measured.pairs, measured.bins)
        turn.set_title("Turn of one cycle" + (", fresh" if portrait.worn is not None else ""), y=_TITLE_PLACE)
        _legend_above(turn)
        map_panels.draw_density(density, curves)
        if measured is not None:
            map_panels.draw_measured_histogram(density, measured.histogram)
        density.set_ylim(bottom=0.0)
        density.set_title("Directions recorded", y=_TITLE_PLACE)
        _legend_above(density)
        map_panels.draw_cobweb(cobweb, curves.cobweb, portrait.fixed_points)
        place = "the jump" if portrait.gathering_jumps else "the slowest direction"
        place = "the stable direction" if portrait.stable_points else place
        whole = curves.cobweb.high - curves.cobweb.low > 6.2
        cobweb.set_title("Cobweb" if whole else f"Cobweb about {place}", y=_TITLE_PLACE)
        path = None if measured is None else measured.pairs.path
        map_panels.draw_staircase(staircase, portrait.staircase.theta, path)
        staircase.set_title("Staircase", y=_TITLE_PLACE)
        if path is not None:
            staircase.legend(loc="upper left")
        draw_cycle(push, drag, curves.scene)
        cycle = portrait.cycle
        push.set_title(
            f"Push from {sentences.angle(cycle.theta)}: turns {sentences.angle(cycle.push_turn)}", y=_TITLE_PLACE
        )
        drag.set_title(f"Drag by the ring: turns {sentences.angle(cycle.drag_turn)}", y=_TITLE_PLACE)
        _write_words(figure, portrait, curves, measured)
    return figure


def _legend_above(axes: Axes) -> None:
    """A legend of one row on the title's line, where it can cover nothing."""
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=4, borderaxespad=0.2, **_NARROW)


def _write_words(figure: Figure, portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None) -> None:
    material, said = portrait.loop.material, sentences.headline(portrait)
    known = sentences.uncertainty_sentence(material.name, portrait.uncertainty)
    size = 18.0 * min(1.0, _HEADLINE_LETTERS / len(said))
    figure.text(0.015, 0.955, said, fontsize=size, fontweight="bold", va="center")
    tellers = (sentences.lock_sentence, sentences.noise_sentence, sentences.staircase_sentence)
    told = fill(" ".join([*(tell(portrait) for tell in tellers), known]), LINE_LETTERS)
    figure.text(0.015, 0.928, told, fontsize=10, va="top", linespacing=1.35)
    inferred = f"{material.name} was inferred, not measured  ·  " if material.inferred else ""
    how = f"{sentences.push_line(portrait)}  ·  {sentences.accuracy_line(portrait)}"
    foot = [sentences.parameters_line(portrait), f"{inferred}{how}"]
    if measured is not None:
        foot.append(sentences.agreement_sentence(measured.agreement))
    figure.text(0.015, 0.06, "\n".join(foot), fontsize=8, color=QUIET, va="top", linespacing=1.35)
    figure.text(0.985, 0.06, cycle_key(curves.scene), fontsize=8, color=QUIET, va="top", ha="right", linespacing=1.35)
