"""Newton's and Euler's equations body by body: free-body diagrams, unknown reactions, elimination,
closed form (3.5-3.15).

n_{i,k} is the moment of body i on body k at joint k. A revolute joint's motor is the moment about
its axis (in the plane the whole moment), a prismatic one's the force along its axis; the other
components are bearing reactions.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from freebody.errors import FreebodyError, listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import entry, sym, vec
from freebody.scalars.trig import Trig
from freebody.spatial import dot
from freebody_textbook.closed_chains.linear_equations import product, solved
from freebody_textbook.derivation import Meaning, Method, MethodOption, Step, Worked
from freebody_textbook.methods import free_bodies, glossary, recursive
from freebody_textbook.methods.body_by_body import FreeBodies, SolvedReactions, angles_between_arms
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.glossary import INERTIA, METER
from freebody_textbook.methods.loop_forces_on_bodies import (
    FEW,
    LoopForces,
    LoopReactions,
    needs_of,
    without_links,
)
from freebody_textbook.methods.loops_and_multipliers import LONG, Loops
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import geometry, motion, shared_motors
from freebody_textbook.methods.step_reasons import Efforts
from freebody_textbook.methods.whole_bodies import are_free


def work_out(setting: Setting, route: str) -> Worked:
    """Derive the equations of motion by Newton and Euler. route: moments of each body about its
    centre of mass, or of all bodies beyond a joint about its pivot. For free bodies see
    `free_bodies`, for closed chains `_of_closed_chain`."""
    if are_free(setting.symbols.given or setting.symbols.model):
        return free_bodies.work_out(setting, route)
    if setting.tree.loops:
        return _of_closed_chain(setting, route)
    inward = tuple(reversed(setting.order))
    reactions = SolvedReactions(setting)
    tau = {i: reactions.motor(i) for i in setting.leaders}
    work = FreeBodies(setting, reactions, tau)
    about = _about_pivots(setting, reactions.drives) if route == "pivot" else work.about_centres()
    torques = tuple(tau.values())
    symbols = list(_symbols(setting, route))
    if not recursive.is_readable(setting, torques):
        steps = [*about, *recursive.modular_steps(setting, "explicit")]
        more = [*recursive.symbols(setting), *meanings(setting, *["gravity{n}"] * setting.weighs)]
        symbols = list(dict.fromkeys([*symbols, *more]))
    else:
        moving = motion(setting)
        # about a fixed pivot only the turning counts
        steps = [
            *about,
            geometry(setting),
            *(moving[:1] if route == "pivot" and setting.cited == "R" else moving),
        ]
        if route == "centre":
            steps += angles_between_arms(setting)
        told = inward if route == "centre" else filter(setting.is_alone, inward)
        steps += [work.substituted(i, route == "centre") for i in told]
        steps += shared_motors(setting, reactions.drives, tau)
        steps += ending(setting)
    title = f"{METHOD.title}, moments about the pivots" if route == "pivot" else ""
    return Worked(tuple(steps), torques, symbols, title)


def _symbols(s: Setting, route: str) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}")
    if route == "pivot":
        yield from _arms_of_pivots(s)
    else:
        yield from meanings(s, "f{h}{n}")
        yield from glossary.joint_moments(s)


def _of_closed_chain(s: Setting, route: str) -> Worked:
    """Derive the equations of a planar closed chain by Newton and Euler."""
    if route != "centre":
        raise FreebodyError(
            "derive: moments about pivots are written out for open chains, where a joint carries "
            "all the bodies after it; leave route out for a closed one."
        )
    loops = Loops(s)
    reactions = LoopReactions(s, loops)
    tau = {i: reactions.motor(i) for i in s.order}
    work = _LoopedBodies(s, reactions, tau)
    work.join(loops)
    bodies = [i for i in s.order if i not in s.links]
    inward = list(reversed(bodies))
    steps = [work.loops_cut(), *map(work.body, bodies), work.count(bodies)]
    steps += map(work.eliminated, filter(s.is_held, inward))
    steps += [work.loop_forces.geometry(), *(without_links(s, step) for step in motion(s))]
    steps += [loops.closed(), loops.rates(), loops.seconds()]
    steps += [work.substituted(i, True) if s.is_held(i) else work.freed(i) for i in inward]
    steps += [*work.unknowns(), *ending(s, work.through_loops())]
    efforts = Efforts.of(s)
    unknown = [f"the {efforts.words}"] if efforts.count else []
    unknown += [f"the forces in {loops.named}", "those in the joints"]
    sought = f"Given a motion that keeps {loops.named} closed, {listed(unknown)} are sought."
    torques = tuple(tau[i] for i in s.order)
    return Worked(tuple(steps), torques, _symbols_of_loops(s), sought=sought, system=work.system)


def _symbols_of_loops(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}")
    yield glossary.loop_equations(s)
    yield glossary.multipliers(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


class _LoopedBodies(FreeBodies):
    """The free bodies of a closed chain, with the forces of the loops on them."""

    def join(self, loops: Loops) -> None:
        """Include the loops and the forces that they exert on the bodies."""
        self.loops, self.loop_forces = loops, LoopForces(self.s, loops)
        self.system = needs_of(self.reactions, loops)

    # ------------------------------------------------------------ the bodies
    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """External forces on body i: the load and the loops' forces, each with its lever arm."""
        return [*super().outer(i), *self.loop_forces.on(i)]

    def turned(self, i: int) -> list[Expression]:
        """Moments that loops exert on body i."""
        return self.loop_forces.moments_on(i)

    def further_forces(self, i: int) -> list[str]:
        """Phrases for the loops' forces on body i."""
        return self.loop_forces.in_words(i)

    def left_over(self, i: int) -> str:
        """Phrase for the loop's force as a remaining unknown, for a body with the end of a loop."""
        carried = [i]
        for k in carried:
            carried += self.s.tree.children(k)
        looped = any(self.loop_forces.on(k) for k in carried)
        return f"nothing unknown{f' but forces in {self.loops.named}' if looped else ''}"

    def loops_cut(self) -> Step:
        """Step: cutting the loops and replacing them by forces."""
        return self.loop_forces.step(
            " λ_k is the multiplier of loop equation k, so that Lagrange's equations of the first "
            "kind have the same unknowns."
        )

    def count(self, bodies: list[int]) -> Step:
        """Step: counting equations and unknowns."""
        s, loops = self.s, self.loops.named
        n, m = len(bodies), len(self.loop_forces.unknowns)
        free = [f"body {s.numbers[i]}" for i in bodies if not s.is_held(i)]
        motors = sum(map(s.driven, s.order))
        unknown = 2 * (n - len(free)) + m + motors
        reason = (
            f"Each of the {n} bodies has two equations of forces and one of moments. Unknown are "
            f"two components of what each joint's bearing transmits, {m} of {loops}, and "
            f"{motors} of the {'motor' if motors == 1 else 'motors'}: {unknown} for {3 * n} "
            f"equations.{f' No joint holds {listed(free)}.' if free else ''} "
        )
        if unknown == 3 * n:
            reason += "For a given motion all of them are determined."
        elif unknown > 3 * n:
            reason += (
                "There are more drives than degrees of freedom: for a given motion the drives can "
                f"work against one another, and the forces in {loops} are not determined."
            )
        else:
            reason += (
                "There are fewer drives than degrees of freedom: not every motion is possible."
            )
        return Step("Equations and unknowns", reason)

    def freed(self, i: int) -> Step:
        """Step: the equations of a body without a joint."""
        s, n, k = self.s, self.s.numbers[i], i
        joints = [i]
        while s.tree.bodies[k].parent in s.links:
            k = s.tree.bodies[k].parent
            joints.insert(0, k)
        reason = (
            f"No joint holds body {n}: its equations, of the forces along x and y and of the "
            f"moments, contain no other unknowns than the forces in {self.loops.named}."
        )
        lines = tuple(eq(s.motor(j), s.show(self.tau[j])) for j in joints)
        return Step(f"Substitute the motion: body {n}", reason, lines)

    # ------------------------------------------------------------ the unknowns
    def unknowns(self) -> list[Step]:
        """Steps: the equations A λ = k from the joints without motor."""
        s = self.s
        free = [i for i in s.order if not s.driven(i)]
        if not free:
            return []
        joints = listed([f"joint {s.numbers[i]}" for i in free])
        theirs = "its equation holds" if len(free) == 1 else "their equations hold"
        reason = (
            f"No motor acts at {joints}: {theirs} no unknown but the forces in "
            f"{self.loops.named}, which occur linearly. As a system, A λ = k; k holds what the "
            f"motion{' and the weights ask for' if s.weighs else ' asks for'}."
        )
        lines = self.loop_forces.system(self.system)
        more, found = self._solved()
        unlisted = self.loops.unlisted(self.system.A)
        title = f"The forces in {self.loops.named}"
        return [Step(title, f"{reason}{more}{unlisted}", (*lines, *found))]

    def _solved(self) -> tuple[str, list[Equation]]:
        """A sentence on how A λ = k is solved, and the equations of the multipliers λ in the
        entries of k; no equations where these are too long."""
        system, symbols = self.system, self.s.symbols
        unknown = self.loop_forces.unknowns
        if len(system.passive) != len(unknown):
            return " There are not as many equations as multipliers.", []
        if len(unknown) > FEW:
            return " It is solved with numbers.", []
        n = range(len(unknown))
        one = symbols.element(1.0)
        unit = [[one if i == j else symbols.zero() for j in n] for i in n]
        above, below = solved(system.A, unit, symbols)
        if below.is_zero:
            return " Its determinant vanishes: these joints do not determine the multipliers.", []
        layout = self.loops.equations.layout
        rows = [
            ex.add(*(ex.mul(product(x, layout), entry("k", j)) for j, x in enumerate(row, 1)))
            for row in above
        ]
        if any(ex.size(row) > LONG for row in rows):
            return " It is solved with numbers.", []
        lines = [eq(name, ex.div(row, "Delta")) for name, row in zip(unknown, rows, strict=True)]
        lines.append(eq("Delta", ex.Function("det", sym("A")), product(below, layout)))
        return (
            " Where the determinant Δ vanishes the robot can move although its drives are locked "
            "(a singular position of the second type), and the forces grow without bound."
        ), lines

    def through_loops(self) -> list[Expression]:
        """Generalized forces of the loops by coordinate, Φ_qᵀ λ."""
        columns = zip(*self.loops.equations.Phi_q, strict=True)
        return [
            ex.add(
                *(
                    ex.mul(ex.partial(self.loops.phi(j), name), unknown)
                    for j, (x, unknown) in enumerate(
                        zip(column, self.loop_forces.unknowns, strict=True), 1
                    )
                    if not x.is_zero
                )
            )
            for name, column in zip(self.s.symbols.coordinates, columns, strict=True)
        ]


def _about_pivots(s: Setting, drives: Mapping[int, Trig]) -> list[Step]:
    """Steps with one moment equation per joint, from the base outward; drives: torque of each
    joint's friction and springs."""
    if s.cited == "R":
        return [_fixed_axis(s, s.show(drives[s.order[0]]))]
    return [_carried(s, i, drives) for i in s.order]


def _arms_of_pivots(s: Setting) -> Iterator[Meaning]:
    """Glossary entries of the symbols for moments about pivots."""
    if s.cited == "R":
        yield Meaning((sym("I_A"),), "moment of inertia about the pivot", INERTIA)
    elif any(s.turns(i) and s.tree.children(i) for i in s.order):
        words = "vector from joint i to the centre of mass of body k"
        yield Meaning((sym("r_i,ck", True),), words, METER)


def _fixed_axis(s: Setting, drive: Expression) -> Step:
    """Step: a single body on a fixed pivot, with its moment of inertia about the pivot."""
    (i,) = s.order
    centre = s.centre_name(i)
    moments: list[Expression] = [s.motor(i), ex.neg_each(drive)]
    if s.weighs:
        moments.append(ex.cross(centre, s.mass_times(i, vec("g"))))
    if s.loaded(i):
        moments.append(ex.cross(s.tip_name(), vec("f")))
    length = dot(s.centre(i), s.centre(i))
    own = ex.ZERO if s.is_point(i) else "I1"
    about = ex.add(own, s.mass_times(i, s.show(length)))
    return Step(
        "Moments about the pivot",
        "The body turns about a fixed pivot, where the reaction f_0,1 has no moment: one equation "
        "gives the torque, with the moment of inertia about the pivot by the parallel-axis "
        "theorem. (The notes print (3.3) and (3.4) with the opposite sign of the weight.)",
        (eq("I_A", about), eq(ex.add(*moments), ex.mul("I_A", sym("omega1_d")))),
        ("1.19", "3.3", "3.4"),
        figure="free-body 1",
    )


def _carried(s: Setting, i: int, drives: Mapping[int, Trig]) -> Step:
    n, parent = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    held = f"f_{parent},{n}" + ("" if s.is_pin(i) else f" with the moment n_{parent},{n}")
    found = (
        f"the {s.words(i).effort}" if s.driven(i) else "an equation of motion: there is no motor"
    )
    line = eq(s.motor(i), ex.add(_balance(s, i), s.show(drives[i]))) if s.is_alone(i) else None
    if line is None:
        reaction = s.force_name(s.tree.bodies[i].parent, i)
        line = eq(s.along(i, s.joint_moment(i), reaction), _balance(s, i))
    lines = [*_arms(s, i), line]
    if not s.is_alone(i):
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"one equation gives the part of the reaction {held} at the joint that does work."
        )
    elif s.turns(i):
        pivot = "the pivot" if s.planar else "its axis"
        none = f"has no moment about {pivot}, so that one moment equation gives {found}"
        if s.slides(i):
            none = (
                "does no work along the screw: the moments about its axis, and pitch times the "
                f"forces along it, give {found}"
            )
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"the reaction {held} at the joint {none}."
        )
    else:
        reason = (
            f"Take all that joint {n} carries as one system: the reactions inside it cancel, and "
            f"of the reaction {held} at the joint {'only the motor' if s.driven(i) else 'nothing'} "
            f"acts along the slide, so that one force equation gives {found}."
        )
    return Step(f"All that joint {n} carries", reason, tuple(lines), figure=f"carried {n}")


def _arms(s: Setting, i: int) -> list[Equation]:
    """Equations of the lever arms from pivot i to the centres of mass beyond the next joint."""
    if not s.turns(i):
        return []
    lines = [eq(_arm(s, i, k), _way(s, i, k, s.centre_name(k))) for k in _subtree(s, i) if k != i]
    if _loaded(s, i) and not s.loaded(i):
        lines.append(eq(_tip_arm(s, i), _way(s, i, s.tip, s.tip_name())))
    return lines


def _arm(s: Setting, i: int, k: int) -> Expression:
    a, b = s.numbers[i], s.numbers[k]
    return (
        s.centre_name(i) if k == i else ex.Symbol(f"r{a}_c{b}", "r", (str(a), f"c{b}"), bold=True)
    )


def _tip_arm(s: Setting, i: int) -> Expression:
    n = str(s.numbers[i])
    return s.tip_name() if s.loaded(i) else ex.Symbol(f"r{n}_P", "r", (n, "P"), bold=True)


def _way(s: Setting, i: int, k: int, last: Expression) -> Expression:
    """The sum of vectors from joint i to a point of body k."""
    path = [last]
    while k != i:
        parent = s.tree.bodies[k].parent
        path.append(s.reach_name(parent, k))
        k = parent
    return ex.add(*reversed(path))


def _balance(s: Setting, i: int) -> Expression:
    """Sum over all bodies beyond joint i of inertia and weight terms in the moment about it."""
    moments, forces = [], []
    for k in _subtree(s, i):
        moments += [s.spin_terms(k), ex.cross(_arm(s, i, k), s.needed(k))]
        forces.append(s.needed(k))
    if _loaded(s, i):
        moments.append(ex.neg(ex.cross(_tip_arm(s, i), vec("f"))))
        forces.append(ex.neg(vec("f")))
    return s.along(i, ex.add(*moments), ex.add(*forces))


def _loaded(s: Setting, i: int) -> bool:
    return bool(s.load) and s.tip in _subtree(s, i)


def _subtree(s: Setting, i: int) -> list[int]:
    """Indices of body i and of all bodies that hang on it."""
    return [i, *(k for child in s.tree.children(i) for k in _subtree(s, child))]


METHOD = Method(
    "newton-euler",
    "Newton and Euler, body by body",
    "forces and moments on each body, the reactions eliminated",
    "lecture notes, chapter 3 and section 6.1",
    work_out,
    options=(
        MethodOption("route", ("centre", "pivot"), "moments about centres of mass or pivots"),
    ),
    closed=(2,),
    elsewhere="fb.inverse_dynamics and fb.reactions",
)
