"""How the site is built: Sphinx with MyST Markdown, formulas as MathML, reference pages made from
the code.

Everything is made without a network, and the pages need none.
"""

import sys
from pathlib import Path

import cyclemap

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_extensions"))
sys.path[:0] = [str(HERE), str(HERE.parent)]

from rooms import write_pages  # noqa: E402

project = "cyclemap"
author = "The cyclemap developers"
release = version = cyclemap.__version__
project_copyright = author

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx_click",
    "sphinx_copybutton",
    "sphinx_design",
    "drawings",
    "explorer_page",
    "gallery",
    "mathml_math",
    "public_names",
    "settings_table",
]
exclude_patterns = ["_build", "_extensions", "_figures", "gallery/*.md"]
# The pages of the reference follow the rooms' own tables of contents; each name in them has a page
# of its own.
write_pages(HERE / "reference" / "api")
autosummary_generate = False
nitpicky = True
# Types in signatures that are not public, and those of other libraries, have no page of their own
# here.
nitpick_ignore_regex = [
    (
        r"py:.*",
        r"(numpy|np|collections|concurrent|pathlib|matplotlib|fractions|typing|types|pandas|pd|scipy|sympy|casadi|PIL|rich|click|xarray)(\..*)?",
    ),
    (r"py:.*", r"cyclemap\.[a-z_]+\..*"),
    (r"py:class", r"[A-Z][A-Za-z]*"),
    # How Sphinx splits `tuple[float, ...]` in the signature of a class with defaults.
    (r"py:class", r"tuple\[float"),
    # Errors that docstrings name without their room.
    (r"py:exc", r"[A-Z][A-Za-z]*"),
]

myst_enable_extensions = ["amsmath", "colon_fence", "deflist", "dollarmath"]
myst_heading_anchors = 3
smartquotes = False
html_math_renderer = "mathml"
math_numfig = False

add_module_names = False
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
maximum_signature_line_length = 90
python_use_unqualified_type_names = True
# A page holds one name; in the contents of every page its members would be one list more.
toc_object_entries = False

copybutton_prompt_text = r">>> |\.\.\. |\$ "
copybutton_prompt_is_regexp = True
copybutton_only_copy_prompt_lines = True
copybutton_line_continuation_character = "\\"

html_theme = "furo"
html_title = "cyclemap"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}
