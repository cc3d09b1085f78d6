"""Mechanisms in coordinates of every part (Newton, Euler, and constraints by singular values),
without freebody's kinematics: from poses and twists of the parts to their accelerations."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from support.closed_chains import GROUND, Mechanism, Moving, Pin, moment, turned


def accelerations(
    mechanism: Mechanism,
    state: Moving,
    torques: Mapping[str, float],
    wrenches: Mapping[str, np.ndarray],
) -> np.ndarray:
    """(parts, six) of each part's origin, world axes, linear first.

    torques: of pins, b against a; wrenches: on parts, at their origins.
    """
    dim, parts = mechanism.dim, list(mechanism.parts)
    six = 6 if dim == 3 else 3
    place = {part: slice(six * k, six * (k + 1)) for k, part in enumerate(parts)}
    M, force = np.zeros((six * len(parts),) * 2), np.zeros(six * len(parts))
    for part, at in place.items():
        M[at, at], force[at] = _body(mechanism, state, part)
        force[at] += wrenches.get(part, 0.0)
    rows, right = [], []
    for pin in mechanism.pins:
        for signed, c in equations(mechanism, state, pin):
            row = np.zeros(six * len(parts))
            for part, entries in signed:
                if part != GROUND:
                    row[place[part]] += entries
            rows.append(row)
            right.append(c)
        _drive(mechanism, state, pin, torques.get(pin.name, 0.0), force, place)
    J, c = np.array(rows), np.array(right)
    root = np.linalg.inv(
        np.linalg.cholesky(M)
    ).T  # least constraint is least norm where inertias are 1
    A, free = J @ root, root.T @ force
    return (root @ (free + np.linalg.pinv(A, rcond=1e-10) @ (c - A @ free))).reshape(
        len(parts), six
    )


def _body(mechanism: Mechanism, state: Moving, part: str) -> tuple[np.ndarray, np.ndarray]:
    """Inertia about the part's origin, world axes, and the force of gravity and of the motion
    itself."""
    dim, inertia = mechanism.dim, mechanism.parts[part]
    assert inertia is not None
    R, w = state.T[part][:dim, :dim], state.V[part][dim:]
    m, com, about = inertia.numbers()
    com = R @ np.array(com)
    g = np.array(mechanism.gravity)
    central = turned(w, turned(w, com))
    if dim == 2:
        I = np.array(about).ravel()[:1]
        lever = np.array([[-com[1]], [com[0]]])
        top = np.hstack([m * np.eye(2), m * lever])
        bottom = np.hstack([m * lever.T, [[float(I[0]) + m * com @ com]]])
        f = m * (g - central)
        return np.vstack([top, bottom]), np.concatenate([f, moment(com, f)])
    I = R @ np.array(about) @ R.T
    x = np.array([[0, -com[2], com[1]], [com[2], 0, -com[0]], [-com[1], com[0], 0]])
    f = m * (g - central)
    mass = np.block([[m * np.eye(3), -m * x], [m * x, I - m * x @ x]])
    return mass, np.concatenate([f, np.cross(com, f) - np.cross(w, I @ w)])


def _point(mechanism: Mechanism, state: Moving, part: str, T: np.ndarray):
    """(axes, place, velocity, angular velocity, arm, acceleration at zero accelerations of the
    part) of a frame."""
    dim = mechanism.dim
    G, V = state.T[part] @ T, state.V[part]
    arm = G[:dim, dim] - state.T[part][:dim, dim]
    w = V[dim:]
    return G[:dim, :dim], G[:dim, dim], V[:dim] + turned(w, arm), w, arm, turned(w, turned(w, arm))


def equations(mechanism: Mechanism, state: Moving, pin: Pin):
    """([(part, entries of the row)], right-hand side) of each equation of accelerations of a
    pin."""
    dim = mechanism.dim
    R, p_a, v_a, w_a, arm_a, bias_a = _point(mechanism, state, pin.a, pin.T_a)
    _, p_b, v_b, w_b, arm_b, bias_b = _point(mechanism, state, pin.b, pin.T_b)
    none = np.zeros(3 if dim == 3 else 1)

    def at_points(f, extra_a=none):
        """f · (acceleration of b's point - that of a's)."""
        return [
            (pin.b, np.concatenate([f, moment(arm_b, f)])),
            (pin.a, -np.concatenate([f, moment(arm_a, f) + extra_a])),
        ]

    def of_turns(t):
        return [
            (pin.b, np.concatenate([np.zeros(dim), t])),
            (pin.a, -np.concatenate([np.zeros(dim), t])),
        ]

    r, rd = p_b - p_a, v_b - v_a
    if pin.kind in ("revolute", "spherical", "fixed"):
        for e in np.eye(dim):
            yield at_points(e), -e @ (bias_b - bias_a)
    if pin.kind == "distance":
        yield at_points(r), -r @ (bias_b - bias_a) - rd @ rd
    if pin.kind == "prismatic":
        for n in np.linalg.svd(np.array([pin.axis]))[2][1:]:
            t = R @ n  # fixed in a: t · r = 0
            second = turned(w_a, turned(w_a, t))
            yield (
                at_points(t, moment(r, t)),
                -t @ (bias_b - bias_a) - 2.0 * turned(w_a, t) @ rd - second @ r,
            )
    if pin.kind in ("fixed", "prismatic"):
        for e in np.eye(len(none)):
            yield of_turns(e), 0.0
    if pin.kind == "revolute" and dim == 3:
        for n in np.linalg.svd(np.array([pin.axis]))[2][1:]:
            t = R @ n
            yield of_turns(t), -np.cross(w_a, t) @ (w_b - w_a)


def _drive(mechanism: Mechanism, state: Moving, pin: Pin, torque: float, force, place) -> None:
    """The torque or force of a pin on both parts."""
    if not torque:
        return
    dim = mechanism.dim
    R = _point(mechanism, state, pin.a, pin.T_a)[0]
    p_b = _point(mechanism, state, pin.b, pin.T_b)[1]
    axis = np.array(pin.axis) if dim == 2 and pin.kind == "revolute" else R @ np.array(pin.axis)
    for part, sign in ((pin.b, 1.0), (pin.a, -1.0)):
        if part != GROUND and pin.kind == "prismatic":
            # on a too, a slide presses where b's point is
            f, lever = sign * torque * axis, p_b - state.T[part][:dim, dim]
            force[place[part]] += np.concatenate([f, moment(lever, f)])
        elif part != GROUND:
            force[place[part]] += np.concatenate([np.zeros(dim), sign * torque * axis])
