"""Reactions that each joint must carry, from the equations of Newton and Euler solved from the last
body inward."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from freebody.expressions import expression as ex
from freebody.expressions.expression import Expression
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, dot, scale, sub, times
from freebody_textbook.methods.setting import Setting

Reaction = tuple[Vector, Vector]
"""Force and moment at a joint."""


class SolvedReactions:
    """f and n of body i: force and moment of its parent on it at joint i, in the axes that are
    shown."""

    def __init__(self, setting: Setting):
        self.s = setting
        self._found = self._inward(lambda i, reaction: reaction)

    @property
    def f(self) -> dict[int, Vector]:
        """Forces at the joints by body."""
        return {i: f for i, (f, _) in self._found.items()}

    @property
    def n(self) -> dict[int, Vector]:
        """Moments of the reactions about the joints."""
        return {i: n for i, (_, n) in self._found.items()}

    @cached_property
    def borne(self) -> dict[int, Reaction]:
        """(f, n) by the bearings alone: without what a joint without a motor would have to give
        along its coordinate, which vanishes by its equation of motion."""
        return self._inward(self._without_motor)

    def _without_motor(self, i: int, reaction: Reaction) -> Reaction:
        s, (f, n) = self.s, reaction
        if s.driven(i) or not s.is_alone(i) or s.turns(i) == s.slides(i):
            return reaction
        if not self.drives[i].is_zero:
            return reaction
        ((w, v),) = s.tree.bodies[i].columns
        v = s.axes(i, v)
        if s.turns(i):
            return f, sub(n, scale(dot(w, n), w))
        return sub(f, scale(dot(v, f), v)), n

    def _inward(self, passed_on: Callable[[int, Reaction], Reaction]) -> dict[int, Reaction]:
        found: dict[int, Reaction] = {}
        for i in reversed(range(len(self.s.tree.bodies))):
            found[i] = passed_on(i, self._solved(i, found))
        return found

    def _solved(self, i: int, found: dict[int, Reaction]) -> Reaction:
        """Reaction at joint i from the two equations of body i, the reactions at its children being
        known."""
        s, space = self.s, self.s.tree.space
        f = scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))
        n = add(
            space.euler(s.inertia(i), s.motion.w[i], s.motion.wd[i]), space.moment(s.centre(i), f)
        )
        for k in s.tree.children(i):
            R = s.motion.joints[k][0]
            f_k, n_k = found[k]
            if not s.planar:
                f_k, n_k = times(R, f_k), space.turn(R, n_k)
            f = add(f, f_k)
            n = add(n, n_k, space.moment(s.to_child(i, k), f_k))
        for force, moment in self.applied(i):
            f, n = sub(f, force), sub(n, moment)
        return f, n

    def applied(self, i: int) -> Iterable[tuple[Vector, Vector]]:
        """Forces on body i from outside, weight apart, with their moments about its joint."""
        s = self.s
        if s.loaded(i):
            yield s.tip_force(), s.tree.space.moment(s.to_tip(i), s.tip_force())

    def motor(self, i: int) -> Trig:
        """The component of joint i's reaction that its motor gives, with those of the joints that
        it moves besides, and what its drive takes."""
        s, total = self.s, self.drives[i]
        for k in s.together(i):
            f, n = self._found[k]
            ((w, v),) = s.tree.bodies[k].columns
            total = total + s.ratio(k) * (dot(w, n) + dot(s.axes(k, v), f))
        return s.symbols.element(total)

    @cached_property
    def drives(self) -> dict[int, Trig]:
        """Friction, springs and rotors by the motors that they burden; at rest the springs."""
        return {i: drive_part(self.s, i) for i in self.s.leaders}

    def motor_rule(self, i: int, moment: Expression) -> Expression:
        """The component of the reaction that is the motor's, and its drive's part."""
        s = self.s
        part = s.along(i, moment, s.force_name(s.tree.bodies[i].parent, i))
        return ex.add(part, s.show(self.drives[i]))


def drive_part(s: Setting, i: int) -> Trig:
    """The torque that friction, spring and rotor of joint i, and of those that follow it, take of
    its motor; at rest what is there then, such as springs."""
    total = s.symbols.zero()
    for k in s.together(i) if s.at_rest else ():
        body = s.tree.bodies[k]
        if body.drive is not None:
            at_rest = body.drive.only(lambda law: not law.only_moving)
            total = total + s.ratio(k) * at_rest.torque(s.symbols.q, (0.0,) * s.tree.nv)
    return total if s.at_rest else s.equations.drives[s.index(i)] + s.rotor_part(i)
