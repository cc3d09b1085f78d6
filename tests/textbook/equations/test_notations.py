"""Answers in the notation of a book, and in one's own: letters, angles, parameters by formulas."""

from __future__ import annotations

from pathlib import Path

import pytest

import freebody as fb
from support.command import run
from support.notations import NOTATIONS, own_notation

ARM = fb.planar("RR")
OWN = """title = "Mine"
zero = "down"
angles = "absolute"
[names]
L = "l"
[parameters]
lc = "l/2"
I = "m*l^2/12"
[letters]
mass = "B"
"""

RIGHT = [
    ("notes", "H22 = m2 lc2^2 + I2"),
    ("craig", "V = [-m2 l1 lc2 s2 (2 θ̇1 θ̇2 + θ̇2²); m2 l1 lc2 s2 θ̇1²]"),
    ("craig", "V2 = m2 l1 lc2 s2 θ̇1²"),
    ("craig", "k1 = (m1 lc1^2 + Izz1) θ̇1²/2"),
    ("craig", "u2 = m2 g (l1 s1 + lc2 s12)"),
    ("spong", r"d_{12} = m_2 (\ell_{c2}^2 + \ell_1 \ell_{c2} \cos q_2) + I_2"),
    ("spong", r"\phi_2 = m_2 \ell_{c2} g \cos(q_1 + q_2)"),
    ("siciliano", r"b_{12} = I_{\ell_2} + m_{\ell_2}(\ell_2^2 + a_1 \ell_2 c_2)"),
    ("siciliano", r"\tau = B(q)\ddot q + C(q,\dot q)\dot q + g(q)"),
    ("murray-li-sastry", "N1 = (m1 r1 + m2 l1) g c1 + m2 r2 g c12; M22 = Iz2 + m2 r2^2"),
    ("lynch-park", "tau = M q̈ + h"),
    ("lynch-park", "g1 = (m1 r1 + m2 L1) g c1 + m2 r2 g c12"),
    ("featherstone", "tau = H q̈ + C"),
    ("featherstone", "C2 = m2 l1 lc2 s2 q̇1² + m2 g lc2 cos(q1 + q2)"),
]


@pytest.mark.sample(4)
@pytest.mark.parametrize(("name", "answer"), RIGHT)
def test_lines_in_a_books_notation_are_right(name: str, answer: str):
    assert fb.check(ARM, answer, notation=name), answer
    if "tau" not in answer:
        left, _, right = answer.rpartition("=")
        assert not fb.check(ARM, f"{left}= 2 * {right}".replace("2 *  [", "2 * ["), notation=name)


def test_a_notation_says_which_of_two_readings_is_meant():
    """V2 is a potential energy in the notes, and a velocity term with Craig; C with Featherstone
    holds gravity too; l is not the length with Siciliano."""
    velocity = "V2 = m2 l1 lc2 s2 θ̇1²"
    assert not fb.check(ARM, velocity)
    assert fb.check(ARM, velocity, notation="craig")
    gravity = "C2 = m2 l1 lc2 s2 q̇1² + m2 g lc2 c12"
    assert not fb.check(ARM, gravity)
    assert fb.check(ARM, gravity, notation="featherstone")
    assert not fb.check(ARM, "g2 = ml2 a2 g c12", notation="siciliano")
    assert fb.check(ARM, "g2 = ml2 l2 g c12", notation="siciliano")


@pytest.fixture
def own(tmp_path: Path) -> Path:
    file = tmp_path / "mine.toml"
    file.write_text(OWN, encoding="utf-8")
    return file


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "answer",
    [
        "B22 = m2 L2^2/3",
        "B12 = m2 L1 L2/2 cos(θ1 - θ2)",
        "g1 = (m1/2 + m2) g L1 sin θ1",
        "x = L1 sin θ1 + L2 sin θ2; y = -L1 cos θ1 - L2 cos θ2",
        "T2 = m2/2 (L1² θ̇1² + L2²/3 θ̇2² + L1 L2 cos(θ1 - θ2) θ̇1 θ̇2)",
    ],
)
def test_ones_own_notation_is_a_small_file(own: Path, answer: str):
    assert fb.check(ARM, answer, notation=own)
    assert fb.check(ARM, answer, notation=str(own))
    changed = answer.replace("- ", "+ ").replace("= (m1", "= -(m1").replace("2 L2^2", "1 L2^2")
    changed = changed.replace("= L1 sin", "= L1 cos").replace("θ1 + θ2", "θ1 + 2 θ2")
    assert changed != answer
    assert not fb.check(ARM, changed, notation=own)


def test_one_parameter_may_be_a_formula(tmp_path: Path):
    rod = own_notation(tmp_path, "rod", parameters={"lc2": "l2/2", "I2": "m2*l2^2/12"})
    assert fb.check(ARM, "H22 = m2 l2^2/3", notation=rod)
    assert fb.check(ARM, "H22 = m2 lc2^2 + I2", notation=rod)
    assert not fb.check(ARM, "H22 = m2 l2^2/4", notation=rod)
    assert not fb.check(ARM, "H22 = m2 l2^2/3")
    point = own_notation(tmp_path, "point", parameters={"I": "0", "lc": "l"})
    assert fb.check(ARM, "H11 = m1 l1² + m2 (l1² + l2² + 2 l1 l2 c2)", notation=point)


@pytest.mark.parametrize("zero", ["down", "up"])
def test_angles_may_be_measured_from_the_vertical(tmp_path: Path, zero: str):
    style = own_notation(tmp_path, "tedrake", zero=zero)
    sign = "" if zero == "down" else "-"
    right = f"G1 = {sign}(m1 lc1 + m2 l1) g s1 {sign or '+'} m2 g lc2 s12"
    assert fb.check(ARM, right, notation=style)
    wrong = fb.check(ARM, "G2 = m2 g lc2 c12", notation=style)
    assert not wrong
    own = f"here it is measured from the vertical ({zero}wards)"
    assert any(own in cause for cause in wrong.causes), wrong
    assert fb.check(ARM, "H12 = m2 (lc2² + l1 lc2 c2) + I2", notation=style)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("title = 3", "mine.toml:1: title is 3, expected text"),
        ("angle = 'absolute'", "mine.toml:1: no key 'angle'"),
        ("angles = 'relativ'", "Did you mean 'relative'[?] Angles: relative, absolute"),
        ("zero = 'north'", "no zero 'north'"),
        ("[letters]\nmas = 'B'", "mine.toml:2.*no key 'mas'.*Did you mean 'mass'"),
        ("names = 'a'", "names is a table"),
        ("[parameters]\nlc9 = 'l1'", "no parameter 'lc9'"),
        (
            "[parameters]\nlc = 'l/'",
            "the parameter lc = l/: the line ends where a term",
        ),
        ("[parameters]\nlc1 = 'l1 l2'", "^check: the parameter lc1 = l1 l2: [^:]*expected[.]$"),
        ("[parameters]\nlc1 = 'L1'", "no quantity 'L1' .* Did you mean 'l1'"),
        ("[parameters]\nlc1 = 'I1/m1'", "the parameter lc1 = I1/m1: "),
        ("[parameters]\nlc1 = 'lc2'\nlc2 = 'l2'", "names a parameter that is given by a formula"),
        ("[parameters]\nm2 = 'theta1'", "m2 = theta1 changes with the motion"),
        ("[parameters]\nlc2 = 'l2*cos(theta2)'", "changes with the motion"),
        ("[letters]\nmass = 'A'\ncoriolis = 'C A'", "mine.toml:3.*A stands for mass and coriolis"),
        ("[names]\n'a b' = 'l1'", "not a single name"),
        ("title = ", "not valid TOML"),
    ],
)
def test_a_malformed_notation_is_refused_with_its_place(tmp_path: Path, text: str, words: str):
    file = tmp_path / "mine.toml"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(fb.FreebodyError, match=words):
        fb.check(ARM, "H22 = m2 lc2^2 + I2", notation=file)


@pytest.mark.parametrize(
    ("letters", "right"),
    [
        ({"mass": "C"}, "C22 = m2 lc2^2 + I2"),
        ({"gravity": "C"}, "C2 = m2 g lc2 c12"),
        ({"mass": "J"}, "J22 = m2 lc2^2 + I2"),
        ({"velocity": "H"}, "H2 = m2 l1 lc2 s2 θ̇1²"),
    ],
)
def test_a_letter_that_is_given_to_one_quantity_is_no_others(
    tmp_path: Path, letters: dict, right: str
):
    style = own_notation(tmp_path, "own", letters=letters)
    assert fb.check(ARM, right, notation=style)
    assert not fb.check(ARM, right.replace("= ", "= 2 "), notation=style)


def test_presets_are_files_that_name_their_source():
    plain = fb.derive(ARM, "lagrange").text()
    assert fb.derive(ARM, "lagrange", notation="notes").text() == plain
    told = [fb.derive(ARM, "lagrange", notation=name).text() for name in NOTATIONS[1:]]
    sources = {text.partition("\nLetters: ")[2] for text in told}
    assert len(sources) == len(told) >= 6
    assert all(len(source) > 20 for source in sources)
    with pytest.raises(fb.FreebodyError, match=r"no notation 'crag'.*Did you mean 'craig'"):
        fb.check(ARM, "H22 = 0", notation="crag")


def test_a_book_whose_names_the_robot_has_keeps_them():
    """Where the arm itself is named as Siciliano does, l1 is its own."""
    arm = fb.planar("RR", l=["a1", "a2"], lc=["l1", "l2"], m=["ml1", "ml2"], I=["Il1", "Il2"])
    assert fb.check(arm, "b22 = Il2 + ml2 l2^2", notation="siciliano")


def test_the_command_takes_a_notation(own: Path, capsys: pytest.CaptureFixture[str]):
    assert run(["check", "RR", "B22 = m2 L2^2/3", "--notation", str(own)]) == 0
    assert run(["check", "RR", "V2 = m2 l1 lc2 s2 θ̇1²", "--notation", "craig"]) == 0
    assert run(["check", "RR", "V2 = 0", "--notation", "nowhere.toml"]) == 2
    assert "nowhere.toml" in capsys.readouterr().err


def test_letters_that_a_notation_does_not_have_are_ones_own():
    with pytest.raises(fb.AnswerError, match="D22 is taken for a name of your own"):
        fb.check(ARM, "D22 = m2 lc2^2 + I2", notation="craig")


def test_a_letter_that_derivations_have_for_forces_may_be_gravitys(tmp_path: Path):
    """Khalil and Dombre call gravity's torques Q and those of the motors Γ."""
    letters = {"torque": "Gamma", "mass": "A", "gravity": "Q"}
    style = own_notation(tmp_path, "khalil", letters=letters, terms="matrix")
    steps = fb.derive(ARM, "lagrange", notation=style).steps
    assert str(steps[0].equations[1]) == "Γ = [Γ₁, Γ₂]ᵀ"
    closed = next(step for step in steps if step.operation == "The closed form")
    gravity = [str(x) for x in closed.equations if str(x).startswith("Q")]
    assert len(gravity) == 2
    assert fb.check(ARM, "\n".join(gravity), notation=style)


@pytest.mark.parametrize("options", [{"notation": 5}, {"parameters": 5}])
def test_a_notation_of_another_type_is_refused(options: dict):
    with pytest.raises(fb.FreebodyError, match=next(iter(options))):
        fb.check(ARM, "T = 0", **options)
