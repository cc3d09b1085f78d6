"""Kernels for AArch64: compiled here, linked with a C program, run by QEMU's user emulation, and
compared with the kernels of this machine.

What needs a whole Python there is run by `tools/aarch64`.
"""

from __future__ import annotations

import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.program.passes import optimise
from freebody.program.program import Program
from freebody.targets.llvm.emit import emit
from freebody.targets.llvm.lanes import REALS
from freebody.targets.llvm.machine import Host, host

GCC, QEMU = (shutil.which(name) for name in ("aarch64-linux-gnu-gcc", "qemu-aarch64"))
pytestmark = pytest.mark.skipif(
    not (GCC and QEMU),
    reason="needs aarch64-linux-gnu-gcc and qemu-aarch64 (Debian's gcc-aarch64-linux-gnu, "
    "libc6-dev-arm64-cross, qemu-user)",
)

THERE = Host("aarch64-unknown-linux-gnu", "generic", "+neon,+fp-armv8", "")
"""Any 64-bit ARM: vectors of 128 bits, fused multiply-add."""

COUNT = 257
"""Samples: whole rounds of every width, and a rest."""

DRIVER = """
#include <fenv.h>
#include <stdint.h>
#include <stdio.h>
void kernel(char **args, intptr_t *dims, intptr_t *steps, void *data);
static {number} {arrays};
int main(void)
{{
    char *args[] = {{{names}}};
    intptr_t dims[] = {{{dims}}}, steps[] = {{{steps}}};
    FILE *file = fopen("in", "rb");
    {read}
    fclose(file);
    kernel(args, dims, steps, 0);
    file = fopen("out", "wb");
    {written}
    return fclose(file) | fetestexcept(FE_ALL_EXCEPT); /* no flag may be left */
}}
"""


def built_and_run(program: Program, inputs: list[np.ndarray], folder: Path) -> list[np.ndarray]:
    """The outputs of a kernel on AArch64 for inputs (COUNT, *core) of one type of number."""
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    real = REALS[inputs[0].dtype.name]
    target = llvm.Target.from_triple(THERE.triple).create_target_machine(
        cpu=THERE.cpu, features=THERE.features, opt=2, reloc="pic", codemodel="small"
    )
    module = llvm.parse_assembly(emit(optimise(program), THERE.machine(real=real)))
    module.triple, module.data_layout = THERE.triple, str(target.target_data)
    (folder / "kernel.o").write_bytes(target.emit_object(module))
    arguments = [*program.inputs, *program.outputs]
    cores = [n for a in arguments for n in a.shape]
    strides = [stride for a in arguments for stride in np.empty(a.shape, inputs[0].dtype).strides]
    whole = [inputs[0].itemsize * a.size for a in arguments]
    read, written = (
        "\n    ".join(
            f"{how}(a{k}, sizeof a{k}, 1, file);"
            for k in range(len(arguments))
            if (k < len(inputs)) == (how == "fread")
        )
        for how in ("fread", "fwrite")
    )
    text = DRIVER.format(
        number={"float64": "double", "float32": "float"}[inputs[0].dtype.name],
        arrays=", ".join(f"a{k}[{COUNT * a.size}]" for k, a in enumerate(arguments)),
        names=", ".join(f"(char *)a{k}" for k in range(len(arguments))),
        dims=", ".join(map(str, [COUNT, *cores])),
        steps=", ".join(map(str, [*whole, *strides])),
        read=read,
        written=written,
    )
    (folder / "driver.c").write_text(text)
    (folder / "in").write_bytes(b"".join(np.ascontiguousarray(x).tobytes() for x in inputs))
    for command in (
        [GCC, "-static", "-O1", "driver.c", "kernel.o", "-lm", "-o", "run"],
        [QEMU, "./run"],
    ):
        subprocess.run(command, cwd=folder, check=True, timeout=60)
    numbers = np.fromfile(folder / "out", inputs[0].dtype)
    ends = np.cumsum([COUNT * a.size for a in program.outputs])
    return [
        part.reshape(COUNT, *a.shape)
        for part, a in zip(np.split(numbers, ends[:-1]), program.outputs, strict=True)
    ]


def same(there: np.ndarray, here: np.ndarray) -> None:
    """Equal in every bit where this machine too has fused multiply-add, else to rounding."""
    if host().machine().fma:
        np.testing.assert_array_equal(there, here)
        return
    limit = 2e4 * np.finfo(here.dtype).eps * np.nanmax(np.abs(here))
    np.testing.assert_allclose(there, here, rtol=0, atol=limit)


@pytest.mark.parametrize("dtype", ["float64", "float32"])
@pytest.mark.parametrize(
    ("robot", "quantity"),
    [
        ("ur5e", "inverse_dynamics"),
        ("ur5e", "forward_dynamics"),
        ("ur5e", "mass_matrix"),
        ("panda", "inverse_dynamics"),
        ("panda", "forward_dynamics"),
        ("five_bar", "forward_dynamics"),
    ],
)
def test_dynamics_are_those_of_this_machine(robot: str, quantity: str, dtype: str, tmp_path: Path):
    model = fb.load(robot)
    kernel = fb.kernel(model, quantity, dtype=dtype)
    rng = np.random.default_rng(7)
    inputs = [rng.uniform(-2, 2, (COUNT, *a.shape)).astype(dtype) for a in kernel.program.inputs]
    if model.loops:
        inputs[0][:] = fb.assemble(model)
        inputs[1][:] = 0.0
    inputs[0][-1, 0] = np.nan  # of no other sample's business
    (there,) = built_and_run(kernel.program, inputs, tmp_path)
    assert np.isnan(there[-1]).all()
    assert np.isfinite(there[:-1]).all()
    same(there, kernel(*inputs))


@pytest.mark.parametrize("dtype", ["float64", "float32"])
def test_functions_are_those_of_this_machine(dtype: str, tmp_path: Path):
    names = ("sin", "cos", "exp", "tanh", "asin", "log", "sqrt", "atan2")
    kernel = fb.compile(
        lambda x: {
            name: [getattr(fb.math, name)(*(x if name == "atan2" else x[:1]))] for name in names
        },
        {"x": 2},
        dtype=dtype,
    )
    rng = np.random.default_rng(8)
    size = 10.0 ** rng.integers(-3, 4, (COUNT, 1))
    x = (size * rng.uniform(-1, 1, (COUNT, 2))).astype(dtype)
    x[:6, 0] = 0.0, 1.0, -1.0, 1e30, np.inf, np.nan
    for there, here in zip(built_and_run(kernel.program, [x], tmp_path), kernel(x), strict=True):
        same(there, here)
