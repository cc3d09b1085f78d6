"""Curves over time as small SVG pictures: axes with units, curves with their names beside them, a
peak marked, limits dashed."""

from __future__ import annotations

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.arrays import Array
from freebody.figures.colours import SERIES
from freebody.figures.curve_names import SIZE, named_curves
from freebody.figures.labelling import Box
from freebody.figures.marked_text import width
from freebody.figures.svg import Picture
from freebody.figures.svg_symbols import circle, line, path, words
from freebody.outputs.number_text import fixed, significant, superscript

_LEFT, _RIGHT, _TOP, _BOTTOM, _ROW = 52.0, 12.0, 40.0, 30.0, 15.0
_SECOND = 40.0  # pixels: on the right, where there is a second axis
_SEEN = 0.15  # pixels: a curve may leave its samples by no more than this


@dataclass(frozen=True)
class Plot:
    """A plot to be drawn: curves (k,) over t (k,) by name, each of them in `unit`."""

    title: str
    t: Array
    curves: Mapping[str, Array]
    unit: str
    limits: tuple[float, ...] = ()
    """Levels drawn dashed, where they are near the curves."""
    now: float | None = None
    """An instant marked by a vertical line."""
    peaks: bool = True
    """Whether the point of the first curve farthest from zero is marked."""
    names: bool = True
    """Whether the curves are named: beside them, or in a legend where there is no room."""
    size: tuple[float, float] = (340.0, 200.0)
    log: bool = False
    across: str = "t in s"
    """The title of the horizontal axis."""
    colours: Mapping[str, int] | None = None
    """The colour of each curve by name; default their order."""
    faint: Collection[str] = ()
    """Names of curves drawn behind the others, thin: measured ones, with their noise."""
    also: tuple[float, str] | None = None
    """A second unit, on an axis at the right, and how many of it are one of `unit`."""

    def colour(self, name: str) -> int:
        """The number of a curve's colour."""
        number = list(self.curves).index(name) if self.colours is None else self.colours[name]
        return number % SERIES


def plot(what: Plot) -> Picture:
    """Picture of a plot with its axes and curves."""
    what = _to_print(what)
    w, h = what.size
    axes = _axes(what)
    box, (low, high) = axes.box, axes.range
    body = [words("name", 6 + 16j, escape(what.title)), *_grid(axes, what)]
    if what.now is not None:
        d = f"M{axes.x(what.now):.1f} {box[1]:.1f}V{box[3]:.1f}"
        body.append(line("now", d, f"t = {what.now:.4g} s"))
    for level in what.limits:
        if low <= level <= high:
            body.append(axes.level("limit", level, f"limit {significant(level)}"))
    drawn: dict[str, Array] = {}
    behind = len(body)
    for name, curve in what.curves.items():
        pieces = []
        for run in _runs(curve):
            x, y = axes.x(what.t[run]), axes.y(curve[run])
            needed = thin(x, y)
            pieces += [np.stack([x, y], axis=-1)[needed], np.full((1, 2), np.nan)]
            d = path((x + 1j * y)[needed].tolist())
            css = f"curve s{what.colour(name)}"
            if name in what.faint:
                body.insert(behind, line(f"{css} faint", d, name))
            else:
                body.append(line(css, d, name))
        drawn[name] = np.concatenate(pieces) if pieces else np.full((1, 2), np.nan)
    peak = _peak(axes, what) if what.peaks and not what.log else None
    if peak is not None:
        body.append(peak.svg)
    placed = named_curves(drawn, box, [peak.box] if peak else []) if what.names else []
    for label in placed:
        css = f"num halo f{what.colour(label.name)}"
        body.append(words(css, label.at, escape(label.name), "middle"))
    rows = _legend(what, {label.name for label in placed})
    for k, row in enumerate(rows):
        for name, x in row:
            at = complex(x, h + 11 + _ROW * k)
            d = f"M{at.real:.1f} {at.imag - 4:.1f}h14"
            body.append(line(f"curve s{what.colour(name)}", d))
            body.append(words("num", at + 19, escape(name)))
    tall = h + _ROW * len(rows) + (4 if rows else 0)
    return Picture("".join(body), w, tall, f"{what.title}, {what.unit} over time")


def axes_of(what: Plot) -> PlotAxes:
    """The axes of a plot: where they lie on its page, and in the curves' own units what they
    show; of logarithms the powers of ten."""
    printed = _axes(_to_print(what))
    power = 10.0 ** _power(what)
    return replace(printed, range=(printed.range[0] * power, printed.range[1] * power))


def _axes(what: Plot) -> PlotAxes:
    """The axes of a plot with values as they print them."""
    w, h = what.size
    box = (_LEFT, _TOP, w - (_SECOND if what.also else _RIGHT), h - _BOTTOM)
    return PlotAxes(box, (float(what.t[0]), float(what.t[-1])), _range(what), what.log)


def _power(what: Plot) -> int:
    """The power of ten taken out of numbers too small or large to print; 0 where none is."""
    if what.log:
        return 0
    curves = (np.asarray(curve, dtype=float) for curve in what.curves.values())
    finite = (np.abs(curve[np.isfinite(curve)]) for curve in curves)
    size = max((float(values.max(initial=0.0)) for values in finite), default=0.0)
    return 0 if size == 0 or 1e-2 <= size < 1e5 else math.floor(math.log10(size))


def _to_print(what: Plot) -> Plot:
    """The plot with values as the axis prints them: logarithms, or with a power of ten taken out of
    numbers too small or large to print."""
    curves = {name: np.asarray(curve, dtype=float) for name, curve in what.curves.items()}
    if what.log:
        logs = {k: np.log10(np.maximum(np.abs(x), 1e-300)) for k, x in curves.items()}
        return replace(what, curves=logs)
    power = _power(what)
    if not power:
        return replace(what, curves=curves)
    return replace(
        what,
        curves={name: curve / 10.0**power for name, curve in curves.items()},
        limits=tuple(level / 10.0**power for level in what.limits),
        unit=f"10{superscript(power)} {what.unit}",
        also=what.also and (what.also[0] * 10.0**power, what.also[1]),
    )


def _runs(curve: Array) -> list[slice]:
    """The stretches of a curve that can be drawn: where it is not finite, it is interrupted."""
    steps = np.flatnonzero(np.diff(np.isfinite(curve).astype(int), prepend=0, append=0))
    return [slice(int(a), int(b)) for a, b in zip(steps[::2], steps[1::2], strict=True)]


def thin(x: Array, y: Array, tolerance: float = _SEEN) -> NDArray[np.intp]:
    """Indices of the samples that a polyline needs to stay within `tolerance` of all (Ramer,
    Douglas, Peucker)."""
    keep = np.zeros(len(x), dtype=bool)
    keep[[0, -1]] = True
    waiting = [(0, len(x) - 1)]
    while waiting:
        a, b = waiting.pop()
        if b - a < 2:
            continue
        inner = slice(a + 1, b)
        across = np.abs((x[b] - x[a]) * (y[inner] - y[a]) - (y[b] - y[a]) * (x[inner] - x[a]))
        off = across / max(math.hypot(x[b] - x[a], y[b] - y[a]), 1e-12)
        worst = int(np.argmax(off))
        if off[worst] > tolerance:
            middle = a + 1 + worst
            keep[middle] = True
            waiting += [(a, middle), (middle, b)]
    return np.flatnonzero(keep)


def ticks(low: float, high: float, most: int = 5) -> list[float]:
    """Round values between low and high."""
    step = (high - low) / most
    power = 10.0 ** math.floor(math.log10(step))
    step = next(k * power for k in (1, 2, 2.5, 5, 10) if k * power >= step * (1 - 1e-9))
    first = math.ceil(low / step - 1e-9)
    return [k * step for k in range(first, math.floor(high / step + 1e-9) + 1)]


@dataclass(frozen=True)
class PlotAxes:
    """The axes of a plot: left, top, right and bottom on its page, and what they show."""

    box: tuple[float, float, float, float]
    time: tuple[float, float]
    range: tuple[float, float]
    log: bool

    def x(self, t: ArrayLike) -> Array:
        left, _, right, _ = self.box
        a, b = self.time
        return left + (np.asarray(t) - a) / (b - a or 1.0) * (right - left)

    def y(self, value: ArrayLike) -> Array:
        _, top, _, bottom = self.box
        low, high = self.range
        return bottom - (np.asarray(value) - low) / (high - low) * (bottom - top)

    def level(self, css: str, value: float, title: str = "") -> str:
        """An SVG line across the plot at a value."""
        left, _, right, _ = self.box
        return line(css, f"M{left:.1f} {float(self.y(value)):.1f}H{right:.1f}", title)


def _range(what: Plot) -> tuple[float, float]:
    """The lowest and highest value of the axis, so that it holds all curves, zero where it is near,
    and limits that a curve comes near."""
    values = np.concatenate(list(what.curves.values()))
    values = values[np.isfinite(values)]
    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    if what.log:
        return math.floor(low), max(math.ceil(high), math.floor(low) + 1)
    size = max(abs(low), abs(high))
    near = [level for level in what.limits if math.isfinite(level) and abs(level) < 1.6 * size]
    low, high = min([low, *near]), max([high, *near])
    span = high - low
    if span <= 1e-9 * max(size, 1e-12):
        half = 0.5 * size if size > 1e-12 else 1.0
        return low - half, high + half
    if 0 < low < 0.5 * span:
        low = 0.0
    if -0.5 * span < high < 0:
        high = 0.0
    below, above = (0.14 if abs(edge) >= 0.98 * size else 0.06 for edge in (low, high))
    return low - below * span, high + above * span


def _grid(axes: PlotAxes, what: Plot) -> list[str]:
    left, top, right, bottom = axes.box
    out = []
    levels = ticks(*axes.range, most=4) if not axes.log else _decades(*axes.range)
    for level in levels:
        text = f"10{_raised(level)}" if axes.log else tick(level, levels)
        out.append(axes.level("grid", level))
        out.append(words("tick", complex(left - 6, axes.y(level) + 4), text, "end"))
    if what.also is not None:
        out += _second(axes, *what.also)
    instants = ticks(*axes.time)
    for t in instants:
        x = float(axes.x(t))
        out.append(line("axis", f"M{x:.1f} {bottom:.1f}v4"))
        out.append(words("tick", complex(x, bottom + 16), tick(t, instants), "middle"))
    if not axes.log and axes.range[0] < 0 < axes.range[1]:
        out.append(axes.level("axis", 0.0))
    frame = line("frame", f"M{left:.1f} {top:.1f}V{bottom:.1f}H{right:.1f}")
    time = words("unit", complex(right, bottom + 28), escape(what.across), "end")
    end = max(left - 6, width(what.unit, 11) + 4)
    return [*out, frame, time, words("unit", complex(end, top - 7), escape(what.unit), "end")]


def _second(axes: PlotAxes, factor: float, unit: str) -> list[str]:
    """The axis of a second unit, of which `factor` are one of the first, at the plot's right."""
    _, top, right, _ = axes.box
    levels = ticks(*(factor * end for end in axes.range), most=4)
    out = [words("unit", complex(right + 6, top - 7), escape(unit))]
    for level in levels:
        y = float(axes.y(level / factor))
        out.append(line("axis", f"M{right:.1f} {y:.1f}h4"))
        out.append(words("tick", complex(right + 7, y + 4), tick(level, levels)))
    return out


def _decades(low: float, high: float) -> list[float]:
    step = max(1, math.ceil((high - low) / 4))
    return [float(k) for k in range(int(low), int(high) + 1, step)]


def _raised(level: float) -> str:
    return f'<tspan dy="-4" font-size="75%">{fixed(level, 0)}</tspan>'


def tick(value: float, all_values: Sequence[float]) -> str:
    """The number printed at a tick, with as many decimals as the step between ticks needs."""
    step = all_values[1] - all_values[0] if len(all_values) > 1 else 1.0
    size = max(abs(v) for v in all_values) if all_values else 1.0
    if abs(value) < 1e-9 * max(size, step):
        return "0"
    if size >= 1e5 or step < 1e-4:
        return significant(value, 3)
    decimals = max(0, -math.floor(math.log10(step) + 1e-9))
    if abs(step * 10**decimals - round(step * 10**decimals)) > 1e-6:
        decimals += 1
    return fixed(value, decimals)


@dataclass(frozen=True)
class _Peak:
    """The mark and the printed value of the first curve where it is farthest from zero, and the box
    of that text."""

    svg: str
    box: Box


def _peak(axes: PlotAxes, what: Plot) -> _Peak | None:
    curve = next(iter(what.curves.values()))
    k = int(np.argmax(np.abs(curve)))
    if abs(curve[k]) < 1e-12:
        return None
    at, text = complex(axes.x(what.t[k]), axes.y(curve[k])), significant(float(curve[k]))
    half, below = width(text, 11) / 2, -7 if curve[k] > 0 else 15
    left, right = axes.box[0] + half + 4, axes.box[2] - half
    inside = min(max(at.real, left), right)
    if what.now is not None and abs(inside - (now := float(axes.x(what.now)))) < half + 3:
        beside = [now + side * (half + 5) for side in ((1, -1) if at.real >= now else (-1, 1))]
        inside = next((x for x in beside if left <= x <= right), inside)
    y = at.imag + below
    beside = words("tick halo", complex(inside, y), text, "middle")
    mark = circle("peak f0", at, 3.4, f"{text} {what.unit} at {what.t[k]:.4g} s")
    return _Peak(mark + beside, (inside - half, y - 11, inside + half, y + 4))


def _legend(what: Plot, placed: Collection[str]) -> list[list[tuple[str, float]]]:
    """(name, x) of the curves without a name beside them, in rows that fit."""
    rows: list[list[tuple[str, float]]] = []
    x = math.inf
    for name in what.curves if what.names else ():
        if name in placed:
            continue
        needed = width(name, SIZE) + 40
        if x + needed > what.size[0]:
            rows.append([])
            x = 8.0
        rows[-1].append((name, x))
        x += needed
    return rows
