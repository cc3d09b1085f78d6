"""Sweeps in Zarr stores: each block is a region of the arrays, and a sweep that was stopped
continues where it was.

A block's numbers are written first and how many of its points failed last, so that a block counts
as done when it is whole on the disk.
"""

from __future__ import annotations

import contextlib
import json
import os
import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from freebody.errors import FileError, FreebodyError, MissingPackageError, listed
from freebody.locks import imported
from freebody.outputs.files import reason
from freebody.sweeps.evaluation import BlockResult, FailedPoint, SweepBlock, SweepBlocks, SweepTask
from freebody.sweeps.identity import differing

if TYPE_CHECKING:
    import xarray as xr

_HASH = "freebody_sweep"
_WITH, _FINISHED = "computed_with", "finished"
_LEFT = re.compile(r"\.[0-9a-f]{32}\.partial$")
"""Name of a file that Zarr is writing; one stays behind where the process was killed."""
_REASONS = 8192
"""Bytes for the failed points of a block that are told."""
PARTS = "parts"
"""Name of the group of arrays that are gathered block by block."""


class SweepStore:
    """The arrays of a sweep on disk: the rows of its table by its blocks."""

    def __init__(
        self,
        path: str | os.PathLike[str],
        task: SweepTask,
        blocks: SweepBlocks,
        identity: str,
        computed_with: Mapping[str, str],
    ):
        try:
            self._zarr = imported("zarr")
        except ModuleNotFoundError:
            raise MissingPackageError("sweep: store=", "zarr", "sweep") from None
        self.path = Path(path)
        self._kept = task.empty() if task.reductions else []
        self._task, self._blocks, self._with = task, blocks, computed_with
        with self._disk_errors():
            self._open(identity)
            self.done = ~np.isnan(self._failed[:])

    def _open(self, identity: str) -> None:
        """Open the store as it was left, or begin a new one; refuses the store of another sweep."""
        root = self._group()
        held = root.attrs.get(_HASH)
        if held is None:
            if not self._is_bare():
                raise self._of_others()
            self._create(root.create_group(PARTS, overwrite=True))
            # last: a store without it was never begun
            root.attrs.update({_WITH: dict(self._with), _HASH: identity})
        elif held != identity:
            raise self._of_another_sweep(dict(root.attrs.get(_WITH, {})))
        for left in self.path.rglob("*.partial"):
            if _LEFT.search(left.name):
                left.unlink()
        parts = root[PARTS]
        self._failed, self._failures = parts["failed"], parts["reasons"]
        self._arrays = {key: parts[key] for key in self._shapes()}

    def _group(self) -> Any:
        """The folder as a Zarr group: the existing one, or a new one."""
        if self.path.exists() and not self.path.is_dir():
            raise self._of_others()
        mode = "r+" if self._files() else "a"
        try:
            return self._zarr.open_group(str(self.path), mode=mode, zarr_format=3)
        except (FileNotFoundError, NotADirectoryError, ValueError, KeyError):
            if mode == "a":
                raise
            raise self._of_others() from None

    def _of_another_sweep(self, begun_with: Mapping[str, str]) -> FreebodyError:
        others = differing(self._with, begun_with)
        what = "its function, model, grid, reduction or block size"
        return FreebodyError(
            f"sweep: {self.path} holds another sweep: "
            + (f"it was begun with another {listed(others)}" if others else f"{what} differs")
            + ". Name another store."
        )

    def _is_bare(self) -> bool:
        """Whether the folder holds at most arrays without data, as at the start of a sweep."""
        return all(x.name == "zarr.json" and x.parts[0] in (x.name, PARTS) for x in self._files())

    def _files(self) -> list[Path]:
        """The files in the folder, except those that a killed process was writing."""
        every = self.path.rglob("*")
        return [x.relative_to(self.path) for x in every if not (x.is_dir() or _LEFT.search(x.name))]

    def _of_others(self) -> FreebodyError:
        return FreebodyError(
            f"sweep: {self.path} exists, and is no store of a sweep. Name another."
        )

    def _shapes(self) -> dict[str, tuple[tuple[int, ...], np.dtype]]:
        """Shape and type of each array's entry for one point (or one row of a block), by the
        array's name."""
        task = self._task
        if not task.reductions:
            return {name: (core, np.dtype(float)) for name, core in task.outputs}
        return {
            f"{name}-{key}": (array.shape[1:], array.dtype)
            for (name, _), found in zip(task.outputs, self._kept, strict=True)
            for key, array in found.items()
        }

    def _create(self, parts: Any) -> None:
        (every, columns), blocks = self._task.grid.shape, self._blocks
        high, wide, (groups, count) = blocks.high, blocks.wide, blocks.count

        def create(
            key: str, shape: tuple[int, ...], chunks: tuple[int, ...], kind: Any, *names: str
        ) -> None:
            empty = float("nan") if np.dtype(kind).kind == "f" else 0
            more = {"fill_value": empty, "dimension_names": names}
            parts.create_array(key, shape=shape, chunks=chunks, dtype=kind, **more)

        for key, (core, kind) in self._shapes().items():
            size, step = (count, 1) if self._task.reductions else (columns, wide)
            names = "row", "column", *(f"{key}_{k}" for k in range(len(core)))
            create(key, (every, size, *core), (high, step, *core), kind, *names)
        places = groups, count, _REASONS
        create("reasons", places, (1, 1, _REASONS), "u1", "group", "part", "byte")
        create("failed", (every, count), (high, 1), "f8", "row", "part")

    def holds(self, block: SweepBlock) -> bool:
        """Whether a block is complete on disk."""
        return bool(self.done[block.rows.start, self._blocks.place(block)[1]])

    def write(self, block: SweepBlock, result: BlockResult) -> None:
        """Write a block's results to their region."""
        rows, (group, part) = slice(block.rows.start, block.rows.stop), self._blocks.place(block)
        with self._disk_errors():
            if self._task.reductions:
                for (name, _), found in zip(self._task.outputs, result.gathered, strict=True):
                    for key, array in found.items():
                        self._arrays[f"{name}-{key}"][rows, part] = array
            else:
                columns = slice(block.columns.start, block.columns.stop)
                for (name, _), values in zip(self._task.outputs, result.values, strict=True):
                    self._arrays[name][rows, columns] = values
            if result.reasons:
                self._failures[group, part] = _packed(result.reasons)
            self._failed[rows, part] = result.failed.astype(float)

    def read(self, block: SweepBlock) -> BlockResult:
        """The stored reductions and failures of a block, without the values of its points."""
        rows, (group, part) = slice(block.rows.start, block.rows.stop), self._blocks.place(block)
        with self._disk_errors():
            gathered = [
                {key: self._arrays[f"{name}-{key}"][rows, part] for key in keys}
                for (name, _), keys in zip(self._task.outputs, self._kept, strict=False)
            ]
            failed = self._failed[rows, part].astype(np.int64)
            failures = _unpacked(self._failures[group, part]) if failed.any() else []
        return BlockResult(gathered, [], failed, failures)

    def finish(self, found: xr.Dataset) -> xr.Dataset:
        """The dataset itself, after it is stored beside the blocks, with text coordinates as
        attributes."""
        texts = [name for name, x in found.coords.items() if x.dtype.kind not in "fiu"]
        plain = found.drop_vars(texts)
        names = {str(name): [str(x) for x in found[name].values] for name in texts}
        with self._disk_errors():
            begun = self._root().attrs
        plain.attrs = {**found.attrs, "names": json.dumps(names)}
        plain.attrs |= {_WITH: begun[_WITH], _HASH: begun[_HASH]}
        plain.attrs["failures"] = json.dumps(found.attrs["failures"])
        with self._disk_errors():
            root = self._root()
            if not root.attrs.get(_FINISHED):
                for name in [x for x in root if x != PARTS]:
                    del root[name]  # begun by a process that was stopped, and not whole
                plain.to_zarr(str(self.path), mode="a", zarr_format=3, consolidated=False)
                self._root().attrs[_FINISHED] = True
        return found

    def _root(self) -> Any:
        return self._zarr.open_group(str(self.path), mode="r+")

    def values(self) -> xr.Dataset:
        """All values of each output, (rows, columns, *core), read from disk on access."""
        import xarray as xr

        path, names = str(self.path), [name for name, _ in self._task.outputs]
        with self._disk_errors():
            return xr.open_zarr(path, group=PARTS, chunks=None, consolidated=False)[names]

    @contextmanager
    def _disk_errors(self) -> Iterator[None]:
        """Context that refuses a disk that is full or cannot be written to; finished blocks stay,
        and a later run continues with them."""
        try:
            yield
        except OSError as failure:
            raise FileError(
                self.path,
                None,
                f"cannot be written: {reason(failure)}. What is done is kept; the same call goes "
                f"on with it.",
            ) from None


def _packed(reasons: Sequence[FailedPoint]) -> np.ndarray:
    """Failed points and their reasons as bytes of one length; where not all fit, the first ones."""
    for count in range(len(reasons), -1, -1):
        short = [(r.row, r.column, r.reason[:1000]) for r in reasons[:count]]
        text = json.dumps(short).encode()
        if len(text) <= _REASONS:
            break
    return np.frombuffer(text.ljust(_REASONS, b"\0"), dtype="u1")


def _unpacked(packed: np.ndarray) -> list[FailedPoint]:
    with contextlib.suppress(ValueError):
        return [FailedPoint(*x) for x in json.loads(packed.tobytes().rstrip(b"\0").decode())]
    return []
