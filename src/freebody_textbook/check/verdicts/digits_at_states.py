"""Answers with rounded numbers compared at states: whether numbers that round to the written ones
are correct at all states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from fractions import Fraction

import numpy as np

from freebody.expressions.grammar.source import Source
from freebody.expressions.nodes import Expression, Number, nodes, replaced
from freebody_textbook.check.states.state_values import AnyArray, choices
from freebody_textbook.check.verdicts.rounded_numbers import half_a_unit

_STEPS = 4
"""Steps of Gauss and Newton; numbers move by their last digit, so that each squares the gap."""
_STATES_PER_NUMBER = 2
"""The least number of states for each number that may move: else any answer could be fitted."""
_FARTHEST = 3.0
"""The largest gap, in all that the digits leave open, from which steps are taken."""

GapOfTree = Callable[[Expression, int], AnyArray]
"""The gap between a tree and the right value at each state, on one of its functions' branches."""


def unrounded(tree: Expression, source: Source, gap: GapOfTree, count: int) -> Expression | None:
    """An expression with each rounded number changed by at most half a unit of its last digit, to
    come closest to the correct value; None if it has no rounded numbers, or too many for the number
    of states."""
    halves = _halves(tree, source)
    if not halves or _STATES_PER_NUMBER * len(halves) > count:
        return None
    branch = _nearest_branch(tree, gap)

    def moved(shares: AnyArray) -> Expression:
        """The expression with its numbers changed by fractions of half a unit."""
        new: dict[Expression, Expression] = {
            x: replace(x, value=x.value + Fraction(float(share)) * half)
            for (x, half), share in zip(halves.items(), shares, strict=True)
        }
        return replaced(tree, new)

    def gap_at(shares: AnyArray) -> AnyArray:
        return _on(branch, moved(shares), gap)

    shares = np.zeros(len(halves))
    for _ in range(_STEPS):
        here = gap_at(shares)
        slopes = np.array([gap_at(shares + row) - here for row in np.eye(len(shares))]).T
        known = np.isfinite(here) & np.isfinite(slopes).all(axis=1)
        reach = _FARTHEST * np.abs(slopes).sum(axis=1)
        if not known.any() or (np.abs(here) > reach)[known].any():
            return None
        shares = _least_squares(slopes[known], -here[known], shares)
    return moved(shares)


def _halves(tree: Expression, source: Source) -> dict[Number, Fraction]:
    """The decimal numbers in an expression, with half a unit of their last digit."""
    rows = ((x, half_a_unit(source[x.span], x.value)) for x in nodes(tree) if isinstance(x, Number))
    return {x: half for x, half in rows if half}


def _nearest_branch(tree: Expression, gap: GapOfTree) -> AnyArray:
    """The branch of the expression's functions that is nearest to the correct value at each
    state."""
    rows = np.abs([gap(tree, k) for k in range(len(choices(tree)))])
    return np.argmin(np.where(np.isfinite(rows), rows, np.inf), axis=0)


def _on(branch: AnyArray, tree: Expression, gap: GapOfTree) -> AnyArray:
    """The difference from the correct value, at each state on its own branch."""
    found = np.full(len(branch), np.nan)
    for k in np.unique(branch):
        found[branch == k] = gap(tree, int(k))[branch == k]
    return found


def _least_squares(slopes: AnyArray, wanted: AnyArray, shares: AnyArray) -> AnyArray:
    """Fractions of half a unit, updated by least squares and limited to ±1."""
    from scipy.optimize import lsq_linear

    scale = np.abs(slopes).max() or 1.0
    target = (wanted + slopes @ shares) / scale
    return np.asarray(lsq_linear(slopes / scale, target, (-1.0, 1.0), tol=1e-15).x)
