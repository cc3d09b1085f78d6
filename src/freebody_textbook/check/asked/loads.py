"""A force and a moment at the tip: their names in answers, and the torques in equilibrium with
them, τ = Jᵀ F; with weights and motion if the answer has these (2.50)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache

from freebody.expressions.grammar.atoms import numbered
from freebody.expressions.grammar.lexemes import Lexemes
from freebody.expressions.grammar.patterns import LexemePattern
from freebody.expressions.grammar.words import DOT
from freebody.expressions.polynomials.symbols import symbols as symbols_of
from freebody.expressions.quantities import kinds
from freebody.model.model import Model
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.quantity import (
    ActingLoads,
    AskedQuantity,
    Mistaken,
    QuantityTable,
)
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
"""Pattern of the force on a slide."""
_GIVEN = LexemePattern("%fresh < F | f > ~_? ~{? ~%axis? ~}? &< &? = >")
"""Pattern of a name of the user's own for a force."""
JOINT_FORCE = LexemePattern("< !-%latin f | %font { f } > ~_? ~{? < ~%digit | ~%low_digit >")
"""The force in a joint, f_12."""
MOMENT = LexemePattern("!-%latin < M | n | N > ~_? ~{? ~%axis")
"""Pattern of a moment at the tip."""
SPELT = {"f": ("f", "F", "fP", "FP", "fE", "FE", "fe", "Fe", "ftip", "Ftip"), "n": ("n", "M", "N")}
VECTORS = tuple(name for name in SPELT["f"] if not name.endswith("tip"))


def named_in(model: Model, formulas: Lexemes) -> tuple[str, ...]:
    """Symbols for the load on the tip, if the answer contains one."""
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
    """Symbols of an external force on a planar closed chain: components at its tip, or a force
    along its only slide."""
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
    """Spellings of the load's components, with the polynomial of each, except names that are
    taken."""
    for name in setting.loads:
        letter, axis = ("f", "") if name == ALONG_SLIDE else name
        for spelling in (f"{x}{axis}" for x in SPELT[letter]):
            if spelling not in taken:
                yield spelling, setting.ring[name]


_FORCES = frozenset(x + axis for x in SPELT["f"] for axis in ("", "x", "y", "z"))
_FORCE_WORDS = (
    "{name} may be a force from outside, which is read of closed chains in the plane, as F_x and "
    "F_y at their tip or as F along their one slide without drive, or the force in a joint: that "
    "of body 1 on body 2 is f_12, the force of a loop λ_1."
)
_OF_TIP = frozenset(("x", "y", "z", "r", "J", "detJ", "vx", "vy", "vz", "ax", "ay", "az", "rP"))
_TIP = (
    "{model} has no tip, of which {name} would be: name one of its frames in its file, tip = "
    '"…"; the centre of mass of body 1 is r_c1, with the components x_c1 and y_c1.'
)


def instead_of(model: Model, name: str) -> str:
    """An error hint on what to write instead of a name; "" if there is none."""
    plain = name.strip(DOT).rstrip("'")
    shown = plain if len(plain) < 2 or plain[0] in "dJ" else f"{plain[0]}_{plain[1:]}"
    if model.loops and numbered(plain)[0] in _FORCES:
        return _FORCE_WORDS.format(name=shown)
    if model.tip is None and plain in _OF_TIP:
        return _TIP.format(model=repr(model.name), name=shown)
    return ""


_SENSES = (
    "F is the force that the tip exerts on its surroundings.",
    "F is a force on the tip, from outside.",
)
_UNTURNED = "This is J F: torques follow from the transpose, τ = Jᵀ F, as velocities from v = J q̇."


def vectors(
    setting: RightEquations, single: Mapping[str, AskedQuantity]
) -> dict[str, QuantityTable]:
    """The load as vectors: F, the force; W, force and moment."""
    ring = setting.ring

    def component(name: str) -> AskedQuantity:
        return AskedQuantity(
            kinds.LOAD,
            (),
            lambda: ring[name],
            axis=name[1],
            words="the load",
            thoughts=tuple(_of_transpose(setting, single, name)),
            note=_SENSES[0],
            also=((_SENSES[1], lambda: -ring[name]),),
        )

    rows = [[component(name)] for name in setting.loads]
    force = rows[: len(setting.force_at_tip)]
    names = [(x, force) for x in VECTORS] + [("W", rows)]
    return dict(names) if rows else {}


def _of_transpose(
    setting: RightEquations, single: Mapping[str, AskedQuantity], name: str
) -> Iterator[Mistaken]:
    """The mistake F = Jᵀ τ, which uses the transpose of a square Jacobian instead of its inverse
    transpose."""
    force = setting.force_at_tip
    n = range(1, len(force) + 1)
    if name not in force or len(setting.symbols.coordinates) != len(force):
        return

    def value() -> Trig:
        def entry(i: int, j: int) -> Trig:
            return single[f"J{i}{j}"].polynomial()

        k, total = force.index(name) + 1, setting.zero
        for i in n:
            for j in n:
                total = total + entry(i, k) * (setting.ring[force[j - 1]] * entry(j, i))
        return total

    yield "This is Jᵀ τ: torques follow from forces by τ = Jᵀ F, so F = J⁻ᵀ τ.", value


def held_by_loops(
    setting: RightEquations, target: AskedQuantity, besides: Collection[str]
) -> AskedQuantity:
    """The torque of a closed chain's drive under an external force; rates alone do not mean motion,
    as they occur in virtual work."""
    own = target.index[0] - 1
    acting: ActingLoads = "load"
    if "motion" in besides:
        acting = "motion"
    elif "weight" in besides:
        acting = "weight"
    weighs = acting == "load" and setting.order.gravity is not None
    return replace(
        target,
        kind=kinds.HELD,
        compute=lambda: setting.held(acting)[own],
        note="The links' weights are left out." if weighs else "",
        words=f"the torque or force at {target.joint} that holds the load",
        acting=acting,
    )


def held(
    setting: RightEquations,
    single: Mapping[str, AskedQuantity],
    target: AskedQuantity,
    load: Collection[str],
    besides: Collection[str],
) -> AskedQuantity:
    """The torque of a joint in equilibrium with a load at the tip; besides: effects in the line,
    such as motion and weights, that are included."""
    (i,) = target.index
    names = [name for name in setting.loads if name in load]
    has_motion = not {"motion", "rate"}.isdisjoint(besides)
    has_weight = "weight" in besides

    @cache
    def gravity() -> Trig:
        return setting.element(setting.all_of("g")[i - 1])

    @cache
    def base() -> Trig:
        if has_motion:
            return target.polynomial()
        return gravity() if has_weight else setting.zero

    def product(entry: str) -> Trig:
        """An entry of J F or Jᵀ F, for the load F."""
        total = setting.zero
        for name in names:
            k = setting.loads.index(name) + 1
            total = total + single[entry.format(k=k, i=i)].polynomial() * setting.ring[name]
        return total

    weighs = not gravity().is_zero
    note = " The links' weights are left out." if weighs and not (has_weight or has_motion) else ""
    if len(names) == 1:
        note = f" It has no other component than {names[0][1]}.{note}"
    thoughts: list[Mistaken] = []
    if f"J{i}{len(setting.loads)}" in single or f"J{i}{len(names)}" in single:
        for sign in (1, -1):
            thoughts.append((_UNTURNED, lambda sign=sign: base() + product("J{i}{k}") * sign))
    return replace(
        target,
        kind=kinds.LOAD,
        compute=lambda: base() + product("J{k}{i}"),
        note=_SENSES[0] + note,
        also=((_SENSES[1] + note, lambda: base() - product("J{k}{i}")),),
        words=f"the torque or force at {target.joint} that holds the load",
        thoughts=tuple(thoughts),
    )
