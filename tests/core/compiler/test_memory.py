"""Where memory ends, or lies in pieces: an error that names what asked for it and how much, no end
of the process; and a worker of the tests that dies nevertheless leaves its last words."""

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
from support.child_process import environment

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


@pytest.mark.sample(1)
@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux how much memory a process has")
@pytest.mark.parametrize(
    ("room", "before", "words"),
    [
        (1, "loaded", r"OutOfMemoryError LLVM may need \d\d MiB of memory .*to compile 0\.\d+ MB"),
        (100, "nothing", "OutOfMemoryError LLVM may need 200 MiB of memory .*to load its library"),
        (60, "loaded", "compiled"),
    ],
)
def test_a_kernel_without_memory_is_an_error_and_not_the_end(room: int, before: str, words: str):
    """LLVM ends a process whose memory ends."""
    assert re.match(words, printed(LIMITED, str(room), before))


def printed(program: str, *arguments: str) -> str:
    """What a program prints, in a process of its own that compiles all that it needs."""
    done = subprocess.run(
        [sys.executable, "-c", program, *arguments],
        capture_output=True,
        text=True,
        env=environment() | {"FREEBODY_CACHE": "off"},
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-500:]
    return done.stdout


APART = """
import ctypes
import numpy as np
import freebody as fb

PAGE, FREE, TAKEN = 4096, 0x4022, 0x104022  # anywhere, or at an address: private, without memory
system = ctypes.CDLL(None)
system.mmap.restype = ctypes.c_void_p
system.mmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t] + 3 * [ctypes.c_int] + [ctypes.c_long]
system.munmap.argtypes = [ctypes.c_void_p, ctypes.c_size_t]

def mappings():
    for line in open("/proc/self/maps"):
        addresses, rights, *others = line.split()
        first, end = (int(x, 16) for x in addresses.split("-"))
        yield first, end, rights, others[-1]

def is_right(robot, quantity):
    ask = [np.full(robot.nq, 0.5)] * len(fb.kernel(robot, quantity, target="numpy").program.inputs)
    numpy, cpu = (fb.kernel(robot, quantity, target=target)(*ask) for target in ("numpy", "cpu"))
    return np.allclose(numpy, cpu)

robot = fb.load("2R")
is_right(robot, "bias")  # what is imported and taken once
low = system.mmap(None, 5 << 30, 0, FREE, -1, 0)  # all holes of the addresses above are filled
above = [mapping for mapping in mappings() if mapping[0] >= low]
for (_, end, *_), (first, _, _, name) in zip(above, above[1:]):
    if name[0] != "[" and first > end:
        system.mmap(end, first - end, 0, TAKEN, -1, 0)

hole = low + (4 << 30)
def free(pages):
    global hole
    system.munmap(hole, pages * PAGE)
    hole += (pages + 1) * PAGE

free(1)  # for constants, too small for code
print(is_right(robot, "inverse_dynamics"))
for pages in (2, 3, 4):  # for the object beside the kernel's
    free(pages)
print(is_right(fb.load("ur5e"), "inverse_dynamics"))
print(any("x" in rights and low + (4 << 30) <= first < hole for first, _, rights, _ in mappings()))
"""


@pytest.mark.skipif(sys.platform != "linux", reason="asks Linux for addresses")
def test_code_is_right_where_addresses_are_free_only_far_from_each_other():
    """As in a long session that has taken and freed large pieces of memory."""
    assert printed(APART).split() == 3 * ["True"]


MOST = Path("/proc/sys/vm/max_map_count")

IN_PIECES = """
import mmap
import freebody as fb

model = fb.load("2R")
fb.kernel(model, "bias")
pieces = []
try:
    while True:
        pieces.append(mmap.mmap(-1, 1))
except OSError:
    pass
for left in range(100):
    try:
        fb.kernel(model, "inverse_dynamics")
    except fb.OutOfMemoryError as problem:
        print(problem)
        pieces.pop().close()
    else:
        print("compiled")
        break
"""


@pytest.mark.skipif(
    not MOST.exists() or int(MOST.read_text()) > 200_000,
    reason="needs a system that limits the pieces of a process's memory, to not too many",
)
def test_a_kernel_without_pieces_of_memory_is_an_error_and_not_the_end():
    """Code whose pages do not get their rights ends the process when it is called."""
    *refused, done = printed(IN_PIECES).splitlines()
    assert done == "compiled"
    assert 5 < len(refused) < 50
    for words in refused:
        assert re.match(r"LLVM may need \d\d MiB of memory in up to \d+ pieces to compile", words)
        assert "vm.max_map_count" in words


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
