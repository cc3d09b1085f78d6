"""Section 5.1: kinetic and potential energies (5.1-5.5)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody_notes.checks import Related


def moving_bar(turning=1.4, pinned=False):
    """A moving uniform bar: its kinetic energy as the integral of ½ dm v² along it, and the kinetic
    energy that freebody computes."""
    l, m = 1.2, 3.0
    body = fb.planar(
        "PPR", m=[0, 0, m], lc=[0, 0, l / 2], I=[0, 0, m * l**2 / 12], l=[0, 0, l], g=0
    )
    q, qd = [0.3, -0.4, 0.7], [0.0 if pinned else 0.9, 0.0 if pinned else -0.5, turning]
    u, w = np.polynomial.legendre.leggauss(8)
    points = [fb.velocity(body, q, qd, "link3", point=[x, 0.0])[:2] for x in l / 2 * (u + 1)]
    v_G = fb.velocity(body, q, qd, "link3", point=[l / 2, 0.0])[:2]
    return {
        "T": fb.kinetic_energy(body, q, qd),
        "T_pieces": float(m / 4 * w @ np.sum(np.square(points), axis=1)), "m": m, "v": points[0],
        "v_G": v_G, "omega": turning, "I_G": m * l**2 / 12, "I_o": m * l**2 / 3,
    }  # fmt: skip


def translating_bar():
    return moving_bar(turning=0.0)


def pinned_bar():
    return moving_bar(pinned=True)


def lifted():
    """A body on a vertical slide: its potential energy, and the work W done by its weight when it
    rises from 0."""
    lift = fb.planar("P", m=["m"], lc=[0], I=["I"], angles=[np.pi / 2])
    free = fb.quantities(lift)
    height = free["rc1"][1]
    return free | {"h": height, "W": free["m"] * free["gravity"][1] * height}


def stretched_spring():
    """A slide on a spring, without weight: the holding force is the derivative of the potential
    energy."""
    slide = fb.planar("P", m=["m"], lc=[0], I=["I"], g=0, drives=[fb.Drive(stiffness="k")])
    free = fb.quantities(slide)
    return free | {"x": free["d1"]}


CHECKS = {
    "translating_bar": Related(translating_bar),
    "pinned_bar": Related(pinned_bar),
    "moving_bar": Related(moving_bar),
    "lifted": Related(lifted),
    "stretched_spring": Related(stretched_spring),
}
