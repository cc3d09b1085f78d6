"""The text of the one renderer, for the scripts of pages."""

from __future__ import annotations

from freebody.outputs.page_script import joined

_FILES = (
    "numbers.js", "inflated.js", "solids.js", "raster.js", "camera.js", "floor.js", "labels.js",
    "stage.js",
)  # fmt: skip


def renderer() -> str:
    """JavaScript text of the renderer: `Stage`, which draws a scene on a canvas, and what it is
    made of."""
    return joined("freebody.moving", _FILES)
