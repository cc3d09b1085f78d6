"""Two unknown joints of a planar loop in closed form: triangles and circles, each with its two solutions.

A loop is cut at its pin. Seen from a joint in it, everything on the way to one end of the cut turns, or slides,
against everything on the way to the other; what lies between two unknown joints is rigid, whatever its links. So two
unknown pins and the cut make a triangle with known sides: R R R. Vectors are complex numbers, arrays (N, K) of samples
and solutions.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import ancestors, frame_pose, joint_poses, world_poses
from freebody.arrays import Array
from freebody.lazy import cached_property
from freebody.model.joints.revolute import Turning
from freebody.model.tree import Tree
from freebody.spatial import times
from freebody.trees.triangles import by_triangle

Complex = NDArray[np.complexfloating]
Crossing = tuple[int, float]
"""A joint on the way from the first end to the second, and the sign with which it moves what comes behind."""
_COINCIDE = 1e-6  # sides of a triangle, relative to its perimeter, below which two of its pins are one
_LOOSE = 1e-9  # how far (relative) a square may be negative and still be taken as 0: a straight dyad


class Coincident(Exception):
    """Pins of a dyad lie on one another: any angle does."""


@dataclass(frozen=True)
class Chain:
    """The joints between two frames that meet, or stay `distance` apart; the first may be a target, None."""

    name: str
    ends: tuple[str | None, str]
    path: tuple[Crossing, ...]
    distance: float = 0.0

    @property
    def frames(self) -> tuple[str, ...]:
        """Its ends on the robot."""
        return tuple(end for end in self.ends if end is not None)


def chain(tree: Tree, name: str, ends: tuple[str | None, str], distance: float = 0.0) -> Chain:
    """The chain between two frames of a tree."""
    first, second = (ancestors(tree, tree.frames[frame][0]) if frame is not None else [] for frame in ends)
    up = [(i, -1.0) for i in first if i not in second]
    down = [(i, 1.0) for i in reversed(second) if i not in first]
    return Chain(name, ends, (*up, *down), distance)


@dataclass(frozen=True, eq=False)
class Posture:
    """Positions q (N, K, nq) and where everything is; target: points (N, 1), angle: directions (N, 1)."""

    tree: Tree
    q: Array
    target: Complex | None = None
    angle: Array | None = None

    @cached_property
    def world(self) -> list:
        """Poses of all bodies."""
        return world_poses(self.tree, joint_poses(self.tree, tuple(np.moveaxis(self.q, -1, 0))))

    def point(self, frame: str | None) -> Complex:
        """Origin of a frame, or the target."""
        if frame is None:
            assert self.target is not None
            return np.broadcast_to(self.target, self.q.shape[:-1])
        return self._complex(frame_pose(self.tree, self.world, frame)[1])

    def heading(self, frame: str) -> Array:
        """Angle of a frame's x axis."""
        R, _ = frame_pose(self.tree, self.world, frame)
        return np.asarray(np.angle(self._complex((R[0][0], R[1][0]))), dtype=float)

    def pivot(self, body: int) -> Complex:
        """Where a joint is."""
        return self._complex(self.world[body][1])

    def slide(self, crossing: Crossing) -> Complex:
        """Unit vector along which a sliding joint moves what comes behind."""
        body, sign = crossing
        return sign * self._complex(times(self.world[body][0], self.tree.bodies[body].axis))

    def turned(self, *turns: tuple[Crossing, Array]) -> Array:
        """q with joints turned by angles of what comes behind them."""
        q = np.array(self.q)
        for (body, sign), angle in turns:
            (w,), _ = self.tree.bodies[body].columns[0]
            q[..., self.tree.bodies[body].coordinates.q[0]] += sign * w * angle
        return q

    def slid(self, crossing: Crossing, way: Array) -> Array:
        """q with a joint slid by a way of what comes behind it, along its own axis."""
        q = np.array(self.q)
        q[..., self.tree.bodies[crossing[0]].coordinates.q[0]] += way
        return q

    def moved(self, q: Array) -> Posture:
        """The same target with other positions."""
        return Posture(self.tree, q, self.target, self.angle)

    def _complex(self, p: tuple) -> Complex:
        return np.broadcast_to(np.asarray(p[0] + 1j * np.asarray(p[1])), self.q.shape[:-1])


Reach = tuple[str, str, Array, Array, Array]
"""Two points, how far apart they are (N, K), and how far apart what joins them can hold them: from, to."""


class Step(ABC):
    """Unknown joints of one chain found from the others."""

    @property
    @abstractmethod
    def crossings(self) -> tuple[Crossing, ...]:
        """The joints that it finds."""

    @property
    @abstractmethod
    def frames(self) -> tuple[str, ...]:
        """The frames that it brings together."""

    @abstractmethod
    def solve(self, at: Posture) -> list[Array]:
        """q (N, K, nq) of each solution, NaN where there is none."""

    def label(self, at: Posture) -> Array | None:
        """Which solution a posture is: a positive or a negative number (N, K)."""
        del at
        return None

    words: tuple[str, str] = ("", "")
    """Names of the positive and the negative solution."""

    def reach(self, at: Posture) -> Reach | None:
        """What keeps it from closing."""
        del at
        return None


@dataclass(frozen=True)
class Triangle(Step):
    """Two pins and the cut: R R R."""

    chain: Chain
    first: Crossing
    second: Crossing
    names: tuple[str, str, str]
    """Of the pins: first, second, the cut."""

    @property
    def frames(self) -> tuple[str, ...]:
        return self.chain.frames

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return self.first, self.second

    def _pins(self, at: Posture) -> tuple[Complex, Complex, Complex, Complex]:
        """The cut's first end, both pins, the cut's second end."""
        ends = (at.point(end) for end in self.chain.ends)
        start, end = ends
        return start, at.pivot(self.first[0]), at.pivot(self.second[0]), end

    def _sides(self, at: Posture) -> tuple[Array, Array, Array]:
        start, p, r, end = self._pins(at)
        return np.abs(start - p), np.abs(r - p), np.abs(end - r)

    def solve(self, at: Posture) -> list[Array]:
        start, p, r, end = self._pins(at)
        a, b, c = self._sides(at)
        _refuse_coincident(a, b, c)
        here = np.angle((r - p) / (start - p)), np.angle((end - r) / (p - r))
        wanted = _corner(c, a, b), _corner(a, b, c)
        return [
            at.turned((self.first, s * wanted[0] - here[0]), (self.second, s * wanted[1] - here[1]))
            for s in (1.0, -1.0)
        ]

    @property
    def _elbow(self) -> int:
        """Which pin moves: 1 and 2 the joints, 0 the cut; the other two are where the rest of the robot holds them."""
        signs = self.first[1], self.second[1]
        return 2 if signs == (1.0, 1.0) else 1 if signs == (-1.0, -1.0) else 0

    @property
    def words(self) -> tuple[str, str]:
        name = (self.names[2], self.names[0], self.names[1])[self._elbow]
        return f"{name} left", f"{name} right"

    def label(self, at: Posture) -> Array:
        start, p, r, _ = self._pins(at)
        base, other, elbow = {2: (p, start, r), 1: (r, start, p), 0: (p, r, start)}[self._elbow]
        return _side(base, other, elbow)

    def reach(self, at: Posture) -> Reach:
        a, b, c = self._sides(at)
        one, two, cut = self.names
        base, legs, ends = {
            2: (a, (b, c), (one, cut)),
            1: (c, (a, b), (two, cut)),
            0: (b, (a, c), (one, two)),
        }[self._elbow]
        return *ends, base, np.abs(legs[0] - legs[1]), legs[0] + legs[1]


@dataclass(frozen=True)
class TurnAndSlide(Step):
    """A pin and a slide: R P."""

    chain: Chain
    turn: Crossing
    slide: Crossing
    name: str

    @property
    def frames(self) -> tuple[str, ...]:
        return self.chain.frames

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return self.turn, self.slide

    @property
    def words(self) -> tuple[str, str]:
        return f"{self.name} forward", f"{self.name} backward"

    def _parts(self, at: Posture) -> tuple[Complex, Complex, Complex, bool]:
        """From the pin: what is rigid, what slides, along which way; whether the slide lies behind the pin."""
        o = at.pivot(self.turn[0])
        near, far = (at.point(end) - o for end in self.chain.ends)
        behind = self.chain.path.index(self.slide) > self.chain.path.index(self.turn)
        e = at.slide(self.slide)
        return (near, far, e, behind) if behind else (far, near, -e, behind)

    def solve(self, at: Posture) -> list[Array]:
        rigid, sliding, e, behind = self._parts(at)
        along, across = _along(e, sliding), _across(e, sliding)
        _refuse_coincident(np.abs(rigid))
        half = _root(np.abs(rigid), across)
        found = []
        for s in (1.0, -1.0):
            way = s * half - along
            arrived = sliding + way * e
            turn = np.angle(rigid / arrived)
            slid = at.moved(at.slid(self.slide, way))
            found.append(slid.turned((self.turn, turn if behind else -turn)))
        return found

    def label(self, at: Posture) -> Array:
        _, sliding, e, _ = self._parts(at)
        return _along(e, sliding) / np.maximum(np.abs(sliding), 1e-300)


@dataclass(frozen=True)
class TwoSlides(Step):
    """P P: one solution."""

    chain: Chain
    first: Crossing
    second: Crossing

    @property
    def frames(self) -> tuple[str, ...]:
        return self.chain.frames

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return self.first, self.second

    def solve(self, at: Posture) -> list[Array]:
        start, end = (at.point(frame) for frame in self.chain.ends)
        return [_shifted(at, self.first, self.second, start - end)]


@dataclass(frozen=True)
class Swing(Step):
    """A pin in a chain whose ends stay a distance apart."""

    chain: Chain
    turn: Crossing
    names: tuple[str, str]
    """The pin and the end that turns about it."""

    @property
    def frames(self) -> tuple[str, ...]:
        return self.chain.frames

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return (self.turn,)

    @property
    def words(self) -> tuple[str, str]:
        return f"{self.names[1]} left", f"{self.names[1]} right"

    def solve(self, at: Posture) -> list[Array]:
        o = at.pivot(self.turn[0])
        near, far = (at.point(end) - o for end in self.chain.ends)
        a, b = np.abs(near), np.abs(far)
        _refuse_coincident(a, b)
        here, wanted = np.angle(far / near), _corner(np.full(a.shape, self.chain.distance), a, b)
        return [at.turned((self.turn, s * wanted - here)) for s in (1.0, -1.0)]

    def label(self, at: Posture) -> Array:
        o = at.pivot(self.turn[0])
        start, end = (at.point(frame) for frame in self.chain.ends)
        return _side(o, start, end) if self.turn[1] > 0 else _side(o, end, start)

    def reach(self, at: Posture) -> Reach:
        o = at.pivot(self.turn[0])
        near, far = (np.abs(at.point(end) - o) for end in self.chain.ends)
        base, leg = (near, far) if self.turn[1] > 0 else (far, near)
        other = self.chain.ends[0 if self.turn[1] > 0 else 1] or "the target"
        d = self.chain.distance
        return self.names[0], other, base, np.abs(leg - d), leg + d


@dataclass(frozen=True)
class Stretch(Step):
    """A slide in a chain whose ends stay a distance apart."""

    chain: Chain
    slide: Crossing
    name: str

    @property
    def frames(self) -> tuple[str, ...]:
        return self.chain.frames

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return (self.slide,)

    @property
    def words(self) -> tuple[str, str]:
        return f"{self.name} forward", f"{self.name} backward"

    def _gap(self, at: Posture) -> tuple[Array, Array]:
        """From the first end to the second, along the slide and across."""
        start, end = (at.point(frame) for frame in self.chain.ends)
        e = at.slide(self.slide)
        return _along(e, end - start), _across(e, end - start)

    def solve(self, at: Posture) -> list[Array]:
        along, across = self._gap(at)
        half = _root(np.full(along.shape, self.chain.distance), across)
        return [at.slid(self.slide, s * half - along) for s in (1.0, -1.0)]

    def label(self, at: Posture) -> Array:
        return self._gap(at)[0] / self.chain.distance


@dataclass(frozen=True)
class TwoCircles(Step):
    """Two slides that carry the ends of two rods: where two circles meet."""

    chains: tuple[Chain, Chain]
    slides: tuple[Crossing, Crossing]
    signs: tuple[float, float]
    """With which the slides move the second end of each chain against its first."""
    name: str

    @property
    def frames(self) -> tuple[str, ...]:
        return (*self.chains[0].frames, *self.chains[1].frames)

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return self.slides

    @property
    def words(self) -> tuple[str, str]:
        return f"{self.name} left", f"{self.name} right"

    def _gaps(self, at: Posture) -> list[Complex]:
        """How the carried end lies from the centre of each circle."""
        return [
            sign * (at.point(c.ends[1]) - at.point(c.ends[0]))
            for c, sign in zip(self.chains, self.signs, strict=True)
        ]

    def solve(self, at: Posture) -> list[Array]:
        one, two = self._gaps(at)
        between = one - two  # from the first centre to the second
        r, t = (np.full(one.shape, c.distance) for c in self.chains)
        d = np.abs(between)
        _refuse_coincident(d)
        corner = _corner(t, r, d)
        return [
            _shifted(at, *self.slides, between / d * r * np.exp(1j * s * corner) - one) for s in (1.0, -1.0)
        ]

    def label(self, at: Posture) -> Array:
        one, two = self._gaps(at)
        return _side(np.zeros_like(one), one - two, one)

    def reach(self, at: Posture) -> Reach:
        one, two = self._gaps(at)
        r, t = (np.full(one.shape, c.distance) for c in self.chains)
        names = [
            c.ends[0] if sign > 0 else c.ends[1] for c, sign in zip(self.chains, self.signs, strict=True)
        ]
        return str(names[0]), str(names[1]), np.abs(one - two), np.abs(r - t), r + t


@dataclass(frozen=True)
class Heading(Step):
    """The pin that turns the tip to the direction wanted."""

    frame: str
    turn: Crossing

    @property
    def frames(self) -> tuple[str, ...]:
        return (self.frame,)

    @property
    def crossings(self) -> tuple[Crossing, ...]:
        return (self.turn,)

    def solve(self, at: Posture) -> list[Array]:
        assert at.angle is not None
        return [at.turned((self.turn, at.angle - at.heading(self.frame)))]


# ---------------------------------------------------------------- geometry
def _along(e: Complex, v: Complex) -> Array:
    """e · v."""
    return np.asarray(np.real(np.conj(e) * v), dtype=float)


def _across(e: Complex, v: Complex) -> Array:
    """e × v."""
    return np.asarray(np.imag(np.conj(e) * v), dtype=float)


def _corner(opposite: Array, a: Array, b: Array) -> Array:
    """The angle of a triangle between sides a and b, by half-angles; NaN where the sides make none."""
    d = a - b
    above, below = (opposite - d) * (opposite + d), (a + b - opposite) * (a + b + opposite)
    return by_triangle(above, below, (a + b) ** 2 + opposite**2)


def _root(a: Array, b: Array) -> Array:
    """√(a² - b²); 0 where it is short of that by rounding, else NaN."""
    square = (a - b) * (a + b)
    with np.errstate(invalid="ignore"):
        return np.sqrt(np.where((square < 0) & (square > -_LOOSE * (a * a + b * b)), 0.0, square))


def _side(base: Complex, other: Complex, elbow: Complex) -> Array:
    """The sine of the angle from base-other to base-elbow: positive where the elbow lies on the left."""
    one, two = other - base, elbow - base
    return _across(one, two) / np.maximum(np.abs(one) * np.abs(two), 1e-300)


def _shifted(at: Posture, first: Crossing, second: Crossing, way: Complex) -> Array:
    """q with two joints slid so that together they move what comes behind by `way`."""
    e, g = at.slide(first), at.slide(second)
    det = _across(e, g)
    with np.errstate(invalid="ignore", divide="ignore"):
        det = np.where(np.abs(det) > 1e-12, det, np.nan)
        x, y = _across(way, g) / det, _across(e, way) / det
    return at.moved(at.slid(first, x)).slid(second, y)


def _refuse_coincident(*sides: Array) -> None:
    whole = np.add.reduce(sides)
    for side in sides:
        if np.any(side <= _COINCIDE * np.maximum(whole, 1e-300)):
            raise Coincident


def is_turning(tree: Tree, crossing: Crossing) -> bool:
    """Whether a joint on the way turns."""
    return isinstance(tree.bodies[crossing[0]].primitive, Turning)


def coordinates(tree: Tree, crossings: Iterable[Crossing]) -> set[int]:
    """Which coordinates joints on the way are."""
    return {tree.bodies[i].coordinates.q[0] for i, _ in crossings}
