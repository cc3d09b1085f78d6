"""Expressions for print: names, brackets, signs, and each renderer."""

from __future__ import annotations

import json
import math
import subprocess
import sys
import xml.etree.ElementTree as ET
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from unicodedata import normalize

import numpy as np
import pytest

import freebody as fb
from freebody.expressions import expression as ex
from freebody.expressions.evaluate import NoValue, arithmetic
from freebody.expressions.evaluate import evaluate as walk
from freebody.expressions.expression import (
    add,
    cos,
    cross,
    d_dt,
    div,
    dot,
    eq,
    expr,
    mul,
    neg,
    power,
    sin,
    sub,
)
from freebody.expressions.grammar.tables import characters, classes, spellings
from freebody.expressions.nodes import nodes, replaced
from freebody.expressions.printed_names import entry, sym, vec
from freebody.expressions.typesetting.latex import width_of
from freebody.expressions.typesetting.text import TEXT
from freebody.expressions.typesetting.typesetter import broken
from freebody_textbook.check.asked.right_equations import setting
from freebody_textbook.check.verdicts.verdict_sentences import example
from freebody_textbook.closed_chains.linear_equations import product
from freebody_textbook.equations.source_code import to_sympy
from freebody_textbook.relations.formula import FormulaError, parse
from freebody_textbook.relations.formula_values import Each, value
from freebody_textbook.relations.relation import agrees, printed_numbers
from support.extras import extra
from support.printed_values import evaluate


@pytest.mark.parametrize(
    ("name", "text", "latex"),
    [
        ("theta1", "θ₁", r"\theta_1"),
        ("theta1_d", "θ̇₁", r"\dot{\theta}_1"),
        ("theta2_dd", "θ̈₂", r"\ddot{\theta}_2"),
        ("theta12", "θ₁₂", r"\theta_{12}"),
        ("d2_dd", "d̈₂", r"\ddot{d}_2"),
        ("l1", "l₁", "l_1"),
        ("lc1", "lc₁", "l_{c1}"),
        ("m10", "m₁₀", "m_{10}"),
        ("I1", "I₁", "I_1"),
        ("I1xx", "I₁xx", "I_{1,xx}"),
        ("c1x", "c₁x", "c_{1x}"),
        ("tau1", "τ₁", r"\tau_1"),
        ("H11", "H₁₁", "H_{11}"),
        ("H_10_2", "H₁₀,₂", "H_{10,2}"),
        ("h", "h", "h"),
        ("f01", "f₀₁", "f_{0,1}"),
        ("f_9_10", "f₉,₁₀", "f_{9,10}"),
        ("omega2z_d", "ω̇₂z", r"\dot{\omega}_{2z}"),
        ("sgn_theta1_d", "sgn(θ̇₁)", r"\operatorname{sgn}(\dot{\theta}_1)"),
        ("lam", "λ", r"\lambda"),
        ("payload", "payload", r"\mathrm{payload}"),
        ("r_G", "r_G", "r_G"),
        ("link_mass", "link_mass", r"\mathrm{link}_{\mathrm{mass}}"),
    ],
)
def test_names(name: str, text: str, latex: str) -> None:
    assert str(sym(name)) == normalize("NFC", text)
    assert sym(name).latex() == latex


def test_vectors_are_bold_and_entries_numbered() -> None:
    assert vec("vc1_d").latex() == r"\dot{\mathbf{v}}_{c1}"
    assert vec("omega1").latex() == r"\boldsymbol{\omega}_1"
    assert entry("H", 1, 2) == sym("H12")
    assert entry("H", 10, 2).name == "H_10_2"
    assert str(entry("tau", 12)) == "τ₁₂"


@pytest.mark.parametrize(
    ("expression", "text", "latex"),
    [
        (add("a", neg("b"), mul(-2, "c")), "a − b − 2 c", "a - b - 2 c"),
        (sub("a", add("b", "c")), "a − (b + c)", "a - (b + c)"),
        (neg(add("a", "b")), "−(a + b)", "-(a + b)"),
        (add(neg("a"), "b"), "−a + b", "-a + b"),
        (mul("a", neg("b")), "−a b", "-a b"),
        (mul("a", add("b", "c"), 3), "3 a (b + c)", "3 a (b + c)"),
        (mul(Fraction(1, 2), "a"), "½ a", r"\tfrac{1}{2}\,a"),
        (mul(Fraction(5, 7), "a"), "5/7 a", r"\tfrac{5}{7}\,a"),
        (mul(ex.num(Fraction(1, 4), decimal=True), "a"), "0.25 a", r"0.25\,a"),
        (ex.num(Fraction(123, 10**9), decimal=True), "1.23·10⁻⁷", r"1.23\cdot 10^{-7}"),
        (ex.num(Fraction(22, 7), decimal=True), "3.14286", "3.14286"),
        (power("lc1", 2), "lc₁²", "l_{c1}^2"),
        (power("theta1_d", 2), "θ̇₁²", r"\dot{\theta}_1^2"),
        (power(add("a", "b"), 2), "(a + b)²", "(a + b)^2"),
        (power(cos("theta1"), 2), "cos² θ₁", r"\cos^2 \theta_1"),
        (power("J", -1), "J⁻¹", "J^{-1}"),
        (cos(add("theta1", "theta2")), "cos(θ₁+θ₂)", r"\cos(\theta_1+\theta_2)"),
        (sin(mul(2, "theta1")), "sin 2θ₁", r"\sin 2 \theta_1"),
        (mul(sin("theta1"), cos("theta2")), "sin θ₁ cos θ₂", r"\sin \theta_1\,\cos \theta_2"),
        (mul(sin("theta1"), "theta2_d"), "sin(θ₁) θ̇₂", r"\sin \theta_1\,\dot{\theta}_2"),
        (mul(power(sin("theta1"), 2), "a"), "sin²(θ₁) a", r"\sin^2 \theta_1\,a"),
        (div(add("a", "b"), "c"), "(a + b)/c", r"\frac{a + b}{c}"),
        (div(neg("a"), mul("b", "c")), "−a/(b c)", r"-\frac{a}{b c}"),
        (
            neg(cross(vec("sc1"), vec("f01"))),
            "−sc₁ × f₀₁",
            r"-\mathbf{s}_{c1} \times \mathbf{f}_{0,1}",
        ),
        (
            cross(vec("w"), cross(vec("w"), vec("r"))),
            "w × (w × r)",
            r"\mathbf{w} \times (\mathbf{w} \times \mathbf{r})",
        ),
        (mul("m", dot(vec("v"), vec("v"))), "m (v · v)", r"m (\mathbf{v} \cdot \mathbf{v})"),
        (
            cross(sub(vec("a"), vec("b")), neg(vec("c"))),
            "(a − b) × (−c)",
            r"(\mathbf{a} - \mathbf{b}) \times (-\mathbf{c})",
        ),
        (
            d_dt(ex.partial("L", "theta1_d")),
            "d/dt (∂L/∂θ̇₁)",
            r"\frac{\mathrm{d}}{\mathrm{d}t}\left(\frac{\partial L}{\partial "
            r"\dot{\theta}_1}\right)",
        ),
        (ex.vector("a", add("b", "c")), "[a, b + c]ᵀ", r"\begin{bmatrix} a \\ b + c \end{bmatrix}"),
        (
            ex.matrix([["a", 0], [0, "b"]]),
            "[a, 0; 0, b]",
            r"\begin{bmatrix} a & 0 \\ 0 & b \end{bmatrix}",
        ),
        (mul(ex.transposed("J"), vec("f")), "Jᵀ f", r"J^{\mathsf{T}} \mathbf{f}"),
        (eq("H12", "H21", "a"), "H₁₂ = H₂₁ = a", "H_{12} = H_{21} = a"),
        (ex.words("with"), "with", r"\text{with}"),
    ],
)
def test_print(expression: ex.Expression, text: str, latex: str) -> None:
    assert str(expression) == text
    assert expression.latex() == latex
    ET.fromstring(expression.mathml())


@pytest.mark.parametrize(
    ("formula", "text", "latex"),
    [
        ("log(x*y)*sqrt(x)", "log(xy) √x", r"\log(x y)\,\sqrt{x}"),
        ("sin(cos(y)^2*sin(y))", "sin(cos² y sin y)", r"\sin(\cos^2 y\,\sin y)"),
        ("sin(cos(x))", "sin(cos x)", r"\sin(\cos x)"),
        ("sin(2*x)*cos(y)", "cos y sin 2x", r"\cos y\,\sin 2 x"),
        ("sqrt(x + y)", "√(x + y)", r"\sqrt{x + y}"),
        ("x*sqrt(x*y)", "x √(x y)", r"x \sqrt{x y}"),
    ],
)
def test_arguments_end_where_they_seem_to(formula: str, text: str, latex: str) -> None:
    (expression,) = fb.vector_function([formula], ["x", "y"]).expressions
    assert (str(expression), expression.latex()) == (text, latex)
    root = ET.fromstring(expression.mathml())
    assert bool(root.findall(".//{*}msqrt")) == ("sqrt" in formula)


def test_building() -> None:
    assert add() == expr(0)
    assert add("a", 0, add("b", "c")) == add("a", "b", "c")
    assert sub("a", 0) == sym("a")
    assert mul("a", 0) == expr(0)
    assert mul(2, mul("a", 3)) == mul(6, "a")
    assert mul(neg("a"), neg("b")) == mul("a", "b")
    assert neg(neg("a")) == sym("a")
    assert power("a", 0) == expr(1)
    assert power("a", 1) == sym("a")
    assert ex.size(mul(2, "a", add("b", "c"))) == 4
    assert hash(add("a", "b")) == hash(add("a", "b"))
    equation = eq("a", "b", "c")
    assert (equation.lhs, equation.rhs) == (sym("a"), sym("c"))
    assert equation._repr_latex_() == r"$\displaystyle a = b = c$"


def test_evaluate() -> None:
    at = {"a": np.array([1.0, 2.0]), "b": 3.0, "theta1": 0.5, "theta1_d": -2.0}
    found = evaluate(eq("x", add(mul(2, "a", power("b", 2)), neg(div("b", "a")))), at)
    np.testing.assert_allclose(found, [15.0, 34.5])
    assert evaluate(mul(sin("theta1"), ex.sgn("theta1_d")), at) == -np.sin(0.5)
    assert evaluate(cross(ex.vector(1, 2), ex.vector(3, 5)), at) == -1
    np.testing.assert_allclose(
        evaluate(cross(ex.vector(1, 0, 0), ex.vector(0, "b", 0)), at), [0, 0, 3]
    )
    assert evaluate(dot(ex.vector(1, 2), ex.vector(3, "b")), at) == 9
    np.testing.assert_allclose(
        evaluate(ex.transposed(ex.matrix([[1, 2], [3, "b"]])), at), [[1, 3], [2, 3]]
    )
    with pytest.raises(fb.UnknownNameError, match="no quantity 'c'"):
        value(sym("c"), at)
    with pytest.raises(NoValue, match="for print only") as told:
        walk(add("a", d_dt("a")), {**arithmetic(float), ex.Symbol: lambda node, _: at[node.name]})
    assert told.value.node == d_dt("a")


def test_pieces_of_a_text_are_equal_to_themselves_alone() -> None:
    """A printed node is what it prints; of two pieces of a text that say the same, each is its
    own."""
    one, other = ex.Product((sym("a"), sym("b"))), mul("a", "b")
    assert one == other
    assert hash(one) == hash(other)
    first, second = (replace(sym("a"), span=span) for span in ((0, 1), (4, 5)))
    assert first == first
    assert first != second
    assert first != sym("a")
    whole = ex.Sum((first, second), span=(0, 5))
    found = {first: 1, second: 2, whole: 3}
    assert [found[node] for node in nodes(whole)] == [3, 1, 2]
    assert replaced(whole, {second: sym("b")}).parts == (first, sym("b"))
    assert [str(x) for x in nodes(ex.matrix([["a", "b"], ["c", 1]]))][1:] == ["a", "b", "c", "1"]


def test_sympy() -> None:
    sympy = extra("sympy", "SymPy")
    a, b = sympy.symbols("a b", real=True)
    assert to_sympy(add(mul(Fraction(1, 2), power("a", 2)), neg(sin("b")))) == a**2 / 2 - sympy.sin(
        b
    )
    assert to_sympy(ex.matrix([["a", 1]])) == sympy.Matrix([[a, 1]])
    assert to_sympy(ex.sgn("a")) == sympy.sign(a)
    with pytest.raises(fb.FreebodyError, match="no counterpart"):
        to_sympy(cross("a", "b"))


def test_lines() -> None:
    long = eq(
        "x",
        add(mul("m", add(*(f"a{i}" for i in range(1, 8)))), *(neg(f"b{i}") for i in range(1, 8))),
    )
    whole = " ".join(broken(TEXT(long), 10**6))
    assert whole == str(long)
    lines = TEXT.lines(long, 40)
    assert lines[0] == "x = m (a₁ + a₂ + a₃ + a₄ + a₅ + a₆ + a₇)"
    assert all(len(line) <= 40 for line in lines)
    assert " ".join(lines) == whole
    assert all(line[0] in "−+" for line in lines[1:])


def test_a_name_that_is_nothing_but_the_mark_of_a_rate_is_a_name():
    assert (sym("_d").dots, sym("theta1_d").dots, sym("theta1_dd").dots) == (0, 1, 2)


def test_scripts_in_a_formula_are_narrower_than_letters_and_wider_than_nothing():
    assert width_of("x") < width_of("x_{12}") < width_of("x12") + width_of("{}")


def test_there_is_no_example_that_tells_an_answer_from_itself():
    where = setting(fb.equations(fb.planar("RR")), ())
    length, mass = where.ring["l1"], where.ring["m1"]
    assert example(where, length, length) is None
    assert example(where, length, mass) is not None


@pytest.mark.parametrize("power", [1, 2, 3])
def test_a_square_has_no_sign_of_its_factor(power: int):
    equations = fb.equations(fb.planar("RR"))
    ring = equations.symbols.ring
    factor = (
        ring.sin("theta1") * ring.cos("theta1") - ring["l1"] * ring["lc1"] - ring["l1"] * ring["l2"]
    )
    values = {"theta1": 0.4, "l1": 0.7, "l2": 0.5, "lc1": 0.3}
    number = math.sin(0.4) * math.cos(0.4) - 0.7 * 0.3 - 0.7 * 0.5
    x = ring["l1"]
    for _ in range(power):
        x = x * factor
    assert evaluate(product(x, equations.layout), values) == pytest.approx(
        0.7 * number**power, rel=1e-12
    )


def test_mutants_are_drawn_from_every_file():
    """The tool refuses where a file of the source is in none of its areas."""
    tool = Path(__file__).parents[3] / "tools/mutants.py"
    done = subprocess.run(
        [sys.executable, str(tool), "--list", "--count", "14"],
        capture_output=True,
        text=True,
        timeout=100,
        check=False,
    )
    assert done.returncode == 0, done.stderr[-500:]
    areas = [line.partition(":")[0] for line in done.stdout.splitlines()]
    assert len(areas) == len(set(areas)) == 14


ROWS = (
    "3*x^3*y - x/2 + 1",
    "sin(2*x)*exp(y) - cos(x - y)^2",
    "sqrt(x)*log(x*y)/(1 + y^2)",
    "tan(x)/y^2 + sqrt(x + sin(y)^3)",
    "exp(x)*exp(-2*y)/(x + 2*y)^3",
    "1/sqrt(x*y) + log(2 + cos(exp(x)))",
)


def test_sums_over_bodies():
    at = {"m": 3.0, "m_i": Each((1.0, 2.0)), "r_i": Each(((1.0, 0.0), (0.0, 1.0)))}
    assert fb.relation(at, "m = sum(m_i)")
    assert fb.relation(at, "sum(m_i*r_i) = [1, 2]")


def test_printed_numbers_and_their_last_digits():
    assert printed_numbers("[5.97, −7.190]") == [(5.97, 0.01), (-7.19, pytest.approx(0.001))]
    assert agrees([5.9731, -7.1896], "[5.97, -7.190]")
    assert not agrees([5.99, -7.1896], "[5.97, -7.190]")


@pytest.mark.parametrize("row", ROWS)
def test_what_a_function_prints_has_its_values(row: str):
    f = fb.vector_function([row], ["x", "y"])
    at = np.random.default_rng(3).uniform(0.3, 1.2, (20, 2))
    printed = [value(f.expressions[0], {"x": x, "y": y}) for x, y in at]
    np.testing.assert_allclose(printed, f(at)[:, 0], rtol=1e-13)


def test_formulas_have_the_grammar_of_answers() -> None:
    """A formula that cannot be read says where; powers, products, fractions and matrices are read
    as in an answer, with a sign in every product."""
    assert parse("2·m_1/3 − a²") == parse("2*m_1/3 - a^2")
    assert parse(r"\frac{a}{b} + \begin{bmatrix} a & b \\ c & 1 \end{bmatrix}") == parse(
        "a/b + [[a, b], [c, 1]]"
    )
    assert str(parse("dot([a, b], [c, 0.5])^-1")) == "([a, b]ᵀ · [c, 0.5]ᵀ)⁻¹"
    for text, place in (
        ("f = 2 m a", "there is 'm' where an operator or the end of the line is expected"),
        ("f = m*foo(a)", "no function 'foo'; there are arccos"),
        ("f = cross(a)", "cross is given 1 arguments"),
        ("f = a^b", "a power must be a whole number"),
        ("f = (a", "'\\(' is not closed"),
        ("f = a!", "'!' has no meaning here"),
        ("f = ", "the line ends where a term is expected"),
    ):
        with pytest.raises(FormulaError, match=place) as refused:
            parse(text)
        assert refused.value.line == 1
        assert "^" in refused.value.context


def test_a_greek_letter_with_a_number_is_no_name_between_two_bodies():
    assert str(parse("phi_2 + psi_i")) == "φ₂ + ψ_i"
    assert str(parse("R1_2 + vc1_i")) == "R₂¹ + vc_i¹"


@pytest.mark.parametrize("module", [characters, classes, spellings])
def test_tables_are_literals_that_another_language_can_read(module):
    """Nothing is lost on the way through JSON but that a tuple is a list."""
    tables = {name: x for name, x in vars(module).items() if name.isupper()}
    assert tables
    for x in tables.values():
        assert json.dumps(json.loads(json.dumps(x))) == json.dumps(x)
