"""Walking by step kernels."""

from __future__ import annotations

import numpy as np

import freebody as fb

METHODS = {"semi_implicit_step": 1, "rk4_step": 4, "implicit_step": 2}
"""The order of each."""

State = tuple[np.ndarray, np.ndarray]


def walk(
    model: fb.Model, method: str, state: State, tau: np.ndarray, time: float, steps: int, *more
) -> State:
    """The state after so many steps."""
    step = fb.kernel(model, method, wrench_frames=["tool"] if more else ())
    for _ in range(steps):
        state = step(*state, tau, time / steps, *more)
    return state


def apart(model: fb.Model, one: State, other: State) -> float:
    """The largest difference of two states."""
    return max(
        np.abs(fb.difference(model, one[0], other[0])).max(),
        np.abs(one[1] - other[1]).max(initial=0.0),
    )
