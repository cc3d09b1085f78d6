"""A 1 kHz control loop on this machine: how long a call takes and how late it begins.

    python benchmarks/control_loop.py [--seconds 10] [--robot ur5e] [--rate 1000]

Computed torque and the momentum observer are called once a period, from Python (kernels) and in C
(the same two exported, compiled with `cc -O2`), and in between the loop sleeps until an absolute
time. Each line has percentiles of the time that both calls take and of the time from the instant
that was meant to the first call, in microseconds. Lateness is the operating system's: without a
real-time kernel and priority it depends on whatever else runs.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import time
from pathlib import Path

import numpy as np

import freebody as fb

LAWS = ("computed_torque", "momentum_observer")
LOOP = """#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <time.h>
#include "computed_torque.h"
#include "momentum_observer.h"
static double seconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9*(double)t.tv_nsec;
}
int main(void)
{
    static double took[COUNT], late[COUNT];
    double q[N] = {0}, qd[N] = {0}, goal[N], still[N] = {0}, kp[N], kd[N], ko[N];
    double tau[N] = {0}, integral[N] = {0}, r[N];
    struct timespec next;
    for (int i = 0; i < N; i++) {
        goal[i] = 0.1;
        kp[i] = 100;
        kd[i] = 20;
        ko[i] = 30;
    }
    clock_gettime(CLOCK_MONOTONIC, &next);
    for (int k = 0; k < COUNT; k++) {
        next.tv_nsec += (long)(1e9*H);
        if (next.tv_nsec >= 1000000000L) {
            next.tv_nsec -= 1000000000L;
            next.tv_sec++;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &next, 0);
        double before = seconds();
        q[0] = 1e-4*k;
        momentum_observer(q, qd, tau, H, integral, ko, r, integral);
        computed_torque(q, qd, goal, still, still, kp, kd, tau);
        took[k] = seconds() - before;
        late[k] = before - ((double)next.tv_sec + 1e-9*(double)next.tv_nsec);
    }
    for (int k = 0; k < COUNT; k++) printf("%.9g %.9g\\n", took[k], late[k]);
    return tau[0] == tau[0] ? 0 : 1;
}
"""


def in_python(model: fb.Model, count: int, h: float) -> np.ndarray:
    """(count, 2): seconds that the calls took, and how late they began."""
    law, observe = (fb.kernel(model, name) for name in LAWS)
    n = model.nv
    q, qd, goal, still, tau = np.zeros(n), np.zeros(n), np.full(n, 0.1), np.zeros(n), np.zeros(n)
    kp, kd, ko, integral = np.full(n, 100.0), np.full(n, 20.0), np.full(n, 30.0), np.zeros(n)
    found = np.empty((count, 2))
    start = time.perf_counter()
    for k in range(count):
        instant = start + (k + 1) * h
        time.sleep(max(0.0, instant - time.perf_counter()))
        before = time.perf_counter()
        q[0] = 1e-4 * k
        _, integral = observe(q, qd, tau, h, integral, ko)
        tau = law(q, qd, goal, still, still, kp, kd)
        found[k] = time.perf_counter() - before, before - instant
    return found


def in_c(model: fb.Model, count: int, h: float) -> np.ndarray:
    """The same in C."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for law in LAWS:
            fb.export(model, law, folder)
        (folder / "loop.c").write_text(LOOP)
        sizes = [f"-DN={model.nv}", f"-DCOUNT={count}", f"-DH={h}"]
        files = ["loop.c", *(f"{law}.c" for law in LAWS)]
        command = ["cc", "-std=c99", "-O2", *sizes, *files, "-lm", "-o", "loop"]
        subprocess.run(command, cwd=folder, check=True)
        done = subprocess.run(["./loop"], cwd=folder, capture_output=True, text=True, check=True)
    return np.array([list(map(float, line.split())) for line in done.stdout.splitlines()])


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robot", default="ur5e")
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--rate", type=float, default=1000.0)
    given = parser.parse_args()
    model, count = fb.load(given.robot), round(given.seconds * given.rate)
    print("| µs | median | 99 % | 99.9 % | largest |\n|---|---|---|---|---|")
    for title, loop in (("Python", in_python), ("C", in_c)):
        for what, values in zip(
            ("calls", "late by"), loop(model, count, 1 / given.rate).T, strict=True
        ):
            found = 1e6 * np.percentile(values, [50.0, 99.0, 99.9, 100.0])
            print(f"| {title}, {what} | {' | '.join(f'{x:.3g}' for x in found)} |", flush=True)


if __name__ == "__main__":
    main()
