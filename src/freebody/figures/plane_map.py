"""Values over a plane as a chart: axes in metres, contours with their values, colours for the range
in which most values lie, and the robot as a line drawing."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

from freebody.arrays import Array
from freebody.figures.colours import MAP
from freebody.figures.drawing import Cells
from freebody.figures.marked_text import width
from freebody.figures.plots import tick, ticks
from freebody.figures.svg import Picture
from freebody.figures.svg_symbols import cells, circle, line, path, words
from freebody.outputs.number_text import shortest

_LEFT, _RIGHT, _TOP, _BOTTOM = 46.0, 12.0, 40.0, 44.0
_WIDE, _TALLEST = 340.0, 380.0
_USEFUL = (1.0, 65.0)  # percent of the values between which the contours lie
_LEVELS = 8
_APART = 20.0  # pixels: so far numbers on contours keep from each other, upwards
_FLAT = 0.4  # of a distance sideways counts: numbers are wider than tall
_EDGE = 16.0

EndsOnPage = tuple[complex, complex]
InPlane = Sequence[float] | Array
OnPage = Callable[[InPlane], complex]
"""The pixels of a place (2,) in the plane, m."""


@dataclass(frozen=True)
class PlaneMap:
    """Values (m, n) over an even grid in a plane, NaN where there are none."""

    title: str
    unit: str
    across: Array
    """(n,), m, increasing, of the grid's columns."""
    up: Array
    """(m,), m, increasing, of its rows."""
    values: Array
    across_title: str
    up_title: str
    links: Sequence[tuple[Array, Array]] = ()
    """Ends (2,) of the robot's links in the plane, m."""
    tip: tuple[float, float] | None = None

    @property
    def levels(self) -> list[float]:
        """Round values between which the colours change: even steps over the range in which most
        values lie, so that a few large ones near a singular pose do not hide it."""
        there = self.values[np.isfinite(self.values)]
        low, high = np.percentile(there, _USEFUL)
        if high - low <= 1e-9 * max(abs(high), 1e-12):
            return []
        return ticks(float(low), float(high), _LEVELS)


def plane_map(what: PlaneMap) -> Picture:
    """Picture of a map with its axes, contours and the robot."""
    steps = what.across[1] - what.across[0], what.up[1] - what.up[0]
    there = np.isfinite(what.values)
    rows, columns = np.flatnonzero(there.any(axis=1)), np.flatnonzero(there.any(axis=0))
    ends = [what.across[columns[[0, -1]]], what.up[rows[[0, -1]]]]
    low = np.array([end[0] - step for end, step in zip(ends, steps, strict=True)])
    high = np.array([end[-1] + step for end, step in zip(ends, steps, strict=True)])
    room = _WIDE - _LEFT - _RIGHT, _TALLEST - _TOP - _BOTTOM
    scale = float(min(room[0] / (high[0] - low[0]), room[1] / (high[1] - low[1])))
    size = scale * (high - low)
    box = (_LEFT, _TOP, _LEFT + size[0], _TOP + size[1])

    def at(place: InPlane) -> complex:
        x, y = float(place[0]), float(place[1])
        return complex(_LEFT + scale * (x - low[0]), _TOP + scale * (high[1] - y))

    levels = what.levels
    body = [words("name", 6 + 16j, escape(what.title))]
    body += _coloured(what, levels, steps, at)
    texts: list[str] = []
    placed = [at(a) + share * (at(b) - at(a)) for a, b in what.links for share in (0.0, 0.5, 1.0)]
    for level in levels:
        segments = [(at(a), at(b)) for a, b in contour(what.across, what.up, what.values, level)]
        if segments:
            d = "".join(path(segment) for segment in segments)
            body.append(line("contour", d, f"{shortest(level)} {what.unit}"))
            texts += _number(segments, f"{shortest(level)} {what.unit}", box, placed)
    body += [line("stick", path([at(a), at(b)])) for a, b in what.links]
    body += [circle("joint", at(a), 3.0) for a, _ in what.links]
    if what.tip is not None:
        body.append(circle("tipdot", at(what.tip), 4.0, "the tip"))
    body += [*texts, *_axes(what, (low, high), box, at)]
    return Picture("".join(body), _WIDE, box[3] + _BOTTOM, f"{what.title}, {what.unit}")


def contour(x: Array, y: Array, values: Array, level: float) -> Iterator[tuple[Array, Array]]:
    """Segments (ends (2,)) of the line on which values (m, n) over y (m,) and x (n,), straight
    between neighbours, are a level (marching squares); none where a neighbour has no value."""
    ring = ((0, 0), (0, 1), (1, 1), (1, 0))
    m, n = values.shape
    corners = np.stack([values[i : m - 1 + i, j : n - 1 + j] for i, j in ring]) - level
    crossed = np.isfinite(corners).all(axis=0)
    crossed &= (corners > 0).any(axis=0) & (corners <= 0).any(axis=0)
    for i, j in np.argwhere(crossed):
        own = corners[:, i, j]
        ends = []
        for a, b in ((0, 1), (1, 2), (2, 3), (3, 0)):
            if (own[a] > 0) != (own[b] > 0):
                share = own[a] / (own[a] - own[b])
                p, q = (np.array([x[j + ring[k][1]], y[i + ring[k][0]]]) for k in (a, b))
                ends.append(p + share * (q - p))
        # of a saddle the middle tells which corners belong together
        if len(ends) == 4 and (own.mean() > 0) != (own[0] > 0):
            ends = [*ends[1:], ends[0]]
        yield from zip(ends[::2], ends[1::2], strict=True)


def _coloured(
    what: PlaneMap, levels: Sequence[float], steps: Sequence[float], at: OnPage
) -> list[str]:
    colours = np.full(what.values.shape, -1)
    there = np.isfinite(what.values)
    colours[there] = np.searchsorted(levels, what.values[there], side="right")
    count = max(len(levels), 1)
    shown = np.where(there, np.round(colours * (MAP - 1) / count).astype(int), -1)
    corner = (what.across[0] - steps[0] / 2, what.up[0] - steps[1] / 2)
    part = tuple(map(tuple, shown.tolist()))
    return cells(Cells(corner, (steps[0], 0.0), (0.0, steps[1]), part, "map"), at)


def _number(
    segments: Sequence[EndsOnPage], text: str, box: tuple[float, ...], placed: list[complex]
) -> list[str]:
    """The number of a contour at the roomiest place on it, as SVG; none where there is no room."""
    half = width(text, 11) / 2 + 2
    best, most = None, _APART
    for a, b in segments:
        middle = (a + b) / 2
        beside = min(middle.real - box[0], box[2] - middle.real) - half
        inside = min(middle.imag - box[1], box[3] - middle.imag, beside + _EDGE) - _EDGE
        away = (middle - other for other in placed)
        room = min((abs(complex(_FLAT * x.real, x.imag)) for x in away), default=1e3)
        if inside > 0 and room > most:
            best, most = middle, room
    if best is None:
        return []
    placed.append(best)
    return [words("contour-text", best + 4j, escape(text), "middle")]


def _axes(
    what: PlaneMap, ends: tuple[Array, Array], box: tuple[float, ...], at: OnPage
) -> list[str]:
    (left, top, right, bottom), (low, high) = box, ends
    out = [line("frame", f"M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}")]
    across, up = (ticks(float(low[k]), float(high[k]), 5) for k in (0, 1))
    for x in across:
        p = at((x, low[1]))
        out.append(line("axis", f"M{p.real:.1f} {bottom:.1f}v4"))
        out.append(words("tick", complex(p.real, bottom + 16), tick(x, across), "middle"))
    for y in up:
        p = at((low[0], y))
        out.append(line("axis", f"M{left:.1f} {p.imag:.1f}h-4"))
        out.append(words("tick", complex(left - 7, p.imag + 4), tick(y, up), "end"))
    out.append(words("unit", complex(left - 38, top - 8), escape(what.up_title)))
    out.append(words("unit", complex(right, bottom + 32), escape(what.across_title), "end"))
    return out
