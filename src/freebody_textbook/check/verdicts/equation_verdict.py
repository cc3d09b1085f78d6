"""The verdict on one equation of an answer: equal, or the simplest explanation of the
difference."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

from freebody.expressions.grammar.words import spelt
from freebody.expressions.nodes import Expression, Number, nodes, replaced
from freebody.expressions.printed_names import sym
from freebody.expressions.quantities import kinds
from freebody.expressions.quantities.kinds import Kind
from freebody.expressions.quantities.units import unit_text
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.accepted_variants import (
    coriolis_advice,
    coriolis_notes,
    in_its_scale,
    is_undriven_equation,
)
from freebody_textbook.check.algebra.exact_polynomials import PolynomialReader
from freebody_textbook.check.algebra.finite_field import (
    Point,
    Workspace,
    random_point,
    without_values,
)
from freebody_textbook.check.algebra.quotients import Named, Value, difference
from freebody_textbook.check.asked.asked_quantities import Targets
from freebody_textbook.check.asked.more_of_bodies import MOVES
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.numbers.units_of_symbols import can_be_a_level, misfit
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reading.vocabulary import Vocabulary
from freebody_textbook.check.reasons.bodies_at_point import BodiesAtPoint
from freebody_textbook.check.reasons.free_body_beliefs import FreeBodyMotion
from freebody_textbook.check.reasons.misconceptions import explaining
from freebody_textbook.check.reasons.misreadings import doubt_about, readings, unread_condition
from freebody_textbook.check.reasons.polynomial_differences import moving
from freebody_textbook.check.reasons.thoughts import FreeSides, Subject
from freebody_textbook.check.spelling.answer_text import AnswerError
from freebody_textbook.check.states.agreement import StatesOfModel
from freebody_textbook.check.states.state_values import functions_of
from freebody_textbook.check.verdict import EquationVerdict, Example, Mistake
from freebody_textbook.check.verdicts import singular_poses, verdict_at_states
from freebody_textbook.check.verdicts.explanation import Explanation, first, quotient_verdict
from freebody_textbook.check.verdicts.number_verdict import NumberJudge
from freebody_textbook.check.verdicts.rounded_numbers import MEASURED, Rounded
from freebody_textbook.check.verdicts.verdict_sentences import (
    Wording,
    example,
    example_at,
    quoted,
    right_equation,
    right_verdict,
    wrong_verdict,
)

_OTHER_SENSE = (
    "What has either sense, as a force at the tip, has another one here than in other lines."
)
STILL = (
    "It is right where nothing moves: write ‘In equilibrium:’ in front of it if that is meant; "
    "otherwise the terms with rates and accelerations are missing."
)


@dataclass(frozen=True)
class Judge:
    """Judges claims by comparing them with a model's correct values."""

    setting: RightEquations
    targets: Targets
    claims: Sequence[Claim]
    """The claims of the whole answer."""
    numbers: NumberJudge

    @cached_property
    def point(self) -> Point:
        """A random point of the finite field."""
        return random_point(self.setting.ring)

    @cached_property
    def bodies(self) -> BodiesAtPoint:
        """The bodies at the judge's point."""
        return BodiesAtPoint(self.setting, self.point)

    @cached_property
    def free_body(self) -> FreeBodyMotion | None:
        """The motion of a free body; None for other robots."""
        return FreeBodyMotion(self.setting) if self.setting.is_free_body else None

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """Names needed to read printed equations."""
        return Vocabulary(self.setting)

    def verdict(self, claim: Claim, explain: bool = True) -> EquationVerdict:
        """The verdict on one claim, with its mistakes named if `explain`, otherwise with an
        example; a claim is correct if it is so in one reading of its symbols."""
        found = self._as_read(claim, False)
        if found.equal:
            return found
        work, meant = without_values(claim.node), claim
        for reading in readings(self.setting, self.targets, claim, work):
            node = replaced(claim.node, reading.new)
            whole = claim.whole and replaced(claim.whole, reading.new)
            target = reading.target or claim.target
            with suppress(AnswerError):  # too long to be multiplied out
                value = self._value(claim, node)
                other = replace(claim, target=target, node=node, value=value, whole=whole)
                again = self._as_read(other, False)
                if again.equal:
                    return replace(again, note=f"{reading.note} {again.note}".strip())
                if reading.target is not None and _is_zero(claim.target):
                    meant = other
        wrong = self._as_read(meant, True) if explain else found
        meant = replace(meant, target=self._in_its_sense(meant))
        return replace(
            wrong,
            causes=(*wrong.causes, *unread_condition(claim)),
            right=right_equation(self.setting, meant),
        )

    def _value(self, claim: Claim, node: Expression) -> Value:
        """The value of an expression in an alternative reading."""
        if functions_of(node) or claim.target.kind.is_long:
            return claim.value
        return PolynomialReader(claim.source, self.setting.ring).quotient(node)

    def _as_read(self, claim: Claim, explain: bool) -> EquationVerdict:
        """The verdict on a claim in the first reading of its symbols."""
        if claim.target.kind.is_pose:
            return singular_poses.verdict(claim)
        if functions_of(claim.node if claim.whole is None else claim.whole):
            found = verdict_at_states.verdict(self, claim, claim.target.compute(), explain)
            assert found is not None
            return found
        number = self.numbers.verdict(claim, explain)
        if number is not None:
            return number
        claim = in_its_scale(claim, self.claims, self._same)
        claim = replace(claim, target=self._in_its_sense(claim))
        right = claim.target.compute()
        title = claim.target.title
        if difference(claim.value, right).is_zero:
            has_two_meanings = spelt(claim.label) in self.targets.namesakes
            meant = claim.target.note or f"It is read as {title}." * has_two_meanings
            note = " ".join(filter(None, (meant, self._zeros(claim))))
            return right_verdict(claim, note)
        if claim.target.kind.of_loops in ("positions", "rates") and claim.value.is_zero:
            return right_verdict(claim, "It says that the loop is closed.")
        if level := self._level(claim, right):
            note = f"It differs by the constant {level}: the zero level of V is arbitrary."
            return right_verdict(claim, note)
        special = verdict_at_states.verdict(self, claim, right, explain)
        special = special or quotient_verdict(self, claim, right, explain)
        if special is not None:
            return special
        assert isinstance(claim.value, Trig)
        assert isinstance(right, Trig)
        return (
            self._other_ways(claim, claim.value, right)
            or self._in_numbers(claim, claim.value, right)
            or self._wrong(claim, claim.value, right, explain)
        )

    def up_to_a_constant(self, claim: Claim, right: Value) -> bool:
        """Whether a claim is about an energy, whose reference level is free, and differs only by a
        constant."""
        if not claim.target.kind.up_to_a_constant:
            return False
        yours = claim.value
        if not (isinstance(yours, Trig) and isinstance(right, Trig)):
            return True  # the numerator of a quotient has other units
        return can_be_a_level(self.setting, yours - right, right)

    def _level(self, claim: Claim, right: Value) -> str:
        """The constant by which a claim about an energy may differ; "" if there is none."""
        if not (isinstance(claim.value, Trig) and isinstance(right, Trig)):
            return ""
        gap = claim.value - right
        is_one = self.up_to_a_constant(claim, right) and self._is_constant(gap)
        return str(self.setting.form(gap)) if is_one else ""

    @cached_property
    def states(self) -> StatesOfModel:
        """The model's states with loops closed and joints without drives obeying the equations of
        motion."""
        return StatesOfModel(self.setting)

    def _same(self, a: Value, b: Value) -> bool:
        """Whether two values are equal, or equal whenever the loops are closed."""
        gap = difference(a, b)
        return gap.is_zero or self._vanishes(gap)

    def _vanishes(self, x: Trig, still: bool = False) -> bool:
        """Whether a polynomial is 0 whenever the loops are closed; still: in equilibrium."""
        states = self.states.of(still=still) if self.setting.system is not None else None
        return states is not None and bool(states.polynomial(x).vanishes.all())

    def _in_its_sense(self, claim: Claim) -> AskedQuantity:
        """The claim's quantity with the sign that fits the answer, if either sign is correct, as
        for a torque balancing a force of unknown direction."""
        target = claim.target
        if not target.also:
            return target
        if target.kind.is_told_by_value:
            note, compute = self._told(claim)
            if compute is target.compute:
                return target
            words = f"{target.title}, {note[3:].rstrip('.')}" if note else target.words
            return replace(target, compute=compute, note=note, words=words)
        ((note, other),) = target.also
        senses = self._senses(target.kind)
        second = senses.index(max(senses)) if any(senses) else self._nearer(claim)
        if target.kind.has_own_sense:
            return replace(target, compute=other, note=note) if second else target
        if not second:
            return replace(target, thoughts=((_OTHER_SENSE, other), *target.thoughts))
        first = (_OTHER_SENSE, target.compute)
        return replace(target, compute=other, note=note, thoughts=(first, *target.thoughts))

    def _told(self, claim: Claim) -> Mistaken:
        """The meaning among those of a claim's quantity, with its note, from which the claim
        differs least, or with it all claims of its kind."""
        target = claim.target
        alike = [claim]
        if target.kind.is_defined_once:
            alike = [x for x in self.claims if x.target.kind is target.kind]

        def differing(way: Mistaken) -> int:
            found = 0
            for x in alike:
                meanings = {x.target.note: x.target.compute, **dict(x.target.also)}
                value = meanings.get(way[0], x.target.compute)()
                found += len(difference(x.value, value))
            return found

        return min([(target.note, target.compute), *target.also], key=differing)

    def _senses(self, kind: Kind) -> tuple[int, int]:
        """(number of claims about a kind correct with the first sign, number with the second)."""
        of = {kind} if kind.has_own_sense else {x.target.kind for x in self.claims}
        told = [x for x in self.claims if x.target.also and x.target.kind in of]
        first = sum(_is_right(claim, claim.target.compute) for claim in told)
        return first, sum(_is_right(claim, claim.target.also[0][1]) for claim in told)

    def _nearer(self, claim: Claim) -> int:
        """The sign convention with which fewer terms differ."""
        values = (claim.target.compute(), claim.target.also[0][1]())
        sizes = [len(difference(claim.value, x)) for x in values]
        return sizes.index(min(sizes))

    def _wrong(self, claim: Claim, yours: Trig, right: Trig, explain: bool) -> EquationVerdict:
        if explain and self._is_meant_still(claim, yours, right):
            return self._with_example(claim, right, (), (STILL,))
        right, condition = self.numbers.at_condition(claim, right)
        findings, causes = self._explained(claim, yours, right) if explain else ([], [])
        causes = [*[f"It is compared at {condition}."] * bool(condition), *causes]
        hint = coriolis_advice(self.setting, claim, self.claims)
        causes = [*causes, *[hint] * bool(hint), *self._unsymmetric(claim)]
        return self._with_example(claim, right, findings, causes)

    def _is_meant_still(self, claim: Claim, yours: Trig, right: Trig) -> bool:
        """Whether an answer without moving quantities is correct in equilibrium."""
        if not claim.target.kind.may_be_still or self.numbers.has_motion(claim):
            return False
        lexemes = claim.source.lexemes
        within = lexemes.between(*claim.node.span)
        if MOVES.found_in(lexemes, within.start, within.stop):
            return False
        return self.numbers.is_right_in_equilibrium(yours, right) or self._vanishes(
            yours - right, still=True
        )

    def _unsymmetric(self, claim: Claim) -> list[str]:
        """A sentence on a mass matrix entry for which the answer gives two different values."""
        mirrored = claim.target.index[::-1]
        if not claim.target.kind.is_symmetric or mirrored == claim.target.index:
            return []
        return [
            f"The mass matrix is symmetric, so {claim.label} = {other.label}."
            for other in self.claims
            if other.target.kind is claim.target.kind
            and other.target.index == mirrored
            and other.value != claim.value
        ][:1]

    def _with_example(
        self, claim: Claim, right: Trig, findings: Sequence[Mistake], causes: Sequence[str]
    ) -> EquationVerdict:
        return wrong_verdict(claim, findings, causes, self.example(claim.value, right))

    def example(self, yours: Value, right: Value) -> Example | None:
        """Numbers at which an answer differs from the correct one; for a closed chain at a state
        with closed loops."""
        states = self.states.of(own_values=True) if self.setting.system is not None else None
        if states is not None:
            gap = states.of(yours) - states.of(right)
            if not gap.vanishes.all():
                tree = Named("", yours)
                return example_at(self.setting, states, gap.worst, tree, right)
        return example(self.setting, yours, right)

    def _other_ways(self, claim: Claim, yours: Trig, right: Trig) -> EquationVerdict | None:
        """The verdict on an answer that is correct in another form: torques of passive joints,
        other matrices C; None if it is not."""
        note = self.coriolis.get(claim.target.index, "") if claim.target.kind.by_rates else ""
        if claim.target.idle and (
            yours.is_zero or is_undriven_equation(self.setting, yours, right)
        ):
            joint = claim.target.index[0]
            note = f"Joint {joint} is passive: {sym(f'{kinds.TORQUE.usual}{joint}')} = 0."
        return right_verdict(claim, note) if note else None

    @cached_property
    def coriolis(self) -> Mapping[tuple[int, ...], str]:
        """Notes, by indices, on entries of a Coriolis matrix that differs from Christoffel's."""
        return coriolis_notes(self.setting, self.claims)

    # ------------------------------------------------------------ numbers
    def _in_numbers(self, claim: Claim, yours: Trig, right: Trig) -> EquationVerdict | None:
        """The verdict on an answer in numbers, or about a model with measured numbers; None for an
        answer in symbols."""
        model = self.setting.symbols.model
        values = {name: value for name, value in model.parameters.items() if value is not None}
        decimal = self.setting.order.decimal
        rounded = Rounded(self.setting, claim.source, claim.node, yours, right, values)
        if not decimal and not rounded.applies:
            return self._mixed(claim, rounded) if values else None
        wrong = rounded.wrong(MEASURED) if decimal else rounded.wrong()
        if wrong is None:
            return None
        has_level = self.up_to_a_constant(claim, right)
        moves = moving(self.setting)
        off = [x for x in wrong if x.instead or not has_level or not x.names.isdisjoint(moves)]
        if not off:
            note = "Numbers were compared to three digits."
            if rounded.applies:
                note = f"In numbers, with the values of {model.name!r}, to the digits given."
            note = f"{note} {verdict_at_states.LEVEL}" if wrong else note
            return right_verdict(claim, note)
        if not rounded.is_in_numbers:
            return None
        wording = Wording(self.setting, claim.source)
        findings = first([wording.of_number(row) for row in off])
        causes = [f"In numbers, with the values of {model.name!r}, to the digits given:"]
        return self._with_example(claim, rounded.target, findings, causes)

    def _mixed(self, claim: Claim, rounded: Rounded) -> EquationVerdict | None:
        """The verdict on an answer that mixes numbers and symbols; None if it is not wrong for
        that."""
        if not rounded.is_mixed or not any(isinstance(x, Number) for x in nodes(claim.node)):
            return None
        text = (
            f"With the values of {self.setting.symbols.model.name!r} the number is right, but one "
            f"term mixes symbols and numbers, which may be right by coincidence: write it all in "
            f"symbols, or all in numbers."
        )
        return self._with_example(claim, rounded.right, (), [text])

    def _zeros(self, claim: Claim) -> str:
        """A sentence on parameters in the answer that are 0 in this model."""
        if not self.setting.zeros:
            return ""
        names = {x.name: sym(x.name) for x in nodes(claim.node) if isinstance(x, Named)}
        found = [str(names[name]) for name in names if name in self.setting.zeros]
        if not found:
            return ""
        model = self.setting.symbols.model.name
        return f"({' and '.join(found)} {'are' if len(found) > 1 else 'is'} 0 in {model!r}.)"

    def _is_constant(self, x: Trig) -> bool:
        """Whether a polynomial contains no coordinate or rate."""
        return all(x.derivative(name).is_zero for name in self.setting.symbols.rates)

    def _explained(self, claim: Claim, yours: Trig, right: Trig) -> tuple[list[Mistake], list[str]]:
        work = Workspace(claim.node, self.point)
        value = self.point.of(right)
        doubt = doubt_about(self.setting, self.targets, claim, work)
        causes = self.thoughts(claim, right, work)
        findings = Explanation(self, claim, right, work, value).findings(bool(causes))
        return findings, [doubt] * bool(doubt) + causes + self._units(yours, right)

    def thoughts(self, claim: Claim, right: Value, work: Workspace) -> list[str]:
        """Sentences on misconceptions that explain a wrong claim."""
        if self.setting.turned is not None:
            return []
        terms, point = None, work.point
        if claim.whole is not None:
            named = (x for x in nodes(claim.whole) if isinstance(x, Named))
            terms = frozenset(point.of(x.value) for x in named)
        bodies = self.bodies if point is self.point else BodiesAtPoint(self.setting, point)
        free = self.free_body and FreeSides(self.free_body, claim.value, claim.target.compute())
        return explaining(
            Subject(bodies, self.targets, claim.target, right, terms, free), work.value
        )

    def _units(self, yours: Trig, right: Trig) -> list[str]:
        """A sentence on a term with wrong units."""
        found = misfit(self.setting, yours, right)
        if found is None:
            return []
        term, unit, expected = found
        text = f"The units do not fit: {quoted(self.setting.form(term))} has {unit_text(unit)}"
        return [f"{text}, where {unit_text(expected)} is needed."]


def _is_zero(target: AskedQuantity) -> bool:
    """Whether a quantity is 0 in every state."""
    right = target.compute()
    return isinstance(right, Trig) and right.is_zero


def _is_right(claim: Claim, value: Callable[[], Value]) -> bool:
    return difference(claim.value, value()).is_zero
