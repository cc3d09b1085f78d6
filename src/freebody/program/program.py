"""Programs: straight-line arithmetic from named arrays to named arrays, as data that can be
checked, printed, and evaluated over any scalars."""

from __future__ import annotations

import hashlib
import struct
from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from math import isfinite, prod
from typing import Any

from freebody.elementary import FUNCTIONS, Scalar
from freebody.errors import FreebodyError
from freebody.identifiers import is_identifier
from freebody.lazy import cached_property
from freebody.outputs.display import Titled, counted
from freebody.scalars.operations import ARITY, OPERATIONS


class ProgramError(FreebodyError, ValueError):
    """Raised for a program that breaks its specification."""


@dataclass(frozen=True)
class Argument:
    """The name and core shape of an input or output; () is a scalar.

    The name is a word of freebody's own, never one from a file: it stands in generated text. A
    uniform input is one value for the whole batch: it is read, and what follows from it alone
    computed, once a call.
    """

    name: str
    shape: tuple[int, ...]
    uniform: bool = False

    @property
    def size(self) -> int:
        """Number of scalars of the argument."""
        return prod(self.shape)

    def indices(self) -> Iterator[tuple[int, ...]]:
        """The index of each scalar, in C order."""
        return product(*map(range, self.shape))

    def __str__(self) -> str:
        return f"{self.name}({', '.join(map(str, self.shape))})"


@dataclass(frozen=True, repr=False)
class Program(Titled):
    """A program: nodes (op, a, b, c), operands before their readers, and the nodes that are
    results.

    `a`, `b` and `c` index nodes, -1 where there is no operand; `c` may be left out where no
    operation has three. An "input" has in `a` its position among the scalars of all inputs (C
    order), a "const" its position in `constants`. `results` lists the node of each scalar of all
    outputs, in C order.
    """

    name: str
    inputs: tuple[Argument, ...]
    outputs: tuple[Argument, ...]
    op: tuple[str, ...]
    a: tuple[int, ...]
    b: tuple[int, ...]
    constants: tuple[float, ...]
    results: tuple[int, ...]
    c: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if not self.c:
            object.__setattr__(self, "c", (-1,) * len(self.op))

    def _title(self) -> str:
        given, found = (", ".join(map(str, some)) for some in (self.inputs, self.outputs))
        return f"Program {self.name!r}: {given} -> {found} in {counted(len(self.op), 'node')}"

    def __len__(self) -> int:
        return len(self.op)

    @cached_property
    def digest(self) -> str:
        """SHA-256 of the content, in hexadecimal."""
        head = repr((self.name, self.inputs, self.outputs, self.results)).encode()
        rows = zip(self.op, self.a, self.b, self.c, strict=True)
        body = "".join(f"{op} {a} {b} {c}\n" for op, a, b, c in rows).encode()
        numbers = struct.pack(f"<{len(self.constants)}d", *self.constants)
        digest = hashlib.sha256()
        for part in (head, body, numbers):
            digest.update(len(part).to_bytes(8, "little") + part)
        return digest.hexdigest()

    @cached_property
    def operations(self) -> dict[str, int]:
        """How often each arithmetic operation occurs."""
        return dict(Counter(op for op in self.op if ARITY[op]))

    @cached_property
    def uniform(self) -> tuple[bool, ...]:
        """For each node whether it depends on uniform inputs and constants alone, and so is the
        same for the whole batch."""
        scalars = [argument.uniform for argument in self.inputs for _ in range(argument.size)]
        found: list[bool] = []
        for index, op in enumerate(self.op):
            found.append(
                scalars[self.a[index]]
                if op == "input"
                else all(found[i] for i in self.operands(index))
            )
        return tuple(found)

    @property
    def input_size(self) -> int:
        """Number of scalars of all inputs."""
        return sum(argument.size for argument in self.inputs)

    @property
    def sampled_size(self) -> int:
        """Number of scalars of the inputs that are not uniform."""
        return sum(argument.size for argument in self.inputs if not argument.uniform)

    @property
    def output_size(self) -> int:
        """Number of scalars of all outputs."""
        return sum(argument.size for argument in self.outputs)

    def operands(self, index: int) -> tuple[int, ...]:
        """Indices of a node's operands."""
        return self._operands[index]

    @cached_property
    def _operands(self) -> tuple[tuple[int, ...], ...]:
        rows = zip(self.a, self.b, self.c, strict=True)
        return tuple([row[: ARITY[op]] for op, row in zip(self.op, rows, strict=True)])

    def listing(self) -> str:
        """The whole program, one node a line."""
        scalars = scalar_names(self.inputs)
        lines = [f"{self.name}: {_listed(self.inputs)} -> {_listed(self.outputs)}"]
        for index, op in enumerate(self.op):
            if op == "input":
                text = scalars[self.a[index]]
            elif op == "const":
                text = repr(self.constants[self.a[index]])
            else:
                text = " ".join([op, *(f"%{i}" for i in self.operands(index))])
            lines.append(f"  %{index} = {text}")
        lines += [
            f"  {name} = %{i}"
            for name, i in zip(scalar_names(self.outputs), self.results, strict=True)
        ]
        return "\n".join(lines)

    def __str__(self) -> str:
        counts = ", ".join(f"{count} {op}" for op, count in sorted(self.operations.items()))
        return (
            f"{self.name}: {_listed(self.inputs)} -> {_listed(self.outputs)}; "
            f"{counts or 'no operations'}"
        )


def scalar_names(arguments: tuple[Argument, ...]) -> list[str]:
    """`q[0]`, `M[0,1]`, … for each scalar of the arguments, in C order."""
    return [
        f"{argument.name}[{','.join(map(str, index))}]" if index else argument.name
        for argument in arguments
        for index in argument.indices()
    ]


def verify(program: Program) -> Program:
    """The program itself if it is valid; raises ProgramError otherwise.

    Raises
    ------
    ProgramError
        Naming the first broken rule: known operations, operands that precede, positions in range,
        finite constants, one result for each output scalar, sizes of at least 0, names used once,
        and names that are words: they stand in generated text, so that a name from outside must not
        get here.
    """

    def demand(truth: bool, rule: str) -> None:
        if not truth:
            raise ProgramError(f"{program.name}: {rule}.")

    for name in (program.name, *(argument.name for argument in program.inputs + program.outputs)):
        if not is_identifier(name):
            raise ProgramError(
                f"the name {name!r} in a program is not a word of letters a-z, digits and _."
            )
    for kind, arguments in (("inputs", program.inputs), ("outputs", program.outputs)):
        names = [argument.name for argument in arguments]
        demand(
            len(set(names)) == len(names), f"the names of {kind} are used once: {', '.join(names)}"
        )
    demand(len(program.outputs) > 0, "a program has at least one output")
    demand(
        not any(argument.uniform for argument in program.outputs), "an output belongs to a sample"
    )
    for argument in program.inputs + program.outputs:
        demand(all(size >= 0 for size in argument.shape), f"{argument} has a negative size")
    count = len(program.op)
    columns = (program.a, program.b, program.c)
    demand(all(len(x) == count for x in columns), "op, a, b and c have one entry a node")
    for index in range(count):
        if fault := _fault(program, index):
            raise ProgramError(f"{program.name}: {fault}.")
    demand(all(isfinite(value) for value in program.constants), "constants are finite")
    demand(
        len(program.results) == program.output_size,
        f"{program.output_size} output scalars need as many results",
    )
    demand(all(0 <= index < count for index in program.results), "a result is a node")
    return program


def _fault(program: Program, index: int) -> str:
    """The fault of one node in words; "" if it has none."""
    op, row = program.op[index], (program.a[index], program.b[index], program.c[index])
    if op not in ARITY:
        return f"%{index}: unknown operation {op!r}; known: {', '.join(ARITY)}"
    arity = ARITY[op]
    if not arity:
        what, most = (
            ("input", program.input_size) if op == "input" else ("constant", len(program.constants))
        )
        return (
            ""
            if 0 <= row[0] < most and row[1:] == (-1, -1)
            else f"%{index}: {what} {row[0]} of {most}"
        )
    if not 0 <= min(row[:arity]) <= max(row[:arity]) < index:
        return (
            f"%{index} = {op} {' '.join(f'%{i}' for i in row[:arity])}: an operand precedes its use"
        )
    if row[arity:].count(-1) < len(row) - arity:
        return f"%{index} = {op}: it has {arity} operands, what is left of (a, b, c) = {row} is -1"
    return ""


def _listed(arguments: tuple[Argument, ...]) -> str:
    return ", ".join(map(str, arguments))


VALUES: dict[str, Callable[..., Scalar]] = {
    name: FUNCTIONS.get(name, record.number) for name, record in OPERATIONS.items()
}
"""Each operation over any scalar; those of arithmetic are Python's own."""


def evaluated(program: Program, inputs: Sequence[Any]) -> tuple[Any, ...]:
    """The outputs as nested tuples, from inputs that are nested tuples of any scalars."""
    held = values(program, inputs)
    results, start = [], 0
    for argument in program.outputs:
        part = program.results[start : start + argument.size]
        results.append(nested([held[i] for i in part], argument.shape))
        start += argument.size
    return tuple(results)


def values(program: Program, inputs: Sequence[Any]) -> list[Scalar]:
    """The value of every node, from inputs that are nested tuples of any scalars."""
    scalars = [x for nest in inputs for x in flat(nest)]
    held: list[Scalar] = []
    for index, op in enumerate(program.op):
        if op == "input":
            held.append(scalars[program.a[index]])
        elif op == "const":
            held.append(program.constants[program.a[index]])
        else:
            held.append(VALUES[op](*(held[i] for i in program.operands(index))))
    return held


def free_prefix(prefix: str, arguments: Sequence[Argument]) -> str:
    """The prefix, extended by underscores until no argument's name begins with it."""
    while any(argument.name.startswith(prefix) for argument in arguments):
        prefix += "_"
    return prefix


def flat(nest: Any) -> list[Scalar]:
    """The scalars of nested tuples, in C order."""
    return [x for part in nest for x in flat(part)] if isinstance(nest, tuple) else [nest]


def nested(scalars: Sequence[Scalar], shape: tuple[int, ...]) -> Any:
    """Scalars in C order as nested tuples of a shape."""
    if not shape:
        return scalars[0]
    step = len(scalars) // shape[0] if shape[0] else 0
    return tuple(nested(scalars[k * step : (k + 1) * step], shape[1:]) for k in range(shape[0]))
