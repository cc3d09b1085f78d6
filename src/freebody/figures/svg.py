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
from freebody.figures import colours, labelling, marked_text, svg_symbols
from freebody.figures.drawing import (
    SAME,
    Arc,
    Arrow,
    Cells,
    Dimension,
    Drawing,
    Element,
    Label,
    Line,
    Mark,
    Prism,
    Turn,
    places,
)
from freebody.figures.labelling import RULE, Box, Crowd, Wanted, leader
from freebody.figures.view import View
from freebody.outputs.harmless_text import legal
from freebody.outputs.number_text import significant

XMLNS = 'xmlns="http://www.w3.org/2000/svg"'
_NOTE = 17.0  # height of a line of notes
_MARGIN = 46.0  # pixels around everything, for labels
_STRIP = 14.0  # below, for scale bars
_VALUE = 12.0  # height of the letters of values
_LOST = 1e-12  # of the distance from the origin: what is shorter is lost in rounding


Anchor = tuple[complex, complex]
"""A place on the page and the direction in which a label would like to go from there."""


@dataclass
class Page:
    """An SVG picture being built: the map from metres to pixels, and what has been written so
    far."""

    drawing: Drawing
    scale: float
    shift: complex
    crowd: Crowd
    body: list[str]
    wanted: list[Wanted]

    def at(self, place: Sequence[float]) -> complex:
        """The pixels of a place in the world; y points down."""
        return self.shift + self.scale * self.drawing.view.on_page(place)

    def towards(self, direction: Sequence[float] | None, default: complex = 1.0) -> complex:
        """The unit direction on the page of a direction in the world; to the right where that
        points at the viewer."""
        way = default if direction is None else self.drawing.view.on_page(direction)
        return way / abs(way) if abs(way) > 1e-9 else 1.0

    def want(self, element: Element, css: str, anchors: Sequence[Anchor]) -> None:
        """Request a place for the label beside an element, near the given anchors."""
        formula, after = labelling.beside(element, self.drawing.labels)
        if formula or after:
            wide = marked_text.formula_width(formula) + marked_text.width(after, _VALUE)
            self.wanted.append(Wanted(formula, css, anchors, wide, after))

    def around(
        self, e: Turn | Arc | Mark, css: str, r: float, start: float, sweep: float,
        shares: Sequence[float],
    ) -> None:  # fmt: skip
        """Keep labels clear of an arc of r pixels around an element's place, from the direction
        `start` over `sweep` (rad), and request a place for the element's label outside it at given
        fractions of its length."""

        def on(share: float) -> Anchor:
            way = svg_symbols.towards(start + sweep * share)
            return self.at(e.at) + r * way, way

        count = max(8, int(abs(sweep) * r / 5))
        self.crowd.points += [on(k / count)[0] for k in range(count + 1)]
        self.want(e, css, [on(share) for share in shares])


@dataclass(frozen=True)
class Picture:
    """SVG elements and the size of the page they stand on."""

    body: str
    width: float
    height: float
    title: str

    def text(self, css: bool = True, place: str = "") -> str:
        """The SVG document as text. css: with a style sheet, to stand alone. place: attributes x
        and y, for use inside another document."""
        style = f"<style>{colours.style()}</style>" if css else ""
        size = f'width="{self.width:g}" height="{self.height:.0f}"'
        title = escape(self.title, quote=True)
        return legal(
            f'<svg {place or XMLNS} class="fig" viewBox="0 0 {self.width:g} {self.height:.0f}" '
            f'{size} role="img" aria-label="{title}">{style}{self.body}</svg>'
        )

    def inline(self) -> str:
        """The SVG element for use inside an HTML page, which has the style sheet and needs no
        namespace."""
        return self.text(css=False).replace(f" {XMLNS}", "", 1)


def picture(drawing: Drawing, width: float = 560.0, tallest: float = 460.0) -> Picture:
    """The drawing on a page `width` pixels wide and as tall as it needs."""
    return _finished(*laid_out(drawing, width, tallest), drawing, width)


def alike(drawings: Sequence[Drawing], width: float, tallest: float) -> list[Picture]:
    """Pictures of drawings with one view on pages of one size, on which each place of the world is
    at the same pixels."""
    bounds = [_bounds(drawing) for drawing in drawings]
    low, high = np.min([a for a, _ in bounds], axis=0), np.max([b for _, b in bounds], axis=0)
    return [
        _finished(*laid_out(drawing, width, tallest, (low, high)), drawing, width)
        for drawing in drawings
    ]


def _finished(
    page: Page, height: float, boxes: Sequence[Box], drawing: Drawing, width: float
) -> Picture:
    page.body += filter(None, map(_leader, page.wanted, boxes))  # below all labels
    page.body += map(_label, page.wanted, boxes)
    page.body += _corners(drawing, page, height)
    for k, note in enumerate(drawing.notes):
        at = complex(width / 2, height + 4 + _NOTE * (k + 0.6))
        page.body.append(_centred("n", at, note, 12.0))
    height += _NOTE * len(drawing.notes) + (8 if drawing.notes else 0)
    if drawing.key:
        middle = complex(width / 2, height + 14)
        page.body += svg_symbols.key(drawing.key, middle, width - 2 * _MARGIN)
        height += svg_symbols.KEY
    return Picture("".join(page.body), width, height, drawing.title)


def laid_out(
    drawing: Drawing, width: float, tallest: float, bounds: tuple[Array, Array] | None = None
) -> tuple[Page, float, list[Box]]:
    """(page, height, boxes): the page with everything drawn but the labels, its height, and the
    places of the labels.

    bounds: the lowest and highest coordinates of the view that the page holds; default: the
    drawing's own.
    """
    page, height = _fit(drawing, width, tallest, bounds or _bounds(drawing))
    for element in drawing.elements:
        _DRAW[type(element)](page, element)
    return page, height, page.crowd.settle(page.wanted)


def natural_scale(drawing: Drawing, width: float, tallest: float) -> float:
    """The scale in pixels per metre at which the drawing just fits."""
    return _natural(_bounds(drawing), width, tallest)


def _natural(bounds: tuple[Array, Array], width: float, tallest: float) -> float:
    span = bounds[1] - bounds[0]
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


def _fit(
    drawing: Drawing, width: float, tallest: float, bounds: tuple[Array, Array]
) -> tuple[Page, float]:
    low, high = bounds
    scale = drawing.scale or _natural(bounds, width, tallest)
    top = 18.0 if drawing.heading else 0.0
    inner = max(float(high[1] - low[1]) * scale + 2 * _MARGIN, 120.0)
    middle = (low + high) / 2
    shift = complex(width / 2 - scale * middle[0], top + inner / 2 + scale * middle[1])
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
    beyond = b, b - a if abs(b - a) > 1 else 1 - 1j
    near, across = (_along(a, b, side, e.beside or 0.5) for side in _sides(e.aside))
    anchors = [*near, *across, beyond] if e.beside else [beyond, near[0], across[0]]
    page.want(e, f"{e.role}-text", anchors)


def _beside(a: complex, b: complex, aside: float) -> tuple[complex, complex]:
    """The ends of a segment moved by some pixels to its left."""
    if not aside or a == b:
        return a, b
    left = -1j * aside * (b - a) / abs(b - a)
    return a + left, b + left


def _sides(aside: float) -> tuple[float, float]:
    """The sides to try for a label, the preferred first: 1 left, -1 right; something moved aside
    has its label on that side."""
    return (1.0, -1.0) if aside >= 0 else (-1.0, 1.0)


def _along(a: complex, b: complex, side: float, share: float) -> list[Anchor]:
    """Anchors for a label on one side of a segment, around a fraction of its length."""
    shares = (share, share + 0.15, share - 0.15)
    return [(a + k * (b - a), -1j * side * (b - a)) for k in shares]


def _dimension(page: Page, e: Dimension) -> None:
    ends = page.at(e.start), page.at(e.end)
    a, b = _beside(*ends, e.aside)
    page.body.append(svg_symbols.dimension(ends, a, b))
    for p, q in ((a, b), (ends[0], a), (ends[1], b)):
        page.crowd.keep_clear(p, q)
    page.want(e, "dimension-text", _along(a, b, _sides(e.aside)[0], 0.5))


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
    at, way = page.at(e.at), page.towards(e.direction)
    page.body.append(svg_symbols.MARKS[e.kind](at, e.size, way, e.role))
    page.crowd.keep_clear(at - 0.7 * e.size, at + 0.7 * e.size)
    page.around(e, "", e.size, 0.0, 2 * math.pi, ())
    if e.kind == "ground":
        for depth in (1.2, 2.0):
            foot, wide = at - depth * e.size * way, 2j * e.size * way
            page.crowd.keep_clear(foot - wide, foot + wide)


def _prism(page: Page, e: Prism) -> None:
    rings = svg_symbols.prism_rings(e, page.drawing.view)
    near, far = ([page.at(p) for p in ring] for ring in rings)
    outline = svg_symbols.hull(near + far)
    page.body.append(svg_symbols.prism(near, outline, e.far))
    for a, b in zip(outline, outline[1:] + outline[:1], strict=True):
        page.crowd.keep_clear(a, b)


def _cells(page: Page, e: Cells) -> None:
    page.body += svg_symbols.cells(e, page.at)


def _text(page: Page, e: Label) -> None:
    at, way = page.at(e.at), page.towards(e.direction, 1 - 1j)
    page.want(e, f"{e.role}-text", [(at, way), (at, -way)])


_DRAW = {
    Line: _line,
    Arrow: _arrow,
    Dimension: _dimension,
    Turn: _turn,
    Arc: _arc,
    Mark: _mark,
    Prism: _prism,
    Label: _text,
    Cells: _cells,
}
assert set(_DRAW) == set(Element.__args__)


def _tooltip(page: Page, e: Arrow | Turn) -> str:
    _, after = labelling.beside(e, page.drawing.labels)
    return marked_text.plain(e.label or e.name) + after


def _centred(css: str, at: complex, sentence: str, size: float) -> str:
    return svg_symbols.words(
        css, at, marked_text.marked(marked_text.sentence(sentence), size), "middle"
    )


def _label(wanted: Wanted, box: Box) -> str:
    left, _, right, bottom = box
    after = [marked_text.Run(wanted.after, "num")] if wanted.after else []
    shown = marked_text.marked([*marked_text.runs(wanted.text), *after])
    at = complex((left + right) / 2, bottom - RULE["below"])
    return svg_symbols.words(f"halo f {wanted.css}", at, shown, "middle")


def _leader(wanted: Wanted, box: Box) -> str:
    anchor = wanted.anchors[0][0]
    near = leader(anchor, box)
    return svg_symbols.line("leader", svg_symbols.path([anchor, near])) if near else ""


def _corners(drawing: Drawing, page: Page, height: float) -> list[str]:
    """The SVG of the drawing's corners: heading above; below, scale bars on the left and the
    world's axes on the right."""
    heading = escape(drawing.heading)
    out = [svg_symbols.words("name", 12 + 20j, heading)] if heading else []
    at = complex(14.0, height - 10.0)
    for metres, label, role in drawing.rulers:
        length = metres * page.scale
        out.append(svg_symbols.ruler(at, length, label, role))
        at += max(length, marked_text.width(label, 11)) + 26
    if drawing.compass:
        out += _compass(drawing.view, complex(page.crowd.width - 34.0, height - 26.0))
    return out


def _compass(view: View, at: complex) -> list[str]:
    """Small arrows along the world's axes."""
    out = []
    for name, axis in zip("xyz", np.eye(len(view.rows[0])), strict=False):
        way = 20.0 * view.on_page(axis)
        out.append(svg_symbols.arrow(at, at + way, name))
        beyond = at + way * (1.0 + 9.0 / max(abs(way), 6.0)) + 4j
        out.append(_centred("tick", beyond, name, 11.0))
    return out
