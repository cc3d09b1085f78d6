"""What it costs that numbers are inputs, or have 32 bits: the time of one sample in a batch, on one
thread.

    python benchmarks/inputs.py [--robots ur5e ur5 panda talos] [--zeros] [--batch 4096]
        [--rounds 100]

Beside the kernel of fixed numbers stand the same kernel with `inputs=` the masses, centres,
inertias and lengths of the robot that are not zero (of a UR5e 59; with `--zeros`, all ten numbers
of each of its bodies: 66): one value for the batch, and one for every sample; the public function
for one robot and, beside it, for a family of as many different ones as there are samples; and the
kernel in float32, with its error against float64 relative to a sample's largest entry. Rounds are
interleaved; times are the quickest round's.
"""

import argparse
import os

os.environ.update(
    OMP_NUM_THREADS="1", OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", FREEBODY_CACHE="off"
)

from dataclasses import replace
from functools import partial

import numpy as np

import freebody as fb
from against import ROBOTS
from common import quickest, robots_folder
from freebody.model.inertia import combined
from freebody.model.quantity_reader import VALUES
from freebody.model.tree import Attached
from freebody.spatial import of_dimension

TASKS = ("inverse_dynamics", "forward_dynamics")
LENGTHS = {
    "a",
    "d",
    "alpha",
    "theta",
    *(f"placement.{x}" for x in ("x", "y", "z", "roll", "pitch", "yaw")),
}


def lumped(model: fb.Model) -> fb.Model:
    """The model with one inertia a body, as the kernel of fixed numbers has them."""
    space = of_dimension(model.dim)
    bodies = []
    for body in model.bodies:
        moved = [
            x.inertia.placed(*x.placement.lower(space, VALUES))
            for x in body.inertias
            if x.inertia.mass
        ]
        bodies.append(
            replace(body, inertias=(Attached(body.name, combined(moved)),) if moved else ())
        )
    return replace(model, bodies=tuple(bodies))


def named(model: fb.Model, zeros: bool) -> list[str]:
    """Masses, centres, inertias, lengths and angles; a right angle of a placement stays
    structure."""
    inertial = {
        "mass",
        *(f"com.{x}" for x in "xyz"),
        *(f"inertia.{x}{y}" for x in "xyz" for y in "xyz"),
    }
    empty = {
        r.name.split(".")[0]
        for r in fb.parameters(model)
        if r.name.endswith(".mass") and not r.value
    }
    found = []
    for record in fb.parameters(model):
        owner, _, number = record.name.partition(".")
        meant = not record.structural and (
            number in LENGTHS or (number in inertial and owner not in empty)
        )
        if meant and (record.value or (zeros and number in inertial)):
            found.append(record.name)
    return found


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--robots", nargs="+", default=["ur5e", "ur5", "panda", "talos"])
    parser.add_argument(
        "--zeros", action="store_true", help="also those of a body's numbers that are zero"
    )
    parser.add_argument("--batch", type=int, default=4096)
    parser.add_argument("--rounds", type=int, default=100)
    given = parser.parse_args()
    if hasattr(os, "sched_setaffinity"):  # public functions take the threads that are there
        os.sched_setaffinity(0, {min(os.sched_getaffinity(0))})
    rng = np.random.default_rng(20261122)
    head = (
        "fixed",
        "uniform",
        "a sample",
        "float32",
        "function",
        "family",
        "error: median",
        "greatest",
    )
    print(f"{'':<26}{'numbers':>8}" + "".join(f"{title:>19}" for title in head))
    for robot in given.robots:
        if robot in ROBOTS:
            file, tip = ROBOTS[robot]
            model = fb.load(robots_folder() / file, mimic="free", tip=tip, physical="ignore")
        else:
            model = fb.load(robot)
        model = lumped(model.without("friction"))
        heavier, longer = rng.uniform(0.9, 1.1, (2, given.batch))
        for task in TASKS:
            wide, short = fb.kernel(model, task), fb.kernel(model, task, dtype="float32")
            open_ = fb.kernel(model, task, inputs=named(model, given.zeros))
            numbers = np.array(open_.values)
            q = rng.uniform(-1, 1, (3, given.batch, model.nv))
            rounded, each = q.astype(np.float32), np.tile(numbers, (given.batch, 1))
            for column, name in enumerate(open_.parameters):  # what is physical stays so
                if ".com." not in name:
                    each[:, column] *= heavier if ".mass" in name or ".inertia" in name else longer
            family = model.bind(dict(zip(open_.parameters, each.T, strict=True)))
            out, out32 = wide(*q), short(*rounded)
            scale = np.abs(out).max(axis=1)
            assert np.abs(open_(*q, numbers) - out).max() <= 1e-9 * scale.max()
            error = np.abs(out32 - out).max(axis=1) / scale
            function = getattr(fb, task)
            apart = np.abs(open_(*q, each) - function(family, *q)).max(axis=1)
            assert (apart <= 1e-9 * scale).all()
            wanted = {
                "fixed": (wide, q, np.empty_like(out)),
                "uniform": (open_, (*q, numbers), np.empty_like(out)),
                "a sample": (open_, (*q, each), np.empty_like(out)),
                "float32": (short, rounded, np.empty_like(out32)),
            }
            runs = {
                title: partial(k, *x, out=into, threads=1) for title, (k, x, into) in wanted.items()
            }
            runs |= {
                "function": partial(function, model, *q),
                "family": partial(function, family, *q),
            }
            found = quickest(runs, given.rounds, warm=True)
            each = {title: 1e9 * time / given.batch for title, time in found.items()}
            beside = {"family": "function"}
            cells = [
                f"{each[x]:.1f} ns, {each[x] / each[beside.get(x, 'fixed')]:.2f}" for x in head[:-2]
            ]
            cells += [f"{np.median(error):.1e}", f"{error.max():.1e}"]
            print(
                f"{robot + ' ' + task:<26}{len(numbers):>8}"
                + "".join(f"{cell:>19}" for cell in cells),
                flush=True,
            )


if __name__ == "__main__":
    main()
