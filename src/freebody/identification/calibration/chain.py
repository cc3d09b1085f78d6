"""A robot's chain to its tip with displaced joints: what can be off in it, where it puts a marker
then, and how that changes with everything that can be off.

The chain is a product of exponentials in local frames: behind the placement of each joint as the
model has it stand a small shift d and a small turn exp φ, and then its motion, T_i exp(d) exp(φ)
exp(S_i q_i). So axes that are nearly parallel are no special case (Okamura, Park 1996: kinematic
calibration using the product of exponentials formula; Chen, Yang, Tan, Yeo 2001: local POE model
for robot kinematic calibration). A displacement moves the marker by its adjoint, exactly.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, shown
from freebody.kernels.own_functions import compile as compiled
from freebody.lazy import kept
from freebody.model.model import Model
from freebody.model.piece_paths import put
from freebody.model.placement import rotate, shift
from freebody.spatial import compose, of_dimension
from freebody.targets import Kernel

AXES = ("x", "y", "z")
DISPLACEMENTS = (*AXES, *(f"r{axis}" for axis in AXES))
"""Names of a frame's shift and turn, behind the joint's."""


def turned(vectors: Array) -> Array:
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_rotvec(vectors.reshape(-1, 3)).as_matrix().reshape(*vectors.shape, 3)


def rotation_vectors(R: Array) -> Array:
    """Rotation vectors (..., 3) of rotation matrices (..., 3, 3)."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec().reshape(R.shape[:-1])


def skew(x: Array) -> Array:
    """The matrices (..., 3, 3) whose products with a vector are the cross products of x (..., 3)
    with it."""
    zero = np.zeros(x.shape[:-1])
    a, b, c = np.moveaxis(x, -1, 0)
    rows = [[zero, -c, b], [c, zero, -a], [-b, a, zero]]
    return np.stack([np.stack(row, axis=-1) for row in rows], axis=-2)


def right_jacobian(x: Array) -> Array:
    """J (3, 3) with exp(x + dx) = exp(x) exp(J dx) for a small rotation vector x (3,)."""
    K, angle = skew(x), float(np.linalg.norm(x))
    if angle < 1e-4:
        return np.eye(3) - 0.5 * K + K @ K / 6.0
    a, b = (1.0 - np.cos(angle)) / angle**2, (angle - np.sin(angle)) / angle**3
    return np.eye(3) - a * K + b * K @ K


class MarkerPoses(NamedTuple):
    """Poses of the marker in the instrument's axes, and their changes by all unknowns."""

    position: Array
    """(n, 3) m."""
    rotation: Array
    """(n, 3, 3)."""
    linear: Array
    """(n, 3, k), changes of the position."""
    angular: Array
    """(n, 3, k), turns that go with them."""


@dataclass(frozen=True)
class MeasuredChain:
    """The joints between a robot's base and a frame, and the unknowns of their geometry.

    bodies: indices in the model, base first. columns: of q, one for each. R, p: placements as the
    model has them, the frame's in its body last. spins, slides: motion columns (k, 3) in the axes
    of the joints. kernel: (q, R, p) -> poses of all joints' frames and of the frame.
    """

    model: Model
    frame: str
    bodies: tuple[int, ...]
    columns: tuple[int, ...]
    R: Array
    p: Array
    spins: Array
    slides: Array
    gears: bool
    kernel: Kernel

    @property
    def joints(self) -> tuple[str, ...]:
        """Names of the joints."""
        return tuple(self.model.bodies[i].joint.name for i in self.bodies)

    @property
    def own(self) -> tuple[str, ...]:
        """The unknowns of a joint."""
        return (*DISPLACEMENTS, "offset", *(("gear",) if self.gears else ()))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all unknowns of the geometry, joint by joint."""
        return tuple(f"{joint}.{name}" for joint in self.joints for name in self.own)

    @property
    def turns(self) -> Array:
        """Flags (k,): whether a joint's coordinate is an angle."""
        return np.any(self.spins != 0.0, axis=1)

    @property
    def units(self) -> tuple[str, ...]:
        """Units of all unknowns."""
        frame = ("m",) * 3 + ("rad",) * 3
        gear = ("1",) if self.gears else ()
        return tuple(
            unit for turns in self.turns for unit in (*frame, "rad" if turns else "m", *gear)
        )

    def rows(self, x: Array) -> Array:
        """Unknowns (k, ...) as a row for each joint."""
        return x.reshape(len(self.bodies), -1)

    def frames(self, q: Array, x: Array) -> tuple[Array, Array]:
        """Axes (n, k + 1, 3, 3) and origins (n, k + 1, 3) of the displaced joints' frames before
        they move, and of the frame at the end, at readings q (n, nq) of the joints."""
        rows = self.rows(x)
        R, p = self.R.copy(), self.p.copy()
        p[:-1] += np.einsum("kij,kj->ki", R[:-1], rows[:, :3])
        R[:-1] = R[:-1] @ turned(rows[:, 3:6])
        return self.kernel(self.moved(q, x), R, p)

    def moved(self, q: Array, x: Array) -> Array:
        """Coordinates (n, k) of the joints at readings q (n, nq)."""
        rows, own = self.rows(x), q[:, self.columns]
        return own * (1.0 + rows[:, 7]) + rows[:, 6] if self.gears else own + rows[:, 6]

    def marker_poses(
        self, q: Array, x: Array, instrument: tuple[Array, Array], marker: tuple[Array, Array]
    ) -> MarkerPoses:
        """Where the instrument sees the marker at readings q (n, nq), and the changes by the
        unknowns: of the geometry x, then of the instrument's pose and of the marker's.

        instrument: (R, p) of the world in the instrument's axes; marker: in the frame at the end.
        Their changes are a shift, and a turn in their own axes behind it.
        """
        (R_IW, p_IW), (R_EM, p_EM) = instrument, marker
        R, p = self.frames(q, x)
        R, p = R_IW @ R, p @ R_IW.T + p_IW
        end = p[:, -1] + R[:, -1] @ p_EM
        arms = end[:, None] - p[:, :-1]
        rows, count = self.rows(x), len(self.own)
        n, k = arms.shape[:2]
        linear = np.zeros((n, 3, k * count + 12))
        angular = np.zeros((n, 3, k * count + 12))
        moves, spins = (  # the joints' own columns (n, k, 3, count)
            np.moveaxis(part[:, :, : k * count].reshape(n, 3, k, count), 1, 2)
            for part in (linear, angular)
        )
        axes = R[:, :-1]
        # the shift is in the axes before the turn
        moves[..., :3] = axes @ np.swapaxes(turned(rows[:, 3:6]), 1, 2)
        spins[..., 3:6] = axes @ np.array([right_jacobian(row[3:6]) for row in rows])
        spins[..., 6] = (axes @ self.spins[:, :, None])[..., 0]
        moves[..., 3:7] = -skew(arms) @ spins[..., 3:7]
        moves[..., 6] += (axes @ self.slides[:, :, None])[..., 0]
        if self.gears:
            for part in (moves, spins):
                part[..., 7] = part[..., 6] * q[:, self.columns, None]
        at = k * count
        linear[:, :, at : at + 3] = np.eye(3)
        angular[:, :, at + 3 : at + 6] = R_IW
        linear[:, :, at + 3 : at + 6] = -skew(end - p_IW) @ R_IW
        linear[:, :, at + 6 : at + 9] = R[:, -1]
        rotation = R[:, -1] @ R_EM
        angular[:, :, at + 9 : at + 12] = rotation
        return MarkerPoses(end, rotation, linear, angular)

    def calibrated(self, x: Array) -> Model:
        """The model with the displacements and offsets of x, without its gear factors."""
        found = self.model
        for j, (i, row) in enumerate(zip(self.bodies, self.rows(x), strict=True)):
            joint = found.bodies[i].joint
            offset = row[6]
            placement = (
                joint.placement.then(shift(*map(float, row[:3])))
                .then(rotate(turned(row[3:6])))
                .then(shift(*map(float, offset * self.slides[j])))
                .then(rotate(turned(offset * self.spins[j])))
            )
            found = put(found, ("bodies", i, "joint"), replace(joint, placement=placement))
        return found


def chain_to(model: Model, frame: str | None, gears: bool) -> MeasuredChain:
    """The chain to a frame, the tip if None. Refuses models that cannot be calibrated, with the
    remedy."""
    function = "calibrate"
    model.require_tree(function)
    if model.dim != 3:
        raise FreebodyError(
            f"calibrate: {model.name!r} is planar; calibrate its twin in space: model.to_space()."
        )
    if model.family:
        raise FreebodyError(
            f"calibrate: {model.name!r} is a family; calibrate its members one by one, model[i]."
        )
    model.require_values(function)
    name = model.frame(frame).name
    tree = model.tree
    at, R, p = tree.frames[name]
    path: list[int] = []
    while at >= 0:
        path.insert(0, at)
        at = tree.bodies[at].parent
    bodies = [tree.bodies[k] for k in path]
    of_model = [tree.body_of.index(k) if k in tree.body_of else -1 for k in path]
    for body, i in zip(bodies, of_model, strict=True):
        kind = model.bodies[i].kind if i >= 0 else None
        if kind is None or kind.nq != 1 or kind.nv != 1:
            raise FreebodyError(
                f"calibrate: on the way to {name!r}, joint {shown(body.name)} has more than one "
                f"coordinate; take a frame behind joints that turn or slide."
            )
        if model.bodies[i].joint.mimic is not None:
            raise FreebodyError(
                f"calibrate: on the way to {name!r}, joint {model.bodies[i].joint.name!r} follows "
                f'another; load the robot with mimic="free", and give the positions of both.'
            )
    if not bodies:
        raise FreebodyError(
            f"calibrate: no joint is between the base and {name!r}; name another frame=."
        )
    columns = [body.columns[0] for body in bodies]
    return MeasuredChain(
        model,
        name,
        tuple(of_model),
        tuple(model.coordinates[i].q[0] for i in of_model),
        np.array([*(body.R for body in bodies), R], dtype=float),
        np.array([*(body.p for body in bodies), p], dtype=float),
        np.array([spin for spin, _ in columns], dtype=float),
        np.array([slide for _, slide in columns], dtype=float),
        gears,
        kept(model, f"_calibration_chain {name}", _kernel, bodies),
    )


def _kernel(bodies: Any) -> Kernel:
    """The kernel (q, R, p) -> (R, p) of the frames along a chain, whose placements are inputs."""
    k, space = len(bodies), of_dimension(3)

    def calibration_chain(q: Any, R: Any, p: Any) -> Any:
        before, moved = [], None
        for j in range(k + 1):
            placed = (R[j], p[j])
            before.append(placed if moved is None else compose(moved, placed))
            if j < k:
                body = bodies[j]
                moved = compose(before[-1], body.primitive.pose(space, body.axis, (q[j],)))
        return {"axes": tuple(x for x, _ in before), "origins": tuple(x for _, x in before)}

    inputs = {"q": (k,), "R": (k + 1, 3, 3), "p": (k + 1, 3)}
    return compiled(calibration_chain, inputs, {"axes": (k + 1, 3, 3), "origins": (k + 1, 3)})
