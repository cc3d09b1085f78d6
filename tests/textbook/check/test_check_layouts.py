"""Answers as students lay them out: numbers of questions, entries in brackets, signs of definition,
Word's letters and its formulas on one line, headings, tables and lines that go on."""

from __future__ import annotations

from pathlib import Path

import pytest

import freebody as fb

ARM = fb.planar("RR")
H22, H12 = "m2*lc2^2 + I2", "m2*(lc2^2 + l1*lc2*cos(theta2)) + I2"
LABELS = [
    "1)",
    "2.",
    "a)",
    "(a)",
    "(1)",
    "(2b)",
    "ii)",
    "(iv)",
    "*",
    "•",
    "Q1:",
    "Eq.(3):",
    "Step2:",
]
H11 = "m1 lc1^2 + I1 + m2 (l1^2 + lc2^2 + 2 l1 lc2 c2) + I2"
G2 = r"G_2 = m_2 g l_{c2} \cos(\theta_1 + \theta_2)"
TORQUE = r"\tau_2 = H_{21} \ddot\theta_1 + H_{22} \ddot\theta_2 + v_2 + G_2"

LAYOUTS = {
    "text": [
        *(
            f"{label} H22 = {H22}"
            for label in LABELS
        ),
        f"Eq. (3): H22 = {H22}\n1) M(q) = [{H11}, {H12}; {H12}, {H22}]",
        *(f"{name} = {H22}" for name in ("H[2,2]", "H[2, 2]", "H(2,2)", "H_{2,2}", "M_2,2")),
        f"H[1,2] = {H12}\nG[2] = m2 g lc2 c12",
        *(f"H22 {sign} {H22}" for sign in (":=", "≡", "≔", "≜", "==", r"\equiv", r"\coloneqq")),
        "𝐺₂ = 𝑚₂ 𝑔 𝑙c₂ 𝑐𝑜𝑠(𝜃₁+𝜃₂)\n𝐻_22=𝑚_2 𝑙_𝑐2^2+𝐼_2",
        "τ_2=H_21 θ ̈_1+H_22 (θ_2 ) ̈+v_2+m_2 gl_c2 〖cos〗\u2061(θ_1+θ_2 )",
        "H_22=m_2 〖l_c2〗^2+I_2",
        r"G_2 = m_2\,g\,l_{c2}~\cdot\cos\left(\theta_1+\theta_2\right)",
        r"{G}_2 = m_2 g {l}_{c2} \cos({\theta}_1 + {\theta }_{2})",
        r"v_2 = m_2 l_1 l_{c2} \sin(\theta_2) {\dot{\theta}}_1 \dot{{\theta}}_1",
        *(
            f"{own} = I_2 + m_2 l_{{c2}}^2\nH_{{22}} = 0 + {other}"
            for own, other in (
                (r"\bar{I}_2", r"\bar I_2"), ("Ī_2", r"\overline{I}_2"), ("I_2^*", r"I_2^{\ast}"),
                (r"\hat{I}", r"\widehat{I}"), (r"\underline I", "I\u0332"),
            )
        ),
        r"\vec{\tau}_2 = \mathcal{G}_2 + H_{21} \ddot\theta_1 + H_{22} \ddot\theta_2 + v_2",
        r"G_2 = m_2 g l_{c2} \sin(\theta_1 + \theta_2 + 90^\circ)",
    ],
    "latex": [
        G2.replace(r"\cos", "% the weight\n\\cos") + f"\nH_{{22}} = {H22}",
        rf"\begin{{aligned}} {TORQUE} \end{{aligned}}".replace("+ H", "\\\\\n &\\quad{} + H"),
        r"\begin{align} H_{22} ={}& m_2 l_{c2}^2 \\ &{}+ I_2 \\" + G2 + r"\end{align}",
    ],
    "markdown": [
        f"## H22 = {H22}\n\nand\n\n## 2: ${G2}$",
        f"| H22 = {H22} | G2 = m2 g lc2 c12 |\n|---|---|",
        f"(a) H22 = {H22}\n\n(b) ${G2}$",
    ],
    "python": [
        "M[1, 1] = m2*lc2**2 + I2\nM[0][1] = m2*(lc2**2 + l1*lc2*cos(q[1])) + I2",
        "tau[1] = M[1, 0]*q[0].diff(t, 2) + M[1, 1]*q[1].diff(t, 2) + v2 + G[1]",
    ],
}  # fmt: skip


@pytest.mark.sample(2)
@pytest.mark.parametrize("form", LAYOUTS)
def test_layouts_are_read_and_their_mistakes_found(form: str):
    """Each is right; and with a sign, a function or an index changed it is wrong."""
    changes = (("+ I", "- I"), ("+I", "-I"), ("cos", "sin"), ("c12", "s12"), ("v_2", "v_1"),
               ("0 +", "I_1 -"),
               ("sin", "cos"), ("𝐼_2", "𝐼_1"), ("M[1, 0]", "M[0, 0]"))  # fmt: skip
    for text in LAYOUTS[form]:
        verdict = fb.check(ARM, text, form=form)
        assert verdict, f"{text}\n{verdict}"
        assert not verdict.unread
        old, new = next((old, new) for old, new in changes if old in text)
        assert not fb.check(ARM, text.replace(old, new, 1), form=form), text


MARKED = (
    r"\bar θ_2",
    r"\hat{\theta}_2",
    r"\tilde{\theta_2}",
    "θ̄_2",
    "θ_2^*",
    r"\underline{\theta}_2",
)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", MARKED)
def test_a_letter_with_a_mark_is_another_quantity(name: str):
    """In formulas, in states and as what is checked, unless the answer or names say what it is."""
    answer = f"G_2 = m_2 g l_{{c2}} \\cos(\\theta_1 + {name})"
    for form in ("text", "latex"):
        text = f"${answer}$" if form == "latex" else answer
        with pytest.raises(fb.AnswerError, match="a letter with a mark is another quantity"):
            fb.check(ARM, text, form=form)
    assert fb.check(ARM, answer, names={name: "theta2"})
    assert fb.check(ARM, f"{name} = θ_2\n{answer}")
    assert not fb.check(ARM, f"{name} = 2 θ_2\n{answer}")
    numbers = fb.load("2R")
    assert fb.check(numbers, "G2 = 3.047 N m at θ1 = 30°, θ2 = 45°")
    with pytest.raises(fb.AnswerError, match=r"not given|is not defined"):
        fb.check(numbers, f"G2 = 3.047 N m at θ1 = 30°, {name} = 45°")
    with pytest.raises(fb.AnswerError, match="gives no symbol of '2R' a value"):
        fb.check(numbers, "G2 = 3.047 N m", at=f"θ1 = 30°, {name} = 45°")
    marked = name.replace("θ", "H").replace(r"\theta", "H").replace("2", "22")
    with pytest.raises(fb.AnswerError, match="is taken for a name of your own"):
        fb.check(ARM, f"{marked} = {H22}")


def test_what_looks_like_a_label_but_is_a_factor_counts():
    assert fb.check(ARM, "(1) m2 lc2^2 + I2 = H22")
    assert not fb.check(ARM, "(2) m2 lc2^2 + I2 = H22")
    with pytest.raises(fb.AnswerError, match="different numbers of entries"):
        fb.check(ARM, f"H[0,0] = {H22}")


def test_titles_are_words_unless_they_are_equations():
    right = f"H22 = {H22}"
    assert fb.check(ARM, f"# Where x = y\n\n{right}", form="markdown")
    for title in ("## G2 = m2 g lc2 cos θ1", "## Answer: G2 = m2 g lc2 c1", "# $G_2 = m_2 g$"):
        verdict = fb.check(ARM, f"{title}\n\n{right}", form="markdown")
        assert [x.equal for x in verdict.equations] == [False, True]


def test_names_are_all_read_at_once():
    """In whatever order; what would be ignored is refused."""
    swapped = {"l1": "l2", "l2": "l1"}
    for names in (swapped, dict(reversed(swapped.items()))):
        assert fb.check(ARM, "x = l2 c1 + l1 c12", names=names)
        assert not fb.check(ARM, "x = l1 c1 + l2 c12", names=names)
    for names in ({"b": "2*a", "a": "l2"}, {"a": "l2", "b": "2*a"}):
        assert fb.check(ARM, "x = l1 c1 + b/2 c12", names=names)
    for names, words in (
        ({"sin": "cos"}, "'sin' has a meaning of its own"),
        ({"pi": "l1"}, "'pi' has a meaning of its own"),
        ({"C12": "sin"}, "a letter for sin, without numbers"),
        ({"b": "a", "a": "b"}, "no symbol 'a'"),
    ):
        with pytest.raises(fb.AnswerError, match=words):
            fb.check(ARM, f"H22 = {H22}", names=names)
    turntable = fb.dh([{"m": "m1", "a": "a1"}], convention="standard")
    with pytest.raises(fb.AnswerError, match="no 'lc' with a number is known"):
        fb.check(turntable, "H11 = I1zz", names={"L": "lc"})


def test_functions_in_a_file_of_names_are_refused(tmp_path: Path):
    file = tmp_path / "own.toml"
    file.write_text('[names]\nsin = "cos"\n', encoding="utf-8")
    with pytest.raises(fb.AnswerError, match="'sin' has a meaning of its own"):
        fb.check(ARM, f"H22 = {H22}", notation=file)


@pytest.mark.parametrize("answer", ["h = k; k = h", "h = -k\nk = -h"])
def test_names_given_by_each_other_say_nothing(answer: str):
    with pytest.raises(fb.AnswerError, match="h is defined by itself"):
        fb.check(ARM, f"{answer}\nH22 = {H22}")
    verdict = fb.check(ARM, f"{answer}\nH22 = {H22}", form="markdown")
    assert not verdict
    assert any("h is defined by itself" in x.reason for x in verdict.unread)


SLOPPY = [
    ("RR", "h = m2*l1*lc2*s2\nC(q,qdot) = [-h*q2dot, -h*(q1dot+q2dot); h*q1dot, 0]", "; h", "; -h"),
    ("RR", r"C(q,\dot q)\dot q = [-m2 l1 lc2 s2 (2 q̇1 q̇2 + q̇2²); m2 l1 lc2 s2 q̇1²]", "; m", "; -m"),
    ("RR", "x_e = l1 c1 + l2 c12 and ẏ_e = l1 c1 θ̇1 + l2 c12 (θ̇1+θ̇2)", "= l1 c1 θ", "= s1 θ"),
    ("RR", "|J| = l1 l2 sinθ2", "sin", "cos"),
    ("RR", "|v_c1|^2 = lc1² θ̇1²", "lc1", "l1"),
    ("RR", "τ1 = M11θ̈1 + M12θ̈2 + h(2θ̇1θ̇2+θ̇2²) + G1 where h = -m2l1lc2sinθ2", "= -", "= "),
    ("RR", "τ = Mq̈ + Cq̇ + G", "+ C", "- C"),
    ("RR", "tau = Mqdd + Cqd + G", "+ G", "- G"),
    ("RR", "Q1 = d/dt(dL/dq1dot) - dL/dq1", ") -", ") +"),
    ("RR", "w2 = dq1 + dq2; α2 = θ̈1 + θ̈2", "= dq1 +", "="),
    ("RR", "tau2 = I2 ω̇2 + m2 (r_c2 - r_2) x (a_c2 - g)", "- g", "+ g"),
    ("RR", "v_c2 = v_2 + ω2 x s_c2", "+ ω2", "+ ω1"),
    ("quadrotor", "q̇ = ((Iz-Ix) p r + l (f3-f1))/Iy", "Iz-Ix", "Ix-Iz"),
    ("quadrotor", "m*zdd = T*cos(phi)*cos(theta) - m*g, T = f1+f2+f3+f4", "- m", "+ m"),
]  # fmt: skip


@pytest.mark.sample(3)
@pytest.mark.parametrize(("robot", "answer", "old", "new"), SLOPPY)
def test_what_is_typed_in_haste_is_read(robot: str, answer: str, old: str, new: str):
    model = fb.load(robot)
    verdict = fb.check(model, answer)
    assert verdict, f"{answer}\n{verdict}"
    assert not verdict.unread
    wrong = answer.replace(old, new, 1)
    assert wrong != answer
    assert not fb.check(model, wrong)


def test_v1_beside_torques_may_be_the_velocity_term():
    right = fb.check(ARM, "tau_1 = M11 θ̈1 + M12 θ̈2 + V1 + G1")
    assert right.text == "tau_1 is right. ‘V1’ is read as the velocity term."
    text = fb.check(ARM, "tau_1 = M11 θ̈1 + M12 θ̈2 - V1 + G1").text
    assert (
        "‘V1’ on the right is read as a potential energy; write v1 for the velocity term." in text
    )


def test_a_full_stop_may_stand_apart():
    for answer in ("H22 = I2 + m2 lc2^2 .", r"\[ H_{22} = I_2 + m_2 l_{c2}^2 . \]"):
        assert fb.check(fb.load("RR"), answer)
        assert not fb.check(fb.load("RR"), answer.replace("+", "-"))
