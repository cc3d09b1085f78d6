"""What prints for people, by itself: numbers with their digits, names as they are in files, tables,
sentences with subscripts, names beside curves and contours of maps.

Public results show of these only what they happen to have.
"""

from __future__ import annotations

import math
import re
import tomllib
import xml.etree.ElementTree as ET
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import freebody as fb
from freebody.expressions.printed_names import sym
from freebody.expressions.typesetting import literal
from freebody.figures.curve_names import named_curves
from freebody.figures.marked_text import html, marked, plain, runs, width
from freebody.figures.plane_map import PlaneMap, contour, plane_map
from freebody.figures.plots import Plot, axes_of, plot
from freebody.outputs.display import TextTable, counted
from freebody.outputs.number_text import (
    compared,
    fixed,
    lifetime,
    percent,
    rounded_up,
    shortest,
    significant,
)
from freebody.report.results import LimitUse
from freebody.report.tables import PrintedNumber, WordsCell, aligned, opened, typeset
from freebody_textbook.render.prose import markdown_prose, tex_prose, text_prose, web_prose
from support.hostile import NAMES, balanced

_BOX = (50.0, 40.0, 330.0, 170.0)
_REACH = 6.0  # pixels that letters reach above and below the middle of their line


@pytest.mark.parametrize(
    ("value", "as_measured", "as_short"),
    [
        (0.4, "0.400", "0.4"),
        (-12.0, "−12.0", "−12"),
        (9.99e-4, "9.99·10⁻⁴", "0.000999"),
        (1e-3, "0.00100", "0.001"),
        (99999.0, "99999", "99999"),
        (-123456789.0, "−1.23·10⁸", "−123456789"),
        (2.5e-7, "2.50·10⁻⁷", "2.5·10⁻⁷"),
        (6e23, "6.00·10²³", "6·10²³"),
    ],
)
def test_a_number_prints_with_its_digits(value: float, as_measured: str, as_short: str) -> None:
    assert significant(value) == as_measured
    assert shortest(value) == as_short


def test_what_is_no_number_and_signs() -> None:
    assert [significant(x) for x in (math.nan, math.inf, -math.inf, 0.0)] == ["–", "∞", "−∞", "0"]
    assert fixed(-0.256, 2) == "−0.26"


@pytest.mark.parametrize("value", [3.14159, -2.5e-9, 7.5e6, 0.02, 1e-300])
@pytest.mark.parametrize("digits", [2, 4])
def test_what_is_printed_is_the_number(value: float, digits: int) -> None:
    """Read back, it is the number to the digits that are given."""
    raised = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")
    for text in (significant(value, digits), shortest(value, digits)):
        mantissa, _, power = text.replace("−", "-").partition("·10")
        read = float(f"{mantissa}e{power.translate(raised) or 0}")
        assert read == pytest.approx(value, rel=10.0 ** (1 - digits) / 2)


PAIRS = [(0.78539, 0.78541), (1.0 + 1e-9, 1.0), (100000.2, 100000.1), (-3.0, 3.0), (0.0, 1e-9)]


@pytest.mark.parametrize("pair", PAIRS)
def test_numbers_that_a_message_compares_differ_in_print(pair: tuple[float, float]) -> None:
    one, other = compared(*pair)
    assert one != other
    assert (float(one) < float(other)) == (pair[0] < pair[1])
    assert compared(pair[0], pair[0])[0] == compared(pair[0], pair[0])[1]


def test_compared_numbers_have_no_more_digits_than_it_takes() -> None:
    assert compared(1.23456, 9.87654) == ("1.235", "9.877")
    assert compared(0.78539, 0.78541) == ("0.78539", "0.78541")
    assert compared(math.inf, 2.0) == ("inf", "2")


def test_what_a_message_states_of_numbers_is_true_of_the_printed_ones() -> None:
    printed = compared(0.1, 0.2, 0.3000004, digits=6, holds=lambda a, b, c: a + b < c)
    assert printed == ("0.1", "0.2", "0.3000004")


def test_a_limit_that_is_exceeded_prints_so() -> None:
    use = LimitUse("speed", "elbow", 0.78541, 0.78539, 0.78541 / 0.78539, 1.0, "rad/s")
    assert use.exceeded
    assert use.text == (
        "the speed of elbow is 0.78541 rad/s at t = 1 s, 100.003 % of its limit of 0.78539 rad/s"
    )
    by_rounding = LimitUse(
        "position", "elbow", math.pi, math.nextafter(math.pi, 3), 1.0, 0.5, "rad", "upper"
    )
    assert by_rounding.text == (
        "elbow goes to 3.142 rad at t = 0.5 s, its upper limit being 3.142 rad"
    )
    at_zero = LimitUse("position", "elbow", 1.776e-15, 0.0, 1.0, 0.5, "rad", "lower")
    assert at_zero.text == "elbow goes to 0 rad at t = 0.5 s, its lower limit being 0 rad"


def test_what_has_to_be_given_at_least_is_never_rounded_down() -> None:
    assert rounded_up(1.234501, 4) == "1.235"
    assert rounded_up(1.2349, 4) == "1.235"
    assert rounded_up(1.25, 4) == "1.25"
    rng = np.random.default_rng(3)
    for x in np.exp(rng.uniform(-20, 20, 200)):
        assert x <= float(rounded_up(float(x), 5)) <= x * (1 + 1e-4)


# ---------------------------------------------------------------- the functions
@pytest.mark.parametrize("name", NAMES)
def test_escaped_names_are_letters_to_tex(name: str):
    """What is left after the known commands has no character that TeX reads as anything but
    itself."""
    for made in (
        literal.tex(name),
        tex_prose(f"link {literal.literal(name)} of x_1").split(" of $x")[0],
    ):
        rest = re.sub(r"\\text[a-z]+\{\}|\\[&%$#_{}]|\$\\[a-z]+\$", "", made)
        assert not re.search(r"[\\&%$#_{}~^<>|\"]", rest), made
    formula = literal.tex_math(name)
    assert formula == name or formula == f"\\text{{{literal.tex(name)}}}"


@pytest.mark.parametrize("name", NAMES)
def test_names_in_sentences_are_no_symbols(name: str):
    sentence = f"point {literal.literal(name)} of s_1"
    shown = "".join(c if c.isprintable() else "\ufffd" for c in " ".join(name.split()))
    assert text_prose(sentence) == f"point {shown} of s₁"
    page = ET.fromstring(f"<p>{web_prose(sentence)}</p>")
    assert "".join(page.itertext()) == f"point {shown} of s1"
    assert [e.tag for e in page] == ["b", "sub"]
    unescaped = re.sub(
        r"\\(.)", r"\1", markdown_prose(sentence).removesuffix(r" of $\mathbf{s}_{1}$")
    )
    assert unescaped == f"point {shown}"


def test_factors_of_products_of_vectors_are_set_as_vectors():
    """Beside the components, which are not."""
    sentence = "by components, a × b = a_x b_y − a_y b_x, or a · b; ω × I ω"
    page = ET.fromstring(f"<p>{web_prose(sentence)}</p>")
    assert [e.text for e in page if e.tag == "b"] == ["a", "b", "a", "b"]
    assert [e.text for e in page if e.tag == "i"] == ["a", "b", "a", "b"]
    assert "".join(page.itertext()).replace("ax", "a_x") == (
        "by components, a × b = a_x by − ay bx, or a · b; ω × I ω"
    )
    assert text_prose(sentence) == sentence
    assert tex_prose("a × b").startswith(r"$\mathbf{a}$")


def test_plain_names_have_no_marks():
    assert literal.literal("link2") == "link2"
    assert literal.MARK not in text_prose(f"link {literal.literal('a_b')}")


def test_foreign_letters_are_declared_to_tex():
    lines = literal.declared("关节 θ é – x")
    assert any("5173" in line for line in lines)
    assert not any("03B8" in line or "2013" in line for line in lines)
    assert literal.declared("plain é – θ") == []


def test_what_is_said_of_bundled_robots_is_set_by_any_tex():
    said = [
        tomllib.loads(file.read_text("utf-8")).get("about", "")
        for file in sorted(Path(fb.__file__).parent.glob("robots/*.toml"))
    ]
    assert any("₂" in about for about in said)
    assert literal.declared(literal.tex(" ".join(said))) == []
    assert literal.tex("θ̇₁² − x̂") == r"$\dot{\theta}$$_{1}$² $-$ x̂"


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    "name", ["θ1", "left_upper_arm_length_of_the_first_robot", "a__b", "é", "l_", "_"]
)
def test_names_of_parameters_are_legible_formulas(name: str):
    """What a parameter may be called, in LaTeX, MathML and a drawing."""
    formula = sym(name).latex()
    assert balanced(formula)
    assert not re.search(r"(?<!\\)_(?!\{|[A-Za-z0-9])", formula), formula
    ET.fromstring(sym(name).mathml())
    model = fb.planar("RR", l=[name, "l2"])
    for drawing in fb.kinematic_diagram(model).drawings:
        ET.fromstring(fb.kinematic_diagram(model).svg)
        assert drawing


def test_a_long_reason_is_folded_and_whole():
    """At the end of a sentence or clause; a text without one is not cut."""
    text = "; ".join(f"link{k} has no mass" for k in range(60)) + ". It is not judged."
    first, rest = opened(text, 200)
    assert len(first) <= 200
    assert f"{first} {rest}" == text
    assert first.endswith(";")
    assert opened("a" * 500, 200) == ("a" * 500, "")
    assert opened(text, len(text)) == (text, "")


@pytest.mark.parametrize("peak", [0.3, 0.5, 0.55, 0.98])
@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_the_value_of_a_peak_stands_beside_the_line_of_an_instant(peak: float, sign: float):
    """The cursor of a page begins there, and would strike it through."""
    t = np.linspace(0.0, 1.0, 101)
    curve = sign * (20.0 - 30.0 * (t - peak) ** 2)
    what = Plot("Torque", t, {"total": curve}, "N m", now=0.5, names=False)
    body = ET.fromstring(f"<g>{plot(what).body}</g>")
    (text,) = (x for x in body.iter("text") if x.get("class") == "tick halo")
    left, _, right, _ = axes_of(what).box
    at, half = float(text.get("x", "nan")), width(text.text or "", 11) / 2
    assert left <= at - half
    assert at + half <= right + 1.0
    assert abs(at - (left + right) / 2) > half


@pytest.mark.parametrize("name", ["j_{}", "j_{1}", "a_b", "j_{", "_{<&>}"])
def test_curves_are_called_what_their_joints_are(name: str):
    """A name stands beside its curve letter by letter, or in a legend that leaves it room where
    curves are on one another; braces after a bar made the page of a study fail."""
    t = np.linspace(0.0, 1.0, 5)

    def named(second: np.ndarray) -> list[ET.Element]:
        body = plot(Plot("Torque", t, {name: t, "next": second}, "N m")).body
        texts = ET.fromstring(f"<g>{body}</g>").iter("text")
        return [x for x in texts if x.text in (name, "next")]

    beside = named(-t)
    assert [(x.text, x.get("class")) for x in beside] == [
        (name, "num halo f0"),
        ("next", "num halo f1"),
    ]
    legend = plot(Plot("Torque", t, {name: t, "next": -t}, "N m", size=(150.0, 90.0)))
    first, second = (
        x for x in ET.fromstring(f"<g>{legend.body}</g>").iter("text") if x.get("class") == "num"
    )
    assert (first.text, second.text) == (name, "next")
    assert float(second.get("y", 0)) > float(first.get("y", 0)) or float(
        second.get("x", 0)
    ) - float(first.get("x", 0)) > 40 + 4 * len(name)


@pytest.mark.parametrize("text", ["j_{}", "m_{a<b}", "2 θ_12 & x_{1,2}"])
def test_text_with_subscripts_is_well_formed(text: str):
    letters = plain(text)
    for made in (marked(runs(text)), html(text)):
        assert "".join(ET.fromstring(f"<g>{made}</g>").itertext()) == letters


def test_long_tables_say_what_is_left_out():
    table = TextTable(("k",), [(str(k),) for k in range(100)], ["a & b"])
    assert table.html(most=3).count("<tr>") == 4
    assert "<p>… and 97 more</p><p>a &amp; b</p>" in table.html(most=3)
    assert TextTable((), ()).html("nothing <here>") == "<p><b>nothing &lt;here&gt;</b></p>"


def test_columns_of_a_table():
    table = TextTable(("name", "value", "empty"), [("a", "-1.5 N", ""), ("b", "", "")])
    assert table.html() == (
        '<table><thead><tr><th style="text-align:left">name</th><th>value</th></tr></thead><tbody>'
        '<tr><td style="text-align:left">a</td><td>-1.5 N</td></tr>'
        '<tr><td style="text-align:left">b</td><td></td></tr></tbody></table>'
    )


def test_counted():
    assert [counted(k, "body") for k in (1, 2)] == ["1 body", "2 bodies"]
    assert counted(0, "loop") == "0 loops"


def test_what_is_at_its_limit_is_not_marked_as_beyond():
    """As the verdict: a speed of 1.0000000000000002 of 1 rad/s is within."""
    at, beyond = (PrintedNumber(x, "speed", {}, bar=x) for x in (1.0 + 1e-15, 1.001))
    assert (at.over, beyond.over, PrintedNumber(2.0, "speed", {}).over) == (False, True, False)


# ---------------------------------------------------------------- how numbers are printed
def numbers(*values: float) -> list[str]:
    return [cell.text for cell in aligned([PrintedNumber(v, "x", {}) for v in values])]


def test_column_has_one_number_of_decimals():
    assert numbers(-67.27, 2.72, 1.82, 5.62) == ["−67.27", "2.72", "1.82", "5.62"]
    assert numbers(1234.5, 12.25, 0.5) == ["1234.5", "12.2", "0.5"]


def test_small_and_missing_numbers_are_not_printed_as_zero():
    assert numbers(67.0, 5.0, 0.000946) == ["67.00", "5.00", "9.5·10⁻⁴"]
    assert numbers(67.0, 5.0, 1e-15) == ["67.00", "5.00", "0"]
    assert numbers(float("nan"), float("inf"), 2.0) == ["–", "∞", "2.00"]
    assert aligned([WordsCell("word")]) == [WordsCell("word")]


@pytest.mark.parametrize(
    ("value", "text"), [(0, "0"), (3.14159, "3.14"), (-2e-7, "−2.00·10⁻⁷"), (123456, "1.23·10⁵")]
)
def test_significant_digits(value, text):
    assert significant(value) == text


def test_sentences_are_typeset_and_escaped():
    assert typeset("needs -67.27 N m <at> 1.96e+04, 10^3.2-fold") == (
        "needs −67.27 N m &lt;at&gt; 1.96·10⁴, 10<sup>3.2</sup>-fold"
    )


def test_a_share_is_not_rounded_across_its_limit():
    assert percent(1.004) == "100.40 %"
    assert percent(0.9996) == "99.96 %"
    assert percent(2.391) == "239 %"
    assert percent(1.0 - 1e-12) == percent(1.0) == "100 %"


def test_a_life_is_promised_rounded_down_and_no_longer_than_anybody_measured():
    lives = (3.6e16, math.inf, 1.0e6, 44_567.0, 6163.9, 12.39, 0.04567)
    assert [lifetime(x) for x in lives] == [
        "practically unlimited (beyond 1e6 h)", "practically unlimited (beyond 1e6 h)",
        "1000000 h", "44500 h", "6160 h", "12.3 h", "0.0456 h",
    ]  # fmt: skip


def curves(seed: int, count: int) -> dict[str, np.ndarray]:
    """Smooth curves in a plot's box, with names of some length."""
    rng = np.random.default_rng(seed)
    x = np.linspace(_BOX[0], _BOX[2], 60)
    waves = rng.uniform(0.2, 3.0, count), rng.uniform(0.0, 6.0, count), rng.uniform(0.1, 1.0, count)
    found = {}
    for k, (pace, phase, size) in enumerate(zip(*waves, strict=True)):
        y = 105.0 + 60.0 * size * np.sin(pace * (x - 50.0) / 45.0 + phase)
        found["joint" * (1 + k % 3) + str(k)] = np.stack([x, y], axis=-1)
    return found


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 8))
def test_names_stand_beside_their_curves_and_on_nothing_else(seed: int, count: int):
    drawn = curves(seed, count)
    taken = [(180.0, 40.0, 230.0, 60.0)]
    placed = named_curves(drawn, _BOX, taken)
    boxes = [*taken]
    for label in placed:
        half = width(label.name, 12.0) / 2
        left, right = label.at.real - half, label.at.real + half
        top, bottom = label.at.imag - 4 - _REACH, label.at.imag - 4 + _REACH
        assert _BOX[0] <= left < right <= _BOX[2]
        assert _BOX[1] <= top < bottom <= _BOX[3]
        for a, b, c, d in boxes:
            assert right <= a or left >= c or bottom <= b or top >= d
        boxes.append((left, top, right, bottom))
        x, y = drawn[label.name].T
        beside = np.hypot(np.clip(x, left, right) - x, np.clip(y, top, bottom) - y)
        assert beside.min() < 30.0
        for points in drawn.values():
            inside = (points > (left, top)) & (points < (right, bottom))
            assert inside.all(axis=1).sum() <= 3


def test_most_names_find_a_place():
    """A legend is the exception: of three waves at least two are named beside themselves."""
    named = [len(named_curves(curves(seed, 3), _BOX)) for seed in range(20)]
    assert np.mean(named) > 2.0


def test_a_second_axis_says_the_same_in_another_unit():
    t = np.linspace(0.0, 1.0, 20)
    what = Plot("Speed", t, {"a": 3.0 * t}, "rad/s", also=(30.0 / np.pi, "rpm"), peaks=False)
    texts = list(ET.fromstring(f"<g>{plot(what).body}</g>").iter("text"))
    ticks = [(x.get("text-anchor"), float(x.get("y", 0)), x.text or "") for x in texts
             if x.get("class") == "tick" and x.get("text-anchor") != "middle"]  # fmt: skip
    heights = [
        np.array(
            [(y, float(text.replace("−", "-"))) for anchor, y, text in ticks if anchor == side]
        )
        for side in ("end", None)
    ]
    (first, second) = (np.polyfit(side[:, 1], side[:, 0], 1) for side in heights)
    assert second[1] == pytest.approx(first[1], abs=0.2)  # zero is at one height
    assert first[0] / second[0] == pytest.approx(30.0 / np.pi, rel=0.01)


def test_contours_are_circles_of_a_cone():
    x = y = np.linspace(-1.0, 1.0, 41)
    cone = np.hypot(x[None, :], y[:, None])
    cone[:, :8] = np.nan
    ends = np.array(list(contour(x, y, cone, 0.5))).reshape(-1, 2)
    assert np.hypot(*ends.T) == pytest.approx(0.5, abs=2e-3)
    assert ends[:, 0].min() > x[8] - 1e-12
    turned = np.arctan2(ends[:, 1], ends[:, 0])
    seen = np.sort(turned[np.abs(turned) < 2.2])
    assert np.diff(seen).max() < 0.15  # without gaps: a cell is 0.1 wide seen from the middle
    assert list(contour(x, y, cone, 9.0)) == []


def test_a_saddle_is_two_lines():
    grid = np.array([0.0, 1.0])
    two = list(contour(grid, grid, np.array([[1.0, -1.0], [-1.0, 1.0]]), 0.0))
    assert len(two) == 2
    corner = np.array([[0.0, 1.0], [1.0, 0.0]])  # of the high middle the low corners are cut off
    cut = list(contour(grid, grid, np.array([[3.0, -1.0], [-1.0, 3.0]]), 0.0))
    for a, b in cut:
        assert min(np.abs(a - c).max() + np.abs(b - c).max() for c in corner) < 1.0


def test_a_map_is_read_where_most_values_are():
    """A few huge values near a singular pose leave the contours where the others are."""
    x = np.linspace(0.1, 1.0, 30)
    values = np.broadcast_to(5.0 / x, (20, 30)).copy()
    values[3, 4] = 1e6
    what = PlaneMap("Payload", "kg", x, np.linspace(0.0, 0.6, 20), values, "m out", "m up")
    assert what.levels[0] >= 5.0
    assert what.levels[-1] < 50.0
    assert len(what.levels) > 3
    text = plane_map(what).text()
    root = ET.fromstring(text)
    said = [x.text for x in root.iter("{http://www.w3.org/2000/svg}text")]
    assert sum(str(x).endswith(" kg") for x in said) >= 3
    assert {"m out", "m up", "Payload"} <= set(said)
