"""Settings of the site: Sphinx reads the Markdown pages as they stand in the repository, and makes
the reference from docstrings and the gallery from its scripts.

    sphinx-build -W --keep-going -c docs . build/site
"""

import sys
from pathlib import Path

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT / "docs" / "site"))

import freebody as fb  # noqa: E402

project = "freebody"
author = "the freebody developers"
version = release = fb.__version__
root_doc = "docs/index"
include_patterns = [
    "docs/**",
    "benchmarks/README.md",
    "proof/README.md",
    "README.md",
    "CHANGELOG.md",
    "CONTRIBUTING.md",
    "SECURITY.md",
    "THIRD-PARTY.md",
]
exclude_patterns = ["docs/site/**", "docs/gallery/made/pages"]
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "reference",
    "gallery",
    "markup",
    "notebooks",
]
nitpicky = True  # a reference that leads nowhere is a warning, and -W makes an error of it

myst_enable_extensions = ["smartquotes"]
myst_heading_anchors = 4  # the same anchors as on GitHub
suppress_warnings = ["myst.header", "misc.highlighting_failure"]

autodoc_typehints = "signature"
autodoc_typehints_format = "short"
maximum_signature_line_length = 88
nitpick_ignore_regex = [("py:class", ".*")]  # types of arguments, most of them aliases
autodoc_member_order = "bysource"

html_theme = "furo"
html_title = f"freebody {version}"
html_static_path = ["site/static"]
html_css_files = ["site.css"]
html_extra_path = ["site/top", "gallery/made/pages", "notebooks/made"]
html_show_sphinx = html_show_copyright = False
html_copy_source = False
