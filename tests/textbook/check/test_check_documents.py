"""Whole answers: text, Markdown, LaTeX, notebooks and code, with words between the equations."""

from __future__ import annotations

import json
import time
from itertools import pairwise
from pathlib import Path

import pytest

import freebody as fb
from support.answer_documents import CODE, LATEX, MARKDOWN, NOTEBOOK, TEXT
from support.command import run

ARM = fb.planar("RR")

DOCUMENTS = {
    "answer.md": (MARKDOWN, 9, ["line 7", "line 8", "line 9", "line 9", "line 11", "line 13"]),
    "answer.tex": (LATEX, 8, ["line 5", "line 7", "line 8", "line 11", "line 12", "line 14"]),
    "answer.txt": (TEXT, 4, ["line 4", "line 5", "line 6", "line 8"]),
    "answer.py": (CODE, 4, ["line 3", "line 4", "line 6", "line 8"]),
    "answer.ipynb": (NOTEBOOK, 5, ["cell 1, line 2", "cell 2, line 3", "cell 2, line 4"]),
}


@pytest.mark.parametrize("name", DOCUMENTS)
def test_a_whole_file_is_read(name: str, tmp_path: Path):
    text, count, places = DOCUMENTS[name]
    file = tmp_path / name
    file.write_text(text, encoding="utf-8")
    verdict = fb.check(ARM, file)
    assert verdict, verdict
    assert len(verdict.equations) >= count
    assert [x.where for x in verdict.equations][: len(places)] == places
    assert verdict.text.startswith(f"{places[0]}: ")


@pytest.mark.sample(4)
@pytest.mark.parametrize(
    ("name", "right", "wrong", "place"),
    [
        ("answer.md", r"\cos(\theta_1 + \theta_2)\)", r"\sin(\theta_1 + \theta_2)\)", "line 11"),
        ("answer.md", "c2 = h dtheta1^2", "c2 = -h dtheta1^2", "line 13"),
        ("answer.md", "- so h = m2", "- so h = 2 m2", "line 13"),
        ("answer.md", "&+ h", "&- h", "line 17"),
        ("answer.md", r"H_{12} \dot{\theta}_1", r"H_{22} \dot{\theta}_1", "line 16"),
        ("answer.md", "m1*g*lc1*sp.cos", "m1*g*lc1*sp.sin", "line 24"),
        ("answer.tex", r"&\quad + I_2", r"&\quad - I_2", "line 8"),
        ("answer.tex", r"\boxed{\dot{y} = l", r"\boxed{\dot{y} = -l", "line 15"),
        ("answer.tex", r"}_{\text{inertia}} +", r"}_{\text{inertia}} -", "line 17"),
        ("answer.tex", "with } h = m", "with } h = -m", "line 17"),
        ("answer.txt", "   + h (d", "   - h (d", "line 8"),
        ("answer.txt", "where h = m2", "where h = -m2", "line 8"),
        ("answer.py", "theta1.diff(t, 2)", "theta1.diff(t, 1)", "line 6"),
        ("answer.py", "Rational(1, 2)", "Rational(1, 3)", "line 8"),
        ("answer.ipynb", "lc2*sp.cos(theta2)", "lc2*sp.sin(theta2)", "cell 2, line 4"),
    ],
)
def test_a_mistake_in_a_file_is_found_on_its_line(name: str, right: str, wrong: str, place: str):
    text = DOCUMENTS[name][0]
    assert right in text
    form = {"md": "markdown", "tex": "latex", "txt": "text", "py": "python", "ipynb": "notebook"}
    verdict = fb.check(ARM, text.replace(right, wrong), form=form[name.split(".")[1]])
    assert not verdict
    assert place in [x.where or place for x in verdict.equations if not x.equal]
    assert all(x.findings or x.causes for x in verdict.equations if not x.equal)


def test_what_is_passed_over_is_told_only_where_it_is_an_equation():
    verdict = fb.check(ARM, MARKDOWN, form="markdown")
    assert [(x.where, x.text) for x in verdict.unread] == [
        ("line 3", r"\theta_2 = 0"),  # the value of g is known
    ]
    assert r"Not read, line 3: \theta_2 = 0: " in verdict.text
    (passed,) = fb.check(ARM, TEXT).unread
    assert (passed.where, passed.text) == ("line 10", "θ2 = 0 the arm is stretched")


def test_an_equation_about_the_robot_that_is_not_read_is_no_success(
    capsys: pytest.CaptureFixture[str], tmp_path: Path
):
    text = MARKDOWN.replace("c2 = h dtheta1^2", "tau1 = L.differentiated()")
    verdict = fb.check(ARM, text, form="markdown")
    assert not verdict
    assert all(equation.equal for equation in verdict.equations)
    assert [x.where for x in verdict.left_out] == ["line 13"]
    file = tmp_path / "answer.md"
    file.write_text(text, encoding="utf-8")
    assert run(["check", "RR", str(file)]) == 2
    assert "Not read, line 13: tau1 = L.differentiated()" in capsys.readouterr().out
    assert run(["check", "RR", str(file), "--form", "nothing"]) == 2
    assert "no form 'nothing'" in capsys.readouterr().err


RIGHT = r"$H_{22} = m_2 l_{c2}^2 + I_2$"
WRONG = "H12 = m2 lc2^2 + I2"
LATEX_WRONG = r"H_{12} = m_2 l_{c2}^2 + I_2"


@pytest.mark.sample(10)
@pytest.mark.parametrize(
    ("form", "text"),
    [
        ("markdown", f"{RIGHT} and {WRONG}"),
        ("markdown", f"{RIGHT}\n\n| a | b |\n|---|---|\n| {WRONG} | x |"),
        ("markdown", f"{RIGHT}\n\n`{WRONG}`"),
        ("markdown", f"{RIGHT}\n\n```c\n{WRONG}\n"),
        ("markdown", f"{RIGHT}\n\n<p>{WRONG}</p>"),
        ("markdown", f"{RIGHT}\n\n- [ ] {WRONG}"),
        ("markdown", f"{RIGHT}\n\n$H_{{12}}$ = $m_2 l_{{c2}}^2 + I_2$"),
        ("latex", f"{RIGHT}\n{WRONG}"),
        ("latex", f"{RIGHT} \\ensuremath{{{LATEX_WRONG}}}"),
        ("latex", f"{RIGHT}\\begin{{empheq}}{{align}}{LATEX_WRONG}\\end{{empheq}}"),
        ("latex", f"{RIGHT}\\[{LATEX_WRONG}"),
        ("latex", f"{RIGHT}\\begin{{alignat}}{{2}}{LATEX_WRONG}\\end{{alignat}}"),
        ("latex", f"{RIGHT}\\begin{{IEEEeqnarray}}{{rCl}}H_{{12}}&=&I_2\\end{{IEEEeqnarray}}"),
        ("latex", r"$H_{22} = m_2 l_{c2}^2 + I_2 \dots$ " + RIGHT),
        ("latex", f"{RIGHT} $H_{{12}} \\approx I_2$"),
        ("latex", f"{RIGHT} $H_{{12}} := I_2$"),
        ("latex", f"{RIGHT} $H_{{12}} \\overset{{!}}{{=}} I_2$"),
        ("python", "H22 = m2*lc2**2 + I2\nH12, H21 = m2*lc2**2, m2*lc2**2"),
        ("python", "H22 = m2*lc2**2 + I2\nM[0, 1] = m2*lc2**2"),
        ("python", "H22 = m2*lc2**2 + I2\nH12 += m2*lc2**2"),
        ("python", "H22 = m2*lc2**2 + I2\nH22 = H22 + I2"),
        ("python", "H22 = m2*lc2**2 + I2\ndisplay(sp.Eq(H12, m2*lc2**2))"),
        ("python", "H22 = m2*lc2**2 + I2\nassert H12 == m2*lc2**2"),
        ("python", "H22 = m2*lc2**2 + I2\n%time H12 = m2*lc2**2"),
        ("python", "H22 = m2*lc2**2 + I2\nH12 = sympify('m2*lc2**2')"),
        ("text", "H22 = m2 lc2^2 + I2\nH12 (the coupling) = m2 lc2^2"),
        ("text", "H22 = m2 lc2^2 + I2\nH12 [kg m^2] = m2 lc2^2"),
    ],
)
def test_nothing_about_the_robot_is_left_out_in_silence(form: str, text: str):
    """Wherever it stands: an equation of one of its quantities is judged, or told as not read."""
    verdict = fb.check(ARM, text, form=form)
    assert not verdict
    assert verdict.left_out or not all(x.equal for x in verdict.equations)


@pytest.mark.parametrize(
    ("form", "text"),
    [
        ("latex", f"% {WRONG}\n{RIGHT}"),
        ("markdown", f"# Where x = y\n\n{RIGHT}<!-- {WRONG} -->"),
        ("python", f"H22 = simplify(m2*lc2**2 + I2)  # {WRONG}\nH22 = trigsimp(H22)"),
        ("python", "x, y = symbols('x y')\nH22 = m2*lc2**2 + I2\nprint(H22 == H12)\nplot(x=3)"),
        ("python", "H22 = m2*lc2**2 + I2\nprint('H12 = ', H12)  # the last"),
    ],
)
def test_comments_titles_and_declarations_state_nothing(form: str, text: str):
    verdict = fb.check(ARM, text, form=form)
    assert verdict, verdict
    assert not verdict.unread


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("H22 = m2 lc2^2 + I2 + damping", "no symbol 'damping'"),
        ("H22 = m2 lc2^2 + I2\n + damping", "no symbol 'damping'"),
        ("H22 = m2 lc2^2 + I2 + l1*\n damping", "no symbol 'damping'|a term is expected"),
        ("foo + H22 = m2 lc2^2 + I2", "no symbol 'foo'"),
        ("foo H22 - damping = m2 lc2^2 + I2", "no symbol 'damping'"),
        ("foo/2 H22 = m2 lc2^2 + I2", "no symbol 'foo'"),
        ("The answer is easy.", "the answer is empty"),
        ("Let n = 3 be a number", "no equation could be read; line 1"),
    ],
)
def test_no_term_is_taken_for_words(text: str, words: str):
    with pytest.raises(fb.AnswerError, match=words):
        fb.check(ARM, text)


def test_derivatives_of_the_energies_are_read():
    right = [
        "∂L/∂θ̇1 = H11 θ̇1 + H12 θ̇2",
        r"\frac{d}{dt}\left(\frac{\partial L}{\partial \dot\theta_2}\right) = H_{12}\ddot\theta_1"
        r" + H_{22}\ddot\theta_2 - m_2 l_1 l_{c2} s_2 \dot\theta_1 \dot\theta_2",
        "d/dt ∂L/∂θ̇1 - ∂L/∂θ1 = tau1",
        "∂V/∂θ2 = m2 g lc2 c12",
        "tau1 = d/dt(H11 dtheta1 + H12 dtheta2) + ∂V/∂q1",
    ]
    for text in right:
        assert fb.check(ARM, text), text
        assert not fb.check(ARM, text.replace(" = ", " = -", 1)), text
    with pytest.raises(fb.AnswerError, match="defined by itself"):
        fb.check(ARM, "L = L + ∂L/∂q1 - ∂L/∂q1")
    with pytest.raises(fb.AnswerError, match="not a coordinate to differentiate by"):
        fb.check(ARM, "∂L/∂θ12 = 0")


def test_sympys_own_latex_of_functions_of_time_is_read():
    text = (
        r"\tau_2 = H_{12} \frac{d^{2}}{d t^{2}} \theta_{1}{\left(t \right)} + H_{22} "
        r"\frac{d^{2}}{d t^{2}} \theta_{2}{\left(t \right)} + l_{1} lc_{2} m_{2} "
        r"\sin{\left(\theta_{2}{\left(t \right)} \right)} "
        r"\left(\frac{d}{d t} \theta_{1}{\left(t \right)}\right)^{2} + G_2"
    )
    assert fb.check(ARM, text)
    assert not fb.check(ARM, text.replace(r"\sin", r"\cos"))


@pytest.mark.parametrize(
    "text",
    [
        "A = foo1\n\nH22 = m2 lc2^2 + I2 + A",
        "A = l1^l2\n\nH22 = m2 lc2^2 + I2 + A",
        "A = B\n\nB = foo3\n\nH22 = A + m2 lc2^2 + I2",
        "A = B\n\nB = A\n\nH22 = A + m2 lc2^2 + I2",
    ],
)
def test_what_is_written_with_a_name_without_value_is_not_judged(text: str):
    verdict = fb.check(ARM, f"{text}\n\nG2 = m2 g lc2 c12", form="markdown")
    assert [equation.name for equation in verdict.equations] == ["G2"]
    assert not verdict
    with pytest.raises(fb.AnswerError):
        fb.check(ARM, text)


NOT_ALL = [
    (r"$$M(q) + \text{bar} = 3$$ $G_2 = m_2 g l_{c2} c_{12}$", "markdown"),
    (
        r"\begin{cases} H_{12} = 2 + \text{bar} \\ H_{22} = m_2 l_{c2}^2 + I_2 \end{cases} $G$",
        "latex",
    ),
    (r"$$H_{22} = m_2 l_{c2}^2 + \text{damping} + I_2$$", "markdown"),
    (r"$$H_{22} = m_2 l_{c2}^2 + \dots + I_2$$", "markdown"),
    ("H22 = m2*lc2**2 + I2\nH22 += l1", "python"),
    ("H22 = m2*lc2**2 + I2\nH22 = H22 + l1", "python"),
    ("H22 = m2*lc2**2 + I2\nH12 = I2 + f('a')", "python"),
    ("H22 = m2*lc2**2 + I2\nH12 = H22.subs(lc2, 3)", "python"),
]


@pytest.mark.parametrize(("text", "form"), NOT_ALL, ids=range(len(NOT_ALL)))
def test_no_part_of_an_equation_is_left_out_unseen(text: str, form: str):
    try:
        verdict = fb.check(ARM, text, form=form)
    except fb.AnswerError:
        return
    assert not verdict, verdict
    assert verdict.left_out


def test_what_follows_an_equation_without_one_is_told():
    verdict = fb.check(ARM, r"$$H_{22} = m_2 l_{c2}^2 + I_2 \text{ times } 2$$", form="markdown")
    assert [x.text for x in verdict.unread] == ["2"]


@pytest.mark.sample(6)
@pytest.mark.parametrize(
    "end", [r" \quad (3.2)", r"\qquad(3-2)", "   (3.2)", "\t(A.4)", r" \hfill (12.3a) \\"]
)
@pytest.mark.parametrize("form", ["text", "latex"])
def test_the_number_of_an_equation_is_no_factor(end: str, form: str):
    for right, equal in ((RIGHT.strip("$"), True), (LATEX_WRONG, False)):
        text = rf"\[{right}{end}\]" if form == "latex" else right + end
        assert bool(fb.check(ARM, text, form=form)) is equal, text


def test_a_number_that_is_not_apart_is_a_factor():
    assert not fb.check(ARM, "H22 = (m2 lc2^2 + I2) (3.2)")


def test_rows_of_one_equation_may_be_spaced():
    answer = r"\begin{align} H_{22} &= m_2 l_{c2}^2 \\[2pt] &\quad + I_2 \end{align}"
    assert fb.check(ARM, answer, form="latex")


def test_signs_of_markdown_are_told_from_powers_and_minus():
    text = "**Answer**\n\n- H22 = m2*lc2**2 + I2\n- **so** G2 = m2*g*lc2*cos(theta1 + theta2)"
    assert len(fb.check(ARM, text, form="markdown").equations) == 2
    text = r"$$H_{22} = m_2 l_{c2}^2 + I_2 \Rightarrow G_2 = m_2 g l_{c2} c_{12}$$"
    assert len(fb.check(ARM, text, form="markdown").equations) == 2


def test_names_may_be_introduced_in_any_order():
    text = "H22 = E + I2\nE = F lc2\nF = m2 lc2"
    assert fb.check(ARM, text)
    assert not fb.check(ARM, text.replace("m2 lc2", "m1 lc2"))


HOSTILE = [
    ("$" * 99_999, "markdown"),
    ("$a=1$ " * 20_000, "markdown"),
    ("\\begin{align}" * 10_000, "latex"),
    ("$" + "\\boxed{" * 50_000 + "=$", "latex"),
    ("```\n" * 25_000, "markdown"),
    ("the word = is " * 7_000, "text"),
    ("H12 " + " " * 190_000 + "= I2 +", "text"),
    ("x" * 1_000_000, "text"),
    (json.dumps({"cells": [{"cell_type": "code", "source": "(" * 100_000}]}), "notebook"),
    (json.dumps({"cells": [{"cell_type": "code", "source": 3}]}), "notebook"),
    ("[" * 300_000, "notebook"),
    ('{"cells":' * 40_000, "notebook"),
    ("∂" * 19_000, "text"),
    ("\\" * 99_000 + "%", "latex"),
    ("H12 = \ud800\u202e", "text"),
    ("H12 = 🤖", "markdown"),
    ("at θ1 = 1 " * 5_000 + "=", "markdown"),
    ("Eq(H12," * 50_000, "python"),
    (json.dumps({"cells": [{"cell_type": "code", "source": "H12, x = " * 40_000}]}), "notebook"),
    ("__import__('os').system('touch x') = 3", "python"),
]


@pytest.mark.sample(2)
@pytest.mark.parametrize(("text", "form"), HOSTILE, ids=range(len(HOSTILE)))
def test_hostile_documents_are_refused_in_bounded_time(text: str, form: str):
    begun = time.process_time()
    with pytest.raises(fb.AnswerError):
        fb.check(ARM, text, form=form)
    assert time.process_time() - begun < 20.0  # in minutes or never, if not in one pass


def test_sines_that_a_document_introduces_and_coordinates_of_centres_are_read():
    """A student's first lines: they were passed over, and c_1 was taken for a velocity term."""
    verdict = fb.check(
        ARM,
        r"""With $c_1 = \cos\theta_1$, $s_1 = \sin\theta_1$, $s_{12} = \sin(\theta_1+\theta_2)$:
$$x_{c1} = l_{c1} c_1$$
$$\dot{x}_{c2} = -l_1 s_1 \dot\theta_1 - l_{c2} s_{12} \dot\theta_2$$
$$y_{c2} = l_1 s_1 + l_{c2} s_{12}$$
$$V = m_1 g l_{c1} s_1 + m_2 g y_{c2}$$
""",
        form="markdown",
    )
    said = str(verdict)
    assert [f"{name} is right." in said for name in ("x_{c1}", "y_{c2}", "V")] == [True] * 3
    assert r"\dot{x}_{c2}, the velocity of the centre of mass of body 2, is not right" in said
    assert "velocity term" not in said
    assert "Not read" not in said


def test_a_sine_of_another_angle_is_no_s1():
    with pytest.raises(fb.AnswerError, match="s_1 is a symbol"):
        fb.check(ARM, "s_1 = sin(theta2)\nV = s_1")


def test_in_space_only_the_positions_of_centres_have_coordinates():
    """v_c2 is along body 2 there: its components are no rates of x_c2, y_c2, z_c2."""
    arm = fb.load("elbow_arm")
    assert fb.check(arm, "x_c2 = lc2*cos(theta1)*cos(theta2)")
    rate = "-lc2*(sin(theta1)*cos(theta2)*dtheta1 + cos(theta1)*sin(theta2)*dtheta2)"
    assert fb.check(arm, rf"\dot{{x}}_{{c2}} = {rate}")
    assert not fb.check(arm, r"\dot{x}_{c2} = 0")
    assert not fb.check(arm, f"v_c2x = {rate}")


@pytest.mark.parametrize(("opening", "closing"), [(r"\Big(", r"\Big)"), (r"\left[", r"\right]")])
def test_brackets_may_stand_around_the_end_of_a_row(opening: str, closing: str):
    """A long energy was not read; a term behind the row's end counts, and matrices keep theirs."""
    answer = rf"""\begin{{align}}
    T_2 = {{}}& \frac{{m_2}}{{2}} {opening} l_1^2 \dot\theta_1^2 + l_{{c2}}^2 (\dot\theta_1 + \dot\theta_2)^2 \nonumber \\[2pt]
    & \quad + 2 l_1 l_{{c2}} \cos\theta_2 \, \dot\theta_1 (\dot\theta_1 + \dot\theta_2) {closing} \\
    & + \frac{{I_2}}{{2}} (\dot\theta_1 + \dot\theta_2)^2 \\
    r_{{c1}} = {{}}& \left( \begin{{matrix}} l_{{c1}} \cos\theta_1 \\ l_{{c1}} \sin\theta_1 \end{{matrix}} \right)
    \end{{align}}"""  # noqa: E501  # a row of LaTeX is one line
    for form in ("latex", "markdown"):
        verdict = fb.check(ARM, answer, form=form)
        assert verdict, verdict.text
        assert len(verdict.findings) == 0
        assert verdict.text.count("is right") == 3
        wrong = fb.check(ARM, answer.replace("+ 2 l_1", "- 2 l_1"), form=form)
        assert not wrong
        assert not wrong.unread


MACROS = [
    r"\newcommand{\ta}{\theta_1} $G_2 = m_2 g l_{c2} \cos(\ta + \theta_2)$",
    r"\newcommand\ta{\ensuremath{\theta_1}\xspace}$G_2 = m_2 g l_{c2} \cos(\ta+\theta_2)$",
    r"\def\th#1{\theta_{#1}}\def\G{G_2} $\G = m_2 g l_{c2} \cos(\th1 + \th{2})$",
    r"\newcommand{\dd}[2]{\frac{d #1}{d #2}} $v_2 = m_2 l_1 l_{c2} \cos(\theta_2 - \pi/2) "
    r"\left(\dd{\theta_1}{t}\right)^2$",
    r"\newcommand{\lc}[1][2]{l_{c#1}}\newcommand*\w{m_2 g \lc}$G_2 = \w \cos(\theta_1+\theta_2)$",
    "% \\newcommand{\\ta}{\\theta_2}\n\\newcommand{\\ta}{\\theta_1}\n\\begin{document}\n"
    r"$G_2 = m_2 g l_{c2} \cos(\ta + \theta_2)$ \end{document}",
    r"\DeclareMathOperator{\cs}{cos} $G_2 = m_2 g l_{c2} \cs(\theta_1+\theta_2)$",
]


@pytest.mark.parametrize("text", MACROS)
def test_commands_of_its_own_are_put_in(text: str):
    verdict = fb.check(ARM, text, form="latex")
    assert verdict
    assert not verdict.unread
    assert not fb.check(ARM, text.replace("cos", "sin"), form="latex")


@pytest.mark.parametrize(
    "text",
    [
        r"\def\a{\a} $G_2 = \a$",
        r"\def\a{\b\b}\def\b{\a} $G_2 = \a$",
        r"\def\a#1{\a{#1#1}} $G_2 = \a{x}$",
        "".join(rf"\def\{a}{{\{b}\{b}}}" for a, b in pairwise("abcdefghijklmnopqrstu"))
        + r"$G_2 = \a$",
        r"\def\a{x}" + r"\a" * 30_000,
    ],
)
def test_commands_that_grow_without_end_are_refused(text: str):
    begun = time.process_time()
    with pytest.raises(fb.AnswerError, match="stands for itself, or for a text that is too long"):
        fb.check(ARM, text, form="latex")
    assert time.process_time() - begun < 2.0


TABLES = [
    "| θ1 [°] | θ2 [°] | G2 [N m] |\n|---|:-:|---|\n| 30 | 45 | 3.047 |\n| 0 | 0 | 11.77 |",
    "| No. | $\\theta_1$ (deg) | $θ_2$ (deg) | $G_2$ (Nm) |\n|-|-|-|-|\n| 1 | 30 | 45 | 3.047 |",
    "| G2 / N m | θ1 / ° | θ2 / ° |\n|---|---|---|\n| 3.047 | 30 | 45 |",
    "| θ1 | θ2 | G2 |\n|---|---|---|\n| 30° | 45° | 3.047 N m |",
    "At θ1 = 30°, θ2 = 45°:\n\n| | value |\n|---|---|\n| G2 [N m] | 3.047 |\n| H22 | 0.64 kg m² |",
]


@pytest.mark.parametrize("table", TABLES)
def test_tables_of_numbers_are_checked_row_by_row(table: str):
    arm = fb.load("2R")
    verdict = fb.check(arm, table, form="markdown")
    assert verdict, verdict.text
    assert not verdict.unread
    wrong = fb.check(arm, f"H22 = 0.64\n\n{table.replace('3.047', '3.147')}", form="markdown")
    assert "must be 3.0468 N m at θ₁ = 30" in wrong.text


def test_a_table_of_words_or_parameters_is_no_answer():
    table = "| symbol | meaning |\n|---|---|\n| l1 | length |\n| m1 | 4 kg |\n\n"
    verdict = fb.check(fb.load("2R"), f"{table}H22 = m2 lc2² + I2", form="markdown")
    assert [x.where for x in verdict.equations] == ["line 6"]
    assert verdict


@pytest.mark.parametrize(
    "given", ["vx, vy = x_c2.diff(t), y_c2.diff(t)", "vx, vy = foo(x_c2), foo(y_c2)"]
)
def test_a_name_that_code_gives_in_a_way_that_is_not_read_is_no_quantity_of_the_robot(given: str):
    code = f"""
x_c2 = l1*cos(theta1) + lc2*cos(theta1 + theta2)
y_c2 = l1*sin(theta1) + lc2*sin(theta1 + theta2)
{given}
T2 = m2*(vx**2 + vy**2)/2 + I2*(dtheta1 + dtheta2)**2/2
V2 = m2*g*y_c2
"""
    verdict = fb.check(fb.planar("RR"), code, form="python")
    assert [one.equal for one in verdict.equations] == [True, True, True]
    assert not verdict
    assert any("vx is not defined by any line that can be read" in x.reason for x in verdict.unread)


def test_a_function_of_the_coordinates_states_what_it_returns():
    right = "def H22(q):\n    a = lc2\n    return m2*a**2 + I2\n"
    assert fb.check(fb.load("2R"), right, form="python")
    wrong = right.replace("H22", "H12")
    verdict = fb.check(fb.load("2R"), f"H22 = m2*lc2**2 + I2\n{wrong}", form="python")
    assert [x.equal for x in verdict.equations] == [True, False]
    matrix = "def M(q): return sp.Matrix([[1, 2], [2, 3]])\nH22 = m2*lc2**2 + I2\n"
    assert not fb.check(fb.load("2R"), matrix, form="python")


def test_a_function_of_other_arguments_states_nothing_of_the_robot():
    code = "def T(a, d):\n    return sp.Matrix([[1, a], [0, d]])\nH22 = m2*lc2**2 + I2\n"
    assert fb.check(fb.load("2R"), code, form="python")
    itself = "def H22(q):\n    H22 = m2*lc2**2 + I2\n    return H22\n"
    assert fb.check(fb.load("2R"), itself, form="python")
