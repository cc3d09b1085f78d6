"""The command `freebody models`."""

from __future__ import annotations

from freebody.cli import terminal

EXAMPLE = "Example: freebody models"


def models() -> None:
    """List the bundled models, each with a description and the source of its numbers."""
    from rich.padding import Padding

    from freebody.robots import abouts
    from freebody.robots import models as bundled

    out, told = terminal.out(), abouts()
    for name, source in bundled().items():
        out.print(name, style="bold")
        out.print(Padding(told[name], (0, 0, 0, 4)))
        out.print(Padding(f"source: {source}", (0, 0, 0, 4)), style="dim")
