"""The site's own extensions: formulas and docstrings."""

import doctest
from xml.etree import ElementTree

import mathml_math
import public_names
import pytest
import rooms
from mathml_math import UnknownFormula, mathml

NAMESPACE = "{http://www.w3.org/1998/Math/MathML}"


@pytest.mark.parametrize(
    ("latex", "tags"),
    [
        (r"\frac{\pi}{\sqrt{a\,\varepsilon}}", {"mfrac", "msqrt"}),
        (r"\sum_{k=1}^n c_k \cos k\theta", {"munderover"}),
        (r"\begin{pmatrix} a & b \\ c & d \end{pmatrix}", {"mtable", "mtr", "mtd"}),
        (r"\dot v = \hat z \times r", {"mover"}),
    ],
)
def test_formulas_become_the_mathml_that_they_mean(latex: str, tags: set[str]) -> None:
    elements = ElementTree.fromstring(mathml(latex, True)).iter()
    assert tags <= {element.tag.removeprefix(NAMESPACE) for element in elements}


@pytest.mark.parametrize(
    "latex", [r"\nosuchthing{x}", r"\frac{1}", r"\begin{nosuch} x \end{nosuch}"]
)
def test_what_is_no_known_formula_is_refused(latex: str) -> None:
    with pytest.raises(UnknownFormula):
        mathml(latex)


def test_in_docstrings_code_alone_is_marked_and_examples_stay_as_they_are() -> None:
    lines = ["With |a| * x_n, of `CircleMap`:", "", ">>> `1` * 2", "2 | `3`", "", "then `theta`."]
    public_names.as_text(None, "property", "", None, None, lines)
    assert lines == [
        r"With \|a\| \* x_n, of :py:obj:`~cyclemap.CircleMap`:",
        *lines[1:5],
        "then ``theta``.",
    ]
    assert lines[2:4] == [">>> `1` * 2", "2 | `3`"]


def test_sections_become_lists_whose_types_are_no_links() -> None:
    lines = ["A sum.", "", "Parameters", "----------", "theta : ndarray, shape (n,)", "    Angles."]
    lines += ["", "Returns", "-------", "float", "    Of them."]
    public_names.as_text(None, "function", "", None, None, lines)
    text = "\n".join(lines)
    assert ":Parameters: **theta** (*ndarray, shape (n,)*) -- Angles." in text
    assert ":returns: *float* -- Of them." in text


@pytest.mark.parametrize("module", [mathml_math, public_names, rooms], ids=lambda one: one.__name__)
def test_the_extensions_own_examples_hold(module) -> None:
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0
