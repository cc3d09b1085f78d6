"""Closed chains in closed form: loop equations, the first kind and its reduction, statics, parallel
robots."""

from __future__ import annotations

import re

import numpy as np
import pytest

import freebody as fb
from freebody.expressions.expression import eq
from freebody_textbook.closed_chains.linear_equations import product
from freebody_textbook.closed_chains.loop_statics import LoopStatics
from freebody_textbook.closed_chains.multiplier_equations import FirstKind, multiplier_names
from support.methods import agree
from support.printed_lines import derived
from support.printed_values import evaluate

pytestmark = pytest.mark.usefixtures("numpy_kernels")

PLANAR = ["slider_crank", "four_bar", "five_bar", "five_bar_rods", "double_four_bar"]
METHOD = "lagrange-first-kind"


def closed_state(model, seed=0):
    """A closed position away from singular ones, and consistent rates."""
    rng = np.random.default_rng(seed)
    while True:
        q = fb.assemble(model, rng.uniform(-2, 2, model.nq))
        s = np.linalg.svd(fb.kernel(model, "constraint_jacobian")(q), compute_uv=False)
        if s[-1] > 0.05 * s[0]:
            return q, fb.loop_velocity(model, q, rng.normal(size=model.nv))


def with_drives(model, rng):
    """Torques of the drives alone."""
    driven = [name in model.driven_names for name in model.velocity_names]
    return rng.normal(size=model.nv) * driven


# ---------------------------------------------------------------- loop equations
@pytest.mark.parametrize("name", [*PLANAR, "3RRR", "bricard"])
def test_polynomials_equal_the_kernels(name):
    model = fb.load(name)
    loops = fb.loop_equations(model)
    rng = np.random.default_rng(1)
    q, qd = rng.uniform(-1, 1, (5, model.nq)), rng.normal(size=(5, model.nv))
    names = ("constraint", "constraint_jacobian", "constraint_bias")
    Phi, Phi_q, c = fb.kernel(model, names)(q, qd)
    scale = loops.evaluate(loops.scale, q)
    np.testing.assert_allclose(loops.evaluate(loops.Phi, q), scale * Phi, rtol=0, atol=1e-12)
    np.testing.assert_allclose(
        loops.evaluate(loops.Phi_q, q), scale[..., None] * Phi_q, rtol=0, atol=1e-12
    )
    np.testing.assert_allclose(loops.evaluate(loops.c, q, qd), scale * c, rtol=0, atol=2e-12)


@pytest.mark.parametrize("name", ["slider_crank", "five_bar_rods", "double_four_bar"])
def test_jacobian_and_bias_are_derivatives_of_the_equations(name):
    loops = fb.loop_equations(fb.load(name))
    s = loops.symbols
    assert loops.Phi_q == [[x.derivative(name) for name in s.coordinates] for x in loops.Phi]
    rates = dict(zip(s.coordinates, s.qd, strict=True))
    along = [[x.along(rates) for x in row] for row in loops.Phi_q]
    for c, row in zip(loops.c, along, strict=True):
        total = c
        for x, rate in zip(row, s.qd, strict=True):
            total = total + x * rate
        assert total.is_zero


def test_five_bar_equals_the_corrected_notes():
    """(2.33)-(2.40), d = 2b, A at -d/2."""
    loops = fb.loop_equations(fb.load("five_bar_rods"))
    ring = loops.symbols.ring
    x, y, d, l1, l2, l3, l4 = (
        ring["x"],
        ring["y"],
        2 * ring["b"],
        *(ring[f"l{i}"] for i in (1, 2, 3, 4)),
    )
    s1, c1, s2, c2 = ring.sin("theta1"), ring.cos("theta1"), ring.sin("theta2"), ring.cos("theta2")
    left = (-d / 2 + l1 * c1 - x) ** 2 + (l1 * s1 - y) ** 2 - l3**2
    right = (d / 2 + l2 * c2 - x) ** 2 + (l2 * s2 - y) ** 2 - l4**2
    assert loops.Phi == [left, right]
    assert loops.J_a() == [
        [d - 2 * l1 * c1 + 2 * x, -2 * l1 * s1 + 2 * y],
        [-d - 2 * l2 * c2 + 2 * x, -2 * l2 * s2 + 2 * y],
    ]
    jb1 = l1 * d * s1 + 2 * l1 * x * s1 - 2 * l1 * y * c1
    jb2 = -l2 * d * s2 + 2 * l2 * x * s2 - 2 * l2 * y * c2
    zero = loops.symbols.zero()
    assert loops.J_b() == [[jb1, zero], [zero, jb2]]
    io = loops.input_output()
    for row, (a, b) in zip(
        io.J_a, zip(*io.J_b, strict=True), strict=True
    ):  # J_a J + J_b = 0, J_b is diagonal
        assert len(row) == 2
        assert a.is_zero or b.is_zero
    (J11, J12), (J21, J22) = io.J
    for k, (one, two) in enumerate(((J11, J21), (J12, J22))):
        for i in range(2):
            first = io.J_a[i][0] * one.above * two.below + io.J_a[i][1] * two.above * one.below
            assert (first + io.J_b[i][k] * one.below * two.below).is_zero


@pytest.mark.parametrize(
    ("name", "rows", "first", "second"),
    [
        ("five_bar", None, "l₁ l₂ sin θ₃ sin θ₄", "−sin(θ₁−θ₂+θ₃−θ₄)"),
        ("slider_crank", None, "−l₁ sin θ₂", "cos(θ₁+θ₂)"),
        ("four_bar", ["w"], "−l₁ sin(θ₁−θ₃)", "−l₂ sin(θ₁+θ₂−θ₃)"),
        ("five_bar_rods", None, None, None),
        ("3RRR", None, None, None),
    ],
)
def test_tip_and_drives_in_closed_form(name, rows, first, second):
    model = fb.load(name)
    io = fb.loop_equations(model).input_output(rows=rows)
    if first:
        assert str(io.first.expression) == first
        assert str(io.second.expression) == second
    q, _ = closed_state(model, 3)
    J = -np.linalg.solve(io.evaluate(io.J_a, q), io.evaluate(io.J_b, q))
    np.testing.assert_allclose(J, fb.input_output(model, q, rows=rows).J, rtol=1e-10, atol=1e-12)


def test_what_cannot_be_had_is_said():
    with pytest.raises(fb.FreebodyError, match="has no loops"):
        fb.loop_equations(fb.load("2R"))
    with pytest.raises(fb.FreebodyError, match="5 joints of 'double_four_bar' are driven, 3 rows"):
        fb.loop_equations(fb.load("double_four_bar")).input_output()
    with pytest.raises(
        fb.FreebodyError, match=r"1 joints of 'five_bar' are driven.* 0 equations hold"
    ):
        fb.loop_equations(fb.load("five_bar").replace(actuated=["theta1"])).input_output()
    with pytest.raises(fb.FreebodyError, match="coordinates that are numbers"):
        fb.loop_equations(fb.load("stewart"))


# ---------------------------------------------------------------- the first kind
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", PLANAR)
def test_first_kind_is_forward_dynamics(name):
    model = fb.load(name)
    system = fb.derive(model, METHOD).system
    assert isinstance(system, FirstKind)
    loops = system.loops
    for seed in range(3):
        q, qd = closed_state(model, seed)
        tau = with_drives(model, np.random.default_rng(seed))
        M, rest, Phi_q, c = (
            loops.evaluate(x, q, qd) for x in (system.M, system.rest, loops.Phi_q, loops.c)
        )
        m = len(c)
        block = np.block([[M, Phi_q.T], [Phi_q, np.zeros((m, m))]])
        solved = np.linalg.solve(block, [*(tau - rest), *c])
        qdd = fb.forward_dynamics(model, q, qd, tau)
        np.testing.assert_allclose(
            solved[: model.nv], qdd, rtol=1e-10, atol=1e-10 * np.abs(qdd).max()
        )
        # λ is what `reactions` calls so, and each loop's force the one that is shown
        scale = loops.evaluate(loops.scale, q)
        multipliers = fb.reactions(model, q, qd, tau=tau).multipliers
        np.testing.assert_allclose(solved[model.nv :] * scale, multipliers, rtol=1e-7, atol=1e-8)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", PLANAR)
def test_reduction_takes_the_multipliers_out(name):
    model = fb.load(name)
    system = fb.derive(model, METHOD).system
    assert isinstance(system, FirstKind)
    reduction = system.reduction
    assert reduction is not None
    s, scaled = system.symbols, reduction.scaled
    for row in system.loops.Phi_q:  # Φ_q (Δ N) = 0 as polynomials, on open positions too
        for column in zip(*scaled, strict=True):
            total = s.zero()
            for x, y in zip(row, column, strict=True):
                total = total + x * y
            assert total.is_zero
    # where the independent coordinates do determine the others
    states = (closed_state(model, seed) for seed in range(5, 50))
    q, qd = next(x for x in states if abs(reduction.delta.evaluate(s.values(*x))) > 0.01)
    values = s.values(q, qd)
    tau = with_drives(model, np.random.default_rng(5))
    qdd = fb.forward_dynamics(model, q, qd, tau)
    N = np.array([[x.evaluate(values) for x in row] for row in reduction.N])
    drift = np.array([x.evaluate(values) for x in reduction.drift])
    M, rest = (system.loops.evaluate(x, q, qd) for x in (system.M, system.rest))
    u = np.linalg.solve(N.T @ M @ N, N.T @ (tau - rest - M @ drift))
    np.testing.assert_allclose(N @ u + drift, qdd, rtol=1e-8, atol=1e-9 * np.abs(qdd).max())
    delta = reduction.delta.evaluate(values)
    np.testing.assert_allclose(
        system.loops.evaluate(reduction.mass, q), delta**2 * N.T @ M @ N, rtol=1e-8, atol=1e-12
    )


def eksergian(model, theta, rate, tau, angles):
    """One-degree mechanism in its crank angle: J ü + ½ J' u̇² + V' = τ, from positions alone, by
    differences.

    angles(θ): positions and turns of every mass (x, y, φ) with its mass and inertia.
    """
    p, h = model.parameters, 1e-3

    def energy_terms(t):
        ahead, behind = angles(p, t + h), angles(p, t - h)
        J = V = 0.0
        for (m, I, *pose), (_, _, *up), (_, _, *down) in zip(
            angles(p, t), ahead, behind, strict=True
        ):
            up2 = angles(p, t + 2 * h)[len(seen)][2:]
            down2 = angles(p, t - 2 * h)[len(seen)][2:]
            slope = (8 * (np.array(up) - down) - (np.array(up2) - down2)) / (12 * h)
            J += m * (slope[0] ** 2 + slope[1] ** 2) + I * slope[2] ** 2
            V += m * p["g"] * pose[1]
            seen.append(0)
        seen.clear()
        return J, V

    seen: list[int] = []
    k = 1e-2
    at = [energy_terms(theta + j * k) for j in (-2, -1, 0, 1, 2)]
    dJ, dV = ((8 * (at[3][i] - at[1][i]) - (at[4][i] - at[0][i])) / (12 * k) for i in (0, 1))
    return (tau - dV - 0.5 * dJ * rate**2) / at[2][0]


def slider_crank_masses(p, t):
    """Crank, rod and slider, the rod to the right."""
    phi = -np.arcsin(p["l1"] * np.sin(t) / p["l2"])
    pin = p["l1"] * np.array([np.cos(t), np.sin(t)])
    crank, rod = pin * p["lc1"] / p["l1"], pin + p["lc2"] * np.array([np.cos(phi), np.sin(phi)])
    x = pin[0] + p["l2"] * np.cos(phi)
    return [
        (p["m1"], p["I1"], *crank, t),
        (p["m2"], p["I2"], *rod, phi),
        (p["m3"], 0.0, x, 0.0, 0.0),
    ]


def four_bar_masses(p, t):
    """Crank, coupler and rocker, the open branch."""
    pin = p["l1"] * np.array([np.cos(t), np.sin(t)])
    way = np.array([p["d"], 0.0]) - pin
    d, base = np.hypot(*way), np.arctan2(way[1], way[0])
    phi = base + np.arccos((d**2 + p["l2"] ** 2 - p["l3"] ** 2) / (2 * d * p["l2"]))
    end = pin + p["l2"] * np.array([np.cos(phi), np.sin(phi)])
    psi = np.arctan2(end[1], end[0] - p["d"])
    coupler = pin + p["lc2"] * np.array([np.cos(phi), np.sin(phi)])
    rocker = np.array([p["d"], 0.0]) + p["lc3"] * np.array([np.cos(psi), np.sin(psi)])
    crank = pin * p["lc1"] / p["l1"]
    return [
        (p["m1"], p["I1"], *crank, t),
        (p["m2"], p["I2"], *coupler, phi),
        (p["m3"], p["I3"], *rocker, psi),
    ]


@pytest.mark.parametrize(
    ("name", "masses"), [("slider_crank", slider_crank_masses), ("four_bar", four_bar_masses)]
)
def test_second_kind_equals_one_coordinate_by_hand(name, masses):
    model = fb.load(name)
    system = fb.derive(model, METHOD).system
    assert isinstance(system, FirstKind)
    reduction = system.reduction
    assert reduction is not None
    theta, rate, tau = 1.1, 2.3, 4.0
    (_, _, *one), (_, _, _, _, phi), last = masses(model.parameters, theta)
    q = [theta, phi - theta, last[4] if name == "four_bar" else last[2]]
    assert one[2] == theta
    qd = fb.loop_velocity(model, q, {model.joint_names[0]: rate})
    values = system.symbols.values(np.array(q), qd)
    delta = reduction.delta.evaluate(values)
    Q = [system.symbols.element(x) for x in (tau, 0.0, 0.0)]
    second = reduction.right(Q)[0].evaluate(values) / reduction.mass[0][0].evaluate(values)
    assert delta != 0.0
    assert second == pytest.approx(eksergian(model, theta, rate, tau, masses), rel=1e-8)
    assert second == pytest.approx(fb.forward_dynamics(model, q, qd, [tau, 0, 0])[0], rel=1e-10)


def test_open_chain_has_no_multipliers():
    arm = fb.planar("RR")
    first, second = fb.derive(arm, METHOD), fb.derive(arm, "lagrange")
    assert first.tau == second.tau
    assert first.steps[0].notes == ("5.24",)
    assert "no multipliers" in first.steps[0].reason
    assert first.steps[1:] == second.steps


def test_every_force_is_named():
    text = " ".join(derived("five_bar", METHOD).text().split())
    assert "λ₁ and λ₂ are the force of body 4 on body 3 at P, by components." in text
    assert "f₃₄ = [−λ₁, −λ₂]ᵀ" in text
    assert "f = n − m = 4 − 2 = 2" in text
    rods = derived("five_bar_rods", METHOD)
    assert "Φ₁ = (x + b − l₁ cos θ₁)² + (y − l₁ sin θ₁)² − l₃² = 0" in rods.text()
    assert ("2.33", "2.34", "5.21") in [step.notes for step in rods.steps]
    assert "it pulls body 1 at B towards body 4" in " ".join(rods.text().split())


def test_other_methods_name_those_for_closed_chains():
    with pytest.raises(fb.FreebodyError, match="'lagrange-first-kind'"):
        fb.derive(fb.load("four_bar"), "recursive")


def test_of_legs_that_are_alike_the_lines_of_one_are_told():
    """Six legs of the Stewart platform; three of the 3RRR robot have lines of their own."""
    steps = derived("stewart").steps
    spoken = {str(line.lhs) for step in steps for line in step.equations}
    assert {"∂L/∂θ₇", "∂L/∂d₉", "τ₉", "ω₈", "V₉"} <= spoken
    assert not {"∂L/∂θ₁₀", "∂L/∂d₁₂", "τ₂₄", "ω₁₁", "V₁₂"} & spoken
    told = [step.reason for step in steps if "the same" in step.reason]
    assert sum("bodies 10 to 12" in reason for reason in told) == 1
    assert len(told) > 10
    operations = [step.operation for step in derived("3RRR").steps]
    assert {"The equation of θ₄", "The equation of θ₆", "The equation of θ₈"} <= {*operations}


def test_a_platform_on_six_legs_is_derived_as_far_as_print_allows():
    """With yaw, pitch and roll in the place of the quaternion; from rest, where rates do not count,
    legs and multipliers are those of the kernels."""
    model, derivation = fb.load("stewart"), derived("stewart")
    system = derivation.system
    assert isinstance(system, FirstKind)
    loops, last = system.loops, derivation.steps[-1]
    assert last.operation == "No reduction"
    assert "18 loop equations are too many" in last.reason
    rates = next(s for s in derivation.steps if s.operation == "Velocity constraints")
    names = [str(line.lhs) for line in rates.equations]
    assert len(set(names)) == len(names), "row 4, column 11 is not row 41, column 1"
    assert "Φ_q,₁₀,₄" in names
    q = fb.assemble(model)
    w, x, y, z = q[3:7]
    yaw = np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))
    pitch = np.arcsin(2 * (w * y - x * z))
    roll = np.arctan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y))
    at = np.array([*q[:3], yaw, pitch, roll, *q[7:]])
    still = np.zeros(model.nv)
    np.testing.assert_allclose(loops.evaluate(loops.Phi, at), np.zeros(18), atol=1e-9)
    tau = with_drives(model, np.random.default_rng(1))
    M, rest, Phi_q = (loops.evaluate(x, at, still) for x in (system.M, system.rest, loops.Phi_q))
    block = np.block([[M, Phi_q.T], [Phi_q, np.zeros((18, 18))]])
    solved = np.linalg.solve(block, [*(tau - rest), *np.zeros(18)])
    qdd = fb.forward_dynamics(model, q, still, tau)
    assert np.linalg.norm(solved[:3]) == pytest.approx(np.linalg.norm(qdd[:3]))  # other axes
    np.testing.assert_allclose(solved[6:24], qdd[6:], rtol=1e-7, atol=1e-7)
    multipliers = fb.reactions(model, q, still, tau=tau).multipliers
    np.testing.assert_allclose(solved[24:], multipliers, rtol=1e-6, atol=1e-6)
    with pytest.raises(fb.FreebodyError, match=r"too long to be printed.* fb.input_output"):
        fb.derive(model, "kinematics")


# ---------------------------------------------------------------- body by body
@pytest.mark.sample(2)
@pytest.mark.parametrize("name", [*PLANAR, "3RRR"])
def test_newton_and_euler_end_in_the_first_kind(name):
    """With the same multipliers, term by term, joints without motors included."""
    model = fb.load(name)
    bodies = fb.derive(model, "newton-euler")
    assert isinstance(bodies.system, LoopStatics)
    assert list(bodies.tau) == FirstKind(bodies.system.loops, bodies.equations).forces
    for step in ("Equations and unknowns", "Free body 4" if "RRR" in name else "Free body 1"):
        assert step in [x.operation for x in bodies.steps]


def test_a_platform_that_no_joint_holds_has_no_reaction():
    said = derived("3RRR", "newton-euler").text()
    assert "   m₃ g − f₃₅ − f₃₇ − f₃₉ = m₃ v̇c₃\n" in said
    assert "   0 = 1.5 ẍ − λ₁ − λ₃ − λ₅\n" in said
    assert "21 for 21 equations. No joint holds body 3." in " ".join(said.split())
    assert not re.search("f₀₁|f₁₂|f₂₃|ω₁|ω₂|Free body 1", said)


def test_a_load_is_carried_through_the_loops_too():
    model = fb.load("five_bar")
    bodies = fb.derive(model, "newton-euler", load=True)
    first = fb.derive(model, load=True)
    assert first.method == METHOD, "where none is asked for"
    assert agree(bodies, first)
    assert "f₁₃ + m₃ g + f − f₃₄ = m₃ v̇c₃" in [str(x) for s in bodies.steps for x in s.equations]


@pytest.mark.parametrize("name", ["slider_crank", "five_bar_rods"])
def test_forces_in_the_loops_of_a_motion_are_reactions(name):
    model = fb.load(name)
    system = fb.derive(model, "newton-euler").system
    assert isinstance(system, LoopStatics)
    q, qd = closed_state(model, 2)
    tau = with_drives(model, np.random.default_rng(2))
    qdd = fb.forward_dynamics(model, q, qd, tau)
    A, k = (system.loops.evaluate(x, q, qd, qdd) for x in (system.A, system.right))
    multipliers = np.linalg.solve(A, k)
    scale = system.loops.evaluate(system.loops.scale, q)
    found = fb.reactions(model, q, qd, qdd=qdd)
    np.testing.assert_allclose(multipliers * scale, found.multipliers, rtol=1e-7, atol=1e-8)
    s = system.loops.symbols
    values = s.values(q, qd, qdd) | dict(
        zip(multiplier_names(system.loops), multipliers, strict=True)
    )
    np.testing.assert_allclose(
        [system.needed[j].evaluate(values) for j in range(model.nv)], tau, rtol=1e-8, atol=1e-8
    )


def test_printed_multipliers_solve_their_system():
    """λ by k over Δ, as they stand in the lines, against A λ = k."""
    derivation = derived("five_bar", "newton-euler")
    (step,) = [x for x in derivation.steps if x.operation == "The forces in the loop"]
    lines = {str(x.lhs): x for x in step.equations}
    symbols = derivation.equations.symbols
    q = np.array([2.1, 1.0, -1.4, 1.4])
    known = symbols.values(q) | {"k1": 0.7, "k2": -1.3}
    known["Delta"] = evaluate(lines["Δ"], known)
    found = [evaluate(lines[name], known) for name in ("λ₁", "λ₂")]
    system = derivation.system
    assert isinstance(system, LoopStatics)
    A = system.loops.evaluate(system.A, q)
    np.testing.assert_allclose(A @ found, [0.7, -1.3], rtol=1e-12)


def test_moments_about_pivots_are_of_open_chains():
    with pytest.raises(fb.FreebodyError, match="written out for open chains"):
        fb.derive(fb.load("four_bar"), "newton-euler", route="pivot")


@pytest.mark.parametrize("load", [False, True])
def test_load_on_the_tip_enters_by_virtual_work(load):
    model = fb.load("slider_crank")
    derivation = fb.derive(model, METHOD, load=load)
    assert isinstance(derivation.system, FirstKind)
    by_load = [a - b for a, b in zip(derivation.system.forces, derivation.tau, strict=True)]
    assert any(not x.is_zero for x in by_load) == load
    if load:
        assert by_load[2] == derivation.system.symbols.ring["fx"]


def test_factors_of_measured_numbers_keep_their_size():
    """Not whole numbers of ten digits with what makes them small in front."""
    loops = fb.loop_equations(fb.load("3RRR"))
    x = loops.Phi_q[0][2] * loops.Phi_q[1][3]
    shown = str(product(x, loops.layout))
    assert len(re.findall(r"\(.*?\)", shown)) >= 2, "factored"
    assert not re.search(r"\d{8}|·10", shown)
    q = np.linspace(0.3, 1.1, 9)
    found = evaluate(eq(product(x, loops.layout)), loops.symbols.values(q))
    assert found == pytest.approx(x.evaluate(loops.symbols.values(q)), rel=1e-12)


# ---------------------------------------------------------------- statics
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["slider_crank", "four_bar", "five_bar", "five_bar_rods"])
def test_statics_equals_numbers(name):
    model = fb.load(name)
    derivation = fb.derive(model, "statics")
    system = derivation.system
    assert isinstance(system, LoopStatics)
    assert system.determined
    q, _ = closed_state(model, 7)
    force = np.array([3.0, -5.0])
    values = system.loops.symbols.values(q) | {"fx": force[0], "fy": force[1]}
    expected = fb.static_torque(model, q, wrenches={model.tip: [*force, 0.0]})
    driven = [k for k in range(model.nv) if k not in system.passive]
    torque = [system.torque(k) for k in driven]
    np.testing.assert_allclose(
        [x.evaluate(values) for x in torque if x is not None],
        expected[driven],
        rtol=1e-9,
        atol=1e-9,
    )
    assert system.multipliers is not None
    found = fb.reactions(
        model, q, np.zeros(model.nv), qdd=np.zeros(model.nv), wrenches={model.tip: [*force, 0.0]}
    )
    scale = system.loops.evaluate(system.loops.scale, q)
    multipliers = np.array([x.evaluate(values) for x in system.multipliers])
    np.testing.assert_allclose(multipliers * scale, found.multipliers, rtol=1e-8, atol=1e-8)


def test_springs_hold_too():
    table = {"stiffness": 12.0, "rest": 0.3}
    four_bar = fb.load("four_bar")
    import dataclasses

    bodies = list(four_bar.bodies)
    joint = bodies[2].joint
    drive = dataclasses.replace(joint.drive, **table)
    bodies[2] = dataclasses.replace(bodies[2], joint=dataclasses.replace(joint, drive=drive))
    model = dataclasses.replace(four_bar, bodies=tuple(bodies))
    system = fb.derive(model, "statics", load=False).system
    assert isinstance(system, LoopStatics)
    q, _ = closed_state(model, 2)
    torque = system.torque(0)
    assert torque is not None
    held = torque.evaluate(system.loops.symbols.values(q))
    assert held == pytest.approx(fb.static_torque(model, q)[0], rel=1e-9)
    assert held != pytest.approx(fb.static_torque(four_bar, q)[0], rel=1e-3)


def test_more_drives_than_freedoms_leave_a_system():
    derivation = fb.derive(fb.load("double_four_bar"), "statics", load=False)
    assert isinstance(derivation.system, LoopStatics)
    assert not derivation.system.determined
    assert fb.derive(
        fb.load("five_bar").replace(actuated=["theta1", "theta2", "B"]), "statics"
    ).text()
    with pytest.raises(fb.FreebodyError, match="closed chain in space"):
        fb.derive(fb.load("bricard"), "statics")


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["slider_crank", "five_bar_rods"])
@pytest.mark.parametrize("method", [METHOD, "statics"])
def test_every_form_is_written(name, method):
    derivation = derived(name, method)
    page = derivation.html()
    for text in (derivation.text(), derivation.markdown(), derivation.latex(), page):
        assert "λ" in text or r"\lambda" in text
    assert "/work" not in page


def test_kinematics_of_parallel_robots():
    text = " ".join(derived("five_bar_rods", "kinematics").text().split())
    for line in (
        "J_a v + J_b θ̇ = 0",
        "det J_b = 4 l₁ l₂",
        "tan θ₁ = y/(x + b)",
        "(2.35), (2.37)–(2.40)",
    ):
        assert line in text
    text = " ".join(derived("five_bar", "kinematics").text().split())
    assert "J₂₂ = −(l₂ cos(θ₁+θ₃) sin θ₄)/Δ" in text
    assert "θ₁ − θ₂ + θ₃ − θ₄ = 0" in text
