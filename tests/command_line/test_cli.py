"""The command line: examples of its help run, errors are one line with exit code 2, findings give
1."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path

import pytest

import freebody as fb
from support.command import error, run

EMPTY = '<robot name="a"><link name="x"/></robot>'


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)


def program(*arguments: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-m", "freebody", *arguments], capture_output=True, text=True, check=False
    )


def test_study_writes_a_report_and_data(capsys: pytest.CaptureFixture[str]):
    assert run(["study", "2R"]) == 0
    said = capsys.readouterr()
    assert said.err == ""
    lines = said.out.splitlines()
    assert lines.pop(0) == (
        "Not judged: the description lacks an effort limit, a speed limit and a position range of "
        "joint1 and joint2."
    )
    assert lines[0] == (
        "2R: 2 coordinates. Motion: by default every joint swings within its limits, from rest to "
        "rest in 5 s."
    )
    assert lines[1] == "The tip is 'tip', as the robot's description says."
    assert lines.pop(2) == (
        "Load: none. Mounting: base fixed, gravity (0, -9.81) m/s² in world axes."
    )
    card = lines[2 : (drives := next(k for k, x in enumerate(lines) if x.startswith("joint  ")))]
    assert [row.partition("  ")[0] for row in card[1:] if row[0] != " "] == [
        "carries", "can be run", "gives out first",
    ]  # fmt: skip
    del lines[2:drives]
    assert re.split("  +", lines[2].strip()) == [
        "joint", "peak torque", "at", "RMS torque", "peak speed", "peak power",
    ]  # fmt: skip
    assert lines[3].startswith("joint1 ")
    assert re.search(
        r"^Self-checks: freebody's results are consistent in all \d\.$", said.out, re.MULTILINE
    )
    assert lines[-3:] == [
        "report: study-2R/report.html",
        "data:   study-2R/study.nc and CSV tables beside it",
        "again:  freebody study 2R",
    ]
    assert Path("study-2R/report.html").stat().st_size > 10_000
    assert Path("study-2R/study.nc").exists()
    assert (
        run(["study", "2R", "--motion", "study-2R/motion.csv", "--out", "again"]) == 0
    )  # what it writes, it reads
    told = capsys.readouterr().out  # 401 samples, and where a load has its peak between two
    assert re.search(r"Motion: read from motion.csv, 40[1-9] rows; rates as given\.", told)


def test_doubtful_inertias_are_yellow_lines_and_stand_in_the_report(
    capsys: pytest.CaptureFixture[str],
):
    Path("rod.toml").write_text(
        """
        link = [
            { name = "base" },
            { name = "rod", mass = 1, com = [0.5, 0, 0], inertia = [0, 0, 0, 0, 0, 0.35] },
        ]
        joint = [{ name = "pin", kind = "revolute", parent = "base", child = "rod", axis = "z" }]
        """,
        encoding="utf-8",
    )
    assert run(["study", "rod.toml"]) == 0
    said = capsys.readouterr().err.splitlines()
    text = (
        "link 'rod': principal moments 0, 0, 0.35 kg m² break the triangle inequality (0 + 0 "
        "< 0.35)."
    )
    assert re.fullmatch(rf"rod\.toml:4: warning: {re.escape(text)}", said[0])
    assert len(said) == 1
    page = Path("study-rod/report.html").read_text(encoding="utf-8")
    assert "break the triangle inequality" in page
    assert run(["study", "rod.toml", "--physical", "ignore", "--out", "out"]) == 0
    assert capsys.readouterr().err == ""
    assert "accept it with" in error(capsys, "study", "rod.toml", "--physical", "refuse")
    assert run(["show", "puma560"]) == 0  # whose published inertias are doubtful
    assert re.match(r"puma560\.toml:\d+: warning: link 'link1': ", capsys.readouterr().err)


def test_limits_that_are_left_are_yellow_lines(capsys: pytest.CaptureFixture[str]):
    rows = "\n".join(f"{k},0,{k},0,0,0,0" for k in range(8))
    Path("m.csv").write_text(f"t,{','.join(fb.load('ur5e').position_names)}\n{rows}\n")
    assert run(["study", "ur5e", "--motion", "m.csv"]) == 1
    said = capsys.readouterr()
    assert said.out.startswith(
        "Not feasible: shoulder_lift_joint goes to 7 rad at t = 7 s, beyond its upper limit 6.283"
    )
    said = said.err
    assert "warning: shoulder_lift_joint leaves its range: the motion spans 0 to 7 rad" in said


def test_show(capsys: pytest.CaptureFixture[str]):
    assert run(["show", "panda"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("panda: 9 bodies in space, nq = 8, nv = 8, ")
    assert "└── panda_link1  (panda_joint1, revolute)" in out
    assert "├── panda_leftfinger  (panda_finger_joint1, prismatic)" in out
    assert re.search(r"panda_finger_joint2 +prismatic .* 1 × panda_finger_joint1 \+ 0", out)
    assert "frames: panda_link0, " in out
    assert run(["show", "2R", "--base", "free"]) == 0
    assert "base (planar" not in capsys.readouterr().out.splitlines()[0]
    assert run(["show", "template:scara", "--parameter", "m2=5.5", "--parameter", "I2=0.08"]) == 0
    out = capsys.readouterr().out
    assert re.search(r"^joint2 .* 5\.5 kg = m2", out, re.MULTILINE)
    assert re.search(r"^numbers: .* l1 = 0\.425, .* m2 = 5\.5, ", out, re.MULTILINE)
    assert "x1 = " in out.partition("\nformulas: ")[2]
    assert out.rstrip().endswith("still so for arm, quill and hand.")


def test_show_says_when_all_joints_of_a_closed_chain_count_as_drives(
    capsys: pytest.CaptureFixture[str],
):
    assert run(["show", "bricard"]) == 0
    assert "driven: all joints, because none is marked as passive" in capsys.readouterr().out
    assert run(["show", "four_bar"]) == 0
    assert "driven: all joints" not in capsys.readouterr().out


def test_models(capsys: pytest.CaptureFixture[str]):
    assert run(["models"]) == 0
    out = capsys.readouterr().out
    for name in fb.models():
        assert re.search(rf"^{name}\n    \S", out, re.MULTILINE)


def test_version_and_help(capsys: pytest.CaptureFixture[str]):
    assert run(["--version"]) == 0
    assert capsys.readouterr().out == f"freebody {fb.__version__}\n"
    assert run([]) == 0
    assert "Usage: freebody" in capsys.readouterr().out


def test_help_needs_nothing_heavy():
    code = (
        "import sys, freebody.cli.app as a; a.run(['--help']); "
        "print([m for m in ('scipy', 'xarray', 'llvmlite', 'matplotlib', 'pydantic') if m in "
        "sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.splitlines()[-1] == "[]"


def test_what_is_no_robot_is_refused(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    Path("empty.urdf").touch()
    Path("folder.urdf").mkdir()
    Path("binary.urdf").write_bytes(bytes(range(256)))
    Path("short.urdf").write_text('<robot name="a">\n<link name="x">\n')
    Path("still.urdf").write_text(EMPTY)
    assert error(capsys, "study", "nothing.urdf").startswith("nothing.urdf: there is no such file.")
    assert error(capsys, "study", "empty.urdf") == "empty.urdf: the file is empty."
    assert (
        error(capsys, "study", "folder.urdf") == "folder.urdf: this is a folder; name a file in it."
    )
    assert error(capsys, "study", "binary.urdf") == "binary.urdf: the file is binary, not text."
    assert error(capsys, "study", "short.urdf") == (
        "short.urdf:3: the file ends inside <link>, opened on line 2; it seems to be truncated."
    )
    assert error(capsys, "show", "robot.xyz").endswith(
        "it reads .urdf, .xacro, .xml, .mjcf, .sdf, .toml, .csv."
    )
    assert "no model 'ur5' in the bundled models. Did you mean 'ur5e'?" in error(
        capsys, "study", "ur5"
    )
    assert "has no movable joint" in error(capsys, "study", "still.urdf")


def test_bad_motions_tips_and_options_are_refused(capsys: pytest.CaptureFixture[str]):
    Path("m.csv").write_text("t,joint1,jont2\n0,1,2\n")
    assert error(capsys, "study", "2R", "--motion", "m.csv").startswith(
        "m.csv:1: no column 'jont2' in a motion of '2R'. Did you mean 'joint2'?"
    )
    assert (
        error(capsys, "study", "2R", "--motion", "none.csv") == "none.csv: there is no such file."
    )
    assert error(capsys, "study", "2R", "--tip", "tipp") == (
        "no frame 'tipp' in '2R'. Did you mean 'tip'? Frames: base, link1, link2, tip."
    )
    assert "'flying' is not one of 'fixed', 'free'" in error(
        capsys, "study", "2R", "--base", "flying"
    )
    assert "No such option: --nope" in error(capsys, "study", "2R", "--nope")
    assert error(capsys, "study").startswith("Missing argument")
    assert "No such command 'studdy'" in error(capsys, "studdy")
    assert "snap_angles is 3.0" in error(capsys, "show", "2R", "--snap-angles", "3")
    Path("file").touch()
    assert error(capsys, "study", "2R", "--out", "file") == (
        "file: there is a file of that name; name a folder instead."
    )


def test_a_line_stays_a_line(capsys: pytest.CaptureFixture[str]):
    assert "\\n long word word" in error(capsys, "show", "a\n  long " + "word " * 60)


def test_what_cannot_be_compared_is_refused_before_anything_is_printed_or_written(
    capsys: pytest.CaptureFixture[str],
):
    for way in ([], ["--out", "derivation.txt"]):
        assert run(["derive", "2R", "--compare", "statics", *way]) == 2
        said = capsys.readouterr()
        assert said.out == ""
        assert said.err.startswith("error: compare: one derivation has a load on the tip")
    assert not Path("derivation.txt").exists()


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    ("name", "start"),
    [
        ("a.html", "<!doctype html>"),
        ("a.HTM", "<!doctype html>"),
        ("a.tex", "\\documentclass"),
        ("a.md", "# "),
        ("a.txt", "2R: "),
    ],
)
def test_the_ending_of_a_file_says_how_a_derivation_is_written(name, start, tmp_path):
    assert run(["derive", "2R", "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / name).read_text(encoding="utf-8").lstrip().lower().startswith(start.lower())
    assert run(["derive", "2R", "--form", "text", "--out", str(tmp_path / name)]) == 0
    assert (tmp_path / name).read_text(encoding="utf-8").startswith("2R: ")


def test_derive_prints_writes_and_compares(capsys: pytest.CaptureFixture[str], tmp_path: Path):
    assert run(["derive", "2R", "--method", "lagrange", "--compare", "recursive"]) == 0
    text = capsys.readouterr().out
    assert "H₁₁ = m₁ lc₁² + I₁ + m₂ (l₁² + lc₂² + 2 l₁ lc₂ cos θ₂) + I₂" in text
    assert "tau1: 15 terms, identical" in text
    page = tmp_path / "statics.html"
    assert run(["derive", "2R", "--method", "statics", "--form", "html", "--out", str(page)]) == 0
    assert page.read_text(encoding="utf-8").startswith("<!doctype html>")
    assert run(["derive", "quadrotor"]) == 0
    assert "Newton" in capsys.readouterr().out
    assert run(["derive", "stewart", "--method", "lagrange"]) == 2
    assert "stewart" in capsys.readouterr().err


def test_derive_takes_the_options_of_its_methods(capsys: pytest.CaptureFixture[str]):
    assert run(["derive", "2R", "--method", "recursive", "--weights", "explicit", "--load"]) == 0
    assert "f₁₂ = fc₂ − m₂ g − f" in capsys.readouterr().out
    assert run(["derive", "2R", "--method", "recursive", "--gravity", "explicit", "--load"]) == 0
    said = capsys.readouterr()
    assert "f₁₂ = fc₂ − m₂ g − f" in said.out
    assert "is now written --weights explicit" in said.err
    assert run(["derive", "2R", "--gravity", "inside"]) == 2
    assert "--gravity 'inside': write the field x,y" in capsys.readouterr().err
    assert run(["derive", "pendulum", "--route", "pivot"]) == 0
    assert "I_A = I₁ + m₁ lc₁²" in capsys.readouterr().out
    assert run(["derive", "2R", "--method", "lagrange", "--route", "pivot"]) == 2
    assert (
        "derive 'lagrange': route is an option of 'newton-euler'; leave it out."
        in capsys.readouterr().err
    )


def test_thousands_of_warnings_are_counted_not_printed(capsys: pytest.CaptureFixture[str]):
    thin = (
        '<inertial><mass value="1"/><inertia ixx="9" iyy="1" izz="1" ixy="0" ixz="0" '
        'iyz="0"/></inertial>'
    )
    links = "".join(f'<link name="x{i}">{thin}</link>' for i in range(400))
    joints = "".join(
        f'<joint name="j{i}" type="fixed"><parent link="x{i}"/><child link="x{i + 1}"/></joint>'
        for i in range(399)
    )
    Path("thin.urdf").write_text(f'<robot name="a">{links}{joints}</robot>')
    run(["show", "thin.urdf"])
    said = capsys.readouterr().err.splitlines()
    assert 10 < len(said) < 60
    assert re.fullmatch(r"warning: and 3\d\d more such warnings; .*", said[-1])


SCREW = """
[[link]]
name = "stand"
[[link]]
name = "nut"
mass = 1
[[joint]]
name = "screw"
kind = "helical"
parent = "stand"
child = "nut"
axis = "z"
pitch = {pitch}
"""


def test_show_tells_the_root_link_and_a_screws_pitch(tmp_path, capsys):
    path = tmp_path / "press.toml"
    for pitch, said in (("0.0008", "helical, pitch 0.0008 m/rad"), ('"h"', "helical, pitch h")):
        path.write_text(SCREW.format(pitch=pitch), encoding="utf-8")
        assert run(["show", str(path)]) == 0
        out = capsys.readouterr().out
        assert said in out
        assert "\nstand\n└── nut  (screw, helical)" in out
    path.write_text('base = "free"\n' + SCREW.format(pitch=1), encoding="utf-8")
    assert run(["show", str(path)]) == 0
    assert "\nworld\n└── stand  (base, free)" in capsys.readouterr().out


def test_a_wrong_option_leads_to_its_commands_help(capsys):
    assert run(["derive", "2R", "--basis", "free"]) == 2
    assert capsys.readouterr().err.rstrip().endswith("See freebody derive --help.")


def test_derive_replaces_a_universal_and_a_spherical_joint(tmp_path, capsys):
    path, ball = tmp_path / "ball.toml", SCREW.format(pitch=1).replace("helical", "spherical")
    path.write_text(ball.replace('axis = "z"\npitch = 1\n', ""), encoding="utf-8")
    assert run(["derive", str(path), "--method", "lagrange"]) == 0
    assert "yaw, pitch and roll" in capsys.readouterr().out.replace("\n", " ")
    text = path.read_text(encoding="utf-8").replace("spherical", "universal")
    path.write_text(text, encoding="utf-8")
    assert run(["derive", str(path), "--method", "lagrange"]) == 0
    assert "is replaced by joints 1 and 2" in capsys.readouterr().out.replace("\n", " ")
