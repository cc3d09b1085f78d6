"""Parallel robots: the relation between the tip's motion and the driven joints (2.35-2.40), and
where it is singular."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from freebody.algorithms.singular_thresholds import LOST_MOTION, RANK
from freebody.arrays import Array
from freebody.by_value import ByValue
from freebody.errors import FreebodyError
from freebody.kernels.formula_variants import motion_rows
from freebody.loops.closure_checks import (
    driven_coordinates,
    require_closed,
    require_loops,
    scaled_jacobian,
    taken_at,
)
from freebody.loops.scaled_equations import length, null_space, rate_scale
from freebody.model.model import Model
from freebody.outputs.display import Titled
from freebody.trees.kinematics import jacobian
from freebody.trees.public_calls import JointVector, finite_vector


@dataclass(frozen=True, eq=False, repr=False)
class InputOutput(Titled, ByValue):
    """The relation J_a ẋ + J_b θ̇ = 0 between the tip's motion ẋ (r,) and the driven rates θ̇ (r,)
    at one position.

    The equations are combined and scaled so that [J_a J_b] has orthonormal rows over angular rates;
    `first`, `second` are the smallest singular values of J_b and J_a then: 0 at a singular position
    of that type.
    """

    J_a: Array
    J_b: Array
    driven: tuple[str, ...]
    rows: tuple[str, ...]
    first: float
    """Type 1, 0 where J_b is singular: the tip loses a motion though the drives may turn; limits of
    the workspace."""
    second: float
    """Type 2, 0 where J_a is singular: the tip gives way though the drives stand still."""

    def _title(self) -> str:
        return (
            f"Input and output: {', '.join(self.rows)} by {', '.join(self.driven)}; "
            f"singular values {self.first:.3g} (first type), {self.second:.3g} (second)"
        )

    @property
    def J(self) -> Array:
        """The Jacobian J = -J_a⁻¹ J_b (2.36), with ẋ = J θ̇. Raises an error at a singular position
        of the second type."""
        if self.second < RANK:
            raise FreebodyError(
                "J = -J_a⁻¹ J_b does not exist at a singular position of the second type: the tip "
                "moves though the driven joints stand still."
            )
        return -np.linalg.solve(self.J_a, self.J_b).astype(float, copy=False)

    @property
    def kind(self) -> str:
        """ "regular", or the type of the singular position: "first", "second" or "third" (both)."""
        first, second = self.first < LOST_MOTION, self.second < LOST_MOTION
        return (
            "third" if first and second else "first" if first else "second" if second else "regular"
        )


def input_output(
    model: Model,
    q: JointVector,
    *,
    frame: str | None = None,
    rows: Sequence[str] | None = None,
    actuated: Sequence[str] | None = None,
) -> InputOutput:
    """J_a and J_b of a parallel robot at a closed position: how its tip moves with its driven
    joints (2.35)-(2.40).

    Parameters
    ----------
    model : Model
        A closed chain.
    q : (nq,)
        Closed position, rad and m.
    frame : str, optional
        The tip.
    rows : names, optional
        Of its motion, among "vx", "vy", "vz", "wx", "wy", "wz" (plane "vx", "vy", "w"), as many as
        there are driven joints and degrees of freedom; default the first ones.
    actuated : names, optional
        Driven joints; default those not passive.

    Returns
    -------
    InputOutput

    Raises
    ------
    LoopError
        The loops are open at q.
    FreebodyError
        The numbers of rows, drives and degrees of freedom do not match.

    References
    ----------
    Gosselin, Angeles 1990.
    """
    require_loops(model, "input_output")
    at = finite_vector("input_output", model, "q", q)
    if at.shape != (model.nq,):
        raise FreebodyError(
            f"input_output: q has shape {at.shape}, expected ({model.nq},): one position."
        )
    model = taken_at(model, at)
    require_closed("input_output", model, at)
    driven = list(driven_coordinates("input_output", model, actuated))
    chosen = motion_rows(model, rows)
    chosen = chosen[: len(driven)] if rows is None else chosen
    N, _ = null_space(scaled_jacobian(model, at), RANK)
    if len(chosen) != len(driven):
        raise FreebodyError(
            f"input_output: {len(driven)} joints are driven and {len(chosen)} rows chosen; these "
            f"must be equal."
        )
    names = ("vx", "vy", "vz", "wx", "wy", "wz") if model.dim == 3 else ("vx", "vy", "w")
    unit = np.array([length(model) if names[k][0] == "v" else 1.0 for k in chosen])
    rates = rate_scale(model)
    tip = jacobian(model, at, frame)[list(chosen)] * rates / unit[:, None]
    # all (ẋ, θ̇) that the loops allow, and what is orthogonal to them: the equations between ẋ and
    # θ̇
    allowed = np.vstack([tip @ N, N[driven]])
    U, s, _ = np.linalg.svd(allowed)
    freedom = int((s > RANK).sum())
    n = len(driven)
    if freedom != n:
        raise FreebodyError(
            f"input_output: {n} joints are driven, but they and the {n} rows move in {freedom} "
            f"ways; drive as many "
            "joints, and choose as many rows, as the mechanism has degrees of freedom."
        )
    equations = U[:, freedom:].T
    smallest = [
        float(np.linalg.svd(part, compute_uv=False)[-1])
        for part in (equations[:, n:], equations[:, :n])
    ]
    return InputOutput(
        equations[:, :n] / unit,
        equations[:, n:] / rates[driven],
        tuple(model.velocity_names[k] for k in driven),
        tuple(names[k] for k in chosen),
        *smallest,
    )
