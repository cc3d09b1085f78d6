"""The recursions themselves, called on numbers: those that compute the same by other ways agree.

No public function tells by which recursion it computes, so these are asked for by name.
"""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from freebody.algorithms import forward_dynamics
from freebody.algorithms.aba import aba
from freebody.algorithms.crba import bias, crba
from freebody.algorithms.kinematics import coordinate_rates
from freebody.algorithms.regrouped_parameters import lightened
from freebody.algorithms.rnea import External, external_on_frame, rnea
from freebody.any_chain.kernel_options import chosen_option
from freebody.kernels.formulas import FORMULAS
from freebody.kernels.parameter_inputs import inputs_of
from freebody.kernels.tracing import chosen
from support import generate
from support.helpers import (
    close,
    numbers,
    random_wrenches,
    scalars,
    state,
)
from support.tree_marks import every_tree


@pytest.mark.parametrize("seed", [4, 20])
def test_rates_of_the_coordinates_of_a_step(seed: int):
    """dexp⁻¹(x) v is how the way from q to q ⊕ x changes when the robot moves on with v; three
    terms of it."""
    model = generate.model(seed)
    q, v, x = fb.random_state(model, seed)
    x, tiny = 0.3 * x / np.abs(x).max(), 1e-5
    ahead, back = (
        fb.difference(model, q, fb.integrate(model, fb.integrate(model, q, x), t * v))
        for t in (tiny, -tiny)
    )
    found = coordinate_rates(model.tree, tuple(x), tuple(v))
    np.testing.assert_allclose(
        found, (ahead - back) / (2 * tiny), rtol=0, atol=1e-4 * np.abs(v).max()
    )


@pytest.mark.parametrize("dim", [2, 3])
@pytest.mark.parametrize("seed", range(20))
def test_other_bodies_under_which_it_moves_alike(seed: int, dim: int):
    """A step's program is shorter by regrouped inertial numbers; M and the bias are those of the
    robot's own."""
    model = generate.model(seed, dim)
    q, qd, _ = fb.random_state(model, seed)
    own, light = model.tree, lightened(model.tree)
    for found, expected in ((crba(light, q), crba(own, q)), (bias(light, q, qd), bias(own, q, qd))):
        scale = np.abs(np.array(expected, dtype=float)).max()
        np.testing.assert_allclose(
            np.array(found, dtype=float),
            np.array(expected, dtype=float),
            rtol=0,
            atol=1e-13 * scale,
        )
    if not own.follows:
        np.testing.assert_allclose(aba(light, q, qd, qd), aba(own, q, qd, qd), rtol=1e-8, atol=1e-8)


def external(model: Model, q: np.ndarray, loads: dict[str, np.ndarray]) -> list[External]:
    given = (
        external_on_frame(model.tree, scalars(q), name, scalars(w)) for name, w in loads.items()
    )
    return [load for load in given if load is not None]


@pytest.mark.sample(14)
@every_tree
def test_forward_dynamics_by_composite_and_by_articulated_bodies(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    condition = np.linalg.cond(numbers(model, "mass_matrix", q)).max()
    allowed = max(1e-10, 1e3 * np.finfo(float).eps * condition)
    given = (model.tree, scalars(q), scalars(qd), scalars(tau), external(model, q, loads))
    found = np.stack(np.broadcast_arrays(*forward_dynamics.forward_dynamics(*given)), -1)
    close(found, qdd, allowed, what="composite bodies")
    if model.tree.follows:
        with pytest.raises(AssertionError, match="moves several joints"):
            aba(*given)
    else:
        found = np.stack(np.broadcast_arrays(*aba(*given)), -1)
        close(found, qdd, allowed, what="articulated bodies")


@pytest.mark.sample(17)
@every_tree
def test_gravity_as_base_acceleration_or_explicit(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    given = (
        model.tree,
        scalars(q),
        scalars(qd),
        scalars(qdd),
        external(model, q, random_wrenches(model, seed, 3)),
    )
    base, explicit = rnea(*given, gravity="base"), rnea(*given, gravity="explicit")
    for a, b in (
        (base.tau, explicit.tau),
        *zip(base.f, explicit.f, strict=True),
        *zip(base.n, explicit.n, strict=True),
    ):
        a, b = (np.stack(np.broadcast_arrays(*x, q[..., 0]), -1) for x in (a, b))
        close(a, b, 1e-12, 10.0 + float(abs(b).max()), "two ways of gravity")


@pytest.mark.usefixtures("numpy_kernels")
def test_directions_of_power_that_do_not_settle_are_told(monkeypatch):
    """By the number of sweeps, which is enough for all states that were tried, made too small."""
    monkeypatch.setattr(forward_dynamics, "_SWEEPS", 1)
    drive = fb.Drive(load_friction=0.2, efficiency=0.8, back_efficiency=0.6, rotor=0.3, gear=10.0)
    model = fb.planar(
        "RRP",
        m=[1.0, 2.0, 0.5],
        lc=[0.3, 0.2, 0.1],
        l=[0.7, 0.6, 0.4],
        I=[0.1, 0.2, 0.05],
        drives=[drive, None, drive],
    )
    q, qd, tau = np.random.default_rng(0).normal(size=(3, 50, 3)) * 3.0
    with pytest.raises(
        fb.SingularError, match=r"way power flows through joint1 and joint3 of 'RRP"
    ):
        fb.forward_dynamics(model, q, qd, tau)
    found = fb.kernel(model, "forward_dynamics", target="numpy")(q, qd, tau)
    settled = np.isfinite(found).all(axis=1)
    assert 0 < settled.sum() < 50
    again = fb.inverse_dynamics(model, q[settled], qd[settled], found[settled])
    np.testing.assert_allclose(again, tau[settled], atol=1e-11)


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


@pytest.mark.sample(1)
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
