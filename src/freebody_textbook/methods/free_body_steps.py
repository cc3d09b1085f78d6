"""Steps of the derivation of one free body's equations, in body axes (6.1, 6.2)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.nodes import Symbol
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym, vec
from freebody.expressions.typesetting.literal import literal
from freebody.lazy import cached_property
from freebody.model.bodies import Body, Frame
from freebody.model.model import Model
from freebody.model.parameters import Parameter, Quantity
from freebody.model.tree import Attached
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, scale, sub, times, transposed
from freebody_textbook.closed_chains.linear_equations import ratio, solved
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting

XYZ = ("x", "y", "z")
PLACES = 6
"""Joints of one coordinate that stand for a free one: three slides, yaw, pitch and roll."""
UNITS = {"v": "m/s", "omega": "rad/s"}


def mark_of(model: Model, k: int) -> str:
    """The number of body k in symbols; "" if it is the only body."""
    return str(k + 1) if len(model.bodies) > 1 else ""


def part_with_mass(body: Body) -> Attached:
    """The part with mass of a body; further parts may be payloads without mass."""
    masses = [(part, part.inertia.mass) for part in body.inertias]
    weighing = (x for x, m in masses if (m.value if isinstance(m, Parameter) else m) != 0.0)
    return next(weighing, body.inertias[0])


def mass_symbol(model: Model, k: int) -> Symbol:
    """The model's name for the mass of body k, otherwise m with the body's number."""
    mass = part_with_mass(model.bodies[k]).inertia.mass
    name = sym(mass.name if isinstance(mass, Parameter) else f"m{mark_of(model, k)}")
    assert isinstance(name, Symbol)
    return name


def thrusts_of(model: Model) -> dict[str, Frame]:
    """Frames along whose z axes thrusts act, by the thrusts' names: all frames mounted on bodies,
    except the tip."""
    frames = [x for x in model.frames if x.mounted and x.body >= 0 and x.name != model.tip]
    return {f"T{j}": frame for j, frame in enumerate(frames, 1)}


@dataclass(frozen=True)
class FreeBody:
    """Body k of a model of free bodies, with its derivation steps."""

    s: Setting
    given: Model
    k: int

    # ------------------------------------------------------------ names
    @cached_property
    def i(self) -> int:
        """Index of the tree body that has the mass, after its six joints."""
        return self.s.tree.body_of[PLACES * (self.k + 1) - 1]

    @cached_property
    def mark(self) -> str:
        """The body's number in symbols; "" if it is the only body."""
        return mark_of(self.given, self.k)

    @cached_property
    def coordinates(self) -> tuple[str, ...]:
        """Names of x, y, z, yaw, pitch and roll."""
        start = PLACES * self.k
        return self.s.symbols.coordinates[start : start + PLACES]

    def vector(self, letter: str, dots: str = "") -> Symbol:
        """The symbol of one of the body's vectors."""
        return vec(f"{letter}{self.mark}{dots}")

    def components(self, letter: str, dots: str = "") -> tuple[str, ...]:
        """Names of the components of a vector."""
        return tuple(f"{letter}{self.mark}_{axis}{dots}" for axis in XYZ)

    @property
    def R(self) -> Symbol:
        """The symbol of the body's rotation."""
        return Symbol(f"R{self.mark}", "R", (self.mark,) if self.mark else ())

    @property
    def m(self) -> Expression:
        """The symbol of the body's mass: the model's name, otherwise m."""
        return mass_symbol(self.given, self.k)

    @property
    def mass(self) -> Quantity:
        """The mass of the free body, a number or a parameter of the model."""
        return part_with_mass(self.given.bodies[self.k]).inertia.mass

    @property
    def inertia(self) -> Expression:
        """The symbol of the body's inertia tensor."""
        return sym(f"I{self.mark}")

    @property
    def q(self) -> tuple[Symbol, ...]:
        """Symbols of the quaternion for the body's orientation."""
        return tuple(Symbol(f"q{self.mark}_{x}", "q", (self.mark + x,)) for x in ("w", *XYZ))

    @property
    def arm(self) -> Symbol:
        """The symbol of the vector from the body's origin to its centre of mass."""
        return Symbol(f"sc{self.mark}", "s", (f"c{self.mark}",), bold=True)

    @cached_property
    def is_off_centre(self) -> bool:
        """Whether the body's origin differs from its centre of mass."""
        return self.s.column(self.s.centre(self.i)) != ex.ZERO

    # ------------------------------------------------------------ polynomials
    def symbols_of(self, letter: str, dots: str = "") -> Vector:
        """The components of v or ω as symbols."""
        return tuple(self.s.symbols.ring[name] for name in self.components(letter, dots))

    @cached_property
    def v(self) -> Vector:
        """Velocity of the origin in body axes, Rᵀ ṗ, by the rates of the coordinates."""
        R, p = self.s.world[self.i]
        moving = [self.s.symbols.element(x).along(self.s.symbols.rates) for x in p]
        return self._elements(times(transposed(R), tuple(moving)))

    @cached_property
    def w(self) -> Vector:
        """Angular velocity in body axes, by the rates of the angles."""
        return self._elements(self.s.motion.w[self.i])

    def _elements(self, v: Vector) -> Vector:
        return tuple(map(self.s.symbols.element, v))

    def wrench(self, v: Vector, vd: Vector, w: Vector, wd: Vector) -> tuple[Vector, Vector]:
        """Force and moment (f, n) by Newton and Euler."""
        s, space = self.s, self.s.tree.space
        c = s.centre(self.i)
        turning = add(space.cross(wd, c), space.cross(w, space.cross(w, c)))
        acceleration = add(vd, space.cross(w, v), turning)
        f = scale(s.mass(self.i), sub(acceleration, s.gravity(self.i)))
        return self._elements(f), self._elements(space.euler(s.inertia(self.i), w, wd))

    @cached_property
    def generalized(self) -> tuple[Trig, ...]:
        """The generalized forces along the coordinates that do the same work as f and n."""
        s, rates = self.s, self.s.symbols.rates
        vd, wd = (tuple(x.along(rates) for x in moving) for moving in (self.v, self.w))
        f, n = self.wrench(self.v, vd, self.w, wd)
        about = self._elements(add(n, s.tree.space.cross(s.centre(self.i), f)))
        return tuple(
            inner([x.derivative(name + RATE) for x in (*self.v, *self.w)], (*f, *about), s.symbols)
            for name in self.coordinates
        )

    # ------------------------------------------------------------ steps
    def steps(self) -> Iterator[Step]:
        """All derivation steps of this body in order."""
        yield self.pose()
        yield self.laws()
        yield self.written_out()
        yield self.angles()
        yield self.quaternion()
        yield from self.pushed()
        yield self.along_coordinates()

    def pose(self) -> Step:
        """Step: the coordinates, the rotation R and the velocity ṗ."""
        yaw, pitch, roll = map(self._told, self.coordinates[3:])
        R, p = self.s.world[self.i]
        reason = (
            f"p leads to the body's origin. Three turns in a row give its orientation: yaw {yaw} "
            f"about z, pitch {pitch} about the y axis that results, roll {roll} about the x axis "
            "that results. R takes components from the body's axes to the world's. The velocity v "
            "and the angular velocity ω are given in the body's own axes, where the inertia does "
            "not change."
        )
        shown = ex.matrix([[self.s.show(x) for x in row] for row in R])
        lines = (
            eq(self.vector("p"), self.s.column(p)),
            eq(self.R, shown),
            eq(self.vector("p", RATE), ex.mul(self.R, self.vector("v"))),
        )
        return Step(f"Position and orientation{self._of}", reason, lines)

    @property
    def _of(self) -> str:
        return f" of body {self.mark}" if self.mark else ""

    def _told(self, name: str) -> str:
        return f"θ_{name.removeprefix('theta')}"

    def laws(self) -> Step:
        """Step: Newton's and Euler's equations in vectors."""
        v, w, vd, wd = (self.vector(x, d) for d in ("", RATE) for x in UNITS)
        inertia, f, n = self.inertia, self.vector("f"), self.vector("n")
        terms = [vd, ex.cross(w, v)]
        off, arm = self.is_off_centre, self.arm
        if off:
            terms += [ex.cross(wd, arm), ex.cross(w, ex.cross(w, arm))]
        weight = ex.mul(self.m, ex.transposed(self.R), vec("g")) if self.s.weighs else ex.ZERO
        lines = [
            eq(ex.mul(self.m, ex.add(*terms)), ex.add(weight, f)),
            eq(ex.add(ex.mul(inertia, wd), ex.cross(w, ex.mul(inertia, w))), n),
            *(
                []
                if isinstance(self.mass, Parameter)
                else [eq(self.m, self.s.show(self.s.mass(self.i)))]
            ),
            *([eq(arm, self.s.column(self.s.centre(self.i)))] if off else []),
            eq(inertia, ex.matrix([map(self.s.show, row) for row in self.s.inertia(self.i)])),
        ]
        weighed = "its weight and " if self.s.weighs else ""
        reason = (
            f"On the body act {weighed}the force f, with the moment n about the centre of mass. "
            "The axes turn with the body: a vector whose components change at the rates ȧ has the "
            "derivative ȧ + ω × a. So the acceleration of the origin is v̇ + ω × v (Newton), and "
            "the angular momentum I ω changes at I ω̇ + ω × I ω (Euler)."
        )
        if any(frame.body == self.k for frame in thrusts_of(self.given).values()):
            reason += " In the drawing the thrusts T_j make up f and n; their step is below."
        if off:
            reason += " The centre of mass, at s_c from the origin, is accelerated as well by the "
            reason += "turning."
        return Step(
            f"Free body{' ' + self.mark if self.mark else ''}",
            reason,
            tuple(lines),
            ("6.1", "6.2"),
            figure=f"free {self.k + 1}",
        )

    def written_out(self) -> Step:
        """Step: force f and moment n by their components."""
        f, n = self.wrench(
            self.symbols_of("v"), self.symbols_of("v", RATE),
            self.symbols_of("omega"), self.symbols_of("omega", RATE),
        )  # fmt: skip
        names = (*self.components("f"), *self.components("n"))
        lines = tuple(eq(sym(a), self.s.show(x)) for a, x in zip(names, (*f, *n), strict=True))
        reason = (
            "The same by components. The products of angular rates in the moments, ω × I ω, are "
            "the gyroscopic moment: a body that turns evenly about an axis which is no principal "
            "axis of its inertia still needs it, and it vanishes where all moments of inertia are "
            "equal."
        )
        return Step(f"The equations of motion{self._of}", reason, lines, result=True)

    def angles(self) -> Step:
        """Step: ω by the rates of the angles, and the rates by ω."""
        s, names = self.s, self.coordinates[3:]
        E = [[x.derivative(name + RATE) for name in names] for x in self.w]
        above, below = solved(E, [[x] for x in self.symbols_of("omega")], s.symbols)
        lines = [
            eq(sym(a), s.show(x)) for a, x in zip(self.components("omega"), self.w, strict=True)
        ]
        lines += [
            eq(sym(name + RATE), ratio(row[0], below).form(s.layout))
            for name, row in zip(names, above, strict=True)
        ]
        yaw, pitch, roll = map(self._told, names)
        reason = (
            "Each angle's rate turns the body about its own axis; together they are ω. Solved for "
            "the rates, this is what a simulation integrates beside ṗ = R v. Where the "
            f"cosine of {pitch} vanishes the axes of {yaw} and {roll} are in line and the rates "
            "are infinite (gimbal lock), although nothing happens to the body."
        )
        return Step(f"Rates of the angles{self._of}", reason, tuple(lines))

    def quaternion(self) -> Step:
        """Step: the rate of the orientation as a quaternion, without angles."""
        q = self.q
        a, b, c = map(sym, self.components("omega"))
        w, x, y, z = q
        half, two = ex.num(Fraction(1, 2)), ex.expr(2)

        def rate(name: Symbol, *terms: Expression) -> Equation:
            dotted = Symbol(name.name + RATE, name.letter, name.low, 1)
            return eq(dotted, ex.mul(half, ex.add(*terms)))

        def on(u: Symbol, v: Symbol) -> Expression:
            return ex.sub(1, ex.mul(two, ex.add(ex.power(u, 2), ex.power(v, 2))))

        def off(sign: int, *of: Symbol) -> Expression:
            first, second = ex.mul(*of[:2]), ex.mul(*of[2:])
            return ex.mul(two, (ex.add if sign > 0 else ex.sub)(first, second))

        rows = (
            (on(y, z), off(-1, x, y, w, z), off(1, x, z, w, y)),
            (off(1, x, y, w, z), on(x, z), off(-1, y, z, w, x)),
            (off(-1, x, z, w, y), off(1, y, z, w, x), on(x, y)),
        )
        lines = (
            eq(self.R, ex.matrix(rows)),
            rate(w, *(ex.neg(ex.mul(u, v)) for u, v in ((x, a), (y, b), (z, c)))),
            rate(x, ex.mul(w, a), ex.mul(y, c), ex.neg(ex.mul(z, b))),
            rate(y, ex.mul(w, b), ex.mul(z, a), ex.neg(ex.mul(x, c))),
            rate(z, ex.mul(w, c), ex.mul(x, b), ex.neg(ex.mul(y, a))),
        )
        reason = (
            "Four numbers, the squares of which add up to 1, tell the orientation without a "
            "singular position: q_w is the cosine of half the angle of the turn, the others are "
            "the axis times its sine. Their rates are linear in ω; the equations of motion stay "
            "as they are, with this R."
        )
        return Step(f"A quaternion in place of the angles{self._of}", reason, lines)

    def pushed(self) -> Iterator[Step]:
        """Steps: thrusts along the z axes of the body's frames."""
        s = self.s
        own = {name: x for name, x in thrusts_of(self.given).items() if x.body == self.k}
        if not own:
            return
        f = n = s.tree.space.zero
        lines: list[Equation] = []
        for name, frame in own.items():
            _, turned, at = s.tree.frames[frame.name]
            push = scale(s.symbols.ring[name], tuple(row[2] for row in turned))
            arm = sub(at, s.centre(self.i))
            f, n = add(f, push), add(n, s.tree.space.cross(arm, push))
            lines.append(eq(vec(f"s{name.removeprefix('T')}"), s.column(arm)))
        both = zip(("f", "n"), (f, n), strict=True)
        lines += [eq(self.vector(letter), s.column(x)) for letter, x in both]
        told = listed([literal(frame.name) for frame in own.values()])
        lost = [
            f"{words} {axis}"
            for words, v in (("force along", f), ("moment about", n))
            for axis, x in zip(XYZ, v, strict=True)
            if s.symbols.element(x).is_zero
        ]
        reason = (
            f"If a thrust T_j pushes along the z axis of each frame on the body ({told}), s_j "
            "leading there from the centre of mass, these are their sum and the sum of their "
            "moments."
        )
        if lost:
            reason += f" They give {listed(f'no {x}' for x in lost)}."
        yield Step(f"Force and moment of thrusts{self._of}", reason, tuple(lines))

    def along_coordinates(self) -> Step:
        """Step: the generalized forces τ with the same work as f and n."""
        s = self.s
        n = self.vector("n")
        about = ex.add(n, ex.cross(self.arm, self.vector("f"))) if self.is_off_centre else n
        lines = [eq(self._along("p"), ex.mul(self.R, self.vector("f")))]
        names = self.coordinates[3:]
        for k, name in enumerate(names, 4 + PLACES * self.k):
            column = s.column(tuple(x.derivative(name + RATE) for x in self.w))
            lines.append(eq(sym(f"tau{k}"), ex.dot(column, about)))
        reason = (
            "The work of f and n in a small change of the coordinates gives the forces along "
            "them: those along p are f by its components in the world, those along the angles the "
            "parts of the moment about the origin along their axes. Other methods end in these."
        )
        return Step(f"Forces along the coordinates{self._of}", reason, tuple(lines))

    def _along(self, letter: str) -> Expression:
        first = PLACES * self.k
        return ex.Vector(tuple(sym(f"tau{first + j}") for j in (1, 2, 3)))
