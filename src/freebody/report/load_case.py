"""The load case of a study in words: the robot's loads, its tip, how it is mounted, and which
numbers differ from its file's."""

from __future__ import annotations

import numpy as np

from freebody.model.description import CHANGED
from freebody.model.model import Model
from freebody.model.number_editors import TENSOR
from freebody.model.parameters import Quantity
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached


def load_case(model: Model) -> dict[str, str]:
    """The load case in words by subject: "load", "tip", "mounting", and "changed" where numbers
    are.

    They tell the model as it is, not how it was made, so that equal models have equal words but for
    what was changed by name.
    """
    parts = [*model.base_inertias, *(part for body in model.bodies for part in body.inertias)]
    loads = "; ".join(_load(model, part) for part in parts if part.load)
    free = any(body.parent < 0 and body.kind.frees(model.dim) for body in model.bodies)
    field = ", ".join(_number(x) for x in np.moveaxis(model.gravity, -1, 0))
    changed = [notice.text for notice in model.notices if notice.kind == CHANGED]
    found = {
        "load": f"{loads}." if loads else "none.",
        "tip": model.tip_reason,
        "mounting": f"base {'free' if free else 'fixed'}, gravity ({field}) m/s² in world axes.",
    }
    return {**found, "changed": " ".join(changed)} if changed else found


def _load(model: Model, part: Attached) -> str:
    """A load in words: its mass, centre of mass and inertia, in the axes of its frame."""
    inertia = part.inertia
    centre = ", ".join(_quantity(x) for x in inertia.com)
    entries = [
        f"{name} {_quantity(x)}"
        for name, x in zip(TENSOR[model.dim], inertia.tensor, strict=True)
        if np.any(VALUES.quantity(x))
    ]
    about = f"inertia {', '.join(entries)} kg m²" if entries else "a point without inertia"
    return f"{part.link}, {_quantity(inertia.mass)} kg at ({centre}) m in {part.frame}, {about}"


def _quantity(x: Quantity) -> str:
    return _number(VALUES.quantity(x))


def _number(x: object) -> str:
    """A number as text, or the range of the numbers of a family."""
    values = np.asarray(x, dtype=float)
    low, high = (f"{float(end) + 0.0:.4g}" for end in (values.min(), values.max()))
    return low if low == high else f"{low} … {high}"


def in_a_line(model: Model) -> str:
    """The load case except the tip, in one line."""
    case = load_case(model)
    return " ".join(f"{about.capitalize()}: {case[about]}" for about in case if about != "tip")
