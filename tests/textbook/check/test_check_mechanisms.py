"""What answers about mechanisms and what scripts have besides polynomials: virtual displacements,
derivatives by a coordinate, reciprocal functions, matrices of slopes, a ratio n."""

import functools

import pytest

import freebody as fb

load = functools.cache(fb.load)
SLIDE = r"\frac{l_1\sin\theta_2}{\cos(\theta_1+\theta_2)}"
RATIO = "k = l1*sin(theta2)/cos(theta1 + theta2)\n"
COT = r"\cot(\theta_1+\theta_2)"

RIGHT = [
    ("slider_crank", rf"\delta d_3 = {SLIDE}\,\delta\theta_1"),
    ("slider_crank", "δd3 = l1*sin(theta2)/cos(theta1 + theta2)*δθ1"),
    ("slider_crank", r"\tau_1\delta\theta_1 = F\,\delta d_3"),
    ("2R", r"\delta x = J_{11}\delta q_1 + J_{12}\delta q_2"),
    ("2R", r"\tau_1\delta\theta_1 + \tau_2\delta\theta_2 = F_x\delta x + F_y\delta y"),
    ("2R", r"\tau_1\delta\theta_1 + \tau_2\delta\theta_2 = F_x\delta x + F_y\delta y + \delta V"),
    ("2R", "\\delta = I_2 + m_2 l_{c2}^2\nH_{12} = \\delta + m_2 l_1 l_{c2}\\cos\\theta_2"),
    ("slider_crank", rf"\frac{{\mathrm{{d}} d_3}}{{\mathrm{{d}}\theta_1}} = {SLIDE}"),
    ("slider_crank", rf"\frac{{dx}}{{d\theta_1}} = {SLIDE}"),
    ("slider_crank", r"\frac{dV}{d\theta_1} = \frac{\dot V}{\dot\theta_1}"),
    ("slider_crank", RATIO + r"\ddot d_3 = k\ddot\theta_1 + \frac{dk}{d\theta_1}\dot\theta_1^2"),
    ("2R", r"\frac{dV}{d\theta_2} = m_2 g l_{c2}\cos(\theta_1+\theta_2)"),
    ("slider_crank", rf"{COT} = -l_2\cos(\theta_1+\theta_2)\csc(\theta_1)/l_1"),
    ("2R", "x*sec(theta1) = l1 + l2*cos(theta1 + theta2)/cos(theta1)"),
    ("2R", "J = jacobian([l1*cos(q1) + l2*cos(q1 + q2); l1*sin(q1) + l2*sin(q1 + q2)], [q1; q2])"),
    ("2R", "T = 1/2*qd'*M*qd"),
    ("2R", "qd'*(Mdot - 2*C)*qd = 0"),
    ("2R", "T = 1/2*dq.T @ M @ dq"),
    ("2R", "tau = M @ ddq + C @ dq + g"),
    ("2R", r"\dot q^T(\dot M - 2C)\dot q = 0"),
    ("four_bar", r"\lambda^T\Phi_q\dot q = 0"),
    ("2R", "A = m2*l1\nC = lc2\nH12 = I2 + m2*lc2^2 + AC*cos(theta2)"),
    ("slider_crank", "n = l1*cos(theta1)/(l2*cos(theta1 + theta2))\nomega_2 = -n*dtheta1"),
    # rates of any quantity, of robots with a parameter d too
    ("four_bar", "τ1 θ̇1 = dT1/dt + dT2/dt + dT3/dt + dV1/dt + dV2/dt + dV3/dt"),
    ("four_bar", "τ1 θ̇1 = Ṫ1 + Ṫ2 + Ṫ3 + V̇1 + V̇2 + V̇3"),
    ("four_bar", "τ1 θ̇1 = d(T1 + T2 + T3 + V1 + V2 + V3)/dt"),
    ("four_bar", "f01 + f21 + m1 g = m1 d v_c1/dt"),
    ("slider_crank", "dT1/dt = (I1 + m1*lc1^2) dθ1/dt d²θ1/dt²"),
    ("2R", r"\dot T_1 = (I_1 + m_1 l_{c1}^2)\dot\theta_1\frac{d^2\theta_1}{dt^2}"),
    ("2R", "T1_dot = (I1 + m1 lc1²) θ̇1 ddθ1/dt²"),
    ("2R", "dp1/dt = τ1 - dV/dθ1"),
    ("2R", "diff(T_1, t) = (I1 + m1*lc1^2)*diff(theta1, t)*diff(theta1, (t, 2))"),
]  # fmt: skip


@pytest.mark.sample(5)
@pytest.mark.parametrize(("robot", "answer"), RIGHT)
def test_what_is_right_is_read(robot: str, answer: str):
    verdict = fb.check(load(robot), answer)
    assert verdict, verdict


WRONG = [
    ("slider_crank", rf"\delta d_3 = -{SLIDE}\,\delta\theta_1"),
    ("slider_crank", r"\tau_1\delta\theta_1 = 2F\,\delta d_3"),
    ("2R", r"\tau_1\delta\theta_1 + \tau_2\delta\theta_2 = F_x\delta x + F_y\delta y - \delta V"),
    ("slider_crank", r"\frac{d d_3}{d\theta_1} = l_1\sin\theta_2"),
    ("slider_crank", r"\frac{dV}{d\theta_1} = m_1 g l_{c1}\cos\theta_1"),
    ("slider_crank", RATIO + r"\ddot d_3 = k\ddot\theta_1 + 2\frac{dk}{d\theta_1}\dot\theta_1^2"),
    ("slider_crank", rf"{COT} = l_2\cos(\theta_1+\theta_2)\csc(\theta_1)/l_1"),
    ("2R", "J = jacobian([l1*cos(q1) + l2*cos(q1 + q2); l1*sin(q1) - l2*sin(q1 + q2)], [q1; q2])"),
    ("2R", "T = qd'*M*qd"),
    ("2R", "qd'*(Mdot - C)*qd = 0"),
    ("2R", "tau = M @ ddq + C @ dq - g"),
    ("2R", "A = m2*l1\nC = lc2\nH12 = I2 + m2*lc2^2 + 2AC*cos(theta2)"),
    ("four_bar", "τ1 θ̇1 = dT1/dt + dT2/dt + dT3/dt + dV1/dt + dV2/dt - dV3/dt"),
    ("four_bar", "dT1/dt = (I1 + m1 lc1²) θ̇1²"),
    ("2R", "Ṫ1 = ½ (I1 + m1 lc1²) θ̇1 θ̈1"),
    ("2R", "dp1/dt = τ1 + dV/dθ1"),
]  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize(("robot", "answer"), WRONG)
def test_what_is_wrong_stays_wrong(robot: str, answer: str):
    verdict = fb.check(load(robot), answer)
    assert not verdict
    assert not verdict.unread


REFUSED = [
    ("slider_crank", r"\tau_1\delta\theta_1 = m_3\ddot d_3\,\delta d_3", "beside virtual displace"),
    ("slider_crank", r"\delta d_3 = \dot d_3", "beside virtual displacements"),
    ("five_bar", r"\frac{dx}{d\theta_1} = 1", "several coordinates move freely"),
    ("2R", "x = l1*cos(theta1)' + l2*cos(theta1 + theta2)", "no vector or matrix"),
    ("2R", r"\theta_1 = \cot^{-1}(x/y)", "the inverse function of cot"),
    ("slider_crank", "cos(theta1 + theta2) = 0", "this tells a pose"),
    ("2R", "d/dt(θ̈1) = 0", "nothing here tells how θ̈₁ changes in time"),
    ("2R", "d/dt(τ1) = 0", "nothing here tells how θ̈₁ changes in time"),
    ("four_bar", "d/dt(λ1 l1) = 0", "nothing here tells how λ₁ changes in time"),
    ("four_bar", "T1 = 1/2 (I1 + m1 lc1^2) dθ1/dt²", "the time t does not occur"),
]


@pytest.mark.parametrize(("robot", "answer", "words"), REFUSED)
def test_what_may_mean_something_else_is_refused(robot: str, answer: str, words: str):
    with pytest.raises(fb.AnswerError) as refused:
        fb.check(load(robot), answer)
    assert words in str(refused.value)


SCRIPT = """
import sympy as sp
p = sp.Matrix([l1*sp.cos(q1) + l2*sp.cos(q1 + q2), l1*sp.sin(q1) + l2*sp.sin(q1 + q2)])
V = m1*g*lc1*sp.sin(q1) + m2*g*(l1*sp.sin(q1) + lc2*sp.sin(q1 + q2))
J = p.jacobian([q1, q2])
G = sp.Matrix([V]).jacobian([q1, q2]).T
w = J*sp.Matrix([q1d, q2d])
"""


def test_a_script_with_matrices_of_slopes():
    verdict = fb.check(load("2R"), SCRIPT, form="python")
    assert verdict, verdict
    assert {"J11", "J22", "G1", "G2"} <= {x.name for x in verdict.equations}
    wrong = fb.check(load("2R"), SCRIPT.replace("[q1, q2]).T", "[q2, q1]).T"), form="python")
    assert {x.name for x in wrong.equations if not x.equal} == {"G1", "G2"}


def test_no_multipliers_are_told_where_an_answer_has_none():
    verdict = fb.check(load("four_bar"), "tau1 = (I1 + m1*lc1^2)*ddtheta1")
    assert not verdict
    assert "λ" not in verdict.text
    assert "is missing" not in verdict.text


def test_angles_from_the_x_axis_are_told_of_a_mechanism():
    line = "omega_3 = l1*sin(theta1 - theta2)/(l3*sin(theta3 - theta2))*dtheta1"
    (cause,) = fb.check(load("four_bar"), line).causes
    assert cause.startswith("This would be right if all angles were measured from the x axis")
    assert fb.check(load("four_bar"), line, absolute=True)


def test_no_reaction_is_named_in_a_gravity_term():
    """It is found without reactions too, so that what is missing is told, not a guess at why."""
    line = (
        "G1 = m3*g*(l2*cos(theta1 + theta2) + lc3*cos(theta1 + theta2 + theta3))"
        " + m2*g*lc2*cos(theta1 + theta2) + (m1*lc1 + m2*l1)*g*cos(theta1)"
    )
    verdict = fb.check(load("3R"), line)
    assert not verdict
    assert not verdict.causes
    assert "‘l₁ cos θ₁’ of ‘m₃ g (l₁ cos θ₁ + " in str(verdict)


def test_what_is_left_out_is_named_where_loops_close():
    verdict = fb.check(load("four_bar"), r"τ1 θ̇1 = \frac{d}{dt}(T1 + T2 + V1 + V2)")
    assert "moment of inertia of rocker is missing" in verdict.equations[0].causes[0]
