"""Answers about bodies that nothing holds, and about the gyro: Newton's and Euler's equations in
body axes, thrusts, rates of angles."""

from __future__ import annotations

import pytest

import freebody as fb
from support.robots import Joint, Link, Robot, loaded

QUADROTOR, GYRO = fb.load("quadrotor"), fb.load("gyro")
GYROSCOPIC, WEIGHT = "The gyroscopic moment has the wrong sign", "weight has the wrong direction"
ARM, TURNED = "The thrust's arm has the wrong sign", "R is transposed"
LINES = [  # right; a piece, what is written in its place, and why that is wrong
    (r"I_x \dot{\omega}_x - (I_y - I_z) \omega_y \omega_z = M_x", "- (", "+ (", GYROSCOPIC),
    (r"I_x \dot p = (I_y - I_z) q r + l (f_2 - f_4)", "(I_y - I_z)", "(I_z - I_y)", GYROSCOPIC),
    (r"I_x \dot p = (I_y - I_z) q r + l (f_2 - f_4)", "f_2 - f_4", "f_4 - f_2", ARM),
    (r"I_x \dot p = (I_y - I_z) q r + l (f_2 - f_4)", "(I_y - I_z) q r +", "", "is missing"),
    (r"I_y \dot q = (I_z - I_x) p r + l (f_3 - f_1)", "f_3 - f_1", "f_1 - f_3", ARM),
    (r"I_z \dot r = (I_x - I_y) p q", "(I_x - I_y)", "(I_y - I_x)", GYROSCOPIC),
    (r"m \ddot z = \cos\phi\cos\theta (F_1+F_2+F_3+F_4) - m g", "- m g", "+ m g", WEIGHT),
    ("m z̈ = cφ cθ (F1 + F2 + F3 + F4) - m g", "cφ cθ ", "", "Forces are not rotated"),
    (
        r"m \ddot x = (\cos\phi\sin\theta\cos\psi + \sin\phi\sin\psi)(f_1+f_2+f_3+f_4)",
        "+ \\sin", "- \\sin", "has the wrong sign",
    ),
    ("m (u̇ + q w - r v) = m g sin θ + f_x", "q w - r v", "r v - q w", "ω × v has the wrong sign"),
    ("m (u̇ + q w - r v) = m g sin θ + f_x", " + q w - r v", "", "ω × v is missing"),
    ("m (u̇ + q w - r v) = m g sin θ + f_x", "m g sin", "-m g sin", WEIGHT),
    (r"\dot\phi = p + (q \sin\phi + r \cos\phi) \tan\theta", "p + (", "p - (", "the wrong sign"),
    ("ψ̇ = (q sin φ + r cos φ)/cos θ", "+ r", "- r", "has the wrong sign"),
    ("p = φ̇ - ψ̇ sin θ", "- ψ̇", "+ ψ̇", "has the wrong sign"),
    ("n = I ω̇ + ω × (I ω)", "+ ω", "- ω", GYROSCOPIC),
    ("ω̇ = I^{-1} (n - ω × (I ω))", "- ω", "+ ω", GYROSCOPIC),
    ("m v̇ + m ω × v = m Rᵀ g + f", "+ f", "- f", "has the wrong sign"),
    ("m p̈ = R f + m g", "R f", "Rᵀ f", TURNED),
    ("ṗ = R v", "R", "Rᵀ", TURNED),
    ("M_x = l (f2 - f4)", "f2 - f4", "f4 - f2", ARM),
    ("U1 = f1 + f2 + f3 + f4; z̈ = cφ cθ U1/m - g", "- g", "+ g", WEIGHT),
    ("T = ½ m (u² + v² + w²) + ½ (Ix p² + Iy q² + Iz r²)", "+ ½", "- ½", "is not right"),
    ("V = m g z", "m g z", "-m g z", "is not right"),
    ("5 ω̇_x + 5 ω_y ω_z = n_x", "+ 5", "- 5", "is not right"),
]  # fmt: skip


@pytest.mark.sample(1)
@pytest.mark.parametrize(("line", "piece", "other", "reason"), LINES)
def test_lines_about_a_quadrotor(line: str, piece: str, other: str, reason: str):
    assert fb.check(QUADROTOR, line), line
    assert piece in line
    verdict = fb.check(QUADROTOR, line.replace(piece, other, 1))
    assert not verdict
    assert reason in verdict.text


@pytest.mark.sample(1)
@pytest.mark.parametrize("line", ["φ̈ = l (f2 - f4)/I_x", "θ̈ = l (f3 - f1)/I_y"])
def test_what_holds_near_hover_only_is_told_so(line: str):
    verdict = fb.check(QUADROTOR, line)
    assert not verdict
    assert "right near hover only" in verdict.causes[0]


def off_centre():
    """A free body in symbols whose centre of mass is aside."""
    inertia = fb.Inertia.of("m", ["a", 0, "c"], ["Ixx", 0, "Ixz", "Iyy", 0, "Izz"])
    links, joint = (Link("base"), Link("body", inertia)), Joint("flight", "free", "base", "body")
    made = Robot("body", 3, links, (joint,), (9.81, (0.0, 0.0, -1.0)))
    return loaded(made)


@pytest.mark.sample(1)
@pytest.mark.parametrize("model", [QUADROTOR, off_centre()], ids=["quadrotor", "off_centre"])
def test_a_derivation_is_an_answer(model):
    """The equations of motion and of the angles' rates as `fb.derive` prints them, and each with
    another sign."""
    steps = fb.derive(model).steps
    chosen = [s for s in steps if s.operation.startswith(("The equations of", "Rates of the"))]
    printed = [line for step in chosen for line in step.equations if hasattr(line.lhs, "name")]
    assert len(printed) == 12
    verdict = fb.check(model, "\n".join(map(str, printed)))
    assert verdict, verdict
    assert len(verdict.equations) == 12
    verdict = fb.check(model, "\n".join(f"{line.lhs} = -({line.rhs})" for line in printed))
    assert [x.equal for x in verdict.equations] == [False] * 12, verdict


GYRO_LINES = [
    (r"I_x \dot\omega_x - (I_y - I_z) \omega_y \omega_z = M_x", "- (", "+ ("),
    (r"I_y \dot\omega_y - (I_z - I_x) \omega_x \omega_z = M_y", "- (", "+ ("),
    ("M_z = I_z ω̇_z - (I_x - I_y) ω_x ω_y", "- (", "+ ("),
    ("n_12 = I_2 ω̇_2 + ω_2 × (I_2 ω_2)", "+ ω", "- ω"),
    ("ω_y = θ̇1 sin θ2", "= θ̇1", "= -θ̇1"),
    ("n12y = 5 θ̈1 sin θ2 + 10 θ̇1 θ̇2 cos θ2", "+ 10", "- 10"),
    ("τ2 = I_x θ̈2 - (I_y - I_z) sin θ2 cos θ2 θ̇1²", "- (", "+ ("),
]


@pytest.mark.parametrize(("line", "piece", "other"), GYRO_LINES)
def test_lines_about_a_gyro(line: str, piece: str, other: str):
    assert fb.check(GYRO, line), line
    verdict = fb.check(GYRO, line.replace(piece, other, 1))
    assert not verdict
    assert "sign" in verdict.text


def test_the_gyroscopic_moment_of_a_gyro_is_named():
    assert GYROSCOPIC in fb.check(GYRO, "M_y = I_y ω̇_y - (I_x - I_z) ω_x ω_z").causes[0]
    assert "gyroscopic moment is missing" in fb.check(GYRO, "M_y = I_y ω̇_y").causes[0]


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ("Ix = 5", "is a symbol of the model"),
        ("H11 = 3", "is taken for a name of your own"),
        ("ω̇_x = ω̇_x + p - p", "stands on both sides"),
        ("I_x ṗ = c (f2 - f4)", "no symbol 'c'"),
    ],
)
def test_what_is_not_about_the_body_is_refused(line: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(QUADROTOR, line)
