"""A derivation as text for a terminal, Markdown, a LaTeX document and an HTML page."""

from __future__ import annotations

import html as escape
import re
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

from freebody.derivations.render import page
from freebody.derivations.render import text as plain
from freebody.derivations.render.equation_numbers import cited
from freebody.derivations.render.literal import literal
from freebody.derivations.render.mathml import mathml
from freebody.derivations.render.prose import markdown_prose, tex_prose, text_prose, web_prose
from freebody.outputs.page import policy
from freebody.outputs.text import legal

if TYPE_CHECKING:
    from freebody.derivations.derivation import Derivation, Meaning, Step

Figures = Mapping[str, str]
"""SVG text by the name that a step gives its figure."""

SOURCE = "S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019"
TALLEST = 40
"""Lines that a frame around a result may hold, so that it fits on a page."""


# ---------------------------------------------------------------- text
def text(derivation: Derivation, width: int = 100) -> str:
    """For a terminal."""
    title = text_prose(_title(derivation))
    blocks = [title, "=" * _cells(title)]
    if derivation.given:
        blocks += [
            "",
            textwrap.fill(text_prose(derivation.given), width),
            "",
            *_text_table(derivation, width),
        ]
    for number, step in enumerate(derivation.steps, 1):
        blocks += ["", f"{number}. {step.operation}{_numbers(step, '  [notes {}]')}"]
        blocks.append(textwrap.indent(textwrap.fill(text_prose(step.reason), width - 3), "   "))
        if step.equations:
            blocks += ["", _text_equations(step, width)]
    return "\n".join([*blocks, "", textwrap.fill(text_prose(_source(derivation)), width)])


def _text_equations(step: Step, width: int) -> str:
    lines = page.text([step.equations], width - 8).splitlines()
    if not step.result:
        return textwrap.indent("\n".join(lines), "      ")
    size = max(map(_cells, lines))
    inside = [f"   │ {line}{' ' * (size - _cells(line))} │" for line in lines]
    return "\n".join([f"   ┌{'─' * (size + 2)}┐", *inside, f"   └{'─' * (size + 2)}┘"])


def _cells(line: str) -> int:
    """Columns that a line takes: combining dots take none."""
    return len(re.sub("[\u0300-\u036f]", "", line))


def _text_table(derivation: Derivation, width: int) -> list[str]:
    rows = [(", ".join(map(plain.text, m.symbols)), m) for m in derivation.glossary]
    size = min(24, max((_cells(names) for names, _ in rows), default=0))
    lines = []
    for names, meaning in rows:
        pad = " " * max(1, size + 2 - _cells(names))
        lines += textwrap.wrap(
            f"{names}{pad}{_meaning(meaning)}", width - 3, initial_indent="   ",
            subsequent_indent=" " * (size + 5),
            drop_whitespace=True, break_long_words=False, break_on_hyphens=False,
        )  # fmt: skip
    return lines


def _meaning(meaning: Meaning) -> str:
    words = text_prose(meaning.words)
    return f"{words} [{meaning.unit}]" if meaning.unit else words


# ---------------------------------------------------------------- Markdown
def markdown(derivation: Derivation, images: Figures | None = None) -> str:
    """Markdown with formulas between dollar signs; images: paths of drawings by the names of
    figures."""
    left = dict(images or {})
    blocks = [f"# {markdown_prose(_title(derivation))}"]
    if derivation.given:
        blocks += [markdown_prose(derivation.given), _markdown_table(derivation)]
    if "overview" in left:
        blocks.append(f"![]({left.pop('overview')})")
    for number, step in enumerate(derivation.steps, 1):
        blocks += [
            f"## {number}. {step.operation}{_numbers(step, ' — notes {}')}",
            markdown_prose(step.reason),
        ]
        if step.figure in left:
            blocks.append(f"![]({left.pop(step.figure)})")
        if step.equations:
            formula = page.latex([step.equations])
            blocks.append(f"$$\n{_boxed(formula) if _fits(step, formula) else formula}\n$$")
    return legal("\n\n".join([*blocks, f"*{markdown_prose(_source(derivation))}*"]) + "\n")


def _markdown_table(derivation: Derivation) -> str:
    rows = ["| symbol | meaning | unit |", "|---|---|---|"]
    for m in derivation.glossary:
        rows.append(f"| {_dollars(m)} | {markdown_prose(m.words)} | {m.unit} |")
    return "\n".join(rows)


# ---------------------------------------------------------------- LaTeX
def latex(derivation: Derivation) -> str:
    """A LaTeX document that needs amsmath and T1 fonts only."""
    lines = [
        r"\documentclass[11pt,a4paper]{article}",
        r"\usepackage[utf8]{inputenc}",
        r"\usepackage[T1]{fontenc}",
        r"\usepackage{amsmath,amssymb}",
        r"\usepackage[margin=22mm]{geometry}",
        r"\setlength{\parindent}{0pt}",
        r"\setlength{\parskip}{4pt}",
        r"\raggedbottom",
        r"\allowdisplaybreaks",
        r"\begin{document}",
        rf"{{\LARGE\bfseries {tex_prose(_title(derivation))}\par}}\bigskip",
    ]
    if derivation.given:
        lines += [tex_prose(derivation.given), *_latex_table(derivation)]
    for step in derivation.steps:
        notes = tex_prose(_numbers(step, "notes {}"))
        beside = rf"\hfill{{\normalfont\small {notes}}}" if notes else ""
        lines += [rf"\section{{{tex_prose(step.operation)}{beside}}}", tex_prose(step.reason)]
        if step.equations:
            lines.append(_latex_equations(step))
    lines += [rf"\medskip\textit{{{tex_prose(_source(derivation))}}}", r"\end{document}"]
    return legal("\n".join(lines) + "\n")


def _latex_equations(step: Step) -> str:
    formula = page.latex([step.equations])
    if _fits(step, formula):
        return f"\\[\n{_boxed(formula)}\n\\]"
    return page.latex([step.equations], "align*")


def _fits(step: Step, formula: str) -> bool:
    """Whether a step is a result that a frame can hold."""
    return step.result and len(formula.splitlines()) <= TALLEST


def _boxed(formula: str) -> str:
    return f"\\boxed{{\n{formula}\n}}"


def _latex_table(derivation: Derivation) -> list[str]:
    rows = [
        rf"{_dollars(m)} & {tex_prose(m.words)} & {tex_prose(m.unit)} \\"
        for m in derivation.glossary
    ]
    return [
        r"\begin{center}\small",
        r"\begin{tabular}{lp{95mm}l}",
        *rows,
        r"\end{tabular}",
        r"\end{center}",
    ]


# ---------------------------------------------------------------- HTML
def body(derivation: Derivation, figures: Figures | None = None) -> str:
    """The steps as HTML, without a page around them; a figure stands where a step first asks for
    it."""
    shown: set[str] = set()
    parts = [f"<h1>{web_prose(_title(derivation))}</h1>"]
    if derivation.given:
        parts += [f"<p>{web_prose(derivation.given)}</p>", _html_table(derivation)]
    if figures and "overview" in figures:
        parts.append(f"<figure>{figures['overview']}</figure>")
    for number, step in enumerate(derivation.steps, 1):
        note = _numbers(step, ' <small class="notes">notes {}</small>')
        parts.append(f"<section><h2><span>{number}</span> {web_prose(step.operation)}{note}</h2>")
        parts.append(f"<p>{web_prose(step.reason)}</p>")
        name = step.figure
        if name is not None and figures and name in figures and name not in shown:
            shown.add(name)
            parts.append(f"<figure>{figures[name]}</figure>")
        if step.equations:
            kind = "equations result" if step.result else "equations"
            parts.append(f'<div class="{kind}">{page.html([step.equations])}</div>')
        parts.append("</section>")
    return "\n".join([*parts, f'<p class="source">{web_prose(_source(derivation))}</p>'])


def _html_table(derivation: Derivation) -> str:
    rows = "".join(
        f"<tr><td>{', '.join(mathml(x, display=False) for x in m.symbols)}</td>"
        f"<td>{web_prose(m.words)}</td><td>{escape.escape(m.unit)}</td></tr>"
        for m in derivation.glossary
    )
    return f'<table class="symbols"><tbody>{rows}</tbody></table>'


def html(derivation: Derivation, figures: Figures | None = None, style: str = "") -> str:
    """One page that fetches nothing; `style` is for the figures."""
    title = web_prose(_title(derivation))
    return legal(
        f'<!doctype html>\n<html lang="en"><head><meta charset="utf-8">{policy()}'
        '<meta name="viewport" content="width=device-width, initial-scale=1">'
        '<meta name="color-scheme" content="light dark"><link rel="icon" href="data:,">'
        f"<title>{title}</title><style>{style}{_STYLE}</style></head>\n<body><main>\n"
        f"{body(derivation, figures)}\n</main></body></html>\n"
    )


_STYLE = """
body{font:17px/1.6 system-ui,sans-serif;margin:0;color:#1b2430;background:#fff}
main{max-width:60rem;margin:0 auto;padding:2rem 1.2rem 4rem}
h1{font-size:1.9rem;line-height:1.25}
h2{font-size:1.2rem;margin:2.4rem 0 .3rem}h2 span{color:#8a94a3;margin-right:.4em}
h2 .notes{font-weight:400;color:#5a6675;font-size:.85rem;margin-left:.4em}
p{max-width:44rem}.equations{overflow-x:auto;padding:.3rem 0}
.result{border:1.5px solid #8a94a3;border-radius:.4rem;padding:.8rem;margin-top:.8rem}
.symbols{border-collapse:collapse;font-size:.92rem;margin:1rem 0}
.symbols td{padding:.12rem 1.2rem .12rem 0;vertical-align:baseline}
.symbols td:last-child{white-space:nowrap}
math{font-size:1.08rem}p math,td math{font-size:1em}
figure{margin:1rem 0;text-align:center}figure svg{max-width:100%;height:auto}
.source{color:#5a6675;font-size:.9rem;margin-top:3rem}
@media (prefers-color-scheme:dark){body{color:#e4e9f0;background:#12161c}
.source,h2 .notes{color:#9aa6b5}}
@media print{main{max-width:none;padding:0}section{break-inside:avoid-page}}
"""


# ---------------------------------------------------------------- shared
def _title(derivation: Derivation) -> str:
    model = derivation.equations.symbols.model
    return f"{literal(model.name)}: {derivation.title}"


def _dollars(meaning: Meaning) -> str:
    """Symbols between dollar signs."""
    return ", ".join(f"${x.latex()}$" for x in meaning.symbols)


def _numbers(step: Step, form: str) -> str:
    """The notes' equation numbers in a form such as "[notes {}]", or nothing."""
    return form.format(cited(step.notes)) if step.notes else ""


def _source(derivation: Derivation) -> str:
    numbered = any(step.notes for step in derivation.steps)
    source = derivation.equations.symbols.model.source
    parts = [
        f"Method: {derivation.reference}" if derivation.reference else "",
        f"Equation numbers: {SOURCE}." if numbered else "",
        f"Robot: {literal(source.rstrip('.'))}" if source else "",
    ]
    return " ".join(part if part.endswith(".") else part + "." for part in parts if part)
