"""--set and protocol files: what is understood, what is refused, and which of two wins."""

import math

import pytest

from cyclemap.cli.options import LoopOptions
from cyclemap.cli.settings import chosen_loop, set_settings
from cyclemap.errors import DataFileError, InvalidInput
from cyclemap.resets import read_protocol


@pytest.fixture
def protocol(tmp_path):
    def write(text):
        path = tmp_path / "protocol.toml"
        path.write_text(text, encoding="utf-8")
        return path

    return write


@pytest.mark.parametrize("text", ["mu_a", "=3", "mu_a=", " = ", ""])
def test_set_without_key_or_value_is_refused(text) -> None:
    with pytest.raises(InvalidInput, match="is not of the form key=value"):
        set_settings([text])


def test_later_set_wins() -> None:
    assert set_settings(["mu_a=0.1", "mu_a = 0.2"]) == {"mu_a": 0.2}


def test_protocol_tables_are_headings_only(protocol) -> None:
    path = protocol('push_mm = 140\n[pusher]\npusher_mu = 0.2\n[slider]\nfootprint = "grid:8"\n')
    assert read_protocol(path)[0] == {"push_mm": 140, "pusher_mu": 0.2, "footprint": "grid:8"}


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("[push\n", "not TOML"),
        ("[push]\nside = true\n", ", line 2: side is True; it must be a number, text"),
        ("[push]\n[push.deeper]\nside = 1\n", ", line 2: deeper is {'side': 1}; it must be a number, text"),
        ("[push]\nside = 1\nmu_a = 'rough'\n", ", line 3: mu_a must be a finite number, not 'rough'"),
        ("[[strategy.actions]]\nside = 0\n[push]\nsdie = 1\n", ", line 4: unknown setting 'sdie': did you mean 'si"),
        ("[a]\nside = 1\n[b]\nside = 2\n", ", line 4: side is given twice"),
    ],
)
def test_bad_protocol_is_refused_by_file_and_line(protocol, text, said) -> None:
    path = protocol(text)
    with pytest.raises(DataFileError) as refusal:
        read_protocol(path)
    assert str(path) in str(refusal.value)
    assert said in str(refusal.value)


def test_absent_protocol_is_refused(tmp_path) -> None:
    with pytest.raises(DataFileError, match="there is no such file"):
        read_protocol(tmp_path / "none.toml")
    with pytest.raises(DataFileError, match="cannot be read"):
        read_protocol(tmp_path)


def test_set_wins_over_protocol_over_material_over_mit(protocol) -> None:
    path = protocol("[push]\nmu_a = 0.3\nmu_b = 0.28\npusher_mu = 0.2\n")
    loop, sigma = chosen_loop(LoopOptions("plywood", path, ("mu_a=0.31",)))
    friction = loop.material.friction
    assert (friction.mu_a, friction.mu_b, friction.m0) == (0.31, 0.28, 0.0325)
    assert loop.pusher.friction == 0.2
    assert loop.pusher.radius == 0.00475
    assert sigma is None


def test_noise_is_read_in_degrees() -> None:
    _, sigma = chosen_loop(LoopOptions("plywood", None, ("noise_deg=2.5",)))
    assert sigma == pytest.approx(math.radians(2.5))


@pytest.mark.parametrize("text", ["noise_deg=0", "noise_deg=-1", "noise_deg=nan", "noise_deg=loud"])
def test_noise_must_be_positive(text) -> None:
    with pytest.raises(InvalidInput, match="noise_deg"):
        chosen_loop(LoopOptions("plywood", None, (text,)))


@pytest.mark.parametrize(("key", "meant"), [("mu_aa", "mu_a"), ("nois_deg", "noise_deg"), ("push_mn", "push_mm")])
def test_unknown_key_names_the_one_that_was_meant(key, meant) -> None:
    with pytest.raises(InvalidInput, match=f"'{key}'.*did you mean '{meant}'"):
        chosen_loop(LoopOptions("plywood", None, (f"{key}=1",)))
