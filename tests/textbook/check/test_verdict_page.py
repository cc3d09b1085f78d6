"""The page of a verdict: every line of the answer, marks, reasons, and what would be right."""

from __future__ import annotations

import html
import pickle
import re
from pathlib import Path

import pytest

import freebody as fb
from support.command import error, run

ARM = fb.planar("RR")
ANSWER = r"""# Exercise <1>
The inertia is $H_{12} = m_2(l_{c2}^2 - l_1 l_{c2}\cos\theta_2) + I_2$, and
$$H_{22} = m_2 l_{c2}^2 + I_2$$
$\dot v_{c2x} = 3$ and $G_2 = ( m_2$
"""


def plain(page: str) -> str:
    """The words of a page, formulas included."""
    body = page.partition("<body>")[2]
    return " ".join(html.unescape(re.sub(r"<[^>]+>", "", body)).split())


def test_a_page_has_the_answer_its_marks_and_what_is_said():
    verdict = fb.check(ARM, ANSWER, form="markdown")
    page = verdict.html()
    words = plain(page)
    for line in ANSWER.splitlines():
        assert line in words
    assert "1 of 3 equations right" in words
    for equation in verdict.equations:
        for said in (
            *equation.causes,
            equation.example_text,
            *(x.message for x in equation.findings),
        ):
            assert said in words
    (row,) = verdict.unread
    assert row.reason in words
    rows = re.findall(r'<li( class="\w+")?><span class="marks">(.*?)</span>', page)
    marks = [(re.findall(r"\w+", kind)[-1:], re.findall("[✓✗]", inside)) for kind, inside in rows]
    assert marks == [([], []), (["wrong"], ["✗"]), (["right"], ["✓"]), (["wrong"], ["✗"])]
    for target in re.findall(r'href="#([^"]+)"', page):
        assert f'id="{target}"' in page
    assert r"<mark>- l_1 l_{c2}\cos\theta_2</mark>" in page
    assert "script-src 'none'" in page
    assert not re.search(r'(?:src|href)="(?!#|data:)', page)
    assert pickle.loads(pickle.dumps(verdict)).html() == page


@pytest.mark.parametrize(
    ("answer", "right"),
    [
        ("H12 = 3", "H₁₂ = m₂ (lc₂² + l₁ lc₂ cos θ₂) + I₂"),
        (r"\dot v_{c2y} = 0", None),
        ("detJ = 1", "detJ = l₁ l₂ sin θ₂"),
        ("c2 = 0", "c₂ = m₂ l₁ lc₂ sin(θ₂) θ̇₁²"),
        ("theta1_dd = tau1/I1", ""),
    ],
)
def test_what_would_be_right_is_right_when_it_is_checked(answer: str, right: str | None):
    verdict = fb.check(ARM, answer)
    (equation,) = verdict.equations
    if right == "":  # no formula in the symbols of the robot
        assert equation.right is None
        assert "What would be right" not in verdict.html()
        return
    assert right is None or str(equation.right) == right
    assert fb.check(ARM, str(equation.right))
    assert "What would be right" in verdict.html()


def test_a_place_behind_letters_with_dots_is_marked():
    verdict = fb.check(ARM, "c2 = θ̇₁ θ̇₁ m2 l1 lc2 sin(θ1)")
    assert "<mark>" in verdict.html()
    pieces = re.findall("<mark>(.*?)</mark>", verdict.html())
    assert [x.yours for x in verdict.findings] == pieces


def test_the_command_writes_the_page(tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    page = tmp_path / "verdict.html"
    assert run(["check", "2R", "H22 = I2", "--out", str(page)]) == 1
    assert "written: " in capsys.readouterr().out
    assert "H22, entry 2, 2 of the mass matrix, is not right" in page.read_text("utf-8")
    assert "expected an .html file" in error(capsys, "check", "2R", "H22 = I2", "--out", "x.txt")
