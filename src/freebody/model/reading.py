"""How the quantities of a model become scalars: as values here, in other ways by readers elsewhere."""

from __future__ import annotations

import math

from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.model.parameters import Parameter, Quantity
from freebody.spatial import Matrix, Vector

EXACT = 1e-12
"""Angles (rad) this close to a multiple of a right angle are that multiple."""


class Reader:
    """Reads numbers as they are and parameters as their values; a subclass may read them as anything else."""

    combines = True
    """Whether the inertias of links that are lumped may be added up as numbers."""

    def quantity(self, q: Quantity) -> Scalar:
        """The scalar of a number or parameter."""
        if isinstance(q, Parameter):
            if q.value is None:
                raise ModelError(f"parameter {q.name!r} has no value.")
            return q.value
        return q

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        """Sine and cosine of a constant angle."""
        return exact_sin_cos(self.quantity(angle))

    def rotation(self, matrix: Matrix) -> Matrix:
        """A constant rotation matrix."""
        return matrix

    def axis(self, axis: Vector) -> Vector:
        """The constant unit axis of a joint."""
        return axis


VALUES = Reader()


def exact_sin_cos(angle: float, tolerance: float = EXACT) -> tuple[float, float]:
    """sin and cos, exactly 0 and ±1 within `tolerance` (rad) of a multiple of π/2; with 0 as computed."""
    quarter = round(angle / (math.pi / 2))
    if tolerance > 0.0 and abs(angle - quarter * (math.pi / 2)) <= tolerance:
        return ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0))[quarter % 4]
    return math.sin(angle), math.cos(angle)
