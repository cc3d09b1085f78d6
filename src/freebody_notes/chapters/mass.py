"""Section 1.2.2: centre of mass and moment of inertia (1.15-1.20)."""

from __future__ import annotations

import numpy as np

import freebody as fb
from freebody.derivations.values import Each
from freebody.model.inertia import combined
from freebody_notes.checks import Related, Run
from freebody_notes.item import Item, Outcome


def particles():
    """Three particles that are fixed to each other, and turn at a rate omega about G."""
    masses, points = (2.0, 1.0, 3.0), np.array([[0.2, 0.1], [-0.4, 0.3], [0.5, -0.2]])
    body = combined([fb.Inertia.point(m, r) for m, r in zip(masses, points, strict=True)])
    rho, omega = points - np.array(body.com), 1.7
    speed = omega * np.linalg.norm(rho, axis=1)
    return {
        "m": body.mass, "r_G": body.com, "I_G": body.tensor[0], "omega": omega,
        "m_i": Each(masses), "r_i": Each(map(tuple, points)), "rho_i": Each(map(tuple, rho)), "v_i": Each(speed),
    }  # fmt: skip


def particles_about_com():
    """The same with the origin moved to G."""
    seen = particles()
    return seen | {"r": seen["rho_i"], "r_i": seen["rho_i"], "r_G": (0.0, 0.0)}


def bar():
    """A uniform bar by integration along it."""
    m, l = 1.3, 0.7
    body = fb.integrated_inertia(lambda u: (u, 0 * u), [(0, l)], m)
    pieces = np.linspace(0, l, 20001)[1::2]  # the middles of ten thousand equal pieces
    return {
        "m": m, "l": l, "r_G": body.com, "I_G": body.tensor[0], "I_O": body.about([0, 0])[0, 0],
        "r_pieces": (pieces.mean(), 0.0),
    }  # fmt: skip


def bar_in_pieces():
    """The same with as many pieces as rounding allows: their sum differs by m l²/12 over the square
    of their number."""
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
    """Particles about their centre of mass, and about a point O at the distance d."""
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
    """The theorem, and what becomes of it from a point that is not the centre of mass."""
    values = shifted()
    outcome = Related(lambda: values).run(printed)
    try:
        fb.inertia_from(1.0, [0.0, 0.0], 0.5, about=[1.0, 0.0])
    except fb.FreebodyError as problem:
        return Outcome(
            outcome.holds, (*outcome.lines, f"From any other point it does not hold: {problem}")
        )
    return Outcome(False, ("an inertia smaller than m d² was taken",))


PARTICLES, BAR = Related(particles), Related(bar)

ITEMS = (
    Item(
        "eq-1.15", "1.2.2", "Centre of mass of particles", "definition",
        "The centre of mass is the mean of the positions, weighted by the masses.",
        "r_G = 1/m*sum(m_i*r_i)", PARTICLES, figure="1.3",
    ),
    Item(
        "uf-1.15-total-mass", "1.2.2", "Total mass", "definition",
        "The mass of the whole is the sum of the masses.",
        "m = sum(m_i)", PARTICLES,
    ),
    Item(
        "eq-1.16", "1.2.2", "Centre of mass of a continuum", "definition",
        "For a continuous body the sum becomes an integral over its mass: here of a uniform bar, against ten thousand pieces.",
        "r_G = r_pieces = [l/2, 0]", BAR,
    ),
    Item(
        "uf-1.16-com-zero", "1.2.2", "Origin in the centre of mass", "identity",
        "With the origin in the centre of mass the mass-weighted positions add up to nothing.",
        "r = 0; sum(m_i*r_i) = sum(m_i*rho_i) = 0", Related(particles_about_com),
        "misprint", "r_G = 0; sum(m_i*r_i) = sum(m_i*rho_i) = 0",
        "What vanishes is r_G, the position of the centre of mass; the position r of a particle does not.",
        figure="1.3",
    ),
    Item(
        "eq-1.17", "1.2.2", "Moment of inertia of particles", "definition",
        "Masses times the squares of their distances from G; it is what stands with ω²/2 in the kinetic energy.",
        "I_G = sum(m_i*rho_i^2); 1/2*I_G*omega^2 = sum(1/2*m_i*v_i^2)", PARTICLES,
    ),
    Item(
        "eq-1.18", "1.2.2", "Moment of inertia of a continuum", "definition",
        "The integral of ρ² over the mass; here of a uniform bar, against many small pieces.",
        "I_G = I_pieces", Related(bar_in_pieces),
    ),
    Item(
        "uf-1.18-disc", "1.2.2", "Disc", "definition",
        "A uniform round plate of radius r, about its axis: by integration over the plate.",
        "I_G = 1/2*m*r^2", Related(disc),
    ),
    Item(
        "uf-1.18-ring", "1.2.2", "Ring", "definition",
        "A ring of radius r, about its axis. It has to be thin: a thick one has mass nearer to the axis.",
        "I_G = m*r^2", Related(ring),
    ),
    Item(
        "uf-1.18-bar", "1.2.2", "Bar", "definition",
        "A slender uniform bar of length l, about its middle.",
        "I_G = 1/12*m*l^2", BAR,
    ),
    Item(
        "eq-1.19", "1.2.2", "Parallel axes", "identity",
        "The inertia about an axis at the distance d from the centre of mass; the right side has to start from the centre "
        "of mass and no other point.",
        "I_O = I_G + m*d^2", Run(parallel_axes, calls="fb.inertia_from(m, r_G, I_O, about=O).tensor"),
    ),
    Item(
        "ex-1.3-bar-pin", "1.2.2", "Example: a bar on a pin", "worked-example",
        "The moment of inertia of a uniform bar about a pin at its end.",
        "I_O = 1/3*m*l^2", BAR,
    ),
    Item(
        "eq-1.20", "1.2.2", "Bar about its end", "worked-example",
        "The same by parallel axes, with d half the length.",
        "I_O = 1/12*m*l^2 + m*(l/2)^2 = 1/3*m*l^2", BAR,
    ),
)  # fmt: skip
