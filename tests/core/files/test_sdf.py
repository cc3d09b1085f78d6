"""SDF files: the same equations of motion as Drake reads from them, loops of second parents, and
what is wrong told with its line."""

import numpy as np
import pytest

import freebody as fb
from support.extras import extra

pytestmark = pytest.mark.usefixtures("numpy_kernels")

INERTIAL = (
    "<inertial><pose>0.1 0.2 0.3 0.1 0.2 0.3</pose><mass>{}</mass><inertia><ixx>0.3</ixx>"
    "<iyy>0.4</iyy><izz>0.5</izz><ixy>0.01</ixy><ixz>-0.02</ixz><iyz>0.03</iyz></inertia></inertial>"
)


def link(name, pose="", mass=1.5):
    return f'<link name="{name}">{pose}{INERTIAL.format(mass)}</link>'


def joint(name, parent, child, inside, kind="revolute"):
    return (
        f'<joint name="{name}" type="{kind}"><parent>{parent}</parent><child>{child}</child>'
        f"{inside}</joint>"
    )


def sdf(inside, version="1.7"):
    return f'<sdf version="{version}"><model name="arm">\n{inside}\n</model></sdf>'


Y = "<axis><xyz>0 1 0</xyz></axis>"
HAND = (
    link("palm", "<pose>0 0 0.1 0.2 0 0</pose>")
    + link("finger", '<pose relative_to="palm">0.1 0 0 0 0 0.3</pose>', 0.4)
    + '<frame name="grip" attached_to="finger"><pose>0 0 0.05 0 0 0</pose></frame>'
    + joint("open", "palm", "finger", '<axis><xyz expressed_in="__model__">0 0 1</xyz></axis>',
            "prismatic")
)  # fmt: skip
ARM = link("a", "<pose>0 0 1 0.1 0.2 0.3</pose>") + joint("j", "world", "a", Y)
AT = '<pose relative_to="a">0.3 0 0 0 0.5 0</pose>'
WRIST = joint("wrist", "a", "hand::palm", Y)
ROBOTS = {
    "poses of the model": sdf(
        link("a", "<pose>0 0 1 0.1 0.2 0.3</pose>")
        + link("b", "<pose>1 0 1 0 0.5 0</pose>")
        + joint("j", "world", "a", Y)
        + joint("k", "a", "b", "<axis><xyz>1 2 3</xyz></axis>")
    ),
    "poses of others": sdf(
        link("a", "<pose>0 0 1 0.1 0.2 0.3</pose>")
        + link("b", '<pose relative_to="a">1 0 1 0 0.5 0</pose>')
        + '<frame name="f" attached_to="a"><pose relative_to="b">0.1 0 0 0.4 0 0</pose></frame>'
        + joint("j", "world", "a", Y)
        + joint("k", "a", "b", '<axis><xyz expressed_in="f">0 0 1</xyz></axis>', "prismatic")
    ),
    "a joint away from its child": sdf(
        link("a")
        + link("b", "<pose>1 0 0 0 0 0</pose>")
        + joint("j", "world", "a", f"<pose>0.1 0.2 0.3 0.5 0 0</pose>{Y}")
        + joint("k", "a", "b", f'<pose relative_to="a">0.5 0 0.1 0 0.3 0</pose>{Y}')
    ),
    "degrees and quaternions": sdf(
        link("a", '<pose degrees="true">0 0 1 20 30 40</pose>')
        + link("b", '<pose rotation_format="quat_xyzw">0.5 0 0 0.1 0.2 0.3 0.9273618495</pose>')
        + joint("j", "world", "a", Y)
        + joint("k", "a", "b", Y),
        "1.9",
    ),
    "an axis of the model": sdf(
        link("a", "<pose>0 0 1 0.5 0.2 0</pose>")
        + joint(
            "j",
            "world",
            "a",
            "<axis><use_parent_model_frame>1</use_parent_model_frame><xyz>0 1 0</xyz></axis>",
        ),
        "1.6",
    ),
    "a screw": sdf(
        link("a", "<pose>0 0 1 0.5 0.2 0</pose>")
        + joint("j", "world", "a", f"{Y}<screw_thread_pitch>0.3</screw_thread_pitch>", "screw"),
        "1.10",
    ),
    "a screw of old": sdf(
        link("a", "<pose>0 0 1 0.5 0.2 0</pose>")
        + joint("j", "world", "a", f"{Y}<thread_pitch>-20</thread_pitch>", "screw"),
        "1.6",
    ),
    "two axes": sdf(
        link("a", "<pose>0 0 1 0.5 0.2 0</pose>")
        + joint("j", "world", "a", "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz></axis2>",
                "universal")
    ),
    "fixed and ball": sdf(
        link("a")
        + link("b", "<pose>1 0 0 0 0 0.4</pose>")
        + link("c", "<pose>1 0 1 0 0 0.4</pose>")
        + joint("w", "world", "a", "", "fixed")
        + joint("k", "a", "b", Y)
        + joint("f", "b", "c", "", "fixed")
    ),
    "a model that is turned": sdf(
        "<pose>1 2 3 0.3 0.2 0.1</pose>"
        + link("a")
        + joint("j", "world", "a", Y)
    ),
    "a model inside": sdf(ARM + f'<model name="hand">{AT}{HAND}</model>' + WRIST),
    "a model inside that is placed by a frame": sdf(
        ARM + f'<model name="hand" placement_frame="grip">{AT}{HAND}</model>' + WRIST, "1.9"
    ),
    "models inside each other": sdf(
        f'<model name="hand"><model name="inner"><pose>0.3 0 0 0 0.5 0</pose>{HAND}</model>'
        + joint("wrist", "world", "inner", Y)
        + "</model>"
    ),
    "a model that is placed by a link": sdf(
        "<pose>1 2 3 0.3 0.2 0.1</pose>" + ARM, "1.9"
    ).replace('name="arm"', 'name="arm" placement_frame="a"'),
}  # fmt: skip


def gear(name, pose, mass):
    return link(name, f"<pose>{pose}</pose>", mass)


GEARED = sdf(
    gear("a", "0 0 1 0 0 0", 1.5)
    + gear("b", "1 0 1 0 0 0.7", 0.4)
    + joint("j", "world", "a", "<axis><xyz>0 0 1</xyz></axis>")
    + joint("k", "world", "b", "<axis><xyz>0 0 1</xyz></axis>")
    + joint("gears", "a", "b", "<gearbox_ratio>3</gearbox_ratio>"
            "<gearbox_reference_body>world</gearbox_reference_body>"
            "<axis><xyz>0 0 1</xyz></axis><axis2><xyz>0 0 -1</xyz></axis2>", "gearbox")
)  # fmt: skip


def followed(model: fb.Model) -> tuple[str, float]:
    """The joint that joint k follows, and its ratio."""
    mimic = next(x for x in model.bodies if x.joint.name == "k").joint.mimic
    assert mimic is not None
    return mimic.joint, mimic.ratio


def test_a_gearbox_is_a_mimic():
    """theta2 = -ratio theta1, the angles of child and parent about its two axes as seen from the
    reference body, whichever way the joints count."""
    found = fb.load(text=GEARED, format="sdf")
    assert found.joint_names == ("j", "k")
    assert followed(found) == ("j", 3.0)  # its second axis is against the joint's
    mimics = GEARED.partition('<joint name="gears"')[0] + "</model></sdf>"
    at = mimics.rindex("</axis>")
    told = "<mimic joint='j'><multiplier>3</multiplier></mimic>"
    twin = fb.load(text=mimics[:at] + told + mimics[at:], format="sdf")
    assert found == twin
    turned = GEARED.replace(
        "<parent>world</parent><child>a</child><axis><xyz>0 0 1",
        "<parent>world</parent><child>a</child><axis><xyz>0 0 -1",
    )
    alike = GEARED.replace("<axis2><xyz>0 0 -1", "<axis2><xyz>0 0 1")
    for text in (turned, alike):
        assert followed(fb.load(text=text, format="sdf")) == ("j", -3.0)


def test_a_screw_is_written_and_read_again(tmp_path):
    model = fb.load(text=ROBOTS["a screw of old"], format="sdf")
    assert fb.losses(model, "sdf") == []
    fb.save(model, tmp_path / "screw.sdf")
    again = fb.load(tmp_path / "screw.sdf")
    assert again.bodies[0].joint.numbers == pytest.approx((1 / 20,), rel=1e-15)
    assert fb.same_robot(model, again)


def test_a_screw_without_pitch_is_told():
    screw = sdf(link("a") + joint("j", "world", "a", Y, "screw"))
    model = fb.load(text=screw, format="sdf")
    assert model.bodies[0].joint.numbers == (1 / (2 * np.pi),)
    (told,) = [x for x in model.notices if x.kind == "pitch"]
    assert "assumes 1 m for each turn; give <screw_thread_pitch>" in told.text


@pytest.mark.parametrize("robot", ROBOTS)
def test_equations_are_those_of_drake(robot):
    extra("pydrake", "Drake")
    from pydrake.multibody.parsing import Parser
    from pydrake.multibody.plant import MultibodyPlant

    plant = MultibodyPlant(0.0)
    plant.mutable_gravity_field().set_gravity_vector([0.0, 0.0, -9.81])
    Parser(plant).AddModelsFromString(ROBOTS[robot], "sdf")
    plant.Finalize()
    context = plant.CreateDefaultContext()
    model = fb.load(text=ROBOTS[robot], format="sdf")
    assert model.nq == plant.num_positions()
    names = [name.split("::")[-1].removesuffix("_2") for name in model.joint_names]
    at = [plant.GetJointByName(name).position_start() for name in names]
    at = [start + names[:k].count(names[k]) for k, start in enumerate(at)]
    rng = np.random.default_rng(5)
    for _ in range(4):
        q = rng.normal(size=model.nq)
        theirs = np.zeros(model.nq)
        theirs[at] = q
        plant.SetPositions(context, theirs)
        M = plant.CalcMassMatrix(context)[np.ix_(at, at)]
        G = -plant.CalcGravityGeneralizedForces(context)[at]
        np.testing.assert_allclose(fb.mass_matrix(model, q), M, atol=1e-9)
        np.testing.assert_allclose(fb.gravity_torque(model, q), G, atol=1e-8)


def test_old_versions_give_axes_in_the_model():
    robot = link("a", "<pose>0 0 1 0.5 0.2 0</pose>") + joint("j", "world", "a", Y)
    flag = "<use_parent_model_frame>1</use_parent_model_frame>"
    old = fb.load(text=sdf(robot, "1.4"), format="sdf")
    new = fb.load(text=sdf(robot.replace("<xyz>", f"{flag}<xyz>"), "1.6"), format="sdf")
    other = fb.load(text=sdf(robot, "1.6"), format="sdf")
    q = np.array([0.4])
    assert fb.gravity_torque(old, q) == pytest.approx(fb.gravity_torque(new, q))
    assert fb.gravity_torque(old, q) != pytest.approx(fb.gravity_torque(other, q))


def test_a_second_parent_closes_a_loop():
    """A parallelogram: the coupler's second parent is the other crank."""
    bars = (
        link("left")
        + link("top", "<pose>0 0 1 0 0 0</pose>")
        + link("right", "<pose>2 0 0 0 0 0</pose>")
    )
    pins = (
        joint("a", "world", "left", Y)
        + joint("b", "left", "top", Y)
        + joint("c", "world", "right", Y)
        + joint("d", "right", "top", f'<pose relative_to="right">0 0 1 0 0 0</pose>{Y}')
    )
    model = fb.load(text=sdf(bars + pins), format="sdf")
    (loop,) = model.loops
    assert (loop.name, loop.kind) == ("d", "revolute")
    q = fb.assemble(model, {"a": 0.5}, free=["b", "c"])
    assert dict(zip(model.joint_names, q, strict=True)) == pytest.approx(
        {"a": 0.5, "b": -0.5, "c": 0.5}
    )
    assert fb.mobility(model, q).instantaneous == 1
    rubbing = Y.replace("</axis>", "<dynamics><damping>1</damping></dynamics></axis>")
    lossy = sdf(bars + pins.replace(f"0 0 0</pose>{Y}", f"0 0 0</pose>{rubbing}"))
    told = [str(notice) for notice in fb.load(text=lossy, format="sdf").notices]
    assert any("'d' closes a loop, and its <dynamics> is left out" in text for text in told)


def test_limits_friction_springs_mimics_and_frames():
    inside = (
        "<axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>2</upper><effort>30</effort>"
        "<velocity>-1</velocity></limit><dynamics><damping>0.5</damping><friction>0.2</friction>"
        "<spring_stiffness>7</spring_stiffness><spring_reference>0.1</spring_reference></dynamics>"
        "</axis>"
    )
    follow = (
        '<axis><xyz>0 1 0</xyz><mimic joint="j" axis="axis"><multiplier>2</multiplier>'
        "<offset>0.3</offset><reference>0.1</reference></mimic></axis>"
    )
    model = fb.load(
        text=sdf(
            link("a")
            + link("b")
            + '<frame name="tool" attached_to="b"><pose>0 0 0.2 0 0 0</pose></frame>'
            + joint("j", "world", "a", inside)
            + joint("k", "a", "b", follow)
        ),
        format="sdf",
    )
    first, second = (body.joint for body in model.bodies)
    limits = first.limits
    assert (limits.lower, limits.upper, limits.effort, limits.velocity) == (-1, 2, 30, np.inf)
    assert (second.mimic.ratio, second.mimic.offset) == (2.0, pytest.approx(0.1))
    assert "tool" in model.frame_names
    M = fb.mass_matrix(model, [0.0])
    tau = fb.inverse_dynamics(model, [0.4], [1.0], [0.0])
    back = fb.inverse_dynamics(model, [0.4], [-1.0], [0.0])
    assert M.shape == (1, 1)
    assert (tau - back)[0] == pytest.approx(2 * (0.5 + 0.2))


def test_what_is_not_said_is_told():
    model = fb.load(text=sdf('<link name="a"/>' + joint("j", "world", "a", Y)), format="sdf")
    assert any("SDF assumes 1 kg and 1 kg m²" in str(notice) for notice in model.notices)
    assert fb.mass_matrix(model, [0.0]) == pytest.approx(np.ones((1, 1)))
    floating = fb.load(text=sdf(link("a") + link("b") + joint("j", "world", "a", Y)), format="sdf")
    assert floating.nv == 7
    assert any("floats freely" in str(notice) for notice in floating.notices)


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("<robot/>", ":1: the root element is <robot>, expected <sdf>."),
        (sdf(""), "there are no links"),
        (sdf(link("a") + link("a")), "there are two of that name"),
        (sdf(link("a", "<pose>1 2 3</pose>")), "<pose> has 3 numbers, expected 6"),
        (sdf(link("a", "<pose>1 2 3 4 5 x</pose>")), "'x' in <pose> is no usable number"),
        (sdf(link("a", '<pose relative_to="b"/>')), "no frame 'b' in the model"),
        (
            sdf(link("a", '<pose relative_to="b"/>') + link("b", '<pose relative_to="a"/>')),
            "placed in circles",
        ),
        (sdf(link("a") + joint("j", "world", "c", Y)), "no link 'c'"),
        (
            sdf(link("a") + '<frame name="f" attached_to="b"/>' + joint("j", "world", "f", Y)),
            "no frame 'b' in joint 'j'",
        ),
        (sdf(link("a") + joint("j", "a", "world", Y)), "swap parent and child"),
        (sdf(link("a") + joint("j", "world", "a", "", "gears")), "no type 'gears'"),
        (
            sdf(
                link("a")
                + joint("j", "world", "a", Y, "screw").replace(
                    "</joint>", "<thread_pitch>0</thread_pitch></joint>"
                )
            ),
            "<thread_pitch> is 0; a screw advances",
        ),
        (
            GEARED.replace("<gearbox_reference_body>world", "<gearbox_reference_body>wall"),
            "no link 'wall' in joint 'gears'",
        ),
        (
            GEARED.replace("<gearbox_reference_body>world</gearbox_reference_body>", ""),
            "a gearbox needs its <gearbox_reference_body>",
        ),
        (
            GEARED.replace("<axis2><xyz>0 0 -1", "<axis2><xyz>0 1 0"),
            "'b' has no revolute joint with 'world' about the gearbox's <axis2>; give it one, or",
        ),
        (GEARED.replace("<gearbox_ratio>3", "<gearbox_ratio>0"), "that of no gears"),
        (
            GEARED.replace(
                "</xyz></axis></joint>", "</xyz><mimic joint='j'/></axis></joint>", 1
            ).replace("</xyz></axis></joint>", "</xyz><mimic joint='j'/></axis></joint>", 1),
            "joint 'k' follows 'j' already; keep one",
        ),
        (
            sdf(link("a") + joint("j", "world", "a", "<axis><xyz>0 0 0</xyz></axis>")),
            "the axis is zero",
        ),
        (sdf(link("a") + "<include/>"), "<include> has no <uri>"),
        (sdf(link("a") + "<include><uri>model://b/c</uri></include>"), "package 'b' was not found"),
        (sdf(link("a") + "<include><uri>https://b/c</uri></include>"), "'https://b/c' is not read"),
        (
            sdf(link("a") + "<include><uri>/etc/x</uri></include>"),
            "lies outside the file's package",
        ),
        (sdf(link("a") + '<model name="b"/>'), "model 'b' inside a model has no links"),
        (
            sdf(link("a") + f'<model name="b"><static>1</static>{link("c")}</model>'),
            "model 'b' inside a model is static",
        ),
        (sdf(link("a") + "<model name='b'>" * 21 + "</model>" * 21), "nested more than 20 deep"),
        ('<sdf version="x"><model name="a"/></sdf>', "the version is 'x'"),
        ('<sdf version="1.7"><world name="w"/></sdf>', "a robot is one <model>"),
    ],
)
def test_refusals(text, told):
    with pytest.raises(fb.FreebodyError) as caught:
        fb.load(text=text, format="sdf")
    assert told in str(caught.value)


def test_a_model_inside_is_the_same_as_its_parts_written_out():
    """Names with INNER:: in front, poses in the inner model's frame, which is a frame itself."""
    pose = '<pose relative_to="hand">0 0 1 0 0 0</pose>'
    tool = f'{WRIST}<frame name="t" attached_to="hand::grip">{pose}</frame>'
    hand = f'<model name="hand">{AT}{HAND}</model>'
    inside = fb.load(text=sdf(ARM + hand + tool), format="sdf")
    flat = HAND
    for name in ("palm", "finger", "grip", "open"):
        for before, after in ('""', "><"):
            flat = flat.replace(f"{before}{name}{after}", f"{before}hand::{name}{after}")
    flat = flat.replace('"__model__"', '"hand"').replace(
        "<pose>0 0 0.1 0.2 0 0</pose>", '<pose relative_to="hand">0 0 0.1 0.2 0 0</pose>'
    )
    frame = f'<frame name="hand" attached_to="hand::palm">{AT}</frame>'
    written_out = fb.load(text=sdf(ARM + frame + flat + tool), format="sdf")
    assert {*inside.frame_names} == {*written_out.frame_names}
    assert {*inside.frame_names} >= {"hand", "hand::palm", "hand::grip", "t"}
    q, _, _ = fb.random_state(inside, 2)
    for one in (fb.mass_matrix, fb.gravity_torque):
        np.testing.assert_array_equal(one(inside, q), one(written_out, q))
    for frame in ("hand", "hand::grip", "t"):
        for one, two in zip(
            *(fb.forward_kinematics(x, q, frame) for x in (inside, written_out)), strict=True
        ):
            np.testing.assert_allclose(one, two, atol=1e-15)


def test_included_models_are_read_below_packages(tmp_path):
    hand = tmp_path / "lib" / "hand"
    hand.mkdir(parents=True)
    robot = tmp_path / "robot"
    robot.mkdir()
    (hand / "model.config").write_text("<model><name>hand</name><sdf>hand.sdf</sdf></model>")
    (hand / "hand.sdf").write_text(
        f'<sdf version="1.7">\n<model name="gripper">\n{HAND}</model></sdf>'
    )
    include = f"<include><uri>model://hand</uri><name>hand</name>{AT}</include>"
    (robot / "arm.sdf").write_text(sdf(f"{ARM}{include}{WRIST}"))
    with pytest.raises(fb.FileError, match="package 'hand' was not found"):
        fb.load(robot / "arm.sdf")
    found = fb.load(robot / "arm.sdf", package_path=hand.parent)
    inside = fb.load(text=sdf(f'{ARM}<model name="hand">{AT}{HAND}</model>{WRIST}'), format="sdf")
    q, _, _ = fb.random_state(inside, 4)
    np.testing.assert_array_equal(fb.mass_matrix(found, q), fb.mass_matrix(inside, q))
    world = robot / "world.sdf"
    ground = "<include><uri>model://ground_plane</uri></include>"
    world.write_text(
        f'<sdf version="1.7"><world name="w">{ground}<include><uri>arm.sdf</uri></include></world>'
        "</sdf>"
    )
    found = fb.load(world, package_path=hand.parent)
    assert found.name == "arm"
    assert any("'model://ground_plane'" in str(notice) for notice in found.notices)
    text = (hand / "hand.sdf").read_text().replace("0.1 0.2 0 0", "0.1")
    (hand / "hand.sdf").write_text(text)
    with pytest.raises(fb.FileError, match=r"hand\.sdf:3: .* has 3 numbers, expected 6"):
        fb.load(robot / "arm.sdf", package_path=hand.parent)
    (robot / "arm.sdf").write_text(sdf(f"{link('a')}<include><uri>arm.sdf</uri></include>"))
    with pytest.raises(fb.FileError, match="nested more than 20 deep"):
        fb.load(robot / "arm.sdf")


def test_old_files_have_a_link_called_world():
    robot = '<link name="world"/>' + link("a") + joint("j", "world", "a", Y)
    old = fb.load(text=sdf(robot, "1.5"), format="sdf")
    new = fb.load(text=sdf(link("a") + joint("j", "world", "a", Y), "1.5"), format="sdf")
    assert fb.gravity_torque(old, [0.3]) == pytest.approx(fb.gravity_torque(new, [0.3]))


def test_a_world_with_one_robot(tmp_path):
    path = tmp_path / "world.sdf"
    robot = link("a") + joint("j", "world", "a", Y)
    path.write_text(
        '<sdf version="1.6"><world name="w"><gravity>0 0 -1.6</gravity><model name="ground">'
        f'<static>true</static><link name="g"/></model><model name="arm">{robot}</model></world>'
        "</sdf>"
    )
    model = fb.load(path)
    assert model.name == "arm"
    assert model.gravity == pytest.approx([0, 0, -1.6])
