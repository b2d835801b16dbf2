"""The replay page draws every push's errors and motions, and a few courses whole."""

import math

import numpy as np
import pandas
import pytest
from drawn_words import assert_words_apart

from cyclemap.evidence import Replay, ReplayedPushes
from cyclemap.evidence.comparison.replay_table import REPLAY_COLUMNS
from cyclemap.mechanics import Slider
from cyclemap.views.push_pages import replay_headline, replay_page


def made_replay(off, turn_off, kind):
    travel = np.linspace(0.0, 0.05, 30)
    measured = np.column_stack([travel, 0.1 * travel, 2.0 * travel])
    predicted = measured + np.outer(travel / 0.05, (off, 0.0, turn_off))
    tip = np.column_stack([travel - 0.06, 0.0 * travel])
    outline = Slider.mit(kind).outline_points()
    told = (0.0, 0.0, 1, True, False, True, True)
    return Replay(travel, measured, predicted, travel, tip, np.zeros(2), outline, *told)


def made(kinds):
    """Replays of objects, the k-th k+1 mm and k+1 degrees off."""
    replays = [
        made_replay(1e-3 * (k + 1), math.radians(k + 1), kind) for k, kind in enumerate(kinds)
    ]
    rows = [
        dict.fromkeys(REPLAY_COLUMNS, 0.0)
        | {"object": kind, "surface": "abs", "speed": 0.02 if k else math.nan}
        | replay.summary()
        for k, (kind, replay) in enumerate(zip(kinds, replays, strict=True))
    ]
    return ReplayedPushes(pandas.DataFrame(rows), tuple(replays), ())


@pytest.mark.slow
@pytest.mark.parametrize("kinds", [["hex"], ["hex", "rect1", "hex", "ellip1", "tri1", "rect1"]])
def test_every_push_is_drawn_once_in_each_upper_panel(kinds) -> None:
    page = replay_page(made(kinds), "abs")
    for axes, others in zip(page.axes[:4], (0, 1, 0, 1), strict=True):
        assert sum(len(line.get_xdata()) for line in axes.lines[others:]) == len(kinds)
    assert_words_apart(page)


def test_the_headline_counts_pushes_and_tells_the_mean_errors() -> None:
    told = [replay_headline(made(kinds)) for kinds in (["hex"], ["hex", "rect1", "hex"])]
    assert told[0] == "1 push replayed: it ends 1.0 mm and 1.0° off on average."
    assert told[1] == "3 pushes replayed: they end 2.0 mm and 2.0° off on average."
