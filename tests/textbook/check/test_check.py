"""`check` by hand: answers in many notations, typical mistakes and what is said of them, unreadable
input."""

from __future__ import annotations

import math
import pickle
import re
import time
from pathlib import Path

import pytest

import freebody as fb
from support.command import run
from support.extras import extra

ARM = fb.planar("RR")
M12 = "m2*(lc2^2 + l1*lc2*cos(theta2)) + I2"


# ---------------------------------------------------------------- equal, written differently
EQUAL = [
    "H12 = m2*(lc2^2 + l1*lc2*cos(theta2)) + I2",
    "M21 = I2 + m2 lc2 (lc2 + l1 c2)",
    "H₁₂ = H₂₁ = m₂ (lc₂² + l₁ lc₂ cos θ₂) + I₂",
    r"H_{12} = m_2\left(l_{c2}^2 + l_1 l_{c2}\cos\theta_2\right) + I_2",
    "H11 = m1 lc1² + I1 + m2 (l1² + lc2² + 2 l1 lc2 cos θ2) + I2",
    "H11 = I1 + I2 + m1*lc1**2 + m2*((l1 + lc2*c2)**2 + (lc2*s2)**2)",
    "H_{1,1} = m_1 l_{c,1}^{2} + I_{1} + I_{2} + m_2 [l_1 l_1 + 2 l_1 l_{c_2} c_{2} + l^2_{c2}]",
    "m22 = 0.5 m2 lc2 (4 lc2 - 2 lc2) + 1.0 I2",
    "G2=m2glc2c12",
    "g_1 = g (m1 lc1 + m2 l1) cos(q1) + g m2 lc2 (cos q1 cos q2 - sin q1 sin q2)",
    "G1 = m1 g(lc1 cos θ1 ) + m2 g(l1 cos θ1 + lc2 cos(θ1 + θ2 ))",
    "G1 = m1 g lc1 sin(pi/2 - th1) + m2 g (l1 sin(θ1 + 90°) + lc2 cos theta12)",
    "c1 = -m2 l1 lc2 s2 (2 dtheta1 dtheta2 + dtheta2^2)",
    "c2 = m2·l1·lc2·sin θ₂·θ̇₁²",
    r"v_1 = - m_2 l_1 l_{c2} \sin\theta_2\,\dot{\theta}_2 (2\dot\theta_1 + \dot{\theta_2})",
    "tau1 = H11 θ̈1 + H12 θ̈2 - h θ̇2^2 - 2hθ̇1θ̇2 + G1",
    "tau1 = H11 qdd1 + H12 qdd2 + h qd2^2 + 2 h qd1 qd2 + G1\nh = -m2 l1 lc2 sin(q2)",
    "τ₂ - m2 g lc2 c12 = H21 θ₁'' + H22 θ₂''\n  + m2 l1 lc2 s2 θ₁'²",
    "T = 1/2 m1 lc1^2 ω1^2 + ½ I1 ω1² + 1/2 I2 ω2^2 + 1/2 m2 (l1²ω1² + lc2² ω2² + 2 l1 lc2 ω1 ω2 "
    "cos θ2)",
    "V = m1 g lc1 sin θ1 + m2 g (l1 sin θ1 + lc2 sin (θ1 + θ2)) + m1 g l1",
    "J11 = -l1 s1 - l2 s12; J12 = -l2 s12; J31 = 1",
    "x = l1 c1 + l2 c12, y = l1 s1 + l2 s12",
    "ẍ = -l1(θ̈1 s1 + θ̇1² c1) - l2((θ̈1+θ̈2)s12 + (θ̇1+θ̇2)² c12)",
    "detJ = l1 l2 s2",
    "M = [[m1 lc1^2 + I1 + m2 l1^2 + H22 + 2 m2 l1 lc2 c2, H21], [m2*lc2*(lc2 + l1*c2) + I2, "
    "m2*lc2**2 + I2]]",
    r"G = \begin{bmatrix} m_1 g l_{c1} c_1 + m_2 g (l_1 c_1 + l_{c2} c_{12}) \\ m_2 g l_{c2} "
    r"c_{12} \end{bmatrix}",
    "# what I found\nH22 = m2 lc2^2 + I2\n\nG2 = m2 g lc2 cos(θ1+θ2)",
    r"\begin{aligned} H_{22} &= m_2 l_{c2}^2 + I_2 \\ h &= m_2 l_1 l_{c2} \sin \theta_2 "
    r"\end{aligned}",
]  # fmt: skip


@pytest.mark.parametrize("answer", EQUAL)
def test_the_same_written_differently_is_equal(answer: str):
    verdict = fb.check(ARM, answer)
    assert verdict, verdict.text
    assert verdict.findings == ()


def test_what_the_program_prints_is_equal():
    for word in ("RR", "RP", "PRR"):
        model = fb.planar(word)
        equations = fb.equations(model)
        for view in ("named", "expanded"):
            for text in (
                equations.text(view, width=40),
                equations.latex(view, environment="align*"),
            ):
                verdict = fb.check(model, text)
                assert verdict, verdict.text
                assert len(verdict.equations) >= len(word)


# ---------------------------------------------------------------- typical mistakes
# answer, kind of the finding (or of the first), words of the verdict
WRONG = [
    # the notes as printed
    ("H11 = m1 lc1^2 + I1 + I2 + m2 (l1^2 + lc2^2 + 2 l1 lc2 cos θ2) + I2", "extra",
     "‘I2’ should not be there"),
    ("H22 = m1 lc2^2 + I2", "index", "‘m1’ must be m₂ in ‘m1 lc2^2’"),
    ("H12 = m2 (lc2^2 + 2 l1 lc2 cos θ2) + I2", "factor", "cos θ2’ is twice as large as it"),
    ("V2 = m2 g (l1 sin θ1 + lc1 sin θ1)", "extra", "‘m₂ g lc₂ sin(θ₁+θ₂)’ is missing"),
    # signs
    ("G2 = -m2 g lc2 cos(θ1+θ2)", "sign", "sign of gravity"),
    ("tau2 = H21 θ̈1 + H22 θ̈2 + h θ̇1² - G2", "sign", "sign of gravity"),
    ("tau1 = H11 θ̈1 + H12 θ̈2 + h θ̇2² + 2 h θ̇1 θ̇2 + G1", "sign",
     "centrifugal terms have the wrong sign"),
    ("tau2 = H21 θ̈1 + H22 θ̈2 - h θ̇1² + G2", "sign", "‘- h θ̇1²’ has the wrong sign"),
    ("J11 = l1 s1 + l2 s12", "sign", "The whole answer has the wrong sign"),
    ("x = l1 c1 - l2 c12", "sign", "‘- l2 c12’ has the wrong sign"),
    # factors
    ("tau1 = H11 θ̈1 + H12 θ̈2 - h θ̇2² - h θ̇1 θ̇2 + G1", "factor", "occurs twice"),
    ("c1 = -m2 l1 lc2 s2 (θ̇2² + θ̇1 θ̇2)", "factor", "‘θ̇1 θ̇2’ is half as large as it should be"),
    ("H11 = m1 lc1² + I1 + m2 (l1² + lc2² + l1 lc2 c2) + I2", "factor",
     "‘l1 lc2 c2’ is half as large as it should be"),
    ("T1 = (m1 lc1² + I1) θ̇1²", "factor", "is twice as large as it should be"),
    # lengths and indices
    ("G2 = m2 g l2 cos(θ1+θ2)", "length", "the centre of mass of link 2 is lc₂ from its joint"),
    ("G1 = m1 g lc1 c1 + m2 g (lc1 c1 + lc2 c12)", "length", "l₁ is the distance to the next"),
    ("H22 = m2 l2² + I2", "length", "You wrote l₂ for lc₂"),
    ("H22 = m2 (l2/2)² + I2", "extra", "the midpoint of the link, lc₂ = l₂/2"),
    ("H12 = m1 (lc2² + l1 lc2 c2) + I2", "index", "‘m1’ must be m₂"),
    ("tau2 = H12 θ̈1 + H11 θ̈2 + h θ̇1² + G2", "index", "‘H11’ must be H22"),
    # parallel axis, moments of inertia
    ("H11 = I1 + m2 (l1² + lc2² + 2 l1 lc2 c2) + I2", "missing",
     "The parallel-axis theorem is missing"),
    ("H22 = I2", "missing", "m₂ lc₂² must be added"),
    ("H11 = m1 lc1² + m2 (l1² + lc2² + 2 l1 lc2 c2)", "missing", "right for point masses only"),
    ("H11 = m1 lc1² + I1 + m2 (l1² + lc2² + 2 l1 lc2 c2)", "missing", "ω₂ = θ̇₁ + θ̇₂"),
    # angles and functions
    ("G2 = m2 g lc2 cos θ2", "angle", "each angle is measured from the previous link"),
    ("G1 = m1 g lc1 c1 + m2 g (l1 c1 + lc2 c2)", "angle", "were measured from the x axis"),
    ("h = m2 l1 lc2 sin(θ1+θ2)", "angle", "must be sin θ₂"),
    ("h = m2 l1 lc2 cos θ2", "function", "‘cos θ2’ must be sin θ₂"),
    ("G1 = (m1 lc1 + m2 l1) g s1 + m2 g lc2 s12", "function", "were measured from the vertical"),
    ("T = 1/2 (m1 lc1² + I1) θ̇1² + 1/2 I2 θ̇2² + 1/2 m2 (l1² θ̇1² + lc2² ω2² + 2 l1 lc2 c2 θ̇1 "
     "ω2)", "rate",
     "‘θ̇2’ must be θ̇₁ + θ̇₂"),
    ("c2 = m2 l1 lc2 s2 θ̇1 θ̇2", "rate index", "‘θ̇2’ must be θ̇₁"),
    # powers, factors, terms
    ("H22 = m2 lc2 + I2", "exponent", "‘lc2’ has the wrong power"),
    ("H12 = m2 lc2² + l1 lc2 c2 + I2", "missing factor", "‘l1 lc2 c2’ lacks the factor m₂"),
    ("G2 = m2 lc2 c12", "missing factor", "‘m₂ lc₂ cos(θ₁+θ₂)’ has kg m, where"),
    ("H12 = m2 lc2² + I2", "missing", "right for H22"),
    ("tau1 = (m1 lc1² + I1) θ̈1 + m1 g lc1 c1", "missing",
     "the moment of inertia of link2 is missing"),
    ("tau2 = H21 θ̈1 + H22 θ̈2 + h θ̇1²", "missing", "Gravity is missing"),
    ("H22 = m2 lc2² + I2 + m2 l1 lc2", "extra", "‘m2 l1 lc2’ should not be there"),
    ("tau1 = H11 θ̈1 + H12 θ̈2 + G1", "missing", "Coriolis and centrifugal terms are missing"),
]  # fmt: skip


@pytest.mark.sample(5)
@pytest.mark.parametrize(("answer", "kind", "words"), WRONG)
def test_typical_mistakes_are_named(answer: str, kind: str, words: str):
    verdict = fb.check(ARM, answer)
    assert not verdict
    assert verdict.findings[0].kind in kind.split() or verdict.findings[0].kind == kind
    assert words in verdict.text


@pytest.mark.parametrize(
    ("gravity", "words"),
    [
        ((0.0, 0.0, -9.81), "weights act along −z, so V = + m g z"),
        ((0.0, 9.81, 0.0), "weights act along +y, so V = − m g y"),
        ((3.0, 0.0, -4.0), "V = − m g · r, with the vector g"),
    ],
)
def test_where_the_weights_pull_is_said_of_this_robot(gravity: tuple[float, ...], words: str):
    lift = fb.dh([{"joint": "R", "alpha": math.pi / 2, "a": "a1"},
                  {"joint": "R", "a": "a2", "m": "m2"}], convention="standard")  # fmt: skip
    lift = lift.replace(gravity=gravity).replace(gravity="g")
    right = fb.check(lift, "G2 = 0").findings[0].right
    verdict = fb.check(lift, f"G2 = -({right})")
    assert "the sign of gravity" in verdict.text
    assert words in verdict.text


RUBBED = ARM.with_drive("joint1", viscous="b", coulomb="f")


@pytest.mark.parametrize("family", "TV")
def test_energies_of_a_body_are_those_of_its_payload_too(family: str):
    loaded = ARM.with_payload(mass=1.5)
    own = fb.check(ARM, f"{family}2 = 0").findings[0].right
    assert fb.check(ARM, f"{family}2 = {own}")
    verdict = fb.check(loaded, f"{family}2 = {own}")
    assert not verdict
    assert "1.5 " in verdict.text
    assert "l₂" in verdict.findings[0].message
    with pytest.raises(fb.FreebodyError, match="rc2"):  # a fraction that has no symbol
        fb.check(loaded, "rc2x = 0")


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("friction", "words"),
    [
        ("", "Friction is missing; everything else is right."),
        ("- b θ̇1 - f sgn(θ̇1)", "All friction terms have the wrong sign"),
    ],
)
def test_friction_is_not_taken_for_velocity_terms(friction: str, words: str):
    right = "tau1 = H11 θ̈1 + H12 θ̈2 - h θ̇2² - 2 h θ̇1 θ̇2 + G1"
    assert fb.check(RUBBED, f"{right} + b θ̇1 + f sgn(θ̇1)")
    verdict = fb.check(RUBBED, f"{right} {friction}")
    assert not verdict
    assert words in verdict.text
    assert "entrifugal" not in verdict.text
    missing = fb.check(RUBBED, "tau1 = H11 θ̈1 + H12 θ̈2 + G1 + b θ̇1 + f sgn(θ̇1)")
    assert "The Coriolis and centrifugal terms are missing; everything else" in missing.text


def test_a_verdict_reads_like_this():
    verdict = fb.check(ARM, "H22 = m2*lc2**2 + I2\nH12 = m2*(lc2**2 + 2*l1*lc2*cos(theta2)) + I2")
    assert str(verdict).splitlines() == [
        "H22 is right.",
        "H12, entry 1, 2 of the mass matrix, is not right.",
        "  ‘2*l1*lc2*cos(theta2)’ is twice as large as it should be: it must be l₁ lc₂ cos θ₂.",
        "      H12 = m2*(lc2**2 + 2*l1*lc2*cos(theta2)) + I2",
        "                         ^^^^^^^^^^^^^^^^^^^^",
        "  For example, at θ₂ = 0.9, l₁ = 0.5, m₂ = 2, lc₂ = 0.15, I₂ = 0.05: "
        "yours is 0.2815, the right one 0.1882.",
    ]
    (finding,) = verdict.findings
    assert (finding.kind, finding.yours, finding.right) == (
        "factor",
        "2*l1*lc2*cos(theta2)",
        "l₁ lc₂ cos θ₂",
    )
    assert (finding.line, finding.column) == (2, 20)


def test_the_example_shows_both_numbers():
    (equation,) = fb.check(fb.load("2R"), "G2 = m2 g lc2 cos θ2").equations
    example = equation.example
    assert example is not None
    assert example.values["m2"] == 3.0  # the model's own
    values = example.values
    g2 = values["m2"] * values["g"] * values["lc2"]
    import math

    assert example.yours == pytest.approx(g2 * math.cos(values["theta2"]))
    assert example.right == pytest.approx(g2 * math.cos(values["theta1"] + values["theta2"]))


def test_mistakes_of_several_kinds_at_once_are_all_named():
    verdict = fb.check(ARM, "H11 = m2 lc1² + I1 + m2 (l1² - lc2² + 2 l1 lc2 s2) + I2")
    assert {f.kind for f in verdict.findings} == {"index", "sign", "function"}


def test_a_line_that_is_right_in_one_reading_of_its_symbols_is_right():
    read = "‘c1’ is read as the velocity term."
    assert read in fb.check(ARM, "tau1 = M11 θ̈1 + M12 θ̈2 + c1 + g1").text
    assert fb.check(ARM, "tau1 = M11 θ̈1 + M12 θ̈2 + v1 + g1")
    solved = fb.check(ARM, "θ̈1 = (H22 (τ1 - c1 - G1) - H12 (τ2 - c2 - G2))/(H11 H22 - H12^2)")
    assert solved
    assert read in solved.text
    spong = fb.check(ARM, "τ1 = d11 q̈1 + d12 q̈2 + c1 + g1", notation="spong")
    assert spong
    assert "is read as the velocity term" in spong.text
    wrong = fb.check(ARM, "tau1 = M11 θ̈1 - M12 θ̈2 + c1 + g1")
    assert "‘c1’ on the right is read as a cosine; write v1 for the velocity term." in wrong.text
    assert fb.check(ARM, "V = 9.81 (m1 lc1 s1 + m2 (l1 s1 + lc2 s12))")
    assert not fb.check(ARM, "V = 9.7 (m1 lc1 s1 + m2 (l1 s1 + lc2 s12))")
    unknown = fb.planar("RR", g="g")
    verdict = fb.check(unknown, "V = m1 9.81 lc1 s1 + m2 9.81 (l1 s1 + lc2 s12)")
    assert not verdict
    assert "‘9.81’ must be the symbol g" in verdict.text


@pytest.mark.parametrize(
    ("robot", "answer", "zeros"),
    [
        ("RP", "f2 = m2 (d̈2 - (l1 + d2) θ̇1²) + m2 g s1", ("lc2",)),
        ("RP", "G1 = m1 g lc1 c1 + m2 g (d2 + lc2) c1", ("l1",)),
        ("RPR", "G1 = m1 g lc1 c1 + m2 g d2 c1 + m3 g (d2 c1 + lc3 cos(θ1+θ3))", ("l1", "lc2")),
    ],
)
def test_another_zero_of_a_slide_is_named_with_the_words_that_say_so(
    robot: str, answer: str, zeros: tuple[str, ...]
):
    arm = fb.planar(robot)
    verdict = fb.check(arm, answer)
    assert not verdict
    assert " ".join(f"--parameter {name}=0" for name in zeros) + "," in verdict.causes[0]
    assert fb.check(arm, answer, parameters=dict.fromkeys(zeros, 0))


def test_h3_beside_torques_is_the_velocity_term_or_a_coefficient_and_that_is_said():
    arm, line = fb.planar("RRR"), "tau3 = H31 θ̈1 + H32 θ̈2 + H33 θ̈3 + h3 "
    right = fb.check(arm, f"{line} + G3")
    assert right
    assert "‘h3’ is read as the velocity term." in right.text
    wrong = fb.check(arm, f"{line} - G3").causes[0]
    assert wrong == (
        "‘h3’ on the right is read as the coefficient m₃ l₂ lc₃ sin θ₃; write v3 for the velocity "
        "term."
    )
    own = fb.check(arm, f"h3 = 0\n{line} + G3")
    assert not any("is read as" in x for x in own.causes)


def test_a_length_left_out_of_an_arm_that_slides_is_named():
    verdict = fb.check(fb.planar("RP"), "H11 = m1 lc1² + I1 + I2 + m2 (l1 + d2)²")
    assert "‘lc₂’ of ‘m₂ (l₁ + d₂ + lc₂)²’ is missing." in verdict.text


def test_symbols_that_the_arm_does_not_have_are_explained():
    verdict = fb.check(fb.planar("RP"), "G1 = m1 g lc1 c1 + m2 g (l1 + d2 + l2) c1")
    assert "l₂ is not a symbol of RP" in verdict.text
    verdict = fb.check(fb.planar("RP"), "G1 = m1 g lc1 c1 + m2 g (l1 + d2 + lc2) c12")
    assert [f.kind for f in verdict.findings] == ["angle"]


# ---------------------------------------------------------------- other inputs
def test_sympy_is_read():
    sympy = extra("sympy", "SymPy")
    from sympy.physics.mechanics import dynamicsymbols

    q1, q2 = dynamicsymbols("theta1 theta2")
    t = dynamicsymbols._t
    m1, m2, l1, lc1, lc2, I1, I2, g = sympy.symbols("m1 m2 l1 lc1 lc2 I1 I2 g")
    p1 = sympy.Matrix([lc1 * sympy.cos(q1), lc1 * sympy.sin(q1)])
    p2 = sympy.Matrix(
        [
            l1 * sympy.cos(q1) + lc2 * sympy.cos(q1 + q2),
            l1 * sympy.sin(q1) + lc2 * sympy.sin(q1 + q2),
        ]
    )
    w = q1.diff(t), q1.diff(t) + q2.diff(t)
    T = (
        m1 * p1.diff(t).dot(p1.diff(t))
        + m2 * p2.diff(t).dot(p2.diff(t))
        + I1 * w[0] ** 2
        + I2 * w[1] ** 2
    ) / 2
    V = g * (m1 * p1[1] + m2 * p2[1])
    tau = [(T.diff(x.diff(t))).diff(t) - (T - V).diff(x) for x in (q1, q2)]
    assert fb.check(ARM, {"T": T, "V": V, "L": T - V, "tau1": tau[0], "tau": sympy.Matrix(tau)})
    assert fb.check(ARM, sympy.Eq(sympy.Symbol("tau_2"), tau[1]))
    assert not fb.check(ARM, [sympy.Eq(sympy.Symbol("tau_2"), tau[1]), "G2 = 0"])
    printed = fb.equations(ARM).to_sympy()
    assert fb.check(ARM, {name: printed[name] for name in ("M", "C", "c", "g", "tau", "T", "V")})
    assert fb.check(ARM, r"\tau_1 = " + sympy.latex(printed["tau"][0]))


def test_names_of_ones_own():
    assert fb.check(ARM, "H22 = M2 a2^2 + J2", names={"M2": "m2", "a2": "lc2", "J2": "I2"})
    assert fb.check(ARM, "H22 = M2 a2^2 + J2", names={"M": "m", "a": "lc", "J": "I"})
    assert fb.check(ARM, "G2 = m2 g lc2 cos φ2", names={"φ2": "θ1 + θ2"})
    assert fb.check(
        ARM,
        "T2 = ½ I2 φ̇2² + ½ m2 (l1² θ̇1² + lc2² φ̇2² + 2 l1 lc2 cos(φ2 - θ1) θ̇1 φ̇2)",
        names={"φ2": "θ1+θ2"},
    )
    assert fb.check(ARM, "h = A sin θ2\nA = m2 l1 lc2\nH12 = A c2 + m2 lc2^2 + I2")


def test_one_joint_needs_no_numbers():
    arm = fb.load("pendulum")
    for answer in (
        "τ = (m lc² + I) θ̈ + m g lc cos θ",
        "tau - mglc cos(q) = (I + m*lc^2) q''",
        "V = mg lc sin θ1",
    ):
        assert fb.check(arm, answer)
    verdict = fb.check(arm, "τ + m g lc cos θ = (I + m lc²) ω̇")  # (3.3) of the notes as printed
    assert "Only the sign of gravity is wrong" in verdict.text


def test_arms_in_space_and_measured_numbers():
    rows = [{"a": "a1", "m": "m1"}, {"a": "a2", "m": "m2"}]
    arm = fb.dh(rows, convention="standard", gravity=(0.0, -9.81, 0.0))
    right = fb.equations(arm)
    assert fb.check(arm, f"H12 = {right.form(right.M[0][1])}\nJ11 = -a1 s1 - a2 s12")
    assert not fb.check(arm, f"H12 = {right.form(right.M[0][1])} + m2 a1 a2")
    scara = fb.load("scara")
    assert fb.check(scara, "G3 = -2.5 g\nH22 = 0.7335")
    assert not fb.check(scara, "H22 = 0.7435")


def test_the_zero_of_the_potential_energy_is_free():
    verdict = fb.check(fb.planar("RR"), "V = m1 g lc1 s1 + m2 g (l1 s1 + lc2 s12) + m1 g l1")
    assert verdict
    assert verdict.text == (
        "V is right. It differs by the constant m₁ g l₁: the zero level of V is arbitrary."
    )


# ---------------------------------------------------------------- what cannot be read
UNREADABLE = [
    ("", "the answer is empty"),
    ("H12", "this line has no equals sign"),
    ("H12 = ", "one side of this = is empty"),
    ("H12 = (l1", "this '(' is not closed (line 1, column 7)"),
    ("H12 = l1)", "this ')' closes no bracket (line 1, column 9)"),
    ("H12 = [l1)", "'[' is closed by ')'"),
    ("H12 = l_{c1", "this brace is not closed"),
    ("H12 = l1 ++", "the line ends where a term is expected"),
    ("G1 = 0\nH12 = m2 L1", "no symbol 'L1' in 'RR' (line 2, column 10). Did you mean 'l1'?"),
    ("H12 = m3 l1", "no symbol 'm3' in 'RR' (line 1, column 7). Did you mean 'm2'?"),
    ("G2 = m2 g lc2 cos(t1+t2)", "For a name of your own: names={'t1': 'theta1'}, --name t1="),
    ("H22 = I2 (parallel axis)", "Words that are not part of an equation go after a #."),
    ("H12 = __import__('os').system('true')", "no symbol '__import__'"),
    ("H12 = exec(chr(1))", "no symbol 'exec'"),
    ("H12 = lambda: 0", "no symbol 'lambda'"),
    ("H12 = l1 @ l2", "'@' has no meaning here"),
    ("H12 = 9**9**9", "a power of a power needs brackets"),
    ("H12 = ((9**12)**12)**12", "this number is too large"),
    ("H12 = l1**99999999999", "a power must be a whole number up to 12"),
    ("H12 = ((((l1+1)^12)^12)^12)", "more than 60 symbols are multiplied"),
    ("H12 = (l1+l2+m1+m2+g+I1+I2+lc1+lc2+theta1+theta2)^12", "too many terms"),
    ("H12 = cos(9999999 theta1)", "a multiple of an angle this large"),
    ("H12 = " + "(" * 9000 + "1" + ")" * 9000, "more than 100 brackets inside one another"),
    ("H12 = " + "cos(" * 3000 + "1" + ")" * 3000, "more than 100 brackets inside one another"),
    ("H12 = " + "\\dot{" * 3000 + "q" + "}" * 3000, "commands inside commands"),
    ("H12 = " + "a" * 19_000, "no symbol 'aaaaaaaaaaaaaaaaaaaaaaaaaaaaaa…'"),
    ("l1" * 10_001, "at most 20000 are read"),
    ("H12 = " + "9" * 80, "this number is too long"),
    ("H12 = l1/(l2 - l2)", "division by zero"),
    ("H12 = l1^l2", "a power must be a whole number"),
    ("H12 = cos(l1)", "sin and cos need a sum of angles"),
    ("H12 = cos θ1²", "write cos^2(θ1)"),
    ("H12 = lc2 2", "write lc2^2 for a power, lc2*2 for a product"),
    ("H12 = 2.0.5 m2", "the number .5 follows '2.0'"),
    ("H12 = theta1dd2", "may be theta1·dd2 or theta1d·d2: put spaces"),
    ("l1 = 2", "is a symbol of the model, not a result"),
    ("lc2 = l2/2", "uniform bars, are told by parameters="),
    ("x + y = y + x", "both sides are the same, whatever its quantities are"),
    ("H12 - H12 = 0", "both sides are the same"),
    ("2 T + 0 = T + T", "both sides are the same"),
    ("0 = 0", "both sides are the same"),
    ("θ1 = θ1", "both sides are the same"),
    ("M = l1", "M is a vector or matrix"),
    ("M = [[1, 2], [3]]", "M has 2 × 2 entries here"),
    ("A = [1, 2]\nH12 = A", "H12 is one number, not a vector or matrix"),
    ("A = 3", "A is taken for a name of your own"),
    ("tau3 = 0", "tau3 is taken for a name of your own"),
    ("A = 3\nB = 4", "A and B are taken for names of your own"),
    (42, "an answer is text, a SymPy equation or a dict"),
]


@pytest.mark.sample(17)
@pytest.mark.parametrize(("answer", "words"), UNREADABLE, ids=range(len(UNREADABLE)))
def test_what_cannot_be_read_is_refused_at_once(answer: str, words: str):
    begun = time.process_time()
    with pytest.raises(fb.AnswerError) as refused:
        fb.check(ARM, answer)
    assert time.process_time() - begun < 5.0
    assert words in str(refused.value)
    # tblib, which dask brings, has exceptions pickle their tracebacks too, link by link
    error = refused.value.with_traceback(None)
    assert str(pickle.loads(pickle.dumps(error))) == str(error)


@pytest.mark.parametrize("nothing", ["0", "(l1 - l1)"])
def test_what_is_nothing_may_have_a_power(nothing: str):
    """Repairs of a power try one lower, too: of x⁰ there is none that a value has."""
    assert not fb.check(ARM, f"tau1 = {nothing}^0")
    assert fb.check(ARM, f"H22 = {nothing}^0 (m2 lc2^2 + I2)")


def test_errors_point_at_the_place():
    with pytest.raises(fb.AnswerError) as refused:
        fb.check(ARM, "H22 = m2 lc2^2 + I2\nH12 = θ̇₁ * L1 + I2")
    assert str(refused.value).splitlines()[1:] == ["    H12 = θ̇₁ * L1 + I2", "               ^^"]


def test_long_answers_with_many_mistakes_are_judged_in_time():
    begun = time.process_time()
    wrong = " + ".join(f"{k} l1 sin(theta{1 + k % 2})^3 theta1_d" for k in range(1, 300))
    assert not fb.check(ARM, "\n".join([f"tau1 = {wrong}"] * 2 + ["H12 = l1 m2"] * 60))
    assert time.process_time() - begun < 20.0


# ---------------------------------------------------------------- the command
def test_several_equations_on_the_command_line_are_lines_of_one_answer(capsys):
    assert run(["check", "2R", "H22 = m2 lc2^2 + I2", "G2 = m2 g lc2 c12"]) == 0
    assert capsys.readouterr().out == "H22 is right.\nG2 is right.\n"
    assert run(["check", "2R", "a = m2 lc2^2", "H22 = a + I2"]) == 0
    assert run(["check", "2R", "H22 = m2 lc2^2 + I2", "G2 = m2 g lc2 s12"]) == 1
    assert run(["check", "2R", "H22 = m2 lc2^2 + I2", "more.txt"]) == 2
    assert "'more.txt' is no equation" in capsys.readouterr().err


def test_the_command_says_what_is_wrong(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    assert run(["check", "2R", f"H12 = {M12}"]) == 0
    assert capsys.readouterr().out == "H12 is right.\n"
    file = tmp_path / "answer.tex"
    file.write_text(
        "\\begin{align} H_{22} &= m_2 l_{c2}^2 + I_2 \\\\ G_2 &= m_2 g l_2 c_{12} \\end{align}"
    )
    assert run(["check", "2R", str(file)]) == 1
    said = capsys.readouterr().out
    assert said.startswith("H_{22} is right.\nG_2, the gravity term of joint 2, is not right.\n")
    assert "‘l_2’ must be lc₂" in said
    assert run(["check", "2R", "G2 = m2 g a c12", "--name", "a=lc2"]) == 0


def test_the_command_refuses_in_one_line_and_points(capsys: pytest.CaptureFixture[str]):
    assert run(["check", "2R", "H12 = m2*L1"]) == 2
    said = capsys.readouterr()
    assert said.out == ""
    first, *place = said.err.splitlines()
    assert first.startswith(
        "error: check: no symbol 'L1' in '2R' (line 1, column 10). Did you mean 'l1'?"
    )
    assert place == ["    H12 = m2*L1", "             ^^"]
    assert run(["check", "2R", "missing.txt"]) == 2
    assert "no such file" in capsys.readouterr().err
    assert run(["check", "2R", "H12 = I2", "--name", "nonsense"]) == 2
    assert "such as L1=l1" in capsys.readouterr().err


def test_a_long_line_is_cut_at_dots_around_the_mistake():
    answer = "H11 = m1*lc1^2 + I1 + m2*(l1^2 + lc2^2 + l1*lc2*cos(theta2)) + I2" + " + 0*I1" * 12
    for text in (answer, answer.replace("= ", "= " + "0*I2 + " * 12)):
        context = fb.check(ARM, text).findings[0].context
        line, carets = context.splitlines()
        assert line.startswith("    …") is (text is not answer)
        assert line.endswith("…")
        start = carets.index("^")
        assert line[start : start + carets.count("^")] == "l1*lc2*cos(theta2)"


def test_how_many_more_numbers_differ_is_said():
    """Each missing term that is added leaves one less to be told."""
    arm, answer, told = fb.load("ur5e"), "H22 = 1", []
    for _ in range(3):
        text = fb.check(arm, answer).text
        told.append(int(re.search(r"(\d+) more terms differ", text)[1]))
        answer += " + " + re.search("‘(.*)’ is missing", text)[1]
    assert told == [told[0], told[0] - 1, told[0] - 2]
    assert told[2] > 1
    # H11 of three bars has thirteen terms
    six = fb.check(fb.load("3R"), "H11 = I1").findings
    assert len(six) == 7
    assert six[-1].message == "6 more terms differ."
    most = fb.check(fb.load("3R"), "H11 = I1 + I2 + I3 + m3*lc3^2 + m3*l2^2 + m3*l1^2").findings
    assert [x.kind for x in most] == ["missing"] * 7


@pytest.mark.parametrize(
    ("told", "words"),
    [
        ({"names": 5}, "names: 5 is no dict"),
        ({"at": {"theta1": 10**400}}, "'theta1' is neither a number nor a text"),
        ({"parameters": {5: 5}}, "is no dict of names with formulas"),
    ],
)
def test_arguments_of_other_types_are_refused(told, words):
    with pytest.raises(fb.FreebodyError, match=words):
        fb.check(fb.load("2R"), "H22 = m2*lc2^2 + I2", **told)
