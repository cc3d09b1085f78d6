"""Dynamics of open chains: forces from motion, motion from forces, and the matrices and energies in
between."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.algorithms.kinematics import NO_CENTRE
from freebody.algorithms.singular_thresholds import NO_WRENCH
from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, SingularError, listed
from freebody.kernels.formula_variants import require_square
from freebody.kernels.formulas import Option
from freebody.model.kept_facts import fact
from freebody.model.losses import lossy_joints
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.shafts import untwisted
from freebody.model.tree import about_origin
from freebody.spatial import of_dimension
from freebody.trees.closer_looks import looking_closer
from freebody.trees.kinematics import jacobian
from freebody.trees.public_calls import (
    CallKey,
    FrameWrenchTable,
    JointVector,
    careful,
    evaluate,
    finite_vector,
)
from freebody.trees.special_joints import refuse_massless, refuse_passive


def where_all_move_mass(
    function: str,
    model: Model,
    inputs: tuple[JointVector, ...],
    _: None,
    wrenches: FrameWrenchTable,
) -> Any:
    """The result of `careful` for a model in which each joint moves some inertia; refuses other
    models."""
    require_model(function, model)
    refuse_massless(model, function)
    return careful(function, model, inputs, None, wrenches)


def refuse_singular(function: str, model: Model, accelerations: Array) -> None:
    """Raise SingularError for finite inputs with an acceleration (..., nv) that is not finite: M is
    singular there, or the directions of power in lossy gears were not found."""
    single = accelerations.ndim == 1  # plain Python is quicker there
    if math.isfinite(sum(accelerations.tolist())) if single else np.isfinite(accelerations).all():
        return
    *sample, k = map(int, np.argwhere(~np.isfinite(accelerations))[0])
    if lossy := lossy_joints(model.bodies):
        raise SingularError(
            f"{function}: which way power flows through {listed(lossy)} of {model.name!r}, whose "
            f"losses depend on it, did not settle{at_sample(sample)}, or the mass matrix is "
            f"singular."
        )
    raise SingularError(
        f"{function}: the mass matrix of {model.name!r} is singular{at_sample(sample)}: "
        f"joint coordinate {model.velocity_names[k]!r} has no finite acceleration."
    )


def inverse_dynamics_derivatives(
    model: Model, q: JointVector, qd: JointVector, qdd: JointVector
) -> tuple[Array, Array, Array]:
    """(∂tau/∂q, ∂tau/∂q̇, M), each (..., nv, nv), rows tau; with friction (the sign of dry friction
    kept constant), springs and rotors.

    q: (..., nq); qd, qdd: (..., nv). With free, spherical and quaternion coordinates ∂/∂q is on the
    tangent space: along `fb.integrate(model, q, v)`. Source: Singh, Russell, Wensing 2022.
    """
    return evaluate("inverse_dynamics_derivatives", model, (q, qd, qdd))


def inverse_dynamics_second_derivatives(
    model: Model, q: JointVector, qd: JointVector, qdd: JointVector
) -> tuple[Array, Array, Array, Array]:
    """Second derivatives of tau, each (..., nv, nv, nv), the last axis the last direction of
    differentiation.

    (∂²tau/∂q∂q, ∂²tau/∂q̇∂q, ∂²tau/∂q̇∂q̇, ∂M/∂q); those with respect to q̈ and q̇, and to q̈
    twice, are zero. On the tangent space, the derivative along q of what
    `inverse_dynamics_derivatives` returns.
    """
    return evaluate("inverse_dynamics_second_derivatives", model, (q, qd, qdd))


def forward_dynamics_derivatives(
    model: Model, q: JointVector, qd: JointVector, tau: JointVector
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
    function: str, model: Model, inputs: tuple[JointVector, ...], *_: None
) -> tuple[Array, ...]:
    result = where_all_move_mass(function, model, inputs, None, None)
    refuse_singular(function, model, np.diagonal(result[2], axis1=-2, axis2=-1))
    return result


def mass_matrix(model: Model, q: JointVector) -> Array:
    """M (..., nv, nv), rotors included, by composite bodies. q: (..., nq)."""
    return evaluate("mass_matrix", model, (q,))


def mass_matrix_inverse(model: Model, q: JointVector) -> Array:
    """M⁻¹ (..., nv, nv). q: (..., nq). Raises SingularError naming the joint that moves no
    inertia."""
    return evaluate("mass_matrix_inverse", model, (q,), None, None, where_all_move_mass)


def coriolis_matrix(model: Model, q: JointVector, qd: JointVector) -> Array:
    """C (..., nv, nv): C q̇ is the velocity term and Ṁ - 2C is skew-symmetric (Christoffel).

    q: (..., nq); qd: (..., nv). With free or spherical joints the matrix of Echeandia and Wensing
    2021.
    """
    return evaluate("coriolis_matrix", model, (q, qd))


def bias(model: Model, q: JointVector, qd: JointVector) -> Array:
    """c + g, friction and springs (..., nv): the inverse dynamics at zero acceleration."""
    return evaluate("bias", model, (q, qd))


def gravity_torque(model: Model, q: JointVector) -> Array:
    """g (..., nv): the torque that holds the arm at rest against gravity, springs not included."""
    return evaluate("gravity_torque", model, (q,))


def tip_wrench(model: Model, q: JointVector, tau: JointVector, frame: str | None = None) -> Array:
    """Wrench (..., 6) that the arm exerts on its surroundings with torques tau (..., nv): J⁻ᵀ tau
    (2.51).

    In the plane (..., 3). With fewer joints than rows the least-squares solution is not taken: a
    planar arm of two joints returns the force alone (moment 0). Gravity and springs are not
    counted. Flexible joints transmit what their motors exert. Raises SingularError at a singular
    Jacobian, PassiveJointError for a torque at a passive joint.
    """
    if isinstance(model, Model) and model.passive:
        refuse_passive("tip_wrench", model, tau)
        rigid = None if model.loops else untwisted(model)
        if rigid is not None:
            links = rigid.links(finite_vector("tip_wrench", model, "q", q))
            motors = finite_vector("tip_wrench", model, "tau", tau)[..., rigid.rates]
            return tip_wrench(rigid.model, links, motors, model.frame(frame).name)
    return evaluate(("tip_wrench", frame), model, (q, tau), _square, None, _TIP_WRENCH)


def _square(model: Model, frame: str | None) -> Option:
    """The option for a frame of an arm whose torques determine the wrench there; refuses other
    robots."""
    if model.loops:
        raise FreebodyError(
            f"tip_wrench: {model.name!r} is a closed chain; with J = fb.input_output(model, q).J "
            f"it is J⁻ᵀ tau."
        )
    option = Option(model.frame(frame).name)
    require_square("tip_wrench", model)
    return option


def _tip_wrench(model: Model, option: Option, at: np.ndarray, *inputs: Array) -> Array:
    """The tip wrench at samples (k, …) that the kernel could not decide; at: their indices, for
    errors."""
    q, tau = inputs
    J = jacobian(model, q, option.frame)
    square = J[..., : model.nv, :]
    values = np.linalg.svd(square, compute_uv=False)
    singular = np.argwhere(values[..., -1] <= NO_WRENCH * values[..., 0])
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


def kinetic_energy(model: Model, q: JointVector, qd: JointVector) -> Array:
    """T (...) in J, rotors included (5.1-5.3)."""
    return evaluate("kinetic_energy", model, (q, qd))


def potential_energy(model: Model, q: JointVector) -> Array:
    """V (...) in J: gravity, zero at the world's origin, and springs (5.4, 5.5).

    The weight of all links counts, as in `model.mass` and `center_of_mass`: links fixed to the base
    add a constant.
    """
    return evaluate("potential_energy", model, (q,))


def strut_states(model: Model, q: JointVector, qd: JointVector) -> tuple[Array, Array, Array]:
    """(length m, its rate m/s, tension N) of the struts, each (..., struts) in the order of
    `model.strut_names`; q: (..., nq), qd: (..., nv).

    A strut pulls its ends together with its tension, preload + stiffness (L - rest) + damping L̇;
    where it is below 0 it pushes.
    """
    return evaluate("strut_states", model, (q, qd))


def momentum(
    model: Model, q: JointVector, qd: JointVector, about: ArrayLike | None = None
) -> Array:
    """Linear (kg m/s), then angular momentum (kg m²/s), (..., 6), about a point of the world
    (default its origin).

    (..., 3) in the plane. Momentum of the bodies; rotors are not counted.
    """
    if about is None:
        return evaluate("momentum", model, (q, qd))
    return evaluate(("momentum", "about"), model, (q, qd, about), _about, None, _momentum_about)


def _momentum_about(
    key: CallKey, model: Model, inputs: tuple[Any, ...], option: Any, _: None
) -> Array:
    require_model("momentum", model)
    *state, about = inputs
    return careful(key, model, (*state, finite_vector("momentum", model, "about", about)), option)


def _about(model: Model, _: str) -> Option:
    return Option(point=True)


def centroidal_momentum_matrix(model: Model, q: JointVector) -> Array:
    """A (..., 6, nv): A q̇ is the momentum about the centre of mass of what moves, linear then
    angular, world axes.

    (..., 3, nv) in the plane. q: (..., nq). Raises SingularError where nothing that moves has a
    mass. Source: Orin, Goswami, Lee 2013.
    """
    return evaluate(
        "centroidal_momentum_matrix", model, (q,), None, None, _centroidal_momentum_matrix
    )


def _centroidal_momentum_matrix(
    function: str, model: Model, inputs: tuple[JointVector, ...], *_: None
) -> Array:
    require_model(function, model)
    if not _moves_mass(model):
        raise SingularError(NO_CENTRE.format("no link that moves"))
    return careful(function, model, inputs)


@fact
def _moves_mass(model: Model) -> bool:
    """Whether the moving bodies together have mass, and so a centre of mass."""
    space = of_dimension(model.dim)
    total = sum(about_origin(space, body.masses)[0] for body in model.tree.bodies)
    return bool(np.all(total != 0.0))
