"""Expanding a document's own LaTeX commands, \\newcommand and \\def: text is substituted, nothing
is executed, and unlimited growth is refused."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import dataclass, field

from freebody_textbook.check.spelling.answer_text import AnswerError

MOST_USES = 20_000
LARGEST = 400_000
"""The most characters of a text with its commands put in."""
_DEEPEST = 30
"""The most commands inside one another."""
_LONGEST_LINE = 2000

_DEFINITION = re.compile(
    r"\\(?:(?:re)?newcommand|providecommand|DeclareRobustCommand)\*?\s*(?:\{\s*)?\\([A-Za-z]+)(?:\s*\})?"
    r"\s*(?:\[\s*([0-9])\s*\]\s*(?:\[([^\]\[{}]{0,80})\]\s*)?)?(?=\{)"
    r"|\\def\s*\\([A-Za-z]+)\s*((?:#[1-9])*)\s*(?=\{)"
    r"|\\DeclareMathOperator\*?\s*\{\s*\\([A-Za-z]+)\s*\}\s*(?=\{)"
)
_COMMENT = re.compile(r"(?<!\\)%")
_OPTION = re.compile(r"\s*\[([^\]\[]{0,200})\]")
_COMMAND = re.compile(r"\\([A-Za-z]+|.)", re.DOTALL)
_BRACE = re.compile(r"\\.|[{}]", re.DOTALL)
_PLACE = re.compile(r"#([1-9])")


@dataclass(frozen=True)
class _Macro:
    """A LaTeX command's replacement text; #1 is its first argument, which may have a default."""

    body: str
    arguments: int = 0
    default: str | None = None


def expanded(text: str) -> str:
    """A text with its command definitions removed and its own commands expanded.

    A command is known behind its definition. Raises AnswerError for commands that stand for
    themselves, or that make the text too long.
    """
    return _Expansion().of(text, 0) if _DEFINITION.search(text) else text


@dataclass
class _Expansion:
    macros: dict[str, _Macro] = field(default_factory=dict[str, _Macro])
    uses: int = 0
    size: int = 0

    def of(self, text: str, depth: int) -> str:
        """A text with the commands expanded that are defined so far."""
        parts, braces = list[str](), closing_braces(text)
        at = kept = 0
        while (match := _COMMAND.search(text, at)) is not None:
            at = match.end()
            definition = _DEFINITION.match(text, match.start())
            end = definition and self._define(text, definition, braces)
            if end:
                blank = "".join("\n" if c == "\n" else " " for c in text[match.start() : end])
                new, at = blank, end
            elif match[1] in self.macros:
                new, at = self._used(text, match, braces, depth)
            else:
                continue
            parts += [text[kept : match.start()], new]
            kept = at
        return "".join([*parts, text[kept:]])

    def _define(self, text: str, found: re.Match[str], braces: Mapping[int, int]) -> int:
        """Store a command definition; returns the place where the definition ends, 0 if there is
        none."""
        end = braces.get(found.end(), 0)
        line = text[max(0, found.start() - _LONGEST_LINE) : found.start()].rpartition("\n")[2]
        if not end or _COMMENT.search(line):
            return 0
        body = text[found.end() + 1 : end].replace("\n", " ").replace("\\xspace", "")
        new, count, default, short, places, operator = found.groups()
        if operator:
            self.macros[operator] = _Macro(f"\\operatorname{{{body}}}")
        else:
            arguments = int(count or 0) if new else len(places) // 2
            self.macros[new or short] = _Macro(body, arguments, default)
        return end + 1

    def _used(
        self, text: str, command: re.Match[str], braces: Mapping[int, int], depth: int
    ) -> tuple[str, int]:
        """The expansion of a command at a place, and where its arguments end."""
        macro, at = self.macros[command[1]], command.end()
        given: list[str] = []
        if macro.default is not None:
            option = _OPTION.match(text, at)
            given.append(option[1] if option else macro.default)
            at = option.end() if option else at
        while len(given) < macro.arguments:
            argument, at = _argument(text, at, braces)
            given.append(argument)
        made = _PLACE.sub(
            lambda x: given[int(x[1]) - 1] if int(x[1]) <= len(given) else "", macro.body
        )
        self.uses += 1
        self.size += len(made)
        if depth == _DEEPEST or self.uses > MOST_USES or self.size > LARGEST:
            raise AnswerError(
                f"\\{command[1]} stands for itself, or for a text that is too long",
                "Define it by what it stands for.",
            )
        return self.of(made, depth + 1), at


def _argument(text: str, at: int, braces: Mapping[int, int]) -> tuple[str, int]:
    """A command's argument, a group in braces or the next command or character, and where it
    ends."""
    while text[at : at + 1].isspace():
        at += 1
    if at in braces:
        return text[at + 1 : braces[at]], braces[at] + 1
    command = _COMMAND.match(text, at)
    end = command.end() if command else at + 1
    return text[at:end], end


def closing_braces(text: str) -> dict[int, int]:
    """The position of the matching closing brace, by that of the opening one."""
    found, opened = dict[int, int](), list[int]()
    for match in _BRACE.finditer(text):
        if match[0] == "{":
            opened.append(match.start())
        elif match[0] == "}" and opened:
            found[opened.pop()] = match.start()
    return found
