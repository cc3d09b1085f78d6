"""The drawings of a derivation: an arm with its names, and beside the steps the vectors, velocities
and free bodies."""

from __future__ import annotations

from dataclasses import replace
from functools import partial, wraps
from pathlib import Path
from typing import Any

import numpy as np

from freebody.derivations.derivation import Derivation, Drawings, Step
from freebody.derivations.derive import undrawn_derivation
from freebody.derivations.expressions.expression import Expression, Symbol, nodes
from freebody.derivations.expressions.printed_names import vec
from freebody.derivations.methods import METHODS
from freebody.figures import colours
from freebody.figures.drawing import Drawing, Element, canonical
from freebody.figures.figure import save
from freebody.figures.labelling import labels_of
from freebody.figures.layers import axes, forces, geometry, motion, vectors
from freebody.figures.layers.structure import Layer, drawn
from freebody.figures.layers.views import VIEWS
from freebody.figures.names import Names, names_of
from freebody.figures.snapshot import Snapshot, resting_pose, snapshot, with_values
from freebody.figures.svg import picture
from freebody.figures.text import label
from freebody.model.model import Model
from freebody.outputs.numbers import significant

WIDE, TALL = 460.0, 400.0
_DARK = "@media screen and (prefers-color-scheme:dark)"
_LOAD = {2: (0.85, -0.53), 3: (0.5, -0.65, -0.6)}
"""Direction of the load on the tip in drawings."""


@wraps(undrawn_derivation, assigned=("__doc__",))
def derive(model: Model, method: str | None = None, **options: Any) -> Derivation:
    """A derivation that draws what it speaks of where it is shown as a page or in a notebook."""
    return replace(undrawn_derivation(model, method, **options), draw=drawings)


def drawings(derivation: Derivation, labels: str = "names") -> Drawings:
    """SVG text for "overview" and for every figure that a step asks for and that can be drawn."""
    shown = illustrations(derivation, labels).items()
    return Drawings(
        {name: picture(drawing, WIDE, TALL).inline() for name, drawing in shown},
        colours.style(_DARK),
    )


def write_drawings(derivation: Derivation, document: Path, labels: str = "names") -> dict[str, str]:
    """Each drawing as an SVG file beside a document; the files' names by figure, for
    `Derivation.markdown`."""
    names = {}
    for name, drawing in illustrations(derivation, labels).items():
        target = document.with_name(f"{document.stem}-{name.replace(' ', '-')}.svg")
        save(picture(drawing, WIDE, TALL).text(), target, "a drawing")
        names[name] = target.name
    return names


def illustrations(derivation: Derivation, labels: str = "names") -> dict[str, Drawing]:
    """The same as data; labels: "names", "values" or "both"."""
    labels = labels_of("a derivation's drawings", derivation.equations.symbols.model, labels)
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
            if labels != "names" and step is None:
                drawing.notes += _state(seen)
            drawing.labels = labels
            drawing.elements = [e for e in drawing.elements if _is_spoken_of(e, spoken)]
            found[name] = drawing
    return found


def _state(seen: Snapshot) -> list[str]:
    """The state that values belong to, in words."""
    arrays = (("q", seen.q), ("q̇", seen.qd), ("q̈", seen.qdd))
    rows = [f"{name} = ({', '.join(significant(x) for x in array)})" for name, array in arrays]
    if seen.wrenches is not None:
        force = ", ".join(significant(x) for x in np.asarray(seen.wrenches)[: seen.model.dim])
        rows.append(f"f = ({force}) N at the tip")
    return [f"Values in these drawings: {rows[0]}", *rows[1:]]


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
    plane = seen.model.dim == 2
    kind, _, number = name.rpartition(" ")
    if kind == "free-body":
        body = seen.pose.bodies[int(number) - 1]
        return forces.alone(seen, body, names, forces.BOOK[seen.model.dim])
    if kind == "carried":
        return forces.carried(seen, seen.pose.bodies[int(number) - 1], names) if plane else None
    if kind == "partial":
        alone = partial(motion.partial_of_centres, joint=int(number))
        note = f"Partial velocities: only joint {number} moves, at unit rate"
        layers = (geometry.angles, geometry.slides, geometry.centres, alone)
        return _noted(drawn(seen, names, note.lower(), layers), note) if plane else None
    recipe = _RECIPES[seen.model.dim].get(name)
    if recipe is None:
        return None
    note, layers = recipe
    return _noted(drawn(seen, names, note.lower(), layers, faint=name == "tip"), note)


def _noted(drawing: Drawing, note: str) -> Drawing:
    drawing.notes = [note]
    return drawing


def _load(drawing: Drawing, seen: Snapshot, names: Names) -> None:
    """The force on the tip, if there is one."""
    if seen.wrenches is not None:
        body = seen.pose.bodies[seen.model.frame().body]
        forces.act(drawing, seen, body, names, ("external",))


def _tip(*layers: Layer) -> dict[str, tuple[str, tuple[Layer, ...]]]:
    """Position of the tip, its velocity and its acceleration, with the joints' rates, on layers."""
    r, v, a = (label(vec("r_P" + ending)) for ending in ("", "_d", "_dd"))
    rates, velocity = motion.rates, partial(motion.of_tip, name=v)
    acceleration = partial(motion.of_tip, name=a, second=True)
    return {
        "tip": ("Position of the tip", (*layers, vectors.links, partial(vectors.to_tip, name=r))),
        "tip velocity": ("The velocity of the tip", (*layers, rates, velocity)),
        "tip acceleration": (
            "The acceleration of the tip", (*layers, partial(rates, second=True), acceleration)
        ),
    }  # fmt: skip


_RECIPES: dict[int, dict[str, tuple[str, tuple[Layer, ...]]]] = {
    2: {
        "overview": (
            "Coordinates, lengths and centres of mass", (*VIEWS[2]["geometry"], _load)
        ),
        "vectors": (
            "The vectors, drawn beside the bodies they lie on",
            (
                geometry.centres, partial(vectors.links, aside=vectors.BESIDE),
                vectors.to_centres, vectors.directions,
            ),
        ),
        "centres": ("Where the centres of mass are", VIEWS[2]["centres"]),
        "velocities": (
            "Joint rates and velocities of the centres of mass", VIEWS[2]["velocities"]
        ),
        "accelerations": (
            "Joint accelerations and accelerations of the centres of mass",
            VIEWS[2]["accelerations"],
        ),
        **_tip(geometry.angles, geometry.slides),
    },
    3: {
        "overview": ("Joint axes and joint variables", VIEWS[3]["frames"]),
        "vectors": ("Vectors from joint to joint, and centres of mass", VIEWS[3]["vectors"]),
        **_tip(axes.variables),
    },
}  # fmt: skip
"""By dimension and by the name that steps give them: a line of words, and the layers."""
