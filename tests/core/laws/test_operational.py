"""Operational space, centroidal quantities and regressors against their definitions."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import Drive, SingularError
from support.branched import MODELS

pytestmark = pytest.mark.usefixtures("numpy_kernels")


@pytest.fixture(params=MODELS)
def case(request):
    model = MODELS[request.param]()
    return model, *fb.random_state(model, seed=11, batch=4)


def test_mass_matrix_inverse(case):
    model, q, _, _ = case
    product = fb.mass_matrix_inverse(model, q) @ fb.mass_matrix(model, q)
    np.testing.assert_allclose(product, np.broadcast_to(np.eye(model.nv), product.shape), atol=1e-9)


def test_regressor_times_parameters_is_inverse_dynamics(case):
    model, q, qd, qdd = case
    tau = fb.regressor(model, q, qd, qdd) @ np.array(list(fb.inertial_parameters(model).values()))
    np.testing.assert_allclose(
        tau, fb.inverse_dynamics(model, q, qd, qdd), rtol=1e-11, atol=1e-11 * np.abs(tau).max()
    )


def test_energy_regressor_times_parameters_is_energy(case):
    model, q, qd, _ = case
    parameters = fb.inertial_parameters(model)
    kinetic, potential = np.moveaxis(
        fb.energy_regressor(model, q, qd) @ np.array(list(parameters.values())), -1, 0
    )
    np.testing.assert_allclose(kinetic, fb.kinetic_energy(model, q, qd), rtol=1e-11)
    missing = fb.potential_energy(model, q) - potential
    np.testing.assert_allclose(
        missing, np.broadcast_to(missing[:1], missing.shape), rtol=1e-9, atol=1e-9
    )


def test_links_on_the_base_have_energy_as_they_have_mass():
    """`mass` and `center_of_mass` counted them, and energies did not."""
    arm = fb.load("panda")
    for model in (arm, arm.bind({"panda_link0.mass": np.linspace(0.0, 5.0, 4)})):
        q = fb.random_state(arm, seed=3)[0]
        expected = -model.mass * (fb.center_of_mass(model, q) * model.gravity).sum(-1)
        np.testing.assert_allclose(fb.potential_energy(model, q), expected, rtol=1e-13)
    kernel = fb.kernel(arm, "potential_energy", inputs=["panda_link0.mass"])
    np.testing.assert_allclose(kernel(q, p=np.array([[5.0]])), expected[-1:], rtol=1e-13)


def test_links_on_the_base_have_energy_in_every_derivation():
    arm = fb.load("2R").with_payload(mass=3.0, com=[0.1, 0.2], frame="base")
    q, eqs = [0.3, 0.4], fb.equations(arm)
    assert eqs.evaluate(eqs.V, q) == pytest.approx(fb.potential_energy(arm, q), rel=1e-14)
    text = fb.derive(arm, "lagrange").text()
    assert "V₀ = 3/5 g" in text
    assert "L = T₁ + T₂ − (V₀ + V₁ + V₂)" in text
    absolute = fb.derive(arm, "lagrange-first-kind", coordinates="absolute").text()
    assert "V = m₁ g y₁ + m₂ g y₂ + 3/5 g" in absolute
    words = {str(x.symbols[0]): x.words for x in fb.derive(arm, "lagrange").glossary}
    assert words["V₀"] == "potential energy of what is fixed to the base"


def test_centroidal_momentum(case):
    model, q, qd, _ = case
    momentum = (fb.centroidal_momentum_matrix(model, q) @ qd[..., None])[..., 0]
    moving = model.without("rotors")
    mass = moving.mass - sum(part.inertia.numbers()[0] for part in moving.base_inertias)
    free = fb.Model(**{**vars_of(moving), "base_inertias": ()})
    centre = fb.center_of_mass(free, q)
    np.testing.assert_allclose(
        momentum, fb.momentum(model, q, qd, about=centre), rtol=1e-9, atol=1e-10
    )
    still = np.zeros_like(qd)
    h = 1e-5
    velocity = (
        fb.center_of_mass(free, fb.integrate(model, q, h * qd))
        - fb.center_of_mass(free, fb.integrate(model, q, -h * qd))
    ) / (2 * h)
    np.testing.assert_allclose(momentum[..., : model.dim], mass * velocity, rtol=1e-6, atol=1e-7)
    assert not fb.momentum(model, q, still).any()


def vars_of(model):
    """The fields that a model is made of."""
    return {name: getattr(model, name) for name in model.__dataclass_fields__}


def test_operational_space_moves_the_frame_as_it_says(case):
    model, q, qd, _ = case
    frame, rows = model.leaves[-1] if model.tip is None else model.tip, ("vx", "vy")
    inertia = fb.operational_space_inertia(model, q, frame, rows)
    rest = fb.operational_space_bias(model, q, qd, frame, rows)
    wanted = np.array([0.3, -0.7])
    force = (inertia @ wanted) + rest
    J = fb.jacobian(model, q, frame)[..., :2, :]
    tau = np.einsum("nij,ni->nj", J, force)
    qdd = fb.forward_dynamics(model, q, qd, tau)
    moved = fb.acceleration(model, q, qd, qdd, frame)[..., :2]
    np.testing.assert_allclose(moved, np.broadcast_to(wanted, moved.shape), atol=1e-8)


def test_rows_that_cannot_be_are_refused():
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1])
    with pytest.raises(
        fb.FreebodyError, match=r"has 2 joint coordinates and cannot move a frame along 3 rows"
    ):
        fb.operational_space_inertia(model, [0.1, 0.2])
    with pytest.raises(fb.FreebodyError, match="2 joint coordinates and cannot move a frame"):
        fb.kernel(model, "operational_space_bias")  # its numbers were 1e15
    with pytest.raises(SingularError, match="the rows of its Jacobian are linearly dependent"):
        fb.operational_space_inertia(model.to_space(), [0.1, 0.2], rows=["vx", "vz"])
    with pytest.raises(fb.FreebodyError, match=r"no row 'vz' in rows=.*Rows: vx, vy, w"):
        fb.operational_space_inertia(model, [0.1, 0.2], rows=["vz"])
    with pytest.raises(fb.FreebodyError, match=r"frame 'tip' of 'RR' is at a singularity"):
        fb.operational_space_inertia(model, [0.1, 0.0], rows=["vx", "vy"])


@pytest.mark.sample(1)
def test_forward_dynamics_by_parameters(case):
    model, q, qd, tau = case
    slope = fb.forward_dynamics_parameter_derivatives(model, q, qd, tau)
    qdd = fb.forward_dynamics(model, q, qd, tau)
    # M q̈ + … = Y π: with more of each parameter the same torque gives -M⁻¹ Y more acceleration
    expected = -np.linalg.solve(fb.mass_matrix(model, q), fb.regressor(model, q, qd, qdd))
    np.testing.assert_allclose(slope, expected, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("reference", ["world", "body"])
def test_jacobian_derivatives(case, reference):
    model, q, qd, _ = case
    frame = model.leaves[-1]
    slope = fb.jacobian_derivatives(model, q, frame, reference)
    moving = np.einsum("nijk,nk->nij", slope, qd)
    np.testing.assert_allclose(moving, fb.jacobian_dot(model, q, qd, frame, reference), atol=1e-11)


def test_source_computes_what_the_kernel_does(case):
    model, q, qd, qdd = case
    names = ("inverse_dynamics", "mass_matrix", "kinetic_energy")
    scope: dict = {}
    exec(fb.source(model, names), scope)
    results = scope["_".join(names)](q, qd, qdd)
    for result, expected in zip(results, fb.kernel(model, names)(q, qd, qdd), strict=True):
        np.testing.assert_allclose(
            result, expected, rtol=1e-11, atol=1e-11 * np.abs(expected).max()
        )


def test_unknown_languages_are_refused():
    with pytest.raises(
        fb.FreebodyError, match=r"no language 'fortran' in fb.source. Languages: c, cpp"
    ):
        fb.source(MODELS["planar"](), "mass_matrix", "fortran")


def test_source_of_a_wrench_on_a_frame_of_any_name():
    model = MODELS["planar"]().with_tool("2nd tool-tip")
    q, qd, qdd = fb.random_state(model, seed=3)
    scope: dict = {}
    exec(fb.source(model, "inverse_dynamics", wrench_frames=["2nd tool-tip"]), scope)
    wrench = np.array([1.0, 2.0, 3.0])
    expected = fb.inverse_dynamics(model, q, qd, qdd, {"2nd tool-tip": wrench})
    np.testing.assert_allclose(scope["inverse_dynamics"](q, qd, qdd, wrench), expected)


def test_springs_leave_gravity_alone_to_the_last_bit():
    stiff = fb.planar(
        "RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], drives=[Drive(stiffness=1e9)] * 2
    )
    q = np.random.default_rng(1).normal(size=(50, 2))
    assert np.array_equal(
        fb.gravity_torque(stiff, q), fb.gravity_torque(stiff.without("springs"), q)
    )


def test_numpy_kernels_do_not_cut_numbers_off():
    kernel = fb.kernel(MODELS["planar"](), "bias", target="numpy")
    n = MODELS["planar"]().nv
    with pytest.raises(TypeError, match=r"^bias: out holds int64 values, expected float64"):
        kernel(np.zeros(n), np.zeros(n), out=np.zeros(n, dtype=int))


def test_a_few_samples_next_to_a_singularity_are_looked_at_alone():
    """All were put through a singular value decomposition: 3 µs a sample instead of 0.3."""
    model = fb.load("ur5e")
    q, qd, _ = fb.random_state(model, 4, 64)
    q[[5, 40], 4] = 1e-2, -1e-8  # the axes of the wrist in line, but for these angles
    J, M = fb.jacobian(model, q), fb.mass_matrix(model, q)
    drift = fb.jacobian_dot(model, q, qd) @ qd[..., None]
    inverse = np.linalg.inv(J @ np.linalg.solve(M, np.swapaxes(J, -1, -2)))
    rest = J @ np.linalg.solve(M, fb.bias(model, q, qd)[..., None]) - drift
    for found, expected in (
        (fb.operational_space_inertia(model, q), inverse),
        (fb.operational_space_bias(model, q, qd)[..., None], inverse @ rest),
    ):
        size = np.abs(expected).max(axis=(1, 2))
        off = np.abs(found - expected).max(axis=(1, 2)) / size
        assert off[40] < 1e-2  # of 1e14 times the largest
        assert np.delete(off, 40).max() < 1e-6
        assert np.isfinite(found).all()
    alone = [fb.operational_space_inertia(model, x) for x in q]
    np.testing.assert_array_equal(fb.operational_space_inertia(model, q), alone)
    kernel = fb.kernel(model, "operational_space_inertia")(q)
    assert np.isnan(kernel[40]).all()
    assert np.isfinite(kernel[:40]).all()
    q[40, 4] = 0.0
    for again in (q, q.reshape(8, 8, 6)):
        at = r"40" if again is q else r"\(5, 0\)"
        with pytest.raises(SingularError, match=f"is at a singularity at sample {at}: "):
            fb.operational_space_inertia(model, again)
    q[40, 4] = np.nan
    with pytest.raises(fb.FreebodyError, match="q is nan"):
        fb.operational_space_inertia(model, q)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ["ur5e", "panda", "2R", "puma560"])
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_rates_that_move_a_frame_are_kernels_too(name: str):
    """The pseudoinverse of every sample took 6 µs."""
    model = fb.load(name)
    q, qd, qdd = fb.random_state(model, 6, 50)
    r = 6 if model.nv >= 6 else 2
    V, A = fb.velocity(model, q, qd)[:, :r], fb.acceleration(model, q, qd, qdd)[:, :r]
    J = fb.jacobian(model, q)[:, :r]
    drift = (fb.jacobian_dot(model, q, qd)[:, :r] @ qd[..., None])[..., 0]
    rows = ("vx", "vy", "vz", "wx", "wy", "wz")[:r]
    for function, given, wanted, right in (
        ("inverse_velocity", (q,), V, V),
        ("inverse_acceleration", (q, qd), A, A - drift),
    ):
        found = getattr(fb, function)(model, *given, wanted)
        exact = (np.linalg.pinv(J) @ right[..., None])[..., 0]
        np.testing.assert_allclose(found, exact, rtol=1e-8, atol=1e-9)
        np.testing.assert_allclose((J @ found[..., None])[..., 0], right, atol=1e-11)
        alone = [getattr(fb, function)(model, *(x[k] for x in given), wanted[k]) for k in range(50)]
        np.testing.assert_array_equal(found, alone)
        kernel = fb.kernel(model, function, rows=rows)(*given, np.ascontiguousarray(wanted))
        sure = np.isfinite(kernel).all(axis=-1)
        np.testing.assert_array_equal(kernel[sure], found[sure])
        assert sure.mean() > 0.9
    q[7] = 0.0
    if name != "panda":
        assert np.isnan(fb.kernel(model, "inverse_velocity", rows=rows)(q[7], V[7].copy())).all()
        with pytest.raises(SingularError, match="the Jacobian is singular at sample 7"):
            fb.inverse_velocity(model, q, V)


def spatial_arm_of_three() -> fb.Model:
    row = {"a": 0.3, "m": 2.0, "com": [-0.1, 0, 0], "I": [0.01, 0, 0, 0.03, 0, 0.03]}
    return fb.dh([row | {"alpha": x} for x in (np.pi / 2, 0.0, 0.4)], convention="standard")


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("make", "joint"),
    [
        (lambda: fb.load("ur5e"), 4),
        (lambda: fb.load("puma560"), 4),
        (lambda: fb.load("2R"), 1),
        (lambda: fb.planar("RRR", l=[0.4] * 3, lc=[0.2] * 3, m=[1.0] * 3, I=[0.1] * 3), 1),
        (spatial_arm_of_three, 2),
    ],
)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_torques_tell_the_wrench_by_a_kernel(make, joint: int):
    """As near to J⁻ᵀ tau as J's condition lets NumPy come; a decomposition of every sample took
    6 µs."""
    model = make()
    n, rng = model.nv, np.random.default_rng(3)
    q, tau = fb.random_state(model, 5, 400)[0], rng.normal(size=(400, n))
    q[:, joint] = 10.0 ** rng.uniform(-9.0, 0.0, 400)  # singular at 0
    found = fb.tip_wrench(model, q, tau)
    J = fb.jacobian(model, q)
    square = np.swapaxes(J[:, :n], -1, -2)
    exact = np.linalg.solve(square, tau[..., None])[..., 0]
    off = np.abs(found[:, :n] - exact).max(axis=-1) / np.abs(exact).max(axis=-1)
    assert (off < 1e-14 * np.linalg.cond(square)).all()
    assert found.shape == J.shape[:-1]
    assert not found[:, n:].any()
    kernel = fb.kernel(model, "tip_wrench")(q, tau)
    sure = np.isfinite(kernel).all(axis=-1)
    np.testing.assert_array_equal(kernel[sure], found[sure])
    assert 0.4 < sure.mean() < 1.0
    assert sure[q[:, joint] > 1e-3].mean() > 0.95
    alone = [fb.tip_wrench(model, *x) for x in zip(q, tau, strict=True)]
    np.testing.assert_array_equal(found, alone)
    few = fb.tip_wrench(model, q[:8].reshape(2, 4, n).tolist(), tau[0])
    np.testing.assert_array_equal(few[1, 2], fb.tip_wrench(model, q[6], tau[0]))
    assert fb.tip_wrench(model, q[:0], tau[0]).shape == (0, J.shape[-2])


def test_wrenches_that_torques_do_not_tell_are_refused_by_name_too():
    model = fb.load("ur5e")
    q, tau = fb.random_state(model, 4, 12)[0], np.ones(6)
    q[7, 4] = 0.0
    assert np.isnan(fb.kernel(model, "tip_wrench")(q[7], tau)).all()
    for given, at in ((q, "7"), (q.reshape(3, 4, 6), r"\(1, 3\)")):
        with pytest.raises(SingularError, match=f"is singular at sample {at}: some wrench"):
            fb.tip_wrench(model, given, tau)
    with pytest.raises(SingularError, match="7 joints but the wrench 6 components"):
        fb.kernel(fb.load("iiwa14"), "tip_wrench")
    with pytest.raises(fb.FreebodyError, match=r"closed chain; with J = fb\.input_output"):
        fb.tip_wrench(fb.load("five_bar"), np.zeros(4), np.zeros(4))
    with pytest.raises(fb.FreebodyError, match="closed chain, for which this is not available"):
        fb.kernel(fb.load("five_bar"), "tip_wrench")
    with pytest.raises(fb.FreebodyError, match=r"tau reaches 1e\+308; the result overflows"):
        fb.tip_wrench(model, q[0], np.full(6, 1e308))


def test_a_row_that_no_joint_moves_is_singular_and_huge_rates_are_named():
    """Such a pivot is 0 whatever the position, which no trace can divide by."""
    model = fb.planar("RRR", l=[0.4] * 3, lc=[0.2] * 3, m=[1.0] * 3, I=[0.1] * 3).to_space()
    q = np.array([0.1, 0.2, 0.3])
    with pytest.raises(SingularError, match="satisfies vz = 0"):
        fb.inverse_velocity(model, q, [0.1, 0.1, 0.0])
    kernel = fb.kernel(model, "inverse_velocity", rows=("vx", "vz"))
    assert np.isnan(kernel(q, np.ones(2))).all()
    arm, q = fb.load("ur5e"), np.full(6, 0.5)
    with pytest.raises(fb.FreebodyError, match=r"^operational_space_bias: qd reaches 1e\+200"):
        fb.operational_space_bias(arm, q, np.full(6, 1e200))
    with pytest.raises(fb.FreebodyError, match=r"^inverse_velocity: V_ref reaches 1e\+308"):
        fb.inverse_velocity(arm, q, np.full(6, 1e308))
