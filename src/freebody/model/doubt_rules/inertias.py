"""Rules on masses and inertias: what weighs nothing, what no rigid body has, and whether that is
felt."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.bodies import Body
from freebody.model.doubt_rules.aspects import NAMES
from freebody.model.inertia import combined
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached, parents_first
from freebody.spatial import of_dimension

if TYPE_CHECKING:
    from freebody.model.model import Model

MEASURED = 0.15
"""Share of a body's largest principal moment by which its moments may break the triangle inequality
because they are measured, or printed with few digits."""
_ON_AXIS = 1e-6
"""Distance in m below which a point counts as on an axis."""
_ROUNDED = 1e-9
"""Relative, or rad: what rounding leaves of 0."""


def is_bare(body: Body) -> bool:
    """Whether a body has neither mass nor inertia."""
    return not any(weighs(part) for part in body.inertias)


def weighs(part: Attached) -> bool:
    """Whether a link has mass or inertia."""
    return any(VALUES.quantity(x) != 0.0 for x in (part.inertia.mass, *part.inertia.tensor))


def massless(model: Model, _: Sequence[str]) -> Iterator[str]:
    """The robot where none of its bodies has any mass."""
    if model.bodies and all(map(is_bare, model.bodies)):
        yield "no body has any mass."


def impossible(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Inertias that no rigid body has, by more than measured ones break the triangle inequality."""
    wrong = _faults(model, lambda breach: breach > MEASURED)
    if len(wrong) == 1:
        yield f"an inertia is one that no rigid body has: {wrong[0][1]}."
    elif wrong:
        names = listed([name for name, _ in wrong], NAMES)
        yield f"{len(wrong)} inertias are such that no rigid body has, of {names}: {wrong[0][1]}."


def inexact(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Inertias that no rigid body has, by no more than measured ones."""
    off = _faults(model, lambda breach: breach <= MEASURED)
    if off:
        what = "an inertia" if len(off) == 1 else f"{len(off)} inertias"
        yield (
            f"{what} that no rigid body has {'is' if len(off) == 1 else 'are'} used as given, of "
            f"{listed([name for name, _ in off], NAMES)}."
        )


def _faults(model: Model, wanted: Callable[[float], bool]) -> list[tuple[str, str]]:
    """Names of the links whose inertias no rigid body has, and why, of bodies that break the
    triangle inequality by so much; without what is never felt."""
    found = []
    for body, axes in zip(model.bodies, _turned_about(model), strict=True):
        faults = [
            (part.link, fault)
            for part in body.inertias
            if (fault := part.inertia.fault()) and not _unfelt(part, axes)
        ]
        if faults and wanted(_breach(body)):
            found += [(link, f"link {link!r}: {fault}") for link, fault in faults]
    return found


def unfelt_links(model: Model) -> set[str]:
    """Names of the links with an inertia that no rigid body has, of which nothing is ever felt:
    those of the base, and such as turn about no other axis than the one that their inertia is
    given about."""
    moving = {
        part.link
        for body, axes in zip(model.bodies, _turned_about(model), strict=True)
        for part in body.inertias
        if part.inertia.fault() and _unfelt(part, axes)
    }
    return moving | {part.link for part in model.base_inertias if part.inertia.fault()}


def _breach(body: Body) -> float:
    """The excess of a body's principal moments over the triangle inequality, as a share of the
    largest one; infinite for masses and moments below 0."""
    if any(VALUES.quantity(part.inertia.mass) < 0.0 for part in body.inertias):
        return math.inf
    return excess(_whole(body))


def excess(tensor: Array) -> float:
    """The excess of a tensor's principal moments over the triangle inequality, as a share of the
    largest one; infinite where none is above 0."""
    if tensor.shape == (1, 1):
        return math.inf if tensor[0, 0] < 0.0 else 0.0
    a, b, c = np.linalg.eigvalsh(tensor)
    return float((c - a - b) / c) if c > 0.0 else math.inf


def _unfelt(part: Attached, axes: Array | None) -> bool:
    """Whether nothing is felt of what is wrong with a link's inertia: its body never turns, or only
    about the axis of which alone an inertia is given. axes: see `_turned_about`."""
    mass, _, tensor = part.inertia.numbers()
    if axes is None or mass < 0.0:
        return False
    if not len(axes):
        return True
    R = np.array(part.placement.lower(of_dimension(3), VALUES)[0], dtype=float)
    axis = R.T @ axes[0]
    about = float(axis @ tensor @ axis)
    rest = tensor - about * np.outer(axis, axis)
    return about >= 0.0 and float(np.abs(rest).max()) <= _ROUNDED * float(np.abs(tensor).max())


def _turned_about(model: Model) -> list[Array | None]:
    """For each body in space the axes about which it ever turns, in its own: none (0, 3), or one
    (1, 3), about which alone its inertia is felt; None where there are several, and in the
    plane."""
    if model.dim == 2:
        return [None] * len(model.bodies)
    space = of_dimension(3)
    turned: dict[int, tuple[Array, list[Array]]] = {-1: (np.eye(3), [])}
    """Orientation of each body where all coordinates are 0, and the axes above it, seen from there,
    by body."""
    axes: list[Array | None] = [None] * len(model.bodies)
    for i in parents_first(model.bodies):
        body = model.bodies[i]
        R, above = turned[body.parent]
        R = R @ np.array(body.joint.placement.lower(space, VALUES)[0], dtype=float)
        numbers = tuple(map(VALUES.quantity, body.joint.numbers))
        own = [
            R @ np.array(angular, dtype=float)
            for primitive, axis in body.kind.primitives(space, body.joint.axis, numbers)
            for angular, _ in primitive.columns(space, axis)
            if any(angular)
        ]
        every = [*above, *own]
        turned[i] = R, every
        if all(np.allclose(np.cross(every[0], u), 0.0, atol=_ROUNDED) for u in every):
            axes[i] = np.reshape([R.T @ u for u in every[:1]], (-1, 3))
    return axes


def _whole(body: Body) -> Array:
    """Inertia about the centre of mass of all that is fixed together."""
    dim = body.inertias[0].inertia.dim
    placed = [
        part.inertia.placed(*part.placement.lower(of_dimension(dim), VALUES))
        for part in body.inertias
    ]
    return combined(placed).numbers()[2]


def point(model: Model, _: Sequence[str]) -> Iterator[str]:
    """Loads that are points, without inertia: those alike in one sentence."""
    space = of_dimension(model.dim)
    felt: list[str] = []
    for body in model.bodies:
        for part in body.inertias:
            inertia = part.inertia
            mass = VALUES.quantity(inertia.mass)
            if not part.load or not mass or any(VALUES.quantity(x) for x in inertia.tensor):
                continue
            R, p = part.placement.lower(space, VALUES)
            com = [VALUES.quantity(x) for x in inertia.com]
            at = np.array(p) + np.array(R, dtype=float) @ com
            off = at
            if model.dim == 3 and body.joint.axis:
                off = np.cross(body.joint.axis, at)
            free = body.kind.turns and float(np.linalg.norm(off)) <= _ON_AXIS
            load = f"{part.link!r} ({mass:.4g} kg)"
            if free:
                axis = f"{body.joint.name}, on whose axis it is, does not feel it"
                yield f"load {load} is a point without inertia; {axis}."
            else:
                felt.append(load)
    if felt:
        are = "load {} is a point" if len(felt) == 1 else "loads {} are points"
        yield f"{are.format(listed(felt))} without inertia."
