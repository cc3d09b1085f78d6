"""Helical, cylindrical and universal joints: against Pinocchio's own, against the same motions made
of revolute and prismatic joints, and their numbers by name. Random trees have them too
(`support.generate`)."""

from __future__ import annotations

import ast
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Limits, Parameter
from freebody.expressions.polynomials.symbols import symbols
from freebody.figures.snapshot import clear_pose
from freebody.inverse.problem.solutions import turning_coordinates
from freebody.model import description
from freebody.model.build import build_model
from freebody.model.joints import KINDS, JointKind
from freebody.model.joints.prismatic import SLIDING
from freebody.model.joints.revolute import TURNING
from freebody.model.loop_kinds import LOOP_KINDS
from freebody_textbook.equations.base_parameters import base_parameters
from support import generate, robots
from support.extras import extra
from support.helpers import close
from support.methods import agree
from support.robots import Joint, Link, Mimic, Robot, loaded, rpy, shift
from support.sources import parsed

pytestmark = pytest.mark.usefixtures("numpy_kernels")

PITCH = 0.03
AXIS = (0.0, 0.6, 0.8)


def described(*joints: Joint) -> Robot:
    """A chain of links with masses, or none where the name says so."""
    rng = np.random.default_rng(3)
    links = [Link("base")]
    for joint in joints:
        inertia = None if joint.child.startswith("no_mass") else generate.random_inertia(rng)
        links.append(Link(joint.child, inertia))
    gravity = (1.0, 2.0, -9.0)
    return Robot("chain", 3, tuple(links), joints, gravity)


def screw(name: str, parent: str, child: str, pitch: object = PITCH) -> Joint:
    at = shift(0.1, 0.0, 0.2).then(rpy(0.3, 0.2, 0.1))
    return Joint(name, "helical", parent, child, at, AXIS, numbers=(pitch,))


THREE = (
    screw("s", "base", "a"),
    Joint("u", "universal", "a", "b", shift(0.0, 0.2, 0.3).then(rpy(0.1, 0.4, 0.2))),
    Joint("c", "cylindrical", "b", "c", shift(0.0, 0.2, 0.3), (1.0, 2.0, 3.0)),
)


def dynamics(model: fb.Model, q: np.ndarray, qd: np.ndarray, qdd: np.ndarray) -> list[np.ndarray]:
    return [
        fb.mass_matrix(model, q),
        fb.inverse_dynamics(model, q, qd, qdd),
        fb.forward_dynamics(model, q, qd, qdd),
        fb.forward_kinematics(model, q),
        fb.jacobian(model, q),
        fb.kinetic_energy(model, q, qd),
    ]


def test_pinocchio_has_the_same_helical_and_universal_joint():
    pin = extra("pinocchio", "Pinocchio")
    model = loaded(described(*THREE))
    theirs = pin.Model()
    theirs.gravity.linear[:] = model.gravity
    axis = np.array([1.0, 2.0, 3.0]) / np.sqrt(14.0)
    kinds = [
        pin.JointModelHelicalUnaligned(np.array(AXIS), PITCH),
        pin.JointModelUniversal(np.array([1.0, 0.0, 0.0]), np.array([0.0, 1.0, 0.0])),
        pin.JointModelRevoluteUnaligned(axis),
        pin.JointModelPrismaticUnaligned(axis),
    ]
    last = 0
    for k, kind in enumerate(kinds):
        T = THREE[k].placement.matrix() if k < 3 else np.eye(4)
        last = theirs.addJoint(last, kind, pin.SE3(T), str(k))
        body = model.bodies[k] if k < 2 else model.bodies[2]
        if k != 2:
            m, c, tensor = body.inertias[0].inertia.numbers()
            theirs.appendBodyToJoint(last, pin.Inertia(m, c, tensor), pin.SE3.Identity())
    data = theirs.createData()
    for q, qd, qdd in zip(*fb.random_state(model, 0, 5), strict=True):
        tau = pin.rnea(theirs, data, q, qd, qdd)
        close(fb.inverse_dynamics(model, q, qd, qdd), tau, 1e-12)
        close(fb.mass_matrix(model, q), pin.crba(theirs, data, q), 1e-12)
        close(fb.forward_dynamics(model, q, qd, tau), qdd, 1e-10)
        pin.forwardKinematics(theirs, data, q)
        close(fb.forward_kinematics(model, q), np.array(data.oMi[last]), 1e-13)


def test_they_are_chains_of_revolute_and_prismatic_joints():
    """A screw is a turn, and a slide that follows it; the others are free to do both."""
    q, qd, qdd = fb.random_state(loaded(described(*THREE)), 1, 4)
    s, u, c = THREE
    parts = (
        replace(s, name="s", kind="revolute", child="no_mass_1", numbers=()),
        Joint("s2", "prismatic", "no_mass_1", "a", axis=AXIS, mimic=Mimic("s", PITCH)),
        replace(u, name="u1", kind="revolute", child="no_mass_2", axis=(1.0, 0.0, 0.0)),
        Joint("u2", "revolute", "no_mass_2", "b", axis=(0.0, 1.0, 0.0)),
        replace(c, name="c1", kind="revolute", child="no_mass_3"),
        Joint("c2", "prismatic", "no_mass_3", "c", axis=(1.0, 2.0, 3.0)),
    )
    whole = loaded(described(*THREE))
    masses = {body.name: body.inertias for body in whole.bodies}
    made = loaded(described(*parts))
    made = replace(
        made,
        bodies=tuple(replace(body, inertias=masses.get(body.name, ())) for body in made.bodies),
    )
    for ours, theirs in zip(dynamics(whole, q, qd, qdd), dynamics(made, q, qd, qdd), strict=True):
        close(ours, theirs, 1e-11)


def test_a_universal_loop_is_a_universal_joint():
    """A free body that such a loop holds moves as one on the joint, also beyond a quarter turn, and
    is held by the same wrench."""
    at = shift(0.1, 0.0, 0.2).then(rpy(0.3, 0.2, 0.1))
    jointed = loaded(described(Joint("u", "universal", "base", "a", at)))
    free = loaded(described(Joint("f", "free", "base", "a")))
    free = replace(
        free, bodies=tuple(replace(b, inertias=jointed.bodies[0].inertias) for b in free.bodies)
    )
    held = free.with_frame(
        "hook",
        rotation=at.matrix()[:3, :3],
        position=at.matrix()[:3, 3],
        frame="base",
    )
    held = held.with_loop("u", "universal", ("hook", "a"))
    assert fb.mobility(held, fb.assemble(held)).instantaneous == 2
    for q, qd in (
        ((0.4, -0.3), (0.7, -1.1)),
        ((2.5, 1.9), (-0.4, 0.8)),
        ((-1.7, -2.8), (1.0, 2.0)),
    ):
        qdd = fb.forward_dynamics(jointed, q, qd, [0.0, 0.0])
        T = fb.forward_kinematics(jointed, q, "a")
        v = np.linalg.solve(np.kron(np.eye(2), T[:3, :3]), fb.velocity(jointed, q, qd, "a"))
        pose = np.concatenate([T[:3, 3], fb.quat_wxyz(T[:3, :3])])
        found = fb.forward_dynamics(held, pose, v, np.zeros(6))
        moved = fb.jacobian(jointed, q, "a") @ qdd + fb.jacobian_dot(jointed, q, qd, "a") @ qd
        theirs = fb.jacobian(held, pose, "a") @ found + fb.jacobian_dot(held, pose, v, "a") @ v
        close(theirs, moved, 1e-9)
        wrench = fb.reactions(held, pose, v, tau=np.zeros(6))["u"]
        close(wrench, fb.joint_wrenches(jointed, q, qd, qdd)[0], 1e-9)


def test_a_cardan_shaft_obeys_hookes_law():
    """tan θ2 = cos β tan θ1 between shafts at an angle β that a universal joint links; its rate,
    and the torque that it passes on."""
    bend = 0.6
    turned = shift(0.0, 0.0, 0.0).then(rpy(bend, 0.0, 0.0))
    tree = loaded(
        described(
            Joint("driving", "continuous", "base", "a", axis=(0.0, 0.0, 1.0)),
            Joint("driven", "continuous", "base", "b", turned, (0.0, 0.0, 1.0)),
        )
    )
    shaft = tree.with_loop("cross", "universal", ("a", "b"))
    for angle in (0.3, 1.2, -0.7):
        q = fb.assemble(shaft, [angle, 0.0], free=["driven"])
        assert np.tan(q[1]) == pytest.approx(np.cos(bend) * np.tan(angle), rel=1e-12)
        qd = fb.loop_velocity(shaft, q, [1.0, 0.0])
        ratio = np.cos(bend) / (np.cos(angle) ** 2 + (np.cos(bend) * np.sin(angle)) ** 2)
        assert qd[1] / qd[0] == pytest.approx(ratio, rel=1e-12)
        brake = shaft.replace(gravity=0.0, actuated=["driving"]).with_drive("driven", stiffness=5.0)
        tau = fb.static_torque(brake, q)
        assert tau[0] == pytest.approx(ratio * 5.0 * q[1], rel=1e-9)


# ---------------------------------------------------------------- the pitch is a number
def test_a_pitch_is_a_number_like_others():
    model = loaded(described(screw("s", "base", "a")))
    found = fb.parameters(model)["s.pitch"]
    assert (found.value, found.unit) == (PITCH, "m/rad")
    q, qd, qdd = fb.random_state(model, 0)
    pitches = np.array([0.01, 0.05])
    family = model.bind({"s.pitch": pitches})
    alone = [model.bind({"s.pitch": float(x)}) for x in pitches]
    expected = [fb.inverse_dynamics(one, q, qd, qdd) for one in alone]
    close(fb.inverse_dynamics(family, q, qd, qdd), np.array(expected), 1e-15)
    assert alone[0].structure is model.structure is model.bind({"s.pitch": 0.0}).structure
    kernel = fb.kernel(model, "inverse_dynamics", inputs=["s.pitch"])
    close(kernel(q, qd, qdd, pitches[:, None]), np.array(expected), 1e-14)
    slope = fb.kernel(model, "inverse_dynamics", inputs=["s.pitch"], by="p")
    step = 1e-5
    ends = [
        fb.inverse_dynamics(model.bind({"s.pitch": PITCH + x}), q, qd, qdd) for x in (step, -step)
    ]
    close(slope(q, qd, qdd, [PITCH])[1][..., 0], (ends[0] - ends[1]) / (2.0 * step), 1e-8)


def test_a_pitch_in_files(tmp_path):
    text = """
name = "press"
[[link]]
name = "base"
[[link]]
name = "ram"
mass = 2.0
[[joint]]
name = "spindle"
kind = "helical"
parent = "base"
child = "ram"
axis = "z"
"""

    def read(more: str, kind: str = "helical") -> fb.Model:
        (tmp_path / "press.toml").write_text(text.replace("helical", kind) + more)
        return fb.load(tmp_path / "press.toml")

    model = read("pitch = { name = 'h', value = 0.002 }\nlimits = { upper = '20 deg' }\n")
    fb.save(model, tmp_path / "saved.toml")
    again = fb.load(tmp_path / "saved.toml")
    assert again.bodies[0].joint.numbers == model.bodies[0].joint.numbers
    close(fb.gravity_torque(again, [0.3]), [0.002 * 2.0 * 9.81], 1e-14)
    with pytest.raises(fb.FreebodyError, match=r"joint 'spindle': pitch is missing; add pitch ="):
        read("")
    with pytest.raises(fb.FreebodyError, match=r"toml:14: joint 'spindle': a prismatic joint has "
                       r"no pitch; remove it\."):  # fmt: skip
        read("pitch = 0.1\n", "prismatic")


@pytest.mark.parametrize(
    ("kind", "numbers", "text"),
    [
        ("helical", (), r"numbers has 0 entries; those of a helical joint are: pitch \(m/rad\)\."),
        ("universal", (1.0,), r"numbers has 1 entry; those of a universal joint are: none\."),
        ("helical", (float("nan"),), r"pitch: nan is not a finite number\."),
    ],
)
def test_numbers_that_do_not_fit_the_kind(kind: str, numbers: tuple[float, ...], text: str):
    """What no file can say."""
    joint = description.Joint(
        "j", kind, "base", "a", axis=AXIS if kind == "helical" else (), numbers=numbers
    )
    links = (description.Link("base"), description.Link("a"))
    robot = description.RobotDescription("chain", 3, links, (joint,), (9.81, (0.0, 0.0, -1.0)))
    with pytest.raises(fb.FreebodyError, match=rf"joint 'j': {text}"):
        build_model(robot)


def test_new_kinds_are_drawn_where_they_are_seen():
    """Each joint bent or drawn out, its symbol a solid on its axis or a cross; the rod of what has
    moved along an axis is there."""
    model = loaded(described(*THREE))
    figure = fb.kinematic_diagram(model, show="vectors")
    q = clear_pose(model)
    assert np.all(np.abs(q) > 0.1)
    shown = figure.drawing.elements
    solids = {k: [e for e in shown if e.name == f"joint {k}"] for k in (1, 2, 3)}
    assert [len(found) for found in solids.values()] == [2, 2, 2]
    assert len({e.axis for e in solids[1] + solids[3]}) == 2, "each along the axis of its joint"
    assert np.dot(*(e.axis for e in solids[2])) == pytest.approx(0.0, abs=1e-12), "a cross"
    rod = next(e for e in shown if e.name == "link 3")
    length = np.linalg.norm(np.subtract(*rod.points))
    assert length == pytest.approx(abs(q[list(model.position_names).index("c.d")]))
    assert fb.free_body_diagram(model, q).bodies[2].force_residual < 1e-9


# ---------------------------------------------------------------- every kind says what it is
@pytest.mark.parametrize("name", KINDS)
def test_a_kind_of_one_axis_names_its_primitive(name):
    """Its motion, words and units are the primitive's; `turns` and `slides` are alone what they
    say."""
    kind = KINDS[name]
    assert len(kind.angular) == kind.nv == len(kind.velocity_names)
    if kind.nv != 1:
        assert kind.motion is None
        return
    assert kind.motion is not None
    assert kind.motion.words.unit == ("rad" if kind.angular[0] else "m")
    assert kind.motion.turns or kind.motion.slides
    assert kind.turns + kind.slides == (kind.motion.turns != kind.motion.slides)


def test_the_table_that_mechanisms_are_made_from_is_the_package_s_own():
    assert list(robots.KINDS) == list(KINDS)
    for name, kind in KINDS.items():
        numbers = tuple(number.name for number in kind.numbers)
        own = robots.Kind(kind.dimensions, kind.nv, kind.needs_axis, kind.ranged, numbers)
        assert robots.KINDS[name] == own


def alone(kind: str, seed: int = 0) -> fb.Model:
    """A body on a joint of that kind, on a body that turns."""
    rng = np.random.default_rng(seed)
    own = KINDS[kind]
    axis = tuple(rng.normal(size=3)) if own.needs_axis else ()
    at = generate.random_placement(rng, general=True)
    last = Joint("j", kind, "a", "b", at, axis, numbers=(0.1,) * len(own.numbers))
    return loaded(described(Joint("r", "revolute", "base", "a", axis=(0.0, 1.0, 0.0)), last))


@pytest.mark.parametrize("kind", generate.SPATIAL)
def test_base_parameters_of_every_kind(kind: str):
    """As many as the regressor has independent columns, and they give the torques: also of joints
    that are several primitives with nothing between."""
    model = alone(kind)
    states = fb.random_state(model, 0, 60)
    Y = fb.regressor(model, *states)
    base = fb.base_parameters(model)
    assert len(base) == np.linalg.matrix_rank(Y.reshape(-1, Y.shape[-1]), rtol=1e-9)
    found = Y[..., list(base.columns)] @ base.values
    close(found, fb.inverse_dynamics(model, *states), 1e-9)


@pytest.mark.parametrize(
    "kind", [kind for kind in generate.SPATIAL if KINDS[kind].quaternion is None]
)
def test_equations_of_every_kind(kind: str):
    """In symbols, also by base parameters."""
    model = alone(kind)
    q, qd, qdd = fb.random_state(model, 0, 2)
    found = fb.equations(model, numbers=True)
    close(found.evaluate(found.tau, q, qd, qdd), fb.inverse_dynamics(model, q, qd, qdd), 1e-9)
    s = symbols(model)
    base = base_parameters(s)
    values = s.evaluate([b.value for b in base], q, qd, qdd)
    columns = fb.regressor(s.model, q, qd, qdd)[..., [b.column for b in base]]
    torques = (columns * values[:, None, :]).sum(-1)
    close(torques, fb.inverse_dynamics(model, q, qd, qdd), 1e-9)


@pytest.mark.sample(1)
@pytest.mark.parametrize("kind", [kind for kind in generate.SPATIAL if KINDS[kind].composed])
def test_derivations_of_joints_of_several_coordinates(kind: str):
    """A joint of several coordinates is derived as joints of one: by every method the same
    equations, which are the model's."""
    model = alone(kind)
    single = symbols(model).model
    assert [body.kind.nv for body in single.bodies] == [1] * model.nv
    q, qd, qdd = fb.random_state(model, 0, 2)
    torques = fb.inverse_dynamics(model, q, qd, qdd)
    close(fb.inverse_dynamics(single, q, qd, qdd), torques, 1e-12)
    derived = [fb.derive(model, method) for method in ("newton-euler", "recursive", "lagrange")]
    for one in derived:
        assert agree(derived[0], one)
        assert f"The {kind} joint j is replaced by joints 2" in one.given
        assert "m₂" not in str(one)
    found = fb.equations(model, numbers=True)
    close(found.evaluate(found.tau, q, qd, qdd), torques, 1e-9)


def test_a_derivation_takes_a_joint_apart_under_names_of_its_own():
    """The names of the parts are free ones, whatever the file's are called."""
    at = (0.0, 0.0, 1.0)
    joints = (
        Joint("c", "cylindrical", "base", "a", axis=at),
        Joint("c.theta", "revolute", "a", "a.theta", shift(0.3, 0.0, 0.0), at),
        Joint("x", "planar", "a.theta", "b"),
    )
    single = symbols(loaded(described(*joints))).model
    assert single.joint_names == ("c.theta′", "c.d", "c.theta", "x′", "y", "x.theta")
    assert single.frame_names[:4] == ("base", "a", "a.theta", "b")
    assert len(set(single.frame_names)) == 7


def test_which_coordinates_repeat_after_a_whole_turn():
    """Not those of a screw, nor of a turn that a slide or a screw follows."""
    model = loaded(described(*THREE))
    assert turning_coordinates(model).tolist() == [False, True, True, True, False]
    led = (
        Joint("r", "revolute", "base", "a", axis=(0.0, 0.0, 1.0)),
        Joint("t", "revolute", "a", "b", axis=(1.0, 0.0, 0.0), mimic=Mimic("r", 2.0)),
    )
    assert turning_coordinates(loaded(described(*led))).tolist() == [True]
    for kind in ("prismatic", "helical"):
        numbers = (0.1,) * len(KINDS[kind].numbers)
        follower = replace(led[1], kind=kind, numbers=numbers)
        assert turning_coordinates(loaded(described(led[0], follower))).tolist() == [False]


def test_turns_of_a_screw_beyond_the_starts_are_not_called_out_of_reach():
    made = loaded(described(screw("s", "base", "a")))
    target = fb.forward_kinematics(made, [20.0])
    none = fb.inverse_kinematics(made, target)
    assert not len(none.q)
    assert "Out of reach" not in str(none)
    assert "Starts lie within ±π of s" in str(none)
    close(fb.inverse_kinematics(made, target, q0=[19.0]).q, [[20.0]], 1e-9)
    limited = loaded(described(replace(screw("s", "base", "a"), limits=Limits(-30.0, 30.0))))
    close(fb.inverse_kinematics(limited, target).q, [[20.0]], 1e-9)
    far = fb.inverse_kinematics(limited, fb.forward_kinematics(limited, [300.0]))
    assert "Starts lie" not in str(far)


COMMON = {"fixed", "free", "planar", "point", "distance"}
"""Names of kinds that are words with other meanings too."""
OTHERWISE = {
    "formats/urdf.py": "what the format calls them",
    "formats/urdf_motors.py": "what the format calls them",
    "formats/sdf.py": "what the format calls them",
    "formats/sdf_gears.py": "what the format calls them",
    "formats/mjcf/reader.py": "what the format calls them",
    "formats/mjcf/equalities.py": "what two equalities of the format are",
    "formats/writing/dh_csv.py": "the kinds that the format has",
    "formats/writing/mjcf.py": "the kinds that the format has",
    "formats/writing/sdf.py": "the kinds that the format has",
    "diagnosis/facts.py": "what URDF calls them",
    "diagnosis/findings/limits.py": "what URDF calls them",
    "diagnosis/bodies_in_space.py": "the axis that joints of the plane have in space",
    "diagnosis/differences.py": "the axis that loops of the plane have in space",
    "model/cut_fixed_joints.py": "the joint that stands for a fixed one",
    "ways_out/fmus.py": "how a variable of FMI varies",
}
SOURCE = Path(fb.__file__).parent


def test_no_file_but_its_own_knows_a_kind_of_joint_or_loop():
    """Neither by its name nor by its class: all else asks the record."""
    names = {*KINDS, *LOOP_KINDS} - COMMON
    for path in SOURCE.rglob("*.py"):
        where = path.relative_to(SOURCE).as_posix()
        if where.startswith("model/joints/") or where == "model/loop_kinds.py":
            continue
        for node in ast.walk(parsed(path)):
            if isinstance(node, ast.Constant) and where not in OTHERWISE:
                assert node.value not in names, (where, node.lineno)
            if isinstance(node, ast.ImportFrom) and node.module is not None:
                own = node.module.removeprefix("freebody.model.joints.")
                assert own in (node.module, "kind"), (where, node.lineno)


# ---------------------------------------------------------------- symbols
HELIX = {"h": 0.02, "l": 0.3, "m": 2.0, "lc": 0.2, "I": 0.05}


def helix(*, with_slide: bool = False) -> fb.Model:
    """A screw that carries an arm, with names for its numbers."""
    m, lc, I = (Parameter(x, HELIX[x]) for x in ("m", "lc", "I"))
    inertia = Inertia(m, (lc, 0.0, 0.0), (0.0, 0.0, 0.0, I, 0.0, I))
    joints = [
        Joint(
            "screw",
            "helical",
            "base",
            "nut",
            axis=(0.0, 0.0, 1.0),
            numbers=(Parameter("h", HELIX["h"]),),
        ),
        Joint(
            "elbow",
            "revolute",
            "nut",
            "arm",
            shift(Parameter("l", HELIX["l"]), 0.0, 0.0),
            (0.0, 1.0, 0.0),
        ),
    ]
    links = [Link("base"), Link("nut", inertia), Link("arm", inertia)]
    if with_slide:
        joints.append(Joint("slide", "prismatic", "arm", "rod", axis=(1.0, 0.0, 0.0)))
        links.append(Link("rod", Inertia.point(1.0, (0.0, 0.0, 0.0))))
    gravity = (0.0, 0.0, -9.81)
    return loaded(Robot("helix", 3, tuple(links), tuple(joints), gravity))


@pytest.mark.sample(2)
@pytest.mark.parametrize("with_slide", [False, True])
@pytest.mark.parametrize("method", ["newton-euler", "recursive", "lagrange", "kane"])
def test_a_screw_in_derivations(method: str, with_slide: bool):
    """The torques are those of the kernel, and what is said of a screw is so: its motor's torque is
    the moment about the axis, and pitch times the force along it."""
    model = helix(with_slide=with_slide)
    found = fb.derive(model, method)
    q, qd, qdd = fb.random_state(model, 0, 3)
    close(
        found.equations.evaluate(found.equations.tau, q, qd, qdd),
        fb.inverse_dynamics(model, q, qd, qdd),
        1e-12,
    )
    said = " ".join(found.text().split())
    assert "joint 1 (helical, angle θ₁)" in said
    assert "h pitch (advance for each radian) of joint 1 [m/rad]" in said
    assert ("guide" in said or "slide, u₃" in said) <= with_slide
    if method == "newton-euler":
        assert "τ₁ = z₁ · n₀₁ + h (z₁ · f₀₁)" in said
        assert "the nut of joint 1" in said
        assert "helical or revolute joint adds its rate" in said
        assert ("a prismatic joint adds nothing" in said) == with_slide
    if method == "recursive":
        assert "v₁ = h θ̇₁ z₁ = [0, 0, h θ̇₁]ᵀ" in said
        assert "τ₁ = n₀₁ · z₁ + h (f₀₁ · z₁)" in said
        assert "the turning and the sliding of joint 1" in said


def test_a_joint_kind_of_tomorrow_says_itself_whether_it_has_an_axis(tmp_path, monkeypatch):
    """A joint of two motions: a file and a line, and its files are written and read."""

    class Sleeve(JointKind):
        name, nq, nv, needs_axis = "sleeve", 2, 2, True
        position_names = velocity_names = ("turn", "slide")
        angular = (True, False)

        def primitives(self, space, axis, numbers):
            return ((TURNING, axis), (SLIDING, axis))

    monkeypatch.setitem(KINDS, "sleeve", Sleeve())
    text = (
        '[[link]]\nname = "base"\n[[link]]\nname = "arm"\n[[joint]]\nname = "a"\nkind = "sleeve"\n'
        'parent = "base"\nchild = "arm"\naxis = [0, 0.6, 0.8]\n'
    )
    model = fb.load(text=text, format="toml")
    fb.save(model, tmp_path / "saved.toml")
    for arm in (model, fb.load(tmp_path / "saved.toml")):
        velocity = fb.velocity(arm, [0.3, 0.2], [1.0, 2.0], frame="arm")
        np.testing.assert_allclose(velocity, [0.0, 1.2, 1.6, 0.0, 0.6, 0.8], atol=1e-15)
    with pytest.raises(fb.FreebodyError, match="a sleeve joint has no friction; remove it"):
        fb.load(text=text + "friction = { viscous = 1.0 }\n", format="toml")
