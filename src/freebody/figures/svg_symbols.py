"""SVG text: lines, circles, words, and of them the symbols of textbooks; in pixels, y down."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from html import escape

import numpy as np

from freebody.figures.drawing import Point, Prism, View, point

Pixel = tuple[float, float]


def line(css: str, d: str, title: str = "") -> str:
    """A path from its data; title: what is told of it on the screen."""
    told = f"><title>{escape(title)}</title></path>" if title else "/>"
    return f'<path class="{css}" d="{d}"{told}'


def circle(css: str, at: Pixel, r: float, title: str = "") -> str:
    """A circle."""
    told = f"><title>{escape(title)}</title></circle>" if title else "/>"
    return f'<circle class="{css}" cx="{at[0]:.1f}" cy="{at[1]:.1f}" r="{r:g}"{told}'


def words(css: str, x: float, y: float, marked: str, anchor: str = "") -> str:
    """Text that is set already; anchor: "middle" or "end", default its start."""
    at = f' text-anchor="{anchor}"' if anchor else ""
    return f'<text class="{css}" x="{x:.1f}" y="{y:.1f}"{at}>{marked}</text>'


def group(title: str, *parts: str) -> str:
    """Parts that are told of together."""
    return f"<g><title>{escape(title)}</title>{''.join(parts)}</g>" if title else "".join(parts)


def path(points: Sequence[Pixel], closed: bool = False) -> str:
    """Path data of a polyline."""
    return "M" + "L".join(f"{x:.1f} {y:.1f}" for x, y in points) + ("Z" if closed else "")


def head(tip: Pixel, heading: Pixel, role: str, size: float = 9.0) -> str:
    """An arrow head whose point is at `tip`."""
    (x, y), (u, v) = tip, heading
    back, side = (x - size * u, y - size * v), 0.36 * size
    wings = [(back[0] - k * side * v, back[1] + k * side * u) for k in (1, -1)]
    return line(f"{role}-head", path([tip, *wings], True))


def arrow(a: Pixel, b: Pixel, role: str, heads: int = 1, title: str = "") -> str:
    """An arrow from a to b; a ring with a dot where it points at the viewer."""
    length = math.dist(a, b)
    if length < 4.0:
        return group(title, circle(role, b, 5), circle(f"{role}-head", b, 2))
    u, v = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    size = min(10.0, max(5.0, 0.4 * length))
    shaft = (b[0] - 0.7 * size * u, b[1] - 0.7 * size * v)
    tips = [
        head((b[0] - k * 0.8 * size * u, b[1] - k * 0.8 * size * v), (u, v), role, size)
        for k in range(heads)
    ]
    return group(title, line(role, path([a, shaft])), *tips)


def turn(
    at: Pixel,
    radius: float,
    value: float,
    role: str,
    title: str = "",
    facing: float = 90.0,
    span: float = 240.0,
) -> str:
    """A moment: an arc of `span` degrees around the direction `facing`; counter-clockwise where
    positive."""
    sweep = math.copysign(math.radians(span), value)
    end = math.radians(facing) + sweep / 2
    d, (x, y) = _bow(at, radius, end - sweep, sweep)
    u, v = _ahead(end + math.copysign(0.18, value), value)
    return group(title, line(role, d), head((x + 5 * u, y + 5 * v), (u, v), role))


def arc(at: Pixel, radius: float, start: float, sweep: float) -> str:
    """The arc of an angle, with a small head where it ends."""
    d, end = _bow(at, radius, start, sweep)
    bend = start + sweep - math.copysign(min(3.0 / radius, abs(sweep) / 2), sweep)
    return line("angle", d) + head(end, _ahead(bend, sweep), "angle", 7)


def _bow(at: Pixel, radius: float, start: float, sweep: float) -> tuple[str, Pixel]:
    """Path data of an arc from the direction `start` over `sweep` (rad), and where it ends."""
    angles = (start, start + sweep)
    ends = [(at[0] + radius * math.cos(a), at[1] - radius * math.sin(a)) for a in angles]
    (a, b), (c, d) = ends
    flags = f"{int(abs(sweep) > math.pi)} {int(sweep < 0)}"
    return f"M{a:.1f} {b:.1f}A{radius:.1f} {radius:.1f} 0 {flags} {c:.1f} {d:.1f}", ends[1]


def _ahead(angle: float, way: float) -> Pixel:
    """The direction along a circle at an angle; counter-clockwise where `way` is positive."""
    sign = math.copysign(1.0, way)
    return -math.sin(angle) * sign, -math.cos(angle) * sign


def dimension(ends: tuple[Pixel, Pixel], moved: tuple[Pixel, Pixel]) -> str:
    """A line with a head at both ends, and thin ones to it from what it measures."""
    (a, b), length = moved, math.dist(*moved)
    thin = "".join(path([p, q]) for p, q in zip(ends, moved, strict=True) if math.dist(p, q) > 1)
    out = line("dimension", thin + path([a, b]))
    if length < 1:
        return out
    u, v = (b[0] - a[0]) / length, (b[1] - a[1]) / length
    size = min(8.0, 0.45 * length)
    return out + head(b, (u, v), "dimension", size) + head(a, (-u, -v), "dimension", size)


def joint(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """A pin seen along its axis."""
    return circle("pin", at, size)


def sphere(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """A ball joint."""
    spot = at[0] - 0.3 * size, at[1] - 0.3 * size
    return circle("side", at, size) + circle("spot", spot, round(0.3 * size, 1))


def com(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """The quartered disc of a centre of mass."""
    x, y = at
    arc = f"A{size:g} {size:g} 0 0"
    upper = f"M{x:.1f} {y:.1f}h{size:g}{arc} 0 {x:.1f} {y - size:.1f}Z"
    quarters = f"{upper}M{x:.1f} {y:.1f}h{-size:g}{arc} 0 {x:.1f} {y + size:.1f}Z"
    return circle("com", at, size) + line("comq", quarters)


def ground(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """A support: a triangle on a hatched line; `heading` is the way up."""
    (x, y), (u, v) = at, heading

    def local(right: float, up: float) -> Pixel:
        return x + size * (-v * right + u * up), y + size * (u * right + v * up)

    strokes = [path([local(k, -1.7), local(k - 0.6, -2.3)]) for k in np.linspace(-1.5, 2.1, 7)]
    floor = path([local(-2.1, -1.7), local(2.1, -1.7)])
    triangle = path([local(0, 0), local(-1.2, -1.7), local(1.2, -1.7)], True)
    parts = {"hatch": "".join(strokes), "rail": floor, "pin": triangle}
    return "".join(line(css, d) for css, d in parts.items())


def slider(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """A block that slides along `heading`."""
    (x, y), (u, v) = at, heading
    corners = [
        (x + size * (1.5 * a * u - b * v), y + size * (1.5 * a * v + b * u))
        for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))
    ]
    return line("pin", path(corners, True))


def dot(at: Pixel, size: float, heading: Pixel, role: str) -> str:
    """A point."""
    return circle(role, at, size)


MARKS: dict[str, Callable[[Pixel, float, Pixel, str], str]] = {
    "joint": joint, "sphere": sphere, "com": com, "ground": ground, "slider": slider, "dot": dot,
}  # fmt: skip


def prism_rings(prism: Prism, view: View) -> tuple[list[Point], list[Point]]:
    """Corners of both ends, the nearer to the viewer first."""
    axis = np.asarray(prism.axis) / np.linalg.norm(prism.axis)
    other = np.eye(3)[int(np.argmin(abs(axis)))]
    u = np.cross(axis, other)
    u /= np.linalg.norm(u)
    w = np.cross(axis, u)
    first = math.pi / 4 if prism.sides == 4 else 0.0
    angles = np.arange(prism.sides) * 2 * math.pi / prism.sides + first
    ring = prism.radius * (np.outer(np.cos(angles), u) + np.outer(np.sin(angles), w))
    if axis @ np.asarray(view.towards) < 0:
        axis = -axis
    middle = np.asarray(prism.at)
    ends = (middle + prism.half * axis + ring, middle - prism.half * axis + ring)
    return [point(p) for p in ends[0]], [point(p) for p in ends[1]]


def prism(near: list[Pixel], far: list[Pixel], distant: bool) -> str:
    """Its outline, and the end that is seen."""
    parts = line("side", path(hull(near + far), True)) + line("cap", path(near, True))
    return f'<g class="far">{parts}</g>' if distant else parts


def hull(points: list[Pixel]) -> list[Pixel]:
    """Convex hull, by Andrew's monotone chain."""
    ordered = sorted(set(points))

    def half(sequence: list[Pixel]) -> list[Pixel]:
        chain: list[Pixel] = []
        for p in sequence:
            while len(chain) > 1 and _left(chain[-2], chain[-1], p) <= 0:
                chain.pop()
            chain.append(p)
        return chain[:-1]

    return half(ordered) + half(ordered[::-1])


def _left(a: Pixel, b: Pixel, c: Pixel) -> float:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def ruler(at: Pixel, length: float, label: str, role: str) -> str:
    """A scale bar, its text above."""
    x, y = at
    text = words("tick", x, y - 6, escape(label))
    if role != "length":
        return arrow(at, (x + length, y), role) + text
    ends = "".join(f"M{k:.1f} {y - 3:.1f}V{y + 3:.1f}" for k in (x, x + length))
    return line("axis", f"{ends}M{x:.1f} {y:.1f}H{x + length:.1f}") + text
