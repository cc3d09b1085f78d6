"""Torques of a UR5e over many robots times many states, reduced on the way.

    python benchmarks/sweeps.py [--robots 1000] [--states 10000]

Seconds of `fb.sweep` with the largest absolute value alone, and with quantiles and places too, held
in memory and in a Zarr store, and with samples as states, which are made when they are read; beside
the kernel alone on all states of one robot, as often as there are robots; the quickest of some
rounds, in turns. The memory that was held at most, in MB, at the end.
"""

import argparse
import sys
import tempfile
from collections.abc import Callable

import numpy as np

import freebody as fb
from common import quickest

ROUNDS = 8


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", type=int, default=1000)
    parser.add_argument("--states", type=int, default=10_000)
    asked = parser.parse_args()
    arm = fb.load("ur5e")
    q, qd, qdd = fb.random_state(arm, 0, asked.states)
    ranges = {"forearm_link.mass": (1.0, 4.0), "upper_arm_link.mass": (4.0, 12.0)}
    over = {"design": fb.samples(asked.robots, ranges), "state": {"q": q, "qd": qd, "qdd": qdd}}
    kernel = fb.kernel(arm, "inverse_dynamics", inputs=list(ranges))

    sampled = fb.samples(asked.states, {x: (-np.ones(6), np.ones(6)) for x in ("q", "qd", "qdd")})

    def swept(*reductions: str, stored: bool = False, states: object = over["state"]) -> None:
        with tempfile.TemporaryDirectory() as folder:
            fb.sweep(
                arm,
                "inverse_dynamics",
                over={**over, "state": states},
                reduce=reductions,
                store=f"{folder}/s" if stored else None,
            )

    def alone() -> None:
        for _ in range(asked.robots):
            kernel(q, qd, qdd)

    runs: dict[str, Callable[[], object]] = {
        "peak": lambda: swept("peak"),
        "peak, in a store": lambda: swept("peak", stored=True),
        "peak, of samples": lambda: swept("peak", states=sampled),
        "peak, rms, p99, argpeak": lambda: swept("peak", "rms", "p99", "argpeak"),
        "these four, in a store": lambda: swept("peak", "rms", "p99", "argpeak", stored=True),
        "kernel alone": alone,
    }
    for name, seconds in quickest(runs, ROUNDS).items():
        each = 1e9 * seconds / (asked.robots * asked.states)
        print(f"{name:26}{seconds:8.3f} s {each:8.1f} ns a point")
    if sys.platform != "win32":
        import resource

        print(f"memory at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


if __name__ == "__main__":
    main()
