"""Closed forms: every view has the kernels' values, the notes' 2R reads as the notes print it
(corrected)."""

from __future__ import annotations

import ctypes
import itertools
import math
import re
import shutil
import subprocess
import sys
import time
import xml.etree.ElementTree as ET
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.extras import extra
from support.helpers import numbers
from support.printed_values import evaluate
from support.robots import Joint, Link, Mimic, Robot, loaded, shift, turn
from support.symbolic import coupled

WORDS = ["".join(w) for n in (1, 2, 3) for w in itertools.product("RP", repeat=n)]
DRIVES = [
    fb.Drive(fb.Parameter("b1"), fb.Parameter("k1"), fb.Parameter("J1"), 10.0),
    fb.Drive(stiffness=fb.Parameter("s2"), rest=0.2),
    fb.Drive(viscous=0.3),
]
INERTIA = tuple(f"{{}}{axes}" for axes in ("xx", "xy", "xz", "yy", "yz", "zz"))


def planar(word: str, **changes: Any) -> fb.Model:
    """A planar word with values for all its parameters."""
    return with_values(fb.planar(word, **changes))


def with_values(model: fb.Model, seed: int = 0) -> fb.Model:
    """Values for the parameters that have none: products of inertia small, the rest about 1."""
    rng = np.random.default_rng(seed)
    small = ("xy", "xz", "yz")
    values = {
        name: rng.uniform(-0.1, 0.1) if name.endswith(small) else rng.uniform(0.6, 1.0)
        for name in model.missing
    }
    return model.bind(**values)


def spatial(seed: int, joints: int, named: bool) -> fb.Model:
    """A random arm in space, its table and inertias in numbers or by name."""
    rng = np.random.default_rng([seed, joints])
    rows = []
    for i in range(1, joints + 1):
        row: dict[str, Any] = {
            "joint": "RRP"[int(rng.integers(3))],
            "alpha": float(rng.choice([0.0, math.pi / 2, -math.pi / 2, rng.uniform(-3, 3)])),
            "theta": float(rng.choice([0.0, rng.uniform(-3, 3)])),
        }
        if named:
            row |= {"a": f"a{i}", "d": f"d0{i}", "m": f"m{i}", "com": [f"c{i}{x}" for x in "xyz"]}
            row["I"] = [name.format(f"I{i}") for name in INERTIA]
        else:
            row |= {
                "a": float(rng.normal()),
                "d": float(rng.normal()),
                "m": float(rng.uniform(0.5, 2)),
            }
            row |= {"com": rng.normal(size=3).tolist(), "I": [1.0, 0.1, 0.05, 1.2, -0.1, 0.9]}
            row |= {"friction": (0.4, 0.2), "rotor": 0.001, "gear": 30.0}
        rows.append(row)
    return with_values(fb.dh(rows, convention="standard", name=f"arm{seed}", physical="ignore"))


CALLED_AS_ENTRIES = [
    fb.Drive(stiffness=fb.Parameter("h", 3.0), viscous=fb.Parameter("H11", 0.7)),
    fb.Drive(stiffness=fb.Parameter("G_1", 2.0), viscous=fb.Parameter("c1", 0.6)),
]

MODELS = {
    **{word: planar(word) for word in WORDS},
    "RRR with drives": planar("RRR", drives=DRIVES),
    "called as entries": planar("RP", drives=CALLED_AS_ENTRIES),
    "PP at an angle": planar("PP", angles=[0.3, 0.4]),
    **{f"named {s}": spatial(s, 1 + s % 3, named=True) for s in range(6)},
    **{f"numbers {s}": spatial(s, 1 + s % 3, named=False) for s in range(6)},
}


def state(model: fb.Model, n: int = 3) -> tuple[np.ndarray, ...]:
    rng = np.random.default_rng(7)
    return tuple(rng.uniform(-2, 2, size=(n, model.nv)) for _ in range(3))


def values(eqs: Any, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> dict[str, Any]:
    return eqs.symbols.values(q, qd, qdd)


def close(a: Any, b: Any) -> None:
    """To 1e-12 of the largest entry."""
    a, b = np.broadcast_arrays(np.asarray(a, dtype=float), np.asarray(b, dtype=float))
    np.testing.assert_allclose(a, b, rtol=1e-12, atol=1e-12 * max(1.0, np.abs(b).max()))


@pytest.mark.parametrize("name", MODELS)
def test_polynomials_have_the_values_of_the_kernels(name: str) -> None:
    model = MODELS[name]
    eqs = fb.equations(model)
    q, qd, qdd = state(model)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    close(eqs.evaluate(eqs.tau, q, qd, qdd), tau)
    close(eqs.evaluate(eqs.M, q), numbers(model, "mass_matrix", q))
    close(eqs.evaluate(eqs.C, q, qd), numbers(model, "coriolis_matrix", q, qd))
    close(eqs.evaluate(eqs.g, q), numbers(model, "gravity_torque", q))
    close(eqs.evaluate(eqs.T, q, qd), numbers(model, "kinetic_energy", q, qd))
    close(eqs.evaluate(eqs.V, q), numbers(model, "potential_energy", q))


@pytest.mark.sample(12)
@pytest.mark.parametrize("name", MODELS)
def test_what_is_printed_has_the_values_of_the_kernels(name: str) -> None:
    model = MODELS[name]
    eqs = fb.equations(model)
    q, qd, qdd = state(model)
    at = values(eqs, q, qd, qdd)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    for (expanded,) in zip(*eqs.groups("expanded"), strict=True):
        i = int(expanded.lhs.name.removeprefix("tau")) - 1
        close(evaluate(expanded, at), tau[..., i])
    for i, row in enumerate(eqs.M):
        for j, x in enumerate(row):
            close(evaluate(eqs.form(x), at), numbers(model, "mass_matrix", q)[..., i, j])
    close(evaluate(eqs.form(eqs.T), at), numbers(model, "kinetic_energy", q, qd))


@pytest.mark.sample(32)
@pytest.mark.parametrize("names", ["notes", "standard"])
@pytest.mark.parametrize("name", MODELS)
def test_named_forms_have_the_values_of_the_kernels(name: str, names: str) -> None:
    model = MODELS[name]
    eqs = fb.equations(model)
    q, qd, qdd = state(model)
    known = values(eqs, q, qd, qdd)
    torques, *definitions = eqs.groups("named", names)
    for line in (line for group in definitions for line in group):
        value = evaluate(line, values(eqs, q, qd, qdd))
        known |= {side.name: value for side in line.sides[:-1]}
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    for i, line in enumerate(torques):
        close(evaluate(line, known), tau[..., i])


@pytest.mark.parametrize("name", [*MODELS, "ur5e", "puma560", "panda"])
def test_intermediates_have_the_values_of_the_kernels(name: str) -> None:
    model = MODELS[name] if name in MODELS else fb.load(name, physical="ignore")
    eqs = fb.equations(model)
    q, qd, qdd = state(model)
    known = values(eqs, q, qd, qdd)
    lines = eqs.intermediates()
    for line in lines:
        known[line.lhs.name] = evaluate(line, known)
    assert len({line.lhs.name for line in lines}) == len(lines)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    for i in range(model.nv):
        close(known[f"tau{i + 1}"], tau[..., i])


@pytest.mark.parametrize("name", MODELS)
def test_python_source(name: str) -> None:
    model = MODELS[name]
    space: dict[str, Any] = {}
    exec(fb.equations(model).python(), space)
    q, qd, qdd = (x[0] for x in state(model))
    M, c, G, tau = space["dynamics"](q.tolist(), qd.tolist(), qdd.tolist())
    close(M, numbers(model, "mass_matrix", q))
    close(c, numbers(model, "coriolis_matrix", q, qd) @ qd)
    close(G, numbers(model, "gravity_torque", q))
    close(tau, numbers(model, "inverse_dynamics", q, qd, qdd))


@pytest.mark.parametrize("name", ["RR", "RRR with drives", "RPR", "named 2", "numbers 5"])
@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc to compile the C source")
def test_c_source(name: str, tmp_path: Path) -> None:
    model = MODELS[name]
    eqs = fb.equations(model)
    n = model.nv
    call = (
        "const double *q, const double *qd, const double *qdd, double *M, double *c, double *G, "
        "double *tau"
    )
    first = "&defaults, " if eqs.parameters else ""
    wrapper = (
        f"void run({call}) {{ dynamics({first}q, qd, qdd, (double (*)[{n}])M, c, G, tau); }}\n"
    )
    (tmp_path / "arm.c").write_text(eqs.c_source() + wrapper)
    library = tmp_path / "arm.so"
    command = [
        "gcc",
        "-std=c99",
        "-Wall",
        "-Werror",
        "-O1",
        "-shared",
        "-fPIC",
        "arm.c",
        "-o",
        "arm.so",
        "-lm",
    ]
    subprocess.run(command, cwd=tmp_path, check=True)
    inputs = [np.ascontiguousarray(x[0]) for x in state(model)]
    outputs = [np.zeros((n, n)), np.zeros(n), np.zeros(n), np.zeros(n)]
    pointer = ctypes.POINTER(ctypes.c_double)
    ctypes.CDLL(str(library)).run(*(x.ctypes.data_as(pointer) for x in (*inputs, *outputs)))
    q, qd, qdd = inputs
    close(outputs[0], numbers(model, "mass_matrix", q))
    close(outputs[3], numbers(model, "inverse_dynamics", q, qd, qdd))


@pytest.mark.parametrize("name", ["RR", "RRR with drives", "PRP", "named 1", "numbers 1"])
def test_sympy(name: str) -> None:
    sympy = extra("sympy", "SymPy")
    model = MODELS[name]
    eqs = fb.equations(model)
    q, qd, qdd = (x[:1] for x in state(model))
    at = {k: float(np.ravel(v)[0]) for k, v in values(eqs, q, qd, qdd).items()}
    matrices = eqs.to_sympy()
    symbols = sympy.symbols(list(at), real=True)
    for key, expected in (
        ("M", numbers(model, "mass_matrix", q)[0]),
        ("C", numbers(model, "coriolis_matrix", q, qd)[0]),
        ("tau", numbers(model, "inverse_dynamics", q, qd, qdd)[0][:, None]),
        ("V", numbers(model, "potential_energy", q)[0]),
    ):
        close(sympy.lambdify(symbols, matrices[key])(*at.values()), expected)


# ---------------------------------------------------------------- how it reads
def test_2r_reads_as_the_notes() -> None:
    assert fb.equations(fb.planar("RR")).text() == (
        "τ₁ = H₁₁ θ̈₁ + H₁₂ θ̈₂ − h θ̇₂² − 2 h θ̇₁ θ̇₂ + G₁\n"  # (3.20)
        "τ₂ = H₂₁ θ̈₁ + H₂₂ θ̈₂ + h θ̇₁² + G₂\n"  # (3.21)
        "\n"
        "H₁₁ = m₁ lc₁² + I₁ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂\n"  # (3.22), corrected
        "H₂₂ = m₂ lc₂² + I₂\n"  # (3.23), corrected
        "H₁₂ = H₂₁ = m₂ (lc₂² + l₁ lc₂ cos θ₂) + I₂\n"  # (3.24), corrected
        "\n"
        "h = m₂ l₁ lc₂ sin θ₂\n"  # (3.25)
        "\n"
        "G₁ = m₁ g lc₁ cos θ₁ + m₂ g (l₁ cos θ₁ + lc₂ cos(θ₁+θ₂))\n"  # (3.26)
        "G₂ = m₂ g lc₂ cos(θ₁+θ₂)"  # (3.27)
    )


@pytest.mark.parametrize(
    ("word", "lines"),
    [
        ("R", ["τ₁ = H₁₁ θ̈₁ + G₁", "H₁₁ = m₁ lc₁² + I₁", "G₁ = m₁ g lc₁ cos θ₁"]),
        (
            "RP",
            [
                "τ₁ = H₁₁ θ̈₁ + 2 h θ̇₁ ḋ₂ + G₁",
                "H₁₁ = m₁ lc₁² + I₁ + m₂ (l₁ + d₂ + lc₂)² + I₂",
                "G₂ = m₂ g sin θ₁",
            ],
        ),
        (
            "PR",
            [
                "τ₂ = H₂₁ d̈₁ + H₂₂ θ̈₂ + G₂",
                "H₁₁ = m₁ + m₂",
                "H₁₂ = H₂₁ = −m₂ lc₂ sin θ₂",
                "h = m₂ lc₂ cos θ₂",
            ],
        ),
        (
            "RRR",
            [
                "h₃ = m₃ l₂ lc₃ sin θ₃",
                "τ₃ = H₃₁ θ̈₁ + H₃₂ θ̈₂ + H₃₃ θ̈₃ + h₂ θ̇₁² + h₃ θ̇₂² + 2 h₃ θ̇₁ θ̇₂ + G₃",
            ],
        ),
        ("PP", ["τ₁ = H₁₁ d̈₁", "τ₂ = H₂₂ d̈₂ + G₂", "H₂₂ = m₂", "G₂ = m₂ g"]),
    ],
)
def test_planar_arms_read_well(word: str, lines: list[str]) -> None:
    text = fb.equations(fb.planar(word)).text().splitlines()
    assert [line for line in lines if line not in text] == []


def test_expanded_and_standard_names() -> None:
    eqs = fb.equations(fb.planar("RR"))
    expanded = eqs.text("expanded", width=400)
    assert "+ (m₂ lc₂² + I₂) θ̈₂ + m₂ l₁ lc₂ sin(θ₂) θ̇₁² + m₂ g lc₂ cos(θ₁+θ₂)" in expanded
    standard = eqs.text(names="standard")
    assert "τ₁ = M₁₁ θ̈₁ + M₁₂ θ̈₂ + c₁ + g₁" in standard
    assert "c₁ = −m₂ l₁ lc₂ sin(θ₂) θ̇₂² − 2 m₂ l₁ lc₂ sin(θ₂) θ̇₁ θ̇₂" in standard
    assert str(eqs.form(eqs.T)).startswith("½ (m₁ lc₁² + I₁ + m₂ (")


def test_drives_stand_beside_the_rest() -> None:
    text = fb.equations(planar("RRR", drives=DRIVES)).text()
    assert "+ G₁ + b₁ θ̇₁ + k₁ sgn(θ̇₁)" in text
    assert "H₁₁ = m₁ lc₁² + I₁" in text
    assert "+ 100 J₁" in text


def test_numbers() -> None:
    eqs = fb.equations(fb.load("2R"), numbers=True)
    assert "H₁₁ = 5.64 + 2.4 cos θ₂" in eqs.text()
    assert "G₂ = 11.772 cos(θ₁+θ₂)" in eqs.text()
    assert eqs.parameters == {}
    some = fb.equations(fb.planar("RR")).substitute(l1=0.5, I2=0)
    assert "H₂₂ = m₂ lc₂²" in some.text().splitlines()
    assert "h = 0.5 m₂ lc₂ sin θ₂" in some.text()
    with pytest.raises(fb.UnknownNameError, match="Did you mean 'l1'"):
        fb.equations(fb.planar("RR")).substitute(l11=2)
    with pytest.raises(fb.MissingValueError, match="I1"):
        fb.equations(fb.planar("RR"), numbers=True)


def test_parallel_axes_are_gathered() -> None:
    eqs = fb.equations(fb.load("puma560", physical="ignore"), numbers=True)
    line = next(
        line for line in eqs.text("named", width=10**6).splitlines() if line.startswith("H₁₆")
    )
    assert line == "H₁₆ = H₆₁ = 4·10⁻⁵ cos(θ₂+θ₃) cos θ₅ − 4·10⁻⁵ sin(θ₂+θ₃) cos θ₄ sin θ₅"


def test_squares_and_products_in_space() -> None:
    rows = [{"alpha": math.pi / 2, "m": "m1", "I": ["I1xx", 0, 0, "I1yy", 0, "I1zz"]}]
    rows += [{"a": "a2", "m": "m2", "com": ["c2x", 0, 0], "I": ["I2xx", 0, 0, "I2yy", 0, "I2zz"]}]
    eqs = fb.equations(fb.dh(rows, convention="standard"))
    assert (
        str(eqs.form(eqs.M[0][0])) == "I₁yy + m₂ (a₂ + c₂x)² cos² θ₂ + I₂xx sin² θ₂ + I₂yy cos² θ₂"
    )


def test_an_arm_in_space_reads_well() -> None:
    rows: list[dict[str, Any]] = [
        {"alpha": math.pi / 2, "m": "m1", "I": ["I1xx", 0, 0, "I1yy", 0, "I1zz"]}
    ]
    for i in (2, 3):
        row = {"a": f"a{i}", "m": f"m{i}", "com": [f"c{i}x", 0, 0]}
        rows.append({**row, "I": [f"I{i}xx", 0, 0, f"I{i}yy", 0, f"I{i}zz"]})
    text = fb.equations(fb.dh(rows, convention="standard")).text(width=400).splitlines()
    assert (
        "H₁₁ = I₁yy + m₂ (a₂ + c₂x)² cos² θ₂ + I₂xx sin² θ₂ + I₂yy cos² θ₂"
        " + m₃ (a₂² cos² θ₂ + 2 a₂ (a₃ + c₃x) cos θ₂ cos(θ₂+θ₃) + (a₃ + c₃x)² cos²(θ₂+θ₃))"
        " + I₃xx sin²(θ₂+θ₃) + I₃yy cos²(θ₂+θ₃)"
    ) in text
    assert "G₂ = m₂ g (a₂ + c₂x) cos θ₂ + m₃ g (a₂ cos θ₂ + (a₃ + c₃x) cos(θ₂+θ₃))" in text


def test_long_equations_say_so() -> None:
    eqs = fb.equations(fb.load("puma560", physical="ignore"))
    assert str(eqs).startswith("puma560: M has ")
    assert "too long to read" in eqs.text()
    assert "view='intermediates'" in eqs.text()
    assert eqs.count() == {"M": 165, "c": 729, "g": 24}
    assert 100 < len(eqs.text("intermediates").splitlines()) < 180


def test_operations_are_counted() -> None:
    eqs = fb.equations(fb.planar("R"))  # τ = H θ̈ + G, H = m lc² + I, G = m g lc cos θ
    assert eqs.operations() == {"additions": 2, "multiplications": 6, "functions": 1}
    puma = fb.equations(fb.load("puma560", physical="ignore"))
    assert puma.operations("intermediates")["multiplications"] < 400


def test_views_and_names_are_checked() -> None:
    eqs = fb.equations(fb.planar("R"))
    with pytest.raises(fb.UnknownNameError, match="Did you mean 'expanded'"):
        eqs.text("expand")
    with pytest.raises(fb.UnknownNameError, match=r"no naming 'other'.*Namings: notes, standard"):
        eqs.text(names="other")


# ---------------------------------------------------------------- what has no closed form, and
# joints that follow
def following(ratio: float, kind: str = "revolute", base: str = "fixed") -> fb.Model:
    """Two links, the second joint follows the first."""
    bar = fb.Inertia(fb.Parameter("m1"), (0.5, 0.0), (fb.Parameter("I1"),))
    links = (
        Link("base", fb.Inertia(2.0, (0.1, 0.0), (0.3,)) if base == "free" else None),
        Link("a", bar),
        Link("b", fb.Inertia(fb.Parameter("m2"), (0.3, 0.0), (fb.Parameter("I2"),))),
    )
    axis = (1.0,) if kind == "revolute" else (1.0, 0.0)
    joints = (
        Joint("first", "revolute", "base", "a", axis=(1.0,), drive=fb.Drive(coulomb=0.3)),
        Joint(
            "second",
            kind,
            "a",
            "b",
            shift(fb.Parameter("l1"), 0.0).then(turn("z", 0.2)),
            axis,
            drive=fb.Drive(0.1, 0.2),
            mimic=Mimic("first", ratio, 0.1),
        ),
    )
    return with_values(loaded(Robot("gears", 2, links, joints, (9.81, (0.0, -1.0))), base=base))


@pytest.mark.parametrize(
    ("ratio", "kind", "base"),
    [(2.0, "revolute", "fixed"), (-1.0, "revolute", "free"), (0.5, "prismatic", "fixed")],
)
def test_following_joints(ratio: float, kind: str, base: str) -> None:
    model = following(ratio, kind, base)
    eqs = fb.equations(model)
    q, qd, qdd = state(model)
    expected = numbers(model, "inverse_dynamics", q, qd, qdd)
    close(eqs.evaluate(eqs.tau, q, qd, qdd), expected)
    at = values(eqs, q, qd, qdd)
    line = eqs.groups("expanded")[0][-1]
    close(evaluate(line, at), expected[..., -1])
    for step in eqs.intermediates():
        at[step.lhs.name] = evaluate(step, at)
    close(at[f"tau{model.nv}"], expected[..., -1])


def test_following_by_a_fraction_is_refused() -> None:
    with pytest.raises(
        fb.FreebodyError,
        match=r"joint 'second' of 'gears' turns 0.5 times as far as 'first'.*mimic=.free.",
    ):
        fb.equations(following(0.5))
    turned = coupled(fb.planar("RR"), joint2=("joint1", 1.0, 0.2))
    assert "1.96013 lc₂ cos 2θ₁" in str(fb.equations(turned))  # twice the cosine of 0.2
    swapped = coupled(fb.planar("PR"), joint2=("joint1", 2.0, 0.0))
    with pytest.raises(fb.FreebodyError, match=r"turns as 'joint1' slides: .*turning joint lead"):
        fb.equations(swapped)


def test_joints_without_closed_form_are_refused() -> None:
    with pytest.raises(
        fb.FreebodyError, match="is free: closed forms need coordinates that are numbers"
    ):
        fb.equations(fb.load("quadrotor"))


# ---------------------------------------------------------------- other programs read it
@pytest.mark.parametrize("name", ["RR", "RRR with drives", "named 2", "numbers 2"])
def test_mathml_is_well_formed(name: str) -> None:
    eqs = fb.equations(MODELS[name])
    for view in ("named", "expanded", "intermediates"):
        root = ET.fromstring(eqs.mathml(view))
        assert root.tag == "{http://www.w3.org/1998/Math/MathML}math"


def test_a_leading_minus_in_mathml_is_a_sign() -> None:
    """Not infix, which browsers take a minus behind a bracket for, and set with space around it."""
    text = fb.equations(MODELS["RR"]).mathml("expanded")
    assert "−</mo>" in text
    assert not re.findall(r"(?:\(</mo>|<mrow>|<mtd>|^)<mo>−</mo>", text)
    assert '<mo form="prefix">−</mo>' in fb.derive(fb.planar("RP"), "newton-euler").html()


@pytest.mark.skipif(shutil.which("pdflatex") is None, reason="needs pdflatex")
def test_latex_compiles_and_fits(tmp_path: Path) -> None:
    body = []
    for name in ("RR", "RPR", "RRR with drives", "named 2", "numbers 2"):
        eqs = fb.equations(MODELS[name])
        body += [
            eqs.latex(view, environment="align*") for view in ("named", "expanded", "intermediates")
        ]
        body += [f"$${eqs.latex()}$$"]
    long = fb.equations(fb.load("puma560", physical="ignore"))
    body += [f"$${long.latex()}$$", long.latex("intermediates", environment="align*")]
    (tmp_path / "page.tex").write_text(
        "\\documentclass{article}\\usepackage{amsmath}\\usepackage[a4paper,margin=2cm]{geometry}\n"
        "\\allowdisplaybreaks\\begin{document}\n" + "\n".join(body) + "\\end{document}\n"
    )
    command = ["pdflatex", "-interaction=nonstopmode", "-halt-on-error", "page.tex"]
    run = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, errors="replace")
    assert run.returncode == 0, run.stdout[-2000:]
    assert "Overfull \\hbox" not in run.stdout


def test_without_sympy_the_error_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sympy", None)
    with pytest.raises(ImportError) as refused:
        fb.equations(fb.planar("R")).to_sympy()
    message = "to_sympy: SymPy is not installed; pip install 'freebody[sympy]'."
    assert str(refused.value) == message
    assert isinstance(refused.value, fb.FreebodyError)


def test_sympy_is_imported_only_when_asked_for() -> None:
    code = (
        "import sys, freebody as fb; fb.equations(fb.planar('RR')).text(); "
        "assert 'sympy' not in sys.modules"
    )
    subprocess.run([sys.executable, "-c", code], check=True)


def test_coordinates_by_name() -> None:
    symbols = fb.equations(fb.planar("RPR")).symbols
    assert symbols.coordinates == ("theta1", "d2", "theta3")
    assert "theta1_d" in symbols.ring.names
    assert "d2_dd" in symbols.ring.names


def test_an_arm_of_many_joints_is_told_to_be_too_long_at_once() -> None:
    """The mass matrix of 14 joints has 721629 terms, which took 42 s and 3.5 GB to count with the
    rest."""
    start = time.process_time()
    eqs = fb.equations(fb.planar("R" * 14).replace(name="50%_#"))
    assert r"\text{50\%\_\#: M alone" in eqs.latex()
    for shown in (str(eqs), eqs.latex(), eqs._repr_latex_(), eqs.mathml()):
        assert "M alone has more than 2000 terms: too long to read" in shown
    assert time.process_time() - start < 5.0


def test_what_is_counted_from_the_tip_is_the_mass_matrix() -> None:
    """Long is what has more terms, not more joints: slides stay short, and the bound is that of M
    itself."""
    assert not fb.equations(fb.planar("P" * 14)).is_vast
    for joints in range(2, 9):
        eqs = fb.equations(fb.planar("R" * joints))
        assert eqs.is_vast == (eqs.count()["M"] > 2000)


@pytest.mark.parametrize("word", ["R", "RR", "RP", "PRR"])
@pytest.mark.parametrize("seed", range(3))
def test_one_parameter_may_be_a_mass_and_a_length_and_a_moment_of_inertia(word: str, seed: int):
    """As where a file's author calls everything a: what is left of a power of a mass stands in the
    rest."""
    rng = np.random.default_rng(seed)
    drawn = {
        key: list(rng.choice(["a", "b"][: 1 + seed], len(word))) for key in ("l", "lc", "m", "I")
    }
    arm = fb.planar(word, **{key: [str(x) for x in names] for key, names in drawn.items()})
    values = {name: float(rng.uniform(0.5, 2.0)) for name in arm.parameters if name != "g"}
    q, qd, qdd = rng.uniform(-1.0, 1.0, (3, len(word)))
    scope: dict = {}
    exec(fb.equations(arm.bind(**values)).python(), scope)
    M, *_ = scope["dynamics"](q, qd, qdd)
    np.testing.assert_allclose(M, fb.mass_matrix(arm.bind(**values), q), rtol=1e-12, atol=1e-12)


def test_a_parameter_that_is_called_like_a_sine_is_refused_by_name():
    with pytest.raises(
        fb.FreebodyError, match="the name 'sin_theta1' stands for two quantities; rename"
    ):
        str(fb.equations(fb.planar("RR", m=["sin_theta1", "m2"])))
