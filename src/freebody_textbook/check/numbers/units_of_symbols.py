"""Units of symbols, known from their place in the model or by the lecture notes' letters: a term
with other units than the correct ones is wrong in any case."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from freebody.expressions.grammar.atoms import atom, undotted
from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit, si_text
from freebody.scalars.generators import function_of, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.asked.letters_for_numbers import BY_LETTER
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.closed_chains.multiplier_equations import is_multiplier

_TEXTS = {
    si_text(x, True): x
    for x in (units.MASS, units.LENGTH, units.NONE, units.INERTIA, units.ACCELERATION)
}
"""Units of a model's numbers, as its catalogue writes them."""
_POSITIONS = ("x", "y", "z")
"""Coordinates of a slide along an axis of the world."""
_OTHERS = ((1.3, 1.2, 0.9), (0.7, 0.8, 1.2))
"""kg, m and s in other units: of these sizes no product of two parameters changes as an energy."""


def unit_of(setting: RightEquations, powers: Mapping[str, int]) -> Unit | None:
    """The unit of a product of powers; None if a symbol's unit is unknown."""
    total = [0, 0, 0]
    for name, exponent in powers.items():
        unit = _unit(setting, name)
        if unit is None:
            return None
        total = [a + exponent * b for a, b in zip(total, unit, strict=True)]
    return total[0], total[1], total[2]


def _unit(setting: RightEquations, name: str) -> Unit | None:
    if name == setting.order.gravity:
        return 0, 1, -2
    if function_of(name):
        return 0, 0, 0
    if known := _TEXTS.get(setting.units.get(name, "")):
        return known
    if is_multiplier(name) and setting.system is not None:
        return _unit_of_multiplier(setting.system.loops.names[int(atom(name).figures) - 1])
    own = atom(name)
    moves = undotted(name) in setting.symbols.coordinates
    if moves and own.letter in _POSITIONS and not own.index:
        return 0, 1, -own.dots
    is_known = setting.is_planar or moves
    if not is_known or not own.is_numbered or own.letter not in BY_LETTER:
        return None
    kg, m, s = BY_LETTER[own.letter].unit
    return kg, m, s - own.dots


def _unit_of_multiplier(loop: str) -> Unit:
    """The unit of a multiplier λ: an energy divided by the unit of its loop equation, m, m² or
    rad."""
    part = loop.rpartition(".")[2]
    length = 2 if part == "tension" else int(part.startswith("f"))
    return 1, 2 - length, -2


def in_other_units(
    setting: RightEquations, names: Sequence[str], conditions: Iterable[Trig], energy: Trig
) -> list[tuple[float, list[float]]]:
    """Factors by which an energy and each named symbol change in other systems of units; empty if
    the units of the energy or of the conditions (polynomials that vanish at the state) are unknown,
    as with numbers in place of lengths."""
    known = _units_tell(setting, energy) and not setting.is_free_body
    if not known or not all(_has_one_unit(setting, x) for x in conditions):
        return []
    found = [unit_of(setting, {name: 1}) or units.NONE for name in names]
    return [
        (_factor(sizes, units.ENERGY), [_factor(sizes, unit) for unit in found])
        for sizes in _OTHERS
    ]


def _has_one_unit(setting: RightEquations, x: Trig) -> bool:
    """Whether all terms of a polynomial have the same, known unit."""
    found = {unit_of(setting, powers) for powers, _ in x.terms()}
    return len(found) <= 1 and None not in found


def _factor(sizes: tuple[float, float, float], unit: Unit) -> float:
    return math.prod(size**power for size, power in zip(sizes, unit, strict=True))


def unit_of_quantity(setting: RightEquations, target: AskedQuantity, right: Value) -> Unit | None:
    """The unit of a quantity, from its joints if possible, otherwise from its terms; None if it is
    unknown."""
    turns = [
        setting.turns(setting.symbols.coordinates[k - 1])
        for k in target.index
        if 0 < k <= len(setting.symbols.coordinates)
    ]
    unit = target.kind.unit_of(turns)
    if unit is not None:
        return unit
    return _common_unit(setting, right) if isinstance(right, Trig) else None


def misfit(setting: RightEquations, yours: Trig, right: Trig) -> tuple[Trig, Unit, Unit] | None:
    """A term of the answer whose unit differs from the correct answer's, with both units; together
    with terms that differ from it in sines and cosines alone."""
    expected = _common_unit(setting, right)
    if expected is None:
        return None
    for powers, _ in yours.terms():
        unit = unit_of(setting, powers)
        if unit is not None and unit != expected:
            part = _without_waves(powers)
            alike = [term for term in yours.terms() if _without_waves(term[0]) == part]
            return setting.ring.polynomial(alike), unit, expected
    return None


def can_be_a_level(setting: RightEquations, gap: Trig, right: Trig) -> bool:
    """Whether the constant part of a difference between energies can be a reference level: it
    contains only the robot's own symbols, and is an energy or a plain number as far as units show
    (not where numbers replace masses or lengths, as 20 g is then an energy too)."""
    polynomial, rates = setting.ring.polynomial, setting.symbols.rates
    parts = [(powers, polynomial([(powers, k)])) for powers, k in gap.terms()]
    still = [p for p, x in parts if all(x.derivative(name).is_zero for name in rates)]
    if any(symbol_of(name) in setting.foreign for p in still for name in p):
        return False
    found = {unit_of(setting, powers) for powers in still if powers}
    return not _units_tell(setting, right) or found <= {units.ENERGY, None}


def _units_tell(setting: RightEquations, energy: Trig) -> bool:
    """Whether the terms of an energy have its unit, which is so if no parameter is a plain
    number."""
    own = {unit_of(setting, powers) for powers, _ in energy.terms()}
    return own <= {units.ENERGY, None} and not _has_numbers_for_parameters(setting)


def _has_numbers_for_parameters(setting: RightEquations) -> bool:
    """Whether plain numbers occur in place of parameters, so that units are not visible."""
    given = setting.given.items()
    return any(
        unit_of(setting, p) != _unit(setting, name) for name, x in given for p, _ in x.terms()
    )


def _without_waves(powers: Mapping[str, int]) -> dict[str, int]:
    return {name: power for name, power in powers.items() if not function_of(name)}


def is_of_another_kind(setting: RightEquations, yours: Trig, right: Trig) -> bool:
    """Whether no term has the correct answer's unit or an unknown one: another quantity is
    meant."""
    if right.is_zero:
        return not yours.is_zero
    expected = _common_unit(setting, right)
    found = {unit_of(setting, powers) for powers, _ in yours.terms()}
    return bool(found) and expected is not None and found.isdisjoint((expected, None))


def _common_unit(setting: RightEquations, right: Trig) -> Unit | None:
    """The common unit of the correct answer's terms; None if numbers replace parameters."""
    if _has_numbers_for_parameters(setting):
        return None
    return next((unit_of(setting, powers) for powers, _ in right.terms()), None)
