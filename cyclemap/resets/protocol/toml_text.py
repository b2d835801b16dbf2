"""Tables as TOML text: what the protocol files need of it."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator, Mapping
from decimal import Decimal

from cyclemap.errors import InvalidInput
from cyclemap.resets.protocol.exact_units import decimal_text

Table = Mapping[str, object]

_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")


def toml_text(tables: Mapping[str, Table], comments: tuple[str, ...] = ()) -> str:
    """Return named tables as TOML, `comments` before them, one a line.

    Values are texts, booleans, numbers, lists of them, small tables (written inline) and lists of tables (arrays of
    tables). Decimals keep all their digits. Raises InvalidInput for any other value.

    >>> print(toml_text({"push": {"side": 2, "push_mm": Decimal("80.5"), "parts": [{"kind": "straight"}]}}, ("Mine.",)))
    # Mine.
    <BLANKLINE>
    [push]
    side = 2
    push_mm = 80.5
    <BLANKLINE>
    [[push.parts]]
    kind = "straight"
    <BLANKLINE>
    """
    lines = [f"# {line}".rstrip() for comment in comments for line in comment.splitlines() or [""]]
    for name, table in tables.items():
        lines += ["", f"[{_key(name)}]", *_body(_key(name), table)]
    return "\n".join(lines).lstrip("\n") + "\n"


def _body(path: str, table: Table) -> Iterator[str]:
    """The lines of one table: its values first, then its arrays of tables."""
    nested = {key: value for key, value in table.items() if _is_array_of_tables(value)}
    for key, value in table.items():
        if key not in nested:
            yield f"{_key(key)} = {_value(value)}"
    for key, rows in nested.items():
        inner = f"{path}.{_key(key)}"
        assert isinstance(rows, (list, tuple))
        for row in rows:
            yield from ("", f"[[{inner}]]", *_body(inner, row))


def _is_array_of_tables(value: object) -> bool:
    return isinstance(value, (list, tuple)) and bool(value) and all(isinstance(row, Mapping) for row in value)


def _value(value: object) -> str:
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        # A basic string is that of JSON, which leaves one control character as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Decimal):
        return decimal_text(value)
    if isinstance(value, (int, float)):
        return repr(value)
    if isinstance(value, (list, tuple)):
        return f"[{', '.join(map(_value, value))}]"
    if isinstance(value, Mapping):
        return f"{{ {', '.join(f'{_key(key)} = {_value(part)}' for key, part in value.items())} }}"
    raise InvalidInput(f"{value!r} cannot be written as TOML: give a text, number, boolean, list or table")


def _key(name: str) -> str:
    return name if _BARE_KEY.fullmatch(name) else _value(name)
