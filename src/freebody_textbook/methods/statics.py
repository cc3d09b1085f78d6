"""Equilibrium of each body, and the torques that hold an arm still against gravity and a force on
its tip (2.41-2.49)."""

from __future__ import annotations

from collections.abc import Iterator

from freebody_textbook.derivation import Meaning
from freebody_textbook.methods import glossary, loop_statics
from freebody_textbook.methods.body_quantities import meanings
from freebody_textbook.methods.coupled_joints import shared_motors
from freebody_textbook.methods.equilibrium import Equilibrium
from freebody_textbook.methods.geometry import geometry
from freebody_textbook.methods.method import Method, Worked
from freebody_textbook.methods.reactions import SolvedReactions
from freebody_textbook.methods.setting import Setting
from freebody_textbook.methods.step_reasons import Efforts


def work_out(setting: Setting) -> Worked:
    """The steps; the setting is at rest. Of a closed chain: see `loop_statics`."""
    if setting.tree.loops:
        return loop_statics.work_out(setting)
    reactions = SolvedReactions(setting)
    work = Equilibrium(setting, reactions)
    tau = {i: reactions.motor(i) for i in setting.leaders}
    steps = [work.convention()] if setting.load else []
    steps += [*map(work.body, setting.order)]
    steps += [work.solved(i) for i in reversed(setting.order)]
    steps += [
        *shared_motors(setting, reactions.drives),
        geometry(setting, inertias=False),
        work.result(tau),
    ]
    if setting.load:
        steps.append(work.transpose())
    torques = tuple(tau.values())
    sought = f"Sought: {Efforts.of(setting).holding} the arm at rest."
    return Worked(tuple(steps), torques, _symbols(setting), sought=sought)


def _symbols(s: Setting) -> Iterator[Meaning]:
    yield from glossary.vectors(s)
    yield from meanings(s, "f{h}{n}")
    yield from glossary.joint_moments(s)


METHOD = Method(
    "statics",
    "Statics",
    "equilibrium of each body at rest, with a force on the tip",
    "lecture notes, section 2.4",
    work_out,
    closed=(2,),
    elsewhere="fb.static_torque and fb.reactions",
    at_rest=True,
)
