"""Forces from motion, and motion from forces, of open and closed chains.

A kernel that the model keeps answers at once. Where it does not, the room of the model's chains
does: `trees` with care, or `loops`, which is imported when the first closed chain comes.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Literal

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.kernels.formulas import Option
from freebody.lazy import kept
from freebody.model.bodies import Frame
from freebody.model.cut_fixed_joints import cut, fixed_frame
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.spatial import of_dimension
from freebody.trees.dynamics import refuse_singular, where_all_move_mass
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.public_calls import (
    CallKey,
    FrameWrenchTable,
    JointVector,
    careful,
    checked_inputs,
    checked_reference,
    evaluate,
)
from freebody.trees.special_joints import refuse_passive


# Each call tries three ways in this order: the kernel that the model keeps from an earlier call
# (`evaluate`); of a closed chain, the function of `loops`; of an open one, `careful`, which looks
# at the inputs one by one, says what is wrong with them, and compiles the kernel that is kept.
def _by_chain(
    closed: Callable[..., Any], opened: Callable[..., Any] = careful
) -> Callable[..., Any]:
    """A function that calls `closed` for closed chains and `opened` for open ones, used where no
    kernel is ready."""

    def answer(
        key: CallKey, model: Model, inputs: tuple[Any, ...], option: Any, wrenches: FrameWrenchTable
    ) -> Any:
        function, *choice = (key,) if isinstance(key, str) else key
        require_model(function, model)
        if model.loops:
            return closed(model, *inputs, wrenches, *choice)
        return opened(key, model, inputs, option, wrenches)

    return answer


def _closed_inverse(model: Model, *arguments: Any) -> Array:
    from freebody.loops.forces import inverse_dynamics

    return inverse_dynamics(model, *arguments)


def _closed_forward(model: Model, *arguments: Any) -> Array:
    from freebody.loops.accelerations import forward_dynamics

    return forward_dynamics(model, *arguments)


def _closed_static(model: Model, *arguments: Any) -> Array:
    from freebody.loops.forces import static_torque

    return static_torque(model, *arguments)


def _closed_wrenches(
    model: Model, q: Any, qd: Any, qdd: Any, wrenches: FrameWrenchTable, reference: Any
) -> Array:
    from freebody.any_chain.reactions import reactions

    return reactions(model, q, qd, qdd=qdd, wrenches=wrenches, reference=reference).wrenches


def _opened_forward(function: str, model: Model, *arguments: Any) -> Array:
    result = where_all_move_mass(function, model, *arguments)
    refuse_singular(function, model, result)
    return result


_AT_JOINT = " (wrenches= and springs of joints are)"
_INVERSE, _STATIC = _by_chain(_closed_inverse), _by_chain(_closed_static)
_FORWARD, _WRENCHES = _by_chain(_closed_forward, _opened_forward), _by_chain(_closed_wrenches)


def inverse_dynamics(
    model: Model,
    q: JointVector,
    qd: JointVector,
    qdd: JointVector,
    wrenches: FrameWrenchTable = None,
    actuated: Sequence[str] | None = None,
    forces: JointVector | None = None,
) -> Array:
    """Joint torques tau that a motion needs: M q̈ + c + g + friction + springs + rotors - Σ Jᵀ w -
    forces, by recursive Newton-Euler.

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one.
    q : (..., nq)
        Positions, rad and m.
    qd, qdd : (..., nv)
        Rates and accelerations, per s and s².
    wrenches : {frame: (..., 6)} or (..., 6), optional
        Force (N), then moment (N m), that act on the arm at a frame's origin, world axes; one
        array is for the tip. In the plane (..., 3): fx, fy, m.
    actuated : names, optional
        Of a closed chain the joints that drive; default those not passive.
    forces : (..., nv), optional
        Generalized forces (N m, N) along the joints that no drive gives, at passive joints too:
        springs between links, cables, aerodynamic drag.

    Returns
    -------
    (..., nv)
        N m and N. Of an open chain the entries of passive joints (`model.passive`) are the torques
        that would be needed there; the motion is possible where they are zero. Of a closed chain
        the torques of the driven joints, zero elsewhere; of more drives than the mechanism needs,
        the smallest torques.

    Raises
    ------
    ShapeError, NotFiniteError, UnknownNameError, MissingValueError
    LoopError
        A state that the loops do not allow.
    SingularError
        The drives do not determine the motion.

    References
    ----------
    Luh, Walker, Paul 1980; notes 4.6-4.15, 6.16-6.29.
    """
    if actuated is None and forces is None:
        return evaluate("inverse_dynamics", model, (q, qd, qdd), None, wrenches, _INVERSE)
    require_model("inverse_dynamics", model)
    if model.loops:
        return _closed_inverse(model, q, qd, qdd, wrenches, actuated, forces)
    if actuated is not None:
        raise FreebodyError(
            f"inverse_dynamics: actuated= chooses among the joints of a closed chain; "
            f"{model.name!r} has no loops."
        )
    require_lossless("inverse_dynamics: forces=", model, _AT_JOINT)
    given = {"q": q, "qd": qd, "qdd": qdd, "forces": forces}
    (*motion, acting), loads = _checked("inverse_dynamics", model, given, wrenches)
    return evaluate("inverse_dynamics", model, tuple(motion), None, loads, _INVERSE) - acting


def forward_dynamics(
    model: Model,
    q: JointVector,
    qd: JointVector,
    tau: JointVector,
    wrenches: FrameWrenchTable = None,
    forces: JointVector | None = None,
) -> Array:
    """Accelerations q̈ under joint torques (3.29), of closed chains (5.29), with dependent equations
    and at singular positions too, where a motion keeps its branch.

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one.
    q : (..., nq)
        Positions, rad and m.
    qd : (..., nv)
        Rates, rad/s and m/s.
    tau : (..., nv)
        Torques and forces of the drives, N m and N.
    wrenches, forces : optional
        External wrenches and further generalized forces, as for `inverse_dynamics`.

    Returns
    -------
    (..., nv)
        rad/s² and m/s².

    Raises
    ------
    SingularError
        A joint that moves no inertia, by its name.
    LoopError
        A state that the loops do not allow.
    PassiveJointError
        A torque at a passive joint.
    """
    if isinstance(model, Model) and model.passive:
        refuse_passive("forward_dynamics", model, tau)
    if forces is not None:
        require_model("forward_dynamics", model)
        require_lossless("forward_dynamics: forces=", model, _AT_JOINT)
        given = {"q": q, "qd": qd, "tau": tau, "forces": forces}
        (q, qd, tau, acting), wrenches = _checked("forward_dynamics", model, given, wrenches)
        tau = tau + acting
    return evaluate("forward_dynamics", model, (q, qd, tau), None, wrenches, _FORWARD)


def _checked(
    function: str, model: Model, given: dict[str, JointVector], wrenches: FrameWrenchTable
) -> tuple[list[Array], dict[str, Array] | None]:
    """The inputs of a dynamics function as finite arrays of one batch shape, and the wrenches by
    frame."""
    frames, arrays = checked_inputs(function, model, given, wrenches)
    loads = dict(zip(frames, arrays[len(given) :], strict=True))
    return arrays[: len(given)], loads or None


def static_torque(model: Model, q: JointVector, wrenches: FrameWrenchTable = None) -> Array:
    """Torques that hold the arm at rest: g + springs - Σ Jᵀ w (2.41-2.49).

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one.
    q : (..., nq)
        Positions, rad and m.
    wrenches : optional
        Wrenches that act on the arm, as for `inverse_dynamics`; the notes' (2.52) prints the torque
        that exerts f, its negative.

    Returns
    -------
    (..., nv)
        N m and N. An open chain rests where the entries of its passive joints are zero; elsewhere
        they are the holding torque that is missing. Of a closed chain the torques of the driven
        joints, as for `inverse_dynamics`.

    Raises
    ------
    LoopError, SingularError
        As `inverse_dynamics` does.
    """
    return evaluate("static_torque", model, (q,), None, wrenches, _STATIC)


def joint_wrenches(
    model: Model,
    q: JointVector,
    qd: JointVector,
    qdd: JointVector,
    wrenches: FrameWrenchTable = None,
    reference: Literal["world", "child"] = "world",
    joint: str | None = None,
) -> Array:
    """Reaction wrench of every joint in a motion: the total that the parent exerts on the child, at
    the child's joint origin.

    A motion's generalized forces between parent and child along a joint, such as those of springs,
    change no joint's total in an open chain (in a closed one: `reactions`, forces=); what acts from
    outside is given as wrenches.

    Parameters
    ----------
    model : Model
        Robot, an open chain or a closed one.
    q, qd, qdd, wrenches
        Motion and external wrenches, as for `inverse_dynamics`.
    reference : "world" or "child"
        Axes of the components.
    joint : name, optional
        One joint alone; also a fixed one (`model.fixed_joint_names`), as of a force and torque
        sensor at the wrist, or a frame that is fixed to another: what holds it and all behind it,
        at its origin.

    Returns
    -------
    (..., nj, 6), or (..., 6) of one joint
        Force (N), then moment (N m); (..., nj, 3) in the plane. Row i belongs to joint_names[i].
        Of a closed chain a row for each loop follows, on the second frame's body by the first's;
        `reactions` also says which components are determined.

    Raises
    ------
    LoopError, SingularError
        As `inverse_dynamics` does.
    """
    if joint is not None:
        require_model("joint_wrenches", model)
    if joint is None or joint in model.reaction_names:
        key = "joint_wrenches", reference
        found = evaluate(key, model, (q, qd, qdd), _in_axes, wrenches, _WRENCHES)
        return found if joint is None else found[..., model.reaction_names.index(joint), :]
    frame = fixed_frame(model, joint, "joint_wrenches")
    checked_reference(reference, ("world", "child"))
    return _through_fixed(model, frame, (q, qd, qdd), wrenches, reference == "child")


def _through_fixed(
    model: Model,
    frame: Frame,
    motion: tuple[JointVector, JointVector, JointVector],
    wrenches: FrameWrenchTable,
    in_child: bool,
) -> Array:
    """The wrench (..., 6) at a frame's origin by which the body before it holds all that is fixed
    to the frame: that of a motionless hinge put in its place."""
    given: dict[str, Any] = dict(zip(("q", "qd", "qdd"), motion, strict=True))
    _, arrays = checked_inputs("joint_wrenches", model, given, None)
    q = arrays[0]
    apart = kept(model, f"_cut {frame.name}", cut, model, frame.name)
    still = [np.concatenate([x, np.zeros((*x.shape[:-1], 1))], axis=-1) for x in arrays]
    every = joint_wrenches(apart, still[0], still[1], still[2], wrenches)
    found = every[..., len(model.bodies), :]
    d = model.dim
    T = forward_kinematics(model, q, frame.name)
    body = next(f.name for f in model.frames if f.body == frame.body and not f.parent)
    arm = T[..., :d, d] - forward_kinematics(model, q, body)[..., :d, d]
    force, moment = found[..., :d], found[..., d:]
    lever = of_dimension(d).moment(tuple(np.moveaxis(arm, -1, 0)), tuple(np.moveaxis(force, -1, 0)))
    moment = moment - np.stack(lever, axis=-1)
    if in_child:
        force = np.einsum("...ji,...j->...i", T[..., :d, :d], force)
        if d == 3:
            moment = np.einsum("...ji,...j->...i", T[..., :d, :d], moment)
    return np.concatenate([force, moment], axis=-1)


def _in_axes(model: Model, reference: str) -> Option:
    return Option(reference=checked_reference(reference, ("world", "child")))
