"""Equilibrium of each body, and the torques that hold an arm still against gravity and a force on its tip
(2.41-2.49)."""

from __future__ import annotations

from freebody.derivations.derivation import Derivation
from freebody.derivations.methods import loop_statics
from freebody.derivations.methods.equilibrium import Equilibrium
from freebody.derivations.methods.geometry import geometry
from freebody.derivations.methods.overview import overview
from freebody.derivations.methods.reactions import Reactions
from freebody.derivations.methods.setting import Setting


def derive(setting: Setting) -> Derivation:
    """The derivation; the setting is at rest. Of a closed chain: see `loop_statics`."""
    if setting.tree.loops:
        return loop_statics.derive(setting)
    reactions = Reactions(setting)
    work = Equilibrium(setting, reactions)
    tau = {i: reactions.motor(i) for i in setting.order}
    steps = [work.convention()] if setting.load else []
    steps += [*map(work.body, setting.order)]
    steps += [work.solved(i) for i in reversed(setting.order)]
    steps += [geometry(setting, inertias=False), work.result(tau)]
    if setting.load:
        steps.append(work.transpose())
    torques = tuple(tau[i] for i in setting.order)
    return Derivation(
        "statics", "Statics", setting.equations, tuple(steps), torques, *overview(setting, "statics")
    )
