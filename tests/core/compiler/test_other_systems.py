"""Kernels for systems and processors that are not at hand: LLVM makes objects for all of them, and
what these ask for is what the loader provides there."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb
from freebody.program.passes import optimise
from freebody.targets.llvm.emit import emit
from freebody.targets.llvm.loader import libraries
from freebody.targets.llvm.machine import Host

NM = shutil.which("llvm-nm")
AVX2 = "+avx2,+fma"
MACHINES = {
    "linux-x86": ("linux", Host("x86_64-unknown-linux-gnu", "haswell", AVX2, "")),
    "linux-arm": ("linux", Host("aarch64-unknown-linux-gnu", "generic", "+neon", "")),
    "macos-x86": ("darwin", Host("x86_64-apple-darwin", "haswell", AVX2, "")),
    "macos-arm": ("darwin", Host("arm64-apple-darwin", "apple-m1", "+neon", "")),
    "windows-x86": ("win32", Host("x86_64-pc-windows-msvc", "haswell", AVX2, "")),
    "windows-arm": ("win32", Host("aarch64-pc-windows-msvc", "generic", "+neon", "")),
}
MARKS = {"_fltused"}
"""Names without use: on Windows it says that there are floating-point numbers."""


@pytest.mark.skipif(NM is None, reason="needs llvm-nm, which reads every format of objects")
@pytest.mark.parametrize("machine", MACHINES)
def test_the_loader_provides_what_kernels_ask_for(machine: str, tmp_path: Path):
    import llvmlite.binding as llvm

    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    system, there = MACHINES[machine]
    target = llvm.Target.from_triple(there.triple).create_target_machine(
        cpu=there.cpu, features=there.features, opt=2, reloc="pic", codemodel="small"
    )
    asked = set()
    for robot, quantity, inputs in (
        ("ur5e", "inverse_dynamics", ["*.mass"]),
        ("stewart", "forward_dynamics", ()),  # so long that it has much on its stack
    ):
        program = fb.kernel(fb.load(robot), quantity, inputs=inputs).program
        module = llvm.parse_assembly(emit(optimise(program), there.machine()))
        module.triple, module.data_layout = there.triple, str(target.target_data)
        (tmp_path / "kernel.o").write_bytes(target.emit_object(module))
        done = subprocess.run(
            [NM, "--undefined-only", "--just-symbol-name", "kernel.o"],
            cwd=tmp_path,
            capture_output=True,
            text=True,
            check=True,
        )
        asked.update(done.stdout.split())
    prefix = "_" if system == "darwin" else ""  # of every name of C there
    provided = {prefix + name for names in libraries(system, there.x86).values() for name in names}
    assert asked - MARKS <= provided
    assert asked & provided


WITHOUT = """
import os, sys
for name in ("geteuid", "getuid", "fork", "register_at_fork", "sched_getaffinity", "set_blocking",
             "O_NOFOLLOW", "O_DIRECTORY", "O_CLOEXEC", "O_NONBLOCK", "O_NOCTTY"):
    delattr(os, name)
sys.modules["fcntl"] = sys.modules["pwd"] = sys.modules["resource"] = None
import freebody.cli
freebody.cli.main()
"""
"""The command where the system is not POSIX: what Windows has no counterpart of is gone."""


def test_a_study_needs_nothing_that_only_posix_has(tmp_path: Path):
    done = subprocess.run(
        [sys.executable, "-c", WITHOUT, "study", "2R", "--out", "study"],
        cwd=tmp_path,
        env=os.environ | {"FREEBODY_CACHE": str(tmp_path / "cache")},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert "report.html" in {path.name for path in (tmp_path / "study").iterdir()}
    assert any((tmp_path / "cache").iterdir())  # compiled code is kept
