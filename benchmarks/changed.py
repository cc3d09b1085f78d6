"""What a changed number costs: a new payload, mass, length or gravity of a UR5e, and one call of
the new robot.

    python benchmarks/changed.py [--rounds 15]

First the changed copy alone, then with one inverse and one forward dynamics of it, each time with
another value; the structure has been called before. Below, one call of a kernel with `inputs=`, as
a multiple of the kernel of fixed numbers: p left out, as an array, and by name. Microseconds of CPU
time, the median of rounds and the quickest.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")

import time
from collections import deque
from collections.abc import Callable
from copy import copy
from functools import partial
from itertools import repeat
from statistics import median

import numpy as np

import freebody as fb

CALLS, WITHIN = 400, 100
CHANGES: dict[str, Callable[[fb.Model, float], fb.Model]] = {
    "payload": lambda model, x: model.with_payload(mass=2.0 + x),
    "payload with its centre": lambda model, x: model.with_payload(
        mass=2.0 + x, com=(0.01, 0.02, 0.1)
    ),
    "mass": lambda model, x: model.bind({"forearm_link.mass": 2.0 + x}),
    "length": lambda model, x: model.bind({"elbow_joint.a": -0.4 - x}),
    "gravity": lambda model, x: model.bind({"gravity": 9.0 + x}),
}
INPUTS = {
    "one mass": ["forearm_link.mass"],
    "payload": ["payload.*"],
    "masses": ["*.mass"],
    "all": ["*"],
}


def microseconds(run: Callable[[float], object]) -> float:
    """CPU time of one call, each with another number."""
    start = time.process_time()
    for k in range(CALLS):
        run(1e-4 * k)
    return (time.process_time() - start) / CALLS * 1e6


def of_one(kernel: Callable[..., object], *arguments: object) -> Callable[[float], object]:
    """Calls of a kernel that stand for one, so that what calls it does not count."""
    columns = [repeat(x, WITHIN) for x in arguments]

    def run(_: float) -> None:
        deque(map(kernel, *[copy(x) for x in columns]), maxlen=0)

    return run


def times(runs: dict[str, Callable[[float], object]], rounds: int) -> dict[str, list[float]]:
    """Of each run one time a round."""
    for run in runs.values():
        run(0.0)
    taken: dict[str, list[float]] = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            taken[name].append(microseconds(run))
    return taken


def after(change: Callable[[float], fb.Model], function: Callable[..., object], state: np.ndarray):
    """A change, and one call of the changed robot."""
    return lambda x: function(change(x), *state)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=15)
    rounds = parser.parse_args().rounds
    model, state = fb.load("ur5e"), np.random.default_rng(20261122).normal(size=(3, 6))
    runs: dict[str, Callable[[float], object]] = {}
    for name, change in CHANGES.items():
        made = partial(change, model)
        runs[name] = made
        runs[f"{name}, inverse dynamics"] = after(made, fb.inverse_dynamics, state)
        runs[f"{name}, forward dynamics"] = after(made, fb.forward_dynamics, state)
    print(f"{'µs':<44}{'median':>8}{'least':>8}")
    for name, taken in times(runs, rounds).items():
        print(f"{name:<44}{median(taken):8.1f}{min(taken):8.1f}")
    print(f"\n{'inverse dynamics with inputs=':<44}{'left out':>10}{'array':>10}{'by name':>10}")
    fixed = fb.kernel(model, "inverse_dynamics")
    for title, names in INPUTS.items():
        kernel = fb.kernel(model, "inverse_dynamics", inputs=names)
        p, one = np.array(kernel.values), kernel.parameters[0]
        taken = times(
            {
                "fixed": of_one(fixed, *state),
                "left out": of_one(kernel, *state),
                "array": of_one(kernel, *state, p),
                "by name": of_one(partial(kernel, p={one: 2.0}), *state),
            },
            rounds,
        )
        ratios = [
            median(a / b for a, b in zip(taken[way], taken["fixed"], strict=True)) for way in taken
        ]
        print(f"{f'{title} ({len(p)})':<44}" + "".join(f"{ratio:10.2f}" for ratio in ratios[1:]))


if __name__ == "__main__":
    main()
