"""The equations of logs: columns and torques filtered alike, joint by joint, with their products,
which are all that least squares asks of them."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.identification.columns import Columns
from freebody.identification.decimation import Decimation, decimation
from freebody.identification.logs.log import Log, LogStates

REST = 0.02
"""Rate (rad/s, m/s) up to which a joint counts as resting, where dry friction is any torque that
holds: such rows are left out."""


class Prepared(NamedTuple):
    """A log with the states of which its columns are made, and the samples that are kept."""

    log: Log
    states: LogStates
    filter: Decimation
    places: NDArray[np.intp]


@dataclass(frozen=True)
class JointEquations:
    """The equations of one joint. x: (m, c) filtered columns, last, where there are such, those of
    load-dependent friction, and then one for the gain of the drive. unknowns: (c,) that they
    multiply. y: (m,) what they add up to. places: (m,) of the kept samples that they are of. rate:
    (m,) of the joint. load: the places of load-dependent friction. squares, moments: (c, c) and
    (c,), products of the columns with each other and with y, of which only single columns are made
    anew."""

    x: Array
    unknowns: NDArray[np.intp]
    y: Array
    places: NDArray[np.intp]
    rate: Array
    load: slice
    squares: Array
    moments: Array

    @staticmethod
    def of(
        x: Array,
        unknowns: NDArray[np.intp],
        y: Array,
        places: NDArray[np.intp],
        rate: Array,
        load: slice,
    ) -> JointEquations:
        """The equations with their products."""
        return JointEquations(x, unknowns, y, places, rate, load, x.T @ x, x.T @ y)

    def put(self, at: slice, columns: Array) -> None:
        """Puts other columns (m, k) into places of x."""
        self.x[:, at] = columns
        products = self.x.T @ columns
        self.squares[:, at], self.squares[at] = products, products.T
        self.moments[at] = columns.T @ self.y

    def weighted(self, weights: Array) -> tuple[Array, Array]:
        """The products of columns with each other and with y, rows being weighted; few of them
        have other weights than 1."""
        few = np.flatnonzero(weights != 1.0)
        x = self.x[few]
        lacking = x * (1.0 - weights[few])[:, None]
        return self.squares - x.T @ lacking, self.moments - lacking.T @ self.y[few]


@dataclass(frozen=True)
class LogEquations:
    """The equations of logs of one robot, filtered once, a record of rows for each joint."""

    columns: Columns
    prepared: tuple[Prepared, ...]
    rows: tuple[JointEquations, ...]
    currents: bool
    """Whether they add up to currents with unknown gains, so that y is in A."""

    @property
    def size(self) -> int:
        """The number of unknowns without gains."""
        return len(self.columns.names)

    @property
    def inflation(self) -> float:
        """The factor by which the variance of estimates exceeds that from as many independent
        samples, the noise being white before it was filtered."""
        return max(p.filter.inflation for p in self.prepared)

    @property
    def spacing(self) -> float:
        """Time between kept samples, s."""
        return max(p.filter.step / p.log.rate for p in self.prepared)

    def put_loads(self, values: Array) -> None:
        """Puts into the columns of load-dependent friction what joints transmit with these
        unknowns: of T = Y base - J q̈, without rotors, a part is lost, a |T| sign(q̇)."""
        (base, rotors), n = self.columns.of_bodies(values), len(self.rows)
        loads = np.empty((2 * n, sum(len(p.places) for p in self.prepared)))
        start = 0
        for p in self.prepared:
            torque = self.columns.transmitted(base, *p.states)
            s = self.columns.sign(p.states.qd) * np.sign(torque - rotors * p.states.qdd)
            both = np.concatenate([s * torque, -s * p.states.qdd], axis=1)
            own = loads[:, start : start + len(p.places)]
            for where, x in p.filter.filtered(p.places, both.__getitem__):
                own[:, where] = x.T
            start += len(p.places)
        for j, rows in enumerate(self.rows):
            count = rows.load.stop - rows.load.start
            rows.put(rows.load, loads[[j, n + j][:count]][:, rows.places].T)

    def sums(self, values: Array) -> list[Array]:
        """The sums of each joint's columns, torques or currents."""
        own = np.append(values, np.zeros(len(self.rows)))
        return [rows.x @ own[rows.unknowns] for rows in self.rows]


def equations(
    function: str,
    columns: Columns,
    logs: Sequence[Log],
    given: Sequence[Array] | None,
    cutoff: float,
) -> LogEquations:
    """The filtered equations of logs.

    given: what they add up to, torques (n, joints) of each log, or None for the logs' currents.
    Raises FreebodyError where a joint has too few samples that move.
    """
    prepared = tuple(_prepared(log, cutoff) for log in logs)
    currents = given is None
    sums = [log.current for log in logs] if given is None else given
    rate = np.concatenate([p.states.qd[p.places] for p in prepared])
    moves = np.abs(rate) > REST
    joints = range(len(columns.joints))
    parts = [_empty(function, columns, j, moves[:, j], currents) for j in joints]
    start, filled = 0, np.zeros(len(parts), dtype=np.intp)
    for p, right in zip(prepared, sums, strict=True):
        for where, found in _filtered(columns, p, np.asarray(right)):
            moving = moves[start + where.start : start + where.stop]
            for j, (row, (x, y, _)) in enumerate(zip(columns.rows, parts, strict=True)):
                used = found[moving[:, j]]
                at = slice(filled[j], filled[j] + len(used))
                x[at, : len(row.unknowns)] = used[:, row.results]
                y[at] = used[:, columns.width + j]
                filled[j] = at.stop
        start += len(p.places)
    rows = []
    for j, (row, (x, y, unknowns)) in enumerate(zip(columns.rows, parts, strict=True)):
        moving, first = np.flatnonzero(moves[:, j]), len(row.unknowns)
        load = slice(first, first + len(row.by_load))
        rows.append(JointEquations.of(x, unknowns, y, moving, rate[moving, j], load))
    return LogEquations(columns, prepared, tuple(rows), currents)


def _prepared(log: Log, cutoff: float) -> Prepared:
    low_pass = decimation(log.rate, cutoff)
    return Prepared(log, log.states(), low_pass, low_pass.kept(log.settled()))


def _empty(
    function: str, columns: Columns, j: int, moves: NDArray[np.bool_], currents: bool
) -> tuple[Array, Array, NDArray[np.intp]]:
    """Room for a joint's columns and for what they add up to, and the unknowns of the columns."""
    row, count = columns.rows[j], int(moves.sum())
    extra = row.by_load + ([len(columns.names) + j] if currents else [])
    unknowns = np.array([*row.unknowns, *extra], dtype=np.intp)
    if count < 2 * len(unknowns):
        raise FreebodyError(
            f"{function}: joint {columns.joints[j]!r} moves faster than {REST:g} rad/s (m/s) in "
            f"{count} of {len(moves)} samples, too few to tell its friction; take logs "
            f"in which every joint moves."
        )
    return np.zeros((count, len(unknowns))), np.empty(count), unknowns


def _filtered(columns: Columns, p: Prepared, given: Array) -> Iterator[tuple[slice, Array]]:
    """(which of the kept samples, filtered columns with what they add up to), part by part."""
    buffer = np.empty((0, columns.width + len(columns.joints)))

    def samples(part: slice) -> Array:
        nonlocal buffer
        size = part.stop - part.start
        if size > len(buffer):
            buffer = np.empty((size, buffer.shape[1]))
        x = buffer[:size]
        q, qd, qdd = (state[part] for state in p.states)
        columns.kernel(q, qd, qdd, columns.sign(qd), out=x[:, : columns.width])
        x[:, columns.width :] = given[part]
        return x

    return p.filter.filtered(p.places, samples)
