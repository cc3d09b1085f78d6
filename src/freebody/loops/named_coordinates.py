"""Coordinates by name: those that may move, those that are driven."""

from __future__ import annotations

from collections.abc import Sequence

from freebody.errors import UnknownNameError
from freebody.model.model import Model


def driven_coordinates(
    function: str, model: Model, actuated: Sequence[str] | None = None
) -> tuple[int, ...]:
    """Indices of the driven coordinates: of those named, or the model's own."""
    return model.driven if actuated is None else tuple(free_coordinates(model, actuated, function))


def free_coordinates(model: Model, names: Sequence[str] | None, function: str) -> list[int]:
    """Indices of the coordinates named, each by itself or through its joint; None is all."""
    if names is None:
        return list(range(model.nv))
    if isinstance(names, str):
        names = (names,)
    of_joint = {
        body.joint.name: list(at.v)
        for body, at in zip(model.bodies, model.coordinates, strict=True)
        if body.joint.mimic is None
    }
    of_name = {name: [k] for k, name in enumerate(model.velocity_names)} | of_joint
    for name in names:
        if name not in of_name:
            raise UnknownNameError("coordinate", name, f"{function}: {model.name!r}", of_name)
    return sorted({k for name in names for k in of_name[name]})
