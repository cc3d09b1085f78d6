"""Energies of a robot and the virtual work of a load, for Lagrange's equations (5.1-5.5)."""

from __future__ import annotations

from fractions import Fraction

from freebody.algorithms.energy import resting_energy
from freebody.algorithms.kinematics import BodyMotions
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import eq
from freebody.expressions.polynomials.arithmetic import inner
from freebody.expressions.printed_names import sym, vec
from freebody.lazy import cached_property
from freebody.model.drives import LAWS, DriveLaw
from freebody.scalars.trig import Trig
from freebody.spatial import add, dot, times
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting

HALF = ex.num(Fraction(1, 2))


class Energies:
    """The energies of a robot as polynomials without accelerations."""

    def __init__(self, setting: Setting, moving: BodyMotions):
        self.s = setting
        self.moving = moving

    def kinetic(self, i: int) -> Trig:
        """Kinetic energy ½ m v_c² + ½ ω · I ω of body i, summed over its parts."""
        space, v, w = self.s.tree.space, self.moving.v[i], self.moving.w[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            vc = add(v, space.cross(w, part.c))
            total = total + part.m * dot(vc, vc) + dot(w, space.inertia_times(part.inertia, w))
        return total * 0.5

    def potential(self, i: int) -> Trig:
        """Potential energy -m g · r_c of body i, summed over its parts."""
        R, p = self.s.world[i]
        total = self.s.symbols.zero()
        for part in self.s.tree.bodies[i].masses:
            total = total - part.m * dot(self.s.tree.gravity, add(p, times(R, part.c)))
        return total

    @cached_property
    def springs(self) -> Trig:
        """Potential energy stored by the drives' laws, such as springs."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                total = total + body.drive.energy(self.s.symbols.q)
        return total

    @cached_property
    def storing_laws(self) -> list[DriveLaw]:
        """The drive laws that store energy, each once, in the table's order."""
        acting = {
            x.law.name
            for body in self.s.tree.bodies
            for x in (() if body.drive is None else body.drive.laws)
            if not self.s.symbols.element(x.p[0]).is_zero
        }
        return [law for law in LAWS.values() if law.energy is not None and law.name in acting]

    @property
    def storing(self) -> str:
        """Phrase for the parts that store energy besides weights."""
        return listed(list(dict.fromkeys(f"{law.words}s" for law in self.storing_laws)))

    @property
    def stored(self) -> list[str]:
        """Sentences on the energies stored besides those of weights."""
        return [law.stored for law in self.storing_laws]

    @cached_property
    def rotors(self) -> Trig:
        """Kinetic energy of the drives' rotors."""
        total = self.s.symbols.zero()
        for body in self.s.tree.bodies:
            if body.drive is not None:
                (rate,) = body.rates(self.s.symbols.qd)
                total = total + 0.5 * body.drive.inertia * (rate * rate)
        return total

    @cached_property
    def resting(self) -> Trig:
        """Potential energy -m g · r_c of parts fixed to the base, a constant."""
        return self.s.symbols.element(resting_energy(self.s.tree))

    @property
    def has_resting(self) -> bool:
        """Whether parts fixed to the base have potential energy."""
        return not self.resting.is_zero

    @property
    def has_springs(self) -> bool:
        """Whether springs store energy."""
        return not self.springs.is_zero

    @property
    def has_rotors(self) -> bool:
        """Whether rotors have kinetic energy."""
        return not self.rotors.is_zero

    @property
    def has_potential(self) -> bool:
        """Whether there is any potential energy."""
        return self.s.weighs or self.has_springs

    @cached_property
    def total_potential(self) -> Trig:
        """Potential energy V of weights and springs."""
        own = (self.potential(i) for i in self.s.weighted)
        return sum(own, self.resting + self.springs)

    @cached_property
    def lagrangian(self) -> Trig:
        """Lagrange's function T - V."""
        total = sum((self.kinetic(i) for i in self.s.weighted), self.rotors)
        return total - self.total_potential


def virtual_work(s: Setting) -> tuple[Step, dict[int, Trig]]:
    """The step of virtual work, and the load's generalized force for each coordinate, f ·
    ∂r_P/∂q_i."""
    tip = [s.symbols.element(x) for x in s.tip_position()]
    lines = [
        eq(vec("f"), ex.Vector(tuple(map(sym, s.load)))),
        eq(vec("r_P"), s.column(tuple(tip))),
    ]
    works: dict[int, Trig] = {}
    for i in s.leaders:
        x = s.coordinate(i)
        works[i] = inner([position.derivative(x) for position in tip], s.load_components, s.symbols)
        part = ex.dot(vec("f"), ex.partial(vec("r_P"), x))
        motor = s.motor(i)
        lines.append(eq(f"Q{s.index(i) + 1}", ex.add(motor, part), ex.add(motor, s.show(works[i]))))
    reason = (
        "The work of motors and load in a small change of the coordinates, Σ τ_i δq_i + f · δr_P, "
        "is Σ Q_i δq_i: the load adds its component along the direction in which each coordinate "
        "moves the tip."
    )
    return Step("Generalized forces by virtual work", reason, tuple(lines)), works
