"""The record of a target, which says how programs run somewhere, and the choice of a target from
the table and of the width of its vectors."""

from __future__ import annotations

import importlib.util
from collections.abc import Callable, Hashable, Mapping
from dataclasses import dataclass, field
from functools import cache
from typing import TYPE_CHECKING

from freebody.errors import FreebodyError
from freebody.program.program import Program
from freebody.targets import settings

if TYPE_CHECKING:
    from freebody.targets.kernel import Kernel


class KernelError(FreebodyError, TypeError):
    """A kernel requested or called in a way that does not exist."""


@dataclass(frozen=True)
class Target:
    """A target on which programs run: functions that emit code, compile it, load it, and make a
    callable.

    build: the kernel of a verified program, for a width (None: what suits) and a type of number.
    source: what runs, as text, for a width. widths: for each type of number that it computes with,
    the samples in a vector that may be asked for; none where it has no vectors. variant: what else
    the code of a program depends on, from the environment. loops: whether what it makes is a loop
    that releases the GIL and reads uniform inputs once a call. Long batches are then cut, and
    shared among threads. missing: what this machine lacks to run it, in words; empty if nothing.
    host: whether its kernels compute with the host's memory, which tensors of the CPU are. NumPy
    stands in for them where a program has no inputs, or an empty argument; others take these too.
    kinds: narrower targets by name, asked for as "target:kind".
    """

    build: Callable[[Program, int | None, str], Kernel]
    source: Callable[[Program, int, str], str]
    widths: Mapping[str, tuple[int, ...]]
    variant: Callable[[Program], Hashable]
    loops: bool
    missing: Callable[[], str] = lambda: ""
    host: bool = True
    kinds: Mapping[str, Callable[[], Target]] = field(default_factory=dict)


TARGETS: dict[str, Callable[[], Target]] = {}
"""Targets by name: a function that imports the record on first use. `freebody.targets`, which is
imported before any target, fills it."""


@cache
def target_named(name: str) -> Target:
    """The record of a target of the table, or of a kind of one."""
    name, _, kind = name.partition(":")
    record = TARGETS[name]()
    return record.kinds[kind]() if kind else record


def chosen_target(name: str | None) -> str:
    """The name itself; for None that in FREEBODY_TARGET, else "cpu", or "numpy" where LLVM is not
    installed.

    Raises KernelError where there is no such target.
    """
    name = name or settings.TARGET
    if not name:
        return "cpu" if importlib.util.find_spec("llvmlite") else "numpy"
    whole, colon, kind = name.partition(":")
    if whole not in TARGETS:
        known = ", ".join(TARGETS)
        raise KernelError(f"no target {name!r}. Targets: {known} (argument or FREEBODY_TARGET).")
    if colon and kind not in target_named(whole).kinds:
        kinds = ", ".join(target_named(whole).kinds)
        raise KernelError(
            f"target {whole!r} has no kind {kind!r}. "
            + (f"Kinds: {kinds}; write {whole}:KIND." if kinds else "Leave it out.")
        )
    return name


def chosen_width(target: str, width: int | None, dtype: str) -> int | None:
    """The width itself; for None that in FREEBODY_WIDTH, where the target has vectors. None: the
    width that suits the machine.

    Raises KernelError where the target has no such type of number or width.
    """
    widths = target_named(target).widths
    if dtype not in widths:
        raise KernelError(f"target {target!r} has no dtype {dtype!r}. It has: {', '.join(widths)}.")
    if not widths[dtype]:
        if width is not None:
            raise KernelError(f"width={width}: target {target!r} has no vectors; leave it out.")
        return None
    given = settings.WIDTH if width is None else str(width)
    if given is None:
        return None
    if given not in map(str, widths[dtype]):
        listed = ", ".join(map(str, widths[dtype]))
        raise KernelError(
            f"no width {given} of {dtype}. Widths: {listed} (argument or FREEBODY_WIDTH)."
        )
    return int(given)
