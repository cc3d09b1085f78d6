"""A computation of a page as JavaScript, with states at which Python has computed it too: a page
proves itself by them before it offers anything."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.outputs.page_script import packed_numbers
from freebody.program import Argument, Program
from freebody.targets.interpreter import BlockedFunction
from freebody.targets.text import LANGUAGES, SourceUnit


@dataclass(frozen=True)
class PageKernel:
    """A program that a page runs as the JavaScript function of its name."""

    name: str
    program: Program

    @property
    def script(self) -> str:
        """The function's JavaScript text: inputs, then outputs, all arrays but single numbers among
        the inputs."""
        return LANGUAGES["javascript-script"].emit(SourceUnit(self.program, self.name))

    def __call__(self, given: Mapping[str, Array]) -> tuple[Array, ...]:
        """The outputs for inputs by name, computed by NumPy."""
        found = BlockedFunction(self.program)(*(given[x.name] for x in self.program.inputs))
        return found if isinstance(found, tuple) else (found,)

    def proof(self, given: Mapping[str, Array]) -> dict[str, Any]:
        """Python's own results at several states as a page reads them: the sizes of inputs (0: a
        single number) and outputs, and the rows of all numbers, inputs first."""
        inputs, outputs = self.program.inputs, self.program.outputs
        columns = [_rows(x, given[x.name]) for x in inputs]
        columns += [_rows(x, y) for x, y in zip(outputs, self(given), strict=True)]
        return {
            "inputs": [x.size if x.shape else 0 for x in inputs],
            "outputs": [x.size for x in outputs],
            "rows": packed_numbers(np.concatenate(columns, axis=-1)),
        }


def _rows(argument: Argument, values: Array) -> Array:
    """Values of an argument, a row for each state."""
    return np.asarray(values, dtype=float).reshape(len(values), argument.size)
