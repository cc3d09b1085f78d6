"""Newton and Euler body by body for a closed chain: the loops are cut, what they do to the bodies
is unknown, and the joints without motors give it (chapter 3, with the constraints of section 5.4).

The torques that this ends in are linear in the multipliers λ, and the same polynomials as those of
Lagrange's equations of the first kind.
"""

from __future__ import annotations

from collections.abc import Iterator

from freebody.errors import FreebodyError, listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import entry, sym
from freebody_textbook.closed_chains.linear import product, solved
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import glossary
from freebody_textbook.methods.body_by_body import FreeBodies
from freebody_textbook.methods.body_motion import motion
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import LONG, Loops
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.loop_forces import (
    FEW,
    LoopForces,
    LoopReactions,
    needs_of,
    without_links,
)
from freebody_textbook.methods.method import Worked
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import Efforts


def work_out(s: Setting, route: str) -> Worked:
    """The steps; planar chains only."""
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
    return Worked(tuple(steps), torques, _symbols(s), sought=sought, system=work.system)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}")
    yield glossary.loop_equations(s)
    yield glossary.multipliers(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


class _LoopedBodies(FreeBodies):
    """The free bodies with the forces of the loops on them."""

    def join(self, loops: Loops) -> None:
        """Tell the loops."""
        self.loops, self.loop_forces = loops, LoopForces(self.s, loops)
        self.system = needs_of(self.reactions, loops)

    # ------------------------------------------------------------ the bodies
    def outer(self, i: int) -> list[tuple[Expression, Expression]]:
        """The load, and the loops' forces."""
        return [*super().outer(i), *self.loop_forces.on(i)]

    def turned(self, i: int) -> list[Expression]:
        """Moments of loops."""
        return self.loop_forces.moments_on(i)

    def told(self, i: int) -> list[str]:
        """The loops' forces in words."""
        return self.loop_forces.told(i)

    def left_over(self, i: int) -> str:
        """Of a body that carries the end of a loop the loop's force."""
        carried = [i]
        for k in carried:
            carried += self.s.tree.children(k)
        looped = any(self.loop_forces.on(k) for k in carried)
        return f"nothing unknown{f' but forces in {self.loops.named}' if looped else ''}"

    def loops_cut(self) -> Step:
        """What stands for each loop."""
        return self.loop_forces.step(
            " λ_k is the multiplier of loop equation k, so that Lagrange's equations of the first "
            "kind have the same unknowns."
        )

    def count(self, bodies: list[int]) -> Step:
        """As many equations as unknowns?"""
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
        """The equations of a body that no joint holds."""
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
        """A λ = k from the joints without motor."""
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
        """λ by the entries of k, where that is short."""
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
        """Φ_qᵀ λ by coordinate."""
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
