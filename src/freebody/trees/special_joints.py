"""Joints that move no inertia, and joints without a drive: errors for functions that cannot handle
them.

A joint that moves no inertia makes the mass matrix singular; it is found once a model. Most robots
are seen to be sound by what their bodies weigh, each alone; that takes microseconds, so that a new
payload does too. Only of others is the mass matrix looked at.
"""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np

from freebody.algorithms.crba import crba, supports
from freebody.arrays import Array, at_sample
from freebody.errors import PassiveJointError, SingularError, listed
from freebody.model.drives.acting import inertia_of, of_names
from freebody.model.families import of_member
from freebody.model.geometry import fact
from freebody.model.model import Model
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Tree, lower
from freebody.trees.public_calls import JointVector, finite_vector
from freebody.trees.states import generic_state

_NOTHING = 1e-13  # a pivot this small, relative to what it was subtracted from, is rounding
_SAMPLES = 4  # configurations that are looked at
_CLEAR = 1e-11  # a pivot this large, relative to the largest entry that M can have, is no rounding
_TRAVEL = 6.0
"""Metres, more than joints that translate are moved in the configurations that are looked at."""
_BLOCK = 1024  # members of a family that are looked at together


def refuse_passive(function: str, model: Model, tau: JointVector) -> None:
    """Raise PassiveJointError where a torque tau (..., nv) acts at a passive joint."""
    passive = model.passive
    if not passive:
        return
    if type(tau) is np.ndarray and tau.shape == (model.nv,):  # plain Python is quicker there
        values = tau.tolist()
        if not any(values[k] for k in passive):
            return
    given = finite_vector(function, model, "tau", tau)[..., model.passive]
    bad = np.argwhere(given != 0.0)
    if len(bad):
        *sample, k = map(int, bad[0])
        value, name = float(given[tuple(bad[0])]), model.velocity_names[model.passive[k]]
        raise PassiveJointError(
            f"{function}: the torque of {name!r} is {value:g}{at_sample(sample)}, but the joint of "
            f"{model.name!r} is passive: nothing drives it. Give 0 there, or name it among "
            f"model.replace(actuated=[...])."
        )


def all_driven(model: Model) -> Model:
    """The model with a drive in every joint; the model itself if no joint is passive."""
    if not model.passive:
        return model
    return model.replace(actuated=[b.joint.name for b in model.bodies if b.joint.mimic is None])


def refuse_massless(model: Model, function: str) -> None:
    """Raise SingularError if some joint moves no inertia at one of a few random configurations."""
    known, member = _found(model)
    if known:
        joints = listed(map(repr, known))
        several = len(known) > 1
        raise SingularError(
            f"{function}: the mass matrix of {model.name!r}{of_member(member)} is singular: "
            f"joint{'s' if several else ''} {joints} move{'' if several else 's'} no inertia. "
            f"Give a mass and inertia to what {'each' if several else 'it'} carries, or a rotor "
            f"inertia to the joint, or fix it."
        )


def massless(model: Model) -> tuple[str, ...]:
    """Names of the coordinates that move no inertia, with the loops of a closed chain cut; for a
    family, those of the first member that has any."""
    return _found(model)[0]


@fact
def _found(model: Model) -> tuple[tuple[str, ...], tuple[int, ...]]:
    """Names of the coordinates that move no inertia, and the family index of the member that has
    them."""
    if _all_sound(model):
        return (), ()
    if not model.family:
        return _idle(model, ())[0], ()
    count = math.prod(model.family)
    for first in range(0, count, _BLOCK):
        some = np.unravel_index(np.arange(first, min(first + _BLOCK, count)), model.family)
        names, k = _idle(model[tuple(index[:, None] for index in some)], (len(some[0]),))
        if names:
            return names, tuple(int(index[k]) for index in some)
    return (), ()


def _all_sound(model: Model) -> bool:
    """Whether each pivot of the mass matrix M is certainly far above rounding, judged by the
    inertia of each body alone; False means that this is unknown.

    A pivot is twice the least kinetic energy at unit rate of its joint, while all that carries the
    joint rests; the energy of the joint's own body is a part of it, and that of the others is not
    negative.
    """
    structure, numbers = model.structure, model.numbers  # refused where some are missing
    if numbers.ndim > 1:
        rows = numbers.reshape(-1, numbers.shape[-1])[:, : structure.gravity]
        if (rows != rows[0]).any():
            return False
        numbers = rows[0]
    if structure.followers:
        return False
    entries = numbers.tolist()
    least, far, mass, inertia, rotor = math.inf, 0.0, 0.0, 0.0, 0.0
    for row in structure.rows:
        own = entries[row.inertia]
        if entries[row.joint]:  # how far the joint takes its body is theirs to say
            return False
        eigenvalue, about = _least(tuple(own))
        least, mass, inertia = min(least, eigenvalue), mass + own[0], inertia + about
        far += math.hypot(*entries[row.position]) + (0.0 if row.turns else _TRAVEL)
        reflected = inertia_of(of_names(row.laws, entries[row.drive]))
        if reflected < 0.0:  # a rotor that takes inertia away
            return False
        rotor += reflected
    bound = 2.0 * (mass * (1.0 + far * far) + inertia) + rotor
    return least > _CLEAR * bound


@lru_cache(maxsize=1024)
def _least(inertia: tuple[float, ...]) -> tuple[float, float]:
    """(a lower bound of the smallest eigenvalue of a body's spatial inertia, the trace of its
    inertia about the origin).

    With the centre of mass c and T = (1, -c×; 0, 1) the inertia is Tᵀ diag(m 1, I_c) T, so that its
    eigenvalues are at least min(m, those of I_c) / (1 + |c|)². Of three positive eigenvalues the
    smallest is at least det / (trace / 2)².
    """
    m, *rest = inertia
    dim = 2 if len(rest) == 3 else 3
    about = rest[2] if dim == 2 else rest[3] + rest[6] + rest[8]
    if m <= 0.0:
        return -math.inf, about
    c = [h / m for h in rest[:dim]]
    off = sum([x * x for x in c])
    if dim == 2:
        least = about - m * off
    else:
        x, y, z = c
        xx, xy, xz, yy, yz, zz = rest[3:]
        a, b, d = xx - m * (off - x * x), yy - m * (off - y * y), zz - m * (off - z * z)
        ab, ad, bd = xy + m * x * y, xz + m * x * z, yz + m * y * z
        minor = a * b - ab * ab
        determinant = minor * d - a * bd * bd - b * ad * ad + 2.0 * ab * ad * bd
        half = 0.5 * (a + b + d)
        least = determinant / (half * half) if min(a, minor, determinant) > 0.0 else 0.0
    return min(m, least) / (1.0 + math.sqrt(off)) ** 2 if least > 0.0 else -math.inf, about


def _idle(model: Model, members: tuple[int, ...]) -> tuple[tuple[str, ...], int]:
    """Names of the coordinates that move no inertia at random configurations, and the index of the
    first family member that has any."""
    tree = lower(model, VALUES)
    q, _, _ = generic_state(model, seed=1, batch=_SAMPLES)
    samples = tuple(np.moveaxis(q, -1, 0))
    M = np.array([[x + np.zeros((*members, _SAMPLES)) for x in row] for row in crba(tree, samples)])
    M = M.reshape(model.nv, model.nv, *members, _SAMPLES)
    moves = np.array([M[k, k].any(axis=-1) for k in range(model.nv)]).reshape(model.nv, *members)
    if not moves.all():
        member = 0 if not members else int(np.argwhere(~moves.all(axis=0))[0, 0])
        some = moves[:, member] if members else moves
        return tuple(model.velocity_names[k] for k in range(model.nv) if not some[k]), member
    with np.errstate(all="ignore"):
        pivots = _pivots(tree, M)
        largest = np.abs(np.einsum("kk...->k...", M)).max(axis=(0, -1), keepdims=True, initial=0.0)[
            0
        ]
    for k, pivot in pivots.items():
        floor = np.maximum(_NOTHING * np.abs(M[k, k]), 1e-16 * largest)
        bad = np.argwhere(~(pivot > floor).all(axis=-1))
        if len(bad):  # pivots of the joints before it are of no use
            return (model.velocity_names[k],), int(bad[0, 0]) if members else 0
    return (), 0


def _pivots(tree: Tree, M: Array) -> dict[int, Array]:
    """The pivots D in M = Lᵀ D L of the mass matrix, by coordinate, leaves first; eliminates whole
    rows, as a long chain needs cubically many products."""
    order = list(supports(tree))
    left = M[np.ix_(order, order)]
    pivots = {}
    for i in reversed(range(len(order))):
        row = left[i, :i]
        left[:i, :i] -= (row / left[i, i])[:, None] * row
        pivots[order[i]] = np.abs(left[i, i])
    return pivots
