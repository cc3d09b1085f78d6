"""Kernels of a model's structure, which take the model's numbers as inputs.

The numbers are one more input p, of which a kernel takes what it reads. So robots that differ in
numbers share what is compiled, and a changed number compiles nothing. What is compiled lives as
long as some model of the structure.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from freebody.arrays import Array
from freebody.elementary import Scalar
from freebody.kernels.formulas import FORMULAS, POSITIONS, Option
from freebody.kernels.lookup import ColumnKernel, KernelList, in_columns
from freebody.kernels.tracing import program
from freebody.model.contributions import joined, pose_part
from freebody.model.model import Model
from freebody.model.structure import frame_form, laws_shown, tree_over
from freebody.model.tree import Tree
from freebody.program import Argument, Program
from freebody.program.passes import without_unread
from freebody.targets import Kernel, compile_program
from freebody.targets.finite_check import sound


@dataclass(frozen=True)
class Compiled:
    """A compiled kernel of a structure, with the indices of the numbers that it reads and the
    places of quaternions among its inputs."""

    kernel: Kernel
    read: slice | NDArray[np.intp]
    quaternions: tuple[tuple[int, int], ...]
    """Pairs (input, entry of it) where a quaternion begins."""


class Bound:
    """A kernel of a structure together with one model's numbers: called like a kernel specialised
    to the model."""

    __slots__ = ("kernel", "numbers", "quaternions")

    def __init__(
        self,
        kernel: Kernel | ColumnKernel | KernelList,
        numbers: tuple[Array, ...] = (),
        quaternions: tuple[tuple[int, int], ...] = (),
    ):
        """Take over a kernel; numbers: the array that is its last argument, none where the kernel's
        parts hold their own.

        quaternions: see `Compiled`.
        """
        self.kernel, self.numbers, self.quaternions = kernel, numbers, quaternions

    def __call__(self, *arrays: ArrayLike, out: Any = None, threads: int | None = None) -> Any:
        if out is None and threads is None:
            return self.kernel(*arrays, *self.numbers)
        return self.kernel(*arrays, *self.numbers, out=out, threads=threads)

    def by_columns(self) -> Bound:
        """The kernel for arrays with one more axis in front of their core, along which the robot
        stays the same."""
        return Bound(self.kernel, tuple(p[..., None, :] if p.ndim > 1 else p for p in self.numbers))

    def checked(self, every: bool = False, kept: bool = False) -> Callable[..., Any]:
        """A function of the kernel's remaining inputs, which returns None where some input is not
        surely `sound` (quaternions included). every: whether all outputs must be finite. kept:
        whether outputs of more than a few samples are attached to an exception, so that no kernel
        runs twice."""
        general = self._kept if kept else self._finite if every else self._sound
        if isinstance(self.kernel, Kernel):
            held = self.numbers[0] if self.numbers else None
            return self.kernel.quick_checked(general, held, self.quaternions) or general
        return general

    def _sound(self, *arrays: Any) -> Any:
        return sound(self, arrays, self.quaternions)

    def _finite(self, *arrays: Any) -> Any:
        return sound(self, arrays, self.quaternions, every=True)

    def _kept(self, *arrays: Any) -> Any:
        return sound(self, arrays, self.quaternions, every=True, kept=True)


def fetch(model: Model, names: tuple[str, ...], option: Option) -> Bound:
    """The kernel of the model's structure, compiled on first use, with the model's numbers."""
    found = known(model, names, option)
    if found is None:
        large = in_columns(
            model,
            names,
            option,
            lambda part: fetch(model, (part,), Option()).by_columns(),
            lambda some: fetch(model, some, option),
        )
        if large is not None:
            found = model.compiled[names, option, "structure"] = Bound(large)
        else:
            model.structure.kernels[_key(model, names, option)] = _compiled(model, names, option)
            found = known(model, names, option)
            assert found is not None
    return found


def known(model: Model, names: tuple[str, ...], option: Option) -> Bound | None:
    """The kernel if it has been compiled before, for this model or another of its structure; None
    otherwise."""
    place = names, option, "structure"
    found = model.compiled.get(place)
    if found is None:
        found = ready(model, names, option)
        if found is not None:
            model.compiled[place] = found
    return found


def ready(model: Model, names: tuple[str, ...], option: Option) -> Bound | None:
    """The kernel if it has been compiled before, else None; it is not kept with the model, for
    callers that keep what they make of it."""
    compiled = model.structure.kernels.get(_key(model, names, option))
    if compiled is None:
        return None
    numbers = _numbers(model, option, compiled.read)
    return Bound(compiled.kernel, (numbers,), compiled.quaternions)


def _key(model: Model, names: tuple[str, ...], option: Option) -> tuple[Any, ...]:
    """The key of a kernel among those of a structure: the names and the option, with the structure
    of frames in place of their names."""
    if option == PLAIN and True not in map(_shows_drives, names):
        return names
    frames = tuple([frame_form(model, name) for name in _frames(option)])
    nameless = option._replace(frame=None, wrench_frames=()) if frames else option
    return names, nameless, option.frame is None, frames, _shown_drives(model, names)


PLAIN = Option()
"""The option without any choice."""

Over = Callable[[Sequence[Scalar]], Tree]
"""Scalars in the place of a model's numbers -> its tree."""

_OWN = 8
"""Kernels of programs of one kind that are no formula's, kept for one structure."""


def _frames(option: Option) -> tuple[str, ...]:
    return option.wrench_frames if option.frame is None else (option.frame, *option.wrench_frames)


def _shown_drives(model: Model, names: tuple[str, ...]) -> tuple[tuple[str, ...], ...] | None:
    """For each body the names of its drive's laws, as part of a kernel's key; None where no output
    has entries for single laws."""
    return laws_shown(model) if any(map(_shows_drives, names)) else None


@cache
def _shows_drives(name: str) -> bool:
    return any("parameters" in output.dims for output in FORMULAS[name].outputs.values())


def _numbers(model: Model, option: Option, read: slice | NDArray[np.intp]) -> Array:
    """The numbers that a kernel reads from a model, (k,) or for a family (*family, k), even where
    its members share them."""
    numbers, frames = model.numbers, _frames(option)
    if frames:
        numbers = joined(
            [numbers, *(pose_part(model.frame(f).placement, model.dim).numbers for f in frames)]
        )
    chosen = numbers[..., read]
    if (
        chosen.ndim > 1 and chosen.strides[-1] != chosen.itemsize
    ):  # a kernel reads rows twice as quickly
        chosen = np.ascontiguousarray(chosen)
    if chosen.shape[:-1] != model.family:
        chosen = np.broadcast_to(chosen, (*model.family, chosen.shape[-1]))
    return chosen


def _compiled(model: Model, names: tuple[str, ...], option: Option) -> Compiled:
    return _compiled_over(
        model,
        option,
        lambda p, over: program(model, names, option, p, over),
        _shown_drives(model, names),
    )


def fetch_own(
    model: Model, key: tuple[str, ...], option: Option, made: Callable[[Argument, Over], Program]
) -> Bound:
    """The kernel of a program other than a formula's, with the model's numbers: compiled by `made`,
    from p and the tree over its scalars, where the structure has none of that key. Only the last
    few kernels whose keys begin alike are kept."""
    kernels, place = model.structure.kernels, (*key, _key(model, (), option))
    compiled = kernels.pop(place, None) or _compiled_over(model, option, made, None)
    alike = [k for k in list(kernels) if k[0] == key[0]]
    for old in alike[: len(alike) + 1 - _OWN]:
        kernels.pop(old, None)
    kernels[place] = compiled
    return Bound(compiled.kernel, (_numbers(model, option, compiled.read),), compiled.quaternions)


def _compiled_over(
    model: Model,
    option: Option,
    made: Callable[[Argument, Over], Program],
    drives_shown: tuple[tuple[str, ...], ...] | None,
) -> Compiled:
    """The compiled kernel of a program whose model's numbers are inputs; inputs that the program
    never reads are dropped."""
    count = sum(
        pose_part(model.frame(f).placement, model.dim).numbers.shape[-1] for f in _frames(option)
    )
    p = Argument("p", (model.numbers.shape[-1] + count,), uniform=True)

    def over(scalars: Sequence[Scalar]) -> Tree:
        return tree_over(model, scalars, _frames(option), drives_shown)

    traced, read = without_unread(made(p, over), "p")
    given = [i for i, argument in enumerate(traced.inputs) if argument.name in POSITIONS]
    quaternions = tuple((i, start) for i in given for start in model.structure.quaternions)
    return Compiled(compile_program(traced), _in_one_piece(read), quaternions)


def _in_one_piece(read: tuple[int, ...]) -> slice | NDArray[np.intp]:
    """The indices as a slice where they are consecutive, since slicing copies nothing; else as an
    array."""
    first, last = read[0], read[-1]
    return (
        slice(first, last + 1) if last - first + 1 == len(read) else np.array(read, dtype=np.intp)
    )
