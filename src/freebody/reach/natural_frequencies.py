"""`natural_frequencies`: how fast a robot with compliant joints oscillates about each posture, in
which modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.vibration_modes import SWEEPS, vibration_modes
from freebody.any_chain.dynamics import static_torque
from freebody.arrays import Array, at_sample
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, SingularError
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.doubts import Doubt, attribute, doubts_on, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.program import Argument, trace
from freebody.reach.compliant_joints import (
    CompliantJoints,
    Stiffness,
    compliant_joints,
    quaternion_coordinates,
    tangent,
    turning,
)
from freebody.reach.each_member import of_members
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.reach.loop_motions import loop_motions
from freebody.targets import Kernel, compile_program
from freebody.trees.dynamics import mass_matrix
from freebody.trees.public_calls import JointVector, common_batch, finite_vector

if TYPE_CHECKING:
    import xarray as xr

_BLOCK = 8192
"""Postures computed together: their matrices stay in a processor's cache."""
_BALANCED = 1e-9
"""Torque along a joint with a quaternion, relative to the largest, that is none."""
_RIGID = 1e-12
"""ω² relative to the largest, or to what rounding makes of it, that is 0."""


@dataclass(frozen=True, eq=False, repr=False)
class NaturalFrequencies(Tabled, ByValue):
    """The undamped modes of a robot about each posture (...), those of the lowest frequency first.

    squares: (..., k), ω² in rad²/s²; 0 of a mode that no spring resists, below 0 of one in which
    the robot falls away from the posture. modes: (..., k, nv), one a row, with vᵀ M v = 1, 0 at
    coordinates that stand still; of the two senses that in which the first entry of more than half
    the largest one's size is positive. joint_names: (nv,). held: names of the coordinates that
    stand still. doubts: those on the robot's masses and rotors. notices: in which units one
    stiffness counts.
    """

    squares: Array
    modes: Array
    joint_names: tuple[str, ...]
    held: tuple[str, ...]
    doubts: tuple[Doubt, ...] = ()
    notices: tuple[str, ...] = ()
    _aside = ("doubts", "notices")

    @property
    def frequencies(self) -> Array:
        """Natural frequencies (..., k), Hz; NaN where the robot does not oscillate but falls
        away."""
        falls = self.squares < 0.0
        return np.where(falls, np.nan, np.sqrt(np.where(falls, 0.0, self.squares)) / (2 * np.pi))

    @property
    def stable(self) -> np.ndarray:
        """Flags (...) where no mode falls away from the posture."""
        return np.asarray((self.squares >= 0.0).all(axis=-1))

    def to_xarray(self) -> xr.Dataset:
        """A labelled dataset over the postures, modes and coordinates."""
        dims = axes_of("posture", self.squares.ndim - 1)
        names = np.array(self.joint_names)
        return labelled(
            {
                "frequency": ((*dims, "mode"), self.frequencies, "Hz", "natural frequency"),
                "square": ((*dims, "mode"), self.squares, "rad2/s2", "its square"),
                "shape": (
                    (*dims, "mode", "coordinate"),
                    self.modes,
                    "1",
                    "mode, of which the modal mass is 1",
                ),
            },
            {"coordinate": (("coordinate",), names, "1", "coordinate")},
            {"held": ", ".join(self.held), **attribute(self.doubts)},
        )

    def _title(self) -> str:
        postures = counted(self.squares[..., 0].size, "posture")
        return (
            f"Natural frequencies: {postures}, {counted(self.squares.shape[-1], 'mode')}"
            f"{named(self.doubts)}"
        )

    def _table(self) -> TextTable:
        if not self.squares.size:
            return TextTable((), ())
        k, nv = self.modes.shape[-2:]
        hertz, shapes = self.frequencies.reshape(-1, k), np.abs(self.modes.reshape(-1, k, nv))
        rows = []
        for i in range(k):
            known = hertz[:, i][np.isfinite(hertz[:, i])]
            ends = [f"{f(known):.4g}" if known.size else "" for f in (np.min, np.median, np.max)]
            most = np.bincount(np.argmax(shapes[:, i], axis=-1), minlength=nv)
            rows.append((str(i + 1), *ends, self.joint_names[int(np.argmax(most))]))
        notes = [*([in_one_line(self.doubts)] if self.doubts else []), *self.notices]
        if not self.stable.all():
            count = counted(int((~self.stable).sum()), "posture")
            notes.append(f"The robot falls away from {count}: its springs are too soft.")
        head = ("mode", "least (Hz)", "median (Hz)", "largest (Hz)", "most often largest in")
        return TextTable(head, rows, notes)


def natural_frequencies(
    model: Model,
    q: JointVector,
    stiffness: Stiffness = None,
    *,
    held: Sequence[str] | None = None,
) -> NaturalFrequencies:
    """The natural frequencies and modes of a robot with compliant joints, about each posture.

    Parameters
    ----------
    model
        A robot, an open chain or a closed one, or a family of robots. Its own springs, flexible
        joints (`Model.with_flexible_joint`) and struts yield; friction and dampers are left out.
    q
        (..., nq), such as `fb.random_state(model, seed, 10**6)[0]`, loops closed; of a family
        (..., *family, nq).
    stiffness
        (..., nv) or {joint: k}, N m/rad (N/m): of the gear and shaft between the motor of each
        joint, which stands still with its rotor, and the link. Infinite, or of a drive left out of
        the mapping: rigid. One number is that of every driven joint of one coordinate.
    held
        Names of the joints that stand still, `model.driven_names` for all drives; () for none.
        Default: with `stiffness` the drives that have none, else none: motors then turn freely.

    Returns
    -------
    NaturalFrequencies
        Of K v = ω² M v with M the mass matrix of what moves, and K the slope of the torques at rest
        by the positions: springs, and weights, as if constant torques held the robot at q. Of a
        closed chain these are torques of its drives, and v the motions that its loops allow.

    Raises
    ------
    FreebodyError
        Nothing yields; a free base or ball joint that moves and does not rest at q.
    SingularError
        A coordinate that moves no mass; a closed chain that its drives cannot hold, or at a
        singular position among others.
    LoopError
        Open loops.
    ShapeError, NotFiniteError, UnknownNameError
    """
    if model.family:
        return _of_family(model, q, stiffness, held)
    function = "natural_frequencies"
    joints = compliant_joints(function, model, stiffness, held, resting=False)
    at = finite_vector(function, model, "q", q)
    shape = common_batch(function, {"q": at, "stiffness": joints.given})
    rows = np.broadcast_to(at, (*shape, at.shape[-1])).reshape(-1, at.shape[-1])
    springs = np.broadcast_to(joints.given, (*shape, len(joints.moving)))
    springs = springs.reshape(-1, len(joints.moving))
    of_block = _modes_of_loops if model.loops else _modes
    found = [
        of_block(function, joints, rows[first : first + _BLOCK], springs[first : first + _BLOCK],
                 first)
        for first in range(0, max(len(rows), 1), _BLOCK)
    ]  # fmt: skip
    squares, modes = (x[0] if len(x) == 1 else np.concatenate(x) for x in zip(*found, strict=True))
    largest = np.abs(squares).max(axis=-1, keepdims=True, initial=0.0)
    squares[np.abs(squares) <= _RIGID * largest] = 0.0
    k = squares.shape[-1]
    return NaturalFrequencies(
        squares.reshape(*shape, k), modes.reshape(*shape, k, model.nv), model.velocity_names,
        tuple(x for x in model.velocity_names if x not in joints.names),
        doubts_on(model, *DYNAMIC), joints.notices,
    )  # fmt: skip


def _of_family(
    model: Model, q: JointVector, stiffness: Stiffness, held: Sequence[str] | None
) -> NaturalFrequencies:
    parts = of_members(
        model,
        {"q": q, "stiffness": stiffness},
        lambda member, given: natural_frequencies(member, **given, held=held),
    )
    first = parts.first
    return replace(
        first,
        squares=parts.stacked(lambda x: x.squares, 1),
        modes=parts.stacked(lambda x: x.modes, 2),
        doubts=doubts_on(model, *DYNAMIC),
    )


def _modes(
    function: str, joints: CompliantJoints, q: Array, springs: Array, first: int
) -> tuple[Array, Array]:
    """Squares and modes at postures (m, nq), of which the first has this number, of an open
    chain."""
    at, n = joints.moving, joints.model.nv
    _require_resting(function, joints, q, first)
    M = mass_matrix(joints.model, q)
    M = M if len(at) == n else np.ascontiguousarray(M[..., at[:, None], at])
    K = tangent(replace(joints, given=springs), q)
    if len(at) >= len(SWEEPS):
        squares, shapes = _decomposed(function, joints, M, K, np.arange(len(q)) + first)
    else:
        squares, shapes, sure = _kernel(len(at))(M, K)
        unsure = np.flatnonzero(~((sure == 1.0) & np.isfinite(squares).all(axis=-1)))
        if len(unsure):
            closer = _decomposed(function, joints, M[unsure], K[unsure], unsure + first)
            squares[unsure], shapes[unsure] = closer
    if len(at) == n:
        return squares, shapes
    modes = np.zeros((*squares.shape, n))
    modes[..., at] = shapes
    return squares, modes


def _require_resting(function: str, joints: CompliantJoints, q: Array, first: int) -> None:
    """Refuse postures at which something turns or shifts a joint with a quaternion that moves: no
    constant torque in its axes holds it as a potential does."""
    free = np.intersect1d(quaternion_coordinates(joints.model), joints.moving)
    if not len(free):
        return
    torque = np.abs(static_torque(joints.model, q))
    bad = torque[:, free].max(axis=-1) > _BALANCED * np.maximum(torque.max(axis=-1), 1e-300)
    if bad.any():
        sample = int(np.argmax(bad))
        k = int(free[np.argmax(torque[sample, free])])
        raise FreebodyError(
            f"{function}: {joints.model.name!r} does not rest{at_sample((sample + first,))}: "
            f"{torque[sample, k]:.4g} {'N m' if turning(joints.model)[k] else 'N'} act along "
            f"{joints.model.velocity_names[k]!r}, where no spring or drive holds it. Give a "
            f"posture at which it rests, hold the joint still (held=), or, of a robot that floats, "
            f"take model.replace(gravity=0)."
        )


def _modes_of_loops(
    function: str, joints: CompliantJoints, q: Array, springs: Array, first: int
) -> tuple[Array, Array]:
    """Squares and modes at postures (m, nq), of which the first has this number, of a closed
    chain."""
    at, tree = joints.moving, joints.model.opened
    if not len(q):
        return np.zeros((0, 0)), np.zeros((0, 0, tree.nv))
    found = loop_motions(function, joints, q, static_torque(tree, q), drives_hold=True)
    N = found.ways
    moving = N[:, at]
    K = np.swapaxes(moving, -1, -2) @ tangent(replace(joints, given=springs), q) @ moving
    M = np.swapaxes(N, -1, -2) @ mass_matrix(tree, q) @ N
    K = K + found.bend
    squares, weights = _decomposed(
        function, joints, M, 0.5 * (K + np.swapaxes(K, -1, -2)), np.arange(len(q)) + first
    )
    return squares, _sensed(weights @ np.swapaxes(N, -1, -2))


@cache
def _kernel(n: int) -> Kernel:
    """The kernel (M, K) -> ω², modes, and 1 where they are sure, of n coordinates of any robot."""

    def found(M: Any, K: Any) -> tuple[Any, ...]:
        (squares, modes), sure = vibration_modes(M, K)
        return squares, modes, sure

    inputs = Argument("M", (n, n)), Argument("K", (n, n))
    outputs = Argument("squares", (n,)), Argument("modes", (n, n)), Argument("sure", ())
    return compile_program(trace("vibration_modes", found, inputs, outputs))


def _decomposed(
    function: str, joints: CompliantJoints, M: Array, K: Array, samples: np.ndarray
) -> tuple[Array, Array]:
    """Squares and modes (m, k, k) by LAPACK. samples: their numbers, for errors."""
    try:
        L = np.linalg.cholesky(M)
    except np.linalg.LinAlgError:
        bad = int(np.argmin(np.linalg.eigvalsh(M)[..., 0]))
        names = ", ".join(joints.names)
        raise SingularError(
            f"{function}: a motion of {names} of {joints.model.name!r} moves no mass"
            f"{at_sample((int(samples[bad]),))}; give the links mass and inertia, or hold joints "
            f"still (held=)."
        ) from None
    half = np.linalg.solve(L, K)
    A = np.linalg.solve(L, np.swapaxes(half, -1, -2))
    squares, U = np.linalg.eigh(0.5 * (A + np.swapaxes(A, -1, -2)))
    modes = np.swapaxes(np.linalg.solve(np.swapaxes(L, -1, -2), U), -1, -2)
    return np.asarray(squares, dtype=float), _sensed(np.asarray(modes, dtype=float))


def _sensed(modes: Array) -> Array:
    """Modes (..., k) in the sense in which the first entry of more than half the largest one's size
    is positive."""
    size = np.abs(modes)
    leading = np.argmax(size > 0.5 * size.max(axis=-1, keepdims=True), axis=-1)
    senses = np.sign(np.take_along_axis(modes, leading[..., None], axis=-1))
    return senses * modes
