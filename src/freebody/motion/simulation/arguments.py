"""A simulation as data: its arguments, checked, and its progress."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, as_floats, is_count, refuse_not_finite
from freebody.errors import FreebodyError, UnknownNameError, shown, warn
from freebody.labels import is_labelled
from freebody.loops.equations import taken_at
from freebody.model.drives import LAWS
from freebody.model.losses import lossy_joints, require_lossless
from freebody.model.model import Model
from freebody.motion.friction import WIDTH, smooth_friction
from freebody.motion.simulation.first_order_system import FINEST
from freebody.motion.simulation.joint_contacts import JointContacts, joint_contacts
from freebody.motion.simulation.lanes import MotionLanes
from freebody.motion.simulation.torques import (
    CompiledTorque,
    TorqueInput,
    warn_of_tables,
)
from freebody.trees.public_calls import JointVector, vector

if TYPE_CHECKING:
    pass

TOLERANCE = 1e-10
_FRICTION = ("smooth", "dry")
_DRY = next(law.numbers[0] for law in LAWS.values() if law.signed)
_EVERY = 0.05  # s
Progress = Callable[[str, float], None]
"""A function that is called with a text and the part that is done (0 to 1)."""


@dataclass(frozen=True, eq=False)
class Simulation:
    """The arguments of `simulate`, as arrays of the right shapes.

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


def require_counts(**given: Any) -> None:
    """Refuse what is no whole number above 0, but for None."""
    for name, value in given.items():
        if value is not None and not is_count(value):
            raise FreebodyError(
                f"simulate: {name} is {shown(value)}, expected a whole number above 0."
            )


def require_sizes(
    step: float | None, tolerance: float | None, friction_width: float | None, max_step: float
) -> None:
    """Refuse steps, tolerances and widths that are not above 0."""
    above_zero("simulate", "friction_width", WIDTH if friction_width is None else friction_width)
    above_zero("simulate", "step", 1.0 if step is None else step, "seconds")
    above_zero("simulate", "tolerance", TOLERANCE if tolerance is None else tolerance)
    above_zero("simulate", "max_step", 1.0 if max_step == np.inf else max_step, "seconds")
    if tolerance is not None and tolerance < FINEST:
        raise FreebodyError(
            f"simulate: tolerance is {tolerance:g}, finer than the rounding of numbers lets any "
            f"motion be known; from about 1e-12 on it has a meaning."
        )


def require_friction(model: Model, friction: str, width: float | None) -> None:
    """Refuse a width of friction that is not there, or not smooth."""
    if width is None:
        return
    if friction == "dry":
        raise FreebodyError(
            "simulate: friction_width= is of friction='smooth'; dry friction has no width. Leave "
            "one of them out."
        )
    if not has_friction(model):
        raise FreebodyError(
            f"simulate: friction_width= is of {_DRY.what}, and no joint of {model.name!r} has "
            f"any: leave it out, or give a joint some (model.with_drive(joint, {_DRY.name}=…))."
        )


def has_friction(model: Model) -> bool:
    """Whether the friction of a drive of the model depends on the sign of a rate."""
    return smooth_friction(model)[1].acts or bool(lossy_joints(model.bodies))


def times_of(t: ArrayLike) -> Array:
    """The times t (T,), at least two, which increase."""
    times = as_floats("simulate", "t", t)
    if times.ndim != 1 or len(times) < 2:
        raise FreebodyError(f"simulate: t has shape {times.shape}, expected at least two times.")
    refuse_not_finite("simulate", "t", times, 0)
    if (np.diff(times) <= 0).any():
        raise FreebodyError("simulate: the times t must increase.")
    return times


def contacts_of(
    model: Model, friction: str, restitution: JointVector | float | None
) -> JointContacts | None:
    """Dry friction and stops, where there are any."""
    if friction not in _FRICTION:
        raise UnknownNameError("model of friction", friction, "simulate", _FRICTION)
    share = None
    if restitution is not None:
        share = restitution if is_labelled(restitution) else np.asarray(restitution)
        if isinstance(share, np.ndarray) and not share.ndim:
            share = np.full(model.nv, as_floats("simulate", "restitution", share))
        share = vector("simulate", model, "restitution", share)
        refuse_not_finite("simulate", "restitution", share, 1, model.velocity_names)
        if ((share < 0.0) | (share > 1.0)).any():
            bad = share[(share < 0.0) | (share > 1.0)].flat[0]
            raise FreebodyError(
                f"simulate: restitution is {bad:g}, expected from 0 (no rebound) to 1 (elastic)."
            )
    if friction == "smooth" and share is None:
        return None
    require_lossless(
        "simulate: friction='dry' and restitution=",
        model,
        " (friction='smooth' and method='implicit' are)",
    )
    if model.loops:
        raise FreebodyError(
            f"simulate: friction='dry' and restitution= need an open chain, and {model.name!r} has "
            f"loops: leave them out, and give stops as part of the torque."
        )
    contacts = joint_contacts(model, friction == "dry", share)
    if share is not None and not np.isfinite([contacts.lower, contacts.upper]).any():
        raise FreebodyError(
            f"simulate: restitution= is of stops at the limits of joints, and no joint of "
            f"{model.name!r} has one: leave it out, or give its joints limits."
        )
    return contacts


def simulation_of(
    model: Model,
    state: tuple[JointVector, JointVector],
    t: Array,
    torque: TorqueInput,
    forces: TorqueInput | None,
    wrenches: Mapping[str, tuple[str, Array]],
    **others: Any,
) -> Simulation:
    """The simulation of checked arguments; t (T,), and wrenches by frame with their names."""
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
    loads, lanes = {frame: w for frame, (_, w) in wrenches.items()}, MotionLanes(_shape(batches))
    return Simulation(model, q, qd, t, torque, forces, loads, lanes, **others)


def _warn_of_shared_table(name: str, table: Array) -> None:
    """Say that a table (T, nv) for T motions is one over time, the same for all of them."""
    times, nv = table.shape
    one = "one torque" if name == "torque" else "one row"
    warn(
        f"simulate: {name} {table.shape} is taken as a table over the {times} times, the "
        f"same for all motions; {one} for each is {(times, 1, nv)}, a table "
        f"{(1, *table.shape)} says the same as this without a warning.",
    )


def _shape(batches: Mapping[str, tuple[int, ...]]) -> tuple[int, ...]:
    """The batch shape of all arguments together, by their names."""
    try:
        return np.broadcast_shapes(*batches.values())
    except ValueError:
        shapes = ", ".join(f"{name} {batch}" for name, batch in batches.items())
        raise FreebodyError(
            f"simulate: the batch shapes do not broadcast together: {shapes}."
        ) from None


def paced(progress: Progress | None, text: str) -> Callable[[float], None]:
    """A function of the part that is done, quick to call often; of None one that does nothing."""
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
