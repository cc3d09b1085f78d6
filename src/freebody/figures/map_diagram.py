"""`map_diagram`: values over a slice of the workspace in colour, with the robot in it."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError
from freebody.figures.colours import MAP
from freebody.figures.drawing import Cells, ColourKey, Drawing, point
from freebody.figures.figure import Figure, of_one
from freebody.figures.layers.structure import sticks, structure
from freebody.figures.plots import tick, ticks
from freebody.figures.snapshot import snapshot
from freebody.figures.view import FLAT, View, best_view
from freebody.model.model import Model
from freebody.outputs.number_text import shortest
from freebody.trees.public_calls import JointVector

_EVEN = 1e-6  # of a cell: so even are the steps of a grid
_FROM_ABOVE = 45.0


def map_diagram(
    model: Model,
    points: ArrayLike,
    values: ArrayLike,
    q: JointVector | None = None,
    *,
    title: str = "",
) -> Figure:
    """A slice of the workspace coloured by a map's values, and the robot in it.

    Parameters
    ----------
    points
        (m, n, dim), m, world axes: an even grid in a plane, the middles of the cells.
    values
        (m, n), such as `fb.workspace(...).ways` or the mass of `fb.payload_map`; NaN is left blank.
        Up to eight different whole numbers have a colour each, others one for each round interval.
    q
        (nq,), where the robot stands; default: so that it is clearly visible.
    title
        Above the key, with the unit.

    Returns
    -------
    Figure
        With `.svg` and `.save("map.svg")`.

    Raises
    ------
    FreebodyError, ShapeError, NotFiniteError
    """
    caller, d = "map_diagram", model.dim
    grid, shown = as_floats(caller, "points", points), as_floats(caller, "values", values)
    if grid.ndim != 3 or grid.shape[-1] != d or min(grid.shape[:2]) < 2:
        least = "at least two rows and columns"
        raise ShapeError(caller, "points", grid.shape, f"(m, n, {d})", least)
    refuse_not_finite(caller, "points", grid, 1)
    if shown.shape != grid.shape[:2]:
        raise ShapeError(caller, "values", shown.shape, str(grid.shape[:2]), "one for each point")
    if np.isinf(shown).any():
        raise FreebodyError(
            f"{caller}: values holds infinity, for which there is no colour; put NaN where nothing "
            f"is to be drawn."
        )
    across, up = _steps(caller, grid)
    seen = snapshot(model, q, caller=caller)
    colours, key = coloured(shown, title)
    drawing = Drawing(_view(sticks(seen.pose), across, up), title or f"A map of {model.name}")
    drawing.add(_cells(grid[0, 0] - (across + up) / 2, across, up, colours))
    drawing.key = key
    structure(drawing, seen)
    return of_one(f"{model.name}: {drawing.title}", drawing, caller)


def _steps(caller: str, grid: Array) -> tuple[Array, Array]:
    """The vectors between neighbouring columns and between neighbouring rows of a grid; raises an
    error where the grid is not even and flat."""
    m, n = grid.shape[:2]
    across, up = (grid[0, -1] - grid[0, 0]) / (n - 1), (grid[-1, 0] - grid[0, 0]) / (m - 1)
    j, i = np.arange(n)[None, :, None], np.arange(m)[:, None, None]
    off = np.abs(grid[0, 0] + j * across + i * up - grid).max()
    sizes = np.linalg.norm(across), np.linalg.norm(up)
    flat = sizes[0] ** 2 * sizes[1] ** 2 - (across @ up) ** 2
    if off > _EVEN * max(sizes) or flat <= (_EVEN * max(sizes)) ** 4:
        raise FreebodyError(
            f"{caller}: points is no even grid in a plane; take one such as "
            f"np.stack(np.meshgrid(x, y), axis=-1) with x and y of np.linspace."
        )
    return across, up


def _cells(corner: Array, across: Array, up: Array, numbers: np.ndarray) -> Cells:
    """The cells of a grid, reduced to the part around those that have a colour."""
    rows, columns = (np.flatnonzero((numbers >= 0).any(axis=k)) for k in (1, 0))
    if len(rows):
        corner = corner + rows[0] * up + columns[0] * across
        numbers = numbers[rows[0] : rows[-1] + 1, columns[0] : columns[-1] + 1]
    part = tuple(map(tuple, numbers.tolist()))
    return Cells(point(corner), point(across), point(up), part, "map")


def _view(links: list[tuple[Array, Array]], across: Array, up: Array) -> View:
    """The view in which a slice is seen well, and of several such the one in which the robot is,
    too."""
    if len(across) == 2:
        return FLAT
    normal = np.cross(across, up)
    normal /= np.linalg.norm(normal)
    if abs(normal[2]) > 0.7:
        return best_view(links, elevation=_FROM_ABOVE)
    azimuth = np.degrees(np.arctan2(normal[1], normal[0]))
    return best_view(links, [azimuth + turn for turn in (-30, 30, 150, 210)])


def coloured(values: Array, title: str) -> tuple[np.ndarray, ColourKey]:
    """The index of each value's colour (-1 for NaN), and the colour key."""
    there = np.isfinite(values)
    known = np.unique(values[there])
    if not len(known):
        return np.full(values.shape, -1), ColourKey(title, (), ())
    whole = len(known) <= MAP and bool((known == np.round(known)).all())
    if whole or len(known) == 1:
        texts, edges = tuple(shortest(float(x)) for x in known), known
    else:
        edges = _edges(float(known[0]), float(known[-1]))
        texts = tuple(tick(float(x), edges.tolist()) for x in edges)
        edges = edges[:-1]
    count = len(edges)
    used = tuple(round(k * (MAP - 1) / max(count - 1, 1)) for k in range(count))
    place = np.clip(np.searchsorted(edges, values, side="right") - 1, 0, count - 1)
    key = ColourKey(title, used, texts, between=not (whole or len(known) == 1))
    return np.where(there, np.asarray(used)[place], -1), key


def _edges(low: float, high: float) -> Array:
    """Round values that divide a range into colour steps, the first not above low, the last not
    below high, in as many steps as the colours allow."""
    for most in range(2 * MAP, 1, -1):
        inner = ticks(low, high, most)
        if len(inner) > 1:
            step = inner[1] - inner[0]
            first = [inner[0] - step] if inner[0] > low else []
            last = [inner[-1] + step] if inner[-1] < high else []
            if len(first) + len(inner) + len(last) <= MAP + 1:
                return np.array([*first, *inner, *last])
    return np.array([low, high])
