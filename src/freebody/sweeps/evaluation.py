"""The evaluation of a part of a sweep's table: its values, and the points without one, with the
reason."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from freebody.arrays import Array
from freebody.errors import FreebodyError
from freebody.lazy import cached_property
from freebody.model.model import Model
from freebody.sweeps.reductions import (
    Gathered,
    SweepReduction,
    finished,
    gathered,
    joined,
    needed,
)
from freebody.sweeps.sweep_axes import SweepGrid
from freebody.sweeps.swept_functions import FAILURES, FAULTS, SweptFunction

NOT_A_NUMBER = "the result is not a number"
_GATHERED = 1 << 23
"""Bytes that are gathered from a tile: a histogram has half a megabyte for a row of six joints."""
_MOST_REASONS = 20
"""Failures of a block that are kept with place and reason; the others are counted."""


Reasons = dict[tuple[int, int], str]
"""Why a point has no value, by its row and column."""
ByOutput = Mapping[str, Array]
"""An array for each output, by its name."""


class FailedPoint(NamedTuple):
    """A point of the table without a value, and the reason."""

    row: int
    column: int
    reason: str


class SweepBlock(NamedTuple):
    """A part of the table that is evaluated as one piece of work."""

    rows: range
    columns: range


@dataclass
class BlockResult:
    """The results of a block: for each output its reductions (or, where rows go on in further
    blocks, the numbers these need) or all values; the number of failed points of each row; some of
    those points."""

    gathered: list[Gathered]
    values: list[Array]
    failed: np.ndarray
    reasons: list[FailedPoint] = field(default_factory=list)


InOrder = Callable[[Callable[[SweepBlock], BlockResult], list[SweepBlock]], Iterator[BlockResult]]
"""A `map`: the result of a function for each tile, in order."""
Keep = Callable[[SweepBlock, BlockResult], object]
"""A function that is given each block with its result, as soon as that is there."""


@dataclass(frozen=True)
class SweepTask:
    """A sweep as a function of a block that can be sent to another process."""

    model: Model
    grid: SweepGrid
    function: SweptFunction
    outputs: tuple[tuple[str, tuple[int, ...]], ...]
    """Names and core shapes of the outputs."""
    reductions: tuple[SweepReduction, ...]
    """The reductions; none: the values themselves are kept."""
    whole_rows: bool
    """Whether a block has all columns of its rows, so that they are reduced there."""
    rows_are_robots: bool
    """Whether numbers of the model vary, along rows alone."""
    hoisted: bool
    tile: int
    """Points that are evaluated at once."""

    def __call__(self, block: SweepBlock, side_by_side: InOrder = map) -> BlockResult:
        """The results of a block, evaluated in tiles that are joined in order.

        side_by_side: a `map`, which may be one that evaluates several tiles at a time.
        """
        whole = BlockResult([], [], np.zeros(len(block.rows), dtype=np.int64))
        if not self.reductions:
            shape = len(block.rows), len(block.columns)
            whole.values = [np.empty((*shape, *core)) for _, core in self.outputs]
        refused = self._refused(block.rows)
        high = max(1, min(self.tile // len(block.columns), _GATHERED // self._row_bytes))
        tiles = [
            SweepBlock(some, columns)
            for some in _cut(block.rows, high)
            for columns in _cut(block.columns, self.tile)
        ]
        parts: list[list[Gathered]] = []
        rows: list[Gathered] | None = None  # those of which some columns are in
        found = side_by_side(lambda tile: self._tile(tile, block, refused, whole.values), tiles)
        for tile, part in zip(tiles, found, strict=True):
            whole.failed[_within(tile.rows, block.rows)] += part.failed
            whole.reasons = with_more(whole.reasons, part.reasons, _MOST_REASONS)
            if not self.reductions:
                continue
            if tile.columns == block.columns:
                parts.append(part.gathered)
                continue
            rows = part.gathered if rows is None else joined(rows, part.gathered)
            if tile.columns.stop == block.columns.stop:
                parts.append(self._reduced(rows))
                rows = None
        if parts:
            whole.gathered = [
                {key: np.concatenate([part[k][key] for part in parts]) for key in parts[0][k]}
                for k in range(len(self.outputs))
            ]
        return whole

    def _reduced(self, found: list[Gathered]) -> list[Gathered]:
        return [finished(self.reductions, x) for x in found] if self.whole_rows else found

    def empty(self) -> list[Gathered]:
        """The results of a block of one row without any values."""
        return self._reduced(self._nothing())

    def _nothing(self) -> list[Gathered]:
        values = [np.full((1, 1, *core), np.nan) for _, core in self.outputs]
        return gathered(values, needed(self.reductions), 0)

    @cached_property
    def _row_bytes(self) -> int:
        """The number of bytes gathered for one row before it is reduced."""
        return max(1, sum(array.nbytes for x in self._nothing() for array in x.values()))

    def _tile(
        self, tile: SweepBlock, block: SweepBlock, refused: dict[int, str], places: list[Array]
    ) -> BlockResult:
        """The results of a tile, reduced where the tile has all of the block's columns; where all
        values are wanted, they are put into the block's arrays."""
        rows, columns = tile
        reasons: Reasons = {}
        named = self._values(rows, columns, refused, reasons)
        values = [named[name] for name, _ in self.outputs]
        failed = np.zeros((len(rows), len(columns)), dtype=bool)
        for x in values:
            lacking = np.isnan(x)
            if lacking.any():
                failed |= lacking.any(axis=tuple(range(2, x.ndim)))
        points = _failed_points(tile, failed, reasons) if failed.any() else []
        for whole, x in zip(places, values, strict=False):
            whole[_within(rows, block.rows), _within(columns, block.columns)] = x
        found = gathered(values, needed(self.reductions), columns.start)
        if columns == block.columns:
            found = self._reduced(found)
        return BlockResult(found, [], failed.sum(axis=1), points)

    def _values(
        self, rows: range, columns: range, refused: dict[int, str], reasons: Reasons
    ) -> ByOutput:
        """The values (R, C, *core) by output; a part that is refused is halved until it is a single
        point or robot."""
        shape = len(rows), len(columns)
        reason = refused.get(rows.start) if len(rows) == 1 else None
        if reason is None:
            try:
                return self._all_values(rows, columns, refused)
            except FAULTS:
                raise
            except FAILURES as problem:
                reason = str(problem) if shape == (1, 1) else None
        if reason is not None:
            reasons[rows.start, columns.start] = reason
            return {name: np.full((*shape, *core), np.nan) for name, core in self.outputs}
        if len(rows) > 1:
            axis, halves = 0, [(half, columns) for half in _halved(rows)]
        else:
            axis, halves = 1, [(rows, half) for half in _halved(columns)]
        parts = [self._values(*half, refused, reasons) for half in halves]
        return {
            name: np.concatenate([part[name] for part in parts], axis=axis)
            for name, _ in self.outputs
        }

    def _all_values(self, rows: range, columns: range, refused: dict[int, str]) -> ByOutput:
        """The values (R, C, *core) by output of a part in which every point has one; raises an
        error otherwise."""
        if any(r in refused for r in rows):
            raise FreebodyError("some robots of the part are refused")
        given, shape = self.grid.part(rows, columns), (len(rows), len(columns))
        numbers = {name: given[name] for name in self.function.numbers}
        if numbers and not self.rows_are_robots:
            self.model.bind(_of_one(numbers) if shape == (1, 1) else numbers)
        found = self.function(given, self.hoisted)
        return {name: np.broadcast_to(found[name], (*shape, *core)) for name, core in self.outputs}

    def _refused(self, rows: range) -> dict[int, str]:
        """The rows whose numbers no robot has, with the reason, where rows are robots."""
        if not self.rows_are_robots:
            return {}
        given = self.grid.part(rows, range(1))
        numbers = {name: given[name][:, 0] for name in self.function.numbers}
        try:
            self.model.bind(_of_one(numbers) if len(rows) == 1 else numbers)
        except FreebodyError as problem:
            if len(rows) == 1:
                return {rows.start: str(problem)}
            first, second = _halved(rows)
            return self._refused(first) | self._refused(second)
        return {}


def _failed_points(tile: SweepBlock, failed: np.ndarray, reasons: Reasons) -> list[FailedPoint]:
    """The failed points of each row that has some, each reason once, at its first point."""
    rows = np.flatnonzero(failed.any(axis=1))
    first = failed.argmax(axis=1)
    places = {(tile.rows.start + r, tile.columns.start + int(first[r])) for r in rows.tolist()}
    every = sorted(places | reasons.keys())
    return with_more([], [FailedPoint(*x, reasons.get(x, NOT_A_NUMBER)) for x in every])


def with_more(
    reasons: list[FailedPoint], more: list[FailedPoint], most: int | None = None
) -> list[FailedPoint]:
    """Failed points of a sweep together with further ones; of those in one row with the same reason
    only the first is kept."""
    if not more:
        return reasons
    found: dict[tuple[int, str], FailedPoint] = {}
    for point in [*reasons, *more]:
        found.setdefault((point.row, point.reason), point)
    return list(found.values())[:most]


def _of_one(numbers: ByOutput) -> dict[str, float]:
    """The numbers of a single robot as floats, so that an error does not mention a family's
    member."""
    return {name: float(x.flat[0]) for name, x in numbers.items()}


def _within(part: range, whole: range) -> slice:
    return slice(part.start - whole.start, part.stop - whole.start)


def _cut(whole: range, size: int) -> list[range]:
    return [whole[k : k + size] for k in range(0, len(whole), size)]


def _halved(whole: range) -> tuple[range, range]:
    middle = len(whole) // 2
    return whole[:middle], whole[middle:]


@dataclass(frozen=True)
class SweepBlocks:
    """The table of a given shape cut into blocks of at most so many points, in order: rows
    together, then block after block along the columns. The cut depends on the shape alone, and so
    is the same wherever it runs."""

    shape: tuple[int, int]
    points: int

    @property
    def wide(self) -> int:
        """The number of columns in a block."""
        return min(self.shape[1], self.points)

    @property
    def high(self) -> int:
        """The number of rows in a block: one, where a block does not have all columns."""
        return max(1, self.points // self.wide) if self.wide == self.shape[1] else 1

    @property
    def count(self) -> tuple[int, int]:
        """The number of blocks along the rows and the columns."""
        return -(-self.shape[0] // self.high), -(-self.shape[1] // self.wide)

    def place(self, block: SweepBlock) -> tuple[int, int]:
        """The position of a block in the table, counted in blocks."""
        return block.rows.start // self.high, block.columns.start // self.wide

    def __iter__(self) -> Iterator[SweepBlock]:
        every, across = range(self.shape[0]), range(self.shape[1])
        for r in range(0, len(every), self.high):
            for c in range(0, len(across), self.wide):
                yield SweepBlock(every[r : r + self.high], across[c : c + self.wide])
