"""Compliant robots whose loops, free bases or large deflections ask for more than a stiffness for
each joint: against motions of the drives, closed forms, and the balance itself."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.optimize import root_scalar

import freebody as fb

pytestmark = pytest.mark.usefixtures("numpy_kernels")

FLOATING = """
name = "two bodies on a shaft"
gravity = 0
[[link]]
name = "world"
[[link]]
name = "hub"
mass = 4
inertia = [0.5, 0, 0, 0.4, 0, 0.3]
[[link]]
name = "panel"
mass = 2
inertia = [0.1, 0, 0, 0.15, 0, 0.2]
[[joint]]
name = "flight"
kind = "free"
parent = "world"
child = "hub"
passive = true
[[joint]]
name = "shaft"
kind = "revolute"
parent = "hub"
child = "panel"
axis = "z"
"""


def closed_at(model: fb.Model, q: np.ndarray, moved: np.ndarray) -> np.ndarray:
    """The closed position near q whose drives have moved so far."""
    at = [model.position_names.index(name) for name in model.driven_names]
    guess = q.copy()
    guess[at] += moved
    passive = [name for name in model.velocity_names if name not in model.driven_names]
    return fb.assemble(model, guess, free=passive)


def slopes(model: fb.Model, q: np.ndarray, h: float = 2e-3) -> np.ndarray:
    """Slopes of the drives' torques at rest by their positions, by differences of fourth order."""
    drives, units = list(model.driven), np.eye(len(model.driven))

    def torque(moved: np.ndarray) -> np.ndarray:
        return fb.static_torque(model, closed_at(model, q, moved))[drives]

    central = [
        np.stack([(torque(k * e) - torque(-k * e)) / (2.0 * k) for e in units], axis=-1)
        for k in (h, h / 2.0)
    ]
    return (4.0 * central[1] - central[0]) / 3.0


@pytest.mark.parametrize(
    ("name", "stiff"), [("five_bar", 8.0), pytest.param("stewart", 200.0, marks=pytest.mark.long)]
)
def test_modes_of_closed_chains_are_those_seen_from_their_drives(name: str, stiff: float):
    """As a system of the drives alone, so soft that weights and forces of loops count."""
    model = fb.load(name).without("friction")
    q = fb.default_motion(model, samples=8).q[3]
    springs = stiff * np.linspace(1.0, 1.5, len(model.driven))
    found = fb.natural_frequencies(model, q, dict(zip(model.driven_names, springs, strict=True)))
    ways = np.stack(
        [fb.loop_velocity(model, q, {x: float(x == one) for x in model.driven_names})
         for one in model.driven_names], axis=-1,
    )  # fmt: skip
    M, K = fb.mass_matrix(model.opened, q), slopes(model, q) + np.diag(springs)
    squares = eigh(0.5 * (K + K.T), ways.T @ M @ ways, eigvals_only=True)
    assert found.squares == pytest.approx(squares, abs=1e-9 * np.abs(squares).max())
    assert np.allclose(found.modes @ M @ found.modes.T, np.eye(len(springs)), atol=1e-12)
    assert np.abs(np.diag(springs) - K).max() > 1e-2 * stiff


def test_a_load_on_two_ropes_swings_as_a_pendulum():
    """ω² = g/l of a load that two parallel cranks carry, which comes from the loop's force alone;
    held by a spring at one crank k/(m l²) more, and no motion where that crank stands."""
    weightless = dict.fromkeys(("m1", "m3", "I1", "I3"), 0.0)
    swing = fb.load("four_bar").bind(l1=0.4, l3=0.4, l2=0.9, d=0.9, m2=2.0, **weightless)
    down = fb.assemble(swing, [-np.pi / 2, np.pi / 2, -np.pi / 2])
    free = fb.natural_frequencies(swing, down, held=())
    assert free.squares == pytest.approx([9.81 / 0.4], rel=1e-9)
    sprung = fb.natural_frequencies(swing, down, 5.0)
    assert sprung.squares == pytest.approx([9.81 / 0.4 + 5.0 / (2.0 * 0.4**2)], rel=1e-9)
    up = fb.assemble(swing, [np.pi / 2, -np.pi / 2, np.pi / 2])
    assert not fb.natural_frequencies(swing, up, held=()).stable
    with pytest.raises(fb.FreebodyError, match="let nothing move"):
        fb.natural_frequencies(swing, down, held=["crank_pin"])
    with pytest.raises(fb.LoopError, match="is open by"):
        fb.natural_frequencies(swing, [0.1, 0.2, 0.3], 5.0)
    loose = swing.replace(actuated=[])
    with pytest.raises(fb.SingularError, match="cannot hold it"):
        fb.natural_frequencies(loose, fb.assemble(loose, [0.3, -0.3, 0.3]), held=())


def test_a_robot_that_floats_and_one_that_hangs():
    """Two bodies on a shaft turn against each other, ω² = k (1/I₁ + 1/I₂); a load on a rope of two
    axes swings with g/l. What nothing holds is refused."""
    free = fb.load(text=FLOATING, format="toml").with_drive("shaft", stiffness=30.0)
    found = fb.natural_frequencies(free, fb.neutral(free), held=())
    assert found.squares[:6] == pytest.approx(np.zeros(6), abs=1e-9)
    assert found.squares[6] == pytest.approx(30.0 * (1.0 / 0.3 + 1.0 / 0.2), rel=1e-12)
    stood = fb.natural_frequencies(free, fb.neutral(free), held=["flight"])
    assert stood.squares == pytest.approx([30.0 / 0.2])
    with pytest.raises(fb.FreebodyError, match=r"does not rest.*flight\.vz"):
        fb.natural_frequencies(free.replace(gravity=9.81), fb.neutral(free), held=())
    with pytest.raises(fb.FreebodyError, match="about which no spring acts"):
        fb.natural_frequencies(free, fb.neutral(free), {"flight.wx": 3.0})
    crane = fb.load("gantry_crane")
    hangs = fb.natural_frequencies(crane, np.zeros(4), held=crane.driven_names)
    assert hangs.squares == pytest.approx([9.81 / 1.5] * 2)


def test_one_number_for_all_drives_and_families():
    arm = fb.load("scara")
    q = fb.random_state(arm, 3, 2)[0]
    one = fb.natural_frequencies(arm, q, 2e4)
    assert np.array_equal(one.squares, fb.natural_frequencies(arm, q, [2e4] * 4).squares)
    assert "is N m/rad of joint1, joint2 and joint4 and N/m of joint3" in one.notices[0]
    bent = fb.deflection(arm, q, stiffness=2e4)
    assert np.array_equal(bent.joints, fb.deflection(arm, q, stiffness=[2e4] * 4).joints)
    assert bent.notices == one.notices
    for slack in (0.0, -1.0, np.nan):
        with pytest.raises(fb.FreebodyError, match="must be numbers above 0"):
            fb.natural_frequencies(arm, q, slack)
    family = arm.with_payload(np.array([0.0, 1.0, 3.0]))
    push = [0.0, 0.0, -20.0, 0.0, 0.0, 0.0]
    modes = fb.natural_frequencies(family, q[:, None], 2e4)
    sinks = fb.deflection(family, q[:, None], push, stiffness=2e4)
    assert modes.modes.shape == (2, 3, 4, 4)
    for k in range(3):
        alone = fb.natural_frequencies(family[k], q, 2e4)
        assert np.array_equal(modes.squares[:, k], alone.squares)
        sunk = fb.deflection(family[k], q, push, stiffness=2e4)
        assert np.array_equal(sinks.displacement[:, k], sunk.displacement)
    with pytest.raises(fb.FreebodyError, match="does not go with a family of shape"):
        fb.natural_frequencies(family, np.zeros((2, 4)), 2e4)


def root(function: Callable[[float], float]) -> float:
    """Between -1 and 0."""
    return float(root_scalar(function, bracket=(-1.0, 0.0), xtol=1e-15).root)


def test_a_soft_arm_yields_until_all_balances():
    """k x = (m g lc + F l) cos x of an arm that lies level, and how far the linear answer is off;
    an arm that stands and whose spring is too soft has no answer."""
    arm = fb.planar("R", l=[2.0], lc=[1.0], m=[3.0], I=[0.1])
    for k, close in ((5e3, 1e-3), (200.0, 0.01)):
        pull = 3.0 * 9.81 * 1.0 + 10.0 * 2.0
        x = root(lambda x, pull=pull, k=k: k * x + pull * np.cos(x))
        found = fb.deflection(arm, [0.0], [0.0, -10.0, 0.0], stiffness=k, iterate=True)
        assert found.joints == pytest.approx([x], abs=1e-11)
        moved = [2.0 * np.cos(x) - 2.0, 2.0 * np.sin(x), x]
        assert found.displacement == pytest.approx(moved, abs=1e-10)
        alone = root(lambda x, k=k: k * x + 3.0 * 9.81 * np.cos(x))
        assert found.by_gravity[2] == pytest.approx(alone, abs=1e-11)
        linear = fb.deflection(arm, [0.0], [0.0, -10.0, 0.0], stiffness=k)
        off = np.hypot(*(linear.displacement - found.displacement)[:2])
        assert found.off == pytest.approx(off, rel=1e-9)
        assert linear.off == pytest.approx(off, rel=close)
    assert "would miss by up to 60.3 mm" in str(found._table().notes)
    stands = fb.deflection(arm, [[np.pi / 2 - 1e-3], [0.0]], stiffness=20.0, iterate=True)
    assert np.isnan(stands.distance).tolist() == [True, False]
    assert "No equilibrium was found near 1 posture" in str(stands._table().notes)


def test_a_closed_chain_yields_until_its_drives_balance():
    robot = fb.load("five_bar").without("friction")
    q = fb.default_motion(robot, samples=8).q[2:5]
    springs, push = np.array([160.0, 220.0]), [4.0, -30.0, 0.0]
    given = dict(zip(robot.driven_names, springs, strict=True))
    found = fb.deflection(robot, q, push, stiffness=given, iterate=True)
    torque = fb.static_torque(robot, q + found.joints, push)
    drives = list(robot.driven)
    assert torque[:, drives] == pytest.approx(-springs * found.joints[:, drives], abs=1e-9)
    moved = fb.forward_kinematics(robot, q + found.joints) - fb.forward_kinematics(robot, q)
    assert found.displacement[:, :2] == pytest.approx(moved[:, :2, 2], abs=1e-12)
    linear = fb.deflection(robot, q, push, stiffness=given)
    assert (linear.off < 0.3 * linear.distance).all()
    assert np.abs(linear.off - found.off).max() < 0.2 * found.off.max()
    tenth = fb.deflection(robot, q, 0.01 * np.array(push), stiffness=given)
    assert np.allclose(tenth.by_wrenches, 0.01 * linear.by_wrenches, atol=1e-15)
