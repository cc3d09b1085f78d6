"""The verdict on claims that are compared at states: equations that hold on closed loops, and those
with inverse functions."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.nodes import Expression, Function, nodes, replaced
from freebody.lazy import cached_property
from freebody.scalars.generators import generators_in, symbols_in
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.finite_field import is_square, without_values
from freebody_textbook.check.algebra.quotients import Named, Value, generator, pair
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.numbers.given_states import in_words
from freebody_textbook.check.numbers.units_of_symbols import in_other_units, unit_of
from freebody_textbook.check.reading.claim import Claim
from freebody_textbook.check.reasons.misconceptions import left_out
from freebody_textbook.check.reasons.small_changes import Repair, SmallChanges
from freebody_textbook.check.states.admissible_states import AdmissibleStates, StateSampler
from freebody_textbook.check.states.agreement import Agreement, Equal, agreement, few, is_drowned
from freebody_textbook.check.states.state_values import (
    MOST_BRANCHES,
    AnyArray,
    Running,
    choices,
    functions_of,
    of_several_values,
)
from freebody_textbook.check.verdict import EquationVerdict, Mistake
from freebody_textbook.check.verdicts.digits_at_states import unrounded
from freebody_textbook.check.verdicts.verdict_sentences import (
    Wording,
    example_at,
    right_verdict,
    wrong_verdict,
)
from freebody_textbook.closed_chains.linear_equations import Ratio

if TYPE_CHECKING:
    from freebody_textbook.check.verdicts.equation_verdict import Judge

_MOST_NODES = 150
"""Pieces of an answer up to which changes are tried."""

_OTHER_POSTURE = (
    "It belongs to another posture than the line before: with these two coordinates the tip is "
    "elsewhere."
)
_OTHER_ASSEMBLY = (
    "It holds in another assembly of the mechanism than that of its file: the same lengths, put "
    "together the other way."
)
ONE_ASSEMBLY = "It holds in one assembly of the mechanism, not in every one."
_DROWNED = (
    "terms that cancel are so much larger here than what is left of them that rounding could hide "
    "a mistake"
)
LEVEL = "It differs by a constant: the zero level of V is arbitrary."
_OTHER_VALUES = {
    "arccos": "arccos and −arccos are the two postures that reach a point, elbow up and elbow down",
    "sqrt": "the two signs of the root are the two postures, elbow up and elbow down",
    "arcsin": "arcsin is a right angle at most, and π − arcsin has the same sine",
    "arctan": "arctan loses the quadrant, which atan2(y, x) has",
}


def verdict(judge: Judge, claim: Claim, right: Value, explain: bool) -> EquationVerdict | None:
    """The verdict on a claim with inverse functions or about closed loops; None for other claims,
    and for claims that loops do not make correct though they may not have to."""
    functions = functions_of(claim.node if claim.whole is None else claim.whole)
    if len(of_several_values(claim.node)) > MOST_BRANCHES:
        claim.source.fail(
            f"at most {MOST_BRANCHES} inverse functions are read in an equation", claim.node.span
        )
    at_states = _AtStates(judge, claim, right)
    if not (functions or _has_conditions(judge.setting) or at_states.is_quotient_in_numbers):
        return None
    kind = claim.target.kind
    says_nothing = claim.value.is_zero and (kind.holds_by_loops or right.is_zero)
    if not functions and (kind.of_loops in ("positions", "slopes") or says_nothing):
        return None
    if at_states.moving is None:
        if kind.is_long or functions:
            claim.source.fail(
                "this robot's loops could not be closed anywhere, and so nothing can be compared",
                claim.node.span,
            )
        return None
    return at_states.verdict(explain, bool(functions))


def _symbols_of(tree: Expression) -> set[str]:
    """The symbols in an expression as written."""
    named = (x.value for x in nodes(tree) if isinstance(x, Named))
    return symbols_in(*(part for value in named for part in pair(value)))


def _one_value(found: Agreement) -> str:
    """A sentence on an answer that would be correct only with second values of its functions."""
    count, of = int(found.right.sum()), found.states.count
    return (
        f"As it stands it is right at {count} of {of} positions only. At the others a function "
        "would need its second value, a root its other sign; but that is no choice between "
        "postures."
    )


def _has_conditions(setting: RightEquations) -> bool:
    """Whether states must satisfy conditions: closed loops, equations of passive joints, or motion
    of free bodies."""
    is_free = setting.symbols.model.passive or setting.is_free_body
    return setting.system is not None or bool(is_free)


@dataclass(frozen=True)
class _AtStates:
    """A claim with the states at which it must hold."""

    judge: Judge
    claim: Claim
    right: Value

    @cached_property
    def moving(self) -> AdmissibleStates | None:
        """States in motion; with the model's parameter values if the claim contains no parameter.
        None if there are none."""
        free_body = self.judge.free_body
        if free_body is None:
            acting = self.claim.target.acting
            found = self.judge.states.of(own_values=self.is_in_numbers, acting=acting)
            of_loops, moving = (
                self.claim.target.kind.of_loops,
                self.judge.setting.symbols.coordinates,
            )
            if found is not None and of_loops:
                return found.with_any(() if of_loops == "rates" else moving)
            return found
        written = (x.value for x in nodes(self._tree) if isinstance(x, Named))
        images = free_body.motion((*written, self.right)).images
        return StateSampler(self.judge.setting, self.is_in_numbers, images=images).states()

    @property
    def is_in_numbers(self) -> bool:
        """Whether the claim contains no symbol that has a value in the model, except gravity."""
        return bool(self._known_symbols) and self._has_no_known_symbols

    @cached_property
    def _known_symbols(self) -> frozenset[str]:
        """The symbols that have a value in the model, except gravity."""
        model = self.judge.setting.symbols.model
        given = {name for name, x in model.parameters.items() if x is not None}
        return frozenset(given - {self.judge.setting.order.gravity})

    @cached_property
    def _has_no_known_symbols(self) -> bool:
        """Whether the claim contains no symbol that has a value in the model."""
        named = (x.value for x in nodes(self._tree) if isinstance(x, Named))
        symbols = (x for x in named if isinstance(x, Trig) and len(x) == 1)
        return self._known_symbols.isdisjoint(generators_in(*symbols))

    @property
    def is_quotient_in_numbers(self) -> bool:
        """Whether the claim is a quotient without symbols; polynomials in numbers are judged by
        their digits."""
        value = self.claim.value
        return (
            self.claim.target.kind.takes_quotients or isinstance(value, Ratio)
        ) and self.is_in_numbers

    @property
    def _tree(self) -> Expression:
        """The expression that is compared: for an equation between two sides their difference."""
        return self.claim.node if self.claim.whole is None else self.claim.whole

    def _sought(self, states: AdmissibleStates) -> Running:
        """The values that the expression must equal."""
        if self.claim.whole is not None:
            return Running.exact(np.zeros(states.count))
        return states.of(self.right)

    @cached_property
    def _equal(self) -> Equal:
        """The kind of equality required: equal, up to whole turns, or up to a constant."""
        ring = self.judge.setting.ring
        is_angle = isinstance(self.right, Trig) and _is_angle(self.right, ring.angles)
        has_level = self.judge.up_to_a_constant(self.claim, self.right) and self._is_energy
        return Equal(is_angle and self.claim.whole is None, has_level)

    @cached_property
    def _is_energy(self) -> bool:
        """Whether the difference of the sides is an energy plus a plain number, so that it changes
        with units."""
        states, sampler = self.moving, StateSampler(self.judge.setting)
        if states is None or self.is_in_numbers:
            return True
        names, held = list(states.values), [*sampler.loops[0], *sampler.passive]
        first, gaps = self._gap(states), list[Running]()
        energy = self.judge.targets.single["V"].polynomial()
        for size_of_energy, sizes in in_other_units(self.judge.setting, names, held, energy):
            values = {x: states.values[x] * size for x, size in zip(names, sizes, strict=True)}
            gap = self._gap(replace(states, values=values)) - first
            gaps.append(gap * Running.exact(1 / (size_of_energy - 1)))
        return not gaps or bool((gaps[0] - gaps[1]).vanishes.all())

    def _gap(self, states: AdmissibleStates) -> Running:
        return states.at(self._tree, {}) - self._sought(states)

    def _agreement(self, states: AdmissibleStates) -> Agreement:
        return agreement(states, self._tree, self._sought(states), self._equal)

    # ------------------------------------------------------------ verdicts
    def verdict(self, explain: bool, by_functions: bool) -> EquationVerdict | None:
        """The verdict "right" with its note; "wrong" if no other comparison can make the claim
        right; otherwise None."""
        states, held = self.moving, self._held()
        assert states is not None
        found = self._agreement(states)
        if is_drowned(states, self._tree, self._sought(states), found.gap):
            self.claim.source.fail(_DROWNED, self.claim.node.span)
        if note := self._note(found):
            if by_functions and not self._shares_a_posture(found):
                return self._wrong(found, (), (_OTHER_POSTURE,))
            return right_verdict(self.claim, f"{note} {self.claim.target.note}".strip())
        if held is not None and self._agreement(held).is_everywhere:
            note = f"It holds in equilibrium: compared in numbers at {held.count} positions."
            return right_verdict(self.claim, note)
        there, where = self._there()
        if there is not None:
            found = self._agreement(there)
            if note := self._note(found):
                return right_verdict(self.claim, f"At {where}. {note}")
        if note := self._note_on_digits(states):
            return right_verdict(self.claim, note)
        if found.is_with_branches and not self._may_choose_branches:
            return self._wrong(found, (), (_one_value(found),))
        if self.judge.setting.system is not None and found.is_in_another_assembly:
            return self._wrong(found, (), (_OTHER_ASSEMBLY,))
        if self.judge.free_body is not None and not by_functions:
            return None
        if explain and not by_functions and (cause := self._left_out(states)):
            return self._wrong(found, (), (cause,))
        return self._wrong_only_here(found, explain, by_functions)

    def _wrong_only_here(
        self, found: Agreement, explain: bool, by_functions: bool
    ) -> EquationVerdict | None:
        """The verdict "wrong", if numbers alone decide or a mistake explains the claim; otherwise
        None."""
        only_here = by_functions or self._is_by_loops
        if not (only_here or self._goes_another_way):
            return None
        mistake = next(self._mistakes(found), None) if explain else None
        unexplained = not only_here or self.claim.target.kind.is_equation
        if mistake is None and unexplained and not by_functions:
            return None
        told = f"Compared in numbers at {found.states.count} states, on every branch."
        return self._wrong(found, (mistake,) if mistake else (), (told,) if by_functions else ())

    @property
    def _may_choose_branches(self) -> bool:
        """Whether inverse functions in the claim give positions, which several postures have: they
        contain no masses or forces, and belong to an equation of positions or to earlier
        definitions."""
        first, last = self._tree.span
        parts = (self._tree,)
        if not self.claim.target.kind.has_branches:
            parts = of_several_values(self._tree)
            if any(first <= x.argument.span[0] < last for x in parts):
                return False
        if self._is_in_motion and any(map(self._is_root_of_square, of_several_values(self._tree))):
            return False
        names = set[str]().union(*map(_symbols_of, parts))
        units = (unit_of(self.judge.setting, {name: 1}) for name in names)
        return not any(unit is not None and unit[0] for unit in units)

    @property
    def _is_in_motion(self) -> bool:
        """Whether the claim contains rates or accelerations, or is about one."""
        written = _symbols_of(self._tree) | generators_in(*pair(self.right))
        return any(atom(name).dots for name in written)

    def _is_root_of_square(self, node: Function) -> bool:
        """Whether a root is that of a squared expression in written symbols, which fix its sign:
        √(1 − cos²) needs no choice if the angle is known. The root of a squared rate is a speed
        without direction."""
        named = (x.value for x in nodes(node.argument) if isinstance(x, Named))
        if node.name != "sqrt" or functions_of(node.argument) or not all(map(_is_symbol, named)):
            return False
        if any(atom(name).dots for name in _symbols_of(node.argument)):
            return False
        return is_square(self.judge.setting.ring, node.argument)

    def _left_out(self, states: AdmissibleStates) -> str:
        """A sentence on parameters that may have been forgotten: with them set to 0 the claim is
        right."""
        setting = self.judge.setting
        if self.claim.value.is_zero or not _has_conditions(setting):
            return ""
        written, right = _symbols_of(self._tree), generators_in(*pair(self.right))
        sampler = StateSampler(setting, acting=self.claim.target.acting)
        for text, group in left_out(setting):
            there = None
            if group.names.isdisjoint(written) and group.explains(right, written):
                there = sampler.at_values(states, dict.fromkeys(group.names, 0.0))
            if there is not None and self._note(self._agreement(there)):
                return text
        return ""

    @property
    def _is_by_loops(self) -> bool:
        """Whether only closed loops can make the claim right: it is about a quantity that holds by
        loops, or gives a quotient for a polynomial."""
        claim = self.claim
        return claim.target.kind.holds_by_loops or (
            isinstance(claim.value, Ratio) and not isinstance(self.right, Ratio)
        )

    @property
    def _goes_another_way(self) -> bool:
        """Whether the claim contains symbols that the correct value does not have, for instance
        along the other leg of a loop."""
        own, theirs = (symbols_in(*pair(x)) for x in (self.right, self.claim.value))
        return self.claim.whole is None and not theirs <= own

    def _held(self) -> AdmissibleStates | None:
        """Positions in equilibrium, if the claim refers to them and contains no moving quantity;
        None otherwise."""
        numbers = self.judge.numbers
        if not numbers.is_still(self.claim.node.span) or numbers.has_motion(self.claim):
            return None
        return self.judge.states.of(still=True)

    def _there(self) -> tuple[AdmissibleStates | None, str]:
        """(states with the values given for the claim, these values in words); None for the states
        if nothing is given, or the claim contains quantities that vanish there."""
        judge = self.judge
        given = judge.numbers.numbers.state_at(self.claim.node.span, in_symbols=True)
        if not given or judge.setting.system is None or self.claim.target.kind.of_loops:
            return None, ""
        if judge.numbers.has_what_vanishes(self.claim, given):
            return None, ""
        values = {name: x.value for name, x in given.items()}
        found = judge.states.of(own_values=self.is_in_numbers, given=values)
        if found is None:
            self.claim.source.fail(
                f"the loops could not be closed at {in_words(given)}", self.claim.node.span
            )
        return found, in_words(given)

    def _note(self, found: Agreement) -> str:
        """A note for a claim that is right; "" for a wrong one."""
        closed = self.judge.setting.system is not None
        passive = self.judge.setting.symbols.model.passive
        of_loops = self.claim.target.kind.of_loops
        where = "states that close the loops" if closed and not of_loops else "positions"
        compared = f"Compared in numbers at {found.states.count} {where}"
        if passive and not closed and not functions_of(self._tree) and found.is_everywhere:
            joints = " and ".join(f"joint {k + 1}" for k in passive)
            return f"It holds with what follows from no drive at {joints}."
        polynomial = not closed and not functions_of(self._tree)
        if found.is_everywhere and polynomial and self.is_in_numbers:
            return f"In numbers, with the values of {self.judge.setting.symbols.model.name!r}."
        if found.is_everywhere:
            plain = agreement(found.states, self._tree, self._sought(found.states))
            return f"{compared}." if plain.is_everywhere or self._equal.as_angles else LEVEL
        if found.is_with_branches and self._may_choose_branches:
            others = ", and ".join(dict.fromkeys(_OTHER_VALUES[x] for x in found.others))
            count = int(found.right.sum())
            stands = f"right as it stands at {count}, at the others on another branch"
            return f"{compared}: {stands}; {others}."
        if closed and found.is_in_one_assembly:
            return f"{ONE_ASSEMBLY} {compared}."
        return ""

    def _note_on_digits(self, states: AdmissibleStates) -> str:
        """A note for a claim in numbers that is right to its digits; "" otherwise."""
        if not self._has_no_known_symbols:
            return ""
        every, sought = choices(self._tree), self._sought(states)

        def gap(tree: Expression, branch: int) -> AnyArray:
            several: list[Expression] = [*of_several_values(tree)]
            choice = dict(zip(several, every[branch].values(), strict=True))
            gap = states.at(tree, choice) - sought
            return self._equal.reduced(gap, states).value

        tree = unrounded(self._tree, self.claim.source, gap, states.count)
        if tree is None:
            return ""
        other = replace(self, claim=replace(self.claim, node=tree, whole=None))
        note = other._note(agreement(states, tree, sought, self._equal))
        model = self.judge.setting.symbols.model.name
        return note and f"In numbers, with the values of {model!r}, to the digits given. {note}"

    def _shares_a_posture(self, found: Agreement) -> bool:
        """Whether the claim is right as it stands at some state where the coordinates given earlier
        in the answer are right too."""
        claims, right = self.judge.claims, found.right.copy()
        for other in claims[: claims.index(self.claim)]:
            if not other.target.kind.is_posture or other.label == self.claim.label:
                continue
            before = _AtStates(self.judge, other, other.target.compute())
            if before.moving is found.states:
                theirs = before._agreement(found.states)
                right &= theirs.right if before._note(theirs) else True
        return bool(right.any())

    def _wrong(
        self, found: Agreement, findings: tuple[Mistake, ...], causes: tuple[str, ...]
    ) -> EquationVerdict:
        """The verdict "wrong", with the state of the largest difference."""
        claim, shown = self.claim, None
        if claim.whole is None:
            shown = example_at(
                self.judge.setting, found.states, found.worst, claim.node, self.right
            )
        return wrong_verdict(claim, findings, causes, shown)

    # ------------------------------------------------------------ mistakes
    def _mistakes(self, found: Agreement) -> Iterator[Mistake]:
        """Mistakes each of which explains the difference, most likely first."""
        tree = self._tree
        fits, work = self._fitting(found), without_values(tree)
        if len(work.values) > _MOST_NODES:
            return
        changes = SmallChanges(self.judge.setting, work, 0, lambda name: {})
        for repair in sorted(changes.discrete(), key=lambda row: row.cost):
            says_nothing = repair.kind == "extra" and repair.node is work.root
            if (
                not says_nothing
                and _can_be_said(repair)
                and fits(replaced(tree, {repair.node: repair.new}))
            ):
                yield Wording(self.judge.setting, self.claim.source).of_repair(repair, work)

    def _fitting(self, found: Agreement) -> Callable[[Expression], bool]:
        """A function that tells whether a changed expression is right; it first tries a few states,
        with cached node values."""
        states, first = found.states, few(found.states)
        known, sought = first.pieces(self._tree), self._sought(first)

        def fits(tree: Expression) -> bool:
            here = agreement(first, tree, sought, self._equal, known)
            if not here.possible.all():
                return False
            return bool(self._note(agreement(states, tree, self._sought(states), self._equal)))

        return fits


def _is_symbol(x: Value) -> bool:
    """Whether a value is a number or a symbol of the ring, not a combination of several."""
    return isinstance(x, Trig) and (x.is_constant or generator(x) is not None)


def _is_angle(x: Trig, angles: tuple[str, ...]) -> bool:
    """Whether a value is a sum of integer multiples of angles."""
    terms = list(x.terms())
    return bool(terms) and all(
        list(powers.values()) == [1] and powers.keys() <= set(angles) and k.denominator == 1
        for powers, k in terms
    )


def _can_be_said(repair: Repair) -> bool:
    """Whether a change can be printed: of an expression with functions only its sign or another
    function."""
    return repair.kind in ("sign", "arguments", "inverse") or not functions_of(repair.node)
