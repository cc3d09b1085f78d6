"""C of large robots: gcc and clang compile it without a warning, and it gives what the kernel
gives, double and float.

Long, two minutes: `.venv/bin/pytest -m long -n0 -s tests/ways_out/test_export_robots.py` prints the
differences.
"""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import time
import warnings

import numpy as np
import pytest

import freebody as fb
from support import real_files

pytestmark = pytest.mark.long

WARNINGS = ["-Wall", "-Wextra", "-Wconversion", "-Wdouble-promotion", "-pedantic", "-Werror"]
LIMIT = {"float64": 1e-13, "float32": 1e-5}


def talos(base: str) -> fb.Model:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fb.load(real_files.ROBOTS / "talos_data/robots/talos_reduced.urdf", base=base)


ROBOTS = {
    "ur5e": lambda: fb.load("ur5e"),
    "panda": lambda: fb.load("panda"),
    "talos": lambda: talos("fixed"),
    "talos on a free base": lambda: talos("free"),
    "stewart": lambda: fb.load("stewart"),
}


@pytest.mark.parametrize("compiler", ["gcc", "clang"])
@pytest.mark.parametrize("dtype", LIMIT)
@pytest.mark.parametrize("robot", ROBOTS)
def test_c_compiles_without_a_warning_and_agrees_with_the_kernel(
    robot, dtype, compiler, tmp_path, monkeypatch
):
    if shutil.which(compiler) is None:
        pytest.skip(f"{compiler} is not installed")
    monkeypatch.setattr("freebody.ways_out.exports.COUNT", 30)
    if "talos" in robot and not real_files.FILES:
        pytest.skip("example-robot-data is not installed")
    model = ROBOTS[robot]()
    names = [
        "forward_dynamics",
        "mass_matrix",
        *(["constraint", "constraint_jacobian"] if model.loops else []),
    ]
    fb.export(model, names, tmp_path, dtype=dtype, name="f")
    build = [compiler, "-std=c99", *WARNINGS, "-O1"]
    subprocess.run([*build, "f.c", "f_test.c", "-lm", "-o", "f_test"], cwd=tmp_path, check=True)
    told = subprocess.run(["./f_test"], cwd=tmp_path, capture_output=True, text=True, check=False)
    assert told.returncode == 0, told.stdout
    subprocess.run(
        [*build, "-shared", "-fPIC", "f.c", "-lm", "-o", "f.so"], cwd=tmp_path, check=True
    )
    library = ctypes.CDLL(str(tmp_path / "f.so"))
    kernel = fb.kernel(model, names)
    states = dict(zip(("q", "qd", "tau"), fb.random_state(model, 0, 30), strict=True))
    if model.loops:
        motion = fb.default_motion(model, samples=30)
        states |= {"q": motion.q, "qd": motion.qd}
    given = [states[argument.name].astype(dtype) for argument in kernel.program.inputs]
    expected = kernel(*given)
    worst = dict.fromkeys(names, 0.0)
    for i in range(len(given[0])):
        ins = [np.ascontiguousarray(x[i], dtype) for x in given]
        outs = [np.zeros(argument.shape, dtype) for argument in kernel.program.outputs]
        assert library.f(*(ctypes.c_void_p(x.ctypes.data) for x in (*ins, *outs))) == 0
        for name, found, wanted in zip(names, outs, expected, strict=True):
            largest = np.abs(wanted).max()
            worst[name] = max(worst[name], float(np.abs(found - wanted[i]).max() / largest))
    print(robot, dtype, compiler, worst)
    assert max(worst.values()) <= LIMIT[dtype]


@pytest.mark.parametrize("dtype", LIMIT)
@pytest.mark.parametrize(
    ("compiler", "machine"),
    [("aarch64-linux-gnu-gcc", "qemu-aarch64"), ("arm-linux-gnueabihf-gcc", "qemu-arm")],
)
def test_self_tests_pass_on_arm(compiler, machine, dtype, tmp_path):
    for tool in (compiler, machine):
        if shutil.which(tool) is None:
            pytest.skip(f"{tool} is not installed")
    for name in ("inverse_dynamics", "forward_dynamics"):
        fb.export(fb.load("panda"), name, tmp_path / name, dtype=dtype)
        build = [
            compiler,
            "-std=c99",
            *WARNINGS,
            "-O2",
            f"{name}.c",
            f"{name}_test.c",
            "-lm",
            "-static",
            "-o",
            "t",
        ]
        subprocess.run(build, cwd=tmp_path / name, check=True)
        told = subprocess.run(
            [machine, "./t"], cwd=tmp_path / name, capture_output=True, text=True, check=False
        )
        assert told.returncode == 0, told.stdout + told.stderr


def test_text_is_written_quickly():
    """A Panda's inverse dynamics in a fifth of a second."""
    model = fb.load("panda")
    times = []
    for _ in range(3):
        start = time.process_time()
        fb.source(model, "inverse_dynamics", "c")
        times.append(time.process_time() - start)
    assert min(times) <= 0.2
