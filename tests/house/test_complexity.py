"""No function has more ways through it than a reader can follow."""

from __future__ import annotations

import ast

import pytest

from support.sources import SOURCES, parsed, place

MOST = 20


def ways(function: ast.AST) -> int:
    """One, and one more for each branch, each further part of an `and` or `or`, and each loop and
    condition of a comprehension."""
    found = 1
    for node in ast.walk(function):
        if isinstance(node, ast.BoolOp):
            found += len(node.values) - 1
        elif isinstance(node, ast.comprehension):
            found += 1 + len(node.ifs)
        else:
            branches = (ast.If, ast.IfExp, ast.For, ast.While, ast.ExceptHandler, ast.Assert)
            found += isinstance(node, (*branches, ast.match_case))
    return found


@pytest.mark.parametrize(
    ("text", "count"),
    [
        ("def f(): pass", 1),
        ("def f(x): return 1 if x else 2", 2),
        ("def f(x, y, z): return x and y and z", 3),
        ("def f(x): return [y for y in x if y]", 3),
    ],
)
def test_what_is_counted(text: str, count: int):
    assert ways(ast.parse(text).body[0]) == count


def test_no_function_has_more_ways_than_can_be_followed():
    found = {
        f"{place(path)}:{node.lineno} {node.name}": count
        for path in SOURCES
        for node in ast.walk(parsed(path))
        if isinstance(node, ast.FunctionDef) and (count := ways(node)) > MOST
    }
    assert found == {}
