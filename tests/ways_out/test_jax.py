"""Kernels inside JAX: values, maps, derivatives of every order, and the interface to XLA that they
rest on."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import textwrap
from concurrent.futures import ThreadPoolExecutor
from itertools import chain

import numpy as np
import pytest

import freebody as fb
from support.extras import extra
from support.real_files import ROBOTS

jax = extra("jax", "JAX", "jax")
jnp = jax.numpy


@pytest.fixture(autouse=True)
def doubles():
    with jax.enable_x64(True):
        yield


def state(model, *batch, seed=3, count=3):
    rng = np.random.default_rng(seed)
    q = rng.normal(size=(*batch, model.nq))
    return [q, *(rng.normal(size=(*batch, model.nv)) for _ in range(count - 1))]


QUANTITIES = {
    "ur5e": ("ur5e", "inverse_dynamics", {}),
    "panda": ("panda", "inverse_dynamics", {}),
    "free base": ("quadrotor", "forward_dynamics", {}),
    "closed chain": ("five_bar", "forward_dynamics", {}),
    "several": ("2R", ["inverse_dynamics", "mass_matrix", "bias"], {}),
    "derivatives": ("2R", "inverse_dynamics_derivatives", {}),
    "by": ("2R", "inverse_dynamics", {"by": ("q", "qd")}),
}


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "names", "options"), QUANTITIES.values(), ids=QUANTITIES)
def test_the_kernels_own_numbers_bit_by_bit(robot, names, options):
    model = fb.load(robot)
    kernel, function = fb.kernel(model, names, **options), fb.to_jax(model, names, **options)
    arrays = state(model, 37)
    expected = kernel(*arrays)
    for way in (function, jax.jit(jax.vmap(function))):
        agree(way(*arrays), expected)
    agree(function(*(x[5] for x in arrays)), kernel(*(x[5] for x in arrays)))
    agree(function(*(x.tolist() for x in arrays)), expected)  # whatever JAX makes arrays of
    empty = function(*(x[:0] for x in arrays))
    assert [x.shape for x in tupled(empty)] == [(0, *x.shape[1:]) for x in tupled(expected)]


def tupled(result):
    return result if isinstance(result, tuple) else (result,)


def agree(found, expected):
    for x, y in zip(tupled(found), tupled(expected), strict=True):
        np.testing.assert_array_equal(x, y)


def test_numbers_for_results():
    model = fb.load("ur5e")
    q, qd = state(model, 4, count=2)
    function = fb.to_jax(model, ["kinetic_energy", "potential_energy"])
    agree(function(q, qd), fb.kernel(model, ["kinetic_energy", "potential_energy"])(q, qd))
    slope = jax.vmap(jax.grad(lambda *x: function(*x)[0], 1))(q, qd)
    np.testing.assert_allclose(
        slope, np.einsum("nij,nj->ni", fb.mass_matrix(model, q), qd), rtol=1e-12
    )


SHAPES = {
    "all": [(4, 5, 6), (4, 5, 6), (4, 5, 6)],
    "one shared": [(100,), (), (100,)],
    "an outer and an inner one": [(3, 1), (1, 70), (3, 70)],
    "an inner one that is short": [(70, 1), (1, 3), ()],
    "mixed": [(2, 1, 3), (1, 70, 1), (2, 70, 3)],
    "more mixed": [(2, 1, 80), (1, 3, 1), ()],
    "ones": [(1, 1), (1,), ()],
    "empty": [(3, 0), (1,), ()],
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("shapes", SHAPES.values(), ids=SHAPES)
def test_batches_broadcast(shapes):
    model = fb.load("2R")
    arrays = [x[0] for x in (state(model, *shape, 1) for shape in shapes)]
    arrays = [x.reshape(*shape, 2) for x, shape in zip(arrays, shapes, strict=True)]
    agree(
        fb.to_jax(model, "inverse_dynamics")(*arrays), fb.kernel(model, "inverse_dynamics")(*arrays)
    )


def test_maps_within_maps_copy_nothing_that_is_shared():
    model = fb.load("ur5e")
    function = fb.to_jax(model, "inverse_dynamics")
    q, qd, qdd = state(model, 70)
    nested = jax.vmap(jax.vmap(function, (0, None, None)), (None, 0, None))
    agree(nested(q, qd, qdd[0]), fb.kernel(model, "inverse_dynamics")(q, qd[:, None], qdd[0]))
    text = str(jax.make_jaxpr(nested)(q, qd, qdd[0]))
    assert "ffi_call" in text
    assert "f64[70,70,6] = broadcast_in_dim" not in text
    agree(
        jax.vmap(function, -1)(*(np.moveaxis(x, 0, -1) for x in (q, qd, qdd))), function(q, qd, qdd)
    )


def test_without_x64_the_kernel_of_float32_computes():
    model = fb.load("ur5e")
    arrays = state(model, 9)
    with jax.enable_x64(False):
        found = fb.to_jax(model, "inverse_dynamics")(*arrays)
    assert found.dtype == np.float32
    agree(
        found,
        fb.kernel(model, "inverse_dynamics", dtype="float32")(*(np.float32(x) for x in arrays)),
    )
    of_floats = fb.to_jax(fb.kernel(model, "inverse_dynamics", dtype="float32"))
    assert of_floats(*arrays).dtype == np.float32


def test_types_promote_as_in_jax():
    model = fb.load("2R")
    function = fb.to_jax(model, "rk4_step")
    q = jnp.array([0.1, 0.2], dtype=jnp.float32)
    assert (
        function(q, q, q, 0.01)[0].dtype == np.float32
    )  # a number of Python's has no type of its own
    assert function(q, q, np.zeros(2), 0.01)[0].dtype == np.float64
    assert function([1, 0], [0, 0], [0, 0], 1)[0].dtype == np.float64
    agree(
        function([1, 0], [0, 0], [0, 0], 1), fb.kernel(model, "rk4_step")([1, 0], [0, 0], [0, 0], 1)
    )


DERIVED = {
    "ur5e": ("ur5e", "inverse_dynamics"),
    "plane": ("3R", "forward_dynamics"),
    "free base": ("quadrotor", "forward_dynamics"),
    "closed chain": ("five_bar", "forward_dynamics"),
    "a matrix": ("2R", "mass_matrix"),
}


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "name"), DERIVED.values(), ids=DERIVED)
def test_derivatives_forward_and_reverse(robot, name):
    """Against central differences of the kernel; by all nq entries of q, also off unit
    quaternions."""
    model = fb.load(robot)
    kernel, function = fb.kernel(model, name), fb.to_jax(model, name)
    arrays = state(model, 3, count=len(kernel.program.inputs))
    every = tuple(range(len(arrays)))
    forward = jax.vmap(jax.jacfwd(function, every))(*arrays)
    reverse = jax.jit(jax.vmap(jax.jacrev(function, every)))(*arrays)
    for k, (one, other) in enumerate(zip(forward, reverse, strict=True)):
        scale = np.abs(one).max()
        np.testing.assert_allclose(one, other, rtol=0, atol=1e-13 * scale)
        np.testing.assert_allclose(one, differences(kernel, arrays, k), rtol=0, atol=2e-7 * scale)


def differences(kernel, arrays, k, step=1e-5):
    columns = []
    for place in range(arrays[k].shape[-1]):
        ends = []
        for sign in (1.0, -1.0):
            moved = [x.copy() for x in arrays]
            moved[k][..., place] += sign * step
            ends.append(np.asarray(kernel(*moved)))
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.stack(columns, axis=-1)


def test_derivatives_are_those_of_the_text():
    """Of JAX's own differentiation of the same arithmetic written out, to 1e-10; by positions with
    quaternions."""
    model = fb.load("quadrotor")
    scope: dict = {}
    exec(fb.source(model, "inverse_dynamics", "jax"), scope)
    arrays = [x[0] for x in state(model, 1)]
    found = jax.jacfwd(fb.to_jax(model, "inverse_dynamics"), (0, 1, 2))(*arrays)
    expected = jax.jacfwd(jax.jit(scope["inverse_dynamics"]), (0, 1, 2))(*arrays)
    for one, other in zip(found, expected, strict=True):
        np.testing.assert_allclose(one, other, rtol=1e-10, atol=1e-12)


def test_second_derivatives():
    model = fb.load("3R")
    arrays = [x[0] for x in state(model, 1)]
    expected = fb.kernel(model, "inverse_dynamics_second_derivatives")(*arrays)
    function = fb.to_jax(model, "inverse_dynamics")
    hessian = jax.jit(jax.hessian(function, (0, 1)))(*arrays)
    pairs = {(0, 0): expected[0], (1, 0): expected[1], (1, 1): expected[2]}
    for (i, j), wanted in pairs.items():
        np.testing.assert_allclose(hessian[i][j], wanted, rtol=1e-10, atol=1e-11)
        np.testing.assert_allclose(hessian[j][i], np.swapaxes(wanted, 1, 2), rtol=1e-10, atol=1e-11)
    outward = jax.jacrev(jax.jacrev(function))(*arrays)
    np.testing.assert_allclose(outward, expected[0], rtol=1e-10, atol=1e-11)


def test_one_direction_and_one_gradient_have_kernels_of_their_own():
    """And many directions for the same values go through one whole Jacobian; all ways agree."""
    model = fb.load("3R")
    function = fb.to_jax(model, "inverse_dynamics")
    arrays = state(model, 5)
    tables = fb.inverse_dynamics_derivatives(model, *arrays)
    rng = np.random.default_rng(1)
    rates, weight = list(rng.normal(size=(3, 5, 3))), rng.normal(size=(5, 3))

    value, along = jax.jvp(function, tuple(arrays), tuple(rates))
    agree(value, fb.kernel(model, "inverse_dynamics")(*arrays))
    expected = sum(np.einsum("nij,nj->ni", A, x) for A, x in zip(tables, rates, strict=True))
    np.testing.assert_allclose(along, expected, rtol=1e-11, atol=1e-12)
    _, back = jax.vjp(function, *arrays)
    for one, table in zip(back(weight), tables, strict=True):
        np.testing.assert_allclose(
            one, np.einsum("nij,ni->nj", table, weight), rtol=1e-11, atol=1e-12
        )
    # the transpose of the transpose is the way along
    forward = jax.linear_transpose(back, weight)
    np.testing.assert_allclose(forward(tuple(rates))[0], along, rtol=1e-11, atol=1e-12)

    def how(made):
        return set(re.findall(r"matrix=(True|False)", str(jax.make_jaxpr(made)(*arrays))))

    assert how(jax.vmap(jax.grad(lambda *x: jnp.sum(function(*x))))) == {"False"}
    assert how(jax.vmap(jax.jacfwd(function))) == how(jax.vmap(jax.jacrev(function))) == {"True"}


def test_every_sample_may_have_directions_of_its_own():
    model = fb.load("3R")
    function = fb.to_jax(model, "inverse_dynamics")
    q, qd, qdd = state(model, 2)
    directions, weights = np.random.default_rng(6).normal(size=(2, 2, 2, 3))
    table = fb.inverse_dynamics_derivatives(model, q, qd, qdd)[0]

    def along(q, qd, qdd, directions):
        return jax.vmap(lambda d: jax.jvp(lambda x: function(x, qd, qdd), (q,), (d,))[1])(
            directions
        )

    def back(q, qd, qdd, weights):
        return jax.vmap(lambda w: jax.vjp(lambda x: function(x, qd, qdd), q)[1](w)[0])(weights)

    found = jax.vmap(along)(q, qd, qdd, directions)
    np.testing.assert_allclose(
        found, np.einsum("nij,ndj->ndi", table, directions), rtol=1e-11, atol=1e-12
    )
    found = jax.vmap(back)(q, qd, qdd, weights)
    np.testing.assert_allclose(
        found, np.einsum("nij,ndi->ndj", table, weights), rtol=1e-11, atol=1e-12
    )


def test_what_is_shared_by_a_batch_has_the_sum_of_its_gradients():
    model = fb.load("2R")
    function = fb.to_jax(model, ["inverse_dynamics", "mass_matrix"])
    q, qd, qdd = state(model, 6)
    tables = fb.inverse_dynamics_derivatives(model, q, qd[0], qdd[:1])

    def loss(q, qd, qdd):
        tau, M = function(q, qd, qdd)
        return jnp.sum(tau) + jnp.sum(M[:, 0, 1])

    gradients = jax.grad(loss, (1, 2))(q, qd[0], qdd[:1])
    np.testing.assert_allclose(gradients[0], tables[1].sum((0, 1)), rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(gradients[1], tables[2].sum((0, 1))[None], rtol=1e-12)
    each = jax.vmap(jax.grad(loss, (0, 1)), (None, 0, None))(q, qd, qdd)
    for k in range(6):
        for one, other in zip(each, jax.grad(loss, (0, 1))(q, qd[k], qdd), strict=True):
            np.testing.assert_allclose(one[k], other, rtol=1e-11, atol=1e-11)
    apart = jax.vmap(lambda w: jax.vjp(lambda x: function(q, x, qdd)[0], qd[0])[1](w)[0])(
        np.eye(12).reshape(12, 6, 2)
    )
    expected = fb.inverse_dynamics_derivatives(model, q, qd[0], qdd)[1].reshape(12, 2)
    np.testing.assert_allclose(apart, expected, rtol=1e-11, atol=1e-12)


def test_derivatives_of_gradients():
    """A Hessian times a vector, three ways, one of them over a checkpoint; and the whole Hessian of
    the energy."""
    model = fb.load("2R")
    function = fb.to_jax(model, "forward_dynamics")
    q, qd, tau = (x[0] for x in state(model, 1))
    v = np.array([0.3, -0.2])

    def loss(q):
        return jnp.sum(function(q, qd, tau) ** 2)

    _, forward = jax.jvp(jax.grad(loss), (q,), (v,))
    reverse = jax.grad(lambda q: jax.grad(loss)(q) @ v)(q)
    again = jax.grad(lambda q: jax.grad(jax.checkpoint(loss))(q) @ v)(q)
    whole = jax.hessian(loss)(q)
    for one in (forward, reverse, again):
        np.testing.assert_allclose(one, whole @ v, rtol=1e-9, atol=1e-9 * np.abs(whole).max())
    ends = [jax.grad(loss)(q + h * v) for h in (1e-6, -1e-6)]
    np.testing.assert_allclose(forward, (ends[0] - ends[1]) / 2e-6, rtol=1e-5)


def test_wrenches_and_numbers_of_the_model():
    """The Jacobian tells what a wrench does; mass is what the regressor multiplies; p is shared, or
    one for each."""
    model = fb.load("ur5e")
    q, qd, qdd = state(model, 80)
    loaded = fb.to_jax(model, "static_torque", wrench_frames=["wrist_3_link"])
    by_wrench = jax.vmap(jax.jacfwd(loaded, 1))(q, np.zeros((80, 6)))
    jacobian = fb.jacobian(model, q, "wrist_3_link")
    np.testing.assert_allclose(by_wrench, -np.swapaxes(jacobian, -1, -2), atol=1e-12)

    kernel = fb.kernel(model, "inverse_dynamics", inputs=["*.mass"])
    function = fb.to_jax(kernel)
    assert function.parameters == kernel.parameters
    agree(function.values, kernel.values)
    p = np.array(function.values)
    agree(function(q, qd, qdd, p), kernel(q, qd, qdd))
    agree(jax.vmap(function, (0, 0, 0, None))(q, qd, qdd, p), kernel(q, qd, qdd))
    each = p * np.linspace(0.5, 1.5, 80)[:, None]
    agree(jax.vmap(function)(q, qd, qdd, each), kernel(q, qd, qdd, each))
    robots = jax.vmap(jax.vmap(function, (0, 0, 0, None)), (None, None, None, 0))
    # the numbers of a robot are read once for all its samples, which rounds in another way
    expected = kernel(q, qd, qdd, each[:3, None])
    np.testing.assert_allclose(robots(q, qd, qdd, each[:3]), expected, rtol=1e-12, atol=1e-12)
    slope = jax.jacrev(function, 3)(q[0], qd[0], qdd[0], p)
    expected = fb.kernel(model, "inverse_dynamics", inputs=["*.mass"], by="p")(q[0], qd[0], qdd[0])[
        1
    ]
    np.testing.assert_allclose(slope, expected, rtol=1e-11, atol=1e-11)
    agree(
        fb.to_jax(model, "inverse_dynamics", inputs=["*.mass"])(q, qd, qdd, p),
        function(q, qd, qdd, p),
    )


def test_the_gradient_through_a_simulation():
    """By the first position, through a hundred steps of a scan: forward and reverse agree, and with
    differences."""
    model = fb.load("2R")
    accelerate = fb.to_jax(model, "forward_dynamics")
    h, tau = 0.005, jnp.array([0.3, -0.1])

    def rates(x):
        return jnp.concatenate([x[2:], accelerate(x[:2], x[2:], tau)])

    def step(x, _):
        k1 = rates(x)
        k2 = rates(x + 0.5 * h * k1)
        k3 = rates(x + 0.5 * h * k2)
        k4 = rates(x + h * k3)
        return x + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4), None

    @jax.jit
    def end(x):
        return jnp.sum(jax.lax.scan(step, x, None, length=100)[0] ** 2)

    x = jnp.array([0.3, 0.4, 0.0, 0.1])
    reverse = jax.jit(jax.grad(end))(x)
    np.testing.assert_allclose(reverse, jax.jacfwd(end)(x), rtol=1e-10)
    moved = [(end(x.at[k].add(1e-6)) - end(x.at[k].add(-1e-6))) / 2e-6 for k in range(4)]
    np.testing.assert_allclose(reverse, moved, rtol=1e-6)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("kind", "right"), [("implicit_step", True), ("semi_implicit_step", False)]
)
def test_gradients_from_rest_with_coulomb_friction(kind, right):
    """Right through the step whose friction is smooth, and not through one that has sign(q̇), as
    the docs warn."""
    model = fb.planar("RR", l=[0.5, 0.4], lc=[0.25, 0.2], m=[2.0, 1.0], I=[0.05, 0.02])
    step = fb.to_jax(model, kind, inputs=["joint*.friction.coulomb"])

    @jax.jit
    def end(torques):
        def moved(state, tau):
            return step(*state, tau, 1e-3, jnp.array([1.0, 0.5])), None

        (q, _), _ = jax.lax.scan(moved, (jnp.array([0.3, 0.4]), jnp.zeros(2)), torques)
        return 1e4 * jnp.sum(q)

    hold = fb.gravity_torque(model, [0.3, 0.4])  # against friction, nothing moves
    torques, change = np.tile(hold, (20, 1)), np.array([0.3, 0.2]) * np.ones((20, 1))
    slope = float(jnp.sum(jax.grad(end)(torques) * change))
    moved = float(end(torques + 1e-4 * change) - end(torques - 1e-4 * change)) / 2e-4
    assert (abs(slope - moved) < 1e-4 * abs(moved)) == right, (slope, moved)


def test_whole_numbers_and_what_is_not_differentiated():
    model = fb.load("2R")
    function = fb.to_jax(model, "inverse_dynamics")
    slope = jax.jacfwd(lambda q: function(q, np.array([0, 1]), jnp.array([1, 0])))(
        np.array([0.1, 0.2])
    )
    expected = fb.inverse_dynamics_derivatives(model, [0.1, 0.2], [0.0, 1.0], [1.0, 0.0])[0]
    np.testing.assert_allclose(slope, expected, rtol=1e-12)
    value, along = jax.jvp(function, (jnp.ones(2),) * 3, (jnp.zeros(2),) * 3)
    agree(value, fb.kernel(model, "inverse_dynamics")(np.ones(2), np.ones(2), np.ones(2)))
    agree(along, np.zeros(2))


def test_a_sample_that_is_no_number_is_none_in_all_outputs_and_touches_no_other():
    model = fb.load("ur5e")
    arrays = state(model, 20)
    good = fb.kernel(model, "inverse_dynamics")(*arrays)
    arrays[1][7, 2] = np.nan
    found = np.array(jax.jit(fb.to_jax(model, "inverse_dynamics"))(*arrays))
    assert np.isnan(found[7]).all()
    agree(np.delete(found, 7, 0), np.delete(good, 7, 0))


def test_tiny_numbers_are_what_they_are():
    """XLA takes them for zero, kernels do not: so results do not depend on who calls."""
    kernel = fb.compile(lambda x: x * 0.5, {"x": ()})
    assert float(fb.to_jax(kernel)(3e-310)) == kernel(3e-310) > 0.0


def test_threads():
    model = fb.load("ur5e")
    arrays = state(model, 300)
    expected = fb.kernel(model, "inverse_dynamics")(*arrays)
    function = jax.jit(fb.to_jax(model, "inverse_dynamics"))

    def work(_):
        with jax.enable_x64(True):
            return [np.array(function(*arrays)) for _ in range(20)]

    with ThreadPoolExecutor(4) as pool:
        for result in chain(*pool.map(work, range(4))):
            agree(result, expected)


def test_long_batches_are_shared_among_threads_without_a_trace(monkeypatch):
    """Of every size and shape, also by several callers at a time: each sample is the kernel's
    own."""
    monkeypatch.setattr("freebody.targets.kernel._WORTH", 200.0)
    kernel = fb.compile(
        lambda x, y: [x * 1.2345678, x / (y[0] * y[0] + y[1])], {"x": (), "y": 2}, {"z": 2}
    )
    assert kernel.samples_of_a_thread < 20
    function = jax.jit(fb.to_jax(kernel))
    rng = np.random.default_rng(4)
    for shapes in (
        ((1,), (1,)),
        ((17,), (17,)),
        ((1000,), ()),
        ((100_001,), (100_001,)),
        ((3, 1), (1, 70)),
        ((40, 300), (1, 300)),
    ):
        x, y = rng.normal(size=shapes[0]), rng.normal(size=(*shapes[1], 2))
        agree(function(x, y), kernel(x, y))
    x, y = rng.normal(size=(10_000,)), rng.normal(size=(10_000, 2))
    expected = kernel(x, y)

    def call(_):
        with jax.enable_x64(True):
            return [np.array(function(x, y)) for _ in range(50)]

    with ThreadPoolExecutor(4) as pool:
        for result in chain(*pool.map(call, range(4))):
            agree(result, expected)


def test_symbols_without_values_are_refused():
    with pytest.raises(
        fb.FreebodyError, match=r"numbers need a value for I1, I2, l1, l2, lc1, lc2, m1, m2"
    ):
        fb.to_jax(fb.planar("RR"), "inverse_dynamics")
    family = fb.load("2R").bind(m1=[1.0, 2.0])
    with pytest.raises(
        fb.FreebodyError,
        match=r"fb.to_jax without inputs=: '2R' is a family of robots, shape \(2,\)",
    ):
        fb.to_jax(family, "inverse_dynamics")
    found = fb.to_jax(family, "inverse_dynamics", inputs=["m1"])
    agree(
        found([0.1, 0.2], [0.0, 0.0], [0.0, 0.0], found.values),
        fb.inverse_dynamics(family, [0.1, 0.2], [0.0, 0.0], [0.0, 0.0]),
    )


@pytest.mark.long
def test_a_humanoid():
    """Values bit by bit; directions and gradients are each other's transpose, and those of the
    formula."""
    path = ROBOTS / "talos_data/robots/talos_reduced.urdf"
    if not path.exists():
        pytest.skip("example-robot-data is not installed")
    model = fb.load(path, base="free", tip="left_sole_link")
    for name in ("inverse_dynamics", "forward_dynamics"):
        function, arrays = fb.to_jax(model, name), [x[0] for x in state(model, 1)]
        agree(function(*arrays), fb.kernel(model, name)(*arrays))
        tables = fb.kernel(model, f"{name}_derivatives")(*arrays)
        rates, weight = state(model, seed=8), np.random.default_rng(1).normal(size=model.nv)
        _, along = jax.jvp(function, tuple(arrays), tuple(rates))
        _, back = jax.vjp(function, *arrays)
        slopes = back(weight)
        np.testing.assert_allclose(
            weight @ along, sum(x @ y for x, y in zip(slopes, rates, strict=True)), rtol=1e-9
        )
        for slope, table in zip(slopes[1:], tables[1:], strict=True):
            scale = np.abs(slope).max()
            np.testing.assert_allclose(slope / scale, weight @ table / scale, atol=1e-9)


PROGRAM = """
    import sys, numpy as np, jax
    jax.config.update("jax_enable_x64", True)
    jax.config.update("jax_compilation_cache_dir", sys.argv[1])
    jax.config.update("jax_persistent_cache_min_compile_time_secs", 0)
    jax.config.update("jax_persistent_cache_min_entry_size_bytes", -1)
    import freebody as fb
    hits = []
    jax.monitoring.register_event_listener(lambda name, **_: hits.append(name))
    model = fb.load("2R")
    q = np.array([[0.1, 0.2], [0.3, 0.4]])
    slope = jax.jit(jax.vmap(jax.jacrev(fb.to_jax(model, "inverse_dynamics"))))(q, q, q)
    assert np.allclose(slope, fb.inverse_dynamics_derivatives(model, q, q, q)[0])
    print(sum(name.endswith("cache_hits") for name in hits))
"""


def test_programs_that_jax_keeps_on_disk_run_in_another_process(tmp_path):
    hits = []
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", textwrap.dedent(PROGRAM), str(tmp_path)],
            capture_output=True,
            text=True,
            timeout=120,
            check=False,
        )
        assert done.returncode == 0, done.stderr
        hits.append(int(done.stdout.split()[-1]))
    assert hits[1] > hits[0]


def test_a_dtype_that_is_asked_for_is_computed_with():
    model = fb.load("ur5e")
    arrays = state(model, 9)
    single = fb.to_jax(model, "inverse_dynamics", dtype="float32")
    found = single(*arrays)
    assert found.dtype == np.float32
    agree(found, fb.kernel(model, "inverse_dynamics", dtype="float32")(*arrays))
    assert jax.jacfwd(single)(*(x[0] for x in arrays)).dtype == np.float32
    double = fb.to_jax(model, "inverse_dynamics", dtype="float64")
    rounded = [np.float32(x) for x in arrays]
    agree(double(*rounded), fb.kernel(model, "inverse_dynamics")(*rounded))
    of_kernel = fb.to_jax(fb.kernel(model, "inverse_dynamics"), dtype="float32")
    agree(of_kernel(*arrays), found)
    with pytest.raises(fb.FreebodyError, match="dtype='float16'; it can be 'float64' or 'float32'"):
        fb.to_jax(model, "inverse_dynamics", dtype="float16")
    with pytest.raises(fb.FreebodyError, match="q holds complex numbers, expected real numbers"):
        single(arrays[0] + 1j, *arrays[1:])
    with jax.enable_x64(False), pytest.raises(fb.FreebodyError, match="makes all numbers float32"):
        fb.to_jax(model, "inverse_dynamics", dtype="float64")


def test_numbers_of_the_model_by_name():
    model, names = fb.load("ur5e"), ["payload.mass", "forearm_link.mass"]
    q, qd, qdd = state(model, 7)
    masses, twice = np.linspace(0.0, 3.0, 7), {("forearm_link", "mass"): 2.0}
    kernel = fb.kernel(model, "inverse_dynamics", inputs=names)
    for function in (fb.to_jax(kernel), fb.to_jax(model, "inverse_dynamics", inputs=names)):
        agree(function(q, qd, qdd), kernel(q, qd, qdd))
        by_name = twice | {"payload.mass": masses}
        for found in (
            function(q, qd, qdd, p=by_name),
            jax.jit(lambda m, f=function: f(q, qd, qdd, p={**twice, "payload.mass": m}))(masses),
        ):
            agree(found, kernel(q, qd, qdd, p=by_name))
        slope = jax.jacfwd(lambda m, f=function: f(q[0], qd[0], qdd[0], p={"payload.mass": m}))(1.0)
        steps = (kernel(q[0], qd[0], qdd[0], p={"payload.mass": m}) for m in (2.0, 1.0))
        np.testing.assert_allclose(slope, np.subtract(*steps), atol=1e-11)
        # the model's own numbers are of the type of what is given
        assert function(*map(np.float32, (q, qd, qdd)), p={"payload.mass": 1.0}).dtype == np.float32
        with pytest.raises(fb.FreebodyError, match=r"'shoulder_link.mass' is not an input"):
            function(q, qd, qdd, p={"shoulder_link.mass": 1.0})
    with pytest.raises(fb.FreebodyError, match="it has no numbers of the model as inputs"):
        fb.to_jax(model, "inverse_dynamics")(q, qd, qdd, p={"payload.mass": 1.0})
    symbols = fb.to_jax(fb.planar("RR"), "gravity_torque", inputs=["*"])
    with pytest.raises(fb.FreebodyError, match="need a value for"):
        symbols([0.1, 0.2], p={"l1": 1.0})


def test_arrays_on_several_devices_are_cut_along_the_batch():
    """Nothing is gathered but vectors in pieces; explicit axes are refused."""
    done = subprocess.run(
        [sys.executable, "-m", "support.sharded"],
        capture_output=True,
        text=True,
        env={**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p)},
        timeout=300,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-2000:]
    assert "mass_matrix: q lies on several devices" in done.stdout
    assert "jax.shard_map" in done.stdout
