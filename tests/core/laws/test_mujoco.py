"""Random trees and two robots beside MuJoCo: mass matrix, bias, inverse dynamics, poses."""

from __future__ import annotations

import re
import sys
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np
import pytest

import freebody as fb
from freebody import Model
from support import generate
from support.extras import extra
from support.helpers import close, numbers, poses
from support.real_files import FILES, ROBOTS
from support.robots import Joint, Link, Placement, Robot, loaded

mujoco = extra("mujoco", "MuJoCo")

EPS = 1e-9  # MuJoCo turns each inertia to its principal axes and back


class Theirs:
    """MuJoCo's model and our order of its degrees of freedom."""

    def __init__(self, text: str, ours: Model):
        self.ours = ours
        self.model = mujoco.MjModel.from_xml_string(text)
        self.model.dof_damping[:] = 0
        self.model.dof_frictionloss[:] = 0
        self.model.opt.gravity[:] = ours.gravity
        self.model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
        self.data = mujoco.MjData(self.model)
        self.q, self.v = [], []
        self.screws = []  # (place of their slide in q and q̇, of ours in q and q̇, pitch)
        for body, at in zip(ours.bodies, ours.coordinates, strict=True):
            several = {"planar": "xyz", "universal": "xy", "cylindrical": ["", "slide"]}
            for part in several.get(body.joint.kind, [""]):
                j = self.joint(part_of(body.joint, part))
                nq, nv = {"free": (7, 6), "spherical": (4, 3)}.get(body.joint.kind, (1, 1))
                self.q += range(self.model.jnt_qposadr[j], self.model.jnt_qposadr[j] + nq)
                self.v += range(self.model.jnt_dofadr[j], self.model.jnt_dofadr[j] + nv)
            if body.joint.kind == "helical":
                j = self.joint(part_of(body.joint, "slide"))
                place = (int(self.model.jnt_qposadr[j]), int(self.model.jnt_dofadr[j]))
                self.screws.append((*place, at.q[0], at.v[0], body.joint.numbers[0]))
        kinds = {body.joint.kind for body in ours.bodies}
        unknown = f"`several` above or `attach` below lack one of {kinds}"
        assert (len(self.q), len(self.v)) == (ours.nq, ours.nv), unknown
        more = len(self.screws)
        assert (self.model.nq, self.model.nv) == (ours.nq + more, ours.nv + more)

    def joint(self, name: str) -> int:
        """Their number of a joint."""
        number = mujoco.mj_name2id(self.model, mujoco.mjtObj.mjOBJ_JOINT, name)
        assert number >= 0
        return number

    def rates(self, q: np.ndarray) -> np.ndarray:
        """G with their rates = G q̇: the velocity of a free body is in world axes there, its ω in
        the body's as here."""
        G = np.eye(self.model.nv)[self.v].T
        standing = poses(self.ours, q)
        for body, at in zip(self.ours.bodies, self.ours.coordinates, strict=True):
            if body.joint.kind == "free":
                k = list(at.v[:3])
                G[np.ix_([self.v[i] for i in k], k)] = standing[body.name][:3, :3]
        for _, slide, _, k, pitch in self.screws:
            G[slide, k] = pitch
        return G

    def check(self, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> None:
        """One state."""
        G, model, data = self.rates(q), self.model, self.data
        turning = np.zeros(model.nv)  # d/dt (R v) = R (v̇ + ω × v)
        for body, at in zip(self.ours.bodies, self.ours.coordinates, strict=True):
            if body.joint.kind == "free":
                k = list(at.v)
                turning[[self.v[i] for i in k[:3]]] = poses(self.ours, q)[body.name][
                    :3, :3
                ] @ np.cross(qd[k[3:]], qd[k[:3]])
        data.qpos[self.q] = q
        for slide, _, k, _, pitch in self.screws:
            data.qpos[slide] = pitch * q[k]
        data.qvel[:] = G @ qd
        data.qacc[:] = G @ qdd + turning
        mujoco.mj_forward(model, data)
        M = np.zeros((model.nv, model.nv))
        for row, unit in zip(M, np.eye(model.nv), strict=True):
            mujoco.mj_mulM(model, data, row, unit)
        ours = numbers(self.ours, "mass_matrix", q)
        close(ours, G.T @ M @ G, EPS, what="mass matrix")
        standing = poses(self.ours, q)
        for i in range(1, model.nbody):
            name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i)
            close(standing[name][:3, :3], data.xmat[i].reshape(3, 3), EPS, what=name)
            close(standing[name][:3, 3], data.xpos[i], EPS, 1.0, name)
        data.qacc[:] = G @ qdd + turning
        mujoco.mj_inverse(model, data)
        tau = numbers(self.ours, "inverse_dynamics", q, qd, qdd)
        close(tau, G.T @ data.qfrc_inverse, EPS, what="inverse dynamics")


# ---------------------------------------------------------------- random trees
def text(values) -> str:
    return " ".join(repr(float(x)) for x in np.asarray(values).ravel())


def pose(tag: Element, T: np.ndarray) -> None:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, T[:3, :3].ravel())
    tag.set("pos", text(T[:3, 3]))
    tag.set("quat", text(quaternion))


def mjcf(description: Robot) -> str:
    """A description without massless links as MJCF: fixed links are bodies without a joint."""
    root = Element("mujoco")
    SubElement(root, "compiler", angle="radian", autolimits="false")
    above = {joint.child: joint for joint in description.joints}
    (base,) = (link for link in description.links if link.name not in above)
    links = {link.name: link for link in description.links}
    attach(SubElement(root, "worldbody"), base, None, description, links)
    return tostring(root, encoding="unicode")


def part_of(joint: Joint, part: str) -> str:
    """The name of one of several of their joints that are one of ours."""
    return f"{joint.name}_{part}" if part else joint.name


def attach(
    parent: Element,
    link: Link,
    joint: Joint | None,
    description: Robot,
    links: dict[str, Link],
) -> None:
    body = SubElement(parent, "body", name=link.name)
    pose(body, (joint.placement if joint else Placement()).matrix())
    if joint and joint.kind != "fixed":
        drive = joint.drive
        extra = {
            "armature": text(drive.rotor * drive.gear**2),
            "stiffness": text(drive.stiffness),
            "springref": text(drive.rest),
        }
        parts = {
            "planar": (("x", "slide", "1 0 0"), ("y", "slide", "0 1 0"), ("z", "hinge", "0 0 1")),
            "universal": (("x", "hinge", "1 0 0"), ("y", "hinge", "0 1 0")),
        }
        if joint.kind in parts:
            for letter, kind, axis in parts[joint.kind]:
                SubElement(body, "joint", name=part_of(joint, letter), type=kind, axis=axis)
        elif joint.kind == "spherical":
            SubElement(body, "joint", name=joint.name, type="ball")
        else:
            kind = "slide" if joint.kind == "prismatic" else "hinge"
            SubElement(body, "joint", name=joint.name, type=kind, axis=text(joint.axis), **extra)
            if joint.kind in ("cylindrical", "helical"):  # a screw's slide follows its hinge
                name = part_of(joint, "slide")
                SubElement(body, "joint", name=name, type="slide", axis=text(joint.axis))
    if link.inertia is not None:
        m, c, tensor = link.inertia.numbers()
        T = link.placement.matrix()
        turned = T[:3, :3] @ tensor @ T[:3, :3].T
        full = turned[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        SubElement(
            body,
            "inertial",
            pos=text(T[:3, :3] @ c + T[:3, 3]),
            mass=text(m),
            fullinertia=text(full),
        )
    for other in description.joints:
        if other.parent == link.name:
            attach(body, links[other.child], other, description, links)


def comparable(seed: int) -> bool:
    """MuJoCo frees only bodies of the world, and refuses joints that carry nothing."""
    description = generate.tree(seed)
    massless = {link.name for link in description.links if link.inertia is None}
    moving = {joint.child for joint in description.joints if joint.kind != "fixed"}
    return not massless & moving and all(joint.kind != "free" for joint in description.joints)


SEEDS = [seed for seed in range(120) if comparable(seed)]


def test_the_trees_hold_every_kind_but_free():
    kinds = [joint.kind for seed in SEEDS for joint in generate.tree(seed).joints]
    assert min(kinds.count(kind) for kind in generate.MOVING if kind != "free") >= 10


@pytest.mark.sample(9)
@pytest.mark.parametrize("seed", SEEDS)
def test_random_trees(seed: int):
    description = generate.tree(seed)
    bare = description.payloads == ()
    model = loaded(description, mimic="free").without("friction")
    if not bare:  # a payload is a link fixed to its frame
        model = loaded(generate.replace(description, payloads=()), mimic="free").without("friction")
    theirs = Theirs(mjcf(description), model)
    for state in zip(*fb.random_state(model, seed, 2), strict=True):
        theirs.check(*state)


@pytest.mark.parametrize("seed", SEEDS[:12])
def test_random_trees_on_a_free_base(seed: int):
    description = generate.tree(seed)
    links = tuple(
        generate.replace(link, inertia=generate.random_inertia(np.random.default_rng(seed)))
        if link.name == "base"
        else link
        for link in description.links
    )
    description = generate.replace(description, links=links, payloads=())
    model = loaded(description, mimic="free", base="free").without("friction")
    xml = mjcf(description).replace('<body name="base"', '<body name="base" ', 1)
    start = re.search(r'<body name="base"[^>]*>', xml).end()
    theirs = Theirs(f'{xml[:start]}<freejoint name="base"/>{xml[start:]}', model)
    for state in zip(*fb.random_state(model, seed, 2), strict=True):
        theirs.check(*state)


# ---------------------------------------------------------------- robots from their files
@pytest.mark.skipif(
    not FILES and sys.platform != "linux", reason="there is no wheel of example-robot-data"
)
@pytest.mark.parametrize(
    "name", ["ur_description/urdf/ur5_robot.urdf", "panda_description/urdf/panda.urdf"]
)
def test_robots(name: str):
    """MuJoCo reads the same file, its shapes taken out."""
    model = fb.load(str(ROBOTS / name), mimic="free", snap_angles=0, physical="ignore").without(
        "friction"
    )
    bare = re.sub(
        r"<(visual|collision)\b.*?</\1>", "", (ROBOTS / name).read_text(), flags=re.DOTALL
    )
    bare = re.sub(r"<mimic[^>]*/>", "", bare)
    compiler = (
        '<mujoco><compiler inertiafromgeom="false" fusestatic="true" '
        'balanceinertia="false"/></mujoco>'
    )
    theirs = Theirs(bare.replace("</robot>", f"{compiler}</robot>"), model)
    for state in zip(*fb.random_state(model, 1, 4), strict=True):
        theirs.check(*state)
