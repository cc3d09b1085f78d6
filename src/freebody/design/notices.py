"""Sentences on what a choice of motors cannot mend: what has no motor of its own, joints that
follow others beyond their own limits, and noise of measured motions."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from freebody.any_chain.effort_limits import followers
from freebody.design.duty_cycle import DutyCycle
from freebody.errors import listed
from freebody.model.model import Model
from freebody.motion.files.measured_motions import loudest
from freebody.motion.ranges import CLOSE, angular
from freebody.outputs.number_text import compared


def without_motor(model: Model, where: str) -> tuple[str, ...]:
    """A sentence on joints of several coordinates, such as a free base, which have no motor in
    reality; where: in what result, such as "this study"."""
    free = [b.joint.name for b in model.bodies if b.kind.nv > 1 and not b.joint.passive]
    if not free:
        return ()
    joint, has, its = ("Joint", "has", "its") if len(free) == 1 else ("Joints", "have", "their")
    return (
        f"{joint} {listed(map(repr, free))} {has} no motor of {its} own: {its} torques and forces "
        f"in {where} are what something else has to exert to produce the motion.",
    )


def unmended(model: Model, cycles: Sequence[DutyCycle]) -> tuple[str, ...]:
    """Sentences on what no motor and gear of a joint mends over duty cycles: what holds a base that
    is free, and loads beyond the own limits of joints that follow others."""
    return (*without_motor(model, "these loads"), *_beyond(model, cycles))


def noise_notices(model: Model, cycles: Sequence[DutyCycle]) -> tuple[str, ...]:
    """Sentences on the noise of measured motions in duty cycles, which counts as torque."""
    noise = loudest(model, (x.motion for cycle in cycles for x in cycle.segments))
    return () if noise is None else (noise.counted,)


def _beyond(model: Model, cycles: Sequence[DutyCycle]) -> Iterator[str]:
    own = followers(model)
    if own is None:
        return
    largest = np.zeros(len(own.names))
    for segment in (segment for cycle in cycles for segment in cycle.segments):
        loaded = followers(segment.carried_by(model))
        if loaded is not None:
            q, qd, qdd, wrenches, _ = segment.states()
            torques = loaded.torques(q, qd, qdd, wrenches)
            largest = np.maximum(largest, np.abs(torques).max(axis=0))
    turns = angular(own.freed)[own.columns]
    for name, size, limit, turning in zip(own.names, largest, own.limits, turns, strict=True):
        if size > limit * (1.0 + CLOSE):
            what, unit = ("torque", "N m") if turning else ("force", "N")
            reached, most = compared(size, limit)
            yield (
                f"The {what} that reaches {name}, which follows another joint, is {reached} "
                f"{unit}, {100.0 * size / limit:.4g} % of its own limit of {most} {unit}, "
                f"without the mass of any drive: no choice of motors mends that."
            )
