"""Quantities of closed chains and trees: loop equations, independent coordinates, and forces in
joints and loops by Lagrange multipliers."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from freebody.expressions.expression import Expression
from freebody.expressions.grammar.atoms import spellings
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.words import spelt
from freebody.expressions.polynomials.arithmetic import determinant
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import vec
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import neg
from freebody_textbook.check.algebra.quotients import Value, negative
from freebody_textbook.check.asked.group import (
    NamedTarget,
    QuantityGroup,
    column,
    components,
    entries,
    matrix,
    values,
)
from freebody_textbook.check.asked.quantity import AskedQuantity, Mistaken, QuantityTable
from freebody_textbook.check.asked.right_equations import RightEquations, loop_equation
from freebody_textbook.closed_chains.first_kind import Reduction, multiplier_names
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.body_quantities import BY_NAME
from freebody_textbook.methods.body_values import BodyValues
from freebody_textbook.methods.cut_loops import Loops
from freebody_textbook.methods.loop_forces import LoopForces, LoopReactions, needs_of
from freebody_textbook.methods.setting import Setting
from freebody_textbook.relations.quantities import branches


class LoopQuantities(QuantityGroup):
    """Quantities of loops: Φ, Φ_q, their rates, the required value of Φ_q q̈, and the multipliers
    λ."""

    def single(self) -> Iterator[NamedTarget]:
        for i, (x,) in enumerate(self._tables.get("Phi", []), 1):
            (rate,), (c,) = self._tables["Phi_d"][i - 1], self._tables["c"][i - 1]
            yield (f"Phi{i}",), x
            yield tuple(spellings("Phi", str(i), 1)), rate
            yield tuple(spellings("Phi", str(i), 2)), self._second(rate)
            yield (f"c{i}",), replace(c, also=tuple(self._velocity_term(i)))
            for j, entry in enumerate(self._tables["Phiq"][i - 1], 1):
                yield (f"Phiq{i}{j}",), entry

    def _velocity_term(self, i: int) -> Iterator[Mistaken]:
        """The alternative reading of c_i as the velocity term of joint i."""
        if i in self.numbers:
            note = f"It is read as the velocity term of {self.joint(i)}."
            yield note, self.entry(kinds.VELOCITY.name, i)

    def _second(self, rate: AskedQuantity) -> AskedQuantity:
        """The second time derivative of a loop equation."""
        words = rate.words.replace("the rate", "the second derivative", 1)
        value = rate.polynomial().along(self.setting.symbols.rates)
        return AskedQuantity(kinds.LOOP_RATE, rate.index, lambda: value, words=words)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        found = dict(self._tables)
        found |= {"gamma": found["c"]} if found else {}
        for name, letter in (("Phi_d", "Phi"), ("Phiq_d", "Phiq")):
            if table := found.pop(name, None):
                found |= dict.fromkeys(spellings(letter, "", 1), table)
        return found

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        if self.setting.system is None:
            return {}
        loops, rates = self.setting.system.loops, self.setting.symbols.rates
        signs = [
            1 - 2 * (loop_equation(i) in self.setting.opposed) for i in range(1, len(loops.c) + 1)
        ]
        rows = [
            [self.setting.element(x) * sign for x in self.setting.forces(row)]
            for sign, row in zip(signs, loops.Phi_q, strict=True)
        ]
        ring = self.setting.ring
        found: dict[str, QuantityTable] = {name: [] for name in ("Phi", "Phi_d", "c", "lam")}
        for i, (name, lam) in enumerate(zip(loops.names, multiplier_names(loops), strict=True), 1):
            sign = signs[i - 1]
            phi, c = (self.setting.element(x[i - 1]) * sign for x in (loops.Phi, loops.c))
            told = _in_words(name)
            columns = {
                "Phi": (kinds.LOOP, phi, f"the loop equation of {told}"),
                "Phi_d": (
                    kinds.LOOP_RATE,
                    phi.along(rates),
                    f"the rate of the loop equation of {told}",
                ),
                "c": (kinds.LOOP_REST, c, f"what row {i} of Φ_q q̈ must be"),
                "lam": (
                    kinds.MULTIPLIER,
                    ring[lam],
                    f"the multiplier of the loop equation of {told}",
                ),
            }
            for key, (kind, value, words) in columns.items():
                asked = AskedQuantity(kind, (i,), lambda value=value: value, words=words)
                found[key].append([asked])
        whole, slopes = "the Jacobian of the loop equations", kinds.LOOP_JACOBIAN
        own = [values(row) for row in rows]
        found["Phiq"] = matrix(slopes, own, f"entry {{}}, {{}} of {whole}")
        moving = [[lambda x=x: x.along(rates) for x in row] for row in rows]
        found["Phiq_d"] = matrix(slopes, moving, f"entry {{}}, {{}} of the rate of {whole}")
        return found


def _in_words(name: str) -> str:
    """Description of a loop equation by its name: closing_pin.fy is that of 'closing_pin' along
    y."""
    loop, _, part = name.rpartition(".")
    if part in ("m", "tension"):
        return f"{loop!r} for its {'angle' if part == 'm' else 'length'}"
    return f"{loop!r} {'along' if part[0] == 'f' else 'about'} {part[1:]}"


_N = LexemePattern("!-%latin N !~%latin")
_H, _M = (LexemePattern(f"!-%latin {letter} _? {{? < %counted | %low_digit >") for letter in "HM")


class ReducedQuantities(QuantityGroup):
    """Quantities of a closed chain in independent coordinates, in the plane or in space: n, N, γ
    and u."""

    def single(self) -> Iterator[NamedTarget]:
        if self.setting.system is None:
            return
        for i in self.numbers:
            yield (f"n{i}",), self._applied(i)
        for k, of_loop in enumerate(self.setting.system.loops.c, 1):
            also = (("It is read as c of Φ_q q̈ = c.", self.element(lambda x=of_loop: x)),)
            asked = AskedQuantity(
                kinds.LOOP_REST, (k,), also[0][1], words=f"what row {k} of Φ_q q̈ must be"
            )
            yield (
                (f"gamma{k}",),
                replace(self._drift[k - 1][0], also=also) if self._drift else asked,
            )
        for (x,) in self._drift:
            yield (f"gamma{x.index[0]}",), x

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        if self.setting.system is None:
            return {}
        found: dict[str, QuantityTable] = {"n": [[self._applied(i)] for i in self.numbers]}
        if self._reduction is None:
            return found
        reduction = self._reduction
        own = [k + 1 for k in reduction.independent]
        rows = [
            [
                self.quotient(lambda k=k, j=j: (reduction.scaled[k - 1][j], reduction.delta))
                for j in range(len(own))
            ]
            for k in self.numbers
        ]
        N = matrix(kinds.OF_INDEPENDENT, rows, "entry {}, {} of N, q̇ = N u̇")
        found |= {"N": N, **({"gamma": self._drift} if _N.found_in(self.formulas) else {})}
        for dots, ending in enumerate(("", RATE, SECOND)):
            names = self.setting.symbols.coordinates
            column = [[self.coordinate(names[k - 1] + ending, k)] for k in own]
            found |= dict.fromkeys(spellings("u", "", dots), column)
        return found

    @property
    def _reduction(self) -> Reduction | None:
        return reduction_of(self.setting)

    def _applied(self, i: int) -> AskedQuantity:
        """The generalized force n_i: the drive's, minus the terms of velocities, weights, springs
        and friction."""

        def value() -> Trig:
            tau, rest = self.entry("tau", i), [self.entry(x, i)() for x in ("c", "g", "drives")]
            idle = i in self.passive
            return (self.setting.zero if idle else tau()) - sum(rest, self.setting.zero)

        words = f"the generalized force of joint {i} without what accelerations and loops need"
        return AskedQuantity(kinds.APPLIED, (i,), value, words=words)

    @cached_property
    def _drift(self) -> QuantityTable:
        """The drift γ: the accelerations q̈ for ü = 0."""
        return [[self._drift_of(k)] for k in self.numbers] if self._reduction else []

    def _drift_of(self, k: int) -> AskedQuantity:
        reduction = self._reduction
        assert reduction is not None
        value = self.quotient(lambda: (reduction.scaled_drift[k - 1], reduction.delta))
        return AskedQuantity(
            kinds.DRIFT, (k,), value, words=f"entry {k} of γ, q̈ = N ü + γ",
            thoughts=(("It has the wrong sign: Φ_q γ = c = −Φ̇_q q̇.", lambda: negative(value())),),
        )  # fmt: skip


class ReducedMass(QuantityGroup):
    """The reduced mass matrix H_ij = (NᵀM N)_ij, for answers that call it H and the cut chain's
    matrix M."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether the formulas have both M and H, the mass matrix in independent coordinates."""
        first = next(_H.all(formulas), None)
        return first is not None and _M.found_in(formulas, first.stop)

    def single(self) -> Iterator[NamedTarget]:
        if (found := reduction_of(self.setting)) is None:
            return
        reduction: Reduction = found
        n = range(len(reduction.independent))

        def entry(i: int, j: int) -> Callable[[], Value]:
            return self.quotient(lambda: (reduction.mass[i][j], reduction.delta**2))

        rows = [[entry(i, j) for j in n] for i in n]
        words = "entry {}, {} of the mass matrix in independent coordinates, NᵀM N"
        yield from entries({"H": matrix(kinds.OF_INDEPENDENT, rows, words)})


def reduction_of(setting: RightEquations) -> Reduction | None:
    """The reduction of a closed chain to independent coordinates; None if there is none."""
    system = setting.system if setting.turned is None else None
    return system and system.reduction


_SYSTEM = LexemePattern("!-%latin A < λ | \\lambda | %font { < \\lambda | λ > >")
_OF_CENTRE = (BY_NAME["sc{n}"], BY_NAME["fc{n}"])
_BodyRow = tuple[Expression, Iterable[Any], int, str]
"""Name, components, body and words."""


class BodiesOfTrees(QuantityGroup):
    """Quantities of bodies, f_24, s_c3 and the like, in trees: named as in the derivations."""

    def single(self) -> Iterator[NamedTarget]:
        yield from components(self._vectors)

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._vectors

    @cached_property
    def _vectors(self) -> dict[str, QuantityTable]:
        s = self._setting
        if not (branches(s.tree) or self.setting.system) or self.setting.turned is not None:
            return {}
        if any(len(body.masses) > 1 for body in s.tree.bodies):  # its centre has no symbol
            return {}
        found: dict[str, QuantityTable] = {}
        for name, vector, n, words in self._told(s):
            plain = spelt(str(name))
            if plain and plain not in found:
                found[plain] = self._table(list(vector), n, words)
        return found

    def _told(self, s: Setting) -> Iterator[_BodyRow]:
        loops = Loops(s) if self.setting.system else None
        reactions = LoopReactions(s, loops) if loops else SolvedReactions(s)
        for i in s.order if loops else ():
            assert loops is not None
            for arm, vector in LoopForces(s, loops).ways(i):
                yield arm, vector, s.numbers[i], f"the way on body {s.numbers[i]} to a loop's force"
        for i in s.order:
            b, parent = BodyValues(s, i, reactions), s.tree.bodies[i].parent
            n = b.n
            h = s.numbers[parent] if parent >= 0 else 0
            for k in s.tree.children(i):
                yield s.naming.reach(n, s.numbers[k]), s.to_child(i, k), n, f"a way along body {n}"
            if s.ends_in_tip(i):
                yield s.naming.to_tip(n), s.to_tip(i), n, BY_NAME["s{n}"].told(n)
            if i in s.weighted:
                for record in _OF_CENTRE:
                    yield vec(record.known.format(n=n)), record.value(b), n, record.told(n)
            yield s.naming.force(h, n), b.force, n, BY_NAME["f{h}{n}"].told(n, h)
            yield s.naming.moment(h, n), b.moment, n, BY_NAME["n{n}"].told(n, h)
            yield s.naming.force(n, h), neg(b.force), n, BY_NAME["f{n}{h}"].told(n, h)
            yield s.naming.moment(n, h), neg(b.moment), n, BY_NAME["n{n}{h}"].told(n, h)
        for loop in s.tree.loops if loops else ():
            assert loops is not None
            force, moment = loops.wrench(loop)
            n = s.numbers[loops.ends(loop)[1]]
            yield loops.force_name(loop), force, n, f"the force of the loop on body {n}"
            yield loops.moment_name(loop), moment, n, f"the moment of the loop on body {n}"
            on, by = s.naming.loop_bodies(s.symbols.tree.loops.index(loop))[::-1]
            words = f"the force of body {on} on body {by} in the loop"
            yield s.naming.force(on, by), neg(force), n, words

    def _table(self, vector: list[Any], n: int, words: str) -> QuantityTable:
        axes = "xyz" if len(vector) > 1 else ("",)
        own = (self.element(lambda x=x: x) for x in vector)
        return column(kinds.OF_BODY, own, words, (n,), axes)


class LoopForceSystem(QuantityGroup):
    """Quantities of A λ = k, the equations of the passive joints for the multipliers."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer contains A λ."""
        return _SYSTEM.found_in(formulas)

    def single(self) -> Iterator[NamedTarget]:
        yield from entries({"k": self._tables.get("k", [])})
        if self._tables and len(self._tables["A"]) == len(self._tables["A"][0]):
            rows = [[x.polynomial() for x in row] for row in self._tables["A"]]
            words = "the determinant of A, A λ = k"
            det = AskedQuantity(
                kinds.DETERMINANT, (), lambda: determinant(rows, self.setting.symbols), words=words
            )
            yield ("detA",), det

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._tables

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        if self.setting.system is None or self.setting.turned is not None:
            return {}
        s = self._setting
        loops = Loops(s)
        system = needs_of(LoopReactions(s, loops), loops)
        if not system.A:
            return {}
        rows = [[self.element(lambda x=x: x) for x in row] for row in system.A]
        A = matrix(kinds.OF_INDEPENDENT, rows, "entry {}, {} of A, A λ = k")
        return {"A": A, "k": [[self._right(x, i)] for i, x in enumerate(system.right, 1)]}

    def _right(self, x: Trig, i: int) -> AskedQuantity:
        """The quantity that is an entry of k, the right side of A λ = k."""
        words = f"entry {i} of k, A λ = k"
        return AskedQuantity(kinds.OF_INDEPENDENT, (i,), self.element(lambda: x), words=words)
