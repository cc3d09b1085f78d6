"""`kinematic_diagram`: a robot with the names of its geometry, its vectors, its velocities or its
accelerations."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from os import PathLike

from freebody.errors import FreebodyError
from freebody.expressions.notations.notation import BookNotation
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.labelling import chosen_of, labels_of
from freebody.figures.layers import geometry, motion
from freebody.figures.layers.structure import Layer, drawn
from freebody.figures.snapshot import snapshot
from freebody.model.model import Model
from freebody.trees.public_calls import Vector

WIDE, TALL = 440.0, 420.0
"""Size of one drawing, pixels."""
_MOVING = ("velocities", "accelerations")
"""Views that show rates; the last shows accelerations, too."""
_BENT: tuple[Layer, ...] = (geometry.angles, geometry.slides)
_GEOMETRY: tuple[Layer, ...] = (*_BENT, geometry.centres)
VIEWS: dict[int, dict[str, tuple[Layer, ...]]] = {
    2: {
        "geometry": (*_GEOMETRY, geometry.all_lengths, geometry.of_the_ground),
        "vectors": (*_BENT, geometry.links, geometry.to_tip),
        "centres": (*_GEOMETRY, geometry.of_centres),
        "velocities": (*_GEOMETRY, motion.rates, motion.of_centres),
        "accelerations": (
            *_GEOMETRY, partial(motion.rates, second=True), partial(motion.of_centres, second=True)
        ),
    },
    3: {
        "frames": (geometry.axes, geometry.variables),
        "normals": (geometry.axes, geometry.normals),
        "vectors": (geometry.links, geometry.centres),
    },
}  # fmt: skip
"""What may be shown, by dimension, and of what layers it is made."""
_DEFAULT = {2: ("geometry", "vectors"), 3: ("frames", "normals")}


def kinematic_diagram(
    model: Model,
    q: Vector | None = None,
    show: str | Sequence[str] | None = None,
    qd: Vector | None = None,
    qdd: Vector | None = None,
    *,
    labels: str = "names",
    notation: str | PathLike[str] | BookNotation | None = None,
) -> Figure:
    """Drawings of a robot with symbols: geometry and vectors in the plane, joint axes and common
    normals in space.

    q: (nq,) rad or m; qd, qdd: (nv,); default: a state in which the robot is clearly visible.
    Parameters without value get typical values. show: one or several of "geometry" (θ_i, d_i, l_i,
    l_ci, C_i), "vectors" (s_i, r), "centres" (r_ci), "velocities" (rates, v_ci), "accelerations" in
    the plane; "frames" (z_i, of slides u_i, joint variables), "normals" (a_i, d_i), "vectors" (s_i,
    C_i) in space. labels: "names", "values" or "both". notation: whose letters stand in it,
    as for `check`. Returns a figure with `.svg`,
    `.save("arm.svg")` and `.named("s_1")`, the elements as data. Raises ShapeError, NotFiniteError,
    UnknownNameError, MissingValueError. Source: figures 1.2, 2.1, 3.2, 4.3, 5.3, 6.4, 6.5.
    """
    caller, known = "kinematic_diagram", VIEWS[model.dim]
    asked = _DEFAULT[model.dim] if show is None else show
    chosen = chosen_of(f"{caller} of a model in {model.dim}D", asked, known)
    if not chosen:
        raise FreebodyError(f"{caller}: show is empty; name one of {', '.join(known)}.")
    for argument, value, views in (("qd", qd, _MOVING), ("qdd", qdd, _MOVING[1:])):
        if value is not None and not set(views) & set(chosen):
            instead = "drawings in space show none; leave it out"
            instead = f"say show={views[0]!r}" if views[0] in known else instead
            shown = ", ".join(chosen)
            raise FreebodyError(f"{caller}: {argument} is not drawn in {shown}: {instead}.")
    how = labels_of(caller, model, labels)
    seen = snapshot(model, q, qd, qdd, None, caller, notation)
    drawings = tuple(drawn(seen, x, known[x], faint=x == "vectors") for x in chosen)
    for drawing in drawings:
        drawing.labels = how
    to_one_scale(drawings, WIDE, TALL)
    return Figure(f"Kinematic diagram of {model.name}", drawings, 2, WIDE, TALL, caller)
