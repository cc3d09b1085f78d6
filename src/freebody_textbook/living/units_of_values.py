"""Units of the values of lines, from those of the symbols in their terms."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from freebody.expressions.polynomials.symbols import Symbols
from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit, si_text
from freebody.model.placement import Shift
from freebody.scalars.generators import function_of
from freebody.scalars.trig import Trig
from freebody_textbook.equations.equations import Equations
from freebody_textbook.living.page_program import entries

_BY_TEXT: Mapping[str, Unit] = {
    "J": units.ENERGY,
    **{
        si_text(x, True): x
        for x in (
            units.MASS, units.LENGTH, units.SPEED, units.ACCELERATION, units.INERTIA, units.FORCE,
            units.ENERGY, units.NONE, units.RATE, units.SECOND,
        )
    },
}  # fmt: skip
"""Units of symbols, as tables of symbols write them."""


def together(told: Iterable[str | None]) -> str:
    """The units of a vector from those of its entries: one if all have the same; "" if that of an
    entry is unknown. None: of an entry that is 0, which tells none."""
    units_told = list(told)
    known = list(dict.fromkeys(x for x in units_told if x is not None))
    if not known or "" in known or (len(known) > 1 and None in units_told):
        return ""
    return known[0] if len(known) == 1 else ", ".join(filter(None, units_told))


class UnitsOfValues:
    """Units of polynomials whose symbols have units; "" where terms do not tell one, as where
    plain numbers stand for lengths or masses.

    equations: the model's. known: units of symbols by name.
    """

    def __init__(self, equations: Equations, known: Mapping[str, str]):
        self._known = known
        self._tell = _is_lettered(equations.symbols) and all(
            self._units(x) <= {units.ENERGY} for x in (equations.T, equations.V)
        )

    def __call__(self, value: Any) -> str:
        """The unit of a scalar, or the units of a vector's entries."""
        parts = entries(value)
        if not self._tell or not all(isinstance(x, Trig | int | float) for x in parts):
            return ""  # what is traced has no terms
        return together(
            [self._text(x) if isinstance(x, Trig) and not x.is_zero else None for x in parts]
        )

    def _text(self, x: Trig) -> str:
        rows = [[*powers.items()] for powers, _ in x.terms()]
        if len(rows) == len(rows[0]) == 1 and rows[0][0][1] == 1:  # a symbol: radians have none
            return self._known.get(rows[0][0][0], "")
        found = self._units(x)
        unit = found.pop() if len(found) == 1 else None
        return "" if unit is None or unit == units.NONE else si_text(unit, angular=True)

    def _units(self, x: Trig) -> set[Unit | None]:
        """The units of all terms; None among them if a symbol's is unknown."""
        return {self._product(powers) for powers, _ in x.terms()}

    def _product(self, powers: Mapping[str, int]) -> Unit | None:
        total = [0, 0, 0]
        for name, exponent in powers.items():
            unit = units.NONE if function_of(name) else _BY_TEXT.get(self._known.get(name, ""))
            if unit is None:
                return None
            total = [a + exponent * b for a, b in zip(total, unit, strict=True)]
        return total[0], total[1], total[2]


def _is_lettered(symbols: Symbols) -> bool:
    """Whether no frame is placed at a plain number other than 0."""
    frames: Iterable[Any] = symbols.model.frames
    shifts = [x.by for frame in frames for x in frame.placement.steps if isinstance(x, Shift)]
    return not any(isinstance(x, int | float) and x != 0.0 for by in shifts for x in by)
