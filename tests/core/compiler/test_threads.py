"""Batches in parts on several threads, several callers, forked children."""

from __future__ import annotations

import os
import subprocess
import sys
import threading
import time
import weakref
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from support.child_process import environment
from support.programs import random_kernel, same_bits, samples, swap_kernel

pytestmark = pytest.mark.usefixtures("memory_only")


@pytest.mark.parametrize("threads", [1, 2, 3, 7, None])
def test_threads_change_nothing(threads):
    compiled = random_kernel(5)
    arrays = samples(1001, 9)
    whole = compiled.ufunc(*arrays)
    assert same_bits(compiled(*arrays, threads=threads), whole)
    outs = tuple(np.zeros_like(w) for w in whole)
    returned = compiled(*arrays, out=outs, threads=threads)
    assert all(r is o for r, o in zip(returned, outs, strict=True))
    assert same_bits(outs, whole)
    x, A, s = arrays
    mixed = x[None, :7], A[:300, None], s[0]
    assert same_bits(compiled(*mixed, threads=threads), compiled.ufunc(*mixed))
    single = tuple(a[0] for a in arrays)
    assert same_bits(compiled(*single, threads=threads), compiled.ufunc(*single))


def test_threads_with_out_over_input():
    compiled = swap_kernel()
    q = np.random.default_rng(0).normal(size=(1000, 3))
    expected = compiled(q)
    compiled(q, out=q, threads=4)
    np.testing.assert_array_equal(q, expected)


def test_several_callers_at_once_and_nothing_is_kept():
    compiled = random_kernel(5)
    arrays = samples(3001, 9)
    whole = compiled.ufunc(*arrays)

    def agrees(_):
        return all(same_bits(compiled(*arrays, threads=3), whole) for _ in range(50))

    with ThreadPoolExecutor(4) as pool:
        assert all(pool.map(agrees, range(4)))
    q = np.ones((1000, 3))
    kept = weakref.ref(q)
    swap_kernel()(q, threads=2)
    del q
    deadline = time.monotonic() + 10.0  # a helper lets go when its thread comes to it
    while kept() is not None:
        assert time.monotonic() < deadline
        time.sleep(0.001)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
def test_threads_work_in_a_forked_child():
    code = """
import os, numpy as np, warnings
warnings.simplefilter("ignore", DeprecationWarning)  # fork beside threads is what is tested
import freebody as fb
k = fb.compile(lambda q: [2.0 * q[0]], {"q": 1}, {"r": 1})
q = np.ones((5000, 1))
k(q, threads=4)
child = os.fork()
if child == 0:
    os._exit(0 if (k(q, threads=4) == 2.0).all() else 1)
assert os.waitpid(child, 0)[1] == 0
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


@pytest.mark.skipif(not hasattr(os, "fork"), reason="there is no fork")
def test_a_child_forked_during_a_compilation_can_compile():
    code = """
import os, sys, threading, warnings
import numpy as np
warnings.simplefilter("ignore", DeprecationWarning)  # fork beside threads is what is tested
import freebody as fb
def made(n):
    def function(q):
        x = q[0]
        for _ in range(n):
            x = x * q[0] + 1.0
        return [x]
    return fb.compile(function, {"q": 1}, {"r": 1})
# imported before: a child forked while another thread imports would wait for that import for ever
fb.compile
work = threading.Thread(target=lambda: [made(n) for n in range(300, 330)])
work.start()
while work.is_alive():
    child = os.fork()
    if child == 0:
        os._exit(0 if made(2)(np.ones((1, 1))) == 3.0 else 1)
    assert os.waitpid(child, 0)[1] == 0
work.join()
"""
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


def test_the_gil_is_released():
    compiled = random_kernel(0, 4000)
    arrays = samples(100_000)
    ticks, stop = [], threading.Event()

    def tick():
        while not stop.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.0005)

    thread = threading.Thread(target=tick)
    thread.start()
    try:
        while not ticks:
            time.sleep(0.001)
        before = time.perf_counter()
        compiled.ufunc(*arrays)
        after = time.perf_counter()
    finally:
        stop.set()
        thread.join()
    assert sum(before < t < after for t in ticks) > 2, (after - before, len(ticks))
