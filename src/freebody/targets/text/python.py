"""Programs as Python: a pure function over NumPy or JAX arrays, and one that builds a CasADi
function."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from freebody.program.program import Argument
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    flat,
    helpers,
    number,
)
from freebody.targets.text.statements import ProgramWords, Spelling, lines, statements, words_of

_IMPORTED = ("cos", "sign", "sin", "sqrt")
_FUNCTIONS = {op: f"{op}({{a}})" for op in _IMPORTED} | {
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
    "epsilon": "xp.finfo(xp.result_type({a})).eps",
}
_CASADI = {op: f"ca.{op}({{a}})" for op in (*_IMPORTED, "exp", "log", "tanh", "asin", "acos")} | {
    "absolute": "ca.fabs({a})",
    "atan2": "ca.atan2({a}, {b})",
    "less": "({a} < {b})",
    "less_equal": "({a} <= {b})",
    "equal": "({a} == {b})",
    "where": "ca.if_else({a} != 0.0, {b}, {c})",
    "minimum": "min_of({a}, {b})",
    "maximum": "max_of({a}, {b})",
    "epsilon": number(2.0**-52),
}
_CASADI_HELPERS = {
    op: f"def {name}(a, b):\n"
    f"    return ca.if_else({first}, a, ca.if_else({second}, b, a + b))\n\n\n"
    for op, name, first, second in (
        ("minimum", "min_of", "a <= b", "b < a"),
        ("maximum", "max_of", "b <= a", "a < b"),
    )
}
"""NaN that arises on the way stays; CasADi takes `a != a` for false whatever a is."""
_TEST = "python {name}_test.py"
_OWN = frozenset(
    ("np", "sys", "jax", "numpy", "casadi", "xp", "ca", "batch", "min_of", "max_of", *_IMPORTED)
)


def _indexed(word: str, argument: Argument, position: int) -> str:
    if not argument.shape:
        return word
    index = np.unravel_index(position, argument.shape)
    return f"{word}[..., {', '.join(str(int(i)) for i in index)}]"


_ARRAYS = Spelling(
    _FUNCTIONS,
    number,
    _indexed,
    flat,
    "{word} = {text}",
    "{word} = {text}",
    "# {text}",
    inputs_first=True,
)
_SCALARS = Spelling(
    _CASADI,
    number,
    lambda word, argument, k: f"{word}[{k // _columns(argument)}, {k % _columns(argument)}]",
    flat,
    "{word} = {text}",
    "{word} = {text}",
    "# {text}",
)


def _columns(argument: Argument) -> int:
    """The number of columns of an argument in CasADi, which has two dimensions: the last two of
    three are merged."""
    return int(np.prod(argument.shape[1:]))


def _in_casadi(argument: Argument) -> tuple[int, int]:
    """The shape of an argument in CasADi, where vectors are columns."""
    return (*argument.shape, 1)[0], _columns(argument)


def _in_arrays(argument: Argument) -> tuple[int, ...]:
    return argument.shape


def _computed(
    unit: SourceUnit, words: ProgramWords, spelling: Spelling
) -> tuple[list[str], list[list[str]]]:
    """The lines that compute, and for each output the texts of its scalars."""
    done = statements(unit, words, spelling, _OWN)
    inner = [statement for statement in done if not statement.writes]
    results = iter([statement.text for statement in done if statement.writes])
    return lines(inner, spelling, "    "), [
        [next(results) for _ in range(a.size)] for a in unit.program.outputs
    ]


def _docstring(unit: SourceUnit) -> list[str]:
    comment = unit.comment or (str(unit.program),)
    return [f'"""{comment[0]}', *(["", *comment[1:]] if len(comment) > 1 else []), '"""']


def _emit_arrays(module: str, unit: SourceUnit) -> str:
    """Python text of a function of arrays (..., *core) that broadcast, which returns an array or a
    tuple."""
    words, program = words_of(unit, _OWN), unit.program
    body, results = _computed(unit, words, _ARRAYS)
    batches = [_batch(a, word) for word, a in zip(words.inputs, program.inputs, strict=True)]
    returned = [_array(a, scalars) for a, scalars in zip(program.outputs, results, strict=True)]
    return "\n".join(
        [
            *_docstring(unit),
            "",
            f"import {module} as xp",
            f"from {module} import {', '.join(_IMPORTED)}",
            "",
            "",
            f"def {words.function}({', '.join(words.inputs)}):",
            *body,
            f"    batch = xp.broadcast_shapes({', '.join(batches)})",
            f"    return {', '.join(returned)}\n",
        ]
    )


def _batch(argument: Argument, word: str) -> str:
    return f"{word}.shape[:-{len(argument.shape)}]" if argument.shape else f"xp.shape({word})"


def _array(argument: Argument, scalars: list[str]) -> str:
    if not argument.shape:
        return f"xp.broadcast_to({scalars[0]}, batch)"
    shape = ", ".join(map(str, argument.shape))
    if not scalars:
        return f"xp.zeros((*batch, {shape}))"
    listed = ", ".join(f"xp.broadcast_to({s}, batch)" for s in scalars)
    stacked = f"xp.stack([{listed}], axis=-1)"
    return stacked if len(argument.shape) == 1 else f"{stacked}.reshape(*batch, {shape})"


def _emit_casadi(unit: SourceUnit) -> str:
    """Python text of a function without arguments that builds a casadi.Function of columns and
    matrices."""
    words, program = words_of(unit, _OWN), unit.program
    body, results = _computed(unit, words, _SCALARS)
    symbols = [
        f'    {word} = ca.SX.sym("{word}", {", ".join(map(str, _in_casadi(a)))})'
        for word, a in zip(words.inputs, program.inputs, strict=True)
    ]
    outs = [_matrix(a, scalars) for a, scalars in zip(program.outputs, results, strict=True)]
    names = (", ".join(f'"{word}"' for word in listed) for listed in (words.inputs, words.outputs))
    return "\n".join(
        [
            *_docstring(unit),
            "",
            "import casadi as ca\n\n",
            *(text.rstrip("\n") + "\n\n" for text in helpers(program, _CASADI_HELPERS)),
            f"def {words.function}():",
            *symbols,
            *body,
            f'    return ca.Function("{words.function}", [{", ".join(words.inputs)}], '
            f"[{', '.join(outs)}], "
            f"[{next(names)}], [{next(names)}])\n",
        ]
    )


def _matrix(argument: Argument, scalars: Sequence[str]) -> str:
    rows, width = _in_casadi(argument)
    if not scalars:
        return f"ca.SX({rows}, {width})"
    if width == 1:
        return f"ca.vertcat({', '.join(scalars)})"
    listed = (", ".join(scalars[k * width : (k + 1) * width]) for k in range(rows))
    return f"ca.vertcat({', '.join(f'ca.horzcat({row})' for row in listed)})"


def _package(
    emit: Callable[[SourceUnit], str],
    prelude: Sequence[str],
    function: str,
    shaped: Callable[[Argument], tuple[int, ...]],
    unit: SourceUnit,
    vectors: SelfTestSamples,
) -> dict[str, str]:
    """The module and its self-test, by file name; function: the call with one sample, where {name}
    is the module's function; shaped: the shape of an argument's sample there."""
    words = words_of(unit, _OWN)
    shapes = [shaped(a) for a in (*unit.program.inputs, *unit.program.outputs)]
    tables = [repr(rows.tolist()) for rows in (*vectors.inputs, *vectors.outputs)]
    arrays = [
        f"    np.array({table}).reshape({(vectors.count, *shape)!r}),"
        for table, shape in zip(tables, shapes, strict=True)
    ]
    test = [
        "import sys",
        "",
        "import numpy as np",
        *prelude,
        f"from {words.function} import {words.function}",
        "",
        "GIVEN = [",
        *arrays[: len(words.inputs)],
        "]",
        "EXPECTED = [",
        *arrays[len(words.inputs) :],
        "]",
        f"bad, f = False, {function.format(name=words.function)}",
        f"found = [f(*(x[i] for x in GIVEN)) for i in range({vectors.count})]",
        *(["found = [(x,) for x in found]"] if len(words.outputs) == 1 else []),
        f"names, allowed = {list(words.outputs)!r}, {list(vectors.tolerances)!r}",
        "for k, expected in enumerate(EXPECTED):",
        "    got = np.array([x[k] for x in found])",
        "    if got.shape != expected.shape:",
        '        print(f"{names[k]}: of shape {got.shape[1:]}; expected {expected.shape[1:]}")',
        "        bad = True",
        "        continue",
        "    off = np.abs(got - expected).max(initial=0.0) / (np.abs(expected).max(initial=0.0) or "
        "1.0)",
        '    print(f"{names[k]}: off by at most {off:.2g} of its largest entry; '
        'allowed {allowed[k]:.2g}")',
        "    bad = bad or not off <= allowed[k]",
        'print("FAILED" if bad else "passed")',
        "sys.exit(bad)",
    ]
    return {f"{words.function}.py": emit(unit), f"{words.function}_test.py": "\n".join(test) + "\n"}


NUMPY = Language(
    partial(_emit_arrays, "numpy"),
    partial(_package, partial(_emit_arrays, "numpy"), (), "{name}", _in_arrays),
    _TEST,
)
JAX = Language(
    partial(_emit_arrays, "jax.numpy"),
    partial(
        _package,
        partial(_emit_arrays, "jax.numpy"),
        ("import jax", 'jax.config.update("jax_enable_x64", True)'),
        "{name}",
        _in_arrays,
    ),
    _TEST,
)
CASADI = Language(_emit_casadi, partial(_package, _emit_casadi, (), "{name}()", _in_casadi), _TEST)
