"""What follows from uniform inputs alone is computed once a call: a program in two parts."""

from __future__ import annotations

from dataclasses import replace

from freebody.program.passes import drop_dead
from freebody.program.program import Argument, Program
from freebody.scalars.operations import ARITY


def hoist(program: Program) -> tuple[Program, Program]:
    """What is computed once a call, and what is computed for every sample.

    The first has what were the uniform inputs, and one output: what it computes of them. The second
    has the other inputs, and one uniform input, the last: the scalars of the uniform ones, then
    that output.
    """
    uniform = program.uniform
    place = _places(program)
    known = sum(x.size for x in program.inputs if x.uniform)
    read = {
        operand
        for index, once in enumerate(uniform)
        if not once
        for operand in program.operands(index)
    }
    read.update(program.results)
    handed = [
        index
        for index, op in enumerate(program.op)
        if uniform[index] and ARITY[op] and index in read
    ]
    number = {index: known + k for k, index in enumerate(handed)}
    once = replace(
        program,
        name=f"{program.name}_once",
        inputs=tuple(replace(x, uniform=False) for x in program.inputs if x.uniform),
        outputs=(Argument("computed", (len(handed),)),),
        a=tuple(
            place[a] if op == "input" else a for op, a in zip(program.op, program.a, strict=True)
        ),
        results=tuple(handed),
    )
    sampled = [x for x in program.inputs if not x.uniform]
    first = sum(x.size for x in sampled)
    op, a, b, c = list(program.op), list(program.a), list(program.b), list(program.c)
    for index in range(len(program)):
        if index in number:
            op[index], a[index], b[index], c[index] = "input", first + number[index], -1, -1
        elif op[index] == "input":
            a[index] = place[a[index]] + first * uniform[index]
    every = replace(
        program,
        inputs=(*sampled, Argument("uniform", (known + len(handed),), uniform=True)),
        op=tuple(op),
        a=tuple(a),
        b=tuple(b),
        c=tuple(c),
    )
    return drop_dead(once), drop_dead(every)


def _places(program: Program) -> list[int]:
    """For each scalar of the inputs its place among those of the uniform ones, or among those of
    the others."""
    sizes, places = {False: 0, True: 0}, []
    for argument in program.inputs:
        for _ in range(argument.size):
            places.append(sizes[argument.uniform])
            sizes[argument.uniform] += 1
    return places
