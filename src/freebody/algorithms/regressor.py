"""Inverse dynamics and energies as linear functions of a robot's inertial and drive parameters.

Their names and order are those of `model.inertial_parameters`.
"""

from __future__ import annotations

from freebody.algorithms.crba import own_inertia
from freebody.algorithms.kinematics import (
    BodyMotions,
    ancestors,
    columns_at_origin,
    outward,
    world_poses,
)
from freebody.algorithms.world_axes import dot_motion
from freebody.elementary import Scalar
from freebody.model.drives.acting import DriveScalars
from freebody.model.tree import Tree
from freebody.spatial import AnySpace, Matrix, Vector, add, dot, identity, neg, times, transposed


def regressor(tree: Tree, q: Vector, qd: Vector, qdd: Vector) -> Matrix:
    """Y with tau = Y π: nv rows; columns body by body, then drive by drive, in the model's
    order."""
    space = tree.space
    motion = outward(tree, q, qd, qdd, neg(tree.gravity))
    poses = world_poses(tree, motion.joints)
    S = columns_at_origin(tree, poses)
    columns: list[list[Scalar]] = []
    for i in tree.body_of:
        R, p = poses[i]
        for moment, force in _unit_wrenches(space, motion, i):
            f = times(R, force)
            wrench = (add(space.turn(R, moment), space.moment(p, f)), f)
            column: list[Scalar] = [0.0] * tree.nv
            for j in ancestors(tree, i):
                at = tree.bodies[j].coordinates
                for s, k in zip(S[j], at.v, strict=True):
                    column[k] = column[k] + at.slope(q) * dot_motion(s, wrench)
            columns.append(column)
    for drive in drives(tree):
        (k,), slope = drive.at.v, drive.at.slope(q)
        for torque in drive.unit_torques(q, qd, qdd):
            columns.append([slope * torque if k == row else 0.0 for row in range(tree.nv)])
    return transposed(tuple(tuple(column) for column in columns))


def energy_regressor(tree: Tree, q: Vector, qd: Vector) -> Matrix:
    """Two rows, kinetic and potential energy, as linear functions of the same parameters.

    The potential of a spring lacks its constant ½ k rest², that of gravity the constant of what is
    fixed to the base, whose parameters are not among them.
    """
    space = tree.space
    motion = outward(tree, q, qd, (0.0,) * tree.nv)
    kinetic: list[Scalar] = []
    potential: list[Scalar] = []
    poses = world_poses(tree, motion.joints)
    for i in tree.body_of:
        (R, p), w, v = poses[i], motion.w[i], motion.v[i]
        field = times(transposed(R), tree.gravity)
        kinetic += [
            0.5 * dot(v, v),
            *(dot(v, space.cross(w, unit)) for unit in identity(space.dim)),
        ]
        kinetic += [0.5 * dot(w, space.inertia_times(unit, w)) for unit in _unit_inertias(space)]
        potential += [
            -dot(tree.gravity, p),
            *(-g for g in field),
            *(0.0 for _ in _unit_inertias(space)),
        ]
    for drive in drives(tree):
        (rate,) = drive.at.rates(q, qd)
        kinetic += [0.5 * inertia * (rate * rate) for inertia in drive.unit_inertias()]
        potential += drive.unit_energies(q)
    return tuple(kinetic), tuple(potential)


def parameter_values(tree: Tree) -> list[Scalar]:
    """The inertial parameters π of the tree, in the regressors' order."""
    values: list[Scalar] = []
    for i in tree.body_of:
        m, h, inertia = own_inertia(tree.space, tree.bodies[i])
        I = tree.space.inertia_matrix(inertia)
        values += [m, *h, *(I[i][j] for i in range(len(I)) for j in range(i, len(I)))]
    for drive in drives(tree):
        values += drive.parameters()
    return values


def drives(tree: Tree) -> list[DriveScalars]:
    """The drives of the joints that have one, in the model's order."""
    found = (tree.bodies[i].drive for i in tree.body_of)
    return [drive for drive in found if drive is not None]


def _unit_inertias(space: AnySpace) -> list[Scalar]:
    """Inertias with one entry (and its mirror) 1 and the others 0."""
    if space.dim == 2:
        return [1.0]
    return [
        tuple(tuple(1.0 if {r, c} == {i, j} else 0.0 for c in range(3)) for r in range(3))
        for i in range(3)
        for j in range(i, 3)
    ]


def _unit_wrenches(space: AnySpace, motion: BodyMotions, i: int) -> list[tuple[Vector, Vector]]:
    """(moment, force) that each parameter of body i, being 1, needs; body axes, at its origin."""
    w, wd, vd, rates = motion.w[i], motion.wd[i], motion.vd[i], motion.rates[i]
    result = [(space.zero_angular, vd)]
    result += [(space.moment(unit, vd), times(rates, unit)) for unit in identity(space.dim)]
    result += [(space.euler(unit, w, wd), space.zero) for unit in _unit_inertias(space)]
    return result
