"""Checks of a study: quantities computed in two ways that must agree."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from freebody.any_chain.dynamics import forward_dynamics
from freebody.any_chain.reactions import balance
from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.loops import forces as closed
from freebody.loops.assembly import assemble
from freebody.loops.equations import gaps, scaled_residual
from freebody.loops.rates import loop_velocity
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import length
from freebody.model.model import Model
from freebody.motion.friction import strut_torque
from freebody.motion.motion import Motion
from freebody.motion.ranges import ranges
from freebody.motion.simulation.simulate import simulate
from freebody.outputs.display import counted
from freebody.report.results import Check, Replay
from freebody.report.variables import PARTS
from freebody.trees.dynamics import mass_matrix
from freebody.trees.special_joints import all_driven
from freebody.trees.states import difference

if TYPE_CHECKING:
    import xarray as xr

_STRETCH = 0.4, 0.5  # of the duration: errors of a longer simulation grow too far


def checks(
    model: Model, motion: Motion, data: xr.Dataset, replay: Replay | None
) -> tuple[Check, ...]:
    """All checks of a study, computed."""
    found = [_parts(data), _energy(data), *_bodies(model, motion, data)]
    found += _closed(model, motion) if model.loops else _along_axes(model, data)
    forward = _forward(model, motion, data)
    if forward is not None:
        found.append(forward)
    if replay is not None:
        found.append(_replayed(replay))
    return tuple(_with_slack(model, found)) if model.loops else tuple(found)


def _with_slack(model: Model, found: Iterable[Check]) -> Iterator[Check]:
    """The checks, with allowed values raised for a closed chain whose rounded numbers make its
    redundant equations contradict each other."""
    slack = redundancy(model).slack
    for each in found:
        if each.passed or slack <= each.bar:
            yield each
        else:
            text = (
                f"{each.text} The allowed value takes account of the rounding of the robot's "
                f"numbers (see mobility)."
            )
            yield check(each.name, each.value, slack, text)


def check(name: str, value: float, bar: float, text: str) -> Check:
    """A check that a value is at most `bar`; NaN does not pass."""
    return Check(name, float(value), float(bar), bool(value <= bar), text)


def relative(difference: Array, reference: Array) -> float:
    """The largest difference divided by the largest reference; 0 where both vanish."""
    size = float(np.abs(reference).max(initial=0.0))
    off = float(np.abs(difference).max(initial=0.0))
    return off / size if size else off


def _parts(data: xr.Dataset) -> Check:
    parts = sum(data[part].values for part in PARTS)
    tau = data["tau"].values
    size = np.max([np.abs(data[part].values).max() for part in PARTS])
    return check(
        "equation of motion",
        relative(parts - tau, np.array([size])),
        1e-10,
        "M q̈ + C q̇ + g + friction + springs + rotors compared with the torque of the recursive "
        "Newton-Euler algorithm, relative to the largest part.",
    )


def _energy(data: xr.Dataset) -> Check:
    kinetic, potential = data["kinetic_energy"].values, data["potential_energy"].values
    turned_over = max(map(np.ptp, (kinetic, potential, kinetic + potential)))
    return check(
        "energy balance",
        relative(data["energy_residual"].values, np.array([turned_over])),
        1e-8,
        "Work of the drives less friction losses compared with the gain in energy, relative to "
        "the energy exchanged.",
    )


def _bodies(model: Model, motion: Motion, data: xr.Dataset) -> list[Check]:
    wrenches = np.concatenate(
        [data["reaction_force"].values, data["reaction_moment"].values], axis=-1
    )
    found = balance(model, motion.q, motion.qd, motion.qdd, wrenches, {})
    how = "accelerations from the poses differentiated twice, not from the recursion"
    rows = (
        ("forces", found.force, found.largest_force, "Joint reactions and weight compared with "
         f"mass times acceleration of every body; {how}; relative to the largest force."),
        ("moments", found.moment, found.largest_moment, "The same for moments and the rate of "
         f"change of angular momentum; {how}; relative to the largest moment."),
    )  # fmt: skip
    return [
        check(f"{what} on each body", relative(off, np.array([largest])), 1e-10, text)
        for what, off, largest, text in rows
    ]


def _closed(model: Model, motion: Motion) -> list[Check]:
    """Checks of closed chains: how well the motion keeps the loops closed, and whether the torques
    of a part of it, simulated, reproduce it."""
    gap = gaps(model, scaled_residual(model, motion.q)).max() / length(model)
    start, end = (motion.t[0] + part * motion.duration for part in _STRETCH)
    q, qd, _ = motion.at(start)
    q = assemble(model, q)

    def torque(t: float, *_: Array) -> Array:
        return closed.torques(model, *motion.at(t))

    back = simulate(model, q, loop_velocity(model, q, qd), [start, end], torque)
    miss = difference(model, motion.at(end)[0], back["q"].values[-1]) / ranges(model).width
    closure = "Largest gap of a loop along the motion, relative to the robot's length."
    course = (
        f"Where the torques drive the model from t = {start:.3g} s to {end:.3g} s: deviation from "
        f"the motion, relative to the joint range."
    )
    return [
        check("loops", gap, 1e-9, closure),
        check("simulation", np.abs(miss).max(), 1e-6, course),
    ]


def _along_axes(model: Model, data: xr.Dataset) -> list[Check]:
    """Checks of the component S·w of each joint's reaction, with rotor, friction and spring,
    against tau, for joints of one coordinate."""
    tau = data["tau"].values
    along = data["tau_friction"].values + data["tau_springs"].values + data["tau_rotors"].values
    if model.struts:
        along -= strut_torque(model, data["q"].values, data["qd"].values)
    single = np.ones(model.nv, dtype=bool)
    force, moment = data["reaction_force_child"].values, data["reaction_moment_child"].values
    bodies = zip(model.bodies, model.coordinates, model.tree.body_of, strict=True)
    for k, (body, at, i) in enumerate(bodies):
        columns = model.tree.bodies[i].columns
        if (
            len(columns) != body.kind.nv
        ):  # a chain: its first primitives have reactions of their own
            single[list(at.v)] = False
            continue
        for (w, v), coordinate in zip(columns, at.v, strict=True):
            share = moment[:, k] @ np.array(w) + force[:, k] @ np.array(v)
            along[:, coordinate] = along[:, coordinate] + at.ratio * share
    if not single.any():
        return []
    text = (
        "Reactions along the axes, with friction, springs and rotors, compared with the "
        "torques, relative to the largest torque."
    )
    off = relative((along - tau)[:, single], tau[:, single])
    return [check("reactions along the axes", off, 1e-10, text)]


def _forward(model: Model, motion: Motion, data: xr.Dataset) -> Check | None:
    """A check of forward dynamics under the torques against the accelerations; None where the mass
    matrix is singular."""
    try:
        back = forward_dynamics(all_driven(model), motion.q, motion.qd, data["tau"].values)
    except SingularError:
        return None
    M = mass_matrix(model, motion.q)
    condition = float(np.linalg.cond(M).max())
    scale = np.abs(np.linalg.solve(M, np.abs(data["tau"].values)[..., None])).max()
    return check(
        "forward dynamics",
        relative(back - motion.qdd, np.array([max(scale, np.abs(motion.qdd).max())])),
        max(1e-10, 1e3 * np.finfo(float).eps * condition),
        f"Accelerations computed from the torques compared with those of the motion; the allowed "
        f"value depends on cond M = {condition:.3g}.",
    )


def _replayed(replay: Replay) -> Check:
    run = replay.misses[~np.isnan(replay.misses)]
    text = (
        f"Where the torques drive the model in {counted(len(run), 'piece')}: deviation from the "
        f"reference, relative to the joint range."
    )
    return check("replay", run.max(), 1e-6, text)
