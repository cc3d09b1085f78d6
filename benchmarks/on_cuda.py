"""Kernels on a GPU: evaluations a second with all data there, and the share of what the card's data
sheet allows.

    python benchmarks/on_cuda.py [ROBOT …] [--samples 4000000] [--rounds 20] [--whole]

Needs a GPU and the extra `cuda`. Rows are arrays (n, k), columns (k, n). The limit is the lower of
the two of `ptx.py`, of arithmetic and of memory with nothing spilled. --whole: programs are not
divided among entries, and spill instead. Results are compared with the CPU's.
"""

from __future__ import annotations

import argparse
import platform
import sys
from time import perf_counter
from typing import Any

import numpy as np

import freebody as fb
from freebody.targets.cuda import driver, parts
from freebody.targets.cuda.gpu_arrays import DeviceArray
from ptx import BYTES, INSTRUCTIONS, QUANTITIES, instructions, quantities, robot


class Columns:
    """An array (n, *core) on the GPU whose samples are next to each other."""

    def __init__(self, memory: driver.Memory, shape: tuple[int, ...], dtype: np.dtype):
        n, *core = shape
        steps = [n * int(np.prod(core[k + 1 :])) for k in range(len(core))]
        self.shape, self.dtype, self._memory = shape, dtype, memory
        self.__cuda_array_interface__ = {
            "shape": shape,
            "typestr": dtype.str,
            "data": (memory.address, False),
            "strides": tuple(dtype.itemsize * s for s in (1, *steps)),
            "version": 3,
            "stream": driver.DEFAULT_STREAM,
        }


def resident(values: np.ndarray, columns: bool) -> DeviceArray | Columns:
    """A copy on the GPU, as rows or as columns."""
    flat = np.ascontiguousarray(np.moveaxis(values, 0, -1) if columns else values)
    with driver.current(0):
        memory = driver.Memory(flat.nbytes, 0, driver.DEFAULT_STREAM)
        driver.call(
            "cuMemcpyHtoDAsync",
            memory.address,
            flat.ctypes.data,
            flat.nbytes,
            driver.DEFAULT_STREAM,
        )
        driver.call("cuStreamSynchronize", driver.DEFAULT_STREAM)
    return (Columns if columns else DeviceArray)(memory, values.shape, values.dtype)


def first(array: Any, count: int) -> np.ndarray:
    """Of an array (n, *core) on the GPU the first samples."""
    n, *core = array.shape
    whole = np.empty(array.shape, array.dtype)
    with driver.current(0):
        address = array.__cuda_array_interface__["data"][0]
        driver.call(
            "cuMemcpyDtoHAsync", whole.ctypes.data, address, whole.nbytes, driver.DEFAULT_STREAM
        )
        driver.call("cuStreamSynchronize", driver.DEFAULT_STREAM)
    if isinstance(array, Columns):
        whole = np.moveaxis(whole.reshape(*core, n), -1, 0)
    return whole[:count]


def seconds(kernel: Any, given: list[Any], outs: tuple[Any, ...], rounds: int) -> float:
    """Of one call, the best of three times `rounds` calls in a row."""
    best = float("inf")
    for _ in range(3):
        begin = perf_counter()
        for _ in range(rounds):
            kernel(*given, out=outs, stream=driver.DEFAULT_STREAM)
        with driver.current(0):
            driver.call("cuStreamSynchronize", driver.DEFAULT_STREAM)
        best = min(best, (perf_counter() - begin) / rounds)
    return best


def line(model: fb.Model, name: str, quantity: str, dtype: str, samples: int, rounds: int) -> str:
    """One line of the table."""
    kernel, there = (
        fb.kernel(model, quantity, target=target, dtype=dtype) for target in ("cuda", "cpu")
    )
    program, size = kernel.program, np.dtype(dtype).itemsize
    moved = size * (program.input_size + program.output_size)
    samples = min(samples, int(8e9) // moved)
    rng = np.random.default_rng(0)
    arrays = [
        (0.3 * rng.standard_normal((samples, *a.shape))).astype(dtype) for a in program.inputs
    ]
    expected = there(*(x[:1000] for x in arrays))
    expected = expected if isinstance(expected, tuple) else (expected,)
    count = instructions(kernel.source, dtype)
    limit = min(INSTRUCTIONS[dtype] / count, BYTES / moved)
    found, off = [], 0.0
    for columns in (False, True):
        given = [resident(x, columns) for x in arrays]
        outs = tuple(
            resident(np.zeros((samples, *a.shape), dtype), columns) for a in program.outputs
        )
        rate = samples / seconds(kernel, given, outs, rounds)
        found += [f"{rate / 1e9:.2f}", f"{rate / limit:.0%}"]
        for x, y in zip(outs, expected, strict=True):
            off = max(off, float(np.abs(first(x, 1000) - y).max() / np.abs(y).max()))
    entries = len(kernel.plan.parts)
    shown = (
        name,
        quantity.replace("_", " "),
        dtype,
        entries,
        *found,
        f"{limit / 1e9:.2g}",
        f"{off:.0e}",
    )
    return f"| {' | '.join(map(str, shown))} |"


def main() -> None:
    """The table."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("robots", nargs="*", default=("ur5e", "panda", "stewart"))
    parser.add_argument("--samples", type=int, default=4_000_000)
    parser.add_argument("--rounds", type=int, default=20)
    parser.add_argument("--whole", action="store_true")
    parser.add_argument("--quantities", nargs="+", default=QUANTITIES)
    asked = parser.parse_args()
    if lacking := driver.missing():
        sys.exit(f"not run: {lacking}")
    if asked.whole:
        parts.LARGEST, parts.ALIVE = 0.0, sys.maxsize
    with driver.current(0):
        card = driver.call("cuDeviceGetName", 100, 0).split(b"\0")[0].decode()
    print(
        f"{card}; {platform.node()}; 10^9 evaluations a second, data on the card, share of the "
        f"limit\n"
    )
    print("| robot | quantity | type | entries | rows | share | columns | share | limit | off by |")
    print("|---|---|---|---|---|---|---|---|---|---|")
    for name in asked.robots:
        model = robot(name)
        for quantity in [x for x in asked.quantities if x in quantities(model, every=True)]:
            for dtype in INSTRUCTIONS:
                print(line(model, name, quantity, dtype, asked.samples, asked.rounds), flush=True)


if __name__ == "__main__":
    main()
