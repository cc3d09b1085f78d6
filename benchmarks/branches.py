"""Inverse kinematics: every branch of a pose, beside EAIK where it is installed.

    taskset -c 0 python benchmarks/branches.py [--poses 1000000] [--outside 100000] [--robots …]

For each robot, of one thread (the function takes as many as the process has CPUs): nanoseconds a
pose in batches of 4096 (`out=`), microseconds of one call from Python; the same of
`fb.inverse_kinematics` (its batch without the few poses that it looks at more closely, since these
are next to singular); and for EAIK a pose of its own batch call, in turns within one run, the
quickest of some rounds. Then, for so many random poses, in pieces: how far the position that made
each pose is from the nearest branch, and how far forward kinematics takes the branches from the
pose. Last, of so many poses moved out of reach (by three times the arm's length and more; seven
joints without `redundancy`): how many are refused with a distance that their way out allows, and
the seconds that takes.
"""

import argparse
import time
import warnings
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

import freebody as fb
from common import seconds

ROBOTS = ("ur5e", "puma560", "industrial", "skew", "scara", "panda", "iiwa14")
BATCH = 4096
ROUNDS = 15
PIECE = 50_000


def load(name: str) -> fb.Model:
    """A bundled robot; or an industrial arm, offsets at shoulder and elbow, a spherical wrist (the
    lengths are an ABB IRB 6640's, in m); or the same with axes 1 to 3 askew, which leads to a
    polynomial of degree four."""
    if name not in ("industrial", "skew"):
        return fb.load(name, physical="ignore")
    half = np.pi / 2
    first, second, third = (-half, 0.0, -half) if name == "industrial" else (-1.2, 0.4, -1.3)
    rows = [
        {"d": 0.78, "a": 0.32, "alpha": first},
        {"a": 1.075, "theta": -half, "alpha": second},
        {"a": 0.2, "alpha": third},
        {"d": 1.1425, "alpha": half},
        {"alpha": -half},
        {"d": 0.2},
    ]
    return fb.dh(
        [{"m": 1.0, "com": [0, 0, 0], "I": [0] * 6, **row} for row in rows], convention="standard"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--poses", type=int, default=1_000_000)
    parser.add_argument("--outside", type=int, default=100_000)
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=ROBOTS)
    asked = parser.parse_args()
    warnings.simplefilter("ignore", fb.PhysicalWarning)
    print(
        f"{'robot':11}{'branches':>9}{'ns a pose':>11}{'µs a call':>11}{'function, ns':>14}"
        f"{'function, µs':>14}{'EAIK µs a pose':>16}"
        f"{'own, worst':>12}{'residual':>10}{'unclear':>9}"
        f"{'refused':>9}{'s':>7}"
    )
    for name in asked.robots:
        model = load(name)
        kernel: Any = fb.kernel(model, "inverse_kinematics")
        q, poses = random_poses(model, BATCH, 0)
        arrays = inputs(model, kernel, q, poses)
        one = [np.array(x[0]) for x in arrays]
        runs: dict[str, tuple[Callable[[], object], int, float]] = {
            "batch": (partial(kernel, *arrays, out=kernel(*arrays), threads=1), 3, BATCH / 1e9),
            "call": (partial(kernel, *one), 300, 1e-6),
        }
        seven = len(arrays) == 2
        known = fb.inverse_kinematics(model, poses, redundancy=arrays[1] if seven else None)
        clear = (np.abs(kernel(*arrays)[2]) > 1e-5).all(axis=1) & (known.count > 0)
        some = [np.ascontiguousarray(x[clear]) for x in arrays]
        given = [{"redundancy": x[1]} if seven else {} for x in (some, one)]
        function = fb.inverse_kinematics
        runs["function"] = partial(function, model, some[0], **given[0]), 3, clear.sum() / 1e9
        runs["one"] = partial(function, model, one[0], **given[1]), 100, 1e-6
        rival = eaik(model, poses)
        if rival is not None:
            runs["eaik"] = (rival, 1, BATCH / 1e6)
        times = quickest(runs)
        own, residual, unclear = verified(model, kernel, asked.poses)
        refused, seconds = outside(model, asked.outside)
        print(
            f"{name:11}{kernel.program.outputs[0].shape[0]:9}{times['batch']:11.0f}"
            f"{times['call']:11.2f}{times['function']:14.0f}{times['one']:14.2f}"
            f"{times.get('eaik', np.nan):16.2f}{own:12.1e}{residual:10.1e}"
            f"{unclear:9}{refused:9}{seconds:7.2f}",
            flush=True,
        )


def random_poses(model: fb.Model, count: int, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Positions within the limits, and the poses of the tip there."""
    q, _, _ = fb.random_state(model, seed, count)
    return q, fb.forward_kinematics(model, q)


def inputs(model: fb.Model, kernel: Any, q: np.ndarray, poses: np.ndarray) -> list[np.ndarray]:
    """What the kernel takes: the joint of seven that is held stands as it did."""
    return [poses, q[:, 6].copy()] if len(kernel.program.inputs) == 2 else [poses]


def quickest(runs: dict[str, tuple[Callable[[], object], int, float]]) -> dict[str, float]:
    """Seconds of each, over its unit: the mean of its repetitions, in the quickest of rounds that
    take turns."""
    found = dict.fromkeys(runs, np.inf)
    for _ in range(ROUNDS):
        for name, (call, times, unit) in runs.items():
            found[name] = min(found[name], seconds(call, times, time.perf_counter) / unit)
    return found


def eaik(model: fb.Model, poses: np.ndarray) -> Callable[[], object] | None:
    """EAIK's batch call for the same arm, by its axes; None where it has none, or is not there."""
    try:
        from eaik.IK_HP import HPRobot  # pyright: ignore[reportMissingImports]
    except ImportError:
        return None
    if model.nq != 6:
        return None
    chain = screws(model)
    H = np.array([s.w for s in chain.screws])
    at = np.array([s.p for s in chain.screws])
    P = np.vstack([at[:1], np.diff(at, axis=0), chain.p - at[-1:]])
    turned = poses.copy()
    turned[:, :3, :3] = poses[:, :3, :3] @ chain.R.T  # its frames are the base's at zero
    robot = HPRobot(H, P)
    if not robot.hasKnownDecomposition():
        return None
    (first,) = robot.IK_batched(turned[:1], 1)
    assert np.abs(robot.fwdKin(np.array(first.Q)[0]) - turned[0]).max() < 1e-8, "not the same arm"
    return partial(robot.IK_batched, turned, 1)


def screws(model: fb.Model) -> Any:
    """The joints as lines at zero."""
    from freebody.algorithms.screws import chain_to

    return chain_to(model.tree, model.frame().name)


def verified(model: fb.Model, kernel: Any, poses: int) -> tuple[float, float, int]:
    """(own, residual, unclear): see the head of the file; unclear: poses of which a branch clears
    its bounds by less than 1e-6. Where the kernel has lost the position, the function's branches
    count, which looks closer at such poses."""
    turning = np.array([body.kind.turns for body in model.bodies if body.joint.mimic is None])
    worst_own = worst = 0.0
    unclear = 0
    for seed in range(-(-poses // PIECE)):
        q, T = random_poses(model, min(PIECE, poses - seed * PIECE), seed)
        found, valid, clear = kernel(*inputs(model, kernel, q, T))
        good = valid == 1.0
        moving = slice(0, 7) if len(kernel.program.inputs) == 2 else slice(None)
        own = nearest(found, good, q, turning, moving)
        lost = np.flatnonzero(own > 1e-6)
        if len(lost):
            held = {"redundancy": q[lost, 6]} if len(kernel.program.inputs) == 2 else {}
            again = fb.inverse_kinematics(model, T[lost], **held)
            own[lost] = nearest(again.q, again.valid, q[lost], turning, moving)
        miss = np.abs(fb.forward_kinematics(model, found[good]) - np.repeat(T, good.sum(1), axis=0))
        worst_own, worst = max(worst_own, own.max()), max(worst, miss.max(initial=0.0))
        unclear += int((np.abs(clear).min(axis=1) < 1e-6).sum())
    return worst_own, worst, unclear


def nearest(
    found: np.ndarray, good: np.ndarray, q: np.ndarray, turning: np.ndarray, moving: slice
) -> np.ndarray:
    """How far the nearest of the good branches (N, k, nq) is from q (N, nq)."""
    way = found[..., moving] - q[:, None, moving]
    way -= np.where(turning[moving], 2 * np.pi * np.round(way / (2 * np.pi)), 0.0)
    return np.where(good, np.abs(way).max(axis=-1), np.inf).min(axis=1, initial=np.inf)


def outside(model: fb.Model, count: int) -> tuple[int, float]:
    """How many poses out of reach are refused, with a distance above what the arm's length leaves
    of the way out and below the whole way; seconds."""
    from freebody.algorithms.screws import arm_length

    _, T = random_poses(model, count, 1)
    length = arm_length(model.tree, model.frame().name)
    way = np.random.default_rng(1).normal(size=(count, 3))
    if not all(s.turning for s in screws(model).screws):  # a lift has no end but its limits
        way[:, 2] = 0.0
    way *= (3.0 + np.abs(way[:, :1])) * length / np.linalg.norm(way, axis=-1, keepdims=True)
    T[:, :3, 3] += way
    start = time.perf_counter()
    found = fb.inverse_kinematics(model, T)
    seconds = time.perf_counter() - start
    far = np.linalg.norm(way, axis=-1)
    told = (found.distance <= far + 1e-9) & (found.distance >= far - 2.0 * length - 1e-9)
    return int((told & (found.count == 0)).sum()), seconds


if __name__ == "__main__":
    main()
