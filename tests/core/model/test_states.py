"""Positions as points of a manifold: moving, differences, neutral and random states."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm

import freebody as fb
from freebody import Inertia, Limits, Model
from support import generate
from support.helpers import numbers, poses
from support.robots import Joint, Link, Robot, loaded

pytestmark = pytest.mark.usefixtures("numpy_kernels")

TREES = range(60)
NO_LIMITS = Limits()


def single(kind: str, limits: Limits = NO_LIMITS) -> Model:
    axis = (0.0, 0.0, 1.0) if kind in ("revolute", "prismatic", "continuous") else ()
    links = (Link("world"), Link("body", Inertia.sphere(1.0, 0.1)))
    joints = (Joint("joint", kind, "world", "body", axis=axis, limits=limits),)
    return loaded(Robot(kind, 3, links, joints, (9.81, (0.0, 0.0, -1.0))))


@pytest.mark.sample(3)
@pytest.mark.parametrize("seed", TREES)
def test_integrate_and_difference_undo_each_other(seed: int):
    model = generate.model(seed)
    q0, v, _ = fb.random_state(model, seed, (2, 3))
    q1 = fb.integrate(model, q0, 0.4 * v)
    assert q1.shape == q0.shape
    assert fb.difference(model, q0, q1) == pytest.approx(0.4 * v, abs=1e-12)
    other, _, _ = fb.random_state(model, seed + 1000, (2, 3))
    way = fb.difference(model, q0, other)
    arrived = poses(model, fb.integrate(model, q0, way))
    for name, T in poses(model, other).items():
        assert arrived[name] == pytest.approx(T, abs=1e-11)
    assert fb.difference(model, q0, q0) == pytest.approx(np.zeros_like(v), abs=1e-12)
    assert fb.integrate(model, q0, 0 * v) == pytest.approx(q0, abs=1e-15)
    # in two steps the same as in one, the velocity being constant in the body's axes
    assert poses(model, fb.integrate(model, fb.integrate(model, q0, 0.3 * v), 0.1 * v))[
        "tool"
    ] == pytest.approx(poses(model, q1)["tool"], abs=1e-12)


@pytest.mark.parametrize("size", [0.0, 1e-9, 1e-5, 1.1e-4, 0.3, 2.0, 3.1, 3.14159])
def test_free_joint_moves_along_its_screw(size: float):
    model = single("free")
    rng = np.random.default_rng(1)
    q = fb.random_state(model, 2)[0]
    w = rng.normal(size=3)
    v = np.array([0.3, -0.5, 0.7, *(size * w / np.linalg.norm(w))])
    twist = np.zeros((4, 4))
    twist[:3, :3] = [[0, -v[5], v[4]], [v[5], 0, -v[3]], [-v[4], v[3], 0]]
    twist[:3, 3] = v[:3]
    q1 = fb.integrate(model, q, v)
    assert np.linalg.norm(q1[3:]) == pytest.approx(1.0, abs=1e-15)
    expected = poses(model, q)["body"] @ expm(twist)
    assert poses(model, q1)["body"] == pytest.approx(expected, abs=1e-14)
    assert fb.difference(model, q, q1) == pytest.approx(v, abs=1e-8 if size > 3.1 else 1e-12)


@given(st.integers(0, 2**32), st.floats(0, 3.1))
def test_quaternion_and_its_opposite_are_one_orientation(seed: int, size: float):
    model = single("spherical")
    rng = np.random.default_rng(seed)
    q, _, _ = fb.random_state(model, seed)
    w = rng.normal(size=3)
    w *= size / np.linalg.norm(w)
    q1 = fb.integrate(model, q, w)
    for a, b in ((q, q1), (-q, q1), (q, -q1)):
        assert fb.difference(model, a, b) == pytest.approx(w, abs=1e-9)
    assert numbers(model, "forward_kinematics", q) == pytest.approx(
        numbers(model, "forward_kinematics", -q), abs=1e-15
    )


def test_planar_and_one_axis_joints_add():
    for kind, n in (("planar", 3), ("revolute", 1), ("continuous", 1), ("prismatic", 1)):
        model = single(kind)
        q, v = (
            np.arange(1.0, n + 1),
            np.full(n, 10.0),
        )  # a continuous angle is a number, several turns a larger one
        assert fb.integrate(model, q, v) == pytest.approx(q + v)
        assert fb.difference(model, q, q + v) == pytest.approx(v)


def test_batches_broadcast():
    model = generate.model(4)
    q, v, _ = fb.random_state(model, 1, (3, 1))
    assert (q[:, 0] == fb.random_state(model, 1, np.int64(3))[0]).all()
    assert fb.integrate(model, q, v[0]).shape == (3, 1, model.nq)
    assert fb.integrate(model, q[0, 0], np.zeros((5, model.nv))).shape == (5, model.nq)
    assert fb.difference(model, q, q[0]).shape == (3, 1, model.nv)


def test_arguments_are_not_written_to():
    model = generate.model(4)
    q, v, _ = fb.random_state(model, 1)
    for array in (q, v):
        array.flags.writeable = False
    assert fb.integrate(model, q, v).flags.writeable
    fb.difference(model, q, q)
    fb.inverse_dynamics(model, q, v, v)


# ---------------------------------------------------------------- neutral and random
@pytest.mark.parametrize("seed", range(0, 60, 4))
def test_neutral(seed: int):
    model = generate.model(seed)
    q = fb.neutral(model)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        own = q[list(at.q)]
        if body.kind.nq in (4, 7):
            assert own[-4:].tolist() == [1, 0, 0, 0]
            own = own[:-4]
        assert not own.any()
    # link frames are where their joints' placements put them
    standing = poses(model, q)
    for joint in generate.tree(seed).joints:
        if joint.mimic is None:
            expected = standing[joint.parent] @ joint.placement.matrix()
            assert standing[joint.child] == pytest.approx(expected, abs=1e-13)


@pytest.mark.parametrize("seed", range(0, 60, 3))
def test_random_states(seed: int):
    model = generate.model(seed)
    q, qd, qdd = fb.random_state(model, 5, (4, 7))
    assert (q.shape, qd.shape, qdd.shape) == ((4, 7, model.nq), (4, 7, model.nv), (4, 7, model.nv))
    for again, array in zip(fb.random_state(model, 5, (4, 7)), (q, qd, qdd), strict=True):
        assert np.array_equal(again, array)
    assert not np.array_equal(q, fb.random_state(model, 6, (4, 7))[0])
    assert fb.random_state(model, 5)[0].shape == (model.nq,)
    assert fb.random_state(model, 5, 3)[0].shape == (3, model.nq)
    for body, at in zip(model.bodies, model.coordinates, strict=True):
        own = q[..., list(at.q)]
        if body.joint.mimic:
            continue
        if body.kind.nq in (4, 7):
            assert np.linalg.norm(own[..., -4:], axis=-1) == pytest.approx(np.ones((4, 7)))
        elif body.kind.nq == 1:
            limits = body.joint.limits.meant
            assert (own >= limits.lower).all()
            assert (own <= limits.upper).all()


@pytest.mark.parametrize(
    ("limits", "low", "high"),
    [
        (Limits(), -np.pi, np.pi),
        (Limits(-0.5, 0.25), -0.5, 0.25),
        (Limits(2.0, 2.0), -np.pi, np.pi),
        (Limits(lower=5.0), 5.0, 5.0 + 2 * np.pi),
        (Limits(upper=-5.0), -5.0 - 2 * np.pi, -5.0),
        (Limits(-1e16, 1e16), -np.pi, np.pi),
        (Limits(2000.0, 2001.0), 2000.0, 2001.0),
        (Limits(-3000.0, -2000.0), -3000.0, -2000.0),
    ],
    ids=str,
)
def test_random_positions_fill_the_range(limits: Limits, low: float, high: float):
    q = fb.random_state(single("revolute", limits), 1, 4000)[0]
    assert q.min() >= low
    assert q.max() <= high
    if limits.upper - limits.lower > 1e4:
        return
    reach = high - low
    assert q.min() - low <= 0.01 * reach or limits.lower < -1e3
    assert high - q.max() <= 0.01 * reach or limits.upper > 1e3


def test_random_orientations_are_uniform():
    q = fb.random_state(single("spherical"), 1, 20000)[0]
    R = poses(single("spherical"), q)["body"][:, :3, :3]
    assert np.abs(R.mean(0)).max() < 0.02
    assert (R**2).mean(0) == pytest.approx(np.full((3, 3), 1 / 3), abs=0.02)


@pytest.mark.parametrize("name", ["ur5e", "RP"])
def test_positions_that_add_are_moved_alike_whatever_kind_of_vector_comes(name):
    """Plain arrays take a short way; lists, dicts and batches of other shapes the long one, to the
    same bits."""
    model = fb.load(name)
    q, v, _ = fb.random_state(model, 1, 3)
    expected = q + v
    for a, b in ((q, v), (q.tolist(), v), (q, v.tolist()), (q[:, None], v[:, None])):
        np.testing.assert_array_equal(fb.integrate(model, a, b).reshape(q.shape), expected)
        np.testing.assert_array_equal(fb.difference(model, a, b).reshape(q.shape), v - q)
    by_name = dict(zip(model.position_names, q[0], strict=True))
    np.testing.assert_array_equal(fb.integrate(model, by_name, v[0]), expected[0])
    for bad in (np.nan, np.inf):
        with pytest.raises(fb.FreebodyError, match=model.position_names[0]):
            fb.integrate(model, np.where(np.arange(model.nq) == 0, bad, q[0]), v[0])
    with pytest.raises(fb.FreebodyError, match="has shape"):
        fb.integrate(model, q[0, :-1], v[0, :-1])


def test_positions_of_a_model_without_numbers_move_as_those_of_one_with_them():
    inertia = Inertia.of("m", (0, 0, 0), np.eye(3))
    links = (
        Link("world"),
        Link("body", inertia),
        Link("arm", Inertia.sphere(1.0, 0.1)),
        Link("foot"),
    )
    joints = (
        Joint("base", "free", "world", "body"),
        Joint("hinge", "revolute", "body", "arm", axis=(0.0, 0.0, 1.0)),
        Joint("ball", "spherical", "arm", "foot"),
    )
    symbolic = loaded(Robot("symbolic", 3, links, joints, (9.81, (0.0, 0.0, -1.0))))
    assert symbolic.missing
    bound = symbolic.bind(m=1.0)
    q, v, _ = fb.random_state(bound, 5, 4)
    reached = fb.integrate(symbolic, q, v)
    np.testing.assert_allclose(reached, fb.integrate(bound, q, v), rtol=0, atol=1e-15)
    way = fb.difference(symbolic, q, reached)
    np.testing.assert_allclose(way, fb.difference(bound, q, reached), rtol=0, atol=1e-14)


def test_the_second_quaternion_of_a_difference_is_looked_at_on_every_call():
    model = fb.load("quadrotor")
    q, _, _ = fb.random_state(model, 1)
    off = q * np.where(np.arange(7) < 3, 1.0, 1.001)
    for _ in range(2):
        fb.difference(model, q, q)
        with pytest.raises(fb.FreebodyError, match=r"has length 1\.001"):
            fb.difference(model, q, off)


def test_positions_that_add_are_added_to_the_last_bit():
    model, rng = fb.load("ur5e"), np.random.default_rng(5)
    q, v = rng.normal(size=(2, 7, 6))
    assert fb.integrate(model, q, v).tobytes() == (q + v).tobytes()
    assert fb.difference(model, q, v).tobytes() == (v - q).tobytes()
    assert fb.integrate(model, q[0], v).tobytes() == (q[0] + v).tobytes()
    for k in range(7):
        assert fb.integrate(model, q[k], v[k]).tobytes() == (q[k] + v[k]).tobytes()


def test_neutral_is_the_callers_own():
    model = fb.load("ur5e")
    fb.neutral(model)[0] = 1.0
    assert not fb.neutral(model).any()
