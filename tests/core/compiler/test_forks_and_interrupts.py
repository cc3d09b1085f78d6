"""A process that forks, or is stopped by Ctrl-C, in the middle of the work of another thread or of
a long call; how batches are cut into parts.

Where a fork or an interrupt hits, and how a batch is cut, is not to be seen from outside: locks and
loops are watched where they are, and told of a machine of four CPUs.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

import freebody as fb
from freebody.program import Argument, trace
from freebody.targets import Kernel, compile_program, kernel
from freebody.targets.threads import run_split
from support.programs import swap_kernel
from support.sources import SOURCES, SRC
from support.sources import place as place_of


def run(code: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code],
        timeout=60,
        env={**os.environ, "PYTHONPATH": str(SRC), **environment},
        capture_output=True,
        text=True,
    )


FORK_DURING_A_TRACE = """
import os, signal, threading, time, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # fork beside threads is what is tested
import numpy as np
import freebody as fb
from freebody.targets.kernel import Kernel
from freebody.model import model as models, tree
from freebody.kernels import lookup
small, large = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1]), fb.load("ur5e")
inside, go_on, lower = threading.Event(), threading.Event(), models.lower
def slow(model, values):  # what a large robot takes seconds for
    if model.name == "ur5e":
        inside.set()
        go_on.wait(20)
    return lower(model, values)
models.lower = slow
tracing = threading.Thread(target=lambda: large.tree)
tracing.start()
inside.wait(20)
child = os.fork()
if child == 0:
    signal.alarm(5)  # a child that waits for ever ends by this
    os._exit(0 if fb.mass_matrix(small, np.zeros(2)).shape == (2, 2) else 1)
status = os.waitpid(child, 0)[1]
go_on.set()
tracing.join()
assert status == 0, status
"""


@pytest.mark.sample(1)
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.parametrize("target", ["cpu", "numpy"])
def test_a_child_forked_while_another_thread_traces_goes_on(target):
    done = run(FORK_DURING_A_TRACE, FREEBODY_TARGET=target)
    assert done.returncode == 0, done.stderr


FORK_DURING_AN_IMPORT = """
import os, signal, sys, threading, time, warnings
warnings.simplefilter("ignore", DeprecationWarning)
from importlib.machinery import SourceFileLoader
import freebody as fb
inside = threading.Event()
stage = SourceFileLoader.{stage}
def slowly(self, of):  # a specification, later the module
    if getattr(of, "__spec__", of).name == "{slow}":
        inside.set()
        time.sleep(0.5)
    return stage(self, of)
SourceFileLoader.{stage} = slowly
def first_use():
    {use}
using = threading.Thread(target=first_use)
using.start()
assert inside.wait(20)
child = os.fork()
if child == 0:
    signal.alarm(5)  # a child that waits for ever ends by this
    {use}
    os._exit(0 if callable(fb.compile) else 1)
status = os.waitpid(child, 0)[1]
using.join()
assert status == 0, status
"""


@pytest.mark.sample(1)
@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
@pytest.mark.parametrize(
    ("use", "slow", "stage"),
    [
        (
            "fb.compile",
            "freebody.kernels.own_functions",
            "create_module",
        ),  # not among the modules yet
        ("fb.math.sin", "freebody.scalar_math", "create_module"),
        ("fb.compile", "freebody.targets.threads", "exec_module"),
        ("import freebody.kernels.own_functions", "freebody.targets.threads", "exec_module"),
        ("import freebody_notes.item", "freebody_notes.item", "exec_module"),
    ],
)
def test_a_child_forked_while_another_thread_imports_goes_on(use, slow, stage):
    done = run(FORK_DURING_AN_IMPORT.format(use=use, slow=slow, stage=stage))
    assert done.returncode == 0, done.stderr
    assert not done.stderr


FORK_BEFORE_A_LOG = """
import os, signal, sys, threading, time, warnings
warnings.simplefilter("ignore", DeprecationWarning)
from freebody import locks
import logging
inside = threading.Event()
def log_while_building():
    with locks.KERNELS:
        inside.set()
        time.sleep(0.3)
        logging.getLogger("never asked before").info("a line")
building = threading.Thread(target=log_while_building, daemon=True)
building.start()
assert inside.wait(20)
signal.alarm(10)  # who waits for ever ends by this
child = os.fork()
if child == 0:
    with locks.KERNELS:
        os._exit(0)
assert os.waitpid(child, 0)[1] == 0
"""


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_fork_waits_for_a_thread_that_logs_while_it_builds():
    done = run(FORK_BEFORE_A_LOG)
    assert done.returncode == 0, done.stderr
    assert not done.stderr


HANDLER_THAT_COMPILES = """
import os, signal, threading
import freebody as fb
import llvmlite.binding as llvm
from freebody.targets import kernel
stopped = threading.Timer(20, os._exit, [7])  # who waits for ever ends by this
stopped.daemon = True
stopped.start()
numbers, made = iter(range(2, 9)), []
def scaled():
    by = next(numbers)
    scale = fb.compile(lambda x: [by * x[0]], {{"x": 1}}, {{"y": 1}})
    made.append((by, scale([[1.0]] * 5000, threads=by)[-1, 0]))
signal.signal(signal.SIGINT, lambda *_: scaled())
scaled()
before = {place}
def interrupted(*given):
    {place} = before
    signal.raise_signal(signal.SIGINT)
    return before(*given)
{place} = interrupted
scaled()
scaled()
assert [y for _, y in made] == [by for by, _ in made] and len(made) == 4, made
"""


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "place", ["kernel.verify", "llvm.parse_assembly", "threading.Thread.start"]
)
def test_a_handler_of_a_signal_may_ask_for_a_kernel_while_one_is_compiled(place):
    done = run(HANDLER_THAT_COMPILES.format(place=place), FREEBODY_CACHE="off")
    assert done.returncode == 0, done.stderr


def test_nothing_in_freebody_holds_a_lock_that_a_fork_would_leave_taken():
    """`functools.cached_property` holds one for all instances before Python 3.12."""
    users = [
        place_of(path)
        for path in SOURCES
        if any(
            "functools" in line and "cached_property" in line and "import" in line
            for line in path.read_text(encoding="utf-8").splitlines()
        )
    ]
    assert users == []


def double() -> Kernel:
    program = trace(
        "double", lambda q: ([2.0 * q[0]],), [Argument("q", (1,))], [Argument("r", (1,))]
    )
    return Kernel(program, "cpu", 2, compile_program(program).ufunc)


@pytest.mark.parametrize("threads", [1, 4])
@pytest.mark.parametrize("shape", [(4_000,), (4, 1000), (2,) * 12, (1, 4000, 1)])
def test_an_interrupt_stops_a_long_call_after_the_part_that_is_being_computed(
    monkeypatch, threads, shape
):
    """Ctrl-C in the third of many parts: of those that nobody has begun, none is computed."""
    long, calls = double(), []
    before = signal.signal(
        signal.SIGINT, signal.default_int_handler
    )  # a shell's job in the background ignores it
    monkeypatch.setattr(long, "_longest", 16)
    monkeypatch.setattr(long, "few", 8)
    computed = long.ufunc

    def stopped(*arrays, out):
        calls.append(arrays[0].size)
        if len(calls) == 3:
            os.kill(os.getpid(), signal.SIGINT)
            time.sleep(0.01)  # the main thread may be another
        return computed(*arrays, out=out)

    monkeypatch.setattr(long, "ufunc", stopped)
    try:
        with pytest.raises(KeyboardInterrupt):
            long(np.ones((*shape, 1)), threads=threads)
    finally:
        signal.signal(signal.SIGINT, before)
    assert max(calls) <= 16
    assert len(calls) < 100  # of 250


def test_a_part_takes_milliseconds():
    """Of the dearest quantities, and of those that do little but move numbers; counted in
    operations and entries."""
    arm = fb.load("ur5e")
    for name in ("potential_energy", "forward_kinematics", "inverse_dynamics_second_derivatives"):
        long = fb.kernel(arm, name, target="cpu")
        entries = long.program.input_size + long.program.output_size
        assert 0.1 * kernel._SLICE < long._longest * long._cost <= kernel._SLICE
        assert long._longest * entries <= 5e7


@pytest.mark.parametrize("threads", [1, 3])
@pytest.mark.parametrize("shape", [(1001,), (7, 143), (143, 7), (3, 1, 5, 67), (2,) * 10])
def test_parts_give_the_bits_of_the_whole(monkeypatch, threads, shape):
    arm = fb.load("ur5e")
    whole = fb.kernel(arm, ["inverse_dynamics", "mass_matrix"])
    parts = Kernel(whole.program, whole.target, whole.width, whole.ufunc)
    monkeypatch.setattr(parts, "_longest", 50)
    monkeypatch.setattr(parts, "few", 8)
    q, qd, qdd = fb.random_state(arm, 1, shape)
    one = qd[(0,) * len(shape)]
    for given in (
        (q, qd, qdd),
        (q, one, qdd),
        (q[:1], qd, qdd[..., :1, :]),
        (q.astype(np.float32), qd, qdd),
    ):
        expected = whole.ufunc(*given)
        outs = tuple(np.full_like(x, np.nan) for x in expected)
        for found in (parts(*given, threads=threads), parts(*given, threads=threads, out=outs)):
            for x, y in zip(found, expected, strict=True):
                assert x.tobytes() == y.tobytes()


def test_output_over_input_part_by_part(monkeypatch):
    """A part that is written must not be what a later part reads."""
    parts = double()
    monkeypatch.setattr(parts, "_longest", 16)
    monkeypatch.setattr(parts, "few", 8)
    buffer = np.arange(1100.0)[:, None]
    expected = 2.0 * buffer[:1000]
    parts(buffer[:1000], out=buffer[37:1037])
    np.testing.assert_array_equal(buffer[37:1037], expected)


def test_memory_of_results_that_are_gone_is_used_again_and_of_those_that_are_there_never():
    arm = fb.load("ur5e")
    torque = fb.kernel(arm, "inverse_dynamics")
    q, qd, qdd = fb.random_state(arm, 1, 30_000)
    first = torque(q, qd, qdd)
    view, expected = first[5:, 2:4], first.copy()
    addresses = {torque(q, qd, qdd, threads=1).ctypes.data for _ in range(10)}
    assert len(addresses) <= 2
    assert first.ctypes.data not in addresses
    del first
    second = torque(qd, q, qdd)
    np.testing.assert_array_equal(view, expected[5:, 2:4])  # a view keeps the memory
    assert not np.may_share_memory(view, second)
    assert second.flags.writeable
    assert second.flags.c_contiguous


def test_threads_that_ask_for_memory_at_once_get_different_pieces():
    from freebody.targets import result_memory

    def is_its_own(value: float) -> bool:
        for _ in range(300):
            piece = result_memory.empty((3_000_000,))
            piece[::500_000] = value
            time.sleep(0)
            if (piece[::500_000] != value).any():
                return False
        return True

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(is_its_own, range(4)))
    assert (
        sum(size * len(pieces) for size, pieces in result_memory._kept.items())
        <= result_memory.LIMIT
    )


def test_large_batches_are_shared_by_default(monkeypatch):
    parts = []
    compiled = swap_kernel()
    monkeypatch.setattr(kernel, "run_split", lambda *a: parts.append(a[-2]))
    monkeypatch.setattr(kernel, "cpus", lambda: 4)
    compiled(np.ones((100, 3)))
    assert parts == []
    compiled(np.zeros((20_000_000 // 3, 3)))
    assert parts == [3]


@pytest.mark.parametrize("count", [1, 15, 16, 17, 100, 1001, 100_000])
@pytest.mark.parametrize("threads", [1, 2, 5])
def test_every_sample_is_in_one_part(count, threads):
    hits, parts = np.zeros((count, 1)), []

    def ufunc(x, out):
        parts.append(len(x))
        out[0][:] += x

    run_split(ufunc, [np.ones((count, 1))], [hits], [1, 1], (count,), threads)
    assert (hits == 1.0).all()
    assert sum(parts) == count
    assert len(parts) <= 3 * threads


@pytest.mark.parametrize("error", [ZeroDivisionError, KeyboardInterrupt])
@pytest.mark.parametrize("where", [0, 500, 999])
def test_what_a_part_raises_is_raised_when_all_are_done(error, where):
    finished = np.zeros(1000, dtype=bool)

    def ufunc(x, out):
        time.sleep(0.01)
        if where in x:
            raise error
        finished[x.astype(int)] = True

    x = np.arange(1000.0)
    for _ in range(2):  # the helpers are there afterwards
        with pytest.raises(error):
            run_split(ufunc, [x], [x.copy()], [0, 0], (1000,), 2)
    assert finished.sum() < 1000
    assert finished.any() or error is KeyboardInterrupt  # what nobody has begun is dropped
