"""The equations of motion linearised about a state, and the linear-quadratic regulator of the
result."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError
from freebody.model.model import Model
from freebody.trees.dynamics import forward_dynamics_derivatives
from freebody.trees.public_calls import JointVector, finite_vector

_SYMMETRIC = 1e-9
"""How far from symmetric a matrix may be by rounding, relative to its largest entry."""

_ROUNDED = 1e-10
"""Error of an eigenvalue of 1 by rounding."""


def linearize(
    model: Model, q: JointVector, qd: JointVector, tau: JointVector, step: float | None = None
) -> tuple[Array, Array]:
    """(A, B) of ẋ = A x + B u: how a small deviation x = (δq, δq̇) from the motion through a state
    changes with that of the drives' torques, u.

    q: (..., nq); qd, tau: (..., nv). A: (..., 2 nv, 2 nv). B: (..., 2 nv, m), a column for each of
    the m driven coordinates (`model.driven_names`). step (s): instead x(t + step) = A x(t) + B u(t)
    with u held over it, by the matrix exponential. δq is `fb.difference(model, q, q + δq)`, rad
    and m; with spherical and free joints the state must be at rest. The sign of dry friction is
    constant. Raises FreebodyError, SingularError, PassiveJointError.
    """
    model.require_tree("linearize")
    rates = finite_vector("linearize", model, "qd", qd)
    if model.nq != model.nv and rates.any():
        raise FreebodyError(
            f"linearize: {model.name!r} has spherical or free joints, whose positions do not add: "
            f"it is linearised at rest alone, with qd = 0."
        )
    by_q, by_qd, by_tau = forward_dynamics_derivatives(model, q, rates, tau)
    n = model.nv
    drives = list(model.driven)
    A = np.zeros((*by_q.shape[:-2], 2 * n, 2 * n))
    B = np.zeros((*by_q.shape[:-2], 2 * n, len(drives)))
    A[..., :n, n:] = np.eye(n)
    A[..., n:, :n], A[..., n:, n:] = by_q, by_qd
    B[..., n:, :] = by_tau[..., drives]
    return (A, B) if step is None else _held(A, B, above_zero("linearize", "step", step, "seconds"))


def _held(A: Array, B: Array, step: float) -> tuple[Array, Array]:
    """The discrete A and B over a step with constant inputs: the upper rows of exp(step [A B; 0 0])
    (Van Loan 1978)."""
    from scipy.linalg import expm

    n, m = B.shape[-2:]
    both = np.zeros((*A.shape[:-2], n + m, n + m))
    both[..., :n, :n], both[..., :n, n:] = A, B
    found = np.asarray(expm(step * both), dtype=np.float64)
    return found[..., :n, :n], found[..., :n, n:]


def discrete_lqr(A: ArrayLike, B: ArrayLike, Q: ArrayLike, R: ArrayLike) -> Array:
    """The gain K (m, n) of the feedback u = -K x that minimises Σ xᵀ Q x + uᵀ R u along x⁺ = A x +
    B u.

    A: (n, n), B: (n, m), as `fb.linearize(model, q, qd, tau, step)` returns them. Q: (n, n),
    symmetric, no eigenvalue below 0; R: (m, m), symmetric, all eigenvalues above 0. By SciPy's
    `solve_discrete_are`. Raises FreebodyError where the inputs cannot stabilise the state, or Q
    does not weigh all that is unstable; ShapeError, NotFiniteError.
    """
    given = {"A": A, "B": B, "Q": Q, "R": R}
    A, B, Q, R = (_matrix(name, value) for name, value in given.items())
    n, m = len(A), B.shape[-1]
    for name, x, size in (("A", A, (n, n)), ("B", B, (n, m)), ("Q", Q, (n, n)), ("R", R, (m, m))):
        if x.shape != size:
            raise ShapeError("discrete_lqr", name, x.shape, str(size), "A (n, n), B (n, m)")
    _require_weight("Q", Q, False)
    _require_weight("R", R, True)
    from scipy.linalg import solve_discrete_are

    refusal = FreebodyError(
        "discrete_lqr: no feedback stabilises this: the inputs B do not reach an unstable part of "
        "A, or Q does not weigh it. Give Q weight on every position, and look at the drives."
    )
    try:
        P = solve_discrete_are(A, B, Q, R)
    except np.linalg.LinAlgError:
        raise refusal from None
    K = np.asarray(np.linalg.solve(R + B.T @ P @ B, B.T @ P @ A), dtype=np.float64)
    if not np.abs(np.linalg.eigvals(A - B @ K)).max(initial=0.0) < 1.0 - _ROUNDED:
        raise refusal
    return K


def _matrix(name: str, value: ArrayLike) -> Array:
    array = as_floats("discrete_lqr", name, value)
    if array.ndim != 2:
        raise ShapeError("discrete_lqr", name, array.shape, "a matrix", "one system, no batch")
    refuse_not_finite("discrete_lqr", name, array, 2)
    return array


def _require_weight(name: str, weight: Array, positive: bool) -> None:
    """Refuse a weight matrix that is not symmetric, or that has a negative eigenvalue (positive: or
    a zero one)."""
    largest = float(np.abs(weight).max(initial=0.0))
    if np.abs(weight - weight.T).max(initial=0.0) > _SYMMETRIC * largest:
        raise FreebodyError(f"discrete_lqr: {name} is not symmetric.")
    least = float(np.linalg.eigvalsh(weight).min(initial=np.inf))
    if least <= 0.0 if positive else least < -_SYMMETRIC * largest:
        wanted = "above 0" if positive else "at least 0"
        raise FreebodyError(
            f"discrete_lqr: the least eigenvalue of {name} is {least:.3g}, expected {wanted}: the "
            f"cost would have no least value."
        )
