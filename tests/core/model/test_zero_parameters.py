"""A parameter given as 0 is 0: in equations, derivations, generated code and `check`, however it
was given."""

from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from support.methods import METHODS, agree

RR = {"l": ["l1", "l2"], "lc": ["l1", "l2"], "m": ["m1", "m2"]}
TOML = """
name = "points"
[planar]
word = "RR"
lc = ["l1", "l2"]
[parameters]
I1 = 0
I2 = 0.0
"""
ROW = {"a": "a1", "m": "m1", "com": ["c1x", 0, 0], "I": [0, 0, 0, "I1yy", 0, "I1zz"]}


def from_toml(folder: Path) -> Model:
    """Point masses from a file."""
    path = folder / "points.toml"
    path.write_text(TOML, encoding="utf-8")
    return fb.load(path)


def test_point_masses_leave_no_inertia_in_the_equations(tmp_path: Path):
    """However the zeros come: as numbers, bound later, or from a file."""
    given = fb.planar("RR", I=[0, 0], **RR)
    bound = fb.planar("RR", **RR).bind(I1=0, I2=0.0)
    for model in (given, bound, from_toml(tmp_path)):
        text = str(fb.equations(model))
        assert "H₂₂ = m₂ l₂²\n" in text
        assert "I₁" not in text
        assert "I₂" not in text
        verdict = fb.check(model, "H22 = m2 l2^2\nH12 = m2 (l2^2 + l1 l2 cos(theta2))")
        assert verdict, verdict.text
        named = fb.check(model, "H22 = m2 l2^2 + I2")  # which is the same number
        assert named
        assert "I₂ is 0 in" in named.text
        wrong = fb.check(model, "H22 = m2 l2^2 - I2 - m2")
        assert not wrong
        assert "‘- m2’" in wrong.text


def test_a_parameter_of_a_table_bound_to_zero_is_gone():
    arm = fb.dh([ROW], convention="standard")
    assert "I₁zz" in str(fb.equations(arm))
    assert fb.check(arm.bind(I1zz=0), "H11 = m1 (a1 + c1x)^2")
    assert fb.check(arm.bind(c1x=0, a1=0), "H11 = I1zz")


def test_the_bundled_slide_begins_at_the_axis_in_equations_as_in_its_drawing():
    text = str(fb.equations(fb.load("RP")))
    assert "h = m₂ (d₂ + lc₂)" in text
    assert "l₁" not in text
    assert "l₁" not in fb.derive(fb.load("RP"), "newton-euler").text()


def test_no_gravity_means_no_gravity_terms():
    still = fb.planar("RR", g=0)
    assert "G" not in str(fb.equations(still))
    assert fb.check(still, "G1 = 0")


@pytest.mark.parametrize("method", METHODS)
def test_derivations_of_bodies_with_nothing_in_them(method: str):
    """Massless bodies, point masses, joints in one place: every method ends, and names no moment of
    inertia."""
    for model in (
        fb.planar("RR", I=[0, 0], **RR),
        fb.planar("RR", l=["l1", "l2"], lc=[0, "lc2"], m=[0, "m2"], I=[0, "I2"]),
        fb.planar("RP", l=[0, "l2"], lc=[0, 0], m=[0, "m"], I=[0, 0]),
        fb.dh([{"a": "a1", "m": "m1", "com": ["c1x", 0, 0]}], convention="modified"),
    ):
        text = fb.derive(model, method).text()
        assert "I₁ ω̇₁" not in text
        assert "½ I₁" not in text
        assert "0 = 0" not in text


def test_quantities_of_a_massless_body_are_zero():
    found = fb.quantities(fb.planar("RR", l=["l1", "l2"], m=[0, "m2"], lc=[0, "lc2"], I=[0, "I2"]))
    assert all(x.is_zero for x in found["fc1"])
    assert found["Mc1"].is_zero


def test_methods_still_agree_and_code_has_no_ghost():
    model = fb.planar("RP", l=[0, 0.4], lc=[0.1, 0.2], m=[1.0, 2.0], I=[0, 0.1])
    assert agree(fb.derive(model, "lagrange"), fb.derive(model, "newton-euler"))
    source = fb.equations(model).python()
    assert "I1" not in source
    assert "I2" in source
    q, qd, qdd = np.array([0.3, 0.5]), np.array([0.4, -0.2]), np.array([0.1, 0.7])
    by_equations = fb.equations(model).evaluate(fb.equations(model).tau, q, qd, qdd)
    assert np.allclose(by_equations, fb.inverse_dynamics(model, q, qd, qdd), rtol=1e-12)
