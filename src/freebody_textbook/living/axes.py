"""Quantities in space by the names of derivations: in the axes of each body, and all in those of
the world, where vectors of several bodies can be added."""

from __future__ import annotations

from typing import Any

from freebody.expressions.grammar.atoms import atom
from freebody.spatial import product, times, transposed
from freebody_textbook.relations.formula_values import rank
from freebody_textbook.relations.quantities import Quantities

_VECTORS = ("omega", "v", "vc", "s", "sc", "f", "fc", "n", "nc")
"""Letters of vectors in axes of their body, whose number is the last figure."""
_PARTIAL = ("omega", "vc")
"""Letters of partial velocities, whose indices are body and joint."""


def body_of(name: str) -> str:
    """The number of the body in whose axes a vector is, by the name with which a line begins."""
    own = atom(name)
    turns = own.letter == "R" and own.is_figures and len(own.figures) == 2 and not own.dots
    return own.figures[-1] if turns else _of_vector(name)


def _of_vector(name: str) -> str:
    """The number of the body whose vector it is, "" of anything else."""
    own = atom(name)
    if not own.is_figures or own.primes or len(own.figures) > 2 or own.letter not in _VECTORS:
        return ""
    is_partial = own.letter in _PARTIAL and len(own.index) == 2 and not own.dots
    return own.figures[0 if is_partial else -1]


def scalar_name(name: str) -> str:
    """Of a parameter that has the name of a matrix, such as I1, the name of its value."""
    return f"{name} (scalar)"


def own_axes(values: Quantities, parameters: dict[str, Any]) -> Quantities:
    """Each vector in the axes of its body, n0_1 for the moment n1 at its joint; R1_2 is printed as
    what turns components of body 1 to those of body 2; axes of joints are left to the lines that
    define them."""
    found: dict[str, Any] = {}
    further: dict[str, Any] = {}
    for name, x in values.items():
        own = atom(name)
        match own.letter, own.index, own.dots:
            case "z" | "w", (k,), 0 if k.isdigit():
                continue
            case "n", (k,), 0 if k.isdigit():
                further[f"n{int(k) - 1}_{k}"] = x
            case "R", (k,), 0 if k.isdigit() and k != "0":
                further[f"R0_{k}"] = transposed(x)
            case "R", (_, _), 0:
                further[name] = transposed(x)
        found[name] = x
    found |= further
    found |= {scalar_name(name): x for name, x in parameters.items() if rank(found.get(name)) > 0}
    return Quantities(found, values.layout)


def world_axes(values: Quantities) -> Quantities:
    """Quantities in axes of their bodies, turned into those of the world."""
    found: dict[str, Any] = {}
    for name, x in values.items():
        own = atom(name)
        body = own.figures if own.letter == "I" and own.is_numbered else _of_vector(name)
        turn = values.get(f"R{body}") if body else None
        if turn is None or rank(x) == 0:
            found[name] = x
        else:
            found[name] = (
                product(product(turn, x), transposed(turn)) if rank(x) == 2 else times(turn, x)
            )
    return Quantities(found, values.layout)
