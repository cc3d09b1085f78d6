"""How errors grow along a motion, linearised, and pieces in which they grow little."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import Ranges, position_columns
from freebody.motion.simulation.first_order_system import System
from freebody.report.stepped_runs import Reference

BOUND = 1e4
"""Amplification that a piece may have at most."""

_GRID = 400
_HALVINGS = 14


def scaling(model: Model, allowed: Ranges) -> Array:
    """What each entry of (q, q̇) is measured in (nq + nv,): the range, and the range per second;
    quaternions 1."""
    position = np.ones(model.nq)
    iq, iv = position_columns(model)
    position[iq] = allowed.width[iv]
    return np.concatenate([position, allowed.width])


def transitions(whole: System, motion: Motion, scale: Array) -> tuple[Array, Array]:
    """Grid times (k + 1,) and the scaled state-transition matrices (k, n, n) of its steps along the
    motion.

    Each is the exponential of the linearised dynamics at the step's middle. Steps are halved until
    none alone amplifies by more than a tenth of the bound: near poses where the mass matrix is all
    but singular they become very short.
    """
    times = np.linspace(motion.t[0], motion.t[-1], _GRID + 1)
    steps = _steps(whole, motion, scale, times[:-1], times[1:])
    for _ in range(_HALVINGS):
        sizes = np.abs(steps).sum(axis=-1).max(axis=-1)
        wild = np.flatnonzero(~(sizes <= 0.1 * BOUND))  # infinite ones, too
        if not len(wild):
            break
        middles = 0.5 * (times[wild] + times[wild + 1])
        second = _steps(whole, motion, scale, middles, times[wild + 1])
        steps[wild] = _steps(whole, motion, scale, times[wild], middles)
        times = np.insert(times, wild + 1, middles)
        steps = np.insert(steps, wild + 1, second, axis=0)
    return times, steps


def _steps(whole: System, motion: Motion, scale: Array, start: Array, end: Array) -> Array:
    """exp(A (end - start)), A at the middle (k, n, n), in units of `scale`."""
    reference, middle = Reference(whole, motion), 0.5 * (start + end)
    A = whole.jacobian(middle, reference.state(middle), reference.torque(middle))
    with np.errstate(over="ignore", invalid="ignore"):
        return exponentials(A * (scale / scale[:, None]) * (end - start)[:, None, None])


def exponentials(A: Array) -> Array:
    """exp(A) of matrices (k, n, n): Taylor's series of A / 2^s, squared s times.

    scipy's expm wakes BLAS threads for each small matrix; on a busy machine that takes seconds.
    """
    size = float(np.abs(A).sum(axis=-1).max(initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(max(size, 1e-300)))) + 2)
    scaled = A / 2.0**halvings
    total = term = np.broadcast_to(np.eye(A.shape[-1]), A.shape)
    for k in range(1, 13):
        term = term @ scaled / k
        total = total + term
    for _ in range(halvings):
        total = total @ total
    return total


def pieces(times: Array, steps: Array) -> tuple[Array, Array]:
    """(edges, factors): the longest pieces of the grid whose products of steps have norm at most
    `BOUND`.

    A factor is the largest norm on the way through the piece, at least 1.
    """
    edges, factors = [0], []
    product, largest = np.eye(steps.shape[-1]), 1.0
    for k, step in enumerate(steps):
        longer = step @ product
        size = float(np.linalg.norm(longer, 2))
        if size > BOUND and edges[-1] < k:
            edges.append(k)
            factors.append(largest)
            longer, largest = step, 1.0
            size = float(np.linalg.norm(step, 2))
        product, largest = longer, max(largest, size)
    return times[[*edges, len(steps)]], np.array([*factors, largest])


def amplification(steps: Array) -> float:
    """log10 of the norm of the product of all steps, or of its largest part from the start,
    whichever is larger."""
    product, exponent, largest = np.eye(steps.shape[-1]), 0.0, 0.0
    for step in steps:
        product = step @ product
        size = float(np.linalg.norm(product, 2))
        exponent += np.log10(size)
        product /= size
        largest = max(largest, exponent)
    return largest
