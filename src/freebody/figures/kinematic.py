"""`kinematic_diagram`: a robot with the names of its geometry, its vectors, its velocities or its
accelerations."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from functools import partial

from freebody.errors import FreebodyError, UnknownNameError
from freebody.figures.drawing import Drawing
from freebody.figures.figure import Figure, to_one_scale
from freebody.figures.names import Names, names_of
from freebody.figures.sketch import arm, frames, motion, vectors
from freebody.figures.sketch.snapshot import Snapshot, snapshot
from freebody.model.model import Model
from freebody.trees.calls import Vector

Layer = Callable[[Drawing, Snapshot, Names], None]
WIDE, TALL = 440.0, 420.0
"""Size of one drawing, pixels."""

_GEOMETRY: tuple[Layer, ...] = (arm.angles, arm.slides, arm.centres)
_BENT: tuple[Layer, ...] = (arm.angles, arm.slides)
PLANE: dict[str, tuple[Layer, ...]] = {
    "geometry": (*_GEOMETRY, arm.all_lengths),
    "vectors": (*_BENT, vectors.links, lambda drawing, seen, names: vectors.to_tip(drawing, seen)),
    "centres": (*_GEOMETRY, vectors.of_centres),
    "velocities": (*_GEOMETRY, motion.rates, motion.of_centres),
    "accelerations": (*_GEOMETRY, partial(motion.rates, second=True), motion.second_of_centres),
}
"""What a drawing of a planar arm may show, and of what layers it is made."""
SPACE: dict[str, tuple[Layer, ...]] = {
    "frames": (frames.joint_axes, frames.variables),
    "normals": (frames.joint_axes, frames.normals),
    "vectors": (frames.links, frames.centres),
}
"""The same of a robot in space."""


def kinematic_diagram(
    model: Model,
    q: Vector | None = None,
    show: str | Sequence[str] | None = None,
    qd: Vector | None = None,
    qdd: Vector | None = None,
) -> Figure:
    """Drawings of a robot with symbols: geometry and vectors in the plane, joint axes and common
    normals in space.

    q: (nq,) rad or m; qd, qdd: (nv,); default: a state that is seen well. Parameters without value
    get one that is. show: one or several of "geometry" (θ_i, d_i, l_i, l_ci, C_i), "vectors" (s_i,
    r), "centres" (r_ci), "velocities" (rates, v_ci), "accelerations" in the plane; "frames" (z_i,
    of slides u_i, joint variables), "normals" (a_i, d_i), "vectors" (s_i, C_i) in space. Returns a
    figure with `.svg`, `.save("arm.svg")` and `.named("s_1")`, the elements as data. Raises
    ShapeError, NotFiniteError, UnknownNameError. Source: figures 1.2, 2.1, 3.2, 4.3, 5.3, 6.4, 6.5.
    """
    known = PLANE if model.dim == 2 else SPACE
    default = ("geometry", "vectors") if model.dim == 2 else ("frames", "normals")
    chosen = default if show is None else (show,) if isinstance(show, str) else tuple(show)
    for name in chosen:
        if name not in known:
            raise UnknownNameError(
                "view", name, f"kinematic_diagram of a model in {model.dim}D", known
            )
    if not chosen:
        raise FreebodyError(f"kinematic_diagram: show is empty; name one of {', '.join(known)}.")
    _require_drawn("qd", qd, ("velocities", "accelerations"), chosen, known)
    _require_drawn("qdd", qdd, ("accelerations",), chosen, known)
    seen = snapshot(model, q, qd, qdd)
    names = names_of(seen.model)
    drawings = tuple(view(seen, name, names) for name in chosen)
    to_one_scale(drawings, WIDE, TALL)
    return Figure(f"Kinematic diagram of {model.name}", drawings, 2, WIDE, TALL)


def _require_drawn(
    argument: str,
    value: Vector | None,
    views: Sequence[str],
    chosen: Sequence[str],
    known: Collection[str],
) -> None:
    """Refuse rates that none of the drawings asked for would show."""
    if value is None or set(views) & set(chosen):
        return
    possible = [name for name in views if name in known]
    instead = (
        f"say show={possible[0]!r}" if possible else "drawings in space show none; leave it out"
    )
    raise FreebodyError(
        f"kinematic_diagram: {argument} is not drawn in {', '.join(chosen)}: {instead}."
    )


def view(seen: Snapshot, show: str, names: Names) -> Drawing:
    """One of the drawings of `PLANE` or `SPACE`."""
    title = f"{seen.model.name}: {show}"
    if seen.model.dim == 2:
        drawing, layers = arm.blank(title), PLANE[show]
        arm.structure(drawing, seen, names, faint=show == "vectors")
    else:
        drawing, layers = frames.blank(title, frames.viewed(seen)), SPACE[show]
        frames.structure(drawing, seen)
    for layer in layers:
        layer(drawing, seen, names)
    return drawing
