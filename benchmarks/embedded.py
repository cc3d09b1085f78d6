"""What exported C takes on a microcontroller: bytes of code and of stack, by arm-none-eabi-gcc.

    python benchmarks/embedded.py [--robots ur5e panda scara talos]
        [--quantities inverse_dynamics …]

Needs Debian's gcc-arm-none-eabi and libnewlib-arm-none-eabi. Code is what `-Os` makes of the C,
constants included, without the sines of the C library; stack is the function's own and that of the
largest it calls. Talos comes from the wheel example-robot-data.
"""

from __future__ import annotations

import argparse
import subprocess
import tempfile
import warnings
from pathlib import Path

import freebody as fb
from compare import robots_folder

GCC = (
    "arm-none-eabi-gcc -std=c99 -Os -mthumb -mfloat-abi=hard -fstack-usage -Wall -Wextra "
    "-Wconversion -Werror"
)
MACHINES = {
    "Cortex-M4F, float": ("float32", "-mcpu=cortex-m4 -mfpu=fpv4-sp-d16 -Wdouble-promotion"),
    "Cortex-M7, double": ("float64", "-mcpu=cortex-m7 -mfpu=fpv5-d16"),
}
QUANTITIES = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "gravity_torque")


def load(robot: str) -> fb.Model:
    """Bundled, or Talos."""
    if robot != "talos":
        return fb.load(robot)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return fb.load(robots_folder() / "talos_data/robots/talos_reduced.urdf")


def bytes_of(model: fb.Model, quantity: str, dtype: str, flags: str) -> tuple[int, int]:
    """Code and stack."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        fb.export(model, quantity, folder, dtype=dtype, name="f_")
        subprocess.run(
            [*GCC.split(), *flags.split(), "-c", "f_.c", "-o", "f_.o"], cwd=folder, check=True
        )
        size = subprocess.run(
            ["arm-none-eabi-size", "f_.o"], cwd=folder, capture_output=True, text=True, check=True
        ).stdout.splitlines()[1]
        used = {
            row.split("\t")[0].split(":")[-1]: int(row.split("\t")[1])
            for row in (folder / "f_.su").read_text().splitlines()
        }
    own = used.pop("f_")
    return int(size.split()[0]), own + max(used.values(), default=0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--robots", nargs="+", default=["ur5e", "panda", "scara", "talos"])
    parser.add_argument("--quantities", nargs="+", default=list(QUANTITIES))
    given = parser.parse_args()
    print(f"| | {' | '.join(f'{machine}: code | stack' for machine in MACHINES)} |")
    print(f"|---|{'---|' * 2 * len(MACHINES)}")
    for robot in given.robots:
        model = load(robot)
        for quantity in given.quantities:
            found = [bytes_of(model, quantity, dtype, flags) for dtype, flags in MACHINES.values()]
            cells = " | ".join(f"{code} | {stack}" for code, stack in found)
            print(f"| {robot}, {quantity} | {cells} |", flush=True)


if __name__ == "__main__":
    main()
