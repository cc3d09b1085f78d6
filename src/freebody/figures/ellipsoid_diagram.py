"""`ellipsoid_diagram`: a robot with the velocity and force ellipsoids at its tip."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.figures.drawing import Drawing
from freebody.figures.figure import Figure, of_one
from freebody.figures.layers.bare_robot import drawn
from freebody.figures.snapshot import snapshot
from freebody.figures.view import View
from freebody.model.model import Model
from freebody.reach.ellipsoids import Ellipsoids, ellipsoids
from freebody.trees.kinematics import forward_kinematics
from freebody.trees.public_calls import JointVector

_SHARE = 0.3  # of the robot's size: the longest half-axis
_SLIM = 1e-3  # of the largest singular value: forces along smaller ones do not fit on a page


def ellipsoid_diagram(
    model: Model, q: JointVector | None = None, frame: str | None = None
) -> Figure:
    """A robot with the ellipsoids of its tip's velocities and forces, and their axes.

    q: (nq,); default: a pose in which the robot is clearly visible. frame: name, default the tip.
    The ellipsoids are those of `fb.ellipsoids`, each to a scale of its own, which a bar below
    gives. `.named("velocity axis 1")` is an axis, its value in m/s for joint rates of length 1,
    `.named("force axis 1")` in N for joint torques of length 1. Forces next to a singular posture
    are left out, with a note. Open chains. Raises ShapeError, NotFiniteError, UnknownNameError.
    """
    caller = "ellipsoid_diagram"
    model.require_tree(caller)
    seen = snapshot(model, q, caller=caller)
    found = ellipsoids(seen.model, seen.q, frame)
    at = np.asarray(forward_kinematics(seen.model, seen.q, found.frame))[: model.dim, model.dim]
    drawing = drawn(seen, f"ellipsoids of {found.frame}")
    reach = _SHARE * seen.size
    sizes = found.singular_values
    if sizes[0] > 0.0:
        _ellipsoid(drawing, at, found.velocity, reach, ("velocity", "velocity", "m/s"))
    drawing.notes.append("velocities at joint rates of length 1")
    if sizes[-1] > _SLIM * sizes[0]:
        _ellipsoid(drawing, at, found.force, reach, ("force", "external", "N"))
        drawing.notes.append("forces at joint torques of length 1")
    else:
        drawing.notes.append(_without_forces(found))
    return of_one(f"{model.name}: ellipsoids at {found.frame}", drawing, caller)


def _without_forces(found: Ellipsoids) -> str:
    sizes = found.singular_values
    if sizes[-1] == 0.0:
        return "singular: some directions of force load no joint, and forces are not drawn"
    return "next to singular: forces are too unlike to be drawn"


def _ellipsoid(
    drawing: Drawing, at: Array, axes: Array, reach: float, what: tuple[str, str, str]
) -> None:
    """Draw an ellipsoid: its outline and its half-axes, the longest `reach` metres long."""
    name, role, unit = what
    longest = float(np.linalg.norm(axes, axis=-1).max())
    drawn_axes = axes * (reach / longest)
    drawing.line(at + outline(drawn_axes, drawing.view), name, role, closed=True)
    for k, (axis, value) in enumerate(zip(drawn_axes, axes, strict=True), start=1):
        if np.linalg.norm(axis) > 1e-6 * reach:
            drawing.arrow(at, at + axis, f"{name} axis {k}", role, value, unit, label="")
    drawing.ruler(longest, reach, unit, role)


def outline(axes: Array, view: View) -> Array:
    """72 points (72, dim) around 0 on an ellipse, or on the visible outline of an ellipsoid.

    The point A n, with A the axes as columns and n a unit vector, is on the rim where the normal
    there, along A⁻ᵀ n, is at right angles to the line of sight t: n ⊥ adj(A) t.
    """
    angles = np.linspace(0.0, 2 * np.pi, 73)[:-1]
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    if axes.shape[-1] == 2:
        return circle @ axes
    a, b, c = axes
    sight = np.array([np.cross(b, c), np.cross(c, a), np.cross(a, b)]) @ np.asarray(view.towards)
    if not np.linalg.norm(sight) > 1e-12 * np.linalg.norm(axes) ** 2:
        sight = np.array([0.0, 0.0, 1.0])  # flat, and seen from its edge
    plane = np.linalg.svd(sight[None])[2][1:]
    return circle @ plane @ axes
