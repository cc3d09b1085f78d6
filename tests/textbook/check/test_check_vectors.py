"""Vector and matrix equations in answers, and everything that `fb.quantities` knows."""

from __future__ import annotations

import math
from typing import Any

import pytest

import freebody as fb

ARM = fb.planar("RR")

RIGHT = [
    "tau = M q̈ + C q̇ + g",
    r"M(q)\ddot{q} + C(q,\dot{q})\dot{q} + g(q) = \tau",
    r"\tau = M(\Theta)\ddot\Theta + V(\Theta,\dot\Theta) + G(\Theta)",
    r"T = \frac12 \dot{q}^T M(q) \dot{q}",
    "T2 = ½ m2 vc2^2 + ½ I2 ω2²",
    r"T_1 = \tfrac12 m_1 v_{c1}^{\top} v_{c1} + \tfrac12 I_1 \omega_1^2",
    r"\begin{bmatrix} \tau_1 \\ \tau_2 \end{bmatrix} = M \ddot q + C\dot q + g",
    r"c = C \dot q",
    "h = m2 l1 lc2 s2; tau = M q̈ + h [-2 θ̇1 θ̇2 - θ̇2²; θ̇1²] + G",
    "vc1 = ω1 × rc1",
    "v_2^2 = l1^2 θ̇1^2",
    r"T_2 = \frac12 m_2 v_{2}^{2} + m_2 v_2 · (ω_2 × s_c2) + \frac12 (I_2 + m_2 l_{c2}^2) ω_2²",
    "vc2 = v2 + cross(ω2, sc2)",
    "fc2 = m2 vc2_d",
    "f12 = fc2 - m2 gravity",
    "[v_x; v_y] = [-l1 s1 θ̇1 - l2 s12 (θ̇1+θ̇2); l1 c1 θ̇1 + l2 c12 (θ̇1+θ̇2)]",
    r"J_P = \begin{bmatrix} -l_1 s_1 - l_2 s_{12} & -l_2 s_{12} \\"
    r" l_1 c_1 + l_2 c_{12} & l_2 c_{12} \end{bmatrix}",
    "r_d = J_P q̇",
    "c112 = m2 l1 lc2 s2",
    r"\Gamma_{112} = -m_2 l_1 l_{c2} s_2",
]


@pytest.mark.sample(6)
@pytest.mark.parametrize("answer", RIGHT)
def test_vector_equations_are_worked_out_entry_by_entry(answer: str):
    assert fb.check(ARM, answer), answer
    left, _, right = answer.rpartition("=")
    if "tau" not in right and "[" not in right and "\\begin" not in right:
        assert not fb.check(ARM, f"{left}= 2 ({right})")


@pytest.mark.parametrize(
    "form", ["({}, {})^T", r"\left({}, {}\right)^{{\mathsf T}}", "({}, {})", "({}, {})."]
)
def test_vectors_stand_in_round_brackets_too(form: str):
    entries = "-l1 s1 θ̇1 - lc2 s12 (θ̇1 + θ̇2)", "l1 c1 θ̇1 + lc2 c12 (θ̇1 + θ̇2)"
    assert fb.check(ARM, f"v_c2 = {form.format(*entries)}")
    assert not fb.check(ARM, f"v_c2 = {form.format(*reversed(entries))}")
    assert fb.check(ARM, "tau = M (θ̈1, θ̈2)^T + c + G")
    with pytest.raises(fb.AnswerError, match="G2 is one number, not a vector"):
        fb.check(ARM, f"G2 = {form.format(1, 2)}")


def test_a_mistake_in_a_vector_is_named_in_its_entry():
    verdict = fb.check(ARM, "tau = M q̈ + [-m2 l1 lc2 s2 (θ̇1 θ̇2 + θ̇2²); m2 l1 lc2 s2 θ̇1²] + G")
    assert [x.equal for x in verdict.equations] == [False, True]
    assert "occurs twice" in verdict.text
    verdict = fb.check(ARM, "vc2 = [-l1 s1 θ̇1 - lc2 s12 (θ̇1 + θ̇2); l1 c1 θ̇1 + lc2 c12 θ̇2]")
    assert "vc2x is right.\nvc2y, the velocity of the centre of mass of body 2, is" in verdict.text


@pytest.mark.parametrize(
    ("answer", "words"),
    [
        ("tau = M q̈ + [1; 2; 3]", "a vector of 3 is added to a vector of 2"),
        ("tau = M q̈ + T", "T is added to a vector of 2"),
        ("tau = M [1; 2; 3]", "a matrix of 2 × 2 is multiplied with a vector of 3"),
        ("tau1 = M q̈", "tau1 is one number, not a vector or matrix"),
        ("T = M^2", "a matrix of 2 × 2 has no power 2 here"),
        ("[tau1; tau2] = M", "different numbers of entries"),
        ("tau = tau", "defined by itself"),
        ("M = [[1, 2], [3]] M", "the rows of this matrix have different lengths"),
        ("tau = " + "M " * 40 + "q̈", "too many entries"),
        ("vc1 = cross(rc1, ω1)", "have no cross product"),
        ("vc1 = 2 × rc1", "may be a product or the cross product"),
    ],
)
def test_vectors_that_do_not_fit_are_refused(answer: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(ARM, answer)


ROWS = [{"alpha": math.pi / 2, "a": "a1", "m": "m1", "com": ["c1x", 0, 0]}, {"a": "a2", "m": "m2"}]
SPATIAL = fb.dh(ROWS, convention="standard")
ARMS = {"RR": ARM, "RP": fb.planar("RP"), "space": SPATIAL, "gyro": fb.load("gyro")}


def printed(known: Any, x: Any) -> str:
    """A quantity as one writes it on a line."""
    if isinstance(x, tuple) and isinstance(x[0], tuple):
        return "[" + ", ".join(f"[{', '.join(str(known.form(y)) for y in row)}]" for row in x) + "]"
    if isinstance(x, tuple):
        return "[" + "; ".join(str(known.form(y)) for y in x) + "]"
    return str(known.form(x))


def with_one_sign_changed(x: Any, rate: Any) -> Any:
    """The first entry that is not 0 with the other sign; a rate more where there is none."""
    if not isinstance(x, tuple):
        return -x if _counts(x) else x + rate
    k = next((k for k, y in enumerate(x) if _counts(y)), 0)
    return tuple(with_one_sign_changed(y, rate) if i == k else y for i, y in enumerate(x))


def _counts(x: Any) -> bool:
    """Whether something is not all 0."""
    return any(map(_counts, x)) if isinstance(x, tuple) else x != x * -1


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ARMS)
def test_each_known_quantity_is_checked(name: str):
    """Its own printed line is right, and none with one sign changed."""
    model = ARMS[name]
    known = fb.quantities(model)
    given = {*fb.equations(model).symbols.ring.names, "q", "qd", "qdd"}
    asked = [x for x in known if x not in given]
    assert len(asked) > 60
    for some in (asked[:60], asked[60:]):  # an answer has at most 100
        verdict = fb.check(model, "\n".join(f"{x} = {printed(known, known[x])}" for x in some))
        assert verdict, verdict
        some = [x for x in some if x not in verdict.unchecked]  # the numbers of a model
        wrong = {x: with_one_sign_changed(known[x], known["qd"][0]) for x in some}
        text = "\n\n".join(f"{x} = {printed(known, wrong[x])}" for x in some)
        verdict = fb.check(model, text, form="markdown")
        found = {x.where for x in verdict.equations if not x.equal}
        assert found == {f"line {1 + 2 * k}" for k in range(len(some))}, verdict


@pytest.mark.parametrize(
    "answer",
    [
        "s1 = 2\nH22 = m2 lc2^2 + I2",
        "r1 = lc1 + 0*l1\nH11 = H12 + 1 - 1 + m1 r1^2 + I1 + m2 (l1^2 + l1 lc2 c2)",
        "p12 = m2 lc2\nG2 = p12 g c12",
        "n1 = m2 lc2\nG2 = n1 g c12",
    ],
)
def test_names_of_vectors_may_be_ones_own_for_numbers(answer: str):
    if answer.startswith("s1"):
        with pytest.raises(fb.AnswerError, match="s1 is a symbol of the model"):
            fb.check(ARM, answer)
    else:
        assert fb.check(ARM, answer)


def test_an_entry_of_the_rate_of_a_matrix_that_is_anothers_is_told():
    swapped = "Ḣ = [-m2 l1 lc2 s2 θ̇2, -2 m2 l1 lc2 s2 θ̇2; -m2 l1 lc2 s2 θ̇2, 0]"
    verdict = fb.check(fb.planar("RR"), swapped)
    assert "What you wrote is right for M\u0307 1, 2, not for this one." in verdict.text


@pytest.mark.parametrize(
    ("robot", "line"),
    [
        ("2R", "v_1 = 0"),
        ("2R", "f_21 = -f_12"),
        ("2R", "n_21 = -n_12"),
        ("2R", "m1 a_c1 = f_01 + f_21 + m1 g"),
        ("elbow_arm", "f_10 = -f_01"),
        ("four_bar", "m2 a_c2 = f_12 - f_23 + m2 g"),
        ("four_bar", "m3 a_c3 = f_03 + f_23 + m3 g"),
        ("four_bar", "f_10 = -f_01"),
    ],
)
def test_a_reaction_has_a_name_of_its_own(robot: str, line: str):
    assert fb.check(fb.load(robot), line)


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("robot", "line"),
    [
        ("2R", "v_2 = 0"),
        ("2R", "f_21 = f_12"),
        ("2R", "m1 a_c1 = f_01 - f_21 + m1 g"),
        ("four_bar", "m2 a_c2 = f_12 + f_23 + m2 g"),
        ("four_bar", "m3 a_c3 = f_03 - f_23 + m3 g"),
    ],
)
def test_and_the_sign_of_newtons_third_law(robot: str, line: str):
    assert not fb.check(fb.load(robot), line)
