"""Determinants of polynomials, and the Jacobian seen from where its determinant is short."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from freebody.algorithms.kinematics import Column, Pose, ancestors, joint_poses
from freebody.expressions.polynomials.symbols import Symbols
from freebody.model.tree import Tree
from freebody.scalars.trig import Trig
from freebody.spatial import Matrix, Vector, add, compose, identity, neg, sub, times, transposed


def determinant(rows: Sequence[Sequence[Trig]], s: Symbols) -> Trig:
    """By Laplace's expansion, every minor once, sparse rows first."""
    n = len(rows)
    order = sorted(range(n), key=lambda i: sum(not x.is_zero for x in rows[i]))
    sign = _parity(order)
    minors: dict[int, Trig] = {0: s.element(float(sign))}
    for i in order:  # minors of the rows so far, by the columns they use
        wider: dict[int, Trig] = {}
        for used, minor in minors.items():
            for j, x in enumerate(rows[i]):
                if used >> j & 1 or x.is_zero:
                    continue
                after = (used >> (j + 1)).bit_count()
                term = minor * x if after % 2 == 0 else -(minor * x)
                key = used | 1 << j
                wider[key] = wider[key] + term if key in wider else term
        minors = {key: minor for key, minor in wider.items() if not minor.is_zero}
    return minors.get((1 << n) - 1, s.zero())


def _parity(order: list[int]) -> int:
    inversions = sum(a > b for i, a in enumerate(order) for b in order[i + 1 :])
    return -1 if inversions % 2 else 1


def jacobian_from(s: Symbols, frame: str, body: int) -> list[list[Trig]]:
    """Linear and angular columns of all joints before `frame`, in the axes and at the origin of a
    body on the way.

    Against the Jacobian of the frame its rows are turned and its linear ones moved to another
    point: the determinant of all rows is the same, and much shorter (Waldron, Wang, Bolin 1985).
    """
    tree = s.tree
    poses = joint_poses(tree, s.q)
    full: list[Vector] = [(0.0,) * tree.space.six for _ in range(tree.nv)]
    for i in ancestors(tree, tree.frames[frame][0]):
        R, p = _seen_from(tree, poses, body, i)
        at = tree.bodies[i].coordinates
        for k, (w, v) in zip(at.v, tree.bodies[i].columns, strict=True):
            full[k] = add(full[k], _moved(tree, (w, v), R, p, at.ratio))
    return [[s.element(x) for x in row] for row in transposed(tuple(full))]


def _seen_from(tree: Tree, poses: list[Pose], body: int, i: int) -> Pose:
    """Pose of body i in the axes of `body`; one carries the other."""
    resting: Pose = (identity(tree.space.dim), tree.space.zero)
    inner, outer = (i, body) if i in ancestors(tree, body) else (body, i)
    pose = resting
    while outer != inner:
        pose = compose(poses[outer], pose)
        outer = tree.bodies[outer].parent
    if inner != i or i == body:
        return pose
    E = transposed(pose[0])
    return E, neg(times(E, pose[1]))


def _moved(tree: Tree, column: Column, R: Matrix, p: Vector, ratio: Any) -> Vector:
    """A column given at a body's origin, in axes R and at a point from which that origin is p
    away."""
    space = tree.space
    w, v = space.turn(R, column[0]), times(R, column[1])
    linear = sub(v, space.cross(w, p))
    return tuple(ratio * x for x in linear + w)


def columns_of(s: Symbols, frame: str) -> list[int]:
    """The coordinates on the way to a frame, in order."""
    tree = s.tree
    return sorted(
        {k for i in ancestors(tree, tree.frames[frame][0]) for k in tree.bodies[i].coordinates.v}
    )


def shortest_determinant(s: Symbols, frame: str) -> Trig:
    """det of all rows of a frame's Jacobian, from the body on the way where its entries are
    fewest."""
    columns = columns_of(s, frame)
    choices = [jacobian_from(s, frame, body) for body in ancestors(s.tree, s.tree.frames[frame][0])]
    rows = min(choices, key=lambda J: sum(len(x) for row in J for x in row))
    return determinant([[row[k] for k in columns] for row in rows], s)
