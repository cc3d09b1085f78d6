"""Motions from arrays, and from tables in memory: dicts, pandas DataFrames, xarray Datasets."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, Protocol

import numpy as np

from freebody.arrays import Array, as_floats
from freebody.errors import FreebodyError, KindError, ShapeError
from freebody.labels import refuse_other_times, row_times
from freebody.model.model import Model
from freebody.model.model_argument import require_model
from freebody.motion.files.csv_columns import TIMES, factor, kinds, named_unit
from freebody.motion.files.motion_columns import (
    check_names,
    doubted,
    given_motion,
    motion_from_columns,
    with_untold_twists,
    without_jumps,
)
from freebody.motion.motion import Motion, vector_of_times
from freebody.trees.public_calls import finite_vector


class MotionTable(Protocol):
    """Columns by name: a dict, a DataFrame or a Dataset."""

    def items(self) -> Any:
        """Pairs of name and column of the table."""


def motion_of_samples(model: Model, t: Any, q: Any, qd: Any, qdd: Any) -> Motion:
    """The motion of arrays or of one table, see `Motion.of`."""
    require_model("Motion.of", model)
    model.require_values("a motion")
    if q is None:
        if qd is not None or qdd is not None:
            raise FreebodyError(
                "Motion.of: rates are given without positions; give t, q and then qd and qdd."
            )
        return motion_from_table(model, t)
    refuse_other_times("Motion.of", {"q": q, "qd": qd, "qdd": qdd})
    times = vector_of_times(t)
    given = {"q": q} | {k: x for k, x in (("qd", qd), ("qdd", qdd)) if x is not None}
    arrays = {name: _rows(model, name, value, len(times)) for name, value in given.items()}
    if not model.loops:
        none = np.full((len(times), model.nv), np.nan)
        rates, accelerations = (arrays.get(name, none) for name in ("qd", "qdd"))
        return given_motion(model, times, arrays["q"], rates, accelerations, "given as arrays")
    if len(arrays) > 1:
        raise FreebodyError(
            "Motion.of: the rates of a closed chain are found from its positions; leave out "
            "qd and qdd."
        )
    columns = dict(zip(model.position_names, arrays["q"].T, strict=True))
    return motion_from_columns(model, times, columns, "given as arrays", _problem)


def motion_from_table(model: Model, table: Any) -> Motion:
    """The motion in a dict, a DataFrame or a Dataset with `time` or `t` and a column for each
    position name; or in the Dataset of a simulation or study."""
    if "position" in getattr(table, "coords", ()) and "q" in table:
        return _recorded(model, table)
    columns: dict[str, Array] = {}
    stated = set()
    quantities = kinds(model)
    for label, values, unit in _columns(table):
        name, own = named_unit(label, quantities)
        if name in columns:
            raise _problem(f"column {name!r} occurs twice in it; remove one.")
        column = as_floats("motion", repr(label), values)
        if column.ndim != 1:
            raise _problem(f"{label!r} has shape {column.shape}, expected one number a sample.")
        bad = np.flatnonzero(~np.isfinite(column))
        if len(bad):
            raise _problem(f"{label!r} holds a value that is not finite.", int(bad[0]))
        unit = own if unit is None else unit
        if unit is not None:
            size = factor(name, unit.strip(), quantities)
            if isinstance(size, str):
                raise _problem(f"{label!r}: {size}")
            column = column * size
            stated.add(name)
        columns[name] = column
    if "t" not in columns:
        raise _problem("it needs a one-dimensional 'time' or 't' (s).")
    check_names(model, list(columns), _problem)
    times = columns.pop("t")
    for name, column in columns.items():
        if len(column) != len(times):
            raise _problem(f"{name!r} has {len(column)} samples, 't' has {len(times)}.")
    columns, untwisted = with_untold_twists(model, columns, len(times))
    times, columns, before = without_jumps(model, times, columns)
    t = vector_of_times(times)
    motion = motion_from_columns(model, t, columns, f"a table{untwisted}", _problem, before)
    where = "attrs['units'] of '{}' as '{}'" if hasattr(table, "data_vars") else "'{} ({})'"
    return doubted(model, motion, columns, frozenset(stated), where)


def _recorded(model: Model, result: Any) -> Motion:
    """The motion in a Dataset of `simulate` or of a study, of which q, qd and qdd are read."""
    several = [str(d) for d in result["q"].dims if d not in ("time", "position")]
    if several:
        one = ", ".join(f"{d}=0" for d in several)
        raise _problem(f"it has many motions; choose one, such as table.isel({one}).")
    given = ["q"] if model.loops else [name for name in ("q", "qd", "qdd") if name in result]
    arrays = {"q": None, "qd": None, "qdd": None} | {name: result[name] for name in given}
    return motion_of_samples(model, result["time"].values, **arrays)


def _columns(table: Any) -> Iterator[tuple[str, Any, str | None]]:
    """Label, values and unit of each column of a table."""
    if hasattr(table, "data_vars"):
        times = [table[name] for name in TIMES if name in table.variables]
        for name in table.variables:
            if times and (name in TIMES or table[name].dims == times[0].dims):
                unit = table[name].attrs.get("units")
                yield str(name), table[name].values, unit if isinstance(unit, str) else None
    elif hasattr(table, "columns") and hasattr(table, "to_numpy"):
        index = row_times(table)
        if index is not None and not {str(x).lower() for x in table.columns} & set(TIMES):
            yield "t", index, None
        for k, name in enumerate(table.columns):
            yield str(name), table.iloc[:, k].to_numpy(), None
    elif hasattr(table, "items"):
        for name, values in table.items():
            yield str(name), values, None
    else:
        raise KindError(
            "Motion.of",
            "t",
            table,
            "times (T,) with positions q (T, nq) after them, or a table by names",
        )


def _rows(model: Model, name: str, value: Any, count: int) -> Array:
    array = finite_vector("Motion.of", model, name, value)
    if array.ndim != 2 or len(array) != count:
        size = array.shape[-1]
        raise ShapeError("Motion.of", name, array.shape, f"({count}, {size})", "one row a time")
    return array


def _problem(text: str, row: int | None = None) -> FreebodyError:
    return FreebodyError(f"motion: the table: {text}" + ("" if row is None else f" (sample {row})"))
