"""Replay the claims: each file beside this one is a claim, its docstring, and the program that
proves it or fails.

    python proof/run.py              all, and the table of proof/README.md
    python proof/two_masses.py       one, in any folder; it may write files there
"""

from __future__ import annotations

import ast
import os
import platform
import subprocess
import sys
import tempfile
import time
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import freebody

HERE = Path(__file__).parent
BESIDE = ("numpy", "pin", "drake", "mujoco", "sympy", "toppra", "fmpy", "jax")


def claims() -> list[Path]:
    """The files of all claims."""
    return sorted(path for path in HERE.glob("*.py") if path.name != "run.py")


def claimed(path: Path) -> str:
    """What a file claims, in one line."""
    return " ".join((ast.get_docstring(ast.parse(path.read_text(encoding="utf-8"))) or "").split())


def replay(path: Path) -> tuple[bool, str, float]:
    """Whether the claim holds, the last line that its program prints, and its seconds."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.perf_counter()
        run = subprocess.run(
            [sys.executable, str(path)],
            cwd=folder,
            env={**os.environ, "PYTHONIOENCODING": "utf-8"},
            capture_output=True,
            encoding="utf-8",
            check=False,
        )
        seconds = time.perf_counter() - start
    said = (run.stdout if run.returncode == 0 else run.stderr).strip().splitlines()
    return run.returncode == 0, said[-1] if said else "", seconds


def versions() -> str:
    """The packages that took part, with their versions, and the machine."""
    found = [f"freebody {freebody.__version__}"]  # as imported; metadata may be of another
    for package in BESIDE:
        try:
            found.append(f"{package} {version(package)}")
        except PackageNotFoundError:
            found.append(f"{package} not installed")
    return f"{', '.join(found)}; Python {platform.python_version()}, {platform.machine()}"


def main() -> int:
    """Replay all claims and print a table in Markdown; 1 if one does not hold."""
    failed = 0
    print("| claim | what its program says | s |\n|---|---|---|")
    for path in claims():
        holds, said, seconds = replay(path)
        failed += not holds
        said = said.replace("|", "\\|")
        verdict = said if holds else f"**does not hold**: {said}"
        link = f"[{path.stem}]({path.name})"
        print(f"| {link}: {claimed(path)} | {verdict} | {seconds:.1f} |", flush=True)
    print(f"\n{versions()}")
    return min(failed, 1)


if __name__ == "__main__":
    sys.exit(main())
