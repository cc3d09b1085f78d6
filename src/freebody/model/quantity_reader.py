"""Readers of quantities, which turn those of a model into scalars: into values here, in other ways
elsewhere."""

from __future__ import annotations

import math
from collections.abc import Sequence
from math import prod

import numpy as np

from freebody.elementary import Scalar
from freebody.errors import ModelError
from freebody.model.families import Members, NamedNumber
from freebody.model.parameter_formulas import FollowingParameter
from freebody.model.parameters import Parameter, ParameterProduct, Quantity
from freebody.spatial import Matrix, Vector

EXACT = 1e-12
"""Angles (rad) this close to a multiple of a right angle are that multiple."""


class QuantityReader:
    """A reader that takes numbers as they are and parameters as their values; subclasses may read
    them differently."""

    combines = True
    """Whether the inertias of links that are lumped may be added up as numbers."""

    def quantity(self, q: Quantity) -> Scalar:
        """The scalar of a number or parameter; for a family an array of its shape."""
        kind = type(q)
        if kind is float or kind is NamedNumber:  # most are
            return q
        if isinstance(q, Parameter):
            if q.value is None:
                if isinstance(q, FollowingParameter) and q.formula:
                    return q.formula.value(self.quantity)
                raise ModelError(f"parameter {q.name!r} has no value.")
            return q.value.array if isinstance(q.value, Members) else q.value
        if isinstance(q, Members):
            return q.array
        return prod(map(self.quantity, q.factors)) if isinstance(q, ParameterProduct) else q

    def quantities(self, qs: Sequence[Quantity]) -> Sequence[Scalar]:
        """Scalars of several quantities."""
        return [*map(self.quantity, qs)]

    def sin_cos(self, angle: Quantity) -> tuple[Scalar, Scalar]:
        """Sine and cosine of a constant angle."""
        if angle == 0.0:  # most are
            return 0.0, 1.0
        read = self.quantity(angle)
        return _exact_each(read) if isinstance(read, np.ndarray) else exact_sin_cos(read)

    def rotation(self, matrix: Matrix) -> Matrix:
        """A constant rotation matrix."""
        return matrix

    def axis(self, axis: Vector) -> Vector:
        """The constant unit axis of a joint."""
        return axis


class Values(QuantityReader):
    """A reader that takes numbers as they are, which most are, and parameters as their values."""

    def quantities(self, qs: Sequence[Quantity]) -> Sequence[Scalar]:
        if {*map(type, qs)} <= _NUMBERS:
            return qs
        return super().quantities(qs)


_NUMBERS = {float, NamedNumber}

VALUES = Values()


def exact_sin_cos(angle: float, tolerance: float = EXACT) -> tuple[float, float]:
    """Sine and cosine of an angle, exactly 0 and ±1 within `tolerance` (rad) of a multiple of π/2;
    as computed where the tolerance is 0."""
    if angle == 0.0:  # most are
        return 0.0, 1.0
    quarter = round(angle / (math.pi / 2))
    if tolerance > 0.0 and abs(angle - quarter * (math.pi / 2)) <= tolerance:
        return ((0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0))[quarter % 4]
    return math.sin(angle), math.cos(angle)


def _exact_each(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of an angle for each member of a family, as of `exact_sin_cos`."""
    quarter = np.round(angles / (math.pi / 2))
    right = np.abs(angles - quarter * (math.pi / 2)) <= EXACT
    table = np.array([(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)])[quarter.astype(int) % 4]
    return np.where(right, table[..., 0], np.sin(angles)), np.where(
        right, table[..., 1], np.cos(angles)
    )
