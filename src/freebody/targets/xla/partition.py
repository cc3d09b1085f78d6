"""Arrays that lie on several devices: each computes its own samples.

XLA knows nothing of what a compiled function does, and would gather all samples on every device.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import count
from typing import Any

from freebody.program.program import Argument, Program

Batch = tuple[int, int]


def partitioned(
    program: Program, compute: Callable[[Sequence[Any], Batch], Any], batch: Batch
) -> Callable[..., Any]:
    """compute(arrays, batch) as a function of arrays (outer, inner, *core), each leading size 1 or
    that of the batch, that XLA cuts along the batch; vectors and matrices are never cut.

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
        """Along the batch as it lies, its vectors and matrices in one piece."""
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


def _axes(leading: Sequence[int], core: int, batch: Batch, numbers: Iterator[int]) -> Iterator[str]:
    """A name for each axis; those of the batch have the same in all arrays that vary along it."""
    for name, size, whole in zip(_BATCH, leading, batch, strict=True):
        yield name if size == whole > 1 else f"own{next(numbers)}"
    for _ in range(core):
        yield f"own{next(numbers)}"
