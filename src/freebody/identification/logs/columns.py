"""Which columns of a log hold what: by the layout's word, else by the names in the header.

A name in a header is taken apart into words: those of a joint's name, one that names a quantity
(`actual_q_0`, `/joint_states/elbow_joint/velocity`, `tau3`, `joint1.v`), and numbers, which count
joints from 0 or from 1. ROS's JointState lists joints in an order of its own and names them in
columns of words (`field.name0`), by which numbers are then translated.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError, UnknownNameError, listed
from freebody.identification.logs.layout import ColumnRef, LogLayout
from freebody.identification.logs.quantities import QUANTITIES, TIME_UNITS, words_in
from freebody.identification.logs.table import LogTable
from freebody.model.model import Model
from freebody.motion.files.csv_columns import named_unit
from freebody.motion.ranges import angular, position_columns
from freebody.outputs.display import counted

_WORD = re.compile(r"[A-Z]?[a-z]+|[A-Z]+(?![a-z])|[0-9]+|[^\W\d_a-zA-Z]+")
_BESIDE = words_in(
    "field joint joints state states actual measured data msg robot arm motor link j"
)
"""Words of names that tell nothing."""
_NOT_MEASURED = words_in(
    "target desired des cmd command commanded ref reference setpoint error err tcp tool cartesian "
    "external ext momentum control"
)
"""Words of columns that hold something else than what the joints did."""
_TIMES = ("t", "time", "timestamp", "stamp", "secs", "sec", "seconds")
_NANOSECONDS = ("nsecs", "nsec", "nanosec", "nanoseconds")


@dataclass(frozen=True)
class LogPlan:
    """Columns of a table that are read, by quantity, in the order of `names`, and what turns them
    into SI units and the model's directions."""

    names: tuple[str, ...]
    time: tuple[int, ...]
    """One column of times, two (seconds, and nanoseconds of them), or none."""
    time_unit: str | None
    columns: dict[str, tuple[int, ...]]
    factors: dict[str, Array]
    """Factors (joints,) of each quantity, signs included."""
    stated: frozenset[str]
    """Quantities whose units are stated, which are believed."""
    offsets: Array
    gains: Array | None
    rate: float | None


def plan_of(table: LogTable, layout: LogLayout, model: Model | None) -> LogPlan:
    """The columns of a log and what they mean. Raises FileError, which says what to write."""
    return _Reading(table, layout, model).plan()


@dataclass(frozen=True)
class _NamedColumn:
    """A column by the words of its name: a quantity of a joint."""

    quantity: str
    joint: str
    """The joint's name, or a number where the header counts joints; 1 where it has neither."""
    column: int
    unit: str | None


class _Reading:
    """Columns of one table, looked up."""

    def __init__(self, table: LogTable, layout: LogLayout, model: Model | None):
        self.table, self.layout, self.model = table, layout, model
        self.cells = [named_unit(name, {}) for name in table.names or ()]
        self.joints = () if model is None else joint_names(model)
        heads = [name for name, _ in self.cells]
        known = (
            self.joints
            or layout.joints
            or [x for x in heads if any(y.startswith(f"{x}.") for y in heads)]
        )
        self.words = {name: _words_of(name) for name in known}
        self.named = [
            x for k, (name, unit) in enumerate(self.cells) for x in self.read(k, name, unit)
        ]
        self.numbered = {x.joint: table.first[x.column] for x in self.named if x.quantity == "name"}

    def plan(self) -> LogPlan:
        columns, units, names = self.joint_columns()
        time, time_unit = self.times()
        order = self.order(names)
        count = len(order)
        factors, stated = {}, set[str]()
        for key in columns:
            given = self.layout.units.get(key) or units.get(key) or (None,) * count
            given = tuple(given) * count if len(given) == 1 else tuple(given)
            if len(given) != count:
                raise self.table.refusal(
                    f"units of {key} are {len(given)}, there are {count} joints; give one, or one "
                    f"for each joint."
                )
            stated |= {key} if all(given) else set()
            factors[key] = np.array(
                [self.factor(key, unit, n) for unit, n in zip(given, names, strict=True)]
            )
        signs = np.array(self.per_joint("signs", count) or [1.0] * count)
        gains = self.per_joint("gains", count)
        if gains and "current" not in columns:
            raise self.table.refusal("gains are given, but no current; name its columns.")
        for key in factors:
            if QUANTITIES[key].turns_over:
                factors[key] = factors[key] * signs
        return LogPlan(
            tuple(names[k] for k in order),
            time,
            time_unit,
            {key: tuple(found[k] for k in order) for key, found in columns.items()},
            {key: found[order] for key, found in factors.items()},
            frozenset(stated),
            np.array(self.per_joint("offsets", count) or [0.0] * count)[order],
            np.array(gains)[order] if gains else None,
            self.layout.rate,
        )  # fmt: skip

    def per_joint(self, key: str, count: int) -> tuple[float, ...]:
        """The numbers that the layout lists under a key, one for each joint, or none."""
        found = self.layout.lists()[key]
        if found and len(found) != count:
            raise self.table.refusal(
                f"{key} in {self.layout.file} has {counted(len(found), 'entry')}, the log has "
                f"{counted(count, 'joint')}."
            )
        return found

    # ------------------------------------------------------------ joints
    def joint_columns(
        self,
    ) -> tuple[dict[str, tuple[int, ...]], dict[str, tuple[str | None, ...]], tuple[str, ...]]:
        """Columns of each quantity, their units as the header states them, and the joints' names in
        the order of the columns."""
        layout = self.layout
        given = {k: tuple(map(self.column, refs)) for k, refs in layout.columns.items()}
        names = layout.joints or self.joints_in_header(given)
        if given:
            count = len(next(iter(given.values())))
            if not names:
                names = tuple(f"joint{k + 1}" for k in range(count))
            if len(names) != count:
                first = next(iter(given))
                raise self.table.refusal(
                    f"{first} has {count} columns{self.said_by()}, and there are {len(names)} "
                    f"joints: {listed(names, 8)}."
                )
        units: dict[str, tuple[str | None, ...]] = {}
        for key, quantity in QUANTITIES.items():
            if key in given:
                if self.cells:
                    units[key] = tuple(self.cells[k][1] for k in given[key])
                continue
            found = self.by_name(key, names)
            if found is None:
                if quantity.needed:
                    raise self.table.refusal(self.no_positions())
                continue
            given[key] = tuple(x.column for x in found)
            units[key] = tuple(x.unit for x in found)
        if "torque" not in given and "current" not in given:
            raise self.table.refusal(
                f"no column holds torques or currents of the joints{self.has()}; "
                f"{self.name_them('torque')}."
            )
        return given, units, names

    def joints_in_header(self, given: dict[str, tuple[int, ...]]) -> tuple[str, ...]:
        """Names of the joints in the order of the layout's columns: the model's, else those in the
        header."""
        if self.joints:
            return self.joints
        if given or not self.cells:
            return ()
        found = list(dict.fromkeys(x.joint for x in self.named if x.quantity == "position"))
        if self.numbered and set(found) <= set(self.numbered):
            return tuple(self.numbered[number] for number in found)
        if found and all(x.isdecimal() for x in found):
            found = sorted(found, key=int)
            return tuple(f"joint{int(x) - int(found[0]) + 1}" for x in found)
        return tuple(found)

    def by_name(self, key: str, names: Sequence[str]) -> list[_NamedColumn] | None:
        """The header's columns of a quantity in the order of the joints; None where there are
        none."""
        found = self.by_joint(key)
        by_name = {joint: x for joint, x in found.items() if joint in names}
        counted = {int(j): x for j, x in found.items() if j.isdecimal() and j not in names}
        if not by_name and counted:
            return self.by_number(key, names, counted)
        missing = [name for name in names if name not in by_name]
        if not by_name or (missing and not QUANTITIES[key].needed and key != "torque"):
            return None
        if missing:
            raise self.table.refusal(
                f"there is no {key} of {listed(map(repr, missing), 8)}{self.has()}; a log has a "
                f"column for every joint; {self.name_them(key)}{self.lock_them(missing)}."
            )
        return [by_name[name] for name in names]

    def by_joint(self, key: str) -> dict[str, _NamedColumn]:
        """The header's columns of a quantity by joint, which may be a number."""
        found: dict[str, _NamedColumn] = {}
        for x in self.named:
            if x.quantity != key:
                continue
            joint = self.numbered.get(x.joint, x.joint)
            if joint in found:
                a, b = (self.cells[k][0] for k in (found[joint].column, x.column))
                raise self.table.refusal(
                    f"columns {a!r} and {b!r} both look like the {key} of joint {joint}; remove "
                    f"one, or {self.name_them(key)}."
                )
            found[joint] = x
        return found

    def by_number(
        self, key: str, names: Sequence[str], counted: dict[int, _NamedColumn]
    ) -> list[_NamedColumn]:
        """Columns in the order of their numbers, which must count the joints from 0 or from 1."""
        first = min(counted)
        numbers = range(first, first + len(names))
        if first not in (0, 1) or sorted(counted) != list(numbers):
            raise self.table.refusal(
                f"the {key} is given of joints {listed(map(str, sorted(counted)), 12)}, and "
                f"there are {len(names)} joints: {listed(names, 8)}; {self.name_them(key)}"
                f"{self.lock_them(names[len(counted) :])}."
            )
        return [counted[k] for k in numbers]

    def order(self, names: tuple[str, ...]) -> list[int]:
        """Places of the log's joints in the model's order."""
        if not self.joints:
            return list(range(len(names)))
        for name in names:
            if name not in self.joints:
                assert self.model is not None
                raise self.table.refusal(
                    str(UnknownNameError("joint", name, repr(self.model.name), self.joints))
                )
        missing = [name for name in self.joints if name not in names]
        if missing or len(set(names)) < len(names):
            raise self.table.refusal(
                f"the log is of joints {listed(names, 8)}, the model also has "
                f"{listed(missing, 8)}; each joint is named once{self.lock_them(missing)}."
            )
        return [names.index(name) for name in self.joints]

    def factor(self, key: str, unit: str | None, name: str) -> float:
        """The size of a unit in SI units, 1 where none is given."""
        if unit is None:
            return 1.0
        turns = None
        if self.model is not None and name in self.joints:
            turns = bool(angular(self.model)[self.joints.index(name)])
        known = QUANTITIES[key].units(turns)
        if unit not in known:
            raise self.table.refusal(
                f"{unit!r} is not a unit of the {key} of {name!r}; units: {', '.join(known)}."
            )
        return known[unit]

    # ------------------------------------------------------------ names and numbers of columns
    def read(self, column: int, name: str, unit: str | None) -> Iterator[_NamedColumn]:
        """The quantity and joint that a column's name says, if it says one thing."""
        words = _words_of(name)
        owner, rest = self.joint_in(words)
        if owner and not rest:
            yield _NamedColumn("position", owner, column, unit)
            return
        if _NOT_MEASURED & set(rest):
            return
        quantity, said = _quantity_in(rest)
        left = [w for w in rest if w not in said and w not in _BESIDE]
        if quantity is not None and not (owner and left):
            yield _NamedColumn(quantity, owner or "_".join(left) or "1", column, unit)

    def joint_in(self, words: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
        """The joint whose name is among the words, the longest, and the words beside it."""
        for name in sorted(self.words, key=lambda x: -len(self.words[x])):
            own = self.words[name]
            for k in range(len(words) - len(own) + 1):
                if words[k : k + len(own)] == own:
                    return name, words[:k] + words[k + len(own) :]
        return "", words

    def column(self, ref: ColumnRef) -> int:
        """The place of a column that the layout names."""
        if isinstance(ref, int):
            if ref > self.table.width:
                raise self.table.refusal(
                    f"{self.layout.file} names column {ref}, and there are {self.table.width} "
                    f"columns."
                )
            return ref - 1
        known = [*dict.fromkeys((*(self.table.names or ()), *(name for name, _ in self.cells)))]
        for names in (self.table.names or (), [name for name, _ in self.cells]):
            if ref in names:
                return list(names).index(ref)
        if not known:
            raise self.table.refusal(
                f"{self.layout.file} names column {ref!r}, and the log has no header; give numbers."
            )
        raise self.table.refusal(str(UnknownNameError("column", ref, "the header", known)))

    def times(self) -> tuple[tuple[int, ...], str | None]:
        """The columns of the time, and its unit where that is stated."""
        if self.layout.time:
            found = tuple(map(self.column, self.layout.time))
        else:
            found = self.times_in_header()
        if not found and self.layout.rate is None:
            raise self.table.refusal(
                f"no column holds the time{self.has()}; name it 't', or write rate = ... (rows a "
                f"second) below [log] in {self.where()}."
            )
        unit = self.layout.units.get("time", (None,))[0]
        stated = {self.cells[k][1] for k in found if self.cells} - {None}
        unit = unit or (stated.pop() if len(stated) == 1 else None)
        if unit is not None and unit not in TIME_UNITS:
            raise self.table.refusal(
                f"{unit!r} is not a unit of time; units: {', '.join(TIME_UNITS)}."
            )
        return found, "s" if len(found) == 2 else unit

    def times_in_header(self) -> tuple[int, ...]:
        """The columns of the time by their names: a stamp of the message before the time at which
        it was written down."""
        ends = [(_words_of(name)[-1:] or ("",))[0] for name, _ in self.cells]
        parts = [k for k, end in enumerate(ends) if end in _NANOSECONDS]
        whole = [k for k, end in enumerate(ends) if end in _TIMES]
        if parts:
            before = [k for k in whole if ends[k] in ("secs", "sec") and k < parts[0]]
            if before:
                return before[-1], parts[0]
        stamps = [k for k in whole if ends[k] in ("stamp", "timestamp")]
        return tuple((stamps or whole)[:1])

    # ------------------------------------------------------------ words for errors
    def has(self) -> str:
        if not self.cells:
            return " (the log has no header)"
        return f"; it has {listed((repr(name) for name, _ in self.cells), 8)}"

    def said_by(self) -> str:
        return f" in {self.layout.file}" if self.layout.file else ""

    def where(self) -> str:
        """The file in which a layout belongs."""
        return self.layout.file or "a TOML file beside the log, of the same name"

    def name_them(self, key: str) -> str:
        """Words on how to tell a quantity's columns."""
        example = "14-19" if key in ("torque", "current") else "2-7"
        return f'say which below [log] in {self.where()}, such as {key} = "{example}"'

    def lock_them(self, joints: Sequence[str]) -> str:
        """Words on joints of the model that the log may not have, such as a gripper's; none without
        any."""
        if self.model is None or not joints:
            return ""
        name = joints[0]
        return (
            f"; or, if the log lacks joints, lock them: "
            f'model.with_locked({{"{name}": …}}), --lock {name}=…'
        )

    def no_positions(self) -> str:
        count = len(self.joints) or max(1, (self.table.width - 1) // 3)
        last = [1 + k * count for k in range(4)]
        spans = [f'{key} = "{last[k] + 1}-{last[k + 1]}"' for k, key in enumerate(_EXAMPLE)]
        return (
            f"no column is known as a position of a joint{self.has()}. Write into {self.where()}: "
            f"[log], time = 1, {', '.join(spans)}, with the numbers of your columns."
        )


_EXAMPLE = ("position", "velocity", "torque")
_OF_HEADERS = (
    *QUANTITIES.values(),
    replace(QUANTITIES["position"], name="name", words=frozenset({"name", "names"})),
)
"""Quantities by the words of headers, names of joints among them."""


def _quantity_in(words: tuple[str, ...]) -> tuple[str | None, set[str]]:
    """The one quantity that words name, with the words that do so; None where none or several."""
    found = [(q.name, w) for w in words for q in _OF_HEADERS if w in q.words]
    if len({quantity for quantity, _ in found}) > 1:  # `q_velocity`
        found = [(quantity, w) for quantity, w in found if len(w) > 2]
    kinds = {quantity for quantity, _ in found}
    return (kinds.pop() if len(kinds) == 1 else None), {w for _, w in found}


def _words_of(name: str) -> tuple[str, ...]:
    return tuple(word.lower() for word in _WORD.findall(name))


def joint_names(model: Model) -> tuple[str, ...]:
    """The names of a model's coordinates, each a joint's own. Raises FreebodyError where a joint
    has a quaternion."""
    model.require_tree("read_log")
    if len(position_columns(model)[0]) < model.nq or model.nq != model.nv:
        raise FreebodyError(
            f"read_log: {model.name!r} has joints with quaternions, whose positions are no columns "
            f"of a log; give a model with a fixed base."
        )
    return model.velocity_names
