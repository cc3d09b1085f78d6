"""Section 5.2 and 5.3: Lagrange's equations of the second kind (5.6-5.20)."""

from __future__ import annotations

from fractions import Fraction

import freebody as fb
from freebody_notes.chapters.pendulum import pendulum
from freebody_notes.chapters.two_link import MATRIX, PRINTED_M, RIGHT_M, unit_rods
from freebody_notes.checks import ARM, Answer, Related, Run
from freebody_notes.item import Item


def arm_energies():
    """The energies of both links; I_1O is the inertia of link 1 about the base's joint, h2 the
    height of C₂."""
    free = fb.quantities(fb.planar("RR"))
    at_o = free["I1"] + free["m1"] * free["lc1"] ** 2
    return free | {
        "I_1O": at_o,
        "v_C2": free["vc2"],
        "height": free["rc2"][1],
        "half": Fraction(1, 2),
    }


BAR, TWO = Related(pendulum), Related(arm_energies)
EACH = Related(f"fb.quantities({ARM})", links=(1, 2))
_V2 = "m2*g*(l1*sin(theta1) + lc2*sin(theta1+theta2))"
_FIRST, _SECOND = (f"d_dt(partial(L, theta{i}_d)) - partial(L, theta{i}) = tau{i}" for i in (1, 2))
_C2 = "[l1*cos(theta1) + {0}*cos(theta1+theta2), l1*sin(theta1) + {0}*sin(theta1+theta2)]"

ITEMS = (
    Item("eq-5.6", "5.2", "The Lagrangian", "definition", "Kinetic minus potential energy.", "L = T - V", TWO),
    Item(
        "eq-5.7", "5.2", "Lagrange's equations", "identity",
        "One for each independent coordinate; Q is the force along it, without what is in V already.",
        "d_dt(partial(L, theta_i_d)) - partial(L, theta_i) = tau_i", EACH,
    ),
    Item(
        "ex-5.1-pendulum", "5.3", "Example 1: an arm of one link", "worked-example",
        "Energies, Lagrangian, equation. The result has the sign that (3.3) and (3.4) miss.",
        "T = 1/2*I_o*theta_d^2; V = m*g*l/2*sin(theta); L = T - V; I_o*theta_dd + m*g*l/2*cos(theta) = tau", BAR,
        figure="5.2",
    ),
    Item(
        "uf-5.1-T", "5.3", "Its kinetic energy", "worked-example", "Rotation about a fixed axis.",
        "T = 1/2*I_o*omega^2 = 1/2*I_o*theta_d^2", BAR,
    ),
    Item("uf-5.1-V", "5.3", "Its potential energy", "worked-example", "The height of the middle.", "V = m*g*l/2*sin(theta)", BAR),
    Item(
        "uf-5.1-L", "5.3", "Its Lagrangian", "worked-example", "Their difference.",
        "L = 1/2*I_o*theta_d^2 - m*g*l/2*sin(theta)", BAR,
    ),
    Item(
        "uf-5.1-lagrange", "5.3", "Its equation", "worked-example", "(5.7) for θ.",
        "d_dt(partial(L, theta_d)) - partial(L, theta) = tau", BAR,
    ),
    Item(
        "uf-5.1-eom", "5.3", "The result", "worked-example", "The derivatives carried out.",
        "I_o*theta_dd + m*g*l/2*cos(theta) = tau", BAR,
    ),
    Item(
        "ex-5.2-2dof", "5.3", "Example 2: an arm of two links", "worked-example",
        "Energies and both equations; with the potential energy of link 2 as (5.14) has it.",
        f"V2 = m2*g*(l1*sin(theta1) + lc1*sin(theta1)); {_FIRST}; {_SECOND}", TWO, "inconsistent",
        f"V2 = {_V2}; {_FIRST}; {_SECOND}",
        "With (5.14) gravity would not act on joint 2 at all. With (5.20) the equations are those of chapter 3, once "
        "(3.22)–(3.24) are corrected.",
        figure="5.3",
    ),
    Item("eq-5.8", "5.3", "Rate of link 1", "definition", "As (3.16).", "omega1 = theta1_d", TWO),
    Item("eq-5.9", "5.3", "Rate of link 2", "definition", "As (3.17).", "omega2 = omega1 + theta2_d = theta1_d + theta2_d", TWO),
    Item(
        "eq-5.10", "5.3", "Velocity of C₂", "derivation", "The position of C₂ differentiated.",
        f"v_C2 = d_dt({_C2.format('1/2*l2')})", TWO, "inconsistent", f"v_C2 = d_dt({_C2.format('lc2')})",
        "C₂ is put at half of the link, while (5.11)–(5.20) and (3.19) have it at l_c2; and a bracket is not closed.",
        figure="5.3",
    ),
    Item(
        "eq-5.11", "5.3", "T₁", "derivation", "Link 1 turns about a fixed axis.",
        "T1 = 1/2*I_1O*theta1_d^2 = 1/2*theta1_d^2*(m1*lc1^2 + I1)", TWO,
    ),
    Item("eq-5.12", "5.3", "V₁", "derivation", "Height of C₁.", "V1 = m1*g*lc1*sin(theta1)", Answer(ARM)),
    Item("eq-5.13", "5.3", "T₂", "derivation", "Link 2 moves and turns.", "T2 = 1/2*I2*omega2^2 + 1/2*m2*v_C2^2", TWO),
    Item(
        "eq-5.14", "5.3", "V₂", "derivation", "Height of C₂.",
        "V2 = m2*g*(l1*sin(theta1) + lc1*sin(theta1))", Answer(ARM), "misprint", f"V2 = {_V2}",
        "The height of C₂ above the elbow is l_c2 sin(θ₁+θ₂), as (5.20) has it.",
    ),
    Item("uf-5.2-L", "5.3", "The Lagrangian", "definition", "Both links together.", "L = T1 - V1 + T2 - V2", TWO),
    Item("eq-5.15", "5.3", "First equation", "derivation", "(5.7) for θ₁.", _FIRST, TWO),
    Item("eq-5.16", "5.3", "Second equation", "derivation", "(5.7) for θ₂.", _SECOND, TWO),
    Item(
        "uf-5.2-claim", "5.3", "The same as in chapter 3", "identity",
        "The equations that come out are said to be those of chapter 3: its mass matrix against that of the energies.",
        PRINTED_M, Run(unit_rods, calls=MATRIX), "inconsistent", RIGHT_M,
        "Not those printed there: (3.22), (3.23) and (3.24) have slips that the energies do not share. With these "
        "corrected it is true.",
    ),
    Item("eq-5.17", "5.3", "T₁ again", "derivation", "As (5.11).", "T1 = 1/2*theta1_d^2*(m1*lc1^2 + I1)", Answer(ARM)),
    Item("eq-5.18", "5.3", "V₁ again", "derivation", "As (5.12).", "V1 = m1*g*lc1*sin(theta1)", Answer(ARM)),
    Item(
        "eq-5.19", "5.3", "T₂ written out", "derivation",
        "(5.13) with ω₂ and v_C2 put in, eleven terms; sin(θ₁+θ₂) sin θ₁ + cos(θ₁+θ₂) cos θ₁ is cos θ₂.",
        "T2 = 1/2*lc2^2*m2*theta1_d^2 + lc2^2*m2*theta1_d*theta2_d + 1/2*lc2^2*m2*theta2_d^2 + 1/2*m2*theta1_d^2*l1^2 "
        "+ sin(theta1+theta2)*sin(theta1)*l1*lc2*m2*theta1_d*theta2_d "
        "+ sin(theta1+theta2)*sin(theta1)*l1*lc2*m2*theta1_d^2 "
        "+ cos(theta1+theta2)*cos(theta1)*l1*lc2*m2*theta1_d^2 "
        "+ cos(theta1+theta2)*cos(theta1)*l1*lc2*m2*theta1_d*theta2_d "
        "+ 1/2*I2*theta1_d^2 + I2*theta1_d*theta2_d + 1/2*I2*theta2_d^2", Answer(ARM),
    ),
    Item("eq-5.20", "5.3", "V₂ again", "derivation", "Height of C₂.", f"V2 = {_V2}", Answer(ARM)),
)  # fmt: skip
