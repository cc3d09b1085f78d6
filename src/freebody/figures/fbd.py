"""Free-body diagrams: each body alone, with every force and moment on it at one instant."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from freebody.errors import FreebodyError, UnknownNameError
from freebody.figures.body import PANEL, TALLEST, diagrams
from freebody.figures.drawing import Drawing
from freebody.figures.figure import save, sheet
from freebody.figures.loads import BodyLoads, body_loads
from freebody.figures.svg import picture
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.outputs.display import Titled
from freebody.trees.calls import Vector, Wrenches


@dataclass(frozen=True, eq=False, repr=False)
class FreeBodyDiagram(Titled):
    """The diagrams of one or of all bodies at one instant; shows itself in a notebook."""

    title: str
    bodies: tuple[BodyLoads, ...]
    drawings: tuple[Drawing, ...]
    """One a body, in their order."""

    def _title(self) -> str:
        return self.title

    @property
    def drawing(self) -> Drawing:
        """The only drawing; with several bodies take one of `drawings`."""
        if len(self.drawings) != 1:
            raise FreebodyError(
                f"{self.title}: it has {len(self.drawings)} drawings; take one of .drawings, or "
                f"name a body."
            )
        return self.drawings[0]

    @cached_property
    def svg(self) -> str:
        """SVG text that stands alone; several bodies stand in rows of two."""
        pictures = [picture(drawing, PANEL, TALLEST) for drawing in self.drawings]
        return sheet(pictures, self.title, level=0.0).text()

    def _repr_svg_(self) -> str:
        return self.svg

    def save(self, path: str | os.PathLike[str]) -> Path:
        """Write the SVG; the path."""
        return save(self.svg, path, "free_body_diagram")


def free_body_diagram(
    model: Model,
    q: Vector,
    body: str | int | None = None,
    qd: Vector | None = None,
    qdd: Vector | None = None,
    wrenches: Wrenches = None,
) -> FreeBodyDiagram:
    """Free-body diagram of a body (its name, its joint's or a link's; or its index from 0), or of
    all: forces to scale.

    q: (nq,) rad or m; qd, qdd: (nv,), default at rest; wrenches as for `inverse_dynamics`, acting
    on the arm. Returns a figure with `.svg`, `.save("fbd.svg")`, `.drawing` (the arrows as data)
    and `.bodies` (the loads and how well they balance). Raises ShapeError, NotFiniteError,
    UnknownNameError. Source: figures 1.4, 2.3, 3.2, 6.4.
    """
    loads = body_loads(model, q, qd, qdd, wrenches)
    chosen = loads if body is None else (loads[_index(model, body)],)
    title = f"Free-body diagram of {model.name}" + (
        "" if body is None else f": {chosen[0].body.name}"
    )
    return FreeBodyDiagram(title, chosen, diagrams(chosen, model.dim))


def _index(model: Model, body: str | int) -> int:
    if isinstance(body, int):
        if not 0 <= body < len(model.bodies):
            raise FreebodyError(
                f"free_body_diagram: body {body} of {model.name!r} is not there; it has bodies 0 "
                f"to "
                f"{len(model.bodies) - 1}."
            )
        return body
    if body in model.joint_names:
        return model.joint_names.index(body)
    names = [b.name for b in model.bodies]
    index = model.body_index(body) if body in (*names, *model.frame_names) else -1
    if index < 0:
        raise UnknownNameError("body", body, f"{model.name!r}", names)
    return index
