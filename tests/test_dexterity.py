"""Singular values of Jacobians: as LAPACK has them, whatever the rank."""

from __future__ import annotations

import numpy as np
import pytest

import freebody as fb


@pytest.mark.parametrize(
    ("name", "task", "angular"),
    [("ur5e", "pose", 3), ("panda", "position", 0), ("2R", "pose", 1), ("2R", "position", 0)],
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
    ):
        with pytest.raises(fb.FreebodyError, match=words):
            fb.dexterity(arm, [0.1, 0.2], **more)
    with pytest.raises(fb.FreebodyError, match="closed chain"):
        fb.dexterity(fb.load("five_bar"), np.zeros(5))
