"""Models: what is lumped and kept, changed copies, and every refusal of assembly."""

from __future__ import annotations

import dataclasses
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import Drive, FileError, Inertia, Limits, ModelError, Parameter
from freebody.model.build import build_model
from freebody.model.description import Joint, Link, Loop, Mount, Payload, RobotDescription
from freebody.model.inertia import combined
from freebody.model.joints import KINDS
from freebody.model.loop_kinds import LOOP_KINDS
from freebody.model.mimics import Mimic
from freebody.model.placement import Placement, shift
from support import generate, robots
from support.helpers import close, numbers, refused

Z = (0.0, 0.0, 1.0)
DOWN = (9.81, (0.0, 0.0, -1.0))
BALL = Inertia.sphere(1.0, 0.1).moved_to((0.3, 0.0, 0.0))


def hinge(name: str, parent: str, child: str, **changes: Any) -> Joint:
    return Joint(
        **{"name": name, "kind": "revolute", "parent": parent, "child": child, "axis": Z, **changes}
    )


def described(
    *joints: Joint, links: tuple[str | Link, ...] = ("base", "arm", "hand"), **changes: Any
) -> RobotDescription:
    made = tuple(link if isinstance(link, Link) else Link(link, BALL, line=10) for link in links)
    return RobotDescription(
        **{"name": "robot", "dim": 3, "links": made, "joints": joints, "gravity": DOWN, **changes}
    )


TWO = (
    hinge("shoulder", "base", "arm", line=20),
    hinge("elbow", "arm", "hand", placement=shift(0.5, 0.0, 0.0), line=30),
)


def says(text: str, description: RobotDescription, **options: Any) -> None:
    """Refused in these words; of a file, with its name and line."""
    with pytest.raises(ModelError, match=f"^'robot': {re.escape(text)}$"):
        build_model(description, **options)
    with pytest.raises(FileError, match=rf"^robot\.urdf(:\d+)?: {re.escape(text)}$"):
        build_model(replace(description, file="robot.urdf"), **options)


def changed(i: int, **changes: Any) -> RobotDescription:
    return described(
        *(replace(joint, **changes) if k == i else joint for k, joint in enumerate(TWO))
    )


# ---------------------------------------------------------------- refusals
def test_trees_that_cannot_be():
    says("there are no links; a robot needs at least one.", described(links=()))
    says(
        "two links are called 'arm'; rename one.",
        described(*TWO, links=("base", "arm", "arm", "hand")),
    )
    says("two joints are called 'shoulder'; rename one.", changed(1, name="shoulder"))
    says("a joint has no name; give it one.", changed(1, name=""))
    says("a link has no name; give it one.", described(*TWO, links=("base", "arm", "hand", "")))
    says(
        _unknown_link("parent", "amr"),
        changed(1, parent="amr"),
    )
    says(_unknown_link("child", "hnad"), changed(1, child="hnad"))
    says(
        "joint 'elbow': link 'arm' cannot be its own parent; name another parent.",
        changed(1, child="arm"),
    )
    says(
        "link 'hand' hangs on two joints, 'elbow' and 'third'; a tree allows one: "
        "write the other as a loop between two frames, or remove it.",
        described(*TWO, hinge("third", "base", "hand")),
    )
    cycle = described(
        hinge("a", "one", "two"), hinge("b", "two", "one"), links=("base", "one", "two")
    )
    says(
        "the links form a cycle, one -> two -> one (child -> parent); a tree has none: "
        "write one joint as a loop between two frames, or remove it.",
        cycle,
    )
    everything = described(hinge("a", "one", "two"), hinge("b", "two", "one"), links=("one", "two"))
    says(
        "the links form a cycle, one -> two -> one (child -> parent); a tree has none: "
        "write one joint as a loop between two frames, or remove it.",
        everything,
    )
    says(
        "links 'base', 'hand' have no parent joint; only one link can be the base: "
        "connect the others to it by joints.",
        described(TWO[0]),
    )


def _unknown_link(role: str, name: str) -> str:
    near = "arm" if role == "parent" else "hand"
    return (
        f"joint 'elbow': no {role} link {name!r} in the file. Did you mean {near!r}? "
        f"{role.capitalize()} links: base, arm, hand."
    )


def test_lines_of_a_file_are_the_ones_to_look_at():
    for description, line in (
        (changed(1, parent="amr"), 30),
        (changed(0, limits=Limits(2, 1)), 20),
        (described(TWO[0]), 10),
        (changed(1, mimic=Mimic("elbow")), 30),
    ):
        with pytest.raises(FileError) as refusal:
            build_model(replace(description, file="robot.urdf"))
        assert refusal.value.line == line
        assert str(refusal.value).startswith(f"robot.urdf:{line}: ")


def test_joints_that_cannot_be():
    kinds = f"Joint kinds: {', '.join(KINDS)}."
    says(
        f"no joint kind 'revolut' in joint 'elbow'. Did you mean 'revolute'? {kinds}",
        changed(1, kind="revolut"),
    )
    for axis in ((0.0, 0.0, 0.0), (1.0, 0.0), (), (math.nan, 0.0, 1.0)):
        says(
            f"joint 'elbow': axis {axis} must be 3 finite numbers, not all zero.",
            changed(1, axis=axis),
        )
    says(
        "joint 'elbow': lower limit 2 is above upper 1; swap them, or leave both out "
        "where there are none.",
        changed(1, limits=Limits(2, 1)),
    )
    says(
        "joint 'elbow': a limit is not a number; correct it.",
        changed(1, limits=Limits(velocity=math.nan)),
    )
    says(
        "joint 'elbow': friction, rotors and springs belong to joints of one coordinate, "
        "not a free one; "
        "remove them.",
        changed(1, kind="free", drive=Drive(viscous=1.0)),
    )
    flat = RobotDescription(
        "robot",
        2,
        (Link("base"), Link("arm", Inertia.bar(1.0, 1.0, dim=2))),
        (Joint("ball", "spherical", "base", "arm"),),
        (9.81, (0.0, -1.0)),
    )
    says("joint 'ball': a spherical joint needs a model in space, this one is planar.", flat)
    turned = replace(flat, joints=(Joint("pin", "revolute", "base", "arm", axis=Z),))
    says("joint 'pin': axis (0.0, 0.0, 1.0) must be 1 finite numbers, not all zero.", turned)


def test_mimics_that_cannot_be():
    says(
        "joint 'elbow': its mimic relations form a cycle; remove one.",
        changed(1, mimic=Mimic("elbow")),
    )
    both = described(
        replace(TWO[0], mimic=Mimic("elbow")), replace(TWO[1], mimic=Mimic("shoulder"))
    )
    says("joint 'shoulder': its mimic relations form a cycle; remove one.", both)
    unknown = changed(1, mimic=Mimic("sholder"))
    says(
        "no joint 'sholder' in the mimic of 'elbow'. Did you mean 'shoulder'? Joints: shoulder, "
        "elbow. "
        "Correct it, or load with mimic='free'.",
        unknown,
    )
    assert build_model(unknown, mimic="free").nv == 2
    ball = described(
        replace(TWO[0], kind="spherical", axis=()), replace(TWO[1], mimic=Mimic("shoulder"))
    )
    with pytest.raises(
        ModelError,
        match=r"^'robot': joint 'elbow': only joints of one coordinate can mimic or be mimicked\.",
    ):
        build_model(ball)


def test_frames_and_loops_that_cannot_be():
    says(
        "no link 'arms' in frame 'tool'. Did you mean 'arm'? Links: base, arm, hand.",
        described(*TWO, mounts=(Mount("tool", "arms"),)),
    )
    says(
        "frame 'arm': the name is taken; rename it.",
        described(*TWO, mounts=(Mount("arm", "hand"),)),
    )
    says(
        "frame 'tool': the name is taken; rename it.",
        described(*TWO, mounts=(Mount("tool", "hand"), Mount("tool", "arm"))),
    )


def test_loops_that_cannot_be():
    def knee(kind="revolute", frames=("arm", "base"), **more):
        return described(*TWO, loops=(Loop("knee", kind, frames, **more),))

    z = (0.0, 0.0, 2.0)
    assert build_model(knee(axis=z)).loops == (
        Loop("knee", "revolute", ("arm", "base"), (0.0, 0.0, 1.0)),
    )
    says(
        f"no loop kind 'hinge' in loop 'knee'. Loop kinds: {', '.join(LOOP_KINDS)}.",
        knee("hinge"),
    )
    says("loop 'knee': point is no loop of dimension 3; write spherical.", knee("point"))
    says(
        "no frame 'arms' in loop 'knee'. Did you mean 'arm'? Frames: base, arm, hand.",
        knee(frames=("arms", "base"), axis=z),
    )
    says("loop 'knee': axis () must be 3 finite numbers, not all zero.", knee())
    says(
        "loop 'knee': a spherical loop has no axis in dimension 3; remove it.",
        knee("spherical", axis=z),
    )
    says("loop 'knee': a fixed loop has no distance; remove it.", knee("fixed", distance=1.0))
    says("loop 'knee': give the distance (m) between its frames.", knee("distance"))
    says(
        "loop 'knee': distance is 0 m, expected more than 0; for 0 hold the origins together "
        "instead.",
        knee("distance", distance=0.0),
    )
    says(
        "loop 'knee': frames 'arm' and 'arm' are on the same body, "
        "so the loop closes nothing; name frames of two bodies.",
        knee(frames=("arm", "arm"), axis=z),
    )
    twice = replace(knee(axis=z), loops=(Loop("shoulder", "fixed", ("arm", "base")),))
    says("loop 'shoulder': the name is taken or empty; choose another.", twice)


def test_options_are_known_ones():
    for option, value, listed in (
        ("physical", "maybe", "warn, refuse, ignore"),
        ("mimic", "fixed", "follow, free"),
        ("base", "floating", "fixed, free"),
    ):
        near = " Did you mean 'fixed'?" if value == "fixed" and option == "base" else ""
        text = f"no option {value!r} in {option}=.{near} Options: {listed}."
        refused(
            text, lambda option=option, value=value: build_model(described(*TWO), **{option: value})
        )
    with pytest.raises(
        fb.FreebodyError,
        match=r"^no frame 'hnad' in 'robot'\. Did you mean 'hand'\? Frames: base, arm, hand\.$",
    ):
        build_model(described(*TWO), tip="hnad")


GIVE_A_LOAD = "give a mass (kg), perhaps with com= and box=, cylinder= or inertia=; or an Inertia."
BAD = Inertia.of(1.0, (0, 0, 0), [0.1, 0, 0, 0.1, 0, 0.5])
FAULT = "principal moments 0.1, 0.1, 0.5 kg m² break the triangle inequality (0.1 + 0.1 < 0.5)"


def test_inertias_no_body_has_are_refused_warned_of_or_used_as_given():
    description = described(*TWO, links=("base", "arm", Link("hand", BAD, line=12)))
    says(f"link 'hand': {FAULT}. Correct it, or accept it with physical='warn'.", description)
    warning = f"warning: link 'hand': {FAULT}."
    with pytest.warns(fb.PhysicalWarning, match=f"^{re.escape(warning)}$"):
        model = build_model(description, physical="warn")
    assert str(model.notices[0]) == f"warning: link 'hand': {FAULT}."
    with pytest.warns(fb.PhysicalWarning, match=r"^robot\.urdf:12: warning: link 'hand': "):
        filed = build_model(replace(description, file="robot.urdf"), physical="warn")
    assert (filed.notices[0].kind, filed.notices[0].line) == ("physical", 12)
    ignored = build_model(description, physical="ignore")
    assert [notice.kind for notice in ignored.notices] == ["tip"]
    z = np.zeros(2)
    for m in (model, ignored):
        assert numbers(m, "mass_matrix", z)[1, 1] == pytest.approx(0.5)  # as given


def test_warning_of_one_link_does_not_stop_the_binding_of_another():
    links = (
        "base",
        Link("arm", Inertia.of("m1", (0, 0, 0), [1.0, 0, 0, 1, 0, 1])),
        Link("hand", BAD),
    )
    model = build_model(described(*TWO, links=links), physical="ignore")
    assert model.bind(m1=2.0).mass == 1 + 2 + 1
    with pytest.raises(
        ModelError, match=r"^'robot': link 'arm': mass -2 kg is negative\. Bind a physical value\.$"
    ):
        model.bind(m1=-2.0)


def test_a_negative_mass_in_a_lump_keeps_its_moment():
    """Masses 1 and -1 fixed together leave a first moment without a mass, which no single Inertia
    holds."""
    links = (
        "base",
        Link("arm", Inertia.point(1.0, (0.5, 0, 0))),
        Link("hand", Inertia.point(-1.0, (0.2, 0, 0))),
    )
    joints = (TWO[0], Joint("weld", "fixed", "arm", "hand"))
    model = build_model(described(*joints, links=links), physical="ignore")
    assert model.replace(gravity=[0, -10, 0]).mass == 1.0
    bent = model.replace(gravity=[0, -10, 0])
    assert numbers(bent, "gravity_torque", np.zeros(1)) == pytest.approx([10 * (0.5 - 0.2)])
    assert numbers(bent, "mass_matrix", np.zeros(1))[0, 0] == pytest.approx(0.25 - 0.04)


# ---------------------------------------------------------------- what a model is
def test_names_and_order():
    model = build_model(described(*reversed(TWO)))
    assert model.joint_names == ("elbow", "shoulder")
    assert model.position_names == model.velocity_names == ("elbow", "shoulder")
    assert model.frame_names == ("base", "arm", "hand")
    assert (model.nq, model.nv, model.tip, model.leaves) == (2, 2, "hand", ("hand",))
    assert [body.name for body in model.bodies] == ["hand", "arm"]
    assert [body.parent for body in model.bodies] == [1, -1]
    assert model.body_index("hand") == 0
    assert repr(model) == "<Model 'robot': 2 bodies, nq = 2, nv = 2, dim 3>"


def test_models_are_frozen():
    model = build_model(described(*TWO))
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.name = "other"
    with pytest.raises(dataclasses.FrozenInstanceError):
        model.bodies[0].joint.name = "other"
    with pytest.raises(TypeError):
        model.bodies[0] = model.bodies[1]


def test_axes_are_made_unit_and_coordinate_axes_exact():
    model = build_model(changed(0, axis=(0.0, 0.3, 0.0)))
    assert model.bodies[0].joint.axis == (0.0, 1.0, 0.0)
    model = build_model(changed(0, axis=(0.0, -3.0, 4.0)))
    assert model.bodies[0].joint.axis == pytest.approx((0, -0.6, 0.8))


@pytest.mark.parametrize("seed", range(24))
def test_lumping_keeps_every_link_and_the_total_mass(seed: int):
    description, model = generate.tree(seed), generate.model(seed)
    mass = sum(link.inertia.mass for link in description.links if link.inertia)
    mass += sum(load.inertia.mass for load in description.payloads)
    assert model.mass == pytest.approx(mass, rel=1e-14)
    fixed_to = {joint.child: joint.parent for joint in description.joints if joint.kind == "fixed"}
    for link in description.links:
        frame = model.frame(link.name)
        carrier = link.name
        while carrier in fixed_to:
            carrier = fixed_to[carrier]
        assert frame.parent == fixed_to.get(link.name, "")
        assert (model.bodies[frame.body].name if frame.body >= 0 else "base") in (carrier, "base")
        kept = model.base_inertias if frame.body < 0 else model.bodies[frame.body].inertias
        assert (link.name in [part.link for part in kept]) == (link.inertia is not None)


def test_fixed_siblings_are_not_chained():
    """Two links fixed to the same one: each placed from it, whatever their order."""
    weld = (
        Joint("left_weld", "fixed", "arm", "left", shift(0.0, 1.0, 0.0)),
        Joint("right_weld", "fixed", "arm", "right", shift(0.0, -1.0, 0.0)),
    )
    for order in (weld, weld[::-1]):
        links = ("base", "arm", Link("left", Inertia.point(1.0)), Link("right", Inertia.point(1.0)))
        model = build_model(described(TWO[0], *order, links=links))
        assert fb.mass_matrix(model, [0.0])[0, 0] == pytest.approx(
            fb.mass_matrix(build_model(described(TWO[0], links=("base", "arm"))), [0.0])[0, 0] + 2.0
        )
        assert fb.center_of_mass(model, [0.0])[1] == pytest.approx(0.0, abs=1e-15)


def test_leaves():
    fork = described(hinge("l", "base", "arm"), hinge("r", "base", "hand"))
    model = build_model(fork)
    assert (model.tip, model.leaves) == (None, ("arm", "hand"))
    assert build_model(fork, tip="arm").tip == "arm"
    tooled = replace(fork, mounts=(Mount("gripper", "hand", shift(0.1, 0.0, 0.0)),))
    assert build_model(tooled).leaves == ("arm", "gripper")


def test_free_base():
    model = build_model(described(*TWO), base="free")
    assert (model.joint_names, model.nq, model.nv) == (("base", "shoulder", "elbow"), 9, 8)
    assert model.bodies[0].joint.kind == "free"
    flat = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1])
    assert flat.nv == 1
    with pytest.raises(ModelError, match=r"^'robot': two joints are called 'base'; rename one\.$"):
        build_model(changed(0, name="base"), base="free")


def test_free_planar_base_moves_in_x_y_and_theta():
    links = (Link("base", Inertia.disc(2.0, 0.5, dim=2)), Link("arm", Inertia.bar(1.0, 1.0, dim=2)))
    joints = (Joint("pin", "revolute", "base", "arm", axis=(1.0,)),)
    model = build_model(
        RobotDescription("rover", 2, links, joints, (9.81, (0.0, -1.0))), base="free"
    )
    assert model.position_names == ("base.x", "base.y", "base.theta", "pin")
    q, qd, qdd = fb.random_state(model, 1, 3)
    close(
        numbers(model, "inverse_dynamics", q, qd, qdd),
        numbers(model.to_space(), "inverse_dynamics", q, qd, qdd),
        1e-13,
    )
    assert fb.mass_matrix(model, q[0])[0, 0] == pytest.approx(3.0)


def test_limits():
    ball = described(
        replace(TWO[0], kind="spherical", axis=()), replace(TWO[1], limits=Limits(-1, 2, 3, 4))
    )
    limits = build_model(ball).limits
    assert limits.lower.tolist() == [-math.inf] * 3 + [-1]
    assert limits.upper.tolist() == [math.inf] * 3 + [2]
    assert limits.velocity.tolist() == [math.inf] * 3 + [3]
    assert limits.effort.tolist() == [math.inf] * 3 + [4]


# ---------------------------------------------------------------- changed copies
def test_replace():
    model = build_model(described(*TWO))
    other = model.replace(name="other", tip="arm", gravity=[1.0, 2.0, -2.0])
    assert (other.name, other.tip, model.name, model.tip) == ("other", "arm", "robot", "hand")
    assert other.gravity == pytest.approx([1, 2, -2])
    assert other.replace(gravity=6.0).gravity == pytest.approx(
        [2, 4, -4]
    )  # a size keeps the direction
    assert other.replace(gravity=0).gravity.tolist() == [0, 0, 0]
    assert other.replace(gravity=[0, 0, 0]).gravity.tolist() == [0, 0, 0]
    assert model.replace(gravity=[0, -9.81, 0]).gravity.tolist() == [0, -9.81, 0]
    named = model.replace(gravity="g")
    assert named.missing == ("g",)
    assert named.bind(g=3.0).gravity.tolist() == [0, 0, -3.0]
    with pytest.raises(
        ModelError, match=r"^gravity: a vector of 3 entries in world axes is needed, not 2\.$"
    ):
        model.replace(gravity=[0, 1])
    with pytest.raises(
        fb.FreebodyError, match=r"^no frame 'amr' in 'robot'\. Did you mean 'arm'\?"
    ):
        model.replace(tip="amr")


def test_without():
    drive = Drive(1.0, 2.0, 3.0, 4.0, 5.0, 6.0)
    model = build_model(changed(0, drive=drive))
    assert model.without("friction").bodies[0].joint.drive == replace(
        drive, viscous=0.0, coulomb=0.0
    )
    assert model.without("rotors").bodies[0].joint.drive == replace(drive, rotor=0.0)
    assert model.without("springs").bodies[0].joint.drive == replace(drive, stiffness=0.0)
    assert model.bodies[0].joint.drive == drive
    with pytest.raises(
        fb.FreebodyError,
        match=r"^no feature 'rotor' in Model\.without\. Did you mean 'rotors'\? Features: ",
    ):
        model.without("rotor")


def test_bind():
    model = fb.planar("R")
    known = "Parameters: m1, lc1, I1, l1, g."
    refused(f"no parameter 'l11' in 'R'. Did you mean 'l1'? {known}", lambda: model.bind(l11=1))
    refused("parameter 'l1': nan is not a finite number.", lambda: model.bind(l1=math.nan))
    refused(
        f"parameter 'l1' = 'long': no parameter 'long' in the model. {known}",
        lambda: model.bind(l1="long"),
    )
    negative = "'R': link 'link1': mass -1 kg is negative. Bind a physical value."
    refused(negative, lambda: model.bind(m1=-1, lc1=1, I1=1))
    half = model.bind(l1=2.0)
    assert (half.parameters["l1"], model.parameters["l1"], half.missing) == (
        2.0,
        None,
        ("I1", "lc1", "m1"),
    )


def test_drives_limits_and_mimics_hold_numbers():
    assert Drive(viscous="b1").viscous == Parameter("b1")
    assert (
        type(Drive(rotor=1).rotor) is type(Limits(0, 1).upper) is type(Mimic("a", 2).ratio) is float
    )
    for text, call in (
        ("Drive: viscous: nan is not a finite number.", lambda: Drive(viscous=math.nan)),
        ("Limits: lower: 'low' is not a number.", lambda: Limits("low")),
        ("Mimic: offset: inf is not a finite number.", lambda: Mimic("a", offset=math.inf)),
        (
            "'robot': joint 'elbow': velocity limit -1 is negative; give its size.",
            _limited(velocity=-1),
        ),
        (
            "'robot': joint 'elbow': effort limit -2 is negative; give its size.",
            _limited(effort=-2),
        ),
        (
            "'robot': joint 'elbow': no position lies between its limits; make one finite.",
            _limited(lower=math.inf),
        ),
    ):
        refused(text, call)


def _limited(**limits: float):
    return lambda: build_model(changed(1, limits=Limits(**limits), line=None))


def test_numbers_of_numpy_are_numbers():
    model = fb.planar("R", l=[1], lc=[0.5], m=[1], I=[0.1], g=np.float32(2))
    assert model.gravity.tolist() == [0, -2]
    assert model.replace(gravity=np.int64(3)).gravity.tolist() == [0, -3]
    assert model.with_payload(np.float32(2)).mass == 3
    with pytest.raises(fb.FreebodyError, match="the gravity of 'R': numbers need a value for g0"):
        _ = fb.planar("R", g="g0").gravity


def test_payload_refusals():
    model = build_model(described(*TWO))
    for text, call in (
        (f"with_payload: {GIVE_A_LOAD}", lambda: model.with_payload()),
        (
            f"with_payload: {GIVE_A_LOAD}",
            lambda: model.with_payload("heavy"),
        ),
        (
            "with_payload: an Inertia has a mass of its own; leave out mass=, or give inertia= as "
            "its entries about the centre of mass.",
            lambda: model.with_payload(inertia=Inertia.nothing(), mass=1.0),
        ),
        (
            "with_tool: rotation has shape (2, 2), expected (3, 3).",
            lambda: model.with_tool("tool", rotation=np.eye(2)),
        ),
        (
            "with_payload: the inertia is 2D but 'robot' is 3D.",
            lambda: model.with_payload(Inertia.nothing(2)),
        ),
        (f"with_payload: 'payload': {FAULT}.", lambda: model.with_payload(BAD)),
        ("with_payload: 'payload': mass -1 kg is negative.", lambda: model.with_payload(-1.0)),
        (
            "with_tool: 'robot' already has a frame 'arm'; choose another name.",
            lambda: model.with_tool("arm"),
        ),
        ("with_tool: position has 2 entries, expected 3.", lambda: model.with_tool("tool", (1, 2))),
        (
            "with_tool: the matrix is not a rotation (R Rᵀ = 1, det R = 1).",
            lambda: model.with_tool("tool", rotation=-np.eye(3)),
        ),
        (
            "with_tool: position: nan is not a finite number.",
            lambda: model.with_tool("tool", (math.nan, 0, 0)),
        ),
    ):
        refused(text, call)


def test_payload_as_point_mass():
    model = build_model(described(*TWO))
    q = np.array([0.3, 0.4])
    J = fb.jacobian(model, q)[:3]
    gained = fb.mass_matrix(model.with_payload(2.0), q) - fb.mass_matrix(model, q)
    assert gained == pytest.approx(2.0 * J.T @ J)
    same = fb.mass_matrix(model.with_payload(mass=2.0, com=(0, 0, 0)), q)
    assert same == pytest.approx(fb.mass_matrix(model.with_payload(2.0), q))
    described_ = described(*TWO, payloads=(Payload("bag", "hand", Inertia.point(2.0)),))
    assert fb.mass_matrix(build_model(described_), q) == pytest.approx(same)


def test_placements():
    assert Placement().steps == shift(0.0, 0.0, 0.0).steps == ()
    there = robots.shift(1.0, 2.0, 3.0)
    assert there.then(there.inverse()).matrix() == pytest.approx(np.eye(4))


# ---------------------------------------------------------------- drives that no motor has
NO_DRIVE = [
    ({"viscous": -1.0}, "viscous friction -1 is negative; give it as 0 or more"),
    ({"coulomb": -2.0}, "Coulomb friction -2 is negative; give it as 0 or more"),
    ({"rotor": -1e-4}, "rotor inertia -0.0001 is negative; give it as 0 or more"),
]
NO_GEAR = ({"gear": 0.0}, "gear is 0; give the ratio of motor speed to joint speed, below 0 where ")


@pytest.mark.parametrize(("given", "words"), [*NO_DRIVE, NO_GEAR])
@pytest.mark.parametrize("changes", [0, 3])
def test_a_drive_that_no_motor_has_is_refused(given: dict[str, float], words: str, changes: int):
    """Of a model, and of a copy that is edited for the third time."""
    model = fb.load("ur5e")
    for k in range(changes):
        model = model.bind({"elbow_joint.friction.viscous": 1.0 + k})
    number = {"viscous": "friction.viscous", "coulomb": "friction.coulomb", "gear": "rotor.gear"}
    name = number.get(*given, "rotor.inertia")
    value = next(iter(given.values()))
    with pytest.raises(fb.FreebodyError, match=re.escape(words)):
        model.with_drive("elbow_joint", **given)
    with pytest.raises(fb.FreebodyError, match=re.escape(f"joint 'elbow_joint': {words}")):
        model.bind({f"elbow_joint.{name}": value})
    with pytest.raises(fb.FreebodyError, match=re.escape(words)):
        model.bind({f"elbow_joint.{name}": np.array([1.0, value])})


@pytest.mark.parametrize(("given", "words"), NO_DRIVE)
def test_a_file_s_drive_that_no_motor_has_is_warned_of(
    given: dict[str, float], words: str, tmp_path: Path
):
    given = dict(given)
    viscous, coulomb = given.pop("viscous", 0.0), given.pop("coulomb", 0.0)
    rows = [{"a": 1.0, "m": 1.0, "friction": (viscous, coulomb), **given}]
    with pytest.raises(fb.FreebodyError, match=re.escape(words)):
        fb.dh(rows, convention="standard")
    file = tmp_path / "arm.toml"
    fb.save(fb.dh(rows, convention="standard", physical="ignore"), file)
    with pytest.warns(fb.PhysicalWarning, match=re.escape(f"joint 'joint1': {words}.")):
        model = fb.load(file)
    assert [notice.kind for notice in model.notices] == ["drive", "tip"]
    model.bind({"gravity": 9.0})  # what was accepted before stays so


def test_a_spring_may_push_away_and_a_gear_turn_the_other_way():
    fb.load("ur5e").with_drive("elbow_joint", stiffness=-1.0, gear=-100.0, rotor=1e-4)


def test_a_name_is_one_number_wherever_it_stands():
    arm = fb.load("2R")
    like_m1 = Inertia.point(Parameter("m1"), (0.0, 0.0))
    one = fb.planar("RR", l=[Parameter("a", 0.5), "a"])
    assert one.parameters["a"] == 0.5
    assert {r.name: r.value for r in fb.parameters(one)}["a"] == 0.5
    for known, made in (
        (0.4, arm.bind(l1=0.4).with_drive("joint1", viscous="l1").bodies[0].joint.drive.viscous),
        (3.0, arm.bind(m2=3.0).replace(gravity="m2").gravity_size),
        (
            6.0,
            arm.with_payload(like_m1).bodies[-1].inertias[-1].inertia.mass,
        ),
    ):
        assert made.value == known
    driven = arm.with_drive("joint1", viscous="l1")
    q, qd = [0.1, 0.2], [0.3, 0.4]
    friction = fb.inverse_dynamics(driven, q, qd, qd) - fb.inverse_dynamics(arm, q, qd, qd)
    close(friction, [driven.parameters["l1"] * 0.3, 0.0], 1e-12)
    other = Parameter("l1", 7.0)
    for change in (
        lambda: fb.planar("RR", l=[Parameter("l1", 1.0), other]),
        lambda: arm.with_drive("joint1", viscous=other),
        lambda: arm.with_payload(Inertia.point(other, (0.0, 0.0))),
        lambda: arm.replace(gravity=other),
    ):
        with pytest.raises(ModelError, match=r"parameter 'l1' has two values, .*; a name is one"):
            change()
    assert (
        arm.with_drive("joint1", viscous=Parameter("b", 1.0))
        .with_drive("joint1", viscous=Parameter("b", 2.0))
        .parameters["b"]
        == 2.0
    ), "what is replaced does not count"


def test_what_is_known_to_be_negative_is_refused_though_other_values_are_open():
    with pytest.raises(ModelError, match="'link1': mass -1 kg is negative"):
        fb.planar("RR", m=[-1, 1])
    with pytest.raises(ModelError, match="'link2': moment of inertia -2 kg m² is negative"):
        fb.planar("RR", I=[1, -2])
    assert fb.planar("RR", m=["a", 0]).parameters["a"] is None


def test_no_inertias_are_none_together():
    with pytest.raises(fb.FreebodyError, match=r"^combined: give at least one Inertia\.$"):
        combined([])
