"""Inertial parameters regrouped: what of a body moves as if it were fixed to the body before it is
counted there.

What does not change when a joint moves cannot be told from a part of the body before it: on a
revolute joint a body that is symmetric about its axis and light about it (mass, first moment along
the axis, equal moments of inertia across it); on a prismatic joint a body's inertia. Source: W.
Khalil, E. Dombre, Modeling, Identification and Control of Robots, 2002, chapter 9.
"""

from __future__ import annotations

from dataclasses import replace

from freebody.algorithms.crba import Composite, own_inertia
from freebody.algorithms.turned_frames import turned_frames
from freebody.elementary import Scalar
from freebody.model.inertial_parameters import body_parameters
from freebody.model.tree import Mass, Tree, TreeBody
from freebody.spatial import AnySpace, add, scale, symmetric, times


def regrouped(tree: Tree, named: bool = False) -> list[Composite]:
    """(mass, first moment, inertia) of each body about its origin, with what its children hand
    down; named: see `regroup`."""
    return regroup(tree, [own_inertia(tree.space, body) for body in tree.bodies], named)


def lightened(tree: Tree) -> Tree:
    """The tree in other frames and with its inertial numbers regrouped: other bodies, of fewer
    numbers, under which it moves alike.

    M and the bias are the same; joint forces, energies and momenta are not.
    """
    tree = turned_frames(tree)
    bodies = tuple(
        replace(body, masses=(Mass(m, tree.space.zero, inertia, h),))
        for body, (m, h, inertia) in zip(tree.bodies, regrouped(tree), strict=True)
    )
    return replace(tree, bodies=bodies)


def regroup(tree: Tree, composites: list[Composite], named: bool = False) -> list[Composite]:
    """Regrouped parameters from given ones; linear in them. named: nothing is handed to what lies
    between the primitives of one joint, which is no body of the model and has no parameters with
    names."""
    space, result = tree.space, list(composites)
    for i in reversed(range(len(tree.bodies))):
        body = tree.bodies[i]
        if named and is_inner(tree, body.parent):
            continue
        (m, h, inertia), result[i] = _split(space, body, result[i])
        if body.parent >= 0:
            h = times(body.R, h)
            inertia = space.plus_inertia(
                space.turned_inertia(body.R, inertia), space.steiner(m, h, body.p)
            )
            M, H, J = result[body.parent]
            moved = (M + m, add(H, h, scale(m, body.p)), space.plus_inertia(J, inertia))
            result[body.parent] = moved
    return result


def is_inner(tree: Tree, i: int) -> bool:
    """Whether a body of the tree lies between the primitives of one joint."""
    return i >= 0 and i not in tree.body_of


def kept(tree: Tree, i: int) -> tuple[str, ...]:
    """Names of the parameters that stay with body i, of `body_parameters`."""
    space, body = tree.space, tree.bodies[i]
    names = body_parameters(space)
    if is_inner(tree, body.parent):
        return names
    if body.primitive.slides and not body.primitive.turns:
        return names[: 1 + space.dim]
    if body.primitive.slides or not body.primitive.turns:
        return names
    if space.dim == 2:
        return names[1:]
    k = _along(body)
    if k is None:
        return names
    across = "xyz"[k - 1]
    gone = {"m", f"h{'xyz'[k]}", f"I{across}{across}"}
    return tuple(name for name in names if name not in gone)


def _along(body: TreeBody) -> int | None:
    """The coordinate axis of its own frame about which a body turns, if it is one."""
    size = [abs(x) if isinstance(x, float) else None for x in body.axis]
    return size.index(1.0) if sorted(size, key=str) == [0.0, 0.0, 1.0] else None


def _split(space: AnySpace, body: TreeBody, composite: Composite) -> tuple[Composite, Composite]:
    """Two parts of a composite inertia: (what is handed down, what stays)."""
    m, h, inertia = composite
    nothing = space.no_inertia
    if body.primitive.slides and not body.primitive.turns:
        return (0.0, space.zero, inertia), (m, h, nothing)
    if body.primitive.slides or not body.primitive.turns:
        return (0.0, space.zero, nothing), composite
    if space.dim == 2:
        return (m, space.zero, nothing), (0.0, h, inertia)
    k = _along(body)
    if k is None:
        return (0.0, space.zero, nothing), composite
    across: Scalar = inertia[k - 1][k - 1]
    moved = symmetric(3, lambda i, j: across if i == j != k else 0.0)
    stays = symmetric(3, lambda i, j: inertia[i][j] - across if i == j != k else inertia[i][j])
    along = tuple(x if i == k else 0.0 for i, x in enumerate(h))
    rest = tuple(0.0 if i == k else x for i, x in enumerate(h))
    return (m, along, moved), (0.0, rest, stays)
