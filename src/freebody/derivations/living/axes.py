"""Quantities in space by the names of derivations: in the axes of each body, and all in those of
the world, where vectors of several bodies can be added."""

from __future__ import annotations

import re
from typing import Any

from freebody.derivations.relations.formula_values import rank
from freebody.derivations.relations.quantities import Quantities
from freebody.spatial import product, times, transposed

_VECTOR = re.compile(r"(?:omega|vc?|sc?|fc?|nc?)(?:\d_?)?(\d)(?:_dd?)?")
"""Names of vectors in axes of their body, whose number is the last digit."""
_PARTIAL = re.compile(r"(?:omega|vc)(\d)_\d")
"""Names of partial velocities: body and joint."""


def body_of(name: str) -> str:
    """The number of the body in whose axes a vector is, by the name with which a line begins."""
    found = _vector(name) or re.fullmatch(r"R\d_?(\d)", name)
    return found[1] if found else ""


def _vector(name: str) -> re.Match[str] | None:
    return _PARTIAL.fullmatch(name) or _VECTOR.fullmatch(name)


def scalar_name(name: str) -> str:
    """Of a parameter that has the name of a matrix, such as I1, the name of its value."""
    return f"{name} (scalar)"


def own_axes(values: Quantities, parameters: dict[str, Any]) -> Quantities:
    """Each vector in the axes of its body, n0_1 for the moment n1 at its joint; R1_2 is printed as
    what turns components of body 1 to those of body 2; axes of joints are left to the lines that
    define them."""
    found = {name: x for name, x in values.items() if not re.fullmatch(r"[zw]\d+", name)}
    found |= {
        f"n{int(name[1:]) - 1}_{name[1:]}": x
        for name, x in values.items()
        if re.fullmatch(r"n[1-9]", name)
    }
    found |= {name: transposed(x) for name, x in values.items() if re.fullmatch(r"R\d_\d", name)}
    found |= {
        f"R0_{name[1:]}": transposed(x)
        for name, x in values.items()
        if re.fullmatch(r"R[1-9]", name)
    }
    found |= {scalar_name(name): x for name, x in parameters.items() if rank(found.get(name)) > 0}
    return Quantities(found, values.layout)


def world_axes(values: Quantities) -> Quantities:
    """Quantities in axes of their bodies, turned into those of the world."""
    found: dict[str, Any] = {}
    for name, x in values.items():
        match = _vector(name) or re.fullmatch(r"I(\d)", name)
        turn = values.get(f"R{match[1]}") if match else None
        if turn is None or rank(x) == 0:
            found[name] = x
        else:
            found[name] = (
                product(product(turn, x), transposed(turn)) if rank(x) == 2 else times(turn, x)
            )
    return Quantities(found, values.layout)
