"""Magnitudes of a motion that look like another unit: degrees, millimetres, milliseconds."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array
from freebody.errors import listed
from freebody.model.model import Model
from freebody.motion.ranges import position_columns, ranges

_BEYOND = 1.5  # times the range: what is farther out is doubtful
_TURNS = 2.0  # without a range
_FAR = 50.0  # m, without a range
_SLOW = 1.0, 100  # s between samples, and so many of them


def implausible_units(
    model: Model, t: Array, q: Array, told: frozenset[str], where: str
) -> list[str]:
    """Sentences on positions q (T, nq) and times t that are in SI units only if the motion is a
    strange one.

    told: columns whose unit was stated, which are believed. where: what the unit is written in,
    with a place for a name and a unit.
    """
    iq, iv = position_columns(model)
    allowed = ranges(model)
    found: dict[bool, list[str]] = {True: [], False: []}
    words: dict[bool, str] = {}
    for a, k in zip(iq.tolist(), iv.tolist(), strict=True):
        name = model.position_names[a]
        turns = bool(allowed.turns[k])
        far = float(np.abs(q[:, a]).max())
        bound = max(abs(float(allowed.lower[k])), abs(float(allowed.upper[k])))
        ranged = np.isfinite(bound)
        limit = _BEYOND * bound if ranged else 2 * np.pi * _TURNS if turns else _FAR
        if name in told or far <= limit or far / (180 / np.pi if turns else 1e3) > limit:
            continue
        found[turns].append(name)
        if turns not in words:
            size = f"{far:.3g} rad, {far / (2 * np.pi):.3g} turns" if turns else f"{far:.3g} m"
            ends = (
                f", where its range ends at {bound:.3g} {'rad' if turns else 'm'}" if ranged else ""
            )
            words[turns] = f"{size}{ends}"
    sentences = [
        _position(found[turns], words[turns], turns, where)
        for turns in (True, False)
        if found[turns]
    ]
    if "t" not in told and len(t) >= _SLOW[1] and np.median(np.diff(t)) >= _SLOW[0]:
        sentences.append(
            f"The samples are {np.median(np.diff(t)):.3g} s apart. If t is in milliseconds, write "
            f"{where.format('t', 'ms')}."
        )
    return sentences


def _position(names: list[str], reached: str, turns: bool, where: str) -> str:
    name, others = names[0], names[1:]
    rest = f" ({listed(others, 6)} likewise)" if others else ""
    unit, short = ("degrees", "deg") if turns else ("millimetres", "mm")
    return (
        f"{name} goes to {reached}{rest}. If these are {unit}, write {where.format(name, short)}."
    )
