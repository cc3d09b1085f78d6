"""Positions as points of a manifold: neutral, random, moving along a velocity, and the velocity between two."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array
from freebody.model.facts import fact
from freebody.model.joints import JointKind
from freebody.model.model import Model
from freebody.model.parts import Limits
from freebody.model.required import require_model
from freebody.numerics.calls import common_batch, finite_vector

_FAR = 1e3  # limits beyond this many rad or m are some file's way to say that there are none


def neutral(model: Model) -> Array:
    """q (nq,) with every coordinate 0 and every quaternion the identity."""
    require_model("neutral", model)
    q = np.zeros(model.nq)
    for kind, iq, _ in _manifolds(model):
        if kind.quaternion is not None:
            q[iq[kind.quaternion]] = 1.0
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
    if _all_plain(model, q, v) and _finite(moved := np.add(q, v)):
        return moved
    q0, rate = _batched("integrate", model, q=q, v=v)
    result = np.empty_like(q0)
    for kind, iq, iv in _manifolds(model):
        result[..., iq] = _INTEGRATE.get(kind.name, np.add)(q0[..., iq], rate[..., iv])
    return result


def difference(model: Model, q0: ArrayLike, q1: ArrayLike) -> Array:
    """The velocity (..., nv) that leads from q0 to q1 (..., nq) in unit time: integrate(q0, difference(q0,
    q1)) = q1."""
    require_model("difference", model)
    if _all_plain(model, q0, q1) and _finite(way := np.subtract(q1, q0)):
        return way
    a, b = _batched("difference", model, q0=q0, q1=q1)
    result = np.empty((*a.shape[:-1], model.nv))
    for kind, iq, iv in _manifolds(model):
        result[..., iv] = _DIFFERENCE.get(kind.name, lambda x, y: y - x)(a[..., iq], b[..., iq])
    return result


@fact
def _flat_size(model: Model) -> int:
    """nq where positions are numbers that add, else -1."""
    return model.nq if all(body.kind.quaternion is None for body in model.bodies) else -1


def _all_plain(model: Model, *given: Any) -> bool:
    """Whether these are float64 arrays of one shape, and positions numbers that add: nothing else to look at."""
    first = given[0]
    return all(
        type(x) is np.ndarray and x.dtype == np.float64 and x.shape == first.shape for x in given
    ) and first.shape[-1:] == (_flat_size(model),)


def _finite(result: Array) -> bool:
    return math.isfinite(sum(result.tolist())) if result.ndim == 1 else bool(np.isfinite(result).all())


def _batched(function: str, model: Model, **given: ArrayLike) -> list[Array]:
    """Checked vectors, broadcast to their common batch."""
    named = {name: finite_vector(function, model, name, value) for name, value in given.items()}
    batch = common_batch(function, named)
    return [np.broadcast_to(array, (*batch, array.shape[-1])) for array in named.values()]


def _manifolds(model: Model) -> list[tuple[JointKind, list[int], list[int]]]:
    """(kind, entries of q, entries of v) of each independent joint."""
    return [
        (body.kind, list(at.q), list(at.v))
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None
    ]


# ---------------------------------------------------------------- quaternions w, x, y, z
def quaternion_product(a: Array, b: Array) -> Array:
    """a b, shapes (..., 4)."""
    w, x, y, z = np.moveaxis(a, -1, 0)
    W, X, Y, Z = np.moveaxis(b, -1, 0)
    return np.stack(
        [
            w * W - x * X - y * Y - z * Z,
            w * X + x * W + y * Z - z * Y,
            w * Y - x * Z + y * W + z * X,
            w * Z + x * Y - y * X + z * W,
        ],
        axis=-1,
    )


def conjugate(q: Array) -> Array:
    """Inverse of a unit quaternion."""
    return q * np.array([1.0, -1.0, -1.0, -1.0])


def turned(q: Array, v: Array) -> Array:
    """R(q) v, shapes (..., 4), (..., 3)."""
    w, u = q[..., :1], q[..., 1:]
    t = 2.0 * np.cross(u, v)
    return v + w * t + np.cross(u, t)


def quaternion_of(w: Array) -> Array:
    """Quaternion of a rotation vector (..., 3)."""
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    return np.concatenate([np.cos(angle / 2), 0.5 * np.sinc(angle / (2 * np.pi)) * w], axis=-1)


def rotation_vector(q: Array) -> Array:
    """Rotation vector (..., 3) of a quaternion, of length at most π."""
    q = np.where(q[..., :1] < 0, -q, q)
    size = np.linalg.norm(q[..., 1:], axis=-1, keepdims=True)
    half = np.arctan2(size, q[..., :1])
    factor = np.where(size > 1e-12, 2 * half / np.where(size > 0, size, 1.0), 2.0)
    return factor * q[..., 1:]


def _screw_shift(w: Array, v: Array) -> Array:
    """∫ exp(s ω×) v ds over s from 0 to 1."""
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    small = angle < 1e-4
    a = np.where(small, 1.0, angle)
    first = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2  # (1 - cos) / angle², without the difference
    second = np.where(small, 1 / 6 - angle**2 / 120, (a - np.sin(a)) / a**3)
    return v + first * np.cross(w, v) + second * np.cross(w, np.cross(w, v))


def _unshifted(w: Array, p: Array) -> Array:
    """The v whose `_screw_shift` is p."""
    angle = np.linalg.norm(w, axis=-1, keepdims=True)
    small = angle < 1e-4
    a = np.where(small, 1.0, angle)
    rest = np.where(small, 1 / 12 + angle**2 / 720, (1 - a / 2 / np.tan(a / 2)) / a**2)
    return p - 0.5 * np.cross(w, p) + rest * np.cross(w, np.cross(w, p))


def _turn(q: Array, w: Array) -> Array:
    moved = quaternion_product(q, quaternion_of(w))
    return moved / np.linalg.norm(moved, axis=-1, keepdims=True)


def _float(q: Array, v: Array) -> Array:
    p = q[..., :3] + turned(q[..., 3:], _screw_shift(v[..., 3:], v[..., :3]))
    return np.concatenate([p, _turn(q[..., 3:], v[..., 3:])], axis=-1)


def _between(a: Array, b: Array) -> Array:
    return rotation_vector(quaternion_product(conjugate(a), b))


def _float_between(a: Array, b: Array) -> Array:
    w = _between(a[..., 3:], b[..., 3:])
    shift = turned(conjugate(a[..., 3:]), b[..., :3] - a[..., :3])
    return np.concatenate([_unshifted(w, shift), w], axis=-1)


_INTEGRATE: dict[str, Callable[[Array, Array], Array]] = {"spherical": _turn, "free": _float}
_DIFFERENCE: dict[str, Callable[[Array, Array], Array]] = {"spherical": _between, "free": _float_between}
