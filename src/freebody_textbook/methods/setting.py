"""What all derivations of a model share: its symbols, its motion, and how its vectors are called
and shown.

In the plane vectors have world components, as in chapters 1 to 5 of the notes; in space those of
the body's own frame, as in chapter 6.
"""

from __future__ import annotations

from freebody.algorithms.kinematics import (
    BodyMotions,
    Pose,
    joint_poses,
    outward,
    world_poses,
)
from freebody.algorithms.rnea import External, Recursion, rnea
from freebody.lazy import cached_property
from freebody.spatial import Vector, add, sub, times, transposed
from freebody_textbook.methods.shown_mechanism import ShownMechanism


class Setting(ShownMechanism):
    """One model, ready to be derived: how its bodies move."""

    # ------------------------------------------------------------ motion
    @cached_property
    def motion(self) -> BodyMotions:
        """Velocities and accelerations of every body, base at rest, body axes."""
        return outward(self.tree, self.symbols.q, *self._rates)

    @property
    def _rates(self) -> tuple[Vector, Vector]:
        """Velocities and accelerations of the coordinates."""
        still = (0.0,) * self.tree.nv
        return (still, still) if self.at_rest else (self.symbols.qd, self.symbols.qdd)

    def recursion(self, gravity: str) -> Recursion:
        """One run of the recursion; gravity: "base" or "explicit"."""
        return rnea(self.tree, self.symbols.q, *self._rates, self.tip_load(), gravity)

    def tip_load(self) -> tuple[External, ...]:
        """The load in the axes of the tip's body, as the recursion takes it."""
        if not self.load:
            return ()
        body, _, p = self.tip_frame
        world = world_poses(self.tree, joint_poses(self.tree, self.symbols.q))
        force = times(transposed(world[body][0]), self.load_components)
        return ((body, force, self.tree.space.moment(p, force)),)

    @cached_property
    def world(self) -> list[Pose]:
        """Pose of every body in the world."""
        return world_poses(self.tree, self.motion.joints)

    # ------------------------------------------------------------ vectors
    def axes(self, i: int, v: Vector) -> Vector:
        """Components of a vector of body i as they are shown: the world's in the plane, the body's
        in space."""
        return times(self.world[i][0], v) if self.planar else v

    def axis(self, i: int) -> Vector:
        """Direction of joint i, in the axes that are shown."""
        return self.axes(i, self.tree.bodies[i].axis)

    def centre(self, i: int) -> Vector:
        """Joint origin to the centre of mass of body i."""
        return self.axes(i, self._mass(i).c)

    def centre_velocity(self, i: int) -> Vector:
        """Velocity of the centre of mass of body i."""
        c = self._mass(i).c
        return self.axes(i, add(self.motion.v[i], self.tree.space.cross(self.motion.w[i], c)))

    def centre_acceleration(self, i: int) -> Vector:
        """Acceleration of the centre of mass of body i."""
        return self.axes(i, add(self.motion.vd[i], times(self.motion.rates[i], self._mass(i).c)))

    def centre_position(self, i: int) -> Vector:
        """Centre of mass of body i in the world."""
        R, p = self.world[i]
        return add(p, times(R, self._mass(i).c))

    def to_child(self, i: int, k: int) -> Vector:
        """Joint origin of body i to that of its child k."""
        if self.planar:
            return sub(self.world[k][1], self.world[i][1])
        return self.motion.joints[k][1]

    def ends_in_tip(self, i: int) -> bool:
        """Whether body i is the last of its branch and carries the tip."""
        has_tip = self.symbols.model.tip is not None
        return has_tip and not self.tree.children(i) and self.tip == i

    def to_tip(self, i: int) -> Vector:
        """Joint origin of body i to the tip, which is fixed to it."""
        return self.axes(i, self.tip_frame[2])

    def gravity(self, i: int) -> Vector:
        """The gravity field in the axes of body i."""
        return (
            self.tree.gravity
            if self.planar
            else times(transposed(self.world[i][0]), self.tree.gravity)
        )

    def tip_force(self) -> Vector:
        """The load on the tip, given in the world's axes, in those that are shown for its body."""
        force = self.load_components
        return force if self.planar else times(transposed(self.world[self.tip][0]), force)

    def tip_position(self) -> Vector:
        """The tip in the world."""
        R, p = self.world[self.tip]
        return add(p, times(R, self.tip_frame[2]))
