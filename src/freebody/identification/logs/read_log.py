"""`read_log`: a robot's log from its file, with a sentence on everything that was mended."""

from __future__ import annotations

import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from freebody.arrays import Array, above_zero
from freebody.errors import listed
from freebody.formats.read_file import NOT_FINITE
from freebody.identification.filters import SETTLES
from freebody.identification.logs.clock import FEWEST, grid_of, in_order
from freebody.identification.logs.columns import LogPlan, plan_of
from freebody.identification.logs.doubts import (
    beyond_limits,
    rates_checked,
    resting_ends,
    spikes,
    unmeasured,
    unwrapped,
)
from freebody.identification.logs.layout import layout_of
from freebody.identification.logs.log import Log
from freebody.identification.logs.quantities import QUANTITIES
from freebody.identification.logs.table import LogTable, table_of_log
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.model.parameters import LARGEST
from freebody.motion.ranges import Flags, angular
from freebody.outputs.display import counted

_BROKEN = 0.05
"""Part of the rows that may be broken before a log is refused."""
_SHORT = 3.0 * SETTLES  # s


def read_log(
    path: Any,
    model: Model | None = None,
    *,
    layout: str | os.PathLike[str] | None = None,
    rate: float | None = None,
) -> Log:
    """A robot's log: positions, rates, and torques or currents of its joints on a uniform grid of
    times.

    What is broken in a few rows is left out and told in the log's notices, such as cut rows, words
    and NaN between numbers, spikes, clocks that were set, gaps. What is wrong with the whole is
    refused.

    Parameters
    ----------
    path
        A CSV file (commas, semicolons, tabs or blanks; decimal points, or commas where these do not
        separate), a Parquet file, or a dict or DataFrame of columns. A header names the columns, as
        `t, joint1, joint1.v, joint1.torque (N m)`, as ROS does for JointState, as `actual_q_0`.
    model
        Whose joints they are: the log is in the order of its coordinates, and is compared with its
        limits. Without it, the joints are those of the header.
    layout
        A TOML file that says in its table `[log]` which columns hold what, in which units, with
        which signs, and what turns currents into torques; by default the one beside the log under
        the same name, else `log.toml` in its folder.
    rate
        Samples a second (Hz) of the grid, by default those of the file.

    Raises
    ------
    FileError
        What cannot be read or understood, with the line and the remedy.
    """
    if model is not None:
        require_model("read_log", model)
    if rate is not None:
        rate = above_zero("read_log", "rate", rate, "Hz")
    table = table_of_log(path)
    plan = plan_of(table, layout_of(layout, path), model)
    samples = _samples(table, plan)
    name = Path(path).name if isinstance(path, str | os.PathLike) else "a table"
    return _log(samples, plan, model, rate, name)


@dataclass(frozen=True)
class _LogSamples:
    """Rows of a log that can be used, in SI units."""

    table: LogTable
    lines: Any
    """Lines (n,) on which they stand."""
    times: Array
    values: dict[str, Array]
    """Quantities (n, joints) by their names."""
    notices: tuple[str, ...]

    def at(self, row: int) -> str:
        return f"{self.table.unit} {self.lines[row]}"

    def refuse(self, problem: str, row: int | None) -> Exception:
        return self.table.refusal(problem, None if row is None else int(self.lines[row]))

    def of(self, rows: Any, notices: Iterable[str] = (), times: Array | None = None) -> _LogSamples:
        """Some of the rows, with further notices."""
        values = {key: x[rows] for key, x in self.values.items()}
        t = self.times[rows] if times is None else times
        return _LogSamples(self.table, self.lines[rows], t, values, (*self.notices, *notices))


def _samples(table: LogTable, plan: LogPlan) -> _LogSamples:
    """The numbers of a table without broken rows."""
    columns = [*plan.time, *(k for found in plan.columns.values() for k in found)]
    owner = [*("time" for _ in plan.time), *(key for key, x in plan.columns.items() for _ in x)]
    found = table.rows(columns)
    if not len(found.values):
        line, why = (*found.broken, (None, "there are no rows of numbers"))[0]
        raise table.refusal(f"{why}; no row can be used.", line)
    bad = ~(np.abs(found.values) <= LARGEST)
    empty, notices = _empty(table, columns, owner, bad)
    for k, key in enumerate(owner):
        if key == "temperature" and key not in empty:  # drives tell it now and then
            good = np.flatnonzero(~bad[:, k])
            found.values[:, k] = np.interp(np.arange(len(bad)), good, found.values[good, k])
        if key == "temperature" or key in empty:
            bad[:, k] = False
    broken = dict(found.broken)
    rows = bad.any(axis=1)
    for row in np.flatnonzero(rows).tolist():
        k = int(np.argmax(bad[row]))
        fault = _fault(found.values[row, k])
        broken[int(found.lines[row])] = f"{_name(table, columns[k])}: {fault}"
    notices += _left_out(table, broken, len(bad) + len(found.broken))
    used, lines = found.values, found.lines
    if rows.any():
        used, lines = used[~rows], lines[~rows]
    if len(used) < FEWEST:
        raise table.refusal(f"{counted(len(used), 'sample')}; a log needs at least {FEWEST}.")
    values = _values(used, owner, empty, plan)
    return _LogSamples(
        table, lines, _times(used[:, : len(plan.time)], plan), values, tuple(notices)
    )


def _values(used: Array, owner: list[str], empty: set[str], plan: LogPlan) -> dict[str, Array]:
    """The quantities (n, joints) in columns, in SI units and the model's directions."""
    values = {
        key: used[:, [k for k, name in enumerate(owner) if name == key]] * factors
        for key, factors in plan.factors.items()
        if key not in empty
    }
    values["position"] += plan.offsets
    if plan.gains is not None:
        values["torque"] = values["current"] * plan.gains
    return values


def _times(columns: Array, plan: LogPlan) -> Array:
    """The times (n,) of rows: of one column, of seconds and nanoseconds, or by the rate."""
    if columns.shape[1] == 2:
        return (columns[:, 0] - columns[0, 0]) + 1e-9 * columns[:, 1]
    if columns.shape[1] == 1:
        return columns[:, 0]
    assert plan.rate is not None
    return np.arange(len(columns)) / plan.rate


def _fault(value: float) -> str:
    return f"the value is {NOT_FINITE}" if not np.isfinite(value) else f"{value:g} is no quantity"


def _name(table: LogTable, column: int) -> str:
    return f"column {column + 1 if table.names is None else repr(table.names[column])}"


def _empty(
    table: LogTable, columns: list[int], owner: list[str], bad: Flags
) -> tuple[set[str], list[str]]:
    """Quantities that the log can do without and that have columns with hardly a number, and a
    sentence on each; refuses others of that kind."""
    empty, notices = set[str](), list[str]()
    spare = {"velocity", "temperature", *(["current"] if "torque" in owner else [])}
    for k in np.flatnonzero(bad.mean(axis=0) > 0.5).tolist():
        key, name = owner[k], _name(table, columns[k])
        if key not in spare:
            raise table.refusal(
                f"{name} has no number in {int(bad[:, k].sum())} of {len(bad)} rows, and holds a "
                f"{key} that is needed."
            )
        if key not in empty:
            notices.append(f"{name} has hardly a number: no {key} was read.")
        empty.add(key)
    return empty, notices


def _left_out(table: LogTable, broken: dict[int, str], count: int) -> list[str]:
    """A sentence on the rows that are left out; refuses a table in which they are many."""
    if not broken:
        return []
    line = min(broken)
    if len(broken) > max(1.0, _BROKEN * count):
        raise table.refusal(
            f"{broken[line]}; {len(broken)} of {count} rows are broken, more than one in "
            f"{round(1 / _BROKEN)}: mend the file.",
            line,
        )
    others = sorted(set(broken) - {line})
    also = f", {table.unit}s {listed(map(str, others), 6)} likewise" if others else ""
    return [f"{table.unit.capitalize()} {line} is left out: {broken[line]}{also}."]


def _log(
    samples: _LogSamples, plan: LogPlan, model: Model | None, rate: float | None, source: str
) -> Log:
    """The log of samples: put in order, doubted, and brought to a grid."""
    unit = "s" if not plan.time else plan.time_unit
    order = in_order(samples.times, unit, samples.at, samples.refuse)
    every = np.array_equal(order.rows, np.arange(len(samples.times)))
    samples = samples.of(slice(None) if every else order.rows, order.notices, order.times)
    samples = _without_spikes(samples)
    turns = np.ones(len(plan.names), dtype=bool) if model is None else angular(model)
    q, joined = unwrapped(samples.values["position"], turns, plan.names, samples.at)
    notices = list(joined)
    samples.values["position"] = q
    if model is not None:
        notices += beyond_limits(model, samples.values, plan.stated, samples.refuse)
    notices += unmeasured(samples.values, plan.names, samples.refuse)
    if "velocity" in samples.values:
        check = rates_checked(
            samples.times, q, samples.values["velocity"], plan.names, samples.refuse
        )
        notices += check.notices
        if check.useless:
            del samples.values["velocity"]
    else:
        notices.append("There are no rates in the log: the positions are differentiated.")
    active, resting = resting_ends(samples.times, q, SETTLES)
    samples = samples.of(active, (*notices, *resting))
    return _on_grid(samples, plan, rate, source)


def _without_spikes(samples: _LogSamples) -> _LogSamples:
    if len(samples.times) < FEWEST:
        raise samples.refuse(
            f"{counted(len(samples.times), 'sample')} at different times; a log needs at least "
            f"{FEWEST}.",
            None,
        )
    off = spikes({key: x for key, x in samples.values.items() if key != "temperature"})
    if not off.any():
        return samples
    lines = [str(x) for x in samples.lines[off]]
    one = len(lines) == 1
    return samples.of(
        ~off,
        [
            f"{samples.table.unit.capitalize()}{'' if one else 's'} {listed(lines, 6)} "
            f"{'is' if one else 'are'} left out: a spike between neighbours that agree."
        ],
    )


def _on_grid(samples: _LogSamples, plan: LogPlan, rate: float | None, source: str) -> Log:
    t = samples.times - samples.times[0]
    grid = grid_of(t, rate, samples.at)
    values = {key: grid.values(x) for key, x in samples.values.items()}
    notices = [*samples.notices, *grid.notices]
    if grid.times[-1] < _SHORT:
        notices.append(
            f"The log is {grid.times[-1]:.3g} s long: little is left without {SETTLES:g} s at both "
            f"ends, which the filter needs."
        )
    rates = "velocity" in values
    qd = values["velocity"] if rates else np.gradient(values["position"], grid.times, axis=0)
    assert set(values) <= set(QUANTITIES)
    return Log(
        grid.times,
        values["position"],
        qd,
        values.get("torque"),
        values.get("current"),
        plan.names,
        grid.measured,
        temperature=values.get("temperature"),
        rates_measured=rates,
        source=f"read from {source}",
        notices=tuple(notices),
    )
