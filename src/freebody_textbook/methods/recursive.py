"""The recursive Newton-Euler method: outward for motion, inward for forces, with every line written
out (4.6-4.15; 6.16-6.29)."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from freebody.algorithms.rnea import Recursion
from freebody.expressions import expression as ex
from freebody.expressions.expression import Equation, Expression, Symbol, eq
from freebody.expressions.nodes import Words
from freebody.expressions.printed_names import sym, vec
from freebody.scalars.trig import Trig
from freebody_textbook.derivation import Meaning, Method, MethodOption, Step, Worked
from freebody_textbook.methods import glossary, step_reasons
from freebody_textbook.methods.body_by_body import drive_part
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.ending import ending
from freebody_textbook.methods.modular import ModularSetting, last_step
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.shared_steps import geometry, shared_motors
from freebody_textbook.methods.step_reasons import coriolis, gyroscopic, working_part

GRAVITIES = ("base", "explicit")


def work_out(setting: Setting, gravity: str, values: str) -> Worked:
    """Derive the equations by the recursive method. gravity: as the base's acceleration -g, or as
    each body's weight; values: in full if readable, or modular."""
    base = gravity == "base" or not setting.weighs
    record = setting.recursion(gravity)
    tau = tuple(setting.symbols.element(record.tau[setting.index(i)]) for i in setting.leaders)
    names = list(symbols(setting))
    if values == "modular" or not is_readable(setting, tau):
        steps = modular_steps(setting, gravity)
        names += meanings(setting, *["gravity{n}"] * (not base and not setting.planar))
    else:
        steps = _steps(setting, record, base)
        steps += ending(setting)
    title = "" if base else f"{METHOD.title}, gravity as weights"
    return Worked(tuple(steps), tau, names, title)


def is_readable(setting: Setting, tau: Iterable[Trig]) -> bool:
    """Whether all torques are short enough to be written out."""
    return not any(isinstance(setting.show(x), Words) for x in tau)


def modular_steps(setting: Setting, gravity: str) -> list[Step]:
    """Steps of the recursion with each line in terms of earlier ones; in the plane, where all
    vectors have world components, only the rules."""
    base = gravity == "base" or not setting.weighs
    shown = setting if setting.planar else ModularSetting.of(setting)
    steps = _steps(shown, shown.recursion(gravity), base, rules=setting.planar)
    long = not setting.planar and not setting.equations.is_short
    steps += [last_step(steps, setting.equations.length)] if long else ending(setting)
    return steps


def _steps(s: Setting, record: Recursion, base: bool, rules: bool = False) -> list[Step]:
    outward, inward = Outward(s, record, base, rules), Inward(s, record, base, rules)
    return [
        geometry(s, rotations=True),
        outward.start(),
        *map(outward.step, s.order),
        *map(inward.step, reversed(s.order)),
        *inward.shared(),
    ]


def symbols(s: Setting) -> Iterator[Meaning]:
    """Meanings of the symbols that the recursion introduces."""
    yield from glossary.vectors(s)
    yield from meanings(s, "omega{n}", "vc{n}", "v{n}")
    if s.planar:
        yield Meaning((vec("z"),), "unit vector at right angles to the plane", "")
    yield from meanings(s, "fc{n}", "Mc{n}", "f{h}{n}")
    yield from glossary.joint_moments(s)


_BY_NAME = (
    " From here each line is written by components of the lines before, such as ω_2x, so that it "
    "holds the numbers and the coordinate of one joint; in the coordinates of all joints the lines "
    "grow from body to body. Velocities of points are left out: the accelerations do not need them."
)


_BY_RULES = (
    " From here each vector is given by those of the previous body; all have components along "
    "x and y, and written out in the coordinates of the joints they would grow from body to body."
)


class Outward:
    """Steps of the outward sweep: velocities and accelerations, with values from the recursion."""

    def __init__(self, setting: Setting, record: Recursion, base: bool, rules: bool):
        self.s = setting
        self.record = record
        self.base = base
        self.rules = rules
        self.velocities = not isinstance(setting, ModularSetting)

    def _worked(self, name: Expression, rule: Expression, value: Expression) -> Equation:
        return worked(name, rule, value, self.rules)

    def start(self) -> Step:
        """Step: the motion of the base, from which the recursion starts."""
        s = self.s
        if not s.weighs:
            reason = "The base is at rest, and there is no gravity."
        elif self.base:
            reason = (
                "The base is at rest. Giving it the acceleration -g instead, upwards, accounts "
                "for every body's weight without a further term: all accelerations below contain "
                "it."
            )
        else:
            reason = "The base is at rest; each body's weight is counted among its forces."
        w, wd = ((sym if s.planar else vec)(name) for name in ("omega0", "omega0_d"))
        moved = eq(vec("v0_d"), ex.neg(vec("g")) if self.base and s.weighs else ex.ZERO)
        still = eq(vec("v0"), ex.ZERO) if self.velocities else None
        if not self.velocities:
            reason += _BY_NAME
        if self.rules:
            reason += _BY_RULES
        return Step(
            "Start at the base",
            reason,
            tuple(x for x in (eq(w, ex.ZERO), eq(wd, ex.ZERO), still, moved) if x is not None),
        )

    def step(self, i: int) -> Step:
        """Step: velocities and accelerations of one body."""
        s, n, parent = self.s, self.s.numbers[i], self.s.tree.bodies[i].parent
        before = "the base" if parent < 0 else f"body {s.numbers[parent]}"
        own = " and the ".join(
            word for word, has in (("turning", s.turns(i)), ("sliding", s.slides(i))) if has
        )
        reason = f"The motion that body {n} takes over from {before}, plus the {own} of joint {n}"
        extra = coriolis(s, (i,))
        if extra:
            reason += f"; on a rotating body it adds the Coriolis acceleration {extra}"
        centre = self._centre(i) if i in s.weighted else []
        lines = (*self._angular(i), *self._linear(i), *centre, *self._field(i))
        table = _PLANAR if s.planar else _SPATIAL
        cited = (table[True] * s.turns(i)) + (table[False] * s.slides(i))
        return Step(f"Outward: body {n}", f"{reason}.", lines, tuple(dict.fromkeys(cited)))

    def _field(self, i: int) -> list[Equation]:
        """The equation of gravity in body axes, for a modular recursion with weights."""
        s = self.s
        name, parent = s.field_name(i), s.tree.bodies[i].parent
        if self.base or name == vec("g"):
            return []
        rule = self._carried(s.field_name(parent) if parent >= 0 else vec("g"), i)
        return [self._worked(name, rule, s.column(s.gravity(i)))]

    def _angular(self, i: int) -> list[Equation]:
        s, motion = self.s, self.record.motion
        parent = s.tree.bodies[i].parent
        rows = []
        for dots, value in (("", motion.w[i]), ("_d", motion.wd[i])):
            before = (
                self._carried(s.angular_name("omega", parent, dots), i) if parent >= 0 else ex.ZERO
            )
            own: Expression = ex.ZERO
            if s.turns(i):
                own = self._rate(i, dots)
                own = own if s.planar else ex.mul(own, s.name("z", i))
                if dots and not s.planar and parent >= 0:
                    own = ex.add(own, self._swing(i))
            rows.append(
                self._worked(
                    s.angular_name("omega", i, dots), ex.add(before, own), s.angular(value)
                )
            )
        return rows

    def _swing(self, i: int) -> Expression:
        """The term ω × θ̇ z of the angular acceleration: the joint's rotation is itself rotated."""
        s = self.s
        before = self._carried(s.angular_name("omega", s.tree.bodies[i].parent), i)
        return ex.cross(before, ex.mul(self._rate(i), s.name("z", i)))

    def _rate(self, i: int, dots: str = "") -> Expression:
        """The rate of joint i, or its acceleration, along the axis."""
        s = self.s.symbols
        return self.s.show(self.s.rate(i, s.qdd if dots else s.qd))

    def _carried(self, x: Expression, i: int) -> Expression:
        """A vector of the preceding body converted to the axes of body i."""
        s = self.s
        return x if s.planar else ex.mul(s.rotation_name(s.tree.bodies[i].parent, i), x)

    def _linear(self, i: int) -> list[Equation]:
        s, motion, parent = self.s, self.record.motion, self.s.tree.bodies[i].parent
        if parent >= 0:
            w, wd, arm = self._omega(parent, ""), self._omega(parent, "_d"), s.reach_name(parent, i)
            speed = ex.add(s.name("v", parent), ex.cross(w, arm))
            change = ex.add(
                s.name("v", parent, "_d"), ex.cross(wd, arm), ex.cross(w, ex.cross(w, arm))
            )
        else:
            speed, change = ex.ZERO, vec("v0_d") if self.base and s.weighs else ex.ZERO
        rows = []
        for dots, rule, value in (("", speed, motion.v[i]), ("_d", change, motion.vd[i])):
            carried = rule if s.planar or rule == ex.ZERO else self._carried(rule, i)
            if s.slides(i):
                carried = ex.add(carried, *self._slid(i, dots))
            rows.append(self._worked(s.name("v", i, dots), carried, s.column(s.axes(i, value))))
        return rows if self.velocities else rows[1:]

    def _slid(self, i: int, dots: str) -> list[Expression]:
        """Terms of a sliding joint: its rate; or its acceleration and the Coriolis term."""
        s = self.s
        rates = self._rate(i), self._rate(i, "_d")
        speed, change = (ex.mul(s.advance(i), x, s.axis_name(i)) for x in rates)
        parent = s.tree.bodies[i].parent
        still = parent < 0 or s.angular(self.record.motion.w[parent]) == ex.ZERO
        if not dots or still:
            return [change if dots else speed]
        return [change, ex.mul(2, ex.cross(self._omega(i, ""), speed))]

    def _omega(self, i: int, dots: str) -> Expression:
        """Angular velocity or acceleration of a body as a vector, ω z in the plane."""
        s = self.s
        name = s.angular_name("omega", i, dots)
        return ex.mul(name, vec("z")) if s.planar else name

    def _centre(self, i: int) -> list[Equation]:
        s = self.s
        w, wd, c = self._omega(i, ""), self._omega(i, "_d"), s.centre_name(i)
        speed = ex.add(s.name("v", i), ex.cross(w, c))
        change = ex.add(s.name("v", i, "_d"), ex.cross(wd, c), ex.cross(w, ex.cross(w, c)))
        second = s.column(s.axes(i, self.record.vd_com[i][0]))
        found = [self._worked(s.name("vc", i, "_d"), change, second)]
        if self.velocities:
            found.insert(0, self._worked(s.name("vc", i), speed, s.column(s.centre_velocity(i))))
        return found


_PLANAR = {
    True: ("4.6", "4.7", "4.8", "4.9", "4.10", "4.11"),
    False: ("4.8", "4.11", "6.24", "6.25", "6.26", "6.27"),
}
_SPATIAL = {
    True: ("6.18", "6.19", "6.20", "6.21", "6.22"),
    False: ("6.22", "6.24", "6.25", "6.26", "6.27"),
}


class Inward:
    """Steps of the inward sweep, with values from the recursion; base: gravity is part of the
    accelerations; rules: values are omitted."""

    def __init__(self, setting: Setting, record: Recursion, base: bool, rules: bool):
        self.s = setting
        self.record = record
        self.base = base
        self.rules = rules

    def step(self, i: int) -> Step:
        """Step: forces and moments on one body, and its motor."""
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
        """A clause on a planar slide that bears no moment except that of a child without motor,
        which is 0; "" otherwise."""
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
        """Whether the inward sweep of a planar arm starts with body i."""
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
        """Equations of f and the moment at the joint, and of the torque unless it is that
        moment."""
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
        """Steps: the motors that move several joints."""
        s, tau = self.s, self.record.tau
        drives = {i: drive_part(s, i) for i in s.coupled}
        values = {i: tau[s.index(i)] for i in drives}
        return shared_motors(s, drives, None if self.rules else values)

    def _needed(self, i: int) -> Expression:
        """The inertia force, minus the weight if gravity is explicit; 0 for a body without mass."""
        s = self.s
        if i not in s.weighted:
            return ex.ZERO
        force = s.name("fc", i)
        return force if self.base else ex.sub(force, s.mass_times(i, s.field_name(i)))

    def _outer(self, i: int, x: Expression, k: int) -> Expression:
        """A vector of child k converted to the axes of body i."""
        return x if self.s.planar else ex.mul(self.s.rotation_name(k, i), x)

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
        """The load f on the tip, in space converted from world axes to body axes."""
        return vec("f") if self.s.planar else ex.mul(self.s.rotation_name(-1, i), vec("f"))

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
    """The equation name = rule = value; the rule is omitted if it is 0, the value if only rules are
    shown."""
    if rules:
        return ex.chain(name, rule)
    return ex.chain(name, value) if rule == ex.ZERO else ex.chain(name, rule, value)


METHOD = Method(
    "recursive",
    "The recursive method of Newton and Euler",
    "motion from the base outward, forces from the tip inward",
    "lecture notes, sections 4.3 and 6.3",
    work_out,
    aliases=("recursive-newton-euler",),
    options=(
        MethodOption("gravity", GRAVITIES, "gravity as acceleration of the base, or as weights"),
        MethodOption(
            "values",
            ("full", "modular"),
            "written out in the joints' coordinates as long as they can be read, or each line by "
            "those before",
        ),
    ),
)
