"""A torque that was compiled by `fb.compile`: its inputs by name, those of the state and others."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.errors import FreebodyError, KindError, UnknownNameError, listed
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.formulas.inputs import INPUTS
from freebody.lazy import cached_property
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.simulation.driven_steps import STATE, law_inputs
from freebody.motion.simulation.motion_lanes import MotionLanes, some_of
from freebody.program import Program
from freebody.targets import Kernel, compile_program
from freebody.trees.controllers import not_negative
from freebody.trees.special_joints import refuse_passive


@dataclass(frozen=True, eq=False)
class CompiledTorque:
    """A law's program, and what it takes besides time and state, (..., *core) each, in its
    order."""

    model: Model
    law: Program
    more: tuple[Array, ...]

    @property
    def cores(self) -> tuple[int, ...]:
        """Of each further input the axes of its core."""
        return tuple(len(x.shape) for x in self.law.inputs if x.name not in STATE)

    @property
    def batches(self) -> dict[str, tuple[int, ...]]:
        """The leading shapes of the further inputs."""
        own = [x.name for x in self.law.inputs if x.name not in STATE]
        pairs = zip(self.more, self.cores, strict=True)
        shapes = [x.shape[: x.ndim - core] for x, core in pairs]
        return dict(zip((f"torque_inputs[{n!r}]" for n in own), shapes, strict=True))

    @cached_property
    def _kernel(self) -> Kernel:
        return compile_program(self.law)

    def __call__(self, t: Array, q: Array, qd: Array) -> Array:
        """tau (..., nv)."""
        state = {"t": t, "q": q, "qd": qd}
        found = self._kernel(*law_inputs(self.law, state, self.more))
        if self.model.passive and np.isfinite(found).all():
            refuse_passive("simulate", self.model, found)
        return np.broadcast_to(found, np.broadcast_shapes(found.shape, qd.shape))


def compiled_torque(
    model: Model, kernel: Kernel, given: Mapping[str, Any], name: str = "torque"
) -> CompiledTorque:
    """The torque of a kernel, its inputs checked; given: those besides t, q and qd, by name. name:
    of the argument, of which `torque` alone takes such inputs."""
    if not isinstance(given, Mapping):
        raise KindError("simulate", "torque_inputs", given, "a dict of names and values")
    law = kernel.program
    sizes = {"t": (), "q": (model.nq,), "qd": (model.nv,)}
    own = [x for x in law.inputs if x.name not in STATE]
    for x in law.inputs:
        if x.name in sizes and x.shape != sizes[x.name]:
            raise FreebodyError(
                f"simulate: the compiled {name} takes {x}, but of {model.name!r} {x.name} has "
                f"shape {sizes[x.name]}."
            )
    if [x.shape for x in law.outputs] != [(model.nv,)]:
        raise FreebodyError(
            f"simulate: the compiled {name} returns {listed(map(str, law.outputs))}; expected one "
            f"output of shape ({model.nv},)."
        )
    for name in given:
        if name not in [x.name for x in own]:
            raise UnknownNameError("input", name, "torque_inputs=", [x.name for x in own])
    lacking = [x.name for x in own if x.name not in given]
    if lacking:
        remedy = (
            f"give torque_inputs={{{lacking[0]!r}: …}}"
            if name == "torque"
            else "compile it with these numbers inside"
        )
        raise FreebodyError(
            f"simulate: the compiled {name} takes {listed(lacking)} besides t, q and qd: {remedy}."
        )
    more, gains = [], _gains(law)
    for x in own:
        array = as_floats("simulate", f"torque_inputs[{x.name!r}]", given[x.name])
        check_core("simulate", f"torque_inputs[{x.name!r}]", array, x.shape, "as it was compiled")
        refuse_not_finite("simulate", f"torque_inputs[{x.name!r}]", array, len(x.shape))
        if x.name in gains:
            rows = model.velocity_names if x.shape == (model.nv,) else range(*x.shape)
            not_negative("simulate", f"torque_inputs[{x.name!r}]", array, [*map(str, rows)])
        more.append(array)
    return CompiledTorque(model, law, tuple(more))


def _gains(law: Program) -> tuple[str, ...]:
    """What makes no sense below 0 among the inputs of a kernel that is one of `FORMULAS`: control
    laws refuse it there as where they are called; in a law of the user's own a name says
    nothing."""
    formula, names = FORMULAS.get(law.name), tuple(x.name for x in law.inputs)
    if formula is None or names != formula.inputs:
        return ()
    return tuple(name for name in names if INPUTS[name].positive is not None)


def one_lane(torque: CompiledTorque, lanes: MotionLanes, k: int) -> CompiledTorque:
    """With the further inputs of one motion."""
    pairs = zip(torque.more, torque.cores, strict=True)
    more = tuple(some_of(lanes.each(x, core), core, k) for x, core in pairs)
    return replace(torque, model=member_at(torque.model, lanes.index(k)), more=more)
