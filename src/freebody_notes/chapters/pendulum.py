"""Section 3.1 and 3.2: the laws again, and the arm of one link (3.1-3.9)."""

from __future__ import annotations

import freebody as fb
from freebody_notes.chapters.planar_body import thrown_body
from freebody_notes.checks import Related


def pendulum():
    """A bar of length l = 2 r on a hinge at A, with its centre of mass C in the middle."""
    bar = fb.planar("R", lc=["r"], m=["m"], I=["I_c"], l=["l"])
    free = fb.quantities(bar)
    meaning = {
        "theta": "theta1", "theta_d": "theta1_d", "theta_dd": "theta1_dd", "omega": "omega1",
        "omega_d": "omega1_d", "tau": "tau1", "v_c": "vc1", "v_c_d": "vc1_d", "r_c": "sc1",
    }  # fmt: skip
    m, I_c, r = free["m"], free["I_c"], fb.quantities(bar)["theta1"].ring["r"]
    named = {new: free[old] for new, old in meaning.items()}
    return (
        free | named | {"r": r, "l": r * 2, "I_A": I_c + m * r * r, "I_o": I_c + m * r * r, "m": m}
    )


def bodies():
    """Numbers of coordinates of a free body, of one on a pin and of one on slides; and the force
    that a pin transmits."""
    pinned = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1])
    return {
        "n_free": fb.planar("PPR").nv, "n_pin": pinned.nv, "n_slides": fb.planar("PP").nv,
        "n_all": fb.joint_wrenches(pinned, [0.3], [1.0], [2.0]).size,
    }  # fmt: skip


CHECKS = {
    "thrown_body": Related(thrown_body),
    "bodies": Related(bodies),
    "pendulum": Related(pendulum),
}
