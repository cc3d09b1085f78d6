"""The verdict on what is no polynomial, or holds for free motions only: solved accelerations,
inverses, cos θ₂ from x and y."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from freebody.derivations.check import numeric_example
from freebody.derivations.check.claim_reader import Claim
from freebody.derivations.check.differences import Difference
from freebody.derivations.check.explanation import Explanation
from freebody.derivations.check.finite_field import Point
from freebody.derivations.check.finite_field_tree import Workspace
from freebody.derivations.check.quotients import Value, difference
from freebody.derivations.check.verdict import EquationVerdict, Mistake
from freebody.derivations.closed_chains.linear import Ratio
from freebody.errors import listed
from freebody.scalars.trig import Trig

if TYPE_CHECKING:
    from freebody.derivations.check.equation_verdict import Judge

_SOLVED = ("solved", "q")
_MAY_BE_FREE = (*_SOLVED, "tau", "identity")
"""Quantities into which the equation of a passive joint may have been put."""


def verdict(judge: Judge, claim: Claim, right: Value, explain: bool) -> EquationVerdict | None:
    """The verdict on a quotient, or on what holds for free motions; None of any other answer."""
    yours, title, point = claim.value, claim.target.title, judge.point
    motion = judge.free_motion if claim.target.family in _MAY_BE_FREE else None
    if motion is not None and any(map(motion.concerns, (yours, right))):
        put, own = motion.of(yours), motion.of(right)
        if difference(put, own).is_zero:
            numbers = listed([str(k) for k in judge.targets.passive])
            joints = f"joint{'s' if len(judge.targets.passive) > 1 else ''} {numbers}"
            note = f"It holds with what follows from no drive at {joints}."
            return EquationVerdict(claim.label, title, True, note=note)
        if claim.target.family in _SOLVED or isinstance(yours, Ratio):
            yours, right, point = put, own, motion.at(point)
    elif isinstance(yours, Trig) and isinstance(right, Trig):
        return None
    if point is judge.point and isinstance(yours, Trig) and isinstance(right, Trig):
        return None
    findings, causes = _explained(judge, claim, right, point) if explain else ([], [])
    shown = numeric_example.example(judge.setting, yours, right)
    text = numeric_example.sentence(shown) if shown else ""
    return EquationVerdict(claim.label, title, False, tuple(findings), tuple(causes), shown, text)


def _explained(
    judge: Judge, claim: Claim, right: Value, point: Point
) -> tuple[list[Mistake], list[str]]:
    """The changes that make it right, and what may have been thought."""
    work = Workspace(claim.node, point)
    thoughts = [x for x, thought in claim.target.thoughts if point.of(thought()) == work.value]
    findings = _Changes(judge, claim, right, work, point.of(right)).simplest()
    if not findings and claim.whole is not None:
        whole = Workspace(claim.whole, point)
        findings = _Changes(judge, claim, judge.setting.zero, whole, 0).simplest()
    return findings, thoughts


class _Changes(Explanation):
    """The search without a comparison term by term."""

    @property
    def rows(self) -> Sequence[Difference]:
        return ()

    def simplest(self) -> list[Mistake]:
        """One change or several that make it right; none where none is found."""
        single = self._single()
        return [single] if single is not None else self._several()
