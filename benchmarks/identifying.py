"""How long identification takes, and how much memory: 100 000 samples of a simulated UR5e, from
CSV to a saved model, what is compiled being warm. --seconds: of another log, at 100 Hz.

    python benchmarks/identifying.py
"""

from __future__ import annotations

import argparse
import os
import tempfile
import time
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

import freebody as fb

RATE, JOINTS = 100.0, 6


def arm() -> fb.Model:
    """A UR5e with rotors and friction."""
    rng, model = np.random.default_rng(2), fb.load("ur5e", physical="ignore")
    for joint in model.joint_names:
        model = model.with_drive(
            joint,
            rotor=rng.uniform(0.05, 0.4),
            viscous=rng.uniform(2.0, 4.0),
            coulomb=rng.uniform(1.0, 3.0),
            load_friction=rng.uniform(0.03, 0.08),
        )
    return model


def written(model: fb.Model, path: Path, seconds: float) -> Path:
    """The file of a log: Fourier motions of 10 s period, noise on torques, positions and rates."""
    rng, t = np.random.default_rng(1), np.arange(0.0, seconds, 1.0 / RATE)
    w = 2.0 * np.pi * np.arange(1, 6) / 10.0
    a, b = rng.normal(size=(2, 5, JOINTS)) / np.arange(1, 6)[:, None]
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    q, qd = s @ a + c @ b, c @ (w[:, None] * a) - s @ (w[:, None] * b)
    qdd = -s @ (w[:, None] ** 2 * a) - c @ (w[:, None] ** 2 * b)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    tau = tau + 0.02 * tau.std(axis=0) * rng.normal(size=q.shape)
    q, qd = q + 2e-5 * rng.normal(size=q.shape), qd + 1e-3 * rng.normal(size=q.shape)
    head = ",".join(["t", *(f"{x}{k + 1}" for x in ("q", "qd", "tau") for k in range(JOINTS))])
    rows = np.column_stack([t, q, qd, tau])
    np.savetxt(path, rows, delimiter=",", header=head, comments="", fmt="%.9g")
    return path


def memory(kind: str) -> float:
    """Memory of this process, MB: VmRSS now, VmHWM at most since `forget_peak`; Linux alone."""
    lines = Path("/proc/self/status").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith(kind)) / 1024


def forget_peak() -> None:
    """Lets the largest memory so far be that of now."""
    Path("/proc/self/clear_refs").write_text("5")


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seconds", type=float, default=1000.0)
    seconds = parser.parse_args().seconds
    model, bare = arm(), fb.load("ur5e", physical="ignore")
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        short = written(model, folder / "short.csv", 20.0)
        whole = written(model, folder / "whole.csv", seconds)
        fb.save(fb.identify(bare, fb.read_log(str(short), bare)).model, folder / "model.toml")
        before = memory("VmRSS")
        forget_peak()
        for _ in range(5):
            wall, processor = time.perf_counter(), time.process_time()
            log = fb.read_log(str(whole), bare)
            read = time.process_time() - processor
            fb.save(fb.identify(bare, log).model, folder / "model.toml")
            processor = time.process_time() - processor
            print(
                f"{len(log.time)} samples: {time.perf_counter() - wall:.2f} s, of the processor "
                f"{processor:.2f} s, of which reading {read:.2f} s"
            )
        print(f"at most {memory('VmHWM') - before:.0f} MB above what is loaded and compiled")


if __name__ == "__main__":
    main()
