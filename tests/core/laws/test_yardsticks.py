"""Other people's numbers, printed by their programs or books: each with its source."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import freebody as fb
from freebody import Inertia, Model
from support.helpers import close, numbers
from support.robots import Joint, Link, Robot, loaded, shift

AXES = {"x": (1.0, 0.0, 0.0), "y": (0.0, 1.0, 0.0), "z": (0.0, 0.0, 1.0)}


def revolutes(
    *bodies: tuple[int, tuple, str, float, tuple, tuple], gravity=(0.0, -9.81, 0.0)
) -> Model:
    """Bodies (parent, offset in it, axis, mass, com, principal moments about it) behind revolute
    joints."""
    links, joints = [Link("world")], []
    for i, (parent, offset, axis, mass, com, principal) in enumerate(bodies):
        links.append(Link(f"b{i}", Inertia.of(mass, com, np.diag(principal).astype(float))))
        above = "world" if parent < 0 else f"b{parent}"
        joints.append(
            Joint(f"j{i}", "revolute", above, f"b{i}", shift(*map(float, offset)), AXES[axis])
        )
    return loaded(Robot("rbdl", 3, tuple(links), tuple(joints), gravity), tip="b0")


def half_digit(found, printed, digits: int) -> None:
    """As printed with so many decimals."""
    assert np.abs(np.asarray(found) - np.asarray(printed)).max() <= 0.5000001 * 10.0**-digits


def drop(model: Model) -> np.ndarray:
    """Accelerations from rest at zero without torques, by the kernel and by plain arrays."""
    zero = np.zeros(model.nv)
    qdd = fb.forward_dynamics(model, zero, zero, zero)
    close(qdd, numbers(model, "forward_dynamics", zero, zero, zero), 1e-12)
    return qdd


# ---------------------------------------------------------------- RBDL, tests/DynamicsTests.cc
UNIT = (1, 1, 1)


def test_rbdl_single():
    half_digit(drop(revolutes((-1, (0, 0, 0), "z", 1, (1.5, 1, 1), (1, 2, 3)))), [-2.3544], 4)


@pytest.mark.parametrize(
    "qdd",
    [[-4.905], [-5.886, 3.924], [-6.036923076923, 3.773076923077, 1.509230769231]],
    ids=["one", "two", "three"],
)
def test_rbdl_chain(qdd: list[float]):
    bodies = [(i - 1, (float(i > 0), 0, 0), "z", 1, (1, 0, 0), UNIT) for i in range(len(qdd))]
    half_digit(drop(revolutes(*bodies)), qdd, 12 if len(qdd) == 3 else 3)


def test_rbdl_tree():
    model = revolutes(
        (-1, (0, 0, 0), "z", 1, (1, 0, 0), UNIT),
        (0, (1, 0, 0), "y", 1, (0, 1, 0), UNIT),
        (1, (0, 1, 0), "x", 1, (0, 0, 1), UNIT),
        (0, (-0.5, 0, 0), "y", 1, (0, 1, 0), UNIT),
        (3, (0, -0.5, 0), "x", 1, (0, 0, 1), UNIT),
    )
    printed = [
        -1.60319066147860,
        -0.534396887159533,
        4.10340466926070,
        0.267198443579767,
        5.30579766536965,
    ]
    half_digit(drop(model), printed, 14)


# ---------------------------------------------------------------- Puma 560: Corke's Robotics
# Toolbox
def puma(**options) -> Model:
    """roboticstoolbox-python, models/DH/Puma560.py: standard DH; links 1 and 3 are not physical."""
    quarter = math.pi / 2
    geometry = [
        (0, quarter, 0.67183),
        (0.4318, 0, 0),
        (0.0203, -quarter, 0.15005),
        (0, quarter, 0.4318),
        (0, -quarter, 0),
        (0, 0, 0),
    ]
    mass = [0, 17.4, 4.8, 0.82, 0.34, 0.09]
    com = [
        (0, 0, 0),
        (-0.3638, 0.006, 0.2275),
        (-0.0203, -0.0141, 0.07),
        (0, 0.019, 0),
        (0, 0, 0),
        (0, 0, 0.032),
    ]
    moments = [
        (0, 0.35, 0),
        (0.13, 0.524, 0.539),
        (0.066, 0.086, 0.0125),
        (1.8e-3, 1.3e-3, 1.8e-3),
        (0.3e-3, 0.4e-3, 0.3e-3),
        (0.15e-3, 0.15e-3, 0.04e-3),
    ]
    rotor = [2.0e-4] * 3 + [3.3e-5] * 3
    gear = [-62.6111, 107.815, -53.7063, 76.0364, 71.923, 76.686]
    rows = [
        {
            "a": a,
            "alpha": alpha,
            "d": d,
            "m": m,
            "com": c,
            "I": np.diag(I).astype(float),
            "rotor": J,
            "gear": G,
        }
        for (a, alpha, d), m, c, I, J, G in zip(
            geometry, mass, com, moments, rotor, gear, strict=True
        )
    ]
    return fb.dh(rows, convention="standard", name="puma560", **options)


@pytest.mark.filterwarnings("ignore::freebody.errors.PhysicalWarning")
def test_puma560():
    """roboticstoolbox-python, tests/test_DHRobot.py, at the nominal configuration."""
    model = puma(physical="warn")
    q = np.array([0, math.pi / 4, math.pi, 0, math.pi / 4, 0])
    zero, ones = np.zeros(6), np.ones(6)
    half_digit(fb.gravity_torque(model, q), [0, 31.6399, 6.0351, 0, 0.0283, 0], 4)
    M = fb.mass_matrix(model, q)
    printed = [
        [3.6594, -0.4044, 0.1006, -0.0025, 0, 0],
        [4.4137, 0.3509, 0, 0.0024, 0],
        [0.9378, 0, 0.0015, 0],
        [0.1925, 0, 0],
        [0.1713, 0],
        [0.1941],
    ]
    for i, row in enumerate(printed):
        half_digit(M[i, i:], row, 4)
    # printed with six digits each
    tau = fb.inverse_dynamics(model, q, zero, ones)
    for value, digits, text in zip(
        tau,
        [5, 4, 5, 6, 6, 6],
        [3.35311, 36.0025, 7.42596, 0.190043, 0.203441, 0.194133],
        strict=True,
    ):
        half_digit(value, text, digits)
    half_digit(
        fb.inverse_dynamics(model, q, ones, zero),
        [-1.3911, 33.4228, 5.2831, 0.0012, 0.0306, 0.0001],
        4,
    )


def test_puma560_holds_links_that_no_rigid_body_can_have():
    with pytest.warns(fb.PhysicalWarning) as told:
        model = puma(physical="warn")
    assert [str(w.message).split(":")[1] for w in told] == [" link 'link1'", " link 'link3'"]
    assert [str(n) for n in model.notices if n.kind == "physical"] == [str(w.message) for w in told]
    with pytest.raises(
        fb.FreebodyError,
        match=r"'puma560': link 'link1': principal moments 0, 0, 0\.35 kg m² break the triangle",
    ):
        puma()


# ---------------------------------------------------------------- double pendulums
def acrobot() -> Model:
    """Drake, multibody/benchmarks/acrobot; Spong's parameters."""
    return fb.planar("RR", l=[1, 2], lc=[0.5, 0.5], m=[1, 1], I=[0.083, 0.33])


def test_acrobot():
    model = acrobot()
    close(fb.mass_matrix(model, [0.3, 0.0]), [[2.913, 1.08], [1.08, 0.58]], 1e-14)
    close(fb.mass_matrix(model, [0.3, math.pi / 3]), [[2.413, 0.83], [0.83, 0.58]], 1e-14)
    # Drake counts theta1 from the downward vertical, the notes from the horizontal
    q, qd = np.array([math.pi / 6 - math.pi / 2, math.pi / 3]), np.array([0.4, -0.7])
    coriolis = [0.0303108891325, 0.0692820323028]
    half_digit(fb.coriolis_matrix(model, q, qd) @ qd, coriolis, 13)
    half_digit(fb.gravity_torque(model, q), [12.2625, 4.905], 12)
    half_digit(fb.bias(model, q, qd), np.add(coriolis, [12.2625, 4.905]), 12)


@pytest.mark.parametrize(
    ("qd", "tau"), [((1.5, 0.0), (0.0, 28.125)), ((1.5, 1.5), (-84.375, 28.125))]
)
@pytest.mark.parametrize("q1", [0.0, -0.7, 2.0])
@pytest.mark.parametrize("inertia", [0.0, 1.3])
def test_double_pendulum_newton(qd: tuple, tau: tuple, q1: float, inertia: float):
    """Newton, newton/tests/test_inverse_dynamics.py: neither q1 nor the inertias matter."""
    model = fb.planar("RR", l=[1, 1], lc=[0.5, 0.5], m=[25, 25], I=[inertia] * 2, g=0)
    close(fb.inverse_dynamics(model, [q1, math.pi / 2], qd, [0, 0]), tau, 1e-13, 100.0)
    close(fb.inverse_dynamics(model.to_space(), [q1, math.pi / 2], qd, [0, 0]), tau, 1e-13, 100.0)


# ---------------------------------------------------------------- bodies that turn in space
def pivoted(inertia: Inertia, kind: str, gravity: float) -> Model:
    links = (Link("world"), Link("body", inertia))
    joints = (Joint("pivot", kind, "world", "body"),)
    return loaded(Robot(kind, 3, links, joints, gravity))


def spin(model: Model, w0: tuple[float, ...], duration: float) -> tuple[np.ndarray, np.ndarray]:
    """(quaternion wxyz, ω in the body's axes) after a motion without torques, by a compiled
    kernel."""
    forward = fb.kernel(model, "forward_dynamics")
    nq, nv = model.nq, model.nv
    no_torque = np.zeros(nv)

    def slope(t: float, y: np.ndarray) -> np.ndarray:
        q, qd = y[:nq], y[nq:]
        w, x, z = q[-4], q[-3:], qd[-3:]
        turning = 0.5 * np.array([-x @ z, *(w * z + np.cross(x, z))])
        moving = []
        if nq == 7:
            u = q[-3:]
            moving = qd[:3] + 2 * w * np.cross(u, qd[:3]) + 2 * np.cross(u, np.cross(u, qd[:3]))
        return np.concatenate([moving, turning, forward(q, qd, no_torque)])

    start = np.concatenate([fb.neutral(model), np.zeros(nv - 3), w0])
    end = solve_ivp(slope, (0, duration), start, method="DOP853", rtol=1e-12, atol=1e-12).y[:, -1]
    return end[nq - 4 : nq], end[-3:]


def test_heavy_top():
    """Exudyn, heavyTop.py: its converged solution at 0.2 s."""
    model = pivoted(
        Inertia.of(15.0, (0, 1, 0), np.diag([0.234375, 0.46875, 0.234375])), "spherical", 9.81
    )
    quaternion, w = spin(model, (0.0, 150.0, -4.61538), 0.2)
    printed = np.array([-0.708279152975, 0.438781088126, 0.545728396145, 0.089399752823])
    close(quaternion * np.sign(quaternion @ printed), printed, 1e-9)
    close(w, [-2.691590912, 150.0, 4.917260990], 1e-9)


@pytest.mark.parametrize("kind", ["free", "spherical"])
def test_free_axisymmetric_body(kind: str):
    """Drake, multibody/benchmarks/free_body: I = 0.04 across, J = 0.02 along z; and in closed
    form."""
    body = Inertia.of(1.0, (0, 0, 0), np.diag([0.04, 0.04, 0.02]))
    model = pivoted(body, kind, 9.81)
    _, w = spin(model, (2.0, 4.0, 6.0), 1.0)
    close(w, [-1.4155049609614219, -4.242210002521516, 6], 1e-11)
    s, c = math.sin(3.0), math.cos(3.0)
    close(w, [2 * c + 4 * s, 4 * c - 2 * s, 6], 1e-11)


def test_simulate_gives_the_same():
    """The package's own simulation of the two, quaternions kept at unit length on the way."""
    top = pivoted(
        Inertia.of(15.0, (0, 1, 0), np.diag([0.234375, 0.46875, 0.234375])), "spherical", 9.81
    )
    end = fb.simulate(
        top, fb.neutral(top), [0.0, 150.0, -4.61538], [0.0, 0.2], tolerance=1e-12
    ).isel(time=-1)
    close(end["qd"].values, [-2.691590912, 150.0, 4.917260990], 1e-9)
    printed = np.array([-0.708279152975, 0.438781088126, 0.545728396145, 0.089399752823])
    q = end["q"].values
    close(q * np.sign(q @ printed), printed, 1e-9)
    free = pivoted(Inertia.of(1.0, (0, 0, 0), np.diag([0.04, 0.04, 0.02])), "free", 0.0)
    end = fb.simulate(
        free, fb.neutral(free), [0, 0, 0, 2.0, 4.0, 6.0], [0.0, 1.0], tolerance=1e-12
    ).isel(time=-1)
    close(end["qd"].values[3:], [-1.4155049609614219, -4.242210002521516, 6], 1e-10)


def test_pendulum_of_the_iftomm_library():
    """Library of computational benchmark problems, A01: a point pendulum released at rest from the
    horizontal."""
    model = fb.planar("R", l=[1], lc=[1], m=[1], I=[0], g=9.81)
    motion = fb.simulate(model, [math.pi], [0.0], [0.0, 1.0, 10.0], tolerance=1e-12)
    xy = fb.forward_kinematics(model, motion["q"].values)[:, :2, 2]
    half_digit(xy[1], [0.98629175113, -0.16501085313], 10)
    half_digit(xy[2], [-0.27508746258, -0.96141920510], 8)
