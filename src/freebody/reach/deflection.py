"""`deflection`: how far a robot with compliant joints yields under its weight and under loads."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from freebody.any_chain.dynamics import static_torque
from freebody.arrays import Array, at_sample
from freebody.by_value import ByValue
from freebody.errors import SingularError, listed
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.doubts import Doubt, attribute, doubts_on, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.reach.compliant_joints import (
    CompliantJoints,
    compliant_joints,
    has_springs,
    tangent,
)
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.trees.kinematics import jacobian
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    common_batch,
    finite_vector,
    wrenches_by_frame,
)

if TYPE_CHECKING:
    import xarray as xr

_SOFT = 1e-12
"""Stiffness of some motion, relative to the largest, that is none."""
_FAR = 0.1
"""rad: joints that yield further do not yield as the undeflected robot says."""


@dataclass(frozen=True, eq=False, repr=False)
class Deflection(Tabled, ByValue):
    """How far a frame is displaced at each posture (...), its drives standing still.

    displacement: (..., six), of the frame's origin (m), then the rotation vector (rad; in the plane
    the angle), world axes. by_gravity, by_wrenches: its two parts. joints: (..., nv), by how much
    each coordinate yields, rad (m); 0 of those that stand still. joint_names: (nv,). frame: its
    name. doubts: those on the robot's masses.
    """

    by_gravity: Array
    by_wrenches: Array
    joints: Array
    joint_names: tuple[str, ...]
    frame: str
    turns: tuple[bool, ...]
    """Whether each coordinate is an angle."""
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)

    @property
    def displacement(self) -> Array:
        """(..., six), the whole."""
        return self.by_gravity + self.by_wrenches

    @property
    def distance(self) -> Array:
        """(...), m, by which the frame's origin is displaced."""
        size = self.displacement.shape[-1]
        return np.asarray(np.linalg.norm(self.displacement[..., : 3 if size == 6 else 2], axis=-1))

    @property
    def far(self) -> np.ndarray:
        """(...), whether an angle yields by more than 0.1 rad: the displacement, which is linear in
        the loads, is then only a hint."""
        return np.asarray((np.abs(self.joints[..., list(self.turns)]) > _FAR).any(axis=-1))

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the postures: displacement with its parts, and joints."""
        dims = axes_of("posture", self.joints.ndim - 1)
        space = self.by_gravity.shape[-1] == 6
        rows = ("x", "y", "z", "rx", "ry", "rz") if space else ("x", "y", "r")
        at, of = (*dims, "component"), f"displacement of {self.frame}"
        return labelled(
            {
                "displacement": (at, self.displacement, "m|rad", of),
                "by_gravity": (at, self.by_gravity, "m|rad", f"{of} by its weight"),
                "by_wrenches": (at, self.by_wrenches, "m|rad", f"{of} by the wrenches"),
                "joints": ((*dims, "coordinate"), self.joints, "rad|m", "yield of the joints"),
            },
            {
                "component": (("component",), np.array(rows), "1", "component"),
                "coordinate": (("coordinate",), np.array(self.joint_names), "1", "coordinate"),
            },
            {"frame": self.frame, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        count = self.distance.size
        most = f", up to {1e3 * self.distance.max():.4g} mm" if count else ""
        return (
            f"Deflection: {counted(count, 'posture')}{most} at frame {self.frame!r}"
            f"{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        if not self.distance.size:
            return TextTable((), ())
        worst = np.unravel_index(np.argmax(self.distance), self.distance.shape)
        rows = []
        for name, turns, x in zip(self.joint_names, self.turns, self.joints[worst], strict=True):
            told = f"{np.degrees(x):.4g} deg" if turns else f"{1e3 * x:.4g} mm"
            rows.append((name, told))
        notes = [in_one_line(self.doubts)] if self.doubts else []
        if self.far.any():
            count = counted(int(self.far.sum()), "posture")
            notes.append(f"Linear in the loads, which is only a hint in {count}: angles > 0.1 rad.")
        return TextTable(("joint, where it is largest", "yields"), rows, notes)


def deflection(
    model: Model,
    q: JointVector,
    wrenches: FrameWrenchTable = None,
    frame: str | None = None,
    *,
    stiffness: JointVector | None = None,
) -> Deflection:
    """How far a frame of a robot is displaced by the robot's weight and by loads: the drives stand
    still, and the joints yield.

    Parameters
    ----------
    model
        An open chain, whose flexible joints (`Model.with_flexible_joint`), springs of passive
        joints and struts yield. What it carries (`Model.with_payload`) is part of its weight.
    q
        (..., nq), where the robot would be without weight and loads.
    wrenches
        {frame: (..., six)} exerted on the robot by its surroundings, or one at the tip: force, then
        moment, world axes (N, N m).
    frame
        Name of the frame that is displaced; default the tip.
    stiffness
        (..., nv) or {joint: k}, N m/rad (N/m): between the motor of each joint, which stands still,
        and its link. Infinite, or of a drive left out of the mapping: rigid.

    Returns
    -------
    Deflection
        Linear in the loads: torques, stiffnesses and Jacobian J are those at q, so that the frame
        moves by J K⁻¹ (Jᵀ w - g), with w the loads and g the torques that hold weights and tensed
        springs.

    Raises
    ------
    FreebodyError
        Nothing yields; a closed chain; joints with quaternions.
    SingularError
        A joint that nothing holds.
    ShapeError, NotFiniteError, UnknownNameError
    """
    function = "deflection"
    joints = compliant_joints(function, model, stiffness, None, resting=True)
    at = finite_vector(function, model, "q", q)
    loads = wrenches_by_frame(function, model, wrenches)
    told = {f"wrenches[{name!r}]": load for name, load in loads.items()}
    batch = common_batch(function, {"q": at, "stiffness": joints.given, **told})
    name = model.frame(frame).name
    weight = static_torque(joints.model, at)[..., joints.moving]
    pull = np.zeros_like(weight)
    if loads:
        pull = static_torque(joints.model, at, loads)[..., joints.moving] - weight
    sides = np.stack(np.broadcast_arrays(weight, pull), axis=-1)
    parts = np.zeros((*batch, model.nv, 2))
    parts[..., joints.moving, :] = -_yielded(function, joints, at, sides)
    moved = jacobian(model, at, name) @ parts
    return Deflection(
        moved[..., 0],
        moved[..., 1],
        parts.sum(axis=-1),
        model.velocity_names,
        name,
        tuple(x for b in model.bodies if b.joint.mimic is None for x in b.kind.angular),
        doubts_on(model, MASSES),
    )


def _yielded(function: str, joints: CompliantJoints, q: Array, torques: Array) -> Array:
    """K⁻¹ times torques (..., k, m); refuses stiffnesses that leave a motion to nothing."""
    if not has_springs(joints.model):
        _require_held(function, joints, joints.given)
        return torques / joints.given[..., None]
    K = tangent(joints, q, weightless=True)
    symmetric = 0.5 * (K + np.swapaxes(K, -1, -2))
    _require_held(function, joints, np.asarray(np.linalg.eigvalsh(symmetric), dtype=float))
    return np.asarray(np.linalg.solve(K, torques), dtype=float)


def _require_held(function: str, joints: CompliantJoints, values: Array) -> None:
    """Refuse eigenvalues (..., k) of stiffnesses of which one is none."""
    loose = np.argwhere(values.min(axis=-1) <= _SOFT * np.abs(values).max(axis=-1))
    if len(loose):
        raise SingularError(
            f"{function}: nothing holds all of {listed(map(repr, joints.names), 8)} of "
            f"{joints.model.name!r}{at_sample(loose[0])}: a joint has no spring, or one that "
            f"pushes away. Give passive joints springs."
        )
