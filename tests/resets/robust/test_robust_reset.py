"""Drawn pushes for a range, checked on materials drawn anew: counts, shares, corners, and what cannot be made."""

import os
import signal
import subprocess
import sys
import time
from dataclasses import replace
from functools import partial
from pathlib import Path

import numpy as np
import pytest
from robust_cases import EVEN, GRID, NOISE, ROUGH, SHORT, short_loop

from cyclemap.errors import InvalidInput
from cyclemap.resets.robust.material_range import MaterialRange
from cyclemap.resets.robust.robust_reset import corner_check, robust_reset
from cyclemap.resets.robust.sampling_confidence import share_bound
from cyclemap.resets.robust.scenario_weights import scenario_row
from cyclemap.resets.robust.worst_case import Allowance, spread_work
from cyclemap.resets.strategies.push_strategies import AlternatingPushes, DrawnPushes, side_pushes

LOOP, ABOUT = short_loop(ROUGH), MaterialRange(ROUGH)
CHOICE = side_pushes(SHORT, (0, 2))
LOOSE = Allowance(total_variation=0.5, reach=0.5, pushes=30)
QUICK = replace(GRID, samples=8)
OPTIONS = {"pushes": CHOICE, "noise": NOISE, "grid": QUICK, "starts": 1}


@pytest.fixture(scope="module")
def held():
    return robust_reset(LOOP, ABOUT, allowance=LOOSE, count=6, slants=(), **OPTIONS)


def test_the_check_has_the_corners_and_as_many_drawn_materials_as_asked_for(held):
    """2³ corners of ratio, m0 and n0 about the nominal one; six drawn: none exceeds, so 1 - .05^(1/6) bounds."""
    assert held.holds and not held.slanted and len(held.check.scores) == 1 + 8 + 6
    assert (held.drawn, held.exceeding_drawn) == (6, 0)
    assert held.check.share_exceeding == share_bound(0, 6) == pytest.approx(1.0 - 0.05 ** (1 / 6))
    assert sum(held.strategy.chances) == pytest.approx(1.0) and held.mean_drag_ratio < 2.0
    weights = held.strategy.weights
    assert weights == tuple(round(weight, 4) for weight in weights) and set(held.strategy.pushes) <= set(CHOICE)


def test_drawn_materials_of_the_check_are_none_that_the_pushes_were_made_with(held):
    """Else the bound on the share would be no bound."""
    drawn = held.check.sample.materials[held.check.sample.chosen :]
    used = {one.friction for one in (*held.made.scenarios, *held.made.check.sample.materials)}
    assert len(drawn) == 6 and not {one.friction for one in drawn} & used


def test_changes_are_those_of_the_materials(held):
    """Two routes: the coordinates of the sample, and the friction of its materials."""
    laws = [material.friction for material in held.check.sample.materials]
    own = ROUGH.friction
    assert held.changes("m0") == pytest.approx([law.m0 / own.m0 - 1.0 for law in laws])
    ratio = [law.mu_a / law.mu_b / (own.mu_a / own.mu_b) - 1.0 for law in laws]
    assert held.changes("ratio") == pytest.approx(ratio) and np.abs(held.changes("ratio")).max() == pytest.approx(0.1)
    with pytest.raises(InvalidInput, match="no 'phi': it has ratio, m0, n0"):
        held.changes("phi")


def test_the_corners_of_another_strategy_are_those_of_the_check(held):
    """The robust pushes themselves have the same scores there; what alternates has none."""
    corners = corner_check(LOOP, held.strategy, ABOUT, held, noise=NOISE, grid=QUICK)
    assert corners.scores == held.check.scores[:9] and len(corners.scores) == 9
    assert corner_check(LOOP, AlternatingPushes(CHOICE), ABOUT, held) is None


def test_what_cannot_be_kept_is_tried_with_slanted_pushes_and_then_told():
    strict = Allowance(total_variation=1e-4, reach=0.5, pushes=30)
    narrow, stages = MaterialRange(ROUGH, offset=0.0), []
    made = robust_reset(
        LOOP, narrow, allowance=strict, count=2, slants=(0.3,), progress=lambda name, _: stages.append(name), **OPTIONS
    )
    assert not made.holds and made.slanted and made.exceeding_drawn == 2 and made.check.share_exceeding == 1.0
    assert list(dict.fromkeys(stages)) == ["robust pushes", "robust pushes, slanted too", "checking on 2 materials"]
    excess = [strict.excess(score) for score in made.check.scores]
    assert made.worst_material is made.check.sample.materials[int(np.argmax(excess))] and max(excess) > 0.0
    angles = {push.angle for push in made.strategy.pushes}
    assert angles <= {0.0, 0.3} and set(made.made.scenarios) >= set(narrow.without_direction().scenarios().materials)


def test_pushes_that_need_too_much_room_are_left_out():
    with pytest.raises(InvalidInput, match="no push keeps to reach and contact"):
        robust_reset(LOOP, ABOUT, reach=0.01, **OPTIONS)
    with pytest.raises(InvalidInput, match="no push keeps to reach and contact"):
        robust_reset(LOOP, ABOUT, contact=1.1 * SHORT.distance, **OPTIONS)


def test_scenarios_come_from_processes_as_from_one():
    """Maps cannot be sent between processes; what is sent makes the same maps."""
    row = partial(scenario_row, LOOP, CHOICE, QUICK)
    once, twice = (list(spread_work(row, [ROUGH, EVEN], workers)) for workers in (1, 2))
    assert len(twice) == 2
    for one, other in zip(once, twice, strict=True):
        assert np.array_equal(one.cycles.lifted, other.cycles.lifted) and one.own_drag == other.own_drag
        assert float(one.maps[1](0.3)) == float(other.maps[1](0.3))


SLEEPERS = """
import multiprocessing, threading, time
from cyclemap.resets.robust.worst_case import spread_work
if __name__ == "__main__":
    def tell():
        while len(multiprocessing.active_children()) < 2:
            time.sleep(0.02)
        print(*(child.pid for child in multiprocessing.active_children()), flush=True)
    threading.Thread(target=tell, daemon=True).start()
    list(spread_work(time.sleep, [0.01] * 4 + [60.0] * 4, 2))
"""


@pytest.mark.skipif(not Path("/proc/self/stat").exists(), reason="asks about processes as Linux does")
def test_workers_end_with_the_process_that_started_them(tmp_path):
    """A kill that the parent cannot answer leaves no worker behind."""
    script = tmp_path / "sleepers.py"
    script.write_text(SLEEPERS)
    with subprocess.Popen([sys.executable, str(script)], stdout=subprocess.PIPE, text=True) as parent:
        workers = [int(word) for word in parent.stdout.readline().split()]
        assert len(workers) == 2
        time.sleep(0.3)
        parent.send_signal(signal.SIGKILL)
        parent.wait(10)
    due = time.monotonic() + 20.0
    while any(_alive(worker) for worker in workers) and time.monotonic() < due:
        time.sleep(0.05)
    assert not any(_alive(worker) for worker in workers)


def _alive(process: int) -> bool:
    try:
        os.kill(process, 0)
    except ProcessLookupError:
        return False
    # One that ended and that nobody has asked about is no more.
    return Path(f"/proc/{process}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"


def test_on_even_friction_alone_one_push_holds():
    """Rotations by one angle: the bias is none, whatever is drawn."""
    about = MaterialRange(EVEN, ratio=0.0)
    one = robust_reset(short_loop(EVEN), about, allowance=Allowance(reach=1.0), count=1,
                       **{**OPTIONS, "pushes": CHOICE[:1]})  # fmt: skip
    assert one.holds and one.strategy == DrawnPushes(CHOICE[:1], weights=(1.0,))
    assert one.check.nominal.total_variation < 1e-6
