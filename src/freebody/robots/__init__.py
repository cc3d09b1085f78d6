"""Bundled models: TOML files in this folder, each with its source cited."""

from __future__ import annotations

import tomllib

from freebody.formats.read_file import bundled_names, bundled_text
from freebody.outputs.display import TextTable


class Models(dict[str, str]):
    """Names of models with the sources of their numbers, printed as a table."""

    def __str__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {source}" for name, source in self.items())

    __repr__ = __str__

    def _repr_html_(self) -> str:
        return TextTable(("name", "source"), list(self.items())).html(most=len(self))


def models() -> Models:
    """The bundled models: name -> the source of its numbers. `load` takes the names."""
    return Models(_entries("source"))


def abouts() -> dict[str, str]:
    """For each bundled model by name what is worth seeing in it."""
    return _entries("about")


def _entries(key: str) -> dict[str, str]:
    return {name: tomllib.loads(bundled_text(name))[key] for name in bundled_names()}
