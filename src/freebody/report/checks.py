"""Checks of a study: quantities computed in two ways that must agree."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import TYPE_CHECKING

import numpy as np

from freebody.arrays import Array
from freebody.errors import SingularError
from freebody.loops import dynamics as closed
from freebody.loops.assembly import assemble
from freebody.loops.equations import gaps, scaled_residual
from freebody.loops.rates import loop_velocity
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import length
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.ranges import ranges
from freebody.motion.simulation.simulate import simulate
from freebody.report.results import Check, Replay
from freebody.report.variables import PARTS
from freebody.trees import dynamics
from freebody.trees.newton_euler_residuals import balance
from freebody.trees.passive_joints import all_driven
from freebody.trees.states import difference

if TYPE_CHECKING:
    import xarray as xr

_STRETCH = 0.4, 0.5  # of the duration: errors of a longer simulation grow too far


def checks(
    model: Model, motion: Motion, data: xr.Dataset, replay: Replay | None
) -> tuple[Check, ...]:
    """All checks of a study."""
    found = [_parts(data), _energy(data), *_bodies(model, motion, data)]
    found += _closed(model, motion) if model.loops else _along_axes(model, data)
    forward = _forward(model, motion, data)
    if forward is not None:
        found.append(forward)
    if replay is not None:
        found.append(_replayed(replay))
    return tuple(_with_slack(model, found)) if model.loops else tuple(found)


def _with_slack(model: Model, found: Iterable[Check]) -> Iterator[Check]:
    """Bars of a closed chain whose numbers are rounded so far that its redundant equations
    contradict each other."""
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
    """A check; NaN does not pass."""
    return Check(name, float(value), float(bar), bool(value <= bar), text)


def relative(difference: Array, reference: Array) -> float:
    """Largest difference over largest reference; 0 where both vanish."""
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
    total = data["kinetic_energy"].values + data["potential_energy"].values
    turned_over = max(
        np.ptp(total),
        np.ptp(data["kinetic_energy"].values),
        np.ptp(data["potential_energy"].values),
    )
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
    """How well the motion keeps the loops closed, and whether the torques of a stretch of it
    simulate back to it."""
    gap = gaps(model, scaled_residual(model, motion.q)).max()
    start, end = (
        motion.t[0] + _STRETCH[0] * motion.duration,
        motion.t[0] + _STRETCH[1] * motion.duration,
    )
    q, qd, _ = motion.at(start)
    q = assemble(model, q)
    back = simulate(
        model,
        q,
        loop_velocity(model, q, qd),
        [start, end],
        lambda t, *_: closed.torques(model, *motion.at(t)),
    )
    miss = difference(model, motion.at(end)[0], back["q"].values[-1]) / ranges(model).width
    return [
        check(
            "loops",
            gap / length(model),
            1e-9,
            "Largest gap of a loop along the motion, relative to the robot's length.",
        ),
        check(
            "simulation",
            np.abs(miss).max(),
            1e-6,
            f"Where the torques drive the model from t = {start:.3g} s to {end:.3g} s: deviation "
            f"from the motion, relative to the joint range.",
        ),
    ]


def _along_axes(model: Model, data: xr.Dataset) -> list[Check]:
    """S·w of joints of one coordinate with rotor, friction and spring, against tau."""
    tau = data["tau"].values
    along = data["tau_friction"].values + data["tau_springs"].values + data["tau_rotors"].values
    counted = np.ones(model.nv, dtype=bool)
    force, moment = data["reaction_force_child"].values, data["reaction_moment_child"].values
    for k, (body, at, i) in enumerate(
        zip(model.bodies, model.coordinates, model.tree.body_of, strict=True)
    ):
        columns = model.tree.bodies[i].columns
        if (
            len(columns) != body.kind.nv
        ):  # a chain of several primitives: its first ones have reactions of their own
            counted[list(at.v)] = False
            continue
        for (w, v), coordinate in zip(columns, at.v, strict=True):
            share = moment[:, k] @ np.array(w) + force[:, k] @ np.array(v)
            along[:, coordinate] = along[:, coordinate] + at.ratio * share
    if not counted.any():
        return []
    text = (
        "Reactions along the axes, with friction, springs and rotors, compared with the "
        "torques, relative to the largest torque."
    )
    return [
        check(
            "reactions along the axes",
            relative((along - tau)[:, counted], tau[:, counted]),
            1e-10,
            text,
        )
    ]


def _forward(model: Model, motion: Motion, data: xr.Dataset) -> Check | None:
    """Forward dynamics of the torques against the accelerations; None where the mass matrix is
    singular."""
    try:
        back = dynamics.forward_dynamics(all_driven(model), motion.q, motion.qd, data["tau"].values)
    except SingularError:
        return None
    M = dynamics.mass_matrix(model, motion.q)
    condition = float(np.linalg.cond(M).max())
    scale = np.abs(np.linalg.solve(M, np.abs(data["tau"].values)[..., None])).max()
    return check(
        "forward dynamics",
        relative(back - motion.qdd, np.array([max(scale, np.abs(motion.qdd).max())])),
        max(1e-10, 1e3 * np.finfo(float).eps * condition),
        f"Accelerations computed from the torques compared with those of the motion; the allowed "
        f"value depends on cond M = "
        f"{condition:.3g}.",
    )


def _replayed(replay: Replay) -> Check:
    run = replay.misses[~np.isnan(replay.misses)]
    return check(
        "replay",
        run.max(),
        1e-6,
        f"Where the torques drive the model in {len(run)} piece{'' if len(run) == 1 else 's'}: "
        f"deviation from the reference, relative to the joint range.",
    )
