"""A model at one instant: where its parts are, how they move, and what acts on them."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from os import PathLike
from typing import Any

import numpy as np
from scipy.optimize import root

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array
from freebody.errors import warn
from freebody.expressions.naming import Naming
from freebody.expressions.notations.lettering import lettering_of
from freebody.expressions.notations.notation import BookNotation, notation_of
from freebody.expressions.polynomials.symbols import names_by_body
from freebody.figures.body_loads import BodyLoads, body_loads
from freebody.figures.drawing import SAME
from freebody.figures.drawing_names import DrawingNames
from freebody.figures.skeleton import BodyPlace, End, Skeleton, extent, skeleton
from freebody.lazy import cached_property
from freebody.loops.assembly import assemble
from freebody.loops.rates import loop_acceleration, loop_velocity
from freebody.model.model import Model
from freebody.model.parameter_formulas import followed
from freebody.model.parameters import Parameter, with_parameters
from freebody.trees.dynamics import mass_matrix
from freebody.trees.kinematics import acceleration, velocity
from freebody.trees.positions import integrate, neutral
from freebody.trees.public_calls import FrameWrenchTable, single_vector

_PATTERN = (("lc", 0.45), ("l", 0.9), ("a", 0.4), ("d", 0.3), ("m", 1.0), ("I", 0.05), ("g", 9.81))
_TURNS = (0.60, 0.75, -0.85, 0.80, -0.70)  # rad, of an arm that is only to be looked at
_RESTS = 1e-12  # of joints without motor: far below what drawings show
_RATES, _SECOND = (0.9, 1.1, -0.8), (1.5, 1.0, -1.0)


@dataclass(frozen=True, eq=False)
class Snapshot:
    """A model and its state: q (nq,) in rad or m; qd, qdd (nv,); wrenches on it as for
    `inverse_dynamics`."""

    model: Model
    q: Array
    qd: Array
    qdd: Array
    wrenches: FrameWrenchTable
    names: DrawingNames
    links: frozenset[int] = frozenset()
    """Bodies that stand for nothing, between joints that replace another; they are not drawn."""
    common_size: float | None = None
    """The size of several poses whose symbols are drawn alike, metres; default: this pose's."""

    @cached_property
    def drawn(self) -> tuple[BodyPlace, ...]:
        """The bodies that are drawn, without those that stand for nothing real."""
        return tuple(body for body in self.pose.bodies if body.index not in self.links)

    def is_held(self, body: BodyPlace) -> bool:
        """Whether a body is attached to its parent by a joint that is drawn."""
        return body.parent not in self.links

    @cached_property
    def pose(self) -> Skeleton:
        """Places of all parts of the robot."""
        return skeleton(self.model, self.q)

    @cached_property
    def size(self) -> float:
        """Diagonal of the box around the robot, metres."""
        return extent([self.pose]) if self.common_size is None else self.common_size

    @cached_property
    def loads(self) -> tuple[BodyLoads, ...]:
        """Forces and moments on each body."""
        return body_loads(self.names.naming, self.pose, self.q, self.qd, self.qdd, self.wrenches)

    def end(self, body: BodyPlace) -> Array | None:
        """The far end of a body: the joint of its first child (after a slide), else the tip; None
        where there is neither."""
        return next((place for _, place in self.reaches(body)), None)

    def reaches(self, body: BodyPlace) -> list[tuple[End, Array]]:
        """The ends of the vectors s from a body's joint: its children's joints (after a slide) and
        the tip it carries; its first leaf where it has neither."""
        found = [
            (end, self.pose.bodies[end.child].origin) for end in body.ends if end.child is not None
        ]
        leaves = [(end, end.place) for end in body.ends if end.child is None]
        return [*found, *(x for x in leaves if x[0].name == self.model.tip)] or leaves[:1]

    def heading(self, body: BodyPlace) -> Array:
        """Unit vector along a body, from its joint outwards."""
        for place in (self.end(body), body.com):
            if place is not None and np.linalg.norm(place - body.origin) > SAME:
                return (place - body.origin) / np.linalg.norm(place - body.origin)
        return body.rotation[:, 0]

    def velocity_at(self, body: BodyPlace, place: Array) -> Array:
        """Velocity (dim,) of the point of a body that is at `place`, m/s, world axes."""
        local = body.rotation.T @ (place - body.origin)
        found = velocity(self.model, self.q, self.qd, self._frame(body), local)
        return np.asarray(found)[: self.model.dim]

    def acceleration_at(self, body: BodyPlace, place: Array) -> Array:
        """Acceleration (dim,) of the point of a body that is at `place`, m/s², world axes."""
        local = body.rotation.T @ (place - body.origin)
        found = acceleration(self.model, self.q, self.qd, self.qdd, self._frame(body), local)
        return np.asarray(found)[: self.model.dim]

    def angular(self, body: BodyPlace) -> Array:
        """Angular velocity of a body: (3,) rad/s in world axes, (1,) in the plane."""
        found = velocity(self.model, self.q, self.qd, self._frame(body))
        return np.asarray(found)[self.model.dim :]

    def _frame(self, body: BodyPlace) -> str:
        return next(f.name for f in self.model.frames if f.body == body.index and not f.parent)


def snapshot(
    model: Model,
    q: Any = None,
    qd: Any = None,
    qdd: Any = None,
    wrenches: FrameWrenchTable = None,
    caller: str = "a drawing",
    notation: BookNotation | str | PathLike[str] | None = None,
) -> Snapshot:
    """A snapshot of a model; parameters without value and a state that is not given are chosen so
    that the drawing is clear. caller: for errors; notation: whose letters label it, as for
    `check`."""
    shown = with_values(model)

    def given(name: str, value: Any, default: Callable[[], Array]) -> Array:
        return default() if value is None else single_vector(caller, shown, name, value)

    at = given("q", q, lambda: _seen_well(shown))
    rates = given("qd", qd, lambda: _consistent_rates(shown, at))
    second = given("qdd", qdd, lambda: _consistent_second(shown, at, rates, wrenches))
    coordinates = (name for names in names_by_body(shown) for name in names)
    style = notation_of(notation)
    if style.parameters:
        warn(
            f"{caller}: [parameters] of the notation {style.name!r} are not drawn; labels are "
            "letters, not formulas."
        )
    letters = lettering_of(style, model, tuple(coordinates))
    naming = Naming(shown, letters=letters)
    return Snapshot(shown, at, rates, second, wrenches, DrawingNames(naming))


def _seen_well(model: Model) -> Array:
    """A pose that shows all parts well; of a closed chain its home, or near it a pose at which all
    loops are closed."""
    if not model.loops:
        return clear_pose(model)
    return assemble(model) if model.home else assemble(model, clear_pose(model))


def resting_pose(model: Model, wrenches: FrameWrenchTable) -> Array | None:
    """A pose at which an arm's joints without motor rest by themselves; None where it has none, or
    none was found."""
    free = list(model.passive)
    if model.loops or not free:
        return None
    start, still = clear_pose(model), np.zeros(model.nv)

    def moved(x: Array) -> Array:
        way = np.zeros(model.nv)
        way[free] = x
        return np.asarray(integrate(model, start, way))

    def missing(x: Array) -> Array:
        return np.asarray(inverse_dynamics(model, moved(x), still, still, wrenches=wrenches))[free]

    found = root(missing, still[free], tol=_RESTS)
    return moved(found.x) if found.success else None


def _consistent_rates(model: Model, q: Array) -> Array:
    rates = _cycled(model, _RATES)
    return loop_velocity(model, q, rates) if model.loops else rates


def _consistent_second(model: Model, q: Array, qd: Array, wrenches: FrameWrenchTable) -> Array:
    """Accelerations that a closed chain's loops allow, or for which an arm's joints without motor
    need no torque."""
    second = _cycled(model, _SECOND)
    if model.loops:
        return loop_acceleration(model, q, qd, second)
    free = list(model.passive)
    if free:
        missing = np.asarray(inverse_dynamics(model, q, qd, second, wrenches=wrenches))[free]
        M = np.asarray(mass_matrix(model, q))[np.ix_(free, free)]
        second[free] -= np.linalg.lstsq(M, missing, rcond=None)[0]
    return second


def with_values(model: Model) -> Model:
    """The model with a value for each parameter that has none, by what its name says it is.

    Not `bind`, which asks for inertias that a rigid body may have: beside given ones typical values
    need not be, and a drawing of places and forces is none the worse for it.
    """
    missing = set(model.missing)

    def valued(p: Parameter) -> Parameter:
        return Parameter(p.name, _typical(p.name, model.parameters)) if p.name in missing else p

    found = with_parameters(model, valued)
    return followed(found) if found.formulas else found


def _typical(name: str, given: Mapping[str, float | None]) -> float:
    """A typical value (m, kg or kg m²) for a parameter by its name: links grow shorter outwards,
    centres of mass are halfway along links of given lengths, products of inertia are 0."""
    if re.search(r"(xy|xz|yz)$", name):
        return 0.0
    length = given.get(f"l{name[2:]}") if name.startswith("lc") else None
    if length is not None:
        return length / 2
    size = next((value for start, value in _PATTERN if name.startswith(start)), 0.1)
    digits = re.search(r"\d+", name)
    return size * 0.9 ** (int(digits.group()) - 1) if digits and name[0] in "lad" else size


def clear_pose(model: Model) -> Array:
    """q (nq,) at which an arm is seen well: bent at each turn, slid out at each slide, within the
    limits."""
    q = np.array(neutral(model), dtype=float)
    length = _slide(model)
    turn = 0
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is not None or body.kind.nq != body.kind.nv or not body.kind.holds:
            continue
        for k, turns in zip(at.q, body.kind.angular, strict=True):
            q[k], turn = (_TURNS[turn % len(_TURNS)], turn + 1) if turns else (length, turn)
        limits = body.joint.limits.meant
        low, high = limits.lower, limits.upper
        if body.kind.nq == 1 and np.isfinite(low) and np.isfinite(high):
            inner = low + 0.25 * (high - low), high - 0.25 * (high - low)
            q[at.q[0]] = min(max(q[at.q[0]], inner[0]), inner[1])
    return q


def _slide(model: Model) -> float:
    """The length by which slides are drawn out, metres: about as long as the links are."""
    size = extent([skeleton(model, neutral(model))])
    turns = sum(not body.kind.slides for body in model.bodies)
    return 0.7 if size == 1.0 and not turns else 0.55 * size / max(turns, 1)


def _cycled(model: Model, values: tuple[float, ...]) -> Array:
    return np.array([values[k % len(values)] for k in range(model.nv)])
