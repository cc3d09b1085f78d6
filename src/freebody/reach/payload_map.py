"""`payload_map`: the largest mass that a robot holds at rest, at each posture."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.any_chain.dynamics import static_torque
from freebody.any_chain.effort_limits import chosen_efforts, followers
from freebody.arrays import Array, as_floats, check_core, refuse_not_finite
from freebody.by_value import ByValue
from freebody.elementary import Scalar, absolute, less, where
from freebody.errors import FreebodyError, PassiveJointError
from freebody.labels import aligned
from freebody.model.doubt_rules.aspects import EFFORTS, MASSES
from freebody.model.doubts import Doubt, attribute, barring, doubts_on, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.program import Argument, trace
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.spatial import dot, of_dimension, times, transposed
from freebody.targets import Kernel, compile_program
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.public_calls import JointVector, finite_vector, refuse_without_length
from freebody.ways_out.kernel import formula

if TYPE_CHECKING:
    import xarray as xr

_UNLIMITED = 1e30
"""The number for no bound inside a kernel, whose numbers are finite."""
NO_SLOPE = 1e-12
"""N m/kg, N/kg: what a kilogram adds to a torque by rounding alone, as at an arm that hangs."""
_ROUNDING = 1e-13
"""Change of a torque, as a part of it, that is none."""


@dataclass(frozen=True, eq=False, repr=False)
class PayloadMap(Tabled, ByValue):
    """The largest mass at a point of an arm that its joints hold at rest, at each posture (...).

    mass: (...), kg; 0 where a joint is overloaded without any, infinite where none limits it.
    joint: (...), index of the joint that limits it, -1 without one. overloaded: (...), whether that
    joint is overloaded without payload. joint_names: (K,), of the coordinates, then of joints that
    follow others and have limits of their own. frame: where the mass is. doubts: those
    on the robot's masses and effort limits; where one of them bars a verdict, the masses are what
    its numbers give, and nothing is judged.
    """

    mass: Array
    joint: np.ndarray
    overloaded: np.ndarray
    joint_names: tuple[str, ...]
    frame: str
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the postures: mass, the name of the joint that limits it, and
        whether that is overloaded."""
        dims = axes_of("posture", self.mass.ndim)
        names = np.array([*self.joint_names, ""])[self.joint]
        return labelled(
            {
                "mass": (dims, self.mass, "kg", f"largest payload at {self.frame}"),
                "joint": (dims, names, "1", "joint that limits it"),
                "overloaded": (dims, self.overloaded, "1", "overloaded without payload"),
            },
            {},
            {"frame": self.frame, **attribute(self.doubts)},
        )

    def _title(self) -> str:
        count = self.mass.size
        if not count:
            return f"Payload map: no postures; frame {self.frame!r}"
        least, most = self.mass.min(), self.mass.max()
        masses = "" if barring(self.doubts) else f", {least:.4g} to {most:.4g} kg"
        return (
            f"Payload map: {counted(count, 'posture')}{masses} at frame {self.frame!r}"
            f"{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        rows = []
        for k, name in enumerate(self.joint_names):
            mass = self.mass[self.joint == k]
            if mass.size:
                rows.append((name, str(mass.size), f"{mass.min():.4g}", f"{mass.max():.4g}"))
        notes = [in_one_line(self.doubts)] if self.doubts else []
        if self.overloaded.any():
            count = counted(int(self.overloaded.sum()), "posture")
            notes.append(f"A joint is overloaded without payload in {count}.")
        return TextTable(("limiting joint", "postures", "least (kg)", "largest (kg)"), rows, notes)


def payload_map(
    model: Model,
    q: JointVector,
    frame: str | None = None,
    *,
    effort: JointVector | None = None,
    point: JointVector | None = None,
) -> PayloadMap:
    """The largest mass that a robot holds at rest at each posture, and the joint that limits it.

    q: (..., nq), such as `fb.random_state(model, seed, 10**6)[0]`, of a family (..., *family, nq).
    frame: name, default the tip. effort: (nv,), of a family (*family, nv) too, the largest torques
    and forces, N m and N, infinite where there is no limit; default the joints' effort limits;
    those of joints that follow others count in any case. Of a closed chain, whose positions must
    satisfy its loops, only driven joints count, and a dictionary may omit the others. point:
    (dim,), centre of the mass in the frame's axes, m; default its origin.

    The torques at rest are those of `fb.static_torque`, affine in the mass: g + springs - m Jᵀ g₀
    with the field g₀ (2.41-2.49); friction does not help to hold. Returns PayloadMap. Raises
    FreebodyError without gravity or efforts and for an open chain with passive joints, ShapeError,
    NotFiniteError, UnknownNameError.
    """
    function = "payload_map"
    model.require_values("the payload map")
    if not model.gravity.any():
        raise FreebodyError(f"{function}: {model.name!r} is without gravity; no mass has weight.")
    if model.passive and not model.loops:
        refuse_passive(function, model)
    at = finite_vector(function, model, "q", q)
    given, names = chosen_efforts(function, model, effort), model.velocity_names
    if (following := followers(model)) is not None:
        names = (*names, *following.names)
        limits = following.limits
        shape = np.broadcast_shapes(given.shape[:-1], limits.shape[:-1])
        both = (np.broadcast_to(x, (*shape, x.shape[-1])) for x in (given, limits))
        given = np.concatenate([*both], axis=-1)
    name = model.frame(frame).name
    centre = np.zeros(model.dim) if point is None else _point(model, point)
    refuse_without_length(function, model, at)
    found = _by_torques if model.loops or model.family else _at_once
    mass, joint, over = found(model, at, name, np.minimum(given, _UNLIMITED), centre)
    free = mass >= _UNLIMITED * 1e-6
    return PayloadMap(
        np.where(free, np.inf, mass),
        np.where(free, -1, joint).astype(int),
        np.asarray(over == 1.0),
        names,
        name,
        doubts_on(model, MASSES, *([EFFORTS] if effort is None else ())),
    )


def refuse_passive(function: str, model: Model) -> None:
    """Tell what holds the passive joints at rest: nothing, or a spring that gives way."""
    sprung = {body.joint.name for body in model.bodies if body.joint.drive.stiffness != 0.0}
    loose = next((name for name in model.passive_names if name not in sprung), None)
    if loose is not None:
        raise PassiveJointError(
            f"{function}: {loose!r} of {model.name!r} is passive: nothing holds it at rest."
        )
    raise PassiveJointError(
        f"{function}: {model.passive_names[0]!r} of {model.name!r} is passive: a spring holds it "
        f"and gives way to the mass, on which the posture then depends. Ask the robot with this "
        f"joint rigid, such as model.without('shafts'): its motors hold as much."
    )


def _point(model: Model, point: JointVector) -> Array:
    names = ("x", "y", "z")[: model.dim]
    array = as_floats(
        "payload_map", "point", aligned("payload_map", "point", point, names, ("axis",))
    )
    check_core("payload_map", "point", array, (model.dim,), "the centre of the mass, one point")
    refuse_not_finite("payload_map", "point", array, 1, names)
    if array.ndim != 1:
        raise FreebodyError(f"payload_map: point has shape {array.shape}, expected ({model.dim},).")
    return array


HeldLoad = tuple[Scalar, Scalar, Scalar]
"""A mass, the joint that limits it, and 1 where that is overloaded."""


def _at_once(model: Model, q: Array, frame: str, effort: Array, point: Array) -> HeldLoad:
    """The largest mass, the limiting joint and whether it is overloaded, at each posture, by one
    kernel of the model."""
    key = ("payload_map", frame)
    found = model.compiled.get(key)
    if found is None:
        found = model.compiled[key] = _compiled(model, frame)
    return found(q, effort, point)


def _compiled(model: Model, frame: str) -> Kernel:
    """The kernel (q, effort, point) -> largest mass, limiting joint and overload."""
    pose = formula(model, "forward_kinematics", frame=frame)
    jacobian = formula(model, "jacobian", frame=frame)
    static, d = formula(model, "static_torque"), model.dim
    field, following = tuple(map(float, model.gravity)), followers(model)

    def largest(q: Any, effort: Any, point: Any) -> HeldLoad:
        arm = times(tuple(row[:d] for row in pose(q)[:d]), point)
        weight = of_dimension(d).moment(arm, field)
        pull = (*field, *weight)
        slopes = [-dot(column, pull) for column in transposed(jacobian(q), model.nv)]
        torques = [*static(q)]
        if following is not None:
            own = tuple(x for at in model.coordinates for x in at.position(tuple(q)))
            columns = transposed(
                formula(following.freed, "jacobian", frame=frame)(own), following.freed.nv
            )
            held = formula(following.freed, "static_torque")(own)
            slopes += [-dot(columns[k], pull) for k in following.columns]
            torques += [held[k] for k in following.columns]
        return _held(torques, slopes, effort)

    count = model.nv if following is None else model.nv + len(following.names)
    inputs = [Argument("q", (model.nq,)), Argument("effort", (count,)), Argument("point", (d,))]
    return compile_program(trace("payload_map", largest, inputs, _OUTPUTS))


_OUTPUTS = [Argument(name, ()) for name in ("mass", "joint", "overloaded")]


def _held(
    torques: Sequence[Scalar], slopes: Sequence[Scalar], effort: Sequence[Scalar]
) -> HeldLoad:
    """The largest mass, the limiting joint and its overload, from the torques at rest (nv,) without
    payload and their change for each kilogram."""
    best: HeldLoad = (_UNLIMITED, 0.0, 0.0)
    for k, (torque, slope) in enumerate(zip(torques, slopes, strict=True)):
        over = less(effort[k], absolute(torque))
        left = effort[k] - where(less(0.0, slope), torque, -torque)
        size = absolute(slope)
        none = less(size, NO_SLOPE)
        holds = where(none, _UNLIMITED, left / where(none, 1.0, size))
        mass = where(over, 0.0, holds)
        nearer = less(mass, best[0])
        # of overloaded joints the first
        best = tuple(where(nearer, a, b) for a, b in zip((mass, float(k), over), best, strict=True))
    return best


def _by_torques(model: Model, q: Array, frame: str, effort: Array, point: Array) -> HeldLoad:
    """The largest mass, the limiting joint and its overload, from the torques at rest without
    payload and under a kilogram's weight; for closed chains and families."""
    d, field = model.dim, model.gravity
    T = forward_kinematics(model, q, frame)
    arm = T[..., :d, :d] @ point
    if d == 3:
        moment = np.cross(arm, field)
    else:
        moment = arm[..., :1] * field[..., 1:] - arm[..., 1:] * field[..., :1]
    pull = np.broadcast_to(field, (*moment.shape[:-1], d))
    weight = {frame: np.concatenate([pull, moment], axis=-1)}
    torques, loaded = static_torque(model, q), static_torque(model, q, weight)
    if (following := followers(model)) is not None:
        rest = np.zeros((*torques.shape[:-1], model.nv))
        still = (np.broadcast_to(q, (*rest.shape[:-1], model.nq)), rest, rest)
        torques, loaded = (
            np.concatenate([own, following.torques(*still, pulls)], axis=-1)
            for own, pulls in ((torques, None), (loaded, weight))
        )
    slopes = loaded - torques
    slopes[np.abs(slopes) <= _ROUNDING * np.abs(loaded)] = 0.0
    key = ("payload_map", "by torques")
    kernel = model.compiled.get(key)
    if kernel is None:
        count = torques.shape[-1]
        inputs = [Argument(name, (count,)) for name in ("torques", "slopes", "effort")]
        kernel = compile_program(trace("held", _held, inputs, _OUTPUTS))
        model.compiled[key] = kernel
    return kernel(torques, slopes, effort)
