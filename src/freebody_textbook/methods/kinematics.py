"""Kinematics of the tip step by step: position, velocity, Jacobian, singular poses, acceleration
(2.10-2.26)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from freebody.errors import FreebodyError, listed
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import entry, sym, vec
from freebody.expressions.singularities import Determinant, jacobian_determinant
from freebody.lazy import cached_property
from freebody_textbook.closed_chains.input_output import ClosedInputOutput
from freebody_textbook.closed_chains.linear import product, ratio
from freebody_textbook.derivation import Meaning, Method, Step, Worked
from freebody_textbook.methods import glossary
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.cut_loops import LONG, Loops
from freebody_textbook.methods.glossary import METER
from freebody_textbook.methods.setting import Setting

_SOUGHT = (
    "Sought: how the tip P moves with the joints, and the joints' motion for a given one of "
    "the tip."
)


def work_out(setting: Setting) -> Worked:
    """Derive the kinematics of the tip; the result has no torques. For closed chains see
    `_of_closed_chain`."""
    if setting.tree.loops:
        return _of_closed_chain(setting)
    work = _TipKinematics(setting)
    steps = [
        work.position(),
        work.velocity(),
        work.jacobian(),
        *work.singular(),
        work.acceleration(),
        *work.back(),
    ]
    steps += _inverse_position(setting) if not setting.symbols.is_rewritten else []
    return Worked(tuple(steps), (), _symbols(setting), "Kinematics of the tip", _SOUGHT)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield Meaning((sym("r_P", True),), "position of the tip, from the base's origin", METER)
    if s.planar:
        yield from meanings(s, "s{n}")
        if len(s.leaders) > 2:
            yield Meaning((sym("phi"),), "angle of the last body from the x axis", "rad")
    yield Meaning((sym("J"),), "Jacobian of the tip", "m or 1")


class _TipKinematics:
    """The steps of the tip's kinematics: motion of the point, and in the plane its rotation if
    enough joints turn."""

    def __init__(self, setting: Setting):
        self.s = setting
        self.closed = Kinematics(setting.symbols, setting.symbols.model.frame().name)
        n, dim = len(setting.leaders), setting.tree.space.dim
        self.rows = tuple(range(3)) if dim == 3 or n >= 3 else (0, 1)

    @cached_property
    def turning(self) -> bool:
        """Whether the angle φ of the last body is included."""
        return self.s.planar and len(self.rows) == 3

    def cited(self, *numbers: str) -> tuple[str, ...]:
        """Equation numbers of the notes, if the robot is their 2R arm; otherwise none."""
        return numbers if self.s.cited == "RR" else ()

    # ------------------------------------------------------------ forward
    def position(self) -> Step:
        """Step: the tip's position as a sum of vectors along the arm."""
        s, position = self.s, self.s.column(tuple(self.closed.position))
        told = "The frames of the bodies, followed one after the other,"
        lines = [eq(vec("r_P"), position)]
        if s.planar:
            told, chain = "The vectors along the bodies, added one after the other,", self._chain()
            first = s.column(s.world[self._path()[0]][1])
            start = [vec("r_1")] if first != ex.ZERO else []
            total = ex.add(*start, *(name for name, _ in chain))
            lines = [eq(name, s.column(value)) for name, value in chain]
            lines += [*(eq(name, first) for name in start), eq(vec("r_P"), total, position)]
            lines += [self._angle()] if self.turning else []
        return Step(
            "Position of the tip",
            f"{told} lead from the base to the tip P.",
            tuple(lines),
            self.cited("2.10", "2.11", "2.12", "2.13"),
            figure="tip",
        )

    def _chain(self) -> list[tuple[Expression, tuple]]:
        s, path = self.s, self._path()
        inner = [(s.reach_name(i, k), s.to_child(i, k)) for i, k in pairwise(path)]
        return [
            row
            for row in [*inner, (s.tip_name(), s.to_tip(path[-1]))]
            if s.column(row[1]) != ex.ZERO
        ]

    def _path(self) -> list[int]:
        """Indices of the bodies from the base to the one with the tip."""
        path = [self.s.tip]
        while self.s.tree.bodies[path[0]].parent >= 0:
            path.insert(0, self.s.tree.bodies[path[0]].parent)
        return path

    def _angle(self) -> Equation:
        angles = [self.s.position(i) for i in self._path() if self.s.turns(i)]
        return eq("phi", ex.add(*angles))

    def velocity(self) -> Step:
        """Step: the tip's velocity, the derivative of its position."""
        s, velocity = self.s, self.closed.velocity
        value = s.column(tuple(velocity[: s.tree.space.dim]))
        lines = [eq(vec("r_P_d"), ex.d_dt(vec("r_P")), value)]
        if self.turning:
            lines.append(eq(ex.d_dt("phi"), s.show_moved(velocity[2])))
        reason = (
            "The tip stays where it is, whatever the joints do."
            if value == ex.ZERO
            else "Differentiating with respect to time; a sine's derivative is the cosine times "
            "the rate of its angle."
        )
        return Step(
            "Velocity of the tip",
            reason,
            tuple(lines),
            self.cited("2.16", "2.17"),
            figure="tip velocity",
        )

    def jacobian(self) -> Step:
        """Step: the Jacobian, whose entries are the coefficients of the rates."""
        s = self.s
        rates = ex.Vector(tuple(sym(s.coordinate(i) + RATE) for i in s.leaders))
        J = [[s.show_moved(self.closed.J[r][k]) for k in self._columns()] for r in self.rows]
        moved = ex.Vector((vec("r_P_d"), sym("phi_d"))) if self.turning else vec("r_P_d")
        return Step(
            "The Jacobian",
            "The velocity is linear in the rates; their factors are the partial derivatives of the "
            "position, one column for each joint.",
            (eq(moved, ex.mul("J", vec("q_d"))), eq(vec("q_d"), rates), eq("J", ex.matrix(J))),
            ("2.6", *self.cited("2.18", "2.19")),
            result=True,
        )

    def _columns(self) -> list[int]:
        return [self.s.index(i) for i in self.s.leaders]

    # ------------------------------------------------------------ singular poses
    @cached_property
    def _determinant(self) -> Determinant:
        return jacobian_determinant(self.closed, self.rows)

    def singular(self) -> list[Step]:
        """Step: the poses with det J = 0, if J is square."""
        s = self.s
        if len(self.rows) != len(s.leaders):
            return []
        found = self._determinant
        expanded, name = s.show(found.polynomial), ex.Function("det", sym("J"))
        product = found.expression
        shorter = ex.size(product) < ex.size(expanded)
        lines = [ex.chain(name, expanded, product) if shorter else eq(name, product)]
        for condition in found.conditions:
            lines += condition.solutions or (condition.equation,)
        one = len(lines) == 2
        where = f"It is zero where {'the other line' if one else 'one of the other lines'} holds"
        if not found.conditions:
            where = "It is never zero"
        if found.polynomial.is_zero:
            where = "It is zero everywhere: the joints cannot move the tip in all directions"
        reason = f"Where the determinant vanishes the arm loses a direction of motion. {where}."
        return [
            Step(
                "Singular poses",
                reason,
                tuple(lines),
                self.cited("2.20", "2.21", "2.22", "2.23"),
                result=True,
            )
        ]

    def acceleration(self) -> Step:
        """Step: the acceleration of the tip, J q̈ + J̇ q̇."""
        s = self.s
        J_dot = [
            [s.show_moved(self.closed.J_dot[r][k]) for k in self._columns()] for r in self.rows
        ]
        second = ex.add(ex.mul("J", vec("q_dd")), ex.mul("J_d", vec("q_d")))
        moved = vec("r_P_dd") if not self.turning else ex.Vector((vec("r_P_dd"), sym("phi_dd")))
        value = s.column(tuple(self.closed.acceleration[: s.tree.space.dim]))
        lines = [eq("J_d", ex.matrix(J_dot)), eq(moved, second), eq(vec("r_P_dd"), value)]
        return Step(
            "Acceleration of the tip",
            "Differentiating once more: the rates change, and so does the Jacobian.",
            tuple(lines),
            ("2.24",),
            figure="tip acceleration",
        )

    def back(self) -> list[Step]:
        """Step: joint velocities and accelerations for a given motion of the tip, if J is
        invertible."""
        if len(self.rows) != len(self.s.leaders) or self._determinant.polynomial.is_zero:
            return []
        inverse = ex.power("J", -1)
        moved, second = (vec(f"r_P{d}") for d in (RATE, SECOND))
        if self.turning:
            moved, second = (
                ex.Vector((x, sym(f"phi{d}"))) for x, d in ((moved, RATE), (second, SECOND))
            )
        lines = [
            eq(vec("q_d"), ex.mul(inverse, moved)),
            eq(vec("q_dd"), ex.mul(inverse, ex.sub(second, ex.mul("J_d", vec("q_d"))))),
        ]
        reason = (
            "Where J is not singular the joints' motion follows from a wanted motion of the tip."
        )
        return [
            Step(
                "Inverse velocity and acceleration",
                reason,
                (*lines, *self._inverse()),
                ("2.25", "2.26"),
            )
        ]

    def _inverse(self) -> list[Equation]:
        """Equation of the inverse of a 2×2 Jacobian."""
        if len(self.rows) != 2:
            return []
        s = self.s
        (a, b), (c, d) = [[self.closed.J[r][k] for k in self._columns()] for r in self.rows]
        determinant = a * d - b * c
        adjugate = [[d, -b], [-c, a]]
        rows = [[ratio(x, determinant).form(s.layout) for x in row] for row in adjugate]
        name = ex.Symbol("J_inverse", "K")  # so that an entry K₁₁ is not read as 1/J₁₁
        return [eq(ex.power("J", -1), name), eq(name, ex.matrix(rows))]


def _of_closed_chain(setting: Setting) -> Worked:
    """Derive the velocity relation of tip and drives in a closed chain, with as many components of
    the tip's motion as degrees of freedom."""
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
    return Worked(tuple(steps), (), _symbols_of_loops(setting), sought=_SOUGHT)


def _symbols_of_loops(s: Setting) -> Iterator[Meaning]:
    yield glossary.loop_equations(s)
    yield Meaning((vec("v"),), "rates of the tip", "m/s, rad/s")
    yield Meaning((sym("J"),), "Jacobian of the tip with respect to the driven joints", "m or 1")


class _TipAndDrives:
    """The steps on J_a ẋ + J_b θ̇ = 0 between tip and drives."""

    def __init__(self, setting: Setting, loops: Loops, found: ClosedInputOutput):
        self.s, self.loops, self.io = setting, loops, found

    @property
    def _numbered(self) -> bool:
        return self.loops.is_notes_robot

    def between(self) -> Step:
        """Step: J_a and J_b (2.35, 2.37-2.40)."""
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
        """Step: the Jacobian of tip and drives, J = -J_a⁻¹ J_b (2.36)."""
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
        """Step: the poses in which det J_b or det J_a vanishes."""
        lines = [*self._where(self.io.first, "b"), *self._where(self.io.second, "a")]
        reason = (
            "First type, det J_b = 0: the drives can move while the tip does not, and the tip "
            "loses a direction of motion, as at the boundary of the workspace. Second type, det "
            "J_a = 0: the tip can move although the drives are locked; near such a position the "
            f"forces in the robot grow without bound.{self._partly()}"
        )
        return Step("Singular positions", reason, tuple(lines))

    def _partly(self) -> str:
        """A sentence for relations that omit some components of the tip's motion."""
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
    """Symbol of a component of the tip's velocity: ẋ for "vx", ω for "w"."""
    if row[0] == "v":
        return ex.Symbol(f"{row[1]}_d", row[1], dots=1)
    return ex.Symbol(f"omega{row[1:]}", "ω", tuple(row[1:]))


def _j(low: str) -> Expression:
    return ex.Symbol(f"J_{low}", "J", (low,))


def _inverse_position(s: Setting) -> list[Step]:
    """Step: inverse kinematics of the notes' arm with straight links; none for other arms, for
    which fb.inverse_kinematics serves."""
    lengths = _lengths(s)
    if lengths is None:
        return []
    a, b = lengths
    x = sym("x")
    y = sym("y")
    one = sym(s.coordinate(s.order[0]))
    two = sym(s.coordinate(s.order[1]))
    square = ex.add(ex.power(x, 2), ex.power(y, 2))
    over = ex.sub(square, ex.add(ex.power(a, 2), ex.power(b, 2)))
    reach, aside = ex.add(a, ex.mul(b, ex.cos(two))), ex.mul(b, ex.sin(two))
    lines = (
        eq(ex.cos(two), ex.div(over, ex.mul(2, a, b))),
        eq(ex.power(ex.sin(two), 2), ex.sub(1, ex.power(ex.cos(two), 2))),
        eq(ex.mul(square, ex.sin(one)), ex.sub(ex.mul(reach, y), ex.mul(aside, x))),
        eq(ex.mul(square, ex.cos(one)), ex.add(ex.mul(reach, x), ex.mul(aside, y))),
    )
    reason = (
        "The square of the distance to P(x, y) does not depend on the first angle and gives the "
        "cosine of the second. Its sine has two signs, for the elbow on one side or the other; for "
        "each, sine and cosine together determine the quadrant of the first angle (atan2). P can "
        "be reached where the cosine lies between -1 and 1, that is, where its distance from the "
        "base is at least the difference and at most the sum of the lengths."
    )
    return [Step("Inverse position", reason, lines, ("2.14", "2.15"))]


def _lengths(s: Setting) -> tuple[Expression, Expression] | None:
    """The lengths l1 and l2 of an arm of two straight links with its pivot at the origin; None for
    other robots."""
    if s.cited != "RR" or s.tip != s.order[1]:
        return None
    first, second = s.order
    at = [
        s.motion.joints[first][1],
        s.motion.joints[second][1],
        s.tip_frame[2],
    ]
    (x0, y0), (a, y1), (b, y2) = ([s.show(x) for x in p] for p in at)
    return (a, b) if all(x == ex.ZERO for x in (x0, y0, y1, y2)) and ex.ZERO not in (a, b) else None


METHOD = Method(
    "kinematics",
    "Kinematics",
    "position, velocity, Jacobian, singular poses and acceleration of the tip",
    "lecture notes, sections 2.2 and 2.3",
    work_out,
    closed=(2, 3),
    finds_torques=False,
)
