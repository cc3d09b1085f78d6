"""Tests ask public functions: those that import internals become no more, what they take through
`tests/support` counted."""

from __future__ import annotations

import ast
from functools import cache
from pathlib import Path

import freebody as fb

TESTS = Path(__file__).parents[1]
MOST = 59
"""Files of tests with internals that there may be: lowered when one goes, never raised."""

PACKAGES = ("freebody", "freebody_textbook", "freebody_notes")
PUBLIC = {"freebody", "freebody.math", *(f"freebody.{name}" for name in (*fb.__all__, "math"))}


@cache
def imported(path: Path) -> frozenset[str]:
    """Every module that a file imports, and every name that it takes out of one."""
    names: set[str] = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names.update(a.name for a in node.names)
        elif isinstance(node, ast.ImportFrom) and node.module:
            public = node.module == "freebody.math"
            names.update(node.module if public else f"{node.module}.{a.name}" for a in node.names)
    return frozenset(names)


def beside(path: Path) -> set[Path]:
    """The files of `tests` that a file imports."""
    found = set()
    for name in imported(path):
        place = TESTS.joinpath(*name.split("."))
        found |= {place.with_suffix(".py"), place.parent.with_suffix(".py"), place / "__init__.py"}
    return {file for file in found if file.is_file()}


def reached(path: Path) -> set[Path]:
    """A file of tests and all files of `tests` that it comes to."""
    seen, ahead = {path}, [path]
    while ahead:
        new = beside(ahead.pop()) - seen
        seen |= new
        ahead += new
    return seen


def internals(path: Path) -> set[str]:
    """What a file imports of the packages that is not public."""
    return {x for x in imported(path) if x.split(".")[0] in PACKAGES} - PUBLIC


def test_fewer_and_fewer_tests_import_internals():
    files = sorted(TESTS.rglob("test_*.py"))
    inside = [str(f.relative_to(TESTS)) for f in files if any(map(internals, reached(f)))]
    assert len(inside) == MOST, (
        f"{len(inside)} of {len(files)} files: lower MOST, or ask a public function in the new one"
    )
