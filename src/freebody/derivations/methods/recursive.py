"""The recursive method: outward for motion, inward for forces, every line written out (4.6-4.15;
6.16-6.29)."""

from __future__ import annotations

from freebody.algorithms.rnea import Recursion, rnea
from freebody.derivations import expression as ex
from freebody.derivations.derivation import Derivation, Step
from freebody.derivations.expression import Equation, Expression, eq
from freebody.derivations.methods.lagrange import closed_form
from freebody.derivations.methods.setting import Setting
from freebody.derivations.names import sym, vec
from freebody.derivations.symbols import RATE, SECOND
from freebody.errors import UnknownNameError
from freebody.scalars.trig import Trig

GRAVITIES = ("base", "explicit")


def derive(setting: Setting, gravity: str = "base") -> Derivation:
    """The derivation; gravity: as acceleration -g of the base, or as each body's weight."""
    if gravity not in GRAVITIES:
        raise UnknownNameError("gravity", gravity, "recursive", GRAVITIES)
    work = _Work(setting, gravity)
    steps = [work.start()]
    steps += [work.outward(i) for i in setting.order]
    steps += [work.inward(i) for i in reversed(setting.order)]
    steps.append(closed_form(setting))
    tau = tuple(work.torque(i) for i in setting.order)
    title = "The recursive method of Newton and Euler"
    return Derivation("recursive", title, setting.equations, tuple(steps), tau)


class _Work:
    """The lines of both sweeps, their values taken from one run of the recursion over the ring."""

    def __init__(self, setting: Setting, gravity: str):
        self.s = s = setting
        self.base = gravity == "base"
        load = ()
        if s.load:
            tip, _, p = s.tree.frames[s.symbols.model.frame().name]
            force = tuple(s.symbols.ring[name] for name in s.load)
            if s.planar:
                R = s.world[tip][0]
                force = tuple(R[0][k] * force[0] + R[1][k] * force[1] for k in range(2))
            load = ((tip, force, s.tree.space.moment(p, force)),)
            self.tip = tip
        self.record: Recursion = rnea(s.tree, s.symbols.q, s.symbols.qd, s.symbols.qdd, load, gravity)

    def torque(self, i: int) -> Trig:
        """The recursion's torque of body i's joint."""
        return self.s.symbols.element(self.record.tau[self.s.tree.bodies[i].coordinates.v[0]])

    # ------------------------------------------------------------ steps
    def start(self) -> Step:
        s = self.s
        still = [eq(vec("v0"), ex.ZERO), eq(sym("omega0") if s.planar else vec("omega0"), ex.ZERO)]
        base = eq(vec("v0_d"), ex.neg(vec("g")) if self.base else ex.ZERO)
        reason = (
            "The base rests. Letting it accelerate upwards by g instead gives every body its weight "
            "without a further term."
            if self.base
            else "The base rests; each body's weight will stand among its forces."
        )
        return Step("Start at the base", reason, (*still, base), figure="kinematics")

    def outward(self, i: int) -> Step:
        """Velocities and accelerations of one body."""
        s = self.s
        lines = [*self._angular(i), *self._linear(i), self._centre(i)]
        numbers = ("4.6", "4.7", "4.9", "4.10", "4.11") if s.planar else _SPATIAL[s.turns(i)]
        return Step(
            f"Outward: body {s.numbers[i]}",
            "From the body before it, the joint's own motion added"
            + (
                "."
                if s.turns(i)
                else "; a point that slides on a turning body has Coriolis' acceleration 2 ω × ḋ u."
            ),
            tuple(lines),
            numbers,
        )

    def _angular(self, i: int) -> list[Equation]:
        s, motion, q = self.s, self.record.motion, self.s.coordinate(i)
        parent = s.tree.bodies[i].parent
        rows = []
        for dots, ending, value in (("", RATE, motion.w[i]), ("_d", SECOND, motion.wd[i])):
            before = self._carried(s.angular_name("omega", parent, dots), i) if parent >= 0 else ex.ZERO
            own: Expression = ex.ZERO
            if s.turns(i):
                own = sym(q + ending) if s.planar else ex.mul(sym(q + ending), s.name("z", i))
                if dots and not s.planar and parent >= 0:
                    swing = ex.cross(
                        self._carried(s.angular_name("omega", parent), i),
                        ex.mul(sym(q + RATE), s.name("z", i)),
                    )
                    own = ex.add(own, swing)
            rows.append(_chain(s.angular_name("omega", i, dots), ex.add(before, own), s.angular(value)))
        return rows

    def _carried(self, x: Expression, i: int) -> Expression:
        """A vector of the body before, in the axes of body i."""
        s = self.s
        if s.planar:
            return x
        n = s.numbers[i]
        rotation = ex.Symbol(f"R{n}", "R", (str(s.numbers[s.tree.bodies[i].parent]),), high=str(n))
        return ex.mul(rotation, x)

    def _linear(self, i: int) -> list[Equation]:
        s, motion, q = self.s, self.record.motion, self.s.coordinate(i)
        parent = s.tree.bodies[i].parent
        arm = self._arm(i)
        w, wd = self._omega(parent, ""), self._omega(parent, "_d")
        rows = []
        speed = ex.add(
            s.name("v", parent) if parent >= 0 else ex.ZERO, ex.cross(w, arm) if parent >= 0 else ex.ZERO
        )
        change = s.name("v", parent, "_d") if parent >= 0 else vec("v0_d")
        if parent >= 0:
            change = ex.add(change, ex.cross(wd, arm), ex.cross(w, ex.cross(w, arm)))
        for dots, rule, value in (("", speed, motion.v[i]), ("_d", change, motion.vd[i])):
            carried = rule if s.planar or rule == ex.ZERO else self._carried(rule, i)
            if not s.turns(i):
                ending = SECOND if dots else RATE
                carried = ex.add(carried, ex.mul(sym(q + ending), s.name("u", i)))
                if dots:
                    carried = ex.add(
                        carried,
                        ex.mul(2, ex.cross(self._omega(i, ""), ex.mul(sym(q + RATE), s.name("u", i)))),
                    )
            rows.append(_chain(s.name("v", i, dots), carried, s.column(s.axes(i, value))))
        return rows

    def _omega(self, i: int, dots: str) -> Expression:
        """ω of a body as a vector: ω z in the plane."""
        s = self.s
        return (
            ex.mul(s.angular_name("omega", i, dots), vec("z"))
            if s.planar
            else s.angular_name("omega", i, dots)
        )

    def _arm(self, i: int) -> Expression:
        s, parent = self.s, self.s.tree.bodies[i].parent
        return (
            s.name("s", parent) if len(s.tree.children(parent)) < 2 else s.name(f"s{s.numbers[parent]}_", i)
        )

    def _centre(self, i: int) -> Equation:
        s = self.s
        w, wd, c = self._omega(i, ""), self._omega(i, "_d"), s.name("sc", i)
        rule = ex.add(s.name("v", i, "_d"), ex.cross(wd, c), ex.cross(w, ex.cross(w, c)))
        return eq(s.name("vc", i, "_d"), rule, s.column(s.axes(i, self.record.vd_com[i][0])))

    def inward(self, i: int) -> Step:
        """Forces and moments on one body, and its motor."""
        s, n = self.s, self.s.numbers[i]
        F, N = self.record.F[i][0], self.record.N[i][0]
        inertia = ex.mul(f"I{n}", s.angular_name("omega", i, "_d"))
        if not s.planar:
            w = s.angular_name("omega", i)
            inertia = ex.add(inertia, ex.cross(w, ex.mul(f"I{n}", w)))
        parent = s.tree.bodies[i].parent
        lines = [
            eq(s.name("fc", i), ex.mul(f"m{n}", s.name("vc", i, "_d")), s.column(s.axes(i, F))),
            eq(s.angular_name("Mc" if s.planar else "nc", i), inertia, s.angular(N)),
            eq(s.force_name(parent, i), self._force(i), s.column(s.axes(i, self.record.f[i]))),
            eq(self._moment_name(i), self._moment(i), s.angular(self.record.n[i])),
            eq(s.torque_name(i), self._motor(i), s.show(self.torque(i))),
        ]
        return Step(
            f"Inward: body {n}",
            "What accelerates the body, and what it passes on, must come through its joint; the motor "
            "gives the part along "
            "the joint's axis.",
            tuple(lines),
            ("4.12", "4.13", "4.14", "4.15") if s.planar else ("6.28", "6.29"),
            figure=f"free-body {n}",
        )

    def _needed(self, i: int) -> Expression:
        """The inertia force, with the weight taken off where gravity is explicit."""
        s = self.s
        force = s.name("fc", i)
        return force if self.base else ex.sub(force, ex.mul(f"m{s.numbers[i]}", vec("g")))

    def _outer(self, i: int, x: Expression, k: int) -> Expression:
        """A vector of child k in the axes of body i."""
        s = self.s
        if s.planar:
            return x
        return ex.mul(ex.Symbol(f"R{s.numbers[i]}", "R", (str(s.numbers[k]),), high=str(s.numbers[i])), x)

    def _force(self, i: int) -> Expression:
        s = self.s
        parts = [self._needed(i), *(self._outer(i, s.force_name(i, k), k) for k in s.tree.children(i))]
        if s.load and self.tip == i:
            parts.append(ex.neg(vec("f")))
        return ex.add(*parts)

    def _moment_name(self, i: int) -> Expression:
        return self.s.angular_name("M" if self.s.planar else "n", i)

    def _moment(self, i: int) -> Expression:
        s = self.s
        parts = [s.angular_name("Mc" if s.planar else "nc", i)]
        parts += [self._outer(i, self._moment_name(k), k) for k in s.tree.children(i)]
        parts.append(ex.cross(s.name("sc", i), self._needed(i)))
        for k in s.tree.children(i):
            arm = s.name("s", i) if len(s.tree.children(i)) == 1 else s.name(f"s{s.numbers[i]}_", k)
            parts.append(ex.cross(arm, self._outer(i, s.force_name(i, k), k)))
        if s.load and self.tip == i:
            parts.append(ex.neg(ex.cross(s.name("s", i), vec("f"))))
        return ex.add(*parts)

    def _motor(self, i: int) -> Expression:
        s = self.s
        parent = s.tree.bodies[i].parent
        if s.turns(i):
            part = self._moment_name(i) if s.planar else ex.dot(self._moment_name(i), s.name("z", i))
        else:
            part = ex.dot(s.force_name(parent, i), s.name("u", i))
        return ex.add(part, ex.Words("drive")) if s.tree.bodies[i].drive is not None else part


_SPATIAL = {True: ("6.18", "6.19", "6.20", "6.21", "6.22"), False: ("6.24", "6.25", "6.26", "6.27", "6.22")}


def _chain(name: Expression, rule: Expression, value: Expression) -> Equation:
    return eq(name, value) if rule == value else eq(name, rule, value)
