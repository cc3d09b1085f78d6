"""The command `freebody`, run in this process as `python -m freebody` runs it."""

from __future__ import annotations

import runpy
import sys
from collections.abc import Sequence


def run(arguments: Sequence[str]) -> int:
    """The exit status with these arguments; what it prints goes to this process's streams."""
    before, sys.argv = sys.argv, ["freebody", *arguments]
    try:
        runpy.run_module("freebody", run_name="__main__")
    except SystemExit as end:
        return int(end.code or 0)
    finally:
        sys.argv = before
    raise AssertionError("freebody ended without an exit status")
