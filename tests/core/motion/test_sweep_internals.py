"""Sweeps where a result does not show what was done: how blocks are cut and shared among
processors, what is evaluated once only, by what a function is known again.

No argument chooses these, so they are set and watched where they are.
"""

from __future__ import annotations

import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody.kernels import lookup
from freebody.sweeps import run, samples
from freebody.sweeps.evaluation import SweepTask
from freebody.sweeps.identity import fingerprint

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
STATES = dict(zip(("q", "qd", "qdd"), fb.random_state(ARM, 3, 90), strict=True))
OVER = {"m2": np.linspace(0.5, 3.0, 4), "l1": np.linspace(0.2, 0.6, 2), "state": STATES}
NAMES = ["max", "rms", "argpeak"]


def swept(store: Path | None, **changed: Any) -> Any:
    given = {"over": OVER, "reduce": NAMES, "block": 40, **changed}
    model, function = given.pop("model", ARM), given.pop("function", "inverse_dynamics")
    return fb.sweep(model, function, store=store, **given)


def content(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_bytes_depend_on_the_sweep_alone(monkeypatch):
    """Not on threads, nor, but for sums, on how the table is cut."""
    names = ["max", "argpeak", "p90", "mean"]
    whole = fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce=names, block=100)
    for threads in (1, 5):
        monkeypatch.setattr(run, "cpus", lambda n=threads: n)
        again = fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce=names, block=100)
        assert all((whole[x].values == again[x].values).all() for x in whole.data_vars)
    for size in (1, 7, 10**6):
        cut = fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce=names, block=size)
        assert np.allclose(cut.tau_mean, whole.tau_mean, rtol=1e-12)
        assert all((cut[x] == whole[x]).all() for x in whole.data_vars if x != "tau_mean")


def test_one_kernel_serves_all_robots(monkeypatch):
    made = []
    compiled = lookup.compile_program
    monkeypatch.setattr(
        lookup, "compile_program", lambda *a, **k: made.append(1) or compiled(*a, **k)
    )
    arm = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.02])
    fb.sweep(arm, "inverse_dynamics", over=OVER, reduce="max")
    assert len(made) == 1


@pytest.mark.parametrize("method", ["sobol", "random"])
def test_samples_follow_from_the_seed_and_their_place_alone(method, monkeypatch):
    """Any of any number of them, and a sweep reads those of its block."""
    monkeypatch.setattr(samples, "_RUN", 64)
    ranges = {"m2": (1.0, 3.0), "q": (np.array([-1.0, 0.0]), np.array([1.0, 0.5]))}
    held = fb.samples(300, ranges, method=method, seed=4)
    whole = dict(held)
    monkeypatch.setattr(samples, "_HELD", 0)
    found = fb.samples(10**12, ranges, method=method, seed=4)
    for places in (slice(0, 5), slice(60, 200), np.array([[299, 3], [64, 130]])):
        for name, values in found.at(places).items():
            assert (values == whole[name][places]).all()
    assert not (found.at(slice(0, 64))["m2"] == found.at(slice(64, 128))["m2"]).any()
    last = found.at(slice(10**12 - 3, 10**12))["q"]
    assert last.shape == (3, 2)
    over = {"s": fb.samples(300, ranges, method=method, seed=4), "l1": [0.2, 0.3]}
    for along in (["s"], ["l1"], ["s", "l1"]):
        given = {"reduce": ["max", "argmax"], "along": along}
        a, b = (
            fb.sweep(ARM, "gravity_torque", over={**over, "s": x}, block=100, **given)
            for x in (over["s"], whole)
        )
        assert a.equals(b)


@pytest.mark.sample(1)
@pytest.mark.parametrize("reduce", [NAMES, None])
def test_what_was_stopped_goes_on(tmp_path, monkeypatch, reduce):
    """At several places; what is done is not done again, nor is more than one block under way, on
    however many processors."""
    pytest.importorskip("zarr")
    swept(tmp_path / "whole.zarr", reduce=reduce)
    evaluated = []
    real = SweepTask.__call__
    monkeypatch.setattr(SweepTask, "__call__", lambda *a: evaluated.append(a[1]) or real(*a))
    monkeypatch.setattr(run, "cpus", lambda: 4)

    for stop in (0.1, 0.3, 0.9):

        def stopping(told: str, share: float, stop: float = stop) -> None:
            assert re.fullmatch(r"\d+ of 720 points, \S+ per second, \d+ s left", told)
            if share >= stop:
                raise KeyboardInterrupt

        with pytest.raises(KeyboardInterrupt):
            swept(tmp_path / "again.zarr", reduce=reduce, progress=stopping)
    swept(tmp_path / "again.zarr", reduce=reduce)
    assert content(tmp_path / "again.zarr") == content(tmp_path / "whole.zarr")
    assert len(evaluated) == len(set(evaluated)) == 24


def test_a_block_of_zeros_is_done(tmp_path, monkeypatch):
    pytest.importorskip("zarr")
    over = {"q": np.zeros((8, 2))}
    nothing = fb.compile(lambda q: 0.0 * q[0], {"q": (2,)}, {"x": ()})
    fb.sweep(ARM, nothing, over=over, block=2, store=tmp_path / "z")
    monkeypatch.setattr(SweepTask, "__call__", lambda *a: pytest.fail("evaluated again"))
    found = fb.sweep(ARM, nothing, over=over, block=2, store=tmp_path / "z")
    assert (found.x.values == 0.0).all()


GAIN, TABLE = 2.0, {"a": np.ones(2)}


def gained(model: fb.Model, q: Any) -> Any:
    return helped(q) * TABLE["a"][0] * np.sin(q).shape[0] ** 0


def helped(q: Any) -> Any:
    return (lambda x: GAIN * x)(q) if "q" in {"q", "p", "r"} else helped(q)


def digest(parts: list[Any]) -> str:
    return hashlib.sha256(repr(parts).encode()).hexdigest()


def test_functions_are_known_again_by_the_globals_that_they_read(monkeypatch):
    """Also those of functions that they call; in another process the same."""
    first = fingerprint(gained)
    script = "import test_sweep_internals as t; print(t.digest(t.fingerprint(t.gained)))"
    here = Path(__file__)
    folders = (here.parent, here.parents[2], Path(fb.__file__).parents[1])
    paths = os.pathsep.join(map(str, folders))
    environment = {**os.environ, "PYTHONPATH": paths, "PYTHONHASHSEED": "1"}
    printed = subprocess.run(
        [sys.executable, "-c", script], env=environment, capture_output=True, text=True
    )
    assert printed.stdout.strip() == digest(first), printed.stderr
    for name, value in (("GAIN", 3.0), ("TABLE", {"a": np.zeros(2)}), ("helped", lambda q: q)):
        with monkeypatch.context() as patched:
            patched.setattr(sys.modules[__name__], name, value)
            assert fingerprint(gained) != first
    assert fingerprint(gained) == first
