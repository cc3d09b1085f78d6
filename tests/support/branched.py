"""Three robots with every joint kind, and differences along their tangent spaces."""

from __future__ import annotations

import numpy as np

import freebody as fb
from support.robots import Joint, Link, Mimic, Robot, loaded, rotate, shift


def branched(base: str) -> fb.Model:
    """A tree with every joint kind that has a body of its own, friction, a spring, a rotor and a
    follower."""
    rng = np.random.default_rng(7)

    def lump() -> fb.Inertia:
        a = rng.normal(size=(3, 3))
        sigma = a @ a.T * 0.05
        return fb.Inertia.of(
            float(rng.uniform(0.5, 2)),
            rng.normal(size=3) * 0.2,
            np.trace(sigma) * np.eye(3) - sigma,
        )

    def place():
        turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
        return shift(*rng.normal(size=3) * 0.5).then(rotate(turn * np.sign(np.linalg.det(turn))))

    drive = fb.Drive(viscous=0.3, rotor=1e-3, gear=20.0, stiffness=4.0, rest=0.2)
    joints = (
        Joint("a", "revolute", "base", "A", place(), (0.0, 0.0, 1.0), drive=drive),
        Joint("b", "spherical", "A", "B", place()),
        Joint("c", "prismatic", "A", "C", place(), (0.6, 0.0, 0.8), drive=drive),
        Joint("d", "planar", "B", "D", place()),
        Joint("e", "revolute", "D", "E", place(), (1.0, 2.0, -1.0), mimic=Mimic("c", -1.5, 0.3)),
    )
    links = tuple(Link(name, lump()) for name in ("base", "A", "B", "C", "D", "E"))
    return loaded(Robot("branched", 3, links, joints, (9.81, (0.0, 0.0, -1.0))), base=base)


MODELS = {
    "planar": lambda: fb.planar(
        "RPRR", l=[1, 0.2, 0.5, 0.3], lc=[0.5, 0.3, 0.2, 0.1], m=[1, 2, 3, 1], I=[1, 2, 3, 4]
    ),
    "fixed": lambda: branched("fixed"),
    "free": lambda: branched("free"),
}


def difference_along(model, function, q, *rest, h=1e-3):
    """d function / d tangent of q by an eighth-order central difference, (..., n, nv)."""
    weights = {1: 4 / 5, 2: -1 / 5, 3: 4 / 105, 4: -1 / 280}
    columns = []
    for k in range(model.nv):
        step = np.eye(model.nv)[k] * h
        columns.append(
            sum(
                w
                * (
                    function(fb.integrate(model, q, s * step), *rest)
                    - function(fb.integrate(model, q, -s * step), *rest)
                )
                for s, w in weights.items()
            )
            / h
        )
    return np.stack(columns, axis=-1)
