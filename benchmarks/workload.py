"""The whole workload: public functions with fresh results, from one sample to a hundred thousand,
beside what a user of Pinocchio, or of EAIK, has; and the kernel's best case, called that.

    taskset -c 0 python benchmarks/workload.py [--robots ur5 panda] [--calibrated]
        [--sizes 1 10 100 4096 100000] [--rounds 7] [--only mass_matrix]

Every call of freebody checks what it is given and what comes out, and returns new arrays. Pinocchio
computes inverse and forward dynamics in its own batch calls with one thread (its columns and its
result stand ready) or in the quickest Python loop, whichever is quicker; the others in that loop,
whose results stay in its `Data`. Inverse kinematics takes random poses as they come, those that
are looked at more closely among them. The best case is the kernel of fixed numbers on 4096 samples
in the caches, into arrays that stand ready. `--calibrated` turns and moves every joint by about
1e-3 (rad, m), as a factory's calibration does, on both sides. Values are compared first; rounds
take turns; times are the quickest on the wall.
"""

import argparse
import os

os.environ.update(OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1")

import tempfile
import xml.etree.ElementTree as ET
from collections import deque
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pinocchio as pin

import freebody as fb
from branches import eaik, load, random_poses
from common import quickest, robots_folder
from compare import ROBOTS, States, bare

SIZES = (1, 10, 100, 4096, 100_000)
LOOP = 200
"""Samples of a Python loop, whose time does not depend on how many they are."""
AGREE = 1e-7
AT_ONCE = 4096
TOGETHER = ("mass_matrix", "bias", "forward_kinematics", "jacobian", "jacobian_dot")
BRANCHES = ("ur5e", "puma560", "panda", "iiwa14")


def calibrated(urdf: str, seed: int = 7) -> str:
    """The robot with every joint turned and moved a little."""
    root, rng = ET.fromstring(urdf), np.random.default_rng(seed)
    for joint in root.iter("joint"):
        origin = joint.find("origin")
        if origin is None:
            origin = ET.SubElement(joint, "origin")
        for name in ("xyz", "rpy"):
            given = np.array(origin.get(name, "0 0 0").split(), dtype=float)
            origin.set(name, " ".join(map(repr, map(float, given + rng.normal(0, 1e-3, 3)))))
    return ET.tostring(root, encoding="unicode")


class Pair:
    """A robot on both sides."""

    def __init__(self, name: str, moved: bool):
        file, tip = ROBOTS[name]
        urdf = bare(robots_folder() / file)
        urdf = calibrated(urdf) if moved else urdf
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder, "robot.urdf")
            path.write_text(urdf, encoding="utf-8")
            self.model = fb.load(path, mimic="free", tip=tip, physical="ignore")
        self.model = self.model.without("friction", "rotors", "springs")
        self.pin = pin.buildModelFromXML(urdf)
        self.data, self.pool = self.pin.createData(), pin.ModelPool(self.pin, 1)
        self.frame = self.pin.getFrameId(tip)

    def states(self, count: int) -> States:
        """Random ones."""
        q, qd, qdd, tau = np.random.default_rng(1).uniform(-1, 1, (4, count, self.model.nv))
        return States(q, qd, qdd, 10 * tau, tuple(self.model.joint_names))

    def theirs(self, states: States) -> dict[str, tuple[Callable[..., Any], list[np.ndarray]]]:
        """Pinocchio's call for one sample of each quantity, and its arguments."""
        p, d, f = self.pin, self.data, self.frame
        joints = sorted(range(1, p.njoints), key=lambda i: p.idx_vs[i])
        order = states.order(p.names[i] for i in joints)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED

        def pose(q: np.ndarray) -> Any:
            pin.forwardKinematics(p, d, q)
            return pin.updateFramePlacement(p, d, f)

        calls: dict[str, Callable[..., Any]] = {
            "inverse_dynamics": partial(pin.rnea, p, d),
            "forward_dynamics": partial(pin.aba, p, d),
            "mass_matrix": partial(pin.crba, p, d),
            "forward_kinematics": pose,
            "jacobian": lambda q: pin.computeFrameJacobian(p, d, q, f, axes),
            "inverse_dynamics_derivatives": partial(pin.computeRNEADerivatives, p, d),
            "forward_dynamics_derivatives": partial(pin.computeABADerivatives, p, d),
        }
        return {task: (call, [*states.arguments(task, order)]) for task, call in calls.items()}

    def batch(self, task: str, columns: list[np.ndarray]) -> Callable[[], Any] | None:
        """Its batch call, where it has one."""
        call = {"inverse_dynamics": pin.rneaInParallel, "forward_dynamics": pin.abaInParallel}
        if task not in call:
            return None
        given = [np.asfortranarray(x.T) for x in columns]
        return partial(call[task], 1, self.pool, *given, np.empty_like(given[0]))


def dynamics(pair: Pair, name: str, sizes: list[int], rounds: int, only: list[str]) -> None:
    """One row for each quantity."""
    print(f"\n{name:<32}{'best case':>10}" + "".join(f"{f'B = {B}':>21}" for B in sizes))
    print(f"{'':32}{'ns':>10}" + f"{'ns a sample, ratio':>21}" * len(sizes))
    few = pair.states(AT_ONCE)
    for task in pair.theirs(few):
        if only and task not in only:
            continue
        function = getattr(fb, task)
        kernel: Any = fb.kernel(pair.model, task)
        arrays = few.arguments(task)
        out = kernel(*arrays)
        runs: dict[str, tuple[Callable[[], Any], int]] = {
            "best": (partial(kernel, *arrays, out=out, threads=1), AT_ONCE)
        }
        alike(pair, task, few)
        for B in sizes:
            states = pair.states(B)
            ours = states.arguments(task)
            call, columns = pair.theirs(states)[task]
            runs[f"ours {B}"] = (partial(function, pair.model, *ours), B)
            some = [list(x[:LOOP]) for x in columns]
            loop = partial(looped, call, some)
            runs[f"loop {B}"] = (loop, len(some[0]))
            batch = pair.batch(task, columns)
            if batch is not None:
                runs[f"batch {B}"] = (batch, B)
        times = timed(runs, rounds)
        cells = []
        for B in sizes:
            peer = min(times.get(f"{how} {B}", np.inf) for how in ("loop", "batch"))
            ours_ = times[f"ours {B}"]
            cells.append(f"{ours_:,.1f}, {peer / ours_:.2f}×".rjust(21))
        print(f"{task:<32}{times['best']:>10,.1f}" + "".join(cells), flush=True)


def looped(call: Callable[..., Any], columns: list[list[np.ndarray]]) -> None:
    deque(map(call, *columns), maxlen=0)


def alike(pair: Pair, task: str, states: States) -> None:
    """Refuse to time what differs."""
    call, columns = pair.theirs(states)[task]
    found = call(*(x[0] for x in columns))
    names = list(pair.pin.names)[1:]
    order = np.argsort([states.names.index(n) for n in names])
    ours = getattr(fb, task)(pair.model, *(x[0] for x in states.arguments(task)))
    ours = ours[0] if isinstance(ours, tuple) else ours
    if task == "forward_kinematics":
        theirs = found.homogeneous
    elif "derivatives" in task:
        theirs = found[0][np.ix_(order, order)]
    elif task == "mass_matrix":
        theirs = (np.triu(found) + np.triu(found, 1).T)[np.ix_(order, order)]
    else:
        theirs = np.asarray(found)[..., order]
    apart = np.abs(ours - theirs).max() / np.abs(theirs).max()
    if apart > AGREE:
        raise SystemExit(f"{task} differs by {apart:.1e}: its times would say nothing")


def timed(runs: dict[str, tuple[Callable[[], Any], int]], rounds: int) -> dict[str, float]:
    """Nanoseconds a sample, each run as often in a round as takes a few milliseconds."""
    many = {}
    for name, (run, samples) in runs.items():
        once = quickest({name: run}, 3)[name]
        times = max(1, int(5e-3 / max(once, 1e-7)))
        many[name] = (partial(repeated, run, times), times * samples)
    least = quickest({name: run for name, (run, _) in many.items()}, rounds)
    return {name: 1e9 * least[name] / count for name, (_, count) in many.items()}


def repeated(run: Callable[[], Any], times: int) -> None:
    for _ in range(times):
        run()


def together(pair: Pair, sizes: list[int], rounds: int) -> None:
    """Several quantities in one kernel, and one after the other."""
    one: Any = fb.kernel(pair.model, TOGETHER)
    each = [fb.kernel(pair.model, name) for name in TOGETHER]
    print(f"\n{', '.join(TOGETHER)}: one kernel beside five, ns a sample")
    for B in sizes:
        q, qd = pair.states(B).arguments("bias")[0], pair.states(B).qd
        apart = [
            partial(k, *((q, qd) if len(k.program.inputs) > 1 else (q,)), threads=1) for k in each
        ]
        runs: dict[str, tuple[Callable[[], Any], int]] = {
            "one": (partial(one, q, qd, threads=1), B),
            "five": (lambda runs=apart: [run() for run in runs], B),
        }
        times = timed(runs, rounds)
        print(f"{f'B = {B}':>32}{times['one']:>10,.1f}{times['five']:>10,.1f}")


def inverse_kinematics(sizes: list[int], rounds: int) -> None:
    """Random poses as they come, in pieces of each size, beside EAIK where it has the arm."""
    print("\ninverse kinematics, µs a pose, every pose" + "".join(f"{B:>9}" for B in sizes))
    total = max(20_000, *sizes)
    for name in BRANCHES:
        model = load(name)
        q, T = random_poses(model, total, 5)
        runs: dict[str, tuple[Callable[[], Any], int]] = {}
        for B in sizes:
            count = min(total // B, 2000)
            pieces: list[tuple[Any, dict[str, Any]]] = []
            for k in range(count):
                some = k if B == 1 else slice(k * B, k * B + B)
                held = {"redundancy": q[some, 6].copy()} if model.nq > 6 else {}
                pieces.append((T[some].copy(), held))
            runs[str(B)] = (partial(solved, model, pieces), count * B)
        rival = eaik(model, T[:AT_ONCE])
        if rival is not None:
            runs["EAIK"] = (rival, AT_ONCE)
        times = timed(runs, rounds)
        peer = f"   EAIK {times['EAIK'] / 1e3:.2f}" if rival else ""
        print(f"{name:<41}" + "".join(f"{times[str(B)] / 1e3:>9.3f}" for B in sizes) + peer)


def solved(model: fb.Model, pieces: list[tuple[Any, dict[str, Any]]]) -> None:
    for target, held in pieces:
        fb.inverse_kinematics(model, target, **held)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="*", choices=ROBOTS, default=["ur5", "panda"])
    parser.add_argument("--sizes", nargs="+", type=int, default=list(SIZES))
    parser.add_argument("--rounds", type=int, default=7)
    parser.add_argument("--only", nargs="+", default=[], help="quantities; inverse_kinematics")
    parser.add_argument("--calibrated", action="store_true", help="calibrated robots too")
    given = parser.parse_args()
    quantities = [name for name in given.only if name != "inverse_kinematics"]
    for name in given.robots if quantities or not given.only else ():
        for moved in (False, True) if given.calibrated else (False,):
            pair = Pair(name, moved)
            title = f"{name}, calibrated" if moved else name
            dynamics(pair, title, given.sizes, given.rounds, quantities)
            if not quantities and not moved:
                together(pair, given.sizes, given.rounds)
    if not given.only or "inverse_kinematics" in given.only:
        inverse_kinematics([B for B in given.sizes if B <= 20_000] or [1], given.rounds)


if __name__ == "__main__":
    main()
