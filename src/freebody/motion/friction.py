"""Friction of joints in numbers: laws that depend on the sign of a rate, smoothed over a stated
width so that an integrator can follow; and the shares of torque that planning and studies use."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from freebody.algorithms.rnea import rnea
from freebody.algorithms.simulation_steps import FRICTION_WIDTH
from freebody.algorithms.struts import struts_alone
from freebody.arrays import Array
from freebody.elementary import Scalar, tanh
from freebody.errors import FreebodyError
from freebody.lazy import kept
from freebody.model.drives import LAWS, DriveLaw
from freebody.model.drives.acting import DriveScalars
from freebody.model.losses import require_lossless
from freebody.model.model import Model

WIDTH = FRICTION_WIDTH
"""rad/s or m/s: sticking creeps at rates below this."""


@dataclass(frozen=True, eq=False)
class DryFriction:
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
        for drive in self.drives:
            smooth = replace(drive, sign=lambda law, rate: tanh(rate / self.width))
            found[..., drive.at.v[0]] += drive.at.ratio * smooth.torque(*_columns(q, qd))
        return found

    def drag(self, q: Array, qd: Array) -> Array:
        """The size (..., nv) of dry friction at q (..., nq) and qd (..., nv); at rest the most that
        it can hold."""
        found = np.zeros(qd.shape)
        for drive in self.drives:
            found[..., drive.at.v[0]] += abs(drive.at.ratio) * drive.drag(*_columns(q, qd))
        return found

    def grip(self, family: tuple[int, ...] = ()) -> Array:
        """Largest torque that dry friction holds at rest (*family, nv)."""
        return self.drag(np.zeros((*family, self.nq)), np.zeros((*family, self.nv)))

    def steepest(self) -> Array:
        """The approximate largest slope d tau / d q̇ of each coordinate (nv,)."""
        found, slow = np.zeros(self.nv), ((0.0,) * self.nq, (self.width,) * self.nv)
        for drive in self.drives:
            found[drive.at.v[0]] += drive.at.ratio**2 * drive.drag(*slow) / self.width
        return found


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
    found = np.zeros(qd.shape)
    for drive in _only(model, lambda law: law.feature == "friction"):
        found[..., drive.at.v[0]] += drive.at.ratio * drive.torque(*_columns(q, qd))
    return found + strut_damping(model, q, qd) if model.struts else found


def motor_springs(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) of laws that store energy on the motors' side of the gears, such as
    cogging, at q (..., nq) and qd (..., nv); joints do not transmit it."""
    found = np.zeros(qd.shape)
    for drive in _only(model, lambda law: law.energy is not None and not law.at_joint):
        found[..., drive.at.v[0]] += drive.at.ratio * drive.torque(*_columns(q, qd))
    return found


def strut_torque(model: Model, q: Array, qd: Array) -> Array:
    """The torque (..., nv) that struts need at q (..., nq) and qd (..., nv)."""
    tau = rnea(struts_alone(model.tree), *_columns(q, qd), (0.0,) * model.nv).tau
    return np.stack([np.broadcast_to(x, qd.shape[:-1]) for x in tau], axis=-1)


def strut_damping(model: Model, q: Array, qd: Array) -> Array:
    """The part of the struts' torque (..., nv) that their dampers need; linear in qd."""
    dampers = tuple(replace(strut, stiffness=0.0, preload=0.0) for strut in model.struts)
    return strut_torque(replace(model, struts=dampers), q, qd)


def without_friction(model: Model) -> Model:
    """The model without everything that dissipates energy: friction of joints, dampers of
    struts."""
    struts = tuple(replace(strut, damping=0.0) for strut in model.struts)
    return replace(model.without("friction"), struts=struts)


def lost_torque(model: Model, qd: Array, transmitted: Array) -> Array:
    """The torque (..., nv) that drives supply in addition to what their joints transmit (..., nv)
    at the rates qd (..., nv), because of losses."""
    found = np.zeros(qd.shape)
    for body in model.tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            sent = transmitted[..., k]
            found[..., k] = body.drive.lost_part(tuple(np.moveaxis(qd, -1, 0)), sent) * sent
    return found


def lost_parts(model: Model) -> tuple[Array, Array]:
    """Two fractions (nv,) of the transmitted torque: lost while the motor drives the joint, and
    spared the motor while the joint drives it."""
    driving, driven = np.zeros(model.nv), np.zeros(model.nv)
    for body in model.tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            driving[k], driven[k] = body.drive.losses
    return driving, driven


def reflected_inertia(model: Model) -> Array:
    """The rotors' inertia reflected to each coordinate (nv,), that of follower joints included."""
    return _each(model, lambda drive: drive.at.ratio**2 * drive.inertia)


def viscous_friction(model: Model) -> Array:
    """The torque of friction per unit of rate (nv,) from the laws proportional to it, that of
    follower joints included."""
    return kept(model, "_viscous_friction", _viscous_friction, model)


def _viscous_friction(model: Model) -> Array:
    at_rest = (0.0,) * model.nq, (0.0,) * model.nv
    return _each(
        model,
        lambda drive: (
            drive.at.ratio**2 * drive.only(lambda law: law.power == 1).slopes(*at_rest)[1]
        ),
    )


def _each(model: Model, of: Callable[[DriveScalars], Scalar]) -> Array:
    found = np.zeros(model.nv)
    for body in model.tree.bodies:
        if body.drive is not None:
            found[body.coordinates.v[0]] += of(body.drive)
    found.flags.writeable = False
    return found


def simple_friction(function: str, model: Model) -> tuple[Array, Array]:
    """Viscous friction, and the largest dry friction independent of the rate, for each coordinate
    (nv,). Raises FreebodyError where a joint has other friction."""
    require_lossless(function, model)
    for body in model.tree.bodies:
        for x in () if body.drive is None else body.drive.laws:
            if x.law.feature == "friction" and x.law.power not in (0, 1) and np.any(x.p[0]):
                raise FreebodyError(
                    f"{function}: the {x.law.numbers[0].what} of body {body.name!r} is neither "
                    f"constant nor proportional to the rate; plan without it, "
                    f"model.with_drive(joint, {x.law.strength}=0)."
                )
    return viscous_friction(model), sticking_friction(model)[1].grip()
