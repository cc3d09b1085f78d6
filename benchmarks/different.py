"""A million different robots: the time of one RK4 step of one of them, beside that of equal ones,
on one thread.

    python benchmarks/different.py [--arms 1000000] [--block 1024] [--steps 50] [--rounds 3]

Every arm is a UR5e with masses, centres, inertias and lengths of its own, 66 numbers: a family,
whose kernel reads them for every sample. All arms are moved on by all steps, a block of arms after
the other, so that the block's states and numbers stay in the caches from step to step. Equal arms
go the same way through the kernel of fixed numbers. Afterwards some of the arms are bound one by
one and compared. Times are CPU times of whole rounds, interleaved.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1")

import time
from collections.abc import Callable
from typing import Any

import numpy as np

import freebody as fb
from inputs import named

STEP = 1e-3
COMPARED = 20


def family_of(arm: fb.Model, count: int, seed: int = 0) -> fb.Model:
    """So many robots: the bodies of each are heavier, and its lengths longer, by factors of its
    own."""
    known, rng = fb.parameters(arm), np.random.default_rng(seed)
    heavier, longer = rng.uniform(0.9, 1.1, (2, count))  # what is physical stays so
    values = {}
    for name in named(arm, zeros=True):
        number = name.partition(".")[2]
        factor = heavier if number == "mass" or number.startswith("inertia.") else longer
        values[name] = known[name].value * factor
    return arm.bind(values)


class Arms:
    """Random states of many arms, moved on by one kernel."""

    def __init__(self, arm: fb.Model, count: int, block: int, steps: int):
        self.q, self.qd, tau = fb.random_state(arm, 1, (count,))
        self.tau, self.block, self.steps = 10.0 * tau, block, steps
        self.end = np.empty_like(self.q), np.empty_like(self.qd)
        # read from the one, written to the other
        self.out = [tuple(np.empty((block, arm.nv)) for _ in range(2)) for _ in range(2)]

    def moved(self, step: Callable[..., Any], numbers: np.ndarray | None) -> float:
        """All steps of all arms; CPU time of one step of one arm in ns."""
        start = time.process_time()
        for first in range(0, len(self.q), self.block):
            some = slice(first, first + self.block)
            state, tau = (self.q[some], self.qd[some]), self.tau[some]
            own = () if numbers is None else (numbers[some],)
            for k in range(self.steps):
                out = tuple(x[: len(tau)] for x in self.out[k % 2])
                state = step(*state, tau, STEP, *own, out=out, threads=1)
            for end, reached in zip(self.end, state, strict=True):
                end[some] = reached
        return (time.process_time() - start) * 1e9 / (len(self.q) * self.steps)


def difference(arms: Arms, family: fb.Model) -> float:
    """Of the states where some arms are and those where they get one by one, relative to each arm's
    fastest joint."""
    worst = 0.0
    for i in np.linspace(0, len(arms.q) - 1, COMPARED, dtype=int):
        state, step = (arms.q[i], arms.qd[i]), fb.kernel(family[int(i)], "rk4_step")
        for _ in range(arms.steps):
            state = step(*state, arms.tau[i], STEP)
        apart = max(np.abs(end[i] - x).max() for end, x in zip(arms.end, state, strict=True))
        worst = max(worst, apart / np.abs(state[1]).max())
    return worst


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--arms", type=int, default=1_000_000)
    parser.add_argument("--block", type=int, default=1024)
    parser.add_argument("--steps", type=int, default=50)
    parser.add_argument("--rounds", type=int, default=3)
    given = parser.parse_args()
    arm = fb.load("ur5e").without("friction")
    arms = Arms(arm, given.arms, given.block, given.steps)
    start = time.perf_counter()
    family = family_of(arm, given.arms)
    step, fixed = fb.kernel(family, "rk4_step"), fb.kernel(arm, "rk4_step")
    made = time.perf_counter() - start
    print(
        f"{given.arms} arms, {step.values.shape[-1]} numbers each, made in {made:.1f} s; blocks of "
        f"{given.block}"
    )
    for _ in range(given.rounds):
        equal, different = arms.moved(fixed, None), arms.moved(step, step.values)
        print(
            f"a step: equal {equal:.1f} ns, different {different:.1f} ns, ratio "
            f"{different / equal:.2f}",
            flush=True,
        )
    print(
        f"difference to {COMPARED} arms bound one by one, after {given.steps} steps: "
        f"{difference(arms, family):.1e}"
    )


if __name__ == "__main__":
    main()
