"""What is told and drawn of each body, by name: over polynomials, or over the scalars of a
program."""

from __future__ import annotations

from typing import Any

from freebody.derivations.methods.energies import Energies
from freebody.derivations.methods.reactions import SolvedReactions
from freebody.derivations.methods.setting import Setting
from freebody.spatial import transposed


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
    n, above = s.numbers[i], s.numbers[s.tree.bodies[i].parent]
    turning = {
        f"omega{n}": s.motion.w[i], f"omega{n}_d": s.motion.wd[i],
        f"{'M' if s.planar else 'n'}{n}": reactions.n[i],
    }  # fmt: skip
    found = {
        f"r{n}": s.world[i][1], f"rc{n}": s.centre_position(i), f"vc{n}": s.centre_velocity(i),
        f"vc{n}_d": s.centre_acceleration(i), f"sc{n}": s.centre(i),
        s.naming.force(above, n).name: reactions.f[i],
    }  # fmt: skip
    made: dict[str, Any] = {name: vector(s, v) for name, v in (found | turning).items()}
    if s.planar:
        made |= {name: made[name][0] for name in turning}
        made[f"I{n}"] = s.symbols.element(s.inertia(i))
    else:
        R = s.motion.joints[i][0]
        for name, matrix in (
            (f"R{n}", s.world[i][0]), (f"R{above}_{n}", transposed(R)), (f"R{n}_{above}", R),
        ):  # fmt: skip
            made[name] = tuple(vector(s, row) for row in matrix)
        made[f"I{n}"] = tuple(vector(s, row) for row in s.inertia(i))
        made[f"n{above}_{n}"] = made[f"n{n}"]
    made |= {f"m{n}": s.symbols.element(s.mass(i))}
    return made if s.follows(i) else made | {f"tau{s.index(i) + 1}": reactions.motor(i)}
