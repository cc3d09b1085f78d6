"""Closed chains beside Pinocchio, MuJoCo and Drake, and beside equations of motion in reduced
coordinates."""

from __future__ import annotations

import math
from functools import lru_cache

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Model
from support.extras import extra
from support.helpers import all_driven, close, numbers
from support.robots import Joint, Link, Loop, Robot, loaded

pytestmark = pytest.mark.usefixtures("numpy_kernels")

pin, mujoco = extra("pinocchio", "Pinocchio"), extra("mujoco", "MuJoCo")
G = 9.81


# ---------------------------------------------------------------- reduced coordinates, by hand
def reduced(lengths, theta, rate, torque):
    """θ̈ of a planar one-freedom mechanism: E = ½ m(θ) θ̇² + V(θ), by complex steps of its
    closed-form kinematics.

    lengths(θ): list of (mass, inertia, x, y, angle) with entries that may be complex.
    """

    def values(z):
        return np.array([[x, y, angle] for _, _, x, y, angle in lengths(z)])

    h = 1e-30
    first = values(theta + 1j * h).imag / h
    step = 1e-3
    second = sum(
        w * values(theta + k * step + 1j * h).imag / h
        for k, w in ((-4, 1 / 280), (-3, -4 / 105), (-2, 1 / 5), (-1, -4 / 5))
    )
    second = second - sum(
        w * values(theta + k * step + 1j * h).imag / h
        for k, w in ((4, 1 / 280), (3, -4 / 105), (2, 1 / 5), (1, -4 / 5))
    )
    second = second / step
    parts = lengths(theta)
    m = sum(
        p[0] * (f[0] ** 2 + f[1] ** 2) + p[1] * f[2] ** 2 for p, f in zip(parts, first, strict=True)
    )
    slope = sum(
        p[0] * (f[0] * s[0] + f[1] * s[1]) + p[1] * f[2] * s[2]
        for p, f, s in zip(parts, first, second, strict=True)
    )
    gravity = sum(p[0] * G * f[1] for p, f in zip(parts, first, strict=True))
    return (torque - slope * rate**2 - gravity) / m


@pytest.mark.parametrize("theta", [0.3, 1.2, 2.8, -0.9, np.pi / 2])
def test_slider_crank_in_its_crank_angle(theta):
    model = fb.load("slider_crank")
    p = model.parameters

    def parts(z):
        phi = -np.arcsin(p["l1"] * np.sin(z) / p["l2"])
        x, y = p["l1"] * np.cos(z), p["l1"] * np.sin(z)
        return [
            (p["m1"], p["I1"], p["lc1"] * np.cos(z), p["lc1"] * np.sin(z), z),
            (p["m2"], p["I2"], x + p["lc2"] * np.cos(phi), y + p["lc2"] * np.sin(phi), phi),
            (p["m3"], 0.0, x + p["l2"] * np.cos(phi), 0.0 * z, 0.0 * z),
        ]

    at = parts(theta)
    q = np.array([theta, at[1][4] - theta, at[2][2]])
    check_one_freedom(model, q, parts, theta)


@pytest.mark.parametrize("theta", [0.3, 1.2, 2.8, -0.9, np.pi / 2])
def test_four_bar_in_its_crank_angle(theta):
    model = fb.load("four_bar")
    p = model.parameters

    def parts(z):
        x, y = p["l1"] * np.cos(z), p["l1"] * np.sin(z)
        dx, dy = p["d"] - x, -y
        r2 = dx * dx + dy * dy
        r = np.sqrt(r2)
        cosine = (r2 + p["l2"] ** 2 - p["l3"] ** 2) / (2 * r * p["l2"])
        phi = _angle(dx, dy) + np.arccos(cosine)
        ex, ey = x + p["l2"] * np.cos(phi), y + p["l2"] * np.sin(phi)
        psi = _angle(ex - p["d"], ey)
        return [
            (p["m1"], p["I1"], p["lc1"] * np.cos(z), p["lc1"] * np.sin(z), z),
            (p["m2"], p["I2"], x + p["lc2"] * np.cos(phi), y + p["lc2"] * np.sin(phi), phi),
            (p["m3"], p["I3"], p["d"] + p["lc3"] * np.cos(psi), p["lc3"] * np.sin(psi), psi),
        ]

    at = parts(theta)
    q = np.array([theta, np.real(at[1][4]) - theta, np.real(at[2][4])])
    check_one_freedom(model, q, parts, theta)


def _angle(x, y):
    """atan2 that a complex step may pass through."""
    if not (np.iscomplexobj(x) or np.iscomplexobj(y)):
        return np.arctan2(y, x)
    a = np.arctan2(np.real(y), np.real(x))
    slope = (np.real(x) * np.imag(y) - np.real(y) * np.imag(x)) / (
        np.real(x) ** 2 + np.real(y) ** 2
    )
    return a + 1j * slope


def check_one_freedom(model, q, parts, theta):
    for rate, torque in ((0.0, 0.0), (2.0, 0.0), (-3.0, 1.7)):
        qd = fb.loop_velocity(model, q, {model.velocity_names[0]: rate})
        qdd = fb.forward_dynamics(model, q, qd, [torque, 0.0, 0.0])
        expected = reduced(parts, theta, rate, torque)
        close(qdd[0], expected, 1e-10, 1.0)
        # the energy, too
        m = [(a, b) for a, b, *_ in parts(theta)]
        assert len(m) == len(model.bodies)
        close(fb.inverse_dynamics(model, q, qd, qdd), [torque, 0.0, 0.0], 1e-10, 1.0)


@pytest.mark.parametrize("angle", [0.0, 0.7, 2.0, -2.5])
def test_a_pendulum_on_a_rod(angle):
    """A particle free in the plane, held at a distance: θ̈ = -(g / l) sin θ, tension m (l θ̇² + g
    cos θ)."""
    model = particle()
    l, m, w = 0.8, 1.3, 1.7
    s, c = np.sin(angle), np.cos(angle)
    q, qd = np.array([l * s, -l * c]), l * w * np.array([c, s])
    found = fb.reactions(model, q, qd, tau=[0.0, 0.0])
    turn = -G / l * s
    expected = l * turn * np.array([c, s]) + l * w**2 * np.array([-s, c])
    close(found.qdd, expected, 1e-12)
    close(found.multipliers, [m * (l * w**2 + G * c)], 1e-12)
    assert found.balance < 1e-12


def particle() -> Model:

    return loaded(
        Robot(
            "pendulum",
            2,
            (Link("ground"), Link("rail"), Link("bob", Inertia(1.3, (0.0, 0.0), (0.0,)))),
            (
                Joint("x", "prismatic", "ground", "rail", axis=(1.0, 0.0), passive=True),
                Joint("y", "prismatic", "rail", "bob", axis=(0.0, 1.0), passive=True),
            ),
            G,
            loops=(Loop("rod", "distance", ("ground", "bob"), distance=0.8),),
        )
    )


# ---------------------------------------------------------------- Pinocchio, MuJoCo, Drake
MECHANISMS = ("four_bar", "five_bar", "slider_crank", "stewart", "bricard")


@lru_cache(maxsize=8)
def closed_state(name: str) -> tuple[Model, np.ndarray, np.ndarray, np.ndarray]:
    """The mechanism in space, a state, torques of all joints."""
    model = all_driven(fb.load(name)).to_space()
    rng = np.random.default_rng(4)
    q = fb.neutral(model)
    if name == "stewart":
        q[2] = 0.9
    elif name == "bricard":
        q = fb.random_state(model, 3)[0]
    else:
        q = q + rng.uniform(0.2, 0.8, size=model.nq)
    q = fb.assemble(model, q)
    qd = fb.loop_velocity(model, q, rng.normal(size=model.nv))
    return model, q, qd, rng.normal(scale=2.0, size=model.nv)


def _listed(kind, items):
    result = kind()
    for item in items:
        result.append(item)
    return result


def depth_first(model: Model, k: int = -1) -> list[int]:
    """Indices of the tree's bodies, each before what it carries, branch by branch."""
    return [i for child in model.tree.children(k) for i in (child, *depth_first(model, child))]


def pinocchio_twin(model: Model):
    """(Pinocchio's model, index of each of our velocities in theirs, frames by name) built body by
    body."""
    twin = pin.Model()
    twin.gravity.linear = np.array(model.gravity)
    ids, frames = {-1: 0}, {}
    order = []
    for k in depth_first(model):  # its composite bodies need that
        body = model.tree.bodies[k]
        place = pin.SE3(np.array(body.R, dtype=float), np.array(body.p, dtype=float))
        kind = next(
            b.kind.name for b, i in zip(model.bodies, model.tree.body_of, strict=True) if i == k
        )
        axis = np.array(body.axis, dtype=float)
        joint = {
            "revolute": lambda a=axis: pin.JointModelRevoluteUnaligned(a),
            "prismatic": lambda a=axis: pin.JointModelPrismaticUnaligned(a),
            "free": pin.JointModelFreeFlyer,
        }[kind]()
        ids[k] = twin.addJoint(ids[body.parent], joint, place, f"joint{k}")
        for mass in body.masses:
            inertia = pin.Inertia(
                float(mass.m), np.array(mass.c, dtype=float), np.array(mass.inertia, dtype=float)
            )
            twin.appendBodyToJoint(ids[k], inertia, pin.SE3.Identity())
        order.append((k, body.coordinates))
    v = np.zeros(model.nv, dtype=int)
    q = np.zeros(model.nq, dtype=int)
    for k, at in order:
        joint = twin.joints[ids[k]]
        v[list(at.v)] = np.arange(joint.idx_v, joint.idx_v + joint.nv)
        own = list(at.q)
        theirs = np.arange(joint.idx_q, joint.idx_q + joint.nq)
        if len(own) == 7:
            theirs = theirs[[0, 1, 2, 6, 3, 4, 5]]
        q[own] = theirs
    for name, (body, R, p) in model.tree.frames.items():
        frames[name] = ids[body], pin.SE3(np.array(R, dtype=float), np.array(p, dtype=float))
    return twin, q, v, frames


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", MECHANISMS)
def test_beside_pinocchio(name):
    """Its constrained dynamics on the loops as contacts: of a ball 3D, of a pin 6D less the turn
    that a pin allows."""
    model, q, qd, tau = closed_state(name)
    twin, at_q, at_v, frames = pinocchio_twin(model)
    q_p, v_p, tau_p = np.zeros(twin.nq), np.zeros(twin.nv), np.zeros(twin.nv)
    q_p[at_q], v_p[at_v], tau_p[at_v] = q, qd, tau
    contacts = []
    for loop in model.loops:
        (i, A), (j, B) = (frames[f] for f in loop.frames)
        points = [np.zeros(3)]
        if (
            loop.kind == "revolute"
        ):  # a pin: balls at two points of its axis; one equation more than needed
            points.append(np.array(loop.axis))
        for point in points:
            shifted = pin.SE3(np.eye(3), point)
            contacts.append(
                pin.RigidConstraintModel(
                    pin.ContactType.CONTACT_3D, twin, i, A * shifted, j, B * shifted, pin.LOCAL
                )
            )
    data = twin.createData()
    datas = [contact.createData() for contact in contacts]
    contacts, datas = (
        _listed(pin.StdVec_RigidConstraintModel, contacts),
        _listed(pin.StdVec_RigidConstraintData, datas),
    )
    pin.initConstraintDynamics(twin, data, contacts, datas)
    settings = pin.ProximalSettings(1e-14, 1e-6, 500)
    found = pin.constraintDynamics(twin, data, q_p, v_p, tau_p, contacts, datas, settings)
    ours = fb.forward_dynamics(model, q, qd, tau)
    close(ours, found[at_v], 1e-10, 1.0)


@pytest.mark.parametrize("name", MECHANISMS)
def test_beside_mujoco(name):
    """With its equalities as hard as it lets them be, at rest, for its constraints leave out what
    depends on rates; and exactly, its mass matrix and bias with our accelerations and our loops'
    forces."""
    model, q, qd, tau = closed_state(name)
    twin = mujoco.MjModel.from_xml_string(mujoco_text(model))
    twin.opt.gravity[:] = model.gravity
    data = mujoco.MjData(twin)
    v = np.concatenate(
        [twin.joint(joint).dofadr + np.arange(_sizes(model)[joint]) for joint in model.joint_names]
    )
    for joint, at in zip(model.joint_names, model.coordinates, strict=True):
        start = int(twin.joint(joint).qposadr[0])
        data.qpos[start : start + len(at.q)] = q[list(at.q)]
    # a free body's velocity in world axes: u = T v, u̇ = T v̇ + Ṫ v
    T, extra = np.eye(model.nv), np.zeros(model.nv)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.kind.name == "free":
            R = fb.forward_kinematics(model, q, body.name)[:3, :3]
            T[np.ix_(at.v[:3], at.v[:3])] = R
            extra[list(at.v[:3])] = R @ np.cross(qd[list(at.v[3:])], qd[list(at.v[:3])])
    data.qfrc_applied[v] = np.linalg.solve(T.T, tau)
    mujoco.mj_forward(twin, data)
    assert np.abs(data.efc_pos[: data.ne]).max() < 1e-9
    still = np.zeros(model.nv)
    close(data.qacc[v], T @ fb.forward_dynamics(model, q, still, tau), 2e-3, 1.0, "hardened")
    data.qvel[v] = T @ qd
    mujoco.mj_forward(twin, data)
    found = fb.reactions(model, q, qd, tau=tau)
    M = np.zeros((twin.nv, twin.nv))
    _full(twin, data, M)
    J = numbers(model, "constraint_jacobian", q)
    needed = T.T @ (M[np.ix_(v, v)] @ (T @ found.qdd + extra) + data.qfrc_bias[v])
    close(needed, tau - J.T @ found.multipliers, 1e-8)


def _full(twin, data, M) -> None:
    try:
        mujoco.mj_fullM(twin, M, data.qM)
    except (TypeError, AttributeError):  # from 4 on
        mujoco.mj_fullM(twin, data, M)


def _sizes(model: Model) -> dict[str, int]:
    return {body.joint.name: body.kind.nv for body in model.bodies}


def mujoco_text(model: Model) -> str:
    """A MuJoCo file of the mechanism. A massless cross between two pins is told as two pins of one
    body; what turns in the plane only gets inertia about the plane's axes, which its motion does
    not feel."""
    tree = model.tree
    index = {k: i for i, k in enumerate(tree.body_of)}

    def row(values) -> str:
        return " ".join(repr(float(x)) for x in np.ravel(values))

    def joint(k: int) -> str:
        body = tree.bodies[k]
        name = model.bodies[index[k]].joint.name
        kind = model.bodies[index[k]].kind.name
        if kind == "free":
            return f'<freejoint name="{name}"/>'
        return (
            f'<joint name="{name}" type="{"hinge" if kind == "revolute" else "slide"}" '
            f'axis="{row(body.axis)}"/>'
        )

    def inertial(k: int) -> str:
        (mass,) = tree.bodies[k].masses
        tensor = np.array(mass.inertia, dtype=float)
        if not tensor[:2].any():
            tensor[2, 2] = max(tensor[2, 2], 1e-9)
            tensor = tensor + np.diag([0.6, 0.6, 0.0]) * tensor[2, 2]
        tensor += (
            1e-10 * np.eye(3) * (np.linalg.eigvalsh(tensor)[0] <= 0.0)
        )  # rods have none along them
        six = tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]]
        return f'<inertial pos="{row(mass.c)}" mass="{float(mass.m)!r}" fullinertia="{row(six)}"/>'

    def told(k: int, joints: str = "") -> str:
        body = tree.bodies[k]
        place = np.array(body.R, dtype=float)
        children = tree.children(k)
        joints += joint(k)
        if not body.masses:
            (only,) = children
            assert not np.any(tree.bodies[only].p)
            inner = told(only, joints)
            return inner.replace('pos="0.0 0.0 0.0"', f'pos="{row(body.p)}"', 1)
        inside = "".join(told(c) for c in children)
        where = f'name="b{k}" pos="{row(body.p)}" quat="{row(fb.quat_wxyz(place))}"'
        return f"<body {where}>{joints}{inertial(k)}{inside}</body>"

    sites, equalities = {}, ""
    for loop in model.loops:
        offsets = [np.zeros(3)] if loop.kind == "spherical" else [np.zeros(3), np.array(loop.axis)]
        for m, offset in enumerate(offsets):
            names = []
            for frame in loop.frames:
                body, R, at = tree.frames[frame]
                site = f"{loop.name}_{frame}_{m}"
                where = np.array(at, dtype=float) + np.array(R, dtype=float) @ offset
                sites.setdefault(body, []).append(f'<site name="{site}" pos="{row(where)}"/>')
                names.append(site)
            equalities += (
                f'<connect site1="{names[0]}" site2="{names[1]}" solref="0.0002 1" '
                'solimp="0.9999 0.9999 0.001 0.5 2"/>'
            )
    text = "".join(told(c) for c in tree.children(-1))
    for body, found in sites.items():
        here = "".join(found)
        if body < 0:
            text = here + text
        else:
            text = text.replace(f'<body name="b{body}" ', f'<!--{body}--><body name="b{body}" ', 1)
            start = text.index("<inertial", text.index(f"<!--{body}-->"))
            text = text[:start] + here + text[start:]
    return (
        '<mujoco><compiler angle="radian" autolimits="false"/><option timestep="0.0001" '
        'iterations="200" '
        f'tolerance="0"/><worldbody>{text}</worldbody><equality>{equalities}</equality></mujoco>'
    )


def bennett(a: float = 0.7, alpha: float = 0.6, beta: float = 1.1) -> fb.Model:
    """Bennett's loop of four turning joints: sides a, b, a, b, b / sin beta = a / sin alpha, the
    last side the base."""
    b = a * math.sin(beta) / math.sin(alpha)
    sides = [(a, alpha), (b, beta), (a, alpha)]
    rods = [{"a": x, "alpha": t, "m": 1.0 + k, "com": [-x / 2, 0, 0],
             "I": [0.001, 0, 0, 0.05, 0, 0.05]}
            for k, (x, t) in enumerate(sides)]  # fmt: skip
    c, s = math.cos(beta), math.sin(beta)
    arm = fb.dh(rods, convention="standard", name="bennett")
    arm = arm.with_frame("last_axis", [-b, 0, 0], [[1, 0, 0], [0, c, s], [0, -s, c]], frame="base")
    return arm.with_loop("joint4", "revolute", ("frame3", "last_axis"), axis=(0, 0, 1))


@pytest.mark.parametrize("theta", [0.4, 1.3, 2.5, -1.9])
def test_bennetts_loop_moves_as_its_closed_form_says(theta: float) -> None:
    """tan(θ1/2) tan(θ2/2) = const and θ3 = -θ1 (G. T. Bennett, A new mechanism, Engineering 76,
    1903)."""
    alpha, beta = 0.6, 1.1
    model = bennett(alpha=alpha, beta=beta)
    ratio = math.sin((beta + alpha) / 2) / math.sin((beta - alpha) / 2)
    other = 2 * math.atan(ratio / math.tan(theta / 2))
    q = fb.assemble(model, {"joint1": theta, "joint2": other, "joint3": -theta})
    np.testing.assert_allclose(q, [theta, other, -theta], atol=1e-12)
    found = fb.mobility(model, q)
    assert (found.generic, found.instantaneous) == (1, 1)
    s1, c1, s2, c2 = math.sin(theta), math.cos(theta), math.sin(other), math.cos(other)
    rate = 0.8
    G = np.array([1.0, -s2 / s1, -1.0])
    G_rate = np.array([0.0, -(rate * G[1] * c2 / s1 - rate * s2 * c1 / s1**2), 0.0])
    qd = fb.loop_velocity(model, q, {"joint1": rate})
    np.testing.assert_allclose(qd, G * rate, atol=1e-12)
    # one equation of motion, by virtual work along the closed form
    tree = model.opened
    M, bias = fb.mass_matrix(tree, q), fb.bias(tree, q, qd)
    second = -G @ (M @ (G_rate * rate) + bias) / (G @ M @ G)
    qdd = fb.forward_dynamics(model, q, qd, np.zeros(3))
    np.testing.assert_allclose(
        qdd, G * second + G_rate * rate, rtol=0, atol=1e-12 * max(1.0, abs(qdd).max())
    )
