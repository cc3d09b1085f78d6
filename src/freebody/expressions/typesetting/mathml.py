"""Expressions as MathML, for a page that fetches no script."""

from __future__ import annotations

import re
from fractions import Fraction
from xml.sax.saxutils import escape

from freebody.expressions.nodes import Expression, Symbol
from freebody.expressions.typesetting.typesetter import BREAK, Notation, Typesetter, is_call

NAMESPACE = 'xmlns="http://www.w3.org/1998/Math/MathML"'
_OPEN, _CLOSE = '<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>'
_THIN, _APPLY, _TIMES = '<mspace width=".17em"/>', "<mo>\u2061</mo>", "<mo>\u2062</mo>"
_DOTS = ("", "˙", "¨")
_TAGS = re.compile(r"<[^>]*>|&[^;]*;|[˙¨\u2061\u2062]|\ue000[a-z]*\ue001|\ue002")
_LOW = re.compile(
    "<msub(?:sup)?>(?:<mi[^>]*>[^<]*</mi>|<mover.*?</mover>)"
    "(<mrow>.*?</mrow>|<mn>[^<]*</mn>|<mi>[^<]*</mi>)"
)
_MARKS = re.compile("\ue000([a-z]*)\ue001|\ue002")
"""Marks of where a term with a source begins and ends, until it is known where lines end."""
_BOLD = str.maketrans(
    {chr(0x41 + k): chr(0x1D400 + k) for k in range(26)}
    | {chr(0x61 + k): chr(0x1D41A + k) for k in range(26)}
    | {chr(0x391 + k): chr(0x1D6A8 + k) for k in range(25)}
    | {chr(0x3B1 + k): chr(0x1D736 + k) for k in range(25)}
)
"""Bold letters as in LaTeX: upright, but small Greek letters in italics. Browsers know no bold
`mathvariant`."""


def lean(page: str) -> str:
    """The text of a page without what each of its formulas would need to stand alone."""
    return page.replace(f" {NAMESPACE}", "")


def mathml(node: Expression, display: bool = True) -> str:
    """A `<math>` element, set as a line of its own unless `display` is false."""
    kind = ' display="block"' if display else ""
    return f"<math {NAMESPACE}{kind}>{MATHML.line(node)}</math>"


def _width(string: str) -> float:
    """The approximate width of a MathML string in letters; scripts are smaller, tags take no
    room."""
    full = len(_TAGS.sub("", string))
    scripts = sum(len(_TAGS.sub("", low)) for low in _LOW.findall(string))
    return 0.85 * (full - 0.4 * scripts) + 0.8 * string.count('form="infix"')


def _in_elements(lines: list[str]) -> list[str]:
    """Lines in which each term with a source is an element of the source's class; a term broken
    over lines is one element in each."""
    made, source = [], ""
    for line in lines:
        text = _opened(source) if source else ""
        for piece in re.split("(\ue000[a-z]*\ue001|\ue002)", line):
            mark = _MARKS.fullmatch(piece)
            if mark is None:
                text += piece
                continue
            source = mark[1] or ""
            text += _opened(source) if source else "</mrow>"
        made.append(_SIGN.sub(_short, text) + "</mrow>" * bool(source))
    return made


_SIGN = re.compile('(^|<mrow class="[^"]*">)?<mo form="infix">')


def _short(sign: re.Match[str]) -> str:
    """The opening tag of a sign, without the attribute that only a sign at the start of a line
    needs."""
    return "<mo>" if sign[1] is None else sign[0]


def _opened(source: str) -> str:
    return f'<mrow class="term-{source}">'


def _digits(digits: str) -> str:
    return f"<mn>{digits.replace('-', '−')}</mn>"


def _ratio(value: Fraction) -> str:
    above, below = map(_digits, (str(value.numerator), str(value.denominator)))
    return f'<mstyle displaystyle="false"><mfrac>{above}{below}</mfrac></mstyle>'


def _symbol(node: Symbol, high: str) -> str:
    upright = ' mathvariant="normal"' if len(node.letter) > 1 else ""
    shown = node.letter.translate(_BOLD) if node.bold else node.letter
    letter = f"<mi{upright}>{escape(shown)}</mi>"
    if node.dots:
        letter = f'<mover accent="true">{letter}<mo>{_DOTS[node.dots]}</mo></mover>'
    low = _low(node.low) if node.low else ""
    high = high or (f"<mi>{escape(node.high)}</mi>" if node.high else "")
    scripts = "sub" * bool(low) + "sup" * bool(high)
    return f"<m{scripts}>{letter}{low}{high}</m{scripts}>" if scripts else letter


def _low(parts: tuple[str, ...]) -> str:
    """A subscript in MathML: digits with their commas as numbers, letters in italics, words
    upright; in an <mrow> where there are several."""
    runs = re.findall(r"[\d,]+|[^\W\d_]{3,}|.", ",".join(parts))
    elements = [f"<mn>{x}</mn>" if x[0] in ",0123456789" else f"<mi>{escape(x)}</mi>" for x in runs]
    return elements[0] if len(elements) == 1 else f"<mrow>{''.join(elements)}</mrow>"


MATHML = Typesetter(
    Notation(
        digits=_digits,
        ratio=_ratio,
        symbol=_symbol,
        exponent=lambda exponent: _digits(str(exponent)),
        gap=lambda before, after: _THIN if is_call(before) or is_call(after) else _TIMES,
        function="<mi>{}</mi>".format,
        words=lambda text: f"<mtext>{escape(text)}</mtext>",
        sourced=lambda source, term: f"\ue000{source}\ue001{term}\ue002",
        finished=_in_elements,
        plus=f'{BREAK}<mo form="infix">+</mo>',
        minus=f'{BREAK}<mo form="infix">−</mo>',
        lead='<mo form="prefix">−</mo>',
        brackets=f"{_OPEN}{{}}{_CLOSE}",
        tall_brackets="<mo>(</mo>{}<mo>)</mo>",
        cross="<mo>×</mo>",
        dot="<mo>·</mo>",
        equals="<mo>=</mo>",
        comma="<mo>,</mo>",
        colon='<mo lspace="0">:</mo><mspace width=".4em"/>',
        tenfold="<mo>·</mo>",
        differentials=('<mi mathvariant="normal">d</mi>', "<mo>∂</mo>"),
        transposed="<mi>T</mi>",
        inverse_transposed="<mrow><mo>−</mo><mi>T</mi></mrow>",
        space="",
        raised="<msup>{}{}</msup>",
        group="<mrow>{}</mrow>",
        line="<mrow>{}</mrow>",
        width=_width,
        applied='{}<mo rspace=".17em">\u2061</mo>{}',
        bracketed=f"{{}}{_APPLY}{_OPEN}{{}}{_CLOSE}",
        norm="<mrow><mo>|</mo>{}<mo>|</mo></mrow>",
        root="<msqrt>{}</msqrt>",
        fraction="<mfrac><mrow>{}</mrow><mrow>{}</mrow></mfrac>",
        operand="<mrow><mo>(</mo>{}<mo>)</mo></mrow>",
        matrix=(
            "<mrow><mo>[</mo><mtable><mtr><mtd>{}</mtd></mtr></mtable><mo>]</mo></mrow>",
            "</mtd></mtr><mtr><mtd>",
            "</mtd><mtd>",
        ),
    )
)
"""The inside of a `<math>` element."""
