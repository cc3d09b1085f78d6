"""Joints that follow others by polynomials: beside the free joints at what they follow, the balance
of energy, MuJoCo, files, limits, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial import Polynomial

import freebody as fb
from support import generate
from support.extras import extra
from support.helpers import FIRST, STEPS, close, numbers
from support.robots import Joint, Link, Loop, Mimic, Mount, Robot, loaded, shift

POWERS = {"wrist": (0.3, -0.2), "grip": (0.5, -2.0)}


def arm(powers: dict[str, tuple[float, ...]] = POWERS, **grip) -> Robot:
    """Two joints, a wrist that follows the shoulder and a finger that slides as the wrist turns."""
    inertia = fb.Inertia(2.0, (0.05, 0.02, 0.3), (0.03, 0.002, -0.003, 0.04, 0.004, 0.05))
    names = ("base", "upper", "fore", "hand", "finger")
    joints = (
        Joint("shoulder", "revolute", "base", "upper", axis=(0.0, 1.0, 0.0)),
        Joint("elbow", "revolute", "upper", "fore", shift(0.1, 0.0, 0.8), (0.0, 1.0, 0.0)),
        Joint(
            *("wrist", "revolute", "fore", "hand", shift(0.0, 0.0, 0.7), (1.0, 0.0, 0.0)),
            mimic=Mimic("shoulder", -0.7, 0.3, powers.get("wrist", ())),
        ),
        Joint(
            *("grip", "prismatic", "hand", "finger", shift(0.0, 0.1, 0.2), (0.0, 0.0, 1.0)),
            mimic=Mimic("wrist", 0.2, 0.0, powers.get("grip", ())),
            **grip,
        ),
    )
    links = tuple(Link(name, inertia) for name in names)
    return Robot("palletiser", 3, links, joints, (1.0, 0.5, -9.7), tip="finger")


def bent_tree(seed: int) -> Robot:
    """A generated tree whose joints follow by polynomials, where any follows."""
    tree = generate.tree(seed)
    joints = [
        replace(joint, mimic=joint.mimic and replace(joint.mimic, powers=(0.3, -0.15)))
        for joint in tree.joints
    ]
    return replace(tree, joints=tuple(joints))


class Embedded:
    """A robot beside its twin whose joints are all free, at states of the coordinates.

    The followers' positions, rates and accelerations come from the description, by the chain
    rule: q_f = p(q_l), q̇_f = p' q̇_l, q̈_f = p' q̈_l + p" q̇_l². G: q̇ of the twin = G q̇.
    """

    def __init__(self, robot: Robot, base: str = "fixed", seed: int = 0):
        self.model = loaded(robot, base=base)
        self.free = loaded(robot, base=base, mimic="free")
        self.state = fb.random_state(self.model, seed, batch=4)
        q, qd, _ = self.state
        of = {joint.name: joint.mimic for joint in robot.joints}
        at = {name: q[:, k] for k, name in enumerate(self.model.position_names)}
        known = {name: k for k, name in enumerate(self.model.velocity_names)}

        def followed(name):
            """(position, row of G, row of its rate, all (samples, …)) of a coordinate."""
            unit, none = np.zeros((len(q), self.model.nv)), np.zeros((len(q), self.model.nv))
            if of.get(name) is None:
                unit[:, known[name]] = 1.0
                return at.get(name), unit, none
            x, row, rate = followed(of[name].joint)
            p = Polynomial((of[name].offset, of[name].ratio, *of[name].powers))
            speed = np.einsum("nk,nk->n", row, qd)
            first, second = p.deriv()(x), p.deriv(2)(x)
            bent = (second * speed)[:, None] * row
            return p(x), first[:, None] * row, first[:, None] * rate + bent

        self.positions = np.stack(
            [at[x] if x in at else followed(x)[0] for x in self.free.position_names], axis=-1
        )
        rows = [followed(name)[1:] for name in self.free.velocity_names]
        self.G, self.G_rate = (np.stack(x, axis=1) for x in zip(*rows, strict=True))
        self.G_back = np.swapaxes(self.G, -1, -2)

    @property
    def free_state(self):
        _, qd, qdd = self.state
        drift = times(self.G_rate, qd)
        return self.positions, times(self.G, qd), times(self.G, qdd) + drift


def times(A, x):
    return np.einsum("nij,nj->ni", A, x)


BENT = [
    seed
    for seed in range(60)
    if sum(joint.mimic is not None for joint in generate.tree(seed).joints) > 1
][:6]


@pytest.mark.parametrize("seed", BENT)
def test_beside_the_free_tree(seed):
    robot = bent_tree(seed)
    beside = Embedded(robot, generate.base(seed), seed)
    model, free, frame = beside.model, beside.free, robot.links[-1].name
    assert any(body.joint.mimic is not None for body in model.bodies)
    q, qd, qdd = beside.state
    theirs = beside.free_state
    M = numbers(free, "mass_matrix", theirs[0])
    C = numbers(free, "coriolis_matrix", *theirs[:2])
    tau = times(beside.G_back, numbers(free, "inverse_dynamics", *theirs))
    close(numbers(model, "inverse_dynamics", q, qd, qdd), tau, 1e-12)
    close(numbers(model, "mass_matrix", q), beside.G_back @ M @ beside.G, 1e-12)
    coriolis = beside.G_back @ (C @ beside.G + M @ beside.G_rate)
    close(numbers(model, "coriolis_matrix", q, qd), coriolis, 1e-12)
    gravity = times(beside.G_back, numbers(free, "gravity_torque", theirs[0]))
    close(numbers(model, "gravity_torque", q), gravity, 1e-12)
    for energy, given, others in (
        ("kinetic_energy", (q, qd), theirs[:2]),
        ("potential_energy", (q,), theirs[:1]),
    ):
        close(numbers(model, energy, *given), numbers(free, energy, *others), 1e-13)
    for reference in ("world", "body"):
        how = {"frame": frame, "reference": reference}
        J = numbers(free, "jacobian", theirs[0], **how)
        close(numbers(model, "jacobian", q, **how), J @ beside.G, 1e-13)
        rate = numbers(free, "jacobian_dot", *theirs[:2], **how) @ beside.G + J @ beside.G_rate
        close(numbers(model, "jacobian_dot", q, qd, **how), rate, 1e-12, 1.0)
    momentum = numbers(free, "centroidal_momentum_matrix", theirs[0]) @ beside.G
    close(numbers(model, "centroidal_momentum_matrix", q), momentum, 1e-12)


@pytest.fixture(scope="module")
def rubbing() -> fb.Model:
    return loaded(
        arm(drive=fb.Drive(viscous=0.4, coulomb=0.3, rotor=0.01, gear=3.0, stiffness=20, rest=0.1))
    )


def test_derivatives_beside_differences(rubbing):
    q, qd, qdd = fb.random_state(rubbing, 1)
    tau = fb.inverse_dynamics(rubbing, q, qd, qdd)
    close(fb.forward_dynamics(rubbing, q, qd, tau), qdd, 1e-11)
    h = 1e-2
    steps = h * STEPS[:, None]
    inverse = fb.inverse_dynamics_derivatives(rubbing, q, qd, qdd)
    forward = fb.forward_dynamics_derivatives(rubbing, q, qd, tau)
    second, *_ = numbers(rubbing, "inverse_dynamics_second_derivatives", q, qd, qdd)
    for k, unit in enumerate(np.eye(2)):
        way = steps * unit
        for function, given, found in (
            (fb.inverse_dynamics, (q, qd, qdd), inverse),
            (fb.forward_dynamics, (q, qd, tau), forward),
        ):
            for j in range(3):
                moved = [x + way * (i == j) for i, x in enumerate(given)]
                difference = FIRST @ function(rubbing, *np.broadcast_arrays(*moved)) / h
                close(found[j][:, k], difference, 1e-8, 1.0)
        along = fb.inverse_dynamics_derivatives(rubbing, q + way, qd, qdd)[0]
        close(second[..., k], np.einsum("s,sij->ij", FIRST, along) / h, 1e-8, 1.0)


def test_parameters_and_families(rubbing):
    model = rubbing.without("friction")
    q, qd, qdd = fb.random_state(model, 2)
    tau = fb.inverse_dynamics(model, q, qd, qdd)
    parameters = np.array(list(fb.inertial_parameters(model).values()))
    close(fb.regressor(model, q, qd, qdd) @ parameters, tau, 1e-12)
    family = model.with_drive("grip", stiffness=[20.0, 60.0])
    each = fb.inverse_dynamics(family, q, qd, qdd)
    close(each[0], tau, 1e-13)
    close(each[1], fb.inverse_dynamics(family[1], q, qd, qdd), 1e-13)


@pytest.mark.parametrize(
    ("method", "step", "off"),
    [
        ("implicit", 1e-3, 1e-4),
        pytest.param("auto", None, 1e-9, marks=pytest.mark.long),
        pytest.param("rk4", 1e-3, 1e-9, marks=pytest.mark.long),
    ],
)
def test_energy_stays(rubbing, method, step, off):
    model = rubbing.without("friction")
    found = fb.simulate(
        model, [0.3, -0.5], [0.2, 0.1], np.linspace(0.0, 0.5, 26), method=method, step=step
    )
    energy = (found.kinetic_energy + found.potential_energy).values
    assert np.ptp(energy) < off * np.ptp(found.kinetic_energy.values)


@pytest.mark.long
def test_a_study_with_friction_and_rotors(rubbing, tmp_path):
    """Each part of the torque by a formula of its own, and the work of the follower's friction."""
    t = np.linspace(0.0, 1.0, 101)
    q = np.stack([0.5 * np.sin(t) ** 2, -0.4 * np.sin(t) ** 2], axis=-1)
    study = fb.study(rubbing, fb.Motion.of(rubbing, t, q))
    failed = [check.name for check in study.checks if not check.passed]
    assert not failed
    assert float(abs(study.data["tau_rotors"]).max()) > 1e-3
    page = tmp_path / "study.html"
    study.to_html(page)
    assert "wrist follows shoulder: position = " in page.read_text(encoding="utf-8")


def test_a_polynomial_of_degree_one_is_a_ratio():
    assert loaded(arm({"wrist": (0.0, 0.0), "grip": (0.0,)})) == loaded(arm({}))


def test_a_polynomial_of_a_polynomial():
    model = loaded(arm())
    grip = model.bodies[3].joint.mimic
    x = np.linspace(-2.0, 2.0, 9)
    wrist = Polynomial((0.3, -0.7, *POWERS["wrist"]))
    found = Polynomial((grip.offset, grip.ratio, *grip.powers))
    assert grip.joint == "shoulder"
    close(found(x), Polynomial((0.0, 0.2, *POWERS["grip"]))(wrist(x)), 1e-12)


def test_inverse_kinematics():
    model = loaded(arm())
    target = fb.forward_kinematics(model, [0.4, -0.7])
    close(fb.inverse_kinematics(model, target).q[0], [0.4, -0.7], 1e-9)


# ---------------------------------------------------------------- limits
def limited(lower: float, upper: float) -> fb.Model:
    """The arm whose wrist has limits."""
    robot = arm()
    joints = [
        replace(joint, limits=fb.Limits(lower, upper)) if joint.name == "wrist" else joint
        for joint in robot.joints
    ]
    return loaded(replace(robot, joints=tuple(joints)))


WRIST = Polynomial((0.3, -0.7, *POWERS["wrist"]))


def test_limits_of_followers_bound_their_leaders():
    """Of the ranges in which the follower is within its limits that one around 0."""
    inside, outside = [0.2, -0.7], [0.9, -0.7]
    model = limited(float(WRIST(0.25)), float(WRIST(-0.1)))
    assert WRIST(-0.1) > WRIST(0.2) > WRIST(0.25) > WRIST(0.9)
    close(fb.inverse_kinematics(model, fb.forward_kinematics(model, inside)).q[0], inside, 1e-9)
    found = fb.inverse_kinematics(model, fb.forward_kinematics(model, outside))
    close(found.q[0], outside, 1e-9)
    assert not found.within_limits.any()


@pytest.mark.long
def test_limits_of_followers_are_stops():
    model = limited(0.25, 0.31)
    t = np.linspace(0.0, 0.3, 61)
    for push, end in ((30.0, 0.25), (-30.0, 0.31)):
        found = fb.simulate(
            model, [0.0, 0.0], [0.0, 0.0], t, [push, 0.0], restitution=0.0, method="rk4", step=1e-3
        )
        wrist = WRIST(found.q.values[:, 0])
        assert wrist.min() > 0.25 - 1e-9
        assert wrist.max() < 0.31 + 1e-9
        close(wrist[-1], end, 1e-9)


# ---------------------------------------------------------------- closed chains
def test_in_a_closed_chain_energy_stays():
    inertia = fb.Inertia(1.0, (0.5, 0.1), (0.1,))
    links = tuple(Link(name, inertia) for name in ("ground", "a", "b", "c", "d"))
    joints = (
        Joint("j1", "revolute", "ground", "a"),
        Joint("j2", "revolute", "a", "b", shift(1.0, 0.0)),
        Joint(
            *("j3", "revolute", "b", "c", shift(1.2, 0.0)),
            mimic=Mimic("j2", 0.7, 0.5, (0.2, -0.1)),
        ),
        Joint("j4", "revolute", "c", "d", shift(0.9, 0.0)),
    )
    mounts = Mount("end", "d", shift(1.3, 0.0)), Mount("pin", "ground", shift(1.5, 0.2))
    loop = Loop("close", "revolute", ("end", "pin"))
    model = loaded(Robot("bar", 2, links, joints, (0.0, -9.81), mounts, (loop,)))
    q = fb.assemble(model, [0.9, 0.8, 0.6])
    qd = fb.loop_velocity(model, q, {"j1": 0.5})
    found = fb.simulate(model, q, qd, np.linspace(0.0, 0.6, 31), method="rk4", step=2e-3)
    energy = (found.kinetic_energy + found.potential_energy).values
    assert np.ptp(energy) < 1e-9 * np.ptp(found.kinetic_energy.values)


# ---------------------------------------------------------------- files, and MuJoCo
def test_saved_and_loaded(tmp_path):
    model = loaded(arm({"wrist": POWERS["wrist"]}))
    for name in ("arm.toml", "arm.xml"):
        fb.save(model, tmp_path / name, lossy=True)
        again = fb.load(tmp_path / name)
        assert [b.joint.mimic for b in again.bodies] == [b.joint.mimic for b in model.bodies]


@pytest.mark.parametrize("kind", ["urdf", "sdf"])
def test_what_files_lose_is_told(kind):
    told = "the polynomial by which joint 'wrist' follows 'shoulder': it moves on its own"
    assert told in fb.losses(loaded(arm()), kind)


def test_mjcf_holds_degree_4():
    robot = arm({"wrist": (0.3, 0.1, 0.1, 0.2)})
    joints = [replace(x, mimic=None) if x.name == "grip" else x for x in robot.joints]
    told = "the polynomial by which joint 'wrist' follows 'shoulder': it moves on its own"
    assert told in fb.losses(loaded(replace(robot, joints=tuple(joints))), "xml")


HINGES = """
<mujoco>
  <compiler angle="radian"/>
  <option timestep="1e-4"/>
  <default><equality solref="2e-4 1" solimp="0.9999 0.9999 0.001"/></default>
  <worldbody>
    <body><joint name="a" type="hinge" axis="0 1 0" ref="0.2"/>
      <geom type="sphere" size="0.1" pos="0.1 0.05 0.3" density="500"/>
      <body name="tip" pos="0.1 0 0.5"><joint name="b" type="hinge" axis="1 0 0" ref="-0.3"/>
        <geom type="box" size="0.1 0.05 0.2" pos="0 0.1 0.3" density="300"/>
      </body>
    </body>
  </worldbody>
  <equality><joint joint1="b" joint2="a" polycoef="0.1 0.5 -0.3 0.2 0.1"/></equality>
</mujoco>
"""


def test_equality_joint_of_mujoco():
    """The motion under MuJoCo's equality in the limit of a hard one: there the follower is a little
    off, by what its spring takes."""
    mujoco = extra("mujoco", "MuJoCo")
    ours = fb.load(text=HINGES, format="xml")
    theirs = mujoco.MjModel.from_xml_string(HINGES)
    data = mujoco.MjData(theirs)
    a = 0.5

    def follower(a):
        return -0.3 + Polynomial((0.1, 0.5, -0.3, 0.2, 0.1))(a - 0.2)

    data.qpos[:] = a, follower(a)
    start = fb.forward_kinematics(ours, [a], "tip")
    mujoco.mj_forward(theirs, data)
    close(start[:3, :3], data.body("tip").xmat.reshape(3, 3), 1e-9)
    for _ in range(3000):
        mujoco.mj_step(theirs, data)
    close(data.qpos[1], follower(data.qpos[0]), 1e-4)
    found = fb.simulate(ours, [a], [0.0], [0.0, 0.3])
    close(found.q.values[-1], data.qpos[:1], 1e-3)
    assert abs(found.q.values[-1, 0] - a) > 0.2


# ---------------------------------------------------------------- refused
@pytest.mark.parametrize(
    ("call", "told"),
    [
        (lambda m: fb.simulate(m, [0, 0], [0, 0], [0, 1], friction="dry"),
         "simulate: the Coulomb friction of body 'finger', whose joint follows another by a "
         "polynomial, is felt there by a ratio that changes with the position"),
        (lambda m: fb.time_optimal(m, [[0, 0], [1, 1]], velocity=1, acceleration=1),
         "time_optimal: the viscous friction of body 'finger'"),
        (fb.equations, "joint 'wrist' of 'palletiser' follows 'shoulder' by a polynomial: closed "
         "forms need a ratio that does not change with the position."),
    ],
)  # fmt: skip
def test_refused(rubbing, call, told):
    with pytest.raises(fb.FreebodyError) as error:
        call(rubbing)
    assert told in str(error.value)


@pytest.mark.parametrize(
    ("mimic", "told"),
    [
        ("{ joint = 'shoulder', ratio = [] }",
         "ratio is empty; give a number, or the coefficients of q, q², q³, …"),
        ("{ joint = 'shoulder', ratio = [1, 'x'] }", "ratio[1] is 'x', expected a number"),
        ("{ joints = { shoulder = [1, 2], elbow = [] } }", "elbow is empty; give a number"),
    ],
)  # fmt: skip
def test_refused_in_files(mimic, told):
    robot = arm()
    joint = robot.joints[2].text()
    written = joint[: joint.index("mimic")] + f"mimic = {mimic}\n"
    with pytest.raises(fb.FileError) as error:
        loaded(robot.text().replace(joint, written))
    assert told in str(error.value)


def test_a_polynomial_of_a_sum_is_refused():
    robot = arm()
    joint = robot.joints[2].text()
    several = joint[: joint.index("mimic")] + "mimic = { joints = { shoulder = 1, elbow = 1 } }\n"
    told = "joint 'grip' follows 'wrist' by a polynomial, and that follows several joints"
    with pytest.raises(fb.FileError, match=told):
        loaded(robot.text().replace(joint, several))
