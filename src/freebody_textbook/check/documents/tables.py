"""Markdown's tables of numbers as equations, a row a line: below θ1 [°] | G2 [N m] the row
30 | 3.05 is θ1 = 30 °, G2 = 3.05 N m; G2 | 3.05 N m is G2 = 3.05 N m."""

from __future__ import annotations

import re

_ROW = re.compile(r"[ \t]{0,3}\|(?P<cells>[^\n]{1,400})\|[ \t]*$")
_RULE = re.compile(r"[ \t]{0,3}\|?(?:[ \t]*:?-+:?[ \t]*\|)+(?:[ \t]*:?-+:?)?[ \t]*")
_NAME = re.compile(
    r"\s*\$?\s?(?P<name>(?=[^\s=]*[\d₀-₉\\Α-ω])(?:\\[A-Za-z]+|[A-Za-zΑ-ω])[^\s=\[\]()|$,]{0,24})"
    r"\s?\$?\s*(?:[\[(/]\s?\$?(?P<unit>[^\[\]()|=$]{1,20})\$?\s?[\])]?)?\s*$"
)
"""A symbol, perhaps with a unit."""
_NUMBER = re.compile(
    r"\s*\$?(?P<number>[-+−]?(?:\d{1,20}(?:\.\d{0,20})?|\.\d{1,20}))\s?(?P<unit>[^|=]{0,20}?)\$?\s*$"
)


def in_lines(text: str) -> str:
    """The text with such tables as equations, line by line."""
    lines = text.split("\n")
    for k in range(1, len(lines)):
        if _RULE.fullmatch(lines[k]) and (head := _cells(lines[k - 1])):
            _read(lines, k, head)
    return "\n".join(lines)


def _read(lines: list[str], rule: int, head: list[str]) -> None:
    """Put equations in place of the rows below a rule."""
    names = [_NAME.match(cell) for cell in head]
    found: dict[int, str] = {}
    for k in range(rule + 1, len(lines)):
        cells = _cells(lines[k])
        if not cells or _RULE.fullmatch(lines[k]):
            break
        pairs = list(zip(names, cells, strict=False))
        own = _NAME.match(cells[0])
        if not any(names) and own and len(cells) == 2:
            pairs = [(own, cells[1])]
        told = [(name, _NUMBER.match(cell)) for name, cell in pairs if name]
        if told and all(number for _, number in told):
            found[k] = ", ".join(_equation(*pair) for pair in told)
    for k, line in found.items():
        lines[k] = line
    if found:
        lines[rule - 1] = lines[rule] = ""


def _cells(line: str) -> list[str]:
    row = _ROW.fullmatch(line)
    return row["cells"].split("|") if row else []


def _equation(name: re.Match[str], number: re.Match[str] | None) -> str:
    assert number is not None
    unit = number["unit"] or name["unit"] or ""
    return f"{name['name']} = {number['number']} {unit}".rstrip()
