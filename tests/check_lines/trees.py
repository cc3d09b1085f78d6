"""Formulas as trees: read from short Python text or from SymPy, evaluated in numbers, changed."""

import ast
import itertools
import math
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import numpy as np
import sympy as sp

Tree = tuple[Any, ...]
"""("num", value), ("sym", key), ("add" | "mul", parts), ("neg", x), ("div", x, y), ("pow", x, n),
("fun", name, arguments), ("mat", rows)."""

FUNCTIONS = {
    "sin": np.sin,
    "cos": np.cos,
    "tan": np.tan,
    "sqrt": np.sqrt,
    "acos": np.arccos,
    "asin": np.arcsin,
    "atan": np.arctan,
    "atan2": np.arctan2,
    "abs": np.abs,
    "cot": lambda x: 1 / np.tan(x),
}
INVERSE = ("acos", "asin", "atan", "atan2")
TWO_VALUED = ("acos", "asin", "sqrt", "atan", "atan2")


def tree(text: str) -> Tree:
    """The tree of a formula in Python: "m2*(lc2**2 + l1*lc2*cos(th2))"; a list is a matrix."""
    return _of_node(ast.parse(text.strip(), mode="eval").body)


def _of_node(node: ast.AST) -> Tree:
    match node:
        case ast.Constant(value=value):
            return ("num", Fraction(str(value)))
        case ast.Name(id=key):
            return ("sym", key)
        case ast.UnaryOp(op=ast.USub(), operand=x):
            return ("neg", _of_node(x))
        case ast.BinOp(left=left, op=ast.Add(), right=right):
            return _flat("add", _of_node(left), _of_node(right))
        case ast.BinOp(left=left, op=ast.Sub(), right=right):
            return _flat("add", _of_node(left), ("neg", _of_node(right)))
        case ast.BinOp(left=left, op=ast.Mult(), right=right):
            return _flat("mul", _of_node(left), _of_node(right))
        case ast.BinOp(left=left, op=ast.Div(), right=right):
            x, y = _of_node(left), _of_node(right)
            if x[0] == y[0] == "num":
                return ("num", x[1] / y[1])
            return ("div", x, y)
        case ast.BinOp(left=left, op=ast.Pow(), right=right):
            exponent = _of_node(right)
            sign = -1 if exponent[0] == "neg" else 1
            return ("pow", _of_node(left), sign * (exponent[-1] if sign > 0 else exponent[1][1]))
        case ast.Call(func=ast.Name(id=name), args=arguments):
            return ("fun", name, tuple(_of_node(x) for x in arguments))
        case ast.List(elts=rows):
            return ("mat", tuple(tuple(_of_node(x) for x in row.elts) for row in rows))  # type: ignore[attr-defined]
    raise ValueError(ast.dump(node))


def _flat(kind: str, left: Tree, right: Tree) -> Tree:
    return (kind, (*(left[1] if left[0] == kind else (left,)), right))


def from_sympy(value: sp.Expr) -> Tree:
    """The tree of a SymPy expression, terms and factors in its order of printing."""
    if value.is_Number:
        number = Fraction(int(value.p), int(value.q)) if value.is_Rational else Fraction(str(value))
        return ("num", number) if number >= 0 else ("neg", ("num", -number))
    if value.is_Symbol:
        return ("sym", value.name)
    if value.is_Add:
        return ("add", tuple(from_sympy(x) for x in value.as_ordered_terms()))
    if value.is_Pow:
        base, exponent = value.args
        if exponent == sp.Rational(1, 2):
            return ("fun", "sqrt", (from_sympy(base),))
        if exponent.could_extract_minus_sign():
            return ("div", ("num", Fraction(1)), from_sympy(base**-exponent))
        return ("pow", from_sympy(base), Fraction(int(exponent)))
    if value.is_Mul:
        if value.args[0].is_Number and value.args[0] < 0:
            return ("neg", from_sympy(-value))
        above, below = sp.fraction(value)
        if below != 1 and not (below.is_Number and above.is_Number):
            if below.is_Number:
                first, rest = above.as_coeff_Mul()
                ratio = first / below
                return _product([ratio, *sp.Mul.make_args(rest)])
            return ("div", from_sympy(above), from_sympy(below))
        return _product([x for x in value.as_ordered_factors() if x != 1])
    names = {"Abs": "abs"}
    name = value.func.__name__
    return ("fun", names.get(name, name), tuple(from_sympy(x) for x in value.args))


def _product(factors: list[sp.Expr]) -> Tree:
    factors = [x for x in factors if x != 1]
    parts = tuple(from_sympy(x) for x in factors)
    return parts[0] if len(parts) == 1 else ("mul", parts)


def value(one: Tree, env: dict[str, np.ndarray], second: Iterator[int] | None = None) -> Any:
    """The formula's numbers at all states of env; of a two-valued function, second (0 or 1 for each
    in turn) chooses the other value."""
    match one[0]:
        case "num":
            return float(one[1])
        case "sym":
            return env[one[1]]
        case "add":
            return sum(value(x, env, second) for x in one[1])
        case "mul":
            return math.prod(value(x, env, second) for x in one[1])
        case "neg":
            return -value(one[1], env, second)
        case "div":
            return value(one[1], env, second) / value(one[2], env, second)
        case "pow":
            return value(one[1], env, second) ** float(one[2])
        case "mat":
            return np.array([[_wide(value(x, env, second), env) for x in row] for row in one[1]])
    arguments = [value(x, env, second) for x in one[2]]
    found = FUNCTIONS[one[1]](*arguments)
    if second is not None and one[1] in TWO_VALUED and next(second):
        other = {"acos": -found, "sqrt": -found, "asin": np.pi - found}
        return other.get(one[1], found + np.pi if one[1] == "atan" else found)
    return found


def _wide(x: Any, env: dict[str, np.ndarray]) -> np.ndarray:
    return np.broadcast_to(x, env["one"].shape)


def two_valued(one: Tree) -> int:
    """How many functions of two values the formula has."""
    return sum(x[0] == "fun" and x[1] in TWO_VALUED for _, x in places(one))


def places(one: Tree, at: tuple[int, ...] = ()) -> Iterator[tuple[tuple[int, ...], Tree]]:
    """All parts of a tree, each with the way to it."""
    yield at, one
    for i, child in enumerate(children(one)):
        yield from places(child, (*at, i))


def children(one: Tree) -> tuple[Tree, ...]:
    """The parts directly below."""
    match one[0]:
        case "num" | "sym":
            return ()
        case "add" | "mul":
            return one[1]
        case "neg" | "pow":
            return (one[1],)
        case "div":
            return (one[1], one[2])
        case "mat":
            return tuple(itertools.chain.from_iterable(one[1]))
    return one[2]


def put(one: Tree, at: tuple[int, ...], new: Tree) -> Tree:
    """The tree with another part at a place."""
    if not at:
        return new
    below = list(children(one))
    below[at[0]] = put(below[at[0]], at[1:], new)
    match one[0]:
        case "add" | "mul":
            return (one[0], tuple(below))
        case "neg":
            return ("neg", below[0])
        case "pow":
            return ("pow", below[0], one[2])
        case "div":
            return ("div", below[0], below[1])
        case "mat":
            width = len(one[1][0])
            rows = [tuple(below[i : i + width]) for i in range(0, len(below), width)]
            return ("mat", tuple(rows))
    return ("fun", one[1], tuple(below))


def keys(one: Tree) -> set[str]:
    """The symbols of a formula."""
    return {x[1] for _, x in places(one) if x[0] == "sym"}


def size(one: Tree) -> int:
    """How many symbols and numbers are written."""
    return sum(x[0] in ("sym", "num") for _, x in places(one))
