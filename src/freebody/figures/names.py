"""Names in a drawing, equal to those that `Naming` gives in equations. Joints are the points O, A,
B, …, the tip is P."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import count, islice

import numpy as np

from freebody.expressions.expression import Symbol
from freebody.expressions.naming import TIP, Naming
from freebody.expressions.polynomials.symbols import RATE, SECOND
from freebody.expressions.printed_names import sym
from freebody.figures.body_loads import Load
from freebody.figures.drawing import SAME
from freebody.figures.skeleton import BodyPlace, End, Skeleton
from freebody.figures.text import indexed, label

_ENDINGS = ("", RATE, SECOND)


@dataclass(frozen=True)
class DrawingNames:
    """Names of a model's parts, as drawings print them."""

    naming: Naming
    weights: bool = True
    """Whether weights are drawn: not where the accelerations contain gravity."""
    tip: str = TIP

    def on(self, symbol: str, n: int, prefix: str = "") -> str:
        """A symbol with the number of body n as subscript, behind a prefix."""
        return indexed(symbol, f"{prefix}{n}")

    def coordinate(self, body: BodyPlace, order: int = 0) -> str:
        """The name of a joint's coordinate, or of its rate of a given order; "" where it has no
        coordinate of its own."""
        name = self.naming.coordinate(body.number)
        return label(self.naming.letters(sym(name + _ENDINGS[order]))) if name else ""

    def mass(self, n: int) -> str:
        """Name of the mass of body n."""
        return label(self.naming.mass(n))

    def inertia(self, n: int) -> str:
        """The inertia of body n, about its centre of mass."""
        return label(self.naming.inertia(n))

    def axis(self, body: BodyPlace) -> str:
        """The name of a joint's axis or direction of sliding."""
        return label(self.naming.axis(body.number))

    def reach(self, body: BodyPlace, end: End, letter: str = "s") -> str:
        """The name of the vector from a body's joint to one of its ends: a child's joint or the
        tip."""
        n = body.number
        name = self.naming.to_tip(n) if end.child is None else self.naming.reach(n, end.child + 1)
        return label(replace(name, letter=letter))

    def length(self, body: BodyPlace, end: End) -> str:
        """The name of the length of the vector from a body's joint to an end; "" where it has
        none."""
        child = None if end.child is None else end.child + 1
        return self._length(self.naming.length(child, end.name), self.on("l", body.number))

    def on_the_ground(self, body: BodyPlace) -> str:
        """The length from the origin to a body's joint; "" where the model has no name for it."""
        name = self.naming.length(body.number)
        return label(name) if name is not None else ""

    def rod(self, loop: int) -> str:
        """The length of the rod that closes a loop; "" where the model has no name for it."""
        name = self.naming.rod(loop)
        return label(name) if name is not None else ""

    def centre_length(self, body: BodyPlace) -> str:
        """The distance from a joint to the centre of mass."""
        return self._length(self.naming.centre_length(body.number), self.on("l", body.number, "c"))

    def _length(self, name: Symbol | None, pattern: str) -> str:
        """The model's name of a length; else the pattern's, unless another quantity has it already;
        else ""."""
        taken = {label(sym(x)) for x in self.naming.model.parameters}
        return label(name) if name is not None else "" if pattern in taken else pattern

    def acting(self, load: Load, body: BodyPlace) -> tuple[str, str]:
        """The names of a force and its moment on a body."""
        return load.name, load.moment_name

    def point(self, pose: Skeleton, n: int) -> str:
        """The letter of joint n: its own name where that is a capital letter, else the next letter
        that nothing else in the model has.

        O is kept for the origin, so that letters start with A where joint 1 is elsewhere.
        """
        model = self.naming.model
        given = {k: b.joint.name for k, b in enumerate(model.bodies, 1) if is_letter(b.joint.name)}
        if n in given:
            return given[n]
        taken = {*given.values(), *filter(is_letter, model.frame_names)}
        at_origin = float(np.linalg.norm(pose.bodies[0].origin)) < SAME
        free = (name for name in _letters(1 if at_origin else 2) if name not in taken)
        return next(islice(free, n - 1 - sum(k < n for k in given), None))


def is_letter(name: str) -> bool:
    """Whether a name is a single capital letter, as names of points are."""
    return len(name) == 1 and name.isupper()


def _letters(first: int) -> Iterator[str]:
    """O, A, B, … N, A′, B′, … from the first."""
    for n in count(first):
        yield "O" if n == 1 else chr(ord("A") + (n - 2) % 14) + "′" * ((n - 2) // 14)
