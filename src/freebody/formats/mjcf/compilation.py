"""MuJoCo's account of a file: its parser in a process of its own, what it says of a file that it
refuses, and numbers that it takes and no robot has."""

from __future__ import annotations

import json
import re
import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from freebody.errors import FileError, MissingPackageError
from freebody.formats import read_file
from freebody.formats.mjcf import compiled

_SECONDS = 300  # that MuJoCo may take, of which distances of large meshes take most
PARTS = {
    "bodies": "body",
    "joints": "joint",
    "sites": "site",
    "equalities": "equality",
    "actuators": "actuator",
    "tendons": "tendon",
}
"""The kinds of parts of a compiled model, each by the word for one of them."""
_REMEDIES = (
    (
        "Error opening file",
        "Put that file there, or correct its path; a part that others include is loaded by one of "
        "those, from whose folder its paths are looked up.",
    ),
    (
        "not found in|unrecognized name|unknown default class",
        "Correct the name; a part that others include is loaded by one of those.",
    ),
    ("repeated name", "Rename one of the two."),
    (
        "larger than mjMINVAL",
        "Give the body a mass and moments of inertia above 1e-15 kg and kg m², or remove its "
        "joint.",
    ),
)
"""Remedies of a file, by words in what MuJoCo says of it."""
BOUNDS = {
    "range": "range",
    "effort": "actuatorfrcrange",
    "force": "forcerange",
    "input": "ctrlrange",
}
"""MJCF's names of the pairs of numbers that bound something."""


def compilation(file: str, on_disk: bool, data: bytes) -> dict[str, Any]:
    """The numbers that MuJoCo makes of the file, in a process that may fail."""
    from importlib.util import find_spec

    if find_spec("mujoco") is None:
        raise MissingPackageError("load: MJCF", "mujoco", "mjcf")
    command = [
        sys.executable,
        compiled.__file__,
        *([str(Path(file).absolute())] if on_disk else []),
    ]
    try:
        with TemporaryDirectory() as folder:  # MuJoCo writes a log where it runs
            done = subprocess.run(
                command,
                input=b"" if on_disk else data,
                capture_output=True,
                timeout=_SECONDS,
                check=False,
                cwd=folder,
            )
    except subprocess.TimeoutExpired:
        raise FileError(file, None, f"MuJoCo took more than {_SECONDS} s to compile it.") from None
    try:
        found = json.loads(done.stdout)
    except ValueError:
        reason = done.stderr.decode(errors="replace").strip().rsplit("\n", 1)[-1]
        raise FileError(
            file, None, f"MuJoCo ended while it compiled it: {reason or done.returncode}."
        ) from None
    if "problem" in found:
        told = found["problem"]
        raise FileError(
            file, _line(told, data), f"MuJoCo does not compile it: {_as_sentences(told)}"
        )
    _refuse_unusable(file, found)
    return found


def _line(told: str, data: bytes) -> int | None:
    """The line that MuJoCo tells of a file; it does not say which, where files are included."""
    found = re.search(r"\bline (\d+)", told)
    line = int(found[1]) if found else 0  # of what has none MuJoCo tells 0
    return line if line and not re.search(rb"<(include|model)\b", data) else None


def _as_sentences(told: str) -> str:
    """The words of MuJoCo on a file, in one line, and what mends the file where that is known."""
    line = "; ".join(" ".join(x.split()) for x in told.splitlines() if x.strip())
    line = re.sub(r"^((XML )?Error: )+|, line 0\b", "", line).rstrip(".")
    return " ".join([f"{line}.", *(mend for words, mend in _REMEDIES if re.search(words, line))])


def _refuse_unusable(file: str, found: dict[str, Any]) -> None:
    """Refuse numbers that MuJoCo takes and no robot has: NaN, and infinity where it is no bound."""
    for kind, called in PARTS.items():
        for part in found[kind]:
            for key, given in part.items():
                for value in given if isinstance(given, list) else [given]:
                    fault = isinstance(value, float) and read_file.fault(value, key in BOUNDS)
                    if fault:
                        name = f" {part['name']!r}" if part["name"] else ""
                        problem = f"{called}{name}: its {key} is {value:g}, {fault}."
                        raise FileError(file, None, problem)
