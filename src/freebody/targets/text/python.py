"""Program to a readable, pure Python function over NumPy or JAX arrays: source to keep, to read or to differentiate."""

from __future__ import annotations

from freebody.identifiers import identifiers
from freebody.program.program import Argument, Program, verify

MODULES = {"numpy": "numpy", "jax": "jax.numpy"}
"""Module that the text imports as `xp`, by language."""

EXPRESSION = {
    "neg": "-{a}",
    "sqrt": "sqrt({a})",
    "sin": "sin({a})",
    "cos": "cos({a})",
    "sign": "sign({a})",
    "add": "{a} + {b}",
    "sub": "{a} - {b}",
    "mul": "{a} * {b}",
    "div": "{a} / {b}",
    "exp": "xp.exp({a})",
    "log": "xp.log({a})",
    "tanh": "xp.tanh({a})",
    "atan2": "xp.arctan2({a}, {b})",
    "asin": "xp.arcsin({a})",
    "acos": "xp.arccos({a})",
    "absolute": "xp.absolute({a})",
    "less": "xp.where({a} < {b}, 1.0, 0.0)",
    "less_equal": "xp.where({a} <= {b}, 1.0, 0.0)",
    "equal": "xp.where({a} == {b}, 1.0, 0.0)",
    "where": "xp.where({a} != 0.0, {b}, {c})",
    "minimum": "xp.minimum({a}, {b})",
    "maximum": "xp.maximum({a}, {b})",
}

_OWN = ("xp", "cos", "sign", "sin", "sqrt", "batch")


def emit(program: Program, language: str) -> str:
    """Text of a function with the program's name: arrays (..., *core) that broadcast in, an array or a tuple out."""
    verify(program)  # its names are words
    own = {*_OWN, program.name, *(f"v{index}" for index in range(len(program)))}
    words = identifiers((argument.name for argument in program.inputs), own)
    names = {}
    lines = [
        f'"""{program}"""',
        "",
        f"import {MODULES[language]} as xp",
        f"from {MODULES[language]} import cos, sign, sin, sqrt",
        "",
        "",
        f"def {program.name}({', '.join(words.values())}):",
    ]
    entries = [
        f"{words[argument.name]}[..., {', '.join(map(str, index))}]"
        if argument.shape
        else words[argument.name]
        for argument in program.inputs
        for index in argument.indices()
    ]
    for index, op in enumerate(program.op):
        if op == "const":
            names[index] = repr(program.constants[program.a[index]])
            continue
        names[index] = f"v{index}"
        if op == "input":
            text = entries[program.a[index]]
        else:
            operands = dict(zip("abc", (names[i] for i in program.operands(index)), strict=False))
            text = EXPRESSION[op].format(**operands)
        lines.append(f"    {names[index]} = {text}")
    batches = ", ".join(_batch(argument, words[argument.name]) for argument in program.inputs)
    lines.append(f"    batch = xp.broadcast_shapes({batches})")
    returned, position = [], 0
    for argument in program.outputs:
        scalars = [names[i] for i in program.results[position : position + argument.size]]
        position += argument.size
        returned.append(_array(argument, scalars))
    lines.append(f"    return {', '.join(returned)}")
    return "\n".join(lines) + "\n"


def _batch(argument: Argument, word: str) -> str:
    return f"{word}.shape[:-{len(argument.shape)}]" if argument.shape else f"xp.shape({word})"


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
