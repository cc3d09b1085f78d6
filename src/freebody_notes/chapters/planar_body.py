"""Section 1.3 and 1.4: free bodies, and the laws of Newton and Euler in the plane (1.21-1.27)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.model.inertia import combined
from freebody_notes.checks import ARM, Related
from freebody_textbook.relations.formula_values import Each

_MASSES, _POINTS = (2.0, 1.0, 3.0), np.array([[0.2, 0.1], [-0.4, 0.3], [0.5, -0.2]])


def thrown_body(omega=1.3, alpha=-2.1):
    """Three particles of a rigid body in arbitrary planar motion, with Newton's law for each of
    them."""
    body = fb.planar("PPR", m=[0, 0, 1], lc=[0, 0, 0], I=[0, 0, 0], l=[0, 0, 1], g=0)
    motion = ([0.1, -0.2, 0.6], [0.4, 0.7, omega], [1.1, -0.8, alpha])
    whole = combined([fb.Inertia.point(m, r) for m, r in zip(_MASSES, _POINTS, strict=True)])
    R = fb.forward_kinematics(body, motion[0], "link3")[:2, :2]
    a_i = [fb.acceleration(body, *motion, "link3", point=p)[:2] for p in _POINTS]
    return {
        "m": whole.mass, "I_G": whole.tensor[0], "alpha": alpha,
        "F_i": Each(tuple(m * a) for m, a in zip(_MASSES, a_i, strict=True)),
        "rho_i": Each(tuple(R @ (p - whole.com)) for p in _POINTS),
        "a_G": fb.acceleration(body, *motion, "link3", point=whole.numbers()[1])[:2], "a": a_i[0],
    }  # fmt: skip


def pushed_along():
    """A thrown body with zero angular velocity and acceleration."""
    return thrown_body(omega=0.0, alpha=0.0)


def pinned_body():
    """A body on a pin at O without weight, pushed by a force F at its end; f is the pin's force on
    it."""
    l, lc, m, I = 1.2, 0.5, 3.0, 0.4
    body = fb.planar("R", l=[l], lc=[lc], m=[m], I=[I], g=0)
    q, qd, F = [0.7], [1.9], np.array([4.0, -6.0])
    push = {"tip": [*F, 0.0]}
    alpha = fb.forward_dynamics(body, q, qd, [0.0], wrenches=push)
    f = fb.joint_wrenches(body, q, qd, alpha, wrenches=push)[0, :2]
    a_G = fb.acceleration(body, q, qd, alpha, "link1", point=[lc, 0])[:2]
    along = np.array([np.cos(q[0]), np.sin(q[0])])
    P, G = l * along, lc * along

    def cross(a, b):
        return a[0] * b[1] - a[1] * b[0]

    return {
        "m": m, "I_G": I, "I_O": I + m * lc**2, "alpha": alpha[0], "a_G": a_G, "F": F, "f": f,
        "M_O": Each((cross(P, F), 0.0)), "M_G": Each((cross(P - G, F), cross(-G, f))),
        "F_j": Each((F, f)),
    }  # fmt: skip


def cut_free():
    """The free bodies of the arm: each joint force occurs twice, with opposite signs."""
    free = fb.quantities(fb.planar("RR"), load=True)
    return free | {
        "F_1": [
            a - b + w for a, b, w in zip(free["f01"], free["f12"], _weight(free, 1), strict=True)
        ],
        "F_2": [
            a + w + f for a, w, f in zip(free["f12"], _weight(free, 2), free["f"], strict=True)
        ],
    }


def _weight(free, i):
    return [free[f"m{i}"] * x for x in free["gravity"]]


CHECKS = {
    "loaded_arm": Related(f"fb.quantities({ARM}, load=True)"),
    "cut_free": Related(cut_free),
    "thrown_body": Related(thrown_body),
    "pushed_along": Related(pushed_along),
    "pinned_body": Related(pinned_body),
}
