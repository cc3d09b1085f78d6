"""Random mechanisms with every kind of joint, reproducible from a seed, as descriptions and as
models."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cache

import numpy as np

import freebody as fb
from support.robots import (
    KINDS,
    Joint,
    Link,
    Mimic,
    Mount,
    Payload,
    Placement,
    Robot,
    loaded,
    rotate,
    shift,
    turn,
)

MOVING = {name: kind for name, kind in KINDS.items() if kind.nv}
SPATIAL = tuple(name for name, kind in MOVING.items() if 3 in kind.dimensions)
PLANAR = tuple(name for name, kind in MOVING.items() if 2 in kind.dimensions)
ONE_AXIS = tuple(name for name, kind in MOVING.items() if kind.nv == 1)
_WEIGHTS = dict.fromkeys(MOVING, 1.2) | {"revolute": 6.0, "continuous": 3.0, "prismatic": 4.0}


made: dict[tuple[int, int], fb.Model] = {}
"""The trees that were asked for before, by seed and dimension: many laws read each."""


def model(seed: int, dim: int = 3) -> fb.Model:
    """The random tree of a seed; one in five on a free base. Some of its masses may be zero, its M
    never singular."""
    if (seed, dim) not in made:
        made[seed, dim] = loaded(tree(seed, dim), base=base(seed))
    return made[seed, dim]


def base(seed: int) -> str:
    """Whether the tree of this seed stands on a fixed or on a free base."""
    return "free" if seed % 5 == 4 else "fixed"


@cache
def tree(seed: int, dim: int = 3) -> Robot:
    """Links and joints of a random tree with 1 to 12 movable joints, made once: laws ask it for
    kinds of joints before there is a model."""
    return _Tree(seed, dim).description()


def random_rotation(rng: np.random.Generator) -> np.ndarray:
    """A uniformly distributed rotation matrix."""
    Q, R = np.linalg.qr(rng.normal(size=(3, 3)))
    Q = Q * np.sign(np.diag(R))
    return Q * np.sign(np.linalg.det(Q))


def random_inertia(rng: np.random.Generator, dim: int = 3) -> fb.Inertia:
    """A physical one: the matrix of second moments about the com is a random positive definite
    one."""
    mass = float(rng.uniform(0.2, 3.0))
    com = tuple(rng.normal(scale=0.15, size=dim))
    if dim == 2:
        return fb.Inertia(mass, com, (float(mass * rng.uniform(0.002, 0.05)),))
    A = rng.normal(scale=0.1, size=(3, 3))
    second = mass * (A @ A.T + 1e-3 * np.eye(3))
    return fb.Inertia.of(mass, com, np.trace(second) * np.eye(3) - second)


def random_placement(rng: np.random.Generator, dim: int = 3, general: bool = False) -> Placement:
    """Any pose, an exact right-angled one, or none at all; `general` excludes the special ones."""
    style = (
        "any"
        if general
        else rng.choice(["any", "right", "shift", "none"], p=[0.4, 0.35, 0.15, 0.1])
    )
    if style == "none":
        return Placement()
    by = shift(*(float(x) for x in rng.normal(scale=0.4, size=dim)))
    if style == "shift":
        return by
    if style == "right":
        axis = "z" if dim == 2 else str(rng.choice(list("xyz")))
        return by.then(turn(axis, int(rng.integers(-2, 4)) * math.pi / 2))
    if dim == 2:
        return by.then(turn("z", float(rng.uniform(-3, 3))))
    if rng.random() < 0.5:
        return by.then(rotate(random_rotation(rng)))
    return by.then(turn("x", float(rng.uniform(-3, 3)))).then(turn("y", float(rng.uniform(-3, 3))))


def odd_chain(n: int, seed: int, varied: bool = False) -> Robot:
    """A chain of n joints without zeros and right angles: axes in any direction, offsets of cm.

    varied: its last third is a branch, and it has sliding joints, springs, rotors, a ball and a
    joint that follows another.
    """
    rng = np.random.default_rng([n, seed])
    links, joints = [Link("link0", random_inertia(rng))], []
    for i in range(n):
        kind = {3: "prismatic", 5: "spherical"}.get(i % 9, "revolute") if varied else "revolute"
        axis = rng.normal(size=3)
        drive, mimic = fb.Drive(), None
        if varied and i % 4 == 0 and kind != "spherical":
            drive = fb.Drive(viscous=0.1, rotor=1e-3, gear=5.0, stiffness=2.0, rest=0.3)
        if varied and i == n - 2:
            kind, mimic = "revolute", Mimic("joint0", -0.7, 0.2)
        joints.append(
            Joint(
                f"joint{i}",
                kind,
                f"link{n // 2 if varied and i == 2 * n // 3 else i}",
                f"link{i + 1}",
                shift(*rng.normal(scale=0.07, size=3)).then(rotate(random_rotation(rng))),
                () if kind == "spherical" else tuple(axis / np.linalg.norm(axis)),
                drive=drive,
                mimic=mimic,
            )
        )
        links.append(Link(f"link{i + 1}", random_inertia(rng)))
    gravity = (1.0, -2.0, -9.0)
    tool = Mount("tool", f"link{n}", random_placement(rng, general=True))
    return Robot(f"odd{n}", 3, tuple(links), tuple(joints), gravity, (tool,), tip="tool")


class _Tree:
    """The making of one tree."""

    def __init__(self, seed: int, dim: int):
        self.seed, self.dim = seed, dim
        self.rng = np.random.default_rng([seed, dim])
        self.links = [Link("base")]
        self.joints: list[Joint] = []
        self.massless: set[str] = set()

    def description(self) -> Robot:
        rng = self.rng
        heavy_base = base(self.seed) == "free" or rng.random() < 0.5
        self.links[0] = Link("base", random_inertia(rng, self.dim) if heavy_base else None)
        self.fixed_links("base")
        n = 1 + self.seed % 12
        ends = ["base"]
        for i in range(n):
            parent = (
                ends[-1]
                if rng.random() < 0.6 or ends[-1] in self.massless
                else str(rng.choice(ends))
            )
            self.movable(i, parent, last=i == n - 1)
            ends.append(f"link{i + 1}")
            self.fixed_links(f"link{i + 1}")
        joints, links = list(self.joints), list(self.links)
        if self.seed % 3 == 0:  # the order in a file is free
            rng.shuffle(joints)
            rng.shuffle(links)
        direction = rng.normal(size=self.dim)
        gravity = tuple(float(x) for x in 9.81 * direction / np.linalg.norm(direction))
        mounts = (
            Mount("tool", f"link{n}", random_placement(rng, self.dim)),
            Mount("ground", "base", shift(*(0.5,) * self.dim)),
        )
        payloads = (
            (Payload("parcel", "tool", random_inertia(rng, self.dim)),)
            if rng.random() < 0.3
            else ()
        )
        return Robot(
            f"tree{self.seed}",
            self.dim,
            tuple(links),
            tuple(joints),
            gravity,
            mounts,
            payloads=payloads,
            tip="tool",
        )

    def movable(self, i: int, parent: str, last: bool) -> None:
        rng, name = self.rng, f"link{i + 1}"
        after_massless = parent in self.massless
        kind = self.kind(after_massless)
        one_axis = kind in ONE_AXIS
        # one joint may carry nothing but the next one; its axis and placements are then general, so
        # that M is regular
        massless = one_axis and not last and rng.random() < 0.1 and not after_massless
        general = massless or after_massless
        if massless:
            self.massless.add(name)
        leaders = [joint.name for joint in self.joints if joint.kind in ONE_AXIS]
        mimic = None
        if one_axis and leaders and not general and rng.random() < 0.25:
            following = [joint.name for joint in self.joints if joint.mimic]
            leader = rng.choice(following if following and rng.random() < 0.4 else leaders)
            mimic = Mimic(str(leader), float(rng.uniform(-2, 2)), float(rng.normal(scale=0.3)))
        axis: tuple[float, ...] = ()
        if KINDS[kind].axis:
            axis = self.axis(kind, general)
        limits = (
            fb.Limits(-1.5, 2.0, 3.0, 50.0)
            if one_axis and MOVING[kind].ranged and rng.random() < 0.5
            else fb.Limits()
        )
        numbers = tuple(float(rng.normal(scale=0.2)) for _ in MOVING[kind].numbers)
        self.joints.append(
            Joint(
                f"joint{i + 1}",
                kind,
                parent,
                name,
                random_placement(rng, self.dim, general),
                axis,
                limits,
                self.drive() if one_axis else fb.Drive(),
                mimic,
                numbers=numbers,
            )
        )
        inertia = None if massless else random_inertia(rng, self.dim)
        placed = random_placement(rng, self.dim) if rng.random() < 0.5 else Placement()
        self.links.append(Link(name, inertia, placed))

    def kind(self, after_massless: bool) -> str:
        kinds = SPATIAL if self.dim == 3 else PLANAR
        if after_massless:  # a body that is free already has no use for one more joint
            kinds = tuple(name for name in kinds if name in ONE_AXIS)
        weights = np.array([_WEIGHTS[k] for k in kinds])
        return str(self.rng.choice(kinds, p=weights / weights.sum()))

    def axis(self, kind: str, general: bool) -> tuple[float, ...]:
        rng = self.rng
        if self.dim == 2 and kind != "prismatic":
            return (float(rng.choice([-1.0, 1.0])),)
        if not general and rng.random() < 0.5:
            along = np.zeros(self.dim)
            along[rng.integers(self.dim)] = rng.choice([-1.0, 1.0, 2.5])
            return tuple(float(x) for x in along)
        return tuple(float(x) for x in rng.normal(size=self.dim))

    def drive(self) -> fb.Drive:
        rng = self.rng
        viscous, coulomb, rotor, stiffness = (
            float(x) for x in rng.uniform(size=4) * (rng.random(4) < 0.4)
        )
        return fb.Drive(
            viscous,
            coulomb,
            1e-3 * rotor,
            float(rng.choice([1.0, -20.0, 50.0])),
            5 * stiffness,
            float(rng.normal(scale=0.5)),
        )

    def fixed_links(self, on: str) -> None:
        """Up to three links fixed to one another or side by side; on a massless link none with a
        mass."""
        fixed = [on]
        for k in range(int(self.rng.choice([0, 1, 2, 3], p=[0.5, 0.25, 0.15, 0.1]))):
            parent = str(self.rng.choice(fixed))
            name = f"{on}_part{k + 1}"
            inertia = None if on in self.massless else random_inertia(self.rng, self.dim)
            self.links.append(Link(name, inertia, random_placement(self.rng, self.dim)))
            placement = random_placement(self.rng, self.dim)
            self.joints.append(Joint(f"{name}_weld", "fixed", parent, name, placement))
            fixed.append(name)


# ---------------------------------------------------------------- the same robot told otherwise
def renamed(description: Robot) -> Robot:
    """Other names for all links and joints."""

    def new(name: str) -> str:
        return f"x_{name[::-1]}"

    return replace(
        description,
        links=tuple(replace(link, name=new(link.name)) for link in description.links),
        joints=tuple(
            replace(
                joint,
                name=new(joint.name),
                parent=new(joint.parent),
                child=new(joint.child),
                mimic=joint.mimic and replace(joint.mimic, joint=new(joint.mimic.joint)),
            )
            for joint in description.joints
        ),
        mounts=tuple(replace(mount, link=new(mount.link)) for mount in description.mounts),
    )


def reordered_links(description: Robot, seed: int) -> Robot:
    """Links in another order; the joints keep theirs."""
    order = np.random.default_rng(seed).permutation(len(description.links))
    return replace(description, links=tuple(description.links[i] for i in order))


def split(description: Robot, seed: int) -> Robot:
    """Every link with a mass in two pieces, the second fixed to the first at some odd place."""
    rng = np.random.default_rng(seed)
    dim = description.dim
    links, joints = [], []
    for link in description.links:
        if link.inertia is None:
            links.append(link)
            continue
        part = float(rng.uniform(0.2, 0.8))
        links.append(replace(link, inertia=_scaled(link.inertia, part)))
        weld = random_placement(rng, dim, general=True)
        piece = f"{link.name}_piece"
        links.append(
            Link(piece, _scaled(link.inertia, 1 - part), weld.inverse(dim).then(link.placement))
        )
        joints.append(Joint(f"{piece}_weld", "fixed", link.name, piece, weld))
    return replace(description, links=tuple(links), joints=(*description.joints, *joints))


def moved_frames(description: Robot, seed: int) -> tuple[Robot, dict[str, np.ndarray]]:
    """Link frames moved where the meaning of q allows it, with the pose of the new frame in the old
    for each link.

    Behind a prismatic joint anywhere, behind one that turns about an axis along and about that and
    turned at will, along z behind a planar one, anywhere on a fixed link. A description in space,
    with no mimics lost.
    """
    rng = np.random.default_rng(seed)
    moves: dict[str, Placement] = {link.name: Placement() for link in description.links}
    for joint in description.joints:
        along = np.zeros(3)
        if joint.kind in ("revolute", "continuous", "helical", "cylindrical"):
            along = np.array(joint.axis) / np.linalg.norm(joint.axis) * rng.normal()
        elif joint.kind in ("prismatic", "fixed"):
            along = rng.normal(size=3)
        elif joint.kind == "planar":
            moves[joint.child] = shift(0.0, 0.0, float(rng.normal()))
            continue
        else:
            continue
        moves[joint.child] = shift(*(float(x) for x in along)).then(rotate(random_rotation(rng)))
    joints = []
    for joint in description.joints:
        placement = moves[joint.parent].inverse().then(joint.placement).then(moves[joint.child])
        axis = (
            tuple(moves[joint.child].matrix()[:3, :3].T @ np.array(joint.axis))
            if joint.axis
            else ()
        )
        joints.append(replace(joint, placement=placement, axis=axis))
    links = tuple(
        replace(l, placement=moves[l.name].inverse().then(l.placement)) for l in description.links
    )
    mounts = tuple(
        replace(m, placement=moves[m.link].inverse().then(m.placement)) for m in description.mounts
    )
    return (
        replace(description, links=links, joints=tuple(joints), mounts=mounts),
        {name: move.matrix() for name, move in moves.items()},
    )


def _scaled(inertia: fb.Inertia, part: float) -> fb.Inertia:
    return fb.Inertia(part * inertia.mass, inertia.com, tuple(part * x for x in inertia.tensor))
