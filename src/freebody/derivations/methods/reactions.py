"""What each joint must carry, from the equations of Newton and Euler solved from the last body
inward."""

from __future__ import annotations

from collections.abc import Iterable

from freebody.derivations.expressions import expression as ex
from freebody.derivations.expressions.expression import Expression
from freebody.derivations.methods.setting import Setting
from freebody.lazy import cached_property
from freebody.scalars.trig import Trig
from freebody.spatial import Vector, add, dot, scale, sub, times


class SolvedReactions:
    """f and n of body i: force and moment of its parent on it at joint i, in the axes that are
    shown."""

    def __init__(self, setting: Setting):
        self.s = setting
        self.f: dict[int, Vector] = {}
        self.n: dict[int, Vector] = {}
        for i in reversed(range(len(setting.tree.bodies))):
            self._solve(i)

    def _solve(self, i: int) -> None:
        """From the two equations of body i, the reactions at its children being known."""
        s, space = self.s, self.s.tree.space
        f = scale(s.mass(i), sub(s.centre_acceleration(i), s.gravity(i)))
        n = add(
            space.euler(s.inertia(i), s.motion.w[i], s.motion.wd[i]), space.moment(s.centre(i), f)
        )
        for k in s.tree.children(i):
            R = s.motion.joints[k][0]
            f_k, n_k = (
                (self.f[k], self.n[k])
                if s.planar
                else (times(R, self.f[k]), space.turn(R, self.n[k]))
            )
            f = add(f, f_k)
            n = add(n, n_k, space.moment(s.to_child(i, k), f_k))
        for force, moment in self.applied(i):
            f, n = sub(f, force), sub(n, moment)
        self.f[i], self.n[i] = f, n

    def applied(self, i: int) -> Iterable[tuple[Vector, Vector]]:
        """Forces on body i from outside, weight apart, with their moments about its joint."""
        s = self.s
        if s.loaded(i):
            yield s.tip_force(), s.tree.space.moment(s.to_tip(i), s.tip_force())

    def motor(self, i: int) -> Trig:
        """The component of joint i's reaction that its motor gives, and what its drive takes
        besides."""
        s = self.s
        ((w, v),) = s.tree.bodies[i].columns
        along = dot(w, self.n[i]) + dot(s.axes(i, v), self.f[i])
        return s.symbols.element(along) + self.drives[i]

    @cached_property
    def drives(self) -> dict[int, Trig]:
        """Friction, spring and rotor of each joint; of one at rest its spring."""
        return {i: drive_part(self.s, i) for i in self.s.order}

    def motor_rule(self, i: int, moment: Expression) -> Expression:
        """The component of the reaction that is the motor's, and its drive's part."""
        s = self.s
        part = s.along(i, moment, s.force_name(s.tree.bodies[i].parent, i))
        return ex.add(part, s.show(self.drives[i]))


def drive_part(s: Setting, i: int) -> Trig:
    """What friction, spring and rotor of joint i take of its motor; at rest the spring alone."""
    body, k = s.tree.bodies[i], s.index(i)
    if body.drive is None:
        return s.symbols.zero()
    if s.at_rest:
        (q,) = body.position(s.symbols.q)
        return s.symbols.element(body.drive.stiffness * (q - body.drive.rest))
    return s.equations.drives[k] + body.drive.rotor * s.symbols.qdd[k]
