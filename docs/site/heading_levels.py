"""A Sphinx extension: captions of the table of contents say to screen readers at which level they
stand, without which browsers take a level of their own (axe: aria-required-attr)."""

from __future__ import annotations

from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.writers.html5 import HTML5Translator

LEVEL = ' aria-level="2"'
"""Below the title of the page."""


class LevelledCaptions(HTML5Translator):
    """Sphinx's translator, whose headings by role have a level."""

    def starttag(self, node: nodes.Node, tagname: str, *args: Any, **attributes: Any) -> str:
        """The start of an element."""
        text = super().starttag(node, tagname, *args, **attributes)
        return text.replace(' role="heading"', f' role="heading"{LEVEL}', 1)


def setup(app: Sphinx) -> dict[str, Any]:
    """Registers the translator."""
    app.set_translator("html", LevelledCaptions)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
