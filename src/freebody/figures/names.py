"""What things are called in a drawing: as `Naming` calls them in the equations, or by a pattern in
the notes' figures.

Joints are the points O, A, B, …, the tip is P.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

from freebody.derivations.expressions.expression import Symbol
from freebody.derivations.expressions.printed_names import GREEK, sym
from freebody.derivations.naming import TIP, Naming
from freebody.derivations.polynomials.symbols import RATE, SECOND
from freebody.figures.body_loads import Load
from freebody.figures.skeleton import BodyPlace, End
from freebody.figures.text import indexed, label
from freebody.model.model import Model

_DOTS = ("", "\u0307", "\u0308")
_ENDINGS = ("", RATE, SECOND)


def lettered(n: int) -> str:
    """The joint of body n from 1: O, A, B, … N, A′, B′, …"""
    return "O" if n == 1 else chr(ord("A") + (n - 2) % 14) + "′" * ((n - 2) // 14)


def numbered(n: int) -> str:
    """The number of a body."""
    return str(n)


def between(before: str, n: str) -> str:
    """Subscript of a force of body `before` on body n."""
    return f"{before},{n}"


@dataclass(frozen=True)
class Names:
    """Names by a pattern; `index` turns a body's number (0: the ground) into a subscript."""

    index: Callable[[int], str] = numbered
    point: Callable[[int], str] = lettered
    tip: str = TIP
    force: Callable[[str, str], str] = between
    letter: str = "f"
    """Of forces."""
    moment: str = ""
    """Of the moment at any joint, with the body's number; default: τ at turns in the plane, else n
    with two."""
    load: str = "f"
    """Of a force on the tip."""
    weights: bool = True
    """Whether weights are drawn: not where the accelerations contain gravity."""

    def on(self, symbol: str, n: int, prefix: str = "") -> str:
        """A symbol with the subscript of body n, if it has one."""
        return indexed(symbol, prefix + self.index(n))

    def coordinate(self, body: BodyPlace, order: int = 0) -> str:
        """The joint's coordinate or its rate; "" where it has none of its own."""
        name = body.kind.coordinate or "theta"
        return self.on(GREEK.get(name, name) + _DOTS[order], body.number)

    def mass(self, n: int) -> str:
        """Of body n."""
        return self.on("m", n)

    def inertia(self, n: int) -> str:
        """Of body n, about its centre of mass."""
        return self.on("I", n)

    def axis(self, body: BodyPlace) -> str:
        """The direction of a joint."""
        return self.on(body.kind.axis_letter, body.number)

    def reach(self, body: BodyPlace, end: End, letter: str = "s") -> str:
        """The vector from a joint to where something hangs."""
        return self.on(letter, body.number)

    def length(self, body: BodyPlace, end: End) -> str:
        """The same way's length; "" where it has no name."""
        return self.on("l", body.number)

    def centre_length(self, body: BodyPlace) -> str:
        """From a joint to the centre of mass."""
        return self.on("l", body.number, "c")

    def acting(self, load: Load, body: BodyPlace) -> tuple[str, str]:
        """Names of a force and its moment on a body."""
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


@dataclass(frozen=True)
class ModelNames(Names):
    """Names of one model, those of its equations."""

    naming: Naming | None = None

    @property
    def _own(self) -> Naming:
        assert self.naming is not None
        return self.naming

    def coordinate(self, body: BodyPlace, order: int = 0) -> str:
        name = self._own.coordinate(body.number)
        return label(sym(name + _ENDINGS[order])) if name else ""

    def mass(self, n: int) -> str:
        return label(self._own.mass(n))

    def inertia(self, n: int) -> str:
        return label(self._own.inertia(n))

    def axis(self, body: BodyPlace) -> str:
        return label(self._own.axis(body.number))

    def reach(self, body: BodyPlace, end: End, letter: str = "s") -> str:
        n = body.number
        name = self._own.to_tip(n) if end.child is None else self._own.reach(n, end.child + 1)
        return label(replace(name, letter=letter))

    def length(self, body: BodyPlace, end: End) -> str:
        child = None if end.child is None else end.child + 1
        return self._length(self._own.length(child, end.name), self.on("l", body.number))

    def centre_length(self, body: BodyPlace) -> str:
        return self._length(self._own.centre_length(body.number), self.on("l", body.number, "c"))

    def _length(self, name: Symbol | None, pattern: str) -> str:
        """The model's name; where it has none that of the pattern, if no other quantity has it."""
        if name is not None:
            return label(name)
        taken = {label(sym(x)) for x in self._own.model.parameters}
        return "" if pattern in taken else pattern

    def acting(self, load: Load, body: BodyPlace) -> tuple[str, str]:
        return load.name, load.moment_name


def names_of(model: Model, weights: bool = True) -> ModelNames:
    """The names in a model's drawings."""
    return ModelNames(naming=Naming(model), weights=weights)
