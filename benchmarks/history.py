"""Benchmarks over time: a dated row of benchmarks/history.csv, with the processor and the versions
that it was measured with.

    python benchmarks/history.py            measures, and prints the row
    python benchmarks/history.py --keep     and appends it to the table

It takes less than a minute. Nanoseconds of CPU time a state of a UR5e's kernels in batches of 4096
on one thread, the least of rounds that take turns, and of one call; how many times as long
Pinocchio takes for the same inverse dynamics in the same rounds, which compares rows of different
machines; and seconds to compile the inverse dynamics where nothing is cached. Rows of one processor
can be compared with each other. `load` is the number of processes that wanted the processor when
the script began: what else the machine does slows caches and clocks, even in CPU time.
"""

import argparse
import csv
import datetime
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from importlib.metadata import version
from pathlib import Path

import numpy as np
import pinocchio as pin

import freebody as fb
from common import processor, seconds

TABLE = Path(__file__).with_name("history.csv")
QUANTITIES = {
    "inverse_dynamics": ("q", "qd", "qdd"),
    "forward_dynamics": ("q", "qd", "tau"),
    "mass_matrix": ("q",),
    "inverse_dynamics_derivatives": ("q", "qd", "qdd"),
}
BATCH, ROUNDS, ONE_CALLS = 4096, 15, 20_000
COMPILED = """
import time
import freebody as fb

arm = fb.load("ur5e")
start = time.perf_counter()
fb.kernel(arm, "inverse_dynamics")
print(time.perf_counter() - start)
"""


def kernel_times() -> dict[str, float]:
    """Nanoseconds a state in batches, of one call, and Pinocchio's multiple, by column."""
    arm = fb.load("ur5e").without("friction")
    q, qd, qdd = fb.random_state(arm, seed=11, batch=BATCH)
    states = {"q": q, "qd": qd, "qdd": qdd, "tau": fb.inverse_dynamics(arm, q, qd, qdd)}
    batches: dict[str, Callable[[], object]] = {}
    singles: dict[str, Callable[[], object]] = {}
    for name, inputs in QUANTITIES.items():
        kernel = fb.kernel(arm, name)
        all_states = [states[x] for x in inputs]
        one_state = [states[x][0].copy() for x in inputs]
        batches[f"{name} ns"] = lambda kernel=kernel, given=all_states: kernel(*given, threads=1)
        singles[f"{name} one call ns"] = lambda kernel=kernel, given=one_state: kernel(*given)
    measured = least({**batches, "pinocchio": in_pinocchio(arm, q, qd, qdd)}, ROUNDS, 5)
    theirs = measured.pop("pinocchio") / measured["inverse_dynamics ns"]
    return {
        **{name: 1e9 * took / BATCH for name, took in measured.items()},
        **{name: 1e9 * took for name, took in least(singles, 5, ONE_CALLS).items()},
        "pinocchio takes times as long": theirs,
    }


def least(runs: dict[str, Callable[[], object]], rounds: int, times: int) -> dict[str, float]:
    """Seconds of CPU time of a call of each, the least of rounds in which all take turns."""
    found = dict.fromkeys(runs, float("inf"))
    for _ in range(rounds):
        for name, run in runs.items():
            found[name] = min(found[name], seconds(run, times))
    return found


def in_pinocchio(arm: fb.Model, *states: np.ndarray) -> Callable[[], object]:
    """Pinocchio's call for the inverse dynamics of all states, on one thread."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder, "arm.urdf")
        fb.save(arm, file)
        pool = pin.ModelPool(pin.buildModelFromUrdf(str(file)), 1)
    rows = [np.asfortranarray(x.T) for x in states]
    tau = np.zeros_like(rows[0], order="F")
    pin.rneaInParallel(1, pool, *rows, tau)
    if not np.allclose(tau.T, fb.inverse_dynamics(arm, *states)):
        raise SystemExit("Pinocchio has other torques: the times would not be of the same thing")
    return lambda: pin.rneaInParallel(1, pool, *rows, tau)


def seconds_to_compile() -> float:
    """Of the inverse dynamics in a fresh process whose cache is empty."""
    with tempfile.TemporaryDirectory() as folder:
        run = subprocess.run(
            [sys.executable, "-c", COMPILED],
            env={**os.environ, "FREEBODY_CACHE": folder},
            capture_output=True,
            text=True,
            check=True,
        )
    return float(run.stdout)


def row() -> dict[str, str]:
    """A row of the table, by column."""
    packages = {"numpy": "numpy", "llvmlite": "llvmlite", "pinocchio": "pin"}
    return {
        "date": datetime.datetime.now(datetime.UTC).date().isoformat(),
        "processor": processor(),
        "cores": str(os.cpu_count()),
        "load": f"{os.getloadavg()[0]:.1f}",
        "python": ".".join(map(str, sys.version_info[:3])),
        "freebody": fb.__version__,
        **{name: version(package) for name, package in packages.items()},
        **{name: f"{took:.4g}" for name, took in kernel_times().items()},
        "compile s": f"{seconds_to_compile():.3g}",
    }


def keep(found: dict[str, str]) -> None:
    """Append a row; a table with other columns is refused."""
    head = TABLE.read_text(encoding="utf-8").splitlines()[:1] if TABLE.exists() else []
    if head and head != [",".join(found)]:
        raise SystemExit(f"{TABLE} has other columns: give the old rows the new ones first")
    with TABLE.open("a", encoding="utf-8", newline="") as file:
        writer = csv.DictWriter(file, found, lineterminator="\n")
        if not head:
            writer.writeheader()
        writer.writerow(found)


def main() -> None:
    """Measure, print, and keep the row if asked to."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n\n")[0])
    parser.add_argument("--keep", action="store_true", help="append the row to history.csv")
    asked = parser.parse_args()
    found = row()
    print("\n".join(f"{name}: {value}" for name, value in found.items()))
    if asked.keep:
        keep(found)


if __name__ == "__main__":
    main()
