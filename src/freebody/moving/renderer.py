"""The script that draws what moves, the one of all pages."""

from __future__ import annotations

from functools import cache

from freebody.outputs.pages import joined

_FILES = (
    "numbers.js", "vectors.js", "solids.js", "hulls.js", "raster.js", "camera.js", "floor.js",
    "symbols.js", "labels.js", "surface.js", "stage.js",
)  # fmt: skip
_UNPACKING = "inflated.js"
_NOTES = "notes.js"


@cache
def renderer(*, notes: bool = False) -> str:
    """The script's text, with what unpacks arrays of numbers; notes: instead of it with what names
    a robot's geometry."""
    return joined("freebody.moving", [*_FILES, _NOTES if notes else _UNPACKING])
