"""Springs of a model, with which generalized forces that pull alike are compared."""

from __future__ import annotations

import numpy as np

import freebody as fb

K = 20.0


def loaded(name: str) -> tuple[fb.Model, np.ndarray, np.ndarray]:
    """A closed chain that moves, and random generalized forces."""
    model, rng = fb.load(name), np.random.default_rng(5)
    q = fb.assemble(model, fb.neutral(model))
    qd = fb.loop_velocity(model, q, rng.normal(size=model.nv))
    return model, np.stack([q, qd]), rng.normal(size=model.nv)


def springs(model: fb.Model) -> fb.Model:
    """With a spring at each joint."""
    for name in model.joint_names:
        model = model.with_drive(name, stiffness=K, rest=0.3)
    return model
