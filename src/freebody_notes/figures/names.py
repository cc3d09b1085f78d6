"""Names by a pattern, for figures of the notes that name things differently from the model's
equations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from freebody.expressions.printed_names import GREEK
from freebody.figures.body_loads import Load
from freebody.figures.names import DrawingNames
from freebody.figures.skeleton import BodyPlace, End, Skeleton
from freebody.figures.snapshot import Snapshot
from freebody.figures.text import indexed

_DOTS = ("", "\u0307", "\u0308")


def between(before: str, n: str) -> str:
    """Subscript "before,n" of the force that body `before` exerts on body n."""
    return f"{before},{n}"


@dataclass(frozen=True)
class PatternNames(DrawingNames):
    """Names of a figure's parts by a pattern; `index` turns a body's number (0: the ground) into a
    subscript."""

    index: Callable[[int], str] = str
    letters: Callable[[int], str] | None = None
    """Letters of the joints; default: as in all drawings."""
    force: Callable[[str, str], str] = between
    letter: str = "f"
    """Letter of forces."""
    moment: str = ""
    """Letter of the moment at any joint, with the body's number; default: τ at turns in the plane,
    else n with two."""
    load: str = "f"
    """Letter of a force on the tip."""

    def on(self, symbol: str, n: int, prefix: str = "") -> str:
        return indexed(symbol, prefix + self.index(n))

    def coordinate(self, body: BodyPlace, order: int = 0) -> str:
        name = body.kind.coordinate or "theta"
        return self.on(GREEK.get(name, name) + _DOTS[order], body.number)

    def mass(self, n: int) -> str:
        return self.on("m", n)

    def inertia(self, n: int) -> str:
        return self.on("I", n)

    def axis(self, body: BodyPlace) -> str:
        return self.on(body.kind.axis_letter, body.number)

    def reach(self, body: BodyPlace, end: End, letter: str = "s") -> str:
        return self.on(letter, body.number)

    def length(self, body: BodyPlace, end: End) -> str:
        return self.on("l", body.number)

    def centre_length(self, body: BodyPlace) -> str:
        return self.on("l", body.number, "c")

    def acting(self, load: Load, body: BodyPlace) -> tuple[str, str]:
        n, kind = body.number, load.kind
        if load.role == "weight":
            return f"{self.mass(n)} g", ""
        if load.role == "external":
            return self.load, ""
        first, second = (
            (body.parent + 1, n) if load.role == "reaction" else (n, (load.joint or 0) + 1)
        )
        sign = "" if load.role == "reaction" else "−"
        between = self.force(self.index(first), self.index(second))
        if self.moment:
            moment = self.on(self.moment, second)
        else:
            moment = self.on("τ", second) if kind is not None and kind.turns else f"n_{{{between}}}"
        return f"{sign}{self.letter}_{{{between}}}", sign + moment

    def point(self, pose: Skeleton, n: int) -> str:
        return super().point(pose, n) if self.letters is None else self.letters(n)


def called(seen: Snapshot, **pattern: Any) -> Snapshot:
    """A snapshot with its parts renamed by a pattern: fields of `PatternNames`."""
    return replace(seen, names=PatternNames(seen.names.naming, **pattern))
