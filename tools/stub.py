"""What type checkers and editors read in the place of `freebody/__init__.py`, whose names are
imported when first used.

    python tools/stub.py > src/freebody/__init__.pyi

writes it anew after a change of the table of public names; `tests/house/test_types.py` holds both
equal.
"""

from __future__ import annotations

import freebody as fb


def stub() -> str:
    """The text of the stub: each public name from its place."""
    lines = [
        '"""Written by tools/stub.py from the table in __init__.py: '
        'what type checkers read of it."""',
        "",
    ]
    lines += ["from . import math as math"]
    for place, names in sorted(fb._PLACES.items()):
        for name in sorted(names):
            line = f"from {place} import {name} as {name}"
            lines += (
                [line]
                if len(line) <= 100
                else [f"from {place} import (", f"    {name} as {name},", ")"]
            )
    return "\n".join([*lines, "", "__version__: str", ""])


if __name__ == "__main__":
    print(stub(), end="")
