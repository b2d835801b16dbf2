"""Signatures and docstrings as people read them: arrays without their insides, links to where a
name is public, and no mark of reStructuredText but code.
"""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, NumpyDocstring

import cyclemap

ARRAY_LIKE = re.compile(r"~?[\w.]*Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]")
ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[.*?\.\.\.\], ~?(?:numpy\.)?dtype\[[^\[\]]*(?:\[[^\]]*\])?\]\]"
)


# Types are words for people: no links.
SECTIONS = Config(
    napoleon_use_param=False,
    napoleon_use_rtype=False,
    napoleon_custom_sections=[("Attributes", "params_style")],
)
CODE = re.compile(r"(``.+?``|`[^`\s][^`]*`)")


def as_text(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Mark a docstring's code as code, and nothing else, outside its examples; then have its
    sections, NumPy's, as lists. Those of attributes are a sentence, in which a colon is none of a
    type.
    """
    example = False
    for index, line in enumerate(lines):
        example = bool(line.strip()) and (example or line.lstrip().startswith(">>>"))
        if not example:
            lines[index] = marked(line)
    if what not in ("attribute", "data", "property"):
        lines[:] = NumpyDocstring(lines, SECTIONS, app, what, name, thing, options).lines()


def marked(line: str) -> str:
    """A line with names in backticks as code, or as links where they are public, and all else as it
    stands.

    >>> marked("`theta`, |f'| of `CircleMap` * 2")
    "``theta``, \\\\|f'\\\\| of :py:obj:`~cyclemap.CircleMap` \\\\* 2"
    """
    words = []
    for part in CODE.split(line):
        name = part.strip("`")
        if not CODE.fullmatch(part):
            words.append(re.sub(r"([|*])", r"\\\1", part))
        else:
            public = name in cyclemap.__all__
            words.append(f":py:obj:`~cyclemap.{name}`" if public else f"``{name}``")
    return "".join(words)


def short_types(
    app: Sphinx,
    what: str,
    name: str,
    thing: Any,
    options: Any,
    signature: str | None,
    returned: str | None,
) -> tuple[str | None, str | None]:
    """Write arrays as `ndarray` in signatures: shapes and units are in the words below them."""
    return (signature and short(signature), returned and short(returned))


def short(types: str) -> str:
    """Types without the inside of arrays.

    >>> short("(x: ~numpy.ndarray[tuple[~typing.Any, ...], ~numpy.dtype[~numpy.float64]]) -> int")
    '(x: ~numpy.ndarray) -> int'
    """
    return ARRAY.sub("~numpy.ndarray", ARRAY_LIKE.sub("~numpy.typing.ArrayLike", types))


def short_properties(app: Sphinx, doctree: nodes.document) -> None:
    """The same for the types of properties, which autodoc asks nobody about."""
    for node in doctree.findall(addnodes.desc_annotation):
        text = node.astext()
        if short(text) != text:
            node.children = [nodes.Text(short(text).replace("~numpy.", ""))]


def public_link(app: Sphinx, env: Any, node: Any, content: nodes.Node) -> nodes.Node | None:
    """Link `cyclemap.room.module.Name`, as types in signatures say it, to where `Name` is
    documented.
    """
    target = str(node.get("reftarget", ""))
    room, _, name = target.removeprefix("cyclemap.").partition(".")
    name = name.rpartition(".")[2] or room
    path = f"cyclemap.{name}" if name in cyclemap.__all__ else f"cyclemap.{room}.{name}"
    if node.get("refdomain") != "py" or target == path:
        return None
    return env.get_domain("py").resolve_xref(
        env, node["refdoc"], app.builder, "obj", path, node, content
    )


def setup(app: Sphinx) -> dict[str, bool]:
    """Mend docstrings and the types in signatures."""
    app.connect("autodoc-process-docstring", as_text)
    app.connect("autodoc-process-signature", short_types)
    app.connect("doctree-read", short_properties)
    app.connect("missing-reference", public_link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
