"""Where memory ends: an error that names what asked for it and how much, no end of the process; and
a worker of the tests that dies nevertheless leaves its last words."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyError, OutOfMemoryError
from support.programs import environment

MANY = 10**13
ARM, CHAIN = fb.load("ur5e"), fb.load("four_bar")
START = np.array([0.1, -1.0, 0.9, 0.3, 0.7, 0.1])
Q = np.broadcast_to(np.zeros(6), (MANY, 6))
"""More positions than any memory holds, in the memory of one."""

TOO_LARGE: dict[str, Callable[[], Any]] = {
    "random_state: batch=(10000000000000,) ": lambda: fb.random_state(ARM, 0, (MANY,)),
    "inverse_dynamics: q of shape (10000000000000, 6) ": lambda: fb.inverse_dynamics(ARM, Q, Q, Q),
    "bias: q of shape (10000000000000, 6) ": lambda: fb.kernel(ARM, "bias", target="numpy")(Q, Q),
    "inverse_velocity: V of shape (10000000000000, 6) ": lambda: fb.inverse_velocity(ARM, Q, Q),
    "default_motion: samples=10000000000000 ": lambda: fb.default_motion(ARM, samples=MANY),
    "default_motion: samples=10000000000000000000 ": (
        lambda: fb.default_motion(ARM, samples=10**6 * MANY)
    ),
    "quintic: step=1e-13 ": lambda: fb.quintic(ARM, [START, START + 1], [0, 1], step=1 / MANY),
    "time_optimal: points=10000000000000 ": lambda: fb.time_optimal(
        ARM, fb.quintic(ARM, [START, START + 1], [0, 1]), points=MANY
    ),
    "workspace: points of shape (10000000000000, 3) ": lambda: fb.workspace(ARM, Q[:, :3]),
    "sweep: over of q ": lambda: fb.sweep(ARM, "mass_matrix", over={"q": Q}),
    "sweep: the 1e+15 points of M ": lambda: fb.sweep(
        fb.load("2R"),
        "mass_matrix",
        over={n: np.linspace(1, 2, k) for n, k in (("m1", 10**6), ("m2", 10**6), ("l1", 10**3))},
        at={"q": [0, 0]},
    ),
    "simulate: t of shape (10000000000000,) ": lambda: fb.simulate(
        ARM, START, START, t=np.broadcast_to(1.0, (MANY,))
    ),
    "assembly_modes: starts=10000000000000 ": lambda: fb.assembly_modes(
        CHAIN, fb.assemble(CHAIN), free=["crank_pin", "coupler_pin", "rocker_pin"], starts=MANY
    ),
    "with_payload: mass: the array of shape (10000000000000,) ": (
        lambda: ARM.with_payload(np.broadcast_to(1.0, (MANY,)))
    ),
}


@pytest.mark.parametrize("words", TOO_LARGE)
def test_an_argument_beyond_all_memory_is_named(words: str):
    with pytest.raises(OutOfMemoryError) as problem:
        TOO_LARGE[words]()
    said = str(problem.value)
    assert said.startswith(words)
    assert isinstance(problem.value, FreebodyError)
    assert isinstance(problem.value, MemoryError)
    assert "fit into memory" in said


def test_the_size_is_said():
    with pytest.raises(MemoryError, match=r"shape \(10000000000000, 6, 6\), 2\.56 PiB"):
        fb.mass_matrix(ARM, Q)


LIMITED = """
import re, resource, sys
import numpy as np
import freebody as fb

model = fb.load("panda")
np.linalg.inv(np.random.default_rng(0).random((200, 200)))  # BLAS takes memory of its own
if sys.argv[2] == "loaded":
    fb.kernel(fb.load("2R"), "bias")
size = int(re.search(r"VmSize:\\s+(\\d+)", open("/proc/self/status").read())[1]) * 1024
resource.setrlimit(resource.RLIMIT_AS, (size + int(sys.argv[1]) * 2**20,) * 2)
try:
    fb.kernel(model, "inverse_dynamics")
except MemoryError as problem:
    print(type(problem).__name__, problem)
else:
    print("compiled")
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux how much memory a process has")
@pytest.mark.parametrize(
    ("room", "before", "words"),
    [
        (1, "loaded", r"OutOfMemoryError LLVM may need \d\d MiB of memory to compile 0\.\d+ MB"),
        (100, "nothing", "OutOfMemoryError LLVM may need 200 MiB of memory to load its library"),
        (60, "loaded", "compiled"),
    ],
)
def test_a_kernel_without_memory_is_an_error_and_not_the_end(room: int, before: str, words: str):
    """LLVM ends a process whose memory ends."""
    done = subprocess.run(
        [sys.executable, "-c", LIMITED, str(room), before],
        capture_output=True,
        text=True,
        env=environment() | {"FREEBODY_CACHE": "off"},
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-500:]
    assert re.match(words, done.stdout)


DIES = """
import os

def test_that_ends_its_process():
    os.write(2, b"these are the last words")
    os.abort()
"""


def test_the_last_words_of_a_worker_are_in_the_report(tmp_path: Path):
    (tmp_path / "test_dies.py").write_text(DIES)
    (tmp_path / "conftest.py").write_text("from support.dying_workers import *")
    done = subprocess.run(
        [
            sys.executable,
            "-m",
            "pytest",
            "-n1",
            "--max-worker-restart=0",
            "-q",
            "-p",
            "no:cacheprovider",
            str(tmp_path),
        ],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(Path(__file__).parents[2])},
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 1
    report = done.stdout[done.stdout.index("FAILURES") :]
    assert re.search(r"worker 'gw\d' crashed while running", report)
    assert "these are the last words" in report
    assert "Fatal Python error: Aborted" in report
    assert "in test_that_ends_its_process" in report


_FRESH = """
import os, resource
import numpy as np
import freebody as fb
model = fb.load("ur5e")
for batch in (100, 300, 1000, 4096, 30_000, 700_000):
    state = fb.random_state(model, 1, batch)
    for function in (fb.inverse_dynamics, fb.inverse_dynamics_derivatives):
        size = 8 * batch * (6 if function is fb.inverse_dynamics else 36)
        if size > 2**26:
            continue
        seen = [resource.getrusage(resource.RUSAGE_SELF).ru_minflt]
        for _ in range(5):
            for _ in range(10):
                function(model, *state)
            seen.append(resource.getrusage(resource.RUSAGE_SELF).ru_minflt)
        print(function.__name__, batch, np.diff(seen).min() / 10, size // 4096)
"""


@pytest.mark.skipif(sys.platform != "linux", reason="pages are counted as Linux does")
def test_fresh_results_cost_no_pages():
    """Results that are gone leave their memory to the next: once the heap has its size, next to
    none of the pages that results lie in is asked of the system anew."""
    run = subprocess.run(
        [sys.executable, "-c", _FRESH],
        capture_output=True,
        text=True,
        check=True,
        env=environment(),
        timeout=120,
    )
    rows = [line.split() for line in run.stdout.splitlines()]
    assert len(rows) == 11
    for name, batch, faults, pages in rows:
        assert float(faults) <= 2.0 + 0.02 * float(pages), (name, batch, faults, pages)
