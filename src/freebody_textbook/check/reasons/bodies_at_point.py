"""Motion and forces of a mechanism's bodies in numbers at a point, also under wrong beliefs about
their equations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

from freebody.algorithms.kinematics import compose
from freebody.algorithms.loop_constraints import loop_loads
from freebody.lazy import cached_property
from freebody.spatial import Matrix, Vector, add, dot, scale, sub, times, transposed
from freebody_textbook.check.algebra.finite_field import Point
from freebody_textbook.check.asked.right_equations import RightEquations
from freebody_textbook.methods.setting import Setting


@dataclass(frozen=True)
class Belief:
    """A wrong belief about the equations of a body: changed factors and terms; the defaults are
    correct. F is m (v̇_c - g), f the force of the body on the next one; s and s_c lead from its
    joint to the next joint and to its centre of mass."""

    force: int = 1
    """The factor of f in Newton's equation."""
    couple: int = 1
    """The factor of the next body's moment in Euler's."""
    arms: tuple[int, ...] = (1, 0, 0, 1)
    """The factors of s_c × F, s × F, s_c × f and s × f in Euler's equation."""
    product: Callable[[Vector, Vector], Vector] | None = None
    """The function that a cross product in the plane is taken for."""
    joint_is_fixed: bool = False
    """Whether the joint is taken for one that does not accelerate."""
    loops_act: bool = True
    gyroscopic: int = 1
    """Factor of ω × I ω in Euler's equation."""
    spins_alone: bool = False
    """Whether the body's own joint alone makes up ω in I ω."""
    turns_alone: bool = False
    """Whether it alone makes up ω in ω × r."""
    coriolis: Fraction = Fraction(1)
    """Factor of the Coriolis acceleration 2 ω × ḋ."""


RIGHT = Belief()
_RIGHTLY = (False, False, 1, 1)
"""The right answers to the questions of a belief that concern motions."""
BodyKey = tuple[str, int]
"""Letter of a vector and number of its body."""


@dataclass(frozen=True)
class BodyThere:
    """A body with numbers at a point: vectors in world axes, the inertia in body axes."""

    parent: int
    place: int
    """The number of the body's coordinate."""
    turns: bool
    R: Matrix
    way: Vector
    """Vector from the joint before to the body's joint."""
    turn: Vector
    slide: Vector
    m: Any
    centre: Vector
    inertia: Any
    reach: Vector
    """The vector from the body's joint to the next one, or to the tip."""
    loops: tuple[Vector, Vector]
    """Force and moment of the loops on the body."""


@dataclass(frozen=True)
class State:
    """Rates and accelerations of the coordinates, gravity, and whether the state is complete, with
    the forces of loops and drives."""

    rates: Vector
    accelerations: Vector
    gravity: Vector
    is_whole: bool = False


@dataclass(frozen=True)
class InertialMotion:
    """The motion of one body: ω and ω̇ as used in I ω and as used in ω × r, and velocities and
    accelerations of its joint and centre of mass."""

    spin: tuple[Vector, Vector]
    arm: tuple[Vector, Vector]
    v: Vector
    vd: Vector
    vc: Vector
    vcd: Vector


Inertial = tuple[InertialMotion, Vector, Vector, Any]
"""Motion, force and moment of one body, and ω · I ω."""


@dataclass(frozen=True)
class BodiesAtPoint:
    """The bodies of a tree, or of a closed chain with its loops cut, in numbers at a point."""

    setting: RightEquations
    point: Point

    @cached_property
    def s(self) -> Setting:
        """The mechanism for which the equations are derived."""
        return Setting(self.setting.equations.symbols)

    @property
    def is_told(self) -> bool:
        """Whether each body has a single mass and a joint with a coordinate of its own."""
        tree = self.s.tree
        single = all(len(x.masses) < 2 and len(x.coordinates.v) == 1 for x in tree.bodies)
        return single and not tree.follows and self.setting.turned is None

    def number(self, x: Any) -> Any:
        """The value at the point of a polynomial of the equations."""
        return self.point.of(self.setting.element(self.s.symbols.element(x)))

    def vector(self, v: Sequence[Any]) -> Vector:
        """The value at the point of a vector of polynomials."""
        return tuple(map(self.number, v))

    def _zero(self, angular: bool = False) -> Vector:
        return (0,) * (1 if angular and self.s.planar else self.s.tree.space.dim)

    @cached_property
    def bodies(self) -> list[BodyThere]:
        """The bodies, parents first."""
        s, found, world = self.s, list[BodyThere](), list[Any]()
        system = self.setting.system
        acting = (
            loop_loads(system.loops.tree, s.symbols.q, tuple(system.multipliers)) if system else []
        )
        joints = [(tuple(map(self.vector, R)), self.vector(p)) for R, p in s.motion.joints]
        for i, (body, joint) in enumerate(zip(s.tree.bodies, joints, strict=True)):
            before = world[body.parent] if body.parent >= 0 else None
            R, _ = pose = compose(before, joint) if before else joint
            world.append(pose)

            def turned(v: Vector, R: Matrix = R) -> Vector:
                return v if s.planar and len(v) == 1 else times(R, v)

            ends = [joints[k][1] for k in s.tree.children(i)]
            ends += [self.vector(s.tip_frame[2])] * s.ends_in_tip(i)
            ((turn, slide),) = (tuple(map(self.vector, x)) for x in body.columns)
            loads = [tuple(map(self.vector, x[1:])) for x in acting if x[0] == i]
            force, moment = (
                turned(add(zero, *(x[k] for x in loads)))
                for k, zero in enumerate((self._zero(), self._zero(True)))
            )
            mass, inertia = body.masses, s.inertia(i)
            found.append(
                BodyThere(
                    body.parent, body.coordinates.v[0], s.turns(i), R,
                    times(before[0], joint[1]) if before else joint[1],
                    turned(turn), turned(slide), self.number(s.mass(i)),
                    turned(self.vector(mass[0].c)) if mass else self._zero(),
                    self.number(inertia) if s.planar else tuple(map(self.vector, inertia)),
                    turned(ends[0]) if ends else self._zero(), (force, moment),
                )
            )  # fmt: skip
        return found

    # ------------------------------------------------------------ states
    @cached_property
    def moving(self) -> State:
        """The full state: velocities, accelerations and gravity."""
        x = self.s.symbols
        rates, second = self.vector(x.qd), self.vector(x.qdd)
        return State(rates, second, self.vector(self.s.tree.gravity), True)

    def states(self, j: int) -> dict[str, State]:
        """States in which the joint torques equal τ, c and g; for a coordinate j ≥ 0, column j of
        M."""
        if j >= 0:
            return {"M": self.starting(j)}
        still = self.starting(-1)
        coasting = replace(still, rates=self.moving.rates)
        resting = replace(still, gravity=self.moving.gravity)
        return {"tau": self.moving, "c": coasting, "g": resting}

    def driven(self, i: int, state: State) -> Any:
        """The drive's part of a joint torque: rotor inertia, and in a complete state friction and
        springs."""
        drive, k = self.s.tree.bodies[i].drive, self.bodies[i].place
        rotor = self.number(drive.inertia) * state.accelerations[k] if drive else 0
        return rotor + (self.number(self.s.equations.drives[k]) if state.is_whole else 0)

    def starting(self, j: int) -> State:
        """The state with unit acceleration of coordinate j and nothing else."""
        n = range(len(self.moving.rates))
        return State((0,) * len(n), tuple(int(k == j) for k in n), self._zero())

    # ------------------------------------------------------------ motion
    def _crossed(self, w: Vector, r: Vector) -> Vector:
        return self.s.tree.space.cross(w, r)

    def _whirled(self, w: tuple[Vector, Vector], r: Vector) -> Vector:
        """Acceleration of the point at r on a rotating body relative to its origin: ω̇ × r + ω × (ω
        × r)."""
        return add(self._crossed(w[1], r), self._crossed(w[0], self._crossed(w[0], r)))

    def motions(self, state: State, of: Collection[int], belief: Belief) -> list[InertialMotion]:
        """The motion of every body, with a belief about some of them."""
        still = self._zero(True), self._zero(True)
        found, true, alone = list[InertialMotion](), {-1: still}, {-1: still}
        ground = InertialMotion(still, still, *[self._zero()] * 4)
        for i, body in enumerate(self.bodies):
            held, k = belief if i in of else RIGHT, body.parent
            before = found[k] if k >= 0 else ground
            rate, second = state.rates[body.place], state.accelerations[body.place]
            own = scale(rate, body.turn), scale(second, body.turn)
            w, wd = add(true[k][0], own[0]), add(true[k][1], own[1])
            if not self.s.planar:
                wd = add(wd, self._crossed(true[k][0], own[0]))
            true[i], alone[i] = (w, wd), own if body.turns else alone[k]
            spin = alone[i] if held.spins_alone else true[i]
            arm = alone[i] if held.turns_alone else true[i]
            sliding, twice = scale(rate, body.slide), 2 * self.point.number(held.coriolis)
            v = add(before.v, self._crossed(before.arm[0], body.way), sliding)
            vd = add(
                add(before.vd, self._whirled(before.arm, body.way)),
                add(scale(second, body.slide), scale(twice, self._crossed(arm[0], sliding))),
            )
            vc = add(v, self._crossed(arm[0], body.centre))
            found.append(
                InertialMotion(spin, arm, v, vd, vc, add(vd, self._whirled(arm, body.centre)))
            )
        return found

    def _spun(self, body: BodyThere, motion: InertialMotion, gyroscopic: int) -> tuple[Vector, Any]:
        """(rate of a body's angular momentum about its centre of mass, ω · I ω)."""
        if self.s.planar:
            ((w,), (wd,)) = motion.spin
            return (body.inertia * wd,), body.inertia * w * w
        w, wd = (times(transposed(body.R), x) for x in motion.spin)
        momentum = times(body.inertia, w)
        turning = scale(gyroscopic, self._crossed(w, momentum))
        return times(body.R, add(times(body.inertia, wd), turning)), dot(w, momentum)

    # ------------------------------------------------------------ all that is told
    @cached_property
    def _known(self) -> dict[Any, Any]:
        return {}

    def inertial(self, state: State, of: Collection[int], belief: Belief) -> list[Inertial]:
        """For every body its motion, m (v̇_c - g), the rate of angular momentum, and ω · I ω."""
        own = (belief.spins_alone, belief.turns_alone, belief.coriolis, belief.gyroscopic)
        key = (state, *((own, tuple(of)) if own != _RIGHTLY else ()))
        if key not in self._known:
            self._known[key] = [
                (
                    x,
                    scale(body.m, sub(x.vcd, state.gravity)),
                    *self._spun(body, x, belief.gyroscopic if i in of else 1),
                )
                for i, (body, x) in enumerate(
                    zip(self.bodies, self.motions(state, of, belief), strict=True)
                )
            ]
        return self._known[key]

    def moved(self, of: Collection[int] = (), belief: Belief = RIGHT) -> dict[BodyKey, Vector]:
        """Motion vectors of the bodies in world axes, and kinetic energies; key -1 has the
        total."""
        found: dict[BodyKey, Vector] = {}
        half = self.point.number(Fraction(1, 2))
        for i, (x, _, spun, energy) in enumerate(self.inertial(self.moving, of, belief)):
            body = self.bodies[i]
            found |= {("w", i): x.spin[0], ("wd", i): x.spin[1], ("v", i): x.v, ("vd", i): x.vd}
            found |= {("vc", i): x.vc, ("vcd", i): x.vcd, ("nc", i): spun}
            found["fc", i] = scale(body.m, x.vcd)
            found["v tip", i] = add(x.v, self._crossed(x.arm[0], body.reach))
            found["vd tip", i] = add(x.vd, self._whirled(x.arm, body.reach))
            found["T", i] = (half * (body.m * dot(x.vc, x.vc) + energy),)
        found["T", -1] = (sum(found["T", i][0] for i in range(len(self.bodies))),)
        return found

    def acting(
        self, state: State, of: Collection[int] = (), belief: Belief = RIGHT
    ) -> dict[BodyKey, Vector]:
        """Force and moment on each body at its joint, in world axes, and the joint torque."""
        if belief is RIGHT and ("acting", state) in self._known:
            return self._known["acting", state]
        inertial, found = self.inertial(state, of, belief), dict[BodyKey, Vector]()
        for i in reversed(range(len(self.bodies))):
            body, held = self.bodies[i], belief if i in of else RIGHT
            crossed = (self.s.planar and held.product) or self.s.tree.space.moment
            x, f, n, _ = inertial[i]
            a, b, c, d = held.arms
            n = add(n, crossed(add(scale(a, body.centre), scale(b, body.reach)), f))
            if held.joint_is_fixed:
                n = sub(n, crossed(body.centre, scale(body.m, x.vd)))
            for k, child in enumerate(self.bodies):
                if child.parent == i:
                    arm = add(scale(c, body.centre), scale(d, child.way))
                    f = add(f, scale(held.force, found["f", k]))
                    n = add(n, scale(held.couple, found["n", k]), crossed(arm, found["f", k]))
            if state.is_whole and held.loops_act:
                f, n = sub(f, body.loops[0]), sub(n, body.loops[1])
            found |= {("f", i): f, ("n", i): n}
            found["tau", i] = (dot(body.turn, n) + dot(body.slide, f),)
        if belief is RIGHT:
            self._known["acting", state] = found
        return found

    def projected(
        self, state: State, of: Collection[int] = (), belief: Belief = RIGHT
    ) -> dict[BodyKey, Vector]:
        """Joint torques without loops by partial velocities: Σ ∂v_c/∂q̇ · m (v̇_c - g) + ∂ω/∂q̇ · I
        ω̇."""
        inertial, found = self.inertial(state, of, belief), dict[BodyKey, Vector]()
        for i, own in enumerate(self.bodies):
            unit = replace(self.starting(-1), rates=self.starting(own.place).accelerations)
            parts = [x for x, *_ in self.inertial(unit, of, belief)]
            rows = zip(parts, inertial, strict=True)
            found["tau", i] = (
                sum(dot(part.vc, f) + dot(part.spin[0], n) for part, (_, f, n, _) in rows),
            )
        return found
