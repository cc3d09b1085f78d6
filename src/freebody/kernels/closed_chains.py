"""What closed chains do where trees take a kernel as it stands: the one way from here into their
room."""

from __future__ import annotations

import importlib
from collections.abc import Callable
from functools import cache, wraps
from typing import Any

from freebody.model.model import Model
from freebody.model.model_argument import require_one

_OF_FAMILIES = (
    "inverse_dynamics",
    "forward_dynamics",
    "static_torque",
    "joint_wrenches",
    "counting_equations",
    "require_partition",
)
_PLACES = {
    "inverse_dynamics": ("freebody.loops.dynamics", "inverse_dynamics"),
    "forward_dynamics": ("freebody.loops.dynamics", "forward_dynamics"),
    "static_torque": ("freebody.loops.dynamics", "static_torque"),
    "joint_wrenches": ("freebody.loops.reactions", "reactions"),
    "assemble": ("freebody.loops.assembly", "assemble"),
    "loop_velocity": ("freebody.loops.rates", "loop_velocity"),
    "counting_equations": ("freebody.loops.independent_equations", "counting_equations"),
    "require_partition": ("freebody.loops.independent_equations", "require_partition"),
}


@cache
def closed_chain_function(name: str) -> Callable[..., Any]:
    """The function of that name for models with loops, imported when the first of these comes."""
    module, place = _PLACES[name]
    function = getattr(importlib.import_module(module), place)

    if name in _OF_FAMILIES:
        return function

    @wraps(function)
    def of_one(model: Model, *args: Any, **kwargs: Any) -> Any:
        require_one(name, model)
        return function(model, *args, **kwargs)

    return of_one
