"""Equilibrium of each body, and the torques that hold an arm still against gravity and a force on its tip
(2.41-2.49)."""

from __future__ import annotations

from freebody.algorithms.kinematics import jacobian
from freebody.derivations import expression as ex
from freebody.derivations.derivation import Derivation, Step
from freebody.derivations.expression import Expression, eq
from freebody.derivations.methods.newton_euler import Work
from freebody.derivations.methods.setting import Setting
from freebody.derivations.names import sym, vec
from freebody.scalars.trig import Trig
from freebody.spatial import dot


def derive(setting: Setting) -> Derivation:
    """The derivation; the setting is at rest."""
    work = _Still(setting)
    steps = [work.convention()] if setting.load else []
    steps += [work.bodies(i) for i in setting.order]
    tau: dict[int, Trig] = {}
    for i in reversed(setting.order):
        more, tau[i] = work.eliminated(i)
        steps += more
    if setting.load:
        steps.append(work.transpose())
    return Derivation(
        "statics", "Statics", setting.equations, tuple(steps), tuple(tau[i] for i in setting.order)
    )


class _Still(Work):
    """Newton and Euler without motion: forces and moments on each body add up to zero."""

    def inertia_force(self, i: int) -> Expression:
        return ex.ZERO

    def inertia_terms(self, i: int) -> Expression:
        return ex.ZERO

    def drive(self, i: int, k: int) -> Trig:
        """Springs only: what rests has no friction to overcome."""
        s, drive = self.s, self.s.tree.bodies[i].drive
        if drive is None:
            return s.symbols.zero()
        (q,) = s.tree.bodies[i].position(s.symbols.q)
        return s.symbols.element(drive.stiffness * (q - drive.rest))

    def numbered(self, n: int) -> tuple[str, ...]:
        return {1: ("2.46", "2.47"), 2: ("2.45", "2.48")}.get(n, ()) if self.s.planar else ()

    def convention(self) -> Step:
        """What f is."""
        return Step(
            "The load",
            "f acts on the arm at its tip. The force that the arm exerts on its surroundings is -f; "
            "formulas for the one "
            "and the other differ in sign.",
            (eq(vec("f"), ex.Vector(tuple(sym(name) for name in self.s.load))),),
            figure="kinematics",
        )

    def bodies(self, i: int) -> Step:
        n = self.s.numbers[i]
        return Step(
            f"Free body {n}",
            "In equilibrium the forces on each body add up to zero, and so do the moments about any point "
            "of it.",
            (eq(self.force_terms(i), ex.ZERO), eq(self.moment_terms(i), ex.ZERO)),
            {1: ("2.41", "2.42"), 2: ("2.43", "2.44")}.get(n, ()) if self.s.planar else (),
            figure=f"free-body {n}",
        )

    def transpose(self) -> Step:
        """The load's part as -Jᵀ f."""
        s = self.s
        J = [
            [s.symbols.element(x) for x in row]
            for row in jacobian(s.tree, s.symbols.q, s.symbols.model.frame().name)
        ]
        rows = J[: s.tree.space.dim]
        load = tuple(s.symbols.ring[name] for name in s.load)
        if s.planar:
            part = [dot(tuple(row[s.tree.bodies[i].coordinates.v[0]] for row in rows), load) for i in s.order]
            shown = ex.Vector(tuple(s.show(-x) for x in part))
        else:
            shown = ex.Words("")
        rule = ex.neg(ex.mul(ex.transposed(sym("J")), vec("f")))
        J_shown = ex.matrix([[s.show(x) for x in row] for row in rows])
        lines = [eq(sym("J"), J_shown)]
        lines.append(eq(sym("tau"), rule, shown) if s.planar else eq(sym("tau"), rule))
        return Step(
            "The load through the Jacobian",
            "Without weights the torques are -Jᵀ f: the virtual work of the load and of the motors "
            "cancels. The torque that "
            "exerts the force f on the surroundings is its opposite, Jᵀ f.",
            tuple(lines),
            ("2.49", "2.50"),
        )
