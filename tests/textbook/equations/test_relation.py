"""Quantities by name, relations between them, functions given as formulas, mass by integration,
rotations by angles."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import freebody as fb


@pytest.fixture(scope="module")
def arm():
    return fb.quantities(fb.planar("RR"))


# ---------------------------------------------------------------- quantities
@pytest.mark.parametrize("word", ["R", "RR", "RPR", "PRP"])
def test_quantities_are_those_of_the_numeric_functions(word: str):
    n = len(word)
    model = fb.planar(word, l=[0.4] * n, lc=[0.2] * n, m=[1.5] * n, I=[0.02] * n)
    q, qd, qdd = (x[0] for x in fb.random_state(model, 3, 1))
    free = fb.quantities(model)
    symbols = free.layout.symbols

    def numbers(name):
        return symbols.evaluate([*free[name]], q, qd, qdd)

    np.testing.assert_allclose(numbers("tau"), fb.inverse_dynamics(model, q, qd, qdd), atol=1e-12)
    np.testing.assert_allclose(numbers("r_dd"), fb.acceleration(model, q, qd, qdd)[:2], atol=1e-12)
    w = fb.joint_wrenches(model, q, qd, qdd)
    for k in range(n):
        np.testing.assert_allclose(numbers(f"f{k}{k + 1}"), w[k, :2], atol=1e-12)
        np.testing.assert_allclose(
            symbols.evaluate(free[f"M{k + 1}"], q, qd, qdd), w[k, 2], atol=1e-12
        )
    np.testing.assert_allclose(
        symbols.evaluate(free["T"], q, qd), fb.kinetic_energy(model, q, qd), atol=1e-12
    )


def test_a_load_acts_on_the_tip():
    free = fb.quantities(fb.planar("RR", g=[0, 0]), load=True, at_rest=True)
    assert fb.relation(free, "tau = -transpose(J)*f")
    assert fb.relation(free, "f23 = -f")


def test_gravity_by_the_base_or_by_weights_gives_the_same_torques():
    model = fb.planar("RP")
    explicit, base = fb.quantities(model), fb.quantities(model, gravity="base")
    assert explicit["tau"] == base["tau"]
    assert fb.relation(base, "v0_d = -gravity")


def test_links_in_letters(arm):
    for same in ("omega_i = omega2", "omega_h = omega1", "f_hi = f12"):
        assert fb.relation(arm, same, link=2)
    for i in (1, 2):
        assert fb.relation(arm, "omega_i_d = omega_h_d + theta_i_dd", link=i)


def test_axes_and_rates_in_the_world():
    free = fb.quantities(fb.load("scara"))
    for i in (1, 2):
        assert fb.relation(free, "w_i = w_h + theta_i_d*z_i", link=i)
        assert fb.relation(free, "d_dt(R_i) = skew(w_i)*R_i", link=i)


def test_quantities_refuse_what_they_have_no_names_for():
    with pytest.raises(fb.FreebodyError, match="is free"):
        fb.quantities(fb.load("quadrotor"))


# ---------------------------------------------------------------- relations
def test_a_relation_is_true_or_says_by_how_much_not(arm):
    assert fb.relation(arm, "f12 + m2*gravity = m2*vc2_d")
    wrong = fb.relation(arm, "f12 - m2*gravity = m2*vc2_d")
    assert not wrong
    assert wrong.exact
    at, (left, right) = wrong.example()
    assert np.subtract(left, right) == pytest.approx([0.0, 2 * at["m2"] * at["g"]])


@pytest.mark.parametrize(
    ("formula", "words"),
    [
        ("s1 = l1", "never equal"),
        ("s1 + l1 = 0", "cannot be added"),
        ("s1*s2 = 0", "have no product"),
    ],
)
def test_shapes_that_do_not_fit(arm, formula, words):
    found = fb.relation(arm, formula)
    assert not found
    assert words in found.problem


def test_a_relation_needs_an_equals_sign_and_known_names(arm):
    with pytest.raises(fb.FreebodyError, match="has no ="):
        fb.relation(arm, "s1 + s2")
    with pytest.raises(fb.UnknownNameError, match="no quantity 's9'"):
        fb.relation(arm, "s9 = s1")


def test_time_and_partial_derivatives(arm):
    assert fb.relation(arm, "d_dt(r) = r_d")
    assert fb.relation(arm, "d_dt(partial(L, theta2_d)) - partial(L, theta2) = tau2")
    assert "by a coordinate" in fb.relation(arm, "partial(L, l1*l2) = 0").problem


@settings(max_examples=50, deadline=None)
@given(st.lists(st.floats(-10, 10), min_size=6, max_size=6))
def test_vector_algebra_is_that_of_numpy(x):
    a, b = x[:3], x[3:]
    at = {
        "a": a,
        "b": b,
        "c": np.cross(a, b),
        "d": float(np.dot(a, b)),
        "n": float(np.linalg.norm(a)),
    }
    assert fb.relation(at, "cross(a, b) = c")
    assert fb.relation(at, "dot(a, b) = d")
    assert fb.relation(at, "cross(b, a) = -c")
    assert fb.relation(at, "a^2 = n^2")


def test_matrices():
    at = {"A": [[2.0, 1.0], [0.5, 3.0]], "b": [1.0, -2.0]}
    at |= {"x": np.linalg.solve(at["A"], at["b"]), "D": float(np.linalg.det(at["A"]))}
    assert fb.relation(at, "x = A^-1*b")
    assert fb.relation(at, "det(A) = D = 2*3 - 1*0.5")
    assert fb.relation(at, "transpose(A)*[1, 0] = [2, 1]")


# ---------------------------------------------------------------- functions
def test_trajectory_derivatives_and_numbers():
    path = fb.trajectory("3*t^3 + 2*t^2 + 1", "sin(2*t)*exp(t)")
    t = np.linspace(0, 1, 5)
    r, v, a = path.at(t)
    np.testing.assert_allclose(r[:, 1], np.sin(2 * t) * np.exp(t))
    np.testing.assert_allclose(v[:, 0], 9 * t**2 + 4 * t)
    np.testing.assert_allclose(a[:, 1], np.exp(t) * (4 * np.cos(2 * t) - 3 * np.sin(2 * t)))
    assert str(path.velocity.expressions[0]) == "9 t² + 4 t"


WRITTEN = {
    "3*x^3*y - x/2 + 1": lambda x, y: 3 * x**3 * y - x / 2 + 1,
    "sin(2*x)*exp(y) - cos(x - y)^2": lambda x, y: np.sin(2 * x) * np.exp(y) - np.cos(x - y) ** 2,
    "sqrt(x)*log(x*y)/(1 + y^2)": lambda x, y: np.sqrt(x) * np.log(x * y) / (1 + y**2),
    "tan(x)/y^2 + sqrt(x + sin(y)^3)": lambda x, y: np.tan(x) / y**2 + np.sqrt(x + np.sin(y) ** 3),
    "exp(x)*exp(-2*y)/(x + 2*y)^3": lambda x, y: np.exp(x - 2 * y) / (x + 2 * y) ** 3,
    "1/sqrt(x*y) + log(2 + cos(exp(x)))": lambda x, y: (
        1 / np.sqrt(x * y) + np.log(2 + np.cos(np.exp(x)))
    ),
}


@pytest.mark.parametrize("row", WRITTEN)
def test_functions_are_those_written_and_their_slopes_those_of_differences(row: str):
    f = fb.vector_function([row], ["x", "y"])
    at = np.random.default_rng(3).uniform(0.3, 1.2, (20, 2))
    np.testing.assert_allclose(f(at)[:, 0], WRITTEN[row](*at.T), rtol=1e-13)
    steps = 1e-3 * np.eye(2)[:, None]
    near = [f(at + k * steps)[..., 0] for k in (1, -1, 2, -2)]
    slopes = (8 * (near[0] - near[1]) - (near[2] - near[3])) / 12e-3
    np.testing.assert_allclose(f.jacobian_at(at)[:, 0], slopes.T, rtol=1e-8, atol=1e-8)


def test_functions_are_compared_exactly_and_else_by_numbers():
    f = fb.vector_function(["x", "y"], ["x", "y"])
    at = dict(zip("xy", f.symbols, strict=True))
    same = (
        "(x + y)^2 = x^2 + 2*x*y + y^2",
        "sin(x)^2 + cos(x)^2 = 1",
        "exp(x)*exp(y) = exp(x + y)",
        "sqrt(x)*sqrt(x) = x",
        "sin(x - y) = -sin(y - x)",
        "x/(2*y) = 0.5*x*y^-1",
        "sin(x - x) + cos(y - y) + exp(x - x) + log(1 + x - x) + sqrt(4 + x - x) = 4",
    )
    for form in same:
        found = fb.relation(at, form)
        assert (bool(found), found.exact) == (True, True), form
    beside_rounding = fb.relation(at, "sin(2*x) = 2*sin(x)*cos(x)")
    assert (bool(beside_rounding), beside_rounding.exact) == (True, False)
    wrong = fb.relation(at, "sin(2*x) = 2*sin(x)*cos(y)")
    assert (bool(wrong), wrong.exact) == (False, True)
    assert wrong.example() is not None
    assert not fb.relation(at, "log(-x) = log(-2*x)")  # a number nowhere
    with pytest.raises(fb.FreebodyError, match="tanh of a formula: closed forms have sin, cos"):
        fb.math.tanh(f.symbols[0])
    with pytest.raises(fb.FreebodyError, match="divided by 0"):
        fb.relation(at, "1/(x - x) = y")
    with pytest.raises(fb.FreebodyError, match="more than 300 terms"):
        fb.vector_function(["(x + y)^2000"], ["x", "y"])


def test_a_path_through_samples_has_the_derivatives_of_the_curve():
    exact = fb.trajectory("5*cos(3.14*t)", "5*sin(3.14*t)")
    t = np.linspace(0, 1, 101)
    path = fb.sampled_trajectory(t, exact.at(t)[0])
    for found, right, miss in zip(
        path.at([0.3, 0.71]), exact.at([0.3, 0.71]), (1e-9, 1e-8, 1e-6), strict=True
    ):
        np.testing.assert_allclose(found, right, rtol=0, atol=50 * miss)
    with pytest.raises(fb.ShapeError, match="one row per time"):
        fb.sampled_trajectory(t, np.zeros((3, 2)))
    with pytest.raises(fb.FreebodyError, match="at least 6 samples"):
        fb.sampled_trajectory(t[::-1], exact.at(t)[0])


def test_vector_function_jacobian():
    f = fb.vector_function(["x*y", "sqrt(x) + y^2"], ["x", "y"])
    np.testing.assert_allclose(f.jacobian_at([4.0, 3.0]), [[3.0, 4.0], [0.25, 6.0]])
    assert f.jacobian_at(np.ones((5, 2))).shape == (5, 2, 2)
    with pytest.raises(fb.ShapeError, match=r"expected \(\.\.\., 2\)"):
        f([1.0, 2.0, 3.0])
    with pytest.raises(fb.UnknownNameError, match="no variable 'z'"):
        fb.vector_function(["x + z"], ["x"])
    with pytest.raises(fb.FreebodyError, match="one scalar formula"):
        fb.vector_function(["[x, x]"], ["x"])


# ---------------------------------------------------------------- mass
def test_shapes_by_integration_are_those_of_the_library():
    m, r, h = 2.0, 0.3, 0.5
    solid = fb.integrated_inertia(
        lambda s, a, z: (s * np.cos(a), s * np.sin(a), z),
        [(0, r), (0, 2 * np.pi), (-h / 2, h / 2)],
        m,
    )
    np.testing.assert_allclose(
        solid.numbers()[2], fb.Inertia.cylinder(m, r, h).numbers()[2], atol=1e-12
    )
    ball = fb.integrated_inertia(
        lambda s, a, b: (s * np.cos(a) * np.cos(b), s * np.sin(a) * np.cos(b), s * np.sin(b)),
        [(0, r), (0, 2 * np.pi), (-np.pi / 2, np.pi / 2)],
        m,
    )
    np.testing.assert_allclose(ball.numbers()[2], fb.Inertia.sphere(m, r).numbers()[2], atol=1e-12)
    rod = fb.integrated_inertia(lambda u: (u, 0 * u), [(0.2, 0.8)], m)
    np.testing.assert_allclose(rod.com, [0.5, 0.0], atol=1e-14)
    with pytest.raises(fb.ModelError, match="covers nothing"):
        fb.integrated_inertia(lambda u, v: (u + v, u + v, u + v), [(0, 1), (0, 1)])


def test_inertia_from_another_point_and_back():
    body = fb.Inertia.of(2.0, [0.1, 0.2, -0.3], [0.3, 0.02, 0.01, 0.4, -0.03, 0.5])
    O = [0.5, -0.4, 0.2]
    back = fb.inertia_from(2.0, body.com, body.about(O), O)
    np.testing.assert_allclose(back.tensor, body.tensor, atol=1e-12)
    with pytest.raises(fb.ModelError, match="is too small: moment of inertia -1 kg m² is negative"):
        fb.inertia_from(2.0, [0.0, 0.0], 1.0, [1.0, 0.0])


# ---------------------------------------------------------------- rotations
def test_rotation_by_named_axes():
    R = fb.rotation("ZXZ", [np.pi / 2, 0.0, 0.0])
    np.testing.assert_allclose(R @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    w, x, y, z = fb.quat_wxyz(R)
    np.testing.assert_allclose([w, x, y, z], [np.sqrt(0.5), 0, 0, np.sqrt(0.5)], atol=1e-15)
    for bad in (("ZXQ", [1, 2, 3]), ("ZX", [1, 2, 3])):
        with pytest.raises(fb.FreebodyError, match="one angle for each of the letters"):
            fb.rotation(*bad)
