"""Doubts on a robot: which there are, what each result says of them, and what they bar."""

from __future__ import annotations

import re
import tempfile
from collections.abc import Callable
from dataclasses import replace
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Motion
from freebody.kernels.formulas import FORMULAS
from freebody.model.doubt_rules.aspects import (
    ALL,
    DYNAMIC,
    EFFORTS,
    FRICTION,
    LOADS,
    MASSES,
    RANGES,
    ROTORS,
    SPEEDS,
)
from freebody.model.doubts import DOUBT_KINDS, Doubt, tied
from support.command import run

pytestmark = [
    pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning"),
    pytest.mark.filterwarnings("ignore::freebody.MassWarning"),
]

LIMITS = [fb.Limits(-2.0, 2.0, v, e) for v, e in ((1.9, 95.0), (2.1, 45.0), (2.7, 14.0))]


def arm(limits=LIMITS, rotor: float = 1e-4, **numbers) -> fb.Model:
    """Three links in the plane of which nothing is doubtful."""
    given = {"l": [0.4, 0.3, 0.2], "lc": [0.2, 0.15, 0.1], "m": [3.0, 2.0, 1.0]}
    given |= {"I": [0.04, 0.015, 0.004]} | numbers
    drives = [fb.Drive(viscous=0.3, rotor=rotor, gear=50)] * 3
    return fb.planar("RRR", **given, limits=limits, drives=drives)


def settled(model: fb.Model) -> fb.Model:
    """A model with its file's doubts tied to its numbers, as loading does."""
    return replace(model, notices=tied(model.notices, model))


def told_by_file(kind: str) -> fb.Model:
    """What only a file could tell."""
    return settled(replace(arm(), notices=(Doubt(kind, f"so says the file of {kind}."),)))


def with_first_drive(drive: fb.Drive) -> fb.Model:
    """One that is not checked."""
    model = arm()
    first = model.bodies[0]
    body = replace(first, joint=replace(first.joint, drive=drive))
    return replace(model, bodies=(body, *model.bodies[1:]))


def spatial(*moments: float) -> fb.Model:
    """The arm in space, its last link with these principal moments."""
    model = arm().to_space()
    tensors = [(0.01, 0.04, 0.04), (0.01, 0.015, 0.015), moments]
    bodies = []
    for body, tensor in zip(model.bodies, tensors, strict=True):
        (part,) = body.inertias
        inertia = Inertia(
            part.inertia.mass, part.inertia.com, Inertia.of(1, [0] * 3, np.diag(tensor)).tensor
        )
        bodies.append(replace(body, inertias=(replace(part, inertia=inertia),)))
    return replace(model, bodies=tuple(bodies))


HAVING: dict[str, Callable[[], fb.Model]] = {
    "no masses": lambda: arm(m=[0.0] * 3, I=[0.0] * 3, rotor=1e-2),
    "implausible inertias": lambda: told_by_file("implausible inertias"),
    "impossible inertias": lambda: spatial(0.1, 0.2, 0.5),
    "impossible drives": lambda: with_first_drive(fb.Drive(viscous=-0.1, rotor=1e-4)),
    "placeholder limits": lambda: arm([fb.Limits(-2.0, 2.0, 10.0, 300.0)] * 3),
    "missing limits": lambda: arm([LIMITS[0], fb.Limits(-2.0, 2.0, 2.0), LIMITS[2]]),
    "estimated inertias": lambda: told_by_file("estimated inertias"),
    "estimated limits": lambda: told_by_file("estimated limits"),
    "inexact inertias": lambda: spatial(0.0125, 0.066, 0.08),
    "no rotor inertia": lambda: arm(rotor=0.0),
    "point load": lambda: arm().with_payload(mass=0.7),
}
"""A model with each kind of doubt, and no other."""


@cache
def having(kind: str) -> fb.Model:
    """One object a kind, whose kernels are shared."""
    return HAVING[kind]()


def swing(model: fb.Model) -> Motion:
    """Well within all limits."""
    t = np.linspace(0.0, 1.0, 21)
    return fb.Motion.of(model, t, 0.1 * np.sin(np.pi * t)[:, None] ** 2 * np.ones(model.nv))


@cache
def studied(kind: str) -> fb.Study:
    return fb.study(having(kind), swing(having(kind)))


def _study(model: fb.Model) -> str:
    known = [studied(kind) for kind in HAVING if having(kind) is model]
    return (known or [fb.study(model, swing(model))])[0].verdict.text


def _ends(model: fb.Model) -> list[list[float]]:
    return [[0.1] * model.nv, [0.4] * model.nv]


def _told(motion: Motion) -> str:
    return " ".join(motion._table().notes)


def _swept(model: fb.Model) -> str:
    q = np.zeros((2, model.nv))
    found = fb.sweep(model, "gravity_torque", over={"state": {"q": q}})
    return str(found.attrs.get("doubts", ""))


def _payload(model: fb.Model) -> str:
    q = np.full((2, model.nq), 0.2)
    return str(fb.payload_map(model, q).to_xarray().attrs.get("doubts", ""))


def _simulated(model: fb.Model) -> str:
    free = [0.1] * model.nv, [0.0] * model.nv, [0.0, 0.01]
    return str(fb.simulate(model, *free, method="rk4", step=0.01).attrs.get("doubts", ""))


def _reached(model: fb.Model) -> str:
    points = np.full((2, model.dim), 0.2)
    return str(fb.workspace(model, points).to_xarray().attrs.get("doubts", ""))


def _source(model: fb.Model) -> str:
    return fb.source(model, "kinetic_energy", "c")


RESULTS: dict[str, tuple[Callable[[fb.Model], str], tuple[str, ...], bool, bool]] = {
    "study": (_study, ALL, True, False),
    "payload map": (_payload, (MASSES, EFFORTS), True, False),
    "time_optimal": (
        lambda m: _told(fb.time_optimal(m, _ends(m), points=21)),
        (*DYNAMIC, *(EFFORTS, SPEEDS, RANGES)),
        True,
        False,
    ),
    "plan": (
        lambda m: _told(fb.quintic(m, _ends(m), acceleration=3.0)), (SPEEDS, RANGES), False, False,
    ),
    "simulate": (_simulated, DYNAMIC, False, False),
    "sweep": (_swept, (MASSES,), False, False),
    "workspace": (_reached, (RANGES,), False, False),
    "source": (_source, (MASSES, LOADS, ROTORS), False, True),
    "repr": (repr, ALL, False, True),
}  # fmt: skip
"""What a result says, what it depends on, whether what is not given counts, and whether it names
the kind instead of the sentence."""


# ------------------------------------------------------------ the law
def test_the_models_of_these_tests_have_one_doubt_each_and_every_kind_has_one():
    assert set(HAVING) == set(DOUBT_KINDS)
    assert arm().doubts == ()
    for kind in HAVING:
        assert {doubt.kind for doubt in having(kind).doubts} == {kind}


@pytest.mark.sample(1)
@pytest.mark.parametrize("result", RESULTS)
def test_every_result_says_once_what_is_doubtful_of_what_it_depends_on(result: str):
    said, depends, judged, by_name = RESULTS[result]
    for kind, record in DOUBT_KINDS.items():
        model = having(kind)
        # an open question on efforts is none for what needs no drive
        text = " ".join(said(model).split())
        (doubt,) = model.doubts
        counts = set(record.touches) & set(depends) and (judged or not record.absent)
        words = kind if by_name else doubt.clause[1:]
        assert text.count(words) == bool(counts), f"{kind}: {text[:600]}"
        if counts and not by_name:
            assert ("Not judged: " in text) == record.bars, f"{kind}: {text}"
    clean = said(arm())
    assert "doubt" not in clean.lower()
    assert "ot judged" not in clean


def test_the_file_says_what_the_results_say(tmp_path: Path):
    """A study's files, page and manifest; an export's manifest."""
    model, study = having("placeholder limits"), studied("placeholder limits")
    (doubt,) = model.doubts
    study.save(tmp_path / "study", report=True)
    for name in ("manifest.json", "report.html"):
        text = (tmp_path / "study" / name).read_text(encoding="utf-8")
        assert doubt.clause in " ".join(re.sub(r"<[^>]*>", "", text).split()), name
    assert doubt.clause in study.summary.attrs["doubts"]
    assert doubt.clause in study.notices[0]
    light = having("point load")
    fb.export(light, "mass_matrix", tmp_path / "c", "c")
    assert light.doubts[0].clause[1:] in (tmp_path / "c" / "manifest.json").read_text()


@pytest.mark.sample(4)
@pytest.mark.parametrize("kind", DOUBT_KINDS)
def test_what_bars_the_verdict_and_the_exit_status_stand_in_the_table(kind: str):
    study, record = studied(kind), DOUBT_KINDS[kind]
    assert study.verdict.outcome == ("not judged" if record.bars else "feasible")
    assert study.finding == record.mend
    assert study.passed == (not record.bars)


@pytest.mark.parametrize("kind", ["no masses", "placeholder limits", "estimated limits"])
def test_a_position_limit_that_is_known_is_judged_whatever_else_is_doubtful(kind: str):
    model = having(kind)
    t = np.linspace(0.0, 9.0, 41)
    far = fb.Motion.of(model, t, np.outer(np.sin(np.pi * t / 9.0) ** 2, [2.5, 0.0, 0.0]))
    outcome = fb.study(model, far).verdict.outcome
    assert outcome == ("not judged" if kind == "estimated limits" else "not feasible")


@pytest.mark.usefixtures("numpy_kernels")
def test_formulas_name_all_that_they_depend_on():
    """Other masses, load, rotor, friction change only what says that it depends on them."""
    drives = [fb.Drive(viscous=0.1, rotor=1e-3, gear=50)] * 2
    row = {"a": 0.3, "m": 2.0, "com": [-0.1, 0, 0], "I": [0.01, 0, 0, 0.03, 0, 0.03]}
    bare = fb.dh([row | {"alpha": 0.4}, row], convention="standard")
    for joint, drive in zip(bare.joint_names, drives, strict=True):
        bare = bare.with_drive(joint, viscous=drive.viscous, rotor=drive.rotor, gear=drive.gear)
    moments = np.array([0.02, 0, 0, 0.03, 0, 0.04])
    base = bare.with_payload(Inertia.of(1.0, [0.1, 0, 0], list(moments)))
    masses = [
        p.name for p in fb.parameters(base) if p.name in ("link1.mass", "link2.mass", "m1", "m2")
    ]
    others = {
        MASSES: base.bind(dict.fromkeys(masses, 3.0)),
        LOADS: bare.with_payload(Inertia.of(1.0, [0.1, 0, 0], list(3.0 * moments))),
        ROTORS: base.with_drive(base.joint_names[0], rotor=5e-3),
        FRICTION: base.with_drive(base.joint_names[0], viscous=0.7),
    }
    assert len(masses) == 2
    tried = 0
    for name, formula in FORMULAS.items():
        if formula.chains in ("closed", "arm", "square"):
            continue
        rows = {"rows": ("vx", "vy")} if formula.free_rows else {}
        kernel, rng = fb.kernel(base, name, **rows), np.random.default_rng(1)
        given = [0.1 * np.abs(rng.normal(size=x.shape)) + 0.05 for x in kernel.program.inputs]
        values = kernel(*given)
        for aspect, other in others.items():
            found = fb.kernel(other, name, **rows)(*given)
            pairs = zip(
                *(x if isinstance(x, tuple) else (x,) for x in (values, found)), strict=True
            )
            alike = all(np.allclose(a, b, 1e-11, 1e-14, equal_nan=True) for a, b in pairs)
            assert alike or aspect in formula.touches, f"{name} depends on {aspect}"
        tried += 1
    assert tried > 40


# ------------------------------------------------------------ masses
def _dh_arm(*alphas: float) -> fb.Model:
    """Links along x of which only the inertia about their own z axis is given."""
    rows = [
        {"a": 0.3, "alpha": alpha, "m": 2.0, "com": [-0.15, 0, 0], "I": [0, 0, 0, 0, 0, 0.02]}
        for alpha in alphas
    ]
    return fb.dh(rows, convention="standard", physical="warn")


@pytest.mark.parametrize(
    ("alphas", "named"),
    [((0.0, 0.0, 0.0), ()), ((np.pi / 2, 0.0, 0.0), (1, 2, 3)), ((0.0, np.pi / 2, 0.0), (2, 3))],
)
def test_inertia_about_one_axis_is_enough_where_a_link_turns_about_no_other(alphas, named):
    """An arm of three axes with Ixx = Iyy = 0 was "Feasible", though its torques depend on them."""
    doubts = [x for x in _dh_arm(*alphas).doubts if x.kind == "impossible inertias"]
    links = {int(k) for doubt in doubts for k in re.findall(r"link'? ?(\d)", doubt.text)}
    assert links == set(named)
    assert len(doubts) == bool(named)


def _one_link(axes: list[str], inertia: list[float], mass: float = 1.0) -> fb.Model:
    """A chain along x whose last link has this inertia; joints "rz", "px"."""
    text = ['name = "r"', "dim = 3", '[[link]]\nname = "ground"']
    for k, axis in enumerate(axes):
        kind = {"r": "revolute", "p": "prismatic"}[axis[0]]
        last = k == len(axes) - 1
        given = inertia if last else [0.02, 0, 0, 0.03, 0, 0.03]
        text.append(
            f'[[link]]\nname = "l{k}"\nmass = {mass if last else 1.0}\ncom = [0.1, 0, 0]\n'
            f'inertia = {given}\n[[joint]]\nname = "j{k}"\nkind = "{kind}"\n'
            f'parent = "{f"l{k - 1}" if k else "ground"}"\nchild = "l{k}"\n'
            f'origin = [{0.2 * bool(k)}, 0, 0]\naxis = "{axis[1]}"'
        )
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "r.toml"
        file.write_text("\n".join(text))
        return fb.load(file)


ABOUT_Z = [0.0, 0.0, 0.0, 0.0, 0.0, 0.02]


@pytest.mark.parametrize(
    ("axes", "inertia", "kinds"),
    [
        (["rz", "rz"], ABOUT_Z, set()),
        (["px", "rz"], ABOUT_Z, set()),
        (["rz", "ry"], ABOUT_Z, {"impossible inertias"}),
        (["ry", "rz"], ABOUT_Z, {"impossible inertias"}),
        (["px", "py"], ABOUT_Z, set()),  # which never turns
        (["rz"], [9e-9, 0, 0, 1e-9, 0, 1e-9], {"impossible inertias"}),  # however small
        (["rz"], [-5e-9, 0, 0, 5e-9, 0, 5e-9], {"impossible inertias"}),
        (["rz"], [0, 0, 0, 0, 0, -1e-9], {"impossible inertias"}),
        (["ry", "rz"], [0.01, 0, 0, 0.012, 0, 0.0225], {"inexact inertias"}),
    ],
)
def test_what_is_felt_of_an_inertia_decides(axes, inertia, kinds):
    model = _one_link(axes, inertia, 1e-3 if max(map(abs, inertia)) < 1e-6 else 1.0)
    found = {doubt.kind for doubt in model.doubts if "inertias" in doubt.kind}
    assert found == kinds
    if not kinds:  # nor with a load
        loaded = model.with_payload(mass=0.5).doubts
        assert not [doubt for doubt in loaded if "inertias" in doubt.kind]


def test_a_part_that_no_body_is_stands_beside_where_the_whole_is_one():
    model = _one_link(["rz", "ry"], [0.2, 0, 0, 0.2, 0, 0.2], 5.0)
    for tensor in ([0.01, 0, 0, 0.01, 0, 0.05], [-0.05, 0, 0, -0.05, 0, -0.05]):
        load = Inertia(1.0, (0.0, 0.0, 0.0), tuple(map(float, tensor)))
        (part,) = model.bodies[-1].inertias
        body = replace(model.bodies[-1], inertias=(part, replace(part, link="tool", inertia=load)))
        both = replace(model, bodies=(*model.bodies[:-1], body))
        assert "inexact inertias" in {doubt.kind for doubt in both.doubts}


# ------------------------------------------------------------ limits
CHAIN = """<robot name="chain"><link name="base"/>{links}</robot>"""
LINK = """<link name="link{k}"><inertial><origin xyz="0 0 0.15"/><mass value="{mass}"/>
<inertia ixx="{i}" iyy="{i}" izz="{j}" ixy="0" ixz="0" iyz="0"/></inertial></link>
<joint name="j{k}" type="revolute"><parent link="{parent}"/><child link="link{k}"/>
<origin xyz="0 0 {z}"/><axis xyz="{axis}"/>
<limit lower="-2" upper="2" velocity="{velocity}" effort="{effort}"/></joint>"""


def chain(*limits: tuple[float, float]) -> str:
    """A file of an arm of so many joints, by effort and speed."""
    links = []
    for k, (effort, velocity) in enumerate(limits):
        mass = 4.0 - 0.45 * k
        numbers = {"mass": mass, "i": 0.0093 * mass, "j": 0.0031 * mass}
        where = {"z": 0.3 if k else 0.1, "axis": "0 1 0" if k % 2 else "0 0 1"}
        parent = f"link{k - 1}" if k else "base"
        links.append(
            LINK.format(k=k, parent=parent, effort=effort, velocity=velocity, **numbers, **where)
        )
    return CHAIN.format(links="".join(links))


PI = 3.14159


@pytest.mark.parametrize(
    ("limits", "placeholders"),
    [
        ([(300, 10)] * 7, 7),  # pybullet's iiwa
        ([(1000, 1000)] * 3, 3),  # Solo, Bolt
        ([(50000, 10000), (50, 1.5), (100, 1.5), (50, 1.5), (15, 4), (15, 4), (15, 4)], 1),
        # what makers say: Panda, UR5e, UR5 of ROS, iiwa, Baxter, Gen3, xArm, Sawyer, Jaco
        ([(87, 2.175)] * 4 + [(12, 2.61)] * 3, 0),
        ([(150, PI)] * 3 + [(28, PI)] * 3, 0),
        ([(150, 3.15)] * 3 + [(28, 3.2)] * 3, 0),
        ([(320, 1.48), (320, 1.48), (176, 1.75), (176, 1.31), (110, 2.27), (40, 2.36)], 0),
        ([(50, 1.5), (100, 1.5), (50, 1.5), (50, 1.5), (15, 4), (15, 4), (15, 4)], 0),
        ([(39, 1.3963)] * 4 + [(9, 1.2218)] * 3, 0),
        ([(50, 3.14), (50, 3.14), (30, 3.14), (30, 3.14), (30, 3.14), (20, 3.14)], 0),
        ([(80, 1.74), (80, 1.328), (40, 1.957), (40, 1.957), (9, 3.485), (9, 3.485)], 0),
        ([(40, 0.6283), (80, 0.6283), (40, 0.6283), (40, 0.6283), (20, 0.8378)], 0),
        ([(300, 10)] * 2, 0),  # two alike may be two modules
        # more than such motors weigh; the first stands on the ground
        ([(100, PI)] * 5 + [(28, PI)], 0),
        ([(400, PI)] * 4 + [(28, PI)], 3),
        ([(400, PI)] + [(35, PI)] * 5, 0),
    ],
)  # fmt: skip
def test_placeholders_are_told_from_what_makers_say(tmp_path: Path, limits, placeholders: int):
    file = tmp_path / "chain.urdf"
    file.write_text(chain(*limits))
    doubts = [x for x in fb.load(file).doubts if x.kind == "placeholder limits"]
    assert len({name for doubt in doubts for name in doubt.joints}) == placeholders


def test_a_robot_with_placeholder_limits_is_not_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """It was "feasible, 5.24 times as fast"."""
    monkeypatch.chdir(tmp_path)
    Path("iiwa.urdf").write_text(chain(*[(300, 10)] * 4))
    assert run(["study", "iiwa.urdf"]) == 1
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith(
        "Not judged: the limits of j0, j1, j2 and j3 are placeholders, 300 N m and 10 rad/s of "
        "each. Rotor inertia is not given; its torque is left out. chain: "
    )
    assert "times as fast" not in out
    assert "of its effort limit" not in out


def test_the_largest_share_is_of_the_drives_whose_limit_is_not_in_doubt(tmp_path: Path):
    """The sentence said "of any drive" beside a table with larger shares."""
    file = tmp_path / "chain.urdf"
    file.write_text(chain((50, 1.5), (50000, 1.5), (50, 1.5)))
    text = fb.study(fb.load(file)).worst.text
    assert "the largest share of the drives whose limit is not in doubt" in text
    assert "j1 needs" not in text


# ------------------------------------------------------------ masses and loads
def test_a_massless_robot_lifts_nothing_that_is_told():
    model = fb.dh([{"a": 0.4}, {"a": 0.3}, {"a": 0.2}], convention="standard")
    model = model.replace(gravity=[0.0, -9.81, 0.0])
    found = fb.payload_map(model, np.full((5, 3), 0.2), effort=50.0 * np.ones(3))
    assert repr(found) == "<Payload map: 5 postures at frame 'frame3'; not judged: no masses>"
    assert repr(model).endswith("; not judged: no masses>")


def test_doubts_follow_the_numbers_of_a_changed_copy():
    def kinds(model: fb.Model) -> set[str]:
        return {doubt.kind for doubt in model.doubts}

    massless = having("no masses")
    assert kinds(massless.bind(m1=2.0, I1=0.1)) == set()
    assert kinds(arm().bind({"joint2.limits.effort": 0.0})) == {"missing limits"}
    assert kinds(having("no rotor inertia").without("rotors")) == {"no rotor inertia"}
    rotors = having("no rotor inertia")
    for name in rotors.joint_names:
        rotors = rotors.with_drive(name, rotor=1e-4)
    assert kinds(rotors) == set()
    box = Inertia.box(0.7, (0.1, 0.2))
    assert kinds(arm().with_payload(box)) == set()
    twice = having("placeholder limits").bind(
        {"joint1.limits.effort": 170.0, "joint2.limits.effort": 70.0}
    )
    assert kinds(twice) == set()
    for masses in ([0.0, 0.5, 1.0], [0.0, 0.5, 0.0]):
        assert kinds(arm().with_payload(mass=np.array(masses))) == {"point load"}


def test_what_a_file_told_stands_until_its_numbers_are_others():
    model = having("estimated inertias")
    assert model.is_estimated
    pi = fb.inertial_parameters(model)
    assert not model.with_inertial_parameters({x: 1.1 * y for x, y in pi.items()}).is_estimated
    assert model.bind(m1=5.0).is_estimated  # the other links are as they were
    assert model.bind({"joint1.limits.effort": 3.0}).is_estimated
    limits = having("estimated limits")
    names = [f"{joint}.limits.effort" for joint in limits.joint_names]
    assert {x.kind for x in limits.bind({names[0]: 90.0}).doubts} == {"estimated limits"}
    assert limits.bind(dict(zip(names, (90.0, 40.0, 12.0), strict=True))).doubts == ()


@pytest.mark.parametrize("kind", ["no masses", "implausible inertias", "estimated inertias",
                                  "estimated limits"])  # fmt: skip
def test_saved_doubts_are_read_again(tmp_path: Path, kind: str):
    model = told_by_file(kind) if kind != "no masses" else having(kind)
    if kind == "no masses":
        model = settled(replace(model, notices=(Doubt(kind, "all of them."),)))
    fb.save(model, tmp_path / "arm.toml")
    again = fb.load(tmp_path / "arm.toml", physical="ignore")
    assert [(x.kind, x.text) for x in again.doubts] == [(x.kind, x.text) for x in model.doubts]


def test_a_point_load_says_which_joint_does_not_feel_it():
    def said(model: fb.Model) -> str:
        return next(doubt.text for doubt in model.doubts if doubt.kind == "point load")

    robot = fb.load("ur5e")
    assert said(robot.with_payload(mass=2.0)) == (
        "load 'payload' (2 kg) is a point without inertia; wrist_3_joint, on whose axis it is, "
        "does not feel it."
    )
    aside = robot.with_payload(mass=2.0, com=[0.05, 0, 0])
    assert said(aside) == "load 'payload' (2 kg) is a point without inertia."
    drive = aside.with_payload(mass=1.5, com=[0.1, 0.05, 0], frame="forearm_link", name="drive")
    assert said(drive) == (
        "loads 'drive' (1.5 kg) and 'payload' (2 kg) are points without inertia."
    )


# ------------------------------------------------------------ bundled robots, small words
def test_bundled_robots_carry_their_own_doubts():
    found = {name: [x.kind for x in fb.load(name).doubts] for name in fb.models()}
    assert found["scara"] == ["estimated inertias", "estimated limits", "no rotor inertia"]
    assert found["iiwa14"] == ["estimated inertias", "no rotor inertia"]
    assert found["ur5e"] == found["panda"] == ["no rotor inertia"]
    assert found["puma560"] == ["missing limits", "inexact inertias"]  # as they were measured
    for name, kinds in found.items():
        assert not any(DOUBT_KINDS[kind].mend for kind in kinds), name
        if fb.load(name).dim == 2:  # of a textbook's arm nobody asks for rotors
            assert "no rotor inertia" not in kinds


def test_by_estimates_a_motion_is_compared_but_not_judged(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    monkeypatch.chdir(tmp_path)
    assert run(["study", "scara"]) == 0
    out = " ".join(capsys.readouterr().out.split())
    assert out.startswith("Not judged: the masses and inertias are estimates, not the maker's. The")
    assert " Every limit is kept by the estimates; nearest: " in out


def test_nothing_is_said_of_a_torque_that_is_none():
    model = arm().replace(gravity=0.0)
    still = fb.Motion.of(model, np.linspace(0, 1, 11), np.zeros((11, 3)))
    assert fb.study(model, still).worst.text == (
        "No drive needs a torque or force during the motion."
    )
