"""`derive`: the equations of motion step by step, by one of the methods of the notes."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from freebody.derivations.closed.first_kind import MULTIPLIER
from freebody.derivations.derivation import Comparison, Derivation
from freebody.derivations.methods import (
    first_kind,
    kinematics,
    lagrange,
    newton_euler,
    recursive,
    statics,
)
from freebody.derivations.methods.setting import Setting, require_chain_of_bodies
from freebody.derivations.symbols import symbols
from freebody.errors import FreebodyError, UnknownNameError
from freebody.model.closures import LOOP_KINDS
from freebody.model.model import Model
from freebody.spatial import of_dimension

METHODS = {
    "newton-euler": newton_euler.derive,
    "recursive": recursive.derive,
    "lagrange": lagrange.derive,
    "lagrange-first-kind": first_kind.derive,
    "statics": statics.derive,
    "kinematics": kinematics.derive,
}

OPTIONS = {"newton-euler": ("route",), "recursive": ("gravity",)}
"""Options that a method has of its own."""

CLOSED = ("lagrange-first-kind", "statics", "kinematics")
"""Methods for closed chains."""

LOADS = {2: ("fx", "fy"), 3: ("fx", "fy", "fz")}
"""Names of the components of the force on the tip."""


def derive(
    model: Model, method: str | None = None, *, load: bool | None = None, **options: Any
) -> Derivation:
    """A derivation of the model's equations as an ordered list of steps.

    method: "newton-euler" (route="centre": moments about each centre of mass, or "pivot": of all that a joint carries
    about it), "recursive" (gravity="base": as acceleration of the base, or "explicit": as weights), "lagrange",
    "statics", "kinematics" (of the tip); of closed chains "lagrange-first-kind", with multipliers and the reduction to
    independent coordinates. Default: "newton-euler", of closed chains "lagrange-first-kind".
    load: whether a force f, with world components fx, fy (fz), acts on the tip; by default in statics. Raises
    FreebodyError for joints with several axes or followers, and for a load on a model without a tip.
    Source: S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019.
    """
    if method is None:
        method = default_method(model)
    if method not in METHODS:
        raise UnknownNameError("method", method, "fb.derive", METHODS)
    _require_options(method, load, options)
    if method not in CLOSED:
        model.require_tree(f"derive {method!r}", " or ".join(map(repr, CLOSED)))
    if load is None:
        load = method == "statics" and _has_moving_tip(model)
    names = LOADS[model.dim] if load else ()
    made = symbols(model, extra=(*names, *_multipliers(model)))
    require_chain_of_bodies(made, f"derive {method!r}")
    return METHODS[method](Setting(made, names, at_rest=method == "statics"), **options)


def default_method(model: Model) -> str:
    """The method for a model where none is asked for."""
    return "lagrange-first-kind" if model.loops else "newton-euler"


def _require_options(method: str, load: bool | None, options: Mapping[str, Any]) -> None:
    """Refuse what the method would not use."""
    for name in options:
        owner = next((m for m, own in OPTIONS.items() if name in own), None)
        if owner is None:
            known = ("load", *OPTIONS.get(method, ()))
            raise UnknownNameError("option", name, f"derive {method!r}", known)
        if owner != method:
            raise FreebodyError(f"derive {method!r}: {name} is an option of {owner!r}; leave it out.")
    if load and method == "kinematics":
        raise FreebodyError("derive 'kinematics': forces do not occur in it; leave load out.")


def _multipliers(model: Model) -> tuple[str, ...]:
    """Names of the multipliers of its loop equations."""
    space = of_dimension(model.dim)
    size = sum(LOOP_KINDS[loop.kind].closure(space, loop.axis).size(space) for loop in model.loops)
    return tuple(f"{MULTIPLIER}{k}" for k in range(1, size + 1))


def _has_moving_tip(model: Model) -> bool:
    return model.tip is not None and model.frame().body >= 0


def compare(first: Derivation, second: Derivation) -> Comparison:
    """Two derivations of one model, subtracted term by term; true when they are identical polynomials."""
    a, b = first.equations.symbols, second.equations.symbols
    if a.given is not b.given:
        raise FreebodyError("compare: the derivations are of different models.")
    if not (first.tau and second.tau):
        raise FreebodyError("compare: a derivation of kinematics ends in no torques.")
    if a.ring != b.ring:
        raise FreebodyError("compare: one derivation has a load on the tip, the other has none.")
    return Comparison(first, second)
