"""Units of what a page shows: of its sliders, and of the values below its equations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from freebody.expressions.expression import Expression, Symbol
from freebody.expressions.grammar.atoms import atom
from freebody.expressions.nodes import Negative, Sum
from freebody.expressions.polynomials.symbols import RATE
from freebody_textbook.derivation import Derivation
from freebody_textbook.methods.glossary import ACCELERATION, in_model, placed
from freebody_textbook.methods.setting import Setting


def is_velocity(name: str) -> bool:
    """Whether it is a component of a free body's velocity, or its rate."""
    own = atom(name)
    return own.letter in ("v", "omega") and own.index in (("x",), ("y",), ("z",)) and own.dots < 2


def units_of_symbols(derivation: Derivation) -> dict[str, str]:
    """By name, as the derivation's table tells them, and of what only the drawings need."""
    symbols = derivation.equations.symbols
    found = {symbol.name: unit for symbol, unit in _told(derivation)}
    for name in symbols.extra:
        if is_velocity(name):
            found[name] = ("rad/s" if "omega" in name else "m/s") + "²" * name.endswith(RATE)
    if symbols.model.tip is not None:
        for parameter, _, unit in placed(symbols.model.frame().placement, ""):
            found.setdefault(parameter.name, unit)
    for parameter, _, unit in in_model(Setting(symbols), moved=False):
        found.setdefault(parameter.name, unit)
    gravity = derivation.equations.layout.order.gravity
    return {gravity: ACCELERATION} | found if gravity else found


def _told(derivation: Derivation) -> Iterator[tuple[Symbol, str]]:
    """Symbols of the table with their units; of several units in a row each serves as many. What
    has one unit "or" another has none that is sure."""
    for row in derivation.glossary:
        units = [unit if " or " not in unit else "" for unit in row.unit.split(", ")]
        each = max(1, len(row.symbols) // len(units))
        for k, symbol in enumerate(row.symbols):
            if isinstance(symbol, Symbol):
                yield symbol, units[min(k // each, len(units) - 1)]


class LineUnits:
    """Units of left sides, by the symbol that they are or begin with: its own, or that of symbols
    with its letter and like indices; "" where the table tells none, or several."""

    def __init__(self, derivation: Derivation, known: Mapping[str, str]):
        self._known = known
        self._alike: dict[object, set[str]] = {}
        for symbol, unit in _told(derivation):
            near, (letter, _) = _keys(symbol)
            for key in (near, (letter, True)):
                self._alike.setdefault(key, set()).add(_still(unit, symbol.dots))

    def __call__(self, left: Expression) -> str:
        while isinstance(left, Sum | Negative):
            left = left.terms[0] if isinstance(left, Sum) else left.operand
        if not isinstance(left, Symbol):
            return ""
        if left.name in self._known:
            return self._known[left.name]
        alike = next((self._alike[key] for key in _keys(left) if key in self._alike), set())
        unit = next(iter(alike)) if len(alike) == 1 else ""
        return _per_second(unit, left.dots)


def _keys(symbol: Symbol) -> Iterator[tuple[object, ...]]:
    """From near to far: the letter with its kinds of indices; of totals and components the letter
    alone."""
    yield symbol.letter, symbol.high, ",".join(symbol.low).translate(_ANY_LINK)
    yield symbol.letter, not symbol.low or symbol.low[-1] in "xyz"


_ANY_LINK = str.maketrans(dict.fromkeys("0123456789ik", "#"))
_RATES = {"rad": "rad/s", "rad/s": "rad/s²", "m": "m/s", "m/s": "m/s²"}


def _per_second(unit: str, dots: int) -> str:
    for _ in range(dots):
        unit = _RATES.get(unit, "")
    return unit


def _still(unit: str, dots: int) -> str:
    back = {rate: unit for unit, rate in _RATES.items()}
    for _ in range(dots):
        unit = back.get(unit, "")
    return unit
