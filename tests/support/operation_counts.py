"""Operations of kernels of a few robots, which do not depend on the machine that counts them.

PYTHONPATH=src:tests python tests/support/operation_counts.py     renew operation_counts.toml
"""

from __future__ import annotations

import tomllib
from pathlib import Path

import freebody as fb

BOUNDS = Path(__file__).with_suffix(".toml")
ROBOTS = ("ur5e", "panda", "iiwa14", "five_bar")
QUANTITIES = ("inverse_dynamics", "forward_dynamics", "mass_matrix")


def counted() -> dict[str, dict[str, int]]:
    """Of each robot and quantity the operations of one sample, adding up all kinds of them."""
    counts: dict[str, dict[str, int]] = {}
    for name in ROBOTS:
        robot = fb.load(name)
        counts[name] = {}
        for quantity in QUANTITIES:
            kernel = fb.kernel(robot, quantity, target="numpy")
            counts[name][quantity] = sum(kernel.program.operations.values())
    return counts


def bounds() -> dict[str, dict[str, int]]:
    """The counts that are kept, none of which may be exceeded."""
    return tomllib.loads(BOUNDS.read_text(encoding="utf-8"))


def main() -> None:
    """Write today's counts; what grew is seen in the difference."""
    lines = ["# made by operation_counts.py beside this file; operations of one sample"]
    for robot, counts in counted().items():
        lines += ["", f"[{robot}]", *(f"{name} = {count}" for name, count in counts.items())]
    BOUNDS.write_text("\n".join(lines) + "\n", encoding="utf-8")


if __name__ == "__main__":
    main()
