"""Motions of a closed chain, drawn at random, at which its loops are closed: what follows from the
loops is compared in numbers at all of them."""

from __future__ import annotations

import random
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import flint

from freebody.derivations.check.asked.inverse_functions import (
    BITS,
    NEAR,
    RandomPosition,
    ball,
)
from freebody.derivations.check.asked.right_equations import RightEquations
from freebody.derivations.closed_chains.first_kind import multiplier_names
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.scalars.rational import exactly
from freebody.scalars.trig import Trig

MOTIONS, MOST_COORDINATES = 12, 12
_STEPS, _TRIES = 60, 4
_DRAWN = (0.5, 1.5)
"""From where to where what has no value is drawn."""
_CLOSED = Fraction(1, 10**60)
"""The gap at which loops count as closed."""
_OFF = 0.05
"""By how much guesses, and by which share parameters, differ from the model's."""

Balls = dict[str, Any]


@dataclass(frozen=True)
class ClosedMotions:
    """Motions of a model; own_values: with the values of its parameters, which otherwise vary;
    still: positions at which it is held."""

    setting: RightEquations
    own_values: bool = False
    still: bool = False

    def hold(self, x: Trig) -> bool:
        """Whether a polynomial is 0 at all of them."""
        return self.all_have(lambda place: place.polynomial(x))

    def all_have(self, gap: Callable[[RandomPosition], Any]) -> bool:
        """Whether something vanishes at all of them."""
        with flint.ctx.workprec(BITS):
            places = map(self.place, range(MOTIONS))
            return all(place is not None and abs(gap(place)) < ball(NEAR) for place in places)

    def place(self, k: int) -> RandomPosition | None:
        """One of the motions, the same for each answer; None of a chain that is not closed, has too
        many joints or cannot be closed near its home."""
        names = self.setting.symbols.coordinates
        if self.setting.system is None or len(names) > MOST_COORDINATES:
            return None
        if k not in self._found:
            chance = random.Random(f"freebody closed motion {k}")
            with flint.ctx.workprec(BITS):
                drawn = (self._closed(self._drawn(chance)) for _ in range(_TRIES))
                self._found[k] = next(filter(None, drawn), None)
        return self._found[k]

    @cached_property
    def _found(self) -> dict[int, RandomPosition | None]:
        return {}

    def _drawn(self, chance: random.Random) -> Balls:
        """Random numbers, those of parameters and coordinates near the model's and its home's."""
        model, coordinates = self.setting.symbols.model, self.setting.symbols.coordinates
        home, near = dict(model.home), dict(model.parameters)
        for body, at in zip(model.bodies, model.coordinates, strict=True):
            near |= {coordinates[k]: home.get(body.joint.name, 0.0) for k in at.v}
        values: Balls = {}
        for name in self.setting.ring.names:
            x, drawn = near.get(name), round(chance.uniform(*_DRAWN), 6)
            if x is not None:
                off = round(chance.uniform(-_OFF, _OFF), 6)
                varies = name in coordinates or not self.own_values
                x = x + varies * off * (1 if name in coordinates else x)
            moves = name.endswith((RATE, SECOND))
            values[name] = ball(0 if self.still and moves else exactly(drawn if x is None else x))
        return values

    def _closed(self, values: Balls) -> RandomPosition | None:
        """The motion nearest to the values, by Newton's method; None where it does not come to an
        end, or the loops' equations depend on each other."""
        names, place = self.setting.symbols.coordinates, RandomPosition(values)

        def of(rows: Sequence[Trig]) -> list[Any]:
            return list(map(place.polynomial, rows))

        def moved(ending: str, gap: Sequence[Any]) -> bool:
            slopes = [[ball(0)] * len(names) for _ in gap]
            for (i, k), x in self._slopes.items():
                slopes[i][k] = place.polynomial(x)
            step = _shortest(slopes, gap)
            for name, by in zip(names if step else (), step, strict=True):
                values[name + ending] = (values[name + ending] - by).mid()
            return bool(step)

        Phi, *derivatives = self._rows
        for _ in range(_STEPS):
            gap = of(Phi)
            if all(abs(x) < ball(_CLOSED) for x in gap):
                break
            if not moved("", gap):
                return None
        else:
            return None
        linear = zip((RATE, SECOND), derivatives, strict=True)
        if not all(moved(x, of(rows)) for x, rows in linear):
            return None
        return place if self._pressed(place, values) else None

    def _pressed(self, place: RandomPosition, values: Balls) -> bool:
        """Whether multipliers are found with which nothing drives the passive joints."""
        setting = self.setting
        assert setting.system is not None
        names = multiplier_names(setting.system.loops)
        rows = [setting.element(setting.system.forces[k]) for k in setting.symbols.model.passive]
        if not rows or len(rows) > len(names):  # as of joints that yield: free multipliers
            return True
        slopes = [[place.polynomial(x.derivative(name)) for name in names] for x in rows]
        step = _shortest(slopes, [place.polynomial(x) for x in rows])
        for name, by in zip(names if step else (), step, strict=True):
            values[name] = (values[name] - by).mid()
        return True

    @cached_property
    def _rows(self) -> list[list[Trig]]:
        """Φ, Φ̇, Φ̈."""
        setting = self.setting
        assert setting.system is not None
        found = [[setting.element(x) for x in setting.system.loops.Phi]]
        for _ in (RATE, SECOND):
            found.append([x.along(setting.symbols.rates) for x in found[-1]])
        return found

    @cached_property
    def _slopes(self) -> dict[tuple[int, int], Trig]:
        """Φ_q, where it is not 0."""
        names, Phi = self.setting.symbols.coordinates, self._rows[0]
        entries = {
            (i, k): x.derivative(name) for i, x in enumerate(Phi) for k, name in enumerate(names)
        }
        return {at: x for at, x in entries.items() if not x.is_zero}


def _shortest(J: Sequence[Sequence[Any]], left: Sequence[Any]) -> list[Any]:
    """The shortest x with J x = left; empty where J has dependent rows."""
    A = flint.arb_mat([list(row) for row in J])
    b = flint.arb_mat([[x] for x in left])
    try:
        return [row[0] for row in (A.transpose() * (A * A.transpose()).solve(b)).tolist()]
    except ZeroDivisionError:
        return []
