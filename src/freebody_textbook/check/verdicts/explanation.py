"""The simplest changes that correct one equation of an answer; and verdicts on quotients, and on
what holds for free motions only: solved accelerations, inverses, cos θ₂ from x and y."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from freebody.errors import FreebodyError
from freebody.expressions.grammar.lexer import tokens
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import Point, Workspace
from freebody_textbook.check.algebra.quotients import Value, pair
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reading.reading import AnswerParser
from freebody_textbook.check.reasons.differences import (
    Difference,
    differences,
    is_too_long,
    polynomial,
    printed,
    terms,
)
from freebody_textbook.check.reasons.free_bodies import FreeMotion
from freebody_textbook.check.reasons.misconceptions import related
from freebody_textbook.check.reasons.misreadings import doubt_about
from freebody_textbook.check.reasons.small_changes import Repair, Repairs
from freebody_textbook.check.spelling.answer_text import AnswerText
from freebody_textbook.check.verdict import EquationVerdict, Mistake
from freebody_textbook.check.verdicts.verdict_sentences import Wording, wrong_verdict
from freebody_textbook.closed_chains.first_kind import MULTIPLIER

if TYPE_CHECKING:
    from freebody_textbook.check.verdicts.equation_verdict import Judge


MOST_FINDINGS = 6
_MISSING, _REVERSE = 1.9, 0.3
"""Cost of a missing term, and what an explanation costs that does not point into the answer
itself."""


@dataclass(frozen=True)
class Explanation:
    """Searches for the mistakes in one claim."""

    judge: Judge
    claim: Claim
    right: Value
    work: Workspace
    value: int

    @property
    def setting(self) -> RightEquations:
        return self.judge.setting

    @cached_property
    def wording(self) -> Wording:
        return Wording(self.setting, self.claim.source)

    @cached_property
    def rows(self) -> Sequence[Difference]:
        """Terms in which the answer differs from the correct one."""
        assert isinstance(self.claim.value, Trig)
        assert isinstance(self.right, Trig)
        return differences(self.setting, self.claim.value, self.right)

    def findings(self, has_cause: bool) -> list[Mistake]:
        """The cheapest explanation: one change, several, or all differing terms."""
        sides = (self.claim.value, self.right)
        if any(isinstance(x, Trig) and is_too_long(x) for x in sides):
            own = self.forward.single()
            return [self.wording.of_repair(own, self.work) if own else self._unexplained()]
        if self._is_reduced:
            return []
        single = self._single()
        if single is not None:
            return [single]
        several = [] if has_cause and len(self.rows) > MOST_FINDINGS else self._several()
        if several and len(several) <= len(self.rows):
            return several
        return first([self.wording.of_difference(row) for row in self.rows])

    @property
    def _is_reduced(self) -> bool:
        """Whether only the correct equation has multipliers; its terms then have many equivalent
        forms, so that no single term counts as missing."""
        found = (
            {name for x in pair(side) for powers, _ in x.terms() for name in powers}
            for side in (self.claim.value, self.right)
        )
        yours, right = (any(name.startswith(MULTIPLIER) for name in names) for names in found)
        return right and not yours

    def _unexplained(self) -> Mistake:
        return Mistake("term", "The answers have too many terms to be compared one by one.")

    # ------------------------------------------------------------ one change
    def _single(self) -> Mistake | None:
        """The cheapest single mistake: a change of the answer, a change of the correct answer that
        gives the user's, or a missing term."""
        own = self.forward.single()
        missing = self._missing_cost()
        best = min(own.cost if own else 99.0, missing)
        if best > 1.0:
            reverse = self._reverse(best - _REVERSE)
            if reverse is not None:
                return self.wording.of_reverse(*reverse)
        if own is not None and own.cost <= missing:
            return self.wording.of_repair(own, self.work)
        if missing < 99.0:
            return self._missing()
        return None

    @cached_property
    def forward(self) -> Repairs:
        """Search for changes of the answer that correct it."""
        return Repairs(self.setting, self.work, self.value, self._related)

    def _related(self, name: str) -> dict[str, Value]:
        """Other quantities of the same kind as one named in the answer, such as H11."""
        single = self.judge.targets.single
        others = related(self.judge.targets, single[name]) if name in single else {}
        return {other: value for other, value in others.items() if value != self.right}

    def _missing_cost(self) -> float:
        """The cost of reporting a single missing term."""
        if len(self.rows) == 1 and self.rows[0].yours == 0:
            return _MISSING
        return 99.0

    def _missing(self) -> Mistake:
        return self.wording.of_difference(self.rows[0])

    def _reverse(self, below: float) -> tuple[Repair, Workspace, Wording] | None:
        """A change of the printed correct answer that gives the user's, at a cost below `below`;
        None if there is none."""
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
                work = Workspace(parser.side(), self.work.point)
            except FreebodyError:
                continue
            if work.value != self.value:  # decimals were rounded
                continue
            repair = Repairs(self.setting, work, self.work.value, lambda name: {}).single(below)
            if repair is not None and repair.cost < below:
                best, below = (repair, work, Wording(self.setting, source)), repair.cost
        return best

    def _printed(self) -> list[str]:
        """Printed forms of the correct answer, as a whole and term by term."""
        if not isinstance(self.right, Trig):
            return [self.setting.form(self.right)]
        if self.right.is_zero:
            return []
        layout = self.setting.layout
        flat = [
            str(printed(layout, self.setting, *row))
            for row in terms(self.setting, self.right).items()
        ]
        return [self.setting.form(self.right), " + ".join(f"({term})" for term in flat)]

    # ------------------------------------------------------------ several changes
    def _several(self) -> list[Mistake]:
        """Two or three changes that together correct the answer."""
        point, insertions = self.judge.point, []
        for row in self.rows:
            if row.instead is None and row.yours == 0:
                x = self._term(row)
                insertions.append((x, point.of(x)))
        found = self.forward.several(insertions)
        return [self._said(repair) for repair in found]

    def _term(self, row: Difference) -> Trig:
        return polynomial(self.setting, row.key, row.right)

    def _said(self, repair: Repair) -> Mistake:
        if repair.kind == "missing" and repair.node is self.work.root:
            row = next(
                row for row in self.rows if self.judge.point.of(self._term(row)) == repair.change
            )
            return self.wording.of_difference(row)
        return self.wording.of_repair(repair, self.work)


def _nothing(name: str) -> None:
    """Return None: printed answers contain no named quantities."""


def first(found: list[Mistake]) -> list[Mistake]:
    """The first few of many mistakes, with a note on how many more there are."""
    if len(found) <= MOST_FINDINGS + 1:
        return found
    more = Mistake("term", f"{len(found) - MOST_FINDINGS} more terms differ.")
    return [*found[:MOST_FINDINGS], more]


_LIKELY = ("sign", "function", "factor", "index", "missing", "extra")


def quotient_verdict(
    judge: Judge, claim: Claim, right: Value, explain: bool
) -> EquationVerdict | None:
    """The verdict on a quotient, or on a claim that holds for free motions; None for other
    answers."""
    yours, point = claim.value, judge.point
    motion = _motion(judge, claim, right)
    if motion is not None and any(map(motion.concerns, (yours, right))):
        yours, right, point = motion.of(yours), motion.of(right), motion.at(point)
    if point is judge.point and isinstance(yours, Trig) and isinstance(right, Trig):
        return None
    findings, causes = _explained(judge, claim, right, point) if explain else ([], [])
    return wrong_verdict(claim, findings, causes, judge.example(yours, right))


def _motion(judge: Judge, claim: Claim, right: Value) -> FreeMotion | None:
    """The motions of a free body for which a claim must hold; None if there is no free body."""
    return judge.free_body and judge.free_body.motion((claim.value, right))


def _explained(
    judge: Judge, claim: Claim, right: Value, point: Point
) -> tuple[list[Mistake], list[str]]:
    """The changes that correct a claim, and sentences on misconceptions."""
    work = Workspace(claim.node, point)
    doubt = doubt_about(judge.setting, judge.targets, claim, work)
    thoughts = [*[doubt] * bool(doubt), *judge.thoughts(claim, right, work)]
    found = _Changes(judge, claim, right, work, point.of(right)).simplest(bool(thoughts))
    if claim.whole is not None and [x.kind for x in found] != ["sign"]:
        whole = Workspace(claim.whole, point)
        other = _Changes(judge, claim, judge.setting.zero, whole, 0).simplest(bool(thoughts))
        found = other if not found or [x.kind for x in other] == ["sign"] else found
    return found, thoughts


class _Changes(Explanation):
    """Searches for changes without a comparison term by term."""

    @property
    def rows(self) -> Sequence[Difference]:
        return ()

    def simplest(self, has_cause: bool) -> list[Mistake]:
        """The fewest changes that correct the answer; empty if none are found, or if the cause is
        known and they are unlikely."""
        single = self._single()
        if single is None:
            return [] if has_cause else self._several()
        says_nothing = single.yours == self.claim.source[self.work.root.span]
        if single.kind == "extra" and says_nothing:
            return []
        return [single] if not has_cause or single.kind in _LIKELY else []
