"""Figures: pictures that show themselves in a notebook and are saved; several drawings on one
sheet, which can be searched for elements."""

from __future__ import annotations

import os
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

from freebody.errors import FreebodyError
from freebody.figures.drawing import Drawing, Element, named
from freebody.figures.svg import Picture, natural_scale, picture
from freebody.lazy import cached_property
from freebody.outputs.display import Titled
from freebody.outputs.files import write
from freebody.outputs.pdf import pdf

WIDE, TALL = 400.0, 380.0
"""Size of one drawing on a sheet, pixels."""


class Pictured:
    """A base class for results with a picture, shown in notebooks and saved as SVG or PDF."""

    caller: str
    """The function that made it, for errors."""

    @property
    def picture(self) -> Picture:
        """The picture, all on one sheet."""
        raise NotImplementedError

    @property
    def svg(self) -> str:
        """SVG text that stands alone."""
        return self.picture.text()

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | os.PathLike[str]) -> Path:
        """The path of the .svg or .pdf file to which the picture is written.

        A PDF is printed by a Chromium, Chrome or Edge that is at hand, in light colours. Raises
        FreebodyError for another kind of file, or where there is no browser.
        """
        return save(self.picture, path, self.caller)


@dataclass(frozen=True, eq=False, repr=False)
class Figure(Titled, Pictured):
    """Drawings that belong together; shows itself in a notebook."""

    title: str
    drawings: tuple[Drawing, ...]
    columns: int = 2
    width: float = WIDE
    """Width of one drawing, pixels."""
    tallest: float = TALL
    caller: str = "a figure"
    """The function that made the figure, for errors."""
    level: float = 1.0
    """Height of the common edge on which drawings in a row stand: the lower one (1), where captions
    are, or the upper one (0)."""

    def _title(self) -> str:
        return f"Figure: {self.title}"

    @cached_property
    def picture(self) -> Picture:
        """All drawings of the figure on one sheet."""
        return sheet(self.pictures, self.title, self.columns, self.level)

    @property
    def pictures(self) -> list[Picture]:
        """Each drawing by itself, for pages that have no room for the sheet."""
        return [picture(drawing, self.width, self.tallest) for drawing in self.drawings]

    @property
    def drawing(self) -> Drawing:
        """The only drawing of the figure; raises an error where there are several."""
        if len(self.drawings) != 1:
            raise FreebodyError(
                f"{self.title}: it has {len(self.drawings)} drawings; take one of .drawings, or "
                f"name a body."
            )
        return self.drawings[0]

    def named(self, name: str, panel: int | None = None) -> Element:
        """The element of that name in the first drawing that has it, or in drawing `panel` (from
        0).

        Raises UnknownNameError, which lists the names.
        """
        searched = self.drawings if panel is None else (self.drawings[panel],)
        return named(searched, name, self.title)


def of_one(title: str, drawing: Drawing, caller: str) -> Figure:
    """A figure of a single drawing on a large sheet."""
    return Figure(title, (drawing,), 1, 560.0, 520.0, caller)


def sheet(pictures: Sequence[Picture], title: str, columns: int = 2, level: float = 1.0) -> Picture:
    """A picture of several pictures in rows, with columns as wide as the widest; level 1 aligns
    their lower edges, where captions are, 0 the upper ones."""
    if len(pictures) == 1:
        return Picture(pictures[0].body, pictures[0].width, pictures[0].height, title)
    body, y, wide = "", 0.0, max(one.width for one in pictures)
    for k in range(0, len(pictures), columns):
        row = pictures[k : k + columns]
        tall = max(p.height for p in row)
        for j, p in enumerate(row):
            at = f'x="{j * wide:g}" y="{y + level * (tall - p.height):g}"'
            body += p.text(css=False, place=at)
        y += tall
    return Picture(body, min(columns, len(pictures)) * wide, y, title)


def to_one_scale(
    drawings: Sequence[Drawing], wide: float = WIDE, tall: float = TALL,
    alike: Sequence[float] | None = None,
) -> None:  # fmt: skip
    """Give drawings the largest scale at which each of them fits its page; alike: for each drawing
    the length in metres that is drawn equally long in all (default 1)."""
    pairs = list(zip(drawings, alike or [1.0] * len(drawings), strict=True))
    lengths = [natural_scale(drawing, wide, tall) * one for drawing, one in pairs]
    for drawing, one in pairs:
        drawing.scale = min(lengths) / one


def save(shown: Picture, path: str | os.PathLike[str], what: str) -> Path:
    """The path of the .svg or .pdf file to which a picture is written; what: names it in errors."""
    target = picture_file(path, what)
    return write(target, _KINDS[target.suffix.lower()](shown))


def picture_file(path: str | os.PathLike[str], what: str) -> Path:
    """The path of a file that can hold a picture.

    Raises FreebodyError for one that is neither .svg nor .pdf; what: names the picture in it.
    """
    target = Path(path)
    if target.suffix.lower() not in _KINDS:
        raise FreebodyError(
            f"{what}: {target.name!r} is not an .svg or .pdf file; name one, such as 'fbd.svg'."
        )
    return target


def _on_paper(shown: Picture) -> bytes:
    """A PDF whose one page is as large as the picture."""
    size = f"{shown.width:g}px {shown.height:.0f}px"
    return pdf(
        f"<!doctype html><meta charset='utf-8'><style>@page{{size:{size};margin:0}}"
        f"body{{margin:0}}svg{{display:block}}</style>{shown.text()}"
    )


_KINDS: dict[str, Callable[[Picture], str | bytes]] = {".svg": Picture.text, ".pdf": _on_paper}
