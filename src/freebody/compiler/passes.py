"""Passes over a program: each takes a program and returns one that computes the same."""

from __future__ import annotations

from collections.abc import Callable

from freebody.compiler.program import Program, verify

PASSES: dict[str, Callable[[Program], Program]] = {}
"""Passes by name, in the order in which they run."""


def optimise(program: Program) -> Program:
    """All passes, one after the other, each product verified."""
    for apply in PASSES.values():
        program = verify(apply(program))
    return program
