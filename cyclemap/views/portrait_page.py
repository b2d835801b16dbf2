"""The portrait of a loop on one page: turn, directions, cobweb, staircase, and a cycle to scale."""

from __future__ import annotations

from typing import TYPE_CHECKING

from matplotlib.figure import Figure

from cyclemap.collection.portrait import Portrait
from cyclemap.collection.portrait_curves import PortraitCurves
from cyclemap.views import map_panels, sentences, style
from cyclemap.views.object_page import cycle_key, draw_cycle
from cyclemap.views.staircase_panels import draw_staircase

if TYPE_CHECKING:
    from cyclemap.evidence import MeasuredOverlay


@style.picture_style()
def portrait_page(
    portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None = None
) -> Figure:
    """Draw `portrait`, whose curves are `curves`, with `measured` over it where given."""
    figure = style.new_figure()
    room = _write_words(figure, portrait, curves, measured)
    panels = style.panels(figure, "abc;def", room, width_ratios=(5.2, 2.75, 3.2))
    turn, cobweb, push, density, staircase, drag = panels
    map_panels.draw_turn(turn, curves.turn)
    map_panels.mark_fixed_points(turn, portrait.fixed_points)
    if portrait.uncertainty is not None:
        map_panels.draw_intervals(turn, portrait.uncertainty.directions)
    map_panels.draw_density(density, curves.density_theta, curves.density)
    map_panels.draw_cobweb(cobweb, curves.cobweb, portrait.fixed_points)
    draw_staircase(
        staircase,
        portrait.staircase.theta,
        None if measured is None else measured.pairs.path,
    )
    if measured is not None:
        map_panels.draw_measured_turns(turn, measured.pairs, measured.bins)
        map_panels.draw_recorded(density, measured.histogram)
    draw_cycle(push, drag, curves.scene)
    cycle = portrait.cycle
    start, pushed, dragged = map(sentences.angle, (cycle.theta, cycle.push_turn, cycle.drag_turn))
    titles = (
        f"Turn of one cycle{', fresh' * (portrait.worn is not None)}",
        _cobweb_title(portrait, curves),
        f"Push from {start}: turns {pushed}",
        "Directions recorded",
        "Staircase",
        f"Drag by the ring: turns {dragged}",
    )
    for axes, title in zip(panels, titles, strict=True):
        style.entitle(axes, title)
    return figure


def _cobweb_title(portrait: Portrait, curves: PortraitCurves) -> str:
    """Of what place the cobweb is, where it does not show the whole circle."""
    if curves.cobweb.high - curves.cobweb.low > 6.2:
        return "Cobweb"
    if portrait.stable_points:
        return "Cobweb about the stable direction"
    return f"Cobweb about the {'jump' if portrait.gathering_jumps else 'slowest direction'}"


def _write_words(
    figure: Figure, portrait: Portrait, curves: PortraitCurves, measured: MeasuredOverlay | None
) -> style.Room:
    material = portrait.loop.material
    told = [
        sentences.lock_sentence(portrait),
        sentences.noise_sentence(portrait),
        sentences.staircase_sentence(portrait),
        sentences.uncertainty_sentence(material.name, portrait.uncertainty),
    ]
    inferred = f"{material.name} was inferred, not measured  ·  " if material.inferred else ""
    how = f"{sentences.push_line(portrait)}  ·  {sentences.accuracy_line(portrait)}"
    foot = [sentences.parameters_line(portrait), f"{inferred}{how}"]
    if measured is not None:
        foot.append(sentences.agreement_sentence(measured.agreement))
    said, key = sentences.headline(portrait), cycle_key(curves.scene)
    return style.write_page(figure, said, told, "\n".join(foot), key)
