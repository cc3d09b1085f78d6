"""Parameters that follow from others: lc1 = l1/2 below [parameters] of a robot's file."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.page_data import page_data
from support.robots import loaded

RODS = """
name = "rods"
[planar]
word = "RRR"
[parameters]
l1 = 1
l2 = 0.8
l3 = "l2/2"
m = "rho*A*l"
rho = 7850
A = "π*r²"
r = 0.01
lc = "l/2"
I = "m l²/12"
"""
Q, QD, QDD = (0.3, -0.7, 1.1), (1.0, 0.4, -0.6), (0.5, 2.0, -1.0)


def in_numbers(l1: float = 1.0, l2: float = 0.8, r: float = 0.01, rho: float = 7850.0) -> fb.Model:
    """The same arm as it is without formulas."""
    lengths = np.array([l1, l2, l2 / 2])
    masses = rho * np.pi * r**2 * lengths
    inertias = masses * lengths**2 / 12
    return fb.planar("RRR", l=lengths.tolist(), lc=(lengths / 2).tolist(), m=masses.tolist(),
                     I=inertias.tolist())  # fmt: skip


def torque(model: fb.Model, **how: Any) -> np.ndarray:
    return np.asarray(fb.inverse_dynamics(model, Q, QD, QDD, **how))


CHANGES = [{}, {"l1": 1.7}, {"l2": 0.5, "r": 0.02}, {"rho": 2700.0, "l1": 0.2}]


# ---------------------------------------------------------------- numbers follow
@pytest.mark.parametrize("changed", CHANGES)
def test_what_a_formula_gives_follows_what_it_names(changed: dict[str, float]):
    """By bind, as a member of a family, as an input of a kernel, and by a change of a change."""
    rods, expected = loaded(RODS), torque(in_numbers(**changed))
    assert torque(rods.bind(changed)) == pytest.approx(expected, rel=1e-12)
    columns = {name: np.array([0.4, value]) for name, value in changed.items()}
    if columns:
        assert torque(rods.bind(columns)[1]) == pytest.approx(expected, rel=1e-12)
        assert torque(rods.bind(columns))[1] == pytest.approx(expected, rel=1e-12)
    kernel = fb.kernel(rods, "inverse_dynamics", inputs=["l?", "rho", "r"])
    assert kernel.parameters == ("l1", "l2", "r", "rho")
    assert kernel(Q, QD, QDD, p=changed) == pytest.approx(expected, rel=1e-12)
    model = rods
    for name, value in {"l1": 3.0, "r": 0.5, **changed}.items():
        for x in (0.9, value):
            model = model.bind({name: x})
    back = {"l1": 1.0, "r": 0.01} | changed
    assert torque(model.bind(back)) == pytest.approx(expected, rel=1e-12)


def test_inputs_of_a_family_and_derivatives_follow():
    rods = loaded(RODS)
    family = rods.bind(l1=np.array([0.5, 1.5]))
    kernel = fb.kernel(family, "inverse_dynamics", inputs=["l2"])
    assert kernel.parameters == ("l1", "l2")
    found = kernel(Q, QD, QDD, p={"l2": 0.6})
    expected = [torque(in_numbers(l1=x, l2=0.6)) for x in (0.5, 1.5)]
    assert found == pytest.approx(np.array(expected), rel=1e-12)
    _, slope = fb.kernel(rods, "inverse_dynamics", inputs=["l1"], by=["p"])(Q, QD, QDD)
    h = 1e-6
    rise = torque(in_numbers(l1=1 + h)) - torque(in_numbers(l1=1 - h))
    assert np.ravel(slope) == pytest.approx(rise / (2 * h), rel=1e-6)


def test_a_sweep_goes_over_what_formulas_name():
    with pytest.raises(fb.FreebodyError, match=r"'lc1' follows from l1/2; name what it follows"):
        fb.sweep(loaded(RODS), "gravity_torque", over={"lc1": [0.5, 1.5]}, at={"q": Q})


def test_in_space_angles_follow_too():
    text = """
    [dh]
    convention = "standard"
    rows = [{ d = "d1", alpha = "tilt", m = 3, com = [0, "c1y", 0] }, { a = 0.4, m = 2 }]
    [parameters]
    d1 = 0.3
    half = "40 deg"
    tilt = "2*half"
    c1y = "-d1/2"
    """
    arm = loaded(text).bind(d1=0.5, half=0.6)
    rows = [{"d": 0.5, "alpha": 1.2, "m": 3, "com": [0, -0.25, 0]}, {"a": 0.4, "m": 2}]
    plain = fb.dh(rows, convention="standard")
    found = fb.inverse_dynamics(arm, Q[:2], QD[:2], QDD[:2])
    assert found == pytest.approx(fb.inverse_dynamics(plain, Q[:2], QD[:2], QDD[:2]), rel=1e-12)
    equations = fb.equations(arm)  # half is in no equation, tilt is
    assert {"half", "tilt"} <= set(equations.parameters) | {"half"}
    tau = equations.symbols.evaluate(equations.tau, *(np.array(x[:2]) for x in (Q, QD, QDD)))
    assert tau == pytest.approx(found, rel=1e-12)


def test_numbers_without_values_wait_for_them():
    arm = fb.planar("RR").bind(lc="l/2", I="m*l^2/12")
    assert arm.missing == ("l1", "l2", "m1", "m2")
    known = arm.with_payload(fb.Inertia(fb.Parameter("m1", 2.0), (0, 0), (0,)))
    assert known.bind(l1=3, l2=1, m2=1).parameters["I1"] == 1.5
    with pytest.raises(fb.FreebodyError, match=r"need a value for l1, l2, m1, m2\."):
        fb.gravity_torque(arm, [0, 0])


def test_a_number_is_not_put_where_a_formula_gives_it():
    rods = loaded(RODS)
    with pytest.raises(
        fb.FreebodyError, match=r"lc1 follows from l1/2; .* set it free first: bind\(lc1='lc1'\)"
    ):
        rods.bind(lc1=0.3)
    with pytest.raises(fb.FreebodyError, match="lc1 follows from l1/2"):
        rods.bind({"link1.com.x": 0.3})
    free = rods.bind(lc1="lc1")
    assert free.parameters["lc1"] == 0.5
    assert free.bind(l1=2, lc1=0.3).parameters["lc1"] == 0.3
    assert rods.bind(lc1="0.3").bind(l1=2).parameters["lc1"] == 0.3
    assert rods.bind(lc1="l1/4").bind(l1=2).parameters["lc1"] == 0.5
    own = fb.planar("RRR", l=[1, 1, 1]).bind(lc="l/4", lc1=0.3, lc2="l2/2", I="0", I1="lc1")
    assert [own.parameters[x] for x in ("lc1", "lc2", "lc3", "I1", "I3")] == [
        0.3,
        0.5,
        0.25,
        0.3,
        0,
    ]
    told = {x.name: x.formula for x in fb.parameters(rods) if x.formula}
    assert told["lc1"] == "l1/2"
    assert told["I3"] == "m3 l3²/12"
    assert "l1" not in told
    assert "= l1/2" in repr(fb.parameters(rods))


def test_formulas_stay_with_the_model(tmp_path: Path):
    rods = loaded(RODS)
    fb.save(rods, tmp_path / "rods.toml")
    again = fb.load(tmp_path / "rods.toml")
    assert again == rods
    assert hash(again) == hash(rods)
    assert pickle.loads(pickle.dumps(rods)) == rods != in_numbers()
    assert torque(again.bind(l1=1.7)) == pytest.approx(torque(in_numbers(l1=1.7)), rel=1e-12)
    # what nothing uses any more is not saved
    fb.save(rods.with_inertial_parameters(fb.inertial_parameters(rods)), tmp_path / "pi.toml")
    assert set(fb.load(tmp_path / "pi.toml").parameters) == {"l1", "l2", "l3", "g"}


# ---------------------------------------------------------------- in symbols
@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "lagrange"])
def test_derivations_put_formulas_in(method: str):
    arm = fb.planar("RR").bind(lc="l/2", I="m*l**2/12")
    given = {"lc": "l/2", "I": "m*l**2/12"}
    told, other = fb.derive(arm, method), fb.derive(fb.planar("RR"), method, parameters=given)
    assert "I₁ = 1/12 m₁ l₁², I₂ = 1/12 m₂ l₂², lc₁ = ½ l₁ and lc₂ = ½ l₂." in told.given
    assert [str(x) for x in told.tau] == [str(x) for x in other.tau]
    if method == "lagrange":
        sliders = {x["name"] for x in page_data(told.html())["inputs"]}
        assert "l1" in sliders
        assert "lc1" not in sliders
    kept = fb.derive(arm, method, parameters={"lc": "lc", "I2": 0})
    assert str(fb.derive(fb.planar("RR"), method, parameters={"I2": 0, "I1": given["I"].replace(
        "m", "m1").replace("l", "l1")}).tau) == str(kept.tau)  # fmt: skip


def test_equations_relations_and_checks_put_formulas_in():
    arm = loaded(RODS).bind(m="m")
    equations = fb.equations(arm)
    assert "H₃₃ = ⅓ m₃ l₃²" in str(fb.equations(arm.bind(l3="l3")))
    assert set(equations.parameters) == {"l1", "l2", "m1", "m2", "m3", "g"}
    states = (np.array(x) for x in (Q, QD, QDD))
    found = equations.symbols.evaluate(equations.tau, *states)
    assert found == pytest.approx(torque(in_numbers()), rel=1e-12)
    assert "l_c" not in equations.text("intermediates")
    assert fb.relation(fb.quantities(arm), "I3 = m3*l2**2/48")
    for line in ("H33 = m3*lc3**2 + I3", "H33 = m3*l3**2/3", "H33 = m3*l2^2/12"):
        assert fb.check(arm, line), line
    wrong = fb.check(arm, "H33 = m3*l3**2/2")
    assert not wrong
    assert "must be multiplied by 2/3" in wrong.text
    assert not fb.check(arm, "H33 = m3*l3**2/3", parameters={"lc": "l"})


@pytest.mark.parametrize(
    ("line", "is_right", "words"),
    [
        ("I1 = m1*l1^2/12", True, "I1 is right."),
        ("I_1 = m_1 l_1^2/3", False, "about the joint, I₁ + m₁ lc₁²; I₁ is about the centre"),
        ("lc2 = l2", False, "lc2, which a formula gives, is not right."),
        ("I1 = 0.5 kg m^2", True, "With the values of"),
        (
            "I1 = 2.0 kg m^2\nT1 = 1/2 I1 dtheta1^2",
            False,
            "T1, the kinetic energy of body 1,",
        ),
    ],
)
def test_what_a_formula_gives_is_checked(line: str, is_right: bool, words: str):
    arm = fb.planar("RR", l=[2, 1], m=[1.5, 1]).bind(lc="l/2", I="m*l^2/12")
    verdict = fb.check(arm, line)
    assert bool(verdict) is is_right
    assert words in verdict.text


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("lines", "words"),
    [
        ('lc1 = "l1/"', "8: [parameters]: lc1 = 'l1/': the end stands where a number, a name or a"),
        ('lc1 = "lc2"\nlc2 = "lc1"', "it is circular, lc2 from lc1 from lc2; give one of them a"),
        ('lc1 = "lc1"', "it is circular, lc1 from lc1"),
        ('lc1 = "k*l1"', "8: [parameters]: lc1 = 'k*l1': no parameter 'k' in the model."),
        ('lc1 = "l1/0"', "it divides by 0."),
        ('lc1 = "1/(l1-l1)"', "it divides by 0."),
        ('lc1 = "1/l1"', "divides by a parameter; a formula is a polynomial and divides by"),
        ('lc1 = "sqrt(-2)*l1"', "sqrt of -2 is no number."),
        ('lc1 = "sin(l1)"', "it takes sin of a parameter; a formula is a polynomial"),
        ('lc1 = "l1**0.5"', "0.5 stands where a whole number as power is expected"),
        ('lc1 = "1e70*l1"', "a number in it is above 1e+60"),
        ('lc1 = "1e59*l1**40"', "the power 40 is above 12"),
        ('lc1 = "(l1+l2+m1+m2)^12"', "it has more than 200 terms"),
        (f'lc1 = "{"(" * 60}l1{")" * 60}"', "more than 50 brackets stand inside one another"),
        (f'lc1 = "{"l1+" * 400}l1"', "at most 1000 are read"),
        ('lc1 = "__import__(\'os\')"', '"\'" has no meaning in it'),
        ('I = "m*(l-2)"', "8: [parameters]: I1 = 'm1*(l1-2)': it is −1 with the values of 'robot'"),
        ('I1 = "200 g"', "a number with a unit; numbers are in SI units and without one, and a"),
        ('m3 = "l1"', "8: no parameter 'm3' in the model. Did you mean"),
        ('k = 2', "8: no parameter 'k' in the model."),
        ('lc = "l/2"\nlc1 = 1\nlc2 = 1', "lc is that of no link, as lc1 and lc2 have their own."),
        ('lc1 = "9e59*l2"', "8: [parameters]: lc1 = '9e59*l2': parameter 'lc1': 9e+61 is"),
    ],
)  # fmt: skip
def test_a_formula_that_cannot_be_is_refused(lines: str, words: str):
    text = "[planar]\nword = 'RR'\n[parameters]\nl1 = 1\nl2 = 1e2\nm1 = 1\nm2 = 3\n"
    with pytest.raises(fb.FreebodyError) as refusal:
        loaded(text + lines)
    assert words in str(refusal.value)


def test_what_becomes_negative_later_is_refused():
    arm = fb.planar("RR", l=[1, 1], m=[1, 1]).bind(lc="l/2", I="m*(2-l)")
    with pytest.raises(fb.FreebodyError, match=r"link 'link1': moment of inertia -1 .* negative"):
        arm.bind(l1=3)
    with pytest.raises(fb.FreebodyError, match="I1' = '-m1': it is −1 with the values of 'RR'"):
        arm.bind(I1="-m1")
    with pytest.raises(fb.FreebodyError, match="it is negative; a mass is never negative"):
        fb.planar("RR").bind(m1="-2*m2")
    with pytest.raises(fb.FreebodyError, match=r"1e\+90 is too large"):
        arm.bind(I1="m1**9").bind(m1=1e10)


def test_a_formula_is_for_a_parameter_with_a_name():
    arm = fb.load("2R")
    with pytest.raises(fb.FreebodyError, match=r"no parameter 'joint1\.friction\.viscous'"):
        arm.bind({"joint1.friction.viscous": "m1"})
    assert arm.bind({"joint1.friction.viscous": "1/4"}).bodies[0].joint.drive.viscous == 0.25


# ---------------------------------------------------------------- commands
def test_commands_take_other_numbers(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    file = tmp_path / "rods.toml"
    file.write_text(RODS, encoding="utf-8")
    over = ["gravity_torque", "--states", "3", "--over", "l1=1:2:2"]

    def said(*arguments: str, status: int = 0) -> str:
        assert run([*arguments]) == status
        out = capsys.readouterr()
        return " ".join((out.out + out.err).split())

    shown = said("show", str(file), "--parameter", "r=0.02", "--parameter", "lc1=0.2")
    assert "21.7021 kg" in shown
    assert "formulas: A = π*r², l3 = l2/2, lc2 = l2/2" in shown
    assert "note: given by --parameter in the place of the file's: r = 0.02, lc1 = 0.2." in shown
    light = said("sweep", str(file), *over, "--parameter", "rho=1")
    assert said("sweep", str(file), *over) != light
    assert "set it free first" in said(
        "sweep", str(file), "gravity_torque", "--over", "lc1=1:2:2", status=2
    )
    assert "no parameter 'l9' in 'rods'" in said(
        "study", str(file), "--parameter", "l9=1", status=2
    )
    assert "write a name, =, and what it stands for, such as l1=0.5" in said(
        "fbd", str(file), "--parameter", "l9", status=2
    )


def test_a_difference_that_is_0_now_is_put_in_all_the_same():
    """Else equations would hold for these values only, and sliders of pages be wrong."""
    arm = fb.planar("R", l=[1], m=[2], I=["e"]).bind(l1=1, m1=2, lc1=1, e=0).bind(e="l1-lc1")
    assert arm.parameters["e"] == 0
    assert "H₁₁ = m₁ lc₁² + l₁ − lc₁" in str(fb.equations(arm))
    assert fb.check(arm, "H11 = m1*lc1**2 + l1 - lc1")
    assert fb.check(arm, "H11 = m1*lc1**2 + e")
    assert not fb.check(arm, "H11 = m1*lc1**2")
