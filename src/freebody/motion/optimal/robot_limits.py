"""Limits of a robot's speeds, accelerations and torques, and their values along paths, each by one
kernel of the robot's structure."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from freebody.algorithms import path_timing
from freebody.algorithms.path_timing import torques_along
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.rnea import External, rnea
from freebody.any_chain.dynamics import inverse_dynamics
from freebody.any_chain.kernel_options import chosen_option
from freebody.arrays import Array
from freebody.errors import FreebodyError, SingularError
from freebody.kernels.formulas import Option
from freebody.kernels.formulas.record import at_driven_joints, external, partition_of
from freebody.kernels.structural import Bound, Over, fetch_own
from freebody.lazy import cached_property
from freebody.loops.forces import drive_torques
from freebody.model.model import Model
from freebody.model.tree import Tree
from freebody.motion.optimal.follower_limits import FollowerLimits
from freebody.motion.optimal.geometric_path import PathSamples
from freebody.motion.optimal.speed_profile import ENDS, PathRows, both_ends, row_arguments
from freebody.motion.ranges import Flags
from freebody.outputs.display import counted
from freebody.program import Argument, Program, trace
from freebody.spatial import Vector

_NAME = "time_optimal"


class LimitsReached(NamedTuple):
    """How far a motion exceeds its limits within intervals: by row, positive above the upper limit,
    negative below the lower (N, P, m); the largest as a fraction of its limit (N, P); the share of
    a limit that one might come to (N, P); the square of the largest speed as a fraction of its
    limit (N, P)."""

    by: Array
    share: Array
    near: Array
    speed: Array


@dataclass(frozen=True, eq=False)
class RobotLimits:
    """A robot with limits of rates, accelerations and torques (nv,), infinite where there is none,
    and those of its followers, under constant wrenches on frames."""

    model: Model
    velocity: Array
    acceleration: Array
    torque: Array
    wrenches: Mapping[str, Array]

    @cached_property
    def size(self) -> Array:
        """The limits (m,) of all rows: finite limits of torque, then finite limits of acceleration,
        then those of torques that reach followers."""
        own = np.concatenate([self.torque, self.acceleration])[list(self._limited)]
        return np.concatenate([own, self.followed.size])

    @cached_property
    def followed(self) -> FollowerLimits:
        """The limits of torques that reach followers."""
        return FollowerLimits.of(self.model, self.wrenches)

    @cached_property
    def _limited(self) -> tuple[int, ...]:
        """The indices of the torques, then of the accelerations, that have a finite limit."""
        found = np.isfinite([self.torque, self.acceleration])
        return tuple(np.flatnonzero(found).tolist())

    def _row(self, torque: Array, acceleration: Array, followed: Array) -> Array:
        """The entries (..., m) that have a limit, out of torques and accelerations (..., nv) and
        what reaches followers."""
        own = np.concatenate([torque, acceleration], axis=-1)[..., list(self._limited)]
        return np.concatenate([own, followed], axis=-1)

    def friction(self, q: Array, torque: Array, followed: Array) -> Array:
        """The amounts (..., m) that joint friction (..., nv) at q (..., nq), and that of followers,
        adds to the limited torques."""
        return self._row(self._driven(q, torque), np.zeros_like(torque), followed)

    def values(self, q: Array, qd: Array, qdd: Array) -> Array:
        """The values (..., m) of all rows in a motion: torques of the drives, friction and wrenches
        included, accelerations, torques that reach followers."""
        tree = self.model.opened if self.model.loops else self.model
        own = inverse_dynamics(tree, q, qd, qdd, dict(self.wrenches) or None)
        return self._row(self._driven(q, own), qdd, self.followed.torques(q, qd, qdd))

    def _driven(self, q: Array, torque: Array) -> Array:
        """Torques of the drives (..., nv) for the torques that the tree needs, which for a closed
        chain the drives must provide through the loops."""
        return drive_torques(_NAME, self.model, q, torque) if self.model.loops else torque

    def rows(self, at: PathSamples, kept: float) -> tuple[Array, ...]:
        """The arrays a, b, lo, hi (T, P, m) of the limits lo <= a s̈ + b ṡ² <= hi at points of
        paths, without friction; kept: the fraction of the limits that may be used."""
        count = len(self._limited)
        own = self._kernel("rows")(*_flat(at.orders[:3]), kept * self.size[:count], *self._loads)
        own = tuple(x.reshape(*at.s.shape, count) for x in own)
        if self.model.loops:
            self._refuse_singular(at, np.isnan(own[0]).any(axis=-1))
        if not self.followed.names:
            return own
        both = zip(own, self.followed.rows(at, kept), strict=True)
        return tuple(np.concatenate(pair, axis=-1) for pair in both)

    def reached(
        self, rows: PathRows, x: Array, at: PathSamples, between: PathSamples
    ) -> LimitsReached:
        """How far motions with x = ṡ² (N + 1, P) exceed the limits; at, between: samples at the
        grid and halfway in its intervals."""
        along = *between.orders[:3], at.first[:-1], at.first[1:], *both_ends(rows)
        ends = (a.ravel() for a in (x[:-1], x[1:], rows.h))
        finite = np.minimum(self.velocity, path_timing.FAR)
        given = (*_flat(along), *ends, self.size, finite, *self._halfway(rows, x, between))
        by, *others = self._kernel("reached")(*given, *self._loads)
        shape = rows.h.shape
        found = LimitsReached(
            by.reshape(*shape, len(self.size)), *(x.reshape(shape) for x in others)
        )
        if self.model.loops:
            lost = np.isnan(found.share) & np.isfinite(x[:-1] + x[1:])
            self._refuse_singular(between, lost)
        return found

    def _halfway(self, rows: PathRows, x: Array, between: PathSamples) -> tuple[Array, ...]:
        """The torques (N P, n) that reach followers halfway in each interval, as an argument; none
        where there are none."""
        if not self.followed.names:
            return ()
        start, end = x[:-1, :, None], x[1:, :, None]
        square, u = 0.5 * (start + end), (end - start) / rows.h[..., None]
        qd, qdd = between.first * np.sqrt(square), between.second * square + between.first * u
        found = self.followed.torques(between.q, qd, qdd)
        return (found.reshape(-1, found.shape[-1]),)

    @cached_property
    def _option(self) -> Option:
        """The kernels' option: the frames with wrenches, and for a closed chain the partition by
        its drives."""
        frames = tuple(self.wrenches)
        if not self.model.loops:
            return Option(wrench_frames=frames)
        return chosen_option(self.model, "inverse_dynamics", wrench_frames=frames, function=_NAME)[
            1
        ]

    def refuse_shared(self) -> None:
        """Refuse a closed chain whose drives do not determine its motion, or whose motion does not
        determine their torques."""
        drives = len(self.model.driven)
        motions = self.model.nv - len(partition_of(self._option).rows)
        if drives > motions:
            raise FreebodyError(
                f"{_NAME}: {self.model.name!r} has {drives} drives for "
                f"{counted(motions, 'independent motion')}, and no one way to share the torques; "
                f"model.replace(actuated=[...]) names as many drives as motions."
            )

    def _refuse_singular(self, samples: PathSamples, lost: Flags) -> None:
        """Refuse a closed chain whose drives do not hold it at some of the samples (T, P)."""
        if lost.any():
            i, path = np.argwhere(lost)[0]
            q = ", ".join(f"{x:.4g}" for x in samples.q[i, path])
            raise SingularError(
                f"{_NAME}: at s = {samples.s[i, path]:.4g} (q = {q}) the drives of "
                f"{self.model.name!r} do not determine its motion, or nearly so; move the path "
                f"away from there."
            )

    @property
    def _loads(self) -> tuple[Array, ...]:
        return tuple(self.wrenches.values())

    def _kernel(self, name: str) -> Bound:
        """A kernel of `_KERNELS` for the robot's structure and the rows that are limited."""
        option, limited, others = self._option, self._limited, len(self.followed.names)
        place = f"path {name}", limited, others, option
        found = self.model.compiled.get(place)
        if found is None:
            key = f"path {name}", str(limited), str(others)
            made = partial(_made, name, self.model, option, limited, others)
            found = self.model.compiled[place] = fetch_own(self.model, key, option, made)
        return found


def _flat(arrays: Iterable[Array]) -> Iterator[Array]:
    """Arrays (a, b, n) reshaped to (a b, n), the form in which kernels are fastest."""
    return (x.reshape(x.shape[0] * x.shape[1], x.shape[2]) for x in arrays)


def _made(
    name: str,
    model: Model,
    option: Option,
    limited: tuple[int, ...],
    others: int,
    p: Argument,
    over: Over,
) -> Program:
    """The program of a kernel named in `_KERNELS`; others: the number of limited followers."""
    evaluate, arguments = _KERNELS[name]
    inputs, outputs = arguments(model, len(limited), others)
    size = len(model.tree.space.zero) + len(model.tree.space.zero_angular)
    loads = [Argument(f"w{k}", (size,), uniform=True) for k in range(len(option.wrench_frames))]

    def whole(*scalars: Any) -> tuple[Any, ...]:
        tree, q = lightened(over(scalars[-1])), scalars[0]
        on_bodies = external(tree, option, q, scalars[len(inputs) : -1])
        driven = partial(at_driven_joints, tree, option, q)
        return evaluate(tree, on_bodies, driven, limited, *scalars[: len(inputs)])

    return trace(f"path_{name}", whole, (*inputs, *loads, p), outputs)


def _path(model: Model) -> list[Argument]:
    return [Argument("q", (model.nq,)), *_rates(model, "first", "second")]


def _rates(model: Model, *names: str) -> list[Argument]:
    return [Argument(name, (model.nv,)) for name in names]


def _rows_arguments(model: Model, m: int, _: int) -> tuple[list[Argument], list[Argument]]:
    outputs = [Argument(name, (m,)) for name in ("a", "b", "lo", "hi")]
    return [*_path(model), Argument("kept", (m,), uniform=True)], outputs


def _rows(
    tree: Tree,
    loads: Sequence[External],
    driven: Callable[[Vector], Vector],
    limited: Sequence[int],
    q: Vector,
    first: Vector,
    second: Vector,
    kept: Vector,
) -> tuple[Any, ...]:
    """The limits of one point as vectors a, b, lo, hi of lo <= a s̈ + b ṡ² <= hi."""
    a, b, rest = map(driven, torques_along(tree, q, first, second, loads))
    every = ((*a, *first), (*b, *second), (*rest, *(0.0 for _ in first)))
    a, b, rest = (tuple(values[k] for k in limited) for values in every)
    lo, hi = ([way * x - y for x, y in zip(kept, rest, strict=True)] for way in (-1.0, 1.0))
    return a, b, lo, hi


def _reached_arguments(
    model: Model, count: int, others: int
) -> tuple[list[Argument], list[Argument]]:
    m = count + others
    given = [*_path(model), *_rates(model, "start", "end"), *row_arguments(m), *ENDS]
    sizes = Argument("size", (m,), uniform=True), Argument("velocity", (model.nv,), uniform=True)
    outputs = [Argument("excess", (m,)), *(Argument(name, ()) for name in ("share", "near", "top"))]
    followed = [Argument("followed", (others,))] if others else []
    return [*given, *sizes, *followed], outputs


def _reached(
    tree: Tree,
    loads: Sequence[External],
    driven: Callable[[Vector], Vector],
    limited: Sequence[int],
    q: Vector,
    first: Vector,
    second: Vector,
    *given: Any,
) -> tuple[Any, ...]:
    """How far a motion exceeds the limits in one interval, see `LimitsReached`."""
    (start, end, *rows), (x, y, h, size, velocity, *followed) = given[:10], given[10:]
    qd, qdd = path_timing.halfway(first, second, x, y, h)
    every = (*driven(rnea(tree, q, qd, qdd, loads).tau), *qdd)
    limits = path_timing.RowsAtEnd(*rows[:4]), path_timing.RowsAtEnd(*rows[4:])
    values = [*(every[k] for k in limited), *(x for torques in followed for x in torques)]
    found = path_timing.excess(*limits, values, size, x, y, h)
    return *found, path_timing.top_speed(start, first, end, velocity, x, y)


_KERNELS = {"rows": (_rows, _rows_arguments), "reached": (_reached, _reached_arguments)}
