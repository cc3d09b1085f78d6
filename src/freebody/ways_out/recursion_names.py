"""What the nodes of a program are in the recursion: names for whoever reads its text.

The recursion is traced once more, with its intermediates as results; a node of the program that
computes the same from the same inputs has their name. So no algorithm knows that its scalars are
named, and the program is the kernel's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from freebody.algorithms.crba import composites, crba
from freebody.algorithms.kinematics import world_poses
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.rnea import rnea
from freebody.elementary import Scalar
from freebody.kernels.formulas import Option
from freebody.kernels.formulas.choices import external
from freebody.model.tree import Tree
from freebody.program import Program, trace
from freebody.scalars.expr import Expr
from freebody.scalars.operations import OPERATIONS

MEANINGS = {
    "R": "rotation matrix from its axes to those of the world",
    "r": "position of its origin in the world",
    "w": "angular velocity",
    "wd": "angular acceleration",
    "v": "velocity of its origin",
    "a": "acceleration of its origin minus gravity",
    "f": "force that the joint transmits to it",
    "n": "moment that the joint transmits to it",
    "h": "first moment of the body and all that it carries, about its origin",
    "I": "inertia of the body and all that it carries, about its origin",
    "M": "entry of the mass matrix",
    "c": "torque at zero accelerations",
}
"""What the letters in front of a number stand for."""

_SEEN = ("input", "const", "sin", "cos")
"""Operations that show what they are."""
_LESS = "fnhI"
"""Letters that say less of a node than the name of the result that it is."""

LARGEST = 64
"""Coordinates up to which the mass matrix is looked for."""


def marks(program: Program, option: Option, tree_over: Callable[[Any], Tree]) -> dict[int, str]:
    """Node -> word, of those that the recursion has a name for: w3_x, the x of the angular velocity
    of body 3.

    tree_over: the tree over the scalars of p.
    """
    inputs = [argument.name for argument in program.inputs]
    if not any(argument.name == "q" and argument.size for argument in program.inputs):
        return {}

    def evaluate(*values: Any) -> dict[str, np.ndarray]:
        given = dict(zip(inputs, values, strict=True))
        tree = tree_over(given.get("p"))
        plain, lighter = (dict(_named(t, option, given)) for t in (tree, lightened(tree)))
        found = plain | {f"{word}__": scalar for word, scalar in lighter.items()}
        return {word: np.array(x, dtype=object) for word, x in found.items() if isinstance(x, Expr)}

    recursion = trace("recursion", evaluate, program.inputs, None)
    numbers: dict[tuple[Any, ...], int] = {}
    at = {number: node for node, number in reversed([*enumerate(_numbered(program, numbers))])}
    known = _numbered(recursion, numbers)
    results = set(program.results)
    found: dict[int, str] = {}
    for argument, named in zip(recursion.outputs, recursion.results, strict=True):
        word = argument.name.removesuffix("__")
        node = at.get(known[named])
        if node is None:
            node, word = at.get(_opposite(recursion, named, known, numbers)), f"minus_{word}"
        if (
            node is None
            or program.op[node] in _SEEN
            or (node in results and argument.name[0] in _LESS)
        ):
            continue
        found.setdefault(node, word)
    return found


def _opposite(
    program: Program, node: int, known: list[int], numbers: dict[tuple[Any, ...], int]
) -> int:
    """The number of what computes the negative of a node; -1 where that is nothing known."""
    op, operands = program.op[node], [known[i] for i in program.operands(node)]
    if op == "neg":
        return operands[0]
    return numbers.get((op, *reversed(operands)), -1) if op == "sub" else -1


def _numbered(program: Program, numbers: dict[tuple[Any, ...], int]) -> list[int]:
    """For each node a number; nodes of two programs that compute the same from the same inputs have
    the same."""
    made: list[int] = []
    for index, op in enumerate(program.op):
        if record := OPERATIONS.get(op):
            operands = [made[i] for i in program.operands(index)]
            key = (op, *(sorted(operands) if record.commutes else operands))
        else:
            key = (op, program.constants[program.a[index]] if op == "const" else program.a[index])
        made.append(numbers.setdefault(key, len(numbers)))
    return made


def _named(tree: Tree, option: Option, given: dict[str, Any]) -> Iterator[tuple[str, Scalar]]:
    """Words and scalars of inverse dynamics, of the poses, and of the mass matrix."""
    zeros = (0.0,) * tree.nv
    q, qd, qdd = given["q"], given.get("qd", zeros), given.get("qdd", zeros)
    wrenches = tuple(
        given[f"wrench{k}"] for k in range(len(option.wrench_frames)) if f"wrench{k}" in given
    )
    loads = external(tree, option, q, wrenches) if wrenches else []
    recursion = rnea(tree, q, qd, qdd, loads)
    motion, world = recursion.motion, world_poses(tree, recursion.motion.joints)
    gathered = composites(tree, motion.joints)
    if "qdd" not in given:
        yield from ((f"c_{k}", x) for k, x in enumerate(recursion.tau))
    if tree.nv <= LARGEST:
        for k, row in enumerate(crba(tree, q)):
            yield from ((f"M_{k}_{l}", x) for l, x in enumerate(row[: k + 1]))
    for joint, i in enumerate(tree.body_of):
        R, p = world[i]
        _, h, inertia = gathered[i]
        values = (
            R,
            p,
            motion.w[i],
            motion.wd[i],
            motion.v[i],
            motion.vd[i],
            recursion.f[i],
            recursion.n[i],
        )
        for letter, value in zip(MEANINGS, (*values, h, inertia), strict=False):
            yield from _entries(f"{letter}{joint + 1}", value)


def _entries(word: str, value: Any) -> Iterator[tuple[str, Scalar]]:
    """w3_x, w3_y, w3_z of a vector, R3_xx, … of a matrix; what has one entry is w3."""
    if not isinstance(value, tuple):
        yield word, value
        return
    if len(value) == 1:
        yield from _entries(word, value[0])
        return
    for axis, entry in zip("xyz", value, strict=False):
        yield from _entries(f"{word}{axis}" if word[-1] in "xyz" else f"{word}_{axis}", entry)
