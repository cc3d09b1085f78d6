"""A `Drawing` as SVG text: fits it on a page, draws each element, finds room for the labels."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from html import escape
from itertools import pairwise

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.figures import colours, labelling, svg_symbols, text
from freebody.figures.drawing import (
    SAME,
    Arc,
    Arrow,
    Dimension,
    Drawing,
    Element,
    Label,
    Line,
    Mark,
    Prism,
    Turn,
    View,
    places,
)
from freebody.figures.label_placement import Crowd, Placed, Wanted
from freebody.outputs.numbers import significant
from freebody.outputs.text import legal

XMLNS = 'xmlns="http://www.w3.org/2000/svg"'
_NOTE = 17.0  # height of a line of notes
_MARGIN = 46.0  # pixels around everything, for labels
_STRIP = 14.0  # below, for scale bars
_VALUE = 12.0  # height of the letters of values
_LOST = 1e-12  # of the distance from the origin: what is shorter is lost in rounding


@dataclass
class Page:
    """From metres to pixels, and what has been written so far."""

    drawing: Drawing
    scale: float
    shift: Array
    crowd: Crowd
    body: list[str]
    wanted: list[Wanted]

    def at(self, place: tuple[float, ...]) -> tuple[float, float]:
        """Pixels of a place of the world; y down."""
        x, y = self.drawing.view.project([place])[0]
        return float(self.shift[0] + self.scale * x), float(self.shift[1] - self.scale * y)

    def towards(self, direction: tuple[float, ...]) -> tuple[float, float]:
        """A direction of the world on the page, unit length, y down; to the right where it points
        at the viewer."""
        x, y = self.drawing.view.project([direction])[0]
        size = math.hypot(x, y)
        return (float(x / size), float(-y / size)) if size > 1e-9 else (1.0, 0.0)

    def want(
        self, element: Element, css: str, anchors: Sequence[tuple[float, float, float, float]]
    ) -> None:
        """Ask for room for what stands beside an element."""
        formula, after = labelling.beside(element, self.drawing.labels)
        if formula or after:
            wide = text.formula_width(formula) + text.width(after, _VALUE)
            self.wanted.append(Wanted(formula, css, anchors, text.SIZE, wide, after))

    def around(
        self,
        e: Turn | Arc | Mark,
        css: str,
        r: float,
        start: float,
        sweep: float,
        shares: Sequence[float],
    ) -> None:
        """Keep clear of an arc of r pixels around an element's place, from the direction `start`
        over `sweep` (rad), and ask for room outside it at shares of its length."""
        x, y = self.at(e.at)
        count = max(8, int(abs(sweep) * r / 5))

        def on(share: float) -> tuple[float, float, float, float]:
            u, v = math.cos(start + sweep * share), -math.sin(start + sweep * share)
            return x + r * u, y + r * v, u, v

        self.crowd.points += [on(k / count)[:2] for k in range(count + 1)]
        self.want(e, css, [on(share) for share in shares])


@dataclass(frozen=True)
class Picture:
    """SVG elements and the size of the page they stand on."""

    body: str
    width: float
    height: float
    title: str

    def text(self, css: bool = True, place: str = "") -> str:
        """The SVG document. css: with a style sheet, to stand alone. place: attributes x and y,
        inside another."""
        style = f"<style>{colours.style()}</style>" if css else ""
        size = f'width="{self.width:g}" height="{self.height:.0f}"'
        title = escape(self.title, quote=True)
        return legal(
            f'<svg {place or XMLNS} class="fig" viewBox="0 0 {self.width:g} {self.height:.0f}" '
            f'{size} role="img" aria-label="{title}">{style}{self.body}</svg>'
        )

    def inline(self) -> str:
        """Inside an HTML page, which has the style sheet and knows SVG without its namespace."""
        return self.text(css=False).replace(f" {XMLNS}", "", 1)


def picture(drawing: Drawing, width: float = 560.0, tallest: float = 460.0) -> Picture:
    """The drawing on a page `width` pixels wide and as tall as it needs."""
    page, height, labels = laid_out(drawing, width, tallest)
    page.body += [_label(placed) for placed in labels]
    page.body += _corners(drawing, page, height)
    page.body += [
        _centred("n", width / 2, height + 4 + _NOTE * (k + 0.6), note, 12.0)
        for k, note in enumerate(drawing.notes)
    ]
    height += _NOTE * len(drawing.notes) + (8 if drawing.notes else 0)
    return Picture("".join(page.body), width, height, drawing.title)


def laid_out(drawing: Drawing, width: float, tallest: float) -> tuple[Page, float, list[Placed]]:
    """The page with all but the labels, its height, and where the labels go."""
    page, height = _fit(drawing, width, tallest)
    for element in drawing.elements:
        _DRAW[type(element)](page, element)
    return page, height, page.crowd.settle(page.wanted)


def natural_scale(drawing: Drawing, width: float, tallest: float) -> float:
    """Pixels a metre at which the drawing just fits."""
    span = _bounds(drawing)[1] - _bounds(drawing)[0]
    return float(min((width - 2 * _MARGIN) / span[0], (tallest - 2 * _MARGIN) / span[1]))


def _bounds(drawing: Drawing) -> tuple[Array, Array]:
    spanned = [p for element in drawing.elements for p in places(element)]
    flat = drawing.view.project(spanned) if spanned else np.zeros((1, 2))
    span, far = float(np.ptp(flat, axis=0).max()), float(abs(flat).max())
    if max(span, SAME) < _LOST * far:
        raise FreebodyError(
            f"{drawing.title}: what is to be drawn is {significant(span, 2)} m long and "
            f"{significant(far, 2)} m from the origin, where so short a length is lost in "
            f"rounding. Use lengths that differ less."
        )
    return flat.min(axis=0), np.maximum(flat.max(axis=0), flat.min(axis=0) + 1e-9)


def _fit(drawing: Drawing, width: float, tallest: float) -> tuple[Page, float]:
    low, high = _bounds(drawing)
    scale = drawing.scale or natural_scale(drawing, width, tallest)
    top = 18.0 if drawing.heading else 0.0
    inner = max(float(high[1] - low[1]) * scale + 2 * _MARGIN, 120.0)
    middle = (low + high) / 2
    shift = np.array([width / 2 - scale * middle[0], top + inner / 2 + scale * middle[1]])
    height = top + inner + (_STRIP if drawing.rulers else 0.0)
    crowd = Crowd(width, height - (_STRIP + 14.0 if drawing.rulers else 0.0))
    if drawing.compass:
        crowd.boxes.append((width - 70.0, height - 62.0, width, height))
    return Page(drawing, scale, shift, crowd, [], []), height


def _line(page: Page, e: Line) -> None:
    points = [page.at(p) for p in e.points]
    d = svg_symbols.path(points, e.closed)
    if e.width:
        edge = f'<path class="edge" stroke-width="{e.width + 2.4:g}" d="{d}"/>'
        bar = f'<path class="bar" stroke-width="{e.width:g}" d="{d}"/>'
        page.body.append(f'<g class="far">{edge}{bar}</g>' if e.far else edge + bar)
    else:
        page.body.append(svg_symbols.line(e.role, d))
        points += points[: int(e.closed)]
    if e.role not in ("grid", "shadow", "ghost"):
        for a, b in pairwise(points):
            page.crowd.keep_clear(a, b, e.width / 2 + 2 if e.width else 0.0)


def _arrow(page: Page, e: Arrow) -> None:
    a, b = _beside(page.at(e.start), page.at(e.end), e.aside)
    page.body.append(svg_symbols.arrow(a, b, e.role, e.heads, _tooltip(page, e)))
    page.crowd.keep_clear(a, b)
    dx, dy = (b[0] - a[0], b[1] - a[1])
    beyond = (*b, dx, dy) if math.hypot(dx, dy) > 1 else (*b, 1.0, -1.0)
    at, side = e.beside or 0.5, 1.0 if e.aside >= 0 else -1.0
    near, across = (
        [(a[0] + k * dx, a[1] + k * dy, s * dy, -s * dx) for k in (at, at + 0.15, at - 0.15)]
        for s in (side, -side)
    )
    anchors = [*near, *across, beyond] if e.beside else [beyond, near[0], across[0]]
    page.want(e, f"{e.role}-text", anchors)


def _beside(
    a: svg_symbols.Pixel, b: svg_symbols.Pixel, aside: float
) -> tuple[svg_symbols.Pixel, svg_symbols.Pixel]:
    """A segment moved some pixels to its left."""
    length = math.dist(a, b)
    if not aside or not length:
        return a, b
    u, v = aside * (b[1] - a[1]) / length, -aside * (b[0] - a[0]) / length
    return (a[0] + u, a[1] + v), (b[0] + u, b[1] + v)


def _dimension(page: Page, e: Dimension) -> None:
    ends = page.at(e.start), page.at(e.end)
    a, b = _beside(*ends, e.aside)
    page.body.append(svg_symbols.dimension(ends, (a, b)))
    page.crowd.keep_clear(a, b)
    for end, moved in zip(ends, (a, b), strict=True):
        page.crowd.keep_clear(end, moved)
    (x, y), dx, dy, side = a, b[0] - a[0], b[1] - a[1], 1.0 if e.aside >= 0 else -1.0
    anchors = [(x + k * dx, y + k * dy, side * dy, -side * dx) for k in (0.5, 0.65, 0.35)]
    page.want(e, "dimension-text", anchors)


def _turn(page: Page, e: Turn) -> None:
    at, title = page.at(e.at), _tooltip(page, e)
    page.body.append(svg_symbols.turn(at, e.radius, e.value, e.role, title, e.facing, e.span))
    start, sweep = math.radians(e.facing - e.span / 2), math.radians(e.span)
    page.around(e, f"{e.role}-text", e.radius, start, sweep, (0.75, 0.25, 0.5, 1.0, 0.0))


def _arc(page: Page, e: Arc) -> None:
    r = e.radius * page.scale
    page.body.append(svg_symbols.arc(page.at(e.at), r, e.start, e.sweep))
    page.around(e, "", r, e.start, e.sweep, (0.5, 0.7, 0.3))


def _mark(page: Page, e: Mark) -> None:
    x, y = page.at(e.at)
    u, v = page.towards(e.direction) if e.direction else (1.0, 0.0)
    page.body.append(svg_symbols.MARKS[e.kind]((x, y), e.size, (u, v), e.role))
    page.crowd.keep_clear((x - e.size * 0.7, y), (x + e.size * 0.7, y))
    page.around(e, "", e.size, 0.0, 2 * math.pi, ())
    if e.kind == "ground":
        for depth in (1.2 * e.size, 2.0 * e.size):
            a, b = x - depth * u, y - depth * v
            wide = 2 * e.size * v, 2 * e.size * u
            page.crowd.keep_clear((a + wide[0], b - wide[1]), (a - wide[0], b + wide[1]))


def _prism(page: Page, e: Prism) -> None:
    near, far = svg_symbols.prism_rings(e, page.drawing.view)
    page.body.append(
        svg_symbols.prism([page.at(p) for p in near], [page.at(p) for p in far], e.far)
    )
    outline = svg_symbols.hull([page.at(p) for p in near + far])
    for a, b in zip(outline, outline[1:] + outline[:1], strict=True):
        page.crowd.keep_clear(a, b)


def _text(page: Page, e: Label) -> None:
    x, y = page.at(e.at)
    dx, dy = page.towards(e.direction) if e.direction else (0.8, -0.8)
    page.want(e, f"{e.role}-text", [(x, y, dx, dy), (x, y, -dx, -dy)])


_DRAW = {
    Line: _line,
    Arrow: _arrow,
    Dimension: _dimension,
    Turn: _turn,
    Arc: _arc,
    Mark: _mark,
    Prism: _prism,
    Label: _text,
}
assert set(_DRAW) == set(Element.__args__)


def _tooltip(page: Page, e: Arrow | Turn) -> str:
    _, after = labelling.beside(e, page.drawing.labels)
    return text.plain(e.label or e.name) + after


def _centred(css: str, x: float, y: float, sentence: str, size: float) -> str:
    return svg_symbols.words(css, x, y, text.marked(text.sentence(sentence), size), "middle")


def _label(placed: Placed) -> str:
    (left, top, right, bottom), wanted = placed.box, placed.wanted
    after = f'<tspan class="num">{escape(wanted.after)}</tspan>' if wanted.after else ""
    shown = text.marked(text.runs(wanted.text)) + after
    x, y = (left + right) / 2, bottom - (bottom - top) * 0.27
    return svg_symbols.words(f"halo f {wanted.css}", x, y, shown, "middle")


def _corners(drawing: Drawing, page: Page, height: float) -> list[str]:
    """Heading above; below, scale bars to the left and the world's axes to the right."""
    width = page.crowd.width
    heading = escape(drawing.heading)
    out = [svg_symbols.words("name", 12, 20, heading)] if heading else []
    x = 14.0
    for metres, label, role in drawing.rulers:
        length = metres * page.scale
        out.append(svg_symbols.ruler((x, height - 10.0), length, label, role))
        x += max(length, text.width(label, 11)) + 26
    return out + (_compass(drawing.view, (width - 34.0, height - 26.0)) if drawing.compass else [])


def _compass(view: View, at: tuple[float, float]) -> list[str]:
    """Small arrows along the world's axes."""
    out = []
    for k, name in enumerate("xyz"[: len(view.rows[0])]):
        u, v = 20.0 * view.rows[0][k], -20.0 * view.rows[1][k]
        out.append(svg_symbols.arrow(at, (at[0] + u, at[1] + v), name))
        far = 1.0 + 9.0 / max(math.hypot(u, v), 6.0)
        out.append(_centred("tick", at[0] + far * u, at[1] + far * v + 4, name, 11.0))
    return out
