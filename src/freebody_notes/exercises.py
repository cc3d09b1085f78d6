"""Exercises that the notes leave to the reader: a hint, and the solution worked out when it is
asked for."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
from markupsafe import Markup, escape

import freebody as fb
from freebody.expressions.expression import eq
from freebody_notes.chapters.first_kind import pinned_bar
from freebody_notes.chapters.five_bar import limbs, robot
from freebody_notes.chapters.recursion import as_vectors
from freebody_notes.checks import number
from freebody_notes.data import data
from freebody_notes.steps import ROWS
from freebody_textbook.derivation import Derivation
from freebody_textbook.derive import compare
from freebody_textbook.relations.formula import parse, symbol
from freebody_textbook.relations.quantities import Quantities
from freebody_textbook.render import page


@dataclass(frozen=True)
class Exercise:
    """A question of the notes, with a hint."""

    id: str
    chapter: int
    title: str
    question: str
    hint: str


def _paragraph(text: str) -> str:
    return f"<p>{escape(text)}</p>"


def _values(values: Quantities, *names: str) -> str:
    """HTML of equations name = value for vectors and scalars of a model."""
    lines = [
        eq(symbol(name, isinstance(values[name], tuple)), values.form(values[name]))
        for name in names
    ]
    return page.html([lines])


def _steps(derivation: Derivation, *remarks: str) -> str:
    return "".join(map(_paragraph, remarks)) + derivation._repr_html_()


# ---------------------------------------------------------------- solutions
def tip_acceleration() -> str:
    free = fb.quantities(fb.planar("RR"))
    steps = (
        "Each link contributes a centripetal term, its length times the square of its angular "
        "velocity, and a tangential term, its length times its angular acceleration."
    )
    return _values(free, "r", "r_d", "r_dd") + _paragraph(steps)


def point_acceleration() -> str:
    free = as_vectors()
    left = eq(parse("d_dt(d_dt(r_A))", ["r_A"]), free.form(free["v_A_d"]))
    right = parse(
        "v_B_d + cross(omega_d, s) + cross(omega, cross(omega, s))",
        ["v_B_d", "omega", "omega_d", "s"],
    )
    holds = bool(
        fb.relation(
            free, "d_dt(d_dt(r_A)) = v_B_d + cross(omega_d, s) + cross(omega, cross(omega, s))"
        )
    )
    proof = "Both are identical as polynomials, term by term." if holds else "They differ."
    said = (
        "Write the position of A with lengths and angles, and differentiate twice; "
        "then collect the terms into vectors:"
    )
    return (
        _paragraph(said)
        + page.html([[left], [eq(right, free.form(free["v_A_d"]))]])
        + _paragraph(proof)
    )


def five_bar() -> str:
    """Solution of the five-bar exercise: inverse and forward kinematics, and where each is
    singular."""
    model, q = robot()
    lengths = model.parameters
    limbs_ = {side: fb.planar("RR", l=[lengths[x] for x in l], lc=[0, 0], m=[0, 0], I=[0, 0])
              for side, l in ((-1, ("l1", "l3")), (1, ("l2", "l4")))}  # fmt: skip
    cranks = [
        fb.inverse_kinematics(arm, q[2:] - [side * lengths["b"], 0]).q[:, 0]
        for side, arm in limbs_.items()
    ]
    pairs = [f"θ₁ = {a:.4f}, θ₂ = {b:.4f}".replace("-", "−") for a in cranks[0] for b in cranks[1]]
    modes = fb.assembly_modes(model, q, free=["x", "y"])[:, 2:]
    io = fb.input_output(model, q)
    symbols = limbs()
    J_a = symbols["J_a"]
    across = (J_a[0][0] * J_a[1][1] - J_a[0][1] * J_a[1][0]) / 4
    singular = [
        *(eq(symbol(name), symbols.form(symbols[name])) for name in ("j_b1", "j_b2")),
        eq(parse("det(J_a)/4"), symbols.form(across)),
    ]
    inverse = (
        "Inverse kinematics: each limb is a two-link arm with its base at A or C, so "
        "fb.inverse_kinematics gives two angles for each crank. "
        f"These are four combinations; for P = {number(q[2:], 4)}:"
    )
    forward = (
        "Forward kinematics: the crank angles determine B and D, and P lies where the circles "
        f"about them intersect. fb.assembly_modes finds {len(modes)} positions for θ = "
        f"{number(q[:2])}: {' and '.join(number(x, 4) for x in modes)}."
    )
    poses = (
        "Singular poses of the first type, where an entry of J_b is zero: AB and BP (or CD and DP) "
        "are collinear, and P is on the boundary of its workspace. Singular poses of the second "
        "type, where det J_a is zero: BP and DP are collinear, and the cranks cannot hold P. At "
        f"this pose fb.input_output says: {io.kind}; the smallest singular values are "
        f"{io.first:.3f} for J_b (first type) and {io.second:.3f} for J_a (second type)."
    )
    listed = "<ul>" + "".join(f"<li>{escape(pair)}</li>" for pair in pairs) + "</ul>"
    return "".join(
        [_paragraph(inverse), listed, _paragraph(forward), _paragraph(poses), page.html([singular])]
    )


def joint_forces() -> str:
    return _steps(
        fb.derive(fb.planar("RR", g=[0, 0]), "statics"), "Link 2 first: f₂ = −f; then f₁ = f₂."
    )


def newton_euler() -> str:
    return _steps(fb.derive(fb.planar("RR"), "newton-euler"))


def two_links_by_recursion() -> str:
    return _steps(fb.derive(fb.planar("RR"), "recursive"))


def lagrange() -> str:
    arm = fb.planar("RR")
    first, second = fb.derive(arm, "lagrange"), fb.derive(arm, "newton-euler")
    head, *torques = str(compare(first, second)).splitlines()
    listed = "".join(f"<li>{escape(line)}</li>" for line in torques)
    return _steps(first) + _paragraph(head) + f"<ul>{listed}</ul>"


def bar_on_a_pin() -> str:
    """Solution of the pinned-bar exercise: Lagrange's equations of the first kind."""
    found = pinned_bar()
    lines = [
        eq(parse("Phi", ["Phi"]), parse("[x - r*cos(theta), y - r*sin(theta)]")),
        eq(parse("Phi_q", ["Phi_q"]), parse("[[1, 0, r*sin(theta)], [0, 1, -r*cos(theta)]]")),
        eq(parse("M"), parse("[[m, 0, 0], [0, m, 0], [0, 0, I_c]]")),
        eq(parse("c", ["c"]), parse("[-r*cos(theta)*theta_d^2, -r*sin(theta)*theta_d^2]")),
        eq(parse("n", ["n"]), parse("[0, -m*g, tau]")),
    ]
    agree = np.allclose(found["f_pin"], found["f_hinged"]) and np.isclose(
        found["alpha"], found["alpha_hinged"]
    )
    same = (
        " A model of the bar with a revolute joint, which needs no multipliers, has the same "
        "acceleration and the same force."
    )
    text = (
        "For m = 3 kg, I_c = 0.25 kg m², r = 0.5 m, τ = 4 N m at θ = 0.7, θ̇ = 1.9 rad/s the "
        f"system (5.29) gives θ̈ = {number(found['alpha'])} rad/s² and "
        f"λ = {number(found['lam'])} N; the pin force on the bar is −λ.{same if agree else ''}"
    )
    first = (
        "A free bar has the coordinates x, y of its centre and θ; "
        "the pin holds its end at the origin:"
    )
    how = (
        'fb.planar("PPR", …).with_loop("pin", "point", ("base", "tip")) is this bar; '
        "fb.forward_dynamics and fb.reactions solve it, and fb.simulate keeps its end on the pin. "
        "fb.derive(fb.load('five_bar_rods'), 'lagrange-first-kind') treats the robot of section "
        "2.3 in this way, step by step."
    )
    return _paragraph(first) + page.html([lines]) + _paragraph(text) + _paragraph(how)


def sliding_joint() -> str:
    rows = [row | {"m": f"m{i}"} for i, row in enumerate(ROWS[1:], 1)]
    chain = fb.dh(rows, convention="modified", name="RP")
    return _steps(
        fb.derive(chain, "recursive"), "A revolute joint, then a prismatic one, in modified frames."
    )


SOLUTIONS = {
    "ex-1.2-acceleration": tip_acceleration,
    "five-bar": five_bar,
    "joint-forces": joint_forces,
    "closed-form": newton_euler,
    "ex-4.5-verify": point_acceleration,
    "two-link-recursion": two_links_by_recursion,
    "lagrange-2r": lagrange,
    "first-kind": bar_on_a_pin,
    "prismatic": sliding_joint,
}
"""How each exercise of exercises.toml is solved."""


@cache
def exercises() -> tuple[Exercise, ...]:
    """All exercises, in the order of the notes."""
    return tuple(Exercise(name, **words) for name, words in data("exercises.toml").items())


def solution(exercise: Exercise) -> Markup:
    """The solution of an exercise as HTML."""
    return Markup(SOLUTIONS[exercise.id]())
