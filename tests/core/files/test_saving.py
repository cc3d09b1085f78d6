"""Models written as URDF, SDF, MJCF and DH tables: read again they move as before, and what a
format cannot hold is told before anything is written."""

import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.extras import extra
from support.fuzz import CORPUS
from support.generate import model as generated
from support.helpers import all_driven, close, numbers, poses
from support.mujoco_server import MujocoServer
from support.real_files import FILES, REFUSED, ROBOTS, every_robot_file

pytestmark = pytest.mark.usefixtures("numpy_kernels", "one_mujoco")

FORMATS = ("urdf", "sdf", "mjcf", "csv")
RANGES = ("lower", "upper", "velocity", "effort")
FEW = ("ur5e", "panda", "five_bar", "puma560", "quadrotor")


@pytest.fixture(name="one_mujoco")
def one_mujoco_process(monkeypatch: pytest.MonkeyPatch) -> None:
    """MuJoCo is started once for the files of all tests, where one can wait for a process."""
    if sys.platform != "win32":
        monkeypatch.setattr(subprocess, "run", _mujoco.run)


_mujoco = MujocoServer()


def valued(name: str | Path) -> fb.Model:
    """A model, such as a bundled one, with a value for every number."""
    model = fb.load(name, physical="ignore")
    missing = {name: 0.7 for name, value in model.parameters.items() if value is None}
    return model.bind(**missing) if missing else model


def after(model: fb.Model, kind: str, folder: Path) -> tuple[fb.Model, list[str]]:
    """The model after a file of a format that holds it, and what that has lost."""
    found = again(model, kind, folder)
    assert found
    return found


def again(model: fb.Model, kind: str, folder: Path) -> tuple[fb.Model, list[str]] | None:
    """The model after a file of that format, and what that has lost; None where the format does
    not hold such a robot at all."""
    try:
        lost = fb.losses(model, kind)
    except fb.FreebodyError:
        return None
    file = folder / f"robot.{kind}"
    if lost:
        with pytest.raises(fb.FreebodyError, match="would be lost") as told:
            fb.save(model, file)
        assert lost[0] in str(told.value)
        assert not file.exists()
    fb.save(model, file, lossy=bool(lost))
    base = "free" if said(lost, "base='free'") else None
    if said(lost, "snap_angles=0"):
        read = fb.load(file, physical="ignore", base=base, snap_angles=0.0)
    else:
        read = fb.load(file, physical="ignore", base=base)
    file.unlink()
    return read, lost


def said(lost: list[str], words: str) -> bool:
    return any(words in loss for loss in lost)


def left(model: fb.Model, lost: list[str]) -> fb.Model:
    """What is left of a model by the words of its losses, of those that change how it moves."""
    if said(lost, "the plane"):
        model = model.to_space()
    if said(lost, "gravity"):
        size = np.linalg.norm(model.gravity) if said(lost, "a table has it along -z") else 9.81
        model = model.replace(gravity=[0.0, 0.0, -size])
    if said(lost, "the stiffness of the spring"):
        model = model.without("springs")
        for name in model.passive_names:  # shafts keep theirs
            model = model.with_drive(name, stiffness=0.0) if name.endswith("_twist") else model
    if any(loss.startswith(("the strut ", "the struts ")) for loss in lost):
        model = model.without("struts")
    if said(lost, "load-dependent friction") or said(lost, "efficiency of the gear"):
        for name in model.joint_names:
            model = model.with_drive(name, load_friction=0, efficiency=0, back_efficiency=0)
    return model


_RENAMED = re.compile(r"the name of joint '(.*)', which a link has: '(.*)' is written")


def renamed(name: str, one: fb.Model, two: fb.Model, lost: list[str]) -> str:
    """A coordinate's name after a file: SDF names no free joints, and none as a link; a base that
    floats is told by `base`."""
    joint, dot, rest = name.partition(".")
    if name in (*two.position_names, *two.velocity_names):
        return name
    body = next(body for body in one.bodies if body.joint.name == joint)
    if body.joint.kind != "free":
        others = {x[1]: x[2] for x in map(_RENAMED.fullmatch, lost) if x}
        return f"{others[joint]}{dot}{rest}"
    floating = {x.name: x.joint.name for x in two.bodies if x.joint.kind == "free"}
    found = floating.get(body.name) or next(iter(floating.values()))
    return f"{found}.{rest}"


def floats_last(model: fb.Model, names: tuple[str, ...], lost: list[str]) -> list[int]:
    """Where each coordinate of a model is after a file that may have those of free joints last."""
    free = tuple(f"{body.joint.name}." for body in model.bodies if body.joint.kind == "free")
    moved = [said(lost, "the last") and name.startswith(free) for name in names]
    order = sorted(range(len(names)), key=lambda k: moved[k])
    return [order.index(k) for k in range(len(names))]


def same_motion(one: fb.Model, two: fb.Model, lost: list[str]) -> None:
    """The same mass matrix, bias and limits, coordinate by coordinate, and frames at the same
    places."""
    one, two = left(one, lost).opened, two.opened
    q, qd, _ = fb.random_state(one, 5, 2)
    if said(lost, "joints of one coordinate"):
        # rates of the joints that were taken apart are others
        assert (one.nq, one.nv) == (two.nq, two.nv)
        place, at = (floats_last(one, x, lost) for x in (one.position_names, one.velocity_names))
        if said(lost, "order of its coordinates"):
            return
    else:
        place = [two.position_names.index(renamed(x, one, two, lost)) for x in one.position_names]
        at = [two.velocity_names.index(renamed(x, one, two, lost)) for x in one.velocity_names]
        assert at == sorted(at) or said(lost, "order of its coordinates") or said(lost, "the last")
    # what has no mass is a speck of dust in MuJoCo
    dust = 1.0 if said(lost, "no mass, or no moment") else 0.0
    there, rates = np.empty_like(q), np.empty_like(qd)
    there[:, place], rates[:, at] = q, qd
    if one.nv == 0:
        close(two.mass, one.mass, 1e-12, what="mass")
        return
    if not said(lost, "which does not move") and not said(lost, "which is the ground"):
        close(two.mass, one.mass, 1e-12, max(1e-3, dust), what="mass")
    rise, own_rise = (
        np.diff(numbers(m, "potential_energy", x)) for m, x in ((two, there), (one, q))
    )
    close(rise, own_rise, 1e-12, max(1e-3 * one.mass, dust), what="potential energy")
    if not said(lost, "no rigid body has") and not said(lost, "joints of one coordinate"):
        M = numbers(two, "mass_matrix", there)[:, at][:, :, at]
        bias = numbers(two, "bias", there, rates)[:, at]
        least = max(1e-3, dust)
        close(M, numbers(one, "mass_matrix", q), 1e-12, least, what="mass matrix")
        close(bias, numbers(one, "bias", q, qd), 1e-12, least, what="bias")
    for name in RANGES:
        if name != "velocity" or not said(lost, "speed limit"):
            found, own_limits = getattr(two.limits, name)[at], getattr(one.limits, name)
            kept = np.full(one.nv, True)
            if said(lost, "which is a point"):
                kept = one.limits.lower < one.limits.upper
            if said(lost, "takes for none"):
                kept = kept & (np.abs(own_limits) < 1e16)
                kept &= (own_limits != 0.0) | (name in ("lower", "upper"))
            assert found[kept].tolist() == own_limits[kept].tolist(), name
    if said(lost, "which the last joint does not move"):
        return
    theirs, own = poses(two, there), poses(one, q)
    if said(lost, "where the frames") or said(lost, "the name of the tip"):
        own, theirs = {"tip": own[one.tip or ""]}, {"tip": theirs[two.tip or ""]}
    for name in own.keys() & theirs.keys():
        close(theirs[name], own[name], 1e-12, 1.0, what=name)


def every_pair(model: fb.Model, folder: Path) -> None:
    """The model in every format, and from there in every other."""
    for kind in FORMATS:
        found = again(model, kind, folder)
        if found is None:
            continue
        read, lost = found
        same_motion(model, read, lost)
        for other in ("toml", *FORMATS):
            second = again(read, other, folder)
            if second is not None:
                same_motion(read, *second)


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", FEW)
def test_bundled_models_through_every_pair_of_formats(name, tmp_path):
    every_pair(valued(name), tmp_path)


@pytest.mark.parametrize(
    "file",
    ["dh/table.csv", "mjcf/loop.xml", "mjcf/tree.xml", "sdf/loop.sdf", "urdf/kinds.urdf",
     "xacro/arm.xacro"],
)  # fmt: skip
def test_files_of_every_format_through_every_pair(file, tmp_path):
    if file.startswith("mjcf"):
        extra("mujoco", name="mjcf")
    every_pair(valued(CORPUS / file), tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in fb.models() if name not in FEW])
def test_all_bundled_models_through_every_pair_of_formats(name, tmp_path):
    every_pair(valued(name), tmp_path)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", [name for name in FILES if name not in REFUSED])
def test_real_files_through_every_pair_of_formats(name, tmp_path):
    every_pair(fb.load(ROBOTS / name, physical="ignore"), tmp_path)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("file", list(every_robot_file()))
def test_robots_of_data_wheels_through_every_pair_of_formats(file, tmp_path):
    """Those of the wheels that are on the path; what is refused is skipped with the refusal."""
    try:
        model = fb.load(file, physical="ignore")
    except fb.FreebodyError as refusal:
        pytest.skip(f"refused: {refusal}")
    every_pair(model, tmp_path)


@pytest.mark.sample(1)
@pytest.mark.parametrize("seed", range(6))
def test_generated_mechanisms_in_every_format(seed, tmp_path):
    """Trees of every kind of joint, with every law of drives."""
    model = generated(seed)
    for kind in FORMATS:
        found = again(model, kind, tmp_path)
        if found is not None:
            same_motion(model, *found)


def test_moments_that_no_body_has_are_raised_to_what_mujoco_takes(tmp_path):
    """Those of an Allegro hand: rounded sums of what was raised were refused."""
    file = tmp_path / "finger.urdf"
    file.write_text("""<robot name="finger"><link name="base"/><link name="tip"><inertial>
<mass value="0.0355"/><inertia ixx="2.63979183333e-05" ixy="6.67968e-06" ixz="4.783625e-06"
iyy="1.34948516667e-05" iyz="9.372e-06" izz="2.63979183333e-05"/></inertial></link>
<joint name="bend" type="continuous"><parent link="base"/><child link="tip"/></joint></robot>""")
    model = fb.load(file, physical="ignore")
    read, lost = after(model, "mjcf", tmp_path)
    assert said(lost, "no rigid body has")
    assert read.mass == model.mass


@pytest.mark.parametrize("kind", ["sdf", "mjcf"])
def test_a_link_that_moves_and_is_called_as_the_ground_is_refused(kind):
    """Two bodies of one name were written, which no reader takes."""
    hinge = HINGE.format(k=1, axis="z", parent="base")
    text = ARM.format(links=LINK.format(k=1), joints=hinge).replace("l3", "l1")
    model = fb.load(text=text.replace("l1", "world"), format="toml")
    with pytest.raises(fb.FreebodyError, match="'world' is the ground, and no other link"):
        fb.losses(model, kind)


# ---------------------------------------------------------------- closed chains
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *((name, "urdf") for name in ("five_bar", "bricard", "stewart")),
        *((name, "mjcf") for name in ("five_bar", "bricard", "stewart")),
        ("double_four_bar", "sdf"),
    ],
)
def test_loops_hold_the_same_motions(name, kind, tmp_path):
    """Accelerations of a closed chain by torques in all its joints."""
    model = all_driven(valued(name))
    read, lost = after(model, kind, tmp_path)
    model, read = left(model, lost), all_driven(read)
    q = fb.assemble(model)
    place = [read.position_names.index(x) for x in model.position_names]
    at = [read.velocity_names.index(x) for x in model.velocity_names]
    there, tau = np.empty_like(q), np.arange(1.0, model.nv + 1.0)
    there[place] = q
    force = np.empty_like(tau)
    force[at] = tau
    rest = np.zeros(model.nv)
    found = fb.forward_dynamics(read, there, rest, force)[at]
    close(found, fb.forward_dynamics(model, q, rest, tau), 1e-12)


@pytest.mark.sample(6)
@pytest.mark.parametrize(
    ("kind", "limits", "lost"),
    [
        ("urdf", "effort = 0", ["the effort limit 0 of j, which URDF takes for none"]),
        ("urdf", "velocity = 0", ["the speed limit 0 of j, which URDF takes for none"]),
        ("urdf", "effort = 1e17", ["the effort limit 1e+17 of j, which URDF takes for none"]),
        ("urdf", "lower = 0, upper = 0", []),
        ("sdf", "lower = 0, upper = 0, velocity = 0, effort = 0", []),
        ("sdf", "lower = -1e16", ["the lower limit -1e+16 of j, which SDF takes for none"]),
        ("mjcf", "effort = 0", ["the effort limit 0 of j, which MJCF takes for none"]),
        ("mjcf", "velocity = 0", ["the speed limit of j"]),
        ("mjcf", "lower = 0, upper = 0",
         ["the range of 'j', which is a point: MuJoCo takes it for none"]),
        ("csv", "lower = 0, upper = 0, velocity = 0, effort = 0", []),
    ],
)  # fmt: skip
def test_limits_of_0_are_kept_or_told(kind, limits, lost, tmp_path):
    """Readers take some limits of 0, and very large ones, for none: a loss by name, else they are
    read again."""
    if kind == "mjcf":
        extra("mujoco", name="mjcf")
    text = (
        "[dh]\nconvention = 'standard'\n"
        f"rows = [{{ a = 1, m = 2, joint_name = 'j', limits = {{ {limits} }} }}]\n"
    )
    one = fb.load(text=text, format="toml")
    told = [x for x in fb.losses(one, kind) if "limit" in x or "range" in x]
    assert told == lost
    fb.save(one, tmp_path / f"one.{kind}", lossy=True)
    two = fb.load(tmp_path / f"one.{kind}")
    for name in RANGES:
        found = getattr(two.limits, name)[0]
        if lost:
            assert found in (getattr(one.limits, name)[0], np.inf, -np.inf)
        else:
            assert found == getattr(one.limits, name)[0], name


def test_several_bodies_that_float_in_sdf(tmp_path):
    """SDF names no free joints: each floats whom nothing holds."""
    bodies = "".join(
        f"[[link]]\nname = '{name}'\nmass = {mass}\ncom = [0.1, 0.2, 0.3]\n"
        f"inertia = [0.4, 0, 0, 0.5, 0, 0.6]\n"
        for name, mass in (("one", 1.0), ("arm", 2.0), ("two", 3.0))
    )
    joints = "".join(
        f"[[joint]]\nname = '{name}'\nkind = '{kind}'\nparent = '{parent}'\n"
        f"child = '{child}'\n{rest}"
        for name, kind, parent, child, rest in (
            ("second", "free", "ground", "two", ""),
            ("first", "free", "ground", "one", ""),
            ("elbow", "revolute", "one", "arm", "axis = 'y'\n"),
        )
    )
    text = f"[[link]]\nname = 'ground'\n{bodies}{joints}"
    model = fb.load(text=text, format="toml")
    read, lost = after(model, "sdf", tmp_path)
    assert sum("floats" in x for x in lost) == 2
    same_motion(model, read, lost)


def test_a_loop_that_is_open_where_sdf_draws_it_is_lost():
    assert said(fb.losses(valued("five_bar"), "sdf"), "'tip_pin', which is left open")


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_joints_without_motor_stay_so_in_closed_chains(kind, tmp_path):
    read, _ = after(valued("five_bar"), kind, tmp_path)
    assert set(read.driven_names) == {"theta1", "theta2"}


# ---------------------------------------------------------------- more than a tree of joints
ARM = """
name = "arm"
[[link]]
name = "base"
{links}
[[link]]
name = "plate"
mass = 0.3
[[joint]]
name = "bolts"
kind = "fixed"
parent = "l3"
child = "plate"
origin = [0, 0, 0.1]
{joints}
"""
LINK = '[[link]]\nname = "l{k}"\nmass = 2\ncom = [0, 0.1, 0.2]\ninertia = [0.1, 0, 0, 0.2, 0, 0.15]'
HINGE = """[[joint]]
name = "j{k}"
kind = "revolute"
parent = "{parent}"
child = "l{k}"
origin = [0.1, 0, 0.3]
axis = "{axis}"
limits = {{ lower = -2, upper = 2, velocity = 3, effort = 90 }}
"""


@cache
def arm(several: bool = False) -> fb.Model:
    """A chain of five joints; several: of which the last follows the first two."""
    joints = [
        HINGE.format(k=k, axis=axis, parent=f"l{k - 1}" if k > 1 else "base")
        for k, axis in enumerate("zyxyz", 1)
    ]
    if several:
        joints[-1] = joints[-1].partition("limits")[0]
        joints[-1] += "mimic = { joints = { j1 = -1, j2 = 0.5 }, offset = 0.2 }"
    links = "\n".join(LINK.format(k=k) for k in range(1, 6))
    return fb.load(text=ARM.format(links=links, joints="\n".join(joints)), format="toml")


def test_masses_add_up_in_the_digits_that_were_given(tmp_path):
    """The sum of the floats 2.3 and 1.05 is 3.3499999999999996."""
    link = LINK.format(k=1).replace("mass = 2", "mass = 2.3")
    hinge = HINGE.format(k=1, axis="z", parent="base")
    text = (
        ARM.format(links=link, joints=hinge).replace("l3", "l1").replace("mass = 0.3", "mass = 0")
    )
    model = fb.load(text=text, format="toml").with_payload(1.05, frame="l1")
    assert model.mass == 3.35
    for kind in ("urdf", "sdf", "mjcf"):
        file = tmp_path / f"arm.{kind}"
        fb.save(model, file, lossy=True)
        assert re.search(r"\b3\.35\b", file.read_text(encoding="utf-8")), kind


@pytest.mark.parametrize(
    ("name", "numbers"),
    [("puma560", ("0.4508", "0.06975 0.01625 0.086")), ("stanford", ("0.312", "0.113"))],
)
def test_sums_of_lengths_and_moments_are_in_the_digits_that_were_given(name, numbers, tmp_path):
    """The sum of the floats 0.4318 and 0.019 is 0.45080000000000003; moments that break the
    triangle inequality by 0.0075 are raised by half of that each."""
    model = valued(name)
    for kind in ("urdf", "sdf", "mjcf"):
        file = tmp_path / f"arm.{kind}"
        fb.save(model, file, lossy=True)
        text = file.read_text(encoding="utf-8")
        assert not re.search(r"\d(0{9,}|9{9,})\d+\b", text), kind
        found = [x for x in numbers if re.search(rf"\b{re.escape(x)}\b", text)]
        assert found == [x for x in numbers if " " not in x or kind == "mjcf"], kind


def strutted(model: fb.Model) -> fb.Model:
    """With a spring between two frames, and a gas spring between two links."""
    model = model.with_frame("hook", [0.1, 0.4, 0.2], frame="base")
    model = model.with_frame("eye", [0.2, 0.1, 0.0], frame="plate")
    model = model.with_strut("spring", ("hook", "eye"), stiffness=70.0, rest=0.2, damping=3.0)
    return model.with_strut("gas", ("l1", "l4"), stiffness=80.0, rest=0.3, preload=-40.0)


def lossy(model: fb.Model) -> fb.Model:
    """With a gear that has an efficiency, and one with friction by its load."""
    model = model.with_drive("j3", rotor=2e-4, gear=100.0, efficiency=0.8, back_efficiency=0.7)
    return model.with_drive("j4", load_friction=0.1)


def flexible(model: fb.Model) -> fb.Model:
    return model.with_drive("j3", rotor=2e-4, gear=100.0).with_flexible_joint(
        "j3", stiffness=3e3, damping=2.0
    )


PARTS = {
    "struts": lambda: strutted(arm()),
    "several leaders": lambda: arm(several=True),
    "losses": lambda: lossy(arm()),
    "flexible": lambda: flexible(arm()),
    "all": lambda: flexible(lossy(strutted(arm(several=True)))),
}
LOST = {
    "struts": {"the struts spring and gas": "urdf sdf csv", "preload of the strut 'gas'": "mjcf"},
    "losses": dict.fromkeys(
        ("the load-dependent friction of j4", "the efficiency of the gear, the motor driving"),
        "urdf sdf mjcf csv",
    ),
    "flexible": {
        "that j3_twist has no motor": "urdf sdf mjcf csv",
        "the stiffness of the spring of j3_twist": "urdf csv",
        "that j3_rotor has no mass": "mjcf",
    },
    "several leaders": {"has no mass": "mjcf"},
}
"""What is said of each part, and in which formats."""
LOST["all"] = {key: kinds for part in LOST.values() for key, kinds in part.items()}
del LOST["all"]["has no mass"], LOST["all"]["that j3_rotor has no mass"]


@pytest.mark.parametrize("part", PARTS)
def test_toml_holds_every_part(part, tmp_path):
    model = PARTS[part]()
    fb.save(model, tmp_path / "arm.toml")
    read = fb.load(tmp_path / "arm.toml")
    assert read == model
    assert fb.losses(model, "toml") == []
    assert read.strut_names == model.strut_names
    assert read.fixed_joint_names == ("bolts",)
    assert [x.joint.drive for x in read.bodies] == [x.joint.drive for x in model.bodies]
    assert fb.doctor(tmp_path / "arm.toml").of("error") == ()


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", FORMATS)
@pytest.mark.parametrize("part", PARTS)
def test_every_part_is_held_or_named(part, kind, tmp_path):
    """And what is left moves as before, and is the same robot but for what is told."""
    model = PARTS[part]()
    if kind == "csv" and part in ("several leaders", "all"):
        with pytest.raises(fb.FreebodyError, match="'j5_j1' follows another"):
            fb.losses(model, kind)
        return
    read, lost = after(model, kind, tmp_path)
    assert [key for key in LOST[part] if said(lost, key)] == [
        key for key, kinds in LOST[part].items() if kind in kinds.split()
    ]
    assert said(lost, "the name of the fixed joint bolts") == (kind in ("mjcf", "csv"))
    if kind in ("urdf", "sdf"):
        assert "bolts" in read.fixed_joint_names
    same_motion(model, read, lost)
    found = fb.same_robot(model, read)
    unlike = {x.place[0] for x in found.differences if x.size > 1e-14}  # kg, of bodies without mass
    expected = {"j3_twist"} if said(lost, "j3_twist has no motor") else set()
    if said(lost, "the struts"):
        expected |= {"spring", "gas"}
    assert unlike == expected, str(found)
    told = "\n".join(found.regardless)
    assert ("load-dependent friction" in told) == said(lost, "the load-dependent friction")


def test_mujoco_pulls_as_the_struts_do(tmp_path):
    """Springs, dampers, and a preload in the rest length."""
    mujoco = extra("mujoco")
    model = strutted(arm())
    read, lost = after(model, "mjcf", tmp_path)
    assert said(lost, "with the rest length 0.8 m, which is written, its spring has the same force")
    q, qd, _ = fb.random_state(model, 3)
    close(fb.bias(read, q, qd), fb.bias(model, q, qd), 1e-12)
    fb.save(model, tmp_path / "robot.xml", lossy=True)
    theirs = mujoco.MjModel.from_xml_path(str(tmp_path / "robot.xml"))
    data = mujoco.MjData(theirs)
    data.qpos[:], data.qvel[:] = q, qd
    mujoco.mj_forward(theirs, data)
    own = fb.bias(model, q, qd) - fb.bias(model.without("struts"), q, qd)
    close(data.qfrc_passive, -own, 1e-12)


def test_struts_that_mujoco_does_not_have(tmp_path):
    model = arm().with_strut("pull", ("l1", "l3"), preload=4.0)
    model = model.with_strut("soft", ("l1", "l4"), stiffness=10.0, rest=0.1, preload=4.0)
    model = model.with_strut("piston", ("l1", "l5"), damping=2.0, preload=4.0)
    model = model.with_strut("rod", ("base", "l5"))
    read, lost = after(model, "mjcf", tmp_path)
    assert said(lost, "the strut 'pull', which is a preload alone")
    assert said(lost, "the preload of the strut 'soft', which no rest length stands for")
    assert said(lost, "the preload of the strut 'piston', which no rest length stands for")
    assert said(lost, "the strut 'rod', which has no force")
    assert read.strut_names == ("soft", "piston")
    found = fb.same_robot(model, read)
    assert {x.place[0] for x in found.differences} == {"pull", "soft", "piston", "rod"}


def test_a_fixed_joint_has_the_name_of_a_link_in_no_sdf(tmp_path):
    text = ARM.format(links=LINK.format(k=3), joints=HINGE.format(k=3, axis="z", parent="base"))
    model = fb.load(text=text.replace("bolts", "plate"), format="toml")
    assert model.fixed_joint_names == ("plate",)
    read, lost = after(model, "sdf", tmp_path)
    assert said(lost, "the name of joint 'plate', which a link has: 'plate_joint' is written")
    assert read.fixed_joint_names == ("plate_joint",)
    assert after(model, "urdf", tmp_path)[0].fixed_joint_names == ("plate",)


# ---------------------------------------------------------------- as others read it
@pytest.mark.parametrize("name", ["ur5e", "scara"])
@pytest.mark.parametrize("kind", ["urdf", "sdf"])
def test_drake_reads_the_same_robot(name, kind, tmp_path):
    """With its rotors, whose names are Drake's."""
    plants = extra("pydrake.multibody.plant", "drake")
    parsing = extra("pydrake.multibody.parsing", "drake")
    model, file = valued(name), tmp_path / f"robot.{kind}"
    model = model.with_drive(model.joint_names[1], rotor=2e-5, gear=-101.0)
    fb.save(model, file, lossy=True)
    plant = plants.MultibodyPlant(0.0)
    parsing.Parser(plant).AddModels(str(file))
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName(model.frame_names[0]))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    q, qd, _ = fb.random_state(model, 2)
    at = [plant.GetJointByName(joint).velocity_start() for joint in model.joint_names]
    there, rates = np.empty_like(q), np.empty_like(qd)
    there[at], rates[at] = q, qd
    plant.SetPositions(context, there)
    plant.SetVelocities(context, rates)
    M = plant.CalcMassMatrix(context)[np.ix_(at, at)]
    close(M, fb.mass_matrix(model, q), 1e-12)
    turning = plant.CalcBiasTerm(context) - plant.CalcGravityGeneralizedForces(context)
    bare = model.without("friction")
    close(turning[at], fb.bias(bare, q, qd), 1e-11)
    lower = plant.GetPositionLowerLimits()[at]
    assert lower.tolist() == model.limits.lower.tolist()


@pytest.mark.parametrize("name", ["ur5e", "scara", "stewart"])
def test_mujoco_reads_the_same_robot(name, tmp_path):
    mujoco = extra("mujoco")
    model, file = valued(name).opened, tmp_path / "robot.xml"
    fb.save(model, file, lossy=True)
    theirs = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(theirs)
    joints = [theirs.joint(k).name for k in range(theirs.njnt)]
    if name != "stewart":
        q, qd, _ = fb.random_state(model, 2)
        assert tuple(joints) == model.joint_names
        data.qpos[:], data.qvel[:] = q, qd
        mujoco.mj_forward(theirs, data)
        M = np.zeros((theirs.nv, theirs.nv))
        mujoco.mj_fullM(theirs, data, M)
        close(M, fb.mass_matrix(model, q), 1e-12)
        close(data.qfrc_bias, fb.bias(model.without("friction"), q, qd), 1e-11)
    else:
        assert theirs.nv == model.nv
        close(theirs.body_mass.sum(), model.mass, 1e-12)


# ---------------------------------------------------------------- what is refused
def test_what_is_refused(tmp_path):
    model = fb.load("ur5e")
    with pytest.raises(fb.FreebodyError, match=r"must end in \.toml, \.urdf"):
        fb.save(model, tmp_path / "robot.obj")
    with pytest.raises(fb.UnknownNameError, match="no format 'urfd'"):
        fb.losses(model, "urfd")
    with pytest.raises(fb.FreebodyError, match="a DH table is one serial arm"):
        fb.save(fb.load("3RRR"), tmp_path / "robot.csv")
    with pytest.raises(fb.FreebodyError, match="l1"):
        fb.save(fb.load("2R").bind(l1=None), tmp_path / "robot.urdf")
    family = model.with_payload([1.0, 2.0])
    with pytest.raises(fb.FreebodyError, match="family"):
        fb.losses(family, "sdf")


def test_names_are_data_and_xml_keeps_them(tmp_path):
    """Quotes, angle brackets and ampersands are kept; control characters are refused."""
    odd = 'a"<b>&amp;c'
    model = fb.dh([{"joint": "R", "a": 1, "m": 1, "name": odd}], convention="standard", name=odd)
    for kind in ("urdf", "sdf", "mjcf"):
        read, _ = after(model, kind, tmp_path)
        assert read.name == odd
        assert odd in read.frame_names
    told = fb.dh([{"joint": "R", "a": 1, "m": 1}], convention="standard", name="a\x07b")
    with pytest.raises(fb.FreebodyError, match="is no name in URDF"):
        fb.losses(told, "urdf")


def test_a_dh_table_is_fitted_to_the_axes(tmp_path):
    """And says how well; skew axes, base and tool of a random arm come back."""
    model = fb.load("ur5e").with_tool("pen", [0.1, 0.2, 0.3], np.diag([1.0, -1.0, -1.0]))
    fb.save(model, tmp_path / "arm.csv", lossy=True)
    text = (tmp_path / "arm.csv").read_text(encoding="utf-8")
    assert "# fitted to the axes of the joints, which are off by at most" in text
    assert "# tool: " in text


def test_a_dh_table_has_its_coordinates_from_the_base_outwards(tmp_path):
    joints = [
        HINGE.format(k=k, axis="y", parent=f"l{k - 1}" if k > 1 else "base") for k in (3, 2, 1)
    ]
    links = "\n".join(LINK.format(k=k) for k in range(1, 4))
    model = fb.load(text=ARM.format(links=links, joints="\n".join(joints)), format="toml")
    assert model.joint_names == ("j3", "j2", "j1")
    read, lost = after(model, "csv", tmp_path)
    assert said(lost, "the order of its coordinates, which is that from the base outwards: j1, j2")
    assert read.joint_names == ("j1", "j2", "j3")
    same_motion(model, read, lost)
    inner = fb.losses(model.replace(tip="l2"), "csv")
    assert said(inner, "the tip 'l2', which the last joint does not move")
    assert said(inner, "plate")


def test_angles_near_right_ones_are_a_loss_by_name(tmp_path):
    turned = np.eye(3)
    turned[:2, :2] = [[1.0, -1e-9], [1e-9, 1.0]]
    model = fb.load("ur5e").with_tool("pen", [0.1, 0.2, 0.3], turned)
    assert said(fb.losses(model, "urdf"), "snap_angles=0")


@pytest.mark.parametrize("kind", ["urdf", "sdf"])
def test_a_yaw_of_rounding_near_a_right_pitch_is_none(kind, tmp_path):
    """As 1.5708, six digits of a right angle, makes it, on which the other angles hang."""
    roll = pitch = 1.5708
    c, s = np.cos(pitch), np.sin(pitch)
    turned = np.array([[c, 0, s], [0, 1, 0], [-s, 0, c]])
    turned = turned @ [[1, 0, 0], [0, np.cos(roll), -np.sin(roll)], [0, np.sin(roll), np.cos(roll)]]
    for noise in (0.0, 1e-16, -1e-16):
        turned[1, 0] = noise
        model = arm().with_tool("pen", [0.1, 0.2, 0.3], turned)
        read, lost = after(model, kind, tmp_path)
        assert not said(lost, "snap_angles=0")
        same_motion(model, read, lost)


def test_the_command(tmp_path, capsys):
    file = tmp_path / "arm.urdf"
    assert run(["convert", "ur5e", str(file)]) == 0
    assert fb.load(file).mass == fb.load("ur5e").mass
    assert run(["convert", "2R", str(tmp_path / "2R.urdf")]) == 2
    assert "would be lost in .urdf: the plane" in capsys.readouterr().err
    assert run(["convert", "2R", str(tmp_path / "2R.urdf"), "--lossy"]) == 0
    assert "lost: the plane" in capsys.readouterr().out
