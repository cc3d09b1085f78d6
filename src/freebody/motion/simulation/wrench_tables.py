"""External wrenches of a simulation: constant, or tables over its times."""

from __future__ import annotations

from collections.abc import Mapping

from freebody.arrays import Array, refuse_not_finite
from freebody.errors import FreebodyError, warn
from freebody.labels import row_times
from freebody.model.model import Model
from freebody.motion.simulation.torques import refuse_other_times
from freebody.trees.public_calls import Wrenches, wrenches_by_frame


def all_wrenches(
    model: Model, t: Array, wrenches: Wrenches, tables: Wrenches
) -> dict[str, tuple[str, Array]]:
    """By frame what it is called in messages, and its wrench: (..., 1, six), or (..., T, six) at
    the times t (T,)."""
    given = wrenches_by_frame("simulate", model, wrenches)
    found = {frame: (f"wrenches[{frame!r}]", w[..., None, :]) for frame, w in given.items()}
    over = tables if isinstance(tables, Mapping) else {None: tables}
    named = wrenches_by_frame("simulate", model, tables, name="wrench_tables")
    for (frame, w), value in zip(named.items(), over.values(), strict=tables is not None):
        name = f"wrench_tables[{frame!r}]"
        if w.ndim < 2 or w.shape[-2] != len(t):
            raise FreebodyError(
                f"simulate: {name} has shape {w.shape}, expected (..., {len(t)}, {w.shape[-1]}): a "
                f"row for each of the {len(t)} times of t. A constant wrench is given as wrenches=."
            )
        if frame in found:
            raise FreebodyError(
                f"simulate: wrenches and wrench_tables both have frame {frame!r}; add the constant "
                f"wrench to each row of the table."
            )
        if w.ndim == 2:
            refuse_other_times(name, row_times(value), t)
        found[frame] = name, w
    for name, w in found.values():
        refuse_not_finite("simulate", name, w, 1)
    return found


def warn_of_tables(t: Array, wrenches: Mapping[str, tuple[str, Array]], state: Array) -> None:
    """Say where wrenches of many motions from one state may have been meant as a table."""
    for name, w in wrenches.values():
        if w.shape[:-1] == (len(t), 1) and state.ndim == 1:
            warn(
                f"simulate: {name} {(len(t), w.shape[-1])} is taken as a constant wrench for each "
                f"of {len(t)} motions; a table over the {len(t)} times t is given as "
                f"wrench_tables=."
            )
