"""`excitation`: a motion that tells the most of a robot's parameters within its limits, and how
well it tells each.

With noise of known size in the torques, the least variance with which parameters can be found from
a motion is the inverse of its information M = Σ Yᵀ W Y (Y the columns of the regression, W the
inverse variances). The determinant of M is made large (D-optimality: no scaling of parameters
matters), then the largest variance of a base parameter small. M is a sum over times, so the slope
of either criterion is one of a sum of functions of one state each, φ = tr(W Y S Yᵀ), with the same
matrix S for all: M⁻¹ for log det M, M⁻¹ D M⁻¹ for variances weighted by D. These slopes are taken
by central differences, all states side by side in one call of a kernel.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.optimize import minimize

from freebody.any_chain.dynamics import inverse_dynamics
from freebody.arrays import Array, above_zero, as_floats, is_count
from freebody.by_value import ByValue
from freebody.errors import FreebodyError, ShapeError, listed
from freebody.identification.columns import Columns, friction_laws, regression_columns
from freebody.identification.filters import SETTLES
from freebody.identification.fourier import FourierMotions, FourierStates
from freebody.identification.log_equations import REST
from freebody.kernels.own_functions import compile as compiled
from freebody.model.doubt_rules.aspects import MASSES
from freebody.model.doubts import doubts_on, doubts_used
from freebody.model.model import Model
from freebody.motion.motion import Motion
from freebody.motion.planning.planning_limits import Limit, PlanningLimits, planning_limits
from freebody.outputs.display import Tabled, TextTable, counted
from freebody.outputs.number_text import compared, shortest
from freebody.trees.base_parameters import independent
from freebody.trees.position_rates import layout
from freebody.trees.public_calls import JointVector, finite_vector
from freebody.ways_out.kernel import formula

_SMOOTH = 0.05
"""Rate within which dry friction changes its sense in the columns: slopes have to see it."""
_SHARE = 0.01
"""Noise in a torque, as a part of the effort limit, where none is given."""
_CYCLES = 0.5  # Hz, of the highest harmonic
_HARMONICS = 4, 15
"""Fewest and most harmonics that are chosen."""
_PER_CYCLE = 16
"""Samples in a period of the highest harmonic at which a motion is judged while it is sought."""
_WITHIN = 0.99
"""Part of a limit from which a sample costs: between samples a motion goes a little beyond."""
_STEP = 1e-6  # rad, m, s: of central differences
_POSTURES, _STARTS = 2000, 20
"""Postures drawn as middles, and random motions of which the best is where the search begins."""
_SLOW = 0.2  # rad/s, m/s and by s: limits of quasi-static motions
_RANK = 1e-8
_POWER = 6
"""Power of the mean of variances that stands for the largest."""
_DETERMINANT = 0.25
"""Weight of the determinant beside the largest variance, so that friction stays told."""


class _Stage(NamedTuple):
    """A part of the search: the weight of limits, that of the largest variance (else the
    determinant), and the most steps."""

    weight: float
    worst: bool
    steps: int


_STAGES = (
    _Stage(30.0, False, 60),
    _Stage(300.0, False, 30),
    _Stage(300.0, True, 60),
    _Stage(3000.0, True, 30),
)


@dataclass(frozen=True, eq=False, repr=False)
class Excitation(Tabled, ByValue):
    """A motion for identification, and how well its log will tell each parameter.

    deviations: (parameters,) standard deviations expected of base parameters and then of friction,
    by `names`; kg, kg m, kg m², N m and so on. noise: (nv,) standard deviation of the torques'
    noise, sample by sample at `rate` Hz, N m or N, in proportion to which they are.
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
    friction: Sequence[str] = ("viscous", "coulomb", "offset"),
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
    limits = planning_limits("excitation", model, velocity, acceleration, None, torque)
    task = _MotionSearch.of(
        model, duration, harmonics, rate, quasi_static, noise, friction,
        _slowed(limits) if quasi_static else limits, _walls(model, box, frames),
    )  # fmt: skip
    x = task.start(np.random.default_rng(seed))
    for stage in _STAGES:
        found = minimize(
            task.cost, x.ravel(), (stage,), jac=True, method="L-BFGS-B",
            options={"maxiter": stage.steps},
        )  # fmt: skip
        x = found.x.reshape(x.shape)
    return task.result(task.within(x))


def _slowed(limits: PlanningLimits) -> PlanningLimits:
    """The limits of a quasi-static motion."""
    slow = (np.minimum(x, _SLOW) for x in (limits.velocity, limits.acceleration))
    return replace(limits, **dict(zip(("velocity", "acceleration"), slow, strict=True)))


@dataclass(frozen=True)
class _Walls:
    """A box for origins of frames: the kernel of their places (..., points, dim), and corners."""

    points: Callable[..., Array]
    low: Array
    high: Array

    def used(self, q: Array) -> Array:
        """How much of the box is used (..., 2 points dim): above 1 outside, by m."""
        places = self.points(q)
        over = np.concatenate([places - self.high, self.low - places], axis=-2)
        return 1.0 + over.reshape(*q.shape[:-1], -1)


def _walls(model: Model, box: ArrayLike | None, frames: Sequence[str] | None) -> _Walls | None:
    if box is None:
        if frames is not None:
            raise FreebodyError("excitation: frames are given without a box; give box=(low, high).")
        return None
    corners = as_floats("excitation", "box", box)
    if corners.shape != (2, model.dim):
        raise ShapeError(
            "excitation", "box", corners.shape, f"(2, {model.dim})", "its lowest and highest corner"
        )
    if not (corners[0] < corners[1]).all():
        raise FreebodyError(
            "excitation: the box has no room: its first corner must be the lowest, its second the "
            "highest."
        )
    names = list(model.frame_names) if frames is None else list(frames)
    poses = [
        formula(model, "forward_kinematics", frame=x)
        for x in (*names, *([None] * (frames is None)))
    ]
    dim = model.dim

    def places(q):
        return {"places": tuple(tuple(T(q)[i][dim] for i in range(dim)) for T in poses)}

    kernel = compiled(places, {"q": (model.nq,)}, {"places": (len(poses), dim)})
    if frames is None:
        q = np.random.default_rng(0).uniform(-1.0, 1.0, (4, model.nq))
        moves = np.ptp(kernel(q), axis=0).max(axis=-1) > _RANK
        return _Walls(lambda q: kernel(q)[..., moves, :], *corners)
    return _Walls(kernel, *corners)


@dataclass(frozen=True)
class _MotionSearch:
    """A search: the cost of Fourier motions by their coefficients (joints, size), flattened."""

    model: Model
    columns: Columns
    told: NDArray[np.intp]
    """Places of the unknowns that count, base parameters first."""
    base: int
    """The number of base parameters that count."""
    motions: FourierMotions
    times: Array
    functions: FourierStates
    noise: Array
    rate: float
    limits: PlanningLimits
    walls: _Walls | None
    slow: bool
    notices: tuple[str, ...]

    @staticmethod
    def of(
        model: Model,
        duration: float,
        harmonics: int | None,
        rate: float,
        slow: bool,
        noise: JointVector | float | None,
        friction: Sequence[str],
        limits: PlanningLimits,
        walls: _Walls | None,
    ) -> _MotionSearch:
        """The task of what `excitation` was asked for."""
        duration = above_zero("excitation", "duration", duration, "seconds")
        rate = above_zero("excitation", "rate", rate, "Hz")
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
        columns = replace(regression_columns(model, friction_laws(friction)), smooth=_SMOOTH)
        if columns.by_load:
            raise FreebodyError(
                "excitation: load-dependent friction has no columns of its own; leave 'load' out "
                "of friction, the motion is as good for it."
            )
        motions = FourierMotions(duration, chosen)
        times = np.arange(_PER_CYCLE * chosen, dtype=np.float64) * (
            duration / (_PER_CYCLE * chosen)
        )
        told = np.arange(len(columns.names))
        if slow:
            told = np.concatenate([_by_gravity(columns), told[columns.base :]])
        size, told_of_noise = _noise(model, noise, limits)
        return _MotionSearch(
            model, columns, told, int((told < columns.base).sum()), motions, times,
            motions.functions(times), size, rate, limits, walls, slow,
            (*told_of_noise, *_words(model, limits, walls)),
        )  # fmt: skip

    # ------------------------------------------------------------ what a motion tells
    def entries(self, states: FourierStates) -> list[tuple[Array, NDArray[np.intp]]]:
        """For each joint the columns (..., c) at states, over the torque's noise, and the places
        among what counts that they belong to."""
        values = self.columns.results(*states)
        at_rest = values
        if self.slow:
            still = np.zeros_like(states.q)
            at_rest = self.columns.results(states.q, still, still)
        place = np.full(len(self.columns.names), -1)
        place[self.told] = np.arange(len(self.told))
        found = []
        for row, sigma in zip(self.columns.rows, self.noise, strict=True):
            of_base = row.unknowns < self.columns.base
            x = np.where(of_base, at_rest[..., row.results], values[..., row.results])
            kept = place[row.unknowns] >= 0
            found.append((x[..., kept] / sigma, place[row.unknowns[kept]]))
        return found

    def information(self, states: FourierStates, used: NDArray[np.bool_] | None = None) -> Array:
        """M of the samples (n, nv) of states, those of each joint that are used (n, nv)."""
        M = np.zeros((len(self.told), len(self.told)))
        for j, (x, places) in enumerate(self.entries(states)):
            x = x if used is None else x[used[:, j]]
            M[np.ix_(places, places)] += x.T @ x
        return M

    def used(self, states: FourierStates) -> Array:
        """How much of each limit is used (..., limits), above 1 too much: of positions, rates,
        accelerations, torques, and the box."""
        q, qd, qdd = states
        allowed = self.limits.allowed
        room = 0.5 * allowed.width
        parts = [1.0 + (q - allowed.upper) / room, 1.0 + (allowed.lower - q) / room]
        for x, most in ((qd, self.limits.velocity), (qdd, self.limits.acceleration)):
            parts.append(np.abs(x) / most)
        if np.isfinite(self.limits.torque).any():
            parts.append(np.abs(inverse_dynamics(self.model, q, qd, qdd)) / self.limits.torque)
        if self.walls is not None:
            parts.append(self.walls.used(q))
        return np.concatenate(parts, axis=-1)

    def excess(self, states: FourierStates) -> Array:
        """The squares by which limits are exceeded (...), added up."""
        return (np.maximum(self.used(states) - _WITHIN, 0.0) ** 2).sum(axis=-1)

    def cost(self, flat: Array, stage: _Stage) -> tuple[float, Array]:
        """The criterion with the cost of limits, and its slope by the coefficients."""
        x = flat.reshape(self.model.nv, -1).T
        states = FourierStates(*(f @ x for f in self.functions))
        scale = self.rate * self.motions.duration / len(self.times)
        value, S = _criterion(scale * self.information(states), self.base, stage.worst)
        weight = stage.weight / len(self.times)

        def of_each(moved: FourierStates) -> Array:
            told = sum(
                np.einsum("...i,...i", y @ S[np.ix_(at, at)], y) for y, at in self.entries(moved)
            )
            return weight * self.excess(moved) - scale * np.asarray(told)

        slopes = _slopes(of_each, states)
        by_x = sum(g.T @ f for g, f in zip(slopes, self.functions, strict=True))
        return value + weight * float(self.excess(states).sum()), np.asarray(by_x).ravel()

    # ------------------------------------------------------------ motions
    def start(self, rng: np.random.Generator) -> Array:
        """The best of some random motions within the limits, (joints, size); refuses limits that no
        posture keeps."""
        n, allowed = self.model.nv, self.limits.allowed
        low, high = (
            np.where(np.isfinite(x), x, y)
            for x, y in ((allowed.lower, -np.pi), (allowed.upper, np.pi))
        )
        low, high = np.maximum(low, -np.pi), np.minimum(high, np.pi)
        middles = low + (high - low) * rng.random((_POSTURES, n))
        still = np.zeros_like(middles)
        used = self.used(FourierStates(middles, still, still)).max(axis=1)
        if used.min() > _WITHIN:
            raise FreebodyError(
                f"excitation: of {_POSTURES} postures of {self.model.name!r} none is within the "
                f"limits at rest{' and inside the box' if self.walls else ''}; widen the box, or "
                f"look at the effort limits."
            )
        best: tuple[float, Array] | None = None
        for middle in middles[np.argsort(used)[: _STARTS * 5 : 5]]:
            x = np.vstack([middle, rng.normal(size=(self.motions.size - 1, n))])
            x = self.within(x.T, _WITHIN)
            cost = self.cost(x.ravel(), _STAGES[0])[0]
            if best is None or cost < best[0]:
                best = cost, x
        assert best is not None
        return best[1]

    def within(self, x: Array, most: float = 1.0 - 1e-3) -> Array:
        """The coefficients (joints, size) with so much smaller amplitudes that all limits are kept
        at a hundred times for each of the search."""
        count = 100 * self.motions.harmonics
        t = np.arange(count + 1, dtype=np.float64) * (self.motions.duration / count)
        x = x.copy()
        for _ in range(200):
            states = self.motions.states(t, x.T)
            over = float(self.used(states).max())
            if over <= most:
                return x
            rates = max(
                float(np.max(np.abs(states.qd) / self.limits.velocity)),
                float(np.max(np.abs(states.qdd) / self.limits.acceleration)),
            )
            x[:, 1:] *= max(0.5, most / rates) if rates > most else 0.98
        raise FreebodyError("excitation: no motion keeps the limits; widen them.")

    def result(self, x: Array) -> Excitation:
        """The motion of coefficients, and how well it tells each parameter."""
        count = round(self.motions.duration * self.rate)
        t = np.arange(count + 1, dtype=np.float64) * (self.motions.duration / count)
        states = self.motions.states(t, x.T)
        settled = (t > SETTLES) & (t < self.motions.duration - SETTLES)
        used = settled[:, None] & (np.abs(states.qd) > REST)
        M = self.information(states, used)
        try:
            deviations = np.sqrt(np.diag(_inverse(M)))
        except np.linalg.LinAlgError:
            raise FreebodyError(
                "excitation: the motion found leaves some parameter untold; give a longer duration "
                "or wider limits."
            ) from None
        ends = states.qd.copy()
        ends[[0, -1]] = 0.0
        motion = Motion(
            t, states.q, ends, states.qdd,
            f"excitation with {counted(self.motions.harmonics, 'harmonic')}", layout(self.model),
            notices=self.limits.allowed.notices,
            doubts=doubts_used(self.model, *self.limits.rests),
        )  # fmt: skip
        names = tuple(self.columns.names[k] for k in self.told)
        return Excitation(motion, names, deviations, self.base, self.noise, self.rate, self.notices)


def _criterion(M: Array, base: int, worst: bool) -> tuple[float, Array]:
    """The value that is made small, and the matrix S by which its slope is -Σ tr(dM S)."""
    size = len(M)
    d = np.sqrt(np.diag(M))
    logs = float(np.linalg.slogdet(M / np.outer(d, d))[1] + 2.0 * np.log(d).sum()) / size
    inverse = _inverse(M)
    if not worst:
        return -logs, inverse / size
    variances = np.diag(inverse)[:base]
    largest = float(variances.max())
    powers = (variances / largest) ** _POWER
    D = np.zeros(size)
    D[:base] = powers / (variances * powers.sum())
    value = float(np.log(largest) + np.log(powers.sum()) / _POWER)
    return value - _DETERMINANT * logs, (inverse * D) @ inverse + _DETERMINANT / size * inverse


def _inverse(M: Array) -> Array:
    """M⁻¹ of an information matrix, scaled to a unit diagonal meanwhile. Raises LinAlgError where
    it is not positive definite."""
    d = np.sqrt(np.diag(M))
    factor = np.linalg.inv(np.linalg.cholesky(M / np.outer(d, d)))
    return factor.T @ factor / np.outer(d, d)


def _slopes(of_each: Callable[[FourierStates], Array], states: FourierStates) -> list[Array]:
    """Slopes (n, nv) by positions, rates and accelerations of a function of states, by central
    differences, all at once."""
    nv = states.q.shape[1]
    moves = np.concatenate([np.eye(3 * nv), -np.eye(3 * nv)]).reshape(6 * nv, 1, 3, nv) * _STEP
    moved = FourierStates(*(x + moves[:, :, k] for k, x in enumerate(states)))
    forward, back = of_each(moved).reshape(2, 3, nv, -1)
    return [x.T for x in (forward - back) / (2.0 * _STEP)]


def _by_gravity(columns: Columns) -> NDArray[np.intp]:
    """Places of the base parameters that torques at rest tell, those that are no combination of
    others."""
    n = len(columns.rows)
    q = np.random.default_rng(0).uniform(-np.pi, np.pi, (4 * columns.base, n))
    values = columns.results(q, np.zeros_like(q), np.zeros_like(q))
    Y = np.zeros((n, len(q), columns.base))
    for y, row in zip(Y, columns.rows, strict=True):
        of_base = row.unknowns < columns.base
        y[:, row.unknowns[of_base]] = values[:, row.results][:, of_base]
    chosen, _ = independent(Y.reshape(-1, columns.base))
    if not chosen:
        raise FreebodyError(
            "excitation: gravity loads none of the joints, so that a quasi-static motion tells no "
            "mass; leave quasi_static out."
        )
    return np.array(chosen, dtype=np.intp)


def _noise(
    model: Model, noise: JointVector | float | None, limits: PlanningLimits
) -> tuple[Array, tuple[str, ...]]:
    """The noise (nv,) in each joint's torque, and words on where it is from."""
    if noise is None:
        effort = limits.allowed.effort
        size = np.where(np.isfinite(effort), _SHARE * effort, 1.0)
        return size, (
            f"Standard deviations are for torques whose noise is {_SHARE:.0%} of the effort limit, "
            f"or 1 N m where there is none; give noise, in proportion to which they are.",
        )
    alike = not isinstance(noise, Mapping) and np.ndim(noise) == 0
    given = np.full(model.nv, noise) if alike else noise
    size = finite_vector("excitation", model, "noise", given)
    if size.shape != (model.nv,) or not (size > 0.0).all():
        raise FreebodyError(f"excitation: noise is {noise}, expected a number above 0, or (nv,).")
    return size, ()


def _words(model: Model, limits: PlanningLimits, walls: _Walls | None) -> tuple[str, ...]:
    """Sentences on limits that are not there."""
    found = []
    free = [
        x for x, a in zip(model.velocity_names, limits.acceleration, strict=True) if a == np.inf
    ]
    if free:
        found.append(f"The acceleration of {listed(free, 6)} has no limit but its frequencies.")
    if walls is None:
        found.append("Collisions with the robot itself and its surroundings are not looked at.")
    if np.isfinite(limits.torque).any() and doubts_on(model, MASSES):
        found.append("The model's masses are doubtful, and torques are limited by them alone.")
    return tuple(found)
