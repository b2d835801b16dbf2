"""Docstrings of a room's exports are in NumPy's sections, and leave out no parameter."""

import ast
import builtins
import doctest
import importlib
import inspect
import re

import pytest

# In numpydoc's order.
SECTIONS = ("Parameters", "Attributes", "Returns", "Raises", "Warns")
SECTIONS += ("See Also", "Notes", "References", "Examples")
ROOMS = ("mechanics", "maps", "collection", "protocol", "evidence", "resets", "sweeps")
PACKAGES = ("cyclemap", *(f"cyclemap.{room}" for room in ROOMS))


def exports(package: str) -> list[object]:
    """The classes and functions of a package; constants and unions of types have no docstring."""
    module = importlib.import_module(package)
    things = [getattr(module, name) for name in module.__all__]
    return [thing for thing in things if inspect.isclass(thing) or inspect.isroutine(thing)]


# The top holds names of the rooms again.
EXPORTS = list(dict.fromkeys(thing for package in PACKAGES for thing in exports(package)))
each_export = pytest.mark.parametrize(
    "thing", EXPORTS, ids=[f"{thing.__module__}.{thing.__qualname__}" for thing in EXPORTS]
)


def sections_of(thing: object) -> dict[str, str]:
    """The text of every section of a docstring, in order."""
    pieces = re.split(r"^(\w[\w ]*)\n-{3,}\n", inspect.getdoc(thing) or "", flags=re.MULTILINE)
    return dict(zip(pieces[1::2], pieces[2::2], strict=True))


def entries_of(text: str) -> set[str]:
    """The names that a section lists, each or several in a line that is not indented."""
    heads = [line for line in text.splitlines() if re.match(r"\S", line)]
    return {name.strip() for head in heads for name in head.partition(" : ")[0].split(",")}


def parameters_of(thing: object) -> set[str]:
    """The public names that a call takes; errors take what all do, protocols are never called."""
    is_protocol = getattr(thing, "_is_protocol", False)
    if is_protocol or (inspect.isclass(thing) and issubclass(thing, Exception)):
        return set()
    return {name for name in inspect.signature(thing).parameters if not name.startswith("_")}


def attributes_of(thing: object) -> set[str]:
    """What a class has, said in its body or in one that it is made from."""
    names: set[str] = set()
    for ancestor in inspect.getmro(thing) if inspect.isclass(thing) else ():
        names |= {*vars(ancestor), *inspect.get_annotations(ancestor)}
    return names


@each_export
def test_sections_are_numpys_and_in_their_order(thing: object) -> None:
    """A section of another name would be no section to an editor."""
    names = list(sections_of(thing))
    assert names == [name for name in SECTIONS if name in names]


@each_export
def test_every_parameter_has_an_entry(thing: object) -> None:
    """What a result is made of stands among its attributes."""
    sections = sections_of(thing)
    told = [sections.get(name, "") for name in ("Parameters", "Attributes")]
    entries = entries_of(told[0]) | entries_of(told[1])
    assert parameters_of(thing) <= {entry.lstrip("*") for entry in entries}


@each_export
def test_entries_name_what_is_there(thing: object) -> None:
    """What was renamed must not live on in the docstring."""
    sections = sections_of(thing)
    parameters = {entry.lstrip("*") for entry in entries_of(sections.get("Parameters", ""))}
    assert parameters <= parameters_of(thing)
    assert entries_of(sections.get("Attributes", "")) <= attributes_of(thing)


@each_export
def test_every_export_shows_an_example_that_imports_what_it_uses(thing: object) -> None:
    """Doctests run among a module's own names; who reads one has none of these."""
    examples = doctest.DocTestParser().get_examples(sections_of(thing).get("Examples", ""))
    assert examples
    tree = ast.parse("".join(example.source for example in examples))
    made = set(dir(builtins))
    for node in ast.walk(tree):
        if isinstance(node, ast.Import | ast.ImportFrom):
            made |= {name.asname or name.name for name in node.names}
        elif isinstance(node, ast.FunctionDef | ast.ExceptHandler):
            made.add(str(node.name))
        elif isinstance(node, ast.arg):
            made.add(node.arg)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            made.add(node.id)
    assert {node.id for node in ast.walk(tree) if isinstance(node, ast.Name)} <= made
