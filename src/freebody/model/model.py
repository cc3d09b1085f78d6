"""`Model`: a robot, frozen. Bodies are what moves; links that are fixed to one another are one
body."""

from __future__ import annotations

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from dataclasses import replace as replaced
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, MissingValueError, ModelError, shown
from freebody.lazy import cached_property
from freebody.model import changes as changed
from freebody.model import (
    edits,
    flexible_joints,
    inertial_parameters,
    joint_table,
    locked_joints,
    named_numbers,
)
from freebody.model.bodies import Body, Frame, JointLimits
from freebody.model.description import Loop, Notice
from freebody.model.doubt_rules.aspects import ALL
from freebody.model.doubts import (
    ESTIMATED,
    Doubt,
    doubts_on,
    doubts_used,
    named,
    read_doubts,
)
from freebody.model.families import MemberError, one_family, taken
from freebody.model.gravity import gravity_of
from freebody.model.inertia import Inertia, decimal_sum
from freebody.model.kept_facts import Geometry, geometry_of
from freebody.model.loops import checked_tolerance
from freebody.model.named_parts import NamedParts
from freebody.model.parameter_formulas import ParameterFormula
from freebody.model.parameters import Quantity, each_parameter
from freebody.model.quantity_reader import VALUES
from freebody.model.shapes import Shape
from freebody.model.structure import Structure, numbers_of, structure_of
from freebody.model.struts import Strut
from freebody.model.tip import requested_tip, with_tip
from freebody.model.tree import Attached, Tree, lower
from freebody.outputs.display import Tabled, TextTable, counted


@dataclass(frozen=True, eq=False, repr=False)
class Model(NamedParts, Tabled, ByValue):
    """A robot: bodies in the file's order of their joints, named frames, gravity. Made by `load`,
    `planar`, `dh`."""

    name: str
    dim: int
    bodies: tuple[Body, ...]
    frames: tuple[Frame, ...]
    gravity_size: Quantity
    gravity_direction: tuple[Any, ...]
    base_inertias: tuple[Attached, ...] = field(default_factory=tuple)
    loops: tuple[Loop, ...] = ()
    formulas: tuple[ParameterFormula, ...] = ()
    """Formulas of parameters that follow from others, each behind those that it names."""
    home: tuple[tuple[str, float], ...] = ()
    """(position name, value): where closing the loops starts from; others are neutral."""
    tip: str | None = None
    source: str = ""
    about: str = ""
    """The robot in words, and what is worth seeing in it."""
    notices: tuple[Notice, ...] = ()
    loop_tolerance: tuple[float, float] | None = None
    """(m, rad): by how much rounded numbers may keep loops from closing; None: the default, 1 mm or
    a thousandth of the loop's size, and 1 mrad."""
    struts: tuple[Strut, ...] = ()
    """Springs and dampers between two points."""
    shapes: tuple[tuple[str, Shape], ...] = ()
    """(frame, shape in it) of the links of its file, for drawings: they weigh nothing."""
    _aside = (
        "name",
        "source",
        "about",
        "notices",
        "shapes",
    )  # a file's name, what somebody called the robot, how it looks

    # ------------------------------------------------------------ numbers
    @property
    def parameters(self) -> dict[str, Any]:
        """Names and values of the parameters."""
        return {parameter.name: parameter.value for parameter in each_parameter(self)}

    @cached_property
    def missing(self) -> tuple[str, ...]:
        """Names of the parameters without value."""
        return tuple(sorted({name for p in each_parameter(self) for name in p.missing}))

    def require_values(self, what: str) -> None:
        """Refuse a model with parameters that have no value."""
        if self.missing:
            raise MissingValueError(f"{what} of {self.name!r}", self.missing)

    def require_tree(self, function: str, instead: str = "") -> None:
        """Refuse a closed chain, in the name of a function."""
        if self.loops:
            other = f"use {instead}, or " if instead else ""
            raise FreebodyError(
                f"{function}: {self.name!r} is a closed chain, for which this is not available; "
                f"{other}take model.opened, the tree that is left when its loops are cut."
            )

    @cached_property
    def family(self) -> tuple[int, ...]:
        """The shape of the family of robots that the model is, where some of its numbers are
        arrays; () for one robot.

        Results of numeric functions have this shape, broadcast with that of the samples, whatever
        numbers differ. Exceptions are those that use no number of a model: neutral, random_state,
        integrate, difference.
        """
        return named_numbers.family(self)

    def __getitem__(self, index: Any) -> Model:
        """A member of a family, or by slices some of them; indices are those of an array of its
        shape."""
        if not self.family:
            raise MemberError(
                f"{self.name!r} is one robot, not a family: it has no member {shown(index)}."
            )
        try:
            picked = np.empty(self.family)[index].size
        except (IndexError, ValueError, TypeError):
            picked = 0
        if not picked:
            raise MemberError(
                f"{self.name!r}: {shown(index)} selects no member of a family of shape "
                f"{self.family}."
            )
        return taken(self, self.family, index)

    # a family is no sequence that runs out: members are asked by index
    __iter__ = None

    @cached_property
    def tree(self) -> Tree:
        """The model in numbers, as the algorithms take it."""
        try:
            return lower(self, VALUES)
        except ModelError:
            self.require_values("the numbers")
            raise

    @cached_property
    def structure(self) -> Structure:
        """The structure that remains of the model without its numbers, with what is compiled for
        it: shared by all like it."""
        try:
            return structure_of(self)
        except ModelError:
            self.require_values("the numbers")
            raise

    @cached_property
    def numbers(self) -> Array:
        """The model's numbers (k,), as the kernels of its structure take them; of a family (...,
        k)."""
        return numbers_of(self)

    @cached_property
    def geometry(self) -> Geometry:
        """The model's structure and lengths, with what follows from these alone: shared by all
        models that have the same."""
        return geometry_of(self)

    @cached_property
    def opened(self) -> Model:
        """The tree that is left when all loops are cut; the model itself where there are none."""
        return self.without("loops") if self.loops else self

    @cached_property
    def compiled(self) -> dict[Any, Any]:
        """Code compiled for this model, nothing else; filled and read by the numeric functions."""
        return {}

    @cached_property
    def facts(self) -> dict[str, Any]:
        """Facts that follow from the model alone and have been found before; see
        `model.kept_facts.fact`."""
        return {}

    @cached_property
    def mass(self) -> Any:
        """Total mass (kg) of all links, those fixed to the base included; of a family an array of
        its shape."""
        missing = [
            name
            for a in self._attached
            for p in each_parameter(a.inertia.mass)
            for name in p.missing
        ]
        if missing:
            raise MissingValueError(f"the mass of {self.name!r}", missing)
        masses = [VALUES.quantity(a.inertia.mass) for a in self._attached]
        if self.family:
            return np.broadcast_to(sum(masses), self.family).copy()
        return decimal_sum(masses)

    @property
    def is_estimated(self) -> bool:
        """Whether inertias are estimates (such as `load` makes, estimate_inertia=); how stands in
        `doubts`."""
        return any(doubt.kind == ESTIMATED for doubt in read_doubts(self))

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """The doubts on the model as it is now, each with its `kind` and `text`; `of` says what it
        touches, and whether it bars a verdict."""
        return doubts_on(self, *ALL)

    @property
    def gravity(self) -> Array:
        """The gravity field (dim,) in world axes, m/s²; of a family (*family, dim)."""
        missing = [name for p in each_parameter(self.gravity_size) for name in p.missing]
        if missing:
            raise MissingValueError(f"the gravity of {self.name!r}", missing)
        size = VALUES.quantity(self.gravity_size)
        entries = [size * VALUES.quantity(x) for x in self.gravity_direction]
        return np.stack([np.broadcast_to(x, self.family) for x in entries], axis=-1)

    @property
    def limits(self) -> JointLimits:
        """Limits of the coordinates, arrays (nv,), of a family (*family, nv), as written; infinite
        where none."""
        rows: list[tuple[Any, ...]] = []
        for body in self.bodies:
            if body.joint.mimic is None:
                limits = body.joint.limits
                row = (limits.lower, limits.upper, limits.velocity, limits.effort)
                rows += [tuple(map(VALUES.quantity, row))] * body.kind.nv
        if not rows:
            return JointLimits(*(np.zeros((*self.family, 0)) for _ in range(4)))
        columns = zip(*rows, strict=True)
        return JointLimits(
            *(
                np.stack([np.broadcast_to(np.float64(x), self.family) for x in column], axis=-1)
                for column in columns
            )
        )

    def _key(self) -> tuple[Any, ...]:
        return super(Model, changed.without_idle_payload(self))._key()

    @property
    def _attached(self) -> tuple[Attached, ...]:
        """The inertias of all links, the base's first."""
        return (*self.base_inertias, *(part for body in self.bodies for part in body.inertias))

    # ------------------------------------------------------------ changed copies
    def bind(self, values: Mapping[Any, Any] | None = None, /, **symbols: Any) -> Model:
        """The model with other numbers: model.bind(l1=0.4), model.bind({"forearm.mass": 3.0}).

        Parameters
        ----------
        values, **symbols
            Numbers by the names that `fb.parameters` lists; a name that holds a dot itself is given
            as a tuple of its parts, ("a.b", "mass"). link.mass keeps centre and inertia, link.scale
            scales mass and inertia together, a mass that is given beside it too. An array gives
            each member of a family its own (`family`); arrays broadcast together. A text is a
            formula, bind(lc1="l1/2"), bind(lc="l/2") of every link: such a parameter follows from
            the others from then on, also in derivations, until it is given another text ("0.3", or
            "lc1" to keep its value).

        Raises
        ------
        UnknownNameError
            A name that the model does not have.
        ModelError
            What no rigid body is, naming the member, or a number in the place of what a formula
            gives.
        """
        return edits.bound(self, {**(values or {}), **symbols})

    def replace(
        self,
        *,
        name: str | None = None,
        gravity: Any = None,
        tip: str | None = None,
        actuated: Sequence[str] | None = None,
        loop_tolerance: tuple[float, float] | None = None,
    ) -> Model:
        """The model with another name, tip, gravity, choice of driven joints, or tolerance of its
        loops.

        Parameters
        ----------
        name
            The model's name.
        gravity
            A size in m/s² (0 for none), a name, or a vector (dim,) in world axes; vectors (...,
            dim) are those of a family (sizes of a family: bind({"gravity": sizes})).
        tip
            The frame that `frame=None` means from then on.
        actuated
            Names of the joints that are driven; all other joints are passive.
        loop_tolerance
            (m, rad), see `with_loop`.
        """
        changes: dict[str, object] = {}
        if name is not None:
            changes["name"] = name
        if gravity is not None:
            changes["gravity_size"], changes["gravity_direction"] = gravity_of(
                gravity, self.dim, self.gravity_direction
            )
        if actuated is not None:
            changes["bodies"] = changed.actuated(self, actuated)
        if loop_tolerance is not None:
            changes["loop_tolerance"] = checked_tolerance(loop_tolerance, "Model.replace")
        result = dataclasses.replace(self, **changes)
        if tip is not None:
            result = with_tip(result, requested_tip(tip))
        if gravity is not None:
            result = changed.with_symbols_known(result, result.gravity_size)
        return one_family(result, self, *changes.values())

    def with_drive(
        self,
        joint: str,
        **numbers: Any,
    ) -> Model:
        """The model with another rotor, gear, friction or spring in a joint of one coordinate.

        What is not given stays. Numbers, names, or arrays with a number for each member of a
        family; units are those of a revolute joint, and in brackets of a prismatic one.

        Parameters
        ----------
        joint
            The joint's name.
        numbers
            By the names of `fb.Drive`: of its rotor the inertia before the gear, kg m² (kg), and
            gear, the ratio of motor speed to joint speed; of a spring stiffness, N m/rad (N/m), and
            rest, rad (m); and those of friction, such as viscous, N m s/rad (N s/m).
        """
        return edits.driven(self, joint, {k: x for k, x in numbers.items() if x is not None})

    def with_flexible_joint(self, joint: str, *, stiffness: Any, damping: Any = 0.0) -> Model:
        """The model with a shaft that twists between the rotor of a joint and its link.

        The joint's coordinate is then the angle of its rotor, seen behind the gear, where motor,
        friction and losses act; a passive joint "<joint>_twist" behind it, on a link
        "<joint>_rotor" without mass, has the twist as its coordinate. The link's angle is their
        sum. Numbers, names, or arrays over the members of a family.

        Parameters
        ----------
        joint
            Name of a joint of one coordinate, with a rotor that has inertia.
        stiffness
            Of the shaft, seen at the joint: N m/rad (N/m of a prismatic joint).
        damping
            N m s/rad (N s/m), of the twist.

        Raises
        ------
        ModelError
            Nothing turns before the shaft twists, a spring acts on the link's angle, or another
            joint follows.
        UnknownNameError
        """
        given = {"stiffness": stiffness, "damping": damping}
        return flexible_joints.with_flexible_joint(self, joint, given)

    def with_locked(self, positions: Mapping[str, float]) -> Model:
        """The model in which some joints are locked: with_locked({"finger": 0.02}).

        What a locked joint carries is a part of the body that it hangs on, and its coordinate is
        gone from q and q̇; joints that follow it are locked with it. Its rotor, friction and spring
        go too, since it does not move; frames, masses and their names stay.

        Parameters
        ----------
        positions
            The position of each joint that is locked, rad or m, by the name of a joint of one
            coordinate, or by a pattern of such names, "right_*".

        Raises
        ------
        ModelError
            A position beyond the joint's range, a joint that follows another, two patterns that
            disagree, or a loop or strut that would hold two frames of one body.
        UnknownNameError
        """
        return locked_joints.with_locked(self, positions)

    def with_inertial_parameters(self, pi: Any) -> Model:
        """The model with other inertial parameters π (..., k), in the order and units of
        `fb.inertial_parameters`.

        An array, or what carries their names (that function's dict, a pandas Series); arrays with
        axes in front make a family. A body's links and the loads on it become one, in its name,
        since π knows no parts of a body; gears and what is fixed to the base stay. Raises
        ModelError for a body that no rigid body is, by name.
        """
        return inertial_parameters.with_inertial_parameters(self, pi)

    def without(self, *features: str) -> Model:
        """The model without "friction", "rotors", "springs" (those of joints, and cogging torques),
        "struts", "shafts" or "loops" (the tree that is left when they are cut).

        A strut and the shaft of a flexible joint keep their stiffness and damping, or go as a
        whole: without "shafts" the rotors are fixed to their links, and the twists are no
        coordinates.
        """
        return changed.without(self, features)

    def with_payload(
        self,
        mass: Any = None,
        *,
        com: Any = None,
        box: Sequence[float] | None = None,
        cylinder: Sequence[float] | None = None,
        inertia: Any = None,
        frame: str | None = None,
        name: str = "payload",
    ) -> Model:
        """The model carrying a rigid load in `frame`.

        Its numbers are then called payload.mass, payload.com.x, payload.inertia.xx, …. Arrays of
        masses, and of centres (..., dim), give each member of a family its own.

        Parameters
        ----------
        mass
            kg; or an Inertia in the frame's axes, which is the whole load.
        com
            (dim,) m, where the load's centre of mass is in the frame; default: the origin, or the
            Inertia's own.
        box, cylinder, inertia
            The load's shape, in the frame's axes: box, the sides (a, b, c) m (in the plane (a, b));
            cylinder, the radius and the height along z (r, h) m (in the plane a disc of radius r),
            both filled evenly; or inertia, kg m² about the centre of mass: six entries ixx, ixy,
            ixz, iyy, iyz, izz, (3, 3), or in the plane a number. Without a shape the load is a
            point, which has no inertia.
        frame
            Default: the tip.
        name
            The load's name, which its numbers begin with.

        Raises
        ------
        ModelError
            A load that no rigid body is.
        """
        load = changed.load(mass, com, box, cylinder, inertia, self.dim)
        return edits.loaded(self, load, frame, name)

    def with_frame(
        self,
        name: str,
        position: Sequence[float] | None = None,
        rotation: Sequence[Sequence[float]] | Array | None = None,
        *,
        frame: str | None = None,
    ) -> Model:
        """The model with one frame more, at `position` (m) and `rotation` (matrix) in `frame`
        (default: the tip)."""
        return changed.with_frame(self, name, position, rotation, frame, "with_frame")

    def with_tool(
        self,
        name: str,
        position: Sequence[float] | None = None,
        rotation: Sequence[Sequence[float]] | Array | None = None,
        *,
        inertia: Inertia | None = None,
        frame: str | None = None,
    ) -> Model:
        """The model with a frame more, as `with_frame`, which is the tip; `inertia` rides in it."""
        model = changed.with_frame(self, name, position, rotation, frame, "with_tool")
        model = with_tip(model, requested_tip(name))
        return model if inertia is None else model.with_payload(inertia, frame=name, name=name)

    def with_loop(
        self,
        name: str,
        kind: str,
        frames: tuple[str, str],
        *,
        axis: Sequence[float] = (),
        distance: Quantity | str | None = None,
        loop_tolerance: tuple[float, float] | None = None,
    ) -> Model:
        """The model with two frames, on different bodies, held together: a closed chain.

        Parameters
        ----------
        name
            The loop's name.
        kind
            "revolute" or "prismatic" (about, along `axis`; no axis for revolute in the plane),
            "universal" (space; about x of the first frame and y of the second), "spherical"
            (space), "point" (plane), "fixed", or "distance" (the origins stay `distance` m apart).
        frames
            Names of the two frames.
        axis
            (dim,), given in the axes of both frames.
        distance
            m, a number or a name, of a loop of this kind.
        loop_tolerance
            (m, rad), of all loops of the model: by how much rounded numbers may keep them from
            closing. Equations that hold within it wherever the mechanism goes are redundant, and
            `mobility` names them. Default: 1 mm or a thousandth of the loop's size, the smaller,
            and 1 mrad; (0, 0) takes the numbers at their word.

        Raises
        ------
        ModelError, UnknownNameError
        """
        along = tuple(np.atleast_1d(axis).tolist())
        given: Any = distance  # a name becomes a parameter where the loop is checked
        looped = changed.with_loop(self, Loop(name, kind, frames, along, given))
        return looped if loop_tolerance is None else looped.replace(loop_tolerance=loop_tolerance)

    def with_strut(
        self,
        name: str,
        frames: tuple[str, str],
        *,
        stiffness: Any = None,
        rest: Any = 0.0,
        damping: Any = 0.0,
        preload: Any = 0.0,
    ) -> Model:
        """The model with a strut more, a spring and damper between two points, such as a gas
        spring.

        It pulls the frames' origins together with preload + stiffness (L - rest) + damping L̇ (N),
        L being their distance; below 0 it pushes. Numbers, names, or arrays with a number for each
        member of a family.

        Parameters
        ----------
        name
            The strut's name; its numbers are then called name.stiffness, name.rest, ….
        frames
            Names of the two frames, on different bodies or one on the base; `with_frame` makes
            frames at points.
        stiffness, rest
            N/m, and the length (m) without spring force.
        damping
            N s/m.
        preload
            N, the force at the rest length: above 0 it pulls, below 0 it pushes as a gas spring
            does.

        Raises
        ------
        ModelError, UnknownNameError
        """
        numbers = {"stiffness": stiffness, "rest": rest, "damping": damping, "preload": preload}
        return changed.with_strut(self, name, frames, numbers)

    def to_space(self) -> Model:
        """The twin in space of a planar model: its plane is xy, z points to the reader."""
        return self if self.dim == 3 else changed.in_space(self)

    def _title(self) -> str:
        loops = f", {counted(len(self.loops), 'loop')}" if self.loops else ""
        sizes = (
            f"{counted(len(self.bodies), 'body')}, nq = {self.nq}, nv = {self.nv}, dim {self.dim}"
        )
        members = f"; a family of shape {self.family}" if self.family else ""
        return f"Model {self.name!r}: {sizes}{loops}{members}{named(doubts_used(self, *ALL))}"

    def _table(self) -> TextTable:
        loops = [f"loop {x.name}: {x.kind}, {x.frames[0]} and {x.frames[1]}" for x in self.loops]
        struts = [f"strut {x.name}: {x.frames[0]} and {x.frames[1]}" for x in self.struts]
        return replaced(joint_table.table(self), notes=[*loops, *struts])


edits.make_lazy(Model)
