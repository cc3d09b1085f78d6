"""Closed-form equations as source code, one Python or C function for M, c, G and tau, and
expressions in SymPy."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, ClassVar

from freebody.errors import FreebodyError, MissingPackageError
from freebody.expressions.evaluate import NoValue, arithmetic, evaluate
from freebody.expressions.expression import (
    Matrix,
    Negative,
    Product,
    Sum,
    Symbol,
    Vector,
    nodes,
)
from freebody.expressions.nodes import Expression, Function, Number, Power
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.typesetting.typesetter import (
    ATOM,
    CALL,
    EQUATION,
    PRODUCT,
    Notation,
    Typesetter,
)
from freebody.identifiers import C_KEYWORDS, identifiers, in_words, word_set

if TYPE_CHECKING:
    from freebody_textbook.equations.equations import Equations


_OWN = word_set("q qd qdd M c G tau p math dynamics sin cos sgn parameters")


@dataclass(frozen=True)
class Assignment:
    """Assignment to an array entry: name, indices, value."""

    array: str
    indices: tuple[int, ...]
    value: Expression


def entries(equations: Equations) -> list[Assignment]:
    """The assignments of M (upper triangle), c, G, and of `drive` for friction and springs."""
    form, n = equations.layout.form, len(equations.M)
    result = [
        Assignment("M", (i, j), form(equations.M[i][j])) for i in range(n) for j in range(i, n)
    ]
    for array, column in (("c", equations.c), ("G", equations.g), ("drive", equations.drives)):
        result += [Assignment(array, (i,), form(x)) for i, x in enumerate(column)]
    return result


class CodeNames:
    """Names in generated code: parameters as unique identifiers; functions of angles become
    variables."""

    def __init__(
        self, equations: Equations, rows: list[Assignment], words: Collection[str], parameter: str
    ):
        self.coordinates = equations.symbols.coordinates
        self.parameter = parameter
        self.words = identifiers(equations.parameters, _OWN.union(words))
        self.waves: dict[Function, str] = {}
        """A variable for each sine and cosine: cos_12 is cos(θ1 + θ2)."""
        taken = {*self.words.values(), *_OWN}
        parts = [part for row in rows for part in nodes(row.value) if isinstance(part, Function)]
        self.sign = any(part.name == "sgn" for part in parts)
        """Whether a sign function occurs."""
        for part in dict.fromkeys(part for part in parts if part.name != "sgn"):
            wanted = f"{part.name}_{_spelt(part.argument)}"
            self.waves[part] = identifiers([wanted], taken)[wanted]
            taken.add(self.waves[part])

    def __call__(self, name: str) -> str:
        for ending, array in ((SECOND, "qdd"), (RATE, "qd"), ("", "q")):
            if name.removesuffix(ending) in self.coordinates and name.endswith(ending):
                return f"{array}[{self.coordinates.index(name.removesuffix(ending))}]"
        return self.parameter.format(self.words[name])


def _spelt(argument: Expression) -> str:
    """The part of a variable name for an angle: 12 for θ1 + θ2, 1_m2x3 for θ1 - 2 θ3."""
    words = []
    for term in argument.terms if isinstance(argument, Sum) else (argument,):
        sign, term = ("m", term.operand) if isinstance(term, Negative) else ("", term)
        number, symbol = term.factors if isinstance(term, Product) else (None, term)
        times = f"{number.value}x" if isinstance(number, Number) else ""
        name = symbol.name if isinstance(symbol, Symbol) else ""
        words.append(sign + times + name.removeprefix("theta"))
    return ("" if all(len(word) == 1 for word in words) else "_").join(words)


@dataclass(frozen=True)
class _ClosedFormSource:
    """How a programming language writes the function: its template, the parts inserted, and an
    assignment."""

    text: str
    parts: Callable[[Equations, CodeNames], dict[str, str]]
    assignment: Callable[[str, str], list[str]]
    sign: str
    """A function for signs, where they occur."""
    parameter: str = "{}"
    reserved: Collection[str] = ()
    library: str = ""
    """The prefix of the names of its functions."""
    constant: str = "    {} = {}"

    def __call__(self, equations: Equations) -> str:
        rows = entries(equations)
        names = CodeNames(equations, rows, self.reserved, self.parameter)
        functions = {name: self.library + name for name in ("sin", "cos")} | {"sgn": "sgn"}
        plain, spell = _code(names, functions), _code(names, functions, names.waves)
        lines = [self.constant.format(name, plain(wave)) for wave, name in names.waves.items()]
        body = []
        for row in rows:
            target = row.array + "".join(f"[{i}]" for i in row.indices)
            if row.array == "M" and row.indices[0] != row.indices[1]:
                target = f"{target} = M[{row.indices[1]}][{row.indices[0]}]"
            body += self.assignment(target, spell(row.value))
        title = f"Equations of motion of {in_words(equations.symbols.model.name)} in closed form."
        q = ", ".join(map(in_words, names.coordinates))
        return self.text.format(
            title=title,
            summary=f"M q'' + c + G + friction and springs = tau; q = ({q}) in rad and m.",
            sign=self.sign * names.sign,
            constants="".join(f"{line}\n" for line in lines),
            body="\n".join(body),
            n=len(equations.M),
            **self.parts(equations, names),
        )


# ---------------------------------------------------------------- Python
def _python_parts(equations: Equations, names: CodeNames) -> dict[str, str]:
    values = equations.parameters
    open_ones = [names.words[x] for x, value in values.items() if value is None]
    known = [f"{names.words[x]}={value!r}" for x, value in values.items() if value is not None]
    arguments = ", ".join(["q", "qd", "qdd", *open_ones, *known])
    return {"head": "\n".join(_wrapped(f"def dynamics({arguments}):", ""))}


def _python_assignment(target: str, value: str) -> list[str]:
    line = f"    {target} = {value}"
    if value == "0.0":
        return []
    return [line] if len(line) <= 100 else _wrapped(f"    {target} = ({value})", "        ")


python = _ClosedFormSource(
    '''"""{title}"""

import math

{sign}
{head}
    """{summary}"""
{constants}    M = [[0.0] * {n} for _ in range({n})]
    c, G, drive = [0.0] * {n}, [0.0] * {n}, [0.0] * {n}
{body}
    tau = [sum(M[i][j] * qdd[j] for j in range({n})) + c[i] + G[i] + drive[i] for i in range({n})]
    return M, c, G, tau
''',
    _python_parts,
    _python_assignment,
    sign="\ndef sgn(x):\n    return (x > 0) - (x < 0)\n\n",
    library="math.",
)
"""Source of dynamics(q, qd, qdd, parameters…) -> M, c, G, tau, with nothing but `math`."""


def _wrapped(line: str, indent: str) -> list[str]:
    return textwrap.wrap(
        line,
        100,
        subsequent_indent=indent,
        break_long_words=False,
        break_on_hyphens=False,
        drop_whitespace=True,
    ) or [""]


# ---------------------------------------------------------------- C
def _c_parts(equations: Equations, names: CodeNames) -> dict[str, str]:
    n, values, lines = len(equations.M), equations.parameters.values(), []
    if values:
        members = ", ".join(names.words.values())
        lines += [*_wrapped(f"typedef struct {{ double {members}; }} parameters;", "    "), ""]
        if all(value is not None for value in values):
            numbers = ", ".join(map(repr, values))
            lines += [*_wrapped(f"static const parameters defaults = {{ {numbers} }};", "    "), ""]
    return {
        "structure": "".join(f"{line}\n" for line in lines),
        "first": "const parameters *p, " if values else "",
        "vectors": ", ".join(f"const double {x}[{n}]" for x in ("q", "qd", "qdd")),
        "outputs": ", ".join(f"double {x}[{n}]" for x in ("c", "G", "tau")),
    }


c = _ClosedFormSource(
    """/* {title} */
#include <math.h>

{structure}{sign}/* {summary} */
void dynamics({first}{vectors},
              double M[{n}][{n}], {outputs})
{{
{constants}    double drive[{n}];
{body}
    for (int i = 0; i < {n}; ++i) {{
        tau[i] = c[i] + G[i] + drive[i];
        for (int j = 0; j < {n}; ++j) tau[i] += M[i][j] * qdd[j];
    }}
}}
""",
    _c_parts,
    lambda target, value: _wrapped(f"    {target} = {value};", "        "),
    sign="static double sgn(double x) { return (x > 0.0) - (x < 0.0); }\n\n",
    parameter="p->{}",
    reserved=C_KEYWORDS,
    constant="    const double {} = {};",
)
"""C99 source of dynamics(parameters, q, qd, qdd, M, c, G, tau), with nothing but <math.h>."""


def _code(
    name: Callable[[str], str],
    functions: Mapping[str, str],
    variables: Mapping[Function, str] | None = None,
) -> Callable[[Expression], str]:
    """A renderer of expressions to infix code: `name` spells symbols, `functions` are the names of
    sin, cos and sgn.

    `variables` names those sines and cosines that stand in a variable.
    """
    return _Code(name, functions, variables or {})


class _Code(Typesetter):
    fraction_levels = PRODUCT, EQUATION

    def __init__(
        self,
        name: Callable[[str], str],
        functions: Mapping[str, str],
        variables: Mapping[Function, str],
    ):
        super().__init__(
            Notation(
                symbol=lambda node, high: name(node.name),
                gap=lambda before, after: "*",
                plus=" + ",
                minus=" - ",
                lead="-",
                fraction="{}/({})",
                bar=False,
            )
        )
        self.functions, self.variables = functions, variables

    def _number(self, node: Number) -> str:
        return repr(node.value.numerator / node.value.denominator)

    def _call(self, node: Function) -> str:
        known = self.variables.get(node)
        return known or f"{self.functions[node.name]}({self(node.argument)})"

    def _power(self, node: Power) -> str:
        base = self(node.base, CALL if isinstance(node.base, Function) else ATOM)
        product = "*".join([base] * abs(node.exponent))
        return product if node.exponent > 0 else f"1.0/({product})"

    _rules: ClassVar = {**Typesetter._rules, Number: _number, Function: _call, Power: _power}


_NAMES = {x: x for x in ("sin", "cos", "tan", "sqrt", "exp", "log")} | {"sgn": "sign"}


def to_sympy(node: Expression) -> Any:
    """An expression in SymPy; symbols are real and named as in generated code (theta1, theta1_d,
    l1, …).

    Raises MissingPackageError, FreebodyError.
    """
    try:
        import sympy
    except ImportError:
        raise MissingPackageError("to_sympy", "SymPy", "sympy") from None

    rules = {
        **arithmetic(
            lambda number: sympy.Rational(number.numerator, number.denominator),
            total=lambda terms: sympy.Add(*terms),
            product=lambda factors: sympy.Mul(*factors),
        ),
        Symbol: lambda node, at: sympy.Symbol(node.name, real=True),
        Function: lambda node, at: getattr(sympy, _NAMES[node.name])(at(node.argument)),
        Vector: lambda node, at: sympy.Matrix(list(map(at, node.entries))),
        Matrix: lambda node, at: sympy.Matrix([list(map(at, row)) for row in node.rows]),
    }
    try:
        return evaluate(node, rules)
    except NoValue as problem:
        kind = type(problem.node).__name__
        raise FreebodyError(f"{problem.node}: {kind} has no counterpart in SymPy.") from None
