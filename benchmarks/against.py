"""freebody at two commits: the time of each row of docs/benchmarks.md's first tables, as a ratio.

    python benchmarks/against.py BEFORE [AFTER] [--robots ur5 panda talos] [--runs 5]
        [--dtype float64]

Each commit is checked out into a folder of its own. Processes of both take turns, so that a machine
that slows down slows both; within a process a row's time is the quickest of its rounds. AFTER is
HEAD by default; `.` is the working tree.
"""

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from common import robots_folder, seconds

ROBOTS = {  # name: (file below robots/, tip)
    "ur5": ("ur_description/urdf/ur5_robot.urdf", "ee_link"),
    "panda": ("panda_description/urdf/panda.urdf", "panda_hand"),
    "talos": ("talos_data/robots/talos_reduced.urdf", "gripper_left_base_link"),
}
TASKS = {
    "inverse_dynamics": "inverse_dynamics",
    "forward_dynamics": "forward_dynamics",
    "mass_matrix": "mass_matrix",
    "tip pose and Jacobian": ("forward_kinematics", "jacobian"),
    "inverse_dynamics_derivatives": "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives": "forward_dynamics_derivatives",
}
BATCH = 4096
ROUNDS = 15
LIMIT = 1.05
"""Ratios above it are marked."""


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("before")
    parser.add_argument("after", nargs="?", default="HEAD")
    parser.add_argument("--robots", nargs="+", choices=ROBOTS, default=list(ROBOTS))
    parser.add_argument("--runs", type=int, default=5)
    parser.add_argument("--dtype", default="float64")
    parser.add_argument("--measure", action="store_true", help=argparse.SUPPRESS)
    given = parser.parse_args()
    if given.measure:
        print(json.dumps(measured(given.robots, given.dtype)))
        return 0
    with tempfile.TemporaryDirectory() as folder:
        trees = [
            checked_out(commit, Path(folder, name))
            for name, commit in zip("ba", (given.before, given.after), strict=True)
        ]
        try:
            found = [[run(tree, given) for tree in trees] for _ in range(given.runs)]
        finally:
            for tree in trees:
                if tree.is_relative_to(folder):
                    git("worktree", "remove", "--force", str(tree))
    return report([before for before, _ in found], [after for _, after in found])


def git(*arguments: str) -> str:
    return subprocess.run(
        ["git", *arguments], check=True, capture_output=True, text=True
    ).stdout.strip()


def checked_out(commit: str, folder: Path) -> Path:
    """The folder in which a commit is; of `.` the working tree itself."""
    if commit == ".":
        return Path(git("rev-parse", "--show-toplevel"))
    git("worktree", "add", "--detach", str(folder), commit)
    return folder


def run(tree: Path, given: argparse.Namespace) -> dict[str, float]:
    """Times of all rows, by a process that imports freebody from that folder."""
    threads = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")
    environment = os.environ | threads | {"PYTHONPATH": str(tree / "src"), "FREEBODY_CACHE": "off"}
    command = [
        sys.executable,
        __file__,
        "-",
        "--measure",
        "--dtype",
        given.dtype,
        "--robots",
        *given.robots,
    ]
    done = subprocess.run(command, env=environment, check=True, stdout=subprocess.PIPE, text=True)
    return json.loads(done.stdout)


def measured(robots: list[str], dtype: str) -> dict[str, float]:
    """Nanoseconds: of a sample in a batch, of one call of the kernel and of the public function; of
    compiling, and of a process up to its first kernel (CPU)."""
    import freebody as fb

    options = {} if dtype == "float64" else {"dtype": dtype}
    rows: dict[str, float] = {}
    for robot in robots:
        file, tip = ROBOTS[robot]
        model = fb.load(robots_folder() / file, mimic="free", tip=tip, physical="ignore").without(
            "friction"
        )
        if not rows:  # what the first one imports is no compiling
            fb.kernel(model, "gravity_torque", **options)
            rows["import, first robot and first kernel"] = time.process_time() * 1e9
        rng = np.random.default_rng(20261101)
        for task, names in TASKS.items():
            start = time.process_time()
            kernel = fb.kernel(model, names, **options)
            rows[f"{robot}, {task}, compiling"] = (time.process_time() - start) * 1e9
            given = [
                rng.uniform(-1, 1, (BATCH, *x.shape)).astype(dtype) for x in kernel.program.inputs
            ]
            one = [x[0] for x in given]
            batch = partial(kernel, *given, out=kernel(*given), threads=1)
            rows[f"{robot}, {task}, batch"] = quickest(batch) / BATCH
            rows[f"{robot}, {task}, one call"] = quickest(partial(kernel, *one), 300)
            if hasattr(fb, task) and dtype == "float64":
                public = partial(getattr(fb, task), model, *one)
                rows[f"{robot}, {task}, function, one call"] = quickest(public, 300)
    return rows


def quickest(call: Callable[[], object], times: int = 3) -> float:
    """Nanoseconds of a call: the mean of `times`, in the quickest of some rounds."""
    return 1e9 * min(seconds(call, times, time.perf_counter) for _ in range(ROUNDS))


def report(before: list[dict[str, float]], after: list[dict[str, float]]) -> int:
    """Print each row; how many are slower by more than the limit."""
    print(
        f"{'':<52}{'before, ns':>14}{'after, ns':>14}{'after / before':>16}{'of single pairs':>18}"
    )
    slower = 0
    for row in before[0]:
        old, new = (np.array([run[row] for run in runs]) for runs in (before, after))
        ratio = np.median(new) / np.median(old)
        pairs = new / old
        slower += ratio > LIMIT
        mark = "  slower" if ratio > LIMIT else ""
        print(
            f"{row:<52}{np.median(old):>14,.1f}{np.median(new):>14,.1f}{ratio:>16.3f}"
            f"{f'{pairs.min():.2f} .. {pairs.max():.2f}':>18}{mark}"
        )
    print(f"\n{slower} of {len(before[0])} rows slower by more than {LIMIT - 1:.0%}.")
    return int(slower > 0)


if __name__ == "__main__":
    sys.exit(main())
