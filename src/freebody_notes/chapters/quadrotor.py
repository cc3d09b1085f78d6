"""Section 6.1, example 2: the quadrotor (6.8-6.14)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.relation import printed_numbers
from freebody.derivations.values import Each
from freebody_notes.checks import Digits, Related, Run, number
from freebody_notes.item import Item, Outcome


def flight():
    """The bundled quadrotor with g = 9.8 m/s², turned by Z-X-Z angles; its thrusts pushed on it at
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
        "R": R, "m": flyer.mass, "gravity": flyer.gravity, "F": flyer.mass * v_d, "v_d": v_d, "omega": omega,
        "omega_d": omega_d, "I_prime": I_prime, "I": I, "n": I @ omega_d + np.cross(omega, I @ omega),
        "F_i_prime": Each(thrusts), "F_i": Each(R @ F for F in thrusts), "s_i_prime": Each(arms), "i": Each((1, 2, 3, 4)),
        "pi": np.pi, "phi1": np.pi / 4, "phi2": 0.1, "phi3": 0.2, "n_prime": R.T @ (I @ omega_d + np.cross(omega, I @ omega)),
        "I_y": 5.0, "I_z": 10.0,
    }  # fmt: skip


def euler_angles():
    values = flight()
    turns = {
        f"R_{k}": fb.rotation(axis, [values[f"phi{k}"]])
        for k, axis in ((1, "Z"), (2, "X"), (3, "Z"))
    }
    return values | turns


def inertia(form: str) -> Outcome:
    """The form with the data as printed; and which I_x the printed numbers came from."""
    values = flight()
    local = (
        values["R"].T @ np.reshape([x for x, _ in printed_numbers(PRINTED_I)], (3, 3)) @ values["R"]
    )
    recovered = f"The printed numbers turned back into local axes have the diagonal {number(np.diag(local), 5)}."
    if "I_x" in form:
        outcome = Related(flight).run(form)
        return Outcome(outcome.holds, (*outcome.lines, recovered))
    outcome = Digits(flight).run(form)
    return Outcome(outcome.holds, outcome.lines)


def turning(form: str) -> Outcome:
    """The form; and the printed numbers from thrusts that are turned into global axes once too
    often."""
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


FLIGHT_CALL = 'fb.forward_dynamics(fb.load("quadrotor").replace(gravity=[0, 0, -9.8]), q, qd, np.zeros(6), wrenches=thrusts)'
FLIGHT = Related(flight)
PRINTED_I = (
    "[[5.02483, -0.02489, 0.35119], [-0.02489, 5.02483, -0.35119], [0.35119, -0.35119, 9.95008]]"
)
_RIGHT_I = "[[5.024917, -0.024917, 0.351201], [-0.024917, 5.024917, -0.351201], [0.351201, -0.351201, 9.950166]]"
_MOMENT = "R*sum(cross(s_i_prime, F_i_prime))"

ITEMS = (
    Item(
        "ex-6.2-quadrotor", "6.1", "Example 2: a quadrotor", "worked-example",
        "Linear and angular acceleration of a quadrotor of 5 kg, from four thrusts along its own z, its Z-X-Z angles "
        "(π/4, 0.1, 0.2) and its angular velocity (0.5, 0, 0.1) rad/s.",
        "v_d = [0.151, -0.151, 2.129]; omega_d = [-0.063869, -0.15480, -0.001131]", Digits(flight), "inconsistent",
        "v_d = [0.15107, -0.15107, -7.67069]; omega_d = [-0.064561, -0.155539, -0.006455]",
        "Neither result follows from the data: gravity is missing in (6.13), and (6.14) mixes frames. The data need "
        "I_x = 5 kg m² (blank in print; recovered from (6.12)), g = 9.8 m/s² (recovered from (6.9)) and ω in global "
        "components (so (6.14)).",
        figure="6.3",
    ),
    Item(
        "eq-6.8", "6.1", "Attitude", "worked-example", "Three turns, about z, the new x and the new z.",
        "R = R_1*R_2*R_3 = [[0.5532, -0.83002, 0.07059], [0.8327, 0.54906, -0.07059], [0.01983, 0.09784, 0.9950]]",
        Digits(euler_angles), figure="6.3",
    ),
    Item(
        "eq-6.9", "6.1", "All forces", "worked-example",
        "The thrusts turned into global axes, and the weight. Printed: (0.755333, −0.75533, −38.3535) N.",
        "F = R*sum(F_i) + m*gravity", FLIGHT, "misprint", "F = R*sum(F_i_prime) + m*gravity",
        "What R is multiplied with are the local thrusts F′; the prime is missing. The numbers, which are right to four "
        "digits, belong to g = 9.8 m/s², which is not said: (0.75534, −0.75534, −38.35346) N.",
        figure="6.3",
    ),
    Item(
        "eq-6.10", "6.1", "Rotors", "definition", "Four rotors, half a metre from the centre, on both axes.",
        "s_i_prime = 0.5*[cos((i-1)*pi/2), sin((i-1)*pi/2), 0]", FLIGHT, figure="6.3",
    ),
    Item(
        "eq-6.11", "6.1", "All moments", "worked-example", "Those of the thrusts about the centre.",
        f"n = {_MOMENT} = [-1.1, -0.35, 0]", Digits(flight), "inconsistent",
        f"n = {_MOMENT} = [-0.318046, -1.108244, -0.056062]; n_prime = [-1.1, -0.35, 0]",
        "The formula turns the moment into global axes, the numbers are those before that turn.",
    ),
    Item(
        "eq-6.12", "6.1", "Inertia in global axes", "worked-example", "(6.3), from the principal moments in the data.",
        f"I = R*diag([I_x, I_y, I_z])*transpose(R); I = {PRINTED_I}", Run(inertia, ("I", "R"), calls="R = fb.rotation('ZXZ', [np.pi/4, 0.1, 0.2]); R @ np.diag([5, 5, 10]) @ R.T"), "incomplete",
        f"I = R*diag([5, I_y, I_z])*transpose(R) = {_RIGHT_I}",
        "I_x is blank in the data; the printed numbers come from I_x = 5 kg m², with rounding errors in their last digits.",
    ),
    Item(
        "eq-6.13", "6.1", "Linear acceleration", "worked-example", "All forces over the mass.",
        "v_d = F/m = [0.151, -0.151, 2.129]", Digits(flight), "inconsistent", "v_d = F/m = [0.15107, -0.15107, -7.67069]",
        "The third component is the thrust over the mass alone; with the F of (6.9) the quadrotor falls at 7.67 m/s².",
    ),
    Item(
        "eq-6.14", "6.1", "Angular acceleration", "worked-example", "Euler's equation solved.",
        "omega_d = I^-1*(n - cross(omega, I*omega)) = [-0.063869, -0.15480, -0.001131]", Run(turning, ("omega_d", "I", "n", "omega"), calls=FLIGHT_CALL),
        "inconsistent", "omega_d = I^-1*(n - cross(omega, I*omega)) = [-0.064561, -0.155539, -0.006455]",
        "The printed numbers come from moments of thrusts that were already turned into global axes, turned once more.",
    ),
)  # fmt: skip
