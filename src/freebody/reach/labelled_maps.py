"""Labelled datasets of one form for the maps of this folder, which do not import each other."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import xarray as xr

MapEntry = tuple[tuple[str, ...], Any, str, str]
"""An array of a map: its dimensions, values, unit, and meaning in words."""


def axes_of(name: str, count: int) -> tuple[str, ...]:
    """Names of `count` axes: `name`, or `name0`, `name1`, … where there are several."""
    return (name,) if count == 1 else tuple(f"{name}{k}" for k in range(count))


def labelled(
    entries: Mapping[str, MapEntry],
    coordinates: Mapping[str, MapEntry],
    about: Mapping[str, Any],
) -> xr.Dataset:
    """A dataset of arrays with dimensions and units; about: its attributes."""
    import xarray as xr

    def variables(given: Mapping[str, MapEntry]) -> dict[str, Any]:
        return {
            name: (dims, np.array(values), {"units": unit, "long_name": meaning})
            for name, (dims, values, unit, meaning) in given.items()
        }

    return xr.Dataset(variables(entries), variables(coordinates), dict(about))
