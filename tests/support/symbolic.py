"""Arms with symbols for some of their numbers, and what is derived of them."""

from __future__ import annotations

import inspect
import itertools
import re
from dataclasses import replace

import numpy as np

import freebody as fb
from support.robots import Mimic

_TOLD = re.compile(r"^'(?P<name>[\w-]+)': .*?(?: Options: (?P<options>.*?))?$", re.MULTILINE)
_OPTION = re.compile(r"(\w+)=('[\w-]+'(?: \| '[\w-]+')*)")
_OPTIONS = {
    told["name"]: {
        name: re.findall(r"[\w-]+", choices)
        for name, choices in _OPTION.findall(told["options"] or "")
        if name != "values"  # it chooses only how lines are written
    }
    for told in _TOLD.finditer(inspect.getdoc(fb.derive) or "")
}
"""The options of each method with their choices, read off the documentation of `fb.derive`."""
METHODS = list(_OPTIONS)
"""Names of all methods of derivation."""
_ENDING_ELSEWHERE = {"lagrange-first-kind", "statics", "kinematics"}
"""Methods that end in multipliers, in forces at rest or in no torques."""
WAYS = [
    (method, dict(zip(options, chosen, strict=True)))
    for method, options in _OPTIONS.items()
    if method not in _ENDING_ELSEWHERE
    for chosen in itertools.product(*options.values())
]
"""The ways from a motion to the torques: every method of open chains, with every choice of its
options that makes another way."""


def spatial_arm(seed: int, n: int) -> fb.Model:
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


def coupled(model: fb.Model, **followers: tuple[str, float, float]) -> fb.Model:
    """The arm with some joints following others, each by (joint, ratio, offset)."""
    bodies = [
        replace(body, joint=replace(body.joint, mimic=Mimic(*followers[body.joint.name])))
        if body.joint.name in followers
        else body
        for body in model.bodies
    ]
    return replace(model, bodies=tuple(bodies))


def with_values(model: fb.Model) -> fb.Model:
    """Numbers for all parameters that have none; inertias between a half and one are physical."""
    rng = np.random.default_rng(3)
    return model.bind(**{name: rng.uniform(0.5, 1.0) for name in model.missing})
