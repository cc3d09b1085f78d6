"""Formulas of operational space, and of momentum as a function of the rates."""

from __future__ import annotations

from functools import partial
from typing import Any

from freebody.algorithms.operational_space import (
    centroidal_momentum_matrix,
    operational_space,
    where_sure,
)
from freebody.kernels.formulas.record import Formula, Option, frame_of, one
from freebody.model.doubts import INERTIAL
from freebody.model.tree import Tree
from freebody.spatial import Matrix, Vector


def _sure(t: Tree, o: Option, q: Vector, values: Vector | Matrix) -> tuple[Any]:
    return (where_sure(t, q, frame_of(o), o.rows, values),)


_along_rows = partial(Formula, of_frame=True, of_rows=True, free_rows=True, chains="open")

FORMULAS = {
    "operational_space_inertia": _along_rows(
        ("q",),
        one(
            "Lambda",
            ("rows", "rows"),
            "inertia of the motion of the frame; NaN next to a singularity (kg, kg m, kg m^2)",
        ),
        lambda t, o, q: _sure(t, o, q, operational_space(t, q, None, frame_of(o), o.rows)[0]),
    ),
    "operational_space_bias": _along_rows(
        ("q", "qd"),
        one(
            "mu",
            ("rows",),
            "bias of the motion of the frame: force, then moment; NaN as Lambda (N, N m)",
        ),
        lambda t, o, q, qd: _sure(t, o, q, operational_space(t, q, qd, frame_of(o), o.rows)[1]),
        lossless=True,
    ),
    "centroidal_momentum_matrix": Formula(
        ("q",),
        one(
            "A",
            ("six", "nv"),
            "factors of the rates in the momentum about the centre of mass (kg m, kg m^2)",
        ),
        lambda t, o, q: (centroidal_momentum_matrix(t, q),),
        touches=INERTIAL,
    ),
}
