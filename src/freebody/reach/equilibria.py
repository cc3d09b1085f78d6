"""Where robots with compliant joints come to rest under weights and loads: in proportion to these,
and by Newton's method where that is not good enough."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from scipy.spatial.transform import Rotation

from freebody.any_chain.dynamics import static_torque
from freebody.arrays import Array, at_sample
from freebody.errors import SingularError, listed
from freebody.lazy import Keeps, cached_property
from freebody.loops.closure_checks import closing
from freebody.reach.compliant_joints import CompliantJoints, has_springs, tangent
from freebody.reach.loop_motions import loop_motions
from freebody.trees.kinematics import forward_kinematics, jacobian
from freebody.trees.positions import difference, integrate

_SOFT = 1e-12
"""Stiffness of some motion, relative to the largest, that is none."""
_STEPS = 60
_ARRIVED = 1e-12
"""rad, m: a step of the iteration that is none."""
_LONGEST = 0.3
"""rad, m: the longest step."""
_CLOSED = 1e-9
"""Scaled loop equations of a position that is closed."""


@dataclass(frozen=True)
class Yielded:
    """Where a robot came to rest: by how much a frame is displaced (n, six), and coordinates (n,
    nv)."""

    displacement: Array
    joints: Array


@dataclass(frozen=True, eq=False)
class Equilibria(Keeps):
    """A robot with compliant joints at postures q (n, nq) without weights and loads, and the loads
    {frame: (n, six)}."""

    function: str
    joints: CompliantJoints
    q: Array
    loads: Mapping[str, Array]

    def displaced(self, frame: str, iterate: bool) -> tuple[Yielded, Yielded, Array]:
        """(by its weight, by weight and loads, by how much (n,) the answer in proportion to these
        misses, m)."""
        parts, tree = self._linear, self.joints.model.opened
        moved = jacobian(tree, self.q, frame) @ parts
        linear = [Yielded(moved[..., 0], parts[..., 0]), Yielded(moved.sum(-1), parts.sum(-1))]
        T0 = forward_kinematics(tree, self.q, frame)
        if iterate:
            whole = self._settled(T0, frame, linear[1], self.loads)
            weight = self._settled(T0, frame, linear[0], {}) if self.loads else whole
            reached = whole.displacement[:, : self.joints.model.dim]
        else:
            weight, whole = linear
            y, _ = self._moved(self.q, whole.joints)
            y, _ = self._moved(y, self._step(y, self.loads, exact=False)[0])
            reached = _shift(T0, forward_kinematics(tree, y, frame))
        missed = reached - linear[1].displacement[:, : self.joints.model.dim]
        return weight, whole, np.asarray(np.linalg.norm(missed, axis=-1))

    # ------------------------------------------------------------ in proportion
    @cached_property
    def _linear(self) -> Array:
        """Displacements (n, nv, 2) of the coordinates, linear in weights and in loads, that these
        cause."""
        joints, tree = self.joints, self.joints.model.opened
        weight = static_torque(tree, self.q)
        pull = static_torque(tree, self.q, self.loads) - weight if self.loads else 0.0 * weight
        sides, W = np.stack([weight, pull], axis=-1), self._ways(self.q)
        parts = np.zeros_like(sides)
        if W is None:
            parts[:, joints.moving] = -self._solved(self._springs, sides[:, joints.moving])
            return parts
        return -W @ self._solved(self._reduced(self._springs, W), np.swapaxes(W, -1, -2) @ sides)

    @cached_property
    def _springs(self) -> Array:
        """Stiffnesses (n, k, k) of the moving coordinates without those of weights; their diagonals
        (n, k) where nothing couples them."""
        joints = self.joints
        if has_springs(joints.model):
            return tangent(joints, self.q, weightless=True)
        return joints.given

    def _ways(self, q: Array) -> Array | None:
        """The motions (n, nv, f) that loops leave; None of an open chain, where each coordinate is
        one."""
        if not self.joints.model.loops:
            return None
        return loop_motions(self.function, self.joints, q).ways

    def _reduced(self, K: Array, W: Array) -> Array:
        moving = W[:, self.joints.moving]
        pulled = K[..., None] * moving if K.ndim == 2 else K @ moving
        return np.swapaxes(moving, -1, -2) @ pulled

    def _solved(self, K: Array, torques: Array) -> Array:
        """K⁻¹ times torques (n, f, m); refuses stiffnesses that leave a motion to nothing."""
        values = _eigenvalues(K)
        loose = np.argwhere(values.min(axis=-1) <= _SOFT * np.abs(values).max(axis=-1))
        if len(loose):
            raise SingularError(
                f"{self.function}: nothing holds all of {listed(map(repr, self.joints.names), 8)} "
                f"of {self.joints.model.name!r}{at_sample(loose[0])}: a joint has no spring, or "
                f"one that pushes away. Give passive joints springs."
            )
        return _divided(K, torques)

    # ------------------------------------------------------------ until all balances
    def _settled(
        self, T0: Array, frame: str, start: Yielded, loads: Mapping[str, Array]
    ) -> Yielded:
        """Where the robot rests under loads, by Newton's method; NaN where it has not come to rest,
        or falls away. T0: of the frame at q."""
        tree = self.joints.model.opened
        y, left = self._moved(self.q, start.joints)
        rests, stable = np.zeros((2, len(y)), dtype=bool)
        for _ in range(_STEPS):
            step, stable = self._step(y, loads, exact=True)
            step[~np.isfinite(step).all(axis=-1)] = 0.0  # of what nothing holds there
            longest = np.abs(step).max(axis=-1, initial=0.0, keepdims=True)
            rests = longest[:, 0] <= _ARRIVED
            if rests.all():
                break
            y, left = self._moved(y, step * np.minimum(1.0, _LONGEST / (longest + 1e-300)))
        joints = difference(tree, self.q, y)
        joints[:, self.joints.still] = 0.0
        parts = _displacement(T0, forward_kinematics(tree, y, frame)), joints
        good = (rests & stable & (left < _CLOSED))[:, None]
        return Yielded(*(np.where(good, part, np.nan) for part in parts))

    def _moved(self, q: Array, way: Array) -> tuple[Array, Array]:
        """(positions (n, nq) moved along a way (n, nv) of small steps, how far loops are open)."""
        moved = integrate(self.joints.model.opened, q, way)
        if not self.joints.model.loops:
            return moved, np.zeros(len(q))
        return closing(self.joints.model, moved, self.joints.moving.tolist())

    def _step(self, y: Array, loads: Mapping[str, Array], exact: bool) -> tuple[Array, np.ndarray]:
        """(a step (n, nv) towards balance from y, whether the robot would be stable there); exact:
        with the stiffness that weights, loads and loops have at y, else with that of springs."""
        joints, tree = self.joints, self.joints.model.opened
        at = joints.moving
        needed = static_torque(tree, y, loads or None)
        needed[:, at] += joints.given * difference(tree, self.q, y)[:, at]
        K = tangent(joints, y, wrenches=loads) if exact else self._springs
        step = np.zeros_like(needed)
        if joints.model.loops:
            found = loop_motions(self.function, joints, y, needed)
            W = found.ways
            K = self._reduced(K, W) + (found.bend if exact else 0.0)
            power = np.swapaxes(W, -1, -2) @ needed[..., None]
            step = -(W @ _divided(K, power))[..., 0]
        else:
            step[:, at] = -_divided(K, needed[:, at, None])[..., 0]
        return step, _eigenvalues(K).min(axis=-1) > 0.0


def _divided(K: Array, torques: Array) -> Array:
    """K⁻¹ times torques (n, f, m); K (n, f, f), or its diagonal (n, f)."""
    found = torques / K[..., None] if K.ndim == 2 else np.linalg.solve(K, torques)
    return np.asarray(found, dtype=float)


def _eigenvalues(K: Array) -> Array:
    """Eigenvalues (n, f) of the symmetric parts of K (n, f, f), or K itself where it is a diagonal
    (n, f)."""
    found = K if K.ndim == 2 else np.linalg.eigvalsh(0.5 * (K + np.swapaxes(K, -1, -2)))
    return np.asarray(found, dtype=float)


def _displacement(T0: Array, T1: Array) -> Array:
    """The displacements (n, six) of frames (n, dim + 1, dim + 1): m, then the rotation vector."""
    d = T0.shape[-1] - 1
    turn = T1[:, :d, :d] @ np.swapaxes(T0[:, :d, :d], -1, -2)
    if d == 3:
        return np.concatenate([_shift(T0, T1), Rotation.from_matrix(turn).as_rotvec()], axis=-1)
    angle = np.arctan2(turn[:, 1, :1], turn[:, 0, :1])
    return np.concatenate([_shift(T0, T1), angle], axis=-1)


def _shift(T0: Array, T1: Array) -> Array:
    """The displacements (n, dim) of the origins of frames."""
    return T1[:, :-1, -1] - T0[:, :-1, -1]
