"""Joints that nothing drives: where a torque is given for one, it is refused; what one would need,
it lacks."""

from __future__ import annotations

import numpy as np

from freebody.arrays import at_sample
from freebody.errors import PassiveJointError
from freebody.model.model import Model
from freebody.trees.public_calls import Vector, finite_vector


def refuse_passive(function: str, model: Model, tau: Vector) -> None:
    """Raise PassiveJointError where a torque tau (..., nv) acts at a passive joint."""
    passive = model.passive
    if not passive:
        return
    if type(tau) is np.ndarray and tau.shape == (model.nv,):  # plain Python is quicker there
        values = tau.tolist()
        if not any(values[k] for k in passive):
            return
    given = finite_vector(function, model, "tau", tau)[..., model.passive]
    bad = np.argwhere(given != 0.0)
    if len(bad):
        *sample, k = map(int, bad[0])
        value, name = float(given[tuple(bad[0])]), model.velocity_names[model.passive[k]]
        raise PassiveJointError(
            f"{function}: the torque of {name!r} is {value:g}{at_sample(sample)}, but the joint of "
            f"{model.name!r} is passive: nothing drives it. Give 0 there, or name it among "
            f"model.replace(actuated=[...])."
        )


def all_driven(model: Model) -> Model:
    """The model with a drive in every joint; the model itself where no joint is passive."""
    if not model.passive:
        return model
    return model.replace(actuated=[b.joint.name for b in model.bodies if b.joint.mimic is None])
