"""Sweeps in Zarr stores: stopped anywhere they go on, and end with the same bytes."""

from __future__ import annotations

import errno
import os
import signal
import subprocess
import sys
import time
from contextlib import nullcontext
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb

zarr = pytest.importorskip("zarr")
xr = pytest.importorskip("xarray")

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
STATES = dict(zip(("q", "qd", "qdd"), fb.random_state(ARM, 3, 90), strict=True))
OVER = {"m2": np.linspace(0.5, 3.0, 4), "l1": np.linspace(0.2, 0.6, 2), "state": STATES}
NAMES = ["max", "rms", "argpeak"]


def swept(store: Path | None, **changed: Any) -> Any:
    given = {"over": OVER, "reduce": NAMES, "block": 40, **changed}
    model, function = given.pop("model", ARM), given.pop("function", "inverse_dynamics")
    return fb.sweep(model, function, store=store, **given)


def same(a: Any, b: Any) -> bool:
    return set(a.data_vars) == set(b.data_vars) and all(
        a[x].values.tobytes() == b[x].values.tobytes() for x in a.data_vars
    )


def content(folder: Path) -> dict[str, bytes]:
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_a_store_holds_what_the_call_returns(tmp_path):
    found = swept(tmp_path / "a.zarr")
    assert same(found, swept(None))
    read = xr.open_zarr(tmp_path / "a.zarr", chunks=None, consolidated=False)
    assert same(read, found)
    assert (read.m2.values == OVER["m2"]).all()
    whole = swept(tmp_path / "b.zarr", reduce=None)
    assert whole.tau.dims == ("point", "state", "coordinate")
    assert whole.tau.values.tobytes() == swept(None, reduce=None).tau.values.tobytes()
    assert whole.l1.values.tolist() == [0.2, 0.6] * 4


def test_failed_points_are_kept_with_their_reasons(tmp_path):
    over = {"m2": [1.0, -1.0], "state": STATES}
    for _ in range(2):
        with pytest.warns(fb.FreebodyWarning, match="mass -1 kg is negative"):
            found = swept(tmp_path / "f", over=over)
        assert found.failed.values.tolist() == [0, 90]


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "changed",
    [
        {"model": ARM.bind(lc2=0.16)},
        {"over": {**OVER, "m2": np.linspace(0.5, 3.1, 4)}},
        {"over": {**OVER, "state": {**STATES, "qd": STATES["qd"] * 2}}},
        {"reduce": ["max", "argpeak"]},
        {"block": 41},
        {"function": lambda model, q, qd, qdd: fb.inverse_dynamics(model, q, qd, qdd)},
    ],
    ids=["model", "number", "states", "reductions", "block", "function"],
)  # fmt: skip
def test_another_sweep_is_refused(tmp_path, changed):
    swept(tmp_path / "s")
    before = content(tmp_path / "s")
    with pytest.raises(fb.FreebodyError, match="another sweep"):
        swept(tmp_path / "s", **changed)
    assert content(tmp_path / "s") == before


def test_the_robot_of_a_function_counts(tmp_path):
    def torque(model: fb.Model, q: Any) -> Any:
        return fb.gravity_torque(model, q)[..., 0]

    for model, refused in ((ARM, False), (ARM.bind(lc2=0.16), True)):
        with pytest.raises(fb.FreebodyError, match="another sweep") if refused else nullcontext():
            fb.sweep(model, torque, over={"q": STATES["q"]}, reduce="max", store=tmp_path / "f")


def test_functions_are_known_again_by_what_they_hold(tmp_path):
    def scaled(by: Any) -> Any:
        return lambda model, q: by * q[..., 0]

    over, store = {"q": STATES["q"]}, tmp_path / "f"
    one = fb.sweep(ARM, scaled(2.0), over=over, reduce="max", store=store)
    assert same(one, fb.sweep(ARM, scaled(2.0), over=over, reduce="max", store=store))
    with pytest.raises(fb.FreebodyError, match="another sweep"):
        fb.sweep(ARM, scaled(3.0), over=over, reduce="max", store=store)

    def holds(model: fb.Model, q: Any, x: Any = THING) -> Any:
        return q

    with pytest.raises(fb.FreebodyError, match="reads a object"):
        fb.sweep(ARM, holds, over={"q": [1.0]}, store=store)


THING = object()


def test_folders_of_others_are_left_alone(tmp_path):
    (tmp_path / "notes.txt").write_text("mine")
    (tmp_path / "file").write_text("mine")
    (tmp_path / "film.partial").write_text("mine")
    for path in (tmp_path, tmp_path / "file"):
        with pytest.raises(fb.FreebodyError, match=r"no store of a sweep\. Name another"):
            swept(path)
    assert (tmp_path / "notes.txt").read_text() == "mine"
    assert (tmp_path / "file").read_text() == "mine"
    assert (tmp_path / "film.partial").exists()


@pytest.mark.sample(1)
@pytest.mark.parametrize("room", [0, 3, 60, -4, -3, -1])
def test_a_full_disk_is_said_and_nothing_is_lost(tmp_path, monkeypatch, room):
    """Before a store is begun, while it is, among its blocks, and while the result is put there."""
    local = zarr.storage._local
    real, left = local._put, [10**9]

    def full(*arguments: Any, **options: Any) -> Any:
        left[0] -= 1
        if left[0] < 0:
            raise OSError(errno.ENOSPC, "No space left on device")
        return real(*arguments, **options)

    monkeypatch.setattr(local, "_put", full)
    swept(tmp_path / "whole")
    left[0] = room if room >= 0 else 10**9 - left[0] + room
    with pytest.raises(fb.FreebodyError, match=r"disk is full\. What is done is kept"):
        swept(tmp_path / "s")
    left[0] = 10**9
    swept(tmp_path / "s")
    assert content(tmp_path / "s") == content(tmp_path / "whole")


SCRIPT = """
import os, sys, time
import numpy as np
import freebody as fb
from freebody.sweeps.evaluation import SweepTask
arm = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
log = os.open(sys.argv[2], os.O_WRONLY | os.O_APPEND | os.O_CREAT)
real = SweepTask.__call__
def told(self, block, *rest):
    os.write(log, f"{block.rows} {block.columns}\\n".encode())
    return real(self, block, *rest)
SweepTask.__call__ = told
def slow(model, q):
    time.sleep(0.01)
    return fb.gravity_torque(model, q)
function, size, over = {
    "python": (slow, 20, {"m2": np.linspace(0.5, 3.0, 6), "q": fb.random_state(arm, 3, 400)[0]}),
    "kernel": ("gravity_torque", 40_000, {
        "m2": np.linspace(0.5, 3.0, 60), "q": fb.random_state(arm, 3, 400_000)[0],
    }),
}[sys.argv[3]]
print("begun", flush=True)
fb.sweep(arm, function, over=over, reduce=["max", "mean"], block=size, store=sys.argv[1])
"""


@pytest.mark.long
@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
@pytest.mark.parametrize("function", ["python", "kernel"])
def test_killed_at_random_it_ends_with_the_same_bytes(tmp_path, function):
    """And each kill costs at most one block."""
    script, log = tmp_path / "script.py", tmp_path / "log"
    script.write_text(SCRIPT)
    environment = {**os.environ, "PYTHONPATH": str(Path(fb.__file__).parents[1])}
    rng = np.random.default_rng()

    def started(store: str, killed_after: float | None = None) -> bool:
        """Whether it was killed on the way."""
        command = [sys.executable, str(script), str(tmp_path / store), str(log), function]
        with subprocess.Popen(command, env=environment, stdout=subprocess.PIPE) as process:
            assert process.stdout is not None
            process.stdout.readline()
            if killed_after is not None:
                time.sleep(killed_after)
                process.send_signal(signal.SIGKILL)
            return process.wait() != 0

    assert not started("whole")
    every = log.read_text().splitlines()
    log.unlink()
    kills = sum([started("killed", rng.uniform(0.3, 1.2)) for _ in range(3)])
    assert not started("killed")
    assert content(tmp_path / "killed") == content(tmp_path / "whole")
    begun = log.read_text().splitlines()
    assert set(begun) == set(every)
    assert len(begun) - len(every) <= kills
    assert kills
