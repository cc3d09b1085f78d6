"""States that a robot can be in, drawn at random: loops closed on every branch, at regular
positions, and what nothing drives obeying the equations of motion."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from freebody.expressions.grammar.atoms import atom
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.scalars.generators import SIGN, function_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.asked.quantity import ActingLoads
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.states.state_values import AnyArray, Polynomials, StateValues
from freebody_textbook.closed_chains.multiplier_equations import multiplier_names

PARAMETER_SETS, STARTS, ON_EACH = 3, 4, 3
"""Sets of parameters; for each the branches that are looked for besides the home's; and states on
each of these."""
OF_TREES = 8
"""States of a robot without loops, for each set of parameters."""
_GUESSES = 48
"""Random positions from which loops are closed, for each set of parameters."""
_VARIED = 0.25
"""The share by which parameters differ from the model's."""
_DRAWN = (0.5, 1.5)
"""The range from which parameters without a value are drawn."""
_FARTHEST = 1.5
"""The range of slides, in lengths of the robot."""
_STEPS, _CLOSED = 60, 1e-13
"""Newton's steps, and the gap at which loops count as closed, in lengths of the robot."""
_REGULAR = (0.03, 0.01)
"""Least ratio of singular values of a regular position; the second where the first leaves none."""
_DEPENDENT = 1e-7
"""The ratio below which rows of a Jacobian count as dependent."""
_STRIDE, _CORRECTION = 0.15, 0.06
"""Radians of a step along a branch, and how far it may lead off it."""
_LED = 0.3
"""The farthest that others may follow a step of a coordinate that is led to where it is given."""
_BETWEEN, _MOST_WALKED = 4, 60
"""Steps from one state to the next, and of the whole way."""
_SOLVED = 1e-9
"""The share of its terms within which a linear system counts as solved."""


@dataclass(frozen=True, eq=False)
class AdmissibleStates(StateValues):
    """parameters: the number of each state's set; branch: that of its branch within the set, 0 the
    home's."""

    parameters: AnyArray
    branch: AnyArray

    @property
    def is_home(self) -> AnyArray:
        """Flags of the states on the branch of the home."""
        return self.branch == 0

    def with_any(self, coordinates: Collection[str]) -> AdmissibleStates:
        """The states with random rates, accelerations and some coordinates, which need not keep
        loops closed."""
        chance = np.random.default_rng(29)
        values = {
            name: chance.normal(size=self.count) if atom(name).dots or name in coordinates else x
            for name, x in self.values.items()
        }
        return replace(self, values=values)

    def chosen(self, which: AnyArray) -> AdmissibleStates:
        """The states at some places of the collection."""
        values = {name: x[which] for name, x in self.values.items()}
        return AdmissibleStates(values, self.parameters[which], self.branch[which])


def _together(parts: Sequence[AdmissibleStates]) -> AdmissibleStates:
    """The states of several collections in one."""
    return AdmissibleStates(
        {name: np.concatenate([x.values[name] for x in parts]) for name in parts[0].values},
        np.concatenate([x.parameters for x in parts]),
        np.concatenate([x.branch for x in parts]),
    )


@dataclass(frozen=True, eq=False)
class StateSampler:
    """Draws the states of a model; own_values: with the values of its parameters, which otherwise
    vary; still: positions at which it is held; given: values of some names at all states; acting:
    under a force from outside, alone, with the weights or with the motion too."""

    setting: RightEquations
    own_values: bool = False
    still: bool = False
    given: Mapping[str, float] = field(default_factory=dict[str, float])
    acting: ActingLoads = ""
    images: Mapping[str, Value] = field(default_factory=dict[str, Value])
    """Values of some names by the others, as velocities and accelerations of a free body."""

    def states(self) -> AdmissibleStates | None:
        """States drawn at random, alike each time; None of a chain that cannot be closed."""
        chance = np.random.default_rng(28)
        drawn = [self._of_one_set(chance, k) for k in range(PARAMETER_SETS)]
        parts = [x for x in drawn if x is not None and x.count]
        return _together(parts) if parts else None

    def at_values(
        self, states: AdmissibleStates, values: Mapping[str, float]
    ) -> AdmissibleStates | None:
        """The states with other masses or weights at their positions and rates, and the
        accelerations and multipliers that follow."""
        others = {name: np.full(states.count, x) for name, x in values.items()}
        changed = replace(states, values={**states.values, **others})
        return self._pressed(np.random.default_rng(28), changed)

    def _of_one_set(self, chance: np.random.Generator, k: int) -> AdmissibleStates | None:
        """States with one set of parameters."""
        count = 1 + _GUESSES
        values = {name: np.full(count, x) for name, x in self._parameters(chance).items()}
        values |= self._guesses(chance, count)
        for name in self.setting.ring.names:
            if name not in values and function_of(name) != SIGN:
                values[name] = np.full(count, chance.uniform(*_DRAWN))
        fixed = [x for x in self.given if x not in self._names]
        values |= {x: np.full(count, self.given[x]) for x in fixed}
        drawn = AdmissibleStates(values, np.full(count, k), np.arange(count))
        positions = self._positions(chance, drawn)
        if positions is None:
            return None
        found = self._pressed(chance, self._moving(chance, positions))
        if found is None or not self.images:
            return found
        put = {name: found.of(x).value for name, x in self.images.items()}
        return replace(found, values={**found.values, **put})

    # ------------------------------------------------------------ what is drawn
    def _parameters(self, chance: np.random.Generator) -> dict[str, float]:
        """Values of the robot's parameters at the states."""
        found = {}
        for name, x in self.setting.symbols.model.parameters.items():
            varied = chance.uniform(1 - _VARIED, 1 + _VARIED)
            if x is not None and name in self.setting.ring.index:
                found[name] = x if self.own_values else x * varied
        return found

    def _guesses(self, chance: np.random.Generator, count: int) -> dict[str, AnyArray]:
        """Positions, the first that of the home."""
        found = {}
        for name, home in zip(self._names, self.home, strict=True):
            far = np.pi if name in self.setting.ring.angles else _FARTHEST * self._length
            near = -far if name in self.setting.ring.angles or self.loops[0] else _DRAWN[0] * far
            found[name] = chance.uniform(near, far, count)  # an arm's slides do not reach behind it
            found[name][0] = home
        return found

    @property
    def _names(self) -> tuple[str, ...]:
        return self.setting.symbols.coordinates

    @cached_property
    def home(self) -> AnyArray:
        """The file's home, in the answer's coordinates."""
        model, turned = self.setting.symbols.model, self.setting.turned
        home, found = dict(model.home), np.zeros(len(self._names))
        for body, at in zip(model.bodies, model.coordinates, strict=True):
            for k in at.v:
                found[k] = home.get(body.joint.name, 0.0)
        if turned is not None:
            found = np.linalg.solve(np.array(turned, float), found)
        quarters = self.setting.quarters
        return found - np.pi / 2 * np.array(quarters) if quarters else found

    @cached_property
    def _length(self) -> float:
        """A length of the robot: the mean of its parameters in metres."""
        model, units = self.setting.symbols.model, self.setting.units
        lengths = [abs(x) for k, x in model.parameters.items() if x and units.get(k) == "m"]
        return float(np.mean(lengths)) if lengths else 1.0

    @cached_property
    def _scale(self) -> AnyArray:
        """A radian of each turn, a length of each slide."""
        angles = self.setting.ring.angles
        return np.array([1.0 if x in angles else self._length for x in self._names])

    @cached_property
    def _loose(self) -> tuple[str, ...]:
        """The coordinates that are not given."""
        return tuple(self._not_given(self._names))

    @cached_property
    def _loose_scale(self) -> AnyArray:
        return np.array([self._size_of(x) for x in self._loose])

    # ------------------------------------------------------------ positions
    def _positions(
        self, chance: np.random.Generator, drawn: AdmissibleStates
    ) -> AdmissibleStates | None:
        """Regular positions with closed loops, some on each branch that is found."""
        if not self.loops[0]:
            return drawn.chosen(np.arange(1, 1 + OF_TREES))  # none is the home's
        rows = self._rows
        if not rows.names:
            return None
        closed = self._closed(drawn, self._any_rows, self._names, self._scale)
        if self._loose != self._names:
            closed = self._led(closed)
        if not closed.count:
            return None
        ratio: AnyArray = self._ratios(closed, rows)
        enough = (closed.chosen(np.flatnonzero(ratio >= x)) for x in _REGULAR)
        regular = next((x for x in enough if x.count), None)
        if regular is None:
            return None
        return self._walked(chance, self._apart(regular), rows)

    def _led(self, states: AdmissibleStates) -> AdmissibleStates:
        """The states that closed positions come to when the given coordinates are led to their
        values; those that cannot follow are left out."""
        fixed = [x for x in self._names if x not in self._loose]
        ways = {x: self.given[x] - states.values[x] for x in fixed}
        count = 1 + int(max(np.abs(way).max(initial=0.0) for way in ways.values()) / _STRIDE)
        numbered = replace(states, branch=np.arange(states.count))
        for k in range(count):
            ahead = {
                x: self.given[x] - way[numbered.branch] * (count - 1 - k) / count
                for x, way in ways.items()
            }
            moved = replace(numbered, values={**numbered.values, **ahead})
            numbered, off = self._back(moved, self._rows)
            numbered = numbered.chosen(off < _LED)
            if not numbered.count:
                break
        return replace(numbered, branch=states.branch[numbered.branch])

    def _closed(
        self, drawn: AdmissibleStates, rows: Rows, names: Sequence[str], scale: AnyArray
    ) -> AdmissibleStates:
        """The states nearest to some at which rows vanish, by Newton's method; those that do not
        come to an end are left out."""
        values = dict(drawn.values)
        for _ in range(_STEPS):
            here = replace(drawn, values=values)
            gap = rows.at(here)
            if (np.abs(gap) <= _CLOSED * self._length).all():
                break
            slopes = rows.slopes_at(here) * scale
            steps = np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=1e-10), gap) * scale
            steps = np.clip(steps, -scale, scale)
            for i, name in enumerate(names):
                values[name] = values[name] - steps[:, i]
        here = replace(drawn, values=values)
        ends = (np.abs(rows.at(here)) <= 100 * _CLOSED * self._length).all(1)
        return here.chosen(np.flatnonzero(ends))

    def _ratios(self, states: AdmissibleStates, rows: Rows) -> AnyArray:
        """The least of the singular values that generic positions have, by the largest."""
        values = self._singular_values(states, rows)
        rank = int((values > _DEPENDENT).sum(1).max())
        return values[:, rank - 1] if rank else np.ones(states.count)

    def _singular_values(self, states: AdmissibleStates, rows: Rows) -> AnyArray:
        values = np.linalg.svd(self._normed(states, rows), compute_uv=False)
        return values / np.maximum(values[:, :1], 1e-300)

    def _normed(self, states: AdmissibleStates, rows: Rows) -> AnyArray:
        """Φ_q by turns and lengths, its rows of length 1."""
        slopes = rows.slopes_at(states) * self._loose_scale
        return slopes / np.maximum(np.linalg.norm(slopes, axis=2, keepdims=True), 1e-300)

    def _apart(self, states: AdmissibleStates) -> AdmissibleStates:
        """The home, if it is among the states, and those of the others that are farthest from one
        another."""
        at = np.stack([states.values[x] / s for x, s in zip(self._names, self._scale, strict=True)])
        angles = np.array([x in self.setting.ring.angles for x in self._names])
        chosen = [int(np.argmin(states.branch))]
        while len(chosen) < min(states.count, 1 + STARTS):
            gaps = at[:, :, None] - at[:, None, chosen]
            gaps[angles] = 2 * np.sin(gaps[angles] / 2)
            chosen.append(int(np.abs(gaps).max(0).min(1).argmax()))
        return states.chosen(np.array(chosen))

    def _walked(
        self, chance: np.random.Generator, starts: AdmissibleStates, rows: Rows
    ) -> AdmissibleStates:
        """States along the branches of some, by small steps that keep to them."""
        here, found = starts, list[AdmissibleStates]()
        heading = chance.normal(size=(starts.count, len(self._loose)))
        taken, stride = np.zeros(starts.count, int), np.full(starts.count, _STRIDE)
        least = min(_REGULAR[-1], float(self._ratios(starts, rows).min()))
        for _ in range(_MOST_WALKED):
            along = self._free(here, rows, heading)
            if not along.any() or (taken >= ON_EACH * _BETWEEN).all():
                break
            heading = along / np.maximum(np.abs(along).max(1, keepdims=True), 1e-300)
            moved = self._moved(here, heading * stride[:, None])
            there, off = self._back(moved, rows)
            good = (off < _CORRECTION) & (self._ratios(there, rows) >= least)
            here = replace(here, values={
                x: np.where(good, y, here.values[x]) for x, y in there.values.items()
            })  # fmt: skip
            taken = taken + good
            stride = np.where(good, _STRIDE, stride / 2)
            lost = stride < _STRIDE / 10  # the way ends here
            heading[lost], stride[lost] = -heading[lost], _STRIDE
            reached = good & (taken % _BETWEEN == 0) & (taken <= ON_EACH * _BETWEEN)
            if reached.any():
                found.append(here.chosen(reached))
        return _together(found) if found else starts

    def _back(self, moved: AdmissibleStates, rows: Rows) -> tuple[AdmissibleStates, AnyArray]:
        """The nearest positions with closed loops, and how far they are in turns and lengths;
        infinitely where there is none."""
        numbered = replace(moved, branch=np.arange(moved.count))
        closed = self._closed(numbered, rows, self._loose, self._loose_scale)
        values, off = dict(moved.values), np.full(moved.count, np.inf)
        off[closed.branch] = 0.0
        for x, scale in zip(self._loose, self._loose_scale, strict=True):
            values[x] = moved.values[x].copy()
            values[x][closed.branch] = closed.values[x]
            off = np.maximum(off, np.abs(values[x] - moved.values[x]) / scale)
        return replace(moved, values=values), off

    def _moved(self, states: AdmissibleStates, steps: AnyArray) -> AdmissibleStates:
        """States moved by turns and lengths."""
        moved = {
            x: states.values[x] + step * s
            for x, step, s in zip(self._loose, steps.T, self._loose_scale, strict=True)
        }
        return replace(states, values={**states.values, **moved})

    def _free(self, states: AdmissibleStates, rows: Rows, wanted: AnyArray) -> AnyArray:
        """The part of turns and lengths that the loops allow."""
        slopes = self._normed(states, rows)
        held = np.einsum("kij,kj->ki", slopes, wanted)
        free = wanted - np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=_DEPENDENT), held)
        return np.where(np.abs(free) > _DEPENDENT, free, 0.0)

    # ------------------------------------------------------------ motion
    def _moving(self, chance: np.random.Generator, states: AdmissibleStates) -> AdmissibleStates:
        """Positions with rates that keep the loops closed."""
        moving = self._begun(states, [x + RATE for x in self._names])
        return moving if self.still else self._solved(chance, moving, self._of_rates)[0]

    def _pressed(
        self, chance: np.random.Generator, states: AdmissibleStates
    ) -> AdmissibleStates | None:
        """The states with accelerations and multipliers that keep loops closed and move passive
        joints as nothing drives them."""
        at_zero = self._begun(states, [*(x + SECOND for x in self._names), *self.multipliers])
        rows = self._of_forces
        if not rows.names:
            return self._at_rest(at_zero) if rows.polynomials else at_zero
        found, ends = self._solved(chance, at_zero, rows)
        if self.still and not ends.all():
            return self._at_rest(found)
        return found.chosen(ends) if ends.any() else None

    def _solved(
        self, chance: np.random.Generator, states: AdmissibleStates, rows: Rows
    ) -> tuple[AdmissibleStates, AnyArray]:
        """States at which rows vanish that are linear in their names, which are 0 or given so far,
        and where that has come to an end."""
        slopes, gap = rows.slopes_at(states), rows.at(states)
        scale = np.array([self._size_of(x) for x in rows.names])
        slopes = slopes * scale
        size = np.maximum(np.linalg.norm(slopes, axis=2), 1e-300)
        A, b = slopes / size[:, :, None], -gap / size
        x = chance.normal(size=(states.count, len(rows.names)))
        left = b - np.einsum("kij,kj->ki", A, x)
        x = x + np.einsum("kij,kj->ki", np.linalg.pinv(A, rcond=_DEPENDENT), left)
        x = np.where(np.abs(x) > _DEPENDENT, x, 0.0)
        found = {name: x[:, k] * scale[k] for k, name in enumerate(rows.names)}
        solved = np.abs(np.einsum("kij,kj->ki", A, x) - b)
        most = np.abs(x).max(1, keepdims=True, initial=0.0)
        ends = (solved <= _SOLVED * (1 + np.abs(b) + most)).all(1)
        return replace(states, values={**states.values, **found}), ends

    def _begun(self, states: AdmissibleStates, names: Sequence[str]) -> AdmissibleStates:
        """The states with what is given of some names, and 0 for the others."""
        values = {x: np.full(states.count, self.given.get(x, 0.0)) for x in names}
        return replace(states, values={**states.values, **values})

    def _size_of(self, name: str) -> float:
        """The scale of a rate or acceleration; multipliers are as large as weights."""
        sizes = dict(zip(self._names, self._scale, strict=True))
        return float(sizes.get(name.removesuffix(atom(name).ending), 1.0))

    def _at_rest(self, states: AdmissibleStates) -> AdmissibleStates | None:
        """Positions at which what nothing drives stays where it is."""
        rows = self._at_rest_rows
        scale = np.array([self._size_of(x) for x in rows.names])
        found = self._closed(states, rows, rows.names, scale)
        return found if found.count else None

    # ------------------------------------------------------------ equations
    @property
    def multipliers(self) -> tuple[str, ...]:
        system = self.setting.system
        return () if system is None else multiplier_names(system.loops)

    @cached_property
    def loops(self) -> tuple[list[Trig], list[Trig], list[Trig]]:
        """The polynomials Φ, Φ̇ and Φ̈."""
        system, rates = self.setting.system, self.setting.symbols.rates
        Phi = [] if system is None else [self.setting.element(x) for x in system.loops.Phi]
        first = [x.along(rates) for x in Phi]
        return Phi, first, [x.along(rates) for x in first]

    @cached_property
    def _rows(self) -> Rows:
        """The equations that close loops, where some coordinates are given."""
        return Rows(self.loops[0], self._loose)

    @cached_property
    def _any_rows(self) -> Rows:
        """Equations that close loops, as rows over all names."""
        return Rows(self.loops[0], self._names)

    @cached_property
    def _of_rates(self) -> Rows:
        """The equations of rates that keep loops closed."""
        return Rows(self.loops[1], self._not_given(x + RATE for x in self._names))

    @property
    def _unknown(self) -> list[str]:
        """Accelerations and multipliers, which the equations of motion tell."""
        second = () if self.still else (x + SECOND for x in self._names)
        return self._not_given([*second, *self.multipliers])

    def _not_given(self, names: Iterable[str]) -> list[str]:
        return [x for x in names if x not in self.given]

    @cached_property
    def _of_forces(self) -> Rows:
        """The equations of motion of which accelerations and multipliers follow."""
        return Rows([*([] if self.still else self.loops[2]), *self.passive], self._unknown)

    @cached_property
    def _at_rest_rows(self) -> Rows:
        """The equations of a robot that stays at rest by itself."""
        names = self._not_given([*self._names, *self.multipliers])
        return Rows([*self.loops[0], *self.passive], names)

    @cached_property
    def passive(self) -> list[Trig]:
        """The generalized forces that nothing gives."""
        passive = self.setting.symbols.model.passive
        if self.acting:
            held = self.setting.held(self.acting)
            return [held[k] for k in passive]
        forces = self.setting.all_of("tau")
        return [self.setting.element(forces[k]) for k in passive]


@dataclass(frozen=True, eq=False)
class Rows:
    """Polynomials that are to vanish, and names that may be changed for it."""

    polynomials: Sequence[Trig]
    names: Sequence[str]

    def at(self, states: StateValues) -> AnyArray:
        """Their values, a row for each state."""
        fresh = StateValues(states.values)
        return np.array([x.value for x in self._own.at(fresh)]).reshape(-1, fresh.count).T

    def slopes_at(self, states: StateValues) -> AnyArray:
        """Their derivatives by the names."""
        fresh = StateValues(states.values)
        found = np.zeros((states.count, len(self.polynomials), len(self.names)))
        for (i, k), x in zip(self._slopes, self._by_names.at(fresh), strict=True):
            found[:, i, k] = x.value
        return found

    @cached_property
    def _own(self) -> Polynomials:
        return Polynomials(self.polynomials)

    @cached_property
    def _by_names(self) -> Polynomials:
        return Polynomials(list(self._slopes.values()))

    @cached_property
    def _slopes(self) -> dict[tuple[int, int], Trig]:
        entries = {
            (i, k): x.derivative(name)
            for i, x in enumerate(self.polynomials)
            for k, name in enumerate(self.names)
        }
        return {at: x for at, x in entries.items() if not x.is_zero}
