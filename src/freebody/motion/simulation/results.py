"""The results of a simulation: the states found, what an interrupted run hands over, and the
dataset with a table of its quantities."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.kernels.formulas import Option
from freebody.kernels.structural import Bound, fetch
from freebody.lazy import cached_property
from freebody.loops.closure_checks import gaps, scaled_rate, scaled_residual
from freebody.model.doubt_rules.aspects import DYNAMIC, RANGES
from freebody.model.doubts import attribute, doubts_used
from freebody.model.model import Model
from freebody.motion.ranges import angular
from freebody.motion.simulation.dry_friction_and_stops import JointContacts
from freebody.motion.simulation.first_order_system import (
    System,
    TorqueLaw,
    loads_over,
    row_at,
    system,
)
from freebody.motion.simulation.prepared_simulation import Simulation, TorqueInput, drive_of
from freebody.motion.smooth_friction import sticking_friction
from freebody.trees.special_joints import all_driven

if TYPE_CHECKING:
    import xarray as xr

_EACH = ("coordinate",)


@dataclass(eq=False)
class Simulated:
    """The states at the times t (R,), NaN where not yet computed: q (..., R, nq), qd (..., R, nv);
    and the settings used, for the result's attributes.

    It is filled while the simulation runs, so that it holds what there is when that ends early.
    tau (..., R, nv): the torques, where they are found on the way. given: else, of t, q (..., nq)
    and qd, all motions at one time.
    """

    t: Array
    q: Array
    qd: Array
    used: dict[str, Any]
    tau: Array | None = None
    given: TorqueLaw | None = None

    def torques(self) -> Array:
        """Torques of the drives (..., R, nv) at the times of the result."""
        if self.tau is not None or self.given is None:
            return np.full(self.qd.shape, np.nan) if self.tau is None else self.tau
        found = np.empty(self.qd.shape)
        for k, now in enumerate(self.t):
            found[..., k, :] = self.given(now, self.q[..., k, :], self.qd[..., k, :])
        return found

    def until_now(self) -> Simulated:
        """The states reduced to the times that some motion has reached."""
        reached = np.isfinite(self.qd).all(axis=-1).reshape(-1, len(self.t)).any(axis=0)
        last = int(np.flatnonzero(reached)[-1]) + 1 if reached.any() else 1
        tau = None if self.tau is None else self.tau[..., :last, :]
        states = self.q[..., :last, :], self.qd[..., :last, :]
        return Simulated(self.t[:last], *states, self.used, tau, self.given)


class SimulationStopped(FreebodyError):
    """Raised by `simulate` where a motion cannot go on or would never end; `result` is the dataset
    up to the last of the times t that was reached."""

    result: xr.Dataset | None = None


class SimulationInterrupted(KeyboardInterrupt):
    """Raised by Ctrl-C during `simulate`; `result` is the dataset of what was computed."""

    def __init__(self, result: xr.Dataset):
        last = float(result["time"].values[-1])
        super().__init__(
            f"simulate: interrupted; what was computed, up to t = {last:.6g} s, is the `result` of "
            f"this exception."
        )
        self.result = result


@dataclass(frozen=True)
class States:
    """The states with times t (R,) as the first axis, so that a family comes last: q (R, ..., nq),
    qd and tau (R, ..., nv)."""

    run: Simulation
    t: Array
    q: Array
    qd: Array
    tau: Array | None = None

    @property
    def model(self) -> Model:
        """The model whose states these are."""
        return self.run.model

    @cached_property
    def qdd(self) -> Array:
        """Accelerations (R, ..., nv) under all torques, forces and wrenches."""
        run = self.run
        axes = len(run.lanes.shape) + 2  # all: times come first, what is common to motions last
        loads = {n: np.expand_dims(w, [*range(axes - w.ndim)]) for n, w in run.wrenches.items()}
        whole = system(run.model, run.width, *loads_over(run.t, loads))
        assert self.tau is not None
        acting = self.tau if run.forces is None else self.tau + self._forces(run.forces, axes)
        if run.contacts is None:
            return whole.acceleration(self.t, self.q, self.qd, acting)
        return self._under_contact(whole, run.contacts, acting)

    def _forces(self, given: TorqueInput, axes: int) -> Array:
        """Forces (R, ..., nv) that act in addition to the torques."""
        if isinstance(given, np.ndarray):
            table = np.expand_dims(given, [*range(axes - given.ndim)])
            return row_at(self.t, self.run.t, table)
        shape = self.run.lanes.shape
        drive = drive_of(all_driven(self.model), self.run.t, given, shape, "forces")
        return np.stack([drive(*now) for now in zip(self.t, self.q, self.qd, strict=True)])

    def _under_contact(self, whole: System, contacts: JointContacts, tau: Array) -> Array:
        """Accelerations (R, ..., nv) with dry friction and stops."""
        forces = tau - whole.torque(self.t, self.q, self.qd, np.zeros(self.qd.shape))
        M = _kernel(self.model, "mass_matrix")(self.q)
        times, nv = len(self.q), self.model.nv
        own = contacts.lanes(self.run.lanes).repeated(times)
        states = self.q.reshape(-1, self.model.nq), self.qd.reshape(-1, nv)
        drag = np.zeros(self.qd.shape)
        if contacts.dry:
            drag = sticking_friction(contacts.robot)[1].drag(self.q, self.qd)
        rows = (M.reshape(-1, nv, nv), forces.reshape(-1, nv), drag.reshape(-1, nv))
        found = own.contact(*states, *rows)
        return found.qdd.reshape(self.qd.shape)


class RecordedQuantity(NamedTuple):
    """A quantity that `simulate` can record: its dimensions, unit and description, and the function
    that computes it from the states."""

    dims: tuple[str, ...]
    unit: str
    words: str
    of: Callable[[States], Any]
    of_torque: bool = False
    loops: bool = False


def _kernel(model: Model, name: str) -> Bound:
    """The kernel of a formula, for inputs that may hold NaN."""
    return fetch(model, (name,), Option())


RECORDED = {
    "q": RecordedQuantity(("position",), "rad|m|1", "position", lambda s: s.q),
    "qd": RecordedQuantity(_EACH, "rad/s|m/s", "rate", lambda s: s.qd),
    "qdd": RecordedQuantity(_EACH, "rad/s²|m/s²", "acceleration", lambda s: s.qdd, True),
    "tau": RecordedQuantity(_EACH, "N m|N", "torque or force of the drive", lambda s: s.tau, True),
    "kinetic_energy": RecordedQuantity(
        (),
        "J",
        "kinetic energy, rotors included",
        lambda s: _kernel(s.model, "kinetic_energy")(s.q, s.qd),
    ),
    "potential_energy": RecordedQuantity(
        (), "J", "of gravity and springs", lambda s: _kernel(s.model, "potential_energy")(s.q)
    ),
    "power": RecordedQuantity(
        _EACH, "W", "mechanical power of the drive", lambda s: s.tau * s.qd, True
    ),
    "loop_gap": RecordedQuantity(
        ("loop",),
        "m",
        "how far each loop is open",
        lambda s: gaps(s.model, scaled_residual(s.model, s.q)),
        loops=True,
    ),
    "loop_rate": RecordedQuantity(
        ("loop",),
        "m/s",
        "how fast each loop opens",
        lambda s: gaps(s.model, scaled_rate(s.model, s.q, s.qd)),
        loops=True,
    ),
}
"""The quantities of a result by their names."""


def dataset(run: Simulation, result: Simulated, names: Sequence[str]) -> xr.Dataset:
    """The result as a dataset over the batch's dimensions and `time`; NaN where a motion has not
    come that far."""
    import xarray as xr

    model, batch = run.model, run.lanes.shape
    axis = len(batch)
    found = [result.q, result.qd]
    if any(RECORDED[name].of_torque for name in names):
        found.append(result.torques())
    states = States(run, result.t, *(np.moveaxis(x, axis, 0) for x in found))
    dims = (*_batch_dims(model, batch), "time")
    variables = {}
    with np.errstate(invalid="ignore"):
        for name in names:
            record = RECORDED[name]
            values = np.moveaxis(np.asarray(record.of(states)), 0, axis)
            about = {"units": record.unit, "long_name": record.words}
            variables[name] = ((*dims, *record.dims), values, about)
    used = {d for name in names for d in RECORDED[name].dims}
    turns = angular(model)
    coordinates: dict[str, Any] = {
        "time": ("time", result.t, {"units": "s", "long_name": "time"}),
    }
    if "position" in used:
        coordinates["position"] = list(model.position_names)
    if "coordinate" in used:
        coordinates["coordinate"] = list(model.velocity_names)
        coordinates["unit"] = ("coordinate", np.where(turns, "rad", "m"))
        coordinates["effort_unit"] = ("coordinate", np.where(turns, "N m", "N"))
    if "loop" in used:
        coordinates["loop"] = [loop.name for loop in model.loops]
    aspects = DYNAMIC if run.contacts is None else (*DYNAMIC, RANGES)
    doubts = attribute(doubts_used(model, *aspects))
    return xr.Dataset(variables, coordinates, {"robot": model.name, **result.used, **doubts})


def _batch_dims(model: Model, batch: tuple[int, ...]) -> list[str]:
    """Names of the batch's dimensions: `member` of a family, `sample` of the others; numbered where
    there are several."""
    family = len(model.family)
    names = []
    for kind, count in (("sample", len(batch) - family), ("member", family)):
        names += [kind] if count == 1 else [f"{kind}{k}" for k in range(count)]
    return names
