"""The drawings of a derivation: an arm with its names, and beside the steps the vectors, velocities
and free bodies."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace
from functools import wraps
from pathlib import Path
from typing import Any

import numpy as np

from freebody.derivations import derive as plain
from freebody.derivations.derivation import Derivation, Drawings, Step
from freebody.derivations.expression import Expression, Symbol, nodes
from freebody.derivations.methods import METHODS
from freebody.derivations.names import vec
from freebody.figures import theme
from freebody.figures.drawing import Drawing, Element, canonical
from freebody.figures.figure import save
from freebody.figures.kinematic import view
from freebody.figures.loads import label
from freebody.figures.names import Names, names_of
from freebody.figures.sketch import arm, forces, frames, motion, space_forces, vectors
from freebody.figures.sketch.snapshot import Snapshot, resting_pose, snapshot, with_values
from freebody.figures.svg import picture
from freebody.model.model import Model

WIDE, TALL = 460.0, 400.0
_DARK = "@media screen and (prefers-color-scheme:dark)"
_LOAD = {2: (0.85, -0.53), 3: (0.5, -0.65, -0.6)}
"""Direction of the load on the tip in drawings."""


@wraps(plain.derive)
def derive(model: Model, method: str | None = None, **options: Any) -> Derivation:
    """A derivation that draws what it speaks of where it is shown as a page or in a notebook."""
    return replace(plain.derive(model, method, **options), draw=drawings)


def drawings(derivation: Derivation) -> Drawings:
    """SVG text for "overview" and for every figure that a step asks for and that can be drawn."""
    found = {name: picture(d, WIDE, TALL).inline() for name, d in illustrations(derivation).items()}
    return Drawings(found, theme.style(_DARK))


def write_drawings(derivation: Derivation, document: Path) -> dict[str, str]:
    """Each drawing as an SVG file beside a document; the files' names by figure, for
    `Derivation.markdown`."""
    names = {}
    for name, drawing in illustrations(derivation).items():
        target = document.with_name(f"{document.stem}-{name.replace(' ', '-')}.svg")
        save(picture(drawing, WIDE, TALL).text(), target, "a drawing")
        names[name] = target.name
    return names


def illustrations(derivation: Derivation) -> dict[str, Drawing]:
    """The same as data."""
    seen, spoken = _shown(derivation), _spoken(derivation)
    wanted: dict[str, Step | None] = {"overview": None}
    for step in derivation.steps:
        if step.figure:
            wanted.setdefault(step.figure, step)
    found = {}
    for name, step in wanted.items():
        names = names_of(seen.model, step is None or _has_weights(step))
        drawing = _drawn(seen, names, name)
        if drawing is not None:
            if _is_free_body(name) and not names.weights and np.any(seen.model.gravity):
                drawing.notes = ["No weights: gravity is in the accelerations"]
            drawing.elements = [e for e in drawing.elements if _is_spoken_of(e, spoken)]
            found[name] = drawing
    return found


def _is_free_body(name: str) -> bool:
    return name.startswith(("free-body", "carried"))


def _spoken(derivation: Derivation) -> set[str]:
    """Labels of all symbols in the derivation's equations and in its table of symbols."""
    equations = [line for step in derivation.steps for line in step.equations]
    printed: list[Expression] = [
        *equations,
        *(x for row in derivation.glossary for x in row.symbols),
    ]
    return {
        canonical(label(symbol))
        for line in printed
        for symbol in nodes(line)
        if isinstance(symbol, Symbol)
    }


def _has_weights(step: Step) -> bool:
    """Whether weights are among a step's forces; not where the accelerations contain gravity."""
    return any(symbol == vec("g") for line in step.equations for symbol in nodes(line))


_QUANTITIES = ("position", "velocity", "acceleration", "dimension", "angle", "z")


def _is_spoken_of(element: Element, spoken: set[str]) -> bool:
    """Whether an element is no vector, length or coordinate, or one that is spoken of."""
    free = (
        element.role not in _QUANTITIES
        or element.name in ("X", "Y", "Z")
        or not getattr(element, "label", "")
    )
    return free or canonical(element.name) in spoken


def _shown(derivation: Derivation) -> Snapshot:
    """A state that is seen well: moving, or at rest; under a load on the tip if the equations have
    one."""
    symbols = derivation.equations.symbols
    model = with_values(symbols.model)
    still = np.zeros(model.nv) if METHODS[derivation.method].at_rest else None
    load = _tip_load(model) if "fx" in symbols.extra else None
    return snapshot(model, None if still is None else resting_pose(model, load), still, still, load)


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
    alone = re.fullmatch(r"partial (\d+)", name)
    if alone:
        return _partial(seen, names, int(alone[1])) if seen.model.dim == 2 else None
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


def _tip(order: int, note: str) -> Callable[[Snapshot, Names], Drawing]:
    """The way to the tip (order 0), its velocity (1) or its acceleration (2), with the joints'
    rates."""
    name = label(vec("r_P" + ("", "_d", "_dd")[order]))

    def plane(seen: Snapshot, names: Names) -> Drawing:
        drawing = arm.blank(f"{seen.model.name}: {note.lower()}")
        arm.structure(drawing, seen, names, faint=not order)
        for layer in (arm.angles, arm.slides):
            layer(drawing, seen, names)
        if not order:
            vectors.links(drawing, seen, names)
            vectors.to_tip(drawing, seen, name)
        else:
            motion.rates(drawing, seen, names, second=order == 2)
            motion.of_tip(drawing, seen, name, second=order == 2)
        return _noted(drawing, note)

    def space(seen: Snapshot, names: Names) -> Drawing:
        drawing = frames.blank(f"{seen.model.name}: {note.lower()}", frames.viewed(seen))
        frames.structure(drawing, seen)
        if not order:
            vectors.to_tip(drawing, seen, name)
        else:
            frames.variables(drawing, seen, names)
            motion.of_tip(drawing, seen, name, second=order == 2)
        return _noted(drawing, note)

    return lambda seen, names: (plane if seen.model.dim == 2 else space)(seen, names)


def _partial(seen: Snapshot, names: Names, joint: int) -> Drawing:
    """How the centres of mass move when one joint alone does."""
    note = f"Partial velocities: joint {joint} alone moves, at the rate 1"
    drawing = arm.blank(f"{seen.model.name}: {note.lower()}")
    arm.structure(drawing, seen, names)
    for layer in (arm.angles, arm.slides, arm.centres):
        layer(drawing, seen, names)
    motion.partial_of_centres(drawing, seen, joint)
    return _noted(drawing, note)


def _noted(drawing: Drawing, note: str) -> Drawing:
    drawing.notes = [note]
    return drawing


def _view(show: str, note: str) -> Callable[[Snapshot, Names], Drawing]:
    return lambda seen, names: _noted(view(seen, show, names), note)


_TIP = {
    "tip": _tip(0, "The way to the tip"),
    "tip velocity": _tip(1, "The velocity of the tip"),
    "tip acceleration": _tip(2, "The acceleration of the tip"),
}
_PLANE: dict[str, Callable[[Snapshot, Names], Drawing]] = {
    "overview": _overview,
    "vectors": _vectors,
    "centres": _view("centres", "Where the centres of mass are"),
    "velocities": _view("velocities", "Joint rates and velocities of the centres of mass"),
    "accelerations": _view(
        "accelerations", "Joint accelerations and accelerations of the centres of mass"
    ),
    **_TIP,
}
_SPACE: dict[str, Callable[[Snapshot, Names], Drawing]] = {
    "overview": _view("frames", "Joint axes and joint variables"),
    "vectors": _view("vectors", "Vectors from joint to joint, and centres of mass"),
    **_TIP,
}
