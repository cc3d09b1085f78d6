"""Robots without zeros and right angles beside Pinocchio: what calibration costs, and long chains.

    python benchmarks/without_zeros.py [--rounds 15] [--joints 30 60]

UR5 and Panda as their files have them, and with the origin of every joint off by about a millimetre
and a milliradian, as a factory measures them: operations, one sample of a batch, and Pinocchio's
time for it. Then chains whose axes and offsets have any direction: the mass matrix, one call of the
kernel and of the public function, and a batch. Rounds are interleaved, and the quickest counts; one
thread.
"""

import argparse
import os
import tempfile
import warnings

os.environ.update(
    OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", FREEBODY_CACHE="off"
)

from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pinocchio as pin

import freebody as fb
from common import processor, quickest, robots_folder
from compare import ROBOTS, bare

BATCH = 4096
OFF = 1e-3
LIMIT = '<limit lower="-3" upper="3" effort="1" velocity="1"/>'
TASKS = {"inverse_dynamics": 3, "mass_matrix": 1, "forward_dynamics": 3}


def calibrated(urdf: str, seed: int = 5) -> str:
    """The file with every joint's origin off by about `OFF` (m, rad)."""
    root, rng = ElementTree.fromstring(urdf), np.random.default_rng(seed)
    for joint in root.findall("joint"):
        origin = joint.find("origin")
        if origin is None:
            origin = ElementTree.SubElement(joint, "origin")
        for name in ("xyz", "rpy"):
            entries = np.array([float(x) for x in origin.get(name, "0 0 0").split()])
            origin.set(name, numbers(entries + OFF * rng.normal(size=3)))
    return ElementTree.tostring(root, encoding="unicode")


def chain(n: int, seed: int = 1) -> str:
    """A URDF of n revolute joints with axes and offsets in any direction."""
    rng = np.random.default_rng(seed)
    parts = ['<robot name="chain"><link name="l0"/>']
    for i in range(n):
        axis = rng.normal(size=3)
        A = rng.normal(scale=0.03, size=(3, 3))
        second = A @ A.T + 1e-4 * np.eye(3)
        mass = rng.uniform(0.1, 1.0)
        inertia = mass * (np.trace(second) * np.eye(3) - second)
        entries = " ".join(
            f'i{"xyz"[r]}{"xyz"[c]}="{inertia[r, c]}"' for r in range(3) for c in range(r, 3)
        )
        place = numbers(rng.uniform(-0.1, 0.1, 3)), numbers(rng.uniform(-1.5, 1.5, 3))
        parts.append(
            f'<joint name="j{i}" type="revolute">{LIMIT}'
            f'<parent link="l{i}"/><child link="l{i + 1}"/>'
            f'<origin xyz="{place[0]}" rpy="{place[1]}"/>'
            f'<axis xyz="{numbers(axis / np.linalg.norm(axis))}"/></joint>'
            f'<link name="l{i + 1}"><inertial>'
            f'<origin xyz="{numbers(rng.uniform(-0.05, 0.05, 3))}"/>'
            f'<mass value="{mass}"/><inertia {entries}/></inertial></link>'
        )
    return "".join((*parts, "</robot>"))


def numbers(entries: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in entries)


def pinocchio_loops(model: pin.Model, q: np.ndarray, qd: np.ndarray, last: np.ndarray):
    """A function for each task that goes through the batch."""
    data, pool = model.createData(), pin.ModelPool(model, 1)
    columns = [np.asfortranarray(x.T) for x in (q, qd, last)]
    out = np.empty_like(columns[0])

    def mass_matrices() -> None:
        for row in q:
            pin.crba(model, data, row)

    return {
        "inverse_dynamics": lambda: pin.rneaInParallel(1, pool, *columns, out),
        "forward_dynamics": lambda: pin.abaInParallel(1, pool, *columns, out),
        "mass_matrix": mass_matrices,
    }


def loaded(urdf: str) -> tuple[fb.Model, pin.Model]:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "robot.urdf")
        path.write_text(urdf)
        ours = fb.load(path, physical="ignore").without("friction", "rotors", "springs")
    return ours, pin.buildModelFromXML(urdf)


def states(model: fb.Model, theirs: pin.Model, batch: int) -> tuple[list, list]:
    """Positions, rates and accelerations, in our order and in Pinocchio's."""
    ours = list(np.random.default_rng(20261123).uniform(-1, 1, (3, batch, model.nv)))
    joints = sorted(range(1, theirs.njoints), key=lambda i: theirs.idx_vs[i])
    order = [model.joint_names.index(theirs.names[i]) for i in joints]
    return ours, [np.ascontiguousarray(x[:, order]) for x in ours]


def arms(rounds: int) -> None:
    print(f"\n{'':<38}{'operations':>11}{'ns a sample':>13}{'Pinocchio':>11}{'ratio':>8}")
    for robot in ("ur5", "panda"):
        nominal = bare(robots_folder() / ROBOTS[robot][0])
        for name, urdf in (("as in the file", nominal), ("calibrated", calibrated(nominal))):
            model, theirs = loaded(urdf)
            ours, there = states(model, theirs, BATCH)
            loops = pinocchio_loops(theirs, *there)
            runs: dict[str, Callable[[], object]] = {}
            count = {}
            for task, taken in TASKS.items():
                kernel = fb.kernel(model, task)
                count[task] = sum(kernel.program.operations.values())
                given, out = ours[:taken], kernel(*ours[:taken])
                runs[task] = lambda k=kernel, g=given, o=out: k(*g, out=o, threads=1)
                runs[f"pin {task}"] = loops[task]
            least = quickest(runs, rounds, warm=True)
            for task in TASKS:
                own, other = (1e9 * least[key] / BATCH for key in (task, f"pin {task}"))
                print(
                    f"{f'{robot} {name}, {task}':<38}{count[task]:>11,}{own:>13.1f}{other:>11,.0f}"
                    f"{other / own:>7.1f}x",
                    flush=True,
                )


def chains(joints: list[int], rounds: int) -> None:
    print(f"\n{'mass matrix, µs':<20}{'operations':>11}{'kernel':>9}{'function':>10}", end="")
    print(f"{'Pinocchio':>11}{'kernel / P.':>13}{'in a batch':>12}{'difference':>12}")
    for n in joints:
        urdf = chain(n)
        model, theirs = loaded(urdf)
        data, (ours, there) = theirs.createData(), states(model, theirs, 512)
        kernel, q = fb.kernel(model, "mass_matrix"), ours[0][0].copy()
        there_q, out = there[0][0].copy(), kernel(ours[0])
        upper = np.triu(pin.crba(theirs, data, there_q))
        off = np.abs(np.triu(kernel(q)) - upper).max() / np.abs(upper).max()
        calls = {
            "kernel": lambda k=kernel, q=q: k(q),
            "function": lambda m=model, q=q: fb.mass_matrix(m, q),
            "pin": lambda m=theirs, d=data, q=there_q: pin.crba(m, d, q),
        }
        least = quickest(calls, rounds, times=200)
        batch = quickest({"": lambda k=kernel, g=ours[0], o=out: k(g, out=o, threads=1)}, rounds)
        print(
            f"{n:>6} joints{'':<7}{sum(kernel.program.operations.values()):>11,}"
            + "".join(f"{1e6 * least[x]:>{w}.2f}" for x, w in zip(calls, (9, 10, 11), strict=True))
            + f"{least['kernel'] / least['pin']:>13.2f}{1e6 * batch[''] / 512:>12.2f}{off:>12.0e}",
            flush=True,
        )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--joints", type=int, nargs="*", default=[30, 60])
    given = parser.parse_args()
    warnings.simplefilter("ignore")  # of what a chain at random looks like
    print(f"{processor()}; batches of {BATCH}, of chains 512; freebody from {fb.__file__}")
    arms(given.rounds)
    chains(given.joints, given.rounds)


if __name__ == "__main__":
    main()
