"""Descriptions of a program for readers of its source text: arguments with units, the robot's
structure, operation counts, and names of intermediate results in the recursion.

Every name from outside becomes a word; `names` says which word is which name. Names of nodes come
from tracing the recursion once more, with its intermediates as results: a node of the program that
computes the same from the same inputs has their name. So no algorithm knows that its scalars are
named, and the program is the kernel's own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from freebody import __version__
from freebody.algorithms.crba import composites, crba
from freebody.algorithms.kinematics import world_poses
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.rnea import rnea
from freebody.algorithms.turned_frames import turned_frames
from freebody.elementary import Scalar
from freebody.identifiers import identifiers
from freebody.kernels.formulas import FORMULAS, INPUTS, POSITIONS, Option
from freebody.kernels.formulas.record import external
from freebody.kernels.parameter_inputs import KernelInputs
from freebody.model.doubts import Doubt, doubts_used
from freebody.model.model import Model
from freebody.model.named_numbers import Parameters
from freebody.model.tree import Tree
from freebody.program import Argument, Program, trace
from freebody.scalars.expr import Expr
from freebody.scalars.operations import OPERATIONS
from freebody.targets.text import Joints

_NUMBERS = "numbers of the robot, listed below (SI units)"
"""Words for the input p."""


class ProgramDescription:
    """The description of a program of a model, for comments in its source text. Attributes:
    comment, joints, marks (see `SourceUnit`), names."""

    def __init__(
        self,
        model: Model,
        quantities: tuple[str, ...],
        option: Option,
        numbers: KernelInputs | None,
        program: Program,
    ):
        self.model, self.option, self.numbers, self.program = model, option, numbers, program
        self._names = quantities
        # of all numbers: names.json is then the same for all functions of a robot, which may share
        # a folder
        self._number_words = identifiers(Parameters(model).names)
        self._joint_words = identifiers(model.joint_names)
        self._body_words = identifiers([*(body.name for body in model.bodies), *model.frame_names])
        self._meanings = self._worded(quantities)
        self.marks = _marks(program, option, numbers.tree if numbers else lambda _: model.tree)

    @property
    def comment(self) -> tuple[str, ...]:
        """Comment lines for the head of the source text."""
        program, model = self.program, self.model
        (robot,) = identifiers([model.name]).values()
        counts = ", ".join(f"{count} {op}" for op, count in sorted(program.operations.items()))
        lines = [
            f"{program.name} of the robot {robot}.",
            f"{sum(program.operations.values())} operations: {counts or 'none'}.",
            f"Written by freebody {__version__} for this robot only: its numbers are constants in "
            f"the code{', except those in p' if self.numbers else ''}.",
            *self._doubtful(),
            "",
            *self._arguments("Inputs", program.inputs),
            *self._arguments("Outputs", program.outputs),
            *_listed_numbers(self.model, self.numbers, self._number_words),
            *self._structure(),
        ]
        if self.option.frame is not None:
            frame = self._body_words[self.option.frame]
            lines.append(f"The frame is {frame}; axes: {self.option.reference}.")
        return (*lines, *self._legend())

    @property
    def doubts(self) -> tuple[Doubt, ...]:
        """Doubts about the model's numbers on which the requested quantities depend."""
        return doubts_used(self.model, *(x for name in self._names for x in FORMULAS[name].touches))

    def _doubtful(self) -> list[str]:
        """Comment lines with the kinds of doubts; their full sentences contain names from the
        robot's file."""
        kinds = ", ".join(dict.fromkeys(doubt.kind for doubt in self.doubts))
        return [f"Doubts about the robot: {kinds}."] if kinds else []

    def _legend(self) -> list[str]:
        """Comment lines that explain the variable names taken from the recursion."""
        letters = {
            word.removeprefix("minus_").rstrip("xyz_0123456789") for word in self.marks.values()
        }
        if not letters:
            return []
        meanings = [
            f"  {letter} {meaning}" for letter, meaning in MEANINGS.items() if letter in letters
        ]
        return [
            "",
            *_SECTIONS,
            *(_TURNED if self._is_turned else ()),
            *(_COUNTED if letters & {"M", "c"} else ()),
            *(_REGROUPED if letters & {*"fnhI"} else ()),
            *meanings,
        ]

    @property
    def _is_turned(self) -> bool:
        """Whether the bodies' frames may be turned against those in the robot's file."""
        return not self.numbers and turned_frames(self.model.tree) is not self.model.tree

    @property
    def joints(self) -> Joints:
        """The joint to which each scalar belongs: entries of q and of the rates, and rows of
        outputs that have one row per joint."""
        by_q, by_v = [-1] * self.model.nq, [-1] * self.model.nv
        for k, at in reversed(list(enumerate(self.model.coordinates))):
            for owner, entries in ((by_q, at.q), (by_v, at.v)):
                for i in entries:
                    owner[i] = k
        last = len(self.model.bodies) - 1
        inputs: list[int] = []
        for argument in self.program.inputs:
            rates = argument.name in INPUTS and INPUTS[argument.name].dims == ("nv",)
            owners = by_q if argument.name in POSITIONS else by_v if rates else [-1] * argument.size
            inputs += owners
        outputs: list[int] = []
        for argument in self.program.outputs:
            rows = argument.shape and argument.shape[0] == self.model.nv
            outputs += [by_v[index[0]] if rows else last for index in argument.indices()]
        return Joints(tuple(inputs), tuple(outputs), tuple(self._joint_words.values()))

    @property
    def names(self) -> dict[str, Any]:
        """The robot's original names, by the identifier that stands for each in the text."""
        (robot,) = identifiers([self.model.name]).values()
        return {
            "robot": {robot: self.model.name},
            "joints": {word: name for name, word in self._joint_words.items()},
            "bodies and frames": {word: name for name, word in self._body_words.items()},
            "numbers": {word: name for name, word in self._number_words.items()},
        }

    def _worded(self, quantities: tuple[str, ...]) -> dict[str, str]:
        """Descriptions of the arguments, by name."""
        found = {name: given.meaning for name, given in INPUTS.items()} | {"p": _NUMBERS}
        if self.model.nq == self.model.nv:  # no quaternions
            found |= {name: f"{found[name].partition(';')[0]})" for name in ("q", "qd")}
        for k, frame in enumerate(self.option.wrench_frames):
            found[f"wrench{k}"] = (
                f"wrench on the frame {self._body_words[frame]}: force, then moment about its "
                f"origin, world axes (N, N m)"
            )
        for name in quantities:
            for label, output in FORMULAS[name].outputs.items():
                full = f"{name}_{label}" if len(quantities) > 1 else label
                found[f"out {full}"] = output.meaning
        return found

    def _arguments(self, title: str, arguments: Iterable[Argument]) -> list[str]:
        kind = "out " if title == "Outputs" else ""
        return [
            f"{title}:",
            *(f"  {a}: {self._meanings.get(kind + a.name, 'as named')}" for a in arguments),
            "",
        ]

    def _structure(self) -> list[str]:
        """Comment lines on the joints: the type of each, its entries in q, and the bodies that it
        carries."""
        model = self.model
        lines = [f"Joints, in {model.dim} dimensions:"]
        for k, (body, at) in enumerate(zip(model.bodies, model.coordinates, strict=True)):
            parent = (
                self._body_words[model.bodies[body.parent].name] if body.parent >= 0 else "the base"
            )
            follows = " (follows another)" if body.joint.mimic is not None else ""
            lines.append(
                f"  {k + 1} {self._joint_words[body.joint.name]}: {body.kind.name}{follows}, q "
                f"{_span(at.q)}, "
                f"qd {_span(at.v)}, carries {self._body_words[body.name]} on {parent}"
            )
        if model.loops:
            lines.append(f"  and {len(model.loops)} loops that close the chain")
        return [*lines, f"Gravity: {self._gravity()}."]

    def _gravity(self) -> str:
        """Phrase for the gravity vector, which matters to whoever mounts the robot; "in p" if it is
        an input."""
        given = self.numbers.opened if self.numbers else self.model
        if (given.gravity_size, given.gravity_direction) != (
            self.model.gravity_size,
            self.model.gravity_direction,
        ):
            return "in p"
        return f"[{', '.join(f'{x:.6g}' for x in self.model.gravity)}] m/s^2, world axes"


_SECTIONS = (
    "Sections: outward, up to joint k: values that depend on no later joint; inward, to joint k: "
    "values needed only",
    "for results of joints up to k. Names: w3_y is the y component, in its own axes, of the "
    "angular velocity of",
    "body 3, which joint 3 carries, and minus_w3_y its negative; t1, t2, ... are values without "
    "such a name.",
)
_TURNED = (
    "Frames of bodies are turned about the axes of their joints, and moved along them, where this "
    "saves operations:",
    "their own axes and origins are then those.",
)
_COUNTED = ("Entries of M and c count from 0, as arrays do.",)
_REGROUPED = (
    "Masses are regrouped among bodies where this saves operations and leaves the motion "
    "unchanged: f, n, h and I",
    "are then those of the regrouped bodies.",
)


def _span(entries: tuple[int, ...]) -> str:
    """Text of array indices counted from 0: [2] or [0..5]."""
    return (
        f"[{entries[0]}]"
        if len(entries) == 1
        else f"[{entries[0]}..{entries[-1]}]"
        if entries
        else "[]"
    )


def _listed_numbers(model: Model, numbers: KernelInputs | None, words: dict[str, str]) -> list[str]:
    """Comment lines on the meaning of the entries of p, with names, units and the model's own
    values."""
    if numbers is None:
        return []
    records = {record.name: record for record in Parameters(model)}
    lines = []
    for k, (name, value) in enumerate(zip(numbers.names, numbers.values, strict=True)):
        unit = records[name].unit.replace("²", "^2")
        unit = "" if unit == "1" else unit
        own = (
            f", here {value:.6g} {unit}".rstrip()
            if value == value
            else f" ({unit})"
            if unit
            else ""
        )
        lines.append(f"  p [{k}] {words[name]}{own}")
    return ["Numbers of the robot:", *lines, ""]


def of_program(
    program: Program, numbers: KernelInputs | None = None
) -> tuple[tuple[str, ...], dict[str, Any]]:
    """(comment lines, names of p's entries) for a kernel of which only the program and its p are
    known."""
    counts = ", ".join(f"{count} {op}" for op, count in sorted(program.operations.items()))
    words = identifiers(Parameters(numbers.model).names if numbers else ())
    head = [
        f"{program.name}: {', '.join(map(str, program.inputs))} -> "
        f"{', '.join(map(str, program.outputs))}.",
        f"{sum(program.operations.values())} operations: {counts or 'none'}.",
        f"Written by freebody {__version__}.",
    ]
    if numbers is None:
        return tuple(head), {}
    listed = _listed_numbers(numbers.model, numbers, words)
    return (*head, "", *listed[:-1]), {"numbers": {word: name for name, word in words.items()}}


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
"""The meaning of the letters in front of a number."""

_SEEN = ("input", "const", "sin", "cos")
"""Operations that show what they are."""
_LESS = "fnhI"
"""Letters that say less of a node than the name of the result that it is."""

_LARGEST = 64
"""Coordinates up to which the mass matrix is looked for."""


def _marks(program: Program, option: Option, tree_over: Callable[[Any], Tree]) -> dict[int, str]:
    """Variable names for nodes of the program that are intermediate results of the recursion: w3_x
    is the x component of the angular velocity of body 3.

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
    """The number of a node that computes the negative of a node; -1 if there is none among the
    known ones."""
    op, operands = program.op[node], [known[i] for i in program.operands(node)]
    if op == "neg":
        return operands[0]
    return numbers.get((op, *reversed(operands)), -1) if op == "sub" else -1


def _numbered(program: Program, numbers: dict[tuple[Any, ...], int]) -> list[int]:
    """A number for each node; nodes of two programs get the same number when they compute the same
    value from the same inputs."""
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
    """Variable names and scalars of inverse dynamics, the poses and the mass matrix."""
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
    if tree.nv <= _LARGEST:
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
    """Names of the entries of a vector, w3_x, w3_y, w3_z, or matrix, R3_xx, …, with the scalars; a
    single entry is w3."""
    if not isinstance(value, tuple):
        yield word, value
        return
    if len(value) == 1:
        yield from _entries(word, value[0])
        return
    for axis, entry in zip("xyz", value, strict=False):
        yield from _entries(f"{word}{axis}" if word[-1] in "xyz" else f"{word}_{axis}", entry)
