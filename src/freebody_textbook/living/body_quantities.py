"""What is told and drawn of each body, by name: over polynomials, or over the scalars of a
program."""

from __future__ import annotations

from typing import Any

from freebody_textbook.methods.body_quantities import BODY_QUANTITIES, numbers
from freebody_textbook.methods.body_values import BodyValues
from freebody_textbook.methods.energies import Energies
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting


def body_quantities(s: Setting, reactions: SolvedReactions) -> dict[str, Any]:
    """By the names that derivations give them; vectors in the axes that are shown, but positions
    and gravity, which are in those of the world."""
    ring, energies = s.symbols.ring, Energies(s, s.motion)
    found: dict[str, Any] = {name: ring[name] for name in ring.names}
    found["gravity"] = vector(s, s.tree.gravity)
    found["V"], found["T"] = energies.total_potential, energies.rotors
    if s.tree.base:
        found["V0"] = energies.resting
    for i in s.order:
        found |= _of_body(s, reactions, i)
        if i in s.weighted:
            found["T"] = found["T"] + energies.kinetic(i)
            found |= {f"T{s.numbers[i]}": energies.kinetic(i)}
            found |= {f"V{s.numbers[i]}": energies.potential(i)}
    found["L"] = found["T"] - found["V"]
    if s.symbols.model.tip is not None and s.tip >= 0:
        found["r"] = vector(s, s.tip_position())
    if s.load:
        found["f"] = vector(s, s.load_components)
    return found


def vector(s: Setting, v: Any) -> tuple[Any, ...]:
    """Its components as scalars of the setting."""
    return tuple(map(s.symbols.element, v))


def _of_body(s: Setting, reactions: SolvedReactions, i: int) -> dict[str, Any]:
    b = BodyValues(s, i, reactions)
    above = s.numbers[s.tree.bodies[i].parent] if s.tree.bodies[i].parent >= 0 else 0
    at = numbers(b.n, above)
    rows = (x for x in BODY_QUANTITIES if x.shown and x.exists(b))
    made = {x.known.format(**at): x.value(b) for x in rows}
    made[s.naming.force(above, b.n).name] = b.vector(b.force)
    if not s.planar:
        made[f"n{above}_{b.n}"] = made[f"n{b.n}"]
        there, back = f"R{above}_{b.n}", f"R{b.n}_{above}"  # as lines print them: from, to
        made |= {there: made[back], back: made[there]}
    return made if s.follows(i) else made | {f"tau{s.index(i) + 1}": reactions.motor(i)}
