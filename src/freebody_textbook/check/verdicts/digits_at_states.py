"""Answers in rounded numbers that are compared at states: whether some numbers that round to those
written are right at all of them."""

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
    """A tree with the numbers, each within half a unit of its last digit, that come closest to the
    right value; None where it has no rounded numbers, or too many for so many states."""
    halves = _halves(tree, source)
    if not halves or _STATES_PER_NUMBER * len(halves) > count:
        return None
    branch = _nearest_branch(tree, gap)

    def moved(shares: AnyArray) -> Expression:
        """The tree with its numbers moved by shares of half a unit."""
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
    """The numbers with digits behind the point, and half a unit of the last one."""
    rows = ((x, half_a_unit(source[x.span], x.value)) for x in nodes(tree) if isinstance(x, Number))
    return {x: half for x, half in rows if half}


def _nearest_branch(tree: Expression, gap: GapOfTree) -> AnyArray:
    """The branch of the tree's functions that is nearest at each state."""
    rows = np.abs([gap(tree, k) for k in range(len(choices(tree)))])
    return np.argmin(np.where(np.isfinite(rows), rows, np.inf), axis=0)


def _on(branch: AnyArray, tree: Expression, gap: GapOfTree) -> AnyArray:
    """The gap of a tree, at each state on its own branch."""
    found = np.full(len(branch), np.nan)
    for k in np.unique(branch):
        found[branch == k] = gap(tree, int(k))[branch == k]
    return found


def _least_squares(slopes: AnyArray, wanted: AnyArray, shares: AnyArray) -> AnyArray:
    """The shares after the change that comes closest to what is wanted, none beyond half a unit."""
    from scipy.optimize import lsq_linear

    scale = np.abs(slopes).max() or 1.0
    target = (wanted + slopes @ shares) / scale
    return np.asarray(lsq_linear(slopes / scale, target, (-1.0, 1.0), tol=1e-15).x)
