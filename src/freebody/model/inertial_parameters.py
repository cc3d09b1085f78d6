"""Inertial parameters π: names and order of the numbers that inverse dynamics is linear in, and a
model made of them.

Of each body its mass m, first moment h = m c and inertia I about its joint's origin, in its axes;
of each joint with a drive those of its laws, such as reflected rotor inertia J gear², stiffness,
and stiffness times rest position.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import ModelError, ShapeError
from freebody.labels import aligned
from freebody.model.drives import LAWS, NUMBERS
from freebody.model.families import Members, members
from freebody.model.inertia import Inertia, faults
from freebody.model.parameters import LARGEST, Quantity, finite
from freebody.model.quantity_reader import VALUES
from freebody.model.structure import laws_shown
from freebody.model.tree import Attached
from freebody.spatial import AnySpace, of_dimension

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.description import Drive
    from freebody.model.model import Model

_ROUNDED = 1e-14
"""Share of a body's inertia below which entries about its centre are what rounding leaves of a
particle's."""


def body_parameters(space: AnySpace) -> tuple[str, ...]:
    """Names of a body's parameters, in order."""
    if space.dim == 2:
        return ("m", "hx", "hy", "I")
    return ("m", "hx", "hy", "hz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz")


def parameter_names(model: Model) -> tuple[str, ...]:
    """Names of a model's inertial parameters, in order: of bodies, then of the joints that have a
    drive."""
    own = body_parameters(of_dimension(model.dim))
    drives = zip(model.bodies, laws_shown(model), strict=True)
    return (
        *(f"{body.name}.{p}" for body in model.bodies for p in own),
        *(f"{b.joint.name}.{p}" for b, laws in drives for x in laws for p in LAWS[x].parameters),
    )


def with_inertial_parameters(model: Model, pi: Any) -> Model:
    """The model with other inertial parameters, see `Model.with_inertial_parameters`."""
    function = "with_inertial_parameters"
    model.require_values(function)
    names = parameter_names(model)
    given = np.asarray(aligned(function, "pi", pi, names))
    if given.ndim < 1 or given.shape[-1] != len(names):
        because = "the order is that of fb.inertial_parameters(model)"
        raise ShapeError(function, "pi", given.shape, f"(..., {len(names)})", because)
    numbers = {name: _number(given[..., k], f"{function}: {name}") for k, name in enumerate(names)}
    own, bodies = body_parameters(of_dimension(model.dim)), []
    for body, laws in zip(model.bodies, laws_shown(model), strict=True):
        row = np.stack([VALUES.quantity(numbers[f"{body.name}.{p}"]) for p in own], axis=-1)
        inertia = _inertia(row, model.dim, f"{function}: {body.name!r}")
        changed = replace(body, inertias=(Attached(body.name, inertia),))
        if laws:
            drive = _drive(body, laws, numbers, f"{function}: joint {body.joint.name!r}")
            changed = replace(changed, joint=replace(body.joint, drive=drive))
        bodies.append(changed)
    return replace(model, bodies=tuple(bodies))


def _number(x: Any, owner: str) -> Quantity:
    return members(x, owner, LARGEST) if np.ndim(x) else finite(x[()], owner)


def _quantity(x: Array) -> Quantity:
    """A computed number, or those of the members."""
    return Members(np.array(x)) if np.ndim(x) else float(x)


def _inertia(row: Array, dim: int, owner: str) -> Inertia:
    """Mass, centre and inertia about it, of mass, first moment and inertia about the origin (...,
    10) or (..., 4)."""
    m, h, about = row[..., 0], row[..., 1 : 1 + dim], row[..., 1 + dim :]
    if np.any((m == 0.0)[..., None] & (h != 0.0)):
        raise ModelError(f"{owner}: a first moment h without a mass m; no rigid body has that.")
    c = np.divide(h, m[..., None], out=np.zeros_like(h), where=(m != 0.0)[..., None])
    square = (h * c).sum(axis=-1)
    if dim == 2:
        steiner = square[..., None]
    else:
        pairs = [(i, j) for i in range(3) for j in range(i, 3)]
        steiner = np.stack(
            [(square if i == j else 0.0) - h[..., i] * c[..., j] for i, j in pairs], axis=-1
        )
    tensor = about - steiner
    tensor[np.abs(tensor) <= _ROUNDED * np.abs(about).max(axis=-1, keepdims=True)] = 0.0
    columns = [np.moveaxis(x, -1, 0) for x in (c, tensor)]
    inertia = Inertia(_quantity(m), *(tuple(map(_quantity, x)) for x in columns))
    fault = faults(inertia)
    if fault:
        raise ModelError(
            f"{owner}: {fault}. Estimate under the constraint that each body is physical."
        )
    return inertia


def _drive(body: Body, laws: Sequence[str], numbers: Mapping[str, Quantity], owner: str) -> Drive:
    """The drive of a joint with other parameters; what these do not tell, such as the gear, and
    without a spring its rest position, stays."""
    old, found = body.joint.drive, {}
    now = {name: VALUES.quantity(getattr(old, name)) for name in NUMBERS}
    for law in map(LAWS.__getitem__, laws):
        named = (numbers[f"{body.joint.name}.{p}"] for p in law.parameters)
        entries = [np.asarray(VALUES.quantity(x)) for x in named]
        found |= law.numbers_of(entries, now, owner)
    return replace(old, **{name: _quantity(np.asarray(x)) for name, x in found.items()})
