"""States at which a page's kernels are held against Python's results: random ones, which of a
closed chain are reached from its home by its own motion."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from freebody.arrays import Array
from freebody.model.model import Model
from freebody.studio.kernels import PageKernel, Studied
from freebody.trees.positions import random_state

KernelStates = dict[str, Array]
"""Values (count, ...) of inputs by name."""

STEP = 1e-3
"""The length of a step of a page's simulation, s."""
DAMPING = 1e-3
"""The damping of a descent's first step."""
COUNT = 5
"""The number of states of each kernel."""
_SHAKEN, _PUSHES = 5e-3, 12  # s and steps, by which a closed chain leaves its home
_SEED = 35


def states(
    robot: Studied, q0: Array, heaviest: float, made: Mapping[str, PageKernel]
) -> KernelStates:
    """The inputs of all kernels by name, several values each.

    q0: where the robot stands first (nq,). heaviest: the largest load of the page's slider, kg.
    """
    model, rng = robot.model, np.random.default_rng(_SEED)
    q, qd, _ = random_state(model, _SEED, COUNT)
    tau = rng.uniform(-1.0, 1.0, (COUNT, model.nv)) * model.mass
    given: KernelStates = {
        "tau": tau,
        "h": np.full(COUNT, STEP),
        "p": rng.uniform(0.0, heaviest, (COUNT, 1)),
        "damping": np.full(COUNT, DAMPING),
        "weights": rng.uniform(0.5, 2.0, (COUNT, model.nv)),
    }
    if model.loops:
        q, qd = _shaken(model, q0, given, made["stepped"])
    given |= {"q": q, "qd": qd}
    if "looked" in made:
        given["target"] = made["looked"]({"q": q[::-1]})[0]
    return given


def _shaken(model: Model, q0: Array, given: KernelStates, step: PageKernel) -> tuple[Array, Array]:
    """States of a closed chain some steps after it was at rest at q0, under torques, or as far as
    it came on the way to singular positions, where there is no step."""
    q, qd = np.tile(q0, (COUNT, 1)), np.zeros((COUNT, model.nv))
    for _ in range(_PUSHES):
        q1, qd1 = step({**given, "q": q, "qd": qd, "h": np.full(COUNT, _SHAKEN)})
        goes = np.isfinite(q1).all(axis=-1, keepdims=True)
        q, qd = np.where(goes, q1, q), np.where(goes, qd1, qd)
    return q, qd
