"""Base parameters: no column of the regressor is missed, none is left over, and the equations are
the same."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from freebody.algorithms.regressor import regressor
from freebody_textbook.equations.base_parameters import base_parameters, by_base_parameters
from support.printed_values import evaluate
from support.symbolic import spatial_arm, with_values

pytestmark = pytest.mark.usefixtures("numpy_kernels")

WORDS = ["".join(w) for n in (1, 2, 3) for w in itertools.product("RP", repeat=n)]
MODELS = {
    **{word: fb.planar(word) for word in [*WORDS, "RRRR", "RPRP"]},
    **{f"arm{seed}": spatial_arm(seed, 1 + seed % 4) for seed in range(8)},
    "rotors": fb.planar(
        "RR", drives=[fb.Drive(rotor=fb.Parameter("J1")), fb.Drive(rotor=fb.Parameter("J2"))]
    ),
}


def rank(model: Model) -> int:
    """Rank of the regressor over many states, friction and springs left out."""
    q, qd, qdd = fb.random_state(model, seed=3, batch=80)
    rows = fb.regressor(model, q, qd, qdd).reshape(-1, len(fb.inertial_parameters(model)))
    return int(np.linalg.matrix_rank(rows, tol=1e-9 * np.linalg.norm(rows, 2)))


@pytest.mark.parametrize("name", MODELS)
def test_torques_by_base_parameters_are_the_same_polynomials(name):
    eqs = fb.equations(MODELS[name])
    s = eqs.symbols
    bases = base_parameters(s)
    rows = regressor(s.tree, s.q, s.qd, s.qdd)
    for row, tau, drive in zip(rows, eqs.tau, eqs.drives, strict=True):
        total = s.zero()
        for base in bases:
            total = total + s.element(row[base.column]) * base.value
        assert total + drive == tau


@pytest.mark.sample(12)
@pytest.mark.parametrize("name", [name for name in MODELS if name != "rotors"])
def test_there_are_no_fewer(name):
    # parameters that vanish for this model are left out: give every one a value
    model = with_values(MODELS[name])
    numeric = fb.base_parameters(model)
    assert len(numeric) == rank(model)
    assert len(base_parameters(fb.equations(MODELS[name]).symbols)) <= len(numeric)


@pytest.mark.parametrize("name", ["RR", "RPR", "arm2", "rotors"])
def test_what_is_printed_has_the_kernels_values(name):
    model = with_values(MODELS[name])
    eqs = fb.equations(model)
    q, qd, qdd = fb.random_state(model, seed=1, batch=3)
    known = eqs.symbols.values(q, qd, qdd)
    torques, *rest = eqs.groups("base")
    for line in (line for group in reversed(rest) for line in group):
        value = evaluate(line, known)
        known |= {side.name: value for side in line.sides[:-1]}
    for i, line in enumerate(torques):
        np.testing.assert_allclose(
            evaluate(line, known), fb.inverse_dynamics(model, q, qd, qdd)[..., i], rtol=1e-12
        )


def test_2r_by_base_parameters():
    eqs = fb.equations(fb.planar("RR"))
    assert eqs.text("base") == (
        "τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² − 2 h θ̇₁ θ̇₂ + G₁\n"
        "τ₂ = H₂₁ θ̈₁ + H₂₂ θ̈₂ + h θ̇₁² + G₂\n"
        "\n"
        "H₁₁ = J₁ + 2 κ₂x l₁ cos θ₂ + J₂\n"
        "H₂₂ = J₂\n"
        "H₁₂ = H₂₁ = κ₂x l₁ cos θ₂ + J₂\n"
        "\n"
        "h = κ₂x l₁ sin θ₂\n"
        "\n"
        "G₁ = κ₁x g cos θ₁ + κ₂x g cos(θ₁+θ₂)\n"
        "G₂ = κ₂x g cos(θ₁+θ₂)\n"
        "\n"
        "κ₁x = m₁ lc₁ + m₂ l₁\n"
        "J₁ = m₁ lc₁² + I₁ + m₂ l₁²\n"
        "κ₂x = m₂ lc₂\n"
        "J₂ = m₂ lc₂² + I₂"
    )
    short = by_base_parameters(eqs)
    assert short.count()["M"] < eqs.count()["M"]
    assert {"m1", "m2", "I1", "I2", "lc2"} & {
        n for x in short.tau for p, _ in x.terms() for n in p
    } == set()


def test_a_rotor_joins_the_inertia_that_it_cannot_be_told_from():
    lines = fb.equations(MODELS["rotors"]).text("base").splitlines()
    assert "BJ₁ = m₁ lc₁² + I₁ + m₂ l₁² + J₁" in lines  # J1 is the rotor's own name here
    assert any(line.endswith("= J₂") for line in lines)


@pytest.mark.parametrize(("robot", "count"), [("puma560", 36), ("ur5e", 36), ("panda", None)])
def test_real_robots_have_as_many_as_is_known(robot, count):
    # 36 of six revolute joints with a vertical first and a horizontal second axis (Khalil and
    # Dombre, 9.4)
    model = fb.load(robot, physical="ignore").without("friction", "rotors", "springs")
    found = fb.base_parameters(model)
    assert len(found) == rank(model)
    assert count in (None, len(found))
    q, qd, qdd = fb.random_state(model, seed=2, batch=5)
    tau = fb.regressor(model, q, qd, qdd)[..., list(found.columns)] @ found.values
    np.testing.assert_allclose(tau, fb.inverse_dynamics(model, q, qd, qdd), rtol=1e-8, atol=1e-8)


def test_base_parameters_in_words():
    model = fb.planar("RR", l=[1, 0.5], lc=[0.5, 0.25], m=[2, 1], I=[0.2, 0.1])
    found = fb.base_parameters(model)
    assert found.names == tuple(
        f"{body.name}.{p}" for body in model.bodies for p in ("hx", "hy", "I")
    )
    assert found.combination(found.names[2]) == {
        found.names[2]: 1.0,
        f"{model.bodies[1].name}.m": 1.0,
    }
    np.testing.assert_allclose(found.values, [2.0, 0, 1.7, 0.25, 0, 0.1625])
    assert (
        str(found).splitlines()[0]
        == f"{found.names[0]}: 2 = {found.names[0]} + {model.bodies[1].name}.m"
    )


def test_a_derivation_ends_in_base_parameters_where_only_they_are_short():
    rows = [
        {
            "alpha": alpha,
            "a": f"a{i}",
            "d": f"d{i}",
            "m": f"m{i}",
            "com": [f"c{i}{x}" for x in "xyz"],
            "I": [f"I{i}{xy}" for xy in ("xx", "xy", "xz", "yy", "yz", "zz")],
        }
        for i, alpha in enumerate((np.pi / 2, -np.pi / 2, 0.0), 1)
    ]
    model = fb.dh(rows, convention="standard", name="arm")
    assert not fb.equations(model).is_short
    steps = fb.derive(model, "lagrange").steps
    closed = next(step for step in steps if step.operation == "The closed form")
    assert "base parameters" in closed.reason
    names = {line.lhs.name for line in closed.equations}
    assert {"tau1", "H11", "J3zz", "kappa3x"} <= names
