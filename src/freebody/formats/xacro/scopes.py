"""Names of a xacro file: properties, each read when it is first asked for, and macros with their
parameters, scope over scope."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from freebody.errors import shown
from freebody.formats.urdf_elements import XmlElement
from freebody.formats.xacro.values import ExpressionError

_PARAMETER = re.compile(
    r"\s*(?P<name>[^\s:=]+)"
    r"(?:\s*:?=\s*(?P<forward>\^\|?)?"
    r"(?P<default>\$\{[^}]*\}|\$\([^)]*\)|(?:'[^']*'|\"[^\"]*\"|[^\s'\"])*))?"
)
TRUE, FALSE = ("true", "True"), ("false", "False")
_CIRCULAR = object()


@dataclass(frozen=True)
class MacroParameter:
    """A parameter of a macro: `name` (with * or ** for a block), whether the caller's value of that
    name is its default, and a default's text."""

    name: str
    forward: bool
    default: str | None


@dataclass(frozen=True)
class XacroMacro:
    """A macro as it is written: its parameters in order, and the element that it stands for."""

    name: str
    parameters: tuple[MacroParameter, ...]
    body: XmlElement


class XacroScope(Mapping[str, Any]):
    """Names of a file, a macro's call or a namespace, backed by the scopes around it. A text that
    is no literal is evaluated when its name is first used."""

    def __init__(
        self, evaluate: Callable[[str, XacroScope], Any], around: XacroScope | None = None
    ):
        self.evaluate, self.around = evaluate, around
        self.values: dict[str, Any] = {}
        self.unread: dict[str, str] = {}
        self.macros: dict[str, XacroMacro] = {}
        self.namespaces: dict[str, XacroScope] = {}
        self.space = False

    def __getitem__(self, name: str) -> Any:
        scope = self.holding(name)
        if scope is None:
            raise KeyError(name)
        if name in scope.unread:
            text = scope.unread.pop(name)
            scope.values[name] = _CIRCULAR
            scope.values[name] = literal(scope.evaluate(text, scope))
        if scope.values[name] is _CIRCULAR:
            raise ExpressionError(f"property {shown(name)} is defined by itself")
        return scope.values[name]

    def __iter__(self) -> Iterator[str]:
        for scope in self.chain():
            yield from scope.values

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def chain(self) -> Iterator[XacroScope]:
        scope: XacroScope | None = self
        while scope is not None:
            yield scope
            scope = scope.around

    def holding(self, name: str) -> XacroScope | None:
        return next((scope for scope in self.chain() if name in scope.values), None)

    def __contains__(self, name: object) -> bool:
        return any(name in scope.values for scope in self.chain())

    def put(self, name: str, value: Any, lazily: bool = False) -> None:
        value = literal(value)
        self.unread.pop(name, None)
        self.values[name] = value
        if lazily and isinstance(value, str):
            self.unread[name] = value

    def drop(self, name: str) -> None:
        for scope in self.chain():
            scope.values.pop(name, None)
            scope.unread.pop(name, None)

    def outer(self, where: str) -> XacroScope:
        """The scope of the whole file ("global") or of the caller ("parent")."""
        *_, outermost = self.chain()
        if where == "global" or self.around is None:
            return outermost
        around = (scope for scope in self.around.chain() if self.space or not scope.space)
        return next(around, outermost)

    def macro(self, name: str) -> tuple[XacroMacro, XacroScope] | None:
        """The macro of that name, perhaps with namespaces in front, and the scope in which it is
        called; None where there is none."""
        for scope in self.chain():
            if name in scope.macros:
                return scope.macros[name], self
        first, dot, rest = name.partition(".")
        for scope in self.chain() if dot else ():
            if first in scope.namespaces:
                return scope.namespaces[first].macro(rest)
        return None


def parameters_of(text: str) -> tuple[MacroParameter, ...]:
    """The parameters that a macro's `params` names, in order."""
    return tuple(
        MacroParameter(
            found["name"],
            found["forward"] is not None,
            found["default"] or None,
        )
        for found in _PARAMETER.finditer(text)
    )


def literal(value: Any) -> Any:
    """The number, truth value or quoted text that a text stands for; anything else as it is."""
    if not isinstance(value, str):
        return value
    if len(value) >= 2 and value[0] == value[-1] == "'":
        return value[1:-1]
    if "_" in value:
        return value
    for read in (int, float):
        try:
            return read(value)
        except ValueError:
            pass
    return True if value in TRUE else False if value in FALSE else value
