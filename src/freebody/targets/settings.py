"""Environment variables of targets, read once and kept apart from their readers: no call's answer
changes while a process runs, and tests set them in one place."""

from __future__ import annotations

import os

TARGET = os.environ.get("FREEBODY_TARGET") or None
"""The target of kernels for which no `target=` is given."""

WIDTH = os.environ.get("FREEBODY_WIDTH") or None
"""Samples in a vector of kernels for which no `width=` is given, as text."""

FASTCALL = os.environ.get("FREEBODY_FASTCALL", "").lower() != "off"
"""Whether calls of one sample may go by the interpreter's own way."""
