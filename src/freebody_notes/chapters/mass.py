"""Section 1.2.2: centre of mass and moment of inertia (1.15-1.20)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.model.inertia import combined
from freebody_notes.checks import ByFunction, Related
from freebody_notes.item import Outcome
from freebody_textbook.relations.formula_values import Each


def particles():
    """Three particles that form one rigid body, turning at the rate omega about G."""
    masses, points = (2.0, 1.0, 3.0), np.array([[0.2, 0.1], [-0.4, 0.3], [0.5, -0.2]])
    body = combined([fb.Inertia.point(m, r) for m, r in zip(masses, points, strict=True)])
    rho, omega = points - np.array(body.com), 1.7
    speed = omega * np.linalg.norm(rho, axis=1)
    return {
        "m": body.mass, "r_G": body.com, "I_G": body.tensor[0], "omega": omega, "m_i": Each(masses),
        "r_i": Each(map(tuple, points)), "rho_i": Each(map(tuple, rho)), "v_i": Each(speed),
    }  # fmt: skip


def particles_about_com():
    """Moments of inertia of particles about their centre of mass G."""
    seen = particles()
    return seen | {"r": seen["rho_i"], "r_i": seen["rho_i"], "r_G": (0.0, 0.0)}


def bar():
    """A uniform bar: its moments of inertia by integration along it."""
    m, l = 1.3, 0.7
    body = fb.integrated_inertia(lambda u: (u, 0 * u), [(0, l)], m)
    pieces = np.linspace(0, l, 20001)[1::2]  # the middles of ten thousand equal pieces
    return {
        "m": m, "l": l, "r_G": body.com, "I_G": body.tensor[0], "I_O": body.about([0, 0])[0, 0],
        "r_pieces": (pieces.mean(), 0.0),
    }  # fmt: skip


def bar_in_pieces():
    """The moment of inertia of a uniform bar by integration, and as a sum over n = 200 000 pieces;
    the sum is smaller by m l²/12 / n²."""
    m, l, n = 1.3, 0.7, 200_000
    rho = (np.arange(n) + 0.5) * l / n - l / 2
    body = fb.integrated_inertia(lambda u: (u, 0 * u), [(0, l)], m)
    return {"I_G": body.tensor[0], "I_pieces": float(np.mean(rho**2)) * m}


def disc():
    m, r = 2.0, 0.3
    body = fb.integrated_inertia(
        lambda s, a: (s * np.cos(a), s * np.sin(a)), [(0, r), (0, 2 * np.pi)], m
    )
    return {"m": m, "r": r, "I_G": body.tensor[0]}


def ring():
    m, r = 2.0, 0.3
    body = fb.integrated_inertia(lambda a: (r * np.cos(a), r * np.sin(a)), [(0, 2 * np.pi)], m)
    return {"m": m, "r": r, "I_G": body.tensor[0]}


def shifted():
    """Moments of inertia of particles about their centre of mass, and about a point O at the
    distance d."""
    masses, points = (2.0, 1.0, 3.0), np.array([[0.2, 0.1], [-0.4, 0.3], [0.5, -0.2]])
    body = combined([fb.Inertia.point(m, r) for m, r in zip(masses, points, strict=True)])
    O = np.array([-0.3, 0.8])
    direct = sum(m * np.sum((r - O) ** 2) for m, r in zip(masses, points, strict=True))
    mass, com, _ = body.numbers()
    back = fb.inertia_from(mass, com, direct, about=O)
    return {
        "m": body.mass, "d": np.linalg.norm(O - body.com), "I_G": back.tensor[0], "I_O": direct,
    }  # fmt: skip


def parallel_axes(printed: str) -> Outcome:
    """Outcome of checking the parallel axis theorem, with the error that occurs about a point other
    than the centre of mass."""
    values = shifted()
    outcome = Related(lambda: values).run(printed)
    try:
        fb.inertia_from(1.0, [0.0, 0.0], 0.5, about=[1.0, 0.0])
    except fb.FreebodyError as problem:
        return Outcome(
            outcome.holds, (*outcome.lines, f"From any other point it does not hold: {problem}")
        )
    return Outcome(False, ("an inertia smaller than m d² was taken",))


CHECKS = {
    "particles": Related(particles),
    "particles_about_com": Related(particles_about_com),
    "bar": Related(bar),
    "bar_in_pieces": Related(bar_in_pieces),
    "disc": Related(disc),
    "ring": Related(ring),
    "parallel_axes": ByFunction(
        parallel_axes, calls="fb.inertia_from(m, r_G, I_O, about=O).tensor"
    ),
}
