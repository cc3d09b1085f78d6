"""Kane's method: what its steps print is what kernels compute by other ways."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.printed_values import evaluate, is_a
from support.symbolic import spatial_arm, with_values

ARMS = [fb.planar("RPR"), fb.planar("PR"), spatial_arm(5, 2), spatial_arm(8, 2)]


def equations_of(derivation: Any) -> dict[str, Any]:
    """The equations by the name of their left side, those printed first."""
    found: dict[str, Any] = {}
    for step in derivation.steps:
        for line in step.equations:
            if is_a(line.lhs, "Symbol"):
                found.setdefault(line.lhs.name, line)
    return found


@pytest.mark.parametrize("model", ARMS, ids=lambda model: model.name)
def test_partial_velocities_are_velocities_at_unit_rates(model: fb.Model):
    bound = with_values(model)
    q, qd, qdd = fb.random_state(bound, seed=4)
    known = fb.equations(bound).symbols.values(q, qd, qdd)
    printed, dim = equations_of(fb.derive(bound, "kane")), bound.dim
    checked = 0
    masses = fb.inertial_parameters(bound)
    for i, body in enumerate(bound.bodies, 1):
        # in space the components are along the body's axes
        R = np.eye(2) if dim == 2 else fb.forward_kinematics(bound, q, body.name)[:3, :3]
        moment = np.array([masses[f"{body.name}.h{x}"] for x in "xyz"[:dim]])
        centre = moment / masses[f"{body.name}.m"]
        for r, unit in enumerate(np.eye(bound.nv), 1):
            moved = fb.velocity(bound, q, unit, body.name, centre)
            turning = moved[2] if dim == 2 else moved[3:] @ R
            for name, expected in ((f"vc{i}_{r}", moved[:dim] @ R), (f"omega{i}_{r}", turning)):
                found = evaluate(printed[name], known) if name in printed else 0.0
                np.testing.assert_allclose(found, expected, atol=1e-12, err_msg=name)
                checked += name in printed
    assert checked > bound.nv


@pytest.mark.parametrize("model", ARMS, ids=lambda model: model.name)
def test_generalized_forces_are_gravity_and_inertia(model: fb.Model):
    bound = with_values(model)
    q, qd, qdd = fb.random_state(bound, seed=7)
    known = fb.equations(bound).symbols.values(q, qd, qdd)
    printed = equations_of(fb.derive(bound, "kane"))
    motors = {f"tau{r}": 0.25 * r for r in range(1, bound.nv + 1)}
    weights = fb.gravity_torque(bound, q)
    inertia = fb.inverse_dynamics(bound, q, qd, qdd) - weights
    for r in range(1, bound.nv + 1):
        active = evaluate(printed[f"F{r}"], known | motors)
        assert active == pytest.approx(0.25 * r - weights[r - 1], abs=1e-12)
        assert evaluate(printed[f"F{r}_star"], known) == pytest.approx(-inertia[r - 1], abs=1e-11)


def test_kane_of_the_pendulum():
    text = fb.derive(fb.planar("R"), "kane").text()
    for line in (
        "ω₁₁ = ∂ω₁/∂θ̇₁ = 1",
        "vc₁₁ = ∂vc₁/∂θ̇₁ = [−lc₁ sin θ₁, lc₁ cos θ₁]ᵀ",
        "F₁ = τ₁ + m₁ g · vc₁₁ = τ₁ − m₁ g lc₁ cos θ₁",
        "F₁* = −fc₁ · vc₁₁ − nc₁ ω₁₁ = −(m₁ lc₁² + I₁) θ̈₁",
        "F₁ + F₁* = 0",
        "T. R. Kane and D. A. Levinson",
    ):
        assert line in text


def test_what_joints_take_stands_in_the_generalized_forces():
    """Friction and a spring are active forces, a motor's rotor is inertia; a passive joint has no
    motor."""
    J, b, k = map(fb.Parameter, ("J1", "b1", "s1"))
    arm = fb.planar(
        "R", g=0, drives=[fb.Drive(viscous=b, rotor=J, gear=1.0, stiffness=k, rest=0.0)]
    )
    lines = {name: str(line) for name, line in equations_of(fb.derive(arm, "kane")).items()}
    assert "b₁ θ̇₁" in lines["F1"]
    assert "θ₁ s₁" in lines["F1"]
    assert "J₁" in lines["F1_star"]
    assert "J₁" not in lines["F1"]
    passive = fb.derive(fb.planar("RR").replace(actuated=["joint1"]), "kane")
    assert str(equations_of(passive)["F2"]) == "F₂ = m₂ g · vc₂₂ = −m₂ g lc₂ cos(θ₁+θ₂)"
    assert "joint 2 has no motor" in passive.text().lower().replace("\n   ", " ")
