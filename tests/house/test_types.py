"""What type checkers and editors see of the public names: as much as the interpreter, and
mistakes."""

from __future__ import annotations

import inspect
import json
import os
import re
import runpy
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb

ROOT = Path(__file__).parents[2]
SAMPLES = Path(__file__).parents[1] / "types"
PYTHON = os.environ.get("TYPES_OF", sys.executable)
"""The interpreter whose freebody is looked at: in .ci/run that of a wheel's environment."""


def test_the_stub_has_the_names_of_the_table():
    stub = ROOT / "src/freebody/__init__.pyi"
    expected = runpy.run_path(str(ROOT / "tools/stub.py"))["stub"]()
    assert stub.read_text(encoding="utf-8") == expected, (
        f"python tools/stub.py > {stub.relative_to(ROOT)}"
    )
    assert (stub.parent / "py.typed").exists()


def test_completion_offers_every_public_name():
    assert dir(fb) == sorted(fb.__all__)
    model = fb.load("2R")
    offered = {name for name in dir(model) if not name.startswith("_")}
    assert {"with_payload", "bind", "tip", "bodies", "gravity", "nq"} <= offered


def test_what_a_checker_finds_right_runs():
    runpy.run_path(str(SAMPLES / "right.py"))


def checked(*files: Path) -> dict[str, list[tuple[int, str]]]:
    """Of each file the lines that pyright complains of, and what it says."""
    if shutil.which("pyright", path=str(Path(sys.executable).parent)) is None:
        pytest.skip("pyright is not installed")
    command = [
        str(Path(sys.executable).with_name("pyright")),
        "--outputjson",
        "--pythonpath",
        PYTHON,
    ]
    done = subprocess.run(
        [*command, *map(str, files)],
        capture_output=True,
        text=True,
        timeout=300,
        check=False,
        cwd=files[0].parent,
    )
    found: dict[str, list[tuple[int, str]]] = {file.name: [] for file in files}
    for complaint in json.loads(done.stdout)["generalDiagnostics"]:
        line = complaint["range"]["start"]["line"]
        found[Path(complaint["file"]).name].append((line, complaint["message"]))
    return found


def test_a_strict_checker_sees_every_public_signature_and_finds_mistakes(tmp_path):
    for sample in SAMPLES.glob("*.py"):
        shutil.copy(sample, tmp_path)
    every = ["# pyright: strict", "import freebody as fb"]
    for k, name in enumerate(sorted(fb.__all__)):
        every.append(f"x{k} = fb.{name}")
        value = getattr(fb, name)
        if inspect.isclass(value) and not issubclass(value, BaseException):
            members = [member for member in dir(value) if not member.startswith("_")]
            every += [f"x{k}_{j} = fb.{name}.{member}" for j, member in enumerate(members)]
    (tmp_path / "every.py").write_text("\n".join([*every, ""]), encoding="utf-8")
    found = checked(tmp_path / "right.py", tmp_path / "every.py", tmp_path / "wrong.py")
    assert found["right.py"] == []
    assert found["every.py"] == []
    lines = (tmp_path / "wrong.py").read_text(encoding="utf-8").splitlines()
    expected = {
        k: line.partition("# error: ")[2] for k, line in enumerate(lines) if "# error: " in line
    }
    said = {k: " ".join(text for at, text in found["wrong.py"] if at == k) for k in expected}
    missed = {
        lines[k]: said[k]
        for k, words in expected.items()
        if words not in re.sub(r"\s+", " ", said[k])
    }
    assert not missed
    assert {at for at, _ in found["wrong.py"]} == set(expected)
