"""The step of a freebody derivation at which an equation of the notes occurs."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import freebody as fb
from freebody_notes.item import Item
from freebody_textbook.derivation import Derivation, Step


@dataclass(frozen=True)
class Place:
    """A derivation step, and the call that makes the derivation."""

    call: str
    title: str
    step: Step


FIRST_KIND = 'fb.derive(fb.load("five_bar_rods"), "lagrange-first-kind")'
_CALLS = {
    1: ('fb.derive(fb.load("pendulum"), "newton-euler")',),
    2: ('fb.derive(fb.planar("RR"), "statics")', FIRST_KIND),
    3: ('fb.derive(fb.planar("RR"), "newton-euler")',),
    4: ('fb.derive(fb.planar("RR"), "recursive")',),
    5: ('fb.derive(fb.planar("RR"), "lagrange")', FIRST_KIND),
    6: ('fb.derive(fb.dh(rows, convention="modified"), "recursive")',),
}
ROWS = (
    {"d": 0.3, "m": "m1", "com": [0, 0, 0.1], "I": [0.01, 0, 0, 0.01, 0, 0.02]},
    {"a": 0.4, "alpha": 0.0, "m": "m2", "com": [0.2, 0, 0], "I": [0.01, 0, 0, 0.02, 0, 0.03]},
    {
        "joint": "P", "a": 0.3, "alpha": 1.5707963267948966, "m": "m3", "com": [0, 0, 0.1],
        "I": [0.01, 0, 0, 0.01, 0, 0.02],
    },
)  # fmt: skip
"""Two turning joints and a sliding one in modified frames: small enough to read."""


@cache
def _derivation(call: str) -> Derivation:
    return eval(call, {"fb": fb, "rows": ROWS})  # the calls are those above


def live_derivation(chapter: int) -> tuple[str, Derivation]:
    """The call of a chapter's first derivation, and the derivation."""
    call = _CALLS[chapter][0]
    return call, _derivation(call)


def place_of(item: Item) -> Place | None:
    """The step of the chapter's derivation that contains the item's equation; None if there is
    none."""
    kind, _, number = item.id.partition("-")
    if kind != "eq":
        return None
    for call in _CALLS.get(item.chapter, ()):
        derivation = _derivation(call)
        # of the sweeps over several bodies the last is the one that shows most
        for step in reversed(derivation.steps):
            if number in step.notes and step.equations:
                return Place(call, derivation.title, step)
    return None
