"""Inverse velocity (2.25) and acceleration (2.26): what they undo, and what they refuse or damp."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb
from freebody import FreebodyWarning, SingularError
from support.helpers import refused


@pytest.fixture(scope="module")
def two():
    return fb.planar("RR", l=[1.0, 0.7], lc=[0.5, 0.3], m=[1, 1], I=[0.1, 0.1])


def states(model, seed, batch=6):
    return fb.random_state(model, seed, batch)


def test_the_notes_equations(two):
    """θ̇ = J⁻¹ ẋ and θ̈ = J⁻¹ (ẍ - J̇ θ̇) with the notes' J, the rows ẋ and ẏ."""
    q, qd, qdd = states(two, 0)
    J = fb.jacobian(two, q)[:, :2]
    Jd = fb.jacobian_dot(two, q, qd)[:, :2]
    V = (J @ qd[..., None])[..., 0]
    A = (J @ qdd[..., None] + Jd @ qd[..., None])[..., 0]
    assert np.allclose(fb.inverse_velocity(two, q, V), qd, rtol=0, atol=1e-11)
    assert np.allclose(fb.inverse_acceleration(two, q, qd, A), qdd, rtol=0, atol=1e-10)


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("name", "task"),
    [("3R", None), ("scara", ("vx", "vy", "vz", "wz")), ("puma560", None), ("ur5e", "pose")],
)
def test_undoes_velocity_and_acceleration(name, task):
    """Square Jacobians, by the whole velocity or by its rows."""
    model = fb.load(name, physical="ignore")
    q, qd, qdd = states(model, 3)
    V, A = fb.velocity(model, q, qd), fb.acceleration(model, q, qd, qdd)
    assert np.allclose(fb.inverse_velocity(model, q, V, task=task), qd, rtol=0, atol=1e-8)
    assert np.allclose(fb.inverse_acceleration(model, q, qd, A, task=task), qdd, rtol=0, atol=1e-7)
    if task == ("vx", "vy", "vz", "wz"):
        assert np.allclose(
            fb.inverse_velocity(model, q, V[:, [0, 1, 2, 5]], task=task), qd, rtol=0, atol=1e-9
        )


def test_a_redundant_arm_moves_least():
    """Of all rates that give V those of least norm; fingers, which do not move the hand, rest."""
    model = fb.load("panda")
    q, qd, _ = states(model, 1)
    V = fb.velocity(model, q, qd)
    found = fb.inverse_velocity(model, q, V)
    assert np.allclose(fb.velocity(model, q, found), V, rtol=0, atol=1e-10)
    assert (np.linalg.norm(found, axis=-1) <= np.linalg.norm(qd, axis=-1) + 1e-12).all()
    J = fb.jacobian(model, q)
    assert np.allclose(found, (np.linalg.pinv(J, rcond=1e-12) @ V[..., None])[..., 0], atol=1e-9)
    assert (found[:, -1] == 0).all()


def test_batches_broadcast(two):
    q, _, _ = states(two, 0)
    one = fb.inverse_velocity(two, q, [0.1, 0.2])
    assert one.shape == (6, 2)
    assert np.array_equal(fb.inverse_velocity(two, q[0], np.tile([0.1, 0.2], (4, 1)))[3], one[0])
    assert fb.inverse_velocity(two, np.zeros((0, 2)), [0.1, 0.2]).shape == (0, 2)
    assert fb.inverse_velocity(two, {"joint1": 0.1, "joint2": 0.8}, [0.1, 0.2]).shape == (2,)


# ---------------------------------------------------------------- singular
def test_names_the_lost_direction(two):
    """Straight along x: no motion along x. Along the diagonal: none along it, and the sample is
    named."""
    refused(
        "inverse_velocity: the Jacobian is singular: frame 'tip' of 'RR' has lost a degree of "
        "freedom: every motion that the joints can give it satisfies vx = 0. Leave out a row "
        "(task=), or give damping=0.05 for the nearest possible motion.",
        lambda: fb.inverse_velocity(two, [0, 0], [1, 0]),
        SingularError,
    )
    refused(
        "inverse_acceleration: the Jacobian is singular at sample 1: frame 'tip' of 'RR' has lost "
        "a degree of freedom: every motion that the joints can give it satisfies vx + vy = 0. "
        "Leave out a row (task=), or give "
        "damping=0.05 for the nearest possible motion.",
        lambda: fb.inverse_acceleration(two, [[0, 1], [np.pi / 4, np.pi]], [0.1, 0.2], [1, 0]),
        SingularError,
    )
    assert np.allclose(
        fb.velocity(two, [0, 0], fb.inverse_velocity(two, [0, 0], [1.0], task=("vy",)))[1], 1.0
    )


def test_wrist_singularity_is_named():
    """Puma with a straight wrist: what is said of its motions is true of all that its joints can
    give."""
    model = fb.load("puma560", physical="ignore")
    q = np.array([0.0, 0.3, 0.4, 0.0, 0.0, 0.0])
    with pytest.raises(SingularError, match=r"satisfies vy - 0\.178 wx - 0\.15 wz = 0\."):
        fb.inverse_velocity(model, q, np.ones(6))
    J = fb.jacobian(model, q)
    assert np.abs(J[1] - 0.178 * J[3] - 0.15 * J[5]).max() < 2e-3


def test_damping_is_exact_away_from_singularities(two, recwarn):
    q = np.array([[0.3, 0.9], [0.1, -2.0]])
    assert np.allclose(
        fb.inverse_velocity(two, q, [0.1, 0.2], damping=0.01),
        fb.inverse_velocity(two, q, [0.1, 0.2]),
        atol=1e-14,
    )
    assert not recwarn


def test_damping_bounds_the_rates_and_says_so(two):
    off = "gets V but for 1 in vx at sample 1"
    with pytest.warns(FreebodyWarning, match=f"frame 'tip' of 'RR' {off}"):
        found = fb.inverse_velocity(two, [[0.3, 0.9], [0.0, 0.0]], [1.0, 0.5], damping=0.05)
    assert np.isfinite(found).all()
    assert abs(fb.velocity(two, [0.0, 0.0], found[1])[1] - 0.5) < 1e-12  # what is possible is exact
    with pytest.warns(FreebodyWarning, match="damped near a singularity"):
        near = fb.inverse_velocity(two, [0.0, 1e-6], [1.0, 0.0], damping=0.05)
    assert np.abs(near).max() < 1.0 / 0.05
    assert np.abs(fb.inverse_velocity(two, [0.0, 1e-6], [1.0, 0.0])).max() > 1e5


def test_damping_is_continuous(two):
    """No jump where damping sets in, nor at the singularity."""
    theta = np.linspace(-0.3, 0.3, 6001)
    q = np.stack([np.zeros_like(theta), theta], axis=-1)
    with pytest.warns(FreebodyWarning):
        rates = fb.inverse_velocity(two, q, [1.0, 0.0], damping=0.05)
    assert np.abs(np.diff(rates, axis=0)).max() < 0.2


# ---------------------------------------------------------------- refusals
def test_refusals(two):
    iv = fb.inverse_velocity
    refused(
        "inverse_velocity: 2 joint coordinates of 'RR' cannot give frame 'tip' any motion in 3 "
        "rows (vx, vy, w); "
        'choose at most that many rows, such as task="position".',
        lambda: iv(two, [0.1, 0.2], [1, 0, 0]),
        SingularError,
    )
    refused(
        "inverse_velocity: V has shape (4,), expected (..., 3): 2 entries for the position, 3 for "
        "the pose; "
        "else name the rows with task=.",
        lambda: iv(two, [0.1, 0.2], [1, 0, 0, 0]),
    )
    refused(
        "inverse_velocity: V has shape (1,), expected (..., 3): all rows, or 2 entries for vx, vy.",
        lambda: iv(two, [0.1, 0.2], [1], task="position"),
    )
    refused(
        "inverse_velocity: V is nan for 'vy'; every entry must be a finite number.",
        lambda: iv(two, [0.1, 0.2], [1, np.nan]),
    )
    refused(
        "inverse_velocity: damping is 0; it must be positive, such as 0.05, or None.",
        lambda: iv(two, [0.1, 0.2], [1, 0], damping=0),
    )
    refused(
        "inverse_acceleration: qd has shape (3,), expected (..., 2): model 'RR' has nv = 2.",
        lambda: fb.inverse_acceleration(two, [0.1, 0.2], [0, 0, 0], [1, 0]),
    )
    refused(
        "inverse_velocity: the batch shapes do not broadcast together: q (3,), V (2,).",
        lambda: iv(two, np.ones((3, 2)), np.ones((2, 2))),
    )
