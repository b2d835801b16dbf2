"""The site's own extensions: formulas and docstrings."""

import doctest
from xml.etree import ElementTree

import house_docstrings
import mathml_math
import public_names
import pytest
import rooms
from house_docstrings import house_to_rest
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
    found = {
        element.tag.removeprefix(NAMESPACE)
        for element in ElementTree.fromstring(mathml(latex, True)).iter()
    }
    assert tags <= found


@pytest.mark.parametrize(
    "latex", [r"\nosuchthing{x}", r"\frac{1}", r"\begin{nosuch} x \end{nosuch}"]
)
def test_what_is_no_known_formula_is_refused(latex: str) -> None:
    with pytest.raises(UnknownFormula):
        mathml(latex)


def test_docstrings_become_lists_rubrics_formulas_and_examples() -> None:
    words = (
        "What it is, with a*b and x_n.\n\nParameters\n----------\nfirst, second : m, of "
        "`CircleMap`.\nthird : how\n"
        "    many.\n\n    h(v) = s * v\n\n- one\n- two\n\n>>> 1 + 1\n2"
    )
    text = "\n".join(house_to_rest(words.split("\n")))
    assert r"with a\*b and x\_n." in text
    assert ".. rubric:: Parameters" in text
    assert (
        "* **first, second** : m, of :py:obj:`~cyclemap.CircleMap`.\n* **third** : how many."
        in text
    )
    assert ".. code-block:: text\n\n       h(v) = s * v" in text
    assert "* one" in text and "* two" in text
    assert ".. code-block:: pycon\n\n   >>> 1 + 1\n   2" in text


@pytest.mark.parametrize(
    "module", [house_docstrings, mathml_math, public_names, rooms], ids=lambda one: one.__name__
)
def test_the_extensions_own_examples_hold(module) -> None:
    found = doctest.testmod(module)
    assert found.attempted > 0 and found.failed == 0
