"""The table of exported text: for each language and quantity its size, its time and its difference
from the kernel.

    python benchmarks/ways_out.py [--robots ur5e panda] [--languages C JavaScript …]
        [--quantities …] [--rounds 7]

Each text is called for 256 random states, as a program of its language would; results are compared
with the kernel's, relative to an output's largest entry. Tools that are not there are left out:
gcc, g++, node, rustc, octave, casadi. Prints two tables of Markdown: nanoseconds in each language;
then kilobytes, with the largest difference of all that compute in double, and of those in float.
"""

from __future__ import annotations

import argparse
import platform
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import accumulate
from pathlib import Path

import numpy as np

import freebody as fb
from compare import cpu
from freebody.program import Argument

QUANTITIES = (
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "forward_kinematics",
    "jacobian",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
    "rk4_step",
)
DTYPES = ("float64", "float32")
STATES = 256
INPUTS, OUTPUTS = "given.bin", "found.bin"
"""Files of doubles, (STATES, all scalars of the inputs), and what the program writes of the
outputs."""


@dataclass(frozen=True)
class Task:
    """One function: its inputs and outputs, and how many calls make a round."""

    inputs: tuple[Argument, ...]
    outputs: tuple[Argument, ...]
    rounds: int
    repeats: int

    def spans(self, arguments: Sequence[Argument]) -> list[tuple[int, int]]:
        """Where each argument begins among all scalars, and its size."""
        sizes = [a.size for a in arguments]
        return list(zip(accumulate([0, *sizes[:-1]]), sizes, strict=True))

    @property
    def sizes(self) -> tuple[int, int]:
        """Scalars of the inputs and of the outputs."""
        return sum(a.size for a in self.inputs), sum(a.size for a in self.outputs)


def in_c(task: Task, name: str, include: str, number: str = "double") -> dict[str, str]:
    """C, and C++ too."""
    m, n = task.sizes
    ins = [
        f"in[i] + {at}" if a.shape else f"in[i][{at}]"
        for a, (at, _) in zip(task.inputs, task.spans(task.inputs), strict=True)
    ]
    outs = [f"out[i] + {at}" for at, _ in task.spans(task.outputs)]
    return {
        name: f"""#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <time.h>
#include "{include}"
static double file[{STATES}*{max(m, n)}];
static {number} in[{STATES}][{m}], out[{STATES}][{n}];
static double now(void) {{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e9*(double)t.tv_sec + (double)t.tv_nsec;
}}
int main(void) {{
    FILE *f = fopen("{INPUTS}", "rb");
    if (!f || fread(file, 8, {STATES}*{m}, f) != {STATES}*{m}) return 1;
    for (int i = 0; i < {STATES}; i++)
        for (int k = 0; k < {m}; k++) in[i][k] = ({number})file[i*{m} + k];
    double best = 1e30;
    for (int r = 0; r < {task.rounds}; r++) {{
        const double t = now();
        for (int j = 0; j < {task.repeats}; j++)
            for (int i = 0; i < {STATES}; i++) f_({", ".join(ins + outs)});
        const double took = (now() - t)/({task.repeats}.0*{STATES});
        if (took < best) best = took;
    }}
    for (int i = 0; i < {STATES}; i++)
        for (int k = 0; k < {n}; k++) file[i*{n} + k] = (double)out[i][k];
    f = fopen("{OUTPUTS}", "wb");
    if (!f || fwrite(file, 8, {STATES}*{n}, f) != {STATES}*{n} || fclose(f)) return 1;
    printf("%.9g\\n", best);
    return 0;
}}
"""
    }


def in_javascript(task: Task) -> dict[str, str]:
    """Node.js: arrays of their own for each call, as a page has them."""
    m, _ = task.sizes
    ins = [
        f"x.slice({at}, {at + size})" if a.shape else f"x[{at}]"
        for a, (at, size) in zip(task.inputs, task.spans(task.inputs), strict=True)
    ]
    outs = [f"new Float64Array({a.size})" for a in task.outputs]
    arguments = ", ".join(f"c[{k}]" for k in range(len(ins + outs)))
    return {
        "run.mjs": f"""import {{ f_ }} from "./f_.mjs";
import fs from "fs";
const file = fs.readFileSync("{INPUTS}");
const all = new Float64Array(file.buffer.slice(file.byteOffset, file.byteOffset + file.length));
const calls = [];
for (let i = 0; i < {STATES}; i++) {{
  const x = all.slice(i*{m}, (i + 1)*{m});
  calls.push([{", ".join(ins + outs)}]);
}}
let best = Infinity;
for (let r = 0; r < {task.rounds}; r++) {{
  const t = process.hrtime.bigint();
  for (let j = 0; j < {task.repeats}; j++) for (const c of calls) f_({arguments});
  best = Math.min(best, Number(process.hrtime.bigint() - t)/({task.repeats}*{STATES}));
}}
const found = calls.flatMap((c) => c.slice({len(ins)}).flatMap((y) => [...y]));
fs.writeFileSync("{OUTPUTS}", Buffer.from(new Float64Array(found).buffer));
console.log(best);
"""
    }


def in_rust(task: Task) -> dict[str, str]:
    """Rust."""
    m, _ = task.sizes
    ins = [
        f"x[{at}..{at + size}].try_into().unwrap()" if a.shape else f"x[{at}]"
        for a, (at, size) in zip(task.inputs, task.spans(task.inputs), strict=True)
    ]
    outs = [f"&mut y{k}" for k in range(len(task.outputs))]
    made = " ".join(f"let mut y{k} = [0f64; {a.size}];" for k, a in enumerate(task.outputs))
    seen = " ".join(f"std::hint::black_box(&y{k});" for k in range(len(task.outputs)))
    kept = " ".join(f"found.extend_from_slice(&y{k});" for k in range(len(task.outputs)))
    return {
        "run.rs": f"""mod f_;
use std::time::Instant;
fn main() {{
    let bytes = std::fs::read("{INPUTS}").unwrap();
    let number = |b: &[u8]| f64::from_le_bytes(b.try_into().unwrap());
    let all: Vec<f64> = bytes.chunks(8).map(number).collect();
    let mut found: Vec<f64> = Vec::new();
    {made}
    let mut best = f64::INFINITY;
    for _ in 0..{task.rounds} {{
        let t = Instant::now();
        for _ in 0..{task.repeats} {{
            for x in all.chunks({m}) {{ f_::f_({", ".join(ins + outs)}); {seen} }}
        }}
        best = best.min(t.elapsed().as_nanos() as f64/({task.repeats} as f64*{STATES} as f64));
    }}
    for x in all.chunks({m}) {{ f_::f_({", ".join(ins + outs)}); {kept} }}
    let bytes: Vec<u8> = found.iter().flat_map(|y| y.to_le_bytes()).collect();
    std::fs::write("{OUTPUTS}", bytes).unwrap();
    println!("{{}}", best);
}}
"""
    }


def in_octave(task: Task) -> dict[str, str]:
    """Octave."""
    m, n = task.sizes
    ins = [f"x({at + 1}:{at + size})" for at, size in task.spans(task.inputs)]
    outs = [f"y{k}" for k in range(len(task.outputs))]
    kept = "; ".join(  # MATLAB counts columns first
        f"reshape(permute({y}, {list(range(max(2, len(a.shape)), 0, -1))}), [], 1)"
        for y, a in zip(outs, task.outputs, strict=True)
    )
    return {
        "run.m": f"""file = fopen("{INPUTS}");
given = fread(file, [{m}, {STATES}], "double"); fclose(file);
found = zeros({n}, {STATES}); best = Inf;
for r = 1:2
  t = tic;
  for i = 1:{STATES}
    x = given(:, i); [{", ".join(outs)}] = f_({", ".join(ins)}); found(:, i) = [{kept}];
  end
  best = min(best, 1e9*toc(t)/{STATES});
end
file = fopen("{OUTPUTS}", "w"); fwrite(file, found, "double"); fclose(file);
printf("%.9g\\n", best);
"""
    }


def in_python(task: Task, casadi: bool = False) -> dict[str, str]:
    """One call for all states: NumPy's arrays broadcast, CasADi maps its function."""
    m, _ = task.sizes
    shapes = [a.shape for a in task.inputs]
    if casadi:
        ins = [f"x[:, {at}:{at + size}].T.copy()" for at, size in task.spans(task.inputs)]
        made, call = f"f = f_().map({STATES})", "f(*ins)"
        rows = [a.shape[0] if len(a.shape) > 1 else a.size for a in task.outputs]
        kept = [
            f"np.asarray(y).reshape({count}, {STATES}, -1).swapaxes(0, 1).reshape({STATES}, -1)"
            for count in rows
        ]
    else:
        ins = [
            f"x[:, {at}:{at + size}].reshape(({STATES}, *{shape}))"
            for (at, size), shape in zip(task.spans(task.inputs), shapes, strict=True)
        ]
        made, call = "f = f_", "f(*ins)"
        kept = [f"np.asarray(y).reshape({STATES}, -1)" for _ in task.outputs]
    parts = ", ".join(text.replace("(y)", f"(found[{k}])") for k, text in enumerate(kept))
    return {
        "run.py": f"""import time
import numpy as np
from f_ import f_
x = np.fromfile("{INPUTS}").reshape({STATES}, {m})
ins = [{", ".join(ins)}]
{made}
best = np.inf
for r in range({task.rounds}):
    t = time.perf_counter_ns()
    found = {call}
    best = min(best, (time.perf_counter_ns() - t)/{STATES})
found = found if isinstance(found, (tuple, list)) else (found,)
np.concatenate([{parts}], axis=1).astype(float).tofile("{OUTPUTS}")
print(best)
"""
    }


@dataclass(frozen=True)
class Way:
    """A language as it is called here: its name for `fb.export`, what it needs, its program, and
    the commands."""

    language: str
    needs: str
    program: Callable[[Task], dict[str, str]]
    commands: tuple[str, ...]
    suffix: str
    """Of the file that holds the text."""
    dtype: str = "float64"


CC = "gcc -std=c99 -O3 -march=native"
RUN = (f"{CC} run.c f_.c -lm -o run", "./run")
WAYS = {
    "C": Way("c", "gcc", lambda t: in_c(t, "run.c", "f_.h"), RUN, ".c"),
    "C, float": Way("c", "gcc", lambda t: in_c(t, "run.c", "f_.h", "float"), RUN, ".c", "float32"),
    "C++": Way(
        "cpp",
        "g++",
        lambda t: in_c(t, "run.cpp", "f_.hpp"),
        ("g++ -std=c++11 -O3 -march=native run.cpp -o run", "./run"),
        ".hpp",
    ),
    "Rust": Way(
        "rust",
        "rustc",
        in_rust,
        (
            "rustc --edition 2021 -C opt-level=3 -C target-cpu=native -A warnings run.rs -o run",
            "./run",
        ),
        ".rs",
    ),
    "JavaScript": Way("javascript", "node", in_javascript, ("node run.mjs",), ".mjs"),
    "NumPy": Way("numpy", "numpy", in_python, ("{python} run.py",), ".py"),
    "CasADi": Way(
        "casadi", "casadi", lambda t: in_python(t, casadi=True), ("{python} run.py",), ".py"
    ),
    "Octave": Way("matlab", "octave", in_octave, ("octave --quiet run.m",), ".m"),
}


def measured(
    model: fb.Model, quantity: str, way: Way, python: str, rounds: int
) -> tuple[int, float, float]:
    """Bytes of the text, nanoseconds a call, and the largest difference over an output's largest
    entry."""
    kernel = fb.kernel(model, quantity)
    rng = np.random.default_rng(0)
    q, qd, last = fb.random_state(model, 0, STATES)
    values = {"q": q, "qd": qd, "qdd": last, "tau": 10 * last, "h": rng.uniform(1e-3, 2e-3, STATES)}
    given = [np.asarray(values[a.name], way.dtype).astype(float) for a in kernel.program.inputs]
    expected = kernel(*given)
    expected = expected if isinstance(expected, tuple) else (expected,)
    operations = max(sum(kernel.program.operations.values()), 100)
    task = Task(
        kernel.program.inputs, kernel.program.outputs, rounds, max(1, 400_000 // operations // 10)
    )
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fb.export(model, quantity, folder, way.language, name="f_", dtype=way.dtype)
        for file, text in way.program(task).items():
            (folder / file).write_text(text)
        np.concatenate([x.reshape(STATES, -1) for x in given], axis=1).tofile(folder / INPUTS)
        for command in way.commands:
            done = subprocess.run(
                command.format(python=python),
                shell=True,
                cwd=folder,
                capture_output=True,
                text=True,
                check=False,
            )
            if done.returncode:
                raise SystemExit(f"{command}: {done.stderr}")
        found = np.fromfile(folder / OUTPUTS).reshape(STATES, -1)
        size = (folder / f"f_{way.suffix}").stat().st_size
    off = 0.0
    for (at, width), wanted in zip(task.spans(task.outputs), expected, strict=True):
        difference = np.abs(found[:, at : at + width] - wanted.reshape(STATES, -1))
        off = max(off, float(difference.max() / np.abs(wanted).max()))
    return size, float(done.stdout.split()[-1]), off


def available(way: Way, python: str) -> bool:
    """Whether what runs it is here."""
    if way.needs in ("numpy", "casadi"):
        return not subprocess.run(
            [python, "-c", f"import {way.needs}"], capture_output=True, check=False
        ).returncode
    return shutil.which(way.needs) is not None


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=["ur5e", "panda"])
    parser.add_argument("--quantities", nargs="+", default=list(QUANTITIES))
    parser.add_argument("--languages", nargs="+", default=list(WAYS))
    parser.add_argument(
        "--python", default=sys.executable, help="an interpreter with NumPy and CasADi"
    )
    parser.add_argument("--rounds", type=int, default=7)
    given = parser.parse_args()
    print(
        f"{cpu()}; Python {platform.python_version()}, freebody {fb.__version__}; best of "
        f"{given.rounds}\n"
    )
    ways = {name: WAYS[name] for name in given.languages if available(WAYS[name], given.python)}
    sizes = [
        f"| kilobytes of text | {' | '.join(ways)} | error, double | error, float |",
        f"|---|{'---|' * len(ways)}---|---|",
    ]
    print(f"| nanoseconds a call | {' | '.join(ways)} |\n|---|{'---|' * len(ways)}")
    for robot in given.robots:
        model = fb.load(robot).without("friction", "rotors", "springs")
        for quantity in given.quantities:
            found = {
                name: measured(model, quantity, way, given.python, given.rounds)
                for name, way in ways.items()
            }
            times = [f"{time:,.0f}" for _, time, _ in found.values()]
            cells = [f"{size / 1000:.0f}" for size, _, _ in found.values()]
            off = {
                d: [found[name][2] for name, way in ways.items() if way.dtype == d] for d in DTYPES
            }
            worst = [f"{max(some):.0e}" if some else "" for some in off.values()]
            print(f"| {robot}, {quantity} | {' | '.join(times)} |", flush=True)
            sizes.append(f"| {robot}, {quantity} | {' | '.join([*cells, *worst])} |")
    print("", *sizes, sep="\n")


if __name__ == "__main__":
    main()
