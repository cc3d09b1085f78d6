"""The mobility of a mechanism: counted (Grübler), at one position (instantaneous), and in general
(generic)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.loops.equations import require_closed, scaled_jacobian, taken_at
from freebody.loops.independent_equations import (
    RANK_WHERE_FOUND,
    dependent_rows,
    rank,
    regular_jacobian,
)
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import null_space, row_names
from freebody.model.model import Model
from freebody.outputs.display import InWords, counted
from freebody.trees.public_calls import JointVector, finite_vector
from freebody.values import ByValue


@dataclass(frozen=True, eq=False, repr=False)
class Mobility(InWords, ByValue):
    """Degrees of freedom of a closed chain, and where its equations depend on one another."""

    model: str
    instantaneous: int
    """nv - rank Φ_q at this position: motions that no equation forbids at once."""
    generic: int
    """nv - rank Φ_q at nearby positions that can be reached: finite motions."""
    gruebler: int
    """nv - number of equations: the count that takes all equations as independent."""
    equations: int
    rank: int
    """Rank of Φ_q at positions in general."""
    redundant: tuple[str, ...]
    """Equations that follow from those before them, in general: without them the mechanism moves
    the same."""
    independent: tuple[str, ...]
    """A well-conditioned choice of coordinates that determine the others here; driven joints are
    preferred."""
    misfit: tuple[float, float] = (0.0, 0.0)
    """(m, rad): how far rounded numbers keep the redundant equations from holding, at most, where
    that was looked at; 0 where they hold but for rounding in the computation."""

    def _title(self) -> str:
        return (
            f"Mobility of {self.model!r}: {counted(self.generic, 'degree')} of freedom, "
            f"{self.instantaneous} instantaneous at this position"
        )

    @property
    def singular(self) -> bool:
        """Whether the mechanism has more freedom at this position than in general."""
        return self.instantaneous > self.generic

    @property
    def _misfit(self) -> str:
        metres, radians = self.misfit
        parts = [f"{metres:.2g} m"] * (metres > 0.0) + [f"{radians:.2g} rad"] * (radians > 0.0)
        return (
            f"; numbers are rounded, and leave them open by up to {' and '.join(parts)}"
            if parts
            else ""
        )

    def __str__(self) -> str:
        lines = [
            f"{self.model}: {self.generic} degree{'s' if self.generic != 1 else ''} of freedom "
            f"(Grübler {self.gruebler}, instantaneous {self.instantaneous})",
            f"  {self.equations} loop equations, rank {self.rank}",
            f"  redundant: {', '.join(self.redundant) or 'none'}{self._misfit}",
            f"  independent coordinates: {', '.join(self.independent) or 'none'}",
        ]
        if self.singular:
            lines.append(
                "  singular position: more motions are possible instantaneously than in general"
            )
        return "\n".join(lines)


def mobility(model: Model, q: JointVector) -> Mobility:
    """Mobility at the closed position q (nq,), and in general: at positions reached from it by
    finite motions.

    A mechanism without loops has nv everywhere. Generic mobility is found by following short
    motions in many directions; where none is possible, it is 0. Raises LoopError when q is not
    closed.
    """
    at = finite_vector("mobility", model, "q", q)
    if at.shape != (model.nq,):
        raise FreebodyError(
            f"mobility: q has shape {at.shape}, expected ({model.nq},): one position."
        )
    if not model.loops:
        n = model.nv
        return Mobility(model.name, n, n, n, 0, 0, (), model.velocity_names)
    model = taken_at(model, at)
    require_closed("mobility", model, at)
    here, _ = null_space(scaled_jacobian(model, at), RANK_WHERE_FOUND)
    regular, moves = regular_jacobian(model, at)
    finite = model.nv - rank(regular) if moves else 0
    names, known = row_names(model), redundancy(model)
    rounded = known.rank is not None
    redundant = (
        sorted(set(range(len(names))) - set(known.rows)) if rounded else dependent_rows(regular)
    )
    return Mobility(
        model.name,
        here.shape[1],
        finite,
        model.nv - len(names),
        len(names),
        rank(regular),
        tuple(names[k] for k in redundant),
        independent_coordinates(model, here),
        known.misfit,
    )


def independent_coordinates(model: Model, directions: Array) -> tuple[str, ...]:
    """Names of coordinates whose rates determine all others: rows of the null space (nv, f), chosen
    by pivoting."""
    names = model.velocity_names
    driven = model.driven if model.passive else ()
    # a driven joint wins over a passive one that would do little better
    left = (
        directions
        * np.array([1.0 if k in driven or not driven else 0.1 for k in range(model.nv)])[:, None]
    )
    chosen: list[int] = []
    for _ in range(directions.shape[1]):
        sizes = np.linalg.norm(left, axis=1)
        k = int(np.argmax(sizes.round(9)))  # ties go to the first
        chosen.append(k)
        unit = left[k] / sizes[k]
        left = left - np.outer(left @ unit, unit)
    return tuple(names[k] for k in sorted(chosen))
