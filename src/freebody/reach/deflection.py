"""`deflection`: how far a robot with compliant joints yields under its weight and under loads."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.doubts import Doubt, attribute, doubts_on, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.reach.compliant_joints import Stiffness, compliant_joints, turning
from freebody.reach.each_member import of_members
from freebody.reach.equilibria import Equilibria
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    common_batch,
    finite_vector,
    wrenches_by_frame,
)

if TYPE_CHECKING:
    import xarray as xr

_FAR = 0.1
"""rad: joints that yield further do not yield as the undeflected robot says."""


@dataclass(frozen=True, eq=False, repr=False)
class Deflection(Tabled, ByValue):
    """How far a frame is displaced at each posture (...), its drives standing still.

    displacement: (..., six), of the frame's origin (m), then the rotation vector (rad; in the plane
    the angle), world axes; NaN where no equilibrium was found. by_gravity: by the weight alone;
    by_wrenches: what the loads add. joints: (..., nv), by how much each coordinate yields, rad (m);
    0 of those that stand still. joint_names: (nv,). frame: its name. iterated: whether the robot
    has yielded until all balanced, or in proportion to the loads. doubts: those on the robot's
    masses. notices: in which units one stiffness counts.
    """

    by_gravity: Array
    by_wrenches: Array
    joints: Array
    joint_names: tuple[str, ...]
    frame: str
    turns: tuple[bool, ...]
    """Whether each coordinate is an angle."""
    off: Array
    """(...), m, by which the answer in proportion to the loads misses: of an iterated one exactly,
    else by one step of the iteration."""
    iterated: bool = False
    doubts: tuple[Doubt, ...] = ()
    notices: tuple[str, ...] = ()
    _aside = ("doubts", "notices")

    @property
    def displacement(self) -> Array:
        """Displacement of the frame (..., six) by gravity and wrenches together."""
        return self.by_gravity + self.by_wrenches

    @property
    def distance(self) -> Array:
        """Distance (...) by which the frame's origin is displaced, m."""
        size = self.displacement.shape[-1]
        return np.asarray(np.linalg.norm(self.displacement[..., : 3 if size == 6 else 2], axis=-1))

    @property
    def far(self) -> np.ndarray:
        """Flags (...) where an angle yields by more than 0.1 rad: a displacement in proportion to
        the loads is then only a hint."""
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
                "off": (dims, self.off, "m", "miss of the answer in proportion to the loads"),
            },
            {
                "component": (("component",), np.array(rows), "1", "component"),
                "coordinate": (("coordinate",), np.array(self.joint_names), "1", "coordinate"),
            },
            {"frame": self.frame, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        count = self.distance.size
        known = self.distance[np.isfinite(self.distance)]
        most = f", up to {1e3 * known.max():.4g} mm" if known.size else ""
        return (
            f"Deflection: {counted(count, 'posture')}{most} at frame {self.frame!r}"
            f"{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        known = np.isfinite(self.distance)
        rows = []
        if known.any():
            size = np.where(known, self.distance, -1.0)
            worst = np.unravel_index(np.argmax(size), size.shape)
            for name, turns, x in zip(
                self.joint_names, self.turns, self.joints[worst], strict=True
            ):
                told = f"{np.degrees(x):.4g} deg" if turns else f"{1e3 * x:.4g} mm"
                rows.append((name, told))
        notes = [*([in_one_line(self.doubts)] if self.doubts else []), *self.notices]
        notes += self._how_far_off(known)
        return TextTable(("joint, where it is largest", "yields"), rows, notes)

    def _how_far_off(self, known: np.ndarray) -> list[str]:
        """Sentences on how good the answer is."""
        notes = []
        if known.any():
            miss = f"{1e3 * self.off[known].max():.3g} mm"
            notes.append(
                f"All balances; in proportion to the loads it would miss by up to {miss}."
                if self.iterated
                else f"In proportion to the loads: misses by about {miss}, at most."
            )
        if self.far.any() and not self.iterated:
            count = counted(int(self.far.sum()), "posture")
            notes.append(f"That is only a hint in {count}: angles > 0.1 rad; take iterate=True.")
        if not known.all():
            count = counted(int((~known).sum()), "posture")
            notes.append(f"No equilibrium was found near {count} (nan): the springs give way.")
        return notes


def deflection(
    model: Model,
    q: JointVector,
    wrenches: FrameWrenchTable = None,
    frame: str | None = None,
    *,
    stiffness: Stiffness = None,
    iterate: bool = False,
) -> Deflection:
    """How far a frame of a robot is displaced by the robot's weight and by loads: the drives stand
    still, and the joints yield.

    Parameters
    ----------
    model
        A robot, an open chain or a closed one, or a family of robots, whose flexible joints
        (`Model.with_flexible_joint`), springs of passive joints and struts yield. What it carries
        (`Model.with_payload`) is part of its weight.
    q
        (..., nq), where the robot would be without weight and loads, loops closed; of a family
        (..., *family, nq).
    wrenches
        {frame: (..., six)} exerted on the robot by its surroundings, or one at the tip: force, then
        moment, world axes (N, N m), which keep their direction.
    frame
        Name of the frame that is displaced; default the tip.
    stiffness
        (..., nv) or {joint: k}, N m/rad (N/m): between the motor of each joint, which stands still,
        and its link. Infinite, or of a drive left out of the mapping: rigid. One number is that of
        every driven joint of one coordinate.
    iterate
        Whether the robot yields until springs, weights and loads balance where it then is.

    Returns
    -------
    Deflection
        Linear in the loads: torques, stiffnesses and Jacobian J are those at q, so that the frame
        moves by J K⁻¹ (Jᵀ w - g), with w the loads and g the torques that hold weights and tensed
        springs; `off` tells by how much that misses. With `iterate` the equilibrium itself, by
        Newton's method from there; NaN where none was found, or none that is stable.

    Raises
    ------
    FreebodyError
        Nothing yields.
    SingularError
        A joint that nothing holds; a closed chain at a singular position among others.
    LoopError
        Open loops.
    ShapeError, NotFiniteError, UnknownNameError
    """
    if model.family:
        return _of_family(model, q, wrenches, frame, stiffness, iterate)
    function = "deflection"
    joints = compliant_joints(function, model, stiffness, None, resting=True)
    at = finite_vector(function, model, "q", q)
    loads = wrenches_by_frame(function, model, wrenches)
    told = {f"wrenches[{name!r}]": load for name, load in loads.items()}
    batch = common_batch(function, {"q": at, "stiffness": joints.given, **told})
    flat = [
        np.broadcast_to(x, (*batch, x.shape[-1])).reshape(-1, x.shape[-1])
        for x in (at, joints.given, *loads.values())
    ]
    name = model.frame(frame).name
    rest = Equilibria(
        function, replace(joints, given=flat[1]), flat[0], dict(zip(loads, flat[2:], strict=True))
    )
    weight, whole, off = rest.displaced(name, iterate)
    by_gravity, by_wrenches, yielded = (
        x.reshape(*batch, x.shape[-1])
        for x in (weight.displacement, whole.displacement - weight.displacement, whole.joints)
    )
    return Deflection(
        by_gravity, by_wrenches, yielded, model.velocity_names, name, tuple(turning(model)),
        off.reshape(batch), iterate, doubts_on(model, MASSES), joints.notices,
    )  # fmt: skip


def _of_family(
    model: Model,
    q: JointVector,
    wrenches: FrameWrenchTable,
    frame: str | None,
    stiffness: Stiffness,
    iterate: bool,
) -> Deflection:
    given = {"q": q, "wrenches": wrenches, "stiffness": stiffness}
    parts = of_members(
        model, given, lambda one, own: deflection(one, frame=frame, iterate=iterate, **own)
    )
    return replace(
        parts.first,
        by_gravity=parts.stacked(lambda x: x.by_gravity, 1),
        by_wrenches=parts.stacked(lambda x: x.by_wrenches, 1),
        joints=parts.stacked(lambda x: x.joints, 1),
        off=parts.stacked(lambda x: x.off, 0),
        doubts=doubts_on(model, MASSES),
    )
