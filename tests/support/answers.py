"""Answers as users write them: right ones in many notations and forms, and wrong ones with the
mistake on record."""

from __future__ import annotations

import random
import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from fractions import Fraction
from functools import lru_cache
from itertools import product as words_of

import freebody as fb
from freebody.algorithms.kinematics import jacobian
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.grammar.lexer import tokens
from freebody.expressions.printed_names import sym
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.asked.joints import polynomial
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.reading import AnswerParser
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.verdict import Verdict
from freebody_textbook.equations.equations import Equations

WORDS = ["".join(word) for n in (1, 2, 3, 4) for word in words_of("RP", repeat=n)]


@lru_cache(maxsize=64)
def model(word: str) -> tuple[fb.Model, Equations]:
    """A planar arm and its equations."""
    arm = fb.planar(word)
    return arm, fb.equations(arm)


@lru_cache(maxsize=64)
def quantities(word: str) -> list[tuple[str, Expression]]:
    """Name and right answer, as it prints, of what may be asked of an arm; no zeros."""
    _, e = model(word)
    n = range(len(word))
    found = [("T", e.T), ("V", e.V)]
    for i in n:
        found += [(f"tau{i + 1}", e.tau[i]), (f"c{i + 1}", e.c[i]), (f"G{i + 1}", e.g[i])]
        found += [(f"H{i + 1}{j + 1}", e.M[i][j]) for j in n]
    s = e.symbols
    rows = jacobian(s.tree, s.q, "tip")
    found += [(f"J{i + 1}{j + 1}", s.element(rows[i][j])) for i in range(3) for j in n]
    return [(name, e.form(x)) for name, x in found if not x.is_zero]


LINES = ("omega", "vc", "vc_d", "rc", "f", "M", "Mc")
"""Quantities of bodies that methods of derivation go through."""


@lru_cache(maxsize=64)
def lines(word: str) -> list[tuple[str, Expression]]:
    """The same of lines on the way: motions of bodies, forces between them, derivatives of L; each
    component is one."""
    arm, e = model(word)
    known, found = fb.quantities(arm), []
    for i in range(1, len(word) + 1):
        for stem in LINES:
            letters, _, dots = stem.partition("_")
            name = f"{letters}{i - 1 if stem == 'f' else ''}{i}"
            value = known[name + ("_d" if dots else "")]
            axes = "xy" if isinstance(value, tuple) else ("",)
            entries = value if isinstance(value, tuple) else (value,)
            found += [
                (name + ("_d" if dots else "") + axis, x)
                for axis, x in zip(axes, entries, strict=True)
            ]
    rates = e.symbols.rates
    L = e.T - e.V
    for i, q in enumerate(e.symbols.coordinates, 1):
        rate = next(iter(rates[q].terms()))[0].popitem()[0]
        unknown = {"theta": "θ", "d": "d"}[re.sub(r"\d", "", q)]
        momentum = L.derivative(rate)
        found += [
            (f"∂L/∂{unknown}{i}", L.derivative(q)),
            (f"∂L/∂{unknown}\u0307{i}", momentum),
            (f"d/dt(∂L/∂{unknown}\u0307{i})", momentum.along(rates)),
        ]
    return [(name, e.form(x)) for name, x in found if not x.is_zero]


# ---------------------------------------------------------------- trees
Path = tuple[int, ...]


def parts(x: Expression) -> tuple[Expression, ...]:
    """What an expression is made of; the angle of a function is no part."""
    match x:
        case ex.Sum():
            return x.terms
        case ex.Product():
            return x.factors
        case ex.Negative():
            return (x.operand,)
        case ex.Power():
            return (x.base,)
    return ()


def rebuilt(x: Expression, new: tuple[Expression, ...]) -> Expression:
    """The same with other parts."""
    match x:
        case ex.Sum():
            return ex.Sum(new)
        case ex.Product():
            return ex.Product(new)
        case ex.Negative():
            return ex.Negative(new[0])
        case ex.Power():
            return ex.Power(new[0], x.exponent)
    return x


def paths(x: Expression, here: Path = ()) -> Iterator[tuple[Path, Expression]]:
    """All pieces with where they are."""
    yield here, x
    for k, part in enumerate(parts(x)):
        yield from paths(part, (*here, k))


def at(x: Expression, path: Path) -> Expression:
    """The piece at a place."""
    return at(parts(x)[path[0]], path[1:]) if path else x


def put(x: Expression, path: Path, new: Expression) -> Expression:
    """The expression with another piece there."""
    if not path:
        return new
    rows = list(parts(x))
    rows[path[0]] = put(rows[path[0]], path[1:], new)
    return rebuilt(x, tuple(rows))


def changed_everywhere(x: Expression, change: Callable[[Expression], Expression]) -> Expression:
    """`change` of all pieces, the inner ones first."""
    return change(rebuilt(x, tuple(changed_everywhere(part, change) for part in parts(x))))


# ---------------------------------------------------------------- mistakes
@dataclass(frozen=True)
class Mistake:
    """A wrong answer, what was done to it and where: `old` and `new` pieces, and the term of a sum
    they are in."""

    kind: str
    answer: Expression
    old: Expression
    new: Expression
    right: Expression
    without: Expression
    """The right answer with 0 for the term that was touched: it tells what that term
    contributes."""


KINDS = ("sign", "factor", "index", "angle", "missing", "extra", "function", "length")


def mistake(rng: random.Random, word: str, right: Expression, kind: str) -> Mistake | None:
    """A random mistake of a kind, or None where the answer has nothing to get wrong in this way."""
    rows = [
        (path, x, new)
        for path, x in paths(right)
        for new in [_wrong(rng, word, right, path, x, kind)]
        if new is not None
    ]
    if not rows:
        return None
    path, old, new = rng.choice(rows)
    addend = path
    while addend and not isinstance(at(right, addend[:-1]), ex.Sum):
        addend = addend[:-1]
    return Mistake(kind, put(right, path, new), old, new, right, put(right, addend, ex.ZERO))


def _wrong(
    rng: random.Random, word: str, right: Expression, path: Path, x: Expression, kind: str
) -> Expression | None:
    """What stands in place of a piece after a mistake of a kind; None where it cannot be made."""
    is_term = not path or isinstance(at(right, path[:-1]), ex.Sum)
    match kind:
        case "sign" if is_term:
            return ex.neg(x)
        case "factor" if is_term:
            return ex.mul(rng.choice([2, 3, Fraction(1, 2), 4]), x)
        case "missing" if is_term and path and len(at(right, path[:-1]).terms) > 1:
            return ex.ZERO
        case "extra" if is_term:
            return ex.Sum((x, _invented(rng, word, x)))
        case "function" if isinstance(x, ex.Function):
            return ex.Function({"sin": "cos", "cos": "sin"}[x.name], x.argument)
        case "angle" if isinstance(x, ex.Function):
            other = rng.choice([a for a in _angles(word) if a != x.argument] or [None])
            return other and ex.Function(x.name, other)
        case "index" | "length" if isinstance(x, ex.Symbol):
            names = _others(word, x.name, kind)
            return sym(rng.choice(names)) if names else None
    return None


def _others(word: str, name: str, kind: str) -> list[str]:
    """Symbols that are written for one by mistake."""
    match = re.fullmatch(r"([A-Za-z]+)(\d)(_d{1,2})?", name)
    if match is None:
        return []
    letter, k, ending = match[1], match[2], match[3] or ""
    if kind == "length":
        return [{"l": "lc", "lc": "l"}[letter] + k] if letter in ("l", "lc") else []
    others = [str(i + 1) for i in range(len(word)) if str(i + 1) != k]
    if letter in ("theta", "d"):
        others = [i for i in others if {"R": "theta", "P": "d"}[word[int(i) - 1]] == letter]
    return [letter + i + ending for i in others]


def _angles(word: str) -> list[Expression]:
    """Sums of angles of neighbouring joints."""
    turning = [sym(f"theta{i + 1}") for i, letter in enumerate(word) if letter == "R"]
    n = len(turning)
    return [ex.add(*turning[i:j]) for i in range(n) for j in range(i + 1, n + 1)]


def _invented(rng: random.Random, word: str, x: Expression) -> Expression:
    """A term that looks like another one but is not: a symbol exchanged, or a function more."""
    spots = [(p, s) for p, s in paths(x) if isinstance(s, ex.Symbol)]
    path, old = rng.choice(spots) if spots else ((), ex.ONE)
    names = _others(word, getattr(old, "name", ""), "index") + _others(
        word, getattr(old, "name", ""), "length"
    )
    if spots and names:
        return put(x, path, sym(rng.choice(names)))
    angles = _angles(word)
    return ex.mul(x, ex.cos(rng.choice(angles))) if angles else ex.mul(x, sym("m1"))


# ---------------------------------------------------------------- equal forms
def rewritten(rng: random.Random, x: Expression, steps: int = 6, odd: bool = True) -> Expression:
    """The same in another form: multiplied out, sums of angles expanded, in another order; `odd`:
    as nobody writes."""
    for _ in range(steps):
        rows = [
            (path, new)
            for path, node in paths(x)
            if odd or not isinstance(node, ex.Symbol)
            for new in _equal(rng, node)
        ]
        if rows and sum(1 for _ in paths(x)) < 400:
            x = put(x, *rng.choice(rows))
    return changed_everywhere(x, lambda node: _shuffled(rng, node))


def _shuffled(rng: random.Random, x: Expression) -> Expression:
    rows = list(parts(x))
    if isinstance(x, ex.Sum | ex.Product) and rng.random() < 0.7:
        rng.shuffle(rows)
    return rebuilt(x, tuple(rows))


def _equal(rng: random.Random, x: Expression) -> Iterator[Expression]:
    """Other ways to write one piece."""
    match x:
        case ex.Product() if any(isinstance(f, ex.Sum) for f in x.factors):
            k = rng.choice([k for k, f in enumerate(x.factors) if isinstance(f, ex.Sum)])
            rest = (*x.factors[:k], *x.factors[k + 1 :])
            yield ex.Sum(tuple(ex.Product((*rest, term)) for term in x.factors[k].terms))
        case ex.Power() if x.exponent == 2:
            yield ex.Product((x.base, x.base))
            if isinstance(x.base, ex.Function) and x.base.name in ("sin", "cos"):
                other = ex.Function({"sin": "cos", "cos": "sin"}[x.base.name], x.base.argument)
                yield ex.Sum((ex.ONE, ex.Negative(ex.Power(other, 2))))
        case ex.Function() if isinstance(x.argument, ex.Sum):
            k = rng.randrange(1, len(x.argument.terms))
            a, b = ex.add(*x.argument.terms[:k]), ex.add(*x.argument.terms[k:])
            if x.name == "cos":
                yield ex.Sum(
                    (ex.mul(ex.cos(a), ex.cos(b)), ex.Negative(ex.mul(ex.sin(a), ex.sin(b))))
                )
            elif x.name == "sin":
                yield ex.Sum((ex.mul(ex.sin(a), ex.cos(b)), ex.mul(ex.cos(a), ex.sin(b))))
        case ex.Symbol():
            part = rng.choice([Fraction(1, 2), Fraction(1, 4), Fraction(2)])
            yield ex.Sum((ex.mul(part, x), ex.mul(1 - part, x)))
        case ex.Negative(operand=ex.Sum()):
            yield ex.Sum(tuple(ex.neg(term) for term in x.operand.terms))


# ---------------------------------------------------------------- notations
_LOW = str.maketrans("0123456789", "₀₁₂₃₄₅₆₇₈₉")


class Writer:
    """Writes expressions in one notation, chosen at random: code, plain text, Unicode or LaTeX."""

    def __init__(self, rng: random.Random, word: str):
        self.rng = rng
        self.word = word
        self.style = rng.choice(["code", "plain", "unicode", "latex"])
        self.times = {
            "code": "*",
            "plain": rng.choice([" ", "*", " * "]),
            "unicode": rng.choice([" ", "·", " × "]),
        }.get(self.style, rng.choice([" ", r" \cdot ", r"\,"]))
        self.power = rng.choice(["**", "^"]) if self.style == "code" else "^"
        self.short = rng.random() < 0.3 and word.count("R") == len(word)
        self.q = rng.random() < 0.25 and self.style in ("code", "plain")
        self.rate = rng.choice(["{}_d", "d{}", "{}'", "{}dot"])
        self.brackets = (
            rng.choice(["()", "[]"]) if self.style != "latex" else rng.choice(["()", "lr"])
        )

    def equation(self, name: str, x: Expression) -> str:
        """name = expression."""
        if re.search(r"[xy∂]", name) or name.startswith(("omega", "vc", "rc", "f", "M")):
            return f"{name} = {self.write(x)}"
        letter, digits = re.sub(r"\d", "", name), re.sub(r"\D", "", name)
        letter = {"H": self.rng.choice(["H", "M"]), "G": self.rng.choice(["G", "g"])}.get(
            letter, letter
        )
        if self.style == "latex":
            letter = "\\tau" if letter == "tau" else letter
            left = f"{letter}_{{{digits}}}" if digits else letter
        elif self.style == "unicode":
            left = ("τ" if letter == "tau" else letter) + digits.translate(_LOW)
        else:
            left = letter + self.rng.choice(["", "_"] if digits else [""]) + digits
        return f"{left} = {self.write(x)}"

    def write(self, x: Expression, level: int = 0) -> str:
        """An expression; brackets where `level` (1: in a product, 2: below a power) needs them."""
        match x:
            case ex.Sum():
                text = self.write(x.terms[0], 0)
                for term in x.terms[1:]:
                    minus = isinstance(term, ex.Negative)
                    text += (" - " if minus else " + ") + self.write(
                        term.operand if minus else term, 1
                    )
                return self.bracket(text) if level else text
            case ex.Negative():
                text = "-" + self.write(x.operand, 1)
                return self.bracket(text) if level else text
            case ex.Product():
                text = self.times.join(
                    self.write(f, 1.5 if k else 1) for k, f in enumerate(x.factors)
                )
                return self.bracket(text) if level > 1 else text
            case ex.Power():
                return self._power(x)
            case ex.Number():
                return self._number(x.value, level)
            case ex.Symbol():
                return self.symbol(x.name)
            case ex.Function():
                return self._function(x.name, x.argument)
        raise TypeError(type(x).__name__)

    def bracket(self, text: str) -> str:
        """( … )."""
        if self.brackets == "lr":
            return rf"\left({text}\right)"
        return self.brackets[0] + text + self.brackets[1]

    def _number(self, value: Fraction, level: float) -> str:
        if value < 0:
            return self.bracket("-" + self._number(-value, 0))
        if value.denominator == 1:
            return (
                self.bracket(str(value))
                if (level == 1.5 and self.times.isspace()) or level == 1.5
                else str(value)
            )
        if value.denominator in (2, 4) and self.rng.random() < 0.3:
            text = str(float(value))
        elif self.style == "latex":
            return rf"\frac{{{value.numerator}}}{{{value.denominator}}}"
        elif self.style == "unicode" and value == Fraction(1, 2):
            text = "½"
        else:
            text = f"{value.numerator}/{value.denominator}"
        return self.bracket(text) if level > 1 or (level == 1.5) else text

    def _power(self, x: ex.Power) -> str:
        exponent = str(x.exponent)
        if (
            isinstance(x.base, ex.Function)
            and self.style in ("latex", "unicode")
            and not self.short
        ):
            text = self._function(x.base.name, x.base.argument)
            name = "\\" + x.base.name if self.style == "latex" else x.base.name
            high = (
                f"^{{{exponent}}}"
                if self.style == "latex"
                else {"2": "²", "3": "³"}.get(exponent, "^" + exponent)
            )
            return text.replace(name, name + high, 1)
        base = self.write(x.base, 2)
        if isinstance(x.base, ex.Function) and not self.short:
            base = self.bracket(base)
        if self.style == "unicode":
            return base + exponent.translate(str.maketrans("0123456789", "⁰¹²³⁴⁵⁶⁷⁸⁹"))
        return base + (f"^{{{exponent}}}" if self.style == "latex" else self.power + exponent)

    def _function(self, name: str, argument: Expression) -> str:
        terms = argument.terms if isinstance(argument, ex.Sum) else (argument,)
        if self.short and all(isinstance(t, ex.Symbol) for t in terms):
            digits = "".join(sorted(re.sub(r"\D", "", t.name) for t in terms))
            return f"{name[0]}_{{{digits}}}" if self.style == "latex" else name[0] + digits
        inner = self.write(argument)
        head = "\\" + name if self.style == "latex" else name
        if (
            len(terms) == 1
            and isinstance(argument, ex.Symbol)
            and self.style in ("latex", "unicode")
        ):
            return f"{head} {inner}"
        return head + self.bracket(inner)

    def symbol(self, name: str) -> str:
        """A symbol in this notation."""
        match = re.fullmatch(r"([A-Za-z]+?)(\d*)(_d{1,2})?", name)
        assert match is not None
        letter, k, dots = match[1], match[2], len(match[3] or "_") - 1
        if self.q and letter in ("theta", "d"):
            letter = "q"
        if self.style == "latex":
            letter = "\\theta" if letter == "theta" else letter
            if letter == "lc":
                return f"l_{{c{k}}}"
            dotted = f"\\{'d' * dots}ot{{{letter}}}" if dots else letter
            return f"{dotted}_{k}" if k else dotted
        if self.style == "unicode":
            letter = "θ" if letter == "theta" else letter
            return letter + ("", "\u0307", "\u0308")[dots] + k.translate(_LOW)
        if not dots:
            return letter + k
        rate = (
            {"{}dot": "{}ddot", "d{}": "dd{}", "{}_d": "{}_dd", "{}'": "{}''"}[self.rate]
            if dots == 2
            else self.rate
        )
        return rate.format(letter + k)


# ---------------------------------------------------------------- does a verdict name a mistake?
SAME = {
    "sign": {"sign", "factor"},
    "factor": {"factor"},
    "index": {"index", "symbol", "rate", "length"},
    "length": {"length", "symbol"},
    "angle": {"angle"},
    "function": {"function", "angle"},
    "missing": {"missing"},
    "extra": {"extra"},
}
"""What a finding of each kind of mistake may be called."""


def named(setting: RightEquations, verdict: Verdict, m: Mistake) -> bool:
    """Whether a finding says what was done: the piece and what it should be; or the term, as it is
    and should be."""
    value = lambda x: polynomial(setting, x)
    whole = value(m.answer) - value(m.right)  # what the mistake adds to the answer
    term = value(m.right) - value(m.without)
    old, new = value(m.old), value(m.new)
    if m.kind == "extra":
        old, new = setting.zero, new - old
    pairs = [(read(setting, f.yours), read(setting, f.right)) for f in verdict.findings]
    for finding, (yours, right) in zip(verdict.findings, pairs, strict=True):
        if finding.kind in SAME[m.kind] and (yours, right) in (
            (new, old),
            (term + whole, term),
            (whole, setting.zero),
        ):
            return True
        if finding.kind in SAME[m.kind] and m.kind == "missing" and right in (old, term):
            return True
        if (
            finding.kind in SAME[m.kind]
            and m.kind in ("sign", "factor")
            and right in (old, -old, term, -term)
        ):
            return True
    known = [(yours, right) for yours, right in pairs if yours is not None and right is not None]
    gap = sum((yours - right for yours, right in known), setting.zero)
    return len(known) == len(pairs) and gap == whole and len(pairs) <= 3


def read(setting: RightEquations, text: str) -> Trig | None:
    """A piece of a verdict as polynomial; "" is 0, what cannot be read None."""
    if not text:
        return setting.zero
    vocabulary = Vocabulary(setting)
    try:
        source = AnswerText.of(text)
        node = AnswerParser(
            source, tokens(source, vocabulary)[:-1], vocabulary, lambda name: None
        ).side()
        return PolynomialReader(source, setting.ring).read(node)
    except fb.FreebodyError:
        return None
