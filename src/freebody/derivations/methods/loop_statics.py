"""Equilibrium of a closed chain, free body by free body, what the loops do being forces sought
(2.41-2.49)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from freebody.algorithms import loop_constraints
from freebody.algorithms.kinematics import frame_pose
from freebody.derivations.closed_chains.statics import LoopStatics
from freebody.derivations.derivation import Meaning, Step
from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Equation, Expression, eq
from freebody.derivations.expressions.nodes import Words
from freebody.derivations.expressions.printed_names import entry, sym
from freebody.derivations.methods import glossary
from freebody.derivations.methods.cut_loops import LONG, Loops
from freebody.derivations.methods.equilibrium import Equilibrium
from freebody.derivations.methods.geometry import geometry
from freebody.derivations.methods.method import Worked
from freebody.derivations.methods.reactions import SolvedReactions
from freebody.derivations.methods.setting import Setting
from freebody.errors import listed
from freebody.lazy import cached_property
from freebody.model.tree import TreeLoop
from freebody.spatial import Vector, sub


def work_out(setting: Setting) -> Worked:
    """The steps; planar chains only."""
    loops = Loops(setting)
    work = _Balance(setting, loops, _LoopReactions(setting, loops))
    steps = [work.convention()] if setting.load else []
    steps += [work.forces(), *map(work.body, setting.order), work.geometry()]
    steps += [*work.passive(), work.torques(), work.reactions_step()]
    torques = tuple(work.reactions.motor(i) for i in setting.order)
    sought = (
        "Sought: the motor torques and forces that hold the robot at rest, and the forces in the "
        "loops."
    )
    return Worked(tuple(steps), torques, _symbols(setting), sought=sought, system=work.system)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield Meaning((sym("lam_k"),), "multiplier of loop equation k: the loop's constraint force", "")
    yield glossary.joint_forces()
    yield from glossary.joint_moments(s)


class _LoopReactions(SolvedReactions):
    """Reactions with the loops' wrenches on the bodies."""

    def __init__(self, setting: Setting, loops: Loops):
        self.loads = loop_constraints.loop_loads(
            loops.equations.tree, setting.symbols.q, tuple(loops.system.multipliers)
        )
        super().__init__(setting)

    def applied(self, i: int) -> Iterable[tuple[Vector, Vector]]:
        yield from super().applied(i)
        for body, force, moment in self.loads:
            if body == i:
                yield self.s.axes(i, force), moment


class _Balance(Equilibrium):
    """Forces and moments on each body add up to zero."""

    def __init__(self, setting: Setting, loops: Loops, reactions: SolvedReactions):
        super().__init__(setting, reactions)
        self.loops = loops

    @cached_property
    def system(self) -> LoopStatics:
        """The equations of the joints."""
        s = self.s
        needed = {s.index(i): self.reactions.motor(i) for i in s.order}
        passive = tuple(s.index(i) for i in s.order if not s.driven(i))
        return LoopStatics(self.loops.equations, needed, passive)

    # ------------------------------------------------------------ the bodies
    def forces(self) -> Step:
        """What replaces each loop."""
        lines = [line for loop in self.s.tree.loops for line in self.loops.force_lines(loop)]
        held = "; ".join(self.loops.holds(loop) for loop in self.s.tree.loops)
        rods = any(loop.closure.distance for loop in self.s.tree.loops)
        along = (
            " A massless rod transmits force only along its axis; λ is half its tension over its "
            "length."
            if rods
            else ""
        )
        reason = (
            f"The loops are cut: {held}. Each is replaced by the force of one body on the other "
            f"and its opposite; its components are the unknowns.{along}"
        )
        return Step("Cut the loops: their forces are the unknowns", reason, tuple(lines))

    def body(self, i: int) -> Step:
        """Equilibrium of one body, and what its motor gives of the moment or force at its joint."""
        s, step = self.s, super().body(i)
        if s.is_pin(i):
            return step
        motor = eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i)))
        return replace(step, equations=(*step.equations, motor))

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """Those of the tree, and the loops' forces."""
        found = super().outer(i)
        for loop, frame in self._ends(i):
            force = self.loops.force_name(loop)
            found.append((force if self.loops.acts(loop, i) else ex.neg(force), self.arm(i, frame)))
        return found

    def _ends(self, i: int) -> list[tuple[TreeLoop, str]]:
        """Loops that act on body i, and the frame at which: its own, or of a slide that of the
        second body, where the wrench is counted on both."""
        return [
            (loop, loop.frames[1] if loop.closure.slides else frame)
            for loop in self.s.tree.loops
            for frame, k in zip(loop.frames, self.loops.ends(loop), strict=True)
            if k == i
        ]

    def about(self, i: int) -> list[Expression]:
        """Moments about the joint, those of loops that carry moments included; forces at the joint
        have none."""
        s = self.s
        terms = [
            ex.neg(ex.cross(s.reach_name(i, k), s.force_name(i, k))) for k in s.tree.children(i)
        ]
        for force, arm in self.outer(i):
            negative = isinstance(force, ex.Negative)
            moment = (
                ex.ZERO if arm == ex.ZERO else ex.cross(arm, force.operand if negative else force)
            )
            terms.append(ex.neg(moment) if negative and moment != ex.ZERO else moment)
        for loop, _ in self._ends(i):
            moment = self.loops.moment_name(loop)
            terms.append(moment if self.loops.acts(loop, i) else ex.neg(moment))
        return terms

    def arm(self, i: int, frame: str) -> Expression:
        """The way from joint i to a frame where a loop acts: 0 where it is the joint's own
        place."""
        if all(self.s.symbols.element(x).is_zero for x in self._way(i, frame)):
            return ex.ZERO
        if self._is_only_end(i, frame):
            return self.s.name("s", i)
        return self.s.naming.to_point(self.s.numbers[i], frame)

    def _is_only_end(self, i: int, frame: str) -> bool:
        """Whether loops and load act on body i at one point, and no further joint: s_i leads
        there."""
        ends = [f for _, f in self._ends(i)]
        ends += [self.s.symbols.model.frame().name] if self.s.loaded(i) else []
        places = [tuple(map(self.s.symbols.element, self._way(i, f))) for f in ends]
        here = tuple(map(self.s.symbols.element, self._way(i, frame)))
        return not self.s.tree.children(i) and all(place == here for place in places)

    def _way(self, i: int, frame: str) -> Vector:
        k, _, at = self.s.tree.frames[frame]
        if k == i:
            return self.s.axes(i, at)
        _, place = frame_pose(self.s.tree, self.s.world, frame)
        return sub(place, self.s.world[i][1])

    def geometry(self) -> Step:
        """The vectors, those to the loops' frames included."""
        step = geometry(self.s, inertias=False)
        lines: list[Equation] = list(step.equations)
        for i in self.s.order:
            for _, frame in self._ends(i):
                if self.arm(i, frame) != ex.ZERO:
                    lines.append(eq(self.arm(i, frame), self.s.column(self._way(i, frame))))
        others = any(len(getattr(line.lhs, "low", ())) > 1 for line in lines)
        more = "s_i,P points from joint i to a point P where a loop acts; " if others else ""
        reason = more + step.reason.replace("(or the tip)", "(or the tip, or where a loop acts)")
        return Step(step.operation, reason, tuple(dict.fromkeys(lines)), step.notes, step.figure)

    # ------------------------------------------------------------ solved
    def passive(self) -> list[Step]:
        """What passive joints do not carry gives the loops' forces."""
        s = self.s
        free = [i for i in s.order if not s.driven(i)]
        if not free:
            return []
        joints = listed([f"joint {s.numbers[i]}" for i in free])
        lines = [eq(s.show(self.reactions.motor(i)), ex.ZERO) for i in free]
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
        system, names = (
            self.system,
            [entry("lam", k) for k in range(1, len(self.loops.equations.names) + 1)],
        )
        if system.multipliers is None:
            reason = (
                f"There are {len(system.passive)} equations for {len(names)} multipliers: there "
                f"are more drives than degrees of freedom, so that the drives can work against "
                f"one another. As a system: A λ = k."
            )
            lines = [*self.loops.matrix(sym("A"), system.A), eq(ex.mul("A", "lam"), "k")]
            lines += [eq("k", ex.Vector(tuple(map(self.s.show, system.right))))]
            return Step("The forces in the loops", reason, tuple(lines))
        lines = [
            eq(name, self.loops.ratio(x)) for name, x in zip(names, system.multipliers, strict=True)
        ]
        reason = (
            "Linear equations, solved by determinants. Where the denominator vanishes the robot "
            "can move although its drives are locked (a singular position of the second type), "
            "and no finite forces give equilibrium."
        )
        return Step("The forces in the loops", reason, tuple(lines), result=True)

    def torques(self) -> Step:
        """τ of the motors."""
        s = self.s
        lines = []
        for i in s.order:
            if not s.driven(i):
                continue
            sides = [s.show(self.reactions.motor(i))]
            found = self.system.torque(s.index(i))
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
        lines = [
            eq(s.force_name(s.tree.bodies[i].parent, i), s.column(self.reactions.f[i]))
            for i in s.order
        ]
        lines += [
            eq(s.joint_moment(i), s.angular(self.reactions.n[i]))
            for i in s.order
            if not s.is_pin(i)
        ]
        reason = (
            "The balance of forces, from the last body inward, gives the force of the previous "
            "body on each."
        )
        return Step("The forces in the joints", reason, tuple(lines))
