"""Section 6.1, example 2: the quadrotor (6.8-6.14)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import ByFunction, Digits, Related, number
from freebody_notes.item import Outcome
from freebody_textbook.relations.formula_values import Each
from freebody_textbook.relations.relation import printed_numbers


def flight():
    """The bundled quadrotor with g = 9.8 m/s², its attitude in Z-X-Z angles, the thrusts acting at
    the rotors' frames."""
    flyer = fb.load("quadrotor").replace(gravity=[0, 0, -9.8])
    R = fb.rotation("ZXZ", [np.pi / 4, 0.1, 0.2])
    thrusts = [np.array([0, 0, x]) for x in (3.2, 1.4, 2.5, 3.6)]
    omega = np.array([0.5, 0, 0.1])
    q = np.concatenate([np.zeros(3), fb.quat_wxyz(R)])
    qd = np.concatenate([np.zeros(3), R.T @ omega])  # the model's ω has the body's axes
    push = {f"rotor{i + 1}": [*(R @ F), 0, 0, 0] for i, F in enumerate(thrusts)}
    qdd = fb.forward_dynamics(flyer, q, qd, np.zeros(6), wrenches=push)
    acceleration = fb.acceleration(flyer, q, qd, qdd)
    neutral = np.array([0, 0, 0, 1.0, 0, 0, 0])
    arms = [fb.forward_kinematics(flyer, neutral, f"rotor{i + 1}")[:3, 3] for i in range(4)]
    I_prime = np.diag([5.0, 5.0, 10.0])
    I, v_d, omega_d = R @ I_prime @ R.T, acceleration[:3], acceleration[3:]
    return {
        "R": R, "m": flyer.mass, "gravity": flyer.gravity, "F": flyer.mass * v_d, "v_d": v_d,
        "omega": omega, "omega_d": omega_d, "I_prime": I_prime, "I": I,
        "n": I @ omega_d + np.cross(omega, I @ omega), "F_i_prime": Each(thrusts),
        "F_i": Each(R @ F for F in thrusts), "s_i_prime": Each(arms), "i": Each((1, 2, 3, 4)),
        "pi": np.pi, "phi1": np.pi / 4, "phi2": 0.1, "phi3": 0.2,
        "n_prime": R.T @ (I @ omega_d + np.cross(omega, I @ omega)), "I_y": 5.0, "I_z": 10.0,
    }  # fmt: skip


def euler_angles():
    values = flight()
    turns = {
        f"R_{k}": fb.rotation(axis, [values[f"phi{k}"]])
        for k, axis in ((1, "Z"), (2, "X"), (3, "Z"))
    }
    return values | turns


def inertia(form: str) -> Outcome:
    """Outcome of checking an inertia formula with the data as printed, with a note on the I_x from
    which the printed numbers follow."""
    values = flight()
    local = (
        values["R"].T @ np.reshape([x for x, _ in printed_numbers(PRINTED_I)], (3, 3)) @ values["R"]
    )
    recovered = (
        "The printed numbers turned back into local axes have the diagonal "
        f"{number(np.diag(local), 5)}."
    )
    if "I_x" in form:
        outcome = Related(flight).run(form)
        return Outcome(outcome.holds, (*outcome.lines, recovered))
    outcome = Digits(flight).run(form)
    return Outcome(outcome.holds, outcome.lines)


def turning(form: str) -> Outcome:
    """Outcome of checking the angular acceleration, with the numbers that follow when the thrusts
    are rotated into global axes twice."""
    values = flight()
    outcome = Digits(flight).run(form)
    twice = values["R"] @ sum(
        np.cross(s, F) for s, F in zip(values["s_i_prime"], values["F_i"], strict=True)
    )
    I, omega = values["I"], values["omega"]
    mixed = np.linalg.solve(I, twice - np.cross(omega, I @ omega))
    return Outcome(
        outcome.holds,
        (*outcome.lines, f"With n = R ∑ s′ × (R F′) instead, ω̇ is {number(mixed, 5)}."),
    )


PRINTED_I = (
    "[[5.02483, -0.02489, 0.35119], [-0.02489, 5.02483, -0.35119], [0.35119, -0.35119, 9.95008]]"
)


CHECKS = {
    "flight": Related(flight),
    "flight_digits": Digits(flight),
    "euler_angles": Digits(euler_angles),
    "inertia": ByFunction(
        inertia,
        ("I", "R"),
        calls="R = fb.rotation('ZXZ', [np.pi/4, 0.1, 0.2]); R @ np.diag([5, 5, 10]) @ R.T",
    ),
    "turning": ByFunction(
        turning,
        ("omega_d", "I", "n", "omega"),
        calls='fb.forward_dynamics(fb.load("quadrotor").replace(gravity=[0, 0, -9.8]), '
        "q, qd, np.zeros(6), wrenches=thrusts)",
    ),
}
