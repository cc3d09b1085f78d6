"""What processes that tests start are given."""

from __future__ import annotations

import os
import sys


def environment() -> dict[str, str]:
    """Of a child process that imports what this one does."""
    return {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)}
