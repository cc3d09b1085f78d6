"""Torques that hold a force at the tip, τ = Jᵀ F, with the weights and the motion where an answer
has these too (2.50)."""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cache

from freebody.expressions.quantities import kinds
from freebody.scalars.trig import Trig
from freebody_textbook.check.asked.load_names import VECTORS
from freebody_textbook.check.asked.quantity import (
    ActingLoads,
    AskedQuantity,
    Mistaken,
    QuantityTable,
)
from freebody_textbook.check.asked.right_equations import RightEquations

_SENSES = (
    "F is the force that the tip exerts on its surroundings.",
    "F is a force on the tip, from outside.",
)
_UNTURNED = "This is J F: torques follow from the transpose, τ = Jᵀ F, as velocities from v = J q̇."


def vectors(
    setting: RightEquations, single: Mapping[str, AskedQuantity]
) -> dict[str, QuantityTable]:
    """F, a column of the force; with its moment W."""
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
    """F = Jᵀ τ, a square J of the position taken for its inverse."""
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
    """The torque of a drive of a closed chain under a force from outside; rates alone tell no
    motion: they may be those of virtual work."""
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
    """The torque at a joint that holds the components of a load; besides: what the line tells of,
    as motion and weights, which then count too."""
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
        """J F or Jᵀ F."""
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
