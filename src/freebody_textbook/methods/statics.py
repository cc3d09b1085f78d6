"""Statics: equilibrium of each body, and the torques that hold an arm against gravity and a force
on its tip (2.41-2.49)."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from freebody.algorithms.kinematics import jacobian
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression, eq
from freebody.expressions.nodes import Words
from freebody.expressions.printed_names import sym, vec
from freebody.lazy import cached_property
from freebody_textbook.closed_chains.statics import LoopStatics
from freebody_textbook.derivation import Meaning, Method, Step, Worked
from freebody_textbook.methods import glossary
from freebody_textbook.methods.body_by_body import SolvedReactions
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import LONG, Loops
from freebody_textbook.methods.loop_forces import FEW, LoopForces, LoopReactions, needs_of
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import geometry, moment_of, shared_motors
from freebody_textbook.methods.step_reasons import Efforts, motorless


def work_out(setting: Setting) -> Worked:
    """Derive the joint torques of a robot at rest. For closed chains see `_of_closed_chain`."""
    if setting.tree.loops:
        return _of_closed_chain(setting)
    reactions = SolvedReactions(setting)
    work = _Equilibrium(setting, reactions)
    tau = {i: reactions.motor(i) for i in setting.leaders}
    steps = [work.convention()] if setting.load else []
    steps += [*map(work.body, setting.order)]
    steps += [work.solved(i) for i in reversed(setting.order)]
    steps += [
        *shared_motors(setting, reactions.drives),
        geometry(setting, inertias=False),
        work.result(tau),
    ]
    if setting.load:
        steps.append(work.transpose())
    torques = tuple(tau.values())
    sought = f"Sought: {Efforts.of(setting).holding} the arm at rest."
    return Worked(tuple(steps), torques, _symbols(setting), sought=sought)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


class _Equilibrium:
    """Steps of an arm's equilibrium: forces and moments on each body add up to zero, moments about
    its joint."""

    def __init__(self, setting: Setting, reactions: SolvedReactions):
        self.s = setting
        self.reactions = reactions

    def convention(self) -> Step:
        """Step: definition of the force on the tip."""
        robot = "robot" if self.s.tree.loops else "arm"
        return Step(
            "The load",
            f"f is the force on the {robot} at its tip P. What the {robot} exerts there on its "
            f"surroundings is -f; formulas for the one and for the other differ in sign.",
            (eq(vec("f"), ex.Vector(tuple(sym(name) for name in self.s.load))),),
        )

    def body(self, i: int) -> Step:
        """Step: the equilibrium of one body."""
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
        """External forces on body i, each with the vector from its joint to the point of action."""
        s = self.s
        heavy = s.weighs and i in s.weighted
        weight = [(s.mass_times(i, vec("g")), s.centre_name(i))] if heavy else []
        return [*weight, *([(vec("f"), s.tip_name())] if s.loaded(i) else [])]

    def about(self, i: int) -> list[Expression]:
        """Moments of all other forces on body i, about its joint."""
        s = self.s
        terms = [
            ex.neg(ex.cross(s.reach_name(i, k), s.force_name(i, k))) for k in s.tree.children(i)
        ]
        return [*terms, *(moment_of(force, arm) for force, arm in self.outer(i))]

    def solved(self, i: int) -> Step:
        """Step: reaction and torque at joint i, in terms of earlier ones."""
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
        """Step: the torques written out."""
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
        """Step: the load's part of the torques, as -Jᵀ f."""
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


def _of_closed_chain(setting: Setting) -> Worked:
    """Derive the joint torques of a planar closed chain at rest."""
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
    return Worked(
        tuple(steps), torques, _symbols_of_loops(setting), sought=sought, system=work.system
    )


def _symbols_of_loops(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield glossary.multipliers(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


class _Balance(_Equilibrium):
    """Steps of a closed chain's equilibrium: forces and moments on each body add up to zero."""

    def __init__(self, setting: Setting, loops: Loops, reactions: SolvedReactions):
        super().__init__(setting, reactions)
        self.loops, self.forces = loops, LoopForces(setting, loops)

    @cached_property
    def system(self) -> LoopStatics:
        """The joints' equilibrium equations, linear in the multipliers."""
        return needs_of(self.reactions, self.loops)

    # ------------------------------------------------------------ the bodies
    def body(self, i: int) -> Step:
        """Step: equilibrium of one body, and the motor's component of the moment or force at its
        joint."""
        s, step = self.s, super().body(i)
        if s.is_pin(i):
            return step
        motor = eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i)))
        return replace(step, equations=(*step.equations, motor))

    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """External forces on body i as for a tree, and the loops' forces."""
        return [*super().outer(i), *self.forces.on(i)]

    def about(self, i: int) -> list[Expression]:
        """Moments on body i about its joint, including those transmitted by loops; forces at the
        joint have none."""
        return [*super().about(i), *self.forces.moments_on(i)]

    # ------------------------------------------------------------ solved
    def passive(self) -> list[Step]:
        """Steps: the loops' forces from equilibrium at passive joints."""
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
        """Step: the torques τ of the motors."""
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
        """Step: the forces in the joints."""
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


METHOD = Method(
    "statics",
    "Statics",
    "equilibrium of each body at rest, with a force on the tip",
    "lecture notes, section 2.4",
    work_out,
    closed=(2,),
    elsewhere="fb.static_torque and fb.reactions",
    at_rest=True,
)
