"""MJCF files: the same equations of motion as MuJoCo's own, and what is left out is named."""

import warnings

import numpy as np
import pytest

import freebody as fb
from support.extras import extra

mujoco = extra("mujoco")
pytestmark = pytest.mark.usefixtures("numpy_kernels")

BOX = '<geom type="box" size="0.05 0.1 0.2" pos="0.1 0 0.05" euler="20 30 40" mass="1.3"/>'
ARMS = {
    "hinge": f'<body name="a" pos="1 2 3" euler="10 20 30"><joint axis="1 2 3"/>{BOX}</body>',
    "away from the origin": f'<body pos="0 0 1"><joint axis="0 1 0" pos="0.3 0 0.1"/>{BOX}'
    f'<body pos="0.5 0 0"><joint axis="1 0 1" pos="0 0.2 0"/>{BOX}</body></body>',
    "several in one body": f'<body pos="0 0 1" euler="0 0 90"><joint axis="0 1 0" pos="0.3 0 0.1"/>'
    f'<joint type="slide" axis="1 1 0"/><joint axis="0 0 1" pos="0 0.1 0"/>{BOX}</body>',
    "reference": f'<body pos="0 0 1"><joint axis="0 1 0" ref="30"/>{BOX}<body pos="0.5 0 0">'
    f'<joint type="slide" axis="1 0 1" ref="0.4"/>{BOX}</body></body>',
    "spring and damper": f'<body><joint axis="0 1 0" stiffness="7" springref="20" damping="0.3" '
    f'armature="0.2"/>{BOX}</body>',
    "powers of spring and damper": f'<body><joint axis="0 1 0" stiffness="0 0 5" springref="20" '
    f'ref="10" damping="0.3 0.4"/>{BOX}</body>',
    "ball": f'<body><joint type="ball" pos="0 0 0.1"/>{BOX}<body pos="0 0 1"><joint axis="1 0 0"/>'
    f"{BOX}</body></body>",
    "welded": f'<body><joint axis="0 1 0"/>{BOX}<body pos="1 0 0" euler="0 40 0">{BOX}</body>'
    "</body>",
    "two trees": f'<body><joint axis="0 1 0"/>{BOX}</body><body><joint axis="1 0 0"/>{BOX}</body>',
}


def mjcf(bodies, rest="", option=""):
    return f'<mujoco model="arm"><option {option}/><worldbody>{bodies}</worldbody>{rest}</mujoco>'


def theirs(text, q, v, a):
    """MuJoCo's mass matrix and the forces of inverse dynamics, passive ones included."""
    model = mujoco.MjModel.from_xml_string(text)
    model.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data = mujoco.MjData(model)
    data.qpos[:], data.qvel[:], data.qacc[:] = q, v, a
    mujoco.mj_inverse(model, data)
    M = np.zeros((model.nv, model.nv))
    mujoco.mj_fullM(model, data, M)
    return M, data.qfrc_inverse


@pytest.mark.sample(1)
@pytest.mark.parametrize("arm", ARMS)
def test_equations_are_those_of_mujoco(arm):
    text = mjcf(ARMS[arm])
    model = fb.load(text=text, format="mjcf")
    rng = np.random.default_rng(3)
    for _ in range(5):
        q, v, a = rng.normal(size=model.nq), rng.normal(size=model.nv), rng.normal(size=model.nv)
        if arm == "ball":
            q[:4] /= np.linalg.norm(q[:4])
        M, tau = theirs(text, q, v, a)
        np.testing.assert_allclose(fb.mass_matrix(model, q), M, atol=1e-12)
        np.testing.assert_allclose(fb.inverse_dynamics(model, q, v, a), tau, atol=1e-11)


def test_a_free_body():
    """Same pose; MuJoCo's linear rate is in the world's axes, freebody's in the body's."""
    text = mjcf(f'<body pos="0 0 1" euler="5 6 7"><freejoint/>{BOX}</body>')
    model = fb.load(text=text, format="mjcf")
    q = np.array([0.1, 0.2, 0.3, 0.5, 0.5, -0.5, 0.5])
    M, _ = theirs(text, q, np.zeros(6), np.zeros(6))
    w, x, y, z = q[3:]
    R = np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )
    T = np.eye(6)
    T[:3, :3] = R
    np.testing.assert_allclose(fb.mass_matrix(model, q), T.T @ M @ T, atol=1e-12)


def test_friction_limits_and_actuators():
    text = mjcf(
        f'<body name="a"><joint name="j" axis="0 1 0" range="-30 60" limited="true" '
        f'frictionloss="0.4"/>{BOX}<body name="b"><joint name="k" axis="1 0 0"/>{BOX}</body>'
        "</body>",
        '<actuator><motor joint="j" gear="50" ctrllimited="true" ctrlrange="-1 2"/>'
        '<position joint="k" forcelimited="true" forcerange="-3 3" kp="9"/></actuator>',
    )
    model = fb.load(text=text, format="mjcf")
    j, k = (body.joint for body in model.bodies)
    assert (j.limits.lower, j.limits.upper) == pytest.approx((-np.pi / 6, np.pi / 3))
    assert (j.limits.effort, k.limits.effort) == (100.0, 3.0)
    idle = fb.load(text=text.replace('gear="50" ctrllimited="true"', 'gear="0"'), format="mjcf")
    assert idle.limits.effort.tolist() == [0.0, 3.0]  # no force reaches the joint
    at_rest = fb.inverse_dynamics(model, [0.2, 0.1], [1e-3, 0.0], [0.0, 0.0])
    back = fb.inverse_dynamics(model, [0.2, 0.1], [-1e-3, 0.0], [0.0, 0.0])
    assert (at_rest - back)[0] == pytest.approx(0.8, abs=1e-9)


@pytest.mark.parametrize(
    ("given", "left_out"),
    [
        ('stiffness="7 3 5"', "the second power of its spring"),
        ('damping="0.3 0.2 0.1"', "the third power of its damper"),
    ],
)
def test_powers_that_are_no_law_are_named(given, left_out):
    text = mjcf(f'<body><joint name="j" axis="0 1 0" {given}/>{BOX}</body>')
    model = fb.load(text=text, format="mjcf")
    assert f"text: joint 'j': {left_out} is left out." in [str(x) for x in model.notices]


def test_gravity_and_what_is_left_out():
    arm = ARMS["hinge"]
    none = fb.load(text=mjcf(arm, option='gravity="0 0 0"'), format="mjcf")
    off = fb.load(
        text=mjcf(arm).replace("/><w", '><flag gravity="disable"/></option><w'), format="mjcf"
    )
    for model in (none, off):
        assert np.allclose(fb.gravity_torque(model, [0.3]), 0)
    side = fb.load(text=mjcf(arm, option='gravity="1 2 2"'), format="mjcf")
    assert np.linalg.norm(side.gravity) == pytest.approx(3.0)
    told = fb.load(
        text=mjcf(
            arm.replace("<joint", '<site name="s" pos="0.1 0 0"/><joint').replace(
                'name="a"', 'name="a" gravcomp="1"'
            ),
            '<tendon><spatial limited="true" range="0 1"><site site="s"/><site site="t"/></spatial>'
            "</tendon>",
            'density="1.2"',
        ).replace("</worldbody>", '<site name="t" pos="0 0 3"/></worldbody>'),
        format="mjcf",
    )
    text = " ".join(str(notice) for notice in told.notices)
    for part in (
        "length of tendons are left out: tendon1",
        "a fluid",
        "gravity compensation of a",
        "contacts",
    ):
        assert part in text
    assert {"s", "t"} <= set(told.frame_names)


ROD = '<geom type="capsule" size="0.01" fromto="0 0 0 {} {} 0" mass="{}"/>'
HEIGHT = 3 * np.sin(np.radians(40))
REACH = 1 + 3 * np.cos(np.radians(40))
FOUR_BAR = f"""<body name="crank"><joint name="drive" axis="0 0 1"/>{ROD.format(1, 0, 1)}
<body name="coupler" pos="1 0 0" euler="0 0 40"><joint name="pin" axis="0 0 1"/>
{ROD.format(3, 0, 3)}</body></body><body name="rocker" pos="{REACH} 0 0">
<joint name="swing" axis="0 0 1"/>{ROD.format(0, HEIGHT, 2)}</body>"""
STIFF = 'solref="0.002 1" solimp="0.99999 0.99999 0.001"'
CLOSINGS = {
    "connect": f'<connect name="close" body1="coupler" body2="rocker" anchor="3 0 0" {STIFF}/>',
    "connect from the other side": f'<connect name="close" body1="rocker" body2="coupler" '
    f'anchor="0 {HEIGHT} 0" {STIFF}/>',
}


@pytest.mark.sample(1)
@pytest.mark.parametrize("closing", CLOSINGS)
def test_a_loop_of_a_connect(closing):
    """A four-bar in the plane of gravity, closed by a connect, falls as in MuJoCo, whose
    constraints are a little soft."""
    text = mjcf(
        FOUR_BAR,
        f"<equality>{CLOSINGS[closing]}</equality>"
        '<actuator><motor joint="drive" gear="1"/></actuator>',
        'gravity="0 -9.81 0"',
    )
    model = fb.load(text=text, format="mjcf")
    assert [body.joint.passive for body in model.bodies] == [False, True, True]
    assert fb.mobility(model, np.zeros(3)).instantaneous == 1
    theirs = mujoco.MjModel.from_xml_string(text)
    theirs.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    data = mujoco.MjData(theirs)
    data.ctrl[:] = 2.5
    mujoco.mj_forward(theirs, data)
    found = fb.forward_dynamics(model, np.zeros(3), np.zeros(3), [2.5, 0.0, 0.0])
    np.testing.assert_allclose(found, data.qacc, rtol=2e-3)


def test_a_loop_of_a_weld():
    """Two arms whose ends are welded together cannot move."""
    text = mjcf(
        f'<body name="a"><joint axis="0 0 1"/>{ROD.format(1, 0, 1)}</body>'
        '<body name="b" pos="2 0 0" euler="0 0 30"><joint axis="0 0 1"/>'
        f"{ROD.format(1, 0, 1)}</body>",
        '<equality><weld body1="a" body2="b"/></equality>',
    )
    model = fb.load(text=text, format="mjcf")
    assert model.loops[0].kind == "fixed"
    assert fb.assemble(model, np.zeros(2)) == pytest.approx(np.zeros(2), abs=1e-12)
    assert fb.mobility(model, np.zeros(2)).instantaneous == 0


def test_what_joins_parts_of_one_body_is_left_out():
    """A spring and a connect between bodies that are welded together do nothing."""
    text = mjcf(
        f'<site name="w"/><body name="a"><joint axis="0 1 0"/>{BOX}<site name="s"/><body name="b" '
        f'pos="1 0 0">{BOX}<site name="t"/></body></body>',
        '<tendon><spatial name="cord" stiffness="9"><site site="s"/><site site="t"/></spatial>'
        '</tendon><equality><connect name="pin" body1="a" body2="b" anchor="1 0 0"/></equality>',
    )
    model = fb.load(text=text, format="mjcf")
    told = [str(notice) for notice in model.notices]
    assert "text: the tendon 'cord' is between parts of one body, and is left out." in told
    assert "text: the equality 'pin' joins parts of one body, and is left out." in told
    assert not model.loops
    assert not model.struts


def test_equalities_of_joints():
    bodies = (
        f'<body><joint name="lead" axis="0 1 0" ref="10"/>{BOX}</body>'
        f'<body pos="1 0 0"><joint name="follow" axis="0 1 0" ref="20"/>{BOX}</body>'
    )
    equality = '<equality><joint joint1="follow" joint2="lead" polycoef="0.1 2 0 0 0"/></equality>'
    model = fb.load(text=mjcf(bodies, equality), format="mjcf")
    follower = next(b.joint for b in model.bodies if b.joint.name == "follow")
    assert follower.mimic.ratio == 2.0
    assert follower.mimic.offset == pytest.approx(np.radians(20) + 0.1 - 2 * np.radians(10))
    assert model.nv == 1
    curved = fb.load(text=mjcf(bodies, equality.replace("2 0 0 0", "2 -0.7 0 0")), format="mjcf")
    turned = 0.1 + 2 * 0.3 - 0.7 * 0.3**2  # from where the file draws it
    T = fb.forward_kinematics(curved, [np.radians(10) + 0.3], curved.bodies[1].name)
    assert np.arctan2(T[0, 2], T[0, 0]) == pytest.approx(turned)


FINGERS = "".join(
    f'<body name="b{k}" pos="{k} 0 0"><joint name="j{k}" axis="0 1 0" ref="{10 * k}"/>{BOX}'
    for k in (1, 2, 3)
)
FIXED = """<tendon><fixed name="one"><joint joint="j1" coef="0.4"/><joint joint="j3" coef="-0.8"/>
</fixed><fixed name="two"><joint joint="j2" coef="5"/></fixed></tendon><equality>{}</equality>"""


def test_equalities_of_fixed_tendons():
    """A fixed tendon adds up joints: where MuJoCo holds its length, its last joint follows."""
    given = FIXED.format('<tendon tendon1="one" tendon2="two" polycoef="0.1 2 0 0 0"/>')
    text = mjcf(FINGERS + "</body>" * 3, given)
    model = fb.load(text=text, format="mjcf")
    assert model.nv == 2
    lead = {"j1": 0.3, "j2": -0.2}
    mimics = [body.joint.mimic for body in model.bodies if body.joint.mimic]  # one for each leader
    turned = sum(x.ratio * lead[x.joint] + x.offset for x in mimics)
    theirs = mujoco.MjModel.from_xml_string(text)
    data = mujoco.MjData(theirs)
    data.qpos[:] = [*lead.values(), turned]
    mujoco.mj_forward(theirs, data)
    assert data.efc_pos[:1] == pytest.approx([0.0], abs=1e-14)
    held = FIXED.format('<tendon tendon1="two"/>')
    with pytest.raises(fb.FreebodyError, match="'j2' is held in its place"):
        fb.load(text=mjcf(FINGERS + "</body>" * 3, held), format="mjcf")
    twice = '<joint joint1="j3" joint2="j1"/>' * 2 + '<joint joint1="j3"/>'
    with pytest.raises(fb.FreebodyError, match="'j3' is held in its place"):
        fb.load(text=mjcf(FINGERS + "</body>" * 3, FIXED.format(twice)), format="mjcf")


def test_a_tendon_whose_ends_are_at_one_point_is_left_out():
    """A point on a hinge's axis stays where it is; what else the file holds is read."""
    text = mjcf(
        f'<site name="s" pos="0 0 1"/><site name="w" pos="1 0 1"/><body name="a" pos="0 0 1">'
        f'<joint name="j" axis="0 1 0"/>{BOX}<site name="t" pos="0 0 0"/></body>',
        '<tendon><spatial name="none" stiffness="5"><site site="s"/><site site="t"/></spatial>'
        '<spatial name="some" stiffness="5"><site site="w"/><site site="t"/></spatial></tendon>',
    )
    model = fb.load(text=text, format="mjcf")
    assert (model.joint_names, model.strut_names) == (("j",), ("some",))
    told = "warning: the tendon 'none' is between two sites that are always at one point, and is"
    assert any(told in str(x) for x in model.notices)


def test_what_is_left_out_of_many_parts_is_told_once():
    joints = "".join(f'<joint joint="j{k}" coef="1"/>' for k in (1, 2, 3))
    tendons = "".join(
        f'<fixed name="t{k}" stiffness="{k}" range="0 1" limited="true">{joints}</fixed>'
        for k in range(9)
    )
    base = f'<body><joint name="float" type="free" armature="0.2"/>{BOX}'
    text = mjcf(base + FINGERS + "</body>" * 4, f"<tendon>{tendons}</tendon>")
    told = [x.text for x in fb.load(text=text, format="mjcf").notices if "left out" in x.text]
    assert len(told) == 3
    assert told[0] == "warning: armature of free and ball joints is left out: float."
    assert told[1].endswith("tendons are left out: t0, t1, t2, t3 and 5 more.")
    assert told[2].endswith("is left out: t1, t2, t3, t4 and 4 more.")


@pytest.mark.sample(5)
@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<mujoco><worldbody/></mujoco>", "it has no bodies.* is loaded by one of those"),
        ("<mujoco><worldbody><body/></mujoco>", "not well-formed"),
        (mjcf('<body><joint axis="0 0 0"/></body>'), "MuJoCo does not compile it"),
        (mjcf(BOX + "<wrong/>"), "MuJoCo does not compile it: Schema violation: unrecognized"),
        (
            mjcf('<include file="none.xml"/>'),
            "compile it: Error opening file '.*none.xml'; Element 'include'[^:]*. Put that file",
        ),
        (mjcf('<geom size="1" material="m"/>'), "'m' not found in .* Correct the name"),
        ("<mujoco><asset/></mujoco>", "a part that others include; load one that does"),
        ("<sdf/>", "the root element is <sdf>, expected <mujoco>"),
        ("<mujocoinclude/>", "load one that includes it"),
    ],
)
def test_refusals(text, told):
    with pytest.raises(fb.FreebodyError, match=told):
        fb.load(text=text, format="mjcf")


def test_a_crash_of_the_parser_is_an_error(monkeypatch):
    """The process that parses may end, the user's does not."""
    import signal
    import subprocess

    def killed(command, **how):
        return subprocess.CompletedProcess(command, -signal.SIGSEGV, b"", b"")

    monkeypatch.setattr(subprocess, "run", killed)
    with pytest.raises(fb.FreebodyError, match="MuJoCo ended while it compiled it"):
        fb.load(text=mjcf(ARMS["hinge"]), format="mjcf")


def test_files_with_includes_and_urdf_in_xml(tmp_path):
    (tmp_path / "parts.xml").write_text(f"<mujocoinclude>{ARMS['hinge']}</mujocoinclude>")
    path = tmp_path / "scene.xml"
    path.write_text(mjcf('<include file="parts.xml"/>'))
    assert fb.load(path).nv == 1
    (tmp_path / "robot.xml").write_text('<robot name="r"><link name="a"/></robot>')
    assert fb.load(tmp_path / "robot.xml").name == "r"
    with pytest.raises(fb.FreebodyError, match="package_path= is for URDF, xacro and SDF files"):
        fb.load(path, package_path=tmp_path)
    with pytest.raises(fb.FreebodyError, match="<mujocoinclude>"):
        fb.load(tmp_path / "parts.xml")


def test_inertias_that_mujoco_works_out_from_geoms_are_not_doubted():
    """Three equal balls of one chain are no placeholders, the same numbers in <inertial> are."""
    ball = '<geom type="sphere" size="0.1" mass="2"/>'
    stated = '<inertial pos="0 0 0" mass="2" diaginertia="0.01 0.01 0.01"/>'

    def doubted(inertia, option="auto"):
        bodies = "".join(f'<body pos="{k} 0 0"><joint axis="0 1 0"/>{inertia}' for k in (1, 2, 3))
        compiler = f'<compiler inertiafromgeom="{option}"/>'
        text = mjcf(bodies + "</body>" * 3).replace("<worldbody>", f"{compiler}<worldbody>")
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", fb.MassWarning)
            doubts = fb.load(text=text, format="mjcf").doubts
        return [doubt.kind for doubt in doubts if doubt.kind != "missing limits"]

    assert doubted(ball) == doubted(stated + ball, "true") == []
    assert doubted(stated + ball) == ["implausible inertias"]
