"""Public results for closed chains: the double four-bar, Bricard's loop, and a Stewart platform by
Newton and Euler."""

from __future__ import annotations

import time
from dataclasses import dataclass

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import freebody as fb
from freebody import SingularError
from support.double_four_bar import TIP, cranks
from support.helpers import close, poses

G = 9.81


# ---------------------------------------------------------------- double four-bar
def test_double_four_bar_at_rest():
    model = fb.load("double_four_bar")
    q, qd = cranks(np.pi / 3)
    qdd = fb.forward_dynamics(model, q, qd, qd)
    close(qdd[[0, 2, 4]], np.full(3, -5.7225), 1e-14)
    for theta in (0.01, 0.4, 1.3, 2.5, 4.0, 1e-3):
        q, qd = cranks(theta)
        expected = -3.5 * G * np.cos(theta) / 3.0
        close(fb.forward_dynamics(model, q, qd, qd)[[0, 2, 4]], np.full(3, expected), 1e-11, 1.0)


def test_double_four_bar_to_its_tenth_second():
    """From upright, the tip at 1 m/s: through the stretched position ten times, where the loops
    lose rank by two."""
    model = fb.load("double_four_bar")
    q, qd = cranks(np.pi / 2, -1.0)
    fb.simulate(model, q, qd, [0.0, 0.1])  # what is compiled once
    start = time.perf_counter()
    motion = fb.simulate(model, q, qd, np.linspace(0.0, 10.0, 101))
    print(f"10 s of the double four-bar in {time.perf_counter() - start:.2f} s")
    for t, tip in TIP.items():
        theta = float(motion.q.sel(time=t)[0])
        assert np.abs(np.array([np.cos(theta), np.sin(theta)]) - tip).max() < 1e-8
    speed = float(motion.qd.sel(time=10.0)[0])
    theta = float(motion.q.sel(time=10.0)[0])
    velocity = speed * np.array([-np.sin(theta), np.cos(theta)])
    assert np.abs(velocity - [1.42305147, -0.49486885]).max() < 1e-7
    energy = motion.kinetic_energy + motion.potential_energy
    assert float(np.abs(energy - energy[0]).max()) < 1e-7  # of 34 J
    assert float(motion.loop_gap.max()) < 1e-12
    assert float(motion.loop_rate.max()) < 1e-11
    sine = np.sin(motion.q.values[:, 0])
    assert sine.min() < -0.9  # it turns and hangs down on the way


@pytest.mark.sample(1)
@pytest.mark.parametrize("speed", [-1.0, -1.02, -1.08, -1.19, -1.31, 0.7])
def test_the_stretched_position_is_passed_without_loss(speed: float):
    """Where a step ends beside it was luck: up to 1e-6 of 34 J were lost."""
    model = fb.load("double_four_bar")
    q, qd = cranks(np.pi / 2, speed)
    motion = fb.simulate(model, q, qd, np.linspace(0.0, 10.0, 11))
    energy = motion.kinetic_energy + motion.potential_energy
    assert float(np.abs(energy - energy[0]).max()) < 2e-8
    exact = solve_ivp(
        lambda t, y: [y[1], -3.5 * G * np.cos(y[0]) / 3.0], [0.0, 10.0], [np.pi / 2, speed],
        method="DOP853", rtol=1e-12, atol=1e-12,
    )  # fmt: skip
    close(motion.q.values[-1, 0], exact.y[0, -1], 2e-8)


@pytest.mark.parametrize("theta", [0.0, np.pi, 1e-9, 1e-7, 1e-5, -1e-4, 1e-3])
def test_double_four_bar_stretched(theta):
    """In and beside the stretched position, where the loops have lost rank, moving: on the branch
    it is on."""
    model = fb.load("double_four_bar")
    assert fb.mobility(model, cranks(0.0)[0]).instantaneous == 3
    assert fb.mobility(model, cranks(0.0)[0]).generic == 1
    q, qd = cranks(theta, 2.0)
    qdd = fb.forward_dynamics(model, q, qd, np.zeros(5))
    expected = -3.5 * G * np.cos(theta) / 3.0 * np.array([1, -1, 1, -1, 1])
    close(qdd, expected, 2e-6 if 0 < abs(theta) < 1e-4 and theta != np.pi else 1e-9)


@pytest.mark.parametrize("theta", [0.0, np.pi])
def test_double_four_bar_from_its_stretched_position(theta):
    model = fb.load("double_four_bar")
    motion = fb.simulate(
        model, *cranks(theta, 3.0), np.linspace(0.0, 4.0, 11)
    )  # and through it again
    energy = (motion.kinetic_energy + motion.potential_energy).values
    assert np.abs(energy - energy[0]).max() < 1e-7
    q = motion.q.values
    close(q[:, [2, 4]], q[:, [0, 0]], 1e-8, 1.0)
    with pytest.raises(SingularError, match="no longer determines how the motion continues"):
        fb.simulate(model, *cranks(theta), [0.0, 1.0])


def test_stretched_and_at_rest_no_way_is_told():
    model = fb.load("double_four_bar")
    q, qd = cranks(0.0)
    with pytest.raises(
        SingularError, match="singular position, where loop 'L1' no longer determines"
    ):
        fb.forward_dynamics(model, q, qd, qd)
    # near it, it falls
    close(
        fb.forward_dynamics(model, *cranks(1e-4), qd)[[0, 2, 4]], np.full(3, -3.5 * G / 3.0), 1e-7
    )


def test_where_the_double_four_bar_is_redundant():
    """In the plane five coordinates and four equations leave its one motion, so none is redundant.
    In space pins hold all that the plane holds by itself: three equations a loop follow from
    others."""
    plane = fb.load("double_four_bar")
    q, _ = cranks(1.0)
    found = fb.mobility(plane, q)
    assert (found.gruebler, found.generic, found.instantaneous, found.equations) == (1, 1, 1, 4)
    assert found.redundant == ()
    space = fb.mobility(plane.to_space(), q)
    assert (space.gruebler, space.generic, space.instantaneous, space.equations) == (-5, 1, 1, 10)
    assert space.redundant == ("L1.fz", "L1.mx", "L1.my", "L2.fz", "L2.mx", "L2.my")
    still = np.zeros(5)
    close(
        fb.forward_dynamics(plane.to_space(), q, still, still),
        fb.forward_dynamics(plane, q, still, still),
        1e-12,
    )


# ---------------------------------------------------------------- Bricard
def test_bricard():
    """By count rigid; it moves, and keeps moving."""
    model = fb.load("bricard")
    q = fb.assemble(model, fb.random_state(model, 3)[0])
    found = fb.mobility(model, q)
    assert (found.gruebler, found.generic, found.instantaneous) == (0, 1, 1)
    assert (found.equations, found.rank) == (5, 4)
    assert len(found.redundant) == 1
    assert found.redundant[0].startswith("joint6.")
    # followed by its own motion over more than a radian, exactly closed as its frames tell
    (free,) = found.independent
    k = model.velocity_names.index(free)
    way = [q]
    for _ in range(60):
        rates = fb.loop_velocity(model, way[-1], {free: 0.02})
        guess = way[-1] + rates
        way.append(fb.assemble(model, guess, free=[n for n in model.velocity_names if n != free]))
    way = np.array(way)
    close(way[-1, k] - way[0, k], 1.2, 1e-12)
    T = poses(model, way)
    A, B = T["last_axis"], T["frame5"]
    assert np.abs(A[:, :3, 3] - B[:, :3, 3]).max() < 1e-11
    assert np.abs(A[:, :3, 2] - B[:, :3, 2]).max() < 1e-11
    for position in way[::12]:
        assert fb.mobility(model, position).generic == 1
    energy_is_kept(model, q, fb.loop_velocity(model, q, {free: 1.0}))


def energy_is_kept(model, q, qd):
    motion = fb.simulate(model, q, qd, np.linspace(0.0, 0.5, 6))
    energy = (motion.kinetic_energy + motion.potential_energy).values
    assert np.abs(energy - energy[0]).max() < 1e-8 * max(1.0, np.abs(energy).max())
    assert float(motion.loop_gap.max()) < 1e-11
    assert float(motion.loop_rate.max()) < 1e-10


def test_bricard_determines_the_moment_about_every_joints_own_axis_in_that_joints_axes():
    """No motor acts, so the moment about each joint's own axis is zero whatever the redundant
    equation carries: in the child's axes that is one component, determined; in the world's axes it
    is a mixture, mostly not."""
    model = fb.load("bricard")
    q = fb.assemble(model, fb.random_state(model, 3)[0])
    qd = fb.loop_velocity(model, q, np.ones(5))
    child, world = (
        fb.reactions(model, q, qd, tau=np.zeros(5), reference=axes) for axes in ("child", "world")
    )
    assert [body.joint.axis for body in model.bodies] == [(0.0, 0.0, 1.0)] * 5
    assert model.loops[0].axis == (0.0, 0.0, 1.0)
    assert child.determined[:, 5].all()
    assert (
        not child.determined[:, :5].all(axis=-1).any()
    )  # one self-stress runs through every joint
    size = float(np.abs(child.wrenches).max())
    close(child.wrenches[:, 5], np.zeros(6), 1e-10, size)
    assert not world.determined.all(axis=-1).any()
    # a batch says what its samples say
    both = fb.reactions(model, [q, q], [qd, 0 * qd], tau=np.zeros((2, 5)), reference="child")
    assert np.array_equal(both.determined[0], child.determined)


# ---------------------------------------------------------------- Stewart platform
@dataclass(frozen=True)
class Leg:
    """A leg d = l e from its base to the platform, by two crossed pins: about x by a, then about y
    by b."""

    s: np.ndarray
    d: np.ndarray
    e: np.ndarray
    lengths: tuple[float, float, float]
    angles: np.ndarray
    """(3, 2): a, b, and their velocities and accelerations."""

    @property
    def turn(self) -> np.ndarray:
        """R = Rx(a) Ry(b)."""
        (a, b), s = self.angles[0], np.sin(self.angles[0])
        ca, cb = np.cos(a), np.cos(b)
        return np.array([[1, 0, 0], [0, ca, -s[0]], [0, s[0], ca]]) @ np.array(
            [[cb, 0, s[1]], [0, 1, 0], [-s[1], 0, cb]]
        )

    @property
    def pins(self) -> tuple[np.ndarray, np.ndarray]:
        return np.array([1.0, 0, 0]), np.array(
            [0.0, np.cos(self.angles[0, 0]), np.sin(self.angles[0, 0])]
        )

    @property
    def spin(self) -> tuple[np.ndarray, np.ndarray]:
        """ω, ω̇."""
        x, y = self.pins
        (ad, bd), (add, bdd) = self.angles[1:]
        return ad * x + bd * y, add * x + bdd * y + ad * bd * np.cross(x, y)


def leg(base, corner, R, p, v, w, a, alpha) -> Leg:
    """Of the platform's pose and motion."""
    s = R @ corner
    d = p + s - base
    dd = v + np.cross(w, s)
    ddd = a + np.cross(alpha, s) + np.cross(w, np.cross(w, s))
    l = np.linalg.norm(d)
    e = d / l
    ld = e @ dd
    ed = (dd - ld * e) / l
    ldd = (dd @ dd + d @ ddd - ld * ld) / l
    edd = (ddd - ldd * e - 2 * ld * ed) / l
    # e = (sin b, -sin a cos b, cos a cos b)
    r2 = e[1] ** 2 + e[2] ** 2
    turning, growth = e[1] * ed[2] - e[2] * ed[1], 2 * (e[1] * ed[1] + e[2] * ed[2])
    ad = turning / r2
    add = (e[1] * edd[2] - e[2] * edd[1]) / r2 - turning * growth / r2**2
    b = np.arcsin(e[0])
    bd = ed[0] / np.cos(b)
    bdd = (edd[0] + np.sin(b) * bd**2) / np.cos(b)
    return Leg(
        s, d, e, (l, ld, ldd), np.array([[np.arctan2(-e[1], e[2]), b], [ad, bd], [add, bdd]])
    )


PLATFORM = (20.0, np.array([0, 0, 0.02]), np.diag([0.9, 0.9, 1.7]))
CYLINDER = (2.5, np.array([0, 0, 0.25]), np.diag([0.052, 0.052, 0.003]))
PISTON = (1.2, np.array([0, 0, -0.2]), np.diag([0.025, 0.025, 0.0004]))
GRAVITY = np.array([0, 0, -G])


def body_load(inertia, R, r, w, alpha, acceleration):
    """What a body needs: force, and moment about the point from which its centre stands at r."""
    m, _, about = inertia
    force = m * (acceleration - GRAVITY)
    world = R @ about @ R.T
    return force, np.cross(r, force) + world @ alpha + np.cross(w, world @ w)


def leg_forces(legs, R, w, a, alpha, load) -> np.ndarray:
    """The six drives' forces by Newton and Euler, under a wrench on the platform at its origin."""
    r = R @ PLATFORM[1]
    acceleration = a + np.cross(alpha, r) + np.cross(w, np.cross(w, r))
    force, moment = body_load(PLATFORM, R, r, w, alpha, acceleration)
    force, moment = force - load[:3], moment - load[3:]
    own = []
    for each in legs:
        Q, (spin, dspin), (l, ld, ldd) = each.turn, each.spin, each.lengths
        r_c, r_p = Q @ CYLINDER[1], Q @ PISTON[1] + each.d
        a_c = np.cross(dspin, r_c) + np.cross(spin, np.cross(spin, r_c))
        a_p = np.cross(dspin, r_p) + np.cross(spin, np.cross(spin, r_p))
        a_p = a_p + 2 * ld * np.cross(spin, each.e) + ldd * each.e
        _, n_c = body_load(CYLINDER, Q, r_c, spin, dspin, a_c)
        f_p, n_p = body_load(PISTON, Q, r_p, spin, dspin, a_p)
        # about the base: the cross passes on a moment across both pins only, the ball on the
        # platform a force
        across = np.cross(*each.pins)
        total = n_c + n_p
        total = total - across * (each.e @ total) / (each.e @ across)
        sideways = np.cross(total, each.e) / l
        force, moment = force + sideways, moment + np.cross(each.s, sideways)
        own.append(each.e @ f_p)
    columns = [np.concatenate([each.e, np.cross(each.s, each.e)]) for each in legs]
    return np.linalg.solve(np.array(columns).T, np.concatenate([force, moment])) + own


@pytest.mark.parametrize("seed", range(6))
def test_stewart_by_newton_and_euler(seed):
    model = fb.load("stewart")
    rng = np.random.default_rng(seed)
    w0 = rng.normal(scale=0.15, size=3)
    K = np.cross(np.eye(3), w0)
    R = np.linalg.solve(np.eye(3) + K, np.eye(3) - K)  # Cayley: a rotation
    p = np.array([0.0, 0.0, 0.9]) + rng.normal(scale=0.08, size=3)
    v, w, a, alpha = rng.normal(scale=1.5, size=(4, 3))
    load = rng.normal(scale=50.0, size=6)
    legs = []
    for k in range(6):
        base = np.array(
            model.tree.bodies[model.tree.body_of[model.joint_names.index(f"swing{k + 1}")]].p
        )
        _, _, corner = model.tree.frames[
            next(f for f in model.loops[k].frames if not f.startswith("piston"))
        ]
        legs.append(leg(base.astype(float), np.array(corner, dtype=float), R, p, v, w, a, alpha))
    assert abs(np.linalg.det(R) - 1) < 1e-12
    q = np.concatenate([p, fb.quat_wxyz(R), *([*x.angles[0], x.lengths[0]] for x in legs)])
    qd = np.concatenate([R.T @ v, R.T @ w, *([*x.angles[1], x.lengths[1]] for x in legs)])
    second = [
        R.T @ (a - np.cross(w, v)),
        R.T @ alpha,
        *([*x.angles[2], x.lengths[2]] for x in legs),
    ]
    qdd = np.concatenate(second)
    drives = [model.velocity_names.index(f"leg{k + 1}") for k in range(6)]
    expected = leg_forces(legs, R, w, a, alpha, load)
    tau = fb.inverse_dynamics(model, q, qd, qdd, {"platform": load})
    close(tau[drives], expected, 1e-9)
    assert not np.delete(tau, drives).any()
    # the legs' own masses are felt
    assert np.abs(expected).max() > 10
    # forwards: the same motion from these forces
    close(fb.forward_dynamics(model, q, qd, tau, {"platform": load}), qdd, 1e-9)
    found = fb.mobility(model, q)
    assert (found.gruebler, found.generic, found.instantaneous, found.redundant) == (6, 6, 6, ())
    io = fb.input_output(model, q)
    close(io.J @ np.array([x.lengths[1] for x in legs]), np.concatenate([v, w]), 1e-9)
