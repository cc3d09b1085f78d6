"""What the public numeric functions refuse, and in which words."""

from __future__ import annotations

import re
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import freebody as fb
from freebody import (
    MissingValueError,
    Model,
    NotFiniteError,
    ShapeError,
    SingularError,
    UnknownNameError,
)
from support import generate


def arm() -> Model:
    return fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1], name="arm")


ARM = arm()
Z = np.zeros(2)
NAN, INF = float("nan"), float("inf")
SHAPE = "model 'arm' has nv = 2."


def says(text: str, call: Callable[[], Any], kind: type[Exception] = fb.FreebodyError) -> None:
    """The refusal is this text, at first and again once a kernel is known."""
    for _ in range(2):
        with pytest.raises(kind, match=f"^{re.escape(text)}$"):
            call()


@pytest.fixture(autouse=True, scope="module")
def kernels_are_known():
    """Refusals must not depend on whether a call went well before."""
    fb.inverse_dynamics(ARM, Z, Z, Z)
    fb.jacobian(ARM, Z)


# ---------------------------------------------------------------- shapes and types
FUNCTIONS: list[tuple[Callable, tuple[str, ...]]] = [
    (fb.inverse_dynamics, ("q", "qd", "qdd")),
    (fb.forward_dynamics, ("q", "qd", "tau")),
    (fb.mass_matrix, ("q",)),
    (fb.coriolis_matrix, ("q", "qd")),
    (fb.bias, ("q", "qd")),
    (fb.gravity_torque, ("q",)),
    (fb.static_torque, ("q",)),
    (fb.joint_wrenches, ("q", "qd", "qdd")),
    (fb.kinetic_energy, ("q", "qd")),
    (fb.potential_energy, ("q",)),
    (fb.momentum, ("q", "qd")),
    (fb.center_of_mass, ("q",)),
    (fb.forward_kinematics, ("q",)),
    (fb.velocity, ("q", "qd")),
    (fb.acceleration, ("q", "qd", "qdd")),
    (fb.jacobian, ("q",)),
    (fb.jacobian_dot, ("q", "qd")),
    (fb.integrate, ("q", "v")),
    (fb.difference, ("q0", "q1")),
]
ARGUMENTS = [(f, names, k) for f, names in FUNCTIONS for k in range(len(names))]
each_argument = pytest.mark.parametrize(
    ("function", "names", "k"),
    ARGUMENTS,
    ids=[f"{f.__name__}-{names[k]}" for f, names, k in ARGUMENTS],
)


def with_one(names: tuple[str, ...], k: int, value: Any) -> list[Any]:
    return [value if i == k else np.array([0.3, 0.7]) for i in range(len(names))]


@each_argument
@pytest.mark.parametrize("shape", [(3,), (1,), (), (2, 3), (0,)], ids=str)
def test_wrong_shape(function: Callable, names: tuple[str, ...], k: int, shape: tuple[int, ...]):
    size = "nq" if names[k].startswith("q") and names[k] not in ("qd", "qdd") else "nv"
    text = (
        f"{function.__name__}: {names[k]} has shape {shape}, expected (..., 2): "
        f"model 'arm' has {size} = 2."
    )
    says(text, lambda: function(ARM, *with_one(names, k, np.zeros(shape))), ShapeError)


@each_argument
def test_not_finite(function: Callable, names: tuple[str, ...], k: int):
    start = f"{function.__name__}: {names[k]} is"
    end = "every entry must be a finite number."
    says(
        f"{start} nan for 'joint2'; {end}",
        lambda: function(ARM, *with_one(names, k, [0, NAN])),
        NotFiniteError,
    )
    batch = np.zeros((4, 2))
    batch[2, 0] = INF
    says(
        f"{start} inf at sample 2 for 'joint1'; {end}",
        lambda: function(ARM, *with_one(names, k, batch)),
        NotFiniteError,
    )
    box = np.zeros((2, 3, 2))
    box[1, 2, 1] = -INF
    says(
        f"{start} -inf at sample (1, 2) for 'joint2'; {end}",
        lambda: function(ARM, *with_one(names, k, box)),
        NotFiniteError,
    )


@each_argument
@pytest.mark.parametrize(
    ("value", "what"),
    [
        (
            np.array([1j, 0]),
            "holds complex numbers, expected real numbers; .real has their real parts.",
        ),
        (np.array([None, 0.0]), "holds None at index 0, expected real numbers."),
        (None, "is None, expected real numbers."),
        ([0.5, "b"], "holds 'b' at index 1, expected real numbers."),
        (
            ["0.5", "1"],
            "holds text, expected real numbers; convert it with numpy.asarray(…, dtype=float).",
        ),
        ([[1.0, 2.0], [3.0]], "has rows of different lengths; make them equal."),
    ],
    ids=["complex", "object", "None", "text", "numbers in text", "ragged"],
)
def test_not_real_numbers(
    function: Callable, names: tuple[str, ...], k: int, value: Any, what: str
):
    says(
        f"{function.__name__}: {names[k]} {what}", lambda: function(ARM, *with_one(names, k, value))
    )


@pytest.mark.parametrize("kind", [int, bool, np.float32, list, tuple])
def test_other_numbers_are_taken(kind: type):
    given = kind([1, 0]) if kind in (list, tuple) else np.array([1, 0]).astype(kind)
    expected = fb.mass_matrix(ARM, np.array([1.0, 0.0]))
    assert fb.mass_matrix(ARM, given) == pytest.approx(expected)
    assert fb.mass_matrix(arm(), given) == pytest.approx(expected)  # on the first call as well


def test_batches_that_do_not_broadcast():
    says(
        "inverse_dynamics: the batch shapes do not broadcast together: q (3,), qd (4,), qdd ().",
        lambda: fb.inverse_dynamics(ARM, np.zeros((3, 2)), np.zeros((4, 2)), Z),
    )
    says(
        "static_torque: the batch shapes do not broadcast together: q (2,), wrenches['tip'] (3,).",
        lambda: fb.static_torque(ARM, np.zeros((2, 2)), np.zeros((3, 3))),
    )
    says(
        "integrate: the batch shapes do not broadcast together: q (2,), v (3,).",
        lambda: fb.integrate(ARM, np.zeros((2, 2)), np.zeros((3, 2))),
    )
    says(
        "tip_wrench: the batch shapes do not broadcast together: q (2,), tau (3,).",
        lambda: fb.tip_wrench(ARM, np.ones((2, 2)), np.zeros((3, 2))),
    )
    assert fb.inverse_dynamics(ARM, np.zeros((3, 1, 2)), np.zeros((4, 2)), Z).shape == (3, 4, 2)
    assert fb.inverse_dynamics(ARM, np.zeros((0, 2)), Z, Z).shape == (0, 2)


# ---------------------------------------------------------------- dicts
def test_dict_of_names():
    q = {"joint2": 0.7, "joint1": 0.3}
    assert fb.mass_matrix(ARM, q) == pytest.approx(fb.mass_matrix(ARM, [0.3, 0.7]))
    many = {"joint1": np.zeros((3, 1)), "joint2": np.ones(4)}
    assert fb.mass_matrix(ARM, many).shape == (3, 4, 2, 2)
    says(
        "inverse_dynamics: q lacks joint2; give every entry, 0 where it rests.",
        lambda: fb.inverse_dynamics(ARM, {"joint1": 0}, Z, Z),
    )
    says(
        "no entry 'jiont2' in inverse_dynamics: qd. Did you mean 'joint2'? Entries: joint1, "
        "joint2.",
        lambda: fb.inverse_dynamics(ARM, Z, {"joint1": 0, "jiont2": 0}, Z),
        UnknownNameError,
    )
    says(
        "inverse_dynamics: q is nan for 'joint2'; every entry must be a finite number.",
        lambda: fb.inverse_dynamics(ARM, {"joint1": 0, "joint2": NAN}, Z, Z),
    )
    says(
        "inverse_dynamics: q['joint2'] is 'x', expected real numbers.",
        lambda: fb.inverse_dynamics(ARM, {"joint1": 0, "joint2": "x"}, Z, Z),
    )
    says(
        "bias: the batch shapes do not broadcast together: q['joint1'] (3,), q['joint2'] (4,).",
        lambda: fb.bias(ARM, {"joint1": np.zeros(3), "joint2": np.zeros(4)}, Z),
    )


def test_dict_of_quaternion_entries():
    model = generate.model(4)
    assert model.position_names[:7] == tuple(
        f"base.{x}" for x in ("x", "y", "z", "quat_w", "quat_x", "quat_y", "quat_z")
    )
    assert model.velocity_names[:6] == tuple(
        f"base.{x}" for x in ("vx", "vy", "vz", "wx", "wy", "wz")
    )
    q = fb.random_state(model, 1)[0]
    given = dict(zip(model.position_names, q, strict=True))
    assert fb.mass_matrix(model, given) == pytest.approx(fb.mass_matrix(model, q))
    del given["base.quat_y"]
    says(
        "mass_matrix: q lacks base.quat_y; give every entry, 0 where it rests.",
        lambda: fb.mass_matrix(model, given),
    )


# ---------------------------------------------------------------- wrenches and points
def test_wrenches():
    says(
        "inverse_dynamics: wrenches['tip'] has shape (6,), expected (..., 3): force, then moment, "
        "world axes.",
        lambda: fb.inverse_dynamics(ARM, Z, Z, Z, np.zeros(6)),
        ShapeError,
    )
    says(
        "inverse_dynamics: wrenches['link1'] has shape (), expected (..., 3): force, then moment, "
        "world axes.",
        lambda: fb.inverse_dynamics(ARM, Z, Z, Z, {"link1": 1.0}),
        ShapeError,
    )
    says(
        "no frame 'tpi' in 'arm'. Did you mean 'tip'? Frames: base, link1, link2, tip.",
        lambda: fb.forward_dynamics(ARM, Z, Z, Z, {"tpi": np.zeros(3)}),
        UnknownNameError,
    )
    says(
        "joint_wrenches: wrenches['tip'] is nan at sample 1 for 'fy'; every entry must be a finite "
        "number.",
        lambda: fb.joint_wrenches(ARM, Z, Z, Z, {"tip": [[0, 0, 0], [0, NAN, 0]]}),
        NotFiniteError,
    )
    says(
        "static_torque: wrenches['tip'] is inf for 'm'; every entry must be a finite number.",
        lambda: fb.static_torque(ARM, Z, [0, 0, INF]),
        NotFiniteError,
    )
    says(
        "inverse_dynamics: wrenches holds frame 'tip' twice; add the two wrenches up.",
        lambda: fb.inverse_dynamics(ARM, Z, Z, Z, {"tip": [0, 1, 0], None: [0, 1, 0]}),
    )
    twin = ARM.to_space()
    says(
        "inverse_dynamics: wrenches['tip'] is nan for 'mx'; every entry must be a finite number.",
        lambda: fb.inverse_dynamics(twin, Z, Z, Z, [0, 0, 0, NAN, 0, 0]),
        NotFiniteError,
    )


def test_points():
    says(
        "velocity: point has shape (3,), expected (..., 2): model 'arm' has dim = 2.",
        lambda: fb.velocity(ARM, Z, Z, point=[1, 2, 3]),
        ShapeError,
    )
    says(
        "velocity: point is nan for 'y'; every entry must be a finite number.",
        lambda: fb.velocity(ARM, Z, Z, point=[1, NAN]),
        NotFiniteError,
    )
    says(
        "momentum: about has shape (3,), expected (..., 2): model 'arm' has dim = 2.",
        lambda: fb.momentum(ARM, Z, Z, about=[1, 2, 3]),
        ShapeError,
    )
    says(
        "momentum: about is nan for 'x'; every entry must be a finite number.",
        lambda: fb.momentum(ARM, Z, Z, about=[NAN, 0]),
        NotFiniteError,
    )


# ---------------------------------------------------------------- names
def test_unknown_frame_and_reference():
    frames = "Frames: base, link1, link2, tip."
    says(
        f"no frame 'link3' in 'arm'. Did you mean 'link2'? {frames}",
        lambda: fb.jacobian(ARM, Z, "link3"),
        UnknownNameError,
    )
    says(
        f"no frame 'elbow' in 'arm'. {frames}",
        lambda: fb.forward_kinematics(ARM, Z, "elbow"),
        UnknownNameError,
    )
    says(
        "no reference 'local' in reference=. References: world, body.",
        lambda: fb.jacobian(ARM, Z, reference="local"),
        UnknownNameError,
    )
    says(
        "no reference 'body' in reference=. References: world, child.",
        lambda: fb.joint_wrenches(ARM, Z, Z, Z, reference="body"),
        UnknownNameError,
    )


def test_errors_of_names_are_key_errors_that_read_well():
    with pytest.raises(KeyError) as refusal:
        fb.jacobian(ARM, Z, "tpi")
    assert str(refusal.value).startswith("no frame 'tpi'")


def test_no_tip_lists_the_candidates():
    links = tuple(fb_link(name) for name in ("base", "left", "right"))
    joints = tuple(
        fb.model.description.Joint(f"{side}_joint", "revolute", "base", side, axis=(0.0, 0.0, 1.0))
        for side in ("left", "right")
    )
    description = fb.model.description.RobotDescription(
        "twins", 3, links, joints, (9.81, (0.0, 0.0, -1.0))
    )
    model = fb.model.build.build_model(description)
    assert model.tip is None
    text = (
        "'twins' has no single tip. No tip is chosen: nothing moves but equal branches of one "
        "joint. Candidates: left and right. Name a frame, or choose the tip with tip= (--tip)."
    )
    for call in (
        lambda: fb.jacobian(model, Z),
        lambda: fb.forward_kinematics(model, Z),
        lambda: fb.inverse_dynamics(model, Z, Z, Z, np.zeros(6)),
        lambda: fb.tip_wrench(model, Z, Z),
        lambda: model.with_payload(1.0),
        lambda: fb.kernel(model, "jacobian"),
    ):
        says(text, call)
    assert fb.jacobian(model.replace(tip="right"), Z).shape == (6, 2)


def fb_link(name: str):
    return fb.model.description.Link(name, fb.Inertia.sphere(1.0, 0.1).moved_to((0.2, 0.0, 0.0)))


def test_kernel():
    with pytest.raises(
        UnknownNameError,
        match=r"^no quantity 'inverse' in fb\.kernel\. Did you mean 'inverse_velocity'\? "
        r"Quantities: ",
    ):
        fb.kernel(ARM, "inverse")
    says("fb.kernel: give at least one quantity.", lambda: fb.kernel(ARM, []))
    says(
        "no reference 'child' in reference=. References: world, body.",
        lambda: fb.kernel(ARM, "jacobian", reference="child"),
        UnknownNameError,
    )
    says(
        "no reference 'body' in reference=. References: world, child.",
        lambda: fb.kernel(ARM, "joint_wrenches", reference="body"),
        UnknownNameError,
    )
    assert fb.kernel(ARM, "joint_wrenches", reference="child")(Z, Z, Z).shape == (2, 3)


# ---------------------------------------------------------------- values
def test_symbols_without_values():
    model = fb.planar("RR", l=[1, None], name="letters")
    bind = (
        "Give them with model.bind(I1=..., I2=..., l2=...), or below [parameters] in a TOML file."
    )
    listed = "numbers need a value for I1, I2, l2, lc1, lc2, m1, m2."
    says(
        f"the numbers of 'letters': {listed} {bind}",
        lambda: fb.mass_matrix(model, Z),
        MissingValueError,
    )
    says(
        f"the numbers of 'letters': {listed} {bind}",
        lambda: fb.forward_dynamics(model, Z, Z, Z),
        MissingValueError,
    )
    masses = (
        "the mass of 'letters': numbers need a value for m1, m2. "
        "Give them with model.bind(m1=..., m2=...), or below [parameters] in a TOML file."
    )
    says(masses, lambda: fb.center_of_mass(model, Z), MissingValueError)
    assert model.bind(m1=1, m2=2).mass == 3.0
    bound = model.bind(l2=1, lc1=0.5, lc2=0.5, m1=1, m2=1, I1=0.1, I2=0.1)
    assert bound.missing == ()
    assert fb.mass_matrix(bound, [0.3, 0.7]) == pytest.approx(fb.mass_matrix(ARM, [0.3, 0.7]))


def test_quaternions_off_unit_length():
    model = generate.model(4)
    q = fb.random_state(model, 1)[0]
    remedy = "it must be 1 within 1e-6: divide it by its length."
    says(
        f"mass_matrix: the quaternion of joint 'base' has length 2; {remedy}",
        lambda: fb.mass_matrix(model, 2 * q),
    )
    says(
        f"mass_matrix: the quaternion of joint 'base' has length 0; {remedy}",
        lambda: fb.mass_matrix(model, 0 * q),
    )
    says(
        f"integrate: the quaternion of joint 'base' has length 2; {remedy}",
        lambda: fb.integrate(model, 2 * q, np.zeros(model.nv)),
    )
    near = q.copy()
    near[3:7] *= 1 + 5e-7
    assert fb.mass_matrix(model, near) == pytest.approx(
        fb.mass_matrix(model, q), rel=1e-12, abs=1e-12
    )
    says(
        "mass_matrix: q is nan for 'base.x'; every entry must be a finite number.",
        lambda: fb.mass_matrix(model, np.full(model.nq, NAN)),
    )


def test_the_quaternion_at_fault_is_quoted():
    model = generate.model(4)
    q = fb.random_state(model, 1, 3)[0]
    q[1, 3:7] *= 0.5
    remedy = "it must be 1 within 1e-6: divide it by its length."
    text = f"the quaternion of joint 'base' at sample 1 has length 0.5; {remedy}"
    says(f"bias: {text}", lambda: fb.bias(model, q, np.zeros(model.nv)))
    says(f"difference: {text}", lambda: fb.difference(model, q[0], q))


# ---------------------------------------------------------------- singular
def test_tip_wrench():
    q, force = [0.3, 0.7], np.array([3.0, -2.0, 0.0])
    tau = fb.jacobian(ARM, q).T @ force
    assert fb.tip_wrench(ARM, q, tau) == pytest.approx(force)
    assert fb.tip_wrench(ARM, q, {"joint1": tau[0], "joint2": tau[1]}) == pytest.approx(force)
    # it is what the arm exerts: the wrench on it is the opposite
    still = ARM.replace(gravity=0)
    assert fb.static_torque(still, q, -force) == pytest.approx(tau)
    why = (
        "some wrench at its frame needs no torque, so the torques do not determine it. Choose "
        "another q."
    )
    text = "tip_wrench: the Jacobian of 'arm' is singular"
    says(f"{text}: {why}", lambda: fb.tip_wrench(ARM, Z, Z), SingularError)
    says(
        f"{text} at sample 1: {why}",
        lambda: fb.tip_wrench(ARM, [[0.0, 1.0], [0.0, 0.0]], Z),
        SingularError,
    )
    says(
        "tip_wrench: tau has shape (3,), expected (..., 2): " + SHAPE,
        lambda: fb.tip_wrench(ARM, q, np.zeros(3)),
        ShapeError,
    )
    says(
        "tip_wrench: tau is nan for 'joint2'; every entry must be a finite number.",
        lambda: fb.tip_wrench(ARM, q, [0, NAN]),
        NotFiniteError,
    )
    four = fb.planar("RRRR", l=[1] * 4, lc=[0.5] * 4, m=[1] * 4, I=[0.1] * 4)
    says(
        "tip_wrench: 'RRRR' has 4 joints but the wrench 3 components; torques determine it only "
        "when these are equal.",
        lambda: fb.tip_wrench(four, np.ones(4), np.zeros(4)),
        SingularError,
    )
    three = fb.planar("RRR", l=[1] * 3, lc=[0.5] * 3, m=[1] * 3, I=[0.1] * 3)
    wrench = np.array([1.0, 2.0, 3.0])
    assert fb.tip_wrench(
        three, [0.1, 0.7, 0.9], fb.jacobian(three, [0.1, 0.7, 0.9]).T @ wrench
    ) == pytest.approx(wrench)


def test_joints_that_move_no_inertia():
    nothing = fb.planar(
        "RRR", l=[1, 1, 0], lc=[0.5, 0.5, 0], m=[1, 1, 0], I=[0.1, 0.1, 0], name="bare"
    )
    remedy = (
        "Give a mass and inertia to what it carries, or a rotor inertia to the joint, or fix it."
    )
    text = (
        "forward_dynamics: the mass matrix of 'bare' is singular: joint 'joint3' moves no inertia. "
        + remedy
    )
    says(
        text,
        lambda: fb.forward_dynamics(nothing, np.zeros(3), np.zeros(3), np.zeros(3)),
        SingularError,
    )
    all_of_it = fb.planar("RR", l=[1, 1], lc=[1, 1], m=[0, 0], I=[0, 0], name="ghost")
    text = (
        "forward_dynamics: the mass matrix of 'ghost' is singular: joints 'joint1' and 'joint2' "
        "move no inertia. " + remedy.replace("it carries", "each carries")
    )
    says(text, lambda: fb.forward_dynamics(all_of_it, Z, Z, Z), SingularError)
    rotor = fb.planar(
        "RR",
        l=[1, 1],
        lc=[1, 1],
        m=[0, 0],
        I=[0, 0],
        drives=[fb.Drive(rotor=2.0), fb.Drive(rotor=1.0, gear=3)],
    )
    assert fb.forward_dynamics(rotor, Z, Z, [1.0, 9.0]) == pytest.approx([0.5, 1.0])
    twice = fb.planar(
        "RR", l=[0, 1], lc=[0, 1], m=[0, 1], I=[0, 1], name="twice"
    )  # one axis, two joints
    text = (
        "forward_dynamics: the mass matrix of 'twice' is singular: joint 'joint1' moves no "
        "inertia. " + remedy
    )
    says(text, lambda: fb.forward_dynamics(twice, Z, Z, Z), SingularError)


def test_a_mass_matrix_singular_at_one_configuration():
    """Two links without mass and a particle at the tip: singular where the arm is stretched, and
    regular elsewhere."""
    model = fb.planar("RR", l=[1, 1], lc=[1, 1], m=[0, 1], I=[0, 0], g=0, name="particle")
    q = np.array([0.3, 1.0])
    qdd = fb.forward_dynamics(model, q, Z, [1.0, 2.0])
    assert fb.mass_matrix(model, q) @ qdd == pytest.approx([1.0, 2.0])
    says(
        "forward_dynamics: the mass matrix of 'particle' is singular: "
        "joint coordinate 'joint1' has no finite acceleration.",
        lambda: fb.forward_dynamics(model, Z, Z, [1.0, 2.0]),
        SingularError,
    )
    says(
        "forward_dynamics: the mass matrix of 'particle' is singular at sample 1: "
        "joint coordinate 'joint1' has no finite acceleration.",
        lambda: fb.forward_dynamics(model, np.array([q, Z]), Z, [1.0, 2.0]),
        SingularError,
    )


def test_no_mass_no_centre():
    model = fb.planar("R", l=[1], lc=[1], m=[0], I=[0], name="ghost")
    says(
        "center_of_mass: 'ghost' has no mass; give its links an inertia.",
        lambda: fb.center_of_mass(model, [0.0]),
        SingularError,
    )


# ---------------------------------------------------------------- kernels let NaN through
def test_kernels_spoil_only_the_sample_that_is_not_finite():
    model = generate.model(13)
    q, qd, qdd = fb.random_state(model, 3, 21)
    k = fb.kernel(model, ["inverse_dynamics", "mass_matrix", "joint_wrenches"])
    clean = k(q, qd, qdd)
    for spoilt in (q, qd, qdd):
        for value in (NAN, INF, -INF):
            keep = spoilt[5, -1]
            spoilt[5, -1] = value
            for a, b in zip(clean, k(q, qd, qdd), strict=True):
                assert np.isnan(b[5]).all()
                assert np.array_equal(np.delete(a, 5, 0), np.delete(b, 5, 0))
            spoilt[5, -1] = keep


def test_inputs_that_overflow_are_named():
    model = fb.load("2R")
    text = r"inverse_dynamics: qd reaches 1e\+200; the result overflows. Check its units."
    with pytest.raises(fb.FreebodyError, match=text):
        fb.inverse_dynamics(model, [0.1, 0.2], [1e200, 0.0], [0.0, 0.0])


def test_the_second_call_checks_what_the_first_did():
    """A known kernel is tried at once, with wrenches and quaternions too, and gives the same and
    refuses the same."""
    fixed = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[1, 1], I=[0.1, 0.1]).to_space()
    for arm in (fixed, fb.load("ur5e", base="free")):
        q, qd, qdd = fb.random_state(arm, 1)
        w, frame = np.arange(6.0), arm.leaves[0]
        for wrenches in (None, {frame: w}, {frame: w.tolist()}):
            first, second = (fb.inverse_dynamics(arm, q, qd, qdd, wrenches) for _ in range(2))
            assert np.array_equal(first, second)
            many = fb.inverse_dynamics(arm, np.stack([q, q]), qd, qdd, wrenches)
            assert np.array_equal(many, [first, first])
        with pytest.raises(fb.FreebodyError, match=r"wrenches\['.*'\] has shape \(5,\)"):
            fb.inverse_dynamics(arm, q, qd, qdd, {frame: w[:5]})
        with pytest.raises(fb.FreebodyError, match="nan"):
            fb.inverse_dynamics(arm, q, qd, qdd, {frame: w * np.nan})
        if arm.nq > arm.nv:
            for bad in (1.01 * q, np.stack([q, 1.01 * q])):
                with pytest.raises(
                    fb.FreebodyError, match=r"the quaternion of joint .* has length 1\.01"
                ):
                    fb.inverse_dynamics(arm, bad, qd, qdd)
