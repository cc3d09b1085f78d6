"""Kinds of the symbols of a model (angles by parallel axes, masses by body, gravity, rates) and
their order."""

from __future__ import annotations

import re
from dataclasses import dataclass, fields, is_dataclass
from fractions import Fraction
from typing import Any

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.expressions.polynomials.angle_sums import AngleBlocks
from freebody.expressions.polynomials.symbols import RATE, SECOND, Symbols
from freebody.lazy import cached_property
from freebody.model.bodies import Body
from freebody.model.parameters import Parameter, each_parameter
from freebody.model.placement import AxisRotation
from freebody.scalars.generators import sign_of
from freebody.scalars.rational import rational_sin_cos
from freebody.spatial import neg

Rank = tuple[int, int, int, str]
"""Kind, joint, and then by name."""


@dataclass(frozen=True)
class Order:
    """Kinds and order of a model's symbols, so that terms can be grouped and factors ordered."""

    symbols: Symbols

    @cached_property
    def angles(self) -> tuple[str, ...]:
        """Names of the angles whose sines and cosines are generators, in the order of the
        joints."""
        return self.symbols.ring.angles

    @cached_property
    def blocks(self) -> AngleBlocks:
        """The angles by parallel axes: those of one block turn about the same direction."""
        bodies = self.symbols.tree.bodies
        blocks: list[list[str]] = []
        block_of: dict[int, list[str]] = {}
        for i, body in enumerate(bodies):
            if not body.primitive.turns:
                continue
            name = self.symbols.coordinates[body.coordinates.v[0]]
            leader = self._parallel(i)
            block = block_of[leader] if leader is not None else []
            block_of[i] = block
            if not any(name in other for other in blocks):
                if not block:
                    blocks.append(block)
                block.append(name)
        known = {name for block in blocks for name in block}
        return (*map(tuple, blocks), *((x,) for x in self.angles if x not in known))

    def _parallel(self, i: int) -> int | None:
        """The nearest body that turns under body i, if its axis is parallel to that of i."""
        bodies = self.symbols.tree.bodies
        space = self.symbols.tree.space
        axis = bodies[i].axis
        while True:
            axis, i = space.turn(bodies[i].R, axis), bodies[i].parent
            if i < 0:
                return None
            if bodies[i].primitive.turns:
                own = bodies[i].axis
                return i if axis in (own, neg(own)) else None

    @cached_property
    def inertial(self) -> dict[str, tuple[int, int]]:
        """(body, 0 of a mass or 1 of a moment of inertia) of each inertial parameter."""
        rank: dict[str, tuple[int, int]] = {}
        for i, body in enumerate(self.symbols.model.bodies):
            for part in body.inertias:
                for kind, quantity in enumerate((part.inertia.mass, part.inertia.tensor)):
                    for parameter in each_parameter(quantity):
                        rank.setdefault(parameter.name, (i, kind))
        return rank | dict(self.symbols.inertial)

    @cached_property
    def gravity(self) -> str:
        """Name of gravity's magnitude; "" where it has no symbol."""
        size = self.symbols.model.gravity_size
        return size.name if isinstance(size, Parameter) else ""

    @cached_property
    def moving(self) -> frozenset[str]:
        """Names of velocities, accelerations, signs of velocities, and of all symbols that are not
        the model's own."""
        names = self.symbols.coordinates
        signs = (sign_of(x + RATE) for x in names)
        return frozenset(
            [*signs, *(x + e for x in names for e in (RATE, SECOND)), *self.symbols.extra]
        )

    @cached_property
    def decimal(self) -> bool:
        """Whether numbers are measured ones, printed as decimals."""
        return self.symbols.reader.numbers or _holds_decimals(self.symbols.model.bodies)

    @cached_property
    def _ranks(self) -> dict[str, Rank]:
        return {}

    def rank(self, name: str) -> Rank:
        """Order of the symbols in a product: inertia, gravity, lengths and coordinates by joint,
        rates."""
        found = self._ranks.get(name)
        if found is None:
            found = self._ranks[name] = self._rank(name)
        return found

    def _rank(self, name: str) -> Rank:
        kind = (
            0
            if name in self.inertial
            else 1
            if name == self.gravity
            else 3
            if name in self.moving
            else 2
        )
        digits = re.search(r"\d+", name)
        return kind, int(digits[0]) if digits else 0, name not in self.symbols.coordinates, name

    def number(self, value: Fraction) -> Expression:
        """A polynomial's coefficient as an expression."""
        return ex.num(
            value,
            self.decimal
            or value.denominator > 64
            or bool(value.denominator % 2 and value.denominator > 9),
        )


def _holds_decimals(thing: Any) -> bool:
    """Whether inertias, placements, drives or followers hold plain numbers that are not whole,
    right angles apart."""
    if isinstance(thing, AxisRotation):
        angle = thing.angle
        return isinstance(angle, (int, float)) and bool(rational_sin_cos(angle)[0].denominator != 1)
    if isinstance(thing, Body):
        joint = thing.joint
        own = (thing.inertias, joint.placement, joint.drive)
        if joint.mimic is not None:
            offset = joint.mimic.offset
            own = (
                *own,
                joint.mimic.ratio,
                AxisRotation("z", offset) if thing.kind.turns else offset,
            )
        return _holds_decimals(own)
    if isinstance(thing, tuple):
        return any(map(_holds_decimals, thing))
    if is_dataclass(thing) and not isinstance(thing, Parameter):
        return any(_holds_decimals(getattr(thing, f.name)) for f in fields(thing))
    return isinstance(thing, float) and not thing.is_integer()
