"""Steps for closed chains that several methods share: cutting the loops, their equations, and the
wrench of each multiplier."""

from __future__ import annotations

from dataclasses import dataclass

from freebody.algorithms import loop_constraints
from freebody.algorithms.kinematics import frame_pose
from freebody.errors import listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.printed_names import entry, place, sym
from freebody.expressions.typesetting.literal import literal
from freebody.lazy import cached_property
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.tree import TreeLoop
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, scale
from freebody_textbook.closed_chains.linear_equations import Ratio, product, quotient
from freebody_textbook.closed_chains.loop_equations import LoopEquations
from freebody_textbook.closed_chains.multiplier_equations import FirstKind, multiplier_names
from freebody_textbook.derivation import Step
from freebody_textbook.methods.setting import Setting

LONG = 90
"""Numbers and symbols up to which a matrix is written out."""
FEW = 9
"""Coordinates up to which they are listed in a column."""
_ENTRIES = 16
"""Number of entries up to which a matrix is written out."""
LONGEST = 500
"""Numbers and symbols up to which all right sides of one system are written out."""


@dataclass(frozen=True)
class Loops:
    """The loops of a model, in words and as derivation steps."""

    s: Setting

    @cached_property
    def equations(self) -> LoopEquations:
        """The loop equations Φ and their derivatives."""
        return LoopEquations(self.s.symbols)

    @cached_property
    def system(self) -> FirstKind:
        """The equations of the first kind."""
        return FirstKind(self.equations, self.s.equations)

    # ------------------------------------------------------------ words
    @property
    def named(self) -> str:
        """Phrase "the loop" or "the loops", by their number."""
        return "the loop" if len(self.s.tree.loops) == 1 else "the loops"

    def ends(self, loop: TreeLoop) -> tuple[int, int]:
        """The tree bodies that carry a loop's two frames; -1 is the ground."""
        a, b = (self.s.tree.frames[frame][0] for frame in loop.frames)
        return a, b

    def body(self, i: int) -> str:
        """Words for a body: "body 3", or "the ground"."""
        return f"body {self.s.numbers[i]}" if i >= 0 else "the ground"

    def points(self, loop: TreeLoop) -> tuple[str, str]:
        """Phrases "point P of body 3" for a loop's two frames."""
        first, second = (
            self._point(name, i) for name, i in zip(loop.frames, self.ends(loop), strict=True)
        )
        return first, second

    def _point(self, frame: str, i: int) -> str:
        own = self.s.symbols.model.frame(frame)
        return (
            f"point {literal(frame)} of {self.body(i)}"
            if own.mounted
            else f"the origin of {self.body(i)} ({literal(frame)})"
        )

    def holds(self, loop: TreeLoop) -> str:
        """Phrase for the constraint of a loop."""
        first, second = self.points(loop)
        if loop.closure.distance:
            return f"{literal(loop.name)} is a massless rod from {first} to {second}"
        kind = next(x.kind for x in self.s.symbols.model.loops if x.name == loop.name)
        if LOOP_KINDS[kind].pins:
            return f"{literal(loop.name)} holds {first} and {second} together"
        return f"{literal(loop.name)} ({kind}) joins {first} to {second}"

    # ------------------------------------------------------------ steps
    def cut(self) -> Step:
        """Step: the coordinates of the tree that remains when the loops are cut."""
        s = self.s
        held = "; ".join(self.holds(loop) for loop in s.tree.loops)
        reason = (
            f"With {self.named} cut, the bodies form a tree, whose joint variables determine every "
            f"pose; they are not independent, because {self.named} must stay closed: {held}."
        )
        motors = [s.motor(i) for i in s.order]
        if any(x == ex.ZERO for x in motors):
            reason += " A passive joint has no motor and its force is 0."
        if len(motors) > FEW:
            reason += (
                " q holds the joint variables in the order of the joints, Q the torques and forces "
                "of their motors."
            )
            return Step(f"Cut {self.named}: dependent coordinates", reason)
        lines = [eq(sym("q"), ex.Vector(tuple(sym(s.coordinate(i)) for i in s.order)))]
        if not s.load:
            lines.append(eq(sym("Q"), ex.Vector(tuple(motors))))
        return Step(f"Cut {self.named}: dependent coordinates", reason, tuple(lines))

    def closed(self) -> Step:
        """Step: the loop equations, Φ(q) = 0."""
        reason = " ".join(self._written(loop) for loop in self.s.tree.loops)
        lines = [
            eq(self.phi(k), shown, ex.ZERO)
            for k, shown in enumerate(self.equations.expressions(), 1)
        ]
        numbers = ("2.33", "2.34", "5.21") if self.is_notes_robot else ("5.21",)
        if self.is_notes_robot:
            reason += " (The notes print (2.33) and (2.34) with the opposite sign of d = 2b.)"
        return Step("The loop equations", reason, tuple(lines), numbers)

    def _written(self, loop: TreeLoop) -> str:
        rows = [f"Φ_{k + 1}" for k in self.equations.rows(loop)]
        (a, b), (first, second) = map(literal, loop.frames), self.points(loop)
        verb = "say" if len(rows) > 1 else "says"
        if loop.closure.distance:
            square = f"the square of the distance from {a} to {b}"
            return f"{listed(rows)} {verb} that {square} is that of {literal(loop.name)}'s length."
        if not loop.closure.turns and not loop.closure.slides:
            return (
                f"{listed(rows)} {verb} that the vector from {first} to {second} is zero, "
                f"component by component."
            )
        return f"{listed(rows)} {verb} that {literal(loop.name)} stays closed: {_parts(loop)}."

    @cached_property
    def is_notes_robot(self) -> bool:
        """Whether the mechanism is the five-bar robot of the notes' section 2.3: a freely sliding
        point on two rods."""
        s = self.s
        names = set(s.symbols.coordinates)
        lengths = {"b", "l1", "l2", "l3", "l4"}
        rods = len(s.tree.loops) == 2 and all(loop.closure.distance for loop in s.tree.loops)
        return (
            s.planar
            and rods
            and names == {"theta1", "theta2", "x", "y"}
            and lengths <= set(s.symbols.ring.names)
        )

    def freedom(self) -> Step:
        """Step: the degrees of freedom, f = n - m."""
        n, m = len(self.s.symbols.coordinates), len(self.equations.names)
        f = self.equations.gruebler
        word = "degree" if f == 1 else "degrees"
        reason = (
            f"{n} coordinates less {m} equations leave {f} {word} of freedom (Grübler's count). "
            f"It assumes that all equations are independent; whether they are depends on lengths "
            f"and position."
        )
        if f < 1:
            reason += (
                " With redundant ones it moves all the same; fb.mobility tells whether it does."
            )
        return Step("Degrees of freedom", reason, (eq("f", ex.sub("n", "m"), ex.sub(n, m), f),))

    def rates(self) -> Step:
        """Step: the loop equations of the rates, Φ_q q̇ = 0."""
        reason = (
            "The equations hold at all times, so their time derivatives vanish: the matrix Φ_q of "
            "partial derivatives, multiplied by the rates, gives zero."
        )
        zero = eq(ex.d_dt(sym("Phi")), ex.mul(self.phi_q, dotted("q", 1)), ex.ZERO)
        return Step(
            "Velocity constraints",
            reason + self.unlisted(self.equations.Phi_q),
            (zero, *self.matrix(self.phi_q, self.equations.Phi_q)),
            ("5.22",),
        )

    def seconds(self) -> Step:
        """Step: the loop equations of the accelerations, Φ_q q̈ = c."""
        rate = ex.Symbol("Phi_q_d", "Φ", ("q",), dots=1)
        rule = eq(ex.mul(self.phi_q, dotted("q", 2)), ex.neg(ex.mul(rate, dotted("q", 1))), "c")
        shown = list(map(self.s.show, self.equations.c))
        if sum(map(ex.size, shown)) > LONGEST:
            shown = [ex.words(f"({len(x)} terms)") for x in self.equations.c]
        lines = [eq(entry("c", k), x) for k, x in enumerate(shown, 1)]
        reason = (
            "Differentiating once more gives the constraints on the accelerations; c holds the "
            "products of rates."
        )
        return Step("Acceleration constraints", reason, (rule, *lines), ("5.28",))

    def wrenches(self) -> Step:
        """Step: the force that each multiplier represents."""
        lines: list[Equation] = []
        words: list[str] = []
        for loop in self.s.tree.loops:
            rows = list(self.equations.rows(loop))
            names = listed([f"λ_{k + 1}" for k in rows])
            words.append(f"{names} {'is' if len(rows) == 1 else 'are'} {self._meaning(loop)}.")
            lines += self.force_lines(loop)
        reason = (
            "The constraint forces of a loop enter the equations as -Φ_qᵀ λ. "
            + " ".join(words)
            + " The two bodies exert opposite wrenches on each other."
        )
        return Step("Meaning of the multipliers", reason, tuple(lines))

    def _meaning(self, loop: TreeLoop) -> str:
        target, other = map(self.body, self.ends(loop))
        at = literal(loop.frames[0])
        if loop.closure.distance:
            return (
                f"half the rod's tension over its length: positive, it pulls {target} at {at} "
                f"towards {other}"
            )
        parts = (
            "force"
            if not loop.closure.turns and not loop.closure.slides
            else "force and the moment"
        )
        along = "" if self.s.planar else " along the world's axes"
        return f"the {parts} of {other} on {target} at {at}, by components{along}"

    # ------------------------------------------------------------ wrenches
    def acts(self, loop: TreeLoop, i: int) -> bool:
        """Whether a loop's printed wrench acts on body i, the second frame's body, rather than its
        opposite."""
        return self.ends(loop)[1] == i

    def _index(self, loop: TreeLoop) -> int:
        return [x.name for x in self.s.tree.loops].index(loop.name)

    def force_name(self, loop: TreeLoop) -> Expression:
        """Name of a loop's force, by the first frame's body on the second's."""
        return self.s.naming.loop_force(self._index(loop))

    def moment_name(self, loop: TreeLoop) -> Expression:
        """Name of a loop's moment, by the first frame's body on the second's, about the second
        frame's origin."""
        return self.s.naming.loop_moment(self._index(loop))

    def wrench(self, loop: TreeLoop) -> tuple[Vector, Vector]:
        """(force, moment) of a loop on the second frame's body at its frame, in world axes, by the
        multipliers."""
        own = next(x for x in self.equations.tree.loops if x.name == loop.name)
        s, space = self.s, self.s.tree.space
        ends = (frame_pose(s.tree, self.equations.world, frame) for frame in loop.frames)
        force, moment = space.zero, space.zero_angular
        names = multiplier_names(self.equations)
        for k, e in zip(
            self.equations.rows(loop),
            loop_constraints.loop_equations(space, own, *ends),
            strict=True,
        ):
            weight = -s.symbols.ring[names[k]]
            force = add(force, scale(weight, e.f))
            moment = add(moment, scale(weight, e.n_b))
        return force, moment

    def force_lines(self, loop: TreeLoop) -> list[Equation]:
        """Equations of a loop's wrench by its multipliers."""
        s = self.s
        if loop.closure.distance:
            (k,) = self.equations.rows(loop)
            gap = s.column(tuple(-x for x in self.equations.gap(loop)))
            return [eq(self.force_name(loop), ex.mul(2, entry("lam", k + 1), gap))]
        force, moment = self.wrench(loop)
        lines = [eq(self.force_name(loop), s.column(force))]
        if self.moment_name(loop) != ex.ZERO:
            lines.append(eq(self.moment_name(loop), s.angular(moment)))
        return lines

    # ------------------------------------------------------------ how it is shown
    def ratio(self, x: Ratio, common: Trig | None = None) -> Expression:
        """Printed form of a quotient; over Δ if `common` is given, of which its denominator then is
        a multiple by a number. A long one is given by its number of terms."""
        layout, below = self.equations.layout, ex.ONE
        if x.is_polynomial:
            shown = x.form(layout)
        elif common is not None:
            number = x.below.leading_coefficient / common.leading_coefficient
            below = sym("Delta")
            shown = quotient(product(x.above / number, layout), below)
        else:
            below, shown = product(x.below, layout), x.form(layout)
        if ex.size(shown) <= 2 * LONG:
            return shown
        told = ex.words(f"({len(x.above)} terms)")
        return ex.div(
            told, below if ex.size(below) <= LONG else ex.words(f"({len(x.below)} terms)")
        )

    @property
    def phi_q(self) -> Expression:
        """Symbol of the Jacobian Φ_q."""
        return PHI_Q

    def phi(self, k: int) -> Expression:
        """Symbol of the loop equation Φ_k."""
        return entry("Phi", k)

    def matrix(self, name: Expression, rows: list) -> list[Equation]:
        """Equations of a matrix: written out, row by row if it is wide, or only its nonzero
        entries."""
        shown = ex.matrix([[self._entry(x) for x in row] for row in rows])
        if self._is_short(rows, shown):
            return [eq(name, shown)]
        letter = name.letter if isinstance(name, ex.Symbol) else "A"
        low = name.low if isinstance(name, ex.Symbol) else ()
        return [
            eq(
                ex.Symbol(f"{letter}{place(i, j)}", letter, (*low, *place(i, j).split(","))),
                self._entry(x),
            )
            for i, row in enumerate(rows, 1)
            for j, x in enumerate(row, 1)
            if not x.is_zero
        ]

    def _is_short(self, rows: list, shown: Expression) -> bool:
        return ex.size(shown) <= LONG and len(rows) * len(rows[0]) <= _ENTRIES

    def unlisted(self, rows: list) -> str:
        """A sentence, starting with a blank, on the entries that `matrix` omits; "" if it omits
        none."""
        shown = ex.matrix([[self._entry(x) for x in row] for row in rows])
        some = any(x.is_zero for row in rows for x in row)
        told = " Entries that are not listed are 0."
        return told if some and not self._is_short(rows, shown) else ""

    def _entry(self, x: Trig) -> Expression:
        return min((self.s.show_moved(x), self.s.show(x)), key=ex.size)


PHI_Q = ex.Symbol("Phi_q", "Φ", ("q",))
"""Symbol of the Jacobian Φ_q."""


def block_system() -> Equation:
    """The equation of M q̈ + Φ_qᵀ λ = n and Φ_q q̈ = c as one block system (5.29)."""
    block = ex.matrix([[sym("M"), ex.transposed(PHI_Q)], [PHI_Q, ex.ZERO]])
    return eq(ex.mul(block, ex.vector(dotted("q", 2), sym("lam"))), ex.vector("n", "c"))


def dotted(letter: str, dots: int) -> Expression:
    """Symbol of all coordinates or their derivatives: q, q̇, q̈."""
    return ex.Symbol(letter + ("", "_d", "_dd")[dots], letter, dots=dots)


def _parts(loop: TreeLoop) -> str:
    closure = loop.closure
    parts = ["the points together"] if closure.point else []
    parts += ["no motion across the slide"] if closure.slides else []
    parts += ["perpendicular directions that stay perpendicular"] if closure.turns else []
    return ", ".join(parts)
