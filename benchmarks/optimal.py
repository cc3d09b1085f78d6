"""Time-optimal motions along random paths beside toppra's, with torque limits.

toppra gets the same path and limits, torques from `fb.inverse_dynamics` (a call takes a
microsecond), and its scheme with conditions at both ends of each interval. The truth is a duration
with 20001 points. Said of each robot: the largest relative error of durations, ours, toppra's on an
even grid of as many points, and toppra's on our grid, also with its sign: below 0 a motion is
quicker than its limits allow; the largest difference between ours and the latter; by how much
torques exceed their limits on a ten times finer check, of 99 of 100 paths and of the worst; speeds
theirs (0: nowhere); at how many samples some limit is reached within 1 %. Then milliseconds (the
least of turns) of one path all in, of toppra's all in and of its passes alone, and toppra's time
over ours, by the clock and of the processor; last, a thousand UR5e paths of a thousand points at
once, by both too. Each takes its turn with as many calls as fill 20 ms, so that it finds its code
and memory in the processor's caches; `cold` is the processor's time of the first call of ours in a
turn, just after toppra's.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np
import toppra
import toppra.algorithm as toppra_algorithm
import toppra.constraint as toppra_constraint
from scipy.interpolate import CubicSpline

import freebody as fb
from freebody.motion.optimal.geometric_path import grid
from freebody.motion.piecewise import PiecewisePolynomial

toppra.setup_logging("ERROR")
TURN = 0.02
DH = [
    {"theta": 0, "d": 0.34, "a": 0, "alpha": -np.pi / 2},
    {"theta": 0, "d": 0, "a": 0, "alpha": np.pi / 2},
    {"theta": 0, "d": 0.4, "a": 0, "alpha": np.pi / 2},
    {"theta": 0, "d": 0, "a": 0.3, "alpha": -np.pi / 2},
    {"theta": 0, "d": 0.3, "a": 0.1, "alpha": 0},
]


def dh_arm() -> fb.Model:
    """Five joints, with speeds and torques of a small robot."""
    rows = [
        row
        | {
            "m": 5.0 - k,
            "com": (-0.5 * row["a"], 0.0, -0.2 * row["d"]),
            "I": np.diag([0.02, 0.03, 0.02]) * (5 - k) / 5,
            "limits": fb.Limits(-3.0, 3.0, 2.5, 80.0 - 14.0 * k),
        }
        for k, row in enumerate(DH)
    ]
    return fb.dh(rows, convention="standard", name="dh5")


ARMS: dict[str, Callable[[], fb.Model]] = {
    "ur5e": lambda: fb.load("ur5e"),
    "panda": lambda: fb.load("panda").without("friction"),
    "dh5": dh_arm,
}


def random_path(model: fb.Model, rng: np.random.Generator, waypoints: int = 6) -> CubicSpline:
    """Within the joints' ranges, about the middle."""
    low, high = np.maximum(model.limits.lower, -2.5), np.minimum(model.limits.upper, 2.5)
    middle, half = 0.5 * (low + high), 0.5 * (high - low)
    while True:
        points = middle + 0.7 * half * rng.uniform(-1, 1, (waypoints, model.nq))
        path = CubicSpline(np.linspace(0, 1, waypoints), points, bc_type="natural")
        q = path(np.linspace(0, 1, 500))
        if (q > model.limits.lower).all() and (q < model.limits.upper).all():
            return path


def by_toppra(model: fb.Model, path: CubicSpline, s: np.ndarray) -> tuple[float, float]:
    """(duration, seconds of the passes)."""
    scheme = {"discretization_scheme": toppra_constraint.DiscretizationType.Interpolation}

    def both(limit: np.ndarray) -> np.ndarray:
        return np.stack([-limit, limit], axis=-1)

    curve = toppra.SplineInterpolator(path.x, path(path.x), bc_type="natural")
    limits = [
        toppra_constraint.JointVelocityConstraint(both(model.limits.velocity)),
        toppra_constraint.JointTorqueConstraint(
            lambda q, v, a: fb.inverse_dynamics(model, q, v, a),
            both(model.limits.effort),
            np.zeros(model.nv),
            **scheme,
        ),
    ]
    problem = toppra_algorithm.TOPPRA(limits, curve, gridpoints=s)
    start = time.perf_counter()
    _, speed, _ = problem.compute_parameterization(0, 0)
    passes = time.perf_counter() - start
    return float(np.sum(2 * np.diff(s) / (speed[1:] + speed[:-1]))), passes


def least(runs: dict[str, Callable[[], object]], rounds: int) -> dict[str, np.ndarray]:
    """Milliseconds of each, in turn: by the clock, of the processor, and the latter of the first
    call of a turn."""
    found = {name: np.full(3, np.inf) for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            start, calls, first = now(), 0, 0.0
            while calls == 0 or (now() - start)[0] < TURN:
                run()
                calls += 1
                first = first or (now() - start)[1]
            ms = 1e3 * np.append((now() - start) / calls, first)
            found[name] = np.minimum(found[name], ms)
    return found


def now() -> np.ndarray:
    """Seconds by the clock, and of this process on all processors."""
    return np.array([time.perf_counter(), time.process_time()])


def excess_and_share(model: fb.Model, motion: fb.Motion) -> tuple[float, float, float]:
    """(torque over its limit on a ten times finer check, speed over its limit, share of samples
    where a limit is reached)."""
    fractions = (np.arange(10) + 0.5) / 10
    t = (motion.t[:-1, None] + fractions * np.diff(motion.t)[:, None]).ravel()
    q, qd, qdd = motion.at(t)
    torque = np.abs(fb.inverse_dynamics(model, q, qd, qdd)) / model.limits.effort
    speed = np.abs(qd) / model.limits.velocity
    top = (motion.peaks.velocity.size / model.limits.velocity).max()
    return torque.max(), top, np.mean(np.maximum(torque, speed).max(axis=-1) > 0.99)


def durations(model: fb.Model, paths: list[CubicSpline], points: int, truth: np.ndarray) -> str:
    """How far they are off, and what the motions exceed."""
    motions = fb.time_optimal(model, paths, points=points)
    own = np.array([motion.duration for motion in motions]) / truth - 1.0
    even = np.linspace(0.0, 1.0, points)
    ours = grid(PiecewisePolynomial(paths[0].x, paths[0].c), points - 1)
    on_even, on_ours = (
        np.array([by_toppra(model, path, s)[0] for path in paths]) / truth - 1.0
        for s in (even, ours)
    )
    apart = np.abs((1.0 + own) / (1.0 + on_ours) - 1.0).max()
    torque, speed, share = np.array([excess_and_share(model, motion) for motion in motions]).T
    return (
        f"{np.abs(own).max():10.1e}{np.abs(on_even).max():10.1e}{on_ours.min():10.1e}"
        f"{on_ours.max():10.1e}{apart:10.1e}{np.quantile(torque, 0.99):13.5f}{torque.max():10.5f}"
        f"{max(speed.max() - 1.0, 0.0):10.1e}{share.min():9.3f}"
    )


def main() -> None:
    """A table for each number of points, then the times."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--paths", type=int, default=200)
    parser.add_argument("--rounds", type=int, default=7)
    arguments = parser.parse_args()
    robots, truths = {}, {}
    for name, make in ARMS.items():
        model, rng = make(), np.random.default_rng(7)
        robots[name] = model, [random_path(model, rng) for _ in range(arguments.paths)]
        exact = fb.time_optimal(*robots[name], points=20001)
        truths[name] = np.array([motion.duration for motion in exact])
    for points in (101, 301, 1001):
        print(f"{points} points, {arguments.paths} paths")
        print(
            f"{'':8}{'own':>10}{'even':>10}{'from':>10}{'to':>10}{'apart':>10}{'torque 99 %':>13}"
            f"{'worst':>10}{'speed':>10}{'reached':>9}"
        )
        for name, (model, paths) in robots.items():
            print(f"{name:8}{durations(model, paths, points, truths[name])}", flush=True)
    for points in (101, 1001):
        print(f"{points} points")
        print(
            f"{'':8}{'ms':>8}{'CPU':>7}{'cold':>7}{'toppra':>8}{'CPU':>7}{'passes':>8}{'ratio':>7}"
            f"{'CPU':>7}"
        )
        for name, (model, paths) in robots.items():
            s = np.linspace(0.0, 1.0, points)
            passes = min(by_toppra(model, paths[0], s)[1] for _ in range(arguments.rounds))
            own, toppras = least(
                {
                    "own": lambda m=model, p=paths[0], n=points: fb.time_optimal(m, p, points=n),
                    "toppra": lambda m=model, p=paths[0], s=s: by_toppra(m, p, s),
                },
                arguments.rounds,
            ).values()
            ratio = toppras / own
            print(
                f"{name:8}{own[0]:8.2f}{own[1]:7.2f}"
                f"{own[2]:7.2f}{toppras[0]:8.1f}{toppras[1]:7.1f}{1e3 * passes:8.1f}{ratio[0]:7.1f}"
                f"{ratio[1]:7.1f}"
            )
    model, rng = ARMS["ur5e"](), np.random.default_rng(7)
    paths = [random_path(model, rng) for _ in range(1000)]
    clock, processor = least({"all": lambda: fb.time_optimal(model, paths)}, 3)["all"][:2] / 1e3
    print(f"1000 paths of 1001 points: {clock:.2f} s, {processor:.2f} s of a processor")


if __name__ == "__main__":
    main()
