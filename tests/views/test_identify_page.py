"""The page and the sentences of an identification say what was found, and draw a panel for each
sort of data.
"""

from dataclasses import replace

import numpy as np
import pytest
from drawn_words import assert_words_apart

from cyclemap.collection import CollectionLoop
from cyclemap.evidence import (
    Identification,
    MeasuredDrag,
    MeasuredPush,
    cycle_pair_block,
    drag_turn_block,
    friction_scan_block,
    identified_material,
    identify,
    push_end_block,
)
from cyclemap.evidence.identification.data_block import DataBlock
from cyclemap.evidence.identification.force_blocks import scan_traction
from cyclemap.evidence.identification.surface_parameters import Parameter, Values
from cyclemap.evidence.identified_material import (
    Derived,
    IdentifiedCurves,
    derived_quantities,
    identified_curves,
)
from cyclemap.mechanics import EllipseFriction, Pose, Slider
from cyclemap.views import identify_page as sentences
from cyclemap.views.identify_page import identify_page

LAW = EllipseFriction(0.28, 0.22, 0.02, -0.012, 0.6)
WEIGHT = 8.2


def scans() -> dict[str, np.ndarray]:
    direction = np.linspace(0.0, 6.0, 24)
    way = np.stack([np.cos(direction), np.sin(direction)], axis=-1)
    force = WEIGHT * LAW.traction(way) + 0.05 * np.random.default_rng(0).standard_normal((24, 2))
    along, across = np.sum(force * way, axis=1), np.sum(force[:, ::-1] * way * (1, -1), axis=1)
    return {"direction": direction, "force_along": along, "force_across": across}


@pytest.fixture(scope="module")
def found() -> Identification:
    """The size of friction identified from scans, with pushes, drags and wearing cycles beside
    them.
    """
    slider, rng = Slider.mit("rect1"), np.random.default_rng(1)
    pushes, drags = [], []
    for n in range(2):
        ends = Pose(0, 0, 0), Pose(0.001 * n, -0.02, 0.1)
        pushes.append(MeasuredPush(*ends, (0.003 * n, 0.051), (0.003 * n, 0.03), n))
        ends = Pose(0.05, 0.02 * n, 0.5 * n), Pose(0.0, 0.0, 0.5 * n + 0.1)
        drags.append(MeasuredDrag(*ends, n))
    theta = rng.uniform(0.0, 20.0, 12)
    loop = CollectionLoop.mit("isotropic")
    cycles = cycle_pair_block(loop, theta, 0.1 + 0 * theta, np.arange(12), np.linspace(0, 1, 12))
    blocks = [
        friction_scan_block(scans(), WEIGHT),
        cycles,
        push_end_block(pushes, slider),
        drag_turn_block(drags, slider),
    ]
    fixed = {"worn_ellipticity_x": 0.2, "worn_offset_y": 0.1}
    return identify(blocks, ["friction_scale"], fixed, starts=1)


@pytest.fixture(scope="module")
def curves(found) -> IdentifiedCurves:
    return identified_curves(found, scan_traction(scans(), WEIGHT))


@pytest.mark.slow
def test_there_is_a_panel_for_each_sort_of_data(found, curves) -> None:
    page = identify_page("A title", found, curves, ["One sentence.", "Another."])
    titles = [axes.get_title(loc="left") for axes in page.axes]
    wanted = ["Friction ellipse", "Cycles: map", "Parameters, with 95 % intervals"]
    wanted += ["Push ends: turns", "Drag-backs: turns", "Push ends: places"]
    assert list(filter(None, titles)) == wanted
    assert len(page.axes[2].child_axes) == len(found.estimates)
    assert_words_apart(page)


def test_curves_are_the_data_and_what_the_fit_says_of_them(found, curves) -> None:
    assert curves.sized and curves.worn is not None and curves.forces is not None
    assert curves.forces.shape == (24, 2) and len(curves.samples) == 200
    angle = np.linspace(0, 2 * np.pi, 181)
    along = np.stack([np.cos(angle), np.sin(angle)], -1)
    assert curves.ellipse == pytest.approx(found.friction().traction(along))
    (cycles,) = curves.cycles
    assert cycles.late is not None and cycles.turn == pytest.approx(0.1)
    # Isotropic friction turns by the same everywhere; the worn one does not.
    assert np.ptp(cycles.fitted) < 1e-5 < 1e-2 < np.ptp(cycles.late)
    pushes = curves.strokes[0]
    errors = found.fit.residuals[found.problem.kinds == "push turn (rad)"]
    assert pushes.predicted - pushes.measured == pytest.approx(errors) and len(pushes.errors) == 2


def test_of_many_plates_a_panel_shows_the_shape_of_each_and_intervals_are_those_they_share() -> (
    None
):
    rest = Parameter("plate_dome", "bends", "kPa", -9.0, 9.0, 0.3, 0.2, 0.0)

    def block(plate: str, share: float) -> DataBlock:
        def law(values: Values) -> tuple[np.ndarray, np.ndarray]:
            places = np.arange(9.0)
            off = values["plate_dome"] - share + values["offset_x"] * places
            return off + 0.01 * np.cos(places), np.column_stack([np.ones(9), places])

        asked = ("plate_dome", "offset_x")
        return DataBlock(plate, asked, law, np.arange(9), "m").of_owner(plate, (rest,))

    names = [f"plate{number}" for number in range(14)]
    blocks = [block(name, 0.05 * (number + 1)) for number, name in enumerate(names)]
    several = identify(blocks, ["offset_x", *(f"plate_dome[{name}]" for name in names)], starts=1)
    page = identify_page("Many", several, identified_curves(several), ["Words."])
    (lines,) = [axes for axes in page.axes if axes.get_title(loc="left") == "Shapes of plates"]
    assert [text.get_text() for text in lines.get_yticklabels()] == sorted(names)[::-1]
    (shared,) = [axes for axes in page.axes if "of all plates" in axes.get_title(loc="left")]
    assert len(shared.child_axes) == 1


def test_a_material_carries_wear_and_what_the_data_depend_on(found) -> None:
    material = identified_material(found, "slate", ["a.csv"], 300.0)
    assert material.inferred and material.wear is not None and material.wear.cycles == 300.0
    assert material.wear.friction.mu_a > material.friction.mu_a
    assert material.found_with.pin_friction_radius == 0.0
    assert "in a.csv" in material.provenance and "scan force" in material.misfit
    scanned = identify(found.problem.blocks[:1], ["friction_scale"], starts=1)
    alone = identified_material(scanned, "slate")
    assert alone.wear is None and alone.found_with.pin_friction_radius is None


def test_no_headline_is_sharper_than_its_interval(found) -> None:
    """Intervals stand in place of values, so that a ratio of 1 to 1.35 and any direction are told
    as what they are.
    """
    ratio = Derived("axis_ratio", "", "1", 1.11, 1.0, 1.35)
    way = Derived("axis_direction", "", "rad", 0.5, 0.3, 0.7)
    size = Derived("offset_size", "", "1", 0.132, 0.0, 0.43)
    to = Derived("offset_direction", "", "rad", 0.5, -3.0, 3.0, known=False)
    unknown = replace(way, known=False)
    round_the_back = replace(to, lower=np.radians(-196.0), upper=np.radians(-195.0), known=True)
    (friction,) = derived_quantities(found)
    ends = f"{friction.lower:.3f} to {friction.upper:.3f}"
    even = EllipseFriction.isotropic(0.2)
    axes = "axes 1.00 to 1.35 : 1"
    for known, held, told in (
        (
            [ratio, way, size, to],
            LAW,
            f"{axes} (longer along 17° to 40°), centre 0.0 to 43.0 % off, in any direction",
        ),
        ([ratio, unknown], LAW, f"{axes}, in any direction"),
        ([size, round_the_back], LAW, "centre 0.0 to 43.0 % off towards 164° to 165°"),
        ([friction], even, f"mean friction {ends}; friction taken as isotropic"),
    ):
        assert sentences.headline("felt", known, held) == f"felt: friction ellipse with {told}"
    for held, told in (
        (even, "taken as isotropic"),
        (LAW, "held at axes 1.27 : 1, centre 9.4 % off"),
    ):
        assert sentences.headline("felt", [], held).endswith(f"friction {told}")


def test_errors_of_places_and_forces_are_distances(found) -> None:
    errors = {one.kind: one for one in found.errors}
    places = found.fit.residuals[found.problem.kinds == "push place (m)"].reshape(-1, 2)
    forces = found.fit.residuals[found.problem.kinds == "scan force (N)"].reshape(-1, 2)
    for kind, vectors in (("push place (m)", places), ("scan force (N)", forces)):
        length = np.linalg.norm(vectors, axis=1)
        assert errors[kind].rows == len(vectors)
        assert errors[kind].mean == pytest.approx(length.mean())
        assert errors[kind].rms == pytest.approx(np.sqrt(np.mean(length**2)))
    assert errors["push turn (rad)"].rows == 2
