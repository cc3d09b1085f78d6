"""What kernels for GPUs take: registers, spilled bytes, length, time, and the limits of a card.
Needs ptxas, no GPU.

`python benchmarks/ptx.py [ROBOT …] [--all]`: a Markdown table. Limits are those of an H200, in 10^9
evaluations a second: its data sheet has 34 and 67 · 10^12 double and float operations a second,
multiply-add counted as two, and 4.8 · 10^12 bytes.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import subprocess
import sys
import sysconfig
import tempfile
from pathlib import Path
from time import process_time

import freebody as fb
from freebody.kernels.formulas import FORMULAS

QUANTITIES = (
    "inverse_dynamics",
    "forward_dynamics",
    "mass_matrix",
    "jacobian",
    "rk4_step",
    "inverse_dynamics_derivatives",
    "forward_dynamics_derivatives",
)
ROBOTS = ("ur5e", "panda", "talos", "stewart")
INSTRUCTIONS = {"float64": 17e12, "float32": 33.5e12}
"""A second, a multiply-add being one."""
BYTES = 4.8e12
_WEIGHT = {"div": 10, "sqrt": 10}
"""Instructions that they become."""


def robot(name: str) -> fb.Model:
    """A bundled model, or Talos of the wheel example-robot-data."""
    data = Path(sysconfig.get_path("purelib"), "cmeel.prefix/share/example-robot-data/robots")
    path = data / "talos_data/robots/talos_reduced.urdf"
    return fb.load(path, mimic="free", tip="left_sole_link") if name == "talos" else fb.load(name)


def quantities(model: fb.Model, every: bool) -> list[str]:
    """Those that there are of an open or closed chain."""
    loops = ("constraint", "constrained_dynamics", "reaction_wrenches")
    other = "open" if model.loops else "closed"
    there = [
        x
        for x, f in FORMULAS.items()
        if f.chains not in (other, "arm") and (model.loops or not x.startswith(loops))
    ]
    return there if every else [x for x in QUANTITIES if x in there]


def ptxas() -> str:
    """NVIDIA's assembler."""
    found = [
        *Path(sysconfig.get_path("purelib"), "nvidia").glob("*/bin/ptxas"),
        shutil.which("ptxas"),
    ]
    if not any(found):
        sys.exit("ptxas is missing: pip install nvidia-cuda-nvcc-cu12")
    return str(next(x for x in found if x))


def _of_children() -> float:
    """Seconds of a processor's time that processes started from here have taken."""
    return sum(os.times()[2:4])


def assembled(text: str) -> tuple[list[int], int, float]:
    """Registers of each entry, bytes that are spilled and read back in all, seconds of a
    processor's time."""
    with tempfile.TemporaryDirectory() as folder:
        Path(folder, "x.ptx").write_text(text, encoding="ascii")
        begin = _of_children()
        command = [ptxas(), "-arch=sm_90", "-v", "x.ptx", "-o", "x.cubin"]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True)
        spent = _of_children() - begin
    registers = [int(x) for x in re.findall(r"Used (\d+) registers", done.stderr)]
    moved = sum(map(int, re.findall(r"(\d+) bytes spill (?:stores|loads)", done.stderr)))
    return registers, moved, spent


def instructions(text: str, dtype: str) -> int:
    """Arithmetic instructions of that type; those of large angles are left out."""
    entries = text[text.index(".visible .entry") :]
    kind = "f64" if dtype == "float64" else "f32"
    words = re.findall(
        rf"^\s+(fma|add|sub|mul|div|sqrt|neg|min|max|setp\.\w+)[.\w]*\.{kind}\b",
        entries,
        re.MULTILINE,
    )
    return sum(_WEIGHT.get(word, 1) for word in words)


def figures(model: fb.Model, quantity: str, dtype: str) -> tuple[str, ...]:
    """What the table tells of one kernel."""
    begin = process_time()
    text = fb.source(model, quantity, "cuda", dtype=dtype)
    emitted = process_time() - begin
    registers, moved, spent = assembled(text)
    count, size = instructions(text, dtype), 8 if dtype == "float64" else 4
    program = fb.kernel(model, quantity, target="numpy").program
    there = size * (program.input_size + program.output_size)
    limits = INSTRUCTIONS[dtype] / max(count, 1) / 1e9, BYTES / there / 1e9
    spilling = f", {min(limits[0], BYTES / (there + moved) / 1e9):.2g} spilling" if moved else ""
    shown = (
        len(registers),
        max(registers),
        moved,
        count,
        there,
        f"{len(text) / 1e3:.0f}",
        f"{emitted + spent:.1f}",
    )
    return (
        *map(str, shown),
        f"{min(limits):.2g} ({'arithmetic' if limits[0] < limits[1] else 'memory'}){spilling}",
    )


HEAD = (
    "entry points, registers, bytes spilled, instructions, bytes in and out, kB of text, "
    "seconds, limit (10⁹/s)"
)


def main() -> None:
    """The table: of double and of float."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("robots", nargs="*", default=ROBOTS)
    parser.add_argument("--all", action="store_true", help="every quantity")
    asked = parser.parse_args()
    print(f"| robot | quantity | {HEAD.replace(', ', ' | ')} |\n|{'---|' * 10}")
    for name in asked.robots:
        model = robot(name)
        for quantity in quantities(model, asked.all):
            cells = zip(*(figures(model, quantity, dtype) for dtype in INSTRUCTIONS), strict=True)
            both = (x if x == y else f"{x} / {y}" for x, y in cells)
            print(f"| {name} | {quantity.replace('_', ' ')} | {' | '.join(both)} |", flush=True)


if __name__ == "__main__":
    main()
