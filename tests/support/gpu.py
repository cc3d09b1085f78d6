"""A GPU that is not there: entries of a GPU's text run on this processor, thread by thread; and
ptxas, which assembles.

What runs is the LLVM text of the entries themselves. Only the registers that tell a thread where it
is are replaced.
"""

from __future__ import annotations

import ctypes
import importlib.util
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from freebody.program import Program
from freebody.targets.cuda.emit import emit
from freebody.targets.cuda.parts import parts, prepared
from freebody.targets.llvm.loader import load
from freebody.targets.llvm.machine import object_code

DRIVER = Path(__file__).with_name("driver.c")
THREADS = 32
_WHERE = {"tid": "thread", "ntid": "threads", "ctaid": "block"}
_PLACES = "".join(f"@{x} = internal global i32 0\n" for x in _WHERE.values())
_SET = """
define void @place(i32 %thread, i32 %threads, i32 %block) {
  store i32 %thread, ptr @thread
  store i32 %threads, ptr @threads
  store i32 %block, ptr @block
  ret void
}
"""


def on_host(text: str) -> str:
    """The text of a module of entries, for this processor; `@place` says which thread is next.

    `@NAME.packed` is the entry NAME with the addresses of its values in one array, as a driver has
    them.
    """
    for register, name in _WHERE.items():
        text = text.replace(
            f"call i32 @llvm.nvvm.read.ptx.sreg.{register}.x()", f"load i32, ptr @{name}"
        )
    text = re.sub(r"declare i32 @llvm\.nvvm.*\n", "", text)
    packed = [
        _packed(*found) for found in re.findall(r"define ptx_kernel void @(\w+)\((.*)\) #3", text)
    ]
    text = text.replace("define ptx_kernel void", "define void")
    assert packed
    assert "nvvm" not in text
    return "\n".join([_PLACES, text, _SET, *packed])


def _packed(name: str, parameters: str) -> str:
    kinds = [parameter.split()[0] for parameter in parameters.split(", ")]
    lines = [f"define void @{name}.packed(ptr %values) {{"]
    for k, kind in enumerate(kinds):
        lines.append(
            f"  %at{k} = getelementptr ptr, ptr %values, i64 {k}\n  %p{k} = load ptr, ptr %at{k}"
        )
        lines.append(f"  %x{k} = load {kind}, ptr %p{k}")
    values = ", ".join(f"{kind} %x{k}" for k, kind in enumerate(kinds))
    return "\n".join([*lines, f"  call void @{name}({values})\n  ret void\n}}\n"])


class Emulated:
    """Entries of a module, to be started as a driver does."""

    def __init__(self, text: str, names: list[str]):
        packed = [f"{name}.packed" for name in names]
        self._code, self.addresses = load([object_code(on_host(text), 1)], ["place", *packed], {})
        self._place = ctypes.CFUNCTYPE(None, *[ctypes.c_int32] * 3)(self.addresses["place"])

    def launch(self, name: str, values: list[int], blocks: int, threads: int = THREADS) -> None:
        """Run every thread of every block with the entry's 64-bit values."""
        entry = ctypes.CFUNCTYPE(None, ctypes.c_void_p)(self.addresses[f"{name}.packed"])
        numbers = (ctypes.c_int64 * len(values))(*values)
        base = ctypes.addressof(numbers)
        pointers = (ctypes.c_void_p * len(values))(*(base + 8 * k for k in range(len(values))))
        for block in range(blocks):
            for thread in range(threads):
                self._place(thread, threads, block)
                entry(ctypes.addressof(pointers))


def values_of(arrays: list[np.ndarray], cores: list[int], count: int) -> list[int]:
    """What an entry takes: of arrays (n, *core) or (*core) the address and the steps; then the
    number of samples."""
    made = []
    for array, core in zip(arrays, cores, strict=True):
        steps = [stride // array.itemsize for stride in array.strides]
        made += [array.ctypes.data, steps[0] if array.ndim > core else 0, steps[-1] if core else 0]
    return [*made, count]


def run(
    program: Program, arrays: list[np.ndarray], dtype: str = "float64"
) -> tuple[np.ndarray, ...]:
    """All outputs for samples (n, *core), as columns, by one emulated thread each and some that are
    left over."""
    program = prepared(program)
    entries = {f"part{k}": piece for k, piece in enumerate(parts(program, dtype))}
    gpu = Emulated(emit(entries, dtype), list(entries))
    count = max(
        len(x) for x, a in zip(arrays, program.inputs, strict=True) if x.ndim > len(a.shape)
    )
    outs = [np.full((a.size, count), 7.0, dtype) for a in program.outputs]
    flat = [
        x.astype(dtype).reshape(*x.shape[: x.ndim - len(a.shape)], a.size)
        for x, a in zip(arrays, program.inputs, strict=True)
    ]
    values = values_of([*flat, *(x.T for x in outs)], [1] * (len(flat) + len(outs)), count)
    for name in entries:
        gpu.launch(name, values, -(-count // THREADS))
    return tuple(x.T.reshape(count, *a.shape) for x, a in zip(outs, program.outputs, strict=True))


def driver(folder: Path, text: str | None = None) -> Path:
    """A library in the place of NVIDIA's driver, with the entries of a text in it."""
    library = folder / "libcuda.so.1"
    command = [
        "cc",
        "-O1",
        "-shared",
        "-fPIC",
        "-Wl,-soname,libcuda.so.1",
        str(DRIVER),
        "-o",
        str(library),
        "-ldl",
    ]
    if text is not None:
        (folder / "entries.o").write_bytes(object_code(on_host(text), 1))
        command.insert(1, str(folder / "entries.o"))
    subprocess.run(command, check=True)
    return library


def ptxas() -> str:
    """NVIDIA's assembler: from its wheel, which is in the test extra where there is one, or a CUDA
    toolkit's."""
    found = importlib.util.find_spec("nvidia")
    for root in found.submodule_search_locations or () if found else ():
        for path in Path(root).glob("*/bin/ptxas*"):
            return str(path)
    installed = shutil.which("ptxas")
    if installed is None and sys.platform == "linux":
        pytest.fail(
            "ptxas is missing: pip install nvidia-cuda-nvcc-cu12, which is in freebody[test]"
        )
    if installed is None:
        pytest.skip("ptxas is not installed")
    return installed


def assembled(text: str, folder: Path, processor: str = "sm_90") -> list[tuple[int, int, int]]:
    """Registers, bytes spilled and bytes read back of each entry, in order; fails where ptxas
    refuses the text."""
    (folder / "module.ptx").write_text(text, encoding="ascii")
    command = [ptxas(), f"-arch={processor}", "-v", "module.ptx", "-o", "module.cubin"]
    done = subprocess.run(
        command, cwd=folder, capture_output=True, text=True, check=False, timeout=600
    )
    assert done.returncode == 0, done.stderr[:2000]
    entry = (
        r"Function properties for (\w+)\n.*?(\d+) bytes spill stores, "
        r"(\d+) bytes spill loads\n.*Used (\d+) reg"
    )
    return [(int(r), int(s), int(b)) for _, s, b, r in re.findall(entry, done.stderr)]
