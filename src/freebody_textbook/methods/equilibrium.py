"""Equilibrium of each body: forces and moments, and the torques that follow (2.41-2.49)."""

from __future__ import annotations

from freebody.algorithms.kinematics import jacobian
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.printed_names import sym, vec
from freebody_textbook.derivation import Step
from freebody_textbook.methods.geometry import moment_of
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import Efforts, motorless


class Equilibrium:
    """Forces and moments on each body add up to zero; moments are taken about the body's joint."""

    def __init__(self, setting: Setting, reactions: SolvedReactions):
        self.s = setting
        self.reactions = reactions

    def convention(self) -> Step:
        """What f is."""
        robot = "robot" if self.s.tree.loops else "arm"
        return Step(
            "The load",
            f"f is the force on the {robot} at its tip P. What the {robot} exerts there on its "
            f"surroundings is -f; formulas for the one and for the other differ in sign.",
            (eq(vec("f"), ex.Vector(tuple(sym(name) for name in self.s.load))),),
        )

    def body(self, i: int) -> Step:
        """Equilibrium of one body."""
        s, n, children = self.s, self.s.numbers[i], self.s.tree.children(i)
        forces = [s.force_name(s.tree.bodies[i].parent, i)] if s.is_held(i) else []
        forces += [ex.neg(s.force_name(i, k)) for k in children]
        forces += [force for force, _ in self.outer(i)]
        moments = [s.joint_moment(i), *map(ex.neg, map(s.joint_moment, children)), *self.about(i)]
        where = " about its origin"
        if s.is_held(i):
            where = f"; about joint {n} the force there has none"
        reason = f"The forces on body {n} add up to zero, and so do the moments{where}."
        if not s.is_held(i):
            reason = f"No joint holds body {n}. {reason}"
        if s.cited == "RR" and s.weighs and n == 1:
            reason += (
                " (The notes leave the weights out: with g = 0 the numbered equations follow.)"
            )
        numbers = {("RR", 1): ("2.41", "2.42"), ("RR", 2): ("2.43", "2.44")}.get((s.cited, n), ())
        lines = (eq(ex.add(*forces), ex.ZERO), eq(ex.add(*moments), ex.ZERO))
        return Step(f"Free body {n}", reason, lines, numbers, figure=f"free-body {n}")

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """Forces on body i from outside, each with the way from its joint to where it acts."""
        s = self.s
        heavy = s.weighs and i in s.weighted
        weight = [(s.mass_times(i, vec("g")), s.centre_name(i))] if heavy else []
        return [*weight, *([(vec("f"), s.tip_name())] if s.loaded(i) else [])]

    def about(self, i: int) -> list[Expression]:
        """Moments of all other forces on body i about its joint."""
        s = self.s
        terms = [
            ex.neg(ex.cross(s.reach_name(i, k), s.force_name(i, k))) for k in s.tree.children(i)
        ]
        return [*terms, *(moment_of(force, arm) for force, arm in self.outer(i))]

    def solved(self, i: int) -> Step:
        """Reaction and torque of joint i, in terms of those before it."""
        s, n, children = self.s, self.s.numbers[i], self.s.tree.children(i)
        force = ex.add(
            *(s.force_name(i, k) for k in children),
            *(ex.neg(force) for force, _ in self.outer(i)),
        )
        moment = ex.add(*map(s.joint_moment, children), *map(ex.neg, self.about(i)))
        name = s.joint_moment(i)
        lines = [eq(s.force_name(s.tree.bodies[i].parent, i), force, s.column(self.reactions.f[i]))]
        lines.append(eq(name, moment))
        if not s.is_pin(i) and s.is_alone(i):
            lines.append(eq(s.motor(i), self.reactions.motor_rule(i, name)))
        numbers = {("RR", 1): ("2.46",), ("RR", 2): ("2.45",)}.get((s.cited, n), ())
        motor = (
            f" and the {s.words(i).effort} of its motor"
            if s.driven(i)
            else " and the torque or force there, which must be 0 because it has no motor"
        )
        motor = motor if s.is_alone(i) else ""
        reason = f"The two equations of body {n} give the reaction at joint {n}{motor}."
        return Step(f"Solve for joint {n}", reason, tuple(lines), numbers)

    def result(self, tau: dict) -> Step:
        """The torques written out."""
        s = self.s
        lines = tuple(eq(s.motor(i), s.show(tau[i])) for i in s.leaders)
        numbers = ("2.47", "2.48") if s.cited == "RR" else ()
        reason = f"Substituting the vectors gives {Efforts.of(s).holding} the arm at rest."
        if not all(map(s.driven, s.order)):
            reason += (
                f"{motorless(s)} The arm can be held only where the equation with 0 on the left "
                f"is satisfied."
            )
        return Step(
            Efforts.of(s).words.removeprefix("motor ").capitalize() or "The conditions",
            reason,
            lines,
            numbers,
            result=True,
        )

    def transpose(self) -> Step:
        """The load's part as -Jᵀ f."""
        s = self.s
        J = jacobian(s.tree, s.symbols.q, s.symbols.model.frame().name)
        rows = [[s.symbols.element(x) for x in row] for row in J[: s.tree.space.dim]]
        part = ex.neg(ex.mul(ex.transposed(sym("J")), vec("f")))
        weights = " The remaining terms balance the weights." if s.weighs else ""
        slips = (
            " (The notes print (2.49) to (2.52) without the minus: "
            "they are the torques that exert f.)"
        )
        return Step(
            "The load through the Jacobian",
            "The load's part of the torques is -Jᵀ f, J being the Jacobian of the tip: the virtual "
            "work of motors and "
            f"load cancels.{weights} The torque that exerts the force f on the surroundings is its "
            f"opposite, Jᵀ f." + (slips if s.cited == "RR" else ""),
            (
                eq(sym("J"), ex.matrix([[s.show_moved(x) for x in row] for row in rows])),
                eq(vec("tau_f"), part),
            ),
            ("2.19", "2.49", "2.50") if s.cited == "RR" else (),
        )
