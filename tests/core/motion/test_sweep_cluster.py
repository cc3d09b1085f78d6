"""Sweeps on a Dask cluster of processes: the bytes of this process, also where one is killed."""

from __future__ import annotations

import os
import signal
import sys
import threading
from typing import Any

import numpy as np
import pytest

import freebody as fb

distributed = pytest.importorskip("distributed")

pytestmark = [pytest.mark.long, pytest.mark.filterwarnings("ignore")]

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.0], I=[0.03, 0.01])
STATES = dict(zip(("q", "qd", "qdd"), fb.random_state(ARM, 3, 4000), strict=True))
OVER = {"m2": np.linspace(0.5, 3.0, 8), "state": STATES}


def same(a: Any, b: Any) -> bool:
    return all(a[x].values.tobytes() == b[x].values.tobytes() for x in a.data_vars)


@pytest.mark.skipif(sys.platform == "win32", reason="no SIGKILL")
def test_a_cluster_gives_the_same_bytes_also_where_a_worker_is_killed(tmp_path):
    log = str(tmp_path / "log")

    def slow(model: fb.Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> Any:
        import time

        with open(log, "a") as file:
            file.write(".")
        time.sleep(0.6)
        return fb.inverse_dynamics(model, q, qd, qdd)

    with (
        distributed.LocalCluster(2, threads_per_worker=1, dashboard_address=None) as cluster,
        distributed.Client(cluster) as client,
    ):
        for function, names in (("inverse_dynamics", ["max", "mean", "p90"]), (slow, ["mean"])):
            given = {"over": OVER, "reduce": names, "block": 1000}
            here = fb.sweep(ARM, function, **given)
            if function is slow:
                pid, _ = (x.process.pid for x in cluster.workers.values())
                once = os.path.getsize(log)
                threading.Timer(5.0, os.kill, (pid, signal.SIGKILL)).start()
            there = fb.sweep(ARM, function, **given, client=client)
            assert same(there, here)
        assert os.path.getsize(log) - once <= once + 1  # the block that it had under way
        assert pid not in [x.process.pid for x in cluster.workers.values()]
        stored = fb.sweep(
            ARM, "inverse_dynamics", over=OVER, reduce="max", block=1000,
            client=cluster.scheduler_address, store=tmp_path / "s",
        )  # fmt: skip
        assert same(stored, fb.sweep(ARM, "inverse_dynamics", over=OVER, reduce="max", block=1000))


def test_what_is_no_cluster_is_refused():
    with pytest.raises(fb.FreebodyError, match=r"takes a distributed\.Client"):
        fb.sweep(ARM, "inverse_dynamics", over=OVER, client=3)
