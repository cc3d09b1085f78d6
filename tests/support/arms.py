"""Arms from their joint axes, in frames that nobody would choose: what inverse kinematics must not
depend on."""

from __future__ import annotations

import numpy as np

import freebody as fb
from support.generate import random_rotation
from support.robots import Joint, Link, Mount, Robot, homogeneous, loaded, placed

Axes = list[tuple[str, np.ndarray, np.ndarray]]
"""(R or P, direction, point) of each joint, in the axes and at the origin of a base."""


def arm(axes: Axes, seed: int) -> fb.Model:
    """The arm with these axes at zero, on a random base, with random link frames and a random
    tool."""
    rng = np.random.default_rng(seed)
    base = homogeneous(random_rotation(rng), rng.normal(size=3))
    before = np.eye(4)
    links, joints = [Link("base")], []
    for i, (kind, w, p) in enumerate(axes, 1):
        w = np.asarray(w, dtype=float) / np.linalg.norm(w)
        R = random_rotation(rng)
        along = rng.normal() * w if kind == "R" else rng.normal(size=3)  # anywhere on the axis
        here = base @ homogeneous(R, np.asarray(p, dtype=float) + along)
        joints.append(
            Joint(
                f"joint{i}",
                "revolute" if kind == "R" else "prismatic",
                links[-1].name,
                f"link{i}",
                placed(np.linalg.inv(before) @ here),
                tuple(R.T @ w),
            )
        )
        links.append(Link(f"link{i}", fb.Inertia.point(1.0, (0.0, 0.0, 0.0))))
        before = here
    tool = Mount(
        "tool", links[-1].name, placed(homogeneous(random_rotation(rng), rng.normal(size=3)))
    )
    return loaded(
        Robot(
            f"arm{seed}",
            3,
            tuple(links),
            tuple(joints),
            (9.81, (0.0, 0.0, -1.0)),
            (tool,),
            tip="tool",
        )
    )


def direction(rng: np.random.Generator) -> np.ndarray:
    """A random unit vector."""
    v = rng.normal(size=3)
    return v / np.linalg.norm(v)


def skew(word: str, rng: np.random.Generator) -> Axes:
    """Joints with axes anywhere."""
    return [(kind, direction(rng), rng.normal(size=3)) for kind in word]


def meeting(n: int, rng: np.random.Generator) -> Axes:
    """Turning joints whose axes go through one point."""
    c = rng.normal(size=3)
    return [("R", direction(rng), c) for _ in range(n)]


def parallel(n: int, rng: np.random.Generator) -> Axes:
    """Turning joints with parallel axes, some the other way."""
    w = direction(rng)
    return [("R", rng.choice([-1.0, 1.0]) * w, rng.normal(size=3)) for _ in range(n)]


def apart(model: fb.Model, a: np.ndarray, b: np.ndarray) -> float:
    """The largest joint way between two positions, whole turns left out."""
    turning = np.array([body.kind.name == "revolute" for body in model.bodies])
    way = np.abs(a - b)
    return float(np.where(turning, np.abs((a - b + np.pi) % (2 * np.pi) - np.pi), way).max())


def holds(model: fb.Model, solutions: np.ndarray, q: np.ndarray, tolerance: float = 1e-6) -> bool:
    """Whether q is among the solutions (k, n)."""
    return any(apart(model, row, q) < tolerance for row in solutions)


def industrial(rng):
    """Axes 2 and 3 parallel and across axis 1, which they miss: an arm with a shoulder's offset and
    a wrist."""
    w, n = np.array([0.0, 0.0, 1.0]), direction(rng) * [1, 1, 0]
    second = [("R", s * n, rng.normal(size=3)) for s in (1, -1)]
    return [("R", w, np.zeros(3)), *second, *meeting(3, rng)]


def scara(rng):
    w = direction(rng)
    turns = [("R", s * w, rng.normal(size=3)) for s in (1, -1, 1)]
    turns.insert(int(rng.integers(4)), ("P", -w, np.zeros(3)))
    return turns


POSES = {
    "an industrial arm": (industrial, 8),
    "an industrial arm, backwards": (lambda rng: industrial(rng)[::-1], 8),
    "a shoulder and an elbow": (
        lambda rng: meeting(2, rng) + skew("R", rng) + meeting(3, rng),
        8,
    ),
    "a shoulder and a slide": (lambda rng: meeting(2, rng) + skew("P", rng) + meeting(3, rng), 8),
    "parallel axes and a wrist": (
        lambda rng: parallel(2, rng) + skew("R", rng) + meeting(3, rng),
        8,
    ),
    "slides and a wrist": (lambda rng: skew("PPP", rng) + meeting(3, rng), 2),
    "like a UR": (lambda rng: skew("R", rng) + parallel(3, rng) + meeting(2, rng), 8),
    "like a UR, backwards": (
        lambda rng: (skew("R", rng) + parallel(3, rng) + meeting(2, rng))[::-1],
        8,
    ),
    "three skew joints and a wrist": (lambda rng: skew("RRR", rng) + meeting(3, rng), 8),
    "a wrist and a skew slide": (lambda rng: meeting(3, rng) + skew("PRR", rng), 8),
    "a SCARA": (scara, 2),
    "seven, the last held": (
        lambda rng: meeting(3, rng) + skew("R", rng) + meeting(2, rng) + skew("R", rng),
        8,
    ),
    "seven, the first held": (
        lambda rng: (meeting(3, rng) + skew("R", rng) + meeting(2, rng) + skew("R", rng))[::-1],
        8,
    ),
}


def checked(model, target, **more):
    """The solutions, each of which forward kinematics brings to the target."""
    found = fb.inverse_kinematics(model, target, **more)
    T = fb.forward_kinematics(model, found.q)
    d = model.dim
    target = np.asarray(target)
    if target.shape[-1] == d:
        assert np.abs(T[..., :d, d] - target).max(initial=0) < 1e-10
    elif more.get("task") in (None, "pose"):
        assert np.abs(T - target).max(initial=0) < 1e-10
    assert found.residual.max(initial=0) < 1e-10
    return found


def puma_like(rng):
    first, second = meeting(2, rng)
    w = np.cross(first[1], direction(rng))
    return [first, ("R", w, second[2]), ("R", -w, rng.normal(size=3)), *meeting(3, rng)]
