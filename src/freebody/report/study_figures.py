"""Figures of a study by name, each as one picture that stands alone: for papers, slides and
sites."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

from freebody.errors import FreebodyError, UnknownNameError
from freebody.figures.figure import Pictured, sheet
from freebody.figures.moving_picture import moving_picture
from freebody.figures.svg import Picture
from freebody.outputs.display import Titled, counted
from freebody.report import page_figures
from freebody.report.page_figures import CaptionedDrawing

if TYPE_CHECKING:
    from freebody.report.study import Study


_COLUMNS = 3
_ROBOT = (460.0, 400.0)  # pixels


@dataclass(frozen=True, repr=False)
class StudyFigure(Titled, Pictured):
    """One figure of a study: its panels on a sheet."""

    name: str
    panels: tuple[Picture, ...]
    """The drawings by themselves."""
    titles: tuple[str, ...]
    """The names of the panels: joints, bodies or quantities."""
    captions: tuple[str, ...]
    """A sentence for each panel that has one."""
    caller = "study.figure"

    def _title(self) -> str:
        return f"Figure {self.name!r}: {counted(len(self.panels), 'panel')}"

    @property
    def picture(self) -> Picture:
        """All panels on one sheet, at most three side by side."""
        return sheet(self.panels, self.name, _COLUMNS, 0.0)


def _animation(study: Study) -> Iterable[CaptionedDrawing]:
    """The robot running through the motion in its own time."""
    path = None if study.tip is None else page_figures.path_of_tip(study)
    motion = study.motion
    drawing = moving_picture(study.model, motion.t, motion.q, path, *_ROBOT)
    seconds = f"{motion.duration:.3g} s"
    return [CaptionedDrawing(drawing, f"The motion of {seconds}, in its own time.")]


_FIGURES: dict[str, Callable[[Study], Iterable[CaptionedDrawing]]] = {
    "robot": lambda study: [page_figures.robot(study)],
    "animation": _animation,
    "free_bodies": lambda study: page_figures.free_bodies(study)[0],
    **{make.__name__: make for make in page_figures.PLOTS},
}
"""The figures of a study by name, and what draws them."""
NAMES = tuple(_FIGURES)


def study_figure(study: Study, name: str, only: str | Sequence[str] | None) -> StudyFigure:
    """The figure of that name; only: the titles of the panels that it has, default all."""
    if not isinstance(name, str) or name not in _FIGURES:
        raise UnknownNameError("figure", name, "a study", NAMES)
    drawn = list(_FIGURES[name](study))
    if not drawn:
        raise FreebodyError(
            f"study.figure: {study.model.name!r} has no figure {name!r}: there is nothing to draw."
        )
    if only is not None:
        wanted = (only,) if isinstance(only, str) else tuple(dict.fromkeys(only))
        if not wanted:
            raise FreebodyError("study.figure: only names no panel; leave it out for all of them.")
        titles = dict.fromkeys(one.title for one in drawn)
        for title in wanted:
            if title not in titles:
                raise UnknownNameError(
                    "panel", title, f"the figure {name!r}", dict.fromkeys(titles)
                )
        drawn = [one for title in wanted for one in drawn if one.title == title]
    return StudyFigure(
        name,
        tuple(one.picture for one in drawn),
        tuple(one.title for one in drawn),
        tuple(one.caption for one in drawn if one.caption),
    )
