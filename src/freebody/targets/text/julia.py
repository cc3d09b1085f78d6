"""Programs as Julia: a function that writes to arrays it is given, outputs first, as the `!` in its
name says."""

from __future__ import annotations

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
    number_lists,
    numbered,
    single,
)
from freebody.targets.text.statements import Spelling, body_in_parts, refusal, words_of

LONGEST = 4000
"""Operations of one function: compilers take longer than in proportion."""

_ONE = ("sin", "cos", "exp", "tanh", "sign")
_PARTIAL = {"sqrt": "x >= 0", "log": "x >= 0", "asin": "abs(x) <= 1", "acos": "abs(x) <= 1"}
"""Functions that Julia refuses outside of a condition, where the kernel gives NaN."""
FUNCTIONS = (
    {op: f"{op}({{a}})" for op in _ONE}
    | {op: f"{op}_of({{a}})" for op in _PARTIAL}
    | {
        "absolute": "abs({a})",
        "atan2": "atan({a}, {b})",
        "less": "({a} < {b} ? one({a}) : zero({a}))",
        "less_equal": "({a} <= {b} ? one({a}) : zero({a}))",
        "equal": "({a} == {b} ? one({a}) : zero({a}))",
        "where": "({a} != 0 ? {b} : {c})",
        "minimum": "min({a}, {b})",
        "maximum": "max({a}, {b})",
        "epsilon": "eps(typeof({a}))",
    }
)
_HELPERS = {
    op: f"{op}_of(x) = {known} ? {op}(x) : oftype(x, NaN)\n" for op, known in _PARTIAL.items()
}

RESERVED = (
    word_set(
        """exit results expected bad off baremodule begin break catch const continue do else elseif
        end export false finally for function global if import in isa let local macro mutable module
        primitive quote return struct true try type using while where all fill include isfinite im
        pi println maximum minimum error zeros ones w Inf NaN Float32 Float64"""
    )
    | numbered("given")
    | called(FUNCTIONS, _HELPERS)
)


def _single(value: float) -> str:
    text = single(value)
    return text.replace("e", "f") if "e" in text else f"{text}f0"


def _entry(word: str, argument: Argument, position: int) -> str:
    return f"{word}[{position + 1}]" if argument.shape else word


def _spelling(unit: SourceUnit) -> Spelling:
    return Spelling(
        FUNCTIONS,
        _single if unit.dtype == "float32" else number,
        _entry,
        lambda word, argument, k: f"{word}[{k + 1}]",
        "{word} = {text}",
        "{word} = {text}",
        "# {text}",
    )


def _type(unit: SourceUnit) -> str:
    return "Float32" if unit.dtype == "float32" else "Float64"


def _definitions(unit: SourceUnit) -> list[str]:
    """Julia text of the function, after those that it calls."""
    words = words_of(unit, RESERVED)
    order = [*words.outputs, *words.inputs]

    def part(name: str, used: list[str], inner: list[str], slots: int) -> str:
        head = f"function {name}!({', '.join([*used, 'w'])})"
        return "\n".join([head, *inner, "    return nothing", "end\n"])

    call, workspace = "{}!({})", (f"w = zeros({_type(unit)}, {{}})", "w")
    made, body = body_in_parts(
        unit, words, _spelling(unit), RESERVED, LONGEST, order, part, call, workspace, first=1
    )
    head = f"function {words.function}!({', '.join(order)})"
    finite, blank = ("all(isfinite, {word})", "isfinite({word})"), "{word} .= NaN"
    around = "if !({})", "return false", "end"
    checks = refusal(unit, words, finite, (blank, blank), around)
    whole = "\n".join([head, *checks, *body, "    return true", "end\n"])
    return [*helpers(unit.program, _HELPERS), *made, whole]


_USE = (
    "Called with the arrays that receive the outputs first: vectors, matrices row by row, a scalar "
    "as a vector of one.",
    "Returns true; or false if an input is NaN or infinite: all outputs are then NaN.",
)


def _emit(unit: SourceUnit) -> str:
    return "\n".join([*comment_block(unit, _USE, "", "#", ""), "", *_definitions(unit)])


def _package(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    return {f"{word}.jl": _emit(unit), f"{word}_test.jl": _self_test(unit, vectors)}


def _self_test(unit: SourceUnit, vectors: SelfTestSamples) -> str:
    words, spell, t = words_of(unit, RESERVED), _spelling(unit).number, _type(unit)

    def table(rows: list[str]) -> str:
        return f"Vector{{{t}}}[{', '.join(f'[{row}]' for row in rows)}]"

    named = [f"given{k + 1}" for k in range(len(vectors.inputs))]
    given = [
        f"{x}[i]" if a.shape else f"{x}[i][1]"
        for x, a in zip(named, unit.program.inputs, strict=True)
    ]
    text = [f'include("{words.function}.jl")', ""]
    text += [
        f"{x} = {table(number_lists(v, spell))}" for x, v in zip(named, vectors.inputs, strict=True)
    ]
    text += ["bad = false"]
    checks = zip(
        words.outputs, vectors.outputs, largest_entries(vectors), vectors.tolerances, strict=True
    )
    found = [f"zeros({t}, {a.size})" for a in unit.program.outputs]
    text += [f"results = [({', '.join(found)},) for i in 1:{vectors.count}]"]
    text += [f"for i in 1:{vectors.count}"]
    text += [f"    {words.function}!({', '.join(['results[i]...', *given])})", "end"]
    for k, (word, rows, largest, tolerance) in enumerate(checks):
        text += [
            f"expected = {table(number_lists(rows, spell))}",
            f"off = maximum(maximum(abs.(results[i][{k + 1}] .- expected[i]) ./ {spell(largest)}; "
            f"init = 0.0) for i in 1:{vectors.count})",
            f'println("{word}: off by at most ", off, " of its largest entry; '
            f'allowed {tolerance:.2g}")',
            f"global bad |= !(off <= {spell(tolerance)})",
        ]
    text += ['println(bad ? "FAILED" : "passed")', "exit(bad ? 1 : 0)", ""]
    return "\n".join(text)


JULIA = Language(
    _emit,
    _package,
    "julia {name}_test.jl",
    ("float64", "float32"),
    "This text has never been run, since freebody was developed without Julia: run the self-test "
    "before use.",
)
