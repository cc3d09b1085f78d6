"""Programs of the derivatives of a program: its nodes run over scalars with slopes, in a trace of
their own.

Derivatives are the ordinary partial ones by every entry of an input. A derivative is a program
again, so it has derivatives too.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import count
from typing import Any

from freebody.dual import Outer, slopes
from freebody.elementary import Scalar
from freebody.program.evaluate import evaluated, flat, free_prefix, nested
from freebody.program.program import Argument, Program
from freebody.program.tracer import trace


def jacobian(program: Program, by: Sequence[int]) -> Program:
    """The derivatives of each output by each of some inputs, at the same inputs.

    by: positions among the inputs. Outputs: of each output in turn one for each of these inputs,
    (*output, *input).
    """
    inputs = [program.inputs[k] for k in by]
    sizes = [argument.size for argument in inputs]

    def evaluate(*given: Any) -> tuple[Any, ...]:
        number = count()
        lifted = list(given)
        for k in by:
            lifted[k] = nested(
                [Outer(x, {next(number): 1.0}) for x in flat(given[k])], program.inputs[k].shape
            )
        tables = [
            [slopes(x, sum(sizes), Outer) for x in flat(result)]
            for result in evaluated(program, lifted)
        ]
        found = []
        for table, output in zip(tables, program.outputs, strict=True):
            start = 0
            for argument, size in zip(inputs, sizes, strict=True):
                entries = [s for row in table for s in row[start : start + size]]
                found.append(nested(entries, (*output.shape, *argument.shape)))
                start += size
        return tuple(found)

    return trace(f"{program.name}_jacobian", evaluate, program.inputs, slope_arguments(program, by))


def directional(program: Program, by: Sequence[int]) -> Program:
    """The rates of the outputs where some inputs change at given rates, which are the last inputs.

    by: positions of those that change. The length is in proportion to that of the program, whatever
    their sizes.
    """
    first, prefix = len(program.inputs), free_prefix("along", program.inputs)
    rates = tuple(Argument(f"{prefix}{k}", program.inputs[k].shape) for k in by)

    def evaluate(*given: Any) -> tuple[Any, ...]:
        lifted = list(given[:first])
        for k, along in zip(by, given[first:], strict=True):
            pairs = zip(flat(given[k]), flat(along), strict=True)
            lifted[k] = nested([Outer(x, {0: rate}) for x, rate in pairs], program.inputs[k].shape)
        return tuple(
            nested([slopes(x, 1, Outer)[0] for x in flat(result)], output.shape)
            for result, output in zip(evaluated(program, lifted), program.outputs, strict=True)
        )

    outputs = tuple(Argument(f"rate{k}", output.shape) for k, output in enumerate(program.outputs))
    return trace(f"{program.name}_along", evaluate, (*program.inputs, *rates), outputs)


def applied(
    table: Program, program: Program, by: Sequence[int], of: Sequence[int], count: int
) -> Program:
    """A Jacobian times so many vectors, which are the last inputs: rates of the inputs `by`,
    (count, *input), uniform.

    table: as `jacobian` of the program by these gives it. Outputs: those of the outputs `of`,
    (*output, count).
    """
    first, inputs = len(program.inputs), [program.inputs[k] for k in by]
    vectors = _vectors(program, inputs, count)

    def evaluate(*given: Any) -> tuple[Any, ...]:
        tables = _rows(table, program, by, given[:first])
        rates = [[x for nest in given[first:] for x in flat(nest[n])] for n in range(count)]
        return tuple(
            nested(
                [_dot(row, vector) for row in tables[k] for vector in rates],
                (*program.outputs[k].shape, count),
            )
            for k in of
        )

    outputs = tuple(Argument(f"rates{k}", (*program.outputs[k].shape, count)) for k in of)
    return trace(f"{table.name}_applied", evaluate, (*program.inputs, *vectors), outputs)


def applied_back(
    table: Program, program: Program, by: Sequence[int], of: Sequence[int], count: int
) -> Program:
    """The transpose of a Jacobian times so many vectors, weights of the outputs `of`, (count,
    *output).

    As `applied`; outputs: those of the inputs `by`, (count, *input).
    """
    first = len(program.inputs)
    vectors = _vectors(program, [program.outputs[k] for k in of], count)

    def evaluate(*given: Any) -> tuple[Any, ...]:
        tables = _rows(table, program, by, given[:first])
        rows = [row for k in of for row in tables[k]]
        weights = [[x for nest in given[first:] for x in flat(nest[n])] for n in range(count)]
        results, start = [], 0
        for k in by:
            argument = program.inputs[k]
            columns = list(zip(*(row[start : start + argument.size] for row in rows), strict=True))
            entries = [_dot(column, weight) for weight in weights for column in columns]
            results.append(nested(entries, (count, *argument.shape)))
            start += argument.size
        return tuple(results)

    outputs = tuple(Argument(f"slopes{k}", (count, *program.inputs[k].shape)) for k in by)
    return trace(f"{table.name}_applied_back", evaluate, (*program.inputs, *vectors), outputs)


def _vectors(program: Program, arguments: Sequence[Argument], count: int) -> list[Argument]:
    """Arguments for so many vectors of each of these arguments, as uniform inputs."""
    prefix = free_prefix("vectors", program.inputs)
    return [
        Argument(f"{prefix}{k}", (count, *x.shape), uniform=True) for k, x in enumerate(arguments)
    ]


def _rows(
    table: Program, program: Program, by: Sequence[int], given: Sequence[Any]
) -> list[list[Any]]:
    """The rows of each output's Jacobian, by all inputs `by` one after the other."""
    found = iter(evaluated(table, given))
    rows = []
    for output in program.outputs:
        scalars = [flat(next(found)) for _ in by]
        rows.append(
            [
                [
                    x
                    for entries, k in zip(scalars, by, strict=True)
                    for x in entries[i * program.inputs[k].size : (i + 1) * program.inputs[k].size]
                ]
                for i in range(output.size)
            ]
        )
    return rows


def _dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = total + x * y
    return total


def slope_arguments(program: Program, by: Sequence[int]) -> tuple[Argument, ...]:
    """The outputs of the Jacobian of a program by inputs at these positions."""
    return tuple(
        Argument(f"slope{i}_{k}", (*output.shape, *program.inputs[k].shape))
        for i, output in enumerate(program.outputs)
        for k in by
    )
