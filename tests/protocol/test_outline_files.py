"""One T in five kinds of file is one outline; what is no outline is refused with what to do."""

import struct

import numpy as np
import pytest
from refusals import refused

from cyclemap.errors import DataFileError
from cyclemap.protocol import outline_files
from cyclemap.protocol.outline_files import read_outline

pytest.importorskip("svgpathtools")
pytest.importorskip("ezdxf")
pytest.importorskip("trimesh")
pytest.importorskip("shapely")

# Millimetres, counter-clockwise: a bar of 80 by 20 below a stem of 20 by 60.
TEE = [(0, 0), (80, 0), (80, 20), (50, 20), (50, 80), (30, 80), (30, 20), (0, 20)]
AREA = 80 * 20 + 20 * 60
CENTROID = np.array([40.0, (80 * 20 * 10 + 20 * 60 * 50) / AREA])


def svg(shapes: str, frame: str = "") -> str:
    return f'<svg xmlns="http://www.w3.org/2000/svg" {frame}>{shapes}</svg>'


def write_svg(path):
    """Drawn with y down, in a group that turns it up again."""
    steps = " ".join(f"L{x} {y}" for x, y in TEE[1:])
    turned = f'<g transform="translate(0,80) scale(1,-1)"><path d="M0 0 {steps} Z"/></g>'
    frame = 'width="8cm" height="8cm" viewBox="0 0 80 80"'
    path.write_text(svg(f'{turned}<circle cx="5" cy="5" r="2"/>', frame))


def write_dxf(path):
    """Eight lines, in no order, that meet in the corners; in inches."""
    import ezdxf

    drawing = ezdxf.new(units=1)
    sides = list(zip(TEE, TEE[1:] + TEE[:1], strict=True))
    for start, end in sides[::2] + sides[1::2]:
        drawing.modelspace().add_line(np.array(end) / 25.4, np.array(start) / 25.4)
    drawing.saveas(path)


def write_stl(path, scale=1.0, height=10.0):
    triangles = []
    for (x0, y0), (x1, y1) in (((0, 0), (80, 20)), ((30, 20), (50, 80))):
        for z in (0.0, height):
            triangles.append([(x0, y0, z), (x1, y0, z), (x1, y1, z)])
            triangles.append([(x0, y0, z), (x1, y1, z), (x0, y1, z)])
    for start, end in zip(TEE, TEE[1:] + TEE[:1], strict=True):
        triangles.append([(*start, 0.0), (*end, 0.0), (*end, height)])
        triangles.append([(*start, 0.0), (*end, height), (*start, height)])
    with path.open("wb") as file:
        file.write(b"\0" * 80 + struct.pack("<I", len(triangles)))
        for triangle in triangles:
            numbers = [scale * part for corner in triangle for part in corner]
            file.write(struct.pack("<12fH", 0, 0, 0, *numbers, 0))


def write_urdf(path):
    """A mesh in metres, turned by a quarter about z."""
    write_stl(path.with_name("tee_m.stl"), 1e-3)
    shape = '<geometry><mesh filename="package://tee_m.stl"/></geometry>'
    solid = f'<collision><origin rpy="0 0 1.5707963267948966"/>{shape}</collision>'
    links = f'<link name="base"/><link name="tee">{solid}</link>'
    path.write_text(f'<robot name="t">{links}</robot>')


def write_csv(path):
    path.write_text("x_mm;y_mm\n" + "".join(f"{x};{y}\n" for x, y in reversed(TEE)))


@pytest.mark.parametrize("write", [write_svg, write_dxf, write_stl, write_urdf, write_csv])
def test_a_tee_is_the_same_outline_from_every_kind_of_file(tmp_path, write) -> None:
    name = f"tee.{write.__name__[-4:].strip('_')}"
    write(tmp_path / name)
    found = read_outline(tmp_path / name)
    wanted = np.array(TEE) - CENTROID
    if name == "tee.urdf":
        wanted = wanted[:, ::-1] * (-1, 1)
    assert found.outline.sides == 8
    assert found.outline.area == pytest.approx(1e-6 * AREA, rel=1e-6)
    assert found.outline.centroid == pytest.approx((0.0, 0.0), abs=1e-8)
    corners = {tuple(corner) for corner in (1e3 * found.outline.array).round(3).tolist()}
    assert corners == {tuple(corner) for corner in wanted.round(3).tolist()}
    assert "80 x 80 mm" in found.words[0]


def test_units_are_as_told_before_all_else(tmp_path) -> None:
    path = tmp_path / "tee.stl"
    write_stl(path, 1e-3)
    guessed, told = read_outline(path), read_outline(path, "inch", 1e-6).outline
    assert guessed.outline.area == pytest.approx(1e-6 * AREA, rel=1e-5)
    assert "guessed" in guessed.words[0]
    assert told.area == pytest.approx(0.0254**2 * 1e-6 * AREA, rel=1e-4)


def test_the_underside_of_a_mesh_is_its_foot_print(tmp_path) -> None:
    import trimesh

    low = trimesh.creation.box((40.0, 40.0, 10.0))
    high = trimesh.creation.box((100.0, 60.0, 10.0)).apply_translation((0.0, 0.0, 10.0))
    path = tmp_path / "table.stl"
    trimesh.util.concatenate([low, high]).export(path)
    assert read_outline(path).outline.area == pytest.approx(6e-3, rel=1e-5)
    below = read_outline(path, underside=True).outline
    assert below.area == pytest.approx(1.6e-3, rel=1e-5)


@pytest.mark.slow
def test_curves_are_simplified_within_the_tolerance_and_no_more(tmp_path) -> None:
    path = tmp_path / "disc.svg"
    frame = 'width="100mm" height="100mm" viewBox="0 0 100 100"'
    path.write_text(svg('<circle cx="50" cy="50" r="40"/>', frame))
    sides = []
    for tolerance in (1e-5, 1e-4, 1e-3):
        outline = read_outline(path, tolerance=tolerance).outline
        sides.append(outline.sides)
        reach = np.hypot(*outline.array.T)
        assert np.abs(reach - 0.040).max() < tolerance + 2e-5
    assert sides == sorted(sides, reverse=True) and sides[0] > sides[-1]


BOX = '<link name="a"><visual><geometry><box size="0.1 0..2 1"/></geometry></visual></link>'
REFUSED = [
    ("open.svg", svg('<path d="M0 0H80V20"/>'), "no closed line"),
    ("no.svg", "not a drawing", "not an SVG drawing"),
    ("no.dxf", "not a drawing", "not a DXF drawing"),
    ("no.stl", "solid nothing\nendsolid nothing\n", "not a mesh|no triangles"),
    ("no.urdf", "<robot/>", "0 links with a geometry"),
    ("box.urdf", f"<robot>{BOX}</robot>", r"a geometry or origin of a .* \('0..2' is not a num"),
    ("two.csv", "0,0\n1,0\n", "2 vertices; an outline has three"),
    ("bad.csv", "x,y\n0,0\n1,zero\n", "line 3: two numbers x,y are wanted"),
    ("plain.csv", "1,0,0\n2,80,0\n3,80,20\n", "3 columns without names: which are x and y"),
    ("named.csv", "a,b\n0,0\n80,0\n80,20\n", "the header is a,b: name the columns x and y"),
    ("units.csv", "x_mm,y_cm\n0,0\n80,0\n80,2\n", "x and y in different units"),
    ("ells.csv", "x_ells,y_ells\n0,0\n80,0\n80,2\n", "ells is no unit"),
    ("twice.csv", "x_mm,y_mm,x_cm\n0,0,0\n80,0,8\n80,2,8\n", "may both be x"),
    ("gone.svg", None, "there is no such file"),
]


def test_what_is_no_outline_another_kind_of_file_and_a_missing_library_are_told(
    tmp_path, monkeypatch
) -> None:
    for name, content, told in REFUSED:
        if content is not None:
            (tmp_path / name).write_text(content)
        refused(read_outline, tmp_path / name, told=told, kind=DataFileError)
    step, drawing = tmp_path / "tee.step", tmp_path / "tee.svg"
    step.write_text("x")
    refused(read_outline, step, told=r"read from \.svg, \.dxf, .*, not from \.step")
    write_svg(drawing)

    def missing(name):
        raise ImportError(name)

    monkeypatch.setattr(outline_files, "import_module", missing)
    install = r"needs svgpathtools: python -m pip install '\.\[outlines\]'"
    refused(read_outline, drawing, told=install)


@pytest.mark.parametrize(
    ("text", "width", "height", "unit"),
    [
        ("x_mm,y_mm\n0,0\n80,0\n80,20\n", 80.0, 20.0, None),
        ("y_mm,x_mm\n0,0\n0,80\n20,80\n", 80.0, 20.0, None),
        ("id,x_mm,y_mm\n1,0,0\n2,80,0\n3,80,20\n", 80.0, 20.0, None),
        ("x_cm,y_cm\n0,0\n8,0\n8,2\n", 80.0, 20.0, None),
        ("x_in,y_in\n0,0\n2,0\n2,1\n", 50.8, 25.4, None),
        ("X [mm];Y [mm]\n0,5;0,0\n80,5;0,0\n80,5;20,0\n", 80.0, 20.0, None),
        ("0,5;0,0\n80,5;0,0\n80,5;20,0\n", 80.0, 20.0, "mm"),
        ("0,0\n80,0\n80,20\n", 80.0, 20.0, None),
        ("x,y\n0,0\n8,0\n8,2\n", 80.0, 20.0, "cm"),
    ],
)
def test_vertices_are_read_by_the_names_and_units_of_their_columns(
    tmp_path, text, width, height, unit
) -> None:
    """Size, and which corner is the right one: a mirror image has it elsewhere."""
    (tmp_path / "part.csv").write_text(text)
    corners = 1e3 * read_outline(tmp_path / "part.csv", unit).outline.array
    assert np.ptp(corners, axis=0) == pytest.approx([width, height], abs=1e-6)
    sides = np.roll(corners, 1, axis=0) - corners, np.roll(corners, 2, axis=0) - corners
    right_angle = corners[np.argmin(np.abs(np.sum(sides[0] * sides[1], axis=1)))]
    assert right_angle == pytest.approx([width / 3.0, -height / 3.0], abs=1e-6)


def test_a_drawing_of_very_many_curves_is_refused_before_it_is_cut_up(tmp_path) -> None:
    curves = "".join(f"C{k} 0 {k} 1 {k + 1} {k % 2}" for k in range(31_000))
    file = tmp_path / "many.svg"
    file.write_text(svg(f'<path d="M0 0{curves}Z"/>'))
    told = "curves: 3.1e.04, of at most 3e.04; simplify the drawing"
    refused(read_outline, file, told=told)


SQUARE = "M0 0H40V40H0Z"


@pytest.mark.parametrize(
    ("size", "path", "told"),
    [
        ("80mm", SQUARE, "40 x 40 mm, in the file's own unit;"),
        ("302.362", SQUARE, "40 x 40 mm, in pixels of 1/96 inch: give"),
        ("", SQUARE, "10.58 x 10.58 mm, in pixels of 1/96 inch: give --unit"),
        ("80mm", f"{SQUARE}M10 10H20V20H10Z", "the largest of 2 closed lines"),
    ],
    ids=["millimetres", "pixels", "no width", "hole"],
)
def test_what_a_drawing_does_not_tell_and_what_is_left_out_is_said(
    tmp_path, size, path, told
) -> None:
    file = tmp_path / "square.svg"
    width = f'width="{size}" height="{size}"' if size else ""
    file.write_text(svg(f'<path d="{path}"/>', f'{width} viewBox="0 0 80 80"'))
    assert told in read_outline(file).words[0]
    assert read_outline(file, "cm").outline.area == pytest.approx(0.16)


def test_a_dxf_drawing_without_a_unit_is_guessed_by_its_size(tmp_path) -> None:
    corners = [(0, 0), (60, 0), (60, 40), (0, 40)]
    lines = [
        f"0\nLINE\n8\n0\n10\n{a}\n20\n{b}\n11\n{c}\n21\n{d}\n"
        for (a, b), (c, d) in zip(corners, [*corners[1:], corners[0]], strict=True)
    ]
    file = tmp_path / "plate.dxf"
    file.write_text(f"0\nSECTION\n2\nENTITIES\n{''.join(lines)}0\nENDSEC\n0\nEOF\n")
    assert "60 x 40 mm, in mm, guessed by its size" in read_outline(file).words[0]


@pytest.mark.parametrize("rows", ["0,0\n60,0\n60,40\n0,0\n0,0", "0,0\n60,0\n60,0\n60,40"])
def test_a_vertex_that_stands_twice_in_a_row_is_one(tmp_path, rows) -> None:
    file = tmp_path / "plate.csv"
    file.write_text(f"x_mm,y_mm\n{rows}\n")
    assert read_outline(file).outline.sides == 3
