"""Sign conventions that an answer may choose: of loop equations, Φ = 0 or -Φ = 0, and of
multipliers, τ = M q̈ + … ± Φ_qᵀ λ."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Sequence, Set
from dataclasses import replace

from freebody.errors import listed
from freebody.expressions.nodes import Expression, Negative, Sum, nodes
from freebody.expressions.printed_names import sym
from freebody_textbook.check.algebra.quotients import Named, generator
from freebody_textbook.check.asked.right_equations import RightEquations, loop_equation
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.verdict import EquationVerdict
from freebody_textbook.closed_chains.multiplier_equations import multiplier_names

_LOOPS = "{} {} the opposite sign to that in the robot's file; both are right."
_LOAD = "F is a force on the mechanism, from outside."
_MULTIPLIERS = "The multipliers have the opposite sign, τ = M q̈ + … − Φ_qᵀ λ; both are right."


def others(
    setting: RightEquations, wrong: Sequence[Claim], written: str
) -> Iterator[frozenset[str]]:
    """Sets of names whose sign an answer with wrong claims may have reversed: an external force;
    the wrong loop equations with their multipliers; all multipliers."""
    if setting.system is None or not wrong:
        return
    numbers = {x.target.index[0] for x in wrong if x.target.kind.is_of_loop_equation}
    rows = frozenset(map(loop_equation, numbers))
    is_told = any(x in written for x in ("λ", "lam"))
    names = frozenset(_multipliers(setting) if is_told else ())
    own = names.intersection(x for x, row in _multipliers(setting).items() if row in rows)
    yield from [frozenset(setting.loads)] * bool(setting.loads)
    yield from filter(None, dict.fromkeys((rows | own, names, rows | (names - own), rows)))


def _multipliers(setting: RightEquations) -> dict[str, str]:
    """Names of the multipliers, each with its loop equation."""
    assert setting.system is not None
    names = enumerate(multiplier_names(setting.system.loops), 1)
    return {name: loop_equation(i) for i, name in names}


def are_meant(opposed: Set[str], loads: Collection[str], claims: Sequence[Claim]) -> bool:
    """Whether reversed signs that make claims correct are a convention rather than a mistake: at
    least two signs, or that of an external force."""
    return not opposed.isdisjoint(loads) or sum(_signs(opposed, x) for x in claims) > 1


def _signs(opposed: Set[str], claim: Claim) -> int:
    """The number of terms in a claim with reversed sign."""
    terms = list(_terms(claim, claim.node if claim.whole is None else claim.whole))
    if claim.target.kind.is_of_loop_equation:
        return len(terms)
    return sum(any(_is_opposed(opposed, x) for x in nodes(term)) for term in terms)


def _terms(claim: Claim, node: Expression) -> Iterator[Expression]:
    """The terms of a sum; a bracket with one sign in front counts once."""
    if isinstance(node, Sum):
        for term in node.terms:
            yield from _terms(claim, term)
    elif isinstance(node, Negative) and node.span == node.operand.span:  # the right of = left
        yield from _terms(claim, node.operand)
    else:
        yield node


def _is_opposed(opposed: Set[str], node: Expression) -> bool:
    """Whether a symbol is a multiplier with reversed sign."""
    return isinstance(node, Named) and generator(node.value) in opposed


def noted(
    setting: RightEquations, before: Sequence[EquationVerdict], after: Sequence[EquationVerdict]
) -> list[EquationVerdict]:
    """The verdicts under an answer's own sign conventions, with notes where they matter."""
    note = _told(setting)
    return [
        replace(new, note=f"{note} {new.note}".strip()) if new.equal and not old.equal else new
        for old, new in zip(before, after, strict=True)
    ]


def _told(setting: RightEquations) -> str:
    """Sentences on the sign conventions that are reversed in an answer."""
    of_loops = _multipliers(setting)
    rows = [row for row in of_loops.values() if row in setting.opposed]
    have = "have" if len(rows) > 1 else "has"
    told = [_LOOPS.format(listed([str(sym(x)) for x in rows]), have)] * bool(rows)
    multipliers = setting.opposed & of_loops.keys()
    own = {name for name, row in of_loops.items() if row in rows}
    told += [_MULTIPLIERS] * (multipliers not in (own, set()))
    told += [_LOAD] * (not setting.opposed.isdisjoint(setting.loads))
    return " ".join(told)
