"""TOML: everything a model has, lines in errors, and a writer whose files load as the same
model."""

import dataclasses
import math
import re
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Limits, Model, Parameter
from support.real_files import FILES, REFUSED, ROBOTS
from support.robots import KINDS

LINKS = '[[link]]\nname = "base"\n[[link]]\nname = "arm"\n'
JOINT = '[[joint]]\nname = "a"\nkind = "revolute"\nparent = "base"\nchild = "arm"\n'


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Files are written where nobody minds, and errors name them without a path."""
    monkeypatch.chdir(tmp_path)


def read(text: str, **options) -> Model:
    """The model in a file with this text."""
    Path("arm.toml").write_text(text, encoding="utf-8", newline="")
    return fb.load("arm.toml", **{"physical": "refuse", **options})


def message(text: str) -> str:
    """The refusal, which is one line."""
    with pytest.raises(fb.FreebodyError) as refusal:
        read(text)
    assert "\n" not in str(refusal.value)
    return str(refusal.value)


def rotation(entry: str) -> np.ndarray:
    """The rotation matrix of a frame."""
    model = read(f'{LINKS}{JOINT}axis = "z"\n[[frame]]\nname = "f"\nparent = "arm"\n{entry}\n')
    return np.array(model.tree.frames["f"][1], dtype=float)


# ---------------------------------------------------------------- what is read
def test_a_whole_robot():
    model = read("""
        name = "everything"
        source = "made up"
        gravity = [0, 0, -1.62]
        tip = "flange"

        [parameters]
        m1 = 2.5
        tilt = "30 deg"

        [[link]]
        name = "base"
        mass = 4

        [[link]]
        name = "upper"
        mass = "m1"
        com = [0, 0, { name = "c1", value = 0.2 }]
        inertia = [[1, 0.1, 0], [0.1, 1, 0], [0, 0, 1]]

        [[link]]
        name = "lower"
        mass = 3
        com = [0.1, 0, 0]
        shape = { cylinder = { radius = 0.1, length = 0.5 } }
        inertia_frame = { origin = [0, 0, 1], rpy = ["90 deg", 0, 0] }

        [[joint]]
        name = "shoulder"
        kind = "revolute"
        parent = "base"
        child = "upper"
        steps = [{ shift = [0, 0, 1] }, { turn = "x", angle = "tilt" }]
        axis = "-y"
        limits = { lower = "-90 deg", upper = 1.5, velocity = "180 deg/s", effort = 40 }
        friction = { viscous = 0.1, coulomb = 0.2 }
        rotor = { inertia = 1e-4, gear = 100 }
        spring = { stiffness = 5, rest = "45 deg" }

        [[joint]]
        name = "elbow"
        kind = "prismatic"
        parent = "upper"
        child = "lower"
        axis = [0, 3, 4]
        limits = { lower = -inf, upper = 1 }
        mimic = { joint = "shoulder", ratio = 2, offset = 0.1 }

        [[frame]]
        name = "flange"
        parent = "lower"
        origin = [0, 0, 0.1]

        [[payload]]
        name = "box"
        frame = "flange"
        mass = 1
        shape = { box = { size = [1, 2, 3] } }
    """)
    assert (model.name, model.source, model.nv, model.tip, model.mass) == (
        "everything",
        "made up",
        1,
        "flange",
        10.5,
    )
    assert model.gravity.tolist() == [0, 0, -1.62]
    assert model.parameters == {"m1": 2.5, "c1": 0.2, "tilt": math.radians(30)}
    shoulder, elbow = (body.joint for body in model.bodies)
    assert shoulder.axis == (0.0, -1.0, 0.0)
    assert shoulder.limits == Limits(-math.pi / 2, 1.5, math.pi, 40.0)
    assert shoulder.drive == fb.Drive(0.1, 0.2, 1e-4, 100.0, 5.0, math.pi / 4)
    assert (elbow.axis, elbow.limits.upper) == ((0.0, 0.6, 0.8), 1.0)
    mimic = elbow.mimic
    assert (mimic.joint, mimic.ratio, mimic.offset) == ("shoulder", 2.0, 0.1)
    lower, box = model.bodies[1].inertias
    np.testing.assert_allclose(np.diag(lower.inertia.numbers()[2]), [0.07, 0.07, 0.015])
    assert lower.inertia.com == (0.1, 0.0, 0.0)
    turned = ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))
    shift, rotate = map(dataclasses.astuple, lower.placement.steps)
    assert (shift, rotate) == (((0.0, 0.0, 1.0),), (turned,))
    np.testing.assert_allclose(np.diag(box.inertia.numbers()[2]), np.array([13, 10, 5]) / 12)


def test_planar_word_is_the_builder():
    model = read(
        '[planar]\nword = "RP"\nl = [0.5, "reach"]\nangles = [0, "90 deg"]\n[parameters]\n'
        "reach = 0.2\ng = 1.62\n"
    )
    twin = fb.planar(
        "RP", l=[0.5, Parameter("reach", 0.2)], angles=[0, math.pi / 2], g=1.62, name="arm"
    )
    same_model(model, twin)


def test_planar_limits_and_drives():
    limits = '[{ upper = "90 deg", velocity = "90 deg/s" }, { upper = 2 }]'
    drives = '[{ friction = { viscous = 1 } }, { rotor = { inertia = "J", gear = 3 } }]'
    model = read(f'[planar]\nword = "RP"\nlimits = {limits}\ndrives = {drives}\n')
    first, second = (body.joint for body in model.bodies)
    assert (first.limits, first.drive) == (
        Limits(upper=math.pi / 2, velocity=math.pi / 2),
        fb.Drive(viscous=1.0),
    )
    assert (second.limits, second.drive) == (
        Limits(upper=2.0),
        fb.Drive(rotor=Parameter("J"), gear=3.0),
    )


def test_dh_table_is_the_builder():
    model = read("""
    [dh]
    convention = "modified"
    rows = [
      { alpha = "90 deg", d = "d1", m = 2, com = [0, 0, 0.1], I = [
          [1, 0, 0], [0, 1, 0], [0, 0, 1]] },
      { joint = "P", theta = 0.5, a = 0.3, limits = {lower=0, upper=1}, friction = {viscous=2} },
    ]
    """)
    rows = [
        {"alpha": math.radians(90), "d": "d1", "m": 2, "com": (0, 0, 0.1), "I": (1, 0, 0, 1, 0, 1)},
        {"joint": "P", "theta": 0.5, "a": 0.3, "limits": (0, 1), "friction": 2},
    ]
    same_model(model, fb.dh(rows, convention="modified", name="arm"))


def test_a_planar_tree():
    model = read("""
        dim = 2
        [[link]]
        name = "ground"
        [[link]]
        name = "crank"
        mass = 1
        com = ["lc", 0]
        inertia = "I"
        [[joint]]
        name = "pin"
        kind = "revolute"
        parent = "ground"
        child = "crank"
        origin = [1, 2]
        angle = "90 deg"
        axis = -1
    """)
    assert (model.dim, model.missing, model.bodies[0].joint.axis) == (2, ("I", "lc"), (-1.0,))
    assert model.gravity.tolist() == [0, -9.81]


@pytest.mark.parametrize(
    "entry",
    [
        'rpy = ["90 deg", 0, 0]',
        'axis_angle = { axis = "x", angle = "90 deg" }',
        "axis_angle = { axis = [2, 0, 0], angle = 1.5707963267948966 }",
        "quat_wxyz = [0.7071067811865476, 0.7071067811865476, 0, 0]",
        "matrix = [[1, 0, 0], [0, 0, -1], [0, 1, 0]]",
        'steps = [{ turn = "x", angle = "90 deg" }]',
    ],
)
def test_one_rotation_said_six_ways(entry: str):
    np.testing.assert_allclose(rotation(entry), [[1, 0, 0], [0, 0, -1], [0, 1, 0]], atol=4e-16)


def test_base_and_gravity_by_name():
    model = read('base = "free"\ngravity = "g0"\n[[link]]\nname = "body"\nmass = 1\n')
    assert (model.nq, model.gravity_size) == (7, Parameter("g0"))
    assert read('gravity = 1.62\n[[link]]\nname = "body"\n').gravity_size == Parameter("g", 1.62)


def test_loops():
    loop = '[[loop]]\nname = "bar"\nkind = "%s"\nframes = ["base", "arm"]\n'
    text = f'{LINKS}{JOINT}axis = "z"\npassive = true\n{loop}'
    assert read(text % "prismatic" + 'axis = "-y"\n').loops[0].axis == (0.0, -1.0, 0.0)
    model = read(text % "distance" + 'distance = "d"\n')
    assert (model.loops[0].distance, model.actuated) == (Parameter("d"), ())
    assert (
        message(text % "distance")
        == "arm.toml:12: loop 'bar': give the distance (m) between its frames."
    )
    assert message((text % "fixed").replace('frames = ["base", "arm"]', "")) == (
        'arm.toml:12: loop \'bar\': frames is missing; name the two: frames = ["one", "other"].'
    )
    assert message(text % "belt").startswith(
        "arm.toml:14: no kind 'belt' in loop 'bar'. Kinds: revolute,"
    )


# ---------------------------------------------------------------- what is refused
@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("name = 'a'\nnme = 'b'\n[[link]]\n",
         "arm.toml:2: no key 'nme' in the file. Did you mean 'name'? Keys: "
         "name, dim, source, about, "
         "gravity, tip, base, parameters, frame, payload, loop, loop_tolerance, strut, home, "
         "masses_missing, masses_doubtful, masses_estimated, limits_estimated, link, joint, "
         "template, planar, dh."),
        ("name = 'a'\n",
         "arm.toml: there are no links; write a [[link]] for each body, the base included."),
        ("dim = 4\n" + LINKS, "arm.toml:1: dim is 4, expected 2 (the plane) or 3 (space)."),
        ("link = 3\n", "arm.toml:1: link is a number, expected tables: write [[link]] above each."),
        ("[[link]]\n", "arm.toml:1: name is missing; add name = ..."),
        (LINKS + LINKS + JOINT + "axis = 'z'",
         "arm.toml:5: two links are called 'base'; rename one."),
        ("[planar]\nword = 'RR'\n[parameters]\nlc1 = ''\n",
         "arm.toml:4: [parameters]: lc1 is '', expected a number, or text such as \"30 deg\"."),
        (LINKS + "mass = 'm/2'\n",
         "arm.toml:5: link 'arm': mass is 'm/2', expected a number or a name such as 'l1'; write a "
         "formula below [parameters], and its name here."),
        (LINKS + "mass = '3 kg'\n",
         "arm.toml:5: link 'arm': mass is '3 kg', expected a number or a name such as "
         "'l1'."),
        (LINKS + "mass = true\n",
         "arm.toml:5: link 'arm': mass is true or false, expected a number."),
        (LINKS + "mass = nan\n", "arm.toml:5: link 'arm': mass is nan, not a finite number."),
        (LINKS + "mass = 1\ncom = [1, 2]\n",
         "arm.toml:6: link 'arm': com has 2 entries, expected 3."),
        (LINKS + "mass = 1\ncom = [\n1,\n2,\n'x y']\n",
         "arm.toml:9: link 'arm': com[2] is 'x y', expected a number "
         "or a name "
         "such as 'l1'."),
        (LINKS + "com = [0, 0, 0]\n", "arm.toml:3: link 'arm': mass is missing; add mass = ..."),
        (LINKS + "mass = 1\ninertia = [[1, 1, 0], [0, 1, 0], [0, 0, 1]]\n",
         "arm.toml:6: link 'arm': Inertia: the "
         "3×3 tensor is "
         "not symmetric."),
        (LINKS + "mass = 1\ninertia = [1, 0, 0, 1, 0, 3]\n" + JOINT + "axis = 'z'\n",
         "arm.toml:3: link 'arm': "
         "principal moments "
         "1, 1, 3 kg m² break the triangle inequality (1 + 1 < 3). Correct it, or accept it with "
         "physical='warn'."),
        (LINKS + "mass = 1\nshape = { barr = { length = 1 } }\n",
         "arm.toml:6: no key 'barr' in link 'arm'. Did you "
         "mean 'bar'? "
         "Keys: point, disc, ring, bar, box, cylinder, sphere."),
        (LINKS + JOINT.replace("revolute", "revolut"),
         "arm.toml:7: no kind 'revolut' in joint 'a'. Did you mean "
         f"'revolute'? Kinds: {', '.join(KINDS)}."),
        (LINKS + JOINT, "arm.toml:5: joint 'a': axis is missing; add axis = ..."),
        (LINKS + JOINT + "axis = 'w'\n",
         "arm.toml:10: joint 'a': axis is 'w', expected x, y, z, one of them with a "
         "minus, or numbers."),
        (LINKS + JOINT + "axis = [0, 0, 0]\n",
         "arm.toml:5: joint 'a': axis (0.0, 0.0, 0.0) must be 3 finite "
         "numbers, not all zero."),
        (LINKS + JOINT.replace('"base"', '"bas"') + "axis = 'z'\n",
         "arm.toml:5: joint 'a': no parent link 'bas' in "
         "the file. Did you "
         "mean 'base'? Parent links: base, arm."),
        (LINKS + JOINT + "axis = 'z'\nlimits = { lower = '3 dge' }\n",
         "arm.toml:11: joint 'a', limits: lower is '3 "
         "dge', expected a "
         "number, or text such as \"30 deg\"."),
        (LINKS + JOINT + "axis = 'z'\nlimits = { lower = 1, upper = 0 }\n",
         "arm.toml:5: joint 'a': lower limit 1 "
         "is above upper 0; "
         "swap them, or leave both out where there are none."),
        (LINKS + JOINT + "axis = 'z'\nrpy = [0, 0, 0]\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, "
                         "2]]\n", "arm.toml:12: "
         "joint 'a': rpy and "
         "matrix exclude each other; keep one rotation."),
        (LINKS + JOINT + "axis = 'z'\nmatrix = [[1, 0, 0], [0, 1, 0], [0, 0, 2]]\n",
         "arm.toml:11: joint 'a': "
         "rotation: the matrix is "
         "not a rotation (R Rᵀ = 1, det R = 1)."),
        (LINKS + JOINT + "axis = 'z'\nangle = 1\n",
         "arm.toml:11: joint 'a': angle does not fit a model with dim = "
         "3; use rpy, "
         "axis_angle, quat_wxyz, matrix."),
        (LINKS + JOINT + "axis = 'z'\nquat_wxyz = [1, 1, 0, 0]\n",
         "arm.toml:11: joint 'a': the quaternion has "
         "length 1.41421, expected 1."),
        (LINKS + JOINT.replace("revolute", "fixed") + "axis = 'z'\n",
         "arm.toml:10: joint 'a': a fixed joint has no "
         "axis; remove it."),
        (LINKS + "[[frame]]\nname = 'f'\nparent = 'arn'\n",
         "arm.toml:7: no parent 'arn' in frame 'f'. Did you mean "
         "'arm'? Parents: "
         "base, arm."),
        (LINKS + "[[frame]]\nname = 'arm'\nparent = 'arm'\n",
         "arm.toml:6: frame 'arm': the name is taken; rename it."),
        ("tip = 'hand'\n" + LINKS, "arm.toml:1: no tip 'hand' in the file. Tips: base, arm."),
        (LINKS + "mass = 'm'\n[parameters]\nM = 3\n",
         "arm.toml:7: no parameter 'M' in the model. Did you "
         "mean 'm'? Parameters: g, m."),
        (LINKS + "mass = { name = 'm', value = 2 }\n[parameters]\nm = 3\n",
         "arm.toml:7: 'm' has two values, 3 and "
         "2; keep one."),
        ("[planar]\nword = 'RX'\n",
         "arm.toml:1: planar: the word 'RX' must be made of the letters R and P, such as "
         "'RR' or 'RP'."),
        ("[planar]\nword = 'RR'\nl = [1]\n", "arm.toml:3: [planar]: l has 1 entry, expected 2."),
        ("[planar]\nword = 'R'\n" + LINKS,
         "arm.toml:1: [planar] describes the whole arm; remove the other links "
         "and joints."),
        ("dim = 2\n[dh]\nrows = []\n", "arm.toml:1: a [dh] arm has dim = 3; remove dim."),
        ("[dh]\nrows = []\n", "arm.toml:1: [dh]: convention is missing; add convention = ..."),
        ("[dh]\nconvention = 'craig'\n",
         "arm.toml:2: no convention 'craig' in [dh]. Conventions: standard, modified."),
        ("[dh]\nconvention = 'modified'\nrows = [\n{ a = 1 },\n{ alpha = '90 dg' }]\n",
         "arm.toml:5: dh row 2: "
         "alpha is '90 dg', expected "
         "a number or a name such as 'l1'; angles also as text such as '30 deg'."),
        ("[dh]\nconvention = 'modified'\nrows = [\n{ a = 1 },\n{ I = [0, 0, 0, 0, 0, 0] }]\n",
         "arm.toml:5: dh row "
         "2: com or I without a "
         "mass; add m."),
        ("a = " + "[" * 2000 + "]" * 2000, "arm.toml:1: brackets are nested more than 64 deep."),
    ],
)  # fmt: skip
def test_refused(text: str, problem: str):
    assert message(text) == problem


@pytest.mark.parametrize(
    "text", ["name = 'a'\n\nname = 'b'\n", "\n\nname = 3 4\n", "\n\nname = ", "\n\nname = 'b\n"]
)
def test_not_toml(text: str):
    assert message(text).startswith(
        ("arm.toml:3: this is not valid TOML: ", "arm.toml:4: this is not valid TOML: ")
    )


# ---------------------------------------------------------------- writing
def same_model(one: Model, two: Model) -> None:
    """Equal to the last bit in all but the lines they were read from, and the shapes for
    drawings, which TOML does not hold."""
    for field in dataclasses.fields(Model):
        if field.name not in ("notices", "bodies", "shapes"):
            assert getattr(one, field.name) == getattr(two, field.name), field.name
    bodies = [
        [dataclasses.replace(b, joint=dataclasses.replace(b.joint, line=None)) for b in m.bodies]
        for m in (one, two)
    ]
    assert bodies[0] == bodies[1]
    assert repr(bodies[0]) == repr(bodies[1])  # tells 0.0 from -0.0


def round_trip(model: Model) -> None:
    fb.save(model, "written.toml")
    same_model(model, fb.load("written.toml", physical="ignore"))


@pytest.mark.sample(10)
@pytest.mark.parametrize("name", list(fb.models()))
def test_bundled_models_survive_writing(name: str):
    model = fb.load(name, physical="ignore")
    round_trip(model)
    round_trip(fb.load(name, physical="ignore", mimic="free"))
    round_trip(model.replace(gravity=0))
    if model.dim == 2:
        round_trip(model.to_space())
        round_trip(fb.load(name, base="free"))


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", [name for name in FILES if name not in REFUSED])
def test_real_files_survive_writing(name: str):
    round_trip(fb.load(ROBOTS / name, physical="ignore"))
    round_trip(fb.load(ROBOTS / name, physical="ignore", base="free", snap_angles=0, mimic="free"))


def test_tools_and_payloads_survive_writing():
    model = fb.load("panda").with_tool(
        "pen", [0, 0, 0.1], np.diag([1.0, -1.0, -1.0]), inertia=fb.Inertia.point(0.1)
    )
    round_trip(
        model.with_payload(2.0, frame="panda_leftfinger").with_payload(1.0, frame="panda_link0")
    )
    planar = fb.planar("RR", m=[1, None]).with_tool("grip", [0.1, 0], [[0, -1], [1, 0]])
    round_trip(planar.with_payload(fb.Inertia.disc(1, 0.1, dim=2)))


@pytest.mark.parametrize("name", ["panda", "stewart", "2R"])
def test_a_file_that_was_written_is_the_same_model(name, tmp_path):
    """Also to ==, in which the lines of files do not count."""
    model = fb.load(name)
    fb.save(model, tmp_path / "again.toml")
    assert fb.load(tmp_path / "again.toml") == model


def test_a_load_is_no_link_even_with_the_name_of_one(tmp_path):
    model = fb.load("2R").with_payload(
        2.0, frame="link1", name="base"
    )  # the base has no inertia of its own
    fb.save(model, tmp_path / "loaded.toml")
    again = fb.load(tmp_path / "loaded.toml")
    assert np.array_equal(fb.mass_matrix(again, [0.1, 0.2]), fb.mass_matrix(model, [0.1, 0.2]))


def test_symbols_survive_writing():
    rows = [
        {
            "theta": "t0",
            "d": "d1",
            "a": 0.1,
            "alpha": 0.3,
            "m": "m1",
            "rotor": "J",
            "friction": ("v", 0.1),
        }
    ] * 2
    round_trip(fb.dh(rows, convention="modified", gravity="g0"))


def test_save(tmp_path):
    model = fb.load("2R").replace(name='two "R"\\\x7f\té')
    fb.save(model, tmp_path / "arm.toml")
    same_model(model, fb.load(tmp_path / "arm.toml"))
    with pytest.raises(fb.FreebodyError, match=r"save: 'arm.step' must end in \.toml, \.urdf"):
        fb.save(model, "arm.step")


def test_an_origin_may_have_names():
    assert read(f'{LINKS}{JOINT}axis = "z"\norigin = ["a", 0, 0]\n').missing == ("a",)


def test_examples_of_the_reference():
    page = (Path(__file__).parents[3] / "docs/formats.md").read_text(encoding="utf-8")
    examples = re.findall(r"^```toml\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    models = [read(example) for example in examples]
    assert [(model.name, model.nv) for model in models] == [
        ("crane", 2),
        ("palletiser", 2),
        ("flap", 1),
        ("2R", 2),
        ("arm", 2),
        ("small scara", 4),
    ]
    (table,) = re.findall(r"^```text\n(.*?)^```$", page, re.MULTILINE | re.DOTALL)
    Path("arm.csv").write_text(table, encoding="utf-8")
    assert len(fb.load("arm.csv", physical="ignore").bodies) == 3
