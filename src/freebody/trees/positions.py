"""Positions as points of a manifold: neutral and random ones, integration along a velocity, the
velocity between two; rotations and quaternions for spherical and free joints."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, is_count, too_large
from freebody.errors import FreebodyError, KindError, MissingValueError, require_kind
from freebody.labels import refuse_other_times
from freebody.model.description import Limits
from freebody.model.families import FamilyError, arrays_in
from freebody.model.joints import Primitive
from freebody.model.kept_facts import first_member
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.placement import about, rotation_matrix
from freebody.model.usable_limits import usable_limits
from freebody.spatial import of_dimension
from freebody.trees.public_calls import careful, common_batch, evaluate, finite_vector

_FAR = 1e3  # limits beyond this many rad or m are some file's way to say that there are none


def neutral(model: Model) -> Array:
    """q (nq,) with every coordinate 0 and every quaternion the identity."""
    try:  # less than a microsecond: what was found before is tried at once
        return model.facts[_NEUTRAL].copy()
    except (KeyError, AttributeError, TypeError):
        require_model("neutral", model)
        return model.facts.setdefault(_NEUTRAL, _neutral(model)).copy()


_NEUTRAL = "neutral"


def _neutral(model: Model) -> Array:
    q = np.zeros(model.nq)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None and body.kind.quaternion is not None:
            q[at.q[body.kind.quaternion]] = 1.0
    q.flags.writeable = False
    return q


def home_guess(model: Model) -> Array:
    """Starting guess q (nq,) for the assembly of a closed chain: the neutral position, with the
    values of the model's `home` where given."""
    q = neutral(model)
    for name, value in model.home:
        q[model.position_names.index(name)] = value
    return q


def random_state(
    model: Model, seed: int | None = None, batch: int | tuple[int, ...] = ()
) -> tuple[Array, Array, Array]:
    """(q, qd, qdd) of shapes (*batch, nq), (*batch, nv), (*batch, nv), reproducible with a seed.

    q lies within the limits, those of followers included, or within ±π (rad) and ±1 (m) where there
    are none (a range of no width is none); quaternions are uniform; rates and accelerations are
    normal with deviation 1.
    """
    require_model("random_state", model)
    if arrays_in(tuple(body.joint.limits for body in model.bodies)):
        raise FamilyError("random_state", model.name, model.family)
    if seed is not None and not is_count(seed, 0):
        raise KindError("random_state", "seed", seed, "a whole number from 0 up, or None")
    try:
        return _states(model, seed, batch, _usable(model))
    except (MemoryError, ValueError) as problem:
        raise too_large("random_state", {"batch": batch}, problem) from None


def _usable(model: Model) -> list[Limits]:
    """Position limits of each body's joint; those of joints that follow others are applied to the
    leading joint."""
    allowed = usable_limits(first_member(model))
    return [
        replace(body.joint.limits.meant, lower=allowed.lower[at.v[0]], upper=allowed.upper[at.v[0]])
        if body.joint.mimic is None and body.kind.nv == 1
        else body.joint.limits.meant
        for body, at in zip(model.bodies, model.coordinates, strict=True)
    ]


def generic_state(
    model: Model, seed: int | None = None, batch: int | tuple[int, ...] = ()
) -> tuple[Array, Array, Array]:
    """A random state without regard to limits, for properties that depend on the mechanism alone,
    such as ranks.

    A range, be it narrow, may hold only states that are special.
    """
    return _states(model, seed, batch, [Limits()] * len(model.bodies))


def _states(
    model: Model, seed: int | None, batch: int | tuple[int, ...], limits: Sequence[Limits]
) -> tuple[Array, Array, Array]:
    rng = np.random.default_rng(seed)
    shape = (batch,) if isinstance(batch, int | np.integer) else tuple(batch)
    q = np.empty((*shape, model.nq))
    for body, at, allowed in zip(model.bodies, model.coordinates, limits, strict=True):
        if body.joint.mimic is not None:
            continue
        start = body.kind.quaternion
        if start is not None:
            quaternion = rng.normal(size=(*shape, 4))
            q[..., at.q[start:]] = quaternion / np.linalg.norm(quaternion, axis=-1, keepdims=True)
            q[..., at.q[:start]] = rng.uniform(-1, 1, size=(*shape, start))
            continue
        reach = np.where(body.kind.angular, np.pi, 1.0)
        if body.kind.nv > 1:
            q[..., at.q] = rng.uniform(-1, 1, size=(*shape, body.kind.nv)) * reach
        else:
            (reach,) = reach.tolist()
            low, high = allowed.lower, allowed.upper
            if low < -_FAR:
                low = max(low, -reach if high > _FAR else min(-reach, high - 2 * reach))
            if high > _FAR:
                high = min(high, max(reach, low + 2 * reach))
            q[..., at.q[0]] = rng.uniform(low, high, size=shape)
    return q, rng.normal(size=(*shape, model.nv)), rng.normal(size=(*shape, model.nv))


def integrate(model: Model, q: ArrayLike, v: ArrayLike) -> Array:
    """The position (..., nq) reached from q (..., nq) by the constant velocity v (..., nv) in unit
    time.

    Free joints move along their screw (exponential of SE(3)), spherical ones turn by ω; the others
    add.
    """
    return evaluate("integrate", model, (q, v), None, None, _moved)


def difference(model: Model, q0: ArrayLike, q1: ArrayLike) -> Array:
    """The velocity (..., nv) that leads from q0 to q1 (..., nq) in unit time: integrate(q0,
    difference(q0, q1)) = q1."""
    return evaluate("difference", model, (q0, q1), None, None, _between)


def _moved(function: str, model: Model, inputs: tuple[ArrayLike, ...], *_: None) -> Array:
    require_model(function, model)
    if _has_numbers(model):
        return careful(function, model, inputs)
    given = _batched(function, model, q=inputs[0], v=inputs[1])
    return _joint_by_joint(model, model.nq, lambda joint: joint.moved, given)


def _between(function: str, model: Model, inputs: tuple[ArrayLike, ...], *_: None) -> Array:
    require_model(function, model)
    if _has_numbers(model):
        return careful(function, model, inputs)
    given = _batched(function, model, q0=inputs[0], q1=inputs[1])
    return _joint_by_joint(model, model.nv, lambda joint: joint.between, given)


def _has_numbers(model: Model) -> bool:
    try:
        return model.numbers is not None
    except MissingValueError:
        return False


def _joint_by_joint(
    model: Model, size: int, way: Callable[[Primitive], Callable[..., Any]], given: list[Array]
) -> Array:
    """Apply each joint type's own function to that joint's entries of arrays, for models with
    unknown numbers; way: selects the function of a joint primitive."""
    result, space = np.empty((*given[0].shape[:-1], size)), of_dimension(model.dim)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.mimic is None:
            # kinds of several primitives are those whose positions add, as those of any one
            # primitive of theirs do
            own = (0.0,) * len(body.joint.numbers)  # how positions add does not depend on them
            joint = body.kind.primitives(space, space.zero, own)[0][0]
            entries = (at.q if x.shape[-1] == model.nq else at.v for x in given)
            columns = [tuple(x[..., k] for k in ks) for x, ks in zip(given, entries, strict=True)]
            result[..., at.q if size == model.nq else at.v] = np.stack(
                way(joint)(space, *columns), axis=-1
            )
    return result


def _batched(function: str, model: Model, **given: ArrayLike) -> list[Array]:
    """Vector arguments checked and broadcast to their common batch."""
    refuse_other_times(function, given)
    named = {name: finite_vector(function, model, name, value) for name, value in given.items()}
    batch = common_batch(function, named)
    return [np.broadcast_to(array, (*batch, array.shape[-1])) for array in named.values()]


def rotation(axes: str, angles: Sequence[float] | ArrayLike) -> Array:
    """R_WB (3, 3) of turns about the body's own axes: rotation("ZXZ", [a, b, c]) is Rz(a) Rx(b)
    Rz(c).

    axes: letters X, Y, Z, one per angle (rad). It takes components in the turned frame to those in
    the first (6.8).
    """
    require_kind("rotation", "axes", axes, str, 'letters X, Y, Z, such as "ZXZ"')
    given = as_floats("rotation", "angles", angles)
    if not axes or set(axes.upper()) - set("XYZ") or given.shape != (len(axes),):
        raise FreebodyError(
            f"rotation: axes {axes!r} and {given.size} angles; give one angle for each of the "
            f"letters X, Y, Z."
        )
    R = np.eye(3)
    for axis, angle in zip(axes.lower(), given, strict=True):
        R = R @ np.array(about(axis, np.sin(angle), np.cos(angle)))
    return R


def quat_wxyz(R: ArrayLike) -> Array:
    """The unit quaternion w, x, y, z (w >= 0) of a rotation matrix (3, 3), as spherical and free
    joints take it."""
    from scipy.spatial.transform import Rotation

    return Rotation.from_matrix(
        rotation_matrix(as_floats("quat_wxyz", "R", R), "quat_wxyz")
    ).as_quat(canonical=True, scalar_first=True)
