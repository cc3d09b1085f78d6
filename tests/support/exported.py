"""Exported packages, tested by the tools of their languages."""

from __future__ import annotations

import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from freebody.targets.text import LANGUAGES
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
    command = LANGUAGES[language].test.format(name=word)
    for plain, strict in STRICT.items():
        command = command.replace(plain, strict)
    return subprocess.run(
        command, shell=True, cwd=folder, capture_output=True, text=True, check=False, timeout=300
    )


def passes(folder: Path, language: str, word: str) -> None:
    done = self_test(folder, language, word)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "passed" in done.stdout
