"""An inverse kinematics problem, and what was found for it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from freebody.arrays import Array
from freebody.inverse.numerical_solver import NumericalSolver
from freebody.inverse.solutions import Verified
from freebody.trees.states import neutral


@dataclass(frozen=True, eq=False)
class Problem:
    """What was asked for: targets (N, …) of a frame and task."""

    solver: NumericalSolver
    target: Array
    q0: Array | None
    limits: str
    starts: int | None
    seed: int

    @property
    def reference(self) -> Array:
        """q (nq,) next to which angles are wrapped: q0, else the middle of the limits, else 0."""
        if self.q0 is not None:
            return self.q0
        low, high = self.solver.bounds
        both = np.isfinite(low) & np.isfinite(high)
        middle = neutral(self.solver.model)
        middle[both] = (low[both] + high[both]) / 2
        return np.clip(middle, low, high)


@dataclass(frozen=True, eq=False)
class Found:
    """Per target its solutions and their branches; the method, and notes."""

    solutions: list[Verified]
    branches: list[list[str]]
    method: str
    notes: list[str]
