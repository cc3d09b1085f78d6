"""Closed forms of kinematics, determinants and their factors, and where arms are singular."""

from __future__ import annotations

import itertools
from fractions import Fraction

import numpy as np
import pytest

import freebody as fb
from freebody.expressions.closed_form_kinematics import kinematics
from support.arms import arm, skew
from support.helpers import refused

pytestmark = pytest.mark.usefixtures("numpy_kernels")

WORDS = ["".join(w) for n in (1, 2, 3) for w in itertools.product("RP", repeat=n)]


def valued(model, seed=0):
    """The model with values for all its parameters."""
    rng = np.random.default_rng(seed)
    return model.bind(**{name: float(rng.uniform(0.3, 1.2)) for name in model.missing})


# ---------------------------------------------------------------- position, Jacobian, acceleration
def test_two_links_as_in_the_notes():
    """(2.12), (2.13), (2.16), (2.19), (2.21), (2.22)."""
    arm2 = kinematics(fb.planar("RR"))
    assert str(arm2.form(arm2.position[0])) == "l₁ cos θ₁ + l₂ cos(θ₁+θ₂)"
    assert str(arm2.form(arm2.position[1])) == "l₁ sin θ₁ + l₂ sin(θ₁+θ₂)"
    assert arm2.J[0][0] == -arm2.position[1]
    assert str(arm2.form(arm2.J[1][1])) == "l₂ cos(θ₁+θ₂)"
    assert str(arm2.form(arm2.determinant((0, 1)))) == "l₁ l₂ sin θ₂"


@pytest.mark.parametrize("word", WORDS)
def test_closed_forms_are_the_kernels(word):
    """Position, rotation, J, J̇, velocity and acceleration of every planar word."""
    _agrees(valued(fb.planar(word)))


@pytest.mark.parametrize("name", ["puma560", "ur5e", "scara", "iiwa14", "gyro"])
def test_closed_forms_are_the_kernels_in_space(name):
    _agrees(fb.load(name, physical="ignore"))


def _agrees(model):
    forms = kinematics(model)
    q, qd, qdd = fb.random_state(model, 0, 5)
    T = fb.forward_kinematics(model, q)
    d = model.dim
    for mine, kernel in (
        (forms.evaluate(forms.position, q), T[:, :d, d]),
        (forms.evaluate(forms.rotation, q), T[:, :d, :d]),
        (forms.evaluate(forms.J, q), fb.jacobian(model, q)),
        (forms.evaluate(forms.J_dot, q, qd), fb.jacobian_dot(model, q, qd)),
        (forms.evaluate(forms.velocity, q, qd), fb.velocity(model, q, qd)),
        (forms.evaluate(forms.acceleration, q, qd, qdd), fb.acceleration(model, q, qd, qdd)),
    ):
        assert np.abs(mine - kernel).max() < 1e-12 * max(1.0, np.abs(kernel).max())


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ["puma560", "ur5e", "3R", "random"])
def test_determinant_of_the_whole_jacobian(name):
    """From the body where it is short, the same number as from the kernels."""
    model = (
        arm(skew("RPRRRR", np.random.default_rng(0)), 0)
        if name == "random"
        else fb.load(name, physical="ignore")
    )
    found = fb.singularities(model).closed
    q, _, _ = fb.random_state(model, 1, 20)
    determinant = np.linalg.det(fb.jacobian(model, q))
    mine = found.kinematics.evaluate(found.polynomial, q)
    assert np.abs(mine - determinant).max() < 1e-9 * np.abs(determinant).max()


def test_determinant_needs_a_square():
    refused(
        "determinant: 3 rows of the Jacobian of frame 'tip' and 2 joint coordinates make no "
        "square; choose 2 rows.",
        lambda: kinematics(fb.planar("RR")).determinant(),
    )


# ---------------------------------------------------------------- where
@pytest.mark.parametrize(
    ("word", "determinant", "where"),
    [
        ("RR", "l₁ l₂ sin θ₂", ["θ₂ = 0 or π"]),
        ("RP", "−(l₁ + d₂)", ["d₂ = −l₁"]),
        ("PR", "l₂ cos θ₂", ["θ₂ = −π/2 or π/2"]),
        ("PP", "1", []),
        ("RRR", "l₁ l₂ sin θ₂", ["θ₂ = 0 or π"]),
        ("RPR", "−(l₁ + d₂)", ["d₂ = −l₁"]),
        ("PRP", "−sin θ₂", ["θ₂ = 0 or π"]),
        ("PPR", "1", []),
    ],
)
def test_planar_words(word, determinant, where):
    """(2.20) to (2.23), and the same for other words; parameters stay symbols."""
    found = fb.singularities(fb.planar(word))
    assert str(found.determinant) == determinant
    assert [str(c) for c in found.conditions] == where
    assert found.rows == (("vx", "vy") if len(word) == 2 else ("vx", "vy", "w"))


def test_prints():
    found = fb.singularities(fb.planar("RR"))
    assert str(found) == "det J = l₁ l₂ sin θ₂\nsingular where θ₂ = 0 or π\nRows counted: vx, vy."
    assert found.latex() == (
        r"\begin{gathered} \det J = l_1 l_2 \sin \theta_2 \\ "
        r"\theta_2 = 0 \quad\text{or}\quad \theta_2 = \pi \end{gathered}"
    )
    assert [(str(f), e) for f, e in found.factors] == [("l₁", 1), ("l₂", 1), ("sin θ₂", 1)]
    never = fb.singularities(fb.planar("PP"))
    assert "singular nowhere" in str(never)
    assert repr(never) == "<Singularities of 'tip' of 'PP': nowhere>"


def test_puma():
    """Elbow, wrist, shoulder: three factors."""
    model = fb.load("puma560", physical="ignore")
    found = fb.singularities(model)
    assert [str(f) for f, _ in found.factors] == [
        "0.4318 cos θ₃ + 0.0203 sin θ₃",
        "sin θ₅",
        "0.4318 cos θ₂ + 0.0203 cos(θ₂+θ₃) − 0.4318 sin(θ₂+θ₃)",
    ]
    assert str(found.conditions[0]) == "tan θ₃ = −0.4318/0.0203"
    assert str(found.conditions[1]) == "θ₅ = 0 or π"
    assert str(found.conditions[2]).startswith("tan θ₂ = (")
    q, _, _ = fb.random_state(model, 0, 4)
    assert found.measure(q).min() > 1e-4
    for k, value in ((4, 0.0), (4, np.pi), (2, np.arctan2(-0.4318, 0.0203))):
        singular = q.copy()
        singular[:, k] = value
        assert found.measure(singular).max() < 1e-12
    s3, c3 = np.sin(q[:, 2]), np.cos(q[:, 2])
    q[:, 1] = np.arctan2(0.4318 + 0.0203 * c3 - 0.4318 * s3, 0.4318 * c3 + 0.0203 * s3)
    assert found.measure(q).max() < 1e-12


@pytest.mark.parametrize(
    ("name", "where"), [("ur5e", "θ₃ = 0 or π; θ₅ = 0 or π; tan θ₂ = "), ("scara", "θ₂ = 0 or π")]
)
def test_other_robots(name, where):
    found = fb.singularities(fb.load(name))
    assert f"singular where {where}" in str(found)


def test_symbolic_lengths_in_space():
    """An elbow arm with named lengths: wrist, elbow and shoulder, with no number in it."""
    quarter = np.pi / 2
    rows = [
        {"theta": 0, "d": "d1", "a": 0, "alpha": quarter},
        {"theta": 0, "d": 0, "a": "a2", "alpha": 0},
        {"theta": 0, "d": 0, "a": 0, "alpha": quarter},
        {"theta": 0, "d": "d4", "a": 0, "alpha": -quarter},
        {"theta": 0, "d": 0, "a": 0, "alpha": quarter},
        {"theta": 0, "d": "d6", "a": 0, "alpha": 0},
    ]
    found = fb.singularities(fb.dh(rows, convention="standard"))
    assert [str(f) for f, _ in found.factors] == [
        "a₂",
        "d₄",
        "cos θ₃",
        "sin θ₅",
        "a₂ cos θ₂ + d₄ sin(θ₂+θ₃)",
    ]
    assert found.closed.number in (Fraction(1), Fraction(-1))


def test_everywhere_and_other_rows():
    model = fb.planar("PRP")
    assert "singular everywhere" in str(fb.singularities(fb.planar("PPP"), task="pose"))
    assert fb.singularities(model, task="pose").rows == ("vx", "vy", "w")
    two = fb.singularities(fb.planar("RR"), task=("vx", "w"))
    assert str(two.determinant) == "−l₁ sin θ₁"
    refused(
        "singularities: 2 joint coordinates of 'RR' cannot move frame 'tip' along 3 rows (vx, vy, "
        "w) at any pose; "
        "count 2 at most with task=.",
        lambda: fb.singularities(fb.planar("RR"), task="pose"),
    )


@pytest.mark.parametrize("name", ["iiwa14", "2R", "ur5e"])
def test_search(name):
    """Where there is no determinant a search finds singular poses; where there is one it finds
    zeros of it."""
    model = fb.load(name)
    found = fb.singularities(model)
    poses = found.search()
    assert len(poses) > 10
    assert found.measure(poses).max() < 1e-9
    if found.closed is None:
        assert found.determinant is None
        assert found.conditions == ()
        assert (
            "7 joints and 6 rows: J is not square, so there is no determinant; search() finds "
            "singular poses." in found.notes
        )
    else:
        assert np.abs(found.closed.kinematics.evaluate(found.closed.polynomial, poses)).max() < 1e-8


def test_few_joints_and_free_ones():
    """No square, nothing to solve: measured all the same."""
    pendulum = fb.singularities(fb.load("pendulum"))
    assert pendulum.determinant is None
    assert pendulum.measure([0.3]).shape == ()
    assert pendulum.measure(np.zeros((4, 1))).shape == (4,)
    quadrotor = fb.singularities(fb.load("quadrotor", physical="ignore"))
    assert quadrotor.notes[0].startswith(
        "No closed form: joint 'flight' of 'quadrotor' is free: closed forms need "
    )
    assert quadrotor.notes[0].endswith(" search() finds singular poses.")


def test_measure_does_not_depend_on_units():
    """Lengths are taken over the arm's own."""
    q = [0.3, 0.8]
    small = valued(fb.planar("RR", l=[0.001, 0.0007]))
    large = valued(fb.planar("RR", l=[1.0, 0.7]))
    assert np.isclose(
        fb.singularities(small).measure(q), fb.singularities(large).measure(q), rtol=1e-12
    )
