"""Right answers of other forms: other matrices C, numbers, equations of passive joints; answers
that say nothing."""

import re
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb

ARM = fb.planar("RR")
CART = fb.planar("PR", m=["mc", "mp"], lc=[0, "l"], l=[0, "l"], I=[0, 0], passive=["joint2"])
ACROBOT = fb.planar("RR", passive=["joint1"])

SPONG = """C11 = -2 h theta2_d
C12 = -h theta2_d
C21 = h theta1_d
C22 = 0
h = m2 l1 lc2 sin(theta2)"""
"""The acrobot's matrix as Tedrake prints it (Underactuated Robotics, the acrobot's equations of
motion)."""


# ---------------------------------------------------------------- Coriolis matrices
def test_the_published_acrobots_matrix_is_right_though_not_christoffels():
    verdict = fb.check(ARM, SPONG)
    assert verdict, verdict.text
    assert (
        verdict.text.count("C is not the Christoffel matrix. Ṁ − 2C is not skew-symmetric.") == 2
    )  # row 2 is the same


def test_christoffels_own_matrix_needs_no_word():
    verdict = fb.check(ARM, "h = m2 l1 lc2 s2\nC = [[-h θ̇2, -h (θ̇1 + θ̇2)], [h θ̇1, 0]]")
    assert verdict
    assert "Christoffel" not in verdict.text


def test_another_skew_symmetric_matrix_is_said_to_be_one():
    """Christoffel's and S with S q̇ = 0, S skew-symmetric: of three joints S = u [q̇]× with any
    u."""
    arm = fb.planar("PPR")
    own = fb.equations(arm).C
    text = [[str(fb.equations(arm).form(x)) for x in row] for row in own]
    u = "m3 lc3"
    spin = [[0, "-θ̇3", "ḋ2"], ["θ̇3", 0, "-ḋ1"], ["-ḋ2", "ḋ1", 0]]
    rows = [
        "[" + ", ".join(f"{a} + {u} ({b})" for a, b in zip(x, y, strict=True)) + "]"
        for x, y in zip(text, spin, strict=True)
    ]
    verdict = fb.check(arm, f"C = [{', '.join(rows)}]")
    assert verdict, verdict.text
    assert "Ṁ − 2C is skew-symmetric." in verdict.text


@pytest.mark.parametrize(
    "answer",
    [
        SPONG.replace("-2 h", "-h"),
        SPONG.replace("C21 = h theta1_d", "C21 = h theta2_d"),
        SPONG.replace("C22 = 0", "C22 = h theta1_d"),
    ],
)
def test_a_matrix_with_another_product_is_wrong(answer: str):
    assert not fb.check(ARM, answer)


def test_one_entry_alone_is_compared_with_christoffels():
    verdict = fb.check(ARM, "C11 = -2 m2 l1 lc2 s2 theta2_d")
    assert not verdict
    assert "give the whole row" in verdict.text


# ---------------------------------------------------------------- names with two meanings
OWN_NAMES = [
    "k1 = m2 l1 lc2 s2\nc2 = k1 dtheta1^2",
    "phi2 = theta1 + theta2\nG2 = m2 lc2 g cos(phi2)",
    "b1 = m2 l1 lc2\nH12 = I2 + m2 lc2^2 + b1 c2",
    "v1 = lc1 dtheta1\nT1 = m1 v1^2/2 + I1 dtheta1^2/2",
]


@pytest.mark.sample(2)
@pytest.mark.parametrize("answer", OWN_NAMES)
def test_letters_that_some_books_have_for_quantities_may_be_ones_own(answer: str):
    """k1 is a body's kinetic energy to some; a name of other units that other lines use is none."""
    verdict = fb.check(ARM, answer)
    assert verdict, verdict.text
    name, value = answer.splitlines()[0].split(" = ")
    assert not fb.check(ARM, answer.replace(f"{name} =", f"{name} = 2"))
    assert not fb.check(ARM, f"{name} = {value}\n{name} = m2\nH22 = m2 lc2^2 + I2")


def test_such_a_letter_in_the_quantitys_units_is_the_quantity():
    energy = "k1 = (m1 lc1^2 + I1) dtheta1^2{}\nL = k1 + T2 - V"
    assert fb.check(ARM, energy.format("/2")).text == "k1 is right.\nL is right."
    verdict = fb.check(ARM, energy.format(""))
    assert not verdict
    assert "k1, the kinetic energy of body 1, is not right" in verdict.text


def test_components_of_a_bodys_vector_are_told_apart():
    verdict = fb.check(ARM, "vc1 = [-lc1 s1 dtheta1; lc1 s1 dtheta1]")
    assert "vc1x is right.\nvc1y, the velocity" in verdict.text


# ---------------------------------------------------------------- numbers
NUMBERS = {"l": [0.4, 0.3], "lc": [0.2, 0.15], "m": [2.0, 1.5], "I": [0.031, 0.012]}
VALUED = fb.planar("RR", **NUMBERS)


def test_right_numbers_of_a_bundled_arm():
    two = fb.load("2R")
    exact = fb.mass_matrix(two, [0.0, 0.0])[1, 1]
    verdict = fb.check(two, f"H22 = {exact:.2f}")
    assert verdict, verdict.text
    assert "In numbers, with the values of '2R', to the digits given." in verdict.text
    assert not fb.check(two, f"H22 = {exact + 0.02:.2f}")


@pytest.mark.parametrize("digits", [2, 3, 5, 9])
def test_numbers_count_to_half_a_unit_of_their_last_digit(digits: int):
    """H22 = m2 lc2² + I2 = 0.04575: rounded it is right, one unit more is wrong."""
    value = Fraction("1.5") * Fraction("0.15") ** 2 + Fraction("0.012")
    rounded = round(value, digits)
    unit = Fraction(1, 10**digits)
    assert fb.check(VALUED, f"H22 = {float(rounded):.{digits}f}")
    assert not fb.check(VALUED, f"H22 = {float(rounded + unit):.{digits}f}")
    assert not fb.check(VALUED, f"H22 = {float(rounded - unit):.{digits}f}")


def test_a_whole_torque_in_numbers():
    eq = fb.equations(VALUED, numbers=True)
    printed = "\n".join(f"tau{i} = {eq.form(x)}" for i, x in enumerate(eq.tau, 1))
    assert fb.check(VALUED, printed)
    wrong = re.sub(r"(\d\.\d+)", lambda m: f"{float(m[0]) * 1.02:.6g}", printed, count=1)
    verdict = fb.check(VALUED, wrong)
    assert not verdict
    assert "must be" in verdict.text
    assert len(verdict.findings) == 1


def test_gravity_may_stay_a_letter_or_be_a_number():
    assert fb.check(VALUED, "G2 = 0.225 g cos(θ1+θ2)")
    assert fb.check(VALUED, "G2 = 2.207 cos(θ1+θ2)")
    assert not fb.check(VALUED, "G2 = 2.207 cos(θ1)")
    assert fb.check(ARM, "G2 = m2 lc2 9.81 c12")


def test_what_a_right_angle_leaves_out_may_be_left_out():
    """Two axes at right angles do not couple; with another twist they do."""
    rows = [{"a": "a1", "alpha": "al", "m": "m1"}, {"a": "a2", "m": "m2"}]
    arm = fb.dh(rows, convention="standard")
    upright = arm.bind(al=np.pi / 2)
    assert fb.check(upright, "H12 = 0\nG2 = m2 g a2 cos(theta2)")
    assert not fb.check(upright, "H12 = 0.1")
    assert not fb.check(arm.bind(al=1.5), "H12 = 0")
    assert not fb.check(arm, "H12 = 0")


def test_symbols_that_are_right_by_chance_only_are_not_right():
    """lc2 is l2/2 here, and m1 1 kg, but not in the robot's equations."""
    arm = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[1.0, 1.5], I=[0.031, 0.012])
    for answer in (
        "H22 = m2 l2^2/4 + I2", "H22 = 0.25 m2 l2^2 + I2", "V1 = g lc1 s1",
        "H11 = lc1^2 + I1 + m2 (l1^2 + lc2^2 + 2 l1 lc2 c2) + I2",
    ):  # fmt: skip
        assert not fb.check(arm, answer), answer
    mixed = fb.check(arm, "G2 = m2 0.15 g c12")
    assert not mixed
    assert "one term mixes symbols and numbers" in mixed.text


# ---------------------------------------------------------------- circles
@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("T = T + 0", "T is defined by itself"),
        ("H22 = 2*H22 - M22", "H22 is defined by itself"),
        ("H22 = M22", "H22 is defined by itself"),
        ("a = H22\nH22 = a", "H22 is defined by itself"),
        ("tau1 = tau1 + H12 - H21", "tau1 is defined by itself"),
        ("L = T - V\nT = L + V", "by way of"),
        ("H12 = H21\nH21 = H12", "by way of"),
        ("M = [[M11, M12], [M21, M22]]", "M11 is defined by itself"),
        ("H11 = tau1 + H11 - tau1", "H11 is defined by itself"),
    ],
)
def test_what_is_given_by_itself_is_refused(answer: str, words: str):
    with pytest.raises(fb.AnswerError, match=re.escape(words)):
        fb.check(ARM, answer)


def test_names_of_ones_own_hide_no_circle():
    with pytest.raises(fb.AnswerError, match="defined by itself"):
        fb.check(ARM, "H22 = A", names={"A": "H22"})


def test_quantities_may_be_written_by_others():
    assert fb.check(ARM, "H12 = H21\nL = T - V\ntau2 = H21 θ̈1 + H22 θ̈2 + v2 + G2")


# ---------------------------------------------------------------- passive joints
CARTPOLE = [
    "(mc + mp) d1_dd - mp l sin(theta2) theta2_dd - mp l cos(theta2) theta2_d^2",
    "-mp l sin(theta2) d1_dd + mp l^2 theta2_dd + mp g l cos(theta2)",
]
"""The pendulum's angle is counted from the cart's x axis here."""


@pytest.mark.parametrize(
    "answer",
    [
        f"u = {CARTPOLE[0]}\n0 = {CARTPOLE[1]}",
        f"F = {CARTPOLE[0]}\n{CARTPOLE[1]} = 0",
        f"tau = [{CARTPOLE[0]}, {CARTPOLE[1]}]",
        f"F1 = {CARTPOLE[0]}\ntau2 = 0",
        "0 = l theta2_dd - sin(theta2) d1_dd + g cos(theta2)",
        "0 = l θ̈ - sin(θ) d1_dd + g cos θ",
        "l theta2_dd = sin(theta2) d1_dd - g cos(theta2)",
        "0 = 2 mp (l^2 theta2_dd - l sin(theta2) d1_dd + l g cos(theta2))",
        "0 = -H21 d1_dd - H22 theta2_dd - v2 - G2",
        f"0 = tau2 = {CARTPOLE[1]}",
    ],
)
def test_a_cart_with_a_passive_pendulum(answer: str):
    verdict = fb.check(CART, answer)
    assert verdict, verdict.text


@pytest.mark.parametrize(
    "answer",
    [
        f"u = {CARTPOLE[0]} + mp g\n0 = {CARTPOLE[1]}",
        "0 = l theta2_dd + sin(theta2) d1_dd + g cos(theta2)",
        "0 = mp l^2 theta2_dd - mp l sin(theta2) d1_dd + 2 mp g l cos(theta2)",
        "0 = mp l^2 theta2_dd - mp l sin(theta2) d1_dd",
        f"0 = {CARTPOLE[0]}",
        f"u = {CARTPOLE[1]}",
    ],
)
def test_wrong_equations_of_a_cart_with_a_passive_pendulum(answer: str):
    assert not fb.check(CART, answer)


def test_the_mistake_in_an_equation_without_motor_is_named():
    verdict = fb.check(CART, "0 = -mp l sin(theta2) d1_dd + mp l^2 theta2_dd - mp g l cos(theta2)")
    assert "The equation of joint 2, which nothing drives, is not right." in verdict.text
    assert "has the wrong sign" in verdict.text
    halved = fb.check(CART, "0 = l^2 theta2_dd/2 - l sin(theta2) d1_dd/2 - g l cos(theta2)/2")
    assert not halved


def test_x_of_a_cart_may_be_the_slide():
    """x is the tip's where that is right."""
    answer = "u = (mc + mp) ẍ - mp l sin(θ) θ̈ - mp l cos(θ) θ̇^2"
    assert "x is read as the slide's coordinate d1." in fb.check(CART, answer).text
    wrong = fb.check(CART, answer.replace("- mp l sin", "+ mp l sin"))
    assert "say names={'x': 'd1'}" in wrong.text
    assert fb.check(CART, answer, names={"x": "d1"})


def test_the_acrobot_in_its_own_words():
    """Nothing at the shoulder, u at the elbow."""
    eq = fb.equations(fb.planar("RR"))
    shoulder, elbow = (str(eq.form(x)) for x in eq.tau)
    assert fb.check(ACROBOT, f"0 = {shoulder}\nu = {elbow}")
    assert not fb.check(ACROBOT, f"0 = {elbow}\nu = {shoulder}")
    assert not fb.check(ACROBOT, f"u = {shoulder}")
    assert fb.check(ACROBOT, str(eq))


def test_a_driven_arm_has_no_equation_without_torque():
    with pytest.raises(fb.AnswerError, match="neither side is one of the quantities"):
        fb.check(ARM, "0 = H21 θ̈1 + H22 θ̈2 + G2")


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("right", "wrong"),
    [
        ("2 G2 = 2 m2 g lc2 c12", "2 G2 = m2 g lc2 c12"),
        ("-G2 = -m2 g lc2 c12", "-G2 = m2 g lc2 c12"),
        ("G2/g = m2 lc2 c12", "G2/g = m2 lc1 c12"),
        ("G1 - G2 = (m1 lc1 + m2 l1) g c1", "G1 - G2 = (m1 lc1 + m2 l2) g c1"),
        ("x - l1 c1 = l2 c12", "x - l1 c1 = l2 s12"),
        ("2 T = H11 θ̇1^2 + 2 H12 θ̇1 θ̇2 + H22 θ̇2^2", "T/2 = H11 θ̇1^2 + 2 H12 θ̇1 θ̇2 + H22 θ̇2^2"),
    ],
)
def test_multiples_and_sums_of_quantities_are_checked(right: str, wrong: str):
    for arm in (ARM, fb.planar("RR", passive=["joint2"]), fb.load("four_bar").opened):
        if arm is ARM or not right.startswith(("x", "2 T", "G1")):
            assert fb.check(arm, right), arm
            assert not fb.check(arm, wrong), arm


@pytest.mark.parametrize("written", ["cos12", "sin123", "cos1"])
def test_digits_at_a_functions_name_are_asked_about(written):
    """cos12 may be c12; that of the number 12 is nothing that an arm's equations hold."""
    arm = fb.planar("RRR")
    with pytest.raises(fb.FreebodyError, match=f"{written} may be that of a sum of angles"):
        fb.check(arm, f"x = l1 c1 + l2 c12 + l3 {written}")
    assert fb.check(arm, "x = l1 c1 + l2 c12 + l3 c123 + 0 sin 2 theta1 + 0 sin2theta1")


# ---------------------------------------------------------------- P
V = "m1 g lc1 s1 + m2 g (l1 s1 + lc2 s12)"


@pytest.mark.parametrize(
    ("answer", "right", "words"),
    [
        ("P = τᵀ q̇", True, "read as the power of the drives"),
        ("P = τ1 θ̇1 + τ2 θ̇2", True, "read as the power of the drives"),
        ("P = τ1 θ̇1 - τ2 θ̇2", False, "P, the power of the drives, is not right"),
        ("P_2 = τ2 θ̇2", True, "read as the power of the drive of joint 2"),
        (f"P = {V}", True, "read as the potential energy."),
        (f"P = {V} - m1 g l1", True, "the zero level of V is arbitrary"),
        ("P = m1 g lc1 s1", False, "P, the potential energy, is not right"),
        ("P1 = m1 g lc1 s1", True, "read as the potential energy of body 1"),
    ],
)
def test_the_equation_tells_whether_p_is_a_power_or_an_energy(answer: str, right: bool, words: str):
    verdict = fb.check(ARM, answer)
    assert bool(verdict) is right, verdict
    assert words in verdict.text


def test_its_unit_tells_whether_a_number_is_a_power_or_an_energy():
    state = {"theta1": 0.3, "theta2": 0.4, "theta1_d": 1, "theta2_d": 2, "q̈": 0}
    power = fb.inverse_dynamics(VALUED, [0.3, 0.4], [1, 2], [0, 0]) @ [1, 2]
    energy = fb.potential_energy(VALUED, [0.3, 0.4])
    assert fb.check(VALUED, f"P = {power:.3f} W", at=state)
    assert fb.check(VALUED, f"P = {energy:.3f} J", at=state)
    assert "the power of the drives" in fb.check(VALUED, f"P = {energy:.3f} W", at=state).text


LEVELS = [
    ("2R", f"V = {V} + m1 g l1", True),
    ("2R", f"V = {V} + 5", True),
    ("2R", f"V = {V} + m1", False),
    ("2R", f"V = {V} + m2 g d2", False),
    ("2R", "E = T + V + I1", False),
    ("cart_pole", "V = m2 g l2 (1 - cos θ)", True),
    ("cart_pole", "V = m2 g l2 (1 - cos θ) + m1 g d", False),
    ("four_bar", "V = m1 g lc1 s1 + m2 g (l1 s1 + lc2 s12) + m3 g lc3 s3 + m3 g d", True),
    ("four_bar", "V = m1 g lc1 s1 + m2 g (l1 s1 + lc2 s12) + m3 g lc3 s3 + m3 d", False),
]


@pytest.mark.sample(4)
@pytest.mark.parametrize(("robot", "line", "right"), LEVELS)
def test_the_level_of_an_energy_is_an_energy_of_the_robots_own(robot, line, right):
    verdict = fb.check(fb.load(robot), line)
    assert bool(verdict) is right
    assert not right or "the zero level of V is arbitrary" in verdict.text


@pytest.mark.parametrize(
    ("line", "right"),
    [
        ("0 = τ1 - H11 θ̈1 - H12 θ̈2 - c1 - G1", True),
        ("τ1 - G1 = H11 θ̈1 + H12 θ̈2 + c1", True),
        ("G1 - (τ1 - c1) = -H11 θ̈1 - H12 θ̈2", True),
        ("0 = τ1 - H11 θ̈1 - H12 θ̈2 + c1 - G1", False),
        ("τ1 + G1 = H11 θ̈1 + H12 θ̈2 + c1", False),
    ],
)
def test_c1_is_the_velocity_term_wherever_the_torque_stands(line, right):
    verdict = fb.check(fb.load("2R"), line)
    assert bool(verdict) is right
    assert not right or "‘c1’ is read as the velocity term" in verdict.text


def test_a_mistake_beside_a_torque_is_shown_where_it_is_written():
    line = "0 = τ2 - m2 g lc2 c12 - H12 θ̈1 + H22 θ̈2 - m2 l1 lc2 s2 θ̇1²"
    assert "‘H22 θ̈2’ has the wrong sign: it must be −H22 θ̈2" in fb.check(fb.load("2R"), line).text


CHRISTOFFELS = {"h111": "0", "h112": "-h", "h121": "-h", "h122": "-h", "h211": "h", "h222": "0"}
OF_LAGRANGE = CHRISTOFFELS | {"h112": "-2*h", "h121": "0", "h212": "-h/2", "h221": "h/2"}
H = "m2*l1*lc2*sin(theta2)"


@pytest.mark.parametrize("values", [CHRISTOFFELS, OF_LAGRANGE])
def test_coefficients_of_rates_are_right_in_either_definition_and_one_for_all(values):
    """Yoshikawa (1990) and Asada and Slotine (1986): the sums with the rates are the same."""
    lines = [f"{name} = {value.replace('h', H)}" for name, value in values.items()]
    verdict = fb.check(fb.planar("RR"), "\n".join(lines))
    assert verdict
    told = "∂H_ij/∂q_k" if values is OF_LAGRANGE else "Christoffel"
    assert all(told in x.note for x in verdict.equations)
    mixed = "\n".join([*lines, f"h121 = {'-' + H if values is OF_LAGRANGE else 0}"])
    assert not fb.check(fb.planar("RR"), mixed)


def test_a_wrong_coefficient_of_rates_is_told():
    verdict = fb.check(fb.planar("RR"), f"h_{{112}} = {H}")
    assert "the coefficient of the rates 1 and 2 in the velocity term of joint 1" in verdict.text
    assert "has the wrong sign" in verdict.findings[0].message
    arm = fb.planar("RRR")
    line = "c2 = h_{211} θ̇1^2 + h_{233} θ̇3^2 + 2 h_{213} θ̇1 θ̇3 + 2 h_{223} θ̇2 θ̇3 + h222 θ̇2^2"
    assert fb.check(arm, f"{line} + 2 h_{{212}} θ̇1 θ̇2")
