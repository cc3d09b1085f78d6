"""Names that the package knows, as its errors list them where another was given."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import freebody as fb


def listed(call: Callable[[], Any]) -> list[str]:
    """The names that the refusal of this call lists."""
    try:
        call()
    except fb.FreebodyError as error:
        (names,) = re.findall(r"[A-Z][a-z ]+: ([\w, -]+)", str(error))[-1:]
        return names.split(", ")
    raise AssertionError("taken, not refused")


_ARM = fb.load("2R")
LANGUAGES = listed(lambda: fb.source(_ARM, "bias", "none"))
"""Languages of source text."""
LOOP_KINDS = listed(lambda: _ARM.with_loop("loop", "none", ("base", "tip")))
"""Kinds of loops."""
