"""Kinematics of the tip step by step: position, velocity, Jacobian, singular poses, acceleration
(2.10-2.26)."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, eq
from freebody.expressions.kinematics import Kinematics
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym, vec
from freebody.expressions.singularities import Determinant, jacobian_determinant
from freebody.lazy import cached_property
from freebody_textbook.closed_chains.linear import ratio
from freebody_textbook.derivation import Meaning, Step
from freebody_textbook.methods import loop_kinematics
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.glossary import METER
from freebody_textbook.methods.inverse_position import inverse_position
from freebody_textbook.methods.method import Method, Worked
from freebody_textbook.methods.setting import Setting


def work_out(setting: Setting) -> Worked:
    """The steps; there are no torques in them. Of a closed chain: see `loop_kinematics`."""
    if setting.tree.loops:
        return loop_kinematics.work_out(setting)
    work = _Tip(setting)
    steps = [
        work.position(),
        work.velocity(),
        work.jacobian(),
        *work.singular(),
        work.acceleration(),
        *work.back(),
    ]
    steps += inverse_position(setting) if not setting.symbols.is_rewritten else []
    return Worked(
        tuple(steps), (), _symbols(setting), "Kinematics of the tip", loop_kinematics.SOUGHT
    )


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield Meaning((sym("r_P", True),), "position of the tip, from the base's origin", METER)
    if s.planar:
        yield from meanings(s, "s{n}")
        if len(s.leaders) > 2:
            yield Meaning((sym("phi"),), "angle of the last body from the x axis", "rad")
    yield Meaning((sym("J"),), "Jacobian of the tip", "m or 1")


class _Tip:
    """The steps; counted is the motion of the point, and in the plane the turning where there are
    joints for it."""

    def __init__(self, setting: Setting):
        self.s = setting
        self.closed = Kinematics(setting.symbols, setting.symbols.model.frame().name)
        n, dim = len(setting.leaders), setting.tree.space.dim
        self.rows = tuple(range(3)) if dim == 3 or n >= 3 else (0, 1)

    @cached_property
    def turning(self) -> bool:
        """Whether the angle φ of the last body is counted."""
        return self.s.planar and len(self.rows) == 3

    def cited(self, *numbers: str) -> tuple[str, ...]:
        """Numbers of the notes' 2R arm."""
        return numbers if self.s.cited == "RR" else ()

    # ------------------------------------------------------------ forward
    def position(self) -> Step:
        """Sum of the vectors along the arm."""
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
        """Bodies from the base to the tip's."""
        path = [self.s.tip]
        while self.s.tree.bodies[path[0]].parent >= 0:
            path.insert(0, self.s.tree.bodies[path[0]].parent)
        return path

    def _angle(self) -> Equation:
        angles = [self.s.position(i) for i in self._path() if self.s.turns(i)]
        return eq("phi", ex.add(*angles))

    def velocity(self) -> Step:
        """The derivative of the position."""
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
        """The factors of the rates."""
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
        """Where det J = 0, if J is square."""
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
        """J q̈ + J̇ q̇."""
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
        """Joint velocities and accelerations for a given motion of the tip, if J has an inverse."""
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
        """The inverse of a 2×2 Jacobian."""
        if len(self.rows) != 2:
            return []
        s = self.s
        (a, b), (c, d) = [[self.closed.J[r][k] for k in self._columns()] for r in self.rows]
        determinant = a * d - b * c
        adjugate = [[d, -b], [-c, a]]
        rows = [[ratio(x, determinant).form(s.layout) for x in row] for row in adjugate]
        name = ex.Symbol("J_inverse", "K")  # so that an entry K₁₁ is not read as 1/J₁₁
        return [eq(ex.power("J", -1), name), eq(name, ex.matrix(rows))]


METHOD = Method(
    "kinematics",
    "Kinematics",
    "position, velocity, Jacobian, singular poses and acceleration of the tip",
    "lecture notes, sections 2.2 and 2.3",
    work_out,
    closed=(2, 3),
    finds_torques=False,
)
