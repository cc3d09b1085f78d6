"""What is derived in a notation is what `check` reads in it, and says who writes so."""

from __future__ import annotations

import math
import re
from functools import cache
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.notations import NOTATIONS, own_notation
from support.page_data import page_data

ARM = fb.planar("RR")
DERIVED = [
    ("2R", "newton-euler"), ("2R", "lagrange"), ("2R", "kane"), ("RP", "newton-euler"),
    ("pendulum", "lagrange"), ("furuta", "recursive"), ("cart_pole", "lagrange"),
    ("four_bar", "lagrange-first-kind"), ("slider_crank", "newton-euler"),
]  # fmt: skip


PRINTED = [
    pytest.param(robot, method, notation, marks=[pytest.mark.long] * bool((i + k) % 3))
    for i, (robot, method) in enumerate(DERIVED)
    for k, notation in enumerate(NOTATIONS)
]
"""Every derivation in every notation; a third of the pairs, with each of both, in every run."""


def lines(derivation: Any) -> list[str]:
    return [str(line) for step in derivation.steps for line in step.equations]


def closed_form(derivation: Any) -> list[str]:
    step = next(x for x in derivation.steps if x.operation == "The closed form")
    return list(map(str, step.equations))


def is_right(model: fb.Model, text: str, notation: str | Path | None = None) -> bool:
    try:
        return bool(fb.check(model, text, notation=notation))
    except fb.FreebodyError:
        return False


def is_called_otherwise(line: str, notation: str) -> bool:
    """Whether a line gives u or n_i of closed chains, where these are letters of the notation for
    a potential energy or for weights."""
    own = re.match(r"([un])[₀-₉]? = ", line)
    return own is not None and own[1] == {"craig": "u", "murray-li-sastry": "n"}.get(notation)


@cache
def read_in_the_notes(robot: str, method: str) -> tuple[list[int], int]:
    """The lines before the closed form that `check` reads in the notes' own letters, by place."""
    model = fb.load(robot)
    told = fb.derive(model, method)
    names = [step.operation for step in told.steps]
    end = names.index("The closed form") if "The closed form" in names else len(names)
    before = [str(line) for step in told.steps[:end] for line in step.equations]
    return [k for k, line in enumerate(before) if is_right(model, line)], len(before)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("robot", "method", "notation"), PRINTED)
def test_what_is_printed_in_a_notation_is_read_in_it(robot: str, method: str, notation: str):
    model = fb.load(robot)
    printed = lines(fb.derive(model, method, notation=notation))
    places, end = read_in_the_notes(robot, method)
    chosen = [printed[k] for k in places if not is_called_otherwise(printed[k], notation)]
    chosen += printed[end:]
    assert len(chosen) > 10
    if not is_right(model, "\n".join(chosen), notation):
        assert [line for line in chosen if not is_right(model, line, notation)] == []


CLOSED = {
    "notes": ["τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² − 2 h θ̇₁ θ̇₂ + G₁", "h = m₂ l₁ lc₂ sin θ₂"],
    "craig": ["τ₁ = M₁₁ θ̈₁ + M₁₂ θ̈₂ + V₁ + G₁", "V₂ = m₂ l₁ lc₂ s₂ θ̇₁²", "G₂ = m₂ g lc₂ c₁₂"],
    "spong": ["τ₂ = d₂₁ q̈₁ + d₂₂ q̈₂ + C₂₁ q̇₁ + g₂", "C₂₁ = m₂ l₁ lc₂ sin(q₂) q̇₁"],
    "siciliano": ["b₂₂ = ml₂ l₂² + Il₂", "C₂₁ = ml₂ a₁ l₂ s₂ θ̇₁", "g₂ = ml₂ g l₂ c₁₂"],
    "murray-li-sastry": ["M₂₂ = m₂ r₂² + Iz₂", "N₂ = m₂ g r₂ c₁₂"],
    "lynch-park": ["M₂₂ = m₂ r₂² + I₂", "h₂ = m₂ L₁ r₂ sin(θ₂) θ̇₁² + m₂ g r₂ cos(θ₁+θ₂)"],
    "featherstone": ["τ₂ = H₂₁ q̈₁ + H₂₂ q̈₂ + C₂", "H₂₂ = m₂ lc₂² + I₂"],
}


@pytest.mark.parametrize("notation", NOTATIONS)
def test_each_book_has_its_letters(notation: str):
    told = fb.derive(ARM, "lagrange", notation=notation)
    assert set(CLOSED[notation]) <= set(closed_form(told))
    own = fb.equations(ARM).text(names=notation).splitlines()
    assert set(CLOSED[notation]) <= set(own)


def test_sentences_tables_and_documents_have_the_letters_too():
    told = fb.derive(fb.load("2R"), "lagrange", notation="siciliano")
    text = told.text()
    assert "h = ml₂ a₁ l₂ sin θ₂" in text
    assert "ml₁             mass of body 1 [kg]" in text
    words = " ".join(text.split())
    assert "the mass matrix B, the matrix C of velocity terms and gravity g" in words
    assert "Letters: B. Siciliano" in words
    assert "lc" not in text
    assert "T_i, U_i" in text
    assert r"\begin{aligned}" in told.latex()
    assert r"b_{22} &= m_{l2} l_2^2 + I_{l2}" in told.latex()
    spong = fb.derive(ARM, "lagrange", notation="spong")
    assert "11. Derivatives for q₂" in spong.text()
    assert "θ" not in spong.text()


def test_pages_and_drawings_have_the_letters():
    told = fb.derive(fb.load("2R"), "lagrange", notation="siciliano")
    page = told.html()
    assert ">a_1<" in page or "<tspan" in page
    assert "lc1" not in page.split("<script>", maxsplit=1)[0].replace('data-of="lc1"', "").replace(
        'data-input="lc1"', ""
    )
    data = page_data(page)
    of_one = [spellings for spellings, _ in data["words"] if "l#" in spellings]
    assert any({"l#c", "lC#", "lG#", "lc#"} <= {*x} for x in of_one)  # answers call lc_2 l_2 there
    assert data["option"] == " --notation siciliano"
    figure = fb.free_body_diagram(fb.load("2R"), show="lengths", notation="siciliano")
    names = {getattr(x, "label", "") for drawing in figure.drawings for x in drawing.elements}
    assert {"a_1", "l_1", "l_2", "m_{l1} *g*"} <= names
    diagram = fb.kinematic_diagram(fb.load("2R"), notation="spong")
    assert diagram.named("q_2")


def test_two_things_are_never_printed_by_one_name(tmp_path: Path):
    one = own_notation(tmp_path, "one", names={"r": "lc", "r1": "l1"})
    with pytest.raises(fb.FreebodyError, match="notation 'one' calls both l1 and lc1 r1"):
        fb.derive(ARM, notation=one)
    torque = own_notation(tmp_path, "two", letters={"torque": "L"}, names={"L": "l"})
    with pytest.raises(fb.FreebodyError, match=r"notation 'two' calls both .*τ₁.* L₁"):
        fb.derive(ARM, notation=torque)
    crane = fb.load("gantry_crane")  # its only length is l, and L the Lagrangian
    told = fb.derive(crane, "lagrange", notation="lynch-park")
    assert "∂L/∂ẋ = (m₁ + m₂ + m) ẋ + m l cos(θ₄) θ̇₄" in lines(told)
    assert is_right(crane, "∂L/∂ẋ = (m₁ + m₂ + m) ẋ + m l cos(θ₄) θ̇₄", "lynch-park")


def test_a_letter_that_is_taken_gives_way_to_the_next_of_its_list():
    """H is the reduced mass matrix of a closed chain of two degrees of freedom, M the whole."""
    told = lines(fb.derive(fb.load("five_bar"), notation="featherstone"))
    assert any(x.startswith("M₁₁ = ") for x in told)
    assert any(x.startswith("H₁₁ = ") for x in told)


@pytest.mark.parametrize(
    "file",
    [
        "[names]\n'<script>alert(1)</script>' = 'l'",
        "[letters]\nmass = '\\input{/etc/passwd}'",
        "[letters]\nmass = 'M</title>'",
        "[letters]\nkinetic = 'é'",
        "[names]\n'l;import os' = 'l1'",
    ],
)
def test_hostile_names_are_refused(tmp_path: Path, file: str):
    path = tmp_path / "mine.toml"
    path.write_text(file, encoding="utf-8")
    with pytest.raises(fb.FreebodyError, match=r"is not a letter|cannot be printed"):
        fb.derive(ARM, "lagrange", notation=path)


def test_what_a_notation_tells_of_itself_is_text(tmp_path: Path):
    path = tmp_path / "a'<b>x.toml"
    path.write_text("title = '<b>\\input{x}</b>$_'\n[letters]\nmass = 'A'", encoding="utf-8")
    told = fb.derive(ARM, "lagrange", notation=path)
    assert "&lt;b&gt;" in told.html()
    assert "<b>" not in told.html()
    assert r"\input" not in told.latex()
    assert "A₂₂ = m₂ lc₂² + I₂" in lines(told)


def test_the_commands_take_a_notation(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["derive", "RR", "--notation", "craig"]) == 0
    assert "V₂ = m₂ l₁ lc₂ " in capsys.readouterr().out
    out = tmp_path / "arm.svg"
    assert run(["fbd", "2R", "--notation", "siciliano", "--out", str(out)]) == 0
    assert "ml1 g" in capsys.readouterr().out
    assert run(["derive", "RR", "--notation", "crag"]) == 2
    assert "Did you mean 'craig'" in capsys.readouterr().err


ROD = {"lc": "l/2", "I": "m*l^2/12"}


def test_names_that_the_robot_has_itself_stay_and_are_told():
    arm = fb.planar("RR", l=["a1", "a2"], lc=["l1", "l2"], m=["ml1", "ml2"], I=["Il1", "Il2"])
    told = fb.derive(arm, "lagrange", notation="siciliano")
    assert "The robot's own names stay, as Il, a and ml would be one" in told.given
    assert "b₂₂ = ml₂ l₂² + Il₂" in lines(told)


def test_drawings_tell_that_they_leave_formulas_out(tmp_path: Path):
    style = own_notation(tmp_path, "bar", parameters=ROD)
    with pytest.warns(fb.FreebodyWarning, match="are not drawn; labels are letters"):
        fb.free_body_diagram(ARM, notation=style)


def test_greek_letters_are_letters(tmp_path: Path):
    style = own_notation(tmp_path, "greek", letters={"mass": "Ψ"}, names={"φ": "theta", "ψ": "d"})
    told = fb.derive(fb.load("RP"), "lagrange", notation=style)
    assert any(x.startswith("Ψ₁₁ = ") for x in lines(told))
    assert "The equation of ψ₂" in told.text()
    assert "joint 2 (prismatic, displacement ψ₂" in " ".join(told.text().split())
    assert all(is_right(fb.load("RP"), x, style) for x in closed_form(told)[-4:])


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange", "kane"])
def test_parameters_by_formulas_are_put_in(method: str):
    """Uniform bars: the mass matrix of a textbook, and everything that is printed is right."""
    told = fb.derive(ARM, method, parameters=ROD)
    assert "Here lc₁ = ½ l₁, lc₂ = ½ l₂, I₁ = 1/12 m₁ l₁² and I₂ = 1/12 m₂ l₂²." in told.given
    closed = closed_form(told)
    assert "H₂₂ = ⅓ m₂ l₂²" in closed
    assert "G₂ = ½ m₂ g l₂ cos(θ₁+θ₂)" in closed
    assert fb.check(ARM, closed, parameters=ROD)
    assert "I₁ = 1/12 m₁ l₁²" in lines(told) or method not in ("newton-euler", "kane")
    assert fb.check(ARM, ["I₁ = 1/12 m₁ l₁²", *closed], parameters=ROD)
    wrong = fb.check(ARM, ["I₁ = 1/3 m₁ l₁²", *closed], parameters=ROD)
    assert [x.equal for x in wrong.equations] == [False, *[True] * (len(wrong.equations) - 1)]
    assert not fb.check(ARM, closed)
    plain = fb.derive(ARM, method).equations.symbols
    values = {"l1": 0.7, "l2": 0.4, "m1": 2.0, "m2": 1.5, "g": 9.81}
    rods = values | {f"lc{k}": values[f"l{k}"] / 2 for k in (1, 2)}
    rods |= {f"I{k}": values[f"m{k}"] * values[f"l{k}"] ** 2 / 12 for k in (1, 2)}
    state = {x + end: 0.3 + 0.2 * k for k, x in enumerate(plain.coordinates)
             for end in ("", "_d", "_dd")}  # fmt: skip
    own = fb.derive(ARM, method).tau
    for a, b in zip(told.tau, own, strict=True):
        assert a.evaluate(values | state) == pytest.approx(b.evaluate(rods | state), rel=1e-12)


SLEEVE = {
    "l1": 0, "lc1": "a/2", "I1": "m1*a^2/12", "lc2": "-l2/2", "I2": "m2*l2^2/12",
    "lc3": "l3/2", "I3": "m3*r^2/2",
}  # fmt: skip
"""A sleeve of length a, a rod of length l2 in it up to joint 3, a disc of radius r."""


def test_formulas_may_have_letters_that_the_robot_lacks():
    """The equations are those of the robot with the numbers that the formulas give."""
    arm = fb.planar("RPR")
    told = fb.derive(arm, "lagrange", parameters=SLEEVE)
    words = " ".join(told.text().split())
    assert "l₂ length of body 2 [m]" in words
    assert "a, r numbers by which others are given" in words
    values = {"a": 0.5, "l2": 0.7, "r": 0.1, "l3": 0.3, "m1": 3.0, "m2": 2.0, "m3": 1.5}
    by_hand = {"l1": 0.0, "lc1": 0.25, "I1": 0.0625, "lc2": -0.35, "I2": 0.98 / 12, "lc3": 0.15}
    real = arm.bind(**by_hand, I3=0.0075, **{k: values[k] for k in ("l3", "m1", "m2", "m3")})
    q, qd, qdd = [0.3, 0.6, -0.8], [1.1, -0.4, 0.7], [0.5, 1.2, -0.9]
    names = told.equations.symbols.coordinates
    rows = zip(("", "_d", "_dd"), (q, qd, qdd), strict=True)
    values |= {x + end: v for end, row in rows for x, v in zip(names, row, strict=True)}
    found = [x.evaluate(values | {"g": 9.81}) for x in told.tau]
    assert found == pytest.approx(fb.inverse_dynamics(real, q, qd, qdd), rel=1e-12)
    right = "H11 = 1/3 m1 a^2 + m2 (d2^2 - d2 l2 + l2^2/3) + m3 (d2^2 + l3^2/4 + d2 l3 c3 + r^2/2)"
    assert fb.check(arm, [right, *closed_form(told)], parameters=SLEEVE)
    wrong = fb.check(arm, right.replace("1/3 m1", "1/4 m1"), parameters=SLEEVE)
    assert "must be ⅓ m₁ a²" in wrong.text
    rods = fb.derive(arm, parameters={"lc": "l/2"})  # of all links, the one that slides too
    assert "Here lc₁ = ½ l₁, lc₂ = ½ l₂ and lc₃ = ½ l₃." in rods.given


def test_zeros_are_zeros_and_numbers_are_numbers():
    """Point masses at the ends of the links."""
    told = fb.derive(ARM, "lagrange", parameters={"lc": "l", "I": 0})
    assert "H₂₂ = m₂ l₂²" in lines(told)
    assert "T₂ = ½ m₂ vc₂² = " in " ".join(told.text().split())
    assert "H₂₂ = ¼ m₂ + I₂" in lines(fb.derive(ARM, parameters={"lc2": 0.5, "l1": 1}))


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"lc9": "l1"}, "no parameter 'lc9'"),
        ({"lc": "l/"}, "derive 'newton-euler': the parameter lc = l/: the line ends"),
        ({"lc1": "theta1"}, "changes with the motion"),
        ({"lc1": "lc2", "lc2": "l2"}, "names a parameter that is given by a formula"),
        ({"lc1": "L1"}, "no quantity 'L1' .* Did you mean 'l1'"),
        ({"lc1": "theta9"}, "no quantity 'theta9'"),
        ({"I1": "m1*q1^2"}, "no quantity 'q1'"),
        ({"I1": "m1*tau1"}, "no quantity 'tau1'"),
        ({"lc": "l/0"}, "lc1 = l1/0: it divides by 0"),
        ({"lc": "l/(m-m)"}, "divides by 0"),
        ({"m": -1}, "m1 = -1.0 is negative; a mass is never negative"),
        ({"m2": "m1 - 2*m1"}, "m2 = m1 - 2\\*m1 is negative"),
        ({"I1": "-1/12*m1*l1^2"}, "a moment of inertia is never negative"),
        ({"m1": math.nan}, "the parameter m1: nan is not a finite number"),
        ({"m1": "-inf"}, "m1 = -inf: it is not a finite number"),
        ({"m1": [1, 2]}, r"m1: \[1, 2\] is not a number"),
        ({"m1": "[1, 2]"}, "a parameter is one number"),
    ],
)
def test_a_formula_that_cannot_be_is_refused(given: dict[str, Any], words: str):
    with pytest.raises(fb.FreebodyError, match=words):
        fb.derive(ARM, parameters=given)


def test_the_sign_of_a_formula_is_judged_with_the_values_of_the_model():
    arm = ARM.bind(m1=2.0, l1=0.5)
    words = "I1 = m1\\*l1 - 5 is −4 with the values of 'RR'; a moment of inertia is never"
    with pytest.raises(fb.FreebodyError, match=words):
        fb.check(arm, "H22 = m2 lc2^2 + I2", parameters={"I1": "m1*l1 - 5"})
    assert fb.check(arm, "H22 = m2 lc2^2 + I2", parameters={"I1": "m1*l1 - 1", "m2": "m1 - l2"})
    assert fb.check(arm, "H22 = I2", parameters={"m2": 0})


def test_numbers_in_place_of_parameters_have_no_units_to_fit():
    verdict = fb.check(ARM, "H12 = m2 (lc2² + l2 lc2 c2) + I2", parameters={"lc": 0.5})
    assert "‘l2’ must be l₁" in verdict.text
    assert "units" not in verdict.text
    assert "The units do not fit" in fb.check(ARM, "H22 = m2 + I2", parameters={"lc": "l/2"}).text


def test_the_commands_take_parameters(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    rod = ["--parameter", "lc=l/2", "--parameter", "I=m*l^2/12"]
    assert run(["derive", "RR", *rod]) == 0
    assert "H₂₂ = ⅓ m₂ l₂²" in capsys.readouterr().out
    assert run(["check", "RR", "H22 = m2*l2^2/3", *rod]) == 0
    assert run(["check", "RR", "H22 = m2*l2^2/4", *rod]) == 1
    capsys.readouterr()
    assert run(["check", "RR", "H22 = 0", "--parameter", "lc"]) == 2
    assert "--parameter lc: write a name, =, and what it stands for" in capsys.readouterr().err
    file = tmp_path / "rods.toml"
    file.write_text("[parameters]\nlc = 'l/2'\nI = 'm*l^2/12'", encoding="utf-8")
    assert run(["derive", "RR", "--notation", str(file), "--out", str(tmp_path / "a.html")]) == 0


OWN = """angles = "{angles}"
zero = "{zero}"
terms = "vector"
[names]
phi = "theta"
[letters]
mass = "B"
velocity = "C"
"""


def own(folder: Path, angles: str = "relative", zero: str = "x axis") -> Path:
    file = folder / "mine.toml"
    file.write_text(OWN.format(angles=angles, zero=zero), encoding="utf-8")
    return file


@pytest.mark.sample(1)
@pytest.mark.parametrize("zero", ["down", "up"])
@pytest.mark.parametrize(
    ("angles", "robot", "method"),
    [
        ("relative", "2R", "newton-euler"),
        ("relative", "2R", "kane"),
        ("relative", "RP", "recursive"),
        ("absolute", "2R", "lagrange"),
        ("absolute", "RP", "lagrange"),
        ("absolute", "3R", "lagrange"),
    ],
)
def test_angles_are_those_of_the_notation(
    tmp_path: Path, angles: str, zero: str, robot: str, method: str
):
    """Every line is read as right where angles are those of the file, and the closed form is that
    of the model at θ = B φ + b."""
    model, file = fb.load(robot), own(tmp_path, angles, zero)
    told = fb.derive(model, method, notation=file)
    printed, places = lines(told), read_in_the_notes(robot, method)[0]
    chosen = [printed[k] for k in places] if angles == "relative" else printed[4:]
    assert [x for x in chosen[:-1] if not is_right(model, x, str(file))] == []
    assert "φ" in told.given
    assert not {"3.22", "5.15"} & {x for step in told.steps for x in step.notes}
    assert f"{zero}ward vertical" in told.given
    symbols = told.equations.symbols
    phi = np.array([0.4, 0.9, -0.3][: model.nv])
    turns = [body.kind.turns for body in model.bodies]
    first, q = True, phi.copy()
    for i, turning in enumerate(turns):
        if turning:
            q[i] += {"down": -np.pi / 2, "up": np.pi / 2}[zero] * first
            if angles == "absolute" and not first:
                q[i] = phi[i] - max((phi[k] for k in range(i) if turns[k]), key=list(phi).index)
            first = False
    M = fb.mass_matrix(model, q)
    B = np.eye(model.nv)
    if angles == "absolute":
        turning = [i for i, x in enumerate(turns) if x]
        for before, after in pairwise(turning):
            B[after, before] = -1.0
    found = symbols.evaluate(told.equations.M, phi)
    np.testing.assert_allclose(found, B.T @ M @ B, atol=1e-12)
    gravity = symbols.evaluate(told.equations.g, phi)
    np.testing.assert_allclose(gravity, B.T @ fb.gravity_torque(model, q), atol=1e-12)


def test_absolute_angles_are_refused_where_they_are_not_written_out(tmp_path: Path):
    file = own(tmp_path, "absolute")
    with pytest.raises(fb.FreebodyError, match=r"goes from joint to joint.*take 'lagrange'"):
        fb.derive(ARM, "newton-euler", notation=file)
    with pytest.raises(fb.FreebodyError, match="has joints without motor"):
        fb.derive(fb.load("acrobot"), "lagrange", notation=file)
    with pytest.raises(fb.FreebodyError, match="belong to robots in the plane"):
        fb.derive(fb.load("elbow_arm"), "lagrange", notation=file)
    with pytest.raises(fb.FreebodyError, match="torques are those of the joints"):
        fb.free_body_diagram(fb.load("2R"), notation=file)
    told = fb.derive(fb.load("2R"), "lagrange", notation=file)
    assert "sin φ₂" not in told.given  # its robot is told of in angles between links
    words = {row.words for row in told.glossary}
    assert {"angles of the bodies", "torques on the bodies"} <= words
    with pytest.raises(fb.FreebodyError, match="has angles or parameters of its own"):
        fb.equations(ARM).text(names=str(file))
    down = own(tmp_path, zero="down")
    steps = fb.derive(ARM, "kinematics", notation=down).steps
    assert not any("x² + y²" in step.text() for step in steps)  # solved for the joint's angle


def test_drawings_show_the_angles_of_the_notation(tmp_path: Path):
    q = [0.3, 0.5]
    arm = fb.load("2R")
    for angles, zero, sweeps in (
        ("relative", "down", (0.3 + np.pi / 2, 0.5)),
        ("absolute", "x axis", (0.3, 0.8)),
        ("absolute", "down", (0.3 + np.pi / 2, 0.8 + np.pi / 2)),
    ):
        figure = fb.kinematic_diagram(arm, q, notation=own(tmp_path, angles, zero))
        arcs = [figure.named(f"φ_{k}") for k in (1, 2)]
        assert [getattr(arc, "sweep", None) for arc in arcs] == pytest.approx(sweeps)
