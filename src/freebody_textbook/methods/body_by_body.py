"""Newton's and Euler's equations of each body of a chain, the reactions named, eliminated, and
found for a motion (3.5-3.15)."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import vec
from freebody.scalars.trig import Trig
from freebody.spatial import scale, sub
from freebody_textbook.derivation import Step
from freebody_textbook.methods import step_reasons
from freebody_textbook.methods.cross_products import crossed
from freebody_textbook.methods.geometry import moment_of
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting

_BY_COMPONENTS = "First each cross product by components, a × b = a_x b_y - a_y b_x."


class FreeBodies:
    """The steps that name the reactions, eliminate them and put the motion in."""

    def __init__(self, setting: Setting, reactions: SolvedReactions, tau: dict[int, Trig]):
        self.s = setting
        self.reactions = reactions
        self.tau = tau

    def about_centres(self) -> list[Step]:
        """Two equations a body, then the reactions eliminated from the last body inward."""
        s = self.s
        return [*map(self.body, s.order), *map(self.eliminated, reversed(s.order))]

    # ------------------------------------------------------------ free bodies
    def body(self, i: int) -> Step:
        """Newton and Euler of one free body."""
        s, n = self.s, self.s.numbers[i]
        lines = (eq(self.forces(i), self.inertia_force(i)), eq(self.moments(i), s.spin_terms(i)))
        numbers = {
            ("R", 1): ("3.5", "3.6"),
            ("RR", 1): ("3.10", "3.11"),
            ("RR", 2): ("3.12", "3.13"),
        }.get((s.cited, n), ("3.1", "3.2") if s.planar else ("6.1", "6.2"))
        reason = step_reasons.free_body(s, i, self.told(i))
        return Step(f"Free body {n}", reason, lines, numbers, figure=f"free-body {n}")

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """Forces on body i from outside, weight apart, each with the way from its joint to where it
        acts."""
        return [(vec("f"), self.s.tip_name())] if self.s.loaded(i) else []

    def turned(self, i: int) -> list[Expression]:
        """Moments on body i from outside."""
        return []

    def told(self, i: int) -> list[str]:
        """What acts on body i besides joints, weight and load, in words."""
        return []

    def forces(self, i: int) -> Expression:
        """Forces on body i: by its parent, minus those on its children, its weight, those from
        outside."""
        s = self.s
        terms = [s.force_name(s.tree.bodies[i].parent, i)] if s.is_held(i) else []
        terms += [ex.neg(s.force_name(i, k)) for k in s.tree.children(i)]
        if s.weighs:
            terms.append(s.mass_times(i, vec("g")))
        return ex.add(*terms, *(force for force, _ in self.outer(i)))

    def moments(self, i: int) -> Expression:
        """Moments on body i about its centre of mass."""
        s = self.s
        arm, children = s.centre_name(i), s.tree.children(i)
        terms = [s.joint_moment(i), *(ex.neg(s.joint_moment(k)) for k in children)]
        if s.is_held(i):
            terms.append(ex.neg(ex.cross(arm, s.force_name(s.tree.bodies[i].parent, i))))
        for k in children:
            terms.append(ex.neg(ex.cross(ex.sub(s.reach_name(i, k), arm), s.force_name(i, k))))
        terms += [moment_of(force, ex.sub(at, arm)) for force, at in self.outer(i)]
        return ex.add(*terms, *self.turned(i))

    def inertia_force(self, i: int) -> Expression:
        """What the forces on body i add up to."""
        return self.s.mass_times(i, self.s.name("vc", i, "_d"))

    # ------------------------------------------------------------ elimination
    def left_over(self, i: int) -> str:
        """What is unknown when the reaction at joint i is eliminated, the motor's part aside."""
        return "nothing unknown"

    def passed(self, i: int) -> Expression:
        """The force at joint i without reactions: of body i and all that hangs on it, less what
        acts from outside."""
        s = self.s
        terms = [s.needed(i), *(self.passed(k) for k in s.tree.children(i))]
        return ex.add(*terms, *(ex.neg(force) for force, _ in self.outer(i)))

    def eliminated(self, i: int) -> Step:
        """The reaction at joint i from Newton's equation, put into Euler's."""
        s, n = self.s, self.s.numbers[i]
        lines = [
            eq(s.force_name(s.tree.bodies[i].parent, i), self.passed(i)),
            eq(s.joint_moment(i), self.held(i)),
        ]
        if not s.is_pin(i) and s.is_alone(i):
            lines.append(eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i))))
        numbers = {("R", 1): ("3.7",), ("RR", 1): ("3.15",), ("RR", 2): ("3.14",)}.get(
            (s.cited, n), ()
        )
        return Step(
            f"Eliminate the reactions at joint {n}",
            step_reasons.eliminated(s, i, self.left_over(i))
            + (step_reasons.drive(s, i) if s.is_alone(i) else ""),
            tuple(lines),
            numbers,
        )

    def held(self, i: int) -> Expression:
        """The moment at joint i with no reaction force in it."""
        s, children = self.s, self.s.tree.children(i)
        terms = [
            *map(s.joint_moment, children),
            s.spin_terms(i),
            ex.cross(s.centre_name(i), s.needed(i)),
        ]
        terms += [ex.cross(s.reach_name(i, k), self.passed(k)) for k in children]
        terms += [ex.neg(moment_of(force, arm)) for force, arm in self.outer(i)]
        return ex.add(*terms, *map(ex.neg, self.turned(i)))

    # ------------------------------------------------------------ values
    def crossed(self, i: int) -> Iterator[Equation]:
        """The cross products of the moment at joint i by components; none in space, nor of closed
        chains, whose forces have unknown parts."""
        s = self.s
        if not s.planar or s.tree.loops:
            return
        if i in s.weighted and s.column(s.centre(i)) != ex.ZERO:
            force = scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))
            yield crossed(s, (s.centre_name(i), s.centre(i)), (s.needed(i), force))
        for k in s.tree.children(i):
            if s.column(s.to_child(i, k)) != ex.ZERO:
                arm = s.reach_name(i, k), s.to_child(i, k)
                yield crossed(s, arm, (self.passed(k), self.reactions.f[k]))

    def substituted(self, i: int, reactions: bool) -> Step:
        """Reaction and torque at joint i, the motion put in."""
        s, n = self.s, self.s.numbers[i]
        lines = list(self.crossed(i))
        reason = "" if s.tree.children(i) or not lines else f"{_BY_COMPONENTS} "
        if reactions:
            (force, moment), pin = self.reactions.borne[i], s.is_pin(i)
            lines.append(eq(s.force_name(s.tree.bodies[i].parent, i), s.column(force)))
            if not pin:
                lines.append(eq(s.joint_moment(i), s.angular(moment)))
        if s.is_alone(i):
            lines.append(eq(s.motor(i), s.show(self.tau[i])))
        reason += step_reasons.substituted(s, i, reactions)
        if reactions:
            given = self.reactions.f[i] if pin else (*self.reactions.f[i], *self.reactions.n[i])
            left = force if pin else (*force, *moment)
            if any(not s.symbols.element(a - b).is_zero for a, b in zip(given, left, strict=True)):
                reason += " What vanishes by the equation of a joint without a motor is left out."
            reason += step_reasons.gyroscopic(s, i, self.reactions.n[i])
        return Step(f"Substitute the motion: joint {n}", reason, tuple(lines))
