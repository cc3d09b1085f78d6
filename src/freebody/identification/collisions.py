"""`fb.detect_collisions`: pushes that a log shows, by the observer of the generalized momentum.

The observer's residual follows the torques that act besides the drives', without accelerations (De
Luca, Mattone 2003; De Luca, Albu-Schäffer, Haddadin, Hirzinger 2006). It is never 0: what the
model lacks, the residual has too. So a push is what stands out of the log's own residual.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray
from scipy.ndimage import binary_dilation, label, maximum_filter1d
from scipy.signal import lfilter

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array, above_zero
from freebody.by_value import ByValue
from freebody.errors import FreebodyError
from freebody.identification.given_logs import require_suited, with_torques
from freebody.identification.log_equations import REST
from freebody.identification.logs.log import Log
from freebody.identification.logs.read_log import read_log
from freebody.identification.reported import Reported
from freebody.model.doubt_rules.aspects import DYNAMIC
from freebody.model.doubts import capital, doubts_on
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.outputs.display import TextTable, counted
from freebody.trees.controllers import momentum_observer

USUAL_GAIN = 20.0
"""Gain of the observer, 1/s: its residual follows a push within a twentieth of a second."""
_OF_NOISE = 8.0
"""Threshold over the residual's robust standard deviation, that it is at least."""
_BLOCK, _BLOCKS, _RARE = 1.0, 12, 1000.0
"""Time (s) of whose largest residual the tail is taken, so that samples' dependence does not count;
how many such blocks tell a tail; and the time (s) in which noise exceeds a threshold once."""
_LEAST = 0.02
"""Threshold over the RMS of a joint's torque, that it is at least: below it no model is."""
_SLOW = 4.0
"""Time (s) over which the residual's median is taken, which is what the model lacks; a push is
shorter than half of it."""
_MEDIANS, _HIDES, _RESTS = 20.0, 0.1, 0.95
"""Samples a second of this median; part of the residual's usual size from which on what dry
friction holds hides it; and part of a log that a joint may rest for its residual in motion to be
told."""
_SHORTEST, _APART = 0.02, 0.25
"""Time (s) that a push lasts at least above a threshold, and within which two count as one."""
_STARTS = 2.0
"""Standard deviations of the residual that a push's start is traced back to."""
_SLIPS, _STATIC = 0.1, 1.5
"""Time (s) before and after a rest in which a joint creeps, and what dry friction can hold there
over what it is in motion."""
_SETTLED = 5.0
"""Time constants of the observer within which what was before is forgotten."""
_ALONG = np.array([[0, 1, 0], [0, 1, 0], [0, 1, 0]])
"""Which neighbours make a run: samples of one joint."""
_NORMAL = 1.4826
"""Standard deviation of a normal distribution over its median absolute deviation."""


@dataclass(frozen=True)
class Collision:
    """A push in a log. start, end: s. joint: the outermost that the push turns, so that it struck
    the link behind it, or one farther out at a place where it turns no joint in between. torque:
    (n,) N m (N), the largest residual of each joint meanwhile, 0 below its threshold; a push
    shorter than the observer's time constant was stronger. times: that over the threshold at the
    joint where it stands out the most."""

    start: float
    end: float
    joint: str
    link: str
    torque: Array
    times: float


@dataclass(frozen=True, eq=False, repr=False)
class DetectedCollisions(Reported, ByValue):
    """Pushes that a log shows. time: (n,) s. residual: (n, joints) torque that acts besides the
    drives', N m (N), less what the model lacks all the time. threshold: (joints,) of it. judged:
    (n,) flags, false where nothing is told: at the log's ends, and in gaps; at a joint that rests
    what its dry friction holds is not told either."""

    collisions: tuple[Collision, ...]
    names: tuple[str, ...]
    time: Array
    residual: Array
    threshold: Array
    judged: NDArray[np.bool_]
    verdict: str
    notices: tuple[str, ...]
    _aside = ("verdict", "notices")

    def __len__(self) -> int:
        return len(self.collisions)

    def _title(self) -> str:
        return f"Detected collisions: {len(self.collisions)}"

    def _table(self) -> TextTable:
        rows = [
            (
                f"{x.start:.2f} … {x.end:.2f}",
                x.joint,
                x.link,
                ", ".join(f"{tau:.3g}" for tau in x.torque),
                f"{x.times:.1f}",
            )
            for x in self.collisions
        ]
        head = ("t (s)", "outermost joint", "struck link", "torque (N m, N)", "over threshold")
        return TextTable(head, rows, (self.verdict, *self.notices))


class _MomentumResidual(NamedTuple):
    """The residual (n, joints) of a log without its slow part; its robust standard deviation
    (joints,) in motion; how much of it (n, joints) the dry friction of resting joints can be; and
    which samples (n,) tell something."""

    values: Array
    spread: Array
    held: Array
    judged: NDArray[np.bool_]

    @property
    def beyond(self) -> Array:
        """How much of the residual's size (n, joints) no dry friction can be."""
        return np.maximum(np.abs(self.values) - self.held, 0.0)


def detect_collisions(
    model: Model,
    log: Log | str,
    *,
    clean: Log | str | None = None,
    gains: Any = None,
    observer: float = USUAL_GAIN,
) -> DetectedCollisions:
    """Pushes that a log shows: when, at which joint, and what torques they gave, by the observer of
    the generalized momentum (De Luca, Mattone 2003; De Luca and others 2006).

    A push stands out of the log's own residual; what the model lacks, such as friction that it does
    not know, raises the thresholds. They are so high that the residual of motions like those by
    which they are set exceeds one once in some 1000 s, by the tail of its largest values in each
    second. A push that lasts longer than two seconds counts as a load.

    Parameters
    ----------
    model
        As identified, with friction; an arm on a fixed base.
    log
        `fb.Log` or a file of `fb.read_log`.
    clean
        A log without pushes, of motions such as those of the log, by which thresholds are set. By
        default they are set by the log itself, which does as long as pushes are in fewer than a
        quarter of its seconds.
    gains
        Of the drives (n,), N m/A (N/A), for logs of currents, such as `fb.identify` found.
    observer
        Gain of the observer, 1/s: larger ones follow shorter pushes, and more of the noise.

    Returns
    -------
    DetectedCollisions
        With the residual and thresholds.

    Raises
    ------
    FreebodyError
        A log without torques, of other joints, or too short.
    """
    function = "detect_collisions"
    require_model(function, model)
    model.require_tree(function)
    above_zero(function, "observer", observer, "1/s")
    given = None if gains is None else np.broadcast_to(np.asarray(gains, float), (model.nv,))

    def residual_of(x: Log | str) -> tuple[Log, _MomentumResidual]:
        read = x if isinstance(x, Log) else read_log(x, model)
        require_suited(function, read, model.velocity_names)
        read = with_torques(function, read, given)
        return read, _residual(model, read, observer)

    own, found = residual_of(log)
    assert own.torque is not None
    spread = found.spread
    if clean is None:
        tail = _tail(found, own.rate, robust=True)
    else:
        read, other = residual_of(clean)
        spread, tail = np.maximum(spread, other.spread), _tail(other, read.rate, robust=False)
    threshold = np.maximum(_OF_NOISE * spread, tail)
    size = np.sqrt(np.mean(own.torque**2, axis=0))
    threshold = np.maximum(threshold, _LEAST * size)
    events = _events(model, own, found, threshold)
    notices = [*own.notices, *(capital(x.text) for x in doubts_on(model, *DYNAMIC))]
    large = [
        name
        for name, level, rms in zip(own.names, threshold, size, strict=True)
        if level > 0.5 * rms
    ]
    if large:
        notices.append(
            f"The model leaves so much at {', '.join(large)} that pushes below half the torque of "
            f"its motion do not show there; identify the robot first, with its friction."
        )
    verdict = _verdict(events, threshold, own)
    return DetectedCollisions(
        events,
        own.names,
        own.time,
        found.values,
        threshold,
        found.judged,
        verdict,
        tuple(notices),
    )


def _residual(model: Model, log: Log, gain: float) -> _MomentumResidual:
    """The residual of a log; the observer sees all samples at once, and its recursion, which is
    linear, is run behind it."""
    assert log.torque is not None
    h, n = 1.0 / log.rate, len(log.time)
    if n < 4.0 * log.rate:
        raise FreebodyError(
            f"detect_collisions: the log {log.source!r} lasts {n * h:.3g} s, expected 4 s at "
            f"least, so that what the model lacks is told from a push."
        )
    q, qd, qdd = log.states()
    bare = model.without("friction")
    # from an integral of 0, r = k (p - u) / (1 + h k) and integral = u + h r, where u is what the
    # torques add to the momentum over h; so one call tells p and u of all samples
    r, integral = momentum_observer(bare, q, qd, log.torque, h, np.zeros_like(q), gain)
    u = integral - h * r
    p = r * (1.0 + h * gain) / gain + u
    friction, held = _friction(model, bare, q, qd, qdd, log.rate)
    change = np.diff(p, axis=0, prepend=p[:1]) - u + h * friction
    filtered = [
        np.asarray(lfilter([gain], [1.0 + h * gain, -1.0], x, axis=0), dtype=float)
        for x in (change, h * held)
    ]
    values = filtered[0] - _slow_part(filtered[0], filtered[1], log.rate)
    judged = log.settled(_SETTLED / gain)
    if not judged.any():
        raise FreebodyError(
            f"detect_collisions: the log {log.source!r} has no {2.0 * _SETTLED / gain:.3g} s "
            f"without a gap; nothing is told."
        )
    hidden = _hidden(values, filtered[1])
    told = np.where(
        hidden[judged].mean(axis=0) < _RESTS, hidden | ~judged[:, None], ~judged[:, None]
    )
    spread = _NORMAL * np.nanmedian(np.where(told, np.nan, np.abs(values)), axis=0)
    return _MomentumResidual(values, spread, filtered[1], judged)


def _hidden(residual: Array, held: Array) -> NDArray[np.bool_]:
    """Flags (n, joints): where dry friction that holds a resting joint hides the residual."""
    return held > _HIDES * np.median(np.abs(residual), axis=0)


def _tail(found: _MomentumResidual, rate: float, robust: bool) -> Array:
    """The level (joints,) that the residual exceeds once in `_RARE` seconds, where its largest
    values in each second are distributed exponentially beyond their median; 0 of too short a log.
    robust: whether pushes may be among them."""
    size = int(_BLOCK * rate)
    beyond = np.where(found.judged[:, None], found.beyond, np.nan)
    blocks = beyond[: len(beyond) // size * size].reshape(-1, size, beyond.shape[1])
    largest = np.max(blocks, axis=1)  # NaN of a block that is not judged throughout
    largest = largest[np.isfinite(largest).all(axis=1)]
    if len(largest) < _BLOCKS:
        return np.zeros(beyond.shape[1])
    median = np.median(largest, axis=0)
    if robust:
        scale = (np.quantile(largest, 0.75, axis=0) - median) / np.log(2.0)
    else:
        scale = 2.0 * np.mean(np.maximum(largest - median, 0.0), axis=0)
    return np.asarray(median + scale * np.log(0.5 * _RARE / _BLOCK))


def _slow_part(residual: Array, held: Array, rate: float) -> Array:
    """The slow part of a residual (n, joints), which the model lacks all the time: its median
    over `_SLOW` seconds of those samples at which no dry friction of a resting joint hides it,
    straight in between."""
    step = max(1, int(rate / _MEDIANS))
    some = np.where(_hidden(residual, held), np.nan, residual)[::step]
    half = int(0.5 * _SLOW * rate / step)
    padded = np.pad(some, ((half, half), (0, 0)), constant_values=np.nan)
    windows = sliding_window_view(padded, 2 * half + 1, axis=0)
    told = np.isfinite(windows).sum(axis=2) > 0.5 * half
    at, places = np.arange(len(residual)), np.arange(0, len(residual), step)
    found = np.zeros_like(residual)
    for j in np.flatnonzero(told.any(axis=0)).tolist():
        medians = np.nanmedian(windows[told[:, j], j], axis=1)
        found[:, j] = np.interp(at, places[told[:, j]], medians)
    return found


def _friction(
    model: Model, bare: Model, q: Array, qd: Array, qdd: Array, rate: float
) -> tuple[Array, Array]:
    """Torques (n, joints) of friction, of joints at rest the middle of what it can hold; and by how
    much it can differ from that there."""
    both = []
    for way in (-1.0, 1.0):
        rates = np.where(np.abs(qd) < REST, way * REST, qd)
        with_friction = inverse_dynamics(model, q, rates, qdd)
        both.append(with_friction - inverse_dynamics(bare, q, rates, qdd))
    held = 0.5 * _STATIC * np.abs(both[1] - both[0])
    around = maximum_filter1d(held, 2 * int(_SLIPS * rate) + 1, axis=0)
    return 0.5 * (both[0] + both[1]), np.asarray(around, dtype=float)


def _events(
    model: Model, log: Log, found: _MomentumResidual, threshold: Array
) -> tuple[Collision, ...]:
    """The pushes: runs of samples at which a residual is above its threshold, long enough, those
    near one another being one."""
    size = np.abs(found.values)
    above = (found.beyond > threshold) & found.judged[:, None]
    runs, count = _numbered(above, _ALONG)
    lengths = np.bincount(runs.ravel(), minlength=count + 1)
    above &= lengths[runs] >= max(1, int(_SHORTEST * log.rate))
    apart = max(1, int(0.5 * _APART * log.rate))
    numbers, count = _numbered(binary_dilation(above.any(axis=1), iterations=apart))
    links = {body.joint.name: body.name for body in model.bodies}
    made = []
    for k in range(1, count + 1):
        where = np.flatnonzero((numbers == k) & above.any(axis=1))
        shown, meanwhile = above[where], size[where]
        largest = np.argmax(np.where(shown, meanwhile, 0.0), axis=0)
        values = found.values[where[largest], np.arange(len(threshold))]
        torque = np.where(shown.any(axis=0), values, 0.0)
        over = np.where(shown, meanwhile / threshold, 0.0).max(axis=0)
        strongest, start = int(np.argmax(over)), int(where[0])
        while start > 0 and size[start - 1, strongest] > _STARTS * found.spread[strongest]:
            start -= 1
        name = log.names[int(np.flatnonzero(torque)[-1])]
        ends = float(log.time[start]), float(log.time[where[-1]])
        made.append(Collision(*ends, name, links[name], torque, float(over.max())))
    return tuple(made)


def _numbered(flags: Any, structure: Any = None) -> tuple[NDArray[np.intp], int]:
    """Numbers from 1 of the runs of flags, 0 elsewhere, and how many there are."""
    found: Any = label(flags, structure)
    return found[0], int(found[1])


def _verdict(events: tuple[Collision, ...], threshold: Array, log: Log) -> str:
    levels = ", ".join(
        f"{name} {level:.3g}" for name, level in zip(log.names, threshold, strict=True)
    )
    told = f"thresholds (N m, N): {levels}"
    if not events:
        return f"No collision shows; {told}."
    first = events[0]
    more = f"the first at {first.start:.2f} s, seen up to {first.joint}"
    return f"{counted(len(events), 'collision')}, {more}; {told}."
