"""Dynamics: forces from motion, motion from forces, and what stands between them."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, SingularError
from freebody.kernels.closed_chains import closed_chain_function
from freebody.kernels.formulas import Option
from freebody.kernels.options import require_square
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.trees.closer_looks import looking_closer
from freebody.trees.kinematics import checked_reference, jacobian
from freebody.trees.massless_joints import refuse_massless
from freebody.trees.passive_joints import refuse_passive
from freebody.trees.public_calls import (
    Key,
    Vector,
    Wrenches,
    careful,
    checked_inputs,
    evaluate,
    finite_vector,
)


def inverse_dynamics(
    model: Model,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    wrenches: Wrenches = None,
    actuated: Sequence[str] | None = None,
    forces: Vector | None = None,
) -> Array:
    """tau (..., nv): M q̈ + c + g + friction + springs + rotors - Σ Jᵀ w - forces (N m, N), by
    recursive Newton-Euler.

    q: (..., nq); qd, qdd: (..., nv), rad or m and s. wrenches: {frame: (..., 6)} or one array for
    the tip: force, then moment, that act on the arm at the frame's origin, world axes ((..., 3):
    fx, fy, m in the plane). forces: (..., nv), generalized forces (N m, N) along the joints that no
    drive gives, at passive joints too: springs between links, cables, aerodynamic drag. Raises
    ShapeError, NotFiniteError, UnknownNameError, MissingValueError.
    Source: Luh, Walker, Paul 1980; notes 4.6-4.15, 6.16-6.29.

    Of an open chain the entries of passive joints (`model.passive`) are what is missing: the torque
    that would be needed there; the motion is possible where they are zero.

    Closed chains: the torques of the driven joints (`actuated`: names; default those not passive),
    zero elsewhere; of more drives than the mechanism needs, the smallest torques. Raises LoopError
    for a state that its loops do not allow, SingularError where the drives do not determine the
    motion.
    """
    if actuated is None and forces is None:
        return evaluate("inverse_dynamics", model, (q, qd, qdd), None, wrenches, _of_any_chain)
    require_model("inverse_dynamics", model)
    if model.loops:
        of_loops = closed_chain_function("inverse_dynamics")
        return of_loops(model, q, qd, qdd, wrenches, actuated, forces)
    if actuated is not None:
        raise FreebodyError(
            f"inverse_dynamics: actuated= chooses among the joints of a closed chain; "
            f"{model.name!r} has no loops."
        )
    given = {"q": q, "qd": qd, "qdd": qdd, "forces": forces}
    (*motion, acting), loads = _checked("inverse_dynamics", model, given, wrenches)
    return evaluate("inverse_dynamics", model, tuple(motion), None, loads, _of_any_chain) - acting


def _of_any_chain(
    function: str, model: Model, inputs: tuple[Vector, ...], _: None, wrenches: Wrenches
) -> Any:
    """Of closed chains the function of the same name among theirs answers."""
    require_model(function, model)
    if model.loops:
        return closed_chain_function(function)(model, *inputs, wrenches)
    return careful(function, model, inputs, None, wrenches)


def forward_dynamics(
    model: Model,
    q: Vector,
    qd: Vector,
    tau: Vector,
    wrenches: Wrenches = None,
    forces: Vector | None = None,
) -> Array:
    """q̈ (..., nv) under joint torques tau (..., nv) and, where given, further generalized forces
    (..., nv); other arguments as for `inverse_dynamics` (3.29).

    Closed chains: (5.29), with dependent equations and at singular positions, where a motion keeps
    its branch. Raises SingularError naming the joint that moves no inertia, LoopError for a state
    that the loops do not allow, PassiveJointError for a torque at a passive joint.
    """
    if isinstance(model, Model) and model.passive:
        refuse_passive("forward_dynamics", model, tau)
    if forces is not None:
        require_model("forward_dynamics", model)
        given = {"q": q, "qd": qd, "tau": tau, "forces": forces}
        (q, qd, tau, acting), wrenches = _checked("forward_dynamics", model, given, wrenches)
        tau = tau + acting
    return evaluate("forward_dynamics", model, (q, qd, tau), None, wrenches, _forward_dynamics)


def _checked(
    function: str, model: Model, given: dict[str, Vector], wrenches: Wrenches
) -> tuple[list[Array], dict[str, Array] | None]:
    """The inputs as finite arrays of one batch shape, and the wrenches by frame."""
    frames, arrays = checked_inputs(function, model, given, wrenches)
    loads = dict(zip(frames, arrays[len(given) :], strict=True))
    return arrays[: len(given)], loads or None


def _forward_dynamics(
    function: str, model: Model, inputs: tuple[Vector, ...], _: None, wrenches: Wrenches
) -> Array:
    require_model(function, model)
    if model.loops:
        return closed_chain_function(function)(model, *inputs, wrenches)
    result = where_all_move_mass(function, model, inputs, None, wrenches)
    _refuse_singular(function, model, result)
    return result


def where_all_move_mass(
    function: str, model: Model, inputs: tuple[Vector, ...], _: None, wrenches: Wrenches
) -> Any:
    """As `careful`, of models each joint of which moves some inertia."""
    require_model(function, model)
    refuse_massless(model, function)
    return careful(function, model, inputs, None, wrenches)


def _refuse_singular(function: str, model: Model, accelerations: Array) -> None:
    """Finite inputs and an acceleration (..., nv) that is not finite: M is singular there."""
    single = accelerations.ndim == 1  # plain Python is quicker there
    if math.isfinite(sum(accelerations.tolist())) if single else np.isfinite(accelerations).all():
        return
    *sample, k = map(int, np.argwhere(~np.isfinite(accelerations))[0])
    raise SingularError(
        f"{function}: the mass matrix of {model.name!r} is singular{at_sample(sample)}: "
        f"joint coordinate {model.velocity_names[k]!r} has no finite acceleration."
    )


def inverse_dynamics_derivatives(
    model: Model, q: Vector, qd: Vector, qdd: Vector
) -> tuple[Array, Array, Array]:
    """(∂tau/∂q, ∂tau/∂q̇, M), each (..., nv, nv), rows tau; friction (Coulomb's is constant),
    springs, rotors included.

    q: (..., nq); qd, qdd: (..., nv). With free, spherical and quaternion coordinates ∂/∂q is on the
    tangent space: along `fb.integrate(model, q, v)`. Source: Singh, Russell, Wensing 2022.
    """
    return evaluate("inverse_dynamics_derivatives", model, (q, qd, qdd))


def inverse_dynamics_second_derivatives(
    model: Model, q: Vector, qd: Vector, qdd: Vector
) -> tuple[Array, Array, Array, Array]:
    """Second derivatives of tau, each (..., nv, nv, nv), the last axis the last direction of
    differentiation.

    (∂²tau/∂q∂q, ∂²tau/∂q̇∂q, ∂²tau/∂q̇∂q̇, ∂M/∂q); those with respect to q̈ and q̇, and to q̈
    twice, are zero. On the tangent space, the derivative along q of what
    `inverse_dynamics_derivatives` returns.
    """
    return evaluate("inverse_dynamics_second_derivatives", model, (q, qd, qdd))


def forward_dynamics_derivatives(
    model: Model, q: Vector, qd: Vector, tau: Vector
) -> tuple[Array, Array, Array]:
    """(∂q̈/∂q, ∂q̈/∂q̇, ∂q̈/∂tau = M⁻¹), each (..., nv, nv), on the tangent space; arguments as for
    `forward_dynamics`.

    Raises SingularError naming the joint that moves no inertia, PassiveJointError for a torque at a
    passive joint.
    """
    if isinstance(model, Model) and model.passive:
        refuse_passive("forward_dynamics_derivatives", model, tau)
    return evaluate(
        "forward_dynamics_derivatives", model, (q, qd, tau), None, None, _forward_derivatives
    )


def _forward_derivatives(
    function: str, model: Model, inputs: tuple[Vector, ...], *_: None
) -> tuple[Array, ...]:
    result = where_all_move_mass(function, model, inputs, None, None)
    _refuse_singular(function, model, np.diagonal(result[2], axis1=-2, axis2=-1))
    return result


def mass_matrix(model: Model, q: Vector) -> Array:
    """M (..., nv, nv), rotors included, by composite bodies. q: (..., nq)."""
    return evaluate("mass_matrix", model, (q,))


def coriolis_matrix(model: Model, q: Vector, qd: Vector) -> Array:
    """C (..., nv, nv): C q̇ is the velocity term and Ṁ - 2C is skew-symmetric (Christoffel).

    q: (..., nq); qd: (..., nv). With free or spherical joints the matrix of Echeandia and Wensing
    2021.
    """
    return evaluate("coriolis_matrix", model, (q, qd))


def bias(model: Model, q: Vector, qd: Vector) -> Array:
    """c + g, friction and springs (..., nv): the inverse dynamics at zero acceleration."""
    return evaluate("bias", model, (q, qd))


def gravity_torque(model: Model, q: Vector) -> Array:
    """g (..., nv): the torque that holds the arm at rest against gravity, springs not included."""
    return evaluate("gravity_torque", model, (q,))


def static_torque(model: Model, q: Vector, wrenches: Wrenches = None) -> Array:
    """g + springs - Σ Jᵀ w (..., nv): the torque that holds the arm at rest (2.41-2.49).

    wrenches act on the arm, as for `inverse_dynamics`; the notes' (2.52) prints the torque that
    exerts f, its negative. An open chain rests where the entries of its passive joints are zero;
    elsewhere they are the holding torque that is missing. Closed chains: the torques of the driven
    joints, as for `inverse_dynamics`.
    """
    return evaluate("static_torque", model, (q,), None, wrenches, _of_any_chain)


def tip_wrench(model: Model, q: Vector, tau: Vector, frame: str | None = None) -> Array:
    """Wrench (..., 6) that the arm exerts on its surroundings with torques tau (..., nv): J⁻ᵀ tau
    (2.51).

    In the plane (..., 3). With fewer joints than rows the least-squares solution is not taken: a
    planar arm of two joints returns the force alone (moment 0). Gravity and springs are not
    counted. Raises SingularError at a singular Jacobian, PassiveJointError for a torque at a
    passive joint.
    """
    if isinstance(model, Model) and model.passive:
        refuse_passive("tip_wrench", model, tau)
    return evaluate(("tip_wrench", frame), model, (q, tau), _square, None, _TIP_WRENCH)


def _square(model: Model, frame: str | None) -> Option:
    """The frame, of an arm whose torques determine its wrench."""
    if model.loops:
        raise FreebodyError(
            f"tip_wrench: {model.name!r} is a closed chain; with J = fb.input_output(model, q).J "
            f"it is J⁻ᵀ tau."
        )
    option = Option(model.frame(frame).name)
    require_square("tip_wrench", model)
    return option


def _tip_wrench(model: Model, option: Option, at: np.ndarray, *inputs: Array) -> Array:
    """The same of samples (k, …) that are not clear to a kernel; at: of each, for errors."""
    q, tau = inputs
    J = jacobian(model, q, option.frame)
    square = J[..., : model.nv, :]
    values = np.linalg.svd(square, compute_uv=False)
    singular = np.argwhere(values[..., -1] <= _SINGULAR * values[..., 0])
    if len(singular):
        first, *member = singular[0]
        raise SingularError(
            f"tip_wrench: the Jacobian of {model.name!r} is "
            f"singular{at_sample((*at[first], *member))}: some wrench at its frame needs no "
            f"torque, so the torques do not determine it. Choose another q."
        )
    wrench = np.zeros(J.shape[:-1])
    solved = np.linalg.solve(np.swapaxes(square, -1, -2), tau[..., None])
    wrench[..., : model.nv] = solved[..., 0]
    return wrench


_TIP_WRENCH = looking_closer(_tip_wrench)
_SINGULAR = 1e-12
"""A ratio of smallest to largest singular value below which the Jacobian has no inverse."""


def joint_wrenches(
    model: Model,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    wrenches: Wrenches = None,
    reference: Literal["world", "child"] = "world",
) -> Array:
    """Reaction wrench (..., nj, 6) of every joint: force (N), then moment (N m); (..., nj, 3) in
    the plane.

    Row i belongs to joint_names[i]: the total reaction of the parent on the child, at the child's
    joint origin, world axes or the child's. Arguments as for `inverse_dynamics`. Closed chains: a
    row for each loop follows, on the second frame's body by the first's; `reactions` also says
    which components are determined. A motion's generalized forces between parent and child along a
    joint, such as those of springs, change no joint's total in an open chain (in a closed one:
    `reactions`, forces=); what acts from outside is given as wrenches.
    """
    key = "joint_wrenches", reference
    return evaluate(key, model, (q, qd, qdd), _in_axes, wrenches, _joint_wrenches)


def _joint_wrenches(
    key: Key, model: Model, inputs: tuple[Vector, ...], option: Any, wrenches: Wrenches
) -> Array:
    function, reference = key
    require_model(function, model)
    if model.loops:
        q, qd, qdd = inputs
        found = closed_chain_function(function)(
            model, q, qd, qdd=qdd, wrenches=wrenches, reference=reference
        )
        return found.wrenches
    return careful(key, model, inputs, option, wrenches)


def _in_axes(model: Model, reference: str) -> Option:
    return Option(reference=checked_reference(reference, ("world", "child")))


def kinetic_energy(model: Model, q: Vector, qd: Vector) -> Array:
    """T (...) in J, rotors included (5.1-5.3)."""
    return evaluate("kinetic_energy", model, (q, qd))


def potential_energy(model: Model, q: Vector) -> Array:
    """V (...) in J: gravity, zero at the world's origin, and springs (5.4, 5.5).

    The weight of all links counts, as in `model.mass` and `center_of_mass`: links fixed to the base
    add a constant.
    """
    return evaluate("potential_energy", model, (q,))


def momentum(model: Model, q: Vector, qd: Vector, about: ArrayLike | None = None) -> Array:
    """Linear (kg m/s), then angular momentum (kg m²/s), (..., 6), about a point of the world
    (default its origin).

    (..., 3) in the plane. Momentum of the bodies; rotors are not counted.
    """
    if about is None:
        return evaluate("momentum", model, (q, qd))
    return evaluate(("momentum", "about"), model, (q, qd, about), _about, None, _momentum_about)


def _momentum_about(key: Key, model: Model, inputs: tuple[Any, ...], option: Any, _: None) -> Array:
    require_model("momentum", model)
    *state, about = inputs
    return careful(key, model, (*state, finite_vector("momentum", model, "about", about)), option)


def _about(model: Model, _: str) -> Option:
    return Option(point=True)
