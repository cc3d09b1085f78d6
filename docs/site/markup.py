"""A Sphinx extension: HTML for screen readers. Sphinx writes the lines of a long signature
as a list of definitions without terms, and the captions of the navigation as headings of no level;
neither can be announced."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.addnodes import desc_parameterlist
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

LINES = {"<dl": '<span class="parameters"', "<dd": "<span", "</dl>": "</span>", "</dd>": "</span>"}
"""What a list of definitions is written as within a signature; site.css gives each its line."""


class Translator(HTML5Translator):
    """Sphinx's own, but for signatures of several lines and for the levels of captions."""

    def starttag(
        self,
        node: nodes.Element,
        tagname: str,
        suffix: str = "\n",
        empty: bool = False,
        **given: Any,
    ) -> str:
        """An opening tag; of a heading by role it says the level, which ARIA requires."""
        if given.get("ROLE") == "heading":
            given["aria-level"] = "2"
        return super().starttag(node, tagname, suffix, empty, **given)

    def visit_desc_parameterlist(self, node: desc_parameterlist) -> None:
        """Begin the arguments of a signature."""
        self.first_of_signature = len(self.body)
        super().visit_desc_parameterlist(node)

    def depart_desc_parameterlist(self, node: desc_parameterlist) -> None:
        """End the arguments of a signature: what were lists of definitions become lines."""
        super().depart_desc_parameterlist(node)
        for k in range(self.first_of_signature, len(self.body)):
            for definitions, lines in LINES.items():
                self.body[k] = self.body[k].replace(definitions, lines)


def setup(app: Sphinx) -> dict[str, bool]:
    """Register with Sphinx, which calls this."""
    app.set_translator("html", Translator)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
