"""What a page's moving drawing takes from the figure above it: names as they are set there, first
values, the view, and the rule by which labels find their places."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from freebody.expressions.expression import Expression


@dataclass(frozen=True)
class PageFigure:
    """A figure as data."""

    bodies: Sequence[Mapping[str, str]]
    """Of each body formulas by what they name, such as C its centre of mass."""
    ends: Sequence[Sequence[int | str]]
    """Where each body reaches to: numbers of bodies that hang on it, and names of frames."""
    tip: str
    """The name of the tip."""
    points: Mapping[str, str]
    """Names of further frames that are points."""
    rods: Sequence[str]
    """Of each loop its rod's length, or ""."""
    start: Mapping[str, float]
    """First values of symbols."""
    view: tuple[float, float]
    """Azimuth and elevation of the viewer of a robot in space, degrees."""
    rule: Mapping[str, Any]
    """By which labels find their places."""
    formula: Callable[[Expression], str]
    """A name as a formula."""
    typeset: Callable[[str], str]
    """A formula as pieces of an SVG text."""


@dataclass(frozen=True)
class Labels:
    """The formulas that a page writes, each once, and their numbers."""

    figure: PageFigure
    numbers: dict[str, int] = field(default_factory=dict)

    def number(self, formula: str) -> int:
        """Of a formula; -1 where there is none."""
        return self.numbers.setdefault(formula, len(self.numbers)) if formula else -1

    def of(self, name: Expression, sign: int = 1) -> int:
        """The number of a name, with its sign."""
        return self.number("−" * (sign < 0) + self.figure.formula(name))

    def template(self) -> str:
        """All of them as HTML, for the page to copy."""
        texts = (f"<text>{self.figure.typeset(formula)}</text>" for formula in self.numbers)
        return f'<template id="names"><svg>{"".join(texts)}</svg></template>'
