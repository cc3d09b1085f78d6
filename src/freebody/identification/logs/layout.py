"""The table `[log]` of a TOML file, which tells of the columns of logs: which they are, in which
units, with which signs, and by which gains currents become torques.

It stands beside the log under the same name, or as `log.toml` in the same folder for all logs
there:

    [log]
    time = 1                # a column's number from 1, or its name
    position = "2-7"        # a range, a list of numbers, or a list of names
    velocity = "8-13"
    current = "14-19"
    gains = [10.0, 10.7, 8.46, 9.0, 9.48, 10.1]     # N m of the joint per A
"""

from __future__ import annotations

import os
import re
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from freebody.errors import FreebodyError, shown
from freebody.formats import read_file
from freebody.formats.toml_table import TomlTable, table_of
from freebody.identification.logs.quantities import QUANTITIES, TIME_UNITS
from freebody.outputs.display import counted

ColumnRef = int | str
"""A column's number from 1, or its name."""
SHARED = "log.toml"
"""The file that tells of all logs in its folder that have none of their own."""
_RANGE = re.compile(r"\s*([0-9]{1,6})\s*-\s*([0-9]{1,6})\s*", re.ASCII)
_LISTS = ("signs", "offsets", "gains", "torque_constants", "gears")


@dataclass(frozen=True)
class LogLayout:
    """Facts on a log's columns beside their names; by joint in the order of the columns."""

    file: str = ""
    time: tuple[ColumnRef, ...] = ()
    columns: dict[str, tuple[ColumnRef, ...]] = field(default_factory=dict)
    """Columns of each quantity, a joint each."""
    units: dict[str, tuple[str, ...]] = field(default_factory=dict)
    """Units of time and of quantities: one for all joints, or one each."""
    joints: tuple[str, ...] = ()
    signs: tuple[float, ...] = ()
    offsets: tuple[float, ...] = ()
    """Angles and lengths (rad, m) added to positions after the sign."""
    gains: tuple[float, ...] = ()
    """Torque of the joint over current, N m/A or N/A."""
    rate: float | None = None
    """Rows a second, where there is no time."""

    def lists(self) -> dict[str, tuple[Any, ...]]:
        """Lists with an entry for each joint, by their keys."""
        found = {"joints": self.joints, "signs": self.signs, "offsets": self.offsets}
        return {**found, "gains": self.gains}


def layout_of(source: Any, log: Any) -> LogLayout:
    """The layout in a TOML file, by default in the one beside the log; empty where there is none.

    Raises FileError with the line.
    """
    if source is None:
        if not isinstance(log, str | os.PathLike):
            return LogLayout()
        path = Path(log)
        beside = (path.with_suffix(".toml"), path.with_name(SHARED))
        found = [x for x in beside if x != path and x.is_file()]
        if not found:
            return LogLayout()
        source = found[0]
    if not isinstance(source, str | os.PathLike):
        raise FreebodyError(
            f"read_log: layout is {shown(source)}, expected the path of a TOML file with [log]."
        )
    text = read_file.decoded(str(source), read_file.read(Path(source), what="the layout of a log"))
    top = table_of(str(source), text).only("log")
    table = top.table("log")
    if table is None:
        top.refuse("there is no table [log]; write [log] above what is said of the columns.")
    return _read(table.called("[log]"))


def _read(table: TomlTable) -> LogLayout:
    table.only("time", *QUANTITIES, "units", "joints", "rate", *_LISTS)
    time = _columns(table, "time") if "time" in table else ()
    if len(time) > 2:
        table.refuse("time is one column, or two: seconds, and nanoseconds of them.", "time")
    columns = {name: _columns(table, name) for name in QUANTITIES if name in table}
    lists = {key: _numbers(table, key) for key in _LISTS if key in table}
    for k, sign in enumerate(lists.get("signs", ())):
        if abs(sign) != 1.0:
            table.refuse(f"signs[{k}] is {sign:g}, expected 1 or -1.", "signs", k)
    joints = _texts(table, "joints") if "joints" in table else ()
    found = LogLayout(
        table.file,
        time,
        columns,
        _units(table),
        joints,
        lists.get("signs", ()),
        lists.get("offsets", ()),
        _gains(table, lists),
        _rate(table),
    )
    _same_length(table, found)
    return found


def _same_length(table: TomlTable, layout: LogLayout) -> None:
    """RowRefusal lists of different lengths: each has an entry for each joint."""
    sizes = {key: len(x) for key, x in {**layout.columns, **layout.lists()}.items() if x}
    for key, size in sizes.items():
        first = next(iter(sizes))
        if size != sizes[first]:
            key = key if key in table else "gears"
            table.refuse(
                f"{key} has {counted(size, 'entry')}, {first} has {sizes[first]}; give one for "
                f"each joint.",
                key,
            )


def _rate(table: TomlTable) -> float | None:
    rate = table.number("rate", default=None)
    if rate is not None and not rate > 0.0:
        table.refuse(f"rate is {rate:g}, expected rows a second.", "rate")
    return rate


def _gains(table: TomlTable, lists: dict[str, tuple[float, ...]]) -> tuple[float, ...]:
    """Torque of the joint over current: as given, or the motor's constant times the gear."""
    constants, gears = lists.get("torque_constants"), lists.get("gears")
    if "gains" in lists:
        if constants or gears:
            other = "torque_constants" if constants else "gears"
            table.refuse(
                f"gains and {other} are both given; gains are torque_constants times gears: leave "
                f"one out.",
                other,
            )
        return lists["gains"]
    if not constants and not gears:
        return ()
    if not constants or not gears or len(constants) != len(gears):
        key = "torque_constants" if constants else "gears"
        table.refuse(
            "torque_constants (N m/A of the motor) and gears (turns of the motor a turn of the "
            "joint, 1 without) go together, one each for every joint.",
            key,
        )
    return tuple(a * b for a, b in zip(constants, gears, strict=True))


def _columns(table: TomlTable, key: str) -> tuple[ColumnRef, ...]:
    """Columns by number or name: one, a range "2-7", or a list."""
    value = table.get(key, None)
    match = _RANGE.fullmatch(value) if isinstance(value, str) else None
    if match:
        first, last = int(match[1]), int(match[2])
        if not 1 <= first <= last:
            table.refuse(f'{key} is "{value}", expected a range such as "2-7".', key)
        return tuple(range(first, last + 1))
    found = value if isinstance(value, list) else [value]
    for k, x in enumerate(found):
        number = isinstance(x, int) and not isinstance(x, bool) and x >= 1
        if not number and not (isinstance(x, str) and x):
            at = (key, k) if isinstance(value, list) else (key,)
            table.refuse(
                f"{key} is {shown(x)}, expected a column's number from 1 or its name, a list of "
                f'them, or a range such as "2-7".',
                *at,
            )
    if not found:
        table.refuse(f"{key} is empty; name its columns, or leave it out.", key)
    return tuple(found)


def _numbers(table: TomlTable, key: str) -> tuple[float, ...]:
    kind = "angle" if key == "offsets" else "number"
    entries = table.listed(table.get(key, None), key, None)
    found = tuple(table.read_number(x, kind, (key, k)) for k, x in enumerate(entries))
    for k, value in enumerate(found):
        if value == 0.0 and key != "offsets":
            table.refuse(f"{key}[{k}] is 0, expected another number.", key, k)
    return found


def _texts(table: TomlTable, key: str) -> tuple[str, ...]:
    entries = table.listed(table.get(key, None), key, None)
    for k, x in enumerate(entries):
        if not isinstance(x, str) or not x:
            table.refuse(f"{key}[{k}] is {shown(x)}, expected a name in quotes.", key, k)
    return tuple(entries)


def _units(table: TomlTable) -> dict[str, tuple[str, ...]]:
    """The units below `units`: text for all joints, or a list of one each."""
    given = table.table("units")
    if given is None:
        return {}
    given.only("time", *QUANTITIES)
    found = {}
    for key, value in given.data.items():
        texts = _texts(given, key) if isinstance(value, list) else (given.text(key),)
        known = TIME_UNITS if key == "time" else QUANTITIES[key].units(None)
        for text in texts:
            if text not in known:
                given.unknown("unit", text, known, key)
        found[key] = texts
    return found
