"""Exported packages, tested by the tools of their languages."""

from __future__ import annotations

import shutil
import subprocess
import sys
import tempfile
from functools import cache
from pathlib import Path

import pytest

import freebody as fb
from support.extras import extra
from support.languages import TOOL

NEEDS = {"jax": "jax", "casadi": "casadi"}
STRICT = {
    "cc -std=c99": "cc -std=c99 -Wall -Wextra -Wconversion -Wdouble-promotion -pedantic -Werror",
    "c++ ": "c++ -Wall -Wextra -Wconversion -pedantic -Werror ",
    "rustc ": "rustc -D warnings ",
    "python ": f"{sys.executable} ",
    "-O2": "-O0",
}


def require(language: str) -> None:
    if shutil.which(TOOL[language]) is None:
        pytest.skip(f"{TOOL[language]} is not installed: {language} is written, not run")
    if language in NEEDS:
        extra(NEEDS[language])


def self_test(folder: Path, language: str, word: str) -> subprocess.CompletedProcess[str]:
    """The package's own test, compiled with all warnings as errors."""
    command = _told(language).replace("tried", word)
    for plain, strict in STRICT.items():
        command = command.replace(plain, strict)
    return subprocess.run(
        command, shell=True, cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )


@cache
def _told(language: str) -> str:
    """The command that a package's README tells for its self-test, here of the function `tried`."""
    with tempfile.TemporaryDirectory() as folder:
        tried = fb.compile(lambda x: 2.0 * x, {"x": ()}, target="numpy")
        fb.export(tried, out=folder, language=language, name="tried")
        readme = (Path(folder) / "README.txt").read_text(encoding="utf-8")
    return readme.partition("To run that of tried:\n")[2].partition("\n")[0].strip()


def passes(folder: Path, language: str, word: str) -> None:
    done = self_test(folder, language, word)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "passed" in done.stdout
