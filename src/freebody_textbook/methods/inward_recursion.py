"""The inward sweep of the recursive method: forces and moments from the tip to the base (4.12-4.15,
6.28, 6.29)."""

from __future__ import annotations

from freebody.algorithms.rnea import Recursion
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol
from freebody.expressions.printed_names import vec
from freebody_textbook.derivation import Step
from freebody_textbook.methods import step_reasons
from freebody_textbook.methods.coupled_joints import coupled, shared_motors
from freebody_textbook.methods.geometry import rotation_name
from freebody_textbook.methods.reactions import drive_part
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import gyroscopic, working_part


class Inward:
    """The steps, their values taken from the recursion's record; base: gravity is in the
    accelerations; rules: no values are shown."""

    def __init__(self, setting: Setting, record: Recursion, base: bool, rules: bool):
        self.s = setting
        self.record = record
        self.base = base
        self.rules = rules

    def step(self, i: int) -> Step:
        """Forces and moments on one body, and its motor."""
        s, n = self.s, self.s.numbers[i]
        return Step(
            f"Inward: body {n}",
            self._reason(i) + gyroscopic(s, i, self.record.n[i]),
            (*self._inertia(i), *self._carried(i)),
            ("4.12", "4.13", "4.14", "4.15") if s.planar else ("6.28", "6.29"),
            figure=f"free-body {n}",
        )

    def _reason(self, i: int) -> str:
        s, n = self.s, self.s.numbers[i]
        passed = ", and those that it passes on to the next body" if s.tree.children(i) else ""
        weight = ", less its weight" if not self.base else ""
        comma = "," if passed or weight else ""
        part = "the moment" if s.is_pin(i) else working_part(s, i)
        needed = f"Force and moment that accelerate body {n}{weight}{passed}{comma}"
        if i not in s.weighted:
            needed = f"Body {n} has no mass: the force and the moment that it passes on"
        letters = (
            " (The notes write M_i for the moment at joint i, and M_ci for n_ci.)"
            if self._is_first(i)
            else ""
        )
        drive = step_reasons.drive(s, i) if s.is_alone(i) else ""
        letters = drive + self._unborne(i) + letters
        if not s.is_alone(i):
            return f"{needed} come through joint {n}.{letters}"
        if s.driven(i):
            return f"{needed} come through joint {n}; the motor gives {part}.{letters}"
        return f"{needed} come through joint {n}, which has no motor to give {part}.{letters}"

    def _unborne(self, i: int) -> str:
        """Of a planar slide that bears no other moment than that of a child without motor, which is
        0."""
        s = self.s
        if not s.planar or s.is_pin(i):
            return ""
        held = s.angular(self.record.n[i])
        for k in s.tree.children(i):
            if (
                s.is_alone(k)
                and not s.driven(k)
                and held == s.show(self.record.tau[s.index(k)]) != ex.ZERO
            ):
                on = f"{s.numbers.get(s.tree.bodies[i].parent, 0)},{s.numbers[i]}"
                return f" n_{on} is 0 by the equation of joint {s.numbers[k]}."
        return ""

    def _is_first(self, i: int) -> bool:
        """Whether a planar arm's steps inward begin with body i."""
        return self.s.planar and i == self.s.order[-1]

    def _inertia(self, i: int) -> list[Equation]:
        s = self.s
        if i not in s.weighted:
            return []
        F, N = self.record.F[i][0], self.record.N[i][0]
        spin = ex.ZERO if s.is_point(i) else s.show_moved(N[0]) if s.planar else s.column(N)
        rule = s.mass_times(i, s.name("vc", i, "_d"))
        return [
            worked(s.name("fc", i), rule, s.column(s.axes(i, F)), self.rules),
            worked(s.angular_name("nc", i), s.spin_terms(i), spin, self.rules),
        ]

    def _carried(self, i: int) -> list[Equation]:
        """f and the moment at the joint, and the torque where that is not the moment itself."""
        s, rules = self.s, self.rules
        force, value = self._force(i), s.column(s.axes(i, self.record.f[i]))
        f = worked(
            s.force_name(s.tree.bodies[i].parent, i),
            force,
            value,
            rules or isinstance(force, Symbol),
        )
        name, moment = s.joint_moment(i), self._moment(i)
        torque = s.show(self.record.tau[s.index(i)])
        if s.is_pin(i):
            return [f, worked(name, moment, torque, rules)]
        held = worked(name, moment, s.angular(self.record.n[i]), rules)
        if not s.is_alone(i):
            return [f, held]
        return [f, held, worked(s.motor(i), self._motor(i), torque, rules)]

    def shared(self) -> list[Step]:
        """The motors that move several joints."""
        s, tau = self.s, self.record.tau
        drives = {i: drive_part(s, i) for i in coupled(s)}
        values = {i: tau[s.index(i)] for i in drives}
        return shared_motors(s, drives, None if self.rules else values)

    def _needed(self, i: int) -> Expression:
        """The inertia force, with the weight taken off where gravity is explicit; 0 of a body
        without mass."""
        s = self.s
        if i not in s.weighted:
            return ex.ZERO
        force = s.name("fc", i)
        return force if self.base else ex.sub(force, s.mass_times(i, s.field_name(i)))

    def _outer(self, i: int, x: Expression, k: int) -> Expression:
        """A vector of child k in the axes of body i."""
        return x if self.s.planar else ex.mul(rotation_name(self.s, k, i), x)

    def _force(self, i: int) -> Expression:
        s = self.s
        parts = [
            self._needed(i),
            *(self._outer(i, s.force_name(i, k), k) for k in s.tree.children(i)),
        ]
        if s.loaded(i):
            parts.append(ex.neg(self._load(i)))
        return ex.add(*parts)

    def _load(self, i: int) -> Expression:
        """f, in space turned from the world's axes."""
        return vec("f") if self.s.planar else ex.mul(rotation_name(self.s, -1, i), vec("f"))

    def _moment(self, i: int) -> Expression:
        s = self.s
        parts = [s.angular_name("nc", i)] if i in s.weighted else []
        parts += [self._outer(i, s.joint_moment(k), k) for k in s.tree.children(i)]
        parts.append(ex.cross(s.centre_name(i), self._needed(i)))
        for k in s.tree.children(i):
            parts.append(ex.cross(s.reach_name(i, k), self._outer(i, s.force_name(i, k), k)))
        if s.loaded(i):
            parts.append(ex.neg(ex.cross(s.tip_name(), self._load(i))))
        return ex.add(*parts)

    def _motor(self, i: int) -> Expression:
        s = self.s
        force = s.force_name(s.tree.bodies[i].parent, i)
        part = s.along(i, s.joint_moment(i), force, lambda axis, v: ex.dot(v, axis))
        return ex.add(part, s.show(drive_part(s, i)))


def worked(name: Expression, rule: Expression, value: Expression, rules: bool) -> Equation:
    """name = rule = value; a rule that adds up to nothing is left out, and a value where rules
    suffice."""
    if rules:
        return ex.chain(name, rule)
    return ex.chain(name, value) if rule == ex.ZERO else ex.chain(name, rule, value)
