"""An item and its verdict as text for a terminal."""

from __future__ import annotations

import textwrap

from freebody.expressions.expression import Equation, Expression
from freebody_notes.item import ExecutedItem, Item, parts
from freebody_notes.steps import place_of
from freebody_textbook.relations.formula import as_printed
from freebody_textbook.render import page

WIDTH = 100
_INDENT = 12


def shown(item: Item, form: str) -> list[Expression]:
    """The equations of a formula text as expressions for print."""
    primed = getattr(item.check, "primed", ())
    return [as_printed(part, item.check.bold, primed) for part in parts(form)]


def form_text(item: Item, form: str, width: int = WIDTH) -> str:
    """A formula of an item as lines of text."""
    nodes = shown(item, form)
    equations = [node for node in nodes if isinstance(node, Equation)]
    if nodes and len(equations) == len(nodes):
        return page.text([equations], width)
    return "\n".join(textwrap.fill(str(node), width) for node in nodes)


def item_text(finding: ExecutedItem, width: int = WIDTH) -> str:
    """Complete text about one checked item."""
    item, inner = finding.item, width - _INDENT
    rows = [("printed", form_text(item, item.printed, inner) or "nothing")]
    rows.append(("computed", _filled(finding.printed.lines, inner)))
    if finding.printed.example:
        rows.append(("example", _filled((finding.printed.example,), inner)))
    if finding.corrected is not None:
        rows.append(("corrected", form_text(item, item.corrected, inner)))
        rows.append(("proof", _filled(finding.corrected.lines, inner)))
        rows.append(("why", _filled((item.why,), inner)))
    rows.append(("call", item.check.call(item.printed or item.corrected)))
    head = f"{item.title} — {item.number}"
    blocks = [head, "=" * len(head), textwrap.fill(item.says, width), ""]
    blocks += [_row(name, text) for name, text in rows if text]
    return "\n".join(blocks + _derived(item, width))


def _derived(item: Item, width: int) -> list[str]:
    place = place_of(item)
    if place is None:
        return []
    return [
        "",
        f"In {place.call}, “{place.step.operation}”:",
        textwrap.fill(place.step.reason, width),
        "",
        textwrap.indent(page.text([place.step.equations], width - 4), "    "),
    ]


def _filled(lines: tuple[str, ...], width: int) -> str:
    return "\n".join(_wrapped(line, width) for line in lines)


def _wrapped(line: str, width: int) -> str:
    """A sentence broken into lines of a width; a line with a caret is kept unbroken."""
    return line if line.startswith(" ") else textwrap.fill(line, width, break_long_words=False)


def _row(name: str, text: str) -> str:
    """A label with its text beside it."""
    first, *rest = text.splitlines()
    return "\n".join([f"{name:<{_INDENT}}{first}", *(" " * _INDENT + line for line in rest)])
