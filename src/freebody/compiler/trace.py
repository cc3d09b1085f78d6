"""From a function over scalars to a program: run it once on nodes of a fresh graph."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

from freebody.compiler.program import Argument, Program, ProgramError, verify
from freebody.scalars.expr import ARITY, Expr, Graph


def trace(
    name: str,
    function: Callable[..., Any],
    inputs: Sequence[Argument],
    outputs: Sequence[Argument],
) -> Program:
    """The program of what `function` does to scalars.

    Args:
        name: name of the program, for messages and printing.
        function: called once with one nested tuple of scalars for each input (a bare scalar for shape ()); returns
            a sequence with one nested sequence of scalars or numbers for each output.
        inputs: names and core shapes of the arguments.
        outputs: names and core shapes of the results.

    Raises:
        ProgramError: if what the function returns does not have the shape of the outputs.
        GraphError: if the function branches on a value or mixes scalars of two traces.
    """
    graph = Graph()
    arguments = [_nested(graph, argument.name, argument.shape) for argument in inputs]
    returned = function(*arguments)
    if not isinstance(returned, (tuple, list)) or len(returned) != len(outputs):
        given = f"{len(returned)} values" if isinstance(returned, (tuple, list)) else type(returned).__name__
        raise ProgramError(
            f"{name}: the traced function returned {given}, expected a tuple with one entry for each output: "
            f"{', '.join(map(str, outputs))}."
        )
    results: list[int] = []
    for argument, value in zip(outputs, returned, strict=True):
        _flatten(graph, name, argument, argument.shape, value, results)
    return verify(_program(graph, name, tuple(inputs), tuple(outputs), results))


def _nested(graph: Graph, name: str, shape: tuple[int, ...], index: tuple[int, ...] = ()) -> Any:
    if not shape:
        return graph.input(f"{name}[{','.join(map(str, index))}]" if index else name)
    return tuple(_nested(graph, name, shape[1:], (*index, i)) for i in range(shape[0]))


def _flatten(
    graph: Graph, name: str, argument: Argument, shape: tuple[int, ...], value: Any, results: list[int]
) -> None:
    if not shape:
        index = graph.operand(value)
        if index < 0:
            raise ProgramError(f"{name}: output {argument} holds {_kind(value)} where a scalar was expected.")
        results.append(index)
        return
    if isinstance(value, Expr) or not hasattr(value, "__len__") or len(value) != shape[0]:
        raise ProgramError(
            f"{name}: output {argument} holds {_kind(value)} where a sequence of {shape[0]} was expected."
        )
    for entry in value:
        _flatten(graph, name, argument, shape[1:], entry, results)


def _kind(value: Any) -> str:
    if isinstance(value, Expr):
        return "a scalar"
    if hasattr(value, "__len__"):
        return f"a {type(value).__name__} of {len(value)}"
    return f"{type(value).__name__} {value!r}"


def _program(
    graph: Graph, name: str, inputs: tuple[Argument, ...], outputs: tuple[Argument, ...], results: list[int]
) -> Program:
    """The live part of a graph, renumbered; constants in order of their nodes."""
    live = bytearray(len(graph))
    for index in results:
        live[index] = 1
    for index in range(len(graph) - 1, -1, -1):
        if live[index]:
            arity = ARITY[graph.op[index]]
            if arity:
                live[graph.a[index]] = 1
            if arity == 2:
                live[graph.b[index]] = 1
    new, op, a, b, constants = [-1] * len(graph), [], [], [], []
    for index, alive in enumerate(live):
        if not alive:
            continue
        new[index] = len(op)
        kind = graph.op[index]
        arity = ARITY[kind]
        op.append(kind)
        if kind == "const":
            a.append(len(constants))
            constants.append(graph.constant_of[index])
        else:
            a.append(new[graph.a[index]] if arity else graph.a[index])
        b.append(new[graph.b[index]] if arity == 2 else -1)
    return Program(
        name, inputs, outputs, tuple(op), tuple(a), tuple(b), tuple(constants), tuple(new[i] for i in results)
    )
