"""`freebody models`."""

from __future__ import annotations

from freebody.cli import terminal

EXAMPLE = "Example: freebody models"


def models() -> None:
    """List the bundled models, each with the source of its numbers."""
    from rich.table import Table

    from freebody.robots import models as bundled

    table = Table("model", "source", box=None, pad_edge=False, header_style="bold")
    for name, source in bundled().items():
        table.add_row(name, source)
    terminal.out().print(table, markup=False)
