"""Section 5.2 and 5.3: Lagrange's equations of the second kind (5.6-5.20)."""

from __future__ import annotations

from fractions import Fraction

import freebody as fb
from freebody_notes.chapters.pendulum import pendulum
from freebody_notes.chapters.two_link import UNIT_RODS
from freebody_notes.checks import ARM, Related


def arm_energies():
    """The energies of both links of the arm; I_1O is the moment of inertia of link 1 about the
    base's joint, h2 the height of C₂."""
    free = fb.quantities(fb.planar("RR"))
    at_o = free["I1"] + free["m1"] * free["lc1"] ** 2
    return free | {
        "I_1O": at_o,
        "v_C2": free["vc2"],
        "height": free["rc2"][1],
        "half": Fraction(1, 2),
    }


CHECKS = {
    "each_link": Related(f"fb.quantities({ARM})", links=(1, 2)),
    "pendulum": Related(pendulum),
    "arm_energies": Related(arm_energies),
    "unit_rods": UNIT_RODS,
}
