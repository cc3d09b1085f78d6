"""Units of symbols, by their place in the model or by the notes' letters: a term whose units do not
fit cannot be right, whatever it should be."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence

from freebody.expressions.grammar.atoms import atom, undotted
from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit, si_text
from freebody.scalars.generators import function_of, symbol_of
from freebody.scalars.trig import Trig
from freebody_textbook.check.algebra.quotients import Value
from freebody_textbook.check.asked.quantity import AskedQuantity
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.check.link_symbols import BY_LETTER
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
    """The unit of a product; None where a symbol's is not known."""
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
    """The unit of λ, which times the loop's equation, in m, m² or rad, is an energy."""
    part = loop.rpartition(".")[2]
    length = 2 if part == "tension" else int(part.startswith("f"))
    return 1, 2 - length, -2


def in_other_units(
    setting: RightEquations, names: Sequence[str], conditions: Iterable[Trig], energy: Trig
) -> list[tuple[float, list[float]]]:
    """Factors by which an energy and each of some symbols change in other units. What holds at a
    state holds where all change alike; none where the units of the energy or of the state's
    conditions, polynomials that vanish, are not known, as where numbers stand for lengths."""
    known = _units_tell(setting, energy) and not setting.is_free_body
    if not known or not all(_has_one_unit(setting, x) for x in conditions):
        return []
    found = [unit_of(setting, {name: 1}) or units.NONE for name in names]
    return [
        (_factor(sizes, units.ENERGY), [_factor(sizes, unit) for unit in found])
        for sizes in _OTHERS
    ]


def _has_one_unit(setting: RightEquations, x: Trig) -> bool:
    """Whether all terms have the same, and it is known."""
    found = {unit_of(setting, powers) for powers, _ in x.terms()}
    return len(found) <= 1 and None not in found


def _factor(sizes: tuple[float, float, float], unit: Unit) -> float:
    return math.prod(size**power for size, power in zip(sizes, unit, strict=True))


def unit_of_quantity(setting: RightEquations, target: AskedQuantity, right: Value) -> Unit | None:
    """The unit of a quantity: by its joints where these tell, else that of its terms; None where it
    is not known."""
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
    """A term of the answer in other units than the right answer, with both; of the cosine of a sum
    of angles the whole."""
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
    """Whether what does not move in a difference from an energy can be its level: it has the
    robot's own symbols only, and is an energy or a plain number, where units tell: not of a robot
    whose masses or lengths are numbers, as 20 g then is an energy too."""
    polynomial, rates = setting.ring.polynomial, setting.symbols.rates
    parts = [(powers, polynomial([(powers, k)])) for powers, k in gap.terms()]
    still = [p for p, x in parts if all(x.derivative(name).is_zero for name in rates)]
    if any(symbol_of(name) in setting.foreign for p in still for name in p):
        return False
    found = {unit_of(setting, powers) for powers in still if powers}
    return not _units_tell(setting, right) or found <= {units.ENERGY, None}


def _units_tell(setting: RightEquations, energy: Trig) -> bool:
    """Whether the terms of an energy have its unit: no numbers stand for parameters."""
    own = {unit_of(setting, powers) for powers, _ in energy.terms()}
    return own <= {units.ENERGY, None} and not _has_numbers_for_parameters(setting)


def _has_numbers_for_parameters(setting: RightEquations) -> bool:
    """Whether symbols stand for values whose units are not their own."""
    given = setting.given.items()
    return any(
        unit_of(setting, p) != _unit(setting, name) for name, x in given for p, _ in x.terms()
    )


def _without_waves(powers: Mapping[str, int]) -> dict[str, int]:
    return {name: power for name, power in powers.items() if not function_of(name)}


def is_of_another_kind(setting: RightEquations, yours: Trig, right: Trig) -> bool:
    """Whether no term has the units of the right answer, nor any that are not known: it is meant
    for something else."""
    if right.is_zero:
        return not yours.is_zero
    expected = _common_unit(setting, right)
    found = {unit_of(setting, powers) for powers, _ in yours.terms()}
    return bool(found) and expected is not None and found.isdisjoint((expected, None))


def _common_unit(setting: RightEquations, right: Trig) -> Unit | None:
    """The unit of a right answer's terms; None of what has numbers in place of parameters."""
    if _has_numbers_for_parameters(setting):
        return None
    return next((unit_of(setting, powers) for powers, _ in right.terms()), None)
