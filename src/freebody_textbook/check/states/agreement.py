"""Whether two sides agree at all states: as they stand, on another branch of inverse functions, in
one assembly of a closed chain, or up to a constant."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from types import MappingProxyType

import numpy as np

from freebody.expressions.nodes import Expression, Negative, Sum
from freebody.lazy import cached_property
from freebody_textbook.check.asked.quantity import ActingLoads
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.states.admissible_states import AdmissibleStates, StateSampler
from freebody_textbook.check.states.state_values import (
    AnyArray,
    Known,
    Running,
    choices,
    second_values,
)

_LARGEST = 1e5
"""The most by which terms may be larger than what is compared."""

_DrawnFor = tuple[bool, bool, frozenset[tuple[str, float]], ActingLoads]


@dataclass(frozen=True, eq=False)
class Equal:
    """How two sides must agree: equal, up to whole turns, or up to a constant."""

    as_angles: bool = False
    """Whether they may differ by whole turns."""
    to_a_constant: bool = False
    """Whether they may differ by a number for each set of parameters."""

    def reduced(self, gap: Running, states: AdmissibleStates) -> Running:
        """The difference reduced by what this kind of equality ignores."""
        if self.as_angles:
            return replace(gap, value=gap.value - 2 * np.pi * np.round(gap.value / (2 * np.pi)))
        if self.to_a_constant:
            level = np.zeros(states.count)
            for k in np.unique(states.parameters):
                own = states.parameters == k
                level[own] = gap.value[own][0]
            return replace(gap, value=gap.value - level)
        return gap


@dataclass(frozen=True, eq=False)
class Agreement:
    """The states at which two sides are equal as they stand, and those at which they are on some
    branch of their inverse functions; others: the functions whose second value is needed
    somewhere."""

    states: AdmissibleStates
    right: AnyArray
    possible: AnyArray
    others: tuple[str, ...]
    gap: Running
    """The rest of the difference as it stands."""

    @property
    def is_everywhere(self) -> bool:
        """Whether the two sides are equal at all states as they stand."""
        return bool(self.right.all())

    @property
    def is_with_branches(self) -> bool:
        """Whether second values of inverse functions make the two sides equal everywhere, and they
        are equal as they stand on the home position's branch, or somewhere if no state is on it."""
        home = self.states.is_home
        own = self.right[home] if home.any() else self.right
        return bool(self.others and self.possible.all() and own.any())

    @property
    def is_in_one_assembly(self) -> bool:
        """Whether the two sides are equal on the home position's branch; if no state is on it, on
        some branch for every parameter set."""
        home = self.states.is_home
        if home.any():
            return bool(self.right[home].all())
        return all(self._is_right_on_one(k, branches) for k, branches in self._branches)

    @property
    def is_in_another_assembly(self) -> bool:
        """Whether the two sides are equal, for every parameter set, on some branch other than the
        home position's."""
        return all(self._is_right_on_one(k, filter(None, x)) for k, x in self._branches)

    def _is_right_on_one(self, k: int, branches: Iterable[int]) -> bool:
        """Whether the two sides are equal on some of the branches at parameter set k."""
        states = self.states
        return any(
            self.right[(states.parameters == k) & (states.branch == b)].all() for b in branches
        )

    @property
    def _branches(self) -> list[tuple[int, list[int]]]:
        states = self.states
        return [
            (int(k), [int(b) for b in np.unique(states.branch[states.parameters == k])])
            for k in np.unique(states.parameters)
        ]

    @property
    def worst(self) -> int:
        """The state at which the two sides differ most."""
        return self.gap.worst


def agreement(
    states: AdmissibleStates,
    yours: Expression,
    right: Running,
    equal: Equal | None = None,
    known: Known | None = None,
) -> Agreement:
    """The agreement of an expression with the correct values at states; known: values of some of
    its nodes."""
    equal, first = equal or Equal(), None
    fits, every = np.zeros(states.count, bool), choices(yours)
    others: dict[str, None] = {}
    for choice in every:
        with np.errstate(all="ignore"):
            gap = equal.reduced(states.at(yours, choice, known) - right, states)
        holds = gap.vanishes
        first = first or gap
        if (holds & ~fits).any():
            others |= dict.fromkeys(second_values(choice))
        fits |= holds
        if fits.all():
            break
    assert first is not None  # there is one choice at least
    return Agreement(states, first.vanishes, fits, tuple(others), first)


def is_drowned(states: AdmissibleStates, yours: Expression, right: Running, gap: Running) -> bool:
    """Whether some terms are so much larger than the correct value, or the smallest term of an
    equation, that rounding could hide a mistake."""
    with np.errstate(all="ignore"):
        least = right.size if right.size.any() else _least(states, yours)
        return bool(np.median(gap.size / least) > _LARGEST)


def _least(states: AdmissibleStates, yours: Expression) -> AnyArray:
    """The size of the smallest nonvanishing term of a sum at each state."""
    terms = (states.at(x, {}) for x in _terms(yours))
    return np.min([np.where(x.vanishes, np.inf, np.abs(x.value)) for x in terms], axis=0)


def _terms(node: Expression) -> Iterator[Expression]:
    """The terms of nested sums."""
    if isinstance(node, Sum):
        for term in node.terms:
            yield from _terms(term)
    elif isinstance(node, Negative):
        yield from _terms(node.operand)
    else:
        yield node


@dataclass(frozen=True)
class StatesOfModel:
    """The states of a model, each collection drawn only once."""

    setting: RightEquations

    def of(
        self,
        own_values: bool = False,
        still: bool = False,
        given: Mapping[str, float] = MappingProxyType({}),
        acting: ActingLoads = "",
    ) -> AdmissibleStates | None:
        """States of a model. own_values: with the model's parameter values; still: in equilibrium;
        given: values of some names; acting: see `StateSampler`."""
        key = own_values, still, frozenset(given.items()), acting
        if key not in self._drawn:
            drawing = StateSampler(self.setting, own_values, still, given, acting)
            self._drawn[key] = drawing.states()
        return self._drawn[key]

    @cached_property
    def _drawn(self) -> dict[_DrawnFor, AdmissibleStates | None]:
        return {}


def few(states: AdmissibleStates) -> AdmissibleStates:
    """One state per parameter set, on the home position's branch if possible: enough to detect most
    wrong answers."""
    chosen: list[int] = []
    for k in np.unique(states.parameters):
        own = np.flatnonzero(states.parameters == k)
        chosen.append(int(own[np.argmin(states.branch[own])]))
    return states.chosen(np.array(chosen))
