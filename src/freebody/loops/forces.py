"""Forces of closed chains: torques of the drives in a motion or at rest, and forces of the loops;
by a kernel where its result is sure, else by singular values."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.singular_thresholds import RANK
from freebody.arrays import Array, at_sample
from freebody.errors import SingularError, listed
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.closure_checks import (
    branches,
    driven_coordinates,
    require_closed,
    require_consistent,
    scaled_jacobian,
)
from freebody.loops.independent_equations import partition, partition_of_loops
from freebody.loops.scaled_equations import (
    every_jacobian,
    length,
    mechanism,
    null_space,
    rate_scale,
    row_scale,
)
from freebody.model.model import Model
from freebody.model.shafts import shaft_names
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    attempt,
    checked_inputs,
    refuse_without_length,
)

_ADDED = 20.0  # times what rounding changes in the equations, for what it may change in wrenches
_DETERMINED = 1e-7
"""Part of a wrench, relative to the largest, that undetermined multipliers may add."""
# part of a mechanism's motion, all coordinates as angles, by which a drive that stands still moves
_STILL = 1e-12
_WOULD_OPEN = (
    "would open{} under these accelerations; "
    "make them consistent with fb.loop_acceleration(model, q, qd, qdd)"
)


def inverse_dynamics(
    model: Model,
    q: JointVector,
    qd: JointVector,
    qdd: JointVector,
    wrenches: FrameWrenchTable,
    actuated: Sequence[str] | None = None,
    forces: JointVector | None = None,
) -> Array:
    """Torques of the drives in a motion: `fb.inverse_dynamics` of a closed chain."""
    if forces is None:
        found = _attempted("inverse_dynamics", model, (q, qd, qdd), wrenches, actuated)
        if found is not None:
            return found
        forces = np.zeros(model.nv)
    given = {"q": q, "qd": qd, "qdd": qdd, "forces": forces}
    frames, arrays = checked_inputs("inverse_dynamics", model, given, wrenches)
    acting = arrays.pop(len(given) - 1)
    return motion_torques("inverse_dynamics", model, frames, acting, *arrays, actuated=actuated)


def motion_torques(
    function: str,
    model: Model,
    frames: tuple[str, ...],
    forces: Array,
    q: Array,
    qd: Array,
    qdd: Array,
    *loads: Array,
    actuated: Sequence[str] | None = None,
) -> Array:
    """Torques (..., nv) of the drives in a motion, minus those that generalized forces (..., nv)
    provide; refuses states and accelerations that violate the loops."""
    driven = driven_coordinates(function, model, actuated)
    arrays = q, qd, qdd, *loads
    tau = _by_drives("inverse_dynamics", model, driven, frames, arrays)
    if forces.any():
        tau = tau - _by_drives("drive_torques", model, driven, (), (q, forces))
    with_care = np.asarray(np.isnan(tau).any(axis=-1))
    refuse_without_length(function, model, q)
    for taken, part in branches(model, q, with_care):
        require_closed(function, taken, q, qd, part)
        require_consistent(function, taken, q, qd, qdd, _WOULD_OPEN, part)
        needed = fetch(model.opened, ("inverse_dynamics",), Option(wrench_frames=frames))(*arrays)
        tau[part] = _careful_torques(function, taken, q, needed - forces, driven, part)
    return tau


def static_torque(model: Model, q: JointVector, wrenches: FrameWrenchTable) -> Array:
    """Torques of the drives at rest: `fb.static_torque` of a closed chain."""
    found = _attempted("static_torque", model, (q,), wrenches)
    if found is not None:
        return found
    frames, arrays = checked_inputs("static_torque", model, {"q": q}, wrenches)
    tau = _by_drives("static_torque", model, model.driven, frames, tuple(arrays))
    with_care = np.asarray(np.isnan(tau).any(axis=-1))
    q = np.broadcast_to(arrays[0], (*tau.shape[:-1], model.nq))
    refuse_without_length("static_torque", model, q)
    for taken, part in branches(model, q, with_care):
        require_closed("static_torque", taken, q, among=part)
        needed = fetch(model.opened, ("static_torque",), Option(wrench_frames=frames))(*arrays)
        tau[part] = _careful_torques("static_torque", taken, q, needed, model.driven, part)
    return tau


def _attempted(
    function: str,
    model: Model,
    inputs: tuple[JointVector, ...],
    wrenches: FrameWrenchTable,
    actuated: Sequence[str] | None = None,
) -> Array | None:
    """The torques of the drives by a kernel; None where its results are not sure."""
    chosen = partition(model, driven_coordinates(function, model, actuated))
    if chosen is None:
        return None
    key = function if actuated is None else (function, "driven", *chosen.driven)
    return attempt(key, model, inputs, Option(partition=chosen, checks="state"), wrenches)


def _by_drives(
    function: str,
    model: Model,
    driven: tuple[int, ...],
    frames: tuple[str, ...],
    arrays: tuple[Array, ...],
) -> Array:
    """Torques (..., nv) of the drives by a kernel, from arrays q, …; NaN where the result is not
    sure."""
    chosen = partition(model, driven)
    if chosen is None:
        return np.full((*arrays[0].shape[:-1], model.nv), np.nan)
    option = Option(wrench_frames=frames, partition=chosen, checks="state")
    return fetch(model, (function,), option)(*arrays)


def torques(
    model: Model,
    q: Array,
    qd: Array,
    qdd: Array,
    wrenches: Mapping[str, Array] | None = None,
) -> Array:
    """Torques (..., nv) as of `inverse_dynamics` for states taken as closed, such as those between
    the samples of a motion, whose interpolation is slightly open."""
    loads = dict(wrenches or {})
    option = Option(wrench_frames=tuple(loads))
    needed = fetch(model.opened, ("inverse_dynamics",), option)(q, qd, qdd, *loads.values())
    return drive_torques("inverse_dynamics", model, q, needed)


def drive_torques(function: str, model: Model, q: Array, needed: Array) -> Array:
    """Torques (..., nv) of the driven joints, zero elsewhere, with the power of `needed` in every
    motion that the loops allow.

    needed (..., nv): torques of the tree that is left when all loops are cut. Least norm where too
    many drive.
    """
    chosen = partition(model)
    if chosen is None:
        tau = np.full(needed.shape, np.nan)
    else:
        tau = fetch(model, ("drive_torques",), Option(partition=chosen))(q, needed)
    with_care = np.asarray(np.isnan(tau).any(axis=-1))
    if with_care.any():
        q = np.broadcast_to(q, (*needed.shape[:-1], model.nq))
        tau[with_care] = _careful_torques(function, model, q, needed, model.driven, with_care)
    return tau


def _careful_torques(
    function: str,
    model: Model,
    q: Array,
    needed: Array,
    driven: Sequence[int],
    chosen: NDArray[np.bool_],
) -> Array:
    """Torques (N, nv) of the drives at chosen samples of a batch by singular values, whatever the
    rank; refuses motions that the drives cannot force."""
    rates, driven = rate_scale(model), list(driven)
    wanted = rates * needed[chosen]
    tau = np.zeros_like(wanted)
    _, s, Vt = np.linalg.svd(scaled_jacobian(model, q[chosen]))
    ranks = (s > RANK * s.max(axis=-1, keepdims=True, initial=1e-300)).sum(axis=-1)
    for rank in np.unique(ranks):
        at = np.flatnonzero(ranks == rank)
        N = np.swapaxes(Vt[at, rank:], -1, -2)
        motions = np.swapaxes(N[:, driven], -1, -2)
        power = np.einsum("nkf,nk->nf", N, wanted[at])
        # N's columns are units: less than _STILL is rounding, also where a drive has no more
        largest = np.linalg.norm(motions, axis=(-2, -1))
        cut = np.maximum(1e-9, _STILL / np.maximum(largest, 1e-300))
        found = np.einsum("nkf,nf->nk", np.linalg.pinv(motions, rcond=cut), power)
        missed = np.abs(np.einsum("nfk,nk->nf", motions, found) - power).max(axis=-1, initial=0.0)
        bad = np.flatnonzero(missed > 1e-9 * (1.0 + np.abs(power).max(axis=-1, initial=0.0)))
        if len(bad):
            names = ", ".join(model.velocity_names[k] for k in driven) or "none"
            where = at_sample(tuple(map(int, np.argwhere(chosen)[at[bad[0]]])))
            raise SingularError(
                f"{function}: the driven joints of {model.name!r} ({names}) cannot force this "
                f"motion{where}: it can move with these joints locked (too few drives, or a "
                f"singular position of the second type). {_instead(model)}"
            )
        tau[at[:, None], driven] = found / rates[driven]
    return tau


def _instead(model: Model) -> str:
    """A sentence on the remedy where the driven joints cannot force a motion."""
    twists = shaft_names(model)
    if not twists:
        return "Drive another joint: actuated=[...]."
    return (
        f"In a closed chain the shafts of flexible joints ({listed(twists, 4)}) are not twisted by "
        f"what they carry: take the rigid robot, model.without('shafts'), or simulate."
    )


def _shape(model: Model) -> tuple[int, int]:
    """The shape (joints and loops, components) of the wrenches of one sample."""
    return len(model.bodies) + len(model.loops), 6 if model.dim == 3 else 3


def loop_multipliers(
    model: Model, q: Array, force: Array, reference: str
) -> tuple[Array, NDArray[np.bool_]]:
    """Multipliers λ (..., m) with Φ_qᵀ λ = force (..., nv), the part of the drives' forces that the
    motion does not need; and flags (..., k, six) of the wrench components that they determine."""
    batch, chosen = q.shape[:-1], partition_of_loops(model)
    determined = np.ones((*batch, *_shape(model)), dtype=bool)
    if chosen is None:
        multipliers = np.zeros((*batch, mechanism(model).constraints))
        with_care = np.ones(batch, dtype=bool)
    else:
        multipliers = fetch(model, ("loop_multipliers",), Option(partition=chosen))(q, force)
        with_care = np.asarray(np.isnan(multipliers).any(axis=-1))
        if len(chosen.rows) < mechanism(model).constraints:
            change = fetch(
                model, ("loose_wrenches",), Option(reference=reference, partition=chosen)
            )(q)
            determined = _undisturbed(
                model, np.abs(change).max(axis=-3), np.full(batch, _DETERMINED)
            )
    for taken, part in branches(model, q, with_care):
        for index in np.argwhere(part):
            at = tuple(index)
            multipliers[at], determined[at] = _careful_multipliers(
                taken, q[at], force[at], reference
            )
    return multipliers, determined


def _careful_multipliers(
    model: Model, q: Array, force: Array, reference: str
) -> tuple[Array, NDArray[np.bool_]]:
    """The multipliers of one sample by singular values, and flags of the wrench components that
    they determine, whatever the rank."""
    rows = row_scale(model)
    A = scaled_jacobian(model, q)
    multipliers = rows * (np.linalg.pinv(A.T, rcond=RANK) @ (rate_scale(model) * force))
    combinations = rows[:, None] * null_space(A, RANK)[1]
    if not combinations.shape[1]:
        return multipliers, np.ones(_shape(model), dtype=bool)
    kernel = fetch(model, ("reaction_wrenches",), Option(reference=reference))
    still = np.zeros(model.nv)
    rest = kernel(q, still, still, np.zeros(mechanism(model).constraints))
    change = np.abs(kernel(q, still, still, combinations.T) - rest).max(axis=0)
    doubt = max(_DETERMINED, _doubt(A, every_jacobian(model, q)))
    return multipliers, _undisturbed(model, change, np.array(doubt))


def _undisturbed(model: Model, change: Array, doubt: Array) -> NDArray[np.bool_]:
    """Flags (..., k, six) of the wrench components that are unaffected by combinations of
    multipliers which no motion feels.

    change (..., k, six): what they do, at most; doubt (...): relative to the largest of them, what
    is nothing.
    """
    size = change.copy()
    size[..., model.dim :] /= length(model)  # forces and moments compare
    largest = size.max(axis=(-2, -1), initial=1e-300)
    return size < (doubt * largest)[..., None, None]


def _doubt(counting: Array, every: Array) -> float:
    """The doubt that rounding of the model's numbers adds to a determined wrench: the part of the
    equations (m, nv) that was projected out, relative to the least independent one."""
    s = np.linalg.svd(counting, compute_uv=False)
    least = float(s[s > RANK * s.max(initial=1e-300)].min(initial=1.0))
    return _ADDED * float(np.abs(every - counting).max(initial=0.0)) / least
