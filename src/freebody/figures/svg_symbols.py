"""Symbols of textbooks as SVG text, made of lines, circles and words. Places on the page are
complex numbers x + iy, in pixels, y down; so are directions, of length 1."""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable, Sequence
from html import escape
from itertools import groupby

import numpy as np
from scipy.spatial import ConvexHull

from freebody.arrays import Array
from freebody.figures.drawing import Cells, ColourKey, Prism
from freebody.figures.view import View

Pixel = complex


def line(css: str, d: str, title: str = "") -> str:
    """A path from its data; title: what is told of it on the screen."""
    told = f"><title>{escape(title)}</title></path>" if title else "/>"
    return f'<path class="{css}" d="{d}"{told}'


def circle(css: str, at: Pixel, r: float, title: str = "") -> str:
    """SVG element of a circle."""
    told = f"><title>{escape(title)}</title></circle>" if title else "/>"
    return f'<circle class="{css}" cx="{at.real:.1f}" cy="{at.imag:.1f}" r="{r:g}"{told}'


def words(css: str, at: Pixel, marked: str, anchor: str = "") -> str:
    """An SVG text element of words that are already marked up; anchor: "middle" or "end", default
    the start."""
    how = f' text-anchor="{anchor}"' if anchor else ""
    return f'<text class="{css}" x="{at.real:.1f}" y="{at.imag:.1f}"{how}>{marked}</text>'


def group(title: str, *parts: str) -> str:
    """Several SVG parts under one title."""
    return f"<g><title>{escape(title)}</title>{''.join(parts)}</g>" if title else "".join(parts)


def path(points: Sequence[Pixel], closed: bool = False) -> str:
    """Path data of a polyline."""
    return "M" + "L".join(map(_xy, points)) + ("Z" if closed else "")


def _xy(at: Pixel) -> str:
    return f"{at.real:.1f} {at.imag:.1f}"


# ---------------------------------------------------------------- arrows
def head(tip: Pixel, way: Pixel, role: str, size: float = 9.0) -> str:
    """An arrow head as SVG, with its point at `tip`."""
    wings = [tip - size * way * (1 + k * 0.36j) for k in (-1, 1)]
    return line(f"{role}-head", path([tip, *wings], True))


def arrow(a: Pixel, b: Pixel, role: str, heads: int = 1, title: str = "") -> str:
    """An arrow from a to b as SVG; a ring with a dot where it points at the viewer."""
    length = abs(b - a)
    if length < 4.0:
        return group(title, circle(role, b, 5), circle(f"{role}-head", b, 2))
    way, size = (b - a) / length, min(10.0, max(5.0, 0.4 * length))
    tips = [head(b - k * 0.8 * size * way, way, role, size) for k in range(heads)]
    return group(title, line(role, path([a, b - 0.7 * size * way])), *tips)


def turn(
    at: Pixel, radius: float, value: float, role: str, title: str, facing: float, span: float
) -> str:
    """The symbol of a moment as SVG: an arc of `span` degrees around the direction `facing`,
    counter-clockwise where the value is positive."""
    sweep = math.copysign(math.radians(span), value)
    end = math.radians(facing) + sweep / 2
    way = _ahead(end + math.copysign(0.18, value), value)
    tip = at + radius * towards(end) + 5 * way
    return group(title, line(role, _bow(at, radius, end - sweep, sweep)), head(tip, way, role))


def arc(at: Pixel, radius: float, start: float, sweep: float) -> str:
    """The arc of an angle as SVG, with a small head at its end."""
    bend = start + sweep - math.copysign(min(3.0 / radius, abs(sweep) / 2), sweep)
    tip = at + radius * towards(start + sweep)
    bow = line("angle", _bow(at, radius, start, sweep))
    return bow + head(tip, _ahead(bend, sweep), "angle", 7)


def towards(angle: float) -> Pixel:
    """The direction at an angle counter-clockwise from the right (rad), as a complex number on the
    page."""
    return cmath.exp(-1j * angle)


def _bow(at: Pixel, radius: float, start: float, sweep: float) -> str:
    """Path data of an arc from the direction `start` over `sweep` (rad)."""
    a, b = (at + radius * towards(angle) for angle in (start, start + sweep))
    flags = f"{int(abs(sweep) > math.pi)} {int(sweep < 0)}"
    return f"M{_xy(a)}A{radius:.1f} {radius:.1f} 0 {flags} {_xy(b)}"


def _ahead(angle: float, way: float) -> Pixel:
    """The direction of motion along a circle at an angle; counter-clockwise where `way` is
    positive."""
    return -1j * towards(angle) * math.copysign(1.0, way)


def dimension(ends: tuple[Pixel, Pixel], a: Pixel, b: Pixel) -> str:
    """A dimension line from a to b as SVG, with heads at both ends, and thin lines to the ends of
    the measured length."""
    length = abs(b - a)
    thin = [path([p, q]) for p, q in zip(ends, (a, b), strict=True) if abs(q - p) > 1]
    out = line("dimension", "".join(thin) + path([a, b]))
    if length < 1:
        return out
    way, size = (b - a) / length, min(8.0, 0.45 * length)
    return out + head(b, way, "dimension", size) + head(a, -way, "dimension", size)


def ruler(at: Pixel, length: float, label: str, role: str) -> str:
    """A scale bar as SVG, with its text above."""
    text, end = words("tick", at - 6j, escape(label)), at + length
    if role != "length":
        return arrow(at, end, role) + text
    return line("axis", "".join(path(p) for p in ([at, end], *_ticks(at, end)))) + text


def _ticks(*places: Pixel) -> list[list[Pixel]]:
    return [[place - 3j, place + 3j] for place in places]


# ---------------------------------------------------------------- marks
def joint(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """The symbol of a pin joint seen along its axis, as SVG."""
    return circle("pin", at, size)


def sphere(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """Symbol of a ball joint."""
    return circle("side", at, size) + circle("spot", at - 0.3 * size * (1 + 1j), 0.3 * size)


def com(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """The symbol of a centre of mass, a quartered disc, as SVG."""
    sides = ((1, -1), (-1, 1))
    quarters = [
        f"M{_xy(at)}h{k * size:g}A{size:g} {size:g} 0 0 0 {_xy(at + j * size * 1j)}Z"
        for k, j in sides
    ]
    return circle("com", at, size) + line("comq", "".join(quarters))


def ground(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """The symbol of a support, a triangle on a hatched line, as SVG; `way` points up."""

    def local(right: float, up: float) -> Pixel:
        return at + size * way * (up + 1j * right)

    strokes = [path([local(k, -1.7), local(k - 0.6, -2.3)]) for k in np.linspace(-1.5, 2.1, 7)]
    floor = path([local(-2.1, -1.7), local(2.1, -1.7)])
    triangle = path([local(0, 0), local(-1.2, -1.7), local(1.2, -1.7)], True)
    return line("hatch", "".join(strokes)) + line("rail", floor) + line("pin", triangle)


def slider(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """The symbol of a block that slides along `way`, as SVG."""
    corners = [at + size * way * (1.5 * a + 1j * b) for a, b in _CORNERS]
    return line("pin", path(corners, True))


_CORNERS = ((-1, -1), (1, -1), (1, 1), (-1, 1))


def dot(at: Pixel, size: float, way: Pixel, role: str) -> str:
    """Symbol of a point."""
    return circle(role, at, size)


MARKS: dict[str, Callable[[Pixel, float, Pixel, str], str]] = {
    "joint": joint, "sphere": sphere, "com": com, "ground": ground, "slider": slider, "dot": dot,
}  # fmt: skip


# ---------------------------------------------------------------- solids
def prism_rings(prism: Prism, view: View) -> tuple[Array, Array]:
    """Corners (k, 3) of a prism's two ends, the end nearer to the viewer first."""
    axis = np.asarray(prism.axis) / np.linalg.norm(prism.axis)
    u = np.cross(axis, np.eye(3)[int(np.argmin(abs(axis)))])
    u /= np.linalg.norm(u)
    first = math.pi / 4 if prism.sides == 4 else 0.0
    angles = np.arange(prism.sides) * 2 * math.pi / prism.sides + first
    ring = np.outer(np.cos(angles), u) + np.outer(np.sin(angles), np.cross(axis, u))
    half = math.copysign(prism.half, axis @ np.asarray(view.towards)) * axis
    middle = np.asarray(prism.at) + prism.radius * ring
    return middle + half, middle - half


def prism(near: Sequence[Pixel], outline: Sequence[Pixel], distant: bool) -> str:
    """A prism as SVG: its outline, and the end that is seen."""
    parts = line("side", path(outline, True)) + line("cap", path(near, True))
    return f'<g class="far">{parts}</g>' if distant else parts


def hull(points: Sequence[Pixel]) -> list[Pixel]:
    """Corners of the convex hull; all of the points where they lie on one line."""
    flat = np.array([(p.real, p.imag) for p in points])
    if np.linalg.matrix_rank(flat - flat[0], tol=0.01) < 2:
        return list(points)
    return [points[k] for k in ConvexHull(flat).vertices]


_SWATCH = 14.0
KEY = 46.0
"""Height of a key in pixels."""


def cells(e: Cells, at: Callable[[Sequence[float]], complex]) -> list[str]:
    """SVG paths of a map's cells, one for each colour, in which neighbours in a row are joined; at:
    gives the pixels of a place."""
    corner, across, up = map(np.asarray, (e.corner, e.across, e.up))
    d: dict[int, list[str]] = {}
    for i, row in enumerate(e.colours):
        j = 0
        for colour, run in groupby(row):
            end = j + len(list(run))
            if colour >= 0:
                ends = ((i, j), (i, end), (i + 1, end), (i + 1, j))
                places = [at(tuple(corner + b * across + a * up)) for a, b in ends]
                d.setdefault(colour, []).append(path(places, closed=True))
            j = end
    return [f'<path class="m{colour}" d="{"".join(d[colour])}"/>' for colour in sorted(d)]


def key(shown: ColourKey, middle: complex, wide: float) -> list[str]:
    """The colour key of a map as SVG: the colours in a row, and their numbers below, at the edges
    between colours or under each."""
    count = len(shown.colours)
    step = min(wide / max(count, 1), 60.0)
    left = middle - count * step / 2
    out = [words("unit", middle - 4j, escape(shown.title), "middle")]
    for k, colour in enumerate(shown.colours):
        corner = left + k * step
        ends = [corner, corner + step, corner + step + _SWATCH * 1j, corner + _SWATCH * 1j]
        out.append(f'<path class="m{colour}" d="{path(ends, closed=True)}"/>')
    shift = 0.0 if shown.between else 0.5
    for k, text in enumerate(shown.texts):
        at = left + (k + shift) * step + (_SWATCH + 13.0) * 1j
        out.append(words("tick", at, escape(text), "middle"))
    return out
