"""Every figure comes out without measured data, and its caption alone tells what was not found."""

import pytest
from figure_cases import assert_drawn, small, words_of

from cyclemap.figures import NO_DATA, load_exhibit

# Panels, bars of shades among them, and whether measured data are drawn where there are some. The
# figures of four materials and the paths of pushes are drawn in tests of their own.
FIGURES = {
    "anisotropic-against-isotropic": (4, False),
    "dynamic-against-quasi-static": (3, False),
    "phase-diagram": (3, False),
    "force-ratio": (1, True),
    "fingerprint": (3, False),
    "saddle-node": (6, False),
    "setup-and-cycle": (2, False),
    "limit-ellipse-and-patch": (3, True),
    "simulated-against-measured": (2, True),
    "floor-shape": (6, True),
    "staircase-bottleneck": (4, True),
    "wear-drift": (3, True),
}
QUICK = 4
# Of setup-and-cycle an independent solver has +72.409 and -49.512 degrees at θ0 = 270 degrees on
# Table I's plywood.
TOLD = {
    "setup-and-cycle": ("90 mm", "150 mm", "18 mm", "15 mm", "270°", "72.4°", "-49.5°", "292.9°"),
    "fingerprint": ("Ω 8.00°", "59.4° ± 21.1°", "3.8° away, within that error", "21.3 mm"),
    "saddle-node": ("9.793 mm", "13 mm", "162.", "square root"),
    "floor-shape": ("8.0°", "16.0°", "2.9° to 27.5°", "12.2°", "half a turn further"),
    "locking-in": ("57°", "63°", "after 8 cycles"),
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (k >= QUICK)) for k, name in enumerate(FIGURES)],
)
def test_a_figure_is_drawn_without_measured_data_and_its_caption_tells_so(name) -> None:
    panels, measured = FIGURES[name]
    exhibit, result = load_exhibit(name), small(name)
    figure = exhibit.draw(result)
    assert_drawn(figure, panels)
    assert NO_DATA not in words_of(figure).lower()
    assert (NO_DATA in exhibit.caption(result).lower()) == measured


@pytest.mark.slow
@pytest.mark.parametrize("name", TOLD)
def test_a_caption_tells_the_numbers_of_its_result(name) -> None:
    caption = load_exhibit(name).caption(small(name))
    assert [words for words in TOLD[name] if words not in caption] == []
