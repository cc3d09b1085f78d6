"""Positions as points of a manifold: neutral, random, moving along a velocity, and the velocity between two."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.labels import refuse_other_times
from freebody.model.facts import fact
from freebody.model.joints import Primitive
from freebody.model.members import FamilyError, arrays_in
from freebody.model.model import Model
from freebody.model.parts import Limits
from freebody.model.required import require_model
from freebody.spatial import of_dimension
from freebody.trees.calls import common_batch, evaluate, finite_vector

_FAR = 1e3  # limits beyond this many rad or m are some file's way to say that there are none


def neutral(model: Model) -> Array:
    """q (nq,) with every coordinate 0 and every quaternion the identity."""
    require_model("neutral", model)
    q = np.zeros(model.nq)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None and body.kind.quaternion is not None:
            q[at.q[body.kind.quaternion]] = 1.0
    return q


def home_guess(model: Model) -> Array:
    """q (nq,) from which a closed chain is assembled: neutral, but for what the model's `home` says."""
    q = neutral(model)
    for name, value in model.home:
        q[model.position_names.index(name)] = value
    return q


def random_state(
    model: Model, seed: int | None = None, batch: int | tuple[int, ...] = ()
) -> tuple[Array, Array, Array]:
    """(q, qd, qdd) of shapes (*batch, nq), (*batch, nv), (*batch, nv), reproducible with a seed.

    q lies within the limits, or within ±π (rad) and ±1 (m) where there are none (a range of no width is none);
    quaternions are uniform; rates and accelerations are normal with deviation 1.
    """
    require_model("random_state", model)
    if arrays_in(tuple(body.joint.limits for body in model.bodies)):
        raise FamilyError("random_state", model.name, model.family)
    return _states(model, seed, batch, [body.joint.limits.meant for body in model.bodies])


def generic_state(
    model: Model, seed: int | None = None, batch: int | tuple[int, ...] = ()
) -> tuple[Array, Array, Array]:
    """A `random_state` regardless of limits, for what depends on the mechanism alone, such as ranks.

    A range, be it narrow, may hold only states that are special.
    """
    return _states(model, seed, batch, [Limits()] * len(model.bodies))


def _states(
    model: Model, seed: int | None, batch: int | tuple[int, ...], limits: Sequence[Limits]
) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    shape = (batch,) if isinstance(batch, int) else tuple(batch)
    q = np.empty((*shape, model.nq))
    for body, at, allowed in zip(model.bodies, model.coordinates, limits, strict=True):
        if body.joint.mimic is not None:
            continue
        start = body.kind.quaternion
        if start is not None:
            quaternion = rng.normal(size=(*shape, 4))
            q[..., at.q[start:]] = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
            q[..., at.q[:start]] = rng.uniform(-1, 1, size=(*shape, start))
        elif body.kind.name == "planar":
            q[..., at.q] = rng.uniform(-1, 1, size=(*shape, 3)) * [1, 1, np.pi]
        else:
            reach = 1.0 if body.kind.name == "prismatic" else np.pi
            low, high = allowed.lower, allowed.upper
            if low < -_FAR:
                low = max(low, -reach if high > _FAR else min(-reach, high - 2 * reach))
            if high > _FAR:
                high = min(high, max(reach, low + 2 * reach))
            q[..., at.q[0]] = rng.uniform(low, high, size=shape)
    return q, rng.normal(size=(*shape, model.nv)), rng.normal(size=(*shape, model.nv))


def integrate(model: Model, q: ArrayLike, v: ArrayLike) -> Array:
    """The position (..., nq) reached from q (..., nq) by the constant velocity v (..., nv) in unit time.

    Free joints move along their screw (exponential of SE(3)), spherical ones turn by ω; the others add.
    """
    require_model("integrate", model)
    way = _way(model)
    if way == "kernel":
        return evaluate("integrate", model, (q, v))
    if way == "add" and _all_plain(model, q, v) and _finite(moved := np.add(q, v)):
        return moved
    q0, rate = _batched("integrate", model, q=q, v=v)
    return _joint_by_joint(model, model.nq, lambda joint: joint.moved, (q0, rate))


def difference(model: Model, q0: ArrayLike, q1: ArrayLike) -> Array:
    """The velocity (..., nv) that leads from q0 to q1 (..., nq) in unit time: integrate(q0, difference(q0,
    q1)) = q1."""
    require_model("difference", model)
    way = _way(model)
    if way == "kernel":
        return evaluate("difference", model, (q0, q1))
    if way == "add" and _all_plain(model, q0, q1) and _finite(rates := np.subtract(q1, q0)):
        return rates
    a, b = _batched("difference", model, q0=q0, q1=q1)
    return _joint_by_joint(model, model.nv, lambda joint: joint.between, (a, b))


@fact
def _way(model: Model) -> str:
    """Positions that "add" need no kernel; others have one, or go by "joints" where values are missing to trace it."""
    if all(body.kind.quaternion is None for body in model.bodies):
        return "add"
    return "joints" if model.missing else "kernel"


def _joint_by_joint(
    model: Model, size: int, way: Callable[[Primitive], Callable[..., Any]], given: tuple[Array, Array]
) -> Array:
    """What each joint makes of its entries, over arrays: for models without numbers, and positions that add."""
    result, space = np.empty((*given[0].shape[:-1], size)), of_dimension(model.dim)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None:
            # kinds of several primitives are those whose positions add, as those of any one primitive of theirs do
            joint = body.kind.primitives(space, space.zero)[0][0]
            entries = (at.q if x.shape[-1] == model.nq else at.v for x in given)
            columns = [tuple(x[..., k] for k in ks) for x, ks in zip(given, entries, strict=True)]
            result[..., at.q if size == model.nq else at.v] = np.stack(way(joint)(space, *columns), axis=-1)
    return result


def _all_plain(model: Model, *given: Any) -> bool:
    """Whether these are float64 arrays of one shape, that of positions: nothing else to look at."""
    first = given[0]
    return all(
        type(x) is np.ndarray and x.dtype == np.float64 and x.shape == first.shape for x in given
    ) and first.shape[-1:] == (model.nq,)


def _finite(result: Array) -> bool:
    return math.isfinite(sum(result.tolist())) if result.ndim == 1 else bool(np.isfinite(result).all())


def _batched(function: str, model: Model, **given: ArrayLike) -> list[Array]:
    """Checked vectors, broadcast to their common batch."""
    refuse_other_times(function, given)
    named = {name: finite_vector(function, model, name, value) for name, value in given.items()}
    batch = common_batch(function, named)
    return [np.broadcast_to(array, (*batch, array.shape[-1])) for array in named.values()]
