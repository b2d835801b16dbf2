"""The docstrings of the package, written as plain text, as valid reStructuredText.

What they hold: paragraphs; `name : what it is` entries, one a line; headings underlined with
dashes; indented formulas; `>>>` examples; `- ` items; names in one or two
backticks.
"""

import re
from collections.abc import Iterable

from sphinx.application import Sphinx

import cyclemap

NAME = r"[A-Za-zλ_][\w*.]*"
HEAD = rf"{NAME}(?: \([^()]*\))?(?:,? (?:and |or )?{NAME}(?: \([^()]*\))?){{0,5}}"
ENTRY = re.compile(rf"({HEAD}) : (.*)")
CODE = re.compile(r"(``.+?``|`[^`\s][^`]*`)")
# Sections of NumPy's whose entries stand above what they are.
LISTS = ("Parameters", "Returns", "Attributes", "Raises", "Warns")
SPECIAL = re.compile(r"([\\*|_`])")


def house_to_rest(lines: list[str]) -> list[str]:
    """Return reStructuredText that renders a docstring as it was meant.

    >>> entries = ["first, second : θ_n * 2, rad.", "count : how", "    many: `x`."]
    >>> for line in house_to_rest(["A sum.", "", *entries]):
    ...     print(line or "-")
    A sum.
    -
    * **first, second** : θ\\_n \\* 2, rad.
    * **count** : how many: ``x``.
    -
    """
    return tidied([line for block in blocks(lines) for line in block_to_rest(block)])


def blocks(lines: Iterable[str]) -> list[list[str]]:
    """Split lines at blank ones."""
    found: list[list[str]] = [[]]
    for line in lines:
        if line.strip():
            found[-1].append(line.rstrip())
        elif found[-1]:
            found.append([])
    return [block for block in found if block]


def block_to_rest(block: list[str]) -> list[str]:
    """Return one block of lines without blank ones between them, as reStructuredText."""
    if block[0].lstrip().startswith(">>>"):
        return [".. code-block:: pycon", "", *(f"   {line}" for line in block), ""]
    if len(block) > 1 and set(block[1].strip()) == {"-"}:
        make = described if block[0] in LISTS and is_described(block[2:]) else block_to_rest
        following = make(block[2:]) if block[2:] else []
        return [f".. rubric:: {plain(block[0])}", "", *following]
    if all(line.startswith("    ") for line in block):
        return [".. code-block:: text", "", *(f"   {line}" for line in block), ""]
    return [line for piece in pieces(block) for line in piece_to_rest(piece)] + [""]


def is_described(block: list[str]) -> bool:
    """Whether every entry is a name with its type, or a type alone, and its text stands below."""
    following = [*block[1:], ""]
    for line, after in zip(block, following, strict=True):
        if line.startswith(" "):
            continue
        is_sentence = re.search(r"\.( |$)|;", line) is not None
        if is_sentence or (" : " in line and not after.startswith(" ")):
            return False
    return True


def described(block: list[str]) -> list[str]:
    """The entries of a section of NumPy's, what each is indented below its name, as a list.

    >>> described(["theta : ndarray", "    Angles,", "    rad.", "InvalidInput", "    For none."])
    ['* **theta** : *ndarray*. Angles, rad.', '* **InvalidInput**. For none.', '']
    """
    entries: list[list[str]] = []
    for line in block:
        if not line.startswith(" ") or not entries:
            entries.append([line])
        else:
            entries[-1].append(line.strip())
    lines = []
    for head, *text in entries:
        name, _, kind = head.partition(" : ")
        of_kind = f" : *{plain(kind)}*" if kind else ""
        lines.append(f"* **{plain(name)}**{of_kind}. {marked(' '.join(text))}".rstrip())
    return [*lines, ""]


def pieces(block: list[str]) -> list[str]:
    """Join the lines of a block into its sentences, entries and items, one string each."""
    joined: list[str] = []
    for line in block:
        if not joined or starts_anew(line, joined[-1]):
            joined.append(line.strip())
        else:
            joined[-1] += f" {line.strip()}"
    return joined


def starts_anew(line: str, before: str) -> bool:
    """Whether a line begins a new entry or item, or a sentence after one."""
    if ENTRY.match(line) or line.startswith("- "):
        return True
    after_list = before.startswith("- ") or bool(ENTRY.match(before))
    ended = before.endswith((".", ":", "else."))
    return (
        after_list and ended and not line.startswith(" ") and (line[0].isupper() or line[0] == "`")
    )


def piece_to_rest(piece: str) -> list[str]:
    """Return a sentence as a paragraph, an entry or an item as one of a list."""
    entry = ENTRY.match(piece)
    if entry:
        return [f"* **{plain(entry[1])}** : {marked(entry[2])}"]
    if piece.startswith("- "):
        return ["", f"* {marked(piece[2:])}"]
    return ["", marked(piece), ""]


def marked(text: str) -> str:
    """Return text with its code as code, public names as links, and all else as it stands."""
    return "".join(code(part) if CODE.fullmatch(part) else plain(part) for part in CODE.split(text))


def code(part: str) -> str:
    """Return a name in backticks as literal text, or as a link where it is public."""
    name = part.strip("`")
    return f":py:obj:`~cyclemap.{name}`" if name in cyclemap.__all__ else f"``{name}``"


def plain(text: str) -> str:
    """Return text in which nothing is markup."""
    return SPECIAL.sub(r"\\\1", text)


def rewrite(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Rewrite the docstring of one thing in place, as autodoc asks."""
    lines[:] = house_to_rest(lines)


def tidied(lines: list[str]) -> list[str]:
    """Return lines with one blank line where there are more, and one before each list."""
    kept: list[str] = []
    for line in lines:
        if line.startswith("* ") and kept and kept[-1] and not kept[-1].startswith("* "):
            kept.append("")
        if line or (kept and kept[-1]):
            kept.append(line)
    return kept


def setup(app: Sphinx) -> dict[str, bool]:
    """Rewrite every docstring that autodoc reads."""
    app.connect("autodoc-process-docstring", rewrite)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
