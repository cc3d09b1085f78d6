"""Joint kinds as records: their coordinates, and the primitive motions they are made of.

A *primitive* is a joint whose motion columns (angular and linear velocity of the child for a unit
rate, at the child's origin, in the child's axes) are constant. That is all the algorithms know of
joints.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from typing import ClassVar, NamedTuple

from freebody.elementary import Scalar
from freebody.spatial import AnySpace, Matrix, Vector, add, sub

Column = tuple[Vector, Vector]
"""Motion column (angular, linear)."""


class JointWords(NamedTuple):
    """Words for a primitive of one coordinate."""

    joint: str
    """Adjective of the joint: a revolute joint."""
    coordinate: str
    """Noun of the coordinate: an angle."""
    effort: str
    """Noun of the motor's effort."""
    bearing: str
    """Noun of the part that carries the other forces."""
    unit: str
    effort_unit: str


class Own(NamedTuple):
    """A number that belongs to joints of one kind, such as the pitch of a screw."""

    name: str
    """Name of the number in files, and behind the joint's in `fb.parameters`."""
    unit: str
    what: str
    """Meaning of the number: the lead of a screw."""


class Solid(NamedTuple):
    """A part of a joint's symbol in space: a prism, its measures in radii of a drawing's joints."""

    radius: float
    half: float
    """Half of the solid's length."""
    sides: int = 24
    """Number of sides; many of a cylinder."""
    moves: bool = True
    """Whether it goes with the body; else it stays where the joint begins."""
    along: str = "axis"
    """Direction of the solid: "axis", or x, y or z of the frame that it stays in."""


class Primitive(ABC):
    """A joint with constant motion columns."""

    nq: ClassVar[int]
    nv: ClassVar[int]
    words: ClassVar[JointWords]
    """Words for the primitive, where it has one coordinate."""
    turns: ClassVar[bool] = False
    """Whether a motion of one coordinate turns the child about the axis."""
    slides: ClassVar[bool] = False
    """Whether a motion of one coordinate takes the child along the axis."""
    advance: Scalar = 0.0
    """Distance by which a motion of one coordinate takes the child along the axis for each unit of
    the coordinate."""

    @abstractmethod
    def pose(self, space: AnySpace, axis: Vector, q: Vector) -> tuple[Matrix, Vector]:
        """(R, p) of the child in the joint's frame at position q (nq scalars)."""

    @abstractmethod
    def columns(self, space: AnySpace, axis: Vector) -> tuple[Column, ...]:
        """The joint's nv motion columns."""

    def position_rates(self, space: AnySpace, q: Vector, rates: Vector) -> Vector:
        """q̇ of the joint (nq scalars) when it moves with `rates` (nv scalars)."""
        return rates

    def moved(self, space: AnySpace, q: Vector, v: Vector) -> Vector:
        """The position reached from q by the constant rates v in unit time."""
        return add(q, v)

    def between(self, space: AnySpace, q0: Vector, q1: Vector) -> Vector:
        """The constant rates that lead from q0 to q1 in unit time: the inverse of `moved`."""
        return sub(q1, q0)

    def dexp_inverse(self, space: AnySpace, x: Vector, v: Vector) -> Vector:
        """ẋ where the position is moved(q, x) and changes with the rates v; of the series v + ½ [x,
        v] + ¹⁄₁₂ [x, [x, v]] + … these three terms, which methods up to order 4 need (Munthe-Kaas
        1998)."""
        return v

    def bias(self, space: AnySpace, rates: Vector) -> Column:
        """The part of the child's acceleration relative to the joint's frame (the time derivative
        of its point's velocity, in the child's axes) that does not stem from the joint
        accelerations."""
        return space.zero_angular, space.zero


class JointKind(ABC):
    """A family of joints as a user names it."""

    name: ClassVar[str]
    nq: ClassVar[int]
    nv: ClassVar[int]
    position_names: ClassVar[tuple[str, ...]] = ("",)
    """Names of the entries of q, behind the joint's name; empty where there is only one."""
    velocity_names: ClassVar[tuple[str, ...]] = ("",)
    numbers: ClassVar[tuple[Own, ...]] = ()
    """Numbers of such a joint besides its axis, in the order of `Joint.numbers`."""
    quaternion: ClassVar[int | None] = None
    """Index in q at which a unit quaternion w, x, y, z begins."""
    by_angles: ClassVar[tuple[tuple[str, Primitive, Vector], ...]] = ()
    """Name, primitive and axis of joints of one coordinate that, of a kind with a quaternion, can
    stand for it where three angles are wanted."""
    angular: ClassVar[tuple[bool, ...]]
    """For each rate whether it turns (rad, N m) or slides (m, N)."""
    coordinate: ClassVar[str] = ""
    """Letter of a single coordinate in formulas, before the joint's number."""
    letter: ClassVar[str] = ""
    """Letter of the kind in planar words and DH tables."""
    axis_letter: ClassVar[str] = "z"
    """Letter of the unit vector along the axis, before the joint's number."""
    mark: ClassVar[str] = "joint"
    """Symbol in drawings of the plane, one of `figures.svg_symbols.MARKS`; "" for none."""
    solids: ClassVar[tuple[Solid, ...]] = (Solid(1.0, 1.35),)
    """Solids of the symbol in drawings of space; without any, its mark."""
    ranged: ClassVar[bool] = True
    """Whether it is expected to have a range."""
    holds: ClassVar[bool] = True
    """Whether it ties the body to one place or line; drawings show no ground under a body that it
    does not hold."""
    needs_axis: ClassVar[bool] = False
    dimensions: ClassVar[tuple[int, ...]] = (3,)
    """Spaces (2, 3) in which the kind makes sense."""

    motion: ClassVar[type[Primitive] | None] = None
    """The primitive that a kind of one coordinate is."""

    @property
    def turns(self) -> bool:
        """Whether all that a joint of this kind does is turn about one axis."""
        return self.motion is not None and self.motion.turns and not self.motion.slides

    @property
    def slides(self) -> bool:
        """Whether all that a joint of this kind does is slide along one axis."""
        return self.motion is not None and self.motion.slides and not self.motion.turns

    @property
    def composed(self) -> bool:
        """Whether a joint of this kind is several joints of one coordinate each, without mass
        between."""
        return self.nv > 1 and self.quaternion is None

    def frees(self, dim: int) -> bool:
        """Whether a joint of this kind leaves a body all its motion in a space of so many
        dimensions."""
        return self.nv == (6 if dim == 3 else 3)

    def axis_size(self, dim: int) -> int:
        """The number of entries of the joint's axis, in space or in the plane."""
        return dim

    @abstractmethod
    def primitives(
        self, space: AnySpace, axis: Vector, numbers: Vector
    ) -> tuple[tuple[Primitive, Vector], ...]:
        """The chain of primitives, each with its axis, that stands for a joint of this kind with
        these `numbers`; their coordinates in order."""

    def axis_in_space(self, axis: tuple[float, ...]) -> tuple[float, ...]:
        """The axis of the planar model's joint in its twin in space, whose xy-plane the plane
        is."""
        return ()
