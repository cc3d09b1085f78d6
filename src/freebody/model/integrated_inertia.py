"""Mass properties by integration over a shape, and from an inertia about some other point (notes,
1.16, 1.18, 1.19)."""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from freebody.arrays import Array, above_zero, as_floats
from freebody.errors import KindError, ModelError, ShapeError
from freebody.labels import refuse_labelled
from freebody.model.inertia import Inertia

_POINTS = 32
"""Gauss-Legendre points a parameter; exact for polynomials, and to rounding for a full turn of sine
and cosine."""

_STEP = 1e-30
"""Size of the complex step: far below rounding, since nothing is subtracted."""


def integrated_inertia(
    points: Callable[..., Sequence[Any]], bounds: Sequence[tuple[float, float]], mass: float = 1.0
) -> Inertia:
    """A uniform body from a map of parameters to its points: r_G = ∫ r dm / m (1.16) and I_G = ∫ ρ²
    dm (1.18).

    For example, integrated_inertia(lambda r, a: (r*np.cos(a), r*np.sin(a)), [(0, 0.3), (0,
    2*np.pi)], 2.0) is a disc.

    Parameters
    ----------
    points
        A function of one to three parameters that returns the coordinates (2 or 3, in m) by NumPy's
        functions. One parameter makes a wire, two a plate, three a solid.
    bounds
        The range of each parameter.
    mass
        kg.

    Raises
    ------
    ModelError
        A map that covers nothing.
    """
    if not callable(points):
        raise KindError("integrated_inertia", "points", points, "a function of the parameters")
    if as_floats("integrated_inertia", "bounds", bounds).shape[1:] != (2,):
        raise KindError("integrated_inertia", "bounds", bounds, "a pair for each parameter")
    u, w = _nodes(bounds)
    r = _at(points, u).real
    tangents = np.stack(
        [_at(points, _shifted(u, k)).imag / _STEP for k in range(len(bounds))], axis=-1
    )
    dm = w * np.sqrt(np.linalg.det(np.swapaxes(tangents, -1, -2) @ tangents))
    if not np.all(np.isfinite(dm)) or dm.sum() <= 0.0:
        raise ModelError(
            "integrated_inertia: the map covers nothing; give it as many independent directions as "
            "parameters."
        )
    dm *= mass / dm.sum()
    com = dm @ r / mass
    return Inertia.of(mass, com.tolist(), _second(r - com, dm))


def inertia_from(
    mass: float, com: Sequence[float] | Array, tensor: Any, about: Sequence[float] | Array
) -> Inertia:
    """The body whose inertia about a point is `tensor`, a number in the plane: I_G = I_O - m d²
    (1.19).

    com, about: (2,) or (3,), m. Raises ModelError where what is left is no inertia: (1.19) leads
    from the centre of mass to other points, not from any point to any other.
    """
    for name, given in (("com", com), ("tensor", tensor), ("about", about)):
        refuse_labelled(f"inertia_from: {name}", given)
    mass = above_zero("inertia_from", "mass", mass, "kg")
    d = as_floats("inertia_from", "com", com) - as_floats("inertia_from", "about", about)
    about_point = as_floats("inertia_from", "tensor", tensor)
    core = (3, 3) if d.shape == (3,) else ()
    if about_point.shape != core:
        raise ShapeError("inertia_from", "tensor", about_point.shape, str(core))
    body = Inertia.of(mass, tuple(com), about_point - _second(d[None], np.array([mass])))
    fault = body.fault()
    if fault is not None:
        raise ModelError(
            f"inertia_from: the inertia given about {list(map(float, about))} is too small: "
            f"{fault}."
        )
    return body


def _nodes(bounds: Sequence[tuple[float, float]]) -> tuple[Array, Array]:
    """Points (k, n) of the box, and weights (k,)."""
    x, w = np.polynomial.legendre.leggauss(_POINTS)
    axes = [((b - a) / 2 * x + (a + b) / 2, (b - a) / 2 * w) for a, b in bounds]
    u = np.array(list(itertools.product(*(axis for axis, _ in axes))))
    return u, np.prod(list(itertools.product(*(weights for _, weights in axes))), axis=1)


def _shifted(u: Array, k: int) -> Array:
    return u + 1j * _STEP * np.eye(u.shape[1])[k]


def _at(points: Callable[..., Sequence[Any]], u: Array) -> Array:
    """Points (k, dim) of a body at the parameters u (k, ...) over which its inertia is
    integrated."""
    rows = [np.broadcast_to(x, len(u)) for x in points(*u.T)]
    return np.stack(rows, axis=-1).astype(complex)


def _second(rho: Array, dm: Array) -> Any:
    """∫ (ρ² 1 - ρ ρᵀ) dm, a number in the plane."""
    if rho.shape[1] == 2:
        return float(dm @ (rho**2).sum(axis=1))
    outer = np.einsum("k,ki,kj->ij", dm, rho, rho)
    return np.trace(outer) * np.eye(3) - outer
