"""Random planar linkages, and machines written as text."""

from __future__ import annotations

import numpy as np

import freebody as fb
from support.helpers import poses
from support.robots import Joint, Link, Placement, Robot, loaded, rotate, shift

SPECIAL = (0.0, 1.0, -1.0, 0.5)  # lengths of exercises, with which linkages fold flat and align
KINDS = ("revolute", "prismatic", "point", "fixed", "distance")


def linkage(seed: int) -> tuple[fb.Model, np.ndarray]:
    """A random planar tree of 2 to 6 links with 1 or 2 loops, and a guess for a closed position.

    In two of three, loops are placed where they close at the guess.
    """
    rng = np.random.default_rng([seed, 2024])
    special = rng.random() < 0.3
    n = int(rng.integers(2, 7))

    def place() -> Placement:
        if special:
            return shift(float(rng.choice(SPECIAL)), float(rng.choice(SPECIAL[:1] * 3 + SPECIAL)))
        angle = float(rng.uniform(-3, 3))
        R = ((np.cos(angle), -np.sin(angle)), (np.sin(angle), np.cos(angle)))
        by = shift(*(float(x) for x in rng.normal(scale=0.5, size=2)))
        return by.then(rotate(R)) if rng.random() < 0.5 else by

    links, joints = [Link("ground")], []
    for k in range(n):
        mass = float(rng.uniform(0.3, 3.0))
        com = (float(rng.uniform(0, 0.5)), 0.0)
        inertia = fb.Inertia(mass, com, (float(rng.choice([0.0, mass * rng.uniform(0.01, 0.1)])),))
        links.append(Link(f"link{k + 1}", None if rng.random() < 0.15 else inertia))
        parent = "ground" if k == 0 or rng.random() < 0.35 else f"link{rng.integers(1, k + 1)}"
        kind = str(rng.choice(["revolute", "prismatic"], p=[0.75, 0.25]))
        axis = (
            (1.0,) if kind == "revolute" else ((1.0, 0.0) if special else tuple(rng.normal(size=2)))
        )
        drive = fb.Drive()
        if rng.random() < 0.15:
            drive = fb.Drive(
                *(float(x) for x in rng.uniform(0, 0.3, size=2)), stiffness=float(rng.uniform(0, 5))
            )
        joints.append(
            Joint(
                f"joint{k + 1}",
                kind,
                parent,
                f"link{k + 1}",
                place(),
                axis,
                drive=drive,
                passive=bool(rng.random() < 0.5),
            )
        )
    gravity = (0.0, 0.0) if rng.random() < 0.1 else (0.3, -9.81)
    model = loaded(Robot(f"linkage{seed}", 2, tuple(links), tuple(joints), gravity))
    guess = (
        np.where(rng.random(n) < 0.5, 0.0, rng.uniform(-1, 1, size=n))
        if special
        else rng.uniform(-1, 1, n)
    )
    closed = rng.random() < 0.67
    bodies = ["ground", *(f"link{k + 1}" for k in range(n))]
    for k in range(int(rng.integers(1, 3))):
        a, b = (str(x) for x in rng.choice(bodies, size=2, replace=False))
        kind = str(rng.choice(KINDS, p=[0.5, 0.15, 0.1, 0.1, 0.15]))
        at = place()
        model = model.with_frame(f"A{k}", frame=a, **_pose(at))
        if closed:
            T = poses(model, guess)
            rel = np.linalg.inv(T[b]) @ T[f"A{k}"]
            distance = float(rng.uniform(0.2, 1.0))
            if kind == "distance":
                rel[:2, 3] += rel[:2, :2] @ [distance, 0.0]
            model = model.with_frame(f"B{k}", rel[:2, 3], rel[:2, :2], frame=b)
        else:
            distance = float(rng.uniform(0.2, 1.0))
            model = model.with_frame(f"B{k}", frame=b, **_pose(place()))
        model = model.with_loop(
            f"loop{k}",
            kind,
            (f"A{k}", f"B{k}"),
            axis=(1.0, 0.5) if kind == "prismatic" else (),
            distance=distance if kind == "distance" else None,
        )
    return model, np.asarray(guess, dtype=float)


def _pose(placement: Placement) -> dict:
    T = placement.matrix(2)
    return {"position": T[:2, 2], "rotation": T[:2, :2]}


def four_bar_text(turn: str, **top) -> str:
    """A planar four-bar linkage in a vertical plane of space, its axes turned by right angles as
    files print them."""
    rpy = f"[{turn}, 0.0, 0.0]"
    bars = {"crank": 0.3, "coupler": 0.9, "rocker": 0.7}
    text = ['name = "four_bar"', "dim = 3", *(f"{key} = {value}" for key, value in top.items())]
    text += ['[[link]]\nname = "ground"']
    for name, l in bars.items():
        text.append(
            f'[[link]]\nname = "{name}"\nmass = {2 * l}\ncom = [{l / 2}, 0, 0]\n'
            f"inertia = [0, 0, 0, {l**3 / 6}, 0, {l**3 / 6}]"
        )
    for name, parent, child, at, place, axis in (
        ("j1", "ground", "crank", 0.0, "", "[0, -1, 0]"),
        ("j2", "crank", "coupler", 0.3, f"\nrpy = {rpy}", "[0, 0, 1]"),
        ("j3", "coupler", "rocker", 0.9, "", "[0, 0, 1]"),
    ):
        text.append(
            f'[[joint]]\nname = "{name}"\nkind = "revolute"\nparent = "{parent}"\n'
            f'child = "{child}"\n'
            f"origin = [{at}, 0, 0]{place}\naxis = {axis}"
            + ("\npassive = true" if name != "j1" else "")
        )
    text += [
        f'[[frame]]\nname = "pin"\nparent = "ground"\norigin = [1.0, 0, 0]\nrpy = {rpy}',
        '[[frame]]\nname = "end"\nparent = "rocker"\norigin = [0.7, 0, 0]',
        '[[loop]]\nname = "closing"\nkind = "revolute"\nframes = ["pin", "end"]\naxis = [0, 0, 1]',
        "[home]\nj1 = 1.0\nj2 = -0.6\nj3 = -1.6",
    ]
    return "\n".join(text)
