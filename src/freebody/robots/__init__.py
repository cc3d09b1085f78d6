"""Bundled models: TOML files beside this one, each with its source cited."""

from __future__ import annotations

import tomllib

from freebody.formats.read_file import bundled_names, bundled_text


class Models(dict[str, str]):
    """Names and sources of models, printed as a table."""

    def __str__(self) -> str:
        width = max(map(len, self), default=0)
        return "\n".join(f"{name:<{width}}  {source}" for name, source in self.items())

    __repr__ = __str__


def models() -> Models:
    """The bundled models: name -> where its numbers come from. `load` takes the names."""
    return Models({name: tomllib.loads(bundled_text(name))["source"] for name in bundled_names()})
