"""How the tip of a closed chain moves with its drives: loop equations, J_a, J_b, J, singular
positions (2.27-2.40)."""

from __future__ import annotations

from collections.abc import Iterator

from freebody.errors import FreebodyError, listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.polynomials.symbols import RATE
from freebody.expressions.printed_names import entry, sym, vec
from freebody.expressions.singularities import Determinant
from freebody_textbook.closed_chains.input_output import ClosedInputOutput
from freebody_textbook.closed_chains.linear import product
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import glossary
from freebody_textbook.methods.cut_loops import LONG, Loops
from freebody_textbook.methods.method import Worked
from freebody_textbook.methods.setting import Setting

SOUGHT = (
    "Sought: how the tip P moves with the joints, and the joints' motion for a given one of "
    "the tip."
)


def work_out(setting: Setting) -> Worked:
    """The steps; drives and rows of the tip's motion as many as there are freedoms."""
    given = setting.symbols.given or setting.symbols.model
    if any(body.kind.quaternion is not None for body in given.bodies):
        raise FreebodyError(
            f"derive: how the tip of {given.name!r} moves with its drives is too long to be "
            "printed, with three angles for the orientation of a body. fb.input_output gives its "
            "numbers at a position; planar closed chains, such as 3RRR, are derived."
        )
    loops = Loops(setting)
    work = _TipAndDrives(setting, loops, loops.equations.input_output())
    steps = [loops.cut(), loops.closed(), loops.freedom(), loops.rates()]
    steps += [work.between(), work.jacobian(), work.singular()]
    return Worked(tuple(steps), (), _symbols(setting), sought=SOUGHT)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield glossary.loop_equations(s)
    yield Meaning((vec("v"),), "rates of the tip", "m/s, rad/s")
    yield Meaning((sym("J"),), "Jacobian of the tip with respect to the driven joints", "m or 1")


class _TipAndDrives:
    """J_a ẋ + J_b θ̇ = 0 and what follows."""

    def __init__(self, setting: Setting, loops: Loops, found: ClosedInputOutput):
        self.s, self.loops, self.io = setting, loops, found

    @property
    def _numbered(self) -> bool:
        return self.loops.is_notes_robot

    def between(self) -> Step:
        """J_a and J_b (2.35, 2.37-2.40)."""
        x, theta = vec("v"), ex.Symbol("theta_d", "θ", dots=1, bold=True)
        lines: list[Equation] = [
            eq(x, ex.Vector(tuple(map(_component, self.io.rows)))),
            eq(theta, ex.Vector(tuple(sym(name + RATE) for name in self.io.driven))),
            eq(ex.add(ex.mul(_j("a"), x), ex.mul(_j("b"), theta)), ex.ZERO),
            *self.loops.matrix(_j("a"), self.io.J_a),
            *self.loops.matrix(_j("b"), self.io.J_b),
        ]
        coordinates = self.s.symbols.coordinates
        direct = set(self.io.driven) | {"x", "y", "z"} >= set(coordinates)
        how = (
            "The rates of the tip and those of the drives appear in separate columns."
            if direct
            else "The equations are combined so that the rates of the passive joints cancel, as "
            "when a velocity is projected on a bar to eliminate the bar's rotation."
        )
        slips = (
            " (The notes print (2.37), (2.39), (2.40) with the opposite sign of d = 2b.)"
            if self._numbered
            else ""
        )
        reason = (
            f"The velocity constraints relate the velocity of the tip to the rates of the driven "
            f"joints. {how}{slips}"
        )
        numbers = ("2.35", "2.37", "2.38", "2.39", "2.40") if self._numbered else ("2.35",)
        return Step("The tip and the drives", reason, tuple(lines), numbers)

    def jacobian(self) -> Step:
        """J = -J_a⁻¹ J_b (2.36)."""
        J = self.io.J
        rule = eq(sym("J"), ex.neg(ex.mul(ex.power(_j("a"), -1), _j("b"))))
        below = [x.below for row in J for x in row if not x.is_polynomial]
        layout = self.loops.equations.layout
        common = below[0] if below and all(x == below[0] for x in below) else None
        if common is not None and layout.is_negative(common):
            common = -common
        lines = [rule]
        for i, row in enumerate(J, 1):
            for k, x in enumerate(row, 1):
                if not x.is_zero:
                    lines.append(eq(entry("J", i, k), self.loops.ratio(x, common)))
        if common is not None:
            lines.append(eq(sym("Delta"), product(common, layout)))
        reason = "Solved for the tip's velocity where J_a can be inverted."
        return Step("The robot's Jacobian", reason, tuple(lines), ("2.36",), result=True)

    def singular(self) -> Step:
        """Where det J_b or det J_a vanishes."""
        lines = [*self._where(self.io.first, "b"), *self._where(self.io.second, "a")]
        reason = (
            "First type, det J_b = 0: the drives can move while the tip does not, and the tip "
            "loses a direction of motion, as at the boundary of the workspace. Second type, det "
            "J_a = 0: the tip can move although the drives are locked; near such a position the "
            f"forces in the robot grow without bound.{self._partly()}"
        )
        return Step("Singular positions", reason, tuple(lines))

    def _partly(self) -> str:
        """What holds where fewer components of the tip's motion are counted than it has."""
        rows = self.io.rows
        if len(rows) >= self.s.tree.space.dim:
            return ""
        counted = listed([str(_component(row)) for row in rows])
        return (
            f" With {len(rows)} degree{'s' * (len(rows) > 1)} of freedom only {counted} is counted "
            "of the tip: in a position of the first type it may still move at right angles to "
            "that."
        )

    def _where(self, found: Determinant, low: str) -> list[Equation]:
        shown = found.expression
        if ex.size(shown) > 2 * LONG:
            shown = ex.words(f"({len(found.polynomial)} terms)")
        lines = [eq(ex.Function("det", _j(low)), shown)]
        for condition in found.conditions:
            if all(ex.size(e) <= LONG for e in condition.solutions):
                lines += condition.solutions
        return lines


def _component(row: str) -> Expression:
    """ẋ for "vx", ω for "w"."""
    if row[0] == "v":
        return ex.Symbol(f"{row[1]}_d", row[1], dots=1)
    return ex.Symbol(f"omega{row[1:]}", "ω", tuple(row[1:]))


def _j(low: str) -> Expression:
    return ex.Symbol(f"J_{low}", "J", (low,))
