"""The verdict of `check` as a page: the answer with its marks, the reasons, and folded away what
would be right."""

from __future__ import annotations

import html
import re
import unicodedata
from typing import TYPE_CHECKING

from freebody.errors import listed
from freebody.expressions.nodes import Equation
from freebody.expressions.typesetting.mathml import mathml
from freebody.outputs.display import counted
from freebody_textbook.render import documents

if TYPE_CHECKING:
    from freebody_textbook.check.verdict import EquationVerdict, Mistake, Verdict

_MARKS = {True: ("right", "✓"), False: ("wrong", "✗")}
_CARETS = re.compile(r"^( *)(\^+) *$")

STYLE = """
.answer,.line{font:.95rem/1.7 ui-monospace,"DejaVu Sans Mono",monospace;overflow-wrap:anywhere;
white-space:pre-wrap;margin:.6rem 0;padding:0;list-style:none}
.answer li{display:flex;gap:.7em;border-left:.25rem solid #c9d0d8;padding:0 .6rem}
.answer .marks{flex:none;width:2em;white-space:nowrap;font-family:system-ui,sans-serif}
.answer a,h2 .right,h2 .wrong{text-decoration:none}
.answer .right{border-color:#2b7a3d}.answer .wrong{border-color:#b3261e}
.answer .marks a{display:inline-block;min-width:24px;min-height:24px}
h2 .right,.answer .right .marks a{color:#226633}h2 .wrong,.answer .wrong .marks a{color:#a3211a}
.line{padding:.2rem .6rem;border-left:.25rem solid #b3261e}
mark{background:#ffdad6;color:#5c0b07;text-decoration:underline wavy #b3261e .07em}
section ul{padding-left:1.2rem;max-width:44rem}li p{margin:.2rem 0}
.example{color:#4a5563}
@media screen and (prefers-color-scheme:dark){
.answer .right{border-color:#74cf8a}.answer .wrong,.line{border-color:#ff9a90}
h2 .right,.answer .right .marks a{color:#74cf8a}h2 .wrong,.answer .wrong .marks a{color:#ff9a90}
mark{background:#5c1d18;color:#ffdad6}.example{color:#aab4c2}}
@media print{.answer li,.line,section li{break-inside:avoid}.right-one:not([open]){display:none}}
"""
"""The style of what a page of a derivation does not have. Right and wrong differ in their mark, not
in colour alone."""


def verdict_page(verdict: Verdict) -> str:
    """A self-contained HTML page of a verdict."""
    right = sum(equation.equal for equation in verdict.equations)
    count = counted(len(verdict.equations), "equation")
    title = html.escape(f"{verdict.model}: {right} of {count} right")
    blocks = [f"<h1>{title}</h1>", _answer(verdict)]
    blocks += [_section(k, x) for k, x in enumerate(verdict.equations, 1)]
    blocks += _unjudged(verdict)
    return documents.page(title, "\n".join(blocks), STYLE)


def _answer(verdict: Verdict) -> str:
    """The answer line by line, with a mark for each of its equations that leads to the reasons."""
    rows = []
    for number, line in enumerate(verdict.answer.splitlines(), 1):
        here = [(k, x) for k, x in enumerate(verdict.equations, 1) if x.line == number]
        marks = " ".join(
            f'<a href="#equation-{k}" aria-label="{html.escape(x.name)} is {_MARKS[x.equal][0]}">'
            f"{_MARKS[x.equal][1]}</a>"
            for k, x in here
        )
        kind = f' class="{_MARKS[all(x.equal for _, x in here)][0]}"' if here else ""
        text = html.escape(unicodedata.normalize("NFC", line)) or " "
        rows.append(f'<li{kind}><span class="marks">{marks}</span><span>{text}</span></li>')
    return f'<h2>The answer</h2><ol class="answer">{"".join(rows)}</ol>'


def _section(number: int, equation: EquationVerdict) -> str:
    """HTML of what is said of an equation."""
    word, mark = _MARKS[equation.equal]
    name, title = html.escape(equation.name), html.escape(equation.title)
    where = f' <small class="notes">{html.escape(equation.where)}</small>' * bool(equation.where)
    said = f"{name} is right" if equation.equal else f"{name}, {title}, is not right"
    blocks = [f'<h2><span class="{word}">{mark}</span> {said}{where}</h2>']
    if equation.equal:
        blocks += [f"<p>{html.escape(equation.note)}</p>"] * bool(equation.note)
    else:
        blocks += [f"<p>{html.escape(cause)}</p>" for cause in equation.causes]
        found = "".join(f"<li>{_finding(x)}</li>" for x in equation.findings)
        blocks += [f"<ul>{found}</ul>"] * bool(found)
        example = equation.example_text
        blocks += [f'<p class="example">{html.escape(example)}</p>'] * bool(example)
        blocks.append(_right(equation))
    return f'<section id="equation-{number}">{"".join(blocks)}</section>'


def _finding(mistake: Mistake) -> str:
    """A mistake: the line with its place marked, and what is wrong there."""
    line, _, below = mistake.context.partition("\n")
    carets, shown = _CARETS.match(below), ""
    if carets:
        start, end = (_behind(line, column) for column in carets.span(2))
        parts = line[:start].lstrip(), line[start:end], line[end:]
        before, piece, behind = map(html.escape, parts)
        shown = f'<p class="line">{before}<mark>{piece}</mark>{behind}</p>'
    return f"<p>{html.escape(mistake.message)}</p>{shown}"


def _behind(line: str, columns: int) -> int:
    """The place in a line behind so many columns; dots above letters take none."""
    places = [k for k, c in enumerate(line) if not unicodedata.combining(c)]
    return places[columns] if columns < len(places) else len(line)


def _right(equation: EquationVerdict) -> str:
    """HTML of what would be right, folded away until it is asked for."""
    right = equation.right
    if right is None:
        return ""
    if isinstance(right, Equation):
        lines = documents.in_lines([[right]], "result")
    else:
        lines = f'<div class="equations result">{mathml(right)}</div>'
    return f'<details class="right-one"><summary>What would be right</summary>{lines}</details>'


def _unjudged(verdict: Verdict) -> list[str]:
    """HTML of what was not judged, and why."""
    told = []
    if verdict.unchecked:
        names = html.escape(listed(verdict.unchecked, 8))
        told.append(f"<li><p>{names}: no quantity of the robot has such a name.</p></li>")
    for row in verdict.unread:
        told.append(
            f"<li><p>{html.escape(row.where)}: {html.escape(row.reason)}.</p>"
            f'<p class="line">{html.escape(row.text)}</p></li>'
        )
    return [f"<section><h2>Not judged</h2><ul>{''.join(told)}</ul></section>"] if told else []
