"""The verdict on what is no polynomial, or holds for free motions only: solved accelerations,
inverses, cos θ₂ from x and y."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import Point
from freebody_textbook.check.algebra.finite_field_tree import Workspace
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reasons.differences import Difference
from freebody_textbook.check.reasons.free_bodies import FreeMotion
from freebody_textbook.check.reasons.misreadings import doubt_about
from freebody_textbook.check.verdict import EquationVerdict, Mistake
from freebody_textbook.check.verdicts import numeric_example
from freebody_textbook.check.verdicts.explanation import Explanation

if TYPE_CHECKING:
    from freebody_textbook.check.verdicts.equation_verdict import Judge

_LIKELY = ("sign", "function", "factor", "index", "missing", "extra")


def verdict(judge: Judge, claim: Claim, right: Value, explain: bool) -> EquationVerdict | None:
    """The verdict on a quotient, or on what holds for free motions; None of any other answer."""
    yours, title, point = claim.value, claim.target.title, judge.point
    motion = _motion(judge, claim, right)
    if motion is not None and any(map(motion.concerns, (yours, right))):
        yours, right, point = motion.of(yours), motion.of(right), motion.at(point)
    if point is judge.point and isinstance(yours, Trig) and isinstance(right, Trig):
        return None
    findings, causes = _explained(judge, claim, right, point) if explain else ([], [])
    shown = judge.example(yours, right)
    text = numeric_example.sentence(shown) if shown else ""
    return EquationVerdict(claim.label, title, False, tuple(findings), tuple(causes), shown, text)


def _motion(judge: Judge, claim: Claim, right: Value) -> FreeMotion | None:
    """The motions of a free body for which a claim is to hold."""
    return judge.free_body and judge.free_body.motion((claim.value, right))


def _explained(
    judge: Judge, claim: Claim, right: Value, point: Point
) -> tuple[list[Mistake], list[str]]:
    """The changes that make it right, and what may have been thought."""
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
    """The search without a comparison term by term."""

    @property
    def rows(self) -> Sequence[Difference]:
        return ()

    def simplest(self, has_cause: bool) -> list[Mistake]:
        """One change or several that make it right; none where none is found, and where the cause
        is known only a likely one."""
        single = self._single()
        if single is None:
            return [] if has_cause else self._several()
        says_nothing = single.yours == self.claim.source[self.work.root.span]
        if single.kind == "extra" and says_nothing:
            return []
        return [single] if not has_cause or single.kind in _LIKELY else []
