"""Objects that machine code points to."""

from __future__ import annotations

import ctypes
from typing import Any


def forever(*things: Any) -> None:
    """Never free these. A list would not do: modules are emptied at exit, before the last functions are gone."""
    for thing in things:
        ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))
