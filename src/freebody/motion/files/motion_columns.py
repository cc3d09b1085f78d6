"""A motion from columns of numbers by name, wherever they were read: in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from freebody.arrays import Array
from freebody.errors import LoopError, UnknownNameError
from freebody.model.model import Model
from freebody.motion.closed_chain_motion import completed
from freebody.motion.files.csv_columns import quoted
from freebody.motion.files.implausible_units import implausible_units
from freebody.motion.files.measured_motions import ROUNDED, along_rates, rested
from freebody.motion.motion import FEWEST, Motion, derivatives, motion_of
from freebody.motion.piecewise import hermite
from freebody.motion.ranges import angular, position_columns
from freebody.outputs.numbers import compared
from freebody.trees.position_rates import layout, state_of

_UNIT = 1e-3  # how far a quaternion of a file, printed with few digits, may be off unit length
_DISAGREE = (
    0.05  # given rates this far from the differentiated ones, over the largest, are worth a word
)


def doubted(
    model: Model, motion: Motion, columns: Mapping[str, Array], told: frozenset[str], where: str
) -> Motion:
    """The motion with a notice on what looks like another unit; positions that were not given are
    not looked at."""
    found = told | {name for name in model.position_names if name not in columns}
    said = implausible_units(model, motion.t, motion.q, found, where)
    return replace(motion, notices=(*said, *motion.notices))


def check_names(model: Model, header: list[str], problem: Any) -> None:
    """Every column known, every position there."""
    simple = {model.position_names[k] for k in position_columns(model)[0]}
    known = [
        "t",
        *model.position_names,
        *(f"{n}.{x}" for n in model.position_names if n in simple for x in "va"),
    ]
    listed = set(known)
    for name in header:
        if name in listed:
            continue
        if name[-2:] in (".v", ".a") and name[:-2] in (
            *model.position_names,
            *model.velocity_names,
        ):
            raise problem(
                f"column {name!r}: rates of a joint with a quaternion are differentiated; remove "
                f"the column."
            )
        unknown = str(UnknownNameError("column", name, f"a motion of {model.name!r}", known))
        raise problem(f"{unknown[:-1]}; a column that is not part of the motion must be removed.")
    given = set(header)
    missing = [name for name in model.position_names if name not in given]
    if model.loops:
        _check_leaders(model, header, problem)
    elif missing:
        raise problem(
            f"there is no column for {quoted(missing)}; a motion gives every position of "
            f"{model.name!r}."
        )


def _check_leaders(model: Model, header: list[str], problem: Any) -> None:
    """Of a closed chain some positions suffice; rates follow from the loops."""
    rates = [
        name for name in header if name[-2:] in (".v", ".a") and name not in model.position_names
    ]
    if rates:
        raise problem(
            f"column {rates[0]!r}: the rates of a closed chain are found from its positions; "
            f"remove the column."
        )
    if not set(header) & set(model.position_names):
        drives = ", ".join(model.driven_names)
        raise problem(
            f"there is no position; a motion gives at least those of the driven joints: {drives}."
        )


def without_jumps(
    model: Model, t: Array, columns: dict[str, Array]
) -> tuple[Array, dict[str, Array], Array | None]:
    """(t, columns, accelerations (T, n) with which the times are reached, or None) of columns in
    which a time stands twice where the accelerations jump: the first row has those before it.

    Rows that differ in more than accelerations are left as they are.
    """
    rates = [f"{name}.v" for name in model.position_names]
    seconds = [f"{name}.a" for name in model.position_names]
    twice = np.flatnonzero(np.diff(t) == 0.0)
    same = [columns[name] for name in (*model.position_names, *rates) if name in columns]
    if (
        not len(twice)
        or (np.diff(twice) == 1).any()
        or not {*rates, *seconds} <= set(columns)
        or any((column[twice] != column[twice + 1]).any() for column in same)
    ):
        return t, columns, None
    kept = np.append(np.diff(t) != 0.0, True)
    first = np.append(True, np.diff(t) != 0.0)
    before = np.stack([columns[name][first] for name in seconds], axis=-1)
    return t[kept], {name: column[kept] for name, column in columns.items()}, before


def with_jumps(motion: Motion, before: Array | None) -> Motion:
    """The motion whose accelerations `before` (T, n) its times are not those behind them."""
    if before is None:
        return motion
    pieces = hermite(motion.t, motion.q, motion.qd, motion.qdd, before)
    return replace(motion, pieces=pieces)


def motion_from_columns(
    model: Model, t: Array, columns: dict[str, Array], source: str, problem: Any
) -> Motion:
    return rested(model, _as_given(model, t, columns, source, problem))


def _as_given(
    model: Model, t: Array, columns: dict[str, Array], source: str, problem: Any
) -> Motion:
    if len(t) < FEWEST:
        raise problem(f"{len(t)} samples; a motion needs at least {FEWEST}.")
    if model.loops:
        try:
            return completed(model, t, columns, source)
        except LoopError as error:
            raise problem(str(error)) from None
    q = _unit(model, np.stack([columns[name] for name in model.position_names], axis=-1), problem)
    plain = motion_of(model, t, q, source=source)
    rates = {name: columns[f"{name}.v"] for name in model.position_names if f"{name}.v" in columns}
    slopes, notices = plain.qd, []
    if rates and len(rates) == model.nq:
        given = np.stack(list(rates.values()), axis=-1)
        q, slopes = along_rates(t, q, given)
        notices += _in_line(model, np.abs(q - plain.q))
    iq, iv = position_columns(model)
    qd, qdd = plain.qd.copy(), plain.qdd.copy()
    off = []
    for kq, kv in zip(iq, iv, strict=True):
        name = model.position_names[kq]
        if name in rates:
            qd[:, kv] = rates[name]
            qdd[:, kv] = derivatives(t, rates[name][:, None])[0][:, 0]
            largest = max(np.abs(qd[:, kv]).max(), np.abs(slopes[:, kv]).max())
            rounded = ROUNDED * np.abs(q[:, kq]).max() / np.diff(t).min()
            if np.abs(qd[:, kv] - slopes[:, kv]).max() > max(_DISAGREE * largest, rounded):
                off.append(name)
        if f"{name}.a" in columns:
            qdd[:, kv] = columns[f"{name}.a"]
    if off:
        notices.append(
            f"The rates given for {quoted(off)} differ from the slope of the positions by more "
            f"than 5 %."
        )
    accelerated = all(f"{name}.a" in columns for name in model.position_names)
    return replace(
        motion_of(model, t, q, qd, qdd, _told(model, source, list(rates)), tuple(notices)),
        differentiated="" if accelerated else "rates" if len(rates) == model.nq else "positions",
    )


def _told(model: Model, source: str, rates: list[str]) -> str:
    """Where the motion and its rates come from."""
    all_given = len(rates) == model.nq
    how = "rates as given" if all_given else f"rates of {quoted(rates)} as given" if rates else ""
    rest = "" if all_given else "differentiated by a spline through the positions"
    return f"{source}; {'; '.join(part for part in (how, rest) if part)}"


def _in_line(model: Model, moved: Array) -> list[str]:
    """A sentence on positions that were moved (T, nq)."""
    if not moved.any():
        return []
    k = int(np.argmax(moved.max(axis=0)))
    unit = "rad" if angular(model)[k] else "m"
    return [
        f"The positions carry noise and were adjusted to the given rates, by at most "
        f"{moved.max():.2g} {unit} "
        f"({model.position_names[k]})."
    ]


def _unit(model: Model, q: Array, problem: Any) -> Array:
    """q with quaternions of exactly unit length; refuses those that are far off."""
    where = layout(model)
    for iq, _ in where.turns:
        off = np.abs(np.linalg.norm(q[:, iq], axis=-1) - 1.0)
        if (off > _UNIT).any():
            row = int(np.argmax(off > _UNIT))
            size = float(np.linalg.norm(q[row, iq]))
            length, unit = compared(size, 1.0)
            raise problem(
                f"the quaternion {quoted(model.position_names[iq])} has length {length}, "
                f"expected {unit}.",
                row,
            )
    return state_of(where, q, np.zeros_like(q), np.zeros_like(q))[0]
