"""`excitation`: a motion that tells the most of a robot's parameters within its limits, and how
well it tells each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from freebody.arrays import Array, above_zero, is_count
from freebody.by_value import ByValue
from freebody.errors import FreebodyError
from freebody.identification.excitation.fourier import FourierMotions
from freebody.identification.excitation.information import (
    MotionInformation,
    noise_of_torques,
)
from freebody.identification.excitation.motion_limits import MotionLimits, slowed, walls_of
from freebody.identification.excitation.motion_search import MotionSearch
from freebody.identification.filters import SETTLES
from freebody.identification.log_equations import REST
from freebody.model.doubts import doubts_used
from freebody.model.drives import assumed_by
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.planning.planning_limits import Limit, planning_limits
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import compared, shortest
from freebody.trees.position_rates import layout
from freebody.trees.public_calls import JointVector

_CYCLES = 0.5  # Hz, of the highest harmonic
_HARMONICS = 4, 15
"""Fewest and most harmonics that are chosen."""


@dataclass(frozen=True, eq=False, repr=False)
class Excitation(Tabled, ByValue):
    """A motion for identification, and how well its log will tell each parameter.

    deviations: (parameters,) standard deviations expected of what `fb.identify` finds, of base
    parameters and then of friction, by `names`; kg, kg m, kg m², N m and so on. noise: (nv,)
    standard deviation of the torques' noise, sample by sample at `rate` Hz, N m or N, in proportion
    to which they are.
    """

    motion: Motion
    names: tuple[str, ...]
    deviations: Array
    base: int
    """The number of base parameters, the first of the names."""
    noise: Array
    rate: float
    notices: tuple[str, ...] = ()
    _aside = ("notices",)

    @property
    def worst(self) -> tuple[str, float]:
        """The base parameter that is told worst, and its standard deviation."""
        k = int(np.argmax(self.deviations[: self.base]))
        return self.names[k], float(self.deviations[k])

    def deviation(self, name: str) -> float:
        """The standard deviation expected of a parameter."""
        return float(self.deviations[self.names.index(name)])

    def _title(self) -> str:
        name, size = self.worst
        return (
            f"Excitation: {self.motion.duration:.4g} s, {counted(self.base, 'base parameter')}, "
            f"the worst {name} to {shortest(size, 3)}"
        )

    def _table(self) -> TextTable:
        rows = [(n, shortest(x, 3)) for n, x in zip(self.names, self.deviations, strict=True)]
        return TextTable(("parameter", "standard deviation (SI)"), rows, self.notices)


def excitation(
    model: Model,
    duration: float,
    *,
    harmonics: int | None = None,
    velocity: Limit = None,
    acceleration: Limit = None,
    torque: Limit = None,
    box: ArrayLike | None = None,
    frames: Sequence[str] | None = None,
    noise: JointVector | float | None = None,
    rate: float = 100.0,
    friction: Sequence[str] = assumed_by("excitation"),
    quasi_static: bool = False,
    seed: int = 0,
) -> Excitation:
    """A motion from rest to rest that tells the base parameters and the friction of a robot as well
    as its limits allow, with the accuracy expected of each.

    Joints are finite Fourier series. From random ones the determinant of the information is
    maximised, then the largest variance of a base parameter minimised; limits are kept between
    samples too. Collisions are not looked at: give a box.

    Parameters
    ----------
    model
        The robot, an open chain; its masses count for torques alone.
    duration : s
        Length of the motion. A second at both ends tells nothing, since filters settle there.
    harmonics
        Of each joint; None: so many that the highest is 0.5 Hz, 4 to 15.
    velocity, acceleration, torque : one number for all joints, or (nv,); rad/s, rad/s², N m (m, N)
        Limits; the model's limits of position, speed and effort apply too.
    box : (2, dim), m
        The lowest and the highest corner, in the world's axes, of the space that origins of frames
        stay in; infinite where there is no wall.
    frames
        Names of these frames; None: all that move, and the tip.
    noise : one number, or (nv,); N m or N
        Standard deviation of the noise in each sample of the torques; None: 1 % of the effort limit
        where there is one, else 1.
    rate : Hz
        Samples a second of the log to be made, and of the motion returned.
    friction
        Laws of friction that the joints have, of one parameter each.
    quasi_static
        Whether to move slowly, at up to 0.2 rad/s or m/s, for gravity and friction alone: masses
        and inertias that only accelerations tell are none of the parameters then.
    seed
        Of the random motions.

    Returns
    -------
    Excitation

    Raises
    ------
    FreebodyError
        A model that cannot be identified, limits that no posture keeps.
    """
    allowed = planning_limits("excitation", model, velocity, acceleration, None, torque)
    walls = walls_of(model, box, frames)
    limits = MotionLimits(model, slowed(allowed) if quasi_static else allowed, walls)
    motions = _motions(duration, harmonics)
    rate = above_zero("excitation", "rate", rate, "Hz")
    size, told_of_noise = noise_of_torques(model, noise, allowed.allowed.effort)
    information = MotionInformation.of(model, friction, size, quasi_static)
    x = MotionSearch(motions, information, limits, rate).found(np.random.default_rng(seed))
    notices = (*told_of_noise, *limits.words())
    return _with_accuracy(motions, x, information, limits, rate, notices)


def _motions(duration: float, harmonics: int | None) -> FourierMotions:
    """The family of motions that is asked for."""
    duration = above_zero("excitation", "duration", duration, "seconds")
    if duration <= 3.0 * SETTLES:
        given, least = compared(duration, 3.0 * SETTLES)
        raise FreebodyError(
            f"excitation: duration is {given} s, expected more than {least} s: {SETTLES:g} s "
            f"at both ends tells nothing."
        )
    chosen = harmonics
    if chosen is None:
        chosen = int(np.clip(round(_CYCLES * duration), *_HARMONICS))
    if not is_count(chosen, 2):
        raise FreebodyError(f"excitation: harmonics is {harmonics!r}, expected 2 or more.")
    return FourierMotions(duration, chosen)


def _with_accuracy(
    motions: FourierMotions,
    x: Array,
    information: MotionInformation,
    limits: MotionLimits,
    rate: float,
    notices: tuple[str, ...],
) -> Excitation:
    """The motion of coefficients (joints, size), and how well it tells each parameter."""
    count = round(motions.duration * rate)
    t = np.arange(count + 1, dtype=np.float64) * (motions.duration / count)
    states = motions.states(t, x.T)
    settled = (t > SETTLES) & (t < motions.duration - SETTLES)
    used = settled[:, None] & (np.abs(states.qd) > REST)
    try:
        deviations = information.deviations(states, used)
    except np.linalg.LinAlgError:
        raise FreebodyError(
            "excitation: the motion found leaves some parameter untold; give a longer duration "
            "or wider limits."
        ) from None
    ends = states.qd.copy()
    ends[[0, -1]] = 0.0
    motion = Motion(
        t, states.q, ends, states.qdd,
        f"excitation with {counted(motions.harmonics, 'harmonic')}", layout(limits.model),
        notices=limits.planning.allowed.notices,
        doubts=doubts_used(limits.model, *limits.planning.rests),
    )  # fmt: skip
    return Excitation(
        motion, information.names, deviations, information.base, information.noise, rate, notices
    )
