"""Closed chains in MJCF: ten linkages, each drawn once as parts and closings, are the same robot as
their TOML, and move as in MuJoCo, whose constraints are a little soft."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache

import numpy as np
import pytest

import freebody as fb
from support.extras import extra

mujoco = extra("mujoco", name="mjcf")
pytestmark = pytest.mark.usefixtures("numpy_kernels")

X, Y, Z = np.eye(3)
STIFF = 'solref="0.002 1" solimp="0.99999 0.99999 0.001"'
SOFT = 3e-3
"""Relative difference that MuJoCo's softness makes."""


@dataclass(frozen=True)
class Part:
    """A body whose axes are the world's in the drawing: where its joints and its far end are, m,
    its joints as (name, kind, axis), its mass, kg, and numbers of its joints."""

    name: str
    at: tuple[float, ...]
    to: tuple[float, ...]
    joints: tuple[tuple[str, str, np.ndarray], ...]
    parent: str = "world"
    mass: float = 1.0
    numbers: tuple[tuple[str, float], ...] = ()

    @property
    def com(self) -> np.ndarray:
        return 0.5 * (np.array(self.to) - self.at)


@dataclass(frozen=True)
class Closing:
    """A joint that closes a loop at a point of the drawing: a ball, or a hinge where it has an
    axis; where it is fixed, all."""

    a: str
    b: str
    at: tuple[float, ...]
    axis: np.ndarray | None = None
    fixed: bool = False


@dataclass(frozen=True)
class Linkage:
    """A closed chain in the drawing, in which all joints are at 0; the joints of its drives, and
    those of springs that the drives do not move."""

    parts: tuple[Part, ...]
    closings: tuple[Closing, ...]
    drives: tuple[str, ...]
    leaves: tuple[str, ...] = ()

    def part(self, name: str) -> Part:
        return next(part for part in self.parts if part.name == name)

    def below(self, name: str = "world") -> list[Part]:
        """The parts that hang on one, each before those on it, as MJCF nests them."""
        on = [part for part in self.parts if part.parent == name]
        return [one for part in on for one in (part, *self.below(part.name))]

    def place(self, name: str) -> np.ndarray:
        return np.array(self.part(name).at if name != "world" else (0.0, 0.0, 0.0))


def text(values: np.ndarray) -> str:
    return " ".join(repr(float(x)) for x in values)


def rows(values: np.ndarray) -> str:
    return f"[{', '.join(repr(float(x)) for x in values)}]"


KINDS = {"hinge": "revolute", "slide": "prismatic", "ball": "spherical", "free": "free"}
INERTIA = np.array([0.03, 0.04, 0.05])
"""kg m² for each kg, about axes of the drawing."""


def mjcf(linkage: Linkage) -> str:
    def body(part: Part) -> str:
        numbers = " ".join(f'{key}="{value!r}"' for key, value in part.numbers)
        joints = "".join(
            f'<joint name="{name}" type="{kind}" axis="{text(axis)}" {numbers}/>'
            if kind in ("hinge", "slide")
            else f'<joint name="{name}" type="{kind}"/>'
            for name, kind, axis in part.joints
        )
        inside = "".join(body(x) for x in linkage.parts if x.parent == part.name)
        return (
            f'<body name="{part.name}" pos="{text(part.at - linkage.place(part.parent))}">{joints}'
            f'<inertial pos="{text(part.com)}" mass="{part.mass!r}" '
            f'diaginertia="{text(part.mass * INERTIA)}"/>{inside}</body>'
        )

    def equality(closing: Closing, k: int) -> str:
        ends = f'body1="{closing.a}" body2="{closing.b}"'
        if closing.fixed:
            at = closing.at - linkage.place(closing.b)
            return f'<weld name="close{k}" {ends} anchor="{text(at)}" {STIFF}/>'
        at = closing.at - linkage.place(closing.a)
        half = 0.1 * closing.axis if closing.axis is not None else None
        points = [at] if half is None else [at - half, at + half]
        return "".join(
            f'<connect name="close{k}{"" if i == 0 else "_2"}" {ends} anchor="{text(p)}" {STIFF}/>'
            for i, p in enumerate(points)
        )

    bodies = "".join(body(part) for part in linkage.parts if part.parent == "world")
    closings = "".join(equality(x, k) for k, x in enumerate(linkage.closings))
    motors = "".join(f'<motor joint="{name}"/>' for name in linkage.drives)
    return (
        f'<mujoco model="linkage"><worldbody>{bodies}</worldbody><equality>{closings}</equality>'
        f"<actuator>{motors}</actuator></mujoco>"
    )


def toml(linkage: Linkage) -> str:
    lines = ['name = "linkage"', '[[link]]\nname = "world"']
    for part in linkage.below():
        above, origin = part.parent, part.at - linkage.place(part.parent)
        for k, (name, kind, axis) in enumerate(part.joints):
            last = k == len(part.joints) - 1
            child = part.name if last else f"{part.name}_{name}"
            if not last:
                lines.append(f'[[link]]\nname = "{child}"')
            given = dict(part.numbers)
            lines.append(
                f'[[joint]]\nname = "{name}"\nkind = "{KINDS[kind]}"\nparent = "{above}"\n'
                f'child = "{child}"\npassive = {str(name not in linkage.drives).lower()}'
            )
            if kind != "free":
                lines.append(f"origin = {rows(origin)}")
            if kind in ("hinge", "slide"):
                lines.append(f"axis = {rows(axis)}")
                if "damping" in given:
                    lines.append(f"friction = {{ viscous = {given['damping']!r} }}")
                if "stiffness" in given:
                    lines.append(f"spring = {{ stiffness = {given['stiffness']!r} }}")
                if "armature" in given:
                    lines.append(f"rotor = {{ inertia = {given['armature']!r} }}")
            above, origin = child, np.zeros(3)
        xx, yy, zz = part.mass * INERTIA
        lines.append(
            f'[[link]]\nname = "{part.name}"\nmass = {part.mass!r}\ncom = {rows(part.com)}\n'
            f"inertia = {rows(np.array([xx, 0, 0, yy, 0, zz]))}"
        )
    for k, closing in enumerate(linkage.closings):
        for end, name in (("a", closing.a), ("b", closing.b)):
            place = rows(closing.at - linkage.place(name))
            lines.append(f'[[frame]]\nname = "{end}{k}"\nparent = "{name}"\norigin = {place}')
        hinge = closing.axis is not None
        kind = "fixed" if closing.fixed else "revolute" if hinge else "spherical"
        lines.append(f'[[loop]]\nname = "close{k}"\nkind = "{kind}"\nframes = ["a{k}", "b{k}"]')
        if closing.axis is not None:
            lines.append(f"axis = {rows(closing.axis)}")
    return "\n".join(lines)


# ---------------------------------------------------------------- the linkages
def pin(name: str, axis: np.ndarray = Y) -> tuple[tuple[str, str, np.ndarray], ...]:
    return ((name, "hinge", axis),)


def bar(name: str, at: tuple, to: tuple, parent: str = "world", joint: str = "", **given) -> Part:
    """A bar of the xz-plane with a pin at its beginning."""
    a, b = ((x, 0.0, z) for x, z in (at, to))
    return Part(name, a, b, pin(joint or f"j_{name}"), parent, **given)


def closed(a: str, b: str, at: tuple, hinged: bool = True) -> Closing:
    return Closing(a, b, (at[0], 0.0, at[1]), Y if hinged else None)


def around(k: int, radius: float, z: float = 0.0) -> np.ndarray:
    angle = 2.0 * np.pi * k / 3.0
    return np.array([radius * np.cos(angle), radius * np.sin(angle), z])


def across(k: int) -> np.ndarray:
    angle = 2.0 * np.pi * k / 3.0
    return np.array([-np.sin(angle), np.cos(angle), 0.0])


def four_bar() -> Linkage:
    """Cut through its coupler, whose halves are welded together."""
    parts = (
        bar("crank", (0, 0), (0.2, 0.3)),
        bar("coupler", (0.2, 0.3), (0.6, 0.5), "crank"),
        bar("rocker", (1.2, 0), (1.0, 0.7), numbers=(("damping", 0.3), ("stiffness", 2.0))),
        bar("other", (1.0, 0.7), (0.6, 0.5), "rocker"),
    )
    weld = Closing("coupler", "other", (0.6, 0.0, 0.5), fixed=True)
    return Linkage(parts, (weld,), ("j_crank",))


def five_bar() -> Linkage:
    parts = (
        bar("left", (0, 0), (-0.2, 0.4), numbers=(("armature", 0.05),)),
        bar("left_rod", (-0.2, 0.4), (0.3, 0.8), "left"),
        bar("right", (0.5, 0), (0.8, 0.4), numbers=(("armature", 0.05),)),
        bar("right_rod", (0.8, 0.4), (0.3, 0.8), "right"),
    )
    return Linkage(parts, (closed("left_rod", "right_rod", (0.3, 0.8)),), ("j_left", "j_right"))


def slider_crank() -> Linkage:
    parts = (
        bar("crank", (0, 0), (0.2, 0.3)),
        bar("rod", (0.2, 0.3), (1.0, 0), "crank"),
        Part("slider", (1.0, 0, 0), (1.1, 0, 0), (("guide", "slide", X),), mass=2.0),
    )
    return Linkage(parts, (closed("rod", "slider", (1.0, 0), False),), ("guide",))


def pantograph() -> Linkage:
    parts = (
        bar("main", (0, 0), (0.5, 0.8)),
        bar("beam", (0.5, 0.8), (1.0, 0), "main"),
        bar("short", (0.25, 0.4), (0.5, 0), "main"),
        bar("link", (0.75, 0.4), (0.5, 0), "beam"),
    )
    return Linkage(parts, (closed("short", "link", (0.5, 0)),), ("j_main", "j_beam"))


def palletiser() -> Linkage:
    """The forearm is driven through a parallelogram; a second one keeps the bracket level."""
    parts = (
        bar("arm", (0, 0.3), (0, 1.0), joint="shoulder", mass=4.0),
        bar("forearm", (0, 1.0), (0.8, 1.0), "arm", mass=3.0),
        bar("lever", (0, 0.3), (-0.2, 0.3)),
        bar("push", (-0.2, 0.3), (-0.2, 1.0), "lever"),
        bar("bracket", (0, 1.0), (0.1, 1.2), "arm"),
        bar("tie", (-0.1, 0.5), (0.1, 1.2)),
    )
    closings = (
        closed("push", "forearm", (-0.2, 1.0)),
        closed("tie", "bracket", (0.1, 1.2)),
    )
    return Linkage(parts, closings, ("shoulder", "j_lever"))


def scissor() -> Linkage:
    parts = (
        bar("up", (0, 0), (0.8, 0.6)),
        Part("foot", (0.8, 0, 0), (0.9, 0, 0), (("slide", "slide", X),)),
        bar("down", (0.8, 0), (0, 0.6), "foot"),
        bar("up2", (0, 0.6), (0.8, 1.2), "down"),
        bar("down2", (0.8, 0.6), (0, 1.2), "up"),
    )
    closings = (closed("up", "down", (0.4, 0.3)), closed("up2", "down2", (0.4, 0.9)))
    return Linkage(parts, closings, ("slide",))


def three_rrr() -> Linkage:
    """Three legs in the xy-plane and a platform that slides and turns there."""
    parts, closings = [], []
    for k in range(3):
        foot, elbow, corner = around(k, 1.0), around(k, 0.8) + 0.4 * across(k), around(k, 0.3)
        parts += [
            Part(f"near{k}", tuple(foot), tuple(elbow), pin(f"drive{k}", Z)),
            Part(f"far{k}", tuple(elbow), tuple(corner), pin(f"elbow{k}", Z), f"near{k}"),
        ]
        closings.append(Closing(f"far{k}", "platform", tuple(corner), Z))
    plane = (("x", "slide", X), ("y", "slide", Y), ("turn", "hinge", Z))
    parts.append(Part("platform", (0.0, 0, 0), (0.1, 0, 0), plane, mass=2.0))
    return Linkage(tuple(parts), tuple(closings), tuple(f"drive{k}" for k in range(3)))


def delta() -> Linkage:
    """Three cranks, rods on two crossed hinges each, and a platform that only slides."""
    parts, closings = [], []
    for k in range(3):
        foot, elbow, corner = around(k, 0.3), around(k, 0.6, -0.1), around(k, 0.1, -0.8)
        crossed = ((f"swing{k}", "hinge", across(k)), (f"tilt{k}", "hinge", around(k, 1.0)))
        parts += [
            Part(f"crank{k}", tuple(foot), tuple(elbow), pin(f"drive{k}", across(k))),
            Part(f"rod{k}", tuple(elbow), tuple(corner), crossed, f"crank{k}", mass=0.3),
        ]
        closings.append(Closing(f"rod{k}", "platform", tuple(corner)))
    slides = (("x", "slide", X), ("y", "slide", Y), ("z", "slide", Z))
    parts.append(Part("platform", (0.0, 0, -0.8), (0.0, 0.1, -0.8), slides, mass=0.7))
    return Linkage(tuple(parts), tuple(closings), tuple(f"drive{k}" for k in range(3)))


def stewart() -> Linkage:
    """Six legs that grow hold a free platform."""
    parts, closings = [], []
    for k in range(6):
        third, side = divmod(k, 2)
        foot = around(third, 1.0) + (0.3 if side else -0.3) * across(third)
        top = around(third + (0.5 if side else -0.5), 0.6, 1.0)
        along = (top - foot) / np.linalg.norm(top - foot)
        aside = np.cross(along, Z) / np.linalg.norm(np.cross(along, Z))
        middle = foot + 0.4 * (top - foot)
        crossed = ((f"swing{k}", "hinge", aside), (f"tilt{k}", "hinge", np.cross(along, aside)))
        parts += [
            Part(f"case{k}", tuple(foot), tuple(middle), crossed, mass=0.8),
            Part(f"rod{k}", tuple(middle), tuple(top), ((f"leg{k}", "slide", along),), f"case{k}"),
        ]
        closings.append(Closing(f"rod{k}", "platform", tuple(top)))
    free = (("pose", "free", Z),)
    parts.append(Part("platform", (0.0, 0, 1.0), (0.0, 0.1, 1.1), free, mass=5.0))
    return Linkage(tuple(parts), tuple(closings), tuple(f"leg{k}" for k in range(6)))


def cassie() -> Linkage:
    """A leg of a walking robot as Cassie has them: a rod beside shin and tarsus, with leaf springs
    in between, and a rod to the foot."""
    leaf = (("stiffness", 150.0), ("damping", 0.4))
    parts = (
        Part("hip", (0.0, 0, 1.0), (0.0, 0.1, 1.0), pin("abduction", X), mass=1.8,
             numbers=(("armature", 0.04),)),
        bar("thigh", (0, 1.0), (0.12, 0.55), "hip", "pitch", mass=8.0),
        bar("knee", (0.12, 0.55), (0.18, 0.5), "thigh", "knee_motor", numbers=(("armature", 0.1),)),
        bar("shin", (0.18, 0.5), (0.06, 0.16), "knee", "shin_leaf", numbers=leaf),
        bar("tarsus", (0.06, 0.16), (-0.3, 0.06), "shin", "ankle", numbers=(("damping", 0.1),)),
        bar("heel", (0.04, 0.12), (-0.05, 0.1), "tarsus", "heel_leaf", numbers=leaf),
        Part("achilles", (0.0, 0.045, 0.96), (-0.05, 0.0, 0.1),
             (("swing", "hinge", Y), ("sway", "hinge", X)), "thigh", mass=0.16),
        bar("toe_crank", (-0.02, 0.13), (-0.02, 0.08), "tarsus", "toe_motor"),
        bar("plantar", (-0.02, 0.08), (-0.33, 0.02), "toe_crank", "rod"),
        bar("foot", (-0.3, 0.06), (-0.2, 0), "tarsus", "toe"),
    )  # fmt: skip
    closings = (
        Closing("achilles", "heel", (-0.05, 0.0, 0.1)),
        closed("plantar", "foot", (-0.33, 0.02)),
    )
    drives, leaves = ("abduction", "pitch", "knee_motor", "toe_motor"), ("shin_leaf", "heel_leaf")
    return Linkage(parts, closings, drives, leaves)


LINKAGES = {
    make.__name__: make
    for make in (
        four_bar, five_bar, slider_crank, pantograph, palletiser, scissor, three_rrr, delta,
        stewart, cassie,
    )
}  # fmt: skip
FEW = ("five_bar", "delta")
SOME = [x if x in FEW else pytest.param(x, marks=pytest.mark.long) for x in LINKAGES]


@cache
def both(name: str) -> tuple[fb.Model, fb.Model]:
    """The linkage as read from MJCF and from TOML."""
    linkage = LINKAGES[name]()
    return (
        fb.load(text=mjcf(linkage), format="mjcf"),
        fb.load(text=toml(linkage), format="toml"),
    )


def drawn(model: fb.Model, linkage: Linkage) -> np.ndarray:
    """The position in the drawing."""
    q = fb.neutral(model)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.kind == "free":
            q[list(at.q)] = [*linkage.part(body.name).at, 1.0, 0.0, 0.0, 0.0]
    return q


def moved(model: fb.Model, linkage: Linkage) -> np.ndarray:
    """A closed position beside the drawing."""
    q = drawn(model, linkage)
    for k, name in enumerate(linkage.drives):
        q[model.position_names.index(name)] += 0.03 * (1 + k % 2)
    return fb.assemble(model, q, free=model.passive_names)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", SOME)
def test_a_linkage_in_mjcf_is_that_of_its_toml(name):
    linkage = LINKAGES[name]()
    one, two = both(name)
    assert one.position_names == two.position_names
    assert one.passive_names == two.passive_names
    assert [loop.kind for loop in one.loops] == [loop.kind for loop in two.loops]
    same = fb.same_robot(one, two)
    assert same, str(same)
    assert not same.regardless
    q = moved(one, linkage)
    np.testing.assert_allclose(moved(two, linkage), q, atol=1e-9)
    rng = np.random.default_rng(len(name))
    tau, rates = np.zeros(one.nv), {}
    for drive in linkage.drives:
        tau[one.velocity_names.index(drive)] = rng.normal()
        rates[drive] = rng.normal()
    rates |= {leaf: rng.normal() for leaf in linkage.leaves}
    v = fb.loop_velocity(one, q, rates)
    found, expected = (fb.forward_dynamics(x, q, v, tau) for x in (one, two))
    np.testing.assert_allclose(found, expected, atol=1e-9 * (1.0 + abs(expected).max()))


@pytest.mark.parametrize("name", SOME)
def test_a_linkage_falls_as_in_mujoco(name):
    """From rest, in the drawing and beside it, under torques of the drives."""
    linkage, (model, _) = LINKAGES[name](), both(name)
    theirs = mujoco.MjModel.from_xml_string(mjcf(linkage))
    data = mujoco.MjData(theirs)
    joints = [mujoco.mj_id2name(theirs, mujoco.mjtObj.mjOBJ_JOINT, i) for i in range(theirs.njnt)]
    at = {x: model.velocity_names.index(x) for x in joints if x in model.velocity_names}
    assert len(at) + (name == "stewart") == theirs.njnt
    for q in (drawn(model, linkage), moved(model, linkage)):
        tau = np.zeros(model.nv)
        for k, drive in enumerate(linkage.drives):
            tau[at[drive]] = data.ctrl[k] = 3.0 - 2.0 * k
        for body, place in zip(model.bodies, model.coordinates, strict=True):
            start = theirs.jnt_qposadr[joints.index(body.joint.name)]
            data.qpos[start : start + len(place.q)] = q[list(place.q)]
        data.qvel[:] = 0.0
        mujoco.mj_forward(theirs, data)
        found = fb.forward_dynamics(model, q, np.zeros(model.nv), tau)
        expected = np.array([data.qacc[theirs.jnt_dofadr[joints.index(x)]] for x in at])
        size = abs(expected).max()
        np.testing.assert_allclose(found[list(at.values())], expected, atol=SOFT * size)
