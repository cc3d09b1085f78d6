"""What test files share is in tests/support: none is imported by another, so that each can be read
and run alone."""

from __future__ import annotations

import ast
from pathlib import Path


def test_no_test_file_is_imported():
    taken = []
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = [a.name for a in node.names] if isinstance(node, ast.Import) else []
            names += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            taken += [f"{path.name}: {name}" for name in names if name.startswith("test_")]
    assert taken == []
