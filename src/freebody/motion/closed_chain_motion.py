"""Motions of closed chains: some coordinates lead, and the loops determine the others."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from freebody.algorithms.singular_thresholds import RANK
from freebody.arrays import Array
from freebody.errors import LoopError
from freebody.loops.assembly import assemble
from freebody.loops.closure_checks import closing, free_coordinates, scaled_jacobian
from freebody.loops.mobility import mobility
from freebody.loops.rates import loop_acceleration, loop_velocity
from freebody.loops.redundancy import redundancy
from freebody.loops.scaled_equations import backward, length, null_space, rate_scale
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries, untwisted
from freebody.motion.motion import Motion, derivatives
from freebody.motion.piecewise import hermite
from freebody.motion.ranges import position_columns, ranges
from freebody.outputs.number_text import compared
from freebody.trees.position_rates import (
    continuous,
    layout,
    position_acceleration,
    position_rate,
    state_of,
)
from freebody.trees.positions import difference, integrate, neutral, random_state

_SEEDS = 24
_TELLING = 1e-6  # regularity below which some coordinates do not tell the others
_AGREE = 1e-4  # of the length: how far a column that is not needed may be off
_RATES_AGREE = 1e-2  # of the largest: the same of rates and accelerations
_JUMP = 0.5  # rad: between samples nothing moves so far but by changing to another way of closing
_BY_SAMPLE = "at sample {}; make the motion smaller, or its samples closer"
_GOOD = 0.15  # regularity at which a home is as good as any


def leaders(model: Model, q: Array) -> list[int]:
    """Coordinates that determine all others near the closed position q (nq,): the driven joints'
    and the shafts' of flexible joints if they do, else the choice of `mobility`."""
    N, _ = null_space(scaled_jacobian(model, q), RANK)
    own = sorted({*model.driven, *shaft_entries(model)})
    if len(own) == N.shape[1] and np.linalg.matrix_rank(N[own], tol=1e-6) == len(own):
        return own
    return free_coordinates(model, mobility(model, q).independent, "leaders")


def home(model: Model) -> Array:
    """The closed position (nq,) near the model's home; without one, a position within the limits
    from which the mechanism moves well: the first good one, else the best. Shafts of flexible
    joints are untwisted, unless the model's home twists them."""
    rigid = untwisted(model)
    if rigid is not None and rigid.model.home == model.home:
        return rigid.at(home(rigid.model))
    if model.home:
        return assemble(model)
    starts = [neutral(model), *(random_state(model, seed=k)[0] for k in range(_SEEDS))]
    best, quality = None, (-model.nv - 1, 0, 0.0)
    for start in starts:
        try:
            q = assemble(model, start)
        except LoopError:
            continue
        if mobility(model, q).singular:
            continue
        N, _ = null_space(scaled_jacobian(model, q), RANK)
        # in a folded position parts stand still
        moving = int((np.linalg.norm(N, axis=1) > 1e-6).sum())
        found = -outside(model, q), moving, min(regularity(model, q, leaders(model, q)), _GOOD)
        if found > quality:
            best, quality = q, found
        if quality == (0, model.nv, _GOOD):
            break
    if best is None:
        raise LoopError(
            f"no closed position of {model.name!r} was found from {len(starts)} starts; give a "
            f"motion, or close it with fb.assemble(model, q) from a better guess."
        )
    return best


def outside(model: Model, q: Array) -> int:
    """The number of coordinates of q (nq,) beyond their limits."""
    iq, iv = position_columns(model)
    allowed = ranges(model)
    return int(((q[iq] < allowed.lower[iv]) | (q[iq] > allowed.upper[iv])).sum())


def regularity(model: Model, q: Array, leading: Sequence[int]) -> float:
    """How clearly the leading coordinates determine the others at q: 1 at best, 0 where they do
    not."""
    N, _ = null_space(scaled_jacobian(model, q), RANK)
    if N.shape[1] != len(leading):
        return 0.0
    return float(np.linalg.svd(N[list(leading)], compute_uv=False).min(initial=1.0))


def followed(
    model: Model,
    start: Array,
    leading: Sequence[int],
    way: Array,
    place: Callable[[int], str] = _BY_SAMPLE.format,
) -> Array:
    """Closed positions (T, nq) from the closed start (nq,), the leading coordinates moved by way
    (T, len(leading)).

    Raises LoopError with the place of the sample where the loops let them go no further.
    """
    others = [k for k in range(model.nv) if k not in leading]
    q, before = [], start
    done = np.zeros(len(leading))
    for k, reached in enumerate(way):
        step = np.zeros(model.nv)
        step[list(leading)] = reached - done
        N, _ = null_space(scaled_jacobian(model, before), RANK)
        scaled = step / rate_scale(model)
        if N.shape[1] == len(leading):  # the others go along, to first order
            scaled = N @ np.linalg.lstsq(N[list(leading)], scaled[list(leading)], rcond=None)[0]
        guess = integrate(model, before, scaled * rate_scale(model))
        # the leading ones land exactly
        guess = integrate(model, guess, _missing(model, start, guess, leading, reached))
        closed, left = closing(model, guess[None], others)
        moved = np.abs(difference(model, before, closed[0]) / rate_scale(model)).max()
        if left[0] > 1e-11 or moved > _JUMP or backward(model, closed).any():
            raise LoopError(f"the loops of {model.name!r} block the driven joints {place(k)}.")
        before, done = closed[0], reached
        q.append(before)
    return np.array(q)


def _missing(model: Model, start: Array, q: Array, leading: Sequence[int], reached: Array) -> Array:
    """The difference (nv,) between the wanted position start + reached of the leading coordinates
    and theirs at q."""
    step = np.zeros(model.nv)
    step[list(leading)] = reached - difference(model, start, q)[list(leading)]
    return step


def completed(
    model: Model,
    t: Array,
    columns: Mapping[str, Array],
    source: str,
    before: Array | None = None,
) -> Motion:
    """The motion (T samples) in which the named positions follow their columns (T,) and the loops
    determine the others.

    The positions named must determine the others. `name.v` and `name.a` give rates and
    accelerations of all that lead, else they are differentiated; before: (T, nv) the accelerations
    with which the times are reached. Columns that are not needed are held against what the loops
    say. Raises LoopError.
    """
    rate_of = _simple_coordinates(model)
    leading, start = _leading(model, columns, rate_of)
    names = [model.velocity_names[k] for k in leading]
    way = np.stack([columns[name] - columns[name][0] for name in names], axis=-1)
    q = followed(model, start, leading, way)
    closed = dict(zip(model.position_names, q.T, strict=True))
    _refuse_off(model, t, columns, closed, names, _AGREE * length(model))
    text = f"{source}; {', '.join(names)} as given, the others by the loops, rates "
    if not any(f"{name}{ending}" in columns for name in rate_of for ending in (".v", ".a")):
        text += "by a spline through the positions"
        states = consistent_rates(model, t, q, at_rest=False)
        return Motion(t, *states, text, layout(model), differentiated="positions")
    return _with_rates(model, t, q, columns, names, before, f"{text}as given")


def _simple_coordinates(model: Model) -> dict[str, int]:
    """The velocity coordinate of each position that has one of its own, by name."""
    iq, iv = position_columns(model)
    return {model.position_names[a]: int(b) for a, b in zip(iq, iv, strict=True)}


def _leading(
    model: Model, columns: Mapping[str, Array], rate_of: Mapping[str, int]
) -> tuple[list[int], Array]:
    """The coordinates that lead among the positions with columns, and the closed position (nq,) at
    the first sample. Raises LoopError where they do not determine the others."""
    given = [name for name in model.position_names if name in columns]
    start = home(model)
    for name in given:
        start[model.position_names.index(name)] = columns[name][0]
    leading = leaders(model, assemble(model, start))
    if not {model.velocity_names[k] for k in leading} <= set(given):
        leading = [rate_of[name] for name in given if name in rate_of]
    others = [name for k, name in enumerate(model.velocity_names) if k not in leading]
    start = assemble(model, start, free=others)
    if regularity(model, start, leading) < _TELLING:
        names = [model.velocity_names[k] for k in leading]
        raise LoopError(
            f"the positions of {', '.join(names)} do not determine those of the other joints of "
            f"{model.name!r}; give those of {', '.join(model.driven_names)}."
        )
    return leading, start


def _with_rates(
    model: Model,
    t: Array,
    q: Array,
    columns: Mapping[str, Array],
    names: Sequence[str],
    before: Array | None,
    text: str,
) -> Motion:
    """The motion of closed positions q (T, nq) with given rates of the leading coordinates `names`;
    see `completed`."""
    where, scale, pieces = layout(model), rate_scale(model), None
    simple = _simple_coordinates(model).items()
    accelerated = any(f"{name}.a" in columns for name, _ in simple)
    rates = _leading_columns(columns, names, ".v")
    slopes = {f"{name}.a": derivatives(t, x[:, None])[0][:, 0] for name, x in rates.items()}
    seconds = _leading_columns(columns if accelerated else slopes, names, ".a")
    qd = loop_velocity(model, q, rates)
    qdd = loop_acceleration(model, q, qd, seconds)
    found = [(".v", qd, columns), (".a", qdd, columns)]
    if before is not None:
        arriving = {f"{name}.a": before[:, k] for name, k in simple}
        reached = loop_acceleration(model, q, qd, _leading_columns(arriving, names, ".a"))
        found.append((".a", reached, arriving))
        x = continuous(where, q)
        ends = (position_acceleration(where, x, qd, end) for end in (qdd, reached))
        pieces = hermite(t, x, position_rate(where, x, qd), *ends)
    for ending, values, held in found:
        allowed = _RATES_AGREE * float(np.abs(values / scale).max()) * scale
        for name, k in simple:
            closed = {f"{name}{ending}": values[:, k]}
            _refuse_off(model, t, held, closed, names, float(allowed[k]))
    how = "" if accelerated else "rates"
    return Motion(t, q, qd, qdd, text, where, differentiated=how, pieces=pieces)


def _leading_columns(columns: Mapping[str, Array], names: Sequence[str], ending: str) -> Any:
    """The columns (T,) of rates or accelerations of the leading coordinates, by name. Raises
    LoopError where one is missing."""
    for name in names:
        if f"{name}{ending}" not in columns:
            raise LoopError(
                f"there is no column for '{name}{ending}'; a closed chain needs rates of all of "
                f"{', '.join(names)}, and accelerations with their rates, or none."
            )
    return {name: columns[f"{name}{ending}"] for name in names}


def _refuse_off(
    model: Model,
    t: Array,
    columns: Mapping[str, Array],
    closed: Mapping[str, Array],
    names: Sequence[str],
    allowed: float,
) -> None:
    """Refuse columns that deviate from the positions that the loops and the leading coordinates
    `names` give."""
    for name in (name for name in closed if name in columns):
        off = np.abs(closed[name] - columns[name])
        if off.max() > allowed:
            k = int(np.argmax(off))
            given_there, there = compared(columns[name][k], closed[name][k], digits=6)
            raise LoopError(
                f"{name!r} is {given_there} at t = {t[k]:.6g} s, where the loops of {model.name!r} "
                f"and {', '.join(names)} put it at {there}; leave the column out."
            )


def consistent_rates(model: Model, t: Array, q: Array, at_rest: bool) -> tuple[Array, Array, Array]:
    """(q, qd, qdd) of closed positions q (T, nq) at times t: by differentiation, then made
    consistent with the loops."""
    where = layout(model)
    q, qd, qdd = state_of(where, q, *derivatives(t, continuous(where, q), at_rest=at_rest))
    if redundancy(model).rank is not None:
        # made consistent to the last digit with rounded equations, they no longer were with q
        return q, qd, qdd
    qd = loop_velocity(model, q, qd)
    return q, qd, loop_acceleration(model, q, qd, qdd)
