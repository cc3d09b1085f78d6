"""The command line: it reads arguments and prints; what it prints is computed elsewhere."""

from __future__ import annotations

import sys

INTERRUPTED = 130
"""128 and the number of SIGINT, as shells count."""


def main() -> None:
    """Run the program `freebody`."""
    try:
        from freebody.cli.app import run

        code = run(sys.argv[1:])
    except (
        KeyboardInterrupt
    ):  # while the program was still being imported, or said that it is interrupted
        sys.stderr.write("error: interrupted.\n")
        code = INTERRUPTED
    sys.exit(code)
