"""Signatures as people read them: arrays without their insides, and links to where a name is
public.
"""

import re
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

import cyclemap

ARRAY_LIKE = re.compile(r"~?[\w.]*Buffer \| .*?_NestedSequence\[complex \| bytes \| str\]")
ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[.*?\.\.\.\], ~?(?:numpy\.)?dtype\[[^\[\]]*(?:\[[^\]]*\])?\]\]"
)


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
    """Mend the types in signatures."""
    app.connect("autodoc-process-signature", short_types)
    app.connect("doctree-read", short_properties)
    app.connect("missing-reference", public_link)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
