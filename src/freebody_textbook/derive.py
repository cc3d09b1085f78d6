"""Derivation of the equations of motion step by step (`fb.derive`), by one of the methods in
`freebody_textbook.methods`."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from os import PathLike
from typing import Any

from freebody.errors import FreebodyError, UnknownNameError, require_kind
from freebody.expressions.nodes import Equation, Words, nodes
from freebody.expressions.notations.lettering import lettering_of
from freebody.expressions.notations.notation import BookNotation, angles_of, notation_of
from freebody.model.model import Model
from freebody_textbook.closed_chains.multiplier_equations import multipliers
from freebody_textbook.derivation import Comparison, Derivation, Method, Step, written_in
from freebody_textbook.drawings.illustrate import drawings, living_parts
from freebody_textbook.given_parameters import as_terms, formulas_in_words, formulas_of, prepared
from freebody_textbook.methods import METHODS
from freebody_textbook.methods.overview import overview, without_repeated_legs
from freebody_textbook.methods.setting import LOADS, Setting
from freebody_textbook.methods.whole_bodies import (
    sentences_on_whole_bodies,
    symbols_of_bodies,
    velocity_names,
)


def derive(
    model: Model,
    method: str | None = None,
    *,
    load: bool | None = None,
    notation: str | PathLike[str] | BookNotation | None = None,
    parameters: Mapping[str, str | float] | None = None,
    **options: Any,
) -> Derivation:
    """Derive the model's equations, as an ordered list of steps.

    A joint of several coordinates is taken apart into joints of one, a quaternion into yaw, pitch
    and roll (R = R_z R_y R_x). Bodies that nothing holds, such as the quadrotor, are derived in
    their own axes by the first method; joints that follow others, in open chains, by their leader's
    coordinate.

    Parameters
    ----------
    model
        The robot.
    method
        A name from the list below; None: the first that applies to the model.
    load
        Whether a force f, with world components fx, fy (fz), acts on the tip; None: in a method for
        robots at rest, where the model has a tip that moves.
    notation
        The letters that are printed, as for `check`, which reads the lines in the same notation;
        None: those of the notes.
    parameters
        Parameters given by formulas or numbers, {"lc": "l/2"} of all links, {"I1": "m1*l1^2/12"};
        with letters of your own too, {"I1": "m1*r^2/2"}.
    options
        The method's own, from the list below.

    Returns
    -------
    Derivation
        With its steps, the torques as exact polynomials, and text, Markdown, LaTeX and a page.

    Raises
    ------
    FreebodyError
        A turn by a fraction of another, a load on a model without a tip, a notation that calls two
        things by one name, options that the method does not use.
    UnknownNameError
        A name of a method, option or notation that there is not.

    References
    ----------
    S. Bai, Dynamics of robotic manipulators, lecture notes, Aalborg University, 2019, where
    the method's line names no other.
    """
    record = default_method(model) if method is None else method_named(method)
    chosen = _options(record, load, options)
    _require_served(record, model)
    if load is None:
        load = record.at_rest and _has_moving_tip(model)
    style = notation_of(notation, parameters)
    model = prepared(model, style.parameters)
    setting = _setting(record, model, LOADS[model.dim] if load else (), style)
    worked = record.work_out(setting, **chosen)
    given, glossary = overview(setting, record, worked)
    given = " ".join(
        [
            given,
            *sentences_on_whole_bodies(model, setting.symbols, not worked.robot),
            *formulas_in_words(setting.symbols, setting.layout),
        ]
    )
    derivation = Derivation(
        record.name,
        worked.title or record.title,
        setting.equations,
        _with_lengths(without_repeated_legs(setting, worked.steps)),
        worked.tau,
        given,
        glossary,
        worked.system,
        record.reference,
        draw=drawings,
        enliven=living_parts,
    )
    return written_in(setting.letters, derivation)


def _setting(record: Method, model: Model, load: tuple[str, ...], style: BookNotation) -> Setting:
    """The model over polynomials, prepared for a method and a notation; load: names of the
    components of the force on the tip."""
    extra = (*load, *multipliers(model), *velocity_names(model))
    caller = f"derive {record.name!r}"
    made = symbols_of_bodies(caller, model, extra, euler=True)
    _require_angles(record, style, model)
    angles = angles_of(caller, style, made.model)
    if style.parameters or any(angles):  # formulas are read in the symbols of the model without
        formulas = as_terms(formulas_of(caller, made, style.parameters))
        made = symbols_of_bodies(caller, model, extra, True, formulas, *angles)
    lettering = lettering_of(style, made.model, made.coordinates)
    return Setting(made, load, record.at_rest, lettering)


def _with_lengths(steps: tuple[Step, ...]) -> tuple[Step, ...]:
    """The steps, the first of which that prints only the number of terms of a line explains how to
    get the line."""
    first = next((step for step in steps if any(map(_is_shown_by_length, step.equations))), None)
    reason = (
        " Where only the number of terms is given, the line is too long to read; in Python the "
        "derivation holds the torques exactly, as .tau, and M, Φ_q and c of a closed chain, as "
        ".system."
    )
    return tuple(replace(x, reason=x.reason + reason) if x is first else x for x in steps)


def _is_shown_by_length(line: Equation) -> bool:
    return any(isinstance(x, Words) and x.text.endswith(("terms", "terms)")) for x in nodes(line))


def method_named(name: str) -> Method:
    """The derivation method with a name or alias."""
    require_kind("derive", "method", name, str, "the name of a method")
    for method in METHODS.values():
        if name == method.name or name in method.aliases:
            return method
    raise UnknownNameError("method", name, "fb.derive", METHODS)


def default_method(model: Model) -> Method:
    """The default method for a model: the first that supports it, for closed chains preferably one
    made for these."""
    served = [method for method in METHODS.values() if _serves(method, model)]
    return next((method for method in served if model.loops and method.closed_first), served[0])


def _serves(method: Method, model: Model) -> bool:
    return model.dim in (method.closed if model.loops else method.spaces)


def _require_served(method: Method, model: Model) -> None:
    """Raise an error if a method does not support the robot."""
    if _serves(method, model):
        return
    what = f"derive {method.name!r}"
    others = [repr(other.name) for other in METHODS.values() if _serves(other, model)]
    if not model.loops:
        where = "the plane" if model.dim == 2 else "space"
        raise FreebodyError(f"{what}: {model.name!r} is in {where}; take {' or '.join(others)}.")
    if not method.closed:
        model.require_tree(what, " or ".join(others))
    where = "in the plane" if model.dim == 2 else "in space"
    numbers = f"; {method.elsewhere} give its numbers" if method.elsewhere else ""
    raise FreebodyError(
        f"{what}: {model.name!r} is a closed chain {where}, for which {method.name} is not written "
        f"out{numbers}."
    )


def _options(method: Method, load: bool | None, options: Mapping[str, Any]) -> dict[str, str]:
    """The method's options, completed by defaults; raises an error for options that the method does
    not use."""
    own = [option.name for option in method.options]
    for name in options:
        owners = [m.name for m in METHODS.values() if name in (option.name for option in m.options)]
        if not owners:
            known = ("load", "notation", "parameters", *own)
            raise UnknownNameError("option", name, f"derive {method.name!r}", known)
        if name not in own:
            owner = " and ".join(map(repr, owners))
            raise FreebodyError(
                f"derive {method.name!r}: {name} is an option of {owner}; leave it out."
            )
    if load and not method.finds_torques:
        raise FreebodyError(f"derive {method.name!r}: forces do not occur in it; leave load out.")
    found = {option.name: option.choices[0] for option in method.options} | dict(options)
    for option in method.options:
        if found[option.name] not in option.choices:
            raise UnknownNameError(option.name, found[option.name], method.name, option.choices)
    return found


def _require_angles(method: Method, notation: BookNotation, model: Model) -> None:
    """Raise an error for link angles where a method uses joint angles."""
    if notation.absolute and (model.passive or model.loops):
        what = "is a closed chain" if model.loops else "has joints without motor"
        raise FreebodyError(
            f"derive {method.name!r}: the notation {notation.name!r} has all angles from one "
            f"direction, which is not written out where a robot {what}, as {model.name!r}."
        )
    if notation.absolute and not method.absolute:
        others = " or ".join(repr(other.name) for other in METHODS.values() if other.absolute)
        raise FreebodyError(
            f"derive {method.name!r}: the notation {notation.name!r} has all angles from one "
            "direction, and this method goes from joint to joint, to the torque of each joint's "
            f"motor; take {others}."
        )


def _has_moving_tip(model: Model) -> bool:
    return model.tip is not None and model.frame().body >= 0


def compare(first: Derivation, second: Derivation) -> Comparison:
    """Two derivations of one model, subtracted term by term; true when they are identical
    polynomials."""
    a, b = first.equations.symbols, second.equations.symbols
    if a.given != b.given:
        raise FreebodyError("compare: the derivations are of different models.")
    for derivation in (first, second):
        if not METHODS[derivation.method].finds_torques:
            raise FreebodyError(
                f"compare: a derivation by {derivation.method} does not give joint torques."
            )
    if (a.formulas, a.turned, a.quarters) != (b.formulas, b.turned, b.quarters):
        raise FreebodyError("compare: the derivations have other angles or parameters.")
    if a.ring != b.ring:
        raise FreebodyError("compare: one derivation has a load on the tip, the other has none.")
    return Comparison(first, second)


def _listed() -> str:
    """The methods with their options, a line each of a list, for a docstring."""
    lines = []
    for method in METHODS.values():
        serves = "open chains" + (" and closed ones" if method.closed else "")
        options = [
            f"{option.name}={' | '.join(map(repr, option.choices))}: {option.words}"
            for option in method.options
        ]
        also = f" Also called {', '.join(map(repr, method.aliases))}." if method.aliases else ""
        own = f" Options: {'; '.join(options)}." if options else ""
        lines.append(
            f"    - {method.name!r}: {method.words}; {serves} ({method.source}).{own}{also}"
        )
    return "\n".join(lines)


derive.__doc__ = f"{derive.__doc__ or ''}\n    Notes\n    -----\n{_listed()}\n"
