"""How quantities of a closed chain compare: lengths become angles, over the mechanism's length, and
a difference counts as rounding below a limit that suits numbers of any length."""

from __future__ import annotations

from freebody.elementary import Scalar, epsilon, maximum, sqrt
from freebody.model.tree import Tree
from freebody.spatial import Vector, dot


def mechanism_length(tree: Tree) -> Scalar:
    """The farthest that a joint or frame is placed from the one before, or a rod is long (m); 1
    where all is at one place."""
    offsets = [body.p for body in tree.bodies] + [p for _, _, p in tree.frames.values()]
    offsets += [(loop.distance,) for loop in tree.loops]
    sizes = [sqrt(dot(p, p)) for p in offsets if not _vanishes(p)]
    longest: Scalar = sizes[0] if sizes else 1.0
    for size in sizes[1:]:
        longest = maximum(longest, size)
    return longest


def scales(tree: Tree) -> tuple[Vector, Vector]:
    """(factors (m,) of the loop equations, divisors (nv,) of the rates) that turn lengths into
    angles."""
    length = mechanism_length(tree)
    per_length = 1.0 / length
    rows = tuple(per_length if of_length else 1.0 for of_length in equations_of_lengths(tree))
    return rows, tuple(length if of_length else 1.0 for of_length in rates_of_lengths(tree))


def equations_of_lengths(tree: Tree) -> tuple[bool, ...]:
    """For each loop equation whether it is one of lengths (m); others are sines of angles."""
    found: list[bool] = []
    for loop in tree.loops:
        turns = len(loop.closure.turns)
        found += [True] * (loop.closure.size(tree.space) - turns) + [False] * turns
    return tuple(found)


def rates_of_lengths(tree: Tree) -> tuple[bool, ...]:
    """For each rate whether it is one of lengths (m/s); others are angular."""
    found = [False] * tree.nv
    for body in tree.bodies:
        for k, (angular, linear) in zip(body.coordinates.v, body.columns, strict=True):
            found[k] = found[k] or (_vanishes(angular) and not _vanishes(linear))
    return tuple(found)


def repeating(tree: Tree) -> tuple[bool, ...]:
    """For each rate whether a whole turn of its coordinate changes nothing."""
    found = [True] * tree.nv
    for body in tree.bodies:
        ratio = body.coordinates.ratio
        for k, (_, linear) in zip(body.coordinates.v, body.columns, strict=True):
            found[k] = found[k] and _vanishes(linear) and ratio == round(ratio)
    return tuple(found)


def no_finer(limit: float, x: Scalar, roundings: float) -> Scalar:
    """The larger of a relative limit and the rounding of x's type, so that numbers of few digits
    are not compared too finely.

    roundings: how many units of rounding of x's type a compared value may well have gathered.
    """
    return maximum(limit, roundings * epsilon(x))


def _vanishes(vector: Vector) -> bool:
    """Whether a vector is zero by structure, whatever the numbers are."""
    return all(isinstance(x, int | float) and x == 0.0 for x in vector)
