"""Environment variables of targets, read once and kept apart from their readers, so that no call's
answer changes while a process runs, and tests set them in one place."""

from __future__ import annotations

import os

TARGET = os.environ.get("FREEBODY_TARGET") or None
"""The target of kernels for which no `target=` is given."""

WIDTH = os.environ.get("FREEBODY_WIDTH") or None
"""Samples in a vector of kernels for which no `width=` is given, as text."""

OPTIMISE = int(os.environ.get("FREEBODY_OPTIMISE") or 2)
"""LLVM's effort on the machine code of kernels, 0 to 3: with 0 they are compiled in a third of the
time, and run several times as long."""

FASTCALL = os.environ.get("FREEBODY_FASTCALL", "").lower() != "off"
"""Whether calls of one sample may go by the interpreter's own way."""
