"""Whatever is given as a file or a number: it is read, or refused at once with the reason."""

import os
import time
from collections.abc import Callable
from pathlib import Path

import pytest

import freebody as fb
from freebody import read_motion
from support.command import run

BODY = (
    '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" '
    'izz="1"/></inertial>'
)
ARM = """<robot name="a"><link name="base"/><link name="arm">{body}</link>
<joint name="j" type="continuous"><parent link="base"/><child link="arm"/>{inner}</joint></robot>"""
LIMITED = ARM.replace("continuous", "revolute")
ONE = """[[link]]
name = "base"
[[link]]
name = "arm"
{0}
[[joint]]
name = "j"
kind = "revolute"
axis = "z"
parent = "base"
child = "arm"
{1}
"""
TABLE = "# convention: standard\njoint,a,alpha,m\n"


def urdf(inner: str, body: str = BODY) -> str:
    return ARM.format(body=body, inner=inner)


def load(text: str, path: Path) -> fb.Model:
    path.write_text(text, encoding="utf-8")
    return fb.load(path)


def refusal(call: Callable[[], object]) -> str:
    start = time.process_time()
    with pytest.raises(fb.FreebodyError) as caught:
        call()
    assert time.process_time() - start < 6.0
    assert len(str(caught.value)) < 2500
    return str(caught.value)


READERS = {
    "load a URDF": ("x.urdf", fb.load),
    "load a TOML": ("x.toml", fb.load),
    "load a table": ("x.csv", fb.load),
    "a motion": ("x.csv", lambda path: read_motion(fb.load("2R"), path)),
}


# ---------------------------------------------------------------- what is no regular file
@pytest.mark.skipif(os.name == "nt", reason="no FIFOs and no /dev")
@pytest.mark.parametrize("reader", READERS)
def test_a_pipe_a_device_and_a_socket_are_refused_without_opening_them(tmp_path, reader: str):
    name, read = READERS[reader]
    os.mkfifo(tmp_path / name)  # opening it would wait for a writer, for ever
    assert "this is a pipe, not a file; save its contents in a file and name that file." in refusal(
        lambda: read(tmp_path / name)
    )
    (tmp_path / "endless").mkdir()
    (tmp_path / "endless" / name).symlink_to("/dev/zero")
    assert "this is a device, not a file" in refusal(lambda: read(tmp_path / "endless" / name))


@pytest.mark.skipif(os.name == "nt", reason="no FIFOs and no /dev")
@pytest.mark.parametrize("path", ["/dev/zero", "/dev/stdin", "pipe"])
def test_an_answer_from_a_pipe_or_device_is_refused(tmp_path, monkeypatch, capsys, path: str):
    monkeypatch.chdir(tmp_path)
    os.mkfifo("pipe")
    if path == "/dev/stdin":
        os.symlink("pipe", "stdin")
        path = "stdin"
    assert run(["check", "2R", path]) == 2
    text = capsys.readouterr().err
    assert (
        ", not a file; save its contents in a file and name that file; an answer is a file" in text
    )


@pytest.mark.skipif(os.name == "nt", reason="symbolic links need a right there")
def test_a_symbolic_link_to_a_file_is_as_good_as_the_file(tmp_path):
    load(urdf(""), tmp_path / "a.urdf")
    (tmp_path / "b.urdf").symlink_to(tmp_path / "a.urdf")
    assert fb.load(tmp_path / "b.urdf").name == "a"


@pytest.mark.parametrize("reader", READERS)
def test_a_file_that_is_too_large_is_not_read_to_its_end(tmp_path, reader: str):
    name, read = READERS[reader]
    with open(tmp_path / name, "wb") as file:
        file.write(b"x")
        file.truncate(2**40)  # holes: a terabyte that takes no place
    assert " MB, too much for a" in refusal(lambda: read(tmp_path / name))


def test_names_that_no_file_can_have():
    assert refusal(lambda: fb.load("a\0b.urdf")).endswith("there is no such file.")
    assert "the file cannot be read" in refusal(lambda: fb.load("x" * 300 + ".urdf"))
    assert (
        refusal(lambda: fb.load(3))
        == "load: source is int 3, expected the path of a robot's file, or a model's name."
    )
    assert (
        refusal(lambda: fb.load(b"2R"))
        == "load: source is bytes b'2R', expected the path of a robot's file, or a model's name."
    )


def test_text_instead_of_a_path():
    assert refusal(lambda: fb.load(" <robot name='a'><link name='b'/></robot>")) == (
        "load: \" <robot name='a'><link name='b'/></robot>\" is the text of a description, not a "
        'path; give it as text=, with its format, such as format="urdf".'
    )
    assert 'such as format="toml".' in refusal(lambda: fb.load('name = "a"\n[planar]\nword = "R"'))
    assert "standard input" in refusal(lambda: fb.load("-"))


def test_letters_name_a_planar_arm_wherever_a_robot_is_named(capsys):
    assert fb.load("RRP").joint_names == fb.planar("RRP").joint_names
    assert fb.load("RP").source != ""  # the bundled one
    assert fb.load("2R").name == "2R"
    assert run(["show", "RR"]) == 0
    assert "RR: 2 bodies in the plane" in capsys.readouterr().out
    assert run(["derive", "R"]) == 0
    assert "at most 50000 are read" in refusal(lambda: fb.load("R" * 60_000))


# ---------------------------------------------------------------- too many, too deep
TOO_MUCH = {
    "elements inside elements": ("urdf", "<a>" * 100_000, "elements are nested more than 200 deep"),
    "many elements": ("urdf", "<robot>" + "<a/>" * 600_000, "more than 500000 elements"),
    "many links": ("urdf",
                   "<robot>" + "".join(f'<link name="{k}"/>' for k in range(60_000)) + "</robot>",
                   "at most 50000 are read"),
    "brackets": ("toml", "a = " + "[" * 100_000, "brackets are nested more than 64 deep"),
    "tables": ("toml", "a = " + "{a=" * 100_000, "brackets are nested more than 64 deep"),
    "a key of many parts": ("toml", "a" + ".a" * 100_000 + " = 1", "a key has more than 64 parts"),
    "a table of many parts": ("toml", "[a" + ".a" * 100_000 + "]", "a key has more than 64 parts"),
    "values": ("toml", "a = [" + "1," * 2_100_000 + "]", "more than 2000000 lines and values"),
    "rows": ("csv", TABLE + "R,1,0,1\n" * 60_000, "more than 50000 rows"),
    "letters": ("toml", f'[planar]\nword = "{"R" * 60_000}"', "at most 50000 are read"),
}  # fmt: skip


@pytest.mark.sample(1)
@pytest.mark.parametrize("case", TOO_MUCH)
def test_too_many_and_too_deep_is_refused_soon(tmp_path, case: str):
    suffix, text, words = TOO_MUCH[case]
    path = tmp_path / f"x.{suffix}"
    path.write_text(text)
    assert words in refusal(lambda: fb.load(path))


def test_brackets_in_strings_and_comments_do_not_count(tmp_path):
    text = (
        f'# {"[" * 200}\nname = "{"[" * 200} {".a" * 200}"\n'
        f"source = '''{'{' * 200}\n'''\n[planar]\nword = \"R\"\n"
    )
    assert load(text, tmp_path / "x.toml").name.startswith("[[[")


def test_unknown_elements_of_many_names_are_counted(tmp_path):
    inner = "".join(f"<tag{k}/>" for k in range(5000))
    model = load(f'<robot name="a"><link name="b"/>{inner}</robot>', tmp_path / "x.urdf")
    assert len(model.notices) < 110
    assert any("4900 further kinds" in notice.text for notice in model.notices)


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "text",
    [
        "(" * 100_000,
        "x = " + "[" * 20_000,
        "H11 = " + "(" * 19_000,
        "-" * 19_000 + "= 1",
        "H11 = " + "sin " * 4000,
        "H11 = " + "\\frac" * 3000,
        "H11 = 1" + "^1" * 9000,
        "H11 = " + "|" * 1000,
    ],
)
def test_a_deep_answer_is_refused_as_an_answer(text: str):
    assert refusal(lambda: fb.check(fb.load("2R"), text)).startswith("check: ")


LONG = "1" * 5000
BAD = {
    "5000 digits": ("urdf", urdf(f'<origin xyz="{LONG} 0 0"/>'),
                    ":2: joint 'j': xyz of <origin> is '11111"),
    "full-width digits": ("urdf", urdf('<origin xyz="１ 0 0"/>'),
                          ":2: joint 'j': xyz of <origin> is '１'"),
    "an underscore": ("urdf", urdf('<origin xyz="1_0 0 0"/>'),
                      ":2: joint 'j': xyz of <origin> is '1_0'"),
    "a length of 1e200": ("urdf", urdf('<origin xyz="1e200 0 0"/>'),
                          ":2: joint 'j': xyz of <origin> is 1e+200, beyond 1e+60"),
    "an axis of 1e200": ("urdf", urdf('<axis xyz="1e200 1e200 0"/>'),
                         "xyz of <axis> is 1e+200, beyond 1e+60"),
    "an integer of 5000 digits": ("toml", ONE.format(f"mass = {LONG}", ""),
                                  ":5: a number has more than 4300"),
    "a text of 5000 digits": ("toml", ONE.format("mass = 1", f'limits = {{ lower = "{LONG}x" }}'),
                              ":12: joint 'j', l"),
    "a bar of 1e200": ("toml", ONE.format("mass = 1\nshape = { bar = { length = 1e200 } }", ""),
                       ":6: link 'arm', bar: length is 1e+200, beyond"),
    "full-width degrees": ("toml", ONE.format("mass = 1", 'rpy = ["３０ deg", 0, 0]'),
                           ":12: joint 'j': rpy[0] is '３"),
    "gravity of 1e200": ("toml", 'gravity = [0, 1e200]\n[planar]\nword = "R"',
                         ":1: gravity[1] is 1e+200, beyond"),
    "an empty name": ("csv", "# name:\n" + TABLE + "R,1,0,1\n", ":1: name is empty"),
    "infinite gravity": ("csv", "# gravity: 1e999\n" + TABLE + "R,1,0,1\n",
                         ":1: gravity is '1e999', expected"),
    "a cell of 131 073 characters": ("csv", TABLE + "R,1,0," + "9" * 131_073,
                                     ":3: this is not a line of a CSV table"),
    "underscores in a table": ("csv", TABLE + "R,1_0,0,1\n",
                               ":3: dh row 1: a is '1_0', expected a number or a name."),
    "1e200 in a table": ("csv", TABLE + "R,1e200,0,1\n", ":3: dh row 1: a is 1e+200, beyond 1e+60"),
}  # fmt: skip


@pytest.mark.parametrize("case", BAD)
def test_numbers_and_names_that_are_none_are_errors_of_the_input(tmp_path, case: str):
    suffix, text, words = BAD[case]
    assert words in refusal(lambda: load(text, tmp_path / f"x.{suffix}"))


MOTIONS = {
    "a cell of 131 073 characters": ("0" * 131_073, ":2: this is not a line of a CSV table"),
    "5000 digits": (LONG, ":2: column 'joint1': '1111"),
    "full-width digits": ("１", ":2: column 'joint1': '１' is not a number."),
    "an underscore": ("1_0", ":2: column 'joint1': '1_0' is not a number."),
    "infinity": ("infinity", "'infinity' is not a finite number."),
    "1e200": ("1e200", "'1e200' is beyond 1e+60"),
}


@pytest.mark.parametrize("case", MOTIONS)
def test_a_motion_with_what_is_no_number(tmp_path, case: str):
    cell, words = MOTIONS[case]
    path = tmp_path / "m.csv"
    path.write_text(
        f"t,joint1,joint2\n0,{cell},0\n" + "".join(f"{k},0,0\n" for k in range(1, 9)),
        encoding="utf-8",
    )
    assert words in refusal(lambda: read_motion(fb.load("2R"), path))


@pytest.mark.parametrize(
    "values", ["1_0, 0", "１, 0", "nan, 0", "infinity, 0", "1e999, 0", "1e200, 0", LONG + ", 0"]
)
def test_positions_on_the_command_line_that_are_no_numbers(
    tmp_path, monkeypatch, capsys, values: str
):
    monkeypatch.chdir(tmp_path)
    assert run(["fbd", "2R", "--q", values]) == 2
    error = capsys.readouterr().err
    assert "is not a number that can be used" in error
    assert len(error) < 500


@pytest.mark.parametrize("value", ["1_0e-9", "１e-9", "nan", "1e999"])
@pytest.mark.parametrize("option", ["--snap-angles", "--estimate-inertia"])
def test_options_that_are_no_numbers(capsys, option: str, value: str):
    assert run(["show", "2R", option, value]) == 2
    assert "is not a number that can be used" in capsys.readouterr().err


def test_an_answer_with_digits_of_another_script():
    assert "has no meaning here" in refusal(lambda: fb.check(fb.load("2R"), "H22 = 1２ I2"))


def test_a_command_of_thousands_of_letters_is_said_shortly():
    assert "the command \\begegeg" in refusal(
        lambda: fb.check(fb.load("2R"), "\\b" + "eg" * 9000 + " = 1")
    )


def test_a_name_with_thousands_of_digits_is_no_advice(tmp_path):
    joint = '<joint name="k" type="fixed"><parent link="l7"/><child link="base"/></joint>'
    text = ARM.format(body=BODY, inner="").replace(
        "</robot>", f'<link name="l{LONG}"/>{joint}</robot>'
    )
    assert "no parent link 'l7'" in refusal(lambda: load(text, tmp_path / "x.urdf"))


def test_numbers_given_in_python():
    for given in (10**400, 10**5000, 1e200):
        text = refusal(lambda given=given: fb.planar("R", l=[given]))
        assert text.startswith("planar: l[0]: ")
    assert "is not a number" in refusal(lambda: fb.planar("R", l=[[10**5000]]))
    assert "is not a number" in refusal(lambda: fb.load("2R", snap_angles="x"))
    assert "too large" in refusal(lambda: fb.Inertia.bar(1.0, 1e100))
    for size in (1e200, 1e300):
        assert "finite" in refusal(lambda size=size: fb.Inertia.cylinder(1.0, size, 1.0))


@pytest.mark.parametrize("size", [1e-310, 1e-200, 1e-20, 1.0, 1e59])
def test_an_axis_of_any_size_is_made_a_unit_vector(tmp_path, size: float):
    model = load(urdf(f'<axis xyz="{size} {size} 0"/>'), tmp_path / "x.urdf")
    assert model.bodies[0].joint.axis == pytest.approx((0.5**0.5, 0.5**0.5, 0.0), abs=1e-15)


# ---------------------------------------------------------------- patterns that would try every way
# to divide a text
MANY = 60_000


@pytest.mark.parametrize(
    "cell",
    [
        "9" * MANY + "x",
        "1" + " " * MANY + "x!",
        "9" * MANY + "." + "9" * MANY + "e!",
        "1." + "1" * MANY + " deg!",
    ],
)
def test_long_digits_and_blanks_take_no_longer_than_their_length(tmp_path, cell: str):
    assert "expected a number or a name" in refusal(
        lambda: load(TABLE + f"R,{cell},0,1\n", tmp_path / "x.csv")
    )
    assert "expected a number or a name" in refusal(
        lambda: load(ONE.format(f'mass = "{cell}"', ""), tmp_path / "x.toml")
    )
    assert run(["fbd", "2R", "--q", cell]) == 2


def test_long_blanks_in_remarks_and_answers(tmp_path):
    text = f"# source: a{' ' * MANY}b\n{TABLE}R,1,0,1\n"
    start = time.process_time()
    assert len(load(text, tmp_path / "x.csv").source) == MANY + 2
    assert time.process_time() - start < 2.0
    for answer in (
        "a" + " " * 19_000,
        "a" + " " * 9000 + "&" + " " * 9000 + "b",
        "a" + " " * 18_000 + "= 1",
    ):
        assert refusal(lambda answer=answer: fb.check(fb.load("2R"), answer)).startswith("check: ")
