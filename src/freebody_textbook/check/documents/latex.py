"""Reading LaTeX: whole documents, or single formulas."""

from __future__ import annotations

import re
from collections.abc import Iterator

from freebody.expressions.grammar.lexer import MATRICES
from freebody.expressions.grammar.source import Span
from freebody.expressions.grammar.words import spelt
from freebody_textbook.check.documents import plain
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    Blanks,
    DocumentForm,
    FormulaPiece,
    between,
    plain_characters,
)
from freebody_textbook.check.documents.macros import closing_braces

_DISPLAYS = (
    "equation", "align", "gather", "multline", "eqnarray", "flalign", "alignat", "displaymath",
    "math", "dmath", "IEEEeqnarray",
)  # fmt: skip
_WITH_COLUMNS = ("alignat", "IEEEeqnarray")
_COLUMNS = re.compile(r"\s{0,9}\{[^{}]{0,40}\}")
"""The columns behind the begin of some displays: how many, or how they are set."""
_COMMENT = re.compile(r"(?<!\\)(?:\\\\)*(%[^\n]*)")
_CONTINUED = re.compile(r"\n(?=[^\n=]*[^\s=][^\n=]*(?:\n|$))")
"""The end of a line that goes on in one without an equals sign."""
_DOCUMENT, _END = r"\begin{document}", r"\end{document}"

_GROUP = r"\{[^{}]{0,200}\}"
_NOTHING = re.compile(
    rf"\\(?:tag\*?|label|eqref|ref|cite|hspace\*?|vspace\*?|color|phantom|hphantom|vphantom)\s*{_GROUP}"
    r"|\{\}(?=\s*&)"
    r"|\\(?:notag|nonumber|limits|nolimits|allowbreak|strut|mathstrut|hfill|hline|centering"
    r"|thinspace|medspace|thickspace|enspace|quad|qquad)(?![A-Za-z])"
)
"""Commands that say nothing about the matter, with what they are given."""
_THEREFORE = re.compile(
    r"\\(?:therefore|Rightarrow|implies|Longrightarrow|rightarrow|iff|Leftrightarrow)(?![A-Za-z])"
)
"""The commands that stand between equations."""
_AROUND = re.compile(
    r"\\(?:boxed|fbox|underline|overline|ensuremath|displaystyle|underbrace|overbrace)(?![A-Za-z])\s*"
    rf"|\\(?:textcolor|colorbox)\s*{_GROUP}\s*"
)
"""Commands around a formula that is read without them; below an underbrace stand words."""
_TEXT = re.compile(rf"(?<![_^{{])\\(?:text|mbox|textrm|textit|intertext|mathrm)\s*({_GROUP})")
_HALF_BRACE = re.compile(r"\\left\s*\\?[.{](?=\s*(?:\\begin|$))|\\right\s*\.|\\left\s*\\lbrace")
_OPERATORS = tuple("+-*/^_=(")
_ENVIRONMENT = re.compile(r"\\(begin|end)\s*\{([A-Za-z]+)\*?\}|\\\\")
_BRACKETS = re.compile(
    r"\\(begin|end)\s*\{([A-Za-z]+)\*?\}|\\\\(?:\[[^][\n]{0,12}\])?(?P<next>(?=\s*[&+]))?|[][(){}&]"
)
_ARRAY = re.compile(r"\\(begin|end)\s*\{array\}(?:\s*\{[^{}]{0,40}\})?")


def read(text: str) -> AnswerDocument:
    """Document of a LaTeX text: formulas between dollar signs and in displays; without any, all of
    it is read as plain text."""
    written = plain_characters(text)
    whole = Blanks(written)
    whole.replace(_COMMENT, group=1)
    start = str(whole).find(_DOCUMENT)
    if start >= 0:
        whole.put(0, start + len(_DOCUMENT))
    said = str(whole)
    found = formulas(said)
    if not found:
        document = plain.read(text)
        lines = _CONTINUED.sub(" ", str(whole))
        return AnswerDocument(
            written, lines, document.pieces, document.prose, told=True, strict=True
        )
    whole.only(found)
    pieces = clean(whole, found)
    return AnswerDocument(written, str(whole), tuple(pieces), said=said, told=True)


def formulas(text: str) -> list[Span]:
    """Spans of displays and of formulas between dollar signs, in order, without nesting."""
    found: list[Span] = []
    for name in _DISPLAYS:
        for star in ("", "*"):
            opening, closing = f"\\begin{{{name}{star}}}", f"\\end{{{name}{star}}}"
            for start, end in between(text, opening, closing):
                columns = _COLUMNS.match(text, start, end) if name in _WITH_COLUMNS else None
                found.append((columns.end() if columns else start, end))
    found += between(text, "\\[", "\\]") + between(text, "\\(", "\\)")
    outside = Blanks(text.replace("\\$", "  "))
    for start, end in found:
        outside.put(start, end)
    rest = str(outside)
    displays = between(rest, "$$", "$$")
    found += displays
    for start, end in displays:
        outside.put(start - 2, end + 2)
    found += [
        (start, end)
        for start, end in between(str(outside), "$", "$")
        if "\n\n" not in text[start:end]
    ]
    return _outermost(sorted(found))


def _outermost(spans: list[Span]) -> list[Span]:
    kept: list[Span] = []
    for start, end in spans:
        if not kept or start >= kept[-1][1]:
            kept.append((start, end))
    return kept


def clean(whole: Blanks, found: list[Span]) -> list[FormulaPiece]:
    """Blank out LaTeX markup without meaning within formulas of `whole`; returns a piece for each
    equation."""
    for start, end in found:
        for k in range(start, end):  # in a formula the end of a line is none
            if whole.characters[k] == "\n":
                whole.characters[k] = " "
    whole.replace(_NOTHING)
    whole.replace(_HALF_BRACE)
    whole.replace(_THEREFORE, ",")
    _take_words(whole)
    _open_boxes(whole)
    _open_arrays(whole)
    text = str(whole)
    for span in found:
        _join_rows(whole, text, span)
    text = str(whole)
    pieces: list[FormulaPiece] = []
    for span in found:
        pieces += (FormulaPiece(*row, lenient=True) for row in rows(text, span))
    return pieces


def _open_boxes(whole: Blanks) -> None:
    """Blank out boxes and outer braces around formulas."""
    text = str(whole)
    braces = closing_braces(text)
    for match in _AROUND.finditer(text):
        close = braces.get(match.end())
        is_mark = "line" in match[0] and close is not None and spelt(text[match.end() + 1 : close])
        if is_mark:
            continue
        whole.put(*match.span())
        if close is None:
            continue
        whole.put(match.end(), match.end() + 1)
        whole.put(close, close + 1)
        below = re.compile(r"\s*[_^]\s*").match(text, close + 1)
        if "brace" in match[0] and below:
            end = braces.get(below.end(), below.end())
            whole.put(close, end + 1)


def _open_arrays(whole: Blanks) -> None:
    """Blank out the begin and end of arrays of equations."""
    text = str(whole)
    opened: list[re.Match[str]] = []
    for match in _ARRAY.finditer(text):
        if match[1] == "begin":
            opened.append(match)
        elif opened:
            begin = opened.pop()
            if "=" in text[begin.end() : match.start()]:
                whole.put(*begin.span())
                whole.put(*match.span())


def _join_rows(whole: Blanks, text: str, span: Span) -> None:
    """Blank out row ends within brackets and the alignment of continued rows, except in matrices;
    between square brackets a continued row begins with & or +."""
    opened: list[str] = []
    for match in _BRACKETS.finditer(text, *span):
        mark, aligned = match[0][0], match["next"] is not None
        if match[1]:
            if match[2] in MATRICES and match[1] == "begin":
                opened.append("")
            elif match[2] in MATRICES and opened:
                opened.pop()
        elif mark in "([{":
            opened.append(mark)
        elif mark in ")]}":
            del opened[-1:]
        elif opened and opened[-1] and (mark == "&" or opened[-1] == "(" or aligned):
            whole.put(*match.span())


def _take_words(whole: Blanks) -> None:
    """Replace words set as text by a comma, which ends a line; between operators they stay, as they
    stand for a term."""
    text = str(whole)
    for match in _TEXT.finditer(text):
        words = match[1][1:-1].strip()
        before = text[max(0, match.start() - 80) : match.start()].rstrip(" &~")[-1:]
        behind = text[match.end() : match.end() + 80].lstrip(" &~")[:1]
        is_term = before in _OPERATORS or behind in _OPERATORS
        if len(words) > 1 and ("mathrm" not in match[0] or " " in words) and not is_term:
            whole.put(*match.span(), ",")


def rows(text: str, span: Span) -> Iterator[Span]:
    """A display split into rows, each starting where a row has an equals sign; rows of matrices are
    not split."""
    depth, start = 0, span[0]
    for match in _ENVIRONMENT.finditer(text, *span):
        if match[1]:
            depth += (1 if match[1] == "begin" else -1) * (match[2] in MATRICES)
        elif depth <= 0:
            end = text.find("\\\\", match.end(), span[1])
            following = text[match.end() : end if end >= 0 else span[1]]
            if "=" in following and following.lstrip(" &")[:1] not in ("=", "+", "-"):
                yield start, match.end()
                start = match.end()
    yield start, span[1]


FORM = DocumentForm("latex", "LaTeX, a document or formulas", (".tex", ".latex", ".ltx"), read)
