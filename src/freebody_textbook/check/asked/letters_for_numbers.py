"""Letters that answers use for a model's numbers: those of the notes for each link of a planar arm,
one table for all rooms of `check`; g; m, I_x and l of a model with one body."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from typing import Any

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.quantities import units
from freebody.expressions.quantities.units import Unit
from freebody.model.bodies import Frame
from freebody.model.model import Model
from freebody.model.parameters import Parameter
from freebody.model.placement import AxisRotation, Placement, Shift
from freebody_textbook.methods.free_body_steps import thrusts_of


@dataclass(frozen=True)
class LinkSymbol:
    """A parameter or coordinate of link k, such as l_k."""

    letter: str
    unit: Unit
    also: tuple[str, ...] = ()
    """Other letters by which answers call it."""
    behind: tuple[str, ...] = ()
    """Spellings with something behind the number, l1c."""
    moves: bool = False
    """Whether it is a coordinate."""

    def spelt(self, k: int | str) -> Iterator[str]:
        """Spellings of the symbol with a link's number."""
        yield from (f"{letter}{k}" for letter in (self.letter, *self.also))
        yield from (form.format(k=k) for form in self.behind if k)


LINK_SYMBOLS = (
    LinkSymbol("l", units.LENGTH),
    LinkSymbol("lc", units.LENGTH, ("lC", "lG", "lg"), ("l{k}c",)),
    LinkSymbol("m", units.MASS),
    LinkSymbol("I", units.INERTIA, ("Ic", "IC", "IG", "Izz")),
    LinkSymbol("theta", units.NONE, ("q", "th"), moves=True),
    LinkSymbol("d", units.LENGTH, ("q",), moves=True),
)
PARAMETERS = tuple(x for x in LINK_SYMBOLS if not x.moves)
COORDINATES = {x.letter: x for x in LINK_SYMBOLS if x.moves}
BY_LETTER = {x.letter: x for x in LINK_SYMBOLS}


LETTERS = ("Ix", "Ixy", "Ixz", "Iy", "Iyz", "Iz")
"""Names of the entries of an inertia tensor, as it is stored."""
MASS, ARM, GRAVITY = "m", "l", "g"


_GRAVITY = LexemePattern(GRAVITY)
_LETTERED = LexemePattern("< I | J > < ~_ ~{? ~%axis | ~%axis{1,2} !~%small_letter >")


def as_written(model: Model, formulas: Lexemes, own: Collection[str] = ()) -> Model:
    """The model with symbols in place of numbers for which the answer has letters; own: names that
    the answer defines itself."""
    lettered = model.dim == 3 and _LETTERED.found_in(formulas)
    model = with_letters(model) if lettered else model
    size, taken = model.gravity_size, {*model.parameters, *own}
    if not isinstance(size, float) or GRAVITY in taken or not _GRAVITY.found_in(formulas):
        return model
    return replace(model, gravity_size=Parameter(GRAVITY, size))


def with_letters(model: Model) -> Model:
    """The model with symbols m, Ix, Iy, Iz for the numbers of its only body with mass, and l for
    the common distance of the thrusts; the values are kept."""
    own = [k for k, body in enumerate(model.bodies) if body.inertias]
    if len(own) != 1 or len(model.bodies[own[0]].inertias) != 1:
        return model
    taken = set(model.parameters)

    def letter(name: str, x: Any) -> Any:
        return Parameter(name, x) if isinstance(x, float) and x and name not in taken else x

    body = model.bodies[own[0]]
    (part,) = body.inertias
    tensor = tuple(map(letter, LETTERS, part.inertia.tensor))
    inertia = replace(part.inertia, mass=letter(MASS, part.inertia.mass), tensor=tensor)
    bodies = list(model.bodies)
    bodies[own[0]] = replace(body, inertias=(replace(part, inertia=inertia),))
    return replace(model, bodies=tuple(bodies), frames=_with_one_arm(model, taken))


def _with_one_arm(model: Model, taken: Collection[str]) -> tuple[Frame, ...]:
    """The model's frames, with the symbol l for the common distance of those along x or y at which
    thrusts act."""
    pushing = set(thrusts_of(model).values())
    shifts = {frame: _shift_of(frame) for frame in pushing}
    distances = {math.hypot(*by) for by in shifts.values() if by is not None}
    if ARM in taken or None in shifts.values() or len(distances) != 1:
        return model.frames
    arm = Parameter(ARM, distances.pop())

    def placed(frame: Frame) -> Frame:
        by = shifts.get(frame)
        if by is None:
            return frame
        angle = math.atan2(by[1], by[0])
        steps = (AxisRotation("z", angle), Shift((arm, 0.0, 0.0)), AxisRotation("z", -angle))
        return replace(frame, placement=Placement(steps))

    return tuple(map(placed, model.frames))


def _shift_of(frame: Frame) -> tuple[float, ...] | None:
    """Position of a frame on the x or y axis of its body; None if it is elsewhere or rotated."""
    steps = frame.placement.steps
    if len(steps) != 1 or not isinstance(steps[0], Shift):
        return None
    by = tuple(x for x in steps[0].by if isinstance(x, float))
    along = len(by) == 3 and by[2] == 0.0 and (by[0] == 0.0) != (by[1] == 0.0)
    return by if along else None
