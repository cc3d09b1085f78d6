"""Forward dynamics with the mass matrix, also where joints lose a part of the torque that they
transmit.

Behind its rotor (inertia J) and its friction a joint transmits t of the motor's torque, and loses a
part of it, by its direction: with the motor's torque less friction u,

    u - J q̈ = k t,   k = 1 + the part that is lost, where motor and motion have one direction,
                      1 - the part that is spared, where they have not

so that (M + diag(J/k - J)) q̈ = tau - bias - (1 - 1/k) u, a system linear in q̈ once the direction of
each t is known. Since k > 0, the torques t are those for which a strictly convex function is least,
so there is one solution. Without a rotor the direction is that of u. With rotors it is found by a
fixed number of sweeps, each with the directions that the last one led to, from those of u on; of
240 000 states of four arms with up to 0.99 lost none took more than four. Where directions have
not settled, q̈ is NaN.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from freebody.algorithms.crba import bias, crba, factor, solve, substitute
from freebody.algorithms.loop_checks import sure
from freebody.algorithms.rnea import External
from freebody.elementary import Scalar, absolute, epsilon, equal, less_equal, where
from freebody.model.drives.acting import DriveScalars
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector, sub

_SWEEPS = 5
_ROUNDED = 64.0
"""Times epsilon: a torque transmitted so small, relative to those that it is the difference of, has
no direction."""


def forward_dynamics(
    tree: Tree, q: Vector, qd: Vector, tau: Vector, external: Sequence[External] = ()
) -> Vector:
    """q̈ from M q̈ = tau - bias (3.29), less what is lost of the torques transmitted."""
    M, forces = crba(tree, q), sub(tau, bias(tree, q, qd, external))
    if not tree.lossy:
        return solve(tree, M, forces)
    return under_losses(tree, q, qd, tau, M, forces).qdd


@dataclass(frozen=True)
class _Gear:
    """A joint whose gear loses a part of the torque it transmits; k: its coordinate, given: the
    motor's torque less friction."""

    k: int
    drive: DriveScalars
    given: Scalar
    inertia: Scalar

    @property
    def heavy(self) -> bool:
        """Whether the rotor behind the gear may have inertia."""
        return not (isinstance(self.inertia, float) and self.inertia == 0.0)

    def sent(self, qdd: Vector, part: Scalar) -> Scalar:
        """The torque that the gear transmits at given joint accelerations, where a given part of it
        is lost."""
        return (self.given - self._rotor(qdd)) / (1.0 + part)

    def settled(self, qd: Vector, qdd: Vector, part: Scalar, sent: Scalar) -> Scalar:
        """A margin that is positive where the part assumed to be lost is the one that belongs to
        the torque transmitted, or where nothing is transmitted."""
        size = absolute(self.given) + absolute(self._rotor(qdd))
        tiny = less_equal(absolute(sent), _ROUNDED * epsilon(size) * size)
        return where(tiny, 1.0, equal(part, self.drive.lost_part(qd, sent))) - 0.5

    def _rotor(self, qdd: Vector) -> Scalar:
        return self.inertia * qdd[self.k] if self.heavy else 0.0


@dataclass(frozen=True)
class LossyMotion:
    """Accelerations of a tree with lossy joints, and the torque that each of these joints
    transmits, by coordinate."""

    qdd: Vector
    transmitted: dict[int, Scalar]


def under_losses(
    tree: Tree, q: Vector, qd: Vector, tau: Vector, M: Matrix, forces: Vector
) -> LossyMotion:
    """The motion of a tree with lossy joints under the torques tau; forces: the right side of M q̈
    = forces before losses."""
    gears = _gears(tree, q, qd, tau)
    heavy = any(gear.heavy for gear in gears)
    directions = [gear.given for gear in gears]
    for _ in range(_SWEEPS if heavy else 1):
        parts = [g.drive.lost_part(qd, x) for g, x in zip(gears, directions, strict=True)]
        qdd = _accelerations(tree, M, forces, gears, parts)
        sent = [g.sent(qdd, part) for g, part in zip(gears, parts, strict=True)]
        directions = [x if g.heavy else g.given for g, x in zip(gears, sent, strict=True)]
    if heavy:
        each = zip(gears, parts, sent, strict=True)
        qdd = sure(qdd, [g.settled(qd, qdd, part, x) for g, part, x in each if g.heavy])
    return LossyMotion(qdd, {g.k: x for g, x in zip(gears, sent, strict=True)})


def _gears(tree: Tree, q: Vector, qd: Vector, tau: Vector) -> list[_Gear]:
    """The joints of a tree that lose a part of the torque they transmit."""
    found = []
    for body in tree.bodies:
        if body.drive is not None and body.drive.lossy:
            k = body.coordinates.v[0]
            given = tau[k] - body.drive.at_motor.torque(q, qd)
            found.append(_Gear(k, body.drive, given, body.drive.inertia))
    return found


def _accelerations(
    tree: Tree, M: Matrix, forces: Vector, gears: Sequence[_Gear], parts: Sequence[Scalar]
) -> Vector:
    """Accelerations q̈ where the lossy joints lose given parts of the torque they transmit."""
    rows, right = [list(row) for row in M], list(forces)
    for gear, part in zip(gears, parts, strict=True):
        taken = part / (1.0 + part)  # 1 - 1/k
        right[gear.k] = right[gear.k] - taken * gear.given
        if gear.heavy:
            rows[gear.k][gear.k] = rows[gear.k][gear.k] - taken * gear.inertia
    return substitute(tree, factor(tree, tuple(map(tuple, rows))), tuple(right))
