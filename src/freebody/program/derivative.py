"""Derivatives of a program as programs: forward mode, by dual scalars in a trace of their own; and
the gradient in reverse mode, a few times as long as the program whatever the number of inputs.

Derivatives are the ordinary partial ones by every entry of an input. A derivative is a program
again, so it has derivatives too.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from itertools import count
from math import prod
from typing import Any, NamedTuple

from freebody.dual import Outer, slopes, value
from freebody.elementary import CHOOSES, Scalar, maximum, where
from freebody.program.program import (
    VALUES,
    Argument,
    Program,
    evaluated,
    flat,
    free_prefix,
    nested,
    values,
)
from freebody.program.tracer import trace


class Directions(NamedTuple):
    """Directions along which an input is differentiated: their shape, and a function from the
    input's value to the rates of its scalars (rows) along each; None: each scalar is a direction of
    its own."""

    shape: tuple[int, ...]
    rates: Callable[[Any], Sequence[Sequence[Scalar]]] | None = None


def differentiated(program: Program, by: Mapping[int, Directions]) -> Program:
    """A program of the given program's outputs followed by their derivatives by some inputs, called
    dy_dx, (*output, *directions).

    by: directions by positions among the inputs.
    """
    slopes = tuple(
        Argument(f"d{y.name}_d{program.inputs[k].name}", (*y.shape, *directions.shape))
        for y in program.outputs
        for k, directions in by.items()
    )

    def evaluate(*given: Any) -> tuple[Any, ...]:
        results, found = _with_slopes(program, by, given)
        return (*results, *found)

    return trace(program.name, evaluate, program.inputs, (*program.outputs, *slopes))


def jacobian(program: Program, by: Sequence[int]) -> Program:
    """A program of the derivatives of each output by each of some inputs, with the same inputs.

    by: positions among the inputs. Outputs: of each output in turn one for each of these inputs,
    (*output, *input).
    """
    directions = {k: Directions(program.inputs[k].shape) for k in by}

    def evaluate(*given: Any) -> tuple[Any, ...]:
        return _with_slopes(program, directions, given)[1]

    return trace(f"{program.name}_jacobian", evaluate, program.inputs, slope_arguments(program, by))


def _with_slopes(
    program: Program, by: Mapping[int, Directions], given: Sequence[Any]
) -> tuple[tuple[Any, ...], tuple[Any, ...]]:
    """The outputs, and for each in turn its derivatives by each of some inputs."""
    lifted, number = list(given), count()
    for k, directions in by.items():
        ways = [next(number) for _ in range(prod(directions.shape))]
        rows = None if directions.rates is None else directions.rates(given[k])
        slopes_of = (
            ({way: 1.0} for way in ways)
            if rows is None
            else (dict(zip(ways, column, strict=True)) for column in zip(*rows, strict=True))
        )
        scalars = zip(flat(given[k]), slopes_of, strict=True)
        lifted[k] = nested([Outer(x, of) for x, of in scalars], program.inputs[k].shape)
    results, found, total = [], [], next(number)
    for result, output in zip(evaluated(program, lifted), program.outputs, strict=True):
        scalars, start = flat(result), 0
        table = [slopes(x, total, Outer) for x in scalars]
        results.append(nested([value(x, Outer) for x in scalars], output.shape))
        for directions in by.values():
            end = start + prod(directions.shape)
            entries = [s for row in table for s in row[start:end]]
            found.append(nested(entries, (*output.shape, *directions.shape)))
            start = end
    return tuple(results), tuple(found)


def directional(program: Program, by: Sequence[int]) -> Program:
    """A program of the outputs' rates when some inputs change at given rates, which are its last
    inputs.

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
    """A program of a Jacobian times `count` vectors, which are its last inputs: rates of the inputs
    `by`, (count, *input), uniform.

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
    """A program of the transpose of a Jacobian times `count` vectors, weights of the outputs `of`,
    (count, *output).

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
    """Uniform inputs for `count` vectors of each of the given arguments."""
    prefix = free_prefix("vectors", program.inputs)
    return [
        Argument(f"{prefix}{k}", (count, *x.shape), uniform=True) for k, x in enumerate(arguments)
    ]


def _rows(
    table: Program, program: Program, by: Sequence[int], given: Sequence[Any]
) -> list[list[Any]]:
    """The rows of each output's Jacobian by all inputs `by`, one after the other."""
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


def gradient(program: Program, by: Sequence[int], of: Sequence[int]) -> Program:
    """A program of the partial derivatives of Σ w·y by some inputs, over outputs y with weights w,
    which are its last inputs.

    by: positions of the inputs by which is differentiated; of: of the outputs that have weights, of
    their shapes. Outputs: one for each of the inputs `by`, of its shape.
    """
    wanted = [program.inputs[k] for k in by]
    first, prefix = len(program.inputs), free_prefix("weight", program.inputs)
    weights = tuple(Argument(f"{prefix}{k}", program.outputs[k].shape) for k in of)

    def evaluate(*given: Any) -> tuple[Any, ...]:
        found = values(program, given[:first])
        seeds = dict(zip(of, map(flat, given[first:]), strict=True))
        rest = iter(_gradient(program, found, by, seeds))
        return tuple(
            nested([next(rest) for _ in range(argument.size)], argument.shape)
            for argument in wanted
        )

    outputs = tuple(Argument(f"slope{k}", program.inputs[k].shape) for k in by)
    return trace(f"{program.name}_gradient", evaluate, (*program.inputs, *weights), outputs)


def _gradient(
    program: Program, found: list[Scalar], by: Sequence[int], weights: dict[int, list[Scalar]]
) -> list[Scalar]:
    """The gradient by reverse mode, from the results back to the inputs: each node's weight is the
    sum of what its readers pass on."""
    weight: list[Scalar] = [0.0] * len(program)
    counts: list[Scalar] = [0.0] * len(program)
    start = 0
    for k, argument in enumerate(program.outputs):
        for at, given in enumerate(weights.get(k, ())):
            node = program.results[start + at]
            weight[node], counts[node] = weight[node] + given, 1.0
        start += argument.size
    places = _places(program.inputs, by)
    moves = _depends(program, set(places))
    for index in range(len(program) - 1, -1, -1):
        if not moves[index] or _is(counts[index], 0.0) or program.op[index] == "input":
            continue
        for operand, partial, share in _partials(program, index, found, moves, counts[index]):
            weight[operand] = weight[operand] + partial * weight[index]
            counts[operand] = _either(counts[operand], share)
    gradient: dict[int, Scalar] = {
        program.a[i]: weight[i] for i, op in enumerate(program.op) if op == "input"
    }
    return [gradient.get(place, 0.0) for place in places]


def _partials(
    program: Program, index: int, found: list[Scalar], moves: list[bool], counts: Scalar
) -> list[tuple[int, Scalar, Scalar]]:
    """Triples for a node: an operand that depends on the inputs, the partial derivative by it, and
    whether that counts (1, or a scalar that is 0 or 1).

    Behind a choice only what was chosen counts: the derivative of what was not may be infinite, and
    0 times that is no number. So derivatives are chosen, not weighted.
    """
    operands = program.operands(index)
    chooses = CHOOSES.get(program.op[index])
    if chooses is not None:
        condition = chooses(*(found[i] for i in operands))
        a, b = operands[-2:]
        ways = ((a, where(condition, 1.0, 0.0), where(condition, counts, 0.0)),)
        ways += ((b, where(condition, 0.0, 1.0), where(condition, 0.0, counts)),)
        return [way for way in ways if moves[way[0]]]
    seeded = [Outer(found[i], {k: 1.0}) if moves[i] else found[i] for k, i in enumerate(operands)]
    partials = slopes(VALUES[program.op[index]](*seeded), len(operands), Outer)
    return [
        (
            i,
            partial
            if _is(counts, 1.0) or isinstance(partial, float)
            else where(counts, partial, 0.0),
            counts,
        )
        for i, partial in zip(operands, partials, strict=True)
        if moves[i] and not _is(partial, 0.0)
    ]


def _depends(program: Program, places: set[int]) -> list[bool]:
    """For each node whether it depends on the input scalars at these places."""
    found: list[bool] = []
    for index, op in enumerate(program.op):
        if op == "input":
            found.append(program.a[index] in places)
        else:
            found.append(any(found[i] for i in program.operands(index)))
    return found


def _places(inputs: Sequence[Argument], by: Sequence[int]) -> list[int]:
    """Positions of the scalars of these inputs among those of all."""
    starts = [0]
    for argument in inputs:
        starts.append(starts[-1] + argument.size)
    return [place for k in by for place in range(starts[k], starts[k + 1])]


def _either(a: Scalar, b: Scalar) -> Scalar:
    if _is(a, 0.0) or _is(b, 1.0):
        return b
    return a if _is(a, 1.0) or _is(b, 0.0) else maximum(a, b)


def _is(x: Scalar, number: float) -> bool:
    """Whether a scalar is a given number by structure."""
    return isinstance(x, float) and x == number
