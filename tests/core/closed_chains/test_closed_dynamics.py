"""Closed chains that move: forth and back, virtual work, energy, the tip by the drives, singular
positions."""

from __future__ import annotations

from functools import lru_cache

import numpy as np
import pytest

import freebody as fb
from freebody import Model, SingularError
from support.helpers import FIRST, STEPS, close, numbers
from support.loop_scales import rate_scale

ALL = (
    "four_bar",
    "slider_crank",
    "five_bar",
    "five_bar_rods",
    "double_four_bar",
    "3RRR",
    "stewart",
    "bricard",
)
START = {
    "four_bar": [1.0, -0.6, 1.6],
    "slider_crank": [0.8, -1.0, 0.6],
    "five_bar": {"theta1": 2.0, "B": -1.0, "theta2": 1.0, "D": 1.2},
    "five_bar_rods": {"theta1": 2.0, "theta2": 1.0, "x": 0.0, "y": 0.7},
    "double_four_bar": [1.0, -1.0, 1.0, -1.0, 1.0],
    "3RRR": [0.02, -0.03, 0.1, *np.radians([94.6, -115.3, 214.6, -115.3, -25.4, -115.3])],
    "bricard": [2.0, 0.5, -2.0, 0.5, 2.0],
}


@lru_cache(maxsize=8)
def closed(name: str) -> tuple[Model, np.ndarray, np.ndarray]:
    """The mechanism in motion, from a regular position."""
    model = fb.load(name)
    if name == "stewart":
        q = fb.neutral(model)
        q[2], q[[9, 12, 15, 18, 21, 24]] = 0.9, 1.0
        q = fb.assemble(model, q, free=[n for n in model.joint_names if n != "pose"])
    else:
        q = fb.assemble(model, START[name])
    assert not fb.mobility(model, q).singular
    qd = fb.loop_velocity(model, q, np.random.default_rng(5).normal(size=model.nv))
    return model, q, qd


def driven(model: Model) -> np.ndarray:
    """Mask of the driven coordinates."""
    return np.array([not body.joint.passive for body in model.bodies for _ in range(body.kind.nv)])


def drives(model: Model) -> Model:
    """With as many drives as freedoms, where the file has more, or all."""
    if model.name in ("bricard", "double_four_bar"):
        return model.replace(actuated=[model.joint_names[0]])
    return model


@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name", [pytest.param(x, marks=[pytest.mark.long] * (x == "stewart")) for x in ALL]
)
def test_forth_and_back(name):
    model, q, qd = closed(name)
    model = drives(model)
    tau = np.random.default_rng(1).normal(scale=3.0, size=model.nv) * driven(model)
    load = {model.frame().name: np.random.default_rng(2).normal(size=3 if model.dim == 2 else 6)}
    qdd = fb.forward_dynamics(model, q, qd, tau, load)
    close(fb.inverse_dynamics(model, q, qd, qdd, load), tau, 1e-9, 1.0)
    # any acceleration that the loops allow comes back
    wanted = fb.loop_acceleration(model, q, qd, np.random.default_rng(3).normal(size=model.nv))
    needed = fb.inverse_dynamics(model, q, qd, wanted, load)
    close(fb.forward_dynamics(model, q, qd, needed, load), wanted, 1e-9, 1.0)
    by_torque = fb.reactions(model, q, qd, tau=needed, wrenches=load)
    by_motion = fb.reactions(model, q, qd, qdd=wanted, wrenches=load)
    assert by_torque.balance < 1e-9
    assert by_motion.balance < 1e-9
    close(by_motion.wrenches, by_torque.wrenches, 1e-8)
    close(by_motion.tau, needed, 1e-12, 1.0)


@pytest.mark.sample(2)
@pytest.mark.parametrize("name", ALL)
def test_more_drives_than_freedoms(name):
    """Every joint drives: the same motion, and no torques that do the same are smaller."""
    model, q, qd = closed(name)
    every = model.replace(actuated=model.joint_names)
    wanted = fb.loop_acceleration(model, q, qd, np.random.default_rng(3).normal(size=model.nv))
    tau = fb.inverse_dynamics(every, q, qd, wanted)
    close(fb.forward_dynamics(every, q, qd, tau), wanted, 1e-9, 1.0)
    few = fb.inverse_dynamics(drives(model), q, qd, wanted)
    J = numbers(model, "constraint_jacobian", q)
    assert np.linalg.norm(_weighed(model, tau)) <= np.linalg.norm(_weighed(model, few)) * (1 + 1e-9)
    # what loops do to the joints is orthogonal to the least torques
    rates = rate_scale(model)
    close((J * rates) @ (rates * tau), np.zeros(len(J)), 1e-9, 1.0 + float(np.abs(tau).max()))


def _weighed(model: Model, tau: np.ndarray) -> np.ndarray:
    return rate_scale(model) * tau


@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ["five_bar", "3RRR", "stewart"])
def test_too_few_drives(name):
    model, q, qd = closed(name)
    few = model.actuated[:-1]
    wanted = fb.loop_acceleration(model, q, qd, np.ones(model.nv))
    with pytest.raises(
        SingularError, match=r"cannot force this motion: it can move with these joints locked"
    ):
        fb.inverse_dynamics(model, q, qd, wanted, actuated=few)
    with pytest.raises(SingularError, match=r"static_torque: the driven joints"):
        fb.static_torque(model.replace(actuated=few), q)


@pytest.mark.sample(4)
@pytest.mark.parametrize("name", ALL)
def test_static_torque_by_virtual_work(name):
    """τ · δθ = δV - w · δx in every motion that the loops allow, V and x followed along it."""
    model, q, _ = closed(name)
    model = drives(model)
    w = np.random.default_rng(2).normal(size=3 if model.dim == 2 else 6)
    tau = fb.static_torque(model, q, w)
    assert not tau[~driven(model)].any()
    h = 1e-3
    for seed in range(3):
        way = fb.loop_velocity(model, q, np.random.default_rng(seed).normal(size=model.nv))
        path = fb.assemble(model, fb.integrate(model, q, h * STEPS[:, None] * way))
        slope = FIRST @ fb.potential_energy(model, path) / h
        # assembling may move along the motion by a second order, which an even part leaves out
        virtual = w @ fb.velocity(model, q, way)
        close(tau @ way, slope - virtual, 1e-7, 1.0)
    # and a mechanism so held stays
    still = np.zeros(model.nv)
    close(fb.forward_dynamics(model, q, still, tau, w), still, 1e-9, 1.0)


# ---------------------------------------------------------------- motion
@pytest.mark.sample(1)
@pytest.mark.parametrize("name", ALL)
def test_energy_and_power(name):
    """Free: energy stays. Driven: it grows by the work of the drives. The loops stay closed, to
    rounding."""
    model, q, qd = closed(name)
    t = np.linspace(0.0, 0.5, 501)
    torque = 2.0 * np.random.default_rng(9).normal(size=model.nv) * driven(model)
    for tau in (None, lambda now, q, qd: torque * np.cos(7.0 * now)):
        found = fb.simulate(model, q, qd, t, tau)
        energy = (found.kinetic_energy + found.potential_energy).values
        size = max(1.0, float(np.abs(energy).max()))
        assert float(found.loop_gap.max()) < 1e-10
        assert float(found.loop_rate.max()) < 1e-9
        # work: by the quintic of Newton and Cotes over pieces of six samples
        power = found.power.values.sum(axis=1)
        work = np.concatenate([[0.0], np.cumsum(_pieces(power, t[1] - t[0]))])
        close(energy[::5] - energy[0], work, 1e-6 if tau else 1e-8, size)
        k = 250  # the accelerations that are reported are those of the equations
        state = found.q.values[k], found.qd.values[k]
        close(
            found.qdd.values[k], fb.forward_dynamics(model, *state, found.tau.values[k]), 1e-8, 1.0
        )


def _pieces(x: np.ndarray, h: float) -> np.ndarray:
    weights = 5 * h / 288 * np.array([19, 75, 50, 50, 75, 19])
    return np.array([weights @ x[k : k + 6] for k in range(0, len(x) - 5, 5)])


# ---------------------------------------------------------------- the tip by the drives
@pytest.mark.sample(1)
@pytest.mark.parametrize(
    "name", ["five_bar", "five_bar_rods", "3RRR", "stewart", "four_bar", "slider_crank"]
)
def test_the_tip_moves_with_the_drives(name):
    model, q, _ = closed(name)
    rows = {"four_bar": ["vx"], "slider_crank": ["vx"]}.get(name)
    found = fb.input_output(model, q, rows=rows)
    assert found.kind == "regular"
    names = found.driven
    n = len(names)
    for k in range(n):
        rates = fb.loop_velocity(model, q, {name: float(i == k) for i, name in enumerate(names)})
        tip = fb.velocity(model, q, rates)
        kept = [
            {"vx": 0, "vy": 1, "vz": 2, "wx": 3, "wy": 4, "wz": 5, "w": 2}[row]
            for row in found.rows
        ]
        close(found.J[:, k], tip[kept], 1e-10, 1.0)
        close(found.J_a @ tip[kept] + found.J_b[:, k], np.zeros(n), 1e-12, 1.0)
        # by differences along the closed motion
        h = 1e-3
        path = fb.assemble(
            model,
            fb.integrate(model, q, h * STEPS[:, None] * rates),
            free=[n for n in model.velocity_names if n not in names],
        )
        place = fb.forward_kinematics(model, path)[:, : model.dim, model.dim]
        at = [r for r in range(min(n, model.dim)) if found.rows[r].startswith("v")]
        close(found.J[at, k], (FIRST @ place / h)[[kept[r] for r in at]], 1e-9, 1.0)


def five_bar_at(model: Model, P: np.ndarray, first: float, second: float) -> np.ndarray:
    """q with the tip at P, by the working modes first, second = ±1."""
    p = model.parameters
    q = {}
    for x, l, d, mode, crank, elbow_name in (
        (-p["b"], p["l1"], p["l3"], first, "theta1", "B"),
        (p["b"], p["l2"], p["l4"], second, "theta2", "D"),
    ):
        r = P - [x, 0.0]
        size = np.linalg.norm(r)
        cosine = np.clip((l * l + size * size - d * d) / (2 * l * size), -1.0, 1.0)
        angle = np.arctan2(r[1], r[0]) + mode * np.arccos(cosine)
        elbow = np.array([x + l * np.cos(angle), l * np.sin(angle)])
        q |= {crank: angle, elbow_name: np.arctan2(*(P - elbow)[::-1]) - angle}
    return named(model, q)


def named(model: Model, q: dict[str, float]) -> np.ndarray:
    return np.array([q[name] for name in model.joint_names])


def test_five_bar_modes():
    """Four ways to reach a point, two positions for given cranks."""
    model, q, _ = closed("five_bar")
    P = fb.forward_kinematics(model, q)[:2, 2]
    ways = [five_bar_at(model, P, a, b) for a in (-1, 1) for b in (-1, 1)]
    for way in ways:
        close(fb.forward_kinematics(model, way)[:2, 2], P, 1e-12, 1.0)
        fb.mobility(model, way)  # closed
    modes = fb.assembly_modes(model, q, free=["B", "D"])
    assert len(modes) == 2
    close(modes[0], q, 1e-9)
    # the other is the mirror image in the line through the cranks' ends
    p = model.parameters
    at = dict(zip(model.joint_names, q, strict=True))
    ends = [
        np.array([x + l * np.cos(a), l * np.sin(a)])
        for x, l, a in ((-p["b"], p["l1"], at["theta1"]), (p["b"], p["l2"], at["theta2"]))
    ]
    along = (ends[1] - ends[0]) / np.linalg.norm(ends[1] - ends[0])
    mirrored = ends[0] + 2 * along * (along @ (P - ends[0])) - (P - ends[0])
    close(fb.forward_kinematics(model, modes[1])[:2, 2], mirrored, 1e-9, 1.0)


def test_five_bar_first_type():
    """A crank in line with its distal link: the tip stands at the edge of its workspace, the drives
    may move."""
    model = fb.load("five_bar")
    p = model.parameters
    for reach in (p["l1"] + p["l3"], p["l3"] - p["l1"]):
        P = np.array([-p["b"], 0.0]) + reach * np.array([np.cos(1.1), np.sin(1.1)])
        q = five_bar_at(model, P, 1.0, -1.0)
        found = fb.input_output(model, q)
        assert found.kind == "first"
        assert found.first < 1e-7 < found.second
        # the lost motion is along the links
        motion = fb.velocity(model, q, fb.loop_velocity(model, q, {"theta1": 1.0, "theta2": 0.4}))[
            :2
        ]
        close(motion @ [np.cos(1.1), np.sin(1.1)], 0.0, 1e-7, 1.0)
        assert fb.mobility(model, q).instantaneous == 2


def test_five_bar_second_type():
    """Both distal links in line: cranks that stand still do not hold the tip across them."""
    model = fb.load("five_bar")
    p = model.parameters
    # B and D apart by l3 + l4 = 1.2, level
    half = (p["l3"] + p["l4"]) / 2
    x = half - p["b"]
    angle = np.arccos(x / p["l1"])
    q = named(
        model, {"theta1": np.pi - angle, "B": angle - np.pi, "theta2": angle, "D": np.pi - angle}
    )
    found = fb.input_output(model, q)
    assert found.kind == "second"
    assert found.second < 1e-7 < found.first
    with pytest.raises(fb.FreebodyError, match="singular position of the second type"):
        found.J
    with pytest.raises(SingularError, match="a singular position of the second type"):
        fb.inverse_dynamics(model, q, np.zeros(4), np.zeros(4))
    # forwards there is nothing singular
    qdd = fb.forward_dynamics(model, q, np.zeros(4), np.zeros(4))
    assert np.isfinite(qdd).all()
    tip = fb.acceleration(model, q, np.zeros(4), qdd)
    assert tip[1] < -5.0


def test_five_bar_third_type():
    """All in one line: the tip and the drives move at once without one another."""
    model = fb.load("five_bar").bind(b=0.1, l1=0.5, l2=0.5, l3=0.6, l4=0.6)
    # cranks to the right and left, B and D apart by 1.2 = l3 + l4
    q = named(model, {"theta1": np.pi, "B": -np.pi, "theta2": 0.0, "D": np.pi})
    T = fb.forward_kinematics(model, q)
    close(T[:2, 2], [0.0, 0.0], 1e-12, 1.0)
    found = fb.mobility(model, q)
    assert found.instantaneous == 3
    assert found.singular
    with pytest.raises(fb.FreebodyError, match="but they and the 2 rows move in 3 ways"):
        fb.input_output(model, q)
