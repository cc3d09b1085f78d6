"""Singular positions of a parallel robot as curves, followed step by step.

With Φ_p the columns of passive joints, det Φ_p = 0 where the mechanism gives way though its drives
stand still (second type), and det [Φ_q; J_tip] = 0 where its tip stands still though the drives
turn (first type). Together with Φ = 0 such a condition leaves a curve of positions of a mechanism
of two degrees of freedom, points of one of a single degree.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from freebody.arrays import Array, as_floats, refuse_not_finite
from freebody.errors import FreebodyError, UnknownNameError
from freebody.kernels.options import motion_rows
from freebody.loops.assembly import assemble
from freebody.loops.equations import (
    free_coordinates,
    require_loops,
    scaled_jacobian,
    scaled_residual,
)
from freebody.loops.independent_equations import independent_rows
from freebody.loops.scaled_equations import backward, length, rate_scale, shortest_way
from freebody.model.model import Model
from freebody.outputs.display import Titled, counted
from freebody.trees.kinematics import jacobian
from freebody.trees.states import difference, generic_state, integrate, neutral
from freebody.values import ByValue

_Measure = Callable[[Array], Array]
"""A signed number (...) of positions (..., nq), zero where singular."""

_SEEDS = 40
_STEP = 0.04  # rad
_MOST = 3000  # steps along one curve
_NEAR = 2.5 * _STEP  # two curves this close are one
_DIFFERENCE = 1e-6


@dataclass(frozen=True, eq=False, repr=False)
class Locus(Titled, ByValue):
    """One curve of singular positions, or an isolated singular position."""

    kind: Literal["first", "second"]
    q: Array
    """Positions along the curve (k, nq)."""
    closed: bool
    """Whether the curve ends where it began."""

    def _title(self) -> str:
        curve = "closed curve" if self.closed else "curve"
        return (
            f"Singular positions of the {self.kind} type: "
            f"{curve} of {counted(len(self.q), 'position')}"
        )


def singularity_loci(
    model: Model,
    kind: Literal["first", "second"],
    *,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
    hold: Mapping[str, float] | None = None,
) -> tuple[Locus, ...]:
    """Curves of singular positions of a planar parallel robot, all that random starts lead to.

    Positions of both types are on both; those where curves that were not found otherwise only touch
    are left out.

    Parameters
    ----------
    model : Model
        A closed chain.
    kind : "first" or "second"
        "first": the tip loses a degree of freedom; "second": the drives lose control of the tip.
    frame, rows : optional
        Of the tip's motion, as for `input_output`.
    hold : {name: value}, optional
        Values that coordinates keep (rad, m), for mechanisms of more than two degrees of freedom:
        what is left must be a curve.

    Returns
    -------
    tuple of Locus

    Raises
    ------
    FreebodyError
        What is left is no curve.
    """
    require_loops(model, "singularity_loci")
    if kind not in ("first", "second"):
        raise UnknownNameError("kind", kind, "singularity_loci", ("first", "second"))
    problem = _problem(model, kind, frame, rows, dict(hold or {}))
    found: list[Locus] = []
    for seed in range(_SEEDS):
        start = problem.reached(generic_state(model, seed=seed)[0])
        if start is None or any(_on(model, locus, start) for locus in found):
            continue
        locus = problem.followed(start)
        if len(locus.q) > 1 or problem.isolated(start):
            found.append(locus)
    return tuple(found)


def _problem(
    model: Model,
    kind: Literal["first", "second"],
    frame: str | None,
    rows: Sequence[str] | None,
    hold: dict[str, float],
) -> _SingularPositions:
    assemble(model)  # refuses a mechanism that cannot be closed
    kept = list(independent_rows(model))
    driven = model.driven
    freedom = model.nv - len(kept)
    if len(driven) != freedom:
        raise FreebodyError(
            f"singularity_loci: {model.name!r} has {freedom} degrees of freedom and {len(driven)} "
            f"driven joints; name as many with model.replace(actuated=[...])."
        )
    held = [free_coordinates(model, (name,), "singularity_loci") for name in hold]
    if freedom - len(hold) not in (1, 2) or any(len(k) != 1 for k in held):
        spare = max(freedom - 2, 0)
        raise FreebodyError(
            f"singularity_loci: {model.name!r} has {freedom} degrees of freedom; hold {spare} "
            f"coordinate"
            f"{'' if spare == 1 else 's'} with hold={{name: value}}, so that a curve is left."
        )
    chosen = list(motion_rows(model, rows))[: freedom if rows is None else None]
    if len(chosen) != freedom:
        raise FreebodyError(
            f"singularity_loci: {len(chosen)} rows are chosen and {model.name!r} has {freedom} "
            f"degrees of freedom; these must be equal."
        )
    for name, value in hold.items():
        refuse_not_finite(
            "singularity_loci", f"hold[{name!r}]", as_floats("singularity_loci", name, value), 0
        )
    passive = np.setdiff1d(np.arange(model.nv), driven)
    size, rates = length(model), rate_scale(model)

    def second(q: Array) -> Array:
        return np.linalg.det(scaled_jacobian(model, q)[..., kept, :][..., passive])

    def first(q: Array) -> Array:
        J = jacobian(model, q, frame)[..., chosen, :] * rates
        J[..., [k for k, row in enumerate(chosen) if row < model.dim], :] /= size
        return np.linalg.det(np.concatenate([scaled_jacobian(model, q)[..., kept, :], J], axis=-2))

    measure = first if kind == "first" else second
    indices = [k[0] for k in held]
    return _SingularPositions(
        model, kind, measure, kept, indices, np.array([hold[name] for name in hold])
    )


@dataclass(frozen=True)
class _SingularPositions:
    """The equations of a singular position: closed loops (Φ = 0), a vanishing measure of
    singularity, and fixed coordinates."""

    model: Model
    kind: Literal["first", "second"]
    measure: _Measure
    kept: list[int]
    held: list[int]
    values: Array

    def left(self, q: Array) -> Array:
        """Residuals (m + 1 + h,) of these equations at q (nq,), scaled."""
        model = self.model
        phi = scaled_residual(model, q)[self.kept]
        off = (difference(model, neutral(model), q)[self.held] - self.values) / rate_scale(model)[
            self.held
        ]
        return np.concatenate([phi, [float(self.measure(q))], off])

    def slope(self, q: Array) -> Array:
        """Derivatives (m + 1 + h, nv) of the residuals along scaled rates."""
        model, n = self.model, self.model.nv
        steps = _DIFFERENCE * np.concatenate([np.eye(n), -np.eye(n)]) * rate_scale(model)
        values = self.measure(integrate(model, np.broadcast_to(q, (2 * n, model.nq)), steps))
        gradient = (values[:n] - values[n:]) / (2.0 * _DIFFERENCE)
        return np.vstack([scaled_jacobian(model, q)[self.kept], gradient, np.eye(n)[self.held]])

    def reached(self, q: Array, rounds: int = 40) -> Array | None:
        """The singular position that Newton's method finds from q; None where it finds none."""
        for _ in range(rounds):
            left = self.left(q)
            if np.abs(left).max() < 1e-11:
                return None if backward(self.model, q).any() else q
            step = -np.linalg.pinv(self.slope(q), rcond=1e-9) @ left
            longest = np.abs(step).max()
            q = integrate(
                self.model, q, step * min(1.0, 0.5 / max(longest, 1e-300)) * rate_scale(self.model)
            )
        return None

    def isolated(self, start: Array) -> bool:
        """Whether singular positions are isolated points rather than curves."""
        return self.model.nv == len(self.slope(start))

    def followed(self, start: Array) -> Locus:
        """The curve of singular positions through one of them, followed both ways."""
        if self.isolated(start):
            return Locus(self.kind, start[None], False)
        ahead, closed = self._one_way(start, 1.0)
        if closed:
            return Locus(self.kind, np.array([start, *ahead, start]), True)
        back, _ = self._one_way(start, -1.0)
        return Locus(self.kind, np.array([*back[::-1], start, *ahead]), False)

    def _one_way(self, start: Array, sense: float) -> tuple[list[Array], bool]:
        """(positions after the start along one way, whether they lead back to the start)."""
        model, rates = self.model, rate_scale(self.model)
        q, step, direction = start, _STEP, np.zeros(model.nv)
        done: list[Array] = []
        while len(done) < _MOST and step > 1e-3 * _STEP:
            tangent = np.linalg.svd(self.slope(q))[2][-1]
            tangent = tangent * (
                sense if not direction.any() else 1.0 if tangent @ direction > 0.0 else -1.0
            )
            there = self.reached(integrate(model, q, step * tangent * rates), rounds=8)
            if (
                there is None
                or np.linalg.norm(difference(model, q, there) / rates - step * tangent) > 0.5 * step
            ):
                step *= 0.5
                continue
            done.append(there)
            q, direction, step = there, tangent, min(_STEP, 1.5 * step)
            if len(done) > 5 and _apart(model, start, q[None])[0] < _STEP:
                return done, True
        return done, False


def _apart(model: Model, q: Array, others: Array) -> Array:
    """Distances (k,) from q (nq,) to others (k, nq) in angles, whole turns left out."""
    return np.linalg.norm(shortest_way(model, np.broadcast_to(q, others.shape), others), axis=-1)


def _on(model: Model, locus: Locus, q: Array) -> bool:
    return bool(_apart(model, q, locus.q).min() < _NEAR)
