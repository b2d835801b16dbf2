"""One file for object, surface and protocol: what is written is read back, layer by layer, and
defaults are told.
"""

import math
import warnings
from dataclasses import replace

import numpy as np
import pytest

from cyclemap.collection import CollectionLoop
from cyclemap.errors import DoubtfulInput
from cyclemap.mechanics import Ellipse, EllipseFriction, FoundWith, Material, Polygon, load_material
from cyclemap.mechanics.contact_curve import first_contact
from cyclemap.protocol import loop_from_file, loop_from_settings
from cyclemap.protocol.collection_file import (
    FILE_NAME,
    collection_text,
    data_settings,
    names_surface,
    read_settings,
)
from cyclemap.protocol.own_object import check_collection, first_settings, within_reach
from cyclemap.protocol.settings import layered, warn_of_defaults

BOX = Polygon([(0.06, 0.03), (-0.06, 0.03), (-0.06, -0.03), (0.06, -0.03)])
WALNUT = Material("walnut", EllipseFriction(0.35, 0.31, 0.01, 0.0, 0.4), "made up")


def own_loop() -> CollectionLoop:
    return loop_from_settings(first_settings(BOX, "box"), CollectionLoop.mit(WALNUT))


def written(tmp_path, text: str):
    path = tmp_path / "box.toml"
    path.write_text(text)
    return path


def test_a_loop_with_its_surface_is_read_back_as_it_was(tmp_path) -> None:
    """Every part to rounding; no MIT default is left in an own object's file, so nothing is
    doubted.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        path = written(tmp_path, collection_text(own_loop(), noise=math.radians(2.0)))
        found = loop_from_file(path)
    for part in ("slider", "push", "pusher", "reset"):
        assert getattr(found, part) == getattr(own_loop(), part)
    assert found.material.name == "walnut"
    assert found.material.friction.phi == pytest.approx(0.4)
    assert read_settings(path)["noise_deg"] == pytest.approx(2.0)
    assert names_surface(path) and load_material(path).friction == found.material.friction
    moved = loop_from_file(path, surface="plywood")
    assert moved.material.name == "plywood" and moved.slider == own_loop().slider


def test_what_was_found_with_a_surface_stays_in_force(tmp_path) -> None:
    """Rod and ring, identified with the surface, are the loop's when the file is read back."""
    found = FoundWith(pusher_friction=0.2, pin_friction_radius=2e-3)
    loop = own_loop().with_material(replace(WALNUT, found_with=found))
    again = loop_from_file(written(tmp_path, collection_text(loop)))
    assert again.pusher.friction == 0.2
    assert again.reset.pin_friction_radius == pytest.approx(2e-3, abs=1e-12)
    theta = np.linspace(0.0, 6.0, 5)
    assert again.next_theta(theta) == pytest.approx(loop.next_theta(theta), abs=1e-9)


def test_an_own_object_that_leaves_facts_to_mit_is_doubted_once_by_name(tmp_path) -> None:
    """Check names them, too; a later outline takes the place of an earlier one."""
    one = {"vertices_mm": [[0, 0], [9, 0], [0, 9]], "object_name": "wedge", "push_mm": 80}
    assert layered(one, {"shape": "hex"}) == {"push_mm": 80, "shape": "hex"}
    told = r"still: the ring, the mass, .*; give hitch_x_mm, hitch_y_mm, mass_kg"
    with pytest.warns(DoubtfulInput, match=told) as doubts:
        warn_of_defaults({"vertices_mm": one["vertices_mm"]})
    assert len(doubts) == 1
    found = check_collection(written(tmp_path, "[object]\nsemi_x_mm = 40\nsemi_y_mm = 30\n"))
    words = " ".join(finding.words for finding in found.findings)
    for left in ("the ring is not", "the length of the push is not", "no surface is"):
        assert f"{left} said" in words


def test_the_nearest_folder_above_data_tells_what_they_are_of_but_not_the_surface(tmp_path) -> None:
    (tmp_path / FILE_NAME).write_text(collection_text(own_loop(), noise=0.02))
    below = tmp_path / "walnut" / "box" / "normal"
    below.mkdir(parents=True)
    for place in (tmp_path, below, below / "push.h5"):
        found = data_settings(place)
        assert found["object_name"] == "box" and not {"mu_a", "noise_deg"} & set(found)
    assert data_settings(tmp_path.parent / "elsewhere") == {}


@pytest.mark.parametrize("shape", ["rect1", "hex", "tri1", "ellip2"])
def test_the_rod_first_touches_where_the_mechanics_begin(shape) -> None:
    loop = loop_from_settings({"shape": shape, "fraction": 0.3, "angle_deg": 20})
    place, way = first_contact(loop.slider, loop.push, loop.pusher.radius)
    rod = loop.cycle(0.0).trajectory.push
    start = rod.pusher[0] - rod.pose[0, :2]
    assert start == pytest.approx(place, abs=1e-9)
    gone = rod.pusher[-1] - rod.pusher[0]
    assert gone / np.hypot(*gone) == pytest.approx(way, abs=1e-9)


def test_a_first_guess_turns_a_disc_too() -> None:
    """A straight push goes through a disc's centre of friction and turns it not at all: the guess
    slants it.
    """
    settings = first_settings(Ellipse(0.04, 0.04), "mug")
    disc = loop_from_settings(settings, CollectionLoop.mit(WALNUT))
    straight = replace(disc, push=replace(disc.push, angle=0.0))
    assert abs(disc.cycle(0.0).push_turn) > math.radians(10.0) > abs(straight.cycle(0.0).push_turn)


def test_a_first_guess_pushes_no_side_that_a_straight_wall_could_not_touch() -> None:
    """Of a hexagon with a slit, whose sides are the longest, one of the hexagon's."""
    angles = np.radians(30.0 + 60.0 * np.arange(6))
    hexagon = 0.05 * np.column_stack([np.cos(angles), np.sin(angles)])
    slit = [(0.0433, -0.002), (-0.035, 0.0), (0.0433, 0.002)]
    outline = Polygon(tuple(map(tuple, [*hexagon.tolist(), *slit])))
    assert first_settings(outline, "slit")["side"] == 0


def test_a_first_guess_pushes_the_box_as_far_as_its_rod_stays_on_it() -> None:
    loop = within_reach(own_loop())
    assert loop.push.distance < own_loop().push.distance
    for theta in np.linspace(0.0, 2.0 * np.pi, 24, endpoint=False).tolist():
        assert loop.cycle(theta).push.travel == pytest.approx(loop.push.distance)


@pytest.mark.parametrize(
    ("settings", "words", "wrong"),
    [
        ({}, None, False),
        ({"push_mm": 140}, "slides past the edge after", False),
        ({"push_mm": 0.12}, "is push_mm in millimetres?", False),
        ({"hitch_x_mm": -80}, "it lies outside", False),
        ({"hitch_x_mm": 0, "hitch_y_mm": 0}, "hardly turn the object", False),
        ({"mass_kg": 837.4}, "was it given in grams?", False),
        ({"mu_a": 0.9}, "times as large in one direction", False),
        ({"pusher_mu": 1.5}, "that of rubber", False),
        ({"side": 9}, "side", True),
        ({"hitch_x_mm": 9000}, "same unit", True),
    ],
)
def test_check_says_what_is_likely_wrong_and_nothing_of_what_is_right(
    tmp_path, settings, words, wrong
) -> None:
    """The file is one that init wrote, with one fact changed by hand."""
    lines = collection_text(within_reach(own_loop())).splitlines()
    for key, value in settings.items():
        place = next(number for number, line in enumerate(lines) if line.startswith(f"{key} ="))
        lines[place] = f"{key} = {value}"
    found = check_collection(written(tmp_path, "\n".join(lines) + "\n"))
    if words is None:
        assert found.findings == ()
    else:
        assert [finding.wrong for finding in found.findings if words in finding.words] == [wrong]
