"""The verdict on what the loops of a closed chain give: compared at motions that close them."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import flint

from freebody.derivations.check.algebra.answer_tree import Named
from freebody.derivations.check.algebra.finite_field_tree import Workspace
from freebody.derivations.check.algebra.quotients import Value, difference, pair
from freebody.derivations.check.asked.closed_motions import MOTIONS, ClosedMotions
from freebody.derivations.check.asked.inverse_functions import BITS, NEAR, RandomPosition, ball
from freebody.derivations.check.asked.quantity import LONG
from freebody.derivations.check.reading.claim import Claim
from freebody.derivations.check.reasons.small_changes import SmallChanges
from freebody.derivations.check.verdict import EquationVerdict, Example, Mistake
from freebody.derivations.check.verdicts.numeric_example import sentence
from freebody.derivations.check.verdicts.verdict_sentences import Wording
from freebody.derivations.closed_chains.linear import Ratio
from freebody.derivations.expressions.nodes import Expression, nodes, replaced
from freebody.derivations.polynomials.typical_values import occurs

if TYPE_CHECKING:
    from freebody.derivations.check.verdicts.equation_verdict import Judge

_OF_LOOPS = frozenset(
    ("closed", "solved", "identity", "derivative", "of body", "q", "tip", "tip_d", "tip_dd")
    + ("N", "drift", "closing", "applied", "parallel", "tau")
)
"""Families that loops may give in another form."""
_BY_LOOPS = ("closed", "solved", "q", "drift", "N")
"""Those that only loops can make right."""
_HOLDS = f"It holds where the loops are closed: compared in numbers at {MOTIONS} motions."
_HELD = f"It holds in equilibrium: compared in numbers at {MOTIONS} positions."
_MOST_NODES = 150
"""Pieces of an answer up to which changes are tried."""


def verdict(judge: Judge, claim: Claim, right: Value, explain: bool) -> EquationVerdict | None:
    """The verdict where the loops make an answer right, and on what is solved by them; None of any
    other answer, and of one that says that 0 is 0."""
    if judge.setting.system is None:
        return None
    if claim.target.family == LONG:
        return _of_long(judge, claim, explain)
    says_nothing = claim.value.is_zero and claim.target.family != "of body"
    if claim.target.family not in _OF_LOOPS or says_nothing:
        return None
    gap = difference(claim.value, right)
    given = judge.setting.symbols.model.parameters
    has_symbols = any(name in given for powers, _ in gap.terms() for name in powers)
    motions = judge.closed_motions[not has_symbols]
    still = judge.numbers.is_still(claim.node.span) and not judge.numbers.has_motion(claim)
    for some, note in ((motions, _HOLDS), *[(judge.closed_positions, _HELD)] * still):
        if some.all_have(lambda place: place.at(claim.node, {}) - place.of(right)):
            return EquationVerdict(claim.label, claim.target.title, True, note=note)
    if claim.whole is not None and isinstance(claim.value, Ratio):
        return _of_long(judge, replace(claim, node=claim.whole), explain)
    place = motions.place(0)
    if claim.target.family not in _BY_LOOPS or place is None:
        return None
    is_solved = claim.target.family != "closed"
    with flint.ctx.workprec(BITS):
        sought = right if is_solved else judge.setting.zero
        mistake = _mistake(judge, claim, sought, motions) if explain else None
        shown = _example(claim, sought, place)
    if mistake is None and not is_solved:
        return None
    findings = (mistake,) if mistake else ()
    text = sentence(shown)
    return EquationVerdict(claim.label, claim.target.title, False, findings, (), shown, text)


def _of_long(judge: Judge, claim: Claim, explain: bool) -> EquationVerdict:
    """The verdict on an equation whose sides are compared in numbers, and are not multiplied
    out."""
    motions = judge.closed_motions[0]
    if motions.place(0) is None:
        claim.source.fail("multiplied out, this has too many terms to compare", claim.node.span)
    right = motions.all_have(lambda place: place.at(claim.node, {}))
    mistake = None
    if not right and explain:
        mistake = _mistake(judge, claim, judge.setting.zero, motions)
    findings = (mistake,) if mistake else ()
    note = _HOLDS if right else ""
    return EquationVerdict(claim.label, claim.target.title, right, findings, note=note)


def _mistake(judge: Judge, claim: Claim, right: Value, motions: ClosedMotions) -> Mistake | None:
    """The likeliest change that makes it right at all motions."""
    work, first = Workspace(claim.node, judge.point), motions.place(0)
    if first is None or len(work.values) > _MOST_NODES:
        return None
    changes = SmallChanges(judge.setting, work, 0, lambda name: {})
    with flint.ctx.workprec(BITS):
        known: dict[Expression, Any] = {
            x: first.of(x.value) for x in nodes(claim.node) if isinstance(x, Named)
        }
        sought = first.of(right)

    def fits(node: Expression) -> bool:
        """Most changes are out at the first motion, whose values of long polynomials are kept."""
        try:
            with flint.ctx.workprec(BITS):
                if not abs(first.at(node, {}, known) - sought) < ball(NEAR):
                    return False
            return motions.all_have(lambda place: place.at(node, {}) - place.of(right))
        except ZeroDivisionError:
            return False

    for repair in sorted(changes.discrete(), key=lambda row: row.cost):
        says_nothing = repair.kind == "extra" and repair.node is work.root
        if not says_nothing and fits(replaced(claim.node, {repair.node: repair.new})):
            return Wording(judge.setting, claim.source).of_repair(repair, work)
    return None


def _example(claim: Claim, right: Value, place: RandomPosition) -> Example:
    """One of the motions, and both results."""
    pieces = (*pair(claim.value), *pair(right))
    values = {
        name: round(float(x), 4)
        for name, x in place.values.items()
        if any(occurs(name, piece) for piece in pieces)
    }
    return Example(values, float(place.of(claim.value)), float(place.of(right)))
