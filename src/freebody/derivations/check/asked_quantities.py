"""What can be asked: τ_i, M_ij, c_i, g_i, J_ij, T, V, the tip's position, with their names and
right values."""

from __future__ import annotations

import itertools
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

from freebody.derivations.check.body_quantities import BODY_QUANTITIES, BodyQuantity, numbers
from freebody.derivations.check.right_equations import RightEquations
from freebody.derivations.check.vocabulary import spellings
from freebody.derivations.closed_chains.loops import LoopEquations
from freebody.derivations.equations.kinematics import Kinematics
from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.evaluate import arithmetic, evaluate
from freebody.derivations.expressions.expression import Expression
from freebody.derivations.methods.energies import Energies
from freebody.derivations.methods.setting import Setting
from freebody.derivations.notations.notation import BookNotation
from freebody.derivations.polynomials.determinant import determinant
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.relations.quantities import QuantityValues, branches
from freebody.derivations.render.literal import literal
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig

Values = list[Trig] | list[list[Trig]]
"""A vector or matrix."""


@dataclass(frozen=True)
class AskedQuantity:
    """One quantity: its family ("tau", "M", …), indices from 1, and how to compute the right
    value."""

    family: str
    index: tuple[int, ...]
    compute: Callable[[], Trig]
    idle: bool = False
    """Whether nothing drives the joint: the torque is 0, and that is its equation of motion."""
    joint: str = ""
    """The joint that it belongs to, in words."""
    axis: str = ""
    """Of a body's vector: x, y or z."""
    words: str = ""
    """What it is, where its family alone does not tell."""
    thoughts: tuple[tuple[str, Callable[[], Trig]], ...] = ()
    """What it is often mistaken for: a sentence that says so, and its value."""

    @property
    def title(self) -> str:
        """What it is, in words."""
        return self.words or _TITLES[self.family].format(*self.index, joint=self.joint)


_TITLES = {
    "tau": "the drive's torque or force at {joint}",
    "0": "which nothing drives",
    "M": "entry {}, {} of the mass matrix",
    "C": "entry {}, {} of the Coriolis matrix of Christoffel symbols",
    "christoffel": "the Christoffel symbol of the mass matrix of row {}, column {} and rate {}",
    "c": "the velocity term of {joint}",
    "bias": "the velocity and gravity terms of {joint}",
    "g": "the gravity term of {joint}",
    "J": "entry {}, {} of the tip's Jacobian",
    "T": "the kinetic energy",
    "V": "the potential energy",
    "L": "the Lagrangian",
    "Ti": "the kinetic energy of body {}",
    "Vi": "the potential energy of body {}",
    "h": "the velocity coefficient",
    "tip": "a coordinate of the tip",
    "tip_d": "a velocity of the tip",
    "tip_dd": "an acceleration of the tip",
    "det": "the determinant of the tip's Jacobian",
    "derivative": "a derivative of the robot's quantities",
    "q": "one of the coordinates and their rates",
    "identity": "an equation between the robot's quantities",
}
_LETTERS = {
    "tau": ("tau", "Q", "Gamma"),
    "M": ("M", "H", "m", "D", "d", "B", "b"),
    "C": ("C",),
    "c": ("c", "C", "v", "b"),
    "g": ("g", "G", "phi"),
    "J": ("J",),
    "T": ("T", "K", "KE", "Ek", "Ekin"),
    "V": ("V", "U", "P", "PE", "Ep", "Epot"),
    "L": ("L",),
    "bias": (),
}
"""Letters of quantities, where no notation says which."""
_WORLD = "This would be right in the world's axes; here the components are along those of body {}."


def letters_of(notation: BookNotation) -> Mapping[str, tuple[str, ...]]:
    """The letters of the families in a notation: those that it gives to one are no other's."""
    taken = {letter for letters in notation.letters.values() for letter in letters}
    usual = {
        family: tuple(letter for letter in letters if letter not in taken)
        for family, letters in _LETTERS.items()
    }
    return {**usual, **notation.letters}


AMBIGUOUS = frozenset(("B", "b", "d", "k", "phi", "v"))
"""Letters that some books have for these quantities, and others for something else."""
_TIP = {"x": ("x", "xP", "xp", "xE", "xtip", "px"), "y": ("y", "yP", "yp", "yE", "ytip", "py")}
_TIP["z"] = ("z", "zP", "zp", "zE", "ztip", "pz")


@dataclass(frozen=True)
class Targets:
    """The quantities of a model by name; `velocity`: also h, h1, … of the notes' form."""

    setting: RightEquations
    velocity: bool = False
    letters: Mapping[str, tuple[str, ...]] = field(default_factory=lambda: _LETTERS)
    """Letters of the families."""
    based: bool = False
    """Whether the base is accelerated by -g, which then is in all accelerations."""

    @property
    def count(self) -> int:
        """Number of coordinates."""
        return len(self.setting.symbols.coordinates)

    @cached_property
    def names(self) -> frozenset[str]:
        """All names, in plain spelling."""
        return frozenset([*self.single, *self.tables])

    @cached_property
    def alone(self) -> frozenset[str]:
        """Names that stand for vectors and matrices of bodies only."""
        return frozenset(name for name in self.tables if name not in self.single)

    @cached_property
    def single(self) -> dict[str, AskedQuantity]:
        """Quantities that are one polynomial."""
        found: dict[str, AskedQuantity] = {}
        for names, target in self._all():
            for name in names:
                found.setdefault(name, target)
        return found

    @cached_property
    def tables(self) -> dict[str, list[list[AskedQuantity]]]:
        """Vectors (one column) and matrices of quantities."""
        n = range(1, self.count + 1)
        found: dict[str, list[list[AskedQuantity]]] = {}
        for family in ("tau", "g", "bias", "c"):
            column = [[self._by_index[family, (i,)]] for i in n if self.letters[family]]
            found |= dict.fromkeys(self.letters[family], column) if column else {}
        if self.letters["c"]:
            found["V"] = found[self.letters["c"][0]]  # the potential energy is no vector
        for family in ("C", "M"):
            for letter in filter(str.isupper, self.letters[family]):
                found[letter] = [[self._by_index[family, (i, j)] for j in n] for i in n]
        coordinates = self.setting.symbols.coordinates
        for dots, ending in enumerate(("", RATE, SECOND) if self.count > 1 else ()):
            column = [[self._coordinate(x + ending)] for x in coordinates]
            for letter in ("q", "theta", "Theta"):
                found |= dict.fromkeys(spellings(letter, "", dots), column)
        found |= self._vectors
        if self.setting.system is not None:
            rows = range(1, len(self.setting.system.loops.names) + 1)
            found["Phi"] = [[self._by_index["Phi", (i,)]] for i in rows]
            found["Phiq"] = [[self._by_index["Phi_q", (i, j)] for j in n] for i in rows]
        if self._tip is not None:
            found["J"] = [[self.single[f"J{i}{j}"] for j in n] for i in self._rows]
            found |= self._tip_vectors(self._tip)
            found["JP"] = found["J"][: self.setting.symbols.model.dim]
        return found

    @cached_property
    def _by_index(self) -> dict[tuple[str, tuple[int, ...]], AskedQuantity]:
        return {(target.family, target.index): target for target in self.single.values()}

    @cached_property
    def passive(self) -> tuple[int, ...]:
        """Joints that nothing drives, from 1."""
        return tuple(k + 1 for k in self.setting.symbols.model.passive)

    # ------------------------------------------------------------ all of them
    def _all(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        alone = self.count == 1
        n = range(1, self.count + 1)
        if self.setting.system is not None:
            yield from self._loops(self.setting.system.loops)
        for i in n:
            yield (
                self._torque_names(i),
                AskedQuantity("tau", (i,), self._entry("tau", i), i in self.passive, f"joint {i}"),
            )
            for family in ("c", "g", "bias"):
                letters = self.letters[family]
                names = [f"{x}{i}" for x in letters] + ([*letters] if alone else [])
                yield (
                    tuple(names),
                    AskedQuantity(family, (i,), self._entry(family, i), False, f"joint {i}"),
                )
            for j in n:
                for family in ("M", "C"):
                    names = [f"{x}{i}{j}" for x in self.letters[family]] + (
                        ["M", "H", "m", "D"] if alone and family == "M" else []
                    )
                    yield tuple(names), AskedQuantity(family, (i, j), self._entry(family, i, j))
        yield from self._christoffel()
        yield from self._energies()
        yield from self._entries_of_bodies()
        yield from self._coordinates_of_centres()
        if self._tip is not None:
            yield from self._of_tip(self._tip)
        if self.velocity and self.setting.equations.is_short:
            yield from self._coefficients()

    def _torque_names(self, i: int) -> tuple[str, ...]:
        """τ_i; without number where it is the only one; F of a slide; u where there is one joint,
        or some are passive."""
        driven = [k for k in range(1, self.count + 1) if k not in self.passive]
        own = self.setting.symbols.coordinates[i - 1]
        letters = [
            *self.letters["tau"],
            *["F", "f"] * (own[0] in "dxyz"),
            *["u"] * (self.setting.system is None and (bool(self.passive) or self.count == 1)),
        ]
        numbers = (str(i), "") if driven == [i] else (str(i),)
        along = (f"F{own}", f"f{own}") if own in ("x", "y", "z") else ()
        return (*(letter + number for number in numbers for letter in letters), *along)

    def _entry(self, name: str, *index: int) -> Callable[[], Trig]:
        def value() -> Trig:
            parts = ("c", "g", "drives") if name == "bias" else (name,)
            return sum((part(x) for x in parts), self.setting.zero)

        def part(name: str) -> Trig:
            found: Any = self.setting.all_of(name)
            for i in index:
                found = found[i - 1]
            return self.setting.element(found)

        return value

    def _christoffel(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        """Spong's c_ijk, of which C_kj is the sum over i of c_ijk q̇_i, and Γ_ijk of Murray, Li and
        Sastry, of which C_ij is the sum over k of Γ_ijk q̇_k: Γ_kji = c_ijk."""
        n = range(1, self.count + 1)
        for i, j, k in itertools.product(n, repeat=3):
            value = self._symbol_of_christoffel(i - 1, j - 1, k - 1)
            target = AskedQuantity("christoffel", (k, j, i), value)
            yield (f"c{i}{j}{k}", f"Gamma{k}{j}{i}"), target

    def _symbol_of_christoffel(self, i: int, j: int, k: int) -> Callable[[], Trig]:
        def value() -> Trig:
            M, ring = self.setting.all_of("M"), self.setting.ring
            q = self.setting.symbols.coordinates
            m = {x: self.setting.element(M[x[0]][x[1]]) for x in ((k, j), (k, i), (i, j))}
            half = ring.polynomial([({}, Fraction(1, 2))])
            slopes = m[k, j].derivative(q[i]) + m[k, i].derivative(q[j]) - m[i, j].derivative(q[k])
            return slopes * half

        return value

    def _energies(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        eq = self.setting.equations
        bodies = len(eq.symbols.model.bodies)
        for family in ("T", "V"):
            yield self.letters[family], AskedQuantity(family, (), self._entry(family))
            for i in range(1, bodies + 1):
                letters = (*self.letters[family], *["k"] * (family == "T"))
                names = tuple(f"{x}{i}" for x in letters)
                yield names, AskedQuantity(f"{family}i", (i,), self._of_body(family, i - 1))
        sum_of_both = ("L = T − V, not T + V.", lambda: self.setting.element(eq.T + eq.V))
        yield (
            self.letters["L"],
            AskedQuantity(
                "L", (), lambda: self.setting.element(eq.T - eq.V), thoughts=(sum_of_both,)
            ),
        )

    def _of_body(self, family: str, body: int) -> Callable[[], Trig]:
        """An energy of a body with all that is fixed to it."""

        def value() -> Trig:
            s = self._setting
            energies, i = Energies(s, s.motion), s.tree.body_of[body]
            return self.setting.element(
                energies.kinetic(i) if family == "T" else energies.potential(i)
            )

        return value

    def _loops(self, loops: LoopEquations) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        """The equations of closed loops, Φ = 0, and Φ_q."""
        for i, name in enumerate(loops.names, 1):
            value = self._element(lambda i=i: loops.Phi[i - 1])
            words = f"the loop equation {literal(name)}"
            yield (f"Phi{i}",), AskedQuantity("Phi", (i,), value, words=words)
            value = self._element(lambda i=i: loops.c[i - 1])
            words = f"what row {i} of Φ_q q̈ must be"
            yield (f"c{i}", f"gamma{i}"), AskedQuantity("closing", (i,), value, words=words)
            for j in range(1, self.count + 1):
                value = self._element(
                    lambda i=i, j=j: self.setting.forces(loops.Phi_q[i - 1])[j - 1]
                )
                words = f"entry {i}, {j} of the Jacobian of the loop equations"
                yield (f"Phiq{i}{j}",), AskedQuantity("Phi_q", (i, j), value, words=words)

    # ------------------------------------------------------------ bodies
    @cached_property
    def _setting(self) -> Setting:
        return Setting(self.setting.equations.symbols)

    @cached_property
    def _bodies(self) -> list[dict[str, Any]]:
        """What `fb.quantities` tells of each body, in the order of their numbers."""
        values = QuantityValues(self._setting, "base" if self.based else "explicit")
        return [values.of_body(i) for i in self._setting.order]

    @cached_property
    def _vectors(self) -> dict[str, list[list[AskedQuantity]]]:
        """Vectors of bodies, in the axes in which `fb.quantities` gives them."""
        tree = self.setting.equations.symbols.tree
        if tree.follows:
            return {}
        chain = not branches(tree) and self.setting.system is None
        dim = self.setting.symbols.model.dim
        found = {"gravity": self._constants("the gravitational acceleration", tree.gravity)}
        found["z"] = self._constants("the world's z axis", (0.0, 0.0, 1.0))
        for n in range(1, len(tree.bodies) + 1):
            for record in BODY_QUANTITIES:
                whole = len(tree.bodies[tree.body_of[n - 1]].masses) < 2
                is_told = chain or record.of_motion
                if (
                    is_told
                    and record.exists(n, len(tree.bodies), dim)
                    and (whole or not record.of_centre)
                ):
                    table = self._table_of(record, n, dim)
                    found |= dict.fromkeys(
                        (name for name in record.spelt(n) if name not in found), table
                    )
        return found

    def _coordinate(self, name: str) -> AskedQuantity:
        """An entry of q, q̇ or q̈."""
        return AskedQuantity("q", (), lambda: self.setting.ring[name])

    def _constants(self, words: str, vector: Sequence[Any]) -> list[list[AskedQuantity]]:
        element = self.setting.equations.symbols.element
        values = [self._element(lambda x=x: element(x)) for x in vector]
        return [
            [AskedQuantity("of body", (), value, axis=axis, words=words)]
            for axis, value in zip("xyz", values, strict=False)
        ]

    def _table_of(self, record: BodyQuantity, n: int, dim: int) -> list[list[AskedQuantity]]:
        """The entries of one quantity of body n."""
        known, words = record.known.format(**numbers(n)), record.title.format(n=n)

        def entry(*at: int, axis: str = "") -> AskedQuantity:
            index = (n,) if axis or not at else tuple(k + 1 for k in at)
            own, thoughts = self._part(n, known, *at), []
            if record.reaction:
                text = record.reaction.format(**numbers(n))
                thoughts.append((text, lambda: own() * -1))
            if axis and record.own_axes and dim == 3:
                thoughts.append((_WORLD.format(n), self._in_world(n, known, at[0])))
            return AskedQuantity("of body", index, own, False, "", axis, words, tuple(thoughts))

        if record.turns:
            return [[entry(i, j) for j in range(3)] for i in range(3)]
        axes = record.axes(dim)
        return [[entry(k, axis=axis)] for k, axis in enumerate(axes)] if axes else [[entry()]]

    @cached_property
    def soft(self) -> frozenset[str]:
        """Names of vectors of bodies that users often give to things of their own."""
        n = range(1, self.count + 1)
        return frozenset(
            name for record in BODY_QUANTITIES if record.soft for i in n for name in record.spelt(i)
        )

    def _entries_of_bodies(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        for name, table in self._vectors.items():
            for row in table:
                for entry in row:
                    if entry.axis or len(table) == 1:
                        yield (name + entry.axis,), entry

    def _coordinates_of_centres(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        """x_c2, ẋ_c2, ẍ_c2: r_c2, v_c2 and a_c2 by components. In space the last two have those
        along the body, which are no rates of coordinates."""
        of_rates = "rva" if self.setting.symbols.model.dim == 2 else "r"
        for n in range(1, len(self._bodies) + 1):
            for dots, letter in enumerate(of_rates):
                for (entry,) in self._vectors.get(f"{letter}c{n}", ()):
                    names = (spellings(entry.axis, f"{place}{n}", dots) for place in "cG")
                    yield tuple(itertools.chain.from_iterable(names)), entry

    def _in_world(self, n: int, name: str, row: int) -> Callable[[], Trig]:
        """A component in the world's axes of what is given in the body's."""

        def value() -> Trig:
            R = self._setting.world[self._setting.order[n - 1]][0]
            s = self.setting.equations.symbols
            terms = (x * y for x, y in zip(R[row], self._bodies[n - 1][name], strict=True))
            return self.setting.element(s.element(sum(terms, s.zero())))

        return value

    def _part(self, n: int, name: str, *at: int) -> Callable[[], Trig]:
        def value() -> Trig:
            found = self._bodies[n - 1][name]
            for k in at:
                found = found[k]
            return self.setting.element(self.setting.equations.symbols.element(found))

        return value

    # ------------------------------------------------------------ the tip
    @cached_property
    def _tip(self) -> Kinematics | None:
        symbols = self.setting.equations.symbols
        return None if symbols.model.tip is None else Kinematics(symbols, symbols.model.tip)

    def _tip_vectors(self, tip: Kinematics) -> dict[str, list[list[AskedQuantity]]]:
        """r, ṙ, r̈ and J̇, whose rows are those of the position."""
        dim = self.setting.symbols.model.dim
        found: dict[str, list[list[AskedQuantity]]] = {}
        for dots, vector, words in (
            (0, "position", "the position of the tip"),
            (1, "velocity", "the velocity of the tip"),
            (2, "acceleration", "the acceleration of the tip"),
        ):
            column = []
            for k in range(dim):
                value = self._element(lambda k=k, x=vector: getattr(tip, x)[k])
                column.append([AskedQuantity("tip", (), value, axis="xyz"[k], words=words)])
            for letter in ("r", "rP"):
                found |= dict.fromkeys(spellings(letter, "", dots), column)
        rows = []
        for i in range(dim):
            row = []
            for j in range(self.count):
                value = self._element(lambda i=i, j=j: self.setting.forces(tip.J_dot[i])[j])
                words = f"entry {i + 1}, {j + 1} of the rate of the tip's Jacobian"
                row.append(AskedQuantity("J_d", (i + 1, j + 1), value, words=words))
            rows.append(row)
        return found | dict.fromkeys(spellings("J", "", 1), rows)

    @property
    def _rows(self) -> range:
        """Of the Jacobian, from 1."""
        return range(1, 4 if self.setting.is_planar else 7)

    def _of_tip(self, tip: Kinematics) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        for i in self._rows:
            for j in range(1, self.count + 1):
                entry = self._element(lambda i=i, j=j: self.setting.forces(tip.J[i - 1])[j - 1])
                yield (f"J{i}{j}",), AskedQuantity("J", (i, j), entry)
        for k in range(self.setting.symbols.model.dim):
            names = _TIP["xyz"[k]]
            yield names, AskedQuantity("tip", (), self._element(lambda k=k: tip.position[k]))
            for dots, family, vector in ((1, "tip_d", "velocity"), (2, "tip_dd", "acceleration")):
                dotted = tuple(s for name in names[:2] for s in spellings(name, "", dots))
                dotted += ("va"[dots - 1] + "xyz"[k],)
                value = self._element(lambda k=k, vector=vector: getattr(tip, vector)[k])
                yield dotted, AskedQuantity(family, (), value)
        rows = self._square(tip)
        if rows is not None:
            value = self._element(
                lambda: determinant([tip.J[i] for i in rows], self.setting.equations.symbols)
            )
            yield ("detJ",), AskedQuantity("det", (), value)

    def _square(self, tip: Kinematics) -> range | None:
        """The rows of the Jacobian that make it square: in space of three joints those of the
        position, of a wrist those of the orientation."""
        if self.setting.is_planar:
            return range(self.count) if self.count in (2, 3) else None
        if self.count == 6:
            return range(6)
        if self.count != 3:
            return None
        moves = any(not self.setting.element(x).is_zero for row in tip.J[:3] for x in row)
        return range(3) if moves else range(3, 6)

    def _element(self, value: Callable[[], Trig]) -> Callable[[], Trig]:
        """A value in the ring of answers."""
        return lambda: self.setting.element(value())

    # ------------------------------------------------------------ h of (3.25)
    def _coefficients(self) -> Iterator[tuple[tuple[str, ...], AskedQuantity]]:
        for group in self.setting.equations.groups("named"):
            for equation in group:
                symbol = equation.lhs
                if isinstance(symbol, ex.Symbol) and re.fullmatch(r"h[\d_]*", symbol.name):
                    name = symbol.name.replace("_", "")
                    yield (
                        (name,),
                        AskedQuantity("h", (), lambda x=equation.rhs: polynomial(self.setting, x)),
                    )


def polynomial(setting: RightEquations, node: Expression) -> Trig:
    """A printed expression as polynomial."""
    rules = {
        **arithmetic(lambda number: setting.zero + number),
        ex.Symbol: lambda node, at: setting.ring[node.name],
        ex.Function: lambda node, at: getattr(at(node.argument), node.name)(),
    }
    return evaluate(node, rules)
