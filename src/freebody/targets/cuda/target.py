"""NVIDIA's GPUs as a target: PTX that the driver assembles for the one that is there."""

from __future__ import annotations

from freebody.program.program import Program
from freebody.targets.cuda.driver import missing
from freebody.targets.cuda.kernel import GpuKernel
from freebody.targets.cuda.plan import plan
from freebody.targets.target import Target


def _build(program: Program, width: int | None, dtype: str) -> GpuKernel:
    return GpuKernel(program, plan(program, dtype), dtype)


def _source(program: Program, width: int, dtype: str) -> str:
    return plan(program, dtype).text


TARGET = Target(
    build=_build,
    source=_source,
    widths={"float64": (), "float32": ()},
    variant=lambda program: None,
    loops=True,
    missing=missing,
    host=False,
)
