"""Names that other robots have a meaning for, and what to write instead."""

from __future__ import annotations

from freebody.expressions.grammar.words import DOT
from freebody.model.model import Model
from freebody_textbook.check.asked.load_names import SPELT

_FORCES = frozenset(x + axis for x in SPELT["f"] for axis in ("", "x", "y", "z"))
_FORCE = (
    "{name} may be a force from outside, which is read of closed chains in the plane, as F_x and "
    "F_y at their tip or as F along their one slide without drive, or the force in a joint: that "
    "of body 1 on body 2 is f_12, the force of a loop λ_1."
)
_OF_TIP = frozenset(("x", "y", "z", "r", "J", "detJ", "vx", "vy", "vz", "ax", "ay", "az", "rP"))
_TIP = (
    "{model} has no tip, of which {name} would be: name one of its frames in its file, tip = "
    '"…"; the centre of mass of body 1 is r_c1, with the components x_c1 and y_c1.'
)


def advice(model: Model, name: str) -> str:
    """What to write instead of a name in plain spelling, or nothing."""
    plain = name.strip(DOT).rstrip("'")
    shown = plain if len(plain) < 2 or plain[0] in "dJ" else f"{plain[0]}_{plain[1:]}"
    if model.loops and plain.rstrip("0123456789") in _FORCES:
        return _FORCE.format(name=shown)
    if model.tip is None and plain in _OF_TIP:
        return _TIP.format(model=repr(model.name), name=shown)
    return ""
