"""`payload_map`: the largest mass that an arm holds at rest, posture by posture."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.elementary import Scalar, absolute, less, where
from freebody.errors import FreebodyError
from freebody.kernels.scalar_formulas import formula
from freebody.labels import aligned
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable
from freebody.program import Argument, trace
from freebody.spatial import dot, of_dimension, times, transposed
from freebody.targets import Kernel, compile_program
from freebody.trees.public_calls import Vector, finite_vector
from freebody.values import ByValue

_UNLIMITED = 1e30
"""What stands for no bound inside a kernel, whose numbers are finite."""


@dataclass(frozen=True, eq=False, repr=False)
class PayloadMap(Tabled, ByValue):
    """The largest mass at a point of an arm that its joints hold at rest, at each posture (...).

    mass: (...), kg; 0 where a joint is overloaded without any, infinite where none limits it.
    joint: (...), index of the joint that limits it, -1 without one. overloaded: (...), whether that
    joint cannot even hold the arm. joint_names: (nv,). frame: where the mass is.
    """

    mass: Array
    joint: np.ndarray
    overloaded: np.ndarray
    joint_names: tuple[str, ...]
    frame: str

    def _title(self) -> str:
        count = self.mass.size
        if not count:
            return f"PayloadMap: no postures; frame {self.frame!r}"
        return (
            f"PayloadMap: {count} postures, {self.mass.min():.4g} to {self.mass.max():.4g} kg at "
            f"frame {self.frame!r}"
        )

    def _table(self) -> TextTable:
        rows = []
        for k, name in enumerate(self.joint_names):
            mass = self.mass[self.joint == k]
            if mass.size:
                rows.append((name, str(mass.size), f"{mass.min():.4g}", f"{mass.max():.4g}"))
        notes = []
        if self.overloaded.any():
            notes.append(f"{int(self.overloaded.sum())} postures overload a joint without payload.")
        return TextTable(("limiting joint", "postures", "least (kg)", "largest (kg)"), rows, notes)


def payload_map(
    model: Model,
    q: Vector,
    frame: str | None = None,
    *,
    effort: Vector | None = None,
    point: Vector | None = None,
) -> PayloadMap:
    """The largest mass that an arm holds at rest at each posture, and the joint that limits it.

    q: (..., nq), such as `fb.random_state(model, seed, 10**6)[0]`. frame: name, default the tip.
    effort: (nv,), the largest torques and forces, N m and N; default the joints' effort limits.
    point: (dim,), centre of the mass in the frame's axes, m; default its origin.

    The torques at rest are those of `fb.static_torque`, affine in the mass: g + springs - m Jᵀ g₀
    with the field g₀ (2.41-2.49); friction does not help to hold. Returns PayloadMap. Raises
    FreebodyError without gravity or efforts, ShapeError, NotFiniteError, UnknownNameError.
    """
    function = "payload_map"
    model.require_values("the payload map")
    model.require_tree(function)
    if not model.gravity.any():
        raise FreebodyError(f"{function}: {model.name!r} is without gravity; no mass has weight.")
    at = finite_vector(function, model, "q", q)
    given = _efforts(model) if effort is None else finite_vector(function, model, "effort", effort)
    if given.ndim != 1 or not (given > 0).all():
        raise FreebodyError(
            f"{function}: effort must be one positive number for each of the {model.nv} joints; "
            f"got {given.tolist()}."
        )
    name = model.frame(frame).name
    centre = np.zeros(model.dim) if point is None else _point(model, point)
    mass, joint, over = _kernel(model, name)(at, np.minimum(given, _UNLIMITED), centre)
    free = mass >= _UNLIMITED * 1e-6
    return PayloadMap(
        np.where(free, np.inf, mass),
        np.where(free, -1, joint).astype(int),
        np.asarray(over == 1.0),
        model.velocity_names,
        name,
    )


def _efforts(model: Model) -> Array:
    """The joints' effort limits (nv,), infinite where there is none."""
    efforts: list[float] = []
    for body in model.bodies:
        if body.joint.mimic is None:
            efforts += [float(body.joint.limits.meant.effort)] * body.kind.nv
    if not np.isfinite(efforts).any():
        raise FreebodyError(
            f"payload_map: no joint of {model.name!r} has an effort limit. Give effort=, the "
            f"largest torque or force of each joint ({', '.join(model.velocity_names)})."
        )
    return np.array(efforts)


def _point(model: Model, point: Vector) -> Array:
    names = ("x", "y", "z")[: model.dim]
    array = as_floats(
        "payload_map", "point", aligned("payload_map", "point", point, names, ("axis",))
    )
    check_core("payload_map", "point", array, (model.dim,), "the centre of the mass, one point")
    refuse_not_finite("payload_map", "point", array, 1, names)
    if array.ndim != 1:
        raise FreebodyError(f"payload_map: point has shape {array.shape}, expected ({model.dim},).")
    return array


def _kernel(model: Model, frame: str) -> Kernel:
    """(q, effort, point) -> (mass, joint, 1 where it is overloaded), compiled on first use."""
    key = ("payload_map", frame)
    found = model.compiled.get(key)
    if found is None:
        found = model.compiled[key] = _compiled(model, frame)
    return found


def _compiled(model: Model, frame: str) -> Kernel:
    pose = formula(model, "forward_kinematics", frame=frame)
    jacobian = formula(model, "jacobian", frame=frame)
    static, d = formula(model, "static_torque"), model.dim
    field = tuple(map(float, model.gravity))

    def largest(q: Any, effort: Any, point: Any) -> tuple[Scalar, Scalar, Scalar]:
        arm = times(tuple(row[:d] for row in pose(q)[:d]), point)
        weight = of_dimension(d).moment(arm, field)
        slopes = [-dot(column, (*field, *weight)) for column in transposed(jacobian(q), model.nv)]
        best: tuple[Scalar, Scalar, Scalar] = (_UNLIMITED, 0.0, 0.0)
        for k, (torque, slope) in enumerate(zip(static(q), slopes, strict=True)):
            over = less(effort[k], absolute(torque))
            left = effort[k] - where(less(0.0, slope), torque, -torque)
            size = absolute(slope)
            none = less(size, 1e-12)
            holds = where(none, _UNLIMITED, left / where(none, 1.0, size))
            mass = where(over, 0.0, holds)
            nearer = less(mass, best[0])
            # of overloaded joints the first
            best = tuple(
                where(nearer, a, b) for a, b in zip((mass, float(k), over), best, strict=True)
            )
        return best

    inputs = [Argument("q", (model.nq,)), Argument("effort", (model.nv,)), Argument("point", (d,))]
    outputs = [Argument(name, ()) for name in ("mass", "joint", "overloaded")]
    return compile_program(trace("payload_map", largest, inputs, outputs))
