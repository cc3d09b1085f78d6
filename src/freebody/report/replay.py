"""The replay: the torques of a motion drive the model back along it.

Open loop, errors grow as the linearised dynamics let them, often a factor e every 0.1 s for an arm
held upright, so a whole motion cannot be followed to the last digit by any integrator. In pieces
that amplify an error by at most 1e4 it can, and a wrong term in torques or dynamics would show in
the first of them.
"""

from __future__ import annotations

from typing import NoReturn

import numpy as np

from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import Ranges, position_columns, ranges
from freebody.motion.simulation.first_order_system import System, decay_rate, suited_method, system
from freebody.report.driven_runs import ASTRAY, MotionReference, land, open_loop
from freebody.report.results import Replay
from freebody.trees.dynamics import mass_matrix
from freebody.trees.position_rates import Index

_MOST_PIECES = 400
_MOST_SAMPLES = 401
"""Samples of the motion within the pieces that are run: each may cost three hundred evaluations."""
_MANY_JUMPS = 30


def replayed(model: Model, motion: Motion) -> Replay:
    """The replay of a motion in pieces and open loop.

    Raises SingularError if the mass matrix is singular, or so nearly along the motion that pieces
    would be too many.
    """
    whole, allowed = system(model), ranges(model)
    method = _method(model, whole, motion)
    times, steps = transitions(whole, motion, scaling(model, allowed))
    edges, factors = pieces(times, steps)
    if len(factors) > _MOST_PIECES:
        _refuse(model, motion, edges)
    misses, run = np.full(len(factors), np.nan), _followed(motion, edges)
    misses[run] = land(whole, motion, edges[run], edges[run + 1], allowed, method)
    if method == "BDF" and np.isinf(misses).any():
        method = "Radau"  # dearer, but gets through where Newton's iteration in BDF does not
        misses[run] = land(whole, motion, edges[run], edges[run + 1], allowed, method)
    drift_time, drift, ended = open_loop(whole, motion, allowed, method)
    growth = amplification(steps)
    return Replay(
        edges,
        factors,
        misses,
        BOUND,
        method,
        drift_time,
        drift,
        growth,
        whole.friction.width if whole.friction.acts else 0.0,
        f"{_landed(edges, factors, misses)} "
        f"{_drifted(model, allowed, drift_time, drift, ended, growth)}",
    )


def _refuse(model: Model, motion: Motion, edges: Array) -> NoReturn:
    """Raise the error that says where the motion cannot be followed."""
    k = int(np.argmin(np.diff(edges)))
    condition = float(np.linalg.cond(mass_matrix(model, motion.at(edges[k])[0])))
    raise SingularError(
        f"Near t = {edges[k]:.3g} s the linearised dynamics amplify errors so fast, with a mass "
        f"matrix of condition {condition:.1g}, that following the torques would take "
        f"{len(edges) - 1} pieces."
    )


def _followed(motion: Motion, edges: Array) -> Index:
    """The indices of the pieces that are run: all, or for a long log as many, evenly spread, as
    hold `_MOST_SAMPLES` samples.

    Between samples the reference is a polynomial; each sample costs an integrator steps.
    """
    pieces = len(edges) - 1
    count = max(1, int(_MOST_SAMPLES * pieces / len(motion.t)))
    return np.unique(np.linspace(0, pieces - 1, min(count, pieces)).round().astype(int))


def _method(model: Model, whole: System, motion: Motion) -> str:
    """The name of the integrator: an implicit one where friction is stiff at one of a few poses of
    the motion, "Radau" if accelerations jump often, else "BDF"; "DOP853" otherwise."""
    samples = motion.q[:: max(1, len(motion.t) // 8)]
    stiffest = max(samples, key=lambda q: decay_rate(model, whole.friction, q))
    if suited_method(whole, stiffest, motion.duration) == "DOP853":
        return "DOP853"
    return "Radau" if len(motion.jumps) > _MANY_JUMPS else "BDF"


def _landed(edges: Array, factors: Array, misses: Array) -> str:
    """A sentence on how the pieces of a replay ended."""
    count, run = len(misses), int((~np.isnan(misses)).sum())
    if np.isinf(misses).any():
        return "The replay in pieces was stopped: it needs too many steps."
    longest, miss = f"{np.diff(edges).max():.3g} s", f"{np.nanmax(misses):.1g} of the joint range"
    grown = f"an error grows at most {factors.max():.3g}-fold."
    if count == 1:
        return (
            f"Driven by its torques for {longest}, in one piece, the model misses the end of "
            f"the motion by {miss}; {grown}"
        )
    some = f"{run} of {count}" if run < count else f"{count}"
    return (
        f"Driven by its torques in {some} pieces of at most {longest}, each restarted on the "
        f"motion, the model ends each piece within {miss}. In a piece {grown}"
    )


def _drifted(
    model: Model, allowed: Ranges, t: Array, drift: Array, ended: str, growth: float
) -> str:
    """A sentence on the open-loop run and the cause of its drift."""
    share = drift / allowed.width
    k, j = np.unravel_index(int(np.argmax(share)), share.shape)
    found = f"drifts by up to {drift[k, j]:.2g} {'rad' if allowed.turns[j] else 'm'}"
    if ended == ASTRAY:
        first = model.velocity_names[int(np.argmax(share[-1]))]
        found = f"departs from the motion after t = {t[-1]:.3g} s, first {first} by its whole range"
    elif ended:
        found += f" until t = {t[-1]:.3g} s, where the run was stopped: {ended}"
    if growth < 1:
        cause = "errors hardly grow along the motion"
    else:
        cause = (
            f"along the motion any error, even of rounding, grows up to 10^{growth:.1f}-fold "
            "(linearised dynamics)"
        )
    return f"Over the whole motion without a restart it {found}; {cause}."


BOUND = 1e4
"""Amplification that a piece may have at most."""

_GRID = 400
_HALVINGS = 14


def scaling(model: Model, allowed: Ranges) -> Array:
    """The scale of each entry of (q, q̇), (nq + nv,): the range of the joint, and the range per
    second; 1 for quaternions."""
    position = np.ones(model.nq)
    iq, iv = position_columns(model)
    position[iq] = allowed.width[iv]
    return np.concatenate([position, allowed.width])


def transitions(whole: System, motion: Motion, scale: Array) -> tuple[Array, Array]:
    """The times (k + 1,) of a grid and the scaled state-transition matrices (k, n, n) of its steps
    along the motion.

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
    """The matrices exp(A (end - start)) with A at the middle of each step (k, n, n), in units of
    `scale`."""
    reference, middle = MotionReference(whole, motion), 0.5 * (start + end)
    A = whole.jacobian(middle, reference.state(middle), reference.torque(middle))
    with np.errstate(over="ignore", invalid="ignore"):
        return exponentials(A * (scale / scale[:, None]) * (end - start)[:, None, None])


def exponentials(A: Array) -> Array:
    """The exponentials of matrices A (k, n, n): the Taylor series of A / 2^s, squared s times.

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
    """(edges, factors) of the longest pieces of the grid whose products of transition matrices have
    a norm of at most `BOUND`.

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
    """The log10 of the norm of the product of all steps, or of the part from the start whose norm
    is largest, whichever is larger."""
    product, exponent, largest = np.eye(steps.shape[-1]), 0.0, 0.0
    for step in steps:
        product = step @ product
        size = float(np.linalg.norm(product, 2))
        exponent += np.log10(size)
        product /= size
        largest = max(largest, exponent)
    return largest
