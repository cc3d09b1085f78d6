"""Program to a readable, pure Python function over NumPy or JAX arrays: source to keep, to read or to differentiate."""

from __future__ import annotations

import re

from freebody.compiler.emit_numpy import EXPRESSION
from freebody.compiler.program import Argument, Program, scalar_names
from freebody.scalars.expr import ARITY

MODULES = {"numpy": "numpy", "jax": "jax.numpy"}
"""Module that the text imports as `xp`, by language."""


def emit(program: Program, language: str, function: str) -> str:
    """Text of `function(*inputs)`: arrays (..., *core) that broadcast in, one array or a tuple of arrays out."""
    names = {}
    lines = [
        f'"""{program}"""',
        "",
        f"import {MODULES[language]} as xp",
        "from " + MODULES[language] + " import cos, sign, sin, sqrt",
        "",
        "",
        f"def {function}({', '.join(map(_variable, program.inputs))}):",
    ]
    entries = [
        _entry(argument, scalar) for argument in program.inputs for scalar in scalar_names((argument,))
    ]
    for index, op in enumerate(program.op):
        if op == "const":
            names[index] = repr(program.constants[program.a[index]])
            continue
        names[index] = f"v{index}"
        if op == "input":
            text = entries[program.a[index]]
        else:
            a, b = program.a[index], program.b[index]
            text = EXPRESSION[op].format(a=names[a], b=names[b] if ARITY[op] == 2 else "")
        lines.append(f"    {names[index]} = {text}")
    batches = ", ".join(_batch(argument) for argument in program.inputs)
    lines.append(f"    batch = xp.broadcast_shapes({batches})")
    returned, position = [], 0
    for argument in program.outputs:
        scalars = [names[i] for i in program.results[position : position + argument.size]]
        position += argument.size
        returned.append(_array(argument, scalars))
    lines.append(f"    return {', '.join(returned)}")
    return "\n".join(lines) + "\n"


def _variable(argument: Argument) -> str:
    """The argument's name as a Python one; a wrench's is that of its frame, which may be any text."""
    return argument.name if argument.name.isidentifier() else re.sub(r"\W", "_", argument.name)


def _entry(argument: Argument, scalar: str) -> str:
    """`q[..., 2]` for the scalar `q[2]`."""
    name = _variable(argument)
    return f"{name}[..., {scalar[scalar.rindex('[') + 1 :]}" if argument.shape else name


def _batch(argument: Argument) -> str:
    name = _variable(argument)
    return f"{name}.shape[:-{len(argument.shape)}]" if argument.shape else f"xp.shape({name})"


def _array(argument: Argument, scalars: list[str]) -> str:
    if not argument.shape:
        return f"xp.broadcast_to({scalars[0]}, batch)"
    listed = ", ".join(f"xp.broadcast_to({s}, batch)" for s in scalars)
    stacked = f"xp.stack([{listed}], axis=-1)"
    return (
        stacked
        if len(argument.shape) == 1
        else f"{stacked}.reshape(*batch, {', '.join(map(str, argument.shape))})"
    )
