"""Logs of simulated arms: Fourier motions, torques with friction, noise on torques and encoders."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import freebody as fb

RATE = 100.0


def arm(rng=None, friction=("viscous", "coulomb"), offset=0.3):
    """An arm of three joints; with rng, of random masses, rotors and friction."""
    rows = [
        {"a": 0.0, "alpha": np.pi / 2, "d": 0.3},
        {"a": 0.4, "alpha": 0.0, "d": 0.0},
        {"a": 0.35, "alpha": 0.0, "d": 0.1},
    ]
    model = fb.dh(rows, convention="standard", name="arm")
    if rng is None:
        return model
    return with_random_numbers(model, rng, friction)


def with_random_numbers(model, rng, friction=("viscous", "coulomb")):
    """The model with random bodies of some kilograms, rotors, and friction."""
    model = model.without("friction", "rotors", "springs")
    names = list(fb.inertial_parameters(model))
    pi = []
    for k in range(len(model.bodies)):
        m = rng.uniform(1.0, 6.0) * 0.8**k
        c = rng.uniform(-0.15, 0.15, 3)
        a = rng.uniform(-0.1, 0.1, (3, 3))
        second = m * (a @ a.T + 0.002 * np.eye(3) + np.outer(c, c))
        inertia = np.trace(second) * np.eye(3) - second
        pi += [m, *(m * c), *(inertia[i, j] for i in range(3) for j in range(i, 3))]
    assert len(names) == len(pi)
    made = model.with_inertial_parameters(pi)
    for joint in model.joint_names:
        numbers = {"rotor": rng.uniform(0.05, 0.4)}
        sizes = {
            "viscous": 4.0,
            "coulomb": 3.0,
            "offset": 0.4,
            "cube_root": 3.0,
            "load": 0.08,
            "stribeck": 3.0,
            "quadratic": 2.0,
        }
        for law in friction:
            name = "load_friction" if law == "load" else law
            numbers[name] = sizes[law] * rng.uniform(0.4, 1.0)
        if "stribeck" in friction:
            numbers["stribeck_speed"] = 0.15
        made = made.with_drive(joint, **numbers)
    return made


def motion(n, rng, duration=20.0, rate=RATE, harmonics=5):
    """Positions, rates, accelerations (samples, n) of random Fourier series."""
    t = np.arange(int(duration * rate) + 1) / rate
    w = 2.0 * np.pi * np.arange(1, harmonics + 1) / 10.0
    a, b = rng.normal(size=(2, harmonics, n)) / np.arange(1, harmonics + 1)[:, None]
    s, c = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    q = s @ a + c @ b
    qd = c @ (w[:, None] * a) - s @ (w[:, None] * b)
    qdd = -s @ (w[:, None] ** 2 * a) - c @ (w[:, None] ** 2 * b)
    return t, q, qd, qdd


def log(model, rng, noise=0.02, encoder=2e-5, rates=1e-3, duration=20.0, gains=None):
    """A log of a random motion. noise: of torques, over their RMS. encoder, rates: standard
    deviations of positions and rates."""
    t, q, qd, qdd = motion(model.nv, rng, duration)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    tau = tau + noise * np.sqrt(np.mean(tau**2, axis=0)) * rng.normal(size=tau.shape)
    current = None if gains is None else tau / gains
    return fb.Log(
        t,
        q + encoder * rng.normal(size=q.shape),
        qd + rates * rng.normal(size=q.shape),
        tau if gains is None else None,
        current,
        model.velocity_names,
        np.ones(len(t), dtype=bool),
    )


class States(NamedTuple):
    """Positions, rates and accelerations (samples, n)."""

    q: np.ndarray
    qd: np.ndarray
    qdd: np.ndarray


class ExactLog(fb.Log):
    """A log whose accelerations are known."""

    exact: States

    def states(self, cutoff=0.0):
        return self.exact


def exact_log(model, rng, duration=20.0):
    """A log without noise, with its accelerations."""
    t, q, qd, qdd = motion(model.nv, rng, duration)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    made = ExactLog(t, q, qd, tau, None, model.velocity_names, np.ones(len(t), dtype=bool))
    object.__setattr__(made, "exact", States(q, qd, qdd))
    return made
