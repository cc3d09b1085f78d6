"""Lagrange's equations of the first kind in absolute coordinates, as in section 5.4 of the notes:
x, y and φ of each body, with all joints as constraints (5.21-5.29).

The multipliers are then the forces in the joints, and the equations those of Newton and Euler.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from fractions import Fraction

from freebody.errors import FreebodyError, listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import entry, sym
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.model.parameters import Parameter
from freebody.model.placement import AxisRotation, Rotate
from freebody.scalars.trig import Trig
from freebody.spatial import dot
from freebody_textbook.closed_chains.absolute import AbsoluteCoordinates, Constraint
from freebody_textbook.derivation import Meaning, Step, Worked
from freebody_textbook.methods import glossary
from freebody_textbook.methods.body_by_body import drive_part
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import Loops, block_system, dotted
from freebody_textbook.methods.energies import HALF
from freebody_textbook.methods.setting import LONGEST, Setting
from freebody_textbook.methods.step_reasons import Efforts

_WIDE = 12
"""Coordinates up to which the mass matrix is written out."""


def work_out(s: Setting) -> Worked:
    """Derive the equations of a planar open or closed chain in absolute coordinates."""
    if len(s.leaders) < len(s.order):
        raise FreebodyError(
            f"derive: absolute coordinates are written out for joints that move by themselves; in "
            f"{s.symbols.model.name!r} some follow others; leave coordinates out."
        )
    if not s.planar:
        raise FreebodyError(
            f"derive: absolute coordinates are written out for the plane, and "
            f"{s.symbols.model.name!r} is in space; leave coordinates out."
        )
    work = _Absolute(s)
    steps = [work.chosen(), work.constrained(), work.freedom(), work.rates(), work.energies()]
    steps += [work.efforts(), *map(work.body, work.bodies), work.meaning(), work.seconds()]
    back = BackToJoints(s, work.given, work.loops)
    steps += [work.together(), back.step(), back.result()]
    sought = f"{Efforts.of(s).given} accelerations and the forces in all joints are sought."
    title = "Lagrange's equations of the first kind in absolute coordinates"
    return Worked(tuple(steps), tuple(back.tau), work.symbols(), title, sought)


class _Absolute:
    """The steps of a derivation in absolute coordinates."""

    def __init__(self, s: Setting):
        self.s = s
        efforts = {i: str(x.name) for i in s.order if isinstance(x := self.effort(i), ex.Symbol)}
        self.given = AbsoluteCoordinates(s.symbols, efforts)
        self.bodies, self.layout = self.given.bodies, self.given.layout
        self.loops = Loops(s)

    def symbols(self) -> Iterator[Meaning]:
        """Meanings of the symbols that absolute coordinates introduce."""
        names = [self.given.names_of(i) for i in self.bodies]
        places = [x for name in names for x in name[:2]]
        angles = [name[2] for name in names]
        where = "position of the centre of mass of body i"
        if len(self.bodies) > len(self.s.weighted):
            where += ", or of joint i if the body has no mass"
        for chosen, words, unit in (
            (places, where, "m"),
            (angles, "angle of body i from the world's x axis", "rad"),
        ):
            yield Meaning(tuple(map(sym, chosen)), words, unit)
            rates = tuple(sym(x + dots) for dots in (RATE, SECOND) for x in chosen)
            one = len(chosen) == 1
            theirs = (
                "its velocity and acceleration" if one else "their velocities and accelerations"
            )
            yield Meaning(rates, theirs, f"{unit}/s, {unit}/s²")
        yield Meaning((sym("T"), sym("V")), "kinetic and potential energy", glossary.JOULE)
        yield Meaning((sym("Phi_k"),), "a constraint, zero where joint or loop hold together", "")
        yield Meaning((sym("lam_k"),), "its multiplier: a force in a joint or a loop", "")
        yield from meanings(self.s, "f{h}{n}")
        yield from glossary.joint_moments(self.s)

    def show(self, x: Trig) -> Expression:
        """Printed form of a polynomial in absolute coordinates."""
        shown = self.layout.form(x)
        return shown if ex.size(shown) <= LONGEST else ex.words(f"({len(x)} terms)")

    # ------------------------------------------------------------ coordinates and constraints
    def chosen(self) -> Step:
        """Step: the coordinates x, y, φ of each body."""
        lines = [
            eq(self.s.name("rc", i), ex.vector(*self.given.names_of(i)[:2]))
            for i in self.bodies
            if i in self.s.weighted
        ]
        lines.append(eq("q", ex.Vector(tuple(map(sym, self.given.names)))))
        reason = (
            "Each body is located by the position of its centre of mass, x and y, and by the angle "
            "φ of its axes, as if it were free. What the joints do not allow is added as "
            "constraints. No choice is needed, which is why general multibody programs use them; "
            "the price is many coordinates."
        )
        return Step("Absolute coordinates", reason, tuple(lines), figure="centres")

    def constrained(self) -> Step:
        """Step: the constraint equations, Φ(q) = 0."""
        turns = self._turns()
        lines = [
            eq(entry("Phi", k + 1), ex.add(self.show(x), turns.get(k, ex.ZERO)), ex.ZERO)
            for k, x in enumerate(self.given.Phi)
        ]
        reason = " ".join(map(self._told, self.given.constraints))
        free = [f"body {self.s.numbers[i]}" for i in self.bodies if i not in self.given.joints]
        if free:
            reason += f" No joint holds {listed(free)}."
        return Step("The constraints", reason, tuple(lines), ("5.21",))

    def _turns(self) -> dict[int, Expression]:
        """The constant angle of a slide's guide, by the index of its equation."""
        s = self.s
        return {
            c.rows[-1]: ex.neg_each(_turn_of(s.symbols.model, s.numbers[c.body]))
            for c in self.given.constraints
            if c.loop is None and not s.turns(c.body)
        }

    def _told(self, constraint: Constraint) -> str:
        rows = listed([f"Φ_{k + 1}" for k in constraint.rows])
        if constraint.loop is not None:
            return f"{rows}: {self.loops.holds(constraint.loop)}."
        i, n = constraint.body, self.s.numbers[constraint.body]
        before = self.loops.body(self.s.tree.bodies[i].parent)
        if self.s.turns(i):
            return f"{rows}: joint {n} pins body {n} to {before}, at one point of both."
        return (
            f"{rows}: joint {n} guides body {n} on {before}, with no motion across the slide and "
            "no turning."
        )

    def freedom(self) -> Step:
        """Step: the degrees of freedom, f = n - m."""
        n, m = len(self.given.names), len(self.given.Phi)
        reason = (
            f"{'1 body has' if len(self.bodies) == 1 else f'{len(self.bodies)} bodies have'} {n} "
            f"coordinates; {m} constraints leave {n - m} of "
            "them free, if none follows from the others."
        )
        return Step("Degrees of freedom", reason, (eq("f", ex.sub("n", "m"), ex.sub(n, m), n - m),))

    def rates(self) -> Step:
        """Step: the constraints on the rates, Φ_q q̇ = 0."""
        zero = eq(ex.d_dt(sym("Phi")), ex.mul(self.loops.phi_q, dotted("q", 1)), ex.ZERO)
        lines = [zero]
        for constraint in self.given.constraints:
            for k in constraint.rows:
                row = self.given.Phi_q[k]
                terms = [
                    ex.mul(self.show(x), name + RATE)
                    for x, name in zip(row, self.given.names, strict=True)
                    if not x.is_zero
                ]
                lines.append(
                    eq(ex.Symbol(f"Phi{k + 1}_d", "Φ", (str(k + 1),), 1), ex.add(*terms), ex.ZERO)
                )
        reason = (
            "Their time derivatives. A constraint has rates of the bodies that it joins and of no "
            "other, so that most of Φ_q is 0, however long the chain."
        )
        return Step("Velocity constraints", reason, tuple(lines), ("5.22",))

    # ------------------------------------------------------------ energies and forces
    def energies(self) -> Step:
        """Step: the energies T and V."""
        given, parts = self.given, []
        for m, name in zip(given.M, given.names, strict=True):
            if not m.is_zero:
                parts.append(ex.mul(HALF, self.layout.form(m), ex.power(name + RATE, 2)))
        lines = [eq("T", ex.add(*parts)), eq("V", self.show(given.potential))]
        if len(given.M) <= _WIDE:
            diagonal = ex.Function("diag", ex.arguments(*map(self.layout.form, given.M)))
            lines.append(eq("M", diagonal))
        reason = (
            "The squares of the coordinates' own rates, with masses and moments of inertia: no "
            "products, and no coordinate in T. Nowhere is M simpler; it is constant."
        )
        return Step("Energies", reason, tuple(lines), ("5.3", "5.4", "5.25"))

    def effort(self, i: int) -> Expression:
        """Torque or force along the coordinate of joint i: of the motor, minus friction, spring and
        rotor."""
        drive = self.s.show(drive_part(self.s, i))
        return self.s.motor(i) if drive == ex.ZERO else sym(f"Q{self.s.numbers[i]}")

    def efforts(self) -> Step:
        """Step: generalized forces of the motors, by virtual work."""
        s, lines = self.s, []
        for i, name in self.given.efforts.items():
            along = self.show(self.given.coordinate(i))
            turn = ex.neg_each(_turn_of(s.symbols.model, s.numbers[i])) if s.turns(i) else ex.ZERO
            lines.append(eq(s.coordinate(i), ex.add(along, turn)))
            if sym(name) != s.motor(i):
                drive = s.show(drive_part(s, i))
                lines.append(eq(name, ex.add(s.motor(i), ex.neg_each(drive))))
        reason = (
            "The motor of a joint works along the joint's coordinate, which is a function of the "
            "new ones: τ_i acts with τ_i ∂θ_i/∂q, a torque on its body and the opposite on the "
            "body before (d_i in the place of θ_i where it slides)."
            if lines
            else "There is no motor, and nothing else acts along a joint."
        )
        return Step("Forces along the coordinates", reason, tuple(lines), ("5.23",))

    def body(self, i: int) -> Step:
        """Step: the three equations of motion of one body."""
        given, n = self.given, self.s.numbers[i]
        lines = []
        for name in given.names_of(i):
            k = given.names.index(name)
            left = ex.mul(self.layout.form(given.M[k]), name + SECOND)
            lines.append(eq(left, self.show(given.forces[k])))
        reason = f"Lagrange's equation of x, y and φ of body {n}, M q̈ + Φ_qᵀ λ = Q, solved for M q̈."
        if i == self.bodies[0]:
            reason += (
                " They are Newton's equation and Euler's, about the centre of mass, with the "
                "forces in the joints as multipliers."
            )
        return Step(f"The equations of body {n}", reason, tuple(lines), ("5.23",))

    def meaning(self) -> Step:
        """Step: the force that each multiplier represents."""
        lines: list[Equation] = []
        for constraint in self.given.constraints:
            lines += self._forces(constraint)
        reason = (
            "The forces of the constraints are -Φ_qᵀ λ: those of a pin are its multipliers with "
            "the opposite sign. So the first kind gives the forces in the joints with the motion; "
            "the coordinates of joints leave them out."
        )
        return Step("Meaning of the multipliers", reason, tuple(lines))

    def _forces(self, constraint: Constraint) -> list[Equation]:
        s, given = self.s, self.given
        lam = [given.multipliers[k] for k in constraint.rows]
        i = constraint.body
        if constraint.loop is not None:
            return self._loop_forces(constraint)
        name = s.force_name(s.tree.bodies[i].parent, i)
        if s.turns(i):
            return [eq(name, ex.vector(*(self.show(-x) for x in lam)))]
        ux, uy, nx, ny = given.along(i)
        across = ex.vector(*(self.show(-x * lam[0]) for x in (nx, ny)))
        along = ex.vector(self.show(ux), self.show(uy))
        motor = ex.mul(self.effort(i), along)
        return [
            eq(name, ex.add(across, motor)),
            eq(s.moment_name(s.tree.bodies[i].parent, i), self.show(-lam[1])),
        ]

    def _loop_forces(self, constraint: Constraint) -> list[Equation]:
        loop, given = constraint.loop, self.given
        assert loop is not None
        force, moment = [given.symbols.zero()] * 2, given.symbols.zero()
        for k, e in zip(constraint.rows, given.equations_of(loop), strict=True):
            weight = -given.multipliers[k]
            force = [x + weight * y for x, y in zip(force, e.f, strict=True)]
            moment = moment + weight * e.n_b[0]
        lines = [eq(self.loops.force_name(loop), ex.vector(*map(self.show, force)))]
        if self.loops.moment_name(loop) != ex.ZERO:
            lines.append(eq(self.loops.moment_name(loop), self.show(moment)))
        return lines

    # ------------------------------------------------------------ solved
    def seconds(self) -> Step:
        """Step: the constraints on the accelerations, Φ_q q̈ = c."""
        rate = ex.Symbol("Phi_q_d", "Φ", ("q",), dots=1)
        rule = eq(
            ex.mul(self.loops.phi_q, dotted("q", 2)), ex.neg(ex.mul(rate, dotted("q", 1))), "c"
        )
        lines = [eq(entry("c", k), self.show(x)) for k, x in enumerate(self.given.c, 1)]
        reason = "Differentiated once more; c holds the products of rates."
        return Step("Acceleration constraints", reason, (rule, *lines), ("5.28",))

    def together(self) -> Step:
        """Step: all equations as one block system."""
        n, m = len(self.given.names), len(self.given.Phi)
        reason = (
            f"{n} equations of the bodies and {m} of the constraints, for {n} accelerations and "
            f"{m} multipliers. n holds what stands on the right above besides multipliers."
        )
        return Step(
            "Accelerations and multipliers together",
            reason,
            (block_system(),),
            ("5.27", "5.29"),
            result=True,
        )


class BackToJoints:
    """Absolute coordinates as functions of joint coordinates, and the equations in joint
    coordinates."""

    def __init__(self, s: Setting, given: AbsoluteCoordinates, loops: Loops):
        self.s, self.given, self.loops = s, given, loops

    @cached_property
    def placed(self) -> list[Trig]:
        """The absolute coordinates as polynomials in the joint coordinates."""
        s, found = self.s, []
        for i in self.given.bodies:
            found += [*map(s.symbols.element, s.centre_position(i)), self._angle(i)]
        return found

    def _angle(self, i: int) -> Trig:
        """The absolute angle φ as a sum of joint angles, without constant turns."""
        s, total = self.s, self.s.symbols.zero()
        while i >= 0:
            if s.turns(i):
                total = total + s.symbols.ring[s.coordinate(i)]
            i = s.tree.bodies[i].parent
        return total

    def _before(self, i: int) -> list[int]:
        """Indices of the joints on the path from body i to the ground."""
        found = []
        while i >= 0:
            found.append(self.s.numbers[i])
            i = self.s.tree.bodies[i].parent
        return found

    @cached_property
    def N(self) -> list[list[Trig]]:
        """The matrix N = ∂q/∂u of absolute coordinates q by joint coordinates u."""
        return [[x.derivative(name) for name in self.s.symbols.coordinates] for x in self.placed]

    @property
    def tau(self) -> list[Trig]:
        """The torques Nᵀ (M q̈ - weights - load) plus the loops' part; the joints' multipliers
        cancel."""
        s, zero = self.s, self.s.symbols.zero()
        needed: list[Trig] = []
        for i, k in zip(self.given.bodies, range(0, len(self.placed), 3), strict=True):
            second = [
                x.along(s.symbols.rates).along(s.symbols.rates) for x in self.placed[k : k + 3]
            ]
            m = s.mass(i)
            needed += [m * (a - g) for a, g in zip(second[:2], s.tree.gravity, strict=True)]
            needed.append(s.inertia(i) * second[2])
        tip = [s.symbols.element(x) for x in s.tip_position()] if s.load else []
        found = []
        for i in s.order:
            j = s.index(i)
            total = sum((row[j] * x for row, x in zip(self.N, needed, strict=True)), zero)
            total = total + drive_part(s, i)
            if s.tree.loops:
                total = total + self.loops.system.pressed[j]
            if tip:
                slopes = tuple(x.derivative(s.coordinate(i)) for x in tip)
                total = total - dot(slopes, s.load_components)
            found.append(s.symbols.element(total))
        return found

    def step(self) -> Step:
        """Step: absolute coordinates q by the joint coordinates, and N."""
        s = self.s
        names = self.given.names
        lines = []
        for i, k in zip(self.given.bodies, range(0, len(names), 3), strict=True):
            x, y, phi = map(s.show_moved, self.placed[k : k + 3])
            turn = _turn_of(s.symbols.model, *self._before(i))
            rows = zip(names[k : k + 3], (x, y, ex.add(phi, turn)), strict=True)
            lines += [eq(name, value) for name, value in rows]
        u = ex.Vector(tuple(map(sym, s.symbols.coordinates)))
        lines += [eq("u", u), eq(dotted("q", 1), ex.mul("N", dotted("u", 1)))]
        lines += self.loops.matrix(sym("N"), self.N)
        reason = (
            "The coordinates of the joints, u, satisfy the constraints of the joints by "
            "themselves. N holds the derivatives of q by them."
        )
        return Step(
            "Back to the coordinates of the joints",
            reason + self.loops.unlisted(self.N),
            tuple(lines),
        )

    def result(self) -> Step:
        """Step: the torques, by Nᵀ times the equations."""
        s = self.s
        N_t = ex.transposed("N")
        loops = s.tree.loops
        pressed = ex.mul(N_t, ex.transposed(self.loops.phi_q))
        needed, given = ex.mul(N_t, "M", dotted("q", 2)), ex.mul(N_t, "n")
        if loops:
            lines = [eq(ex.add(needed, ex.mul(pressed, "lam")), given)]
        else:
            lines = [eq(pressed, ex.ZERO), eq(needed, given)]
        lines += [eq(s.motor(i), s.show(x)) for i, x in zip(s.order, self.tau, strict=True)]
        reason = (
            "The forces in the joints do no work in the motions that the joints allow: multiplied "
            f"by Nᵀ, {'their multipliers' if loops else 'all multipliers'} leave, with q̈ = N ü + "
            "Ṅ u̇ put in. What remains are "
        )
        reason += (
            "the equations of the first kind in the coordinates of the joints, with the forces in "
            "the loops alone."
            if loops
            else "Lagrange's equations of the second kind."
        )
        return Step(
            "Without the forces in the joints", reason, tuple(lines), ("5.24",), result=True
        )


def _turn_of(model: Model, *joints: int) -> Expression:
    """The constant angle of the placements of some joints, without whole turns."""
    number, named = 0.0, []
    for n in joints:
        for step in model.bodies[n - 1].joint.placement.steps:
            if isinstance(step, Rotate):
                number += math.atan2(step.matrix[1][0], step.matrix[0][0])
            elif isinstance(step, AxisRotation):
                if isinstance(step.angle, Parameter):
                    named.append(sym(step.angle.name))
                elif isinstance(step.angle, int | float):
                    number += step.angle
    return ex.add(_as_angle(math.remainder(number, 2 * math.pi)), *named)


def _as_angle(x: float) -> Expression:
    """An angle in radians as an expression, a fraction of π if it is one."""
    part = Fraction(x / math.pi).limit_denominator(12)
    if abs(x - part * math.pi) > 1e-9:
        return ex.num(Fraction(x), decimal=True)
    above = ex.mul(part.numerator, sym("pi"))
    return ex.div(above, part.denominator)
