"""Masses of a file that are missing, placeholders or implausible are found, and estimated where
that is asked for."""

from __future__ import annotations

import os
import struct
import warnings
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import FileError, FreebodyError, Inertia
from support.command import run
from support.extras import extra

LENGTHS = (0.4, 0.3, 0.2)
BOX = "<collision><origin xyz='{x} 0 0'/><geometry><box size='{l} 0.1 0.1'/></geometry></collision>"


@pytest.fixture(autouse=True)
def in_a_folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.chdir(tmp_path)


def inertial(mass: float, *diagonal: float, at: str = "0.1 0 0") -> str:
    xx, yy, zz = diagonal
    return (
        f"<inertial><origin xyz='{at}'/><mass value='{mass}'/>"
        f"<inertia ixx='{xx}' iyy='{yy}' izz='{zz}' ixy='0' ixz='0' iyz='0'/></inertial>"
    )


def good(k: int) -> str:
    """What fits link k, a steel tube."""
    mass = 3.1 - 0.7 * k
    return inertial(mass, 0.0031, mass * LENGTHS[k] ** 2 / 11, mass * LENGTHS[k] ** 2 / 11)


def arm(inertials: list[str], shape: str | None = BOX) -> str:
    """Three links in a row; the shapes of link k from `shape`, filled with its length."""
    text = "<robot name='arm'><link name='base'/>"
    x = 0.0
    for k, inside in enumerate(inertials):
        own = shape.format(l=LENGTHS[k], x=LENGTHS[k] / 2) if shape else ""
        text += f"<link name='link{k}'>{inside}{own}</link>"
        parent = f"link{k - 1}" if k else "base"
        text += (
            f"<joint name='j{k}' type='revolute'><origin xyz='{x} 0 0'/><parent link='{parent}'/>"
            f"<child link='link{k}'/><axis xyz='0 1 0'/><limit lower='-2' upper='2' velocity='3' "
            f"effort='{200 - 20 * k}'/></joint>"
        )
        x = LENGTHS[k]
    Path("arm.urdf").write_text(text + "</robot>")
    return "arm.urdf"


def said(file: str, **options) -> list[str]:
    """What is warned about, which is what the file's doubts say."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", fb.MassWarning)
        model = fb.load(file, **options)
    texts = [str(w.message) for w in caught if issubclass(w.category, fb.MassWarning)]
    kinds = ("no masses", "implausible inertias")
    doubts = [doubt for doubt in model.doubts if doubt.kind in kinds]
    assert texts == [f"warning: {doubt}" for doubt in doubts]
    return [doubt.text for doubt in doubts]


# ------------------------------------------------------------ found
def test_sound_masses_are_not_doubted():
    assert said(arm([good(0), good(1), good(2)])) == []


def test_a_robot_without_masses_does_not_pass(capsys: pytest.CaptureFixture[str]):
    assert run(["study", arm(["", "", ""])]) == 1
    told = capsys.readouterr()
    start = (
        "the torques cannot be trusted: 3 of 3 moving bodies have no mass: link0, link1 and link2"
    )
    assert " ".join(told.out.split()).startswith(f"Not judged: {start}")
    assert told.err.count("have no mass") == 1
    assert "--estimate-inertia" in told.err
    study = fb.study(fb.load("arm.urdf"))
    assert study.finding
    assert not study.passed
    page = study.to_html("page.html").read_text(encoding="utf-8")
    assert 'class="ruling poor"' in page
    assert study.worst.text.startswith(
        "With the masses of the file, which are in doubt: no drive needs"
    )


def test_speeds_are_judged_without_masses():
    model = fb.load(arm(["", "", ""]))
    t = np.linspace(0, 1, 21)
    verdict = fb.study(model, fb.Motion.of(model, t, np.outer(t**2, [2.0, 0, 0]))).verdict
    assert verdict.text.startswith(
        "Not feasible: the speed of j0 is 4 rad/s at t = 1 s, 133 % of its limit of 3 rad/s."
    )
    assert "The torques cannot be trusted" in verdict.text


def test_what_carries_others_without_shape_or_mass_is_no_finding():
    """Several freedoms in one place are written with links in between that are nothing."""
    assert said(arm(["", good(1), good(2)], shape=None)) == []
    assert said(arm([good(0), good(1), ""], shape=None))[0].startswith(
        "1 of 3 moving bodies has no mass: link2"
    )
    assert said(arm([good(0), "", good(2)]))[0].startswith(
        "1 of 3 moving bodies has no mass: link1"
    )


def test_placeholders_are_found():
    two = inertial(2, 0.01, 0.01, 0.01)
    assert said(arm([two, two, two]))[0].startswith(
        "3 links have the same placeholder inertia (2 kg, 0.01 kg m²): link0, link1 and link2"
    )
    odd = inertial(2.137, 0.0113, 0.0273, 0.0279)
    assert "placeholder" in said(arm([odd, odd, odd]))[0]
    assert said(arm([odd, odd, good(2)])) == []  # two modules alike


def test_legs_may_be_alike():
    legs = "".join(
        f"<link name='leg{k}'>{inertial(2, 0.01, 0.01, 0.01)}{BOX.format(l=0.3, x=0.15)}</link>"
        f"<joint name='hip{k}' type='continuous'><parent link='base'/><child "
        f"link='leg{k}'/></joint>"
        for k in range(4)
    )
    Path("dog.urdf").write_text(f"<robot name='dog'><link name='base'/>{legs}</robot>")
    assert said("dog.urdf") == []


@pytest.mark.parametrize(
    ("wrong", "text"),
    [
        (
            inertial(1.3, 1.1, 1.2, 1.3),
            "inertia far too large for the body: link1 (radius of gyration 1 m,",
        ),
        (
            inertial(1.3, 1e-9, 1e-9, 1e-9),
            "inertia far too small for the body: link1 (radius of gyration ",
        ),
        (
            inertial(1.3, 0.003, 0.01, 0.01, at="120 0 0"),
            "centre of mass far outside the body: link1 (1.2e+02 m",
        ),
        (
            inertial(90.0, 0.15, 0.71, 0.72),
            "mass that does not fit the shape: link1 (90 kg in 3 litres)",
        ),
        (
            inertial(0.011, 3e-5, 9e-5, 9e-5),
            "mass that does not fit the shape: link1 (0.011 kg in 3 litres)",
        ),
    ],
)
def test_implausible_inertias_are_found(wrong: str, text: str):
    assert said(arm([good(0), wrong, good(2)]))[0].startswith(text)


@pytest.mark.parametrize(
    ("geometry", "size"),
    [
        ("<box size='0.3 0.1 0.1'/>", 0.15 + 0.5 * np.hypot(0.3, np.hypot(0.1, 0.1))),
        ("<cylinder radius='0.2' length='0.3'/>", 0.15 + 0.25),
        ("<sphere radius='0.3'/>", 0.15 + 0.3),
    ],
    ids=["box", "cylinder", "sphere"],
)
def test_a_link_is_as_large_as_the_farthest_point_of_its_shape(geometry: str, size: float):
    shape = "<collision><origin xyz='0.15 0 0'/><geometry>" + geometry + "</geometry></collision>"
    (text,) = (
        x
        for x in said(arm([good(0), inertial(1.3, 1.1, 1.2, 1.3), good(2)], shape))
        if "large" in x
    )
    assert f"link1 (radius of gyration 1 m, its size {size:.2g} m)" in text


def test_what_never_turns_a_bearing_is_not_held_against_the_first_link():
    """Of a link on the ground only the inertia about its joint is felt; identified models leave the
    rest open."""
    assert said(arm([inertial(3, 1.3, 0.02, 1.3), good(1), good(2)])) == []


def test_doubts_are_told_once_and_can_be_silenced():
    model = fb.load(arm(["", "", ""]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        quiet = fb.load("arm.urdf", physical="ignore")
    # the verdict knows all the same
    assert [doubt.kind for doubt in quiet.doubts].count("no masses") == 1
    assert fb.study(model).verdict.doubts == fb.study(quiet).verdict.doubts


# ------------------------------------------------------------ estimated
def test_estimates_are_those_of_the_shapes_at_one_density():
    model = fb.load(arm([good(0), "", inertial(2, 1, 1, 1)]), estimate_inertia=9.0)
    assert model.mass == pytest.approx(9.0)
    density = 9.0 / (0.01 * sum(LENGTHS))
    for k, body in enumerate(model.bodies):
        (part,) = body.inertias
        mass, com, tensor = part.inertia.numbers()
        want = Inertia.box(density * 0.01 * LENGTHS[k], (LENGTHS[k], 0.1, 0.1)).numbers()
        assert mass == pytest.approx(want[0])
        np.testing.assert_allclose(com, [LENGTHS[k] / 2, 0, 0], atol=1e-15)
        np.testing.assert_allclose(tensor, want[2], atol=1e-15)
    assert model.is_estimated
    assert said("arm.urdf", estimate_inertia=9.0) == []


def test_cylinders_spheres_and_turned_shapes():
    shape = (
        "<visual><origin xyz='0 0 {x}' rpy='0 1.5707963267948966 0'/><geometry><cylinder "
        "radius='0.05' length='{l}'/>"
        "</geometry></visual><visual><origin xyz='0.2 0 0'/><geometry><sphere "
        "radius='0.1'/></geometry></visual>"
    )
    model = fb.load(arm(["", "", ""], shape), estimate_inertia=7.0)
    tube, ball = (np.pi * 0.05**2 * LENGTHS[0], 4 / 3 * np.pi * 0.1**3)
    whole = sum(np.pi * 0.05**2 * length + ball for length in LENGTHS)
    mass, com, tensor = model.bodies[0].inertias[0].inertia.numbers()
    assert mass == pytest.approx(7.0 * (tube + ball) / whole)
    np.testing.assert_allclose(
        com, np.array([0.2 * ball, 0, 0.2 * tube]) / (tube + ball), atol=1e-15
    )
    turned = np.diag(np.diag(Inertia.cylinder(tube, 0.05, LENGTHS[0]).numbers()[2])[[2, 1, 0]])
    parts = (
        (tube, [0, 0, 0.2], turned),
        (ball, [0.2, 0, 0], Inertia.sphere(ball, 0.1).numbers()[2]),
    )
    expected = sum(
        I + m * (d @ d * np.eye(3) - np.outer(d, d))
        for m, c, I in parts
        for d in [np.array(c) - com]
    )
    np.testing.assert_allclose(tensor, 7.0 / whole * expected, atol=1e-14)


def test_an_estimate_is_not_judged_nor_a_finding_and_it_is_marked_everywhere(
    capsys: pytest.CaptureFixture[str],
):
    file = arm(["", "", ""])
    assert run(["study", file, "--estimate-inertia", "9", "--out", "o"]) == 0
    told = capsys.readouterr()
    assert told.err == ""
    assert told.out.startswith(
        "Not judged: the inertias of 3 links are estimated from their shapes"
    )
    assert "Every limit is kept by the estimates; nearest: " in " ".join(told.out.split())
    page = Path("o/report.html").read_text(encoding="utf-8")
    assert "<strong>Not judged:</strong> the inertias of 3 links are estimated" in page
    assert "9.000 kg (estimated)" in page
    assert "Mass, estimated" in page
    assert run(["show", file, "--estimate-inertia", "9"]) == 0
    out = capsys.readouterr().out
    assert "9 kg, estimated; gravity" in out
    assert "mass, estimated" in out
    assert (
        "assuming a uniform density of 1000 kg/m³ so that their total mass is 9 kg; "
        "links without shapes have none: base" in out
    )


def test_what_is_doubtful_or_estimated_is_so_in_the_saved_file_too():
    for options, outcome in (
        ({}, "Not judged: the torques cannot"),
        ({"estimate_inertia": 9.0}, "Not judged: the inertias of 3 links are estimated"),
    ):
        model = fb.load(arm(["", "", ""]), **options)
        fb.save(model, "saved.toml")
        again = fb.load("saved.toml")
        assert again.is_estimated == model.is_estimated
        assert fb.study(again).verdict.text.startswith(outcome)
    assert said("saved.toml") == []


def test_estimates_that_cannot_be_made_are_refused(capsys: pytest.CaptureFixture[str]):
    with pytest.raises(FileError, match="no link has a shape that fills a volume"):
        fb.load(arm(["", "", ""], shape=None), estimate_inertia=9.0)
    with pytest.raises(
        FreebodyError, match=r"needs the shapes of a URDF, and 'ur5e' comes from none"
    ):
        fb.load("ur5e", estimate_inertia=9.0)
    for mass in (0.0, -1.0, float("nan")):
        with pytest.raises(FreebodyError, match="expected the robot's whole mass, kg above 0"):
            fb.load(arm(["", "", ""]), estimate_inertia=mass)
    mesh = "<visual><geometry><mesh filename='package://robot/no{l}.stl'/></geometry></visual>"
    with pytest.raises(
        FileError, match=r"link 'link0': its mesh 'package://robot/no0\.4\.stl' was not found"
    ):
        fb.load(arm(["", "", ""], mesh), estimate_inertia=9.0)
    assert run(["study", "arm.urdf", "--estimate-inertia", "9"]) == 2
    assert "was not found" in capsys.readouterr().err


def test_a_mass_that_cannot_fill_the_shapes_is_said():
    (text,) = said(arm(["", "", ""]), estimate_inertia=9000.0)
    assert text == "9000 kg is implausible for the shapes in the file, whose volume is 9 litres."


def test_a_link_that_has_no_shape_is_still_missing():
    file = arm([good(0), good(1), good(2)])
    text = Path(file).read_text()
    Path(file).write_text(text.replace(BOX.format(l=LENGTHS[2], x=LENGTHS[2] / 2), ""))
    assert said(file, estimate_inertia=9.0) == ["1 of 3 moving bodies has no mass: link2."]


def stl(path: Path, size: tuple[float, float, float]) -> None:
    """A box about the origin as a binary STL file."""
    corner = (
        np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)]) * size
    )
    faces = ((0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3))
    triangles = [t for a, b, c, d in faces for t in ((a, b, c), (a, c, d))]
    data = b"\0" * 80 + struct.pack("<I", len(triangles))
    for triangle in triangles:
        data += struct.pack("<12fH", 0, 0, 0, *corner[list(triangle)].ravel(), 0)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_bytes(data)


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="this system has no named pipes")
def test_a_mesh_that_is_a_pipe_or_of_a_foreign_kind_is_refused_at_once():
    extra("trimesh")
    Path("robot/meshes").mkdir(parents=True)
    os.mkfifo("robot/meshes/link.stl")
    Path("robot/meshes/link.zip").write_bytes(b"PK")
    for kind, problem in (
        ("stl", "was not found"),
        ("zip", r"link\.zip' is not of the formats \.stl, \.obj, \.ply, \.dae"),
    ):
        mesh = f"<visual><geometry><mesh filename='package://robot/meshes/link.{kind}'/></geometry></visual>"
        with pytest.raises(FileError, match=problem):
            fb.load(arm(["", "", ""], mesh), estimate_inertia=6.0)


def test_a_flat_mesh_is_refused_by_its_volume(recwarn):
    extra("trimesh")
    stl(Path("robot/meshes/link.stl"), (0.2, 0.1, 0.0))
    mesh = (
        "<visual><geometry><mesh filename='package://robot/meshes/link.stl'/></geometry></visual>"
    )
    with pytest.raises(FileError, match=r"link\.stl' cannot be read: .* enclose no volume\."):
        fb.load(arm(["", "", ""], mesh), estimate_inertia=6.0)
    assert not recwarn


def test_meshes_weigh_what_they_enclose():
    extra("trimesh")
    stl(Path("robot/meshes/link.stl"), (200.0, 100.0, 100.0))
    mesh = (
        "<visual><origin xyz='{x} 0 0'/><geometry>"
        "<mesh filename='package://robot/meshes/link.stl' scale='0.001 0.001 "
        "0.001'/></geometry></visual>"
    )
    model = fb.load(arm(["", "", ""], mesh), estimate_inertia=6.0)
    mass, com, tensor = model.bodies[0].inertias[0].inertia.numbers()
    assert mass == pytest.approx(2.0)
    np.testing.assert_allclose(com, [LENGTHS[0] / 2, 0, 0], atol=1e-9)
    np.testing.assert_allclose(tensor, Inertia.box(2.0, (0.2, 0.1, 0.1)).numbers()[2], atol=1e-9)
