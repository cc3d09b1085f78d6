"""Arms with symbols for some of their numbers, and what is derived of them."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np

import freebody as fb
from freebody.model.description import Mimic
from freebody.model.model import Model
from freebody_textbook.methods import METHODS as TABLE

METHODS = list(TABLE)
"""Names of all methods of derivation."""
_SHOWN = {"values"}
"""Options that choose only how lines are written."""
WAYS = [
    (method.name, dict(zip((option.name for option in options), chosen, strict=True)))
    for method in TABLE.values()
    if method.finds_torques and not method.at_rest and not method.closed_first
    for options in ([option for option in method.options if option.name not in _SHOWN],)
    for chosen in itertools.product(*(option.choices for option in options))
]
"""The ways from a motion to the torques: every method of open chains, with every choice of its
options that makes another way."""


def spatial_arm(seed: int, n: int) -> Model:
    """A random arm by its DH table, some of its entries symbols."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "joint": str(rng.choice(["R", "R", "P"])),
            "a": f"a{i}",
            "d": 0.0 if rng.random() < 0.5 else float(rng.integers(1, 5)) / 10,
            "alpha": float(rng.choice([0.0, np.pi / 2, -np.pi / 2, 0.3])),
            "m": f"m{i}",
            "com": (f"c{i}x", float(rng.integers(-5, 5)) / 10, 0.0),
            "I": [f"I{i}xx", 0.0, 0.0, f"I{i}yy", 0.0, f"I{i}zz"],
        }
        for i in range(1, n + 1)
    ]
    return fb.dh(rows, convention=str(rng.choice(["standard", "modified"])), name=f"arm{seed}")


def coupled(model: Model, **followers: tuple[str, float, float]) -> Model:
    """The arm with some joints following others, each by (joint, ratio, offset)."""
    bodies = [
        replace(body, joint=replace(body.joint, mimic=Mimic(*followers[body.joint.name])))
        if body.joint.name in followers
        else body
        for body in model.bodies
    ]
    return replace(model, bodies=tuple(bodies))


def with_values(model: Model) -> Model:
    """Numbers for all parameters that have none; inertias between a half and one are physical."""
    rng = np.random.default_rng(3)
    return model.bind(**{name: rng.uniform(0.5, 1.0) for name in model.missing})
