"""Derivations by different methods end in the same polynomials, and these are the closed form."""

from __future__ import annotations

import itertools
from html import escape

import numpy as np
import pytest

import freebody as fb

WORDS = ["".join(w) for n in (1, 2, 3) for w in itertools.product("RP", repeat=n)]
WAYS = [
    ("lagrange", {}),
    ("newton-euler", {"route": "centre"}),
    ("newton-euler", {"route": "pivot"}),
    ("recursive", {"gravity": "base"}),
    ("recursive", {"gravity": "explicit"}),
]


def spatial_arm(seed: int, n: int) -> fb.Model:
    """A random arm by its DH table, some of its entries symbols."""
    rng = np.random.default_rng(seed)
    rows = [
        {
            "joint": str(rng.choice(["R", "R", "P"])),
            "a": f"a{i}",
            "d": 0.0 if rng.random() < 0.5 else float(rng.integers(1, 5)) / 10,
            "alpha": float(rng.choice([0.0, np.pi / 2, -np.pi / 2, 0.3])),
            "m": f"m{i}",
            "com": (f"c{i}x", float(rng.integers(-5, 5)) / 10, 0.0),
            "I": [f"I{i}xx", 0.0, 0.0, f"I{i}yy", 0.0, f"I{i}zz"],
        }
        for i in range(1, n + 1)
    ]
    return fb.dh(rows, convention=str(rng.choice(["standard", "modified"])), name=f"arm{seed}")


@pytest.mark.parametrize("word", [*WORDS, "RRRR", "RPRP", "PRRP"])
def test_every_way_ends_in_the_closed_form(word):
    model = fb.planar(word)
    for method, options in WAYS:
        derivation = fb.derive(model, method, **options)
        for found, closed in zip(derivation.tau, derivation.equations.tau, strict=True):
            assert found == closed, (method, options)


@pytest.mark.parametrize("seed", range(6))
def test_every_way_ends_in_the_closed_form_in_space(seed):
    model = spatial_arm(seed, 2 + seed % 2)
    for method, options in WAYS:
        derivation = fb.derive(model, method, **options)
        for found, closed in zip(derivation.tau, derivation.equations.tau, strict=True):
            assert (found - closed).is_zero, (method, options)


def test_friction_springs_and_rotors_are_derived_too():
    names = {"viscous": "b1", "coulomb": "k1", "rotor": "J1", "gear": "n1", "stiffness": "s1", "rest": "r1"}
    drive = fb.Drive(**{field: fb.Parameter(name) for field, name in names.items()})
    model = fb.planar("RP", drives=[drive, None])
    for method, options in WAYS:
        derivation = fb.derive(model, method, **options)
        for found, closed in zip(derivation.tau, derivation.equations.tau, strict=True):
            # a rotor stands in M of the closed form
            assert (found - closed).is_zero, (method, options)


def test_statics_is_what_holds_the_arm():
    model = fb.planar("RPR", l=[1, 0.2, 0.7], lc=[0.5, 0.1, 0.3], m=[1, 2, 3], I=[0.1, 0.2, 0.3])
    derivation = fb.derive(model, "statics")
    q, _, _ = fb.random_state(model, seed=1, batch=5)
    values = derivation.equations.symbols.values(q) | {"fx": 3.0, "fy": -2.0}
    tau = np.stack([t.evaluate(values) for t in derivation.tau], axis=-1)
    np.testing.assert_allclose(tau, fb.static_torque(model, q, [3.0, -2.0, 0.0]), rtol=1e-12, atol=1e-12)


def test_a_load_on_the_tip_is_carried_through_newton_euler_and_the_recursion():
    model = fb.planar("RR", l=[1, 0.7], lc=[0.5, 0.3], m=[1, 2], I=[0.1, 0.2])
    q, qd, qdd = fb.random_state(model, seed=1, batch=5)
    expected = fb.inverse_dynamics(model, q, qd, qdd, [3.0, -2.0, 0.0])
    for method, options in WAYS[1:]:
        derivation = fb.derive(model, method, load=True, **options)
        values = derivation.equations.symbols.values(q, qd, qdd) | {"fx": 3.0, "fy": -2.0}
        tau = np.stack([t.evaluate(values) for t in derivation.tau], axis=-1)
        np.testing.assert_allclose(tau, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("method", ["lagrange", "newton-euler", "recursive", "statics"])
def test_every_form_holds_every_step(method):
    derivation = fb.derive(fb.planar("RR"), method)
    text, markdown, latex, html = (
        derivation.text(),
        derivation.markdown(),
        derivation.latex(),
        derivation.html(),
    )
    for step in derivation.steps:
        assert step.operation in text
        assert step.operation in markdown
        assert step.operation.split(" ")[0] in latex
        assert escape(step.reason) in html
    assert html.count("<math") == sum(bool(step.equations) for step in derivation.steps)
    assert "http" not in html.replace("http://www.w3.org/1998/Math/MathML", "")


def test_what_is_not_derived_is_refused():
    with pytest.raises(
        fb.FreebodyError, match=r"no method 'kane' in fb.derive. Methods: newton-euler, recursive, lagrange"
    ):
        fb.derive(fb.planar("RR"), "kane")
    with pytest.raises(fb.FreebodyError, match=r"no route 'left' in newton-euler. Routes: centre, pivot"):
        fb.derive(fb.planar("RR"), "newton-euler", route="left")
    with pytest.raises(fb.FreebodyError, match=r"a load on the tip is written out for planar arms"):
        fb.derive(fb.planar("RR"), "lagrange", load=True)
