"""Rates of positions: q̇ = N(q) v for joints whose q is not simply the integral of v.

Quaternions p = w, x, y, z with the angular velocity ω in body axes: ṗ = ½ p (0, ω) and p̈ = ½ p (0,
ω̇) - ¼ |ω|² p; a free joint's position ẋ = R v, ẍ = R (v̇ + ω × v).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.lazy import kept
from freebody.model.model import Model

Index = NDArray[np.intp]
"""Array of integers that index coordinates."""


@dataclass(frozen=True)
class CoordinateLayout:
    """The places of a model's coordinates: plain ones (q̇ = v), quaternions, and positions of free
    joints.

    plain: (iq, iv) index arrays. turns: slices (q of the quaternion, v of ω). shifts: slices (q of
    x, q of the quaternion, v of the linear velocity, v of ω) of free joints.
    """

    nq: int
    nv: int
    plain: tuple[Index, Index]
    turns: tuple[tuple[slice, slice], ...]
    shifts: tuple[tuple[slice, slice, slice, slice], ...]

    @property
    def flat(self) -> bool:
        """Whether q̇ = v for all coordinates."""
        return not self.turns


def layout(model: Model) -> CoordinateLayout:
    """The layout of a model's coordinates."""
    return kept(model, "_coordinate_layout", _layout, model)


def _layout(model: Model) -> CoordinateLayout:
    iq: list[int] = []
    iv: list[int] = []
    turns, shifts = [], []
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is not None:
            continue
        if body.kind.nq == body.kind.nv:
            iq += at.q
            iv += at.v
            continue
        turn = slice(at.q[-4], at.q[-1] + 1), slice(at.v[-3], at.v[-1] + 1)
        turns.append(turn)
        if body.kind.nq == 7:
            shifts.append((slice(at.q[0], at.q[3]), turn[0], slice(at.v[0], at.v[3]), turn[1]))
    plain = np.array(iq, dtype=int), np.array(iv, dtype=int)
    for index in plain:
        index.flags.writeable = False
    return CoordinateLayout(model.nq, model.nv, plain, tuple(turns), tuple(shifts))


def position_rate(where: CoordinateLayout, q: Array, v: Array) -> Array:
    """The rate q̇ (..., nq) of the positions from rates v (..., nv)."""
    if where.flat:
        return v
    rate = np.empty_like(q)
    rate[..., where.plain[0]] = v[..., where.plain[1]]
    for iq, iv in where.turns:
        rate[..., iq] = 0.5 * _back(_body_map(q[..., iq]), v[..., iv])
    for ix, iq, iv, _ in where.shifts:
        rate[..., ix] = _turned(q[..., iq], v[..., iv])
    return rate


def position_acceleration(where: CoordinateLayout, q: Array, v: Array, a: Array) -> Array:
    """The second rate q̈ (..., nq) of the positions from rates v and their derivatives a (...,
    nv)."""
    if where.flat:
        return a
    second = np.empty_like(q)
    second[..., where.plain[0]] = a[..., where.plain[1]]
    for iq, iv in where.turns:
        p, w = q[..., iq], v[..., iv]
        second[..., iq] = 0.5 * _back(_body_map(p), a[..., iv]) - 0.25 * _dot(w, w) * p
    for ix, iq, iv, iw in where.shifts:
        second[..., ix] = _turned(q[..., iq], a[..., iv] + _cross(v[..., iw], v[..., iv]))
    return second


def state_of(
    where: CoordinateLayout, x: Array, xd: Array, xdd: Array
) -> tuple[Array, Array, Array]:
    """(q, v, v̇) of position coordinates x with their time derivatives; quaternions of any length
    are normalised."""
    if where.flat:
        return x, xd, xdd
    q = x.copy()
    v = np.empty((*x.shape[:-1], where.nv))
    a = np.empty_like(v)
    v[..., where.plain[1]] = xd[..., where.plain[0]]
    a[..., where.plain[1]] = xdd[..., where.plain[0]]
    for iq, iv in where.turns:
        p, pd, pdd = x[..., iq], xd[..., iq], xdd[..., iq]
        E, size = _body_map(p), _dot(p, p)
        w = 2.0 * _times(E, pd) / size
        q[..., iq] = p / np.sqrt(size)
        v[..., iv] = w
        a[..., iv] = 2.0 * (_times(E, pdd) - _dot(p, pd) * w) / size
    for ix, iq, iv, iw in where.shifts:
        p = q[..., iq]
        E, G = _body_map(p), _world_map(p)
        v[..., iv] = _times(E, _back(G, xd[..., ix]))
        a[..., iv] = _times(E, _back(G, xdd[..., ix])) - _cross(v[..., iw], v[..., iv])
    return q, v, a


def normalised(where: CoordinateLayout, q: Array) -> Array:
    """q with its quaternions of unit length."""
    if where.flat:
        return q
    q = q.copy()
    for iq, _ in where.turns:
        q[..., iq] /= np.linalg.norm(q[..., iq], axis=-1, keepdims=True)
    return q


def continuous(where: CoordinateLayout, q: Array) -> Array:
    """Samples q (T, nq) with the signs of quaternions chosen so that neighbours are near."""
    if where.flat:
        return q
    q = q.copy()
    for iq, _ in where.turns:
        together = np.sum(q[1:, iq] * q[:-1, iq], axis=-1) < 0
        flips = np.concatenate([[False], np.cumsum(together) % 2 == 1])
        q[flips, iq] *= -1.0
    return q


# ---------------------------------------------------------------- quaternion maps With p a unit
# quaternion and E, G (3, 4): ω = 2 E ṗ in body axes, ω = 2 G ṗ in world axes, ṗ = ½ Eᵀ ω, R = G Eᵀ.
_ENTRY = np.array([[1, 0, 3, 2], [2, 3, 0, 1], [3, 2, 1, 0]])
_BODY = np.array([[-1.0, 1, 1, -1], [-1, -1, 1, 1], [-1, 1, -1, 1]])
_WORLD = np.array([[-1.0, 1, -1, 1], [-1, 1, 1, -1], [-1, -1, 1, 1]])


def _body_map(p: Array) -> Array:
    """Matrix E (..., 3, 4) of quaternions p (..., 4), which gives the angular velocity in body axes
    from ṗ."""
    return p[..., _ENTRY] * _BODY


def _world_map(p: Array) -> Array:
    """Matrix G (..., 3, 4) of quaternions p (..., 4), which gives the angular velocity in world
    axes from ṗ."""
    return p[..., _ENTRY] * _WORLD


def _times(A: Array, x: Array) -> Array:
    """Products A x (..., rows) of matrices A and vectors x."""
    return (A @ x[..., None])[..., 0]


def _back(A: Array, x: Array) -> Array:
    """Products Aᵀ x (..., columns) of transposed matrices A and vectors x."""
    return (x[..., None, :] @ A)[..., 0, :]


def _turned(p: Array, v: Array) -> Array:
    """Vectors v rotated by the quaternions p, R(p) v; p may have any length."""
    return _times(_world_map(p), _back(_body_map(p), v)) / _dot(p, p)


def _dot(a: Array, b: Array) -> Array:
    """Dot product a · b (..., 1)."""
    return (a * b).sum(axis=-1, keepdims=True)


_NEXT, _AFTER = [1, 2, 0], [2, 0, 1]


def _cross(a: Array, b: Array) -> Array:
    """Cross product a × b; np.cross takes ten times as long for one vector."""
    return a[..., _NEXT] * b[..., _AFTER] - a[..., _AFTER] * b[..., _NEXT]
