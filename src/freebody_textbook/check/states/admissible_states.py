"""Random states that a robot can have: loops closed on every branch, regular positions, joints
without drives obeying the equations of motion."""

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
from freebody_textbook.closed_chains.first_kind import multiplier_names

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
    """A collection of states. parameters: the number of each state's parameter set; branch: of its
    branch within that set, 0 for the home position's."""

    parameters: AnyArray
    branch: AnyArray

    @property
    def is_home(self) -> AnyArray:
        """Flags of the states on the home position's branch."""
        return self.branch == 0

    def with_any(self, coordinates: Collection[str]) -> AdmissibleStates:
        """The states with random rates, accelerations and some random coordinates, for which loops
        need not stay closed."""
        chance = np.random.default_rng(29)
        values = {
            name: chance.normal(size=self.count) if atom(name).dots or name in coordinates else x
            for name, x in self.values.items()
        }
        return replace(self, values=values)

    def chosen(self, which: AnyArray) -> AdmissibleStates:
        """The selected states of the collection."""
        values = {name: x[which] for name, x in self.values.items()}
        return AdmissibleStates(values, self.parameters[which], self.branch[which])


def _together(parts: Sequence[AdmissibleStates]) -> AdmissibleStates:
    """Several collections of states joined into one."""
    return AdmissibleStates(
        {name: np.concatenate([x.values[name] for x in parts]) for name in parts[0].values},
        np.concatenate([x.parameters for x in parts]),
        np.concatenate([x.branch for x in parts]),
    )


@dataclass(frozen=True, eq=False)
class StateSampler:
    """Draws random states of a model. own_values: with the model's parameter values, which
    otherwise vary; still: positions of equilibrium; given: values of some names in all states;
    acting: under an external force alone, or with weights or motion."""

    setting: RightEquations
    own_values: bool = False
    still: bool = False
    given: Mapping[str, float] = field(default_factory=dict[str, float])
    acting: ActingLoads = ""
    images: Mapping[str, Value] = field(default_factory=dict[str, Value])
    """Values of some names by the others, as velocities and accelerations of a free body."""

    def states(self) -> AdmissibleStates | None:
        """Random states, the same at each call; None for a chain that cannot be closed."""
        chance = np.random.default_rng(28)
        drawn = [self._of_one_set(chance, k) for k in range(PARAMETER_SETS)]
        parts = [x for x in drawn if x is not None and x.count]
        return _together(parts) if parts else None

    def at_values(
        self, states: AdmissibleStates, values: Mapping[str, float]
    ) -> AdmissibleStates | None:
        """The states with other values of masses or weights at the same positions and rates, with
        the resulting accelerations and multipliers."""
        others = {name: np.full(states.count, x) for name, x in values.items()}
        changed = replace(states, values={**states.values, **others})
        return self._pressed(np.random.default_rng(28), changed)

    def _of_one_set(self, chance: np.random.Generator, k: int) -> AdmissibleStates | None:
        """Random states for one set of parameters."""
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
        """Parameter values for the k-th set of states."""
        found = {}
        for name, x in self.setting.symbols.model.parameters.items():
            varied = chance.uniform(1 - _VARIED, 1 + _VARIED)
            if x is not None and name in self.setting.ring.index:
                found[name] = x if self.own_values else x * varied
        return found

    def _guesses(self, chance: np.random.Generator, count: int) -> dict[str, AnyArray]:
        """Starting guesses for positions; the first is the home position."""
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
        """The home position of the robot's file, in the answer's coordinates."""
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
        """A typical length of the robot: the mean of its parameters in metres."""
        model, units = self.setting.symbols.model, self.setting.units
        lengths = [abs(x) for k, x in model.parameters.items() if x and units.get(k) == "m"]
        return float(np.mean(lengths)) if lengths else 1.0

    @cached_property
    def _scale(self) -> AnyArray:
        """Scale of each coordinate: a radian for angles, a typical length for slides."""
        angles = self.setting.ring.angles
        return np.array([1.0 if x in angles else self._length for x in self._names])

    @cached_property
    def _loose(self) -> tuple[str, ...]:
        """Coordinates without a given value."""
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
        """The states reached from closed positions when the given coordinates are moved to their
        values; states that cannot follow are left out."""
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
        """The nearest states at which the rows vanish, by Newton's method; states that do not
        converge are left out."""
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
        """Smallest nonzero singular value of the rows' Jacobian at each state, relative to the
        largest; the rank is that of generic positions."""
        values = self._singular_values(states, rows)
        rank = int((values > _DEPENDENT).sum(1).max())
        return values[:, rank - 1] if rank else np.ones(states.count)

    def _singular_values(self, states: AdmissibleStates, rows: Rows) -> AnyArray:
        values = np.linalg.svd(self._normed(states, rows), compute_uv=False)
        return values / np.maximum(values[:, :1], 1e-300)

    def _normed(self, states: AdmissibleStates, rows: Rows) -> AnyArray:
        """The loop Jacobian Φ_q scaled by angles and lengths, with rows of unit length."""
        slopes = rows.slopes_at(states) * self._loose_scale
        return slopes / np.maximum(np.linalg.norm(slopes, axis=2, keepdims=True), 1e-300)

    def _apart(self, states: AdmissibleStates) -> AdmissibleStates:
        """The home position, if it is among the states, and the others that are farthest from each
        other."""
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
        """States along the branches of the starting states, reached by small steps."""
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
        """The nearest positions with closed loops, and their scaled distance; infinite if there are
        none."""
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
        """The states with coordinates changed by scaled steps."""
        moved = {
            x: states.values[x] + step * s
            for x, step, s in zip(self._loose, steps.T, self._loose_scale, strict=True)
        }
        return replace(states, values={**states.values, **moved})

    def _free(self, states: AdmissibleStates, rows: Rows, wanted: AnyArray) -> AnyArray:
        """The component of a scaled velocity that the loops allow."""
        slopes = self._normed(states, rows)
        held = np.einsum("kij,kj->ki", slopes, wanted)
        free = wanted - np.einsum("kij,kj->ki", np.linalg.pinv(slopes, rcond=_DEPENDENT), held)
        return np.where(np.abs(free) > _DEPENDENT, free, 0.0)

    # ------------------------------------------------------------ motion
    def _moving(self, chance: np.random.Generator, states: AdmissibleStates) -> AdmissibleStates:
        """The states with random rates that keep the loops closed."""
        moving = self._begun(states, [x + RATE for x in self._names])
        return moving if self.still else self._solved(chance, moving, self._of_rates)[0]

    def _pressed(
        self, chance: np.random.Generator, states: AdmissibleStates
    ) -> AdmissibleStates | None:
        """The states with accelerations and multipliers that keep the loops closed and satisfy the
        equations of joints without a drive."""
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
        """The states with names set so that rows linear in them vanish; states without a solution
        are left out."""
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
        """The states with given values of some names, and 0 for the other names."""
        values = {x: np.full(states.count, self.given.get(x, 0.0)) for x in names}
        return replace(states, values={**states.values, **values})

    def _size_of(self, name: str) -> float:
        """Typical size of a rate, acceleration or multiplier; multipliers are as large as
        weights."""
        sizes = dict(zip(self._names, self._scale, strict=True))
        return float(sizes.get(name.removesuffix(atom(name).ending), 1.0))

    def _at_rest(self, states: AdmissibleStates) -> AdmissibleStates | None:
        """Positions of equilibrium, where joints without drives stay at rest; None if there are
        none."""
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
        """The loop equations' polynomials Φ, Φ̇ and Φ̈."""
        system, rates = self.setting.system, self.setting.symbols.rates
        Phi = [] if system is None else [self.setting.element(x) for x in system.loops.Phi]
        first = [x.along(rates) for x in Phi]
        return Phi, first, [x.along(rates) for x in first]

    @cached_property
    def _rows(self) -> Rows:
        """The equations for closing the loops when some coordinates are given."""
        return Rows(self.loops[0], self._loose)

    @cached_property
    def _any_rows(self) -> Rows:
        """The loop equations as rows over all names."""
        return Rows(self.loops[0], self._names)

    @cached_property
    def _of_rates(self) -> Rows:
        """The equations for rates that keep the loops closed."""
        return Rows(self.loops[1], self._not_given(x + RATE for x in self._names))

    @property
    def _unknown(self) -> list[str]:
        """Names of the accelerations and multipliers, to be determined from the equations of
        motion."""
        second = () if self.still else (x + SECOND for x in self._names)
        return self._not_given([*second, *self.multipliers])

    def _not_given(self, names: Iterable[str]) -> list[str]:
        return [x for x in names if x not in self.given]

    @cached_property
    def _of_forces(self) -> Rows:
        """The equations of motion for accelerations and multipliers."""
        return Rows([*([] if self.still else self.loops[2]), *self.passive], self._unknown)

    @cached_property
    def _at_rest_rows(self) -> Rows:
        """The equations of a robot at rest in equilibrium."""
        names = self._not_given([*self._names, *self.multipliers])
        return Rows([*self.loops[0], *self.passive], names)

    @cached_property
    def passive(self) -> list[Trig]:
        """The generalized forces that must vanish, as no drive supplies them."""
        passive = self.setting.symbols.model.passive
        if self.acting:
            held = self.setting.held(self.acting)
            return [held[k] for k in passive]
        forces = self.setting.all_of("tau")
        return [self.setting.element(forces[k]) for k in passive]


@dataclass(frozen=True, eq=False)
class Rows:
    """Polynomials that must vanish, and the names that may change for it."""

    polynomials: Sequence[Trig]
    names: Sequence[str]

    def at(self, states: StateValues) -> AnyArray:
        """The polynomials' values, one row per state."""
        fresh = StateValues(states.values)
        return np.array([x.value for x in self._own.at(fresh)]).reshape(-1, fresh.count).T

    def slopes_at(self, states: StateValues) -> AnyArray:
        """The polynomials' derivatives by the names, at each state."""
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
