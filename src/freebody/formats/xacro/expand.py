"""The URDF that a xacro file stands for: properties, macros, includes, conditions and `$(…)`
replaced, each element with the file and line it was written on.

The order of things is that of ROS's own tool (version 2): a property's value is evaluated when it
is first used, a macro's names hide those of its caller, blocks are evaluated where they are
written. A file comes from anywhere: expressions are walked, not run (see `values`), only files of
packages that are around it or named by the user are read, an environment variable only where the
caller allows it, and every kind of growth has a bound.
"""

from __future__ import annotations

import fnmatch
import os
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn

from freebody.errors import FileError, IncludedLine, UnknownNameError, listed, shown
from freebody.formats import read_file
from freebody.formats.packages import Packages
from freebody.formats.urdf_elements import XmlElement, parse
from freebody.formats.xacro.values import (
    GLOBALS,
    TOKENIZE,
    Budget,
    ExpressionError,
    Namespace,
    XacroFunction,
    evaluated,
    size,
)
from freebody.formats.xacro.yaml_files import read_yaml
from freebody.model.description import Notice

_PREFIX = "xacro:"
_ELEMENTS = 50_000  # that an expansion makes
_DEEPEST = 100  # macros, includes and blocks inside each other
_TEXT = 4000  # characters read of an element's text
_PARTS = re.compile(
    r"(?P<escaped>\$\$+[{(])"
    r"|\$\{(?P<expression>[^}]*)\}"
    r"|\$\((?P<command>(?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)"
    r"|(?P<text>[^$]+|\$(?![{($])[^$]*|\$$)"
)
_PARAMETER = re.compile(
    r"\s*(?P<name>[^\s:=]+)"
    r"(?:\s*:?=\s*(?P<forward>\^\|?)?"
    r"(?P<default>\$\{[^}]*\}|\$\([^)]*\)|(?:'[^']*'|\"[^\"]*\"|[^\s'\"])*))?"
)
_TRUE, _FALSE = ("true", "True"), ("false", "False")


@dataclass(frozen=True)
class _MacroParameter:
    """A parameter of a macro: `name` (with * or ** for a block), whether the caller's value of that
    name is its default, and a default's text."""

    name: str
    forward: bool
    default: str | None


@dataclass(frozen=True)
class _XacroMacro:
    """A macro as it is written: its parameters in order, and the element that it stands for."""

    name: str
    parameters: tuple[_MacroParameter, ...]
    body: XmlElement


class _Scope(Mapping[str, Any]):
    """Names of a file, a macro's call or a namespace, over those around it. Text that is no literal
    is evaluated when it is first asked for."""

    def __init__(self, evaluate: Callable[[str, _Scope], Any], around: _Scope | None = None):
        self.evaluate, self.around = evaluate, around
        self.values: dict[str, Any] = {}
        self.unread: dict[str, str] = {}
        self.macros: dict[str, _XacroMacro] = {}
        self.namespaces: dict[str, _Scope] = {}
        self.space = False

    def __getitem__(self, name: str) -> Any:
        scope = self.holding(name)
        if scope is None:
            raise KeyError(name)
        if name in scope.unread:
            text = scope.unread.pop(name)
            scope.values[name] = _CIRCULAR
            scope.values[name] = _literal(scope.evaluate(text, scope))
        if scope.values[name] is _CIRCULAR:
            raise ExpressionError(f"property {shown(name)} is defined by itself")
        return scope.values[name]

    def __iter__(self) -> Iterator[str]:
        for scope in self.chain():
            yield from scope.values

    def __len__(self) -> int:
        return sum(1 for _ in self)

    def chain(self) -> Iterator[_Scope]:
        scope: _Scope | None = self
        while scope is not None:
            yield scope
            scope = scope.around

    def holding(self, name: str) -> _Scope | None:
        return next((scope for scope in self.chain() if name in scope.values), None)

    def __contains__(self, name: object) -> bool:
        return any(name in scope.values for scope in self.chain())

    def put(self, name: str, value: Any, lazily: bool = False) -> None:
        value = _literal(value)
        self.unread.pop(name, None)
        self.values[name] = value
        if lazily and isinstance(value, str):
            self.unread[name] = value

    def drop(self, name: str) -> None:
        for scope in self.chain():
            scope.values.pop(name, None)
            scope.unread.pop(name, None)

    def outer(self, where: str) -> _Scope:
        """The file's scope ("global"), or that of the caller ("parent")."""
        *_, outermost = self.chain()
        if where == "global" or self.around is None:
            return outermost
        around = (scope for scope in self.around.chain() if self.space or not scope.space)
        return next(around, outermost)

    def macro(self, name: str) -> tuple[_XacroMacro, _Scope] | None:
        """The macro of that name, perhaps with namespaces before it, and the scope it is called
        over."""
        for scope in self.chain():
            if name in scope.macros:
                return scope.macros[name], self
        first, dot, rest = name.partition(".")
        for scope in self.chain() if dot else ():
            if first in scope.namespaces:
                return scope.namespaces[first].macro(rest)
        return None


_CIRCULAR = object()


@dataclass(frozen=True)
class Expanded:
    """Result of a xacro file: the URDF's root, notices, and the macros that it defines, or else
    those of its includes, each as `name(parameters)`."""

    root: XmlElement
    notices: tuple[Notice, ...]
    macros: tuple[str, ...]


def expanded(
    file: str,
    data: bytes,
    packages: Packages,
    arguments: Mapping[str, object],
    environment: Sequence[str] = (),
) -> Expanded:
    """The expansion of a xacro file's bytes. arguments: values for its `<xacro:arg>`; environment:
    the variables that `$(env NAME)` may read. Raises FileError with the file and line of what
    cannot be expanded."""
    return _XacroExpansion(file, packages, arguments, environment).of(parse(file, data, _TEXT))


def without_links(found: Expanded) -> str:
    """The reason why a file without links is no robot: it defines macros, or nothing at all."""
    if not found.macros:
        return "there are no links in the file's expansion; a robot needs at least one."
    return (
        f"the file has no links of its own, it defines macros: {listed(found.macros, 5)}. Load the "
        "file that calls them, often in the same folder."
    )


class _XacroExpansion:
    """One file being expanded, with the files that it includes."""

    def __init__(
        self,
        file: str,
        packages: Packages,
        arguments: Mapping[str, object],
        environment: Sequence[str],
    ):
        self.files, self.packages, self.environment = [file], packages, environment
        self.arguments: dict[str, Any] = dict(arguments)
        self.given, self.declared = tuple(arguments), list[str]()
        self.budget, self.left, self.depth = Budget(), _ELEMENTS, 0
        self.notices: list[Notice] = []
        self.known: dict[str, XmlElement] = {}
        self.defined: dict[str, _XacroMacro] = {}
        self.place: XmlElement | None = None
        self.bare = ""
        self.roots = [*packages.readable]

    def of(self, root: XmlElement) -> Expanded:
        scope = _Scope(self.value)
        scope.put("xacro", Namespace(self.functions(), "xacro"))
        made = XmlElement(root.tag, {}, root.line, file=root.file)
        try:
            made.attributes = self.attributes(root, scope)
            self.children(root, scope, made)
        except ExpressionError as problem:
            bare = f" {self.bare}" if self.bare else ""
            self.refuse(self.place or root, f"{problem}.{bare}")
        except RecursionError:
            self.refuse(self.place or root, "macros or blocks are nested too deeply.")
        for name in self.given:
            if name not in self.declared:
                problem = UnknownNameError("argument", name, "its <xacro:arg>", self.declared)
                raise FileError(self.files[0], None, f"{problem}")
        own = [m for m in self.defined.values() if m.body.file == root.file]
        macros = tuple(
            f"{m.name}({', '.join(x.name for x in m.parameters)})"
            for m in own or self.defined.values()
        )
        return Expanded(made, tuple(self.notices), macros)

    # ------------------------------------------------------------ elements
    def children(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        """The elements inside, expanded, become `into`'s."""
        self.depth += 1
        if self.depth > _DEEPEST:
            self.refuse(
                source, f"macros, includes and blocks are nested more than {_DEEPEST} deep."
            )
        for child in source.children:
            self.place = child
            self.element(child, scope, into)
        self.depth -= 1

    def element(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        if source.tag in _TAGS:
            _TAGS[source.tag](self, source, scope, into)
        elif source.tag.startswith(_PREFIX):
            self.call(source, source.tag.removeprefix(_PREFIX), scope, into)
        else:
            self.plain(source, source.tag, self.attributes(source, scope), scope, into)

    def plain(
        self,
        source: XmlElement,
        tag: str,
        attributes: dict[str, str],
        scope: _Scope,
        into: XmlElement,
    ) -> None:
        if not self.bare and _PREFIX + tag in _TAGS:
            self.bare = f"<{tag}> on line {source.line} lacks its prefix xacro: and is not read."
        self.left -= 1
        if self.left < 0:
            self.refuse(source, f"the expansion has more than {_ELEMENTS} elements.")
        content = str(self.value(source.content, scope)) if source.content else ""
        line = source.line
        if source.file != self.files[0] and isinstance(line, int):
            line = IncludedLine(source.file, line)
        made = XmlElement(tag, attributes, line, [], content, source.file)
        into.children.append(made)
        self.children(source, scope, made)

    def attributes(self, source: XmlElement, scope: _Scope) -> dict[str, str]:
        return {
            key: str(self.value(text, scope))
            for key, text in source.attributes.items()
            if not key.startswith((_PREFIX, f"xmlns:{_PREFIX[:-1]}"))
        }

    def include(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "filename"), scope))
        space = source.attributes.get("ns")
        inner = scope
        if space:
            called = str(self.value(space, scope))
            inner = _Scope(self.value, scope)
            inner.space = True
            scope.namespaces[called] = inner
            scope.put(called, Namespace(inner, called))
        optional = self.flag(source, "optional", scope, default=False)
        for path in self.included(source, name):
            try:
                root = self.parsed(source, path)
            except FileError as problem:
                if optional and not path.exists():
                    continue
                raise problem
            self.files.append(os.fspath(path))
            self.children(root, inner, into)
            self.files.pop()

    def included(self, source: XmlElement, name: str) -> list[Path]:
        if name.startswith("package://"):
            package = name.removeprefix("package://").partition("/")[0]
            self.refuse(
                source,
                f"package {shown(package)} was not found around the file; name its folder with "
                f"package_path= (--package-path, or FREEBODY_PACKAGE_PATH).",
            )
        path = Path(os.path.dirname(self.files[-1]), name)
        if not set(path.name) & set("*?["):
            return [path]
        self.readable(source, path.parent)
        found = sorted(x for x in path.parent.glob("*") if fnmatch.fnmatch(x.name, path.name))
        if not found:
            text = f"<{source.tag}>: no file is called {path.name!r} in its folder."
            self.notices.append(Notice("xacro", text, source.file, source.line))
        return found

    def parsed(self, source: XmlElement, path: Path) -> XmlElement:
        """The root of an included file, read once."""
        self.readable(source, path)
        key = os.fspath(path)
        if key not in self.known:
            if len(self.known) > 500:
                self.refuse(source, "more than 500 files are included.")
            try:
                data = read_file.read(path)
            except FileError as problem:
                self.refuse(source, f"<{source.tag}> of {shown(key)}: {problem.problem}")
            self.known[key] = parse(key, data, _TEXT)
        return self.known[key]

    def readable(self, source: XmlElement, path: Path) -> None:
        """Refuse a path outside the packages."""
        real = Path(os.path.realpath(path))
        if not any(real.is_relative_to(os.path.realpath(root)) for root in self.roots):
            self.refuse(
                source,
                f"{shown(os.fspath(path))} lies outside the file's package and is not read; name "
                f"its folder with package_path= (--package-path, or FREEBODY_PACKAGE_PATH).",
            )

    def define(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = self.given_text(source, "name").removeprefix(_PREFIX)
        if name == "call" or "." in name:
            self.refuse(source, f"a macro cannot be called {shown(name)}.")
        scope.macros[name] = self.defined[name] = _XacroMacro(
            name, _parameters(source.attributes.get("params", "")), source
        )

    def property(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        given = source.attributes
        name = str(self.value(self.given_text(source, "name"), scope))
        if not name.isidentifier() or name.startswith("__"):
            self.refuse(source, f"a property cannot be called {shown(name)}.")
        if self.flag(source, "remove", scope, default=False):
            scope.drop(name)
            return
        value: Any = given.get("value")
        if "default" in given:
            if name in scope or value is not None:
                return
            value = given["default"]
        if value is None:
            scope.put(f"**{name}", source)
            return
        lazily, target = self.flag(source, "lazy_eval", scope, default=True), scope
        where = given.get("scope")
        if where in ("global", "parent"):
            lazily, target = False, scope.outer(where)
        target.put(name, value if lazily else self.value(value, scope), lazily)

    def argument(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = self.given_text(source, "name")
        self.declared.append(name)
        if name not in self.arguments:
            if "default" not in source.attributes:
                self.refuse(
                    source,
                    f"argument {name!r} has no default; give it with xacro={{{name!r}: …}} "
                    f"(--xacro {name}:=…).",
                )
            self.arguments[name] = str(self.value(source.attributes["default"], scope))

    def named_element(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        tag = str(self.value(self.given_text(source, "xacro:name"), scope))
        if not tag:
            self.refuse(source, "<xacro:element> has an empty name.")
        named = XmlElement(tag, source.attributes, source.line, source.children, "", source.file)
        self.element(named, scope, into)

    def attribute(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "name"), scope))
        into.attributes[name] = str(self.value(self.given_text(source, "value"), scope))

    def when(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        if self.flag(source, "value", scope) is (source.tag == "xacro:if"):
            self.children(source, scope, into)

    def insert(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = self.given_text(source, "name")
        if f"**{name}" in scope:
            self.children(scope[f"**{name}"], scope, into)
        elif f"*{name}" in scope:
            self.children(XmlElement("", {}, source.line, [scope[f"*{name}"]]), scope, into)
        else:
            self.refuse(source, f"there is no block {shown(name)}.")

    def named_call(self, source: XmlElement, scope: _Scope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "macro"), scope))
        rest = {key: text for key, text in source.attributes.items() if key != "macro"}
        call = XmlElement(source.tag, rest, source.line, source.children, "", source.file)
        self.call(call, name, scope, into)

    def call(self, source: XmlElement, name: str, scope: _Scope, into: XmlElement) -> None:
        found = scope.macro(name)
        if found is None:
            known = list(self.defined)
            self.refuse(source, str(UnknownNameError("macro", name, "the file", known)))
        macro, over = found
        inner = _Scope(self.value, over)
        known = {parameter.name for parameter in macro.parameters}
        for key, text in source.attributes.items():
            if key.startswith("xmlns:"):
                continue
            if key not in known:
                problem = UnknownNameError("parameter", key, f"macro {name!r}", sorted(known))
                self.refuse(source, str(problem))
            inner.put(key, self.value(text, scope))
        blocks = XmlElement("", {}, source.line, file=source.file)
        self.children(source, scope, blocks)
        self.place = source
        waiting = iter(blocks.children)
        for parameter in macro.parameters:
            if parameter.name.startswith("*"):
                block = next(waiting, None)
                if block is None:
                    self.refuse(source, f"macro {name!r} needs a block for {parameter.name!r}.")
                inner.put(parameter.name, block)
            elif parameter.name not in inner.values:
                self.default(source, macro, parameter, scope, inner)
        left = next(waiting, None)
        if left is not None:
            self.refuse(source, f"macro {name!r} takes no block <{left.tag}>.")
        self.children(macro.body, inner, into)

    def default(
        self,
        source: XmlElement,
        macro: _XacroMacro,
        parameter: _MacroParameter,
        scope: _Scope,
        inner: _Scope,
    ) -> None:
        """A parameter that a call does not give: the caller's value of that name, or a default."""
        if parameter.forward and parameter.name in scope:
            inner.put(parameter.name, scope[parameter.name])
        elif parameter.default is not None:
            inner.put(parameter.name, self.value(parameter.default, scope))
        else:
            self.refuse(source, f"macro {macro.name!r} needs parameter {parameter.name!r}.")

    # ------------------------------------------------------------ values
    def given_text(self, source: XmlElement, key: str) -> str:
        text = source.attributes.get(key, "")
        if not text:
            self.refuse(source, f'<{source.tag}> has no {key}; add {key}="...".')
        return text

    def flag(
        self, source: XmlElement, key: str, scope: _Scope, default: bool | None = None
    ) -> bool:
        """A condition: true, false or a number."""
        if default is not None and key not in source.attributes:
            return default
        text = self.given_text(source, key)
        value = self.value(text, scope)
        if not isinstance(value, str):
            return bool(value)
        if value in (*_TRUE, *_FALSE):
            return value in _TRUE
        try:
            return bool(int(value))
        except ValueError:
            self.refuse(
                source, f"{key} of <{source.tag}> is {shown(value)}, expected true or false."
            )

    def value(self, text: str, scope: Mapping[str, Any]) -> Any:
        """The value of a text with ${…} and $(…) in it: of one alone its own, else text."""
        self.budget.spend(1 + len(text) // 16)
        parts, at = list[Any](), 0
        while at < len(text):
            found = _PARTS.match(text, at)
            if found is None:
                raise ExpressionError(f"{shown(text[at:])} has no end")
            at = found.end()
            kind, part = str(found.lastgroup), found[str(found.lastgroup)]
            if kind == "expression":
                inside = self.value(part, scope)
                parts.append(
                    evaluated(inside, scope, self.budget) if isinstance(inside, str) else inside
                )
            elif kind == "command":
                parts.append(self.command(str(self.value(part, scope)), scope))
            else:
                parts.append(part[1:] if kind == "escaped" else part)
        if len(parts) == 1:
            return parts[0]
        for part in parts:
            self.budget.spend(size(part))
        joined = "".join(map(str, parts))
        self.budget.spend(size(joined))
        return joined

    def command(self, text: str, scope: Mapping[str, Any]) -> Any:
        """Value of a substitution $(…) whose inside is `text`."""
        name, _, rest = text.strip().partition(" ")
        if name == "eval":
            read = {"arg": XacroFunction(lambda of: _literal(self.arg(of)))}
            names = {**self.arguments_read(), **self.commands(), **read}
            return evaluated(rest, names, self.budget)
        if name == "cwd":
            return os.getcwd()
        known = self.commands()
        if name not in known:
            problem = UnknownNameError("command", name, "$(…)", [*known, "eval", "cwd"])
            raise ExpressionError(str(problem).removesuffix("."))
        return known[name].call(*rest.split(maxsplit=1 if name == "optenv" else -1))

    def commands(self) -> dict[str, XacroFunction]:
        return {
            "arg": XacroFunction(self.arg),
            "find": XacroFunction(self.find),
            "env": XacroFunction(self.env),
            "optenv": XacroFunction(self.optenv),
            "dirname": XacroFunction(lambda: os.path.dirname(os.path.abspath(self.files[-1]))),
        }

    def functions(self) -> dict[str, Any]:
        """The names behind `xacro.` in expressions."""

        def told(*texts: object) -> str:
            text = " ".join(map(str, texts))
            self.notices.append(Notice("xacro", f"the file says: {shown(text)}", self.files[-1]))
            return ""

        def fatal(*texts: object) -> NoReturn:
            raise ExpressionError(f"the file says: {shown(' '.join(map(str, texts)))}")

        def absolute(name: str) -> str:
            return os.path.join(os.path.dirname(os.path.abspath(self.files[-1])), name)

        return {
            "load_yaml": XacroFunction(self.load_yaml),
            "abs_filename": XacroFunction(absolute),
            "arg": XacroFunction(self.arg),
            "dotify": XacroFunction(dict),
            "tokenize": TOKENIZE,
            **{name: XacroFunction(told) for name in ("message", "warning", "error")},
            "fatal": XacroFunction(fatal),
        }

    def arg(self, name: str) -> Any:
        if name not in self.arguments:
            problem = UnknownNameError("argument", name, "the file", list(self.arguments))
            raise ExpressionError(str(problem).removesuffix("."))
        return self.arguments[name]

    def arguments_read(self) -> dict[str, Any]:
        return {name: _literal(value) for name, value in self.arguments.items()}

    def find(self, name: str) -> str:
        """The folder of a package. What is not found is left as its name: a mesh in it plays no
        part, and an include of it is refused with that name."""
        folder = self.packages.find(name)
        if folder is None:
            return f"package://{name}"
        self.roots.append(folder)
        return os.fspath(folder)

    def env(self, name: str) -> str:
        if name not in self.environment:
            raise ExpressionError(
                f"the environment variable {shown(name)} is not read; allow it with "
                f"xacro_environment=({name!r},) (--xacro-environment {name})"
            )
        if name not in os.environ:
            raise ExpressionError(f"the environment variable {shown(name)} is not set")
        return os.environ[name]

    def optenv(self, name: str, default: str = "") -> str:
        return os.environ.get(name, default) if name in self.environment else default

    def load_yaml(self, name: str) -> Any:
        path = Path(os.path.dirname(self.files[-1]), name)
        source = self.place or XmlElement("", {}, 0, file=self.files[-1])
        self.readable(source, path)
        found = read_yaml(path, lambda text: evaluated(text, GLOBALS, self.budget))
        self.budget.spend(size(found))
        return found

    def refuse(self, source: XmlElement, problem: str) -> NoReturn:
        raise FileError(source.file or self.files[-1], source.line or None, problem)


_TAGS: dict[str, Callable[[_XacroExpansion, XmlElement, _Scope, XmlElement], None]] = {
    "xacro:arg": _XacroExpansion.argument,
    "xacro:attribute": _XacroExpansion.attribute,
    "xacro:call": _XacroExpansion.named_call,
    "xacro:element": _XacroExpansion.named_element,
    "xacro:if": _XacroExpansion.when,
    "xacro:include": _XacroExpansion.include,
    "xacro:insert_block": _XacroExpansion.insert,
    "xacro:macro": _XacroExpansion.define,
    "xacro:property": _XacroExpansion.property,
    "xacro:unless": _XacroExpansion.when,
}


def _parameters(text: str) -> tuple[_MacroParameter, ...]:
    return tuple(
        _MacroParameter(
            found["name"],
            found["forward"] is not None,
            found["default"] or None,
        )
        for found in _PARAMETER.finditer(text)
    )


def _literal(value: Any) -> Any:
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
    return True if value in _TRUE else False if value in _FALSE else value
