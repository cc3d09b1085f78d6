"""Lagrange's equations tell which derivative each term came from: by sums that are equal, and in
colours that are not the only difference."""

from __future__ import annotations

import re
import xml.etree.ElementTree as ET
from functools import reduce
from operator import add

import pytest

import freebody as fb
from freebody.expressions.nodes import Negative, Sourced, Sum, nodes
from freebody.expressions.polynomials.symbols import RATE
from freebody_textbook.methods.terms import KINETIC, POTENTIAL, SEVERAL, TIME
from freebody_textbook.relations.formula_values import value
from freebody_textbook.render.styles import TERMS

SPRUNG = fb.planar("RP").with_drive("joint2", rotor=0.5, stiffness=3.0, viscous=0.25)
MODELS = [*map(fb.planar, ("RR", "RP", "RRR")), SPRUNG, fb.load("furuta"), fb.load("polar_arm")]


def marks(step, line):
    """The terms of a line's last side by their source, each with its sign; "" of those unmarked."""
    found: dict[str, list] = {}
    right = step.equations[line].rhs
    for term in right.terms if isinstance(right, Sum) else (right,):
        inner = term.operand if isinstance(term, Negative) else term
        source = inner.source if isinstance(inner, Sourced) else ""
        found.setdefault(source, []).append(term)
    return found


@pytest.mark.parametrize("model", MODELS, ids=lambda model: model.name)
def test_terms_of_a_source_add_up_to_its_derivative(model):
    """Against derivatives of the energies as `fb.quantities` has them."""
    derivation, known = fb.derive(model, "lagrange"), fb.quantities(model)
    symbols = derivation.equations.symbols
    steps = {step.operation: step for step in derivation.steps}
    zero, ring = symbols.zero(), symbols.ring
    numbers = {name: ring[name] for name in ring.names}

    def total(terms, *sources):
        values = [value(term, numbers) for source in sources for term in terms.get(source, ())]
        return reduce(add, values, zero)

    for k, x in enumerate(symbols.coordinates):
        name = fb.equations(model).layout.form(ring[x])
        step = steps[f"Derivatives for {name}"]
        by_time = known["T"].derivative(x + RATE).along(symbols.rates)
        by_position, potential = known["T"].derivative(x), known["V"].derivative(x)
        assert total(marks(step, 1), TIME) == by_time
        assert total(marks(step, 2), KINETIC) == by_position
        assert total(marks(step, 2), POTENTIAL) == -potential
        assert not marks(step, 2).get(SEVERAL)
        found = marks(steps[f"The equation of {name}"], 1)
        if SEVERAL not in found:
            assert total(found, KINETIC) + total(found, TIME) == by_time - by_position
            assert all(not value(term, numbers).is_zero for term in found.get(KINETIC, ()))
        assert total(found, POTENTIAL) == potential
        assert total(found, *found) == derivation.tau[k]


def test_what_comes_from_where_in_the_closed_form_of_two_links():
    steps = fb.derive(fb.planar("RR"), "lagrange").steps
    closed = next(step for step in steps if step.operation == "The closed form")
    told = [
        {source: list(map(str, terms)) for source, terms in marks(closed, line).items()}
        for line in (0, 1)
    ]
    assert told == [
        {TIME: ["H₁₁ θ̈₁", "H₁₂ θ̈₂", "−h θ̇₂²", "−2 h θ̇₁ θ̇₂"], POTENTIAL: ["G₁"]},
        {TIME: ["H₂₁ θ̈₁", "H₂₂ θ̈₂"], KINETIC: ["h θ̇₁²"], POTENTIAL: ["G₂"]},
    ]


def test_marks_are_in_pages_alone_with_a_legend_and_more_than_a_colour():
    derivation = fb.derive(fb.planar("RRR"), "lagrange")
    marked = [step for step in derivation.steps if any(map(sources, step.equations))]
    assert len(marked) == 7  # the derivatives and the equation of each coordinate; the closed form
    assert {x for step in marked for line in step.equations for x in sources(line)} == {
        TIME, KINETIC, POTENTIAL, SEVERAL,
    }  # fmt: skip
    page = derivation.html()
    assert page.count('<p class="sources">') == len(marked)
    for formula in re.findall(r"<math.*?</math>", page, re.DOTALL):
        ET.fromstring(formula)  # a term that is broken is closed in each line
    assert not re.search("[\ue000-\uf8ff]|term-", derivation.text() + derivation.latex())
    plain = fb.derive(fb.planar("RR"), "newton-euler")
    assert 'class="sources"' not in plain.html()
    lines = re.findall(r"\.term-\w+\{[^}]*border-bottom:[\d.]+em (\w+)\}", TERMS)
    assert len(set(lines)) == 4


def sources(line):
    return {x.source for x in nodes(line) if isinstance(x, Sourced)}
