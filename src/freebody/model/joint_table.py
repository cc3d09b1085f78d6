"""The joints of a robot as a table of texts, for whoever prints it."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from freebody.model.families import Members
from freebody.model.parameters import Parameter
from freebody.outputs.display import TextTable

if TYPE_CHECKING:
    from freebody.model.bodies import Body
    from freebody.model.model import Model


def table(model: Model) -> TextTable:
    """Joints, their limits, and what they carry."""
    mass = "mass, estimated" if model.is_estimated else "mass"
    head = ("joint", "kind", "axis", "range", "speed", "effort", "moves", mass, "follows")
    return TextTable(head, list(map(_row, model.bodies)))


def _row(body: Body) -> tuple[str, ...]:
    """A joint, its limits, and what it carries."""
    joint, limits = body.joint, body.joint.limits
    unit, force = ("m", "N") if body.kind.slides else ("rad", "N m")
    one = body.kind.nv == 1
    bounded = one and (_given(limits.lower) or _given(limits.upper))
    mimic = joint.mimic
    return (
        joint.name,
        ", ".join([joint.kind, *_own(body), *["passive"] * joint.passive]),
        " ".join(f"{x:.4g}" for x in joint.axis),
        f"{_number(limits.lower)} … {_number(limits.upper)} {unit}" if bounded else "",
        f"{_number(limits.velocity)} {unit}/s" if one and _given(limits.velocity) else "",
        f"{_number(limits.effort)} {force}" if one and _given(limits.effort) else "",
        body.name,
        _mass(body),
        mimic.said() if mimic else "",
    )


def _own(body: Body) -> list[str]:
    """The numbers that joints of its kind have of their own, such as a screw's pitch."""
    found = []
    for own, number in zip(body.kind.numbers, body.joint.numbers, strict=True):
        if isinstance(number, Parameter) and number.value is None:
            said = number.name
        else:
            value = number.value if isinstance(number, Parameter) else number
            said = f"{_number(value)} {own.unit}"
        found.append(f"{own.name} {said}")
    return found


def _given(limit: Any) -> bool:
    return isinstance(limit, Members) or math.isfinite(limit)


def _number(limit: Any) -> str:
    if isinstance(limit, Members):
        return f"{limit.array.min():.4g} to {limit.array.max():.4g}"
    return f"{limit:.4g}"


def _mass(body: Body) -> str:
    if any(isinstance(part.inertia.mass, Members) for part in body.inertias):
        return "of each member"
    first = body.inertias[0].inertia.mass if len(body.inertias) == 1 else None
    try:
        whole = f"{sum(part.inertia.numbers()[0] for part in body.inertias):.4g} kg"
        return f"{whole} = {first.name}" if isinstance(first, Parameter) else whole
    except (TypeError, ValueError):  # a parameter without value
        return "symbolic"
