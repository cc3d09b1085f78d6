"""Large matrices column by column, by the products of a matrix and a vector: each returns arrays
(..., column, row)."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.kernels.formulas.record import Fetch


def mass(given: list[Array], n: int, fetch: Fetch, threads: int | None) -> tuple[Array, ...]:
    """M."""
    (q,) = given
    return (fetch("mass_product")(q, np.eye(n), threads=threads),)


def inverse_mass(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """M⁻¹."""
    inverse: Array = np.asarray(np.linalg.inv(mass(given, n, fetch, threads)[0]), dtype=np.float64)
    return (inverse,)


def coriolis(given: list[Array], n: int, fetch: Fetch, threads: int | None) -> tuple[Array, ...]:
    """C."""
    q, qd = given
    return (fetch("coriolis_product")(q, qd, np.eye(n), threads=threads),)


def inverse_derivatives(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """∂τ/∂q, ∂τ/∂q̇ and M."""
    q, qd, qdd = given
    along, none, units = fetch("inverse_dynamics_along"), np.zeros(n), np.eye(n)
    by_q = along(q, qd, qdd, units, none, threads=threads)
    by_qd = along(q, qd, qdd, none, units, threads=threads)
    return by_q, by_qd, *mass([q], n, fetch, threads)


def forward_derivatives(
    given: list[Array], n: int, fetch: Fetch, threads: int | None
) -> tuple[Array, ...]:
    """∂q̈/∂q, ∂q̈/∂q̇ and M⁻¹."""
    q, qd, tau = given
    qdd = fetch("forward_dynamics")(q, qd, tau, threads=threads)
    by_q, by_qd, M = (
        np.swapaxes(x, -1, -2) for x in inverse_derivatives([q, qd, qdd], n, fetch, threads)
    )
    inverse: Array = np.asarray(np.linalg.inv(M), dtype=np.float64)
    results: tuple[Array, ...] = (-inverse @ by_q, -inverse @ by_qd, inverse)
    return tuple(np.swapaxes(x, -1, -2) for x in results)
