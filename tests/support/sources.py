"""Every source file of what is installed, for rules that hold everywhere."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import freebody

SRC = Path(freebody.__file__).parents[1]
PACKAGES = ("freebody", "freebody_textbook", "freebody_notes")
SOURCES = sorted(path for package in PACKAGES for path in (SRC / package).rglob("*.py"))


@cache
def parsed(path: Path) -> ast.Module:
    """The syntax tree of a file, which several tests walk and none changes: parsing all files takes
    seconds."""
    return ast.parse(path.read_text(encoding="utf-8"))


def place(path: Path) -> str:
    """program/program.py in freebody, freebody_notes/page.py beside it."""
    return path.relative_to(SRC).as_posix().removeprefix("freebody/")
