"""Exported C and JavaScript beside Pinocchio's C++: the time of one call, interleaved in one
process.

    python benchmarks/exported.py [--robots ur5e panda] [--rounds 15]

Needs gcc, g++, Eigen (Debian: libeigen3-dev) and the wheel `pin`, whose headers are compiled here
with -O3 -march=native as the exported C is; node, if it is there, runs the exported JavaScript.
Pinocchio's model is written in C++ from freebody's own: the same joints, placements and inertias,
without friction and rotors. Results are compared before times are taken.
"""

from __future__ import annotations

import argparse
import os
import platform
import shutil
import subprocess
import sysconfig
import tempfile
from pathlib import Path

import numpy as np

import freebody as fb
from compare import bare, cpu, robots_folder

TASKS = {  # quantity: (Pinocchio's header, call, result)
    "inverse_dynamics": ("rnea", "rnea(model, data, q, a, b)", "data.tau"),
    "forward_dynamics": ("aba", "aba(model, data, q, a, b)", "data.ddq"),
    "mass_matrix": ("crba", "crba(model, data, q)", "data.M"),
    "inverse_dynamics_derivatives": (
        "rnea-derivatives",
        "computeRNEADerivatives(model, data, q, a, b)",
        "data.dtau_dq",
    ),
}
BOOST = (  # what Pinocchio's own CMake files define
    "-DBOOST_MPL_LIMIT_LIST_SIZE=30",
    "-DBOOST_MPL_LIMIT_VECTOR_SIZE=30",
    "-DBOOST_MPL_CFG_NO_PREPROCESSED_HEADERS",
    "-DBOOST_FUSION_INVOKE_MAX_ARITY=12",
)
STATES = 256  # inputs that are gone through, so that no branch or cache learns one


def load(robot: str) -> fb.Model:
    """Bundled, or the Panda with its fingers from example-robot-data; without what Pinocchio leaves
    out."""
    if robot == "panda":
        text = bare(robots_folder() / "panda_description/urdf/panda.urdf")
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "panda.urdf"
            path.write_text(text)
            return fb.load(path, mimic="free", physical="ignore")
    return fb.load(robot).without("friction", "rotors", "springs")


def model_in_cpp(model: fb.Model) -> str:
    """Statements that build the model; joints of one axis."""
    lines = []
    for k, body in enumerate(model.tree.bodies):
        R = ", ".join(repr(float(x)) for row in body.R for x in row)
        p = ", ".join(repr(float(x)) for x in body.p)
        kind = "P" if model.bodies[k].joint.kind == "prismatic" else "R"
        axis = tuple(float(x) for x in body.axis)
        units = {(1.0, 0.0, 0.0): "X", (0.0, 1.0, 0.0): "Y", (0.0, 0.0, 1.0): "Z"}
        long = "Revolute" if kind == "R" else "Prismatic"
        joint = (
            f"JointModel{kind}{units[axis]}()"
            if axis in units
            else f"JointModel{long}Unaligned{axis}"
        )
        lines.append(
            f"R << {R}; p << {p}; id = model.addJoint({body.parent + 1}, {joint}, SE3(R, p), "
            f'"j{k}");'
        )
        for mass in body.masses:
            c = ", ".join(repr(float(x)) for x in mass.c)
            inertia = ", ".join(repr(float(x)) for row in mass.inertia for x in row)
            lines.append(
                f"R << {inertia}; p << {c}; model.appendBodyToJoint(id, Inertia({float(mass.m)!r}, "
                f"p, R));"
            )
    gx, gy, gz = (float(x) for x in model.gravity)
    return "\n  ".join([*lines, f"model.gravity.linear() << {gx}, {gy}, {gz};"])


def program(
    model: fb.Model, task: str, q: np.ndarray, a: np.ndarray, b: np.ndarray, rounds: int
) -> str:
    """C++ that compares and times both."""
    header, call, result = TASKS[task]
    n, size = (
        model.nv,
        {"mass_matrix": model.nv**2, "inverse_dynamics_derivatives": 3 * model.nv**2}.get(
            task, model.nv
        ),
    )
    arguments = {
        "mass_matrix": "Q[i], out",
        "inverse_dynamics_derivatives": f"Q[i], A[i], B[i], out, out + {n * n}, out + {2 * n * n}",
    }.get(task, "Q[i], A[i], B[i], out")
    tables = "\n".join(
        f"static double {name}[{STATES}][{n}] = "
        f"{str(x.tolist()).replace('[', '{').replace(']', '}')};"
        for name, x in (("Q", q), ("A", a), ("B", b))
    )
    return f"""#include <pinocchio/multibody.hpp>
#include <pinocchio/algorithm/{header}.hpp>
#include <chrono>
#include <cstdio>
#include <vector>
#include "f.h"
using namespace pinocchio;
{tables}
static double out[{size}];
static double now() {{
  const auto since = std::chrono::steady_clock::now().time_since_epoch();
  return std::chrono::duration<double, std::nano>(since).count();
}}
int main() {{
  Model model; Eigen::Matrix3d R; Eigen::Vector3d p; JointIndex id;
  {model_in_cpp(model)}
  Data data(model);
  std::vector<Eigen::VectorXd> qs, as, bs;
  for (int i = 0; i < {STATES}; i++) {{
    qs.push_back(Eigen::Map<Eigen::VectorXd>(Q[i], {n}));
    as.push_back(Eigen::Map<Eigen::VectorXd>(A[i], {n}));
    bs.push_back(Eigen::Map<Eigen::VectorXd>(B[i], {n}));
  }}
  double off = 0, largest = 0;
  for (int i = 0; i < {STATES}; i++) {{
    const Eigen::VectorXd &q = qs[i], &a = as[i], &b = bs[i]; (void)a; (void)b;
    {call};
    f({arguments});
    for (int r = 0; r < {result}.rows(); r++) for (int c = 0; c < {result}.cols(); c++) {{
      if (c < r && {int(task == "mass_matrix")}) continue;
      const double x = {result}(r, c);
      off = std::max(off, std::abs(x - out[r * {result}.cols() + c]));
      largest = std::max(largest, std::abs(x));
    }}
  }}
  double mine = 1e30, theirs = 1e30;
  for (int k = 0; k < {rounds}; k++) {{
    double t = now();
    for (int j = 0; j < 20; j++) for (int i = 0; i < {STATES}; i++) {{
      const Eigen::VectorXd &q = qs[i], &a = as[i], &b = bs[i]; (void)a; (void)b; {call};
    }}
    theirs = std::min(theirs, (now() - t) / (20 * {STATES}));
    t = now();
    for (int j = 0; j < 20; j++) for (int i = 0; i < {STATES}; i++) f({arguments});
    mine = std::min(mine, (now() - t) / (20 * {STATES}));
  }}
  std::printf("%.17g %.17g %.3g\\n", mine, theirs, off / largest);
}}
"""


def script(q: np.ndarray, a: np.ndarray, b: np.ndarray, task: str, rounds: int) -> str:
    """JavaScript that times the exported module."""
    count = {"mass_matrix": 1}.get(task, 3)
    given = ", ".join(f"X[{k}][i]" for k in range(count))
    n = q.shape[1]
    outs = {"mass_matrix": [n * n], "inverse_dynamics_derivatives": [n * n] * 3}.get(task, [n])
    made = ", ".join(f"new Float64Array({size})" for size in outs)
    return f"""import {{ f }} from "./f.mjs";
const rows = {[x.tolist() for x in (q, a, b)]!r};
const X = rows.map((each) => each.map((row) => new Float64Array(row)));
const outs = [{made}];
let best = Infinity;
for (let k = 0; k < {rounds}; k++) {{
  const t = process.hrtime.bigint();
  for (let j = 0; j < 20; j++) for (let i = 0; i < {STATES}; i++) f({given}, ...outs);
  best = Math.min(best, Number(process.hrtime.bigint() - t) / (20 * {STATES}));
}}
console.log(best);
"""


def compare(robot: str, task: str, rounds: int, eigen: str) -> None:
    """One line: freebody's C, Pinocchio's C++, the ratio, JavaScript, their difference."""
    model = load(robot)
    q, a, b = (np.asarray(x) for x in fb.random_state(model, 0, STATES))
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        for language in ("c", "javascript"):
            fb.export(model, task, folder / language, language, name="f")
        (folder / "run.cpp").write_text(program(model, task, q, a, b, rounds))
        include = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/include"
        quick = ["-O3", "-march=native"]
        subprocess.run(
            ["gcc", "-std=c99", *quick, "-c", "c/f.c", "-o", "f.o"], cwd=folder, check=True
        )
        subprocess.run(
            ["g++", "-std=c++17", *quick, "-w", "-DNDEBUG", *BOOST, "-isystem", include, "-isystem",
             eigen, "-Ic",
             "run.cpp", "f.o", "-lm", "-o", "run"],
            cwd=folder, check=True,
        )  # fmt: skip
        told = subprocess.run([folder / "run"], capture_output=True, text=True, check=True).stdout
        mine, theirs, off = map(float, told.split())
        script_time = float("nan")
        if shutil.which("node"):
            (folder / "javascript/run.mjs").write_text(script(q, a, b, task, rounds))
            told = subprocess.run(
                ["node", "run.mjs"],
                cwd=folder / "javascript",
                capture_output=True,
                text=True,
                check=True,
            ).stdout
            script_time = float(told)
        size = (folder / "c/f.c").stat().st_size / 1000
    assert off < 1e-9, f"{robot} {task}: results differ by {off:.2g}"
    print(
        f"{robot:8} {task:30} {mine:8.0f} {theirs:8.0f} {mine / theirs:7.2f} {script_time:8.0f} "
        f"{script_time / mine:7.2f} {size:8.0f} {off:9.1e}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=["ur5e", "panda"])
    parser.add_argument("--tasks", nargs="+", default=list(TASKS))
    parser.add_argument("--rounds", type=int, default=15)
    parser.add_argument("--eigen", default=os.environ.get("EIGEN", "/usr/include/eigen3"))
    given = parser.parse_args()
    print(
        f"{cpu()}; Python {platform.python_version()}, freebody {fb.__version__}; ns a call, best "
        f"of {given.rounds}"
    )
    print(
        f"{'robot':8} {'quantity':30} {'C':>8} {'C++ pin':>8} {'ratio':>7} {'JS':>8} {'JS/C':>7} "
        f"{'C kB':>8} {'off':>9}"
    )
    for robot in given.robots:
        for task in given.tasks:
            compare(robot, task, given.rounds, given.eigen)


if __name__ == "__main__":
    main()
