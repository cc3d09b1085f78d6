"""Accelerations of closed chains under given forces: by a kernel where its result is sure, else by
singular values.

Lagrange's equations of the first kind (5.29) are then solved where equations depend on one another,
or lose rank:

    M q̈ + Φ_qᵀ λ = n,   Φ_q q̈ = c

Singular values tell the rank of Φ_q. What it leaves open is found in its null space N, where λ does
no work: Nᵀ M q̈ = Nᵀ n. Links without mass are welcome, as long as no motion that the loops allow
moves nothing but them. Where Φ_q has lost rank and the mechanism moves, Φ's third derivative must
vanish too; what that asks of q̈ is solved besides, so that a motion through a singular position
stays on its branch.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.loop_constraints import Counting
from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import fetch
from freebody.loops.equations import (
    blurred,
    branches,
    closing,
    counting,
    require_closed,
    require_consistent,
    scaled_jacobian,
)
from freebody.loops.independent_equations import (
    counting_equations,
    independent_rows,
)
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import (
    BLURRED,
    loop_of_row,
    mechanism,
    null_space,
    rate_scale,
    row_scale,
)
from freebody.model.families import member_at
from freebody.model.geometry import first_member
from freebody.model.model import Model
from freebody.trees.public_calls import (
    FrameWrenchTable,
    JointVector,
    attempt,
    checked_inputs,
    refuse_without_length,
)
from freebody.trees.special_joints import massless
from freebody.trees.states import difference, integrate

_Jerk = Callable[[Array], Array]
"""x (k, nv) -> Φ's third derivative at q̈ = x (k, m), scaled."""
_REGULAR = 1e-2  # of pivots, least over largest, from which stages of an integration need no care
_SHORT = 0.01  # rad: a motion that shows where accelerations lead


# part of what accelerations add to it by which it may miss the closed positions: terms of third
# order
_ASIDE = 0.03
_BRANCH = 1e-7  # singular values of the conditions at a singular position, relative to the speed
_IDLE = 1e-13  # of the largest inertia: none
_STUCK = "cannot stay closed at these rates{}: the mechanism is locked"
"""Sentence of `require_consistent` about accelerations that were found."""


def forward_dynamics(
    model: Model, q: JointVector, qd: JointVector, tau: JointVector, wrenches: FrameWrenchTable
) -> Array:
    """Accelerations of a closed chain: `fb.forward_dynamics`."""
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
    """Accelerations q̈ (..., nv); refuses states that violate the loops, and singular positions
    where the motion cannot go on."""
    qdd = _by_kernel(model, "state", frames, q, qd, tau, *loads)
    with_care = np.asarray(np.isnan(qdd).any(axis=-1))
    refuse_without_length(function, model, q)
    for taken, part in branches(model, q, with_care):
        require_closed(function, taken, q, qd, part)
        _complete(taken, frames, qdd, part, q, qd, tau, *loads)
        for index in np.argwhere(part):
            at = tuple(index)
            require_way(first_member(taken), q[at], qd[at], qdd[at])
        require_consistent(function, taken, q, qd, qdd, _STUCK, part)
    return qdd


def accelerations(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """Accelerations q̈ (..., nv) at the stages of a motion, whose states are taken as closed
    without a check."""
    qdd = _by_kernel(model, "solution", frames, q, qd, tau, *loads)
    _complete(model, frames, qdd, np.asarray(np.isnan(qdd).any(axis=-1)), q, qd, tau, *loads)
    return qdd


def _solution(model: Model, checks: str) -> Option | None:
    """The option under which the quick kernel solves the model's equations; None where no fixed
    choice of equations is independent everywhere."""
    if redundancy(model).rank is not None:
        return None
    return Option(equations=counting_equations(model), checks=checks)


def _by_kernel(model: Model, checks: str, frames: tuple[str, ...], *arrays: Array) -> Array:
    """Accelerations q̈ (..., nv) by a kernel; NaN where M is not regular or the equations are not
    independent."""
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
    """Compute q̈ (..., nv) by singular values at the marked samples (...) whose inputs are all
    finite."""
    batch = qdd.shape[:-1]
    for at in np.argwhere(with_care):
        sample = tuple(at)
        some = [np.broadcast_to(x, (*batch, x.shape[-1]))[sample] for x in arrays]
        if all(np.isfinite(x).all() for x in some):
            qdd[sample] = _careful(member_at(model, sample), frames, *some)


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
    """The smallest of the scaled pivots (..., len(kept)) divided by the largest (...); NaN stays
    NaN."""
    if not kept:
        return np.ones(pivots.shape[:-1])
    scaled = pivots * row_scale(model)[list(kept)] ** 2
    return scaled.min(axis=-1) / scaled.max(axis=-1)


def _careful(
    model: Model, frames: tuple[str, ...], q: Array, qd: Array, tau: Array, *loads: Array
) -> Array:
    """Accelerations q̈ (nv,) of one state, by singular values, whatever the rank of its
    equations."""
    option = Option(wrench_frames=frames)
    M, c = fetch(model, ("mass_matrix", "constraint_bias"), Option())(q, qd)
    A = scaled_jacobian(model, q)
    bias = fetch(model.opened, ("inverse_dynamics",), option)(q, qd, np.zeros(model.nv), *loads)
    rates = rate_scale(model)
    speed = float(np.abs(qd / rates).max(initial=0.0))
    try:
        c = counting(model, q, row_scale(model) * c)
        zero = blurred(model, moving=speed > 0.0)
        return _solve(M, tau - bias, A, c, rates, _jerk(model, q, qd), speed, zero)
    except _Idle as idle:
        raise SingularError(
            f"forward_dynamics: {model.name!r} has no unique acceleration: its loops let "
            f"{model.velocity_names[idle.coordinate]!r} move without moving any inertia. Give a "
            f"mass and inertia to what it carries, or a rotor inertia to the joint, or fix it."
        ) from None


def require_way(model: Model, q: Array, qd: Array, qdd: Array) -> None:
    """Refuse a singular position (nq,) from which the rates and accelerations found (nv,) cannot
    continue to closed positions."""
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
    """Whether a short motion with these rates and accelerations stays closed, up to terms of third
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


def _jerk(model: Model, q: Array, qd: Array) -> _Jerk:
    def at(x: Array) -> Array:
        return counting(
            model, q, row_scale(model) * fetch(model, ("constraint_jerk",), Option())(q, qd, x)
        )

    return at


def _solve(
    M: Array,
    n: Array,
    A: Array,
    c: Array,
    rates: Array,
    jerk: _Jerk,
    speed: float,
    blurred: float = BLURRED,
) -> Array:
    """Accelerations q̈ (nv,) of one state from the loop equations and equations of motion; raises
    _Idle.

    M (nv, nv), n (nv,); A (m, nv), c (m,): scaled as in `equations`, over rates scaled by `rates`
    (nv,); speed: of the fastest scaled rate; blurred: singular values, relative to the largest,
    that count as zero.
    """
    mass, force = rates[:, None] * M * rates, rates * n
    U, s, Vt = np.linalg.svd(A)
    rank = int((s > blurred * s.max(initial=1e-300)).sum())
    loose, null = U[:, rank:], Vt[rank:].T
    x = Vt[:rank].T @ ((U[:, :rank].T @ c) / s[:rank])
    if null.shape[1]:
        ways = null @ _unit_root(null, mass)  # of unit inertia: wayᵀ M way = 1
        x = x + ways @ (ways.T @ (force - mass @ x))
        if loose.shape[1] and speed > 0.0:
            x = x + ways @ _onto_branch(x, ways, loose.T, rates, jerk, speed)
    return rates * x


def _unit_root(null: Array, mass: Array) -> Array:
    """A matrix W (k, k) with Wᵀ (Nᵀ M N) W = 1 for the basis N of a null space."""
    sizes, vectors = np.linalg.eigh(null.T @ mass @ null)
    if sizes[0] <= _IDLE * max(float(np.abs(np.diagonal(mass)).max()), 1e-300):
        raise _Idle(int(np.argmax(np.abs(null @ vectors[:, 0]))))
    return vectors / np.sqrt(sizes)


def _onto_branch(
    x: Array, ways: Array, loose: Array, rates: Array, jerk: _Jerk, speed: float
) -> Array:
    """Weights (k,) of the free directions (nv, k) to be added to q̈ so that the third derivative of
    Φ can vanish."""
    values = jerk(rates * np.concatenate([x[None], x + ways.T]))
    at, slopes = loose @ values[0], loose @ (values[1:] - values[0]).T
    U, s, Vt = np.linalg.svd(slopes, full_matrices=False)
    # ways are as long as M makes them; compare with the largest turn they make
    kept = s > _BRANCH * speed * max(float(np.abs(ways).max(initial=0.0)), 1e-300)
    return -Vt[kept].T @ ((U[:, kept].T @ at) / s[kept])


class _Idle(Exception):
    """Raised where a motion that the loops allow moves no inertia; names the coordinate that moves
    most in it."""

    def __init__(self, coordinate: int):
        super().__init__(coordinate)
        self.coordinate = coordinate
