"""A motion from named columns of numbers in SI units, wherever they were read; with a notice where
values look like degrees, millimetres or milliseconds."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from typing import Literal

import numpy as np

from freebody.arrays import Array
from freebody.errors import LoopError, UnknownNameError, listed
from freebody.model.model import Model
from freebody.model.shafts import shaft_names
from freebody.motion.closed_chain_motion import completed
from freebody.motion.files.contradictions import contradictions
from freebody.motion.files.csv_columns import quoted
from freebody.motion.files.measured_motions import along_rates, rested
from freebody.motion.motion import FEWEST, Motion, derivatives, motion_of
from freebody.motion.piecewise import hermite
from freebody.motion.ranges import Flags, angular, position_columns, ranges
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import layout, state_of

_BEYOND = 1.5  # times the range: what is farther out is doubtful
_TURNS = 2.0  # without a range
_FAR = 50.0  # m, without a range
_SLOW = 1.0, 100  # s between samples, and so many of them
_UNIT = 1e-3  # how far a quaternion of a file, printed with few digits, may be off unit length
Refusal = Callable[..., Exception]
"""A function of a text and a row, or None, that makes the error to be raised."""


def doubted(
    model: Model, motion: Motion, columns: Mapping[str, Array], stated: frozenset[str], where: str
) -> Motion:
    """The motion with a notice on values that look like another unit; positions that were not given
    are not examined."""
    found = stated | {name for name in model.position_names if name not in columns}
    sentences = _implausible_units(model, motion.t, motion.q, found, where)
    return replace(motion, notices=(*sentences, *motion.notices))


def check_names(model: Model, header: list[str], problem: Refusal) -> None:
    """Refuse columns that are unknown, and positions that are lacking."""
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
    twists = shaft_names(model)
    missing = [name for name in model.position_names if name not in given and name not in twists]
    if model.loops:
        _check_leaders(model, header, problem)
    elif missing:
        raise problem(
            f"there is no column for {quoted(missing)}; a motion gives every position of "
            f"{model.name!r}."
        )


def _check_leaders(model: Model, header: list[str], problem: Refusal) -> None:
    """Refuse columns of a closed chain without any position."""
    if not set(header) & set(model.position_names):
        drives = ", ".join(model.driven_names)
        raise problem(
            f"there is no position; a motion gives at least those of the driven joints: {drives}."
        )


def with_untold_twists(
    model: Model, columns: dict[str, Array], count: int
) -> tuple[dict[str, Array], str]:
    """(the columns, and for each shaft of a flexible joint of which none tells one of zeros, with
    rates and accelerations where all others have them; words on that)."""
    untold = [name for name in shaft_names(model) if name not in columns]
    if not untold:
        return columns, ""
    simple = [model.position_names[k] for k in position_columns(model)[0]]
    told = [name for name in simple if name not in untold]
    ends = [end for end in ("", ".v", ".a") if {f"{name}{end}" for name in told} <= set(columns)]
    zeros = {f"{name}{end}": np.zeros(count) for name in untold for end in ends}
    return columns | zeros, f", {listed(untold, 4)} untwisted since no column tells of it"


def without_jumps(
    model: Model, t: Array, columns: dict[str, Array]
) -> tuple[Array, dict[str, Array], Array | None]:
    """(t, columns, before) of columns in which a time is listed twice where accelerations jump;
    before: accelerations (T, nv) just before each time, or None. The first of both rows has those.

    Rows that differ in more than accelerations are left as they are. NaN for joints with a
    quaternion, which the loops of a closed chain lead.
    """
    iq, iv = position_columns(model)
    simple = [model.position_names[k] for k in iq]
    rates, seconds = ([f"{name}{ending}" for name in simple] for ending in (".v", ".a"))
    twice = np.flatnonzero(np.diff(t) == 0.0)
    same = [columns[name] for name in (*model.position_names, *rates) if name in columns]
    if (
        not len(twice)
        or (np.diff(twice) == 1).any()
        or not (model.loops or len(simple) == model.nq)
        or not {*rates, *seconds} <= set(columns)
        or any((column[twice] != column[twice + 1]).any() for column in same)
    ):
        return t, columns, None
    kept = np.append(np.diff(t) != 0.0, True)
    first = np.append(True, np.diff(t) != 0.0)
    before = np.full((first.sum(), model.nv), np.nan)
    before[:, iv] = np.stack([columns[name][first] for name in seconds], axis=-1)
    return t[kept], {name: column[kept] for name, column in columns.items()}, before


def motion_from_columns(
    model: Model,
    t: Array,
    columns: dict[str, Array],
    source: str,
    problem: Refusal,
    before: Array | None = None,
) -> Motion:
    """The motion of named columns; before: accelerations as `without_jumps` finds them."""
    if len(t) < FEWEST:
        raise problem(f"{len(t)} samples; a motion needs at least {FEWEST}.")
    if model.loops:
        try:
            return _of_closed_chain(model, t, columns, source, before)
        except LoopError as error:
            raise problem(str(error)) from None
    positions = np.stack([columns[name] for name in model.position_names], axis=-1)
    q = _unit(model, positions, problem)
    rates, accelerations = (_given(model, len(t), columns, ending) for ending in (".v", ".a"))
    of_all = "".join(f"; {part}" for part in _origin_of(model, rates))
    return given_motion(model, t, q, rates, accelerations, f"{source}{of_all}", before)


def _of_closed_chain(
    model: Model, t: Array, columns: dict[str, Array], source: str, before: Array | None
) -> Motion:
    """The motion in which the leading coordinates follow their columns and the loops determine the
    others; noisy positions are adjusted to given rates. Raises LoopError."""
    rates, accelerations = (_given(model, len(t), columns, ending) for ending in (".v", ".a"))
    known, accelerated = (np.asarray(~np.isnan(x).any(axis=0)) for x in (rates, accelerations))
    moved = np.zeros((len(t), model.nq))
    for kq, kv in zip(*position_columns(model), strict=True):
        name = model.position_names[kq]
        if known[kv] and name in columns:
            q = along_rates(t, columns[name][:, None], rates[:, [kv]])[:, 0]
            moved[:, kq] = np.abs(q - columns[name])
            columns = columns | {name: q}
    motion = completed(model, t, columns, source, before)
    sentences = (
        *_in_line(model, moved),
        *contradictions(model, motion, known, accelerated, before),
    )
    return rested(model, replace(motion, notices=sentences), given=bool(known.any()))


def _given(model: Model, count: int, columns: Mapping[str, Array], ending: str) -> Array:
    """Rates or accelerations (T, nv) from columns, NaN where there is no column."""
    found = np.full((count, model.nv), np.nan)
    for kq, kv in zip(*position_columns(model), strict=True):
        column = columns.get(model.position_names[kq] + ending)
        if column is not None:
            found[:, kv] = column
    return found


def given_motion(
    model: Model,
    t: Array,
    q: Array,
    rates: Array,
    accelerations: Array,
    source: str,
    before: Array | None = None,
) -> Motion:
    """The motion of an open chain with samples q (T, nq), and rates and accelerations (T, nv) with
    NaN in the columns that are to be differentiated; before: (T, nv) the accelerations with which
    the times are reached, where they jump. Notices say what contradicts itself."""
    plain = motion_of(model, t, q, source)
    q, notices = plain.q, []
    known, accelerated = (np.asarray(~np.isnan(x).any(axis=0)) for x in (rates, accelerations))
    if known.all() and plain.layout.flat:
        q = along_rates(t, q, rates)
        notices += _in_line(model, np.abs(q - plain.q))
    qd, qdd = np.where(known, rates, plain.qd), plain.qdd.copy()
    if known.any():
        qdd[:, known] = derivatives(t, rates[:, known])[0]
    qdd = np.where(accelerated, accelerations, qdd)
    motion = replace(plain, q=q, qd=qd, qdd=qdd, differentiated=_differentiated(known, accelerated))
    notices += contradictions(model, motion, known, accelerated, before)
    motion = rested(model, replace(motion, notices=tuple(notices)), given=known)
    if before is None:
        return motion
    pieces = hermite(motion.t, motion.q, motion.qd, motion.qdd, before)
    return replace(motion, pieces=pieces)


def _differentiated(known: Flags, accelerated: Flags) -> Literal["", "positions", "rates"]:
    if accelerated.all():
        return ""
    return "rates" if known.all() else "positions"


def _origin_of(model: Model, rates: Array) -> Iterator[str]:
    """Phrases on where a motion's rates come from: given or differentiated."""
    iq, iv = position_columns(model)
    names = [model.position_names[k] for k in iq[~np.isnan(rates[0, iv])]]
    all_given = len(names) == model.nq
    if names:
        yield "rates as given" if all_given else f"rates of {quoted(names)} as given"
    if not all_given:
        yield "differentiated by a spline through the positions"


def _in_line(model: Model, moved: Array) -> list[str]:
    """A sentence on positions that were adjusted, by (T, nq); none where nothing was."""
    if not moved.any():
        return []
    k = int(np.argmax(moved.max(axis=0)))
    unit = "rad" if angular(model)[k] else "m"
    return [
        f"The positions carry noise and were adjusted to the given rates, by at most "
        f"{moved.max():.2g} {unit} ({model.position_names[k]})."
    ]


def _unit(model: Model, q: Array, problem: Refusal) -> Array:
    """The positions q with quaternions of exactly unit length; refuses those that are far from
    it."""
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


def _implausible_units(
    model: Model, t: Array, q: Array, stated: frozenset[str], where: str
) -> list[str]:
    """Sentences on positions q (T, nq) and times t that in SI units would mean an implausible
    motion.

    stated: columns whose unit was stated, which are believed. where: what the unit is written in,
    with a place for a name and a unit.
    """
    iq, iv = position_columns(model)
    turning = ranges(model).turns
    sentences = []
    for turns in (True, False):
        doubtful: dict[str, str] = {}
        for a, k in zip(iq.tolist(), iv.tolist(), strict=True):
            name = model.position_names[a]
            if bool(turning[k]) == turns and name not in stated:
                size = _doubtful_size(model, k, float(np.abs(q[:, a]).max()))
                doubtful |= {name: size} if size else {}
        if doubtful:
            sentences.append(_position(list(doubtful), next(iter(doubtful.values())), turns, where))
    if "t" not in stated and len(t) >= _SLOW[1] and np.median(np.diff(t)) >= _SLOW[0]:
        sentences.append(
            f"The samples are {np.median(np.diff(t)):.3g} s apart. If t is in milliseconds, write "
            f"{where.format('t', 'ms')}."
        )
    return sentences


def _doubtful_size(model: Model, k: int, far: float) -> str:
    """Words for how far a coordinate goes, where that suggests degrees or millimetres instead of SI
    units; else empty."""
    allowed = ranges(model)
    turns = bool(allowed.turns[k])
    bound = max(abs(float(allowed.lower[k])), abs(float(allowed.upper[k])))
    ranged = np.isfinite(bound)
    limit = _BEYOND * bound if ranged else 2 * np.pi * _TURNS if turns else _FAR
    if far <= limit or far / (180 / np.pi if turns else 1e3) > limit:
        return ""
    size = f"{far:.3g} rad, {far / (2 * np.pi):.3g} turns" if turns else f"{far:.3g} m"
    if not ranged:
        return size
    return f"{size}, where its range ends at {bound:.3g} {'rad' if turns else 'm'}"


def _position(names: list[str], reached: str, turns: bool, where: str) -> str:
    name, others = names[0], names[1:]
    rest = f" ({listed(others, 6)} likewise)" if others else ""
    unit, short = ("degrees", "deg") if turns else ("millimetres", "mm")
    return (
        f"{name} goes to {reached}{rest}. If these are {unit}, write {where.format(name, short)}."
    )
