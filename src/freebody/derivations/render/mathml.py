"""Expressions as MathML, for a page that fetches no script."""

from __future__ import annotations

import re
from fractions import Fraction
from xml.sax.saxutils import escape

from freebody.derivations.expressions.expression import Expression, Quotient, Symbol, nodes
from freebody.derivations.render.lines import broken
from freebody.derivations.render.typesetter import ATOM, BREAK, Typesetter, is_call, precedence

_OPEN, _CLOSE = '<mo stretchy="false">(</mo>', '<mo stretchy="false">)</mo>'
_THIN, _APPLY, _TIMES = '<mspace width="0.17em"/>', "<mo>&#x2061;</mo>", "<mo>&#x2062;</mo>"
_DOTS = ("", "˙", "¨")
_TAGS = re.compile(r"<[^>]*>|&[^;]*;|[˙¨]")


def mathml(node: Expression, display: bool = True) -> str:
    """A `<math>` element, set as a line of its own unless `display` is false."""
    kind = ' display="block"' if display else ""
    return f'<math xmlns="http://www.w3.org/1998/Math/MathML"{kind}>{row(node)}</math>'


def row(node: Expression) -> str:
    """The inside of a `<math>` element."""
    return f"<mrow>{_SETTER.whole(node)}</mrow>"


def broken_rows(node: Expression, room: float) -> list[str]:
    """The same in lines of about `room` letters, broken before signs, in brackets only where it
    must be."""
    pieces: list[str] = []
    for piece in _SETTER(node).split(BREAK):
        # a break inside an element, such as a root or an exponent, is none
        if pieces and _opened(pieces[-1]):
            pieces[-1] += piece
        else:
            pieces.append(piece)
    return [f"<mrow>{line}</mrow>" for line in broken(BREAK.join(pieces), room, _width)]


def _opened(string: str) -> bool:
    """Whether an element that begins here does not end here."""
    return len(re.findall(r"<[a-z]", string)) - string.count("/>") > string.count("</")


def _width(string: str) -> float:
    """About how wide it is, in letters; scripts are smaller, elements take no room."""
    full = len(_TAGS.sub("", string))
    scripts = sum(
        len(_TAGS.sub("", s)) for s in re.findall(r"(?:</mi>|</mover>)<mrow>(.*?)</mrow>", string)
    )
    return 0.85 * (full - 0.4 * scripts) + 0.8 * string.count('form="infix"')


class _MathML(Typesetter):
    plus, minus = (f'{BREAK}<mo form="infix">{sign}</mo>' for sign in "+−")
    lead, brackets, space = "<mo>−</mo>", (_OPEN, _CLOSE), ""
    cross, dot, equals, comma, tenfold = (f"<mo>{sign}</mo>" for sign in "×·=,·")
    differentials = '<mi mathvariant="normal">d</mi>', "<mo>∂</mo>"
    transposed, inverse_transposed = "<mi>T</mi>", "<mrow><mo>−</mo><mi>T</mi></mrow>"

    def digits(self, digits: str) -> str:
        return f"<mn>{digits.replace('-', '−')}</mn>"

    def ratio(self, value: Fraction) -> str:
        above, below = map(self.digits, (str(value.numerator), str(value.denominator)))
        return f'<mstyle displaystyle="false"><mfrac>{above}{below}</mfrac></mstyle>'

    def symbol(self, node: Symbol, high: str = "") -> str:
        bold = ' mathvariant="bold" style="font-weight:bold;font-style:normal"' * node.bold
        upright = ' mathvariant="normal"' if len(node.letter) > 1 and not bold else bold
        letter = f"<mi{upright}>{escape(node.letter)}</mi>"
        if node.dots:
            letter = f'<mover accent="true">{letter}<mo>{_DOTS[node.dots]}</mo></mover>'
        low = self.group(_low(node.low)) if node.low else ""
        high = high or (f"<mi>{escape(node.high)}</mi>" if node.high else "")
        if low and high:
            return f"<msubsup>{letter}{low}{high}</msubsup>"
        return f"<msub>{letter}{low}</msub>" if low else self.raised(letter, high)

    def high(self, exponent: int) -> str:
        return self.digits(str(exponent))

    def raised(self, base: str, high: str) -> str:
        return f"<msup>{base}{high}</msup>" if high else base

    def base(self, node: Expression) -> str:
        if precedence(node) < ATOM and any(isinstance(part, Quotient) for part in nodes(node)):
            return f"<mo>(</mo>{self(node)}<mo>)</mo>"  # as tall as it
        return self(node, ATOM)

    def group(self, string: str) -> str:
        return f"<mrow>{string}</mrow>"

    def gap(self, before: Expression, after: Expression) -> str:
        return _THIN if is_call(before) or is_call(after) else _TIMES

    def function(self, name: str) -> str:
        return f"<mi>{name}</mi>"

    def applied(self, name: str, argument: str, bracket: bool) -> str:
        argument = _OPEN + argument + _CLOSE if bracket else _THIN + argument
        return self.group(name + _APPLY + argument)

    def norm(self, argument: str) -> str:
        return f"<mrow><mo>|</mo>{argument}<mo>|</mo></mrow>"

    def fraction(self, above: str, below: str) -> str:
        return f"<mfrac>{self.group(above)}{self.group(below)}</mfrac>"

    def operand(self, string: str) -> str:
        return f"<mrow><mo>(</mo>{string}<mo>)</mo></mrow>"

    def array(self, rows: list[list[str]]) -> str:
        cells = "".join(f"<mtr>{''.join(f'<mtd>{x}</mtd>' for x in row)}</mtr>" for row in rows)
        return f"<mrow><mo>[</mo><mtable>{cells}</mtable><mo>]</mo></mrow>"

    def words(self, text: str) -> str:
        return f"<mtext>{escape(text)}</mtext>"


def _low(parts: tuple[str, ...]) -> str:
    return "<mo>,</mo>".join(map(_letters, parts))


def _letters(part: str) -> str:
    """Digits as numbers, letters in italics, words upright."""
    runs = re.findall(r"\d+|[^\W\d_]{3,}|.", part)
    return "".join(
        f"<mn>{run}</mn>" if run.isdigit() else f"<mi>{escape(run)}</mi>" for run in runs
    )


_SETTER = _MathML()
