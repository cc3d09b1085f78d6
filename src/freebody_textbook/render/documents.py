"""A derivation as terminal text, Markdown, LaTeX document and HTML page: one walk over its blocks,
and a record for each kind of document with its templates."""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

from freebody.expressions.nodes import Expression, Sourced, nodes
from freebody.expressions.typesetting.literal import declared, literal
from freebody.expressions.typesetting.mathml import lean, mathml
from freebody.figures import colours
from freebody.outputs.harmless_text import legal
from freebody.outputs.pages import SHEETS, math_style, policy
from freebody_textbook.render import equation_lines, styles
from freebody_textbook.render.equation_lines import EquationGroups
from freebody_textbook.render.prose import (
    Medium,
    cited,
    markdown_prose,
    tex_prose,
    text_prose,
    web_prose,
)

if TYPE_CHECKING:
    from freebody_textbook.derivation import Derivation, Meaning, Step

Figures = Mapping[str, str]
"""SVG text by the name that a step gives its figure."""

SymbolRows = Sequence[tuple[str, str, str]]
"""Rows of the table of symbols: symbols, meaning, unit or ""."""

SOURCE = "S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019"
TALLEST = 40
"""Lines that a frame around a result may hold, so that it fits on a page."""

LETTERS = 34.0
"""Letters of a line in a window of 400 px."""
LARGEST = 595_000
"""Bytes that a page may have, what it holds for phones included."""


@dataclass(frozen=True)
class LivingParts:
    """HTML of a page's interactive parts: the panel with the drawing and sliders, the values below
    each step's equations, and the texts of the page's loader script and of the script that it
    decompresses."""

    panel: str
    below: Mapping[Step, str]
    script: str
    inflated: str


@dataclass(frozen=True, kw_only=True)
class _Document:
    """A kind of document, defined by templates for its blocks; `prose` typesets their sentences."""

    prose: Medium
    symbol: Callable[[Expression], str]
    equations: Callable[[Step], str]
    listed: Callable[[list[str]], str] = ", ".join
    """How symbols of one meaning are listed."""
    wrap: Callable[[str, str], str] = lambda words, indent: words
    rows: Callable[[_Document, SymbolRows], str] = lambda self, rows: "".join(
        self.row.format(*row) for row in rows
    )
    title: str
    underline: str = ""
    """The letter that a title is underlined with."""
    given: str = "{}"
    row: str = ""
    """A row of the table of symbols."""
    table: str = "{}"
    terms: str = "{}"
    """The table of what terms are, without unit."""
    figure: str = ""
    opening: str = ""
    """The text before the first step."""
    heading: str
    """The heading of a step: its number, what is done, and `notes` with the notes' equation
    numbers."""
    number: str = "{}. "
    notes: str
    reason: str = "{}"
    end: str = ""
    """Text at the end of a step."""
    source: str
    between: str = "\n"

    def __call__(self, derivation: Derivation, figures: Figures | None = None) -> str:
        """The document's text; each figure is placed where a step first refers to it."""
        return self.of(derivation)._written(derivation, figures)

    def of(self, derivation: Derivation) -> _Document:
        """The kind of document with symbols in sentences as in the derivation's equations."""
        planar = derivation.equations.symbols.model.dim == 2
        return replace(self, prose=self.prose.planar) if planar else self

    def _written(self, derivation: Derivation, figures: Figures | None) -> str:
        left, prose = dict(figures or {}), self.prose
        title = prose(_title(derivation))
        blocks = [self.title.format(title), self.underline * _cells(title)]
        blocks += [
            self.given.format(self.wrap(prose(words), ""))
            for words in derivation.given.splitlines()
        ]
        if "overview" in left:
            blocks.append(self.figure.format(left.pop("overview")))
        if derivation.given:
            blocks.append(self.table.format(self._rows(derivation.glossary)))
        blocks.append(self.opening)
        for number, step in enumerate(derivation.steps, 1):
            blocks.append(self.step(step, self.number.format(number), left))
        blocks.append(self.source.format(self.wrap(prose(_source(derivation)), "")))
        return self.between.join(filter(None, blocks))

    def step(self, step: Step, number: str = "", left: dict[str, str] | None = None) -> str:
        """Text of a step, with its figure if `left` still contains it."""
        notes = self.notes.format(self.prose(cited(step.notes))) if step.notes else ""
        blocks = [
            self.heading.format(number, self.prose(step.operation), notes),
            self.reason.format(self.wrap(self.prose(step.reason), "   ")),
        ]
        blocks.append(self.equations(step) if step.equations else "")
        if left and step.figure in left:
            blocks.append(self.figure.format(left.pop(step.figure)))
        blocks.append(self.terms.format(self._rows(step.terms)) if step.terms else "")
        return self.between.join(filter(None, [*blocks, self.end]))

    def _rows(self, table: Sequence[Meaning]) -> str:
        prose = self.prose
        rows = [
            (self.listed(list(map(self.symbol, m.symbols))), prose(m.words), prose(m.unit))
            for m in table
        ]
        return self.rows(self, rows)


# ---------------------------------------------------------------- text
def text(derivation: Derivation, width: int = 100) -> str:
    """The derivation as text for a terminal."""
    return _terminal(width)(derivation)


def step_text(step: Step, width: int = 100) -> str:
    """A step as terminal text, without its number."""
    return _terminal(width).step(step).lstrip("\n")


def _terminal(width: int) -> _Document:
    return _Document(
        prose=text_prose,
        symbol=str,
        equations=lambda step: _text_equations(step, width),
        wrap=lambda words, indent: textwrap.fill(
            words, width, initial_indent=indent, subsequent_indent=indent
        ),
        rows=lambda _, rows: _text_table(rows, width),
        title="{}",
        underline="=",
        given="\n{}",
        table="\n{}",
        terms="\n{}",
        heading="\n{}{}{}",
        notes="  [notes {}]",
        source="\n{}",
    )


def _text_equations(step: Step, width: int) -> str:
    lines = equation_lines.text([step.equations], width - 8).splitlines()
    if not step.result:
        return "\n" + textwrap.indent("\n".join(lines), "      ")
    size = max(map(_cells, lines))
    inside = [f"   │ {line}{' ' * (size - _cells(line))} │" for line in lines]
    return "\n".join(["", f"   ┌{'─' * (size + 2)}┐", *inside, f"   └{'─' * (size + 2)}┘"])


def _cells(line: str) -> int:
    """Terminal columns of a line; combining dots take none."""
    return len(re.sub("[\u0300-\u036f]", "", line))


def _text_table(rows: SymbolRows, width: int) -> str:
    size = min(24, max((_cells(names) for names, _, _ in rows), default=0))
    lines = []
    for names, words, unit in rows:
        pad = " " * max(1, size + 2 - _cells(names))
        lines += textwrap.wrap(
            f"{names}{pad}{words}" + (f" [{unit}]" if unit else ""), width - 3,
            initial_indent="   ", subsequent_indent=" " * (size + 5),
            drop_whitespace=True, break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
    return "\n".join(lines)


# ---------------------------------------------------------------- Markdown and LaTeX
def _framed(step: Step) -> str:
    """A step's equations in LaTeX, boxed if the step is a result that fits into a box."""
    formula = equation_lines.latex([step.equations])
    return f"\\boxed{{\n{formula}\n}}" if _fits(step, formula) else formula


def _fits(step: Step, formula: str) -> bool:
    """Whether a step is a result whose equations fit into a box."""
    return step.result and len(formula.splitlines()) <= TALLEST


def _display(step: Step) -> str:
    if _fits(step, equation_lines.latex([step.equations])):
        return f"\\[\n{_framed(step)}\n\\]"
    return equation_lines.latex([step.equations], "align*")


_MARKDOWN = _Document(
    prose=markdown_prose,
    symbol=lambda symbol: f"${symbol.latex()}$",
    equations=lambda step: f"$$\n{_framed(step)}\n$$",
    title="# {}",
    row="\n| {} | {} | {} |",
    table="| symbol | meaning | unit |\n|---|---|---|{}",
    terms="| term | what it is | |\n|---|---|---|{}",
    figure="![]({})",
    heading="## {}{}{}",
    notes=" — notes {}",
    source="*{}*",
    between="\n\n",
)

_LATEX = _Document(
    prose=tex_prose,
    symbol=_MARKDOWN.symbol,
    equations=_display,
    title=r"{{\LARGE\bfseries {}\par}}\bigskip",
    given="{}\n",
    row="\n{} & {} & {} \\\\",
    table="\\begin{{center}}\\small\n\\begin{{tabular}}{{lp{{70mm}}l}}{}\n\\end{{tabular}}\n"
    "\\end{{center}}",
    terms="\\begin{{center}}\\small\n\\begin{{tabular}}{{lp{{70mm}}l}}{}\n\\end{{tabular}}\n"
    "\\end{{center}}",
    heading=r"\section{{{1}{2}}}",
    notes=r"\hfill{{\normalfont\small notes {}}}",
    source=r"\medskip\textit{{{}}}",
)

_PREAMBLE = r"""\documentclass[11pt,a4paper]{article}
\usepackage[utf8]{inputenc}
\usepackage[T1]{fontenc}
\usepackage{amsmath,amssymb}
\usepackage[margin=22mm]{geometry}
\setlength{\parindent}{0pt}
\setlength{\parskip}{4pt}
\raggedbottom
\allowdisplaybreaks"""


def markdown(derivation: Derivation, images: Figures | None = None) -> str:
    """The derivation as Markdown with formulas between dollar signs; images: paths of drawings by
    figure name."""
    return legal(_MARKDOWN(derivation, images) + "\n")


def latex(derivation: Derivation) -> str:
    """The derivation as a LaTeX document that only needs amsmath and T1 fonts."""
    inside = _LATEX(derivation)
    lines = [_PREAMBLE, *declared(inside), r"\begin{document}", inside, r"\end{document}"]
    return legal("\n".join(lines) + "\n")


# ---------------------------------------------------------------- HTML
NOTEBOOK_STYLE = f"{equation_lines.STYLE}{styles.TERMS}section>details>summary>h2{{display:inline}}"
"""The style that steps need in a page of others, such as a notebook."""

body = _Document(
    prose=web_prose,
    symbol=lambda symbol: mathml(symbol, display=False),
    equations=lambda step: (
        f'<div class="equations{" result" * step.result}">'
        f"{equation_lines.html([step.equations])}</div>"
        f"{_legend(step.equations)}"
    ),
    listed=lambda symbols: " ".join(
        [*(f"<span>{x},</span>" for x in symbols[:-1]), *symbols[-1:]]  # no comma begins a line
    ),
    title="<h1>{}</h1>",
    given="<p>{}</p>",
    row="<tr><td>{}</td><td>{}</td><td>{}</td></tr>",
    table='<details><summary>Symbols and units</summary><table class="symbols"><tbody>{}</tbody>'
    "</table></details>",
    terms='<table class="symbols"><tbody>{}</tbody></table>',
    figure="<figure>{}</figure>",
    heading='<section><details open=""><summary><h2><span>{}</span> {}{}</h2></summary>',
    number="{}",
    notes=' <small class="notes">notes {}</small>',
    reason="<p>{}</p>",
    end="</details></section>",
    source='<p class="source">{}</p>',
)
"""The steps as HTML, without a page around them."""


def tried(living: LivingParts) -> _Document:
    """The kind of HTML document with interactive parts."""
    return replace(
        body,
        opening=living.panel,
        equations=lambda step: body.equations(step) + living.below.get(step, ""),
    )


def on_phones(document: _Document, steps: Sequence[Step], room: int) -> _Document:
    """A kind of document that also contains equations in short lines for phones, at most `room`
    bytes of them."""
    short = _short_lines(steps, room)
    return replace(document, equations=lambda step: short.get(step, "") + document.equations(step))


def html(
    derivation: Derivation,
    figures: Figures | None = None,
    style: str = "",
    living: LivingParts | None = None,
) -> str:
    """A self-contained HTML page; style: CSS for the figures; living: parts that make it
    interactive."""
    title, inside, head, run = web_prose(_title(derivation)), body, policy(), ""
    if living is not None:
        inside, style = tried(living), style + colours.variables() + styles.PANEL + styles.STATE
        head, run = policy([living.script, living.inflated]), f"<script>{living.script}</script>"
    kind = ' class="living"' if living else ""

    def written(document: _Document) -> str:
        return page(title, document(derivation, figures), style, head, kind, run)

    left = LARGEST - len(written(inside).encode())
    return written(on_phones(inside, derivation.steps, left))


def page(
    title: str, inside: str, style: str = "", head: str = policy(), kind: str = "", run: str = ""
) -> str:
    """A self-contained page around HTML: what derivations and verdicts on answers look like.

    head: its policy; kind: attributes of `main`; run: the element of its script.
    """
    return legal(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">{head}'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,">'
        f"<title>{title}</title><style>{math_style()}{SHEETS}{style}{styles.PAGE}{equation_lines.STYLE}"
        f"{styles.TERMS}{styles.STEPS}{styles.SCROLLED}{styles.TOUCHED}{styles.NARROW}</style></head>\n<body>"
        f"<main{kind}>\n"
        f"{lean(inside)}\n</main>{run}</body></html>\n"
    )


_SOURCES = {
    "time": "the time derivative of ∂L/∂q̇",
    "kinetic": "∂T/∂q",
    "potential": "∂V/∂q",
    "several": "more than one of these",
}
"""Sources of terms in words, in the order in which a legend has them."""


def _legend(lines: Iterable[Expression]) -> str:
    """The legend of the marks in some lines; "" if there are none."""
    found = {x.source for line in lines for x in nodes(line) if isinstance(x, Sourced)}
    words = [
        f'<span class="term-{source}">{meant}</span>'
        for source, meant in _SOURCES.items()
        if source in found
    ]
    return f'<p class="sources">Terms from {"; ".join(words)}.</p>' if words else ""


def _short_lines(steps: Iterable[Step], room: int) -> dict[Step, str]:
    """HTML of each step whose equations are too long for a phone, in shorter lines that are hidden
    on wide screens; only for the first steps if all need more than `room` bytes, other equations
    scroll."""
    found: dict[Step, str] = {}
    for step in filter(lambda one: one.equations, steps):
        text = _shorter([step.equations], "result" if step.result else "")
        if not text:
            continue
        found[step] = text
        room -= len(lean(found[step]).encode())
        if room < 0:
            del found[step]
            break
    return found


def _shorter(groups: EquationGroups, kind: str) -> str:
    """HTML of equations in lines for a phone; "" where they fit one as they are."""
    text = equation_lines.html(groups, LETTERS)
    if text == equation_lines.html(groups):
        return ""
    return f'<div class="{f"equations short {kind}".rstrip()}">{text}</div>'


def in_lines(groups: EquationGroups, kind: str = "") -> str:
    """HTML of equations for a page, in short lines too for phones; kind: further classes."""
    full = f'<div class="{f"equations {kind}".rstrip()}">{equation_lines.html(groups)}</div>'
    return _shorter(groups, kind) + full


# ---------------------------------------------------------------- shared
def _title(derivation: Derivation) -> str:
    model = derivation.equations.symbols.model
    return f"{literal(model.name)}: {derivation.title}"


def _source(derivation: Derivation) -> str:
    numbered = any(step.notes for step in derivation.steps)
    source = derivation.equations.symbols.model.source
    written = derivation.lettering.notation
    parts = [
        f"Method: {derivation.reference}" if derivation.reference else "",
        f"Equation numbers: {SOURCE}." if numbered else "",
        f"Letters: {literal(written.source or written.title)}" if written.name != "notes" else "",
        f"Robot: {literal(source.rstrip('.'))}" if source else "",
    ]
    return " ".join(part if part.endswith(".") else part + "." for part in parts if part)
