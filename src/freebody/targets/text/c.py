"""Programs as C99 and as C++ templates: no allocation, no dependency but the standard mathematics,
arrays that may overlap."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import dataclass
from functools import partial

from freebody.identifiers import C_KEYWORDS, word_set
from freebody.program.program import Argument
from freebody.targets.text.language import (
    Language,
    SelfTestSamples,
    SourceUnit,
    called,
    comment_block,
    flat,
    helpers,
    largest_entries,
    number,
    number_lists,
    numbered,
    single,
)
from freebody.targets.text.statements import (
    ProgramWords,
    Spelling,
    body_in_parts,
    refusal,
    words_of,
)

LONGEST = 4000
"""Operations of one function: compilers take longer than in proportion."""
_WIDEST = 110

_ONE = ("sqrt", "sin", "cos", "exp", "log", "tanh", "asin", "acos")
FUNCTIONS = {op: f"{op}{{f}}({{a}})" for op in _ONE} | {
    "absolute": "fabs{f}({a})",
    "atan2": "atan2{f}({a}, {b})",
    "sign": "sign_of({a})",
    "less": "({a} < {b} ? {one} : {zero})",
    "less_equal": "({a} <= {b} ? {one} : {zero})",
    "equal": "({a} == {b} ? {one} : {zero})",
    "where": "({a} != {zero} ? {b} : {c})",
    "minimum": "min_of({a}, {b})",
    "maximum": "max_of({a}, {b})",
    "epsilon": "{epsilon}",
}
_HELPERS = {
    "sign": "{before}{t} sign_of({t} x)\n{{\n    return {cast}((x > {zero}) - (x < {zero}));\n}}\n",
    "minimum": "{before}{t} min_of({t} a, {t} b)\n{{\n    return a <= b || a != a ? a : b;\n}}\n",
    "maximum": "{before}{t} max_of({t} a, {t} b)\n{{\n    return b <= a || a != a ? a : b;\n}}\n",
}

_OWN = word_set("isfinite main std w S all_finite fill")
_FUNCTIONS = word_set(
    """sin cos tan asin acos atan atan2 sinh cosh tanh asinh acosh atanh exp exp2 expm1 log log2
    log10 log1p logb ilogb pow sqrt cbrt fabs fmin fmax fmod fdim fma floor ceil round lround rint
    lrint trunc hypot erf erfc gamma lgamma tgamma frexp ldexp modf scalbn nan j0 j1 jn y0 y1 yn
    signgam div abs remainder remquo copysign nextafter drem significand"""
) | called(FUNCTIONS, _HELPERS)
_LIBRARY = word_set(
    """printf fprintf sprintf scanf puts putchar getchar exit abort atexit malloc calloc realloc
    free memcpy memmove memset memcmp strlen strcpy strcat strcmp index time clock signal raise rand
    srand qsort bsearch system getenv remove rename read write open close stdin stdout stderr errno
    off_by bad"""
)
RESERVED = frozenset(
    (
        *C_KEYWORDS,
        *_OWN,
        *_FUNCTIONS,
        *_LIBRARY,
        *numbered("given", "expected", "found", "worst", "d"),
        *(f"{x}f" for x in _FUNCTIONS),
        *(f"{x}l" for x in _FUNCTIONS),
    )
)

_CHECKS = """{before}int all_finite(int n, const {t} *x)
{{
    for (int i = 0; i < n; i++) {{
        if (!({finite})) {{
            return 0;
        }}
    }}
    return 1;
}}

{before}void fill(int n, {t} *x)
{{
    for (int i = 0; i < n; i++) {{
        x[i] = {nan};
    }}
}}
"""


@dataclass(frozen=True)
class _Dialect:
    """The differences between C in double, C in float, and C++."""

    t: str
    f: str
    number: Callable[[float], str]
    epsilon: str
    before: str = "static "
    head: str = ""
    finite: str = "isfinite(x[i])"
    nan: str = "NAN"

    def written(self, text: str) -> str:
        """The template of an operation in this dialect, with {a}, {b} and {c} left open."""
        words = {"f": self.f, "one": self.number(1.0), "zero": self.number(0.0)}
        words["epsilon"] = self.epsilon
        for word, written in words.items():
            text = text.replace(f"{{{word}}}", written)
        return text

    def filled(self, text: str) -> str:
        """A template of code filled in for this dialect."""
        return text.format(
            before=self.before,
            t=self.t,
            cast=f"({self.t})",
            finite=self.finite,
            nan=self.nan,
            zero=self.number(0.0),
        )


_DOUBLE = _Dialect("double", "", number, number(2.0**-52))
_FLOAT = _Dialect("float", "f", partial(single, suffix="f"), single(2.0**-23, "f"))
_TEMPLATE = _Dialect(
    "S",
    "",
    lambda value: f"S({value!r})",
    "S(std::numeric_limits<S>::epsilon())",
    "template <class S>\n",
    "template <class S>\n",
    "x[i]*S(0.0) == S(0.0)",
    "S(NAN)",
)


def _spelling(dialect: _Dialect) -> Spelling:
    return Spelling(
        {op: dialect.written(text) for op, text in FUNCTIONS.items()},
        dialect.number,
        flat,
        lambda word, argument, k: flat(word, argument, k) if argument.shape else f"*{word}",
        f"const {dialect.t} {{word}} = {{text}};",
        "{word} = {text};",
        "/* {text} */",
    )


def _parameters(unit: SourceUnit, words: ProgramWords, t: str) -> dict[str, str]:
    """The declaration of each argument, by its name in the text."""

    def declared(word: str, argument: Argument, const: str, scalar: str) -> str:
        if not argument.shape:
            return f"{t} {scalar}{word}"
        return f"{const}{t} {word}[{argument.size}]" if argument.size else f"{const}{t} *{word}"

    ins = zip(words.inputs, unit.program.inputs, strict=True)
    outs = zip(words.outputs, unit.program.outputs, strict=True)
    return {w: declared(w, a, "const ", "") for w, a in ins} | {
        w: declared(w, a, "", "*") for w, a in outs
    }


def _prototype(unit: SourceUnit, dialect: _Dialect) -> str:
    words = words_of(unit, RESERVED)
    return _wrapped(
        f"{dialect.head}int {words.function}", _parameters(unit, words, dialect.t).values()
    )


def _wrapped(name: str, parameters: Collection[str]) -> str:
    """The head of a function, with a line for each parameter if it is long."""
    line = f"{name}({', '.join(parameters)})"
    return line if len(line) <= _WIDEST else name + "(\n    " + ",\n    ".join(parameters) + ")"


def _definitions(unit: SourceUnit, dialect: _Dialect) -> list[str]:
    """C text of the function, after those that it calls."""
    words, t = words_of(unit, RESERVED), dialect.t
    parameters = _parameters(unit, words, t)

    def part(name: str, used: list[str], inner: list[str], slots: int) -> str:
        given = [*(parameters[x] for x in used), f"{t} *w"]
        idle = [] if any("w[" in text for text in inner) else ["    (void)w;"]
        head = _wrapped(f"{dialect.before}void {name}", given)
        return "\n".join([head, "{", *inner, *idle, "}\n"])

    call, workspace = "{}({});", (f"{t} w[{{}}];", "w")
    made, body = body_in_parts(
        unit, words, _spelling(dialect), RESERVED, LONGEST, list(parameters), part, call, workspace
    )
    finite, fill = "all_finite({size}, {word})", "fill({size}, {word});"
    checks = refusal(
        unit, words, (finite, "all_finite({size}, &{word})"), (fill, fill),
        ("if (!({})) {{", "return 1;", "}"),
    )  # fmt: skip
    texts = [*helpers(unit.program, _HELPERS), *([_CHECKS] if words.inputs else [])]
    before = [dialect.filled(text) for text in texts]
    whole = [_prototype(unit, dialect), "{", *checks, *body, "    return 0;", "}\n"]
    return [*before, *made, "\n".join(whole)]


_USE = (
    "Matrices are stored row by row. Arrays may overlap. Returns 0; or 1 if an input is NaN or "
    "infinite: all outputs",
    "are then NaN. Do not compile with -ffast-math, which removes that check.",
)


def _head(unit: SourceUnit, *more: str) -> list[str]:
    return comment_block(unit, (*_USE, *more), "/*", " *", " */")


def _dialect(unit: SourceUnit) -> _Dialect:
    return _FLOAT if unit.dtype == "float32" else _DOUBLE


def _emit_c(unit: SourceUnit) -> str:
    """A complete file of C."""
    return "\n".join([*_head(unit), "#include <math.h>", "", *_definitions(unit, _dialect(unit))])


def _emit_cpp(unit: SourceUnit) -> str:
    """A header of C++: a template over the scalar."""
    scalar = "S is double, float, or a scalar of automatic differentiation."
    library = {op: text for op, text in FUNCTIONS.items() if "{f}" in text}  # not those of our own
    using = [f"using std::{function};" for function in sorted(called(library))]
    guard = f"{words_of(unit, RESERVED).function.upper()}_HPP"
    return "\n".join(
        [
            *_head(unit, scalar),
            f"#ifndef {guard}\n#define {guard}\n",
            "#include <cmath>\n#include <limits>\n",
            f"namespace {words_of(unit, RESERVED).function}_detail {{\n",
            *using,
            "",
            *_definitions(unit, _TEMPLATE),
            "}\n",
            f"using "
            f"{words_of(unit, RESERVED).function}_detail::{words_of(unit, RESERVED).function};\n",
            "#endif\n",
        ]
    )


def _package_c(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    """Files of a C package: header, source and self-test."""
    word, dialect = words_of(unit, RESERVED).function, _dialect(unit)
    guard = f"{word.upper()}_H"
    header = [
        *_head(unit),
        f"#ifndef {guard}\n#define {guard}\n",
        '#ifdef __cplusplus\nextern "C" {\n#endif\n',
        f"{_prototype(unit, dialect)};\n",
        "#ifdef __cplusplus\n}\n#endif\n\n#endif\n",
    ]
    source = [f'#include "{word}.h"', "", "#include <math.h>", "", *_definitions(unit, dialect)]
    return {
        f"{word}.h": "\n".join(header),
        f"{word}.c": "\n".join(source),
        f"{word}_test.c": _self_test(
            unit, vectors, dialect, f'#include "{word}.h"\n\n#include <math.h>'
        ),
    }


def _package_cpp(unit: SourceUnit, vectors: SelfTestSamples) -> dict[str, str]:
    word = words_of(unit, RESERVED).function
    return {
        f"{word}.hpp": _emit_cpp(unit),
        f"{word}_test.cpp": _self_test(unit, vectors, _DOUBLE, f'#include "{word}.hpp"\n'),
    }


_OFF = """static {t} off_by(int n, const {t} *found, const {t} *expected, {t} largest)
{{
    {t} off = {zero};
    for (int i = 0; i < n; i++) {{
        const {t} apart = found[i] - expected[i];
        const {t} d = (apart > {zero} ? apart : -apart) / largest;
        off = d <= off ? off : d; /* NaN counts */
    }}
    return off;
}}
"""


def _self_test(unit: SourceUnit, vectors: SelfTestSamples, dialect: _Dialect, include: str) -> str:
    words, program = words_of(unit, RESERVED), unit.program
    found = [f"{'' if a.shape else '&'}found{k}" for k, a in enumerate(program.outputs)]
    given = [f"given{k}[i]" if a.shape else f"given{k}[i][0]" for k, a in enumerate(program.inputs)]
    calls, verdicts, made = [], [], []
    spell, t, largest = dialect.number, dialect.t, largest_entries(vectors)
    for k, (word, argument) in enumerate(zip(words.outputs, program.outputs, strict=True)):
        at = "" if argument.shape else "&"
        array = f"[{max(argument.size, 1)}]" if argument.shape else ""
        made.append(f"    {t} worst{k} = {spell(0.0)}, found{k}{array};")
        calls += [
            f"        const {t} d{k} = off_by({argument.size}, {at}found{k}, expected{k}[i], "
            f"{spell(largest[k])});",
            f"        worst{k} = d{k} <= worst{k} ? worst{k} : d{k};",
        ]
        verdicts += [
            f'    printf("{word}: off by at most %.2g of its largest entry; '
            f'allowed {vectors.tolerances[k]:.2g}\\n", '
            f"(double)worst{k});",
            f"    bad |= !(worst{k} <= {spell(vectors.tolerances[k])});",
        ]
    return "\n".join(
        [
            f"{include}\n#include <stdio.h>\n",
            *_tables("given", vectors.inputs, dialect),
            *_tables("expected", vectors.outputs, dialect),
            dialect.filled(_OFF),
            "int main(void)\n{",
            *made,
            "    int bad = 0;",
            f"    for (int i = 0; i < {vectors.count}; i++) {{",
            f"        bad |= {words.function}({', '.join([*given, *found])});",
            *calls,
            "    }",
            *verdicts,
            '    puts(bad ? "FAILED" : "passed");\n    return bad;\n}\n',
        ]
    )


def _tables(prefix: str, values: tuple, dialect: _Dialect) -> list[str]:
    made = []
    for k, rows in enumerate(values):
        listed = ",\n".join(f"    {{{row}}}" for row in number_lists(rows, dialect.number))
        made.append(
            f"static const {dialect.t} {prefix}{k}[{len(rows)}][{max(rows.shape[1], 1)}] = "
            f"{{\n{listed}\n}};\n"
        )
    return made


C = Language(
    _emit_c,
    _package_c,
    "cc -std=c99 -O2 {name}.c {name}_test.c -lm -o {name}_test && ./{name}_test",
    ("float64", "float32"),
)
CPP = Language(
    _emit_cpp, _package_cpp, "c++ -std=c++11 -O2 {name}_test.cpp -o {name}_test && ./{name}_test"
)
