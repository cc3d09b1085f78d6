"""Robots written as URDF, SDF, MJCF and TOML, with frames, zeros, directions and names of one's own
choice: the same robot in other words."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

import freebody as fb
from support.helpers import numbers

Pose = tuple[np.ndarray, np.ndarray]
HERE: Pose = np.eye(3), np.zeros(3)


@dataclass(frozen=True)
class Written:
    """A body with its joint of one coordinate: the joint's frame in the parent's, and the mass in
    the body's frame, which is the joint's where that is at 0."""

    name: str
    joint: str
    parent: int
    kind: str
    pose: Pose
    axis: np.ndarray
    mass: float
    com: np.ndarray
    tensor: np.ndarray
    limits: dict[str, float]
    damping: float = 0.0
    friction: float = 0.0
    armature: float = 0.0


def bodies_of(model: fb.Model, count: int | None = None) -> list[Written]:
    """The bodies of a model in space, or the first of them, as public functions tell them."""
    inertial, known, rest = fb.inertial_parameters(model), fb.parameters(model), fb.neutral(model)
    own: dict[int, Pose] = {-1: HERE}
    found = []
    for k, body in enumerate(model.bodies[:count]):
        joint = body.joint
        T = numbers(model, "forward_kinematics", rest, frame=body.name)
        own[k] = T[:3, :3], T[:3, 3]
        mass, *moment = (inertial[f"{body.name}.{x}"] for x in ("m", "hx", "hy", "hz"))
        com = np.array(moment) / mass if mass else np.zeros(3)
        entries = np.array([[inertial[f"{body.name}.I{x}"] for x in row] for row in _ENTRIES])
        tensor = entries - mass * (com @ com * np.eye(3) - np.outer(com, com))
        drive = {
            x: known[name].value if (name := f"{joint.name}.{place}") in known else default
            for x, place, default in _DRIVE
        }
        limits = {key: x for key, x in vars(joint.limits).items() if np.isfinite(x)}
        found.append(
            Written(
                body.name, joint.name, body.parent, joint.kind,
                composed(inverse(own[body.parent]), own[k]),
                np.array(joint.axis, dtype=float), mass, com, tensor, limits,
                drive["viscous"], drive["coulomb"], drive["rotor"] * drive["gear"] ** 2,
            )
        )  # fmt: skip
    return found


_ENTRIES = (("xx", "xy", "xz"), ("xy", "yy", "yz"), ("xz", "yz", "zz"))
_DRIVE = (
    ("viscous", "friction.viscous", 0.0),
    ("coulomb", "friction.coulomb", 0.0),
    ("rotor", "rotor.inertia", 0.0),
    ("gear", "rotor.gear", 1.0),
)
"""Numbers of a drive, where `fb.parameters` has them, and what they are where it has not."""


def composed(outer: Pose, inner: Pose) -> Pose:
    return outer[0] @ inner[0], outer[0] @ inner[1] + outer[1]


def inverse(pose: Pose) -> Pose:
    return pose[0].T, -pose[0].T @ pose[1]


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    K = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + np.sin(angle) * K + (1.0 - np.cos(angle)) * K @ K


def disguised(bodies: Sequence[Written], rng: np.random.Generator) -> list[Written]:
    """The same robot: on another base, each link with another frame, each joint with another zero,
    direction and name."""
    own: dict[int, Pose] = {-1: (_any_rotation(rng), rng.uniform(-1.0, 1.0, 3))}
    found = []
    for k, body in enumerate(bodies):
        flip, offset = float(rng.choice([-1.0, 1.0])), float(rng.uniform(-1.0, 1.0))
        frame = _any_rotation(rng), rng.uniform(-0.3, 0.3) * body.axis
        turns = body.kind != "prismatic"
        moved = (rotation(body.axis, offset), np.zeros(3)) if turns else HERE
        moved = moved if turns else (np.eye(3), offset * body.axis)
        at = composed(composed(composed(inverse(own[body.parent]), body.pose), moved), frame)
        R, p = inverse(frame)
        limits = dict(body.limits)
        if "lower" in limits:
            ends = [flip * (limits[x] - offset) for x in ("lower", "upper")]
            limits |= {"lower": min(ends), "upper": max(ends)}
        found.append(
            replace(
                body,
                name=f"part{k}",
                joint=f"axis_{k + 1}",
                pose=at,
                axis=flip * R @ body.axis,
                com=R @ body.com + p,
                tensor=R @ body.tensor @ R.T,
                limits=limits,
            )
        )
        own[k] = frame
    return found


def _any_rotation(rng: np.random.Generator) -> np.ndarray:
    axis = rng.normal(size=3)
    return rotation(axis / np.linalg.norm(axis), rng.uniform(0.0, 3.0))


def _words(vector: Sequence[float] | np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in vector)


def _rpy(R: np.ndarray) -> tuple[float, float, float]:
    """Angles about the fixed axes x, y, z."""
    pitch = float(np.arctan2(-R[2, 0], np.hypot(R[0, 0], R[1, 0])))
    if np.hypot(R[0, 0], R[1, 0]) < 1e-12:
        return float(np.arctan2(-R[1, 2], R[1, 1])), pitch, 0.0
    return float(np.arctan2(R[2, 1], R[2, 2])), pitch, float(np.arctan2(R[1, 0], R[0, 0]))


_KEYS = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))


def urdf(bodies: Sequence[Written], split: bool = False) -> str:
    """URDF; split: half of each link is another link, fixed to it."""
    lines = ['<robot name="as_urdf"><link name="base"/>']
    names = ["base"] if not bodies else [body.name for body in bodies]
    for body in bodies:
        parent = names[body.parent] if body.parent >= 0 else "base"
        tensor = body.tensor * (0.5 if split else 1.0)
        entries = " ".join(f'{key}="{float(tensor[i, j])!r}"' for key, i, j in _KEYS)
        mass = body.mass * (0.5 if split else 1.0)
        inertia = f'<mass value="{mass!r}"/><inertia {entries}/></inertial></link>'
        lines.append(
            f'<link name="{body.name}"><inertial><origin xyz="{_words(body.com)}"/>{inertia}'
        )
        if split:
            at = np.array([0.1, -0.2, 0.05])
            lines.append(
                f'<link name="{body.name}_rest"><inertial><origin xyz="{_words(body.com - at)}"/>'
                f'{inertia}<joint name="{body.name}_weld" type="fixed"><origin xyz="{_words(at)}"/>'
                f'<parent link="{body.name}"/><child link="{body.name}_rest"/></joint>'
            )
        R, p = body.pose
        limits = " ".join(f'{key}="{x!r}"' for key, x in body.limits.items())
        kind = body.kind if "lower" in body.limits else "continuous"
        lines.append(
            f'<joint name="{body.joint}" type="{kind}"><parent link="{parent}"/>'
            f'<child link="{body.name}"/><origin xyz="{_words(p)}" rpy="{_words(_rpy(R))}"/>'
            f'<axis xyz="{_words(body.axis)}"/><limit {limits}/>'
            f'<dynamics damping="{body.damping!r}" friction="{body.friction!r}"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def urdf_of_split_links(bodies: Sequence[Written]) -> str:
    return urdf(bodies, split=True)


def sdf(bodies: Sequence[Written]) -> str:
    """SDF 1.7, each link placed in its parent."""
    lines = ['<sdf version="1.7"><model name="as_sdf"><link name="base"/>']
    lines.append(
        '<joint name="ground" type="fixed"><parent>world</parent><child>base</child></joint>'
    )
    for body in bodies:
        parent = bodies[body.parent].name if body.parent >= 0 else "base"
        R, p = body.pose
        entries = "".join(f"<{key}>{float(body.tensor[i, j])!r}</{key}>" for key, i, j in _KEYS)
        limit = "".join(f"<{key}>{x!r}</{key}>" for key, x in body.limits.items())
        lines.append(
            f'<link name="{body.name}"><pose relative_to="{parent}">{_words(p)} {_words(_rpy(R))}'
            f"</pose><inertial><pose>{_words(body.com)} 0 0 0</pose><mass>{body.mass!r}</mass>"
            f'<inertia>{entries}</inertia></inertial></link><joint name="{body.joint}" '
            f'type="{body.kind}"><parent>{parent}</parent><child>{body.name}</child><axis>'
            f"<xyz>{_words(body.axis)}</xyz><limit>{limit}</limit><dynamics><damping>"
            f"{body.damping!r}</damping><friction>{body.friction!r}</friction></dynamics></axis>"
            f"</joint>"
        )
    return "\n".join([*lines, "</model></sdf>"])


def mjcf(bodies: Sequence[Written]) -> str:
    """MJCF; it has no speed limits."""
    children: dict[int, list[int]] = {}
    for k, body in enumerate(bodies):
        children.setdefault(body.parent, []).append(k)

    def text(k: int) -> str:
        body = bodies[k]
        (R, p), I = body.pose, body.tensor
        order = [float(I[i, j]) for i, j in ((0, 0), (1, 1), (2, 2), (0, 1), (0, 2), (1, 2))]
        axes = f"{_words(R[:, 0])} {_words(R[:, 1])}"
        slides = body.kind == "prismatic"
        ends = [body.limits.get(x, 0.0) for x in ("lower", "upper")]
        limited = f'limited="true" range="{_words(ends)}"' if "lower" in body.limits else ""
        return (
            f'<body name="{body.name}" pos="{_words(p)}" xyaxes="{axes}"><inertial mass="'
            f'{body.mass!r}" pos="{_words(body.com)}" fullinertia="{_words(order)}"/>'
            f'<joint name="{body.joint}" type="{"slide" if slides else "hinge"}" '
            f'axis="{_words(body.axis)}" {limited} damping="{body.damping!r}" '
            f'frictionloss="{body.friction!r}" armature="{body.armature!r}"/>'
            f"{''.join(map(text, children.get(k, [])))}</body>"
        )

    motors = "".join(
        f'<motor joint="{x.joint}" ctrllimited="true" '
        f'ctrlrange="{-x.limits["effort"]!r} {x.limits["effort"]!r}"/>'
        for x in bodies
        if "effort" in x.limits
    )
    inside = "".join(map(text, children[-1]))
    return (
        f'<mujoco model="as_mjcf"><compiler angle="radian"/><worldbody>{inside}</worldbody>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


def toml(bodies: Sequence[Written]) -> str:
    """freebody's own format, through URDF, with the rotors that this lacks."""
    model = fb.load(text=urdf(bodies), format="urdf", physical="ignore")
    for body in bodies:
        if body.armature:
            model = model.with_drive(body.joint, rotor=body.armature, gear=1.0)
    with tempfile.TemporaryDirectory() as folder:
        fb.save(model, path := Path(folder) / "robot.toml")
        return path.read_text(encoding="utf-8")


FORMATS: dict[str, Callable[[Sequence[Written]], str]] = {
    "urdf": urdf, "split.urdf": urdf_of_split_links, "sdf": sdf, "xml": mjcf, "toml": toml,
}  # fmt: skip
"""Writers by the ending of the file."""
