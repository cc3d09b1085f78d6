"""Verdicts as sentences for students: changes, differences, and numerical examples."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction

from freebody.expressions import expression as ex
from freebody.expressions.grammar.atoms import atom, numbered
from freebody.expressions.grammar.source import Source
from freebody.expressions.grammar.tables.characters import DOT
from freebody.expressions.grammar.words import spelt
from freebody.expressions.nodes import (
    Expression,
    Function,
    Number,
    Power,
    Product,
    Sum,
    Symbol,
    nodes,
)
from freebody.expressions.printed_names import sym, with_letter
from freebody.expressions.quantities.kinds import LETTERED
from freebody.outputs.number_text import shortest
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.finite_field import Workspace
from freebody_textbook.check.algebra.quotients import Named, Value, Wave, pair
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reasons.polynomial_differences import Difference, printed
from freebody_textbook.check.reasons.small_changes import Repair
from freebody_textbook.check.states.state_values import StateValues
from freebody_textbook.check.verdict import EquationVerdict, Example, Mistake
from freebody_textbook.closed_chains.multiplier_equations import MULTIPLIER
from freebody_textbook.relations.formula_values import occurs, typical_value

_LONG = 70
_MOST_TERMS = 60
"""Terms of a right side that fill a screen."""
_USUAL = frozenset(kind.usual for kind in LETTERED if kind.usual)
"""Letters by which sentences name entries."""
_OF_REPAIR = {
    "sign": "{written} has the wrong sign: it must be {should}.",
    "factor": "{written} {times}: it must be {should}.",
    "extra": "{written} should not be there{inside}.",
    "missing": "In {written} a term is missing: it must be {should}.",
    "missing factor": "{written} lacks the factor {factor}.",
    "extra factor": "The factor {written} should not be there{inside}.",
    "exponent": "{written} has the wrong power{inside}: it must be {should}.",
    "arguments": "atan2 takes the sine's part first: {should}.",
    "inverse": "It is the {should} of that.",
}
_OTHER_REPAIR = "{written} must be {should}{inside}{reason}."
"""The sentence about any other change of the answer."""

_OF_REVERSE = {
    "sign": "{should}{inside} has the wrong sign in your answer.",
    "factor": "{should}{inside} {times} in your answer.",
    "missing": "{should}{inside} is missing.",
    "extra": "In place of {should} you have {has}: one term should not be there.",
    "missing factor": "The factor {should}{inside} is missing in your answer.",
    "extra factor": "{should} has an extra factor {factor} in your answer.",
}
_OTHER_REVERSE = "In place of {should}{inside} you have {has}{reason}."
"""The sentence about any other change of the right answer that makes it the user's."""

_OF_FUNCTIONS = {"arcsin": "arcsine", "arccos": "arccosine", "atan2": "atan2(y, x)"}
"""Words for inverse functions, whose values no polynomial prints."""

_OPPOSITE = {
    "extra": "missing",
    "missing": "extra",
    "missing factor": "extra factor",
    "extra factor": "missing factor",
}


def right_verdict(claim: Claim, note: str = "") -> EquationVerdict:
    """The verdict on a claim that is right."""
    return EquationVerdict(claim.label, claim.target.title, True, note=note)


def wrong_verdict(
    claim: Claim,
    findings: Iterable[Mistake] = (),
    causes: Iterable[str] = (),
    shown: Example | None = None,
) -> EquationVerdict:
    """The verdict on a claim that is wrong, with an example in numbers."""
    text = sentence(shown) if shown else ""
    title = claim.target.title
    return EquationVerdict(claim.label, title, False, tuple(findings), tuple(causes), shown, text)


def right_equation(setting: RightEquations, claim: Claim) -> Expression | None:
    """The right value of a claim's quantity, as an equation where it has a name of its own; None of
    equations between two sides, of poses, of what stands for itself, and of long formulas."""
    if claim.whole is not None or claim.target.kind.is_pose:
        return None
    right = claim.target.compute()
    form = setting.printed(right) if max(map(len, pair(right))) <= _MOST_TERMS else None
    if form is None or isinstance(form, Symbol):
        return None
    name = _code_name(spelt(claim.label))
    return ex.eq(sym(name), form) if name else form


def _code_name(name: str) -> str:
    """A plain name in the spelling of code, which has the dots behind it: vc2x_d."""
    plain = name.lstrip(DOT)
    return f"{plain}_{'d' * (len(name) - len(plain))}" if plain != name else name


@dataclass(frozen=True)
class Wording:
    """Makes sentences about one answer, from its text and the print form of its symbols."""

    setting: RightEquations
    source: Source

    # ------------------------------------------------------------ repairs of the answer itself
    def of_repair(self, repair: Repair, work: Workspace) -> Mistake:
        """The mistake that a change corrects, with its place in the answer."""
        written = self.written(repair.node.span)
        should = self._opposite(repair) or self.node(repair.new)
        if repair.node is work.root and isinstance(repair.node, Sum):
            written = "The whole answer"
        message = _OF_REPAIR.get(repair.kind, _OTHER_REPAIR).format(
            written=written,
            should=_cut(should),
            inside=self._around(work.addend_of(repair.node), repair, work, "in"),
            times=_times(repair.factor),
            factor=self._factor(repair),
            reason=self._reason(repair.kind, repair.node, repair.new),
        )
        line, column = self.source.place(repair.node.span[0])
        context = self.source.caret(repair.node.span)
        return Mistake(
            repair.kind, message, self.source[repair.node.span], should, line, column, context
        )

    def _opposite(self, repair: Repair) -> str:
        """A piece's text with reversed sign, if it contains named quantities, whose values would be
        too long."""
        named = (
            isinstance(x, Function) or (isinstance(x, Named) and not self._name(x))
            for x in nodes(repair.node)
        )
        if repair.kind != "sign" or not any(named):
            return ""
        text = self.source[repair.node.span]
        return text[1:].strip() if text[:1] in "-−" else f"−{text}"

    def _around(self, addend: Expression, repair: Repair, work: Workspace, word: str) -> str:
        """Phrase for the term that contains a changed piece, unless it is the piece itself or the
        whole side."""
        alone = addend is repair.node or addend is work.root
        return "" if alone else f" {word} {self.written(addend.span)}"

    def _factor(self, repair: Repair) -> str:
        """The factor that a change inserts."""
        if repair.kind != "missing factor" or not isinstance(repair.new, Product):
            return ""
        return self.node(repair.new.factors[-1])

    def _reason(self, kind: str, old: Expression, new: Expression) -> str:
        """Half a sentence on why a piece is wrong."""
        name = self._name(old)
        if name in self.setting.foreign:
            return f" ({sym(name)} is not a symbol of {self.setting.symbols.model.name})"
        other = self._name(new)
        letter, k = numbered(other)
        if kind == "length" and letter == "lc":
            return (
                f": the centre of mass of link {k} is {sym(other)} from its joint, "
                f"{sym('l' + k)} is the length of the link"
            )
        if kind == "length":
            return (
                f": {sym(other)} is the distance to the next joint, {sym('lc' + k)} only "
                f"that to the centre of mass"
            )
        if (
            kind == "angle"
            and isinstance(new, Wave)
            and isinstance(old, Wave)
            and len(new.angle) > len(old.angle) > 0
        ):
            return (
                ": angles are measured from the previous link, so the direction of a link is "
                "a sum of angles"
            )
        if kind == "rate" and isinstance(new, Sum):
            return (
                ": rates are relative to the previous link, so a link's angular velocity is "
                "a sum of rates"
            )
        return ""

    def _name(self, node: Expression) -> str:
        """The generator that a node stands for; "" if none."""
        if isinstance(node, Named) and isinstance(node.value, Trig):
            names = [next(iter(p), "") for p, _ in node.value.terms()]
            return names[0] if len(names) == 1 else ""
        return ""

    # ------------------------------------------------------------ the same seen from the right
    # answer
    def of_reverse(self, repair: Repair, work: Workspace, right: Wording) -> Mistake:
        """The mistake that a change of the correct answer shows, when the change gives the user's
        answer; right: the wording of the correct answer."""
        should, has = right.written(repair.node.span), right.node(repair.new)
        kind = _OPPOSITE.get(repair.kind, repair.kind)
        addend = work.addend_of(repair.node)
        if addend is repair.node and addend is not work.root:
            addend = work.addend_of(work.parents[addend])
        message = _OF_REVERSE.get(kind, _OTHER_REVERSE).format(
            should=should,
            has=_cut(has),
            inside=right._around(addend, repair, work, "of"),
            times=_times(1 / repair.factor) if repair.factor else "",
            factor=right._factor(repair),
            reason=self._reason(repair.kind, repair.new, repair.node),
        )
        yours = "" if kind == "missing" else has
        return Mistake(kind, message, yours, right.source[repair.node.span])

    # ------------------------------------------------------------ differences of terms
    def of_difference(self, row: Difference) -> Mistake:
        """The mistake of a missing term, an extra term, or a term with a wrong coefficient."""
        yours = self.term(row.instead or row.key, row.yours)
        right = self.term(row.key, row.right)
        if row.instead is not None:
            return Mistake("term", f"The term {quoted(yours)} must be {right}.", yours, right)
        if row.yours == 0:
            return Mistake("missing", f"The term {quoted(right)} is missing.", "", right)
        if row.right == 0:
            return Mistake("extra", f"The term {quoted(yours)} should not be there.", yours, "")
        if row.yours == -row.right:
            return Mistake(
                "sign",
                f"The term {quoted(yours)} has the wrong sign: it must be {right}.",
                yours,
                right,
            )
        message = f"The term {quoted(yours)} {_times(row.right / row.yours)}: it must be {right}."
        return Mistake("factor", message, yours, right)

    def of_number(self, row: Difference) -> Mistake:
        """The mistake of a term with a wrong number, in a numeric answer."""
        yours, right = self.term(row.instead or row.key, row.yours), self.term(row.key, row.right)
        if row.yours and row.right and row.instead is None:
            return Mistake("factor", f"{quoted(yours)} must be {right}.", yours, right)
        return self.of_difference(row)

    def term(self, key: tuple, value: Fraction) -> str:
        """Printed form of a term with its coefficient."""
        return str(printed(self.setting.layout, self.setting, key, value))

    # ------------------------------------------------------------ pieces
    def written(self, span: tuple[int, int]) -> str:
        """A piece of the answer's text in quotes, shortened if long."""
        return quoted(self.source[span])

    def node(self, node: Expression) -> str:
        """Printed form of a piece of a corrected answer."""
        match node:
            case Named() if node.name in self.setting.ring.index:
                return str(sym(node.name))
            case Named() if _is_usual(node.name):
                return with_letter(node.name)
            case Wave():
                angle = ex.add(*(ex.mul(k, sym(x)) for x, k in node.angle))
                text = str(ex.Function(node.function, angle))
                return text if not node.turn else self._form(node)
            case Power(base=Named() | Wave()):
                return str(ex.power(sym("x"), node.exponent)).replace("x", self.node(node.base), 1)
            case Number():
                return str(ex.num(node.value))
            case Function() if node.name in _OF_FUNCTIONS:
                return _OF_FUNCTIONS[node.name]
        return self._form(node)

    def _form(self, node: Expression) -> str:
        return self.setting.form(PolynomialReader(self.source, self.setting.ring).quotient(node))


def _is_usual(name: str) -> bool:
    """Whether a name is the usual one of a matrix entry, such as H12."""
    own = atom(name)
    return own.is_numbered and own.letter in _USUAL


def quoted(text: str) -> str:
    """A text in quotes, shortened in the middle if long."""
    shown = text if len(text) <= _LONG else f"{text[: _LONG // 2]} … {text[-_LONG // 3 :]}"
    return f"‘{shown}’"


def _cut(text: str) -> str:
    """A text shortened at the end if it is very long."""
    return text if len(text) <= 3 * _LONG else text[: 3 * _LONG] + " …"


def _times(factor: Fraction) -> str:
    """Phrase for a term that must be multiplied by a number."""
    size = abs(factor)
    sign = "has the wrong sign and " if factor < 0 else ""
    if size == 1:
        return "has the wrong sign"
    if size in (2, Fraction(1, 2)):
        return sign + (
            "is half as large as it should be: a factor of 2 is missing"
            if size == 2
            else "is twice as large as it should be"
        )
    if size.numerator == 1:
        return f"{sign}is {size.denominator} times too large"
    return f"{sign}must be multiplied by {size}"


def example(setting: RightEquations, yours: Value, right: Value) -> Example | None:
    """Values of the occurring symbols with both results; None if no tried values distinguish the
    results."""
    pieces = (*pair(yours), *pair(right))
    used = [name for name in setting.ring.names if any(occurs(name, x) for x in pieces)]
    given = setting.symbols.model.parameters
    for shift in range(4):
        values = {
            name: typical_value(name, given.get(name), shift, k) for k, name in enumerate(used)
        }
        try:
            a, b = float(yours.evaluate(values)), float(right.evaluate(values))
        except (OverflowError, ZeroDivisionError):
            return None
        if f"{a:.4g}" != f"{b:.4g}":
            return Example(values, a, b)
    return Example(values, a, b) if used and not math.isclose(a, b, rel_tol=1e-12) else None


def example_at(
    setting: RightEquations,
    states: StateValues,
    k: int,
    tree: Expression,
    right: Value,
) -> Example | None:
    """A state as example: the values of the symbols in both sides, and both results; None if a
    result is not a number."""
    written = [y for x in nodes(tree) if isinstance(x, Named) for y in pair(x.value)]
    waves = {name for x in nodes(tree) if isinstance(x, Wave) for name, _ in x.angle}

    def is_told(name: str) -> bool:
        """Whether an example lists a symbol's value; multipliers are listed only if the answer
        contains them."""
        of = written if name.startswith(MULTIPLIER) else [*written, *pair(right)]
        return name in waves or any(occurs(name, piece) for piece in of)

    values = {
        name: float(f"{states.generator(name)[k]:.4g}")
        for name in setting.ring.names
        if is_told(name)
    }
    sides = states.at(tree, {}), states.of(right)
    yours, own = (0.0 if x.vanishes[k] else float(x.value[k]) for x in sides)
    return Example(values, yours, own) if math.isfinite(yours + own) else None


def sentence(found: Example) -> str:
    """An example in words: For example, with θ₁ = 0.4, l₁ = 0.5: yours 1.2, right 1.3."""
    at = ", ".join(f"{sym(name)} = {shortest(value)}" for name, value in found.values.items())
    digits = next(
        (d for d in (4, 6, 9, 15) if f"{found.yours:.{d}g}" != f"{found.right:.{d}g}"), 17
    )
    yours, right = (shortest(x, digits) for x in (found.yours, found.right))
    numbers = f"yours is {yours}, the right one {right}"
    return f"For example, at {at}: {numbers}." if at else f"In numbers: {numbers}."
