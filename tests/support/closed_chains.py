"""Mechanisms told without a tree: parts and pins. Any spanning tree of theirs, or none, makes a
model."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

import freebody as fb
from support.generate import random_inertia, random_rotation
from support.helpers import numbers, poses
from support.robots import Joint, Link, Loop, Mount, Robot, homogeneous, loaded, placed

GROUND = "ground"


@dataclass(frozen=True)
class Pin:
    """A joint between parts a and b: its frame's pose in each, of which those of b and a coincide
    at rest."""

    name: str
    kind: str
    a: str
    T_a: np.ndarray
    b: str
    T_b: np.ndarray
    axis: tuple[float, ...] = ()
    distance: float | None = None


@dataclass(frozen=True)
class Mechanism:
    """Parts (None: without mass) and the pins between them; GROUND is no part."""

    dim: int
    parts: Mapping[str, fb.Inertia | None]
    pins: tuple[Pin, ...]
    gravity: tuple[float, ...]
    driven: tuple[str, ...] = ()
    name: str = field(default="mechanism")

    def pin(self, name: str) -> Pin:
        return next(pin for pin in self.pins if pin.name == name)


def mechanism_of(model: fb.Model) -> Mechanism:
    """A model, its bodies' frames being the parts', with one link a body."""
    names = [body.name for body in model.bodies]
    keep = [*range(model.dim), 3]
    rest = poses(model, fb.neutral(model))
    T = {name: pose[np.ix_(keep, keep)] for name, pose in rest.items()}
    T[GROUND] = np.eye(model.dim + 1)
    parts: dict[str, fb.Inertia | None] = {}
    pins = []
    for k, body in enumerate(model.bodies):
        masses = model.tree.bodies[model.tree.body_of[k]].masses
        assert len(masses) <= 1
        parts[body.name] = next((_inertia(m, model.dim) for m in masses), None)
        parent = names[body.parent] if body.parent >= 0 else GROUND
        if body.joint.kind in ("planar", "free") and parent == GROUND:
            continue  # it holds nothing
        pins.append(
            Pin(
                body.joint.name,
                body.joint.kind,
                parent,
                np.linalg.inv(T[parent]) @ T[body.name],
                body.name,
                np.eye(model.dim + 1),
                body.joint.axis,
            )
        )
    for loop, lowered in zip(model.loops, model.tree.loops, strict=True):
        ends: list = []
        for name in loop.frames:
            body, R, p = model.tree.frames[name]
            ends += [
                names[model.tree.body_of.index(body)] if body >= 0 else GROUND,
                homogeneous(R, p),
            ]
        axis = loop.axis or ((1.0,) if loop.kind == "revolute" else ())
        distance = float(lowered.distance) if loop.kind == "distance" else None
        pins.append(Pin(loop.name, loop.kind, *ends, axis, distance))
    return Mechanism(
        model.dim, parts, tuple(pins), tuple(model.gravity), model.actuated, model.name
    )


def _inertia(mass, dim: int) -> fb.Inertia:
    if dim == 2:
        return fb.Inertia(
            float(mass.m), tuple(map(float, mass.c)), (float(np.ravel(mass.inertia)[0]),)
        )
    return fb.Inertia.of(
        float(mass.m), tuple(map(float, mass.c)), np.array(mass.inertia, dtype=float)
    )


def built(mechanism: Mechanism, tree: Iterable[str] | None) -> fb.Model:
    """The model whose joints are the pins named in `tree`, all others loops; None: every part is
    free.

    Frames: "part@" is the part's own, "pin.a" and "pin.b" the pin's two.
    """
    dim = mechanism.dim
    eye = np.eye(dim + 1)
    frame_of = {GROUND: eye}
    parent_of: dict[str, tuple[Pin, str]] = {}
    joints, chosen = [], set(tree or ())
    if tree is None:
        frame_of |= dict.fromkeys(mechanism.parts, eye)
        kind = "planar" if dim == 2 else "free"
        joints = [Joint(f"free_{part}", kind, GROUND, part) for part in mechanism.parts]
    left = [mechanism.pin(name) for name in chosen]
    while left:
        ready = [pin for pin in left if (pin.a in frame_of) != (pin.b in frame_of)]
        assert ready, "the pins of the tree must form one"
        pin = ready[0]
        left.remove(pin)
        a, T_a, b, T_b = pin.a, pin.T_a, pin.b, pin.T_b
        if b in frame_of:
            a, T_a, b, T_b = b, T_b, a, T_a
        frame_of[b] = T_b
        parent_of[b] = pin, a
        passive = pin.name not in mechanism.driven
        place = placed(np.linalg.inv(frame_of[a]) @ T_a)
        joints.append(Joint(pin.name, pin.kind, a, b, place, pin.axis, passive=passive))
    order = list(mechanism.parts)
    joints.sort(key=lambda joint: order.index(joint.child))
    mounts, loops = [], []
    for part in order:
        mounts.append(Mount(f"{part}@", part, placed(np.linalg.inv(frame_of[part]))))
    for pin in mechanism.pins:
        for side, part, T in (("a", pin.a, pin.T_a), ("b", pin.b, pin.T_b)):
            mounts.append(
                Mount(f"{pin.name}.{side}", part, placed(np.linalg.inv(frame_of[part]) @ T))
            )
        if pin.name not in chosen:
            axis = () if pin.kind == "revolute" and dim == 2 else pin.axis
            kind = {2: "point"}.get(dim, pin.kind) if pin.kind == "spherical" else pin.kind
            loops.append(
                Loop(pin.name, kind, (f"{pin.name}.a", f"{pin.name}.b"), axis, pin.distance)
            )
    links = [Link(GROUND)] + [
        Link(part, inertia, placed(np.linalg.inv(frame_of[part])))
        for part, inertia in mechanism.parts.items()
    ]
    described = Robot(
        mechanism.name,
        dim,
        tuple(links),
        tuple(joints),
        mechanism.gravity,
        tuple(mounts),
        tuple(loops),
    )
    return loaded(described)


# ---------------------------------------------------------------- the same state, torque and
# reaction in each
@dataclass(frozen=True)
class Moving:
    """Poses, twists (v, ω) of the parts' own frames."""

    T: dict[str, np.ndarray]
    V: dict[str, np.ndarray]


def moving(
    mechanism: Mechanism, model: fb.Model, q: np.ndarray, qd: np.ndarray, at: str = "@"
) -> Moving:
    """The state of the parts, whose frames have the name of the part and `at`."""
    every = poses(model, q)
    keep = [*range(mechanism.dim), 3]
    T = {part: every[f"{part}{at}"][np.ix_(keep, keep)] for part in mechanism.parts}
    V = {part: numbers(model, "velocity", q, qd, frame=f"{part}{at}") for part in mechanism.parts}
    n = 6 if mechanism.dim == 3 else 3
    return Moving(T | {GROUND: np.eye(mechanism.dim + 1)}, V | {GROUND: np.zeros(n)})


def coordinates(
    mechanism: Mechanism, model: fb.Model, state: Moving
) -> tuple[np.ndarray, np.ndarray]:
    """q, q̇ of a model of the mechanism in that state."""
    q, qd = [], []
    dim = mechanism.dim
    for body in model.bodies:
        if body.joint.kind in ("planar", "free"):
            T, V = state.T[body.name], state.V[body.name]
            if dim == 2:
                q += [*T[:2, 2], np.arctan2(T[1, 0], T[0, 0])]
                qd += [*V]
            else:
                R = T[:3, :3]
                q += [*T[:3, 3], *fb.quat_wxyz(R)]
                qd += [*(R.T @ V[:3]), *(R.T @ V[3:])]
            continue
        pin = mechanism.pin(body.joint.name)
        (G_p, v_p, w_p), (G_c, v_c, w_c) = (_at(mechanism, state, pin, side) for side in ("a", "b"))
        if body.name == pin.a:
            (G_p, v_p, w_p), (G_c, v_c, w_c) = (G_c, v_c, w_c), (G_p, v_p, w_p)
        G = np.linalg.inv(G_p) @ G_c
        R, R_p = G[:dim, :dim], G_p[:dim, :dim]
        axis = np.array(pin.axis)
        if pin.kind == "prismatic":
            q.append(axis @ G[:dim, dim])
            # the point of the parent under the child's origin
            arm = G_c[:dim, dim] - G_p[:dim, dim]
            qd.append(axis @ R_p.T @ (v_c - v_p - turned(w_p, arm)))
        elif pin.kind == "spherical":
            q += [*fb.quat_wxyz(R)]
            qd += [*(G_c[:3, :3].T @ (w_c - w_p))]
        elif dim == 2:
            q.append(axis[0] * np.arctan2(R[1, 0], R[0, 0]))
            qd.append(axis[0] * (w_c - w_p)[0])
        else:
            vee = np.array([R[2, 1] - R[1, 2], R[0, 2] - R[2, 0], R[1, 0] - R[0, 1]]) / 2
            q.append(np.arctan2(axis @ vee, (np.trace(R) - 1) / 2))
            qd.append(axis @ R_p.T @ (w_c - w_p))
    return np.array(q), np.array(qd)


def turned(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """ω × r, in the plane too."""
    return w[0] * np.array([-r[1], r[0]]) if len(r) == 2 else np.cross(w, r)


def moment(r: np.ndarray, f: np.ndarray) -> np.ndarray:
    """r × f, in the plane too."""
    return np.array([r[0] * f[1] - r[1] * f[0]]) if len(r) == 2 else np.cross(r, f)


def _at(mechanism: Mechanism, state: Moving, pin: Pin, side: str):
    part, T = (pin.a, pin.T_a) if side == "a" else (pin.b, pin.T_b)
    dim = mechanism.dim
    G, V = state.T[part] @ T, state.V[part]
    arm = G[:dim, dim] - state.T[part][:dim, dim]
    return G, V[:dim] + turned(V[dim:], arm), V[dim:]


def drives(
    mechanism: Mechanism, model: fb.Model, state: Moving, torques: Mapping[str, float]
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """(tau, wrenches) with which the pins' torques (b against a) act in a model; on cut pins they
    are wrenches."""
    tau, wrenches = np.zeros(model.nv), {}
    for name, value in torques.items():
        pin = mechanism.pin(name)
        if name in model.joint_names:
            k = model.joint_names.index(name)
            sign = 1.0 if model.bodies[k].name == pin.b else -1.0
            (v,) = model.coordinates[k].v
            tau[v] = sign * value
        else:
            w = value * pin_wrench(mechanism, state, pin)
            wrenches |= {f"{name}.a": -w, f"{name}.b": w}
    return tau, wrenches


def pin_wrench(mechanism: Mechanism, state: Moving, pin: Pin) -> np.ndarray:
    """What a unit torque or force of the pin does to b."""
    dim = mechanism.dim
    R = (state.T[pin.a] @ pin.T_a)[:dim, :dim]
    none = np.zeros(dim if pin.kind == "revolute" else 3 if dim == 3 else 1)
    if pin.kind == "prismatic":
        return np.concatenate([R @ pin.axis, none])
    return np.concatenate([none, [pin.axis[0]] if dim == 2 else R @ pin.axis])


def pin_reactions(
    mechanism: Mechanism,
    model: fb.Model,
    state: Moving,
    found: fb.loops.reactions.Reactions,
    torques: Mapping[str, float],
) -> dict[str, np.ndarray]:
    """Of each pin all that a does to b, at the origin of the pin's frame on b, motors included."""
    dim, result = mechanism.dim, {}
    for pin in mechanism.pins:
        w = found[pin.name].copy()
        if pin.name in model.joint_names:
            if model.bodies[model.joint_names.index(pin.name)].name == pin.a:
                p_a = (state.T[pin.a] @ pin.T_a)[:dim, dim]
                p_b = (state.T[pin.b] @ pin.T_b)[:dim, dim]
                w[dim:] += moment(p_a - p_b, w[:dim])
                w = -w
        elif pin.name in torques:
            w += torques[pin.name] * pin_wrench(mechanism, state, pin)
        result[pin.name] = w
    return result


# ---------------------------------------------------------------- generated ones
FREEDOMS = {"revolute": 1, "prismatic": 1, "spherical": 3}


def ring(seed: int) -> Mechanism:
    """A closed chain in space of revolute, prismatic and spherical pins, assembled at rest, with 1
    to 4 freedoms."""
    rng = np.random.default_rng([seed, 77])
    kinds = [str(rng.choice(["revolute", "prismatic"], p=[0.75, 0.25])) for _ in range(4)] + [
        "spherical"
    ]
    while sum(FREEDOMS[kind] for kind in kinds) < 7 + seed % 3:
        kinds.append(str(rng.choice(["revolute", "spherical"], p=[0.8, 0.2])))
    order = rng.permutation(len(kinds))
    kinds = [kinds[k] for k in order]
    names = [f"part{k + 1}" for k in range(len(kinds) - 1)]
    pose = {
        name: homogeneous(random_rotation(rng), rng.normal(scale=0.6, size=3)) for name in names
    }
    pose[GROUND] = np.eye(4)
    pins = []
    for k, (kind, a, b) in enumerate(zip(kinds, [GROUND, *names], [*names, GROUND], strict=True)):
        at = homogeneous(random_rotation(rng), rng.normal(scale=0.6, size=3))
        axis = () if kind == "spherical" else tuple(_unit(rng.normal(size=3)))
        pins.append(
            Pin(
                f"pin{k + 1}",
                kind,
                a,
                np.linalg.inv(pose[a]) @ at,
                b,
                np.linalg.inv(pose[b]) @ at,
                axis,
            )
        )
    parts = {name: random_inertia(rng) for name in names}
    driven = tuple(pin.name for pin in pins if FREEDOMS[pin.kind] == 1)[: 1 + seed % 3]
    return Mechanism(
        3, parts, tuple(pins), tuple(rng.normal(scale=5.0, size=3)), driven, f"ring{seed}"
    )


def _unit(x: np.ndarray) -> np.ndarray:
    return x / np.linalg.norm(x)
