"""Files that ask for far more than they hold: cut short, with huge counts, sizes and numbers, with
rows, curves and nesting without end.
"""

import re
import struct
from pathlib import PurePath

ROWS, CURVES, DEPTH = 50_000, 20_000, 3_000
_NUMBER = re.compile(rb"(?<![\w.#])\d+(?:\.\d+)?(?![\w.])")
_ENTITIES = "".join(f'<!ENTITY e{n} "{f"&e{n - 1};" * 10}">' for n in range(1, 10))
_LISTED = ", ".join(f"[{n % 977}, {n % 631}]" for n in range(ROWS))
_SHAPE = 'shape = "rect1"'
_PLACES = (
    (_SHAPE, f"vertices_mm = [{_LISTED}]"),
    (_SHAPE, f'{_SHAPE}\n[pressure]\nfootprint = "grid:3000"'),
    (_SHAPE, f'{_SHAPE}\n[pressure]\nfootprint = "grid:100000"'),
    (_SHAPE, f"{_SHAPE}\n[ring]\nway_points_mm = [{_LISTED}]"),
    ("[friction]", f"[{'a.' * DEPTH}b]\n[friction]"),
)


def hostile_files(kind: str, healthy: bytes) -> list[bytes]:
    """Hostile files of the kind of a healthy one, which is told by its name."""
    cut = [b"", healthy[: len(healthy) // 2]]
    suffix = PurePath(kind).suffix
    if suffix in (".csv", ".tsv"):
        return cut + _tables(healthy)
    if suffix == ".toml":
        return cut + _with_numbers(healthy) + _settings(healthy)
    if suffix == ".svg":
        return cut + _drawings()
    if suffix == ".json":
        return cut + _with_numbers(healthy) + [b"[" * DEPTH, b'{"a":' * DEPTH]
    if suffix in (".urdf", ".dxf"):
        return cut + _with_numbers(healthy)
    return cut + _with_counts(healthy)


def _tables(healthy: bytes) -> list[bytes]:
    """Rows without end, huge and tiny numbers, one row of a million columns."""
    head, first, *_ = healthy.split(b"\n")
    many = b"\n".join([head] + [first] * ROWS)
    last = healthy.rstrip().split(b"\n")[-1]
    wide = head + b",x" * 1_000_000 + b"\n" + last + b",1" * 1_000_000
    return [many, *_with_numbers(healthy), wide]


def _settings(healthy: bytes) -> list[bytes]:
    """Outlines, grids, ways and tables without end, in the place of what is there."""
    places = [(place.encode(), instead.encode()) for place, instead in _PLACES]
    return [healthy.replace(*pair, 1) for pair in places if pair[0] in healthy]


def _with_numbers(healthy: bytes) -> list[bytes]:
    """Every number in it huge, or the last alone, or next to nothing."""
    instead = (b"1e300", b"99999999", b"1e-300")
    places = [place.span() for place in _NUMBER.finditer(healthy)]
    last = [healthy[:start] + b"1e12" + healthy[end:] for start, end in places[-1:]]
    return [_NUMBER.sub(number, healthy) for number in instead] + last


def _drawings() -> list[bytes]:
    """Curves without end, groups in groups, entities of entities, a huge picture of a speck."""
    head = b'<svg xmlns="http://www.w3.org/2000/svg" width="8cm" height="8cm" viewBox="0 0 80 80">'
    curves = b"c 0 1 1 2 3 3 " * CURVES
    group = b"<g transform='scale(9)'>"
    shapes = (
        b'<path d="M0 0 ' + curves + b'Z"/>',
        b'<path d="M0 0A1e9 1e-9 0 0 0 80 80Z"/>',
        group * DEPTH + b"<rect width='1' height='1'/>" + b"</g>" * DEPTH,
        b'<circle r="1e300"/><ellipse rx="1e9" ry="1e-9"/>',
    )
    entities = f"<!DOCTYPE svg [<!ENTITY e0 'x'>{_ENTITIES}]>".encode()
    bomb = entities + head + b'<path d="&e9;"/></svg>'
    return [*(head + shape + b"</svg>" for shape in shapes), bomb]


def _with_counts(healthy: bytes) -> list[bytes]:
    """The largest count where binary files have theirs: at the start and at the end."""
    count = struct.pack("<Q", 2**63 - 1)
    places = (8, 80, max(0, len(healthy) - 16))
    return [healthy[:place] + count + healthy[place + len(count) :] for place in places]
