"""Where llvmlite is not installed NumPy computes everything: in processes that cannot import it."""

from __future__ import annotations

import inspect
import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb
from support.command import command_names
from support.without_llvm import ELSEWHERE, HIDES

TESTS = Path(__file__).parents[2]


def without_llvm(folder: Path, *words: str) -> str:
    """What a process without llvmlite prints that runs `python *words` in the folder."""
    (folder / "sitecustomize.py").write_text(HIDES, encoding="utf-8")
    path = (str(folder), str(Path(fb.__file__).parents[1]), str(TESTS))
    environment = {k: v for k, v in os.environ.items() if not k.startswith("FREEBODY_")}
    done = subprocess.run(
        [sys.executable, "-W", "ignore", *words],
        cwd=folder,
        env=environment | {"PYTHONPATH": os.pathsep.join(path)},
        capture_output=True,
        text=True,
        timeout=1200,
        check=False,
    )
    assert done.returncode == 0, done.stdout[-2000:] + done.stderr[-2000:]
    return done.stdout


def test_every_public_function_and_command_works(tmp_path: Path):
    found = json.loads(without_llvm(tmp_path, "-m", "support.without_llvm"))
    assert {name: problem for name, problem in found.items() if problem} == {}
    functions = {name for name in fb.__all__ if inspect.isfunction(getattr(fb, name))}
    assert functions | {f"freebody {name}" for name in command_names()} <= found.keys() | {
        *ELSEWHERE,
        *(f"freebody {name}" for name in ELSEWHERE),
    }


@pytest.mark.parametrize(
    "robot",
    [
        "2R",
        *(pytest.param(name, marks=pytest.mark.long) for name in fb.models() if name != "2R"),
    ],
)
def test_a_study_with_its_page(robot: str, tmp_path: Path):
    said = without_llvm(tmp_path, "-m", "freebody", "study", robot, "--out", "studied")
    assert "Self-checks: freebody's results are consistent" in said
    page = (tmp_path / "studied/report.html").read_text(encoding="utf-8")
    assert "llvmlite not installed" in page
    assert "<svg" in page
