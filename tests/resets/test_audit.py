"""An audit tells a lock-in from a spread, what the reset took back, and says when the data cannot
tell.
"""

import math

import numpy as np
import pytest
from refusals import refused

from cyclemap.resets.audit import audit
from cyclemap.views.panels.layout import render
from cyclemap.views.watch_page import audit_headline, audit_page, audit_paragraph


def table(tmp_path, theta_deg, turn_deg=None, first=0):
    """A CSV file of orientations, or of poses with the turn of each push and its number."""
    path = tmp_path / "log.csv"
    if turn_deg is None:
        path.write_text("theta0_deg\n" + "".join(f"{x}\n" for x in theta_deg))
        return path
    ends = (0.04 - 0.07j) * np.exp(1j * np.radians(np.asarray(theta_deg)))
    rows = [
        f"0,0,{np.radians(a)},{end.real},{end.imag},{np.radians(a + b)},{first + n}"
        for n, (a, b, end) in enumerate(zip(theta_deg, turn_deg, ends, strict=True))
    ]
    path.write_text("x0,y0,th0,x1,y1,th1,rep\n" + "\n".join(rows) + "\n")
    return path


def test_a_collection_that_ends_in_one_direction_is_told_from_which_push_on(tmp_path) -> None:
    """Whatever numbers the data give their pushes, the place among those read is told, as that."""
    noise = np.random.default_rng(1).normal(0.0, 1.0, 60)
    theta = np.concatenate([np.arange(78.0, 420.0, 15.0) % 360.0, 63.0 + noise])
    found = audit(table(tmp_path, theta))
    assert 20 <= found.locked_from <= 30
    assert found.gathered > 0.95 and found.worth < 40 and not found.is_good
    said = audit_paragraph(found)
    assert "locks in from push" in audit_headline(found)
    assert "lock in about 6" in said and "cyclemap reset" in said
    numbered = audit(table(tmp_path, theta, np.full(theta.size, 60.0), first=500))
    assert numbered.locked_from == found.locked_from
    said = f"From push {found.locked_from} on, of those read, counted from 0, they lock in"
    assert said in audit_paragraph(numbered)


def test_orientations_spread_evenly_are_good_as_they_are(tmp_path) -> None:
    theta = np.random.default_rng(2).uniform(0.0, 360.0, 200)
    found = audit(table(tmp_path, theta))
    assert found.locked_from is None and found.is_good and found.gathered == 0.0
    assert "Nothing needs to change" in audit_paragraph(found)


def test_what_covers_the_circle_and_is_worth_less_than_half_its_pushes_is_not_good(
    tmp_path,
) -> None:
    """Once round, then a creep of a quarter turn too fast for a rest: no alarm, and little told."""
    around = np.arange(19) * 360.0 / 19.0
    for step_deg, good in ((5.0, True), (1.21, False)):
        theta = np.concatenate([around, 360.0 + step_deg * np.arange(1, 77)]) % 360.0
        found = audit(table(tmp_path, theta))
        assert found.locked_from is None and len(found.covered) == 1
        assert found.is_good == good == (found.worth >= 0.5 * 95)


def test_part_of_the_circle_is_named_and_too_few_pushes_are_refused(tmp_path) -> None:
    theta = np.random.default_rng(3).uniform(20.0, 160.0, 100)
    found = audit(table(tmp_path, theta))
    assert len(found.covered) == 1 and not found.is_good
    assert np.degrees(found.covered[0]) == pytest.approx([theta.min(), theta.max()])
    refused(audit, table(tmp_path, [1.0, 2.0, 3.0]), told="3 pushes of one set; an audit needs 10")


@pytest.mark.slow
def test_what_the_reset_took_back_is_told_where_poses_tell_it(tmp_path) -> None:
    """Pushes of 60 ± 5 degrees and resets that take back nine tenths of each."""
    turn = 60.0 + np.random.default_rng(4).normal(0.0, 5.0, 80)
    theta = np.concatenate([[0.0], np.cumsum(0.1 * turn)])[:80]
    found = audit(table(tmp_path, theta, turn))
    assert found.reset.undone == pytest.approx(0.9, abs=2e-3)
    assert found.reset.slope == pytest.approx(-0.9, abs=1e-9)
    assert "90% back" in audit_paragraph(found)
    assert render(audit_page(found)).startswith(b"\x89PNG")


def test_no_share_is_told_of_a_turn_that_may_be_none_and_no_slope_of_turns_alike(tmp_path) -> None:
    random = np.random.default_rng(5)
    theta = np.cumsum(random.normal(5.0, 1.0, 60))
    for turn in (np.zeros(60), random.normal(0.0, 1.0, 60)):
        found = audit(table(tmp_path, theta, turn))
        assert math.isnan(found.reset.undone) and "% back" not in audit_paragraph(found)
    alike = audit(table(tmp_path, theta, np.full(60, 60.0)))
    assert math.isnan(alike.reset.slope) and "92% back" in audit_paragraph(alike)
