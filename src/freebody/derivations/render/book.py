"""A derivation as text for a terminal, Markdown, a LaTeX document and an HTML page."""

from __future__ import annotations

import html as escape
import textwrap
from collections.abc import Mapping
from typing import TYPE_CHECKING

from freebody.derivations.names import GREEK
from freebody.derivations.render import page

if TYPE_CHECKING:
    from freebody.derivations.derivation import Derivation, Step

Figures = Mapping[str, str]
"""SVG text by the name that a step gives its figure."""

SOURCE = "S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019"


def text(derivation: Derivation, width: int = 100) -> str:
    """For a terminal."""
    blocks = [_title(derivation), "=" * len(_title(derivation))]
    for number, step in enumerate(derivation.steps, 1):
        blocks += ["", f"{number}. {step.operation}{_numbers(step)}"]
        blocks.append(textwrap.indent(textwrap.fill(step.reason, width - 3), "   "))
        if step.equations:
            blocks += ["", textwrap.indent(page.text([step.equations], width - 6), "      ")]
    return "\n".join([*blocks, "", _source(derivation)])


def markdown(derivation: Derivation) -> str:
    """Markdown with formulas between dollar signs."""
    blocks = [f"# {_title(derivation)}"]
    for number, step in enumerate(derivation.steps, 1):
        blocks += [f"## {number}. {step.operation}{_numbers(step)}", step.reason]
        if step.equations:
            blocks.append(f"$$\n{page.latex([step.equations])}\n$$")
    return "\n\n".join([*blocks, f"*{_source(derivation)}*"]) + "\n"


def latex(derivation: Derivation) -> str:
    """A LaTeX document that needs amsmath only."""
    lines = [
        r"\documentclass[11pt,a4paper]{article}",
        r"\usepackage[utf8]{inputenc}",
        r"\usepackage{amsmath,amssymb}",
        r"\usepackage[margin=22mm]{geometry}",
        r"\allowdisplaybreaks",
        rf"\title{{{_tex(_title(derivation))}}}",
        r"\date{}",
        r"\begin{document}",
        r"\maketitle",
    ]
    for step in derivation.steps:
        lines += [rf"\section{{{_tex(step.operation + _numbers(step))}}}", _tex(step.reason)]
        if step.equations:
            lines.append(page.latex([step.equations], "align*"))
    lines += [rf"\medskip\noindent\textit{{{_tex(_source(derivation))}}}", r"\end{document}"]
    return "\n".join(lines) + "\n"


def body(derivation: Derivation, figures: Figures | None = None) -> str:
    """The steps as HTML, without a page around them; a figure stands where a step first asks for it."""
    shown: set[str] = set()
    parts = [f"<h1>{escape.escape(_title(derivation))}</h1>"]
    for number, step in enumerate(derivation.steps, 1):
        note = f' <small class="notes">{_numbers(step).strip()}</small>' if step.notes else ""
        parts.append(f"<section><h2><span>{number}</span> {escape.escape(step.operation)}{note}</h2>")
        parts.append(f"<p>{escape.escape(step.reason)}</p>")
        name = step.figure
        if name is not None and figures and name in figures and name not in shown:
            shown.add(name)
            parts.append(f"<figure>{figures[name]}</figure>")
        if step.equations:
            parts.append(f'<div class="equations">{page.html([step.equations])}</div>')
        parts.append("</section>")
    return "\n".join([*parts, f'<p class="source">{escape.escape(_source(derivation))}</p>'])


def html(derivation: Derivation, figures: Figures | None = None, style: str = "") -> str:
    """One page that fetches nothing; `style` is for the figures."""
    title = escape.escape(_title(derivation))
    return (
        '<!doctype html>\n<html lang="en"><head><meta charset="utf-8">'
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
math{font-size:1.08rem}figure{margin:1rem 0}figure svg{max-width:100%;height:auto}
.source{color:#5a6675;font-size:.9rem;margin-top:3rem}
@media (prefers-color-scheme:dark){body{color:#e4e9f0;background:#12161c}.source,h2 .notes{color:#9aa6b5}}
@media print{main{max-width:none;padding:0}section{break-inside:avoid-page}}
"""


def _title(derivation: Derivation) -> str:
    model = derivation.equations.symbols.model
    return f"{model.name}: {derivation.title}"


def _numbers(step: Step) -> str:
    """The notes' equation numbers, such as ` (3.20-3.27)`."""
    return f"  [notes {', '.join(f'({n})' for n in step.notes)}]" if step.notes else ""


def _source(derivation: Derivation) -> str:
    numbered = any(step.notes for step in derivation.steps)
    source = derivation.equations.symbols.model.source
    parts = [f"Equation numbers: {SOURCE}." if numbered else "", f"Robot: {source}." if source else ""]
    return " ".join(part for part in parts if part)


_TEX = {
    "\\": r"\textbackslash{}",
    **{c: "\\" + c for c in "&%$#_{}"},
    **{letter: f"$\\{name}$" for name, letter in GREEK.items()},
    **{chr(0x2080 + k): f"$_{k}$" for k in range(10)},
    "·": r"$\cdot$",
    "×": r"$\times$",
    "ᵀ": r"$^{T}$",
    "−": "$-$",
    "ḋ": r"$\dot d$",
    "–": "--",
}


def _tex(words: str) -> str:
    """Plain words in LaTeX; Greek letters, subscripts and signs become formulas."""
    return "".join(_TEX.get(c, c) for c in words)
