"""Derivatives by a robot's own numbers, against the complex step: f(p + ih) has the derivative as
its imaginary part.

The step is taken in plain complex arithmetic over the model's tree: neither scalars with slopes nor
compiled code nor regrouped numbers take part, and no difference is formed that would round (W.
Squire, G. Trapp, SIAM Review 40, 1998).
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody.any_chain.kernel_options import chosen_option
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.parameter_inputs import inputs_of
from freebody.kernels.tracing import chosen
from support import generate

pytestmark = pytest.mark.usefixtures("numpy_kernels")

STEP = 1e-40
QUANTITIES = ("inverse_dynamics", "forward_dynamics", "mass_matrix", "forward_kinematics")
TERMS = {"viscous": 0.3, "coulomb": 0.2, "rotor": 1e-4, "gear": 50.0, "stiffness": 2.0}


def ur5e() -> fb.Model:
    return (
        fb.load("ur5e")
        .with_drive("elbow_joint", **TERMS)
        .with_payload(mass=1.5, com=(0.01, 0.02, 0.1))
    )


def planar() -> fb.Model:
    arm = fb.planar(
        "RRP", l=[0.5, 0.4, 0.2], lc=[0.2, 0.3, 0.1], m=[3.0, 2.0, 1.0], I=[0.1, 0.05, 0.02]
    )
    return arm.with_drive(arm.joint_names[1], **TERMS)


def free_base() -> fb.Model:
    model = generate.model(4)
    joint = next(b.joint.name for b in model.bodies if b.kind.nv == 1)
    return model.with_drive(joint, **TERMS)


def complex_steps(
    model: fb.Model, name: str, names: list[str], arrays: dict[str, np.ndarray]
) -> np.ndarray:
    """∂f/∂p (*output, k), all k in one evaluation over arrays of complex numbers."""
    given = inputs_of("fb.kernel", model, names)
    p = given.values[:, None] + 1j * STEP * np.eye(len(given.names))
    _, option = chosen_option(model, name)
    taken = chosen(name, {k: tuple(map(float, x)) for k, x in arrays.items()}, option)
    (value,) = FORMULAS[name].evaluate(given.tree(list(p)), option, **taken)
    shape = fb.kernel(model, name).program.outputs[0].shape
    entries = [value]
    for _ in shape:
        entries = [x for row in entries for x in row]
    return np.stack([np.broadcast_to(np.imag(x) / STEP, len(p)) for x in entries]).reshape(
        *shape, len(p)
    )


@pytest.mark.parametrize("name", QUANTITIES)
@pytest.mark.parametrize("robot", [ur5e, planar, free_base])
def test_derivatives_by_any_number_are_those_of_the_complex_step(robot, name):
    model = robot()
    known = [r for r in fb.parameters(model) if not r.limit]
    # some, and of each kind (mass, com.x, placement.yaw, a, viscous, …) the last, zeros and right
    # angles too
    kinds = {r.parts[1:] or r.name: r.name for r in known}
    names = list(dict.fromkeys([*(r.name for r in known[::9]), *kinds.values()]))
    kernel = fb.kernel(model, name, inputs=names, by="p")
    q, qd, last = fb.random_state(model, 7)
    arrays = {"q": q, "qd": qd, "qdd": last, "tau": last}
    _, found = kernel(*(arrays[a.name] for a in kernel.program.inputs[:-1]))
    expected = complex_steps(model, name, list(kernel.parameters), arrays)
    assert abs(expected).max() > 1e-3
    for k, label in enumerate(kernel.parameters):
        size = max(1.0, abs(expected[..., k]).max())
        assert np.allclose(found[..., k], expected[..., k], rtol=1e-10, atol=1e-10 * size), label
