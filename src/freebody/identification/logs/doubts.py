"""Doubts about what a log says: spikes, turns that were cut off, units that cannot be, rates that
are not those of the positions, torques that were not measured."""

from __future__ import annotations

from collections.abc import Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import listed
from freebody.identification.logs.clock import RowPlace, RowRefusal
from freebody.model.model import Model
from freebody.motion.ranges import Flags, ranges
from freebody.outputs.display import counted
from freebody.outputs.number_text import compared

_TURN = 2.0 * np.pi
_DEGREES = 180.0 / np.pi
_BEYOND = 1.5  # times a limit: what is farther out is doubtful
_EFFORT = 3.0  # times the effort limit
_TYPICAL = 99.5
"""Percentile of the samples' roughness, and of their range, against which a spike is held."""
_SPIKE = 10.0, 0.25
"""How far beyond the typical roughness a spike is, and which part of the typical range."""
_SOME = 5000
"""Rows from which percentiles are taken."""
_MOVES = 1e-3  # rad, m: a joint whose range is smaller does not move
_AGREE = 0.1  # of a rate
_FOLLOWS = 0.9
"""Correlation from which rates are the positions', but for a factor."""
_FACTORS = (
    (-1.0, "have the other sign", "write signs, or turn the sign of one of them"),
    (_DEGREES, "are in degrees where the rates are in rad/s",
     'write units = { position = "deg" }'),
    (1.0 / _DEGREES, "are in rad where the rates are in deg/s",
     'write units = { velocity = "deg/s" }'),
    (_TURN / 60.0, "are in rad where the rates are in rpm",
     'write units = { velocity = "rpm" }'),
    (1e3, "are in millimetres, or the times in milliseconds", "write the units"),
    (1e-3, "have rates in millimetres per second, or the times are in other units",
     "write the units"),
)  # fmt: skip
"""Slopes of positions over rates, what they say of the positions, and what to write."""


def spikes(samples: dict[str, Array]) -> NDArray[np.bool_]:
    """Flags (n,): rows in which some value lies far off between two neighbours that agree; samples:
    arrays (n, k)."""
    count = len(next(iter(samples.values())))
    found, some = np.zeros(count, dtype=bool), slice(None, None, 1 + count // _SOME)
    for x in samples.values():
        off = np.zeros_like(x)
        off[1:-1] = np.abs(x[1:-1] - 0.5 * (x[:-2] + x[2:]))
        low, high = np.percentile(x[some], [100.0 - _TYPICAL, _TYPICAL], axis=0)
        usual = np.percentile(off[some], _TYPICAL, axis=0)
        most = np.maximum(_SPIKE[0] * usual, _SPIKE[1] * (high - low))
        if not (off > most).any():
            continue
        agree = np.zeros_like(off, dtype=bool)
        agree[1:-1] = np.abs(x[2:] - x[:-2]) < _SPIKE[1] * off[1:-1]
        found |= ((off > most) & agree).any(axis=1)
    return found


def unwrapped(
    q: Array, turns: Flags, names: tuple[str, ...], where: RowPlace
) -> tuple[Array, list[str]]:
    """Positions (n, joints) without steps by whole turns, and a sentence on what was joined."""
    jumps = np.where(turns, np.rint(np.diff(q, axis=0) / _TURN), 0.0)
    near = np.abs(np.diff(q, axis=0) - jumps * _TURN) < 0.5
    jumps = np.where(near, jumps, 0.0)
    if not jumps.any():
        return q, []
    joined = q.copy()
    joined[1:] -= _TURN * np.cumsum(jumps, axis=0)
    row, _ = np.argwhere(jumps)[0]
    who = listed((names[k] for k in np.flatnonzero(jumps.any(axis=0))), 6)
    return joined, [
        f"The positions of {who} step by whole turns at "
        f"{counted(int((jumps != 0).sum()), 'place')} ({where(int(row) + 1)} first), where an "
        f"encoder starts anew, and were joined."
    ]


class RateCheck(NamedTuple):
    """Whether the rates are those of the positions."""

    useless: bool
    """Whether they have so little to do with the positions that those are differentiated."""
    notices: list[str]


def rates_checked(
    t: Array, q: Array, qd: Array, names: tuple[str, ...], refuse: RowRefusal
) -> RateCheck:
    """The rates (n, joints) compared with the slopes of the positions; raises what `refuse` makes
    where a factor lies between them."""
    steps = np.diff(t)
    usual = steps < 5.0 * np.median(steps)
    slopes = (np.diff(q, axis=0) / steps[:, None])[usual]
    mean = (0.5 * (qd[1:] + qd[:-1]))[usual]
    moving = np.ptp(q, axis=0) > _MOVES
    power, cross = (mean**2).sum(axis=0), (mean * slopes).sum(axis=0)
    told = moving & (power > 0.0)
    ratio = np.divide(cross, power, out=np.ones(len(names)), where=told)
    size = np.sqrt(power * (slopes**2).sum(axis=0))
    follows = np.divide(np.abs(cross), size, out=np.zeros(len(names)), where=size > 0.0)
    wrong = moving & (~told | (np.abs(ratio - 1.0) > _AGREE))
    for k in np.flatnonzero(wrong & (follows > _FOLLOWS)).tolist():
        near = [x for x in _FACTORS if abs(ratio[k] / x[0] - 1.0) < _AGREE]
        what, remedy = near[0][1:] if near else ("do not belong together", "write the units")
        raise refuse(
            f"the positions of {names[k]} change {ratio[k]:.4g} times as fast as its rates say: "
            f"the positions {what}; {remedy} in the table [log] of the log's TOML file.",
            None,
        )
    if not wrong.any():
        return RateCheck(False, [])
    k = int(np.argmax(wrong))
    return RateCheck(
        True,
        [
            f"The rates of {listed((names[k] for k in np.flatnonzero(wrong)), 6)} are not those of "
            f"the positions (correlation {follows[k]:.2g} for {names[k]}): the positions are "
            f"differentiated instead."
        ],
    )


def beyond_limits(
    model: Model, values: dict[str, Array], stated: frozenset[str], refuse: RowRefusal
) -> Iterator[str]:
    """Sentences on values (n, joints) beyond the model's limits; raises what `refuse` makes where
    they are within them in degrees or millimetres."""
    allowed, names = ranges(model), model.velocity_names
    far = np.abs(values["position"]).max(axis=0)
    bound = np.maximum(np.abs(allowed.lower), np.abs(allowed.upper))
    bound = np.where(np.isfinite(bound), bound, np.where(allowed.turns, 2.0 * _TURN, np.inf))
    scale = np.where(allowed.turns, _DEGREES, 1e3)
    if "position" not in stated:
        for k in np.flatnonzero((far > _BEYOND * bound) & (far / scale <= _BEYOND * bound)):
            unit, short = ("rad", "deg") if allowed.turns[k] else ("m", "mm")
            reached, end = compared(far[k], bound[k])
            raise refuse(
                f"{names[k]} goes to {reached} {unit}, where its range ends at {end} "
                f'{unit}: if these are {short}, write units = {{ position = "{short}" }} in the '
                f'table [log] of the log\'s TOML file; if not, "{unit}".',
                None,
            )
    for key, most, factor, words in (
        ("position", bound, 1.0 + 1e-3, "go beyond the range of"),
        ("velocity", allowed.velocity, _BEYOND, "are far beyond the speed limit of"),
        ("torque", allowed.effort, _EFFORT, "are far beyond the effort limit of"),
    ):
        if key not in values:
            continue
        size = np.abs(values[key]).max(axis=0)
        out = np.flatnonzero(size > factor * most)
        if len(out):
            k = int(out[0])
            yield (
                f"The log's {_PLURAL[key]} {words} {listed((names[i] for i in out), 6)}: "
                f"{size[k]:.4g} where the model says {most[k]:.4g}; are the units and the model "
                f"right?"
            )


_PLURAL = {"position": "positions", "velocity": "rates", "torque": "torques", "current": "currents"}


def unmeasured(
    values: dict[str, Array], names: tuple[str, ...], refuse: RowRefusal
) -> Iterator[str]:
    """Sentences on joints that never move and on torques that never change; raises what `refuse`
    makes where no torque does."""
    for key in ("torque", "current"):
        if key not in values:
            continue
        dead = np.asarray(np.ptp(values[key], axis=0) == 0.0)
        if dead.all():
            raise refuse(
                f"all {_PLURAL[key]} are constant ({values[key][0, 0]:.4g}): they were not "
                f"measured; log the drives' {_PLURAL[key]} too.",
                None,
            )
        if dead.any():
            who = listed((names[k] for k in np.flatnonzero(dead)), 6)
            yield f"The {_PLURAL[key]} of {who} never change: they were not measured."
    still = np.flatnonzero(np.asarray(np.ptp(values["position"], axis=0) < _MOVES))
    if len(still) == len(names):
        raise refuse("no joint moves in this log; log a motion.", None)
    if len(still):
        yield (
            f"{listed((names[k] for k in still), 6)} never moves: the log tells nothing of its "
            f"friction, and little of what it carries."
        )


def resting_ends(t: Array, q: Array, kept: float) -> tuple[slice, list[str]]:
    """The samples without rests at both ends beyond `kept` (s), and a sentence on what was left
    out."""
    first = _first_moved(q)
    last = len(q) - 1 - _first_moved(q[::-1])
    start = int(np.searchsorted(t, t[first] - kept))
    stop = int(np.searchsorted(t, t[last] + kept, side="right"))
    cut = t[start] - t[0], t[-1] - t[stop - 1]
    if first >= last or max(cut) < kept:
        return slice(None), []
    return slice(start, stop), [
        f"Rests of {cut[0]:.3g} s at the beginning and {cut[1]:.3g} s at the end were left out."
    ]


def _first_moved(q: Array) -> int:
    """The first row of positions (n, joints) that is not where they rest at the beginning."""
    away = np.abs(q - np.median(q[:9], axis=0)).max(axis=1)
    return int(np.argmax(away > 2.0 * _MOVES))
