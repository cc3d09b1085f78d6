"""`Model`: a robot, frozen. Bodies are what moves; links that are fixed to one another are one body."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from numbers import Real
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, MissingValueError, ModelError, UnknownNameError
from freebody.model.inertia import Inertia
from freebody.model.joints import KINDS, JointKind
from freebody.model.parameters import (
    Parameter,
    Quantity,
    each_parameter,
    finite,
    quantity,
    with_parameters,
)
from freebody.model.parts import Joint, Notice
from freebody.model.placement import Placement, Rotate, Shift, Turn, rotate, shift
from freebody.model.reading import VALUES
from freebody.model.tree import Attached, Coordinates, Tree, lower


@dataclass(frozen=True)
class Frame:
    """A named frame fixed to a body (index; -1 is the base), placed in the body's frame.

    `parent` is the frame it is fixed to, empty for the frame of a body's first link or of the base. It belongs to a
    link unless it is `mounted`.
    """

    name: str
    body: int
    placement: Placement = Placement()
    parent: str = ""
    mounted: bool = False


@dataclass(frozen=True)
class Body:
    """A movable rigid body: the joint that carries it, the body it hangs on (-1: the base), and its mass.

    The body's frame is its joint's: the link frame of the joint's child at the joint. `joint.placement` is given in
    the parent body's frame. `inertias` keeps every link that is lumped here under its own name.
    """

    name: str
    joint: Joint
    parent: int
    inertias: tuple[Attached, ...] = ()

    @property
    def kind(self) -> JointKind:
        """The joint's kind."""
        return KINDS[self.joint.kind]


@dataclass(frozen=True)
class JointLimits:
    """For each entry of q̇ its joint's limits, infinite for joints of several axes: arrays (nv,); rad or m, N m or N."""

    lower: Array
    upper: Array
    velocity: Array
    effort: Array


@dataclass(frozen=True, eq=False)
class Model:
    """A robot: bodies in the file's order of their joints, named frames, gravity. Made by `load`, `planar`, `dh`."""

    name: str
    dim: int
    bodies: tuple[Body, ...]
    frames: tuple[Frame, ...]
    gravity_size: Quantity
    gravity_direction: tuple[float, ...]
    base_inertias: tuple[Attached, ...] = ()
    tip: str | None = None
    source: str = ""
    notices: tuple[Notice, ...] = ()

    # ------------------------------------------------------------ sizes and names
    @cached_property
    def coordinates(self) -> tuple[Coordinates, ...]:
        """For each body, where its joint's q and q̇ stand in the vectors; a mimic joint shares its leader's."""
        own: dict[str, Coordinates] = {}
        iq = iv = 0
        for body in self.bodies:
            if body.joint.mimic is None:
                kind = body.kind
                own[body.joint.name] = Coordinates(
                    tuple(range(iq, iq + kind.nq)), tuple(range(iv, iv + kind.nv)), 1.0, 0.0
                )
                iq, iv = iq + kind.nq, iv + kind.nv
        result = []
        for body in self.bodies:
            mimic = body.joint.mimic
            # assembly has already resolved mimics of mimics to an independent leader
            result.append(
                own[body.joint.name]
                if mimic is None
                else replace(own[mimic.joint], ratio=mimic.ratio, offset=mimic.offset)
            )
        return tuple(result)

    @property
    def nq(self) -> int:
        """Number of position coordinates."""
        return sum(body.kind.nq for body in self.bodies if body.joint.mimic is None)

    @property
    def nv(self) -> int:
        """Number of velocity coordinates: the degrees of freedom."""
        return sum(body.kind.nv for body in self.bodies if body.joint.mimic is None)

    @property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the movable joints, followers of other joints included, in the file's order."""
        return tuple(body.joint.name for body in self.bodies)

    @cached_property
    def position_names(self) -> tuple[str, ...]:
        """A name for each entry of q: the joint's, with the component where it has several."""
        return self._names(lambda kind: kind.position_names)

    @cached_property
    def velocity_names(self) -> tuple[str, ...]:
        """A name for each entry of q̇ and tau."""
        return self._names(lambda kind: kind.velocity_names)

    def _names(self, components: Callable[[JointKind], tuple[str, ...]]) -> tuple[str, ...]:
        return tuple(
            f"{body.joint.name}.{component}" if component else body.joint.name
            for body in self.bodies
            if body.joint.mimic is None
            for component in components(body.kind)
        )

    @property
    def frame_names(self) -> tuple[str, ...]:
        """Names of all frames: links and mounted ones."""
        return tuple(frame.name for frame in self.frames)

    @cached_property
    def _frame_by_name(self) -> dict[str, Frame]:
        return {frame.name: frame for frame in self.frames}

    @cached_property
    def leaves(self) -> tuple[str, ...]:
        """The movable frames at the ends of the tree: links that carry nothing, or what is mounted on them."""
        carry = {body.joint.parent for body in self.bodies} | {f.parent for f in self.frames if not f.mounted}

        def ends(frame: Frame) -> tuple[str, ...]:
            mounted = [f for f in self.frames if f.mounted and f.parent == frame.name]
            return tuple(end for f in mounted for end in ends(f)) or (frame.name,)

        links = [f for f in self.frames if not f.mounted and f.body >= 0 and f.name not in carry]
        return tuple(end for link in links for end in ends(link))

    def frame(self, name: str | None = None) -> Frame:
        """The frame of that name; None is the tip."""
        if name is None:
            if self.tip is None:
                raise FreebodyError(
                    f"{self.name!r} has no single tip: name a frame, or load with tip=. "
                    f"Leaves: {', '.join(self.leaves)}."
                )
            name = self.tip
        try:
            return self._frame_by_name[name]
        except (KeyError, TypeError):  # a TypeError: what cannot be a name
            raise UnknownNameError("frame", name, f"{self.name!r}", self.frame_names) from None

    def body_index(self, name: str) -> int:
        """Index of the body that carries a link or body of that name."""
        for i, body in enumerate(self.bodies):
            if body.name == name:
                return i
        return self.frame(name).body

    # ------------------------------------------------------------ numbers
    @property
    def parameters(self) -> dict[str, float | None]:
        """Names and values of the parameters."""
        return {parameter.name: parameter.value for parameter in each_parameter(self)}

    @property
    def missing(self) -> tuple[str, ...]:
        """Names of the parameters without value."""
        return tuple(sorted(name for name, value in self.parameters.items() if value is None))

    def require_values(self, what: str) -> None:
        """Refuse a model with parameters that have no value."""
        if self.missing:
            raise MissingValueError(f"{what} of {self.name!r}", self.missing)

    @cached_property
    def tree(self) -> Tree:
        """The model in numbers, as the algorithms take it."""
        self.require_values("the numbers")
        return lower(self, VALUES)

    @cached_property
    def compiled(self) -> dict[Any, Any]:
        """What has been compiled for this model; filled and read by the numeric functions."""
        return {}

    @cached_property
    def mass(self) -> float:
        """Total mass (kg) of all links, those fixed to the base included."""
        missing = [p.name for a in self._attached for p in each_parameter(a.inertia.mass) if p.value is None]
        if missing:
            raise MissingValueError(f"the mass of {self.name!r}", missing)
        return float(sum(VALUES.quantity(a.inertia.mass) for a in self._attached))

    @property
    def gravity(self) -> Array:
        """The gravity field (dim,) in world axes, m/s²."""
        missing = [p.name for p in each_parameter(self.gravity_size) if p.value is None]
        if missing:
            raise MissingValueError(f"the gravity of {self.name!r}", missing)
        size = VALUES.quantity(self.gravity_size)
        return size * np.array(self.gravity_direction)

    @property
    def limits(self) -> JointLimits:
        """Limits of the coordinates, arrays (nv,); infinite where there are none."""
        rows = []
        for body in self.bodies:
            if body.joint.mimic is None:
                limits = body.joint.limits
                rows += [(limits.lower, limits.upper, limits.velocity, limits.effort)] * body.kind.nv
        return (
            JointLimits(*(np.array(column, dtype=float) for column in zip(*rows, strict=True)))
            if rows
            else JointLimits(*(np.zeros(0) for _ in range(4)))
        )

    @property
    def _attached(self) -> tuple[Attached, ...]:
        """The inertias of all links, the base's first."""
        return (*self.base_inertias, *(part for body in self.bodies for part in body.inertias))

    # ------------------------------------------------------------ changed copies
    def bind(self, **values: float) -> Model:
        """The model with values for parameters: model.bind(l1=0.4, m1=2)."""
        known = self.parameters
        for name in values:
            if name not in known:
                raise UnknownNameError("parameter", name, f"{self.name!r}", known)
        bound = with_parameters(
            self,
            lambda p: Parameter(p.name, values[p.name]) if p.name in values else p,  # type: ignore[arg-type]
        )
        for old, new in zip(self._attached, bound._attached, strict=True):
            if new is not old:  # what was accepted before stays so
                fault = new.inertia.fault()
                if fault:
                    raise ModelError(f"{self.name!r}: link {new.link!r}: {fault}. Bind a physical value.")
        return bound

    def replace(
        self,
        *,
        name: str | None = None,
        gravity: float | Sequence[float] | str | None = None,
        tip: str | None = None,
    ) -> Model:
        """The model with another name, tip or gravity: a size (0 for none), a name, or a vector in world axes."""
        changes: dict[str, object] = {}
        if name is not None:
            changes["name"] = name
        if tip is not None:
            changes["tip"] = self.frame(tip).name
        if gravity is not None:
            changes["gravity_size"], changes["gravity_direction"] = gravity_of(
                gravity, self.dim, self.gravity_direction
            )
        return dataclasses.replace(self, **changes)  # type: ignore[arg-type]

    def without(self, *features: str) -> Model:
        """The model without "friction", "rotors" or "springs"."""
        fields = {
            "friction": {"viscous": 0.0, "coulomb": 0.0},
            "rotors": {"rotor": 0.0},
            "springs": {"stiffness": 0.0},
        }
        off: dict[str, float] = {}
        for feature in features:
            if feature not in fields:
                raise UnknownNameError("feature", feature, "Model.without", fields)
            off.update(fields[feature])
        return dataclasses.replace(
            self,
            bodies=tuple(
                replace(body, joint=replace(body.joint, drive=replace(body.joint.drive, **off)))
                for body in self.bodies
            ),
        )

    def with_payload(
        self,
        inertia: Inertia | float | None = None,
        *,
        mass: float | None = None,
        com: Sequence[float] | None = None,
        frame: str | None = None,
        name: str = "payload",
    ) -> Model:
        """The model carrying a rigid load in `frame` (default: the tip).

        inertia: an Inertia in the frame's axes, or a number: the mass (kg) of a particle, as `mass` is. com: (dim,) m,
        where the load's centre of mass is in the frame; default the Inertia's own, of a particle the origin. Raises
        ModelError for a load that no rigid body is.
        """
        at = self.frame(frame)
        load = _load(inertia, mass, com, self.dim)
        if load.dim != self.dim:
            raise ModelError(f"with_payload: the inertia is {load.dim}D but {self.name!r} is {self.dim}D.")
        fault = load.fault()
        if fault:
            raise ModelError(f"with_payload: {name!r}: {fault}.")
        attached = Attached(name, load, at.placement, load=True)
        if at.body < 0:
            return dataclasses.replace(self, base_inertias=(*self.base_inertias, attached))
        bodies = list(self.bodies)
        bodies[at.body] = replace(bodies[at.body], inertias=(*bodies[at.body].inertias, attached))
        return dataclasses.replace(self, bodies=tuple(bodies))

    def with_tool(
        self,
        name: str,
        position: Sequence[float] | None = None,
        rotation: Sequence[Sequence[float]] | Array | None = None,
        *,
        inertia: Inertia | None = None,
        frame: str | None = None,
    ) -> Model:
        """The model with a new tip: frame `name` at `position`, `rotation` (matrix) in `frame` (default: the
        tip now)."""
        at = self.frame(frame)
        if name in self._frame_by_name:
            raise ModelError(f"with_tool: {self.name!r} already has a frame {name!r}; choose another name.")
        placement = at.placement
        if position is not None:
            if len(position) != self.dim:
                raise ModelError(f"with_tool: position has {len(position)} entries, expected {self.dim}.")
            placement = placement.then(shift(*(finite(x, "with_tool: position") for x in position)))
        if rotation is not None:
            if np.shape(rotation) != (self.dim, self.dim):
                raise ModelError(
                    f"with_tool: rotation has shape {np.shape(rotation)}, expected {(self.dim, self.dim)}."
                )
            placement = placement.then(rotate(rotation, "with_tool"))
        model = dataclasses.replace(
            self, frames=(*self.frames, Frame(name, at.body, placement, at.name, mounted=True)), tip=name
        )
        return model if inertia is None else model.with_payload(inertia, frame=name, name=name)

    def to_space(self) -> Model:
        """The twin in space of a planar model: its plane is xy, z points to the reader."""
        if self.dim == 3:
            return self
        return dataclasses.replace(
            self,
            dim=3,
            bodies=tuple(
                replace(
                    body,
                    joint=replace(
                        body.joint,
                        placement=_placement_in_space(body.joint.placement),
                        axis=body.kind.axis_in_space(body.joint.axis),
                    ),
                    inertias=tuple(map(_attached_in_space, body.inertias)),
                )
                for body in self.bodies
            ),
            frames=tuple(
                replace(frame, placement=_placement_in_space(frame.placement)) for frame in self.frames
            ),
            base_inertias=tuple(map(_attached_in_space, self.base_inertias)),
            gravity_direction=(*self.gravity_direction, 0.0),
        )

    def __getstate__(self) -> dict[str, Any]:
        # what is cached is machine code or quick to make again; another process makes its own
        return {field.name: getattr(self, field.name) for field in dataclasses.fields(self)}

    def __repr__(self) -> str:
        return f"<Model {self.name!r}: {len(self.bodies)} bodies, nq = {self.nq}, nv = {self.nv}, dim {self.dim}>"


def _load(
    inertia: Inertia | float | None, mass: float | None, com: Sequence[float] | None, dim: int
) -> Inertia:
    """What the arguments of `with_payload` mean."""
    if inertia is not None and mass is not None:
        raise ModelError("with_payload: inertia and mass= exclude each other; give one of them.")
    given = mass if inertia is None else inertia
    if isinstance(given, int | float | Real):
        return Inertia.point(float(given), (0.0,) * dim if com is None else com)
    if not isinstance(given, Inertia):
        raise ModelError("with_payload: give an Inertia, or mass= (and com=).")
    return given if com is None else given.moved_to(com)


def gravity_of(
    given: float | str | Parameter | Sequence[float],
    dim: int,
    direction: tuple[float, ...] | None = None,
    name: str | None = None,
) -> tuple[Quantity, tuple[float, ...]]:
    """(size, unit direction) from a vector, a size or a name; a size keeps `direction` (default: down).

    A size becomes the value of the parameter `name`, so that equations can show a letter.
    """
    down = (0.0,) * (dim - 1) + (-1.0,)
    direction = direction or down
    if isinstance(given, str | Parameter | int | float | Real):
        return quantity(given, "gravity", name), direction
    vector = np.array([finite(x, "gravity") for x in given])
    if vector.shape != (dim,):
        raise ModelError(f"gravity: a vector of {dim} entries in world axes is needed, not {len(vector)}.")
    size = float(np.linalg.norm(vector))
    # a vector along an axis keeps its size to the last bit
    axis = int(np.argmax(abs(vector)))
    if size and size == abs(vector[axis]):
        return size, tuple(float(np.sign(x)) if i == axis else 0.0 for i, x in enumerate(vector))
    return (size, tuple(float(x) for x in vector / size)) if size else (0.0, direction)


def _placement_in_space(placement: Placement) -> Placement:
    return Placement(tuple(map(_step_in_space, placement.steps)))


def _step_in_space(step: Shift | Turn | Rotate) -> Shift | Turn | Rotate:
    if isinstance(step, Shift):
        return Shift((*step.by, 0.0))
    if isinstance(step, Rotate):
        return Rotate((*((*row, 0.0) for row in step.matrix), (0.0, 0.0, 1.0)))
    return step


def _attached_in_space(part: Attached) -> Attached:
    (zz,) = part.inertia.tensor
    inertia = Inertia(part.inertia.mass, (*part.inertia.com, 0.0), (0.0, 0.0, 0.0, 0.0, 0.0, zz))
    return replace(part, inertia=inertia, placement=_placement_in_space(part.placement))
