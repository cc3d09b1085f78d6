"""Reading Python code as students write it with SymPy: assignments are equations. The code is
parsed as text, never executed."""

from __future__ import annotations

import re
from collections.abc import Iterator

from freebody.expressions.grammar.source import Span
from freebody.expressions.grammar.tables.characters import FILL
from freebody_textbook.check.documents.answer_document import (
    AnswerDocument,
    Blanks,
    DocumentForm,
    FormulaPiece,
    plain_characters,
)

_ASSIGNED = re.compile(
    r"[ \t]{0,12}([A-Za-z_]\w{0,60}\x1f*)[ \t]*(?::[^=\n]{0,40})?([-+*/]{0,2}=)(?!=)"
)
_DECLARED = re.compile(
    r"\b(?:symbols|Symbol|dynamicsymbols|Function|var|lambdify|import|ReferenceFrame|Point)\b"
)
_EQUATION = re.compile(r"(?<![\w.])(?:\w{1,9}\.)?Eq\(\s*([A-Za-z_]\w{0,60})\s*(,)")
_QUESTION = re.compile("==")
_STRINGS = re.compile(r"\"[^\"\n]*\"|'[^'\n]*'")
_MODULES = re.compile(r"(?<![\w.])(?:sp|sympy|sm|smp|np|numpy|math|mp|me)\.(?=[A-Za-z])")
_WRAPPERS = re.compile(
    r"(?<![\w.])(?:simplify|trigsimp|expand|factor|expand_trig|together|cancel|nsimplify)(?=\s*\()"
)
_RATIONAL = re.compile(r"(?<![\w.])(?:Rational|S)\(\s*(\d{1,9})\s*(?:,\s*(\d{1,9})\s*)?\)")
_RATE = re.compile(r"(?<![\w.])([A-Za-z]\w{0,30})\x1f*\.diff\(\s*t\s*(?:,\s*([12])\s*|,\s*t\s*)?\)")
_OF_METHODS = (".diff(", ".jacobian(")
_ENTRY = re.compile(r"(?<![\w.\])])([A-Za-z]+)\[\s?([0-7])\s?(?:(?:,|\]\[)\s?([0-7])\s?)?\]")
"""M[0, 1], tau[0], counted from 0: M12, tau1."""
_FUNCTION = re.compile(
    r"^([ \t]*)(def[ \t]+([MHCG]|[A-Za-z]{1,4}_?\d{1,2})\([ \t]*(?:q|th|theta)\d?\b[^\n]*?:)"
    r"(?:[ \t]*|[ \t]*(?:\n(?:\1[ \t]+\S[^\n]*|[ \t]*(?=\n)))*?\n[ \t]*)"
    r"(return)[ \t](?![ \t]*\3[ \t]*$)",
    re.M,
)
"""A function of the coordinates that has a quantity's name, and what it returns."""
_SAME = (
    r"(?:\w+\.)?(?:simplify|trigsimp|expand|factor|expand_trig)\({0}\)"
    r"|{0}\.(?:simplify|expand|doit|trigsimp)\(\)"
)
"""The calls that do not change a value."""
_METHODS = re.compile(r"\.(?:simplify|expand|doit|trigsimp)\(\s*\)")


def clean(whole: Blanks, said: Blanks, span: Span) -> list[FormulaPiece]:
    """Formula pieces for the assignments in code; everything else is blanked out in `whole`, and in
    `said` everything that states nothing."""
    pieces = []
    kept: list[Span] = []
    for text in (whole, said):
        text.replace(_ENTRY, _counted_from_one, span)
    for match in _FUNCTION.finditer(whole.inside(span)):
        (head, behind), (start, end) = match.span(2), match.span(4)
        for text in (whole, said):
            text.put(span[0] + head, span[0] + behind)
            text.put(span[0] + start, span[0] + end + 1, match[3].ljust(end - start, FILL) + "=")
    code = whole.inside(span)
    stated: list[Span] = []
    for a, b in _statements(code):
        text, start, end = code[a:b], span[0] + a, span[0] + b
        assigned = _ASSIGNED.match(text)
        if not text.strip() or _DECLARED.search(text):
            continue
        behind = "".join(text[assigned.end() :].split()) if assigned else ""
        if assigned and re.fullmatch(_SAME.format(assigned[1].rstrip(FILL)), behind):
            continue  # tau = simplify(tau)
        stated.append((start, end))
        if assigned is None:
            continue
        kept.append((start, end))
        pieces.append(FormulaPiece(start, end, lenient=True))
        whole.put(start + assigned.end(1), start + assigned.start(2))
    whole.only(kept, span)
    said.only(stated, span)
    for start, end in stated:
        _statement_alone(said, start, end)
    for start, end in kept:
        _plain(whole, start, end)
    return pieces


def _counted_from_one(match: re.Match[str]) -> str:
    """The name of an array entry with 1-based indices, converted from the code's 0-based ones."""
    name = match[1] + "".join(str(int(k) + 1) for k in match.groups()[1:] if k)
    return name.ljust(len(match[0]), FILL)


def _statement_alone(said: Blanks, start: int, end: int) -> None:
    """Blank out arguments in brackets, strings and comparisons a == b of a statement; Eq(a, b)
    becomes an equation a = b."""
    text = said.inside((start, end))
    equations = list(_EQUATION.finditer(text))
    said.replace(_EQUATION, "=", (start, end), group=2)
    apart = {at for match in equations for at in range(*match.span())}
    depth = 0
    for at, c in enumerate(text):
        depth -= c in ")]}"
        inside = depth > 0 and at not in apart
        depth += c in "([{"
        if inside:
            said.put(start + at, start + at + 1)
    if not text.lstrip().startswith("assert"):
        said.replace(_QUESTION, "", (start, end))
    for match in _STRINGS.finditer(text):
        said.put(start + match.start(), start + match.end())


def _plain(whole: Blanks, start: int, end: int) -> None:
    """Replace SymPy's functions by formulas."""
    span = (start, end)
    for pattern in (_MODULES, _WRAPPERS, _METHODS):
        whole.replace(pattern, "", span)
    whole.replace(_RATIONAL, lambda x: f"({x[1]}/{x[2]})" if x[2] else x[1], span)
    whole.replace(_RATE, lambda x: "d" * (1 + ("," in x[0] and x[2] != "1")) + x[1], span)
    _functions_for_methods(whole, start, end)


def _functions_for_methods(whole: Blanks, start: int, end: int) -> None:
    """Replace x.diff(y) by diff(x, y), and jacobian likewise."""
    for method in _OF_METHODS:
        while True:
            inside = whole.inside((start, end))
            at = inside.find(method)
            if at < 0:
                break
            first, behind = _begun(inside, at), at + len(method)
            whole.put(start + first, start + behind, f"{method[1:]}{inside[first:at]},")


def _begun(text: str, end: int) -> int:
    """The start of the name or call that ends at a position."""
    at = end
    while at and text[at - 1] == FILL:
        at -= 1
    if at and text[at - 1] == ")":
        depth = 0
        while at:
            at -= 1
            depth += {")": 1, "(": -1}.get(text[at], 0)
            if depth == 0:
                break
    while at and (text[at - 1].isalnum() or text[at - 1] in "_" + FILL):
        at -= 1
    return at


def _statements(code: str) -> Iterator[Span]:
    """Spans of a code's statements, without comments; lines within brackets are joined."""
    depth, start, at = 0, 0, 0
    while at < len(code):
        c = code[at]
        if c in "\"'":
            match = _STRINGS.match(code, at)
            at = match.end() - 1 if match else at
        elif c in "([{":
            depth += 1
        elif c in ")]}":
            depth = max(0, depth - 1)
        elif c == "#":
            stop = code.find("\n", at)
            stop = len(code) if stop < 0 else stop
            if depth == 0:
                yield start, at
                start = stop + 1
            at = stop
        elif c in "\n;" and depth == 0:
            yield start, at
            start = at + 1
        at += 1
    yield start, len(code)


def read(text: str) -> AnswerDocument:
    """Document of a text that consists of code."""
    written = plain_characters(text)
    whole, said = Blanks(written), Blanks(written)
    pieces = clean(whole, said, (0, len(written)))
    return AnswerDocument(
        written, str(whole), tuple(pieces), said=str(said), told=True, assigns=True
    )


FORM = DocumentForm("python", "Python code with SymPy", (".py",), read)
