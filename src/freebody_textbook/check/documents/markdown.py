"""Reading Markdown: formulas between dollar signs, in fences, in tables and on lines of their
own."""

from __future__ import annotations

import re

from freebody.expressions.grammar.source import Span
from freebody_textbook.check.documents import latex, plain, python_code
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    Blanks,
    DocumentForm,
    FormulaPiece,
    between,
    plain_characters,
)

_FENCE = re.compile(r"^[ ]{0,3}(```+|~~~+)[ ]*(\w*)[^\n]*$", re.MULTILINE)
_HEADING = re.compile(
    r"^[ \t]*#{1,6}[ \t]+(?!(?:[^=:\n]{1,40}:[ \t]*)?(?:\$|[^\s=]{1,20}[ \t]?=))[^\n]*",
    re.MULTILINE,
)
"""A heading of words; one that is an equation states it."""
_MARKS = re.compile(
    rf"{_HEADING.pattern}|^[ \t]*(?:#{{1,6}}[ \t]|\|[ \t:|-]+$)"
    r"|^[ \t]*(?:>[ \t]?|[-*+][ \t]+(?:\[[ xX]\][ \t])?|\d{1,3}[.)][ \t]+|\|)"
    r"|(?<!\S)\*\*(?=\S)|(?<=\S)\*\*(?!\S)|(?<=\s)_(?=\w)|\||`",
    re.MULTILINE,
)
"""Marks of headings, lists, quotations, tables and emphasis; a heading with its words. A power
lc2**2 is no emphasis."""
_TABLE_ROW = re.compile(r"[ \t]{0,3}\|(?P<cells>[^\n]{1,400})\|[ \t]*$")
_TABLE_RULE = re.compile(r"[ \t]{0,3}\|?(?:[ \t]*:?-+:?[ \t]*\|)+(?:[ \t]*:?-+:?)?[ \t]*")
_CELL_NAME = re.compile(
    r"\s*\$?\s?(?P<name>(?=[^\s=]*[\d₀-₉\\Α-ω])(?:\\[A-Za-z]+|[A-Za-zΑ-ω])[^\s=\[\]()|$,]{0,24})"
    r"\s?\$?\s*(?:[\[(/]\s?\$?(?P<unit>[^\[\]()|=$]{1,20})\$?\s?[\])]?)?\s*$"
)
"""A symbol, perhaps with a unit."""
_CELL_NUMBER = re.compile(
    r"\s*\$?(?P<number>[-+−]?(?:\d{1,20}(?:\.\d{0,20})?|\.\d{1,20}))\s?(?P<unit>[^|=]{0,20}?)\$?\s*$"
)
_ROW = re.compile(r"[ \t]*\|")
"""The begin of a table's row, whose cells are separate."""


def read(text: str) -> AnswerDocument:
    """Document of a Markdown text: formulas are LaTeX, fences named python are code, other fences
    and lines are plain text."""
    written = plain_characters(_with_tables(text))
    whole, said, pieces, prose = parted(written)
    return AnswerDocument(
        written, str(whole), tuple(pieces), tuple(prose), said=str(said), told=True
    )


def parted(written: str) -> tuple[Blanks, Blanks, list[FormulaPiece], list[Span]]:
    """A Markdown text split: (text with only formulas, text with only what states something,
    formula pieces, spans of prose)."""
    whole = Blanks(written)
    for start, end in between(written, "<!--", "-->"):
        whole.put(start - 4, end + 3)
    text = str(whole)
    said = Blanks(text)
    said.replace(_HEADING)
    pieces: list[FormulaPiece] = []
    prose: list[Span] = []
    displays: list[Span] = []
    at = 0
    for start, end, name, inside in _fences(text):
        displays += _lines(whole, text, (at, start), pieces, prose)
        whole.put(start, inside[0])
        whole.put(inside[1], end)
        if name in ("math", "latex", "tex"):
            displays.append(inside)
        elif name in ("python", "py", "ipython"):
            pieces += python_code.clean(whole, said, inside)
        else:
            prose += plain.lines(text, *inside)
            pieces.append(FormulaPiece(*inside, lenient=True))
        at = end
    displays += _lines(whole, text, (at, len(text)), pieces, prose)
    pieces += latex.clean(whole, displays)
    return whole, said, sorted(pieces, key=lambda piece: piece.start), prose


def _fences(text: str) -> list[tuple[int, int, str, Span]]:
    """The start, end, language and inner span of each fenced block."""
    found, opened = [], None
    for match in _FENCE.finditer(text):
        if opened is None:
            opened = match
        elif match[1][:3] == opened[1][:3]:
            inside = (min(opened.end() + 1, match.start()), match.start())
            found.append((opened.start(), match.end(), opened[2].lower(), inside))
            opened = None
    return found


def _lines(
    whole: Blanks, text: str, span: Span, pieces: list[FormulaPiece], prose: list[Span]
) -> list[Span]:
    """Formula spans in a stretch of Markdown: between dollar signs and in displays; a paragraph
    without these that may contain formulas is added to `pieces` as one piece."""
    start = span[0]
    formulas = [(start + a, start + b) for a, b in latex.formulas(text[slice(*span)])]
    rest = Blanks(text[slice(*span)])
    for a, b in formulas:
        rest.put(a - start, b - start)
    for match in _MARKS.finditer(str(rest)):
        cell = match[0] == "|" and _ROW.match(text, text.rfind("\n", 0, start + match.start()) + 1)
        whole.put(start + match.start(), start + match.end(), ";" if cell else "")
    paragraph: list[Span] = []
    k = 0
    for line in [*plain.lines(text, *span), (span[1], span[1])]:
        while k < len(formulas) and formulas[k][1] <= line[0]:
            k += 1
        holds = k < len(formulas) and formulas[k][0] < line[1]
        if paragraph and (holds or not text[slice(*line)].strip()):
            pieces.append(FormulaPiece(paragraph[0][0], paragraph[-1][1], lenient=True))
            paragraph = []
        if holds:
            k = _keep(whole, line, formulas, k)
        elif text[slice(*line)].strip():
            prose.append(line)
            paragraph.append(line)
    return formulas


def _keep(whole: Blanks, line: Span, formulas: list[Span], k: int) -> int:
    """Blank out a line except for its formulas, starting from the k-th; returns the index of the
    line's last formula."""
    at = line[0]
    while k < len(formulas) and formulas[k][0] < line[1]:
        start, end = formulas[k]
        whole.put(at, max(at, start))
        at = max(at, end)
        if end > line[1]:
            return k
        k += 1
    whole.put(at, max(at, line[1]))
    return k


def _with_tables(text: str) -> str:
    """A text with its numeric tables converted to equations, one line per row: below the head θ1
    [°] | G2 [N m] the row 30 | 3.05 becomes θ1 = 30 °, G2 = 3.05 N m; G2 | 3.05 N m becomes G2 =
    3.05 N m."""
    lines = text.split("\n")
    for k in range(1, len(lines)):
        if _TABLE_RULE.fullmatch(lines[k]) and (head := _cells(lines[k - 1])):
            _read_table(lines, k, head)
    return "\n".join(lines)


def _read_table(lines: list[str], rule: int, head: list[str]) -> None:
    """Replace the table rows below a rule by equations."""
    names = [_CELL_NAME.match(cell) for cell in head]
    found: dict[int, str] = {}
    for k in range(rule + 1, len(lines)):
        cells = _cells(lines[k])
        if not cells or _TABLE_RULE.fullmatch(lines[k]):
            break
        pairs = list(zip(names, cells, strict=False))
        own = _CELL_NAME.match(cells[0])
        if not any(names) and own and len(cells) == 2:
            pairs = [(own, cells[1])]
        told = [(name, _CELL_NUMBER.match(cell)) for name, cell in pairs if name]
        if told and all(number for _, number in told):
            found[k] = ", ".join(_cell_equation(*pair) for pair in told)
    for k, line in found.items():
        lines[k] = line
    if found:
        lines[rule - 1] = lines[rule] = ""


def _cells(line: str) -> list[str]:
    row = _TABLE_ROW.fullmatch(line)
    return row["cells"].split("|") if row else []


def _cell_equation(name: re.Match[str], number: re.Match[str] | None) -> str:
    assert number is not None
    unit = number["unit"] or name["unit"] or ""
    return f"{name['name']} = {number['number']} {unit}".rstrip()


FORM = DocumentForm(
    "markdown", "Markdown with formulas between dollar signs", (".md", ".markdown", ".mdown"), read
)
