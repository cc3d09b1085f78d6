"""The equations of logs: columns and torques filtered alike, joint by joint, with their products,
which are all that least squares asks of them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
_SAME = 1e-4
"""Part of a joint's torque up to which a change of what it transmits is no matter; friction is a
small part of that."""
_TORQUES_AT_ONCE = 256
"""Samples whose columns are in memory at once while transmitted torques are summed: 0.4 MB of a
six-joint arm's, within the cache."""


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
        """Puts what joints transmit with these unknowns into the columns of load-dependent
        friction."""
        loads = _TransmittedTorques.of(self.columns, values)
        whole = np.concatenate([loads.of_log(p) for p in self.prepared])
        for rows, at in zip(self.rows, loads.results, strict=True):
            rows.put(rows.load, whole[rows.places][:, at])

    def transmit_alike(self, values: Array, others: Array) -> bool:
        """Whether joints transmit the same with these unknowns as with others, to a part of their
        torque that no figure of a residual shows."""
        change = (values - others) * (np.arange(self.size) < self.columns.base)
        pairs = zip(self.rows, self.sums(change), strict=True)
        return all(x @ x <= _SAME**2 * (rows.y @ rows.y) for rows, x in pairs)

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
    values: Array | None = None,
) -> LogEquations:
    """The filtered equations of logs.

    given: what they add up to, torques (n, joints) of each log, or None for the logs' currents.
    values: unknowns of which transmitted torques are made for load-dependent friction, whose
    columns else are 0. Raises FreebodyError where a joint has too few samples that move.
    """
    prepared = tuple(_prepared(log, cutoff) for log in logs)
    currents = given is None
    sums = [log.current for log in logs] if given is None else given
    rate = np.concatenate([p.states.qd[p.places] for p in prepared])
    moves = np.abs(rate) > REST
    joints = range(len(columns.joints))
    parts = [_empty(function, columns, j, moves[:, j], currents) for j in joints]
    loads = (
        None if values is None or not columns.by_load else _TransmittedTorques.of(columns, values)
    )
    start, filled = 0, np.zeros(len(parts), dtype=np.intp)
    for p, right in zip(prepared, sums, strict=True):
        samples = _samples(columns, p, np.asarray(right), loads)
        for where, found in p.filter.filtered(p.places, samples):
            moving = moves[start + where.start : start + where.stop]
            for j, (row, (x, y, _)) in enumerate(zip(columns.rows, parts, strict=True)):
                used = np.flatnonzero(moving[:, j])
                rows = found if len(used) == len(found) else found[used]
                at, first = slice(filled[j], filled[j] + len(used)), len(row.unknowns)
                x[at, :first] = rows[:, row.results]
                y[at] = rows[:, columns.width + j]
                if loads is not None:
                    behind = columns.width + len(parts) + loads.results[j]
                    x[at, first : first + len(behind)] = rows[:, behind]
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


class _TransmittedTorques(NamedTuple):
    """The torques that joints transmit, for load-dependent friction: of T = Y base - J q̈,
    without rotors, a part is lost, a |T| sign(q̇).

    sums: (width, n) by which the kernel's results add up to Y base. rotors: (n,) J. results: of
    each joint's columns, places among sign(T) T sign(q̇) of all joints, and behind them -sign(T) q̈
    sign(q̇).
    """

    columns: Columns
    sums: Array
    rotors: Array
    results: list[NDArray[np.intp]]

    @staticmethod
    def of(columns: Columns, values: Array) -> _TransmittedTorques:
        """The loads with these unknowns."""
        base, rotors = columns.of_bodies(values)
        n = len(columns.joints)
        results = [np.array([j, n + j][: len(row.by_load)]) for j, row in enumerate(columns.rows)]
        return _TransmittedTorques(columns, columns.sums_to_torques(base), rotors, results)

    def put(self, found: Array, signs: Array, qdd: Array, out: Array) -> None:
        """Writes the columns (k, 2 n) of samples, from the kernel's results there."""
        n, torque = len(self.rotors), found @ self.sums
        signs = signs * np.sign(torque - self.rotors * qdd)
        np.multiply(signs, torque, out=out[:, :n])
        np.multiply(-signs, qdd, out=out[:, n:])

    def of_log(self, p: Prepared) -> Array:
        """The filtered columns (samples, 2 n) of a log."""
        loads = np.empty((len(p.states.q), 2 * len(self.rotors)))
        room = np.empty((_TORQUES_AT_ONCE, self.columns.width))
        for start in range(0, len(loads), _TORQUES_AT_ONCE):
            part = slice(start, start + _TORQUES_AT_ONCE)
            q, qd, qdd = (state[part] for state in p.states)
            signs, found = self.columns.sign(qd), room[: len(q)]
            self.columns.kernel(q, qd, qdd, signs, out=found)
            self.put(found, signs, qdd, loads[part])
        return np.concatenate([x for _, x in p.filter.filtered(p.places, loads.__getitem__)])


def _samples(
    columns: Columns, p: Prepared, given: Array, loads: _TransmittedTorques | None
) -> Callable[[slice], Array]:
    """The columns of a range of a log's samples, with what they add up to, and then the loads."""
    width, n = columns.width, len(columns.joints)
    room = np.empty((0, width + n + (0 if loads is None else 2 * n)))

    def columns_of(part: slice) -> Array:
        nonlocal room
        q, qd, qdd = (state[part] for state in p.states)
        if len(q) > len(room):
            room = np.empty((len(q), room.shape[1]))
        x, signs = room[: len(q)], columns.sign(qd)
        columns.kernel(q, qd, qdd, signs, out=x[:, :width])
        x[:, width : width + n] = given[part]
        if loads is not None:
            loads.put(x[:, :width], signs, qdd, x[:, width + n :])
        return x

    return columns_of
