"""Quantities of bodies that are vectors, in the axes that `fb.quantities` uses."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import reduce
from operator import getitem
from typing import Any, ClassVar

from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Matrix, dot, identity, times, transposed
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup, column, components
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, BodyQuantity, numbers
from freebody_textbook.relations.quantities import QuantityValues, branches

_WORLD = "This would be right in the world's axes; here the components are along those of body {}."

_TRANSPOSED = "This is its transpose, which turns the other way."


class QuantitiesOfBodies(QuantityGroup):
    """Vectors and tensors of bodies, ω_2, r_c2, v_c2, f_12, …, whole and by components."""

    records = tuple(x for x in BODY_QUANTITIES if not x.is_scalar)
    in_equations_of_bodies: ClassVar[Mapping[str, str]] = {"g": "gravity"}

    def single(self) -> Iterator[NamedTarget]:
        yield from components(self.vectors)
        yield from self._rates_of_components()
        yield from self._of_the_only_body()
        yield from self._coordinates_of_centres()

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self.vectors

    @cached_property
    def _bodies(self) -> list[dict[str, Any]]:
        """Values of `fb.quantities` for each body, in order of the bodies' numbers."""
        values = QuantityValues(self._setting, "base" if self.based else "explicit")
        return [values.of_body(i) for i in self._setting.order]

    @cached_property
    def vectors(self) -> dict[str, QuantityTable]:
        """Vectors of bodies by name, in the axes that `fb.quantities` uses."""
        tree = self.setting.equations.symbols.tree
        chain = not branches(tree) and self.setting.system is None
        dim = self.setting.symbols.model.dim
        records = [x for x in self.records if dim == 3 or not x.matrix]  # I_1 is a parameter there
        found = {"gravity": self._constants("the gravitational acceleration", tree.gravity)}
        found["z"] = self._constants("the world's z axis", (0.0, 0.0, 1.0))
        for n in range(1, len(tree.bodies) + 1):
            for record in records:
                known = record.known.format(**numbers(n)) in self._bodies[n - 1]
                if known and (chain or record.of_motion):
                    table = self._table_of(record, n, dim)
                    found |= dict.fromkeys(
                        (name for name in record.spelt(n) if name not in found), table
                    )
        for n, i in enumerate(self._setting.order, 1):
            found |= self._axis(found, i, n)
            found |= {} if self.setting.is_planar else self._rates_in_world(found, n)
        if self.setting.is_planar:
            own = {name: name.replace("omega", "w") for name in found if "omega" in name}
            found |= {new: found[name] for name, new in own.items()}
        return found if self.setting.is_planar else self._turns(len(tree.bodies)) | found

    def _rates_in_world(
        self, found: Mapping[str, QuantityTable], n: int
    ) -> dict[str, QuantityTable]:
        """The vectors ṙ_c2 and r̈_c2 of body n: derivatives of the world components, or vectors in
        the body's axes."""
        rates: dict[str, QuantityTable] = {}
        for dots, letter in ((1, "v"), (2, "a")):
            column = [
                [replace(x, compute=x.in_world, in_world=None, also=(("", x.compute),))]
                for (x,) in found.get(f"{letter}c{n}", ())
                if x.in_world is not None
            ]
            for place in ("rc", "rG"):
                rates |= dict.fromkeys(spellings(place, str(n), dots), column) if column else {}
        return rates

    def _axis(self, found: Mapping[str, QuantityTable], i: int, n: int) -> dict[str, QuantityTable]:
        """The unit vector of joint n's axis: u_n of a sliding joint, z_n of a turning one; in space
        in the axes of body n, where z_n may also be the z axis of body n in world axes."""
        s = self._setting
        if s.turns(i) and s.planar:
            return {}
        letter, does = ("z", "turns about") if s.turns(i) else ("u", "slides along")
        words = f"the axis that joint {n} {does}"
        own = (self.element(lambda x=x: x) for x in s.axis(i))
        table = column(kinds.OF_BODY, own, words, (n,))
        world = s.world[i][0]
        for R, row, (told,) in zip(world, table, found.get(f"z{n}", ()), strict=False):
            turned = self.element(lambda R=R: dot(R, s.axis(i)))
            note = f"It is read as {told.words} in the world's axes."
            row[0] = replace(row[0], in_world=turned, also=((note, told.compute),))
        return {f"{letter}{n}": table}

    def _turns(self, count: int) -> dict[str, QuantityTable]:
        """The rotation matrices R_k^i between any two bodies, named R20 for R_0^2, which turns
        components in the axes of body 0 into those of body 2."""
        bodies = [-1, *self._setting.order]
        return {
            f"R{b}{a}": self._turn(bodies[a], bodies[b], f"from body {a} to body {b}")
            for a in range(count + 1)
            for b in range(count + 1)
            if a != b
        }

    def _turn(self, a: int, b: int, words: str) -> QuantityTable:
        of = [self._setting.world[i][0] if i >= 0 else identity(3) for i in (a, b)]
        first, second = map(transposed, of)

        def entry(i: int, j: int) -> Callable[[], Trig]:
            return self.element(lambda: dot(second[i], first[j]))

        return [
            [
                AskedQuantity(
                    kinds.OF_BODY, (i + 1, j + 1), entry(i, j), words=f"the rotation {words}",
                    thoughts=((_TRANSPOSED, entry(j, i)),),
                )
                for j in range(3)
            ]
            for i in range(3)
        ]  # fmt: skip

    def _constants(self, words: str, vector: Sequence[Any]) -> QuantityTable:
        return column(kinds.OF_BODY, (self.element(lambda x=x: x) for x in vector), words)

    def _table_of(self, record: BodyQuantity, n: int, dim: int) -> QuantityTable:
        """The entries of one vector or tensor of body n as quantities."""
        known, words = record.known.format(**numbers(n)), record.told(n)

        def entry(*at: int, axis: str = "") -> AskedQuantity:
            index = (n,) if axis or not at else tuple(k + 1 for k in at)
            own, thoughts, world = self._part(n, known, *at), [], None
            if record.reaction:
                text = record.reaction.format(**numbers(n))
                thoughts.append((text, lambda: own() * -1))
            if record.matrix == "rotation":
                thoughts.append((_TRANSPOSED, self._part(n, known, *at[::-1])))
            if record.matrix == "tensor":
                world = self._inertia_in_world(n, *at)
            if axis and record.own_axes and dim == 3:
                world = self._in_world(n, known, at[0])
                thoughts.append((_WORLD.format(n), world))
            return AskedQuantity(
                record.kind, index, own, axis=axis, in_world=world, words=words,
                thoughts=tuple(thoughts), is_angular=record.angular,
            )  # fmt: skip

        if record.matrix:
            return [[entry(i, j) for j in range(3)] for i in range(3)]
        axes = record.axes(dim)
        return [[entry(k, axis=axis)] for k, axis in enumerate(axes)] if axes else [[entry()]]

    def _rates_of_components(self) -> Iterator[NamedTarget]:
        """Rates of vector components, v_c2x with dots after the axis: vc2x_d."""
        for n in range(1, len(self._bodies) + 1):
            for record in (x for x in self.records if any(dots for _, dots in x.names)):
                for (entry,) in self.vectors.get(next(record.spelt(n)), ()):
                    yield tuple(record.spelt(n, entry.axis)), entry

    def _of_the_only_body(self) -> Iterator[NamedTarget]:
        """The components ω_x, ω̇_x and M_x of the only body with mass in a spatial model, such as a
        gyro."""
        tree = self.setting.equations.symbols.tree
        heavy = [
            n for n in range(1, len(tree.bodies) + 1) if tree.bodies[tree.body_of[n - 1]].masses
        ]
        if self.setting.is_planar or len(heavy) != 1:
            return
        (n,) = heavy
        for name, letters, dots in (
            ("omega", ("omega", "w"), 0),
            ("omega", ("omega", "w"), 1),
            ("nc", ("M", "n", "N"), 0),
        ):
            column = self.vectors.get(next(iter(spellings(name, str(n), dots))), ())
            for (entry,) in column:
                names = (spellings(letter, entry.axis, dots) for letter in letters)
                yield tuple(itertools.chain.from_iterable(names)), entry

    def _coordinates_of_centres(self) -> Iterator[NamedTarget]:
        """Coordinates of the centres of mass, x_c2, ẋ_c2, ẍ_c2: components of r_c2, v_c2 and a_c2.
        In space the last two are in the body's axes, hence no derivatives of coordinates."""
        of_rates = "rva" if self.setting.symbols.model.dim == 2 else "r"
        for n in range(1, len(self._bodies) + 1):
            for dots, letter in enumerate(of_rates):
                for (entry,) in self.vectors.get(f"{letter}c{n}", ()):
                    names = (spellings(entry.axis, f"{place}{n}", dots) for place in "cGC")
                    yield tuple(itertools.chain.from_iterable(names)), entry

    def _world(self, n: int) -> Matrix:
        """The rotation matrix of body n."""
        return self._setting.world[self._setting.order[n - 1]][0]

    def _in_world(self, n: int, name: str, row: int) -> Callable[[], Trig]:
        """A component in world axes of a body's vector that is given in body axes."""
        return self.element(lambda: dot(self._world(n)[row], self._bodies[n - 1][name]))

    def _inertia_in_world(self, n: int, i: int, j: int) -> Callable[[], Trig]:
        """An entry of a body's inertia tensor in world axes, R I Rᵀ."""
        R, of_body = self._world(n), self._bodies[n - 1]
        return self.element(lambda: dot(R[i], times(of_body[f"I{n}"], R[j])))

    def _part(self, n: int, name: str, *at: int) -> Callable[[], Trig]:
        """An entry of a quantity of body n from `fb.quantities`."""
        return self.element(lambda: reduce(getitem, at, self._bodies[n - 1][name]))
