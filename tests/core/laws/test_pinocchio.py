"""Every URDF file of example-robot-data beside Pinocchio, on a fixed and on a free base.

By the formulas on plain arrays; a dozen robots by compiled kernels too, and all of them in the long
run. Joints are paired by name: Pinocchio sorts children, and keeps a continuous joint as (cos, sin)
and quaternions as xyzw. What it leaves out of a file (friction) is read here with the standard
library's parser.
"""

from __future__ import annotations

import re
from xml.etree import ElementTree

import numpy as np
import pytest

import freebody as fb
from support import generate
from support.helpers import close, numbers, poses
from support.pinocchio_twin import (
    BASES,
    DOZEN,
    EPS,
    LOADED,
    SINGULAR,
    dry,
    every_robot,
    pair,
    pin,
    relative,
    state,
    symmetric,
)
from support.real_files import FILES, REFUSED, ROBOTS
from support.robots import loaded


# ---------------------------------------------------------------- every file
def test_the_files_are_here():
    assert len(FILES) > 60
    assert set(DOZEN) <= set(FILES)


def test_files_that_are_refused():
    """Exactly these, and for this reason."""
    refused = {}
    for name in FILES:
        try:
            fb.load(str(ROBOTS / name), physical="ignore")
        except fb.FreebodyError as error:
            refused[name] = str(error)
    assert refused.keys() == REFUSED.keys()
    for name, reason in REFUSED.items():
        assert re.search(
            rf"{re.escape(name)}:\d+: {re.escape(reason)}", refused[name].replace("\\", "/")
        )
    # what Pinocchio itself cannot read, and what it reads only because it drops the mimics
    with pytest.raises(ValueError, match="does not contain a valid URDF"):
        pin.buildModelFromUrdf(str(ROBOTS / "ur_description/urdf/ur3.urdf"))


@pytest.mark.sample(10)
@every_robot
def test_dynamics(name: str, base: str):
    model, theirs = pair(name, base)
    if model.nv == 0:
        assert model.joint_names == ()
        return
    q, qd, qdd = state(model, name)
    bare = dry(model)
    relative(
        numbers(bare, "inverse_dynamics", q, qd, qdd),
        theirs.of(pin.rnea, q, qd, qdd),
        "inverse dynamics",
    )
    M = numbers(model, "mass_matrix", q)
    relative(M, np.array([symmetric(m) for m in theirs.of(pin.crba, q)]), "mass matrix")
    relative(numbers(bare, "bias", q, qd), theirs.of(pin.nonLinearEffects, q, qd), "bias")
    relative(
        numbers(model, "gravity_torque", q), theirs.of(pin.computeGeneralizedGravity, q), "gravity"
    )
    energies = (pin.computeKineticEnergy, lambda m, d, q, v: pin.computePotentialEnergy(m, d, q))
    for quantity, compute in zip(("kinetic_energy", "potential_energy"), energies, strict=True):
        expected = [
            compute(theirs.model, theirs.data, theirs.q(a), theirs.rates(b))
            for a, b in zip(q, qd, strict=True)
        ]
        found = numbers(bare, quantity, *((q, qd) if quantity == "kinetic_energy" else (q,)))
        if quantity == "potential_energy":
            # Pinocchio leaves out what is fixed to the base
            base = theirs.model.inertias[0]
            found += base.mass * theirs.model.gravity.linear @ base.lever
        relative(found, np.array(expected), quantity)


def test_a_long_chain_without_zeros():
    ours, theirs = loaded(generate.odd_chain(30, 5)), pin.Model()
    for i, body in enumerate(ours.tree.bodies):
        (mass,) = body.masses
        turning = pin.JointModelRevoluteUnaligned(np.array(body.axis))
        at = theirs.addJoint(i, turning, pin.SE3(np.array(body.R), np.array(body.p)), body.name)
        inertia = pin.Inertia(mass.m, np.array(mass.c), np.array(mass.inertia))
        theirs.appendBodyToJoint(at, inertia, pin.SE3.Identity())
    theirs.gravity.linear = np.array(ours.gravity)
    data, (q, qd, qdd) = theirs.createData(), fb.random_state(ours, 5)
    M = symmetric(pin.crba(theirs, data, q))
    tau = pin.rnea(theirs, data, q, qd, qdd)
    for given in (fb.kernel(ours, "mass_matrix")(q), fb.mass_matrix(ours, q)):
        relative(given, M, "mass matrix", 1e-12)
    relative(fb.kernel(ours, "inverse_dynamics")(q, qd, qdd), tau, "inverse dynamics", 1e-12)
    found = fb.kernel(ours, "forward_dynamics")(q, qd, tau)
    relative(found, pin.aba(theirs, data, q, qd, tau), "forward dynamics")


def dynamics_of(name: str) -> dict[str, tuple[float, float]]:
    """Damping and friction of each joint, as the file has it."""
    root = ElementTree.parse(ROBOTS / name).getroot()
    return {
        joint.get("name", ""): (float(tag.get("damping", 0)), float(tag.get("friction", 0)))
        for joint in root.findall("joint")
        for tag in joint.findall("dynamics")
    }


@pytest.mark.sample(10)
@every_robot
def test_friction_is_counted(name: str, base: str):
    model, theirs = pair(name, base)
    given = dynamics_of(name)
    q, qd, qdd = state(model, name)
    damping, coulomb = np.zeros(model.nv), np.zeros(model.nv)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        if body.joint.name in given:
            damping[at.v[0]], coulomb[at.v[0]] = given[body.joint.name]
    if model.nv:
        expected = theirs.of(pin.rnea, q, qd, qdd) + damping * qd + coulomb * np.sign(qd)
        relative(numbers(model, "inverse_dynamics", q, qd, qdd), expected, "with friction")


def test_some_files_have_friction():
    assert sum(any(d or f for d, f in dynamics_of(name).values()) for name in LOADED) > 20


@pytest.mark.sample(5)
@every_robot
def test_frames(name: str, base: str):
    frames(name, base, most=3)


@pytest.mark.long
@every_robot
def test_all_frames(name: str, base: str):
    frames(name, base, most=1000)


def frames(name: str, base: str, most: int) -> None:
    """Placements of all frames; Jacobians, velocities and accelerations of some."""
    model, theirs = pair(name, base)
    q, qd, qdd = state(model, name) if model.nv else (np.zeros((1, 0)),) * 3
    ids = {f.name: i for i, f in enumerate(theirs.model.frames) if f.type == pin.FrameType.BODY}
    # two frames of Pinocchio may share a name, a link of that name being found by its type
    assert set(ids) == set(model.frame_names)
    found = poses(model, q)
    for k in range(len(q)):
        pin.framesForwardKinematics(theirs.model, theirs.data, theirs.q(q[k]))
        for frame, i in ids.items():
            close(found[frame][k], theirs.data.oMf[i].homogeneous, 1e-10, what=frame)
    if model.nv == 0:  # Pinocchio's Jacobians crash
        return
    rng = np.random.default_rng(len(ids))
    some = list(rng.permutation(np.array(sorted(ids))))[:most]
    for frame in {*some, *model.leaves[:2]}:
        i = ids[str(frame)]
        v, a, J, Jb = [], [], [], []
        for k in range(len(q)):
            x = theirs.q(q[k])
            pin.computeJointJacobians(theirs.model, theirs.data, x)
            pin.updateFramePlacements(theirs.model, theirs.data)
            at = (theirs.model, theirs.data, i)
            J.append(pin.getFrameJacobian(*at, pin.LOCAL_WORLD_ALIGNED)[:, theirs.v])
            Jb.append(pin.getFrameJacobian(*at, pin.LOCAL)[:, theirs.v])
            pin.forwardKinematics(
                theirs.model, theirs.data, x, theirs.rates(qd[k]), theirs.rates(qdd[k])
            )
            pin.updateFramePlacements(theirs.model, theirs.data)
            v.append(pin.getFrameVelocity(*at, pin.LOCAL_WORLD_ALIGNED).vector)
            a.append(pin.getFrameClassicalAcceleration(*at, pin.LOCAL_WORLD_ALIGNED).vector)
        here = {"frame": str(frame)}
        relative(numbers(model, "jacobian", q, **here), np.array(J), f"J of {frame}")
        relative(
            numbers(model, "jacobian", q, reference="body", **here),
            np.array(Jb),
            f"J of {frame}, body axes",
        )
        relative(numbers(model, "velocity", q, qd, **here), np.array(v), f"velocity of {frame}")
        relative(
            numbers(model, "acceleration", q, qd, qdd, **here),
            np.array(a),
            f"acceleration of {frame}",
        )


@pytest.mark.sample(3)
@pytest.mark.parametrize("name", LOADED)
def test_mass_and_momentum_on_a_free_base(name: str):
    """On a fixed base Pinocchio forgets the root link's mass."""
    model, theirs = pair(name, "free")
    assert model.mass == pytest.approx(pin.computeTotalMass(theirs.model), rel=1e-12)
    q, qd, _ = state(model, name)
    com, h = [], []
    for k in range(len(q)):
        com.append(pin.centerOfMass(theirs.model, theirs.data, theirs.q(q[k])).copy())
        h.append(
            pin.computeCentroidalMomentum(
                theirs.model, theirs.data, theirs.q(q[k]), theirs.rates(qd[k])
            ).vector
        )
    relative(numbers(model, "center_of_mass", q), np.array(com), "centre of mass")
    relative(fb.momentum(model, q, qd, com), np.array(h), "momentum about it")


@pytest.mark.sample(12)
@pytest.mark.parametrize("name", LOADED)
def test_coriolis_matrix_on_a_fixed_base(name: str):
    model, theirs = pair(name, "fixed")
    if model.nv:
        q, qd, _ = state(model, name)
        relative(
            numbers(model, "coriolis_matrix", q, qd),
            theirs.of(pin.computeCoriolisMatrix, q, qd),
            "C",
        )


# ---------------------------------------------------------------- forward dynamics
@pytest.mark.sample(21)
@every_robot
def test_forward_dynamics(name: str, base: str):
    model, theirs = pair(name, base)
    if model.nv == 0:
        return
    q, qd, tau = state(model, name)
    M = numbers(model, "mass_matrix", q)
    cond = max(np.linalg.cond(m) for m in M)
    if name in SINGULAR:
        assert not cond < 1e14
        idle = [
            model.velocity_names[k]
            for k in np.flatnonzero(~theirs.of(pin.crba, q)[0].diagonal().astype(bool))
        ]
        assert set(SINGULAR[name]) <= set(idle)
        with pytest.raises(fb.FreebodyError) as refusal:
            fb.forward_dynamics(model, q, qd, tau)
        text = str(refusal.value)
        assert text.startswith(
            f"forward_dynamics: the mass matrix of {model.name!r} is singular: joint"
        )
        *others, last = map(repr, idle)
        names = f"{', '.join(others)} and {last}" if others else last
        assert f" {names} move{'' if others else 's'} no inertia." in text
        return
    qdd = numbers(dry(model), "forward_dynamics", q, qd, tau)
    expected = theirs.of(pin.aba, q, qd, tau)
    relative(qdd, expected, "forward dynamics", max(1e-10, 1e3 * EPS * cond))


"""Files with fingers of no mass: joints that move nothing."""


# ---------------------------------------------------------------- what else `load` does
@pytest.mark.sample(9)
@pytest.mark.parametrize("name", [name for name in LOADED if name not in REFUSED])
def test_default_snapping_moves_things_by_the_angles_changed(name: str):
    exact, _ = pair(name, "fixed")
    snapped = fb.load(str(ROBOTS / name), mimic="free", physical="ignore")
    told = [str(notice) for notice in snapped.notices if notice.kind == "snapped"]
    assert not [n for n in exact.notices if n.kind == "snapped"]
    if exact.nv == 0:
        return
    q, qd, qdd = state(exact, name)
    changed = 0.0
    if told:
        (text,) = told
        count, largest = re.search(
            r": (\d+) angles? .* largest change ([0-9.e+-]+) rad", text
        ).groups()
        assert 0 < float(largest) <= 3.05e-9
        changed = int(count) * float(largest)
    # each changed angle turns what is behind it, and a torque by at most that angle times the
    # moments there
    W = numbers(exact, "joint_wrenches", q, qd, qdd)
    A, B = poses(exact, q), poses(snapped, q)
    reach = 1.0 + max(float(np.abs(T[..., :3, 3]).max()) for T in A.values())
    moments = float(np.abs(W).max()) * reach
    a, b = (numbers(m, "inverse_dynamics", q, qd, qdd) for m in (exact, snapped))
    assert np.abs(a - b).max() <= 1.05 * changed * moments + 1e-14 * np.abs(a).max()
    assert max(float(np.abs(A[f] - B[f]).max()) for f in A) <= 1.05 * changed * reach + 1e-14


def mimics(name: str) -> dict[str, tuple[str, float, float]]:
    """{follower: (leader, multiplier, offset)} as the file has it, for joints that move."""
    root = ElementTree.parse(ROBOTS / name).getroot()
    return {
        joint.get("name", ""): (
            tag.get("joint", ""),
            float(tag.get("multiplier", 1)),
            float(tag.get("offset", 0)),
        )
        for joint in root.findall("joint")
        if joint.get("type") != "fixed"
        for tag in joint.findall("mimic")
    }


FOLLOWING = [name for name in LOADED if name not in REFUSED and mimics(name)]


@pytest.mark.sample(6)
@pytest.mark.parametrize("base", BASES)
@pytest.mark.parametrize("name", FOLLOWING)
def test_mimics_followed(name: str, base: str):
    """q = G y + q0, tau_y = Gᵀ tau(G y + q0, G ẏ, G ÿ), with Pinocchio's tau of the joints set
    free."""
    free, theirs = pair(name, base)
    model = fb.load(str(ROBOTS / name), base=base, snap_angles=0, physical="ignore")
    follows = mimics(name)
    assert model.nv == free.nv - len(follows)
    row = {joint: k for k, joint in enumerate(free.velocity_names)}
    G, q0 = np.zeros((free.nv, model.nv)), np.zeros(free.nv)
    for joint, k in row.items():
        ratio, offset, leader = 1.0, 0.0, joint
        while leader in follows:
            leader, multiplier, added = follows[leader]
            ratio, offset = ratio * multiplier, offset + ratio * added
        G[k, model.velocity_names.index(leader)], q0[k] = ratio, offset
    y, yd, ydd = state(model, name)
    shift = free.nq - free.nv  # of q behind the base's quaternion
    q = (
        np.concatenate([y[:, : 6 + shift], y[:, 6 + shift :] @ G[6:, 6:].T + q0[6:]], axis=-1)
        if shift
        else y @ G.T + q0
    )
    tau = theirs.of(pin.rnea, q, yd @ G.T, ydd @ G.T) @ G
    relative(numbers(dry(model), "inverse_dynamics", y, yd, ydd), tau, "Gᵀ tau")
    M = np.array([G.T @ symmetric(m) @ G for m in theirs.of(pin.crba, q)])
    relative(numbers(dry(model), "mass_matrix", y), M, "Gᵀ M G")
    assert model.joint_names == free.joint_names


def test_some_files_have_mimics():
    assert len(FOLLOWING) == 8
    assert fb.load(str(ROBOTS / DOZEN[1]), physical="ignore").nv == 8
    assert pair(DOZEN[1], "fixed")[0].nv == 9


# ---------------------------------------------------------------- compiled kernels
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", DOZEN)
def test_kernels(name: str):
    kernels(
        name,
        "fixed",
        ("mass_matrix", "bias", "inverse_dynamics", "forward_dynamics", "gravity_torque"),
    )


@pytest.mark.long
@every_robot
def test_all_kernels(name: str, base: str):
    kernels(
        name,
        base,
        (
            "mass_matrix",
            "bias",
            "inverse_dynamics",
            "forward_dynamics",
            "gravity_torque",
            "coriolis_matrix",
        ),
    )


def kernels(name: str, base: str, quantities: tuple[str, ...]) -> None:
    """The public functions against Pinocchio, in a batch with a tail."""
    model, theirs = pair(name, base)
    if model.nv == 0:
        return
    q, qd, qdd = state(model, name, 11)
    bare = dry(model)
    M = np.array([symmetric(m) for m in theirs.of(pin.crba, q)])
    for quantity in quantities:
        if quantity == "mass_matrix":
            relative(fb.mass_matrix(bare, q), M, quantity)
        elif quantity == "bias":
            relative(fb.bias(bare, q, qd), theirs.of(pin.nonLinearEffects, q, qd), quantity)
        elif quantity == "inverse_dynamics":
            relative(
                fb.inverse_dynamics(bare, q, qd, qdd), theirs.of(pin.rnea, q, qd, qdd), quantity
            )
        elif quantity == "gravity_torque":
            relative(
                fb.gravity_torque(bare, q), theirs.of(pin.computeGeneralizedGravity, q), quantity
            )
        elif quantity == "coriolis_matrix" and base == "fixed":
            relative(
                fb.coriolis_matrix(bare, q, qd),
                theirs.of(pin.computeCoriolisMatrix, q, qd),
                quantity,
            )
        elif quantity == "forward_dynamics" and name not in SINGULAR:
            allowed = max(1e-10, 1e3 * EPS * max(np.linalg.cond(m) for m in M))
            relative(
                fb.forward_dynamics(bare, q, qd, qdd),
                theirs.of(pin.aba, q, qd, qdd),
                quantity,
                allowed,
            )
    leaf = model.leaves[0]
    i = theirs.model.getFrameId(leaf, pin.FrameType.BODY)
    T, J = [], []
    for x in q:
        pin.computeJointJacobians(theirs.model, theirs.data, theirs.q(x))
        pin.updateFramePlacements(theirs.model, theirs.data)
        T.append(theirs.data.oMf[i].homogeneous.copy())
        J.append(
            pin.getFrameJacobian(theirs.model, theirs.data, i, pin.LOCAL_WORLD_ALIGNED)[:, theirs.v]
        )
    relative(fb.forward_kinematics(bare, q, leaf), np.array(T), "placement")
    relative(fb.jacobian(bare, q, leaf), np.array(J), "Jacobian")
