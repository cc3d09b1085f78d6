"""Calls as text, so that the call shown with a check is the call that runs."""

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
    """Result of evaluating a call's text, which is also the text shown."""
    return eval(text, {"fb": fb, "np": np})  # the calls are constants of this package


@cache
def source(function: Callable[..., Any]) -> str:
    """Source text of a function without its docstring."""
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
