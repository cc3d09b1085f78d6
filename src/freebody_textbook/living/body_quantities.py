"""Quantities of bodies by name for interactive pages, over polynomials if these are short,
otherwise over a program's scalars, with the recursion computed body by body."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from freebody.elementary import Scalar, cos, sin
from freebody.expressions.polynomials.symbols import Formulas, Symbols
from freebody.model.model import Model
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Parameter, Quantity
from freebody.model.quantity_reader import QuantityReader, exact_sin_cos
from freebody.scalars.expr import Expr
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, numbers
from freebody_textbook.methods.body_values import BodyValues
from freebody_textbook.methods.energies import Energies
from freebody_textbook.methods.setting import Setting


def body_quantities(s: Setting, reactions: SolvedReactions) -> dict[str, Any]:
    """All quantities of bodies by their names in derivations; vectors in the printed axes, but
    positions and gravity in world axes."""
    ring, energies = s.symbols.ring, Energies(s, s.motion)
    found: dict[str, Any] = {name: ring[name] for name in ring.names}
    found["gravity"] = vector(s, s.tree.gravity)
    found["V"], found["T"] = energies.total_potential, energies.rotors
    if s.tree.base:
        found["V0"] = energies.resting
    for i in s.order:
        found |= _of_body(s, reactions, i)
        if i in s.weighted:
            found["T"] = found["T"] + energies.kinetic(i)
            found |= {f"T{s.numbers[i]}": energies.kinetic(i)}
            found |= {f"V{s.numbers[i]}": energies.potential(i)}
    found["L"] = found["T"] - found["V"]
    if s.symbols.model.tip is not None and s.tip >= 0:
        found["r"] = vector(s, s.tip_position())
    if s.load:
        found["f"] = vector(s, s.load_components)
    return found


def vector(s: Setting, v: Any) -> tuple[Any, ...]:
    """A vector's components as scalars of the setting."""
    return tuple(map(s.symbols.element, v))


def _of_body(s: Setting, reactions: SolvedReactions, i: int) -> dict[str, Any]:
    b = BodyValues(s, i, reactions)
    above = s.numbers[s.tree.bodies[i].parent] if s.tree.bodies[i].parent >= 0 else 0
    at = numbers(b.n, above)
    rows = (x for x in BODY_QUANTITIES if x.shown and x.exists(b))
    made = {x.known.format(**at): x.value(b) for x in rows}
    made[s.naming.force(above, b.n).name] = b.vector(b.force)
    if not s.planar:
        made[f"n{above}_{b.n}"] = made[f"n{b.n}"]
        there, back = f"R{above}_{b.n}", f"R{b.n}_{above}"  # as lines print them: from, to
        made |= {there: made[back], back: made[there]}
    return made if s.follows(i) else made | {f"tau{s.index(i) + 1}": reactions.motor(i)}


def shown(model: Model, values: Mapping[str, Any]) -> list[str]:
    """Names of bodies' quantities that have a value on a page, even if no line contains them."""
    known = [x.known for x in BODY_QUANTITIES if x.shown]
    names = (x.format(**numbers(n)) for n in range(1, len(model.bodies) + 1) for x in known)
    return [name for name in names if name in values]


class Inputs(dict[str, Expr]):
    """A program's inputs by name, which take the place of a ring."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the computation's inputs, in their order."""
        return tuple(self)


class TracedReader(QuantityReader):
    """Reads a model's parameters as inputs of a program, or by their formulas; numbers stay
    numbers."""

    combines = False

    def __init__(
        self,
        inputs: Mapping[str, Expr],
        numbers: bool,
        formulas: Formulas,
        own: Mapping[str, ParameterFormula],
    ):
        """Read parameters as `inputs` of a program; formulas: those given to the derivation; own:
        the model's."""
        self.inputs, self.numbers, self.formulas, self.own = inputs, numbers, dict(formulas), own

    def quantity(self, q: Quantity) -> Scalar:
        if not isinstance(q, Parameter) or self.numbers:
            return super().quantity(q)
        if q.name not in self.formulas:
            formula = self.own.get(q.name)
            return formula.value(self.quantity) if formula else self.inputs[q.name]
        total: Scalar = 0.0
        for powers, factor in self.formulas[q.name]:
            factors = (self.inputs[name] for name, power in powers for _ in range(power))
            total = total + math.prod(factors, start=float(factor))
        return total

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        read = self.quantity(angle)
        return (sin(read), cos(read)) if isinstance(read, Expr) else exact_sin_cos(read)


@dataclass(frozen=True, eq=False)
class TracedSymbols(Symbols):
    """Symbols of a model over the inputs of a program in place of a ring."""

    @classmethod
    def of(cls, given: Symbols, inputs: Mapping[str, Expr]) -> TracedSymbols:
        """The same symbols over the scalars of a program."""
        ring: Any = Inputs(inputs)
        reader: Any = TracedReader(ring, given.reader.numbers, given.formulas, given.reader.own)
        names = given.coordinates, reader, given.extra, given.inertial
        rewritten = given.formulas, given.turned, given.quarters
        return cls(given.model, ring, *names, given.given, given.euler, *rewritten)

    def zero(self) -> Any:
        return self.element(0.0)

    def element(self, x: Scalar) -> Any:
        one: Any = self.own("")[0]
        return x if isinstance(x, Expr) else one.graph.constant(x)


@dataclass(frozen=True)
class _Drives:
    drives: list[Scalar]


class TracedSetting(Setting):
    """A derivation's setting over a program's scalars, without closed forms."""

    @property
    def equations(self) -> Any:
        """Friction and spring torques by coordinate, the only equations of such a setting."""
        s = self.symbols
        found: list[Scalar] = [0.0] * self.tree.nv
        for body in self.tree.bodies:
            if body.drive is not None:
                k, torque = body.coordinates.v[0], body.drive.torque(s.q, s.qd)
                found[k] = found[k] + body.coordinates.felt(s.q, torque)
        return _Drives(found)
