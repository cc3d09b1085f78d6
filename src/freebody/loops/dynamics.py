"""Motion from forces and forces from motion, of closed chains."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array, at_sample
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.assembly import free_coordinates
from freebody.loops.equations import (
    blurred,
    closing,
    counting,
    refuse_inconsistent,
    require_closed,
    scaled_jacobian,
    telling_much,
)
from freebody.loops.partition import independent_rows, partition
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled import length, loop_of_row, null_space, rate_scale, row_scale
from freebody.loops.solving import BLURRED, RANK, Idle, Jerk, solve
from freebody.model.model import Model
from freebody.trees.calls import Vector, Wrenches, checked_inputs
from freebody.trees.massless import massless
from freebody.trees.states import difference, integrate

_PIVOT = 1e-4
"""The smallest pivot of the quick solution relative to the largest; below, the careful solution takes over. Rounding
there is 1e-16 over the pivot, and motions through singular positions carry it on: a double four-bar that passes ten of
them is right to 1e-9 with this, with a hundredth of it to 1e-7."""
_REGULAR = 1e-2  # of the same, from which stages of an integration need no care
_LIGHT = 1e10  # the mechanism's inertia over that which resists a loop; rad/s²
_SHORT = 0.01  # rad: a motion that shows where accelerations lead
_ASIDE = 0.03  # part of what accelerations add to it by which it may miss the closed positions: terms of third order
_LEFT = 1e-6  # of an equation, relative to its terms: more is no rounding
WOULD_OPEN = "would open{} under these accelerations; make them consistent with fb.loop_acceleration(model, q, qd, qdd)"
STUCK = "cannot stay closed at these rates{}: the mechanism is stuck"
"""What `require_consistent` says of accelerations that were given, and of those that were found."""


def forward(model: Model, q: Vector, qd: Vector, tau: Vector, wrenches: Wrenches) -> Array:
    """See `fb.forward_dynamics`."""
    frames, (at, rates, drive, *loads) = checked_inputs(
        "forward_dynamics", model, {"q": q, "qd": qd, "tau": tau}, wrenches
    )
    require_closed("forward_dynamics", model, at, rates)
    qdd = definite_accelerations(model, frames, at, rates, drive, *loads)
    require_consistent("forward_dynamics", model, at, rates, qdd, STUCK)
    return qdd


def definite_accelerations(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """The same as `accelerations`; refuses singular positions from which no way leads on."""
    qdd, with_care = _solved(model, frames, q, qd, tau, *loads)
    for index in np.argwhere(with_care):
        at = tuple(index)
        require_way(model, q[at], qd[at], qdd[at])
    return qdd


def accelerations(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """q̈ (..., nv), of states taken as closed: the stages of a motion, which by themselves do not tell where it goes."""
    return _solved(model, frames, q, qd, tau, *loads)[0]


def _solved(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> tuple[Array, NDArray[np.bool_]]:
    """(q̈ (..., nv), which samples took care): compiled where M is regular and the equations are independent."""
    if massless(model) or redundancy(model).rank is not None:
        qdd = np.empty(qd.shape)
        for at in np.ndindex(qd.shape[:-1]):
            qdd[at] = careful(model, frames, *(x[at] for x in (q, qd, tau, *loads)))
        return qdd, np.ones(qd.shape[:-1], dtype=bool)
    kept = independent_rows(model)
    quick = fetch(model, ("constrained_dynamics",), Option(wrench_frames=frames, equations=kept))
    qdd, _, pivots = quick(q, qd, tau, *loads)
    poor = ~(_smallest(model, kept, pivots) > _PIVOT) | _light(model, kept, pivots, qdd)
    if len(kept) < model.tree.constraints:
        poor |= _left(model, q, qd, qdd) > _LEFT
    for at in np.argwhere(poor):
        sample = tuple(at)
        part = [np.broadcast_to(x, (*poor.shape, x.shape[-1]))[sample] for x in (q, qd, tau, *loads)]
        qdd[sample] = careful(model, frames, *part)
    return qdd, poor


def regular(model: Model, q: Array) -> bool:
    """Whether the loop equations at q (nq,) are far from losing rank."""
    kept = independent_rows(model)
    if massless(model) or redundancy(model).rank is not None:
        s = np.linalg.svd(scaled_jacobian(model, q), compute_uv=False)[: len(kept)]
        return bool(s.min(initial=1.0) ** 2 > _REGULAR * s.max(initial=0.0) ** 2)
    quick = fetch(model, ("constrained_dynamics",), Option(equations=kept))
    still = np.zeros(model.nv)
    return bool(_smallest(model, kept, quick(q, still, still)[2]) > _REGULAR)


def _smallest(model: Model, kept: tuple[int, ...], pivots: Array) -> Array:
    """(...): the smallest of the pivots (..., len(kept)) relative to the largest, NaN as it is."""
    if not kept:
        return np.ones(pivots.shape[:-1])
    scaled = pivots * row_scale(model)[list(kept)] ** 2
    return scaled.min(axis=-1) / scaled.max(axis=-1)


def _light(model: Model, kept: tuple[int, ...], pivots: Array, qdd: Array) -> NDArray[np.bool_]:
    """(...): whether so little inertia resists some motion that the quick solution divides by rounding."""
    scaled = pivots * row_scale(model)[list(kept)] ** 2 * model.mass * length(model) ** 2
    fastest = np.abs(qdd / rate_scale(model)).max(axis=-1, initial=0.0)
    return (scaled.max(axis=-1, initial=0.0) > _LIGHT) | (fastest > _LIGHT)


def careful(model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array) -> Array:
    """q̈ (nv,) of one state, whatever the rank."""
    option = Option(wrench_frames=frames)
    M, c = fetch(model, ("mass_matrix", "constraint_bias"), Option())(q, qd)
    A = scaled_jacobian(model, q)
    bias = fetch(model.opened, ("inverse_dynamics",), option)(q, qd, np.zeros(model.nv), *loads)
    rates = rate_scale(model)
    speed = float(np.abs(qd / rates).max(initial=0.0))
    try:
        c = counting(model, q, row_scale(model) * c)
        return solve(M, tau - bias, A, c, rates, _jerk(model, q, qd), speed, blurred(model))
    except Idle as idle:
        raise SingularError(
            f"forward_dynamics: {model.name!r} has no definite acceleration: its loops let "
            f"{model.velocity_names[idle.coordinate]!r} move without moving any inertia. "
            "Give what it carries a mass and inertia, or the joint a rotor inertia, or fix it."
        ) from None


def require_way(model: Model, q: Array, qd: Array, qdd: Array) -> None:
    """Refuse a singular position (nq,) from which the rates and accelerations found (nv,) lead nowhere."""
    _, loose = null_space(scaled_jacobian(model, q), BLURRED)
    lost = model.tree.constraints - loose.shape[1] < len(independent_rows(model))
    if lost and not _leads_on(model, q, qd, qdd):
        worst = int(np.argmax(np.linalg.norm(loose, axis=1)))
        name = model.loops[loop_of_row(model)[worst]].name
        raise SingularError(
            f"forward_dynamics: {model.name!r} is at a singular position, where loop {name!r} no longer tells how the "
            "motion goes on. Start a little beside this position, or with the rates of the way it shall take."
        )


def _leads_on(model: Model, q: Array, qd: Array, qdd: Array) -> bool:
    """Whether a short motion with these accelerations stays closed, but for terms of third order."""
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
        return counting(model, q, row_scale(model) * fetch(model, ("constraint_jerk",), Option())(q, qd, x))

    return at


def inverse(
    model: Model, q: Vector, qd: Vector, qdd: Vector, wrenches: Wrenches, actuated: Sequence[str] | None
) -> Array:
    """See `fb.inverse_dynamics`."""
    frames, (at, rates, second, *loads) = checked_inputs(
        "inverse_dynamics", model, {"q": q, "qd": qd, "qdd": qdd}, wrenches
    )
    require_closed("inverse_dynamics", model, at, rates)
    needed = fetch(model.opened, ("inverse_dynamics",), Option(wrench_frames=frames))(
        at, rates, second, *loads
    )
    require_consistent("inverse_dynamics", model, at, rates, second, WOULD_OPEN)
    return drive_torques("inverse_dynamics", model, at, needed, actuated)


def holding(model: Model, q: Vector, wrenches: Wrenches) -> Array:
    """See `fb.static_torque`."""
    frames, (at, *loads) = checked_inputs("static_torque", model, {"q": q}, wrenches)
    require_closed("static_torque", model, at)
    needed = fetch(model.opened, ("static_torque",), Option(wrench_frames=frames))(at, *loads)
    return drive_torques("static_torque", model, at, needed)


def torques(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """`inverse` (..., nv) of states taken as closed: those between the samples of a motion, which its curve leaves open
    by as little as it is off."""
    needed = fetch(model.opened, ("inverse_dynamics",), Option())(q, qd, qdd)
    return drive_torques("inverse_dynamics", model, q, needed)


def drive_torques(
    function: str, model: Model, q: Array, needed: Array, actuated: Sequence[str] | None = None
) -> Array:
    """Torques (..., nv) of the driven joints, zero elsewhere, with the power of `needed` in every motion that the loops
    allow.

    needed (..., nv): torques of the tree that is left when all loops are cut. Least norm where too many drive.
    """
    driven = free_coordinates(model, model.actuated if actuated is None else actuated, function)
    chosen = partition(model, driven)
    if chosen is None:
        tau, with_care = np.zeros(needed.shape), np.ones(needed.shape[:-1], dtype=bool)
    else:
        tau = fetch(model, ("drive_torques",), Option(partition=chosen))(q, needed)
        with_care = np.isnan(tau).any(axis=-1)
    if with_care.any():
        q = np.broadcast_to(q, (*needed.shape[:-1], model.nq))
        tau[with_care] = _careful_torques(function, model, q, needed, driven, with_care)
    return tau


def _careful_torques(
    function: str, model: Model, q: Array, needed: Array, driven: list[int], chosen: NDArray[np.bool_]
) -> Array:
    """The same at the chosen samples of a batch, (N, nv), whatever the rank; refuses what the drives cannot do."""
    rates = rate_scale(model)
    asked = rates * needed[chosen]
    tau = np.zeros_like(asked)
    _, s, Vt = np.linalg.svd(scaled_jacobian(model, q[chosen]))
    ranks = (s > RANK * s.max(axis=-1, keepdims=True, initial=1e-300)).sum(axis=-1)
    for rank in np.unique(ranks):
        at = np.flatnonzero(ranks == rank)
        N = np.swapaxes(Vt[at, rank:], -1, -2)
        motions = np.swapaxes(N[:, driven], -1, -2)
        power = np.einsum("nkf,nk->nf", N, asked[at])
        found = np.einsum("nkf,nf->nk", np.linalg.pinv(motions, rcond=1e-9), power)
        missed = np.abs(np.einsum("nfk,nk->nf", motions, found) - power).max(axis=-1, initial=0.0)
        bad = np.flatnonzero(missed > 1e-9 * (1.0 + np.abs(power).max(axis=-1, initial=0.0)))
        if len(bad):
            names = ", ".join(model.velocity_names[k] for k in driven) or "none"
            where = at_sample(tuple(map(int, np.argwhere(chosen)[at[bad[0]]])))
            raise SingularError(
                f"{function}: the driven joints of {model.name!r} ({names}) cannot force this motion{where}: it moves "
                "though they stand still (too few drives, or a singular position of the second type). "
                "Drive another joint: actuated=[...]."
            )
        tau[at[:, None], driven] = found / rates[driven]
    return tau


def _left(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """(...): the largest equation, scaled to angles, that accelerations leave unsatisfied, relative to its terms."""
    left, c = missed(model, q, qd, qdd)
    size = 1.0 + np.abs(qdd / rate_scale(model)).max(axis=-1, initial=0.0) + np.abs(c).max(axis=-1)
    return np.abs(left).max(axis=-1) / size


def missed(model: Model, q: Array, qd: Array, qdd: Array) -> tuple[Array, Array]:
    """(Φ_q q̈ - c, c) (..., m), scaled, as far as they tell."""
    phi, c = fetch(model, ("constraint_jacobian", "constraint_bias"), Option())(q, qd)
    rows = row_scale(model)
    left = rows * (np.einsum("...mk,...k->...m", phi, qdd) - c)
    return telling_much(model, q, left), rows * c


def require_consistent(function: str, model: Model, q: Array, qd: Array, qdd: Array, problem: str) -> None:
    """Refuse accelerations that would open a loop, with a problem that has a place for the sample."""
    bad = np.argwhere(_left(model, q, qd, qdd) > max(_LEFT, redundancy(model).slack))
    if len(bad):
        at = tuple(map(int, bad[0]))
        q, qd, qdd = (x[at] for x in (q, qd, qdd))
        refuse_inconsistent(function, model, missed(model, q, qd, qdd)[0], problem.format(at_sample(at)))
