"""Machine code goes when nothing can call it any more, and not before.

How many kernels are kept is said by the compiler, and is emptied there; its library is held against
memory by itself.
"""

from __future__ import annotations

import gc
import os
import subprocess
import sys
import threading
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.math import sin
from freebody.targets.kernel import RECENT
from freebody.targets.llvm.lanes import DOUBLE
from freebody.targets.llvm.machine import object_code

SRC = Path(fb.__file__).parents[1]
MAPS = Path("/proc/self/maps")
ON_LINUX = pytest.mark.skipif(not MAPS.exists(), reason="memory is looked at as Linux shows it")


@pytest.fixture(autouse=True)
def stored(tmp_path_factory, monkeypatch):
    """A folder of compiled code: what was freed is loaded again, which is quicker than
    compiling."""
    monkeypatch.setenv("FREEBODY_CACHE", str(tmp_path_factory.getbasetemp() / "stored"))


DIFFERENT = 48
"""Programs, each compiled once: more than are kept for the next who asks."""


def kernel(number: int, target: str | None = None) -> Any:
    """x -> x² + number."""
    plus = float(number % DIFFERENT)
    return fb.compile(lambda x: [x[0] * x[0] + plus], {"x": 1}, {"y": 1}, target=target)


def value(number: int) -> float:
    return 0.25 + number % DIFFERENT


X = np.array([0.5])


def forget() -> None:
    """Have as many other kernels asked for as are kept for the next who asks."""
    for k in range(RECENT + 1):
        kernel(k, target="numpy")
    gc.collect()


def mappings() -> int:
    return MAPS.read_text().count("\n")


def resident() -> int:
    """Bytes."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * os.sysconf("SC_PAGESIZE")


def use_and_drop(first: int, count: int, problems: list[str]) -> None:
    """Compile, call in all ways, and drop; the last references end in whatever thread comes
    last."""
    for number in range(first, first + count):
        one = kernel(number)
        helpers = [threading.Thread(target=lambda one=one: one(X)) for _ in range(number % 8 == 0)]
        for helper in helpers:
            helper.start()
        batch = np.full((40, 1), 0.5)
        for found in (one(X), one.quick_checked(one)(X), one.ufunc(X), one(batch, threads=2)[3]):
            if found[0] != value(number):
                problems.append(f"{number}: {found}")


def in_threads(first: int, count: int, threads: int = 2) -> list[str]:
    problems: list[str] = []
    workers = [
        threading.Thread(target=use_and_drop, args=(first + k * count, count, problems))
        for k in range(threads)
    ]
    for worker in workers:
        worker.start()
    for worker in workers:
        worker.join()
    return problems


@ON_LINUX
def test_code_of_kernels_that_are_dropped_is_freed():
    assert in_threads(0, 20) == []
    forget()
    before = mappings()
    assert in_threads(0, 100) == []
    forget()
    assert mappings() < before + 100  # each kernel that is there takes three, and threads a few


@ON_LINUX
@pytest.mark.long
def test_ten_thousand_kernels_come_and_go():
    assert in_threads(0, 100) == []
    forget()
    before, filled = mappings(), resident()
    assert in_threads(0, 5000) == []
    forget()
    assert mappings() < before + 20
    assert resident() < filled + 10 * 2**20  # 1 kB each, of which the allocator's own gaps are most


@pytest.mark.sample(1)
@ON_LINUX
@pytest.mark.parametrize(
    "way",
    [
        lambda k: k.ufunc,
        lambda k: k.__call__,
        lambda k: k.quick(len),
        lambda k: k.quick_checked(len),
    ],
)
def test_whoever_can_call_the_code_keeps_it(way):
    forget()
    before = mappings()
    held = [way(kernel(k)) for k in range(20)]
    forget()
    assert mappings() > before + 20
    for k, call in enumerate(held):
        assert call(X)[0] == value(k)
    del held, call
    forget()
    assert mappings() < before + 20


def test_a_kernel_is_the_same_while_it_is_held_and_the_last_ones_are_kept():
    held = kernel(3)
    forget()
    assert kernel(3) is held
    ufunc = kernel(4).ufunc
    assert kernel(4).ufunc is ufunc  # nobody had it, but it was asked for just now


def test_a_call_that_is_running_keeps_its_code():
    def slow(x):
        return [sum((sin(x[0] + k) for k in range(40)), start=0.0)]

    x = np.linspace(0.0, 1.0, 400_000)[:, None]
    kernels, results = [fb.compile(slow, {"x": 1}, {"y": 1})], []
    expected = kernels[0](x)
    started = threading.Event()

    def call() -> None:
        ufunc = kernels[0].ufunc
        started.set()
        results.append(ufunc(x))

    caller = threading.Thread(target=call)
    caller.start()
    started.wait()
    kernels.clear()
    forget()
    caller.join()
    assert np.array_equal(results[0], expected)


def run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    env = {
        **os.environ,
        "PYTHONPATH": str(SRC),
        "PYTHONMALLOC": "malloc",
        "MALLOC_PERTURB_": "165",
        **environment,
    }
    return subprocess.run(
        [sys.executable, "-W", "ignore::DeprecationWarning", "-c", code],
        env=env,
        capture_output=True,
        text=True,
        timeout=120,
        check=False,
    )


MAKE = """
import os, sys, gc, threading
import numpy as np
import freebody as fb
def kernel(number):
    return fb.compile(lambda x: [x[0] * x[0] + number], {"x": 1}, {"y": 1})
x = np.array([0.5])
held = [kernel(float(k)) for k in range(12)]
"""

GARBAGE = """
class Owner:
    def __init__(self, kernel, number):
        self.kernel, self.number, self.itself = kernel, number, self
    def __del__(self):
        said.append(self.kernel(x)[0] == self.kernel.ufunc(x)[0] == 0.25 + self.number)
said = []
for k in range(len(held)):
    Owner(held.pop(0), k)  # older than its owner, so that the collector sees it sooner
from freebody.targets import kernel as kernels
kernels._recent.clear()
gc.collect()
assert said == [True] * 12, said
"""


def test_garbage_whose_finalizers_call_a_kernel():
    """The collector runs the finalizers of all garbage before it frees any."""
    done = run(MAKE + GARBAGE)
    assert (done.returncode, done.stderr) == (0, "")


ENDS = {
    "while a thread is inside": """
big = np.zeros((2_000_000, 1))
def work():
    ufunc = held[3].ufunc
    while True:
        ufunc(big)
for _ in range(2):
    threading.Thread(target=work, daemon=True).start()
""",
    "in a cycle": """
class Owner: pass
owner = Owner()
owner.itself, owner.kernels = owner, held
""",
    "in a finalizer": """
class Owner:
    def __del__(self):
        assert self.kernel(x)[0] == 7.25
owner = Owner()
owner.kernel = held[7]
sys.keep = owner  # of all modules, this one goes last
""",
}


@pytest.mark.sample(1)
@pytest.mark.parametrize("how", ENDS)
def test_the_interpreter_ends_in_peace(how):
    done = run(MAKE + ENDS[how])
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_forked_child_uses_what_it_found_drops_it_and_compiles_its_own():
    done = run(
        MAKE
        + """
child = os.fork()
if child == 0:
    good = held[5](x)[0] == held[5].ufunc(x)[0]
    held.clear()
    held.extend(kernel(11.0 - k) for k in range(13))
    gc.collect()
    good &= held[-1](x)[0] == -0.75 and held[0](x)[0] == 11.25
    held.clear()
    os._exit(0 if good else 1)
assert os.waitpid(child, 0)[1] == 0
assert held[5](x)[0] == 5.25
"""
    )
    assert (done.returncode, done.stderr) == (0, "")


@ON_LINUX
def test_a_texts_numbers_do_not_stay_in_llvm():
    """LLVM keeps all numbers that it ever read in a context: 120 programs of 800 numbers each took
    31 MB."""

    def compile_numbers(first: int) -> None:
        numbers = ", ".join(
            f"double {DOUBLE.constant(first + k / 10_001.0)}" for k in range(10_000)
        )
        object_code(f"@numbers = constant [10000 x double] [{numbers}]")

    for k in range(3):
        compile_numbers(k)
    before = resident()
    for k in range(10):
        compile_numbers(10 + k)
    assert resident() < before + 4 * 2**20
