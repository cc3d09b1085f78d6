"""YAML files that xacro files take numbers from, read as plain data: no tag but units has an
effect."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

from freebody.errors import FileError, MissingPackageError
from freebody.formats import read_file

_LARGEST_FILE = 2**20
_MOST = 20_000  # entries of one mapping, those merged into it among them
_UNITS = {
    "!radians": 1.0,
    "!degrees": math.pi / 180.0,
    "!meters": 1.0,
    "!millimeters": 0.001,
    "!foot": 0.3048,
    "!inches": 0.0254,
}


def read_yaml(path: Path, evaluate: Callable[[str], Any]) -> Any:
    """Contents of a YAML file: dicts, lists, text and numbers. evaluate: the value of an expression
    behind a unit. Raises FileError for what cannot be read."""
    try:
        import yaml  # an extra
    except ImportError:
        raise MissingPackageError("load: YAML in a xacro file", "yaml", "xacro") from None

    class Loader(yaml.SafeLoader):
        """A safe YAML loader with units, and with a bound on merges by <<."""

        def flatten_mapping(self, node: Any) -> None:
            super().flatten_mapping(node)
            if len(node.value) > _MOST:
                raise yaml.YAMLError(f"a mapping has more than {_MOST} entries")

    for tag, factor in _UNITS.items():

        def quantity(loader: Any, node: Any, factor: float = factor) -> float:
            return float(evaluate(str(loader.construct_scalar(node)))) * factor

        Loader.add_constructor(tag, quantity)
    data = read_file.contents(path, _LARGEST_FILE, "numbers of a robot")
    try:
        return yaml.load(data, Loader)
    except RecursionError:
        raise FileError(path, None, "the YAML is nested too deeply.") from None
    except (yaml.YAMLError, ValueError, TypeError) as problem:
        mark = getattr(problem, "problem_mark", None)
        told = getattr(problem, "problem", None) or str(problem)
        line = mark.line + 1 if mark else None
        raise FileError(path, line, f"the YAML cannot be read: {told}.") from None
