"""Chains of many joints: what compiling and running costs a joint, each time in a process of its
own.

    python benchmarks/chains.py [--joints 25 50 100 200] [--tasks inverse_dynamics forward_dynamics]
        [--repeats 3]

Seconds are the CPU's, which other work on the machine disturbs less; of the processes the quickest
counts.
"""

import argparse
import os
import subprocess
import sys
import time

os.environ.update(
    OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", FREEBODY_CACHE="off"
)

import numpy as np

import freebody as fb

TASKS = ("inverse_dynamics", "forward_dynamics")
BATCH = 512
LINK = {
    "a": 0.02,
    "d": 0.01,
    "alpha": 0.7,
    "m": 0.1,
    "com": [0.01, 0, 0],
    "I": np.diag([1e-4, 2e-4, 2e-4]),
}


def measure(task: str, joints: int) -> tuple[float, float]:
    """Seconds until the first result, and for one sample in a batch."""
    model = fb.dh([LINK] * joints, convention="modified")
    state = np.random.default_rng(20261121).uniform(-1, 1, (3, BATCH, joints))
    started = time.process_time()
    kernel = fb.kernel(model, task)
    kernel(*state[:, 0])
    compiling = time.process_time() - started
    out = np.empty((BATCH, joints))
    running = min(seconds(lambda: kernel(*state, out=out, threads=1)) for _ in range(15))
    return compiling, running / BATCH


def seconds(run) -> float:
    started, calls = time.process_time(), 0
    while (passed := time.process_time() - started) < 0.02:
        run()
        calls += 1
    return passed / calls


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--joints", nargs="+", type=int, default=[25, 50, 100, 200])
    parser.add_argument("--tasks", nargs="+", default=TASKS)
    parser.add_argument("--repeats", type=int, default=3)
    parser.add_argument("--one", action="store_true", help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.one:
        print(*measure(options.tasks[0], options.joints[0]))
        return
    print(f"batches of {BATCH}, best of {options.repeats} processes, CPU time")
    for task in options.tasks:
        first = None
        for joints in options.joints:
            command = [sys.executable, __file__, "--one", "--tasks", task, "--joints", str(joints)]
            runs = [
                [
                    *map(
                        float,
                        subprocess.run(command, check=True, capture_output=True).stdout.split(),
                    )
                ]
                for _ in range(options.repeats)
            ]
            compiling, running = np.min(runs, axis=0) / joints
            first = first or (compiling, running)
            print(
                f"{task:<20}{joints:5} joints, for each: compiling {1e3 * compiling:6.1f} ms "
                f"({compiling / first[0]:.2f} of the first), running {1e9 * running:6.2f} ns "
                f"({running / first[1]:.2f})",
                flush=True,
            )


if __name__ == "__main__":
    main()
