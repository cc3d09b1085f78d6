"""What answers call a force and a moment at the tip."""

from __future__ import annotations

from collections.abc import Collection, Iterator

from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.polynomials.symbols import symbols as symbols_of
from freebody.model.model import Model
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.right_equations import ALONG_SLIDE, RightEquations, slides_of

LOADS = {2: ("fx", "fy", "nz"), 3: ("fx", "fy", "fz", "nx", "ny", "nz")}
"""Force and moment at the tip, in the order of the Jacobian's rows."""
_POINT = "< ~P | ~p | ~E | ~e | ~t ~i ~p >"
_COMPONENT = LexemePattern(
    f"!-%latin < letter:< F | f > ~_? ~{{? {_POINT}? ~_? ~{{? | letter:< M | n | N > ~_? ~{{? >"
    " axis:~%axis"
)
_HAND = LexemePattern("!-%latin < a | o | s > ~_? ~{? ~%axis ~}? &? =")
"""An axis of the hand: n_x beside it is one too."""
_VECTOR = LexemePattern(f"!-%latin < < F | f > < ~_? ~{{? {_POINT} ~}}? >? | W > %ends !~_")
"""A force without its components: in an answer with the Jacobian."""
_FORCE = LexemePattern("!-%latin F %ends !~_")
"""A force on a slide."""
_GIVEN = LexemePattern("%fresh < F | f > ~_? ~{? ~%axis? ~}? &< &? = >")
"""A name of one's own."""
JOINT_FORCE = LexemePattern("< !-%latin f | %font { f } > ~_? ~{? < ~%digit | ~%low_digit >")
"""The force in a joint, f_12."""
MOMENT = LexemePattern("!-%latin < M | n | N > ~_? ~{? ~%axis")
"""A moment at the tip."""
SPELT = {"f": ("f", "F", "fP", "FP", "fE", "FE", "fe", "Fe", "ftip", "Ftip"), "n": ("n", "M", "N")}
VECTORS = tuple(name for name in SPELT["f"] if not name.endswith("tip"))


def named_in(model: Model, formulas: Lexemes) -> tuple[str, ...]:
    """Symbols for the load on the tip, where an answer has one."""
    names = LOADS[model.dim]
    if model.loops:
        return _of_loops(model, formulas)
    if model.tip is None or any(body.kind.quaternion for body in model.bodies):
        return ()
    letters = {x["letter"] for x in _COMPONENT.all(formulas)}
    beside = "J" in formulas.places or JOINT_FORCE.found_in(formulas)
    if letters <= ({"n"} if _HAND.found_in(formulas) else set()) and not (
        beside and _VECTOR.found_in(formulas)
    ):
        return ()
    slides = {f"f{x}" for x in symbols_of(model).coordinates}  # of a cart the drive's own force
    return () if set(names) & {*slides, *model.parameters} else names


def _of_loops(model: Model, formulas: Lexemes) -> tuple[str, ...]:
    """Of a mechanism in the plane: a force at its tip by components, or along its one slide."""
    taken = ALONG_SLIDE in model.parameters or _GIVEN.found_in(formulas)
    if model.dim != 2 or taken or "J" in formulas.places:
        return ()
    found = _COMPONENT.all(formulas)
    axes = {x["axis"] for x in found if x["letter"] in ("F", "f")} & {"x", "y"}
    if model.tip is not None and axes:
        names = tuple(f"f{x}" for x in sorted(axes))
        return () if {*names} & {*model.parameters} else names
    alone = len(slides_of(model)) == 1 and not {"F", "f"} & {*model.parameters}
    return (ALONG_SLIDE,) if alone and _FORCE.found_in(formulas) else ()


def symbols(setting: RightEquations, taken: Collection[str]) -> Iterator[tuple[str, Trig]]:
    """Spellings of the load's components, with their values; none that is taken."""
    for name in setting.loads:
        letter, axis = ("f", "") if name == ALONG_SLIDE else name
        for spelling in (f"{x}{axis}" for x in SPELT[letter]):
            if spelling not in taken:
                yield spelling, setting.ring[name]
