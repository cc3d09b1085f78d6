"""The language of formulas inside `fb.relation`: how it is read, values for each body, and numbers
as they are printed, which no public function gives by themselves."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody_textbook.relations.formula import FormulaError, parse
from freebody_textbook.relations.formula_values import Each, value
from freebody_textbook.relations.relation import agrees, printed_numbers

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
