"""The value of an expression in a xacro file, such as `${2*pi/3}`: a subset of Python's syntax, in
which only the listed nodes are allowed.

A file comes from anywhere, so nothing in it is run. The expression is parsed and walked: numbers,
text, lists, tuples, dicts, arithmetic, comparisons, conditions, comprehensions, keys, and calls of
the functions and methods in the tables below. No attribute of a Python object is ever looked up. A
count of steps and bounds on sizes keep every file finite.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import Any

from freebody.errors import likely, shown

_LONGEST = 4000  # characters of an expression
_LARGEST = 100_000  # characters of a text, or entries in a list with all that lies inside
_BITS = 4096  # of a whole number
_DEEPEST = 60  # nested parts of an expression


class ExpressionError(Exception):
    """Raised for an expression that cannot be evaluated, with a sentence that does not name its
    place."""


@dataclass
class Budget:
    """The work left for all expressions of a file: visiting a node costs ten; each entry of a list,
    or sixteen characters, made or compared costs one."""

    left: int = 6_000_000

    def spend(self, work: int) -> None:
        self.left -= work
        if self.left < 0:
            raise ExpressionError("the file's expressions take more work than those of any robot")


@dataclass(frozen=True)
class Namespace:
    """Names reached with a dot, such as `math.pi`, or those of an included file."""

    names: Mapping[str, Any]
    called: str = ""


@dataclass(frozen=True)
class XacroFunction:
    """A function that expressions may call. keywords: the names of arguments that it takes."""

    call: Callable[..., Any]
    keywords: frozenset[str] = field(default_factory=frozenset)


def _range(*bounds: int) -> list[int]:
    found = range(*bounds)
    if len(found) > _LARGEST:
        raise ExpressionError(f"range() with {len(found)} entries is too large")
    return list(found)


def _round(x: float, digits: int | None = None) -> float:
    if digits is not None and abs(digits) > _BITS:
        raise ExpressionError("round() to so many digits is too much")
    return round(x, digits)


def _replaced(text: str, old: str, new: str) -> str:
    if text.count(old) * len(new) > _LARGEST:
        raise ExpressionError("a text is too long")
    return text.replace(old, new)


def _joined(between: str, parts: list[str]) -> str:
    if len(between) * len(parts) > _LARGEST:
        raise ExpressionError("a text is too long")
    return between.join(parts)


def _tokenize(text: str, sep: str = ",; ", skip_empty: bool = True) -> list[str]:
    parts = [""]
    for character in text:
        if character in sep:
            parts.append("")
        else:
            parts[-1] += character
    return [part for part in parts if part] if skip_empty else parts


_NO_FUNCTIONS_OF_MATH = {"comb", "factorial", "perm", "isqrt", "lcm", "prod", "fsum", "dist"}
_MATH: dict[str, Any] = {
    name: XacroFunction(value) if callable(value) else value
    for name, value in vars(math).items()
    if not name.startswith("_") and name not in _NO_FUNCTIONS_OF_MATH
}
_PYTHON: dict[str, Any] = {
    "abs": XacroFunction(abs),
    "all": XacroFunction(all),
    "any": XacroFunction(any),
    "bool": XacroFunction(bool),
    "dict": XacroFunction(dict),
    "enumerate": XacroFunction(
        lambda of, start=0: list(enumerate(of, start)), frozenset({"start"})
    ),
    "float": XacroFunction(float),
    "int": XacroFunction(int),
    "len": XacroFunction(len),
    "list": XacroFunction(list),
    "max": XacroFunction(max),
    "min": XacroFunction(min),
    "range": XacroFunction(_range),
    "reversed": XacroFunction(lambda of: list(reversed(of))),
    "round": XacroFunction(_round),
    "sorted": XacroFunction(sorted, frozenset({"reverse"})),
    "str": XacroFunction(str),
    "sum": XacroFunction(sum),
    "tuple": XacroFunction(tuple),
    "zip": XacroFunction(lambda *of: list(zip(*of, strict=False))),
}
_CONSTANTS = {"True": True, "False": False, "None": None, "true": True, "false": False}
TOKENIZE = XacroFunction(_tokenize, frozenset({"sep", "skip_empty"}))
GLOBALS: dict[str, Any] = {
    **_CONSTANTS,
    **_MATH,
    **_PYTHON,
    "math": Namespace(_MATH, "math"),
    "python": Namespace(_PYTHON, "python"),
}
"""Names that every expression may use, besides the properties and macro parameters of its file."""

_METHODS: dict[type, dict[str, Callable[..., Any]]] = {
    str: {
        "count": str.count,
        "endswith": str.endswith,
        "find": str.find,
        "isdigit": str.isdigit,
        "join": _joined,
        "lower": str.lower,
        "lstrip": str.lstrip,
        "replace": _replaced,
        "rstrip": str.rstrip,
        "split": str.split,
        "startswith": str.startswith,
        "strip": str.strip,
        "upper": str.upper,
    },
    list: {"count": list.count, "index": list.index},
    dict: {
        "get": dict.get,
        "items": lambda of: list(of.items()),
        "keys": lambda of: list(of.keys()),
        "values": lambda of: list(of.values()),
    },
}


def _power(x: Any, y: Any) -> Any:
    if isinstance(x, int) and isinstance(y, int) and y > 0 and x.bit_length() * y > _BITS:
        raise ExpressionError("a power is too large")
    return x**y


def _times(x: Any, y: Any) -> Any:
    for text, times in ((x, y), (y, x)):
        if (
            isinstance(text, str | list | tuple)
            and isinstance(times, int)
            and len(text) * times > _LARGEST
        ):
            raise ExpressionError("a text or list is repeated too often")
    return x * y


def _modulo(x: Any, y: Any) -> Any:
    if isinstance(x, str):  # the width in a format can fill the memory
        raise ExpressionError("text with % is not read; use str() and +")
    return x % y


_BINARY: dict[type[ast.AST], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: _times,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: _modulo,
    ast.Pow: _power,
}
_UNARY: dict[type[ast.AST], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
}
_COMPARED: dict[type[ast.AST], Callable[[Any, Any], bool]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda x, y: x in y,
    ast.NotIn: lambda x, y: x not in y,
}


def size(value: Any) -> int:
    """The entries and sixteenths of characters in a value, what lies inside counted each time it
    does. Raises ExpressionError where they are too many."""
    left, open_values = _LARGEST, [value]
    while open_values:
        part = open_values.pop()
        if isinstance(part, str):
            left -= len(part) // 16
            if len(part) > _LARGEST:
                raise ExpressionError("a text is too long")
        elif isinstance(part, dict):
            left -= len(part)
            open_values += [*part.keys(), *part.values()] if left >= 0 else ()
        elif isinstance(part, list | tuple):
            left -= len(part)
            open_values += part if left >= 0 else ()
        if left < 0:
            raise ExpressionError("a list is too large")
    return _LARGEST - left


def evaluated(text: str, names: Mapping[str, Any], budget: Budget) -> Any:
    """The value of an expression over `names`. Raises ExpressionError for what is not allowed, not
    defined or cannot be computed."""
    text = text.strip()
    if len(text) > _LONGEST:
        raise ExpressionError(f"the expression has more than {_LONGEST} characters")
    try:
        tree = ast.parse(text, mode="eval").body
    except (SyntaxError, ValueError, MemoryError, RecursionError):
        raise ExpressionError(f"{shown(text)} is no expression") from None
    try:
        return _ExpressionWalk(names, budget).value(tree)
    except RecursionError:
        raise ExpressionError("the expression is nested too deeply") from None
    except (TypeError, ValueError, ArithmeticError, LookupError, AttributeError) as problem:
        told = " ".join(str(problem).split()) or type(problem).__name__
        raise ExpressionError(f"{shown(text)}: {told}") from None


class _ExpressionWalk:
    """The evaluation of one expression by a walk over its syntax tree."""

    def __init__(self, names: Mapping[str, Any], budget: Budget):
        self.names, self.budget, self.depth = names, budget, 0

    def value(self, node: ast.AST) -> Any:
        self.budget.spend(10)
        self.depth += 1
        if self.depth > _DEEPEST:
            raise ExpressionError("the expression is nested too deeply")
        read = _NODES.get(type(node))
        if read is None:
            kind = type(node).__name__
            raise ExpressionError(f"{shown(ast.unparse(node))} is not allowed ({kind})")
        found = read(self, node)
        self.depth -= 1
        return found

    def made(self, value: Any) -> Any:
        """The result of an operation; raises ExpressionError where it is too large or of a type
        that xacro has not."""
        if isinstance(value, int) and value.bit_length() > _BITS:
            raise ExpressionError("a whole number is too large")
        if isinstance(value, complex | bytes):
            raise ExpressionError(f"{shown(str(value))} is no value of a robot")
        self.budget.spend(size(value))
        return value

    def constant(self, node: ast.Constant) -> Any:
        if isinstance(node.value, bytes | complex) or node.value is ...:
            raise ExpressionError(f"{shown(ast.unparse(node))} is not allowed")
        return node.value

    def name(self, node: ast.Name) -> Any:
        for names in (self.names, GLOBALS):
            if node.id in names:
                return names[node.id]
        near = likely(node.id, [*self.names, *GLOBALS], most=3)
        hint = f"; similar names: {', '.join(near)}" if near else ""
        raise ExpressionError(f"{shown(node.id)} is not defined{hint}")

    def entries(self, node: ast.List | ast.Tuple) -> Any:
        found = [self.value(entry) for entry in node.elts]
        return self.made(found if isinstance(node, ast.List) else tuple(found))

    def mapping(self, node: ast.Dict) -> dict[Any, Any]:
        if None in node.keys:
            raise ExpressionError("** in a dict is not allowed")
        return self.made(
            {
                self.value(key): self.value(entry)
                for key, entry in zip(node.keys, node.values, strict=True)
                if key is not None
            }
        )

    def binary(self, node: ast.BinOp) -> Any:
        act = _BINARY.get(type(node.op))
        if act is None:
            raise ExpressionError(f"{shown(ast.unparse(node))}: this operator is not allowed")
        return self.made(act(self.value(node.left), self.value(node.right)))

    def unary(self, node: ast.UnaryOp) -> Any:
        act = _UNARY.get(type(node.op))
        if act is None:
            raise ExpressionError(f"{shown(ast.unparse(node))}: this operator is not allowed")
        return act(self.value(node.operand))

    def boolean(self, node: ast.BoolOp) -> Any:
        stops = isinstance(node.op, ast.Or)
        found: Any = None
        for part in node.values:
            found = self.value(part)
            if bool(found) is stops:
                break
        return found

    def comparison(self, node: ast.Compare) -> bool:
        left = self.value(node.left)
        for sign, part in zip(node.ops, node.comparators, strict=True):
            right = self.value(part)
            self.budget.spend(size(left) + size(right))
            if not _COMPARED[type(sign)](left, right):
                return False
            left = right
        return True

    def condition(self, node: ast.IfExp) -> Any:
        return self.value(node.body if self.value(node.test) else node.orelse)

    def entry(self, node: ast.Subscript) -> Any:
        return self.value(node.value)[self.key(node.slice)]

    def key(self, node: ast.AST) -> Any:
        if not isinstance(node, ast.Slice):
            return self.value(node)
        bounds = (node.lower, node.upper, node.step)
        return slice(*(None if bound is None else self.value(bound) for bound in bounds))

    def dotted(self, node: ast.Attribute) -> Any:
        """A name in a namespace, a key of a dict, or a method of a text, list or dict."""
        owner = self.value(node.value)
        if isinstance(owner, Namespace):
            if node.attr in owner.names:
                return owner.names[node.attr]
            raise ExpressionError(f"{shown(ast.unparse(node))} is not defined")
        if isinstance(owner, dict) and node.attr in owner:
            return owner[node.attr]
        method = _METHODS.get(type(owner), {}).get(node.attr)
        if method is not None:
            return XacroFunction(partial(method, owner))
        raise ExpressionError(f"{shown(ast.unparse(node))} is not allowed")

    def call(self, node: ast.Call) -> Any:
        called = self.value(node.func)
        if not isinstance(called, XacroFunction):
            raise ExpressionError(f"{shown(ast.unparse(node.func))} is no function")
        arguments = [self.value(argument) for argument in node.args]
        keywords: dict[str, Any] = {}
        for keyword in node.keywords:
            if keyword.arg is None or (
                keyword.arg not in called.keywords and called.call is not dict
            ):
                raise ExpressionError(f"{shown(ast.unparse(node))}: no such argument")
            keywords[keyword.arg] = self.value(keyword.value)
        self.budget.spend(sum(map(size, arguments)))
        return self.made(called.call(*arguments, **keywords))

    def comprehension(self, node: ast.ListComp | ast.GeneratorExp | ast.DictComp) -> Any:
        outer = self.names
        try:
            if isinstance(node, ast.DictComp):
                return self.made(
                    {
                        self.value(node.key): self.value(node.value)
                        for _ in self.rounds(node.generators, outer)
                    }
                )
            return self.made([self.value(node.elt) for _ in self.rounds(node.generators, outer)])
        finally:
            self.names = outer

    def rounds(self, loops: list[ast.comprehension], names: Mapping[str, Any]) -> Iterator[None]:
        """Run through all rounds of a comprehension's loops, with their names bound, yielding once
        for each."""
        if not loops:
            self.names = names
            yield
            return
        first, *rest = loops
        if first.is_async:
            raise ExpressionError("async is not allowed")
        self.names = names
        for item in self.value(first.iter):
            self.names = inner = {**names, **self.bound_names(first.target, item)}
            if all(self.value(test) for test in first.ifs):
                yield from self.rounds(rest, inner)

    def bound_names(self, target: ast.AST, value: Any) -> dict[str, Any]:
        if isinstance(target, ast.Name):
            return {target.id: value}
        if isinstance(target, ast.Tuple | ast.List):
            found: dict[str, Any] = {}
            for part, entry in zip(target.elts, value, strict=True):
                found |= self.bound_names(part, entry)
            return found
        raise ExpressionError(f"{shown(ast.unparse(target))} is not allowed")


_NODES: dict[type[ast.AST], Callable[[_ExpressionWalk, Any], Any]] = {
    ast.Constant: _ExpressionWalk.constant,
    ast.Name: _ExpressionWalk.name,
    ast.List: _ExpressionWalk.entries,
    ast.Tuple: _ExpressionWalk.entries,
    ast.Dict: _ExpressionWalk.mapping,
    ast.BinOp: _ExpressionWalk.binary,
    ast.UnaryOp: _ExpressionWalk.unary,
    ast.BoolOp: _ExpressionWalk.boolean,
    ast.Compare: _ExpressionWalk.comparison,
    ast.IfExp: _ExpressionWalk.condition,
    ast.Subscript: _ExpressionWalk.entry,
    ast.Attribute: _ExpressionWalk.dotted,
    ast.Call: _ExpressionWalk.call,
    ast.ListComp: _ExpressionWalk.comprehension,
    ast.GeneratorExp: _ExpressionWalk.comprehension,
    ast.DictComp: _ExpressionWalk.comprehension,
}
