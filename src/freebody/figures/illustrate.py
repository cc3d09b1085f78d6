"""The drawings of a derivation: an arm with its names, and beside the steps the vectors, velocities and free bodies."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from freebody.derivations import derive as plain
from freebody.derivations.derivation import Derivation, Drawings
from freebody.figures import theme
from freebody.figures.drawing import Drawing
from freebody.figures.figure import save
from freebody.figures.kinematic import view
from freebody.figures.sketch import arm, forces, frames, space_forces, vectors
from freebody.figures.sketch.names import Names
from freebody.figures.sketch.snapshot import Snapshot, snapshot, with_values
from freebody.figures.svg import picture
from freebody.model.model import Model

WIDE, TALL = 460.0, 400.0
_DARK = "@media screen and (prefers-color-scheme:dark)"
_LOAD = {2: (0.85, -0.53), 3: (0.5, -0.65, -0.6)}
"""Direction of the load on the tip in drawings."""


@wraps(plain.derive)
def derive(model: Model, method: str = "newton-euler", **options: Any) -> Derivation:
    """A derivation that draws what it speaks of where it is shown as a page or in a notebook."""
    return replace(plain.derive(model, method, **options), draw=drawings)


def drawings(derivation: Derivation) -> Drawings:
    """SVG text for "overview" and for every figure that a step asks for and that can be drawn."""
    found = {name: picture(d, WIDE, TALL).inline() for name, d in illustrations(derivation).items()}
    return Drawings(found, theme.style(_DARK))


def write_drawings(derivation: Derivation, document: Path) -> dict[str, str]:
    """Each drawing as an SVG file beside a document; the files' names by figure, for `Derivation.markdown`."""
    names = {}
    for name, drawing in illustrations(derivation).items():
        target = document.with_name(f"{document.stem}-{name.replace(' ', '-')}.svg")
        save(picture(drawing, WIDE, TALL).text(), target, "a drawing")
        names[name] = target.name
    return names


def illustrations(derivation: Derivation) -> dict[str, Drawing]:
    """The same as data."""
    seen, names = _shown(derivation), _names(derivation)
    wanted = ["overview", *(step.figure for step in derivation.steps if step.figure)]
    found = {name: _drawn(seen, names, name) for name in dict.fromkeys(wanted)}
    return {name: drawing for name, drawing in found.items() if drawing is not None}


def _names(derivation: Derivation) -> Names:
    """As the equations call things: the recursion has one moment a joint."""
    planar = derivation.equations.symbols.model.dim == 2
    moment = "" if derivation.method != "recursive" else "M" if planar else "n"
    return Names(moment=moment, slide="u")


def _shown(derivation: Derivation) -> Snapshot:
    """A state that is seen well: moving, or at rest; under a load on the tip if the equations have one."""
    symbols = derivation.equations.symbols
    model = with_values(symbols.model)
    still = np.zeros(model.nv) if derivation.method == "statics" else None
    return snapshot(model, None, still, still, _tip_load(model) if "fx" in symbols.extra else None)


def _tip_load(model: Model) -> list[float]:
    """A force on the tip of a good part of the robot's weight, or of 10 N where there is none."""
    size = 0.6 * model.mass * float(np.linalg.norm(model.gravity)) or 10.0
    return [*(size * x for x in _LOAD[model.dim]), *[0.0] * (1 if model.dim == 2 else 3)]


def _drawn(seen: Snapshot, names: Names, name: str) -> Drawing | None:
    """The drawing that a step calls by its name; None where there is none of this robot."""
    cut = re.fullmatch(r"(free-body|carried) (\d+)", name)
    if cut:
        body = seen.pose.bodies[int(cut[2]) - 1]
        if seen.model.dim == 2:
            return (forces.alone if cut[1] == "free-body" else forces.carried)(seen, body, names)
        view_of_all = frames.viewed(seen)
        return space_forces.alone(seen, body, names, view_of_all) if cut[1] == "free-body" else None
    draw = (_PLANE if seen.model.dim == 2 else _SPACE).get(name)
    return draw(seen, names) if draw else None


def _overview(seen: Snapshot, names: Names) -> Drawing:
    drawing = view(seen, "geometry", names)
    if seen.wrenches is not None:
        loaded = seen.pose.bodies[seen.model.frame().body]
        forces.act(drawing, seen, loaded, names, ("external",))
    return _noted(drawing, "Coordinates, lengths and centres of mass")


def _vectors(seen: Snapshot, names: Names) -> Drawing:
    drawing = arm.blank(f"{seen.model.name}: vectors")
    arm.structure(drawing, seen, names)
    arm.centres(drawing, seen, names)
    vectors.links(drawing, seen, names, vectors.BESIDE)
    vectors.to_centres(drawing, seen, names)
    vectors.directions(drawing, seen, names)
    return _noted(drawing, "The vectors, drawn beside the bodies they lie on")


def _noted(drawing: Drawing, note: str) -> Drawing:
    drawing.notes = [note]
    return drawing


def _view(show: str, note: str) -> Callable[[Snapshot, Names], Drawing]:
    return lambda seen, names: _noted(view(seen, show, names), note)


_PLANE: dict[str, Callable[[Snapshot, Names], Drawing]] = {
    "overview": _overview,
    "vectors": _vectors,
    "centres": _view("centres", "Where the centres of mass are"),
    "velocities": _view("velocities", "Joint rates and velocities of the centres of mass"),
    "accelerations": _view("accelerations", "Joint accelerations and accelerations of the centres of mass"),
}
_SPACE: dict[str, Callable[[Snapshot, Names], Drawing]] = {
    "overview": _view("frames", "Joint axes and joint variables"),
    "vectors": _view("vectors", "Vectors from joint to joint, and centres of mass"),
}
