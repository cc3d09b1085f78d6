"""Newton and Euler body by body: free-body diagrams, unknown reactions, elimination, closed form (3.5-3.15).

n_{i,k} is the moment of body i on body k at joint k. A revolute joint's motor is the moment about its axis (in the
plane the whole moment), a prismatic one's the force along its axis; the other components are bearing reactions.
"""

from __future__ import annotations

from freebody.derivations import expression as ex
from freebody.derivations.derivation import Derivation, Step
from freebody.derivations.expression import Equation, Expression, eq
from freebody.derivations.methods.lagrange import closed_form
from freebody.derivations.methods.setting import Setting
from freebody.derivations.names import vec
from freebody.errors import UnknownNameError
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, dot, scale, sub, times

ROUTES = ("centre", "pivot")


def derive(setting: Setting, route: str = "centre") -> Derivation:
    """The derivation; route: moments of each body about its centre of mass, or of what hangs on a joint
    about its pivot."""
    if route not in ROUTES:
        raise UnknownNameError("route", route, "newton-euler", ROUTES)
    work = Work(setting)
    steps = [work.bodies(i) for i in setting.order] if route == "centre" else []
    steps += work.kinematics()
    tau: dict[int, Trig] = {}
    for i in reversed(setting.order):
        more, tau[i] = work.eliminated(i) if route == "centre" else work.about_pivot(i)
        steps += more
    steps.append(closed_form(setting))
    title = "Newton and Euler, body by body" + (", moments about the pivots" if route == "pivot" else "")
    return Derivation(
        "newton-euler", title, setting.equations, tuple(steps), tuple(tau[i] for i in setting.order)
    )


class Work:
    """The steps, and the reactions as they become known."""

    def __init__(self, setting: Setting):
        self.s = setting
        self.f: dict[int, Vector] = {}
        self.n: dict[int, Vector] = {}

    # ------------------------------------------------------------ equations in names
    def force_terms(self, i: int) -> Expression:
        """Forces on body i: by its parent, minus those on its children, its weight, the load on the tip."""
        s = self.s
        terms: list[Expression] = [s.force_name(s.tree.bodies[i].parent, i)]
        terms += [ex.neg(s.force_name(i, k)) for k in s.tree.children(i)]
        if s.weighs:
            terms.append(ex.mul(f"m{s.numbers[i]}", vec("g")))
        if self.loaded(i):
            terms.append(vec("f"))
        return ex.add(*terms)

    def moment_terms(self, i: int) -> Expression:
        """Moments on body i about its centre of mass."""
        s = self.s
        parent = s.tree.bodies[i].parent
        arm = s.name("sc", i)
        terms = [self.joint_moment(i), *(ex.neg(self.joint_moment(k)) for k in s.tree.children(i))]
        terms.append(ex.neg(ex.cross(arm, s.force_name(parent, i))))
        terms += [
            ex.neg(ex.cross(ex.sub(self.reach_name(i, k), arm), s.force_name(i, k)))
            for k in s.tree.children(i)
        ]
        if self.loaded(i):
            terms.append(ex.cross(ex.sub(s.name("s", i), arm), vec("f")))
        return ex.add(*terms)

    def joint_moment(self, i: int) -> Expression:
        """Moment of the parent on body i: in the plane a revolute joint's is its torque."""
        s = self.s
        if s.planar and s.turns(i):
            return s.torque_name(i)
        return s.moment_name(s.tree.bodies[i].parent, i)

    def reach_name(self, i: int, k: int) -> Expression:
        """s_i, or s_{i,k} where body i carries several."""
        s = self.s
        return s.name("s", i) if len(s.tree.children(i)) == 1 else s.name(f"s{s.numbers[i]}_", k)

    def loaded(self, i: int) -> bool:
        """Whether the load on the tip acts on body i."""
        s = self.s
        return bool(s.load) and s.tree.frames[s.symbols.model.frame().name][0] == i

    def inertia_terms(self, i: int) -> Expression:
        """What the moments on body i add up to."""
        s, inertia = self.s, ex.expr(f"I{self.s.numbers[i]}")
        turning = ex.mul(inertia, s.angular_name("omega", i, "_d"))
        if s.planar:
            return turning
        w = s.angular_name("omega", i)
        return ex.add(turning, ex.cross(w, ex.mul(inertia, w)))

    def inertia_force(self, i: int) -> Expression:
        """What the forces on body i add up to."""
        return ex.mul(f"m{self.s.numbers[i]}", self.s.name("vc", i, "_d"))

    # ------------------------------------------------------------ steps
    def bodies(self, i: int) -> Step:
        """Newton and Euler of one free body."""
        s, n = self.s, self.s.numbers[i]
        lines = (
            eq(self.force_terms(i), self.inertia_force(i)),
            eq(self.moment_terms(i), self.inertia_terms(i)),
        )
        known = (
            {1: ("3.10", "3.11"), 2: ("3.12", "3.13")}.get(n, ("3.1", "3.2")) if s.planar else ("6.1", "6.2")
        )
        return Step(
            f"Free body {n}",
            "Cut the body out and put the reactions where it was held: what it does to the next body acts "
            "back on it with the "
            "opposite sign. Forces give the acceleration of the centre of mass, moments about that centre "
            "the turning.",
            lines,
            known,
            figure=f"free-body {n}",
        )

    def kinematics(self) -> list[Step]:
        """Angular velocities, velocities and accelerations of the centres of mass."""
        s = self.s
        w = [eq(s.angular_name("omega", i), s.angular(s.motion.w[i])) for i in s.order]
        wd = [eq(s.angular_name("omega", i, "_d"), s.angular(s.motion.wd[i])) for i in s.order]
        v = [eq(s.name("vc", i), s.column(s.centre_velocity(i))) for i in s.order]
        vd = [eq(s.name("vc", i, "_d"), s.column(s.centre_acceleration(i))) for i in s.order]
        return [
            Step(
                "Angular velocities and accelerations",
                "Each revolute joint adds its rate to the angular velocity of the body before it.",
                (*w, *wd),
                ("3.16", "3.17") if s.planar else ("6.16", "6.20"),
            ),
            Step(
                "Velocities of the centres of mass",
                "They follow from the geometry and the joint rates.",
                tuple(v),
                ("3.18", "3.19") if s.planar else ("6.19",),
                figure="kinematics",
            ),
            Step(
                "Accelerations of the centres of mass",
                "The velocities differentiated with respect to time.",
                tuple(vd),
                ("4.11",) if s.planar else ("6.22",),
            ),
        ]

    def needed(self, i: int) -> Vector:
        """m (v̇_c - g) of body i: what all other forces on it must add up to."""
        s = self.s
        return scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))

    def load(self) -> Vector:
        """The force on the tip, in the axes that are shown."""
        return tuple(self.s.symbols.ring[name] for name in self.s.load)

    def solve(self, i: int) -> None:
        """Reaction at joint i from the two equations of body i, those of its children being known."""
        s, space = self.s, self.s.tree.space
        f = self.needed(i)
        n = add(space.euler(s.inertia(i), s.motion.w[i], s.motion.wd[i]), space.moment(s.centre(i), f))
        for k in s.tree.children(i):
            R = s.motion.joints[k][0]
            f_k, n_k = (self.f[k], self.n[k]) if s.planar else (times(R, self.f[k]), space.turn(R, self.n[k]))
            f = add(f, f_k)
            n = add(n, n_k, space.moment(s.to_child(i, k), f_k))
        if self.loaded(i):
            f, n = sub(f, self.load()), sub(n, space.moment(s.to_tip(i), self.load()))
        self.f[i], self.n[i] = f, n

    def motor(self, i: int) -> Trig:
        """The component of joint i's reaction that its motor gives, and what its drive takes besides."""
        s = self.s
        ((w, v),) = s.tree.bodies[i].columns
        along = dot(w, self.n[i]) + dot(s.axes(i, v), self.f[i])
        k = s.tree.bodies[i].coordinates.v[0]
        return s.symbols.element(along) + self.drive(i, k)

    def drive(self, i: int, k: int) -> Trig:
        """Friction, spring and rotor of the joint of body i, coordinate k."""
        body, q = self.s.tree.bodies[i], self.s.symbols
        rotor = body.drive.rotor * q.qdd[k] if body.drive is not None else q.zero()
        return self.s.equations.drives[k] + rotor

    def eliminated(self, i: int) -> tuple[list[Step], Trig]:
        """The reaction at joint i from Newton's equation, put into Euler's; then the motor's part."""
        s, n = self.s, self.s.numbers[i]
        parent = s.tree.bodies[i].parent
        self.solve(i)
        force = ex.add(self.inertia_force(i), ex.neg(ex.mul(f"m{n}", vec("g"))) if s.weighs else ex.ZERO)
        force = ex.add(force, *(s.force_name(i, k) for k in s.tree.children(i)))
        if self.loaded(i):
            force = ex.sub(force, vec("f"))
        lines: list[Equation] = [eq(s.force_name(parent, i), force)]
        if len(s.tree.children(i)) == 0 or s.planar:
            lines = [eq(s.force_name(parent, i), force, s.column(self.f[i]))]
        tau = self.motor(i)
        lines.append(self.motor_line(i))
        lines.append(eq(s.torque_name(i), s.show(tau)))
        what = "moment equation" if s.turns(i) else "force along the slide"
        return [
            Step(
                f"Eliminate the reaction at joint {n}",
                f"Newton's equation of body {n} gives the force at joint {n}; its {what} then gives the "
                f"motor's part.",
                tuple(lines),
                self.numbered(n),
            )
        ], tau

    def numbered(self, n: int) -> tuple[str, ...]:
        """The notes' number of the elimination at joint n."""
        return {1: ("3.15",), 2: ("3.14",)}.get(n, ()) if self.s.planar else ()

    def motor_line(self, i: int) -> Equation:
        """How the motor's part comes from the equations of body i."""
        s = self.s
        parent = s.tree.bodies[i].parent
        if not s.turns(i):
            axis = s.name("u", i)
            line = ex.dot(axis, s.force_name(parent, i))
        elif s.planar:
            terms = [self.inertia_terms(i), ex.cross(s.name("sc", i), s.force_name(parent, i))]
            terms += [self.joint_moment(k) for k in s.tree.children(i)]
            terms += [
                ex.cross(ex.sub(self.reach_name(i, k), s.name("sc", i)), s.force_name(i, k))
                for k in s.tree.children(i)
            ]
            if self.loaded(i):
                terms.append(ex.neg(ex.cross(ex.sub(s.name("s", i), s.name("sc", i)), vec("f"))))
            line = ex.add(*terms)
        else:
            line = ex.dot(s.name("z", i), self.joint_moment(i))
        body = s.tree.bodies[i]
        if body.drive is not None:
            line = ex.add(line, ex.Words("drive"))
        return eq(s.torque_name(i), line)

    def about_pivot(self, i: int) -> tuple[list[Step], Trig]:
        """One moment (or force) equation of all that hangs on joint i, in which no inner reaction occurs."""
        s, n = self.s, self.s.numbers[i]
        self.solve(i)
        tau = self.motor(i)
        return [
            Step(
                f"All that joint {n} carries",
                "Taken as one system its inner reactions cancel, and about the pivot the reaction at the "
                "joint has no moment: one equation gives the motor's part at once."
                if s.turns(i)
                else "Taken as one system its inner reactions cancel; the force along the slide is the motor's.",
                (self.pivot_line(i), eq(s.torque_name(i), s.show(tau))),
                ("3.3", "3.4") if s.planar and n == 1 else (),
                figure=f"free-body {n}",
            )
        ], tau

    def pivot_line(self, i: int) -> Equation:
        """Σ over the subtree."""
        s = self.s
        terms = []
        for k in self.subtree(i):
            m = s.numbers[k]
            rate = ex.sub(ex.mul(f"m{m}", s.name("vc", k, "_d")), ex.mul(f"m{m}", vec("g")))
            if s.turns(i):
                arm = s.name("sc", i) if k == i else s.name(f"r{s.numbers[i]}_c", k)
                terms += [self.inertia_terms(k), ex.cross(arm, rate)]
            else:
                terms.append(ex.dot(s.name("u", i), rate))
        if s.load and any(self.loaded(k) for k in self.subtree(i)):
            arm = s.name(f"r{s.numbers[i]}_p", i)
            terms.append(ex.neg(ex.cross(arm, vec("f")) if s.turns(i) else ex.dot(s.name("u", i), vec("f"))))
        return eq(s.torque_name(i), ex.add(*terms))

    def subtree(self, i: int) -> list[int]:
        """Body i and all that hangs on it."""
        return [i, *(k for child in self.s.tree.children(i) for k in self.subtree(child))]
