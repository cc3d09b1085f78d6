"""Section 6.1: one rigid body in space, and the gyro (6.1-6.7)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.model.build import build_model
from freebody.model.description import Joint, Link, RobotDescription
from freebody.model.inertia import combined
from freebody_notes.checks import Digits, Related
from freebody_textbook.relations.formula_values import Each


def thrown_body():
    """Five particles of a rigid body in arbitrary spatial motion, with Newton's law for each of
    them."""
    masses = np.array([2.0, 1.0, 3.0, 1.5, 2.5])
    points = np.random.default_rng(3).normal(size=(5, 3))
    points -= masses @ points / masses.sum()
    inertia = combined([fb.Inertia.point(m, p) for m, p in zip(masses, points, strict=True)])
    flyer = fb.load("quadrotor")
    q, qd, qdd = (x[0] for x in fb.random_state(flyer, 4, 1))
    R = fb.forward_kinematics(flyer, q)[:3, :3]
    velocity, acceleration = fb.velocity(flyer, q, qd), fb.acceleration(flyer, q, qd, qdd)
    a_i = [fb.acceleration(flyer, q, qd, qdd, point=p)[:3] for p in points]
    F_i = Each(tuple(m * a) for m, a in zip(masses, a_i, strict=True))
    rho_i = Each(tuple(R @ p) for p in points)
    omega, omega_d = velocity[3:], acceleration[3:]
    n = sum(np.cross(r, F) for r, F in zip(rho_i, F_i, strict=True))
    about_com = sum(
        m * (r @ r * np.eye(3) - np.outer(r, r))
        for m, r in zip(masses, np.array(rho_i), strict=True)
    )
    return {
        "m": inertia.mass, "F_i": F_i, "rho_i": rho_i, "v_c_d": acceleration[:3], "R": R, "n": n,
        "I": about_com, "I_prime": inertia.numbers()[2], "omega": omega, "omega_d": omega_d,
        "n_prime": R.T @ n, "omega_prime": R.T @ omega, "omega_prime_d": R.T @ omega_d,
    }  # fmt: skip


def rotor():
    """The gyro's rotor on a ball joint at its centre, with a constant ω' in its own axes."""
    links = (Link("base"), Link("rotor", fb.Inertia.of(1, [0, 0, 0], [10, 0, 0, 5, 0, 5])))
    pivot = Joint("pivot", "spherical", "base", "rotor")
    body = build_model(RobotDescription("rotor", 3, links, (pivot,), (0.0, (0.0, 0.0, -1.0))))
    omega, still = np.array([5.0, 0.0, 3.0]), np.zeros(3)
    return {
        "n_prime": fb.inverse_dynamics(body, [1, 0, 0, 0], omega, still),
        "I_prime": np.diag([10.0, 5.0, 5.0]), "omega_prime": omega, "omega_prime_d": still,
    }  # fmt: skip


def gyro():
    """The gyro's moments. n_1: ω' is constant in the rotor's axes. n_2: it rolls at a constant 5
    rad/s while its ring yaws at 3 rad/s."""
    mounted = fb.load("gyro")
    rates = {"yaw": 3.0, "roll": 5.0}
    roll = mounted.joint_names.index("roll")
    still = {"yaw": 0.0, "roll": 0.0}
    driven = fb.joint_wrenches(mounted, still, rates, still, reference="child")[roll, 3:]
    return {"n_1": rotor()["n_prime"], "n_2": driven, "n": driven}


CHECKS = {
    "thrown_body": Related(thrown_body),
    "gyro": Digits(gyro),
    "rotor": Related(rotor),
    "rotor_digits": Digits(rotor),
}
