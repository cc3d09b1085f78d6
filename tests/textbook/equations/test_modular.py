"""Modular recursions: read from the first line to the last they give the torques exactly, and a
line holds the numbers of one joint."""

from __future__ import annotations

import re
from dataclasses import replace
from fractions import Fraction
from typing import Any

import pytest

import freebody as fb
from freebody.expressions import evaluate as walk
from freebody.expressions.expression import Expression, Function, Symbol, Vector, nodes
from freebody.scalars.trig import Trig
from freebody_textbook.derivation import Derivation
from support.printed_lines import derived
from support.symbolic import spatial_arm

pytestmark = pytest.mark.usefixtures("numpy_kernels")


def rational(derivation: Derivation) -> dict[str, tuple[Fraction, Fraction, Fraction]]:
    """By name a number for each symbol, and a sine and a cosine of it, all rational."""
    found = {}
    for k, name in enumerate(derivation.equations.symbols.ring.names, 2):
        t = Fraction(2 * k + 1, 3 * k - 7)
        found[name] = (
            Fraction(k * k % 17 + 1, 2 * k + 1),
            2 * t / (1 + t * t),
            (1 - t * t) / (1 + t * t),
        )
    return found


def exactly(x: Trig, known: dict[str, tuple[Fraction, Fraction, Fraction]]) -> Fraction:
    """The value of a polynomial."""
    angles = set(x.ring.angles)
    values = {name: known[name][0] for name in x.ring.names if name not in angles}
    for name in angles:
        values |= {name: known[name][0], f"sin_{name}": known[name][1]}
        values |= {f"cos_{name}": known[name][2]}
    total = Fraction(0)
    for powers, coefficient in x.terms():
        for name, exponent in powers.items():
            coefficient *= values[name] ** exponent
        total += coefficient
    return total


def line_by_line(derivation: Derivation) -> dict[str, Any]:
    """The lines from outward on, each computed of the numbers before."""
    known = rational(derivation)
    values: dict[str, Any] = {name: x for name, (x, _, _) in known.items()}

    def wave(node: Function, at: Any) -> Fraction:
        assert isinstance(node.argument, Symbol)
        if node.name == "sgn":
            return values[f"sgn_{node.argument.name}"]
        return known[node.argument.name][1 if node.name == "sin" else 2]

    rules = {
        **walk.arithmetic(Fraction),
        Symbol: lambda node, at: values[node.name],
        Function: wave,
    }

    def number(x: Expression) -> Fraction:
        return Fraction(walk.evaluate(x, rules))

    started = False
    for step in derivation.steps:
        started = started or step.operation == "Outward: body 1"
        for line in step.equations if started else ():
            name, last = line.lhs, line.sides[-1]
            if not isinstance(name, Symbol) or step.operation == "The closed form":
                continue
            if isinstance(last, Vector):
                for axis, x in zip("xyz", last.entries, strict=True):
                    values[f"{name.name}_{axis}"] = number(x)
            elif isinstance(last, Symbol) and last.bold:
                for axis in "xyz":
                    values[f"{name.name}_{axis}"] = values.get(f"{last.name}_{axis}", Fraction(0))
            elif not name.bold:
                values[name.name] = number(last)
    return values


ARMS = {
    **{f"arm{seed}": lambda seed=seed: spatial_arm(seed, 2 + seed % 3) for seed in range(4)},
    "puma560": lambda: fb.load("puma560", physical="ignore"),
    "iiwa14": lambda: fb.load("iiwa14"),
}


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("gravity", ["base", "explicit"])
def test_lines_give_the_torques_exactly(name, gravity):
    if (name, gravity) == ("iiwa14", "explicit"):
        pytest.skip("the same lines as those of Newton and Euler, below")
    derivation = fb.derive(ARMS[name](), "recursive", values="modular", gravity=gravity)
    values, known = line_by_line(derivation), rational(derivation)
    assert "terms)" not in derivation.text()
    for i, tau in enumerate(derivation.equations.tau, 1):
        assert values[f"tau{i}"] == exactly(tau, known)


def test_a_load_on_the_tip_is_carried_inward():
    derivation = fb.derive(spatial_arm(2, 4), "recursive", values="modular", load=True)
    values, known = line_by_line(derivation), rational(derivation)
    for i, tau in enumerate(derivation.tau, 1):
        assert values[f"tau{i}"] == exactly(tau, known)


def test_a_loop_to_the_ground_is_turned_to_the_last_body():
    derivation = derived("bricard")
    assert "terms)" not in derivation.text()
    last = [step.operation for step in derivation.steps].index("Inward: body 1")
    values = line_by_line(replace(derivation, steps=derivation.steps[: last + 1]))
    known = rational(derivation)
    for i, tau in enumerate(derivation.tau, 1):
        assert values[f"tau{i}"] == exactly(tau, known)


@pytest.mark.parametrize("method", ["newton-euler", "recursive"])
def test_long_arms_are_modular_without_being_asked(method):
    derivation = derived("ur5e", method)
    text = derivation.text()
    assert "terms)" not in text
    assert "ω₃ = R₂³ ω₂ + θ̇₃ z₃ = [ω₂x cos θ₃ + ω₂y sin θ₃, ω₂y cos θ₃ − ω₂x sin θ₃" in text
    last = derivation.steps[-1]
    assert last.operation == "All together"
    assert re.search(r"c 4010 .* (\d+) products and 3\d\d sums", last.reason)
    for step in derivation.steps:  # one joint's coordinate, and that of the next one inward
        own = re.fullmatch(r"(Outward|Inward): body (\d)", step.operation)
        for line in step.equations if own else ():
            angles = {
                x.argument.name
                for x in nodes(line)
                if isinstance(x, Function) and isinstance(x.argument, Symbol)
            }
            n = int(own[2]) + (own[1] == "Inward") if own else 0
            assert angles <= {f"theta{n}"}
    values, known = line_by_line(derivation), rational(derivation)
    assert values["tau6"] == exactly(derivation.equations.tau[5], known)
    assert values["tau1"] == exactly(derivation.equations.tau[0], known)
    meant = {x.name for row in derivation.glossary for x in row.symbols if isinstance(x, Symbol)}
    assert ("g_i" in meant) == (method == "newton-euler")


def test_in_the_plane_the_rules_suffice():
    lines = fb.derive(fb.planar("RR"), "recursive", values="modular").text()
    assert "v̇c₂ = v̇₂ + ω̇₂ z × sc₂ + ω₂ z × (ω₂ z × sc₂)\n" in lines
    assert "τ₁ = nc₁ + τ₂ + sc₁ × fc₁ + s₁ × f₁₂\n" in lines


@pytest.mark.sample(1)
@pytest.mark.parametrize("method", ["newton-euler", "recursive"])
def test_long_arms_in_the_plane_are_told_by_rules(method):
    said = fb.derive(fb.planar("RRPRR"), method).text()
    assert "terms)" not in said
    assert "   v̇₄ = v̇₃ + ω̇₃ z × s₃ + ω₃ z × (ω₃ z × s₃)\n" in said
    assert "given by those of the previous body" in " ".join(said.split())
