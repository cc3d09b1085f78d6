"""Motion of a free body, such as a quadrotor, under the force and moment on it, or under thrusts
(6.1, 6.2).

Independent are the orientation, v and ω in the axes of the body, and the force f and moment n of
all that acts besides the weight, or the thrusts that make them up.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import sub
from freebody_textbook.check.algebra.finite_field import Point
from freebody_textbook.check.algebra.quotients import Value, negative, over, pair, plus, put, times
from freebody_textbook.check.asked.right_equations import FORCES, RightEquations
from freebody_textbook.closed_chains.linear import ratio, solved
from freebody_textbook.methods.free_body_steps import FreeBody, thrusts_of
from freebody_textbook.methods.setting import Setting

_ANGLES = slice(3, 6)


@dataclass(frozen=True)
class FreeBelief:
    """A wrong belief about the equations of a free body: changed factors and terms; the defaults
    are correct."""

    gyroscopic: int = 1
    """Factor of ω × I ω in Euler's equation."""
    transport: int = 1
    """Factor of ω × v in Newton's equation."""
    weight: int = 1
    axes: Literal["body", "", "back"] = "body"
    """The rotation of forces: "body" as it must be, "" none, "back" by Rᵀ into the world."""
    arms: tuple[int, int] = (1, 1)
    """Factors of the thrusts' moments about x and y."""
    angular: bool = True
    """Whether the rates of the angles follow from ω; else they are taken for it."""


@dataclass(frozen=True)
class FreeMotion:
    """Values of some generators by the others, according to the equations of motion."""

    images: Mapping[str, Value]

    def concerns(self, x: Value) -> bool:
        """Whether a value contains a generator that the equations of motion determine."""
        return any(self.images.keys() & powers.keys() for p in pair(x) for powers, _ in p.terms())

    def of(self, x: Value) -> Value:
        """A polynomial or quotient with the determined generators substituted."""
        above, below = (put(part, self.images) for part in pair(x))
        (p, q), (r, s) = pair(above), pair(below)
        return over(p * s, q * r)

    def at(self, point: Point) -> Point:
        """The point with accelerations that satisfy the equations of motion."""
        return point.changed({name: point.of(x) for name, x in self.images.items()})


@dataclass(frozen=True)
class FreeBodyMotion:
    """The motion of the free body that the equations describe."""

    setting: RightEquations

    @cached_property
    def body(self) -> FreeBody:
        """The free body as in derivations."""
        symbols = self.setting.symbols
        given = symbols.given or symbols.model
        return FreeBody(Setting(symbols), given, 0)

    @cached_property
    def angles(self) -> tuple[str, ...]:
        """Names of the body's yaw, pitch and roll."""
        return self.body.coordinates[_ANGLES]

    @cached_property
    def R(self) -> list[list[Trig]]:
        """The rotation matrix from body axes to world axes."""
        s = self.body.s
        return [[s.symbols.element(x) for x in row] for row in s.world[self.body.i][0]]

    def components(self, letter: str, dots: str = "") -> list[Trig]:
        """The components of v, ω, f, n or their rates as symbols."""
        return list(self.body.symbols_of(letter, dots))

    # ------------------------------------------------------------ thrusts
    @cached_property
    def thrusts(self) -> frozenset[str]:
        """The names of the thrusts on the body."""
        return frozenset(thrusts_of(self.body.given))

    def pushed(self, belief: FreeBelief) -> dict[str, Value]:
        """The components of f and n that the thrusts produce."""
        s = self.body.s
        f = n = [self.setting.zero] * 3
        for name, frame in thrusts_of(self.body.given).items():
            _, axes, at = s.tree.frames[frame.name]
            push = [s.symbols.element(row[2]) * s.symbols.ring[name] for row in axes]
            arm = [s.symbols.element(x) for x in sub(at, s.centre(self.body.i))]
            f = [a + b for a, b in zip(f, push, strict=True)]
            n = [a + b for a, b in zip(n, crossed(arm, push), strict=True)]
        n = [x if k > 0 else -x for x, k in zip(n, (*belief.arms, 1), strict=True)]
        names = (*self.body.components("f"), *self.body.components("n"))
        return dict(zip(names, (*f, *n), strict=True))

    # ------------------------------------------------------------ motion
    def motion(self, values: Iterable[Value], belief: FreeBelief = FreeBelief()) -> FreeMotion:
        """The accelerations, from v, ω and f, n if the values contain these, otherwise from the
        thrusts, if any."""
        used = {name for x in values for part in pair(x) for row, _ in part.terms() for name in row}
        images = self._images(belief)
        if used & self.thrusts or (self.thrusts and not used & set(FORCES)):
            pushed = self.pushed(belief)
            images = {name: _put(x, pushed) for name, x in images.items()} | pushed
        return FreeMotion(images)

    def _images(self, belief: FreeBelief) -> dict[str, Value]:
        v, w = self.components("v"), self.components("omega")
        images: dict[str, Value] = {}
        vd, wd = self._accelerations(v, w, belief)
        images |= dict(zip(self.body.components("v", RATE), vd, strict=True))
        images |= dict(zip(self.body.components("omega", RATE), wd, strict=True))
        places = self.body.coordinates[:3]
        moving = self._in_world(v, belief.axes)
        images |= {name + RATE: x for name, x in zip(places, moving, strict=True)}
        if belief.axes == "body":
            turning = crossed(w, v)
            inertial = [plus(a, x) for a, x in zip(vd, turning, strict=True)]
            lifted = [_inner(row, inertial) for row in self.R]
        else:
            lifted = self._unturned(belief.axes)
        images |= {name + SECOND: x for name, x in zip(places, lifted, strict=True)}
        return images | self._turning(w, wd, belief)

    def _accelerations(
        self, v: Sequence[Trig], w: Sequence[Trig], belief: FreeBelief
    ) -> tuple[list[Value], list[Value]]:
        """The accelerations v̇ and ω̇ by Newton's and Euler's equations."""
        s, zero = self.body.s, (self.setting.zero,) * 3
        inertia = [[s.symbols.element(x) for x in row] for row in s.inertia(self.body.i)]
        spin = crossed(w, [_polynomial(_inner(row, w)) for row in inertia])
        n = self.components("n")
        rest = [[a - b * belief.gyroscopic] for a, b in zip(n, spin, strict=True)]
        above, below = solved(inertia, rest, s.symbols)
        wd = [ratio(row[0], below) for row in above]
        put_in = dict(zip(self.body.components("omega", RATE), wd, strict=True))
        weight = self._weight(belief)
        m = s.symbols.element(s.mass(self.body.i))
        others, _ = self.body.wrench(zero, zero, tuple(w), self.body.symbols_of("omega", RATE))
        own = [f + m * g for f, g in zip(others, self._weight(FreeBelief()), strict=True)]
        vd = []
        for f, rest_of, g, x in zip(self.components("f"), own, weight, crossed(w, v), strict=True):
            force = plus(f, negative(put(rest_of, put_in)))
            acceleration = times(force, ratio(m / m, m))
            vd.append(plus(acceleration, g - x * belief.transport))
        return vd, [plus(x, self.setting.zero) for x in wd]

    def _weight(self, belief: FreeBelief) -> list[Trig]:
        """Gravity in body axes."""
        s = self.body.s
        g = s.gravity(self.body.i) if belief.axes else s.tree.gravity
        return [s.symbols.element(x) * belief.weight + self.setting.zero for x in g]

    def _unturned(self, axes: str) -> list[Value]:
        """The acceleration f / m + g in world axes under the mistake that f is not rotated, or
        rotated backwards."""
        s = self.body.s
        m = s.symbols.element(s.mass(self.body.i))
        gravity = map(s.symbols.element, s.tree.gravity)
        f = self._in_world(self.components("f"), axes)
        return [plus(times(a, ratio(m / m, m)), g) for a, g in zip(f, gravity, strict=True)]

    def _in_world(self, v: Sequence[Trig], axes: str) -> list[Value]:
        """World components of a body vector; `axes`: the rotation used, see `FreeBelief`."""
        if not axes:
            return list(v)
        rows = self.R if axes == "body" else zip(*self.R, strict=True)
        return [_inner(row, v) for row in rows]

    def _turning(
        self, w: Sequence[Trig], wd: Sequence[Value], belief: FreeBelief
    ) -> dict[str, Value]:
        """The rates of the angles and their second derivatives."""
        if not belief.angular:
            yaw, pitch, roll = self.angles
            first = {roll: w[0], pitch: w[1], yaw: w[2]}
            second = {roll: wd[0], pitch: wd[1], yaw: wd[2]}
            rates = {name + RATE: x for name, x in first.items()}
            return rates | {name + SECOND: x for name, x in second.items()}
        names, ring = self.angles, self.setting.ring
        E = [[x.derivative(name + RATE) for name in names] for x in self.body.w]
        above, below = solved(E, [[x] for x in w], self.setting.symbols)
        found: dict[str, Value] = {
            name + RATE: ratio(row[0], below) for name, row in zip(names, above, strict=True)
        }
        found = {name: plus(x, self.setting.zero) for name, x in found.items()}
        moving = {name: ring[name + RATE] for name in names}
        turning = self.body.components("omega")
        moving |= {x: ring[x + RATE] for x in turning}
        put_in = found | dict(zip([x + RATE for x in turning], wd, strict=True))
        for name in names:
            a, b = pair(found[name + RATE])
            slope = a.along(moving) * b - a * b.along(moving)
            found[name + SECOND] = times(put(slope, put_in), ratio(b / b, b * b))
        return found


def crossed(a: Sequence[Trig], b: Sequence[Trig]) -> list[Trig]:
    """The cross product a × b of polynomials."""
    return [a[i] * b[j] - a[j] * b[i] for i, j in ((1, 2), (2, 0), (0, 1))]


def _inner(a: Sequence[Trig], b: Sequence[Value]) -> Value:
    first, *rest = (times(x, y) for x, y in zip(a, b, strict=True))
    for x in rest:
        first = plus(first, x)
    return first


def _polynomial(x: Value) -> Trig:
    assert isinstance(x, Trig)
    return x


def _put(x: Value, images: Mapping[str, Value]) -> Value:
    return FreeMotion(images).of(x)
