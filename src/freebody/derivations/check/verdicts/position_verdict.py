"""The verdict on a coordinate told by inverse functions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import flint

from freebody.derivations.check.algebra.answer_tree import Named
from freebody.derivations.check.algebra.finite_field import Point
from freebody.derivations.check.algebra.finite_field_tree import Workspace
from freebody.derivations.check.asked.inverse_functions import (
    BITS,
    MOST_BRANCHES,
    POSITIONS,
    BranchesFound,
    Branching,
    functions_of,
    swapped,
)
from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.derivations.check.reading.claim import Claim
from freebody.derivations.check.reasons.small_changes import Repair, SmallChanges
from freebody.derivations.check.verdict import EquationVerdict, Mistake
from freebody.derivations.check.verdicts.verdict_sentences import Wording
from freebody.derivations.expressions.nodes import Expression, nodes, replaced
from freebody.scalars.trig import Trig

_OTHER_POSTURE = (
    "It belongs to another posture than the line before: with these two coordinates the tip is "
    "elsewhere."
)
_TRIED = 6
"""Positions at which changes are tried."""
_MOST_NODES = 150
"""Pieces of an answer up to which changes are tried."""
_OTHER_VALUES = {
    "arccos": "arccos and −arccos are the two postures that reach a point, elbow up and elbow down",
    "sqrt": "the two signs of the root are the two postures, elbow up and elbow down",
    "arcsin": "arcsin is a right angle at most, and π − arcsin has the same sine",
    "arctan": "arctan loses the quadrant, which atan2(y, x) has",
}


def verdict(
    setting: RightEquations, claim: Claim, claims: Sequence[Claim], explain: bool
) -> EquationVerdict:
    """Whether the coordinate follows, at positions of the robot drawn at random, and for the same
    posture as in the answer's claims before."""
    if len(functions_of(claim.node)) > MOST_BRANCHES:
        claim.source.fail(
            f"at most {MOST_BRANCHES} inverse functions are read in an equation", claim.node.span
        )
    branching = _branching(setting, claim)
    title, where = claim.target.title, f"Compared in numbers at {POSITIONS} positions"
    with flint.ctx.workprec(BITS):
        found = branching.compared(claim.node)
        if found is not None and not _shared(setting, claim, claims, found.right):
            return EquationVerdict(claim.label, title, False, (), (_OTHER_POSTURE,))
        if found is not None:
            return EquationVerdict(claim.label, title, True, note=f"{where}{_note(found)}")
        mistake = next(_mistakes(setting, claim, branching), None) if explain else None
    told = f"{where}, on every branch."
    if isinstance(mistake, Mistake):
        return EquationVerdict(claim.label, title, False, (mistake,), (told,))
    return EquationVerdict(claim.label, title, False, (), (mistake, told) if mistake else (told,))


def _branching(setting: RightEquations, claim: Claim) -> Branching:
    left = claim.whole
    assert left is not None
    given = {k: x for k, x in setting.symbols.model.parameters.items() if x is not None}
    written = {
        name
        for x in nodes(claim.node)
        if isinstance(x, Named) and isinstance(x.value, Trig) and len(x.value) == 1
        for powers, _ in x.value.terms()
        for name in powers
    }
    values = given if not written & given.keys() else {}
    return Branching(setting, left, _is_angle(setting, left), values)


def _shared(
    setting: RightEquations, claim: Claim, claims: Sequence[Claim], right: frozenset[int]
) -> frozenset[int]:
    """The positions at which a claim and those before it are right as they stand."""
    for other in claims[: claims.index(claim)]:
        if other.target.family == "position" and other.label != claim.label:
            found = _branching(setting, other).compared(other.node)
            right = right & found.right if found else right
    return right


def _is_angle(setting: RightEquations, left: Expression) -> bool:
    return isinstance(left, Named) and any(
        isinstance(left.value, Trig) and left.value == setting.ring[x] for x in setting.ring.angles
    )


def _note(found: BranchesFound) -> str:
    if not found.others:
        return "."
    others = ", and ".join(dict.fromkeys(_OTHER_VALUES[x] for x in found.others))
    return f": right as it stands at {len(found.right)}, at the others on another branch; {others}."


def _mistakes(
    setting: RightEquations, claim: Claim, branching: Branching
) -> Iterator[Mistake | str]:
    """What makes it right, the likeliest first."""
    for text, node, new in swapped(claim.node):
        if branching.compared(replaced(claim.node, {node: new}), _TRIED):
            yield text
    work = Workspace(claim.node, _Nowhere({}, {}))
    if len(work.values) > _MOST_NODES:
        return
    changes = SmallChanges(setting, work, 0, lambda name: {})
    for repair in sorted(changes.discrete(), key=lambda row: row.cost):
        if _can_be_said(repair) and branching.compared(
            replaced(claim.node, {repair.node: repair.new}), _TRIED
        ):
            yield Wording(setting, claim.source).of_repair(repair, work)


def _can_be_said(repair: Repair) -> bool:
    """Whether a change prints: of what holds functions only a sign does."""
    return repair.kind == "sign" or not functions_of(repair.node)


class _Nowhere(Point):
    """No position: only what a tree is made of is asked for."""

    def at(self, node: Expression, known: object = None) -> int:
        return 0
