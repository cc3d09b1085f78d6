"""Checks of a figure: it is drawn from a model, and the expected elements are looked up in the
drawing's data."""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import UnknownNameError
from freebody.figures.drawing import Arc, Arrow, Line, places
from freebody.figures.figure import Figure
from freebody_notes.checks.calls import source
from freebody_notes.checks.relation import Related
from freebody_notes.figures.catalogue import notes_figure
from freebody_notes.item import Outcome

Facts = Callable[["Panel"], Mapping[str, Any]]


_BRACES = str.maketrans("", "", "{}")
"""Around indices of several letters, as figures name them."""


@dataclass(frozen=True)
class Panel:
    """The elements of a figure by name, in one of its panels or in any."""

    figure: Figure

    def start(self, name: str, panel: int | None = None) -> Array:
        """The position of an element: the starting point of an arrow or line."""
        return np.asarray(places(self.figure.named(name, panel))[0])

    def end(self, name: str, panel: int | None = None) -> Array:
        """The end point of an arrow or a line."""
        element = self.figure.named(name, panel)
        assert isinstance(element, Arrow | Line)
        return np.asarray(places(element)[-1])

    def span(self, name: str, panel: int | None = None) -> Array:
        """The vector from the start to the end of a drawn arrow or line."""
        return self.end(name, panel) - self.start(name, panel)

    def of(self, name: str, panel: int | None = None) -> Any:
        """The quantity that an arrow, a turn or an angle represents."""
        element: Any = self.figure.named(name, panel)
        found = element.value if hasattr(element, "value") else element.sweep
        return np.asarray(found) if isinstance(found, tuple) else found

    def direction(self, name: str, panel: int | None = None) -> float:
        """The direction (rad) from which a drawn angle is measured."""
        element = self.figure.named(name, panel)
        assert isinstance(element, Arc)
        return element.start

    def points(self, name: str, panel: int | None = None) -> Array:
        """All points of a drawn line."""
        return np.asarray(places(self.figure.named(name, panel)))

    def along(self, name: str, panel: int | None = None) -> float:
        """1 if an arrow points along the quantity it represents, -1 if against it."""
        shown, value = self.span(name, panel), self.of(name, panel)
        return round(float(shown @ value / (np.linalg.norm(shown) * np.linalg.norm(value))), 9)


@dataclass(frozen=True)
class Drawn:
    """Check of a relation between facts that are read from a drawing; needs: names of the elements
    required in each panel, given in the item."""

    number: str
    facts: Facts
    needs: tuple[tuple[str, ...], ...] = ()
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        lines = [f"figure = fb.notes_figure({self.number!r})", source(self.facts)]
        return "\n".join(lines)

    def run(self, form: str) -> Outcome:
        figure = notes_figure(self.number)
        try:
            for k, names in enumerate(self.needs):
                for name in names:
                    figure.named(name, k)
        except UnknownNameError as problem:
            return Outcome(False, (str(problem),))
        outcome = Related(lambda: self.facts(Panel(figure))).run(form)
        listed = [", ".join(names).translate(_BRACES) for names in self.needs]
        return Outcome(
            outcome.holds,
            (f"The drawing shows {'; '.join(listed)}.", *outcome.lines),
            outcome.example,
        )


@dataclass(frozen=True)
class Caption:
    """Check of a statement about a figure: the elements that it promises, listed in the item, must
    be in the figure."""

    number: str
    promises: Mapping[str, tuple[str, ...]] = field(default_factory=dict)
    bold: Collection[str] = ()

    def call(self, form: str) -> str:
        return f"fb.notes_figure({self.number!r})"

    def run(self, form: str) -> Outcome:
        figure = notes_figure(self.number)
        there = {element.name for drawing in figure.drawings for element in drawing.elements}
        lines, holds = [], True
        for words, names in self.promises.items():
            if words in form:
                missing = [name for name in names if name not in there]
                holds = holds and not missing
                found = f"not in the figure: {', '.join(missing)}" if missing else "in the figure"
                lines.append(f"“{words}”: {found}.")
        return Outcome(holds and bool(lines), tuple(lines))
