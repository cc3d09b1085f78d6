"""What stands beside the elements of a drawing: their names, their values, or both."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable

import numpy as np

from freebody.errors import FreebodyError, UnknownNameError, shown
from freebody.figures.drawing import Arc, Arrow, Dimension, Element, Label, Turn, metres
from freebody.model.model import Model
from freebody.outputs.numbers import significant

LABELS = ("names", "values", "both")


def labels_of(caller: str, model: Model, labels: str | None) -> str:
    """One of `LABELS`; default: both where the model has all its values, else names.

    Raises UnknownNameError, and MissingValueError where values are asked for that are not there.
    """
    if labels is None:
        return "names" if model.missing else "both"
    if labels not in LABELS:
        raise UnknownNameError("choice", labels, f"{caller}: labels=", LABELS)
    if labels != "names":
        model.require_values(f"{caller} with labels={labels!r}")
    return labels


def chosen_of(caller: str, show: str | Iterable[str], known: Collection[str]) -> tuple[str, ...]:
    """What `show` names, each once, as one name or several.

    Raises UnknownNameError for one that is not known, FreebodyError for what is no name.
    """
    if not isinstance(show, Iterable):
        raise FreebodyError(f"{caller}: show is {shown(show)}; give a name, or several.")
    chosen = (show,) if isinstance(show, str) else tuple(show)
    for name in chosen:
        if name not in list(known):
            raise UnknownNameError("choice", name, f"{caller}: show=", known)
    return tuple(dict.fromkeys(chosen))


def quantity(element: Element) -> str:
    """An element's value with its unit, of a vector its magnitude; "" where it has none."""
    match element:
        case Arrow(value=value, unit=unit) if value and unit:
            size = value[0] if len(value) == 1 else float(np.linalg.norm(value))
            return f"{significant(size)} {unit}"
        case Turn():
            return f"{significant(element.value)} {element.unit}"
        case Arc():
            return f"{significant(math.degrees(element.sweep))}°"
        case Dimension():
            return metres(math.dist(element.start, element.end))
        case _:
            return ""


def beside(element: Element, labels: str) -> tuple[str, str]:
    """What stands beside an element, a formula and plain text after it."""
    name = element.text if isinstance(element, Label) else getattr(element, "label", "")
    value = quantity(element) if name and labels != "names" else ""
    if not value:
        return name, ""
    if labels == "values":
        return "", value
    magnitude = isinstance(element, Arrow) and len(element.value) > 1
    return name, f"\u2002{value}" if magnitude else f" = {value}"
