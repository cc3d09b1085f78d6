"""Packages of the extras that tests compare with."""

from __future__ import annotations

import importlib
import os
from typing import Any

import pytest

REQUIRED = os.environ.get("FREEBODY_EXTRAS") == "required"
"""Whether nothing may be missing: `.ci/run` says so, lest comparisons be left out in silence."""


def extra(module: str, package: str = "", name: str = "test") -> Any:
    """A module; where its package is not installed, the test or the file that asks is skipped.

    package: what its users call it, if it is not the module's name. name: the extra that brings it.
    """
    if REQUIRED:
        return importlib.import_module(module)
    reason = f"{package or module} is not installed: pip install 'freebody[{name}]'"
    return pytest.importorskip(module, reason=reason)
