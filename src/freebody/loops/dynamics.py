"""Motion from forces and forces from motion, of closed chains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.loop_checks import LEFT
from freebody.algorithms.loop_constraints import Counting
from freebody.arrays import Array, at_sample
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.equations import (
    blurred,
    branches,
    closing,
    counting,
    driven_coordinates,
    refuse_inconsistent,
    require_closed,
    scaled_jacobian,
    telling_much,
)
from freebody.loops.independent_equations import (
    counting_equations,
    independent_rows,
    partition,
)
from freebody.loops.rank_deficient import BLURRED, RANK, Idle, Jerk, solve
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import (
    loop_of_row,
    mechanism,
    null_space,
    rate_scale,
    row_scale,
)
from freebody.model.families import member_at
from freebody.model.geometry import first_member
from freebody.model.model import Model
from freebody.trees.public_calls import Vector, Wrenches, attempt, checked_inputs
from freebody.trees.special_joints import massless
from freebody.trees.states import difference, integrate

_REGULAR = 1e-2  # of the same, from which stages of an integration need no care
_SHORT = 0.01  # rad: a motion that shows where accelerations lead
# part of what accelerations add to it by which it may miss the closed positions: terms of third
# order
_ASIDE = 0.03
# part of a mechanism's motion, all coordinates as angles, by which a drive that stands still moves
_STILL = 1e-12
WOULD_OPEN = (
    "would open{} under these accelerations; "
    "make them consistent with fb.loop_acceleration(model, q, qd, qdd)"
)
STUCK = "cannot stay closed at these rates{}: the mechanism is locked"
"""What `require_consistent` says of accelerations that were given, and of those that were found."""


def forward_dynamics(model: Model, q: Vector, qd: Vector, tau: Vector, wrenches: Wrenches) -> Array:
    """See `fb.forward_dynamics`."""
    option = _solution(model, "state")
    if option is not None:
        found = attempt("forward_dynamics", model, (q, qd, tau), option, wrenches)
        if found is not None:
            return found
    frames, arrays = checked_inputs(
        "forward_dynamics", model, {"q": q, "qd": qd, "tau": tau}, wrenches
    )
    return definite_accelerations("forward_dynamics", model, frames, *arrays)


def definite_accelerations(
    function: str,
    model: Model,
    frames: tuple[str, ...],
    q: Array,
    qd: Array,
    tau: Array,
    *loads: Array,
) -> Array:
    """q̈ (..., nv); refuses states that the loops do not allow, and singular positions from which
    no way leads on."""
    qdd = _by_kernel(model, "state", frames, q, qd, tau, *loads)
    with_care = np.asarray(np.isnan(qdd).any(axis=-1))
    for taken, part in branches(model, q, with_care):
        require_closed(function, taken, q, qd, part)
        _complete(taken, frames, qdd, part, q, qd, tau, *loads)
        for index in np.argwhere(part):
            at = tuple(index)
            require_way(first_member(taken), q[at], qd[at], qdd[at])
        require_consistent(function, taken, q, qd, qdd, STUCK, part)
    return qdd


def accelerations(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """q̈ (..., nv), of states taken as closed: the stages of a motion, which by themselves do not
    tell where it goes."""
    qdd = _by_kernel(model, "solution", frames, q, qd, tau, *loads)
    _complete(model, frames, qdd, np.asarray(np.isnan(qdd).any(axis=-1)), q, qd, tau, *loads)
    return qdd


def _solution(model: Model, checks: str) -> Option | None:
    """How the quick solution takes the model's equations; None where no fixed choice of them
    does."""
    if redundancy(model).rank is not None:
        return None
    return Option(equations=counting_equations(model), checks=checks)


def _by_kernel(model: Model, checks: str, frames: tuple[str, ...], *arrays: Array) -> Array:
    """q̈ (..., nv) where M is regular and the equations are independent, else NaN."""
    option = _solution(model, checks)
    if option is None:
        return np.full(arrays[1].shape, np.nan)
    return fetch(model, ("forward_dynamics",), option._replace(wrench_frames=frames))(*arrays)


def _complete(
    model: Model,
    frames: tuple[str, ...],
    qdd: Array,
    with_care: NDArray[np.bool_],
    *arrays: Array,
) -> None:
    """Put the careful solution at the samples marked (...) of q̈ (..., nv) where all that is given
    is finite."""
    batch = qdd.shape[:-1]
    for at in np.argwhere(with_care):
        sample = tuple(at)
        some = [np.broadcast_to(x, (*batch, x.shape[-1]))[sample] for x in arrays]
        if all(np.isfinite(x).all() for x in some):
            qdd[sample] = careful(member_at(model, sample), frames, *some)


def regular(model: Model, q: Array) -> bool:
    """Whether the loop equations at q (nq,) are far from losing rank."""
    kept = independent_rows(model)
    if massless(model) or redundancy(model).rank is not None:
        s = np.linalg.svd(scaled_jacobian(model, q), compute_uv=False)[: len(kept)]
        return bool(s.min(initial=1.0) ** 2 > _REGULAR * s.max(initial=0.0) ** 2)
    quick = fetch(model, ("constrained_dynamics",), Option(equations=Counting(kept)))
    still = np.zeros(model.nv)
    return bool(_smallest(model, kept, quick(q, still, still)[2]) > _REGULAR)


def _smallest(model: Model, kept: tuple[int, ...], pivots: Array) -> Array:
    """(...): the smallest of the pivots (..., len(kept)) relative to the largest, NaN as it is."""
    if not kept:
        return np.ones(pivots.shape[:-1])
    scaled = pivots * row_scale(model)[list(kept)] ** 2
    return scaled.min(axis=-1) / scaled.max(axis=-1)


def careful(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """q̈ (nv,) of one state, whatever the rank."""
    option = Option(wrench_frames=frames)
    M, c = fetch(model, ("mass_matrix", "constraint_bias"), Option())(q, qd)
    A = scaled_jacobian(model, q)
    bias = fetch(model.opened, ("inverse_dynamics",), option)(q, qd, np.zeros(model.nv), *loads)
    rates = rate_scale(model)
    speed = float(np.abs(qd / rates).max(initial=0.0))
    try:
        c = counting(model, q, row_scale(model) * c)
        zero = blurred(model, moving=speed > 0.0)
        return solve(M, tau - bias, A, c, rates, _jerk(model, q, qd), speed, zero)
    except Idle as idle:
        raise SingularError(
            f"forward_dynamics: {model.name!r} has no unique acceleration: its loops let "
            f"{model.velocity_names[idle.coordinate]!r} move without moving any inertia. Give a "
            f"mass and inertia to what it carries, or a rotor inertia to the joint, or fix it."
        ) from None


def require_way(model: Model, q: Array, qd: Array, qdd: Array) -> None:
    """Refuse a singular position (nq,) from which the rates and accelerations found (nv,) lead
    nowhere."""
    zero = BLURRED if qd.any() else blurred(model, moving=False)
    _, loose = null_space(scaled_jacobian(model, q), zero)
    lost = mechanism(model).constraints - loose.shape[1] < len(independent_rows(model))
    if lost and not _leads_on(model, q, qd, qdd):
        worst = int(np.argmax(np.linalg.norm(loose, axis=1)))
        name = model.loops[loop_of_row(model)[worst]].name
        raise SingularError(
            f"forward_dynamics: {model.name!r} is at a singular position, where loop {name!r} no "
            f"longer determines how the motion continues. Start at a position near this one, or "
            f"with velocities along the branch that it should follow."
        )


def _leads_on(model: Model, q: Array, qd: Array, qdd: Array) -> bool:
    """Whether a short motion with these accelerations stays closed, but for terms of third
    order."""
    rates = rate_scale(model)
    first, second = qd / rates, qdd / rates
    speed, change = (float(np.abs(x).max(initial=0.0)) for x in (first, second))
    if speed == change == 0.0:
        return True
    h = min(_SHORT / max(speed, 1e-300), (2.0 * _SHORT / max(change, 1e-300)) ** 0.5)
    ahead = integrate(model, q, h * qd + 0.5 * h * h * qdd)
    closed, left = closing(model, ahead[None], range(model.nv))
    moved = float(np.abs(difference(model, ahead, closed[0]) / rates).max(initial=0.0))
    return bool(left[0] < 1e-12) and moved < _ASIDE * 0.5 * h * h * (change + speed**2)


def _jerk(model: Model, q: Array, qd: Array) -> Jerk:
    def at(x: Array) -> Array:
        return counting(
            model, q, row_scale(model) * fetch(model, ("constraint_jerk",), Option())(q, qd, x)
        )

    return at


def inverse_dynamics(
    model: Model,
    q: Vector,
    qd: Vector,
    qdd: Vector,
    wrenches: Wrenches,
    actuated: Sequence[str] | None = None,
    forces: Vector | None = None,
) -> Array:
    """See `fb.inverse_dynamics`."""
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
    """Torques (..., nv) of the drives, less what generalized forces (..., nv) do; refuses states
    and accelerations that the loops do not allow."""
    driven = driven_coordinates(function, model, actuated)
    arrays = q, qd, qdd, *loads
    tau = _by_drives("inverse_dynamics", model, driven, frames, arrays)
    if forces.any():
        tau = tau - _by_drives("drive_torques", model, driven, (), (q, forces))
    with_care = np.asarray(np.isnan(tau).any(axis=-1))
    for taken, part in branches(model, q, with_care):
        require_closed(function, taken, q, qd, part)
        require_consistent(function, taken, q, qd, qdd, WOULD_OPEN, part)
        needed = fetch(model.opened, ("inverse_dynamics",), Option(wrench_frames=frames))(*arrays)
        tau[part] = _careful_torques(function, taken, q, needed - forces, driven, part)
    return tau


def static_torque(model: Model, q: Vector, wrenches: Wrenches) -> Array:
    """See `fb.static_torque`."""
    found = _attempted("static_torque", model, (q,), wrenches)
    if found is not None:
        return found
    frames, arrays = checked_inputs("static_torque", model, {"q": q}, wrenches)
    tau = _by_drives("static_torque", model, model.driven, frames, tuple(arrays))
    with_care = np.asarray(np.isnan(tau).any(axis=-1))
    q = np.broadcast_to(arrays[0], (*tau.shape[:-1], model.nq))
    for taken, part in branches(model, q, with_care):
        require_closed("static_torque", taken, q, among=part)
        needed = fetch(model.opened, ("static_torque",), Option(wrench_frames=frames))(*arrays)
        tau[part] = _careful_torques("static_torque", taken, q, needed, model.driven, part)
    return tau


def _attempted(
    function: str,
    model: Model,
    inputs: tuple[Vector, ...],
    wrenches: Wrenches,
    actuated: Sequence[str] | None = None,
) -> Array | None:
    """The torques of the drives where a kernel is sure of them."""
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
    """Torques (..., nv) of the drives, of arrays q, …; NaN where a kernel is not sure."""
    chosen = partition(model, driven)
    if chosen is None:
        return np.full((*arrays[0].shape[:-1], model.nv), np.nan)
    option = Option(wrench_frames=frames, partition=chosen, checks="state")
    return fetch(model, (function,), option)(*arrays)


def torques(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """`inverse_dynamics` (..., nv) of states taken as closed: those between the samples of a
    motion, which its curve leaves open by as little as it is off."""
    needed = fetch(model.opened, ("inverse_dynamics",), Option())(q, qd, qdd)
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
    """The same at the chosen samples of a batch, (N, nv), whatever the rank; refuses what the
    drives cannot do."""
    rates, driven = rate_scale(model), list(driven)
    asked = rates * needed[chosen]
    tau = np.zeros_like(asked)
    _, s, Vt = np.linalg.svd(scaled_jacobian(model, q[chosen]))
    ranks = (s > RANK * s.max(axis=-1, keepdims=True, initial=1e-300)).sum(axis=-1)
    for rank in np.unique(ranks):
        at = np.flatnonzero(ranks == rank)
        N = np.swapaxes(Vt[at, rank:], -1, -2)
        motions = np.swapaxes(N[:, driven], -1, -2)
        power = np.einsum("nkf,nk->nf", N, asked[at])
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
                f"singular position of the second type). Drive another joint: actuated=[...]."
            )
        tau[at[:, None], driven] = found / rates[driven]
    return tau


def _left(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """(...): the largest equation, scaled to angles, that accelerations leave unsatisfied, relative
    to its terms."""
    left, c = missed(model, q, qd, qdd)
    size = 1.0 + np.abs(qdd / rate_scale(model)).max(axis=-1, initial=0.0) + np.abs(c).max(axis=-1)
    return np.abs(left).max(axis=-1) / size


def missed(model: Model, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array]:
    """(Φ_q q̈ - c, c) (..., m), scaled, as far as they tell."""
    phi, c = fetch(first_member(model), ("constraint_jacobian", "constraint_bias"), Option())(q, qd)
    rows = row_scale(model)
    left = rows * (np.einsum("...mk,...k->...m", phi, qdd) - c)
    return telling_much(model, q, qd, left), rows * c


def require_consistent(
    function: str,
    model: Model,
    q: Array,
    qd: Array,
    qdd: Array,
    problem: str,
    among: NDArray[np.bool_],
) -> None:
    """Refuse accelerations at the samples marked (...) that would open a loop, with a problem that
    has a place for the sample."""
    bad = np.argwhere(among & (_left(model, q, qd, qdd) > max(LEFT, redundancy(model).slack)))
    if len(bad):
        at = tuple(map(int, bad[0]))
        q, qd, qdd = (x[at] for x in (q, qd, qdd))
        refuse_inconsistent(
            function, model, missed(model, q, qd, qdd)[0], problem.format(at_sample(at))
        )
