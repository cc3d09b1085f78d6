"""The program of a program's gradient: in reverse mode, a few times as long as the program whatever
it has inputs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from freebody.dual import Outer, slopes
from freebody.elementary import CHOOSES, Scalar, maximum, where
from freebody.program.evaluate import VALUES, flat, free_prefix, nested, values
from freebody.program.program import Argument, Program
from freebody.program.tracer import trace


def gradient(program: Program, by: Sequence[int], of: Sequence[int]) -> Program:
    """The ordinary partial derivatives of Σ w·y, over outputs y with weights w, which are the last
    inputs.

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
    """From the results back to the inputs: each node's weight is what its readers pass on to it."""
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
    """Partial derivatives of a node: the operands that move, the derivative by each, and whether it
    counts (1, or a scalar that is 0 or 1).

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
    """For each node whether it follows from the input scalars at these places."""
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
    """Whether it is that number, by structure."""
    return isinstance(x, float) and x == number
