"""The record of a programming language for source text; the unit of text to write (a program, its
name and further facts about it); and parts that several languages share."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from math import isinf

import numpy as np

from freebody.errors import FreebodyError
from freebody.identifiers import is_identifier
from freebody.program.program import Argument, Program, ProgramError, verify

# nothing that ends a comment or a string, or escapes
_REMARK = re.compile(r"[A-Za-z0-9_ .,:;()\[\]/^+<>=-]*")


@dataclass(frozen=True)
class Joints:
    """The joint to which each scalar of the inputs and outputs belongs (-1: none), and the joints
    in words."""

    of_inputs: tuple[int, ...]
    of_outputs: tuple[int, ...]
    words: tuple[str, ...]


@dataclass(frozen=True)
class SourceUnit:
    """A program to be written as source text, with its name and comments.

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
    """A section of a program's text: nodes, operands before their readers, under a title (empty:
    none)."""

    title: str
    nodes: tuple[int, ...]


def sections(program: Program, joints: Joints | None) -> list[Section]:
    """The program's operations by joint: outward, nodes that depend on joints up to one; then
    inward, nodes that only results of joints up to one depend on. That is the order of a recursion,
    read from the graph."""
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
    """For each node the last joint that it depends on, and the last joint among those whose results
    depend on it."""
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


@dataclass(frozen=True)
class SelfTestSamples:
    """Samples for a self-test: for each input and output an array (samples, size), and for each
    output the tolerance relative to its largest entry."""

    inputs: tuple[np.ndarray, ...]
    outputs: tuple[np.ndarray, ...]
    tolerances: tuple[float, ...]

    @property
    def count(self) -> int:
        """Number of samples of the self-test."""
        return len(self.outputs[0])


@dataclass(frozen=True)
class Language:
    """A programming language in which programs are written as text.

    emit: the whole text of a unit. package: the files of a unit with a self-test over vectors, by
    name. test: the command that runs the self-test in the files' folder; {name} is the function's
    word. dtypes: types of number that the text can be made for, the default first. note: what a
    reader of a package has to know.
    """

    emit: Callable[[SourceUnit], str]
    package: Callable[[SourceUnit, SelfTestSamples], dict[str, str]]
    test: str
    dtypes: tuple[str, ...] = ("float64",)
    note: str = ""


def numbered(*stems: str) -> frozenset[str]:
    """Names stem0, stem1, … of a self-test's arrays, which no function may have."""
    return frozenset(f"{stem}{k}" for stem in stems for k in range(32))


def called(*tables: Mapping[str, str]) -> frozenset[str]:
    """Words of functions that templates call or define, which nothing else may be called."""
    return frozenset(
        word for table in tables for text in table.values() for word in _CALLED.findall(text)
    )


_CALLED = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?:\{f\})?\(")


def number(value: float) -> str:
    """A double with all its digits, in the form that most languages read."""
    return repr(float(value))


def single(value: float, suffix: str = "") -> str:
    """The nearest float32 with as many digits as it needs."""
    with np.errstate(over="ignore"):
        nearest = np.float32(value)
    if isinf(nearest):
        raise FreebodyError(
            f"the number {value!r} of this robot is beyond the range of float32; use float64."
        )
    text = str(nearest)
    return f"{text if '.' in text or 'e' in text else f'{text}.0'}{suffix}"


def comment_block(
    unit: SourceUnit, use: Iterable[str], begin: str, line: str, end: str
) -> list[str]:
    """The comment at the head of a text: what is known of the unit, and how it is used in the
    language."""
    known = [*unit.comment, ""] if unit.comment else []
    listed = [f"{line} {text}".rstrip() for text in (*known, *use)]
    return [*([begin] if begin else []), *listed, *([end] if end else [])]


def flat(word: str, argument: Argument, position: int) -> str:
    """The text of an argument's entry by its position from 0; of a scalar its name."""
    return f"{word}[{position}]" if argument.shape else word


def helpers(program: Program, known: Mapping[str, str]) -> list[str]:
    """Texts of the helper functions that a program's operations need, in a fixed order."""
    return [text for op, text in known.items() if op in program.operations]


def number_lists(values: np.ndarray, spell: Callable[[float], str]) -> list[str]:
    """For each sample its numbers separated by commas; for none a single number, since C has no
    empty arrays."""
    return [", ".join(map(spell, row)) or spell(0.0) for row in values.tolist()]


def largest_entries(vectors: SelfTestSamples) -> list[float]:
    """For each output the size relative to which differences are measured."""
    return [float(abs(rows).max(initial=0.0)) or 1.0 for rows in vectors.outputs]
