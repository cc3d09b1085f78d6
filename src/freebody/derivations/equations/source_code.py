"""Closed forms as source code: one function in Python or C that computes M, c, G and tau."""

from __future__ import annotations

import textwrap
from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from freebody.derivations.expressions.expression import (
    Expression,
    Function,
    Negative,
    Number,
    Product,
    Sum,
    Symbol,
    nodes,
)
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.derivations.render.code import code
from freebody.identifiers import identifiers, in_words

if TYPE_CHECKING:
    from freebody.derivations.equations.equations import Equations

_C_WORDS = frozenset(
    [
        "auto",
        "break",
        "case",
        "char",
        "const",
        "continue",
        "default",
        "do",
        "double",
        "else",
        "enum",
        "extern",
        "float",
        "for",
        "goto",
        "if",
        "inline",
        "int",
        "long",
        "register",
        "restrict",
        "return",
        "short",
        "signed",
        "sizeof",
        "static",
        "struct",
        "switch",
        "typedef",
        "union",
        "unsigned",
        "void",
        "volatile",
        "while",
        "INFINITY",
        "NAN",
        "HUGE_VAL",
    ]
)
_OWN = {
    "q",
    "qd",
    "qdd",
    "M",
    "c",
    "G",
    "tau",
    "p",
    "math",
    "dynamics",
    "sin",
    "cos",
    "sgn",
    "parameters",
}


@dataclass(frozen=True)
class Assignment:
    """One assignment: array name, indices, value."""

    array: str
    indices: tuple[int, ...]
    value: Expression


def entries(equations: Equations) -> list[Assignment]:
    """M (upper triangle), c, G, and in `drive` friction and springs."""
    form, n = equations.layout.form, len(equations.M)
    result = [
        Assignment("M", (i, j), form(equations.M[i][j])) for i in range(n) for j in range(i, n)
    ]
    for array, column in (("c", equations.c), ("G", equations.g), ("drive", equations.drives)):
        result += [Assignment(array, (i,), form(x)) for i, x in enumerate(column)]
    return result


class CodeNames:
    """Names of code: parameters as words that clash with none; functions of angles become
    variables."""

    def __init__(
        self, equations: Equations, words: frozenset[str], of_parameter: Callable[[str], str]
    ):
        self.coordinates = equations.symbols.coordinates
        self.values = equations.parameters
        self.of_parameter = of_parameter
        self.words = identifiers(self.values, words | _OWN)
        self.waves: dict[Function, str] = {}

    def __call__(self, name: str) -> str:
        for ending, array in ((SECOND, "qdd"), (RATE, "qd"), ("", "q")):
            if name.removesuffix(ending) in self.coordinates and name.endswith(ending):
                return f"{array}[{self.coordinates.index(name.removesuffix(ending))}]"
        return self.of_parameter(self.parameter(name))

    def parameter(self, name: str) -> str:
        """The parameter's name in code."""
        return self.words[name]

    def collect(self, rows: list[Assignment]) -> None:
        """Gives each sine and cosine a variable: cos_12 is cos(θ1 + θ2)."""
        taken = {*self.words.values(), *_OWN}
        for row in rows:
            for part in nodes(row.value):
                if isinstance(part, Function) and part.name != "sgn" and part not in self.waves:
                    wanted = f"{part.name}_{_spelt(part.argument)}"
                    self.waves[part] = identifiers([wanted], taken)[wanted]
                    taken.add(self.waves[part])


def _spelt(argument: Expression) -> str:
    """12 of θ1 + θ2, 1_m2x3 of θ1 - 2 θ3."""
    words = []
    for term in argument.terms if isinstance(argument, Sum) else (argument,):
        sign, term = ("m", term.operand) if isinstance(term, Negative) else ("", term)
        number, symbol = term.factors if isinstance(term, Product) else (None, term)
        times = f"{number.value}x" if isinstance(number, Number) else ""
        name = symbol.name if isinstance(symbol, Symbol) else ""
        words.append(sign + times + name.removeprefix("theta"))
    return ("" if all(len(word) == 1 for word in words) else "_").join(words)


def python(equations: Equations) -> str:
    """Source of dynamics(q, qd, qdd, parameters…) -> M, c, G, tau, with nothing but `math`."""
    names = CodeNames(equations, frozenset(), lambda name: name)
    rows = entries(equations)
    names.collect(rows)
    plain = code(names, {"sin": "math.sin", "cos": "math.cos", "sgn": "sgn"})
    spell = code(names, {"sgn": "sgn"}, names.waves)
    n = len(equations.M)
    arguments = [
        "q",
        "qd",
        "qdd",
        *(f"{names.parameter(x)}{'' if v is None else f'={v!r}'}" for x, v in names.values.items()),
    ]
    arguments.sort(key=lambda argument: "=" in argument)
    lines = [f'"""{_title(equations)}"""', "", "import math", ""]
    if any(
        isinstance(part, Function) and part.name == "sgn"
        for row in rows
        for part in nodes(row.value)
    ):
        lines += ["", "def sgn(x):", "    return (x > 0) - (x < 0)", ""]
    lines += [
        "",
        *_wrapped(f"def dynamics({', '.join(arguments)}):", ""),
        f'    """{_summary(equations)}"""',
    ]
    lines += [f"    {name} = {plain(wave)}" for wave, name in names.waves.items()]
    lines += [
        f"    M = [[0.0] * {n} for _ in range({n})]",
        f"    c, G, drive = [0.0] * {n}, [0.0] * {n}, [0.0] * {n}",
    ]
    for row in rows:
        target = row.array + "".join(f"[{i}]" for i in row.indices)
        value = spell(row.value)
        if value == "0.0":
            continue
        if row.array == "M" and row.indices[0] != row.indices[1]:
            target = f"{target} = M[{row.indices[1]}][{row.indices[0]}]"
        line = f"    {target} = {value}"
        lines += [line] if len(line) <= 100 else _wrapped(f"    {target} = ({value})", "        ")
    lines += [
        f"    tau = [sum(M[i][j] * qdd[j] for j in range({n})) + c[i] + G[i] + drive[i] for i in "
        f"range({n})]",
        "    return M, c, G, tau",
    ]
    return "\n".join(lines) + "\n"


def c(equations: Equations) -> str:
    """C99 source of dynamics(parameters, q, qd, qdd, M, c, G, tau), with nothing but <math.h>."""
    names = CodeNames(equations, _C_WORDS, lambda name: f"p->{name}")
    rows = entries(equations)
    names.collect(rows)
    plain = code(names, {"sin": "sin", "cos": "cos", "sgn": "sgn"})
    spell = code(names, {"sgn": "sgn"}, names.waves)
    n = len(equations.M)
    lines = [f"/* {_title(equations)} */", "#include <math.h>", ""]
    if names.values:
        members = ", ".join(map(names.parameter, names.values))
        lines += [*_wrapped(f"typedef struct {{ double {members}; }} parameters;", "    "), ""]
        if all(value is not None for value in names.values.values()):
            numbers = ", ".join(repr(value) for value in names.values.values())
            lines += [*_wrapped(f"static const parameters defaults = {{ {numbers} }};", "    "), ""]
    if any(
        isinstance(part, Function) and part.name == "sgn"
        for row in rows
        for part in nodes(row.value)
    ):
        lines += ["static double sgn(double x) { return (x > 0.0) - (x < 0.0); }", ""]
    lines += [f"/* {_summary(equations)} */"]
    first = "const parameters *p, " if names.values else ""
    vectors = ", ".join(f"const double {x}[{n}]" for x in ("q", "qd", "qdd"))
    outputs = ", ".join([f"double M[{n}][{n}]", *(f"double {x}[{n}]" for x in ("c", "G", "tau"))])
    lines += [f"void dynamics({first}{vectors},", f"              {outputs})", "{"]
    lines += [f"    const double {name} = {plain(wave)};" for wave, name in names.waves.items()]
    lines += [f"    double drive[{n}];"]
    for row in rows:
        target = row.array + "".join(f"[{i}]" for i in row.indices)
        if row.array == "M" and row.indices[0] != row.indices[1]:
            target = f"{target} = M[{row.indices[1]}][{row.indices[0]}]"
        lines += _wrapped(f"    {target} = {spell(row.value)};", "        ")
    lines += [
        f"    for (int i = 0; i < {n}; ++i) {{",
        "        tau[i] = c[i] + G[i] + drive[i];",
        f"        for (int j = 0; j < {n}; ++j) tau[i] += M[i][j] * qdd[j];",
        "    }",
        "}",
    ]
    return "\n".join(lines) + "\n"


def _title(equations: Equations) -> str:
    return f"Equations of motion of {in_words(equations.symbols.model.name)} in closed form."


def _summary(equations: Equations) -> str:
    meaning = ", ".join(map(in_words, equations.symbols.coordinates))
    return f"M q'' + c + G + friction and springs = tau; q = ({meaning}) in rad and m."


def _wrapped(line: str, indent: str) -> list[str]:
    return textwrap.wrap(
        line,
        100,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
    ) or [""]
