"""Terms by where they came from, in pages: what a colour and an underline mean."""

from __future__ import annotations

from collections.abc import Iterable

from freebody.expressions.nodes import Expression, Sourced, nodes

_MEANT = {
    "time": "the time derivative of ∂L/∂q̇",
    "kinetic": "∂T/∂q",
    "potential": "∂V/∂q",
    "several": "more than one of these",
}
"""In the order in which a legend has them."""


def legend(lines: Iterable[Expression]) -> str:
    """What the marks in some lines mean; nothing where there are none."""
    found = {x.source for line in lines for x in nodes(line) if isinstance(x, Sourced)}
    words = [
        f'<span class="term-{source}">{meant}</span>'
        for source, meant in _MEANT.items()
        if source in found
    ]
    return f'<p class="sources">Terms from {"; ".join(words)}.</p>' if words else ""


STYLE = """
.term-time{color:#1d4fc4;border-bottom:.07em solid}
.term-kinetic{color:#b0480a;border-bottom:.09em dashed}
.term-potential{color:#1f7a36;border-bottom:.11em dotted}
.term-several{border-bottom:.2em double}
.sources{font-size:.92em;color:#5a6675}
@media screen and (prefers-color-scheme:dark){.term-time{color:#8ab4ff}
.term-kinetic{color:#ffa765}.term-potential{color:#74cf8a}.sources{color:#9aa6b5}}
"""
"""Each source has a colour and a kind of line, so that print without colour shows it too."""
