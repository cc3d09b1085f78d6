"""What a language is given to write: a program, its name, and what is known about it besides."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from freebody.identifiers import is_identifier
from freebody.program.program import Program, ProgramError, verify

# nothing that ends a comment or a string, or escapes
_REMARK = re.compile(r"[A-Za-z0-9_ .,:;()\[\]/^+<>=-]*")


@dataclass(frozen=True)
class Joints:
    """Which joint each scalar of all inputs, and of all outputs, belongs to (-1: none), and the
    joints in words."""

    of_inputs: tuple[int, ...]
    of_outputs: tuple[int, ...]
    words: tuple[str, ...]


@dataclass(frozen=True)
class Unit:
    """A program that becomes text.

    name: the function's. comment: lines that stand at the head of the text. joints: where they are
    known, the text has a section for each. dtype: "float64" or "float32". marks: words for nodes,
    by which their values are called. Raises ProgramError for a program that is not valid, and for a
    name or remark that could be taken for code: what is written holds none.
    """

    program: Program
    name: str
    comment: tuple[str, ...] = ()
    joints: Joints | None = None
    dtype: str = "float64"
    marks: Mapping[int, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        verify(self.program)
        if not is_identifier(self.name):
            raise ProgramError(
                f"the function name {self.name!r} is not a word of letters a-z, digits and _."
            )
        for word in self.marks.values():
            if not is_identifier(word):
                raise ProgramError(
                    f"the value name {word!r} is not a word of letters a-z, digits and _."
                )
        for remark in (*self.comment, *(self.joints.words if self.joints else ())):
            if not _REMARK.fullmatch(remark):
                raise ProgramError(
                    f"the remark {remark!r} has characters that a comment must not contain."
                )


@dataclass(frozen=True)
class Section:
    """Nodes in an order in which operands precede, under a title (empty: none)."""

    title: str
    nodes: tuple[int, ...]


def sections(program: Program, joints: Joints | None) -> list[Section]:
    """The program's operations by joint: outward, what depends on joints up to one; then inward,
    what only results of joints up to one depend on. That is the order of a recursion, read from the
    graph."""
    nodes = range(len(program))
    if joints is None:
        return [Section("", tuple(nodes))]
    last = len(joints.words) - 1
    depends, serves = _reach(program, joints)
    rank = [(0, depends[i]) if depends[i] < last else (1, -serves[i]) for i in nodes]
    return [
        Section(_title(joints, *key), tuple(i for i in nodes if rank[i] == key))
        for key in sorted(set(rank))
    ]


def _reach(program: Program, joints: Joints) -> tuple[list[int], list[int]]:
    """For each node the last joint that it depends on, and the last joint whose results depend on
    it."""
    depends = [-1] * len(program)
    for index, op in enumerate(program.op):
        if op == "input":
            depends[index] = joints.of_inputs[program.a[index]]
        else:
            depends[index] = max((depends[i] for i in program.operands(index)), default=-1)
    serves = [-1] * len(program)
    for joint, index in zip(joints.of_outputs, program.results, strict=True):
        serves[index] = max(serves[index], joint)
    for index in reversed(range(len(program))):
        for operand in program.operands(index):
            serves[operand] = max(serves[operand], serves[index])
    return depends, serves


def _title(joints: Joints, inward: int, key: int) -> str:
    joint = -key if inward else key
    if joint < 0:
        return "" if inward else "before the first joint"
    return f"{'inward, to' if inward else 'outward, up to'} joint {joint + 1} {joints.words[joint]}"
