"""Friction of joints in numbers: laws that depend on the sign of a rate, smoothed over a stated
width so that an integrator can follow; and the shares of torque that planning and studies use."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from freebody.algorithms.rnea import rnea
from freebody.algorithms.simulation_steps import FRICTION_WIDTH
from freebody.algorithms.struts import struts_alone
from freebody.arrays import Array
from freebody.elementary import Scalar, tanh
from freebody.errors import FreebodyError
from freebody.lazy import Keeps, kept
from freebody.model.coordinates import Coordinates
from freebody.model.drives import LAWS, DriveLaw
from freebody.model.drives.acting import ActingLaw, DriveScalars
from freebody.model.losses import require_lossless
from freebody.model.model import Model
from freebody.motion.intervals import for_each, side_by_side

WIDTH = FRICTION_WIDTH
"""rad/s or m/s: sticking creeps at rates below this."""


@dataclass(frozen=True, eq=False)
class DryFriction(Keeps):
    """The laws of all joints whose torque depends on the sign of a rate, with tanh(q̇ / width) in
    place of the sign."""

    drives: tuple[DriveScalars, ...]
    nq: int
    nv: int
    width: float

    @property
    def acts(self) -> bool:
        """Whether the model has dry friction."""
        return len(self.drives) > 0

    def torque(self, q: Array, qd: Array) -> Array:
        """Smooth torques (..., nv) that the drives need to overcome friction at q (..., nq) and qd
        (..., nv)."""
        found = np.zeros(qd.shape)
        for drive, iq, iv in kept(self, "_alike", self._alike):
            at = (q[..., iq],), (qd[..., iv],)
            found[..., iv] += drive.at.felt(at[0], drive.torque(*at))
        return found

    def _alike(self) -> list[tuple[DriveScalars, list[int], list[int]]]:
        """The smooth laws, one drive with arrays of numbers in the place of several with the same
        laws at joints that move with their coordinates alike; and these coordinates' columns."""
        rows: dict[Any, list[DriveScalars]] = {}
        for k, drive in enumerate(self.drives):
            at, laws = drive.at, tuple(x.law.name for x in drive.laws)
            before = sum(other.at.v == at.v for other in self.drives[:k])  # at this coordinate
            rows.setdefault((laws, before, at.ratio, at.offset, at.powers), []).append(drive)
        return [self._joined(drives) for drives in rows.values()]

    def _joined(self, drives: Sequence[DriveScalars]) -> tuple[DriveScalars, list[int], list[int]]:
        first, numbers = drives[0], zip(*(drive.laws for drive in drives), strict=True)
        laws = tuple(
            ActingLaw(
                every[0].law, tuple(map(_side_by_side, zip(*(x.p for x in every), strict=True)))
            )
            for every in numbers
        )
        joined = DriveScalars(
            laws, replace(first.at, q=(0,), v=(0,)), lambda law, rate: tanh(rate / self.width)
        )
        return joined, [x.at.q[0] for x in drives], [x.at.v[0] for x in drives]

    def drag(self, q: Array, qd: Array) -> Array:
        """The size (..., nv) of dry friction at q (..., nq) and qd (..., nv); at rest the most that
        it can hold."""
        found = np.zeros(qd.shape)
        for drive in self.drives:
            at = _columns(q, qd)
            found[..., drive.at.v[0]] += np.abs(drive.at.felt(at[0], drive.drag(*at)))
        return found

    def grip(self, family: tuple[int, ...] = ()) -> Array:
        """Largest torque that dry friction holds at rest (*family, nv)."""
        return self.drag(np.zeros((*family, self.nq)), np.zeros((*family, self.nv)))

    def steepest(self, q: Array) -> Array:
        """About the largest slope d tau / d q̇ of each coordinate (nv,) at q (..., nq)."""
        found, slow = np.zeros(self.nv), ((0.0,) * self.nq, (self.width,) * self.nv)
        for drive in self.drives:
            found[drive.at.v[0]] += largest_square(drive.at, q) * drive.drag(*slow) / self.width
        return found


def largest_square(at: Coordinates, q: Array) -> float:
    """The largest square, at q (..., nq), of a joint's rate for each unit of its coordinate's."""
    return float(np.max(np.square(at.slope(tuple(np.moveaxis(q, -1, 0)))), initial=0.0))


def _felt(drives: Iterable[DriveScalars], q: Array, qd: Array) -> Array:
    """The torques (..., nv) of drives at the coordinates, at q (..., nq) and qd (..., nv)."""
    found, (positions, rates) = np.zeros(qd.shape), _columns(q, qd)
    for drive in drives:
        torque = drive.at.felt(positions, drive.torque(positions, rates))
        found[..., drive.at.v[0]] += torque
    return found


def _side_by_side(numbers: Sequence[Any]) -> Array:
    """Numbers of several drives, or arrays of them over a family (...), as an array (..., n)."""
    return np.stack(np.broadcast_arrays(*numbers), axis=-1)


def _columns(q: Array, qd: Array) -> tuple[tuple[Array, ...], tuple[Array, ...]]:
    """The entries of positions and rates, each as an array over the samples."""
    return tuple(np.moveaxis(q, -1, 0)), tuple(np.moveaxis(qd, -1, 0))


def smooth_friction(model: Model, width: float = WIDTH) -> tuple[Model, DryFriction]:
    """(the model without the laws that depend on the sign of a rate, these laws)."""
    friction = _signed_laws(model, lambda law: law.signed, width)
    return without_laws(model, lambda law: law.signed) if friction.acts else model, friction


def sticking_friction(model: Model) -> tuple[Model, DryFriction]:
    """(the model without the laws that hold what is at rest, these laws)."""
    friction = _signed_laws(model, lambda law: law.grips, WIDTH)
    return without_laws(model, lambda law: law.grips) if friction.acts else model, friction


def _signed_laws(model: Model, keeps: Callable[[DriveLaw], bool], width: float) -> DryFriction:
    """The selected laws that depend on the sign of a rate."""
    return DryFriction(_only(model, keeps), model.nq, model.nv, width)


def without_laws(model: Model, gone: Callable[[DriveLaw], bool]) -> Model:
    """The model without the drive laws that `gone` selects."""
    off = {k: x for law in LAWS.values() if gone(law) for k, x in law.off.items()}
    bodies = tuple(
        replace(body, joint=replace(body.joint, drive=replace(body.joint.drive, **off)))
        for body in model.bodies
    )
    return replace(model, bodies=bodies)


def _only(model: Model, keeps: Callable[[DriveLaw], bool]) -> tuple[DriveScalars, ...]:
    """The drives of all joints reduced to selected laws; drives without an acting one are left
    out."""
    found = (b.drive.only(keeps) for b in model.tree.bodies if b.drive is not None)
    return tuple(drive for drive in found if any(np.any(x.p[0]) for x in drive.laws))


def friction_torque(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) of all friction, struts' dampers included, at q (..., nq) and qd (...,
    nv)."""
    found = _felt(_only(model, lambda law: law.feature == "friction"), q, qd)
    return found + strut_damping(model, q, qd) if model.struts else found


class ChangingFriction:
    """The friction that is neither constant nor proportional to the rate, along a motion."""

    def __init__(self, model: Model, q: Array, qd: Array):
        self.drives = _only(model, lambda law: law.torque is not None and _changes(law))
        self.q, self.qd = q, qd

    @property
    def acts(self) -> bool:
        """Whether the model has such friction."""
        return len(self.drives) > 0

    def at_pace(self, k: Scalar) -> Scalar:
        """Its torque (T, nv) where the motion is run k times as fast, or at the paces of an
        interval k above 0, (K, T, nv) at K of them; for 0 the limit of slow motion."""
        found: list[Scalar] = [0.0] * self.qd.shape[-1]
        q, rates = _columns(self.q, self.qd)
        signs = tuple(np.sign(rate) for rate in rates)
        pace = for_each(k, 1)
        fast = tuple(pace * rate for rate in rates)
        for drive in self.drives:
            (sense,) = drive.at.rates(q, signs)
            moving = replace(drive, sign=lambda law, rate, sense=sense: np.sign(sense))
            v = drive.at.v[0]
            found[v] = found[v] + drive.at.felt(q, moving.torque(q, fast))
        return side_by_side(found, (*getattr(k, "shape", ()), *self.qd.shape[:-1]))


def _changes(law: DriveLaw) -> bool:
    return law.feature == "friction" and law.power not in (0, 1)


def motor_springs(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) of laws that store energy on the motors' side of the gears, such as
    cogging, at q (..., nq) and qd (..., nv); joints do not transmit it."""
    at_motor = _only(model, lambda law: law.energy is not None and not law.at_joint)
    return _felt(at_motor, q, qd)


def strut_torque(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) that struts need at q (..., nq) and qd (..., nv)."""
    tau = rnea(struts_alone(model.tree), *_columns(q, qd), (0.0,) * model.nv).tau
    return np.stack([np.broadcast_to(x, qd.shape[:-1]) for x in tau], axis=-1)


def strut_damping(model: Model, q: Array, qd: Array) -> Array:
    """The part of the struts' torque (..., nv) that their dampers need; linear in qd."""
    dampers = tuple(replace(strut, stiffness=0.0, preload=0.0) for strut in model.struts)
    return strut_torque(replace(model, struts=dampers), q, qd)


def without_friction(model: Model) -> Model:
    """The model without everything that dissipates energy: friction of joints, dampers of struts
    and shafts."""
    struts = tuple(replace(strut, damping=0.0) for strut in model.struts)
    return replace(without_laws(model, lambda law: law.feature == "friction"), struts=struts)


def lost_torque(model: Model, qd: Array, transmitted: Scalar) -> Scalar:
    """The torque (..., nv) that drives supply in addition to what their joints transmit, an array
    (..., nv) or an interval of them, at the rates qd (..., nv), because of losses."""
    found: list[Scalar] = [0.0] * qd.shape[-1]
    for body in model.tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            sent = transmitted[..., k]
            found[k] = body.drive.lost_part(tuple(np.moveaxis(qd, -1, 0)), sent) * sent
    return side_by_side(found, transmitted.shape[:-1])


def lost_parts(model: Model) -> tuple[Array, Array]:
    """Two fractions (nv,) of the transmitted torque: lost while the motor drives the joint, and
    spared the motor while the joint drives it."""
    driving, driven = np.zeros(model.nv), np.zeros(model.nv)
    for body in model.tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            driving[k], driven[k] = body.drive.losses
    return driving, driven


def rotor_torque(model: Model, q: Array, qd: Array, qdd: Array) -> Array:
    """The torque (..., nv) of the rotors' inertia at a motion, what followers add included."""
    found, at = np.zeros(qdd.shape), tuple(tuple(np.moveaxis(x, -1, 0)) for x in (q, qd, qdd))
    for body in model.tree.bodies:
        if body.drive is not None:
            (second,) = body.coordinates.second_rates(*at)
            felt = body.coordinates.felt(at[0], body.drive.inertia * second)
            found[..., body.coordinates.v[0]] += felt
    return found


def viscous_torque(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) of the friction that is proportional to the rate, what followers add
    included."""
    return _felt(_only(model, lambda law: law.power == 1), q, qd)


def refuse_bent(
    function: str, model: Model, laws: Callable[[DriveLaw], bool], instead: str
) -> None:
    """Refuse laws at joints that follow others by a ratio that changes with the position, where
    each coordinate's friction is taken for the same everywhere."""
    for body in model.tree.bodies:
        if body.coordinates.powers and body.drive is not None:
            for x in body.drive.only(laws).laws:
                if np.any(x.p[0]):
                    raise FreebodyError(
                        f"{function}: the {x.law.numbers[0].what} of body {body.name!r}, whose "
                        f"joint follows another by a polynomial, is felt there by a ratio that "
                        f"changes with the position, which is not available here; {instead}."
                    )


def simple_friction(function: str, model: Model) -> tuple[Array, Array]:
    """Viscous friction, and the largest dry friction independent of the rate, for each coordinate
    (nv,). Raises FreebodyError where a joint has other friction."""
    require_lossless(function, model)
    refuse_bent(function, model, lambda law: law.feature == "friction", "model.without('friction')")
    for body in model.tree.bodies:
        for x in () if body.drive is None else body.drive.laws:
            if _changes(x.law) and np.any(x.p[0]):
                raise FreebodyError(
                    f"{function}: the {x.law.numbers[0].what} of body {body.name!r} is neither "
                    f"constant nor proportional to the rate; plan without it, "
                    f"model.with_drive(joint, {x.law.strength}=0)."
                )
    still = np.zeros((model.nv, model.nq)), np.eye(model.nv)
    return viscous_torque(model, *still).sum(axis=0), sticking_friction(model)[1].grip()
