"""Jacobians of bodies: of the velocity of their centres of mass, and of their angular velocity, in
the world's axes."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping

from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.quantities import kinds
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.bodies import QuantitiesOfBodies
from freebody_textbook.check.asked.group import NamedTarget
from freebody_textbook.check.asked.quantity import AskedQuantity, QuantityTable

_TOLD = LexemePattern("< %fresh J | %around_letter { J } > ~_? ~{? < %letter | \\omega >")
"""In answers without a J of a letter there is none."""
_OF_CENTRE = ("Jc{n}", "Jv{n}", "Jvc{n}", "JG{n}", "JL{n}")
_ANGULAR = ("Jomega{n}", "Jw{n}", "JA{n}")


class CentreJacobians(QuantitiesOfBodies):
    """J_ci or J_vi, with v_ci = J_vi q̇, and J_ωi, with ω_i = J_ωi q̇."""

    def single(self) -> Iterator[NamedTarget]:
        for name, table in self._tables.items():
            for row in table:
                for entry in row:
                    yield (name + "".join(map(str, entry.index)),), entry

    def tables(self, single: Mapping[str, AskedQuantity]) -> dict[str, QuantityTable]:
        return self._tables

    @cached_property
    def _tables(self) -> dict[str, QuantityTable]:
        if not _TOLD.found_in(self.formulas):
            return {}
        found: dict[str, QuantityTable] = {}
        names = self.setting.symbols.coordinates
        for n in range(1, len(self._bodies) + 1):
            if centre := self.vectors.get(f"rc{n}"):
                rows = [entry.polynomial for (entry,) in centre]
                words = f"the Jacobian of the centre of mass of body {n}"
                table = self._slopes(rows, names, n, words)
                found |= {name.format(n=n): table for name in _OF_CENTRE}
            if turning := self.vectors.get(f"omega{n}"):
                rows = [entry.in_world or entry.polynomial for (entry,) in turning]
                words = f"the Jacobian of the angular velocity of body {n}"
                table = self._slopes(rows, [x + RATE for x in names], n, words)
                found |= {name.format(n=n): table for name in _ANGULAR}
        return found

    def _slopes(
        self, rows: list[Callable[[], Trig]], names: list[str] | tuple[str, ...], n: int, words: str
    ) -> QuantityTable:
        """The derivatives of some values by coordinates or rates."""
        return [
            [
                AskedQuantity(
                    kinds.OF_BODY, (i, j), lambda row=row, x=x: row().derivative(x),
                    words=f"entry {i}, {j} of {words}",
                )
                for j, x in enumerate(names, 1)
            ]
            for i, row in enumerate(rows, 1)
        ]  # fmt: skip
