"""Results of problem sets and books as students type them: rounded numbers where loops are closed,
roots and absolute values, sums of forces, SymPy's methods in plain text."""

from __future__ import annotations

import pytest

import freebody as fb

ARM, CART = fb.planar("RR"), fb.load("cart_pole")
FOUR_BAR, CRANK = fb.load("four_bar"), fb.load("slider_crank")

# ---------------------------------------------------------------- rounded numbers
_RATIO = "omega_3 = {}*dtheta1*sin(theta2)/sin(theta1 + theta2 - theta3)"  # l1/l3 = 3/7
_SLIDE = "d3 = 0.2*cos(theta1) + 0.6*sqrt(1 - {}*sin(theta1)^2)"  # (l1/l2)² = 1/9


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("model", "line", "right", "wrong"),
    [
        (FOUR_BAR, _RATIO, ("0.4286", "0.429", "0.43"), ("0.4276", "0.4287", "0.42")),
        (CRANK, _SLIDE, ("0.1111", "0.111"), ("0.1112", "0.112")),
        (fb.load("2R"), "theta2 = acos((x^2 + y^2 - {})/1.60)", ("1.64",), ("1.65",)),
    ],
)
def test_numbers_in_lines_that_hold_by_loops_are_read_to_their_digits(model, line, right, wrong):
    """Books round: a line is right if numbers that round to those written make it so everywhere."""
    for number in right:
        verdict = fb.check(model, line.format(number))
        assert verdict, verdict
    for number in wrong:
        assert not fb.check(model, line.format(number))


def test_all_rounded_numbers_of_a_leg_count_together():
    """The leg of the 3-RRR in four digits; the last digit of one that is off counts."""
    leg = (
        "(x - 0.1299*cos(theta3) + 0.0750*sin(theta3) + 0.4330 - 0.3*cos(theta4))^2"
        " + (y - 0.1299*sin(theta3) - {}*cos(theta3) + 0.25 - 0.3*sin(theta4))^2 = 0.35^2"
    )
    robot = fb.load("3RRR")
    assert fb.check(robot, leg.format("0.0750"))
    assert not fb.check(robot, leg.format("0.0752"))


# ---------------------------------------------------------------- roots and absolute values
@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("model", "line"),
    [
        (CART, "theta2_dd = -(x_dd*cos(theta2) + g*sqrt(1 - cos(theta2)^2))/l2"),
        (CART, "l2*theta2_dd + x_dd*cos(theta2) + g*sqrt(1 - cos(theta2)^2) = 0"),
        (CRANK, "d3_d = -l1*dtheta1*sqrt(1 - cos(theta1)^2)"
         " - l2*(dtheta1 + dtheta2)*sin(theta1 + theta2)"),
        (FOUR_BAR, "omega_3 = l1*dtheta1*sqrt(1-cos(theta2)^2)/(l3*sin(theta1+theta2-theta3))"),
        (ARM, "dtheta1 = (v_x*cos(theta1 + theta2) + v_y*sin(theta1 + theta2))"
         "/(l1*sqrt(1 - cos(theta2)^2))"),
        (ARM, "det J = l1*l2*|sin(theta2)|"),
        (ARM, "G2 = m2*g*lc2*np.abs(np.cos(q1 + q2))"),
        (CRANK, r"d_3 = |l_1\cos\theta_1| + l_2\cos(\theta_1+\theta_2)"),
    ],
)  # fmt: skip
def test_a_lost_sign_is_no_posture(model, line):
    """√(1 − cos²θ) is |sin θ|: where θ is written its sine has a sign, and no choice is left."""
    assert not fb.check(model, line)


@pytest.mark.parametrize(
    ("model", "line"),
    [
        (CRANK, r"\dot d_3 = -l_1\dot\theta_1\left(\sin\theta_1"
         r" + \frac{l_1\sin 2\theta_1}{2\sqrt{l_2^2 - l_1^2\sin^2\theta_1}}\right)"),
        (CRANK, r"d_3 = l_1\cos\theta_1 + |l_2\cos(\theta_1+\theta_2)|"),
        (CRANK, r"|\dot d_3| = |l_1\dot\theta_1\sin\theta_2/\cos(\theta_1+\theta_2)|"),
        (ARM, "abs(sin(theta2)) = sqrt(1 - cos(theta2)^2)"),
        (ARM, "sin(theta2) = sqrt(1 - cos(theta2)^2)"),
    ],
)  # fmt: skip
def test_roots_and_absolute_values_that_hold(model, line):
    """Roots of what the line's symbols leave open are postures; absolute values have one value."""
    verdict = fb.check(model, line)
    assert verdict, verdict


# ---------------------------------------------------------------- forces
def test_a_force_on_the_piston_stands_behind_a_root_too():
    """Virtual work: τ = F ∂d/∂θ, with the force in either sense."""
    turn = "F*l1*sin(theta1)*(1 {} l1*cos(theta1)/sqrt(l2^2 - l1^2*sin(theta1)^2))"
    for sign in ("", "-"):
        assert fb.check(CRANK, f"tau1 = {sign}{turn.format('+')}")
        assert not fb.check(CRANK, f"tau1 = {sign}{turn.format('-')}")


def test_sums_of_drives_are_equations_too():
    """The difference of two torques, in motion and held still."""
    moving = (
        "tau1 - tau2 = H11*ddtheta1 + H12*ddtheta2 + v1 + G1"
        " - H21*ddtheta1 - H22*ddtheta2 {} v2 - G2"
    )
    still = "In equilibrium: tau1 - tau2 = m1*g*lc1*cos(theta1) + m2*g*l1*cos(theta{})"
    for line, right, wrong in ((moving, "-", "+"), (still, "1", "2")):
        assert fb.check(ARM, line.format(right))
        assert not fb.check(ARM, line.format(wrong))


def test_velocity_terms_stand_beside_inertia_forces():
    """c1 in Kane's F₁* is the velocity term, not a cosine."""
    line = "F_1 + F_1^* = 0\nF_1^* = -(H11*ddtheta1 + H12*ddtheta2 {} c1)"
    assert fb.check(ARM, line.format("+"))
    assert not fb.check(ARM, line.format("-"))


# ---------------------------------------------------------------- spellings
@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("line", "wrong"),
    [
        ("tau2 = sp.diff(L.diff(theta2.diff(t)), t) - L.diff(theta2)", ("- L", "+ L")),
        ("alpha_2 = theta1.diff(t, 2) + theta2(t).diff(t, t)", ("+", "-")),
        ("G2 = m2*g*lc2*np.cos(q1 + q2)", ("np.cos", "np.sin")),
        (r"\boxed{\,G_2 = m_2 g l_{c2}\cos(\theta_1+\theta_2)\,}", (r"\cos", r"\sin")),
        (r"H_{22} \overset{!}{=} m_2 l_{c2}^2 + I_2", ("+", "-")),
        ("tau2 == (m2*lc2**2 + I2)*(q1dd + q2dd) + m2*l1*lc2*(np.cos(q2)*q1dd + np.sin(q2)*q1d**2)"
         " + m2*g*lc2*np.cos(q1+q2)", ("+ np.sin", "- np.sin")),
    ],
)  # fmt: skip
def test_what_students_copy_from_code_and_notes_is_read(line, wrong):
    """The line is right, and with one change wrong."""
    verdict = fb.check(ARM, line)
    assert verdict, verdict
    assert not fb.check(ARM, line.replace(*wrong))
