"""A model in symbols: its ring, its coordinates and its tree over exact polynomials."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.errors import FreebodyError
from freebody.expressions.grammar.parser import PI
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Parameter, Quantity, each_parameter, with_parameters
from freebody.model.placement import AxisRotation
from freebody.model.quantity_reader import QuantityReader
from freebody.model.single_joints import with_single_joints
from freebody.model.tree import Tree, lower
from freebody.scalars.generators import sign_of
from freebody.scalars.rational import rational_axis, rational_rotation, rational_sin_cos
from freebody.scalars.trig import Trig, TrigRing
from freebody.spatial import Matrix, Vector
from freebody.values import ByValue, key

Formulas = tuple[tuple[str, tuple[tuple[tuple[tuple[str, int], ...], Fraction], ...]], ...]
"""Names, and the terms of the polynomials that they stand for."""
RATE, SECOND = "_d", "_dd"
"""Endings of the names of velocities and accelerations."""


class TrigReader(QuantityReader):
    """A reader of parameters as generators of a ring, and of numbers exactly."""

    combines = False

    def __init__(
        self,
        ring: TrigRing,
        numbers: bool,
        formulas: Formulas = (),
        own: Mapping[str, ParameterFormula] | None = None,
    ):
        """Take over the ring, with further formulas; numbers: whether values stand in place of
        parameters; own: the model's formulas for parameters that are no generators."""
        self.ring = ring
        self.numbers = numbers
        self.own = own or {}
        self.formulas = {
            name: ring.polynomial((dict(powers), x) for powers, x in terms)
            for name, terms in formulas
        }

    def quantity(self, q: Quantity) -> Scalar:
        if isinstance(q, Parameter) and not self.numbers:
            formula = self.formulas.get(q.name)
            if formula is None and q.name in self.own:
                return self.own[q.name].value(self.quantity, self.number)
            if formula is None:
                return self.ring[q.name]
            return 0.0 if formula.is_zero else formula
        number = float(super().quantity(q))
        return 0.0 if number == 0.0 else Trig(self.ring, self.ring.constant(number), 0)

    def number(self, x: Fraction) -> Trig:
        """An exact number as polynomial of the ring."""
        return Trig(self.ring, self.ring.constant(x), 0)

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        if isinstance(angle, Parameter) and not self.numbers:
            return self.ring.sin(angle.name), self.ring.cos(angle.name)
        value = angle.value if isinstance(angle, Parameter) else angle
        s, c = rational_sin_cos(float(value))  # type: ignore[arg-type]
        return self._plain(s), self._plain(c)

    def rotation(self, matrix: Matrix) -> Matrix:
        if len(matrix) == 2:
            return matrix
        return tuple(tuple(self._plain(x) for x in row) for row in rational_rotation(matrix))

    def axis(self, axis: Vector) -> Vector:
        return tuple(self._plain(x) for x in rational_axis(axis)) if len(axis) == 3 else axis

    def _plain(self, x: Fraction | float) -> Scalar:
        """The floats 0 and ±1, which simplify at once, where x is one of them; any other number as
        an element of the ring."""
        return float(x) if x in (0, 1, -1) else Trig(self.ring, self.ring.constant(x), 0)


@dataclass(frozen=True, eq=False)
class Symbols(ByValue):
    """A model's symbols: coordinates θ_i (turning), d_i (sliding) and the like, numbered by joint
    from 1, their rates, and the tree over the ring."""

    model: Model
    ring: TrigRing
    coordinates: tuple[str, ...]
    reader: TrigReader
    extra: tuple[str, ...] = ()
    """Further symbols, such as the components of a load."""
    inertial: Mapping[str, tuple[int, int]] = field(default_factory=dict)
    """Further symbols that stand for masses (0) and inertias (1) of bodies: name and (body,
    which)."""
    given: Model | None = None
    """The model as it was given; `model` is that with parameters of value 0 put in."""
    euler: bool = False
    """Whether three angles stand for each quaternion."""
    formulas: Formulas = ()
    """Parameters that are no symbols of the ring but polynomials in other parameters."""
    turned: tuple[tuple[int, ...], ...] | None = None
    """B of θ = B φ, where the joints' coordinates are θ and the symbols stand for φ."""
    quarters: tuple[int, ...] = ()
    """The right angles from the x axis to where each of φ is 0."""
    follows: bool = True
    """Whether formulas of the model are put in; else all its parameters are symbols."""

    def _key(self) -> tuple[Any, ...]:
        return tuple(map(key, self._recipe))

    def __reduce__(self) -> tuple[Any, ...]:
        return symbols, self._recipe  # rings and their elements are made anew

    @property
    def _recipe(self) -> tuple[Any, ...]:
        given = self.given or self.model
        others = self.formulas, self.turned, self.quarters, self.follows
        return given, self.reader.numbers, self.extra, self.inertial, self.euler, *others

    @cached_property
    def tree(self) -> Tree:
        """The model's tree with elements of the ring as its numbers."""
        return lower(self.model, self.reader)

    @property
    def is_rewritten(self) -> bool:
        """Whether the symbols differ from the model's own: by formulas, or by other angles."""
        return bool(self.formulas or self.turned or any(self.quarters))

    def require_plain(self, what: str) -> None:
        """Raise an error where `what` is available in the model's own symbols only and these are
        rewritten."""
        if self.is_rewritten:
            raise FreebodyError(
                f"{what}: the derivation of {self.model.name!r} has angles or parameters of a "
                "notation; fb.equations(model) gives these in the model's own."
            )

    @property
    def q(self) -> tuple[Trig, ...]:
        """The joints' coordinates."""
        plain = self.own("")
        if self.quarters:
            plain = [x + PI / 2 * k for x, k in zip(plain, self.quarters, strict=True)]
        return self.of_joints(plain)

    @property
    def qd(self) -> tuple[Trig, ...]:
        """Rates of the coordinates."""
        return self.of_joints(self.own(RATE))

    @property
    def qdd(self) -> tuple[Trig, ...]:
        """Accelerations of the coordinates."""
        return self.of_joints(self.own(SECOND))

    def followed(self, given: Mapping[str, Trig]) -> dict[str, Trig]:
        """The given values of parameters, with those that follow from the model's formulas."""
        found, reader = dict(given), TrigReader(self.ring, self.reader.numbers)

        def read(q: Quantity) -> Scalar:
            known = found.get(q.name) if isinstance(q, Parameter) else None
            return reader.quantity(q) if known is None else known

        names = names_by_formulas(self.model)
        for formula in self.model.formulas:
            if formula.name not in found and formula.name in names:
                found[formula.name] = self.element(formula.value(read, reader.number))
        return found

    def own(self, ending: str) -> list[Trig]:
        """The symbols of the coordinates, or with an ending those of their rates or
        accelerations."""
        return [self.ring[x + ending] for x in self.coordinates]

    def of_joints(self, values: Sequence[Trig]) -> tuple[Trig, ...]:
        """Values along the joints' coordinates, B φ, from values along the notation's angles φ."""
        rows = self.turned
        return tuple(values) if rows is None else tuple(self._sum(row, values) for row in rows)

    def of_angles(self, forces: Sequence[Trig]) -> list[Trig]:
        """Forces along the notation's angles, Bᵀ τ, from forces along the joints' coordinates."""
        rows = self.turned
        if rows is None:
            return list(forces)
        return [self._sum(column, forces) for column in zip(*rows, strict=True)]

    def _sum(self, factors: Sequence[int], values: Sequence[Trig]) -> Trig:
        return sum((x * k for k, x in zip(factors, values, strict=True) if k), self.zero())

    @property
    def rates(self) -> dict[str, Trig]:
        """The time derivative of each variable that moves."""
        moving = {x: self.ring[x + RATE] for x in self.coordinates}
        return moving | {x + RATE: self.ring[x + SECOND] for x in self.coordinates}

    def zero(self) -> Trig:
        """The polynomial 0 in the ring."""
        return Trig(self.ring, self.ring.constant(0), 0)

    def element(self, x: Scalar) -> Trig:
        """A scalar of the algorithms, which may be a float, as an element of the ring."""
        return x if isinstance(x, Trig) else Trig(self.ring, self.ring.constant(x), 0)

    def values(self, q: Any, qd: Any = None, qdd: Any = None) -> dict[str, Any]:
        """Numbers by name, for `Trig.evaluate`: arrays (..., n) and the model's parameter
        values."""
        values: dict[str, Any] = {k: v for k, v in self.model.parameters.items() if v is not None}
        for ending, array in (("", q), (RATE, qd), (SECOND, qdd)):
            if array is not None:
                values |= {x + ending: array[..., i] for i, x in enumerate(self.coordinates)}
        if qd is not None:
            values |= {
                sign_of(x + RATE): np.sign(qd[..., i]) for i, x in enumerate(self.coordinates)
            }
        return values

    def evaluate(self, quantity: Any, q: Any, qd: Any = None, qdd: Any = None) -> Array:
        """Numbers of polynomials, in lists of any depth, at q, qd, qdd (..., n); with the
        parameters' values."""
        arrays = [None if x is None else np.asarray(x, dtype=float) for x in (q, qd, qdd)]
        values = self.values(*arrays)
        batch = np.broadcast_shapes(*(x.shape[:-1] for x in arrays if x is not None))

        def number(x: Any) -> Any:
            if isinstance(x, Trig):
                return np.broadcast_to(x.evaluate(values), batch)
            return np.stack([number(entry) for entry in x], axis=len(batch))

        return number(quantity)


def symbols(
    model: Model,
    numbers: bool = False,
    extra: tuple[str, ...] = (),
    inertial: Mapping[str, tuple[int, int]] | None = None,
    euler: bool = False,
    formulas: Formulas = (),
    turned: tuple[tuple[int, ...], ...] | None = None,
    quarters: tuple[int, ...] = (),
    follows: bool = True,
) -> Symbols:
    """The model in symbols; `numbers` puts in the values of parameters that have one.

    A parameter whose value is 0 is no symbol: it is 0, in whatever is written about the model; one
    with a formula is what that says. extra, inertial, formulas, turned, quarters, follows: see
    `Symbols`. euler: put yaw, pitch and roll in
    the place of quaternions, which are refused otherwise.
    """
    if model.struts:
        raise FreebodyError(
            f"{model.name!r} has struts ({', '.join(model.strut_names)}), whose lengths are no "
            f'polynomials in sines and cosines; closed forms are of model.without("struts").'
        )
    given, following = model, names_by_formulas(model)
    model = with_parameters(model, lambda p: 0.0 if p.value == 0 and p.name not in following else p)
    model = with_single_joints(model, euler)
    _require_whole_ratios(model)
    coordinates = coordinate_names(model)
    own = {x.name: x for x in model.formulas if follows and x.name in following}
    given_by_formulas = own.keys() | {name for name, _ in formulas}
    names = [] if numbers else list(dict.fromkeys(p.name for p in each_parameter(model)))
    parameters = [name for name in names if name not in given_by_formulas]
    ring = _ring(model, coordinates, parameters, (*extra, *(inertial or ())))
    return Symbols(
        model,
        ring,
        coordinates,
        TrigReader(ring, numbers, formulas, own),
        extra,
        inertial or {},
        given,
        euler,
        formulas,
        turned,
        quarters,
        follows,
    )


def coordinate_names(model: Model) -> tuple[str, ...]:
    """Names of the coordinates: theta_i and d_i by joint, or the slide's own name where it is x, y
    or z."""
    for body in model.bodies:
        if body.kind.quaternion is not None:
            raise FreebodyError(
                f"joint {body.joint.name!r} of {model.name!r} is {body.kind.name}: closed forms "
                "need coordinates that are numbers; put three revolute joints (Euler angles)"
                f"{' and three prismatic ones' if body.kind.nv == 6 else ''} in its place."
            )
    return tuple(name for names in names_by_body(model) for name in names)


def names_by_body(model: Model) -> list[tuple[str, ...]]:
    """The name of the coordinate of each body's joint; none for a joint that follows another or has
    several coordinates."""
    names: list[tuple[str, ...]] = []
    parameters = {p.name for p in each_parameter(model)}
    i = 0
    for body in model.bodies:
        joint = body.joint
        i += joint.mimic is None
        own = joint.name in ("x", "y", "z") and joint.name not in parameters
        if joint.mimic is not None:
            names.append(())
        elif body.kind.slides and own:
            names.append((joint.name,))
        else:
            names.append((f"{body.kind.coordinate}{i}",) if body.kind.nv == 1 else ())
    return names


def _require_whole_ratios(model: Model) -> None:
    """Refuse a turning joint that follows another by a fraction of its angle, or a slide."""
    turning = {body.joint.name: any(body.kind.angular) for body in model.bodies}
    for body in model.bodies:
        mimic = body.joint.mimic
        if mimic is None or not turning[body.joint.name]:
            continue
        if not turning[mimic.joint]:
            raise FreebodyError(
                f"joint {body.joint.name!r} of {model.name!r} turns as {mimic.joint!r} slides: "
                f"closed forms need an angle, since sines and cosines of a length are not "
                'polynomials. Load with mimic="free", or let the turning joint lead.'
            )
        if mimic.ratio != round(mimic.ratio):
            raise FreebodyError(
                f"joint {body.joint.name!r} of {model.name!r} turns {mimic.ratio:g} times as far "
                f"as {mimic.joint!r}: closed forms need a whole number, since sines and cosines of "
                f"a fraction of an angle "
                'are not polynomials in its own. Load with mimic="free", '
                "or let the slower joint lead."
            )


def names_by_formulas(model: Model) -> set[str]:
    """Parameters that formulas of the model give in symbols: all but angles, whose sines and
    cosines have names of their own."""
    return {formula.name for formula in model.formulas} - _angle_parameters(model)


def _ring(
    model: Model, coordinates: Sequence[str], parameters: Sequence[str], further: Iterable[str]
) -> TrigRing:
    """The polynomials in coordinates, their rates and accelerations, and parameters; coordinates
    and parameters that are angles have sines and cosines."""
    turning = [
        name
        for body, own in zip(model.bodies, names_by_body(model), strict=True)
        for name, is_angle in zip(own, body.kind.angular, strict=False)
        if is_angle
    ]
    turns = _angle_parameters(model)
    angles = [x for x in parameters if x in turns]
    others = [
        *(x for x in coordinates if x not in turning),
        *(x + RATE for x in coordinates),
        *(x + SECOND for x in coordinates),
        *(sign_of(x + RATE) for x in coordinates),
        *(x for x in parameters if x not in angles),
        *further,
    ]
    return TrigRing([*turning, *angles], others)


def _angle_parameters(model: Model) -> set[str]:
    """Names of the parameters by which constant placements are turned."""
    placements = [body.joint.placement for body in model.bodies]
    placements += [part.placement for body in model.bodies for part in body.inertias]
    placements += [frame.placement for frame in model.frames]
    return {
        step.angle.name
        for placement in placements
        for step in placement.steps
        if isinstance(step, AxisRotation) and isinstance(step.angle, Parameter)
    }
