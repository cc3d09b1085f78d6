"""Section 5.4: Lagrange's equations of the first kind (5.21-5.29)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import Related


def pinned_bar():
    """A bar as a free body with the coordinates x, y of its centre and θ; a loop holds its end at
    the origin.

    Its acceleration and the pin's force are compared with those of a bar on a revolute joint, which
    has no multipliers.
    """
    r, tau, theta, omega = 0.5, 4.0, 0.7, 1.9
    hinged = fb.planar("R", l=[2 * r], lc=[r], m=[3.0], I=[0.25])
    free = fb.planar(
        "PPR",
        l=[0, 0, -r],
        lc=[0, 0, 0],
        m=[0, 0, 3.0],
        I=[0, 0, 0.25],
        angles=[0, np.pi / 2, -np.pi / 2],
    )
    held = free.with_loop("pin", "point", ("base", "tip"))
    c, s = np.cos(theta), np.sin(theta)
    q, qd = np.array([r * c, r * s, theta]), omega * np.array([-r * s, r * c, 1.0])
    Q_ex = np.array([0.0, 0.0, tau])
    qdd = fb.forward_dynamics(held, q, qd, Q_ex)
    phi = fb.vector_function(["x - r*cos(theta)", "y - r*sin(theta)"], ["x", "y", "theta", "r"])
    along = phi([[*(q + h * qd), r] for h in 1e-3 * np.array([0, 1, -1, 2, -2])])
    alpha = fb.forward_dynamics(hinged, [theta], [omega], [tau])
    pin = fb.joint_wrenches(hinged, [theta], [omega], alpha)[0, :2]
    return {
        "Phi": along[0], "Phi_q": phi.jacobian_at([*q, r])[:, :3], "qd": qd, "x": q[0], "y": q[1],
        "theta": theta, "r": r,
        "Phi_d": (8 * (along[1] - along[2]) - (along[3] - along[4])) / 12e-3, "lam": -pin,
        "Q_ex": Q_ex, "E_L": fb.inverse_dynamics(free, q, qd, qdd), "alpha": qdd[2],
        "alpha_hinged": alpha[0], "f_pin": fb.reactions(held, q, qd, tau=Q_ex)["pin"][:2],
        "f_hinged": pin, "f": fb.mobility(held, q).generic, "n": free.nv, "m": len(phi.rows),
    }  # fmt: skip


def guided_arm():
    """The two-link arm with its tip on a horizontal line: one constraint Φ = y − y₀.

    The line's force is found by asking which force on the tip leaves it without vertical
    acceleration.
    """
    arm = fb.load("2R")
    free = fb.quantities(arm)
    q, tau = np.array([0.4, 0.9]), np.array([3.0, -1.0])
    J = fb.jacobian(arm, q)[:2]
    qd = 1.3 * np.array([J[1, 1], -J[1, 0]])  # the tip moves along the line
    pushed = [fb.forward_dynamics(arm, q, qd, tau, wrenches={"tip": [0, F, 0]}) for F in (0.0, 1.0)]
    rise = [fb.acceleration(arm, q, qd, qdd)[1] for qdd in pushed]
    force = -rise[0] / (rise[1] - rise[0])
    rates = {name: free[f"{name}_d"] for name in ("theta1", "theta2")}
    at = dict(arm.parameters) | {
        "theta1": q[0],
        "theta2": q[1],
        "theta1_d": qd[0],
        "theta2_d": qd[1],
    }
    M_d = [[float(x.along(rates).evaluate(at)) for x in row] for row in free["M"]]
    slopes = {
        e: np.array([float(free[e].derivative(name).evaluate(at)) for name in rates])
        for e in ("T", "V")
    }
    Phi_q, Phi_q_d = J[1:], fb.jacobian_dot(arm, q, qd)[1:2]
    L_q = slopes["T"] - slopes["V"]
    return {
        "M": fb.mass_matrix(arm, q), "qdd": pushed[0] + force * (pushed[1] - pushed[0]), "qd": qd,
        "Phi_q": Phi_q, "Phi_q_d": Phi_q_d, "lam": np.array([-force]), "Q_ex": tau, "L_q": L_q,
        "T_q": slopes["T"], "V_q": slopes["V"], "M_d": np.array(M_d), "c": -Phi_q_d @ qd,
        "n": tau + L_q - np.array(M_d) @ qd,
    }  # fmt: skip


CHECKS = {
    "pinned_bar": Related(pinned_bar),
    "guided_arm": Related(guided_arm),
}
