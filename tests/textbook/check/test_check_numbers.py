"""Answers that are numbers: with units, at a state that the answer or the caller says, right to the
digits given; and what has gone wrong where they are not. The right numbers are those of the
compiled dynamics."""

from __future__ import annotations

import math
import random
from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import run

ARM = fb.planar("RR", l=[0.4, 0.3], lc=[0.2, 0.15], m=[2.0, 1.5], I=[0.031, 0.012])
Q, QD, QDD = np.radians([30.0, 45.0]), np.array([2.0, -1.0]), np.array([0.5, 1.0])
TAU = fb.inverse_dynamics(ARM, Q, QD, QDD)
MASS = fb.mass_matrix(ARM, Q)
POSTURE = "θ₁ = 30°, θ₂ = 45°"
STATE = f"{POSTURE}, θ̇₁ = 2 rad/s, θ̇₂ = -1 rad/s, θ̈₁ = 0.5 rad/s², θ̈₂ = 1 rad/s²"
AT = {"theta1": "30 deg", "theta2": math.pi / 4, "theta1_d": 2, "dtheta2": -1, "θ̈₁": 0.5, "θ̈2": 1}
WEIGHT = 1.5 * 9.81 * 0.15
G2 = WEIGHT * math.cos(math.radians(75))


# ---------------------------------------------------------------- units
VALUES = {
    "tau1": TAU[0],
    "H22": MASS[1, 1],
    "omega2": QD.sum(),
    "x": fb.forward_kinematics(ARM, Q)[0, 2],
    "ẍ": fb.acceleration(ARM, Q, QD, QDD)[0],
    "f01x": fb.joint_wrenches(ARM, Q, QD, QDD)[0, 0],
}


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("name", "text", "factor"),
    [
        ("tau1", "N m", 1), ("tau1", "Nm", 1), ("tau1", "N·mm", 1e-3),
        ("tau1", f"kNm at {STATE}", 1e3), ("tau1", r"\,\mathrm{N\,m}$", 1),
        ("tau1", r"\newton\metre", 1), ("H22", "[kg m²]", 1), ("H22", "kg m^{2}", 1),
        ("H22", "g mm^2", 1e-9), ("omega2", "°/s", math.pi / 180),
        ("omega2", "rpm", math.pi / 30), ("omega2", "rad s^{-1}", 1), ("ẍ", "m/s²", 1),
        ("tau1", "J", 1), ("x", "cm", 1e-2), ("tau1", "Newton-metres", 1), ("tau1", "N-m", 1),
        ("H22", "kg m2", 1), ("ẍ", r"\metre\per\second\squared", 1), ("f01x", "N. The", 1),
    ],
)  # fmt: skip
def test_units_are_read(name: str, text: str, factor: float):
    at = None if STATE in text else AT
    right = VALUES[name] / factor
    assert fb.check(ARM, f"{name} = {right:.9g} {text}", at=at)
    for wrong in (1.001 * right, 1e3 * right, right / 1e3):
        assert not fb.check(ARM, f"{name} = {wrong:.9g} {text}", at=at)


@pytest.mark.parametrize("text", ["N/(m s)", "kg m2"])
def test_units_of_another_quantity_are_told(text: str):
    verdict = fb.check(ARM, f"tau1 = {TAU[0]:.9g} {text}", at=AT)
    assert not verdict
    assert "unit" in verdict.text


@pytest.mark.sample(4)
@pytest.mark.parametrize("text", ["m2 g", "m₂ g", "m_2", "Newtonian", "s1", " and", "{N", "(N m"])
def test_names_and_words_are_no_units(text: str):
    assert fb.check(ARM, f"tau1 = {TAU[0]:.9g}", at=AT)
    with pytest.raises(fb.AnswerError):
        fb.check(ARM, f"tau1 = {TAU[0]:.9g} {text}", at=AT)


# ---------------------------------------------------------------- right
RIGHT = [
    (f"τ₁ = {TAU[0]:.2f} Nm at {STATE}", "text"),
    (f"τ₁ = {TAU[0] * 1000:.0f} N mm for {STATE}", "text"),
    (f"tau = [{TAU[0]:.3f}; {TAU[1]:.3f}] N m with {STATE}", "text"),
    (f"At {STATE}:\ntau_1 = {TAU[0]:.4f}\ntau_2 = {TAU[1]:.4f} Nm", "text"),
    (f"G2 ≈ {G2:.2f} N m (θ1 = π/6, θ2 = 0.25π)", "text"),
    (f"G2 = m2 g lc2 c12 = 1.5*9.81*0.15*cos(75°) = {G2:.3f} N m at {POSTURE}", "text"),
    (f"G2 = m2 g lc2 cos 75° = {G2 * 100:.1f}·10^{{-2}} N-m at {POSTURE} at rest", "text"),
    ("At θ2 = 45° and at rest:\nH12 = m2 (lc2² + l1 lc2 cos(pi/4)) + I2\nv_2 = 0", "text"),
    ("H12 = m2 (lc2² + l1 lc2/√2) + I2 at θ2 = 45°".replace("/√2", " sin 45°"), "text"),
    (f"G2 = {G2 + 0.04:.2f} ± 0.05 N m, {POSTURE}", "text"),
    (f"M = [{MASS[0, 0]:.3f}, {MASS[0, 1]:.3f}; {MASS[1, 0]:.3f}, 0.046] kg m², θ2 = 45°", "text"),
    (f"detJ = 0 at θ2 = 180°\nx = 0 m at θ1 = 90°, θ2 = 0\nG2 = 0.571 N m at {POSTURE}", "text"),
    (f"G = [9.067 N m; 0.571 (N m)] at {POSTURE}", "text"),
    ("H22 = 45750 kg mm^2", "text"),
    ("ω₂ = 1.00 rad/s, x = 0.7 m at θ₁ = θ₂ = 0, θ̇₁ = 120 °/s, θ̇₂ = -62.704 °/s", "text"),
    ("Now θ2 = 45°, q̇ = 0. Then T = 0 J, H12 = 0.10939 kg m².", "text"),
    ("Given q = 0, q̇ = 0 and q̈ = 0.\nT = 0 J; G2 = 2.207 N m", "text"),
    (rf"$\tau_1 = {TAU[0]:.2f}\,\mathrm{{N\,m}}$ at ${STATE}$.".replace("°", r"^\circ"), "latex"),
    (rf"\[ G_2 = \SI{{{G2:.3f}}}{{\newton\metre}} \] for $\theta_1 = \ang{{30}}$, $\theta_2 = "
     r"\frac{\pi}{4}$", "latex"),
    (f"**Given:** ${STATE.replace(', ', '$, $')}$.\n\n1. It is $\\tau_1 = {TAU[0]:.2f}$ N m.\n"
     f"2. $\\tau_2 = {TAU[1]:.3f}\\,\\text{{Nm}}$", "markdown"),
    ("Given: m1 = 2 kg, l1 = 400 mm, I1 = 0.031 kg m2\na) H22 = 0.0458 kg m²\n"
     "b) at θ2 = 45°: H12 = 0.10939 kgm²\nc) At θ1 = 45°, θ2 = 45°: G2 = 0 Nm", "text"),
    (f"With ${POSTURE.replace(', ', '$ and $')}$ the torque is $G_2 = {G2:.3f}$ N m.\n\nNow "
     "$θ_1 = θ_2 = 0$: $G_2 = 2.21~\\text{N m}$.", "markdown"),
]  # fmt: skip


@pytest.mark.sample(5)
@pytest.mark.parametrize(("answer", "form"), RIGHT)
def test_right_numbers_are_right_and_changed_ones_are_not(answer: str, form: str):
    verdict = fb.check(ARM, answer, form=form)
    assert verdict, verdict
    assert not verdict.unread
    wrong = answer.replace("45°", "46°").replace("0.25π", "0.26π").replace("45^", "46^")
    wrong = wrong.replace("{4}", "{5}").replace("45750", "45850").replace("120", "121")
    assert not fb.check(ARM, wrong.replace("2.207", "2.208"), form=form)


@pytest.mark.parametrize("at", [AT, STATE, STATE.replace("°", " deg")])
def test_the_state_may_be_given_besides(at: str | dict[str, float | str]):
    verdict = fb.check(ARM, {"tau1": TAU[0], "tau2": float(f"{TAU[1]:.3f}")}, at=at)
    assert verdict, verdict
    assert "with the values of 'RR'" in verdict.equations[0].note
    assert not fb.check(ARM, {"tau1": TAU[0] * 1.0001}, at=at)
    assert fb.check(ARM, {"tau1": TAU[0] * 1.0001}, at=at, tolerance=0.001)


def test_parameters_without_value_may_be_given():
    answer = f"G2 = {G2:.3f} N m at {POSTURE}, m2 = 1500 g, lc2 = 15 cm, g = 9.81 m/s²"
    assert fb.check(fb.planar("RR", g="g"), answer)


def test_what_does_not_count_at_a_state_is_not_asked_for():
    assert fb.check(ARM, "c2 = 0 N m at rest\nC11 = 0 at rest")
    assert fb.check(ARM, f"T = {0.5 * MASS[1, 1]:.6f} J at θ̇1 = 0, θ̇2 = 1 rad/s")


def test_absolute_angles_are_those_of_the_state():
    verdict = fb.check(ARM, f"V = {0.0:.3f} J at θ1 = 0, θ2 = 0", absolute=True)
    assert verdict
    tip = 0.4 * math.cos(0.5) + 0.3 * math.cos(0.9)
    assert fb.check(ARM, f"x = {tip:.4f} m", absolute=True, at={"theta1": 0.5, "theta2": 0.9})


def test_one_digit_gives_no_reason_away():
    """1 N m was half of 1.688 N m, and right for θ₃ = 0."""
    state = {f"theta{k}": f"{x} deg" for k, x in enumerate((30, 45, -20), 1)}
    for answer in ("G3 = 1 N m", "G1 = 1 N m"):
        assert fb.check(fb.load("3R"), answer, at=state).causes == ()
    (cause,) = fb.check(fb.load("3R"), "G3 = 0.84 N m", at=state).causes
    assert cause == "It is half the right number."
    (cause,) = fb.check(fb.load("3R"), "G3 = 0.065 N m", at=state).causes
    assert cause.startswith("Degrees were taken for radians: θ₁, θ₂ and θ₃ must")


def test_a_number_in_siunitx_is_quoted_whole():
    verdict = fb.check(ARM, r"G2 = \SI{2.11}{\newton\metre} at $\theta_1 = 1, \theta_2 = 1$")
    assert r"‘\SI{2.11}{\newton\metre}’ must be" in verdict.text


# ---------------------------------------------------------------- wrong
def weight(degrees: float) -> float:
    return WEIGHT * math.cos(math.radians(degrees))


WRONG = [
    (f"τ₁ = {TAU[0]:.2f} N at {STATE}", "The units do not fit: N, where N m is needed. In N m"),
    (f"τ₁ = {TAU[0] * 1000:.0f} N m at {STATE}", "The number would be right in N mm."),
    ("x = 700 m at θ1 = θ2 = 0", "The number would be right in mm."),
    ("H22 = 0.0 kg m²", "must be 0.04575 kg m²"),
    (f"H22 = {MASS[1, 1]:.4f} kg m", "The units do not fit: kg m, where kg m² is needed."),
    (f"G2 = {WEIGHT * math.cos(75):.3f} N m at {POSTURE}", "Degrees were taken for radians: θ₁"),
    (f"G2 = {weight(1.3):.4f} N m at θ1 = 0.5, θ2 = 0.8", "Radians were taken for degrees"),
    ("ω₂ = 90 rad/s at θ̇1 = 60 °/s, θ̇2 = 30 °/s", "must be put in as rad/s, not as °/s"),
    ("ω₂ = 90 rad/s at θ̇1 = 60 rpm, θ̇2 = 30 rpm", "must be put in as rad/s, not as rpm"),
    (f"G2 = {-G2:.3f} N m at {POSTURE}", "Only the sign is wrong."),
    (f"G2 = {G2 / 9.81 * 10:.4f} N m at {POSTURE}", "It is right for g = 10 m/s²; here it is 9.81"),
    (f"G2 = {2 * G2:.3f} N m at {POSTURE}", "A possible reason: You wrote l₂ for lc₂"),
    (f"G2 = {weight(45):.3f} N m at {POSTURE}", "measured from the previous link"),
    (f"τ₁ = {TAU[1]:.3f} Nm at {STATE}", "A possible reason: What you wrote is right for τ2"),
    (f"τ₁ = {TAU[0] * 1.003:.3f} Nm at {STATE}", "It is off by 0.3 %: numbers may have been"),
    ("T = 0.7 J at θ̇1 = 1, θ̇2 = 0, θ2 = 0", "must be 0.2884 J at θ̇₁ = 1, θ̇₂ = 0, θ₂ = 0"),
]  # fmt: skip


@pytest.mark.parametrize(("answer", "words"), WRONG)
def test_what_went_wrong_is_said(answer: str, words: str):
    verdict = fb.check(ARM, answer)
    assert not verdict
    assert words in verdict.text, verdict.text
    assert verdict.findings[0].kind == ("unit" if "units" in words else "number")


def test_the_verdict_on_a_number_reads_like_this():
    assert fb.check(ARM, f"G2 = 2.035 N m at {POSTURE}").text == (
        "G2, the gravity term of joint 2, is not right.\n"
        "  Degrees were taken for radians: θ₁ and θ₂ must be put in as radians.\n"
        "  ‘2.035 N m’ must be 0.57128 N m at θ₁ = 30°, θ₂ = 45°, with the values of 'RR'.\n"
        "      G2 = 2.035 N m at θ₁ = 30°, θ₂ = 45°\n"
        "           ^^^^^^^^^"
    )


# ---------------------------------------------------------------- refused
@pytest.mark.parametrize(
    ("answer", "at", "words"),
    [
        ("G2 = 0.57", None, "G2 is a number here, but depends on θ₁, θ₂, which are not given"),
        ("G1 = 54, G2 = 3.047 N m at θ1 = 30°, θ2 = 45°", None, "G1 is a number here, but depends"),
        ("G2 = 0.57 N m", None, "G2 is a number here, but depends on θ₁, θ₂, which are not given"),
        (
            f"τ₁ = 3.3 N m at {POSTURE}",
            None,
            "θ̈₂, which are not given .of an arm that is held still",
        ),
        ("G2 = 0.57 N m at θ₁ = 30 mm, θ₂ = 0", None, "θ₁ is given in mm, and has the unit rad"),
        ("G2 = 0.57 N m at θ₁ = 0, θ₂ = 0, m2 = 3 kg", None, "m₂ is 3 here, and 1.5 in 'RR'"),
        ("G2 = 0,57 N m at θ₁ = 30°, θ₂ = 45°", None, "a decimal comma: write a point"),
        ("J^{-1} = [1, 2; 3, 4] at θ1 = 30°, θ2 = 0", None, "has no value at θ₁ = 30°, θ₂ = 0"),
        ("G2 = m2 g lc2 (c12) kN", None, "follows what is not a number"),
        ("G2 = 0.57 N m at θ1 = 0,5, θ2 = 0", None, "a decimal comma: write a point"),
        ("G2 = m2 g lc2 cos(θ1+θ2)\nr2 = 200 mm", None, "follows what is not a result"),
        ("H22 = m2 lc2^2 + I2", {"theta1": 0.2}, "at: a state is given, but none of the results"),
        ("G2 = 0.57", {"theta9": 1}, "at: 'theta9' gives no symbol of 'RR' a value"),
        ("G2 = 0.57", "theta1 = 1, theta1 = 2", "θ₁ is given twice, 1 and 2"),
        ("G2 = 0.57", {"theta1": [1, 2]}, "at: 'theta1' is neither a number"),
        ("At θ1 = 30°: G2 = 1 N m", {"theta1": 1}, "at: θ₁ = 1, but the answer says θ₁ = 30°"),
        ("G2 = 0.57", {"m2": 3}, "at: m2 = 3, and in 'RR' it is 1.5"),
        ("G2 = 0.57", {"m2": -1.5}, "m₂ is negative; a mass is never negative"),
    ],
)
def test_numbers_without_all_that_they_need_are_refused(
    answer: str, at: dict[str, float] | str | None, words: str
):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(ARM, answer, at=at)


STATE = "θ1 = 30°, θ2 = 45°"


@pytest.mark.sample(6)
@pytest.mark.parametrize(
    "answer",
    [
        *(f"G2 = 3.047 N m at {state}" for state in (
            "q = [30, 45]°", "q = (30°, 45°)", "q = (0.5236, 0.7854) rad", "q = [30 45]^T deg",
            "θ = [π/6; π/4]", "(θ1, θ2) = (30°, 45°)", "[θ1, θ2]^T = [30, 45]^T °",
            r"q = \begin{bmatrix} 30^\circ \\ 45^\circ \end{bmatrix}",
            r"\mathbf{q} = \left[\frac{\pi}{6}, \frac{\pi}{4}\right]^T",
        )),
        *(f"{left} = 3.047 at {STATE}" for left in (
            "G2 [N m]", "G2 (Nm)", "G2 / N m", "G2 in Nm", r"G_2\,[\mathrm{N\,m}]", "2/2 G2",
        )),
        f"G2 [N mm] = 3047 at {STATE}",
        "G2 [N m] = m2 g lc2 c12\nH22 [kg m²] = m2 lc2² + I2",
        f"2 G2 = 6.094 N m at {STATE}",
        *(f"H22 = 0.64 {unit}" for unit in ("kgm2", "kg·m²", "kgm^2", "kg.m²")),
    ],
)  # fmt: skip
def test_units_and_states_are_written_in_many_ways(answer: str):
    arm = fb.load("2R")
    assert fb.check(arm, answer), answer
    for old, new in (("3.047", "3.147"), ("3047", "3147"), ("6.094", "6.194"), ("0.64", "0.74")):
        if old in answer:
            assert not fb.check(arm, answer.replace(old, new))
    if "at q" in answer:
        with pytest.raises(fb.AnswerError, match="3 values for 2 symbols"):
            fb.check(arm, "G2 = 3 N m at q = [30, 45, 20]°")


def test_the_unit_in_front_counts():
    arm = fb.load("2R")
    assert "would be right in N m" in fb.check(arm, f"G2 [kN m] = 3.047 at {STATE}").text
    assert "The units do not fit: kg, where" in fb.check(arm, f"G2 [kg] = 3.047 at {STATE}").text
    with pytest.raises(fb.AnswerError):
        fb.check(arm, "G2 [kN m] = m2 g lc2 c12")


def test_accelerations_of_a_free_body_may_be_numbers():
    body = fb.load("quadrotor")
    at = "q = 0, r = 0, f_2 = 0, f_4 = 1 N"
    for answer in (r"\dot p = -0.1 rad/s^2", "ṗ = -0.1"):
        assert fb.check(body, answer, at=at)
        assert not fb.check(body, answer.replace("0.1", "0.2"), at=at)
        assert fb.check(body, f"{answer} at {at}")


def test_a_tolerance_is_a_share():
    with pytest.raises(
        fb.AnswerError, match=r"tolerance is a share from 0 to 1, such as 0\.01, not 5"
    ):
        fb.check(ARM, "H22 = 0.05", tolerance=5)


def test_in_a_document_what_cannot_be_judged_is_told():
    text = "$H_{22} = 0.04575$ kg m²\n\n$G_2 = 0.57$ N m\n\nThe arm has $r = 3$ mm."
    verdict = fb.check(ARM, text, form="markdown")
    assert not verdict
    assert [x.equal for x in verdict.equations] == [True]
    assert "depends on θ₁, θ₂" in verdict.text
    assert any("follows what is not a result" in x.reason for x in verdict.left_out)


def test_letters_of_a_pendulum_are_units_only_where_they_fit():
    """m is its mass and the metre, g the gravitational acceleration and the gram."""
    one = fb.planar("R", l=[0.4], lc=[0.2], m=[2.0], I=[0.03])
    assert fb.check(one, "x = 0.2 m at θ = 60°")
    assert fb.check(one, "H = 0.11 kg m²\nG = m g lc cos θ")
    assert "3 m₁" in fb.check(one, "V = 3 m").text


# ---------------------------------------------------------------- the command
def test_the_command_takes_the_state(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    exact = float(fb.gravity_torque(fb.load("2R"), np.radians([30, 45]))[1])
    state = ["--at", "theta1 = 30 deg, theta2 = 45 deg"]
    assert run(["check", "2R", f"G2 = {exact:.3f} N m", *state]) == 0
    assert "At θ₁ = 30°, θ₂ = 45°, with the values of '2R'" in capsys.readouterr().out
    file = tmp_path / "answer.txt"
    file.write_text(f"G2 = {exact * 1.01:.4f} N m\n", encoding="utf-8")
    assert run(["check", "2R", str(file), "--at", "theta1 = 30°", "--at", "theta2 = 45°"]) == 1
    assert run(["check", "2R", str(file), *state, "--tolerance", "0.02"]) == 0
    capsys.readouterr()
    assert run(["check", "2R", str(file)]) == 2
    assert "depends on θ₁, θ₂, which are not given" in capsys.readouterr().err


# ---------------------------------------------------------------- from a seed
WHERE = (" at {}", " ({})", ", with {}", " where {}", " when the arm is at {}", " (state: {})")
WORDS = ("R", "RR", "RP", "PR", "RRR")


def random_answer(rng: random.Random) -> tuple[fb.Model, str, str, float, float]:
    """An arm, a result with its state, and the exact value with the unit in which it is written."""
    word = rng.choice(WORDS)
    n = len(word)
    numbers = {k: [round(rng.uniform(0.2, 2.0), 2) for _ in word] for k in ("l", "lc", "m", "I")}
    arm = fb.planar(word, **numbers)
    state, written = [], []
    for dots, mark in enumerate(("", "\u0307", "\u0308")):
        values = []
        for i, kind in enumerate(word, 1):
            degrees = kind == "R" and rng.random() < 0.5
            unit = ("°" if degrees else "rad" if kind == "R" else "cm") + ("", "/s", "/s²")[dots]
            value = rng.randrange(-90, 90) if degrees else round(rng.uniform(-2, 2), 1)
            values.append(value * (math.pi / 180 if degrees else 1 if kind == "R" else 0.01))
            written.append(f"{'θ' if kind == 'R' else 'd'}{mark}{i} = {value} {unit}")
        state.append(values)
    i, j = rng.randrange(n), rng.randrange(n)
    q, qd, qdd = state
    turns = word[i] == "R"
    name, exact, units = rng.choice([
        (f"tau_{i + 1}", fb.inverse_dynamics(arm, q, qd, qdd)[i], FORCES[turns]),
        (f"G_{i + 1}", fb.gravity_torque(arm, q)[i], FORCES[turns]),
        (f"H_{i + 1}{j + 1}", fb.mass_matrix(arm, q)[i, j], {"": 1.0}),
        ("T", fb.kinetic_energy(arm, q, qd), {"J": 1.0, "kJ": 1e3, "N m": 1.0}),
        ("x", fb.forward_kinematics(arm, q)[0, -1], {"m": 1.0, "mm": 1e-3, "centimetres": 1e-2}),
    ])  # fmt: skip
    unit, factor = rng.choice(list(units.items()))
    rng.shuffle(written)
    where = rng.choice(WHERE).format(", ".join(written))
    return (
        arm,
        f"{name} = {{}} {unit}{where}",
        name,
        float(exact),
        factor,
    )


FORCES = ({"N": 1.0, "kN": 1e3}, {"Nm": 1.0, "N·mm": 1e-3, "kN m": 1e3, "N m": 1.0})


def rounded(value: float, digits: int) -> str:
    """Without an exponent, to so many significant digits."""
    size = math.floor(math.log10(abs(value))) if value else 0
    return f"{value:.{max(digits - 1 - size, 1)}f}"


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@pytest.mark.parametrize("seed", range(40))
def test_random_results_are_right_and_planted_errors_are_found(seed: int):
    rng = random.Random(f"numbers {seed}")
    arm, answer, name, exact, factor = random_answer(rng)
    verdict = fb.check(arm, answer.format(rounded(exact / factor, rng.choice((4, 5, 6)))))
    assert verdict, verdict
    if abs(exact) > 1e-6:
        for wrong in (exact * 1.03, -exact, exact * 1000):
            verdict = fb.check(arm, answer.format(rounded(wrong / factor, 5)))
            assert not verdict, verdict
        assert verdict.findings[0].kind == "number", name


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "state",
    ["cos θ2 = 0", r"\cos θ_2 = 0", "sin θ2 = 0", "tan θ2 = 0", "C θ2 = 0"],
)
def test_the_cosine_of_an_angle_is_not_the_angle(state: str):
    right = "H12 = m2 lc2^2 + m2 l1 lc2 + I2"
    assert fb.check(fb.load("2R"), f"{right} at the stretched pose θ2 = 0")
    with pytest.raises(fb.AnswerError):
        fb.check(fb.load("2R"), f"{right} at all but not θ2 = 0")
    with pytest.raises(fb.AnswerError):
        fb.check(fb.load("2R"), f"{right} at cot θ2 = 0")
    for answer in (f"{right} at {state}", f"At {state}: {right}", f"{state}\n{right}"):
        with suppress(fb.AnswerError):  # C θ2 = 0 may be an equation, which is wrong
            assert not fb.check(fb.load("2R"), answer, names={"C": "cos"})


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("G2 = 10.33 J at θ1 = 0.1, θ2 = 0.1", "‘10.33 J’ must be 11.537 N m at"),
        ("V = 3 N m at θ1 = 0.3, θ2 = 0.2", "‘3 N m’ must be 23.04 J at"),
        ("G2 = 1030 N cm at θ1 = 0.3, θ2 = 0.2", "‘1030 N cm’ must be 1033.1 N cm at"),
        ("V = 3 kJ at θ1 = 0.3, θ2 = 0.2", "‘3 kJ’ must be 0.02304 kJ at"),
    ],
)
def test_a_moment_is_told_in_newton_metres_and_an_energy_in_joules(answer, words):
    assert words in str(fb.check(fb.load("2R"), answer))


@pytest.mark.parametrize(
    "answer",
    [
        "G2 = 500 + 1.0e6 - 1.0e6 N m at θ1 = 0, θ2 = 0",
        "H22 = 90 ± 100 kg m²",
        "τ2 = 0 ± 1000 N m at θ1 = 0, θ2 = 0, q̇ = 0, q̈ = 0",
    ],
)
def test_digits_and_tolerances_that_leave_everything_open_tell_nothing(answer):
    with pytest.raises(fb.AnswerError, match="is larger than the right number"):
        fb.check(fb.load("2R"), answer)


def test_digits_that_leave_more_open_than_a_term_has_do_not_make_it_right():
    two = fb.load("2R")
    assert not fb.check(two, "G2 = (500 + 1.0e6 - 1.0e6) cos(θ1+θ2)")
    assert not fb.check(two, "G2 = 11.772 cos(θ1+θ2) + (5 + 1.0e6 - 1.0e6) sin θ1")
    assert fb.check(two, "G2 = (11.8 + 1.0 - 1.0) cos(θ1+θ2)")
    assert fb.check(two, "H22 = 0.6")
    assert fb.check(two, "τ2 = 0 ± 0.01 N m at θ1 = 90°, θ2 = 0, q̇ = 0, q̈ = 0")


def test_the_level_of_an_energy_is_free_in_numbers_too():
    two, scara = fb.load("2R"), fb.load("scara")
    right = "V = 58.86 s1 + 11.77 s12"
    for level in ("", " + 5", " - 3.25"):
        assert fb.check(two, right + level)
    assert "the zero level of V is arbitrary" in fb.check(two, right + " + 5").text
    for wrong in (" + 5 s1", " + 5 θ1", " + 0.1 θ̇1", " + l1", " + m1 g"):
        assert not fb.check(two, right + wrong)
    assert not fb.check(two, "G1 = 58.86 c1 + 11.77 c12 + 5")
    for level in ("", " + 3", " + 20 g"):
        assert fb.check(scara, f"V = -2.5 g d3{level}")
    for wrong in ("V = -2.4 g d3", "V = -2.5 g d3 + 3 θ1", "V = 2.5 g d3"):
        assert not fb.check(scara, wrong)
