"""Newton and Euler body by body: free-body diagrams, unknown reactions, elimination, closed form
(3.5-3.15).

n_{i,k} is the moment of body i on body k at joint k. A revolute joint's motor is the moment about
its axis (in the plane the whole moment), a prismatic one's the force along its axis; the other
components are bearing reactions.
"""

from __future__ import annotations

from collections.abc import Iterator

from freebody.derivations.derivation import Meaning, Step
from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Expression, eq
from freebody.derivations.expressions.printed_names import vec
from freebody.derivations.methods import free_bodies, glossary, step_reasons
from freebody.derivations.methods.body_motion import motion
from freebody.derivations.methods.closed_form_steps import closed_form
from freebody.derivations.methods.geometry import geometry
from freebody.derivations.methods.method import Method, MethodOption, Worked
from freebody.derivations.methods.moments_about_pivots import about_pivots, arms_of_pivots
from freebody.derivations.methods.reactions import SolvedReactions
from freebody.derivations.methods.setting import Setting
from freebody.scalars.trig import Trig


def work_out(setting: Setting, route: str) -> Worked:
    """The steps; route: moments of each body about its centre of mass, or of what hangs on a joint
    about its pivot. Of bodies that nothing holds: see `free_bodies`."""
    if free_bodies.are_free(setting.symbols.given or setting.symbols.model):
        return free_bodies.work_out(setting, route)
    inward = tuple(reversed(setting.order))
    reactions = SolvedReactions(setting)
    tau = {i: reactions.motor(i) for i in inward}
    work = FreeBodies(setting, reactions, tau)
    about = about_pivots(setting, reactions.drives) if route == "pivot" else work.about_centres()
    moving = motion(setting)
    # about a fixed pivot only the turning counts
    steps = [
        *about,
        geometry(setting),
        *(moving[:1] if route == "pivot" and setting.cited == "R" else moving),
    ]
    steps += [work.substituted(i, route == "centre") for i in inward]
    steps.append(closed_form(setting))
    title = f"{METHOD.title}, moments about the pivots" if route == "pivot" else ""
    torques = tuple(tau[i] for i in setting.order)
    return Worked(tuple(steps), torques, _symbols(setting, route), title)


def _symbols(s: Setting, route: str) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from glossary.moving(s)
    if route == "pivot":
        yield from arms_of_pivots(s)
    else:
        yield glossary.joint_forces()
        yield from glossary.joint_moments(s)


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
        return Step(
            f"Free body {n}", step_reasons.free_body(s, i), lines, numbers, figure=f"free-body {n}"
        )

    def forces(self, i: int) -> Expression:
        """Forces on body i: by its parent, minus those on its children, its weight, the load on the
        tip."""
        s = self.s
        terms: list[Expression] = [s.force_name(s.tree.bodies[i].parent, i)]
        terms += [ex.neg(s.force_name(i, k)) for k in s.tree.children(i)]
        if s.weighs:
            terms.append(s.mass_times(i, vec("g")))
        if s.loaded(i):
            terms.append(vec("f"))
        return ex.add(*terms)

    def moments(self, i: int) -> Expression:
        """Moments on body i about its centre of mass."""
        s = self.s
        arm, children = s.centre_name(i), s.tree.children(i)
        terms = [s.joint_moment(i), *(ex.neg(s.joint_moment(k)) for k in children)]
        terms.append(ex.neg(ex.cross(arm, s.force_name(s.tree.bodies[i].parent, i))))
        for k in children:
            terms.append(ex.neg(ex.cross(ex.sub(s.reach_name(i, k), arm), s.force_name(i, k))))
        if s.loaded(i):
            terms.append(ex.cross(ex.sub(s.tip_name(), arm), vec("f")))
        return ex.add(*terms)

    def inertia_force(self, i: int) -> Expression:
        """What the forces on body i add up to."""
        return self.s.mass_times(i, self.s.name("vc", i, "_d"))

    # ------------------------------------------------------------ elimination
    def passed(self, i: int) -> Expression:
        """The force at joint i without reactions: of body i and all that hangs on it, less the
        load."""
        s = self.s
        terms = [s.needed(i), *(self.passed(k) for k in s.tree.children(i))]
        return ex.add(*terms, ex.neg(vec("f")) if s.loaded(i) else ex.ZERO)

    def eliminated(self, i: int) -> Step:
        """The reaction at joint i from Newton's equation, put into Euler's."""
        s, n = self.s, self.s.numbers[i]
        lines = [
            eq(s.force_name(s.tree.bodies[i].parent, i), self.passed(i)),
            eq(s.joint_moment(i), self.held(i)),
        ]
        if not s.is_pin(i):
            lines.append(eq(s.motor(i), self.reactions.motor_rule(i, s.joint_moment(i))))
        numbers = {("R", 1): ("3.7",), ("RR", 1): ("3.15",), ("RR", 2): ("3.14",)}.get(
            (s.cited, n), ()
        )
        return Step(
            f"Eliminate the reactions at joint {n}",
            step_reasons.eliminated(s, i),
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
        if s.loaded(i):
            terms.append(ex.neg(ex.cross(s.tip_name(), vec("f"))))
        return ex.add(*terms)

    # ------------------------------------------------------------ values
    def substituted(self, i: int, reactions: bool) -> Step:
        """Reaction and torque at joint i, the motion put in."""
        s, n = self.s, self.s.numbers[i]
        lines = []
        if reactions:
            lines.append(
                eq(s.force_name(s.tree.bodies[i].parent, i), s.column(self.reactions.f[i]))
            )
            if not s.is_pin(i):
                lines.append(eq(s.joint_moment(i), s.angular(self.reactions.n[i])))
        lines.append(eq(s.motor(i), s.show(self.tau[i])))
        return Step(
            f"Substitute the motion: joint {n}",
            step_reasons.substituted(s, i, reactions),
            tuple(lines),
        )


METHOD = Method(
    "newton-euler",
    "Newton and Euler, body by body",
    "forces and moments on each body, the reactions eliminated",
    "lecture notes, chapter 3 and section 6.1",
    work_out,
    options=(
        MethodOption("route", ("centre", "pivot"), "moments about centres of mass or pivots"),
    ),
)
