"""A motion for a robot of which nothing else is known: smooth, modest, within the limits, every
joint at once."""

from __future__ import annotations

import numpy as np

from freebody.arrays import Array, above_zero, is_count
from freebody.errors import FreebodyError, LoopError, listed, shown
from freebody.model.model import Model
from freebody.model.shafts import shaft_entries, untwisted
from freebody.motion.carried_twists import SMOOTH, with_carried_twists
from freebody.motion.closed_chain_motion import (
    consistent_rates,
    followed,
    home,
    leaders,
    outside,
    regularity,
)
from freebody.motion.files.measured_motions import rested
from freebody.motion.motion import Motion, derivatives
from freebody.motion.ranges import Ranges, ranges
from freebody.trees.position_rates import layout, state_of
from freebody.trees.positions import integrate, neutral

DURATION = 5.0
"""Duration of the default motion, s."""
SAMPLES = 401

_MARGIN = 0.08  # of the range, kept free at each limit
_SPEED = 0.6  # of the speed limit that is used
_MODEST = 0.7, 0.15  # amplitude (rad, m) where the limits allow more
_OFF = 0.8, 0.3  # from the middle of the range, where many arms are stretched (rad, m)
_CLEAR = 0.25  # of the regularity of a closed chain at its start that is left all along
_HALVINGS = 12
_GOLDEN = 0.5 * (np.sqrt(5.0) - 1.0)


def default_motion(model: Model, duration: float = DURATION, samples: int = SAMPLES) -> Motion:
    """A motion of every coordinate, from rest to rest, the same every time.

    duration: s. samples: number of them. Each coordinate swings about a middle with its own phase
    and one to two periods, under a window that brings rate and acceleration to zero at both ends;
    at most 0.7 rad or 0.15 m, 8 % clear of the limits and at 60 % of the speed limit. Free and
    spherical joints do likewise. The links of flexible joints move so, their shafts twisted by what
    they carry; in a closed chain shafts stay as they are.
    """
    duration = above_zero("default_motion", "duration", duration, "seconds")
    if not is_count(samples, 8):
        raise FreebodyError(
            f"default_motion: samples is {shown(samples)}, expected a whole number, at least 8."
        )
    if model.nv == 0:
        raise FreebodyError(f"default_motion: {model.name!r} has no movable joint.")
    t = np.linspace(0.0, duration, samples)
    if model.loops:
        return _of_closed_chain(model, t)
    rigid = untwisted(model)
    if rigid is None:
        return swing(model, t)
    return with_carried_twists(model, rigid, swing(rigid.model, t, SMOOTH))


def swing(model: Model, t: Array, power: int = 3) -> Motion:
    """The default motion of an open chain at times t (T,); power: of time with which it leaves
    rest."""
    duration, allowed = float(t[-1]), ranges(model)
    sines, speeds = _sines(model.nv, len(t), power)
    middle, amplitude = _swing(allowed, speeds / duration)
    q = integrate(model, neutral(model), middle + amplitude * sines)
    where = layout(model)
    x = state_of(where, q, np.zeros_like(q), np.zeros_like(q))[0]
    q, qd, qdd = state_of(where, x, *derivatives(t, x, at_rest=True))
    loose = f", also {listed(model.passive_names, 4)}, as if driven" if model.passive else ""
    text = (
        f"by default every joint swings within its limits{loose}, "
        f"from rest to rest in {duration:g} s"
    )
    return rested(model, Motion(t, q, qd, qdd, text, where, allowed.notices))


def _of_closed_chain(model: Model, t: Array) -> Motion:
    """A motion in which the driven joints swing about a position from which the mechanism moves
    well, as far as its loops let them."""
    start = home(model)
    leading = leaders(model, start)
    if not leading:
        raise FreebodyError(
            f"default_motion: the loops of {model.name!r} allow no motion; fb.mobility(model, q) "
            f"gives its degrees of freedom."
        )
    least = _CLEAR * regularity(model, start, leading)
    sines, _ = _sines(len(leading), len(t), 3)
    allowed = ranges(model)
    amplitude = np.where(allowed.turns, *_MODEST)[leading]
    amplitude[np.isin(leading, shaft_entries(model))] = 0.0
    for _ in range(_HALVINGS):
        try:
            q = followed(model, start, leading, amplitude * sines)
        except LoopError:
            q = None
        if q is not None and all(_clear(model, p, leading, least) for p in q[::8]):
            break
        amplitude = 0.6 * amplitude
    else:
        raise LoopError(
            f"default_motion: {model.name!r} hardly moves from {start}; give a motion of its "
            f"driven joints."
        )
    twists = shaft_entries(model)
    names = [model.velocity_names[k] for k in leading if k not in twists]
    text = (
        f"by default {', '.join(names)} {'swings' if len(names) == 1 else 'swing'} from rest to "
        f"rest in {t[-1]:g} s, the loops determine the other joints"
        f"{', shafts untwisted' if twists else ''}"
    )
    states = consistent_rates(model, t, q, at_rest=True)
    return rested(model, Motion(t, *states, text, layout(model), allowed.notices))


def _clear(model: Model, q: Array, leading: list[int], least: float) -> bool:
    """Whether a position is away from singular positions and within the limits."""
    return regularity(model, q, leading) > least and not outside(model, q)


def _sines(n: int, samples: int, power: int) -> tuple[Array, Array]:
    """Curves (samples, n) within ±1, and the largest slope of each (n,) over s from 0 to 1; power:
    of s with which they leave 0."""
    s = np.linspace(0.0, 1.0, samples)[:, None]
    k = np.arange(n)
    periods = 1.0 + (k * _GOLDEN) % 1.0
    phase = 2 * np.pi * ((0.25 + k * _GOLDEN**2) % 1.0)
    window = (4 * s * (1 - s)) ** power
    shape = window * np.sin(2 * np.pi * periods * (s - 0.5) + phase)
    shape /= np.abs(shape).max(axis=0)
    return shape, np.abs(np.gradient(shape, s[:, 0], axis=0)).max(axis=0)


def _swing(allowed: Ranges, speeds: Array) -> tuple[Array, Array]:
    """The middle and amplitude (n,) of each coordinate's swing; speeds: the largest rates (1/s) of
    curves of amplitude 1."""
    lower, upper = allowed.lower, allowed.upper
    span = upper - lower
    modest = np.where(allowed.turns, *_MODEST)
    amplitude = np.minimum(modest, np.where(np.isfinite(span), (0.5 - _MARGIN) * span, np.inf))
    amplitude = np.minimum(amplitude, _SPEED * allowed.velocity / speeds)
    clear = (
        np.where(np.isfinite(span), _MARGIN * span, np.where(allowed.turns, 0.1, 0.02)) + amplitude
    )
    low, high = lower + clear, upper - clear
    n = len(lower)
    off = np.where(allowed.turns, *_OFF) * np.where(np.arange(n) % 2 == 0, 1.0, -1.0)
    centre = np.where(np.isfinite(span), allowed.middle, np.clip(0.0, low, high))
    return np.clip(centre + off, low, high), amplitude
