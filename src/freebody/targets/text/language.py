"""What a language of source text is: a record; and what several of them share."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from math import isinf

import numpy as np

from freebody.errors import FreebodyError
from freebody.program.program import Argument, Program
from freebody.targets.text.unit import Unit


@dataclass(frozen=True)
class SelfTestSamples:
    """Samples to test with: for each input and each output an array (samples, size), and for each
    output how far a result may be off, over the largest entry of that output."""

    inputs: tuple[np.ndarray, ...]
    outputs: tuple[np.ndarray, ...]
    tolerances: tuple[float, ...]

    @property
    def count(self) -> int:
        """Number of samples."""
        return len(self.outputs[0])


@dataclass(frozen=True)
class Language:
    """A language that programs are written in.

    emit: the whole text of a unit. package: the files of a unit with a self-test over vectors, by
    name. test: the command that runs the self-test in the files' folder; {name} is the function's
    word. dtypes: types of number that the text can be made for, the default first. note: what a
    reader of a package has to know.
    """

    emit: Callable[[Unit], str]
    package: Callable[[Unit, SelfTestSamples], dict[str, str]]
    test: str
    dtypes: tuple[str, ...] = ("float64",)
    note: str = ""


def numbered(*stems: str) -> frozenset[str]:
    """stem0, stem1, …: what a self-test calls its arrays, so that no function is called so."""
    return frozenset(f"{stem}{k}" for stem in stems for k in range(32))


def called(*tables: Mapping[str, str]) -> frozenset[str]:
    """Words of the functions that templates call or define, which nothing else may then be
    called."""
    return frozenset(
        word for table in tables for text in table.values() for word in _CALLED.findall(text)
    )


_CALLED = re.compile(r"([A-Za-z_][A-Za-z0-9_]*)(?:\{f\})?\(")


def number(value: float) -> str:
    """A double with all its digits, as most languages read it."""
    return repr(float(value))


def single(value: float, suffix: str = "") -> str:
    """The nearest float32 with as many digits as it takes."""
    with np.errstate(over="ignore"):
        nearest = np.float32(value)
    if isinf(nearest):
        raise FreebodyError(
            f"the number {value!r} of this robot is beyond the range of float32; use float64."
        )
    text = str(nearest)
    return f"{text if '.' in text or 'e' in text else f'{text}.0'}{suffix}"


def comment_block(unit: Unit, use: Iterable[str], begin: str, line: str, end: str) -> list[str]:
    """The comment at the head of a text: what is known of the unit, and how it is used in the
    language."""
    known = [*unit.comment, ""] if unit.comment else []
    listed = [f"{line} {text}".rstrip() for text in (*known, *use)]
    return [*([begin] if begin else []), *listed, *([end] if end else [])]


def flat(word: str, argument: Argument, position: int) -> str:
    """An entry by its position from 0 on; a scalar is its name."""
    return f"{word}[{position}]" if argument.shape else word


def helpers(program: Program, known: Mapping[str, str]) -> list[str]:
    """Texts of the helper functions that the program's operations need, in a fixed order."""
    return [text for op, text in known.items() if op in program.operations]


def number_lists(values: np.ndarray, spell: Callable[[float], str]) -> list[str]:
    """For each sample its numbers, separated by commas; one number stands for none, as C knows no
    empty array."""
    return [", ".join(map(spell, row)) or spell(0.0) for row in values.tolist()]


def largest_entries(vectors: SelfTestSamples) -> list[float]:
    """For each output the size that its differences are measured by."""
    return [float(abs(rows).max(initial=0.0)) or 1.0 for rows in vectors.outputs]
