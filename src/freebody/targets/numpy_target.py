"""NumPy as a target: programs run node by node, block by block, without a compiler."""

from __future__ import annotations

from freebody.program.passes import optimise
from freebody.program.program import Program
from freebody.targets.interpreter import BlockedFunction
from freebody.targets.kernel import Kernel
from freebody.targets.target import Target


def _build(program: Program, width: int | None, dtype: str) -> Kernel:
    return Kernel(program, "numpy", 1, BlockedFunction(optimise(program), dtype), dtype)


def _source(program: Program, width: int, dtype: str) -> str:
    return optimise(program).listing()


TARGET = Target(
    build=_build,
    source=_source,
    widths={"float64": (), "float32": ()},
    variant=lambda program: None,
    loops=False,
)
