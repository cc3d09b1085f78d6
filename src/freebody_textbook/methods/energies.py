"""Kinetic and potential energies of an arm, and the steps that show them (5.1-5.5, 5.11-5.20)."""

from __future__ import annotations

from fractions import Fraction

from freebody.algorithms.energy import resting_energy
from freebody.algorithms.kinematics import BodyMotions
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, eq
from freebody.expressions.printed_names import vec
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import add, dot, times
from freebody_textbook.derivation import Step
from freebody_textbook.methods.geometry import measured
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.squared_speeds import speed_squared

HALF = ex.num(Fraction(1, 2))
FEW = 6
"""Terms of a v² up to which it is put in."""


class Energies:
    """The energies as polynomials; accelerations do not occur in them."""

    def __init__(self, setting: Setting, moving: BodyMotions):
        self.s = setting
        self.moving = moving

    def kinetic(self, i: int) -> Trig:
        """½ m v_c² + ½ ω · I ω of body i, of each of its parts."""
        space, v, w = self.s.tree.space, self.moving.v[i], self.moving.w[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            vc = add(v, space.cross(w, part.c))
            total = total + part.m * dot(vc, vc) + dot(w, space.inertia_times(part.inertia, w))
        return total * 0.5

    def potential(self, i: int) -> Trig:
        """-m g · r_c of body i, of each of its parts."""
        R, p = self.s.world[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            total = total - part.m * dot(self.s.tree.gravity, add(p, times(R, part.c)))
        return total

    @cached_property
    def springs(self) -> Trig:
        """Energy of the joints' springs."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                stretch = body.position(self.s.symbols.q)[0] - body.drive.rest
                total = total + 0.5 * body.drive.stiffness * (stretch * stretch)
        return total

    @cached_property
    def rotors(self) -> Trig:
        """Kinetic energy of the drives' rotors."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                (rate,) = body.rates(self.s.symbols.qd)
                total = total + 0.5 * body.drive.rotor * (rate * rate)
        return total

    @cached_property
    def resting(self) -> Trig:
        """-m g · r_c of what is fixed to the base: a constant."""
        return self.s.symbols.element(resting_energy(self.s.tree))

    @property
    def has_resting(self) -> bool:
        """Whether what is fixed to the base has a potential energy."""
        return not self.resting.is_zero

    @property
    def has_springs(self) -> bool:
        """Whether springs store energy."""
        return not self.springs.is_zero

    @property
    def has_rotors(self) -> bool:
        """Whether rotors do."""
        return not self.rotors.is_zero

    @property
    def has_potential(self) -> bool:
        """Whether there is any potential energy."""
        return self.s.weighs or self.has_springs

    @cached_property
    def total_potential(self) -> Trig:
        """V."""
        own = (self.potential(i) for i in self.s.weighted)
        return sum(own, self.resting + self.springs)

    @cached_property
    def lagrangian(self) -> Trig:
        """T - V."""
        total = sum((self.kinetic(i) for i in self.s.weighted), self.rotors)
        return total - self.total_potential


def kinetic_step(s: Setting, energies: Energies) -> Step:
    """½ m v² + ½ I ω² a body."""
    lines: list[Equation] = []
    for i in s.weighted:
        v, w = s.name("vc", i), s.angular_name("omega", i)
        inertia = s.inertia_name(i)
        spin = ex.mul(inertia, ex.power(w, 2)) if s.planar else ex.dot(w, ex.mul(inertia, w))
        turning = ex.ZERO if s.is_point(i) else ex.mul(HALF, spin)
        lines += measured(s, i, True)
        rule = ex.add(ex.mul(HALF, s.mass_name(i), ex.power(v, 2)), turning)
        line = s.with_value(f"T{s.numbers[i]}", rule, energies.kinetic(i))
        lines.append(_with_squares(s, i, energies, line))
    if energies.has_rotors:
        lines.append(eq("T_r", s.show(energies.rotors)))
    reason = (
        "The kinetic energy of a body is that of its mass moving with the centre of mass, plus "
        "that of its rotation about the centre of mass"
    )
    rotors = "; the motors' rotors add T_r" if energies.has_rotors else ""
    numbers = {"RR": ("5.3", "5.11", "5.13", "5.17", "5.19")}.get(s.cited, ("5.3",))
    return Step("Kinetic energies", f"{reason}{rotors}.", tuple(lines), numbers)


def _with_squares(s: Setting, i: int, energies: Energies, line: Equation) -> Equation:
    """T of a body of the plane with v² and ω² put in between, where these are sums."""
    v, w = speed_squared(s, i), s.angular(energies.moving.w[i])
    many = isinstance(v, ex.Sum) and len(v.terms) > FEW
    if not s.planar or v is None or many or not any(isinstance(x, ex.Sum) for x in (v, w)):
        return line
    turning = ex.ZERO if s.is_point(i) else ex.mul(HALF, s.inertia_name(i), ex.power(w, 2))
    put_in = ex.add(ex.mul(HALF, s.mass_name(i), v), turning)
    return eq(*line.sides[:2], put_in, *line.sides[2:])


def potential_step(s: Setting, energies: Energies) -> Step:
    """Weights, and springs where there are."""
    lines = [eq("V0", s.show(energies.resting))] if energies.has_resting else []
    for i in s.weighted if s.weighs else ():
        n = s.numbers[i]
        rule = ex.neg(s.mass_times(i, ex.dot(vec("g"), s.name("rc", i))))
        lines.append(s.with_value(f"V{n}", rule, energies.potential(i)))
    if energies.has_springs:
        lines.append(eq("V_s", s.show(energies.springs)))
    parts = (
        ["that of a weight is mass times gravity times height above the base's origin"]
        if s.weighs
        else []
    )
    parts += (
        ["that of what is fixed to the base, V_0, is the same at all times"]
        if energies.has_resting
        else []
    )
    parts += (
        ["that of a spring is half its stiffness times the square of its deflection"]
        if energies.has_springs
        else []
    )
    words = (
        "Potential energy: " + "; ".join(parts)
        if parts
        else "Without gravity and springs there is no potential energy"
    )
    numbers = (
        ("5.4", *({"RR": ("5.12", "5.14", "5.18", "5.20")}.get(s.cited, ()))) if s.weighs else ()
    )
    words += ". (The notes' (5.14) is misprinted; (5.20) is right.)" if "5.14" in numbers else "."
    return Step(
        "Potential energies",
        words,
        tuple(lines),
        (*numbers, *(["5.5"] if energies.has_springs else [])),
    )
