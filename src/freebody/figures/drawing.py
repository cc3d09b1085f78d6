"""A drawing as data: named elements in world coordinates, to be found by tests and written as SVG
by `svg.render`.

Places are in metres of the world, plane or space; a `View` projects them on the page. Sizes of
symbols are in pixels of the page. `role` says what a thing is and picks its colours; `name` says
which one it is, in the notes' notation ("f_{0,1}", "τ_1"), where `_` or `_{…}` is a subscript.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import UnknownNameError
from freebody.figures.text import bold, canonical
from freebody.figures.view import View, WorldPoint
from freebody.outputs.number_text import significant

SAME = 1e-6
"""Distance in metres below which two places count as one."""


@dataclass(frozen=True)
class Line:
    """A polyline, or a polygon where closed."""

    points: tuple[WorldPoint, ...]
    name: str
    role: str
    closed: bool = False
    width: float = 0.0
    """Pixels, of a link; 0 for thin lines."""
    far: bool = False
    """Drawn paler: far from the viewer."""


@dataclass(frozen=True)
class Arrow:
    """A vector `value` (in `unit`) drawn from `start` to `end`; a moment in space has two heads."""

    start: WorldPoint
    end: WorldPoint
    name: str
    role: str
    label: str = ""
    value: tuple[float, ...] = ()
    unit: str = ""
    heads: int = 1
    aside: float = 0.0
    """Pixels that it is drawn to the left of its true place, beside a link or another arrow."""
    beside: float = 0.0
    """Share of its length at which the label stands beside it; 0: at the tip."""


@dataclass(frozen=True)
class Dimension:
    """A length between two places, drawn `aside` pixels to the left of the line from the one to the
    other."""

    start: WorldPoint
    end: WorldPoint
    name: str
    role: str = "dimension"
    label: str = ""
    aside: float = 26.0


@dataclass(frozen=True)
class Turn:
    """A moment in the plane, `value` positive counter-clockwise: an arc with a head around `at`."""

    at: WorldPoint
    value: float
    name: str
    role: str
    label: str = ""
    unit: str = "N m"
    radius: float = 22.0
    facing: float = 90.0
    """The direction of the arc's middle, degrees."""
    span: float = 240.0
    """The part of a circle that the arc is, degrees."""


@dataclass(frozen=True)
class Arc:
    """An angle in the plane: from direction `start` over `sweep` (rad), radius in metres."""

    at: WorldPoint
    radius: float
    start: float
    sweep: float
    name: str
    role: str = "angle"
    label: str = ""


@dataclass(frozen=True)
class Mark:
    """A symbol of `size` pixels: joint, com, ground, rail, slider, dot or sphere; `direction` turns
    it."""

    at: WorldPoint
    kind: str
    name: str
    role: str
    direction: WorldPoint | None = None
    size: float = 7.0


@dataclass(frozen=True)
class Prism:
    """A short solid along `axis`, in metres: a cylinder, or a box with 4 sides."""

    at: WorldPoint
    axis: WorldPoint
    radius: float
    half: float
    name: str
    role: str
    sides: int = 24
    far: bool = False


@dataclass(frozen=True)
class Label:
    """A formula near a place; the writer looks for room around it, in `direction` first."""

    at: WorldPoint
    text: str
    name: str
    role: str = "label"
    direction: WorldPoint | None = None


@dataclass(frozen=True)
class Cells:
    """Coloured cells of a plane: that in row i and column j is the parallelogram of `across` and
    `up` at corner + j across + i up."""

    corner: WorldPoint
    across: WorldPoint
    up: WorldPoint
    colours: tuple[tuple[int, ...], ...]
    """Numbers of the map's colours, row by row; -1: nothing."""
    name: str
    role: str = "map"


@dataclass(frozen=True)
class ColourKey:
    """The key of a map's colours."""

    title: str
    colours: tuple[int, ...]
    texts: tuple[str, ...]
    """A number for each colour, or for each edge of a colour's interval."""
    between: bool = False
    """Whether they are of edges."""


Element = Line | Arrow | Dimension | Turn | Arc | Mark | Prism | Label | Cells


@dataclass
class Drawing:
    """A drawing: its elements in the order of drawing, a view, and a text for readers who cannot
    see it."""

    view: View
    title: str
    elements: list[Element] = field(default_factory=list)
    heading: str = ""
    """Text above the drawing."""
    compass: bool = False
    """Whether small axes of the world stand in a corner."""
    notes: list[str] = field(default_factory=list)
    """Lines of text below the picture."""
    rulers: list[tuple[float, str, str]] = field(default_factory=list)
    """Scale bars: length in metres of the world, text, role."""
    key: ColourKey | None = None
    """The key of the colours, below the picture."""
    scale: float | None = None
    """Pixels a metre; default: what fits."""
    labels: str = "names"
    """The labels beside the elements, one of `labelling.LABELS`."""

    def add(self, *elements: Element) -> None:
        """Add elements to the drawing."""
        self.elements.extend(elements)

    def line(self, points: Iterable[Iterable[float]], name: str, role: str, **how: Any) -> None:
        """Draw a line through places; how: further fields of `Line`."""
        self.add(Line(tuple(map(point, points)), name, role, **how))

    def mark(self, at: Iterable[float], kind: str, name: str, role: str, size: float) -> None:
        """Add a symbol to the drawing."""
        self.add(Mark(point(at), kind, name, role, size=size))

    def write(self, at: Iterable[float], text: str, direction: Iterable[float]) -> None:
        """Write a formula near a place, in the given direction if there is room; repeated calls
        write it once."""
        at, name = point(at), f"label {text}"
        written = (e.at for e in self.elements if isinstance(e, Label) and e.name == name)
        if all(math.dist(at, other) > SAME for other in written):
            self.add(Label(at, text, name, direction=point(direction)))

    def centre(self, at: Iterable[float], name: str, direction: Iterable[float]) -> None:
        """Draw a centre of mass, with its name."""
        at = point(at)
        self.mark(at, "com", name, "com", 6.0)
        self.write(at, name, direction)

    def arrow(
        self,
        start: Iterable[float],
        end: Iterable[float],
        name: str,
        role: str,
        value: Iterable[float] = (),
        unit: str = "",
        *,
        label: str | None = None,
        **how: Any,
    ) -> None:
        """Draw a vector; its label is its name in bold unless another one is given."""
        text = bold(name) if label is None else label
        self.add(Arrow(point(start), point(end), name, role, text, point(value), unit, **how))

    def position(self, start: Array, end: Array, name: str, aside: float = 0.0) -> None:
        """Draw a position vector with a label beside its middle; nothing is drawn where its length
        is 0."""
        if np.linalg.norm(np.subtract(end, start)) > SAME:
            value = np.subtract(end, start)
            self.arrow(start, end, name, "position", value, "m", beside=0.5, aside=aside)

    def ruler(self, about: float, reach: float, unit: str, role: str) -> None:
        """Draw a scale bar for a round size up to `about` (in `unit`); a bar for `about` itself
        would be `reach` metres long."""
        size = round_down(about)
        text = metres(size, 2) if role == "length" else f"{significant(size, 1)} {unit}"
        self.rulers.append((size / about * reach, text, role))

    def named(self, name: str) -> Element:
        """The element of that name, "s_1" or "s_{1}"; UnknownNameError lists the names."""
        return named((self,), name, self.title)

    @property
    def arrows(self) -> list[Arrow]:
        """All arrows of the drawing."""
        return [element for element in self.elements if isinstance(element, Arrow)]


def named(drawings: Sequence[Drawing], name: str, title: str) -> Element:
    """The element of that name in the first drawing that has it."""
    elements = [element for drawing in drawings for element in drawing.elements]
    for element in elements:
        if canonical(element.name) == canonical(name):
            return element
    raise UnknownNameError("element", name, repr(title), sorted({e.name for e in elements}))


def places(element: Element) -> tuple[WorldPoint, ...]:
    """A length in metres as text with its unit."""
    match element:
        case Line():
            return element.points
        case Arrow() | Dimension():
            return element.start, element.end
        case Arc():
            (x, y), r = element.at, element.radius
            turned = [element.start + element.sweep * k / 4 for k in range(5)]
            return (x, y), *((x + r * math.cos(a), y + r * math.sin(a)) for a in turned)
        case Prism():
            middle, axis = np.asarray(element.at), np.asarray(element.axis) * element.half
            across = np.eye(3) - np.outer(axis, axis) / (axis @ axis)
            rim = [middle + sign * element.radius * row for row in across for sign in (-1, 1)]
            return tuple(middle + axis), tuple(middle - axis), *map(tuple, rim)
        case Cells():
            corner, i, j = np.asarray(element.corner), len(element.colours), len(element.colours[0])
            far = np.multiply(i, element.up), np.multiply(j, element.across)
            return tuple(corner), *(tuple(corner + way) for way in (*far, far[0] + far[1]))
        case _:
            return (element.at,)


def metres(length: float, digits: int = 3) -> str:
    """The largest number of the form 1, 2 or 5 times a power of ten that is not above a value."""
    if length >= 0.1:
        return f"{significant(length, digits)} m"
    return f"{significant(1000 * length, digits)} mm"


def round_down(value: float) -> float:
    """The largest of 1, 2 or 5 times a power of ten that is not above a value."""
    power = 10.0 ** math.floor(math.log10(value))
    return max(k * power for k in (1, 2, 5) if k * power <= value * (1 + 1e-12))


def point(values: Iterable[float]) -> WorldPoint:
    """The coordinates of a place as plain floats."""
    return tuple(float(x) for x in values)
