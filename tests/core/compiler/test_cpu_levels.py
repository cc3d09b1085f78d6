"""Kernels for a level of processors: the same code, whichever processor compiles it."""

from __future__ import annotations

import hashlib
import shutil
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from freebody.any_chain.kernel_options import chosen_option
from freebody.kernels.tracing import program
from freebody.targets import KernelError
from freebody.targets.llvm import cpu, machine
from freebody.targets.llvm.lanes import DOUBLE
from freebody.targets.llvm.shared_functions import object_beside
from support.programs import environment

pytestmark = pytest.mark.skipif(not machine.host().x86, reason="levels of x86-64")

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


def test_code_for_a_level_does_not_depend_on_the_processor(monkeypatch):
    for level in ("x86-64-v2", "x86-64-v3"):
        with monkeypatch.context() as patched:
            here = code(level)
            patched.setattr(machine, "host", lambda: HASWELL)
            assert code(level) == here
            assert machine.at_level(level) != HASWELL


def test_values_are_those_of_the_host_but_for_fused_products():
    """Vectors are shorter, and below v3 nothing is fused."""
    own = fb.kernel(ARM, "inverse_dynamics")(*STATES.values())
    made = fb.kernel(ARM, "inverse_dynamics", target="cpu:x86-64-v2")
    assert (made.target, made.width) == ("cpu:x86-64-v2", 2)
    assert np.allclose(made(*STATES.values()), own, rtol=1e-12, atol=1e-13)
    assert "<2 x double>" in made.source


def test_what_a_processor_cannot_run_is_refused(monkeypatch):
    monkeypatch.setattr(machine, "host", lambda: HASWELL)
    with pytest.raises(
        KernelError, match=r"v4' does not run here: this CPU \(haswell\) lacks avx5"
    ):
        fb.sweep(ARM, "inverse_dynamics", over=OVER, cpu="x86-64-v4")
    with pytest.raises(KernelError, match=r"v8-a' does not run here: .* of another architecture"):
        fb.kernel(ARM, "mass_matrix", target="cpu:armv8-a")


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


QEMU = shutil.which("qemu-x86_64")
SCRIPT = """
import hashlib, sys
sys.path.insert(0, sys.argv[1])
import test_cpu_levels as test
print(test.machine.host().cpu, *(
    hashlib.sha256(test.code(level)).hexdigest() for level in ("x86-64-v2", "x86-64-v3")))
"""


@pytest.mark.long
@pytest.mark.skipif(QEMU is None, reason="needs qemu-x86_64 (Debian's qemu-user)")
def test_emulated_processors_give_the_same_code():
    assert QEMU is not None
    here = [hashlib.sha256(code(level)).hexdigest() for level in ("x86-64-v2", "x86-64-v3")]
    for name in ("SandyBridge", "Haswell"):  # NumPy's wheel needs more than Nehalem
        command = [QEMU, "-cpu", name, sys.executable, "-c", SCRIPT, __file__.rsplit("/", 1)[0]]
        found = subprocess.run(command, capture_output=True, text=True, env=environment())
        assert found.stdout.split() == [name.lower(), *here]
