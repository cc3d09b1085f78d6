"""Kane's method: partial velocities, and generalized active and inertia forces whose sum is zero.

T. R. Kane and D. A. Levinson, Dynamics: Theory and Applications, McGraw-Hill, 1985, sections 2.12
(generalized speeds), 2.14 (partial velocities), 4.4 and 4.11 (generalized forces), 6.1 (the
equations). The generalized speeds are here the rates of the joints, so that the equations are those
of the other methods.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import sym, vec
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, dot, scale
from freebody_textbook.derivation import Meaning, Method, Step, Worked
from freebody_textbook.methods import glossary, step_reasons
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import geometry, joints, motion


def work_out(setting: Setting) -> Worked:
    """Derive the equations of motion by Kane's method: each joint's generalized forces add up to
    zero."""
    s = setting
    joints = [_JointRate(s, i) for i in s.leaders]
    steps = [_speeds(s), geometry(s), *motion(s), _inertia_forces(s)]
    for joint in joints:
        steps += [joint.partial_velocities(), joint.forces(), joint.equation()]
    steps += ending(s)
    return Worked(tuple(steps), tuple(joint.torque for joint in joints), _symbols(s))


def _speeds(s: Setting) -> Step:
    rates = ex.Vector(tuple(sym(s.coordinate(i) + RATE) for i in s.leaders))
    many = (
        "The generalized speeds describe the motion, one for each degree of freedom. The rates of "
        "the joints are chosen: velocities are linear in them, and each can be varied alone."
    )
    one = (
        "One generalized speed describes the motion of one degree of freedom. "
        "The rate of the joint is chosen."
    )
    reason = (one if len(s.leaders) == 1 else many) + step_reasons.motorless(s)
    return Step("Choose generalized speeds", reason, (eq(vec("q_d"), rates),))


def _inertia_forces(s: Setting) -> Step:
    lines = []
    for i in s.weighted:
        lines.append(eq(s.name("fc", i), s.mass_times(i, s.name("vc", i, "_d"))))
        if not s.is_point(i):
            lines.append(eq(s.angular_name("nc", i), s.spin_terms(i)))
    return Step(
        "Inertia forces of the bodies",
        "By d'Alembert's principle the motion of a body counts as a load on it: an inertia force "
        "at its centre of mass, the opposite of f_ci, and an inertia torque, the opposite of the "
        "rate of its angular momentum.",
        tuple(lines),
    )


class _JointRate:
    """The steps for the rate of body i's joint, with their values."""

    def __init__(self, s: Setting, i: int):
        self.s, self.i, self.number, self.speed = s, i, s.numbers[i], s.index(i) + 1
        self.is_first = i == s.leaders[0]
        self.rate = s.coordinate(i) + RATE
        self.centres = {k: self._partial(s.centre_velocity(k)) for k in s.weighted}
        self.turning = {k: self._partial(s.motion.w[k]) for k in s.weighted if not s.is_point(k)}

    def _partial(self, velocity: Iterable) -> Vector:
        """The coefficients of the rate in a velocity; in space body axes do not depend on rates."""
        return tuple(self.s.symbols.element(x).derivative(self.rate) for x in velocity)

    # ------------------------------------------------------------ partial velocities
    def partial_velocities(self) -> Step:
        """Step: the partial velocities that are not zero."""
        s, lines = self.s, []
        for k in s.weighted:
            if k in self.turning and _some(self.turning[k]):
                whole = ex.partial(s.angular_name("omega", k), self.rate)
                lines.append(eq(self._omega(k), whole, s.angular(self.turning[k])))
            if _some(self.centres[k]):
                lines.append(
                    eq(
                        self._v(k),
                        ex.partial(s.name("vc", k), self.rate),
                        s.column(self.centres[k]),
                    )
                )
        if s.load and _some(self._tip()):
            lines.append(eq(self._tip_name(), s.column(self._tip())))
        what = f"They describe how the bodies move when only {self._moved} at unit rate"
        if self.is_first:
            what = (
                f"A partial velocity is the factor of one joint's rate in the velocity of a point, "
                f"a partial angular velocity its factor in the angular velocity of a body. {what}"
            )
        rest = "; those that are not listed are zero" if self.s.leaders[1:] else ""
        figure = f"partial {self.number}" if any(map(_some, self.centres.values())) else None
        return Step(
            f"Partial velocities: joint {self.number}",
            f"{what}{rest}.",
            tuple(lines),
            figure=figure,
        )

    @property
    def _moved(self) -> str:
        """Phrase for what the joint moves, with the comma before its rate."""
        if self.s.is_alone(self.i):
            return f"joint {self.number} moves,"
        return f"{joints(self.s, self.i)} move, joint {self.number}"

    def _v(self, k: int) -> Expression:
        """Symbol of the partial velocity of body k's centre of mass, v_ck,r."""
        n, r = self.s.numbers[k], self.speed
        return ex.Symbol(f"vc{n}_{r}", "v", (f"c{n}", str(r)), bold=True)

    def _omega(self, k: int) -> Expression:
        """Symbol of the partial angular velocity of body k, ω_k,r."""
        n, r = self.s.numbers[k], self.speed
        return ex.Symbol(f"omega{n}_{r}", "ω", (str(n), str(r)), bold=not self.s.planar)

    def _tip(self) -> Vector:
        """The tip's partial velocity ∂ṙ_P/∂q̇_r = ∂r_P/∂q_r in world axes, like the load."""
        s = self.s
        return tuple(
            s.symbols.element(x).derivative(s.coordinate(self.i)) for x in s.tip_position()
        )

    def _tip_name(self) -> Expression:
        return ex.partial(vec("r_P_d"), self.rate)

    # ------------------------------------------------------------ generalized forces
    def forces(self) -> Step:
        """Step: the generalized active force and the generalized inertia force."""
        s = self.s
        active = ex.add(
            s.motor(self.i), *self._active_terms(), ex.neg_each(s.show(self._resisting))
        )
        value = ex.add(s.motor(self.i), s.show(self._active))
        inertia = ex.add(*map(ex.neg, self._inertia_terms()), ex.neg_each(s.show(self._rotor)))
        lines = (
            ex.chain(self.active_name, active, value),
            ex.chain(self.inertia_name, inertia, s.show(self._inertia)),
        )
        return Step(f"Generalized forces: joint {self.number}", self._forces_reason(), lines)

    def _forces_reason(self) -> str:
        s = self.s
        acting = [f"the {s.words(self.i).effort} of the motor"] if s.driven(self.i) else []
        acting += ["the weights"] if s.weighs else []
        acting += ["the load on the tip"] if s.load else []
        acting += (
            [f"friction and springs of {self._resisted}"] if not self._resisting.is_zero else []
        )
        found = listed(acting) or "nothing"
        if not self.is_first:
            return (
                f"The same sums with the partial velocities of joint {self.number}; "
                f"in the active force: {found}."
            )
        return (
            f"The generalized active force F_{self.speed} is the sum of all forces, each times "
            f"the partial velocity of the point where it acts, and of all torques, each times the "
            f"partial angular velocity of its body; in it: {found}. The reactions in the joints do "
            f"not occur, for together they do no work in any motion of the joints. The generalized "
            f"inertia force is the same sum over the inertia forces and torques."
        )

    @property
    def _resisted(self) -> str:
        return "the joint" if self.s.is_alone(self.i) else joints(self.s, self.i)

    @property
    def active_name(self) -> Expression:
        """Symbol F_r of the generalized active force."""
        return sym(f"F{self.speed}")

    @property
    def inertia_name(self) -> Expression:
        """Symbol F*_r of the generalized inertia force."""
        return ex.Symbol(f"F{self.speed}_star", "F", (str(self.speed),), high="*")

    def _active_terms(self) -> Iterator[Expression]:
        """Terms of weights and load in the generalized active force."""
        s = self.s
        for k in s.weighted if s.weighs else ():
            if _some(self.centres[k]):
                yield ex.dot(s.mass_times(k, vec("g")), self._v(k))
        if s.load and _some(self._tip()):
            yield ex.dot(vec("f"), self._tip_name())

    def _inertia_terms(self) -> Iterator[Expression]:
        s = self.s
        for k in s.weighted:
            if _some(self.centres[k]):
                yield ex.dot(s.name("fc", k), self._v(k))
            if k in self.turning and _some(self.turning[k]):
                join = ex.mul if s.planar else ex.dot
                yield join(s.angular_name("nc", k), self._omega(k))

    @property
    def _resisting(self) -> Trig:
        """Torque of friction and spring at the joint."""
        return self.s.equations.drives[self.s.index(self.i)]

    @property
    def _rotor(self) -> Trig:
        return self.s.rotor_part(self.i)

    @property
    def _active(self) -> Trig:
        """Generalized active force F_r without the motor."""
        s, total = self.s, -self._resisting
        for k in s.weighted if s.weighs else ():
            total = total + dot(scale(s.mass(k), s.gravity(k)), self.centres[k])
        if s.load:
            total = total + dot(s.load_components, self._tip())
        return s.symbols.element(total)

    @property
    def _inertia(self) -> Trig:
        """Generalized inertia force F*_r of the rate."""
        s, total = self.s, -self._rotor
        for k in s.weighted:
            total = total - dot(scale(s.mass(k), s.centre_acceleration(k)), self.centres[k])
            if k in self.turning:
                spin = s.tree.space.euler(s.inertia(k), s.motion.w[k], s.motion.wd[k])
                total = total - dot(spin, self.turning[k])
        return s.symbols.element(total)

    # ------------------------------------------------------------ the equation
    @property
    def torque(self) -> Trig:
        """The torque or force of the joint's motor."""
        return -self._active - self._inertia

    def equation(self) -> Step:
        """Step: Kane's equation of the rate, F_r + F*_r = 0."""
        s = self.s
        motor = f"this gives the {s.words(self.i).effort} of the motor"
        if not s.driven(self.i):
            motor = "the joint has no motor, so that this is an equation of motion"
        return Step(
            f"Kane's equation: joint {self.number}",
            f"The active and the inertia force of joint {self.number} add up to zero; {motor}.",
            (
                eq(ex.add(self.active_name, self.inertia_name), ex.ZERO),
                eq(s.motor(self.i), s.show(self.torque)),
            ),
        )


def _some(v: Vector) -> bool:
    """Whether a vector of polynomials is not zero."""
    return not all(x.is_zero for x in v)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}")
    yield from meanings(s, "fc{n}", "Mc{n}")
    yield Meaning(
        (sym("v_ci,r", True),), "factor of joint r's rate in v_ci: a partial velocity", "m or 1"
    )
    yield Meaning(
        (sym("omega_i,r", not s.planar),), "the same for ω_i: a partial angular velocity", "1"
    )
    unit = "N m" if all(map(s.turns, s.order)) else "N m or N"
    star = ex.Symbol("F_r_star", "F", ("r",), high="*")
    yield Meaning((sym("F_r"), star), "generalized active and inertia force of joint r", unit)
    if s.load:
        yield Meaning((vec("r_P"),), "position of the tip, from the base's origin", glossary.METER)


METHOD = Method(
    "kane",
    "Kane's equations",
    "partial velocities, generalized active and inertia forces, which add up to zero",
    "Kane and Levinson, Dynamics: Theory and Applications, 1985",
    work_out,
    reference="T. R. Kane and D. A. Levinson, Dynamics: Theory and Applications, McGraw-Hill, 1985",
    aliases=("kanes-equations",),
)
