"""Models written as URDF, SDF, MJCF and DH tables: read again they move as before, and what a
format cannot hold is told before anything is written."""

from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from support.command import run
from support.extras import extra
from support.generate import model as generated
from support.helpers import all_driven, close, numbers, poses
from support.real_files import FILES, REFUSED, ROBOTS

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FORMATS = ("urdf", "sdf", "mjcf", "csv")
RANGES = ("lower", "upper", "velocity", "effort")
FEW = ("ur5e", "panda", "five_bar", "puma560", "quadrotor")


def valued(name: str) -> fb.Model:
    """A bundled model with a value for every number."""
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
    if said(lost, "and its force"):
        model = model.without("struts")
    return model


def renamed(name: str, one: fb.Model, two: fb.Model) -> str:
    """A coordinate's name after a file: SDF names no free joints, and none as a link."""
    joint, dot, rest = name.partition(".")
    kind = next((body.joint.kind for body in one.bodies if body.joint.name == joint), "")
    if name in (*two.position_names, *two.velocity_names):
        return name
    if kind != "free":
        return f"{joint}_joint{dot}{rest}"
    return f"{two.joint_names[-1]}.{rest}"


def same_motion(one: fb.Model, two: fb.Model, lost: list[str]) -> None:
    """The same mass matrix, bias and limits, coordinate by coordinate, and frames at the same
    places."""
    one, two = left(one, lost).opened, two.opened
    q, qd, _ = fb.random_state(one, 5, 2)
    if said(lost, "joints of one coordinate"):
        # rates of the joints that were taken apart are others
        assert (one.nq, one.nv) == (two.nq, two.nv)
        place, at = list(range(one.nq)), list(range(one.nv))
        if said(lost, "order of its coordinates"):
            return
    else:
        place = [two.position_names.index(renamed(x, one, two)) for x in one.position_names]
        at = [two.velocity_names.index(renamed(x, one, two)) for x in one.velocity_names]
        assert at == sorted(at) or said(lost, "order of its coordinates") or said(lost, "the last")
    there, rates = np.empty_like(q), np.empty_like(qd)
    there[:, place], rates[:, at] = q, qd
    if one.nv == 0:
        close(two.mass, one.mass, 1e-12, what="mass")
        return
    if not said(lost, "which does not move") and not said(lost, "which is the ground"):
        close(two.mass, one.mass, 1e-12, what="mass")
    rise, own_rise = (
        np.diff(numbers(m, "potential_energy", x)) for m, x in ((two, there), (one, q))
    )
    close(rise, own_rise, 1e-12, 1e-3 * one.mass, what="potential energy")
    if not said(lost, "no rigid body has") and not said(lost, "joints of one coordinate"):
        M = numbers(two, "mass_matrix", there)[:, at][:, :, at]
        bias = numbers(two, "bias", there, rates)[:, at]
        close(M, numbers(one, "mass_matrix", q), 1e-12, 1e-3, what="mass matrix")
        close(bias, numbers(one, "bias", q, qd), 1e-12, 1e-3, what="bias")
    for name in RANGES:
        if name != "velocity" or not said(lost, "speed limit"):
            found, own_limits = getattr(two.limits, name)[at], getattr(one.limits, name)
            kept = np.full(one.nv, True)
            if said(lost, "which is a point"):
                kept = one.limits.lower < one.limits.upper
            assert found[kept].tolist() == own_limits[kept].tolist(), name
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


@pytest.mark.parametrize("name", FEW)
def test_bundled_models_through_every_pair_of_formats(name, tmp_path):
    every_pair(valued(name), tmp_path)


@pytest.mark.long
@pytest.mark.parametrize("name", [name for name in fb.models() if name not in FEW])
def test_all_bundled_models_through_every_pair_of_formats(name, tmp_path):
    every_pair(valued(name), tmp_path)


@pytest.mark.long
@pytest.mark.filterwarnings("ignore::UserWarning")
@pytest.mark.parametrize("name", [name for name in FILES if name not in REFUSED])
def test_real_files_through_every_pair_of_formats(name, tmp_path):
    every_pair(fb.load(ROBOTS / name, physical="ignore"), tmp_path)


@pytest.mark.parametrize("seed", range(6))
def test_generated_mechanisms_in_every_format(seed, tmp_path):
    """Trees of every kind of joint, with every law of drives."""
    model = generated(seed)
    for kind in FORMATS:
        found = again(model, kind, tmp_path)
        if found is not None:
            same_motion(model, *found)


# ---------------------------------------------------------------- closed chains
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


def test_a_strut_is_a_tendon_of_mjcf_and_a_loss_elsewhere(tmp_path):
    gas = {"stiffness": 300.0, "rest": 0.4, "damping": 12.0, "preload": -60.0}
    arm = valued("ur5e").with_strut("gas", ("base", "forearm_link"), **gas)
    for kind in ("urdf", "sdf", "csv"):
        assert said(fb.losses(arm, kind), "the strut 'gas' and its force"), kind
    read, lost = after(arm, "mjcf", tmp_path)
    same_motion(arm, read, lost)
    assert said(lost, "its force is written as that of a spring with the rest length 0.6 m")
    q, qd, qdd = fb.random_state(arm, 5, 2)
    for found, own in zip(fb.strut_states(read, q, qd), fb.strut_states(arm, q, qd), strict=True):
        close(found, own, 1e-12, 1.0, what="strut")
    close(
        numbers(read, "inverse_dynamics", q, qd, qdd),
        numbers(arm, "inverse_dynamics", q, qd, qdd),
        1e-12,
        1.0,
        what="torques",
    )


@pytest.mark.parametrize("spring", [{}, {"stiffness": 300.0, "rest": 0.1}])
def test_a_preload_that_no_rest_length_makes_is_lost_in_mjcf(spring):
    arm = valued("ur5e").with_strut("gas", ("base", "forearm_link"), **spring, preload=60.0)
    assert "the preload of the strut 'gas'" in fb.losses(arm, "mjcf")


def test_a_loop_that_is_open_where_sdf_draws_it_is_lost():
    assert said(fb.losses(valued("five_bar"), "sdf"), "'tip_pin', which is left open")


@pytest.mark.parametrize("kind", ["urdf", "mjcf"])
def test_joints_without_motor_stay_so_in_closed_chains(kind, tmp_path):
    read, _ = after(valued("five_bar"), kind, tmp_path)
    assert set(read.driven_names) == {"theta1", "theta2"}


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


def test_angles_near_right_ones_are_a_loss_by_name(tmp_path):
    turned = np.eye(3)
    turned[:2, :2] = [[1.0, -1e-9], [1e-9, 1.0]]
    model = fb.load("ur5e").with_tool("pen", [0.1, 0.2, 0.3], turned)
    assert said(fb.losses(model, "urdf"), "snap_angles=0")


def test_the_command(tmp_path, capsys):
    file = tmp_path / "arm.urdf"
    assert run(["convert", "ur5e", str(file)]) == 0
    assert fb.load(file).mass == fb.load("ur5e").mass
    assert run(["convert", "2R", str(tmp_path / "2R.urdf")]) == 2
    assert "would be lost in .urdf: the plane" in capsys.readouterr().err
    assert run(["convert", "2R", str(tmp_path / "2R.urdf"), "--lossy"]) == 0
    assert "lost: the plane" in capsys.readouterr().out
