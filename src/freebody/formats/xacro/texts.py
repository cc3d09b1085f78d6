"""Values of texts in a xacro file: `${…}` evaluated over the names of a scope, `$(…)` replaced, and
the files and environment variables that these may use."""

from __future__ import annotations

import os
import re
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, NoReturn

from freebody.errors import FileError, UnknownNameError, shown
from freebody.formats.packages import Packages
from freebody.formats.urdf_elements import XmlElement
from freebody.formats.xacro.scopes import literal
from freebody.formats.xacro.values import (
    GLOBALS,
    TOKENIZE,
    Budget,
    ExpressionError,
    XacroFunction,
    evaluated,
    size,
)
from freebody.formats.xacro.yaml_files import read_yaml
from freebody.model.description import Notice

_PARTS = re.compile(
    r"(?P<escaped>\$\$+[{(])"
    r"|\$\{(?P<expression>[^}]*)\}"
    r"|\$\((?P<command>(?:[^()]|\((?:[^()]|\([^()]*\))*\))*)\)"
    r"|(?P<text>[^$]+|\$(?![{($])[^$]*|\$$)"
)


class XacroTexts:
    """The texts of a xacro file and its includes: their values, the files they may read, and errors
    with the place that is being expanded."""

    def __init__(
        self,
        file: str,
        packages: Packages,
        arguments: Mapping[str, object],
        environment: Sequence[str],
    ):
        self.files, self.packages, self.environment = [file], packages, environment
        self.arguments: dict[str, Any] = dict(arguments)
        self.budget = Budget()
        self.notices: list[Notice] = []
        self.place: XmlElement | None = None
        self.roots = [*packages.readable]

    def value(self, text: str, scope: Mapping[str, Any]) -> Any:
        """The value of a text with ${…} and $(…) in it: the value itself where the text is a single
        one, else text."""
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
        """The value of a substitution $(…) whose inner text is given."""
        name, _, rest = text.strip().partition(" ")
        if name == "eval":
            read = {"arg": XacroFunction(lambda of: literal(self.arg(of)))}
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
        return {name: literal(value) for name, value in self.arguments.items()}

    def find(self, name: str) -> str:
        """The folder of a package; the name itself where none is found, so that a mesh in it is
        ignored and an include of it is refused by that name."""
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

    def readable(self, source: XmlElement, path: Path) -> None:
        """Refuse a path outside the packages."""
        real = Path(os.path.realpath(path))
        if not any(real.is_relative_to(os.path.realpath(root)) for root in self.roots):
            self.refuse(
                source,
                f"{shown(os.fspath(path))} lies outside the file's package and is not read; name "
                f"its folder with package_path= (--package-path, or FREEBODY_PACKAGE_PATH).",
            )

    def refuse(self, source: XmlElement, problem: str) -> NoReturn:
        raise FileError(source.file or self.files[-1], source.line or None, problem)
