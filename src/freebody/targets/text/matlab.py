"""Programs as MATLAB and Octave: a function file."""

from __future__ import annotations

import numpy as np

from freebody.identifiers import word_set
from freebody.program.program import Argument
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    called,
    comment_block,
    helpers,
    largest_entries,
    number,
    numbered,
)
from freebody.targets.text.statements import ProgramWords, Spelling, lines, statements, words_of

_ONE = ("sin", "cos", "exp", "tanh", "sign")
_PARTIAL = {"sqrt": "x >= 0", "log": "x >= 0", "asin": "abs(x) <= 1", "acos": "abs(x) <= 1"}
"""Functions that are complex outside of a condition, where the kernel gives NaN."""
FUNCTIONS = (
    {op: f"{op}({{a}})" for op in _ONE}
    | {op: f"{op}_of({{a}})" for op in _PARTIAL}
    | {
        "absolute": "abs({a})",
        "atan2": "atan2({a}, {b})",
        "less": "double({a} < {b})",
        "less_equal": "double({a} <= {b})",
        "equal": "double({a} == {b})",
        "where": "where_of({a}, {b}, {c})",
        "minimum": "min_of({a}, {b})",
        "maximum": "max_of({a}, {b})",
        "epsilon": "eps",
    }
)
_HELPERS = {
    op: f"function y = {op}_of(x)\n  y = NaN;\n  if {known}\n    y = {op}(x);\n  end\nend\n"
    for op, known in _PARTIAL.items()
} | {
    op: f"function y = {name}\n  if {known}\n    y = a;\n  else\n    y = b;\n  end\nend\n"
    for op, name, known in (
        ("where", "where_of(c, a, b)", "c ~= 0"),
        ("minimum", "min_of(a, b)", "a <= b || isnan(a)"),  # NaN that arises on the way stays
        ("maximum", "max_of(a, b)", "b <= a || isnan(a)"),
    )
}
RESERVED = (
    word_set(
        """worst bad any break case catch classdef continue else elseif end for function global if
        otherwise parfor persistent return spmd switch try while end_try_catch end_unwind_protect
        endfor endfunction endif endswitch endwhile until unwind_protect unwind_protect_cleanup do
        abs all ans disp eps error exit fprintf i inf Inf isfinite j max min nan NaN numel ones pi
        reshape zeros false true nargin nargout"""
    )
    | numbered("found")
    | called(FUNCTIONS, _HELPERS)
)


def _entry(word: str, argument: Argument, position: int) -> str:
    if not argument.shape:
        return word
    index = np.unravel_index(position, argument.shape)
    return f"{word}({', '.join(str(int(i) + 1) for i in index)})"


_SPELLING = Spelling(
    FUNCTIONS, number, _entry, _entry, "{word} = {text};", "{word} = {text};", "% {text}"
)


def _sizes(argument: Argument) -> str:
    """The sizes of an argument as a MATLAB array: vectors are columns."""
    return ", ".join(
        map(str, argument.shape if len(argument.shape) > 1 else (*argument.shape, 1, 1)[:2])
    )


def _emit(unit: SourceUnit) -> str:
    words, outputs = words_of(unit, RESERVED), unit.program.outputs
    returned = words.outputs[0] if len(outputs) == 1 else f"[{', '.join(words.outputs)}]"
    body = [f"  {word} = NaN({_sizes(a)});" for word, a in zip(words.outputs, outputs, strict=True)]
    body += _checks(unit, words)
    body += lines(statements(unit, words, _SPELLING, RESERVED), _SPELLING, "  ")
    head = [
        f"function {returned} = {words.function}({', '.join(words.inputs)})",
        *comment_block(unit, _USE, "", "%", ""),
    ]
    return "\n".join([*head, *body, "end\n", *helpers(unit.program, _HELPERS)])


def _checks(unit: SourceUnit, words: ProgramWords) -> list[str]:
    """The statements that answer a call with an input that is not finite, in MATLAB."""
    if not words.inputs:
        return []
    tests = " && ".join(f"all(isfinite({word}(:)))" for word in words.inputs)
    return [f"  if ~({tests})", "    return;", "  end"]


_USE = ("Vectors are columns. An input that is NaN or infinite makes all outputs NaN.",)


def _package(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    return {f"{word}.m": _emit(unit), f"{word}_test.m": _self_test(unit, vectors)}


def _array(row: np.ndarray, argument: Argument) -> str:
    """One sample of an argument as MATLAB text, in column-major order."""
    order = np.asarray(row).reshape(argument.shape or (1,)).ravel(order="F")
    return f"reshape([{', '.join(map(number, order.tolist()))}], {_sizes(argument)})"


def _self_test(unit: SourceUnit, vectors: SelfTestSamples) -> str:
    words, program = words_of(unit, RESERVED), unit.program
    found = [f"found{k + 1}" for k in range(len(program.outputs))]
    text = ["bad = false;", f"worst = zeros(1, {len(found)});"]
    for i in range(vectors.count):
        given = [_array(v[i], a) for v, a in zip(vectors.inputs, program.inputs, strict=True)]
        text.append(f"[{', '.join(found)}] = {words.function}({', '.join(given)});")
        for k, (rows, argument) in enumerate(zip(vectors.outputs, program.outputs, strict=True)):
            largest = number(largest_entries(vectors)[k])
            text.append(
                f"worst({k + 1}) = max([worst({k + 1}); 1e300 * "
                f"~isequal(size({found[k]}), size(zeros({_sizes(argument)})))]);"
            )
            text.append(
                f"worst({k + 1}) = max([worst({k + 1}); abs({found[k]}(:) - "
                f"{_array(rows[i], argument)}(:)) / {largest}; any(isnan({found[k]}(:))) * 1e300]);"
            )
    for k, (word, tolerance) in enumerate(zip(words.outputs, vectors.tolerances, strict=True)):
        text += [
            f"fprintf('{word}: off by at most %.2g of its largest entry; allowed "
            f"{tolerance:.2g}\\n', worst({k + 1}));",
            f"bad = bad || ~(worst({k + 1}) <= {number(tolerance)});",
        ]
    text += ["if bad", "  disp('FAILED');", "  exit(1);", "end", "disp('passed');", ""]
    return "\n".join(text)


MATLAB = Language(_emit, _package, "octave --quiet {name}_test.m")
