"""Lagrange's equations of the second kind: energies, the Lagrangian, and one equation a coordinate
(5.6-5.20, 6.15)."""

from __future__ import annotations

from freebody.algorithms.kinematics import outward
from freebody.derivations import expression as ex
from freebody.derivations.derivation import Derivation, Step
from freebody.derivations.expression import Equation, eq
from freebody.derivations.methods.setting import Setting
from freebody.derivations.names import sym, vec
from freebody.derivations.symbols import RATE
from freebody.scalars.trig import Trig
from freebody.spatial import dot, neg

HALF = ex.div(1, 2)


def derive(setting: Setting) -> Derivation:
    """The derivation by energies."""
    slow = _Slow(setting)
    kinetic = [slow.kinetic(i) for i in setting.order]
    potential = [slow.potential(i) for i in setting.order]
    L = slow.total(kinetic) - slow.total(potential) - slow.springs() + slow.rotors()
    steps = [
        slow.coordinates(),
        slow.angular_velocities(),
        slow.positions(),
        slow.velocities(),
        slow.energies("T", kinetic),
        slow.energies("V", potential),
        slow.lagrangian(L),
    ]
    tau = []
    for i in setting.order:
        more, torque = slow.equation(i, L)
        steps += more
        tau.append(torque)
    steps.append(slow.closed_form())
    title = "Lagrange's equations of the second kind"
    return Derivation("lagrange", title, setting.equations, tuple(steps), tuple(tau))


class _Slow:
    """The steps, one method each; accelerations do not occur before the last."""

    def __init__(self, setting: Setting):
        zero = tuple(0.0 for _ in setting.symbols.qd)
        self.setting = setting
        self.motion = outward(setting.tree, setting.symbols.q, setting.symbols.qd, zero)

    def total(self, parts: list[Trig]) -> Trig:
        """Sum, 0 of none."""
        result = self.setting.symbols.zero()
        for part in parts:
            result = result + part
        return result

    def coordinates(self) -> Step:
        s = self.setting
        names = ex.Vector(tuple(sym(s.coordinate(i)) for i in s.order))
        forces = ex.Vector(tuple(s.torque_name(i) for i in s.order))
        return Step(
            "Choose independent coordinates",
            "The joint variables fix the pose of every body and can be varied one by one; the force that "
            "works along each is its joint's torque (or force, where the joint slides).",
            (eq(sym("q"), names), eq(sym("Q"), forces)),
            figure="kinematics",
        )

    def angular_velocities(self) -> Step:
        s = self.setting
        lines = []
        for i in s.order:
            parent = s.tree.bodies[i].parent
            before = s.angular_name("omega", parent) if parent >= 0 else None
            rate = sym(s.coordinate(i) + RATE)
            own = rate if s.planar else ex.mul(rate, s.name("z", i))
            chain = [x for x in (before, own if s.turns(i) else None) if x is not None]
            middle = ex.add(*chain) if chain else ex.ZERO
            value = s.angular(self.motion.w[i])
            lines.append(_line(s.angular_name("omega", i), middle, value))
        return Step(
            "Angular velocities",
            "A revolute joint adds its rate to the angular velocity of the body before it; a prismatic "
            "joint adds nothing.",
            tuple(lines),
            ("4.1", "5.8", "5.9") if s.planar else ("6.16", "6.24"),
        )

    def positions(self) -> Step:
        s = self.setting
        lines = [eq(s.name("rc", i), s.column(s.centre_position(i))) for i in s.order]
        return Step(
            "Positions of the centres of mass",
            "The energies need where each centre of mass is and how fast it moves; positions follow from "
            "the drawing.",
            tuple(lines),
            figure="kinematics",
        )

    def velocities(self) -> Step:
        s = self.setting
        lines = [
            eq(s.name("vc", i), ex.d_dt(s.name("rc", i)), s.column(s.centre_velocity(i)))
            if s.planar
            else eq(s.name("vc", i), s.column(s.centre_velocity(i)))
            for i in s.order
        ]
        where = "" if s.planar else " Components are those of the body's own axes."
        return Step(
            "Velocities of the centres of mass",
            "Differentiating the positions with respect to time gives the velocities." + where,
            tuple(lines),
            ("5.10",) if s.planar else ("6.19", "6.26"),
        )

    def kinetic(self, i: int) -> Trig:
        s = self.setting
        v, w = s.centre_velocity(i), self.motion.w[i]
        square = s.mass(i) * dot(v, v) + dot(w, s.tree.space.inertia_times(s.inertia(i), w))
        return s.symbols.element(square) * 0.5

    def potential(self, i: int) -> Trig:
        s = self.setting
        weight = s.mass(i) * dot(neg(s.tree.gravity), s.centre_position(i))
        return s.symbols.element(weight)

    def springs(self) -> Trig:
        """Energy of the joints' springs."""
        s, total = self.setting, self.setting.symbols.zero()
        for body in s.tree.bodies:
            if body.drive is not None:
                (q,) = body.position(s.symbols.q)
                stretch = q - body.drive.rest
                total = total + 0.5 * body.drive.stiffness * (stretch * stretch)
        return total

    def rotors(self) -> Trig:
        """Kinetic energy of the drives' rotors."""
        s, total = self.setting, self.setting.symbols.zero()
        for body in s.tree.bodies:
            if body.drive is not None:
                (rate,) = body.rates(s.symbols.qd)
                total = total + 0.5 * body.drive.rotor * (rate * rate)
        return total

    def energies(self, letter: str, values: list[Trig]) -> Step:
        s = self.setting
        lines = []
        for i, value in zip(s.order, values, strict=True):
            n = s.numbers[i]
            if letter == "T":
                v, w = s.name("vc", i), s.angular_name("omega", i)
                spin = (
                    ex.mul(HALF, f"I{n}", ex.power(w, 2))
                    if s.planar
                    else ex.mul(HALF, ex.dot(w, ex.mul(f"I{n}", w)))
                )
                rule = ex.add(ex.mul(HALF, f"m{n}", ex.dot(v, v)), spin)
            else:
                rule = ex.neg(ex.mul(f"m{n}", ex.dot(vec("g"), s.name("rc", i))))
            lines.append(eq(f"{letter}{n}", rule, s.show(value)))
        return Step(*_ENERGY[letter], tuple(lines), _ENERGY_NOTES[letter, s.planar])

    def lagrangian(self, L: Trig) -> Step:
        s = self.setting
        numbers = [s.numbers[i] for i in s.order]
        rule = ex.sub(ex.add(*(f"T{n}" for n in numbers)), ex.add(*(f"V{n}" for n in numbers)))
        extra = " Rotors add their kinetic, springs their elastic energy." if self.has_drives() else ""
        return Step(
            "The Lagrangian",
            "Kinetic minus potential energy holds all of the robot's dynamics." + extra,
            (eq("L", rule, s.show(L)),),
            ("5.6",),
        )

    def has_drives(self) -> bool:
        return any(body.drive is not None for body in self.setting.tree.bodies)

    def equation(self, i: int, L: Trig) -> tuple[list[Step], Trig]:
        """The three derivatives and the equation of one coordinate."""
        s = self.setting
        x = s.coordinate(i)
        by_rate, by_position = L.derivative(x + RATE), L.derivative(x)
        moved = by_rate.along(s.symbols.rates)
        drive = s.equations.drives[s.tree.bodies[i].coordinates.v[0]] - self._spring_torque(i)
        torque = moved - by_position + drive
        slope = ex.partial("L", x + RATE)
        lines = (
            eq(slope, s.show(by_rate)),
            eq(ex.d_dt(slope), s.show(moved)),
            eq(ex.partial("L", x), s.show(by_position)),
        )
        left = ex.sub(ex.d_dt(slope), ex.partial("L", x))
        right = s.torque_name(i)
        if not drive.is_zero:
            right = ex.sub(right, s.show(drive))
        number = {1: "5.15", 2: "5.16"}.get(s.numbers[i]) if s.planar else "6.15"
        return [
            Step(
                f"Derivatives for {sym(x)}",
                "Rates and coordinates count as independent in the partial derivatives; the time "
                "derivative brings the "
                "accelerations in.",
                lines,
            ),
            Step(
                f"The equation of {sym(x)}",
                "Lagrange's equation for this coordinate"
                + (", friction acting besides the motor." if not drive.is_zero else "."),
                (eq(left, right), eq(s.torque_name(i), s.show(torque))),
                ("5.7", number) if number else ("5.7",),
            ),
        ], torque

    def _spring_torque(self, i: int) -> Trig:
        """What of the drive's torque the Lagrangian already holds."""
        s = self.setting
        return self.springs().derivative(s.coordinate(i))

    def closed_form(self) -> Step:
        return closed_form(self.setting)


_ENERGY = {
    "T": (
        "Kinetic energies",
        "A rigid body's kinetic energy is that of its mass moving with the centre plus that of turning "
        "about it.",
    ),
    "V": (
        "Potential energies",
        "A weight's potential energy is its work against gravity, zero at the base's origin.",
    ),
}
_ENERGY_NOTES = {
    ("T", True): ("5.3", "5.11", "5.13", "5.17", "5.19"),
    ("T", False): ("5.3",),
    ("V", True): ("5.4", "5.12", "5.20"),
    ("V", False): ("5.4",),
}


def _line(name: ex.Expression, rule: ex.Expression, value: ex.Expression) -> Equation:
    return eq(name, value) if rule == value else eq(name, rule, value)


def closed_form(setting: Setting) -> Step:
    """The last step of every method: torques sorted by accelerations, rates and gravity."""
    equations = setting.equations
    is_2r = setting.planar and len(setting.order) == 2 and all(map(setting.turns, setting.order))
    lines = tuple(line for group in equations.groups("named") for line in group) if equations.is_short else ()
    counts = equations.count()
    reason = (
        "Sorting by accelerations, products of rates and the rest gives the mass matrix, the velocity "
        "terms and gravity."
        if lines
        else f"Sorted by accelerations, rates and the rest the closed form has {counts['M']} terms in M, "
        f"{counts['c']} in the velocity terms and {counts['g']} in gravity: too long to read, and exact."
    )
    numbers = ("3.20", "3.21", "3.22", "3.23", "3.24", "3.25", "3.26", "3.27") if is_2r else ("3.28",)
    return Step("The closed form", reason, lines, numbers)
