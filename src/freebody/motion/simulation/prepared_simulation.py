"""A simulation as data: its checked arguments, its motions as lanes, the torques and times in the
forms that integrators take, and its progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import prod
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.arrays import Array, above_zero, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, ShapeError, warn
from freebody.labels import is_labelled
from freebody.lazy import cached_property
from freebody.loops.closure_checks import taken_at
from freebody.model.families import member_at
from freebody.model.model import Model
from freebody.motion.simulation.dry_friction_and_stops import JointContacts
from freebody.motion.simulation.first_order_system import TorqueLaw, row_at
from freebody.motion.simulation.step_kernels import STATE, law_inputs
from freebody.program import Program
from freebody.targets import Kernel, compile_program
from freebody.trees.public_calls import JointVector, common_shape, vector
from freebody.trees.special_joints import refuse_passive

_EVERY = 0.05  # s
_MOST = 1_000_000  # sampling instants: beyond these a run would take hours
SAME = 1e-9  # of a sampling interval: instants this close to a time are that time

TorqueFunction = Callable[[float, Array, Array], ArrayLike]
TorqueArgument = ArrayLike | TorqueFunction | Kernel | None
Progress = Callable[[str, float], None]
"""A function that is called with a text and the part that is done (0 to 1)."""


@dataclass(frozen=True)
class MotionLanes:
    """The motions of a batch, numbered as lanes; shape: that of the batch."""

    shape: tuple[int, ...]

    @property
    def count(self) -> int:
        """Number of lanes, one for each motion."""
        return prod(self.shape)

    def each(self, array: Array, core: int) -> Array:
        """An array (..., *core) as (count, *core), one row for each lane; without leading axes, and
        so the same for all lanes, it is returned as it is. core: the number of core axes."""
        if array.ndim == core:
            return array
        own = array.shape[array.ndim - core :]
        return np.broadcast_to(array, (*self.shape, *own)).reshape(self.count, *own)

    def all(self, array: Array, core: int) -> Array:
        """An array (..., *core) copied to (count, *core), one row for each lane."""
        own = array.shape[array.ndim - core :]
        return np.array(np.broadcast_to(array, (*self.shape, *own))).reshape(self.count, *own)

    def index(self, lane: int) -> tuple[int, ...]:
        """The index in the batch of a lane."""
        return tuple(map(int, np.unravel_index(lane, self.shape))) if self.shape else ()


Some = int | slice | NDArray[np.intp]
"""A choice of lanes: one without its axis, or several."""


def some_of(array: Array, core: int, lanes: Some) -> Array:
    """The rows of some lanes of an array returned by `MotionLanes.each`."""
    return array if array.ndim == core else array[lanes]


@dataclass(frozen=True, eq=False)
class CompiledTorque:
    """A compiled law with its inputs besides time and state, (..., *core) each, in the law's
    order."""

    model: Model
    law: Program
    more: tuple[Array, ...]

    @property
    def cores(self) -> tuple[int, ...]:
        """The number of core axes of each further input."""
        return tuple(len(x.shape) for x in self.law.inputs if x.name not in STATE)

    @property
    def batches(self) -> dict[str, tuple[int, ...]]:
        """The batch shapes of the further inputs, by name."""
        own = [x.name for x in self.law.inputs if x.name not in STATE]
        pairs = zip(self.more, self.cores, strict=True)
        shapes = [x.shape[: x.ndim - core] for x, core in pairs]
        return dict(zip((f"torque_inputs[{n!r}]" for n in own), shapes, strict=True))

    @cached_property
    def _kernel(self) -> Kernel:
        return compile_program(self.law)

    def __call__(self, t: Array, q: Array, qd: Array) -> Array:
        """The torque tau (..., nv) at a time in given states."""
        state = {"t": t, "q": q, "qd": qd}
        found = self._kernel(*law_inputs(self.law, state, self.more))
        if self.model.passive and np.isfinite(found).all():
            refuse_passive("simulate", self.model, found)
        return np.broadcast_to(found, np.broadcast_shapes(found.shape, qd.shape))


TorqueInput = Array | TorqueFunction | CompiledTorque
"""A torque or force as it was given, checked: a table (..., T, nv), one row (..., 1, nv) that
counts at all times, a function, or one that was compiled."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """The arguments of `simulate` as arrays of the right shapes.

    q (..., nq), qd (..., nv), wrenches by frame (..., T or 1, six), contacts (..., nv): their
    leading axes and the model's family broadcast to `lanes`. torque, and forces besides: tables
    (..., T or 1, nv), Python functions, or compiled. contacts: dry friction, which the model then
    is without, and stops.
    """

    model: Model
    q: Array
    qd: Array
    t: Array
    torque: TorqueInput
    forces: TorqueInput | None
    wrenches: Mapping[str, Array]
    lanes: MotionLanes
    contacts: JointContacts | None
    tolerance: float
    width: float
    max_step: float
    step: float | None
    breakpoints: Array
    sample_time: float | None
    every: int
    threads: int | None
    tell: Callable[[float], None]

    @property
    def duration(self) -> float:
        """Duration of the simulation, s."""
        return float(self.t[-1] - self.t[0])


def simulation_of(
    model: Model,
    state: tuple[JointVector, JointVector],
    t: Array,
    torque: TorqueInput,
    forces: TorqueInput | None,
    wrenches: Mapping[str, tuple[str, Array]],
    **others: Any,
) -> Simulation:
    """The simulation that checked arguments describe; t (T,), and wrenches by frame with their
    names."""
    q, qd = (
        vector("simulate", model, name, value)
        for name, value in zip(("q", "qd"), state, strict=True)
    )
    for name, array in (("q", q), ("qd", qd)):
        refuse_not_finite("simulate", name, array, 1)
    if model.loops:
        model = taken_at(model, q)
    warn_of_tables(t, wrenches, q)
    batches = {"q": q.shape[:-1], "qd": qd.shape[:-1]}
    batches |= {name: w.shape[:-2] for name, w in wrenches.values()}
    for name, table in (("torque", torque), ("forces", forces)):
        if isinstance(table, np.ndarray):
            batches[name] = table.shape[:-2]
            if table.shape[:-1] == (len(t),) == batches["q"]:
                _warn_of_shared_table(name, table)
    if isinstance(torque, CompiledTorque):
        batches |= torque.batches
    if model.family:
        batches["model.family"] = model.family
    contacts = others["contacts"]
    if contacts is not None:
        batches["restitution"] = contacts.restitution.shape[:-1]
    loads = {frame: w for frame, (_, w) in wrenches.items()}
    lanes = MotionLanes(common_shape("simulate", batches))
    return Simulation(model, q, qd, t, torque, forces, loads, lanes, **others)


def warn_of_tables(t: Array, wrenches: Mapping[str, tuple[str, Array]], state: Array) -> None:
    """Warn where constant wrenches for many motions from one state may have been meant as a table
    over time."""
    for name, w in wrenches.values():
        if w.shape[:-1] == (len(t), 1) and state.ndim == 1:
            warn(
                f"simulate: {name} {(len(t), w.shape[-1])} is taken as a constant wrench for each "
                f"of {len(t)} motions; a table over the {len(t)} times t is given as "
                f"wrench_tables=."
            )


def _warn_of_shared_table(name: str, table: Array) -> None:
    """Warn that a table (T, nv) for T motions is taken as one table over time for all of them."""
    times, nv = table.shape
    one = "one torque" if name == "torque" else "one row"
    warn(
        f"simulate: {name} {table.shape} is taken as a table over the {times} times, the "
        f"same for all motions; {one} for each is {(times, 1, nv)}, a table "
        f"{(1, *table.shape)} says the same as this without a warning.",
    )


def drive_of(
    model: Model, t: Array, given: TorqueInput, batch: tuple[int, ...], name: str = "torque"
) -> TorqueLaw:
    """The torque or force of all motions of a batch as a function of time and state; a table is
    interpolated linearly. name: of the argument."""
    if isinstance(given, np.ndarray):
        whole = (*batch, model.nv)
        return lambda now, q, qd: np.broadcast_to(row_at(now, t, given), whole)
    return function_of(model, given, batch, name)


def function_of(
    model: Model,
    given: TorqueFunction | CompiledTorque,
    batch: tuple[int, ...],
    name: str = "torque",
) -> TorqueLaw:
    """The torque or force of all motions of a batch, or of one motion whose states come one by one;
    results of a Python function are checked and broadcast to (*batch, nv). name: of the
    argument."""
    if isinstance(given, CompiledTorque):
        return given
    whole, returned = (*batch, model.nv), f"what {name}(t, q, qd) returns"

    def drive(now: Array, q: Array, qd: Array) -> Array:
        if q.ndim > len(whole):
            return np.stack([drive(now, *state) for state in zip(q, qd, strict=True)])
        tau = given(float(now), q.copy(), qd.copy())  # which may work in place
        if is_labelled(tau):
            tau = vector("simulate", model, returned, tau)
        tau = np.array(as_floats("simulate", returned, tau))
        if tau.shape not in (whole, (model.nv,)):
            hint = "it is called with all motions at once" if batch else f"model {model.name!r}"
            raise ShapeError("simulate", returned, tau.shape, str(whole), hint)
        if model.passive and np.isfinite(tau).all():
            refuse_passive("simulate", model, tau)
        return tau if tau.shape == whole else np.broadcast_to(tau, whole)

    return drive


def one_lane(torque: CompiledTorque, lanes: MotionLanes, k: int) -> CompiledTorque:
    """The compiled torque reduced to the inputs of one motion."""
    pairs = zip(torque.more, torque.cores, strict=True)
    more = tuple(some_of(lanes.each(x, core), core, k) for x, core in pairs)
    return replace(torque, model=member_at(torque.model, lanes.index(k)), more=more)


def instants(start: float, end: float, sample_time: float) -> Array:
    """Times at which a controller is called."""
    above_zero("simulate", "sample_time", sample_time, "seconds")
    count = (end - start) / sample_time
    if count > _MOST:
        raise FreebodyError(
            f"simulate: sample_time is {sample_time:g} s, {count:.3g} instants in this run; "
            f"{_MOST} are the most."
        )
    return start + sample_time * np.arange(max(1, int(np.ceil(count - SAME))), dtype=float)


def merged(times: Array, others: Array, near: float) -> Array:
    """The times and the entries of `others` among them, sorted, without entries closer than `near`
    to one of `times`."""
    inside = others[(others > times[0]) & (others < times[-1])]
    k = np.searchsorted(times, inside)
    apart = np.minimum(inside - times[k - 1], times[k] - inside)
    return np.unique(np.concatenate([times, inside[apart > near]]))


def paced(progress: Progress | None, text: str) -> Callable[[float], None]:
    """A function that reports the fraction done under the given text, quick to call often; for None
    one that does nothing."""
    if progress is None:
        return lambda done: None
    last = -float("inf")

    def tell(done: float) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= _EVERY:
            last = now
            progress(text, min(1.0, done))

    return tell
