"""Section 6.2 and 6.3: Lagrange and the recursion in space, with Denavit-Hartenberg frames
(6.15-6.29)."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

import freebody as fb
from freebody_notes.checks import Reading, Related, Run, number
from freebody_notes.item import Item, Outcome

ROWS = (
    {"joint": "R", "a": 0.0, "alpha": 0.0, "d": 0.3, "m": 2.0, "com": [0.1, -0.2, 0.05], "I": [0.3, 0.02, 0.01, 0.4, -0.03, 0.5]},
    {"joint": "P", "a": 0.4, "alpha": 0.7, "theta": 0.2, "m": 1.5, "com": [-0.05, 0.1, 0.2], "I": [0.2, 0.01, 0.0, 0.1, 0.02, 0.2]},
    {"joint": "R", "a": -0.2, "alpha": -1.1, "d": 0.1, "m": 1.0, "com": [0.15, 0.05, 0.1], "I": [0.05, 0.0, 0.01, 0.06, 0.0, 0.04]},
    {"joint": "P", "a": 0.1, "alpha": 0.4, "theta": -0.5, "m": 0.5, "com": [0.0, 0.02, -0.1], "I": [0.02, 0.0, 0.0, 0.03, 0.0, 0.01]},
)  # fmt: skip
"""A chain with both kinds of joints, skew axes, full inertia tensors."""

GRAVITY = [0.3, -1.2, -9.7]


@cache
def arm(gravity: str = "explicit"):
    """The chain R P R P in modified Denavit-Hartenberg frames, gravity in no special direction."""
    chain = fb.dh(ROWS, convention="modified", gravity=GRAVITY)
    free = fb.quantities(chain, gravity=gravity)
    # without a prime s has global components
    return free | {f"s{n - 1}": _in_world(free, n - 1, f"p{n - 1}_{n}") for n in range(1, 5)}


def _in_world(free, n, name):
    return tuple(
        sum((r * x for r, x in zip(row, free[name], strict=True)), 0.0) for row in free[f"R{n}"]
    )


def explicit():
    return arm()


def accelerated():
    """Gravity as acceleration −g of the base; and the torques of Lagrange's equations."""
    free = arm("base")
    chain = fb.dh(ROWS, convention="modified", gravity=GRAVITY)
    return free | {"tau_L": fb.derive(chain, "lagrange").tau}


def upright():
    """The same with gravity along −z; h is the height of a centre of mass."""
    free = fb.quantities(fb.dh(ROWS, convention="modified"))
    return free | {f"h{n}": free[f"rc{n}"][2] for n in range(1, 5)}


def frames(form: str) -> Outcome:
    """Words leave it open which of the two conventions is meant; a form is held against the
    modified one."""
    row = {"a": 0.4, "alpha": 0.7, "d": 0.1, "theta": 0.0}
    theta = 0.6
    poses = {
        c: fb.forward_kinematics(fb.dh([row], convention=c), [theta])
        for c in ("standard", "modified")
    }
    if "=" not in form:
        lines = [
            f"{c}: p = {number(T[:3, 3])}, joint axis {_axis(c, T)}." for c, T in poses.items()
        ]
        return Outcome(
            False, ("Two conventions go by this name, and give different frames.", *lines)
        )
    T = poses["modified"]
    values = {
        "theta": theta, "alpha": 0.7, "a": 0.4, "d": 0.1, "Rh_i": T[:3, :3], "ph_i": T[:3, 3],
    }  # fmt: skip
    return Related(lambda: values).run(form)


def _axis(convention, T):
    return number([0.0, 0.0, 1.0] if convention == "standard" else T[:3, 2])


def direction(form: str) -> Outcome:
    """Words leave two readings of the matrix; each is put into (6.18)."""
    if "=" in form:
        return REVOLUTE.run(form)
    readings = {
        "components of link i−1 to i": "Ri_h",
        "components of link i to i−1": "transpose(Ri_h)",
    }
    verdicts = {
        words: REVOLUTE.run(f"omega_i = {matrix}*omega_h + theta_i_d*z").holds
        for words, matrix in readings.items()
    }
    lines = tuple(
        f"Read as taking {words}, (6.18) {'holds' if v else 'fails'}."
        for words, v in verdicts.items()
    )
    return Outcome(all(verdicts.values()), lines)


def tip_load():
    """A wrench that the last link exerts on its surroundings, against none."""
    chain = fb.dh(ROWS, convention="modified", gravity=GRAVITY)
    q, qd, qdd = (x[0] for x in fb.random_state(chain, 2, 1))
    f, n = np.array([3.0, -2.0, 5.0]), np.array([0.4, 0.7, -1.1])
    J = fb.jacobian(chain, q)
    loaded = fb.inverse_dynamics(chain, q, qd, qdd, wrenches={"frame4": [*-f, *-n]})
    return {
        "tau_tip": loaded, "tau_free": fb.inverse_dynamics(chain, q, qd, qdd),
        "J_v": J[:3], "J_w": J[3:], "f": f, "n": n,
    }  # fmt: skip


STANDARD = (
    {"joint": "R", "a": 0.3, "alpha": 0.7, "d": 0.2, "m": 2.0, "com": [0.1, -0.2, 0.05], "I": [0.3, 0.02, 0.01, 0.4, -0.03, 0.5]},
    {"joint": "P", "a": 0.1, "alpha": -0.4, "theta": 0.3, "m": 1.5, "com": [-0.05, 0.1, 0.2], "I": [0.2, 0.01, 0, 0.1, 0.02, 0.2]},
    {"joint": "R", "a": -0.2, "alpha": 1.1, "d": 0.1, "m": 1.0, "com": [0.15, 0.05, 0.1], "I": [0.05, 0, 0.01, 0.06, 0, 0.04]},
)  # fmt: skip


def standard_frames():
    """A turning, a sliding and a turning joint in standard frames: motion of each frame from
    fb.velocity and fb.acceleration in its own axes, torques from fb.inverse_dynamics and from the
    recursion written out."""
    chain = fb.dh(STANDARD, convention="standard", gravity=GRAVITY)
    q, qd, qdd = (x[0] for x in fb.random_state(chain, 7, 1))
    found, before = {"z": np.array([0.0, 0.0, 1.0])}, np.eye(4)
    for n in (1, 2, 3):
        T = fb.forward_kinematics(chain, q, f"frame{n}")
        R, v = T[:3, :3], fb.velocity(chain, q, qd, f"frame{n}")
        a = fb.acceleration(chain, q, qd, qdd, f"frame{n}")
        found |= {
            f"E{n}": R.T @ before[:3, :3],
            f"p{n}": R.T @ (T[:3, 3] - before[:3, 3]),
            f"v{n}": R.T @ v[:3],
        }
        found |= {f"omega{n}": R.T @ v[3:], f"v{n}_d": R.T @ a[:3], f"omega{n}_d": R.T @ a[3:]}
        before = T
    rates = {"d2_d": qd[1], "d2_dd": qdd[1], "theta3_d": qd[2], "theta3_dd": qdd[2]}
    swept = _swept_standard(q, qd, qdd)
    return found | rates | {"tau": fb.inverse_dynamics(chain, q, qd, qdd), "tau_swept": swept}


def _swept_standard(q, qd, qdd):
    """Torques by the recursion in standard frames, gravity as acceleration of the base."""
    swept = _outward_standard(q, qd, qdd)
    f = n = np.zeros(3)
    tau, E_next = np.zeros(3), np.eye(3)
    for k in (2, 1, 0):
        row, link = STANDARD[k], swept[k]
        c, I = np.array(row["com"]), fb.Inertia.of(row["m"], row["com"], row["I"]).numbers()[2]
        fc = row["m"] * (
            link["vd"] + np.cross(link["wd"], c) + np.cross(link["w"], np.cross(link["w"], c))
        )
        carried, p = E_next.T @ f, link["p"]
        n = (
            I @ link["wd"]
            + np.cross(link["w"], I @ link["w"])
            + E_next.T @ n
            + np.cross(p + c, fc)
            + np.cross(p, carried)
        )
        f, E_next = fc + carried, link["E"]
        tau[k] = (n if row["joint"] == "R" else f) @ link["E"][:, 2]
    return tau


def _outward_standard(q, qd, qdd):
    w = wd = np.zeros(3)
    vd, links = -np.array(GRAVITY), []
    for k, row in enumerate(STANDARD):
        turns = row["joint"] == "R"
        theta, d = (q[k], row["d"]) if turns else (row["theta"], q[k])
        E = (fb.rotation("Z", [theta]) @ fb.rotation("X", [row["alpha"]])).T
        p = np.array([row["a"], d * np.sin(row["alpha"]), d * np.cos(row["alpha"])])
        z = np.array([0.0, 0.0, 1.0])
        rate, second = (qd[k] * z, qdd[k] * z) if turns else (0 * z, 0 * z)
        slide, push = (0 * z, 0 * z) if turns else (qd[k] * z, qdd[k] * z)
        wd = E @ (wd + second + np.cross(w, rate))
        w = E @ (w + rate)
        vd = (
            E @ (vd + push)
            + np.cross(wd, p)
            + 2 * np.cross(w, E @ slide)
            + np.cross(w, np.cross(w, p))
        )
        links.append({"w": w, "wd": wd, "vd": vd, "E": E, "p": p})
    return links


SWEPT = 'fb.quantities(chain, gravity="base"); fb.derive(chain, "lagrange").tau'
CHAIN = 'fb.quantities(fb.dh(rows, convention="modified", gravity=[0.3, -1.2, -9.7]))  # R P R P'
UNPRIMED = f"{CHAIN}\nvalues['s2'] = R2 @ p2_3  # without a prime s has global components"
REVOLUTE, PRISMATIC = (Related(explicit, links, calls=CHAIN) for links in ((1, 3), (2, 4)))
READ_LITERALLY = Related(explicit, (1, 3), calls=UNPRIMED)
BOTH = Related(explicit, (1, 2, 3, 4), calls=CHAIN)


def _proved(test: Related, also: str) -> Related:
    return replace(test, also=also)


_C = "v_i_d + cross(omega_i_d, sc_i) + cross(omega_i, cross(omega_i, sc_i))"

ITEMS = (
    Item(
        "eq-6.15", "6.2", "Lagrange in space", "identity", "The equations are the same as in the plane.",
        "d_dt(partial(L, theta_i_d)) - partial(L, theta_i) = tau_i", REVOLUTE,
    ),
    Item(
        "uf-6.15-T", "6.2", "Kinetic energy of a link", "definition", "Moving with the centre of mass and turning about it.",
        "T_i = 1/2*m_i*dot(vc_i, vc_i) + 1/2*dot(omega_i, I_i*omega_i)", _proved(BOTH, "T1 + T2 + T3 + T4 = 1/2*dot(qd, M*qd)"),
    ),
    Item(
        "uf-6.15-V", "6.2", "Potential energy of a link", "definition", "By its height, or by the field for any direction of it.",
        "V_i = m_i*g*h_i = -m_i*dot(gravity, rc_i)", Related(upright, links=(1, 2, 3, 4)),
    ),
    Item(
        "uf-6.16-dh", "6.3.1.1", "Denavit and Hartenberg's frames", "definition",
        "The frames are said to follow the convention of Denavit and Hartenberg; no matrix is given.",
        "by the convention of Denavit and Hartenberg", Run(frames, ("Rh_i", "ph_i"), calls='fb.forward_kinematics(fb.dh([row], convention="modified"), [theta])  # and "standard"'), "incomplete",
        "Rh_i = [[cos(theta), -sin(theta), 0], [sin(theta)*cos(alpha), cos(theta)*cos(alpha), -sin(alpha)], "
        "[sin(theta)*sin(alpha), cos(theta)*sin(alpha), cos(alpha)]]; ph_i = [a, -sin(alpha)*d, cos(alpha)*d]",
        "The formulas put joint i on z of the frame that is fixed to link i: that is the modified convention (a and α those "
        "of link i−1), while the name alone usually means the standard one.",
        figure="6.4",
    ),
    Item(
        "eq-6.16", "6.3.1.1", "Turning joint: angular velocity", "derivation", "The joint adds its rate about its axis.",
        "w_i = w_h + theta_i_d*z_i", _proved(REVOLUTE, "d_dt(R_i) = skew(w_i)*R_i"), figure="6.4",
    ),
    Item(
        "eq-6.17", "6.3.1.1", "In components", "derivation", "Each vector by its local components.",
        "R_i*omega_i = R_h*omega_h + theta_i_d*(R_i*z)", REVOLUTE,
    ),
    Item(
        "eq-6.18", "6.3.1.1", "In local components", "derivation", "Multiplied by R_i transposed.",
        "omega_i = Ri_h*omega_h + theta_i_d*z", REVOLUTE,
    ),
    Item(
        "uf-6.18-defs", "6.3.1.1", "Which way the matrix turns", "definition",
        "The matrix is called the one that relates links i−1 and i.",
        "the rotation matrix relating link i−1 and link i", Run(direction, ("Ri_h", "R_i", "R_h"), calls=CHAIN), "incomplete",
        "Ri_h = transpose(R_i)*R_h",
        "Only one of two readings fits (6.18): it takes components of frame i−1 to frame i.",
    ),
    Item(
        "eq-6.19", "6.3.1.1", "Turning joint: velocity", "derivation", "Joint i is a point of link i−1.",
        "v_i = Ri_h*(v_h + cross(omega_h, s_h))", _proved(READ_LITERALLY, "R_i*v_i = d_dt(r_i)"), "misprint",
        "v_i = Ri_h*(v_h + cross(omega_h, ph_i))",
        "The prime is missing on s: it needs components in frame i−1, as the p of (6.26) has.",
    ),
    Item(
        "eq-6.20", "6.3.1.1", "Turning joint: angular acceleration", "derivation", "(6.18) differentiated; the joint's axis turns too.",
        "omega_i_d = Ri_h*omega_h_d + theta_i_dd*z + cross(Ri_h*omega_h, theta_i_d*z)",
        _proved(REVOLUTE, "R_i*omega_i_d = d_dt(R_i*omega_i)"),
    ),
    Item(
        "eq-6.21", "6.3.1.1", "Turning joint: acceleration", "derivation", "(6.19) differentiated.",
        "v_i_d = Ri_h*(v_h_d + cross(omega_h_d, pi_h) + cross(omega_h, cross(omega_h, s_h)))",
        _proved(READ_LITERALLY, "R_i*v_i_d = d_dt(R_i*v_i)"), "inconsistent",
        "v_i_d = Ri_h*(v_h_d + cross(omega_h_d, ph_i) + cross(omega_h, cross(omega_h, ph_i)))",
        "One vector stands under two names, s without a prime and p with its indices exchanged; it is p of (6.26). The dotted "
        "v′ are components of the acceleration, not derivatives of components.",
    ),
    Item(
        "eq-6.22", "6.3.1.1", "Acceleration of the centre of mass", "derivation", "A point of link i.",
        f"vc_i_d = {_C}", _proved(BOTH, "R_i*vc_i_d = d_dt(d_dt(rc_i))"),
    ),
    Item(
        "uf-6.22-com-velocity", "6.3.1.1", "Velocity of the centre of mass", "derivation",
        "The energies of 6.2 need it, and section 6.2 refers to 6.3 for it.", "", _proved(BOTH, "R_i*vc_i = d_dt(rc_i)"),
        "incomplete", "vc_i = v_i + cross(omega_i, sc_i)", "It is not printed there.",
    ),
    Item(
        "uf-6.23-equal-omega", "6.3.1.2", "Sliding joint", "identity", "Both links turn alike.", "w_i = w_h", PRISMATIC, figure="6.5",
    ),
    Item("eq-6.23", "6.3.1.2", "In components", "derivation", "By local components.", "R_i*omega_i = R_h*omega_h", PRISMATIC, figure="6.5"),
    Item(
        "eq-6.24", "6.3.1.2", "In local components", "derivation", "The matrix is constant.",
        "omega_i = Ri_h*omega_h", _proved(PRISMATIC, "d_dt(Ri_h) = 0"),
    ),
    Item(
        "eq-6.25", "6.3.1.2", "Sliding joint: angular acceleration", "derivation", "(6.24) differentiated.",
        "omega_i_d = Ri_h*omega_h_d", _proved(PRISMATIC, "R_i*omega_i_d = d_dt(R_i*omega_i)"),
    ),
    Item(
        "eq-6.26", "6.3.1.2", "Sliding joint: velocity", "derivation", "A point of link i−1, and the sliding; p holds the slide itself.",
        "v_i = Ri_h*(v_h + cross(omega_h, ph_i)) + d_i_d*z", _proved(PRISMATIC, "R_i*v_i = d_dt(r_i)"), figure="6.5",
    ),
    Item(
        "eq-6.27", "6.3.1.2", "Sliding joint: acceleration", "derivation", "(6.26) differentiated, with Coriolis' term.",
        "v_i_d = Ri_h*(v_h_d + cross(omega_h_d, ph_i) + cross(omega_h, cross(omega_h, ph_i))) "
        "+ 2*cross(omega_i, d_i_d*z) + d_i_dd*z", _proved(PRISMATIC, "R_i*v_i_d = d_dt(R_i*v_i)"), figure="6.5",
    ),
    Item("eq-6.28", "6.3.2", "Force of inertia", "definition", "In local components.", "fc_i = m_i*vc_i_d", BOTH),
    Item(
        "eq-6.29", "6.3.2", "Moment of inertia", "definition", "(6.5) for link i; the tensor is the local one, I′ of (6.3).",
        "nc_i = I_i*omega_i_d + cross(omega_i, I_i*omega_i)", _proved(BOTH, "R_i*nc_i = d_dt(R_i*(I_i*omega_i))"),
    ),
    Item(
        "uf-6.29-inward-text", "6.3.2", "Which recursion", "text",
        "Forces and torques are said to be found by the outward recursion.", "through the outward recursion",
        Reading("through the inward recursion", "the section is called inward recursion, and forces go from the tip to the base (chapter 4)."),
        "misprint", "through the inward recursion", "It is the inward recursion that finds forces and torques.",
    ),
    Item(
        "uf-6.29-inward-missing", "6.3.2", "Inward recursion", "algorithm",
        "The section of this title stops before its equations, and refers to the literature for sliding joints.",
        "", Related(accelerated, (1, 2, 3, 4), "tau = tau_L", SWEPT), "incomplete",
        "f_hi = fc_i + Ri_k*f_ik; n_i = nc_i + Ri_k*n_k + cross(sc_i, fc_i) + cross(pi_k, Ri_k*f_ik); "
        "tau1 = dot(n1, z); tau2 = dot(f12, z); tau3 = dot(n3, z); tau4 = dot(f34, z)",
        "With v̇₀ = −g. A turning joint's motor gives the moment about z, a sliding one's the force along z; the other five "
        "components are the bearing's.",
    ),
    Item(
        "uf-6.29-tip-load", "6.3.2", "A load on the tip", "algorithm", "The notes give no values behind the last link.",
        "", Related(tip_load), "incomplete", "tau_tip - tau_free = transpose(J_v)*f + transpose(J_w)*n",
        "A wrench that the last link exerts on its surroundings adds exactly Jᵀ times itself.",
    ),
    Item(
        "uf-6.29-classic-dh", "6.3.2", "The same in standard frames", "algorithm",
        "For frames by the standard convention, where joint i acts along z of frame i−1, the recursion reads differently.",
        "", Related(standard_frames), "incomplete",
        "omega2 = E2*omega1; omega2_d = E2*omega1_d; v2 = E2*(v1 + d2_d*z) + cross(omega2, p2); "
        "v2_d = E2*(v1_d + d2_dd*z) + cross(omega2_d, p2) + 2*cross(omega2, E2*(d2_d*z)) + cross(omega2, cross(omega2, p2)); "
        "omega3 = E3*(omega2 + theta3_d*z); omega3_d = E3*(omega2_d + theta3_dd*z + cross(omega2, theta3_d*z)); "
        "v3 = E3*v2 + cross(omega3, p3); v3_d = E3*v2_d + cross(omega3_d, p3) + cross(omega3, cross(omega3, p3)); tau_swept = tau",
        "E takes components of the link before to those of the link, p leads from the frame before to this one, (a, d sin α, d cos α); "
        "here joint 2 slides and joint 3 turns. Inward the moment gains (p + s_C) × f_C and p × what the next link passes on; "
        "the motor's part of it is along E z.",
    ),
)  # fmt: skip
