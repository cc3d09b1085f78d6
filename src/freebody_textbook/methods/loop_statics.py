"""Equilibrium of a closed chain, free body by free body, what the loops do being forces sought
(2.41-2.49)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.nodes import Words
from freebody.expressions.printed_names import sym
from freebody.lazy import cached_property
from freebody_textbook.closed_chains.statics import LoopStatics
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import glossary
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import LONG, Loops
from freebody_textbook.methods.equilibrium import Equilibrium
from freebody_textbook.methods.loop_forces import FEW, LoopForces, LoopReactions, needs_of
from freebody_textbook.methods.method import Worked
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import Efforts


def work_out(setting: Setting) -> Worked:
    """The steps; planar chains only."""
    loops = Loops(setting)
    work = _Balance(setting, loops, LoopReactions(setting, loops))
    steps = [work.convention()] if setting.load else []
    bodies = [i for i in setting.order if i not in setting.links]
    steps += [work.forces.step(), *map(work.body, bodies), work.forces.geometry()]
    steps += [*work.passive(), work.torques(), work.reactions_step()]
    torques = tuple(work.reactions.motor(i) for i in setting.order)
    sought = (
        f"Sought: {Efforts.of(setting).holding} the robot at rest, and the forces in {loops.named}."
    )
    return Worked(tuple(steps), torques, _symbols(setting), sought=sought, system=work.system)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield glossary.multipliers(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


class _Balance(Equilibrium):
    """Forces and moments on each body add up to zero."""

    def __init__(self, setting: Setting, loops: Loops, reactions: SolvedReactions):
        super().__init__(setting, reactions)
        self.loops, self.forces = loops, LoopForces(setting, loops)

    @cached_property
    def system(self) -> LoopStatics:
        """The equations of the joints."""
        return needs_of(self.reactions, self.loops)

    # ------------------------------------------------------------ the bodies
    def body(self, i: int) -> Step:
        """Equilibrium of one body, and what its motor gives of the moment or force at its joint."""
        s, step = self.s, super().body(i)
        if s.is_pin(i):
            return step
        motor = eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i)))
        return replace(step, equations=(*step.equations, motor))

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """Those of the tree, and the loops' forces."""
        return [*super().outer(i), *self.forces.on(i)]

    def about(self, i: int) -> list[Expression]:
        """Moments about the joint, those of loops that carry moments included; forces at the joint
        have none."""
        return [*super().about(i), *self.forces.moments_on(i)]

    # ------------------------------------------------------------ solved
    def passive(self) -> list[Step]:
        """What passive joints do not carry gives the loops' forces."""
        s = self.s
        free = [i for i in s.order if not s.driven(i)]
        if not free:
            return []
        joints = listed([f"joint {s.numbers[i]}" for i in free])
        lines = [eq(ex.ZERO, s.show(self.reactions.motor(i))) for i in free]
        reason = (
            f"No motor acts at {joints}: on all the bodies that such a joint carries, the moments "
            f"about its axis (the forces along it, if it slides) add up to zero, springs "
            f"included. These equations contain no other unknowns."
        )
        return [
            Step("No torque or force at passive joints", reason, tuple(lines)),
            self._loop_forces(),
        ]

    def _loop_forces(self) -> Step:
        system, names = self.system, self.forces.unknowns
        title = f"The forces in {self.loops.named}"
        if len(names) > FEW:
            reason = (
                "As a system: A λ = k. It is solved with numbers; the quotients would fill pages. "
                "Where the determinant of A vanishes the robot can move although its drives are "
                f"locked (a singular position of the second type).{self.loops.unlisted(system.A)}"
            )
            lines = self.forces.system(system)
            return Step(title, reason, tuple(lines), result=True)
        if system.multipliers is None:
            reason = (
                f"There are {len(system.passive)} equations for {len(names)} multipliers: there "
                f"are more drives than degrees of freedom, so that the drives can work against "
                f"one another. As a system: A λ = k."
            )
            lines = [*self.loops.matrix(sym("A"), system.A), eq(ex.mul("A", "lam"), "k")]
            lines += [eq("k", ex.Vector(tuple(map(self.s.show, system.right))))]
            return Step(title, reason, tuple(lines))
        lines = [
            eq(name, self.loops.ratio(x)) for name, x in zip(names, system.multipliers, strict=True)
        ]
        reason = (
            "Linear equations, solved by determinants. Where the denominator vanishes the robot "
            "can move although its drives are locked (a singular position of the second type), "
            "and no finite forces give equilibrium."
        )
        return Step(title, reason, tuple(lines), result=True)

    def torques(self) -> Step:
        """τ of the motors."""
        s = self.s
        lines = []
        for i in s.order:
            if not s.driven(i):
                continue
            sides = [s.show(self.reactions.motor(i))]
            few = len(self.forces.unknowns) <= FEW
            found = self.system.torque(s.index(i)) if few else None
            if found is not None:
                shown = self.loops.ratio(found)
                sides += (
                    [shown] if not isinstance(shown, Words) and ex.size(shown) <= 2 * LONG else []
                )
            lines.append(ex.chain(s.motor(i), *sides))
        reason = (
            "The balance at the driven joints in terms of the multipliers, then with these "
            "substituted where the result is short."
        )
        return Step("Torques and forces of the motors", reason, tuple(lines), result=True)

    def reactions_step(self) -> Step:
        """Forces in the joints."""
        s = self.s
        held = [i for i in s.order if i not in s.links and s.is_held(i)]
        lines = [
            eq(s.force_name(s.tree.bodies[i].parent, i), s.column(self.reactions.borne[i][0]))
            for i in held
        ]
        lines += [
            eq(s.joint_moment(i), s.angular(self.reactions.borne[i][1]))
            for i in held
            if not s.is_pin(i)
        ]
        reason = (
            "The balance of forces, from the last body inward, gives the force of the previous "
            "body on each."
        )
        return Step("The forces in the joints", reason, tuple(lines))
