"""The result of a simulation as a dataset: which quantities there are, and how they follow from the
states."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.formulas import Option
from freebody.kernels.options import several
from freebody.kernels.structural import Bound, fetch
from freebody.lazy import cached_property
from freebody.loops.equations import gaps, scaled_rate, scaled_residual
from freebody.model.doubts import DYNAMIC, RANGES, attribute, doubts_used
from freebody.model.model import Model
from freebody.motion.ranges import angular
from freebody.motion.simulation.first_order_system import System, loads_over, row_at, system
from freebody.motion.simulation.joint_contacts import JointContacts
from freebody.motion.simulation.simulation import Simulated, Simulation
from freebody.motion.simulation.torques import Given, drive_of
from freebody.trees.special_joints import all_driven

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class States:
    """Times first, t (R,), so that a family comes last: q (R, ..., nq), qd and tau (R, ..., nv)."""

    asked: Simulation
    t: Array
    q: Array
    qd: Array
    tau: Array | None = None

    @property
    def model(self) -> Model:
        """Whose states they are."""
        return self.asked.model

    @cached_property
    def qdd(self) -> Array:
        """Accelerations (R, ..., nv)."""
        asked = self.asked
        axes = len(asked.lanes.shape) + 2  # all: times come first, what is common to motions last
        loads = {n: np.expand_dims(w, [*range(axes - w.ndim)]) for n, w in asked.wrenches.items()}
        whole = system(asked.model, asked.width, *loads_over(asked.t, loads))
        assert self.tau is not None
        acting = self.tau if asked.forces is None else self.tau + self._forces(asked.forces, axes)
        if asked.contacts is None:
            return whole.acceleration(self.t, self.q, self.qd, acting)
        return self._under_contact(whole, asked.contacts, acting)

    def _forces(self, given: Given, axes: int) -> Array:
        """Those besides the torques (R, ..., nv)."""
        if isinstance(given, np.ndarray):
            table = np.expand_dims(given, [*range(axes - given.ndim)])
            return row_at(self.t, self.asked.t, table)
        shape = self.asked.lanes.shape
        drive = drive_of(all_driven(self.model), self.asked.t, given, shape, "forces")
        return np.stack([drive(*now) for now in zip(self.t, self.q, self.qd, strict=True)])

    def _under_contact(self, whole: System, contacts: JointContacts, tau: Array) -> Array:
        """Those with dry friction and stops."""
        forces = tau - whole.torque(self.t, self.q, self.qd, np.zeros(self.qd.shape))
        M = _kernel(self.model, "mass_matrix")(self.q)
        times, nv = len(self.q), self.model.nv
        own = contacts.lanes(self.asked.lanes).repeated(times)
        states = self.q.reshape(-1, self.model.nq), self.qd.reshape(-1, nv)
        found = own.contact(*states, M.reshape(-1, nv, nv), forces.reshape(-1, nv))
        return found.qdd.reshape(self.qd.shape)


class RecordedQuantity(NamedTuple):
    """Its dimensions besides batch and time, unit, words, and how it follows from the states."""

    dims: tuple[str, ...]
    unit: str
    words: str
    of: Callable[[States], Any]
    of_torque: bool = False
    loops: bool = False


def _kernel(model: Model, name: str) -> Bound:
    """Which lets NaN through."""
    return fetch(model, (name,), Option())


_EACH = ("coordinate",)
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
"""All quantities by name."""


def recorded(model: Model, names: Sequence[str] | str | None) -> tuple[str, ...]:
    """Names of the quantities that are wanted; None: all that the model has."""
    known = [name for name, quantity in RECORDED.items() if model.loops or not quantity.loops]
    if names is None:
        return tuple(known)
    listed = several("simulate", "record=", names)
    for name in listed:
        if name not in known:
            raise UnknownNameError("quantity", name, "record=", known)
    if not listed or len(set(listed)) < len(listed):
        raise FreebodyError("simulate: record= names at least one quantity, and each once.")
    return listed


def dataset(asked: Simulation, result: Simulated, names: Sequence[str]) -> xr.Dataset:
    """Over the batch's dimensions and `time`; NaN where a motion has not come that far."""
    import xarray as xr

    model, batch = asked.model, asked.lanes.shape
    axis = len(batch)
    found = [result.q, result.qd]
    if any(RECORDED[name].of_torque for name in names):
        found.append(result.torques())
    states = States(asked, result.t, *(np.moveaxis(x, axis, 0) for x in found))
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
    aspects = DYNAMIC if asked.contacts is None else (*DYNAMIC, RANGES)
    doubts = attribute(doubts_used(model, *aspects))
    return xr.Dataset(variables, coordinates, {"robot": model.name, **result.used, **doubts})


def _batch_dims(model: Model, batch: tuple[int, ...]) -> list[str]:
    """Of a family `member`, of what else the batch has `sample`; numbered where there are
    several."""
    family = len(model.family)
    names = []
    for kind, count in (("sample", len(batch) - family), ("member", family)):
        names += [kind] if count == 1 else [f"{kind}{k}" for k in range(count)]
    return names
