"""Units that pages show are those in which the values are counted: with other units of length, mass
and time they change as these do."""

from __future__ import annotations

import math
import re

import numpy as np
import pytest

import freebody as fb
from freebody_textbook.living.line_values import line_values
from freebody_textbook.living.living import units_of_lines
from freebody_textbook.living.page_program import PageProgram, entries
from freebody_textbook.living.panel import LineUnits, units_of_symbols

METER, KILOGRAM, SECOND = 2.0, 3.0, 5.0
NEWTON = KILOGRAM * METER / SECOND**2
FACTORS = {"m": METER, "kg": KILOGRAM, "s": SECOND, "N": NEWTON, "J": NEWTON * METER, "rad": 1.0}


def factor(unit: str) -> float:
    """Of a unit such as "kg m²" or "N m/rad"."""
    above, _, below = unit.partition("/")
    top, bottom = (
        math.prod(
            FACTORS[name] ** (2 if square else 1)
            for name, square in re.findall("([a-zA-Z]+)(²?)", part)
        )
        for part in (above, below)
    )
    return top / bottom


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("letters", "method"),
    [("RP", "newton-euler"), ("RR", "lagrange"), ("RP", "kane"), ("PR", "lagrange-first-kind")],
)
def test_units_are_those_of_the_values(letters, method):
    derivation = fb.derive(fb.planar(letters), method)
    symbols = derivation.equations.symbols
    kernel = PageProgram(symbols.ring.names, derivation.equations.layout.form)
    units = units_of_symbols(derivation)
    inputs = [name for name in symbols.ring.names if not name.startswith("sgn")]
    assert all(units[name] for name in inputs)
    lines, unit_of = line_values(derivation).lines, units_of_lines(derivation, units)
    told = []
    for line in lines:  # without a unit: a number in any units
        parts, units_told = entries(line.value), unit_of(line).split(", ")
        each = units_told * len(parts) if len(units_told) == 1 else units_told
        told += zip(parts, each, strict=True)
    given = dict(zip(inputs, np.linspace(0.4, 1.3, len(inputs)), strict=True))
    other = {name: x * factor(units[name]) for name, x in given.items()}
    first, second = (kernel.at_random([x for x, _ in told], **x)[:, 0] for x in (given, other))
    np.testing.assert_allclose(second, first * [factor(unit) for _, unit in told], rtol=1e-12)


NUMBERED = """
name = "numbered"
dim = 2
[[link]]
name = "ground"
[[link]]
name = "arm"
mass = 3
com = [2, 0]
inertia = "J"
[[joint]]
name = "shoulder"
kind = "revolute"
parent = "ground"
child = "arm"
"""


def test_plain_numbers_for_lengths_do_not_mislead(tmp_path):
    """6 g cos θ is a torque, though its symbols are those of an acceleration."""
    path = tmp_path / "numbered.toml"
    path.write_text(NUMBERED, encoding="utf-8")
    derivation = fb.derive(fb.load(path), "lagrange")
    unit_of = units_of_lines(derivation, units_of_symbols(derivation))
    units = {str(x.line.lhs): unit_of(x) for x in line_values(derivation).lines}
    assert (units["q"], units["Q"], units["τ₁"]) == ("rad", "N m", "N m")
    assert {unit for name, unit in units.items() if "∂L" in name} == {""}


def test_partial_velocities_are_in_axes_of_their_body_and_scalars_in_none(page_of):
    """v_c2,1 is of body 2, by the rate of joint 1."""
    page = page_of("furuta", "kane").read_text(encoding="utf-8")
    rows = re.findall(r'<p class="value".*?</p>', page)
    (partial,) = [row for row in rows if 'data-name="vc2_1"' in row]
    assert "(in axes of body 2)" in partial
    forces = [row for row in rows if "<mi>F</mi>" in row]
    assert len(forces) == 4
    assert not [row for row in forces if "axes" in row]
    sliders = re.findall(
        r"</output>([^<]*)</span>", page_of("2R", "kinematics").read_text(encoding="utf-8")
    )
    assert all(sliders)
    assert sliders[-1] == " m/s²"


def test_derivatives_of_a_quantity_have_not_its_unit():
    """∂Φ/∂d has another than ∂Φ/∂θ, and neither has that of Φ."""
    derivation = fb.derive(fb.load("five_bar_rods"))
    unit_of = LineUnits(derivation, units_of_symbols(derivation))
    lines = [x.lhs for step in derivation.steps for x in step.equations]
    units = {str(x): unit_of(x) for x in lines}
    assert units["Φ₁"] == "m²"
    assert {unit for name, unit in units.items() if name.startswith("Φ_q")} == {""}
    assert units["T₁"] == "J"
