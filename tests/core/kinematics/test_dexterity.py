"""Singular values of Jacobians: as LAPACK has them, whatever the rank."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


@pytest.mark.sample(3)
@pytest.mark.parametrize(
    ("name", "task", "angular"),
    [
        ("ur5e", "pose", 3),
        ("panda", "pose", 3),
        ("scara", "pose", 3),
        ("panda", "position", 0),
        ("2R", "pose", 1),
        ("2R", "position", 0),
    ],
)
def test_as_lapack(name, task, angular):
    model = fb.load(name)
    q, _, _ = fb.random_state(model, 1, 200)
    q[:3] = 0.0  # singular
    found = fb.dexterity(model, q, task=task)
    J = fb.jacobian(model, q)
    d = model.dim
    rows = J[:, :d] / found.length
    if task == "pose":
        rows = np.concatenate([rows, J[:, d:]], axis=1)
    expected = np.linalg.svd(rows, compute_uv=False)
    assert found.singular_values.shape == expected.shape
    assert np.abs(found.singular_values - expected).max() < 1e-14 * expected.max() * 10
    assert (found.length == 1.0) is (angular == 0)
    assert np.allclose(found.manipulability, expected.prod(axis=-1), atol=1e-14)
    clear = expected[:, -1] > 1e-3
    expected = expected[clear]
    assert np.allclose(found.condition[clear], expected[:, 0] / expected[:, -1])
    table = found.to_xarray()
    assert (table["singular_values"].values == found.singular_values).all()
    assert table["manipulability"].dims == ("posture",)
    assert table["singular_values"].attrs["units"] == ("1" if angular else "m")
    one = fb.dexterity(model, q[7], task=task)
    assert (one.singular_values == found.singular_values[7]).all()


def next_to_singular(model: fb.Model, batch: int) -> np.ndarray:
    """Postures with joints at all distances from 0, down to what rounding is and to 0 itself."""
    rng = np.random.default_rng(7)
    q = fb.random_state(model, 8, batch)[0]
    near = rng.random(q.shape) < 0.4
    q[near] = 10.0 ** rng.uniform(-17.0, 0.0, near.sum())
    q[:: batch // 8][rng.random((len(q[:: batch // 8]), q.shape[1])) < 0.5] = 0.0
    return q


@pytest.mark.sample(2)
@pytest.mark.parametrize(
    ("name", "task"),
    [
        ("ur5e", "pose"),
        ("iiwa14", "pose"),
        ("puma560", ("vx", "vy", "vz", "wx", "wz")),
        ("stanford", ("vx", "vy", "wx", "wy")),
        ("ur5e", "orientation"),
        ("scara", "orientation"),
        ("panda", "position"),
        ("polar_arm", ("vx", "vz")),
        ("3R", "position"),
        ("3R", "w"),
    ],
)
@pytest.mark.filterwarnings("ignore::freebody.PhysicalWarning")
def test_next_to_singular_postures_as_lapack(name, task):
    """Singular values to rounding of the largest, axes that give J Jᵀ back; each posture's to the
    last bit whatever stands beside it."""
    model = fb.load(name)
    q = next_to_singular(model, 400)
    found = fb.dexterity(model, q, task=task)
    names = ("vx", "vy", "vz", "wx", "wy", "wz") if model.dim == 3 else ("vx", "vy", "w")
    J = fb.jacobian(model, q)[:, [names.index(x) for x in found.rows]]
    linear = np.array([x.startswith("v") for x in found.rows])
    A = J / np.where(linear, found.length, 1.0)[:, None]
    expected = np.linalg.svd(A, compute_uv=False)
    largest = expected.max()
    assert np.abs(found.singular_values - expected).max() < 1e-14 * largest
    assert (np.diff(found.singular_values, axis=-1) <= 0.0).all()
    alone = [fb.dexterity(model, x, task=task).singular_values for x in q]
    assert (alone == found.singular_values).all()
    if linear.any() and not linear.all():
        return
    axes = fb.ellipsoids(model, q, task=task)
    ways, sizes = axes.directions, axes.singular_values
    alone = [fb.ellipsoids(model, x, task=task) for x in q]
    assert all((x.directions == y).all() for x, y in zip(alone, ways, strict=True))
    assert all((x.singular_values == y).all() for x, y in zip(alone, sizes, strict=True))
    turned = np.swapaxes(ways, -1, -2)
    assert np.abs(ways @ turned - np.eye(len(found.rows))).max() < 1e-14
    square = turned @ (sizes[..., None] ** 2 * ways)
    assert np.abs(square - A @ np.swapaxes(A, -1, -2)).max() < 1e-14 * largest**2
    k = expected.shape[-1]
    assert np.abs(sizes[:, :k] - expected).max() < 1e-12 * largest
    kept = expected > 1e-11 * expected[:, :1]
    assert (sizes[:, :k][kept] > 0.0).all()
    assert not sizes[:, :k][expected < 1e-13 * expected[:, :1]].any()
    assert not sizes[:, k:].any()
    U = np.swapaxes(np.linalg.svd(A)[0], -1, -2)
    squares = np.zeros(sizes.shape)
    squares[:, :k] = expected**2
    apart = np.abs(squares[:, :, None] - squares[:, None]) + 1e9 * np.eye(len(found.rows))
    clear = apart.min(axis=-1) > 1e-3 * squares[:, :1]
    assert clear.any() or name == "scara"
    assert np.abs(np.abs(np.sum(U * ways, axis=-1)) - 1.0)[clear].max(initial=0.0) < 1e-11
    large = np.abs(ways) > (0.5 + 1e-9) * np.abs(ways).max(axis=-1, keepdims=True)
    at = np.argmax(large, axis=-1)[..., None]
    first = np.take_along_axis(ways, at, axis=-1)[..., 0]
    halves = np.abs(np.abs(ways) / np.abs(ways).max(axis=-1, keepdims=True) - 0.5) < 1e-9
    assert (first > 0.0)[~halves.any(axis=-1)].all()


def test_what_no_kernel_can_square_is_looked_at_alone():
    """A slide at 1e200 m among postures of metres; and rows of equal length, and none at all."""
    arm = fb.planar("RPR", l=[0.4] * 3, lc=[0.2] * 3, m=[1.0] * 3, I=[0.1] * 3)
    q = fb.random_state(arm, 2, 6)[0]
    plain = fb.dexterity(arm, q, task="position"), fb.ellipsoids(arm, q)
    q[4, 1] = 1e200
    far = fb.dexterity(arm, q, task="position"), fb.ellipsoids(arm, q)
    others = np.arange(6) != 4
    for one, other in zip(plain, far, strict=True):
        assert (one.singular_values == other.singular_values)[others].all()
        assert other.singular_values[4, 0] == pytest.approx(1e200)
    slides = fb.planar("PP", l=[1.0] * 2, lc=[0.5] * 2, m=[1.0] * 2, I=[0.1] * 2)
    assert (fb.ellipsoids(slides, [0.1, 0.2]).directions == np.eye(2)).all()
    still = fb.ellipsoids(slides, [0.1, 0.2], task="orientation")
    assert still.singular_values.tolist() == [0.0]
    assert still.directions.tolist() == [[1.0]]
    for batch in ((0,), (2, 0)):
        assert fb.dexterity(slides, np.zeros((*batch, 2))).singular_values.shape == (*batch, 2)
        assert fb.ellipsoids(slides, np.zeros((*batch, 2))).directions.shape == (*batch, 2, 2)


def test_lengths_that_compare():
    """Of one kernel, whatever a radian is worth."""
    model = fb.load("ur5e")
    q = fb.random_state(model, 5, 10)[0]
    for length in (None, 0.1, 2.0, 3):
        found = fb.dexterity(model, q.tolist(), length=length)
        J = fb.jacobian(model, q)
        J[:, :3] /= found.length
        expected = np.linalg.svd(J, compute_uv=False)
        assert np.abs(found.singular_values - expected).max() < 1e-14 * expected.max()
        assert found.length == (length or pytest.approx(1.3, abs=0.5))


def test_the_two_link_arm_by_hand():
    """l1 l2 |sin θ2|, the determinant of (2.19); no direction at a straight arm."""
    model = fb.load("2R")
    l1, l2 = (fb.parameters(model)[n].value for n in ("l1", "l2"))
    q = np.array([[0.3, 1.1], [0.3, 0.0]])
    found = fb.dexterity(model, q, task="position")
    assert np.allclose(found.manipulability, l1 * l2 * np.abs(np.sin(q[:, 1])), atol=1e-15)
    assert found.condition[1] > 1e15
    assert found.smallest[1] < 1e-16
    assert "2 postures of frame 'tip', rows vx, vy" in repr(found)


def test_refusals():
    arm = fb.load("2R")
    for words, more in (
        ("length is -1", {"length": -1.0}),
        ("rows of one kind", {"task": "position", "length": 1.0}),
        ("no task 'pos'", {"task": "pos"}),
        (r"1 / length reaches \S+; the result overflows", {"length": 1e-310}),
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            fb.dexterity(arm, [0.1, 0.2], **more)
    with pytest.raises(fb.FreebodyError, match="closed chain"):
        fb.dexterity(fb.load("five_bar"), np.zeros(5))
