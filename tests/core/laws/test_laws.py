"""Laws that hold for every mechanism, on random trees: by formulas on plain arrays, and some by
compiled kernels."""

from __future__ import annotations

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest

import freebody as fb
from freebody import Inertia, Model, SingularError
from support import generate
from support.helpers import (
    close,
    in_space,
    numbers,
    path,
    poses,
    random_wrenches,
    rate,
    second_rate,
    state,
)
from support.robots import Joint, Link, Placement, Robot, loaded, rotate, shift
from support.tree_marks import CASES, FLAT_TREES, TREES, every_other, every_tree, trees

EPS = np.finfo(float).eps
H = 2e-3  # s, step of first differences
H2 = 6e-3  # s, of second ones


def test_the_trees_hold_every_joint_kind_often():
    counts: Counter[str] = Counter()
    for seed in TREES[1::4]:
        description = generate.tree(seed)
        counts.update(joint.kind for joint in description.joints)
        mimics = {joint.name: joint.mimic for joint in description.joints if joint.mimic}
        counts["mimic"] += len(mimics)
        counts["mimic of mimic"] += sum(m.joint in mimics for m in mimics.values())
        counts["free base"] += generate.base(seed) == "free"
        model = generate.model(seed)
        carriers = {body.parent for body in model.bodies}
        assert 1 <= len(model.bodies) - (generate.base(seed) == "free") <= 12
        counts["fixed siblings"] += any(
            n > 1
            for n in Counter(j.parent for j in description.joints if j.kind == "fixed").values()
        )
        counts["massless between"] += sum(
            not b.inertias and i in carriers for i, b in enumerate(model.bodies)
        )
        counts["child before parent in the file"] += any(
            body.parent > i for i, body in enumerate(model.bodies)
        )
        for drive in (joint.drive for joint in description.joints):
            counts.update(
                k for k in ("viscous", "coulomb", "rotor", "stiffness") if getattr(drive, k)
            )
        counts["base mass"] += bool(model.base_inertias)
        counts["branching"] += any(n > 1 for n in Counter(b.parent for b in model.bodies).values())
    kinds = (*generate.MOVING, "fixed", "mimic")
    assert not {k: counts[k] for k in kinds if counts[k] < 10}
    rest = (
        "mimic of mimic",
        "free base",
        "fixed siblings",
        "massless between",
        "child before parent in the file",
    )
    rest += ("viscous", "coulomb", "rotor", "stiffness", "base mass", "branching")
    assert not {k: counts[k] for k in rest if counts[k] < 7}


def condition(M: np.ndarray) -> float:
    return float(np.linalg.cond(M).max())


# ---------------------------------------------------------------- forward, inverse, mass matrix
@pytest.mark.sample(7)
@every_tree
def test_forward_dynamics_undoes_inverse_dynamics(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    M = numbers(model, "mass_matrix", q)
    allowed = max(1e-10, 1e3 * EPS * condition(M))
    close(
        numbers(model, "forward_dynamics", q, qd, tau, wrenches=loads),
        qdd,
        allowed,
        what="forward(inverse)",
    )
    close(numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads), tau, 0.0)


@pytest.mark.sample(14)
@every_tree
def test_mass_matrix(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    M = numbers(model, "mass_matrix", q)
    close(M, np.swapaxes(M, -1, -2), 0.0, what="symmetric")
    assert np.linalg.eigvalsh(M).min() > 0
    bias = numbers(model, "bias", q, qd)
    close(numbers(model, "inverse_dynamics", q, qd, np.zeros_like(qd)), bias, 1e-15, what="bias")
    units = np.eye(model.nv)[:, None, :] + np.zeros_like(qd)
    columns = numbers(model, "inverse_dynamics", q, qd, units) - bias
    scale = float(max(abs(bias).max(), abs(M).max()))
    close(np.moveaxis(columns, 0, -1), M, 1e-12, scale, "columns of inverse dynamics")
    close(
        numbers(model, "inverse_dynamics", q, qd, qdd),
        (M @ qdd[..., None])[..., 0] + bias,
        1e-12,
        scale,
        "M q̈ + bias",
    )
    twice_T = 2 * numbers(model, "kinetic_energy", q, qd)
    close(twice_T, np.einsum("...i,...ij,...j", qd, M, qd), 1e-13, what="kinetic energy")


@pytest.mark.sample(1)
@pytest.mark.parametrize("varied", [False, True])
@pytest.mark.parametrize("n", [9, 30, 60])
def test_mass_matrix_of_robots_without_zeros(n: int, varied: bool):
    """Whatever frames its kernel was compiled for: those of a long chain are one, and those of a
    short one turned."""
    base = "free" if varied else "fixed"
    model = loaded(generate.odd_chain(n - n // 4 * varied, 1, varied), base=base)
    q, qd, _ = fb.random_state(model, 2, 2)
    units = np.eye(model.nv)[:, None, :] + np.zeros_like(qd)
    columns = np.moveaxis(numbers(model, "mass_product", q, units), 0, -1)
    for M in (fb.kernel(model, "mass_matrix")(q), fb.mass_matrix(model, q)):
        close(M, np.swapaxes(M, -1, -2), 0.0, what="symmetric")
        diagonal = np.sqrt(np.einsum("...ii->...i", M))  # entries of the last links are small
        sizes = diagonal[..., :, None] * diagonal[..., None, :]
        close(M / sizes, columns / sizes, 1e-12, what="columns of inverse dynamics")
        twice_T = 2 * numbers(model, "kinetic_energy", q, qd)
        close(twice_T, np.einsum("...i,...ij,...j", qd, M, qd), 1e-12, what="kinetic energy")


@pytest.mark.sample(1)
@pytest.mark.parametrize("varied", [False, True])
def test_kernels_in_turned_frames(varied: bool):
    """They move alike in other frames of the bodies: as formulas have it in the robot's own."""
    model = loaded(generate.odd_chain(10, 3, varied), base="fixed")
    q, qd, qdd = fb.random_state(model, 4, 2)
    loads = {frame: np.ones((2, 6)) for frame in ("tool", "link6")}
    for name in ("inverse_dynamics", "forward_dynamics", "bias", "mass_matrix"):
        inputs = {"bias": (q, qd), "mass_matrix": (q,)}.get(name, (q, qd, qdd))
        wrenches = loads if len(inputs) == 3 else {}
        kernel = fb.kernel(model, name, wrench_frames=tuple(wrenches))
        expected = numbers(model, name, *inputs, wrenches=wrenches)
        close(kernel(*inputs, *wrenches.values()), expected, 1e-10, what=name)


@pytest.mark.sample(15)
@every_tree
def test_coriolis_matrix(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, _ = state(model, seed)
    C = numbers(model, "coriolis_matrix", q, qd)
    scale = float(abs(numbers(model, "mass_matrix", q)).max())  # of C too, at rates of order 1
    bare = model.replace(gravity=0.0).without("friction", "springs")
    close((C @ qd[..., None])[..., 0], numbers(bare, "bias", q, qd), 1e-12, scale, "C q̇")
    along, _ = path(model, q, qd, 0 * qd, H)
    Md = rate(numbers(model, "mass_matrix", along), H)
    N = Md - 2 * C
    close(N, -np.swapaxes(N, -1, -2), 1e-9, scale, "Ṁ - 2C")


def turns_freely(seed: int, dim: int) -> bool:
    kinds = {joint.kind for joint in generate.tree(seed, dim).joints}
    return bool(kinds & {"spherical", "free"}) or (dim == 3 and generate.base(seed) == "free")


@pytest.mark.sample(14)
@trees([case for case in CASES if not turns_freely(*case)])
def test_coriolis_matrix_is_that_of_christoffel(seed: int, dim: int):
    """Of coordinates whose rates are velocities; the others have no such symbols."""
    model = generate.model(seed, dim)
    q, qd, _ = state(model, seed)
    units = np.eye(model.nv)[:, None, :] + np.zeros_like(qd)
    along, _ = path(model, np.broadcast_to(q, (model.nv, *q.shape)), units, 0 * units, H)
    dM = np.moveaxis(
        rate(numbers(model, "mass_matrix", along), H), 0, -1
    )  # ∂M_ij/∂q_k at (..., i, j, k)
    gamma = 0.5 * (dM + np.swapaxes(dM, -1, -2) - np.moveaxis(dM, -1, -3))
    C = numbers(model, "coriolis_matrix", q, qd)
    scale = float(abs(numbers(model, "mass_matrix", q)).max())
    close(
        C,
        np.einsum("...ijk,...k->...ij", gamma, qd),
        1e-9,
        float(abs(dM).max()) + scale,
        "Christoffel",
    )


# ---------------------------------------------------------------- energy
def friction_power(model: Model, qd: np.ndarray) -> np.ndarray:
    lost = np.zeros(qd.shape[:-1])
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.kind.nv == 1:
            r = at.ratio * qd[..., at.v[0]]
            lost += body.joint.drive.viscous * r**2 + body.joint.drive.coulomb * abs(r)
    return lost


@pytest.mark.sample(9)
@every_tree
def test_power_is_the_rate_of_energy(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    power = (tau * qd).sum(-1) - friction_power(model, qd)
    for name, w in loads.items():
        power += (w * numbers(model, "velocity", q, qd, frame=name)).sum(-1)
    along, rates = path(model, q, qd, qdd, H)
    energy = numbers(model, "kinetic_energy", along, rates) + numbers(
        model, "potential_energy", along
    )
    scale = float(abs(energy).max() + abs(tau * qd).sum(-1).max())
    close(power, rate(energy, H), 1e-9, scale, "power")
    still = (numbers(model, "static_torque", q) * qd).sum(-1)
    close(still, rate(numbers(model, "potential_energy", along), H), 1e-9, scale, "potential")
    field = model.without("springs")
    close(
        (numbers(model, "gravity_torque", q) * qd).sum(-1),
        rate(numbers(field, "potential_energy", along), H),
        1e-9,
        scale,
        "gravity's potential",
    )
    height = numbers(model, "center_of_mass", q) @ model.gravity
    weight = numbers(field, "potential_energy", q)
    close(weight, -model.mass * height, 1e-12, scale, "the weight of all links")


# ---------------------------------------------------------------- kinematics
def vee(W: np.ndarray) -> np.ndarray:
    return np.stack([W[..., 2, 1], W[..., 0, 2], W[..., 1, 0]], axis=-1)


def six(model: Model, linear: np.ndarray, angular: np.ndarray) -> np.ndarray:
    """A twist in the model's own form."""
    if model.dim == 3:
        return np.concatenate([linear, angular], axis=-1)
    return np.concatenate([linear[..., :2], angular[..., 2:]], axis=-1)


def momentum_about(model: Model, h: np.ndarray, point: np.ndarray) -> np.ndarray:
    """The momentum about the origin, taken about a point of the world."""
    p, L = in_space(h, model.dim)
    return six(model, p, L - np.cross(np.append(point, [0.0] * (3 - model.dim)), p))


def velocity_of_point(
    model: Model, frame: str, q: np.ndarray, qd: np.ndarray, point: np.ndarray
) -> np.ndarray:
    """The velocity of a frame, taken at a point that is told in the frame's axes."""
    v, w = in_space(numbers(model, "velocity", q, qd, frame=frame), model.dim)
    arm = poses(model, q)[frame][..., :3, :3] @ np.append(point, [0.0] * (3 - model.dim))
    return six(model, v + np.cross(w, arm), w)


def some_frames(model: Model, seed: int, n: int = 3) -> list[str]:
    rng = np.random.default_rng(seed)
    return ["tool", *(str(name) for name in rng.permutation(np.array(model.frame_names))[:n])]


@pytest.mark.sample(1)
@pytest.mark.usefixtures("numpy_kernels")
@every_tree
def test_velocities_jacobians_and_accelerations_are_derivatives(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    along, rates = path(model, q, qd, qdd, H)
    moving, standing = poses(model, along), poses(model, q)
    point = np.random.default_rng(seed).normal(size=dim)
    for name in some_frames(model, seed):
        T = standing[name]
        close(
            numbers(model, "forward_kinematics", q, frame=name),
            T if dim == 3 else np.delete(np.delete(T, 2, -1), 2, -2),
            1e-15,
            what="pose",
        )
        Td = rate(moving[name], H)
        W = Td[..., :3, :3] @ np.swapaxes(T[..., :3, :3], -1, -2)
        V = numbers(model, "velocity", q, qd, frame=name)
        scale = 1.0 + float(abs(V).max())
        close(V, six(model, Td[..., :3, 3], vee(W)), 1e-9, scale, "velocity")
        arm = T[..., :dim, :dim] @ point
        moved = rate((moving[name][..., :dim, :dim] @ point) + moving[name][..., :dim, 3], H)
        arrived = fb.velocity(model, q, qd, name, point=point)
        close(arrived[..., :dim], moved, 1e-9, scale, "velocity of a point")
        close(arrived[..., dim:], V[..., dim:], 1e-15, what="angular velocity at a point")
        A = numbers(model, "acceleration", q, qd, qdd, frame=name)
        close(
            A,
            rate(numbers(model, "velocity", along, rates, frame=name), H),
            1e-9,
            scale**2 + abs(A).max(),
            "acceleration",
        )
        A_point = fb.acceleration(model, q, qd, qdd, name, point=point)
        V_point = fb.velocity(model, along, rates, name, point=point)
        close(
            A_point,
            rate(V_point, H),
            1e-9,
            scale**2 + abs(A_point).max(),
            f"acceleration of a point, arm {arm.shape}",
        )
        for reference in ("world", "body"):
            J = numbers(model, "jacobian", q, frame=name, reference=reference)
            Jd = numbers(model, "jacobian_dot", q, qd, frame=name, reference=reference)
            size = 1.0 + float(abs(J).max())
            Jt = rate(numbers(model, "jacobian", along, frame=name, reference=reference), H)
            close(Jd, Jt, 1e-9, size * scale, f"J̇ in {reference} axes")
            turned = turn_to(reference, model, T, V)
            close((J @ qd[..., None])[..., 0], turned, 1e-12, scale, f"J q̇ in {reference} axes")
            if reference == "world":
                close(
                    (J @ qdd[..., None] + Jd @ qd[..., None])[..., 0],
                    A,
                    1e-12,
                    scale**2,
                    "J q̈ + J̇ q̇",
                )


def turn_to(reference: str, model: Model, T: np.ndarray, V: np.ndarray) -> np.ndarray:
    if reference == "world":
        return V
    E = np.swapaxes(T[..., :3, :3], -1, -2)
    v, w = in_space(V, model.dim)
    return six(model, (E @ v[..., None])[..., 0], (E @ w[..., None])[..., 0])


# ---------------------------------------------------------------- reactions
@pytest.mark.sample(22)
@every_tree
def test_reactions_balance_every_body(seed: int, dim: int):
    """Newton and Euler for each body about the world's origin, its motion from second differences
    of poses.

    With a = s + R x, the moment of inertial forces is the integral of a × ä; its part about the com
    is the skew part of R Σ R̈ᵀ with Σ the matrix of second moments, so neither angular velocities
    nor any recursion enter.
    """
    description, model = generate.tree(seed, dim), generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    along, _ = path(model, q, qd, qdd, H2)
    moving, standing = poses(model, along), poses(model, q)
    W = numbers(model, "joint_wrenches", q, qd, qdd, wrenches=loads)
    g = np.append(model.gravity, [0.0] * (3 - dim))
    origin = [standing[body.name][..., :3, 3] for body in model.bodies]
    force, moment = in_space(W, dim)
    given = inertias(description)
    mounts = {mount.name: mount for mount in description.mounts}
    assert all(name in standing for name, _, _ in given)
    assert {load.frame for load in description.payloads} <= set(mounts)
    needed_f = np.zeros_like(force)
    needed_n = np.zeros_like(moment)
    scale_f, scale_n = 1.0, 1.0
    for name, inertia, placement in given:
        i = model.frame(name).body
        if i < 0:
            continue
        T = moving[name] @ placed(placement, dim)
        mass, com, second = moments(inertia)
        R, p = T[..., :3, :3], T[..., :3, 3] + T[..., :3, :3] @ com
        pdd, Rdd = second_rate(p, H2), second_rate(R, H2)
        F = mass * (pdd - g)
        D = np.einsum("...ja,ab,...kb->...jk", R[4], second, Rdd)
        N = vee(np.swapaxes(D, -1, -2) - D)
        needed_f[..., i, :] += F
        needed_n[..., i, :] += N + np.cross(p[4], F)
        scale_f = max(scale_f, float(abs(F).max()), mass * float(abs(pdd).max()))
        scale_n = max(scale_n, float(abs(N).max() + abs(np.cross(p[4], F)).max()))
    acting_f, acting_n = force.copy(), moment + np.cross(np.stack(origin, -2), force)
    for k, body in enumerate(model.bodies):
        if body.parent >= 0:
            acting_f[..., body.parent, :] -= force[..., k, :]
            acting_n[..., body.parent, :] -= moment[..., k, :] + np.cross(
                origin[k], force[..., k, :]
            )
    for name, w in loads.items():
        f, n = in_space(w, dim)
        i = model.frame(name).body
        if i >= 0:
            acting_f[..., i, :] += f
            acting_n[..., i, :] += n + np.cross(standing[name][..., :3, 3], f)
    close(acting_f, needed_f, 1e-8, scale_f + float(abs(force).max()), "forces")
    close(acting_n, needed_n, 1e-8, scale_n + float(abs(acting_n).max()), "moments")


def inertias(description: Robot) -> list[tuple[str, Inertia, Placement]]:
    """The frame, inertia and its placement there of each link and load."""
    links = [(x.name, x.inertia, x.placement) for x in description.links if x.inertia is not None]
    return links + [(load.frame, load.inertia, Placement()) for load in description.payloads]


def placed(placement: Placement, dim: int) -> np.ndarray:
    T = np.eye(4)
    S = placement.matrix(dim)
    T[:dim, :dim], T[:dim, 3] = S[:dim, :dim], S[:dim, dim]
    return T


def moments(inertia: Inertia) -> tuple[float, np.ndarray, np.ndarray]:
    """Mass, com and second moments about the com, by hand from the stored entries."""
    if inertia.dim == 2:
        (zz,) = inertia.tensor
        return inertia.mass, np.array([*inertia.com, 0.0]), np.diag([zz / 2, zz / 2, 0.0])
    xx, xy, xz, yy, yz, zz = inertia.tensor
    about = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
    return inertia.mass, np.array(inertia.com), np.trace(about) / 2 * np.eye(3) - about


@pytest.mark.sample(16)
@every_tree
def test_torques_are_reactions_along_the_joints_and_what_drives_add(seed: int, dim: int):
    """S·w + rotor q̈ + friction + spring = tau, S from the description; world and child axes tell
    the same."""
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    W = numbers(model, "joint_wrenches", q, qd, qdd, wrenches=loads)
    child = numbers(model, "joint_wrenches", q, qd, qdd, wrenches=loads, reference="child")
    standing = poses(model, q)
    found = np.zeros_like(tau)
    joints = {joint.name: joint for joint in generate.tree(seed, dim).joints}
    for i, (body, at) in enumerate(zip(model.bodies, model.coordinates, strict=True)):
        root = Joint(body.joint.name, body.joint.kind, "", body.name)
        joint = joints.get(root.name, root)
        f, n = in_space(W[..., i, :], dim)
        R = standing[body.name][..., :3, :3]
        E = np.swapaxes(R, -1, -2)
        f_child, n_child = (E @ f[..., None])[..., 0], (E @ n[..., None])[..., 0]
        close(
            child[..., i, :], six(model, f_child, n_child), 1e-12, float(abs(W).max()), "child axes"
        )
        before = placed(joint.placement, dim)
        if joint.parent:
            before = standing[joint.parent] @ before
        B = before[..., :3, :3]
        if joint.kind == "spherical":
            found[..., at.v] += n_child
        elif joint.kind == "free":
            found[..., at.v] += np.concatenate([f_child, n_child], axis=-1)
        elif joint.kind == "planar":
            found[..., at.v[0]] += (B[..., :, 0] * f).sum(-1)
            found[..., at.v[1]] += (B[..., :, 1] * f).sum(-1)
            found[..., at.v[2]] += (B[..., :, 2] * n).sum(-1)
        elif joint.kind == "universal":
            phi = q[..., at.q[0], None]
            second = np.cos(phi) * B[..., :, 1] + np.sin(phi) * B[..., :, 2]
            found[..., at.v[0]] += (B[..., :, 0] * n).sum(-1)
            found[..., at.v[1]] += (second * n).sum(-1)
        elif joint.kind == "cylindrical":
            axis = B @ (np.array(joint.axis) / np.linalg.norm(joint.axis))
            found[..., at.v[0]] += (axis * n).sum(-1)
            found[..., at.v[1]] += (axis * f).sum(-1)
        else:
            assert len(at.v) == 1, f"what a {joint.kind} joint's torques are is not told here"
            axis = np.array(joint.axis) / np.linalg.norm(joint.axis)
            if dim == 2:
                axis = (
                    np.array([0.0, 0.0, axis[0]])
                    if joint.kind != "prismatic"
                    else np.append(axis, 0.0)
                )
            along = f if joint.kind == "prismatic" else n
            if joint.kind == "helical":
                along = n + joint.numbers[0] * f
            k, drive = at.v[0], joint.drive
            position, r, rr = (
                at.ratio * q[..., at.q[0]] + at.offset,
                at.ratio * qd[..., k],
                at.ratio * qdd[..., k],
            )
            torque = ((B @ axis) * along).sum(-1)
            torque += (
                drive.viscous * r
                + drive.coulomb * np.sign(r)
                + drive.stiffness * (position - drive.rest)
            )
            torque += drive.rotor * drive.gear**2 * rr
            found[..., k] += at.ratio * torque
    close(found, tau, 1e-12, float(abs(W).max()), "along the joints")


@pytest.mark.sample(26)
@every_tree
def test_external_wrenches(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    free = numbers(model, "inverse_dynamics", q, qd, qdd)
    loaded = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    pull = np.zeros_like(free)
    for name, w in loads.items():
        J = numbers(model, "jacobian", q, frame=name)
        pull += (np.swapaxes(J, -1, -2) @ w[..., None])[..., 0]
    scale = float(abs(free).max() + abs(pull).max())
    close(loaded - free, -pull, 1e-12, scale, "-Jᵀ w")
    static = numbers(model, "static_torque", q, wrenches=loads) - numbers(model, "static_torque", q)
    close(static, -pull, 1e-12, scale, "static")


# ---------------------------------------------------------------- momentum
@pytest.mark.sample(10)
@pytest.mark.usefixtures("numpy_kernels")
@every_tree
def test_momentum(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    loads = random_wrenches(model, seed, 3)
    along, rates = path(model, q, qd, qdd, H)
    h = numbers(model, "momentum", q, qd)
    com = numbers(model, "center_of_mass", along)
    scale = 1.0 + float(abs(h).max())
    close(h[..., :dim], model.mass * rate(com, H), 1e-9, scale, "m v_com")
    about = np.random.default_rng(seed).normal(size=dim)
    close(
        fb.momentum(model, q, qd, about),
        momentum_about(model, h, about),
        1e-12,
        scale,
        "about a point",
    )
    # d/dt of it: what the base's joints, gravity and loads do
    W = numbers(model, "joint_wrenches", q, qd, qdd, wrenches=loads)
    standing = poses(model, q)
    force, moment = in_space(W, dim)
    g = np.append(model.gravity, [0.0] * (3 - dim))
    F, N = np.zeros_like(force[..., 0, :]), np.zeros_like(force[..., 0, :])
    for i, body in enumerate(model.bodies):
        if body.parent < 0:
            F += force[..., i, :]
            N += moment[..., i, :] + np.cross(standing[body.name][..., :3, 3], force[..., i, :])
    for name, inertia, placement in inertias(generate.tree(seed, dim)):
        if model.frame(name).body >= 0:
            mass, com, _ = moments(inertia)
            frame = standing[name] @ placed(placement, dim)
            at = frame[..., :3, 3] + frame[..., :3, :3] @ com
            F += mass * g
            N += np.cross(at, mass * g)
    for name, w in loads.items():
        if model.frame(name).body >= 0:
            f, n = in_space(w, dim)
            F += f
            N += n + np.cross(standing[name][..., :3, 3], f)
    hd = rate(numbers(model, "momentum", along, rates), H)
    close(
        six(model, F, N),
        hd,
        1e-9,
        scale + float(abs(hd).max() + abs(moment).max()),
        "rate of momentum",
    )


# ---------------------------------------------------------------- the same robot told otherwise
QUANTITIES = (
    ("inverse_dynamics", 3),
    ("mass_matrix", 1),
    ("coriolis_matrix", 2),
    ("bias", 2),
    ("gravity_torque", 1),
    ("static_torque", 1),
    ("joint_wrenches", 3),
    ("kinetic_energy", 2),
    ("potential_energy", 1),
    ("momentum", 2),
    ("center_of_mass", 1),
    ("forward_kinematics", 1),
    ("velocity", 2),
    ("acceleration", 3),
    ("jacobian", 1),
    ("jacobian_dot", 2),
)


def same(
    a: Model, b: Model, seed: int, but: tuple[str, ...] = (), tolerance: float = 1e-11
) -> None:
    """All quantities agree at random states; the tip is the frame that counts."""
    assert (a.nq, a.nv) == (b.nq, b.nv)
    given = state(a, seed)
    for name, n in QUANTITIES:
        if name not in but:
            expected = numbers(a, name, *given[:n])
            close(numbers(b, name, *given[:n]), expected, tolerance, 1.0, name)


@pytest.mark.sample(4)
@every_other
def test_renaming_changes_nothing(seed: int, dim: int):
    model = generate.model(seed, dim)
    other = loaded(generate.renamed(generate.tree(seed, dim)), base=generate.base(seed))
    same(model, other, seed, tolerance=1e-13)


@pytest.mark.sample(4)
@every_other
def test_order_of_links_changes_nothing(seed: int, dim: int):
    model = generate.model(seed, dim)
    other = loaded(
        generate.reordered_links(generate.tree(seed, dim), seed), base=generate.base(seed)
    )
    assert model.joint_names == other.joint_names
    same(model, other, seed)


@pytest.mark.sample(5)
@every_other
def test_order_of_joints_is_the_files_and_only_permutes(seed: int, dim: int):
    description = generate.tree(seed, dim)
    order = np.random.default_rng(seed).permutation(len(description.joints))
    shuffled = replace(description, joints=tuple(description.joints[i] for i in order))
    model, other = (loaded(d, base=generate.base(seed)) for d in (description, shuffled))
    for d, m in ((description, model), (shuffled, other)):
        in_file = [joint.name for joint in d.joints if joint.kind != "fixed"]
        assert list(m.joint_names) == (
            ["base", *in_file] if generate.base(seed) == "free" else in_file
        )
    q, qd, qdd = state(model, seed)
    to_q = [model.position_names.index(name) for name in other.position_names]
    to_v = [model.velocity_names.index(name) for name in other.velocity_names]
    to_j = [model.joint_names.index(name) for name in other.joint_names]
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    M = numbers(model, "mass_matrix", q)
    W = numbers(model, "joint_wrenches", q, qd, qdd)
    Q, QD, QDD = q[..., to_q], qd[..., to_v], qdd[..., to_v]
    close(numbers(other, "inverse_dynamics", Q, QD, QDD), tau[..., to_v], 1e-12, 1.0, "tau")
    close(numbers(other, "mass_matrix", Q), M[..., to_v, :][..., to_v], 1e-12, 1.0, "M")
    close(numbers(other, "joint_wrenches", Q, QD, QDD), W[..., to_j, :], 1e-11, 1.0, "wrenches")
    qdd_found = numbers(other, "forward_dynamics", Q, QD, tau[..., to_v])
    close(qdd_found, QDD, max(1e-10, 1e3 * EPS * condition(M)), what="forward")


@pytest.mark.sample(3)
@every_other
def test_a_body_in_pieces_is_the_same_body(seed: int, dim: int):
    model = generate.model(seed, dim)
    pieces = loaded(generate.split(generate.tree(seed, dim), seed), base=generate.base(seed))
    assert pieces.joint_names == model.joint_names
    assert pieces.mass == pytest.approx(model.mass, rel=1e-14)
    same(model, pieces, seed)


@pytest.mark.sample(1)
@trees([(seed, 3) for seed in TREES[::2]])
def test_moved_frames_change_only_their_poses(seed: int, dim: int):
    model = generate.model(seed, dim)
    description, moves = generate.moved_frames(generate.tree(seed, dim), seed)
    other = loaded(description, base=generate.base(seed))
    same(
        model, other, seed, but=("joint_wrenches",)
    )  # whose points of reference move along the axes
    q, _, _ = state(model, seed)
    old, new = poses(model, q), poses(other, q)
    for name, move in moves.items():
        close(new[name], old[name] @ move, 1e-12, 1.0, f"pose of {name}")


@pytest.mark.sample(5)
@pytest.mark.parametrize(
    ("seed", "dim"), [(seed, dim) for seed in range(4, 60, 5) for dim in (2, 3)]
)
def test_dynamics_do_not_depend_on_where_a_free_robot_stands(seed: int, dim: int):
    """Not even a thousand kilometres away: no inertia is taken about the world's origin."""
    model = generate.model(seed, dim)
    assert model.joint_names[0] == "base"
    q, qd, qdd = state(model, seed)
    there = q + np.array([1e6] * dim + [0.0] * (model.nq - dim))
    there[..., :dim] = np.round(there[..., :dim], 3)  # a position that floats hold well
    here = there - np.array([1e6] * dim + [0.0] * (model.nq - dim))
    for name, n in QUANTITIES:
        if name in ("potential_energy", "momentum", "center_of_mass", "forward_kinematics"):
            continue
        expected = numbers(model, name, *(here, qd, qdd)[:n])
        allowed = (
            1e-8 if name.startswith("jacobian") else 1e-9
        )  # lever arms are differences of positions
        close(numbers(model, name, *(there, qd, qdd)[:n]), expected, allowed, 1.0, name)


# ---------------------------------------------------------------- mimics
def follow(description: Robot, free: Model, followed: Model) -> tuple[np.ndarray, np.ndarray]:
    """(G, q0) with q = G y + q0 from the joints as described, a mimic of a mimic taken step by
    step."""
    joints = {joint.name: joint for joint in description.joints}
    G = np.zeros((free.nv, followed.nv))
    q0 = np.zeros(free.nv)
    rows = {name: k for k, name in enumerate(free.velocity_names)}
    columns = {name: k for k, name in enumerate(followed.velocity_names)}
    for name, row in rows.items():
        ratio, offset, at = 1.0, 0.0, name
        while at in joints and joints[at].mimic is not None:
            mimic = joints[at].mimic
            offset, ratio, at = offset + ratio * mimic.offset, ratio * mimic.ratio, mimic.joint
        G[row, columns[at]], q0[row] = ratio, offset
    return G, q0


MIMICS = [c for c in CASES if any(joint.mimic for joint in generate.tree(*c).joints)]


def spread(
    free: Model, followed: Model, G: np.ndarray, q0: np.ndarray, y: np.ndarray
) -> np.ndarray:
    """q = G y + q0 where some coordinates are quaternions, which no joint mimics."""
    q = np.empty((*y.shape[:-1], free.nq))
    at = {name: k for k, name in enumerate(followed.position_names)}
    for k, name in enumerate(free.position_names):
        if name in at:
            q[..., k] = y[..., at[name]]
        else:
            row = free.velocity_names.index(name)
            (leader,) = np.flatnonzero(G[row])
            q[..., k] = G[row, leader] * y[..., at[followed.velocity_names[leader]]] + q0[row]
    return q


@pytest.mark.sample(5)
@trees(MIMICS)
def test_mimics_followed_are_free_joints_driven_together(seed: int, dim: int):
    description = generate.tree(seed, dim)
    followed, free = (
        generate.model(seed, dim),
        loaded(description, base=generate.base(seed), mimic="free"),
    )
    n = sum(joint.mimic is not None for joint in description.joints)
    assert (free.nv, free.joint_names) == (followed.nv + n, followed.joint_names)
    G, q0 = follow(description, free, followed)
    y, yd, ydd = state(followed, seed)
    q, qd, qdd = spread(free, followed, G, q0, y), yd @ G.T, ydd @ G.T
    tau = numbers(free, "inverse_dynamics", q, qd, qdd)
    close(numbers(followed, "inverse_dynamics", y, yd, ydd), tau @ G, 1e-12, 1.0, "Gᵀ tau")
    M = numbers(free, "mass_matrix", q)
    close(numbers(followed, "mass_matrix", y), G.T @ M @ G, 1e-12, 1.0, "Gᵀ M G")
    J = numbers(free, "jacobian", q)
    close(numbers(followed, "jacobian", y), J @ G, 1e-12, 1.0, "J G")
    W = numbers(free, "joint_wrenches", q, qd, qdd)
    close(numbers(followed, "joint_wrenches", y, yd, ydd), W, 1e-12, 1.0, "wrenches")
    for name in ("kinetic_energy", "momentum"):
        close(numbers(followed, name, y, yd), numbers(free, name, q, qd), 1e-12, 1.0, name)
    close(
        numbers(followed, "potential_energy", y),
        numbers(free, "potential_energy", q),
        1e-12,
        1.0,
        "V",
    )


# ---------------------------------------------------------------- the plane in space
@pytest.mark.sample(5)
@trees([(seed, 2) for seed in FLAT_TREES])
def test_planar_trees_are_their_twins_in_space(seed: int, dim: int):
    flat = generate.model(seed, dim)
    twin = flat.to_space()
    assert (twin.dim, twin.nv, twin.joint_names, twin.frame_names) == (
        3,
        flat.nv,
        flat.joint_names,
        flat.frame_names,
    )
    given = state(flat, seed)
    loads = random_wrenches(flat, seed, 3)
    loads3 = {
        name: np.stack([w[..., 0], w[..., 1], *[0 * w[..., 0]] * 3, w[..., 2]], -1)
        for name, w in loads.items()
    }
    keep = [0, 1, 5]
    for name, n in (*QUANTITIES, ("forward_dynamics", 3)):
        loaded = name in ("inverse_dynamics", "forward_dynamics", "static_torque", "joint_wrenches")
        a = numbers(flat, name, *given[:n], wrenches=loads if loaded else None)
        b = numbers(twin, name, *given[:n], wrenches=loads3 if loaded else None)
        if name == "forward_kinematics":
            assert np.array_equal(
                b[..., 2, :], np.broadcast_to([0.0, 0.0, 1.0, 0.0], b[..., 2, :].shape)
            )
            b = np.delete(np.delete(b, 2, -1), 2, -2)
        elif name in ("velocity", "acceleration", "momentum", "joint_wrenches"):
            close(
                np.delete(b, keep, -1),
                np.zeros_like(np.delete(b, keep, -1)),
                1e-12,
                1.0 + abs(b).max(),
                f"{name} out of the plane",
            )
            b = b[..., keep]
        elif name in ("jacobian", "jacobian_dot"):
            b = b[..., keep, :]
        elif name == "center_of_mass":
            b = b[..., :2]
        close(a, b, 1e-10 if name == "forward_dynamics" else 1e-12, 1.0, name)
    child = numbers(flat, "joint_wrenches", *given, reference="child")
    close(
        child,
        numbers(twin, "joint_wrenches", *given, reference="child")[..., keep],
        1e-12,
        1.0,
        "child axes",
    )
    for name in ("jacobian", "jacobian_dot"):
        a = numbers(flat, name, *given[: 1 + (name != "jacobian")], reference="body")
        b = numbers(twin, name, *given[: 1 + (name != "jacobian")], reference="body")
        close(a, b[..., keep, :], 1e-12, 1.0, f"{name} in body axes")


# ---------------------------------------------------------------- payloads, tools, features
@pytest.mark.sample(1)
@every_other
def test_payloads(seed: int, dim: int):
    description, model = generate.tree(seed, dim), generate.model(seed, dim)
    rng = np.random.default_rng(seed)
    frame = str(rng.choice([body.name for body in model.bodies]))
    same(model, model.with_payload(0.0, frame=frame), seed, tolerance=0.0)
    same(model, model.with_payload(Inertia.nothing(dim), frame="tool"), seed, tolerance=0.0)
    load = generate.random_inertia(rng, dim)
    link = Link("cargo", load)
    joint = Joint("cargo_weld", "fixed", frame, "cargo")
    described = replace(
        description, links=(*description.links, link), joints=(*description.joints, joint)
    )
    other = loaded(described, base=generate.base(seed))
    laden = model.with_payload(load, frame=frame)
    same(other, laden, seed)
    assert laden.mass == pytest.approx(model.mass + load.mass)


@pytest.mark.sample(7)
@every_other
def test_features_are_taken_off_one_by_one(seed: int, dim: int):
    model = generate.model(seed, dim)
    q, qd, qdd = state(model, seed)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd)
    friction, rotors, springs = (np.zeros_like(tau) for _ in range(3))
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.kind.nv != 1:
            continue
        k, drive = at.v[0], body.joint.drive
        friction[..., k] += at.ratio * (
            drive.viscous * at.ratio * qd[..., k] + drive.coulomb * np.sign(at.ratio * qd[..., k])
        )
        rotors[..., k] += at.ratio**2 * drive.rotor * drive.gear**2 * qdd[..., k]
        springs[..., k] += (
            at.ratio * drive.stiffness * (at.ratio * q[..., at.q[0]] + at.offset - drive.rest)
        )
    for features, removed in (
        (("friction",), friction),
        (("rotors",), rotors),
        (("springs",), springs),
        (("friction", "rotors", "springs"), friction + rotors + springs),
    ):
        close(
            numbers(model.without(*features), "inverse_dynamics", q, qd, qdd),
            tau - removed,
            1e-12,
            1.0,
            str(features),
        )
    bare = model.without("friction", "rotors", "springs")
    close(
        numbers(bare, "gravity_torque", q),
        numbers(model, "gravity_torque", q),
        1e-12,
        1.0,
        "gravity alone",
    )
    close(
        numbers(bare, "joint_wrenches", q, qd, qdd),
        numbers(model, "joint_wrenches", q, qd, qdd),
        0.0,
        what="reactions",
    )


def test_tool_is_a_new_tip():
    rng = np.random.default_rng(5)
    model = generate.model(17)
    R, p = generate.random_rotation(rng), rng.normal(size=3)
    load = generate.random_inertia(rng)
    tooled = model.with_tool("gripper", p, R, inertia=load)
    assert (tooled.tip, model.tip) == ("gripper", "tool")
    q, qd, qdd = state(model, 1)
    T = np.eye(4)
    T[:3, :3], T[:3, 3] = R, p
    close(
        numbers(tooled, "forward_kinematics", q), numbers(model, "forward_kinematics", q) @ T, 1e-14
    )
    carried = model.with_payload(load.placed(R, p), frame="tool")
    close(
        numbers(tooled, "inverse_dynamics", q, qd, qdd),
        numbers(carried, "inverse_dynamics", q, qd, qdd),
        1e-13,
    )


def test_lumped_mass_is_the_combined_inertia():
    """All links welded together: one body, whose inertia is that of the set."""
    rng = np.random.default_rng(3)
    links, joints, parts = [Link("base")], [], []
    pose = {"base": np.eye(4)}
    for i in range(6):
        parent = "base" if i == 0 else f"l{rng.integers(i)}"
        placement = Placement() if i == 0 else generate.random_placement(rng, general=True)
        links.append(Link(f"l{i}", generate.random_inertia(rng)))
        joints.append(Joint(f"j{i}", "free" if i == 0 else "fixed", parent, f"l{i}", placement))
        pose[f"l{i}"] = pose[parent] @ placement.matrix()
        parts.append(links[-1].inertia.placed(pose[f"l{i}"][:3, :3], pose[f"l{i}"][:3, 3]))
    model = loaded(Robot("welded", 3, tuple(links), tuple(joints), (0.0, (0.0, 0.0, -1.0))))
    whole = sum(parts[1:], parts[0])
    m, c, tensor = whole.numbers()
    S = np.array([[0, -c[2], c[1]], [c[2], 0, -c[0]], [-c[1], c[0], 0]])
    M = np.block([[m * np.eye(3), -m * S], [m * S, tensor - m * S @ S]])
    close(numbers(model, "mass_matrix", fb.neutral(model)), M, 1e-13)
    assert model.mass == pytest.approx(sum(p.mass for p in parts))
    shifted = shift(*(float(x) for x in c)).then(rotate(np.eye(3)))
    assert shifted.matrix()[:3, 3] == pytest.approx(c)


# ---------------------------------------------------------------- compiled kernels
KERNELS = [(3, 3), (4, 3), (29, 3), (41, 3), (7, 2), (24, 2)]


def test_kernels_of_every_joint_kind_are_compared():
    bodies = [body for seed, dim in KERNELS for body in generate.model(seed, dim).bodies]
    assert {body.joint.kind for body in bodies} == set(generate.MOVING)
    assert any(body.joint.mimic for body in bodies)


@pytest.mark.sample(1)
@pytest.mark.parametrize(("seed", "dim"), KERNELS, ids=[f"{dim}D-{seed}" for seed, dim in KERNELS])
def test_kernels_compute_the_same_as_plain_arrays(seed: int, dim: int):
    model = generate.model(seed, dim)
    kernels_agree(model, seed, 1e-12)


@pytest.mark.long
@every_tree
def test_kernels_compute_the_same_as_plain_arrays_on_every_tree(seed: int, dim: int):
    kernels_agree(generate.model(seed, dim), seed, 1e-12)


def kernels_agree(model: Model, seed: int, tolerance: float) -> None:
    """Public functions against the formulas on plain arrays."""
    q, qd, qdd = state(model, seed, 11)
    loads = random_wrenches(model, seed, 11, 2)
    tau = numbers(model, "inverse_dynamics", q, qd, qdd, wrenches=loads)
    close(fb.inverse_dynamics(model, q, qd, qdd, loads), tau, tolerance, what="inverse")
    M = numbers(model, "mass_matrix", q)
    allowed = max(1e-10, 1e3 * EPS * condition(M))
    try:
        close(fb.forward_dynamics(model, q, qd, tau, loads), qdd, allowed, what="forward")
    except SingularError as refused:
        raise AssertionError("a regular M was refused") from refused
    close(fb.mass_matrix(model, q), M, tolerance, what="M")
    close(
        fb.coriolis_matrix(model, q, qd),
        numbers(model, "coriolis_matrix", q, qd),
        tolerance,
        1.0,
        "C",
    )
    close(fb.bias(model, q, qd), numbers(model, "bias", q, qd), tolerance, what="bias")
    close(fb.gravity_torque(model, q), numbers(model, "gravity_torque", q), tolerance, 1.0, "g")
    close(
        fb.static_torque(model, q, loads),
        numbers(model, "static_torque", q, wrenches=loads),
        tolerance,
        1.0,
        "static",
    )
    for reference in ("world", "child"):
        W = numbers(model, "joint_wrenches", q, qd, qdd, wrenches=loads, reference=reference)
        close(fb.joint_wrenches(model, q, qd, qdd, loads, reference), W, tolerance, what="wrenches")
    close(
        fb.kinetic_energy(model, q, qd),
        numbers(model, "kinetic_energy", q, qd),
        tolerance,
        what="T",
    )
    close(fb.potential_energy(model, q), numbers(model, "potential_energy", q), tolerance, 1.0, "V")
    close(fb.momentum(model, q, qd), numbers(model, "momentum", q, qd), tolerance, 1.0, "momentum")
    point = np.arange(1.0, 1 + model.dim)
    close(
        fb.momentum(model, q, qd, point),
        momentum_about(model, numbers(model, "momentum", q, qd), point),
        tolerance,
        1.0,
        "momentum",
    )
    close(fb.center_of_mass(model, q), numbers(model, "center_of_mass", q), tolerance, 1.0, "com")
    for frame in ("tool", "ground", model.bodies[0].name):
        at = {"frame": frame}
        close(
            fb.forward_kinematics(model, q, frame),
            numbers(model, "forward_kinematics", q, **at),
            tolerance,
            what="pose",
        )
        close(
            fb.velocity(model, q, qd, frame),
            numbers(model, "velocity", q, qd, **at),
            tolerance,
            1.0,
            "velocity",
        )
        close(
            fb.velocity(model, q, qd, frame, point=point),
            velocity_of_point(model, frame, q, qd, point),
            tolerance,
            1.0,
            "velocity of a point",
        )
        A = numbers(model, "acceleration", q, qd, qdd, **at)
        close(fb.acceleration(model, q, qd, qdd, frame), A, tolerance, 1.0, "acceleration")
        for reference in ("world", "body"):
            J = numbers(model, "jacobian", q, reference=reference, **at)
            close(fb.jacobian(model, q, frame, reference), J, tolerance, 1.0, "J")
            Jd = numbers(model, "jacobian_dot", q, qd, reference=reference, **at)
            close(fb.jacobian_dot(model, q, qd, frame, reference), Jd, tolerance, 1.0, "J̇")
