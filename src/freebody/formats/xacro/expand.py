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
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from freebody.errors import FileError, IncludedLine, UnknownNameError, listed, shown
from freebody.formats import read_file
from freebody.formats.packages import Packages
from freebody.formats.urdf_elements import XmlElement, parse
from freebody.formats.xacro.scopes import (
    FALSE,
    TRUE,
    MacroParameter,
    XacroMacro,
    XacroScope,
    parameters_of,
)
from freebody.formats.xacro.texts import XacroTexts
from freebody.formats.xacro.values import ExpressionError, Namespace
from freebody.model.description import Notice

_PREFIX = "xacro:"
_ELEMENTS = 50_000  # that an expansion makes
_DEEPEST = 100  # macros, includes and blocks inside each other
_TEXT = 4000  # characters read of an element's text


@dataclass(frozen=True)
class Expanded:
    """The result of expanding a xacro file: the URDF's root, notices, and the macros that it (or
    else its includes) defines, each as `name(parameters)`."""

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


class _XacroExpansion(XacroTexts):
    """The expansion of one xacro file with the files that it includes."""

    def __init__(
        self,
        file: str,
        packages: Packages,
        arguments: Mapping[str, object],
        environment: Sequence[str],
    ):
        super().__init__(file, packages, arguments, environment)
        self.given, self.declared = tuple(arguments), list[str]()
        self.left, self.depth = _ELEMENTS, 0
        self.known: dict[str, XmlElement] = {}
        self.defined: dict[str, XacroMacro] = {}
        self.bare = ""

    def of(self, root: XmlElement) -> Expanded:
        scope = XacroScope(self.value)
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
    def children(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        """Append the expansion of an element's children to another element."""
        self.depth += 1
        if self.depth > _DEEPEST:
            self.refuse(
                source, f"macros, includes and blocks are nested more than {_DEEPEST} deep."
            )
        for child in source.children:
            self.place = child
            self.element(child, scope, into)
        self.depth -= 1

    def element(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
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
        scope: XacroScope,
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

    def attributes(self, source: XmlElement, scope: XacroScope) -> dict[str, str]:
        return {
            key: str(self.value(text, scope))
            for key, text in source.attributes.items()
            if not key.startswith((_PREFIX, f"xmlns:{_PREFIX[:-1]}"))
        }

    def include(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "filename"), scope))
        space = source.attributes.get("ns")
        inner = scope
        if space:
            called = str(self.value(space, scope))
            inner = XacroScope(self.value, scope)
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
        """The root element of an included file, which is read only once."""
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

    def define(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        name = self.given_text(source, "name").removeprefix(_PREFIX)
        if name == "call" or "." in name:
            self.refuse(source, f"a macro cannot be called {shown(name)}.")
        scope.macros[name] = self.defined[name] = XacroMacro(
            name, parameters_of(source.attributes.get("params", "")), source
        )

    def property(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
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

    def argument(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
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

    def named_element(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        tag = str(self.value(self.given_text(source, "xacro:name"), scope))
        if not tag:
            self.refuse(source, "<xacro:element> has an empty name.")
        named = XmlElement(tag, source.attributes, source.line, source.children, "", source.file)
        self.element(named, scope, into)

    def attribute(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "name"), scope))
        into.attributes[name] = str(self.value(self.given_text(source, "value"), scope))

    def when(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        if self.flag(source, "value", scope) is (source.tag == "xacro:if"):
            self.children(source, scope, into)

    def insert(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        name = self.given_text(source, "name")
        if f"**{name}" in scope:
            self.children(scope[f"**{name}"], scope, into)
        elif f"*{name}" in scope:
            self.children(XmlElement("", {}, source.line, [scope[f"*{name}"]]), scope, into)
        else:
            self.refuse(source, f"there is no block {shown(name)}.")

    def named_call(self, source: XmlElement, scope: XacroScope, into: XmlElement) -> None:
        name = str(self.value(self.given_text(source, "macro"), scope))
        rest = {key: text for key, text in source.attributes.items() if key != "macro"}
        call = XmlElement(source.tag, rest, source.line, source.children, "", source.file)
        self.call(call, name, scope, into)

    def call(self, source: XmlElement, name: str, scope: XacroScope, into: XmlElement) -> None:
        found = scope.macro(name)
        if found is None:
            known = list(self.defined)
            self.refuse(source, str(UnknownNameError("macro", name, "the file", known)))
        macro, over = found
        inner = XacroScope(self.value, over)
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
        macro: XacroMacro,
        parameter: MacroParameter,
        scope: XacroScope,
        inner: XacroScope,
    ) -> None:
        """Set a macro's parameter that the call does not give: to the caller's value of that name,
        or to its default."""
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
        self, source: XmlElement, key: str, scope: XacroScope, default: bool | None = None
    ) -> bool:
        """The truth of a condition in an attribute: true, false or a number."""
        if default is not None and key not in source.attributes:
            return default
        text = self.given_text(source, key)
        value = self.value(text, scope)
        if not isinstance(value, str):
            return bool(value)
        if value in (*TRUE, *FALSE):
            return value in TRUE
        try:
            return bool(int(value))
        except ValueError:
            self.refuse(
                source, f"{key} of <{source.tag}> is {shown(value)}, expected true or false."
            )


_TAGS: dict[str, Callable[[_XacroExpansion, XmlElement, XacroScope, XmlElement], None]] = {
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
