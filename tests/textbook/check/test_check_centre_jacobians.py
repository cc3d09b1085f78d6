"""Jacobians of the bodies' centres of mass and angular velocities, and Asada's names of vectors."""

from __future__ import annotations

import pytest

import freebody as fb

MASS = "m1 J_{v1}^T J_{v1} + m2 J_{v2}^T J_{v2} + I1 J_{ω1}^T J_{ω1}"
EULER = "N_{0,1} - N_{1,2} + r_{1,c1} × f_{1,2} - r_{0,c1} × f_{0,1} = I1 ω̇1"
EVERY_BODY = "M = Σ m_i J_{vi}^T J_{vi} + J_{ωi}^T"

RIGHT = [
    ("2R", "J_{c1} = [-lc1 s1, 0; lc1 c1, 0]"),
    ("2R", "J_{v2} = [-l1 s1 - lc2 s12, -lc2 s12; l1 c1 + lc2 c12, lc2 c12]"),
    ("2R", "J_{v1} = [-lc1 s1, 0; lc1 c1, 0; 0, 0]"),
    ("2R", "J_{ω2} = [1, 1]"),
    ("2R", "J_{ω2} = [0, 0; 0, 0; 1, 1]"),
    ("2R", "J_{c1}^T J_{c1} = [lc1^2, 0; 0, 0]"),
    ("2R", f"M = {MASS} + I2 J_{{ω2}}^T J_{{ω2}}"),
    ("2R", f"{EVERY_BODY} I_i J_{{ωi}}"),
    ("2R", r"M(q) = \sum_{i=1}^{2} \left(m_i J_{v_i}^T J_{v_i}"
           r" + J_{\omega_i}^T I_i J_{\omega_i}\right)"),
    ("2R", "T = ½ q̇^T (Σ m_i J_{vi}^T J_{vi} + J_{ωi}^T I_i J_{ωi}) q̇"),
    ("2R", "vc2 = J_{v2} q̇"),
    ("2R", "G = -Σ J_{vi}^T m_i g"),
    ("2R", "G = m1 g J_{v1}^T [0; 1] + m2 g J_{v2}^T [0; 1]"),
    ("2R", "r_{0,c1} = [lc1 c1; lc1 s1]"),
    ("2R", "r_{0,1} = [l1 c1; l1 s1]"),
    ("2R", "r_{1,c1} = [(lc1-l1) c1; (lc1-l1) s1]"),
    ("2R", "N_{0,1} = τ1"),
    ("2R", EULER),
    ("pendulum", "M = m1 J_{v1}^T J_{v1} + I1"),
    ("polar_arm", f"{EVERY_BODY} I_i J_{{ωi}}"),
    ("polar_arm", f"{EVERY_BODY} R_i I_i R_i^T J_{{ωi}}"),
    ("polar_arm", "ω3 = J_{ω3} q̇"),
    ("four_bar", f"{EVERY_BODY} I_i J_{{ωi}}"),
]  # fmt: skip

WRONG = [
    ("2R", "J_{c1} = [-l1 s1, 0; l1 c1, 0]"),
    ("2R", "J_{v1} = [-lc1 s1, 0; lc1 c1, 0; 1, 0]"),
    ("2R", "J_{ω2} = [0, 1]"),
    ("2R", "J_{ω2} = [1, 1; 0, 0; 0, 0]"),
    ("2R", "J_{v1}^T J_{v1} = [lc1^2, 0; 0, lc1^2]"),
    ("2R", f"M = {MASS}"),
    ("2R", "M = m1 J_{v1} J_{v1}^T + m2 J_{v2} J_{v2}^T"),
    ("2R", "vc2 = J_{v1} q̇"),
    ("2R", "G = Σ J_{vi}^T m_i g"),
    ("2R", "r_{0,c1} = [l1 c1; l1 s1]"),
    ("2R", "r_{1,c1} = [(l1-lc1) c1; (l1-lc1) s1]"),
    ("2R", EULER.replace("- r_", "+ r_")),
    ("polar_arm", f"{EVERY_BODY} R_i^T I_i R_i J_{{ωi}}"),
    ("polar_arm", f"{EVERY_BODY} I_1 J_{{ωi}}"),
]


@pytest.mark.sample(6)
@pytest.mark.parametrize(("robot", "line"), RIGHT)
def test_jacobians_of_bodies_are_read(robot: str, line: str):
    verdict = fb.check(fb.load(robot), line)
    assert verdict, verdict


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "line"), WRONG)
def test_a_wrong_line_about_them_is_not_right(robot: str, line: str):
    assert not fb.check(fb.load(robot), line)
