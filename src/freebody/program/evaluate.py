"""Evaluation of a program over any scalars, node by node from inputs to outputs."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from freebody.elementary import FUNCTIONS, Scalar
from freebody.program.program import Argument, Program
from freebody.scalars.operations import OPERATIONS

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
