"""`load` by name and by suffix, and DH tables in CSV."""

import math
import os
import random
from pathlib import Path

import pytest

import freebody as fb
from freebody import Model, Parameter
from support.real_files import ROBOTS

TABLE = "# convention: standard\njoint,a,alpha,m\nR,1,90 deg,2\nP,0.5,0,1\n"


def message(source: object, folder: object = "nowhere at all", **options) -> str:
    """The refusal, which is one line."""
    with pytest.raises(fb.FreebodyError) as refusal:
        fb.load(source, **options)
    assert "\n" not in str(refusal.value)
    return str(refusal.value).replace(f"{folder}/", "")


def csv(tmp_path, text: str, **options) -> Model:
    path = tmp_path / "arm.csv"
    path.write_text(text, encoding="utf-8")
    return fb.load(path, **options)


# ---------------------------------------------------------------- names and suffixes
def test_a_name_is_a_bundled_model(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "2R").write_text(
        "not a robot"
    )  # a file without suffix or folder does not hide the name
    assert fb.load("2R").name == "2R"
    (tmp_path / "2R.toml").write_text('name = "mine"\n[planar]\nword = "R"\n')
    assert (fb.load("2R").name, fb.load("2R.toml").name, fb.load("./2R.toml").name) == (
        "2R",
        "mine",
        "mine",
    )


@pytest.mark.parametrize("name", ["UR5e", "Panda", "2r", "3rrr"])
def test_the_case_of_a_bundled_name_is_free(name):
    known = {model.lower(): model for model in fb.models()}
    assert fb.load(name) == fb.load(known[name.lower()])


def test_unknown_names(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    start = "Did you mean 'ur5e'? Models: 2R, 3R, 3RRR, "
    end = ". A file needs its suffix: .urdf, .xacro, .xml, .mjcf, .sdf, .toml, .csv."
    text = message("ur5")
    assert text.startswith(f"load: no model 'ur5' in the bundled models. {start}")
    assert text.endswith(f" ({len(fb.models())} in all){end}")
    (tmp_path / "robot").write_text("x")
    assert message("robot") == (
        "load: 'robot' is not a bundled model. The file of that name needs a suffix that tells its "
        "format: .urdf, "
        ".xacro, .xml, .mjcf, .sdf, .toml, .csv."
    )
    assert message("2R", tip="hand") == "no frame 'hand' in '2R'. Frames: base, link1, link2, tip."


def test_files_that_are_not_read(tmp_path):
    assert (
        message("arm.step")
        == "arm.step: freebody does not know .step; it reads .urdf, .xacro, .xml, .mjcf, .sdf, "
        ".toml, .csv."
    )
    assert (
        message("./arm")
        == "arm: freebody does not know files without suffix; it reads .urdf, .xacro, .xml, .mjcf, "
        ".sdf, "
        ".toml, .csv."
    )
    assert message(tmp_path, tmp_path.parent).endswith(": this is a folder; name a file in it.")


@pytest.mark.parametrize("suffix", [".urdf", ".toml", ".csv"])
def test_files_that_are_none(tmp_path, suffix: str):
    name = f"arm{suffix}"
    path = tmp_path / name
    assert message(path, tmp_path) == f"{name}: there is no such file."
    (tmp_path / f"arn{suffix}").touch()
    assert message(path, tmp_path) == f"{name}: there is no such file. Similar names: arn{suffix}."
    assert (
        message(f"nowhere/{name}")
        == f"nowhere/{name}: there is no such file: folder 'nowhere' does not exist."
    )
    path.write_text(" \n")
    assert message(path, tmp_path) == f"{name}: the file is empty."
    path.write_bytes(b"\x7fELF\x00\x01")
    assert message(path, tmp_path) == f"{name}: the file is binary, not text."
    path.unlink()
    path.mkdir()
    assert message(path, tmp_path) == f"{name}: this is a folder; name a file in it."
    (path / "robot.urdf").touch()
    assert (
        message(path, tmp_path)
        == f"{name}: this is a folder; name a file in it, such as robot.urdf."
    )


@pytest.mark.skipif(
    os.name == "nt" or os.geteuid() == 0, reason="the superuser may read everything"
)
def test_a_file_that_may_not_be_read(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text("x")
    path.chmod(0)
    assert message(path, tmp_path) == "arm.toml: the file cannot be read: Permission denied."


def test_text_that_is_not_utf8(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_bytes(b"name = 'a'\nsource = 'M\xfcller'\n")
    assert message(path, tmp_path) == "arm.toml:2: the text is not UTF-8; save it as UTF-8."


def test_options():
    assert (
        message("2R", snap_angles=2)
        == "load: snap_angles is 2, expected radians between 0 and 0.1."
    )
    assert (
        message("2R", base="fix")
        == "no option 'fix' in base=. Did you mean 'fixed'? Options: fixed, free."
    )
    assert message("panda", mimic="off") == "no option 'off' in mimic=. Options: follow, free."


@pytest.mark.skipif(not ROBOTS.is_dir(), reason="needs example-robot-data")
def test_damaged_files_are_refused_in_one_line(tmp_path):
    """Cut or altered anywhere, a file loads or is refused by a FreebodyError that names it."""
    data = (ROBOTS / "panda_description/urdf/panda.urdf").read_bytes()
    chance = random.Random(0)
    path = tmp_path / "arm.urdf"
    for _ in range(150):
        damaged = bytearray(data)
        if chance.random() < 0.5:
            del damaged[chance.randrange(len(data)) :]
        for _ in range(chance.randrange(1, 5)):
            damaged[chance.randrange(len(damaged))] = chance.choice(b'<>"/= 0-.ae&')
        path.write_bytes(damaged)
        said = said_by(path)
        assert said.startswith(str(path))
        assert "a second line" not in said


def said_by(path: Path) -> str:
    """The refusal, or the path where there is none."""
    try:
        fb.load(path, physical="ignore")
    except fb.FreebodyError as error:
        return str(error).replace("\n", "a second line")
    return str(path)


# ---------------------------------------------------------------- DH tables
def test_dh_table(tmp_path):
    model = csv(tmp_path, TABLE)
    twin = fb.dh(
        [{"a": 1, "alpha": math.pi / 2, "m": 2}, {"joint": "P", "a": 0.5, "m": 1}],
        convention="standard",
        name="arm",
    )
    assert [(b.joint.placement, b.inertias) for b in model.bodies] == [
        (b.joint.placement, b.inertias) for b in twin.bodies
    ]
    assert (model.name, model.frames, model.tip) == (twin.name, twin.frames, "frame2")


def test_dh_table_in_full(tmp_path):
    columns = "joint; name; theta; d; m; cx; Izz; rotor; gear; viscous; coulomb"
    text = f"""
        # convention: modified
        # name: two
        # source: a book
        # gravity: 1.62
        {columns}; lower; upper; velocity; effort

        # a remark
        R; arm; 0.1; d1; m1; c1; 0.5; 1e-4; 50; 0.1; 0.2; -90 deg; 90 deg; 180 deg/s; 7
        P;;;;;;;;;;;;0.3;;
    """
    model = csv(tmp_path, text)
    first, second = model.bodies
    assert (model.name, model.source, model.gravity_size, model.missing) == (
        "two",
        "a book",
        Parameter("g", 1.62),
        ("c1", "d1", "m1"),
    )
    assert first.joint.limits == fb.Limits(-math.pi / 2, math.pi / 2, math.pi, 7.0)
    assert first.joint.drive == fb.Drive(0.1, 0.2, 1e-4, 50.0)
    assert (first.name, first.inertias[0].inertia.tensor) == ("arm", (0.0, 0.0, 0.0, 0.0, 0.0, 0.5))
    assert (second.joint.kind, second.joint.limits.upper, second.inertias) == ("prismatic", 0.3, ())


def test_dh_convention_is_never_guessed(tmp_path):
    bare = TABLE.split("\n", 1)[1]
    assert csv(tmp_path, bare, convention="modified").nv == 2
    with pytest.raises(fb.FreebodyError,
                       match=r"arm.csv:1: the table does not state its convention; add a line '# "
         "convention: "
                                               r"standard' or '# convention: modified', "
                                               r"or load it with "
                                                r"convention=\."):  # fmt: skip
        csv(tmp_path, bare)
    with pytest.raises(
        fb.FreebodyError,
        match=r"arm.csv:1: the file says its convention is standard, the caller "
        r"modified\.",
    ):
        csv(tmp_path, TABLE, convention="modified")


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("standard", "craig",
         "1: no convention 'craig' in the file. Conventions: standard, modified."),
        ("alpha", "alfa", "2: no column 'alfa' in a DH table. Did you mean 'alpha'? Columns: "
                          "joint, name, theta, d, "
         "a, alpha, m, "
         "cx, cy, cz, Ixx, Ixy, Ixz, Iyy, Iyz, Izz, rotor, gear, viscous, coulomb, lower, upper, "
         "velocity, effort, … (25 in all)."),
        ("joint,a,", "a,a,", "2: column 'a' appears twice; keep one."),
        ("R,1", "R", "3: dh row 1: it has 3 cells, the header 4."),
        ("P,0.5", "Q,0.5", "4: dh row 2: joint is 'Q', expected 'R' or 'P'."),
        ("90 deg", "90 dge",
         "3: dh row 1: alpha is '90 dge', expected a number or a name, or an angle such as 30 "
         "deg."),
        ("0.5", "nan", "4: dh row 2: a is 'nan', expected a number or a name."),
        ("0.5", "1e999", "4: dh row 2: a is inf, not a finite number."),
        ("alpha,m", "alpha,Ixx", "3: dh row 1: com or I without a mass; add m."),
        ("R,1,90 deg,2\nP,0.5,0,1\n", "",
         "2: the table has a header but no rows; add one per joint."),
        (TABLE, "# convention: standard\n",
         " there is no table; the first line names the columns, such as joint, "
         "name, theta, "
         "d, a, alpha."),
        ("# conv", "# gravity: down\n# conv", "1: gravity is 'down', expected a number in m/s²."),
    ],
)  # fmt: skip
def test_dh_refused(tmp_path, old: str, new: str, problem: str):
    path = tmp_path / "arm.csv"
    path.write_text(TABLE.replace(old, new), encoding="utf-8")
    assert message(path, tmp_path) == f"arm.csv:{problem}"
