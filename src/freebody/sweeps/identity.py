"""Whether two sweeps are the same: a hash of all that their results depend on."""

from __future__ import annotations

import hashlib
import importlib.metadata
import platform
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy._core._multiarray_umath import __cpu_features__

from freebody.kernels.inputs import InputKernel
from freebody.sweeps.evaluation import SweepTask
from freebody.sweeps.fingerprint import fingerprint
from freebody.sweeps.functions import SweptCallable, SweptFunction
from freebody.sweeps.samples import SAMPLERS, Samples
from freebody.targets import Kernel
from freebody.targets.llvm.cpu import compiler_version
from freebody.targets.llvm.machine import at_level
from freebody.targets.target import chosen_target


class SweepNeeds(NamedTuple):
    """What computes a sweep. target: of its kernel; None of a function of Python, which may call
    kernels of the process's own target and whatever NumPy has. scipy: whether it makes samples."""

    target: str | None
    scipy: bool


def needs_of(task: SweepTask) -> SweepNeeds:
    """What computes a task."""
    kernel = _kernel(task.function)
    every = [axis.given for axis in (*task.grid.rows, *task.grid.columns)]
    scipy = any(isinstance(x, Samples) and SAMPLERS[x.method].scipy for x in every)
    return SweepNeeds(None if kernel is None else kernel.target, scipy)


def computed_with(needs: SweepNeeds) -> dict[str, str]:
    """What last digits depend on besides the arguments: versions, and the processor that code is
    made for, which for a level (`cpu=`) is the same everywhere."""
    target, _, level = (needs.target or chosen_target(None)).partition(":")
    found = {"freebody": compiler_version(), "NumPy": np.__version__}
    if target == "cpu":
        made_for = at_level(level or None)
        found["processor"] = " ".join((made_for.triple, made_for.cpu, *sorted(made_for.has)))
        found["LLVM"] = made_for.llvm
    if target != "cpu" or needs.target is None:
        used = sorted(name for name, there in __cpu_features__.items() if there)
        found["processor's instructions used by NumPy"] = f"{platform.machine()} {' '.join(used)}"
    if needs.scipy:
        found["SciPy"] = importlib.metadata.version("scipy")
    return found


def differing(here: Mapping[str, str], there: Mapping[str, str]) -> list[str]:
    """Names of what is not the same."""
    return [key for key in {**here, **there} if here.get(key) != there.get(key)]


def identity(task: SweepTask, points: int) -> str:
    """SHA-256 in hexadecimal, of the function, the robot, the grid, what is gathered, how the table
    is cut into blocks of so many points, and what it is computed with."""
    digest = hashlib.sha256()

    def add(*parts: Any) -> None:
        for part in parts:
            content = part if isinstance(part, bytes) else repr(part).encode()
            digest.update(len(content).to_bytes(8, "little") + content)

    with_what = sorted(computed_with(needs_of(task)).items())
    add("3", with_what, points, task.tile, task.hoisted)
    add([x.name for x in task.reductions])
    add(task.outputs, *_function(task.function), *fingerprint(task.model))
    for axes in (task.grid.rows, task.grid.columns):
        add(*(part for axis in axes for part in (axis.name, *_given(axis.given))))
    add(*_given(task.grid.constants))
    return digest.hexdigest()


def _given(arrays: Mapping[str, Any]) -> list[Any]:
    if isinstance(arrays, Samples):
        bounds = [
            part for name, pair in arrays.bounds.items() for part in (name, *fingerprint(pair))
        ]
        return ["samples", arrays.count, arrays.method, arrays.seed, *bounds]
    return [part for name, array in arrays.items() for part in (name, *fingerprint(array))]


def _function(function: Any) -> list[Any]:
    if isinstance(function, SweptCallable):
        return fingerprint(function.function)
    kernel = _kernel(function)
    assert kernel is not None
    code = kernel.program.digest
    return [code, kernel.target, kernel.width, kernel.dtype.name, function.numbers]


def _kernel(function: SweptFunction) -> Kernel | None:
    made = getattr(function, "kernel", None)
    return made.kernel if isinstance(made, InputKernel) else made
