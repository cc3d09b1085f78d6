"""Calls as text: what a check shows is what it runs."""

from __future__ import annotations

import inspect
import textwrap
from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

import freebody as fb

ARM = 'fb.planar("RR")'
"""The notes' arm of two links."""


@cache
def made(text: str) -> Any:
    """Result of a call: the text that is shown is the text that is run."""
    return eval(text, {"fb": fb, "np": np})  # the calls are constants of this package


@cache
def source(function: Callable[..., Any]) -> str:
    """The text of a function without its description."""
    lines = textwrap.dedent(inspect.getsource(function)).splitlines()
    start = next((k for k, line in enumerate(lines) if line.strip().startswith('"""')), None)
    if start is not None:
        end = start if lines[start].count('"""') == 2 else next(
            k for k in range(start + 1, len(lines)) if '"""' in lines[k]
        )  # fmt: skip
        lines = lines[:start] + lines[end + 1 :]
    return "\n".join(
        line.replace("  # fmt: skip", "") for line in lines if not line.startswith("@")
    )
