"""Vectors of the bodies of trees and closed chains: forces in joints and loops, by the multipliers,
and the ways along bodies."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import replace
from typing import Any

from freebody.expressions.expression import Expression
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.words import spelt
from freebody.expressions.polynomials.arithmetic import determinant
from freebody.expressions.printed_names import vec
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import neg
from freebody_textbook.check.asked.group import NamedTarget, QuantityGroup
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable
from freebody_textbook.methods.body_quantities import BY_NAME
from freebody_textbook.methods.body_values import BodyValues
from freebody_textbook.methods.cut_loops import Loops
from freebody_textbook.methods.loop_forces import LoopForces, LoopReactions, needs_of
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting
from freebody_textbook.relations.quantities import branches

_SYSTEM = LexemePattern("!-%latin A < λ | \\lambda | %font { < \\lambda | λ > >")
_OF_CENTRE = (BY_NAME["sc{n}"], BY_NAME["fc{n}"])
_BodyRow = tuple[Expression, Iterable[Any], int, str]
"""Name, components, body and words."""


class BodiesOfTrees(QuantityGroup):
    """f_24, s_c3 and the like where the bodies do not form one chain: named as derivations name
    them."""

    def single(self) -> Iterator[NamedTarget]:
        for name, table in self._vectors.items():
            for (entry,) in table:
                if entry.axis or len(table) == 1:
                    yield (name + entry.axis,), entry

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._vectors

    @cached_property
    def _vectors(self) -> dict[str, QuantityTable]:
        s = Setting(self.setting.equations.symbols)
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
        element = self.setting.equations.symbols.element
        asked = AskedQuantity(kinds.OF_BODY, (n,), lambda: self.setting.zero, words=words)
        return [
            [replace(asked, compute=self.element(lambda x=x: element(x)), axis=k)]
            for x, k in zip(vector, axes, strict=False)
        ]


class LoopForceSystem(QuantityGroup):
    """A λ = k, the equations of the passive joints for the multipliers."""

    @classmethod
    def is_told(cls, formulas: Lexemes) -> bool:
        """Whether an answer has A λ."""
        return _SYSTEM.found_in(formulas)

    def single(self) -> Iterator[NamedTarget]:
        for i, (x,) in enumerate(self._tables.get("k", []), 1):
            yield (f"k{i}",), x
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
        s = Setting(self.setting.equations.symbols)
        loops = Loops(s)
        system = needs_of(LoopReactions(s, loops), loops)
        if not system.A:
            return {}
        A = [
            [self._entry(x, "A", i, j) for j, x in enumerate(row, 1)]
            for i, row in enumerate(system.A, 1)
        ]
        return {"A": A, "k": [[self._entry(x, "k", i)] for i, x in enumerate(system.right, 1)]}

    def _entry(self, x: Trig, name: str, *at: int) -> AskedQuantity:
        words = f"entry {', '.join(map(str, at))} of {name}, A λ = k"
        return AskedQuantity(kinds.OF_INDEPENDENT, at, self.element(lambda: x), words=words)
