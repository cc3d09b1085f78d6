"""A program as an operation of JAX: machine code that XLA calls on the CPU, else a call of Python.

What XLA has been given is never freed, so that a program of XLA's may outlive all that freebody
knows of it; equal kernels are given once.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Iterator, Sequence
from functools import cache, partial
from importlib.util import find_spec
from itertools import count
from math import prod
from typing import Any, NamedTuple

import numpy as np

from freebody import locks
from freebody.program.program import Argument, Program
from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.xla import layout

JaxArrays = tuple[Any, ...]

_given: dict[str, tuple[Any, ...]] = {}
"""Name of what XLA was given -> what keeps its code."""


class Compilation(NamedTuple):
    """How kernels of an operation are compiled: the target and width for `compile_program`, the
    width for numbers of one type only."""

    target: str | None = None
    width: int | None = None
    dtype: str | None = None

    def kernel(self, program: Program, dtype: str) -> Kernel:
        """The kernel of a program for numbers of a type, compiled in this way."""
        width = self.width if dtype == self.dtype else None
        return compile_program(program, target=self.target, width=width, dtype=dtype)


class Interface(NamedTuple):
    """XLA's C interface in this process: its version, or the obstacle to using it."""

    version: tuple[int, int] | None
    obstacle: str = ""


@cache
def interface() -> Interface:
    """The interface that XLA offers in this process."""
    try:
        import jax.ffi
    except ImportError:
        return Interface(None, "this version of JAX has no jax.ffi")
    if not find_spec("llvmlite"):
        return Interface(None, "llvmlite is not installed")
    found = layout.version(jax.ffi.include_dir())
    if layout.fits(found):
        return Interface(found)
    said = f"has version {found[0]}.{found[1]}" if found else "does not say its version"
    return Interface(None, f"XLA's interface to compiled functions {said}, known is {layout.MAJOR}")


def operation(program: Program, way: Compilation) -> Callable[..., JaxArrays]:
    """A function of JAX arrays (*batch, *core), of one floating-point type and with equally many
    leading axes, which broadcast: it returns the outputs (*batch, *core).

    It is mapped by `vmap` without copies of what is shared, and has no derivatives.
    """
    import jax

    cores = [len(argument.shape) for argument in program.inputs]

    @cache
    def kernel(dtype: str) -> Kernel:
        return way.kernel(program, dtype)

    def evaluate(*arrays: Any) -> JaxArrays:
        dtype = arrays[0].dtype if arrays else jax.numpy.zeros(()).dtype
        shapes = [x.shape[: x.ndim - core] for x, core in zip(arrays, cores, strict=True)]
        batch = np.broadcast_shapes(*shapes)
        outputs = [jax.ShapeDtypeStruct((*batch, *x.shape), dtype) for x in program.outputs]
        if not any(x.size for x in outputs):
            return tuple(jax.numpy.zeros(x.shape, dtype) for x in outputs)
        size, placed, varies = arranged(arrays, shapes)
        found = kernel(dtype.name)
        if any(x.uniform and many for x, many in zip(program.inputs, varies, strict=True)):
            found = found.per_sample
        results = _partitioned(found.program, partial(_applied, found), size)(*placed)
        return tuple(y.reshape(x.shape) for x, y in zip(outputs, results, strict=True))

    mapped = jax.custom_batching.custom_vmap(evaluate)

    @mapped.def_vmap
    def _rule(
        size: int, batched: Sequence[bool], *arrays: Any
    ) -> tuple[JaxArrays, tuple[bool, ...]]:
        lifted = [x if along else x[None] for x, along in zip(arrays, batched, strict=True)]
        return mapped(*lifted), (True,) * len(program.outputs)

    return mapped


def _applied(kernel: Kernel, arrays: Sequence[Any], batch: tuple[int, int]) -> JaxArrays:
    """The outputs (*batch, *core) for inputs (outer, inner, *core), with each leading size 1 or
    that of the batch."""
    import jax

    shapes = tuple(
        jax.ShapeDtypeStruct((*batch, *x.shape), kernel.dtype) for x in kernel.program.outputs
    )

    def by_python(*arrays: Any) -> JaxArrays:
        return jax.pure_callback(called, shapes, *arrays, vmap_method="sequential")

    def called(*arrays: Any) -> JaxArrays:
        results = kernel(*(np.asarray(array) for array in arrays))
        results = results if isinstance(results, tuple) else (results,)
        # without inputs there are no leading axes
        return tuple(np.reshape(y, x.shape) for x, y in zip(shapes, results, strict=True))

    version = interface().version
    if version is None or kernel.loop is None:
        return by_python(*arrays)
    name = _name(kernel, version)

    def by_machine(*arrays: Any) -> JaxArrays:
        return tuple(jax.ffi.ffi_call(name, shapes)(*arrays))

    return jax.lax.platform_dependent(*arrays, cpu=by_machine, default=by_python)


def _name(kernel: Kernel, version: tuple[int, int]) -> str:
    """The name under which XLA knows the kernel, which is registered first if necessary."""
    import jax.ffi

    from freebody.targets.llvm.lanes import REALS
    from freebody.targets.llvm.loader import load
    from freebody.targets.llvm.machine import host, object_code
    from freebody.targets.xla.handler import text

    assert kernel.loop is not None
    # JAX keeps names with programs on disk, which another process runs: so all that the code
    # depends on is in it
    name = f"freebody_{version[0]}_{version[1]}_{kernel.loop.content}"
    with locks.KERNELS:
        if name not in _given:
            real, each = REALS[kernel.dtype.name], kernel.samples_of_a_thread
            words = text(kernel.program, real, kernel.loop.address, host().x86, version, each)
            code, addresses = load([object_code(words)], ("xla",), {})
            capsule = jax.ffi.pycapsule(ctypes.c_void_p(addresses["xla"]))
            jax.ffi.register_ffi_target(name, capsule, platform="cpu")
            _given[name] = code, kernel.loop
    return name


_Batch = tuple[int, int]


def _partitioned(
    program: Program, compute: Callable[[Sequence[Any], _Batch], Any], batch: _Batch
) -> Callable[..., Any]:
    """The function compute(arrays, batch), for arrays (outer, inner, *core) with leading sizes 1 or
    those of the batch, made so that XLA cuts it along the batch of arrays on several devices and
    never cuts vectors or matrices. Otherwise XLA would gather all samples on every device.

    Where a process sees one device alone, nothing is changed: what XLA may cut, JAX does not keep
    on disk.
    """
    import jax

    if jax.device_count() == 1:
        return lambda *arrays: compute(arrays, batch)
    from jax.experimental.custom_partitioning import custom_partitioning
    from jax.sharding import NamedSharding, PartitionSpec

    def whole(*arrays: Any) -> Any:
        return compute(arrays, batch)

    def part(*arrays: Any) -> Any:
        sizes = ([x.shape[axis] for x in arrays] for axis in (0, 1))
        outer, inner = (max(every, default=1) for every in sizes)
        return compute(arrays, (outer, inner))

    def uncut(argument: Argument, placed: Any) -> Any:
        """The sharding of an argument along the batch as it lies, with vectors and matrices in one
        piece."""
        spec = (*placed.sharding.spec, None, None)[:2]
        core = (None,) * len(argument.shape)
        return NamedSharding(placed.sharding.mesh, PartitionSpec(*spec, *core))

    def partition(mesh: Any, arguments: Any, results: Any) -> Any:
        given = tuple(map(uncut, program.inputs, arguments))
        return mesh, part, tuple(map(uncut, program.outputs, results)), given

    def made(*arrays: Any) -> Any:
        numbers = count()
        inputs = [list(_axes(x.shape[:2], x.ndim - 2, batch, numbers)) for x in arrays]
        outputs = [list(_axes(batch, len(x.shape), batch, numbers)) for x in program.outputs]
        rule = " -> ".join(", ".join(map(" ".join, side)) for side in (inputs, outputs))
        own = [name for axes in inputs + outputs for name in axes if name not in _BATCH]
        function = custom_partitioning(whole)
        function.def_partition(
            partition=partition, sharding_rule=rule, need_replication_factors=tuple(own)
        )
        return function(*arrays)

    return made


_BATCH = ("outer", "inner")


def _axes(
    leading: Sequence[int], core: int, batch: _Batch, numbers: Iterator[int]
) -> Iterator[str]:
    """A name for each axis; axes of the batch have the same name in all arrays that vary along
    them."""
    for name, size, whole in zip(_BATCH, leading, batch, strict=True):
        yield name if size == whole > 1 else f"own{next(numbers)}"
    for _ in range(core):
        yield f"own{next(numbers)}"


_SHORT = 64
"""Samples that are too few for a call of a kernel's loop, where there are several calls."""

_ArrayShape = tuple[int, ...]


def arranged(
    arrays: Sequence[Any], shapes: Sequence[_ArrayShape]
) -> tuple[tuple[int, int], list[Any], list[bool]]:
    """Batches of any shape arranged as an outer and an inner axis: the sizes of these, the arrays
    (outer, inner, *core), and whether each array varies along the inner axis.

    shapes: of the leading axes, equally many of each array, which broadcast. Each of the two sizes
    of an array is 1 or that of the batch; an array is copied only where it varies along some of the
    axes that become one, but not all.
    """
    whole = np.broadcast_shapes(*shapes)
    outer, axes = _split(whole, shapes)
    size = prod(whole[axis] for axis in outer), prod(whole[axis] for axis in axes)
    placed, varies = [], []
    for array, shape in zip(arrays, shapes, strict=True):
        core = array.shape[len(shape) :]
        along = [axis for axis in axes if shape[axis] > 1]
        if along and len(along) < len(axes):
            full = tuple(whole[axis] if axis in axes else n for axis, n in enumerate(shape))
            array = _broadcast(array, (*full, *core))
        rows = size[0] if any(shape[axis] > 1 for axis in outer) else 1
        placed.append(array.reshape(rows, size[1] if along else 1, *core))
        varies.append(bool(along))
    return size, placed, varies


def _split(whole: _ArrayShape, shapes: Sequence[_ArrayShape]) -> tuple[list[int], list[int]]:
    """The axes merged into the outer axis, and those merged into the inner one."""
    groups = _alike(whole, shapes)
    first, *others = groups or [[]]
    inner = [axis for group in others for axis in group]
    if others and prod(whole[axis] for axis in inner) >= _SHORT:
        return first, inner
    return [], [*first, *inner]


def _alike(whole: _ArrayShape, shapes: Sequence[_ArrayShape]) -> list[list[int]]:
    """Groups of neighbouring axes along which the same arrays vary."""
    groups: list[list[int]] = []
    last: list[bool] = []
    for axis, size in enumerate(whole):
        if size == 1:
            continue
        pattern = [shape[axis] > 1 for shape in shapes]
        if groups and pattern == last:
            groups[-1].append(axis)
        else:
            groups.append([axis])
        last = pattern
    return groups


def _broadcast(array: Any, shape: _ArrayShape) -> Any:
    import jax.numpy

    return jax.numpy.broadcast_to(array, shape)
