"""Section 2.4: statics of the arm of two links (2.41-2.52)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import Digits, Related


def resting_arm():
    """The arm at rest, with links without weight and a force f = (u, v) on the tip; f1 is the
    base's force on link 1, f2 link 1's on link 2."""
    arm = fb.planar("RR", g=[0, 0])
    free = fb.quantities(arm, load=True, at_rest=True)
    u, v = free["f"]
    return free | {"f1": free["f01"], "f2": free["f12"], "u": u, "v": v}


def loaded_arm():
    """The statics example: l = 3.5 m and 3 m, both angles 30°, a force on the tip."""
    arm = fb.planar("RR", l=[3.5, 3], lc=[0, 0], m=[0, 0], I=[0, 0])
    q, f = np.array([np.pi / 6, np.pi / 6]), np.array([-4.5, -3.0])
    tau = fb.static_torque(arm, q, wrenches={"tip": [*f, 0]})
    return {"f": f, "tau": tau, "J": fb.jacobian(arm, q)[:2], "f_e": fb.tip_wrench(arm, q, tau)[:2]}


def planar_product():
    a, b = (0.3, -1.2), (2.1, 0.7)
    return {"a": a, "b": b, "A": (*a, 0.0), "B": (*b, 0.0), "z": (0.0, 0.0, 1.0)}


CHECKS = {
    "resting_arm": Related(resting_arm),
    "planar_product": Related(planar_product),
    "loaded_arm": Related(loaded_arm),
    "loaded_arm_digits": Digits(loaded_arm),
}
