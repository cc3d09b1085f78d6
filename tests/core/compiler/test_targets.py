"""What a target is: a record that a table names. A made-up one is put into the table, and asked as
the others are."""

from __future__ import annotations

import importlib.util
import os
import pickle
import re
import subprocess
import sys

import numpy as np
import pytest

import freebody as fb
from freebody.targets import TARGETS, Kernel, KernelError, settings
from freebody.targets.target import Target
from support.programs import (
    environment,
    swap_kernel,
)

pytestmark = pytest.mark.usefixtures("memory_only")


def test_a_target_is_a_module_and_a_line(monkeypatch):
    """It is found, told its program, width and number type, asked for its text, and found again by
    a pickle."""
    asked = []

    def build(program, width, dtype):
        asked.append((width, dtype))
        return Kernel(program, "halves", width or 6, lambda q: np.asarray(q) / 2, dtype)

    record = Target(
        build=build,
        source=lambda program, width, dtype: f"{program.name} {width} {dtype}",
        widths={"float64": (6, 7), "float16": ()},
        variant=lambda program: os.environ.get("HALVES"),
        loops=False,
    )
    monkeypatch.setitem(TARGETS, "halves", lambda: record)
    first = swap_kernel(target="halves", width=7)
    assert (first.target, first.width, first.dtype, first.source) == (
        "halves",
        7,
        "float64",
        "swap 7 float64",
    )
    assert first(np.ones(3)).tolist() == [0.5, 0.5, 0.5]
    assert pickle.loads(pickle.dumps(first)) is first
    assert asked == [(7, "float64")]
    swap_kernel(target="halves", dtype="float16")
    monkeypatch.setattr(settings, "TARGET", "halves")
    monkeypatch.setattr(settings, "WIDTH", "6")
    assert fb.kernel(fb.load("2R"), "bias").target == "halves"
    monkeypatch.setenv("HALVES", "other")  # what the code depends on is part of its key
    assert swap_kernel(width=7) is not first
    assert asked[1:] == [(None, "float16"), (6, "float64"), (7, "float64")]
    for option, text in (
        ({"width": 4}, "no width 4 of float64. Widths: 6, 7 "),
        ({"dtype": "float32"}, "target 'halves' has no dtype 'float32'. It has: float64, float16."),
    ):
        with pytest.raises(KernelError, match=re.escape(text)):
            swap_kernel(**option)


def test_importing_the_compiler_does_not_import_llvm():
    code = (
        "import sys, freebody.targets; assert not any(m.startswith('llvmlite') for m in "
        "sys.modules)"
    )
    subprocess.run([sys.executable, "-c", code], check=True, timeout=60, env=environment())


def test_without_llvm_numpy_computes(monkeypatch):
    monkeypatch.setattr(importlib.util, "find_spec", lambda name: None)
    assert swap_kernel().target == "numpy"
