"""Section 6.2 and 6.3: Lagrange and the recursion in space, with Denavit-Hartenberg frames
(6.15-6.29)."""

from __future__ import annotations

from functools import cache

import numpy as np

import freebody as fb
from freebody_notes.checks import ByFunction, Related, number
from freebody_notes.item import Outcome

ROWS = (
    {"joint": "R", "a": 0.0, "alpha": 0.0, "d": 0.3,
     "m": 2.0, "com": [0.1, -0.2, 0.05], "I": [0.3, 0.02, 0.01, 0.4, -0.03, 0.5]},
    {"joint": "P", "a": 0.4, "alpha": 0.7, "theta": 0.2,
     "m": 1.5, "com": [-0.05, 0.1, 0.2], "I": [0.2, 0.01, 0.0, 0.1, 0.02, 0.2]},
    {"joint": "R", "a": -0.2, "alpha": -1.1, "d": 0.1,
     "m": 1.0, "com": [0.15, 0.05, 0.1], "I": [0.05, 0.0, 0.01, 0.06, 0.0, 0.04]},
    {"joint": "P", "a": 0.1, "alpha": 0.4, "theta": -0.5,
     "m": 0.5, "com": [0.0, 0.02, -0.1], "I": [0.02, 0.0, 0.0, 0.03, 0.0, 0.01]},
)  # fmt: skip
"""A chain with both kinds of joints, skew axes, full inertia tensors."""

GRAVITY = [0.3, -1.2, -9.7]


@cache
def arm(gravity: str = "explicit"):
    """An R P R P chain in modified Denavit-Hartenberg frames, with gravity in a general
    direction."""
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
    """The R P R P chain with its base accelerated by −g instead of gravity; tau_L: the torques from
    Lagrange's equations."""
    free = arm("base")
    chain = fb.dh(ROWS, convention="modified", gravity=GRAVITY)
    return free | {"tau_L": fb.derive(chain, "lagrange").tau}


def upright():
    """The R P R P chain with gravity along −z; h1 … h4 are the heights of the centres of mass."""
    free = fb.quantities(fb.dh(ROWS, convention="modified"))
    return free | {f"h{n}": free[f"rc{n}"][2] for n in range(1, 5)}


def frames(form: str) -> Outcome:
    """Outcome of a statement about Denavit-Hartenberg frames, tested in the modified convention, as
    the notes' words fit standard frames too."""
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
        return Outcome(False, ("Two conventions have this name, and their frames differ.", *lines))
    T = poses["modified"]
    values = {
        "theta": theta, "alpha": 0.7, "a": 0.4, "d": 0.1, "Rh_i": T[:3, :3], "ph_i": T[:3, 3],
    }  # fmt: skip
    return Related(lambda: values).run(form)


def _axis(convention, T):
    return number([0.0, 0.0, 1.0] if convention == "standard" else T[:3, 2])


def direction(form: str) -> Outcome:
    """Outcome of a statement about a rotation matrix, whose two possible directions are each tested
    in (6.18)."""
    if "=" in form:
        return REVOLUTE.run(form)
    readings = {
        "frame i−1 to frame i": "Ri_h",
        "frame i to frame i−1": "transpose(Ri_h)",
    }
    verdicts = {
        words: REVOLUTE.run(f"omega_i = {matrix}*omega_h + theta_i_d*z").holds
        for words, matrix in readings.items()
    }
    lines = tuple(
        f"If the matrix transforms components in {words}, (6.18) {'holds' if v else 'fails'}."
        for words, v in verdicts.items()
    )
    return Outcome(all(verdicts.values()), lines)


def tip_load():
    """Torques of the chain with and without a wrench that its last link exerts on the
    surroundings."""
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
    {"joint": "R", "a": 0.3, "alpha": 0.7, "d": 0.2,
     "m": 2.0, "com": [0.1, -0.2, 0.05], "I": [0.3, 0.02, 0.01, 0.4, -0.03, 0.5]},
    {"joint": "P", "a": 0.1, "alpha": -0.4, "theta": 0.3,
     "m": 1.5, "com": [-0.05, 0.1, 0.2], "I": [0.2, 0.01, 0, 0.1, 0.02, 0.2]},
    {"joint": "R", "a": -0.2, "alpha": 1.1, "d": 0.1,
     "m": 1.0, "com": [0.15, 0.05, 0.1], "I": [0.05, 0, 0.01, 0.06, 0, 0.04]},
)  # fmt: skip


def standard_frames():
    """An R P R chain in standard frames: the motion of each frame from fb.velocity and
    fb.acceleration in its own axes, torques from fb.inverse_dynamics and from the recursion written
    out."""
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
    """Joint torques of the R P R chain by the recursion in standard frames, with gravity as an
    acceleration of the base."""
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


CHAIN = 'fb.quantities(fb.dh(rows, convention="modified", gravity=[0.3, -1.2, -9.7]))  # R P R P'
REVOLUTE = Related(explicit, (1, 3), calls=CHAIN)

CHECKS = {
    "revolute": REVOLUTE,
    "prismatic": Related(explicit, (2, 4), calls=CHAIN),
    "both": Related(explicit, (1, 2, 3, 4), calls=CHAIN),
    "read_literally": Related(
        explicit,
        (1, 3),
        calls=f"{CHAIN}\nvalues['s2'] = R2 @ p2_3  # without a prime s has global components",
    ),
    "upright": Related(upright, (1, 2, 3, 4)),
    "frames": ByFunction(
        frames,
        ("Rh_i", "ph_i"),
        calls='fb.forward_kinematics(fb.dh([row], convention="modified"), [theta])  '
        '# and "standard"',
    ),
    "direction": ByFunction(direction, ("Ri_h", "R_i", "R_h"), calls=CHAIN),
    "accelerated": Related(
        accelerated,
        (1, 2, 3, 4),
        calls='fb.quantities(chain, gravity="base"); fb.derive(chain, "lagrange").tau',
    ),
    "tip_load": Related(tip_load),
    "standard_frames": Related(standard_frames),
}
