"""The loop equations of a model as arrays, scaled so that lengths and angles compare, and what is said of gaps."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
from numpy.typing import NDArray

from freebody.algorithms.kinematics import frame_pose, joint_poses, world_poses
from freebody.arrays import Array, at_sample
from freebody.errors import FreebodyError, LoopError
from freebody.model.model import Model
from freebody.numerics.formulas import Option
from freebody.numerics.kernels import fetch
from freebody.numerics.states import difference
from freebody.spatial import dot, times

CLOSED = 1e-6
"""Gap, relative to the mechanism's length, from which a loop counts as open."""

_NOTHING = 1e-13  # an equation that holds wherever the mechanism goes


def require_loops(model: Model, function: str) -> None:
    """Refuse a model without loops."""
    if not model.loops:
        raise FreebodyError(f"{function}: {model.name!r} has no loops; add one with model.with_loop(...).")


def residual(model: Model, q: Array) -> Array:
    """Φ(q) (..., m)."""
    return fetch(model, ("constraint",), Option())(q)


def rate_of_loops(model: Model, q: Array, qd: Array) -> Array:
    """Φ_q q̇ (..., m)."""
    return fetch(model, ("constraint_rate",), Option())(q, qd)


def jacobian_of_loops(model: Model, q: Array) -> Array:
    """Φ_q (..., m, nv)."""
    return fetch(model, ("constraint_jacobian",), Option())(q)


def row_names(model: Model) -> tuple[str, ...]:
    """A name for each loop equation: the loop's, and the component of its reaction."""
    space = model.tree.space
    return tuple(f"{loop.name}.{part}" for loop in model.tree.loops for part in loop.closure.row_names(space))


def loop_of_row(model: Model) -> tuple[int, ...]:
    """For each equation the index of its loop."""
    tree = model.tree
    return tuple(i for i, loop in enumerate(tree.loops) for _ in range(loop.closure.size(tree.space)))


@dataclass(frozen=True)
class Scales:
    """What makes lengths and angles compare: equations and rates become angles when multiplied by `rows`, divided by
    `rates`."""

    length: float
    """The mechanism's length (m): the farthest that a joint or frame is placed from the one before."""
    rows: Array
    """(m,): 1 / length for equations in metres, 1 for sines of angles."""
    rates: Array
    """(nv,): the length for rates in m/s, 1 for angular ones."""
    turns: NDArray[np.bool_]
    """(nv,): whether a whole turn of the coordinate changes nothing."""


def scales(model: Model) -> Scales:
    """The scales of a model, found once."""
    known = model.compiled.get("scales")
    if known is None:
        known = model.compiled["scales"] = _scales(model)
    return known


def _scales(model: Model) -> Scales:
    tree = model.tree
    offsets = [body.p for body in tree.bodies] + [p for _, _, p in tree.frames.values()]
    offsets += [(loop.distance,) for loop in tree.loops]
    reach = max((float(np.linalg.norm(p)) for p in offsets), default=0.0) or 1.0
    rows: list[float] = []
    for loop in tree.loops:
        turns = len(loop.closure.turns)
        rows += [1.0 / reach] * (loop.closure.size(tree.space) - turns) + [1.0] * turns
    rates, turns = np.ones(model.nv), np.ones(model.nv, dtype=bool)
    for body in tree.bodies:
        ratio = body.coordinates.ratio
        for k, (_, linear) in zip(body.coordinates.v, body.columns, strict=True):
            if any(linear):
                rates[k] = reach
            turns[k] &= not any(linear) and ratio == round(ratio)
    return Scales(reach, np.array(rows), rates, turns)


def length(model: Model) -> float:
    """See `Scales`."""
    return scales(model).length


def row_scale(model: Model) -> Array:
    """See `Scales`."""
    return scales(model).rows


def rate_scale(model: Model) -> Array:
    """See `Scales`."""
    return scales(model).rates


def shortest_way(model: Model, a: Array, b: Array) -> Array:
    """The way from positions a to b (..., nq) as angles (..., nv), whole turns left out."""
    way = difference(model, a, b) / rate_scale(model)
    return np.where(scales(model).turns, (way + np.pi) % (2.0 * np.pi) - np.pi, way)


def scaled_jacobian(model: Model, q: Array) -> Array:
    """Φ_q (..., m, nv) over angular rates, in angles; rows that hold nothing but rounding are zero."""
    A = row_scale(model)[:, None] * jacobian_of_loops(model, q) * rate_scale(model)
    A[np.abs(A).max(axis=-1, initial=0.0) < _NOTHING] = 0.0
    return A


def null_space(A: Array, tolerance: float) -> tuple[Array, Array]:
    """(orthonormal basis of what A (m, n) maps to zero (n, k), of what Aᵀ does (m, l)); singular values below tolerance
    times the largest are zero."""
    if A.shape[0] == 0:
        return np.eye(A.shape[1]), np.zeros((0, 0))
    U, s, Vt = np.linalg.svd(A)
    rank = int((s > tolerance * max(s.max(initial=0.0), 1e-300)).sum())
    return Vt[rank:].T, U[:, rank:]


def backward(model: Model, q: Array) -> NDArray[np.bool_]:
    """(..., loops): whether a loop is closed the wrong way round: turned by a half, or where three axes are held, by a
    third, from which its equations cannot tell it."""
    tree = model.tree
    space = tree.space
    if not any(loop.closure.turns for loop in tree.loops):
        return np.zeros((*q.shape[:-1], len(tree.loops)), dtype=bool)
    world = world_poses(tree, joint_poses(tree, tuple(np.moveaxis(q, -1, 0))))
    found = np.zeros((*q.shape[:-1], len(tree.loops)), dtype=bool)
    for i, loop in enumerate(tree.loops):
        (A, _), (B, _) = (frame_pose(tree, world, frame) for frame in loop.frames)
        for n, u in loop.closure.turns:
            expected = space.turn(A, space.moment(u, n))
            found[..., i] |= np.asarray(dot(expected, space.moment(times(B, u), times(A, n)))) < 0.5
    return found


def gaps(model: Model, phi: Array) -> Array:
    """How far each loop is open (..., loops), from Φ: metres and sines together, the latter times the length."""
    size = phi * row_scale(model) * length(model)
    of_row = np.array(loop_of_row(model))
    parts = [np.linalg.norm(size[..., of_row == i], axis=-1) for i in range(len(model.loops))]
    return np.stack(parts, axis=-1)


def require_closed(function: str, model: Model, q: Array, qd: Array | None = None) -> None:
    """Refuse positions whose loops are open, and rates that would open them."""
    reach = length(model)
    gap = gaps(model, residual(model, q))
    for at, name, sample in _marked(model, gap > CLOSED * reach):
        raise LoopError(
            f"{function}: loop {name!r} of {model.name!r} is open by {gap[at]:.3g} m{sample}; "
            "close it with fb.assemble(model, q)."
        )
    for _, name, sample in _marked(model, backward(model, q)):
        raise LoopError(
            f"{function}: loop {name!r} of {model.name!r} is closed the wrong way round{sample}: its frames face "
            "opposite ways; start fb.assemble from another guess, or turn one frame."
        )
    if qd is not None:
        rate = gaps(model, rate_of_loops(model, q, qd))
        speed = reach * (1.0 + np.abs(qd / rate_scale(model)).max(axis=-1, initial=0.0))
        for at, name, sample in _marked(model, rate > CLOSED * speed[..., None]):
            raise LoopError(
                f"{function}: loop {name!r} of {model.name!r} would open at {rate[at]:.3g} m/s{sample}; "
                "make the rates consistent with fb.loop_velocity(model, q, qd)."
            )


def _marked(model: Model, bad: NDArray[np.bool_]) -> Iterator[tuple[tuple[int, ...], str, str]]:
    """(index, loop, text of the sample) of all (..., loops) that are marked."""
    for index in np.argwhere(bad):
        at = tuple(map(int, index))
        yield at, model.loops[at[-1]].name, at_sample(at[:-1])


def refuse_inconsistent(function: str, model: Model, left: Array, what: str) -> NoReturn:
    """Raise for equations (m,) that cannot hold together, naming the loop that misses most."""
    worst = int(np.argmax(np.abs(left * row_scale(model))))
    name = model.loops[loop_of_row(model)[worst]].name
    raise LoopError(f"{function}: loop {name!r} of {model.name!r} {what}.")
