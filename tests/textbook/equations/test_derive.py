"""Derivations by different methods end in the same polynomials, these are the closed form and the
kernels' values."""

from __future__ import annotations

import itertools
import re
import shutil
import subprocess
from dataclasses import replace
from html import unescape
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.methods import METHODS, WAYS
from support.printed_lines import are_equal, derived, names_in
from support.printed_values import evaluate
from support.symbolic import coupled, spatial_arm, with_values

SOME = {"RRRR", "RPRR", "PRRP", "RRPP"}
"""The arms of four links that are derived in every run; all of them take minutes."""
WORDS = [
    pytest.param(word, marks=[pytest.mark.long] * (len(word) == 4 and word not in SOME))
    for n in (1, 2, 3, 4)
    for word in map("".join, itertools.product("RP", repeat=n))
]


def values_of(derivation, q, qd=None, qdd=None, **load: float) -> np.ndarray:
    """The derived torques (..., n) at states."""
    known = derivation.equations.symbols.values(q, qd, qdd) | load
    shape = np.shape(q)[:-1]
    return np.stack([np.broadcast_to(t.evaluate(known), shape) for t in derivation.tau], axis=-1)


def ends_alike(model: fb.Model) -> None:
    """Every method ends in the closed form, and that has the kernels' values at random states."""
    found = [fb.derive(model, method, **options) for method, options in WAYS]
    for derivation, way in zip(found, WAYS, strict=True):
        for mine, closed in zip(derivation.tau, derivation.equations.tau, strict=True):
            assert (mine - closed).is_zero, way
    bound = with_values(model)
    q, qd, qdd = fb.random_state(bound, seed=5, batch=4)
    tau = values_of(fb.derive(bound, "newton-euler", route="pivot"), q, qd, qdd)
    expected = fb.inverse_dynamics(bound, q, qd, qdd)
    np.testing.assert_allclose(
        tau, expected, rtol=1e-12, atol=1e-12 * max(1.0, np.abs(expected).max())
    )


@pytest.mark.sample(1)
@pytest.mark.parametrize("word", WORDS)
def test_every_way_ends_in_the_closed_form(word):
    ends_alike(fb.planar(word))


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(12))
def test_every_way_ends_in_the_closed_form_in_space(seed):
    ends_alike(spatial_arm(seed, 1 + seed % 4))


@pytest.mark.sample(1)
@pytest.mark.parametrize("names", ["2R", "puma560", "gyro"])
def test_bundled_robots_are_derived(names):
    model = fb.load(names, physical="ignore")
    first = fb.derive(model, "newton-euler")
    assert are_equal(first, fb.derive(model, "recursive"))


COUPLED = [
    coupled(fb.planar("RR"), joint2=("joint1", -1.0, 0.0)),
    coupled(
        fb.planar(
            "PRP", drives=[fb.Drive(0.4, 0.2, 0.1, 2.0), None, fb.Drive(0.1, 0.3, stiffness=5.0)]
        ),
        joint1=("joint3", -1.5, 0.2),
    ),
    coupled(spatial_arm(8, 3), joint1=("joint2", 0.5, 0.1), joint3=("joint2", -2.0, 0.3)),
]
"""Arms whose joints follow others: later and earlier ones, two that follow one, with drives; of the
second the coordinates are those of joints 2 and 3."""


@pytest.mark.sample(1)
@pytest.mark.parametrize("model", COUPLED)
def test_joints_that_follow_others_are_derived_by_every_method(model):
    ends_alike(model)
    kinematics_has_the_kernels_values(model)
    bound = with_values(model)
    q, _, _ = fb.random_state(bound, seed=1, batch=3)
    force = dict(zip(("fx", "fy", "fz"), (3.0, -2.0, 1.0)[: model.dim], strict=False))
    wrench = np.zeros(3 if model.dim == 2 else 6)
    wrench[: model.dim] = list(force.values())
    tau = values_of(fb.derive(bound, "statics"), q, **force)
    np.testing.assert_allclose(tau, fb.static_torque(bound, q, wrench), rtol=1e-11, atol=1e-11)


def test_one_motor_moves_two_joints():
    model = COUPLED[0]
    for way, line in (("centre", "τ₁ = n₀₁ − n₁₂"), ("pivot", "n₁₂ = I₂ ω̇₂ + sc₂ × m₂ (v̇c₂ − g)")):
        derivation = fb.derive(model, "newton-euler", route=way)
        assert line in " ".join(map(str, lines_of(derivation))), way
        assert not re.search("[θτ]₂", derivation.text())
        assert "(revolute, angle −θ₁, follows joint 1)" in " ".join(derivation.text().split())
    assert "ω₂ = ω₁ − θ̇₁ = 0" in lines_of(fb.derive(model, "recursive"))
    text = " ".join(fb.derive(COUPLED[1], "newton-euler").text().split())
    assert "coordinate 1 and motor 1 belong to joint 2" in text
    assert "τ₂ = u₃ · f₂₃ − 1.5 (u₁ · f₀₁)" in text
    passive = " ".join(fb.derive(model.replace(actuated=[])).text().split())
    assert "The common equation of joints 1 and 2" in passive
    with pytest.raises(fb.FreebodyError, match="absolute coordinates are written out for joints"):
        fb.derive(model, "lagrange-first-kind", coordinates="absolute")
    right = ["tau1 = n01 - n12", "omega2 = 0", "H11 = m1 lc1^2 + I1 + m2 l1^2"]
    assert fb.check(model, "\n".join(right))
    assert not fb.check(model, "omega2 = theta1_d")
    assert "torque or force at joint 2, is" in str(fb.check(COUPLED[1], "tau1 = 0"))


LOADED = [
    fb.planar("RR").with_payload(fb.Inertia.point(fb.Parameter("mp"), (0.1, fb.Parameter("b")))),
    fb.planar("PR", m=[2, 3], I=[0, 0.1], l=[0, 1], lc=[0, "e"]).with_payload(mass=1.5),
    fb.planar("R", m=[2], I=[0.1], l=[1], lc=[0.5]).with_payload(mass=1.5, com=[0.1, 0.2]),
    spatial_arm(3, 2).with_payload(fb.Inertia(2.0, (0.1, 0.0, -0.2), (0.1, 0, 0, 0.2, 0, 0.2))),
]


@pytest.mark.sample(2)
@pytest.mark.parametrize("model", LOADED)
def test_a_body_and_its_payload_are_derived_as_one(model):
    ends_alike(model)
    said = fb.derive(model, "lagrange").given
    assert f"Body {model.nv} is link{model.nv} and payload as one rigid body" in said


def test_numbers_of_parts_are_added_up():
    own = fb.Inertia(2.0, (0.5, 0.0, 0.1), (0.1, 0, 0, 0.2, 0, 0.2))
    row = {"m": own.mass, "com": own.com, "I": own.tensor, "a": 0.7}
    arm = fb.dh([row], convention="modified")
    load = fb.Inertia.point(1.5, (0.1, 0.2, 0.0))
    (whole,) = fb.derive(arm.with_payload(load)).equations.symbols.model.bodies[0].inertias
    assert whole.inertia == own + load


def test_the_table_tells_the_symbols_of_the_whole():
    text = fb.derive(LOADED[0], "lagrange").text()
    assert "mt₂             mass of body 2 [kg]" in text
    assert "ct₂x, ct₂y      distances from joint 2 to the centre of mass of body 2 [m]" in text
    assert not re.search(r"\bmp\b", text)
    assert "m_{t2}" in fb.derive(LOADED[0], "lagrange").latex()


@pytest.mark.parametrize(
    ("name", "lines"), [("cart_pole", ["n₀₁ = 0"]), ("furuta", ["n₁₂x = 0", "n₀₁x = 0"])]
)
def test_nothing_is_passed_on_along_a_joint_without_a_motor(name, lines):
    """By the equation of motion of that joint, from which the printed reactions differ."""
    derivation = derived(name, "newton-euler")
    text = derivation.text()
    assert all(f"      {line}\n" in text for line in lines)
    told = "What vanishes by the equation of a joint without a motor is left out."
    assert told in " ".join(text.split())


@pytest.mark.parametrize("method", ["lagrange", "lagrange-first-kind"])
def test_the_table_tells_the_energies_of_rotors_and_springs(method):
    words = {
        "T_r": "kinetic energy of the motors' rotors",
        "V_s": "potential energy of the springs",
    }
    for drive, told in (({}, set()), ({"rotor": 1.0}, {"T_r"}), ({"stiffness": 1.0}, {"V_s"})):
        arm = fb.planar("R").with_drive("joint1", **drive)
        rows = {str(x.symbols[0]): x.words for x in fb.derive(arm, method).glossary}
        assert {name: rows[name] for name in rows.keys() & words} == {x: words[x] for x in told}


def test_the_table_tells_what_bodies_in_numbers_are_called():
    for method, more in (("lagrange", "z_i"), ("newton-euler", "z_i"), ("recursive", "f_i,k")):
        rows = [str(x.symbols[0]) for x in fb.derive(fb.load("scara"), method).glossary]
        assert {"m_i", "I_i", "R_i^k", more} <= set(rows)
        assert len(set(rows)) == len(rows)


def test_moments_of_inertia_in_space_say_about_which_axes():
    """I₁ beside the matrix I₁ was an "entry" of it."""
    words = {str(x.symbols[0]): x.words for x in derived("furuta").glossary}
    assert words["I₁"] == "moment of inertia of body 1 about axes y and z through its centre"
    words = {x.symbols: x.words for x in fb.derive(spatial_arm(2, 3)).glossary}
    assert "entries of the inertia matrix of body 1 about its centre of mass" in words.values()


def test_friction_springs_and_rotors_are_derived_too():
    names = {
        "viscous": "b1",
        "coulomb": "k1",
        "rotor": "J1",
        "gear": "n1",
        "stiffness": "s1",
        "rest": "r1",
    }
    drive = fb.Drive(**{field: fb.Parameter(name) for field, name in names.items()})
    model = fb.planar("RP", drives=[drive, None])
    for method, options in WAYS:
        derivation = fb.derive(model, method, **options)
        for found, closed in zip(derivation.tau, derivation.equations.tau, strict=True):
            # a rotor stands in M of the closed form
            assert (found - closed).is_zero, (method, options)
        assert "drive" not in derivation.text()
        assert "b₁ θ̇₁" in derivation.text()


# ---------------------------------------------------------------- loads and gravity
def test_statics_is_what_holds_the_arm():
    model = fb.planar("RPR", l=[1, 0.2, 0.7], lc=[0.5, 0.1, 0.3], m=[1, 2, 3], I=[0.1, 0.2, 0.3])
    q, _, _ = fb.random_state(model, seed=1, batch=5)
    tau = values_of(fb.derive(model, "statics"), q, fx=3.0, fy=-2.0)
    np.testing.assert_allclose(
        tau, fb.static_torque(model, q, [3.0, -2.0, 0.0]), rtol=1e-12, atol=1e-12
    )


def test_statics_of_the_notes_arm_is_minus_the_jacobian_transposed_times_the_load():
    # (2.45)-(2.48), corrected sign; the arm of (2.52) has no weights
    derivation = fb.derive(fb.planar("RR").replace(gravity=0), "statics")
    text = [str(line) for step in derivation.steps for line in step.equations]
    assert "τ₂ = −s₂ × f" in text
    assert "τ₁ = (l₁ sin θ₁ + l₂ sin(θ₁+θ₂)) f_x − (l₁ cos θ₁ + l₂ cos(θ₁+θ₂)) f_y" in text
    assert "τ₂ = l₂ sin(θ₁+θ₂) f_x − l₂ cos(θ₁+θ₂) f_y" in text
    known = {"l1": 3.5, "l2": 3.0, "fx": -4.5, "fy": -3.0, "theta1": np.pi / 6, "theta2": np.pi / 6}
    np.testing.assert_allclose(
        [t.evaluate(known) for t in derivation.tau], [-5.9731, -7.1913], atol=1e-4
    )


@pytest.mark.parametrize("word", ["R", "RR", "PR", "RP"])
def test_a_load_on_the_tip_is_carried_through_every_method(word):
    n = len(word)
    model = fb.planar(word, l=[1, 0.7][:n], lc=[0.5, 0.3][:n], m=[1, 2][:n], I=[0.1, 0.2][:n])
    q, qd, qdd = fb.random_state(model, seed=1, batch=5)
    expected = fb.inverse_dynamics(model, q, qd, qdd, [3.0, -2.0, 0.0])
    for method, options in WAYS:
        tau = values_of(fb.derive(model, method, load=True, **options), q, qd, qdd, fx=3.0, fy=-2.0)
        np.testing.assert_allclose(tau, expected, rtol=1e-11, atol=1e-11)


@pytest.mark.parametrize("seed", [1, 2])
def test_a_load_in_space(seed):
    model = with_values(spatial_arm(seed, 3))
    q, qd, qdd = fb.random_state(model, seed=1, batch=3)
    load, wrench = {"fx": 3.0, "fy": -2.0, "fz": 1.5}, [3.0, -2.0, 1.5, 0.0, 0.0, 0.0]
    for method, options in WAYS:
        tau = values_of(fb.derive(model, method, load=True, **options), q, qd, qdd, **load)
        np.testing.assert_allclose(
            tau, fb.inverse_dynamics(model, q, qd, qdd, wrench), rtol=1e-10, atol=1e-10
        )
    tau = values_of(fb.derive(model, "statics"), q, **load)
    np.testing.assert_allclose(tau, fb.static_torque(model, q, wrench), rtol=1e-10, atol=1e-10)


@pytest.mark.parametrize(("method", "options"), [*WAYS, ("statics", {})])
def test_without_gravity_there_is_no_g(method, options):
    for model in (fb.planar("RRP").replace(gravity=0), spatial_arm(1, 2).replace(gravity=0)):
        derivation = fb.derive(model, method, **options)
        shown = [line for step in derivation.steps for line in step.equations]
        names = names_in(shown)
        names |= {
            x.name for meaning in derivation.glossary for x in meaning.symbols if hasattr(x, "name")
        }
        assert "g" not in names
        assert not re.search(r"\bgravity G|weight|-g\b", derivation.text())


# ---------------------------------------------------------------- how it reads
def lines_of(derivation) -> list[str]:
    return [str(line) for step in derivation.steps for line in step.equations]


def test_newton_and_euler_of_the_2r_arm_are_the_notes():
    lines = lines_of(fb.derive(fb.planar("RR"), "newton-euler"))
    for line in (
        "f₀₁ − f₁₂ + m₁ g = m₁ v̇c₁",  # (3.10)
        "τ₁ − τ₂ − sc₁ × f₀₁ − (s₁ − sc₁) × f₁₂ = I₁ ω̇₁",  # (3.11)
        "f₁₂ + m₂ g = m₂ v̇c₂",  # (3.12)
        "τ₂ − sc₂ × f₁₂ = I₂ ω̇₂",  # (3.13)
        "τ₂ = I₂ ω̇₂ + sc₂ × m₂ (v̇c₂ − g)",  # (3.14)
        "τ₁ = τ₂ + I₁ ω̇₁ + sc₁ × m₁ (v̇c₁ − g) + s₁ × m₂ (v̇c₂ − g)",  # (3.15)
        "ω₂ = θ̇₁ + θ̇₂",  # (3.17)
        # (3.19)
        "vc₂ = [−l₁ θ̇₁ sin θ₁ − lc₂ (θ̇₁ + θ̇₂) sin(θ₁+θ₂), l₁ θ̇₁ cos θ₁ + lc₂ (θ̇₁ + θ̇₂) "
        "cos(θ₁+θ₂)]ᵀ",
    ):
        assert line in lines


@pytest.mark.parametrize("method", sorted({method for method, _ in WAYS}))
def test_the_2r_arm_ends_in_the_corrected_3_20_to_3_27(method):
    derivation = fb.derive(fb.planar("RR"), method)
    (last,) = [step for step in derivation.steps if step.result]
    assert [str(line) for line in last.equations] == [
        "τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² − 2 h θ̇₁ θ̇₂ + G₁",
        "τ₂ = H₂₁ θ̈₁ + H₂₂ θ̈₂ + h θ̇₁² + G₂",
        "H₁₁ = m₁ lc₁² + I₁ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂",
        "H₂₂ = m₂ lc₂² + I₂",
        "H₁₂ = H₂₁ = m₂ (lc₂² + l₁ lc₂ cos θ₂) + I₂",
        "h = m₂ l₁ lc₂ sin θ₂",
        "G₁ = m₁ g lc₁ cos θ₁ + m₂ g (l₁ cos θ₁ + lc₂ cos(θ₁+θ₂))",
        "G₂ = m₂ g lc₂ cos(θ₁+θ₂)",
    ]


def test_the_pendulum_by_both_routes():
    pivot = lines_of(fb.derive(fb.planar("R"), "newton-euler", route="pivot"))
    assert "I_A = I₁ + m₁ lc₁²" in pivot
    assert "τ₁ + sc₁ × m₁ g = I_A ω̇₁" in pivot  # (3.3)
    centre = lines_of(fb.derive(fb.planar("R"), "newton-euler"))
    assert "τ₁ − sc₁ × f₀₁ = I₁ ω̇₁" in centre  # (3.6)
    for lines in (pivot, centre):
        assert "τ₁ = (m₁ lc₁² + I₁) θ̈₁ + m₁ g lc₁ cos θ₁" in lines  # (3.4), corrected


def test_the_recursion_of_the_2r_arm_is_the_notes():
    text = fb.derive(fb.planar("RR"), "recursive").text()
    for line in (
        "v₂ = v₁ + ω₁ z × s₁ = [−l₁ θ̇₁ sin θ₁, l₁ θ̇₁ cos θ₁]ᵀ",  # (4.7)
        "v̇c₂ = v̇₂ + ω̇₂ z × sc₂ + ω₂ z × (ω₂ z × sc₂)",  # (4.11)
        "τ₁ = nc₁ + τ₂ + sc₁ × fc₁ + s₁ × f₁₂",  # (4.15)
    ):
        assert line in text


def test_virtual_work_of_a_load():
    lines = lines_of(fb.derive(fb.planar("RR"), "lagrange", load=True))
    assert "Q₂ = τ₂ + f · ∂r_P/∂θ₂ = τ₂ − l₂ sin(θ₁+θ₂) f_x + l₂ cos(θ₁+θ₂) f_y" in lines
    assert "d/dt (∂L/∂θ̇₂) − ∂L/∂θ₂ = Q₂" in lines


@pytest.mark.parametrize(
    ("notes", "cited"),
    [
        (("3.22", "3.20", "3.21"), "(3.20)–(3.22)"),
        (("3.16", "3.17", "4.1"), "(3.16), (3.17), (4.1)"),
        (("3.9", "3.10", "3.11", "5.7"), "(3.9)–(3.11), (5.7)"),
    ],
)
def test_numbers_of_equations_are_drawn_together(notes: tuple[str, ...], cited: str):
    step = replace(fb.derive(fb.planar("R")).steps[0], notes=notes)
    assert f"[notes {cited}]" in step.text()


def test_only_arms_of_the_notes_cite_their_free_bodies():
    for step in fb.derive(fb.planar("RRR"), "newton-euler").steps:
        assert not {"3.10", "3.11", "3.12", "3.13", "3.14", "3.15", "3.20"} & set(step.notes)
    assert fb.derive(fb.planar("R"), "newton-euler").steps[0].notes == ("3.5", "3.6")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("model", [fb.planar("RPR"), spatial_arm(3, 2)], ids=["plane", "space"])
def test_the_table_explains_every_parameter_and_coordinate(model, method):
    derivation = fb.derive(model, method)
    explained = {
        x.name for meaning in derivation.glossary for x in meaning.symbols if hasattr(x, "name")
    }
    ring = set(derivation.equations.symbols.ring.names)
    used = names_in(line for step in derivation.steps for line in step.equations)
    loads = {"fx", "fy", "fz"}
    assert (used & ring) - explained - loads == set()
    assert all(meaning.words for meaning in derivation.glossary)
    assert derivation.given.endswith(".")


@pytest.mark.parametrize("method", METHODS)
def test_every_form_holds_every_step(method):
    derivation = fb.derive(fb.planar("RR"), method)
    text, markdown = derivation.text(), derivation.markdown()
    latex, html = derivation.latex(), derivation.html()
    plain = re.sub(r"\s+", " ", unescape(re.sub("<[^>]*>", "", html)))
    for step in derivation.steps:
        assert step.operation in text
        assert step.operation in markdown
        assert step.operation.split(" ")[0] in latex
        # up to the first sign or symbol, which each form writes in its own way
        assert re.split(r"\S_| -", step.reason)[0].strip() in plain
    tables = sum(len(meaning.symbols) for meaning in derivation.glossary)
    shown = [step._repr_html_().count("<math") for step in derivation.steps]  # wide lines apart
    assert [n > 0 for n in shown] == [
        bool(step.equations or step.terms) for step in derivation.steps
    ]
    steps = sum(shown)
    living = html.count('class="slider"') + html.count('class="value"')
    again = "".join(re.findall(r'<div class="equations short.*?</div>', html))  # for a phone
    assert html.count("<math") == tables + steps + living + again.count("<math")
    assert not re.search("https?:", html.replace("http://www.w3.org/1998/Math/MathML", ""))


def test_for_a_phone_an_equation_with_a_long_left_side_is_turned_round(page_of):
    """Only right sides are broken: n₀₁ − n₁₂ − … = I₁ ω̇₁ + … does not fit the other way."""
    page = page_of("elbow_arm", "newton-euler").read_text(encoding="utf-8")
    kinds = ('<div class="equations short', '<div class="equations">')
    own = [page[page.index(kind) :].partition("</div>")[0] for kind in kinds]
    lefts = [" ".join(re.findall(r"<mtr><mtd>(.*?)</mtd>", table)) for table in own]
    assert ["𝐈" in left for left in lefts] == [True, False]


def test_lines_of_a_terminal_fit():
    for method in METHODS:
        for model in (fb.planar("RPR"), spatial_arm(2, 3)):
            for line in fb.derive(model, method).text(width=100).splitlines():
                assert len(re.sub("[\u0300-\u036f]", "", line)) <= 104, line


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs pdflatex")
@pytest.mark.parametrize("method", METHODS)
def test_latex_compiles_and_fits(method, tmp_path: Path):
    for name, model in (("plane", fb.planar("RPR")), ("space", spatial_arm(2, 3))):
        (tmp_path / f"{name}.tex").write_text(fb.derive(model, method).latex())
        command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", f"{name}.tex"]
        run = subprocess.run(
            command, cwd=tmp_path, capture_output=True, text=True, errors="replace"
        )
        assert run.returncode == 0, run.stdout[-2000:]
        assert "Overfull \\hbox" not in run.stdout


# ---------------------------------------------------------------- comparison and refusals
def test_two_methods_are_compared_term_by_term(capsys: pytest.CaptureFixture[str]):
    lagrange = ["derive", "RR", "--method", "lagrange", "--compare"]
    assert run([*lagrange, "newton-euler"]) == 0
    told = capsys.readouterr().out
    assert len(re.findall(r"tau[12]: \d+ terms, identical", told)) == 2
    assert run([*lagrange, "statics"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "one derivation has a load on the tip, the other has none" in told


def test_what_is_not_derived_is_refused():
    with pytest.raises(
        fb.FreebodyError,
        match=r"no method 'hamilton' in fb.derive. Methods: newton-euler, recursive, lagrange",
    ):
        fb.derive(fb.planar("RR"), "hamilton")
    with pytest.raises(fb.FreebodyError, match=r"derive 'lagrange': 'four_bar' is a closed chain"):
        derived("four_bar", "lagrange")
    with pytest.raises(
        fb.FreebodyError, match=r"no route 'left' in newton-euler. Routes: centre, pivot"
    ):
        fb.derive(fb.planar("RR"), "newton-euler", route="left")
    with pytest.raises(
        fb.FreebodyError, match=r"no gravity 'up' in recursive. Gravities: base, explicit"
    ):
        fb.derive(fb.planar("RR"), "recursive", gravity="up")


# ---------------------------------------------------------------- kinematics
def test_kinematics_of_the_2r_arm_is_the_notes():
    lines = lines_of(fb.derive(fb.planar("RR"), "kinematics"))
    for line in (
        "r_P = s₁ + s₂ = [l₁ cos θ₁ + l₂ cos(θ₁+θ₂), l₁ sin θ₁ + l₂ sin(θ₁+θ₂)]ᵀ",  # (2.10)-(2.13)
        "ṙ_P = J q̇",  # (2.18)
        # (2.19)
        "J = [−l₁ sin θ₁ − l₂ sin(θ₁+θ₂), −l₂ sin(θ₁+θ₂); l₁ cos θ₁ + l₂ cos(θ₁+θ₂), l₂ "
        "cos(θ₁+θ₂)]",
        "det J = l₁ l₂ sin θ₂",  # (2.22)
        "θ₂ = 0",
        "θ₂ = π",  # (2.23)
        "r̈_P = J q̈ + J̇ q̇",  # (2.24)
        "q̇ = J⁻¹ ṙ_P",  # (2.25)
        "q̈ = J⁻¹ (r̈_P − J̇ q̇)",  # (2.26)
        "cos θ₂ = (x² + y² − (l₁² + l₂²))/(2 l₁ l₂)",  # (2.14)
        "(x² + y²) sin θ₁ = (l₁ + l₂ cos θ₂) y − l₂ sin(θ₂) x",  # (2.15), with its quadrant
        "(x² + y²) cos θ₁ = (l₁ + l₂ cos θ₂) x + l₂ sin(θ₂) y",
    ):
        assert line in lines


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "model", [fb.planar("RP"), fb.planar("RRR"), fb.planar("PR"), spatial_arm(5, 3)]
)
def test_kinematics_has_the_kernels_values(model):
    kinematics_has_the_kernels_values(model)


def kinematics_has_the_kernels_values(model: fb.Model) -> None:
    """Jacobian, position and acceleration of the tip."""
    derivation = fb.derive(model, "kinematics")
    bound = with_values(model)
    q, qd, qdd = fb.random_state(bound, seed=2, batch=3)
    known = fb.equations(bound).symbols.values(q, qd, qdd)
    values = {
        line.lhs.name: line
        for step in derivation.steps
        for line in step.equations
        if hasattr(line.lhs, "name")
    }
    n, dim = model.nv, model.dim
    J = evaluate(values["J"], known)
    np.testing.assert_allclose(
        J, fb.jacobian(bound, q)[..., : J.shape[-2], :], rtol=1e-11, atol=1e-12
    )
    J_d = evaluate(values["J_d"], known)
    np.testing.assert_allclose(
        J_d, fb.jacobian_dot(bound, q, qd)[..., : J.shape[-2], :], rtol=1e-11, atol=1e-12
    )
    position = evaluate(values["r_P"], known)
    np.testing.assert_allclose(
        position, fb.forward_kinematics(bound, q)[..., :dim, dim], rtol=1e-11, atol=1e-12
    )
    acceleration = evaluate(values["r_P_dd"], known)
    expected = fb.acceleration(bound, q, qd, qdd)[..., :dim]
    np.testing.assert_allclose(acceleration, expected, rtol=1e-11, atol=1e-11)
    if "J_inverse" in values:
        inverse = evaluate(values["J_inverse"], known)
        np.testing.assert_allclose(inverse @ J, np.broadcast_to(np.eye(n), J.shape), atol=1e-10)


def test_kinematics_ends_in_no_torques(capsys: pytest.CaptureFixture[str]):
    assert fb.derive(fb.planar("RR"), "kinematics").tau == ()
    assert run(["derive", "RR", "--method", "kinematics", "--compare", "lagrange"]) == 2
    told = " ".join(capsys.readouterr().err.split())
    assert "kinematics does not give joint torques" in told


def test_no_equation_repeats_a_rule_as_a_number_of_terms():
    """T₄ = ½ m₄ v² + … had read “= ((55 terms))”."""
    said = str(derived("bricard"))
    assert "T₄ = ½ m₄ vc₄² + ½ (ω₄ · I₄ ω₄)\n" in said
    assert "((" not in said


def test_long_lists_are_several_tables():
    """A printed page ends between tables only; one of ninety rows was cut."""
    vectors = next(x for x in derived("ur5e").steps if x.operation == "The vectors")
    assert vectors._repr_html_().count("<math ") == 3
    *short, _, _ = derived("2R", "lagrange").steps  # meanings and limits
    assert all(step._repr_html_().count("<math ") == 1 for step in short)


def test_no_comma_begins_a_line_of_the_table(page_of):
    page = page_of("3R").read_text(encoding="utf-8")
    table = re.findall(r"<table.*?</table>", page, re.DOTALL)[0]
    assert ",</span> " in table
    assert "</math>, " not in table


def test_entries_of_a_wide_matrix_are_named_by_row_and_column():
    """Of the elbow arm's Jacobian: a turn about the vertical does not lift the tip, and bending the
    elbow moves it towards the axis."""
    told = fb.derive(fb.load("elbow_arm"), "kinematics").text()
    for line in (
        "J₁₃ = −l₃ cos θ₁ sin(θ₂+θ₃)",
        "J₂₁ = l₂ cos θ₁ cos θ₂ + l₃ cos θ₁ cos(θ₂+θ₃)",
        "J₃₁ = 0",
        "J̇₃₁ = 0",
        "J₃₂ = l₂ cos θ₂ + l₃ cos(θ₂+θ₃)",
    ):
        assert re.search(rf"{re.escape(line)}\s*[│\n]", told), line
