"""`natural_frequencies`: how fast a robot with compliant joints oscillates about each posture, in
which modes."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.algorithms.vibration_modes import SWEEPS, vibration_modes
from freebody.arrays import Array, at_sample
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, SingularError
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.doubts import Doubt, attribute, doubts_on, in_one_line, named
from freebody.model.model import Model
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.program import Argument, trace
from freebody.reach.compliant_joints import CompliantJoints, compliant_joints, tangent
from freebody.reach.labelled_maps import axes_of, labelled
from freebody.targets import Kernel, compile_program
from freebody.trees.dynamics import mass_matrix
from freebody.trees.public_calls import JointVector, finite_vector

if TYPE_CHECKING:
    import xarray as xr

_BLOCK = 8192
"""Postures computed together: their matrices stay in a processor's cache."""
_RIGID = 1e-12
"""ω² relative to the largest, or to what rounding makes of it, that is 0."""


@dataclass(frozen=True, eq=False, repr=False)
class NaturalFrequencies(Tabled, ByValue):
    """The undamped modes of a robot about each posture (...), those of the lowest frequency first.

    squares: (..., k), ω² in rad²/s²; 0 of a mode that no spring resists, below 0 of one in which
    the robot falls away from the posture. modes: (..., k, nv), one a row, with vᵀ M v = 1, 0 at
    coordinates that stand still; of the two senses that in which the first entry of more than half
    the largest one's size is positive. joint_names: (nv,). held: names of the coordinates that
    stand still. doubts: those on the robot's masses and rotors.
    """

    squares: Array
    modes: Array
    joint_names: tuple[str, ...]
    held: tuple[str, ...]
    doubts: tuple[Doubt, ...] = ()
    _aside = ("doubts",)

    @property
    def frequencies(self) -> Array:
        """(..., k), Hz; NaN where the robot does not oscillate but falls away."""
        falls = self.squares < 0.0
        return np.where(falls, np.nan, np.sqrt(np.where(falls, 0.0, self.squares)) / (2 * np.pi))

    @property
    def stable(self) -> np.ndarray:
        """(...), whether no mode falls away from the posture."""
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
        notes = [in_one_line(self.doubts)] if self.doubts else []
        if not self.stable.all():
            count = counted(int((~self.stable).sum()), "posture")
            notes.append(f"The robot falls away from {count}: its springs are too soft.")
        head = ("mode", "least (Hz)", "median (Hz)", "largest (Hz)", "most often largest in")
        return TextTable(head, rows, notes)


def natural_frequencies(
    model: Model,
    q: JointVector,
    stiffness: JointVector | None = None,
    *,
    held: Sequence[str] | None = None,
) -> NaturalFrequencies:
    """The natural frequencies and modes of a robot with compliant joints, about each posture.

    Parameters
    ----------
    model
        An open chain. Its own springs, flexible joints (`Model.with_flexible_joint`) and struts
        yield; friction and dampers are left out.
    q
        (..., nq), such as `fb.random_state(model, seed, 10**6)[0]`.
    stiffness
        (..., nv) or {joint: k}, N m/rad (N/m): of the gear and shaft between the motor of each
        joint, which stands still with its rotor, and the link. Infinite, or of a drive left out of
        the mapping: rigid.
    held
        Names of the joints that stand still, `model.driven_names` for all drives; () for none.
        Default: with `stiffness` the drives that have none, else none: motors then turn freely.

    Returns
    -------
    NaturalFrequencies
        Of K v = ω² M v with M the mass matrix of what moves, and K the slope of the torques at rest
        by the positions: springs, and weights, as if constant torques held the robot at q.

    Raises
    ------
    FreebodyError
        Nothing yields; a closed chain; joints with quaternions.
    SingularError
        A coordinate that moves no mass.
    ShapeError, NotFiniteError, UnknownNameError
    """
    function = "natural_frequencies"
    joints = compliant_joints(function, model, stiffness, held, resting=False)
    at = finite_vector(function, model, "q", q)
    n, k = model.nv, len(joints.moving)
    try:
        shape = np.broadcast_shapes(at.shape[:-1], joints.given.shape[:-1])
    except ValueError:
        raise FreebodyError(
            f"{function}: the batch shapes do not broadcast together: q {at.shape[:-1]}, stiffness "
            f"{joints.given.shape[:-1]}."
        ) from None
    squares, modes = np.empty((*shape, k)), np.zeros((*shape, k, n))
    rows = np.broadcast_to(at, (*shape, at.shape[-1])).reshape(-1, at.shape[-1])
    springs = np.broadcast_to(joints.given, (*shape, k)).reshape(-1, k)
    flat = squares.reshape(-1, k), modes.reshape(-1, k, n)
    for first in range(0, len(rows), _BLOCK):
        some = slice(first, first + _BLOCK)
        found = _modes(function, joints, rows[some], springs[some], first)
        flat[0][some], flat[1][some][..., joints.moving] = found
    largest = np.abs(squares).max(axis=-1, keepdims=True, initial=0.0)
    squares[np.abs(squares) <= _RIGID * largest] = 0.0
    still = tuple(x for x in model.velocity_names if x not in joints.names)
    return NaturalFrequencies(
        squares, modes, model.velocity_names, still, doubts_on(model, *DYNAMIC)
    )


def _modes(
    function: str, joints: CompliantJoints, q: Array, springs: Array, first: int
) -> tuple[Array, Array]:
    """Squares and modes at postures (m, nq), of which the first has this number."""
    at = joints.moving
    M = mass_matrix(joints.model, q)
    M = M if len(at) == joints.model.nv else np.ascontiguousarray(M[..., at[:, None], at])
    K = tangent(CompliantJoints(joints.model, at, springs), q)
    if len(at) >= len(SWEEPS):
        return _decomposed(function, joints, M, K, np.arange(len(q)) + first)
    squares, modes, sure = _kernel(len(at))(M, K)
    unsure = np.flatnonzero(~((sure == 1.0) & np.isfinite(squares).all(axis=-1)))
    if len(unsure):
        closer = _decomposed(function, joints, M[unsure], K[unsure], unsure + first)
        squares[unsure], modes[unsure] = closer
    return squares, modes


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
    size = np.abs(modes)
    leading = np.argmax(size > 0.5 * size.max(axis=-1, keepdims=True), axis=-1)
    senses = np.sign(np.take_along_axis(modes, leading[..., None], axis=-1))
    return np.asarray(squares, dtype=float), np.asarray(senses * modes, dtype=float)
