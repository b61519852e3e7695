"""The documentation site: `make docs` builds it into site/, and a warning fails."""

from __future__ import annotations

import sys
from pathlib import Path

from lmic import __version__

sys.path.insert(0, str(Path(__file__).parent))

project = "lmic"
version = release = __version__
copyright = "the lmic developers"

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx_click", "library"]
source_suffix = {".md": "markdown"}
suppress_warnings: list[str] = []
nitpicky = True
# other packages' types have no page here, and the kinds of expression are all Nodes
nitpick_ignore_regex = [
    ("py:.*", r"(click|collections|control|enum|fractions|numpy|np|os|pathlib|scipy|sp|sps|sympy)\..*"),
    ("py:class", r"lmic\.language\.nodes\..*"),
]

myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints_format = "short"
# the fields of a record say what its constructor takes
autodoc_class_signature = "separated"
autodoc_default_options = {"members": True, "undoc-members": True, "exclude-members": "__init__, __new__"}

html_theme = "furo"
html_title = f"lmic {__version__}"
html_static_path: list[str] = []
html_copy_source = False
html_show_sphinx = False
pygments_style = "friendly"
pygments_dark_style = "github-dark"
