"""Formulas as MathML, made while the site is built: pages show them without a network and without
scripts.

A formula that cannot be turned into MathML is a warning, and the build takes warnings for errors.
"""

import re
from collections.abc import Iterator
from xml.etree import ElementTree

from docutils import nodes
from latex2mathml.commands import MATRICES
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.util.math import get_node_equation_number
from sphinx.writers.html5 import HTML5Translator

LOGGER = logging.getLogger(__name__)
MATHML = "{http://www.w3.org/1998/Math/MathML}"

# What the converter does not know by these names.
OTHER_WORDS = {
    r"\\(begin|end)\{aligned\}": r"\\\1{align}",
    r"\\(arg|sgn)(?![A-Za-z])": r"\\operatorname{\1}",
    r"\\(notag|nonumber)(?![A-Za-z])": "",
}
ENVIRONMENTS = {name.lstrip("\\") for name in MATRICES}
# How many parts an element must have: a fraction with one is a slip of the pen.
PARTS = {
    "mfrac": 2,
    "mroot": 2,
    "msub": 2,
    "msup": 2,
    "munder": 2,
    "mover": 2,
    "msubsup": 3,
    "munderover": 3,
}


class UnknownFormula(ValueError):
    """LaTeX that has no MathML here: the message names what was not understood."""


def mathml(latex: str, display: bool = False) -> str:
    """Return the MathML of a formula; raises UnknownFormula where a part of it is not understood.

    >>> mathml(r"\\theta").partition(' display="inline">')[2]
    '<mrow><mi>&#x003B8;</mi></mrow></math>'
    """
    try:
        text = convert(in_known_words(latex), display="block" if display else "inline")
        faults = list(faults_of(latex, ElementTree.fromstring(text)))
    except Exception as error:
        raise UnknownFormula(f"{latex.strip()!r}: {type(error).__name__} {error}") from error
    if faults:
        raise UnknownFormula(f"{latex.strip()!r}: {'; '.join(faults)}")
    return text


def in_known_words(latex: str) -> str:
    """The same formula in words that the converter knows."""
    for pattern, other in OTHER_WORDS.items():
        latex = re.sub(pattern, other, latex)
    return latex.strip()


def faults_of(latex: str, root: ElementTree.Element) -> Iterator[str]:
    """What the converter let pass: commands and environments that it does not know, and missing
    parts.
    """
    for part in root.iter():
        name = part.tag.removeprefix(MATHML)
        if part.text and "\\" in part.text:
            yield f"{part.text} is not known"
        if len(part) != PARTS.get(name, len(part)):
            yield f"{name} has {len(part)} of {PARTS[name]} parts"
    for environment in re.findall(r"\\begin\{(\w+\*?)\}", in_known_words(latex)):
        if environment not in ENVIRONMENTS:
            yield f"environment {environment} is not known"


def html_of(translator: HTML5Translator, node: nodes.Node, display: bool) -> str:
    """The HTML of one formula; a warning, and the LaTeX as it stands,
    where it cannot be converted."""
    try:
        return mathml(node.astext(), display)
    except UnknownFormula as error:
        LOGGER.warning("formula without MathML: %s", error, location=node)
        return f"<code>{translator.encode(node.astext())}</code>"


def visit_math(translator: HTML5Translator, node: nodes.Node) -> None:
    """Write a formula that stands in a line."""
    translator.body.append(f'<span class="math">{html_of(translator, node, display=False)}</span>')
    raise nodes.SkipNode


def visit_displayed(translator: HTML5Translator, node: nodes.Node) -> None:
    """Write a formula that stands alone, with its number and anchor where it has a label."""
    translator.body.append(translator.starttag(node, "div", CLASS="math displayed"))
    translator.body.append(html_of(translator, node, display=True))
    if node["number"]:
        translator.body.append(
            f'<span class="eqno">({get_node_equation_number(translator, node)})</span>'
        )
    translator.body.append("</div>\n")
    raise nodes.SkipNode


def setup(app: Sphinx) -> dict[str, bool]:
    """Register the renderer under the name `mathml`."""
    app.add_html_math_renderer("mathml", (visit_math, None), (visit_displayed, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
