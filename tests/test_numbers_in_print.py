"""How numbers print for people."""

from __future__ import annotations

import math

import pytest

from freebody.outputs.numbers import fixed, shortest, significant


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
