"""Every reaction of a mechanism, of joints and of loops: which components are determined, and
whether all balance."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.accelerations import definite_accelerations
from freebody.loops.forces import loop_multipliers, motion_torques
from freebody.loops.scaled_equations import length
from freebody.model.kept_facts import first_member
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    checked_inputs,
    checked_reference,
)
from freebody.trees.special_joints import refuse_passive


@dataclass(frozen=True, eq=False, repr=False)
class Reactions(Tabled, ByValue):
    """Reaction wrenches of a mechanism in motion; arrays have the batch of the inputs in front."""

    names: tuple[str, ...]
    """Names of the joints, then of the loops."""
    wrenches: Array
    """(..., k, six): force, then moment. Of a joint on its child by its parent at the child's joint
    origin; of a loop on the second frame's body by the first's, at the second frame's origin. World
    axes, or those of child and second frame."""
    determined: NDArray[np.bool_]
    """(..., k, six) bool: whether the equations determine the component, in the axes of `wrenches`;
    others are the smallest possible."""
    multipliers: Array
    """λ (..., m) of (5.23), one a loop equation; -Φ_qᵀ λ is what the loops do."""
    qdd: Array
    """Accelerations of the coordinates (..., nv)."""
    tau: Array
    """Torques of the drives (..., nv)."""
    balance: float
    """Largest of ΣF - m a (N) and (ΣM - Ḣ) / length (N; of a family the first member's) over all
    bodies, relative to the largest force: it checks the wrenches against accelerations found from
    the poses alone."""

    def _title(self) -> str:
        return f"Reactions at {', '.join(self.names)}, of shape {self.wrenches.shape}"

    def _table(self) -> TextTable:
        if self.wrenches.ndim > 2:
            return TextTable(
                (),
                (),
                (f"At one instant: wrenches[{', '.join(['k'] * (self.wrenches.ndim - 2))}].",),
            )
        axes = (
            ("fx", "fy", "fz", "mx", "my", "mz")
            if self.wrenches.shape[-1] == 6
            else ("fx", "fy", "m")
        )
        rows = [
            (
                name,
                *(f"{x:.4g}{'' if known else ' *'}" for x, known in zip(wrench, sure, strict=True)),
            )
            for name, wrench, sure in zip(self.names, self.wrenches, self.determined, strict=True)
        ]
        head = (f"{x} ({'N' if x[0] == 'f' else 'N m'})" for x in axes)
        undetermined = (
            ()
            if self.determined.all()
            else ("* not determined by the equations: the smallest possible value.",)
        )
        return TextTable(("", *head), rows, undetermined)

    def __getitem__(self, name: str) -> Array:
        """The wrench (..., six) of one joint or loop."""
        if name not in self.names:
            raise UnknownNameError("reaction", name, "this mechanism", self.names)
        return self.wrenches[..., self.names.index(name), :]


def reactions(
    model: Model,
    q: JointVector,
    qd: JointVector,
    *,
    tau: JointVector | None = None,
    qdd: JointVector | None = None,
    wrenches: FrameWrenchTable = None,
    actuated: Sequence[str] | None = None,
    forces: JointVector | None = None,
    reference: Literal["world", "child"] = "world",
) -> Reactions:
    """All reactions of a tree or closed chain in a state: of every joint and loop, and whether the
    equations determine them.

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one.
    q : (..., nq)
        Positions, rad and m; loops closed.
    qd : (..., nv)
        Rates, rad/s and m/s.
    tau : (..., nv), optional
        Torques and forces of the drives (N m, N): the motion follows.
    qdd : (..., nv), optional
        Accelerations: the torques of the driven joints follow. Give this or `tau`.
    wrenches : {frame: (..., 6)} or (..., 6), optional
        External wrenches, as for `inverse_dynamics`.
    actuated : names, optional
        Of a closed chain the joints that drive; default those not passive.
    forces : (..., nv), optional
        Generalized forces besides the drives', each between parent and child along its joint, as
        that of a spring is: of the joint's wrench it is a part. What acts from outside, such as
        drag, is given as wrenches.
    reference : "world" or "child"
        Axes of the wrenches.

    Returns
    -------
    Reactions
        Wrenches (..., k, 6), joints, then loops; which components are determined, multipliers,
        accelerations, torques, and how well all balance.

    Raises
    ------
    LoopError
        A state that the loops do not allow.
    PassiveJointError
        A torque at a passive joint.

    References
    ----------
    (5.23), (5.29); Newton and Euler body by body (3.1, 3.2, 6.1, 6.2).
    """
    if actuated is not None and not model.loops:
        raise FreebodyError(
            f"reactions: actuated= chooses among the joints of a closed chain; {model.name!r} has "
            f"no loops."
        )
    if (tau is None) == (qdd is None):
        raise FreebodyError("reactions: give either tau=, the torques, or qdd=, the accelerations.")
    checked_reference(reference, ("world", "child"))
    if tau is not None:
        refuse_passive("reactions", model, tau)
    name, third = ("tau", tau) if qdd is None else ("qdd", qdd)
    acting = np.zeros(model.nv) if forces is None else forces
    frames, (at, rates, given, acting, *loads) = checked_inputs(
        "reactions", model, {"q": q, "qd": qd, name: third, "forces": acting}, wrenches
    )
    if qdd is None:
        drive, second = given, _accelerations(model, frames, at, rates, given + acting, *loads)
    else:
        second, drive = given, _torques(model, frames, acting, actuated, at, rates, given, *loads)
    return _found(model, frames, (at, rates, second), drive, acting, loads, reference)


def _torques(
    model: Model,
    frames: tuple[str, ...],
    forces: Array,
    actuated: Sequence[str] | None,
    *motion: Array,
) -> Array:
    """Torques (..., nv) of the drives that a motion needs besides the forces, of any chain."""
    if model.loops:
        return motion_torques("reactions", model, frames, forces, *motion, actuated=actuated)
    return fetch(model, ("inverse_dynamics",), Option(wrench_frames=frames))(*motion) - forces


def _accelerations(model: Model, frames: tuple[str, ...], *state: Array) -> Array:
    """Accelerations (..., nv) that torques and forces cause, of any chain."""
    if model.loops:
        return definite_accelerations("reactions", model, frames, *state)
    return fetch(model, ("forward_dynamics",), Option(wrench_frames=frames))(*state)


def _found(
    model: Model,
    frames: tuple[str, ...],
    motion: tuple[Array, Array, Array],
    tau: Array,
    forces: Array,
    loads: list[Array],
    reference: str,
) -> Reactions:
    """The reactions of a motion under the torques that cause it, with the components that the
    equations do not determine marked."""

    def wrenches_in(axes: str) -> Array:
        kernel = fetch(model, ("reaction_wrenches",), Option(reference=axes, wrench_frames=frames))
        return kernel(*motion, multipliers, *loads)

    q, _, qdd = motion
    multipliers = np.zeros((*q.shape[:-1], 0))
    determined = None
    if model.loops:
        opened = fetch(model.opened, ("inverse_dynamics",), Option(wrench_frames=frames))
        needed = opened(*motion, *loads)
        multipliers, determined = loop_multipliers(
            first_member(model), q, tau + forces - needed, reference
        )
    world = wrenches_in("world")
    if determined is None:
        determined = np.ones(world.shape, dtype=bool)
    left = balance(model, *motion, world, dict(zip(frames, loads, strict=True)))
    chosen = world if reference == "world" else wrenches_in(reference)
    force, moment = (float(np.abs(x).max(initial=0.0)) for x in (left.force, left.moment))
    miss = max(force, moment / length(first_member(model))) / (left.largest_force or 1.0)
    return Reactions(model.reaction_names, chosen, determined, multipliers, qdd, tau, miss)


@dataclass(frozen=True)
class NewtonEulerResiduals:
    """ΣF - m a (..., nj, dim) and ΣM - Ḣ (..., nj, 3 or 1) of every body, and the largest force and
    moment that entered."""

    force: Array
    moment: Array
    largest_force: float
    largest_moment: float


def balance(
    model: Model, q: Array, qd: Array, qdd: Array, wrenches: Array, external: Mapping[str, Array]
) -> NewtonEulerResiduals:
    """Residuals of ΣF = m a and ΣM = Ḣ that reactions and external wrenches (world axes) leave of a
    motion q (..., nq), qd, qdd (..., nv).

    wrenches: (..., joints and loops, six), as `reactions` gives them; external: {frame: (...,
    six)}.
    """
    kernel = fetch(model, ("balance",), Option(wrench_frames=tuple(external)))
    force, moment, largest = kernel(q, qd, qdd, wrenches, *external.values())
    sizes = largest.reshape(-1, 2).max(axis=0, initial=0.0)
    return NewtonEulerResiduals(force, moment, float(sizes[0]), float(sizes[1]))
