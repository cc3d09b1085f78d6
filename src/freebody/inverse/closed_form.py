"""Which closed form fits an arm: by the lines its joints turn about and slide along, never by a
name.

Every form is a recipe from displacements X = T T(0)⁻¹ (a rotation and a shift per target) to
candidates for all joint positions. Candidates are complete, but may hold more than the solutions:
whoever calls verifies them.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.joint_lines import can_meet, common_point, parallel
from freebody.algorithms.screws import Screw, ScrewChain
from freebody.arrays import Array
from freebody.inverse import branch_names
from freebody.inverse import subproblems as sp
from freebody.inverse.position import Candidates, last_of_three, meet, reach

Reached = tuple[tuple[Screw, ...], Array, Array]


@dataclass(frozen=True, eq=False)
class Displacement:
    """X of each target: rotation R (N, 3, 3), shift p (N, 3)."""

    R: Array
    p: Array

    def of(self, point: Array) -> Array:
        """Where X takes a point (3,): (N, 3)."""
        return self.R @ point + self.p

    def inverse(self) -> Displacement:
        """X⁻¹."""
        back = np.swapaxes(self.R, -1, -2)
        return Displacement(back, -(back @ self.p[..., None])[..., 0])


@dataclass(frozen=True, eq=False)
class ClosedFormSolver(ABC):
    """A closed form for one chain."""

    chain: ScrewChain

    @abstractmethod
    def name(self) -> str:
        """What is done, with its source."""

    @abstractmethod
    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        """Candidates (N, k, n); joints that could stand anywhere stay at `prefer` (n,)."""

    @abstractmethod
    def label(self, x: Array) -> list[np.ndarray]:
        """Names (...) of the branches of solutions x (..., n), in parts."""

    def reached(self, X: Displacement) -> Reached | None:
        """(screws, c, points): a target is in the workspace where the screws bring the point c (3,)
        to points (N, 3); None where that is not what decides."""
        return None

    @property
    def screws(self) -> tuple[Screw, ...]:
        """The chain's screws."""
        return self.chain.screws

    @property
    def scale(self) -> float:
        """The chain's length."""
        return self.chain.length


class ThreeJointPosition(ClosedFormSolver):
    """Three joints and the position of the frame: circles and lines, or Pieper's quartic."""

    def name(self) -> str:
        return "closed form: position by three joints (Pieper 1968)"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        found = reach(self.screws, self.chain.p, X.of(self.chain.p), prefer, self.scale)
        assert found is not None  # `closed_form_for` has tried
        return found

    def label(self, x: Array) -> list[np.ndarray]:
        return branch_names.arm(self.screws, self.chain.p, x)

    def reached(self, X: Displacement) -> Reached | None:
        return self.screws, self.chain.p, X.of(self.chain.p)


class ThreeJointOrientation(ClosedFormSolver):
    """Three turning joints and the orientation of the frame."""

    def name(self) -> str:
        return "closed form: orientation by three revolute joints (a spherical triangle)"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        return wrist(self.screws, X.R, prefer)

    def label(self, x: Array) -> list[np.ndarray]:
        return branch_names.wrist(self.screws, x)


@dataclass(frozen=True, eq=False)
class SphericalWristArm(ClosedFormSolver):
    """Six joints, the last three through one point c, which the first three bring to its place
    (Pieper 1968)."""

    c: Array

    def name(self) -> str:
        return "closed form: spherical wrist (Pieper 1968; Paden and Kahan's subproblems)"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        arm = reach(self.screws[:3], self.c, X.of(self.c), prefer[:3], self.scale)
        assert arm is not None
        R = np.eye(3)
        for i, screw in enumerate(self.screws[:3]):
            R = R @ screw.rotation(arm.x[..., i])
        hand = wrist(self.screws[3:], np.swapaxes(R, -1, -2) @ X.R[:, None], prefer[3:])
        return _every_pair(arm, hand)

    def label(self, x: Array) -> list[np.ndarray]:
        return branch_names.arm(self.screws[:3], self.c, x[..., :3]) + branch_names.wrist(
            self.screws[3:], x[..., 3:]
        )

    def reached(self, X: Displacement) -> Reached | None:
        return self.screws[:3], self.c, X.of(self.c)


@dataclass(frozen=True, eq=False)
class ThreeParallelAxes(ClosedFormSolver):
    """Six turning joints, axes 2, 3, 4 parallel, 5 and 6 through one point c: Universal Robots and
    their like.

    Joint 1 puts c at its height along axis 2, joints 5 and 6 turn what is left into a motion in the
    plane across it, and the three parallel joints make that motion (Hawkins 2013; Elias and Wen
    2022).
    """

    c: Array

    def name(self) -> str:
        return "closed form: three parallel axes (Elias and Wen 2022)"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        s1, s2, s3, s4, s5, s6 = self.screws
        w = s2.w
        back = Screw(True, -s1.w, s1.p)
        x1 = sp.at_height_of(back, X.of(self.c), w, self.c @ w)  # (N, 2)
        R1 = s1.rotation(x1)
        v = np.swapaxes(X.R, -1, -2)[:, None] @ (R1 @ w)[..., None]
        v = v[..., 0]  # R1ᵀ R R6ᵀ R5ᵀ w = w, so R6ᵀ R5ᵀ w = v
        x5 = sp.at_angle(Screw(True, -s5.w, s5.p), w, s6.w, sp.angle_between(v, s6.w))  # (N, 2, 2)
        v, x1 = (
            np.broadcast_to(v[..., None, :], (*x5.shape, 3)),
            np.broadcast_to(x1[..., None], x5.shape),
        )
        turned = Screw(True, -s5.w, np.zeros(3)).moved(x5, np.broadcast_to(w, v.shape))
        x6, free6 = sp.onto(Screw(True, s6.w, np.zeros(3)), v, turned, prefer[5])
        G = self._rest(X, x1, x5, x6)
        pair = meet(s2, s3, s4.p, G.of(s4.p), prefer[1:3], self.scale)  # (N, 2, 2, 2, 2)
        x4 = sp.turn_of(G.R, s4.w)[..., None] - pair.x @ np.array([s2.w @ s4.w, s3.w @ s4.w])
        outer = [np.broadcast_to(x[..., None], x4.shape) for x in (x1, x5, x6, free6)]
        x = np.stack([outer[0], pair.x[..., 0], pair.x[..., 1], x4, outer[1], outer[2]], axis=-1)
        free = np.zeros(x.shape, dtype=bool)
        free[..., 1:3], free[..., 5] = pair.free, outer[3]
        shape = (len(X.p), -1, 6)
        return Candidates(x.reshape(shape), free.reshape(shape))

    def _rest(self, X: Displacement, x1: Array, x5: Array, x6: Array) -> Displacement:
        """e1⁻¹ X e6⁻¹ e5⁻¹."""
        s1, s5, s6 = self.screws[0], self.screws[4], self.screws[5]

        def motion(p: Array) -> Array:
            p = s6.moved(-x6, s5.moved(-x5, np.broadcast_to(p, (*x5.shape, 3))))
            p = (X.R[:, None, None] @ p[..., None])[..., 0] + X.p[:, None, None]
            return s1.moved(-x1, p)

        shift = motion(np.zeros(3))
        return Displacement(np.stack([motion(e) - shift for e in np.eye(3)], axis=-1), shift)

    def label(self, x: Array) -> list[np.ndarray]:
        s1, s2, s3, s4, s5, s6 = self.screws
        carried = s3.moved(x[..., 2], s4.moved(x[..., 3], self.c))
        side = branch_names.shoulder(s1, s2, s2.moved(x[..., 1], carried))
        elbow = branch_names.elbow(s2, s3, s4.p, x[..., 1:3], side)
        return [side, elbow, branch_names.flip(s2.w, s5, s6.w, x[..., 4])]


@dataclass(frozen=True, eq=False)
class ReversedArm(ClosedFormSolver):
    """A form for the arm seen from its frame: joints in reverse order, X⁻¹ for X, turns the other
    way."""

    forward: ClosedFormSolver

    def name(self) -> str:
        return self.forward.name() + ", seen from the tip"

    def solve(self, X: Displacement, prefer: Array) -> Candidates:
        found = self.forward.solve(X.inverse(), -prefer[::-1])
        return Candidates(-found.x[..., ::-1], found.free[..., ::-1])

    def label(self, x: Array) -> list[np.ndarray]:
        return self.forward.label(-x[..., ::-1])

    def reached(self, X: Displacement) -> Reached | None:
        return self.forward.reached(X.inverse())


def wrist(screws: Sequence[Screw], R: Array, prefer: Array) -> Candidates:
    """Turns (..., 2, 3) with R4 R5 R6 = R (..., 3, 3); where axes 4 and 6 fall together joint 4 is
    free."""
    s4, s5, s6 = screws
    aim = R @ s6.w
    x5 = sp.at_angle(s5, s6.w, s4.w, sp.angle_between(aim, s4.w))
    aim = np.broadcast_to(aim[..., None, :], (*x5.shape, 3))
    turning = Screw(True, s4.w, np.zeros(3))
    x4, free = sp.onto(turning, s5.turned(x5, np.broadcast_to(s6.w, aim.shape)), aim, prefer[0])
    rest = np.swapaxes(s4.rotation(x4) @ s5.rotation(x5), -1, -2) @ R[..., None, :, :]
    x = np.stack([x4, x5, sp.turn_of(rest, s6.w)], axis=-1)
    none = np.zeros_like(free)
    return Candidates(x, np.stack([free, none, none], axis=-1))


def _every_pair(arm: Candidates, hand: Candidates) -> Candidates:
    """Each solution of the arm (N, k, 3) with those of the hand (N, k, 2, 3) that belong to it."""
    shape = (*hand.x.shape[:-1], 3)
    x = np.concatenate([np.broadcast_to(arm.x[..., None, :], shape), hand.x], axis=-1)
    free = np.concatenate([np.broadcast_to(arm.free[..., None, :], shape), hand.free], axis=-1)
    return Candidates(x.reshape(len(x), -1, 6), free.reshape(len(x), -1, 6))


# ---------------------------------------------------------------- which form fits
def six_joints(chain: ScrewChain) -> ClosedFormSolver | None:
    """The form for the whole pose of a six-joint arm."""
    for turned in (chain, reversed_chain(chain)):
        form = _wristed(turned) or _three_parallel(turned)
        if form is not None:
            return form if turned is chain else ReversedArm(chain, form)
    return None


def three_joints(chain: ScrewChain) -> ClosedFormSolver | None:
    """The form for the position of a three-joint arm."""
    s1, s2, s3 = chain.screws
    return (
        ThreeJointPosition(chain)
        if last_of_three(s1, s2, s3, chain.p, chain.length) is not None
        else None
    )


def three_turns(chain: ScrewChain) -> ClosedFormSolver | None:
    """The form for the orientation of a three-joint arm."""
    s = chain.screws
    bent = not parallel(s[0].w, s[1].w) and not parallel(s[1].w, s[2].w)
    return ThreeJointOrientation(chain) if bent and all(x.turning for x in s) else None


def reversed_chain(chain: ScrewChain) -> ScrewChain:
    """The screws in reverse order."""
    return ScrewChain(
        chain.screws[::-1],
        chain.R,
        chain.p,
        chain.index[::-1],
        chain.ratio,
        chain.offset,
        chain.length,
    )


def _wristed(chain: ScrewChain) -> ClosedFormSolver | None:
    s = chain.screws
    if not all(x.turning for x in s[3:]) or parallel(s[3].w, s[4].w) or parallel(s[4].w, s[5].w):
        return None
    c = common_point(s[3:], chain.length)
    if c is None or last_of_three(s[0], s[1], s[2], c, chain.length) is None:
        return None
    return SphericalWristArm(chain, c)


def _three_parallel(chain: ScrewChain) -> ClosedFormSolver | None:
    s = chain.screws
    if not all(x.turning for x in s) or not (parallel(s[1].w, s[2].w) and parallel(s[2].w, s[3].w)):
        return None
    if parallel(s[0].w, s[1].w) or parallel(s[3].w, s[4].w) or parallel(s[4].w, s[5].w):
        return None
    c = common_point(s[4:], chain.length)
    if c is None or not can_meet(s[1], s[2], chain.length):
        return None
    return ThreeParallelAxes(chain, c)
