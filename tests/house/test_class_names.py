"""No name of a type means two things: whoever searches for one finds one definition."""

from __future__ import annotations

import ast
import re
from collections import defaultdict
from collections.abc import Iterator
from pathlib import Path

from support.sources import parsed

SOURCE = Path(__file__).resolve().parents[2] / "src"
ALIAS = re.compile(r"_?[A-Z][a-z]\w*")
"""An alias of a type, such as Wrenches; constants are all capitals."""
BOTH = {"Matrix", "Vector"}
"""Tuples of scalars in `spatial`, and what stands for one in a formula."""


def types(tree: ast.Module) -> Iterator[tuple[str, int]]:
    """Names and lines of classes, and of aliases at the top of a module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ClassDef):
            yield node.name, node.lineno
    for node in tree.body:
        targets = node.targets if isinstance(node, ast.Assign) else [getattr(node, "target", None)]
        for target in targets:
            if isinstance(target, ast.Name) and ALIAS.fullmatch(target.id):
                yield target.id, node.lineno


def test_no_name_of_a_type_is_defined_twice():
    """A leading underscore makes no other name of it."""
    places = defaultdict(list)
    for path in sorted(SOURCE.rglob("*.py")):
        for name, line in types(parsed(path)):
            places[name.lstrip("_")].append(f"{path.relative_to(SOURCE)}:{line}")
    assert len(places) > 200
    assert {name for name, found in places.items() if len(found) > 1} == BOTH, places
