"""A program as an operation of JAX: machine code that XLA calls on the CPU, else a call of
Python's.

What XLA has been given is never freed, so that a program of XLA's may outlive all that freebody
knows of it; equal kernels are given once.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from functools import cache, partial
from importlib.util import find_spec
from typing import Any, NamedTuple

import numpy as np

from freebody import locks
from freebody.program.program import Program
from freebody.targets.kernel import Kernel, compile_program
from freebody.targets.xla import layout
from freebody.targets.xla.batch_axes import arranged
from freebody.targets.xla.partition import partitioned

Arrays = tuple[Any, ...]

_given: dict[str, tuple[Any, ...]] = {}
"""Name of what XLA was given -> what keeps its code."""


class Way(NamedTuple):
    """How kernels are made: target and width of `compile_program`, the latter for numbers of this
    type."""

    target: str | None = None
    width: int | None = None
    dtype: str | None = None

    def kernel(self, program: Program, dtype: str) -> Kernel:
        """The kernel of a program for numbers of a type."""
        width = self.width if dtype == self.dtype else None
        return compile_program(program, target=self.target, width=width, dtype=dtype)


class Interface(NamedTuple):
    """XLA's C interface in this process: its version, or what is in the way of using it."""

    version: tuple[int, int] | None
    obstacle: str = ""


@cache
def interface() -> Interface:
    """What XLA offers here."""
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


def operation(program: Program, way: Way) -> Callable[..., Arrays]:
    """A function of JAX's arrays (*batch, *core), of one floating-point type and with equally many
    leading axes, which broadcast: the outputs (*batch, *core).

    It is mapped by `vmap` without copies of what is shared, and has no derivatives.
    """
    import jax

    cores = [len(argument.shape) for argument in program.inputs]

    @cache
    def kernel(dtype: str) -> Kernel:
        return way.kernel(program, dtype)

    def evaluate(*arrays: Any) -> Arrays:
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
        results = partitioned(found.program, partial(_applied, found), size)(*placed)
        return tuple(y.reshape(x.shape) for x, y in zip(outputs, results, strict=True))

    mapped = jax.custom_batching.custom_vmap(evaluate)

    @mapped.def_vmap
    def _rule(size: int, batched: Sequence[bool], *arrays: Any) -> tuple[Arrays, tuple[bool, ...]]:
        lifted = [x if along else x[None] for x, along in zip(arrays, batched, strict=True)]
        return mapped(*lifted), (True,) * len(program.outputs)

    return mapped


def _applied(kernel: Kernel, arrays: Sequence[Any], batch: tuple[int, int]) -> Arrays:
    """The outputs (*batch, *core) of inputs (outer, inner, *core), each leading size 1 or that of
    the batch."""
    import jax

    shapes = tuple(
        jax.ShapeDtypeStruct((*batch, *x.shape), kernel.dtype) for x in kernel.program.outputs
    )

    def by_python(*arrays: Any) -> Arrays:
        return jax.pure_callback(called, shapes, *arrays, vmap_method="sequential")

    def called(*arrays: Any) -> Arrays:
        results = kernel(*(np.asarray(array) for array in arrays))
        results = results if isinstance(results, tuple) else (results,)
        # without inputs there are no leading axes
        return tuple(np.reshape(y, x.shape) for x, y in zip(shapes, results, strict=True))

    version = interface().version
    if version is None or kernel.loop is None:
        return by_python(*arrays)
    name = _name(kernel, version)

    def by_machine(*arrays: Any) -> Arrays:
        return tuple(jax.ffi.ffi_call(name, shapes)(*arrays))

    return jax.lax.platform_dependent(*arrays, cpu=by_machine, default=by_python)


def _name(kernel: Kernel, version: tuple[int, int]) -> str:
    """What XLA knows the kernel by; it is given to XLA where that does not have it yet."""
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
