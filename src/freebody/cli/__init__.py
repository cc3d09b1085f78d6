"""The command line: it reads arguments and prints; what it prints is computed elsewhere."""

from __future__ import annotations

import sys


def main() -> None:
    """The program `freebody`."""
    from freebody.cli.app import run

    sys.exit(run(sys.argv[1:]))
