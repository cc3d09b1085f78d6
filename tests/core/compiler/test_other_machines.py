"""Kernels for systems and processors that are not at hand. LLVM makes objects for all of them: what
these ask for is what the loader provides there; on AArch64 they are linked with a C program, run
by QEMU's user emulation, and compared with the kernels of this machine (what needs a whole Python
there is run by `tools/aarch64`); for a level of x86-64 the code is the same, whichever processor
compiles it.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody.any_chain.kernel_options import chosen_option
from freebody.kernels.tracing import program
from freebody.program.passes import optimise
from freebody.program.program import Program
from freebody.targets import KernelError
from freebody.targets.llvm import cpu, machine
from freebody.targets.llvm.emit import emit
from freebody.targets.llvm.lanes import DOUBLE, REALS
from freebody.targets.llvm.loader import libraries
from freebody.targets.llvm.machine import Host, host
from freebody.targets.llvm.shared_functions import object_beside
from support.child_process import environment

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


@pytest.mark.sample(1)
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


GCC, QEMU = (shutil.which(name) for name in ("aarch64-linux-gnu-gcc", "qemu-aarch64"))


on_aarch64 = pytest.mark.skipif(
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


@on_aarch64
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


@on_aarch64
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


on_x86 = pytest.mark.skipif(not machine.host().x86, reason="levels of x86-64")


HASWELL = replace(
    machine.host(),
    cpu="haswell",
    features=",".join(f"+{x}" for x in machine.LEVELS["x86-64-v3"].features),
)
"""A processor without AVX-512."""


ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])


STATES = dict(zip(("q", "qd", "qdd"), fb.random_state(ARM, 3, 90), strict=True))


OVER = {"m2": np.linspace(0.5, 3.0, 4), "state": STATES}


def code(level: str) -> bytes:
    """The object of a kernel, made anew."""
    object_beside.cache_clear()
    listed, option = chosen_option(ARM, "inverse_dynamics")
    here = machine.at_level(level)
    return cpu._compiled(program(ARM, listed, option), here.machine(None, DOUBLE), False, here)


@on_x86
def test_code_for_a_level_does_not_depend_on_the_processor(monkeypatch):
    for level in ("x86-64-v2", "x86-64-v3"):
        with monkeypatch.context() as patched:
            here = code(level)
            patched.setattr(machine, "host", lambda: HASWELL)
            assert code(level) == here
            assert machine.at_level(level) != HASWELL


@on_x86
def test_values_are_those_of_the_host_but_for_fused_products():
    """Vectors are shorter, and below v3 nothing is fused."""
    own = fb.kernel(ARM, "inverse_dynamics")(*STATES.values())
    made = fb.kernel(ARM, "inverse_dynamics", target="cpu:x86-64-v2")
    assert (made.target, made.width) == ("cpu:x86-64-v2", 2)
    assert np.allclose(made(*STATES.values()), own, rtol=1e-12, atol=1e-13)
    assert "<2 x double>" in made.source


@on_x86
def test_what_a_processor_cannot_run_is_refused(monkeypatch):
    monkeypatch.setattr(machine, "host", lambda: HASWELL)
    with pytest.raises(
        KernelError, match=r"v4' does not run here: this CPU \(haswell\) lacks avx5"
    ):
        fb.sweep(ARM, "inverse_dynamics", over=OVER, cpu="x86-64-v4")
    with pytest.raises(KernelError, match=r"v8-a' does not run here: .* of another architecture"):
        fb.kernel(ARM, "mass_matrix", target="cpu:armv8-a")


@on_x86
def test_names_that_are_no_level_are_refused():
    for target, words in (
        ("cpu:x86-64-v9", "has no kind 'x86-64-v9'. Kinds: x86-64, x86-64-v2"),
        ("numpy:fast", "target 'numpy' has no kind 'fast'. Leave it out"),
    ):
        with pytest.raises(KernelError, match=words):
            fb.kernel(ARM, "mass_matrix", target=target)
    with pytest.raises(fb.FreebodyError, match="no CPU 'x86-64-v5'"):
        fb.sweep(ARM, "inverse_dynamics", over=OVER, cpu="x86-64-v5")
    with pytest.raises(fb.FreebodyError, match="set FREEBODY_TARGET=cpu:x86-64-v2"):
        fb.sweep(ARM, lambda model, q: q, over={"q": [1.0]}, cpu="x86-64-v2")


@on_x86
def test_a_store_goes_on_where_another_processor_began_it(tmp_path, monkeypatch):
    """With cpu=; without, it says what differs."""
    pytest.importorskip("zarr")

    def swept(name: str, level: str | None) -> dict[str, bytes]:
        fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce="rms", block=90, store=tmp_path / name,
                 cpu=level)  # fmt: skip
        files = [x for x in (tmp_path / name).rglob("*") if x.is_file()]
        return {str(x.relative_to(tmp_path / name)): x.read_bytes() for x in files}

    level, words = "x86-64-v2", "begun with another processor. Name"
    whole, _ = swept("a", level), swept("own", None)
    with monkeypatch.context() as patched:
        patched.setattr(machine, "host", lambda: HASWELL)
        assert swept("a", level) == whole == swept("b", level)
        with pytest.raises(fb.FreebodyError, match=words):
            swept("own", None)
        with pytest.raises(fb.FreebodyError, match=words):
            swept("a", "x86-64-v3")


QEMU_X86 = shutil.which("qemu-x86_64")


SCRIPT = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
import test_other_machines as test
print(test.machine.host().cpu, *(
    hashlib.sha256(test.code(level)).hexdigest() for level in ("x86-64-v2", "x86-64-v3")))
"""


@on_x86
@pytest.mark.long
@pytest.mark.skipif(QEMU_X86 is None, reason="needs qemu-x86_64 (Debian's qemu-user)")
def test_emulated_processors_give_the_same_code():
    assert QEMU_X86 is not None
    here = [hashlib.sha256(code(level)).hexdigest() for level in ("x86-64-v2", "x86-64-v3")]
    for name in ("SandyBridge", "Haswell"):  # NumPy's wheel needs more than Nehalem
        command = [QEMU_X86, "-cpu", name, sys.executable, "-c", SCRIPT, __file__.rsplit("/", 1)[0]]
        found = subprocess.run(command, capture_output=True, text=True, env=environment())
        assert found.stdout.split() == [name.lower(), *here]


@pytest.mark.long
@pytest.mark.filterwarnings("ignore")
@on_x86
def test_a_mixed_cluster_is_refused_unless_a_level_is_named():
    distributed = pytest.importorskip("distributed")

    def pretend_to_be(level: str) -> None:
        """On a worker: a processor that has the features of a level and no more."""
        from dataclasses import replace

        from freebody.targets.llvm import machine

        features = ",".join(f"+{name}" for name in machine.LEVELS[level].features)
        other = replace(machine.host(), cpu="haswell", features=features)
        machine.host = lambda: other

    with (
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        one = next(iter(client.scheduler_info()["workers"]))
        client.run(pretend_to_be, "x86-64-v3", workers=[one])
        given = {"over": OVER, "reduce": "mean", "block": 1000}
        with pytest.raises(fb.FreebodyError, match="a worker has another processor than this"):
            fb.sweep(ARM, "inverse_dynamics", **given, client=client)
        with pytest.raises(
            fb.FreebodyError, match=r"worker .*: this CPU \(haswell\) lacks avx512f"
        ):
            fb.sweep(ARM, "inverse_dynamics", **given, client=client, cpu="x86-64-v4")
        there = fb.sweep(ARM, "inverse_dynamics", **given, client=client, cpu="x86-64-v2")
        here = fb.sweep(ARM, "inverse_dynamics", **given, cpu="x86-64-v2")
        assert all(there[x].values.tobytes() == here[x].values.tobytes() for x in here.data_vars)
