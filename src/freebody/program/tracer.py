"""Tracing: a function over scalars, run once on nodes of a fresh graph, becomes a program."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from freebody.program.passes import drop_dead
from freebody.program.program import Argument, Program, ProgramError, verify
from freebody.scalars.expr import Expr, Graph


def trace(
    name: str,
    function: Callable[..., Any],
    inputs: Sequence[Argument],
    outputs: Sequence[Argument] | None,
) -> Program:
    """The program of a function: what it does to the scalars of its inputs.

    Parameters
    ----------
    name
        Name of the program, for messages and printing.
    function
        Called once with one nested tuple of scalars for each input (a bare scalar for shape ());
        returns a sequence with one nested sequence of scalars or numbers for each output, or arrays
        of objects.
    inputs
        Names and core shapes of the arguments.
    outputs
        Names and core shapes of the results; None: the function returns {name: array of objects},
        which says.

    Raises
    ------
    ProgramError
        If what the function returns does not have the shape of the outputs.
    GraphError
        If the function branches on a value or mixes scalars of two traces.
    """
    graph = Graph()
    arguments = [_nested(graph, argument.name, argument.shape) for argument in inputs]
    returned = function(*arguments)
    if outputs is None:
        outputs = [Argument(label, array.shape) for label, array in returned.items()]
        returned = tuple(returned.values())
    if not isinstance(returned, (tuple, list)) or len(returned) != len(outputs):
        given = (
            f"{len(returned)} values"
            if isinstance(returned, (tuple, list))
            else type(returned).__name__
        )
        raise ProgramError(
            f"{name}: the traced function returned {given}, expected a tuple with one entry for "
            f"each output: {', '.join(map(str, outputs))}."
        )
    results: list[int] = []
    for argument, value in zip(outputs, returned, strict=True):
        _flatten(graph, name, argument, argument.shape, value, results)
    program = Program(
        name,
        tuple(inputs),
        tuple(outputs),
        op=tuple(graph.op),
        a=tuple(graph.a),
        b=tuple(graph.b),
        c=tuple(graph.c),
        constants=tuple(graph.values),
        results=tuple(results),
    )
    return verify(drop_dead(program))


def _nested(graph: Graph, name: str, shape: tuple[int, ...], index: tuple[int, ...] = ()) -> Any:
    if not shape:
        return graph.input(f"{name}[{','.join(map(str, index))}]" if index else name)
    return tuple(_nested(graph, name, shape[1:], (*index, i)) for i in range(shape[0]))


def _flatten(
    graph: Graph,
    name: str,
    argument: Argument,
    shape: tuple[int, ...],
    value: Any,
    results: list[int],
) -> None:
    if isinstance(value, np.ndarray):
        value = value.tolist()  # of no axes: its one entry
    if not shape:
        index = graph.operand(value)
        if index < 0:
            raise ProgramError(
                f"{name}: output {argument} holds {_kind(value)} where a scalar was expected."
            )
        results.append(index)
        return
    if isinstance(value, Expr) or not hasattr(value, "__len__") or len(value) != shape[0]:
        raise ProgramError(
            f"{name}: output {argument} holds {_kind(value)} where a sequence of {shape[0]} was "
            f"expected."
        )
    for entry in value:
        _flatten(graph, name, argument, shape[1:], entry, results)


def _kind(value: Any) -> str:
    if isinstance(value, Expr):
        return "a scalar"
    if hasattr(value, "__len__"):
        return f"a {type(value).__name__} of {len(value)}"
    return f"{type(value).__name__} {value!r}"
