"""One equation of an answer against the right one: equal, or the simplest explanation of the
difference."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from freebody.derivations.check import coriolis, numeric_example, undriven_joints
from freebody.derivations.check.answer_text import AnswerText
from freebody.derivations.check.answer_tree import Named
from freebody.derivations.check.asked_quantities import Targets
from freebody.derivations.check.claim_reader import Claim
from freebody.derivations.check.differences import (
    Difference,
    differences,
    is_too_long,
    printed,
    terms,
)
from freebody.derivations.check.finite_field import Point, random_point
from freebody.derivations.check.finite_field_tree import Workspace
from freebody.derivations.check.misconceptions import Misconceptions, related
from freebody.derivations.check.misreadings import misread
from freebody.derivations.check.reading import AnswerParser
from freebody.derivations.check.repairs import Repair, Repairs
from freebody.derivations.check.right_equations import RightEquations
from freebody.derivations.check.rounded_numbers import MEASURED, Rounded
from freebody.derivations.check.units import misfit, unit_text
from freebody.derivations.check.verdict import EquationVerdict, Mistake
from freebody.derivations.check.verdict_sentences import Wording, quoted
from freebody.derivations.check.vocabulary import Vocabulary
from freebody.derivations.expressions.nodes import nodes
from freebody.derivations.expressions.printed_names import sym
from freebody.derivations.grammar.lexer import tokens
from freebody.errors import FreebodyError
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig

MOST_FINDINGS = 6
_MISSING, _REVERSE = 1.9, 0.3
"""Cost of a missing term, and what an explanation costs that does not point into the answer
itself."""


@dataclass(frozen=True)
class Judge:
    """Compares claims with the right values of a model."""

    setting: RightEquations
    targets: Targets
    claims: Sequence[Claim] = ()
    """All of the answer."""

    @cached_property
    def point(self) -> Point:
        """A random point of the ring."""
        return random_point(self.setting.ring)

    @cached_property
    def vocabulary(self) -> Vocabulary:
        """Names for reading printed equations."""
        return Vocabulary(self.setting)

    def verdict(self, claim: Claim, explain: bool = True) -> EquationVerdict:
        """The verdict on one claim, with its mistakes named or only with an example."""
        right = claim.target.compute()
        title = claim.target.title
        if claim.value == right:
            return EquationVerdict(claim.label, title, True, note=self._zeros(claim))
        if claim.target.family in ("V", "L", "Vi") and self._is_constant(claim.value - right):
            note = (
                f"It differs by the constant {self.setting.form(claim.value - right)}: the zero "
                f"level of V is arbitrary."
            )
            return EquationVerdict(claim.label, title, True, note=note)
        return (
            self._other_ways(claim, right)
            or self._in_numbers(claim, right)
            or self._wrong(claim, right, explain)
        )

    def _wrong(self, claim: Claim, right: Trig, explain: bool) -> EquationVerdict:
        findings, causes = self._explained(claim, right) if explain else ([], [])
        hint = coriolis.advice(self.setting, claim, self.claims)
        causes = [*causes, *[hint] * bool(hint), *self._unsymmetric(claim)]
        return self._with_example(claim, right, findings, causes)

    def _unsymmetric(self, claim: Claim) -> list[str]:
        """A sentence about an entry of the mass matrix that the answer gives in two ways."""
        mirrored = claim.target.index[::-1]
        if claim.target.family != "M" or mirrored == claim.target.index:
            return []
        return [
            f"The mass matrix is symmetric, so {claim.label} = {other.label}."
            for other in self.claims
            if other.target.family == "M"
            and other.target.index == mirrored
            and other.value != claim.value
        ][:1]

    def _with_example(
        self, claim: Claim, right: Trig, findings: Sequence[Mistake], causes: Sequence[str]
    ) -> EquationVerdict:
        shown = numeric_example.example(self.setting, claim.value, right)
        text = numeric_example.sentence(shown) if shown else ""
        return EquationVerdict(
            claim.label, claim.target.title, False, tuple(findings), tuple(causes), shown, text
        )

    def _other_ways(self, claim: Claim, right: Trig) -> EquationVerdict | None:
        """The verdict on what is right though it is not the same: torques of passive joints, other
        matrices C."""
        note = self.coriolis.get(claim.target.index, "") if claim.target.family == "C" else ""
        if claim.target.idle and (
            claim.value.is_zero or undriven_joints.is_same(self.setting, claim.value, right)
        ):
            joint = claim.target.index[0]
            note = f"Joint {joint} is passive: {sym(f'tau{joint}')} = 0."
        return EquationVerdict(claim.label, claim.target.title, True, note=note) if note else None

    @cached_property
    def coriolis(self) -> Mapping[tuple[int, ...], str]:
        """What is to be said of entries of another matrix C than Christoffel's."""
        return coriolis.notes(self.setting, self.claims)

    # ------------------------------------------------------------ numbers
    def _in_numbers(self, claim: Claim, right: Trig) -> EquationVerdict | None:
        """The verdict on an answer in numbers, or of a model that has measured ones; None of an
        answer in symbols."""
        model = self.setting.symbols.model
        values = {name: value for name, value in model.parameters.items() if value is not None}
        decimal = self.setting.order.decimal
        rounded = Rounded(self.setting, claim.source, claim.node, claim.value, right, values)
        if not decimal and not rounded.applies:
            return self._mixed(claim, rounded) if values else None
        wrong = rounded.wrong(MEASURED) if decimal else rounded.wrong()
        if wrong is None:
            return None
        if not wrong:
            note = "Numbers were compared to three digits."
            if rounded.applies:
                note = f"In numbers, with the values of {model.name!r}, to the digits given."
            return EquationVerdict(claim.label, claim.target.title, True, note=note)
        if not rounded.is_in_numbers:
            return None
        wording = Wording(self.setting, claim.source)
        findings = _first([wording.of_number(row) for row in wrong])
        causes = [f"In numbers, with the values of {model.name!r}, to the digits given:"]
        return self._with_example(claim, rounded.target, findings, causes)

    def _mixed(self, claim: Claim, rounded: Rounded) -> EquationVerdict | None:
        """The verdict on numbers among symbols."""
        if not rounded.is_mixed:
            return None
        text = (
            f"With the values of {self.setting.symbols.model.name!r} the number is right, but one "
            f"term mixes symbols and numbers, which may be right by coincidence: write it all in "
            f"symbols, or all in numbers."
        )
        return self._with_example(claim, rounded.right, (), [text])

    def _zeros(self, claim: Claim) -> str:
        """A sentence about parameters in the answer that are 0 in this model."""
        if not self.setting.zeros:
            return ""
        names = {x.name: sym(x.name) for x in nodes(claim.node) if isinstance(x, Named)}
        found = [str(names[name]) for name in names if name in self.setting.zeros]
        if not found:
            return ""
        model = self.setting.symbols.model.name
        return f"({' and '.join(found)} {'are' if len(found) > 1 else 'is'} 0 in {model!r}.)"

    def _is_constant(self, x: Trig) -> bool:
        """Whether no coordinate or rate occurs."""
        return all(x.derivative(name).is_zero for name in self.setting.symbols.rates)

    def _explained(self, claim: Claim, right: Trig) -> tuple[list[Mistake], list[str]]:
        work = Workspace(claim.node, self.point)
        value = self.point.of(right)
        finding, doubt = misread(self.setting, self.targets, claim, work, value)
        if finding is not None:
            return [finding], []
        causes = self._thoughts(claim, right, work.value)
        findings = _Explanation(self, claim, right, work, value).findings(bool(causes))
        return findings, [doubt] * bool(doubt) + causes + self._units(claim.value, right)

    def _thoughts(self, claim: Claim, right: Trig, value: int) -> list[str]:
        """What may have been thought; thoughts are told of the model's own coordinates only."""
        if self.setting.turned is not None:
            return []
        thoughts = Misconceptions(self.setting, self.targets, claim.target, right, self.point)
        return thoughts.explaining(value)

    def _units(self, yours: Trig, right: Trig) -> list[str]:
        """A sentence about a term in the wrong units."""
        found = misfit(self.setting, yours, right)
        if found is None:
            return []
        term, unit, expected = found
        text = f"The units do not fit: {quoted(self.setting.form(term))} has {unit_text(unit)}"
        return [f"{text}, where {unit_text(expected)} is needed."]


@dataclass(frozen=True)
class _Explanation:
    """The search for what is wrong with one claim."""

    judge: Judge
    claim: Claim
    right: Trig
    work: Workspace
    value: int

    @property
    def setting(self) -> RightEquations:
        return self.judge.setting

    @cached_property
    def wording(self) -> Wording:
        return Wording(self.setting, self.claim.source)

    @cached_property
    def rows(self) -> list[Difference]:
        """Terms that differ."""
        return differences(self.setting, self.claim.value, self.right)

    def findings(self, has_cause: bool) -> list[Mistake]:
        """The cheapest explanation: one change, several, or all terms that differ."""
        if is_too_long(self.claim.value) or is_too_long(self.right):
            own = self.forward.single()
            return [self.wording.of_repair(own, self.work) if own else self._unexplained()]
        single = self._single()
        if single is not None:
            return [single]
        several = [] if has_cause and len(self.rows) > MOST_FINDINGS else self._several()
        if several and len(several) <= len(self.rows):
            return several
        return _first([self.wording.of_difference(row) for row in self.rows])

    def _unexplained(self) -> Mistake:
        return Mistake("term", "The answers have too many terms to be compared one by one.")

    # ------------------------------------------------------------ one change
    def _single(self) -> Mistake | None:
        """The cheapest of: a change of the answer, a change of the right answer that gives it, a
        missing term."""
        own = self.forward.single()
        missing = self._missing_cost()
        best = min(own.cost if own else 99.0, missing)
        if best > 1.0:
            reverse = self._reverse()
            if reverse is not None and reverse[0].cost + _REVERSE < best:
                repair, work, wording = reverse
                return self.wording.of_reverse(repair, work, wording)
        if own is not None and own.cost <= missing:
            return self.wording.of_repair(own, self.work)
        if missing < 99.0:
            return self._missing()
        return None

    @cached_property
    def forward(self) -> Repairs:
        """Changes of the answer."""
        return Repairs(self.setting, self.work, self.value, self._related)

    def _related(self, name: str) -> dict[str, Trig]:
        """The other entries of the family of a quantity that stands in the answer, such as H11."""
        single = self.judge.targets.single
        others = related(self.judge.targets, single[name]) if name in single else {}
        return {other: value for other, value in others.items() if value != self.right}

    def _missing_cost(self) -> float:
        """The cost of saying that one term is missing."""
        if len(self.rows) == 1 and self.rows[0].yours == 0:
            return _MISSING
        return 99.0

    def _missing(self) -> Mistake:
        return self.wording.of_difference(self.rows[0])

    def _reverse(self) -> tuple[Repair, Workspace, Wording] | None:
        """A change of the right answer, as it prints, that gives the user's."""
        best = None
        for text in self._printed():
            source = AnswerText.of(text)
            try:
                parser = AnswerParser(
                    source,
                    tokens(source, self.judge.vocabulary)[:-1],
                    self.judge.vocabulary,
                    _nothing,
                )
                work = Workspace(parser.side(), self.judge.point)
            except FreebodyError:
                continue
            if work.value != self.value:  # decimals were rounded
                continue
            repair = Repairs(self.setting, work, self.work.value, lambda name: {}).single()
            if repair is not None and (best is None or repair.cost < best[0].cost):
                best = repair, work, Wording(self.setting, source)
        return best

    def _printed(self) -> list[str]:
        """The right answer as it prints, and term by term."""
        layout = self.setting.layout
        flat = [
            str(printed(layout, self.setting, *row))
            for row in terms(self.setting, self.right).items()
        ]
        return [self.setting.form(self.right), " + ".join(f"({term})" for term in flat)]

    # ------------------------------------------------------------ several changes
    def _several(self) -> list[Mistake]:
        """Two or three changes of the answer."""
        point, insertions = self.judge.point, []
        for row in self.rows:
            if row.instead is None and row.yours == 0:
                x = self._term(row)
                insertions.append((x, point.of(x)))
        found = self.forward.several(insertions)
        return [self._said(repair) for repair in found]

    def _term(self, row: Difference) -> Trig:
        x = self.setting.ring.polynomial([(dict(row.key[0]), row.right)])
        for function, argument, exponent in row.key[1]:
            angle = sum((self.setting.ring[name] * k for name, k in argument), self.setting.zero)
            for _ in range(exponent):
                x = x * (angle.sin() if function == "sin" else angle.cos())
        return x

    def _said(self, repair: Repair) -> Mistake:
        if repair.kind == "missing" and repair.node is self.work.root:
            row = next(
                row for row in self.rows if self.judge.point.of(self._term(row)) == repair.change
            )
            return self.wording.of_difference(row)
        return self.wording.of_repair(repair, self.work)


def _nothing(name: str) -> None:
    """Printed answers hold no quantities by name."""


def _first(found: list[Mistake]) -> list[Mistake]:
    """The first of many, and how many more there are."""
    if len(found) <= MOST_FINDINGS + 1:
        return found
    more = Mistake("term", f"{len(found) - MOST_FINDINGS} more terms differ.")
    return [*found[:MOST_FINDINGS], more]
